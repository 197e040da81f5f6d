//! SE(3): rigid motions of space, X = \[R t; 0 1\], tangent (ρ, φ).
//!
//! ```text
//! Exp: R = Exp φ, t = J_l(φ)·ρ                   Log: φ = Log R, ρ = J_l(φ)⁻¹·t
//! Ad = [R, t^R; 0, R]                            ad = [φ^, ρ^; 0, φ^]
//! J_l = [J, Q; 0, J]                             J_l⁻¹ = [J⁻¹, Q̃; 0, J⁻¹],  J = J_l(φ)
//! Q = c₂ρ^ + c₃(φ^ρ^ + ρ^φ^) + (φ·ρ)(β₁φ^ + β₂φ^²)
//! Q̃ = −½ρ^ + d(φ^ρ^ + ρ^φ^) + (φ·ρ)e·φ^²        J_r(τ) = J_l(−τ), whose blocks are Jᵀ and Qᵀ
//! ```
//! Barfoot (2024) (8.91), Solà et al. (2018) (170)–(180). Q is the derivative of J_l(φ) along ρ, which gives the form above with
//! the coefficients of [`crate::lie::Stumpff`]; Q̃ = −J⁻¹QJ⁻¹ without the products.
//!
//! Pitfalls. J_r is *not* J_lᵀ (the coupling block stays upper right). Exp(ρ, φ) does not translate by ρ, see
//! [`SE3::new`]. Tangents are translation first; other libraries put the rotation first.
//!
//! ```
//! use boxplus::lie::{LieGroup, SE3, SO3};
//! use nalgebra::Vector3;
//! let turn = SO3::exp(&Vector3::new(0.0, 0.0, std::f64::consts::FRAC_PI_2));
//! let world_from_body = SE3::new(turn, Vector3::new(1.0, 2.0, 3.0));
//! let body_from_camera = SE3::new(SO3::identity(), Vector3::new(0.1, 0.0, 0.0));
//! let world_from_camera = world_from_body * body_from_camera;
//! assert!((world_from_camera.translation() - Vector3::new(1.0, 2.1, 3.0)).norm() < 1e-15);
//! ```

use super::so3::{check_affine, polynomial, skew};
use crate::lie::unrolled::{blocks, cross, transposed};
use crate::lie::{Action, LieError, LieGroup, Real, SO3, Stumpff};
use core::ops::Mul;
use nalgebra::{Matrix3, Matrix4, Matrix6, SMatrix, Vector3, Vector6};

/// A pose or rigid motion of space: rotation and translation.
#[derive(Clone, Copy)]
#[cfg_attr(feature = "bytemuck", derive(bytemuck::TransparentWrapper))]
#[repr(transparent)]
pub struct SE3<S = f64>(pub(in crate::lie) [S; 7]);

impl<S: Real> SE3<S> {
    /// The motion p ↦ `rotation`·p + `translation`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(rotation: SO3<S>, translation: Vector3<S>) -> Self {
        let ([x, y, z], [i, j, k, w]) = (translation.into(), rotation.0);
        Self([x, y, z, i, j, k, w])
    }

    /// The motion of a homogeneous 4×4 matrix.
    ///
    /// # Errors
    /// Those of [`SO3::from_matrix`], or [`LieError::NotHomogeneous`].
    pub fn from_matrix(m: &Matrix4<S>) -> Result<Self, LieError> {
        let rotation = SO3::from_matrix(&m.fixed_view::<3, 3>(0, 0).into_owned())?;
        check_affine([m.m14, m.m24, m.m34], [m.m41, m.m42, m.m43, m.m44 - S::one()])?;
        Ok(Self::new(rotation, Vector3::new(m.m14, m.m24, m.m34)))
    }

    /// R.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn rotation(&self) -> SO3<S> {
        let [_, _, _, x, y, z, w] = self.0;
        SO3([x, y, z, w])
    }

    /// t, in metres of the parent frame.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn translation(&self) -> Vector3<S> {
        let [x, y, z, ..] = self.0;
        Vector3::new(x, y, z)
    }

    /// The homogeneous 4×4 matrix \[R t; 0 1\].
    pub fn to_matrix(&self) -> Matrix4<S> {
        let mut m = self.rotation().to_matrix().to_homogeneous();
        m.fixed_view_mut::<3, 1>(0, 3).copy_from(&self.translation());
        m
    }

    /// The same motion with the rotation at unit norm to the last digit.
    pub fn normalize(&self) -> Self {
        Self::new(self.rotation().normalize(), self.translation())
    }
}

