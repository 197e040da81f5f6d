//! All measurements of a pose graph as one list.

use super::{Edge, Line, PoseGraph, Prior, Prior3, Sighting3};
use crate::lie::{SE2, SE3};
use core::fmt;
use nalgebra::{Vector2, Vector3};

/// A kind of vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum VertexKind {
    /// A pose in the plane.
    Pose2,
    /// A pose in space.
    Pose3,
    /// A point in the plane.
    Point2,
    /// A point in space.
    Point3,
}

impl VertexKind {
    /// The point in the same world.
    pub(super) fn point(self) -> Self {
        match self {
            Self::Pose2 | Self::Point2 => Self::Point2,
            Self::Pose3 | Self::Point3 => Self::Point3,
        }
    }

    /// `other`, if both are in the same world, else the point that it should be.
    pub(super) fn beside(self, other: Self) -> Self {
        if self.point() == other.point() { other } else { self.point() }
    }
}

impl fmt::Display for VertexKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Pose2 => "pose in the plane",
            Self::Pose3 => "pose in space",
            Self::Point2 => "point in the plane",
            Self::Point3 => "point in space",
        })
    }
}

/// A kind of measurement; prints as its g2o tag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Between two poses in the plane.
    Edge2,
    /// Between two poses in space.
    Edge3,
    /// From a pose to a point in the plane.
    Sighting2,
    /// From a sensor on a pose to a point in space.
    Sighting3,
    /// The direction from a pose to a point in the plane.
    Bearing2,
    /// The distance between two vertices of one dimension.
    Range,
    /// Of a pose in the plane.
    Prior2,
    /// Of a sensor on a pose in space.
    Prior3,
    /// Of a point in the plane.
    PointPrior2,
    /// Of a point in space.
    PointPrior3,
}

impl Kind {
    /// Every kind, in the order of [`PoseGraph::constraints`].
    pub const ALL: [Self; 10] = [
        Self::Edge2,
        Self::Edge3,
        Self::Sighting2,
        Self::Sighting3,
        Self::Bearing2,
        Self::Range,
        Self::Prior2,
        Self::Prior3,
        Self::PointPrior2,
        Self::PointPrior3,
    ];

    /// The tag of such a line in a g2o file; of a range, which g2o does not know, in a PyFG file.
    pub fn tag(self) -> &'static str {
        match self {
            Self::Edge2 => "EDGE_SE2",
            Self::Edge3 => "EDGE_SE3:QUAT",
            Self::Sighting2 => "EDGE_SE2_XY",
            Self::Sighting3 => "EDGE_SE3_TRACKXYZ",
            Self::Bearing2 => "EDGE_BEARING_SE2_XY",
            Self::Range => "EDGE_RANGE",
            Self::Prior2 => "EDGE_PRIOR_SE2",
            Self::Prior3 => "EDGE_SE3_PRIOR",
            Self::PointPrior2 => "EDGE_PRIOR_XY",
            Self::PointPrior3 => "EDGE_POINTXYZ_PRIOR",
        }
    }

    /// The kind of its first vertex, or `None` for a range, which may start at any.
    pub fn from_kind(self) -> Option<VertexKind> {
        match self {
            Self::Edge2 | Self::Sighting2 | Self::Bearing2 | Self::Prior2 => Some(VertexKind::Pose2),
            Self::Edge3 | Self::Sighting3 | Self::Prior3 => Some(VertexKind::Pose3),
            Self::PointPrior2 => Some(VertexKind::Point2),
            Self::PointPrior3 => Some(VertexKind::Point3),
            Self::Range => None,
        }
    }

    /// The kind of its second vertex, or `None` for a prior, which has none, and a range, which may end at any.
    pub fn to_kind(self) -> Option<VertexKind> {
        match self {
            Self::Edge2 => Some(VertexKind::Pose2),
            Self::Edge3 => Some(VertexKind::Pose3),
            Self::Sighting2 | Self::Bearing2 => Some(VertexKind::Point2),
            Self::Sighting3 => Some(VertexKind::Point3),
            Self::Range | Self::Prior2 | Self::Prior3 | Self::PointPrior2 | Self::PointPrior3 => None,
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.tag())
    }
}

