//! Where everything goes in a factorisation: computed once for a pattern.

use core::ops::Range;

use super::kernels::{Columns, DEPTH, Run, SLACK};
use super::pattern::Pattern;
use super::symbolic::{Lists, Symbolic, cost};
use crate::graph::GraphError;

/// Subtrees for threads are cut so that none has more than this share of the work.
const SHARES: f64 = 24.0;
/// Less work than this, in multiplications, is not handed to a thread.
const SMALLEST_TASK: f64 = 2e5;
/// What a piece of a product costs beside its multiplications, and a number of an update that is written, read and added, in
/// multiplications. Measured: a third of the time of bundle adjustment; between 50 and 10⁹ pose graphs take the same to 1 %.
const PIECE: f64 = 150.0;
const EXTENSION: f64 = 12.0;

/// Where everything goes.
#[derive(Debug, Default)]
pub(super) struct Plan {
    pub(super) size: usize,
    pub(super) fronts: Vec<Front>,
    loads: Vec<Load>,
    runs: Vec<Run>,
    children: Vec<u32>,
    leaves: Vec<Leaves>,
    /// Subtrees that may be eliminated side by side, each a range of fronts that ends with its root.
    pub(super) tasks: Vec<Range<usize>>,
    /// Numbers in L.
    pub(super) factor_len: usize,
    pub(super) tallest: usize,
    /// Lengths of the panels, of the selected inverse, and of the two stacks.
    pub(super) panels: usize,
    pub(super) inverse: usize,
    pub(super) stacks: [usize; 2],
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
    leaves: (usize, usize),
    /// Whether its update is never formed: see [`Leaves`].
    pub(super) is_leaf: bool,
}

/// Fronts without children that follow each other, with the same rows below their pivots: their columns of L, side by side, go
/// straight into the parent. Points seen by a few cameras are such, and there this is the Schur complement.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaves {
    pub(super) first: u32,
    pub(super) count: u32,
    /// Pivots of all.
    pub(super) depth: usize,
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
    /// All its columns: those of the pivots, and those of the update.
    pub(super) fn columns<'a>(&self, panel: &'a mut [f64], update: &'a mut [f64]) -> [Columns<'a>; 2] {
        let panel = &mut panel[..self.stride() * self.pivots];
        let update = &mut update[..self.update_len()];
        let pivots = Columns { numbers: panel, stride: self.stride(), first: 0, pivots: self.pivots };
        [pivots, Columns { numbers: update, stride: self.update_stride(), first: 0, pivots: 0 }]
    }
}

/// A block of the matrix to be copied into the columns of its front.
#[derive(Clone, Copy, Debug)]
pub(super) struct Load {
    pub(super) from: u32,
    pub(super) to: u32,
    pub(super) rows: u32,
    pub(super) columns: u32,
}

impl Plan {
    /// # Errors
    /// [`GraphError::OutOfMemory`] beyond 2³² rows.
    pub(super) fn new(pattern: &Pattern) -> Result<Self, GraphError> {
        if u32::try_from(pattern.size()).is_err() {
            return Err(GraphError::OutOfMemory);
        }
        let symbolic = &pattern.symbolic;
        let starts = &pattern.starts;
        let count = symbolic.parents.len();
        let mut plan = Self { size: pattern.size(), ..Self::default() };
        for number in 0..count {
            let (first, end) = (symbolic.starts[number] as usize, symbolic.starts[number + 1] as usize);
            let below = symbolic.rows_of(number).iter().map(|&r| starts[r as usize + 1] - starts[r as usize]);
            let pivots = starts[end] - starts[first];
            let rows = pivots + below.sum::<usize>();
            plan.factor_len += (rows * pivots) - pivots * (pivots - 1) / 2;
            plan.tallest = plan.tallest.max(rows);
            plan.fronts.push(Front { start: starts[first], pivots, rows, ..Front::default() });
        }
        let parent_of = |number: u32| (symbolic.parents[number as usize], number);
        let children =
            Lists::new(count, (0..count as u32).map(parent_of).filter(|(p, _)| *p != Symbolic::ROOT));
        for number in 0..count {
            let range = symbolic.starts[number] as usize..symbolic.starts[number + 1] as usize;
            let (loads, runs) = (plan.loads.len(), plan.runs.len());
            plan.load_front(pattern, number, range);
            plan.map_rows(pattern, number);
            plan.fronts[number].loads = (loads, plan.loads.len());
            plan.fronts[number].runs = (runs, plan.runs.len());
        }
        plan.tasks = plan.cut(&symbolic.parents);
        plan.find_leaves(symbolic, &children);
        plan.place(symbolic, &children);
        Ok(plan)
    }

