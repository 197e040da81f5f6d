//! Nanoseconds per operation, of SE(3) and, in short, of other groups, one at a time and in batches: `cargo run --release -p boxplus --example lie_speed`.
#![allow(clippy::print_stdout)] // A report for a terminal.

use boxplus::lie::{
    Action, Batch, BatchGroup, LengthMismatch, LieGroup, Number, Real, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2,
    Sim3,
};
use nalgebra::{Matrix6, SMatrix, SVector, Vector3, Vector6};
use std::hint::black_box;
use std::time::Instant;

const ELEMENTS: usize = 1024;
const ROUNDS: usize = 300;

/// The least time of `ELEMENTS` calls over all rounds, per call: what the processor can do undisturbed.
fn nanoseconds(mut calls: impl FnMut()) -> f64 {
    (0..ROUNDS).fold(f64::INFINITY, |best, _| {
        let start = Instant::now();
        calls();
        best.min(start.elapsed().as_secs_f64() * 1e9 / ELEMENTS as f64)
    })
}

/// Prints the time of an operation on single elements and, where there is one, of its batch.
fn measure<R>(
    name: &str,
    operation: impl Fn(usize) -> R,
    batch: Option<&mut dyn FnMut() -> Result<(), LengthMismatch>>,
) {
    let single = nanoseconds(|| {
        for i in 0..ELEMENTS {
            black_box(&operation(i)); // by reference: a Jacobian is not copied once more
        }
    });
    let batched = batch.map(|run| nanoseconds(|| assert_eq!(black_box(run()), Ok(()))));
    println!("{name:<24}{single:>8.1}{}", batched.map_or(String::new(), |ns| format!("{ns:>8.1}")));
}

fn report<S: Number>() {
    let wave = |i: usize, k: f64| (k * (i as f64 + 1.0)).sin();
    let tangents: Vec<Vector6<S>> = (0..=ELEMENTS)
        .map(|i| Vector6::from_fn(|r, _| S::lit(1.3 * wave(i, 0.7 + 0.11 * r as f64))))
        .collect();
    let poses: Vec<SE3<S>> = tangents.iter().map(SE3::exp).collect();
    let points: Vec<Vector3<S>> = tangents.iter().map(|t| t.fixed_rows::<3>(0).into_owned()).collect();
    let phis: Vec<Vector3<S>> = tangents.iter().map(|t| t.fixed_rows::<3>(3).into_owned()).collect();
    let (x, y) = (|i: usize| &poses[i], |i: usize| &poses[i + 1]);
    // What the batches read and write.
    let (tau, p, first, second) =
        (&tangents[..ELEMENTS], &points[..ELEMENTS], &poses[..ELEMENTS], &poses[1..]);
    let (zero, run) = (Matrix6::zeros(), Batch::OneCore);
    let mut elements = vec![SE3::identity(); ELEMENTS];
    let mut steps = vec![Vector6::zeros(); ELEMENTS];
    let mut moved = vec![Vector3::zeros(); ELEMENTS];
    let mut with_one = vec![(SE3::identity(), zero); ELEMENTS];
    let mut with_two = vec![(SE3::identity(), zero, zero); ELEMENTS];
    let mut step_with_one = vec![(Vector6::zeros(), zero); ELEMENTS];
    let mut step_with_two = vec![(Vector6::zeros(), zero, zero); ELEMENTS];

    measure("SO3 exp", |i| SO3::exp(&phis[i]), None);
    measure("SO3 log", |i| x(i).rotation().log(), None);
    measure("SE3 exp", |i| SE3::exp(&tau[i]), Some(&mut || run.exp(tau, &mut elements)));
    measure("SE3 exp_jac", |i| SE3::exp_jac(&tau[i]), Some(&mut || run.exp_jac(tau, &mut with_one)));
    measure("SE3 log", |i| x(i).log(), Some(&mut || run.log(first, &mut steps)));
    measure("SE3 log_jac", |i| x(i).log_jac(), Some(&mut || run.log_jac(first, &mut step_with_one)));
    measure("SE3 compose", |i| x(i).compose(y(i)), Some(&mut || run.compose(first, second, &mut elements)));
    measure("SE3 inverse", |i| x(i).inverse(), Some(&mut || run.inverse(first, &mut elements)));
    measure("SE3 inverse_jac", |i| x(i).inverse_jac(), None);
    measure("SE3 between", |i| x(i).between(y(i)), Some(&mut || run.between(first, second, &mut elements)));
    measure("SE3 adjoint", |i| x(i).adjoint(), None);
    measure("SE3 act", |i| x(i).act(&p[i]), Some(&mut || run.act(first, p, &mut moved)));
    measure("SE3 act_jac", |i| x(i).act_jac(&p[i]), None);
    measure("SE3 rplus", |i| x(i).rplus(&tau[i]), Some(&mut || run.rplus(first, tau, &mut elements)));
    measure(
        "SE3 rplus_jac",
        |i| x(i).rplus_jac(&tau[i]),
        Some(&mut || run.rplus_jac(first, tau, &mut with_two)),
    );
    measure("SE3 rminus", |i| y(i).rminus(x(i)), Some(&mut || run.rminus(second, first, &mut steps)));
    measure(
        "SE3 rminus_jac",
        |i| y(i).rminus_jac(x(i)),
        Some(&mut || run.rminus_jac(second, first, &mut step_with_two)),
    );
    measure("SE3 interpolate_jac", |i| x(i).interpolate_jac(y(i), S::lit(0.3)), None);
}

