//! Is a large sparse symmetric matrix positive semidefinite, and if not, in which direction is it negative?
//!
//! S + ηI on the rotations is positive definite exactly where a Cholesky factorisation succeeds, so that the smallest
//! eigenvalue is bounded from below by trying shifts η. Where no small one will do, the lowest eigenpair is found by the
//! Lanczos method with (S + σI)⁻¹, σ just beyond −λ: there λ is the largest by far, and a few dozen solves suffice.
//! Golub & Van Loan (2013), §10.1.

use nalgebra::{DMatrix, SymmetricEigen};

use crate::graph::GraphError;
use crate::graph::linear::cholesky::Cholesky;
use crate::graph::linear::pattern::Pattern;
use crate::graph::linear::vector::{dot, rough};

/// A symmetric matrix S with a shift on some of its diagonal: x_RᵀS̃x_R is the least of xᵀSx over all other rows of x.
pub(super) struct Shifted<'a> {
    pattern: &'a Pattern,
    matrix: &'a [f64],
    /// Rows with a shift on the diagonal, and the places of those entries.
    rows: Vec<usize>,
    diagonal: Vec<usize>,
    cholesky: Cholesky,
    scratch: Vec<f64>,
}

/// The smallest eigenvalue of S̃ and a vector x with xᵀSx = λ‖x_R‖², ‖x_R‖ = 1.
#[derive(Clone, Debug)]
pub(super) struct Lowest {
    pub(super) eigenvalue: f64,
    pub(super) vector: Vec<f64>,
}

/// Lanczos vectors at most.
const BASIS: usize = 60;
/// Shifts grow by this factor until one suffices.
const GROWTH: f64 = 10.0;
/// The eigenvalue of (S̃ + σI)⁻¹ is good when its residual is below this part of it.
const CONVERGED: f64 = 1e-8;

impl<'a> Shifted<'a> {
    /// The matrix with these numbers in the lower triangle `pattern`, to be shifted in these rows.
    ///
    /// # Errors
    /// [`GraphError::OutOfMemory`].
    pub(super) fn new(pattern: &'a Pattern, matrix: &'a [f64], rows: Vec<usize>) -> Result<Self, GraphError> {
        let all = pattern.diagonal();
        let diagonal = rows.iter().map(|&row| all[row]).collect();
        let cholesky = Cholesky::new(pattern)?;
        Ok(Self { pattern, matrix, rows, diagonal, cholesky, scratch: vec![0.0; matrix.len()] })
    }

    /// The largest diagonal entry: the scale of rounding.
    pub(super) fn scale(&self) -> f64 {
        self.diagonal.iter().map(|&entry| self.matrix[entry].abs()).fold(0.0, f64::max)
    }

    /// Whether S with `shift` on the diagonal is positive definite; factorises it.
    pub(super) fn is_definite(&mut self, shift: f64) -> bool {
        self.scratch.copy_from_slice(self.matrix);
        self.diagonal.iter().for_each(|&entry| self.scratch[entry] += shift);
        self.cholesky.factorise(&self.scratch).is_ok()
    }

    /// The least of the shifts `first`, 10·`first`, … with which S is positive definite, up to `last`.
    pub(super) fn least_shift(&mut self, first: f64, last: f64) -> Option<f64> {
        let shifts = core::iter::successors(Some(first), |shift| Some(shift * GROWTH));
        shifts.take_while(|&shift| shift <= last).find(|&shift| self.is_definite(shift))
    }

    /// The lowest eigenpair, after `shift` has made the matrix definite.
    pub(super) fn lowest(&mut self, shift: f64) -> Lowest {
        let size = self.rows.len();
        let mut basis = vec![unit(rough(size))];
        let (mut alpha, mut beta): (Vec<f64>, Vec<f64>) = (vec![], vec![]);
        let (value, weights) = loop {
            let k = alpha.len();
            let mut next = self.solve_rotations(&basis[k]);
            alpha.push(dot(&next, &basis[k]));
            for _ in 0..2 {
                // Twice is enough to keep the basis orthogonal to rounding.
                for q in &basis {
                    let along = dot(&next, q);
                    next.iter_mut().zip(q).for_each(|(x, q)| *x -= along * q);
                }
            }
            let length = dot(&next, &next).sqrt();
            let (value, weights) = top(&alpha, &beta);
            let settled = length * weights[k].abs() <= CONVERGED * value.abs();
            if settled || k + 1 == BASIS.min(size) || length == 0.0 {
                break (value, weights);
            }
            beta.push(length);
            next.iter_mut().for_each(|x| *x /= length);
            basis.push(next);
        };
        let mut ritz = vec![0.0; size];
        for (q, weight) in basis.iter().zip(&weights) {
            ritz.iter_mut().zip(q).for_each(|(x, q)| *x += weight * q);
        }
        Lowest { eigenvalue: value.recip() - shift, vector: self.extend(&ritz) }
    }

    /// The rotation rows of (S + σ)⁻¹·x, where x has nothing else: (S̃ + σI)⁻¹·x.
    fn solve_rotations(&mut self, x: &[f64]) -> Vec<f64> {
        let full = self.solve(x);
        self.rows.iter().map(|&row| full[row]).collect()
    }

    /// The vector with these rotation rows for which xᵀSx is least, to the accuracy of one step of inverse iteration.
    fn extend(&mut self, x: &[f64]) -> Vec<f64> {
        let mut full = self.solve(x);
        let length = self.rows.iter().map(|&row| full[row] * full[row]).sum::<f64>().sqrt();
        full.iter_mut().for_each(|x| *x /= length);
        full
    }

    fn solve(&mut self, x: &[f64]) -> Vec<f64> {
        let mut full = vec![0.0; self.pattern.size()];
        self.rows.iter().zip(x).for_each(|(&row, x)| full[row] = *x);
        self.cholesky.solve(&mut full);
        full
    }
}

/// The largest eigenvalue of a tridiagonal matrix and its unit eigenvector.
fn top(alpha: &[f64], beta: &[f64]) -> (f64, Vec<f64>) {
    let entry = |i: usize, j: usize| match i.abs_diff(j) {
        0 => alpha[i],
        1 => beta[i.min(j)],
        _ => 0.0,
    };
    let eigen = SymmetricEigen::new(DMatrix::from_fn(alpha.len(), alpha.len(), entry));
    let best = eigen.eigenvalues.imax();
    (eigen.eigenvalues[best], eigen.eigenvectors.column(best).iter().copied().collect())
}

fn unit(mut x: Vec<f64>) -> Vec<f64> {
    let length = dot(&x, &x).sqrt();
    x.iter_mut().for_each(|x| *x /= length);
    x
}
