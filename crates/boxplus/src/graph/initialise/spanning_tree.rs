//! Poses by chaining measurements along a breadth-first tree.

use std::collections::VecDeque;

use super::edges::{Edge, Pose, priors};
use crate::graph::factor::AnySet;
use crate::graph::{Key, Values};

/// Chains the measurements from every pose that is held or has a prior; a part without either starts from its first
/// pose. Returns, by slot, the poses it started from.
pub(crate) fn walk<P: Pose<N, D>, const N: usize, const D: usize>(
    sets: &[Box<dyn AnySet>],
    values: &mut Values,
) -> Vec<bool> {
    let edges = P::edges(sets);
    let count = values.len::<P>();
    let neighbours = Neighbours::new(&edges, count);
    let mut poses: Vec<Option<P>> = values.slice::<P>().to_vec();
    let mut source = vec![false; count];
    let mut queue = VecDeque::new();
    for (slot, mean) in priors::<P, D>(sets) {
        if !source[slot as usize] && !values.is_held(Key::<P>::new(slot)) {
            poses[slot as usize] = Some(mean);
        }
        source[slot as usize] = true;
    }
    (0..count)
        .filter(|&slot| values.is_held(Key::<P>::new(slot as u32)))
        .for_each(|slot| source[slot] = true);

    queue.extend((0..count).filter(|&slot| source[slot]));
    let mut reached = source.clone();
    for first in 0..=count {
        while let Some(at) = queue.pop_front() {
            let here = *poses[at].get_or_insert_with(P::identity);
            for (next, edge, forward) in neighbours.of(&edges, at) {
                if !reached[next] {
                    reached[next] = true;
                    let step = if forward { edge.measured } else { edge.measured.inverse() };
                    poses[next] = Some(here.compose(&step));
                    queue.push_back(next);
                }
            }
        }
        if first < count && !reached[first] && neighbours.has(first) {
            (source[first], reached[first]) = (true, true);
            queue.push_back(first);
        }
    }
    for (slot, pose) in poses.into_iter().enumerate() {
        if let Some(pose) = pose.filter(|_| reached[slot]) {
            let _ = values.set(Key::<P>::new(slot as u32), pose); // the slot exists
        }
    }
    source
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
