//! SE(2): rigid motions of the plane, X = \[R t; 0 1\], tangent (ρ₁, ρ₂, θ).
//!
//! ```text
//! Exp: t = M(θ)ρ,  M = c₁·I + θc₂·[1]×      Log: ρ = M⁻¹t,  M⁻¹ = (1 − θ²d)·I − (θ/2)·[1]×
//! Ad = [R, −[1]×t; 0, 1]                    ad = [θ[1]×, −[1]×ρ; 0, 0]
//! J_l = [M, q; 0, 1],  q = (θc₃ρ₁ + c₂ρ₂, θc₃ρ₂ − c₂ρ₁)
//! J_l⁻¹ = [M⁻¹, q̃; 0, 1],  q̃ = (θdρ₁ − ½ρ₂, θdρ₂ + ½ρ₁)        J_r(τ) = J_l(−τ)
//! ```
//! Solà et al. (2018) (152)–(168), with the coefficients of [`crate::lie::Stumpff`]; q̃ = −M⁻¹q without the product.
//!
//! Pitfall: Exp(ρ, θ) does not translate by ρ: ρ is a constant velocity in the turning body frame. For a pose with
//! translation t and angle θ use [`SE2::new`].
//!
//! ```
//! use boxplus::lie::{LieGroup, SE2};
//! use nalgebra::{Vector2, Vector3};
//! let quarter_circle = SE2::exp(&Vector3::new(std::f64::consts::FRAC_PI_2, 0.0, std::f64::consts::FRAC_PI_2));
//! assert!((quarter_circle.translation() - Vector2::new(1.0, 1.0)).norm() < 1e-15);
//! ```

use crate::lie::{Action, LieError, LieGroup, Real, SO2, Stumpff};
use core::ops::Mul;
use nalgebra::{Matrix2, Matrix3, SMatrix, Vector2, Vector3};

/// A pose or rigid motion of the plane: rotation and translation.
#[derive(Clone, Copy, PartialEq)]
#[cfg_attr(feature = "bytemuck", derive(bytemuck::TransparentWrapper))]
#[repr(transparent)]
pub struct SE2<S = f64>(pub(in crate::lie) [S; 4]);

impl<S: Real> SE2<S> {
    /// The motion p ↦ R(`angle`)·p + `translation`.
    pub fn new(translation: Vector2<S>, angle: S) -> Self {
        Self::from_parts(translation, SO2::from_angle(angle))
    }

    /// The motion p ↦ `rotation`·p + `translation`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn from_parts(translation: Vector2<S>, rotation: SO2<S>) -> Self {
        let [[x, y], [cos, sin]] = [translation.into(), rotation.0];
        Self([x, y, cos, sin])
    }

    /// The motion of a homogeneous 3×3 matrix.
    ///
    /// # Errors
    /// Those of [`SO2::from_matrix`], or [`LieError::NotHomogeneous`].
    pub fn from_matrix(m: &Matrix3<S>) -> Result<Self, LieError> {
        let rotation = SO2::from_matrix(&m.fixed_view::<2, 2>(0, 0).into_owned())?;
        super::so3::check_affine([m.m13, m.m23], [m.m31, m.m32, m.m33 - S::one()])?;
        Ok(Self::from_parts(Vector2::new(m.m13, m.m23), rotation))
    }

    /// R.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn rotation(&self) -> SO2<S> {
        SO2([self.0[2], self.0[3]])
    }

    /// t, in metres of the parent frame.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn translation(&self) -> Vector2<S> {
        Vector2::new(self.0[0], self.0[1])
    }

    /// The heading in radians, in [−π, π].
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn angle(&self) -> S {
        self.rotation().angle()
    }

    /// The homogeneous 3×3 matrix \[R t; 0 1\].
    pub fn to_matrix(&self) -> Matrix3<S> {
        block(&self.rotation().to_matrix(), &self.translation(), S::one())
    }

    /// The same motion with the rotation at unit norm to the last digit.
    pub fn normalize(&self) -> Self {
        Self::from_parts(self.translation(), self.rotation().normalize())
    }
}

/// The 3×3 matrix \[a b; 0 c\].
#[cfg_attr(not(debug_assertions), inline(always))]
fn block<S: Real>(a: &Matrix2<S>, b: &Vector2<S>, c: S) -> Matrix3<S> {
    let o = S::zero();
    Matrix3::new(a.m11, a.m12, b.x, a.m21, a.m22, b.y, o, o, c)
}

/// The 2×2 matrix a·I + b·\[1\]×.
#[cfg_attr(not(debug_assertions), inline(always))]
fn complex<S: Real>(a: S, b: S) -> Matrix2<S> {
    Matrix2::new(a, -b, b, a)
}

