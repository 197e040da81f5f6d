//! How the right Jacobian itself bends: ∂(J_r(τ)·v)/∂τ on any group, from its brackets alone.

use crate::lie::{Jacobian, LieGroup, Real, Tangent};
use nalgebra::SMatrix;

/// Halvings before the series: |φ| ≤ 2π becomes ≤ 0.79.
const HALVINGS: u32 = 3;
/// 0.79ⁿ/(n + 1)! < ε/100 from n = 15 on.
const TERMS: usize = 16;

/// J_r(τ)·v and F(τ, v) = ∂(J_r(τ)·v)/∂τ, D×D, for |φ| ≤ 2π.
///
/// ```text
/// J_r(τ)v = Σ tₙ/(n + 1)!    t₀ = v, tₙ = −ad_τ·tₙ₋₁ = ad(tₙ₋₁)·τ        ∂tₙ/∂τ = ad(tₙ₋₁) − ad_τ·∂tₙ₋₁/∂τ
/// J_r(2τ)v = ½(I + E)·J_r(τ)v                        E = Ad(Exp(−τ)) = I − ad_τ·J_r(τ)
/// F(2τ, v) = ¼[(I + E)·F(τ, v) + ad(E·J_r(τ)v)·J_r(τ)]
/// ```
/// The series where it is short, then doubled: no case apart at τ = 0, no cancellation.
pub(super) fn right_jacobian_product<G: LieGroup<D>, const D: usize>(
    tau: &Tangent<G::Scalar, D>,
    v: &Tangent<G::Scalar, D>,
) -> (Tangent<G::Scalar, D>, Jacobian<G::Scalar, D>) {
    let lit = G::Scalar::lit;
    let identity = Jacobian::<G::Scalar, D>::identity();
    let part = tau * lit(1.0 / f64::from(1_u32 << HALVINGS));
    let (mut product, mut bend) = series::<G, D>(&part, v);
    let mut jacobian = G::right_jacobian(&part);
    let mut turn = identity - G::small_adjoint(&part) * jacobian;
    for _ in 0..HALVINGS {
        let both = identity + turn;
        let seen = turn * product;
        bend = (both * bend + G::small_adjoint(&seen) * jacobian) * lit(0.25);
        product = (product + seen) * lit(0.5);
        jacobian = both * jacobian * lit(0.5);
        turn *= turn;
    }
    (product, bend)
}

/// The two power series.
fn series<G: LieGroup<D>, const D: usize>(
    tau: &Tangent<G::Scalar, D>,
    v: &Tangent<G::Scalar, D>,
) -> (Tangent<G::Scalar, D>, Jacobian<G::Scalar, D>) {
    let ad = G::small_adjoint(tau);
    let (mut term, mut d_term) = (*v, SMatrix::zeros());
    let (mut sum, mut d_sum) = (*v, SMatrix::zeros());
    let mut reciprocal = 1.0;
    for n in 1..=TERMS {
        d_term = G::small_adjoint(&term) - ad * d_term;
        term = -(ad * term);
        reciprocal /= (n + 1) as f64;
        sum += term * G::Scalar::lit(reciprocal);
        d_sum += d_term * G::Scalar::lit(reciprocal);
    }
    (sum, d_sum)
}

/// ∂(J_r⁻¹(τ)·ω)/∂τ = −J_r⁻¹(τ)·F(τ, g), D×D, given J_r⁻¹(τ) and g = J_r⁻¹(τ)·ω.
pub(super) fn rate_jac<G: LieGroup<D>, const D: usize>(
    tau: &Tangent<G::Scalar, D>,
    inverse: &Jacobian<G::Scalar, D>,
    rate: &Tangent<G::Scalar, D>,
) -> Jacobian<G::Scalar, D> {
    let (_, bend) = right_jacobian_product::<G, D>(tau, rate);
    -(inverse * bend)
}
