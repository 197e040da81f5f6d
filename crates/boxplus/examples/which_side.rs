//! Which side is my perturbation?
//!
//! A pose can be moved in its own frame, X·Exp(τ), or in the world's, Exp(τ)·X. A covariance, a Jacobian, an innovation belongs to
//! one of the two, and the numbers do not say to which. Three questions settle it.
#![expect(clippy::print_stdout, reason = "an example talks")]

use boxplus::lie::{LeftJacobians, LieGroup, SE3, SO3, orders};
use nalgebra::{Matrix6, Vector3, Vector6};
use std::f64::consts::FRAC_PI_2;

fn main() {
    // 10 m east of the origin, facing north.
    let facing_north = SO3::exp(&Vector3::new(0.0, 0.0, FRAC_PI_2));
    let world_from_body = SE3::new(facing_north, Vector3::new(10.0, 0.0, 0.0));

    // 1. Where does a step along x lead? Right (local): ahead, which is north. Left (global): east.
    let along_x = Vector6::new(1.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    println!("right, X·Exp(τ): {:.1}", world_from_body.rplus(&along_x));
    println!("left,  Exp(τ)·X: {:.1}", world_from_body.lplus(&along_x));

    // 2. Where does a small turn lead? Right: on the spot. Left: around the origin of the world, 10 m away.
    let turn = Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.1);
    println!(
        "a right turn moves the body by {:.2} m",
        moved(&world_from_body, &world_from_body.rplus(&turn))
    );
    println!("a left turn moves the body by {:.2} m", moved(&world_from_body, &world_from_body.lplus(&turn)));

    // 3. Whose covariance is it? An unsure heading on the right is an unsure place as well on the left: it is the same uncertainty.
    let unsure_heading = Matrix6::from_diagonal(&Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.01));
    let left = world_from_body.covariance_to_left(&unsure_heading);
    println!(
        "σ_y: {:.2} m on the right, {:.2} m on the left",
        unsure_heading[(1, 1)].sqrt(),
        left[(1, 1)].sqrt()
    );

    // Jacobians: the operation says its side. `_jac` is right, `_left_jac` is left, and they differ by adjoints only.
    let (inverse, d_right) = world_from_body.inverse_jac();
    let (_, d_left) = world_from_body.inverse_left_jac();
    let converted = inverse.output_to_left(&world_from_body.input_to_left(&d_right));
    println!("left Jacobian of the inverse, converted: differs by {:.0e}", (d_left - converted).amax());

    // Another library may also order the coordinates differently: GTSAM has the rotation first (and perturbs on the right).
    let for_gtsam = orders::gtsam::POSE3.matrix_to_theirs(&unsure_heading);
    println!("GTSAM has the heading's variance at [2][2]: {}", for_gtsam[(2, 2)]);
}

/// How far the origin of the body went.
fn moved(before: &SE3, after: &SE3) -> f64 {
    (after.translation() - before.translation()).norm()
}
