//! SO(2): rotations of the plane, stored as (cos θ, sin θ).
//!
//! X·Y multiplies the unit complex numbers; Exp θ = (cos θ, sin θ), Log = atan2(sin, cos) ∈ [−π, π], Ad = J_r = 1,
//! ad = 0 (Solà et al. (2018) (113)–(120)). Rotations are active and counter-clockwise.
//!
//! Pitfall: at θ = π the logarithm keeps the sign of the stored sine; compare rotations by `minus`, never by angle.
//!
//! ```
//! use boxplus::lie::{LieGroup, SO2};
//! use nalgebra::Vector2;
//! let quarter = SO2::from_angle(std::f64::consts::FRAC_PI_2);
//! assert!((quarter * Vector2::new(1.0, 0.0) - Vector2::new(0.0, 1.0)).norm() < 1e-15);
//! assert!(((quarter * quarter * quarter).angle() + std::f64::consts::FRAC_PI_2).abs() < 1e-15);
//! ```

use crate::lie::{Action, LieError, LieGroup, Real};
use core::ops::Mul;
use nalgebra::{Matrix2, SMatrix, SVector, SimdComplexField, Vector1, Vector2};

/// A rotation of the plane.
#[derive(Clone, Copy, PartialEq)]
#[cfg_attr(feature = "bytemuck", derive(bytemuck::TransparentWrapper))]
#[repr(transparent)]
pub struct SO2<S = f64>(pub(in crate::lie) [S; 2]);

impl<S: Real> SO2<S> {
    /// The rotation by `angle` radians, counter-clockwise.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn from_angle(angle: S) -> Self {
        let (sin, cos) = angle.simd_sin_cos();
        Self::from_unit(cos, sin)
    }

    /// The rotation whose cosine and sine have the ratio of the arguments, which are scaled to unit norm.
    ///
    /// # Errors
    /// [`LieError::NotFinite`], or [`LieError::Zero`] where both are zero.
    pub fn from_cos_sin(cos: S, sin: S) -> Result<Self, LieError> {
        let largest = cos.value().abs().max(sin.value().abs());
        if !(cos.value().is_finite() && sin.value().is_finite()) {
            return Err(LieError::NotFinite);
        }
        if largest == 0.0 {
            return Err(LieError::Zero);
        }
        let scale = S::lit(largest); // so that no square over- or underflows
        Ok(Self::from_unit(cos / scale, sin / scale).normalize())
    }

    /// The rotation of a 2×2 matrix.
    ///
    /// # Errors
    /// [`LieError::NotFinite`], [`LieError::NotARotation`] or [`LieError::Reflection`]; see [`SO2::project`].
    pub fn from_matrix(m: &Matrix2<S>) -> Result<Self, LieError> {
        super::so3::check_rotation(m, m.m11 * m.m22 - m.m12 * m.m21)?;
        Self::project(m)
    }

    /// The rotation nearest to any 2×2 matrix in the Frobenius norm.
    ///
    /// # Errors
    /// [`LieError::NotFinite`], or [`LieError::Undetermined`] for a multiple of a reflection, 0 included.
    pub fn project(m: &Matrix2<S>) -> Result<Self, LieError> {
        // tr(RᵀM) = (m₁₁ + m₂₂) cos θ + (m₂₁ − m₁₂) sin θ is largest along this vector.
        let (cos, sin) = (m.m11 + m.m22, m.m21 - m.m12);
        let size = m.iter().fold(0.0, |a: f64, x| a + x.value().abs());
        if !size.is_finite() {
            return Err(LieError::NotFinite);
        }
        if size == 0.0 {
            return Err(LieError::Undetermined { gap: 0.0 });
        }
        let gap = cos.value().simd_hypot(sin.value()) / size;
        // Entries of M known to ε leave the angle uncertain by ε/gap.
        if gap <= 4.0 * S::EPSILON {
            return Err(LieError::Undetermined { gap });
        }
        Self::from_cos_sin(cos, sin)
    }

    /// The angle in radians, in [−π, π].
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn angle(&self) -> S {
        // ±(π − arcsin|sin θ|) behind, where −0 and 0 are told apart.
        let (sin, cos) = (self.sin(), self.cos());
        let near = sin * S::angle_over_sine(sin * sin, cos.simd_abs());
        S::choose(cos.simd_lt(S::zero()), || S::simd_pi().simd_copysign(sin) - near, || near)
    }

    /// cos θ.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn cos(&self) -> S {
        self.0[0]
    }

    /// sin θ.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn sin(&self) -> S {
        self.0[1]
    }

    /// The 2×2 matrix \[cos, −sin; sin, cos\].
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn to_matrix(&self) -> Matrix2<S> {
        Matrix2::new(self.cos(), -self.sin(), self.sin(), self.cos())
    }

    /// The same rotation at unit norm to the last digit. Products already hold it within 2ε.
    pub fn normalize(&self) -> Self {
        let inverse_norm = S::one() / (self.cos() * self.cos() + self.sin() * self.sin()).simd_sqrt();
        Self::from_unit(self.cos() * inverse_norm, self.sin() * inverse_norm)
    }

    /// The rotation with this cosine and sine, of unit norm together.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(in crate::lie) fn from_unit(cos: S, sin: S) -> Self {
        Self([cos, sin])
    }

    /// \[1\]× v = (−v₂, v₁), `v` turned by 90°.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(in crate::lie) fn turn(v: &Vector2<S>) -> Vector2<S> {
        Vector2::new(-v.y, v.x)
    }
}

