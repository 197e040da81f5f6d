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
