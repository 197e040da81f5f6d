//! The public pose graphs against their known optima, in the conventions of four tools.
//!
//! The files may not be distributed with the library; without them every test here says that it skips.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test fails by panicking and says what it skips"
)]

use std::path::PathBuf;

use boxplus::graph::Initial;
use boxplus::io;
use boxplus::pose_graph::solve::solve;
use boxplus::pose_graph::{ChartKind, PoseGraph, SolveSettings};

/// The folder of the public data: `BOXPLUS_DATA`, else `shared/data` beside the checkout.
fn folder() -> Option<PathBuf> {
    let beside = || concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data").into();
    let folder = std::env::var_os("BOXPLUS_DATA").map_or_else(beside, PathBuf::from).join("pose-graph");
    if folder.is_dir() {
        return Some(folder);
    }
    println!("SKIPPED: there is no {}; set BOXPLUS_DATA to a folder with pose-graph/", folder.display());
    None
}

fn read(folder: &std::path::Path, name: &str) -> PoseGraph {
    let path = [name.to_owned(), format!("{name}.gz")]
        .map(|name| folder.join(name))
        .into_iter()
        .find(|p| p.is_file());
    let path = path.unwrap_or_else(|| panic!("{name} is not in {}", folder.display()));
    io::read(&std::fs::read(path).unwrap(), name, None).unwrap().graph
}

/// Optima of (SE-Sync, log, g2o, Ceres): the first certified, the others the best known.
const OPTIMA: [(&str, [f64; 4]); 11] = [
    ("M3500.g2o", [193.8622584, 68.95743912, 137.9129509, 68.95647547]),
    ("manhattan.g2o", [6431.391387, 1774.520535, 3549.036796, 1766.729263]),
    ("intel.g2o", [52.34822729, 22.50211654, 45.00469581, 22.20890399]),
    ("MIT.g2o", [61.15411552, 20.60347352, 41.16326884, 19.80064724]),
    ("kitti_00.g2o", [125.693515, 49.16106912, 98.32201174, 49.13134093]),
    ("sphere2500.g2o", [1687.005814, 675.7009629, 727.1496672, 677.0084937]),
    ("parking-garage.g2o", [1.262524428, 0.6341924, 1.23869058, 0.6341932]),
    ("torus3D.g2o", [24227.04556, 12117.63688, 14574.74644, 12113.52278]),
    ("sphere_bignoise_vertex3.g2o", [2961756.49, 1494168.755, 743862.7209, 1476863.346]),
    ("smallGrid3D.g2o", [1025.398056, 517.9253324, 458.1537843, 512.6990278]),
    ("tinyGrid3D.g2o", [18.51936642, 9.313909434, 6.727881617, 9.259683211]),
];

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
    let Some(folder) = folder() else { return };
    let mut missed = vec![];
    for (name, optima) in OPTIMA {
        let graph = read(&folder, name);
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
    let Some(folder) = folder() else { return };
    for (name, best) in OTHERS {
        let solved = solve(&read(&folder, name), &SolveSettings::default()).unwrap();
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
    let Some(folder) = folder() else { return };
    for name in ["MIT.g2o", "torus3D.g2o", "M3500a.g2o"] {
        let solved = solve(&read(&folder, name), &SolveSettings::default()).unwrap();
        assert_eq!(solved.initialisation, Initial::Chordal, "{name}");
        assert!(solved.given_cost.unwrap() > 10.0 * solved.initial_cost, "{name}");
    }
}
