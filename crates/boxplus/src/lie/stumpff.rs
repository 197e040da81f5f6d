//! Stumpff functions: the only place of the library with removable singularities.
//!
//! ```text
//! c_k(x) = Σⱼ (−x)ʲ/(k + 2j)!        x = θ²
//! c₀ = cos θ    c₁ = sin θ/θ    c₂ = (1 − cos θ)/θ²    c₃ = (θ − sin θ)/θ³    c_k = 1/k! − x·c_{k+2}
//! ```
//!
//! Every map and Jacobian of a group with a rotation is polynomial in the algebra with these functions as coefficients:
//! Exp φ = I + c₁φ^ + c₂φ^², J_l = I + c₂φ^ + c₃φ^². They are entire in x, so nothing happens at θ = 0; what goes wrong
//! there is the evaluation. The quotients above lose a factor θ² of their digits per step of k: at θ = 10⁻² the textbook
//! form of c₅ is wrong in the seventh digit, at 10⁻³ in all. Libraries therefore switch to a series at some tiny θ, and are
//! wrong just above it.
//!
//! Here the series serves all of θ² < 10, hence every rotation a principal logarithm returns (θ ≤ π): c₅ and c₆ by
//! Horner's rule, then downward by c_k = 1/k! − x·c_{k+2}, which only ever subtracts a smaller term. Above, the
//! recurrence runs upward from c₁ and c₂, harmless for large x. One switch, no tuned constants. Relative error for θ ≤ π:
//! 2ε for c₂, 1ε for c₃ … c₆, 3ε for d, 2.5ε for β₁, 4ε for β₂, 32ε for e, in `f32` and in `f64` (`docs/accuracy.md`).
//!
//! ```
//! use boxplus::lie::Stumpff;
//! let theta: f64 = 1e-3;
//! let c = Stumpff::new(theta * theta);
//! assert!((c.c3 - (1.0 / 6.0 - theta.powi(2) / 120.0)).abs() < 1e-14);
//! assert!(((theta - theta.sin()) / theta.powi(3) - 1.0 / 6.0).abs() > 1e-11); // the quotient has lost five digits
//! ```

use super::{Blend, Real};

/// The values c₀ … c₆ at one x = θ².
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Stumpff<S = f64> {
    /// cos θ.
    pub c0: S,
    /// sin θ/θ.
    pub c1: S,
    /// (1 − cos θ)/θ².
    pub c2: S,
    /// (θ − sin θ)/θ³.
    pub c3: S,
    /// (θ²/2 − 1 + cos θ)/θ⁴.
    pub c4: S,
    /// (θ³/6 − θ + sin θ)/θ⁵.
    pub c5: S,
    /// (θ⁴/24 − θ²/2 + 1 − cos θ)/θ⁶.
    pub c6: S,
}

/// Upper end of the series. π² < 10, so that a principal logarithm never leaves it.
const SERIES_END: f64 = 10.0;
/// Beyond, c₀ and c₁ are sines. A little more than (π/2)², for halves of principal angles; c₁ subtracts 37 % at most.
const TRIGONOMETRY_START: f64 = 2.5;

