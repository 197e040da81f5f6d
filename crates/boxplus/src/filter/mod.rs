//! Filters: one belief, carried through motions and measurements.
//!
//! (docs follow)
#![allow(clippy::type_complexity)] // A value and one Jacobian per argument; naming each tuple would hide that.

#[cfg(all(feature = "rand", feature = "std"))]
mod consistency;
#[cfg(feature = "autodiff")]
mod duals;
mod ekf;
mod error;
mod linear;
mod model;
mod models;
#[cfg(feature = "std")]
mod replay;
#[cfg(feature = "std")]
mod smooth;
mod step;
mod ukf;

#[cfg(all(feature = "rand", feature = "std"))]
pub use consistency::{ConsistencyError, MonteCarlo, Report, Run, Series, Verdict};
#[cfg(feature = "autodiff")]
pub use duals::{ByDuals, SmoothMeasurement, SmoothMotion};
pub use ekf::Ekf;
pub use error::FilterError;
pub use model::{Measurement, Motion, check_measurement, check_motion};
pub use models::*;
#[cfg(feature = "std")]
pub use replay::Replay;
#[cfg(feature = "std")]
pub use smooth::Smoother;
pub use step::{Filter, Gate, Innovation, Outcome, Predicted, Update};
pub use ukf::Ukf;
