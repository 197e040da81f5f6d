//! Maps whose loops close through landmarks alone: driven over and over, seen at a place, at a distance, in a direction.

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use boxplus::graph::{
    Bearing2, Bearing3, Between, Graph, GroupVariable, Initial, Key, Noise, Range, Sighting2, Sighting3,
    Solution, SolveOptions, Values,
};
use boxplus::lie::{Action, LieGroup, Rn, SE2, SE3, SO3};
use nalgebra::{SVector, Unit, Vector2, Vector3, vector};
use rand_chacha::ChaCha8Rng;

use crate::world::{noise, rng};

/// What a pose says of a landmark.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Sensor {
    Place,
    Distance,
    Direction,
}

const SENSORS: [Sensor; 3] = [Sensor::Place, Sensor::Distance, Sensor::Direction];
/// Metres; of directions, radians.
const SIGMA: [f64; 3] = [0.05, 0.05, 0.01];
/// Landmarks farther away are not seen, metres.
const REACH: f64 = 12.0;

/// A drive among landmarks. No variable has a value.
struct Drive<P, const N: usize> {
    graph: Graph,
    values: Values,
    poses: Vec<(Key<P>, P)>,
    points: Vec<(Key<Rn<N>>, SVector<f64, N>)>,
}

/// Poses that tell the world's landmarks apart.
trait Rover<const N: usize, const D: usize>: GroupVariable<D> {
    /// The true pose after `k` steps: rounds of 80 m, with some of the third dimension where there is one.
    fn truth(k: usize) -> Self;
    /// Lifts a point of the plane into the world.
    fn lift(p: Vector2<f64>, height: f64) -> SVector<f64, N>;
    fn see(
        graph: &mut Graph,
        keys: (Key<Self>, Key<Rn<N>>),
        seen: SVector<f64, N>,
        sensor: Sensor,
        rng: &mut ChaCha8Rng,
    );
    fn seen(&self, p: &SVector<f64, N>) -> SVector<f64, N>;
}

/// Uniform noise of the given standard deviation.
fn uniform<const R: usize>(rng: &mut ChaCha8Rng, sigma: f64) -> SVector<f64, R> {
    noise::<R>(rng, sigma * 3f64.sqrt())
}

fn angle(k: usize) -> f64 {
    k as f64 / 80.0 * TAU
}

impl Rover<2, 3> for SE2 {
    fn truth(k: usize) -> Self {
        let a = angle(k);
        Self::new(vector![a.cos(), a.sin()] * 80.0 / TAU, a + TAU / 4.0)
    }
    fn lift(p: Vector2<f64>, _: f64) -> Vector2<f64> {
        p
    }
    fn seen(&self, p: &Vector2<f64>) -> Vector2<f64> {
        self.act_inverse(p)
    }
    fn see(
        graph: &mut Graph,
        keys: (Key<Self>, Key<Rn<2>>),
        seen: Vector2<f64>,
        sensor: Sensor,
        rng: &mut ChaCha8Rng,
    ) {
        let sigma = SIGMA[sensor as usize];
        let (two, one) = (uniform::<2>(rng, sigma), uniform::<1>(rng, sigma)[0]);
        match sensor {
            Sensor::Place => graph.add(keys, Sighting2 { measured: seen + two }, isotropic(sigma)),
            Sensor::Distance => graph.add(keys, Range::<_, _, 2>::new(seen.norm() + one), isotropic(sigma)),
            Sensor::Direction => graph.add(keys, Bearing2::new(seen.y.atan2(seen.x) + one), isotropic(sigma)),
        };
    }
}

impl Rover<3, 6> for SE3 {
    fn truth(k: usize) -> Self {
        let flat = SE2::truth(k);
        let position = flat.translation().push(3.0 * (3.0 * angle(k)).sin());
        Self::new(SO3::exp(&vector![0.2 * angle(k).sin(), 0.1, angle(k)]), position)
    }
    fn lift(p: Vector2<f64>, height: f64) -> Vector3<f64> {
        p.push(height)
    }
    fn seen(&self, p: &Vector3<f64>) -> Vector3<f64> {
        self.act_inverse(p)
    }
    fn see(
        graph: &mut Graph,
        keys: (Key<Self>, Key<Rn<3>>),
        seen: Vector3<f64>,
        sensor: Sensor,
        rng: &mut ChaCha8Rng,
    ) {
        let sigma = SIGMA[sensor as usize];
        let (three, one) = (uniform::<3>(rng, sigma), uniform::<1>(rng, sigma)[0]);
        match sensor {
            Sensor::Place => graph.add(keys, Sighting3::new(seen + three), isotropic(sigma)),
            Sensor::Distance => graph.add(keys, Range::<_, _, 3>::new(seen.norm() + one), isotropic(sigma)),
            Sensor::Direction => {
                let direction = Unit::new_normalize(seen.normalize() + three);
                graph.add(keys, Bearing3::new(&direction), isotropic(sigma))
            }
        };
    }
}

