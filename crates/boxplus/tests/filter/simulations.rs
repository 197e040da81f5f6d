//! The ready simulations: what the recommended filter claims is true in all of them, and a plain one is found out.

use boxplus::filter::{MonteCarlo, Report, Rule, Series, Simulation, Trial, Verdict};
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
