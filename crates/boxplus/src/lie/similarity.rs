//! The coefficients of Sim(2) and Sim(3), and the only place where their removable singularities are dealt with.
//!
//! A similarity turns and grows at once: with Z = σI + φ^ its Exp needs G = ∫₀¹ exp(uZ) du, which has a removable singularity
//! where σ and θ vanish together, and others where either does. In the plane Z is the complex number z = σ + iθ and
//! everything follows from φ₁(z) = (eᶻ − 1)/z and φ₂(z) = (eᶻ − 1 − z)/z². In space G = A·I + B·φ^ + C·φ^² with
//!
//! ```text
//! A = (e^σ − 1)/σ    B = (1 + e^σ(σc₁ − c₀))/(σ² + x)    C = (A + e^σ(σc₂ − c₁))/(σ² + x)    x = θ²
//! ```
//!
//! Two regimes each, not the usual four: where σ² + x < 4 the power series, elsewhere the quotients, whose denominators are
//! then harmless. Within 3ε for |σ| ≤ 6, θ ≤ π, `f32` and `f64`, whichever of σ and θ vanishes.

use super::so3::{polynomial, skew};
use super::{Real, Stumpff};
use nalgebra::{Matrix3, Vector2, Vector3};

/// Below σ² + θ² = 4 the series: its terms never exceed the sum, and from here on (eᶻ − 1 − z)/z² cancels no digit.
const SERIES_END: f64 = 4.0;

/// Terms of Σ zᵏ/(k + 1)! for |z| < 2 that leave less than ε/10: 2²³/24! in `f64`, 2¹⁵/16! in `f32`.
fn series_terms<S: Real>() -> usize {
    if S::EPSILON > 1e-10 { 15 } else { 23 }
}

/// a·b of complex numbers.
#[inline]
pub(super) fn times<S: Real>(a: &Vector2<S>, b: &Vector2<S>) -> Vector2<S> {
    Vector2::new(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x)
}

/// a/b of complex numbers.
#[inline]
pub(super) fn over<S: Real>(a: &Vector2<S>, b: &Vector2<S>) -> Vector2<S> {
    times(a, &Vector2::new(b.x, -b.y)) / b.norm_squared()
}

/// φ₁(z) = (eᶻ − 1)/z and φ₂(z) = (eᶻ − 1 − z)/z² of a complex number z = σ + iθ; 1 and ½ at 0.
#[inline]
pub(super) fn phi<S: Real>(z: &Vector2<S>) -> (Vector2<S>, Vector2<S>) {
    let one = Vector2::new(S::one(), S::zero());
    S::choose(
        z.norm_squared().value() < SERIES_END,
        || {
            // Horner's rule: 1/2·(1 + z/3·(1 + z/4·(1 + …))).
            let nested = (2..=series_terms::<S>() + 1)
                .rev()
                .fold(Vector2::zeros(), |sum, k| (one + times(z, &sum)) * S::lit(1.0 / k as f64));
            (one + times(z, &nested), nested)
        },
        || {
            let (sin, cos) = z.y.simd_sin_cos();
            let first = over(&(Vector2::new(cos, sin) * z.x.simd_exp() - one), z);
            (first, over(&(first - one), z))
        },
    )
}

/// The coefficients of G = A·I + B·φ^ + C·φ^² at one (σ, |φ|²).
pub(super) struct Growth<S> {
    a: S,
    b: S,
    c: S,
    x: S,
}

impl<S: Real> Growth<S> {
    #[inline]
    pub(super) fn new(sigma: S, x: S) -> Self {
        let square = sigma * sigma + x;
        let [a, b, c] = S::choose(
            square.value() < SERIES_END,
            || Self::series(sigma, x),
            || {
                let (a, e, k) = (mean_growth(sigma), sigma.simd_exp(), Stumpff::new(x));
                let b = (S::one() + e * (sigma * k.c1 - k.c0)) / square;
                [a, b, (a + e * (sigma * k.c2 - k.c1)) / square]
            },
        );
        Self { a, b, c, x }
    }

    /// \[A, B, C\] of Σ Zᵏ/(k + 1)!, with Zᵏ = p·I + y·φ^ + w·φ^².
    fn series(sigma: S, x: S) -> [S; 3] {
        let (mut p, mut y, mut w) = (S::one(), S::zero(), S::zero());
        let (mut a, mut b, mut c, mut factor) = (S::one(), S::zero(), S::zero(), 1.0);
        for k in 1..=series_terms::<S>() {
            (p, y, w) = (sigma * p, p - x * w + sigma * y, y + sigma * w);
            factor /= (k + 1) as f64;
            let f = S::lit(factor);
            (a, b, c) = (a + p * f, b + y * f, c + w * f);
        }
        [a, b, c]
    }

    /// G·v.
    #[inline]
    pub(super) fn apply(&self, phi: &Vector3<S>, v: &Vector3<S>) -> Vector3<S> {
        combine(phi, self.a, self.b, self.c, v)
    }

    /// G⁻¹·v, where G⁻¹ = (1/A)·I − (B/D)·φ^ + ((B² − CE)/(AD))·φ^² with E = A − Cx, D = E² + B²x.
    #[inline]
    pub(super) fn solve(&self, phi: &Vector3<S>, v: &Vector3<S>) -> Vector3<S> {
        let [a, b, c] = self.inverse();
        combine(phi, a, b, c, v)
    }

