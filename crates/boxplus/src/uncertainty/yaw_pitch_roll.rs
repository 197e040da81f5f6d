//! Covariances of yaw, pitch and roll, as sensors and older programs give them.
//!
//! R = R_z(yaw)·R_y(pitch)·R_x(roll). A small change of the angles turns the body by
//!
//! ```text
//! φ = E·(δyaw, δpitch, δroll),   E = [R_xᵀR_yᵀe_z, R_xᵀe_y, e_x]      det E = −cos(pitch)
//! ```
//!
//! in its own frame, so that Σ_local = EΣEᵀ to first order in the spread. At a pitch of ±π/2 yaw and roll turn about one axis:
//! no covariance of the angles exists there, and near it they are spread without bound, however certain the rotation is.

use super::{Covariance, Gaussian, UncertaintyError};
use crate::lie::{EulerSequence, Real, SE3, SO3};
use nalgebra::{Matrix3, SMatrix, Vector3, Vector6};

/// `(R, E)` at (yaw, pitch, roll).
fn rotation<S: Real>(angles: Vector3<S>) -> (SO3<S>, Matrix3<S>) {
    SO3::from_euler_jac(EulerSequence::ZYX, angles.into())
}

/// (yaw, pitch, roll) of R, and E⁻¹ there, unless the pitch is ±π/2 to half of the digits.
fn angles<S: Real>(r: &SO3<S>) -> Result<(Vector3<S>, Matrix3<S>), UncertaintyError> {
    let euler = r.to_euler(EulerSequence::ZYX);
    match euler.d_angles_d_rotation() {
        Ok(rates) if euler.lock.is_none() => Ok((euler.angles.into(), rates)),
        _ => Err(UncertaintyError::GimbalLock { pitch: euler.angles[1].value() }),
    }
}

impl<S: Real> Gaussian<SO3<S>, 3> {
    /// From (yaw, pitch, roll) in radians and their 3×3 covariance in that order.
    pub fn from_yaw_pitch_roll(angles: &Vector3<S>, covariance: &Covariance<3, S>) -> Self {
        let (r, e) = rotation(*angles);
        Self::new(r, covariance.transformed(&e))
    }

    /// `(angles, covariance)` in the order (yaw, pitch, roll), in radians.
    ///
    /// # Errors
    /// [`UncertaintyError::GimbalLock`].
    pub fn to_yaw_pitch_roll(&self) -> Result<(Vector3<S>, Covariance<3, S>), UncertaintyError> {
        let (angles, rates) = angles(self.mean())?;
        Ok((angles, self.covariance().transformed(&rates)))
    }
}

impl<S: Real> Gaussian<SE3<S>, 6> {
    /// From (x, y, z, yaw, pitch, roll), metres of the parent frame and radians, and their 6×6 covariance in that order.
    ///
    /// ```
    /// use boxplus::lie::SE3;
    /// use boxplus::uncertainty::{Covariance, Gaussian};
    /// use nalgebra::vector;
    /// let pose = vector![1.0, 2.0, 0.5, 1.2, 0.1, -0.05];
    /// let given = Covariance::from_sigmas(&vector![0.5, 0.5, 1.0, 0.1, 0.02, 0.02])?; // a GNSS receiver with a compass
    /// let gaussian = Gaussian::<SE3, 6>::from_yaw_pitch_roll(&pose, &given);
    /// let (back, covariance) = gaussian.to_yaw_pitch_roll()?;
    /// assert!((back - pose).norm() < 1e-14 && (covariance.matrix() - given.matrix()).amax() < 1e-14);
    /// # Ok::<(), boxplus::uncertainty::UncertaintyError>(())
    /// ```
    pub fn from_yaw_pitch_roll(pose: &Vector6<S>, covariance: &Covariance<6, S>) -> Self {
        let (r, e) = rotation(pose.fixed_rows::<3>(3).into_owned());
        let mean = SE3::new(r, pose.fixed_rows::<3>(0).into_owned());
        Self::new(mean, covariance.transformed(&blocks(&r.to_matrix().transpose(), &e)))
    }

    /// `(pose, covariance)` in the order (x, y, z, yaw, pitch, roll), metres of the parent frame and radians.
    ///
    /// # Errors
    /// [`UncertaintyError::GimbalLock`].
    pub fn to_yaw_pitch_roll(&self) -> Result<(Vector6<S>, Covariance<6, S>), UncertaintyError> {
        let (r, t) = (self.mean().rotation(), self.mean().translation());
        let (angles, rates) = angles(&r)?;
        let covariance = self.covariance().transformed(&blocks(&r.to_matrix(), &rates));
        Ok((Vector6::new(t.x, t.y, t.z, angles.x, angles.y, angles.z), covariance))
    }
}

/// \[a, 0; 0, b\].
fn blocks<S: Real>(a: &Matrix3<S>, b: &Matrix3<S>) -> SMatrix<S, 6, 6> {
    let mut m = SMatrix::<S, 6, 6>::zeros();
    m.fixed_view_mut::<3, 3>(0, 0).copy_from(a);
    m.fixed_view_mut::<3, 3>(3, 3).copy_from(b);
    m
}
