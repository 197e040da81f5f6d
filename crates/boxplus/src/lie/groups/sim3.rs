//! Sim(3): similarities of space, X = \[s·R t; 0 1\], tangent (ρ, φ, σ), s = e^σ.
//!
//! ```text
//! Exp: R = Exp φ, s = e^σ, t = G·ρ                 Log: φ = Log R, σ = ln s, ρ = G⁻¹·t
//! G = ∫₀¹ e^{uσ}·Exp(uφ) du = A·I + B·φ^ + C·φ^²       Z = σI + φ^
//! Ad = [sR, t^R, −t; 0, R, 0; 0, 0, 1]             ad = [Z, ρ^, −ρ; 0, φ^, 0; 0, 0, 0]
//! J_l = [G, S, c; 0, J, 0; 0, 0, 1]                J_l⁻¹ = [G⁻¹, −G⁻¹SJ⁻¹, −G⁻¹c; 0, J⁻¹, 0; 0, 0, 1]
//! S = Σ Zⁱρ^(φ^)ʲ/(i + j + 2)!,  c = −Σ Zⁱρ/(i + 2)!,  J = J_l(φ)          J_r(τ) = J_l(−τ)
//! ```
//! Strasdat (2012); the evaluation of the coefficients is in `similarity.rs`. At σ = 0 everything is that of SE(3). What
//! monocular SLAM optimises, for a single camera cannot tell a small room from a large one, and its scale drifts.
//!
//! **Storage.** The logarithm σ of the scale is stored, beside a unit quaternion and t. Every real number is a valid σ, so
//! no composition leaves the group, were there 10⁷ of them; scales add instead of being multiplied, inverses are exact, and
//! a σ of 10⁻¹² keeps all its digits, of which 1 + 10⁻¹² would keep four. The price is one exponential per action; to move
//! many points take [`Sim3::to_matrix`] once.
//!
//! Pitfalls. Eade writes \[R t; 0 s⁻¹\], where the scale acts on the translation as well. ρ is no translation, see
//! [`Sim3::new`]. Sim(3) is not unimodular, det Ad = s³: a volume on the left is not one on the right.
//!
//! ```
//! use boxplus::lie::{LieGroup, SO3, Sim3};
//! use nalgebra::Vector3;
//! let turn = SO3::exp(&Vector3::new(0.0, 0.0, std::f64::consts::FRAC_PI_2));
//! let metric_from_map = Sim3::from_scale(turn, Vector3::new(1.0, 2.0, 3.0), 2.0)?;
//! let p = metric_from_map * Vector3::new(0.5, 0.0, 0.0);
//! assert!((p - Vector3::new(1.0, 3.0, 3.0)).norm() < 1e-15);
//! assert!(((metric_from_map * metric_from_map).scale() - 4.0).abs() < 1e-15);
//! # Ok::<(), boxplus::lie::LieError>(())
//! ```

use super::se23::split;
use super::similarity::{Polynomial, SimilarityJacobian, growth};
use super::so3::{check_affine, skew};
use crate::lie::unrolled::{blocks, cross};
use crate::lie::{Action, LieError, LieGroup, Real, SE3, SO3, Stumpff};
use core::ops::Mul;
use nalgebra::{Matrix3, Matrix4, SMatrix, SVector, Vector3};

/// A similarity of space: rotation, translation and scale.
#[derive(Clone, Copy)]
#[cfg_attr(feature = "bytemuck", derive(bytemuck::TransparentWrapper))]
#[repr(transparent)]
pub struct Sim3<S = f64>(pub(in crate::lie) [S; 8]);

