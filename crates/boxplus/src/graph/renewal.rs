//! Factors that were linearised about the value of a variable, and what became of them.

use super::noise::Noise;

/// What a factor becomes about another value of the variables it was linearised about; see
/// [`Factor::renewed`](super::Factor::renewed).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Renewed<F, const R: usize> {
    /// The same measurement about the new value.
    pub factor: F,
    /// Its noise.
    pub noise: Noise<R>,
    /// How far off the old one was there, in standard deviations.
    pub error: f64,
}

/// What [`Graph::renew`](super::Graph::renew) did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Renewal {
    /// How many factors were linearised anew.
    pub factors: usize,
    /// The largest error of an old one, in standard deviations of its noise: what their linearisation cost the estimate at most, where
    /// single factors decide.
    pub largest: f64,
}

impl Renewal {
    /// Both together.
    pub(super) fn and(self, other: Self) -> Self {
        Self { factors: self.factors + other.factors, largest: self.largest.max(other.largest) }
    }
}
