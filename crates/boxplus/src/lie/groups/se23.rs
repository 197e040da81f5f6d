//! SE₂(3): extended poses, X = \[R v p; 0 1 0; 0 0 1\], rotation, velocity and position, tangent (ρ, φ, ν).
//!
//! ```text
//! Exp: R = Exp φ, p = J·ρ, v = J·ν               Log: φ = Log R, ρ = J⁻¹·p, ν = J⁻¹·v          J = J_l(φ)
//! Ad = [R, p^R, 0; 0, R, 0; 0, v^R, R]           ad = [φ^, ρ^, 0; 0, φ^, 0; 0, ν^, φ^]
//! J_l = [J, Q(ρ), 0; 0, J, 0; 0, Q(ν), J]        J_l⁻¹ = [J⁻¹, Q̃(ρ), 0; 0, J⁻¹, 0; 0, Q̃(ν), J⁻¹]
//! ```
//! Barrau and Bonnabel (2017), Brossard et al. (2022); Q and Q̃ are those of SE(3), Barfoot (2024) (8.91). Two copies of SE(3)
//! share one rotation: position and pose are SE(3) to the last bit, and so are velocity and its Jacobians.
//!
//! The state of inertial navigation: on this group the error of dead reckoning obeys a linear equation that does not depend on
//! the state, which invariant filters live on.
//!
//! Pitfalls. X·Y is no motion in time: velocities add as positions do, and p does not grow by v·t; the group with a clock
//! is [`crate::lie::SGal3`]. A point is moved by the pose alone, the velocity columns of its Jacobian are zero. The matrix holds v
//! before p, the tangent ρ before ν; Barrau and Brossard order it (φ, ν, ρ).
//!
//! ```
//! use boxplus::lie::{LieGroup, SE23, SO3};
//! use nalgebra::Vector3;
//! let turn = SO3::exp(&Vector3::new(0.0, 0.0, std::f64::consts::FRAC_PI_2));
//! let world_from_body = SE23::new(turn, Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.5, 0.0, 0.0));
//! let seen = world_from_body * Vector3::new(1.0, 0.0, 0.0); // a point 1 m ahead
//! assert!((seen - Vector3::new(1.0, 3.0, 3.0)).norm() < 1e-15);
//! let v_body = world_from_body.rotation().inverse() * world_from_body.velocity();
//! assert!((v_body - Vector3::new(0.0, -0.5, 0.0)).norm() < 1e-15);
//! ```

use super::se3::{right_coupling, right_coupling_inverse, turn, unturn};
use super::so3::{check_affine, polynomial, skew};
use crate::lie::unrolled::{blocks, cross, transposed};
use crate::lie::{Action, LieError, LieGroup, Real, SE3, SO3, Stumpff};
use core::ops::Mul;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// An extended pose: rotation, position and velocity.
#[derive(Clone, Copy)]
#[cfg_attr(feature = "bytemuck", derive(bytemuck::TransparentWrapper))]
#[repr(transparent)]
pub struct SE23<S = f64>(pub(in crate::lie) [S; 10]);

impl<S: Real> SE23<S> {
    /// The extended pose of `rotation`, `position` in m and `velocity` in m/s, both in the parent frame.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(rotation: SO3<S>, position: Vector3<S>, velocity: Vector3<S>) -> Self {
        Self::from_pose(SE3::new(rotation, position), velocity)
    }

    /// `pose`, moving at `velocity` in m/s of the parent frame.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn from_pose(pose: SE3<S>, velocity: Vector3<S>) -> Self {
        let ([x, y, z, i, j, k, w], [a, b, c]) = (pose.0, velocity.into());
        Self([x, y, z, i, j, k, w, a, b, c])
    }

    /// The extended pose of a 5×5 matrix \[R v p; 0 1 0; 0 0 1\].
    ///
    /// # Errors
    /// Those of [`SO3::from_matrix`], or [`LieError::NotHomogeneous`].
    pub fn from_matrix(m: &SMatrix<S, 5, 5>) -> Result<Self, LieError> {
        let rotation = SO3::from_matrix(&m.fixed_view::<3, 3>(0, 0).into_owned())?;
        let (velocity, position) = columns(m);
        let (v, p, last) = (velocity, position, m.fixed_rows::<2>(3));
        let below =
            core::array::from_fn::<_, 10, _>(|i| last[i] - S::lit(if i == 6 || i == 9 { 1.0 } else { 0.0 }));
        check_affine([v.x, v.y, v.z, p.x, p.y, p.z], below)?;
        Ok(Self::new(rotation, position, velocity))
    }

    /// R.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn rotation(&self) -> SO3<S> {
        self.pose().rotation()
    }

    /// p, in metres of the parent frame.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn position(&self) -> Vector3<S> {
        self.pose().translation()
    }

    /// v, in m/s of the parent frame.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn velocity(&self) -> Vector3<S> {
        let [.., x, y, z] = self.0;
        Vector3::new(x, y, z)
    }

    /// (R, p), the pose without its velocity.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn pose(&self) -> SE3<S> {
        let [x, y, z, i, j, k, w, ..] = self.0;
        SE3([x, y, z, i, j, k, w])
    }

    /// The 5×5 matrix \[R v p; 0 1 0; 0 0 1\].
    pub fn to_matrix(&self) -> SMatrix<S, 5, 5> {
        let mut m = SMatrix::<S, 5, 5>::identity();
        m.fixed_view_mut::<3, 3>(0, 0).copy_from(&self.rotation().to_matrix());
        m.fixed_view_mut::<3, 1>(0, 3).copy_from(&self.velocity());
        m.fixed_view_mut::<3, 1>(0, 4).copy_from(&self.position());
        m
    }

    /// The same extended pose with the rotation at unit norm to the last digit.
    pub fn normalize(&self) -> Self {
        Self::from_pose(self.pose().normalize(), self.velocity())
    }
}

