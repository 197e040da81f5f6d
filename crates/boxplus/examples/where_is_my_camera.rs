//! Where is my camera, and in which frame is this number?
//!
//! Call every transform by what it maps, `parent_from_child`, every point by its frame, and neighbours cancel: a product whose names do
//! not cancel is wrong before it runs.
#![expect(clippy::print_stdout, reason = "an example talks")]

use boxplus::lie::{Action, LieGroup, SE3, SO3};
use nalgebra::Vector3;
use std::f64::consts::FRAC_PI_2;

fn main() {
    // A car 20 m east of the origin, facing north; its camera 1.2 m up and looking ahead: z ahead, x to the right, y down.
    let world_from_car = SE3::new(SO3::about_z(FRAC_PI_2), Vector3::new(20.0, 0.0, 0.0));
    let lens = SO3::about_z(-FRAC_PI_2) * SO3::about_x(-FRAC_PI_2);
    let car_from_camera = SE3::new(lens, Vector3::new(0.5, 0.0, 1.2));
    let world_from_camera = world_from_car * car_from_camera;
    println!("the camera is at {:.2?}", world_from_camera.translation().as_slice());

    // What the camera sees 10 m ahead and 1 m to the right, in the world: north of the car, and to its east.
    let p_camera = Vector3::new(1.0, 0.0, 10.0);
    let p_world = world_from_camera * p_camera;
    println!("the sight is at  {:.2?}", p_world.as_slice());

    // A direction is no point: it turns, and is not moved. As a homogeneous point, it ends in 0.
    let ahead = Vector3::z();
    let direction = Action::<6, 3>::act_direction(&world_from_camera, &ahead);
    let homogeneous = world_from_camera.act(&ahead.push(0.0));
    println!("looking along    {:.2?} = {:.2?}", direction.as_slice(), homogeneous.as_slice());

    // Back again. The inverse of a pose has another translation, not just the other sign.
    let camera_from_world = world_from_camera.inverse();
    println!("seen again at    {:.2?}", (camera_from_world * p_world).as_slice());
    println!("the world's origin, seen from the camera: {:.2?}", camera_from_world.translation().as_slice());

    // A moment later: how did the camera move? Seen from itself, X⁻¹·Y; the car's motion, seen from the camera, is the same step carried
    // over by the mounting: camera⁻¹·step·camera.
    let later = world_from_car * SE3::exp(&[2.0, 0.0, 0.0, 0.0, 0.0, 0.3].into());
    let car_step = world_from_car.between(&later);
    let camera_step = world_from_camera.between(&(later * car_from_camera));
    let carried = car_from_camera.inverse() * car_step * car_from_camera;
    println!("the camera moved {camera_step:.3}");
    println!("carried over:    {carried:.3}");
    // In the tangent this is Ad, which takes speeds from the car's frame to the camera's.
    let twist = car_from_camera.inverse().adjoint_times(&car_step.log());
    println!("by its tangent:  {:.3}", SE3::exp(&twist));
}
