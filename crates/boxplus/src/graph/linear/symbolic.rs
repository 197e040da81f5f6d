//! What a factorisation does, worked out from the pattern alone: which columns go together, and in what order.
//!
//! Column j of L has the rows of column j of the matrix and those of its children in the *elimination tree*, where the parent
//! of a column is its first row below the diagonal (Liu 1990). Columns whose rows agree but for the pivots between them form
//! a *supernode*, eliminated together as one dense front. In pose graphs these hold one or two variables each, too few to
//! keep the arithmetic busy, so that a supernode is merged into its parent where the zeros it brings cost less than the
//! front it saves (Ashcraft & Grimes 1989); the cost model was measured ([`cost`]).

use core::cmp::Ordering;

use super::dissection::separators;
use super::ordering::minimum_degree;

/// No column.
const NONE: u32 = u32::MAX;

/// Supernodes of a matrix in postorder, and the order of elimination they give.
#[derive(Clone, Debug, Default)]
pub(crate) struct Symbolic {
    /// Variables in the order of elimination, supernode by supernode.
    pub(crate) order: Vec<u32>,
    /// First variable of each supernode in that order, and the end.
    pub(crate) starts: Vec<u32>,
    /// Parent of each supernode; [`Self::ROOT`] has none.
    pub(crate) parents: Vec<u32>,
    /// Start of the rows of each supernode in `rows`, and the end.
    pub(crate) row_starts: Vec<u32>,
    /// Variables below the pivots of each supernode, ascending, by their places in the order.
    pub(crate) rows: Vec<u32>,
    /// Time of a factorisation, in multiplications ([`cost`]).
    pub(crate) work: f64,
}

impl Symbolic {
    /// The parent of a root.
    pub(crate) const ROOT: u32 = NONE;

    /// Analyses a matrix of variables with these dimensions and blocks at `pairs`.
    pub(crate) fn new(dims: &[usize], pairs: &[(u32, u32)]) -> Self {
        let by_degree = Self::in_order(dims, pairs, &minimum_degree(dims, pairs, &[]));
        if by_degree.work < DISSECTED * dims.len() as f64 {
            return by_degree;
        }
        let separators = separators(dims, pairs);
        let dissected = Self::in_order(dims, pairs, &minimum_degree(dims, pairs, &separators));
        if dissected.work < by_degree.work { dissected } else { by_degree }
    }

    /// Analyses the matrix for this order of elimination, or one with as much fill.
    pub(super) fn in_order(dims: &[usize], pairs: &[(u32, u32)], order: &[u32]) -> Self {
        let columns = Columns::new(dims, order, pairs);
        let mut tree = Supernodes::new(&columns);
        tree.amalgamate();
        tree.emit(order)
    }

    /// Rows below the pivots of a supernode.
    pub(crate) fn rows_of(&self, number: usize) -> &[u32] {
        &self.rows[self.row_starts[number] as usize..self.row_starts[number + 1] as usize]
    }
}

/// Time that a front of `k` pivots and `m` rows takes, in multiplications: its own, and what it does beside them. Measured
/// ([`super::tests`]); between half and twice these numbers, times differ little.
pub(super) fn cost(k: usize, m: usize) -> f64 {
    let (k, m) = (k as f64, m as f64);
    let below = m - k;
    let work = k * (below * below + below * k + k * k / 3.0);
    COST[0] + COST[1] * k * m + COST[2] * below * below + work
}

/// Where minimum degree leaves less work than this for each variable, in multiplications, no separator is small enough to be worth
/// the search: planar graphs stay below, lattices in space do not from some 18³ on.
const DISSECTED: f64 = 5e6;

/// Overhead of a front, of an entry in its columns, of an entry passed to its parent, in units of a multiplication.
const COST: [f64; 3] = [2000.0, 8.0, 12.0];

/// The lower triangle by columns and by rows, in the order of elimination.
struct Columns {
    dims: Vec<usize>,
    /// Rows of column j below the diagonal.
    below: Lists,
    /// Columns of row i before the diagonal.
    before: Lists,
}

/// Lists of numbers, one after the other.
pub(super) struct Lists {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Lists {
    /// From (list, item) pairs.
    pub(super) fn new(count: usize, pairs: impl Iterator<Item = (u32, u32)> + Clone) -> Self {
        let mut starts = vec![0; count + 1];
        pairs.clone().for_each(|(list, _)| starts[list as usize + 1] += 1);
        (0..count).for_each(|i| starts[i + 1] += starts[i]);
        let mut next = starts.clone();
        let mut items = vec![0; starts[count] as usize];
        for (list, item) in pairs {
            items[next[list as usize] as usize] = item;
            next[list as usize] += 1;
        }
        Self { starts, items }
    }

    /// Sorts every list.
    fn sort_by(&mut self, order: impl Fn(&u32, &u32) -> Ordering) {
        for ends in self.starts.windows(2) {
            self.items[ends[0] as usize..ends[1] as usize].sort_by(&order);
        }
    }

