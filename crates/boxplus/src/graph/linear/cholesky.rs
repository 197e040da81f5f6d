//! Sparse Cholesky factorisation by fronts.
//!
//! A *front* holds a supernode: its pivots, the rows below them, and nothing else, as a small dense matrix. Eliminating
//! the pivots leaves an *update*, a dense matrix of the rows below, which the parent in the elimination tree adds to its own
//! front: all arithmetic is dense, and every number moves up the tree once (Duff & Reid 1983; Liu 1992).
//!
//! ```text
//! front = blocks of the pivots' columns + updates of the children        assembly
//! [L₁₁; L₂₁] and U = −L₂₁L₂₁ᵀ + …                                        elimination
//! ```
//!
//! The right-hand side is one more row of every front, so that the forward substitution comes with the factor. Updates live
//! on two stacks, one for even levels of the tree and one for odd: a front's update never overlaps with those it consumes.
//! Where everything goes is worked out once; a factorisation allocates nothing.
//!
//! A front, with L₁₁, L₂₁ and the right-hand side, is what a Bayes tree calls a clique: the density of its pivots given the
//! rows below. The panels and updates of an unchanged subtree may be kept when variables join elsewhere; incremental
//! smoothing is to eliminate again only the fronts between the changed variables and the root.

use super::kernels::{Extension, Kernels, Matrix, Product, Run, SLACK};
use super::pattern::Pattern;
use super::symbolic::Symbolic;
use crate::graph::GraphError;

/// A pivot was not positive: the matrix is not (numerically) positive definite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NotPositive;

/// A symmetric positive definite matrix A = LLᵀ of fixed pattern.
pub(crate) struct Cholesky {
    pub(super) plan: Plan,
    pub(super) kernels: Kernels,
    /// The columns of L front by front, each front `rows + 1` high.
    pub(super) panels: Vec<f64>,
    pub(super) stacks: [Vec<f64>; 2],
    scratch: Vec<f64>,
    /// The entries of A⁻¹ in the pattern of L, where they were asked for.
    pub(super) inverse: Vec<f64>,
}

/// Where everything goes.
#[derive(Debug, Default)]
pub(super) struct Plan {
    size: usize,
    pub(super) fronts: Vec<Front>,
    loads: Vec<Load>,
    runs: Vec<Run>,
    children: Vec<u32>,
    /// Numbers in L.
    factor_len: usize,
    pub(super) tallest: usize,
}

/// One supernode. Its matrix has `rows` rows, of which the first `pivots` are eliminated here, and the right-hand side below.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Front {
    /// First pivot, in scalars of the matrix.
    pub(super) start: usize,
    pub(super) pivots: usize,
    pub(super) rows: usize,
    /// First number of its columns in the panels.
    pub(super) panel: usize,
    /// First number of its columns in the selected inverse, each `rows` high.
    pub(super) inverse: usize,
    /// Which stack its update is on, and where.
    pub(super) stack: usize,
    pub(super) update: usize,
    /// Its parts of the lists of the plan.
    loads: (usize, usize),
    runs: (usize, usize),
    children: (usize, usize),
}

impl Front {
    pub(super) fn below(&self) -> usize {
        self.rows - self.pivots
    }
    /// Height of its columns in the panels.
    pub(super) fn stride(&self) -> usize {
        self.rows + 1
    }
    /// Height of the columns of its update.
    pub(super) fn update_stride(&self) -> usize {
        self.below() + 1
    }
    pub(super) fn update_len(&self) -> usize {
        self.update_stride() * self.below()
    }
}

/// A block of the matrix to be copied into the columns of its front.
#[derive(Clone, Copy, Debug)]
struct Load {
    from: u32,
    to: u32,
    rows: u32,
    columns: u32,
}

impl Cholesky {
    /// Lays out the factor of matrices of this pattern.
    ///
    /// # Errors
    /// [`GraphError::OutOfMemory`].
    pub(crate) fn new(pattern: &Pattern) -> Result<Self, GraphError> {
        let (plan, panels, stacks) = Plan::new(pattern)?;
        let scratch = zeros(plan.tallest)?;
        Ok(Self {
            plan,
            kernels: Kernels::new(),
            panels: zeros(panels)?,
            stacks: [zeros(stacks[0])?, zeros(stacks[1])?],
            scratch,
            inverse: vec![],
        })
    }

