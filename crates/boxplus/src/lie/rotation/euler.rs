//! Euler angles: all 24 sequences, their rates, and gimbal lock.
//!
//! A sequence names three axes, the turns being made in the order of the letters. Intrinsic sequences turn about the axes of
//! the moving body, extrinsic ones about those of the world; the same letters in reverse order are the same rotation:
//!
//! ```text
//! intrinsic ABC(α, β, γ) = R_A(α)·R_B(β)·R_C(γ) = extrinsic cba(γ, β, α)
//! ```
//!
//! Capital letters are intrinsic, small ones extrinsic, as in SciPy; `ZYX` is yaw, pitch, roll. Twelve sequences are proper
//! (first axis = third, e.g. `ZXZ`), twelve are Tait–Bryan (three different axes).
//!
//! **Out of a quaternion** by Bernardes & Viollet (2022): the middle angle is 2·atan2 of two lengths, hence right to the last
//! digit at gimbal lock, too, where formulas with an arc sine of a matrix entry lose half of them.
//!
//! **Gimbal lock.** Where the middle angle is ±π/2 (Tait–Bryan), 0 or π (proper), the first and the third axis coincide and only
//! the sum or the difference of their angles is determined: [`EulerAngles::lock`] says which, and its value. The angles returned
//! are always angles of the rotation; those closer to the lock than 16ε have the third one 0.
//! Near the lock a small rotation is a large step of angles: the *angles* jump, the rotation does not.
//!
//! **Rates.** With E = ∂R/∂(angles) on the right, ω = E·(α̇, β̇, γ̇) is the angular velocity in the body frame, R·E that in the
//! world frame; |det E| = sin of the distance of the middle angle from the lock.
//!
//! ```
//! use boxplus::lie::{EulerSequence, GimbalLock, SO3};
//! use std::f64::consts::FRAC_PI_2;
//! let nose_up: SO3 = SO3::from_yaw_pitch_roll(0.7, -FRAC_PI_2, 0.2);
//! let euler = nose_up.to_euler(EulerSequence::ZYX);
//! assert!(matches!(euler.lock, Some(GimbalLock::Sum(sum)) if (sum - 0.9).abs() < 1e-15));
//! // The same letters about fixed axes, by name:
//! let fixed = nose_up.to_euler("xyz".parse()?);
//! assert!((fixed.angles[1] + FRAC_PI_2).abs() < 1e-15);
//! # Ok::<(), boxplus::lie::LieError>(())
//! ```

use crate::lie::{LieError, LieGroup, Real, SO3};
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use core::fmt;
use core::str::FromStr;
use nalgebra::{Matrix3, SimdComplexField, Vector3};

/// Which axes three Euler angles turn about, and whether these move with the body (intrinsic) or not (extrinsic).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct EulerSequence {
    /// 0, 1, 2 for x, y, z, in the order of the angles.
    axes: [usize; 3],
    extrinsic: bool,
}

macro_rules! intrinsic {
    ($($name:ident [$a:literal, $b:literal, $c:literal])*) => { $(
        #[doc = concat!("Intrinsic ", stringify!($name), ".")]
        pub const $name: Self = Self { axes: [$a, $b, $c], extrinsic: false };
    )* };
}

impl EulerSequence {
    intrinsic! {
        XYX [0, 1, 0] XYZ [0, 1, 2] XZX [0, 2, 0] XZY [0, 2, 1]
        YXY [1, 0, 1] YXZ [1, 0, 2] YZX [1, 2, 0] YZY [1, 2, 1]
        ZXY [2, 0, 1] ZXZ [2, 0, 2] ZYX [2, 1, 0] ZYZ [2, 1, 2]
    }
    /// The twelve intrinsic sequences; with [`EulerSequence::extrinsic`] all 24.
    pub const INTRINSIC: [Self; 12] = [
        Self::XYX,
        Self::XYZ,
        Self::XZX,
        Self::XZY,
        Self::YXY,
        Self::YXZ,
        Self::YZX,
        Self::YZY,
        Self::ZXY,
        Self::ZXZ,
        Self::ZYX,
        Self::ZYZ,
    ];

