//! How well the measurements agree with each other, and with the noise they claim.

use crate::graph::Graduation;
use crate::partition::Partition;
use crate::pose_graph::solve::{Misfit, SolveSettings, Solved, solve};
use crate::pose_graph::{Kind, PoseGraph, PoseGraphError};
use crate::uncertainty::ChiSquared;

/// Whether information matrices have the size that the residuals call for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// χ² per degree of freedom is as it should be, within a factor of [`Scale::TOLERATED`].
    Plausible,
    /// The measurements scatter more than they claim: σ is larger than stated.
    TooSure,
    /// They scatter less.
    TooUnsure,
    /// Nothing is measured more than once, so that nothing can be said.
    Unknown,
}

impl Scale {
    /// By how much χ² per degree of freedom may leave its band: noise is seldom known better than to a factor of √2.
    pub const TOLERATED: f64 = 2.0;

    /// For machines: `plausible`, `too_sure`, `too_unsure`, `unknown`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plausible => "plausible",
            Self::TooSure => "too_sure",
            Self::TooUnsure => "too_unsure",
            Self::Unknown => "unknown",
        }
    }

    fn of(chi2: f64, [low, high]: [f64; 2]) -> Self {
        match chi2 {
            x if x > Self::TOLERATED * high => Self::TooSure,
            x if x * Self::TOLERATED < low => Self::TooUnsure,
            _ => Self::Plausible,
        }
    }
}

/// How measurements of one kind fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KindFit {
    /// Their kind.
    pub kind: Kind,
    /// Whether they close loops.
    pub closes_loops: bool,
    /// How many; contradicting ones are left out.
    pub count: usize,
    /// χ² per expected χ². What is expected is the number of residuals times the graph's own ratio of redundancy: the estimate
    /// follows some kinds more than others, which is not told apart.
    pub ratio: f64,
    /// Where the ratio lies in 95 of 100 graphs with noise as stated, were the redundancy spread evenly.
    pub band: [f64; 2],
    /// What follows.
    pub scale: Scale,
}

/// How well the measurements fit at the optimum.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// χ² of all measurements but the contradicting ones.
    pub chi2: f64,
    /// Residuals less unknowns.
    pub dof: usize,
    /// Where χ² lies in 95 of 100 graphs with noise as stated; zeros without a degree of freedom.
    pub band: [f64; 2],
    /// Whether χ² is as the information matrices say.
    pub scale: Scale,
    /// The same by kind of measurement, loop closures apart.
    pub kinds: Vec<KindFit>,
    /// The measurements that fit worst, worst first, at most [`Fit::WORST`].
    pub worst: Vec<Misfit>,
    /// Loop closures that contradict all the rest, in groups that join the same two places.
    pub contradicting: Vec<Vec<Misfit>>,
}

impl Fit {
    /// Worst measurements named at most.
    pub const WORST: usize = 20;
}

/// Closures belong together where both their ends lie within so many poses of each other.
const NEAR: usize = 10;
/// Closures are said to contradict only where leaving them out brings χ² per degree of freedom below this.
const AGREEING: f64 = 2.0;

/// The fit, and the least-squares optimum.
///
/// # Errors
/// Those of [`solve`].
pub(super) fn fit(graph: &PoseGraph, settings: &SolveSettings) -> Result<(Fit, Solved), PoseGraphError> {
    let plain = solve(graph, settings)?;
    let all = judge(&plain);
    if all.scale != Scale::TooSure && all.chi2 <= all.band[1] {
        return Ok((all, plain));
    }
    let graduated = SolveSettings { graduation: Some(Graduation::default()), ..settings.clone() };
    let robust = solve(graph, &graduated)?;
    let kept = judge(&robust);
    let closures = graph.loop_closures().iter().filter(|closes| **closes).count();
    // Where information is stated too large, true closures are rejected as well, and what is left does not agree either.
    let tells = 2 * robust.rejected.len() <= closures + 1 && kept.chi2 < AGREEING * kept.dof as f64;
    if robust.rejected.is_empty() || !tells { Ok((all, plain)) } else { Ok((kept, robust)) }
}

fn judge(solved: &Solved) -> Fit {
    let closes = solved.graph.loop_closures();
    let mut kept = vec![true; closes.len()];
    solved.rejected.iter().for_each(|&place| kept[place] = false);
    let used: Vec<(Misfit, bool)> = solved
        .misfits()
        .zip(&closes)
        .zip(&kept)
        .filter(|((m, _), kept)| **kept && m.chi2.is_finite())
        .map(|((m, &closes), _)| (m, closes))
        .collect();
    let residuals: usize = used.iter().map(|(m, _)| m.dof).sum();
    let dof = residuals.saturating_sub(solved.report.unknowns);
    let band = ChiSquared::new(dof.max(1)).interval(0.95).unwrap_or_default();
    let chi2: f64 = used.iter().map(|(m, _)| m.chi2).sum();
    let (band, scale) = if dof == 0 { ([0.0; 2], Scale::Unknown) } else { (band, Scale::of(chi2, band)) };
    Fit {
        chi2,
        dof,
        band,
        scale,
        kinds: if dof == 0 { vec![] } else { by_kind(&used, dof, residuals) },
        worst: solved.worst(Fit::WORST),
        contradicting: groups(solved),
    }
}

/// `dof` degrees of freedom of all `total` residuals are spread evenly over the kinds.
fn by_kind(used: &[(Misfit, bool)], dof: usize, total: usize) -> Vec<KindFit> {
    let mut kinds = vec![];
    for kind in Kind::ALL {
        for closes_loops in [false, true] {
            let of = used.iter().filter(|(m, closes)| m.kind == kind && *closes == closes_loops);
            let (count, residuals, chi2) =
                of.fold((0, 0, 0.0), |(n, d, x), (m, _)| (n + 1, d + m.dof, x + m.chi2));
            let expected = residuals as f64 * dof as f64 / total as f64;
            if count == 0 {
                continue;
            }
            let usual = ChiSquared::new((residuals * dof / total).max(1)).interval(0.95).unwrap_or_default();
            let band = usual.map(|x| x / expected);
            let ratio = chi2 / expected;
            kinds.push(KindFit { kind, closes_loops, count, ratio, band, scale: Scale::of(ratio, band) });
        }
    }
    kinds
}

/// The rejected closures, grouped by the places they join, the largest group first.
fn groups(solved: &Solved) -> Vec<Vec<Misfit>> {
    let mut rejected = solved.rejected_closures();
    rejected.sort_by_key(|m| (m.from, m.to));
    let near = |a: u64, b: u64| a.abs_diff(b) <= NEAR as u64;
    let mut partition = Partition::new(rejected.len());
    for (i, a) in rejected.iter().enumerate() {
        for (j, b) in rejected.iter().enumerate().skip(i + 1).take_while(|(_, b)| near(a.from, b.from)) {
            if a.to.zip(b.to).is_some_and(|(a, b)| near(a, b)) {
                partition.join(i, j);
            }
        }
    }
    let mut groups: Vec<Vec<Misfit>> = vec![vec![]; rejected.len()];
    rejected.iter().enumerate().for_each(|(i, m)| groups[partition.find(i)].push(*m));
    groups.retain(|group| !group.is_empty());
    groups.sort_by_key(|group| core::cmp::Reverse(group.len()));
    groups
}
