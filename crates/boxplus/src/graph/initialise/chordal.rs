//! Poses by two linear problems.
//!
//! ```text
//! rotations   min Σ κ‖R_j − R_i·R̃‖²_F over all matrices, then the nearest rotation to each
//! positions   min Σ ‖t_j − t_i − R_i·t̃‖² in the metric R_i·Ω_t·R_iᵀ
//! ```
//!
//! The rows of the matrices are independent of each other and share one system: it is factorised once and solved for
//! each row. In the plane the first row is enough: the relaxed matrices are rotations times a factor. Both problems join the
//! same poses as the graph itself, so that one ordering and one symbolic factorisation serve all three.

use nalgebra::SMatrix;

use super::edges::{Edge, Pose};
use crate::graph::linear::analyses::Analyses;
use crate::graph::linear::cholesky::Cholesky;
use crate::graph::linear::pattern::Pattern;
use crate::graph::linear::structure::sorted;
use crate::graph::{GraphError, Key, Values};

/// Overwrites the poses that are joined by relative poses and are not in `known`; `values` hold a value for each.
pub(crate) fn relax<P: Pose<N, D>, const N: usize, const D: usize>(
    edges: &[Edge<P, D>],
    known: &[bool],
    analyses: &Analyses,
    values: &mut Values,
) -> Result<(), GraphError> {
    if edges.is_empty() {
        return Ok(());
    }
    let mut poses: Vec<P> = values.slice::<P>().iter().map(|pose| pose.unwrap_or_else(P::identity)).collect();
    let mut system = System::<N>::new(edges, known, analyses)?;
    let rows = system.solve(P::ROWS, edges, rotation, |slot| poses[slot].parts().0.transpose())?;
    for &(slot, place) in &system.free {
        poses[slot] = P::with_rows(&rows[place], &poses[slot].parts().1).unwrap_or(poses[slot]);
    }
    let position = |slot: usize| first_column(poses[slot].parts().1.as_slice());
    let line = |edge: &Edge<P, D>| displacement(edge, &poses[edge.from as usize]);
    let positions = system.solve(1, edges, line, position)?;
    for &(slot, place) in &system.free {
        let position = positions[place].column(0).into_owned();
        values.set(Key::new(slot as u32), poses[slot].moved_to(&position))?;
    }
    Ok(())
}

/// The relation x_j = B·x_i + b between vectors at two poses, in a metric M. Each column is a problem of its own.
struct Line<const N: usize> {
    b: SMatrix<f64, N, N>,
    offset: SMatrix<f64, N, N>,
    metric: SMatrix<f64, N, N>,
}

/// R_jᵀ = R̃ᵀ·R_iᵀ: the rows of R are the columns here.
fn rotation<P: Pose<N, D>, const N: usize, const D: usize>(edge: &Edge<P, D>) -> Line<N> {
    let kappa = P::rotation_weight(&edge.information);
    Line {
        b: edge.measured.parts().0.transpose(),
        offset: SMatrix::zeros(),
        metric: SMatrix::identity() * kappa,
    }
}

/// t_j = t_i + R_i·t̃, where the pose i has its rotation.
fn displacement<P: Pose<N, D>, const N: usize, const D: usize>(edge: &Edge<P, D>, from: &P) -> Line<N> {
    let (r, _) = from.parts();
    let metric = r * edge.information.fixed_view::<N, N>(0, 0) * r.transpose();
    Line {
        b: SMatrix::identity(),
        offset: first_column((r * edge.measured.parts().1).as_slice()),
        metric: (metric + metric.transpose()) * 0.5,
    }
}

/// The matrix with this first column and zeros.
fn first_column<const N: usize>(column: &[f64]) -> SMatrix<f64, N, N> {
    SMatrix::from_fn(|i, j| if j == 0 { column[i] } else { 0.0 })
}

/// Linear least squares with a vector at each free pose; what depends on the edges alone is laid out once.
struct System<const N: usize> {
    /// (slot, place in the order of elimination) of each free pose.
    free: Vec<(usize, usize)>,
    joins: Vec<Join>,
    diagonal: Vec<usize>,
    matrix: Vec<f64>,
    cholesky: Cholesky,
}

/// The places of the poses that an edge joins, where they are free, and of their common block.
#[derive(Clone, Copy)]
struct Join {
    from: Option<usize>,
    to: Option<usize>,
    at: usize,
}