/// (ρ, φ).
#[cfg_attr(not(debug_assertions), inline(always))]
fn split<S: Real>(tau: &Vector6<S>) -> (Vector3<S>, Vector3<S>) {
    (Vector3::new(tau[0], tau[1], tau[2]), Vector3::new(tau[3], tau[4], tau[5]))
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn join<S: Real>(rho: &Vector3<S>, phi: &Vector3<S>) -> Vector6<S> {
    Vector6::new(rho.x, rho.y, rho.z, phi.x, phi.y, phi.z)
}

/// The 6×6 matrix \[a b; 0 a\].
#[cfg_attr(not(debug_assertions), inline(always))]
fn block<S: Real>(a: &Matrix3<S>, b: &Matrix3<S>) -> Matrix6<S> {
    blocks([[a, b], [&Matrix3::zeros(), a]])
}

/// s^ + a·(φ^ρ^ + ρ^φ^) + b·φ^², the form of Q and Q̃, with u^v^ = v·uᵀ − (u·v)·I.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn coupling<S: Real>(
    s: &Vector3<S>,
    a: S,
    b: S,
    rho: &Vector3<S>,
    phi: &Vector3<S>,
) -> Matrix3<S> {
    let (r, u) = (rho * a, phi * b);
    let w = r + r + u; // entries of the symmetric part are a(ρᵢφⱼ + φᵢρⱼ) + bφᵢφⱼ; on the diagonal w_iφ_i
    let (xx, yy, zz) = (w.x * phi.x, w.y * phi.y, w.z * phi.z);
    let xy = r.x * phi.y + (r.y + u.y) * phi.x;
    let yz = r.y * phi.z + (r.z + u.z) * phi.y;
    let zx = r.z * phi.x + (r.x + u.x) * phi.z;
    Matrix3::new(
        -(yy + zz),
        xy - s.z,
        zx + s.y,
        xy + s.z,
        -(xx + zz),
        yz - s.x,
        zx - s.y,
        yz + s.x,
        -(xx + yy),
    )
}

/// The block Q of J_r, the transpose of that of J_l, given c_k(|φ|²).
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn right_coupling<S: Real>(rho: &Vector3<S>, phi: &Vector3<S>, c: &Stumpff<S>) -> Matrix3<S> {
    let dot = phi.dot(rho);
    let s = -(rho * c.c2 + phi * (dot * c.beta1()));
    coupling(&s, c.c3, dot * c.beta2(), rho, phi)
}

/// The block Q̃ of J_r⁻¹, the transpose of that of J_l⁻¹, given d and e at |φ|².
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn right_coupling_inverse<S: Real>(rho: &Vector3<S>, phi: &Vector3<S>, d: S, e: S) -> Matrix3<S> {
    coupling(&(rho * S::lit(0.5)), d, phi.dot(rho) * e, rho, phi)
}

/// (J_r⁻¹, J_l⁻¹) of (ρ, φ), given d and e at |φ|².
#[cfg_attr(not(debug_assertions), inline(always))]
fn inverses<S: Real>(rho: &Vector3<S>, phi: &Vector3<S>, d: S, e: S) -> (Matrix6<S>, Matrix6<S>) {
    let j = polynomial(phi, S::lit(0.5), d);
    let q = right_coupling_inverse(rho, phi, d, e);
    (block(&j, &q), block(&transposed(&j), &transposed(&q)))
}

impl<S: Real> PartialEq for SE3<S> {
    fn eq(&self, other: &Self) -> bool {
        self.rotation() == other.rotation() && self.translation() == other.translation()
    }
}

