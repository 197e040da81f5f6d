//! Sim(2): similarities of the plane, X = \[s·R t; 0 1\], tangent (ρ₁, ρ₂, θ, σ), s = e^σ.
//!
//! Read as complex numbers, z = σ + iθ, X moves p to eᶻ·p + t:
//!
//! ```text
//! Exp: t = φ₁(z)·ρ                    Log: ρ = t/φ₁(z)           φ₁ = (eᶻ − 1)/z,  φ₂ = (eᶻ − 1 − z)/z²
//! Ad = [eᶻ, −it, −t; 0, 1, 0; 0, 0, 1]           ad = [z, −iρ, −ρ; 0, 0, 0; 0, 0, 0]
//! J_l = [φ₁, −iφ₂ρ, −φ₂ρ; 0, 1, 0; 0, 0, 1]      J_l⁻¹ = [1/φ₁, i(φ₂/φ₁)ρ, (φ₂/φ₁)ρ; 0, 1, 0; 0, 0, 1]
//! J_r(τ) = J_l(−τ)                               (a + ib stands for the block [a −b; b a])
//! ```
//! At σ = 0 this is SE(2): Solà et al. (2018) (152)–(168), with φ₁(iθ) = c₁ + iθc₂ and φ₂(iθ) = c₂ + iθc₃.
//!
//! The logarithm of the scale is stored, for the reasons given at [`crate::lie::Sim3`].
//!
//! Pitfall: ρ is no translation; for a similarity with given translation, angle and scale use [`Sim2::from_scale`].
//!
//! ```
//! use boxplus::lie::{LieGroup, SO2, Sim2};
//! use nalgebra::Vector2;
//! let quarter = SO2::from_angle(std::f64::consts::FRAC_PI_2);
//! let photo_from_map = Sim2::from_scale(quarter, Vector2::new(1.0, 0.0), 3.0)?;
//! let p = photo_from_map * Vector2::new(1.0, 0.0);
//! assert!((p - Vector2::new(1.0, 3.0)).norm() < 1e-14);
//! # Ok::<(), boxplus::lie::LieError>(())
//! ```

use super::sim3::log_scale;
use super::similarity::{over, phi, times};
use super::so3::check_affine;
use crate::lie::{Action, LieError, LieGroup, Real, SE2, SO2};
use core::ops::Mul;
use nalgebra::{Matrix2, Matrix3, Matrix4, SMatrix, Vector2, Vector4};

/// A similarity of the plane: rotation, translation and scale.
#[derive(Clone, Copy, PartialEq)]
#[cfg_attr(feature = "bytemuck", derive(bytemuck::TransparentWrapper))]
#[repr(transparent)]
pub struct Sim2<S = f64>(pub(in crate::lie) [S; 5]);

impl<S: Real> Sim2<S> {
    /// The similarity p ↦ e^`log_scale`·`rotation`·p + `translation`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(rotation: SO2<S>, translation: Vector2<S>, log_scale: S) -> Self {
        let [[x, y], [cos, sin]] = [translation.into(), rotation.0];
        Self([x, y, cos, sin, log_scale])
    }

    /// The similarity p ↦ `scale`·`rotation`·p + `translation`.
    ///
    /// # Errors
    /// [`LieError::NotAScale`] unless `scale` is positive and finite.
    pub fn from_scale(rotation: SO2<S>, translation: Vector2<S>, scale: S) -> Result<Self, LieError> {
        Ok(Self::new(rotation, translation, log_scale(scale)?))
    }

    /// The motion `pose` at scale 1.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn from_pose(pose: &SE2<S>) -> Self {
        Self::new(pose.rotation(), pose.translation(), S::zero())
    }

    /// The similarity of a homogeneous 3×3 matrix \[sR t; 0 1\].
    ///
    /// # Errors
    /// [`LieError::NotAScale`] for a block of zeros, those of [`SO2::from_matrix`], or [`LieError::NotHomogeneous`].
    pub fn from_matrix(m: &Matrix3<S>) -> Result<Self, LieError> {
        let block = m.fixed_view::<2, 2>(0, 0).into_owned();
        // Divided by its largest entry, so that no square over- or underflows; the columns of sR have length s.
        let largest = block.iter().fold(0.0, |a: f64, x| a.max(x.value().abs()));
        let logarithm = log_scale(S::lit(largest))?;
        let unit = block / S::lit(largest);
        let size = (unit.norm_squared() * S::lit(0.5)).simd_sqrt();
        let rotation = SO2::from_matrix(&(unit / size))?;
        check_affine([m.m13, m.m23], [m.m31, m.m32, m.m33 - S::one()])?;
        Ok(Self::new(rotation, Vector2::new(m.m13, m.m23), logarithm + size.simd_ln()))
    }

    /// R.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn rotation(&self) -> SO2<S> {
        SO2([self.0[2], self.0[3]])
    }

    /// t, in metres of the parent frame.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn translation(&self) -> Vector2<S> {
        Vector2::new(self.0[0], self.0[1])
    }

    /// s = e^σ > 0: lengths in the parent frame over lengths in the local one.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn scale(&self) -> S {
        self.log_scale().exp()
    }

    /// σ = ln s.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn log_scale(&self) -> S {
        self.0[4]
    }

    /// The homogeneous 3×3 matrix \[sR t; 0 1\].
    pub fn to_matrix(&self) -> Matrix3<S> {
        let mut m = Action::<4, 2>::linear_part(self).to_homogeneous();
        m.fixed_view_mut::<2, 1>(0, 2).copy_from(&self.translation());
        m
    }

    /// The same similarity with the rotation at unit norm to the last digit.
    pub fn normalize(&self) -> Self {
        Self::new(self.rotation().normalize(), self.translation(), self.log_scale())
    }

    /// ρ as a complex number, and z = σ + iθ.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn split(tau: &Vector4<S>) -> [Vector2<S>; 2] {
        [tau.xy(), Vector2::new(tau.w, tau.z)]
    }
}

