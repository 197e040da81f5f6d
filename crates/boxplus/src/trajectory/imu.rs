//! Pre-integration of inertial measurements: hundreds of samples between two states become one measurement.
//!
//! ```text
//! samples      ω̃ = ω + b_g + n_g      ã = Rᵀ(a − g) + b_a + n_a                        body frame; a, g in the world
//! per sample   ω̂ = ω̃ − b_g,  â = ã − b_a,   Υ = Exp(0, ω̂δ, âδ, δ) ∈ SGal(3)           Δ ← Δ·Υ
//! bias         D ← Ad(Υ⁻¹)·D − δ·J_r[φν]                                               Δ(b + δb) ≈ Δ·Exp(D·δb)
//! noise        Σ ← Ad(Υ⁻¹)·Σ·Ad(Υ⁻¹)ᵀ + δ·J_r[φν]·diag(σ_g²I, σ_a²I)·J_r[φν]ᵀ
//! states       X_j = Γ·F(X_i)·Δ      F: p ← p + vT      Γ = (I, ½gT², gT)              X ∈ SE₂(3)
//! residual     r = Log(Δ(b)⁻¹·F(X_i)⁻¹·Γ⁻¹·X_j) ~ N(0, Σ)
//! ∂r/∂X_j = J_r⁻¹(r)      ∂r/∂X_i = −J_r⁻¹(r)·Ad(D_ij⁻¹)·F      ∂r/∂b = −J_l⁻¹(r)·J_r(D·δb)·D
//! ∂r/∂g = −J_r⁻¹(r)·Ad(D_ij⁻¹)·[½T²R_iᵀ; 0; T·R_iᵀ]
//! ```
//! with D_ij = F(X_i)⁻¹Γ⁻¹X_j what the states say of Δ, and J_r[φν] the columns φ, ν of J_r of SGal(3). Barrau & Bonnabel
//! (2017), Brossard et al. (2022), Kelly (2023); the method is that of Forster et al. (2017).
//!
//! - **Exact within a sample** for constant rate and specific force, however long: Δ is one exponential of SGal(3). Forster
//!   et al. hold the rotation of a sample's start; at 10 ms and 4 rad/s that is off by 2 % of the sample's own velocity.
//! - **One error, on the group**: Σ and D are of the local tangent (ρ, φ, ν) of SE₂(3), all three coupled; to compare
//!   with Forster et al., whose δp and δv are in the frame of Δ, turn ρ and ν by ΔR.
//! - **Biases on the group**: after a change of 0.01 rad/s and 0.1 m/s², half a second of rough motion is off by 4·10⁻⁶ m/s,
//!   by 9·10⁻⁵ m/s with corrections added to p and v as in Forster et al. (`tests/trajectory/imu.rs`); both errors are of
//!   second order.
//! - **Pitfalls**: g points down, (0, 0, −9.81) with z up; at rest an accelerometer reads +9.81 upwards. The
//!   states are those of the sensor itself, not of the body that carries it. Biases drift: that is a factor of its own
//!   between two of them, not part of Σ.

use super::TrajectoryError;
use super::error::{check_duration, check_finite};
use crate::lie::{LieGroup, Real, Rn, SE23, SGal3};
use nalgebra::{SMatrix, SVector, Vector3};

/// What an inertial measurement unit shows during a step, held constant over it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Imu<S = f64> {
    /// Angular rate, in rad/s of the body (not degrees).
    pub gyroscope: Vector3<S>,
    /// Specific force, in m/s² of the body: at rest, +g upwards (not multiples of g).
    pub accelerometer: Vector3<S>,
    /// Δ, in seconds.
    pub duration: S,
}

crate::bundle! {
    /// What a resting inertial sensor reads that is not there, in its own frame: a group, to which two of them add. Tangent
    /// (b_g, b_a).
    pub struct ImuBias {
        gyro: Rn<3> [3],
        accel: Rn<3> [3],
    }
}

impl<S: Real> ImuBias<S> {
    /// b_g in rad/s, b_a in m/s².
    pub fn new(gyro: Vector3<S>, accel: Vector3<S>) -> Self {
        Self { gyro: Rn::new(gyro), accel: Rn::new(accel) }
    }

