//! Test, leave through the next dimension, come back, test again.

use nalgebra::{DMatrix, SMatrix, SymmetricEigen};

use super::Verdict;
use super::lifted::{descend, minimise};
use super::quadratic::{Frame, Layout, Link, cost, multipliers};
use super::spectrum::{Lowest, Shifted};
use crate::graph::{GraphError, SolveOptions};

/// An estimate is optimal when none can be better by more than this part of its cost.
const TIGHT: f64 = 1e-6;
/// Share of the largest diagonal entry of S below which an eigenvalue is rounding.
const ROUNDING: f64 = 1e-15;
/// Minima left one after the other, at most.
const ESCAPES: usize = 8;
/// A new minimum is another one when it is lower by more than this part.
const LOWER: f64 = 1e-9;

/// What the dual matrix says about an estimate.
#[derive(Clone, Debug)]
pub(super) struct Judgement {
    pub(super) cost: f64,
    pub(super) lower_bound: f64,
    /// The smallest eigenvalue of S, or a bound from below that suffices.
    pub(super) eigenvalue: f64,
    /// The part of the gap that rounding alone can make.
    rounding: f64,
    /// The eigenvector, where the eigenvalue is negative beyond what is tolerated.
    lowest: Option<Lowest>,
}

impl Judgement {
    pub(super) fn verdict(&self) -> Verdict {
        if self.cost - self.lower_bound <= TIGHT * self.cost + self.rounding {
            Verdict::Optimal
        } else if self.lowest.is_some() {
            Verdict::NotOptimal
        } else {
            Verdict::Undecided
        }
    }
}

/// The best estimate found, and what is known about it.
pub(super) struct Climb<const D: usize> {
    pub(super) frames: Vec<Frame<D, D>>,
    pub(super) given: Verdict,
    pub(super) given_cost: f64,
    /// Curvature of the way down from the given estimate, and the poses, those that turn most first.
    pub(super) descent: Option<(f64, Vec<usize>)>,
    pub(super) best: Judgement,
    pub(super) escapes: usize,
}

/// Settles `frames` in their minimum, and leaves it for a lower one as long as there is a way.
///
/// The numbers are, for ranks D, P = D + 1 and Q = D + 2, those of [`super::lifted`]: rank, tangent, residual.
///
/// # Errors
/// [`GraphError::OutOfMemory`].
pub(super) fn climb<
    const D: usize,
    const DT: usize,
    const DR: usize,
    const P: usize,
    const PT: usize,
    const PR: usize,
    const Q: usize,
    const QT: usize,
    const QR: usize,
>(
    links: &[Link<D>],
    given: &[Frame<D, D>],
) -> Result<Climb<D>, GraphError> {
    let options = SolveOptions { relative_cost: 1e-14, max_iterations: 300, ..SolveOptions::default() };
    let layout = Layout::new(links, given.len())?;
    let mut frames = minimise::<D, D, DT, DR>(links, given, &options)?;
    let mut judged = judge(links, &layout, &frames)?;
    let (given, given_cost) = (judged.verdict(), judged.cost);
    let descent = judged.lowest.as_ref().map(|lowest| (lowest.eigenvalue, most_turned(&layout, lowest, frames.len())));
    let mut lower_bound = judged.lower_bound;
    let mut escapes = 0;
    while let (Verdict::NotOptimal, Some(lowest), true) = (judged.verdict(), &judged.lowest, escapes < ESCAPES) {
        let start = descend::<D, P, D>(&frames, |pose| layout.part(&lowest.vector, pose), |x| cost(links, x));
        let lifted = minimise::<P, D, PT, PR>(links, &start, &options)?;
        let above = judge(links, &layout, &lifted)?;
        lower_bound = lower_bound.max(above.lower_bound);
        let down = match (above.verdict(), &above.lowest) {
            (Verdict::NotOptimal, Some(lowest)) => {
                let start = descend::<P, Q, D>(&lifted, |pose| layout.part(&lowest.vector, pose), |x| cost(links, x));
                let lifted = minimise::<Q, D, QT, QR>(links, &start, &options)?;
                lower_bound = lower_bound.max(judge(links, &layout, &lifted)?.lower_bound);
                round(&lifted)
            }
            _ => round(&lifted),
        };
        let settled = minimise::<D, D, DT, DR>(links, &down, &options)?;
        if cost(links, &settled) >= judged.cost * (1.0 - LOWER) {
            break; // the relaxation is lower, but what it says of poses is not
        }
        frames = settled;
        judged = judge(links, &layout, &frames)?;
        escapes += 1;
    }
    // A bound holds whatever it was found with; with it another estimate may yet be proved optimal.
    judged.lower_bound = judged.lower_bound.max(lower_bound);
    if escapes > 0 || judged.verdict() == Verdict::NotOptimal {
        // What is left after the last escape is no way down any more that leads to better poses.
        judged.lowest = None;
    }
    Ok(Climb { frames, given, given_cost, descent, best: judged, escapes })
}

