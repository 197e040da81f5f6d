//! SGal(3): the Galilean group, X = \[R v p; 0 1 t; 0 0 1\], changes of inertial frame with their clocks, tangent (ρ, φ, ν, ι).
//!
//! ```text
//! X₁X₂ = (R₁R₂, p₁ + R₁p₂ + v₁t₂, v₁ + R₁v₂, t₁ + t₂)
//! Exp: R = Exp φ, v = Jν, p = Jρ + ι·Γ₂ν, t = ι           Log: ν = J⁻¹v, ρ = J⁻¹p − ι(½ν − d·φ×ν)
//! Ad = [R, (p−vt)^R, −tR, v; 0, R, 0, 0; 0, v^R, R, 0; 0, 0, 0, 1]
//! ad = [φ^, ρ^, −ιI, ν; 0, φ^, 0, 0; 0, ν^, φ^, 0; 0, 0, 0, 0]
//! J_l   = [J, Q(ρ) − ιU, −ι(J − Γ₂), Γ₂ν; 0, J, 0, 0; 0, Q(ν), J, 0; 0, 0, 0, 1]
//! J_l⁻¹ = [J⁻¹, Q̃(ρ) + ιŨ, ι(½I − 2r·φ^), −½ν + d·φ×ν; 0, J⁻¹, 0, 0; 0, Q̃(ν), J⁻¹, 0; 0, 0, 0, 1]
//! U = Σ (n + 1)/(n + m + 3)!·(φ^)ⁿν^(φ^)ᵐ = s^ + ½(c₃ − c₄)(φ^ν^ + ν^φ^) − ½(φ·ν)(c₄ − 4c₅ + 4c₆)φ^² − ½β₂(φmᵀ + mφᵀ)
//! s = ½(c₂ − c₃)ν + ½(c₃ − 3c₄)m − ½(φ·ν)(c₃ − 3c₄ + 3c₅)φ,  m = φ×ν
//! Ũ = −r·ν^ + b(φ·ν)φ^ + ½e(φmᵀ + mφᵀ),  r = c₃/(4c₂),  b = (c₃β₁ − c₂β₂)/(4c₂²)
//! J = J_l(φ),  Γ₂ = ½I + c₃φ^ + c₄φ^²,  Q and Q̃ as in SE(3)                                 J_r(τ) = J_l(−τ)
//! ```
//! Kelly (2023), arXiv 2312.07555, in our order of coordinates. The form of U in [`crate::lie::Stumpff`] functions has no special
//! case at θ = 0. Nor does J_l⁻¹ need a matrix product: J⁻¹Γ₂ = ½I − d·φ^, J⁻¹(J − Γ₂)J⁻¹ = ½I − 2r·φ^, and Ũ is what
//! J⁻¹UJ⁻¹ + J⁻¹(J − Γ₂)Q̃(ν) amounts to.
//!
//! It acts on events: a place p at time τ in the moving frame is R·p + v·τ + p_X at τ + t in the parent frame. An element with
//! t = 0 composes as SE₂(3) does. With a constant angular rate ω and specific force a for a time Δ, both in the body frame,
//! the increments of an inertial sensor are exactly Exp(0, ωΔ, aΔ, Δ).
//!
//! Pitfalls. Time is a coordinate like any other: a covariance has a row for it, in seconds. The position of X⁻¹ is
//! −Rᵀ(p − vt), not that of the SE(3) inverse. Kelly and others order the tangent (ρ, ν, φ, ι).
//!
//! ```
//! use boxplus::lie::{Action, LieGroup, SGal3};
//! use nalgebra::{SVector, Vector3, Vector4};
//! // Two seconds at 3 m/s² along x, from rest, not turning: ν = a·Δ, ι = Δ.
//! let mut tau = SVector::<f64, 10>::zeros();
//! (tau[6], tau[9]) = (6.0, 2.0);
//! let increment = SGal3::exp(&tau);
//! assert!((increment.velocity() - Vector3::new(6.0, 0.0, 0.0)).norm() < 1e-15);
//! assert!((increment.position() - Vector3::new(6.0, 0.0, 0.0)).norm() < 1e-15); // ½·3·2²
//! let event = increment.act(&Vector4::new(0.0, 0.0, 0.0, 1.0)); // the moving origin, one second later
//! assert!((event - Vector4::new(12.0, 0.0, 0.0, 3.0)).norm() < 1e-15);
//! ```