    /// The same letters about the fixed axes.
    pub const fn extrinsic(self) -> Self {
        Self { extrinsic: true, ..self }
    }

    /// Whether the axes are fixed.
    pub const fn is_extrinsic(self) -> bool {
        self.extrinsic
    }

    /// Whether the first and the third axis are the same: proper Euler angles, not Tait–Bryan.
    pub const fn is_proper(self) -> bool {
        self.axes[0] == self.axes[2]
    }

    /// The intrinsic axes in order, which for an extrinsic sequence are the reverse; also reverses angles.
    fn intrinsic_order<T: Copy>(self, [a, b, c]: [T; 3]) -> [T; 3] {
        if self.extrinsic { [c, b, a] } else { [a, b, c] }
    }

    /// The first two intrinsic axes and the remaining one, and +1 or −1 as these are right- or left-handed.
    fn frame(self) -> ([usize; 3], f64) {
        let [a, b, _] = self.intrinsic_order(self.axes);
        let parity = if (a + 1) % 3 == b { 1.0 } else { -1.0 };
        ([a, b, 3 - a - b], parity)
    }
}

/// Three capital letters for an intrinsic sequence, three small ones for an extrinsic one: `ZYX`, `xyz`.
impl FromStr for EulerSequence {
    type Err = LieError;
    fn from_str(name: &str) -> Result<Self, LieError> {
        let intrinsic = Self::INTRINSIC.into_iter();
        let mut all = intrinsic.flat_map(|sequence| [sequence, sequence.extrinsic()]);
        let same = |sequence: &Self| sequence.letters().iter().copied().eq(name.bytes());
        all.find(same).ok_or(LieError::NotASequence)
    }
}

impl EulerSequence {
    fn letters(self) -> [u8; 3] {
        let names = if self.extrinsic { b"xyz" } else { b"XYZ" };
        self.axes.map(|axis| names[axis])
    }
}

impl fmt::Display for EulerSequence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.letters().iter().try_for_each(|letter| write!(f, "{}", char::from(*letter)))
    }
}

/// What is determined where the first and the third axis coincide, in radians in (−π, π].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GimbalLock<S = f64> {
    /// First + third angle.
    Sum(S),
    /// First − third angle.
    Difference(S),
}

/// Three Euler angles of a rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EulerAngles<S = f64> {
    /// What they turn about.
    pub sequence: EulerSequence,
    /// In radians, in the order of the sequence. Out of a rotation: first and third in (−π, π], the middle one in \[0, π\]
    /// if the sequence is proper, else in \[−π/2, π/2\].
    pub angles: [S; 3],
    /// Set where the middle angle is within √ε of the lock: less than half of the digits of the first and the third
    /// angle are determined there, all of the combination given.
    pub lock: Option<GimbalLock<S>>,
}

/// Closer to the lock than this multiple of ε, rounding of a unit quaternion leaves nothing of the angles apart.
const LOCKED: f64 = 16.0;

impl<S: Real> EulerAngles<S> {
    /// The rotation.
    pub fn rotation(&self) -> SO3<S> {
        SO3::from_euler(self.sequence, self.angles)
    }

    /// How far the middle angle is from gimbal lock, in radians: a rotation by δ moves the others by up to about δ/margin.
    pub fn margin(&self) -> f64 {
        let middle = self.angles[1].value();
        // From the nearest multiple of π, if proper, else from the nearest odd multiple of π/2.
        let from = if self.sequence.is_proper() { middle } else { middle + FRAC_PI_2 };
        (from - PI * (from / PI).simd_round()).abs()
    }

    /// E = ∂R/∂(angles), 3×3: R(angles + δ) ≈ R·Exp(E·δ). Body rates are ω = E·(rates of the angles).
    pub fn d_rotation_d_angles(&self) -> Matrix3<S> {
        let basis = self.basis();
        let columns = [basis.u(), basis.v, basis.w];
        Matrix3::from_columns(&self.sequence.intrinsic_order(columns))
    }

