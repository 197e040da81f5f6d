//! Bézier curves by de Casteljau's construction: geodesics between points on geodesics.

use crate::lie::{Jacobian, LieGroup, Real, Tangent};
use crate::trajectory::error::check_ways;
use crate::trajectory::{Motion, TrajectoryError};
use nalgebra::SMatrix;

/// A Bézier curve of degree N − 1 on any group, for u ∈ \[0, 1\].
///
/// ```text
/// Xᵢ⁰ = control i      Xᵢʳ(u) = Xᵢʳ⁻¹·Exp(u·(Xᵢ₊₁ʳ⁻¹ ⊖ Xᵢʳ⁻¹))      X(u) = X₀ᴺ⁻¹(u)
/// ```
/// It starts at the first control element and ends at the last, leaving the first with body velocity (N − 1)·(X₁ ⊖ X₀) and
/// arriving with (N − 1)·(X_{N−1} ⊖ X_{N−2}). Shoemake (1985) on S³, Park & Ravani (1995) on Lie groups. Two control elements
/// make [`LieGroup::interpolate`]. Left-invariant: moving all control elements by G moves the curve by G.
///
/// Pitfall: a group is curved, so that splitting a Bézier curve in two does not give Bézier curves; and the construction is
/// smooth only while no two intermediate points are half a turn apart, which is so when all control rotations lie within a
/// quarter turn of one of them.
///
/// ```
/// use boxplus::lie::{LieGroup, SO3};
/// use boxplus::trajectory::Bezier;
/// use nalgebra::Vector3;
/// let controls: [SO3; 4] = [0.0, 0.4, 0.8, 1.0].map(|a| SO3::exp(&Vector3::new(0.0, a * a, a)));
/// let curve = Bezier::new(controls)?;
/// let (end, _, velocity) = curve.at_jac(1.0);
/// assert!(end.rminus(&controls[3]).norm() < 1e-15);
/// assert!((velocity - 3.0 * controls[3].rminus(&controls[2])).norm() < 1e-14);
/// # Ok::<(), boxplus::trajectory::TrajectoryError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bezier<G: LieGroup<D>, const D: usize, const N: usize> {
    controls: [G; N],
}

impl<G: LieGroup<D>, const D: usize, const N: usize> Bezier<G, D, N> {
    /// The curve of these control elements, of degree N − 1.
    ///
    /// # Errors
    /// [`TrajectoryError::TooFew`] without elements, [`TrajectoryError::NotFinite`], or [`TrajectoryError::Ambiguous`] where
    /// neighbours are half a turn apart.
    pub fn new(controls: [G; N]) -> Result<Self, TrajectoryError> {
        if N == 0 {
            return Err(TrajectoryError::TooFew { got: 0, needed: 1 });
        }
        check_ways(&controls)?;
        Ok(Self { controls })
    }

    /// X(u) with its rates, per unit of u.
    pub fn at(&self, u: G::Scalar) -> Motion<G, D> {
        let (zero, one) = (G::Scalar::lit(0.0), G::Scalar::lit(1.0));
        let mut points = self.controls.map(Motion::at_rest);
        for level in 1..N {
            for i in 0..N - level {
                points[i] = points[i].interpolate(&points[i + 1], &[u, one, zero, zero]);
            }
        }
        points[0]
    }

    /// X(u): `(value, [d_value_d_control; N], d_value_d_u)`, the last being the body velocity per unit of u. The
    /// value alone, without further rates, costs less this way than by [`Bezier::at`].
    pub fn at_jac(&self, u: G::Scalar) -> (G, [Jacobian<G::Scalar, D>; N], Tangent<G::Scalar, D>) {
        let mut points = self.controls;
        let mut velocities = [Tangent::<G::Scalar, D>::zeros(); N];
        let mut jacobians = [[Jacobian::<G::Scalar, D>::zeros(); N]; N];
        for (i, row) in jacobians.iter_mut().enumerate() {
            row[i] = SMatrix::identity();
        }
        for level in 1..N {
            for i in 0..N - level {
                let (point, d_left, d_right, d_u) = points[i].interpolate_jac(&points[i + 1], u);
                points[i] = point;
                velocities[i] = d_left * velocities[i] + d_right * velocities[i + 1] + d_u;
                let (left, right) = jacobians.split_at_mut(i + 1);
                for (left, right) in left[i].iter_mut().zip(&right[0]) {
                    *left = d_left * *left + d_right * right;
                }
            }
        }
        (points[0], jacobians[0], velocities[0])
    }
}
