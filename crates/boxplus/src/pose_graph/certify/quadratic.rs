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

use std::sync::Arc;

use nalgebra::{SMatrix, SVector};

use crate::graph::GraphError;
use crate::graph::linear::pattern::Pattern;
use crate::graph::linear::structure::sorted;
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

/// ½ ∂F/∂(R_i, t_i) of every frame.
pub(super) fn slopes<const P: usize, const D: usize>(
    links: &[Link<D>],
    frames: &[Frame<P, D>],
) -> Vec<Frame<P, D>> {
    let mut slopes = vec![Frame { y: SMatrix::zeros(), t: SVector::zeros() }; frames.len()];
    for link in links {
        let (rotation, translation) = link.misfit(frames);
        let (rotation, translation) = (rotation * link.kappa, translation * link.tau);
        let from = &mut slopes[link.from];
        from.y -= rotation * link.rotation.transpose() + translation * link.translation.transpose();
        from.t -= translation;
        let to = &mut slopes[link.to];
        to.y += rotation;
        to.t += translation;
    }
    slopes
}

/// The multipliers Λ_i of the constraints RᵀR = I.
pub(super) fn multipliers<const P: usize, const D: usize>(
    frames: &[Frame<P, D>],
    slopes: &[Frame<P, D>],
) -> Vec<SMatrix<f64, D, D>> {
    let multiplier = |(frame, slope): (&Frame<P, D>, &Frame<P, D>)| {
        let product = frame.y.transpose() * slope.y;
        (product + product.transpose()) * 0.5
    };
    frames.iter().zip(slopes).map(multiplier).collect()
}

/// The lower triangle of a symmetric matrix with a block for every pose and every link, in an elimination order.
#[derive(Clone)]
pub(super) struct Layout {
    /// Rows of one pose.
    size: usize,
    /// Where each pose stands in the order.
    position: Vec<usize>,
    pub(super) pattern: Pattern,
    /// The pairs of poses that a link joins, the lower first, each once.
    pub(super) pairs: Vec<(u32, u32)>,
    /// One pose of each connected part: moving a part changes no cost, so that one may be held.
    pub(super) anchors: Vec<usize>,
}

impl Layout {
    /// Orders `count` poses joined by `links`, with blocks of `size` rows.
    ///
    /// # Errors
    /// [`GraphError::OutOfMemory`].
    pub(super) fn new<const D: usize>(
        links: &[Link<D>],
        count: usize,
        size: usize,
    ) -> Result<Self, GraphError> {
        let mut parts = Partition::new(count);
        links.iter().for_each(|link| parts.join(link.from, link.to));
        let anchors = parts.parts().map(|(pose, _)| pose).collect();

        let pairs = joined(links, count);
        let pattern = Pattern::new(&vec![size; count], &pairs)?;
        let mut position = vec![0; count];
        let order = pattern.symbolic.order.iter().enumerate();
        order.for_each(|(place, &pose)| position[pose as usize] = place);
        Ok(Self { size, position, pattern, pairs, anchors })
    }

    /// The same poses in the same order, with blocks of another size.
    ///
    /// # Errors
    /// [`GraphError::OutOfMemory`].
    pub(super) fn resized(&self, size: usize) -> Result<Self, GraphError> {
        let symbolic = Arc::clone(&self.pattern.symbolic);
        let pattern = Pattern::lay_out(symbolic, &vec![size; self.count()], &self.pairs)?;
        Ok(Self { size, pattern, ..self.clone() })
    }

    /// How many poses there are.
    pub(super) fn count(&self) -> usize {
        self.position.len()
    }

    /// The first row of a pose.
    pub(super) fn row(&self, pose: usize) -> usize {
        self.position[pose] * self.size
    }

    /// Where the entry of coordinate a of one pose and b of the other stands in the lower triangle, whichever is the row; for
    /// a pose with itself, whichever coordinate is.
    pub(super) fn block(&self, one: usize, other: usize) -> impl Fn(usize, usize) -> usize {
        let (one, other, size) = (self.position[one], self.position[other], self.size);
        let at = self.pattern.find(one.max(other), one.min(other)).unwrap_or(0);
        move |a, b| {
            let (row, column) = if (one, a) < (other, b) { (b, a) } else { (a, b) };
            at + column * size + row
        }
    }
}

/// The matrix S in a layout of D + 1 rows a pose.
pub(super) fn dual<const D: usize>(
    layout: &Layout,
    links: &[Link<D>],
    multipliers: &[SMatrix<f64, D, D>],
) -> Vec<f64> {
    let mut values = vec![0.0; layout.pattern.len()];
    for link in links {
        let (i, j, kappa, tau, t) = (link.from, link.to, link.kappa, link.tau, &link.translation);
        let (ii, jj, ij) = (layout.block(i, i), layout.block(j, j), layout.block(i, j));
        let mut add = |place, value| values[place] += value;
        for a in 0..D {
            for b in 0..=a {
                let unit = if a == b { kappa } else { 0.0 };
                add(ii(a, b), unit + tau * t[a] * t[b]);
            }
            add(jj(a, a), kappa);
            add(ii(D, a), tau * t[a]);
            add(ij(a, D), -tau * t[a]);
            (0..D).for_each(|b| add(ij(a, b), -kappa * link.rotation[(a, b)]));
        }
        add(ii(D, D), tau);
        add(jj(D, D), tau);
        add(ij(D, D), -tau);
    }
    for (pose, multiplier) in multipliers.iter().enumerate() {
        let place = layout.block(pose, pose);
        (0..D).for_each(|a| (0..=a).for_each(|b| values[place(a, b)] -= multiplier[(a, b)]));
    }
    values
}

/// The pairs among `count` poses that a link joins, the lower first, each once.
fn joined<const D: usize>(links: &[Link<D>], count: usize) -> Vec<(u32, u32)> {
    let pair = |link: &Link<D>| (link.from.min(link.to) as u32, link.from.max(link.to) as u32);
    sorted(links.iter().map(pair).filter(|(a, b)| a != b).collect(), count)
}
