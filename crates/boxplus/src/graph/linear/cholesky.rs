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
//! A *leaf*, without children, has nothing to add to its update, so that the update need not be formed: −L₂₁L₂₁ᵀ is subtracted
//! from the parent where it belongs. Points seen by a few cameras are such, and what is left in the parents is the Schur
//! complement, the reduced camera system; points with the same cameras are one product.
//!
//! The right-hand side is one more row of every front, so that the forward substitution comes with the factor. Updates live
//! on two stacks, one for even levels of the tree and one for odd: a front's update never overlaps with those it consumes.
//! Where everything goes is worked out once; a factorisation allocates nothing.
//!
//! A front, with L₁₁, L₂₁ and the right-hand side, is what a Bayes tree calls a clique: the density of its pivots given the
//! rows below. The panels and updates of an unchanged subtree may be kept when variables join elsewhere; incremental
//! smoothing is to eliminate again only the fronts between the changed variables and the root.

use std::sync::Arc;

use core::ops::Range;

use super::kernels::{Columns, Extension, Kernels, Matrix, Outer, Product, SLACK};
use super::pattern::Pattern;
use super::plan::{Front, Leaves, Plan};
use crate::graph::GraphError;
use crate::pool::Pool;

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
    pool: Option<Arc<Pool>>,
    workers: Vec<Worker>,
}

/// The stacks of a thread that eliminates a subtree, and where they stand in the common ones.
struct Worker {
    stacks: [Vec<f64>; 2],
    bases: [usize; 2],
}

impl Worker {
    fn new(plan: &Plan, task: &Range<usize>) -> Result<Self, GraphError> {
        let (mut bases, mut ends) = ([usize::MAX; 2], [0; 2]);
        for front in plan.fronts[task.clone()].iter().filter(|front| !front.is_leaf) {
            bases[front.stack] = bases[front.stack].min(front.update);
            ends[front.stack] = ends[front.stack].max(front.update + front.update_len());
        }
        let length = |i: usize| ends[i].saturating_sub(bases[i]);
        Ok(Self { stacks: [zeros(length(0))?, zeros(length(1))?], bases })
    }
}

impl Cholesky {
    /// Lays out the factor of matrices of this pattern.
    ///
    /// # Errors
    /// [`GraphError::OutOfMemory`].
    pub(crate) fn new(pattern: &Pattern) -> Result<Self, GraphError> {
        let plan = Plan::new(pattern)?;
        Ok(Self {
            kernels: Kernels::new(),
            panels: zeros(plan.panels)?,
            stacks: [zeros(plan.stacks[0])?, zeros(plan.stacks[1])?],
            scratch: zeros(plan.tallest)?,
            inverse: vec![],
            pool: None,
            workers: vec![],
            plan,
        })
    }

