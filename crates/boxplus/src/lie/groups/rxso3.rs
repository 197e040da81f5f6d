//! ℝ⁺×SO(3): scaled rotations of space, s·R, tangent (φ, σ), s = e^σ.
//!
//! Turning and growing commute, so that the group is the direct product of SO(3) and the scales: every operator is
//! block-diagonal, Exp(φ, σ) = e^σ·Exp φ, Ad = \[R, 0; 0, 1\], J_l = \[J_l(φ), 0; 0, 1\]. It is Sim(3) without translation, and what a
//! non-zero quaternion is as an element of a group: q ≙ |q|²·R(q) (Sophus: `RxSO3`). The logarithm σ of the scale is stored,
//! for the reasons given at [`crate::lie::Sim3`].
//!
//! Pitfalls. It scales about the origin; about another point take [`crate::lie::Sim3`]. Everything runs geometrically in the scale:
//! halfway between the scales 1 and 4 is 2.
//!
//! ```
//! use boxplus::lie::{LieGroup, RxSO3, SO3, Sim3};
//! use nalgebra::Vector3;
//! let metric_from_map = RxSO3::from_scale(SO3::about_z(std::f64::consts::FRAC_PI_2), 2.0)?;
//! assert!((metric_from_map * Vector3::x() - Vector3::y() * 2.0).norm() < 1e-15);
//! let similarity = Sim3::from(metric_from_map); // about the origin
//! assert!((similarity * Vector3::x() - Vector3::y() * 2.0).norm() < 1e-15);
//! # Ok::<(), boxplus::lie::LieError>(())
//! ```

use super::sim3::log_scale;
use crate::lie::{Action, LieError, LieGroup, Real, SO3, Sim3};
use core::ops::Mul;
use nalgebra::{Matrix3, Matrix4, SMatrix, Vector3, Vector4};

/// A rotation of space with a change of scale.
#[derive(Clone, Copy)]
#[cfg_attr(feature = "bytemuck", derive(bytemuck::TransparentWrapper))]
#[repr(transparent)]
pub struct RxSO3<S = f64>(pub(in crate::lie) [S; 5]);

impl<S: Real> RxSO3<S> {
    /// The map p ↦ e^`log_scale`·`rotation`·p.
    #[inline]
    pub fn new(rotation: SO3<S>, log_scale: S) -> Self {
        let [x, y, z, w] = rotation.0;
        Self([x, y, z, w, log_scale])
    }

    /// The map p ↦ `scale`·`rotation`·p.
    ///
    /// # Errors
    /// [`LieError::NotAScale`] unless `scale` is positive and finite.
    pub fn from_scale(rotation: SO3<S>, scale: S) -> Result<Self, LieError> {
        Ok(Self::new(rotation, log_scale(scale)?))
    }

    /// The map of a 3×3 matrix s·R.
    ///
    /// # Errors
    /// [`LieError::NotAScale`] for a block of zeros, or those of [`SO3::from_matrix`].
    pub fn from_matrix(m: &Matrix3<S>) -> Result<Self, LieError> {
        let similarity = Sim3::from_matrix(&m.to_homogeneous())?;
        Ok(Self::new(similarity.rotation(), similarity.log_scale()))
    }

    /// R.
    #[inline]
    pub fn rotation(&self) -> SO3<S> {
        let [x, y, z, w, _] = self.0;
        SO3([x, y, z, w])
    }

    /// s = e^σ > 0: lengths in the parent frame over lengths in the local one.
    #[inline]
    pub fn scale(&self) -> S {
        self.log_scale().exp()
    }

    /// σ = ln s.
    #[inline]
    pub fn log_scale(&self) -> S {
        self.0[4]
    }

    /// The 3×3 matrix s·R.
    #[inline]
    pub fn to_matrix(&self) -> Matrix3<S> {
        self.rotation().to_matrix() * self.scale()
    }

    /// The same map with the rotation at unit norm to the last digit.
    pub fn normalize(&self) -> Self {
        Self::new(self.rotation().normalize(), self.log_scale())
    }
}

/// \[a, 0; 0, b\].
#[inline]
fn block<S: Real>(a: &Matrix3<S>, b: S) -> Matrix4<S> {
    let mut m = a.to_homogeneous();
    m.m44 = b;
    m
}

impl<S: Real> PartialEq for RxSO3<S> {
    fn eq(&self, other: &Self) -> bool {
        self.rotation() == other.rotation() && self.log_scale() == other.log_scale()
    }
}

/// At the origin.
impl<S: Real> From<RxSO3<S>> for Sim3<S> {
    fn from(x: RxSO3<S>) -> Self {
        Self::new(x.rotation(), Vector3::zeros(), x.log_scale())
    }
}

impl<S: Real> LieGroup<4> for RxSO3<S> {
    type Scalar = S;
    type Over<T: Real> = RxSO3<T>;
    type Algebra = Matrix3<S>;

    #[inline]
    fn identity() -> Self {
        Self::new(SO3::identity(), S::zero())
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
    fn exp(tau: &Vector4<S>) -> Self {
        Self::new(SO3::exp(&tau.xyz()), tau.w)
    }
    #[inline]
    fn log(&self) -> Vector4<S> {
        self.rotation().log().push(self.log_scale())
    }
    #[inline]
    fn adjoint(&self) -> Matrix4<S> {
        block(&self.rotation().adjoint(), S::one())
    }
    #[inline]
    fn small_adjoint(tau: &Vector4<S>) -> Matrix4<S> {
        block(&SO3::small_adjoint(&tau.xyz()), S::zero())
    }
    #[inline]
    fn right_jacobian(tau: &Vector4<S>) -> Matrix4<S> {
        block(&SO3::right_jacobian(&tau.xyz()), S::one())
    }
    #[inline]
    fn right_jacobian_inverse(tau: &Vector4<S>) -> Matrix4<S> {
        block(&SO3::right_jacobian_inverse(&tau.xyz()), S::one())
    }
    fn hat(tau: &Vector4<S>) -> Matrix3<S> {
        SO3::hat(&tau.xyz()) + Matrix3::from_diagonal_element(tau.w)
    }
    fn vee(algebra: &Matrix3<S>) -> Vector4<S> {
        SO3::vee(algebra).push(algebra.m11)
    }
    fn map<T: Real>(&self, f: impl Fn(S) -> T) -> RxSO3<T> {
        RxSO3::new(self.rotation().map(&f), f(self.log_scale()))
    }
}

impl<S: Real> Action<4, 3> for RxSO3<S> {
    #[inline]
    fn act(&self, p: &Vector3<S>) -> Vector3<S> {
        self.rotation().act(p) * self.scale()
    }
    #[inline]
    fn linear_part(&self) -> Matrix3<S> {
        self.to_matrix()
    }
    #[inline]
    fn generators_at(p: &Vector3<S>) -> SMatrix<S, 3, 4> {
        let mut g = SMatrix::<S, 3, 4>::zeros();
        g.fixed_view_mut::<3, 3>(0, 0).copy_from(&SO3::generators_at(p));
        g.set_column(3, p);
        g
    }
}

impl<S: Real> Mul for RxSO3<S> {
    type Output = Self;
    #[inline]
    fn mul(self, rhs: Self) -> Self {
        self.compose(&rhs)
    }
}

impl<S: Real> Mul<Vector3<S>> for RxSO3<S> {
    type Output = Vector3<S>;
    #[inline]
    fn mul(self, p: Vector3<S>) -> Vector3<S> {
        self.act(&p)
    }
}
