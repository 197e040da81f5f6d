//! A first estimate for the search of false loop closures: the map as it grew.
//!
//! Integrated over a whole drive, odometry is wrong by as much as the map is wide, and any false closure may be true. But no
//! closure was met with a whole drive's drift: the map was closed many times before. So the drive is gone through
//! again, a piece at a time. A closure of the new piece is believed possible if it is no surprise beside the drift since the
//! map was last closed; those possible are told from each other by graduated non-convexity, which now starts from small
//! residuals; and the corrected map is what the next piece is held against.
//!
//! Many files state far more noise than they have. A surprise is therefore measured in the noise that the closures accepted so
//! far show, never in more than is stated. That only guides the search: what is false in the end is judged by the stated noise.

use core::ops::{ControlFlow, Range};
use std::collections::{HashMap, HashSet};

use super::super::problem::{Problem, with_values};
use super::super::{PoseGraphError, SolveSettings};
use super::Suspects;
use super::track::{Link, Net, Track};
use crate::graph::{FactorId, Graduated, Graduation, Iteration, Pace, SolveOptions};
use crate::lie::{LieGroup, SE2, SE3};
use crate::pose_graph::ids::Ids;
use crate::pose_graph::{PoseGraph, Vertex};
use crate::uncertainty::ChiSquared;

/// Pieces of a long drive: the drift within one is what closures are held against.
const PIECES: usize = 32;
/// Poses of the shortest piece.
const SHORTEST: usize = 8;
/// Share of true closures that are no surprise, where the noise is as stated.
const POSSIBLE: f64 = 0.999;
/// By how much the control falls from stage to stage: what comes after corrects what is missed here.
const STEP: f64 = 3.0;
/// What a piece may leave of its cost to gain, and the trial steps after its stages.
const PIECE: (f64, usize) = (1e-4, 30);
/// With this probability the noise is not less than what is believed.
const NOT_LESS: f64 = 0.99;
/// No file is believed to have less than this share of its stated variance: what is left is rounding.
const LEAST_NOISE: f64 = 1e-6;

/// The map, and what is believed of its closures.
struct Map<'a> {
    graph: PoseGraph,
    settings: SolveSettings,
    graduation: Graduation,
    ids: Ids,
    flat: Track<SE2, 3>,
    spatial: Track<SE3, 6>,
    /// Which constraints are loop closures.
    closes: &'a [bool],
    /// Closures that were possible when they were met, as places among the constraints.
    possible: HashSet<usize>,
    /// Those of them that agree with the map.
    accepted: HashSet<usize>,
    /// The variance seen as a share of that stated.
    noise: f64,
}

/// Grows the map of `graph`, whose vertices are at an estimate that no closure went into. Returns it with its vertices moved.
///
/// # Errors
/// Those of the solver.
pub(super) fn grown(
    graph: PoseGraph,
    closes: &[bool],
    (settings, graduation): (&SolveSettings, Graduation),
    observer: &mut dyn FnMut(&Iteration) -> ControlFlow<()>,
) -> Result<PoseGraph, PoseGraphError> {
    let poses = graph.poses2.iter().map(|v| v.id).chain(graph.poses3.iter().map(|v| v.id));
    let ids = Ids::new(poses);
    let mut map = Map {
        flat: Track::new(&graph.edges2, 0, &ids, settings.indefinite),
        spatial: Track::new(&graph.edges3, graph.edges2.len(), &ids, settings.indefinite),
        settings: settings.clone(),
        graduation,
        graph,
        closes,
        possible: HashSet::new(),
        accepted: HashSet::new(),
        noise: 1.0,
        ids,
    };
    // The whole graph has what the user fixes; a part of it need not.
    map.graph.fixed.append(&mut map.settings.fixed);
    let count = map.ids.len();
    let pieces = (count / SHORTEST).clamp(1, PIECES);
    let mut begin = 0;
    for piece in 1..=pieces {
        let end = count * piece / pieces;
        let met = map.meet(begin..end);
        begin = end;
        if met && map.close(end, observer)?.is_break() {
            break;
        }
    }
    Ok(map.graph)
}