fn isotropic<const R: usize>(sigma: f64) -> Noise<R> {
    Noise::from_sigmas(&SVector::repeat(sigma)).unwrap()
}

/// Four rounds past landmarks on both sides, by odometry that turns by as much again as the rounds do.
fn drive<P: Rover<N, D>, const N: usize, const D: usize>(sensor: Sensor, seed: u64) -> Drive<P, N> {
    let mut rng = rng(seed);
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let poses: Vec<(Key<P>, P)> = (0..320).map(|k| (values.declare(k as u64), P::truth(k))).collect();
    let mut points = vec![];
    for k in 0..12_u32 {
        let a = f64::from(k) / 12.0 * TAU;
        let radius = 80.0 / TAU + if k % 2 == 0 { 4.0 } else { -5.0 };
        let point = P::lift(vector![a.cos(), a.sin()] * radius, f64::from(k % 3) * 2.0);
        points.push((values.declare(1000 + u64::from(k)), point));
    }
    // A sensor of the turn rate that is wrong in one direction: loops of odometry do not close.
    let bias = SVector::<f64, D>::from_fn(|row, _| if row == D - 1 { 0.01 } else { 0.0 });
    for pair in poses.windows(2) {
        let step = pair[0].1.between(&pair[1].1);
        let measured = step.rplus(&(bias + uniform::<D>(&mut rng, 0.01)));
        graph.add((pair[0].0, pair[1].0), Between::new(measured), isotropic(0.015));
    }
    for (pose, truth) in &poses {
        for (point, place) in &points {
            let seen = truth.seen(place);
            if seen.norm() < REACH {
                P::see(&mut graph, (*pose, *point), seen, sensor, &mut rng);
            }
        }
    }
    values.set(poses[0].0, poses[0].1).unwrap();
    values.hold(poses[0].0);
    Drive { graph, values, poses, points }
}

/// The optimum next to the truth, which no estimator knows.
fn optimum<P: Rover<N, D>, const N: usize, const D: usize>(drive: &Drive<P, N>) -> Solution {
    let mut values = drive.values.clone();
    drive.poses.iter().for_each(|&(key, truth)| values.set(key, truth).unwrap());
    drive.points.iter().for_each(|&(key, truth)| values.set(key, Rn::new(truth)).unwrap());
    drive.graph.optimize(&values, &SolveOptions::default()).unwrap()
}

fn the_grown_start_leads_to_the_optimum<P: Rover<N, D>, const N: usize, const D: usize>() {
    for (sensor, seed) in SENSORS.into_iter().flat_map(|sensor| [1, 2, 3].map(|seed| (sensor, seed))) {
        let drive = drive::<P, N, D>(sensor, seed);
        let start = drive.graph.initialise(&drive.values, Initial::Auto).unwrap();
        assert_eq!(start.chosen, Initial::Grown, "{sensor:?} {seed}: {:?}", start.costs);
        let found = drive.graph.optimize(&start.values, &SolveOptions::default()).unwrap();
        let best = optimum(&drive);
        let (cost, least) = (found.report.cost, best.report.cost);
        assert!(
            found.report.converged() && cost < least * (1.0 + 1e-6),
            "{} {sensor:?} {seed}: {cost} instead of {least}",
            P::NAME
        );
        for (key, _) in &drive.points {
            let [here, there] = [&found, &best].map(|s| s.values.get(*key).unwrap().vector());
            // Costs that agree to 1e-6 of some 10³ leave 0.03 standard deviations, of less than a metre each.
            assert!((here - there).norm() < 0.03, "{sensor:?} {seed}: {here} instead of {there}");
        }
    }
}