    /// Numbers in the factor L, a measure of the work.
    pub(crate) fn factor_len(&self) -> usize {
        self.plan.factor_len
    }

    /// Factorises A, in the pattern that was analysed.
    ///
    /// # Errors
    /// [`NotPositive`] where a pivot is not positive.
    pub(crate) fn factorise(&mut self, matrix: &[f64]) -> Result<(), NotPositive> {
        self.eliminate(&System { matrix, damping: None, rhs: None })
    }

    /// Factorises A + λD, D diagonal, and carries `rhs` through the forward substitution.
    ///
    /// # Errors
    /// [`NotPositive`] where a pivot is not positive.
    pub(crate) fn factorise_with(
        &mut self,
        matrix: &[f64],
        damping: (f64, &[f64]),
        rhs: &[f64],
    ) -> Result<(), NotPositive> {
        self.eliminate(&System { matrix, damping: Some(damping), rhs: Some(rhs) })
    }

    /// The solution for the right-hand side that came with the factorisation.
    pub(crate) fn solution(&mut self) -> Vec<f64> {
        let mut x = vec![0.0; self.plan.size];
        for front in &self.plan.fronts {
            let last = self.panels[front.panel..].iter().skip(front.rows).step_by(front.stride());
            let range = front.start..front.start + front.pivots;
            x[range].iter_mut().zip(last).for_each(|(x, carried)| *x = *carried);
        }
        self.backward(&mut x);
        x
    }

    /// Overwrites the columns of `rhs` (each as long as the matrix) with A⁻¹·rhs.
    pub(crate) fn solve(&mut self, rhs: &mut [f64]) {
        for x in rhs.chunks_mut(self.plan.size.max(1)) {
            self.forward(x);
            self.backward(x);
        }
    }

    fn eliminate(&mut self, system: &System<'_>) -> Result<(), NotPositive> {
        let Self { plan, kernels, panels, stacks, inverse, .. } = self;
        inverse.clear();
        for number in 0..plan.fronts.len() {
            plan.eliminate(number, system, *kernels, panels, stacks)?;
        }
        Ok(())
    }

    /// x := L⁻¹x.
    fn forward(&mut self, x: &mut [f64]) {
        let Self { plan, kernels, panels, scratch, .. } = self;
        for front in &plan.fronts {
            let local = &mut scratch[..front.rows];
            local[..front.pivots].copy_from_slice(&x[front.start..front.start + front.pivots]);
            local[front.pivots..].fill(0.0);
            kernels.forward(&panels[front.panel..], front.stride(), front.pivots, local);
            x[front.start..front.start + front.pivots].copy_from_slice(&local[..front.pivots]);
            for run in plan.runs_of(front) {
                let (from, to, len) =
                    (run.from as usize + front.pivots, run.scalar as usize, run.len as usize);
                x[to..to + len].iter_mut().zip(&local[from..from + len]).for_each(|(x, l)| *x += l);
            }
        }
    }

    /// x := L⁻ᵀx.
    fn backward(&mut self, x: &mut [f64]) {
        let Self { plan, kernels, panels, scratch, .. } = self;
        for front in plan.fronts.iter().rev() {
            let local = &mut scratch[..front.rows];
            local[..front.pivots].copy_from_slice(&x[front.start..front.start + front.pivots]);
            for run in plan.runs_of(front) {
                let (to, from, len) =
                    (run.from as usize + front.pivots, run.scalar as usize, run.len as usize);
                local[to..to + len].copy_from_slice(&x[from..from + len]);
            }
            kernels.backward(&panels[front.panel..], front.stride(), front.pivots, local);
            x[front.start..front.start + front.pivots].copy_from_slice(&local[..front.pivots]);
        }
    }
}

/// (A + λD)x = b.
struct System<'a> {
    matrix: &'a [f64],
    damping: Option<(f64, &'a [f64])>,
    rhs: Option<&'a [f64]>,
}

/// Zeros, with [`SLACK`] behind them.
pub(super) fn zeros(len: usize) -> Result<Vec<f64>, GraphError> {
    let mut numbers = vec![];
    numbers.try_reserve_exact(len + SLACK).map_err(|_| GraphError::OutOfMemory)?;
    numbers.resize(len + SLACK, 0.0);
    Ok(numbers)
}

