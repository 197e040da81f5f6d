//! Measurements that come late.

use super::FilterError;
use crate::lie::LieGroup;
use crate::uncertainty::{Gaussian, Local, Side};
use std::boxed::Box;
use std::collections::VecDeque;
use std::fmt;

/// A step of a belief: a prediction or an update, with everything it needs inside.
type Step<G, const D: usize, E> = Box<dyn Fn(&Gaussian<G, D, E>) -> Gaussian<G, D, E> + Send>;

/// One thing that happened, and the belief after it.
struct Event<G: LieGroup<D>, const D: usize, E: Side> {
    time: f64,
    step: Step<G, D, E>,
    after: Gaussian<G, D, E>,
}

/// The recent past of a filter, told again when a measurement arrives late or out of order.
///
/// Events are steps of the belief, kept in the order of their times; one that belongs into the past is put in its place, and
/// everything after it is done again: the same numbers come out, to the last bit, in whatever order events arrive. Events of
/// one time keep the order of arrival.
///
/// A prediction carries the time of its *end*. A measurement from within an interval of prediction acts at the interval's
/// start: with an inertial sensor that is a few milliseconds; where it is more, split the prediction.
///
/// ```
/// use boxplus::filter::{Ekf, Filter, Odometry, PositionFix, Replay};
/// use boxplus::lie::{LieGroup, SE2};
/// use boxplus::uncertainty::{Covariance, Gaussian};
/// use nalgebra::vector;
/// let odometry = Odometry { noise: Covariance::from_sigmas(&vector![0.1, 0.1, 0.1])? };
/// let drive = move |b: &Gaussian<SE2, 3>| Ekf::default().predict(b, &odometry, &vector![1.0, 0.0, 0.0]).unwrap_or(*b);
/// let fix = PositionFix::of_origin(vector![1.0, 0.2], Covariance::from_sigmas(&vector![0.1, 0.1])?);
/// let correct = move |b: &Gaussian<SE2, 3>| Ekf::default().update(b, &fix).belief;
///
/// let start = Gaussian::certain(SE2::identity());
/// let (mut prompt, mut late) = (Replay::new(0.0, start, 10.0), Replay::new(0.0, start, 10.0));
/// prompt.push(1.0, drive)?;
/// prompt.push(1.0, correct)?;
/// prompt.push(2.0, drive)?;
/// late.push(1.0, drive)?;
/// late.push(2.0, drive)?;
/// late.push(1.0, correct)?; // it was on its way for a second
/// assert_eq!(late.belief(), prompt.belief());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Replay<G: LieGroup<D>, const D: usize, E: Side = Local> {
    /// The belief before all events, and since when it holds.
    base: (f64, Gaussian<G, D, E>),
    events: VecDeque<Event<G, D, E>>,
    span: f64,
}

impl<G: LieGroup<D>, const D: usize, E: Side> Replay<G, D, E> {
    /// From the belief at `time`; events up to `span` seconds before the newest one are remembered.
    pub fn new(time: f64, start: Gaussian<G, D, E>, span: f64) -> Self {
        Self { base: (time, start), events: VecDeque::new(), span }
    }

    /// The belief after all events.
    pub fn belief(&self) -> &Gaussian<G, D, E> {
        self.events.back().map_or(&self.base.1, |event| &event.after)
    }

    /// The belief at `time`: after the last event that is not later.
    ///
    /// # Errors
    /// [`FilterError::TooOld`], [`FilterError::NotATime`].
    pub fn belief_at(&self, time: f64) -> Result<&Gaussian<G, D, E>, FilterError> {
        let place = self.place(time)?;
        Ok(self.before(place))
    }

    /// Time of the newest event, in seconds; the start, where there is none.
    pub fn time(&self) -> f64 {
        self.events.back().map_or(self.base.0, |event| event.time)
    }

    /// An event at `time`, in seconds: done now, with everything after it.
    ///
    /// # Errors
    /// [`FilterError::TooOld`] where it lies before what is remembered, [`FilterError::NotATime`]; nothing changes then.
    pub fn push(
        &mut self,
        time: f64,
        step: impl Fn(&Gaussian<G, D, E>) -> Gaussian<G, D, E> + Send + 'static,
    ) -> Result<(), FilterError> {
        let place = self.place(time)?;
        let mut belief = step(self.before(place));
        self.events.insert(place, Event { time, step: Box::new(step), after: belief });
        for event in self.events.iter_mut().skip(place + 1) {
            belief = (event.step)(&belief);
            event.after = belief;
        }
        self.forget();
        Ok(())
    }

    /// How many events are not later than `time`.
    fn place(&self, time: f64) -> Result<usize, FilterError> {
        if !time.is_finite() {
            return Err(FilterError::NotATime { time });
        }
        if time < self.base.0 {
            return Err(FilterError::TooOld { time, oldest: self.base.0 });
        }
        Ok(self.events.partition_point(|event| event.time <= time))
    }

    /// The belief before the event at `place`.
    fn before(&self, place: usize) -> &Gaussian<G, D, E> {
        place.checked_sub(1).and_then(|k| self.events.get(k)).map_or(&self.base.1, |event| &event.after)
    }

    fn forget(&mut self) {
        let horizon = self.time() - self.span;
        while self.events.front().is_some_and(|event| event.time < horizon) {
            if let Some(event) = self.events.pop_front() {
                self.base = (event.time, event.after);
            }
        }
    }
}

impl<G: LieGroup<D>, const D: usize, E: Side> fmt::Debug for Replay<G, D, E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let times = (self.base.0, self.time());
        f.debug_struct("Replay")
            .field("times", &times)
            .field("events", &self.events.len())
            .finish_non_exhaustive()
    }
}
