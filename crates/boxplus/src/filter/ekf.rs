//! The Kalman filter of errors.

use super::model::{all_finite, observed, stepped};
use super::step::{Filter, Gate, Innovation, Outcome, Predicted, Update};
use super::{FilterError, Measurement, Motion};
use crate::lie::{LieGroup, Real, Tangent};
use crate::uncertainty::{Covariance, Gaussian, Side};
use nalgebra::{SMatrix, SimdComplexField};

/// The error-state Kalman filter, on the side of the belief, plain or iterated. Solà et al. (2018) §V-A.
///
/// ```text
/// predict  x ← f(x, u)     P ← FPFᵀ + GQGᵀ
/// update   S = HPHᵀ + N    K = PHᵀS⁻¹    δ = Kz    P ← (I − KH)P(I − KH)ᵀ + KNKᵀ         (Joseph)
/// inject   x ← x ⊞ δ
/// reset    P ← JPJᵀ, J = J_r(δ) local, J_l(δ) global                             Mueller, Hehn & D'Andrea (2017)
/// ```
///
/// On the `Global` side this is the right-invariant, on the `Local` side the left-invariant filter of Barrau & Bonnabel (2017):
/// turning the innovation into the frame of the body or of the world, as their papers do, turns H and N along, and K·z is
/// the same.
///
/// ```
/// use boxplus::filter::{Ekf, Filter, Odometry, Sighting};
/// use boxplus::lie::{LieGroup, SE2};
/// use boxplus::uncertainty::{Covariance, Gaussian};
/// use nalgebra::vector;
/// let ekf = Ekf::default();
/// let odometry = Odometry { noise: Covariance::from_sigmas(&vector![0.05, 0.02, 0.02])? };
/// let start = Gaussian::<SE2, 3>::certain(SE2::identity());
/// let moved = ekf.predict(&start, &odometry, &vector![1.0, 0.0, 0.2])?;
/// let beacon = Sighting {
///     landmark: vector![4.0, 1.0],
///     measured: vector![3.2, 0.3], // in the frame of the robot
///     noise: Covariance::from_sigmas(&vector![0.03, 0.03])?,
/// };
/// let update = ekf.update(&moved, &beacon);
/// assert!(update.is_accepted() && update.belief.sigmas()[0] < moved.sigmas()[0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ekf {
    /// Whether the covariance is told about the new mean after a correction. Off only to see what its absence does: at
    /// start-up, where corrections are large, overconfidence.
    pub reset: bool,
    /// Most linearisations in an update. 1 is the extended filter; more, the iterated one: Gauss–Newton on
    /// |x ⊟ x̂|²_P + |z(x)|²_N.
    pub iterations: usize,
    /// Iterations end when a step is shorter than this, in standard deviations of the prior.
    pub tolerance: f64,
    /// Which innovations are believed, judged at the prior.
    pub gate: Gate,
}

impl Default for Ekf {
    /// With reset, one linearisation, an open gate.
    fn default() -> Self {
        Self { reset: true, iterations: 1, tolerance: 1e-6, gate: Gate::open() }
    }
}

impl Ekf {
    /// The iterated filter: up to ten linearisations.
    pub fn iterated() -> Self {
        Self { iterations: 10, ..Self::default() }
    }

    /// The same filter with a gate.
    pub fn gated(self, gate: Gate) -> Self {
        Self { gate, ..self }
    }