impl Plan {
    /// The plan, and how long the panels and the two stacks are.
    fn new(pattern: &Pattern) -> Result<(Self, usize, [usize; 2]), GraphError> {
        let symbolic = &pattern.symbolic;
        let count = symbolic.parents.len();
        let mut plan = Self { size: pattern.size(), ..Self::default() };
        let mut stacks = [0usize; 2];
        let (mut panels, mut inverses) = (0, 0);
        let mut children = vec![vec![]; count];
        for number in 0..count {
            if symbolic.parents[number] != Symbolic::ROOT {
                children[symbolic.parents[number] as usize].push(number as u32);
            }
        }
        let mut depth = vec![0usize; count];
        for number in (0..count).rev() {
            if symbolic.parents[number] != Symbolic::ROOT {
                depth[number] = (depth[symbolic.parents[number] as usize] + 1) % 2;
            }
        }
        let mut tops = [0usize; 2];
        let starts = &pattern.starts;
        for number in 0..count {
            let (first, end) = (symbolic.starts[number] as usize, symbolic.starts[number + 1] as usize);
            let rows = symbolic.rows_of(number);
            let below: usize = rows.iter().map(|&r| starts[r as usize + 1] - starts[r as usize]).sum();
            let pivots = starts[end] - starts[first];
            let mut front = Front {
                start: starts[first],
                pivots,
                rows: pivots + below,
                panel: panels,
                inverse: inverses,
                stack: depth[number],
                ..Front::default()
            };
            front.loads.0 = plan.loads.len();
            plan.load_front(pattern, &front, (first, end), rows);
            front.loads.1 = plan.loads.len();
            front.children.0 = plan.children.len();
            for &child in &children[number] {
                let child = &plan.fronts[child as usize];
                tops[child.stack] -= child.update_len();
            }
            plan.children.extend(&children[number]);
            front.children.1 = plan.children.len();
            front.update = tops[front.stack];
            tops[front.stack] += front.update_len();
            stacks[front.stack] = stacks[front.stack].max(tops[front.stack]);
            panels += front.stride() * pivots;
            inverses += front.rows * pivots;
            plan.factor_len += (front.rows * pivots) - pivots * (pivots - 1) / 2;
            plan.tallest = plan.tallest.max(front.rows);
            plan.fronts.push(front);
        }
        for number in 0..count {
            let begin = plan.runs.len();
            if symbolic.parents[number] != Symbolic::ROOT {
                plan.map_rows(pattern, number);
            }
            plan.fronts[number].runs = (begin, plan.runs.len());
        }
        if u32::try_from(plan.size).is_err() {
            return Err(GraphError::OutOfMemory);
        }
        Ok((plan, panels, stacks))
    }

    fn load_front(&mut self, pattern: &Pattern, front: &Front, (first, end): (usize, usize), rows: &[u32]) {
        let starts = &pattern.starts;
        for column in first..end {
            let (mut k, mut offset) = (0, front.pivots); // the rows below, and where they stand
            for block in pattern.column(column) {
                let row = if block.row < starts[end] {
                    block.row - front.start
                } else {
                    while starts[rows[k] as usize] != block.row {
                        offset += starts[rows[k] as usize + 1] - starts[rows[k] as usize];
                        k += 1;
                    }
                    offset
                };
                self.loads.push(Load {
                    from: block.at as u32,
                    to: ((block.column - front.start) * front.stride() + row) as u32,
                    rows: block.rows as u32,
                    columns: block.columns as u32,
                });
            }
        }
    }

