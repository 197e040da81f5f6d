//! Robust kernels: how much a large residual may pull.
//!
//! A kernel maps s = ‖U·r‖² ≥ 0 to ρ(s), with ρ(0) = 0 and ρ′(0) = 1, and the cost of a factor is ½ρ(s). The solver
//! reweights: it multiplies the factor's part of the normal equations by ρ′(s), the exact gradient of the cost.

use core::str::FromStr;

/// A robust kernel. Scales are in units of the whitened residual: 1 is one standard deviation.
///
/// ```
/// use boxplus::graph::Kernel;
/// let kernel = Kernel::Huber(1.0);
/// assert_eq!(kernel.rho(0.25), 0.25); // below one sigma: least squares
/// assert_eq!(kernel.rho(9.0), 5.0); // beyond: 2·3 − 1
/// assert_eq!("cauchy:2.5".parse(), Ok(Kernel::Cauchy(2.5)));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum Kernel {
    /// ρ = s: least squares.
    #[default]
    None,
    /// ρ = s for s ≤ k², else 2k√s − k². Huber (1964).
    Huber(f64),
    /// ρ = 2k²(√(1 + s/k²) − 1), a smooth Huber; Ceres calls it soft L1. Charbonnier et al. (1997).
    PseudoHuber(f64),
    /// ρ = k² ln(1 + s/k²); also called Lorentzian.
    Cauchy(f64),
    /// ρ = k²s/(k² + s). Geman & McClure (1987).
    GemanMcClure(f64),
    /// ρ = k²(1 − exp(−s/k²)). Dennis & Welsch (1978).
    Welsch(f64),
    /// ρ = k²/3·(1 − (1 − s/k²)³) for s ≤ k², else k²/3: outliers do not pull at all. Beaton & Tukey (1974).
    Tukey(f64),
    /// ρ = 2k²(√s/k − ln(1 + √s/k)). Fair (1974).
    Fair(f64),
    /// Dynamic covariance scaling: ρ = s for s ≤ k, else 4ks/(k + s) − k. Agarwal et al. (2013), MacTavish & Barfoot (2015).
    Dcs(f64),
    /// Truncated least squares, ρ = min(s, k²), with its corner rounded between k²/(1 + β) and k²(1 + β):
    /// ρ = (2k√(1 + β)√s − k² − s)/β there. β = 0 is sharp. Yang et al. (2020), eq. 12, with β = 1/μ.
    Truncated {
        /// Scale k > 0.
        scale: f64,
        /// Spread β ≥ 0 of the corner.
        spread: f64,
    },
    /// Barron's general kernel (2019), twice his loss: ρ = 2c²|α − 2|/α·((s/c²/|α − 2| + 1)^(α/2) − 1) and its limits.
    /// α = 2 is least squares, 1 pseudo-Huber, 0 Cauchy, −2 Geman–McClure, −∞ Welsch (with other scales).
    Barron {
        /// Shape α ≤ 2.
        alpha: f64,
        /// Scale c > 0.
        scale: f64,
    },
}

impl Kernel {
    /// The names that [`FromStr`] knows.
    pub const NAMES: [&'static str; 11] = [
        "none",
        "huber",
        "pseudo-huber",
        "cauchy",
        "geman-mcclure",
        "welsch",
        "tukey",
        "fair",
        "dcs",
        "truncated",
        "barron",
    ];

    /// Whether the scale is finite and positive (and Barron's shape at most 2).
    pub fn is_valid(&self) -> bool {
        let (shape, scale) = match *self {
            Self::None => return true,
            Self::Huber(k)
            | Self::PseudoHuber(k)
            | Self::Cauchy(k)
            | Self::GemanMcClure(k)
            | Self::Welsch(k)
            | Self::Tukey(k)
            | Self::Fair(k)
            | Self::Dcs(k) => (2.0, k),
            Self::Truncated { scale, spread } => {
                return spread >= 0.0 && spread.is_finite() && scale > 0.0 && scale.is_finite();
            }
            Self::Barron { alpha, scale } => (alpha, scale),
        };
        shape <= 2.0 && scale > 0.0 && scale.is_finite()
    }

    /// ρ(s) of the squared whitened residual.
    pub fn rho(&self, s: f64) -> f64 {
        self.evaluate(s).0
    }

