//! From a pose graph to its optimum: faults, policies, gauge, landmarks.
#![allow(
    clippy::unwrap_used,
    clippy::format_push_string,
    reason = "a test fails by panicking, and need not be fast"
)]

use std::ops::ControlFlow;

use boxplus::graph::{Kernel, Termination};
use boxplus::io;
use boxplus::lie::{Action, LieGroup, SE2};
use boxplus::pose_graph::simulate::{Options, Simulator};
use boxplus::pose_graph::solve::{Progress, solve, solve_observed};
use boxplus::pose_graph::{ChartKind, Fault, Indefinite, PoseGraph, PoseGraphError, SolveSettings};

fn world(simulator: Simulator, size: usize) -> PoseGraph {
    simulator.simulate(&Options { size: Some(size), seed: 3, ..Options::default() }).unwrap().graph
}

fn read(text: &str) -> PoseGraph {
    io::read(text.as_bytes(), "test.g2o", None).unwrap().graph
}

#[test]
fn every_simulated_world_is_solved_to_the_noise_it_was_made_with() {
    for simulator in Simulator::ALL {
        let graph = world(simulator, 400);
        let solved = solve(&graph, &SolveSettings::default()).unwrap();
        assert!(
            solved.report.converged() && solved.unconstrained.is_none(),
            "{simulator}: {:?}",
            solved.report
        );
        // Twice the cost is χ² with as many degrees of freedom as there are residuals beyond the unknowns.
        let residuals: usize = graph.constraints().map(|c| c.information.len().isqrt()).sum();
        let dof = (residuals - solved.report.unknowns) as f64;
        let (chi2, sigma) = (2.0 * solved.costs.log, (2.0 * dof).sqrt());
        assert!((chi2 - dof).abs() < 4.0 * sigma, "{simulator}: {chi2} for {dof} ± {sigma}");
        let sum: f64 = solved.chi2.iter().sum();
        assert!((sum - chi2).abs() < 1e-9 * chi2, "{simulator}");
    }
}

#[test]
fn the_solved_graph_has_the_cost_that_is_reported() {
    let graph = world(Simulator::Torus, 300);
    for chart in ChartKind::ALL {
        let settings = SolveSettings { chart, ..SolveSettings::default() };
        let solved = solve(&graph, &settings).unwrap();
        let again = solve(&solved.graph, &settings).unwrap();
        assert!((again.given_cost.unwrap() / solved.cost - 1.0).abs() < 1e-12, "{chart}");
        assert!((solved.costs.of(chart) / solved.cost - 1.0).abs() < 1e-12, "{chart}");
        assert!(again.cost <= solved.cost * (1.0 + 1e-12), "{chart}");
    }
}

#[test]
fn a_graph_without_vertices_gets_them() {
    let mut graph = world(Simulator::Manhattan, 300);
    let with = solve(&graph, &SolveSettings::default()).unwrap();
    graph.poses2.clear();
    let without = solve(&graph, &SolveSettings::default()).unwrap();
    assert_eq!(without.graph.poses2.len(), 300);
    assert!(without.given_cost.is_none());
    assert!((without.cost / with.cost - 1.0).abs() < 1e-8);
    assert_eq!(without.report.gauge[0].label, 0);
}

#[test]
fn what_is_fixed_does_not_move() {
    let mut graph = world(Simulator::Sphere, 200);
    graph.fixed = vec![17];
    let settings = SolveSettings { fixed: vec![99], ..SolveSettings::default() };
    let solved = solve(&graph, &settings).unwrap();
    for id in [17, 99] {
        assert_eq!(solved.graph.poses3[id], graph.poses3[id]);
    }
    assert!(solved.report.gauge.is_empty());
    assert_eq!(solved.report.unknowns, 198 * 6);
    let unknown = SolveSettings { fixed: vec![4711], ..SolveSettings::default() };
    assert_eq!(solve(&graph, &unknown).err(), Some(PoseGraphError::NoSuchVertex { id: 4711 }));
}

