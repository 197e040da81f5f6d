//! Other forms of the same filter: by information, by a square root, in continuous time.

use boxplus::filter::{
    Discretised, Ekf, Filter, FilterError, Flow, InformationBelief, Measurement, Motion, Odometry,
    PositionFix, Sighting, SquareRootBelief, Ukf, check_motion,
};
use boxplus::lie::{LieGroup, Rn, SE2, SE3};
use boxplus::uncertainty::{Covariance, Gaussian, Global, Side};
use nalgebra::{Matrix2, RowVector2, SMatrix, SVector, Vector1, Vector3, vector};

fn tangent<const D: usize>(seed: f64) -> SVector<f64, D> {
    SVector::from_fn(|i, _| (seed + 1.7 * i as f64).sin())
}

/// A covariance with every correlation, and of a condition that leaves digits.
fn covariance<const D: usize>(seed: f64) -> Covariance<D> {
    let root = SMatrix::<f64, D, D>::from_fn(|i, j| 0.05 * (seed + 2.3 * i as f64 + 0.7 * j as f64).sin());
    Covariance::unit().transformed(&(root + SMatrix::identity() * 0.3))
}

fn pose(seed: f64) -> Gaussian<SE3, 6> {
    Gaussian::new(SE3::exp(&tangent(seed)), covariance(seed))
}

fn sighting(seed: f64) -> Sighting<3> {
    Sighting { landmark: tangent(seed) * 3.0, measured: tangent(seed + 1.0), noise: covariance(seed + 2.0) }
}

/// The same belief up to the rounding that inverting its covariance, of condition κ, may leave.
fn same<G: LieGroup<D, Scalar = f64>, E: Side, const D: usize>(a: &Gaussian<G, D, E>, b: &Gaussian<G, D, E>) {
    let (variances, _) = b.covariance().principal_axes();
    let bound = 32.0 * D as f64 * f64::EPSILON * variances[0] / variances[D - 1];
    assert!(bound < 1e-6, "an ill-conditioned case proves nothing: {bound}");
    assert!(a.error_of(b.mean()).amax() < bound, "{:?} {bound}", a.error_of(b.mean()));
    let off = (a.covariance().matrix() - b.covariance().matrix()).amax();
    assert!(off < bound * variances[0], "{off} {bound}");
}

/// A step and a correction in three forms.
fn in_three_forms<E: Side>(start: &Gaussian<SE3, 6, E>, seed: f64) {
    let (odometry, u) = (Odometry { noise: covariance(seed + 4.0) }, tangent(seed + 5.0));
    let moved = Ekf::default().predict(start, &odometry, &u).unwrap();
    let seen = Ekf::default().update(&moved, &sighting(seed)).belief;
    let information = InformationBelief::from_gaussian(start).unwrap().predict(&odometry, &u).unwrap();
    same(&information.to_gaussian().unwrap(), &moved);
    let iterated = Ekf { iterations: 10, tolerance: 0.0, ..Ekf::default() };
    let settled = iterated.update(&moved, &sighting(seed)).belief;
    let by_information = information.update(&sighting(seed)).unwrap().to_gaussian().unwrap();
    // The same ten steps, unless one is √ε of a standard deviation: what may follow is √ε/(1 − r) with the rate r.
    let sigma = settled.sigmas().amax();
    assert!(by_information.error_of(settled.mean()).amax() < 1e-7 * sigma);
    assert!(
        (by_information.covariance().matrix() - settled.covariance().matrix()).amax() < 1e-7 * sigma * sigma
    );
    let root = SquareRootBelief::from_gaussian(start).predict(&odometry, &u).unwrap();
    same(&root.to_gaussian().unwrap(), &moved);
    let root = root.update(&sighting(seed)).unwrap();
    same(&root.to_gaussian().unwrap(), &seen);
    assert!((root.sigmas() - seen.sigmas()).amax() < 1e-12);
    assert!((0..6).all(|i| (i + 1..6).all(|j| root.root()[(i, j)] == 0.0)), "{}", root.root());
}

#[test]
fn all_forms_agree_on_both_sides() {
    for seed in 0..10 {
        let seed = f64::from(seed);
        in_three_forms(&pose(seed), seed);
        in_three_forms::<Global>(&pose(seed).to_global(), seed);
    }
}