    /// ρ′(s), the weight of the factor: 1 for a perfect fit, towards 0 for an outlier.
    pub fn weight(&self, s: f64) -> f64 {
        self.evaluate(s).1
    }

    /// `(ρ(s), ρ′(s))`.
    #[inline]
    pub(crate) fn evaluate(&self, s: f64) -> (f64, f64) {
        match *self {
            Self::None => (s, 1.0),
            Self::Huber(k) => {
                if s <= k * k {
                    (s, 1.0)
                } else {
                    (2.0 * k * s.sqrt() - k * k, k / s.sqrt())
                }
            }
            Self::PseudoHuber(k) => {
                let root = (1.0 + s / (k * k)).sqrt();
                (2.0 * s / (root + 1.0), root.recip()) // 2k²(root − 1) without the cancellation
            }
            Self::Cauchy(k) => (k * k * (s / (k * k)).ln_1p(), k * k / (k * k + s)),
            Self::GemanMcClure(k) => {
                let w = k * k / (k * k + s);
                (s * w, w * w)
            }
            Self::Welsch(k) => (-k * k * (-s / (k * k)).exp_m1(), (-s / (k * k)).exp()),
            Self::Tukey(k) => {
                let u = s / (k * k);
                if u < 1.0 { (s * (1.0 - u + u * u / 3.0), (1.0 - u).powi(2)) } else { (k * k / 3.0, 0.0) }
            }
            Self::Fair(k) => {
                let u = s.sqrt() / k;
                (2.0 * k * k * (u - u.ln_1p()), (1.0 + u).recip())
            }
            Self::Dcs(k) => {
                if s <= k {
                    (s, 1.0)
                } else {
                    (4.0 * k * s / (k + s) - k, (2.0 * k / (k + s)).powi(2))
                }
            }
            Self::Truncated { scale, spread } => truncated(s, scale * scale, spread),
            Self::Barron { alpha, scale } => barron(s, alpha, scale),
        }
    }
}

fn truncated(s: f64, bound: f64, spread: f64) -> (f64, f64) {
    let corner = 1.0 + spread;
    if s * corner <= bound {
        (s, 1.0)
    } else if s >= bound * corner {
        (bound, 0.0)
    } else {
        let root = (corner * bound).sqrt();
        ((2.0 * root * s.sqrt() - bound - s) / spread, (root / s.sqrt() - 1.0) / spread)
    }
}

fn barron(s: f64, alpha: f64, scale: f64) -> (f64, f64) {
    let c2 = scale * scale;
    if alpha == 0.0 {
        let u = s / (2.0 * c2);
        return (2.0 * c2 * u.ln_1p(), (1.0 + u).recip());
    }
    if alpha == f64::NEG_INFINITY {
        let u = s / (2.0 * c2);
        return (-2.0 * c2 * (-u).exp_m1(), (-u).exp());
    }
    let b = 2.0 - alpha;
    if b < 1e-12 {
        return (s, 1.0);
    }
    let log = (s / (c2 * b)).ln_1p();
    (2.0 * c2 * b / alpha * (0.5 * alpha * log).exp_m1(), ((0.5 * alpha - 1.0) * log).exp())
}

/// A kernel's text was not understood.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "`{text}` is no robust kernel; write NAME or NAME:SCALE (barron:SHAPE:SCALE) with a positive scale, NAME one of none, huber, pseudo-huber, cauchy, geman-mcclure, welsch, tukey, fair, dcs, truncated, barron"
)]
pub struct KernelError {
    /// What was written.
    pub text: String,
}

impl FromStr for Kernel {
    type Err = KernelError;

