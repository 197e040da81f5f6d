//! Smoothing and replay.

use crate::linear::{Cart, F, G, H, Lens, N, Q};
use boxplus::filter::{Ekf, Filter, FilterError, Odometry, PositionFix, Replay, Smoother, Ukf};
use boxplus::lie::{LieGroup, Rn, SE2};
use boxplus::uncertainty::{Covariance, Gaussian, Global, Local, Side};
use nalgebra::{DMatrix, DVector, Matrix2, SMatrix, Vector2, vector};

const STEPS: usize = 20;

fn push(k: usize) -> f64 {
    (0.3 * k as f64).sin()
}

fn seen(k: usize) -> f64 {
    (0.17 * k as f64).cos() + 0.1 * (5.0 * k as f64).sin()
}

/// The whole chain as one weighted least-squares problem in the start and the pushes: `(states, covariances)`.
fn batch() -> Vec<(Vector2<f64>, Matrix2<f64>)> {
    // x_k = A_k·z + c_k with z = (x₀, w₁, …, w_n) ~ N(μ, Σ).
    let n = 2 + STEPS;
    let mut a = vec![DMatrix::<f64>::identity(2, n)];
    let mut c = vec![Vector2::zeros()];
    for k in 1..=STEPS {
        let mut next = F * &a[k - 1];
        next.column_mut(1 + k).copy_from(&G);
        a.push(DMatrix::from_iterator(2, n, next.iter().copied()));
        c.push(F * c[k - 1] + G * push(k));
    }
    let mut information = DMatrix::<f64>::identity(n, n) / Q;
    let mut right = DVector::<f64>::zeros(n);
    for (i, (mean, sigma)) in [(1.0, 2.0), (-1.0, 1.0)].into_iter().enumerate() {
        information[(i, i)] = 1.0 / (sigma * sigma);
        right[i] = mean / (sigma * sigma);
    }
    for k in 1..=STEPS {
        let row = H * &a[k];
        information += row.transpose() * &row / N;
        right += row.transpose() * ((seen(k) - (H * c[k])[(0, 0)]) / N);
    }
    let covariance = information.try_inverse().unwrap();
    let z = &covariance * right;
    let told = |k: usize| {
        let (x, p) = (&a[k] * &z, &a[k] * &covariance * a[k].transpose());
        (Vector2::new(x[0], x[1]) + c[k], Matrix2::from_fn(|i, j| p[(i, j)]))
    };
    (0..=STEPS).map(told).collect()
}

fn agrees_with_batch<E: Side>(filter: impl Filter) {
    let start =
        Gaussian::<Rn<2>, 2, E>::from_sigmas(Rn::new(vector![1.0, -1.0]), &vector![2.0, 1.0]).unwrap();
    let mut run = Smoother::new(filter, start);
    for k in 1..=STEPS {
        run.predict(&Cart, &push(k)).unwrap();
        assert!(run.update(&Lens(seen(k))).is_accepted());
    }
    let smoothed = run.smoothed();
    assert_eq!(smoothed.len(), STEPS + 1);
    assert_eq!(smoothed.last(), Some(run.belief()));
    for (belief, (x, p)) in smoothed.iter().zip(batch()) {
        assert!((belief.mean().vector() - x).norm() < 1e-11, "{:e}", (belief.mean().vector() - x).norm());
        assert!((belief.covariance().matrix() - p).norm() < 1e-11);
    }
}

#[test]
fn a_smoother_equals_least_squares_over_the_whole_chain() {
    agrees_with_batch::<Local>(Ekf::default());
    agrees_with_batch::<Global>(Ekf::default());
    agrees_with_batch::<Local>(Ukf::default());
}

fn smoothed_rail(filter: impl Filter, odometry: &Odometry<3>, fix: impl Fn(f64) -> PositionFix<2>) {
    let mut run = Smoother::new(filter, Gaussian::<SE2, 3>::certain(SE2::identity()));
    for k in 1..10 {
        run.predict(odometry, &vector![1.0, 0.0, 0.0]).unwrap();
        assert!(run.update(&fix(f64::from(k) + 0.1)).is_accepted());
    }
    let smoothed = run.smoothed();
    assert!(smoothed.iter().zip(run.beliefs()).all(|(s, f)| s.sigmas()[0] <= f.sigmas()[0] * (1.0 + 1e-9)));
    assert!(smoothed.iter().all(|s| s.sigmas()[2] == 0.0 && s.mean().angle() == 0.0));
    assert!(smoothed[5].sigmas()[0] < 0.8 * run.beliefs().nth(5).unwrap().sigmas()[0]);
}

