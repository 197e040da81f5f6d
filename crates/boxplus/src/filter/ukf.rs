//! The unscented filter on a manifold.

use super::ekf::{checked, injected};
use super::model::{all_finite, finite, is_finite};
use super::step::{Filter, Gate, Innovation, Outcome, Predicted, Update};
use super::{FilterError, Measurement, Motion};
use crate::lie::{Jacobian, LieGroup, Real, Tangent};
use crate::uncertainty::linear::right_divided;
use crate::uncertainty::{Covariance, Gaussian, Side};
use nalgebra::{SMatrix, SVector, SimdComplexField};

/// The unscented Kalman filter on a manifold, Brossard, Barrau & Bonnabel (2020): no derivative is asked for.
///
/// The mean moves without noise; sigma points of P, then those of Q apart, say how errors move. For 2D points of weight
/// w = 1/(2α²D) at ±α√D standard deviations, their images d about that of the centre, and β = 2 (a Gaussian):
///
/// ```text
/// mean    d̄ = w Σ d
/// moment  w Σ d dᵀ + (2 − α²) d̄ d̄ᵀ
/// ```
///
/// This is their scatter about d̄ with the usual centre weights, multiplied out: a centre weight of −1/α² ≈ −10⁶ would
/// cancel all but ten digits and could leave a negative variance; this sum of squares cannot. Posterior covariances are
/// sums of squares as well, of the corrected sigma points.
///
/// On the `Local` side it is their *left* filter, on the `Global` side their *right* one. Innovations of sigma points must not
/// jump by a turn among each other: an angle is to be wrapped near the value measured.
///
/// ```
/// use boxplus::filter::{Ekf, Filter, PositionFix, Ukf};
/// use boxplus::lie::{LieGroup, SE2};
/// use boxplus::uncertainty::{Covariance, Gaussian};
/// use nalgebra::vector;
/// let belief = Gaussian::<SE2, 3>::from_sigmas(SE2::new(vector![1.0, 2.0], 0.3), &vector![0.5, 0.5, 0.1])?;
/// let fix = PositionFix::of_origin(vector![1.4, 1.8], Covariance::from_sigmas(&vector![0.2, 0.2])?);
/// let [ukf, ekf] = [Ukf::default().update(&belief, &fix).belief, Ekf::default().update(&belief, &fix).belief];
/// assert!(ukf.error_of(ekf.mean()).norm() < 0.02);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ukf {
    /// How far out the sigma points are, in √D standard deviations: 0 < α ≤ 1. Rounding is ε/α².
    pub alpha: f64,
    /// Whether the covariance is told about the new mean after a correction. The published filter does not.
    pub reset: bool,
    /// Which innovations are believed.
    pub gate: Gate,
}

impl Default for Ukf {
    /// α = 0.1, with reset, an open gate.
    fn default() -> Self {
        Self { alpha: 0.1, reset: true, gate: Gate::open() }
    }
}

/// What sigma points became: the images of the plus and the minus points about that of the centre, as columns.
struct Images<S, const R: usize, const D: usize> {
    plus: SMatrix<S, R, D>,
    minus: SMatrix<S, R, D>,
}

impl<S: Real, const R: usize, const D: usize> Images<S, R, D> {
    /// Of the points ±column k of `spread`.
    fn of(spread: &Jacobian<S, D>, image: impl Fn(&Tangent<S, D>) -> SVector<S, R>) -> Self {
        let (mut plus, mut minus) = (SMatrix::<S, R, D>::zeros(), SMatrix::<S, R, D>::zeros());
        for k in 0..D {
            let point = spread.column(k).into_owned();
            plus.set_column(k, &image(&point));
            minus.set_column(k, &image(&-point));
        }
        Self { plus, minus }
    }

    fn is_finite(&self) -> bool {
        all_finite(&self.plus) && all_finite(&self.minus)
    }
}

impl Ukf {
    /// The same filter with a gate.
    pub fn gated(self, gate: Gate) -> Self {
        Self { gate, ..self }
    }

    /// α, kept in reach.
    fn spread(&self) -> f64 {
        self.alpha.clamp(1e-6, 1.0)
    }

