//! Distances between things that stand somewhere.

use nalgebra::{SVector, vector};

use crate::graph::{Factor, JacobianBlock, Located};
use crate::lie::Real;

/// Distance measured between the positions of two variables, poses or points, in ℝᴺ: pose to beacon, pose to pose.
///
/// ```text
/// r = ‖p₂ − p₁‖ − z      u = (p₂ − p₁)/‖p₂ − p₁‖
/// ∂r/∂X₁ = −uᵀ·∂p₁/∂X₁      ∂r/∂X₂ = uᵀ·∂p₂/∂X₂      1×D each, local side
/// ```
///
/// Where both positions coincide the distance has no derivative; zero is returned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range<A, B, const N: usize> {
    /// z, in metres.
    pub measured: f64,
    between: core::marker::PhantomData<fn() -> (A, B)>,
}

impl<A, B, const N: usize> Range<A, B, N> {
    /// The distance `measured`, in metres.
    pub fn new(measured: f64) -> Self {
        Self { measured, between: core::marker::PhantomData }
    }
}

impl<A: Located<N>, B: Located<N>, const N: usize> Factor<1> for Range<A, B, N> {
    const NAME: &'static str = "range";
    const RELATIVE: bool = true;
    type Variables = (A, B);

    fn residual<S: Real>(&self, (a, b): &(A::Over<S>, B::Over<S>)) -> SVector<S, 1> {
        vector![(B::position(b) - A::position(a)).norm() - S::lit(self.measured)]
    }

    fn residual_jac(&self, (a, b): &(A, B)) -> (SVector<f64, 1>, (A::Jacobian<1>, B::Jacobian<1>)) {
        let ((p_a, d_p_d_a), (p_b, d_p_d_b)) = (a.position_jac(), b.position_jac());
        let distance = (p_b - p_a).norm();
        let u = if distance > 0.0 { (p_b - p_a) / distance } else { SVector::zeros() };
        let jacobians = (row(&-u, &d_p_d_a), row(&u, &d_p_d_b));
        (vector![distance - self.measured], jacobians)
    }
}

/// uᵀ·J for an N×D matrix J.
fn row<const N: usize, J: JacobianBlock, K: JacobianBlock>(u: &SVector<f64, N>, j: &J) -> K {
    let mut out = K::zeros();
    for (out, column) in out.as_mut_slice().iter_mut().zip(j.as_slice().chunks_exact(N)) {
        *out = u.iter().zip(column).map(|(u, x)| u * x).sum();
    }
    out
}
