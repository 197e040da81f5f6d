//! Sine, cosine, exponential and the angle of a unit vector, without a branch.
//!
//! A loop over these becomes vector instructions, which a call into a mathematical library never does; and one call costs less
//! than the library's. All are within 1 ulp on the ranges named; outside, [`Real`] asks the platform's library for single
//! numbers, and lanes give NaN. Coefficients are from `scripts/elementary_coefficients.py`.

use super::Real;

/// |x| up to which [`sin_cos`] holds: beyond, three pieces of π/2 are too few for a number next to one of its multiples.
pub(super) const SIN_COS_END: f64 = 65536.0;
/// |x| up to which [`exp`] holds: beyond lie overflow and subnormal results.
pub(super) const EXP_END: f64 = 708.0;

/// 1.5·2⁵²: adding it rounds to a whole number, which then stands in the lowest bits.
const ROUND: f64 = 6755399441055744.0;

/// (sin x, cos x).
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn sin_cos(x: f64) -> (f64, f64) {
    // The pieces have 33 bits, so that their products with n are exact. Cody and Waite (1980).
    const PIECES: [f64; 3] =
        [f64::from_bits(0x3ff921fb54400000), f64::from_bits(0x3dd0b4611a600000), 2.0222662487959506e-21];
    let shifted = x * core::f64::consts::FRAC_2_PI + ROUND;
    let (quadrant, n) = (shifted.to_bits(), shifted - ROUND);
    let (near, piece) = (x - n * PIECES[0], n * PIECES[1]);
    let high = near - piece;
    let low = (near - high) - piece - n * PIECES[2];
    // x = n·π/2 + r + low with r in [−π/4, π/4].
    let r = high + low;
    let (low, z) = (low - (r - high), r * r);
    let sin = r + (r * z * polynomial(&SIN, z) + low * (1.0 - 0.5 * z));
    let half = 0.5 * z;
    let one = 1.0 - half;
    let cos = one + ((1.0 - one - half) + (z * z * polynomial(&COS, z) - r * low));
    let (s, c) = if quadrant & 1 == 0 { (sin, cos) } else { (cos, sin) };
    let signed = |v: f64, q: u64| f64::from_bits(v.to_bits() ^ ((q & 2) << 62));
    (signed(s, quadrant), signed(c, quadrant.wrapping_add(1)))
}

/// eˣ.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn exp(x: f64) -> f64 {
    // ln 2 in two pieces, the first of 33 bits.
    const LN2: [f64; 2] = [f64::from_bits(0x3fe62e42fee00000), f64::from_bits(0x3dea39ef35793c76)];
    let shifted = x * core::f64::consts::LOG2_E + ROUND;
    let n = shifted - ROUND;
    let (high, low) = (x - n * LN2[0], n * LN2[1]);
    let r = high - low;
    let rest = (high - r) - low;
    let e = 1.0 + (r + (r * r * polynomial(&EXP, r) + rest));
    // e·2ⁿ by its exponent.
    f64::from_bits(e.to_bits().wrapping_add(shifted.to_bits() << 52))
}

/// acos(w)/√(1 − w²) = θ/sin θ for w = cos θ in \[0, 1\]: 1 at 1 and π/2 at 0, with every derivative.
///
/// What turns the vector part of a unit quaternion into half its logarithm. It is analytic for w > −1, so that one polynomial
/// in 1 − w replaces a root, a quotient, an arc tangent and the care for small angles.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn arc<S: Real>(w: S) -> S {
    let u = S::one() - w;
    S::one() + u * if S::EPSILON > 1e-10 { polynomial(&ARC_SINGLE, u) } else { polynomial(&ARC, u) }
}

/// Σ aⱼxʲ: even and odd powers by Horner's rule in x², side by side. Few and short steps, which a compiler writes out; a loop
/// that stayed one would keep batches from being vectorised.
#[cfg_attr(not(debug_assertions), inline(always))]
fn polynomial<S: Real, const N: usize>(a: &[f64; N], x: S) -> S {
    let (mut even, mut odd, y) = (S::zero(), S::zero(), x * x);
    for j in (0..N.div_ceil(2)).rev() {
        even = even * y + S::lit(a[2 * j]);
        if let Some(a) = a.get(2 * j + 1) {
            odd = odd * y + S::lit(*a);
        }
    }
    even + x * odd
}

/// Relative error 2.0e-17.
const SIN: [f64; 6] = [
    -0.16666666666666666,
    0.008333333333330948,
    -0.00019841269836758574,
    2.755731610255244e-06,
    -2.5051131845003624e-08,
    1.5918129294866608e-10,
];
/// Relative error 1.3e-18.
const COS: [f64; 6] = [
    0.041666666666666664,
    -0.0013888888888887398,
    2.480158729876569e-05,
    -2.7557317271729793e-07,
    2.08761462684032e-09,
    -1.1382632425521717e-11,
];
/// Relative error 1.6e-17.
const EXP: [f64; 10] = [
    0.5000000000000001,
    0.16666666666666669,
    0.041666666666624164,
    0.008333333333330065,
    0.0013888888917196719,
    0.00019841269863040545,
    2.4801521322368692e-05,
    2.7557268480310024e-06,
    2.7620075879983367e-07,
    2.5100375832561234e-08,
];
/// Relative error 3.2e-17.
const ARC: [f64; 21] = [
    0.33333333333333337,
    0.1333333333333216,
    0.057142857144574496,
    0.025396825297269287,
    0.011544014593116173,
    0.0053279483088366185,
    0.0024871121300071887,
    0.0011638546001328132,
    0.0005940854424188283,
    7.211352983263087e-05,
    0.000833000937426987,
    -0.0019569674992866073,
    0.0045212623352351,
    -0.007800214739855487,
    0.010588885862776898,
    -0.011041195077543494,
    0.008721864552393708,
    -0.005044212363588533,
    0.002023068410342283,
    -0.0005042029562849602,
    5.9559620437726244e-05,
];
/// Relative error 6.1e-09.
const ARC_SINGLE: [f64; 10] = [
    0.3333333283713902,
    0.13333432331819872,
    0.057110587904944644,
    0.025800378262564438,
    0.009014792396712372,
    0.014275146695682042,
    -0.01629899420924802,
    0.02459185104827352,
    -0.01574707684781099,
    0.005381980214801952,
];
