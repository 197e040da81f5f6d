//! Landmarks seen from a pose.

use nalgebra::{Matrix2, SMatrix, SVector, Vector2, Vector3};

use crate::graph::Factor;
use crate::lie::{Action, LieGroup, Real, Rn, SE2, SE3};

/// A point seen from a planar pose, in the frame of the pose.
///
/// ```text
/// r = X⁻¹·p − z      ∂r/∂X = [−I, −[1]×·X⁻¹p]      ∂r/∂p = Rᵀ      2×3 and 2×2, local side
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting2 {
    /// z, in metres, in the frame of the pose.
    pub measured: Vector2<f64>,
}

impl Factor<2> for Sighting2 {
    const NAME: &'static str = "sighting";
    const RELATIVE: bool = true;
    type Variables = (SE2, Rn<2>);

    fn residual<S: Real>(&self, (x, p): &(SE2<S>, Rn<2, S>)) -> Vector2<S> {
        x.act_inverse(&p.vector()) - self.measured.map(S::lit)
    }

    fn residual_jac(&self, (x, p): &(SE2, Rn<2>)) -> (Vector2<f64>, (SMatrix<f64, 2, 3>, Matrix2<f64>)) {
        let (seen, d_seen_d_x, d_seen_d_p) = x.act_inverse_jac(&p.vector());
        (seen - self.measured, (d_seen_d_x, d_seen_d_p))
    }
}

/// A point seen from a pose in space by a sensor mounted at `pose_from_sensor`, in the frame of the sensor.
///
/// ```text
/// r = O⁻¹·(X⁻¹·p) − z      ∂r/∂X = R_Oᵀ·[−I, (X⁻¹p)^]      ∂r/∂p = R_Oᵀ·R_Xᵀ      3×6 and 3×3, local side
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting3 {
    /// z, in metres, in the frame of the sensor.
    pub measured: Vector3<f64>,
    /// O, where the sensor sits on the body.
    pub pose_from_sensor: SE3,
}

impl Sighting3 {
    /// A point seen by a sensor in the origin of the pose.
    pub fn new(measured: Vector3<f64>) -> Self {
        Self { measured, pose_from_sensor: SE3::identity() }
    }
}

impl Factor<3> for Sighting3 {
    const NAME: &'static str = "sighting";
    const RELATIVE: bool = true;
    type Variables = (SE3, Rn<3>);

    fn residual<S: Real>(&self, (x, p): &(SE3<S>, Rn<3, S>)) -> Vector3<S> {
        let sensor_from_pose = LieGroup::map(&self.pose_from_sensor.inverse(), S::lit);
        sensor_from_pose.act(&x.act_inverse(&p.vector())) - self.measured.map(S::lit)
    }

    fn residual_jac(
        &self,
        (x, p): &(SE3, Rn<3>),
    ) -> (SVector<f64, 3>, (SMatrix<f64, 3, 6>, SMatrix<f64, 3, 3>)) {
        let sensor_from_pose = self.pose_from_sensor.inverse();
        let (seen, d_seen_d_x, d_seen_d_p) = x.act_inverse_jac(&p.vector());
        let r = sensor_from_pose.rotation().to_matrix();
        (sensor_from_pose.act(&seen) - self.measured, (r * d_seen_d_x, r * d_seen_d_p))
    }
}
