//! Smoothing and mapping with self-calibration, Solà et al. (2018) §V-B to §V-D: estimates err as much as they claim.

use boxplus::graph::{BeaconDrive, Driven, Sees, SolveOptions};
use boxplus::lie::{SE2, SE3};
use boxplus::uncertainty::ChiSquared;
use nalgebra::SVector;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// What is assumed of the bias.
type Assumed = Option<SVector<f64, 2>>;

fn driven<G: Sees<D, N>, const D: usize, const N: usize>(
    drive: &BeaconDrive<G, D, N>,
    assumed: Assumed,
    seed: usize,
) -> Driven<G, D, N> {
    let driven = drive.simulate(&mut ChaCha8Rng::seed_from_u64(seed as u64)).unwrap();
    match assumed {
        Some(bias) => driven.with_bias(bias).unwrap(),
        None => driven,
    }
}

/// Mean NEES of the bias, the beacons, the last pose and everything, and the mean of twice the cost, each over its dimension's 99.9 %
/// interval: −1 at its lower end, 1 at its upper.
fn means<G: Sees<D, N>, const D: usize, const N: usize>(
    drive: &BeaconDrive<G, D, N>,
    assumed: Assumed,
    runs: usize,
) -> Vec<(&'static str, f64)> {
    let mut sums: Vec<(&'static str, usize, f64)> = vec![];
    for seed in 0..runs {
        let driven = driven(drive, assumed, seed);
        let solution = driven.graph.optimize(&driven.start, &SolveOptions::default()).unwrap();
        assert!(solution.report.converged());
        let judged = driven.nees(&solution.values).unwrap();
        let measured = D * driven.poses.len() + N * drive.sightings.len();
        let freedom = measured - judged.last().unwrap().dimension;
        let parts = judged.iter().map(|part| (part.of, part.dimension, part.squared));
        let parts: Vec<_> = parts.chain([("cost", freedom, 2.0 * solution.report.cost)]).collect();
        if sums.is_empty() {
            sums = parts;
        } else {
            sums.iter_mut().zip(parts).for_each(|(sum, part)| sum.2 += part.2);
        }
    }
    let place = |(of, dimension, sum): (&'static str, usize, f64)| {
        let [low, high] = ChiSquared::new(dimension * runs).interval(0.999).unwrap();
        (of, (2.0 * sum - low - high) / (high - low))
    };
    sums.into_iter().map(place).collect()
}

fn consistent<G: Sees<D, N>, const D: usize, const N: usize>(drive: &BeaconDrive<G, D, N>, runs: usize) {
    for (assumed, parts) in [(None, 5), (Some(drive.bias), 4)] {
        let means = means(drive, assumed, runs);
        assert!(
            means.len() == parts && means.iter().all(|(_, place)| place.abs() < 1.0),
            "{assumed:?} {means:?}"
        );
    }
}

#[test]
fn poses_beacons_and_bias_in_the_plane_err_as_much_as_they_claim() {
    consistent(&BeaconDrive::in_plane(), 60);
    consistent(&BeaconDrive::<SE2, 3, 2>::demonstration(), 400);
}

#[test]
fn poses_beacons_and_bias_in_space_err_as_much_as_they_claim() {
    consistent(&BeaconDrive::in_space(), 12);
    consistent(&BeaconDrive::<SE3, 6, 3>::demonstration(), 200);
}

#[test]
fn a_bias_that_is_ignored_is_found_out() {
    let means = means(&BeaconDrive::in_plane(), Some(SVector::zeros()), 3);
    assert!(means.iter().all(|(of, place)| *place > 3.0 || *of == "last pose"), "{means:?}");
}

#[test]
fn a_drive_is_a_function_of_its_generator_and_starts_at_dead_reckoning() {
    let drive = BeaconDrive::in_space();
    let [a, b, c] = [5, 5, 6].map(|seed| driven(&drive, None, seed));
    let last = *a.poses.last().unwrap();
    assert_eq!(a.start.get(last), b.start.get(last));
    assert_ne!(a.start.get(last), c.start.get(last));
    // Sixty steps of 0.5 m, read as 0.55.
    let driven = |values: &boxplus::graph::Values| -> f64 {
        let place = |i: usize| values.get(a.poses[i]).unwrap().translation();
        (1..61).map(|i| (place(i) - place(i - 1)).norm()).sum()
    };
    assert!((driven(&a.truth) - 30.0).abs() < 0.5 && (driven(&a.start) - 33.0).abs() < 0.7);
    // Every beacon is seen, and pairs that there are not do no harm.
    assert!((0..drive.beacons.len()).all(|k| drive.sightings.iter().any(|s| s.1 == k)));
    let more = BeaconDrive { sightings: vec![(0, 99), (99, 0)], ..drive };
    assert_eq!(more.simulate(&mut ChaCha8Rng::seed_from_u64(1)).unwrap().graph.len(), 61);
}
