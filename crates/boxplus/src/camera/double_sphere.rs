//! The double sphere model.

use super::{Camera, Imaged, Unseen, added_to, in_front};
use crate::lie::Real;
use nalgebra::{SMatrix, SVector, Vector2, Vector3, Vector6, vector};

/// The double sphere model of wide-angle lenses: a point falls on one unit sphere, then on another one ξ ahead, and is then seen
/// from α/(1 − α) behind the second one's centre. Usenko, Demmel & Cremers (2018), eqs. (40)–(52). Its inverse is a closed form.
///
/// ```text
/// d₁ = |p|     k = ξd₁ + z     d₂ = √(x² + y² + k²)     D = α·d₂ + (1 − α)·k
/// u = f_x·x/D + c_x     v = f_y·y/D + c_y
/// ```
///
/// ```
/// use boxplus::camera::{Camera, DoubleSphere};
/// use nalgebra::vector;
/// let camera = DoubleSphere { focal: [364.0, 364.0], centre: [376.0, 240.0], xi: -0.2, alpha: 0.58 };
/// let p = vector![1.0, 0.5, 0.3];
/// assert!((camera.unproject(&camera.project(&p)?)? - p.normalize()).norm() < 1e-14);
/// # Ok::<(), boxplus::camera::Unseen>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoubleSphere<S = f64> {
    /// f_x, f_y in pixels.
    pub focal: [S; 2],
    /// c_x, c_y in pixels.
    pub centre: [S; 2],
    /// ξ, from −1 to 1: the distance of the spheres.
    pub xi: S,
    /// α, from 0 to 1.
    pub alpha: S,
}

impl<S: Real> Camera<2, 6> for DoubleSphere<S> {
    const INTRINSICS: &'static [&'static str] = &["fx", "fy", "cx", "cy", "xi", "alpha"];

    fn intrinsics(&self) -> Vector6<S> {
        let ([fx, fy], [cx, cy]) = (self.focal, self.centre);
        Vector6::new(fx, fy, cx, cy, self.xi, self.alpha)
    }
    fn from_intrinsics(i: &Vector6<S>) -> Self {
        Self { focal: [i[0], i[1]], centre: [i[2], i[3]], xi: i[4], alpha: i[5] }
    }
    fn sees(&self, p: &Vector3<S>) -> Result<(), Unseen> {
        let (alpha, xi) = (self.alpha.value(), self.xi.value());
        let w1 = if alpha > 0.5 { (1.0 - alpha) / alpha } else { alpha / (1.0 - alpha) };
        let w2 = (w1 + xi) / S::lit(2.0 * w1 * xi + xi * xi + 1.0).simd_sqrt().value();
        in_front(p.z + S::lit(w2) * p.norm()) // eq. (43)
    }
    fn image(&self, p: &Vector3<S>) -> Vector2<S> {
        let k = self.xi * p.norm() + p.z;
        let d2 = (p.x * p.x + p.y * p.y + k * k).simd_sqrt();
        let scale = (self.alpha * d2 + (S::one() - self.alpha) * k).simd_recip();
        vector![self.focal[0] * p.x * scale + self.centre[0], self.focal[1] * p.y * scale + self.centre[1]]
    }
    fn image_over<T: Real>(camera: &DoubleSphere<T>, p: &Vector3<T>) -> SVector<T, 2> {
        camera.image(p)
    }
    fn image_jac(&self, p: &Vector3<S>) -> Imaged<S, 2, 6> {
        let (o, one) = (S::zero(), S::one());
        let ([fx, fy], alpha, beta) = (self.focal, self.alpha, one - self.alpha);
        let d1 = p.norm();
        let k = self.xi * d1 + p.z;
        let d2 = (p.x * p.x + p.y * p.y + k * k).simd_sqrt();
        let scale = (alpha * d2 + beta * k).simd_recip();
        let (x, y) = (p.x * scale, p.y * scale);
        let d_k = p * (self.xi / d1) + Vector3::z();
        let d_d2 = (vector![p.x, p.y, o] + d_k * k) / d2;
        let d_scale = -(d_d2 * alpha + d_k * beta) * scale; // of ln(1/D)
        let (d_xi, d_alpha) = (-(alpha * k / d2 + beta) * d1 * scale, -(d2 - k) * scale);
        #[rustfmt::skip]
        let d_p = SMatrix::<S, 2, 3>::new(
            fx * (scale + x * d_scale.x), fx * x * d_scale.y, fx * x * d_scale.z,
            fy * y * d_scale.x, fy * (scale + y * d_scale.y), fy * y * d_scale.z,
        );
        #[rustfmt::skip]
        let d_intrinsics = SMatrix::<S, 2, 6>::new(
            x, o, one, o, fx * x * d_xi, fx * x * d_alpha,
            o, y, o, one, fy * y * d_xi, fy * y * d_alpha,
        );
        (vector![fx * x + self.centre[0], fy * y + self.centre[1]], d_p, d_intrinsics)
    }
    fn unproject(&self, image: &Vector2<S>) -> Result<Vector3<S>, Unseen> {
        let (one, two, alpha, xi) = (S::one(), S::lit(2.0), self.alpha, self.xi);
        let [a, b] = [0, 1].map(|i| (image[i] - self.centre[i]) / self.focal[i]);
        let t = a * a + b * b;
        let inside = one - (two * alpha - one) * t; // eq. (51)
        let reach = |x: S| if x.value() >= 0.0 { Ok(x.simd_sqrt()) } else { Err(Unseen::OutOfView) };
        let z = (one - alpha * alpha * t) / (alpha * reach(inside)? + one - alpha);
        let c = (z * xi + reach(z * z + (one - xi * xi) * t)?) / (z * z + t);
        Ok(vector![c * a, c * b, c * z - xi])
    }
}
added_to!(DoubleSphere, 2, 6);