#[test]
fn information_of_many_sensors_adds_up_in_any_order() {
    let nothing = InformationBelief::<SE3, 6>::unknown(SE3::identity());
    let sensors = [0.1, 0.2, 0.3].map(sighting);
    let all = nothing.update_all(&sensors).unwrap();
    let [a, b, c] = sensors;
    let turned = nothing.update_all(&[c, a, b]).unwrap();
    assert!((all.information() - turned.information()).amax() < 1e-9 * all.information().amax());
    assert_eq!(nothing.update_all::<Sighting<3>, 3>(&[]).unwrap(), nothing);
}

#[test]
fn what_nothing_has_seen_stays_unknown_and_unmoved() {
    let nothing = InformationBelief::<SE2, 3>::unknown(SE2::identity());
    assert_eq!(nothing.rank(), 0);
    let fix = PositionFix::of_origin(vector![3.0, 4.0], Covariance::unit());
    let placed = nothing.update(&fix).unwrap();
    assert_eq!((placed.rank(), placed.mean().angle()), (2, 0.0));
    assert!((placed.mean().translation() - vector![3.0, 4.0]).norm() < 1e-12);
    // A step of unknown heading spreads the place; it does not invent a heading.
    let odometry = Odometry { noise: Covariance::unit() * 0.1 };
    let moved = placed.predict(&odometry, &vector![1.0, 0.0, 0.0]).unwrap();
    assert_eq!(moved.rank(), 2);
    assert!(moved.to_gaussian().is_err());
}

#[test]
fn an_exact_sensor_is_refused_in_every_form() {
    let exact = PositionFix::of_origin(vector![3.0, 4.0], Covariance::zero());
    let prior = Gaussian::<SE2, 3>::new(SE2::identity(), Covariance::unit());
    let information = InformationBelief::from_gaussian(&prior).unwrap().update(&exact);
    let root = SquareRootBelief::from_gaussian(&prior).update(&exact);
    assert!(matches!(information, Err(FilterError::Singular { .. })), "{information:?}");
    assert!(matches!(root, Err(FilterError::Singular { .. })), "{root:?}");
    let nan = PositionFix::of_origin(vector![f64::NAN, 4.0], Covariance::unit());
    assert_eq!(SquareRootBelief::from_gaussian(&prior).update(&nan), Err(FilterError::MeasurementNotFinite));
    assert_eq!(
        InformationBelief::from_gaussian(&prior).unwrap().update(&nan),
        Err(FilterError::MeasurementNotFinite)
    );
}

#[test]
fn a_certain_state_stays_certain_as_a_root() {
    let certain = SquareRootBelief::from_gaussian(&Gaussian::<SE2, 3>::certain(SE2::identity()));
    let wheel = Odometry { noise: Covariance::from_sigmas(&vector![0.1, 0.0, 0.0]).unwrap() };
    let moved = certain.predict(&wheel, &vector![1.0, 0.0, 0.0]).unwrap();
    assert!((moved.sigmas() - vector![0.1, 0.0, 0.0]).amax() < 1e-16);
    let fix = PositionFix::of_origin(vector![1.1, 5.0], Covariance::unit() * 0.1);
    let seen = moved.update(&fix).unwrap();
    assert_eq!((seen.sigmas()[1], seen.mean().translation().y), (0.0, 0.0));
}

/// The sum of two coordinates, in `f32` or `f64`.
struct Sum<S>(S, S);

impl<S: boxplus::lie::Real> Measurement<Rn<2, S>, 2, 1> for Sum<S> {
    fn innovation(&self, x: &Rn<2, S>) -> Vector1<S> {
        Vector1::new(self.0 - x.vector().sum())
    }
    fn noise(&self) -> Covariance<1, S> {
        Covariance::unit() * self.1
    }
    fn innovation_jac(&self, x: &Rn<2, S>) -> (Vector1<S>, RowVector2<S>) {
        (self.innovation(x), RowVector2::new(S::one(), S::one()))
    }
}

/// Relative error of σ of the sum and of the difference after one exact sum of two vague coordinates.
fn lost(ratio: f32) -> [f64; 2] {
    let truth = f64::from(ratio);
    let prior = Gaussian::<Rn<2, f32>, 2>::from_sigmas(Rn::identity(), &vector![ratio, ratio]).unwrap();
    let of_sum = |p: &Matrix2<f64>| (p[(0, 0)] + 2.0 * p[(0, 1)] + p[(1, 1)]).max(0.0).sqrt();
    // σ² of the sum: 2r² and 1 in parallel.
    let expected = (2.0 * truth * truth / (2.0 * truth * truth + 1.0)).sqrt();
    let ekf = Ekf::default().update(&prior, &Sum(0.5, 1.0)).belief;
    let root = *SquareRootBelief::from_gaussian(&prior).update(&Sum(0.5, 1.0)).unwrap().root();
    let of_root = (root.map(f64::from).row(0) + root.map(f64::from).row(1)).norm();
    [of_sum(&ekf.covariance().matrix().map(f64::from)), of_root].map(|sigma| (sigma / expected - 1.0).abs())
}

