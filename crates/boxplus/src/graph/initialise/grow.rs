//! The map as it grew: poses in their order, a piece at a time, each landmark as soon as it is determined.
//!
//! Integrated over a whole drive, odometry is wrong by as much as the map is wide, and where loops close through landmarks
//! alone no relaxation of the relative poses knows of them. But no landmark was met again with a whole drive's drift. So the drive is
//! gone through again: the poses of a piece are chained to those before, new landmarks are placed by what was seen of them so far,
//! and all that is known is optimised, coarsely, before the next piece. Landmarks that are seen only by distance or direction
//! wait until the poses that saw them tell them from their mirror images.

use core::any::TypeId;
use core::ops::ControlFlow;

use nalgebra::SVector;

use super::edges::Edge;
use super::landmarks::{Observer, Sight, locate};
use super::spanning_tree;
use crate::graph::values::VariableId;
use crate::graph::{FactorId, Graph, GraphError, Key, SolveOptions, Values};
use crate::lie::{Rn, SE2, SE3};

/// Pieces of a long drive.
const PIECES: usize = 32;
/// Poses of the shortest piece.
const SHORTEST: usize = 8;
/// Trial steps for a piece, and what it may leave of its cost to gain: what comes after corrects the rest.
const PIECE: (usize, f64) = (20, 1e-3);

/// How far the map has grown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    /// Poses that it has.
    pub poses: usize,
    /// Poses that there are.
    pub of: usize,
    /// The cost of what it has, ½ Σ ρ(‖U·r‖²).
    pub cost: f64,
}

/// What the other starts leave out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Landmarks {
    None,
    /// Loops may close through them.
    Seen,
    /// Some by distance or direction alone: their mirror images are minima of their own, which only the cost tells apart.
    Ambiguous,
}

impl Landmarks {
    pub(super) fn of(graph: &Graph) -> Self {
        let (flat, spatial) = (SE2::sights(&graph.sets), SE3::sights(&graph.sets));
        if flat.iter().any(Sight::is_partial) || spatial.iter().any(Sight::is_partial) {
            Self::Ambiguous
        } else if flat.is_empty() && spatial.is_empty() {
            Self::None
        } else {
            Self::Seen
        }
    }
}

/// Grows the map, from the poses that are held or first.
///
/// # Errors
/// Those of [`Graph::optimize`], and the factor whose measurement is not finite.
pub(super) fn grow(
    graph: &Graph,
    values: &Values,
    observer: &mut dyn FnMut(Growth) -> ControlFlow<()>,
) -> Result<Values, GraphError> {
    let mut map = Map {
        flat: Poses::new(graph, values),
        spatial: Poses::new(graph, values),
        graph,
        values: values.clone(),
    };
    let of = map.flat.total + map.spatial.total;
    let pieces = (of / SHORTEST).clamp(1, PIECES);
    let mut stopped = false;
    for piece in 1..=pieces {
        map.extend(piece, pieces).map_err(|factor| graph.not_finite(factor, values))?;
        if !stopped {
            let cost = map.settle()?;
            stopped = observer(Growth { poses: map.flat.end + map.spatial.end, of, cost }).is_break();
        }
    }
    if !stopped {
        map.doubt::<2>(|map| &map.flat.rivals)?;
        map.doubt::<3>(|map| &map.spatial.rivals)?;
    }
    Ok(map.values)
}

struct Map<'a> {
    graph: &'a Graph,
    values: Values,
    flat: Poses<SE2, 2, 3>,
    spatial: Poses<SE3, 3, 6>,
}

impl Map<'_> {
    /// Adds the poses of a piece, and the landmarks that are determined then; after the last piece, all of them.
    fn extend(&mut self, piece: usize, pieces: usize) -> Result<(), FactorId> {
        self.flat.extend(self.graph, &mut self.values, (piece, pieces))?;
        self.spatial.extend(self.graph, &mut self.values, (piece, pieces))
    }

    /// Optimises what is known; returns its cost.
    fn settle(&mut self) -> Result<f64, GraphError> {
        let part = self.graph.part(|id| self.flat.knows(id) && self.spatial.knows(id));
        let (max_iterations, relative_cost) = PIECE;
        let options = SolveOptions { max_iterations, relative_cost, ..SolveOptions::default() };
        let solution = part.optimize(&self.values, &options)?;
        self.values = solution.values;
        Ok(solution.report.cost)
    }
}