    /// Finds the rows of an update in the front of the parent.
    fn map_rows(&mut self, pattern: &Pattern, number: usize) {
        let symbolic = &pattern.symbolic;
        let starts = &pattern.starts;
        let parent = symbolic.parents[number] as usize;
        let end = symbolic.starts[parent + 1];
        let first = starts[symbolic.starts[parent] as usize];
        let above = symbolic.rows_of(parent);
        let (mut k, mut offset) = (0, 0);
        let mut from = 0;
        let begin = self.runs.len();
        for &row in symbolic.rows_of(number) {
            let len = starts[row as usize + 1] - starts[row as usize];
            let pivots = row < end;
            let to = if pivots {
                starts[row as usize] - first
            } else {
                while above[k] != row {
                    offset += starts[above[k] as usize + 1] - starts[above[k] as usize];
                    k += 1;
                }
                offset
            };
            let scalar = starts[row as usize];
            match self.runs[begin..].last_mut() {
                Some(run)
                    if run.pivots == pivots
                        && (run.to + run.len) as usize == to
                        && (run.scalar + run.len) as usize == scalar =>
                {
                    run.len += len as u32;
                }
                _ => self.runs.push(Run {
                    from,
                    to: to as u32,
                    len: len as u32,
                    pivots,
                    scalar: scalar as u32,
                }),
            }
            from += len as u32;
        }
    }

    pub(super) fn children_of(&self, front: &Front) -> &[u32] {
        &self.children[front.children.0..front.children.1]
    }

    pub(super) fn runs_of(&self, front: &Front) -> &[Run] {
        &self.runs[front.runs.0..front.runs.1]
    }

    /// Assembles and eliminates one front.
    fn eliminate(
        &self,
        number: usize,
        system: &System<'_>,
        kernels: Kernels,
        panels: &mut [f64],
        stacks: &mut [Vec<f64>; 2],
    ) -> Result<(), NotPositive> {
        let front = &self.fronts[number];
        let (stride, below) = (front.stride(), front.below());
        let panel = &mut panels[front.panel..front.panel + stride * front.pivots + SLACK];
        panel[..stride * front.pivots].fill(0.0);
        self.load(front, system, panel);

        let [even, odd] = stacks;
        let (own, other) = if front.stack == 0 { (even, odd) } else { (odd, even) };
        let update = &mut own[front.update..front.update + front.update_len() + SLACK];
        let children = self.children_of(front);
        if !children.is_empty() {
            let columns = update[..front.update_len()].chunks_exact_mut(below + 1);
            columns.enumerate().for_each(|(c, column)| column[c..].fill(0.0));
        }
        for &child in children {
            let child = &self.fronts[child as usize];
            let from = &other[child.update..child.update + child.update_len()];
            kernels.extend_add(Extension {
                runs: self.runs_of(child),
                from: Matrix { numbers: from, stride: child.update_stride() },
                panel,
                stride,
                update,
                update_stride: below + 1,
            });
        }
        if !kernels.factorise(panel, stride, front.pivots) {
            return Err(NotPositive);
        }
        let below_pivots = Matrix { numbers: &panel[front.pivots..], stride };
        kernels.subtract_product(Product {
            c: update,
            stride: below + 1,
            a: below_pivots,
            b: below_pivots,
            rows: below + 1,
            columns: below,
            depth: front.pivots,
            lower: true,
            fresh: children.is_empty(),
        });
        Ok(())
    }

    /// Copies the blocks of the matrix and the right-hand side into the columns of a front.
    fn load(&self, front: &Front, system: &System<'_>, panel: &mut [f64]) {
        let stride = front.stride();
        for load in &self.loads[front.loads.0..front.loads.1] {
            let (rows, columns) = (load.rows as usize, load.columns as usize);
            let block = &system.matrix[load.from as usize..][..rows * columns];
            let target = &mut panel[load.to as usize..];
            match rows {
                3 => copy_columns::<3>(block, target, stride),
                6 => copy_columns::<6>(block, target, stride),
                _ => {
                    for (column, target) in block.chunks_exact(rows).zip(target.chunks_mut(stride)) {
                        target[..rows].copy_from_slice(column);
                    }
                }
            }
        }
        let range = front.start..front.start + front.pivots;
        if let Some((lambda, diagonal)) = system.damping {
            for (p, d) in diagonal[range.clone()].iter().enumerate() {
                panel[p * (stride + 1)] += lambda * d;
            }
        }
        if let Some(rhs) = system.rhs {
            for (p, b) in rhs[range].iter().enumerate() {
                panel[p * stride + front.rows] = *b;
            }
        }
    }
}

/// Copies columns of R rows: the compiler knows how many.
fn copy_columns<const R: usize>(block: &[f64], target: &mut [f64], stride: usize) {
    for (column, target) in block.chunks_exact(R).zip(target.chunks_mut(stride)) {
        target[..R].copy_from_slice(column);
    }
}
