//! Lie groups: one trait here, one file per group in `groups`.
//!
//! A pose is not a vector: poses cannot be added, and three angles have no continuous chart. But near any pose the motions
//! form a vector space, the tangent, and Exp carries it onto the group. All of estimation needs only this: step along a
//! tangent (⊞), measure the tangent between two elements (⊟), and know the derivatives of both.
//!
//! ```text
//! X ⊞ τ = X·Exp(τ)    Y ⊟ X = Log(X⁻¹·Y)              Solà et al. (2018) (25), (26)
//! ```
//!
//! - **Side.** Perturbations are local (right), in the frame of the body. Global (left) ones are spelled out: `lplus`, `lminus`,
//!   `left_jacobian`, [`LeftJacobians`]. Both are linked by Ad: X·Exp(τ) = Exp(Ad_X τ)·X.
//! - **Order.** Tangents are (ρ, θ, …): metres, then radians, then whatever else the group moves.
//! - **Frames.** An element maps local to parent coordinates, `p_world = world_from_body * p_body`.
//! - **Accuracy.** Every map and Jacobian is within a few ε for every θ, in `f32` and `f64`: `docs/accuracy.md` states the
//!   bounds, `tests/reference` holds them.
//! - **Rotations** go in and out as Euler angles, quaternions of any convention and more: [`rotation`]. Directions are [`S2`].
//! - **Beyond the group laws**: [`distance`]s, the nearest element to a matrix (`project`), logarithms through many turns
//!   ([`log_near`]), random elements (`sample`, feature `rand`).
//! - **Averages**, weighted, robust, with their covariance: [`means`]. Second derivatives: [`second_order`]. Composition of tangents: [`bch`].
//! - **Your own group** writes the required items of [`LieGroup`] and is proved by one line of [`laws`].
//!
//! ```
//! use boxplus::lie::{LieGroup, SE3};
//! use nalgebra::Vector6;
//! let step = Vector6::new(1.0, 0.0, 0.0, 0.0, 0.0, 0.5); // forward 1 m, turning left by 0.5 rad
//! let start: SE3 = SE3::identity();
//! let end = start.rplus(&step).rplus(&step);
//! let (tau, d_tau_d_end, d_tau_d_start) = end.rminus_jac(&start);
//! assert!((tau - 2.0 * step).norm() < 1e-15);
//! assert!((d_tau_d_end * step - step).norm() < 1e-15); // a longer step of the same kind
//! assert!((d_tau_d_end * step + d_tau_d_start * step).norm() < 1e-15);
//! ```
#![allow(clippy::type_complexity)] // A value and one Jacobian per argument; naming each tuple would hide that.

mod action;
#[cfg(feature = "batch")]
mod batch;
pub mod bch;
mod bundle;
pub mod distance;
#[cfg(feature = "autodiff")]
mod dual;
mod elementary;
mod error;
mod groups;
#[cfg(feature = "batch")]
mod lanes;
pub mod laws;
mod left;
pub(crate) mod linear;
pub mod log_near;
mod manifold;
pub mod means;
mod nearest;
pub mod orders;
mod real;
pub mod rotation;
#[cfg(feature = "rand")]
pub mod sample;
pub mod second_order;
#[cfg(feature = "serde")]
pub mod serialize;
pub mod sphere;
mod stumpff;
mod unrolled;

pub use action::{Action, PointJac};
#[cfg(feature = "batch")]
pub use batch::{Batch, BatchGroup, LengthMismatch, Number};
pub use bch::{Bch, BchOrder};
pub use bundle::Block;
pub use distance::Distance;
pub use error::LieError;
pub use groups::{Plain, R3xSO3, Rn, RxSO2, RxSO3, S1, S3, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3};
#[cfg(feature = "bytemuck")]
pub use groups::{PlainSlices, SliceError};
pub use left::LeftJacobians;
pub use log_near::LogNear;
pub use manifold::Manifold;
pub use means::{ChordalMean, Mean, Means, Weights};
pub use orders::Order;
pub use real::{Blend, Real};
pub use rotation::{EulerAngles, EulerSequence, GimbalLock, SwingTwist};
#[cfg(feature = "rand")]
pub use sample::TangentSampler;
pub use sphere::S2;
pub use stumpff::Stumpff;

use core::fmt::Debug;
use nalgebra::{SMatrix, SVector};
use unrolled::{negated, unit};

/// A tangent vector τ ∈ ℝᴰ, (ρ, θ).
pub type Tangent<S, const D: usize> = SVector<S, D>;
/// A D×D Jacobian between tangent spaces.
pub type Jacobian<S, const D: usize> = SMatrix<S, D, D>;

