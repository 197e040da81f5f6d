//! From samples to a Gaussian and back.

use super::{Covariance, Gaussian, Side, UncertaintyError};
#[cfg(feature = "rand")]
use crate::lie::sample::standard_normal;
use crate::lie::{LieError, LieGroup, Means, Real, Weights};
use nalgebra::SMatrix;

/// Mean and covariance of samples, and how they were found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampled<G: LieGroup<D>, const D: usize, E: Side> {
    /// Mean Σ Log(X̄⁻¹Xᵢ) = 0 and covariance Σ ξξᵀ/(n − 1). Of n ≤ D samples it has no more than rank n − 1.
    pub gaussian: Gaussian<G, D, E>,
    /// How many samples.
    pub count: usize,
    /// Steps to the mean.
    pub iterations: usize,
    /// ‖Σ ξ‖/n, which is 0 up to rounding.
    pub residual: f64,
    /// Share of the samples at half of the way to the cut locus or beyond, as of [`crate::lie::Mean`]; 0: no other mean.
    pub beyond: f64,
}

impl<G: LieGroup<D>, const D: usize, E: Side> Gaussian<G, D, E> {
    /// The mean of samples and the covariance about it. The mean is the bi-invariant one, [`Means::barycentre`]: it needs no
    /// metric and is the same on both sides.
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
        if count < 2 {
            return Err(UncertaintyError::TooFew { given: count, needed: 2 });
        }
        let found = G::barycentre(samples, Weights::Equal).map_err(no_mean)?;
        let mean = found.value;
        let scatter = samples.iter().fold(SMatrix::zeros(), |sum: SMatrix<G::Scalar, D, D>, x| {
            let xi = E::error(x, &mean);
            sum + xi * xi.transpose()
        });
        let covariance = Covariance::new(scatter * G::Scalar::lit(1.0 / (count - 1) as f64))?;
        Ok(Sampled {
            gaussian: Gaussian::new(mean, covariance),
            count,
            iterations: found.iterations,
            residual: found.residual,
            beyond: found.beyond,
        })
    }
}

/// What a mean of equal weights can lack.
fn no_mean(error: LieError) -> UncertaintyError {
    match error {
        LieError::NotConverged { iterations, step } => UncertaintyError::NotConverged { iterations, step },
        _ => UncertaintyError::NotFinite { row: 0, column: 0 },
    }
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
