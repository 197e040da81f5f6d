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

use super::so3::{quadratic, skew};
use crate::lie::real::of_lanes;
use crate::lie::stumpff::{MAX_TERMS, inverse_factorials};
use crate::lie::{Blend, Real, Stumpff};
use nalgebra::{Matrix3, SimdBool, Vector2, Vector3};

/// Below σ² + θ² = 4 the series: its terms never exceed the sum, and from here on (eᶻ − 1 − z)/z² cancels no digit.
const SERIES_END: f64 = 4.0;

/// Coefficients of zᵏ in φ₁ and φ₂, those of even and of odd k apart: 1/(k + 1)! and 1/(k + 2)!. Even and odd powers are summed side
/// by side by Horner's rule in z², which halves the chain of operations that wait for each other.
const FIRST: [[f64; MAX_TERMS + 1]; 2] = [inverse_factorials(1), inverse_factorials(2)];
const SECOND: [[f64; MAX_TERMS + 1]; 2] = [inverse_factorials(2), inverse_factorials(3)];

/// The last pair of coefficients that counts for |z| < 2: what follows is less than ε/10, 2²⁴/25! in `f64`, 2¹⁶/17! in `f32`.
const fn last_pair<S: Real>() -> usize {
    if S::EPSILON > 1e-10 { 7 } else { 11 }
}

/// a·b of complex numbers.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn times<S: Real>(a: &Vector2<S>, b: &Vector2<S>) -> Vector2<S> {
    Vector2::new(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x)
}

/// a/b of complex numbers.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn over<S: Real>(a: &Vector2<S>, b: &Vector2<S>) -> Vector2<S> {
    times(a, &Vector2::new(b.x, -b.y)) / b.norm_squared()
}

/// φ₁(z) = (eᶻ − 1)/z and φ₂(z) = (eᶻ − 1 − z)/z² of a complex number z = σ + iθ; 1 and ½ at 0.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn phi<S: Real>(z: &Vector2<S>) -> (Vector2<S>, Vector2<S>) {
    let one = Vector2::new(S::one(), S::zero());
    if let Some(nan) = of_lanes(z.x) {
        return (one * nan, one * nan);
    }
    S::choose(
        z.norm_squared().simd_lt(S::lit(SERIES_END)),
        || {
            let (square, mut even, mut odd) = (times(z, z), Vector2::zeros(), Vector2::zeros());
            for k in (0..=last_pair::<S>()).rev() {
                even = times(&even, &square) + one * S::lit(SECOND[0][k]);
                odd = times(&odd, &square) + one * S::lit(SECOND[1][k]);
            }
            let second = even + times(z, &odd);
            (one + times(z, &second), second)
        },
        || {
            let (sin, cos) = z.y.sin_cos();
            let first = over(&(Vector2::new(cos, sin) * z.x.exp() - one), z);
            (first, over(&(first - one), z))
        },
    )
}

/// G = A·I + B·φ^ + C·φ^² at one (σ, |φ|²).
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn growth<S: Real>(sigma: S, x: S) -> Polynomial<S> {
    let square = sigma * sigma + x;
    if let Some(nan) = of_lanes(sigma) {
        return Polynomial([nan; 3]);
    }
    Polynomial(S::choose(
        square.simd_lt(S::lit(SERIES_END)),
        || growth_series(sigma, x),
        || {
            let (a, e, k) = (mean_growth(sigma), sigma.exp(), Stumpff::new(x));
            let b = (S::one() + e * (sigma * k.c1 - k.c0)) / square;
            [a, b, (a + e * (sigma * k.c2 - k.c1)) / square]
        },
    ))
}

/// \[A, B, C\] of Σ Zᵏ/(k + 1)!.
#[cfg_attr(not(debug_assertions), inline(always))]
fn growth_series<S: Real>(sigma: S, x: S) -> [S; 3] {
    // By Z² = σ²·I + 2σ·φ^ + φ^² and φ^³ = −xφ^.
    let (square, double) = (sigma * sigma, sigma + sigma);
    let (mut even, mut odd) = ([S::zero(); 3], [S::zero(); 3]);
    for k in (0..=last_pair::<S>()).rev() {
        [even, odd] = [(even, FIRST[0][k]), (odd, FIRST[1][k])].map(|([a, b, c], term)| {
            let (p, q) = (square * a + S::lit(term), double * (a - x * c) + (square - x) * b);
            [p, q, a + double * b + (square - x) * c]
        });
    }
    let [a, b, c] = even;
    let Polynomial([p, q, r]) = Polynomial(odd).grown(sigma, x);
    [a + p, b + q, c + r]
}

