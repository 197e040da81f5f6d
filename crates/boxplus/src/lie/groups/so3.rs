//! SO(3): rotations of space, stored as a unit quaternion \[x, y, z, w\] (Hamilton, ij = k).
//!
//! ```text
//! Exp φ = (½c₁(x/4)·φ, c₀(x/4)),  x = |φ|²         R = I + c₁φ^ + c₂φ^²
//! Log: φ = 2a(w)·v,  a(w) = acos(w)/√(1 − w²),  with w ≥ 0 by q ≡ −q
//! Ad = R    ad = φ^    J_r = I − c₂φ^ + c₃φ^²    J_r⁻¹ = I + ½φ^ + d·φ^²    J_l = J_rᵀ
//! ```
//! Solà et al. (2018) (138)–(149), coefficients of [`crate::lie::Stumpff`]. The arc cosine of a trace or of w
//! alone loses half the digits near 0 and near π; the quotient a(w) is smooth on \[0, 1\], a polynomial in w that costs no
//! root and no arc: Log is within 2ε of the truth, relative to θ, for every θ ≤ π.
//!
//! Pitfalls. q and −q are one rotation: `==` knows, component-wise comparison does not. At θ = π both φ and −φ are
//! right; the stored sign decides, see [`SO3::log_near`] for tracking a rotation vector through π. Quaternion order
//! differs between libraries, hence [`SO3::from_xyzw`] and [`SO3::from_wxyz`].
//!
//! ```
//! use boxplus::lie::{LieGroup, SO3};
//! use nalgebra::Vector3;
//! let world_from_body = SO3::exp(&Vector3::new(0.0, 0.0, std::f64::consts::FRAC_PI_2));
//! let p_world = world_from_body * Vector3::new(1.0, 0.0, 0.0);
//! assert!((p_world - Vector3::new(0.0, 1.0, 0.0)).norm() < 1e-15);
//! ```

use crate::lie::unrolled::transposed;
use crate::lie::{Action, LieError, LieGroup, Real, Stumpff};
use core::ops::Mul;
use nalgebra::{Matrix3, Matrix4, SMatrix, Vector3};

/// A rotation of space.
#[derive(Clone, Copy)]
#[cfg_attr(feature = "bytemuck", derive(bytemuck::TransparentWrapper))]
#[repr(transparent)]
pub struct SO3<S = f64>(pub(in crate::lie) [S; 4]);

/// Largest entry of |RᵀR − I| accepted as rounding: six printed decimals leave up to 2√3·5·10⁻⁷ ≈ 2·10⁻⁶.
const ROTATION_TOLERANCE: f64 = 1e-5;

impl<S: Real> SO3<S> {
    /// The rotation of the quaternion x·i + y·j + z·k + w, of any norm but 0.
    ///
    /// # Errors
    /// [`LieError::NotFinite`], or [`LieError::Zero`] where all components are zero.
    pub fn from_xyzw([x, y, z, w]: [S; 4]) -> Result<Self, LieError> {
        let sizes = [x, y, z, w].map(|a| a.value().abs());
        if sizes.iter().any(|a| !a.is_finite()) {
            return Err(LieError::NotFinite);
        }
        let largest = sizes.into_iter().fold(0.0, f64::max);
        if largest == 0.0 {
            return Err(LieError::Zero);
        }
        let scale = S::lit(largest); // so that no square over- or underflows
        Ok(Self::from_unit(Vector3::new(x, y, z) / scale, w / scale).normalize())
    }

    /// The rotation of the quaternion w + x·i + y·j + z·k, of any norm but 0.
    ///
    /// # Errors
    /// Those of [`SO3::from_xyzw`].
    pub fn from_wxyz([w, x, y, z]: [S; 4]) -> Result<Self, LieError> {
        Self::from_xyzw([x, y, z, w])
    }

    /// The rotation of a 3×3 matrix which is one up to rounding in print (RᵀR = I within 10⁻⁵).
    ///
    /// # Errors
    /// [`LieError::NotFinite`], [`LieError::NotARotation`] or [`LieError::Reflection`]; [`SO3::project`] takes any matrix.
    pub fn from_matrix(m: &Matrix3<S>) -> Result<Self, LieError> {
        check_rotation(m, determinant(m))?;
        Self::from_xyzw(shepperd(m))
    }

