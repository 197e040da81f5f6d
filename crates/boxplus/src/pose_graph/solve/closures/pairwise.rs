//! Loop closures that agree with each other, two by two: pairwise consistency maximisation. Mangelson et al. (2018).
//!
//! Two closures Z_ij, Z_kl and the odometry between their ends go round a loop, from i to j to l and back over k. If both are true,
//!
//! ```text
//! ε = (T_ki · Z_ij · T_jl) ⊟ Z_kl,   d² = εᵀS⁻¹ε,   S = Σ_jl + Ad Σ_ij Adᵀ + Ad Σ_ki Adᵀ + Σ_kl  (each brought to l)
//! ```
//! is χ² with as many degrees of freedom as a displacement has. True closures agree with each other; false ones agree with few. The largest set in which every two agree is the
//! maximum clique of a graph, and is kept.
//!
//! Pitfalls: it looks at odometry only, so that after a long drive everything agrees with everything; and it asks all pairs
//! to agree, so that among many true closures some are lost by chance.

use super::clique::Consistency;
use super::track::{Chain, Link, Track};
use crate::lie::LieGroup;
use crate::uncertainty::ChiSquared;

/// How pairwise consistency is judged. See [`SolveSettings::pairwise`](super::super::SolveSettings::pairwise).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pairwise {
    /// Share of the pairs of true closures that are found to agree, 0…1: d² is at most this quantile of χ².
    pub confidence: f64,
    /// Candidates that the search for the largest set may colour, a measure of time that does not depend on the machine; some
    /// 10⁷ a second. When it is spent, the largest set found counts.
    pub effort: usize,
}

impl Default for Pairwise {
    fn default() -> Self {
        Self { confidence: 0.9999, effort: 20_000_000 }
    }
}

/// What pairwise consistency kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Selection {
    /// Loop closures that were looked at.
    pub closures: usize,
    /// Those kept.
    pub kept: usize,
    /// Whether it is certain that no larger set agrees; otherwise it is the largest that was found.
    pub is_largest: bool,
}

/// The places of the loops that do not agree, in increasing order, and what is to be said of the others.
pub(super) fn select<G: LieGroup<D, Scalar = f64>, const D: usize>(
    track: &Track<G, D>,
    count: usize,
    settings: Pairwise,
) -> (Vec<usize>, Selection) {
    let chain = Chain::new(&track.steps, count);
    let bound = ChiSquared::new(D).quantile(settings.confidence).unwrap_or(f64::INFINITY);
    let mut consistency = Consistency::new(track.loops.len());
    for (b, second) in track.loops.iter().enumerate() {
        for (a, first) in track.loops[..b].iter().enumerate() {
            // Of what no odometry joins nothing is known: it contradicts nothing.
            if disagreement(&chain, first, second).is_none_or(|d2| d2 <= bound) {
                consistency.join(a, b);
            }
        }
    }
    let clique = consistency.clique(settings.effort);
    let agrees = |k: &usize| clique.members.binary_search(k).is_ok();
    let dropped = (0..track.loops.len()).filter(|k| !agrees(k)).map(|k| track.loops[k].place).collect();
    let kept = clique.members.len();
    (dropped, Selection { closures: track.loops.len(), kept, is_largest: clique.is_largest })
}

/// d² of two closures; none where odometry does not join their ends.
fn disagreement<G: LieGroup<D, Scalar = f64>, const D: usize>(
    chain: &Chain<G, D>,
    first: &Link<G, D>,
    second: &Link<G, D>,
) -> Option<f64> {
    let ([i, j], [k, l]) = (first.ends, second.ends);
    let (k_from_i, before) = chain.between(k, i)?;
    let (j_from_l, after) = chain.between(j, l)?;
    let i_from_l = first.measured.compose(&j_from_l);
    let error = k_from_i.compose(&i_from_l).rminus(&second.measured);
    let (from_i, from_j) = (i_from_l.inverse().adjoint(), j_from_l.inverse().adjoint());
    let spread = after
        + from_j * first.covariance * from_j.transpose()
        + from_i * before * from_i.transpose()
        + second.covariance;
    Some(error.dot(&spread.cholesky()?.solve(&error)))
}
