//! S³: unit quaternions as a group, which covers SO(3) twice; and S¹, which is SO(2).
//!
//! q and −q are one rotation but two elements of S³: a turn by 2π leads to −1, only 4π back to 1. Everything local is that of
//! SO(3), with the same tangent, Exp φ = (sin(θ/2)·n, cos(θ/2)) (Solà et al. (2018), example 5), Ad = R(q), J_r as there; what
//! differs is the logarithm, which is unique and smooth up to θ = 2π, where SO(3) ends at π. So S³ is for following an
//! attitude that must not jump, [`S3::lift_near`]; for poses and measurements, which cannot tell q from −q, take [`SO3`].
//!
//! ```text
//! Log q = 2·Log √q,  √q = (q + 1)/|q + 1|: at most half a turn, wherever q is
//! ```
//!
//! In the plane the unit complex numbers S¹ cover SO(2) once: the same group with the same coordinates, [`S1`] is another name.
//!
//! Pitfalls. The tangent is the rotation vector, not the imaginary part of ln q, which is half of it. −1 has a logarithm
//! 2π·n for every n; ours is 2π·e_z.
//!
//! ```
//! use boxplus::lie::{LieGroup, S3, SO3};
//! use nalgebra::Vector3;
//! let step = Vector3::new(0.0, 0.0, 1.0);
//! let q: S3 = S3::exp(&(step * 4.0));
//! assert!((q.log() - step * 4.0).norm() < 1e-15); // beyond π
//! assert!((SO3::from(q).log() - step * (4.0 - std::f64::consts::TAU)).norm() < 1e-14);
//! ```

use crate::lie::{Action, LieError, LieGroup, Real, SO2, SO3};
use core::ops::{Mul, Neg};
use nalgebra::{Matrix3, Vector3};

/// The unit complex numbers: SO(2) by another name. `From` and `Into` lead to and from [`nalgebra::UnitComplex`].
pub type S1<S = f64> = SO2<S>;

/// A unit quaternion, told from its negative.
#[derive(Clone, Copy)]
#[cfg_attr(feature = "bytemuck", derive(bytemuck::TransparentWrapper))]
#[repr(transparent)]
pub struct S3<S = f64>(pub(in crate::lie) [S; 4]);

/// 2⁻⁶⁰: gives −1 an axis, and is far below the rounding of anything else.
const NUDGE: f64 = 1.0 / (1_u64 << 60) as f64;

impl<S: Real> S3<S> {
    #[inline]
    fn rotation(&self) -> SO3<S> {
        SO3(self.0)
    }

    /// The quaternion x·i + y·j + z·k + w, of any norm but 0, which is divided out.
    ///
    /// # Errors
    /// [`LieError::NotFinite`] or [`LieError::Zero`].
    pub fn from_xyzw(quaternion: [S; 4]) -> Result<Self, LieError> {
        Ok(Self((SO3::from_xyzw(quaternion)?).0))
    }

    /// \[x, y, z, w\].
    #[inline]
    pub fn quaternion_xyzw(&self) -> [S; 4] {
        self.rotation().quaternion_xyzw()
    }

    /// Of the two quaternions of `rotation` the one nearer to `self`: follows a rotation from step to step.
    pub fn lift_near(&self, rotation: &SO3<S>) -> Self {
        let lift = Self(rotation.0);
        let products = self.quaternion_xyzw().into_iter().zip(lift.quaternion_xyzw());
        let cos = products.fold(S::zero(), |sum, (a, b)| sum + a * b);
        if cos.value() < 0.0 { -lift } else { lift }
    }

    /// The same quaternion at unit norm to the last digit.
    pub fn normalize(&self) -> Self {
        Self(self.rotation().normalize().0)
    }
}

/// The rotation, the same for q and −q.
impl<S: Real> From<S3<S>> for SO3<S> {
    fn from(q: S3<S>) -> Self {
        q.rotation()
    }
}

