//! A rectified pair of cameras.

use super::{Camera, Imaged, Unseen, added_to, in_front};
use crate::lie::Real;
use nalgebra::{SMatrix, SVector, Vector3, Vector4, Vector5, vector};

/// A rectified pair of pinhole cameras, the right one a baseline along x from the left one, whose frame is that of the pair.
///
/// ```text
/// u_l = f_x·x/z + c_x     v_l = f_y·y/z + c_y     u_r = f_x·(x − b)/z + c_x     v_r = v_l
/// ```
///
/// Its image is (u_l, v_l, u_r, v_r). Where a file has one v only, it stands in both places with √2 of its standard deviation.
///
/// ```
/// use boxplus::camera::{Camera, Stereo};
/// use nalgebra::vector;
/// let pair = Stereo { focal: [400.0, 400.0], centre: [320.0, 240.0], baseline: 0.2 };
/// let seen = pair.project(&vector![1.0, 0.5, 4.0])?;
/// assert!((seen - vector![420.0, 290.0, 400.0, 290.0]).norm() < 1e-12);
/// assert!((pair.unproject(&seen)? - vector![1.0, 0.5, 4.0]).norm() < 1e-12); // the point itself
/// # Ok::<(), boxplus::camera::Unseen>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stereo<S = f64> {
    /// f_x, f_y in pixels.
    pub focal: [S; 2],
    /// c_x, c_y in pixels.
    pub centre: [S; 2],
    /// b, in metres.
    pub baseline: S,
}

impl<S: Real> Camera<4, 5> for Stereo<S> {
    const INTRINSICS: &'static [&'static str] = &["fx", "fy", "cx", "cy", "baseline"];

    fn intrinsics(&self) -> Vector5<S> {
        let ([fx, fy], [cx, cy]) = (self.focal, self.centre);
        vector![fx, fy, cx, cy, self.baseline]
    }
    fn from_intrinsics(i: &Vector5<S>) -> Self {
        Self { focal: [i[0], i[1]], centre: [i[2], i[3]], baseline: i[4] }
    }
    fn sees(&self, p: &Vector3<S>) -> Result<(), Unseen> {
        in_front(p.z)
    }
    fn image(&self, p: &Vector3<S>) -> Vector4<S> {
        let ([fx, fy], [cx, cy]) = (self.focal, self.centre);
        let v = fy * p.y / p.z + cy;
        Vector4::new(fx * p.x / p.z + cx, v, fx * (p.x - self.baseline) / p.z + cx, v)
    }
    fn image_over<T: Real>(camera: &Stereo<T>, p: &Vector3<T>) -> SVector<T, 4> {
        camera.image(p)
    }
    fn image_jac(&self, p: &Vector3<S>) -> Imaged<S, 4, 5> {
        let (o, one) = (S::zero(), S::one());
        let [fx, fy] = self.focal.map(|f| f / p.z);
        let [left, down, right] = [p.x, p.y, p.x - self.baseline].map(|x| x / p.z);
        #[rustfmt::skip]
        let d_p = SMatrix::<S, 4, 3>::new(
            fx, o, -fx * left,
            o, fy, -fy * down,
            fx, o, -fx * right,
            o, fy, -fy * down,
        );
        #[rustfmt::skip]
        let d_intrinsics = SMatrix::<S, 4, 5>::from_row_slice(&[
            left, o, one, o, o,
            o, down, o, one, o,
            right, o, one, o, -fx,
            o, down, o, one, o,
        ]);
        (self.image(p), d_p, d_intrinsics)
    }
    /// The point at which both rays meet, v being the mean of both. A disparity that is not positive is out of view.
    fn unproject(&self, image: &Vector4<S>) -> Result<Vector3<S>, Unseen> {
        let disparity = image[0] - image[2];
        in_front(disparity).map_err(|_| Unseen::OutOfView)?;
        let ([fx, fy], [cx, cy]) = (self.focal, self.centre);
        let z = fx * self.baseline / disparity;
        let v = (image[1] + image[3]) * S::lit(0.5);
        Ok(vector![(image[0] - cx) / fx, (v - cy) / fy, S::one()] * z)
    }
}
added_to!(Stereo, 4, 5);
