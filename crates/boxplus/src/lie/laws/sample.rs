//! What the laws are tried on, and how their numbers are found and compared.

use super::{Verdict, Violation};
use crate::lie::{LieGroup, Real, Tangent};
use nalgebra::{SMatrix, SVector};

/// Lengths of the tangents of one round, as fractions of the radius.
pub(super) const LENGTHS: [f64; 15] =
    [0.0, 1e-12, 1e-9, 1e-7, 1e-5, 1e-4, 1e-3, 0.01, 0.05, 0.16, 0.33, 0.5, 0.7, 0.9, 1.0];
pub(super) const ROUNDS: usize = 6;

/// Three tangents and their elements.
pub(super) struct Sample<G: LieGroup<D>, const D: usize> {
    pub(super) a: Tangent<G::Scalar, D>,
    pub(super) b: Tangent<G::Scalar, D>,
    pub(super) c: Tangent<G::Scalar, D>,
    pub(super) x: G,
    pub(super) y: G,
    pub(super) z: G,
    /// How much a group operation may amplify rounding: the product of the sizes of all adjoints.
    pub(super) scale: f64,
}

impl<G: LieGroup<D>, const D: usize> Sample<G, D> {
    pub(super) fn new(sample: usize, radius: f64) -> Self {
        let a = tangent(sample, 0, radius);
        // Different lengths for the others, and not beyond the cut when they meet.
        let (b, c) = (tangent(sample + 4, 1, 0.5 * radius), tangent(sample + 9, 2, 0.5 * radius));
        let (x, y, z) = (G::exp(&a), G::exp(&b), G::exp(&c));
        let size = |g: &G| 1.0 + largest(&g.adjoint()) + largest(&g.inverse().adjoint());
        Self { a, b, c, x, y, z, scale: size(&x) * size(&y) * size(&z) }
    }
}

/// Σ adᵏ/(k + shift)!, summed in full.
pub(super) fn power_series<S: Real, const D: usize>(ad: &SMatrix<S, D, D>, shift: usize) -> SMatrix<S, D, D> {
    let mut term = SMatrix::identity();
    let mut sum = term;
    for k in 1..60 {
        term = term * ad * S::lit(1.0 / (k + shift) as f64);
        sum += term;
    }
    sum
}

/// Σ B_k·adᵏ/k! with the numbers of Bernoulli: z/(eᶻ − 1), which converges within 2π.
pub(super) fn bernoulli_series<S: Real, const D: usize>(ad: &SMatrix<S, D, D>) -> SMatrix<S, D, D> {
    const TERMS: usize = 170; // (5/2π)¹⁷⁰ < 10⁻¹⁶
    let (mut shares, mut scale) = ([0.0; TERMS], 1.0);
    let (mut power, mut sum) = (SMatrix::<S, D, D>::identity(), SMatrix::zeros());
    for n in 0..TERMS {
        // (eᶻ − 1)/z times the series is 1: B_n/n! = −Σ_{k < n} B_k/k!·1/(n + 1 − k)!.
        let (mut share, mut factorial) = (0.0, 1.0);
        for k in (0..n).rev() {
            factorial *= (n + 1 - k) as f64;
            share -= shares[k] / factorial;
        }
        shares[n] = if n == 0 { 1.0 } else { share };
        // Shares fall like (2π)⁻ⁿ; on their own, powers would overflow in `f32`.
        sum += power * S::lit(shares[n] * scale);
        power = power * ad * S::lit(1.0 / 6.0);
        scale *= 6.0;
    }
    sum
}

/// ∂f/∂τ at 0 by central differences of fourth order: 8(f(h) − f(−h)) − (f(2h) − f(−2h)), over 12h.
pub(super) fn difference<S: Real, const N: usize, const M: usize>(
    f: impl Fn(&SVector<S, N>) -> SVector<S, M>,
) -> SMatrix<S, M, N> {
    let mut jacobian = SMatrix::<S, M, N>::zeros();
    for i in 0..N {
        let at = |s: f64| {
            let mut step = SVector::zeros();
            step[i] = S::lit(s * difference_step::<S>());
            f(&step)
        };
        let column = (at(1.0) - at(-1.0)) * S::lit(8.0) - (at(2.0) - at(-2.0));
        jacobian.set_column(i, &(column / S::lit(12.0 * difference_step::<S>())));
    }
    jacobian
}

/// h = ε^{1/5}, a power of two: truncation h⁴ and rounding ε/h are then alike.
pub(super) fn difference_step<S: Real>() -> f64 {
    if S::EPSILON > 1e-10 { 1.0 / 32.0 } else { 1.0 / 1024.0 }
}

/// h⁴/30·|f⁗′| + ε/h·|f|, with 30-fold room for the fifth derivative and the length of f.
pub(super) fn difference_error<S: Real>() -> f64 {
    let h = difference_step::<S>();
    30.0 * (h * h * h * h / 30.0 + S::EPSILON / h)
}

/// A few dozen roundings.
pub(super) fn rounding<S: Real>() -> f64 {
    32.0 * S::EPSILON
}

pub(super) fn largest<S: Real, const R: usize, const C: usize>(m: &SMatrix<S, R, C>) -> f64 {
    // Not `f64::max`, which would drop a NaN.
    m.iter().map(|x| x.value().abs()).fold(0.0, |a, b| if b <= a { a } else { b })
}

/// A tangent of the sample: its length runs through `LENGTHS`, its direction is generic or, every third time, an axis.
pub(super) fn tangent<S: Real, const D: usize>(sample: usize, stream: usize, radius: f64) -> Tangent<S, D> {
    let length = LENGTHS[sample % LENGTHS.len()] * radius;
    let direction: SVector<f64, D> = draw(sample, stream);
    let axis = SVector::<f64, D>::from_fn(|i, _| f64::from(u8::from(i == sample / 3 % D.max(1))));
    let chosen = if (sample + stream) % 3 == 2 { axis } else { direction.normalize() };
    chosen.map(|x| S::lit(x * length))
}

/// Numbers in (−1, 1), the same in every run.
pub(super) fn draw<S: Real, const N: usize>(sample: usize, stream: usize) -> SVector<S, N> {
    SVector::from_fn(|i, _| {
        // SplitMix64 of the indices.
        let mut z = ((sample * 16 + stream) * 64 + i) as u64;
        z = (z + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        S::lit(((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0)
    })
}
pub(super) fn close<S: Real, const R: usize, const C: usize>(
    law: &'static str,
    left: &SMatrix<S, R, C>,
    right: &SMatrix<S, R, C>,
    bound: f64,
) -> Verdict {
    judge(law, largest(&(left - right)), bound)
}

pub(super) fn same<G: LieGroup<D>, const D: usize>(law: &'static str, x: &G, y: &G, bound: f64) -> Verdict {
    if x == y { Ok(()) } else { judge(law, largest(&x.between(y).log()), bound) }
}

pub(super) fn judge(law: &'static str, error: f64, bound: f64) -> Verdict {
    if error <= bound { Ok(()) } else { Err(Violation { law, error, bound, sample: 0 }) }
}