/// A Lie group with tangent space ℝᴰ. A group file writes the required items; all else is derived here, once.
///
/// Operations ending in `_jac` return the value, then one right (local) Jacobian per argument, D×D, in the order of the
/// arguments; [`LeftJacobians`] has the same on the left.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a Lie group of dimension {D}",
    note = "the dimension is that of the tangent space: 3 for SE(2) and SO(3), 6 for SE(3), N for Rn<N>"
)]
pub trait LieGroup<const D: usize>: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// The scalar the coordinates are written in.
    type Scalar: Real;
    /// The same group over another scalar.
    type Over<S: Real>: LieGroup<D, Scalar = S>;
    /// An element of the Lie algebra as a matrix, τ^ (for ℝⁿ the vector itself).
    type Algebra;

    /// The neutral element.
    fn identity() -> Self;
    /// X·Y.
    fn compose(&self, rhs: &Self) -> Self;
    /// X⁻¹.
    fn inverse(&self) -> Self;
    /// Exp: ℝᴰ → G.
    fn exp(tau: &Tangent<Self::Scalar, D>) -> Self;
    /// Log: G → ℝᴰ, the shortest tangent. At θ = π both signs are right; ours is deterministic.
    fn log(&self) -> Tangent<Self::Scalar, D>;
    /// Ad_X, D×D: X·Exp(τ) = Exp(Ad_X τ)·X. Solà et al. (2018) (29).
    fn adjoint(&self) -> Jacobian<Self::Scalar, D>;
    /// ad_τ, D×D: ad_τ υ = [τ, υ].
    fn small_adjoint(tau: &Tangent<Self::Scalar, D>) -> Jacobian<Self::Scalar, D>;
    /// J_r(τ), D×D: Exp(τ + δ) ≈ Exp(τ)·Exp(J_r δ). Solà et al. (2018) (67).
    fn right_jacobian(tau: &Tangent<Self::Scalar, D>) -> Jacobian<Self::Scalar, D>;
    /// J_r(τ)⁻¹, D×D. Unbounded as θ → 2π.
    fn right_jacobian_inverse(tau: &Tangent<Self::Scalar, D>) -> Jacobian<Self::Scalar, D>;
    /// τ^, the tangent as an element of the algebra.
    fn hat(tau: &Tangent<Self::Scalar, D>) -> Self::Algebra;
    /// The tangent of an element of the algebra: vee(hat(τ)) = τ.
    fn vee(algebra: &Self::Algebra) -> Tangent<Self::Scalar, D>;
    /// The element with `f` applied to every stored number, e.g. to carry constants into dual numbers.
    fn map<S: Real>(&self, f: impl Fn(Self::Scalar) -> S) -> Self::Over<S>;

    /// X⁻¹·Y, Y = `other` seen from X.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn between(&self, other: &Self) -> Self {
        self.inverse().compose(other)
    }
    /// X ⊕ τ = X·Exp(τ), a step in the local frame. Solà et al. (2018) (25).
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn rplus(&self, tau: &Tangent<Self::Scalar, D>) -> Self {
        self.compose(&Self::exp(tau))
    }
    /// Y ⊖ X = Log(X⁻¹Y) with Y = `self`, X = `base`: the local step from X to Y. Solà et al. (2018) (26).
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn rminus(&self, base: &Self) -> Tangent<Self::Scalar, D> {
        base.between(self).log()
    }
    /// τ ⊕ X = Exp(τ)·X, a step in the global frame. Solà et al. (2018) (27).
    #[inline]
    fn lplus(&self, tau: &Tangent<Self::Scalar, D>) -> Self {
        Self::exp(tau).compose(self)
    }
    /// Log(YX⁻¹) with Y = `self`, X = `base`: the global step from X to Y. Solà et al. (2018) (28).
    #[inline]
    fn lminus(&self, base: &Self) -> Tangent<Self::Scalar, D> {
        self.compose(&base.inverse()).log()
    }
    /// X^α = Exp(α·Log X).
    #[inline]
    fn power(&self, alpha: Self::Scalar) -> Self {
        Self::exp(&(self.log() * alpha))
    }
    /// X·(X⁻¹Y)ᵗ, Y = `other`: X at t = 0, Y at t = 1, at constant velocity along the shortest way.
    #[inline]
    fn interpolate(&self, other: &Self, t: Self::Scalar) -> Self {
        self.compose(&self.between(other).power(t))
    }

    /// J_l(τ) = J_r(−τ), D×D: Exp(τ + δ) ≈ Exp(J_l δ)·Exp(τ). Solà et al. (2018) (71), (76).
    #[inline]
    fn left_jacobian(tau: &Tangent<Self::Scalar, D>) -> Jacobian<Self::Scalar, D> {
        Self::right_jacobian(&-tau)
    }
    /// J_l(τ)⁻¹ = J_r(−τ)⁻¹, D×D. Unbounded as θ → 2π.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn left_jacobian_inverse(tau: &Tangent<Self::Scalar, D>) -> Jacobian<Self::Scalar, D> {
        Self::right_jacobian_inverse(&-tau)
    }
    /// Ad_X·τ, without the matrix where that is cheaper: the local step τ, seen from the global frame.
    #[inline]
    fn adjoint_times(&self, tau: &Tangent<Self::Scalar, D>) -> Tangent<Self::Scalar, D> {
        self.adjoint() * tau
    }

    /// D J_r(τ)\[δ\], D×D: d/dt J_r(τ + tδ) at t = 0, linear in δ; the second derivative of Exp. See [`second_order`].
    /// For single numbers where the group has no closed form.
    fn right_jacobian_derivative(
        tau: &Tangent<Self::Scalar, D>,
        delta: &Tangent<Self::Scalar, D>,
    ) -> Jacobian<Self::Scalar, D> {
        second_order::left_jacobian_derivative::<Self, D>(&-tau, &-delta)
    }
    /// D J_r⁻¹(τ)\[δ\] = −J_r⁻¹·D J_r\[δ\]·J_r⁻¹, D×D; the second derivative of Log. Unbounded as θ → 2π.
    #[inline]
    fn right_jacobian_inverse_derivative(
        tau: &Tangent<Self::Scalar, D>,
        delta: &Tangent<Self::Scalar, D>,
    ) -> Jacobian<Self::Scalar, D> {
        let inverse = Self::right_jacobian_inverse(tau);
        -(inverse * Self::right_jacobian_derivative(tau, delta) * inverse)
    }
    /// \[a, b\] = vee(a^·b^ − b^·a^) = ad_a·b.
    #[inline]
    fn bracket(a: &Tangent<Self::Scalar, D>, b: &Tangent<Self::Scalar, D>) -> Tangent<Self::Scalar, D> {
        Self::small_adjoint(a) * b
    }

    /// Whether no coordinate of X ⊖ Y exceeds `tolerance`, with X = `self`, Y = `other`: equal in the sense of the group, q and −q
    /// being one rotation. Metres and radians are held to the same number; false where anything is NaN.
    ///
    /// ```
    /// use boxplus::lie::{LieGroup, SO3};
    /// let x = SO3::from_xyzw([0.1, 0.2, 0.3, 0.9])?;
    /// let negated = SO3::from_xyzw([-0.1, -0.2, -0.3, -0.9])?;
    /// assert!(x.is_near(&negated, 1e-15));
    /// # Ok::<(), boxplus::lie::LieError>(())
    /// ```
    fn is_near(&self, other: &Self, tolerance: f64) -> bool {
        self.rminus(other).iter().all(|x| x.value().abs() <= tolerance)
    }
    /// The basis Eᵢ = eᵢ^ of the algebra: τ^ = Σ τᵢEᵢ. Solà et al. (2018) (10).
    fn generators() -> [Self::Algebra; D] {
        core::array::from_fn(|i| {
            let mut e = Tangent::<Self::Scalar, D>::zeros();
            e[i] = Self::Scalar::lit(1.0);
            Self::hat(&e)
        })
    }

    /// X⁻¹: `(value, −Ad_X)`. Solà et al. (2018) (62).
    #[inline]
    fn inverse_jac(&self) -> (Self, Jacobian<Self::Scalar, D>) {
        (self.inverse(), negated(self.adjoint()))
    }
    /// X·Y: `(value, Ad_{Y⁻¹}, I)`. Solà et al. (2018) (63), (64).
    #[inline]
    fn compose_jac(&self, rhs: &Self) -> (Self, Jacobian<Self::Scalar, D>, Jacobian<Self::Scalar, D>) {
        (self.compose(rhs), rhs.inverse().adjoint(), unit())
    }
    /// X⁻¹Y: `(value, −Ad_{Y⁻¹X}, I)`.
    #[inline]
    fn between_jac(&self, other: &Self) -> (Self, Jacobian<Self::Scalar, D>, Jacobian<Self::Scalar, D>) {
        let value = self.between(other);
        (value, negated(value.inverse().adjoint()), unit())
    }
    /// Exp τ: `(value, J_r(τ))`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn exp_jac(tau: &Tangent<Self::Scalar, D>) -> (Self, Jacobian<Self::Scalar, D>) {
        (Self::exp(tau), Self::right_jacobian(tau))
    }
    /// τ = Log X: `(τ, J_r⁻¹(τ))`. Solà et al. (2018) (79).
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn log_jac(&self) -> (Tangent<Self::Scalar, D>, Jacobian<Self::Scalar, D>) {
        let (tau, right, _) = self.log_jacs();
        (tau, right)
    }
    /// τ = Log X with both inverse Jacobians, which share their coefficients: `(τ, J_r⁻¹(τ), J_l⁻¹(τ))`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn log_jacs(&self) -> (Tangent<Self::Scalar, D>, Jacobian<Self::Scalar, D>, Jacobian<Self::Scalar, D>) {
        let tau = self.log();
        (tau, Self::right_jacobian_inverse(&tau), Self::left_jacobian_inverse(&tau))
    }
    /// X·Exp τ: `(value, Ad_{Exp(−τ)}, J_r(τ))`. Solà et al. (2018) (80), (81).
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn rplus_jac(
        &self,
        tau: &Tangent<Self::Scalar, D>,
    ) -> (Self, Jacobian<Self::Scalar, D>, Jacobian<Self::Scalar, D>) {
        let (step, d_tau) = Self::exp_jac(tau);
        (self.compose(&step), step.inverse().adjoint(), d_tau)
    }
    /// τ = Y ⊖ X with Y = `self`, X = `base`: `(τ, J_r⁻¹(τ), −J_l⁻¹(τ))`. Solà et al. (2018) (82), (83).
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn rminus_jac(
        &self,
        base: &Self,
    ) -> (Tangent<Self::Scalar, D>, Jacobian<Self::Scalar, D>, Jacobian<Self::Scalar, D>) {
        let (tau, right, left) = base.between(self).log_jacs();
        (tau, right, negated(left))
    }
    /// Exp(τ)·X: `(value, I, Ad_{X⁻¹}·J_r(τ))`, in the order (X, τ).
    #[inline]
    fn lplus_jac(
        &self,
        tau: &Tangent<Self::Scalar, D>,
    ) -> (Self, Jacobian<Self::Scalar, D>, Jacobian<Self::Scalar, D>) {
        let (step, d_tau) = Self::exp_jac(tau);
        (step.compose(self), unit(), self.inverse().adjoint() * d_tau)
    }
    /// τ = Log(YX⁻¹) with Y = `self`, X = `base`: `(τ, J_r⁻¹(τ)·Ad_X, −J_r⁻¹(τ)·Ad_X)`.
    #[inline]
    fn lminus_jac(
        &self,
        base: &Self,
    ) -> (Tangent<Self::Scalar, D>, Jacobian<Self::Scalar, D>, Jacobian<Self::Scalar, D>) {
        let (tau, right) = self.compose(&base.inverse()).log_jac();
        let d_self = right * base.adjoint();
        (tau, d_self, negated(d_self))
    }
    /// X^α: `(value, α·J_r(ατ)·J_r⁻¹(τ), τ)` with τ = Log X, in the order (X, α).
    #[inline]
    fn power_jac(&self, alpha: Self::Scalar) -> (Self, Jacobian<Self::Scalar, D>, Tangent<Self::Scalar, D>) {
        let (tau, inverse) = self.log_jac();
        let (value, right) = Self::exp_jac(&(tau * alpha));
        (value, right * inverse * alpha, tau)
    }
    /// [`LieGroup::interpolate`]: `(value, d_value_d_self, d_value_d_other, d_value_d_t)`, the last D×1: the velocity.
    #[inline]
    fn interpolate_jac(
        &self,
        other: &Self,
        t: Self::Scalar,
    ) -> (Self, Jacobian<Self::Scalar, D>, Jacobian<Self::Scalar, D>, Tangent<Self::Scalar, D>) {
        // Z = X·Wᵗ with W = X⁻¹Y: ∂W/∂X = −Ad_{W⁻¹}, ∂W/∂Y = I.
        let w = self.between(other);
        let (step, d_step, tau) = w.power_jac(t);
        let d_self = step.inverse().adjoint() - d_step * w.inverse().adjoint();
        (self.compose(&step), d_self, d_step, tau)
    }
}
