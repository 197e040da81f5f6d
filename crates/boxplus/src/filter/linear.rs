//! Division by a triangular factor some of whose columns may be zero.

use crate::lie::Real;
use nalgebra::SMatrix;

/// X with X·L = A, for L lower triangular; columns of X that meet a zero pivot are 0.
pub(super) fn divided<S: Real, const R: usize, const D: usize>(
    a: &SMatrix<S, R, D>,
    l: &SMatrix<S, D, D>,
) -> SMatrix<S, R, D> {
    let mut x = *a;
    for j in (0..D).rev() {
        for i in 0..R {
            let rest = (j + 1..D).fold(x[(i, j)], |rest, k| rest - x[(i, k)] * l[(k, j)]);
            x[(i, j)] = quotient(rest, l[(j, j)]);
        }
    }
    x
}

/// X with X·Lᵀ = A, likewise.
#[cfg(feature = "std")]
pub(super) fn divided_by_transpose<S: Real, const R: usize, const D: usize>(
    a: &SMatrix<S, R, D>,
    l: &SMatrix<S, D, D>,
) -> SMatrix<S, R, D> {
    let mut x = *a;
    for j in 0..D {
        for i in 0..R {
            let rest = (0..j).fold(x[(i, j)], |rest, k| rest - x[(i, k)] * l[(j, k)]);
            x[(i, j)] = quotient(rest, l[(j, j)]);
        }
    }
    x
}

fn quotient<S: Real>(x: S, pivot: S) -> S {
    if pivot.value() == 0.0 { S::zero() } else { x / pivot }
}
