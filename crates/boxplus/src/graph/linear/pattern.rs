//! A symmetric matrix of blocks: which blocks of its lower triangle there are, and where their numbers stand.

use std::sync::Arc;

use super::symbolic::Symbolic;
use crate::graph::GraphError;

/// The lower triangle of a symmetric matrix by blocks, its variables in the order of elimination.
///
/// Each block stands by itself, column by column; blocks follow each other by columns, then rows, the diagonal first.
/// Diagonal blocks are stored whole, and only their lower triangles are read.
#[derive(Clone, Debug)]
pub(crate) struct Pattern {
    pub(crate) symbolic: Arc<Symbolic>,
    /// First scalar of each variable, in the order of elimination, and the end.
    pub(crate) starts: Vec<usize>,
    /// First block of each column, and the end.
    columns: Vec<u32>,
    /// Row of each block.
    rows: Vec<u32>,
    /// First number of each block, and the end.
    at: Vec<u32>,
}

/// One block of a [`Pattern`]: `rows`×`columns` numbers from `at` on, its first entry at (`row`, `column`), in scalars.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    pub(crate) row: usize,
    pub(crate) column: usize,
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    pub(crate) at: usize,
}

impl Pattern {
    /// Orders variables with these dimensions, joined by `pairs` in either direction and each once. Diagonal blocks need no
    /// mention.
    ///
    /// # Errors
    /// [`GraphError::OutOfMemory`] beyond 2³² numbers.
    #[cfg(any(test, feature = "io"))]
    pub(crate) fn new(dims: &[usize], pairs: &[(u32, u32)]) -> Result<Self, GraphError> {
        Self::lay_out(Arc::new(Symbolic::new(dims, pairs)), dims, pairs)
    }

    /// Lays out variables with these dimensions in the order of an analysis of the same `pairs`, whose dimensions may have been
    /// others.
    ///
    /// # Errors
    /// [`GraphError::OutOfMemory`] beyond 2³² numbers.
    pub(crate) fn lay_out(
        symbolic: Arc<Symbolic>,
        dims: &[usize],
        pairs: &[(u32, u32)],
    ) -> Result<Self, GraphError> {
        let count = dims.len();
        let (mut places, mut starts) = (vec![0u32; count], vec![0]);
        for (place, &variable) in (0u32..).zip(&symbolic.order) {
            places[variable as usize] = place;
            starts.push(starts[place as usize] + dims[variable as usize]);
        }
        let mut columns = vec![1u32; count + 1]; // a diagonal block each
        columns[0] = 0;
        let place = |&(a, b): &(u32, u32)| {
            let (a, b) = (places[a as usize], places[b as usize]);
            (a != b).then_some((a.min(b) as usize, a.max(b)))
        };
        pairs.iter().filter_map(place).for_each(|(column, _)| columns[column + 1] += 1);
        (0..count).for_each(|i| columns[i + 1] += columns[i]);
        let mut next: Vec<u32> = columns[..count].iter().map(|first| first + 1).collect();
        let mut rows = vec![0; columns[count] as usize];
        (0..count).for_each(|i| rows[columns[i] as usize] = i as u32);
        for (column, row) in pairs.iter().filter_map(place) {
            rows[next[column] as usize] = row;
            next[column] += 1;
        }
        let (mut at, mut total) = (vec![0], 0usize);
        for column in 0..count {
            let rows = &mut rows[columns[column] as usize..columns[column + 1] as usize];
            rows.sort_unstable();
            let dim = starts[column + 1] - starts[column];
            for &row in &*rows {
                total += dim * (starts[row as usize + 1] - starts[row as usize]);
                at.push(u32::try_from(total).map_err(|_| GraphError::OutOfMemory)?);
            }
        }
        Ok(Self { symbolic, starts, columns, rows, at })
    }

    /// Number of scalar rows.
    pub(crate) fn size(&self) -> usize {
        self.starts[self.starts.len() - 1]
    }

    /// Number of numbers in the matrix.
    pub(crate) fn len(&self) -> usize {
        self.at[self.at.len() - 1] as usize
    }

    /// The variable, by its place in the order of elimination, to which a scalar belongs.
    pub(crate) fn place_of(&self, scalar: usize) -> usize {
        self.starts.partition_point(|&start| start <= scalar) - 1
    }

    /// The blocks of a column, by places in the order of elimination.
    pub(crate) fn column(&self, column: usize) -> impl Iterator<Item = Block> {
        (self.columns[column] as usize..self.columns[column + 1] as usize).map(move |k| self.block(column, k))
    }

    /// All blocks in the order of their numbers.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = Block> {
        (0..self.starts.len() - 1).flat_map(|column| self.column(column))
    }

    /// First number of the block at a row and a column not after it, or `None` where there is none.
    pub(crate) fn find(&self, row: usize, column: usize) -> Option<usize> {
        let (from, to) = (self.columns[column] as usize, self.columns[column + 1] as usize);
        let k = self.rows[from..to].binary_search(&(row as u32)).ok()?;
        Some(self.at[from + k] as usize)
    }

    /// Position of every diagonal entry in the matrix.
    pub(crate) fn diagonal(&self) -> Vec<usize> {
        let mut diagonal = Vec::with_capacity(self.size());
        for variable in 0..self.starts.len() - 1 {
            let at = self.at[self.columns[variable] as usize] as usize;
            let dim = self.starts[variable + 1] - self.starts[variable];
            diagonal.extend((0..dim).map(|i| at + i * (dim + 1)));
        }
        diagonal
    }

    fn block(&self, column: usize, k: usize) -> Block {
        let row = self.rows[k] as usize;
        let (first, above) = (self.starts[column], self.starts[row]);
        Block {
            row: above,
            column: first,
            rows: self.starts[row + 1] - above,
            columns: self.starts[column + 1] - first,
            at: self.at[k] as usize,
        }
    }
}
