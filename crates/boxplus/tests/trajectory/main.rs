//! Curves, kinematics, integrators and noise over time, held against dual numbers, arbitrary precision and Monte Carlo.
#![allow(missing_docs, clippy::unwrap_used)]

mod curves;
mod gaussian_process;
mod imu;
mod integrators;
mod kinematics;
mod noise;
mod spline;
mod support;
