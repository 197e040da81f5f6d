//! Small matrices put together without loops.
//!
//! Batches run a formula for many elements in one loop, which a compiler vectorises only where no other loop remains inside; and
//! views of a matrix, products with its zeros and its negation stay loops. For single numbers, too, they cost more than the formula.

use super::{Jacobian, Real};
use nalgebra::{ArrayStorage, Matrix3, SMatrix, Vector3};

/// `$body` for every `$i` below the constant `$n`, written out up to 10.
macro_rules! each {
    ($i:ident < $n:ident, $body:expr) => {
        each!(@ $i, $n, $body, 0 1 2 3 4 5 6 7 8 9);
        for $i in 10..$n {
            $body;
        }
    };
    (@ $i:ident, $n:ident, $body:expr, $($k:literal)*) => {
        $( if $k < $n { let $i = $k; $body; } )*
    };
}
#[cfg(feature = "batch")]
pub(super) use each;

/// I, D×D.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn unit<S: Real, const D: usize>() -> Jacobian<S, D> {
    let mut columns = [[S::zero(); D]; D];
    each!(i < D, columns[i][i] = S::one());
    SMatrix::from_array_storage(ArrayStorage(columns))
}

/// −J, D×D.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn negated<S: Real, const D: usize>(j: Jacobian<S, D>) -> Jacobian<S, D> {
    let mut columns = j.data.0;
    each!(c < D, {
        let column = &mut columns[c];
        each!(r < D, column[r] = -column[r]);
    });
    SMatrix::from_array_storage(ArrayStorage(columns))
}

/// The matrix of N×N blocks, each 3×3, in the upper left corner of zeros.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn blocks<S: Real, const N: usize, const D: usize>(grid: [[&Matrix3<S>; N]; N]) -> Jacobian<S, D> {
    let mut columns = [[S::zero(); D]; D];
    each!(i < N, {
        let row = grid[i];
        each!(j < N, {
            let [a, b, c] = row[j].data.0;
            ([columns[3 * j][3 * i], columns[3 * j][3 * i + 1], columns[3 * j][3 * i + 2]]) = a;
            ([columns[3 * j + 1][3 * i], columns[3 * j + 1][3 * i + 1], columns[3 * j + 1][3 * i + 2]]) = b;
            ([columns[3 * j + 2][3 * i], columns[3 * j + 2][3 * i + 1], columns[3 * j + 2][3 * i + 2]]) = c;
        });
    });
    SMatrix::from_array_storage(ArrayStorage(columns))
}

/// Mᵀ, 3×3.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn transposed<S: Real>(m: &Matrix3<S>) -> Matrix3<S> {
    let [[a, b, c], [d, e, f], [g, h, k]] = m.data.0;
    Matrix3::new(a, b, c, d, e, f, g, h, k)
}

/// t^·M, 3×3, whose columns are t × those of M: without the zeros of t^.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn cross<S: Real>(t: &Vector3<S>, m: &Matrix3<S>) -> Matrix3<S> {
    let turned = |[x, y, z]: [S; 3]| [t.y * z - t.z * y, t.z * x - t.x * z, t.x * y - t.y * x];
    let [a, b, c] = m.data.0;
    Matrix3::from_array_storage(ArrayStorage([turned(a), turned(b), turned(c)]))
}
