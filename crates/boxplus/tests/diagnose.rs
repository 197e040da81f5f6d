//! Every kind of fault, made on purpose in a healthy graph, is named by the diagnosis.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use boxplus::lie::SE2;
use boxplus::pose_graph::diagnose::{Freedom, Scale};
use boxplus::pose_graph::simulate::{Options, Simulator};
use boxplus::pose_graph::{Edge, Fault, Kind, Line, PoseGraph, Prior, SolveSettings, Vertex};
use nalgebra::{Matrix1, Matrix2, Vector2, vector};

fn world(simulator: Simulator, size: usize) -> PoseGraph {
    simulator.simulate(&Options { size: Some(size), seed: 1, ..Options::default() }).unwrap().graph
}

#[test]
fn a_healthy_graph_is_called_healthy() {
    for simulator in Simulator::ALL {
        let diagnosis = world(simulator, 200).diagnose();
        assert!(diagnosis.healthy(), "{simulator}: {diagnosis:?}");
        assert!(diagnosis.stopped.is_none());
        let conditioning = diagnosis.conditioning.unwrap();
        assert!(conditioning.condition > 1.0 && conditioning.condition < 1e9, "{}", conditioning.condition);
    }
}

#[test]
fn a_floating_graph_is_free_to_move_and_what_is_known_of_it_holds_it() {
    let mut graph = world(Simulator::Landmarks, 100);
    let part = graph.diagnose().parts[0];
    assert_eq!((part.freedom, part.directions(), part.poses), (Freedom::All, 3, 100));
    assert_eq!(part.points, graph.points2.len());
    let (id, measured) = (graph.points2[0].id, graph.points2[0].value);
    graph.point_priors2.push(Prior { id, measured, information: Matrix2::identity(), line: Line(0) });
    let diagnosis = graph.diagnose();
    assert_eq!(diagnosis.parts[0].freedom, Freedom::TurnAboutPoint);
    assert_eq!(diagnosis.conditioning.unwrap().unconstrained.unwrap().directions, 1); // the numbers agree
    let (id, measured) = (graph.points2[1].id, graph.points2[1].value);
    graph.point_priors2.push(Prior { id, measured, information: Matrix2::identity(), line: Line(0) });
    let diagnosis = graph.diagnose();
    assert_eq!(diagnosis.parts[0].freedom, Freedom::None);
    assert!(diagnosis.conditioning.unwrap().unconstrained.is_none());
}

#[test]
fn parts_adrift_are_counted_and_named() {
    let mut graph = world(Simulator::Manhattan, 200);
    graph.edges2.retain(|e| (e.from < 150) == (e.to < 150));
    let diagnosis = graph.diagnose();
    let told: Vec<_> = diagnosis.parts.iter().map(|part| (part.first, part.poses, part.freedom)).collect();
    assert_eq!(told, [(0, 150, Freedom::All), (150, 50, Freedom::All)]);
    assert!(!diagnosis.determined());
}

#[test]
fn a_landmark_seen_in_one_direction_only_has_no_depth() {
    let mut graph = world(Simulator::Landmarks, 100);
    let (line, id) = (Line(0), 10_000);
    graph.points2.push(Vertex { id, value: graph.poses2[50].value.translation() + vector![3.0, 0.0], line });
    graph.bearings2.push(Edge { from: 50, to: id, measured: 0.3, information: Matrix1::identity(), line });
    let conditioning = graph.diagnose().conditioning.unwrap();
    assert_eq!((conditioning.loose.len(), conditioning.loose[0].variable.label), (1, id));
    assert_eq!(conditioning.loose[0].directions.len(), 1);
    assert_eq!(conditioning.unconstrained.unwrap().directions, 1);
    assert!(conditioning.condition.is_infinite() && conditioning.weakest.is_empty());
}

#[test]
fn the_end_of_a_dead_end_is_the_weakest_and_its_sigma_is_that_of_the_marginals() {
    let mut graph = world(Simulator::Manhattan, 200);
    for k in 200..260 {
        let (line, like) = (Line(0), graph.edges2[0].clone());
        let before = graph.poses2[k - 1].value;
        graph.poses2.push(Vertex {
            id: k as u64,
            value: boxplus::lie::LieGroup::compose(&before, &like.measured),
            line,
        });
        graph.edges2.push(Edge { from: k as u64 - 1, to: k as u64, ..like });
    }
    let solved = boxplus::pose_graph::solve::solve(&graph, &SolveSettings::default()).unwrap().graph;
    let conditioning = graph.diagnose().conditioning.unwrap();
    let worst = &conditioning.weakest[0];
    assert!(worst.variable.label >= 255, "{worst:?}");
    let covariance = solved.position_covariances(&[worst.variable.label], &SolveSettings::default()).unwrap()
        [0]
    .covariance;
    let squares: f64 = worst.sigmas[..2].iter().map(|(_, sigma)| sigma * sigma).sum();
    assert!((squares / covariance.trace() - 1.0).abs() < 1e-6, "{squares} {}", covariance.trace());
    assert_eq!(worst.sigmas.len(), 3);
    assert!(worst.inflation > 10.0);
}

