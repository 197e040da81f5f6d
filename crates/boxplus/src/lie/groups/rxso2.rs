//! ℝ⁺×SO(2): scaled rotations of the plane, s·R, tangent (θ, σ), s = e^σ.
//!
//! The complex numbers without 0 under multiplication: Exp(θ, σ) = e^{σ+iθ}. The group is commutative, hence Ad = J_r = I and
//! ad = 0. It is Sim(2) without translation (Sophus: `RxSO2`). The logarithm σ of the scale is stored, for the reasons given
//! at [`crate::lie::Sim3`].
//!
//! Pitfall: everything runs geometrically in the scale: halfway between the scales 1 and 4 is 2. A reflection is no element, nor is
//! the scale 0.
//!
//! ```
//! use boxplus::lie::{LieGroup, RxSO2, SO2};
//! use nalgebra::Vector2;
//! let photo_from_map = RxSO2::from_scale(SO2::from_angle(std::f64::consts::FRAC_PI_2), 3.0)?;
//! assert!((photo_from_map * Vector2::x() - Vector2::y() * 3.0).norm() < 1e-14);
//! assert!((photo_from_map.power(0.5).scale() - 3.0_f64.sqrt()).abs() < 1e-15);
//! # Ok::<(), boxplus::lie::LieError>(())
//! ```

use super::sim3::log_scale;
use crate::lie::{Action, LieError, LieGroup, Real, SO2, Sim2};
use core::ops::Mul;
use nalgebra::{Matrix2, Vector2};

/// A rotation of the plane with a change of scale.
#[derive(Clone, Copy, PartialEq)]
#[cfg_attr(feature = "bytemuck", derive(bytemuck::TransparentWrapper))]
#[repr(transparent)]
pub struct RxSO2<S = f64>(pub(in crate::lie) [S; 3]);

impl<S: Real> RxSO2<S> {
    /// The map p ↦ e^`log_scale`·`rotation`·p.
    #[inline]
    pub fn new(rotation: SO2<S>, log_scale: S) -> Self {
        let [cos, sin] = rotation.0;
        Self([cos, sin, log_scale])
    }

    /// The map p ↦ `scale`·`rotation`·p.
    ///
    /// # Errors
    /// [`LieError::NotAScale`] unless `scale` is positive and finite.
    pub fn from_scale(rotation: SO2<S>, scale: S) -> Result<Self, LieError> {
        Ok(Self::new(rotation, log_scale(scale)?))
    }

    /// The map of a 2×2 matrix s·R.
    ///
    /// # Errors
    /// [`LieError::NotAScale`] for a block of zeros, or those of [`SO2::from_matrix`].
    pub fn from_matrix(m: &Matrix2<S>) -> Result<Self, LieError> {
        let similarity = Sim2::from_matrix(&m.to_homogeneous())?;
        Ok(Self::new(similarity.rotation(), similarity.log_scale()))
    }

    /// R.
    #[inline]
    pub fn rotation(&self) -> SO2<S> {
        let [cos, sin, _] = self.0;
        SO2([cos, sin])
    }

    /// s = e^σ > 0: lengths in the parent frame over lengths in the local one.
    #[inline]
    pub fn scale(&self) -> S {
        self.log_scale().exp()
    }

    /// σ = ln s.
    #[inline]
    pub fn log_scale(&self) -> S {
        self.0[2]
    }

    /// The 2×2 matrix s·R.
    #[inline]
    pub fn to_matrix(&self) -> Matrix2<S> {
        self.rotation().to_matrix() * self.scale()
    }

    /// The same map with the rotation at unit norm to the last digit.
    pub fn normalize(&self) -> Self {
        Self::new(self.rotation().normalize(), self.log_scale())
    }
}

/// At the origin.
impl<S: Real> From<RxSO2<S>> for Sim2<S> {
    fn from(x: RxSO2<S>) -> Self {
        Self::new(x.rotation(), Vector2::zeros(), x.log_scale())
    }
}

impl<S: Real> LieGroup<2> for RxSO2<S> {
    type Scalar = S;
    type Over<T: Real> = RxSO2<T>;
    type Algebra = Matrix2<S>;

    #[inline]
    fn identity() -> Self {
        Self::new(SO2::identity(), S::zero())
    }
    #[inline]
    fn compose(&self, rhs: &Self) -> Self {
        Self::new(self.rotation().compose(&rhs.rotation()), self.log_scale() + rhs.log_scale())
    }
    #[inline]
    fn inverse(&self) -> Self {
        Self::new(self.rotation().inverse(), -self.log_scale())
    }
    #[inline]
    fn exp(tau: &Vector2<S>) -> Self {
        Self::new(SO2::from_angle(tau.x), tau.y)
    }
    #[inline]
    fn log(&self) -> Vector2<S> {
        Vector2::new(self.rotation().angle(), self.log_scale())
    }
    #[inline]
    fn adjoint(&self) -> Matrix2<S> {
        Matrix2::identity()
    }
    #[inline]
    fn small_adjoint(_: &Vector2<S>) -> Matrix2<S> {
        Matrix2::zeros()
    }
    #[inline]
    fn right_jacobian(_: &Vector2<S>) -> Matrix2<S> {
        Matrix2::identity()
    }
    #[inline]
    fn right_jacobian_inverse(_: &Vector2<S>) -> Matrix2<S> {
        Matrix2::identity()
    }
    fn hat(tau: &Vector2<S>) -> Matrix2<S> {
        Matrix2::new(tau.y, -tau.x, tau.x, tau.y)
    }
    fn vee(algebra: &Matrix2<S>) -> Vector2<S> {
        Vector2::new(algebra.m21, algebra.m11)
    }
    fn map<T: Real>(&self, f: impl Fn(S) -> T) -> RxSO2<T> {
        RxSO2::new(self.rotation().map(&f), f(self.log_scale()))
    }
}

impl<S: Real> Action<2, 2> for RxSO2<S> {
    #[inline]
    fn act(&self, p: &Vector2<S>) -> Vector2<S> {
        self.rotation().act(p) * self.scale()
    }
    #[inline]
    fn linear_part(&self) -> Matrix2<S> {
        self.to_matrix()
    }
    #[inline]
    fn generators_at(p: &Vector2<S>) -> Matrix2<S> {
        Matrix2::from_columns(&[SO2::turn(p), *p])
    }
}

impl<S: Real> Mul for RxSO2<S> {
    type Output = Self;
    #[inline]
    fn mul(self, rhs: Self) -> Self {
        self.compose(&rhs)
    }
}

impl<S: Real> Mul<Vector2<S>> for RxSO2<S> {
    type Output = Vector2<S>;
    #[inline]
    fn mul(self, p: Vector2<S>) -> Vector2<S> {
        self.act(&p)
    }
}