    /// No bias.
    pub fn zero() -> Self {
        Self::identity()
    }

    /// b_g, rad/s.
    pub fn gyro(&self) -> Vector3<S> {
        self.gyro.vector()
    }

    /// b_a, m/s².
    pub fn accel(&self) -> Vector3<S> {
        self.accel.vector()
    }

    /// (b_g, b_a): the order of the columns of derivatives in a bias.
    pub fn vector(&self) -> SVector<S, 6> {
        self.log()
    }
}

/// Densities of the white noise of an inertial sensor, as its data sheet has them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuNoise<S = f64> {
    /// σ_g, rad/s/√Hz.
    pub gyro: S,
    /// σ_a, m/s²/√Hz.
    pub accel: S,
}

/// The sum of inertial samples between two states.
///
/// ```
/// use boxplus::lie::{LieGroup, SE23};
/// use boxplus::trajectory::{ImuBias, ImuNoise, Preintegration};
/// use nalgebra::Vector3;
/// let mut sum = Preintegration::new(ImuBias::zero(), ImuNoise { gyro: 1e-3_f64, accel: 1e-2 })?;
/// for _ in 0..100 {
///     // Lying still for a second: the accelerometer feels the ground push.
///     sum.push(&Vector3::zeros(), &Vector3::new(0.0, 0.0, 9.81), 0.01)?;
/// }
/// let gravity = Vector3::new(0.0, 0.0, -9.81);
/// let later = sum.predict(&SE23::identity(), &ImuBias::zero(), &gravity);
/// assert!(later.rminus(&SE23::identity()).norm() < 1e-13);
/// let sigma_z = sum.covariance()[(2, 2)].sqrt(); // σ_a·√(T³/3)
/// assert!((sigma_z - 1e-2 * (1.0_f64 / 3.0).sqrt()).abs() < 1e-6);
/// # Ok::<(), boxplus::trajectory::TrajectoryError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preintegration<S: Real = f64> {
    increment: SGal3<S>,
    bias: ImuBias<S>,
    noise: ImuNoise<S>,
    covariance: SMatrix<S, 9, 9>,
    d_bias: SMatrix<S, 9, 6>,
}

impl<S: Real> Preintegration<S> {
    /// Nothing yet; samples will be taken about `bias`, the best known.
    ///
    /// # Errors
    /// [`TrajectoryError::NotADensity`] if a density is negative or not finite, [`TrajectoryError::NotFinite`] (0: gyro, 1:
    /// accelerometer).
    pub fn new(bias: ImuBias<S>, noise: ImuNoise<S>) -> Result<Self, TrajectoryError> {
        for density in [noise.gyro, noise.accel].map(Real::value) {
            if !(density >= 0.0 && density.is_finite()) {
                return Err(TrajectoryError::NotADensity { density });
            }
        }
        check_finite(&bias.gyro(), 0)?;
        check_finite(&bias.accel(), 1)?;
        let (covariance, d_bias) = (SMatrix::zeros(), SMatrix::zeros());
        Ok(Self { increment: SGal3::identity(), bias, noise, covariance, d_bias })
    }

    /// The sum of samples about `bias`.
    ///
    /// # Errors
    /// Those of [`Preintegration::new`] and [`Preintegration::push`].
    pub fn of(samples: &[Imu<S>], bias: ImuBias<S>, noise: ImuNoise<S>) -> Result<Self, TrajectoryError> {
        let mut sum = Self::new(bias, noise)?;
        samples.iter().try_for_each(|z| sum.push(&z.gyroscope, &z.accelerometer, z.duration))?;
        Ok(sum)
    }

