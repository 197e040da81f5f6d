//! Is the optimum of a pose graph the global one? A proof, or a way further down.
//!
//! Descent ends in some minimum. For SE-Sync's cost, which compares rotation matrices and isotropic positions, there is a test
//! whether it is the lowest of all: the matrix S of its dual, as sparse as the graph, is positive semidefinite there. Where it is, the
//! bound it gives holds against *every* estimate. Where it is not, the eigenvector of its negative eigenvalue leads down
//! through a space of one more dimension, and what is found there is brought back and tested again. Rosen et al. (2019).
//!
//! ```
//! use boxplus::pose_graph::certify::{Verdict, certify};
//! use boxplus::pose_graph::{SolveSettings, solve::solve};
//! use boxplus::pose_graph::simulate::{Options, Simulator};
//! let world = Simulator::Sphere.simulate(&Options { size: Some(100), ..Options::default() })?;
//! let settings = SolveSettings::default();
//! let certificate = certify(&solve(&world.graph, &settings)?.graph, &settings)?;
//! assert_eq!(certificate.verdict, Verdict::Optimal);
//! assert!(certificate.gap() <= 1e-6 * certificate.cost);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod descent;
mod quadratic;
mod spectrum;
mod staircase;

use core::ops::ControlFlow;

use nalgebra::{SMatrix, SVector};

use super::ids::Ids;
use super::solve::{Indefinite, PoseGraphError, SolveSettings, faults, usable_information};
use super::{Edge, Fault, Kind, Label, PoseGraph, Vertex, VertexKind};
use crate::graph::isotropic_weights;
use crate::lie::{SE2, SE3, SO2, SO3};
use crate::partition::Partition;
use descent::Watch;
use quadratic::{Frame, Link};
use staircase::{Climb, climb};

/// What is known about an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// No estimate whatever costs less, up to the stated gap.
    Optimal,
    /// There is a way down.
    NotOptimal,
    /// Neither is proved; the gap says how much better another estimate could be at most.
    Undecided,
}

impl Verdict {
    /// For machines: `optimal`, `not_optimal`, `undecided`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Optimal => "optimal",
            Self::NotOptimal => "not_optimal",
            Self::Undecided => "undecided",
        }
    }
}

/// A way down from an estimate that is no optimum.
#[derive(Clone, Debug, PartialEq)]
pub struct Descent {
    /// The curvature of the cost along it, for a unit turn of all rotations together: negative.
    pub curvature: f64,
    /// The vertices that turn most, first the one that turns most, at most [`Descent::SHOWN`].
    pub vertices: Vec<u64>,
}

impl Descent {
    /// Vertices named at most.
    pub const SHOWN: usize = 6;
}

/// What [`certify`] found.
#[derive(Clone, Debug)]
pub struct Certificate {
    /// About the given estimate, once it has settled in its own minimum.
    pub given: Verdict,
    /// SE-Sync's cost of that minimum.
    pub given_cost: f64,
    /// Where it is no optimum: the way down.
    pub descent: Option<Descent>,
    /// About the best estimate found from there.
    pub verdict: Verdict,
    /// SE-Sync's cost of it.
    pub cost: f64,
    /// No estimate whatever costs less than this.
    pub lower_bound: f64,
    /// The smallest eigenvalue of the dual matrix there, or what it is at least, where that suffices; in the unit of κ.
    pub eigenvalue: f64,
    /// How many minima were left for lower ones.
    pub escapes: usize,
    /// Whether an observer stopped the search.
    pub stopped: bool,
    /// The graph with its vertices at the best estimate, which minimises SE-Sync's cost; its first pose is where it was.
    pub graph: PoseGraph,
}

impl Certificate {
    /// How much better another estimate could be at most: F(X) − F* is no more than this.
    pub fn gap(&self) -> f64 {
        (self.cost - self.lower_bound).max(0.0)
    }
}

