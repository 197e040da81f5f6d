//! The pinhole with radial and tangential distortion.

use super::radial::{growth, inverse, rises};
use super::{Camera, Imaged, Unseen, added_to, in_front};
use crate::lie::Real;
use nalgebra::{Matrix2, SMatrix, SVector, Vector2, Vector3, vector};

/// A pinhole camera with radial and tangential distortion: Brown (1966), in the form and the order of OpenCV.
///
/// ```text
/// (a, b) = (x, y)/z     t = a² + b²     g = 1 + k₁t + k₂t² + k₃t³
/// u = f_x·(a·g + 2p₁ab + p₂(t + 2a²)) + c_x
/// v = f_y·(b·g + 2p₂ab + p₁(t + 2b²)) + c_y
/// ```
///
/// It sees z > 0 up to where r·g(r²) turns back; the tangential part, which is small in real lenses, is left out of that question.
///
/// ```
/// use boxplus::camera::{Camera, Pinhole};
/// use nalgebra::vector;
/// let camera = Pinhole::new([500.0, 500.0], [320.0, 240.0]);
/// assert_eq!(camera.project(&vector![0.4, -0.2, 2.0])?, vector![420.0, 190.0]);
/// # Ok::<(), boxplus::camera::Unseen>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pinhole<S = f64> {
    /// f_x, f_y in pixels.
    pub focal: [S; 2],
    /// c_x, c_y in pixels.
    pub centre: [S; 2],
    /// k₁, k₂, p₁, p₂, k₃.
    pub distortion: [S; 5],
}

impl<S: Real> Pinhole<S> {
    /// Without distortion.
    pub fn new(focal: [S; 2], centre: [S; 2]) -> Self {
        Self { focal, centre, distortion: [S::zero(); 5] }
    }

    fn radial(&self) -> [S; 3] {
        let [k1, k2, _, _, k3] = self.distortion;
        [k1, k2, k3]
    }

    /// The place (a, b) in the plane z = 1, distorted, and the derivative.
    #[inline]
    fn distort(&self, m: &Vector2<S>) -> (Vector2<S>, Matrix2<S>) {
        let two = S::lit(2.0);
        let [_, _, p1, p2, _] = self.distortion;
        let (a, b, t) = (m.x, m.y, m.norm_squared());
        let (g, d) = growth(&self.radial(), t);
        let across = two * a * b;
        let distorted = vector![
            a * g + p1 * across + p2 * (t + two * a * a),
            b * g + p2 * across + p1 * (t + two * b * b)
        ];
        let mixed = across * d + two * (p1 * a + p2 * b); // symmetric: the distortion is a gradient
        let six = S::lit(6.0);
        let along_a = g + two * a * a * d + two * p1 * b + six * p2 * a;
        let along_b = g + two * b * b * d + two * p2 * a + six * p1 * b;
        (distorted, Matrix2::new(along_a, mixed, mixed, along_b))
    }
}

impl<S: Real> Camera<2, 9> for Pinhole<S> {
    const INTRINSICS: &'static [&'static str] = &["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"];

    fn intrinsics(&self) -> SVector<S, 9> {
        let ([fx, fy], [cx, cy], [k1, k2, p1, p2, k3]) = (self.focal, self.centre, self.distortion);
        SVector::from([fx, fy, cx, cy, k1, k2, p1, p2, k3])
    }
    fn from_intrinsics(i: &SVector<S, 9>) -> Self {
        Self { focal: [i[0], i[1]], centre: [i[2], i[3]], distortion: [i[4], i[5], i[6], i[7], i[8]] }
    }
    fn sees(&self, p: &Vector3<S>) -> Result<(), Unseen> {
        in_front(p.z)?;
        let t = (p.x * p.x + p.y * p.y) / (p.z * p.z);
        if rises(&self.radial(), t) { Ok(()) } else { Err(Unseen::OutOfView) }
    }
    fn image(&self, p: &Vector3<S>) -> Vector2<S> {
        let (m, _) = self.distort(&vector![p.x / p.z, p.y / p.z]);
        vector![self.focal[0] * m.x + self.centre[0], self.focal[1] * m.y + self.centre[1]]
    }
    fn image_over<T: Real>(camera: &Pinhole<T>, p: &Vector3<T>) -> SVector<T, 2> {
        camera.image(p)
    }
    fn image_jac(&self, p: &Vector3<S>) -> Imaged<S, 2, 9> {
        let (o, one, two) = (S::zero(), S::one(), S::lit(2.0));
        let ([fx, fy], depth) = (self.focal, p.z.simd_recip());
        let (a, b) = (p.x * depth, p.y * depth);
        let (m, d) = self.distort(&vector![a, b]);
        let t = a * a + b * b;
        let image = vector![fx * m.x + self.centre[0], fy * m.y + self.centre[1]];
        let d_plane = Matrix2::new(fx * d.m11, fx * d.m12, fy * d.m21, fy * d.m22) * depth;
        let d_depth = -(d_plane * vector![a, b]);
        let d_p = SMatrix::<S, 2, 3>::from_columns(&[
            d_plane.column(0).into_owned(),
            d_plane.column(1).into_owned(),
            d_depth,
        ]);
        let (x, y, across) = (fx * a, fy * b, two * a * b);
        #[rustfmt::skip]
        let d_intrinsics = SMatrix::<S, 2, 9>::from_row_slice(&[
            m.x, o, one, o, x * t, x * t * t, fx * across, fx * (t + two * a * a), x * t * t * t,
            o, m.y, o, one, y * t, y * t * t, fy * (t + two * b * b), fy * across, y * t * t * t,
        ]);
        (image, d_p, d_intrinsics)
    }
    fn unproject(&self, image: &Vector2<S>) -> Result<Vector3<S>, Unseen> {
        let [u, v] = [0, 1].map(|i| (image[i] - self.centre[i]) / self.focal[i]);
        let target = vector![u, v];
        let radius = target.map(Real::value).norm();
        let undistorted = inverse(&self.radial(), S::lit(radius)).ok_or(Unseen::OutOfView)?.value();
        // The tangential part, by Newton's method from the radial inverse; one step more in `S` gives derivatives.
        let mut m = target * S::lit(if radius > 0.0 { undistorted / radius } else { 1.0 });
        for _ in 0..20 {
            let (distorted, d) = self.distort(&m);
            let miss = distorted - target;
            let adjugate = Matrix2::new(d.m22, -d.m12, -d.m21, d.m11);
            m -= adjugate * miss / (d.m11 * d.m22 - d.m12 * d.m21);
            if miss.map(Real::value).norm() <= 8.0 * S::EPSILON * radius {
                let p = vector![m.x, m.y, S::one()];
                return self.sees(&p).map(|()| p.normalize());
            }
        }
        Err(Unseen::OutOfView)
    }
}
added_to!(Pinhole, 2, 9);
