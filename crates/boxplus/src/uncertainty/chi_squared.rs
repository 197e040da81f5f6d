//! The χ² distribution: how large a squared Mahalanobis distance is to be expected.
//!
//! P(x) and Q(x) = 1 − P(x) are regularised incomplete gamma functions of a = k/2 and z = x/2, the series below z = a + 1,
//! Lentz's continued fraction above. Their common factor zᵃe⁻ᶻ/Γ(a + 1) is found from z/a and Stirling's remainder, as in
//! Loader (2000), without the difference of large logarithms that costs common implementations a digit per digit of k.

use super::UncertaintyError;
use nalgebra::SimdComplexField;

/// χ² with k degrees of freedom: the sum of k squared standard normal numbers.
///
/// ```
/// use boxplus::uncertainty::ChiSquared;
/// // A pose has 6 coordinates: 95 % of all errors have ξᵀΣ⁻¹ξ below
/// let threshold = ChiSquared::new(6).quantile(0.95)?;
/// assert!((threshold - 12.591587243743977).abs() < 1e-12);
/// # Ok::<(), boxplus::uncertainty::UncertaintyError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChiSquared {
    degrees: usize,
}

/// Terms after which series and fraction have converged: near z = a they need a few √a, here for a to 10⁹.
const TERMS: usize = 200_000;

impl ChiSquared {
    /// With `degrees` = k; of 0 degrees, x = 0 is certain.
    pub fn new(degrees: usize) -> Self {
        Self { degrees }
    }

    /// P(X ≤ x).
    pub fn cdf(&self, x: f64) -> f64 {
        self.tails(x).0
    }

    /// P(X > x), without the cancellation of 1 − P.
    pub fn survival(&self, x: f64) -> f64 {
        self.tails(x).1
    }

    /// The x with P(X ≤ x) = `probability`, 0 < `probability` < 1.
    ///
    /// # Errors
    /// [`UncertaintyError::NotAProbability`].
    pub fn quantile(&self, probability: f64) -> Result<f64, UncertaintyError> {
        checked(probability)?;
        if self.degrees == 0 {
            return Ok(0.0);
        }
        Ok(self.inverted(Tail::Lower, probability))
    }

    /// The two x that leave (1 − `probability`)/2 below and above, 0 < `probability` < 1: where an average of NEES or NIS should
    /// lie.
    ///
    /// ```
    /// use boxplus::uncertainty::ChiSquared;
    /// let (n, runs) = (6, 50); // the average NEES of 50 runs with 6 coordinates, 95 %
    /// let [low, high] = ChiSquared::new(n * runs).interval(0.95)?.map(|x| x / runs as f64);
    /// assert!((low - 5.078).abs() < 5e-4 && (high - 6.997).abs() < 5e-4);
    /// # Ok::<(), boxplus::uncertainty::UncertaintyError>(())
    /// ```
    ///
    /// # Errors
    /// [`UncertaintyError::NotAProbability`].
    pub fn interval(&self, probability: f64) -> Result<[f64; 2], UncertaintyError> {
        checked(probability)?;
        let tail = 0.5 * (1.0 - probability);
        let low = self.quantile(tail)?;
        if self.degrees == 0 {
            return Ok([0.0, 0.0]);
        }
        // By the upper tail, in which a small probability keeps its digits.
        Ok([low, self.inverted(Tail::Upper, tail)])
    }

    /// P and Q at x.
    fn tails(self, x: f64) -> (f64, f64) {
        let (a, z) = (0.5 * self.degrees as f64, 0.5 * x);
        if x.is_nan() {
            return (f64::NAN, f64::NAN);
        }
        if z <= 0.0 {
            return if self.degrees == 0 && x >= 0.0 { (1.0, 0.0) } else { (0.0, 1.0) };
        }
        if self.degrees == 0 || z == f64::INFINITY {
            return (1.0, 0.0);
        }
        if z < a + 1.0 {
            let p = (front(a, z) * series(a, z)).min(1.0);
            (p, 1.0 - p)
        } else {
            let q = (front(a, z) * a * fraction(a, z)).min(1.0);
            (1.0 - q, q)
        }
    }

    /// dP/dx.
    fn density(self, x: f64) -> f64 {
        let (a, z) = (0.5 * self.degrees as f64, 0.5 * x);
        0.5 * front(a, z) * a / z
    }

    /// The x whose tail is `target`: Newton steps on the logarithm of the tail, which is concave, inside a bracket.
    fn inverted(self, tail: Tail, target: f64) -> f64 {
        let (mut low, mut high) = (0.0, f64::INFINITY);
        let mut x = self.guess(if tail == Tail::Lower { target } else { 1.0 - target });
        for _ in 0..200 {
            let (p, q) = self.tails(x);
            let step = match tail {
                Tail::Lower => -p * (p / target).simd_ln(),
                Tail::Upper => q * (q / target).simd_ln(),
            } / self.density(x);
            if (p > target && tail == Tail::Lower) || (q < target && tail == Tail::Upper) {
                high = x;
            } else {
                low = x;
            }
            let newton = x + step;
            let next = if newton > low && newton < high {
                newton
            } else if high == f64::INFINITY {
                2.0 * x
            } else if low > 0.0 {
                0.5 * (low + high)
            } else {
                high / 16.0
            };
            if (next - x).abs() <= 2.0 * f64::EPSILON * x || next == 0.0 {
                return next;
            }
            x = next;
        }
        x
    }

