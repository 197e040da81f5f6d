//! Why a filter did not take a step.

use crate::uncertainty::{Direction, UncertaintyError};

/// Why a step was refused. The belief is as it was.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FilterError {
    /// The motion's next state or a Jacobian is NaN or infinite.
    #[error("the predicted state or its Jacobian is NaN or infinite; check the input of the motion")]
    MotionNotFinite,
    /// The innovation or its Jacobian is NaN or infinite.
    #[error("the innovation or its Jacobian is NaN or infinite; check the measured value")]
    MeasurementNotFinite,
    /// A covariance has become infinite, or NaN.
    #[error("the covariance is NaN or infinite; check the noise of the model")]
    CovarianceNotFinite,
    /// The innovation covariance is singular: the sensor claims to be exact where the state is certain, too.
    #[error(
        "the innovation has no variance along {direction} (coordinates of the measurement); give the sensor noise there"
    )]
    Singular {
        /// The direction in the space of the measurement.
        direction: Direction,
    },
    /// An event lies further back than a history reaches.
    #[error("an event at {time} s is older than all that is remembered, since {oldest} s")]
    TooOld {
        /// Its time, in seconds.
        time: f64,
        /// The oldest time that can be told, in seconds.
        oldest: f64,
    },
    /// A time that is NaN or infinite.
    #[error("a time must be a finite number of seconds, not {time}")]
    NotATime {
        /// What was given.
        time: f64,
    },
}

impl FilterError {
    /// What a failed inversion of an innovation covariance means here.
    pub(super) fn of_inversion(error: &UncertaintyError) -> Self {
        match *error {
            UncertaintyError::Singular { direction } => Self::Singular { direction },
            _ => Self::CovarianceNotFinite,
        }
    }
}
