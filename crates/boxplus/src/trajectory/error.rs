//! Why a curve, a step or a measurement over time is refused.

use crate::lie::{LieGroup, Real, Tangent};

/// What is wrong with the elements, times or samples a trajectory is asked to be made of.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrajectoryError {
    /// Two successive elements are half a turn apart: two ways lead from one to the other, equally short.
    #[error(
        "the way from element {segment} to the next turns by half a turn: both directions are equally short; \
         put an element between them"
    )]
    Ambiguous {
        /// Index of the first of the two.
        segment: usize,
    },
    /// A number is NaN or infinite.
    #[error("number {index} is NaN or infinite; check the source of the data")]
    NotFinite {
        /// Index of the element, time or component.
        index: usize,
    },
    /// A curve needs more elements than there are.
    #[error("{got} elements are too few: this curve needs {needed}")]
    TooFew {
        /// How many there are.
        got: usize,
        /// How many it needs at least.
        needed: usize,
    },
    /// The numbers of elements and of times differ.
    #[error("{elements} elements, but {times} times: each element needs its own")]
    CountsDiffer {
        /// How many elements there are.
        elements: usize,
        /// How many times there are.
        times: usize,
    },
    /// A duration is not a positive finite number.
    #[error(
        "a duration must be positive and finite, not {duration} s; are two stamps equal or out of order?"
    )]
    NotADuration {
        /// What was given, in the unit of time.
        duration: f64,
    },
    /// A time is not later than the one before it.
    #[error("time {index} is not later than the one before it; sort the elements and drop duplicates")]
    NotIncreasing {
        /// Index of the later time.
        index: usize,
    },
    /// A time at which the trajectory is not defined.
    #[error("no trajectory at {time}: it is defined from {start} to {end}")]
    OutOfRange {
        /// What was asked for.
        time: f64,
        /// Where the trajectory starts.
        start: f64,
        /// Where it ends.
        end: f64,
    },
    /// A density of noise is negative or not finite.
    #[error("{density} is no density of noise: it must be finite and not negative")]
    NotADensity {
        /// What was given.
        density: f64,
    },
    /// A tolerance is not a positive finite number.
    #[error("{tolerance} is no tolerance: it must be positive and finite")]
    NotATolerance {
        /// What was given.
        tolerance: f64,
    },
    /// The step of an adaptive integration shrank below what moves the time.
    #[error("no step is short enough at {time}: the velocity jumps or grows without bound there")]
    StepTooSmall {
        /// Where the integration stopped.
        time: f64,
    },
}

/// The duration itself, if it is one.
pub(super) fn check_duration<S: Real>(duration: S) -> Result<S, TrajectoryError> {
    let value = duration.value();
    if value > 0.0 && value.is_finite() {
        Ok(duration)
    } else {
        Err(TrajectoryError::NotADuration { duration: value })
    }
}

/// Refuses a tangent that is not finite.
pub(super) fn check_finite<S: Real, const D: usize>(
    v: &Tangent<S, D>,
    index: usize,
) -> Result<(), TrajectoryError> {
    if v.iter().all(|x| x.value().is_finite()) { Ok(()) } else { Err(TrajectoryError::NotFinite { index }) }
}

/// Refuses neighbours that are not finite or half a turn apart.
pub(super) fn check_ways<G: LieGroup<D>, const D: usize>(elements: &[G]) -> Result<(), TrajectoryError> {
    if let [only] = elements {
        check_finite(&only.log(), 0)?;
    }
    elements.windows(2).enumerate().try_for_each(|(segment, pair)| {
        let way = pair[1].rminus(&pair[0]);
        // The second where nothing is wrong with the first.
        check_finite(&way, segment + usize::from(check_finite(&pair[0].log(), segment).is_ok()))?;
        if is_the_shortest::<G, D>(&way) { Ok(()) } else { Err(TrajectoryError::Ambiguous { segment }) }
    })
}

/// Whether `way`, a logarithm, stays one when it is longer by √ε: at half a turn Log takes the other way round.
///
/// The group need not say what turns in it: across its cut a logarithm jumps by 2π in an angle, far above the rounding
/// √ε·|τ|.
fn is_the_shortest<G: LieGroup<D>, const D: usize>(way: &Tangent<G::Scalar, D>) -> bool {
    let longer = way.map(|x| x * G::Scalar::lit(1.0 + root_epsilon::<G::Scalar>()));
    let jump = G::exp(&longer).log() - longer;
    let largest = |v: &Tangent<G::Scalar, D>| v.iter().fold(0.0, |m: f64, x| m.max(x.value().abs()));
    largest(&jump) < 1.0 + root_epsilon::<G::Scalar>() * largest(way)
}

/// √ε of the scalar, to within a power of two.
fn root_epsilon<S: Real>() -> f64 {
    if S::EPSILON > 1e-10 { 1.0 / 2048.0 } else { 1.0 / 67_108_864.0 }
}
