//! Points that may be at infinity.

use crate::lie::{Jacobian, Manifold, Real, Tangent};
use nalgebra::{Matrix3, Vector3, vector};

/// A point of space by homogeneous coordinates of unit norm, X = (v, w), which stand for the place v/w; with w = 0 it is at infinity, in the
/// direction v.
///
/// Where cameras see a point under hardly any parallax, its place along the rays is badly known and far from linear: each step of an
/// optimiser leads twice as far, and never to infinity, where the minimum may be. Here infinity is a place like any other, and a step may
/// pass through it, to where the rays meet behind the cameras. Hartley & Zisserman (2004), §2.2; Triggs et al. (2000), §2.1.
///
/// X and −X are one point. With the product of quaternions, X ⊞ τ is X·(τ, 1), to unit norm: the lines through X in ℝ⁴ are seen as on a
/// plane, and Y ⊟ X = τ where X⁻¹Y = s·(τ, 1), exactly its inverse.
///
/// ```
/// use boxplus::camera::Projective;
/// use boxplus::lie::Manifold;
/// use nalgebra::{Vector3, vector};
/// let near = Projective::new(&vector![1.0, 2.0, 4.0], 2.0); // of an extent of 2 m
/// assert!((near.place(2.0) - vector![1.0, 2.0, 4.0]).norm() < 1e-15);
/// let far: Projective = Projective { v: Vector3::x(), w: 0.0 };
/// assert!((near.plus(&far.minus(&near)).v - far.v).norm() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projective<S = f64> {
    /// The direction, times the sine of the angle from the origin.
    pub v: Vector3<S>,
    /// The cosine of that angle: 0 at infinity.
    pub w: S,
}

/// Points nearer to infinity have their place this many extents away.
const FARTHEST: f64 = 1e12;

impl<S: Real> Projective<S> {
    /// The point at `place`, in a world of a certain `extent`, which w stands for.
    pub fn new(place: &Vector3<S>, extent: S) -> Self {
        Self { v: *place, w: extent }.unit()
    }

    /// Its place, in the units of `extent`: at most 10¹² of it away. (Looked up by value: for single numbers.)
    pub fn place(&self, extent: S) -> Vector3<S> {
        let least = S::lit(1.0 / FARTHEST);
        let w = if self.w.value().abs() > least.value() { self.w } else { least };
        self.v * (extent / w)
    }

    fn unit(&self) -> Self {
        let scale = (self.v.norm_squared() + self.w * self.w).simd_sqrt().simd_recip();
        Self { v: self.v * scale, w: self.w * scale }
    }

    /// Derivatives of v and of w by the tangent: w·I + v^, and −vᵀ.
    #[inline]
    #[cfg(feature = "solve")]
    pub(crate) fn tangents(&self) -> (Matrix3<S>, Vector3<S>) {
        (Matrix3::from_diagonal_element(self.w) + self.v.cross_matrix(), -self.v)
    }
}

impl<S: Real> Manifold<3> for Projective<S> {
    type Scalar = S;
    type Over<T: Real> = Projective<T>;

    #[inline]
    fn plus(&self, tau: &Tangent<S, 3>) -> Self {
        let (v, w) = (self.v, self.w);
        Self { v: v + tau * w + v.cross(tau), w: w - v.dot(tau) }.unit()
    }
    fn minus(&self, base: &Self) -> Tangent<S, 3> {
        let across = self.v * base.w - base.v.cross(&self.v) - base.v * self.w;
        across / (base.v.dot(&self.v) + base.w * self.w)
    }
    fn plus_jac(&self, tau: &Tangent<S, 3>) -> (Self, Jacobian<S, 3>, Jacobian<S, 3>) {
        // (1 + τ)⁻¹·(1 + ε)·(1 + τ), and (1 + τ)⁻¹·δ, to first order.
        let (one, n2) = (S::one(), S::one() + tau.norm_squared());
        let hat = tau.cross_matrix();
        let d_self = Matrix3::from_diagonal_element((one + one - n2) / n2)
            + (tau * tau.transpose() - hat) * (S::lit(2.0) / n2);
        (self.plus(tau), d_self, (Matrix3::identity() - hat) / n2)
    }
    fn minus_jac(&self, base: &Self) -> (Tangent<S, 3>, Jacobian<S, 3>, Jacobian<S, 3>) {
        // Of (1 + τ)·(1 + δ), and of (1 − ε)·(1 + τ), to first order.
        let tau = self.minus(base);
        let (even, hat) = (Matrix3::identity() + tau * tau.transpose(), tau.cross_matrix());
        (tau, even + hat, hat - even)
    }
    fn map<T: Real>(&self, f: impl Fn(S) -> T) -> Projective<T> {
        Projective { v: vector![f(self.v.x), f(self.v.y), f(self.v.z)], w: f(self.w) }
    }
}
