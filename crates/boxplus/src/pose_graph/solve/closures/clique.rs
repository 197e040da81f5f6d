//! A largest set of mutually consistent things: the maximum clique of a graph.
//!
//! Greedy first, from every vertex, in an order that puts the best connected last; then branch and bound, where a colouring of
//! the candidates says how much a branch can still give: of each colour a clique has one vertex at most. Tomita & Seki (2003),
//! on sets of bits as San Segundo et al. (2011). Effort is counted, not timed: the same graph gives the same clique.

/// An undirected graph on 0…n−1.
pub(super) struct Consistency {
    rows: Vec<Bits>,
}

/// A clique, and whether no larger one exists.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Clique {
    /// In increasing order.
    pub(super) members: Vec<usize>,
    /// Whether the search came to its end.
    pub(super) is_largest: bool,
}

impl Consistency {
    /// Without edges.
    pub(super) fn new(count: usize) -> Self {
        Self { rows: vec![Bits::none(count); count] }
    }

    /// Joins two different vertices.
    pub(super) fn join(&mut self, a: usize, b: usize) {
        self.rows[a].insert(b);
        self.rows[b].insert(a);
    }

    /// The maximum clique, or the largest found after colouring `effort` candidates.
    pub(super) fn clique(&self, effort: usize) -> Clique {
        // Vertices are renamed so that those that are hard to place come first: colours then run out early.
        let order = self.degeneracy_order();
        let mut name = vec![0; order.len()];
        order.iter().enumerate().for_each(|(new, &old)| name[old] = new);
        let renamed = |&old: &usize| {
            let mut row = Bits::none(order.len());
            self.rows[old].iter().for_each(|other| row.insert(name[other]));
            row
        };
        let rows: Vec<Bits> = order.iter().map(renamed).collect();
        let mut search = Search { best: greedy(&rows), rows, path: vec![], effort };
        let is_largest = search.run();
        let mut members: Vec<usize> = search.best.iter().map(|&new| order[new]).collect();
        members.sort_unstable();
        Clique { members, is_largest }
    }

    /// Vertices by degree, the highest first, where a vertex of least degree is taken away again and again from the end. Matula &
    /// Beck (1983).
    fn degeneracy_order(&self) -> Vec<usize> {
        let count = self.rows.len();
        let mut degree: Vec<usize> = self.rows.iter().map(|row| row.iter().count()).collect();
        let mut left: Vec<bool> = vec![true; count];
        let mut order = Vec::with_capacity(count);
        while let Some(least) = (0..count).filter(|&v| left[v]).min_by_key(|&v| degree[v]) {
            left[least] = false;
            order.push(least);
            self.rows[least].iter().for_each(|other| degree[other] = degree[other].saturating_sub(1));
        }
        order.reverse();
        order
    }
}

/// The largest clique among those that begin with each vertex and take, again and again, the first candidate left.
fn greedy(rows: &[Bits]) -> Vec<usize> {
    let mut best = vec![];
    for first in 0..rows.len() {
        let (mut clique, mut candidates) = (vec![first], rows[first].clone());
        while let Some(next) = candidates.first() {
            clique.push(next);
            candidates.keep(&rows[next]);
        }
        if clique.len() > best.len() {
            best = clique;
        }
    }
    best
}

struct Search {
    rows: Vec<Bits>,
    best: Vec<usize>,
    /// The clique of the branch.
    path: Vec<usize>,
    effort: usize,
}

/// The candidates of a branch in the order of their colours: each with the size of the clique it can give at most.
struct Branch {
    candidates: Bits,
    coloured: Vec<(usize, usize)>,
}

impl Search {
    /// Whether every branch was gone through.
    fn run(&mut self) -> bool {
        let mut all = Bits::none(self.rows.len());
        (0..self.rows.len()).for_each(|v| all.insert(v));
        let Some(root) = self.branch(all) else { return false };
        let mut branches = vec![root];
        while let Some(branch) = branches.last_mut() {
            match branch.coloured.pop() {
                Some((vertex, colours)) if self.path.len() + colours > self.best.len() => {
                    branch.candidates.remove(vertex);
                    let mut candidates = branch.candidates.clone();
                    candidates.keep(&self.rows[vertex]);
                    self.path.push(vertex);
                    if self.path.len() > self.best.len() {
                        self.best.clone_from(&self.path);
                    }
                    let Some(next) = self.branch(candidates) else { return false };
                    branches.push(next);
                }
                _ => {
                    // Those left have no more colours.
                    branches.pop();
                    self.path.pop();
                }
            }
        }
        true
    }

