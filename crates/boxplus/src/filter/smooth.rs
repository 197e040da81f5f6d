//! The past, seen with what came later.

use super::step::{Filter, Predicted, Update};
use super::{FilterError, Measurement, Motion};
use crate::lie::{Jacobian, LieGroup};
use crate::uncertainty::linear::{right_divided, right_divided_by_transpose};
use crate::uncertainty::{Covariance, Gaussian, Local, Side};
use std::{vec, vec::Vec};

/// A filter that remembers every step, so that all of them can be told again with what was learnt later: the smoother of
/// Rauch, Tung & Striebel (1965) on a group.
///
/// ```text
/// C = P_{k|k}·Fᵀ·P_{k+1|k}⁻¹    e = X_{k+1|N} ⊟ X_{k+1|k}    δ = C·e    X_{k|N} = X_{k|k} ⊞ δ
/// P_{k|N} = J(δ)·[P_{k|k} + C·(J⁻¹(e)·P_{k+1|N}·J⁻ᵀ(e) − P_{k+1|k})·Cᵀ]·J(δ)ᵀ
/// ```
///
/// e and its covariance are told about the predicted mean, the sum about the filtered one, and J takes it to the smoothed:
/// two resets that Euclidean texts do not need. The bracket is summed as (I − CF)P(I − CF)ᵀ + CQCᵀ + CJ⁻¹P_{k+1|N}J⁻ᵀCᵀ, which
/// cannot lose its definiteness, and directions that are certain may stay so.
///
/// Works with any [`Filter`]; memory grows by four matrices with every prediction.
///
/// ```
/// use boxplus::filter::{Ekf, Odometry, PositionFix, Smoother};
/// use boxplus::lie::{LieGroup, SE2};
/// use boxplus::uncertainty::{Covariance, Gaussian};
/// use nalgebra::vector;
/// let odometry = Odometry { noise: Covariance::from_sigmas(&vector![0.1, 0.1, 0.1])? };
/// let mut run = Smoother::new(Ekf::default(), Gaussian::<SE2, 3>::certain(SE2::identity()));
/// for _ in 0..10 {
///     run.predict(&odometry, &vector![1.0, 0.0, 0.0])?;
/// }
/// let half_way = run.beliefs().nth(5).map(|b| b.sigmas()[1]);
/// let fix = PositionFix::of_origin(vector![10.0, 0.5], Covariance::from_sigmas(&vector![0.01, 0.01])?);
/// assert!(run.update(&fix).is_accepted());
/// let smoothed = run.smoothed(); // the fix at the end tells where the middle was
/// assert!(smoothed.get(5).map(|b| b.sigmas()[1]) < half_way);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Smoother<F, G: LieGroup<D>, const D: usize, E: Side = Local> {
    filter: F,
    /// Beliefs with all measurements up to their own time.
    filtered: Vec<Gaussian<G, D, E>>,
    /// The predictions that led to the second belief, the third, …
    predicted: Vec<Predicted<G, D, E>>,
}

impl<F: Filter, G: LieGroup<D>, const D: usize, E: Side> Smoother<F, G, D, E> {
    /// From the belief at the start.
    pub fn new(filter: F, start: Gaussian<G, D, E>) -> Self {
        Self { filter, filtered: vec![start], predicted: Vec::new() }
    }

    /// The belief now.
    pub fn belief(&self) -> &Gaussian<G, D, E> {
        // There always is one: `new` puts it there.
        &self.filtered[self.filtered.len() - 1]
    }

    /// Every belief, from the start on, with the measurements up to its own time.
    pub fn beliefs(&self) -> impl Iterator<Item = &Gaussian<G, D, E>> {
        self.filtered.iter()
    }

    /// One step of the motion.
    ///
    /// # Errors
    /// Those of [`Filter::predict`]; nothing is remembered of such a step.
    pub fn predict<M: Motion<G, D, W>, const W: usize>(
        &mut self,
        motion: &M,
        input: &M::Input,
    ) -> Result<(), FilterError> {
        let predicted = self.filter.predict_joint(self.belief(), motion, input)?;
        self.predicted.push(predicted);
        self.filtered.push(predicted.belief);
        Ok(())
    }

    /// A measurement of the state now.
    pub fn update<Z: Measurement<G, D, M>, const M: usize>(&mut self, measurement: &Z) -> Update<G, D, M, E> {
        let update = self.filter.update(self.belief(), measurement);
        if let Some(last) = self.filtered.last_mut() {
            *last = update.belief;
        }
        update
    }

    /// Every belief, from the start on, with all measurements.
    pub fn smoothed(&self) -> Vec<Gaussian<G, D, E>> {
        let mut next = *self.belief();
        let mut backwards = vec![next];
        for (filtered, predicted) in self.filtered.iter().zip(&self.predicted).rev() {
            next = smoothed(filtered, predicted, &next);
            backwards.push(next);
        }
        backwards.reverse();
        backwards
    }
}

/// One step back.
fn smoothed<G: LieGroup<D>, const D: usize, E: Side>(
    filtered: &Gaussian<G, D, E>,
    predicted: &Predicted<G, D, E>,
    next: &Gaussian<G, D, E>,
) -> Gaussian<G, D, E> {
    let transition = &predicted.transition;
    let gain = gain(filtered.covariance(), predicted);
    let e = predicted.belief.error_of(next.mean());
    let later = next.covariance().transformed(&E::jacobian_inverse::<G, D>(&e)).transformed(&gain);
    // What knowing the next state exactly would leave.
    let open = filtered.covariance().transformed(&(Jacobian::identity() - gain * transition))
        + predicted.disturbance.transformed(&gain);
    Gaussian::new(*filtered.mean(), open + later).reset(&(gain * e))
}

/// C = PFᵀ·P⁺⁻, with any generalised inverse: the rows of the left lie in the range of P⁺.
fn gain<G: LieGroup<D>, const D: usize, E: Side>(
    before: &Covariance<D, G::Scalar>,
    predicted: &Predicted<G, D, E>,
) -> Jacobian<G::Scalar, D> {
    let l = predicted.belief.covariance().factor();
    // (C·L)·Lᵀ = PFᵀ.
    let cross = before.matrix() * predicted.transition.transpose();
    right_divided(&right_divided_by_transpose(&cross, &l), &l)
}