    /// ±√(α²D)·L, as columns.
    fn points<S: Real, const D: usize>(&self, covariance: &Covariance<D, S>) -> Jacobian<S, D> {
        covariance.factor() * S::lit(self.spread() * (D as f64).simd_sqrt())
    }

    /// w of one sigma point.
    fn weight<const D: usize>(&self) -> f64 {
        0.5 / (self.spread() * self.spread() * D as f64)
    }

    /// `(d̄, moment)`.
    fn moments<S: Real, const R: usize, const D: usize>(
        &self,
        images: &Images<S, R, D>,
    ) -> (SVector<S, R>, Covariance<R, S>) {
        let (mean, odd, even) = self.parts(images);
        (mean, odd + even)
    }

    /// `(d̄, moment of the odd parts ½(d₊ − d₋), moment of the rest)`. The first is that of a linear function.
    fn parts<S: Real, const R: usize, const D: usize>(
        &self,
        images: &Images<S, R, D>,
    ) -> (SVector<S, R>, Covariance<R, S>, Covariance<R, S>) {
        let weight = self.weight::<D>();
        let (sum, difference) = (images.plus + images.minus, images.plus - images.minus);
        let mean = sum.column_sum() * S::lit(weight);
        // w(d₊d₊ᵀ + d₋d₋ᵀ) = ½w(sum·sumᵀ + difference·differenceᵀ)
        let root = S::lit((0.5 * weight).simd_sqrt());
        let unit = Covariance::<D, S>::unit();
        let bend = S::lit((2.0 - self.spread() * self.spread()).simd_sqrt());
        let even = unit.transformed(&(sum * root)) + Covariance::<1, S>::unit().transformed(&(mean * bend));
        (mean, unit.transformed(&(difference * root)), even)
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
        let (noise, spread) = (measurement.noise(), self.points(prior.covariance()));
        let centre = measurement.innovation(prior.mean());
        let seen = Images::of(&spread, |xi| measurement.innovation(&prior.perturbed(xi)) - centre);
        if !all_finite(&centre) || !seen.is_finite() {
            return Err(FilterError::MeasurementNotFinite);
        }
        let (shift, moment) = self.moments(&seen);
        let (innovation, information) = Innovation::new(centre + shift, moment + noise)?;
        if !self.gate.admits(innovation.nis.value(), M) {
            return Ok(Update { belief: *prior, outcome: Outcome::Gated(innovation) });
        }
        // E[ξ·zᵀ]; an innovation falls where the prediction rises.
        let cross = spread * (seen.plus - seen.minus).transpose() * G::Scalar::lit(self.weight::<D>());
        let gain = -(cross * information);
        let corrected = Images { plus: spread + gain * seen.plus, minus: gain * seen.minus - spread };
        let (_, covariance) = self.moments(&corrected);
        let posterior = Gaussian::new(*prior.mean(), covariance + noise.transformed(&gain));
        let belief = injected(&posterior, &(gain * innovation.value), self.reset)?;
        Ok(Update { belief, outcome: Outcome::Accepted(innovation) })
    }
}

impl Filter for Ukf {
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
        let still = SVector::zeros();
        let next = motion.step(belief.mean(), input, &still);
        let spread = self.points(belief.covariance());
        let moved =
            Images::of(&spread, |xi| E::error(&motion.step(&belief.perturbed(xi), input, &still), &next));
        let pushes = self.points(&finite(motion.noise(input))?);
        let disturbed = Images::of(&pushes, |w| E::error(&motion.step(belief.mean(), input, w), &next));
        if !is_finite(&next) || !moved.is_finite() || !disturbed.is_finite() {
            return Err(FilterError::MotionNotFinite);
        }
        let (_, linear, rest) = self.parts(&moved);
        let disturbance = rest + self.moments(&disturbed).1;
        // Half the difference of the images of ±(column of the spread) is F times that column.
        let transition = right_divided(&((moved.plus - moved.minus) * G::Scalar::lit(0.5)), &spread);
        let belief = checked(Gaussian::new(next, linear + disturbance))?;
        Ok(Predicted { belief, transition, disturbance })
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
