//! Other coordinates of rotations: Euler angles, quaternions of every convention, 6-D, Rodrigues vectors, directions.
//!
//! The library computes with [`SO3`] and differentiates by its rotation vector. Everything else is a way in or out:
//!
//! | coordinates | in | out | where they fail |
//! |---|---|---|---|
//! | rotation vector φ = θn | [`SO3::exp`](super::LieGroup::exp) | [`SO3::log`](super::LieGroup::log), [`SO3::log_near`] | jumps at θ = π, unless followed |
//! | axis and angle | [`SO3::from_axis_angle`], [`SO3::about_x`] … | [`SO3::to_axis_angle`] | any axis at the identity |
//! | matrix | [`SO3::from_matrix`], [`SO3::project`] | [`SO3::to_matrix`] | 9 numbers, 6 constraints |
//! | quaternion, Hamilton | [`SO3::from_xyzw`], [`SO3::from_wxyz`] | [`SO3::quaternion_xyzw`], [`SO3::quaternion_wxyz`] | two for each rotation |
//! | quaternion, JPL | [`SO3::from_jpl_xyzw`] | [`SO3::quaternion_jpl_xyzw`] | as above, and easily mistaken for Hamilton's |
//! | Euler angles, 24 sequences | [`SO3::from_euler`] | [`SO3::to_euler`] | gimbal lock |
//! | 6-D | [`SO3::from_6d`] | [`SO3::to_6d`] | nowhere: what networks learn |
//! | Gibbs vector tan(θ/2)·n | [`SO3::from_gibbs`] | [`SO3::to_gibbs`] | infinite at θ = π |
//! | modified Rodrigues tan(θ/4)·n | [`SO3::from_mrp`] | [`SO3::to_mrp`], [`SO3::to_mrp_shadow`] | switches sets at θ = π |
//! | two directions | [`SO3::between_directions`], [`SO3::from_direction_pairs`] | [`SO3::swing_twist`] | parallel directions |
//!
//! No three numbers are a chart without singularity, hence ⊞ and ⊟: estimate in the tangent, convert for people and files.
//! Every conversion has Jacobians with respect to the local tangent δ, R·Exp(δ), in a method ending in `_jac`; a covariance
//! Σ of δ is that of the coordinates after J·Σ·Jᵀ.
//!
//! **Accuracy**, in `f32` and `f64`, asserted by `tests/rotations` against 50 digits: axis, angle, Gibbs and modified Rodrigues
//! vectors within 4ε of their norm (tan(θ/2) of its condition, where that is larger); Euler angles within 6ε rad, the first and
//! the third over the sine of the distance from gimbal lock, which is all their rotation determines. All 24 sequences agree
//! with SciPy's, which at the lock sets the third angle to 0, too.
//!
//! ```
//! use boxplus::lie::{EulerSequence, SO3};
//! use nalgebra::Matrix3;
//! let world_from_body: SO3 = SO3::from_yaw_pitch_roll(0.5, 0.1, -0.2);
//! let (euler, d_euler_d_rotation) = world_from_body.to_euler_jac(EulerSequence::ZYX)?;
//! let [yaw, pitch, roll] = euler.angles;
//! assert!((yaw - 0.5).abs() < 1e-15 && (pitch - 0.1).abs() < 1e-15 && (roll + 0.2).abs() < 1e-15);
//! // 1° of noise about each body axis is more than 1° in yaw once the body pitches.
//! let sigma = Matrix3::from_diagonal_element(1.0_f64.to_radians().powi(2));
//! let of_angles = d_euler_d_rotation * sigma * d_euler_d_rotation.transpose();
//! assert!(of_angles[(0, 0)].sqrt().to_degrees() > 1.004);
//! # Ok::<(), boxplus::lie::LieError>(())
//! ```

pub mod convert;
pub mod directions;
pub mod euler;
pub mod matrix;
pub mod quaternion;
pub mod rodrigues;

pub use directions::SwingTwist;
pub use euler::{EulerAngles, EulerSequence, GimbalLock};

use super::{LieError, Real, SO3};
use nalgebra::{Matrix3, Vector3};

/// v^, the matrix of v × ·.
#[inline]
fn skew<S: Real>(v: &Vector3<S>) -> Matrix3<S> {
    <SO3<S> as super::LieGroup<3>>::hat(v)
}

/// `v` over its largest component, so that no square over- or underflows.
fn scaled<S: Real>(v: &Vector3<S>) -> Result<Vector3<S>, LieError> {
    if v.iter().any(|x| !x.value().is_finite()) {
        return Err(LieError::NotFinite);
    }
    let largest = v.iter().fold(0.0, |a: f64, x| a.max(x.value().abs()));
    if largest == 0.0 { Err(LieError::Zero) } else { Ok(v / S::lit(largest)) }
}

/// `v` at unit length, and its length.
pub(super) fn unit<S: Real>(v: &Vector3<S>) -> Result<Vector3<S>, LieError> {
    let v = scaled(v)?;
    Ok(v / v.norm_squared().simd_sqrt())
}
