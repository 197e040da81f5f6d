//! Inertial navigation on SE₂(3).

use crate::bundle;
use crate::filter::{Measurement, Motion};
use crate::lie::{Jacobian, LieGroup, Real, Rn, SE23, SGal3, SO3};
use crate::trajectory::Imu;
use crate::uncertainty::Covariance;
use nalgebra::{SMatrix, SVector, Vector3};

/// Standard gravity, in m/s².
pub const STANDARD_GRAVITY: f64 = 9.80665;

/// Continuous-time densities of an inertial sensor, as data sheets and Allan plots give them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImuNoise<S = f64> {
    /// Angular random walk, in rad/s/√Hz.
    pub gyroscope: S,
    /// Velocity random walk, in m/s²/√Hz.
    pub accelerometer: S,
    /// Random walk of the gyroscope's bias, in rad/s²/√Hz.
    pub gyroscope_bias: S,
    /// Random walk of the accelerometer's bias, in m/s³/√Hz.
    pub accelerometer_bias: S,
}

impl<S: Real> ImuNoise<S> {
    /// Of both readings, then of the changes of both biases, over a step of Δ: white noise is density/√Δ, a walk density·√Δ. NaN or
    /// infinite where Δ is not positive: the filter refuses it.
    fn sigmas(&self, duration: S) -> [S; 4] {
        let root = duration.simd_sqrt();
        let Self { gyroscope, accelerometer, gyroscope_bias, accelerometer_bias } = *self;
        [gyroscope / root, accelerometer / root, gyroscope_bias * root, accelerometer_bias * root]
    }
}

/// The extended pose X = (R, p, v) after Δ with constant readings, X⁺ = Γ·Φ_Δ(X)·Υ, and its Jacobians.
///
/// Υ = (Γ₀, Γ₁aΔ, Γ₂aΔ²) is the SGal(3) exponential of (0, ωΔ, aΔ, Δ): exact, no Euler step. Γ = (I, gΔ, ½gΔ²), Φ_Δ: p ← p + vΔ.
/// The local error moves by Ad_Υ⁻¹·F, the global one by Ad_Γ·F, F = I with Δ·I in (ρ, ν): exact for errors of any size (Barrau &
/// Bonnabel (2017)), the global one even independent of the state.
struct Increment<S> {
    upsilon: SE23<S>,
    gamma: SE23<S>,
    duration: S,
    argument: SVector<S, 10>,
}

impl<S: Real> Increment<S> {
    fn new(gravity: &Vector3<S>, omega: &Vector3<S>, force: &Vector3<S>, duration: S) -> Self {
        let mut argument = SVector::<S, 10>::zeros();
        argument.fixed_rows_mut::<3>(3).copy_from(&(omega * duration));
        argument.fixed_rows_mut::<3>(6).copy_from(&(force * duration));
        argument[9] = duration;
        let step = SGal3::exp(&argument);
        let fall = gravity * duration;
        Self {
            upsilon: SE23::new(step.rotation(), step.position(), step.velocity()),
            gamma: SE23::new(SO3::identity(), fall * (duration * S::lit(0.5)), fall),
            duration,
            argument,
        }
    }

    fn applied(&self, x: &SE23<S>) -> SE23<S> {
        let drifted = SE23::new(x.rotation(), x.position() + x.velocity() * self.duration, x.velocity());
        self.gamma.compose(&drifted).compose(&self.upsilon)
    }

    /// F.
    fn drift(&self) -> Jacobian<S, 9> {
        let mut f = Jacobian::<S, 9>::identity();
        (0..3).for_each(|i| f[(i, 6 + i)] = self.duration);
        f
    }

    /// ∂X⁺/∂X, local.
    fn d_state(&self) -> Jacobian<S, 9> {
        self.upsilon.inverse().adjoint() * self.drift()
    }

    /// ∂X⁺/∂X, global.
    fn d_state_left(&self) -> Jacobian<S, 9> {
        self.gamma.adjoint() * self.drift()
    }

    /// ∂X⁺/∂(ω, a), local, 9×6: Δ times the (φ, ν) columns of J_r of SGal(3).
    fn d_reading(&self) -> SMatrix<S, 9, 6> {
        SGal3::right_jacobian(&self.argument).fixed_view::<9, 6>(0, 3) * self.duration
    }
}

/// Inertial dead reckoning without biases: the state is SE₂(3), X = (R, p, v), tangent (ρ, φ, ν).
///
/// w = (gyroscope, accelerometer), 6: readings are ω + w_g and Rᵀ(a − g) + w_a. With biases: [`Inertial`].
///
/// ```
/// use boxplus::filter::{DeadReckoning, Imu, ImuNoise, Motion};
/// use boxplus::lie::{LieGroup, SE23};
/// use nalgebra::{SVector, Vector3};
/// let model = DeadReckoning::upright(ImuNoise::default());
/// let at_rest = Imu {
///     gyroscope: Vector3::zeros(),
///     accelerometer: -model.gravity,
///     duration: 0.01,
/// };
/// let x: SE23 = SE23::identity();
/// assert!(model.step(&x, &at_rest, &SVector::zeros()).rminus(&x).norm() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeadReckoning<S = f64> {
    /// g, in m/s² of the world: (0, 0, −9.81) where z points up.
    pub gravity: Vector3<S>,
    /// Of the sensor; its biases are not part of this model.
    pub noise: ImuNoise<S>,
}