use super::se3::{coupling, right_coupling, right_coupling_inverse, turn, unturn};
use super::se23::split;
use super::so3::{check_affine, polynomial, skew};
use crate::lie::unrolled::{blocks, cross, transposed};
use crate::lie::{Action, LieError, LieGroup, Real, SE23, SO3, Stumpff};
use core::ops::Mul;
use nalgebra::{Matrix3, Matrix4, SMatrix, SVector, Vector3, Vector4};

/// A Galilean transformation: rotation, position, velocity and time.
#[derive(Clone, Copy)]
#[cfg_attr(feature = "bytemuck", derive(bytemuck::TransparentWrapper))]
#[repr(transparent)]
pub struct SGal3<S = f64>(pub(in crate::lie) [S; 11]);

impl<S: Real> SGal3<S> {
    /// The frame of `rotation`, at `position` in m when its clock shows 0, moving at `velocity` in m/s, its clock behind by
    /// `time` in s; all in the parent frame.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(rotation: SO3<S>, position: Vector3<S>, velocity: Vector3<S>, time: S) -> Self {
        Self::from_extended(SE23::new(rotation, position, velocity), time)
    }

    /// An extended pose and the time t.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn from_extended(extended: SE23<S>, time: S) -> Self {
        let [x, y, z, i, j, k, w, a, b, c] = extended.0;
        Self([x, y, z, i, j, k, w, a, b, c, time])
    }

    /// The transformation of a 5×5 matrix \[R v p; 0 1 t; 0 0 1\].
    ///
    /// # Errors
    /// Those of [`SE23::from_matrix`].
    pub fn from_matrix(m: &SMatrix<S, 5, 5>) -> Result<Self, LieError> {
        let (time, mut rest) = (m[(3, 4)], *m);
        check_affine([time], [S::zero()])?;
        rest[(3, 4)] = S::zero();
        Ok(Self::from_extended(SE23::from_matrix(&rest)?, time))
    }

    /// R.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn rotation(&self) -> SO3<S> {
        self.extended_pose().rotation()
    }

    /// p, in metres of the parent frame.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn position(&self) -> Vector3<S> {
        self.extended_pose().position()
    }

    /// v, in m/s of the parent frame.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn velocity(&self) -> Vector3<S> {
        self.extended_pose().velocity()
    }

    /// t in seconds: time in the parent frame minus time in the local one.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn time(&self) -> S {
        self.0[10]
    }

    /// (R, p, v) without the time.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn extended_pose(&self) -> SE23<S> {
        let [x, y, z, i, j, k, w, a, b, c, _] = self.0;
        SE23([x, y, z, i, j, k, w, a, b, c])
    }

    /// The 5×5 matrix \[R v p; 0 1 t; 0 0 1\].
    pub fn to_matrix(&self) -> SMatrix<S, 5, 5> {
        let mut m = self.extended_pose().to_matrix();
        m[(3, 4)] = self.time();
        m
    }

    /// The same transformation with the rotation at unit norm to the last digit.
    pub fn normalize(&self) -> Self {
        Self::from_extended(self.extended_pose().normalize(), self.time())
    }
}

/// The blocks of \[a b c d; 0 a 0 0; 0 e a 0; 0 0 0 f\], the form of Ad, ad, and every Jacobian.
struct Blocks<S> {
    a: Matrix3<S>,
    b: Matrix3<S>,
    c: Matrix3<S>,
    d: Vector3<S>,
    e: Matrix3<S>,
    f: S,
}

impl<S: Real> Blocks<S> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn matrix(&self) -> SMatrix<S, 10, 10> {
        let Self { a, b, c, d, e, f } = self;
        let o = &Matrix3::zeros();
        let mut m: SMatrix<S, 10, 10> = blocks([[a, b, c], [o, a, o], [o, e, a]]);
        [m.data.0[9][0], m.data.0[9][1], m.data.0[9][2]] = d.data.0[0];
        m.data.0[9][9] = *f;
        m
    }
}

/// U(ν, φ), given c_k(|φ|²).
#[cfg_attr(not(debug_assertions), inline(always))]
fn time_coupling<S: Real>(nu: &Vector3<S>, phi: &Vector3<S>, k: &Stumpff<S>) -> Matrix3<S> {
    let (three, four, half) = (S::lit(3.0), S::lit(4.0), S::lit(0.5));
    let (along, across) = (phi.dot(nu) * half, phi.cross(nu));
    let s = nu * ((k.c2 - k.c3) * half) + across * ((k.c3 - three * k.c4) * half)
        - phi * (along * (k.c3 - three * (k.c4 - k.c5)));
    let outer = across * (phi * (k.beta2() * half)).transpose();
    let bend = -along * (k.c4 - four * (k.c5 - k.c6));
    coupling(&s, (k.c3 - k.c4) * half, bend, nu, phi) - outer - transposed(&outer)
}

