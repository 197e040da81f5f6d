//! Lie groups: one trait here, one file per group.
//!
//! Perturbations are local (right): X ⊞ τ = X·Exp(τ), Y ⊟ X = Log(X⁻¹Y), Solà et al. (2018) (25), (26).
//! Tangents are ordered (ρ, θ): metres, then radians.

mod real;

pub use real::Real;

use core::fmt::Debug;
use nalgebra::{SMatrix, SVector};

/// A Lie group with tangent space ℝᴰ. A group file writes the required items; all else is derived here, once.
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
    fn exp(tau: &SVector<Self::Scalar, D>) -> Self;
    /// Log: G → ℝᴰ, the shortest tangent. At θ = π both signs are right; ours is deterministic.
    fn log(&self) -> SVector<Self::Scalar, D>;
    /// Ad_X, D×D: X·Exp(τ) = Exp(Ad_X τ)·X. Solà et al. (2018) (29).
    fn adjoint(&self) -> SMatrix<Self::Scalar, D, D>;
    /// ad_τ, D×D: ad_τ υ = [τ, υ].
    fn small_adjoint(tau: &SVector<Self::Scalar, D>) -> SMatrix<Self::Scalar, D, D>;
    /// J_r(τ), D×D: Exp(τ + δ) ≈ Exp(τ)·Exp(J_r δ). Solà et al. (2018) (67).
    fn right_jacobian(tau: &SVector<Self::Scalar, D>) -> SMatrix<Self::Scalar, D, D>;
    /// J_r(τ)⁻¹, D×D. Unbounded as θ → 2π.
    fn right_jacobian_inverse(tau: &SVector<Self::Scalar, D>) -> SMatrix<Self::Scalar, D, D>;
    /// τ^, the tangent as an element of the algebra.
    fn hat(tau: &SVector<Self::Scalar, D>) -> Self::Algebra;
    /// The tangent of an element of the algebra: vee(hat(τ)) = τ.
    fn vee(algebra: &Self::Algebra) -> SVector<Self::Scalar, D>;
    /// The element with `f` applied to every stored number, e.g. to carry constants into dual numbers.
    fn map<S: Real>(&self, f: impl Fn(Self::Scalar) -> S) -> Self::Over<S>;
}
