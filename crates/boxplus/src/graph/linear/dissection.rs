//! Nested dissection: a small set of variables that separates a graph into halves, and so on in the halves.
//!
//! Separators are eliminated after what they separate, so that nothing fills in across them: of n variables in the plane
//! the factor then holds O(n log n) numbers, in space O(n^(4/3)) (George 1973; Lipton, Rose & Tarjan 1979), where minimum
//! degree knows no such bound. Measured, it is as good in the plane up to 10⁵ variables, and worse in space from 10⁴ on: by a
//! quarter in a lattice of 24³, by two fifths in one of 40³. A separator is found on a coarse graph, of which each variable stands for a cluster, and made smaller on
//! every finer one (Karypis & Kumar 1998; Hendrickson & Rothberg 1998).

use std::collections::{BinaryHeap, VecDeque};

/// Parts of fewer variables than this are left to minimum degree.
pub(super) const LEAF: usize = 120;
/// Graphs of fewer variables are coarse enough.
const COARSE: usize = 100;
/// Starts tried on the coarsest graph.
const SEEDS: usize = 12;
/// Passes of refinement at each level, and moves in vain within one.
const PASSES: usize = 6;
const VAIN: usize = 120;
/// Neither side may weigh more than three of so many parts of the whole.
const FIFTHS: u32 = 5;
/// A separator of more than one in this many variables separates nothing.
const LARGEST_SEPARATOR: usize = 4;

/// Where a variable is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Side {
    Left,
    Right,
    Separator,
}

impl Side {
    fn other(self) -> Self {
        if self == Self::Left { Self::Right } else { Self::Left }
    }
}

/// The variables of all separators of a graph of variables with these dimensions, joined by `pairs` (each once, loops
/// ignored), in the order of elimination: outer separators after inner ones.
pub(super) fn separators(dims: &[usize], pairs: &[(u32, u32)]) -> Vec<u32> {
    let mut found = vec![];
    let mut parts = vec![(Mesh::new(dims, pairs), (0..dims.len() as u32).collect::<Vec<_>>())];
    while let Some((mesh, variables)) = parts.pop() {
        if mesh.len() <= LEAF {
            continue;
        }
        let sides = mesh.separate();
        let on = |side: Side| sides.iter().filter(move |&&s| s == side).count();
        if on(Side::Separator) * LARGEST_SEPARATOR > mesh.len() || on(Side::Left) * on(Side::Right) == 0 {
            continue;
        }
        let there =
            |side: Side| variables.iter().zip(&sides).filter(move |&(_, &s)| s == side).map(|(&v, _)| v);
        found.extend(there(Side::Separator));
        for side in [Side::Left, Side::Right] {
            parts.push((mesh.part(&sides, side), there(side).collect()));
        }
    }
    found.reverse();
    found
}

/// A graph with weights on its nodes and edges.
struct Mesh {
    starts: Vec<u32>,
    /// Neighbour and weight of each edge, from both of its ends.
    edges: Vec<(u32, u32)>,
    weights: Vec<u32>,
}

impl Mesh {
    fn new(dims: &[usize], pairs: &[(u32, u32)]) -> Self {
        let both = pairs.iter().filter(|(a, b)| a != b).flat_map(|&(a, b)| [(a, b), (b, a)]);
        let mut starts = vec![0; dims.len() + 1];
        both.clone().for_each(|(a, _)| starts[a as usize + 1] += 1);
        (0..dims.len()).for_each(|i| starts[i + 1] += starts[i]);
        let mut next = starts.clone();
        let mut edges = vec![(0, 1); starts[dims.len()] as usize];
        for (a, b) in both {
            edges[next[a as usize] as usize].0 = b;
            next[a as usize] += 1;
        }
        Self { starts, edges, weights: dims.iter().map(|&dim| dim as u32).collect() }
    }

    fn len(&self) -> usize {
        self.weights.len()
    }

    fn around(&self, node: u32) -> &[(u32, u32)] {
        &self.edges[self.starts[node as usize] as usize..self.starts[node as usize + 1] as usize]
    }

    /// The nodes of one side with the edges between them.
    fn part(&self, sides: &[Side], side: Side) -> Self {
        let mut numbers = vec![u32::MAX; self.len()];
        let here: Vec<u32> = (0..self.len() as u32).filter(|&node| sides[node as usize] == side).collect();
        here.iter().zip(0..).for_each(|(&node, number)| numbers[node as usize] = number);
        let mut part = Self { starts: vec![0], edges: vec![], weights: vec![] };
        for &node in &here {
            let kept = self.around(node).iter().filter(|(to, _)| sides[*to as usize] == side);
            part.edges.extend(kept.map(|&(to, weight)| (numbers[to as usize], weight)));
            part.starts.push(part.edges.len() as u32);
            part.weights.push(self.weights[node as usize]);
        }
        part
    }

