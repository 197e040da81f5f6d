//! How many false loop closures are found, and what they cost: the table of `docs/robustness.md`.
//!
//! ```text
//! cargo run --release -p boxplus --features solve,io,parallel --example false_closures -- --table
//! cargo run --release -p boxplus --features solve,io,parallel --example false_closures -- FILE.g2o …
//! ```
//! `--table` takes a world of every simulator that closes loops, minutes; without arguments one small world shows the idea. A file has no
//! truth: its optimum without false closures is taken for it.
#![allow(clippy::print_stdout, reason = "an example speaks")]

use std::error::Error;
use std::time::Instant;

use boxplus::graph::{GraduatedLoss, Graduation, Kernel};
use boxplus::io;
use boxplus::lie::LieGroup;
use boxplus::pose_graph::simulate::{Options, Simulator};
use boxplus::pose_graph::solve::{Pairwise, Switches, solve};
use boxplus::pose_graph::{PoseGraph, SolveSettings};

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

/// What can be done about false closures.
fn ways() -> Vec<(&'static str, SolveSettings)> {
    let usual = SolveSettings::default;
    let graduation = |loss| Some(Graduation { loss, scale: None });
    let tls = graduation(GraduatedLoss::TruncatedLeastSquares);
    let pairwise = Some(Pairwise::default());
    vec![
        ("least squares", usual()),
        ("cauchy:1", SolveSettings { kernel: Kernel::Cauchy(1.0), ..usual() }),
        ("switchable", SolveSettings { switches: Some(Switches::default()), ..usual() }),
        ("gnc-tls", SolveSettings { graduation: tls, ..usual() }),
        ("gnc-gm", SolveSettings { graduation: graduation(GraduatedLoss::GemanMcClure), ..usual() }),
        ("pcm", SolveSettings { pairwise, ..usual() }),
        ("pcm+gnc-tls", SolveSettings { pairwise, graduation: tls, ..usual() }),
    ]
}

/// The lines of one graph and one share.
fn rows(name: &str, graph: &PoseGraph, truth: &PoseGraph, share: f64) -> Result<(), Box<dyn Error>> {
    let (spoilt, places) = graph.with_false_closures(share, SEED)?;
    let closures = graph.statistics().loop_closures;
    let mut head = format!("| {name} | {:.0} %", 100.0 * share);
    for (way, settings) in ways() {
        let start = Instant::now();
        let solved = solve(&spoilt, &settings)?;
        let seconds = start.elapsed().as_secs_f64();
        let found = places.iter().filter(|place| solved.rejected.contains(place)).count();
        let lost = solved.rejected.len() - found;
        let judges =
            settings.graduation.is_some() || settings.switches.is_some() || settings.pairwise.is_some();
        let told = if judges {
            format!("{found} of {} | {lost} of {closures}", places.len())
        } else {
            "– | –".to_owned()
        };
        let cut = if solved.selection.is_some_and(|selection| !selection.is_largest) { "\\*" } else { "" };
        println!("{head} | {way}{cut} | {told} | {:.3} | {seconds:.1} |", error(&solved.graph, truth));
        "| | ".clone_into(&mut head);
    }
    Ok(())
}

/// The lines of one graph: first as it is.
fn table(name: &str, graph: &PoseGraph, truth: Option<&PoseGraph>) -> Result<(), Box<dyn Error>> {
    let start = Instant::now();
    let optimum = solve(graph, &SolveSettings::default())?.graph;
    let seconds = start.elapsed().as_secs_f64();
    let truth = truth.unwrap_or(&optimum);
    println!("| {name} | none | least squares | – | – | {:.3} | {seconds:.1} |", error(&optimum, truth));
    SHARES.iter().try_for_each(|&share| rows(name, graph, truth, share))
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("| graph | false | method | false ones found | good ones lost | error (m) | seconds |");
    println!("|---|---:|---|---:|---:|---:|---:|");
    let (options, files): (Vec<String>, Vec<String>) =
        std::env::args().skip(1).partition(|a| a.starts_with("--"));
    let whole_table = options.iter().any(|option| option == "--table");
    for path in &files {
        let graph = io::read(&std::fs::read(path)?, path, None)?.graph;
        table(path.rsplit('/').next().unwrap_or(path), &graph, None)?;
    }
    let worlds = match files.as_slice() {
        [] if whole_table => vec![
            (Simulator::Manhattan, 1000),
            (Simulator::Sphere, 900),
            (Simulator::Torus, 1000),
            (Simulator::Grid, 1000),
            (Simulator::Garage, 1000),
        ],
        [] => vec![(Simulator::Manhattan, 150)],
        _ => vec![],
    };
    for (simulator, size) in worlds {
        let world = simulator.simulate(&Options { size: Some(size), seed: SEED, ..Options::default() })?;
        table(&format!("{simulator}, {size} poses"), &world.graph, Some(&world.truth))?;
    }
    Ok(())
}
