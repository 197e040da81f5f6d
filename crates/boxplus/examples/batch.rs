//! "I have a million poses": `cargo run --release -p boxplus --features parallel --example batch`.
#![allow(clippy::print_stdout)] // A report for a terminal.

use boxplus::lie::{Batch, LengthMismatch, LieGroup, SE3};
use nalgebra::{Matrix6, Vector6};
use std::time::Instant;

const POSES: usize = 1_000_000;

fn main() -> Result<(), LengthMismatch> {
    let tangents: Vec<Vector6<f64>> =
        (0..POSES).map(|i| Vector6::from_fn(|r, _| (0.7 * i as f64 + r as f64).sin())).collect();
    let (mut poses, mut logs) = (vec![SE3::identity(); POSES], vec![Vector6::zeros(); POSES]);
    let mut steps = vec![(Vector6::zeros(), Matrix6::zeros(), Matrix6::zeros()); POSES - 1];

    for batch in [Batch::OneCore, Batch::AllCores] {
        let start = Instant::now();
        batch.exp(&tangents, &mut poses)?;
        batch.log(&poses, &mut logs)?;
        batch.rminus_jac(&poses[1..], &poses[..POSES - 1], &mut steps)?;
        let worst = logs.iter().zip(&tangents).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max);
        println!(
            "{batch:?}: {:.0} ms, Log(Exp τ) − τ at most {worst:.1e}",
            start.elapsed().as_secs_f64() * 1e3
        );
    }

    // One at a time gives the same bits.
    let start = Instant::now();
    let same = (1..POSES).all(|i| poses[i].rminus_jac(&poses[i - 1]) == steps[i - 1]);
    println!(
        "one at a time: {:.0} ms for the last alone, the same bits: {same}",
        start.elapsed().as_secs_f64() * 1e3
    );
    Ok(())
}
