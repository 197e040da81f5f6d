//! SE-Sync's cost as a quadratic form, and the matrix of its dual.
//!
//! Written with all poses side by side, X = [R₁ t₁ R₂ t₂ …], P × n(D+1), the cost is
//!
//! ```text
//! F(X) = Σ κ‖R_j − R_i·R̃‖² + τ‖t_j − t_i − R_i·t̃‖² = tr(X·M·Xᵀ)
//! Λ_i = sym(R_iᵀ·(X·M)_{R_i})            S = M − blockdiag(Λ_i on the rotations, 0 on the translations)
//! ```
//!
//! Because RᵀR = I, F(X') = Σ tr Λ_i + tr(X'·S·X'ᵀ) for *every* X' with orthonormal R', of however many rows P ≥ D. If
//! xᵀSx ≥ λ‖x_R‖² then F(X') ≥ Σ tr Λ_i + λ·n·D: a lower bound on the optimum from any estimate, and a proof that the
//! estimate is the optimum where the two meet. Rosen et al. (2019), §4, with translations kept, which leaves S as sparse as
//! the graph.

use nalgebra::{SMatrix, SVector};

use crate::graph::GraphError;
use crate::graph::linear::cholesky::minimum_degree;
use crate::graph::linear::structure::Pattern;
use crate::partition::Partition;

/// A pose of the relaxation: D orthonormal columns and a position, in ℝᴾ. With P = D it is a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame<const P: usize, const D: usize> {
    pub(super) y: SMatrix<f64, P, D>,
    pub(super) t: SVector<f64, P>,
}

/// A measured displacement with its two weights.
#[derive(Clone, Copy, Debug)]
pub(super) struct Link<const D: usize> {
    pub(super) from: usize,
    pub(super) to: usize,
    pub(super) rotation: SMatrix<f64, D, D>,
    pub(super) translation: SVector<f64, D>,
    /// Weight of the rotation.
    pub(super) kappa: f64,
    /// Weight of the translation.
    pub(super) tau: f64,
}

impl<const D: usize> Link<D> {
    /// (R_j − R_i·R̃, t_j − t_i − R_i·t̃).
    fn misfit<const P: usize>(&self, frames: &[Frame<P, D>]) -> (SMatrix<f64, P, D>, SVector<f64, P>) {
        let (a, b) = (&frames[self.from], &frames[self.to]);
        (b.y - a.y * self.rotation, b.t - a.t - a.y * self.translation)
    }
}

/// F(X).
pub(super) fn cost<const P: usize, const D: usize>(links: &[Link<D>], frames: &[Frame<P, D>]) -> f64 {
    let of = |link: &Link<D>| {
        let (rotation, translation) = link.misfit(frames);
        link.kappa * rotation.norm_squared() + link.tau * translation.norm_squared()
    };
    links.iter().map(of).sum()
}

/// The multipliers Λ_i of the constraints RᵀR = I.
pub(super) fn multipliers<const P: usize, const D: usize>(
    links: &[Link<D>],
    frames: &[Frame<P, D>],
) -> Vec<SMatrix<f64, D, D>> {
    let mut slopes = vec![SMatrix::<f64, P, D>::zeros(); frames.len()]; // ½ ∂F/∂R_i
    for link in links {
        let (rotation, translation) = link.misfit(frames);
        let (rotation, translation) = (rotation * link.kappa, translation * link.tau);
        slopes[link.from] -= rotation * link.rotation.transpose() + translation * link.translation.transpose();
        slopes[link.to] += rotation;
    }
    let multiplier = |(frame, slope): (&Frame<P, D>, &SMatrix<f64, P, D>)| {
        let product = frame.y.transpose() * slope;
        (product + product.transpose()) * 0.5
    };
    frames.iter().zip(&slopes).map(multiplier).collect()
}

/// The lower triangle of S, laid out once in an elimination order.
pub(super) struct Layout<const D: usize> {
    /// Where each pose stands in the order.
    position: Vec<usize>,
    pub(super) pattern: Pattern,
    /// Row blocks of each column block, ascending, the diagonal first.
    blocks: Vec<Vec<usize>>,
    /// One pose of each connected part: its position is held, since moving a part changes no cost.
    anchors: Vec<usize>,
}

impl<const D: usize> Layout<D> {
    /// Rows of one pose.
    const SIZE: usize = D + 1;

