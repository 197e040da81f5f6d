//! Tables of `scripts/rotation_tables.py`.

use boxplus::lie::Real;
use nalgebra::SVector;

/// Rows of named columns.
pub(crate) struct Table {
    header: Vec<&'static str>,
    rows: Vec<Vec<&'static str>>,
}

pub(crate) struct Row<'a> {
    header: &'a [&'static str],
    cells: &'a [&'static str],
}

impl Table {
    pub(crate) fn parse(text: &'static str) -> Self {
        let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
        Self { header: lines.next().unwrap(), rows: lines.collect() }
    }
    pub(crate) fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.rows.iter().map(|cells| Row { header: &self.header, cells })
    }
}

impl Row<'_> {
    pub(crate) fn name(&self) -> &'static str {
        self.cells[0]
    }
    /// The numbers of the columns `name0`, `name1`, …
    pub(crate) fn get<const N: usize>(&self, name: &str) -> [f64; N] {
        let first = format!("{name}0");
        let i = self.header.iter().position(|h| **h == first).unwrap();
        std::array::from_fn(|k| self.cells[i + k].parse().unwrap())
    }
    pub(crate) fn vector<S: Real, const N: usize>(&self, name: &str) -> SVector<S, N> {
        SVector::from(self.get::<N>(name)).map(S::lit)
    }
}

/// Refuses an error, in ε, above its bound.
pub(crate) fn within(name: &str, error: f64, bound: f64) {
    assert!(error <= bound, "{name}: {error:.2} ε, allowed {bound}");
}

/// |computed − truth| in ε of `S`, relative to `scale`.
pub(crate) fn error<S: Real, const R: usize, const C: usize>(
    computed: &nalgebra::SMatrix<S, R, C>,
    truth: &nalgebra::SMatrix<f64, R, C>,
    scale: f64,
) -> f64 {
    let difference = (computed.map(Real::value) - truth).norm();
    assert!(!difference.is_nan(), "{computed:?} {truth}");
    difference / scale / S::EPSILON
}
