//! A filter on its way through a recording.

use super::log::Stamped;
use super::timeline::{Event, timeline};
use crate::filter::{Filter, FilterError, Measurement, Motion, Outcome, Smoother};
use crate::lie::{LieGroup, Real};
use crate::uncertainty::{Covariance, Gaussian, Local, Side};
use nalgebra::SMatrix;
use std::{vec, vec::Vec};

/// Beliefs in order of time.
pub type Track<G, const D: usize, E = Local> = Vec<Stamped<Gaussian<G, D, E>>>;

/// A filter with its belief, which notes what it believed when, and what became of the measurements.
///
/// [`Course::forward`] remembers the belief of every stamp; [`Course::smoothing`] every prediction, too, so that the whole past can be
/// told again with what was learnt later.
///
/// ```
/// use boxplus::filter::{Ekf, Odometry, PositionFix};
/// use boxplus::lie::{LieGroup, SE2};
/// use boxplus::recording::Course;
/// use boxplus::uncertainty::{Covariance, Gaussian};
/// use nalgebra::vector;
/// let odometry = Odometry { noise: Covariance::from_sigmas(&vector![0.1, 0.1, 0.1])? };
/// let mut course = Course::smoothing(Ekf::default(), 0, Gaussian::<SE2, 3>::certain(SE2::identity()));
/// for second in 1..=10 {
///     course.predict(&odometry, &vector![1.0, 0.0, 0.0], second * 1_000_000_000)?;
/// }
/// course.update(&PositionFix::of_origin(vector![10.0, 0.5], Covariance::from_sigmas(&vector![0.01, 0.01])?));
/// assert_eq!(course.fates().accepted, 1);
/// let (then, told_again) = (course.track()[5].value.sigmas()[1], course.smoothed()[5].value.sigmas()[1]);
/// assert!(told_again < then);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Course<F, G: LieGroup<D>, const D: usize, E: Side = Local> {
    memory: Memory<F, G, D, E>,
    /// The stamps of `track`.
    track: Track<G, D, E>,
    fates: Fates,
}

#[derive(Clone, Debug)]
enum Memory<F, G: LieGroup<D>, const D: usize, E: Side> {
    Forward(F),
    Smoothing(Smoother<F, G, D, E>),
}

/// What became of the measurements.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fates {
    /// Measurements that corrected the belief.
    pub accepted: usize,
    /// Too unlikely to be believed.
    pub gated: usize,
    /// Not finite, or singular.
    pub refused: usize,
    /// Σ NIS of the accepted and the gated.
    nis: f64,
    /// Σ of their dimensions.
    dimensions: usize,
}

impl Fates {
    /// The average NIS of a dimension: 1 where the covariance of innovations is as claimed, NaN without any.
    pub fn mean_nis(&self) -> f64 {
        self.nis / self.dimensions as f64
    }
}

impl<F: Filter, G: LieGroup<D>, const D: usize, E: Side> Course<F, G, D, E> {
    /// From the belief at a stamp.
    pub fn forward(filter: F, stamp_ns: i64, start: Gaussian<G, D, E>) -> Self {
        let track = vec![Stamped { stamp_ns, value: start }];
        Self { memory: Memory::Forward(filter), track, fates: Fates::default() }
    }

    /// The same, remembering what a smoother needs: four D×D matrices for every prediction.
    pub fn smoothing(filter: F, stamp_ns: i64, start: Gaussian<G, D, E>) -> Self {
        let track = vec![Stamped { stamp_ns, value: start }];
        Self { memory: Memory::Smoothing(Smoother::new(filter, start)), track, fates: Fates::default() }
    }

    /// The belief now.
    pub fn belief(&self) -> &Gaussian<G, D, E> {
        // There always is one: the constructors put it there.
        &self.track[self.track.len() - 1].value
    }

    /// Now, in nanoseconds.
    pub fn stamp_ns(&self) -> i64 {
        self.track[self.track.len() - 1].stamp_ns
    }

    /// One step of the motion, which ends at a stamp.
    ///
    /// # Errors
    /// Those of [`Filter::predict`]; nothing is remembered of such a step.
    pub fn predict<M: Motion<G, D, W>, const W: usize>(
        &mut self,
        motion: &M,
        input: &M::Input,
        end_ns: i64,
    ) -> Result<(), FilterError> {
        let value = match &mut self.memory {
            Memory::Forward(filter) => {
                filter.predict(&self.track[self.track.len() - 1].value, motion, input)?
            }
            Memory::Smoothing(smoother) => {
                smoother.predict(motion, input)?;
                *smoother.belief()
            }
        };
        self.track.push(Stamped { stamp_ns: end_ns, value });
        Ok(())
    }

    /// A measurement of the state now; whether it was believed.
    pub fn update<Z: Measurement<G, D, M>, const M: usize>(&mut self, measurement: &Z) -> bool {
        let update = match &mut self.memory {
            Memory::Forward(filter) => filter.update(&self.track[self.track.len() - 1].value, measurement),
            Memory::Smoothing(smoother) => smoother.update(measurement),
        };
        if let Some(now) = self.track.last_mut() {
            now.value = update.belief;
        }
        match update.outcome {
            Outcome::Accepted(_) => self.fates.accepted += 1,
            Outcome::Gated(_) => self.fates.gated += 1,
            Outcome::Refused(_) => self.fates.refused += 1,
        }
        if let Some(innovation) = update.innovation() {
            self.fates.nis += innovation.nis.value();
            self.fates.dimensions += M;
        }
        update.is_accepted()
    }

