//! I have a few poses and want a smooth path. Which curve?
//!
//! Five poses of a drone and the times at which it shall be there. `CatmullRom` passes through all of them with continuous
//! velocity; a cubic `BSpline` over the same poses only passes near, but its acceleration is continuous, too.
#![expect(clippy::print_stdout, reason = "an example talks")]

use boxplus::lie::{LieGroup, SE3, SO3};
use boxplus::trajectory::{BSpline, CatmullRom, Motion, PointMotion, TrajectoryError};
use nalgebra::{Vector3, vector};

fn main() -> Result<(), TrajectoryError> {
    let pose =
        |x: f64, y: f64, z: f64, yaw: f64| SE3::new(SO3::exp(&vector![0.0, 0.0, yaw]), vector![x, y, z]);
    let poses = [
        pose(0.0, 0.0, 0.0, 0.0),
        pose(2.0, 0.0, 1.0, 0.3),
        pose(3.5, 1.5, 1.5, 1.2),
        pose(3.5, 3.5, 1.0, 1.6),
        pose(3.0, 5.0, 0.0, 1.6),
    ];
    let times = [0.0, 1.0, 2.0, 3.0, 4.0];

    let through = CatmullRom::new(&poses, &times)?;
    println!("through the poses (continuous velocity)");
    for i in 0..=8 {
        print(f64::from(i) * 0.5, &through.at(f64::from(i) * 0.5)?);
    }

    // A cubic spline starts near its second control element; doubled ends bring it closer to the first and the last.
    let controls = [poses[0], poses[0], poses[1], poses[2], poses[3], poses[4], poses[4]];
    let near = BSpline::<_, 6, 4>::new(&controls, 0.0, 1.0)?;
    println!("near the poses (continuous acceleration)");
    for i in 0..=8 {
        print(f64::from(i) * 0.5, &near.at(f64::from(i) * 0.5)?);
    }

    // Half a turn between two poses: clockwise or counter-clockwise?
    let unclear = [poses[0], pose(1.0, 0.0, 0.0, std::f64::consts::PI)];
    if let Err(error) = CatmullRom::new(&unclear, &times[..2]) {
        println!("refused: {error}");
    }
    Ok(())
}

/// Position, speed and acceleration of the drone's origin in the world, from rates in its own frame.
fn print(t: f64, motion: &Motion<SE3, 6>) {
    let origin = motion.act(&PointMotion::fixed(Vector3::zeros()));
    let (p, yaw_rate_deg) = (origin.position, motion.velocity[5].to_degrees());
    println!(
        "  t = {t:.1} s   x y z = {:5.2} {:5.2} {:5.2} m   {:4.2} m/s   {yaw_rate_deg:5.1} °/s   {:4.2} m/s²",
        p.x,
        p.y,
        p.z,
        origin.velocity.norm(),
        origin.acceleration.norm()
    );
}