#[test]
fn in_single_precision_a_root_keeps_what_a_covariance_loses() {
    // A sensor 10⁴ times as exact as the prior: P holds 10⁸ beside 1, which is beyond seven digits.
    let [by_covariance, by_root] = lost(1e4);
    assert!(by_covariance > 0.3, "{by_covariance}");
    assert!(by_root < 1e-3, "{by_root}");
    // At a ratio of 30 both are right.
    assert!(lost(30.0).iter().all(|error| *error < 1e-3), "{:?}", lost(30.0));
}

/// A body in a wind that grows with height, pushed by noise along the track only.
struct Glider;

impl Flow<SE2, 3> for Glider {
    type Input = f64;
    fn velocity(&self, x: &SE2, turn: &f64) -> Vector3<f64> {
        let drift = x.rotation().inverse().to_matrix() * vector![0.3 * x.translation().y, 0.1];
        vector![1.5 + drift.x, drift.y, *turn]
    }
    fn velocity_jac(&self, x: &SE2, turn: &f64) -> (Vector3<f64>, SMatrix<f64, 3, 3>) {
        let back = x.rotation().inverse().to_matrix();
        let drift = back * vector![0.3 * x.translation().y, 0.1];
        let mut d_x = SMatrix::<f64, 3, 3>::zeros();
        let gradient = SMatrix::<f64, 2, 2>::new(0.0, 0.3, 0.0, 0.0);
        d_x.fixed_view_mut::<2, 2>(0, 0).copy_from(&(back * gradient * back.transpose()));
        (d_x[(0, 2)], d_x[(1, 2)]) = (drift.y, -drift.x);
        (self.velocity(x, turn), d_x)
    }
    fn density(&self, _: &SE2, _: &f64) -> Covariance<3> {
        Covariance::from_sigmas(&vector![0.2, 0.0, 0.1]).unwrap()
    }
}

#[test]
fn a_flow_in_parts_converges_in_second_order() {
    let x = SE2::new(vector![1.0, 2.0], 0.7);
    let error = |steps| check_motion(&Discretised { flow: Glider, steps }, &x, &(0.8, 1.0));
    let [coarse, fine] = [error(4), error(16)];
    assert!(fine < 1e-3 && (coarse / fine - 16.0).abs() < 4.0, "{coarse} {fine}");
}

#[test]
fn noise_in_parts_is_noise_of_the_whole() {
    let x = SE2::new(vector![1.0, 2.0], 0.7);
    let spread = |steps, pieces: i32| {
        let flow = Discretised { flow: Glider, steps };
        let start = Gaussian::<SE2, 3>::certain(x);
        let duration = 1.0 / f64::from(pieces);
        let step = |b, _| Ekf::default().predict(&b, &flow, &(0.8, duration)).unwrap();
        (0..pieces).fold(start, step)
    };
    same(&spread(20, 1), &spread(5, 4));
    let [whole, fine] = [spread(1, 1), spread(64, 1)];
    assert!((whole.covariance().matrix() - fine.covariance().matrix()).amax() < 0.02);
}

#[test]
fn a_step_back_in_time_or_of_no_number_is_refused() {
    let start = Gaussian::<SE2, 3>::certain(SE2::identity());
    let flow = Discretised { flow: Glider, steps: 2 };
    for duration in [-0.1, f64::NAN, f64::INFINITY] {
        let refused = Ekf::default().predict(&start, &flow, &(0.1, duration));
        assert_eq!(refused, Err(FilterError::MotionNotFinite), "{duration}");
        // Sigma points see the step alone.
        let refused = Ukf::default().predict(&start, &flow, &(0.1, duration));
        assert_eq!(refused, Err(FilterError::MotionNotFinite), "{duration}");
    }
    let next = flow.step(&SE2::identity(), &(0.1, -0.1), &Vector3::zeros());
    assert!(next.angle().is_nan() && next.translation().x.is_nan());
}
