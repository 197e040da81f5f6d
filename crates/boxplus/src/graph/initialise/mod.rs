//! Where to start: as given, along a spanning tree, or by the chordal relaxation.
//!
//! Pose graphs have local minima. A start that ignores the nonlinearity of rotations lands near the global one far more
//! often than the poses that odometry leaves in a file. Relative poses ([`Between`] of SE(2) and SE(3), in any chart)
//! place the poses; sightings then place the landmarks that have no value.

mod chordal;
mod edges;
mod grow;
mod inertial;
mod landmarks;
mod spanning_tree;

use core::fmt;
use core::ops::ControlFlow;

use super::set::AnySet;
use super::values::State;
use super::{FactorId, Graph, GraphError, Key, Values, gauge};
use crate::lie::{Rn, SE2, SE3};
use edges::{Edge, Pose};
pub use grow::Growth;
use grow::Landmarks;
pub use inertial::inertial_start;
use landmarks::Observer;

/// How the first estimate is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Initial {
    /// Whichever of the others has the lowest cost. A map is grown where landmarks are seen by distance or direction, or at
    /// places, while no other start costs as little as noise alone would leave.
    #[default]
    Auto,
    /// The values as they are.
    AsGiven,
    /// Measurements chained along a breadth-first tree from what is held, else from the surest prior, else from the first
    /// pose.
    SpanningTree,
    /// Rotations by linear least squares over all matrices, projected to SO(n); then positions by linear least squares.
    /// Martinec & Pajdla (2007); Carlone, Tron, Daniilidis & Dellaert (2015). Rotations are weighed by SE-Sync's isotropic κ, positions by the full
    /// information of the translation.
    Chordal,
    /// The map as it grew, piece by piece, each optimised with the landmarks seen so far before the next is joined on: for loops that
    /// close through landmarks, of which relative poses know nothing.
    Grown,
}

impl Initial {
    /// A name for machines: `"spanning_tree"`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::AsGiven => "as_given",
            Self::SpanningTree => "spanning_tree",
            Self::Chordal => "chordal",
            Self::Grown => "grown",
        }
    }
}

impl fmt::Display for Initial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Auto => "automatic",
            Self::AsGiven => "as given",
            Self::SpanningTree => "spanning tree",
            Self::Chordal => "chordal",
            Self::Grown => "grown",
        })
    }
}

/// A first estimate, and what it was chosen from.
#[derive(Clone, Debug)]
pub struct Initialisation {
    /// The first estimate: every variable that a factor reads has a value.
    pub values: Values,
    /// The way it was made.
    pub chosen: Initial,
    /// The cost of each candidate that was tried.
    pub costs: Vec<(Initial, f64)>,
}

impl Initialisation {
    /// The cost of the first estimate.
    pub fn cost(&self) -> f64 {
        self.costs.iter().find(|(initial, _)| *initial == self.chosen).map_or(f64::NAN, |&(_, cost)| cost)
    }
}

impl Graph {
    /// Makes a first estimate. Held variables stay where they are; so do variables that no relative pose or sighting
    /// reaches.
    ///
    /// # Errors
    /// [`GraphError::MissingValues`] where a variable still has none, or a held one had none; those of [`Graph::cost`];
    /// [`GraphError::ResidualNotFinite`] for a measurement that is not finite; [`GraphError::IllConditioned`] and
    /// [`GraphError::OutOfMemory`] from the chordal relaxation. The automatic choice passes over candidates that fail.
    pub fn initialise(&self, values: &Values, initial: Initial) -> Result<Initialisation, GraphError> {
        self.initialise_observed(values, initial, &mut |_| ControlFlow::Continue(()))
    }

    /// As [`Self::initialise`]; `observer` sees a growing map ([`Initial::Grown`]), and may stop it: then the rest of the poses are
    /// chained to what has grown.
    ///
    /// # Errors
    /// As [`Self::initialise`].
    pub fn initialise_observed(
        &self,
        values: &Values,
        initial: Initial,
        observer: &mut dyn FnMut(Growth) -> ControlFlow<()>,
    ) -> Result<Initialisation, GraphError> {
        let candidates: &[Initial] = match initial {
            Initial::Auto => &[Initial::AsGiven, Initial::SpanningTree, Initial::Chordal, Initial::Grown],
            _ => &[initial],
        };
        let held_without_value = self
            .check_keys(values)?
            .into_iter()
            .find(|&(id, state)| state == State::Declared && values.is_held(id));
        if let Some((id, _)) = held_without_value {
            return Err(GraphError::MissingValues { variables: vec![values.name(id)] });
        }
        let mut best: Option<(Initial, Values, f64)> = None;
        let (mut costs, mut failed, mut tree) = (vec![], None, None);
        for &candidate in candidates {
            let lowest = best.as_ref().map_or(f64::INFINITY, |&(_, _, cost)| cost);
            if (initial, candidate) == (Initial::Auto, Initial::Grown) && !self.is_worth_growing(lowest) {
                continue;
            }
            match self.candidate(values, candidate, &mut tree, observer) {
                Ok((start, cost)) => {
                    costs.push((candidate, cost));
                    if best.as_ref().is_none_or(|(_, _, lowest)| cost < *lowest || !lowest.is_finite()) {
                        best = Some((candidate, start, cost));
                    }
                }
                Err(error) => failed = Some(error),
            }
        }
        match (best, failed) {
            (Some((chosen, values, _)), _) => Ok(Initialisation { values, chosen, costs }),
            (None, Some(error)) => Err(error),
            (None, None) => unreachable!("there is a candidate, and it is kept or fails"),
        }
    }

