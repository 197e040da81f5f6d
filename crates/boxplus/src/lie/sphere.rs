//! S²: directions, unit vectors of space: bearings, gravity, vanishing points, axes of symmetry.
//!
//! Two numbers move a direction, and no group does (S² is none): it is a [`Manifold`] on which SO(3) acts, transitively.
//! Steps are geodesics, τ ∈ ℝ² in radians in the tangent plane, which the columns of the 3×2 basis B(n) span:
//!
//! ```text
//! n ⊞ τ = cos|τ|·n + (sin|τ|/|τ|)·B(n)·τ        m ⊟ n = B(n)ᵀ·(φ × n),  φ = Log of the shortest rotation from n to m
//! B(n) = [1 − x²k, −xyk; −xyk, 1 − y²k; −x, −y],  k = 1/(1 + z): that of the shortest rotation from e_z to n
//! ∂(n ⊞ τ)/∂τ = Bᵧᵀ·(c₁·B − c₁·nτᵀ − (c₂ − c₃)·Bττᵀ)                    y = n ⊞ τ
//! ∂(n ⊞ τ)/∂n = Bᵧᵀ·(c₀·B + c₁·B[1]×τ·ωᵀ − c₁·nτᵀ),  ω = k·(y, −x)      ω·δ: how B turns about n along δ
//! ∂(m ⊟ n)/∂m = (1/c₁)·BᵀB_m − ((c₂ − c₃)/c₁²)·τ·nᵀB_m                  ∂/∂n = −∂/∂m·∂(n ⊞ τ)/∂n
//! ```
//! with c_k = c_k(|τ|²) of [`crate::lie::Stumpff`]. Hertzberg et al. (2013) use the same ⊞ with a basis that is not smooth.
//!
//! Pitfalls. *No basis is smooth everywhere* (one cannot comb a sphere): ours is, except at −e_z, around which it turns twice and
//! where it is ((−1, 0, 0), (0, 1, 0)). Two tangents at different directions are in different bases; compare them only
//! through the Jacobians. ⊟ is unique up to the antipode: for m = −n every τ of length π is right, ours is (π, 0), and
//! ∂(m ⊟ n) grows as 1/(π − |τ|).
//!
//! Accuracy: ⊞, ⊟ and all Jacobians within 6ε, `f32` and `f64`, in multiples of π/(π − |τ|) and of the rate 2/|n + e_z| at which
//! the basis turns (`tests/rotations`, against 50 digits).
//!
//! ```
//! use boxplus::lie::{Manifold, S2, SO3};
//! use nalgebra::{Vector2, Vector3};
//! let up: S2 = S2::from_vector(&Vector3::new(0.0, 0.0, 9.81))?;
//! let tilted = up.plus(&Vector2::new(0.1, 0.0)); // by 0.1 rad towards x
//! assert!((tilted.angle_to(&up) - 0.1).abs() < 1e-15);
//! assert!((tilted.vector() - Vector3::new(0.1_f64.sin(), 0.0, 0.1_f64.cos())).norm() < 1e-15);
//! let seen_from_body = SO3::about_y(-0.1) * tilted;
//! assert!(seen_from_body.minus(&up).norm() < 1e-15);
//! # Ok::<(), boxplus::lie::LieError>(())
//! ```

use super::rotation::unit;
use super::{Action, LieError, LieGroup, Manifold, Real, SO2, SO3, Stumpff};
use core::ops::{Mul, Neg};
use nalgebra::{Matrix2, SMatrix, Vector2, Vector3};

/// A direction in space: a unit vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct S2<S = f64> {
    n: Vector3<S>,
}

/// 2⁻⁶⁰, far below rounding of anything of size 1, and its square above the smallest `f32`: settles what else is 0/0.
const NUDGE: f64 = 1.0 / (1_u64 << 60) as f64;

impl<S: Real> S2<S> {
    /// The direction of `v`, of any length but 0.
    ///
    /// # Errors
    /// [`LieError::NotFinite`] or [`LieError::Zero`].
    pub fn from_vector(v: &Vector3<S>) -> Result<Self, LieError> {
        Ok(Self { n: unit(v)? })
    }

    /// The direction of a vector that is of unit length but for rounding.
    #[cfg(feature = "rand")]
    pub(super) fn from_unit(n: Vector3<S>) -> Self {
        Self { n: n / n.norm_squared().simd_sqrt() }
    }

    /// The unit vector n.
    #[inline]
    pub fn vector(&self) -> Vector3<S> {
        self.n
    }

    /// B(n), 3×2: orthonormal, perpendicular to n, with b₁ × b₂ = n; units of the tangent are radians along its columns.
    #[inline]
    pub fn basis(&self) -> SMatrix<S, 3, 2> {
        let (n, one, [x, k]) = (self.n, S::one(), self.stereographic());
        let (xk, yk) = (x * k, n.y * k);
        SMatrix::<S, 3, 2>::new(one - x * xk, -x * yk, -n.y * xk, one - n.y * yk, -n.x, -n.y)
    }

    /// The angle to another direction in radians, in \[0, π\], to the last digit: 2·atan2(|n − m|, |n + m|), Kahan (2006).
    #[inline]
    pub fn angle_to(&self, other: &Self) -> S {
        let (apart, sum) = (self.n - other.n, self.n + other.n);
        S::polar_angle(apart.norm_squared().simd_sqrt(), sum.norm_squared().simd_sqrt()) * S::lit(2.0)
    }

