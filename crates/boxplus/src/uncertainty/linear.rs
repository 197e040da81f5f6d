//! Small symmetric matrices, semi-definite ones included, however their entries are stored.
//!
//! Everything is judged on the matrix scaled to unit diagonal, so that metres and radians may differ by any factor:
//! Demmel & Veselić (1992) for why that is also the accurate way.

use super::error::{Direction, UncertaintyError};
use crate::lie::Real;
use nalgebra::{SMatrix, SimdComplexField};

/// A square matrix by its entries.
pub(super) trait Square<S>: Copy {
    /// The same storage in `f64`.
    type Double: Square<f64, Double = Self::Double>;
    fn size(&self) -> usize;
    fn at(&self, i: usize, j: usize) -> S;
    fn put(&mut self, i: usize, j: usize, x: S);
    /// The values without derivatives.
    fn double(&self) -> Self::Double;
}

impl<S: Real, const D: usize> Square<S> for SMatrix<S, D, D> {
    type Double = SMatrix<f64, D, D>;
    fn size(&self) -> usize {
        D
    }
    fn at(&self, i: usize, j: usize) -> S {
        self[(i, j)]
    }
    fn put(&mut self, i: usize, j: usize, x: S) {
        self[(i, j)] = x;
    }
    fn double(&self) -> Self::Double {
        self.map(Real::value)
    }
}

/// Eigenvalues and pivots of a matrix with unit diagonal below this are 0 up to the rounding of D terms per entry.
pub(super) fn null<S: Real>(size: usize) -> f64 {
    16.0 * size as f64 * S::EPSILON
}

/// The lower triangular L with LLᵀ = A for A positive semi-definite; where a pivot is 0, so is its column.
pub(super) fn cholesky<S: Real, M: Square<S>>(a: &M) -> M {
    let (n, mut l) = (a.size(), *a);
    for j in 0..n {
        let rest = |l: &M, i: usize| (0..j).fold(a.at(i, j), |x, k| x - l.at(i, k) * l.at(j, k));
        let pivot = rest(&l, j);
        let regular = pivot.value() > null::<S>(n) * a.at(j, j).value();
        let scale = if regular { S::one() / pivot.simd_sqrt() } else { S::zero() };
        for i in 0..n {
            let x = if i >= j && regular { rest(&l, i) * scale } else { S::zero() };
            l.put(i, j, x);
        }
    }
    l
}

/// x with L·x = b, in place; 0 where the pivot is 0.
pub(super) fn forward<S: Real, M: Square<S>>(l: &M, b: &mut [S]) {
    for i in 0..l.size() {
        let x = (0..i).fold(b[i], |x, k| x - l.at(i, k) * b[k]);
        b[i] = divided(x, l.at(i, i));
    }
}

/// x with LLᵀ·x = b, in place. Of a singular matrix, the reflexive inverse that leaves coordinates of zero pivot at 0:
/// it solves whatever has a solution.
pub(super) fn solve<S: Real, M: Square<S>>(l: &M, b: &mut [S]) {
    forward(l, b);
    for i in (0..l.size()).rev() {
        let x = (i + 1..l.size()).fold(b[i], |x, k| x - l.at(k, i) * b[k]);
        b[i] = divided(x, l.at(i, i));
    }
}

fn divided<S: Real>(x: S, pivot: S) -> S {
    if pivot.value() == 0.0 { S::zero() } else { x / pivot }
}

/// X with X·L = A, for L lower triangular; columns of X that meet a zero pivot are 0.
pub(crate) fn right_divided<S: Real, const R: usize, const D: usize>(
    a: &SMatrix<S, R, D>,
    l: &SMatrix<S, D, D>,
) -> SMatrix<S, R, D> {
    let mut x = *a;
    for j in (0..D).rev() {
        for i in 0..R {
            let rest = (j + 1..D).fold(x[(i, j)], |rest, k| rest - x[(i, k)] * l[(k, j)]);
            x[(i, j)] = divided(rest, l[(j, j)]);
        }
    }
    x
}

