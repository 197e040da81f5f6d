//! The normal equations JᵀJ δ = −Jᵀr as a block-sparse lower triangle, laid out once and refilled every iteration.
//!
//! No Jacobian matrix is formed. Each pair of variables that a factor joins has one place in the triangle; a factor's
//! part of JᵀJ is added there through offsets computed beforehand. Variables stand in elimination order (approximate
//! minimum degree on the graph of variables, not of scalars), so that the factorisation permutes nothing.

use super::cholesky::minimum_degree;
use crate::graph::GraphError;
use crate::graph::set::{AnySet, Places};
use crate::graph::values::{Offsets, Values, VariableId};

/// The matrix JᵀJ (lower triangle, compressed columns of [`Structure::pattern`]) and the vector Jᵀr.
#[derive(Clone, Debug)]
pub(crate) struct Normal {
    pub(crate) matrix: Vec<f64>,
    pub(crate) gradient: Vec<f64>,
}

/// Compressed columns: the rows of column c are `rows[starts[c]..starts[c + 1]]`, ascending.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pattern {
    pub(crate) starts: Vec<usize>,
    pub(crate) rows: Vec<usize>,
}

/// Where everything stands in the normal equations.
#[derive(Clone, Debug)]
pub(crate) struct Structure {
    /// The free variables in elimination order.
    pub(crate) variables: Vec<VariableId>,
    /// First scalar of each of them, and the total.
    pub(crate) starts: Vec<usize>,
    /// The same by variable.
    pub(crate) offsets: Offsets,
    /// Pattern of the lower triangle, in scalars.
    pub(crate) pattern: Pattern,
    /// Position of each diagonal entry in the matrix.
    pub(crate) diagonal: Vec<usize>,
    /// Free variables that no factor reads.
    pub(crate) unread: Vec<VariableId>,
    pub(crate) plans: Vec<SetPlan>,
}

/// Where each factor of a set adds its part.
#[derive(Clone, Debug)]
pub(crate) struct SetPlan {
    /// Offset of each variable of each factor in the gradient.
    gradients: Vec<u32>,
    blocks: Vec<Place>,
}

/// Where one block stands: entry (r, c) is at `base + c·stride − c(c−1)/2 + r`, diagonal blocks from the diagonal on.
#[derive(Clone, Copy, Debug)]
struct Place {
    base: u32,
    stride: u32,
    kind: PlaceKind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum PlaceKind {
    /// A held variable: nothing is added.
    Nowhere,
    Diagonal,
    /// Rows of the later variable of the factor, columns of the earlier one.
    AsIs,
    Transposed,
    /// Both variables of the pair are one and the same: B + Bᵀ goes to its diagonal block.
    Twice,
}

impl Structure {
    /// Orders the free variables of the sets and lays out the matrix.
    ///
    /// # Errors
    /// [`GraphError::OutOfMemory`] beyond 2³² numbers in the triangle.
    pub(crate) fn new(sets: &[Box<dyn AnySet>], values: &Values) -> Result<Self, GraphError> {
        let free: Vec<VariableId> = values.ids().filter(|&id| !values.is_held(id)).collect();
        let mut index = Offsets::none(values);
        free.iter().enumerate().for_each(|(i, &id)| index.set(id, i));

        let mut pairs = sorted(pairs_of_variables(sets, &index), free.len());
        let mut read = vec![false; free.len()];
        pairs.iter().for_each(|&(a, b)| (read[a as usize], read[b as usize]) = (true, true));
        let unread = free.iter().zip(&read).filter(|(_, read)| !**read).map(|(&id, _)| id).collect();

        let order = minimum_degree(free.len(), &pairs)?;
        let mut position = vec![u32::MAX; free.len()];
        let mut variables = Vec::with_capacity(free.len());
        for &i in order.iter().filter(|&&i| read[i]) {
            position[i] = variables.len() as u32;
            variables.push(free[i]);
        }
        for pair in &mut pairs {
            let (a, b) = (position[pair.0 as usize], position[pair.1 as usize]);
            *pair = (a.min(b), a.max(b));
        }
        let pairs = sorted(pairs, variables.len());
        let dim = |i: u32| values.dim(variables[i as usize]);
        let entries: usize = pairs.iter().map(|&(a, b)| dim(a) * dim(b)).sum();
        if u32::try_from(entries).is_err() {
            return Err(GraphError::OutOfMemory);
        }
        Ok(Self::lay_out(sets, values, variables, &pairs, unread))
    }

