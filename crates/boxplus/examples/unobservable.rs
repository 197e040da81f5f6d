//! Why does my graph not determine an answer?
//!
//! A robot sees a tree by its bearing alone. The solver converges, and then says which coordinates of which variables the
//! measurements say nothing about; a range settles it.
#![expect(clippy::print_stdout, reason = "an example talks")]

use boxplus::graph::{Bearing2, Between, Graph, Noise, Range, SolveOptions, Values};
use boxplus::lie::{Rn, SE2};
use nalgebra::vector;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let here = values.insert_labelled(SE2::new(vector![0.0, 0.0], 0.0), 100);
    let ahead = values.insert_labelled(SE2::new(vector![1.0, 0.1], 0.0), 101);
    let tree = values.insert_labelled(Rn::new(vector![4.0, 3.0]), 7);
    values.hold(here);
    graph.add((here, ahead), Between::new(SE2::new(vector![1.0, 0.0], 0.0)), Noise::unit());
    graph.add((ahead, tree), Bearing2::new(0.8), Noise::from_sigmas(&vector![0.01])?);

    let once = graph.optimize(&values, &SolveOptions::default())?;
    println!("with one bearing: {}", once.unconstrained.map_or("determined".into(), |free| free.to_string()));

    graph.add((here, tree), Range::new(5.0), Noise::from_sigmas(&vector![0.1])?);
    let twice = graph.optimize(&values, &SolveOptions::default())?;
    println!(
        "with a range too: {}",
        twice.unconstrained.map_or("determined".into(), |free| free.to_string())
    );
    Ok(())
}