/// (J_r⁻¹, J_l⁻¹) of a tangent, given c_k(|φ|²) and d.
#[cfg_attr(not(debug_assertions), inline(always))]
fn inverses<S: Real>(tau: &SVector<S, 10>, k: &Stumpff<S>, d: S) -> [SMatrix<S, 10, 10>; 2] {
    let ([rho, phi, nu], half, iota, e) = (split(tau), S::lit(0.5), tau[9], k.e());
    let j = polynomial(&phi, half, d);
    let [p, q] = [rho, nu].map(|v| right_coupling_inverse(&v, &phi, d, e));
    let r = k.c3 / (k.c2 * S::lit(4.0));
    let b = (k.c3 * k.beta1() - k.c2 * k.beta2()) / (k.c2 * k.c2 * S::lit(4.0));
    let outer = phi * (phi.cross(&nu) * (e * half)).transpose();
    // J_r⁻¹(τ) = J_l⁻¹(−τ): even powers of τ keep their sign, such as ιŨ, odd ones change it.
    let u = (skew(&(phi * (phi.dot(&nu) * b) - nu * r)) + outer + transposed(&outer)) * iota;
    let bend = skew(&(phi * (-iota * (r + r))));
    let shift = Matrix3::from_diagonal_element(iota * half);
    let (straight, across, f) = (nu * half, phi.cross(&nu) * d, S::one());
    let right = Blocks { a: j, b: p + u, c: bend - shift, d: across + straight, e: q, f };
    let [a, b, e] = [j, p, q].map(|m| transposed(&m));
    let left = Blocks { a, b: b + u, c: bend + shift, d: across - straight, e, f };
    [right.matrix(), left.matrix()]
}

/// Log of the vectors: J⁻¹p − ι(½ν − d·φ×ν), φ, J⁻¹v and t.
#[cfg_attr(not(debug_assertions), inline(always))]
fn join<S: Real>(x: &SGal3<S>, phi: &Vector3<S>, d: S) -> SVector<S, 10> {
    let nu = unturn(phi, d, &x.velocity());
    let rho = unturn(phi, d, &x.position()) - (nu * S::lit(0.5) - phi.cross(&nu) * d) * x.time();
    SVector::from([rho.x, rho.y, rho.z, phi.x, phi.y, phi.z, nu.x, nu.y, nu.z, x.time()])
}

impl<S: Real> PartialEq for SGal3<S> {
    fn eq(&self, other: &Self) -> bool {
        self.extended_pose() == other.extended_pose() && self.time() == other.time()
    }
}