/// Five operations of any group.
fn brief<G: BatchGroup<D>, const D: usize>(name: &str) {
    let wave = |i: usize, k: f64| (k * (i as f64 + 1.0)).sin();
    let tau: Vec<SVector<G::Scalar, D>> = (0..ELEMENTS)
        .map(|i| SVector::from_fn(|r, _| G::Scalar::lit(1.3 * wave(i, 0.7 + 0.11 * r as f64))))
        .collect();
    let x: Vec<G> = tau.iter().map(G::exp).collect();
    let y: Vec<G> = x.iter().rev().copied().collect();
    let (zero, run) = (SMatrix::zeros(), Batch::OneCore);
    let (mut elements, mut steps) = (x.clone(), tau.clone());
    let mut with_one = vec![(x[0], zero); ELEMENTS];
    let mut with_two = vec![(tau[0], zero, zero); ELEMENTS];
    let named = |operation: &str| format!("{name} {operation}");
    measure(&named("exp"), |i| G::exp(&tau[i]), Some(&mut || run.exp(&tau, &mut elements)));
    measure(&named("log"), |i| x[i].log(), Some(&mut || run.log(&x, &mut steps)));
    measure(&named("compose"), |i| x[i].compose(&y[i]), Some(&mut || run.compose(&x, &y, &mut elements)));
    measure(&named("exp_jac"), |i| G::exp_jac(&tau[i]), Some(&mut || run.exp_jac(&tau, &mut with_one)));
    measure(
        &named("rminus_jac"),
        |i| y[i].rminus_jac(&x[i]),
        Some(&mut || run.rminus_jac(&y, &x, &mut with_two)),
    );
}

fn others<S: Number>()
where
    SO2<S>: BatchGroup<1>,
    SE2<S>: BatchGroup<3>,
    SO3<S>: BatchGroup<3>,
    SE23<S>: BatchGroup<9>,
    SGal3<S>: BatchGroup<10>,
    Sim2<S>: BatchGroup<4>,
    Sim3<S>: BatchGroup<7>,
{
    brief::<SO2<S>, 1>("SO2");
    brief::<SE2<S>, 3>("SE2");
    brief::<SO3<S>, 3>("SO3");
    brief::<SE23<S>, 9>("SE23");
    brief::<SGal3<S>, 10>("SGal3");
    brief::<Sim2<S>, 4>("Sim2");
    brief::<Sim3<S>, 7>("Sim3");
}

fn main() {
    println!("{:<24}{:>8}{:>8}  ns, f64", "", "single", "batch");
    report::<f64>();
    others::<f64>();
    println!("\n{:<24}{:>8}{:>8}  ns, f32", "", "single", "batch");
    report::<f32>();
    others::<f32>();
}
