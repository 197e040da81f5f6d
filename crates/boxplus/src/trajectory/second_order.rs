//! How the right Jacobian itself bends: ∂(J_r(τ)·v)/∂τ on any group, from its brackets alone.

use crate::lie::{Jacobian, LieGroup, Real, Tangent};
use nalgebra::SMatrix;

/// Halvings before the series: |φ| ≤ 2π becomes ≤ 0.79.
const HALVINGS: u32 = 3;
/// 0.79ⁿ/(n + 1)! < ε/100 from n = 15 on.
const TERMS: usize = 16;

/// F(τ, v) = ∂(J_r(τ)·v)/∂τ, D×D, for |φ| ≤ 2π.
///
/// ```text
/// J_r(τ)v = Σ tₙ/(n + 1)!    t₀ = v, tₙ = −ad_τ·tₙ₋₁ = ad(tₙ₋₁)·τ        ∂tₙ/∂τ = ad(tₙ₋₁) − ad_τ·∂tₙ₋₁/∂τ
/// J_r(2τ)v = ½(I + E)·J_r(τ)v                        E = Ad(Exp(−τ)) = I − ad_τ·J_r(τ)
/// F(2τ, v) = ¼[(I + E)·F(τ, v) + ad(E·J_r(τ)v)·J_r(τ)]
/// ```
/// The series where it is short, then doubled: no case apart at τ = 0, no cancellation.
pub(super) fn right_jacobian_bend<G: LieGroup<D>, const D: usize>(
    tau: &Tangent<G::Scalar, D>,
    v: &Tangent<G::Scalar, D>,
) -> Jacobian<G::Scalar, D> {
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
    bend
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

/// \[∂(F(τ, v)·v)/∂τ, ∂(F(τ, v)·v)/∂v\] for |φ| ≤ π: how the acceleration of Exp(τ + vt) answers to τ and to v.
///
/// With tₙ as above and sₙ = ∂tₙ/∂τ·v = −\[v, tₙ₋₁\] − \[τ, sₙ₋₁\], F(τ, v)·v = Σ sₙ/(n + 1)!, differentiated term by term.
pub(super) fn second_bend<G: LieGroup<D>, const D: usize>(
    tau: &Tangent<G::Scalar, D>,
    v: &Tangent<G::Scalar, D>,
) -> [Jacobian<G::Scalar, D>; 2] {
    // n²πⁿ⁻²/(n + 1)! < ε/100 from n = 29 on.
    const LONG: usize = 30;
    let zero = Jacobian::<G::Scalar, D>::zeros();
    let (ad, along) = (G::small_adjoint(tau), G::small_adjoint(v));
    let (mut t, mut s) = (*v, Tangent::<G::Scalar, D>::zeros());
    let (mut t_tau, mut t_v) = (zero, Jacobian::<G::Scalar, D>::identity());
    let (mut s_tau, mut s_v) = (zero, zero);
    let mut sum = [zero; 2];
    let mut reciprocal = 1.0;
    for n in 1..=LONG {
        let ad_t = G::small_adjoint(&t);
        (s_tau, s_v) = (G::small_adjoint(&s) - along * t_tau - ad * s_tau, ad_t - along * t_v - ad * s_v);
        s = -(along * t + ad * s);
        (t_tau, t_v) = (ad_t - ad * t_tau, -(ad * t_v));
        t = -(ad * t);
        reciprocal /= (n + 1) as f64;
        sum[0] += s_tau * G::Scalar::lit(reciprocal);
        sum[1] += s_v * G::Scalar::lit(reciprocal);
    }
    sum
}
