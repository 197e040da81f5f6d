//! Second derivatives: how the Jacobian of Exp changes along a tangent, and the Hessian of a squared distance.
//!
//! ```text
//! D J_r(τ)[δ] = d/dt J_r(τ + tδ) at t = 0, D×D, linear in δ           D J_r⁻¹[δ] = −J_r⁻¹·D J_r[δ]·J_r⁻¹
//! Log(X·Exp u) = τ + J_r⁻¹u + ½·D J_r⁻¹(τ)[J_r⁻¹u]·u + O(u³),  τ = Log X
//! ```
//!
//! [`LieGroup::right_jacobian_derivative`] has closed forms on SO(2), SO(3), SE(2), SE(3), SE₂(3), whose Stumpff functions
//! differentiate into one another, (1/θ)·dc_k/dθ = k·c_{k+2} − c_{k+1}. Every other group has the exact series here: J_l = Σ adᵏ/(k + 1)!
//! of a tangent halved until it is short, differentiated term by term, and doubled with the derivative of
//! J_l(2ξ) = ½(I + Ad_{Exp ξ})·J_l(ξ). Neither loses digits at θ = 0 or at π.
//!
//! ```
//! use boxplus::lie::{LieGroup, SO3};
//! use nalgebra::Vector3;
//! let (tau, delta) = (Vector3::new(0.3, -0.2, 0.5), Vector3::new(1.0, 2.0, -1.0));
//! let derivative = SO3::right_jacobian_derivative(&tau, &delta);
//! let h = 1e-5; // h²/6 ≈ ε/h ≈ 2e-11
//! let [ahead, behind] = [h, -h].map(|t| SO3::right_jacobian(&(tau + delta * t)));
//! assert!(((ahead - behind) / (2.0 * h) - derivative).amax() < 1e-10);
//! ```

use super::{Jacobian, LieGroup, Real, Tangent};
use nalgebra::SMatrix;

/// Terms of the series for |ad| ≤ ½: ½¹⁶/17! < 5·10⁻²⁰.
const TERMS: usize = 16;

/// D J_l(ξ)[δ] of any group. For single numbers: what the halvings are is read off the values.
pub(super) fn left_jacobian_derivative<G: LieGroup<D>, const D: usize>(
    xi: &Tangent<G::Scalar, D>,
    delta: &Tangent<G::Scalar, D>,
) -> Jacobian<G::Scalar, D> {
    let (lit, identity) = (G::Scalar::lit, SMatrix::identity());
    let halvings = halvings(&G::small_adjoint(xi));
    let mut scale = lit((0..halvings).fold(1.0, |scale, _| scale * 0.5));
    let (a, b) = (G::small_adjoint(&(xi * scale)), G::small_adjoint(&(delta * scale)));
    // tₖ = aᵏ/(k + 1)! and its derivative along b.
    let (mut term, mut d_term) = (identity, SMatrix::zeros());
    let (mut jacobian, mut derivative): (Jacobian<_, D>, Jacobian<_, D>) = (term, d_term);
    for k in 1..=TERMS {
        let next = lit(1.0 / (k + 1) as f64);
        d_term = (d_term * a + term * b) * next;
        term = term * a * next;
        jacobian += term;
        derivative += d_term;
    }
    for _ in 0..halvings {
        let ad = G::exp(&(xi * scale)).adjoint();
        // d Ad_{Exp ξ} = ad_{J_l δ}·Ad_{Exp ξ}.
        let d_ad = G::small_adjoint(&(jacobian * (delta * scale))) * ad;
        derivative = (d_ad * jacobian + derivative + ad * derivative) * lit(0.5);
        jacobian = (jacobian + ad * jacobian) * lit(0.5);
        scale = scale + scale;
    }
    derivative
}

/// How often to halve a tangent until the series in its ad converges as for |ad| ≤ ½. Not from the entries of ad, which may be
/// metres in any number, but from ad¹⁶, where they enter by their sixteenth root: at most a few halvings too many.
fn halvings<S: Real, const D: usize>(ad: &Jacobian<S, D>) -> usize {
    const MOST: usize = 64;
    let power = (0..4).fold(ad.map(Real::value), |m, _| m * m);
    let mut size = (0..4).fold(power.amax() * D as f64, |r, _| nalgebra::SimdComplexField::simd_sqrt(r));
    let mut count = 0;
    while size > 0.5 && count < MOST {
        size *= 0.5;
        count += 1;
    }
    count
}