/// (e^σ − 1)/σ, 1 at 0, with exact derivatives there.
#[cfg_attr(not(debug_assertions), inline(always))]
fn mean_growth<S: Real>(sigma: S) -> S {
    S::choose(
        sigma.simd_abs().simd_lt(S::one()),
        || growth_series(sigma, S::zero())[0],
        || (sigma.exp() - S::one()) / sigma,
    )
}

/// a·I + b·W + c·W², W = φ^.
#[derive(Clone, Copy)]
pub(super) struct Polynomial<S>(pub(super) [S; 3]);

impl<S: Real> Polynomial<S> {
    /// self·v = a·v + b·φ×v + c·φ×(φ×v).
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn apply(&self, phi: &Vector3<S>, v: &Vector3<S>) -> Vector3<S> {
        let (Self([a, b, c]), turned) = (*self, phi.cross(v));
        v * a + turned * b + phi.cross(&turned) * c
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn matrix(&self, phi: &Vector3<S>) -> Matrix3<S> {
        quadratic(phi, self.0)
    }

    /// The inverse, (1/a)·I − (b/d)·W + ((b² − ce)/(ad))·W² with e = a − cx, d = e² + b²x.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn inverse(&self, x: S) -> Self {
        let Self([a, b, c]) = *self;
        let e = a - c * x;
        let d = e * e + b * b * x;
        Self([S::one() / a, -b / d, (b * b - c * e) / (a * d)])
    }

    /// Z·self, Z = σI + W.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn grown(&self, sigma: S, x: S) -> Self {
        let Self([a, b, c]) = *self;
        Self([sigma * a, sigma * b + a - x * c, sigma * c + b])
    }

    /// W·self.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn turned(&self, x: S) -> Self {
        let Self([a, b, c]) = *self;
        Self([S::zero(), a - x * c, b])
    }

    /// The product, by W³ = −xW.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn times(&self, other: &Self, x: S) -> Self {
        let (Self([a, b, c]), Self([d, e, f])) = (*self, *other);
        Self([a * d, a * e + b * d - x * (b * f + c * e), a * f + b * e + c * d - x * c * f])
    }

    /// f·self.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn scaled(&self, f: S) -> Self {
        Self(self.0.map(|c| c * f))
    }

    /// self + f·other.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn plus(&self, f: S, other: &Self) -> Self {
        Self(core::array::from_fn(|i| self.0[i] + f * other.0[i]))
    }

    /// self + f·I.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn shifted(&self, f: S) -> Self {
        let Self([a, b, c]) = *self;
        Self([a + f, b, c])
    }
}

/// A matrix linear in ρ: the coefficients of P, WP, PW, W²P, (φ·ρ)W and (φ·ρ)W², with P = ρ^.
///
/// Products with W stay within these six, by WPW = −(φ·ρ)W, PW² = −xP − W²P − (φ·ρ)W and W³ = −xW.
#[derive(Clone, Copy)]
pub(super) struct Coupling<S>([S; 6]);

impl<S: Real> Coupling<S> {
    /// P·`m`.
    #[inline]
    fn of(m: &Polynomial<S>, x: S) -> Self {
        let (Polynomial([a, b, c]), o) = (*m, S::zero());
        Self([a - x * c, o, b, -c, -c, o])
    }

