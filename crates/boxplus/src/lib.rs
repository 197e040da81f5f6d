//! State estimation on Lie groups: where is it, and how sure are we?
//!
//! The modules are in reading order, and each imports only from those before it:
//! `lie → graph → pose_graph → io`.
#![cfg_attr(not(feature = "std"), no_std)]

pub use nalgebra;

#[cfg(feature = "solve")]
pub mod graph;
#[cfg(feature = "io")]
pub mod io;
pub mod lie;
#[cfg(feature = "io")]
pub mod pose_graph;