    /// E⁻¹ = ∂(angles)/∂R, 3×3: how the angles move as R·Exp(δ). Rates of the angles are E⁻¹·ω.
    ///
    /// # Errors
    /// [`LieError::GimbalLock`] where the middle angle is within 16ε of it.
    pub fn d_angles_d_rotation(&self) -> Result<Matrix3<S>, LieError> {
        let margin = self.margin();
        if margin <= LOCKED * S::EPSILON {
            return Err(LieError::GimbalLock { margin });
        }
        let Basis { v, w, n, un, uw } = self.basis();
        let first = n / un;
        let rows = [first, v, w - first * uw].map(|row| row.transpose());
        Ok(Matrix3::from_rows(&self.sequence.intrinsic_order(rows)))
    }

    /// The instantaneous axes in the body frame. With intrinsic axes a, b, c: w = e_c, v = R_cᵀe_b, u = (R_bR_c)ᵀe_a.
    fn basis(&self) -> Basis<S> {
        let ([a, b, k], parity) = self.sequence.frame();
        let [_, beta, gamma] = self.sequence.intrinsic_order(self.angles);
        let (parity, (sin, cos), (s, c)) = (S::lit(parity), beta.simd_sin_cos(), gamma.simd_sin_cos());
        // R_cᵀ leaves e_c and turns the plane of the two other axes, e_p towards e_q.
        let turned = |axis: usize| -> Vector3<S> {
            let last = if self.sequence.is_proper() { a } else { k };
            let (e, next) = (Vector3::ith(axis, S::one()), Vector3::ith(last, S::one()));
            if axis == last { e } else { e * c - next.cross(&e) * s }
        };
        let v = turned(b);
        // u = cos β·R_cᵀe_a − sin β·R_cᵀ(e_b × e_a), and e_b × e_a = −parity·e_k.
        if self.sequence.is_proper() {
            Basis { v, w: turned(a), n: turned(k) * -parity, un: -sin, uw: cos }
        } else {
            Basis { v, w: turned(k), n: turned(a) * parity, un: cos * parity, uw: sin * parity }
        }
    }
}

/// Axes of the three turns in the body frame: v ⟂ w, n = v × w, and u = (u·n)·n + (u·w)·w.
struct Basis<S> {
    v: Vector3<S>,
    w: Vector3<S>,
    n: Vector3<S>,
    un: S,
    uw: S,
}

impl<S: Real> Basis<S> {
    fn u(&self) -> Vector3<S> {
        self.n * self.un + self.w * self.uw
    }
}

impl<S: Real> SO3<S> {
    /// The rotation of three Euler angles in radians, in the order of the sequence.
    pub fn from_euler(sequence: EulerSequence, angles: [S; 3]) -> Self {
        let [a, b, c] = sequence.intrinsic_order([0, 1, 2]).map(|i| Self::about(sequence.axes[i], angles[i]));
        a.compose(&b).compose(&c)
    }

    /// [`SO3::from_euler`]: `(value, d_value_d_angles)`, 3×3, [`EulerAngles::d_rotation_d_angles`].
    pub fn from_euler_jac(sequence: EulerSequence, angles: [S; 3]) -> (Self, Matrix3<S>) {
        let euler = EulerAngles { sequence, angles, lock: None };
        (euler.rotation(), euler.d_rotation_d_angles())
    }

    /// The Euler angles, in radians. For single numbers: it looks for gimbal lock. There derivatives do not exist.
    pub fn to_euler(&self, sequence: EulerSequence) -> EulerAngles<S> {
        let halves = Halves::new(self, sequence);
        let [first, third] = halves.outer_angles(sequence);
        let lock = (halves.margin() < S::EPSILON.simd_sqrt()).then(|| halves.lock(first, third));
        EulerAngles { sequence, angles: [first, halves.middle_angle(sequence), third], lock }
    }

    /// [`SO3::to_euler`]: `(value, d_angles_d_self)`, 3×3, [`EulerAngles::d_angles_d_rotation`].
    ///
    /// # Errors
    /// [`LieError::GimbalLock`].
    pub fn to_euler_jac(&self, sequence: EulerSequence) -> Result<(EulerAngles<S>, Matrix3<S>), LieError> {
        let euler = self.to_euler(sequence);
        Ok((euler, euler.d_angles_d_rotation()?))
    }