    /// The rotation nearest to any 3×3 matrix in the Frobenius norm: U·diag(1, 1, det UVᵀ)·Vᵀ of its SVD, Horn (1987).
    ///
    /// Found as the eigenvector of Davenport's 4×4 matrix, then improved by one Newton step in `S`, which makes
    /// derivatives exact as well.
    ///
    /// # Errors
    /// [`LieError::NotFinite`], or [`LieError::Undetermined`] where several rotations are equally near: rank below 2, or
    /// σ₂ = σ₃ with a negative determinant.
    pub fn project(m: &Matrix3<S>) -> Result<Self, LieError> {
        let size = m.iter().fold(0.0, |a: f64, x| a.max(x.value().abs()));
        if m.iter().any(|x| !x.value().is_finite()) {
            return Err(LieError::NotFinite);
        }
        if size == 0.0 {
            return Err(LieError::Undetermined { gap: 0.0 });
        }
        let start = davenport(&m.map(|x| x.value() / size), S::EPSILON)?;
        let start = Self::from_xyzw(start.map(S::lit))?;
        // With M = R·H and R nearest, H is symmetric. From R₀: (tr(H)·I − H)·δ = vee(H₀ − H₀ᵀ), R = R₀·Exp(δ).
        let h = start.to_matrix().transpose() * m / S::lit(size);
        let skew = Vector3::new(h.m32 - h.m23, h.m13 - h.m31, h.m21 - h.m12);
        let system = Matrix3::from_diagonal_element(h.trace()) - (h + h.transpose()) * S::lit(0.5);
        Ok(start.compose(&Self::exp(&solve(&system, &skew))))
    }

    /// The unit quaternion as \[x, y, z, w\]; its sign is arbitrary.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn quaternion_xyzw(&self) -> [S; 4] {
        self.0
    }

    /// The 3×3 rotation matrix.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn to_matrix(&self) -> Matrix3<S> {
        let ([x, y, z, w], one) = (self.quaternion_xyzw(), S::one());
        let (x2, y2, z2) = (x + x, y + y, z + z);
        let (xx, yy, zz) = (x * x2, y * y2, z * z2);
        let (xy, yz, zx) = (x * y2, y * z2, z * x2);
        let (wx, wy, wz) = (w * x2, w * y2, w * z2);
        Matrix3::new(
            one - (yy + zz),
            xy - wz,
            zx + wy,
            xy + wz,
            one - (xx + zz),
            yz - wx,
            zx - wy,
            yz + wx,
            one - (xx + yy),
        )
    }

    /// The same rotation at unit norm to the last digit. Products already hold it within 2ε.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn normalize(&self) -> Self {
        let inverse_norm = S::one() / (self.v().norm_squared() + self.w() * self.w()).simd_sqrt();
        Self::from_unit(self.v() * inverse_norm, self.w() * inverse_norm)
    }

    /// The logarithm nearest to `reference` among φ·(1 + 2πk/θ), k integer: follows a rotation through θ = π, 2π, ….
    ///
    /// At the identity every 2πk·n is a logarithm; there n is the direction of `reference`.
    pub fn log_near(&self, reference: &Vector3<S>) -> Vector3<S> {
        let phi = self.log();
        // Direction of the family of logarithms; at the identity it is free.
        let axis = S::choose(phi.norm_squared().simd_gt(S::zero()), || phi, || *reference);
        let square = axis.norm_squared();
        S::choose(
            square.simd_gt(S::zero()),
            || {
                let turn = S::simd_two_pi() / square.simd_sqrt();
                let along = axis.dot(&(reference - phi)) / square;
                phi + axis * (turn * (along / turn).nearest())
            },
            || phi,
        )
    }

    /// The rotation of v·(i, j, k) + w, which is of unit norm.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(in crate::lie) fn from_unit(v: Vector3<S>, w: S) -> Self {
        Self([v.x, v.y, v.z, w])
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn v(&self) -> Vector3<S> {
        let [x, y, z, _] = self.0;
        Vector3::new(x, y, z)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn w(&self) -> S {
        self.0[3]
    }

    /// Exp φ together with the Stumpff functions at |φ|²/4, from which those at |φ|² follow.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn exp_half(phi: &Vector3<S>) -> (Self, Stumpff<S>) {
        let half = Stumpff::half(phi.norm_squared() * S::lit(0.25));
        (Self::from_unit(phi * (half.c1 * S::lit(0.5)), half.c0), half)
    }
}

/// φ^, the matrix of φ × ·.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn skew<S: Real>(v: &Vector3<S>) -> Matrix3<S> {
    let o = S::zero();
    Matrix3::new(o, -v.z, v.y, v.z, o, -v.x, -v.y, v.x, o)
}

