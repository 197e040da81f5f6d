//! State estimation on Lie groups: where is it, and how sure are we?
//!
//! The modules are in reading order, and each imports only from those before it:
//!
//! | module | what | feature |
//! |---|---|---|
//! | [`lie`] | groups: Exp, Log, ⊞, ⊟, adjoints, every Jacobian on both sides | always, `no_std` |
//! | [`uncertainty`] | uncertain elements: compose, relate, fuse, transform, judge; to fourth order, on both sides | always, `no_std` |
//! | [`registration`] | clouds of points laid upon each other: in closed form where pairs are known, else by iterated closest points | always, `no_std` (`registration`: scans) |
//! | [`camera`] | cameras: pinhole, fisheye, double sphere, Bundler's, stereo; their images and every derivative | always, `no_std` |
//! | [`trajectory`] | curves, splines, kinematics, integrators, noise over time, inertial sensors | always, `no_std` |
//! | [`filter`] | filters: one belief carried through motions and measurements, and whether it can be believed | always, `no_std` (`rand`: Monte Carlo) |
//! | `graph` | factor graphs: the estimate that fits all measurements best, and how sure it is | `solve` (`parallel`: on all cores) |
//! | `pose_graph` | pose graphs as data: statistics, faults, simulators, and their optimum | `io` (and `solve`) |
//! | `bundle_adjustment` | cameras and points from images: faults, simulators, and the optimum | `io` (and `solve`) |
//! | `recording` | recorded sensors, filters that go through them, and how right they were | `std` |
//! | `io` | files: g2o, TORO, iSAM; TUM, EuRoC, KITTI, MRCLAM; point clouds in PLY, PCD, text and KITTI's binary; bundles in BAL's and COLMAP's text | `io` |
#![cfg_attr(not(feature = "std"), no_std)]

#[cfg(all(test, feature = "solve", feature = "io"))]
extern crate self as boxplus; // for files that tests within and without share

pub use nalgebra;

#[cfg(feature = "io")]
pub mod bundle_adjustment;
pub mod camera;
pub mod filter;
#[cfg(feature = "solve")]
pub mod graph;
#[cfg(feature = "io")]
pub mod io;
#[cfg(any(feature = "solve", feature = "io"))]
mod label;
pub mod lie;
#[cfg(any(feature = "solve", feature = "io"))]
mod partition;
#[cfg(any(feature = "solve", feature = "registration"))]
mod pool;
#[cfg(feature = "io")]
pub mod pose_graph;
#[cfg(all(test, feature = "solve", feature = "io"))]
mod public_graphs;
#[cfg(feature = "std")]
pub mod recording;
pub mod registration;
#[cfg(any(feature = "solve", feature = "registration"))]
mod robust;
pub mod trajectory;
pub mod uncertainty;

/// The README's example is a test.
#[cfg(all(doctest, feature = "solve"))]
#[doc = include_str!("../../../README.md")]
pub struct Readme;