    /// Lays out the matrix for variables in this order; `pairs` are sorted (column, row) blocks with the diagonal.
    fn lay_out(
        sets: &[Box<dyn AnySet>],
        values: &Values,
        variables: Vec<VariableId>,
        pairs: &[(u32, u32)],
        unread: Vec<VariableId>,
    ) -> Self {
        let mut starts = vec![0];
        let mut position = Offsets::none(values);
        let mut offsets = Offsets::none(values);
        for (i, &id) in variables.iter().enumerate() {
            position.set(id, i);
            offsets.set(id, starts[i]);
            starts.push(starts[i] + values.dim(id));
        }
        let mut columns = vec![0; variables.len() + 1];
        pairs.iter().for_each(|&(column, _)| columns[column as usize + 1] += 1);
        (0..variables.len()).for_each(|i| columns[i + 1] += columns[i]);

        let mut pattern = Pattern { starts: vec![0], rows: vec![] };
        let mut diagonal = vec![];
        let mut above = vec![];
        for column in 0..variables.len() {
            let blocks = &pairs[columns[column]..columns[column + 1]];
            above.extend(blocks.iter().scan(0, |sum, &(_, row)| {
                let row = row as usize;
                let before = *sum;
                *sum += (starts[row + 1] - starts[row]) as u32;
                Some(before)
            }));
            for first in starts[column]..starts[column + 1] {
                diagonal.push(pattern.rows.len());
                for &(_, row) in blocks {
                    pattern.rows.extend(starts[row as usize].max(first)..starts[row as usize + 1]);
                }
                pattern.starts.push(pattern.rows.len());
            }
        }
        let layout = Layout {
            pairs,
            above: &above,
            columns: &columns,
            starts: &starts,
            pattern: &pattern,
            position: &position,
        };
        let plans = sets.iter().map(|set| layout.plan(set.as_ref())).collect();
        Self { variables, starts, offsets, pattern, diagonal, unread, plans }
    }

    /// Number of unknown scalars.
    pub(crate) fn size(&self) -> usize {
        self.diagonal.len()
    }

    /// The free variable to which a scalar belongs, with the number of its coordinate.
    pub(crate) fn coordinate(&self, scalar: usize) -> (VariableId, usize) {
        let variable = self.starts.partition_point(|&start| start <= scalar) - 1;
        (self.variables[variable], scalar - self.starts[variable])
    }

    /// Zeroed normal equations.
    pub(crate) fn normal(&self) -> Normal {
        Normal { matrix: vec![0.0; self.pattern.rows.len()], gradient: vec![0.0; self.size()] }
    }
}

/// Every pair of free variables that some factor joins, with the diagonal, as often as it does.
fn pairs_of_variables(sets: &[Box<dyn AnySet>], index: &Offsets) -> Vec<(u32, u32)> {
    let mut pairs = vec![];
    for set in sets {
        let places = Places::new(set.as_ref(), index);
        for factor in 0..set.len() {
            let free = || places.of(factor).flatten().map(|i| i as u32);
            for (q, b) in free().enumerate() {
                pairs.extend(free().take(q + 1).map(|a| (a.min(b), a.max(b))));
            }
        }
    }
    pairs
}

/// The pairs (a, b), a < `count`, sorted and each once: by buckets of a, which are small.
fn sorted(pairs: Vec<(u32, u32)>, count: usize) -> Vec<(u32, u32)> {
    let mut starts = vec![0; count + 1];
    pairs.iter().for_each(|&(a, _)| starts[a as usize + 1] += 1);
    (0..count).for_each(|i| starts[i + 1] += starts[i]);
    let mut next = starts.clone();
    let mut sorted = vec![(0, 0); pairs.len()];
    for pair in pairs {
        sorted[next[pair.0 as usize]] = pair;
        next[pair.0 as usize] += 1;
    }
    (0..count).for_each(|i| sorted[starts[i]..starts[i + 1]].sort_unstable());
    sorted.dedup();
    sorted
}

struct Layout<'a> {
    /// (column, row) of each block, sorted, and the number of scalar rows above it in its column.
    pairs: &'a [(u32, u32)],
    above: &'a [u32],
    columns: &'a [usize],
    starts: &'a [usize],
    pattern: &'a Pattern,
    position: &'a Offsets,
}