#[test]
fn a_smoother_passes_through_certain_directions() {
    // A rail: nothing ever moves sideways or turns, and the covariance has rank 1 throughout.
    let odometry = Odometry { noise: Covariance::from_sigmas(&vector![0.1, 0.0, 0.0]).unwrap() };
    let fix = |x: f64| {
        let noise = Covariance::from_sigmas(&vector![0.2, 0.2]).unwrap();
        PositionFix::of_origin(vector![x, 0.0], noise)
    };
    smoothed_rail(Ekf::default(), &odometry, fix);
    smoothed_rail(Ukf::default(), &odometry, fix);
}

#[test]
fn without_disturbance_a_smoothed_state_is_the_last_one_carried_back() {
    // x₀ and x_n determine each other then, and odometry moves errors by Ad exactly: both beliefs are one, however large the
    // correction, if and only if both resets of the smoother are right.
    let still = Odometry { noise: Covariance::zero() };
    let l = SMatrix::<f64, 3, 3>::from_fn(|i, j| 0.3 * ((i * i + 3 * i * j + j + 1) as f64).sin());
    let start = Gaussian::<SE2, 3>::new(SE2::identity(), Covariance::new(l * l.transpose()).unwrap());
    let step = vector![1.0, 0.2, 0.6];
    let mut run = Smoother::new(Ekf::default(), start);
    for _ in 0..5 {
        run.predict(&still, &step).unwrap();
    }
    let place = run.belief().mean().translation() + vector![0.7, -0.5];
    assert!(
        run.update(&PositionFix::of_origin(place, Covariance::from_sigmas(&vector![0.01, 0.01]).unwrap()))
            .is_accepted()
    );
    let first = run.smoothed()[0];
    let whole = SE2::exp(&step).power(5.0);
    let carried = first.change_body(&whole);
    assert!(run.smoothed()[0].mean().rminus(&SE2::identity()).norm() > 0.3);
    assert!(carried.mean().rminus(run.belief().mean()).norm() < 1e-12);
    assert!((carried.covariance().matrix() - run.belief().covariance().matrix()).norm() < 1e-12);
}

fn drive(b: &Gaussian<SE2, 3>) -> Gaussian<SE2, 3> {
    let odometry = Odometry { noise: Covariance::from_sigmas(&vector![0.1, 0.05, 0.1]).unwrap() };
    Ekf::default().predict(b, &odometry, &vector![1.0, 0.0, 0.1]).unwrap()
}

fn fix(x: f64) -> impl Fn(&Gaussian<SE2, 3>) -> Gaussian<SE2, 3> + Send + 'static {
    let fix = PositionFix::of_origin(vector![x, 0.3], Covariance::from_sigmas(&vector![0.1, 0.1]).unwrap());
    move |b| Ekf::default().update(b, &fix).belief
}

#[test]
fn events_may_come_in_any_order() {
    let start = Gaussian::certain(SE2::identity());
    let mut ordered = Replay::new(0.0, start, 100.0);
    for k in 1..=10 {
        ordered.push(f64::from(k), drive).unwrap();
        ordered.push(f64::from(k) + 0.5, fix(f64::from(k))).unwrap();
    }
    let mut shuffled = Replay::new(0.0, start, 100.0);
    for k in (1..=10).rev() {
        shuffled.push(f64::from(k) + 0.5, fix(f64::from(k))).unwrap();
    }
    for k in [3, 7, 1, 10, 2, 9, 8, 4, 6, 5] {
        shuffled.push(f64::from(k), drive).unwrap();
    }
    assert_eq!(shuffled.belief(), ordered.belief());
    assert_eq!(shuffled.belief_at(4.2), ordered.belief_at(4.2));
    assert_eq!(ordered.belief_at(0.5).unwrap(), &start);
}

#[test]
fn what_is_forgotten_cannot_be_corrected() {
    let mut run = Replay::new(0.0, Gaussian::certain(SE2::identity()), 2.0);
    for k in 1..=10 {
        run.push(f64::from(k), drive).unwrap();
    }
    let before = *run.belief();
    assert_eq!(run.push(6.5, fix(6.0)).unwrap_err(), FilterError::TooOld { time: 6.5, oldest: 7.0 });
    assert!(matches!(run.push(f64::NAN, fix(6.0)).unwrap_err(), FilterError::NotATime { .. }));
    assert_eq!(run.belief(), &before);
    run.push(8.5, fix(8.0)).unwrap();
    assert_ne!(run.belief(), &before);
}
