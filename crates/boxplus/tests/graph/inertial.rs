//! Inertial navigation as a graph: simulated flights, judged by the NEES of what is estimated.

use boxplus::graph::{
    Between, Graph, Inertial, InertialUnderGravity, Key, Noise, Position, Prior, SolveOptions, Values,
    Velocity, inertial_start,
};
use boxplus::lie::{LieGroup, Manifold, Rn, S2, SE23};
use boxplus::trajectory::{Imu, ImuBias, ImuNoise, Preintegration};
use boxplus::uncertainty::Gaussian;
use nalgebra::{DMatrix, DVector, SVector, Vector3, Vector6, vector};
use rand_chacha::ChaCha8Rng;

use crate::world::rng;

const DENSITY: ImuNoise = ImuNoise { gyro: 2e-3, accel: 2e-2 };
/// Of the bias, in rad/s and m/s² per √s.
const WALK: [f64; 2] = [2e-3, 1e-2];
const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);
/// The antenna, in the body.
const LEVER: Vector3<f64> = Vector3::new(0.3, -0.2, 0.5);
/// Of a position, in metres.
const FIX: f64 = 0.1;
/// Samples between two states, and their duration.
const SAMPLES: usize = 20;
const STEP: f64 = 0.02;

fn normal<const D: usize>(rng: &mut ChaCha8Rng) -> SVector<f64, D> {
    let unit = Gaussian::<Rn<D>, D>::from_sigmas(Rn::identity(), &SVector::repeat(1.0)).unwrap();
    unit.sample(rng).vector()
}

/// What was so, and what the sensors showed.
struct Flight {
    states: Vec<SE23>,
    biases: Vec<ImuBias>,
    samples: Vec<Vec<Imu>>,
    fixes: Vec<Vector3<f64>>,
    /// Of the first bias, in multiples of [`bias_sigmas`].
    spread: f64,
}

/// A flight with turns about all axes; between states the bias wanders.
fn flight(seed: u64, count: usize, spread: f64) -> Flight {
    let mut rng = rng(seed);
    let start = SE23::exp(&(normal::<9>(&mut rng) * 0.5));
    let first = normal::<6>(&mut rng).component_mul(&bias_sigmas()) * spread;
    let mut flight = Flight {
        states: vec![start],
        biases: vec![ImuBias::exp(&first)],
        samples: vec![],
        fixes: vec![],
        spread,
    };
    for k in 0..count {
        let (state, bias) = (flight.states[k], flight.biases[k]);
        let (mut clean, mut shown) = (vec![], vec![]);
        for i in 0..SAMPLES {
            let t = (k * SAMPLES + i) as f64 * STEP;
            let gyroscope = vector![(1.1 * t).sin(), (0.7 * t).cos(), 0.5 * (0.4 * t).sin()];
            // Held up against gravity, more or less, and pushed.
            let accelerometer = vector![2.0 * (0.9 * t).cos(), 2.0 * (1.3 * t).sin(), 9.0 + (0.5 * t).sin()];
            clean.push(Imu { gyroscope, accelerometer, duration: STEP });
            let n = normal::<6>(&mut rng) / STEP.sqrt();
            shown.push(Imu {
                gyroscope: gyroscope + bias.gyro() + n.fixed_rows::<3>(0) * DENSITY.gyro,
                accelerometer: accelerometer + bias.accel() + n.fixed_rows::<3>(3) * DENSITY.accel,
                duration: STEP,
            });
        }
        let sum = Preintegration::of(&clean, ImuBias::zero(), DENSITY).unwrap();
        flight.states.push(sum.predict(&state, &ImuBias::zero(), &GRAVITY));
        flight.samples.push(shown);
        let step = walk_sigmas().component_mul(&normal::<6>(&mut rng));
        flight.biases.push(bias.rplus(&step));
    }
    let seen = |x: &SE23| x.pose() * LEVER;
    flight.fixes = flight.states.iter().map(|x| seen(x) + normal::<3>(&mut rng) * FIX).collect();
    flight
}

/// Of the first bias.
fn bias_sigmas() -> Vector6<f64> {
    Vector6::from_fn(|i, _| [0.02, 0.2][i / 3])
}

/// Of the walk of the bias from one state to the next.
fn walk_sigmas() -> Vector6<f64> {
    let root = (SAMPLES as f64 * STEP).sqrt();
    Vector6::from_fn(|i, _| WALK[i / 3] * root)
}

/// How gravity enters.
#[derive(Clone, Copy, PartialEq)]
enum Gravity {
    Known,
    Direction,
}