impl<S: Real> Sim3<S> {
    /// The similarity p ↦ e^`log_scale`·`rotation`·p + `translation`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(rotation: SO3<S>, translation: Vector3<S>, log_scale: S) -> Self {
        let ([x, y, z], [i, j, k, w]) = (translation.into(), rotation.0);
        Self([x, y, z, i, j, k, w, log_scale])
    }

    /// The similarity p ↦ `scale`·`rotation`·p + `translation`.
    ///
    /// # Errors
    /// [`LieError::NotAScale`] unless `scale` is positive and finite.
    pub fn from_scale(rotation: SO3<S>, translation: Vector3<S>, scale: S) -> Result<Self, LieError> {
        Ok(Self::new(rotation, translation, log_scale(scale)?))
    }

    /// The motion `pose` at scale 1.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn from_pose(pose: &SE3<S>) -> Self {
        Self::new(pose.rotation(), pose.translation(), S::zero())
    }

    /// The similarity of a homogeneous 4×4 matrix \[sR t; 0 1\].
    ///
    /// # Errors
    /// [`LieError::NotAScale`] for a block of zeros, those of [`SO3::from_matrix`], or [`LieError::NotHomogeneous`].
    pub fn from_matrix(m: &Matrix4<S>) -> Result<Self, LieError> {
        let block = m.fixed_view::<3, 3>(0, 0).into_owned();
        // Divided by its largest entry, so that no square over- or underflows; the columns of sR have length s.
        let largest = block.iter().fold(0.0, |a: f64, x| a.max(x.value().abs()));
        let logarithm = log_scale(S::lit(largest))?;
        let unit = block / S::lit(largest);
        let size = (unit.norm_squared() / S::lit(3.0)).simd_sqrt();
        let rotation = SO3::from_matrix(&(unit / size))?;
        check_affine([m.m14, m.m24, m.m34], [m.m41, m.m42, m.m43, m.m44 - S::one()])?;
        Ok(Self::new(rotation, Vector3::new(m.m14, m.m24, m.m34), logarithm + size.simd_ln()))
    }

    /// R.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn rotation(&self) -> SO3<S> {
        let [_, _, _, x, y, z, w, _] = self.0;
        SO3([x, y, z, w])
    }

    /// t, in metres of the parent frame.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn translation(&self) -> Vector3<S> {
        let [x, y, z, ..] = self.0;
        Vector3::new(x, y, z)
    }

    /// s = e^σ > 0: lengths in the parent frame over lengths in the local one.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn scale(&self) -> S {
        self.log_scale().exp()
    }

    /// σ = ln s.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn log_scale(&self) -> S {
        self.0[7]
    }

    /// The homogeneous 4×4 matrix \[sR t; 0 1\].
    pub fn to_matrix(&self) -> Matrix4<S> {
        let mut m = Action::<7, 3>::linear_part(self).to_homogeneous();
        m.fixed_view_mut::<3, 1>(0, 3).copy_from(&self.translation());
        m
    }

    /// The same similarity with the rotation at unit norm to the last digit.
    pub fn normalize(&self) -> Self {
        Self::new(self.rotation().normalize(), self.translation(), self.log_scale())
    }
}

/// ln `scale`.
pub(super) fn log_scale<S: Real>(scale: S) -> Result<S, LieError> {
    let value = scale.value();
    if value > 0.0 && value.is_finite() {
        Ok(scale.simd_ln())
    } else {
        Err(LieError::NotAScale { scale: value })
    }
}

/// The 7×7 matrix \[a b c; 0 d 0; 0 0 e\].
#[inline]
fn block<S: Real>(a: &Matrix3<S>, b: &Matrix3<S>, c: &Vector3<S>, d: &Matrix3<S>, e: S) -> SMatrix<S, 7, 7> {
    let o = Matrix3::zeros();
    let mut m: SMatrix<S, 7, 7> = blocks([[a, b], [&o, d]]);
    [m.data.0[6][0], m.data.0[6][1], m.data.0[6][2]] = c.data.0[0];
    m.data.0[6][6] = e;
    m
}

/// (ρ, φ, σ).
#[cfg_attr(not(debug_assertions), inline(always))]
fn parts<S: Real>(tau: &SVector<S, 7>) -> (Vector3<S>, Vector3<S>, S) {
    let [rho, phi] = split(tau);
    (rho, phi, tau[6])
}

impl<S: Real> PartialEq for Sim3<S> {
    fn eq(&self, other: &Self) -> bool {
        self.rotation() == other.rotation()
            && self.translation() == other.translation()
            && self.log_scale() == other.log_scale()
    }
}

