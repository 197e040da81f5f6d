//! How each part of a graph may move as a whole.

use std::collections::HashMap;

use nalgebra::Vector3;

use crate::pose_graph::{Kind, Measured, PoseGraph, VertexKind};

/// How a part may move as a rigid body without any measurement noticing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Freedom {
    /// Not at all: a fixed pose, a prior of a pose, or enough known points hold it.
    None,
    /// Turn about the line through its known points (in space only).
    TurnAboutLine,
    /// Turn about its only known point: one direction in the plane, three in space.
    TurnAboutPoint,
    /// Anywhere: 3 directions in the plane, 6 in space.
    All,
}

/// Vertices that measurements join.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// The lowest id in it.
    pub first: u64,
    /// Poses in it.
    pub poses: usize,
    /// Points in it.
    pub points: usize,
    /// Whether it lies in space, not in the plane.
    pub spatial: bool,
    /// How it may move.
    pub freedom: Freedom,
}

impl Part {
    /// Independent directions in which it may move.
    pub fn directions(&self) -> usize {
        match self.freedom {
            Freedom::None => 0,
            Freedom::TurnAboutLine => 1,
            Freedom::TurnAboutPoint => {
                if self.spatial {
                    3
                } else {
                    1
                }
            }
            Freedom::All => {
                if self.spatial {
                    6
                } else {
                    3
                }
            }
        }
    }
}

/// The parts of a graph, largest first.
pub(super) fn parts(graph: &PoseGraph) -> Vec<Part> {
    let ids = graph.ids();
    let mut partition = graph.partition(&ids);
    let mut parts: Vec<(Part, Vec<Vector3<f64>>)> = vec![];
    let mut number = HashMap::new();
    let mut part_of = Vec::with_capacity(ids.len());
    let kinds = kinds(graph);
    for (i, &id) in ids.as_slice().iter().enumerate() {
        let place = *number.entry(partition.find(i)).or_insert_with(|| {
            let empty = Part { first: id, poses: 0, points: 0, spatial: false, freedom: Freedom::All };
            parts.push((empty, vec![]));
            parts.len() - 1
        });
        part_of.push(place);
        let part = &mut parts[place].0;
        let kind = kinds.get(&id).copied().unwrap_or(VertexKind::Pose2);
        let pose = matches!(kind, VertexKind::Pose2 | VertexKind::Pose3);
        *(if pose { &mut part.poses } else { &mut part.points }) += 1;
        part.spatial |= matches!(kind, VertexKind::Pose3 | VertexKind::Point3);
    }
    for (id, anchor) in anchors(graph, &kinds) {
        let Some(place) = ids.index(id).map(|i| part_of[i]) else { continue };
        match anchor {
            Some(point) => parts[place].1.push(point),
            None => parts[place].0.freedom = Freedom::None,
        }
    }
    let mut parts: Vec<Part> = parts.into_iter().map(|(part, points)| held(part, &points)).collect();
    parts.sort_by_key(|part| (core::cmp::Reverse(part.poses + part.points), part.first));
    parts
}

/// The kind of every id, told by its vertex or else by a measurement of it.
fn kinds(graph: &PoseGraph) -> HashMap<u64, VertexKind> {
    let named = graph.constraints().flat_map(|c| {
        let from = c.kind.from_kind().map(|kind| (c.from, kind));
        from.into_iter().chain(c.to.zip(c.kind.to_kind()))
    });
    let mut kinds: HashMap<u64, VertexKind> =
        named.chain(graph.vertices().map(|(id, kind, _)| (id, kind))).collect();
    let ranged = graph.ranged_points(|id| kinds.get(&id).copied());
    kinds.extend(ranged);
    kinds
}

/// What ties ids to the world: a whole pose (`None`), or the place of a point.
fn anchors(graph: &PoseGraph, kinds: &HashMap<u64, VertexKind>) -> Vec<(u64, Option<Vector3<f64>>)> {
    let priors = graph.constraints().filter_map(|c| match (c.kind, c.measured) {
        (Kind::PointPrior2, Measured::Point2(z)) => Some((c.from, Some(z.push(0.0)))),
        (Kind::PointPrior3, Measured::Point3(z)) => Some((c.from, Some(*z))),
        (Kind::Prior2 | Kind::Prior3, _) => Some((c.from, None)),
        _ => None,
    });
    let points: HashMap<u64, Vector3<f64>> = graph
        .points2
        .iter()
        .map(|v| (v.id, v.value.push(0.0)))
        .chain(graph.points3.iter().map(|v| (v.id, v.value)))
        .collect();
    let fixed = graph.fixed.iter().filter(|id| kinds.contains_key(id));
    priors.chain(fixed.map(|&id| (id, points.get(&id).copied()))).collect()
}

/// The part with what its known points leave free.
fn held(part: Part, points: &[Vector3<f64>]) -> Part {
    let Some(first) = points.first().filter(|_| part.freedom == Freedom::All) else { return part };
    let arms: Vec<Vector3<f64>> = points.iter().map(|p| p - first).collect();
    let longest = arms.iter().copied().fold(Vector3::zeros(), |a, b| if b.norm() > a.norm() { b } else { a });
    let aside = arms.iter().map(|arm| arm.cross(&longest).norm()).fold(0.0, f64::max);
    let freedom = if longest.norm() == 0.0 {
        Freedom::TurnAboutPoint
    } else if part.spatial && aside <= 1e-9 * longest.norm_squared() {
        Freedom::TurnAboutLine
    } else {
        Freedom::None
    };
    Part { freedom, ..part }
}