    /// The attitude of a vehicle with x ahead, y to the left, z up: R_z(yaw)·R_y(pitch)·R_x(roll), in radians.
    ///
    /// With these axes a positive pitch lowers the nose. In aviation (x ahead, y right, z down) the formula is the same and
    /// it raises the nose.
    pub fn from_yaw_pitch_roll(yaw: S, pitch: S, roll: S) -> Self {
        Self::from_euler(EulerSequence::ZYX, [yaw, pitch, roll])
    }

    /// \[yaw, pitch, roll\] in radians: [`SO3::to_euler`] by [`EulerSequence::ZYX`], without its report of gimbal lock.
    pub fn yaw_pitch_roll(&self) -> [S; 3] {
        self.to_euler(EulerSequence::ZYX).angles
    }
}

/// What Bernardes & Viollet (2022) read off a quaternion for the extrinsic sequence i, j, k with angles θ₁, θ₂, θ₃.
struct Halves<S> {
    /// ½(θ₃ + θ₁) and ½(θ₃ − θ₁), θ₃ being that of a proper sequence.
    plus: S,
    minus: S,
    /// Lengths that vanish at the one and at the other lock: sin and cos of half the middle angle, that of a proper sequence.
    low: S,
    high: S,
    /// θ₃ of the sequence over that of the proper one: ±1.
    kappa: S,
}

impl<S: Real> Halves<S> {
    fn new(rotation: &SO3<S>, sequence: EulerSequence) -> Self {
        let ([k, j, i], proper) = (sequence.intrinsic_order(sequence.axes), sequence.is_proper());
        let (_, parity) = sequence.frame();
        let handed = S::lit(if proper { parity } else { -parity });
        let [x, y, z, w] = rotation.quaternion_xyzw();
        let q = [x, y, z];
        // For proper sequences the third axis is the remaining one.
        let (qi, qj, qk) = (q[i], q[j], q[if proper { 3 - i - j } else { k }] * handed);
        let (a, b, c, d) = if proper { (w, qi, qj, qk) } else { (w - qj, qi + qk, w + qj, qk - qi) };
        let kappa = if proper { S::one() } else { handed };
        Self {
            plus: S::polar_angle(b, a),
            minus: S::polar_angle(d, c),
            low: c.simd_hypot(d),
            high: a.simd_hypot(b),
            kappa,
        }
    }

    /// Whether the nearer lock is that where `low` vanishes.
    fn at_low(&self) -> bool {
        self.low.value() < self.high.value()
    }

    /// The distance from the nearer lock in radians, where it is small.
    fn margin(&self) -> f64 {
        let (low, high) = (self.low.value(), self.high.value());
        2.0 * low.min(high) / low.max(high)
    }

    fn middle_angle(&self, sequence: EulerSequence) -> S {
        let middle = S::polar_angle(self.low, self.high) * S::lit(2.0);
        if sequence.is_proper() { middle } else { middle - S::lit(FRAC_PI_2) }
    }

    /// The first and the third angle in the order of the sequence; at the lock the third is 0.
    fn outer_angles(&self, sequence: EulerSequence) -> [S; 2] {
        let determined = if self.at_low() { self.plus } else { self.minus } * S::lit(2.0);
        let locked = self.margin() <= LOCKED * S::EPSILON;
        let [first, third] = match (locked, sequence.extrinsic, self.at_low()) {
            (false, ..) => [self.plus - self.minus, self.plus + self.minus],
            (true, true, true) => [determined, S::zero()],
            (true, true, false) => [-determined, S::zero()],
            (true, false, _) => [S::zero(), determined],
        };
        let [first, third] = [first, third * self.kappa].map(wrap);
        if sequence.extrinsic { [first, third] } else { [third, first] }
    }

    fn lock(&self, first: S, third: S) -> GimbalLock<S> {
        if self.at_low() == (self.kappa.value() > 0.0) {
            GimbalLock::Sum(wrap(first + third))
        } else {
            GimbalLock::Difference(wrap(first - third))
        }
    }
}

/// `angle`, at most two turns, brought to (−π, π].
fn wrap<S: Real>(angle: S) -> S {
    let value = angle.value();
    if value > PI {
        angle - S::lit(TAU)
    } else if value <= -PI {
        angle + S::lit(TAU)
    } else {
        angle
    }
}
