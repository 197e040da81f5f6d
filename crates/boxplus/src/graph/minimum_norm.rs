//! Covariance without a gauge: the pseudo-inverse of the normal equations, of all generalised inverses the smallest.
//!
//! Where all factors of a part are relative, H = JᵀJ is singular along its rigid motions, the D columns of N. Holding one
//! variable h exactly picks one inverse, in which uncertainty grows with the distance from h. The Moore–Penrose inverse
//! favours no variable: with a pin K on h alone, K = diag(H_hh),
//!
//! ```text
//! (H + K)⁻¹K restricted to the columns of h = N        because HN = 0 and N_h = I
//! H⁺ = P (H + K)⁻¹ P,   P = I − QQᵀ,   Q an orthonormal basis of N
//! ```
//! so that each block costs the pinned inverse and a product with D columns that are computed once. The null space is thus
//! found by the factorisation itself, for variables of every kind.

use nalgebra::DMatrix;

use super::gauge;
use super::linear::cholesky::Cholesky;
use super::linear::structure::Structure;
use super::set::AnySet;
use super::values::{Values, VariableId};

/// What turns the pinned inverse G into P·G·P.
pub(super) struct MinimumNorm {
    /// For each coordinate the part it moves with; none in parts that are tied to the world.
    part: Vec<Option<usize>>,
    /// Q: an orthonormal basis of the rigid motions, coordinates × directions. Parts share the columns: none reaches into another.
    basis: DMatrix<f64>,
    /// G·Q.
    image: DMatrix<f64>,
    /// QᵀGQ of every part.
    middle: Vec<DMatrix<f64>>,
}

impl MinimumNorm {
    /// With the factor of S·(H + K)·S, S = diag(`scale`), in which the coordinates of the variables `pinned` got 1 added on
    /// their diagonal.
    pub(super) fn new(
        sets: &[Box<dyn AnySet>],
        values: &Values,
        (structure, scale): (&Structure, &[f64]),
        cholesky: &mut Cholesky,
        pinned: &[VariableId],
    ) -> Self {
        let (size, mut part) = (structure.size(), vec![None; structure.size()]);
        for (number, free) in gauge::parts(sets, values).iter().filter(|part| !part.anchored).enumerate() {
            for &id in &free.variables {
                let start = structure.offsets.get(id).unwrap_or(size);
                part.iter_mut().skip(start).take(values.dim(id)).for_each(|part| *part = Some(number));
            }
        }
        let directions = pinned.iter().map(|&id| values.dim(id)).max().unwrap_or(0);
        let solved = |cholesky: &mut Cholesky, mut columns: DMatrix<f64>| {
            let rescale = |columns: &mut DMatrix<f64>| {
                for mut column in columns.column_iter_mut() {
                    column.iter_mut().zip(scale).for_each(|(x, s)| *x *= s);
                }
            };
            rescale(&mut columns);
            cholesky.solve(columns.as_mut_slice());
            rescale(&mut columns);
            columns
        };
        let mut basis = DMatrix::zeros(size, directions);
        for &id in pinned {
            if let Some(start) = structure.offsets.get(id) {
                (0..values.dim(id)).for_each(|k| basis[(start + k, k)] = 1.0);
            }
        }
        let mut basis = solved(cholesky, basis);
        orthonormalise(&mut basis, &part, pinned.len());
        let image = solved(cholesky, basis.clone());
        let mut middle = vec![DMatrix::zeros(directions, directions); pinned.len()];
        for (row, part) in part.iter().enumerate() {
            if let Some(part) = *part {
                middle[part] += basis.row(row).transpose() * image.row(row);
            }
        }
        Self { part, basis, image, middle }
    }

    /// (PGP − G)ᵢⱼ.
    pub(super) fn correction(&self, i: usize, j: usize) -> f64 {
        let Some(part) = self.part[i].filter(|_| self.part[i] == self.part[j]) else { return 0.0 };
        let (qi, qj) = (self.basis.row(i), self.basis.row(j));
        (qi * &self.middle[part]).dot(&qj) - self.image.row(i).dot(&qj) - qi.dot(&self.image.row(j))
    }
}

/// Modified Gram–Schmidt, twice, in each part by itself; a part may have fewer directions than there are columns.
fn orthonormalise(basis: &mut DMatrix<f64>, part: &[Option<usize>], parts: usize) {
    let inner = |basis: &DMatrix<f64>, a: usize, b: usize| {
        let mut sums = vec![0.0; parts];
        for (row, part) in part.iter().enumerate() {
            part.iter().for_each(|&part| sums[part] += basis[(row, a)] * basis[(row, b)]);
        }
        sums
    };
    for _ in 0..2 {
        for k in 0..basis.ncols() {
            for other in 0..k {
                let along = inner(basis, other, k);
                for (row, part) in part.iter().enumerate() {
                    part.iter().for_each(|&part| basis[(row, k)] -= along[part] * basis[(row, other)]);
                }
            }
            let norms = inner(basis, k, k);
            for (row, part) in part.iter().enumerate() {
                let norm = part.map_or(0.0, |part| norms[part].sqrt());
                basis[(row, k)] = if norm > 0.0 { basis[(row, k)] / norm } else { 0.0 };
            }
        }
    }
}
