//! Moments of random vectors by sampling, each with its standard error.

use nalgebra::{SMatrix, SVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Standard normal numbers, the same in every run.
pub(crate) struct Normal(ChaCha8Rng);

impl Normal {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    pub(crate) fn uniform(&mut self) -> f64 {
        ((self.0.next_u64() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    /// Box & Muller (1958).
    pub(crate) fn vector<const N: usize>(&mut self) -> SVector<f64, N> {
        SVector::from_fn(|_, _| {
            let (u, v) = (self.uniform(), self.uniform());
            (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
        })
    }
}

/// Sampled mean and covariance; entry by entry, their standard errors.
pub(crate) struct Moments<const N: usize> {
    pub(crate) mean: SVector<f64, N>,
    pub(crate) mean_error: SVector<f64, N>,
    pub(crate) covariance: SMatrix<f64, N, N>,
    pub(crate) covariance_error: SMatrix<f64, N, N>,
}

impl<const N: usize> Moments<N> {
    /// Of `runs` draws `(x, c)`: the vector and a control variate, zero-mean with the known covariance `control`. What
    /// x and c share cancels exactly, and the standard error is that of the difference alone.
    pub(crate) fn controlled(
        runs: usize,
        seed: u64,
        control: &SMatrix<f64, N, N>,
        mut draw: impl FnMut(&mut Normal) -> (SVector<f64, N>, SVector<f64, N>),
    ) -> Self {
        let mut normal = Normal::new(seed);
        let (mut m1, mut m2) = (SVector::<f64, N>::zeros(), SMatrix::<f64, N, N>::zeros());
        let (mut s1, mut s2) = (SVector::<f64, N>::zeros(), SMatrix::<f64, N, N>::zeros());
        for _ in 0..runs {
            let (x, c) = draw(&mut normal);
            let (first, second) = (x - c, x * x.transpose() - c * c.transpose());
            m1 += first;
            m2 += second;
            s1 += first.component_mul(&first);
            s2 += second.component_mul(&second);
        }
        let n = runs as f64;
        let (mean, rest) = (m1 / n, m2 / n);
        let error = |square: f64, mean: f64| ((square / n - mean * mean).max(0.0) / n).sqrt();
        Self {
            mean,
            mean_error: (s1).zip_map(&mean, error),
            covariance: control + rest - mean * mean.transpose(),
            covariance_error: s2.zip_map(&rest, error),
        }
    }

    /// Of plain draws.
    pub(crate) fn of(runs: usize, seed: u64, mut draw: impl FnMut(&mut Normal) -> SVector<f64, N>) -> Self {
        Self::controlled(runs, seed, &SMatrix::zeros(), |normal| (draw(normal), SVector::zeros()))
    }

    /// How far a mean is off, in standard errors of the worst coordinate.
    pub(crate) fn mean_off(&self, mean: &SVector<f64, N>) -> f64 {
        worst(&(self.mean - mean), &self.mean_error)
    }

    /// How far a covariance is off, in standard errors of the worst entry.
    pub(crate) fn covariance_off(&self, covariance: &SMatrix<f64, N, N>) -> f64 {
        worst(&(self.covariance - covariance), &self.covariance_error)
    }
}

/// The largest |difference|/error; rounding alone is no difference.
pub(crate) fn worst<const R: usize, const C: usize>(
    difference: &SMatrix<f64, R, C>,
    error: &SMatrix<f64, R, C>,
) -> f64 {
    let off = |d: f64, e: f64| if d.abs() < 1e-13 { 0.0 } else { d.abs() / e };
    difference.zip_map(error, off).max()
}

/// Above this many standard errors no entry of a right formula is found: a few hundred entries are compared, and
/// P(|z| > 4.5) = 7·10⁻⁶.
pub(crate) const AGREES: f64 = 4.5;
/// Beyond this many standard errors a formula is wrong.
pub(crate) const DISAGREES: f64 = 10.0;