/// \[a, −ib, −b; 0, c, 0; 0, 0, c\], a and b complex: the form of Ad, ad, and every Jacobian.
#[cfg_attr(not(debug_assertions), inline(always))]
fn block<S: Real>(a: &Vector2<S>, b: &Vector2<S>, c: S) -> Matrix4<S> {
    let o = S::zero();
    Matrix4::new(a.x, -a.y, b.y, -b.x, a.y, a.x, -b.x, -b.y, o, o, c, o, o, o, o, c)
}

impl<S: Real> LieGroup<4> for Sim2<S> {
    type Scalar = S;
    type Over<T: Real> = Sim2<T>;
    type Algebra = Matrix3<S>;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn identity() -> Self {
        Self::new(SO2::identity(), Vector2::zeros(), S::zero())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn compose(&self, rhs: &Self) -> Self {
        let rotation = self.rotation().compose(&rhs.rotation());
        Self::new(rotation, self.act(&rhs.translation()), self.log_scale() + rhs.log_scale())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn inverse(&self) -> Self {
        let (rotation, log_scale) = (self.rotation().inverse(), -self.log_scale());
        Self::new(rotation, -rotation.act(&self.translation()) * log_scale.exp(), log_scale)
    }
    /// Subtracts the translations first: the error is relative to their difference, however far from the origin.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn between(&self, other: &Self) -> Self {
        let inverse = self.rotation().inverse();
        let step = inverse.act(&(other.translation() - self.translation())) * (-self.log_scale()).exp();
        Self::new(inverse.compose(&other.rotation()), step, other.log_scale() - self.log_scale())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn exp(tau: &Vector4<S>) -> Self {
        let [rho, z] = Self::split(tau);
        Self::new(SO2::from_angle(z.y), times(&phi(&z).0, &rho), z.x)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn log(&self) -> Vector4<S> {
        let z = Vector2::new(self.log_scale(), self.rotation().angle());
        let rho = over(&self.translation(), &phi(&z).0);
        Vector4::new(rho.x, rho.y, z.y, z.x)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn adjoint(&self) -> Matrix4<S> {
        let growth = Vector2::new(self.rotation().cos(), self.rotation().sin()) * self.scale();
        block(&growth, &self.translation(), S::one())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn small_adjoint(tau: &Vector4<S>) -> Matrix4<S> {
        let [rho, z] = Self::split(tau);
        block(&z, &rho, S::zero())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn right_jacobian(tau: &Vector4<S>) -> Matrix4<S> {
        let [rho, z] = Self::split(&-tau);
        let (first, second) = phi(&z);
        block(&first, &times(&second, &rho), S::one())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn right_jacobian_inverse(tau: &Vector4<S>) -> Matrix4<S> {
        let [rho, z] = Self::split(&-tau);
        let (first, second) = phi(&z);
        let one = Vector2::new(S::one(), S::zero());
        block(&over(&one, &first), &-times(&over(&second, &first), &rho), S::one())
    }
    fn hat(tau: &Vector4<S>) -> Matrix3<S> {
        let o = S::zero();
        Matrix3::new(tau.w, -tau.z, tau.x, tau.z, tau.w, tau.y, o, o, o)
    }
    fn vee(algebra: &Matrix3<S>) -> Vector4<S> {
        Vector4::new(algebra.m13, algebra.m23, algebra.m21, algebra.m11)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn map<T: Real>(&self, f: impl Fn(S) -> T) -> Sim2<T> {
        let [x, y, cos, sin, sigma] = self.0;
        Sim2([f(x), f(y), f(cos), f(sin), f(sigma)])
    }
}

impl<S: Real> Action<4, 2> for Sim2<S> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn act(&self, p: &Vector2<S>) -> Vector2<S> {
        self.rotation().act(p) * self.scale() + self.translation()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn linear_part(&self) -> Matrix2<S> {
        self.rotation().to_matrix() * self.scale()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn generators_at(p: &Vector2<S>) -> SMatrix<S, 2, 4> {
        let (i, o) = (S::one(), S::zero());
        SMatrix::<S, 2, 4>::new(i, o, -p.y, p.x, o, i, p.x, p.y)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn act_direction(&self, d: &Vector2<S>) -> Vector2<S> {
        self.rotation().act(d) * self.scale()
    }
}

impl<S: Real> Mul for Sim2<S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, rhs: Self) -> Self {
        self.compose(&rhs)
    }
}

impl<S: Real> Mul<Vector2<S>> for Sim2<S> {
    type Output = Vector2<S>;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, p: Vector2<S>) -> Vector2<S> {
        self.act(&p)
    }
}