impl Map<'_> {
    /// Moves each landmark that could be elsewhere there, and leaves it where the whole map costs less.
    fn doubt<const N: usize>(
        &mut self,
        rivals: impl Fn(&Self) -> &[(Key<Rn<N>>, SVector<f64, N>)],
    ) -> Result<(), GraphError> {
        let mut cost = f64::INFINITY;
        for (point, place) in rivals(self).to_vec() {
            if cost.is_infinite() {
                cost = self.settle()?;
            }
            let before = self.values.clone();
            let _ = self.values.set(point, Rn::new(place)); // the slot exists
            match self.settle()? {
                other if other < cost => cost = other,
                _ => self.values = before,
            }
        }
        Ok(())
    }
}

/// The poses of one kind and the points that they see.
struct Poses<P, const N: usize, const D: usize> {
    edges: Vec<Edge<P, D>>,
    sights: Vec<Sight<N>>,
    /// By slot, whether the map has the point; points that no pose sees are known from the beginning.
    points: Vec<bool>,
    /// Points that had to be placed without being told from where else they could be.
    rivals: Vec<(Key<Rn<N>>, SVector<f64, N>)>,
    /// Poses before this slot are known.
    end: usize,
    total: usize,
}

impl<P: Observer<N, D>, const N: usize, const D: usize> Poses<P, N, D> {
    fn new(graph: &Graph, values: &Values) -> Self {
        let sights = P::sights(&graph.sets);
        let mut points = vec![true; values.len::<Rn<N>>()];
        let free = |sight: &&Sight<N>| !values.is_held(Key::<Rn<N>>::new(sight.point));
        sights.iter().filter(free).for_each(|sight| points[sight.point as usize] = false);
        let (edges, total) = (P::edges(&graph.sets), values.len::<P>());
        Self { edges, sights, points, rivals: vec![], end: 0, total }
    }

    /// Whether the map has this variable, or another part of it has to say.
    fn knows(&self, id: VariableId) -> bool {
        let slot = id.slot as usize;
        match id.kind {
            kind if kind == TypeId::of::<P>() => slot < self.end,
            kind if kind == TypeId::of::<Rn<N>>() => self.points[slot],
            _ => true,
        }
    }

    fn extend(
        &mut self,
        graph: &Graph,
        values: &mut Values,
        (piece, pieces): (usize, usize),
    ) -> Result<(), FactorId> {
        let begin = core::mem::replace(&mut self.end, self.total * piece / pieces);
        self.chain(graph, values, begin)?;
        let end = self.end;
        for seen in self.sights.chunk_by(|a, b| a.point == b.point) {
            let point = seen[0].point;
            if self.points[point as usize] {
                continue;
            }
            let found = locate::<P, N, D>(seen, values, |pose| (pose as usize) < end);
            if let Some(found) = found.filter(|found| found.sure || piece == pieces) {
                let _ = values.set(Key::new(point), Rn::new(found.place)); // the slot exists
                self.points[point as usize] = true;
                let rival = found.rival.filter(|_| !found.sure);
                self.rivals.extend(rival.map(|place| (Key::new(point), place)));
            }
        }
        Ok(())
    }

    /// Chains the poses from `begin` on to those before.
    fn chain(&self, graph: &Graph, values: &mut Values, begin: usize) -> Result<(), FactorId> {
        let known = |slot: u32| (slot as usize) < self.end;
        let edges: Vec<Edge<P, D>> =
            self.edges.iter().filter(|e| known(e.from) && known(e.to)).copied().collect();
        let free = |slot: &usize| !values.is_held(Key::<P>::new(*slot as u32));
        let anchors: Vec<usize> = (0..begin).filter(free).collect();
        let hold = |values: &mut Values, held| {
            for &slot in &anchors {
                values.set_held(Key::<P>::new(slot as u32).into(), held);
            }
        };
        hold(values, true);
        let walked = spanning_tree::walk(&graph.sets, &edges, values);
        hold(values, false);
        walked.map(drop)
    }
}
