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

use super::so3::skew;
use crate::lie::{Blend, Real, Stumpff};
use nalgebra::{Matrix3, SimdBool, Vector2, Vector3};

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
        z.norm_squared().simd_lt(S::lit(SERIES_END)),
        || {
            // Horner's rule: 1/2·(1 + z/3·(1 + z/4·(1 + …))).
            let nested = (2..=series_terms::<S>() + 1)
                .rev()
                .fold(Vector2::zeros(), |sum, k| (one + times(z, &sum)) * S::lit(1.0 / k as f64));
            (one + times(z, &nested), nested)
        },
        || {
            let (sin, cos) = z.y.sin_cos();
            let first = over(&(Vector2::new(cos, sin) * z.x.exp() - one), z);
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
            square.simd_lt(S::lit(SERIES_END)),
            || Self::series(sigma, x),
            || {
                let (a, e, k) = (mean_growth(sigma), sigma.exp(), Stumpff::new(x));
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

    /// G⁻¹ as a polynomial in φ^.
    #[inline]
    pub(super) fn inverse_polynomial(&self) -> Polynomial<S> {
        Polynomial(self.inverse())
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
        sigma.simd_abs().simd_lt(S::one()),
        || Growth::series(sigma, S::zero())[0],
        || (sigma.exp() - S::one()) / sigma,
    )
}

/// a·I + b·W + c·W², W = φ^.
#[derive(Clone, Copy)]
pub(super) struct Polynomial<S>(pub(super) [S; 3]);

impl<S: Real> Polynomial<S> {
    /// The product, by W³ = −xW.
    #[inline]
    fn times(&self, other: &Self, x: S) -> Self {
        let (Self([a, b, c]), Self([d, e, f])) = (self, other);
        Self([
            *a * *d,
            *a * *e + *b * *d - x * (*b * *f + *c * *e),
            *a * *f + *b * *e + *c * *d - x * *c * *f,
        ])
    }

    /// self + f·other.
    #[inline]
    fn plus(&self, f: S, other: &Self) -> Self {
        Self(core::array::from_fn(|i| self.0[i] + f * other.0[i]))
    }

    #[inline]
    pub(super) fn matrix(&self, phi: &Vector3<S>) -> Matrix3<S> {
        let (Self([a, b, c]), w) = (self, skew(phi));
        Matrix3::from_diagonal_element(*a) + w * *b + w * w * *c
    }
}

/// A matrix linear in ρ: the coefficients of P, WP, PW, W²P, (φ·ρ)W and (φ·ρ)W², with P = ρ^.
///
/// Products with W stay within these six, by WPW = −(φ·ρ)W, PW² = −xP − W²P − (φ·ρ)W and W³ = −xW.
#[derive(Clone, Copy)]
pub(super) struct Coupling<S>([S; 6]);

impl<S: Real> Coupling<S> {
    /// self + f·other.
    #[inline]
    fn plus(&self, f: S, other: &Self) -> Self {
        Self(core::array::from_fn(|i| self.0[i] + f * other.0[i]))
    }

    /// W·self.
    #[inline]
    fn turned(&self, x: S) -> Self {
        let Self([p, wp, pw, wwp, first, second]) = *self;
        Self([S::zero(), p - x * wwp, S::zero(), wp, -pw - x * second, first])
    }

    /// self·W.
    #[inline]
    fn turning(&self, x: S) -> Self {
        let Self([p, wp, pw, wwp, first, second]) = *self;
        Self([-x * pw, S::zero(), p, -pw, -wp - pw - x * second, first - wwp])
    }

    /// `m`·self.
    #[inline]
    pub(super) fn after(&self, m: &Polynomial<S>, x: S) -> Self {
        let once = self.turned(x);
        Self(self.0.map(|s| s * m.0[0])).plus(m.0[1], &once).plus(m.0[2], &once.turned(x))
    }

    /// self·`m`.
    #[inline]
    pub(super) fn before(&self, m: &Polynomial<S>, x: S) -> Self {
        let once = self.turning(x);
        Self(self.0.map(|s| s * m.0[0])).plus(m.0[1], &once).plus(m.0[2], &once.turning(x))
    }

    #[inline]
    pub(super) fn matrix(&self, rho: &Vector3<S>, phi: &Vector3<S>) -> Matrix3<S> {
        let Self([a, b, c, d, first, second]) = *self;
        let (w, p, dot) = (skew(phi), skew(rho), phi.dot(rho));
        let wp = w * p;
        p * a + wp * b + wp.transpose() * c + w * (wp * d + w * (dot * second)) + w * (dot * first)
    }
}

/// The coefficients of the left Jacobian of Sim(3), \[G, S, −Hρ; 0, J, 0; 0, 0, 1\], at one (σ, |φ|²).
#[derive(Clone, Copy)]
pub(super) struct SimilarityJacobian<S> {
    /// G = Σ Zⁱ/(i + 1)!, with Z = σI + W.
    pub(super) g: Polynomial<S>,
    /// S = Σ ZⁱPWʲ/(i + j + 2)!, the coupling of the rotation.
    pub(super) s: Coupling<S>,
    /// H = Σ Zⁱ/(i + 2)!, the coupling of the scale.
    pub(super) h: Polynomial<S>,
    /// J_l(φ).
    pub(super) j: Polynomial<S>,
}

/// Halved until √(σ² + x) ≤ ½, where this many terms of the series leave less than ε/10: ½¹⁶/17! ≪ ε.
const JACOBIAN_TERMS: usize = 17;

impl<S: Real> SimilarityJacobian<S> {
    /// The series at τ/2ᵏ, then k times J_l(2τ) = ½(I + Ad_{Exp τ})·J_l(τ).
    ///
    /// In closed form S would need several regimes, for σ and θ vanish independently. Doubling needs none, loses no digits,
    /// and serves all blocks at once.
    pub(super) fn new(sigma: S, x: S) -> Self {
        let mut scale = halved(x + sigma * sigma);
        let mut jacobian = Self::series(sigma, x, scale);
        loop {
            let short = scale.simd_lt(S::one());
            if short.none() {
                return jacobian;
            }
            jacobian = S::choose(short, || jacobian.doubled(sigma, x, scale), || jacobian);
            scale = S::choose(short, || scale + scale, || scale);
        }
    }

    /// At τ·`scale`, in powers of the unscaled W.
    fn series(sigma: S, x: S, scale: S) -> Self {
        let (one, o) = (S::one(), S::zero());
        let (z, w) = (Polynomial([sigma * scale, scale, o]), Polynomial([o, scale, o]));
        let identity = Polynomial([one, o, o]);
        let (mut zn, mut wn) = (identity, identity);
        let (mut tn, mut pw) = (Coupling([o; 6]), Coupling([scale, o, o, o, o, o]));
        let (mut g, mut s, mut h, mut j) = (identity, tn, Polynomial([o; 3]), identity);
        let mut factor = 1.0;
        for k in 1..=JACOBIAN_TERMS {
            // adᵏ = [Zᵏ, T_k, −Zᵏ⁻¹ρ; 0, Wᵏ, 0; 0, 0, 0], T_{k+1} = Z·T_k + P·Wᵏ.
            factor /= (k + 1) as f64;
            let f = S::lit(factor);
            tn = tn.after(&z, x).plus(one, &pw);
            h = h.plus(f * scale, &zn);
            (zn, wn, pw) = (zn.times(&z, x), wn.times(&w, x), pw.before(&w, x));
            (g, s, j) = (g.plus(f, &zn), s.plus(f, &tn), j.plus(f, &wn));
        }
        Self { g, s, h, j }
    }

    /// From τ·`scale` to twice that.
    fn doubled(&self, sigma: S, x: S, scale: S) -> Self {
        let k = Stumpff::new(x * scale * scale);
        let r = Polynomial([S::one(), k.c1 * scale, k.c2 * scale * scale]);
        let growth = (sigma * scale).exp();
        let Polynomial([a, b, c]) = self.g;
        // t^ for t = Gρ, by (φ×ρ)^ = WP − PW and (φ×(φ×ρ))^ = (φ·ρ)W − xP.
        let t = Coupling([a - x * c, b, -b, S::zero(), c, S::zero()]);
        let pushed = t.before(&r.times(&self.j, x), x);
        let half = S::lit(0.5);
        let mean = |m: &Polynomial<S>, grown: S| {
            Polynomial(m.0.map(|c| c * half)).plus(grown * half, &r.times(m, x))
        };
        let s = Coupling(self.s.0.map(|c| c * half)).plus(growth * half, &self.s.after(&r, x));
        Self {
            g: mean(&self.g, growth),
            s: s.plus(scale * half, &pushed),
            h: mean(&self.h, growth).plus(scale * half, &self.g),
            j: mean(&self.j, S::one()),
        }
    }
}

impl<S: Real> Blend<S> for SimilarityJacobian<S> {
    #[inline]
    fn blend(mask: S::SimdBool, yes: Self, no: Self) -> Self {
        let polynomial = |y: Polynomial<S>, n: Polynomial<S>| Polynomial(Blend::<S>::blend(mask, y.0, n.0));
        Self {
            g: polynomial(yes.g, no.g),
            s: Coupling(Blend::<S>::blend(mask, yes.s.0, no.s.0)),
            h: polynomial(yes.h, no.h),
            j: polynomial(yes.j, no.j),
        }
    }
}

/// The power of ½ by which a number of this square must be multiplied to be at most ½.
fn halved<S: Real>(square: S) -> S {
    let mut scale = S::one();
    // Beyond 2⁴⁰ no digit of an angle is left; the limit also stops at what is not finite.
    for _ in 0..40 {
        let long = (square * scale * scale).simd_gt(S::lit(0.25));
        if long.none() {
            break;
        }
        scale = S::choose(long, || scale * S::lit(0.5), || scale);
    }
    scale
}
