//! False loop closures told from true ones.

use core::ops::ControlFlow;
use std::collections::HashSet;

use super::SolveSettings;
use super::problem::Problem;
use crate::graph::{
    FactorId, Graduation, GraphError, Initial, Initialisation, Iteration, Solution, SolveOptions,
};
use crate::pose_graph::PoseGraph;

/// The first estimate of a graduated solve: where nothing else is asked, one that no loop closure went into, if the rest of the
/// graph reaches every vertex.
///
/// # Errors
/// Those of the initialisation.
pub(super) fn first_estimate(
    graph: &PoseGraph,
    problem: &Problem,
    settings: &SolveSettings,
) -> Result<Initialisation, GraphError> {
    let usual = || problem.factors.initialise(&problem.values, settings.initial);
    if settings.initial != Initial::Auto {
        return usual();
    }
    let closes = graph.loop_closures();
    let mut place = 0;
    let mut trusted = || {
        place += 1;
        !closes[place - 1] // edges come first among the constraints, in this order
    };
    let mut rest = graph.clone();
    rest.edges2.retain(|_| trusted());
    rest.edges3.retain(|_| trusted());
    match Problem::new(&rest, settings) {
        // The same vertices have the same keys.
        Ok(rest) if rest.values.total() == problem.values.total() => {
            let start = rest.factors.initialise(&problem.values, Initial::Auto)?;
            match problem.factors.cost(&start.values) {
                Ok(_) => Ok(start),
                Err(_) => usual(),
            }
        }
        _ => usual(),
    }
}

/// Optimises with loop closures as suspects; returns the places, among [`PoseGraph::constraints`], of those rejected.
///
/// # Errors
/// Those of [`Graph::optimize_graduated`](crate::graph::Graph::optimize_graduated).
pub(super) fn optimise(
    graph: &PoseGraph,
    problem: &mut Problem,
    start: &Initialisation,
    (options, graduation): (&SolveOptions, Graduation),
    observer: &mut dyn FnMut(&Iteration) -> ControlFlow<()>,
) -> Result<(Solution, Vec<usize>), GraphError> {
    let closes = graph.loop_closures();
    let suspects: Vec<(usize, FactorId)> = (0..closes.len())
        .filter(|&place| closes[place])
        .filter_map(|place| Some((place, problem.ids[place]?)))
        .collect();
    let ids: Vec<FactorId> = suspects.iter().map(|&(_, id)| id).collect();
    let found =
        problem.factors.optimize_graduated_observed(&start.values, options, &ids, graduation, observer)?;
    let outliers: HashSet<FactorId> = found.rejected.iter().copied().collect();
    let rejected = suspects.iter().filter(|(_, id)| outliers.contains(id)).map(|&(place, _)| place);
    Ok((found.solution, rejected.collect()))
}
