//! The fisheye of Kannala and Brandt.

use super::radial::{growth, inverse, rises};
use super::{Camera, Imaged, Unseen, added_to, in_front};
use crate::lie::{Real, Stumpff};
use nalgebra::{SMatrix, SVector, Vector2, Vector3, vector};

/// A fisheye: the radius in the image is a polynomial of the angle from the axis. Kannala & Brandt (2006), in the form of OpenCV's
/// `fisheye`.
///
/// ```text
/// r = √(x² + y²)     θ = atan2(r, z)     ρ = θ·(1 + k₁θ² + k₂θ⁴ + k₃θ⁶ + k₄θ⁸)
/// u = f_x·ρ·x/r + c_x     v = f_y·ρ·y/r + c_y
/// ```
///
/// It sees all angles θ < π up to where ρ turns back. On the axis nothing is divided by r: θ/r is smooth there, and so is the code.
///
/// ```
/// use boxplus::camera::{Camera, KannalaBrandt};
/// use nalgebra::vector;
/// let camera = KannalaBrandt { focal: [100.0, 100.0], centre: [0.0, 0.0], distortion: [0.0; 4] };
/// let right_angle = camera.project(&vector![2.0, 0.0, 0.0])?;
/// assert!((right_angle - vector![50.0 * core::f64::consts::PI, 0.0]).norm() < 1e-12);
/// # Ok::<(), boxplus::camera::Unseen>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KannalaBrandt<S = f64> {
    /// f_x, f_y in pixels a radian.
    pub focal: [S; 2],
    /// c_x, c_y in pixels.
    pub centre: [S; 2],
    /// k₁, k₂, k₃, k₄.
    pub distortion: [S; 4],
}

/// θ/r and θ² of a point.
#[inline]
fn angle<S: Real>(p: &Vector3<S>) -> (S, S) {
    let (r2, n) = (p.x * p.x + p.y * p.y, p.norm());
    // Of half the angle, whose cosine is positive all around: cos² = (n + z)/2n, and r = 2n·sin·cos.
    let ahead = (n + p.z) * S::lit(2.0) * n;
    let cos = ahead.simd_sqrt() / (n * S::lit(2.0));
    let quotient = S::angle_over_sine(r2 / ahead, cos) / (n * cos);
    (quotient, quotient * quotient * r2)
}

impl<S: Real> Camera<2, 8> for KannalaBrandt<S> {
    const INTRINSICS: &'static [&'static str] = &["fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4"];

    fn intrinsics(&self) -> SVector<S, 8> {
        let ([fx, fy], [cx, cy], [k1, k2, k3, k4]) = (self.focal, self.centre, self.distortion);
        SVector::from([fx, fy, cx, cy, k1, k2, k3, k4])
    }
    fn from_intrinsics(i: &SVector<S, 8>) -> Self {
        Self { focal: [i[0], i[1]], centre: [i[2], i[3]], distortion: [i[4], i[5], i[6], i[7]] }
    }
    fn sees(&self, p: &Vector3<S>) -> Result<(), Unseen> {
        in_front(p.norm() + p.z)?; // straight behind is no direction in the image
        if rises(&self.distortion, angle(p).1) { Ok(()) } else { Err(Unseen::OutOfView) }
    }
    fn image(&self, p: &Vector3<S>) -> Vector2<S> {
        let (q, t) = angle(p);
        let s = q * growth(&self.distortion, t).0;
        vector![self.focal[0] * s * p.x + self.centre[0], self.focal[1] * s * p.y + self.centre[1]]
    }
    fn image_over<T: Real>(camera: &KannalaBrandt<T>, p: &Vector3<T>) -> SVector<T, 2> {
        camera.image(p)
    }
    fn image_jac(&self, p: &Vector3<S>) -> Imaged<S, 2, 8> {
        let (o, one, two, four) = (S::zero(), S::one(), S::lit(2.0), S::lit(4.0));
        let [fx, fy] = self.focal;
        let (q, t) = angle(p);
        let (g, d) = growth(&self.distortion, t);
        let s = q * g;
        let image = vector![fx * s * p.x + self.centre[0], fy * s * p.y + self.centre[1]];
        // With n = |p|, for x and likewise y: ∂q/∂x = x·(z/n² − q)/r² = −4x·c₃(4θ²)·q³, ∂θ²/∂x = 2qxz/n²; and along z:
        let inverse_square = p.norm_squared().simd_recip();
        let (dq, dt) = (-four * Stumpff::new(four * t).c3 * q * q * q, two * q * p.z * inverse_square);
        let (dq_z, dt_z) = (-inverse_square, -two * q * (p.x * p.x + p.y * p.y) * inverse_square);
        let aside = g * dq + q * d * dt;
        let ds = vector![aside * p.x, aside * p.y, g * dq_z + q * d * dt_z];
        #[rustfmt::skip]
        let d_p = SMatrix::<S, 2, 3>::new(
            fx * (s + p.x * ds.x), fx * p.x * ds.y, fx * p.x * ds.z,
            fy * p.y * ds.x, fy * (s + p.y * ds.y), fy * p.y * ds.z,
        );
        let (x, y) = (fx * q * p.x, fy * q * p.y);
        let [t2, t3, t4] = [t * t, t * t * t, t * t * t * t];
        #[rustfmt::skip]
        let d_intrinsics = SMatrix::<S, 2, 8>::from_row_slice(&[
            s * p.x, o, one, o, x * t, x * t2, x * t3, x * t4,
            o, s * p.y, o, one, y * t, y * t2, y * t3, y * t4,
        ]);
        (image, d_p, d_intrinsics)
    }
    fn unproject(&self, image: &Vector2<S>) -> Result<Vector3<S>, Unseen> {
        let [a, b] = [0, 1].map(|i| (image[i] - self.centre[i]) / self.focal[i]);
        let radius = (a * a + b * b).simd_sqrt();
        if radius.value() == 0.0 {
            return Ok(vector![a, b, S::one()]);
        }
        let theta = inverse(&self.distortion, radius).ok_or(Unseen::OutOfView)?;
        if theta.value() >= core::f64::consts::PI {
            return Err(Unseen::OutOfView);
        }
        let c = Stumpff::new(theta * theta);
        let shrink = c.c1 / growth(&self.distortion, theta * theta).0; // sin θ/ρ
        Ok(vector![a * shrink, b * shrink, c.c0])
    }
}
added_to!(KannalaBrandt, 2, 8);