    /// The subtrees that are small enough while their parents' are not, where all is worth it.
    fn cut(&self, parents: &[u32]) -> Vec<Range<usize>> {
        let mut work: Vec<f64> = self.fronts.iter().map(|front| cost(front.pivots, front.rows)).collect();
        let mut sizes = vec![1; work.len()];
        let limit = work.iter().sum::<f64>() / SHARES;
        for number in 0..work.len() {
            if parents[number] != Symbolic::ROOT {
                work[parents[number] as usize] += work[number];
                sizes[parents[number] as usize] += sizes[number];
            }
        }
        let within = |number: u32| number != Symbolic::ROOT && work[number as usize] <= limit;
        (0..work.len())
            .filter(|&i| within(i as u32) && !within(parents[i]) && work[i] >= SMALLEST_TASK)
            .map(|i| i + 1 - sizes[i]..i + 1)
            .collect()
    }

    /// Decides whose updates are not formed: where a product with holes in it costs less than an update that is written and read
    /// once more.
    fn find_leaves(&mut self, symbolic: &Symbolic, children: &Lists) {
        for number in 0..self.fronts.len() {
            let front = &self.fronts[number];
            let pieces = (front.runs.1 - front.runs.0) as f64;
            let below = front.below() as f64;
            let pays = PIECE * pieces * pieces <= EXTENSION * below * below;
            let alone = children.of(number as u32).is_empty();
            let root = symbolic.parents[number] == Symbolic::ROOT;
            let of_task = self.tasks.iter().any(|task| task.end == number + 1);
            self.fronts[number].is_leaf = pays && alone && !root && !of_task;
        }
    }

    /// Lays out the panels and, as the factorisation will use them, the stacks.
    fn place(&mut self, symbolic: &Symbolic, children: &Lists) {
        let parents = &symbolic.parents;
        let mut stack_of = vec![0; parents.len()];
        for number in (0..parents.len()).rev() {
            if parents[number] != Symbolic::ROOT {
                stack_of[number] = 1 - stack_of[parents[number] as usize];
            }
        }
        let mut tops = [0; 2];
        let tasks: Vec<usize> = self.tasks.iter().map(|task| task.end).collect();
        let mut ends = tasks.into_iter().peekable();
        for (number, stack) in stack_of.into_iter().enumerate() {
            let (first, first_leaves) = (self.children.len(), self.leaves.len());
            for &child in children.of(number as u32) {
                let front = self.fronts[child as usize];
                if front.is_leaf {
                    self.join_leaf(child, symbolic, first_leaves);
                } else {
                    tops[front.stack] -= front.update_len();
                    self.children.push(child);
                }
            }
            if first_leaves < self.leaves.len() {
                self.panels += SLACK; // the columns before are read while these are written
            }
            let front = &mut self.fronts[number];
            front.children = (first, self.children.len());
            front.leaves = (first_leaves, self.leaves.len());
            front.stack = stack;
            front.update = tops[front.stack];
            let top = front.update + front.update_len();
            self.stacks[front.stack] = self.stacks[front.stack].max(top);
            tops[front.stack] = if front.is_leaf { front.update } else { top };
            (front.panel, front.inverse) = (self.panels, self.inverse);
            self.panels += front.stride() * front.pivots;
            self.inverse += front.rows * front.pivots;
            if ends.next_if_eq(&(number + 1)).is_some() {
                self.panels += SLACK; // the next front may be another thread's
            }
        }
    }

    /// Adds a leaf to those of its parent, of which the first is at `first`.
    fn join_leaf(&mut self, number: u32, symbolic: &Symbolic, first: usize) {
        let front = self.fronts[number as usize];
        let joins = |last: &&mut Leaves| {
            let before = &self.fronts[number as usize - 1];
            last.first + last.count == number
                && last.depth + front.pivots <= DEPTH
                && before.panel + before.stride() * before.pivots == front.panel
                && before.pivots == front.pivots
                && symbolic.rows_of(number as usize - 1) == symbolic.rows_of(number as usize)
        };
        match self.leaves[first..].last_mut().filter(joins) {
            Some(last) => (last.count, last.depth) = (last.count + 1, last.depth + front.pivots),
            None => self.leaves.push(Leaves { first: number, count: 1, depth: front.pivots }),
        }
    }

    /// Finds the blocks of the pivots' columns in their front.
    fn load_front(&mut self, pattern: &Pattern, number: usize, range: Range<usize>) {
        let (starts, end) = (&pattern.starts, range.end);
        let (front, rows) = (self.fronts[number], pattern.symbolic.rows_of(number));
        for column in range {
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
        if symbolic.parents[number] == Symbolic::ROOT {
            return;
        }
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

    pub(super) fn leaves_of(&self, front: &Front) -> &[Leaves] {
        &self.leaves[front.leaves.0..front.leaves.1]
    }

    pub(super) fn runs_of(&self, front: &Front) -> &[Run] {
        &self.runs[front.runs.0..front.runs.1]
    }

    pub(super) fn loads_of(&self, front: &Front) -> &[Load] {
        &self.loads[front.loads.0..front.loads.1]
    }
}
