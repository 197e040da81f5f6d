//! Uncertain elements: every formula against Monte Carlo with its standard error, published numbers, and laws over all
//! groups.
#![allow(missing_docs, clippy::unwrap_used)]

mod monte_carlo;
mod propagate;
