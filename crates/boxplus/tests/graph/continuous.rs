//! Trajectories in continuous time: batches beside the Kalman smoother, and the NEES of what is told between states.

use boxplus::filter::{Ekf, Measurement, Motion as Step, Smoother};
use boxplus::graph::{
    Algorithm, Graph, GroupVariable, Interpolated, Key, MotionPrior, Noise, OnSpline, Position, Prior,
    SolveOptions, SplineImu, Values, VariableId,
};
use boxplus::lie::{Action, LieGroup, Rn, SE2, SE3, SO3};
use boxplus::trajectory::{BSpline, ImuBias, Motion, Moving, gp_bridge, gp_covariance, gp_transition};
use boxplus::uncertainty::{Covariance, Gaussian};
use nalgebra::{Cholesky, DMatrix, Matrix4, SMatrix, SVector, Vector1, Vector2, Vector3, vector};
use rand_chacha::ChaCha8Rng;

use crate::world::{positive, rng};

fn normal<const D: usize>(rng: &mut ChaCha8Rng) -> SVector<f64, D> {
    let unit = Gaussian::<Rn<D>, D>::from_sigmas(Rn::identity(), &SVector::repeat(1.0)).unwrap();
    unit.sample(rng).vector()
}

/// x ~ N(0, P).
fn drawn<const D: usize>(rng: &mut ChaCha8Rng, covariance: &SMatrix<f64, D, D>) -> SVector<f64, D> {
    Cholesky::new(*covariance).unwrap().l() * normal::<D>(rng)
}

fn nees<const D: usize>(error: &SVector<f64, D>, covariance: &SMatrix<f64, D, D>) -> f64 {
    error.dot(&Cholesky::new(*covariance).unwrap().solve(error))
}

/// ANEES of D degrees of freedom over n runs: mean D, deviation √(2D/n); four of them are allowed.
#[track_caller]
fn is_chi_squared(sum: f64, dimension: usize, n: f64) {
    let (anees, d) = (sum / n, dimension as f64);
    assert!((anees - d).abs() < 4.0 * (2.0 * d / n).sqrt(), "ANEES {anees} of {d}");
}

// On ℝ² with constant velocity: state (x, y, ẋ, ẏ), and a position seen of each.

type Flat = Moving<Rn<2>, 2, 2, 4>;
const STEP: f64 = 0.7;
const SEEN: f64 = 0.3;

fn density() -> Covariance<2> {
    Covariance::new(SMatrix::<f64, 2, 2>::new(0.5, 0.1, 0.1, 0.2)).unwrap()
}

struct ConstantVelocity;
impl Step<Rn<4>, 4, 4> for ConstantVelocity {
    type Input = f64;
    fn step(&self, x: &Rn<4>, duration: &f64, w: &SVector<f64, 4>) -> Rn<4> {
        Rn::new(block(&gp_transition(*duration), &SMatrix::identity()) * x.vector() + w)
    }
    fn noise(&self, duration: &f64) -> Covariance<4> {
        Covariance::new(block(&gp_covariance(*duration), density().matrix())).unwrap()
    }
    fn step_jac(&self, x: &Rn<4>, duration: &f64) -> (Rn<4>, Matrix4<f64>, Matrix4<f64>) {
        let phi = block(&gp_transition(*duration), &SMatrix::identity());
        (self.step(x, duration, &SVector::zeros()), phi, SMatrix::identity())
    }
}

struct Seen(Vector2<f64>);
impl Measurement<Rn<4>, 4, 2> for Seen {
    fn innovation(&self, x: &Rn<4>) -> Vector2<f64> {
        self.0 - x.vector().fixed_rows::<2>(0)
    }
    fn noise(&self) -> Covariance<2> {
        Covariance::from_sigmas(&Vector2::repeat(SEEN)).unwrap()
    }
    fn innovation_jac(&self, x: &Rn<4>) -> (Vector2<f64>, SMatrix<f64, 2, 4>) {
        (self.innovation(x), SMatrix::identity())
    }
}

/// A ⊗ B.
fn block(a: &SMatrix<f64, 2, 2>, b: &SMatrix<f64, 2, 2>) -> Matrix4<f64> {
    Matrix4::from_fn(|i, j| a[(i / 2, j / 2)] * b[(i % 2, j % 2)])
}