    /// Colours candidates: no two of one colour are joined. `None` where the effort is spent.
    fn branch(&mut self, candidates: Bits) -> Option<Branch> {
        let (mut left, mut coloured, mut colour) = (candidates.clone(), vec![], 0);
        while left.first().is_some() {
            colour += 1;
            let mut free = left.clone();
            while let Some(vertex) = free.first() {
                free.drop(&self.rows[vertex]);
                free.remove(vertex);
                left.remove(vertex);
                coloured.push((vertex, colour));
                self.effort = self.effort.checked_sub(1)?;
            }
        }
        Some(Branch { candidates, coloured })
    }
}

/// A set of small numbers.
#[derive(Clone, Debug)]
struct Bits(Vec<u64>);

impl Bits {
    fn none(count: usize) -> Self {
        Self(vec![0; count.div_ceil(64)])
    }
    fn insert(&mut self, i: usize) {
        self.0[i / 64] |= 1 << (i % 64);
    }
    fn remove(&mut self, i: usize) {
        self.0[i / 64] &= !(1 << (i % 64));
    }
    /// Keeps what is in `other` too.
    fn keep(&mut self, other: &Self) {
        self.0.iter_mut().zip(&other.0).for_each(|(a, b)| *a &= b);
    }
    /// Drops what is in `other`.
    fn drop(&mut self, other: &Self) {
        self.0.iter_mut().zip(&other.0).for_each(|(a, b)| *a &= !b);
    }
    fn first(&self) -> Option<usize> {
        let word = self.0.iter().position(|&word| word != 0)?;
        Some(64 * word + self.0[word].trailing_zeros() as usize)
    }
    fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        self.0
            .iter()
            .enumerate()
            .flat_map(|(word, &bits)| (0..64).filter(move |i| bits >> i & 1 == 1).map(move |i| 64 * word + i))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn random(count: usize, density: f64, seed: u64) -> Consistency {
        let (mut graph, mut rng) = (Consistency::new(count), ChaCha8Rng::seed_from_u64(seed));
        for (a, b) in (0..count).flat_map(|b| (0..b).map(move |a| (a, b))) {
            if rng.random_bool(density) {
                graph.join(a, b);
            }
        }
        graph
    }

    fn is_clique(graph: &Consistency, members: &[usize]) -> bool {
        members.iter().all(|&a| members.iter().all(|&b| a == b || graph.rows[a].iter().any(|c| c == b)))
    }

    #[test]
    fn the_clique_is_as_large_as_that_of_trying_every_subset() {
        for seed in 0..40 {
            let density = [0.2, 0.5, 0.8, 0.95][seed as usize % 4];
            let graph = random(15, density, seed);
            let subset = |set: u32| (0..15).filter(move |i| set >> i & 1 == 1).collect::<Vec<usize>>();
            let largest =
                (0..1 << 15).filter(|&set| is_clique(&graph, &subset(set))).map(u32::count_ones).max();
            let found = graph.clique(1_000_000);
            assert!(found.is_largest && is_clique(&graph, &found.members), "{seed}");
            assert_eq!(Some(found.members.len() as u32), largest, "{seed}");
        }
    }

    #[test]
    fn without_effort_there_is_still_a_clique_and_it_is_not_called_the_largest() {
        let graph = random(200, 0.9, 7);
        let (hasty, thorough) = (graph.clique(0), graph.clique(200_000));
        assert!(!hasty.is_largest && is_clique(&graph, &hasty.members));
        assert!(is_clique(&graph, &thorough.members) && hasty.members.len() <= thorough.members.len());
        assert_eq!(graph.clique(200_000), thorough);
    }

    #[test]
    fn a_planted_clique_is_found_among_many_chance_ones() {
        let mut graph = random(300, 0.3, 3);
        for (a, b) in (0..40).flat_map(|b| (0..b).map(move |a| (a, b))) {
            graph.join(7 * a, 7 * b);
        }
        let found = graph.clique(10_000_000);
        assert!(found.is_largest);
        assert_eq!(found.members, (0..40).map(|k| 7 * k).collect::<Vec<_>>());
    }

    #[test]
    fn nothing_has_an_empty_clique_and_strangers_have_one_of_one() {
        assert_eq!(Consistency::new(0).clique(10), Clique { members: vec![], is_largest: true });
        assert_eq!(Consistency::new(5).clique(10).members.len(), 1);
    }
}