    /// `NAME`, `NAME:SCALE` or `barron:SHAPE:SCALE`; the scale is 1 where it is left out.
    fn from_str(text: &str) -> Result<Self, KernelError> {
        let error = || KernelError { text: text.to_owned() };
        let mut parts = text.split(':');
        let name = parts.next().unwrap_or_default();
        let numbers: Vec<f64> = parts.map(str::parse).collect::<Result<_, _>>().map_err(|_| error())?;
        let scale = numbers.last().copied().unwrap_or(1.0);
        let expected = usize::from(name == "barron");
        let count = numbers.len();
        if count > expected + 1 || (name == "none" && count > 0) {
            return Err(error());
        }
        let kernel = match name {
            "none" => Self::None,
            "huber" => Self::Huber(scale),
            "pseudo-huber" => Self::PseudoHuber(scale),
            "cauchy" => Self::Cauchy(scale),
            "geman-mcclure" => Self::GemanMcClure(scale),
            "welsch" => Self::Welsch(scale),
            "tukey" => Self::Tukey(scale),
            "fair" => Self::Fair(scale),
            "dcs" => Self::Dcs(scale),
            "truncated" => Self::Truncated { scale, spread: 0.0 },
            "barron" if count == 2 => Self::Barron { alpha: numbers[0], scale },
            _ => return Err(error()),
        };
        if kernel.is_valid() { Ok(kernel) } else { Err(error()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kernels() -> Vec<Kernel> {
        let mut kernels = vec![
            Kernel::None,
            Kernel::Huber(1.3),
            Kernel::PseudoHuber(1.3),
            Kernel::Cauchy(1.3),
            Kernel::GemanMcClure(1.3),
            Kernel::Welsch(1.3),
            Kernel::Tukey(1.3),
            Kernel::Fair(1.3),
            Kernel::Dcs(1.3),
            Kernel::Truncated { scale: 1.3, spread: 0.0 },
            Kernel::Truncated { scale: 1.3, spread: 4.0 },
        ];
        let shapes = [2.0, 1.5, 1.0, 0.0, -2.0, -7.0, f64::NEG_INFINITY];
        kernels.extend(shapes.map(|alpha| Kernel::Barron { alpha, scale: 0.7 }));
        kernels
    }

    #[test]
    fn the_weight_is_the_derivative_of_rho() {
        for kernel in kernels() {
            for s in [0.01, 0.3, 1.0, 1.6, 1.8, 5.0, 100.0] {
                let h = 1e-5 * s; // h²/s² ≈ 1e-10 relative, ε/h ≈ 2e-11
                let slope = (kernel.rho(s + h) - kernel.rho(s - h)) / (2.0 * h);
                assert!((slope - kernel.weight(s)).abs() < 2e-9, "{kernel:?} at {s}: {slope}");
            }
        }
    }

    #[test]
    fn every_kernel_is_least_squares_for_small_residuals() {
        for kernel in kernels() {
            assert_eq!(kernel.rho(0.0), 0.0, "{kernel:?}");
            assert!((kernel.weight(1e-18) - 1.0).abs() < 1e-8, "{kernel:?}");
            assert!((kernel.rho(1e-12) / 1e-12 - 1.0).abs() < 1e-5, "{kernel:?}"); // Fair: 1 − ⅔√s/k
        }
    }

    #[test]
    fn no_kernel_exceeds_least_squares_nor_gains_weight() {
        for kernel in kernels() {
            let mut last = 1.0;
            for s in (0..200).map(|i| f64::from(i) * 0.1) {
                let (rho, weight) = kernel.evaluate(s);
                assert!(rho <= s * (1.0 + 1e-14) && weight <= last + 1e-15, "{kernel:?} at {s}");
                last = weight;
            }
        }
    }

    #[test]
    fn special_shapes_of_barron_are_the_named_kernels() {
        for s in [0.1, 1.0, 30.0] {
            let pairs = [
                (Kernel::Barron { alpha: 1.0, scale: 1.3 }, Kernel::PseudoHuber(1.3)),
                (Kernel::Barron { alpha: 0.0, scale: 1.3 }, Kernel::Cauchy(1.3 * 2f64.sqrt())),
                (Kernel::Barron { alpha: -2.0, scale: 1.3 }, Kernel::GemanMcClure(2.6)),
                (Kernel::Barron { alpha: f64::NEG_INFINITY, scale: 1.3 }, Kernel::Welsch(1.3 * 2f64.sqrt())),
            ];
            for (general, named) in pairs {
                assert!((general.rho(s) - named.rho(s)).abs() < 1e-13 * s.max(1.0), "{named:?} at {s}");
            }
        }
    }

    #[test]
    fn kernels_are_read_from_text() {
        for name in Kernel::NAMES.iter().filter(|name| **name != "barron") {
            assert!(name.parse::<Kernel>().is_ok(), "{name}");
        }
        assert_eq!("barron:-2:0.5".parse(), Ok(Kernel::Barron { alpha: -2.0, scale: 0.5 }));
        for bad in ["", "hubert", "huber:-1", "huber:0", "huber:nan", "huber:1:2", "barron:3:1", "none:1"] {
            assert!(bad.parse::<Kernel>().is_err(), "{bad}");
        }
    }
}
