//! Tables of truth, and how far from it a number is.

use boxplus::lie::{LieGroup, Real};
use nalgebra::{SMatrix, SVector};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// A table of the script: named columns of numbers.
pub(crate) struct Table {
    header: Vec<&'static str>,
    rows: Vec<Vec<f64>>,
    inputs: usize,
}

impl Table {
    pub(crate) fn parse(text: &'static str, inputs: usize) -> Self {
        let mut lines = text.lines();
        let header = lines.next().unwrap().split(',').collect();
        let rows = lines.map(|l| l.split(',').map(|x| x.parse().unwrap()).collect()).collect();
        Self { header, rows, inputs }
    }

    /// The rows whose inputs `S` represents exactly.
    pub(crate) fn rows<S: Real>(&self) -> impl Iterator<Item = Row<'_>> {
        let exact = |x: &f64| S::lit(*x).value() == *x;
        let usable = self.rows.iter().filter(move |r| r[..self.inputs].iter().all(exact));
        usable.map(|numbers| Row { header: &self.header, numbers })
    }
}

pub(crate) struct Row<'a> {
    header: &'a [&'static str],
    pub(crate) numbers: &'a [f64],
}

impl Row<'_> {
    /// The place of the column `name`.
    pub(crate) fn column(&self, name: &str) -> usize {
        self.header.iter().position(|h| *h == name).unwrap()
    }
    /// The place of the column `name0`.
    pub(crate) fn first(&self, name: &str) -> usize {
        self.column(&format!("{name}0"))
    }
    /// The numbers of the columns `name0`, `name1`, …
    pub(crate) fn get<const N: usize>(&self, name: &str) -> [f64; N] {
        let i = self.first(name);
        std::array::from_fn(|k| self.numbers[i + k])
    }
    pub(crate) fn input<S: Real, const N: usize>(&self, name: &str) -> SVector<S, N> {
        SVector::from(self.get::<N>(name)).map(S::lit)
    }
}

/// The largest errors of each operation, in ε: for θ ≤ π, and beyond in multiples of θ/(2π − θ).
#[derive(Default)]
pub(crate) struct Errors(pub(crate) BTreeMap<String, [f64; 2]>);

impl Errors {
    /// Records |computed − truth|/scale in ε of `S`, and beyond π over the amplification there.
    pub(crate) fn record<S: Real>(
        &mut self,
        name: &str,
        theta: f64,
        computed: &[S],
        truth: &[f64],
        scale: f64,
    ) {
        assert_eq!(computed.len(), truth.len());
        let difference = norm(computed.iter().zip(truth).map(|(c, t)| c.value() - t));
        let amplified = (theta / (TAU - theta)).max(1.0);
        let error = if difference == 0.0 { 0.0 } else { difference / scale / S::EPSILON / amplified };
        assert!(!error.is_nan(), "{name} at θ = {theta}: {computed:?}");
        let worst = &mut self.0.entry(name.to_owned()).or_default()[usize::from(theta > PI)];
        *worst = worst.max(error);
    }
    /// Relative to the norm of the truth.
    pub(crate) fn relative<S: Real>(&mut self, name: &str, theta: f64, computed: &[S], truth: &[f64]) {
        self.record(name, theta, computed, truth, norm(truth.iter().copied()));
    }
}

pub(crate) fn norm(x: impl IntoIterator<Item = f64>) -> f64 {
    // Scaled, for translations span twelve decades.
    let x: Vec<f64> = x.into_iter().collect();
    let largest = x.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    if largest == 0.0 { 0.0 } else { largest * x.iter().map(|b| (b / largest).powi(2)).sum::<f64>().sqrt() }
}

/// Jacobians at θ → 2π are poles; the tables go on, the promise ends here.
pub(crate) const LAST: f64 = 6.2;

/// Named blocks of a matrix: first row and column, rows and columns.
pub(crate) type Parts = [(&'static str, [usize; 4])];

/// The blocks of `m` against their numbers by rows, one block after the other, each relative to itself.
pub(crate) fn matrix<S: Real, const D: usize>(
    errors: &mut Errors,
    operation: &str,
    parts: &Parts,
    m: &SMatrix<S, D, D>,
    truth: &[f64],
) {
    let mut rest = truth;
    for (part, [i, j, h, w]) in parts {
        let (expected, after) = rest.split_at(h * w);
        let block: Vec<S> = m.view((*i, *j), (*h, *w)).transpose().iter().copied().collect();
        errors.relative(&format!("{operation}, {part}"), 0.0, &block, expected);
        rest = after;
    }
}

/// J_l, J_r and their inverses at ±τ against J_l(τ) and J_l(τ)⁻¹.
pub(crate) fn jacobians<G: LieGroup<D>, const D: usize, const K: usize>(
    errors: &mut Errors,
    group: &str,
    parts: &Parts,
    row: &Row<'_>,
) {
    let tau: SVector<G::Scalar, D> = row.input("tau");
    let (jl, inverse) = (row.get::<K>("jl"), row.get::<K>("jl_inv"));
    matrix(errors, &format!("{group} Jl"), parts, &G::left_jacobian(&tau), &jl);
    matrix(errors, &format!("{group} Jr"), parts, &G::right_jacobian(&-tau), &jl);
    matrix(errors, &format!("{group} Jl⁻¹"), parts, &G::left_jacobian_inverse(&tau), &inverse);
    matrix(errors, &format!("{group} Jr⁻¹"), parts, &G::right_jacobian_inverse(&-tau), &inverse);
}
