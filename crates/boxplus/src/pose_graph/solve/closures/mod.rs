//! False loop closures told from true ones. Odometry, sightings and priors are trusted.

mod clique;
mod grow;
mod pairwise;
mod track;

use core::ops::ControlFlow;
use std::collections::HashSet;

pub use pairwise::{Pairwise, Selection};

use super::problem::{Problem, with_values};
use super::{PoseGraphError, SolveSettings};
use crate::graph::{
    FactorId, Graduation, GraphError, Growth, Initial, Initialisation, Iteration, Kernel, Pace, Solution,
    SolveOptions, Values,
};
use crate::pose_graph::PoseGraph;
use crate::pose_graph::ids::Ids;
use track::Track;

/// Switchable constraints: every loop closure has a switch s ∈ [0, 1] by which its residual is multiplied, and which is
/// measured to be 1. Sünderhauf & Protzel (2012).
///
/// ```text
/// min over s of s²χ² + c²(1 − s)²   is   c²χ²/(c² + χ²)   at   s = c²/(c² + χ²)
/// ```
/// so the switches are eliminated in closed form rather than estimated beside the poses: what is left of a closure is
/// [`Kernel::GemanMcClure`] with scale c, and the minima are the same. (Dynamic covariance scaling, [`Kernel::Dcs`], is a neighbour: its weight is bounded by 1 where χ² ≤ c².)
/// A closure is false where its switch is nearer to 0: χ² > c². There is no graduation: what is found depends on the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Switches {
    /// c, in standard deviations: Ξ = c² is the information of the switch's prior. `None` is what one true closure in a
    /// hundred exceeds, as in [`Graduation::scale`].
    pub scale: Option<f64>,
}

/// What became of a search for false closures.
pub(super) struct Found {
    pub(super) solution: Solution,
    /// The false closures, as places among the constraints, in increasing order.
    pub(super) rejected: Vec<usize>,
    /// What pairwise consistency kept, where it was asked.
    pub(super) selection: Option<Selection>,
}

/// Where to start, and whether no loop closure went into it.
pub(super) struct Start {
    pub(super) initialisation: Initialisation,
    untouched: bool,
}

/// Beyond (1 + this)·c² a closure does not pull at a start near the truth. A true one drifts farther only where nothing else holds it.
const DISTANT: f64 = 100.0;

/// Loop closures as factors: the place of each among the constraints of the whole graph, and its factor.
struct Suspects(Vec<(usize, FactorId)>);

impl Suspects {
    /// `place` says of the k-th constraint of the problem's own graph where it is in the whole, if it is a closure.
    fn new(problem: &Problem, place: impl Fn(usize) -> Option<usize>) -> Self {
        let factors = problem.ids.iter().enumerate();
        Self(factors.filter_map(|(k, &id)| Some((place(k)?, id?))).collect())
    }

    fn ids(&self) -> Vec<FactorId> {
        self.0.iter().map(|&(_, id)| id).collect()
    }

    /// The places of some of the factors.
    fn places(&self, of: &[FactorId]) -> Vec<usize> {
        let of: HashSet<FactorId> = of.iter().copied().collect();
        self.0.iter().filter(|(_, id)| of.contains(id)).map(|&(place, _)| place).collect()
    }
}

impl SolveSettings {
    /// Whether loop closures are under suspicion.
    pub(super) fn doubts_closures(&self) -> bool {
        self.graduation.is_some() || self.switches.is_some() || self.pairwise.is_some()
    }
}

/// The first estimate of a search: where nothing else is asked, one that no loop closure went into, if the rest of the graph
/// reaches every vertex.
///
/// # Errors
/// Those of the initialisation.
pub(super) fn first_estimate(
    graph: &PoseGraph,
    problem: &Problem,
    settings: &SolveSettings,
    observer: &mut dyn FnMut(Growth) -> ControlFlow<()>,
) -> Result<Start, GraphError> {
    let mut usual = || {
        let initialisation =
            problem.factors.initialise_observed(&problem.values, settings.initial, observer)?;
        Ok(Start { initialisation, untouched: false })
    };
    if settings.initial != Initial::Auto || !settings.doubts_closures() {
        return usual();
    }
    let closes = graph.loop_closures();
    match Problem::new(&keeping(graph, |place| !closes[place]), settings) {
        // The same vertices have the same keys.
        Ok(rest) if rest.values.total() == problem.values.total() => {
            match rest.factors.initialise(&problem.values, Initial::Auto) {
                Ok(initialisation) if problem.factors.cost(&initialisation.values).is_ok() => {
                    Ok(Start { initialisation, untouched: true })
                }
                _ => usual(),
            }
        }
        _ => usual(),
    }
}