impl<S: Real> LieGroup<10> for SGal3<S> {
    type Scalar = S;
    type Over<T: Real> = SGal3<T>;
    type Algebra = SMatrix<S, 5, 5>;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn identity() -> Self {
        Self::from_extended(SE23::identity(), S::zero())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn compose(&self, rhs: &Self) -> Self {
        let x = self.extended_pose().compose(&rhs.extended_pose());
        let position = x.position() + self.velocity() * rhs.time();
        Self::new(x.rotation(), position, x.velocity(), self.time() + rhs.time())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn inverse(&self) -> Self {
        let rotation = self.rotation().inverse();
        let start = self.position() - self.velocity() * self.time();
        Self::new(rotation, -rotation.act(&start), -rotation.act(&self.velocity()), -self.time())
    }
    /// Subtracts positions, velocities and times first: the error is relative to their differences.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn between(&self, other: &Self) -> Self {
        let inverse = self.rotation().inverse();
        let time = other.time() - self.time();
        let position = other.position() - self.position() - self.velocity() * time;
        let velocity = other.velocity() - self.velocity();
        let rotation = inverse.compose(&other.rotation());
        Self::new(rotation, inverse.act(&position), inverse.act(&velocity), time)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn exp(tau: &SVector<S, 10>) -> Self {
        let [rho, phi, nu] = split(tau);
        let (rotation, half) = SO3::exp_half(&phi);
        let k = Stumpff::new(phi.norm_squared());
        let turned = phi.cross(&nu);
        let growth = nu * S::lit(0.5) + turned * k.c3 + phi.cross(&turned) * k.c4;
        let position = turn(&phi, &half, &rho) + growth * tau[9];
        Self::new(rotation, position, turn(&phi, &half, &nu), tau[9])
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn log(&self) -> SVector<S, 10> {
        let phi = self.rotation().log();
        join(self, &phi, Stumpff::new(phi.norm_squared()).d())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn adjoint(&self) -> SMatrix<S, 10, 10> {
        let (a, v) = (self.rotation().to_matrix(), self.velocity());
        let start = self.position() - v * self.time();
        let (b, e) = (cross(&start, &a), cross(&v, &a));
        Blocks { a, b, c: a * -self.time(), d: v, e, f: S::one() }.matrix()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn small_adjoint(tau: &SVector<S, 10>) -> SMatrix<S, 10, 10> {
        let [rho, phi, nu] = split(tau);
        let c = Matrix3::from_diagonal_element(-tau[9]);
        Blocks { a: skew(&phi), b: skew(&rho), c, d: nu, e: skew(&nu), f: S::zero() }.matrix()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn right_jacobian(tau: &SVector<S, 10>) -> SMatrix<S, 10, 10> {
        let ([rho, phi, nu], iota) = (split(tau), tau[9]);
        let k = Stumpff::new(phi.norm_squared());
        let [p, q] = [rho, nu].map(|v| right_coupling(&v, &phi, &k));
        // J_l at −τ: U and Γ₂ν are taken at (−ν, −φ), and ι changes sign.
        let u = time_coupling(&-nu, &-phi, &k) * iota;
        let turned = phi.cross(&nu);
        // J − Γ₂, of which I − ½I is exact.
        let lag = polynomial(&phi, k.c3 - k.c2, k.c3 - k.c4) - Matrix3::from_diagonal_element(S::lit(0.5));
        Blocks {
            a: polynomial(&phi, -k.c2, k.c3),
            b: p + u,
            c: lag * iota,
            d: turned * k.c3 - nu * S::lit(0.5) - phi.cross(&turned) * k.c4,
            e: q,
            f: S::one(),
        }
        .matrix()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn right_jacobian_inverse(tau: &SVector<S, 10>) -> SMatrix<S, 10, 10> {
        let [_, phi] = split(tau);
        let k = Stumpff::new(phi.norm_squared());
        let [right, _] = inverses(tau, &k, k.d());
        right
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn log_jacs(&self) -> (SVector<S, 10>, SMatrix<S, 10, 10>, SMatrix<S, 10, 10>) {
        let phi = self.rotation().log();
        let k = Stumpff::new(phi.norm_squared());
        let d = k.d();
        let tau = join(self, &phi, d);
        let [right, left] = inverses(&tau, &k, d);
        (tau, right, left)
    }
    fn hat(tau: &SVector<S, 10>) -> SMatrix<S, 5, 5> {
        let mut m = SE23::hat(&tau.fixed_rows::<9>(0).into_owned());
        m[(3, 4)] = tau[9];
        m
    }
    fn vee(algebra: &SMatrix<S, 5, 5>) -> SVector<S, 10> {
        SE23::vee(algebra).push(algebra[(3, 4)])
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn map<T: Real>(&self, f: impl Fn(S) -> T) -> SGal3<T> {
        let [x, y, z, i, j, k, w, a, b, c, t] = self.0;
        SGal3([f(x), f(y), f(z), f(i), f(j), f(k), f(w), f(a), f(b), f(c), f(t)])
    }
}

/// Events (p, τ): a place in metres and a time in seconds.
impl<S: Real> Action<10, 4> for SGal3<S> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn act(&self, event: &Vector4<S>) -> Vector4<S> {
        let place = self.extended_pose().act(&event.xyz()) + self.velocity() * event.w;
        Vector4::new(place.x, place.y, place.z, event.w + self.time())
    }
    /// \[R v; 0 1\].
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn linear_part(&self) -> Matrix4<S> {
        let mut m = self.rotation().to_matrix().to_homogeneous();
        m.fixed_view_mut::<3, 1>(0, 3).copy_from(&self.velocity());
        m
    }
    /// \[I, −p^, τI, 0; 0, 0, 0, 1\].
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn generators_at(event: &Vector4<S>) -> SMatrix<S, 4, 10> {
        let mut g = SMatrix::<S, 4, 10>::zeros();
        g.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
        g.fixed_view_mut::<3, 3>(0, 3).copy_from(&-skew(&event.xyz()));
        g.fixed_view_mut::<3, 3>(0, 6).fill_diagonal(event.w);
        g[(3, 9)] = S::one();
        g
    }
}

impl<S: Real> Mul for SGal3<S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, rhs: Self) -> Self {
        self.compose(&rhs)
    }
}

impl<S: Real> Mul<Vector4<S>> for SGal3<S> {
    type Output = Vector4<S>;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, event: Vector4<S>) -> Vector4<S> {
        self.act(&event)
    }
}
