//! Vehicles with sensors, simulated, to try filters on.

use super::consistency::{ConsistencyError, MonteCarlo, Report, Run};
use super::models::{
    Attitude, DifferentialDrive, Gyroscope, Imu, ImuNoise, Inertial, InertialState, Odometry, Part,
    PositionFix, RangeBearing, Sighting, VectorSighting, VelocityFix, WheelTravel,
};
use super::{Ekf, Filter, FilterError, Measurement, Motion, Ukf};
use crate::lie::{Action, LieGroup, Rn, SE2, SE3, SE23, SO3};
use crate::uncertainty::{Covariance, Gaussian, Side};
use core::{fmt, str::FromStr};
use nalgebra::{SVector, Vector2, Vector3, vector};
use rand::{Rng, SeedableRng};

/// A vehicle with sensors, simulated: a truth drawn from the prior moves by its model with noise drawn from it, and is
/// measured with noise of the size that sensors state.
///
/// So everything that a filter assumes is true, and what NEES and NIS say is about the filter alone.
///
/// ```
/// use boxplus::filter::{MonteCarlo, Rule, Simulation, Trial, Verdict};
/// use rand_chacha::ChaCha8Rng;
/// let experiment = MonteCarlo { runs: 50, ..MonteCarlo::default() };
/// let world: Simulation = "beacons".parse()?;
/// let report = world.run::<ChaCha8Rng>(Trial::default(), &experiment, |_| true)?;
/// let state = report.series("state").ok_or("recorded")?;
/// assert_eq!((state.dimension, state.verdict()), (3, Verdict::Consistent));
/// // Without the reset of the covariance, and linearised once: overconfident.
/// let plain = Trial { rule: Rule::Extended, reset: false, ..Trial::default() };
/// assert!(world.run::<ChaCha8Rng>(plain, &experiment, |_| true)?.series("state").ok_or("recorded")?.mean > state.mean);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Simulation {
    /// Odometry on SE(2), ranges and bearings of three beacons; the start is unknown by 2 m and 45°.
    Beacons,
    /// Odometry on SE(3), three landmarks seen in the frame of the body.
    Landmarks,
    /// Two driven wheels, position fixes.
    Wheels,
    /// A gyroscope with a bias, an accelerometer at rest, a magnetometer.
    Attitude,
    /// An inertial sensor with biases, fixes of position and velocity.
    Gnss,
    /// An inertial sensor with biases, three landmarks.
    Inertial,
}

/// Which rule corrects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rule {
    /// [`Ekf`], linearised once.
    Extended,
    /// [`Ekf`], linearised until it settles.
    #[default]
    Iterated,
    /// [`Ukf`].
    Unscented,
}

/// The filter that is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trial {
    /// How it corrects.
    pub rule: Rule,
    /// Whether errors are global (right-invariant) instead of local (left-invariant).
    pub global: bool,
    /// Whether the covariance is told about the new mean after a correction.
    pub reset: bool,
}

impl Default for Trial {
    /// Iterated, local, with reset.
    fn default() -> Self {
        Self { rule: Rule::default(), global: false, reset: true }
    }
}

impl Simulation {
    /// Every simulation.
    pub const ALL: [Self; 6] =
        [Self::Beacons, Self::Landmarks, Self::Wheels, Self::Attitude, Self::Gnss, Self::Inertial];