/// States at `times` joined by priors, and positions of the origin seen at the first and from then on at each.
fn flat(times: &[f64], seen: impl Fn(usize) -> Option<Vector2<f64>>) -> (Graph, Values, Vec<Key<Flat>>) {
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let keys: Vec<_> = times.iter().map(|_| values.insert(Flat::identity())).collect();
    graph.add(
        (keys[0],),
        Prior { mean: Flat::identity() },
        Noise::from_sigmas(&SVector::repeat(1.0)).unwrap(),
    );
    for (k, pair) in times.windows(2).enumerate() {
        let prior = MotionPrior::<Rn<2>, 2, 2, 4>::new(pair[1] - pair[0], density()).unwrap();
        graph.add((keys[k], keys[k + 1]), prior, prior.noise().unwrap());
        let at_end = |z| Interpolated::<_, Flat, _>::new(Prior { mean: Rn::new(z) }, 1.0, 1.0).unwrap();
        if let Some(z) = seen(k + 1) {
            graph.add((keys[k], keys[k + 1]), at_end(z), Noise::from_sigmas(&Vector2::repeat(SEEN)).unwrap());
        }
    }
    (graph, values, keys)
}

/// A linear problem, by one step that nothing damps.
fn solved(graph: &Graph, values: &Values) -> Values {
    let options = SolveOptions { algorithm: Algorithm::GaussNewton, ..Default::default() };
    graph.optimize(values, &options).unwrap().values
}

fn drawn_positions(count: usize) -> Vec<Vector2<f64>> {
    let mut rng = rng(5);
    (0..count).map(|_| normal::<2>(&mut rng) * 2.0).collect()
}

#[test]
fn on_vectors_the_batch_is_the_kalman_smoother() {
    let seen = drawn_positions(12);
    let times: Vec<f64> = (0..12).map(|k| f64::from(k) * STEP).collect();
    let (graph, values, keys) = flat(&times, |k| Some(seen[k]));
    let estimate = solved(&graph, &values);
    let mut marginals = graph.marginals(&estimate).unwrap();

    let start = Gaussian::<Rn<4>, 4>::from_sigmas(Rn::identity(), &SVector::repeat(1.0)).unwrap();
    let mut smoother = Smoother::new(Ekf::default(), start);
    for z in &seen[1..] {
        smoother.predict(&ConstantVelocity, &STEP).unwrap();
        assert!(smoother.update(&Seen(*z)).is_accepted());
    }
    for (key, belief) in keys.iter().zip(smoother.smoothed()) {
        let state = estimate.get(*key).unwrap();
        assert!((state.log() - belief.mean().vector()).amax() < 1e-9);
        let covariance = marginals.covariance(*key).unwrap();
        let wanted = DMatrix::from_column_slice(4, 4, belief.covariance().matrix().as_slice());
        assert!((covariance - wanted).amax() < 1e-9);
    }
}

#[test]
fn on_vectors_a_query_is_what_a_state_at_that_time_would_be() {
    let seen = drawn_positions(8);
    let times: Vec<f64> = (0..8).map(|k| f64::from(k) * STEP).collect();
    let (graph, values, keys) = flat(&times, |k| Some(seen[k]));
    let estimate = solved(&graph, &values);
    let mut marginals = graph.marginals(&estimate).unwrap();
    let prior = MotionPrior::<Rn<2>, 2, 2, 4>::new(STEP, density()).unwrap();
    let asked = prior.query(&estimate, &mut marginals, (keys[3], keys[4]), 0.3).unwrap();

    let mut more = times.clone();
    more.insert(4, times[3] + 0.3);
    let index = |k: usize| if k < 4 { Some(k) } else { k.checked_sub(1).filter(|_| k > 4) };
    let (graph, values, keys) = flat(&more, |k| index(k).map(|k| seen[k]));
    let estimate = solved(&graph, &values);
    let mut marginals = graph.marginals(&estimate).unwrap();
    let state = estimate.get(keys[4]).unwrap();
    assert!((state.value().vector() - asked.mean().vector()).amax() < 1e-9);
    let wanted = marginals.covariance(keys[4]).unwrap();
    let wanted = wanted.fixed_view::<2, 2>(0, 0);
    assert!((wanted - asked.covariance().matrix()).amax() < 1e-9, "{wanted} {:?}", asked.covariance());
}

