//! The Jacobians once more, with perturbations on the left (global, Exp(δ)·X) at input and output.
//!
//! Right and left differ by adjoints: for y = f(X) with right Jacobian J, the left one is Ad_y·J·Ad_X⁻¹
//! (Solà et al. (2018) (46)); vectors have Ad = I. The closed forms below need at most one product.

use super::{Jacobian, LieGroup, Tangent};
use nalgebra::SMatrix;

/// Left (global) Jacobians of every operation, for every group. D×D each, in the order of the arguments.
///
/// ```
/// use boxplus::lie::{LeftJacobians, LieGroup, SO3};
/// use nalgebra::Vector3;
/// let x = SO3::exp(&Vector3::new(0.1, -0.2, 0.3));
/// let (_, right) = x.inverse_jac();
/// let (_, left) = x.inverse_left_jac();
/// let converted = x.inverse().output_to_left(&x.input_to_left(&right));
/// assert!((left - converted).amax() < 1e-15);
/// ```
pub trait LeftJacobians<const D: usize>: LieGroup<D> {
    /// X⁻¹: `(value, −Ad_{X⁻¹})`.
    #[inline]
    fn inverse_left_jac(&self) -> (Self, Jacobian<Self::Scalar, D>) {
        let inverse = self.inverse();
        (inverse, -inverse.adjoint())
    }
    /// X·Y: `(value, I, Ad_X)`.
    #[inline]
    fn compose_left_jac(&self, rhs: &Self) -> (Self, Jacobian<Self::Scalar, D>, Jacobian<Self::Scalar, D>) {
        (self.compose(rhs), SMatrix::identity(), self.adjoint())
    }
    /// X⁻¹Y: `(value, −Ad_{X⁻¹}, Ad_{X⁻¹})`.
    #[inline]
    fn between_left_jac(&self, other: &Self) -> (Self, Jacobian<Self::Scalar, D>, Jacobian<Self::Scalar, D>) {
        let ad = self.inverse().adjoint();
        (self.between(other), -ad, ad)
    }
    /// Exp τ: `(value, J_l(τ))`.
    #[inline]
    fn exp_left_jac(tau: &Tangent<Self::Scalar, D>) -> (Self, Jacobian<Self::Scalar, D>) {
        (Self::exp(tau), Self::left_jacobian(tau))
    }
    /// τ = Log X: `(τ, J_l⁻¹(τ))`.
    #[inline]
    fn log_left_jac(&self) -> (Tangent<Self::Scalar, D>, Jacobian<Self::Scalar, D>) {
        let (tau, _, left) = self.log_jacs();
        (tau, left)
    }
    /// X·Exp τ: `(value, I, Ad_X·J_l(τ))`.
    #[inline]
    fn rplus_left_jac(
        &self,
        tau: &Tangent<Self::Scalar, D>,
    ) -> (Self, Jacobian<Self::Scalar, D>, Jacobian<Self::Scalar, D>) {
        (self.rplus(tau), SMatrix::identity(), self.adjoint() * Self::left_jacobian(tau))
    }
    /// τ = Log(X⁻¹Y), Y = `self`, X = `base`: `(τ, J_l⁻¹(τ)·Ad_{X⁻¹}, −J_l⁻¹(τ)·Ad_{X⁻¹})`.
    #[inline]
    fn rminus_left_jac(
        &self,
        base: &Self,
    ) -> (Tangent<Self::Scalar, D>, Jacobian<Self::Scalar, D>, Jacobian<Self::Scalar, D>) {
        let inverse = base.inverse();
        let (tau, left) = inverse.compose(self).log_left_jac();
        let d_self = left * inverse.adjoint();
        (tau, d_self, -d_self)
    }
    /// Exp(τ)·X: `(value, Ad_{Exp τ}, J_l(τ))`, in the order (X, τ).
    #[inline]
    fn lplus_left_jac(
        &self,
        tau: &Tangent<Self::Scalar, D>,
    ) -> (Self, Jacobian<Self::Scalar, D>, Jacobian<Self::Scalar, D>) {
        let step = Self::exp(tau);
        (step.compose(self), step.adjoint(), Self::left_jacobian(tau))
    }
    /// τ = Log(YX⁻¹), Y = `self`, X = `base`: `(τ, J_l⁻¹(τ), −J_r⁻¹(τ))`.
    #[inline]
    fn lminus_left_jac(
        &self,
        base: &Self,
    ) -> (Tangent<Self::Scalar, D>, Jacobian<Self::Scalar, D>, Jacobian<Self::Scalar, D>) {
        let (tau, right, left) = self.compose(&base.inverse()).log_jacs();
        (tau, left, -right)
    }
    /// X^α: `(value, α·J_l(ατ)·J_l⁻¹(τ), τ)` with τ = Log X, in the order (X, α).
    #[inline]
    fn power_left_jac(
        &self,
        alpha: Self::Scalar,
    ) -> (Self, Jacobian<Self::Scalar, D>, Tangent<Self::Scalar, D>) {
        let (tau, left) = self.log_left_jac();
        let scaled = tau * alpha;
        (Self::exp(&scaled), Self::left_jacobian(&scaled) * left * alpha, tau)
    }
    /// [`LieGroup::interpolate`]: `(value, d_value_d_self, d_value_d_other, d_value_d_t)`.
    #[inline]
    fn interpolate_left_jac(
        &self,
        other: &Self,
        t: Self::Scalar,
    ) -> (Self, Jacobian<Self::Scalar, D>, Jacobian<Self::Scalar, D>, Tangent<Self::Scalar, D>) {
        // Z = W^t·X with W = YX⁻¹: ∂Z/∂Y = ∂W^t/∂W, and X enters W from the right, hence Ad_W and the sign.
        let w = other.compose(&self.inverse());
        let (step, d_step, tau) = w.power_left_jac(t);
        (step.compose(self), step.adjoint() - d_step * w.adjoint(), d_step, tau)
    }

