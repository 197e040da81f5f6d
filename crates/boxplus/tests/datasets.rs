//! The public pose graphs against their known optima, in the conventions of four tools.
//!
//! The files may not be distributed with the library; without them every test here says that it skips.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test fails by panicking and says what it skips"
)]

mod public_data;

use boxplus::graph::Initial;
use boxplus::io;
use boxplus::pose_graph::solve::solve;
use boxplus::pose_graph::{ChartKind, SolveSettings};
use public_data::{OPTIMA, graph};

/// The best log costs that any solver is known to reach on the other files, to six digits.
const OTHERS: [(&str, f64); 5] = [
    ("M3500a.g2o", 456.096),
    ("manhattanOlson3500.g2o", 73.0394),
    ("ring.g2o", 5.58155),
    ("sphere_smallnoise.toro.graph", 20.7041),
    ("sphere400.isam.txt", 1266.18),
];

#[test]
fn the_known_optima_are_reached_with_default_settings_in_all_four_conventions() {
    let mut missed = vec![];
    for (name, optima) in OPTIMA {
        let Some(graph) = graph(name) else { return };
        for (chart, optimum) in
            [ChartKind::SeSync, ChartKind::Log, ChartKind::G2o, ChartKind::Ceres].into_iter().zip(optima)
        {
            let solved = solve(&graph, &SolveSettings { chart, ..SolveSettings::default() }).unwrap();
            let relative = solved.cost / optimum - 1.0;
            let report = &solved.report;
            println!(
                "{name} {chart}: {} ({relative:+.1e}), {} iterations",
                solved.cost,
                report.iterations.len()
            );
            assert!((solved.costs.of(chart) / solved.cost - 1.0).abs() < 1e-12, "{name} {chart}");
            if relative.abs() > 1e-6 || !report.converged() {
                missed.push(format!(
                    "{name} {chart}: {} instead of {optimum}, {}",
                    solved.cost, report.termination
                ));
            }
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}

#[test]
fn no_solver_is_known_to_do_better_on_the_other_files() {
    for (name, best) in OTHERS {
        let Some(graph) = graph(name) else { return };
        let solved = solve(&graph, &SolveSettings::default()).unwrap();
        println!("{name}: {}", solved.cost);
        assert!(
            solved.report.converged() && solved.cost < best * (1.0 + 5e-6),
            "{name}: {} > {best}",
            solved.cost
        );
        assert!(solved.unconstrained.is_none());
    }
}

/// From the files' own poses, plain descent ends in poor local minima on some; the start is what makes the difference.
#[test]
fn the_chordal_start_is_chosen_where_the_given_one_is_poor() {
    for name in ["MIT.g2o", "torus3D.g2o", "M3500a.g2o"] {
        let Some(graph) = graph(name) else { return };
        let solved = solve(&graph, &SolveSettings::default()).unwrap();
        assert_eq!(solved.initialisation, Initial::Chordal, "{name}");
        assert!(solved.given_cost.unwrap() > 10.0 * solved.initial_cost, "{name}");
    }
}

/// Victoria Park closes its loops through landmarks alone: from chained odometry descent sticks a hundred times higher. In the
/// torus poses are joined, too, so that the chordal start leaves nothing to grow for.
#[test]
fn landmark_maps_reach_their_optimum() {
    let maps = [
        ("victoriaPark.isam.txt", 6184.12, Initial::Grown),
        ("torus2000Points.isam.txt", 9396.51, Initial::Chordal),
    ];
    for (name, chi2, start) in maps {
        let Some(bytes) = public_data::bytes(&format!("landmark-slam/{name}")) else { return };
        let graph = io::read(&bytes, name, None).unwrap().graph;
        let solved = solve(&graph, &SolveSettings::default()).unwrap();
        println!("{name}: chi2 {}", 2.0 * solved.cost);
        assert_eq!(solved.initialisation, start, "{name}");
        assert!(solved.report.converged() && (2.0 * solved.cost - chi2).abs() < 0.005, "{name}");
    }
}

/// Maps with ranges, started without the vertices of their files. `(χ², metres to the poses of the file, metres to its points)`; the points of
/// GOATS are in another frame than its poses, and the noise of the drone is stated so large that its beacon has a rival that fits better.
#[test]
fn maps_with_ranges_start_without_their_truth_and_end_near_it() {
    let maps = [
        ("goats_15.pyfg", 35699.1457, 3.95, f64::INFINITY),
        ("plaza1.pyfg.gz", 2660.49474, 0.302, 0.057),
        ("single_drone.pyfg.gz", 15.3951545, 0.54, f64::INFINITY),
    ];
    for (name, chi2, position, landmark) in maps {
        let Some(bytes) = public_data::bytes(&format!("ranging/{name}")) else { return };
        let truth = io::read(&bytes, name, None).unwrap().graph;
        let solved = solve(&truth.measurements_only(), &SolveSettings::default()).unwrap();
        let error = solved.graph.error_beside(&truth).unwrap();
        println!("{name}: chi2 {}, {error:?}", 2.0 * solved.cost);
        assert_eq!(solved.initialisation, Initial::Grown);
        assert!(solved.report.converged() && (2.0 * solved.cost / chi2 - 1.0).abs() < 1e-6, "{name}");
        assert!(error.position < position && error.landmark < landmark, "{name}: {error:?}");
    }
}
