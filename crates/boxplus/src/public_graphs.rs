//! The linear core on public graphs: checked always, timed beside faer's on demand; and how the solver grows with its graphs:
//!
//! ```sh
//! BOXPLUS_DATA=... cargo test --release -p boxplus --features solve,io --lib factor_speed -- --ignored --nocapture
//! BOXPLUS_WORLDS=manhattan:1000,grid:1000 cargo test --release -p boxplus --features solve,io --lib growth -- --ignored --nocapture
//! ```
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test fails by panicking, and prints what it measures"
)]

#[path = "../tests/public_data/mod.rs"]
mod public_data;

use std::time::Instant;

use crate::graph::linear::cholesky::Cholesky;
use crate::graph::linear::oracle::{Oracle, TileRate, entries, graph_of, normal_equations};
use crate::graph::linear::pattern::Pattern;
use crate::graph::{Graph, Initial, SolveOptions, Values, VariableId};
use crate::lie::{SE2, SE3};
use crate::pose_graph::simulate::{Options, Simulator};
use crate::pose_graph::solve::factors;

const FILES: [&str; 9] = [
    "pose-graph/M3500.g2o",
    "pose-graph/intel.g2o",
    "pose-graph/MIT.g2o",
    "pose-graph/kitti_00.g2o",
    "pose-graph/parking-garage.g2o",
    "pose-graph/sphere2500.g2o",
    "pose-graph/torus3D.g2o.gz",
    "pose-graph/sphere_bignoise_vertex3.g2o",
    "landmark-slam/victoriaPark.isam.txt",
];

/// The graph of a public file at its initialisation, or `None` where there is no such file.
fn problem(name: &str) -> Option<(Graph, Values)> {
    let text = public_data::bytes(name)?;
    let (graph, values) = factors(&crate::io::read(&text, name, None).unwrap().graph).unwrap();
    let start = graph.initialise(&values, Initial::SpanningTree).unwrap();
    Some((graph, start.values))
}

/// The least seconds of several runs.
fn least(runs: usize, mut run: impl FnMut()) -> f64 {
    let time = |()| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    };
    std::iter::repeat_n((), runs).map(time).fold(f64::INFINITY, f64::min)
}

#[test]
#[ignore = "measures time"]
fn factor_speed() {
    let mut tile = TileRate::new();
    let seconds = least(2000, || tile.run());
    println!("the register tile alone, in the first cache: {:.1} GFlop/s", TileRate::FLOP / seconds * 1e-9);
    println!(
        "| graph | unknowns | analyse ms | GFlop | numbers in L | factorise ms | GFlop/s | faer ms | faer / ours | selected inverse ms | in factorisations |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    for name in FILES {
        let Some((graph, values)) = problem(name) else { continue };
        let (pattern, mut matrix) = normal_equations(&graph, &values).unwrap();
        pattern.diagonal().into_iter().for_each(|at| matrix[at] *= 1.0 + 1e-6);
        let (dims, pairs) = graph_of(&pattern);
        let analyse = least(5, || drop(Cholesky::new(&Pattern::new(&dims, &pairs).unwrap())));
        let mut ours = Cholesky::new(&pattern).unwrap();
        let mut theirs = Oracle::new(&pattern);
        theirs.read(&matrix);
        let (mut factorise, mut faer) = (f64::INFINITY, f64::INFINITY);
        for _ in 0..40 {
            factorise = factorise.min(least(1, || ours.factorise(&matrix).unwrap()));
            faer = faer.min(least(1, || assert!(theirs.factorise())));
        }
        let invert = least(10, || ours.invert().unwrap());
        let flop = ours.multiplications() as f64 * 2e-9;
        println!(
            "| {name} | {} | {:.2} | {flop:.4} | {} | {:.2} | {:.1} | {:.2} | {:.2} | {:.2} | {:.2} |",
            pattern.size(),
            analyse * 1e3,
            ours.factor_len(),
            factorise * 1e3,
            flop / factorise,
            faer * 1e3,
            faer / factorise,
            invert * 1e3,
            invert / factorise,
        );
    }
}

/// Seconds that this thread has computed, where Linux tells; else those that have passed.
fn cpu_seconds(start: Instant) -> f64 {
    let nanoseconds = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let first = nanoseconds.and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    first.map_or_else(|| start.elapsed().as_secs_f64(), |ns| ns * 1e-9)
}

/// The largest memory of the process so far, in MB; NaN where Linux does not tell.
fn peak_memory() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok()).map_or(f64::NAN, |kb| kb / 1e3)
}

/// What [`growth`] measures unless told otherwise.
const WORLDS: &str = "manhattan:1000,manhattan:10000,manhattan:100000,grid:1000,grid:8000";

/// How long a simulated graph of one size takes.
struct Growth {
    poses: usize,
    measurements: usize,
    initialise: f64,
    optimise: f64,
    steps: usize,
    megabytes: f64,
    numbers: usize,
    flop: f64,
    factorise: f64,
}