impl<S: Real> DeadReckoning<S> {
    /// In a world whose z axis points up, at standard gravity.
    pub fn upright(noise: ImuNoise<S>) -> Self {
        Self { gravity: Vector3::new(S::zero(), S::zero(), S::lit(-STANDARD_GRAVITY)), noise }
    }

    fn increment(&self, imu: &Imu<S>) -> Increment<S> {
        Increment::new(&self.gravity, &imu.gyroscope, &imu.accelerometer, imu.duration)
    }
}

impl<S: Real> Motion<SE23<S>, 9, 6> for DeadReckoning<S> {
    type Input = Imu<S>;

    fn step(&self, x: &SE23<S>, imu: &Imu<S>, w: &SVector<S, 6>) -> SE23<S> {
        let omega = imu.gyroscope - w.fixed_rows::<3>(0);
        let force = imu.accelerometer - w.fixed_rows::<3>(3);
        Increment::new(&self.gravity, &omega, &force, imu.duration).applied(x)
    }
    fn noise(&self, imu: &Imu<S>) -> Covariance<6, S> {
        let [gyroscope, accelerometer, ..] = self.noise.sigmas(imu.duration);
        Covariance::independent(&SVector::from_fn(|i, _| [gyroscope, accelerometer][i / 3]))
    }
    fn step_jac(&self, x: &SE23<S>, imu: &Imu<S>) -> (SE23<S>, Jacobian<S, 9>, SMatrix<S, 9, 6>) {
        let step = self.increment(imu);
        (step.applied(x), step.d_state(), -step.d_reading())
    }
    fn step_left_jac(&self, x: &SE23<S>, imu: &Imu<S>) -> (SE23<S>, Jacobian<S, 9>, SMatrix<S, 9, 6>) {
        let step = self.increment(imu);
        let next = step.applied(x);
        (next, step.d_state_left(), -(next.adjoint() * step.d_reading()))
    }
}

bundle! {
    /// A body that navigates by an inertial sensor: extended pose and the sensor's biases, tangent (ρ, φ, ν, b_g, b_a).
    pub struct InertialState {
        /// world_from_body and the velocity in the world.
        pub motion: SE23 [9],
        /// b_g, in rad/s: what the gyroscope shows at rest.
        pub gyroscope_bias: Rn<3> [3],
        /// b_a, in m/s²: what the accelerometer shows beyond the specific force.
        pub accelerometer_bias: Rn<3> [3],
    }
}

/// Inertial navigation with biases: [`InertialState`], readings ω + b_g + w_g and Rᵀ(a − g) + b_a + w_a, biases that wander.
///
/// w = (gyroscope, accelerometer, change of b_g, change of b_a), 12. With a `Global` belief this is the imperfect invariant
/// filter: biases couple to the state through Ad_X̂, the rest stays free of it.
///
/// ```
/// use boxplus::filter::{Ekf, Filter, Imu, ImuNoise, Inertial, InertialState, Part, PositionFix};
/// use boxplus::lie::LieGroup;
/// use boxplus::uncertainty::{Covariance, Gaussian, Global};
/// use nalgebra::{SVector, Vector3, vector};
/// let noise = ImuNoise { gyroscope: 1e-3, accelerometer: 1e-2, gyroscope_bias: 1e-5, accelerometer_bias: 1e-4 };
/// let model = Inertial::upright(noise);
/// let start = Gaussian::<InertialState, 15, Global>::from_sigmas(InertialState::identity(), &SVector::repeat(0.05))?;
/// let imu = Imu { gyroscope: Vector3::zeros(), accelerometer: vector![0.1, 0.0, 9.81], duration: 0.01 };
/// let moved = Ekf::default().predict(&start, &model, &imu)?;
/// let gnss = Part {
///     measurement: PositionFix::of_origin(vector![0.01, 0.0, 0.0], Covariance::from_sigmas(&Vector3::repeat(0.02))?),
///     of: |x: &InertialState| x.motion,
///     block: InertialState::BLOCKS.motion,
/// };
/// assert!(Ekf::default().update(&moved, &gnss).is_accepted());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertial<S = f64> {
    /// g, in m/s² of the world: (0, 0, −9.81) where z points up.
    pub gravity: Vector3<S>,
    /// Of the sensor.
    pub noise: ImuNoise<S>,
}

impl<S: Real> Inertial<S> {
    /// In a world whose z axis points up, at standard gravity.
    pub fn upright(noise: ImuNoise<S>) -> Self {
        Self { gravity: DeadReckoning::upright(noise).gravity, noise }
    }