    /// G⁻¹, 3×3.
    #[inline]
    pub(super) fn inverse_matrix(&self, phi: &Vector3<S>) -> Matrix3<S> {
        let ([a, b, c], w) = (self.inverse(), skew(phi));
        Matrix3::from_diagonal_element(a) + w * b + w * w * c
    }

    fn inverse(&self) -> [S; 3] {
        let Self { a, b, c, x } = *self;
        let e = a - c * x;
        let d = e * e + b * b * x;
        [S::one() / a, -b / d, (b * b - c * e) / (a * d)]
    }
}

/// a·v + b·φ×v + c·φ×(φ×v).
#[inline]
fn combine<S: Real>(phi: &Vector3<S>, a: S, b: S, c: S, v: &Vector3<S>) -> Vector3<S> {
    let turned = phi.cross(v);
    v * a + turned * b + phi.cross(&turned) * c
}

/// (e^σ − 1)/σ, 1 at 0, with exact derivatives there.
fn mean_growth<S: Real>(sigma: S) -> S {
    S::choose(
        sigma.value().abs() < 1.0,
        || Growth::series(sigma, S::zero())[0],
        || sigma.simd_exp_m1() / sigma,
    )
}

/// The blocks of the left Jacobian of Sim(3), \[G, S, c; 0, J, 0; 0, 0, 1\].
pub(super) struct SimilarityJacobian<S> {
    /// G = Σ Zⁱ/(i + 1)!, with Z = σI + φ^: ∂ρ-block.
    pub(super) g: Matrix3<S>,
    /// S = Σ Zⁱρ^(φ^)ʲ/(i + j + 2)!: the coupling of the rotation.
    pub(super) s: Matrix3<S>,
    /// c = −Σ Zⁱρ/(i + 2)!: the coupling of the scale.
    pub(super) c: Vector3<S>,
    /// J_l(φ).
    pub(super) j: Matrix3<S>,
}

/// Halved until √(σ² + x) ≤ ½, where this many terms of the series leave less than ε/10: ½¹⁶/17! ≪ ε.
const JACOBIAN_TERMS: usize = 17;

impl<S: Real> SimilarityJacobian<S> {
    /// At the tangent (ρ, φ, σ): the series at τ/2ᵏ, then k times J_l(2τ) = ½(I + Ad_{Exp τ})·J_l(τ).
    ///
    /// In scalar coefficients S would need several regimes, for σ and θ vanish independently. Doubling needs none, loses no
    /// digits, and serves all blocks at once.
    pub(super) fn new(rho: &Vector3<S>, phi: &Vector3<S>, sigma: S) -> Self {
        let (halvings, mut scale) = halvings(phi.norm_squared().value() + sigma.value() * sigma.value());
        let part = |scale: f64| (rho * S::lit(scale), phi * S::lit(scale), sigma * S::lit(scale));
        let (rho_k, phi_k, sigma_k) = part(scale);
        let mut blocks = Self::series(&rho_k, &phi_k, sigma_k);
        for _ in 0..halvings {
            let (rho_k, phi_k, sigma_k) = part(scale);
            blocks = blocks.doubled(&rho_k, &phi_k, sigma_k);
            scale *= 2.0;
        }
        blocks
    }

    fn series(rho: &Vector3<S>, phi: &Vector3<S>, sigma: S) -> Self {
        let (w, p) = (skew(phi), skew(rho));
        let z = w + Matrix3::from_diagonal_element(sigma);
        let (mut zn, mut wn, mut tn) = (Matrix3::identity(), Matrix3::identity(), Matrix3::zeros());
        let (mut g, mut s, mut c, mut j) = (zn, tn, Vector3::zeros(), wn);
        let mut factor = 1.0;
        for k in 1..=JACOBIAN_TERMS {
            // adᵏ = [Zᵏ, T_k, −Zᵏ⁻¹ρ; 0, Wᵏ, 0; 0, 0, 0], T_{k+1} = Z·T_k + P·Wᵏ.
            factor /= (k + 1) as f64;
            let f = S::lit(factor);
            tn = z * tn + p * wn;
            c -= zn * rho * f;
            (zn, wn) = (z * zn, w * wn);
            (g, s, j) = (g + zn * f, s + tn * f, j + wn * f);
        }
        Self { g, s, c, j }
    }

    /// From τ to 2τ.
    fn doubled(&self, rho: &Vector3<S>, phi: &Vector3<S>, sigma: S) -> Self {
        let Self { g, s, c, j } = self;
        let half = S::lit(0.5);
        let t = g * rho;
        let k = Stumpff::new(phi.norm_squared());
        let r = polynomial(phi, k.c1, k.c2);
        let sr = r * sigma.simd_exp();
        Self {
            g: (g + sr * g) * half,
            s: (s + sr * s + skew(&t) * r * j) * half,
            c: (c + sr * c - t) * half,
            j: (j + r * j) * half,
        }
    }
}

/// How often a number of this square must be halved to be at most ½, and ½ to that power.
fn halvings(square: f64) -> (u32, f64) {
    let (mut count, mut scale) = (0, 1.0);
    // Beyond 2⁴⁰ no digit of an angle is left; the limit also stops at what is not finite.
    while square * scale * scale > 0.25 && count < 40 {
        scale *= 0.5;
        count += 1;
    }
    (count, scale)
}