impl<const N: usize> System<N> {
    fn new<P, const D: usize>(
        edges: &[Edge<P, D>],
        known: &[bool],
        analyses: &Analyses,
    ) -> Result<Self, GraphError> {
        let mut number: Vec<Option<u32>> = vec![None; known.len()];
        let ends = |edge: &Edge<P, D>| [edge.from as usize, edge.to as usize];
        for slot in edges.iter().flat_map(ends).filter(|&slot| !known[slot]) {
            number[slot] = Some(0);
        }
        number.iter_mut().flatten().zip(0..).for_each(|(number, i)| *number = i);
        let count = number.iter().flatten().count();
        let pair = |edge: &Edge<P, D>| {
            let [a, b] = ends(edge).map(|slot| number[slot]);
            let (a, b) = (a?, b?);
            (a != b).then_some((a.min(b), a.max(b)))
        };
        let pairs = sorted(edges.iter().filter_map(pair).collect(), count);
        let symbolic = analyses.of(&vec![D; count], &pairs);
        let mut places = vec![0; count];
        symbolic.order.iter().enumerate().for_each(|(place, &i)| places[i as usize] = place);
        let pattern = Pattern::lay_out(symbolic, &vec![N; count], &pairs)?;
        let join = |edge: &Edge<P, D>| {
            let [from, to] = ends(edge).map(|slot| number[slot].map(|i| places[i as usize]));
            let block = from.zip(to).and_then(|(a, b)| pattern.find(a.max(b), a.min(b)));
            Join { from, to, at: block.unwrap_or(0) }
        };
        let free = number.iter().enumerate().filter_map(|(slot, i)| Some((slot, places[(*i)? as usize])));
        Ok(Self {
            free: free.collect(),
            joins: edges.iter().map(join).collect(),
            diagonal: pattern.diagonal(),
            matrix: vec![0.0; pattern.len()],
            cholesky: Cholesky::new(&pattern)?,
        })
    }

    /// The vectors of the free poses by their places, in the first `columns` columns; those of the others are `known`.
    ///
    /// # Errors
    /// [`GraphError::IllConditioned`].
    fn solve<P, const D: usize>(
        &mut self,
        columns: usize,
        edges: &[Edge<P, D>],
        line: impl Fn(&Edge<P, D>) -> Line<N>,
        known: impl Fn(usize) -> SMatrix<f64, N, N>,
    ) -> Result<Vec<SMatrix<f64, N, N>>, GraphError> {
        self.matrix.fill(0.0);
        let mut right = vec![SMatrix::<f64, N, N>::zeros(); self.free.len()];
        for (edge, &Join { from, to, at }) in edges.iter().zip(&self.joins) {
            if edge.from == edge.to {
                continue; // says nothing of where the pose is
            }
            let Line { b, mut offset, metric } = line(edge);
            let pull = metric * b;
            if from.is_none() {
                offset += b * known(edge.from as usize);
            }
            if to.is_none() {
                offset -= known(edge.to as usize);
            }
            if let Some(from) = from {
                add(&mut self.matrix[self.diagonal[from * N]..], &b.tr_mul(&pull));
                right[from] -= pull.tr_mul(&offset);
            }
            if let Some(to) = to {
                add(&mut self.matrix[self.diagonal[to * N]..], &metric);
                right[to] += metric * offset;
            }
            if let Some((from, to)) = from.zip(to) {
                add(&mut self.matrix[at..], &if to > from { -pull } else { -pull.transpose() });
            }
        }
        self.cholesky.factorise(&self.matrix).map_err(|_| GraphError::IllConditioned)?;
        let mut x: Vec<f64> = (0..columns)
            .flat_map(|c| right.iter().flat_map(move |r| (0..N).map(move |i| r[(i, c)])))
            .collect();
        self.cholesky.solve(&mut x);
        let size = right.len() * N;
        let vectors = |place: usize| {
            SMatrix::from_fn(|i, c| if c < columns { x[c * size + place * N + i] } else { 0.0 })
        };
        Ok((0..right.len()).map(vectors).collect())
    }
}

/// Adds a block to the numbers of its place.
fn add<const N: usize>(numbers: &mut [f64], block: &SMatrix<f64, N, N>) {
    numbers.iter_mut().zip(block.as_slice()).for_each(|(n, b)| *n += b);
}