impl Layout<'_> {
    fn plan(&self, set: &dyn AnySet) -> SetPlan {
        let mut plan = SetPlan { gradients: vec![], blocks: vec![] };
        let places = Places::new(set, self.position);
        for factor in 0..set.len() {
            let positions = || places.of(factor).enumerate();
            plan.gradients
                .extend(positions().map(|(_, p)| p.map_or(Offsets::NONE, |p| self.starts[p] as u32)));
            for (q, b) in positions() {
                plan.blocks.extend(positions().take(q + 1).map(|(p, a)| self.place(a, b, p == q)));
            }
        }
        plan
    }

    /// The place of the block with the rows of `b` and the columns of `a`.
    fn place(&self, a: Option<usize>, b: Option<usize>, same: bool) -> Place {
        let (Some(a), Some(b)) = (a, b) else {
            return Place { base: 0, stride: 0, kind: PlaceKind::Nowhere };
        };
        let kind = match (a == b, same) {
            (true, true) => PlaceKind::Diagonal,
            (true, false) => PlaceKind::Twice,
            _ if a < b => PlaceKind::AsIs,
            _ => PlaceKind::Transposed,
        };
        let (column, row) = (a.min(b), a.max(b));
        let blocks = &self.pairs[self.columns[column]..self.columns[column + 1]];
        let above = self.above[self.columns[column] + blocks.partition_point(|&(_, r)| (r as usize) < row)];
        let first = self.starts[column];
        let height = self.pattern.starts[first + 1] - self.pattern.starts[first];
        // One column on, the block is one shorter at its top: −1, less the triangle already passed.
        Place { base: self.pattern.starts[first] as u32 + above, stride: height as u32 - 1, kind }
    }
}

impl SetPlan {
    /// Adds the part of one factor: its gradients, then its blocks Jᵀ_q J_p for p ≤ q, column by column.
    #[inline(always)]
    pub(crate) fn scatter(&self, factor: usize, dims: &[usize], part: &[f64], normal: &mut Normal) {
        let mut at = 0;
        for (i, &dim) in dims.iter().enumerate() {
            let offset = self.gradients[factor * dims.len() + i];
            if offset != Offsets::NONE {
                let target = &mut normal.gradient[offset as usize..offset as usize + dim];
                target.iter_mut().zip(&part[at..at + dim]).for_each(|(t, x)| *t += x);
            }
            at += dim;
        }
        let pairs = dims.len() * (dims.len() + 1) / 2;
        let mut places = self.blocks[factor * pairs..(factor + 1) * pairs].iter();
        for q in 0..dims.len() {
            for p in 0..=q {
                let block = &part[at..at + dims[p] * dims[q]];
                if let Some(place) = places.next() {
                    place.add(dims[q], dims[p], block, &mut normal.matrix);
                }
                at += dims[p] * dims[q];
            }
        }
    }
}

impl Place {
    /// Index of the first row of a block in column `c`; in the diagonal block row r of column c is at `+ r`.
    #[inline(always)]
    fn column(self, c: usize) -> usize {
        // Column c is c shorter than the first, and so is each before it: c·height − c(c−1)/2 − c.
        self.base as usize + c * self.stride as usize - (c * c.wrapping_sub(1)) / 2
    }

    #[inline(always)]
    fn add(self, rows: usize, columns: usize, block: &[f64], matrix: &mut [f64]) {
        match self.kind {
            PlaceKind::Nowhere => {}
            PlaceKind::AsIs => {
                for c in 0..columns {
                    let start = self.column(c);
                    let target = &mut matrix[start..start + rows];
                    target.iter_mut().zip(&block[c * rows..(c + 1) * rows]).for_each(|(t, x)| *t += x);
                }
            }
            PlaceKind::Transposed => {
                for c in 0..rows {
                    let start = self.column(c);
                    let target = &mut matrix[start..start + columns];
                    target.iter_mut().enumerate().for_each(|(r, t)| *t += block[r * rows + c]);
                }
            }
            PlaceKind::Diagonal => {
                for c in 0..columns {
                    let start = self.column(c) + c;
                    let target = &mut matrix[start..start + rows - c];
                    target.iter_mut().zip(&block[c * rows + c..(c + 1) * rows]).for_each(|(t, x)| *t += x);
                }
            }
            PlaceKind::Twice => {
                for c in 0..columns {
                    let start = self.column(c) + c;
                    let target = &mut matrix[start..start + rows - c];
                    target.iter_mut().enumerate().for_each(|(i, t)| {
                        let r = c + i;
                        *t += block[c * rows + r] + block[r * rows + c];
                    });
                }
            }
        }
    }
}
