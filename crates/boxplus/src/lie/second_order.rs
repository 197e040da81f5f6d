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

/// The Hessian of ½τᵀΩτ, τ = Log X, by a local perturbation X·Exp u: D×D, symmetric, the Ω given as `information`.
///
/// ```text
/// H = J⁻ᵀΩJ⁻¹ + ½(K + Kᵀ),  K_jk = (Ωτ)·D J_r⁻¹(τ)[J⁻¹e_k]·e_j,  J⁻¹ = J_r⁻¹(τ)
/// ```
/// Gauss–Newton keeps the first term. With X = Z⁻¹Y it is the Hessian of a squared distance between Z and Y by Y; by Z, that of −τ.
/// On SO(3) with Ω = I its eigenvalues are 1 along τ and (θ/2)·cot(θ/2) across, which is 0 at θ = π: no squared distance is convex
/// beyond.
///
/// ```
/// use boxplus::lie::{SO3, second_order};
/// use nalgebra::{Matrix3, Vector3};
/// let hessian = second_order::squared_norm_hessian::<SO3, 3>(&Vector3::new(0.0, 0.0, 2.0), &Matrix3::identity());
/// assert!((hessian - Matrix3::from_diagonal(&Vector3::new(1.0 / 1.0_f64.tan(), 1.0 / 1.0_f64.tan(), 1.0))).amax() < 1e-15);
/// ```
pub fn squared_norm_hessian<G: LieGroup<D>, const D: usize>(
    tau: &Tangent<G::Scalar, D>,
    information: &Jacobian<G::Scalar, D>,
) -> Jacobian<G::Scalar, D> {
    let (inverse, force) = (G::right_jacobian_inverse(tau), information * tau);
    let mut bend = Jacobian::<G::Scalar, D>::zeros();
    for k in 0..D {
        let direction = inverse.column(k).into_owned();
        bend.set_column(k, &G::right_jacobian_inverse_derivative(tau, &direction).tr_mul(&force));
    }
    inverse.tr_mul(&(information * inverse)) + (bend + bend.transpose()) * G::Scalar::lit(0.5)
}

/// Terms of the series for |ad| ≤ ½: ½¹⁶/17! < 5·10⁻²⁰; for |φ| ≤ 0.79, 0.79ⁿ/(n + 1)! < ε/100 from n = 15 on.
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

/// Halvings that make |φ| ≤ 2π at most 0.79.
const PRODUCT_HALVINGS: u32 = 3;

/// F(τ, v) = ∂(J_r(τ)·v)/∂τ, D×D, right, for |φ| ≤ 2π: F(τ, v)·δ = D J_r(τ)\[δ\]·v, all δ at once.
///
/// ```text
/// J_r(τ)v = Σ tₙ/(n + 1)!    t₀ = v, tₙ = −ad_τ·tₙ₋₁ = ad(tₙ₋₁)·τ        ∂tₙ/∂τ = ad(tₙ₋₁) − ad_τ·∂tₙ₋₁/∂τ
/// J_r(2τ)v = ½(I + E)·J_r(τ)v                        E = Ad(Exp(−τ)) = I − ad_τ·J_r(τ)
/// F(2τ, v) = ¼[(I + E)·F(τ, v) + ad(E·J_r(τ)v)·J_r(τ)]
/// ```
/// The series where it is short, then doubled, a fixed number of times: no case apart at τ = 0, no cancellation, no look at a value.
///
/// ```
/// use boxplus::lie::{LieGroup, SE3, second_order};
/// use nalgebra::Vector6;
/// let [tau, v, delta] = [0.3, 1.1, -0.7].map(|k| Vector6::from_fn(|i, _| (k * (i as f64 + 1.0)).sin()));
/// let product = second_order::right_jacobian_product_derivative::<SE3, 6>(&tau, &v);
/// assert!((product * delta - SE3::right_jacobian_derivative(&tau, &delta) * v).amax() < 1e-14);
/// ```
pub fn right_jacobian_product_derivative<G: LieGroup<D>, const D: usize>(
    tau: &Tangent<G::Scalar, D>,
    v: &Tangent<G::Scalar, D>,
) -> Jacobian<G::Scalar, D> {
    let lit = G::Scalar::lit;
    let identity = Jacobian::<G::Scalar, D>::identity();
    let part = tau * lit(1.0 / f64::from(1_u32 << PRODUCT_HALVINGS));
    let (mut product, mut bend) = product_series::<G, D>(&part, v);
    let mut jacobian = G::right_jacobian(&part);
    let mut turn = identity - G::small_adjoint(&part) * jacobian;
    for _ in 0..PRODUCT_HALVINGS {
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
fn product_series<G: LieGroup<D>, const D: usize>(
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