    fn increment(&self, x: &InertialState<S>, imu: &Imu<S>, w: &SVector<S, 12>) -> Increment<S> {
        let omega = imu.gyroscope - x.gyroscope_bias.vector() - w.fixed_rows::<3>(0);
        let force = imu.accelerometer - x.accelerometer_bias.vector() - w.fixed_rows::<3>(3);
        Increment::new(&self.gravity, &omega, &force, imu.duration)
    }

    fn moved(x: &InertialState<S>, step: &Increment<S>, w: &SVector<S, 12>) -> InertialState<S> {
        let wandered = |bias: &Rn<3, S>, k: usize| Rn::new(bias.vector() + w.fixed_rows::<3>(k));
        InertialState {
            motion: step.applied(&x.motion),
            gyroscope_bias: wandered(&x.gyroscope_bias, 6),
            accelerometer_bias: wandered(&x.accelerometer_bias, 9),
        }
    }

    /// F and G from their blocks: a reading enters as its bias does, with the opposite sign of the reading.
    fn assembled(
        d_motion: &Jacobian<S, 9>,
        d_reading: &SMatrix<S, 9, 6>,
    ) -> (Jacobian<S, 15>, SMatrix<S, 15, 12>) {
        let (mut f, mut g) = (Jacobian::<S, 15>::identity(), SMatrix::<S, 15, 12>::zeros());
        f.fixed_view_mut::<9, 9>(0, 0).copy_from(d_motion);
        f.fixed_view_mut::<9, 6>(0, 9).copy_from(&-d_reading);
        g.fixed_view_mut::<9, 6>(0, 0).copy_from(&-d_reading);
        g.fixed_view_mut::<6, 6>(9, 6).fill_with_identity();
        (f, g)
    }
}

impl<S: Real> Motion<InertialState<S>, 15, 12> for Inertial<S> {
    type Input = Imu<S>;

    fn step(&self, x: &InertialState<S>, imu: &Imu<S>, w: &SVector<S, 12>) -> InertialState<S> {
        Self::moved(x, &self.increment(x, imu, w), w)
    }
    fn noise(&self, imu: &Imu<S>) -> Covariance<12, S> {
        let sigmas = self.noise.sigmas(imu.duration);
        Covariance::independent(&SVector::from_fn(|i, _| sigmas[i / 3]))
    }
    fn step_jac(
        &self,
        x: &InertialState<S>,
        imu: &Imu<S>,
    ) -> (InertialState<S>, Jacobian<S, 15>, SMatrix<S, 15, 12>) {
        let still = SVector::zeros();
        let step = self.increment(x, imu, &still);
        let (f, g) = Self::assembled(&step.d_state(), &step.d_reading());
        (Self::moved(x, &step, &still), f, g)
    }
    fn step_left_jac(
        &self,
        x: &InertialState<S>,
        imu: &Imu<S>,
    ) -> (InertialState<S>, Jacobian<S, 15>, SMatrix<S, 15, 12>) {
        let still = SVector::zeros();
        let step = self.increment(x, imu, &still);
        let next = Self::moved(x, &step, &still);
        let (f, g) = Self::assembled(&step.d_state_left(), &(next.motion.adjoint() * step.d_reading()));
        (next, f, g)
    }
}

/// A velocity in the world, as GNSS receivers give it: y = v + n. Of an [`SE23`], or of a bundle by
/// [`Part`](super::Part).
///
/// ```text
/// H local  [0, 0, R]      global  [0, −v^, I]
/// ```
///
/// ```
/// use boxplus::filter::{VelocityFix, check_measurement};
/// use boxplus::lie::{LieGroup, SE23};
/// use boxplus::uncertainty::Covariance;
/// use nalgebra::{SVector, vector};
/// let fix = VelocityFix { measured: vector![1.0, 0.0, 0.1], noise: Covariance::unit() * 0.1 }; // m/s
/// assert!(check_measurement(&fix, &SE23::exp(&SVector::repeat(0.3))) < 1e-8);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityFix<S = f64> {
    /// y, in m/s of the world.
    pub measured: Vector3<S>,
    /// Of y.
    pub noise: Covariance<3, S>,
}

impl<S: Real> Measurement<SE23<S>, 9, 3> for VelocityFix<S> {
    fn innovation(&self, x: &SE23<S>) -> Vector3<S> {
        self.measured - x.velocity()
    }
    fn noise(&self) -> Covariance<3, S> {
        self.noise
    }
    fn innovation_jac(&self, x: &SE23<S>) -> (Vector3<S>, SMatrix<S, 3, 9>) {
        let mut h = SMatrix::<S, 3, 9>::zeros();
        h.fixed_view_mut::<3, 3>(0, 6).copy_from(&x.rotation().to_matrix());
        (self.innovation(x), h)
    }
    fn innovation_left_jac(&self, x: &SE23<S>) -> (Vector3<S>, SMatrix<S, 3, 9>) {
        let mut h = SMatrix::<S, 3, 9>::zeros();
        h.fixed_view_mut::<3, 3>(0, 3).copy_from(&-SO3::hat(&x.velocity()));
        h.fixed_view_mut::<3, 3>(0, 6).fill_with_identity();
        (self.innovation(x), h)
    }
}