/// I + a·φ^ + b·φ^².
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn polynomial<S: Real>(phi: &Vector3<S>, a: S, b: S) -> Matrix3<S> {
    quadratic(phi, [S::one(), a, b])
}

/// a·I + b·φ^ + c·φ^², with (φ^²)₁₁ = −(φ₂² + φ₃²) free of cancellation.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn quadratic<S: Real>(phi: &Vector3<S>, [a, b, c]: [S; 3]) -> Matrix3<S> {
    let (s, u) = (phi * b, phi * c);
    let (xx, yy, zz) = (phi.x * u.x, phi.y * u.y, phi.z * u.z);
    let (xy, yz, zx) = (phi.x * u.y, phi.y * u.z, phi.z * u.x);
    Matrix3::new(
        a - (yy + zz),
        xy - s.z,
        zx + s.y,
        xy + s.z,
        a - (xx + zz),
        yz - s.x,
        zx - s.y,
        yz + s.x,
        a - (xx + yy),
    )
}

/// Refuses what is not a rotation matrix, and says why.
pub(super) fn check_rotation<S: Real, const N: usize>(
    m: &SMatrix<S, N, N>,
    determinant: S,
) -> Result<(), LieError> {
    if m.iter().any(|x| !x.value().is_finite()) {
        return Err(LieError::NotFinite);
    }
    let gram = m.transpose() * m - SMatrix::<S, N, N>::identity();
    let deviation = gram.iter().fold(0.0, |a: f64, x| a.max(x.value().abs()));
    if deviation > ROTATION_TOLERANCE {
        return Err(LieError::NotARotation { deviation });
    }
    if determinant.value() < 0.0 {
        return Err(LieError::Reflection);
    }
    Ok(())
}

/// Refuses a translation that is not finite and a last row other than (0, …, 0, 1), whose deviation is `row`.
pub(super) fn check_affine<S: Real, const N: usize, const M: usize>(
    translation: [S; N],
    row: [S; M],
) -> Result<(), LieError> {
    if translation.iter().chain(&row).any(|x| !x.value().is_finite()) {
        return Err(LieError::NotFinite);
    }
    if row.iter().any(|x| x.value().abs() > ROTATION_TOLERANCE) {
        return Err(LieError::NotHomogeneous);
    }
    Ok(())
}

/// A quaternion \[x, y, z, w\], not of unit norm, of a rotation matrix. Shepperd (1978): divides by the largest component.
fn shepperd<S: Real>(m: &Matrix3<S>) -> [S; 4] {
    let (one, trace) = (S::one(), m.trace());
    let (a, b, c) = (m.m32 - m.m23, m.m13 - m.m31, m.m21 - m.m12);
    let (p, q, r) = (m.m12 + m.m21, m.m13 + m.m31, m.m23 + m.m32);
    let [t, x, y, z] = [trace, m.m11, m.m22, m.m33].map(Real::value);
    if t >= x && t >= y && t >= z {
        [a, b, c, one + trace]
    } else if x >= y && x >= z {
        [one + m.m11 + m.m11 - trace, p, q, a]
    } else if y >= z {
        [p, one + m.m22 + m.m22 - trace, r, b]
    } else {
        [q, r, one + m.m33 + m.m33 - trace, c]
    }
}

/// The quaternion maximising tr(RᵀM): top eigenvector of Davenport's matrix. Its eigengap is 2(σ₂ ± σ₃).
fn davenport(m: &Matrix3<f64>, epsilon: f64) -> Result<[f64; 4], LieError> {
    let (a, b, c) = (m.m32 - m.m23, m.m13 - m.m31, m.m21 - m.m12);
    let (p, q, r) = (m.m12 + m.m21, m.m13 + m.m31, m.m23 + m.m32);
    let (x, y, z) = (m.m11, m.m22, m.m33);
    #[rustfmt::skip]
    let k = Matrix4::new(
        x - y - z, p,         q,         a,
        p,         y - x - z, r,         b,
        q,         r,         z - x - y, c,
        a,         b,         c,         x + y + z,
    );
    let eigen = k.symmetric_eigen();
    let top = eigen.eigenvalues.imax();
    let next = (0..4).filter(|i| *i != top).map(|i| eigen.eigenvalues[i]).fold(f64::MIN, f64::max);
    let gap = (eigen.eigenvalues[top] - next) / (2.0 * m.norm());
    // Entries of M known to ε leave the rotation uncertain by ε/gap; below 16ε nothing of it is known.
    if gap <= 16.0 * epsilon {
        return Err(LieError::Undetermined { gap });
    }
    Ok(eigen.eigenvectors.column(top).into_owned().into())
}

