//! The certificate of global optimality: right where the optimum is known, and a way down where it is not one.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test fails by panicking and says what it measured"
)]

use std::path::PathBuf;

use boxplus::graph::Initial;
use boxplus::io;
use boxplus::pose_graph::certify::{Verdict, certify};
use boxplus::pose_graph::solve::solve;
use boxplus::pose_graph::{PoseGraph, SolveSettings};

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

/// SE-Sync's optima; see `datasets.rs`.
const OPTIMA: [(&str, f64); 11] = [
    ("M3500.g2o", 193.8622584),
    ("manhattan.g2o", 6431.391387),
    ("intel.g2o", 52.34822729),
    ("MIT.g2o", 61.15411552),
    ("kitti_00.g2o", 125.693515),
    ("sphere2500.g2o", 1687.005814),
    ("parking-garage.g2o", 1.262524428),
    ("torus3D.g2o", 24227.04556),
    ("sphere_bignoise_vertex3.g2o", 2961756.49),
    ("smallGrid3D.g2o", 1025.398056),
    ("tinyGrid3D.g2o", 18.51936642),
];

#[test]
fn the_known_optima_are_certified() {
    let Some(folder) = folder() else { return };
    for (name, optimum) in OPTIMA {
        let graph = read(&folder, name);
        let settings = SolveSettings::default();
        let solved = solve(&graph, &settings).unwrap();
        let start = std::time::Instant::now();
        let c = certify(&solved.graph, &settings).unwrap();
        println!(
            "{name}: {:?} {:?} cost {} (known {optimum}) bound {} gap {:.1e} eigenvalue {:.1e} escapes {} {:?}",
            c.given,
            c.verdict,
            c.cost,
            c.lower_bound,
            c.gap() / c.cost,
            c.eigenvalue,
            c.escapes,
            start.elapsed()
        );
        assert!((c.cost / optimum - 1.0).abs() < 1e-6);
    }
}

#[test]
fn local_minima_are_left() {
    let Some(folder) = folder() else { return };
    for (name, optimum) in OPTIMA {
        let graph = read(&folder, name);
        let settings = SolveSettings { initial: Initial::AsGiven, ..SolveSettings::default() };
        let Ok(solved) = solve(&graph, &settings) else { continue };
        let start = std::time::Instant::now();
        let c = certify(&solved.graph, &settings).unwrap();
        println!(
            "{name}: {:?} at {} {:?} cost {} (known {optimum}) bound {} gap {:.1e} eigenvalue {:.1e} escapes {} {:?}",
            c.given,
            c.given_cost,
            c.verdict,
            c.cost,
            c.lower_bound,
            c.gap() / c.cost,
            c.eigenvalue,
            c.escapes,
            start.elapsed()
        );
    }
}