    pub(super) fn of(&self, list: u32) -> &[u32] {
        &self.items[self.starts[list as usize] as usize..self.starts[list as usize + 1] as usize]
    }
}

impl Columns {
    fn new(dims: &[usize], order: &[u32], pairs: &[(u32, u32)]) -> Self {
        let mut place = vec![0; order.len()];
        (0u32..).zip(order).for_each(|(i, &variable)| place[variable as usize] = i);
        let placed = pairs.iter().filter(|(a, b)| a != b).map(|&(a, b)| {
            let (a, b): (u32, u32) = (place[a as usize], place[b as usize]);
            (a.min(b), a.max(b))
        });
        Self {
            dims: order.iter().map(|&variable| dims[variable as usize]).collect(),
            below: Lists::new(order.len(), placed.clone()),
            before: Lists::new(order.len(), placed.map(|(column, row)| (row, column))),
        }
    }

    /// The parent of each column in the elimination tree, by ancestors with compressed paths. Liu (1990), algorithm 4.2.
    fn elimination_tree(&self) -> Vec<u32> {
        let count = self.dims.len() as u32;
        let (mut parents, mut ancestors) = (vec![NONE; count as usize], vec![NONE; count as usize]);
        for row in 0..count {
            for &column in self.before.of(row) {
                let mut at = column as usize;
                while ancestors[at] != row {
                    match core::mem::replace(&mut ancestors[at], row) {
                        NONE => {
                            parents[at] = row;
                            break;
                        }
                        up => at = up as usize,
                    }
                }
            }
        }
        parents
    }
}

/// Supernodes under construction, by the order of their first columns.
struct Supernodes {
    nodes: Vec<Supernode>,
    /// Rows of all, in the order of elimination of the analysis; each list also holds later pivots of its supernode.
    rows: Vec<u32>,
    /// The next column of the same supernode.
    next: Vec<u32>,
}

#[derive(Clone)]
struct Supernode {
    first: u32,
    last: u32,
    /// Supernode into which it was merged, or that of its parent; itself for a root.
    parent: u32,
    merged: bool,
    /// Scalars of its pivots, and of the rows below them.
    pivots: usize,
    below: usize,
    rows: (usize, usize),
}

impl Supernodes {
    /// Fundamental supernodes: column by column, each takes the rows of its children.
    fn new(columns: &Columns) -> Self {
        let count = columns.dims.len();
        let parents = columns.elimination_tree();
        let children = Lists::new(
            count,
            (0u32..).zip(&parents).filter(|&(_, &p)| p != NONE).map(|(child, &p)| (p, child)),
        );
        let mut tree = Self { nodes: vec![], rows: vec![], next: vec![NONE; count] };
        let mut node_of = vec![0u32; count];
        let mut marks = vec![NONE; count];
        for column in 0..count as u32 {
            let begin = tree.rows.len();
            let mut below = 0;
            marks[column as usize] = column;
            let mut take = |rows: &mut Vec<u32>, row: u32| {
                if row > column && marks[row as usize] != column {
                    marks[row as usize] = column;
                    below += columns.dims[row as usize];
                    rows.push(row);
                }
            };
            columns.below.of(column).iter().for_each(|&row| take(&mut tree.rows, row));
            let dim = columns.dims[column as usize];
            let mut same = None;
            for &child in children.of(column) {
                let node = &tree.nodes[node_of[child as usize] as usize];
                for k in node.rows.0..node.rows.1 {
                    let row = tree.rows[k];
                    take(&mut tree.rows, row);
                }
            }
            for &child in children.of(column) {
                let number = node_of[child as usize];
                if tree.nodes[number as usize].below == below + dim {
                    same = Some(number);
                }
            }
            let number = if let Some(number) = same {
                tree.rows.truncate(begin);
                let node = &mut tree.nodes[number as usize];
                tree.next[node.last as usize] = column;
                node.last = column;
                node.pivots += dim;
                node.below = below;
                number
            } else {
                tree.nodes.push(Supernode {
                    first: column,
                    last: column,
                    parent: tree.nodes.len() as u32,
                    merged: false,
                    pivots: dim,
                    below,
                    rows: (begin, tree.rows.len()),
                });
                tree.nodes.len() as u32 - 1
            };
            node_of[column as usize] = number;
            for &child in children.of(column) {
                let child = node_of[child as usize];
                if child != number {
                    tree.nodes[child as usize].parent = number;
                }
            }
        }
        tree
    }

