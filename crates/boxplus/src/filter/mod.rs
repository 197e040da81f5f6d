//! Filters: one belief, carried through motions and measurements.
//!
//! (docs follow)
#![allow(clippy::type_complexity)] // A value and one Jacobian per argument; naming each tuple would hide that.

mod ekf;
mod error;
mod model;
mod models;
mod step;
mod ukf;

pub use ekf::Ekf;
pub use error::FilterError;
pub use model::{Measurement, Motion, check_measurement, check_motion};
pub use models::*;
pub use step::{Filter, Gate, Innovation, Outcome, Predicted, Update};
pub use ukf::Ukf;