    /// Adds a sample: angular rate in rad/s and specific force in m/s², constant for the next `duration` seconds.
    ///
    /// # Errors
    /// [`TrajectoryError::NotFinite`] (0: gyro, 1: accelerometer) or [`TrajectoryError::NotADuration`]; the sum is then
    /// unchanged.
    pub fn push(
        &mut self,
        gyro: &Vector3<S>,
        accel: &Vector3<S>,
        duration: S,
    ) -> Result<(), TrajectoryError> {
        check_finite(gyro, 0)?;
        check_finite(accel, 1)?;
        check_duration(duration)?;
        let (turn, push) = ((gyro - self.bias.gyro()) * duration, (accel - self.bias.accel()) * duration);
        let o = S::zero();
        let tau = SVector::from([o, o, o, turn.x, turn.y, turn.z, push.x, push.y, push.z, duration]);
        let (step, jacobian) = SGal3::exp_jac(&tau);
        let d_sample = jacobian.fixed_view::<9, 6>(0, 3) * duration;
        let rate = S::one() / duration;
        let variance = [self.noise.gyro, self.noise.accel].map(|density| density * density * rate);
        let noise = SMatrix::from_fn(|i, j| d_sample[(i, j)] * variance[j / 3]) * d_sample.transpose();
        self.append(&step, &noise, &-d_sample);
        Ok(())
    }

    /// This sum, continued by one about the same bias: the state between them is dropped. The order of samples is kept.
    ///
    /// The bias of `self` stays the reference; to join sums about different biases, add their samples anew.
    pub fn then(&self, next: &Self) -> Self {
        let mut joined = *self;
        joined.append(&next.increment, &next.covariance, &next.d_bias);
        joined
    }

    /// Δ ← Δ·Υ, an error of Δ carried along by Ad(Υ⁻¹), those of Υ added.
    fn append(&mut self, step: &SGal3<S>, noise: &SMatrix<S, 9, 9>, d_bias: &SMatrix<S, 9, 6>) {
        let carry = step.inverse().adjoint().fixed_view::<9, 9>(0, 0).into_owned();
        let covariance = carry * self.covariance * carry.transpose() + noise;
        self.covariance = (covariance + covariance.transpose()) * S::lit(0.5);
        self.d_bias = carry * self.d_bias + d_bias;
        self.increment = self.increment.compose(step);
    }

    /// T, in seconds.
    pub fn duration(&self) -> S {
        self.increment.time()
    }

    /// Δ about the bias of the sum: rotation, position and velocity gained in a freely falling frame, seen from its start.
    pub fn increment(&self) -> SE23<S> {
        self.increment.extended_pose()
    }

    /// The bias about which samples were added.
    pub fn bias(&self) -> ImuBias<S> {
        self.bias
    }

    /// The densities of the samples' noise.
    pub fn noise(&self) -> ImuNoise<S> {
        self.noise
    }

    /// The sum with `f` applied to every number, e.g. to carry constants into dual numbers.
    pub fn map<T: Real>(&self, f: impl Fn(S) -> T) -> Preintegration<T> {
        Preintegration {
            increment: self.increment.map(&f),
            bias: self.bias.map(&f),
            noise: ImuNoise { gyro: f(self.noise.gyro), accel: f(self.noise.accel) },
            covariance: self.covariance.map(&f),
            d_bias: self.d_bias.map(&f),
        }
    }

    /// Σ, 9×9, of the local tangent (ρ, φ, ν) of Δ: m², rad², m²/s².
    pub fn covariance(&self) -> SMatrix<S, 9, 9> {
        self.covariance
    }

    /// D, 9×6: ∂Δ/∂b, local tangent (ρ, φ, ν), columns (b_g, b_a).
    pub fn d_increment_d_bias(&self) -> SMatrix<S, 9, 6> {
        self.d_bias
    }

    /// Δ(b) ≈ Δ·Exp(D·(b − b̂)): the increment if the bias had been `bias`, to first order, without the samples.
    pub fn corrected(&self, bias: &ImuBias<S>) -> SE23<S> {
        self.increment().rplus(&self.shift(bias))
    }

    /// Δ(b) with its derivative in b: `(value, d_value_d_bias)`, 9×6.
    pub fn corrected_jac(&self, bias: &ImuBias<S>) -> (SE23<S>, SMatrix<S, 9, 6>) {
        let (value, _, d_shift) = self.increment().rplus_jac(&self.shift(bias));
        (value, d_shift * self.d_bias)
    }