impl<S: Real> LieGroup<1> for SO2<S> {
    type Scalar = S;
    type Over<T: Real> = SO2<T>;
    type Algebra = Matrix2<S>;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn identity() -> Self {
        Self::from_unit(S::one(), S::zero())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn compose(&self, rhs: &Self) -> Self {
        let cos = self.cos() * rhs.cos() - self.sin() * rhs.sin();
        let sin = self.cos() * rhs.sin() + self.sin() * rhs.cos();
        // One Newton step towards unit norm: the error of a product is squared instead of handed on.
        let scale = S::lit(1.5) - S::lit(0.5) * (cos * cos + sin * sin);
        Self::from_unit(cos * scale, sin * scale)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn inverse(&self) -> Self {
        Self::from_unit(self.cos(), -self.sin())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn exp(tau: &SVector<S, 1>) -> Self {
        Self::from_angle(tau.x)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn log(&self) -> SVector<S, 1> {
        Vector1::new(self.angle())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn adjoint(&self) -> SMatrix<S, 1, 1> {
        SMatrix::identity()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn small_adjoint(_: &SVector<S, 1>) -> SMatrix<S, 1, 1> {
        SMatrix::zeros()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn right_jacobian(_: &SVector<S, 1>) -> SMatrix<S, 1, 1> {
        SMatrix::identity()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn right_jacobian_inverse(_: &SVector<S, 1>) -> SMatrix<S, 1, 1> {
        SMatrix::identity()
    }
    fn hat(tau: &SVector<S, 1>) -> Matrix2<S> {
        Matrix2::new(S::zero(), -tau.x, tau.x, S::zero())
    }
    fn vee(algebra: &Matrix2<S>) -> SVector<S, 1> {
        Vector1::new(algebra.m21)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn map<T: Real>(&self, f: impl Fn(S) -> T) -> SO2<T> {
        let [cos, sin] = self.0;
        SO2([f(cos), f(sin)])
    }
}

impl<S: Real> Action<1, 2> for SO2<S> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn act(&self, p: &Vector2<S>) -> Vector2<S> {
        Vector2::new(self.cos() * p.x - self.sin() * p.y, self.sin() * p.x + self.cos() * p.y)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn linear_part(&self) -> Matrix2<S> {
        self.to_matrix()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn generators_at(p: &Vector2<S>) -> SMatrix<S, 2, 1> {
        Self::turn(p)
    }
}

impl<S: Real> Mul for SO2<S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, rhs: Self) -> Self {
        self.compose(&rhs)
    }
}

impl<S: Real> Mul<Vector2<S>> for SO2<S> {
    type Output = Vector2<S>;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, p: Vector2<S>) -> Vector2<S> {
        self.act(&p)
    }
}
