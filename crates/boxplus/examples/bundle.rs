//! My state is more than a pose.
//!
//! A rover has a pose, a gyroscope bias and a wheel radius. Made a bundle, they are one group: one step, one difference, one
//! covariance, whose blocks have names.
#![expect(clippy::print_stdout, reason = "an example talks")]

use boxplus::lie::{LieGroup, R3xSO3, Rn, SE3};
use nalgebra::{SMatrix, Vector3, Vector6};

boxplus::bundle! {
    /// What a rover has to know of itself.
    struct Rover {
        /// world_from_rover.
        pose: SE3 [6],
        /// What the gyroscope shows at rest, in rad/s.
        bias: Rn<3> [3],
        /// Logarithm of the wheel radius in metres: moved freely, never negative.
        wheel: Rn<1> [1],
    }
}

fn main() {
    let start = Rover {
        bias: Rn::new(Vector3::new(0.01, 0.0, -0.02)),
        wheel: Rn::new([0.1_f64.ln()].into()),
        ..Rover::default()
    };

    // A correction, as an estimator computes it: ten numbers, in the order of the fields.
    let ahead_turning_left = Vector6::new(1.0, 0.0, 0.0, 0.0, 0.0, 0.5);
    let correction = Rover::BLOCKS.pose.embed(&ahead_turning_left)
        + Rover::BLOCKS.bias.embed(&Vector3::new(0.0, 0.005, 0.0));
    let end = start.rplus(&correction);
    println!("{end:.3}");

    // The way back, and how it depends on both ends: one call for all blocks.
    let (tau, d_tau_d_end, _) = end.rminus_jac(&start);
    println!("differs by {:.1e} from the correction", (tau - correction).amax());

    // What is known of the pose when bias and wheel are unknown, and how the pose hangs together with the bias.
    let covariance = d_tau_d_end * SMatrix::<f64, 10, 10>::identity() * d_tau_d_end.transpose() * 1e-4;
    let of_pose = Rover::BLOCKS.pose.marginal(&covariance);
    let with_bias = Rover::BLOCKS.pose.cross(&Rover::BLOCKS.bias, &covariance);
    println!(
        "σ of the heading {:.4} rad, correlation with the bias {}",
        of_pose[(5, 5)].sqrt(),
        with_bias.amax()
    );

    // A bundle does not couple, not even translation and rotation: ⟨ℝ³, SO(3)⟩ goes straight where SE(3) drives an arc.
    let (arc, straight) = (SE3::exp(&ahead_turning_left), R3xSO3::exp(&ahead_turning_left));
    println!("SE(3)       arrives at {:.3?}", arc.translation().as_slice());
    println!("⟨ℝ³, SO(3)⟩ arrives at {:.3?}", straight.translation().as_slice());
}
