//! Nanoseconds per SE(3) operation: `cargo run --release -p boxplus --example lie_speed`.
#![allow(clippy::print_stdout)] // A report for a terminal.

use boxplus::lie::{Action, LieGroup, SE3, SO3};
use nalgebra::{Vector3, Vector6};
use std::hint::black_box;
use std::time::Instant;

const ELEMENTS: usize = 1024;
const ROUNDS: usize = 300;

/// Prints the least time of a call over all rounds of `ELEMENTS` calls: what the processor can do undisturbed.
fn measure<R>(name: &str, operation: impl Fn(usize) -> R) {
    let mut best = f64::INFINITY;
    for _ in 0..ROUNDS {
        let start = Instant::now();
        for i in 0..ELEMENTS {
            black_box(&operation(i)); // by reference: a Jacobian is not copied once more
        }
        best = best.min(start.elapsed().as_secs_f64() * 1e9 / ELEMENTS as f64);
    }
    println!("{name:<24}{best:>8.1} ns");
}

fn main() {
    let wave = |i: usize, k: f64| (k * (i as f64 + 1.0)).sin();
    let tangents: Vec<Vector6<f64>> =
        (0..=ELEMENTS).map(|i| Vector6::from_fn(|r, _| 1.3 * wave(i, 0.7 + 0.11 * r as f64))).collect();
    let poses: Vec<SE3> = tangents.iter().map(SE3::exp).collect();
    let points: Vec<Vector3<f64>> = tangents.iter().map(|t| t.fixed_rows::<3>(0).into_owned()).collect();
    let phis: Vec<Vector3<f64>> = tangents.iter().map(|t| t.fixed_rows::<3>(3).into_owned()).collect();
    let (x, y) = (|i: usize| &poses[i], |i: usize| &poses[i + 1]);

    measure("SO3 exp", |i| SO3::exp(&phis[i]));
    measure("SO3 log", |i| x(i).rotation().log());
    measure("SE3 exp", |i| SE3::exp(&tangents[i]));
    measure("SE3 exp_jac", |i| SE3::exp_jac(&tangents[i]));
    measure("SE3 log", |i| x(i).log());
    measure("SE3 log_jac", |i| x(i).log_jac());
    measure("SE3 compose", |i| x(i).compose(y(i)));
    measure("SE3 inverse", |i| x(i).inverse());
    measure("SE3 between", |i| x(i).between(y(i)));
    measure("SE3 adjoint", |i| x(i).adjoint());
    measure("SE3 act", |i| x(i).act(&points[i]));
    measure("SE3 act_jac", |i| x(i).act_jac(&points[i]));
    measure("SE3 rplus", |i| x(i).rplus(&tangents[i]));
    measure("SE3 rplus_jac", |i| x(i).rplus_jac(&tangents[i]));
    measure("SE3 rminus", |i| y(i).rminus(x(i)));
    measure("SE3 rminus_jac", |i| y(i).rminus_jac(x(i)));
    measure("SE3 interpolate_jac", |i| x(i).interpolate_jac(y(i), 0.3));
}