    /// ∂y/∂X for X perturbed on the left, from the same Jacobian for X perturbed on the right: J·Ad_X⁻¹, M×D.
    #[inline]
    fn input_to_left<const M: usize>(
        &self,
        right: &SMatrix<Self::Scalar, M, D>,
    ) -> SMatrix<Self::Scalar, M, D> {
        right * self.inverse().adjoint()
    }
    /// Inverse of [`LeftJacobians::input_to_left`]: J·Ad_X, M×D.
    #[inline]
    fn input_to_right<const M: usize>(
        &self,
        left: &SMatrix<Self::Scalar, M, D>,
    ) -> SMatrix<Self::Scalar, M, D> {
        left * self.adjoint()
    }
    /// ∂X/∂z with the tangent of X = `self` on the left, from the one on the right: Ad_X·J, D×N.
    #[inline]
    fn output_to_left<const N: usize>(
        &self,
        right: &SMatrix<Self::Scalar, D, N>,
    ) -> SMatrix<Self::Scalar, D, N> {
        self.adjoint() * right
    }
    /// Inverse of [`LeftJacobians::output_to_left`]: Ad_X⁻¹·J, D×N.
    #[inline]
    fn output_to_right<const N: usize>(
        &self,
        left: &SMatrix<Self::Scalar, D, N>,
    ) -> SMatrix<Self::Scalar, D, N> {
        self.inverse().adjoint() * left
    }
    /// The covariance of X = `self` perturbed on the left, from that of X perturbed on the right: Ad_X·Σ·Ad_Xᵀ, D×D.
    /// Exact, Solà et al. (2018) (54).
    #[inline]
    fn covariance_to_left(&self, right: &Jacobian<Self::Scalar, D>) -> Jacobian<Self::Scalar, D> {
        let ad = self.adjoint();
        ad * right * ad.transpose()
    }
    /// Inverse of [`LeftJacobians::covariance_to_left`]: Ad_X⁻¹·Σ·Ad_X⁻ᵀ, D×D.
    #[inline]
    fn covariance_to_right(&self, left: &Jacobian<Self::Scalar, D>) -> Jacobian<Self::Scalar, D> {
        self.inverse().covariance_to_left(left)
    }
}

impl<G: LieGroup<D>, const D: usize> LeftJacobians<D> for G {}
