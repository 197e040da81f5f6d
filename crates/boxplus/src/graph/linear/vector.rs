//! Products of vectors, and of the symmetric matrix with one.

use super::pattern::Pattern;

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// H·x from the lower triangle of H.
pub(crate) fn product(pattern: &Pattern, matrix: &[f64], x: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; x.len()];
    for block in pattern.blocks() {
        let numbers = &matrix[block.at..block.at + block.rows * block.columns];
        let diagonal = block.row == block.column;
        for (c, column) in numbers.chunks_exact(block.rows).enumerate() {
            let below = if diagonal { c + 1 } else { 0 };
            let (column, rows) = (&column[below..], block.row + below..block.row + block.rows);
            let here = block.column + c;
            if diagonal {
                y[here] += numbers[c * (block.rows + 1)] * x[here];
            }
            y[here] += dot(column, &x[rows.clone()]);
            y[rows].iter_mut().zip(column).for_each(|(y, h)| *y += h * x[here]);
        }
    }
    y
}

/// A fixed rough vector: no eigenvector of a real problem is orthogonal to it.
pub(crate) fn rough(len: usize) -> Vec<f64> {
    (0..len).map(|i| (1.0 + i as f64 * 0.754_877).sin()).collect()
}
