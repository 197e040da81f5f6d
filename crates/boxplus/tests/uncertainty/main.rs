//! Uncertain elements: every formula against Monte Carlo with its standard error, published numbers, and laws over all
//! groups.
#![allow(missing_docs, clippy::unwrap_used)]

mod act;
mod chi_squared;
mod covariance;
mod density;
#[cfg(feature = "autodiff")]
mod dual;
mod fuse;
mod joint;
mod laws;
mod monte_carlo;
mod moves;
mod propagate;
mod regions;
mod samples;
mod split;
mod transform;
