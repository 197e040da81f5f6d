//! The ready simulations: what the recommended filter claims is true in all of them, and a plain one is found out.

use boxplus::filter::{
    DeadReckoning, Ekf, Filter, FilterError, Imu, ImuNoise, MonteCarlo, Motion, PositionFix, Report, Rule,
    STANDARD_GRAVITY, Series, Simulation, Trial, VelocityFix, Verdict,
};
use boxplus::lie::{LieGroup, Rn, SE23, SO3};
use boxplus::uncertainty::{Covariance, Gaussian};
use nalgebra::{SVector, Vector3, vector};
use rand_chacha::ChaCha8Rng;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};

const EXPERIMENT: MonteCarlo =
    MonteCarlo { runs: 60, seed: 11, confidence: 0.95, threads: NonZeroUsize::MIN };

fn run(world: Simulation, trial: Trial) -> Report {
    world.run::<ChaCha8Rng>(trial, &EXPERIMENT, |_| true).unwrap()
}

fn state(report: &Report) -> &Series {
    report.series("state").unwrap()
}

#[test]
fn the_recommended_filter_is_consistent_in_every_simulation() {
    for world in Simulation::ALL {
        for global in [false, true] {
            let report = run(world, Trial { global, ..Trial::default() });
            let state = state(&report);
            assert_eq!(
                state.verdict(),
                Verdict::Consistent,
                "{world} global {global}: {} ± {}",
                state.mean,
                state.standard_error
            );
            assert_eq!((report.refused, state.dimension), (0, world.coordinates().len()), "{world}");
            for sensor in &report.series {
                assert_eq!(sensor.verdict(), Verdict::Consistent, "{world} {}: {}", sensor.name, sensor.mean);
            }
        }
    }
}

#[test]
fn with_biases_that_are_known_an_attitude_that_is_not_does_no_harm() {
    // The world of `gnss` as dead reckoning on SE₂(3), whose errors are linear whatever their size: what makes `gnss` overconfident is
    // an unknown attitude times unknown biases.
    let noise =
        ImuNoise { gyroscope: 2e-3, accelerometer: 2e-2, gyroscope_bias: 0.0, accelerometer_bias: 0.0 };
    let motion = DeadReckoning::upright(noise);
    let imu = Imu {
        gyroscope: vector![0.0, 0.0, 0.4],
        accelerometer: vector![0.0, 0.4, STANDARD_GRAVITY],
        duration: 0.05,
    };
    let mean = SE23::new(SO3::identity(), Vector3::zeros(), vector![1.0, 0.0, 0.0]);
    let sigmas = SVector::from_fn(|i, _| [0.5, 0.2, 0.3][i / 3]);
    let start = Gaussian::<SE23, 9>::from_sigmas(mean, &sigmas).unwrap();
    let (far, slow) = (Covariance::unit() * 0.5, Covariance::unit() * 0.1);
    let experiment = MonteCarlo { runs: 150, ..EXPERIMENT };
    let report = experiment.run::<ChaCha8Rng>(|rng, run| {
        let (mut truth, mut belief) = (start.sample(rng), start);
        for k in 1..=200 {
            let disturbance = drawn(&motion.noise(&imu), rng);
            truth = motion.step(&truth, &imu, &disturbance);
            belief = Ekf::iterated().predict(&belief, &motion, &imu)?;
            if k % 10 == 0 {
                let position = PositionFix::of_origin(truth.position() + drawn(&far, rng), far);
                belief = Ekf::iterated().update(&belief, &position).belief;
                let velocity = VelocityFix { measured: truth.velocity() + drawn(&slow, rng), noise: slow };
                belief = Ekf::iterated().update(&belief, &velocity).belief;
                run.state("state", &truth, &belief);
            }
        }
        Ok(())
    });
    let report = report.unwrap();
    assert_eq!(state(&report).verdict(), Verdict::Consistent, "{}", state(&report).mean);
}

