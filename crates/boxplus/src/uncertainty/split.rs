//! Estimates of which a part of the error may be correlated, and a part is known not to be.

use super::fuse::{Known, converged, minimised, smallest};
use super::{Covariance, Criterion, FuseOptions, Gaussian, Local, Side, UncertaintyError};
use crate::lie::{LieGroup, Real};
use nalgebra::{SMatrix, SimdComplexField};

/// An estimate whose error has two independent parts: one *shared*, correlated with other estimates in an unknown way, and one of its
/// *own*, independent of all others.
///
/// A robot that has heard from others shares what it heard; what its own sensors saw since is its own. Covariance intersection
/// ([`Gaussian::intersect`]) treats everything as shared and forgets how good one's own sensors are; fusion
/// ([`Gaussian::fuse`]) treats everything as own and counts rumours twice. Julier & Uhlmann (2001), Li & Nashashibi (2013):
///
/// ```text
/// P_k = S_k/ω_k + O_k       ω₁ = ω, ω₂ = 1 − ω, both told about the result
/// Σ⁻¹ = P₁⁻¹ + P₂⁻¹         K_k = ΣP_k⁻¹
/// S = Σ_k K_kS_kK_kᵀ/ω_k    O = Σ_k K_kO_kK_kᵀ       S + O = Σ
/// ```
///
/// ```
/// use boxplus::lie::SE2;
/// use boxplus::uncertainty::{Covariance, Criterion, Split};
/// use nalgebra::vector;
/// let pose = SE2::new(vector![1.0, 2.0], 0.3);
/// let rumour = Covariance::from_sigmas(&vector![0.3, 0.3, 0.1])?;
/// let seen = Covariance::from_sigmas(&vector![0.1, 0.2, 0.05])?;
/// let mine = Split::<SE2, 3>::new(pose, rumour, seen);
/// let fused = mine.fuse(&mine, Criterion::Determinant)?;
/// // What is shared gets no better by being heard again; what is seen by two does.
/// assert!((fused.estimate.shared().matrix() - rumour.matrix()).amax() < 1e-12);
/// assert!((fused.estimate.own().matrix() - seen.matrix() * 0.5).amax() < 1e-12);
/// # Ok::<(), boxplus::uncertainty::UncertaintyError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Split<G: LieGroup<D>, const D: usize, E: Side = Local> {
    mean: G,
    shared: Covariance<D, G::Scalar>,
    own: Covariance<D, G::Scalar>,
    side: core::marker::PhantomData<E>,
}

/// What two split estimates make.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplitFused<G: LieGroup<D>, const D: usize, E: Side> {
    /// The estimate, its error split as the inputs' are.
    pub estimate: Split<G, D, E>,
    /// ω ∈ (0, 1), the weight of the first estimate's shared part; 1 − ω is that of the second's.
    pub weight: f64,
}

impl<G: LieGroup<D>, const D: usize, E: Side> Split<G, D, E> {
    /// From a mean and the covariances of the two parts of its error, D×D each, on the side `E`.
    pub fn new(mean: G, shared: Covariance<D, G::Scalar>, own: Covariance<D, G::Scalar>) -> Self {
        Self { mean, shared, own, side: core::marker::PhantomData }
    }

    /// X̄.
    pub fn mean(&self) -> &G {
        &self.mean
    }

    /// The covariance of the part of the error that may be correlated with others'.
    pub fn shared(&self) -> &Covariance<D, G::Scalar> {
        &self.shared
    }

    /// The covariance of the independent part of the error.
    pub fn own(&self) -> &Covariance<D, G::Scalar> {
        &self.own
    }

    /// The estimate with its whole covariance, shared and own.
    pub fn total(&self) -> Gaussian<G, D, E> {
        Gaussian::new(self.mean, self.shared + self.own)
    }

    /// P_k for a weight of the shared part.
    fn inflated(&self, weight: f64) -> Covariance<D, G::Scalar> {
        self.shared * G::Scalar::lit((1.0 / weight).simd_sqrt()) + self.own
    }

    /// The estimate from both: no smaller than the true error whatever the correlation of the shared parts (to first order).
    ///
    /// # Errors
    /// [`UncertaintyError::Singular`] where an estimate is certain along a direction; [`UncertaintyError::NotConverged`] where
    /// the two are half a turn apart.
    pub fn fuse(&self, other: &Self, criterion: Criterion) -> Result<SplitFused<G, D, E>, UncertaintyError> {
        let known = |weight: f64| -> Result<[Known<G, D>; 2], UncertaintyError> {
            let of = |x: &Self, weight: f64| {
                x.inflated(weight).information().map(|information| Known { mean: x.mean, information })
            };
            Ok([of(self, weight)?, of(other, 1.0 - weight)?])
        };
        let at = |weight: f64| {
            minimised::<G, D, E>(&self.mean, &known(weight)?.into_iter(), &FuseOptions::default())
        };
        let weight = smallest(|weight| criterion.size(&at(weight)?.estimate))?;
        let total = converged(at(weight)?)?;
        let parts = [(self, weight), (other, 1.0 - weight)];
        let (mut shared, mut own) = (Covariance::zero(), Covariance::zero());
        for ((x, weight), known) in parts.into_iter().zip(known(weight)?) {
            let gain = gain(&total, &known);
            shared = shared + (x.shared * G::Scalar::lit((1.0 / weight).simd_sqrt())).transformed(&gain);
            own = own + x.own.transformed(&gain);
        }
        Ok(SplitFused { estimate: Self::new(*total.mean(), shared, own), weight })
    }
}

/// ΣJᵀP⁻¹: from the error of an estimate about its mean to that of the result, J = J⁻¹(e).
fn gain<G: LieGroup<D>, const D: usize, E: Side>(
    total: &Gaussian<G, D, E>,
    known: &Known<G, D>,
) -> SMatrix<G::Scalar, D, D> {
    let e = E::error(total.mean(), &known.mean);
    total.covariance().matrix() * E::jacobian_inverse::<G, D>(&e).transpose() * known.information
}