impl<S: Real> Stumpff<S> {
    /// All of c₀ … c₆ at `x` = θ² ≥ 0. What a caller does not use costs nothing once inlined.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(x: S) -> Self {
        match x.common(x.simd_lt(S::lit(SERIES_END))) {
            Some(x) => Self::series(x),
            None => Self::closed(x),
        }
    }

    /// The same, where x is mostly below 2.5, as it is for the half of an angle up to π: there no root and no sine is taken.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn half(x: S) -> Self {
        match x.common(x.simd_lt(S::lit(TRIGONOMETRY_START))) {
            Some(x) => Self::polynomials(x),
            None => Self::new(x),
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn series(x: S) -> Self {
        let c = Self::polynomials(x);
        let (c0, c1) = S::choose(
            x.simd_lt(S::lit(TRIGONOMETRY_START)),
            || (c.c0, c.c1),
            || {
                let theta = x.simd_sqrt();
                let (sin, cos) = theta.sin_cos();
                (cos, sin / theta)
            },
        );
        Self { c0, c1, ..c }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn polynomials(x: S) -> Self {
        let (c5, c6) = (series(&C5, x), series(&C6, x));
        let c4 = S::lit(1.0 / 24.0) - x * c6;
        let c3 = S::lit(1.0 / 6.0) - x * c5;
        let c2 = S::lit(0.5) - x * c4;
        // Two terms before the rest, which is then small: c₀ within ε of the truth though it vanishes at π/2.
        let c1 = (S::one() - x * S::lit(1.0 / 6.0)) + x * x * c5;
        let c0 = (S::one() - x * S::lit(0.5)) + x * x * c4;
        Self { c0, c1, c2, c3, c4, c5, c6 }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn closed(x: S) -> Self {
        let theta = x.simd_sqrt();
        let (half_sin, half_cos) = (theta * S::lit(0.5)).sin_cos();
        let c0 = half_cos * half_cos - half_sin * half_sin;
        let c1 = theta.sin_cos().0 / theta;
        let c2 = S::lit(2.0) * half_sin * half_sin / x;
        let c3 = (S::one() - c1) / x;
        let c4 = (S::lit(0.5) - c2) / x;
        let c5 = (S::lit(1.0 / 6.0) - c3) / x;
        let c6 = (S::lit(1.0 / 24.0) - c4) / x;
        Self { c0, c1, c2, c3, c4, c5, c6 }
    }

    /// d = (1 − (θ/2)·cot(θ/2))/θ² = (c₃ − 2c₄)/(2c₂): J_l⁻¹ = I − ½φ^ + d·φ^². 1/12 at 0, a pole at 2π.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn d(&self) -> S {
        -self.beta1() / (self.c2 + self.c2)
    }

    /// e = d′(θ)/θ = ((5c₅ − c₄ − 8c₆)·c₂ + (c₃ − 2c₄)²)/(2c₂²). 1/360 at 0, a pole at 2π.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn e(&self) -> S {
        let b = self.beta1();
        let a = S::lit(5.0) * self.c5 - self.c4 - S::lit(8.0) * self.c6;
        (a * self.c2 + b * b) / (S::lit(2.0) * self.c2 * self.c2)
    }

    /// β₁ = c₂′(θ)/θ = (θ sin θ + 2 cos θ − 2)/θ⁴ = −(c₃ − 2c₄). −1/12 at 0.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn beta1(&self) -> S {
        self.c4 + self.c4 - self.c3
    }

    /// β₂ = c₃′(θ)/θ = (3 sin θ − θ cos θ − 2θ)/θ⁵ = −(c₄ − 3c₅). −1/60 at 0.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn beta2(&self) -> S {
        S::lit(3.0) * self.c5 - self.c4
    }
}

impl<S: Real> Blend<S> for Stumpff<S> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn blend(mask: S::SimdBool, yes: Self, no: Self) -> Self {
        let values = |c: Self| [c.c0, c.c1, c.c2, c.c3, c.c4, c.c5, c.c6];
        let [c0, c1, c2, c3, c4, c5, c6] = Blend::<S>::blend(mask, values(yes), values(no));
        Self { c0, c1, c2, c3, c4, c5, c6 }
    }
}

/// Σⱼ aⱼ(−x)ʲ up to j = `SERIES_TERMS`: even and odd powers by Horner's rule in x², side by side.
#[cfg_attr(not(debug_assertions), inline(always))]
fn series<S: Real>(a: &[f64; MAX_TERMS + 1], x: S) -> S {
    let (n, y) = (S::SERIES_TERMS, x * x);
    let (mut even, mut odd) = (S::lit(a[n]), S::lit(a[n - 1]));
    for j in (1..n / 2).rev() {
        even = S::lit(a[2 * j]) + y * even;
        odd = S::lit(a[2 * j - 1]) + y * odd;
    }
    S::lit(a[0]) + (y * even - x * odd)
}

pub(super) const MAX_TERMS: usize = 12;
const C5: [f64; MAX_TERMS + 1] = inverse_factorials(5);
const C6: [f64; MAX_TERMS + 1] = inverse_factorials(6);

/// aⱼ = 1/(k + 2j)!, each rounded once.
pub(super) const fn inverse_factorials(k: usize) -> [f64; MAX_TERMS + 1] {
    let (mut a, mut factorial, mut n) = ([0.0; MAX_TERMS + 1], 1.0, 1);
    while n <= k + 2 * MAX_TERMS {
        factorial *= n as f64;
        if n >= k && (n - k).is_multiple_of(2) {
            a[(n - k) / 2] = 1.0 / factorial;
        }
        n += 1;
    }
    a
}
