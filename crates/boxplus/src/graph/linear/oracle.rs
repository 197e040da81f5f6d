//! faer's supernodal factorisation of the same matrices: what ours is held against in tests, for numbers and for time.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![cfg_attr(not(feature = "io"), allow(dead_code, reason = "public graphs are read from files"))]

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::linalg::{SupernodalThreshold, amd};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side, Spec};

use super::cholesky::Cholesky;
use super::evaluate::Evaluator;
use super::kernels::{Kernels, Matrix, Product, SLACK};
use super::pattern::Pattern;
use super::structure::Structure;
use crate::graph::{Graph, GraphError, Values, gauge};

/// (row, column, place) of all entries of the lower triangle.
pub(crate) fn entries(pattern: &Pattern) -> impl Iterator<Item = (usize, usize, usize)> {
    pattern.blocks().flat_map(|block| {
        let all = (0..block.columns).flat_map(move |c| (0..block.rows).map(move |r| (r, c)));
        let place = move |(r, c)| (block.row + r, block.column + c, block.at + c * block.rows + r);
        all.map(place).filter(|(i, j, _)| i >= j)
    })
}

/// A matrix of fixed pattern in faer's hands, in our order.
pub(crate) struct Oracle {
    lower: SymbolicSparseColMat<usize>,
    from: Vec<usize>,
    values: Vec<f64>,
    symbolic: SymbolicCholesky<usize>,
    factor: Vec<f64>,
    memory: MemBuffer,
}

impl Oracle {
    pub(crate) fn new(pattern: &Pattern) -> Self {
        let size = pattern.size();
        let mut columns = vec![vec![]; size];
        let mut rows = vec![vec![]; size];
        for (i, j, at) in entries(pattern) {
            columns[j].push((i, at));
            rows[i].push(j);
        }
        let upper = pattern_of(
            &rows
                .into_iter()
                .map(|mut row| {
                    row.sort_unstable();
                    row
                })
                .collect::<Vec<_>>(),
        );
        columns.iter_mut().for_each(|column| column.sort_unstable());
        let from = columns.iter().flatten().map(|(_, at)| *at).collect::<Vec<_>>();
        let lower = pattern_of(
            &columns.iter().map(|column| column.iter().map(|(i, _)| *i).collect()).collect::<Vec<_>>(),
        );
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..CholeskySymbolicParams::default()
        };
        let symbolic =
            factorize_symbolic_cholesky(upper.as_ref(), Side::Upper, SymmetricOrdering::Identity, parameters)
                .unwrap();
        let memory = MemBuffer::new(StackReq::any_of(&[
            symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Spec::default()),
            symbolic.solve_in_place_scratch::<f64>(1, Par::Seq),
        ]));
        Self {
            factor: vec![0.0; symbolic.len_val()],
            values: vec![0.0; from.len()],
            lower,
            from,
            symbolic,
            memory,
        }
    }

    /// Takes over the numbers of a matrix.
    pub(crate) fn read(&mut self, matrix: &[f64]) {
        self.values.iter_mut().zip(&self.from).for_each(|(value, &at)| *value = matrix[at]);
    }

    /// Whether the matrix is positive definite.
    pub(crate) fn factorise(&mut self) -> bool {
        self.symbolic
            .factorize_numeric_llt(
                &mut self.factor,
                SparseColMatRef::new(self.lower.as_ref(), &self.values),
                Side::Lower,
                LltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut self.memory),
                Spec::default(),
            )
            .is_ok()
    }

    pub(crate) fn solve(&mut self, x: &mut [f64]) {
        let size = x.len();
        LltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(x, size, 1),
            Par::Seq,
            MemStack::new(&mut self.memory),
        );
    }
}

fn pattern_of(columns: &[Vec<usize>]) -> SymbolicSparseColMat<usize> {
    let mut starts = vec![0];
    columns.iter().for_each(|column| starts.push(starts[starts.len() - 1] + column.len()));
    SymbolicSparseColMat::new_checked(columns.len(), columns.len(), starts, None, columns.concat())
}

/// The order of faer's approximate minimum degree; `pairs` are sorted, first before second.
pub(crate) fn amd_order(count: usize, pairs: &[(u32, u32)]) -> Vec<u32> {
    let mut columns = vec![vec![]; count];
    pairs.iter().for_each(|&(a, b)| columns[a as usize].push(b as usize));
    let pattern = pattern_of(&columns);
    let pattern: SymbolicSparseColMatRef<'_, usize> = pattern.as_ref();
    let (mut order, mut inverse) = (vec![0usize; count], vec![0; count]);
    let mut memory = MemBuffer::new(amd::order_scratch::<usize>(count, pairs.len()));
    amd::order(&mut order, &mut inverse, pattern, amd::Control::default(), MemStack::new(&mut memory))
        .unwrap();
    order.into_iter().map(|i| i as u32).collect()
}

/// The normal equations of a graph: their pattern and matrix.
pub(crate) fn normal_equations(graph: &Graph, values: &Values) -> Result<(Pattern, Vec<f64>), GraphError> {
    let mut values = values.clone();
    gauge::fix(&graph.sets, &mut values);
    let structure = Structure::new(&graph.sets, &values, &graph.analyses)?;
    let mut normal = structure.normal();
    Evaluator::new(&graph.sets, 1).linearise(&values, &structure, &mut normal);
    Ok((structure.pattern, normal.matrix))
}

/// Dimensions of the variables of a pattern, in its order, and the pairs that have a block.
pub(crate) fn graph_of(pattern: &Pattern) -> (Vec<usize>, Vec<(u32, u32)>) {
    let place = |scalar| pattern.place_of(scalar) as u32;
    let dims = pattern.starts.windows(2).map(|ends| ends[1] - ends[0]).collect();
    let joined = pattern.blocks().filter(|block| block.row != block.column);
    (dims, joined.map(|block| (place(block.column), place(block.row))).collect())
}

impl Cholesky {
    /// Multiplications of one factorisation.
    pub(crate) fn multiplications(&self) -> usize {
        let front =
            |front: &super::plan::Front| (0..front.pivots).map(|c| (front.rows - c).pow(2)).sum::<usize>();
        self.plan.fronts.iter().map(front).sum::<usize>() / 2
    }
}

/// A product small enough for the first cache: the rate that all dense work could have.
pub(crate) struct TileRate {
    a: Vec<f64>,
    c: Vec<f64>,
}

impl TileRate {
    const SIZE: usize = 32;
    const DEPTH: usize = 96;
    pub(crate) const FLOP: f64 = (2 * Self::SIZE * 6 * Self::DEPTH) as f64;

    pub(crate) fn new() -> Self {
        Self { a: vec![1e-3; Self::SIZE * Self::DEPTH + SLACK], c: vec![0.0; Self::SIZE * 6 + SLACK] }
    }

    pub(crate) fn run(&mut self) {
        let a = Matrix { numbers: &self.a, stride: Self::SIZE };
        Kernels::new().subtract_product(Product {
            c: &mut self.c,
            stride: Self::SIZE,
            a,
            b: a,
            rows: Self::SIZE,
            columns: 6,
            depth: Self::DEPTH,
            lower: false,
            fresh: true,
        });
    }
}
