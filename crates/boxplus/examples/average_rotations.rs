//! How do I average rotations? Not number by number.
//!
//! Three readings of one attitude, within 10° of each other, averaged in several ways.
#![allow(clippy::print_stdout, reason = "an example prints")]

use boxplus::lie::{ChordalMean, EulerSequence, LieError, LieGroup, Means, SO3, Weights};
use nalgebra::{Vector3, Vector4};

fn main() -> Result<(), LieError> {
    // Nearly upside down: heading and roll are next to ±180°, where angles wrap and quaternions change sign.
    let truth = SO3::exp(&Vector3::new(0.0, 0.1, 3.1));
    let errors = [[0.10, 0.02, 0.05], [-0.08, 0.03, 0.06], [-0.02, -0.05, -0.11]];
    let readings = errors.map(|e| truth.rplus(&Vector3::from(e)));

    let off = |x: &SO3| x.angle_to(&truth).to_degrees();
    println!("off by (degrees)");
    println!("{:8.3}  mean of the Euler angles", off(&euler_angles(&readings)?));
    println!("{:8.3}  mean of the quaternions", off(&quaternions(&readings)?));
    println!("{:8.3}  chordal mean", off(&SO3::chordal_mean(&readings, Weights::Equal)?));
    let mean = SO3::mean(&readings, Weights::Equal)?;
    let sure = mean.covariance.map_or(f64::NAN, |c| c.trace().sqrt().to_degrees());
    println!("{:8.3}  mean, after {} steps, sure to {sure:.1}", off(&mean.value), mean.iterations);

    // One sensor fails: it reports the identity.
    let with_outlier = [readings[0], readings[1], readings[2], SO3::identity()];
    let median = SO3::median(&with_outlier, Weights::Equal, &Vector3::repeat(1.0))?;
    println!("{:8.3}  median, with a reading that is wrong by 178°", off(&median.value));
    match SO3::mean(&with_outlier, Weights::Equal) {
        Ok(mean) => println!("{:8.3}  mean of the same", off(&mean.value)),
        Err(error) => println!("          mean of the same: {error}"),
    }
    Ok(())
}

/// The wrong way: yaw of +179° and −179° average to 0.
fn euler_angles(readings: &[SO3]) -> Result<SO3, LieError> {
    let zyx: EulerSequence = "ZYX".parse()?;
    let sum = readings.iter().fold(Vector3::zeros(), |sum, x| sum + Vector3::from(x.to_euler(zyx).angles));
    Ok(SO3::from_euler(zyx, (sum / readings.len() as f64).into()))
}

/// Wrong as well: q and −q are one rotation, and cancel.
fn quaternions(readings: &[SO3]) -> Result<SO3, LieError> {
    // As a driver hands them out that keeps the first component positive, a usual convention.
    let driver = |x: &SO3| {
        let q = Vector4::from(x.quaternion_xyzw());
        if q.x < 0.0 { -q } else { q }
    };
    let sum: Vector4<f64> = readings.iter().map(driver).sum();
    SO3::from_xyzw(sum.normalize().into())
}