impl<S: Real> LieGroup<6> for SE3<S> {
    type Scalar = S;
    type Over<T: Real> = SE3<T>;
    type Algebra = Matrix4<S>;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn identity() -> Self {
        Self::new(SO3::identity(), Vector3::zeros())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn compose(&self, rhs: &Self) -> Self {
        Self::new(self.rotation().compose(&rhs.rotation()), self.act(&rhs.translation()))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn inverse(&self) -> Self {
        let rotation = self.rotation().inverse();
        Self::new(rotation, -rotation.act(&self.translation()))
    }
    /// Subtracts the translations first: the error is relative to their difference, however far from the origin.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn between(&self, other: &Self) -> Self {
        let inverse = self.rotation().inverse();
        let step = inverse.act(&(other.translation() - self.translation()));
        Self::new(inverse.compose(&other.rotation()), step)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn exp(tau: &Vector6<S>) -> Self {
        let (rho, phi) = split(tau);
        let (rotation, half) = SO3::exp_half(&phi);
        Self::new(rotation, turn(&phi, &half, &rho))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn log(&self) -> Vector6<S> {
        let phi = self.rotation().log();
        let d = Stumpff::new(phi.norm_squared()).d();
        join(&unturn(&phi, d, &self.translation()), &phi)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn adjoint(&self) -> Matrix6<S> {
        let r = self.rotation().to_matrix();
        block(&r, &cross(&self.translation(), &r))
    }
    /// (R·ρ + t × R·φ, R·φ).
    #[inline]
    fn adjoint_times(&self, tau: &Vector6<S>) -> Vector6<S> {
        let ((rho, phi), r) = (split(tau), self.rotation());
        let turned = r.act(&phi);
        join(&(r.act(&rho) + self.translation().cross(&turned)), &turned)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn small_adjoint(tau: &Vector6<S>) -> Matrix6<S> {
        let (rho, phi) = split(tau);
        block(&skew(&phi), &skew(&rho))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn right_jacobian(tau: &Vector6<S>) -> Matrix6<S> {
        let (rho, phi) = split(tau);
        let c = Stumpff::new(phi.norm_squared());
        block(&polynomial(&phi, -c.c2, c.c3), &right_coupling(&rho, &phi, &c))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn right_jacobian_inverse(tau: &Vector6<S>) -> Matrix6<S> {
        let (rho, phi) = split(tau);
        let c = Stumpff::new(phi.norm_squared());
        inverses(&rho, &phi, c.d(), c.e()).0
    }
    #[inline]
    fn right_jacobian_derivative(tau: &Vector6<S>, delta: &Vector6<S>) -> Matrix6<S> {
        let ((rho, phi), (d_rho, d_phi)) = (split(tau), split(delta));
        let c = Stumpff::new(phi.norm_squared());
        let turning = right_coupling(&d_phi, &phi, &c);
        block(&turning, &super::second::coupling([&rho, &phi], [&d_rho, &d_phi], &c))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn log_jacs(&self) -> (Vector6<S>, Matrix6<S>, Matrix6<S>) {
        let phi = self.rotation().log();
        let c = Stumpff::new(phi.norm_squared());
        let d = c.d();
        let rho = unturn(&phi, d, &self.translation());
        let (right, left) = inverses(&rho, &phi, d, c.e());
        (join(&rho, &phi), right, left)
    }
    fn hat(tau: &Vector6<S>) -> Matrix4<S> {
        let (rho, phi) = split(tau);
        let mut m = Matrix4::zeros();
        m.fixed_view_mut::<3, 3>(0, 0).copy_from(&skew(&phi));
        m.fixed_view_mut::<3, 1>(0, 3).copy_from(&rho);
        m
    }
    fn vee(algebra: &Matrix4<S>) -> Vector6<S> {
        Vector6::new(algebra.m14, algebra.m24, algebra.m34, algebra.m32, algebra.m13, algebra.m21)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn map<T: Real>(&self, f: impl Fn(S) -> T) -> SE3<T> {
        let [x, y, z, i, j, k, w] = self.0;
        SE3([f(x), f(y), f(z), f(i), f(j), f(k), f(w)])
    }
}

/// J_l(φ)·ρ = ρ + c₂φ×ρ + c₃φ×(φ×ρ), given the Stumpff functions at |φ|²/4.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn turn<S: Real>(phi: &Vector3<S>, half: &Stumpff<S>, rho: &Vector3<S>) -> Vector3<S> {
    // From θ/2 to θ without cancellation: c₂(4y) = ½c₁(y)², c₃(4y) = ¼(c₃(y) + c₁(y)c₂(y)).
    let c2 = half.c1 * half.c1 * S::lit(0.5);
    let c3 = (half.c3 + half.c1 * half.c2) * S::lit(0.25);
    let turned = phi.cross(rho);
    rho + turned * c2 + phi.cross(&turned) * c3
}

/// J_l(φ)⁻¹·t = t − ½φ×t + d·φ×(φ×t).
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn unturn<S: Real>(phi: &Vector3<S>, d: S, t: &Vector3<S>) -> Vector3<S> {
    let turned = phi.cross(t);
    t - turned * S::lit(0.5) + phi.cross(&turned) * d
}

impl<S: Real> Action<6, 3> for SE3<S> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn act(&self, p: &Vector3<S>) -> Vector3<S> {
        self.rotation().act(p) + self.translation()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn linear_part(&self) -> Matrix3<S> {
        self.rotation().to_matrix()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn generators_at(p: &Vector3<S>) -> SMatrix<S, 3, 6> {
        let mut g = SMatrix::<S, 3, 6>::zeros();
        g.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
        g.fixed_view_mut::<3, 3>(0, 3).copy_from(&-skew(p));
        g
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn act_direction(&self, d: &Vector3<S>) -> Vector3<S> {
        self.rotation().act(d)
    }
}

impl<S: Real> Mul for SE3<S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, rhs: Self) -> Self {
        self.compose(&rhs)
    }
}

impl<S: Real> Mul<Vector3<S>> for SE3<S> {
    type Output = Vector3<S>;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, p: Vector3<S>) -> Vector3<S> {
        self.act(&p)
    }
}
