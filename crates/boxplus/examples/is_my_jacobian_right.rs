//! Is my Jacobian right? And if it is not: a sign, a transpose, or the other side?
//!
//! A lidar on a vehicle sees a landmark at (X·L)⁻¹·p. Dual numbers carry the exact derivative through the same code; what was
//! derived by hand is held against it, and against its usual mistakes.
#![expect(clippy::print_stdout, reason = "an example talks")]

use boxplus::lie::{Action, LeftJacobians, LieGroup, Real, SE3, SO3};
use nalgebra::{Const, Matrix3, Matrix3x6, Vector3, Vector6};
use num_dual::DualSVec64;

/// Six numbers with their derivatives by a local step of the pose.
type Dual = DualSVec64<6>;

/// What is predicted: the landmark in the frame of the lidar. Generic in the scalar, so that dual numbers pass.
fn predicted<S: Real>(
    world_from_body: &SE3<S>,
    body_from_lidar: &SE3,
    landmark: &Vector3<f64>,
) -> Vector3<S> {
    let world_from_lidar = world_from_body.compose(&body_from_lidar.map(S::lit));
    world_from_lidar.act_inverse(&landmark.map(S::lit))
}

fn main() {
    let world_from_body = SE3::exp(&Vector6::new(1.0, -2.0, 0.5, 0.3, -0.2, 0.9));
    let body_from_lidar = SE3::new(SO3::about_z(0.4), Vector3::new(0.2, 0.0, 1.1));
    let landmark = Vector3::new(6.0, 3.0, 1.0);

    // The derivative itself: perturb by X·Exp(u) at u = 0, the convention of every unmarked Jacobian here.
    let u = Vector6::from_fn(|i, _| Dual::from_re(0.0).derivative(i));
    let moved = world_from_body.map(Dual::from_re).rplus(&u);
    let rows =
        predicted(&moved, &body_from_lidar, &landmark).map(|d| d.eps.unwrap_generic(Const::<6>, Const::<1>));
    let exact = Matrix3x6::from_fn(|i, j| rows[i][j]);

    // By hand, with q the landmark in the body: ∂q/∂u = [−I, q^], turned into the lidar's frame.
    let q = world_from_body.act_inverse(&landmark);
    let turn = body_from_lidar.rotation().inverse().to_matrix();
    let of_body = |sign: f64| {
        let mut j = Matrix3x6::zeros();
        j.fixed_view_mut::<3, 3>(0, 0).copy_from(&-Matrix3::identity());
        j.fixed_view_mut::<3, 3>(0, 3).copy_from(&(SO3::hat(&q) * sign));
        j
    };
    let by_hand = turn * of_body(1.0);

    let report = |what: &str, j: &Matrix3x6<f64>| println!("{what:34} differs by {:.0e}", (j - exact).amax());
    report("by hand", &by_hand);
    report("the sign of q^ wrong", &(turn * of_body(-1.0)));
    report("the lidar's rotation transposed", &(turn.transpose() * of_body(1.0)));
    report("on the left side, Exp(u)·X", &world_from_body.input_to_left(&by_hand));
    report("rotation before translation", &Matrix3x6::from_fn(|i, j| by_hand[(i, (j + 3) % 6)]));

    // Where no dual number comes through (a measurement in a black box), a central difference along each step does, to half of the
    // digits. It must move the pose by rplus, too: adding to its seven numbers leaves the group.
    let h = 1e-5;
    let difference = Matrix3x6::from_fn(|i, j| {
        let at = |s: f64| {
            let step = Vector6::from_fn(|k, _| if k == j { s } else { 0.0 });
            predicted(&world_from_body.rplus(&step), &body_from_lidar, &landmark)
        };
        (at(h) - at(-h))[i] / (2.0 * h)
    });
    report("central differences", &difference);
}
