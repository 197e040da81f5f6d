//! What every filter does and answers: predict, update, gate.

use super::FilterError;
use super::model::{Measurement, Motion, all_finite};
use crate::lie::{Jacobian, LieGroup, Real};
use crate::uncertainty::{ChiSquared, Covariance, Gaussian, Local, Side};
use nalgebra::{SMatrix, SVector};

/// A rule that carries a belief through motions and measurements: [`Ekf`](super::Ekf), [`Ukf`](super::Ukf).
///
/// A filter holds options and no state; the belief is a [`Gaussian`], which goes in and comes out. Errors of the belief are
/// on its side E: `Local` is the left-invariant error X̂⁻¹X, `Global` the right-invariant error XX̂⁻¹ of Barrau & Bonnabel
/// (2017).
pub trait Filter {
    /// The belief after one step of the motion, and how errors moved.
    ///
    /// # Errors
    /// [`FilterError::MotionNotFinite`], [`FilterError::CovarianceNotFinite`].
    fn predict_joint<G, E, F, const D: usize, const W: usize>(
        &self,
        belief: &Gaussian<G, D, E>,
        motion: &F,
        input: &F::Input,
    ) -> Result<Predicted<G, D, E>, FilterError>
    where
        G: LieGroup<D>,
        E: Side,
        F: Motion<G, D, W>;

    /// The belief after one step of the motion.
    ///
    /// # Errors
    /// [`FilterError::MotionNotFinite`], [`FilterError::CovarianceNotFinite`].
    fn predict<G, E, F, const D: usize, const W: usize>(
        &self,
        belief: &Gaussian<G, D, E>,
        motion: &F,
        input: &F::Input,
    ) -> Result<Gaussian<G, D, E>, FilterError>
    where
        G: LieGroup<D>,
        E: Side,
        F: Motion<G, D, W>,
    {
        Ok(self.predict_joint(belief, motion, input)?.belief)
    }

    /// The belief after a measurement, or as it was, and why. Nothing here fails: a bad measurement is refused.
    fn update<G, E, Z, const D: usize, const M: usize>(
        &self,
        belief: &Gaussian<G, D, E>,
        measurement: &Z,
    ) -> Update<G, D, M, E>
    where
        G: LieGroup<D>,
        E: Side,
        Z: Measurement<G, D, M>;
}

/// A prediction, with what a smoother needs of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Predicted<G: LieGroup<D>, const D: usize, E: Side = Local> {
    /// The belief after the step.
    pub belief: Gaussian<G, D, E>,
    /// F, D×D, on the side E: from the error before to the error after; of the [`Ukf`](super::Ukf), its statistical linearisation.
    pub transition: Jacobian<G::Scalar, D>,
    /// P⁺ − FPFᵀ, D×D: GQGᵀ, and what is not linear.
    pub disturbance: Covariance<D, G::Scalar>,
}

/// What became of a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Update<G: LieGroup<D>, const D: usize, const M: usize, E: Side = Local> {
    /// The belief: corrected if the measurement was accepted, else untouched, to the last bit.
    pub belief: Gaussian<G, D, E>,
    /// Which of the two, and why.
    pub outcome: Outcome<M, G::Scalar>,
}

impl<G: LieGroup<D>, const D: usize, const M: usize, E: Side> Update<G, D, M, E> {
    pub(super) fn refused(belief: &Gaussian<G, D, E>, error: FilterError) -> Self {
        Self { belief: *belief, outcome: Outcome::Refused(error) }
    }

    /// Whether the measurement corrected the belief.
    pub fn is_accepted(&self) -> bool {
        matches!(self.outcome, Outcome::Accepted(_))
    }

    /// The innovation, of a measurement that was accepted or gated.
    pub fn innovation(&self) -> Option<&Innovation<M, G::Scalar>> {
        match &self.outcome {
            Outcome::Accepted(innovation) | Outcome::Gated(innovation) => Some(innovation),
            Outcome::Refused(_) => None,
        }
    }
}

/// The fate of a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome<const M: usize, S = f64> {
    /// It corrected the belief.
    Accepted(Innovation<M, S>),
    /// It was too unlikely to be believed: its NIS lies beyond the gate.
    Gated(Innovation<M, S>),
    /// It could not be used: it is not finite, or singular.
    Refused(FilterError),
}

/// What a measurement said that the belief did not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Innovation<const M: usize, S = f64> {
    /// z: measured minus predicted.
    pub value: SVector<S, M>,
    /// S = HPHᵀ + N, M×M.
    pub covariance: Covariance<M, S>,
    /// NIS = zᵀS⁻¹z: of a consistent filter, χ² with M degrees of freedom.
    pub nis: S,
    /// Linearisations made: 1, but for an iterated filter.
    pub iterations: usize,
}

impl<const M: usize, S: Real> Innovation<M, S> {
    /// `(z with its S and NIS, S⁻¹)`.
    pub(super) fn new(
        value: SVector<S, M>,
        covariance: Covariance<M, S>,
    ) -> Result<(Self, SMatrix<S, M, M>), FilterError> {
        if !all_finite(covariance.matrix()) {
            return Err(FilterError::CovarianceNotFinite);
        }
        let information = covariance.information().map_err(|error| FilterError::of_inversion(&error))?;
        let nis = value.dot(&(information * value));
        Ok((Self { value, covariance, nis, iterations: 1 }, information))
    }
}

/// Which innovations are believed.
///
/// ```
/// use boxplus::filter::Gate;
/// assert!(Gate::open().admits(1e9, 2));
/// assert!(!Gate::at(0.99).admits(9.3, 2) && Gate::at(0.99).admits(9.2, 2)); // χ² of 2: 99 % lie below 9.21
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gate {
    /// The share of good measurements that is kept.
    probability: f64,
}

impl Gate {
    /// Everything that can be computed is believed.
    pub const fn open() -> Self {
        Self { probability: 1.0 }
    }

    /// Innovations are believed up to the `probability`-quantile of χ²: of good measurements, that share. 1 is an open gate.
    pub const fn at(probability: f64) -> Self {
        Self { probability }
    }

    /// Whether an innovation of this NIS and dimension passes.
    pub fn admits(&self, nis: f64, dimension: usize) -> bool {
        self.probability >= 1.0 || ChiSquared::new(dimension).cdf(nis) <= self.probability
    }
}

impl Default for Gate {
    fn default() -> Self {
        Self::open()
    }
}
