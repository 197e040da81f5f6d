//! The factor graph, seen from outside.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod beacon_drives;
mod continuous;
mod custom;
mod dense;
mod faults;
mod inertial;
mod landmarks;
mod solve;
mod together;
mod uncertainty;
mod world;
