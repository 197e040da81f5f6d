//! How fast is a g2o file read? Simulates a sphere, writes it as text with full information matrices, and reads it.
//!
//! `cargo run --release -p boxplus --features io --example parse_speed -- [POSES] [FILE]`
//!
//! With FILE, that file is read instead. Peak memory is that of the whole process (Linux).
#![allow(clippy::print_stdout)] // an example may print

use boxplus::io::{self, Format};
use boxplus::pose_graph::PoseGraph;
use boxplus::pose_graph::simulate::{Options, Simulator};
use std::error::Error;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let poses = arguments.next().map_or(Ok(120_000), |n| n.parse())?;
    let text = match arguments.next() {
        Some(path) => std::fs::read(path)?,
        None => simulated_text(poses)?.into_bytes(),
    };
    let megabytes = text.len() as f64 / 1e6;
    println!("{megabytes:.1} MB of text; peak memory {:.0} MB before reading", peak_memory());
    for _ in 0..3 {
        let start = Instant::now();
        let graph = io::read(&text, "text", None)?.graph;
        let seconds = start.elapsed().as_secs_f64();
        let (vertices, edges) = (graph.vertex_count(), graph.constraints().count());
        println!("{vertices} vertices, {edges} edges in {seconds:.3} s: {:.0} MB/s", megabytes / seconds);
    }
    println!("peak memory {:.0} MB", peak_memory());
    let graph = io::read(&text, "text", None)?.graph;
    time("faults", || graph.faults().len());
    time("statistics", || graph.statistics().ids);
    time("write", || io::write(&graph, Format::G2o).map_or(0, |text| text.len()));
    Ok(())
}

/// A sphere whose information matrices are full, as in real files: every number has 16 digits or more.
fn simulated_text(poses: usize) -> Result<String, Box<dyn Error>> {
    let options = Options { size: Some(poses), ..Options::default() };
    let mut graph: PoseGraph = Simulator::Sphere.simulate(&options)?.graph;
    for (k, edge) in (0u32..).zip(&mut graph.edges3) {
        let mix = nalgebra::Matrix6::from_fn(|i, j| f64::from(k * 7 + i as u32 * 5 + j as u32 * 3).sin());
        edge.information += mix * mix.transpose();
    }
    Ok(io::write(&graph, Format::G2o)?)
}

fn time<T: std::fmt::Display>(name: &str, run: impl FnOnce() -> T) {
    let start = Instant::now();
    let result = run();
    println!("{name}: {:.3} s ({result})", start.elapsed().as_secs_f64());
}

/// The largest resident size of this process so far, MB; 0 where the system does not tell.
fn peak_memory() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<f64>().ok()).unwrap_or(0.0) / 1e3
}
