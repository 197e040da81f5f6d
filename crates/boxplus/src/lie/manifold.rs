//! The weaker idea under a group: a space with ⊞ and ⊟.

use super::{Jacobian, LieGroup, Real, Tangent};
use core::fmt::Debug;

/// A D-dimensional manifold on which estimation can move: X ⊞ τ leads along a tangent, Y ⊟ X leads back.
///
/// Axioms (Hertzberg et al. (2013) (1)): X ⊞ 0 = X, X ⊞ (Y ⊟ X) = Y, (X ⊞ τ) ⊟ X = τ for τ near 0, and both are smooth
/// there. Every [`LieGroup`] is a manifold by its right (local) ⊞; unit directions or a user's own type implement this
/// trait alone.
pub trait Manifold<const D: usize>: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// The scalar the coordinates are written in.
    type Scalar: Real;
    /// The same manifold over another scalar.
    type Over<S: Real>: Manifold<D, Scalar = S>;

    /// X ⊞ τ.
    fn plus(&self, tau: &Tangent<Self::Scalar, D>) -> Self;
    /// Y ⊟ X with Y = `self`, X = `base`: the τ with X ⊞ τ = Y.
    fn minus(&self, base: &Self) -> Tangent<Self::Scalar, D>;
    /// X ⊞ τ: `(value, d_value_d_self, d_value_d_tau)`, tangents of the result being those of ⊞ at the result.
    fn plus_jac(
        &self,
        tau: &Tangent<Self::Scalar, D>,
    ) -> (Self, Jacobian<Self::Scalar, D>, Jacobian<Self::Scalar, D>);
    /// Y ⊟ X with Y = `self`, X = `base`: `(tau, d_tau_d_self, d_tau_d_base)`.
    fn minus_jac(
        &self,
        base: &Self,
    ) -> (Tangent<Self::Scalar, D>, Jacobian<Self::Scalar, D>, Jacobian<Self::Scalar, D>);
    /// The element with `f` applied to every stored number, e.g. to carry constants into dual numbers.
    fn map<S: Real>(&self, f: impl Fn(Self::Scalar) -> S) -> Self::Over<S>;
}

impl<G: LieGroup<D>, const D: usize> Manifold<D> for G {
    type Scalar = G::Scalar;
    type Over<S: Real> = G::Over<S>;

    #[inline]
    fn plus(&self, tau: &Tangent<G::Scalar, D>) -> Self {
        self.rplus(tau)
    }
    #[inline]
    fn minus(&self, base: &Self) -> Tangent<G::Scalar, D> {
        self.rminus(base)
    }
    #[inline]
    fn plus_jac(
        &self,
        tau: &Tangent<G::Scalar, D>,
    ) -> (Self, Jacobian<G::Scalar, D>, Jacobian<G::Scalar, D>) {
        self.rplus_jac(tau)
    }
    #[inline]
    fn minus_jac(
        &self,
        base: &Self,
    ) -> (Tangent<G::Scalar, D>, Jacobian<G::Scalar, D>, Jacobian<G::Scalar, D>) {
        self.rminus_jac(base)
    }
    #[inline]
    fn map<S: Real>(&self, f: impl Fn(G::Scalar) -> S) -> G::Over<S> {
        LieGroup::map(self, f)
    }
}
