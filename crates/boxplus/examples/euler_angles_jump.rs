//! My Euler angles jump. Is my data broken?
//!
//! A drone pulls up through the vertical, two degrees per frame, wings level. Its motion is as smooth as can be; its yaw and roll are not.
#![expect(clippy::print_stdout, reason = "an example talks")]

use boxplus::lie::{EulerSequence, GimbalLock, SO3};
use nalgebra::Vector3;

fn main() {
    println!("frame  yaw    pitch  roll   from lock  turned  rotation vector (followed)");
    let mut before = attitude(0);
    let mut followed = Vector3::zeros();
    for frame in 0..=8 {
        let world_from_body = attitude(frame);
        let euler = world_from_body.to_euler(EulerSequence::ZYX);
        let [yaw, pitch, roll] = euler.angles.map(f64::to_degrees);
        // The step of the rotation itself: this is what a filter or a controller should look at.
        let turned = before.angle_to(&world_from_body).to_degrees();
        followed = world_from_body.log_near(&followed);
        let [x, y, z] = followed.map(f64::to_degrees).into();
        print!("{frame:5} {yaw:6.1} {pitch:6.1} {roll:6.1} {:8.1}° ", euler.margin().to_degrees());
        print!("{turned:7.1}°  ({x:6.1}, {y:6.1}, {z:6.1})");
        match euler.lock {
            Some(GimbalLock::Sum(sum)) => println!("  locked: only yaw + roll = {:.1}°", sum.to_degrees()),
            Some(GimbalLock::Difference(difference)) => {
                println!("  locked: only yaw − roll = {:.1}°", difference.to_degrees());
            }
            None => println!(),
        }
        before = world_from_body;
    }

    println!(
        "\nNothing is broken: at a pitch of ±90° yaw and roll turn about one axis, and beyond it the same attitude"
    );
    println!(
        "is written from the other side. Compute with rotations; print angles last. Where this motion is usual,"
    );
    println!("choose a sequence that locks elsewhere:");
    for sequence in [EulerSequence::ZYX, EulerSequence::ZXY] {
        let angles = |frame| attitude(frame).to_euler(sequence).angles.map(|a| a.to_degrees().round());
        println!("  {sequence}: {:?} → {:?}", angles(3), angles(5));
    }
}

/// Heading 30° to the left, nose up by 82° + 2° per frame. With y to the left, up is a negative turn.
fn attitude(frame: u32) -> SO3 {
    SO3::about_z(30_f64.to_radians()) * SO3::about_y(-(82.0 + 2.0 * f64::from(frame)).to_radians())
}
