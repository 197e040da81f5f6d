//! The certificate of global optimality: right where the optimum is known, and a way down where it is not one.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test fails by panicking and says what it measured"
)]

mod public_data;

use std::ops::ControlFlow;

use boxplus::graph::Initial;
use boxplus::lie::{LieGroup, SE2};
use boxplus::pose_graph::certify::{CertifyError, Verdict, certify, certify_observed};
use boxplus::pose_graph::simulate::{Options, Simulator};
use boxplus::pose_graph::solve::solve;
use boxplus::pose_graph::{ChartKind, Costs, Edge, Line, PoseGraph, SolveSettings, Vertex};
use nalgebra::{Matrix3, Vector2};
use public_data::{OPTIMA, graph};

#[test]
fn the_known_optima_are_certified() {
    for (name, [optimum, ..]) in OPTIMA {
        let Some(graph) = graph(name) else { return };
        let settings = SolveSettings::default();
        let solved = solve(&graph, &settings).unwrap();
        let c = certify(&solved.graph, &settings).unwrap();
        println!("{name}: {} at least {} ({:.1e})", c.cost, c.lower_bound, c.gap() / c.cost);
        assert_eq!((c.given, c.verdict, c.escapes), (Verdict::Optimal, Verdict::Optimal, 0), "{name}");
        assert!((c.cost / optimum - 1.0).abs() < 1e-8 && c.gap() <= 1e-6 * c.cost, "{name}: {}", c.cost);
        assert!(c.lower_bound <= optimum * (1.0 + 1e-9), "{name}: no bound, {}", c.lower_bound);
    }
}

/// From the vertices of the file, descent ends in a minimum twenty times too high.
#[test]
fn a_local_minimum_of_real_data_is_left_for_the_optimum() {
    let Some(graph) = graph("MIT.g2o") else { return };
    let settings = SolveSettings { initial: Initial::AsGiven, ..SolveSettings::default() };
    let solved = solve(&graph, &settings).unwrap();
    let c = certify(&solved.graph, &settings).unwrap();
    assert!(c.given == Verdict::NotOptimal && c.given_cost > 1000.0, "{}", c.given_cost);
    assert!(c.descent.unwrap().curvature < 0.0);
    assert!(c.verdict == Verdict::Optimal && (c.cost / 61.15411552 - 1.0).abs() < 1e-8, "{}", c.cost);
}

/// A ring of poses, turned once too often: every pose is a stationary point, the sum of squares far from zero.
fn twisted(count: usize) -> PoseGraph {
    let mut graph = PoseGraph::default();
    let turn = std::f64::consts::TAU / count as f64;
    let line = Line(0);
    for i in 0..count {
        let angle = 2.0 * turn * i as f64; // the measurements turn once
        graph.poses2.push(Vertex { id: i as u64, value: SE2::new(Vector2::zeros(), angle), line });
        graph.edges2.push(Edge {
            from: i as u64,
            to: ((i + 1) % count) as u64,
            measured: SE2::new(Vector2::zeros(), turn),
            information: Matrix3::identity(),
            line,
        });
    }
    graph
}

#[test]
fn a_ring_that_is_twisted_once_is_untwisted() {
    for count in [8, 20, 50] {
        let graph = twisted(count);
        let c = certify(&graph, &SolveSettings::default()).unwrap();
        assert_eq!(c.given, Verdict::NotOptimal, "{count}");
        let step = 2.0 * (std::f64::consts::PI / count as f64).sin();
        let twisted = 2.0 * count as f64 * step * step; // ‖R − R̃‖² = 2·(2 sin(½·angle))²
        assert!((c.given_cost / twisted - 1.0).abs() < 1e-9, "{count}: {} {twisted}", c.given_cost);
        assert_eq!((c.verdict, c.escapes), (Verdict::Optimal, 1), "{count}");
        assert!(c.cost < 1e-18, "{count}: {}", c.cost);
        assert_eq!(c.graph.poses2[0], graph.poses2[0], "the first pose stays");
    }
}

/// The bound holds against every estimate: the poses that made the measurements, and those of other starts.
#[test]
fn the_bound_lies_below_every_estimate() {
    for (world, noise) in [(Simulator::Sphere, 3.0), (Simulator::Torus, 5.0), (Simulator::Manhattan, 4.0)] {
        for seed in 0..3 {
            let usual = Options::default();
            let (sigma_translation, sigma_rotation) =
                (noise * usual.sigma_translation, noise * usual.sigma_rotation);
            let options = Options { size: Some(120), sigma_translation, sigma_rotation, seed, ..usual };
            let world = world.simulate(&options).unwrap();
            let settings = SolveSettings { chart: ChartKind::SeSync, ..SolveSettings::default() };
            let solved = solve(&world.graph, &settings).unwrap();
            let c = certify(&solved.graph, &settings).unwrap();
            let (poses2, poses3) = (world.truth.poses2, world.truth.poses3);
            let truth = PoseGraph { poses2, poses3, ..world.graph };
            let truth = Costs::new(&truth, &settings).unwrap().se_sync;
            assert!(
                c.lower_bound <= truth && c.lower_bound <= c.cost && c.cost <= solved.cost * (1.0 + 1e-9)
            );
            let again = Costs::new(&c.graph, &settings).unwrap().se_sync;
            assert!((again / c.cost - 1.0).abs() < 1e-9, "{again} {}", c.cost);
        }
    }
}

#[test]
fn what_the_proof_does_not_cover_is_refused_by_name() {
    let settings = SolveSettings::default();
    let landmarks = Simulator::Landmarks.simulate(&Options { size: Some(60), ..Options::default() }).unwrap();
    let error = certify(&landmarks.graph, &settings).unwrap_err();
    assert!(matches!(error, CertifyError::Measurements { .. }), "{error}");
    let mut alone = twisted(5);
    alone.poses2.push(Vertex { id: 99, value: SE2::identity(), line: Line(0) });
    let error = certify(&alone, &settings).unwrap_err();
    assert_eq!(error, CertifyError::Unsolved { count: 1, poses: 6 });
    let held = SolveSettings { fixed: vec![0, 3], ..SolveSettings::default() };
    assert_eq!(certify(&twisted(5), &held).unwrap_err(), CertifyError::Held { count: 2 });
    let mut not_finite = twisted(5);
    not_finite.poses2[2].value = SE2::new(Vector2::new(f64::NAN, 0.0), 0.0);
    assert_eq!(certify(&not_finite, &settings).unwrap_err(), CertifyError::Unsolved { count: 1, poses: 5 });
}

#[test]
fn an_observer_stops_the_search_with_what_is_known() {
    let c =
        certify_observed(&twisted(20), &SolveSettings::default(), &mut |_| ControlFlow::Break(())).unwrap();
    assert!(c.stopped && c.escapes == 0 && c.lower_bound <= c.cost);
}

#[test]
fn parts_that_nothing_joins_are_certified_together() {
    let mut graph = twisted(8);
    let other = twisted(9);
    graph.poses2.extend(other.poses2.iter().map(|v| Vertex { id: v.id + 100, ..v.clone() }));
    graph.edges2.extend(other.edges2.iter().map(|e| Edge {
        from: e.from + 100,
        to: e.to + 100,
        ..e.clone()
    }));
    let c = certify(&graph, &SolveSettings::default()).unwrap();
    assert!(c.verdict == Verdict::Optimal && c.cost < 1e-18, "{c:?}");
    assert_eq!((&c.graph.poses2[0], &c.graph.poses2[8]), (&graph.poses2[0], &graph.poses2[8]));
}
