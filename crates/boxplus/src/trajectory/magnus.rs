//! Magnus expansions: one exponential for a velocity known in advance.
//!
//! ```text
//! Ẋ = X·ω(t)^      X(t + h) = X(t)·Exp(Ω)      Ω = ∫ω(s)ds + ½∫∫_{r<s} [ω(r), ω(s)]dr ds + …
//! order 2          Ω = h·ω(t + h/2)
//! order 4          Ω = (h/2)(ω_a + ω_b) + (√3/12)h²[ω_a, ω_b]      ω_a, ω_b at t + (½ ∓ √3/6)h
//! ω = ω₁ + αs      Ω = ω₁h + ½αh² + (h³/12)[ω₁, α]                 the same, in closed form; error O(h⁵)
//! ```
//! Magnus (1954); Blanes, Casas, Oteo & Ros (2009); Barfoot (2024) (8.29). In the spatial form Ẋ = ϖ^·X, X(t + h) =
//! Exp(Ω)·X(t), which most texts print, every bracket has the other sign: Ω_spatial(ϖ) = −Ω_body(−ϖ), the `…_spatial`
//! functions here.
//!
//! Pitfall: with the wrong sign the order is 2 again, and a smooth test trajectory still looks right.

use crate::lie::{LieGroup, Real, Tangent};

/// Ω of order 2 for the body velocity ω over \[t, t + h\]: X(t + h) = X(t)·Exp(Ω). The midpoint rule; the same on both sides.
pub fn magnus2<G: LieGroup<D>, const D: usize>(
    omega: impl Fn(G::Scalar) -> Tangent<G::Scalar, D>,
    t: G::Scalar,
    h: G::Scalar,
) -> Tangent<G::Scalar, D> {
    omega(t + h * G::Scalar::lit(0.5)) * h
}

/// Ω of order 4 for the body velocity ω over \[t, t + h\], from two Gauss nodes: X(t + h) = X(t)·Exp(Ω).
///
/// ```
/// use boxplus::lie::{LieGroup, SO3};
/// use boxplus::trajectory::magnus4;
/// use nalgebra::Vector3;
/// // In a frame that turns by −z this velocity is constant: R(t) = Exp((t, 0, 3t))·Rot_z(−t).
/// let gyro = |t: f64| Vector3::new(t.cos(), t.sin(), 2.0);
/// let truth = SO3::exp(&Vector3::new(0.1, 0.0, 0.3)) * SO3::exp(&Vector3::new(0.0, 0.0, -0.1));
/// let end = SO3::exp(&magnus4::<SO3, 3>(gyro, 0.0, 0.1));
/// assert!(end.rminus(&truth).norm() < 0.1_f64.powi(5) / 50.0);
/// ```
pub fn magnus4<G: LieGroup<D>, const D: usize>(
    omega: impl Fn(G::Scalar) -> Tangent<G::Scalar, D>,
    t: G::Scalar,
    h: G::Scalar,
) -> Tangent<G::Scalar, D> {
    const ROOT3: f64 = 1.732_050_807_568_877_2;
    let lit = G::Scalar::lit;
    let [a, b] = [0.5 - ROOT3 / 6.0, 0.5 + ROOT3 / 6.0].map(|node| omega(t + h * lit(node)));
    (a + b) * (h * lit(0.5)) + G::bracket(&a, &b) * (h * h * lit(ROOT3 / 12.0))
}

/// [`magnus4`] for the spatial velocity ϖ: X(t + h) = Exp(Ω)·X(t).
pub fn magnus4_spatial<G: LieGroup<D>, const D: usize>(
    spatial: impl Fn(G::Scalar) -> Tangent<G::Scalar, D>,
    t: G::Scalar,
    h: G::Scalar,
) -> Tangent<G::Scalar, D> {
    -magnus4::<G, D>(|t| -spatial(t), t, h)
}

/// Ω = ω₁h + ½αh² + (h³/12)·\[ω₁, α\] for the body velocity ω₁ + αs over a time h; local error O(h⁵).
pub fn magnus_linear<G: LieGroup<D>, const D: usize>(
    omega: &Tangent<G::Scalar, D>,
    alpha: &Tangent<G::Scalar, D>,
    h: G::Scalar,
) -> Tangent<G::Scalar, D> {
    let lit = G::Scalar::lit;
    omega * h + alpha * (h * h * lit(0.5)) + G::bracket(omega, alpha) * (h * h * h * lit(1.0 / 12.0))
}

/// [`magnus_linear`] for the spatial velocity ϖ₁ + αs: X(t + h) = Exp(Ω)·X(t). Barfoot (2024) (8.29).
pub fn magnus_linear_spatial<G: LieGroup<D>, const D: usize>(
    spatial: &Tangent<G::Scalar, D>,
    alpha: &Tangent<G::Scalar, D>,
    h: G::Scalar,
) -> Tangent<G::Scalar, D> {
    -magnus_linear::<G, D>(&-spatial, &-alpha, h)
}
