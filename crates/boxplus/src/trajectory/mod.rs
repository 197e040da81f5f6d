//! Elements over time: curves through them, bodies in motion, and what becomes of errors on the way.
//!
//! | question | answer |
//! |---|---|
//! | Where was it between two stamps? | [`crate::lie::LieGroup::interpolate`], [`slerp`] |
//! | A smooth path through poses at given times? | [`CatmullRom`]; between two poses with velocities [`Hermite`] |
//! | A trajectory to estimate, with accelerations? | [`BSpline`], any order, with derivatives in its control elements |
//! | A curve to shape by hand? | [`Bezier`], [`Squad`] |
//! | Where does this velocity lead? | [`Integrator`]; [`magnus4`] where it is known in advance |
//! | What noise does a step add? | [`discretise`], [`velocity_noise`] |
//! | Hundreds of inertial samples as one measurement? | [`Preintegration`] |
//! | A prior that joins states in time, and a query between them? | [`GaussianProcess`] of [`Moving`] states |
//! | How do rates and errors transform? | [`Motion`], [`body_velocity`], [`local_error_transition`], … |
//!
//! Everything is written against [`crate::lie::LieGroup`] alone: it serves every group here and every group of a user's, in
//! `f32`, `f64` and dual numbers, without allocation.
//!
//! - **Rates are of the body**: Ẋ = X·ω^. Spatial rates, Ẋ = ϖ^·X, are spelled out. Units are those of the tangent per unit
//!   of time.
//! - **Derivatives** in elements are right (local); in time they are the rates themselves.
//! - **Half a turn** between neighbours has two shortest ways. The curves refuse it ([`TrajectoryError::Ambiguous`]) instead
//!   of tossing a coin.
#![allow(clippy::type_complexity)] // A value and one Jacobian per argument; naming each tuple would hide that.

mod adaptive;
mod bspline;
mod chain;
mod coordinates;
mod curves;
mod error;
mod gaussian_process;
mod imu;
mod integrate;
mod kinematics;
mod magnus;
mod motion;
mod moving;
mod noise;

pub use adaptive::Adaptive;
pub use bspline::{BSpline, SplineJac};
#[cfg(feature = "solve")]
pub(crate) use bspline::{segment, segment_jac};
pub use curves::{Bezier, CatmullRom, Hermite, HermiteJac, PathJac, Squad, slerp};
pub use error::TrajectoryError;
pub use gaussian_process::{
    GaussianProcess, StateJac, gp_bridge, gp_covariance, gp_information, gp_interpolation, gp_transition,
};
pub use imu::{Imu, ImuBias, ImuNoise, Preintegration};
pub use integrate::Integrator;
pub use kinematics::{
    body_velocity, global_error_dynamics, global_error_integral, global_error_transition,
    local_error_dynamics, local_error_integral, local_error_transition, rate_from_body, rate_from_spatial,
    spatial_velocity,
};
pub use magnus::{magnus_linear, magnus_linear_spatial, magnus2, magnus4, magnus4_spatial};
pub use motion::{Motion, MotionJac, PointMotion};
pub use moving::Moving;
pub use noise::{discretise, velocity_noise, velocity_noise_first_order};
