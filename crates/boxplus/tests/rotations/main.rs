//! Coordinates of rotations, directions, and what moves or draws them.
#![allow(missing_docs, clippy::unwrap_used)]

mod euler;
mod follow;
mod parametrisations;
#[cfg(feature = "rand")]
mod sampling;
mod sphere;
mod table;

const EPS: f64 = f64::EPSILON;
