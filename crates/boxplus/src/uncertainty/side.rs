//! On which side of the mean the error stands: a type, so that a covariance cannot be read on the wrong one.

use crate::lie::{Jacobian, LieGroup, Tangent};
use core::fmt::Debug;

/// The side of the perturbation, [`Local`] or [`Global`]; sealed, there is no third.
///
/// ```text
///                               Local               Global
/// X from X̄ and ξ                X̄·Exp(ξ)            Exp(ξ)·X̄           Barfoot (2024) (8.37)
/// ξ of X about X̄                Log(X̄⁻¹X)           Log(XX̄⁻¹)
/// Exp(τ+δ) from Exp(τ), J·δ     J = J_r(τ)          J = J_l(τ)
/// A known, ξ of A·X             ξ                   Ad_A ξ             Barfoot (2024) (8.39), (8.40)
/// B known, ξ of X·B             Ad_B⁻¹ ξ            ξ
/// ξ on the other side           Ad_X̄ ξ              Ad_X̄⁻¹ ξ           Solà et al. (2018) (54): exact
/// ```
///
/// The left-invariant error X̄⁻¹X of Barrau & Bonnabel (2017) is the *local* one, the right-invariant XX̄⁻¹ the *global* one.
pub trait Side: sealed::Sealed + Copy + Debug + Default + PartialEq + Send + Sync + 'static {
    /// The other side.
    type Opposite: Side<Opposite = Self>;

    /// X from its mean and its error.
    fn perturb<G: LieGroup<D>, const D: usize>(mean: &G, xi: &Tangent<G::Scalar, D>) -> G;
    /// The error of `x` about `mean`; the shortest one.
    fn error<G: LieGroup<D>, const D: usize>(x: &G, mean: &G) -> Tangent<G::Scalar, D>;
    /// J(τ), D×D: an error τ + δ about X̄ is the error J(τ)·δ about the element with error τ, to first order in δ.
    fn jacobian<G: LieGroup<D>, const D: usize>(tau: &Tangent<G::Scalar, D>) -> Jacobian<G::Scalar, D>;
    /// J(τ)⁻¹, D×D.
    fn jacobian_inverse<G: LieGroup<D>, const D: usize>(
        tau: &Tangent<G::Scalar, D>,
    ) -> Jacobian<G::Scalar, D>;
    /// D×D: from the error of X to that of A·X, A = `known`. Exact.
    fn under_left_factor<G: LieGroup<D>, const D: usize>(known: &G) -> Jacobian<G::Scalar, D>;
    /// D×D: from the error of X to that of X·B, B = `known`. Exact.
    fn under_right_factor<G: LieGroup<D>, const D: usize>(known: &G) -> Jacobian<G::Scalar, D>;
    /// D×D: from the error on this side to the error on the other. Exact.
    fn to_opposite<G: LieGroup<D>, const D: usize>(mean: &G) -> Jacobian<G::Scalar, D>;
    /// `(before, after)` with X = after·Exp(ξ)·before: one is X̄, the other the identity.
    fn around<G: LieGroup<D>, const D: usize>(mean: &G) -> (G, G);
    /// D×D: the error of X⁻¹ is minus this times the error of X. Exact.
    fn under_inverse<G: LieGroup<D>, const D: usize>(mean: &G) -> Jacobian<G::Scalar, D> {
        // X⁻¹ = Exp(−ξ)·X̄⁻¹ from the local ξ: the inverse changes the side, and the conversion changes it back.
        Self::to_opposite(mean)
    }
}

/// Errors in the frame of the body: X = X̄·Exp(ξ). The default, as everywhere in the library.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Local;

/// Errors in the frame of the parent: X = Exp(ξ)·X̄.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Global;

mod sealed {
    pub trait Sealed {}
    impl Sealed for super::Local {}
    impl Sealed for super::Global {}
}

impl Side for Local {
    type Opposite = Global;

    fn perturb<G: LieGroup<D>, const D: usize>(mean: &G, xi: &Tangent<G::Scalar, D>) -> G {
        mean.rplus(xi)
    }
    fn error<G: LieGroup<D>, const D: usize>(x: &G, mean: &G) -> Tangent<G::Scalar, D> {
        x.rminus(mean)
    }
    fn jacobian<G: LieGroup<D>, const D: usize>(tau: &Tangent<G::Scalar, D>) -> Jacobian<G::Scalar, D> {
        G::right_jacobian(tau)
    }
    fn jacobian_inverse<G: LieGroup<D>, const D: usize>(
        tau: &Tangent<G::Scalar, D>,
    ) -> Jacobian<G::Scalar, D> {
        G::right_jacobian_inverse(tau)
    }
    fn under_left_factor<G: LieGroup<D>, const D: usize>(_: &G) -> Jacobian<G::Scalar, D> {
        Jacobian::identity()
    }
    fn under_right_factor<G: LieGroup<D>, const D: usize>(known: &G) -> Jacobian<G::Scalar, D> {
        known.inverse().adjoint()
    }
    fn to_opposite<G: LieGroup<D>, const D: usize>(mean: &G) -> Jacobian<G::Scalar, D> {
        mean.adjoint()
    }
    fn around<G: LieGroup<D>, const D: usize>(mean: &G) -> (G, G) {
        (G::identity(), *mean)
    }
}

impl Side for Global {
    type Opposite = Local;

    fn perturb<G: LieGroup<D>, const D: usize>(mean: &G, xi: &Tangent<G::Scalar, D>) -> G {
        mean.lplus(xi)
    }
    fn error<G: LieGroup<D>, const D: usize>(x: &G, mean: &G) -> Tangent<G::Scalar, D> {
        x.lminus(mean)
    }
    fn jacobian<G: LieGroup<D>, const D: usize>(tau: &Tangent<G::Scalar, D>) -> Jacobian<G::Scalar, D> {
        G::left_jacobian(tau)
    }
    fn jacobian_inverse<G: LieGroup<D>, const D: usize>(
        tau: &Tangent<G::Scalar, D>,
    ) -> Jacobian<G::Scalar, D> {
        G::left_jacobian_inverse(tau)
    }
    fn under_left_factor<G: LieGroup<D>, const D: usize>(known: &G) -> Jacobian<G::Scalar, D> {
        known.adjoint()
    }
    fn under_right_factor<G: LieGroup<D>, const D: usize>(_: &G) -> Jacobian<G::Scalar, D> {
        Jacobian::identity()
    }
    fn to_opposite<G: LieGroup<D>, const D: usize>(mean: &G) -> Jacobian<G::Scalar, D> {
        mean.inverse().adjoint()
    }
    fn around<G: LieGroup<D>, const D: usize>(mean: &G) -> (G, G) {
        (*mean, G::identity())
    }
}