#[test]
fn bad_information_is_refused_by_name_or_mended_as_asked() {
    let mut graph = world(Simulator::Manhattan, 100);
    graph.edges2[7].information[(0, 0)] = -3.0;
    graph.edges2[9].information *= 0.0;
    let refused = solve(&graph, &SolveSettings::default()).err().unwrap();
    let PoseGraphError::Faulty { faults } = &refused else { panic!("{refused}") };
    assert_eq!(faults.len(), 2);
    assert!(faults.iter().all(|fault| matches!(fault, Fault::Information { .. })), "{refused}");

    graph.edges2[9].information = graph.edges2[8].information;
    for indefinite in [Indefinite::Clamp, Indefinite::Skip] {
        let solved = solve(&graph, &SolveSettings { indefinite, ..SolveSettings::default() }).unwrap();
        assert!(solved.report.converged() && solved.mended.len() == 1, "{indefinite:?}");
        assert_eq!(solved.chi2[7].is_nan(), indefinite == Indefinite::Skip);
    }
}

#[test]
fn what_is_beyond_mending_is_still_refused_by_name() {
    let graph = read("EDGE_SE2 0 1 1 0 0 -1 0 0 -1 0 -1\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n");
    let clamp = SolveSettings { indefinite: Indefinite::Clamp, ..SolveSettings::default() };
    let error = solve(&graph, &clamp).err().unwrap();
    assert!(error.to_string().contains("not positive definite"), "{error}");
    // One negative eigenvalue can be raised, also where the weights of SE-Sync are derived from it.
    let graph = read("EDGE_SE2 0 1 1 0 0 1 0 0 -1 0 1\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n");
    assert!(solve(&graph, &clamp).unwrap().costs.se_sync < 1e-15);
}

#[test]
fn what_cannot_be_used_is_named_even_where_no_single_number_is_at_fault() {
    // Far lever arms: the information of the body is not positive definite to rounding.
    let text = "PARAMS_SE3OFFSET 0 1e9 2e9 3e9 0 0 0 1\nVERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n\
                EDGE_SE3_PRIOR 0 0 0 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n";
    let error = solve(&read(text), &SolveSettings::default()).err().unwrap();
    assert!(error.to_string().contains("line 3 cannot be used"), "{error}");

    let point = solve(&read("EDGE_PRIOR_XY 9 1 2 1 0 1\n"), &SolveSettings::default()).unwrap();
    assert!((point.graph.points2[0].value - nalgebra::vector![1.0, 2.0]).amax() < 1e-9);

    let mut graph = read("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n");
    graph.poses2[1].id = 0;
    let error = solve(&graph, &SolveSettings::default()).err();
    assert_eq!(error, Some(PoseGraphError::AmbiguousVertex { id: 0 }));
}

#[test]
fn vertices_that_nothing_measures_have_no_covariance_and_stop_no_other() {
    let graph =
        read("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nVERTEX_SE2 2 5 5 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n");
    let sure = graph.position_covariances(&[0, 1, 2], &SolveSettings::default()).unwrap();
    assert_eq!(sure.iter().map(|one| one.id).collect::<Vec<_>>(), [0, 1]);
}

#[test]
fn dangling_edges_are_refused_by_name() {
    let graph = read("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 5 1 0 0 1 0 0 1 0 1\n");
    let error = solve(&graph, &SolveSettings::default()).err().unwrap();
    assert!(error.to_string().contains("EDGE_SE2 refers to 5, which is no vertex"), "{error}");
    assert_eq!(solve(&PoseGraph::default(), &SolveSettings::default()).err(), Some(PoseGraphError::Empty));
}

#[test]
fn parts_that_nothing_joins_are_counted_and_each_gets_a_gauge() {
    let edge = |i, j| format!("EDGE_SE2 {i} {j} 1 0 0.1 1 0 0 1 0 1\n");
    let graph = read(&[edge(0, 1), edge(1, 2), edge(10, 11)].concat());
    let solved = solve(&graph, &SolveSettings::default()).unwrap();
    assert!(solved.parts == 2 && solved.falls_apart());
    assert_eq!(solved.report.gauge.iter().map(|name| name.label).collect::<Vec<_>>(), [0, 10]);
}