/// Optimises with loop closures as suspects.
///
/// # Errors
/// Those of [`Graph::optimize_graduated`](crate::graph::Graph::optimize_graduated) and of building the graph without what is rejected.
pub(super) fn search(
    graph: &PoseGraph,
    start: &Start,
    (settings, options): (&SolveSettings, &SolveOptions),
    observer: &mut dyn FnMut(&Iteration) -> ControlFlow<()>,
) -> Result<Found, PoseGraphError> {
    let whole = with_values(graph, &start.initialisation.values); // every vertex is in it
    let closes = whole.loop_closures();
    let selected = settings.pairwise.map(|pairwise| select(&whole, settings, pairwise));
    let (dropped, selection) = selected.unzip();
    let dropped = dropped.unwrap_or_default();
    let kept = keeping(&whole, |place| dropped.binary_search(&place).is_err());
    let places: Vec<usize> =
        (0..closes.len()).filter(|place| dropped.binary_search(place).is_err()).collect();
    let mut problem = Problem::new(&kept, settings)?;
    let suspects = Suspects::new(&problem, |k| closes[places[k]].then_some(places[k]));
    let mut flow = ControlFlow::Continue(());
    let mut watch = |iteration: &Iteration| {
        // Once stopped, whatever comes next stops too.
        flow = if flow.is_break() { flow } else { observer(iteration) };
        flow
    };
    let (solution, mut rejected) = if let Some(graduation) = settings.graduation {
        let settings = SolveSettings { options: options.clone(), ..settings.clone() };
        graduated(kept, &mut problem, (&suspects, start.untouched), (&settings, graduation), &mut watch)?
    } else if let Some(switches) = settings.switches {
        switched(&mut problem, &suspects, options, switches, &mut watch)?
    } else {
        let start = problem.factors.initialise(&problem.values, settings.initial)?;
        (problem.factors.optimize_observed(&start.values, options, &mut watch)?, vec![])
    };
    rejected.extend(dropped);
    rejected.sort_unstable();
    Ok(Found { solution, rejected, selection })
}

/// Graduated non-convexity: from the map as it grew where the start is odometry, else as published.
fn graduated(
    graph: PoseGraph,
    problem: &mut Problem,
    (suspects, untouched): (&Suspects, bool),
    (settings, graduation): (&SolveSettings, Graduation),
    observer: &mut dyn FnMut(&Iteration) -> ControlFlow<()>,
) -> Result<(Solution, Vec<usize>), PoseGraphError> {
    let (mut start, mut pace) = (problem.values.clone(), Pace::default());
    if untouched && settings.options.max_iterations > 0 {
        let closes = graph.loop_closures();
        let grown = grow::grown(graph, &closes, (settings, graduation), observer)?;
        start = Problem::new(&grown, settings)?.values;
        pace.most = DISTANT;
    }
    let found = problem.factors.optimize_graduated_at(
        &start,
        &settings.options,
        &suspects.ids(),
        (graduation, pace),
        observer,
    )?;
    Ok((found.solution, suspects.places(&found.rejected)))
}

/// Switchable constraints, their switches eliminated.
fn switched(
    problem: &mut Problem,
    suspects: &Suspects,
    options: &SolveOptions,
    switches: Switches,
    observer: &mut dyn FnMut(&Iteration) -> ControlFlow<()>,
) -> Result<(Solution, Vec<usize>), PoseGraphError> {
    let bound = Graduation { scale: switches.scale, ..Graduation::default() };
    let bound = |problem: &Problem, id| problem.factors.residual_dim(id).map(|dof| bound.bound(dof));
    for id in suspects.ids() {
        if let Some(bound) = bound(problem, id) {
            problem.factors.set_kernel_of(id, Kernel::GemanMcClure(bound.sqrt()));
        }
    }
    let start: Values = problem.values.clone();
    let solution = problem.factors.optimize_observed(&start, options, observer)?;
    let off = |&id: &FactorId| problem.factors.squared_error(id, &solution.values) > bound(problem, id);
    let rejected: Vec<FactorId> = suspects.ids().into_iter().filter(off).collect();
    Ok((solution, suspects.places(&rejected)))
}

/// The closures that do not agree with the others, as places among the constraints, in increasing order.
fn select(graph: &PoseGraph, settings: &SolveSettings, pairwise: Pairwise) -> (Vec<usize>, Selection) {
    let ids = Ids::new(graph.poses2.iter().map(|v| v.id).chain(graph.poses3.iter().map(|v| v.id)));
    let flat = Track::new(&graph.edges2, 0, &ids, settings.indefinite);
    let spatial = Track::new(&graph.edges3, graph.edges2.len(), &ids, settings.indefinite);
    let (mut dropped, flat) = pairwise::select(&flat, ids.len(), pairwise);
    let (more, spatial) = pairwise::select(&spatial, ids.len(), pairwise);
    dropped.extend(more); // edges in space come after those in the plane
    let selection = Selection {
        closures: flat.closures + spatial.closures,
        kept: flat.kept + spatial.kept,
        is_largest: flat.is_largest && spatial.is_largest,
    };
    (dropped, selection)
}

/// The graph with those of its edges between poses, by their places among the constraints, that are to be kept.
pub(super) fn keeping(graph: &PoseGraph, keep: impl Fn(usize) -> bool) -> PoseGraph {
    let (mut kept, mut place) = (graph.clone(), 0);
    let mut next = || {
        place += 1;
        keep(place - 1) // edges come first among the constraints, in this order
    };
    kept.edges2.retain(|_| next());
    kept.edges3.retain(|_| next());
    kept
}