    /// Its name, as [`FromStr`] takes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Beacons => "beacons",
            Self::Landmarks => "landmarks",
            Self::Wheels => "wheels",
            Self::Attitude => "attitude",
            Self::Gnss => "gnss",
            Self::Inertial => "inertial",
        }
    }

    /// One line about it.
    pub fn description(self) -> &'static str {
        match self {
            Self::Beacons => "odometry in the plane, ranges and bearings of three beacons",
            Self::Landmarks => "odometry in space, three landmarks seen",
            Self::Wheels => "two driven wheels, position fixes",
            Self::Attitude => "gyroscope with bias, accelerometer, magnetometer",
            Self::Gnss => "inertial sensor with biases, fixes of position and velocity",
            Self::Inertial => "inertial sensor with biases, three landmarks seen",
        }
    }

    /// The coordinates of the error of its state, with their units.
    pub fn coordinates(self) -> &'static [&'static str] {
        const INERTIAL: [&str; 15] = [
            "ρ₁ m",
            "ρ₂ m",
            "ρ₃ m",
            "φ₁ rad",
            "φ₂ rad",
            "φ₃ rad",
            "ν₁ m/s",
            "ν₂ m/s",
            "ν₃ m/s",
            "b_g₁ rad/s",
            "b_g₂ rad/s",
            "b_g₃ rad/s",
            "b_a₁ m/s²",
            "b_a₂ m/s²",
            "b_a₃ m/s²",
        ];
        match self {
            Self::Beacons | Self::Wheels => &["ρ₁ m", "ρ₂ m", "θ rad"],
            Self::Landmarks => &INERTIAL[..6],
            Self::Attitude => &["φ₁ rad", "φ₂ rad", "φ₃ rad", "b₁ rad/s", "b₂ rad/s", "b₃ rad/s"],
            Self::Gnss | Self::Inertial => &INERTIAL,
        }
    }

    /// A filter on it, many times: NEES of the state under the name `state`, NIS under the names of the sensors.
    ///
    /// `proceed` is asked before each run, with the number of runs that are finished, see [`MonteCarlo::run_while`].
    ///
    /// # Errors
    /// Those of [`MonteCarlo::run`].
    pub fn run<R: SeedableRng + Rng>(
        self,
        trial: Trial,
        experiment: &MonteCarlo,
        proceed: impl Fn(usize) -> bool + Sync,
    ) -> Result<Report, ConsistencyError> {
        let all = All { trial, experiment, proceed, rng: core::marker::PhantomData::<fn() -> R> };
        match self {
            Self::Beacons => all.of(&beacons()),
            Self::Landmarks => all.of(&landmarks()),
            Self::Wheels => all.of(&wheels()),
            Self::Attitude => all.of(&attitude()),
            Self::Gnss => all.of(&inertial(Aid::Gnss)),
            Self::Inertial => all.of(&inertial(Aid::Landmarks)),
        }
    }
}

impl fmt::Display for Simulation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is none of [`Simulation::ALL`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no such simulation; choose beacons, landmarks, wheels, attitude, gnss or inertial")]
pub struct UnknownSimulation;

impl FromStr for Simulation {
    type Err = UnknownSimulation;

    fn from_str(name: &str) -> Result<Self, UnknownSimulation> {
        Self::ALL.into_iter().find(|world| world.name() == name).ok_or(UnknownSimulation)
    }
}

/// A vehicle, its sensors apart.
struct World<G: LieGroup<D>, M: Motion<G, D, W>, Z, const D: usize, const W: usize> {
    start: Gaussian<G, D>,
    motion: M,
    steps: usize,
    input: fn(usize) -> M::Input,
    sensors: Z,
}

/// What the sensors of a vehicle make of a belief at step k.
trait Sensors<G: LieGroup<D>, const D: usize>: Sync {
    fn correct<E: Side, F: Filter>(
        &self,
        k: usize,
        truth: &G,
        watch: &mut Watch<'_, F, impl Rng>,
        belief: Gaussian<G, D, E>,
    ) -> Gaussian<G, D, E>;
}

/// A filter with its random numbers and its record.
struct Watch<'a, F, R> {
    filter: &'a F,
    rng: &'a mut R,
    run: &'a mut Run,
}

impl<F: Filter, R: Rng> Watch<'_, F, R> {
    /// An error of a sensor.
    fn error<const N: usize>(&mut self, noise: &Covariance<N>) -> SVector<f64, N> {
        Gaussian::<Rn<N>, N>::new(Rn::new(SVector::zeros()), *noise).sample(self.rng).vector()
    }

    /// The belief after a measurement, its innovation recorded.
    fn update<G: LieGroup<D>, Z: Measurement<G, D, M>, E: Side, const D: usize, const M: usize>(
        &mut self,
        name: &'static str,
        belief: &Gaussian<G, D, E>,
        measurement: &Z,
    ) -> Gaussian<G, D, E> {
        let update = self.filter.update(belief, measurement);
        self.run.innovation(name, &update);
        update.belief
    }
}

/// All runs of an experiment.
struct All<'a, P, R> {
    trial: Trial,
    experiment: &'a MonteCarlo,
    proceed: P,
    rng: core::marker::PhantomData<R>,
}

impl<P: Fn(usize) -> bool + Sync, R: SeedableRng + Rng> All<'_, P, fn() -> R> {
    fn of<G, M, Z, const D: usize, const W: usize>(
        &self,
        world: &World<G, M, Z, D, W>,
    ) -> Result<Report, ConsistencyError>
    where
        G: LieGroup<D, Scalar = f64> + Sync,
        M: Motion<G, D, W> + Sync,
        Z: Sensors<G, D>,
    {
        let Trial { rule, global, reset } = self.trial;
        let ekf = Ekf { reset, iterations: if rule == Rule::Iterated { 10 } else { 1 }, ..Ekf::default() };
        let ukf = Ukf { reset, ..Ukf::default() };
        let opposite = world.start.to_global();
        let report = self.experiment.run_while(&self.proceed, |rng: &mut R, run| match (rule, global) {
            (Rule::Unscented, false) => world.once(world.start, Watch { filter: &ukf, rng, run }),
            (Rule::Unscented, true) => world.once(opposite, Watch { filter: &ukf, rng, run }),
            (_, false) => world.once(world.start, Watch { filter: &ekf, rng, run }),
            (_, true) => world.once(opposite, Watch { filter: &ekf, rng, run }),
        });
        report.map(|mut report| {
            report.series.sort_by_key(|series| series.name != "state");
            report
        })
    }
}

