//! Lenses whose image lies at the radius r·g(r²), g(t) = 1 + k₁t + … + k_N·t^N, where r is a tangent or an angle.

use crate::lie::Real;

/// g(t) and g′(t), by Horner's rule.
#[inline]
pub(super) fn growth<S: Real, const N: usize>(k: &[S; N], t: S) -> (S, S) {
    let (mut value, mut slope) = (S::zero(), S::zero());
    for &k in k.iter().rev() {
        slope = slope * t + value;
        value = value * t + k;
    }
    (value * t + S::one(), slope * t + value)
}

/// Whether r·g(r²) rises all the way from 0 to r = √t: up to its first fold, beyond which the lens is no lens.
pub(super) fn rises<S: Real, const N: usize>(k: &[S; N], t: S) -> bool {
    // Its derivative 1 + Σ (2i + 1)·kᵢ·tⁱ as a polynomial of degree 4 over [0, 1].
    let mut slope = [1.0, 0.0, 0.0, 0.0, 0.0];
    let mut power = 1.0;
    for (i, k) in k.iter().enumerate().take(4) {
        power *= t.value();
        slope[i + 1] = (2 * i + 3) as f64 * k.value() * power;
    }
    positive(bernstein(slope), 24)
}

/// A polynomial of degree 4 by its coefficients in Bernstein's basis, between whose least and largest it stays on [0, 1].
fn bernstein(a: [f64; 5]) -> [f64; 5] {
    let [a0, a1, a2, a3, a4] = a;
    [
        a0,
        a0 + a1 / 4.0,
        a0 + a1 / 2.0 + a2 / 6.0,
        a0 + 0.75 * a1 + a2 / 2.0 + a3 / 4.0,
        a0 + a1 + a2 + a3 + a4,
    ]
}

/// Whether it is positive on [0, 1]: halved until its coefficients tell (de Casteljau), or the end is so small that it counts as a root.
fn positive(b: [f64; 5], halvings: u32) -> bool {
    if b.iter().all(|b| *b > 0.0) {
        return true;
    }
    if halvings == 0 || !(b[0] > 0.0 && b[4] > 0.0) {
        return false;
    }
    let (mut left, mut right) = (b, b);
    for level in 1..5 {
        for i in (level..5).rev() {
            left[i] = 0.5 * (left[i - 1] + left[i]);
        }
        for i in 0..5 - level {
            right[i] = 0.5 * (right[i] + right[i + 1]);
        }
    }
    positive(left, halvings - 1) && positive(right, halvings - 1)
}

/// The r ≥ 0 before the first fold with r·g(r²) = `radius` ≥ 0; `None` where the lens does not reach so far.
///
/// Newton's method between bounds that close in. The last step is taken in `S`, so that derivatives are right, too.
pub(super) fn inverse<S: Real, const N: usize>(k: &[S; N], radius: S) -> Option<S> {
    let numbers = k.map(Real::value);
    let target = radius.value();
    let (mut low, mut high) = (0.0, f64::INFINITY);
    let mut r = target;
    for _ in 0..200 {
        if !rises(&numbers, r * r) {
            high = r;
            r = 0.5 * (low + high);
            continue;
        }
        let (g, slope) = growth(&numbers, r * r);
        let (miss, slope) = (r * g - target, g + 2.0 * r * r * slope);
        // An ulp of each of two products, and that of the sum.
        if miss.abs() <= 4.0 * S::EPSILON * target {
            let r = S::lit(r);
            let (g, d) = growth(k, r * r);
            return Some(r - (r * g - radius) / (g + r * r * d * S::lit(2.0)));
        }
        if miss > 0.0 {
            high = r;
        } else {
            low = r;
        }
        let newton = r - miss / slope;
        r = if low < newton && newton < high { newton } else { 0.5 * (low + high.min(2.0 * r)) };
    }
    None
}
