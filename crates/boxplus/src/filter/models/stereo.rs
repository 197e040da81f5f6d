//! A stereo camera that sees known points.

use crate::camera::{Camera, Stereo};
use crate::filter::Measurement;
use crate::lie::{Action, Real, SE3};
use crate::uncertainty::Covariance;
use nalgebra::{SMatrix, Vector3, Vector4};

/// A point at a known place, seen by a pair of cameras, π a [`Stereo`]: y = π(C·X⁻¹·l) + n, pixels (u, v) left, then right.
///
/// The triangulated point with a covariance of its own would be a [`Sighting`](super::Sighting); pixels keep their noise as it is, which
/// matters where points are far. A point behind the camera is not seen: its innovation is NaN, and the measurement refused. (Which is
/// looked up by value: for single numbers.)
///
/// ```
/// use boxplus::camera::Stereo;
/// use boxplus::filter::{Measurement, StereoSighting, check_measurement};
/// use boxplus::lie::{LieGroup, SE3};
/// use boxplus::uncertainty::Covariance;
/// use nalgebra::{Vector4, vector};
/// let seen = StereoSighting {
///     camera: Stereo { focal: [400.0, 400.0], centre: [320.0, 240.0], baseline: 0.2 },
///     camera_from_body: SE3::identity(),
///     landmark: vector![1.0, 0.5, 4.0],
///     measured: vector![420.0, 290.0, 400.0, 290.0],
///     noise: Covariance::from_sigmas(&Vector4::repeat(2.0))?,
/// };
/// let x = SE3::exp(&vector![0.1, -0.2, 0.3, 0.05, -0.1, 0.2]);
/// assert!(seen.innovation(&SE3::identity()).norm() < 1e-12);
/// assert!(check_measurement(&seen, &x) < 1e-6); // of some hundred pixels
/// # Ok::<(), boxplus::uncertainty::UncertaintyError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StereoSighting<S: Real = f64> {
    /// What sees it.
    pub camera: Stereo<S>,
    /// C, from the frame of the body to that of the left camera.
    pub camera_from_body: SE3<S>,
    /// l, in metres of the world.
    pub landmark: Vector3<S>,
    /// y: (u_l, v_l, u_r, v_r) in pixels.
    pub measured: Vector4<S>,
    /// Of y.
    pub noise: Covariance<4, S>,
}

impl<S: Real> StereoSighting<S> {
    /// y − π and its derivative by the point in the frame of the body, 4×3; NaN where it is not in front.
    fn innovation_at(&self, p_body: &Vector3<S>) -> (Vector4<S>, SMatrix<S, 4, 3>) {
        let seen = self.camera.project_jac(&self.camera_from_body.act(p_body));
        let nowhere = S::lit(f64::NAN);
        let (image, d_p) =
            seen.map_or((Vector4::repeat(nowhere), SMatrix::repeat(nowhere)), |(image, d_p, _)| (image, d_p));
        (self.measured - image, d_p * self.camera_from_body.linear_part())
    }
}

impl<S: Real> Measurement<SE3<S>, 6, 4> for StereoSighting<S> {
    fn innovation(&self, x: &SE3<S>) -> Vector4<S> {
        self.innovation_at(&x.act_inverse(&self.landmark)).0
    }
    fn noise(&self) -> Covariance<4, S> {
        self.noise
    }
    fn innovation_jac(&self, x: &SE3<S>) -> (Vector4<S>, SMatrix<S, 4, 6>) {
        let (p, d_p, _) = x.act_inverse_jac(&self.landmark);
        let (innovation, d_innovation) = self.innovation_at(&p);
        (innovation, d_innovation * d_p)
    }
    fn innovation_left_jac(&self, x: &SE3<S>) -> (Vector4<S>, SMatrix<S, 4, 6>) {
        let (p, d_p, _) = x.act_inverse_left_jac(&self.landmark);
        let (innovation, d_innovation) = self.innovation_at(&p);
        (innovation, d_innovation * d_p)
    }
}