impl<G, M, Z, const D: usize, const W: usize> World<G, M, Z, D, W>
where
    G: LieGroup<D, Scalar = f64>,
    M: Motion<G, D, W>,
    Z: Sensors<G, D>,
{
    /// One run, from a belief that says the same as the start.
    fn once<E: Side, F: Filter>(
        &self,
        mut belief: Gaussian<G, D, E>,
        mut watch: Watch<'_, F, impl Rng>,
    ) -> Result<(), FilterError> {
        let mut truth = self.start.sample(watch.rng);
        for k in 1..=self.steps {
            let input = (self.input)(k);
            let disturbance = watch.error(&self.motion.noise(&input));
            truth = self.motion.step(&truth, &input, &disturbance);
            belief = watch.filter.predict(&belief, &self.motion, &input)?;
            belief = self.sensors.correct(k, &truth, &mut watch, belief);
            watch.run.state("state", &truth, &belief);
        }
        Ok(())
    }
}

/// Independent coordinates.
fn sigmas<const D: usize>(values: [f64; D]) -> Covariance<D> {
    Covariance::independent(&values.into())
}

/// Vectors of three coordinates, those of each of one standard deviation.
fn triples<const D: usize>(values: &[f64]) -> Covariance<D> {
    Covariance::independent(&SVector::from_fn(|i, _| values[i / 3]))
}

struct Beacons([Vector2<f64>; 3]);

fn beacons() -> World<SE2, Odometry<3>, Beacons, 3, 3> {
    World {
        start: Gaussian::new(SE2::identity(), sigmas([2.0, 2.0, 0.8])),
        motion: Odometry { noise: sigmas([0.05, 0.02, 0.02]) },
        steps: 60,
        input: |_| vector![0.5, 0.0, 0.1],
        sensors: Beacons([vector![9.0, 2.0], vector![-6.0, 7.0], vector![2.0, -8.0]]),
    }
}

impl Sensors<SE2, 3> for Beacons {
    fn correct<E: Side, F: Filter>(
        &self,
        k: usize,
        truth: &SE2,
        watch: &mut Watch<'_, F, impl Rng>,
        belief: Gaussian<SE2, 3, E>,
    ) -> Gaussian<SE2, 3, E> {
        let (beacon, noise) = (self.0[k % 3], sigmas([0.1, 0.02]));
        let seen = truth.act_inverse(&beacon);
        let measured = vector![seen.norm(), seen.y.atan2(seen.x)] + watch.error(&noise);
        watch.update("range and bearing", &belief, &RangeBearing { beacon, measured, noise })
    }
}

struct Landmarks {
    places: [Vector3<f64>; 3],
    noise: Covariance<3>,
}

impl Landmarks {
    fn new() -> Self {
        let places = [vector![0.0, 4.0, 4.0], vector![-4.0, -4.0, -3.0], vector![6.0, -4.0, 2.0]];
        Self { places, noise: Covariance::unit() * 0.1 }
    }

    fn sighting<F: Filter, const D: usize>(
        &self,
        k: usize,
        truth: &impl Action<D, 3, Scalar = f64>,
        watch: &mut Watch<'_, F, impl Rng>,
    ) -> Sighting<3> {
        let (landmark, noise) = (self.places[k % 3], self.noise);
        Sighting { landmark, measured: truth.act_inverse(&landmark) + watch.error(&noise), noise }
    }
}

fn landmarks() -> World<SE3, Odometry<6>, Landmarks, 6, 6> {
    World {
        start: Gaussian::new(SE3::identity(), triples(&[0.5, 0.3])),
        motion: Odometry { noise: triples(&[0.03, 0.02]) },
        steps: 60,
        input: |_| vector![0.3, 0.0, 0.02, 0.0, 0.02, 0.1],
        sensors: Landmarks::new(),
    }
}

impl Sensors<SE3, 6> for Landmarks {
    fn correct<E: Side, F: Filter>(
        &self,
        k: usize,
        truth: &SE3,
        watch: &mut Watch<'_, F, impl Rng>,
        belief: Gaussian<SE3, 6, E>,
    ) -> Gaussian<SE3, 6, E> {
        let sighting = self.sighting(k, truth, watch);
        watch.update("landmark", &belief, &sighting)
    }
}

struct Fixes;