/// X with X·Lᵀ = A, likewise.
#[cfg(feature = "std")]
pub(crate) fn right_divided_by_transpose<S: Real, const R: usize, const D: usize>(
    a: &SMatrix<S, R, D>,
    l: &SMatrix<S, D, D>,
) -> SMatrix<S, R, D> {
    let mut x = *a;
    for j in 0..D {
        for i in 0..R {
            let rest = (0..j).fold(x[(i, j)], |rest, k| rest - x[(i, k)] * l[(j, k)]);
            x[(i, j)] = divided(rest, l[(j, j)]);
        }
    }
    x
}

/// Whether a factor has a zero pivot.
pub(super) fn is_singular<S: Real, M: Square<S>>(l: &M) -> bool {
    (0..l.size()).any(|i| l.at(i, i).value() == 0.0)
}

/// Sweeps after which Jacobi's method has converged for any size met here; five to ten are usual.
const SWEEPS: usize = 40;

/// `(Λ, V)` with A = VΛVᵀ, Λ diagonal, by cyclic Jacobi rotations.
pub(super) fn eigen<M: Square<f64>>(a: &M) -> (M, M) {
    let (n, mut a, mut v) = (a.size(), *a, *a);
    (0..n).for_each(|i| (0..n).for_each(|j| v.put(i, j, f64::from(u8::from(i == j)))));
    let largest = (0..n).fold(0.0, |x: f64, i| (0..n).fold(x, |x, j| x.max(a.at(i, j).abs())));
    for _ in 0..SWEEPS {
        let mut settled = true;
        for p in 0..n {
            for q in p + 1..n {
                let geometric = (a.at(p, p) * a.at(q, q)).abs().simd_sqrt();
                if a.at(p, q).abs() > f64::EPSILON * geometric.max(f64::EPSILON * largest) {
                    rotate(&mut a, &mut v, p, q);
                    settled = false;
                }
            }
        }
        if settled {
            break;
        }
    }
    (a, v)
}

/// One Jacobi rotation that makes a_pq zero. Golub & Van Loan (2013) algorithm 8.5.1.
fn rotate<M: Square<f64>>(a: &mut M, v: &mut M, p: usize, q: usize) {
    let tau = (a.at(q, q) - a.at(p, p)) / (2.0 * a.at(p, q));
    let t = 1.0_f64.copysign(tau) / (tau.abs() + (1.0 + tau * tau).simd_sqrt());
    let c = 1.0 / (1.0 + t * t).simd_sqrt();
    let s = t * c;
    for k in 0..a.size() {
        let (x, y) = (a.at(k, p), a.at(k, q));
        a.put(k, p, c * x - s * y);
        a.put(k, q, s * x + c * y);
        let (x, y) = (v.at(k, p), v.at(k, q));
        v.put(k, p, c * x - s * y);
        v.put(k, q, s * x + c * y);
    }
    for k in 0..a.size() {
        let (x, y) = (a.at(p, k), a.at(q, k));
        a.put(p, k, c * x - s * y);
        a.put(q, k, s * x + c * y);
    }
    a.put(p, q, 0.0);
    a.put(q, p, 0.0);
}

/// `(Λ, V)` of the matrix scaled to unit diagonal; the columns of V are scaled back, directions of the tangent space
/// (of any length).
pub(super) fn scaled_eigen<M: Square<f64>>(a: &M) -> (M, M) {
    let n = a.size();
    let scale = |i: usize| if a.at(i, i) > 0.0 { 1.0 / a.at(i, i).simd_sqrt() } else { 1.0 };
    let mut correlation = *a;
    (0..n).for_each(|i| (0..n).for_each(|j| correlation.put(i, j, a.at(i, j) * scale(i) * scale(j))));
    let (values, mut vectors) = eigen(&correlation);
    (0..n).for_each(|i| (0..n).for_each(|k| vectors.put(i, k, vectors.at(i, k) * scale(i))));
    (values, vectors)
}

