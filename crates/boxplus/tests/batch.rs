//! A batch is the scalar operation over slices, to the last bit, whatever the length, the lanes and the threads.
#![cfg(feature = "batch")]
#![allow(missing_docs, clippy::unwrap_used)]

use boxplus::lie::{
    Action, Batch, BatchGroup, LengthMismatch, LieGroup, Number, R3xSO3, Real, Rn, RxSO2, RxSO3, S3, SE2,
    SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3,
};
use nalgebra::{SMatrix, SVector, Vector3};

/// Tangents of every length: at 0, around the switches, at π, beyond 2π, huge, and what is not a number.
fn tangents<S: Real, const D: usize>(count: usize) -> Vec<SVector<S, D>> {
    let lengths = [0.0, 1e-12, 1e-4, 0.4, 1.0, 3.1, std::f64::consts::PI, 3.2, 6.2, 7.0, 80.0, 1e6, f64::NAN];
    let direction = |i: usize, r: usize| ((i * 7 + r * 3 + 1) as f64).sin();
    (0..count)
        .map(|i| SVector::from_fn(|r, _| S::lit(direction(i, r) * lengths[i * 5 % lengths.len()])))
        .collect()
}

/// Bits, as far as a NaN has any.
fn same<S: Real, const R: usize, const C: usize>(a: &SMatrix<S, R, C>, b: &SMatrix<S, R, C>) -> bool {
    a.iter().zip(b.iter()).all(|(a, b)| {
        let (a, b) = (a.value(), b.value());
        a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
    })
}

fn same_element<G: LieGroup<D>, const D: usize>(a: &G, b: &G) -> bool {
    // Equal, or not a number in both.
    a == b || format!("{a:?}") == format!("{b:?}")
}

/// Tangents of every length, and of every number of them that fills blocks or leaves a rest.
fn agrees<G: BatchGroup<D>, const D: usize>() {
    for count in [0, 1, 3, 4, 31, 32, 33, 200] {
        agrees_at::<G, D>(&tangents(count));
    }
}

/// The tangents of a reference table, and as many next to them.
fn agrees_at_a_table<G: BatchGroup<D>, const D: usize>(table: &str) {
    let number = |x: &str| G::Scalar::lit(x.parse().unwrap());
    let tangent = |row: &str| SVector::from_iterator(row.split(',').take(D).map(number));
    let table: Vec<SVector<G::Scalar, D>> = table.lines().skip(1).map(tangent).collect();
    let near = table.iter().rev().map(|tau| tau * G::Scalar::lit(1.0 + 1e-6));
    agrees_at::<G, D>(&[table.clone(), near.collect()].concat());
}

/// All operations on elements x = Exp τ and y, the same in reverse.
fn agrees_at<G: BatchGroup<D>, const D: usize>(tau: &[SVector<G::Scalar, D>]) {
    let count = tau.len();
    let x: Vec<G> = tau.iter().map(G::exp).collect();
    let y: Vec<G> = x.iter().rev().copied().collect();
    let zero = SMatrix::<G::Scalar, D, D>::zeros();
    let (mut elements, mut steps) = (vec![G::identity(); count], vec![SVector::zeros(); count]);
    let mut jacobians = vec![(SVector::zeros(), zero, zero); count];
    let (mut exps, mut logs) = (vec![(G::identity(), zero); count], vec![(SVector::zeros(), zero); count]);
    let mut moved = vec![(G::identity(), zero, zero); count];
    for batch in [Batch::OneCore, Batch::AllCores] {
        batch.exp(tau, &mut elements).unwrap();
        assert!(elements.iter().zip(&x).all(|(a, b)| same_element(a, b)), "exp");
        batch.log(&x, &mut steps).unwrap();
        assert!(steps.iter().zip(&x).all(|(a, x)| same(a, &x.log())), "log");
        batch.compose(&x, &y, &mut elements).unwrap();
        assert!((0..count).all(|i| same_element(&elements[i], &x[i].compose(&y[i]))), "compose");
        batch.between(&x, &y, &mut elements).unwrap();
        assert!((0..count).all(|i| same_element(&elements[i], &x[i].between(&y[i]))), "between");
        batch.inverse(&x, &mut elements).unwrap();
        assert!((0..count).all(|i| same_element(&elements[i], &x[i].inverse())), "inverse");
        batch.rplus(&x, tau, &mut elements).unwrap();
        assert!((0..count).all(|i| same_element(&elements[i], &x[i].rplus(&tau[i]))), "rplus");
        batch.rminus(&y, &x, &mut steps).unwrap();
        assert!((0..count).all(|i| same(&steps[i], &y[i].rminus(&x[i]))), "rminus");
        batch.rminus_jac(&y, &x, &mut jacobians).unwrap();
        batch.exp_jac(tau, &mut exps).unwrap();
        batch.log_jac(&x, &mut logs).unwrap();
        batch.rplus_jac(&x, tau, &mut moved).unwrap();
        for i in 0..count {
            let ((a, b, c), (p, q, r)) = (jacobians[i], y[i].rminus_jac(&x[i]));
            assert!(same(&a, &p) && same(&b, &q) && same(&c, &r), "rminus_jac");
            let ((a, b), (p, q)) = (exps[i], G::exp_jac(&tau[i]));
            assert!(same_element(&a, &p) && same(&b, &q), "exp_jac");
            let ((a, b), (p, q)) = (logs[i], x[i].log_jac());
            assert!(same(&a, &p) && same(&b, &q), "log_jac");
            let ((a, b, c), (p, q, r)) = (moved[i], x[i].rplus_jac(&tau[i]));
            assert!(same_element(&a, &p) && same(&b, &q) && same(&c, &r), "rplus_jac");
        }
    }
}