impl Growth {
    /// Solves on one thread, again and again where that is fast.
    fn measure(world: Simulator, size: usize) -> Self {
        let start = Instant::now();
        let simulated = world.simulate(&Options { size: Some(size), ..Options::default() }).unwrap().graph;
        let (graph, values) = factors(&simulated).unwrap();
        drop(simulated);
        let _ = std::fs::write("/proc/self/clear_refs", "5"); // forget the peak so far
        let repeats = (20_000 / size).max(1);
        let (mut initialise, mut optimise, mut steps) = (0.0, 0.0, 0);
        let mut solved = values.clone();
        let options = SolveOptions { threads: 1, ..SolveOptions::default() };
        for _ in 0..repeats {
            let zero = cpu_seconds(start);
            let first = graph.initialise(&values, Initial::Auto).unwrap();
            let one = cpu_seconds(start);
            let solution = graph.optimize(&first.values, &options).unwrap();
            initialise += (one - zero) / repeats as f64;
            optimise += (cpu_seconds(start) - one) / repeats as f64;
            assert!(solution.report.converged());
            (steps, solved) = (solution.report.iterations.len(), solution.values);
        }
        let megabytes = peak_memory();
        let (pattern, mut matrix) = normal_equations(&graph, &solved).unwrap();
        pattern.diagonal().into_iter().for_each(|at| matrix[at] *= 1.0 + 1e-6);
        let mut cholesky = Cholesky::new(&pattern).unwrap();
        cholesky.factorise(&matrix).unwrap();
        let zero = cpu_seconds(start);
        (0..repeats).for_each(|_| cholesky.factorise(&matrix).unwrap());
        Self {
            poses: values.ids().count(),
            measurements: graph.len(),
            initialise,
            optimise,
            steps,
            megabytes,
            numbers: cholesky.factor_len(),
            flop: cholesky.multiplications() as f64 * 2.0,
            factorise: (cpu_seconds(start) - zero) / repeats as f64,
        }
    }
}

#[test]
#[ignore = "measures time and memory"]
fn growth() {
    let given = std::env::var("BOXPLUS_WORLDS").unwrap_or_else(|_| WORLDS.into());
    let mut tile = TileRate::new();
    let peak = TileRate::FLOP / least(20000, || tile.run());
    println!("the register tile alone, in the first cache: {:.1} GFlop/s", peak * 1e-9);
    println!(
        "| world | poses | measurements | initialise s | optimise s | steps | exponent | peak MB | 10⁶ numbers in L | GFlop | factorise s | GFlop/s | of the tile |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    let mut before: Option<(&str, f64, f64)> = None;
    for item in given.split(',') {
        let (name, size) = item.split_once(':').unwrap();
        let g = Growth::measure(name.parse().unwrap(), size.parse().unwrap());
        let (n, t) = (g.poses as f64, g.initialise + g.optimise);
        let smaller = before.filter(|(other, ..)| *other == name);
        let exponent =
            smaller.map_or_else(|| "–".into(), |(_, m, s)| format!("{:.2}", (t / s).ln() / (n / m).ln()));
        before = Some((name, n, t));
        println!(
            "| {name} | {n} | {} | {:.3} | {:.3} | {} | {exponent} | {:.0} | {:.2} | {:.3} | {:.4} | {:.1} | {:.0} % |",
            g.measurements,
            g.initialise,
            g.optimise,
            g.steps,
            g.megabytes,
            g.numbers as f64 * 1e-6,
            g.flop * 1e-9,
            g.factorise,
            g.flop / g.factorise * 1e-9,
            100.0 * g.flop / g.factorise / peak,
        );
    }
}

#[test]
fn solutions_and_the_selected_inverse_of_public_graphs_are_those_of_faer() {
    for name in FILES {
        let Some((graph, values)) = problem(name) else { continue };
        let (pattern, mut matrix) = normal_equations(&graph, &values).unwrap();
        // A unit diagonal, so that errors have one scale, and a condition below 10⁶.
        let diagonal = pattern.diagonal();
        let scale: Vec<f64> = diagonal.iter().map(|&at| matrix[at].sqrt().recip()).collect();
        entries(&pattern).for_each(|(i, j, at)| matrix[at] *= scale[i] * scale[j]);
        diagonal.iter().for_each(|&at| matrix[at] += 1e-5);
        let mut ours = Cholesky::new(&pattern).unwrap();
        let mut theirs = Oracle::new(&pattern);
        theirs.read(&matrix);
        ours.factorise(&matrix).unwrap();
        assert!(theirs.factorise());
        ours.invert().unwrap();
        let size = pattern.size();
        for column in (0..size).step_by(size / 7) {
            let mut unit = vec![0.0; size];
            unit[column] = 1.0;
            let mut other = unit.clone();
            ours.solve(&mut unit);
            theirs.solve(&mut other);
            let largest = other.iter().fold(0.0f64, |max, x| max.max(x.abs()));
            for row in 0..size {
                assert!((unit[row] - other[row]).abs() < 1e-9 * largest, "{name}");
                if let Some(entry) = ours.inverse_entry(row, column) {
                    assert!((entry - other[row]).abs() < 1e-9 * largest, "{name}");
                }
            }
        }
    }
}

#[test]
fn all_covariances_at_once_are_those_one_by_one() {
    for name in ["pose-graph/M3500.g2o", "pose-graph/sphere2500.g2o"] {
        let Some((graph, values)) = problem(name) else { continue };
        let mut marginals = graph.marginals(&values).unwrap();
        let poses2 = values.iter::<SE2>().map(|(key, _)| VariableId::from(key));
        let all: Vec<_> = poses2.chain(values.iter::<SE3>().map(|(key, _)| VariableId::from(key))).collect();
        let covariances = marginals.covariances(&all).unwrap();
        for (id, covariance) in all.iter().zip(&covariances).step_by(97) {
            let alone = marginals.covariance(*id).unwrap();
            assert!((&alone - covariance).amax() <= 1e-9 * alone.amax(), "{name}: {id:?}");
        }
    }
}