    /// f·self.
    #[inline]
    fn scaled(&self, f: S) -> Self {
        Self(self.0.map(|c| c * f))
    }

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
        self.scaled(m.0[0]).plus(m.0[1], &once).plus(m.0[2], &once.turned(x))
    }

    /// self·`m`.
    #[inline]
    pub(super) fn before(&self, m: &Polynomial<S>, x: S) -> Self {
        let once = self.turning(x);
        self.scaled(m.0[0]).plus(m.0[1], &once).plus(m.0[2], &once.turning(x))
    }

    #[inline]
    pub(super) fn matrix(&self, rho: &Vector3<S>, phi: &Vector3<S>) -> Matrix3<S> {
        let Self([a, b, c, d, first, second]) = *self;
        // By φ^ρ^ = ρφᵀ − (φ·ρ)I, φ^²ρ^ = (φ×ρ)φᵀ − (φ·ρ)φ^ and φ^² = φφᵀ − xI.
        let (dot, x) = (phi.dot(rho), phi.norm_squared());
        let u = rho * b + phi.cross(rho) * d + phi * (dot * second);
        let skewed = skew(&(rho * a + phi * (dot * (first - d))));
        let diagonal = Matrix3::from_diagonal_element(dot * (b + c) + dot * second * x);
        skewed + u * phi.transpose() + (phi * c) * rho.transpose() - diagonal
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

impl<S: Real> SimilarityJacobian<S> {
    /// Terms of the series that leave less than ε/10 where √(σ² + x) ≤ 1: (n + 1)/(n + 2)! of S.
    const TERMS: usize = if S::EPSILON > 1e-10 { 11 } else { 18 };

    /// The series at τ/2ᵏ, √(σ² + x)/2ᵏ ≤ 1, then k times J_l(2τ) = ½(I + Ad_{Exp τ})·J_l(τ).
    ///
    /// In closed form S would need several regimes, for σ and θ vanish independently. Doubling needs none, loses no digits,
    /// and serves all blocks at once.
    pub(super) fn new(sigma: S, x: S) -> Self {
        if let Some(nan) = of_lanes(sigma) {
            let nothing = Polynomial([nan; 3]);
            return Self { g: nothing, s: Coupling([nan; 6]), h: nothing, j: nothing };
        }
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

    /// At τ·`scale`, in powers of the unscaled W. With M = scale·\[Z, P; 0, W\] the blocks G, S and J are those of φ₁(M) = I + M·φ₂(M).
    fn series(sigma: S, x: S, scale: S) -> Self {
        let nothing = Polynomial([S::zero(); 3]);
        let nothing = Self { g: nothing, s: Coupling([S::zero(); 6]), h: nothing, j: nothing };
        // Horner's rule: φ₂ = ½(I + M/3·(I + M/4·(I + …))).
        let second = (2..=Self::TERMS + 1).rev().fold(nothing, |sum, k| sum.nested(sigma, x, scale, k));
        Self { h: second.g.scaled(scale), ..second.nested(sigma, x, scale, 1) }
    }

    /// (I + M·self)/k.
    #[inline]
    fn nested(&self, sigma: S, x: S, scale: S, k: usize) -> Self {
        let share = S::lit(1.0 / k as f64);
        let f = scale * share;
        let coupled = Coupling::of(&self.j, x).plus(S::one(), &self.s.turned(x)).plus(sigma, &self.s);
        Self {
            g: self.g.grown(sigma, x).scaled(f).shifted(share),
            s: coupled.scaled(f),
            h: self.h,
            j: self.j.turned(x).scaled(f).shifted(share),
        }
    }

    /// From τ·`scale` to twice that.
    fn doubled(&self, sigma: S, x: S, scale: S) -> Self {
        let (one, half) = (S::one(), S::lit(0.5));
        // Exp of what is there: e^Z = I + Z·G and R = I + W·J.
        let turn = self.j.turned(x).scaled(scale).shifted(one);
        let mean = self.g.grown(sigma, x).scaled(scale * half).shifted(one);
        let Polynomial([a, b, c]) = self.g;
        // t^ for t = Gρ, by (φ×ρ)^ = WP − PW and (φ×(φ×ρ))^ = (φ·ρ)W − xP.
        let t = Coupling([a - x * c, b, -b, S::zero(), c, S::zero()]);
        let turned = turn.times(&self.j, x);
        Self {
            g: mean.times(&self.g, x),
            s: self.s.after(&mean, x).plus(scale * half, &t.before(&turned, x)),
            h: mean.times(&self.h, x).plus(scale * half, &self.g),
            j: self.j.plus(one, &turned).scaled(half),
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

/// The power of ½ by which a number of this square must be multiplied to be at most 1.
fn halved<S: Real>(square: S) -> S {
    let mut scale = S::one();
    // Beyond 2⁴⁰ no digit of an angle is left; the limit also stops at what is not finite.
    for _ in 0..40 {
        let long = (square * scale * scale).simd_gt(S::one());
        if long.none() {
            break;
        }
        scale = S::choose(long, || scale * S::lit(0.5), || scale);
    }
    scale
}