/// \[a·I + b·\[1\]×, p·ρ + q·\[1\]×ρ; 0, 1\]: the form of every Jacobian of Exp and Log.
#[cfg_attr(not(debug_assertions), inline(always))]
fn jacobian<S: Real>(rho: &Vector2<S>, [a, b]: [S; 2], [p, q]: [S; 2]) -> Matrix3<S> {
    block(&complex(a, b), &(rho * p + SO2::turn(rho) * q), S::one())
}

impl<S: Real> LieGroup<3> for SE2<S> {
    type Scalar = S;
    type Over<T: Real> = SE2<T>;
    type Algebra = Matrix3<S>;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn identity() -> Self {
        Self::from_parts(Vector2::zeros(), SO2::identity())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn compose(&self, rhs: &Self) -> Self {
        Self::from_parts(self.act(&rhs.translation()), self.rotation().compose(&rhs.rotation()))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn inverse(&self) -> Self {
        let rotation = self.rotation().inverse();
        Self::from_parts(-rotation.act(&self.translation()), rotation)
    }
    /// Subtracts the translations first: the error is relative to their difference, however far from the origin.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn between(&self, other: &Self) -> Self {
        let inverse = self.rotation().inverse();
        let step = inverse.act(&(other.translation() - self.translation()));
        Self::from_parts(step, inverse.compose(&other.rotation()))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn exp(tau: &Vector3<S>) -> Self {
        let (rho, theta) = (tau.xy(), tau.z);
        // From θ/2 to θ: c₁(4y) = c₀(y)c₁(y), c₂(4y) = ½c₁(y)².
        let half = Stumpff::half(theta * theta * S::lit(0.25));
        let translation = (rho * half.c0 + SO2::turn(&rho) * (theta * half.c1 * S::lit(0.5))) * half.c1;
        Self::from_parts(translation, SO2::from_angle(theta))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn log(&self) -> Vector3<S> {
        let theta = self.angle();
        let x = theta * theta;
        let h = S::one() - x * Stumpff::new(x).d();
        let rho = self.translation() * h - SO2::turn(&self.translation()) * (theta * S::lit(0.5));
        Vector3::new(rho.x, rho.y, theta)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn adjoint(&self) -> Matrix3<S> {
        block(&self.rotation().to_matrix(), &-SO2::turn(&self.translation()), S::one())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn small_adjoint(tau: &Vector3<S>) -> Matrix3<S> {
        block(&complex(S::zero(), tau.z), &-SO2::turn(&tau.xy()), S::zero())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn right_jacobian(tau: &Vector3<S>) -> Matrix3<S> {
        let (rho, theta, c) = split(tau);
        jacobian(&rho, [c.c1, -theta * c.c2], [theta * c.c3, c.c2])
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn right_jacobian_inverse(tau: &Vector3<S>) -> Matrix3<S> {
        let (rho, theta, c) = split(tau);
        let (d, half) = (c.d(), S::lit(0.5));
        jacobian(&rho, [S::one() - theta * theta * d, theta * half], [theta * d, -half])
    }
    #[inline]
    fn right_jacobian_derivative(tau: &Vector3<S>, delta: &Vector3<S>) -> Matrix3<S> {
        super::second::se2(tau, delta, &Stumpff::new(tau.z * tau.z))
    }
    fn hat(tau: &Vector3<S>) -> Matrix3<S> {
        block(&complex(S::zero(), tau.z), &tau.xy(), S::zero())
    }
    fn vee(algebra: &Matrix3<S>) -> Vector3<S> {
        Vector3::new(algebra.m13, algebra.m23, algebra.m21)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn map<T: Real>(&self, f: impl Fn(S) -> T) -> SE2<T> {
        let [x, y, cos, sin] = self.0;
        SE2([f(x), f(y), f(cos), f(sin)])
    }
}

/// (ρ, θ, c_k(θ²)).
#[cfg_attr(not(debug_assertions), inline(always))]
fn split<S: Real>(tau: &Vector3<S>) -> (Vector2<S>, S, Stumpff<S>) {
    (tau.xy(), tau.z, Stumpff::new(tau.z * tau.z))
}

impl<S: Real> Action<3, 2> for SE2<S> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn act(&self, p: &Vector2<S>) -> Vector2<S> {
        self.rotation().act(p) + self.translation()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn linear_part(&self) -> Matrix2<S> {
        self.rotation().to_matrix()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn generators_at(p: &Vector2<S>) -> SMatrix<S, 2, 3> {
        let (i, o) = (S::one(), S::zero());
        SMatrix::<S, 2, 3>::new(i, o, -p.y, o, i, p.x)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn act_direction(&self, d: &Vector2<S>) -> Vector2<S> {
        self.rotation().act(d)
    }
}

impl<S: Real> Mul for SE2<S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, rhs: Self) -> Self {
        self.compose(&rhs)
    }
}

impl<S: Real> Mul<Vector2<S>> for SE2<S> {
    type Output = Vector2<S>;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, p: Vector2<S>) -> Vector2<S> {
        self.act(&p)
    }
}