/// Why a graph cannot be certified.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CertifyError {
    /// The proof is for graphs of one kind of pose and displacements between them.
    #[error(
        "only graphs of poses and displacements of one kind can be certified; this one has {count} × {kind}"
    )]
    Measurements {
        /// What else it has.
        kind: Kind,
        /// How many of these.
        count: usize,
    },
    /// As [`CertifyError::Measurements`], for vertices.
    #[error("only graphs of poses of one kind can be certified; this one has a {kind}, vertex {}", Label(*id))]
    Vertices {
        /// What else it has.
        kind: VertexKind,
        /// One of these.
        id: u64,
    },
    /// Two held poses are a measurement that the proof does not know.
    #[error(
        "{count} vertices are held, and the proof holds at most one: it says nothing about graphs with more"
    )]
    Held {
        /// How many are held.
        count: usize,
    },
    /// A pose has no value, or nothing joins it.
    #[error("{count} of the {poses} poses have no value or no measurement: solve the graph first")]
    Unsolved {
        /// How many.
        count: usize,
        /// Of how many.
        poses: usize,
    },
    /// The graph itself is at fault.
    #[error(transparent)]
    PoseGraph(#[from] PoseGraphError),
}

/// Certifies the poses that `graph` holds, or finds better ones: the estimate first settles in its own minimum of
/// SE-Sync's cost (a solve in any other chart ends close to it), then is tested, and left if there is a way down.
///
/// # Errors
/// [`CertifyError`], where the proof does not apply.
pub fn certify(graph: &PoseGraph, settings: &SolveSettings) -> Result<Certificate, CertifyError> {
    certify_observed(graph, settings, &mut |_| ControlFlow::Continue(()))
}