/// The solution of a regular 3×3 system by Cramer's rule.
fn solve<S: Real>(a: &Matrix3<S>, b: &Vector3<S>) -> Vector3<S> {
    let [p, q, r] = [0, 1, 2].map(|i| a.column(i).into_owned());
    Vector3::new(q.cross(&r).dot(b), r.cross(&p).dot(b), p.cross(&q).dot(b)) / determinant(a)
}

fn determinant<S: Real>(a: &Matrix3<S>) -> S {
    a.column(0).cross(&a.column(1)).dot(&a.column(2))
}

/// Two quaternions of one rotation are equal: q = −q.
impl<S: Real> PartialEq for SO3<S> {
    fn eq(&self, other: &Self) -> bool {
        (self.v() == other.v() && self.w() == other.w()) || (self.v() == -other.v() && self.w() == -other.w())
    }
}

impl<S: Real> LieGroup<3> for SO3<S> {
    type Scalar = S;
    type Over<T: Real> = SO3<T>;
    type Algebra = Matrix3<S>;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn identity() -> Self {
        Self::from_unit(Vector3::zeros(), S::one())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn compose(&self, rhs: &Self) -> Self {
        let v = self.v().cross(&rhs.v()) + rhs.v() * self.w() + self.v() * rhs.w();
        let w = self.w() * rhs.w() - self.v().dot(&rhs.v());
        // One Newton step towards unit norm: the error of a product is squared instead of handed on.
        let scale = S::lit(1.5) - S::lit(0.5) * (v.norm_squared() + w * w);
        Self::from_unit(v * scale, w * scale)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn inverse(&self) -> Self {
        Self::from_unit(-self.v(), self.w())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn exp(phi: &Vector3<S>) -> Self {
        Self::exp_half(phi).0
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn log(&self) -> Vector3<S> {
        let sign = S::choose(self.w().simd_lt(S::zero()), || -S::one(), || S::one());
        let half = S::angle_over_sine(self.v().norm_squared(), self.w() * sign);
        self.v() * (sign * half * S::lit(2.0))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn adjoint(&self) -> Matrix3<S> {
        self.to_matrix()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn adjoint_times(&self, phi: &Vector3<S>) -> Vector3<S> {
        self.act(phi)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn small_adjoint(phi: &Vector3<S>) -> Matrix3<S> {
        skew(phi)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn right_jacobian(phi: &Vector3<S>) -> Matrix3<S> {
        let c = Stumpff::new(phi.norm_squared());
        polynomial(phi, -c.c2, c.c3)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn right_jacobian_inverse(phi: &Vector3<S>) -> Matrix3<S> {
        polynomial(phi, S::lit(0.5), Stumpff::new(phi.norm_squared()).d())
    }
    #[inline]
    fn right_jacobian_derivative(phi: &Vector3<S>, delta: &Vector3<S>) -> Matrix3<S> {
        super::second::so3(phi, delta)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn log_jacs(&self) -> (Vector3<S>, Matrix3<S>, Matrix3<S>) {
        let phi = self.log();
        let right = Self::right_jacobian_inverse(&phi);
        (phi, right, transposed(&right))
    }
    fn hat(phi: &Vector3<S>) -> Matrix3<S> {
        skew(phi)
    }
    fn vee(algebra: &Matrix3<S>) -> Vector3<S> {
        Vector3::new(algebra.m32, algebra.m13, algebra.m21)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn map<T: Real>(&self, f: impl Fn(S) -> T) -> SO3<T> {
        let [x, y, z, w] = self.0; // not `map`, which may stay a call
        SO3([f(x), f(y), f(z), f(w)])
    }
}

impl<S: Real> Action<3, 3> for SO3<S> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn act(&self, p: &Vector3<S>) -> Vector3<S> {
        let t = self.v().cross(p);
        let t = t + t;
        p + t * self.w() + self.v().cross(&t)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn linear_part(&self) -> Matrix3<S> {
        self.to_matrix()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn generators_at(p: &Vector3<S>) -> Matrix3<S> {
        -skew(p)
    }
}

impl<S: Real> Mul for SO3<S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, rhs: Self) -> Self {
        self.compose(&rhs)
    }
}

impl<S: Real> Mul<Vector3<S>> for SO3<S> {
    type Output = Vector3<S>;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, p: Vector3<S>) -> Vector3<S> {
        self.act(&p)
    }
}
