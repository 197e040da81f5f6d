//! Pose graphs as data: poses, points, and what was measured between them.
//!
//! A [`PoseGraph`] holds exactly what a file says, in the order of the file, one vector per kind, so that nothing is lost
//! between reading and writing; [`PoseGraph::constraints`] walks over all measurements as one list,
//! [`PoseGraph::statistics`] counts, [`PoseGraph::faults`] finds what would make a solver fail, and [`simulate`] makes
//! graphs whose truth is known.
//!
//! ```text
//! pose i         world_from_i                      SE(2), SE(3)
//! edge i → j     Z ≈ X_i⁻¹·X_j = i_from_j          Ω in the tangent at Z: (x, y, θ) or (x, y, z, rx, ry, rz)
//! sighting i → p z ≈ X_i⁻¹·p,  3-D: (X_i·B)⁻¹·p    B = body_from_sensor, an [`Offset`]
//! bearing i → p  z ≈ atan2 of X_i⁻¹·p              radians
//! range i – j    z ≈ ‖p_j − p_i‖                   metres, between poses, points, or both
//! prior i        Z ≈ X_i,  3-D: X_i·B
//! ```
//! Ids are one numbering over poses and points; a [`Label`] shows them as files write them. A graph without any vertex is legal: it has no
//! initial values, and an id that only ranges name is a point.
//!
//! Pitfall: information matrices are the numbers of the file. What they weigh is the business of whoever evaluates the
//! cost: g2o's rotation error is the vector part of a unit quaternion, about *half* the rotation vector, while most other
//! readers of the same files weigh the rotation vector itself. Nothing is rescaled here.

#[cfg(feature = "solve")]
pub mod certify;
mod constraint;
#[cfg(feature = "solve")]
pub mod diagnose;
mod faults;
mod ids;
mod information;
pub mod simulate;
#[cfg(feature = "solve")]
pub mod solve;
mod statistics;
mod truth;

pub use constraint::{Constraint, Kind, Measured, VertexKind};
pub use faults::{Fault, Severity};
pub use information::InformationProblem;
#[cfg(feature = "solve")]
pub use solve::{ChartKind, Costs, Indefinite, PoseGraphError, SolveSettings, Solved};
pub use statistics::{Degree, Statistics};
pub use truth::MapError;

pub use crate::label::{Label, NoLabel};
use crate::lie::{SE2, SE3};
use nalgebra::{SMatrix, Vector2, Vector3};

/// Where something was read: the line in its file, from 1, or 0 if it does not come from a file.
///
/// Provenance is not identity: all lines are equal, so that a graph equals itself written and read back.
#[derive(Clone, Copy, Debug, Default)]
pub struct Line(pub u32);

impl PartialEq for Line {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// A variable with its initial value: a pose `world_from_body` or a point in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Vertex<T> {
    /// Its number, unique over all kinds of vertices.
    pub id: u64,
    /// Its initial value.
    pub value: T,
    /// Where it was read.
    pub line: Line,
}

/// A measurement between two vertices, with D degrees of freedom.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge<Z, const D: usize> {
    /// The vertex in whose frame it was measured.
    pub from: u64,
    /// The vertex that was measured.
    pub to: u64,
    /// The measured value.
    pub measured: Z,
    /// Inverse covariance Ω, D×D, in the order translation, rotation.
    pub information: SMatrix<f64, D, D>,
    /// Where it was read.
    pub line: Line,
}

/// A point in space seen by a sensor that sits on a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Sighting3 {
    /// The pose of the body.
    pub from: u64,
    /// The point.
    pub to: u64,
    /// The [`Offset`] that holds `body_from_sensor`.
    pub offset: u64,
    /// The point in the frame of the sensor, metres.
    pub measured: Vector3<f64>,
    /// Inverse covariance, 3×3.
    pub information: SMatrix<f64, 3, 3>,
    /// Where it was read.
    pub line: Line,
}

/// A measurement of one vertex in the world, with D degrees of freedom.
#[derive(Clone, Debug, PartialEq)]
pub struct Prior<Z, const D: usize> {
    /// The vertex.
    pub id: u64,
    /// Its measured value.
    pub measured: Z,
    /// Inverse covariance, D×D, in the order translation, rotation.
    pub information: SMatrix<f64, D, D>,
    /// Where it was read.
    pub line: Line,
}

/// A measurement of the pose of a sensor in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Prior3 {
    /// The pose of the body.
    pub id: u64,
    /// The [`Offset`] that holds `body_from_sensor`.
    pub offset: u64,
    /// Measured `world_from_sensor`.
    pub measured: SE3,
    /// Inverse covariance, 6×6, in the order translation, rotation.
    pub information: SMatrix<f64, 6, 6>,
    /// Where it was read.
    pub line: Line,
}

