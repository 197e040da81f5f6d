//! A stereo camera that sees known points.

use crate::filter::Measurement;
use crate::lie::{Action, Real, SE3};
use crate::uncertainty::Covariance;
use nalgebra::{SMatrix, Vector3, Vector4};

/// A rectified pair of pinhole cameras, the right one a baseline along x from the left one; z looks ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StereoCamera<S: Real = f64> {
    /// f_u, f_v in pixels.
    pub focal: [S; 2],
    /// c_u, c_v in pixels.
    pub centre: [S; 2],
    /// b, in metres.
    pub baseline: S,
    /// From the frame of the body to that of the left camera.
    pub camera_from_body: SE3<S>,
}

/// A point at a known place, seen by a [`StereoCamera`]: y = π(C·X⁻¹·l) + n, pixels (u, v) left, then right.
///
/// ```text
/// u_l = f_u·x/z + c_u     v_l = f_v·y/z + c_v     u_r = f_u·(x − b)/z + c_u     v_r = v_l
/// ```
///
/// The triangulated point with a covariance of its own would be a [`Sighting`](super::Sighting); pixels keep their noise as it is, which
/// matters where points are far. A point behind the camera is not seen: its innovation is NaN, and the measurement refused. (Which is
/// looked up by value: for single numbers.)
///
/// ```
/// use boxplus::filter::{Measurement, StereoCamera, StereoSighting, check_measurement};
/// use boxplus::lie::{LieGroup, SE3};
/// use boxplus::uncertainty::Covariance;
/// use nalgebra::{Vector4, vector};
/// let camera =
///     StereoCamera { focal: [400.0, 400.0], centre: [320.0, 240.0], baseline: 0.2, camera_from_body: SE3::identity() };
/// let seen = StereoSighting {
///     camera,
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
    pub camera: StereoCamera<S>,
    /// l, in metres of the world.
    pub landmark: Vector3<S>,
    /// y: (u_l, v_l, u_r, v_r) in pixels.
    pub measured: Vector4<S>,
    /// Of y.
    pub noise: Covariance<4, S>,
}

impl<S: Real> StereoCamera<S> {
    /// Pixels of a point in the frame of the body.
    fn project(&self, p_body: &Vector3<S>) -> Vector4<S> {
        let p = self.ahead(p_body);
        let [fu, fv] = self.focal;
        let [cu, cv] = self.centre;
        let v = fv * p.y / p.z + cv;
        Vector4::new(fu * p.x / p.z + cu, v, fu * (p.x - self.baseline) / p.z + cu, v)
    }

    /// Their derivatives by the point, 4×3.
    fn d_project(&self, p_body: &Vector3<S>) -> SMatrix<S, 4, 3> {
        let p = self.ahead(p_body);
        let [fu, fv] = self.focal.map(|f| f / p.z);
        let o = S::zero();
        let [left, down, right] = [p.x, p.y, p.x - self.baseline].map(|x| x / p.z);
        #[rustfmt::skip]
        let d_camera = SMatrix::<S, 4, 3>::new(
            fu, o, -fu * left,
            o, fv, -fv * down,
            fu, o, -fu * right,
            o, fv, -fv * down,
        );
        d_camera * self.camera_from_body.rotation().to_matrix()
    }

    /// The point in the frame of the camera; NaN where it is not in front.
    fn ahead(&self, p_body: &Vector3<S>) -> Vector3<S> {
        let p = self.camera_from_body.act(p_body);
        if p.z.value() > 0.0 { p } else { Vector3::repeat(S::lit(f64::NAN)) }
    }
}

impl<S: Real> Measurement<SE3<S>, 6, 4> for StereoSighting<S> {
    fn innovation(&self, x: &SE3<S>) -> Vector4<S> {
        self.measured - self.camera.project(&x.act_inverse(&self.landmark))
    }
    fn noise(&self) -> Covariance<4, S> {
        self.noise
    }
    fn innovation_jac(&self, x: &SE3<S>) -> (Vector4<S>, SMatrix<S, 4, 6>) {
        let (p, d_p, _) = x.act_inverse_jac(&self.landmark);
        (self.measured - self.camera.project(&p), self.camera.d_project(&p) * d_p)
    }
    fn innovation_left_jac(&self, x: &SE3<S>) -> (Vector4<S>, SMatrix<S, 4, 6>) {
        let (p, d_p, _) = x.act_inverse_left_jac(&self.landmark);
        (self.measured - self.camera.project(&p), self.camera.d_project(&p) * d_p)
    }
}
