//! Clouds of points laid upon each other, against transforms that are known.
#![allow(clippy::unwrap_used)] // a failing test may panic
#![allow(clippy::print_stdout)] // what was measured is worth reading

mod closed_form;
#[cfg(all(feature = "registration", feature = "io"))]
mod public;
#[cfg(feature = "io")]
#[path = "../public_data/mod.rs"]
mod public_data;
#[cfg(feature = "registration")]
mod scans;
mod support;