struct Problem {
    graph: Graph,
    values: Values,
    states: Vec<Key<SE23>>,
    biases: Vec<Key<ImuBias>>,
    down: Key<S2>,
}

/// Positions with a lever arm, inertial sums about `about`, a walk of the bias; a prior on the first state and bias.
fn problem(flight: &Flight, seed: u64, gravity: Gravity, about: &[ImuBias]) -> Problem {
    let mut rng = rng(1000 + seed);
    let mut values = Values::new();
    let sigmas = SVector::<f64, 9>::from_fn(|i, _| [0.5, 0.2, 0.5][i / 3]);
    let mut mean = flight.states[0].rplus(&sigmas.component_mul(&normal(&mut rng)));
    let prior = Prior { mean };

    let mut states = vec![values.insert(mean)];
    for samples in &flight.samples {
        let sum = Preintegration::of(samples, ImuBias::zero(), DENSITY).unwrap();
        mean = sum.predict(&mean, &ImuBias::zero(), &GRAVITY);
        states.push(values.insert(mean));
    }
    let biases = flight.biases.iter().map(|_| values.insert(ImuBias::zero())).collect();
    let down = values.insert(S2::from_vector(&vector![0.1, -0.1, -1.0]).unwrap());
    let mut problem = Problem { graph: Graph::new(), values, states, biases, down };
    problem.graph.add((problem.states[0],), prior, Noise::from_sigmas(&sigmas).unwrap());
    add_inertial(&mut problem, flight, gravity, about);
    add_fixes(&mut problem, flight);
    problem
}

fn add_inertial(problem: &mut Problem, flight: &Flight, gravity: Gravity, about: &[ImuBias]) {
    let Problem { graph, states, biases, down, .. } = problem;
    let spread = bias_sigmas() * flight.spread;
    graph.add((biases[0],), Prior { mean: ImuBias::zero() }, Noise::from_sigmas(&spread).unwrap());
    for (k, samples) in flight.samples.iter().enumerate() {
        let imu = Inertial::new(samples, about[k], DENSITY, GRAVITY).unwrap();
        let noise = imu.noise().unwrap();
        if gravity == Gravity::Known {
            graph.add((states[k], states[k + 1], biases[k]), imu, noise);
        } else {
            let imu = InertialUnderGravity::new(samples, about[k], DENSITY, 9.81).unwrap();
            graph.add((states[k], states[k + 1], biases[k], *down), imu, noise);
        }
        let walk = Noise::from_sigmas(&walk_sigmas()).unwrap();
        graph.add((biases[k], biases[k + 1]), Between::new(ImuBias::zero()), walk);
    }
}

fn add_fixes(problem: &mut Problem, flight: &Flight) {
    let noise = Noise::from_sigmas(&Vector3::repeat(FIX)).unwrap();
    for (state, measured) in problem.states.iter().zip(&flight.fixes) {
        problem.graph.add((*state,), Position::of_point(*measured, LEVER), noise);
    }
}

/// Until the sums are off by no more than `largest` standard deviations.
fn solve(problem: &mut Problem, largest: f64) -> (Values, usize) {
    let mut rounds = 1;
    let mut solution = problem.graph.optimize(&problem.values, &SolveOptions::default()).unwrap();
    while problem.graph.renew(&solution.values).unwrap().largest > largest {
        solution = problem.graph.optimize(&solution.values, &SolveOptions::default()).unwrap();
        rounds += 1;
    }
    assert!(solution.report.converged(), "{:?}", solution.report);
    (solution.values, rounds)
}

fn nees(error: &DVector<f64>, covariance: &DMatrix<f64>) -> f64 {
    error.dot(&covariance.clone().cholesky().unwrap().solve(error))
}

fn dynamic<const D: usize>(error: SVector<f64, D>) -> DVector<f64> {
    DVector::from_column_slice(error.as_slice())
}

