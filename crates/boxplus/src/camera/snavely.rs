//! The camera of Bundler and of Bundle Adjustment in the Large.

use super::radial::{growth, inverse, rises};
use super::{Camera, Imaged, Unseen, added_to, in_front};
use crate::lie::Real;
use nalgebra::{Matrix2, Matrix2x3, SVector, Vector2, Vector3, matrix, vector};

/// The camera of Bundler and of Bundle Adjustment in the Large: Snavely, Seitz & Szeliski (2006); Agarwal et al. (2010).
///
/// It looks along **−z**, with x to the right and y **up** in the image; pixels count from the middle of the image.
///
/// ```text
/// (a, b) = −(x, y)/z     t = a² + b²     (u, v) = f·(1 + k₁t + k₂t²)·(a, b)
/// ```
///
/// ```
/// use boxplus::camera::{Camera, Snavely};
/// use nalgebra::vector;
/// let camera = Snavely { focal: 500.0, distortion: [0.0, 0.0] };
/// assert_eq!(camera.project(&vector![0.4, 0.2, -2.0])?, vector![100.0, 50.0]);
/// # Ok::<(), boxplus::camera::Unseen>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snavely<S = f64> {
    /// f in pixels.
    pub focal: S,
    /// k₁, k₂.
    pub distortion: [S; 2],
}

impl<S: Real> Camera<2, 3> for Snavely<S> {
    const INTRINSICS: &'static [&'static str] = &["f", "k1", "k2"];

    #[inline]
    fn intrinsics(&self) -> Vector3<S> {
        let [k1, k2] = self.distortion;
        vector![self.focal, k1, k2]
    }
    #[inline]
    fn from_intrinsics(i: &Vector3<S>) -> Self {
        Self { focal: i[0], distortion: [i[1], i[2]] }
    }
    fn sees(&self, p: &Vector3<S>) -> Result<(), Unseen> {
        in_front(-p.z)?;
        let t = (p.x * p.x + p.y * p.y) / (p.z * p.z);
        if rises(&self.distortion, t) { Ok(()) } else { Err(Unseen::OutOfView) }
    }
    #[inline]
    fn image(&self, p: &Vector3<S>) -> Vector2<S> {
        let m = vector![p.x, p.y] * -p.z.simd_recip();
        m * (self.focal * growth(&self.distortion, m.norm_squared()).0)
    }
    fn image_over<T: Real>(camera: &Snavely<T>, p: &Vector3<T>) -> SVector<T, 2> {
        camera.image(p)
    }
    #[inline]
    fn image_jac(&self, p: &Vector3<S>) -> Imaged<S, 2, 3> {
        let (f, depth) = (self.focal, -p.z.simd_recip());
        let m = vector![p.x, p.y] * depth;
        let t = m.norm_squared();
        let (g, d) = growth(&self.distortion, t);
        let (stretch, bend) = (f * g, f * d * S::lit(2.0));
        let d_m = Matrix2::new(
            stretch + bend * m.x * m.x,
            bend * m.x * m.y,
            bend * m.x * m.y,
            stretch + bend * m.y * m.y,
        ) * depth;
        let d_z = d_m * m;
        let d_p = Matrix2x3::new(d_m.m11, d_m.m12, d_z.x, d_m.m21, d_m.m22, d_z.y);
        let (k1, k2) = (f * t, f * t * t);
        let d_intrinsics = matrix![m.x * g, m.x * k1, m.x * k2; m.y * g, m.y * k1, m.y * k2];
        (m * stretch, d_p, d_intrinsics)
    }
    fn unproject(&self, image: &Vector2<S>) -> Result<Vector3<S>, Unseen> {
        let m = image / self.focal;
        let radius = m.norm();
        let tangent = if radius.value() == 0.0 {
            radius
        } else {
            inverse(&self.distortion, radius).ok_or(Unseen::OutOfView)?
        };
        let shrink = growth(&self.distortion, tangent * tangent).0.simd_recip();
        Ok(vector![m.x * shrink, m.y * shrink, -S::one()].normalize())
    }
}
added_to!(Snavely, 2, 3);
