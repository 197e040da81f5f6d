//! The sparse Cholesky factorisation behind the solver; the one file that names its backend.
//!
//! Symbolic analysis happens once for a structure, and no later call allocates. The factor is computed by one thread:
//! its sums then have one order, and the same input gives the same bits on every machine.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::linalg::{SupernodalThreshold, amd};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side, Spec};

use super::structure::Pattern;
use crate::graph::GraphError;

/// A fill-reducing elimination order of `count` nodes joined by `pairs` (a ≤ b, sorted, each once).
///
/// # Errors
/// [`GraphError::OutOfMemory`].
pub(crate) fn minimum_degree(count: usize, pairs: &[(u32, u32)]) -> Result<Vec<usize>, GraphError> {
    let mut starts = vec![0; count + 1];
    pairs.iter().for_each(|&(a, _)| starts[a as usize + 1] += 1);
    (0..count).for_each(|i| starts[i + 1] += starts[i]);
    let rows: Vec<usize> = pairs.iter().map(|&(_, b)| b as usize).collect();
    let pattern = SymbolicSparseColMatRef::new_checked(count, count, &starts, None, &rows);
    let (mut order, mut inverse) = (vec![0; count], vec![0; count]);
    let scratch = amd::order_scratch::<usize>(count, rows.len());
    let mut memory = MemBuffer::try_new(scratch).map_err(|_| GraphError::OutOfMemory)?;
    let done =
        amd::order(&mut order, &mut inverse, pattern, amd::Control::default(), MemStack::new(&mut memory));
    // The only failure is an index overflow; any order is then as good.
    Ok(if done.is_err() { (0..count).collect() } else { order })
}

/// A symmetric positive definite matrix A = LLᵀ of fixed pattern.
pub(crate) struct Cholesky {
    size: usize,
    symbolic: SymbolicCholesky<usize>,
    factor: Vec<f64>,
    memory: MemBuffer,
    columns: usize,
}

impl Cholesky {
    /// Analyses the lower triangle `pattern`, whose order is kept, for up to `columns` right-hand sides at a time.
    ///
    /// # Errors
    /// [`GraphError::OutOfMemory`].
    pub(crate) fn new(pattern: &Pattern, columns: usize) -> Result<Self, GraphError> {
        let size = pattern.starts.len() - 1;
        let upper = transpose(pattern);
        let symbolic = factorize_symbolic_cholesky(
            SymbolicSparseColMatRef::new_checked(size, size, &upper.starts, None, &upper.rows),
            Side::Upper,
            SymmetricOrdering::Identity,
            CholeskySymbolicParams {
                // Dense kernels pay at every size met: pose graphs have blocks of 3 and 6 from the start.
                supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
                ..CholeskySymbolicParams::default()
            },
        )
        .map_err(|_| GraphError::OutOfMemory)?;
        let scratch = StackReq::any_of(&[
            symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Spec::default()),
            symbolic.solve_in_place_scratch::<f64>(columns, Par::Seq),
        ]);
        let memory = MemBuffer::try_new(scratch).map_err(|_| GraphError::OutOfMemory)?;
        let mut factor = vec![];
        factor.try_reserve_exact(symbolic.len_val()).map_err(|_| GraphError::OutOfMemory)?;
        factor.resize(symbolic.len_val(), 0.0);
        Ok(Self { size, symbolic, factor, memory, columns })
    }

    /// Numbers in the factor L, a measure of the work.
    pub(crate) fn factor_len(&self) -> usize {
        self.factor.len()
    }

    /// Factorises the lower triangle with these values, in the pattern that was analysed.
    ///
    /// # Errors
    /// [`NotPositive`] where a pivot is not positive.
    pub(crate) fn factorise(&mut self, pattern: &Pattern, values: &[f64]) -> Result<(), NotPositive> {
        let pattern =
            SymbolicSparseColMatRef::new_checked(self.size, self.size, &pattern.starts, None, &pattern.rows);
        self.symbolic
            .factorize_numeric_llt(
                &mut self.factor,
                SparseColMatRef::new(pattern, values),
                Side::Lower,
                LltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut self.memory),
                Spec::default(),
            )
            .map(|_| ())
            .map_err(|_| NotPositive)
    }

    /// Overwrites the columns of `rhs` (each as long as the matrix) with A⁻¹·rhs.
    pub(crate) fn solve(&mut self, rhs: &mut [f64]) {
        let size = self.size;
        for chunk in rhs.chunks_mut((size * self.columns).max(1)) {
            let columns = chunk.len() / size.max(1);
            LltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
                Conj::No,
                MatMut::from_column_major_slice_mut(chunk, size, columns),
                Par::Seq,
                MemStack::new(&mut self.memory),
            );
        }
    }
}

/// A pivot was not positive: the matrix is not (numerically) positive definite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NotPositive;

fn transpose(pattern: &Pattern) -> Pattern {
    let size = pattern.starts.len() - 1;
    let mut starts = vec![0; size + 1];
    pattern.rows.iter().for_each(|&row| starts[row + 1] += 1);
    (0..size).for_each(|i| starts[i + 1] += starts[i]);
    let mut next = starts.clone();
    let mut rows = vec![0; pattern.rows.len()];
    for column in 0..size {
        for &row in &pattern.rows[pattern.starts[column]..pattern.starts[column + 1]] {
            rows[next[row]] = column;
            next[row] += 1;
        }
    }
    Pattern { starts, rows }
}