    /// Each node's side of a small separator.
    fn separate(&self) -> Vec<Side> {
        match self.coarser() {
            Some((coarse, clusters)) => {
                let sides = coarse.separate();
                let mut split = Split::new(self, clusters.iter().map(|&c| sides[c as usize]).collect());
                split.refine();
                split.sides
            }
            None => self.grow(),
        }
    }

    /// The graph of pairs of nodes that the heaviest edges join, and each node's pair; `None` where it is coarse already.
    fn coarser(&self) -> Option<(Self, Vec<u32>)> {
        const NONE: u32 = u32::MAX;
        if self.len() <= COARSE {
            return None;
        }
        let mut order: Vec<u32> = (0..self.len() as u32).collect();
        order.sort_by_key(|&node| self.around(node).len());
        let mut clusters = vec![NONE; self.len()];
        let mut members: Vec<[u32; 2]> = vec![];
        for node in order {
            if clusters[node as usize] != NONE {
                continue;
            }
            // Of equally heavy edges the one to the lightest node, so that clusters grow evenly.
            let free = self.around(node).iter().filter(|(to, _)| clusters[*to as usize] == NONE);
            let best =
                free.max_by_key(|&&(to, weight)| (weight, core::cmp::Reverse(self.weights[to as usize])));
            let mate = best.map_or(node, |&(to, _)| to);
            clusters[node as usize] = members.len() as u32;
            clusters[mate as usize] = members.len() as u32;
            members.push([node, mate]);
        }
        if members.len() * 20 > self.len() * 19 {
            return None; // stars have few pairs
        }
        let mut coarse = Self { starts: vec![0], edges: vec![], weights: vec![] };
        let mut place = vec![NONE; members.len()];
        for (cluster, &[a, b]) in (0u32..).zip(&members) {
            let begin = coarse.edges.len();
            let nodes = if a == b { &[a][..] } else { &[a, b] };
            for &(to, weight) in nodes.iter().flat_map(|&node| self.around(node)) {
                let to = clusters[to as usize];
                match place[to as usize] {
                    _ if to == cluster => {}
                    at if at != NONE && at as usize >= begin => coarse.edges[at as usize].1 += weight,
                    _ => {
                        place[to as usize] = coarse.edges.len() as u32;
                        coarse.edges.push((to, weight));
                    }
                }
            }
            coarse.starts.push(coarse.edges.len() as u32);
            coarse.weights.push(nodes.iter().map(|&node| self.weights[node as usize]).sum());
        }
        Some((coarse, clusters))
    }

    /// The best of several separators around sides that grow, breadth first, from nodes far apart.
    fn grow(&self) -> Vec<Side> {
        let mut seed = 0;
        let mut best: Option<((u32, u32), Vec<Side>)> = None;
        for _ in 0..SEEDS {
            let order = self.breadth_first(seed);
            let half = self.weights.iter().sum::<u32>() / 2;
            let mut sides = vec![Side::Right; self.len()];
            let mut left = 0;
            for &node in &order {
                if left >= half {
                    break;
                }
                sides[node as usize] = Side::Left;
                left += self.weights[node as usize];
            }
            for node in 0..self.len() as u32 {
                let touches = || self.around(node).iter().any(|(to, _)| sides[*to as usize] == Side::Left);
                if sides[node as usize] == Side::Right && touches() {
                    sides[node as usize] = Side::Separator;
                }
            }
            let mut split = Split::new(self, sides);
            split.refine();
            let score = split.score();
            if best.as_ref().is_none_or(|(least, _)| score < *least) {
                best = Some((score, split.sides));
            }
            seed = order[order.len() - 1]; // far away from this one
            if best.as_ref().is_some_and(|(_, sides)| sides[seed as usize] == Side::Separator) {
                seed = order[order.len() / 2];
            }
        }
        best.map_or_else(Vec::new, |(_, sides)| sides)
    }