/// As [`certify`]; `observer` sees the cost of every step, and may stop with what is known so far.
///
/// # Errors
/// As [`certify`].
pub fn certify_observed(
    graph: &PoseGraph,
    settings: &SolveSettings,
    observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Certificate, CertifyError> {
    let mut watch = Watch { observer, stopped: false };
    applies(graph, settings)?;
    let mut out = graph.clone();
    let climbed = if graph.edges3.is_empty() {
        let links = links::<SE2, 2, 3>(&graph.poses2, &graph.edges2, settings)?;
        let climb = climb::<2, 3, 4>(&links, &frames(&graph.poses2), &mut watch);
        settle(climb.map_err(PoseGraphError::from)?, &links, &mut out.poses2)
    } else {
        let links = links::<SE3, 3, 6>(&graph.poses3, &graph.edges3, settings)?;
        let climb = climb::<3, 4, 5>(&links, &frames(&graph.poses3), &mut watch);
        settle(climb.map_err(PoseGraphError::from)?, &links, &mut out.poses3)
    };
    Ok(Certificate { graph: out, stopped: watch.stopped, ..climbed })
}

/// What was found, with the vertices moved there; the graph is still to be filled in.
fn settle<X: Pose<D>, const D: usize>(
    climb: Climb<D>,
    links: &[Link<D>],
    vertices: &mut [Vertex<X>],
) -> Certificate {
    let descent = climb.descent.map(|(curvature, poses)| Descent {
        curvature,
        vertices: poses.iter().take(Descent::SHOWN).map(|&pose| vertices[pose].id).collect(),
    });
    write(&climb.frames, links, vertices);
    Certificate {
        given: climb.given,
        given_cost: climb.given_cost,
        descent,
        verdict: climb.best.verdict(),
        cost: climb.best.cost,
        lower_bound: climb.best.lower_bound,
        eigenvalue: climb.best.eigenvalue,
        escapes: climb.escapes,
        stopped: false,
        graph: PoseGraph::default(),
    }
}

/// Refuses graphs about which the proof says nothing.
fn applies(graph: &PoseGraph, settings: &SolveSettings) -> Result<(), CertifyError> {
    let faults = faults(graph, settings.indefinite);
    let refuse = settings.indefinite == Indefinite::Refuse;
    let fatal = |fault: &Fault| refuse || !matches!(fault, Fault::Information { .. });
    if faults.iter().any(fatal) {
        return Err(PoseGraphError::Faulty { faults }.into());
    }
    let planar = graph.edges3.is_empty();
    let (poses, edges) =
        if planar { (VertexKind::Pose2, Kind::Edge2) } else { (VertexKind::Pose3, Kind::Edge3) };
    let mut others = graph.constraints().filter(|c| c.kind != edges);
    if let Some(other) = others.next() {
        let count = 1 + others.filter(|c| c.kind == other.kind).count();
        return Err(CertifyError::Measurements { kind: other.kind, count });
    }
    if let Some((id, kind, _)) = graph.vertices().find(|&(_, kind, _)| kind != poses) {
        return Err(CertifyError::Vertices { kind, id });
    }
    let mut held: Vec<u64> = graph.fixed.iter().chain(&settings.fixed).copied().collect();
    held.sort_unstable();
    held.dedup();
    if held.len() > 1 {
        return Err(CertifyError::Held { count: held.len() });
    }
    Ok(())
}

/// A pose of the plane or of space, as D orthonormal columns and a position.
trait Pose<const D: usize>: Copy {
    fn frame(&self) -> Frame<D, D>;
    /// The pose of these columns, `None` where they are not finite.
    fn from_frame(frame: &Frame<D, D>) -> Option<Self>;
}

impl Pose<2> for SE2 {
    fn frame(&self) -> Frame<2, 2> {
        Frame { y: self.rotation().to_matrix(), t: self.translation() }
    }
    fn from_frame(frame: &Frame<2, 2>) -> Option<Self> {
        Some(Self::from_parts(frame.t, SO2::project(&frame.y).ok()?))
    }
}

impl Pose<3> for SE3 {
    fn frame(&self) -> Frame<3, 3> {
        Frame { y: self.rotation().to_matrix(), t: self.translation() }
    }
    fn from_frame(frame: &Frame<3, 3>) -> Option<Self> {
        Some(Self::new(SO3::project(&frame.y).ok()?, frame.t))
    }
}

fn frames<X: Pose<D>, const D: usize>(vertices: &[Vertex<X>]) -> Vec<Frame<D, D>> {
    vertices.iter().map(|vertex| vertex.value.frame()).collect()
}

/// The displacements with SE-Sync's weights.
fn links<X: Pose<D>, const D: usize, const N: usize>(
    vertices: &[Vertex<X>],
    edges: &[Edge<X, N>],
    settings: &SolveSettings,
) -> Result<Vec<Link<D>>, CertifyError> {
    let ids = Ids::new(vertices.iter().map(|vertex| vertex.id));
    let mut place = vec![0; ids.len()];
    let mut joined = vec![false; vertices.len()];
    let is_finite = |x: &Frame<D, D>| x.y.iter().chain(&x.t).all(|x| x.is_finite());
    let without_value = vertices.iter().filter(|vertex| !is_finite(&vertex.value.frame())).count();
    for (i, vertex) in vertices.iter().enumerate() {
        ids.index(vertex.id).into_iter().for_each(|k| place[k] = i);
    }
    let mut out = Vec::with_capacity(edges.len());
    let mut strangers = 0;
    for edge in edges {
        let (Some(from), Some(to)) = (ids.index(edge.from), ids.index(edge.to)) else {
            strangers += 1;
            continue;
        };
        let information = usable_information(&edge.information, settings.indefinite);
        let Some((tau, kappa)) = information.and_then(|information| isotropic_weights(&information)) else {
            continue; // left out, as the settings ask
        };
        let (from, to, Frame { y, t }) = (place[from], place[to], edge.measured.frame());
        (joined[from], joined[to]) = (true, true);
        out.push(Link { from, to, rotation: y, translation: t, kappa, tau });
    }
    let alone = joined.iter().filter(|joined| !**joined).count();
    match strangers + alone.max(without_value) {
        0 => Ok(out),
        count => Err(CertifyError::Unsolved { count, poses: vertices.len() }),
    }
}

/// Moves the vertices to these frames, each connected part so that its first pose stays where it was.
fn write<X: Pose<D>, const D: usize>(frames: &[Frame<D, D>], links: &[Link<D>], vertices: &mut [Vertex<X>]) {
    let mut parts = Partition::new(frames.len());
    links.iter().for_each(|link| parts.join(link.from, link.to));
    let mut moves: Vec<Option<(SMatrix<f64, D, D>, SVector<f64, D>)>> = vec![None; frames.len()];
    for (i, (frame, vertex)) in frames.iter().zip(vertices).enumerate() {
        let (turn, shift) = *moves[parts.find(i)].get_or_insert_with(|| {
            let old = vertex.value.frame();
            let turn = old.y * frame.y.transpose();
            (turn, old.t - turn * frame.t)
        });
        if let Some(value) = X::from_frame(&Frame { y: turn * frame.y, t: turn * frame.t + shift }) {
            vertex.value = value;
        }
    }
}
