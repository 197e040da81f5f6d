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
        if !(probability > 0.0 && probability < 1.0) {
            return Err(UncertaintyError::NotAProbability { given: probability });
        }
        if self.degrees == 0 {
            return Ok(0.0);
        }
        Ok(self.inverted(|tails| tails.0 - probability, probability))
    }

    /// The two x that leave (1 − `probability`)/2 below and above: where an average of NEES or NIS should lie.
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
        let tail = 0.5 * (1.0 - probability);
        let low = self.quantile(tail)?;
        if self.degrees == 0 {
            return Ok([0.0, 0.0]);
        }
        // By the upper tail, in which a small probability keeps its digits.
        Ok([low, self.inverted(|tails| tail - tails.1, 1.0 - tail)])
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

    /// The zero of a rising function of the tails: Newton steps inside a bracket, from the guess of Wilson & Hilferty (1931).
    fn inverted(self, excess: impl Fn((f64, f64)) -> f64, probability: f64) -> f64 {
        let k = self.degrees as f64;
        let spread = 2.0 / (9.0 * k);
        let cube = 1.0 - spread + normal_quantile(probability) * spread.simd_sqrt();
        // Far down the lower tail P ≈ zᵃ/Γ(a + 1), where the cube is no guess: start from the mean of the bracket instead.
        let (mut low, mut high) = (0.0, f64::INFINITY);
        let mut x = if cube > 0.1 { k * cube * cube * cube } else { 1e-3 * k };
        for _ in 0..200 {
            let off = excess(self.tails(x));
            if off > 0.0 {
                high = x;
            } else {
                low = x;
            }
            let newton = x - off / self.density(x);
            let next = if newton > low && newton < high {
                newton
            } else if high.is_finite() {
                // Halve the exponent while the bracket reaches down to 0.
                if low > 0.0 { 0.5 * (low + high) } else { high / 16.0 }
            } else {
                2.0 * x
            };
            if (next - x).abs() <= 2.0 * f64::EPSILON * x || next == 0.0 {
                return next;
            }
            x = next;
        }
        x
    }
}

/// zᵃe⁻ᶻ/Γ(a + 1) = exp(−a·(u − ln(1 + u)) − δ(a))/√(2πa), u = z/a − 1, δ Stirling's remainder.
fn front(a: f64, z: f64) -> f64 {
    let exponent = a * excess_of_log((z - a) / a) + stirling(a);
    (-exponent).simd_exp() / (core::f64::consts::TAU * a).simd_sqrt()
}

/// u − ln(1 + u) for u > −1.
fn excess_of_log(u: f64) -> f64 {
    if u.abs() > 0.5 {
        return u - u.simd_ln_1p();
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
