//! The factor graph, seen from outside.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[cfg(feature = "rand")]
mod beacon_drives;
mod custom;
mod dense;
mod faults;
mod solve;
mod uncertainty;
mod world;
