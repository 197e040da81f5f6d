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
use crate::lie::{Action, LieGroup, Real, SE3, SO3};
use nalgebra::{Matrix3, SMatrix, SimdComplexField, Vector3, Vector6};

/// The elementary rotation about axis `k`.
fn about<S: Real>(k: usize, angle: S) -> SO3<S> {
    SO3::exp(&(Vector3::from_fn(|i, _| S::lit(f64::from(u8::from(i == k)))) * angle))
}

/// `(R, E)` at (yaw, pitch, roll).
fn rotation<S: Real>(angles: &Vector3<S>) -> (SO3<S>, Matrix3<S>) {
    let [z, y, x] = [about(2, angles.x), about(1, angles.y), about(0, angles.z)];
    let yaw = y.compose(&x).act_inverse(&Vector3::z());
    (z.compose(&y).compose(&x), Matrix3::from_columns(&[yaw, x.act_inverse(&Vector3::y()), Vector3::x()]))
}

/// (yaw, pitch, roll) of R, yaw and roll in (−π, π], |pitch| ≤ π/2.
fn angles<S: Real>(r: &Matrix3<S>) -> Vector3<S> {
    let cosine = (r.m11 * r.m11 + r.m21 * r.m21).simd_sqrt();
    let polar = S::polar_angle;
    Vector3::new(polar(r.m21, r.m11), polar(-r.m31, cosine), polar(r.m32, r.m33))
}

/// E⁻¹ at (yaw, pitch, roll), unless the pitch is ±π/2 to half of the digits.
fn inverse_rates<S: Real>(angles: &Vector3<S>) -> Result<Matrix3<S>, UncertaintyError> {
    let pitch = angles.y.value();
    if pitch.simd_cos() <= S::EPSILON.simd_sqrt() {
        return Err(UncertaintyError::GimbalLock { pitch });
    }
    let (_, e) = rotation(angles);
    let [a, b, c] = [0, 1, 2].map(|k| e.column(k).into_owned());
    let rows = [b.cross(&c), c.cross(&a), a.cross(&b)].map(|row| (row / a.dot(&b.cross(&c))).transpose());
    Ok(Matrix3::from_rows(&rows))
}

impl<S: Real> Gaussian<SO3<S>, 3> {
    /// From (yaw, pitch, roll) in radians and their 3×3 covariance in that order.
    pub fn from_yaw_pitch_roll(angles: &Vector3<S>, covariance: &Covariance<3, S>) -> Self {
        let (r, e) = rotation(angles);
        Self::new(r, covariance.transformed(&e))
    }

    /// `(angles, covariance)` in the order (yaw, pitch, roll), in radians.
    ///
    /// # Errors
    /// [`UncertaintyError::GimbalLock`].
    pub fn to_yaw_pitch_roll(&self) -> Result<(Vector3<S>, Covariance<3, S>), UncertaintyError> {
        let angles = angles(&self.mean().to_matrix());
        Ok((angles, self.covariance().transformed(&inverse_rates(&angles)?)))
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
        let (r, e) = rotation(&pose.fixed_rows::<3>(3).into_owned());
        let mean = SE3::new(r, pose.fixed_rows::<3>(0).into_owned());
        Self::new(mean, covariance.transformed(&blocks(&r.to_matrix().transpose(), &e)))
    }

    /// `(pose, covariance)` in the order (x, y, z, yaw, pitch, roll), metres of the parent frame and radians.
    ///
    /// # Errors
    /// [`UncertaintyError::GimbalLock`].
    pub fn to_yaw_pitch_roll(&self) -> Result<(Vector6<S>, Covariance<6, S>), UncertaintyError> {
        let (r, t) = (self.mean().rotation().to_matrix(), self.mean().translation());
        let angles = angles(&r);
        let covariance = self.covariance().transformed(&blocks(&r, &inverse_rates(&angles)?));
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