    /// The update, unless it is refused.
    fn corrected<G, E, Z, const D: usize, const M: usize>(
        &self,
        prior: &Gaussian<G, D, E>,
        measurement: &Z,
    ) -> Result<Update<G, D, M, E>, FilterError>
    where
        G: LieGroup<D>,
        E: Side,
        Z: Measurement<G, D, M>,
    {
        let noise = measurement.noise();
        let mut about = *prior; // the prior, told about the iterate
        let mut e = Tangent::<G::Scalar, D>::zeros(); // the iterate, seen from the prior
        let mut innovation: Option<Innovation<M, G::Scalar>> = None;
        let mut iteration = 0;
        loop {
            iteration += 1;
            let (z, h) = observed::<G, E, Z, D, M>(measurement, about.mean())?;
            let (seen, information) = Innovation::new(z, about.covariance().transformed(&h) + noise)?;
            let judged = *innovation.get_or_insert(seen);
            if iteration == 1 && !self.gate.admits(judged.nis.value(), M) {
                return Ok(Update { belief: *prior, outcome: Outcome::Gated(judged) });
            }
            let gain = about.covariance().matrix() * h.transpose() * information;
            // J_r(e)·e = e on either side: the prior's mean stands at −e of the iterate.
            let delta = gain * (z + h * e) - e;
            let covariance = joseph(about.covariance(), &gain, &h, &noise);
            if iteration >= self.iterations.max(1) || self.is_short(&delta, prior.covariance()) {
                let posterior = Gaussian::new(*about.mean(), covariance);
                let belief = injected(&posterior, &delta, self.reset)?;
                let outcome = Outcome::Accepted(Innovation { iterations: iteration, ..judged });
                return Ok(Update { belief, outcome });
            }
            let next = about.perturbed(&delta);
            e = prior.error_of(&next);
            about = Gaussian::new(next, *prior.reset(&e).covariance());
        }
    }

    /// Whether every coordinate of a step is small beside its standard deviation.
    fn is_short<S: Real, const D: usize>(&self, delta: &Tangent<S, D>, prior: &Covariance<D, S>) -> bool {
        let limit = |i: usize| self.tolerance * prior.matrix()[(i, i)].value().max(0.0).simd_sqrt();
        (0..D).all(|i| delta[i].value().abs() <= limit(i))
    }
}

/// x ⊞ δ, and the covariance told about it, or left alone.
pub(super) fn injected<G: LieGroup<D>, E: Side, const D: usize>(
    belief: &Gaussian<G, D, E>,
    delta: &Tangent<G::Scalar, D>,
    reset: bool,
) -> Result<Gaussian<G, D, E>, FilterError> {
    let moved = if reset {
        belief.reset(delta)
    } else {
        Gaussian::new(belief.perturbed(delta), *belief.covariance())
    };
    if !all_finite(delta) {
        return Err(FilterError::MeasurementNotFinite);
    }
    checked(moved)
}

/// The belief, if its covariance is finite.
pub(super) fn checked<G: LieGroup<D>, E: Side, const D: usize>(
    belief: Gaussian<G, D, E>,
) -> Result<Gaussian<G, D, E>, FilterError> {
    if all_finite(belief.covariance().matrix()) { Ok(belief) } else { Err(FilterError::CovarianceNotFinite) }
}

/// (I − KH)P(I − KH)ᵀ + KNKᵀ: a sum of squares whatever K was rounded to.
fn joseph<S: Real, const D: usize, const M: usize>(
    prior: &Covariance<D, S>,
    gain: &SMatrix<S, D, M>,
    h: &SMatrix<S, M, D>,
    noise: &Covariance<M, S>,
) -> Covariance<D, S> {
    prior.transformed(&(SMatrix::identity() - gain * h)) + noise.transformed(gain)
}

impl Filter for Ekf {
    fn predict_joint<G, E, F, const D: usize, const W: usize>(
        &self,
        belief: &Gaussian<G, D, E>,
        motion: &F,
        input: &F::Input,
    ) -> Result<Predicted<G, D, E>, FilterError>
    where
        G: LieGroup<D>,
        E: Side,
        F: Motion<G, D, W>,
    {
        let (next, f, g) = stepped::<G, E, F, D, W>(motion, belief.mean(), input)?;
        let disturbance = motion.noise(input).transformed(&g);
        let moved = Gaussian::new(next, belief.covariance().transformed(&f) + disturbance);
        Ok(Predicted { belief: checked(moved)?, transition: f, disturbance })
    }

    fn update<G, E, Z, const D: usize, const M: usize>(
        &self,
        belief: &Gaussian<G, D, E>,
        measurement: &Z,
    ) -> Update<G, D, M, E>
    where
        G: LieGroup<D>,
        E: Side,
        Z: Measurement<G, D, M>,
    {
        self.corrected(belief, measurement).unwrap_or_else(|error| Update::refused(belief, error))
    }
}