    /// Lets threads share the factorisations to come: subtrees side by side, then the columns of large fronts. Bits do not
    /// depend on it.
    ///
    /// # Errors
    /// [`GraphError::OutOfMemory`].
    pub(crate) fn share(&mut self, pool: Arc<Pool>) -> Result<(), GraphError> {
        if pool.threads() > 1 && !self.plan.tasks.is_empty() {
            let tasks = self.plan.tasks.iter();
            self.workers = tasks.map(|task| Worker::new(&self.plan, task)).collect::<Result<_, _>>()?;
            self.pool = Some(pool);
        }
        Ok(())
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

    /// The subtrees that have a worker each, then all else in order.
    fn eliminate(&mut self, system: &System<'_>) -> Result<(), NotPositive> {
        self.inverse.clear();
        self.eliminate_tasks(system)?;
        let Self { plan, kernels, panels, stacks, pool, workers, .. } = self;
        let elimination = Elimination { plan, system, kernels: *kernels, pool: pool.as_deref() };
        let mut next = 0;
        for (task, worker) in plan.tasks.iter().zip(&*workers) {
            let mut space = Space { panels, first: 0, stacks, bases: [0; 2] };
            (next..task.start).try_for_each(|number| elimination.eliminate(number, &mut space))?;
            // Only now: until here its place on the common stack may have been another's.
            let root = &plan.fronts[task.end - 1];
            let from = &worker.stacks[root.stack][root.update - worker.bases[root.stack]..];
            stacks[root.stack][root.update..][..root.update_len()]
                .copy_from_slice(&from[..root.update_len()]);
            next = task.end;
        }
        let mut space = Space { panels, first: 0, stacks, bases: [0; 2] };
        (next..plan.fronts.len()).try_for_each(|number| elimination.eliminate(number, &mut space))
    }

    /// Eliminates the subtrees that have a worker each, on the worker's own stacks.
    fn eliminate_tasks(&mut self, system: &System<'_>) -> Result<(), NotPositive> {
        let Self { plan, kernels, panels, pool: Some(pool), workers, .. } = self else {
            return Ok(());
        };
        let elimination = Elimination { plan, system, kernels: *kernels, pool: None };
        let (mut rest, mut first) = (&mut panels[..], 0);
        let mut parts = Vec::with_capacity(workers.len());
        for (task, worker) in plan.tasks.iter().zip(&mut *workers) {
            let (start, root) = (plan.fronts[task.start].panel, plan.fronts[task.end - 1]);
            let end = root.panel + root.stride() * root.pivots + SLACK;
            let (panels, after) = core::mem::take(&mut rest)[start - first..].split_at_mut(end - start);
            (rest, first) = (after, end);
            let space = Space { panels, first: start, stacks: &mut worker.stacks, bases: worker.bases };
            parts.push((task.clone(), space, Ok(())));
        }
        pool.for_each(&mut parts, |_, (task, space, done)| {
            *done = task.clone().try_for_each(|number| elimination.eliminate(number, space));
        });
        parts.into_iter().try_for_each(|(_, _, done)| done)
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

/// Zeros, with [`SLACK`] behind them, from pages that the system need not touch before they are used.
///
/// # Errors
/// [`GraphError::OutOfMemory`].
pub(super) fn zeros(len: usize) -> Result<Vec<f64>, GraphError> {
    Vec::<f64>::new().try_reserve_exact(len + SLACK).map_err(|_| GraphError::OutOfMemory)?;
    Ok(vec![0.0; len + SLACK])
}

/// Work, in multiplications, from which the columns of an update are shared among threads, and how many go together.
const LARGE: usize = 1 << 20;
const STRIP: usize = 48;

/// Columns of L and stacks to work in, and where they stand in the whole.
struct Space<'a> {
    panels: &'a mut [f64],
    first: usize,
    stacks: &'a mut [Vec<f64>; 2],
    bases: [usize; 2],
}

/// What the elimination of every front reads.
struct Elimination<'a> {
    plan: &'a Plan,
    system: &'a System<'a>,
    kernels: Kernels,
    pool: Option<&'a Pool>,
}

impl Elimination<'_> {
    /// Assembles and eliminates one front.
    fn eliminate(&self, number: usize, space: &mut Space<'_>) -> Result<(), NotPositive> {
        let Self { plan, kernels, .. } = self;
        let front = &plan.fronts[number];
        let (stride, below) = (front.stride(), front.below());
        let (before, panel) = space.panels.split_at_mut(front.panel - space.first);
        let panel = &mut panel[..stride * front.pivots + SLACK];
        panel[..stride * front.pivots].fill(0.0);
        self.load(front, panel);
        if front.is_leaf {
            return if kernels.factorise(panel, stride, front.pivots) { Ok(()) } else { Err(NotPositive) };
        }

        let [even, odd] = &mut *space.stacks;
        let (own, other) = if front.stack == 0 { (even, odd) } else { (odd, even) };
        let update = &mut own[front.update - space.bases[front.stack]..][..front.update_len() + SLACK];
        let (children, leaves) = (plan.children_of(front), plan.leaves_of(front));
        let fresh = children.is_empty() && leaves.is_empty();
        if !fresh {
            let columns = update[..front.update_len()].chunks_exact_mut(below + 1);
            columns.enumerate().for_each(|(c, column)| column[c..].fill(0.0));
        }
        for columns in front.columns(panel, update) {
            self.subtract_leaves(front, (before, space.first), columns);
        }
        for &child in children {
            let child = &plan.fronts[child as usize];
            let from = &other[child.update - space.bases[child.stack]..][..child.update_len()];
            let from = Matrix { numbers: from, stride: child.update_stride() };
            for to in front.columns(panel, update) {
                kernels.extend_add(Extension { runs: plan.runs_of(child), from, to });
            }
        }
        if !kernels.factorise(panel, stride, front.pivots) {
            return Err(NotPositive);
        }
        self.subtract_square(front, panel, update, fresh);
        Ok(())
    }

    /// Subtracts the products of the leaves of a front from columns of it; where there is much to do, a strip for each thread.
    fn subtract_leaves(&self, front: &Front, (panels, first): (&[f64], usize), columns: Columns<'_>) {
        let leaves = self.plan.leaves_of(front);
        let subtract = |strip: &mut Columns<'_>| {
            for group in leaves {
                let leaf = &self.plan.fronts[group.first as usize];
                let numbers = &panels[leaf.panel + leaf.pivots - first..];
                self.kernels.subtract_outer(Outer {
                    runs: self.plan.runs_of(leaf),
                    l: Matrix { numbers, stride: leaf.stride() },
                    rows: leaf.update_stride(),
                    depth: group.depth,
                    to: strip.reborrow(),
                });
            }
        };
        let work = |group: &Leaves| group.depth * self.plan.fronts[group.first as usize].below().pow(2);
        match self.pool {
            Some(pool) if leaves.iter().map(work).sum::<usize>() > LARGE => {
                pool.for_each(&mut columns.strips(STRIP), |_, strip| subtract(strip));
            }
            _ => subtract(&mut { columns }),
        }
    }

    /// U := U − L₂₁L₂₁ᵀ with the right-hand side below, the columns of a large one on all threads.
    fn subtract_square(&self, front: &Front, panel: &[f64], update: &mut [f64], fresh: bool) {
        let stride = front.update_stride();
        let square = |first: usize, columns: &mut [f64], width: usize| {
            let numbers = &panel[front.pivots + first..];
            let l = Matrix { numbers, stride: front.stride() };
            self.kernels.subtract_product(Product {
                c: &mut columns[first..],
                stride,
                a: l,
                b: l,
                rows: stride - first,
                columns: width,
                depth: front.pivots,
                lower: true,
                fresh,
            });
        };
        match self.pool {
            Some(pool) if front.below() * front.below() * front.pivots > LARGE => {
                let update = &mut update[..front.update_len()];
                let mut strips: Vec<_> = update.chunks_mut(stride * STRIP).collect();
                pool.for_each(&mut strips, |i, columns| square(i * STRIP, columns, columns.len() / stride));
            }
            _ => square(0, update, front.below()),
        }
    }

    /// Copies the blocks of the matrix and the right-hand side into the columns of a front.
    fn load(&self, front: &Front, panel: &mut [f64]) {
        let (stride, system) = (front.stride(), self.system);
        for load in self.plan.loads_of(front) {
            let (rows, columns) = (load.rows as usize, load.columns as usize);
            let block = &system.matrix[load.from as usize..][..rows * columns];
            let target = &mut panel[load.to as usize..];
            match rows {
                2 => copy_columns::<2>(block, target, stride),
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