fn wheels() -> World<SE2, DifferentialDrive, Fixes, 3, 3> {
    World {
        start: Gaussian::new(SE2::identity(), sigmas([0.5, 0.5, 0.3])),
        motion: DifferentialDrive { track: 0.4, rolling: 0.02, slip: 0.01 },
        steps: 200,
        input: |_| WheelTravel { left: 0.095, right: 0.105 },
        sensors: Fixes,
    }
}

impl Sensors<SE2, 3> for Fixes {
    fn correct<E: Side, F: Filter>(
        &self,
        k: usize,
        truth: &SE2,
        watch: &mut Watch<'_, F, impl Rng>,
        belief: Gaussian<SE2, 3, E>,
    ) -> Gaussian<SE2, 3, E> {
        if !k.is_multiple_of(5) {
            return belief;
        }
        let noise = sigmas([0.3, 0.3]);
        let fix = PositionFix::of_origin(truth.translation() + watch.error(&noise), noise);
        watch.update("position", &belief, &fix)
    }
}

struct Vectors;

fn attitude() -> World<Attitude, Gyroscope, Vectors, 6, 6> {
    World {
        start: Gaussian::new(Attitude::identity(), triples(&[0.3, 0.05])),
        motion: Gyroscope { noise: 5e-3, bias_walk: 1e-3 },
        steps: 200,
        input: |k| (vector![0.3, 0.2 * (0.05 * k as f64).sin(), 0.5], 0.05),
        sensors: Vectors,
    }
}

impl Sensors<Attitude, 6> for Vectors {
    fn correct<E: Side, F: Filter>(
        &self,
        _: usize,
        truth: &Attitude,
        watch: &mut Watch<'_, F, impl Rng>,
        belief: Gaussian<Attitude, 6, E>,
    ) -> Gaussian<Attitude, 6, E> {
        let sensors = [
            ("accelerometer", vector![0.0, 0.0, 9.81], 0.4),
            ("magnetometer", vector![0.3, 0.0, -0.95], 0.2),
        ];
        sensors.into_iter().fold(belief, |belief, (name, reference, sigma)| {
            let noise = Covariance::unit() * sigma;
            let measured = truth.rotation.act_inverse(&reference) + watch.error(&noise);
            let measurement = VectorSighting { reference, measured, noise };
            let of = |x: &Attitude| x.rotation;
            watch.update(name, &belief, &Part { measurement, of, block: Attitude::BLOCKS.rotation })
        })
    }
}

/// What helps an inertial sensor.
enum Aid {
    Gnss,
    Landmarks,
}

fn inertial(aid: Aid) -> World<InertialState, Inertial, Aid, 15, 12> {
    let noise =
        ImuNoise { gyroscope: 2e-3, accelerometer: 2e-2, gyroscope_bias: 1e-4, accelerometer_bias: 1e-3 };
    let motion = SE23::new(SO3::identity(), Vector3::zeros(), vector![1.0, 0.0, 0.0]);
    let unbiased = Rn::new(Vector3::zeros());
    let mean = InertialState { motion, gyroscope_bias: unbiased, accelerometer_bias: unbiased };
    World {
        start: Gaussian::new(mean, triples(&[0.5, 0.2, 0.3, 0.02, 0.1])),
        motion: Inertial::upright(noise),
        steps: 200,
        // A circle: the force points to its centre.
        input: |_| Imu {
            gyroscope: vector![0.0, 0.0, 0.4],
            accelerometer: vector![0.0, 0.4, super::models::STANDARD_GRAVITY],
            duration: 0.05,
        },
        sensors: aid,
    }
}

impl Sensors<InertialState, 15> for Aid {
    fn correct<E: Side, F: Filter>(
        &self,
        k: usize,
        truth: &InertialState,
        watch: &mut Watch<'_, F, impl Rng>,
        belief: Gaussian<InertialState, 15, E>,
    ) -> Gaussian<InertialState, 15, E> {
        let (of, block) = (|x: &InertialState| x.motion, InertialState::BLOCKS.motion);
        match self {
            Self::Landmarks if k.is_multiple_of(4) => {
                let measurement = Landmarks::new().sighting(k / 4, &truth.motion, watch);
                watch.update("landmark", &belief, &Part { measurement, of, block })
            }
            Self::Gnss if k.is_multiple_of(10) => {
                let (far, slow) = (Covariance::unit() * 0.5, Covariance::unit() * 0.1);
                let position = PositionFix::of_origin(truth.motion.position() + watch.error(&far), far);
                let belief = watch.update("position", &belief, &Part { measurement: position, of, block });
                let velocity =
                    VelocityFix { measured: truth.motion.velocity() + watch.error(&slow), noise: slow };
                watch.update("velocity", &belief, &Part { measurement: velocity, of, block })
            }
            _ => belief,
        }
    }
}