#[test]
fn false_loop_closures_contradict_the_rest_in_groups() {
    let graph = world(Simulator::Manhattan, 300);
    let mut spoilt = graph.clone();
    let first = spoilt.edges2.len();
    // Five in a row say that the robot came back to another street.
    for k in 0..5 {
        let like = spoilt.edges2[0].clone();
        spoilt.edges2.push(Edge {
            from: 20 + k,
            to: 220 + k,
            measured: SE2::new(vector![0.0, 0.0], 0.7),
            ..like
        });
    }
    let fit = spoilt.diagnose().fit.unwrap();
    let pairs: Vec<_> = fit.contradicting[0].iter().map(|m| (m.from, m.to.unwrap())).collect();
    assert_eq!(pairs, (0..5).map(|k| (20 + k, 220 + k)).collect::<Vec<_>>());
    assert!(fit.worst.iter().take(5).all(|m| m.from >= 20 && m.from < 25), "{:?}", fit.worst);
    assert_eq!(fit.scale, Scale::Plausible);
    assert_eq!(spoilt.edges2.len(), first + 5);
}

#[test]
fn information_of_a_wrong_scale_is_named_with_its_kind_and_no_closure_is_blamed() {
    for (factor, scale) in [(25.0, Scale::TooSure), (0.04, Scale::TooUnsure)] {
        let mut graph = world(Simulator::Sphere, 300);
        graph.edges3.iter_mut().for_each(|e| e.information *= factor);
        let fit = graph.diagnose().fit.unwrap();
        assert_eq!(fit.scale, scale);
        assert!((fit.chi2 / fit.dof as f64 / factor - 1.0).abs() < 0.1, "{fit:?}");
        assert!(fit.contradicting.is_empty());
    }
    let mut graph = world(Simulator::Landmarks, 300);
    graph.sightings2.iter_mut().for_each(|e| e.information *= 100.0);
    let fit = graph.diagnose().fit.unwrap();
    let wrong = |kind: Kind| fit.kinds.iter().find(|k| k.kind == kind).unwrap();
    assert_eq!(wrong(Kind::Sighting2).scale, Scale::TooSure);
    assert!(wrong(Kind::Sighting2).ratio > 2.0 * wrong(Kind::Edge2).ratio, "{:?}", fit.kinds);
}

#[test]
fn numbers_that_are_not_finite_are_traced_to_their_line() {
    let mut graph = world(Simulator::Manhattan, 100);
    graph.edges2[7].measured = SE2::new(Vector2::new(f64::NAN, 0.0), 0.0);
    graph.edges2[7].line = Line(108);
    graph.poses2[3].value = SE2::new(Vector2::new(0.0, f64::INFINITY), 0.0);
    let diagnosis = graph.diagnose();
    let told: Vec<_> = diagnosis.not_finite.iter().map(|n| (n.kind, n.id, n.to, n.line.0)).collect();
    assert_eq!(told, [(None, 3, None, 0), (Some(Kind::Edge2), 7, Some(8), 108)]);
    assert!(diagnosis.fit.is_none() && !diagnosis.healthy());
}

#[test]
fn indefinite_information_and_repeated_edges_are_named_and_the_rest_is_examined() {
    let mut graph = world(Simulator::Manhattan, 100);
    let last = graph.edges2.len() - 1;
    graph.edges2[last].information[(0, 0)] = -1.0;
    graph.edges2[last].line = Line(77);
    let twice = graph.edges2[0].clone();
    graph.edges2.push(twice);
    let diagnosis = graph.diagnose();
    assert!(diagnosis.faults.iter().any(|f| matches!(f, Fault::Information { .. }) && f.line().0 == 77));
    assert!(diagnosis.faults.iter().any(|f| matches!(f, Fault::Repeated { from: 0, to: 1, count: 2, .. })));
    assert!(diagnosis.fit.is_some() && diagnosis.conditioning.is_some());
}

#[test]
fn a_graph_that_cannot_be_solved_says_why() {
    let mut graph = world(Simulator::Manhattan, 50);
    graph.edges2[0].to = 999;
    let diagnosis = graph.diagnose();
    assert!(diagnosis.stopped.is_some() && !diagnosis.determined());
    assert!(PoseGraph::default().diagnose().stopped.is_some());
}
