//! What a front gives its parent: an update that was formed, or a product that need not be.

use super::{Matrix, Product, Simd, WithSimd, strips};

/// Rows of an update that stay together in the front of the parent, and in the matrix.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    /// First row in the update.
    pub(crate) from: u32,
    /// First row in the front of the parent: of its pivots, or counted from their end.
    pub(crate) to: u32,
    pub(crate) len: u32,
    /// Whether they are pivots of the parent.
    pub(crate) pivots: bool,
    /// First row in the matrix.
    pub(crate) scalar: u32,
}

impl Run {
    /// Its first row in columns of the parent in which so many rows of pivots are stored.
    fn row(&self, pivots: usize) -> usize {
        self.to as usize + if self.pivots { 0 } else { pivots }
    }
}

/// Columns of the parent that follow each other, among its pivots or among the others. The last row is the right-hand side.
pub(crate) struct Columns<'a> {
    pub(crate) numbers: &'a mut [f64],
    pub(crate) stride: usize,
    /// The first of them, as runs count.
    pub(crate) first: usize,
    /// How many rows of pivots they have: all in columns of pivots, none in the others.
    pub(crate) pivots: usize,
}

impl<'a> Columns<'a> {
    /// The same columns, to be written for a while.
    pub(crate) fn reborrow(&mut self) -> Columns<'_> {
        Columns { numbers: self.numbers, ..*self }
    }

    /// The columns cut into strips.
    pub(crate) fn strips(self, width: usize) -> Vec<Columns<'a>> {
        let Self { numbers, stride, first, pivots } = self;
        let strips = numbers.chunks_mut(width * stride).zip((first..).step_by(width));
        strips.map(|(numbers, first)| Columns { numbers, stride, first, pivots }).collect()
    }

    /// The part of a run that lies in these columns: its first row within the run, and how many.
    fn part(&self, run: &Run) -> (usize, usize) {
        if run.pivots != (self.pivots > 0) {
            return (0, 0);
        }
        let (from, to) = (run.to as usize, (run.to + run.len) as usize);
        let (first, end) = (self.first, self.first + self.numbers.len() / self.stride);
        let begin = from.max(first);
        (begin - from, to.min(end).saturating_sub(begin))
    }
}

/// An update to be added.
pub(crate) struct Extension<'a> {
    pub(crate) runs: &'a [Run],
    pub(crate) from: Matrix<'a>,
    pub(crate) to: Columns<'a>,
}

impl WithSimd for Extension<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { runs, from, to } = self;
        let pivots = to.pivots;
        for (k, run) in runs.iter().enumerate() {
            let (skipped, count) = to.part(run);
            for t in skipped..skipped + count {
                let source = &from.numbers[(run.from as usize + t) * from.stride..][..from.stride];
                let column = (run.to as usize + t - to.first) * to.stride;
                for (other, skipped) in core::iter::once((run, t)).chain(runs[k + 1..].iter().map(|o| (o, 0)))
                {
                    let source = &source[other.from as usize + skipped..][..other.len as usize - skipped];
                    let row = other.row(pivots) + skipped;
                    add(simd, &mut to.numbers[column + row..], source);
                }
                to.numbers[column + to.stride - 1] += source[from.stride - 1];
            }
        }
    }
}

/// A product L·Lᵀ to be subtracted: the update that it is does not get formed. L has the rows of an update, the right-hand
/// side below, and [`SLACK`](super::SLACK).
pub(crate) struct Outer<'a> {
    pub(crate) runs: &'a [Run],
    pub(crate) l: Matrix<'a>,
    pub(crate) rows: usize,
    pub(crate) depth: usize,
    pub(crate) to: Columns<'a>,
}

impl WithSimd for Outer<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { runs, l, rows, depth, to } = self;
        let (stride, pivots) = (to.stride, to.pivots);
        let below = |row: usize| Matrix { numbers: &l.numbers[row..], stride: l.stride };
        for (k, run) in runs.iter().enumerate() {
            let (skipped, columns) = to.part(run);
            if columns == 0 {
                continue;
            }
            let from = run.from as usize + skipped;
            let column = (run.to as usize + skipped - to.first) * to.stride;
            let diagonal = (run.row(pivots) + skipped, from, run.len as usize - skipped);
            let others = runs[k + 1..].iter().map(|o| (o.row(pivots), o.from as usize, o.len as usize));
            let right = (stride - 1, rows - 1, 1);
            let blocks = core::iter::once(diagonal).chain(others).chain([right]);
            for (place, (row, a, rows)) in blocks.enumerate() {
                let (a, b) = (below(a), below(from));
                let c = &mut to.numbers[column + row..];
                strips(
                    simd,
                    &mut Product { c, stride, a, b, rows, columns, depth, lower: place == 0, fresh: false },
                );
            }
        }
    }
}

/// to += from, on as much of `to`.
#[inline(always)]
fn add<S: Simd>(simd: S, to: &mut [f64], from: &[f64]) {
    let (vectors, rest) = S::as_simd_f64s(from);
    let (to, from_end) = to[..from.len()].split_at_mut(vectors.len() * S::F64_LANES);
    let (targets, _) = S::as_mut_simd_f64s(to);
    targets.iter_mut().zip(vectors).for_each(|(to, from)| *to = simd.add_f64s(*to, *from));
    from_end.iter_mut().zip(rest).for_each(|(to, from)| *to += from);
}