impl<S: Real> LieGroup<7> for Sim3<S> {
    type Scalar = S;
    type Over<T: Real> = Sim3<T>;
    type Algebra = Matrix4<S>;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn identity() -> Self {
        Self::new(SO3::identity(), Vector3::zeros(), S::zero())
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
    fn exp(tau: &SVector<S, 7>) -> Self {
        let (rho, phi, sigma) = parts(tau);
        Self::new(SO3::exp(&phi), growth(sigma, phi.norm_squared()).apply(&phi, &rho), sigma)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn log(&self) -> SVector<S, 7> {
        let phi = self.rotation().log();
        let x = phi.norm_squared();
        let rho = growth(self.log_scale(), x).inverse(x).apply(&phi, &self.translation());
        SVector::from([rho.x, rho.y, rho.z, phi.x, phi.y, phi.z, self.log_scale()])
    }
    #[inline]
    fn adjoint(&self) -> SMatrix<S, 7, 7> {
        let (r, t) = (self.rotation().to_matrix(), self.translation());
        block(&(r * self.scale()), &cross(&t, &r), &-t, &r, S::one())
    }
    #[inline]
    fn small_adjoint(tau: &SVector<S, 7>) -> SMatrix<S, 7, 7> {
        let (rho, phi, sigma) = parts(tau);
        let w = skew(&phi);
        block(&(w + Matrix3::from_diagonal_element(sigma)), &skew(&rho), &-rho, &w, S::zero())
    }
    #[inline]
    fn right_jacobian(tau: &SVector<S, 7>) -> SMatrix<S, 7, 7> {
        Self::left_jacobian(&-tau)
    }
    #[inline]
    fn left_jacobian(tau: &SVector<S, 7>) -> SMatrix<S, 7, 7> {
        let (rho, phi, sigma) = parts(tau);
        let k = SimilarityJacobian::new(sigma, phi.norm_squared());
        let column = -k.h.apply(&phi, &rho);
        block(&k.g.matrix(&phi), &k.s.matrix(&rho, &phi), &column, &k.j.matrix(&phi), S::one())
    }
    #[inline]
    fn right_jacobian_inverse(tau: &SVector<S, 7>) -> SMatrix<S, 7, 7> {
        Self::left_jacobian_inverse(&-tau)
    }
    #[inline]
    fn left_jacobian_inverse(tau: &SVector<S, 7>) -> SMatrix<S, 7, 7> {
        let (rho, phi, sigma) = parts(tau);
        let x = phi.norm_squared();
        let k = SimilarityJacobian::new(sigma, x);
        let g = growth(sigma, x).inverse(x);
        let j = Polynomial([S::one(), S::lit(-0.5), Stumpff::new(x).d()]);
        let coupling = -k.s.after(&g, x).before(&j, x).matrix(&rho, &phi);
        let column = g.apply(&phi, &k.h.apply(&phi, &rho));
        block(&g.matrix(&phi), &coupling, &column, &j.matrix(&phi), S::one())
    }
    /// One side only: nothing is shared with the other.
    #[inline]
    fn log_jac(&self) -> (SVector<S, 7>, SMatrix<S, 7, 7>) {
        let tau = self.log();
        (tau, Self::right_jacobian_inverse(&tau))
    }
    fn hat(tau: &SVector<S, 7>) -> Matrix4<S> {
        let (rho, phi, sigma) = parts(tau);
        let mut m = Matrix4::zeros();
        m.fixed_view_mut::<3, 3>(0, 0).copy_from(&skew(&phi));
        m.fixed_view_mut::<3, 1>(0, 3).copy_from(&rho);
        for i in 0..3 {
            m[(i, i)] = sigma;
        }
        m
    }
    fn vee(algebra: &Matrix4<S>) -> SVector<S, 7> {
        let m = algebra;
        SVector::from([m.m14, m.m24, m.m34, m.m32, m.m13, m.m21, m.m11])
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn map<T: Real>(&self, f: impl Fn(S) -> T) -> Sim3<T> {
        let [x, y, z, i, j, k, w, sigma] = self.0;
        Sim3([f(x), f(y), f(z), f(i), f(j), f(k), f(w), f(sigma)])
    }
}

impl<S: Real> Action<7, 3> for Sim3<S> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn act(&self, p: &Vector3<S>) -> Vector3<S> {
        self.rotation().act(p) * self.scale() + self.translation()
    }
    #[inline]
    fn linear_part(&self) -> Matrix3<S> {
        self.rotation().to_matrix() * self.scale()
    }
    #[inline]
    fn generators_at(p: &Vector3<S>) -> SMatrix<S, 3, 7> {
        let mut g = SMatrix::<S, 3, 7>::zeros();
        g.fixed_view_mut::<3, 6>(0, 0).copy_from(&SE3::generators_at(p));
        g.set_column(6, p);
        g
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn act_direction(&self, d: &Vector3<S>) -> Vector3<S> {
        self.rotation().act(d) * self.scale()
    }
}

impl<S: Real> Mul for Sim3<S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, rhs: Self) -> Self {
        self.compose(&rhs)
    }
}

impl<S: Real> Mul<Vector3<S>> for Sim3<S> {
    type Output = Vector3<S>;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, p: Vector3<S>) -> Vector3<S> {
        self.act(&p)
    }
}
