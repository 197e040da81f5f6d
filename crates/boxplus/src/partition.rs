//! Which of n things hang together.

/// A partition of 0…n−1 that only grows coarser (union by size, paths halved).
pub(crate) struct Partition {
    parent: Vec<usize>,
    size: Vec<usize>,
}

impl Partition {
    /// Every index alone.
    pub(crate) fn new(n: usize) -> Self {
        Self { parent: (0..n).collect(), size: vec![1; n] }
    }

    /// The representative of the part that holds `i`.
    pub(crate) fn find(&mut self, mut i: usize) -> usize {
        while self.parent[i] != i {
            self.parent[i] = self.parent[self.parent[i]];
            i = self.parent[i];
        }
        i
    }

    /// Merges the parts of `i` and `j`.
    pub(crate) fn join(&mut self, i: usize, j: usize) {
        let (i, j) = (self.find(i), self.find(j));
        if i != j {
            let (small, large) = if self.size[i] < self.size[j] { (i, j) } else { (j, i) };
            self.parent[small] = large;
            self.size[large] += self.size[small];
        }
    }

    /// The size of every part, at its representative: `(representative, size)`.
    #[cfg(any(feature = "io", test))]
    pub(crate) fn parts(&self) -> impl Iterator<Item = (usize, usize)> {
        self.parent.iter().enumerate().filter(|(i, p)| i == *p).map(|(i, _)| (i, self.size[i]))
    }
}