/// The place of a sensor on its body.
#[derive(Clone, Debug, PartialEq)]
pub struct Offset<G> {
    /// Its number, in a numbering of its own.
    pub id: u64,
    /// `body_from_sensor`.
    pub value: G,
    /// Where it was read.
    pub line: Line,
}

/// The time of a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stamp {
    /// The vertex.
    pub id: u64,
    /// Seconds, on the clock of the file.
    pub seconds: f64,
}

/// A line that is not understood, kept as it was.
#[derive(Clone, Debug, PartialEq)]
pub struct OtherLine {
    /// The whole line without its end.
    pub text: String,
    /// Where it was read.
    pub line: Line,
}

impl OtherLine {
    /// Its first word.
    pub fn tag(&self) -> &str {
        self.text.split_ascii_whitespace().next().unwrap_or("")
    }
}

/// A pose graph: see the [module](self).
///
/// ```
/// use boxplus::lie::SE2;
/// use boxplus::pose_graph::{Edge, Line, PoseGraph};
/// use nalgebra::{Matrix3, Vector2};
/// let mut graph = PoseGraph::default();
/// graph.edges2.push(Edge {
///     from: 0,
///     to: 1,
///     measured: SE2::new(Vector2::new(1.0, 0.0), 0.1),
///     information: Matrix3::identity(),
///     line: Line(0),
/// });
/// assert_eq!(graph.statistics().components, 1);
/// assert!(graph.faults().is_empty());
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseGraph {
    /// Poses in the plane.
    pub poses2: Vec<Vertex<SE2>>,
    /// Poses in space.
    pub poses3: Vec<Vertex<SE3>>,
    /// Points in the plane.
    pub points2: Vec<Vertex<Vector2<f64>>>,
    /// Points in space.
    pub points3: Vec<Vertex<Vector3<f64>>>,
    /// Displacements between poses in the plane.
    pub edges2: Vec<Edge<SE2, 3>>,
    /// Displacements between poses in space.
    pub edges3: Vec<Edge<SE3, 6>>,
    /// Points of the plane seen from poses, in the frame of the pose.
    pub sightings2: Vec<Edge<Vector2<f64>, 2>>,
    /// Points of space seen from sensors on poses.
    pub sightings3: Vec<Sighting3>,
    /// Directions, in radians from the x-axis of the pose, in which points of the plane were seen.
    pub bearings2: Vec<Edge<f64, 1>>,
    /// Distances, in metres, between the positions of two vertices of one dimension.
    pub ranges: Vec<Edge<f64, 1>>,
    /// Poses of the plane known in the world.
    pub priors2: Vec<Prior<SE2, 3>>,
    /// Poses in space known in the world.
    pub priors3: Vec<Prior3>,
    /// Points of the plane known in the world.
    pub point_priors2: Vec<Prior<Vector2<f64>, 2>>,
    /// Points of space known in the world.
    pub point_priors3: Vec<Prior<Vector3<f64>, 3>>,
    /// Sensors on bodies in the plane; only lines kept in `other` refer to them.
    pub offsets2: Vec<Offset<SE2>>,
    /// Sensors on bodies in space.
    pub offsets3: Vec<Offset<SE3>>,
    /// Vertices whose initial value is exact and must not move.
    pub fixed: Vec<u64>,
    /// When poses were where they are, for those whose files say it.
    pub stamps: Vec<Stamp>,
    /// Lines with other tags.
    pub other: Vec<OtherLine>,
}

impl PoseGraph {
    /// The number of vertices of all kinds.
    pub fn vertex_count(&self) -> usize {
        self.poses2.len() + self.poses3.len() + self.points2.len() + self.points3.len()
    }

    /// The id, kind and line of every vertex: poses before points, in the order of the file.
    pub fn vertices(&self) -> impl Iterator<Item = (u64, VertexKind, Line)> + '_ {
        let of = |kind| move |id, line| (id, kind, line);
        let poses2 = self.poses2.iter().map(move |v| of(VertexKind::Pose2)(v.id, v.line));
        let poses3 = self.poses3.iter().map(move |v| of(VertexKind::Pose3)(v.id, v.line));
        let points2 = self.points2.iter().map(move |v| of(VertexKind::Point2)(v.id, v.line));
        let points3 = self.points3.iter().map(move |v| of(VertexKind::Point3)(v.id, v.line));
        poses2.chain(poses3).chain(points2).chain(points3)
    }

    /// The measurements alone: without the values of vertices, and with nothing fixed at them.
    ///
    /// For files whose vertices are the truth, which no estimate may start from.
    pub fn measurements_only(&self) -> Self {
        Self {
            poses2: vec![],
            poses3: vec![],
            points2: vec![],
            points3: vec![],
            fixed: vec![],
            ..self.clone()
        }
    }
}