    /// The cube of Wilson & Hilferty (1931), or far down the lower tail, where it is no guess, P ≈ zᵃ/Γ(a + 1).
    fn guess(self, probability: f64) -> f64 {
        let k = self.degrees as f64;
        let spread = 2.0 / (9.0 * k);
        let cube = 1.0 - spread + normal_quantile(probability) * spread.simd_sqrt();
        if cube > 0.1 {
            return k * cube * cube * cube;
        }
        let a = 0.5 * k;
        let log_gamma = stirling(a) + (a + 0.5) * a.simd_ln() - a + 0.5 * core::f64::consts::TAU.simd_ln();
        2.0 * ((probability.simd_ln() + log_gamma) / a).simd_exp()
    }
}

/// Neither impossible nor certain.
fn checked(probability: f64) -> Result<(), UncertaintyError> {
    if probability > 0.0 && probability < 1.0 {
        Ok(())
    } else {
        Err(UncertaintyError::NotAProbability { given: probability })
    }
}

/// Which side of x a probability counts.
#[derive(Clone, Copy, PartialEq)]
enum Tail {
    Lower,
    Upper,
}

/// zᵃe⁻ᶻ/Γ(a + 1) = exp(−a·(u − ln(1 + u)) − δ(a))/√(2πa), u = z/a − 1, δ Stirling's remainder.
fn front(a: f64, z: f64) -> f64 {
    let exponent = a * excess_of_log((z - a) / a, z / a) + stirling(a);
    (-exponent).simd_exp() / (core::f64::consts::TAU * a).simd_sqrt()
}

/// u − ln r for r = 1 + u > 0; each is given, because one of them has lost the digits of the other.
fn excess_of_log(u: f64, r: f64) -> f64 {
    if u.abs() > 0.5 {
        return u - r.simd_ln();
    }
    // With v = u/(2 + u), ln(1 + u) = 2(v + v³/3 + v⁵/5 + …), and u − 2v = uv.
    let v = u / (2.0 + u);
    let (mut power, mut sum) = (v * v * v, 0.0);
    for k in 1..20 {
        sum += power / f64::from(2 * k + 1);
        power *= v * v;
    }
    u * v - 2.0 * sum
}

/// δ(a) = ln Γ(a + 1) − (a + ½)ln a + a − ½ ln 2π, for a = ½, 1, 3/2, …
fn stirling(a: f64) -> f64 {
    if a >= 8.0 {
        // The series in 1/a; the next term is 3617/(122400·a¹⁵) < 1e-15.
        let x = 1.0 / (a * a);
        let coefficients =
            [1.0 / 156.0, -691.0 / 360360.0, 1.0 / 1188.0, -1.0 / 1680.0, 1.0 / 1260.0, -1.0 / 360.0];
        let rest = coefficients.iter().fold(0.0, |sum, c| (sum + c) * x);
        return (1.0 / 12.0 + rest) / a;
    }
    // Γ(a + 1) by its recurrence from Γ(1) = 1 or Γ(½) = √π.
    let half_odd = (2.0 * a) % 2.0 == 1.0;
    let (mut factor, mut gamma) =
        if half_odd { (0.5, core::f64::consts::PI.simd_sqrt()) } else { (1.0, 1.0) };
    while factor <= a {
        gamma *= factor;
        factor += 1.0;
    }
    let half_log = 0.5 * core::f64::consts::TAU.simd_ln();
    gamma.simd_ln() - (a + 0.5) * a.simd_ln() + a - half_log
}

/// Σ zⁿ/((a + 1)…(a + n)), n from 0: P = front·series.
fn series(a: f64, z: f64) -> f64 {
    let (mut term, mut sum) = (1.0, 1.0);
    for n in 1..TERMS {
        term *= z / (a + n as f64);
        sum += term;
        if term < sum * f64::EPSILON * 0.25 {
            break;
        }
    }
    sum
}

/// Q·Γ(a)/(zᵃe⁻ᶻ) = 1/(z + 1 − a − 1(1 − a)/(z + 3 − a − …)), by the modified method of Lentz (1976).
fn fraction(a: f64, z: f64) -> f64 {
    let mut b = z + 1.0 - a;
    let mut c = 1.0 / f64::MIN_POSITIVE;
    let mut d = 1.0 / b;
    let mut h = d;
    for n in 1..TERMS {
        let i = n as f64;
        let an = -i * (i - a);
        b += 2.0;
        let guarded = |x: f64| if x.abs() < f64::MIN_POSITIVE { f64::MIN_POSITIVE } else { x };
        d = 1.0 / guarded(an * d + b);
        c = guarded(b + an / c);
        let factor = d * c;
        h *= factor;
        if (factor - 1.0).abs() < f64::EPSILON {
            break;
        }
    }
    h
}

/// The standard normal quantile to 4.5e-4: a first guess only. Abramowitz & Stegun (1964) 26.2.23.
fn normal_quantile(p: f64) -> f64 {
    let tail = p.min(1.0 - p);
    let t = (-2.0 * tail.simd_ln()).simd_sqrt();
    let numerator = 2.515517 + t * (0.802853 + t * 0.010328);
    let x = t - numerator / (1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
    if p < 0.5 { -x } else { x }
}