/// A measured value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measured<'a> {
    /// Of a displacement or pose in the plane.
    Pose2(&'a SE2),
    /// Of a displacement or pose in space.
    Pose3(&'a SE3),
    /// Of a point in the plane, metres.
    Point2(&'a Vector2<f64>),
    /// Of a point in space, metres.
    Point3(&'a Vector3<f64>),
    /// Of a direction in the plane, radians.
    Bearing2(&'a f64),
    /// Of a distance, metres.
    Range(&'a f64),
}

impl Measured<'_> {
    /// The stored numbers, filled up with zeros.
    pub(super) fn numbers(&self) -> [f64; 7] {
        match self {
            Self::Pose2(z) => {
                let (t, r) = (z.translation(), z.rotation());
                [t.x, t.y, r.cos(), r.sin(), 0.0, 0.0, 0.0]
            }
            Self::Pose3(z) => {
                let (t, [x, y, z, w]) = (z.translation(), z.rotation().quaternion_xyzw());
                [t.x, t.y, t.z, x, y, z, w]
            }
            Self::Point2(z) => [z.x, z.y, 0.0, 0.0, 0.0, 0.0, 0.0],
            Self::Point3(z) => [z.x, z.y, z.z, 0.0, 0.0, 0.0, 0.0],
            Self::Bearing2(z) | Self::Range(z) => [**z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        }
    }
}

/// One measurement of any kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constraint<'a> {
    /// Its kind.
    pub kind: Kind,
    /// The vertex in whose frame it was measured, or the only one.
    pub from: u64,
    /// The vertex that was measured, or `None` for a prior.
    pub to: Option<u64>,
    /// The number of the sensor offset it refers to.
    pub offset: Option<u64>,
    /// What was measured.
    pub measured: Measured<'a>,
    /// Inverse covariance, D×D by columns, in the order translation, rotation.
    pub information: &'a [f64],
    /// Where it was read.
    pub line: Line,
}

impl<'a> Constraint<'a> {
    /// Degrees of freedom: the dimension of its residual.
    pub fn dof(&self) -> usize {
        self.information.len().isqrt()
    }

    fn edge<Z, const D: usize>(kind: Kind, e: &'a Edge<Z, D>, measured: fn(&'a Z) -> Measured<'a>) -> Self {
        Self {
            kind,
            from: e.from,
            to: Some(e.to),
            offset: None,
            measured: measured(&e.measured),
            information: e.information.as_slice(),
            line: e.line,
        }
    }

    fn sighting3(e: &'a Sighting3) -> Self {
        Self {
            kind: Kind::Sighting3,
            from: e.from,
            to: Some(e.to),
            offset: Some(e.offset),
            measured: Measured::Point3(&e.measured),
            information: e.information.as_slice(),
            line: e.line,
        }
    }

    fn prior<Z, const D: usize>(kind: Kind, p: &'a Prior<Z, D>, measured: fn(&'a Z) -> Measured<'a>) -> Self {
        Self {
            kind,
            from: p.id,
            to: None,
            offset: None,
            measured: measured(&p.measured),
            information: p.information.as_slice(),
            line: p.line,
        }
    }

    fn prior3(p: &'a Prior3) -> Self {
        Self {
            kind: Kind::Prior3,
            from: p.id,
            to: None,
            offset: Some(p.offset),
            measured: Measured::Pose3(&p.measured),
            information: p.information.as_slice(),
            line: p.line,
        }
    }
}

impl PoseGraph {
    /// The ids that nothing but ranges names, where `kind_of` knows the kind of the others: points in the world of the other end.
    pub(super) fn ranged_points(
        &self,
        kind_of: impl Fn(u64) -> Option<VertexKind>,
    ) -> Vec<(u64, VertexKind)> {
        let ends = self.ranges.iter().flat_map(|e| [(e.from, e.to), (e.to, e.from)]);
        ends.filter(|&(id, _)| kind_of(id).is_none())
            .filter_map(|(id, other)| Some((id, kind_of(other)?.point())))
            .collect()
    }

    /// Every measurement, kind by kind in the order of [`Kind::ALL`], within a kind in the order of the file.
    pub fn constraints(&self) -> impl Iterator<Item = Constraint<'_>> {
        let edges2 = self.edges2.iter().map(|e| Constraint::edge(Kind::Edge2, e, Measured::Pose2));
        let edges3 = self.edges3.iter().map(|e| Constraint::edge(Kind::Edge3, e, Measured::Pose3));
        let sightings2 =
            self.sightings2.iter().map(|e| Constraint::edge(Kind::Sighting2, e, Measured::Point2));
        let sightings3 = self.sightings3.iter().map(Constraint::sighting3);
        let bearings2 =
            self.bearings2.iter().map(|e| Constraint::edge(Kind::Bearing2, e, Measured::Bearing2));
        let ranges = self.ranges.iter().map(|e| Constraint::edge(Kind::Range, e, Measured::Range));
        let priors2 = self.priors2.iter().map(|p| Constraint::prior(Kind::Prior2, p, Measured::Pose2));
        let priors3 = self.priors3.iter().map(Constraint::prior3);
        let points2 =
            self.point_priors2.iter().map(|p| Constraint::prior(Kind::PointPrior2, p, Measured::Point2));
        let points3 =
            self.point_priors3.iter().map(|p| Constraint::prior(Kind::PointPrior3, p, Measured::Point3));
        let binary = edges2.chain(edges3).chain(sightings2).chain(sightings3).chain(bearings2).chain(ranges);
        binary.chain(priors2).chain(priors3).chain(points2).chain(points3)
    }
}