/// The columns v and p of a 5×5 matrix.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn columns<S: Real>(m: &SMatrix<S, 5, 5>) -> (Vector3<S>, Vector3<S>) {
    (m.fixed_view::<3, 1>(0, 3).into_owned(), m.fixed_view::<3, 1>(0, 4).into_owned())
}

/// The first 3K coordinates of a tangent as vectors: ρ, φ, ….
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn split<S: Real, const D: usize, const K: usize>(tau: &SVector<S, D>) -> [Vector3<S>; K] {
    core::array::from_fn(|k| Vector3::new(tau[3 * k], tau[3 * k + 1], tau[3 * k + 2]))
}

/// The 9×9 matrix \[a b 0; 0 a 0; 0 c a\].
#[cfg_attr(not(debug_assertions), inline(always))]
fn block<S: Real>(a: &Matrix3<S>, b: &Matrix3<S>, c: &Matrix3<S>) -> SMatrix<S, 9, 9> {
    let o = &Matrix3::zeros();
    blocks([[a, b, o], [o, a, o], [o, c, a]])
}

/// (J_r⁻¹, J_l⁻¹) of (ρ, φ, ν), given d and e at |φ|².
#[cfg_attr(not(debug_assertions), inline(always))]
fn inverses<S: Real>([rho, phi, nu]: &[Vector3<S>; 3], d: S, e: S) -> (SMatrix<S, 9, 9>, SMatrix<S, 9, 9>) {
    let j = polynomial(phi, S::lit(0.5), d);
    let coupling = |v| right_coupling_inverse(v, phi, d, e);
    let (q, r) = (coupling(rho), coupling(nu));
    (block(&j, &q, &r), block(&transposed(&j), &transposed(&q), &transposed(&r)))
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn join<S: Real>([rho, phi, nu]: &[Vector3<S>; 3]) -> SVector<S, 9> {
    SVector::from([rho.x, rho.y, rho.z, phi.x, phi.y, phi.z, nu.x, nu.y, nu.z])
}

impl<S: Real> PartialEq for SE23<S> {
    fn eq(&self, other: &Self) -> bool {
        self.pose() == other.pose() && self.velocity() == other.velocity()
    }
}

impl<S: Real> LieGroup<9> for SE23<S> {
    type Scalar = S;
    type Over<T: Real> = SE23<T>;
    type Algebra = SMatrix<S, 5, 5>;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn identity() -> Self {
        Self::from_pose(SE3::identity(), Vector3::zeros())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn compose(&self, rhs: &Self) -> Self {
        Self::from_pose(
            self.pose().compose(&rhs.pose()),
            self.rotation().act(&rhs.velocity()) + self.velocity(),
        )
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn inverse(&self) -> Self {
        let pose = self.pose().inverse();
        Self::from_pose(pose, -pose.rotation().act(&self.velocity()))
    }
    /// Subtracts positions and velocities first: the error is relative to their difference.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn between(&self, other: &Self) -> Self {
        let step = self.rotation().inverse().act(&(other.velocity() - self.velocity()));
        Self::from_pose(self.pose().between(&other.pose()), step)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn exp(tau: &SVector<S, 9>) -> Self {
        let [rho, phi, nu] = split(tau);
        let (rotation, half) = SO3::exp_half(&phi);
        Self::new(rotation, turn(&phi, &half, &rho), turn(&phi, &half, &nu))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn log(&self) -> SVector<S, 9> {
        let phi = self.rotation().log();
        let d = Stumpff::new(phi.norm_squared()).d();
        join(&[unturn(&phi, d, &self.position()), phi, unturn(&phi, d, &self.velocity())])
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn adjoint(&self) -> SMatrix<S, 9, 9> {
        let r = self.rotation().to_matrix();
        block(&r, &cross(&self.position(), &r), &cross(&self.velocity(), &r))
    }
    /// (R·ρ + p × R·φ, R·φ, R·ν + v × R·φ).
    #[inline]
    fn adjoint_times(&self, tau: &SVector<S, 9>) -> SVector<S, 9> {
        let [rho, phi, nu] = split(tau).map(|v| self.rotation().act(&v));
        join(&[rho + self.position().cross(&phi), phi, nu + self.velocity().cross(&phi)])
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn small_adjoint(tau: &SVector<S, 9>) -> SMatrix<S, 9, 9> {
        let [rho, phi, nu] = split(tau);
        block(&skew(&phi), &skew(&rho), &skew(&nu))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn right_jacobian(tau: &SVector<S, 9>) -> SMatrix<S, 9, 9> {
        let [rho, phi, nu] = split(tau);
        let c = Stumpff::new(phi.norm_squared());
        let coupling = |v| right_coupling(v, &phi, &c);
        block(&polynomial(&phi, -c.c2, c.c3), &coupling(&rho), &coupling(&nu))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn right_jacobian_inverse(tau: &SVector<S, 9>) -> SMatrix<S, 9, 9> {
        let parts = split(tau);
        let c = Stumpff::new(parts[1].norm_squared());
        inverses(&parts, c.d(), c.e()).0
    }
    #[inline]
    fn right_jacobian_derivative(tau: &SVector<S, 9>, delta: &SVector<S, 9>) -> SMatrix<S, 9, 9> {
        let ([rho, phi, nu], [d_rho, d_phi, d_nu]) = (split(tau), split(delta));
        let c = Stumpff::new(phi.norm_squared());
        let [q, r] =
            [(rho, d_rho), (nu, d_nu)].map(|(v, d)| super::second::coupling([&v, &phi], [&d, &d_phi], &c));
        block(&right_coupling(&d_phi, &phi, &c), &q, &r)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn log_jacs(&self) -> (SVector<S, 9>, SMatrix<S, 9, 9>, SMatrix<S, 9, 9>) {
        let phi = self.rotation().log();
        let c = Stumpff::new(phi.norm_squared());
        let d = c.d();
        let parts = [unturn(&phi, d, &self.position()), phi, unturn(&phi, d, &self.velocity())];
        let (right, left) = inverses(&parts, d, c.e());
        (join(&parts), right, left)
    }
    fn hat(tau: &SVector<S, 9>) -> SMatrix<S, 5, 5> {
        let [rho, phi, nu] = split(tau);
        let mut m = SMatrix::<S, 5, 5>::zeros();
        m.fixed_view_mut::<3, 3>(0, 0).copy_from(&skew(&phi));
        m.fixed_view_mut::<3, 1>(0, 3).copy_from(&nu);
        m.fixed_view_mut::<3, 1>(0, 4).copy_from(&rho);
        m
    }
    fn vee(algebra: &SMatrix<S, 5, 5>) -> SVector<S, 9> {
        let (nu, rho) = columns(algebra);
        join(&[rho, SO3::vee(&algebra.fixed_view::<3, 3>(0, 0).into_owned()), nu])
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn map<T: Real>(&self, f: impl Fn(S) -> T) -> SE23<T> {
        let [x, y, z, i, j, k, w, u, v, s] = self.0;
        SE23([f(x), f(y), f(z), f(i), f(j), f(k), f(w), f(u), f(v), f(s)])
    }
}

/// A point is moved by the pose.
impl<S: Real> Action<9, 3> for SE23<S> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn act(&self, p: &Vector3<S>) -> Vector3<S> {
        self.pose().act(p)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn linear_part(&self) -> Matrix3<S> {
        self.rotation().to_matrix()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn generators_at(p: &Vector3<S>) -> SMatrix<S, 3, 9> {
        let mut g = SMatrix::<S, 3, 9>::zeros();
        g.fixed_view_mut::<3, 6>(0, 0).copy_from(&SE3::generators_at(p));
        g
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn act_direction(&self, d: &Vector3<S>) -> Vector3<S> {
        self.rotation().act(d)
    }
}

impl<S: Real> Mul for SE23<S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, rhs: Self) -> Self {
        self.compose(&rhs)
    }
}

impl<S: Real> Mul<Vector3<S>> for SE23<S> {
    type Output = Vector3<S>;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, p: Vector3<S>) -> Vector3<S> {
        self.act(&p)
    }
}
