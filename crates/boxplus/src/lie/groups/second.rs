//! Closed forms of D J_r(τ)\[δ\], the derivative of the right Jacobian along δ.
//!
//! ```text
//! SO(3): D J_r(φ)[δ] = Q_r(δ, φ), the coupling block of SE(3), which is this derivative
//! SE(3): [Q_r(δφ, φ), Q_r(δρ, φ) + B(ρ, δφ); 0, Q_r(δφ, φ)]
//! B(u, v) = D²J_r(φ)[u, v], symmetric,
//!         = c₃(u^v^ + v^u^) + β₂((φ·v)(φ^u^ + u^φ^) + (φ·u)(φ^v^ + v^φ^) + (u·v)φ^²) + γ₂(φ·u)(φ·v)φ^²
//!           − (β₁((φ·v)u + (φ·u)v + (u·v)φ) + γ₁(φ·u)(φ·v)φ)^
//! γ₁ = β₁′(θ)/θ = c₄ − 5c₅ + 8c₆ → 1/90, γ₂ = β₂′(θ)/θ = c₅ − 7c₆ + 15c₇ → 1/630
//! ```

use super::se3::right_coupling;
use super::so3::skew;
use crate::lie::{Real, SO2, Stumpff};
use nalgebra::{Matrix3, Vector3};

/// Of SO(3) and S³.
#[inline]
pub(super) fn so3<S: Real>(phi: &Vector3<S>, delta: &Vector3<S>) -> Matrix3<S> {
    right_coupling(delta, phi, &Stumpff::new(phi.norm_squared()))
}

/// The block that couples a vector ρ to the rotation: Q_r(δρ, φ) + B(ρ, δφ).
pub(super) fn coupling<S: Real>(
    [rho, phi]: [&Vector3<S>; 2],
    [d_rho, d_phi]: [&Vector3<S>; 2],
    c: &Stumpff<S>,
) -> Matrix3<S> {
    let x = phi.norm_squared();
    let (beta1, beta2) = (c.beta1(), c.beta2());
    let gamma1 = c.c4 - c.c5 * S::lit(5.0) + c.c6 * S::lit(8.0);
    let gamma2 = c.c5 - c.c6 * S::lit(7.0) + c7(x, c) * S::lit(15.0);
    let (along, d_along, between) = (phi.dot(rho), phi.dot(d_phi), rho.dot(d_phi));
    let both = along * d_along;
    let mixed = rho * d_along + d_phi * along;
    // u^v^ + v^u^ = uvᵀ + vuᵀ − 2(u·v)I, so that φ^² = φφᵀ − xI is half of one.
    let pair = |u: &Vector3<S>, v: &Vector3<S>| {
        let product = u * v.transpose();
        product + product.transpose() - Matrix3::from_diagonal_element(u.dot(v) * S::lit(2.0))
    };
    let bend = pair(phi, phi) * ((beta2 * between + gamma2 * both) * S::lit(0.5));
    let turn = (mixed + phi * between) * beta1 + phi * (gamma1 * both);
    right_coupling(d_rho, phi, c) + pair(rho, d_phi) * c.c3 + pair(phi, &mixed) * beta2 + bend - skew(&turn)
}

/// c₇(x) = Σⱼ (−x)ʲ/(7 + 2j)!, by its series where (1/5! − c₅)/x would cancel.
fn c7<S: Real>(x: S, c: &Stumpff<S>) -> S {
    // The last term kept is 30¹⁵·7!/37! = 5·10⁻¹⁸ of the first; above 30 the recurrence loses less than two bits.
    const END: f64 = 30.0;
    const TERMS: u32 = 15;
    let mut sum = S::one();
    for j in (1..=TERMS).rev() {
        let n = f64::from(7 + 2 * j);
        sum = S::one() - x * sum * S::lit(1.0 / (n * (n - 1.0)));
    }
    let recurrence = (S::lit(1.0 / 120.0) - c.c5) / x;
    (sum * S::lit(1.0 / 5040.0)).select(x.simd_lt(S::lit(END)), recurrence)
}

/// Of SE(2): from d(θᵏc_k)/dθ = θᵏ⁻¹c_{k−1}, entry by entry.
pub(super) fn se2<S: Real>(tau: &Vector3<S>, delta: &Vector3<S>, c: &Stumpff<S>) -> Matrix3<S> {
    let (theta, d_theta, o) = (tau.z, delta.z, S::zero());
    let (cos, sin) = (theta * (c.c3 - c.c2) * d_theta, (c.c2 - c.c1) * d_theta);
    let along = delta.xy() * (theta * c.c3) + tau.xy() * ((c.c2 - c.c3 - c.c3) * d_theta);
    let across = delta.xy() * c.c2 + tau.xy() * (theta * c.beta1() * d_theta);
    let column = along + SO2::turn(&across);
    Matrix3::new(cos, -sin, column.x, sin, cos, column.y, o, o, o)
}