/// An error of a sensor.
fn drawn<const N: usize>(noise: &Covariance<N>, rng: &mut ChaCha8Rng) -> SVector<f64, N> {
    Gaussian::<Rn<N>, N>::new(Rn::identity(), *noise).sample(rng).vector()
}

#[test]
fn a_filter_that_linearises_once_and_never_resets_is_found_out() {
    let plain = Trial { rule: Rule::Extended, reset: false, ..Trial::default() };
    assert_eq!(state(&run(Simulation::Beacons, plain)).verdict(), Verdict::Overconfident);
}

#[test]
fn the_unscented_rule_makes_the_same_errors() {
    let rmse = |trial: Trial| state(&run(Simulation::Wheels, trial)).rmse_of_coordinates[0];
    let usual = rmse(Trial::default());
    let unscented = rmse(Trial { rule: Rule::Unscented, ..Trial::default() });
    assert!((unscented / usual - 1.0).abs() < 0.03, "{unscented} {usual}");
}

#[test]
fn squares_of_coordinates_add_up_to_the_whole() {
    let report = run(Simulation::Gnss, Trial::default());
    let sum: f64 = state(&report).rmse_of_coordinates.iter().map(|x| x * x).sum();
    assert!((sum.sqrt() / state(&report).rmse - 1.0).abs() < 1e-12);
}

#[test]
fn an_experiment_that_is_stopped_tells_of_the_runs_that_were_made() {
    let asked = AtomicUsize::new(0);
    let few = |finished: usize| {
        asked.fetch_add(1, Ordering::Relaxed);
        finished < 7
    };
    let stopped = Simulation::Beacons.run::<ChaCha8Rng>(Trial::default(), &EXPERIMENT, few).unwrap();
    let seven = MonteCarlo { runs: 7, ..EXPERIMENT };
    let whole = Simulation::Beacons.run::<ChaCha8Rng>(Trial::default(), &seven, |_| true).unwrap();
    assert_eq!((stopped, asked.into_inner()), (whole, EXPERIMENT.runs));
    let none = Simulation::Beacons.run::<ChaCha8Rng>(Trial::default(), &seven, |_| false).unwrap();
    assert!(none.series.is_empty());
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let three = MonteCarlo { threads: NonZeroUsize::new(3).unwrap(), ..EXPERIMENT };
    let report = Simulation::Wheels.run::<ChaCha8Rng>(Trial::default(), &three, |_| true).unwrap();
    assert_eq!(report, run(Simulation::Wheels, Trial::default()));
}

#[test]
fn standard_errors_of_pure_noise_are_those_of_theory() {
    let noise = Gaussian::<Rn<2>, 2>::from_sigmas(Rn::identity(), &vector![3.0, 0.5]).unwrap();
    let many = MonteCarlo { runs: 4000, ..EXPERIMENT };
    let report = many.run(|rng: &mut ChaCha8Rng, run| {
        run.error("noise", &noise.sample(rng).vector(), noise.covariance());
        run.error("first", &vector![noise.sample(rng).vector().x], &(Covariance::unit() * 3.0));
        Ok::<(), FilterError>(())
    });
    let report = report.unwrap();
    let [both, first] = ["noise", "first"].map(|name| report.series(name).unwrap());
    let n = 4000_f64;
    // NEES of n numbers is χ² of 2, its variance 4; RMSE of Gaussian numbers has the error σ/√(2n).
    assert!((both.standard_error * n.sqrt() / 2.0 - 1.0).abs() < 0.1, "{}", both.standard_error);
    assert!(
        (first.rmse_standard_error * (2.0 * n).sqrt() / 3.0 - 1.0).abs() < 0.1,
        "{}",
        first.rmse_standard_error
    );
    assert!((first.rmse - 3.0).abs() < 4.0 * first.rmse_standard_error);
    assert!((both.rmse_of_coordinates[1] / 0.5 - 1.0).abs() < 0.05, "{:?}", both.rmse_of_coordinates);
}