    /// All nodes, those of the part of `seed` first.
    fn breadth_first(&self, seed: u32) -> Vec<u32> {
        let mut seen = vec![false; self.len()];
        let mut order = Vec::with_capacity(self.len());
        for root in core::iter::once(seed).chain(0..self.len() as u32) {
            if core::mem::replace(&mut seen[root as usize], true) {
                continue;
            }
            let mut queue = VecDeque::from([root]);
            while let Some(node) = queue.pop_front() {
                order.push(node);
                for &(to, _) in self.around(node) {
                    if !core::mem::replace(&mut seen[to as usize], true) {
                        queue.push_back(to);
                    }
                }
            }
        }
        order
    }
}

/// Two sides with no edge between them, and the separator.
struct Split<'a> {
    mesh: &'a Mesh,
    sides: Vec<Side>,
    /// Weights of left, right, separator.
    weights: [u32; 3],
}

impl<'a> Split<'a> {
    fn new(mesh: &'a Mesh, sides: Vec<Side>) -> Self {
        let mut weights = [0; 3];
        sides.iter().zip(&mesh.weights).for_each(|(&side, weight)| weights[side as usize] += weight);
        Self { mesh, sides, weights }
    }

    /// Weight of the separator, then of the heavier side: less is better. A side beyond its limit is worse than any separator.
    fn score(&self) -> (u32, u32) {
        let heavier = self.weights[0].max(self.weights[1]);
        let excess = heavier.saturating_sub(self.limit());
        (self.weights[2] + 8 * excess, heavier)
    }

    fn limit(&self) -> u32 {
        self.weights.iter().sum::<u32>() / FIFTHS * 3
    }

    /// By how much the separator loses weight when this node leaves it for `side`: its own less that of the neighbours on
    /// the other side, which must come in.
    fn gain(&self, node: u32, side: Side) -> i64 {
        let pulled = self.mesh.around(node).iter().filter(|(to, _)| self.sides[*to as usize] == side.other());
        let weight = |node: u32| i64::from(self.mesh.weights[node as usize]);
        weight(node) - pulled.map(|&(to, _)| weight(to)).sum::<i64>()
    }

    fn set(&mut self, node: u32, side: Side) {
        let weight = self.mesh.weights[node as usize];
        self.weights[self.sides[node as usize] as usize] -= weight;
        self.weights[side as usize] += weight;
        self.sides[node as usize] = side;
    }

    /// Fiduccia & Mattheyses (1982) for separators: passes of moves, the best first, each node once, of which those up to
    /// the best state are kept.
    fn refine(&mut self) {
        for _ in 0..PASSES {
            let before = self.score();
            self.pass();
            if self.score() >= before {
                break;
            }
        }
    }

    fn pass(&mut self) {
        let mut heap = BinaryHeap::new();
        let nodes = (0..self.sides.len() as u32).filter(|&node| self.sides[node as usize] == Side::Separator);
        for node in nodes {
            let moves = [Side::Left, Side::Right].map(|side| (self.gain(node, side), node, side));
            heap.extend(moves);
        }
        let mut moved = vec![false; self.sides.len()];
        let mut log: Vec<(u32, Side)> = vec![]; // each change, with what was before
        let (mut best, mut kept, mut vain) = (self.score(), 0, 0);
        while let Some((gain, node, side)) = heap.pop() {
            if self.sides[node as usize] != Side::Separator || moved[node as usize] {
                continue;
            }
            let now = self.gain(node, side);
            if now < gain {
                heap.push((now, node, side));
                continue;
            }
            let heavier = self.weights[side as usize] + self.mesh.weights[node as usize];
            if heavier > self.limit() && self.weights[side as usize] >= self.weights[side.other() as usize] {
                continue;
            }
            moved[node as usize] = true;
            log.push((node, Side::Separator));
            self.set(node, side);
            let mesh = self.mesh;
            for &(pulled, _) in mesh.around(node) {
                if self.sides[pulled as usize] != side.other() {
                    continue;
                }
                log.push((pulled, side.other()));
                self.set(pulled, Side::Separator);
                let moves = [Side::Left, Side::Right].map(|side| (self.gain(pulled, side), pulled, side));
                heap.extend(moves);
                for &(near, _) in mesh.around(pulled) {
                    if self.sides[near as usize] == Side::Separator {
                        heap.push((self.gain(near, side), near, side));
                    }
                }
            }
            if self.score() < best {
                (best, kept, vain) = (self.score(), log.len(), 0);
            } else {
                vain += 1;
                if vain > VAIN {
                    break;
                }
            }
        }
        for &(node, side) in log[kept..].iter().rev() {
            self.set(node, side);
        }
    }
}
