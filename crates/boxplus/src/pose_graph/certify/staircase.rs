//! Test, leave through the next dimension, come back, test again.

use nalgebra::{DMatrix, SMatrix, SVector, SymmetricEigen};

use super::Verdict;
use super::descent::{Watch, descend, minimise};
use super::quadratic::{Frame, Layout, Link, cost, dual, multipliers, slopes};
use super::spectrum::{Lowest, Shifted};
use crate::graph::GraphError;

/// An estimate is optimal when none can be better by more than this part of its cost.
const TIGHT: f64 = 1e-6;
/// Share of the largest diagonal entry of S below which an eigenvalue is rounding.
const ROUNDING: f64 = 1e-15;
/// Relative decrease at which a minimum is reached: a dual bound is as good as the estimate is stationary.
const FINE: f64 = 1e-14;
/// Until it is known which minimum this is.
const SETTLED: f64 = 1e-6;
/// Until the way is clear.
const COARSE: f64 = 1e-3;
/// A gap beyond this part of the cost is no matter of convergence.
const FAR: f64 = 0.05;
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

/// Settles `given` in its minimum, and leaves it for a lower one as long as there is a way, through P = D + 1 and
/// Q = D + 2 dimensions.
///
/// # Errors
/// [`GraphError::OutOfMemory`].
pub(super) fn climb<const D: usize, const P: usize, const Q: usize>(
    links: &[Link<D>],
    given: &[Frame<D, D>],
    watch: &mut Watch<'_>,
) -> Result<Climb<D>, GraphError> {
    let layout = Layout::new(links, given.len(), D + 1)?;
    // A minimum far above its bound need not be known to the last digit before it is left.
    let mut frames = minimise(links, given, SETTLED, watch)?;
    let mut judged = judge(links, &layout, &frames)?;
    if judged.cost - judged.lower_bound < FAR * judged.cost {
        frames = minimise(links, &frames, FINE, watch)?;
        judged = judge(links, &layout, &frames)?;
    }
    let (given, given_cost) = (judged.verdict(), judged.cost);
    let left_open = judged.lowest.as_ref().filter(|_| given == Verdict::NotOptimal);
    let descent = left_open.map(|lowest| (lowest.eigenvalue, most_turned::<D>(&layout, lowest)));
    let (mut lower_bound, mut escapes) = (judged.lower_bound, 0);
    while let (Verdict::NotOptimal, Some(lowest), true) =
        (judged.verdict(), &judged.lowest, escapes < ESCAPES)
    {
        // First in a hurry: a rough minimum one dimension up often leads straight to a better one below.
        let start = descend::<D, P, D>(&frames, |pose| part(&layout, lowest, pose), |x| cost(links, x));
        let rough = minimise(links, &start, COARSE, watch)?;
        let mut settled = minimise(links, &round(&rough), FINE, watch)?;
        if !watch.stopped && !is_lower(cost(links, &settled), judged.cost) {
            let above = minimise(links, &rough, FINE, watch)?;
            let test = judge(links, &layout, &above)?;
            lower_bound = lower_bound.max(test.lower_bound);
            settled = minimise(links, &round(&above), FINE, watch)?;
            if let (false, Some(lowest)) = (is_lower(cost(links, &settled), judged.cost), &test.lowest) {
                let part = |pose| part(&layout, lowest, pose);
                let start = descend::<P, Q, D>(&above, part, |x| cost(links, x));
                let top = minimise(links, &start, FINE, watch)?;
                lower_bound = lower_bound.max(judge(links, &layout, &top)?.lower_bound);
                settled = minimise(links, &round(&top), FINE, watch)?;
            }
        }
        if watch.stopped || !is_lower(cost(links, &settled), judged.cost) {
            break; // the relaxation is lower, but what it says of poses is not
        }
        frames = settled;
        judged = judge(links, &layout, &frames)?;
        escapes += 1;
    }
    // A bound holds wherever it was found; what is left of a way down leads to no better poses.
    judged.lower_bound = judged.lower_bound.max(lower_bound);
    judged.lowest = None;
    Ok(Climb { frames, given, given_cost, descent, best: judged, escapes })
}

fn is_lower(new: f64, old: f64) -> bool {
    new < old * (1.0 - LOWER)
}

/// Tests an estimate of any rank.
fn judge<const P: usize, const D: usize>(
    links: &[Link<D>],
    layout: &Layout,
    frames: &[Frame<P, D>],
) -> Result<Judgement, GraphError> {
    let multipliers = multipliers(frames, &slopes(links, frames));
    let trace: f64 = multipliers.iter().map(SMatrix::trace).sum();
    let mut matrix = dual(layout, links, &multipliers);
    for &pose in &layout.anchors {
        // Whatever is added here is paid by moving the whole part, which is free: S stays as definite as it was.
        let diagonal = layout.block(pose, pose)(D, D);
        matrix[diagonal] *= 2.0;
    }
    let rotations = (0..frames.len()).flat_map(|pose| (0..D).map(move |a| layout.row(pose) + a));
    let mut shifted = Shifted::new(&layout.pattern, &matrix, rotations.collect())?;
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

/// What an eigenvector does to a pose: D numbers turn it into the new dimension, one moves it.
fn part<const D: usize>(layout: &Layout, lowest: &Lowest, pose: usize) -> (SVector<f64, D>, f64) {
    let row = layout.row(pose);
    (SVector::from_column_slice(&lowest.vector[row..row + D]), lowest.vector[row + D])
}

/// The poses, those that an eigenvector turns most first.
fn most_turned<const D: usize>(layout: &Layout, lowest: &Lowest) -> Vec<usize> {
    let turn = |pose: &usize| part::<D>(layout, lowest, *pose).0.norm();
    let mut poses: Vec<usize> = (0..layout.count()).collect();
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
    let pose =
        |f: &Frame<P, D>| Frame { y: nearest_rotation(&(axes.transpose() * f.y)), t: axes.transpose() * f.t };
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
