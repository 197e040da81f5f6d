//! The factor graph, seen from outside.

mod custom;
mod faults;
mod solve;
mod uncertainty;
mod world;
