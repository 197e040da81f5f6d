//! From samples to a Gaussian and back.

use super::{Covariance, Gaussian, Side, UncertaintyError};
use crate::lie::{LieGroup, Real, Tangent};
use nalgebra::{SMatrix, SimdComplexField};

/// Mean and covariance of samples, and how they were found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampled<G: LieGroup<D>, const D: usize, E: Side> {
    /// Mean Σ Log(X̄⁻¹Xᵢ) = 0 and covariance Σ ξξᵀ/(n − 1). Of n ≤ D samples it has no more than rank n − 1.
    pub gaussian: Gaussian<G, D, E>,
    /// How many samples.
    pub count: usize,
    /// Steps to the mean.
    pub iterations: usize,
    /// Length of the last one.
    pub step: f64,
}

impl<G: LieGroup<D>, const D: usize, E: Side> Gaussian<G, D, E> {
    /// The mean of samples and the covariance about it. The mean is the bi-invariant one, Pennec & Arsigny (2013): it needs
    /// no metric and is the same on both sides.
    ///
    /// ```
    /// use boxplus::lie::{LieGroup, SE2};
    /// use boxplus::uncertainty::Gaussian;
    /// use nalgebra::vector;
    /// let fixes = [0.1, -0.1, 0.2].map(|e| SE2::new(vector![1.0, e], 0.5 * e));
    /// let sampled = Gaussian::<SE2, 3>::from_samples(&fixes)?;
    /// assert_eq!(sampled.gaussian.covariance().rank(), 2); // three samples span no more
    /// # Ok::<(), boxplus::uncertainty::UncertaintyError>(())
    /// ```
    ///
    /// # Errors
    /// [`UncertaintyError::TooFew`] of fewer than two; [`UncertaintyError::NotConverged`] where they are too dispersed to have a
    /// mean; [`UncertaintyError::NotFinite`].
    pub fn from_samples(samples: &[G]) -> Result<Sampled<G, D, E>, UncertaintyError> {
        let count = samples.len();
        let [start, _, ..] = samples else {
            return Err(UncertaintyError::TooFew { given: count, needed: 2 });
        };
        let (mean, iterations, step) = mean::<G, D, E>(start, samples)?;
        let scatter = samples.iter().fold(SMatrix::zeros(), |sum: SMatrix<G::Scalar, D, D>, x| {
            let xi = E::error(x, &mean);
            sum + xi * xi.transpose()
        });
        let covariance = Covariance::new(scatter * G::Scalar::lit(1.0 / (count - 1) as f64))?;
        Ok(Sampled { gaussian: Gaussian::new(mean, covariance), count, iterations, step })
    }
}

/// The fixed point X̄ ⊞ mean of errors = X̄: `(mean, iterations, last step)`.
fn mean<G: LieGroup<D>, const D: usize, E: Side>(
    start: &G,
    samples: &[G],
) -> Result<(G, usize, f64), UncertaintyError> {
    const ITERATIONS: usize = 100;
    let (mut mean, mut length) = (*start, 0.0);
    for iteration in 1..=ITERATIONS {
        let (mut sum, mut spread) = (Tangent::<G::Scalar, D>::zeros(), 0.0_f64);
        for xi in samples.iter().map(|x| E::error(x, &mean)) {
            sum += xi;
            spread = spread.max(xi.norm_squared().value());
        }
        let step = sum * G::Scalar::lit(1.0 / samples.len() as f64);
        mean = E::perturb(&mean, &step);
        length = step.norm_squared().value().simd_sqrt();
        if length <= 64.0 * G::Scalar::EPSILON * (1.0 + spread.simd_sqrt()) {
            return Ok((mean, iteration, length));
        }
    }
    Err(UncertaintyError::NotConverged { iterations: ITERATIONS, step: length })
}

#[cfg(feature = "rand")]
impl<G: LieGroup<D>, const D: usize, E: Side> Gaussian<G, D, E> {
    /// A draw: X̄ ⊞ L·η with η standard normal and Σ = LLᵀ; directions without variance stay exactly as they are.
    ///
    /// ```
    /// use boxplus::lie::{LieGroup, SE2};
    /// use boxplus::uncertainty::Gaussian;
    /// use nalgebra::vector;
    /// use rand_chacha::rand_core::SeedableRng;
    /// let pose = Gaussian::<SE2, 3>::from_sigmas(SE2::identity(), &vector![0.1, 0.0, 0.02])?;
    /// let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    /// let draws: Vec<_> = (0..1000).map(|_| pose.sample(&mut rng)).collect();
    /// let again = Gaussian::<SE2, 3>::from_samples(&draws)?.gaussian;
    /// assert!((again.sigmas() - pose.sigmas()).amax() < 0.01);
    /// # Ok::<(), boxplus::uncertainty::UncertaintyError>(())
    /// ```
    pub fn sample(&self, rng: &mut impl rand::Rng) -> G {
        self.perturbed(&(self.covariance().factor() * standard_normal(rng)))
    }

    /// Any number of draws; Σ is factorised once.
    pub fn samples<R: rand::Rng>(&self, mut rng: R) -> impl Iterator<Item = G> + use<G, D, E, R> {
        let (gaussian, factor) = (*self, self.covariance().factor());
        core::iter::repeat_with(move || gaussian.perturbed(&(factor * standard_normal(&mut rng))))
    }
}

/// Independent standard normal numbers. Box & Muller (1958), without rejection: a seed gives the same sequence everywhere
/// that logarithm and cosine round alike.
#[cfg(feature = "rand")]
fn standard_normal<S: Real, const D: usize>(rng: &mut impl rand::Rng) -> Tangent<S, D> {
    // 53 bits, in (0, 1).
    let mut uniform = || ((rng.next_u64() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64;
    Tangent::from_fn(|_, _| {
        let radius = (-2.0 * uniform().simd_ln()).simd_sqrt();
        S::lit(radius * (core::f64::consts::TAU * uniform()).simd_cos())
    })
}