#[test]
fn on_vectors_a_measurement_between_states_tells_what_it_would_tell_a_state_there() {
    // Its noise must hold what the prior leaves open between the states: then both are the same estimate.
    let (z, t) = (vector![1.5, -2.0], 0.3);
    let seen = drawn_positions(6);
    let times: Vec<f64> = (0..6).map(|k| f64::from(k) * STEP).collect();
    let (mut graph, values, keys) = flat(&times, |k| Some(seen[k]));
    let between = Interpolated::<_, Flat, _>::new(Prior { mean: Rn::new(z) }, STEP, t).unwrap();
    let sensor = SMatrix::<f64, 2, 2>::identity() * SEEN * SEEN;
    let noise = sensor + density().matrix() * gp_bridge::<f64, 2>(STEP, t);
    graph.add((keys[2], keys[3]), between, Noise::from_covariance(&noise).unwrap());
    let once = solved(&graph, &values);

    let mut more = times.clone();
    more.insert(3, times[2] + t);
    let all: Vec<_> = seen[..3].iter().chain([&z]).chain(&seen[3..]).copied().collect();
    let (graph, values, more) = flat(&more, |k| Some(all[k]));
    let again = solved(&graph, &values);
    for (k, key) in keys.iter().enumerate() {
        let other = more[if k < 3 { k } else { k + 1 }];
        assert!(once.get(*key).unwrap().is_near(again.get(other).unwrap(), 1e-9));
    }
}

/// γ after `duration`, drawn from the prior of density `q_c`, by blocks; and the state it stands for.
fn drawn_from_the_prior<const D: usize, const R: usize, const N: usize>(
    rng: &mut ChaCha8Rng,
    gamma: &SVector<f64, N>,
    q_c: &SMatrix<f64, D, D>,
    duration: f64,
) -> SVector<f64, N> {
    let (phi, q) = (gp_transition::<f64, R>(duration), gp_covariance::<f64, R>(duration));
    let mean =
        SVector::<f64, N>::from_fn(|i, _| (0..R).map(|j| phi[(i / D, j)] * gamma[j * D + i % D]).sum());
    let noise = SMatrix::<f64, N, N>::from_fn(|i, j| q[(i / D, j / D)] * q_c[(i % D, j % D)]);
    mean + drawn(rng, &noise)
}

/// The state of local coordinates γ = (ξ, ξ̇, ξ̈) about X.
fn from_local<G: GroupVariable<D>, const D: usize, const R: usize, const N: usize>(
    x: &G,
    gamma: &SVector<f64, N>,
) -> Moving<G, D, R, N> {
    let block = |k: usize| if k < R { gamma.fixed_rows::<D>(k * D).into_owned() } else { SVector::zeros() };
    let motion = Motion::<G, D>::from_coordinates(&[block(0), block(1), block(2), SVector::zeros()]);
    Moving::from_motion(&Motion { value: x.compose(&motion.value), ..motion })
}

/// Trajectories drawn from the prior, with every element and one between two states seen: NEES of a state, and of queries where nothing
/// was seen.
fn is_consistent<G: GroupVariable<D>, const D: usize, const R: usize, const N: usize>() {
    const RUNS: u64 = 100;
    let (step, q_c) = (0.5, positive::<D>(&mut rng(77), 0.02));
    let prior = MotionPrior::<G, D, R, N>::new(step, Covariance::new(q_c).unwrap()).unwrap();
    let (start, sensor) = (SMatrix::<f64, N, N>::identity() * 0.01, SMatrix::<f64, D, D>::identity() * 4e-4);
    let mut sums = [0.0; 3];
    for seed in 0..RUNS {
        let mut rng = rng(seed);
        let mean = Moving::<G, D, R, N>::exp(&normal::<N>(&mut rng).map(|x| 0.3 * x));
        let mut truth = vec![mean.rplus(&drawn(&mut rng, &start))];
        let mut middle = vec![];
        for k in 0..6 {
            let Motion { value, velocity, acceleration, .. } = truth[k].motion();
            let blocks = [SVector::zeros(), velocity, acceleration];
            let here = SVector::<f64, N>::from_fn(|i, _| blocks[i / D][i % D]);
            let half = drawn_from_the_prior::<D, R, N>(&mut rng, &here, &q_c, 0.2);
            let end = drawn_from_the_prior::<D, R, N>(&mut rng, &half, &q_c, step - 0.2);
            middle.push(*from_local::<G, D, R, N>(&value, &half).value());
            truth.push(from_local(&value, &end));
        }
        let (mut graph, mut values) = (Graph::new(), Values::new());
        let keys: Vec<_> =
            truth.iter().map(|x| values.insert(x.rplus(&normal::<N>(&mut rng).map(|x| 0.1 * x)))).collect();
        graph.add((keys[0],), Prior { mean }, Noise::from_covariance(&start).unwrap());
        let mut see = |graph: &mut Graph, k: usize, so: &G, time: f64, noise: &SMatrix<f64, D, D>| {
            let mean = so.rplus(&drawn(&mut rng, &sensor));
            let seen = Interpolated::<_, Moving<G, D, R, N>, _>::new(Prior { mean }, step, time).unwrap();
            graph.add((keys[k], keys[k + 1]), seen, Noise::from_covariance(noise).unwrap());
        };
        for k in 0..6 {
            graph.add((keys[k], keys[k + 1]), prior, prior.noise().unwrap());
            see(&mut graph, k, truth[k + 1].value(), step, &sensor);
        }
        see(&mut graph, 1, &middle[1], 0.2, &(sensor + q_c * gp_bridge::<f64, R>(step, 0.2)));
        let solution = graph.optimize(&values, &SolveOptions::default()).unwrap();
        assert!(solution.report.converged(), "{:?}", solution.report);
        let mut marginals = graph.marginals(&solution.values).unwrap();
        let error = truth[3].rminus(solution.values.get(keys[3]).unwrap());
        let covariance = marginals.covariance(keys[3]).unwrap();
        sums[0] += nees(&error, &SMatrix::from_column_slice(covariance.as_slice()));
        for (sum, k) in sums[1..].iter_mut().zip([3, 5]) {
            let told = prior.query(&solution.values, &mut marginals, (keys[k], keys[k + 1]), 0.2).unwrap();
            *sum += nees(&middle[k].rminus(told.mean()), told.covariance().matrix());
        }
    }
    let runs = RUNS as f64;
    is_chi_squared(sums[0], N, runs);
    is_chi_squared(sums[1], D, runs);
    is_chi_squared(sums[2], D, runs);
}