    /// Merges supernodes into their parents where that costs less, from the leaves up.
    fn amalgamate(&mut self) {
        let order = self.by_last();
        let children = Lists::new(
            self.nodes.len(),
            order.iter().map(|&i| (self.nodes[i as usize].parent, i)).filter(|(parent, i)| parent != i),
        );
        let mut candidates: Vec<u32> = vec![];
        for &number in &order {
            candidates.clear();
            candidates.extend(children.of(number));
            // Those with the most rows bring the fewest zeros.
            candidates.sort_by_key(|&i| core::cmp::Reverse(self.nodes[i as usize].below));
            for &child in &candidates {
                let (c, p) = (&self.nodes[child as usize], &self.nodes[number as usize]);
                let apart = cost(c.pivots, c.pivots + c.below) + cost(p.pivots, p.pivots + p.below);
                let together = cost(c.pivots + p.pivots, c.pivots + p.pivots + p.below);
                if together <= apart {
                    let pivots = c.pivots;
                    self.nodes[number as usize].pivots += pivots;
                    self.nodes[child as usize].merged = true;
                }
            }
        }
    }

    /// Supernodes by their last columns: children before parents.
    fn by_last(&self) -> Vec<u32> {
        let mut ending = vec![NONE; self.next.len()];
        (0u32..).zip(&self.nodes).for_each(|(i, node)| ending[node.last as usize] = i);
        ending.retain(|&node| node != NONE);
        ending
    }

    /// The supernode that a supernode is part of in the end.
    fn representative(&self, mut number: u32) -> u32 {
        while self.nodes[number as usize].merged {
            number = self.nodes[number as usize].parent;
        }
        number
    }

    /// Numbers everything anew, in postorder.
    fn emit(mut self, order: &[u32]) -> Symbolic {
        let count = self.nodes.len();
        for node in &self.nodes {
            self.rows[node.rows.0..node.rows.1].sort_unstable();
        }
        let by_last = self.by_last();
        let representatives: Vec<u32> = (0..count as u32).map(|i| self.representative(i)).collect();
        let parts = Lists::new(count, by_last.iter().map(|&i| (representatives[i as usize], i)));
        let whole = |i: &u32| !self.nodes[*i as usize].merged;
        let parent_of = |i: u32| match self.nodes[i as usize].parent {
            parent if parent == i => NONE,
            parent => representatives[parent as usize],
        };
        let mut children = Lists::new(
            count,
            by_last.iter().copied().filter(whole).map(|i| (parent_of(i), i)).filter(|&(p, _)| p != NONE),
        );
        // Leaves first, those with the same rows together.
        let is_leaf: Vec<bool> = (0..count as u32).map(|i| children.of(i).is_empty()).collect();
        let rows = |i: u32| {
            let node = &self.nodes[i as usize];
            let rows = &self.rows[node.rows.0..node.rows.1];
            is_leaf[i as usize].then(|| &rows[rows.partition_point(|&row| row <= node.last)..])
        };
        children
            .sort_by(|&a, &b| rows(b).is_some().cmp(&rows(a).is_some()).then_with(|| rows(a).cmp(&rows(b))));
        let roots = by_last.iter().copied().filter(whole).filter(|&i| parent_of(i) == NONE);

        let postorder = postorder(roots, &children);
        let whole_nodes = self.nodes.iter().filter(|node| !node.merged);
        let work = whole_nodes.map(|node| cost(node.pivots, node.pivots + node.below)).sum();
        let mut symbolic = Symbolic { work, ..Symbolic::default() };
        let mut number_of = vec![NONE; count];
        let mut places = vec![0u32; order.len()];
        for (number, &node) in (0u32..).zip(&postorder) {
            number_of[node as usize] = number;
            symbolic.starts.push(symbolic.order.len() as u32);
            for &part in parts.of(node) {
                let mut column = self.nodes[part as usize].first;
                while column != NONE {
                    places[column as usize] = symbolic.order.len() as u32;
                    symbolic.order.push(order[column as usize]);
                    column = self.next[column as usize];
                }
            }
        }
        symbolic.starts.push(symbolic.order.len() as u32);
        for (number, &node) in postorder.iter().enumerate() {
            let begin = symbolic.rows.len();
            symbolic.row_starts.push(begin as u32);
            let (from, to) = self.nodes[node as usize].rows;
            let end = symbolic.starts[number + 1];
            symbolic
                .rows
                .extend(self.rows[from..to].iter().map(|&row| places[row as usize]).filter(|&p| p >= end));
            symbolic.rows[begin..].sort_unstable();
            let parent = parent_of(node);
            symbolic.parents.push(if parent == NONE { NONE } else { number_of[parent as usize] });
        }
        symbolic.row_starts.push(symbolic.rows.len() as u32);
        symbolic
    }
}

/// Children before parents, each subtree together.
fn postorder(roots: impl Iterator<Item = u32>, children: &Lists) -> Vec<u32> {
    let mut order = vec![];
    let mut stack: Vec<(u32, usize)> = vec![];
    for root in roots {
        stack.push((root, 0));
        while let Some((node, done)) = stack.last_mut() {
            if let Some(&child) = children.of(*node).get(*done) {
                *done += 1;
                stack.push((child, 0));
            } else {
                order.push(*node);
                stack.pop();
            }
        }
    }
    order
}
