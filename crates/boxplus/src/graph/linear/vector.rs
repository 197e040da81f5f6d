//! Products of vectors, and of the symmetric matrix with one.

use super::structure::Pattern;

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// H·x from the lower triangle of H.
pub(crate) fn product(pattern: &Pattern, matrix: &[f64], x: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; x.len()];
    for column in 0..x.len() {
        let range = pattern.starts[column]..pattern.starts[column + 1];
        let mut sum = 0.0;
        for (&row, h) in pattern.rows[range.clone()].iter().zip(&matrix[range]) {
            y[row] += h * x[column];
            if row != column {
                sum += h * x[row];
            }
        }
        y[column] += sum;
    }
    y
}

/// A fixed rough vector: no eigenvector of a real problem is orthogonal to it.
pub(crate) fn rough(len: usize) -> Vec<f64> {
    (0..len).map(|i| (1.0 + i as f64 * 0.754_877).sin()).collect()
}
