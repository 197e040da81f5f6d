//! Filters: closed forms against differences and dual numbers, textbook special cases, what theory says of sides, published
//! numbers by Monte Carlo, and bad input.
#![allow(missing_docs, clippy::unwrap_used)]

mod linear;
mod models;
mod refused;
mod sides;