#[test]
fn states_and_queries_between_them_are_as_sure_as_they_claim_on_many_groups() {
    is_consistent::<Rn<2>, 2, 2, 4>();
    is_consistent::<SE2, 3, 2, 6>();
    is_consistent::<SO3, 3, 3, 9>();
    is_consistent::<SE3, 6, 2, 12>();
    is_consistent::<SE3, 6, 3, 18>();
}

/// A spline through the whole of which elements are seen: NEES of an inner control element.
fn spline_is_consistent<G: GroupVariable<D>, const D: usize>() {
    const RUNS: u64 = 100;
    let sensor = SMatrix::<f64, D, D>::identity() * 4e-4;
    let mut sum = 0.0;
    for seed in 0..RUNS {
        let mut rng = rng(seed);
        let mut truth = vec![G::exp(&normal::<D>(&mut rng).map(|x| 0.3 * x))];
        (0..7).for_each(|k| truth.push(truth[k].rplus(&normal::<D>(&mut rng).map(|x| 0.3 * x))));
        let spline = BSpline::<G, D, 4>::new(&truth, 0.0, 1.0).unwrap();
        let (mut graph, mut values) = (Graph::new(), Values::new());
        let keys: Vec<_> =
            truth.iter().map(|x| values.insert(x.rplus(&normal::<D>(&mut rng).map(|x| 0.1 * x)))).collect();
        for i in 0..30_u32 {
            let (interval, place) = (i as usize / 6, f64::from(i % 6) / 6.0);
            let so = spline.at(interval as f64 + place).unwrap().value;
            let seen = Prior { mean: so.rplus(&drawn(&mut rng, &sensor)) };
            let [a, b, c, d] = [0, 1, 2, 3].map(|j| keys[interval + j]);
            let seen = OnSpline::<_, _, D>::new(seen, place).unwrap();
            graph.add((a, b, c, d), seen, Noise::from_covariance(&sensor).unwrap());
        }
        let estimate = graph.optimize(&values, &SolveOptions::default()).unwrap().values;
        let covariance = graph.marginals(&estimate).unwrap().covariance(keys[3]).unwrap();
        let error = truth[3].rminus(estimate.get(keys[3]).unwrap());
        sum += nees(&error, &SMatrix::from_column_slice(covariance.as_slice()));
    }
    is_chi_squared(sum, D, RUNS as f64);
}

#[test]
fn control_elements_of_splines_are_as_sure_as_they_claim_on_many_groups() {
    spline_is_consistent::<Rn<1>, 1>();
    spline_is_consistent::<SE2, 3>();
    spline_is_consistent::<SO3, 3>();
    spline_is_consistent::<SE3, 6>();
}

