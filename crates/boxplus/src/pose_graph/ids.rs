//! Ids as indices, and which of them hang together.

/// A set of ids in increasing order; each has an index.
pub(super) struct Ids(Vec<u64>);

impl Ids {
    /// The set of `ids`, which may come in any order and repeat.
    pub(super) fn new(ids: impl Iterator<Item = u64>) -> Self {
        let mut ids: Vec<u64> = ids.collect();
        ids.sort_unstable();
        ids.dedup();
        Self(ids)
    }

    /// How many.
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// In increasing order.
    pub(super) fn as_slice(&self) -> &[u64] {
        &self.0
    }

    /// The index of `id`.
    pub(super) fn index(&self, id: u64) -> Option<usize> {
        // Without gaps the index is the distance from the first.
        let guess = usize::try_from(id.wrapping_sub(*self.0.first()?)).ok();
        guess.filter(|&i| self.0.get(i) == Some(&id)).or_else(|| self.0.binary_search(&id).ok())
    }
}

/// A partition of 0…n−1 that only grows coarser (union by size, paths halved).
pub(super) struct Partition {
    parent: Vec<usize>,
    size: Vec<usize>,
}

impl Partition {
    /// Every index alone.
    pub(super) fn new(n: usize) -> Self {
        Self { parent: (0..n).collect(), size: vec![1; n] }
    }

    /// The representative of the part that holds `i`.
    pub(super) fn find(&mut self, mut i: usize) -> usize {
        while self.parent[i] != i {
            self.parent[i] = self.parent[self.parent[i]];
            i = self.parent[i];
        }
        i
    }

    /// Merges the parts of `i` and `j`.
    pub(super) fn join(&mut self, i: usize, j: usize) {
        let (i, j) = (self.find(i), self.find(j));
        if i != j {
            let (small, large) = if self.size[i] < self.size[j] { (i, j) } else { (j, i) };
            self.parent[small] = large;
            self.size[large] += self.size[small];
        }
    }

    /// The size of every part, at its representative: `(representative, size)`.
    pub(super) fn parts(&self) -> impl Iterator<Item = (usize, usize)> {
        self.parent.iter().enumerate().filter(|(i, p)| i == *p).map(|(i, _)| (i, self.size[i]))
    }
}
