//! My rotation vector jumps by a whole turn, and my quaternion changes its sign. Is my data broken?
//!
//! A turntable turns by 50° per frame. Its attitude is an element of SO(3), which knows no jump; the numbers written for it do.
#![expect(clippy::print_stdout, reason = "an example talks")]

use boxplus::lie::{LieError, LieGroup, LogNear, S3, SE3, SO3};
use nalgebra::{Vector3, Vector6};

fn main() -> Result<(), LieError> {
    let axis = Vector3::new(0.0, 0.6, 0.8);
    let mut followed = Vector3::zeros();
    let mut lifted = S3::identity();
    println!("frame  angle of log  followed  q.w written  q.w followed");
    for frame in 0..=9 {
        // From a matrix, as a tracker delivers it: nothing is left of how the turntable got there.
        let measured = SO3::exp(&(axis * (50_f64.to_radians() * f64::from(frame))));
        let attitude = SO3::from_matrix(&measured.to_matrix())?;
        // The shortest rotation vector ends at 180°; of all others that are right this is the one nearest to the last frame's.
        followed = attitude.log_near(&followed);
        lifted = lifted.lift_near(&attitude);
        println!(
            "{frame:5} {:11.0}° {:8.0}° {:12.3} {:13.3}",
            attitude.log().dot(&axis).to_degrees(),
            followed.dot(&axis).to_degrees(),
            attitude.quaternion_xyzw()[3],
            lifted.quaternion_xyzw()[3],
        );
    }

    println!("\nNothing is broken: 200° about an axis and −160° are one rotation, and so are q and −q.");
    println!("Differences of rotation vectors jump, differences of rotations do not:");
    let [a, b] = [170.0_f64, 190.0].map(|degrees| SO3::exp(&(axis * degrees.to_radians())));
    println!("  log(b) − log(a): {:6.1}°", (b.log() - a.log()).norm().to_degrees());
    println!("  b ⊟ a:           {:6.1}°", b.rminus(&a).norm().to_degrees());

    // On poses as well, where the translation part changes with the turn that is chosen.
    let drive = Vector6::new(1.0, 0.0, 0.0, 0.0, 0.0, 0.7);
    let after_five = (0..5).fold(SE3::identity(), |x, _| x.rplus(&drive));
    println!("\nfive steps of a circle: log   {:.2?}", after_five.log().as_slice());
    println!("                   followed   {:.2?}", after_five.log_near(&(drive * 4.8))?.as_slice());
    Ok(())
}
