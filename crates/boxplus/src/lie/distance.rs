//! How far apart two elements are.
//!
//! | distance | of rotations by θ | |
//! |---|---|---|
//! | geodesic, [`SO3::angle_to`] | θ | the angle; Riemannian, both sides invariant |
//! | chordal, [`SO3::chordal_distance`] | 2√2·sin(θ/2) | ‖R₁ − R₂‖ of Frobenius: what SE-Sync and chordal means minimise |
//! | quaternion, [`SO3::quaternion_distance`] | 2·sin(θ/4) | min(‖q₁ − q₂‖, ‖q₁ + q₂‖) |
//!
//! Each is computed without cancellation, right to a few ε for θ → 0, too. For small θ they are θ, √2·θ, ½θ: mind the factor
//! when a threshold or a weight moves from one to another.
//!
//! Poses mix metres and radians, so that a distance needs weights: [`Distance::weighted_distance`] is the norm of the local
//! step from one to the other, coordinate by coordinate. It is symmetric and left-invariant (independent of the world frame),
//! but on groups with translation no metric: the triangle inequality may fail. For a distance with a meaning take a covariance
//! and Mahalanobis.
//!
//! ```
//! use boxplus::lie::{Distance, SE2, SO3};
//! use nalgebra::{Vector2, Vector3};
//! let (a, b): (SO3, SO3) = (SO3::about_z(0.1), SO3::about_z(0.4));
//! assert!((a.angle_to(&b) - 0.3).abs() < 1e-15);
//! let (here, there): (SE2, SE2) = (SE2::new(Vector2::zeros(), 0.0), SE2::new(Vector2::new(3.0, 4.0), 0.0));
//! let per_metre_and_radian = Vector3::new(1.0, 1.0, 10.0);
//! assert!((here.weighted_distance(&there, &per_metre_and_radian) - 5.0).abs() < 1e-15);
//! ```

use super::{LieGroup, Real, SO2, SO3, Tangent};
use nalgebra::{SimdComplexField, Vector3};

/// Distances of every group.
pub trait Distance<const D: usize>: LieGroup<D> {
    /// ‖w ∘ (Y ⊖ X)‖ with X = `self`, Y = `other`: the length of the local step between them, each coordinate multiplied by its
    /// weight (1/m, 1/rad, …).
    #[inline]
    fn weighted_distance(&self, other: &Self, weights: &Tangent<Self::Scalar, D>) -> Self::Scalar {
        other.rminus(self).component_mul(weights).norm_squared().simd_sqrt()
    }
}

impl<G: LieGroup<D>, const D: usize> Distance<D> for G {}

impl<S: Real> SO2<S> {
    /// The angle between two rotations, in \[0, π\] radians.
    #[inline]
    pub fn angle_to(&self, other: &Self) -> S {
        self.between(other).angle().simd_abs()
    }

    /// ‖R₁ − R₂‖ of Frobenius, 2√2·sin(θ/2), in \[0, 2√2\].
    #[inline]
    pub fn chordal_distance(&self, other: &Self) -> S {
        let (cos, sin) = (self.cos() - other.cos(), self.sin() - other.sin());
        ((cos * cos + sin * sin) * S::lit(2.0)).simd_sqrt()
    }
}

impl<S: Real> SO3<S> {
    /// (sin(θ/2), cos(θ/2)) of the rotation from one to the other by θ ≤ π.
    #[inline]
    fn half_angle_to(&self, other: &Self) -> (S, S) {
        let [x, y, z, w] = self.between(other).quaternion_xyzw();
        (Vector3::new(x, y, z).norm_squared().simd_sqrt(), w.simd_abs())
    }

    /// The angle θ of the rotation from one to the other, in \[0, π\] radians: the geodesic distance.
    #[inline]
    pub fn angle_to(&self, other: &Self) -> S {
        let (sin, cos) = self.half_angle_to(other);
        S::polar_angle(sin, cos) * S::lit(2.0)
    }

    /// ‖R₁ − R₂‖ of Frobenius, 2√2·sin(θ/2), in \[0, 2√2\].
    #[inline]
    pub fn chordal_distance(&self, other: &Self) -> S {
        self.half_angle_to(other).0 * S::lit(2.0 * core::f64::consts::SQRT_2)
    }

    /// min(‖q₁ − q₂‖, ‖q₁ + q₂‖), 2·sin(θ/4), in \[0, √2\].
    #[inline]
    pub fn quaternion_distance(&self, other: &Self) -> S {
        // 2·sin(θ/4) = sin(θ/2)/cos(θ/4), cos²(θ/4) = ½(1 + cos(θ/2)).
        let (sin, cos) = self.half_angle_to(other);
        sin / ((S::one() + cos) * S::lit(0.5)).simd_sqrt()
    }
}