    fn shift(&self, bias: &ImuBias<S>) -> SVector<S, 9> {
        self.d_bias * (bias.vector() - self.bias.vector())
    }

    /// X_j = Γ·F(X_i)·Δ(b): where `from` is after the samples, under `gravity` in m/s² of the world frame.
    pub fn predict(&self, from: &SE23<S>, bias: &ImuBias<S>, gravity: &Vector3<S>) -> SE23<S> {
        self.falling(from, gravity).compose(&self.corrected(bias))
    }

    /// [`Preintegration::predict`]: `(value, d_value_d_from, d_value_d_bias, d_value_d_gravity)`, 9×9, 9×6 and 9×3.
    pub fn predict_jac(
        &self,
        from: &SE23<S>,
        bias: &ImuBias<S>,
        gravity: &Vector3<S>,
    ) -> (SE23<S>, SMatrix<S, 9, 9>, SMatrix<S, 9, 6>, SMatrix<S, 9, 3>) {
        let (increment, d_bias) = self.corrected_jac(bias);
        let (value, d_falling, _) = self.falling(from, gravity).compose_jac(&increment);
        (value, d_falling * self.drift(), d_bias, d_falling * self.fall(from))
    }

    /// r = Log(Δ(b)⁻¹·F(X_i)⁻¹·Γ⁻¹·X_j), local tangent (ρ, φ, ν), to be weighed with Σ⁻¹: what the states say of Δ, less Δ.
    pub fn residual(
        &self,
        from: &SE23<S>,
        to: &SE23<S>,
        bias: &ImuBias<S>,
        gravity: &Vector3<S>,
    ) -> SVector<S, 9> {
        self.falling(from, gravity).between(to).rminus(&self.corrected(bias))
    }

    /// [`Preintegration::residual`]: `(r, d_r_d_from, d_r_d_to, d_r_d_bias, d_r_d_gravity)`, 9×9, 9×9, 9×6 and 9×3.
    pub fn residual_jac(
        &self,
        from: &SE23<S>,
        to: &SE23<S>,
        bias: &ImuBias<S>,
        gravity: &Vector3<S>,
    ) -> (SVector<S, 9>, SMatrix<S, 9, 9>, SMatrix<S, 9, 9>, SMatrix<S, 9, 6>, SMatrix<S, 9, 3>) {
        let (increment, d_bias) = self.corrected_jac(bias);
        let (said, d_falling, _) = self.falling(from, gravity).between_jac(to);
        let (r, d_said, d_increment) = said.rminus_jac(&increment);
        let d_falling = d_said * d_falling;
        (r, d_falling * self.drift(), d_said, d_increment * d_bias, d_falling * self.fall(from))
    }

    /// Γ·F(X): X after T in free fall.
    fn falling(&self, from: &SE23<S>, gravity: &Vector3<S>) -> SE23<S> {
        let (t, half) = (self.duration(), S::lit(0.5));
        let position = from.position() + from.velocity() * t + gravity * (half * t * t);
        SE23::new(from.rotation(), position, from.velocity() + gravity * t)
    }

    /// ∂(Γ·F(X))/∂g, 9×3, local: ½T²Rᵀ in ρ, T·Rᵀ in ν.
    fn fall(&self, from: &SE23<S>) -> SMatrix<S, 9, 3> {
        let (t, back) = (self.duration(), from.rotation().inverse().to_matrix());
        let mut d_gravity = SMatrix::<S, 9, 3>::zeros();
        d_gravity.fixed_view_mut::<3, 3>(0, 0).copy_from(&(back * (t * t * S::lit(0.5))));
        d_gravity.fixed_view_mut::<3, 3>(6, 0).copy_from(&(back * t));
        d_gravity
    }

    /// F, 9×9: the local error of Γ·F(X) by that of X, exact for errors of any size: T·I in (ρ, ν). Barrau & Bonnabel (2017).
    fn drift(&self) -> SMatrix<S, 9, 9> {
        let mut f = SMatrix::<S, 9, 9>::identity();
        for i in 0..3 {
            f[(i, i + 6)] = self.duration();
        }
        f
    }
}
