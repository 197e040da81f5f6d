//! Poses by chaining measurements along a breadth-first tree.

use std::collections::VecDeque;

use super::edges::{Edge, Pose, priors};
use crate::graph::set::AnySet;
use crate::graph::{FactorId, Key, Values};
use crate::lie::LieGroup;

/// Chains the measurements from every held pose; a part without one starts from its surest prior, else from its first pose.
/// Returns, by slot, the poses it started from.
///
/// # Errors
/// The factor whose measurement is not finite.
pub(crate) fn walk<P: Pose<N, D>, const N: usize, const D: usize>(
    sets: &[Box<dyn AnySet>],
    edges: &[Edge<P, D>],
    values: &mut Values,
) -> Result<Vec<bool>, FactorId> {
    if let Some(edge) = edges.iter().find(|edge| !edge.measured.is_finite()) {
        return Err(edge.factor);
    }
    let count = values.len::<P>();
    let neighbours = Neighbours::new(edges, count);
    let mut tree =
        Tree { poses: values.slice::<P>().to_vec(), source: vec![false; count], reached: vec![false; count] };

    let held = (0..count).filter(|&slot| values.is_held(Key::<P>::new(slot as u32)));
    tree.grow(held.collect(), edges, &neighbours);
    for (slot, mean) in priors::<P, D>(sets) {
        if !tree.reached[slot as usize] {
            tree.poses[slot as usize] = Some(mean);
            tree.grow(vec![slot as usize], edges, &neighbours);
        }
    }
    for slot in (0..count).filter(|&slot| neighbours.has(slot)) {
        if !tree.reached[slot] {
            tree.grow(vec![slot], edges, &neighbours);
        }
    }
    for (slot, pose) in tree.poses.into_iter().enumerate() {
        if let Some(pose) = pose.filter(|_| tree.reached[slot]) {
            let _ = values.set(Key::<P>::new(slot as u32), pose); // the slot exists
        }
    }
    Ok(tree.source)
}

/// What has been reached so far, by slot.
struct Tree<P> {
    poses: Vec<Option<P>>,
    source: Vec<bool>,
    reached: Vec<bool>,
}

impl<P: Copy> Tree<P> {
    /// Breadth first from `roots`.
    fn grow<const D: usize>(&mut self, roots: Vec<usize>, edges: &[Edge<P, D>], neighbours: &Neighbours)
    where
        P: LieGroup<D>,
    {
        roots.iter().for_each(|&root| (self.source[root], self.reached[root]) = (true, true));
        let mut queue = VecDeque::from(roots);
        while let Some(at) = queue.pop_front() {
            let here = *self.poses[at].get_or_insert_with(P::identity);
            for (next, edge, forward) in neighbours.of(edges, at) {
                if !self.reached[next] {
                    self.reached[next] = true;
                    let step = if forward { edge.measured } else { edge.measured.inverse() };
                    self.poses[next] = Some(here.compose(&step));
                    queue.push_back(next);
                }
            }
        }
    }
}

/// The edges at each pose.
struct Neighbours {
    starts: Vec<usize>,
    edges: Vec<usize>,
}

impl Neighbours {
    fn new<P, const D: usize>(edges: &[Edge<P, D>], count: usize) -> Self {
        let mut starts = vec![0; count + 1];
        for edge in edges {
            starts[edge.from as usize + 1] += 1;
            starts[edge.to as usize + 1] += 1;
        }
        (0..count).for_each(|i| starts[i + 1] += starts[i]);
        let mut next = starts.clone();
        let mut sorted = vec![0; 2 * edges.len()];
        for (i, edge) in edges.iter().enumerate() {
            for end in [edge.from, edge.to] {
                sorted[next[end as usize]] = i;
                next[end as usize] += 1;
            }
        }
        Self { starts, edges: sorted }
    }

    fn has(&self, at: usize) -> bool {
        self.starts[at] < self.starts[at + 1]
    }

    /// Each neighbour, the edge to it, and whether that leads away from `at`.
    fn of<'a, P, const D: usize>(
        &'a self,
        edges: &'a [Edge<P, D>],
        at: usize,
    ) -> impl Iterator<Item = (usize, &'a Edge<P, D>, bool)> {
        self.edges[self.starts[at]..self.starts[at + 1]].iter().map(move |&i| {
            let edge = &edges[i];
            let forward = edge.from as usize == at;
            (if forward { edge.to } else { edge.from } as usize, edge, forward)
        })
    }
}
