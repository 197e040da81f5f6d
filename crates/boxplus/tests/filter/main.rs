//! Filters: closed forms against differences and dual numbers, textbook special cases, what theory says of sides, published
//! numbers by Monte Carlo, and bad input.
#![allow(missing_docs, clippy::unwrap_used)]

#[cfg(feature = "rand")]
mod benchmarks;
#[cfg(feature = "autodiff")]
mod duals;
mod linear;
mod models;
#[cfg(feature = "rand")]
mod published;
mod refused;
mod sides;
#[cfg(feature = "rand")]
mod simulations;
mod single;
#[cfg(feature = "std")]
mod smooth;