impl Map<'_> {
    /// Takes note of the closures whose later pose is in a piece and which are no surprise; whether there are any.
    fn meet(&mut self, piece: Range<usize>) -> bool {
        let mut fresh = possible(&self.flat, &self.graph.poses2, (self, &piece));
        fresh.extend(possible(&self.spatial, &self.graph.poses3, (self, &piece)));
        self.possible.extend(&fresh);
        !fresh.is_empty()
    }

    /// Optimises the poses before `end` with the closures that are possible.
    fn close(
        &mut self,
        end: usize,
        observer: &mut dyn FnMut(&Iteration) -> ControlFlow<()>,
    ) -> Result<ControlFlow<()>, PoseGraphError> {
        let (part, places) = self.part(end);
        let mut problem = Problem::new(&part, &self.settings)?;
        let suspects =
            Suspects::new(&problem, |k| places.get(k).copied().filter(|&place| self.closes[place]));
        let start = problem.values.clone();
        let usual = &self.settings.options;
        let options = SolveOptions {
            relative_cost: PIECE.0.max(usual.relative_cost),
            max_iterations: PIECE.1.min(usual.max_iterations),
            ..usual.clone()
        };
        let mut flow = ControlFlow::Continue(());
        let found = problem.factors.optimize_graduated_at(
            &start,
            &options,
            &suspects.ids(),
            (self.graduation, Pace { step: STEP, noise: self.noise, ..Pace::default() }),
            &mut |iteration| {
                flow = observer(iteration);
                flow
            },
        )?;
        self.accepted = suspects.0.iter().map(|&(place, _)| place).collect();
        for place in suspects.places(&found.rejected) {
            self.accepted.remove(&place);
        }
        self.noise = noise(&problem, &found);
        let solved = with_values(&part, &found.solution.values);
        carry(&mut self.graph.poses2, &solved.poses2, &self.graph.fixed);
        carry(&mut self.graph.poses3, &solved.poses3, &self.graph.fixed);
        replace(&mut self.graph.points2, &solved.points2);
        replace(&mut self.graph.points3, &solved.points3);
        Ok(flow)
    }

    /// The graph of the poses before `end`, with the closures that are possible, and the place in the whole of each edge: they
    /// are the first of its constraints.
    fn part(&self, end: usize) -> (PoseGraph, Vec<usize>) {
        let known = |id: u64| self.ids.index(id).is_none_or(|rank| rank < end); // points have no rank
        let mut part = self.graph.clone();
        part.poses2.retain(|v| known(v.id));
        part.poses3.retain(|v| known(v.id));
        let (mut place, mut places) = (0, vec![]);
        let mut keep = |from, to| {
            let kept = known(from) && known(to) && (!self.closes[place] || self.possible.contains(&place));
            if kept {
                places.push(place);
            }
            place += 1;
            kept
        };
        part.edges2.retain(|e| keep(e.from, e.to));
        part.edges3.retain(|e| keep(e.from, e.to));
        part.sightings2.retain(|e| known(e.from));
        part.sightings3.retain(|e| known(e.from));
        part.bearings2.retain(|e| known(e.from));
        part.ranges.retain(|e| known(e.from) && known(e.to));
        part.priors2.retain(|p| known(p.id));
        part.priors3.retain(|p| known(p.id));
        (part, places)
    }
}

/// An upper bound of the variance that all but the rejected measurements show, as a share of that stated.
fn noise(problem: &Problem, found: &Graduated) -> f64 {
    let (values, unknowns) = (&found.solution.values, found.solution.report.unknowns);
    let rejected: HashSet<FactorId> = found.rejected.iter().copied().collect();
    let kept = problem.ids.iter().flatten().filter(|id| !rejected.contains(id));
    let (mut chi2, mut residuals) = (0.0, 0usize);
    for &id in kept {
        chi2 += problem.factors.squared_error(id, values).unwrap_or(0.0);
        residuals += problem.factors.residual_dim(id).unwrap_or(0);
    }
    let least = residuals
        .checked_sub(unknowns)
        .filter(|dof| *dof > 0)
        .and_then(|dof| ChiSquared::new(dof).quantile(1.0 - NOT_LESS).ok());
    least.map_or(1.0, |least| (chi2 / least).clamp(LEAST_NOISE, 1.0))
}

/// The places of the loops of a track that end in a piece and are no surprise, or of which nothing is known.
fn possible<G: LieGroup<D, Scalar = f64>, const D: usize>(
    track: &Track<G, D>,
    poses: &[Vertex<G>],
    (map, piece): (&Map<'_>, &Range<usize>),
) -> Vec<usize> {
    let fresh: Vec<&Link<G, D>> = track.loops.iter().filter(|link| piece.contains(&link.later())).collect();
    if fresh.is_empty() {
        return vec![];
    }
    let accepted = track.loops.iter().filter(|link| map.accepted.contains(&link.place));
    let net = Net::new(poses, &map.ids, track.steps.iter().chain(accepted));
    let bound = ChiSquared::new(D).quantile(POSSIBLE).unwrap_or(f64::INFINITY) * map.noise;
    let likely = fresh.into_iter().filter(|link| net.surprise(link).is_none_or(|d2| d2 <= bound));
    likely.map(|link| link.place).collect()
}

/// Takes over the poses that were solved, and moves those not yet reached along with the last of them.
fn carry<G: LieGroup<D, Scalar = f64>, const D: usize>(
    poses: &mut [Vertex<G>],
    solved: &[Vertex<G>],
    fixed: &[u64],
) {
    let new: HashMap<u64, G> = solved.iter().map(|v| (v.id, v.value)).collect();
    let Some(last) = poses.iter().filter(|v| new.contains_key(&v.id)).max_by_key(|v| v.id) else { return };
    let correction = new[&last.id].compose(&last.value.inverse());
    for vertex in poses.iter_mut().filter(|v| !fixed.contains(&v.id)) {
        vertex.value = new.get(&vertex.id).copied().unwrap_or_else(|| correction.compose(&vertex.value));
    }
}

fn replace<T: Clone>(points: &mut [Vertex<T>], solved: &[Vertex<T>]) {
    points.iter_mut().zip(solved).for_each(|(point, solved)| point.value = solved.value.clone());
}
