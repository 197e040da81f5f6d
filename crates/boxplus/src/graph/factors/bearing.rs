//! Directions in which landmarks are seen.

use nalgebra::{Matrix1x2, Matrix1x3, Matrix2x3, SMatrix, Unit, Vector1, Vector2, Vector3, vector};

use crate::graph::Factor;
use crate::lie::{Action, Real, Rn, SE2, SE3, SO2};

/// The angle under which a point is seen from a planar pose, counted from the pose's x axis.
///
/// ```text
/// (a, b) = X⁻¹·p      r = atan2(b, a) − z, wrapped to (−π, π]      ∂r/∂(a, b) = (−b, a)/(a² + b²)
/// ```
///
/// Where the point stands in the pose the angle has no derivative; zero is returned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bearing2 {
    measured: SO2,
}

impl Bearing2 {
    /// The angle `measured`, in radians.
    pub fn new(measured: f64) -> Self {
        Self { measured: SO2::from_angle(measured) }
    }

    /// The measured direction in the frame of the pose, of length one.
    pub(crate) fn direction(&self) -> Vector2<f64> {
        vector![self.measured.cos(), self.measured.sin()]
    }
}

impl Factor<1> for Bearing2 {
    const NAME: &'static str = "bearing";
    const RELATIVE: bool = true;
    type Variables = (SE2, Rn<2>);

    fn residual<S: Real>(&self, (x, p): &(SE2<S>, Rn<2, S>)) -> Vector1<S> {
        let seen = x.act_inverse(&p.vector());
        let (cos, sin) = (S::lit(self.measured.cos()), S::lit(self.measured.sin()));
        // The angle from the measured direction to the seen one: wrapped by itself.
        vector![S::polar_angle(cos * seen.y - sin * seen.x, cos * seen.x + sin * seen.y)]
    }

    fn residual_jac(&self, variables: &(SE2, Rn<2>)) -> (Vector1<f64>, (Matrix1x3<f64>, Matrix1x2<f64>)) {
        let (x, p) = variables;
        let (seen, d_seen_d_x, d_seen_d_p) = x.act_inverse_jac(&p.vector());
        let square = seen.norm_squared();
        let d_r_d_seen =
            if square > 0.0 { Matrix1x2::new(-seen.y, seen.x) / square } else { Matrix1x2::zeros() };
        (self.residual::<f64>(variables), (d_r_d_seen * d_seen_d_x, d_r_d_seen * d_seen_d_p))
    }
}

/// The direction in which a point is seen from a pose in space.
///
/// ```text
/// u = X⁻¹p/‖X⁻¹p‖      r = Bᵀ·u      ∂r/∂u = Bᵀ      ∂u/∂(X⁻¹p) = (I − uuᵀ)/‖X⁻¹p‖
/// ```
///
/// The columns of B span the plane normal to the measured direction, so that for small errors r is the angle in
/// radians. A point opposite to the measured direction has r = 0 too: a bearing alone does not see the difference.
/// Where the point stands in the pose, value and derivative are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bearing3 {
    /// Bᵀ.
    plane: Matrix2x3<f64>,
}

impl Bearing3 {
    /// The direction `measured`, in the frame of the pose.
    pub fn new(measured: &Unit<Vector3<f64>>) -> Self {
        // The axis least aligned with it cannot be parallel to it.
        let axis = Vector3::ith(measured.iamin(), 1.0);
        let first = measured.cross(&axis).normalize();
        let second = measured.cross(&first);
        Self { plane: Matrix2x3::from_rows(&[first.transpose(), second.transpose()]) }
    }

    /// The measured direction in the frame of the pose, of length one: b₁ × (z × b₁) = z.
    pub(crate) fn direction(&self) -> Vector3<f64> {
        self.plane.row(0).transpose().cross(&self.plane.row(1).transpose())
    }
}

impl Factor<2> for Bearing3 {
    const NAME: &'static str = "bearing";
    const RELATIVE: bool = true;
    type Variables = (SE3, Rn<3>);

    fn residual<S: Real>(&self, (x, p): &(SE3<S>, Rn<3, S>)) -> Vector2<S> {
        let seen = x.act_inverse(&p.vector());
        let distance = seen.norm();
        let inverse = S::choose(distance.simd_gt(S::zero()), || distance.simd_recip(), S::zero);
        self.plane.map(S::lit) * (seen * inverse)
    }

    fn residual_jac(&self, (x, p): &(SE3, Rn<3>)) -> (Vector2<f64>, (SMatrix<f64, 2, 6>, Matrix2x3<f64>)) {
        let (seen, d_seen_d_x, d_seen_d_p) = x.act_inverse_jac(&p.vector());
        let distance = seen.norm();
        let inverse = if distance > 0.0 { distance.recip() } else { 0.0 };
        let u = seen * inverse;
        let d_r_d_seen = (self.plane - self.plane * u * u.transpose()) * inverse;
        (self.plane * u, (d_r_d_seen * d_seen_d_x, d_r_d_seen * d_seen_d_p))
    }
}