    /// Goes through inputs and what was seen in order of time: `step` makes a motion and its input of what holds for so many seconds,
    /// `correct` makes the updates of what was seen. See [`timeline`].
    ///
    /// ```
    /// use boxplus::filter::{Ekf, Odometry, PositionFix};
    /// use boxplus::lie::{LieGroup, SE2};
    /// use boxplus::recording::{Course, Stamped};
    /// use boxplus::uncertainty::{Covariance, Gaussian};
    /// use nalgebra::vector;
    /// let speeds = [0, 1, 2].map(|second| Stamped { stamp_ns: second * 1_000_000_000, value: 1.5 });
    /// let fix = PositionFix::of_origin(vector![2.1, 0.0], Covariance::from_sigmas(&vector![0.1, 0.1])?);
    /// let mut course = Course::forward(Ekf::default(), 0, Gaussian::<SE2, 3>::certain(SE2::identity()));
    /// course.follow(
    ///     &speeds,
    ///     &[Stamped { stamp_ns: 1_400_000_000, value: fix }],
    ///     |speed, seconds| (Odometry { noise: Covariance::unit() * (0.1 * seconds) }, vector![speed * seconds, 0.0, 0.0]),
    ///     |course, fix| drop(course.update(fix)),
    /// )?;
    /// assert_eq!(course.track().len(), 4);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`Course::predict`], at the first step that fails.
    pub fn follow<I, Z, M: Motion<G, D, W>, const W: usize>(
        &mut self,
        inputs: &[Stamped<I>],
        seen: &[Stamped<Z>],
        step: impl Fn(&I, f64) -> (M, M::Input),
        mut correct: impl FnMut(&mut Self, &Z),
    ) -> Result<(), FilterError> {
        for event in timeline(inputs, seen) {
            match event {
                Event::Step { input, duration, end_ns } => {
                    let (motion, input) = step(input, duration);
                    self.predict(&motion, &input, end_ns)?;
                }
                Event::Seen { value, .. } => correct(self, value),
            }
        }
        Ok(())
    }

    /// What became of the measurements so far.
    pub fn fates(&self) -> Fates {
        self.fates
    }

    /// The belief of every stamp, with the measurements up to it.
    pub fn track(&self) -> &[Stamped<Gaussian<G, D, E>>] {
        &self.track
    }

    /// The belief of every stamp with all measurements; of a course that goes [forward](Course::forward) only, the same as
    /// [`Course::track`].
    pub fn smoothed(&self) -> Track<G, D, E> {
        match &self.memory {
            Memory::Forward(_) => self.track.clone(),
            Memory::Smoothing(smoother) => {
                let stamps = self.track.iter().map(|belief| belief.stamp_ns);
                stamps.zip(smoother.smoothed()).map(|(stamp_ns, value)| Stamped { stamp_ns, value }).collect()
            }
        }
    }
}

/// The beliefs of a part of the state whose local tangent are M coordinates from `first` on: of a navigation state its pose, of
/// an attitude with biases its rotation.
///
/// ```
/// use boxplus::filter::InertialState;
/// use boxplus::lie::{LieGroup, SE3};
/// use boxplus::recording::{Stamped, part_of};
/// use boxplus::uncertainty::Gaussian;
/// let belief = Gaussian::<InertialState, 15>::certain(InertialState::identity());
/// let poses = part_of(&[Stamped { stamp_ns: 0, value: belief }], |x| x.motion.pose(), 0);
/// assert_eq!(*poses[0].value.mean(), SE3::identity());
/// ```
///
/// # Panics
/// Where M coordinates from `first` on are not in the tangent.
pub fn part_of<G, H, E, const D: usize, const M: usize>(
    track: &[Stamped<Gaussian<G, D, E>>],
    of: impl Fn(&G) -> H,
    first: usize,
) -> Track<H, M>
where
    G: LieGroup<D, Scalar = f64>,
    H: LieGroup<M, Scalar = f64>,
    E: Side,
{
    let mut pick = SMatrix::<f64, M, D>::zeros();
    pick.view_mut((0, first), (M, M)).fill_with_identity();
    let marginal = |belief: &Gaussian<G, D, E>| {
        Gaussian::new(of(belief.mean()), local_covariance(belief).transformed(&pick))
    };
    track.iter().map(|belief| belief.map(marginal)).collect()
}

/// Σ of the local error. With the mean as the origin, a change that leaves local errors as they are, both sides are one.
pub(super) fn local_covariance<G, E, const D: usize>(belief: &Gaussian<G, D, E>) -> Covariance<D>
where
    G: LieGroup<D, Scalar = f64>,
    E: Side,
{
    belief.covariance().transformed(&E::under_left_factor(&belief.mean().inverse()))
}