/// Readings of a sensor on a spline, and positions; NEES of its bias and of an inner control element.
fn spline_of_readings(seed: u64) -> [f64; 2] {
    let (interval, gravity) = (0.2, Vector3::new(0.0, 0.0, -9.81));
    let (gyro, accel, fix) = (0.01, 0.05, 0.05);
    let mut rng = rng(seed);
    let bias = ImuBias::exp(&(normal::<6>(&mut rng) * 0.1));
    let at = |t: f64| {
        let rotation = SO3::exp(&vector![0.5 * (1.3 * t).sin(), 0.4 * (0.9 * t).cos(), 0.6 * t]);
        SE3::new(rotation, vector![2.0 * (0.8 * t).sin(), 1.5 * (1.1 * t).cos(), 0.5 * (0.7 * t).sin()])
    };
    let truth: Vec<SE3> = (0..43_u32).map(|k| at(f64::from(k) * interval)).collect();
    let spline = BSpline::<SE3, 6, 4>::new(&truth, 0.0, interval).unwrap();
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let keys: Vec<_> = truth.iter().map(|x| values.insert(x.rplus(&(normal(&mut rng) * 0.05)))).collect();
    let unknown = values.insert(ImuBias::zero());
    let sigmas = SVector::<f64, 6>::from_fn(|i, _| if i < 3 { gyro } else { accel });
    for i in 0..800_usize {
        let (k, place) = (i / 20, (i % 20) as f64 / 20.0);
        let [a, b, c, d] = [0, 1, 2, 3].map(|j| keys[k + j]);
        let now = spline.at((k as f64 + place) * interval).unwrap();
        let [rho, phi, push] = [(0, &now.velocity), (3, &now.velocity), (0, &now.acceleration)]
            .map(|(row, v)| v.fixed_rows::<3>(row).into_owned());
        let force = push + phi.cross(&rho) - now.value.rotation().inverse().act(&gravity);
        let shown = [
            phi + bias.gyro() + normal::<3>(&mut rng) * gyro,
            force + bias.accel() + normal::<3>(&mut rng) * accel,
        ];
        let reading = SplineImu::new(shown, place, interval, gravity).unwrap();
        graph.add((a, b, c, d, unknown), reading, Noise::from_sigmas(&sigmas).unwrap());
        if i % 20 == 7 {
            let place_seen = now.value.translation() + normal::<3>(&mut rng) * fix;
            let seen = OnSpline::<_, _, 6>::new(Position::<SE3, 3>::of_origin(place_seen), place).unwrap();
            graph.add((a, b, c, d), seen, Noise::from_sigmas(&Vector3::repeat(fix)).unwrap());
        }
    }
    let solution = graph.optimize(&values, &SolveOptions::default()).unwrap();
    assert!(solution.report.converged(), "{:?}", solution.report);
    let mut marginals = graph.marginals(&solution.values).unwrap();
    let off = bias.rminus(solution.values.get(unknown).unwrap());
    let error = truth[20].rminus(solution.values.get(keys[20]).unwrap());
    assert!(error.amax() < 0.1, "{error}");
    let mut six = |id| SMatrix::<f64, 6, 6>::from_column_slice(marginals.covariance(id).unwrap().as_slice());
    let [of_bias, of_knot] = [VariableId::from(unknown), keys[20].into()].map(&mut six);
    [nees(&off, &of_bias), nees(&error, &of_knot)]
}

#[test]
fn splines_of_inertial_readings_and_positions_know_pose_and_bias_as_surely_as_they_claim() {
    const RUNS: u64 = 30;
    let runs: Vec<[f64; 2]> = (0..RUNS).map(spline_of_readings).collect();
    for k in 0..2 {
        is_chi_squared(runs.iter().map(|nees| nees[k]).sum(), 6, RUNS as f64);
    }
}

#[test]
fn times_outside_are_refused() {
    type State = Moving<Rn<1>, 1, 2, 2>;
    let seen = Prior { mean: Rn::new(Vector1::new(0.0)) };
    assert!(Interpolated::<_, State, _>::new(seen, 1.0, 1.1).is_err());
    assert!(Interpolated::<_, State, _>::new(seen, 0.0, 0.0).is_err());
    assert!(OnSpline::<_, _, 1>::new(seen, -0.1).is_err());
    assert!(MotionPrior::<Rn<1>, 1, 2, 2>::new(f64::NAN, Covariance::unit()).is_err());
    let exact = MotionPrior::<Rn<1>, 1, 2, 2>::new(1.0, Covariance::zero()).unwrap();
    assert!(exact.noise().is_err());
    assert!(SplineImu::new([Vector3::zeros(); 2], 0.5, 0.0, Vector3::zeros()).is_err());
}
