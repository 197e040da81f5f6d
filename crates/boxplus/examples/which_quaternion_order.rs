//! Four numbers in a file: is it x, y, z, w or w, x, y, z? Hamilton or JPL?
//!
//! Nothing in the numbers says so: every reading is a valid rotation. A measurement does. Here a robot stands still, so that its
//! accelerometer shows which way is up in the body.
#![expect(clippy::print_stdout, reason = "an example talks")]

use boxplus::lie::{LieError, SO3};
use nalgebra::Vector3;

fn main() -> Result<(), LieError> {
    let in_the_file = [0.9238795, 0.2209424, 0.2209424, 0.2209424];
    let specific_force = Vector3::new(-3.04, 4.96, 7.90); // m/s², in the body
    let up_world = Vector3::z();

    println!("reading            turns by   about                    up is off by");
    for (name, world_from_body) in readings(in_the_file)? {
        let (axis, angle) = world_from_body.to_axis_angle();
        let up = world_from_body * specific_force;
        let off = SO3::between_directions(&up, &up_world)?.to_axis_angle().1;
        println!(
            "{name:18} {:6.1}°   ({:5.2}, {:5.2}, {:5.2})   {:10.1}°",
            angle.to_degrees(),
            axis.x,
            axis.y,
            axis.z,
            off.to_degrees()
        );
    }
    println!(
        "\nThe reading under which the measured up is up is the one. (Turns about the vertical cannot be told apart"
    );
    println!("by gravity: check a second direction, too.) Going out, say it again by name:");
    let r = SO3::from_wxyz(in_the_file)?;
    println!("  quaternion_xyzw     {:.3?}   nalgebra, Eigen in memory, ROS, SciPy", r.quaternion_xyzw());
    println!("  quaternion_wxyz     {:.3?}   Eigen's constructor, Ceres, MuJoCo", r.quaternion_wxyz());
    println!("  quaternion_jpl_xyzw {:.3?}   MSCKF, NASA: the opposite vector", r.quaternion_jpl_xyzw());
    Ok(())
}

/// The same four numbers, read in every way.
fn readings(q: [f64; 4]) -> Result<[(&'static str, SO3); 4], LieError> {
    let [w, x, y, z] = q;
    Ok([
        ("xyzw, Hamilton", SO3::from_xyzw(q)?),
        ("wxyz, Hamilton", SO3::from_wxyz(q)?),
        ("xyzw, JPL", SO3::from_jpl_xyzw(q)?),
        ("wxyz, JPL", SO3::from_jpl_xyzw([x, y, z, w])?),
    ])
}
