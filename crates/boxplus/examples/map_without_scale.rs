//! My map has no scale: how do I put it onto the ground?
//!
//! A single camera cannot tell a small room from a large one. Its map is right but for a similarity, Sim(3): a rotation, a translation
//! and a scale, which a few known points settle. A rigid motion cannot.
#![expect(clippy::print_stdout, reason = "an example talks")]

use boxplus::lie::{Action, LieGroup, SE3, SO3, Sim3};
use boxplus::registration::{Noise, Pairs, RegistrationError};
use nalgebra::Vector3;

fn main() -> Result<(), RegistrationError> {
    // Five places on the ground in metres, and where the map has them: in units of its own, 1 to 3.7 m, and with small errors.
    let ground = [[0.0, 0.0, 0.0], [12.0, 1.0, 0.2], [14.0, 9.0, 0.5], [3.0, 11.0, 2.0], [-2.0, 5.0, 4.0]];
    let ground = ground.map(Vector3::from);
    let turn = SO3::exp(&Vector3::new(0.4, -0.2, 2.5));
    let map_from_ground = Sim3::new(turn, Vector3::new(1.0, -0.5, 0.3), -(3.7_f64.ln()));
    let errors = [[1.0, -2.0, 0.5], [-0.5, 1.0, 1.0], [2.0, 0.5, -1.0], [-1.5, -1.0, 0.0], [0.0, 1.5, -0.5]];
    let map: Vec<_> =
        (0..5).map(|i| map_from_ground * ground[i] + Vector3::from(errors[i]) * 0.004).collect();

    let pairs = Pairs::new(&map, &ground)?;
    let rigid = pairs.align::<SE3, 6>()?;
    let similar = pairs.align::<Sim3, 7>()?;
    println!("a rigid motion leaves {:.2} m, a similarity {:.3} m", rigid.rms, similar.rms);

    let ground_from_map = similar.target_from_source;
    let fit = pairs.uncertain(&ground_from_map, Noise::Estimated)?;
    // The last coordinate of the tangent is ln s, so its deviation is relative: percents of the scale.
    let percent = 100.0 * fit.sigmas()[6];
    println!("1 unit of the map is {:.3} m, to {percent:.1} %", ground_from_map.scale());

    // A pose of the map goes to the ground as a pose: rotations are turned, positions moved and scaled, and nothing is stretched.
    let map_from_camera = SE3::new(SO3::about_z(0.2), Vector3::new(0.5, 1.0, 0.1));
    let scaled = ground_from_map * Sim3::from_pose(&map_from_camera);
    let ground_from_camera = SE3::new(scaled.rotation(), scaled.translation());
    println!("the camera is at {:.2?} m", ground_from_camera.translation().as_slice());

    // Halfway between two scales is their geometric mean, for ln s is what is halved: from 1 to 4 by way of 2.
    let halfway =
        Sim3::<f64>::identity().interpolate(&Sim3::new(SO3::identity(), Vector3::zeros(), 4.0_f64.ln()), 0.5);
    println!("halfway between the scales 1 and 4: {:.1}", halfway.scale());

    // What has a direction only, such as a ray of the camera, ends in 0: it is scaled and turned, and not moved.
    let ray = ground_from_map.act(&Vector3::z().push(0.0));
    println!("a ray of length 1 in the map is {:.2} m long on the ground", ray.norm());
    Ok(())
}