fn acts<G: BatchGroup<D> + Action<D, N>, const D: usize, const N: usize>()
where
    G::Over<<G::Scalar as Number>::Lanes>: Action<D, N>,
{
    for count in [3, 33] {
        let x: Vec<G> = tangents::<G::Scalar, D>(count).iter().map(G::exp).collect();
        let points = tangents::<G::Scalar, N>(count);
        let mut out = vec![SVector::zeros(); count];
        for batch in [Batch::OneCore, Batch::AllCores] {
            batch.act(&x, &points, &mut out).unwrap();
            assert!((0..count).all(|i| same(&out[i], &x[i].act(&points[i]))), "act");
        }
    }
}

#[test]
fn a_batch_moves_points_as_single_elements_do() {
    acts::<SO2, 1, 2>();
    acts::<SE2, 3, 2>();
    acts::<SO3, 3, 3>();
    acts::<SE3, 6, 3>();
    acts::<SE3<f32>, 6, 3>();
    acts::<SE3, 6, 4>();
    acts::<SGal3, 10, 4>();
    acts::<Sim3, 7, 3>();
}

#[test]
fn a_batch_gives_the_bits_of_single_operations() {
    agrees::<SO3, 3>();
    agrees::<SE3, 6>();
    agrees::<SE23, 9>();
    agrees::<SGal3, 10>();
    agrees::<Sim3, 7>();
    agrees::<SO2, 1>();
    agrees::<SE2, 3>();
    agrees::<Sim2, 4>();
    agrees::<Rn<5>, 5>();
    agrees::<S3, 3>();
    agrees::<RxSO2, 2>();
    agrees::<RxSO3, 4>();
    agrees::<R3xSO3, 6>();
}

#[test]
fn a_batch_gives_the_bits_of_single_operations_in_f32() {
    agrees::<SO3<f32>, 3>();
    agrees::<SE3<f32>, 6>();
    agrees::<Sim3<f32>, 7>();
    agrees::<SE2<f32>, 3>();
}

/// So that the bounds of `docs/accuracy.md`, which single operations hold at these inputs, are those of batches.
#[test]
fn a_batch_gives_the_bits_of_single_operations_at_every_tangent_of_the_reference_tables() {
    let space = include_str!("reference/se3.csv");
    agrees_at_a_table::<SE3, 6>(space);
    agrees_at_a_table::<SE3<f32>, 6>(space);
    agrees_at_a_table::<R3xSO3, 6>(space);
    agrees_at_a_table::<SO3, 3>(&of_columns(space, 3..6));
    agrees_at_a_table::<SO3<f32>, 3>(&of_columns(space, 3..6));
    agrees_at_a_table::<SE2, 3>(include_str!("reference/se2.csv"));
    agrees_at_a_table::<SE2<f32>, 3>(include_str!("reference/se2.csv"));
    agrees_at_a_table::<SO2, 1>(&of_columns(include_str!("reference/se2.csv"), 2..3));
    let galilean = include_str!("reference/sgal3.csv");
    agrees_at_a_table::<SGal3, 10>(galilean);
    agrees_at_a_table::<SE23, 9>(galilean);
    agrees_at_a_table::<Sim3, 7>(include_str!("reference/sim3.csv"));
    agrees_at_a_table::<Sim3<f32>, 7>(include_str!("reference/sim3.csv"));
    agrees_at_a_table::<RxSO3, 4>(&of_columns(include_str!("reference/sim3.csv"), 3..7));
    agrees_at_a_table::<Sim2, 4>(include_str!("reference/sim2.csv"));
}

/// A table of some columns of another.
fn of_columns(table: &str, columns: std::ops::Range<usize>) -> String {
    let cut = |row: &str| row.split(',').collect::<Vec<_>>()[columns.clone()].join(",");
    table.lines().map(cut).collect::<Vec<_>>().join("\n")
}

#[test]
fn slices_of_different_lengths_are_refused() {
    let mut out = [SO3::<f64>::identity(); 2];
    let refused = Batch::OneCore.exp(&[Vector3::zeros(); 3], &mut out);
    assert_eq!(refused, Err(LengthMismatch { inputs: 3, outputs: 2 }));
    assert_eq!(Batch::OneCore.compose(&[out[0]; 2], &[out[0]], &mut out).unwrap_err().inputs, 1);
}