/// Its stored quaternion, the sign of which is arbitrary; [`S3::lift_near`] chooses.
impl<S: Real> From<SO3<S>> for S3<S> {
    fn from(rotation: SO3<S>) -> Self {
        Self(rotation.0)
    }
}

impl<S: Real> PartialEq for S3<S> {
    fn eq(&self, other: &Self) -> bool {
        self.quaternion_xyzw() == other.quaternion_xyzw()
    }
}

/// The other quaternion of the same rotation.
impl<S: Real> Neg for S3<S> {
    type Output = Self;
    fn neg(self) -> Self {
        let [x, y, z, w] = self.quaternion_xyzw();
        Self((SO3::from_unit(-Vector3::new(x, y, z), -w)).0)
    }
}

impl<S: Real> LieGroup<3> for S3<S> {
    type Scalar = S;
    type Over<T: Real> = S3<T>;
    type Algebra = Matrix3<S>;

    #[inline]
    fn identity() -> Self {
        Self(SO3::identity().0)
    }
    #[inline]
    fn compose(&self, rhs: &Self) -> Self {
        Self(self.rotation().compose(&rhs.rotation()).0)
    }
    #[inline]
    fn inverse(&self) -> Self {
        Self(self.rotation().inverse().0)
    }
    #[inline]
    fn exp(phi: &Vector3<S>) -> Self {
        Self(SO3::exp(phi).0)
    }
    /// The tangent with θ ≤ 2π.
    #[inline]
    fn log(&self) -> Vector3<S> {
        let [x, y, z, w] = self.quaternion_xyzw();
        let (above, below) = (S::one() + w, S::one() - w);
        let v = Vector3::new(x, y, z + below * below * S::lit(NUDGE));
        // As |q| = 1, 1 + w = ½(|v|² + (1 + w)²), which cancels nothing near −1.
        let root = SO3::from_unit(v, (v.norm_squared() + above * above) * S::lit(0.5));
        root.normalize().log() * S::lit(2.0)
    }
    #[inline]
    fn adjoint(&self) -> Matrix3<S> {
        self.rotation().adjoint()
    }
    #[inline]
    fn small_adjoint(phi: &Vector3<S>) -> Matrix3<S> {
        SO3::small_adjoint(phi)
    }
    #[inline]
    fn right_jacobian(phi: &Vector3<S>) -> Matrix3<S> {
        SO3::right_jacobian(phi)
    }
    #[inline]
    fn right_jacobian_inverse(phi: &Vector3<S>) -> Matrix3<S> {
        SO3::right_jacobian_inverse(phi)
    }
    #[inline]
    fn right_jacobian_derivative(phi: &Vector3<S>, delta: &Vector3<S>) -> Matrix3<S> {
        super::second::so3(phi, delta)
    }
    fn hat(phi: &Vector3<S>) -> Matrix3<S> {
        SO3::hat(phi)
    }
    fn vee(algebra: &Matrix3<S>) -> Vector3<S> {
        SO3::vee(algebra)
    }
    fn map<T: Real>(&self, f: impl Fn(S) -> T) -> S3<T> {
        S3(self.rotation().map(f).0)
    }
}

/// q·p·q⁻¹.
impl<S: Real> Action<3, 3> for S3<S> {
    #[inline]
    fn act(&self, p: &Vector3<S>) -> Vector3<S> {
        self.rotation().act(p)
    }
    #[inline]
    fn linear_part(&self) -> Matrix3<S> {
        self.rotation().to_matrix()
    }
    #[inline]
    fn generators_at(p: &Vector3<S>) -> Matrix3<S> {
        SO3::generators_at(p)
    }
}

impl<S: Real> Mul for S3<S> {
    type Output = Self;
    #[inline]
    fn mul(self, rhs: Self) -> Self {
        self.compose(&rhs)
    }
}

impl<S: Real> Mul<Vector3<S>> for S3<S> {
    type Output = Vector3<S>;
    #[inline]
    fn mul(self, p: Vector3<S>) -> Vector3<S> {
        self.act(&p)
    }
}