    /// Whether a map can be expected to start better where it is grown than at the cost of the best other start.
    fn is_worth_growing(&self, lowest: f64) -> bool {
        match Landmarks::of(self) {
            Landmarks::None => false,
            Landmarks::Ambiguous => true,
            // At the truth, noise as stated leaves ½ for each residual, on average.
            Landmarks::Seen => {
                let residuals: usize = self.sets.iter().map(|set| set.len() * set.residual_dim()).sum();
                lowest > 0.5 * residuals as f64
            }
        }
    }

    /// One first estimate and its cost.
    fn candidate(
        &self,
        values: &Values,
        initial: Initial,
        tree: &mut Option<Tree>,
        observer: &mut dyn FnMut(Growth) -> ControlFlow<()>,
    ) -> Result<(Values, f64), GraphError> {
        let start = match initial {
            Initial::SpanningTree => self.tree(values, tree)?.values.clone(),
            Initial::Chordal => self.chordal(self.tree(values, tree)?)?,
            Initial::Grown => {
                let mut start = values.clone();
                self.place_at_priors(&mut start);
                grow::grow(self, &start, observer)?
            }
            Initial::Auto | Initial::AsGiven => values.clone(),
        };
        let cost = self.cost(&start)?;
        Ok((start, cost))
    }

    /// The values along a spanning tree, and from where it grew, made once.
    fn tree<'a>(&self, values: &Values, tree: &'a mut Option<Tree>) -> Result<&'a Tree, GraphError> {
        if let Some(tree) = tree {
            return Ok(tree);
        }
        let mut rooted = values.clone();
        let gauge = gauge::fix(&self.sets, &mut rooted);
        let not_finite = |factor| self.not_finite(factor, values);
        let (edges2, edges3) = (SE2::edges(&self.sets), SE3::edges(&self.sets));
        let known2 = spanning_tree::walk(&self.sets, &edges2, &mut rooted).map_err(not_finite)?;
        let known3 = spanning_tree::walk(&self.sets, &edges3, &mut rooted).map_err(not_finite)?;
        gauge.iter().for_each(|&id| rooted.set_held(id, false));
        self.place_landmarks(&mut rooted);
        Ok(tree.insert(Tree { values: rooted, edges2, known2, edges3, known3 }))
    }

    fn chordal(&self, tree: &Tree) -> Result<Values, GraphError> {
        let mut values = tree.values.clone();
        chordal::relax(&tree.edges2, &tree.known2, &self.analyses, &mut values)?;
        chordal::relax(&tree.edges3, &tree.known3, &self.analyses, &mut values)?;
        self.place_landmarks(&mut values);
        Ok(values)
    }

    /// Places points without a value where their prior says.
    fn place_at_priors(&self, values: &mut Values) {
        place_at_priors::<2>(&self.sets, values);
        place_at_priors::<3>(&self.sets, values);
    }

    /// Places each free landmark where what was seen of it says, and points without a value where their prior says.
    fn place_landmarks(&self, values: &mut Values) {
        self.place_at_priors(values);
        place::<SE2, 2, 3>(&self.sets, values);
        place::<SE3, 3, 6>(&self.sets, values);
    }

    /// The error that a measurement is not finite.
    fn not_finite(&self, factor: FactorId, values: &Values) -> GraphError {
        match self.name(factor, values) {
            Some(factor) => GraphError::ResidualNotFinite { factor },
            None => unreachable!("the factor is of this graph"),
        }
    }
}

/// The values along a spanning tree, the relative poses, and the poses it grew from, by slot.
struct Tree {
    values: Values,
    edges2: Vec<Edge<SE2, 3>>,
    known2: Vec<bool>,
    edges3: Vec<Edge<SE3, 6>>,
    known3: Vec<bool>,
}

/// Sets the points that have a prior and no value.
fn place_at_priors<const N: usize>(sets: &[Box<dyn AnySet>], values: &mut Values) {
    for (slot, mean) in edges::priors::<Rn<N>, N>(sets) {
        let key = Key::new(slot);
        if values.get(key).is_none() {
            let _ = values.set(key, mean); // the slot exists
        }
    }
}

/// Sets the free points that poses see.
fn place<P: Observer<N, D>, const N: usize, const D: usize>(sets: &[Box<dyn AnySet>], values: &mut Values) {
    for seen in P::sights(sets).chunk_by(|a, b| a.point == b.point) {
        let point = Key::<Rn<N>>::new(seen[0].point);
        let found = landmarks::locate::<P, N, D>(seen, values, |_| true);
        if let (Some(found), false) = (found, values.is_held(point)) {
            let _ = values.set(point, Rn::new(found.place)); // the slot exists
        }
    }
}