/// Average NEES of state and bias together, 15, over many flights, at the start, in the middle and at the end.
fn is_consistent(gravity: Gravity) {
    const RUNS: u64 = 60;
    let mut sums = [0.0; 4];
    for seed in 0..RUNS {
        let flight = flight(seed, 15, 1.0);
        let mut problem = problem(&flight, seed, gravity, &[ImuBias::zero(); 16]);
        let (values, _) = solve(&mut problem, 0.05);
        let mut marginals = problem.graph.marginals(&values).unwrap();
        for (sum, k) in sums.iter_mut().zip([0, 7, 14]) {
            let (x, b) = (problem.states[k], problem.biases[k]);
            let error = flight.states[k].rminus(values.get(x).unwrap());
            let off = flight.biases[k].rminus(values.get(b).unwrap());
            let both = DVector::from_iterator(15, error.iter().chain(off.iter()).copied());
            *sum += nees(&both, &marginals.joint(&[x.into(), b.into()]).unwrap());
        }
        if gravity == Gravity::Direction {
            let error = S2::from_vector(&GRAVITY).unwrap().minus(values.get(problem.down).unwrap());
            sums[3] += nees(&dynamic(error), &marginals.covariance(problem.down).unwrap());
        }
    }
    // N·ANEES ~ χ² with 15N (2N) degrees of freedom: mean 15 (2), deviation √(30/N) (√(4/N)); four of them are allowed.
    let runs = RUNS as f64;
    for sum in &sums[..3] {
        assert!((sum / runs - 15.0).abs() < 4.0 * (30.0 / runs).sqrt(), "{sums:?}");
    }
    let expected = if gravity == Gravity::Direction { 2.0 } else { 0.0 };
    assert!((sums[3] / runs - expected).abs() < 4.0 * (4.0 / runs).sqrt(), "{sums:?}");
}

#[test]
fn flights_with_positions_are_as_sure_as_they_claim() {
    is_consistent(Gravity::Known);
}

#[test]
fn the_direction_of_gravity_is_estimated_as_surely_as_claimed() {
    is_consistent(Gravity::Direction);
}

#[test]
fn sums_made_about_a_bias_far_off_end_where_those_about_the_true_one_do() {
    let flight = flight(3, 15, 20.0);
    let at = |estimate: &Values, problem: &Problem| *estimate.get(problem.states[9]).unwrap();
    let mut near = problem(&flight, 3, Gravity::Known, &flight.biases);
    let (wanted, _) = solve(&mut near, 1e-4);
    let mut far = problem(&flight, 3, Gravity::Known, &[ImuBias::zero(); 16]);
    let once = far.graph.optimize(&far.values, &SolveOptions::default()).unwrap().values;
    let (estimate, rounds) = solve(&mut far, 1e-4);

    let off = |estimate: &Values| at(estimate, &far).rminus(&at(&wanted, &near)).amax();
    let (once, estimated) = (off(&once), off(&estimate));
    assert!(rounds > 1 && once > 1e-3 && estimated < 1e-5, "{rounds} rounds, {once:.1e}, {estimated:.1e}");
    let renewal = far.graph.renew(&estimate).unwrap();
    assert!(renewal.factors == 15 && renewal.largest < 1e-4, "{renewal:?}");
}

#[test]
fn an_attitude_that_nobody_knows_is_found_from_positions() {
    for seed in 0..20 {
        // Of the antenna, which is not where the sensor is, with noise, and of a sensor with a bias.
        let flight = flight(seed, 40, 0.3);
        let problem = problem(&flight, seed, Gravity::Known, &[ImuBias::zero(); 41]);
        let sum = |samples: &Vec<Imu>| Preintegration::of(samples, ImuBias::zero(), DENSITY).unwrap();
        let legs: Vec<_> = flight.samples.iter().map(sum).zip(flight.fixes[1..].iter().copied()).collect();
        let start = inertial_start(flight.fixes[0], &legs, &GRAVITY).unwrap();
        let off = start[0].rotation().rminus(&flight.states[0].rotation()).norm();
        assert!(off < 0.3, "{seed}: {off}");

        // Without a prior on the state.
        let mut problem = Problem { graph: Graph::new(), ..problem };
        add_inertial(&mut problem, &flight, Gravity::Known, &[ImuBias::zero(); 41]);
        add_fixes(&mut problem, &flight);
        problem.states.iter().zip(&start).for_each(|(key, x)| problem.values.set(*key, *x).unwrap());
        let (values, _) = solve(&mut problem, 0.05);
        let error = flight.states[20].rotation().rminus(&values.get(problem.states[20]).unwrap().rotation());
        assert!(error.norm() < 0.05, "{seed}: {error}");
    }
}

#[test]
fn a_velocity_that_is_known_is_kept() {
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let x = values.insert(SE23::exp(&(SVector::<f64, 9>::repeat(0.4))));
    graph.add((x,), Prior { mean: SE23::identity() }, Noise::unit());
    let measured = vector![1.0, -2.0, 0.5];
    graph.add((x,), Velocity { measured }, Noise::from_sigmas(&Vector3::repeat(1e-6)).unwrap());
    let solution = graph.optimize(&values, &SolveOptions::default()).unwrap();
    assert!((solution.values.get(x).unwrap().velocity() - measured).norm() < 1e-5);
}