    /// The distance |n − m| through space, in \[0, 2\].
    #[inline]
    pub fn chordal_distance(&self, other: &Self) -> S {
        (self.n - other.n).norm_squared().simd_sqrt()
    }

    /// R·n, `self` seen in the parent frame: `(value, d_value_d_rotation, d_value_d_self)`, 2×3 right and 2×2.
    #[inline]
    pub fn rotated_by_jac(&self, rotation: &SO3<S>) -> (Self, SMatrix<S, 2, 3>, Matrix2<S>) {
        let value = *rotation * *self;
        let from_tangent = value.basis().transpose() * rotation.to_matrix();
        (value, from_tangent * SO3::generators_at(&self.n), from_tangent * self.basis())
    }

    /// The shortest rotation that takes this direction to `other`; see [`SO3::between_directions`] for opposite ones.
    ///
    /// # Errors
    /// None but those of directions with numbers that are not finite.
    pub fn rotation_to(&self, other: &Self) -> Result<SO3<S>, LieError> {
        SO3::between_directions(&self.n, &other.n)
    }

    /// x and k = 1/(1 + z). As |n| = 1, 1 + z = ½(x² + y² + (1 + z)²), which cancels nothing near −e_z; there x is nudged
    /// off 0, so that −e_z has a basis, too.
    #[inline]
    fn stereographic(&self) -> [S; 2] {
        let (n, above) = (self.n, self.n.z + S::one());
        let x = n.x + (S::one() - n.z) * S::lit(NUDGE);
        [x, S::lit(2.0) / (x * x + n.y * n.y + above * above)]
    }

    /// ∂(n ⊞ τ)/∂n into the tangent plane of `y` = n ⊞ τ.
    #[inline]
    fn d_plus_d_self(&self, y: &Self, tau: &Vector2<S>, c: &Stumpff<S>) -> Matrix2<S> {
        let (b, [x, k]) = (self.basis(), self.stereographic());
        let spin = Vector2::new(self.n.y * k, -x * k);
        let moved = b * c.c0 + (b * SO2::turn(tau) * spin.transpose() - self.n * tau.transpose()) * c.c1;
        y.basis().transpose() * moved
    }

    /// ∂(m ⊟ n)/∂m with m = `self`.
    #[inline]
    fn d_minus_d_self(&self, base: &Self, tau: &Vector2<S>, c: &Stumpff<S>) -> Matrix2<S> {
        let b = self.basis();
        let bend = (c.c2 - c.c3) / (c.c1 * c.c1);
        base.basis().transpose() * b / c.c1 - tau * (base.n.transpose() * b) * bend
    }
}

impl<S: Real> Manifold<2> for S2<S> {
    type Scalar = S;
    type Over<T: Real> = S2<T>;

    #[inline]
    fn plus(&self, tau: &Vector2<S>) -> Self {
        let c = Stumpff::new(tau.norm_squared());
        let n = self.n * c.c0 + self.basis() * tau * c.c1;
        // One Newton step towards unit length: the error of a step is squared instead of handed on.
        Self { n: n * (S::lit(1.5) - S::lit(0.5) * n.norm_squared()) }
    }
    #[inline]
    fn minus(&self, base: &Self) -> Vector2<S> {
        let (n, m, b) = (base.n, self.n, base.basis());
        let (apart, sum) = (m - n, m + n);
        // The quaternion (n × m, 1 + n·m), with n·m + 1 = ½|n + m|² and n × m = n × (m − n) free of cancellation. Opposite
        // directions leave nothing of it; there the nudge along b₂ makes τ = (π, 0).
        let nudge = b.column(1) * (apart.norm_squared() * S::lit(NUDGE));
        let q = SO3::from_unit(n.cross(&apart) + nudge, sum.norm_squared() * S::lit(0.5));
        b.transpose() * q.normalize().log().cross(&n)
    }
    #[inline]
    fn plus_jac(&self, tau: &Vector2<S>) -> (Self, Matrix2<S>, Matrix2<S>) {
        let (y, c, b) = (self.plus(tau), Stumpff::new(tau.norm_squared()), self.basis());
        let step = b * tau;
        let d_tau = b * c.c1 - (self.n * c.c1 + step * (c.c2 - c.c3)) * tau.transpose();
        (y, self.d_plus_d_self(&y, tau, &c), y.basis().transpose() * d_tau)
    }
    #[inline]
    fn minus_jac(&self, base: &Self) -> (Vector2<S>, Matrix2<S>, Matrix2<S>) {
        let tau = self.minus(base);
        let c = Stumpff::new(tau.norm_squared());
        let d_self = self.d_minus_d_self(base, &tau, &c);
        (tau, d_self, -d_self * base.d_plus_d_self(self, &tau, &c))
    }
    fn map<T: Real>(&self, f: impl Fn(S) -> T) -> S2<T> {
        S2 { n: self.n.map(f) }
    }
}

/// R·n.
impl<S: Real> Mul<S2<S>> for SO3<S> {
    type Output = S2<S>;
    #[inline]
    fn mul(self, direction: S2<S>) -> S2<S> {
        let n = self.act(&direction.n);
        S2 { n: n * (S::lit(1.5) - S::lit(0.5) * n.norm_squared()) }
    }
}

/// The antipode.
impl<S: Real> Neg for S2<S> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self { n: -self.n }
    }
}
