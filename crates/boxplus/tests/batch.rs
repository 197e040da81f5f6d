//! A batch is the scalar operation over slices, to the last bit, whatever the length, the lanes and the threads.
#![cfg(feature = "batch")]
#![allow(missing_docs, clippy::unwrap_used)]

use boxplus::lie::{
    Batch, BatchGroup, LengthMismatch, LieGroup, Real, Rn, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3,
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

fn agrees<G: BatchGroup<D>, const D: usize>() {
    for count in [0, 1, 3, 4, 31, 32, 33, 200] {
        let tau = tangents::<G::Scalar, D>(count);
        let x: Vec<G> = tau.iter().map(G::exp).collect();
        let y: Vec<G> = x.iter().rev().copied().collect();
        let zero = SMatrix::<G::Scalar, D, D>::zeros();
        let (mut elements, mut steps) = (vec![G::identity(); count], vec![SVector::zeros(); count]);
        let mut jacobians = vec![(SVector::zeros(), zero, zero); count];
        for batch in [Batch::OneCore, Batch::AllCores] {
            batch.exp(&tau, &mut elements).unwrap();
            assert!(elements.iter().zip(&x).all(|(a, b)| same_element(a, b)), "exp");
            batch.log(&x, &mut steps).unwrap();
            assert!(steps.iter().zip(&x).all(|(a, x)| same(a, &x.log())), "log");
            batch.compose(&x, &y, &mut elements).unwrap();
            assert!((0..count).all(|i| same_element(&elements[i], &x[i].compose(&y[i]))), "compose");
            batch.between(&x, &y, &mut elements).unwrap();
            assert!((0..count).all(|i| same_element(&elements[i], &x[i].between(&y[i]))), "between");
            batch.inverse(&x, &mut elements).unwrap();
            assert!((0..count).all(|i| same_element(&elements[i], &x[i].inverse())), "inverse");
            batch.rplus(&x, &tau, &mut elements).unwrap();
            assert!((0..count).all(|i| same_element(&elements[i], &x[i].rplus(&tau[i]))), "rplus");
            batch.rminus(&y, &x, &mut steps).unwrap();
            assert!((0..count).all(|i| same(&steps[i], &y[i].rminus(&x[i]))), "rminus");
            batch.rminus_jac(&y, &x, &mut jacobians).unwrap();
            for i in 0..count {
                let ((a, b, c), (p, q, r)) = (jacobians[i], y[i].rminus_jac(&x[i]));
                assert!(same(&a, &p) && same(&b, &q) && same(&c, &r), "rminus_jac");
            }
        }
    }
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
}

#[test]
fn a_batch_gives_the_bits_of_single_operations_in_f32() {
    agrees::<SO3<f32>, 3>();
    agrees::<SE3<f32>, 6>();
    agrees::<Sim3<f32>, 7>();
    agrees::<SE2<f32>, 3>();
}

#[test]
fn slices_of_different_lengths_are_refused() {
    let mut out = [SO3::<f64>::identity(); 2];
    let refused = Batch::OneCore.exp(&[Vector3::zeros(); 3], &mut out);
    assert_eq!(refused, Err(LengthMismatch { inputs: 3, outputs: 2 }));
    assert_eq!(Batch::OneCore.compose(&[out[0]; 2], &[out[0]], &mut out).unwrap_err().inputs, 1);
}