    /// Orders `count` poses joined by `links`.
    ///
    /// # Errors
    /// [`GraphError::OutOfMemory`].
    pub(super) fn new(links: &[Link<D>], count: usize) -> Result<Self, GraphError> {
        let mut parts = Partition::new(count);
        links.iter().for_each(|link| parts.join(link.from, link.to));
        let anchors = parts.parts().map(|(pose, _)| pose).collect();

        let order = minimum_degree(count, &pairs(links, count, |pose| pose))?;
        let mut position = vec![0; count];
        order.iter().enumerate().for_each(|(place, &pose)| position[pose] = place);
        let mut blocks = vec![vec![]; count];
        for (column, row) in pairs(links, count, |pose| position[pose]) {
            blocks[column as usize].push(row as usize);
        }
        let mut pattern = Pattern { starts: vec![0], rows: vec![] };
        for rows in &blocks {
            for column in 0..Self::SIZE {
                let scalars = rows.iter().flat_map(|row| row * Self::SIZE..(row + 1) * Self::SIZE);
                pattern.rows.extend(scalars.skip(column));
                pattern.starts.push(pattern.rows.len());
            }
        }
        Ok(Self { position, pattern, blocks, anchors })
    }

    /// The numbers of S in the pattern.
    pub(super) fn matrix(&self, links: &[Link<D>], multipliers: &[SMatrix<f64, D, D>]) -> Vec<f64> {
        let mut values = vec![0.0; self.pattern.rows.len()];
        for link in links {
            let (i, j) = (self.position[link.from], self.position[link.to]);
            let (kappa, tau, t) = (link.kappa, link.tau, &link.translation);
            for a in 0..D {
                for b in 0..=a {
                    let unit = if a == b { kappa } else { 0.0 };
                    self.add(&mut values, (i, a), (i, b), unit + tau * t[a] * t[b]);
                }
                self.add(&mut values, (j, a), (j, a), kappa);
                self.add(&mut values, (i, D), (i, a), tau * t[a]);
                self.add(&mut values, (i, a), (j, D), -tau * t[a]);
                (0..D).for_each(|b| self.add(&mut values, (i, a), (j, b), -kappa * link.rotation[(a, b)]));
            }
            self.add(&mut values, (i, D), (i, D), tau);
            self.add(&mut values, (j, D), (j, D), tau);
            self.add(&mut values, (i, D), (j, D), -tau);
        }
        for (pose, multiplier) in multipliers.iter().enumerate() {
            let i = self.position[pose];
            (0..D).for_each(|a| (0..=a).for_each(|b| self.add(&mut values, (i, a), (i, b), -multiplier[(a, b)])));
        }
        for &pose in &self.anchors {
            // Whatever is added here is paid by moving the whole part, which is free: S stays as definite as it was.
            let diagonal = self.place((self.position[pose], D), (self.position[pose], D));
            values[diagonal] += values[diagonal].max(1.0);
        }
        values
    }

    /// Where the diagonal entries of the rotations stand among the numbers of S.
    pub(super) fn rotation_diagonal(&self) -> Vec<usize> {
        let of = |column: usize| (0..D).map(move |a| (column, a));
        (0..self.blocks.len()).flat_map(of).map(|entry| self.place(entry, entry)).collect()
    }

    /// What a vector has for a pose: D numbers for its rotation, one for its position.
    pub(super) fn part(&self, vector: &[f64], pose: usize) -> (SVector<f64, D>, f64) {
        let row = self.position[pose] * Self::SIZE;
        (SVector::from_column_slice(&vector[row..row + D]), vector[row + D])
    }

    fn add(&self, values: &mut [f64], row: (usize, usize), column: (usize, usize), value: f64) {
        let (row, column) = if row >= column { (row, column) } else { (column, row) };
        values[self.place(row, column)] += value;
    }

    /// Where entry (row, column), each (block, coordinate), of the lower triangle stands.
    fn place(&self, (row, a): (usize, usize), (column, b): (usize, usize)) -> usize {
        let above = self.blocks[column].binary_search(&row).unwrap_or(0) * Self::SIZE;
        self.pattern.starts[column * Self::SIZE + b] + above + a - b
    }
}

/// (column, row) of every block of the lower triangle, sorted, each once.
fn pairs<const D: usize>(links: &[Link<D>], count: usize, place: impl Fn(usize) -> usize) -> Vec<(u32, u32)> {
    let joined = links.iter().map(|link| {
        let (a, b) = (place(link.from) as u32, place(link.to) as u32);
        (a.min(b), a.max(b))
    });
    let mut pairs: Vec<_> = (0..count as u32).map(|i| (i, i)).chain(joined).collect();
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}