#[test]
fn maps_that_close_through_landmarks_alone_grow_to_their_optimum_in_the_plane() {
    the_grown_start_leads_to_the_optimum::<SE2, 2, 3>();
}

#[test]
fn maps_that_close_through_landmarks_alone_grow_to_their_optimum_in_space() {
    the_grown_start_leads_to_the_optimum::<SE3, 3, 6>();
}

#[test]
fn odometry_alone_is_no_start_for_such_maps() {
    let drive = drive::<SE2, 2, 3>(Sensor::Distance, 1);
    let start = drive.graph.initialise(&drive.values, Initial::SpanningTree).unwrap();
    let found = drive.graph.optimize(&start.values, &SolveOptions::default()).unwrap();
    assert!(found.report.cost > 10.0 * optimum(&drive).report.cost, "{}", found.report.cost);
}

/// Driven along a line, distances tell a beacon from its mirror image nowhere; then the way bends.
#[test]
fn a_beacon_is_told_from_its_mirror_image_as_soon_as_the_way_bends() {
    let beacon = vector![20.0, 6.0];
    for side in [1.0, -1.0] {
        let (mut graph, mut values) = (Graph::new(), Values::new());
        let truth: Vec<SE2> = (0..60)
            .map(|k| match k {
                0..40 => SE2::new(vector![f64::from(k), 0.0], 0.0),
                _ => SE2::new(vector![40.0, side * f64::from(k - 40)], side * TAU / 4.0),
            })
            .collect();
        let keys: Vec<Key<SE2>> = (0..60).map(|k| values.declare(k)).collect();
        let point = values.declare::<Rn<2>>(100);
        for k in 1..60 {
            let measured = truth[k - 1].between(&truth[k]);
            graph.add((keys[k - 1], keys[k]), Between::new(measured), isotropic(0.02));
        }
        for (key, pose) in keys.iter().zip(&truth) {
            let distance = (beacon - pose.translation()).norm();
            graph.add((*key, point), Range::<_, _, 2>::new(distance), isotropic(0.1));
        }
        let start = graph.initialise(&values, Initial::Grown).unwrap();
        let found = start.values.get(point).unwrap().vector();
        assert!((found - beacon).norm() < 1e-3, "{found}");
    }
}

#[test]
fn one_distance_or_direction_gives_a_landmark_some_place_and_the_optimiser_says_what_is_free() {
    for sensor in [Sensor::Distance, Sensor::Direction] {
        let (mut graph, mut values) = (Graph::new(), Values::new());
        let pose = values.insert(SE2::new(vector![1.0, 2.0], 0.3));
        values.hold(pose);
        let point = values.declare::<Rn<2>>(7);
        SE2::see(&mut graph, (pose, point), vector![3.0, 1.0], sensor, &mut rng(1));
        let start = graph.initialise(&values, Initial::Auto).unwrap();
        let solution = graph.optimize(&start.values, &SolveOptions::default()).unwrap();
        assert!(solution.report.cost < 1e-9 && solution.unconstrained.is_some(), "{sensor:?}");
    }
}

#[test]
fn a_growing_map_tells_how_far_it_is_and_stops_when_asked() {
    let drive = drive::<SE2, 2, 3>(Sensor::Place, 4);
    let mut seen = vec![];
    let mut observer = |growth: boxplus::graph::Growth| {
        seen.push(growth);
        if seen.len() == 5 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let start = drive.graph.initialise_observed(&drive.values, Initial::Grown, &mut observer).unwrap();
    assert_eq!(seen.len(), 5);
    assert!(seen.windows(2).all(|pair| pair[0].poses < pair[1].poses && pair[1].of == 320));
    assert!(start.cost().is_finite(), "the rest is chained on");
}

#[test]
fn growth_moves_no_held_variable() {
    let mut drive = drive::<SE2, 2, 3>(Sensor::Place, 5);
    let (pose, at) = drive.poses[200];
    let (point, place) = drive.points[3];
    drive.values.set(pose, at).unwrap();
    drive.values.set(point, Rn::new(place)).unwrap();
    drive.values.hold(pose);
    drive.values.hold(point);
    let start = drive.graph.initialise(&drive.values, Initial::Grown).unwrap();
    assert_eq!(start.values.get(pose), Some(&at));
    assert_eq!(start.values.get(point), Some(&Rn::new(place)));
}