/// Tests an estimate of any rank.
fn judge<const P: usize, const D: usize>(
    links: &[Link<D>],
    layout: &Layout<D>,
    frames: &[Frame<P, D>],
) -> Result<Judgement, GraphError> {
    let multipliers = multipliers(links, frames);
    let trace: f64 = multipliers.iter().map(SMatrix::trace).sum();
    let (matrix, diagonal) = (layout.matrix(links, &multipliers), layout.rotation_diagonal());
    let mut shifted = Shifted::new(&layout.pattern, &matrix, &diagonal)?;
    let (cost, count) = (cost(links, frames), (frames.len() * D) as f64);
    let first = ROUNDING * shifted.scale();
    let judgement = |eigenvalue: f64, lowest| Judgement {
        cost,
        lower_bound: (trace + eigenvalue * count).max(0.0),
        eigenvalue,
        rounding: 100.0 * first * count,
        lowest,
    };
    if let Some(shift) = shifted.least_shift(first, (0.1 * TIGHT * cost / count).max(10.0 * first)) {
        return Ok(judgement(-shift, None));
    }
    let Some(shift) = shifted.least_shift(0.1 * TIGHT * cost / count, f64::MAX) else {
        return Ok(judgement(f64::NEG_INFINITY, None)); // nothing finite
    };
    let lowest = shifted.lowest(shift);
    // The eigenvalue comes from above: what is proved is that a little less suffices.
    let proved = -lowest.eigenvalue * (1.0 + 1e-6) + first;
    let proved = if shifted.is_definite(proved) { proved } else { shift };
    Ok(judgement(-proved, (lowest.eigenvalue < 0.0).then_some(lowest)))
}

/// The poses, those that an eigenvector turns most first.
fn most_turned<const D: usize>(layout: &Layout<D>, lowest: &Lowest, count: usize) -> Vec<usize> {
    let turn = |pose: &usize| layout.part(&lowest.vector, *pose).0.norm();
    let mut poses: Vec<usize> = (0..count).collect();
    poses.sort_by(|a, b| turn(b).total_cmp(&turn(a)));
    poses
}

/// Poses from frames of higher rank: projected on the D dimensions that hold most of them, then to rotations.
fn round<const P: usize, const D: usize>(frames: &[Frame<P, D>]) -> Vec<Frame<D, D>> {
    let spread = frames.iter().fold(SMatrix::<f64, P, P>::zeros(), |sum, f| sum + f.y * f.y.transpose());
    let eigen = SymmetricEigen::new(DMatrix::from_column_slice(P, P, spread.as_slice()));
    let mut order: Vec<usize> = (0..P).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let mut axes = SMatrix::<f64, P, D>::from_fn(|p, d| eigen.eigenvectors[(p, order[d])]);
    let determinant = |f: &Frame<P, D>| determinant(&(axes.transpose() * f.y));
    let mirrored = frames.iter().filter(|f| determinant(f) < 0.0).count();
    if 2 * mirrored > frames.len() {
        axes.column_mut(0).neg_mut();
    }
    let pose = |f: &Frame<P, D>| Frame { y: nearest_rotation(&(axes.transpose() * f.y)), t: axes.transpose() * f.t };
    frames.iter().map(pose).collect()
}

fn determinant<const D: usize>(m: &SMatrix<f64, D, D>) -> f64 {
    DMatrix::from_column_slice(D, D, m.as_slice()).determinant()
}

/// U·diag(1, …, det UVᵀ)·Vᵀ.
fn nearest_rotation<const D: usize>(m: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
    let svd = DMatrix::from_column_slice(D, D, m.as_slice()).svd(true, true);
    let (Some(mut u), Some(v_t)) = (svd.u, svd.v_t) else { return SMatrix::identity() };
    if (&u * &v_t).determinant() < 0.0 {
        u.column_mut(svd.singular_values.imin()).neg_mut();
    }
    SMatrix::from_column_slice((u * v_t).as_slice())
}