#[test]
fn landmarks_priors_and_bearings_of_a_file_are_used() {
    let truth = [SE2::identity(), SE2::new(nalgebra::vector![2.0, 0.5], 0.4)];
    let tree = nalgebra::Vector2::<f64>::new(3.0, 3.0);
    let mut text = "EDGE_PRIOR_SE2 0 0 0 0 100 0 0 100 0 100\n".to_owned();
    for (id, pose) in truth.iter().enumerate() {
        let seen = pose.act_inverse(&tree);
        let (x, y, angle) = (seen.x, seen.y, seen.y.atan2(seen.x));
        text += &format!("EDGE_SE2_XY {id} 9 {x} {y} 25 0 25\nEDGE_BEARING_SE2_XY {id} 9 {angle} 400\n");
    }
    let step = truth[0].between(&truth[1]);
    text += &format!(
        "EDGE_SE2 0 1 {} {} {} 1 0 0 1 0 1\n",
        step.translation().x,
        step.translation().y,
        step.angle()
    );
    let solved = solve(&read(&text), &SolveSettings::default()).unwrap();
    assert!(
        solved.report.converged() && solved.cost < 1e-15 && solved.report.gauge.is_empty(),
        "{}",
        solved.cost
    );
    assert!((solved.graph.points2[0].value - tree).amax() < 1e-7);
    let sure = solved.graph.position_covariances(&[0, 1, 9, 77], &SolveSettings::default()).unwrap();
    assert_eq!(sure.iter().map(|one| one.id).collect::<Vec<_>>(), [0, 1, 9]);
    assert!(sure.iter().all(|one| one.covariance[(0, 0)] > 0.0 && one.covariance[(2, 2)] == 0.0));
}

#[test]
fn a_prior_measured_by_a_sensor_places_the_body() {
    // The sensor sits one metre ahead of the body and looks left.
    let text = "PARAMS_SE3OFFSET 0 1 0 0 0 0 0.7071067811865476 0.7071067811865476\n\
                VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n\
                EDGE_SE3_PRIOR 0 0 5 2 0 0 0 0.7071067811865476 0.7071067811865476 \
                4 0 0 0 0 0 4 0 0 0 0 4 0 0 0 100 0 0 100 0 100\n";
    let solved = solve(&read(text), &SolveSettings::default()).unwrap();
    let body = solved.graph.poses3[0].value;
    assert!((body.translation() - nalgebra::vector![4.0, 2.0, 0.0]).amax() < 1e-9, "{body:?}");
    // One radian of yaw swings the sensor sideways by one metre: the body's own y is less sure than the sensor's.
    let sure = solved.graph.position_covariances(&[0], &SolveSettings::default()).unwrap()[0].covariance;
    assert!((sure[(0, 0)] - 0.25).abs() < 1e-9 && (sure[(1, 1)] - (0.25 + 0.01)).abs() < 1e-9, "{sure}");
}

#[test]
fn an_interrupted_solve_returns_the_best_so_far() {
    let graph = world(Simulator::Sphere, 300);
    let mut steps = 0;
    let mut observer = |progress: Progress<'_>| match progress {
        Progress::Iteration(_) if steps == 0 => {
            steps += 1;
            ControlFlow::Break(())
        }
        _ => ControlFlow::Continue(()),
    };
    let solved = solve_observed(&graph, &SolveSettings::default(), &mut observer).unwrap();
    assert_eq!(solved.report.termination, Termination::Interrupted);
    assert!(solved.cost < solved.initial_cost);
    let at_once = solve_observed(&graph, &SolveSettings::default(), &mut |_| ControlFlow::Break(())).unwrap();
    assert_eq!(at_once.report.termination, Termination::Interrupted);
    assert_eq!(at_once.graph, at_once.initial);
}

#[test]
fn a_robust_kernel_finds_the_false_closures() {
    let options = Options { size: Some(400), seed: 5, outliers: 0.05, ..Options::default() };
    let simulated = Simulator::Manhattan.simulate(&options).unwrap();
    let position =
        |graph: &PoseGraph, k: usize| graph.poses2[0].value.act_inverse(&graph.poses2[k].value.translation());
    let error = |kernel| {
        let solved = solve(&simulated.graph, &SolveSettings { kernel, ..SolveSettings::default() }).unwrap();
        let worst = (0..400).map(|k| (position(&solved.graph, k) - position(&simulated.truth, k)).norm());
        (worst.fold(0.0, f64::max), solved)
    };
    let (plain, _) = error(Kernel::None);
    // Convex kernels do not depend on the start; those that redescend need a good one.
    let (robust, solved) = error(Kernel::Fair(1.0));
    assert!(robust < 2.0 && robust < 0.2 * plain, "{robust} m, without kernel {plain} m");
    assert!(solved.worst(5).iter().all(|misfit| misfit.chi2 > 100.0), "{:?}", solved.worst(5));
}