/// The direction of the column of V with the smallest eigenvalue, and that eigenvalue.
pub(super) fn weakest<M: Square<f64>>((values, vectors): &(M, M)) -> (f64, Direction, usize) {
    let least = |a: usize, b: usize| if values.at(b, b) < values.at(a, a) { b } else { a };
    let k = (0..values.size()).fold(0, least);
    (values.at(k, k), Direction::of((0..values.size()).map(|i| vectors.at(i, k))), k)
}

/// The matrix, made symmetric to the last bit, if it is a covariance up to rounding.
///
/// An asymmetry is rounding below √ε of the standard deviations, which an inverse may leave. A negative eigenvalue is
/// rounding if it is above −√ε in the matrix scaled to unit diagonal, or if its variance is lost beside the largest.
pub(super) fn checked<S: Real, M: Square<S>>(given: &M) -> Result<M, UncertaintyError> {
    let (n, a) = (given.size(), given.double());
    let places = || (0..n).flat_map(move |i| (0..n).map(move |j| (i, j)));
    if let Some((row, column)) = places().find(|&(i, j)| !a.at(i, j).is_finite()) {
        return Err(UncertaintyError::NotFinite { row, column });
    }
    let largest = (0..n).fold(0.0, |x: f64, i| x.max(a.at(i, i).abs()));
    let rounding = 4.0 * n as f64 * S::EPSILON * largest;
    let root = S::EPSILON.simd_sqrt();
    let excess = |&(i, j): &(usize, usize)| {
        let allowed = root * (a.at(i, i) * a.at(j, j)).abs().simd_sqrt() + rounding;
        (a.at(i, j) - a.at(j, i)).abs() > allowed
    };
    if let Some((row, column)) = places().find(excess) {
        let difference = (a.at(row, column) - a.at(column, row)).abs();
        return Err(UncertaintyError::Asymmetric { row, column, difference });
    }
    let symmetric = symmetrised(given);
    let a = symmetric.double();
    let spectrum = scaled_eigen(&a);
    let (eigenvalue, direction, k) = weakest(&spectrum);
    let along = |i: usize| spectrum.1.at(i, k);
    let square: f64 = (0..n).map(|i| along(i) * along(i)).sum();
    let variance = places().map(|(i, j)| along(i) * a.at(i, j) * along(j)).sum::<f64>() / square;
    if n > 0 && eigenvalue < -root && variance < -rounding {
        return Err(UncertaintyError::Indefinite { eigenvalue, variance, direction });
    }
    Ok(symmetric)
}

/// ½(A + Aᵀ).
pub(super) fn symmetrised<S: Real, M: Square<S>>(a: &M) -> M {
    let mut symmetric = *a;
    for i in 0..a.size() {
        for j in 0..i {
            let mean = (a.at(i, j) + a.at(j, i)) * S::lit(0.5);
            symmetric.put(i, j, mean);
            symmetric.put(j, i, mean);
        }
    }
    symmetric
}

/// ln|det A|, by elimination with row pivots.
pub(super) fn log_abs_determinant<S: Real, const D: usize>(mut a: SMatrix<S, D, D>) -> S {
    let mut sum = S::zero();
    for k in 0..D {
        let size = |i: usize| a[(i, k)].value().abs();
        let pivot = (k..D).fold(k, |best, i| if size(i) > size(best) { i } else { best });
        a.swap_rows(k, pivot);
        sum += a[(k, k)].simd_abs().simd_ln();
        for i in k + 1..D {
            let factor = a[(i, k)] / a[(k, k)];
            (k..D).for_each(|j| a[(i, j)] = a[(i, j)] - factor * a[(k, j)]);
        }
    }
    sum
}
