//! How many false loop closures are found, and what they cost: the table of `docs/robustness.md`.
//!
//! ```text
//! cargo run --release -p boxplus --features solve,io,parallel --example false_closures -- --table
//! cargo run --release -p boxplus --features solve,io,parallel --example false_closures -- FILE.g2o …
//! ```
//! `--table` takes three worlds of the simulators, minutes; without arguments one small world shows the idea. A file has no truth: its optimum without false closures is taken for it.
#![allow(clippy::print_stdout, reason = "an example speaks")]

use std::error::Error;
use std::time::Instant;

use boxplus::graph::{GraduatedLoss, Graduation, Kernel};
use boxplus::io;
use boxplus::lie::LieGroup;
use boxplus::pose_graph::simulate::{Options, Simulator};
use boxplus::pose_graph::{PoseGraph, SolveSettings, solve::solve};

/// Shares of false closures among all.
const SHARES: [f64; 4] = [0.1, 0.2, 0.3, 0.5];
const SEED: u64 = 1;

/// Root mean square distance of the positions to those of `truth`, metres, both seen from their first pose.
fn error(graph: &PoseGraph, truth: &PoseGraph) -> f64 {
    let flat = graph.poses2.iter().zip(&truth.poses2).map(|(a, b)| {
        let first = [graph.poses2[0].value, truth.poses2[0].value];
        (first[0].between(&a.value).translation() - first[1].between(&b.value).translation()).norm_squared()
    });
    let spatial = graph.poses3.iter().zip(&truth.poses3).map(|(a, b)| {
        let first = [graph.poses3[0].value, truth.poses3[0].value];
        (first[0].between(&a.value).translation() - first[1].between(&b.value).translation()).norm_squared()
    });
    let squares: Vec<f64> = flat.chain(spatial).collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

/// One line of the table.
fn row(name: &str, graph: &PoseGraph, truth: &PoseGraph, share: f64) -> Result<(), Box<dyn Error>> {
    let (spoilt, places) = graph.with_false_closures(share, SEED)?;
    let closures = graph.statistics().loop_closures;
    let graduated = |loss| SolveSettings {
        graduation: Some(Graduation { loss, scale: None }),
        ..SolveSettings::default()
    };
    let ways = [
        ("least squares", SolveSettings::default()),
        ("cauchy:1", SolveSettings { kernel: Kernel::Cauchy(1.0), ..SolveSettings::default() }),
        ("gnc-tls", graduated(GraduatedLoss::TruncatedLeastSquares)),
        ("gnc-gm", graduated(GraduatedLoss::GemanMcClure)),
    ];
    for (way, settings) in ways {
        let start = Instant::now();
        let solved = solve(&spoilt, &settings)?;
        let seconds = start.elapsed().as_secs_f64();
        let found = places.iter().filter(|place| solved.rejected.contains(place)).count();
        let lost = solved.rejected.len() - found;
        let told = if settings.graduation.is_some() {
            format!("{found} of {} | {lost} of {closures}", places.len())
        } else {
            "– | –".to_owned()
        };
        println!(
            "| {name} | {:.0} % | {way} | {told} | {:.3} | {seconds:.1} |",
            100.0 * share,
            error(&solved.graph, truth)
        );
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("| graph | false | method | false ones found | good ones lost | error (m) | seconds |");
    println!("|---|---:|---|---:|---:|---:|---:|");
    let (options, files): (Vec<String>, Vec<String>) =
        std::env::args().skip(1).partition(|a| a.starts_with("--"));
    let whole_table = options.iter().any(|option| option == "--table");
    for path in &files {
        let graph = io::read(&std::fs::read(path)?, path, None)?.graph;
        let optimum = solve(&graph, &SolveSettings::default())?.graph;
        let name = path.rsplit('/').next().unwrap_or(path);
        for share in SHARES {
            row(name, &graph, &optimum, share)?;
        }
    }
    let worlds = match files.as_slice() {
        [] if whole_table => {
            vec![(Simulator::Manhattan, 1000), (Simulator::Sphere, 900), (Simulator::Garage, 1000)]
        }
        [] => vec![(Simulator::Manhattan, 150)],
        _ => vec![],
    };
    for (simulator, size) in worlds {
        let world = simulator.simulate(&Options { size: Some(size), seed: SEED, ..Options::default() })?;
        for share in SHARES {
            row(simulator.name(), &world.graph, &world.truth, share)?;
        }
    }
    Ok(())
}
