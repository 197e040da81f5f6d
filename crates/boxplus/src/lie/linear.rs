//! The inverse of a small matrix: of what means and information filters solve.

use super::Real;
use nalgebra::SMatrix;

/// A⁻¹ by elimination with row pivots, chosen by value: for single numbers. None where a pivot is zero, or NaN.
pub(crate) fn inverse<S: Real, const D: usize>(a: &SMatrix<S, D, D>) -> Option<SMatrix<S, D, D>> {
    let (mut a, mut inverse) = (*a, SMatrix::<S, D, D>::identity());
    for k in 0..D {
        let size = |i: usize| a[(i, k)].value().abs();
        let pivot = (k..D).fold(k, |best, i| if size(i) > size(best) { i } else { best });
        let largest = size(pivot);
        if largest == 0.0 || largest.is_nan() {
            return None;
        }
        a.swap_rows(k, pivot);
        inverse.swap_rows(k, pivot);
        let scale = S::one() / a[(k, k)];
        for j in 0..D {
            a[(k, j)] *= scale;
            inverse[(k, j)] *= scale;
        }
        for i in (0..D).filter(|&i| i != k) {
            let factor = a[(i, k)];
            for j in 0..D {
                a[(i, j)] = a[(i, j)] - factor * a[(k, j)];
                inverse[(i, j)] = inverse[(i, j)] - factor * inverse[(k, j)];
            }
        }
    }
    Some(inverse)
}
