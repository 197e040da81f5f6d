//! The variables of a pose graph, found by the ids of its file.

use crate::graph::{Key, Values, Variable};
use crate::lie::{Rn, SE2, SE3};
use crate::pose_graph::ids::Ids;
use crate::pose_graph::{Vertex, VertexKind};

/// The variables, found by the ids of the file.
pub(super) struct Keys {
    pub(super) ids: Ids,
    /// The index of an id that two vertices of one kind have.
    pub(super) repeated: Option<usize>,
    pub(super) poses2: Vec<Option<Key<SE2>>>,
    pub(super) poses3: Vec<Option<Key<SE3>>>,
    pub(super) points2: Vec<Option<Key<Rn<2>>>>,
    pub(super) points3: Vec<Option<Key<Rn<3>>>>,
}

/// The key of a vertex, whatever its kind.
pub(super) enum End {
    Pose2(Key<SE2>),
    Pose3(Key<SE3>),
    Point2(Key<Rn<2>>),
    Point3(Key<Rn<3>>),
}

impl End {
    pub(super) fn kind(self) -> VertexKind {
        match self {
            Self::Pose2(_) => VertexKind::Pose2,
            Self::Pose3(_) => VertexKind::Pose3,
            Self::Point2(_) => VertexKind::Point2,
            Self::Point3(_) => VertexKind::Point3,
        }
    }
}

impl Keys {
    pub(super) fn end(&self, id: u64) -> Option<End> {
        let poses = self.pose2(id).map(End::Pose2).or_else(|| self.pose3(id).map(End::Pose3));
        let points = || self.point2(id).map(End::Point2).or_else(|| self.point3(id).map(End::Point3));
        poses.or_else(points)
    }

    /// An id that names two variables.
    pub(super) fn ambiguous(&self) -> Option<u64> {
        let named = |i: usize| {
            let kinds = [
                self.poses2[i].is_some(),
                self.poses3[i].is_some(),
                self.points2[i].is_some(),
                self.points3[i].is_some(),
            ];
            kinds.into_iter().filter(|named| *named).count()
        };
        let twice = self.repeated.or_else(|| (0..self.ids.len()).find(|&i| named(i) > 1));
        twice.map(|i| self.ids.as_slice()[i])
    }

    pub(super) fn pose2(&self, id: u64) -> Option<Key<SE2>> {
        self.poses2[self.ids.index(id)?]
    }
    pub(super) fn pose3(&self, id: u64) -> Option<Key<SE3>> {
        self.poses3[self.ids.index(id)?]
    }
    pub(super) fn point2(&self, id: u64) -> Option<Key<Rn<2>>> {
        self.points2[self.ids.index(id)?]
    }
    pub(super) fn point3(&self, id: u64) -> Option<Key<Rn<3>>> {
        self.points3[self.ids.index(id)?]
    }
}

/// Adds the vertices of one kind; returns the index of an id that is given twice.
pub(super) fn insert<V: Variable, T>(
    ids: &Ids,
    values: &mut Values,
    keys: &mut [Option<Key<V>>],
    vertices: &[Vertex<T>],
    value: impl Fn(&T) -> V,
) -> Option<usize> {
    let mut twice = None;
    for vertex in vertices {
        if let Some(i) = ids.index(vertex.id) {
            if keys[i].is_some() {
                twice = Some(i);
            }
            keys[i] = Some(values.insert_labelled(value(&vertex.value), vertex.id));
        }
    }
    twice
}

pub(super) fn declare<V: Variable>(
    ids: &Ids,
    values: &mut Values,
    keys: &mut [Option<Key<V>>],
    named: impl Iterator<Item = u64>,
) {
    let mut indices: Vec<usize> = named.filter_map(|id| ids.index(id)).collect();
    indices.sort_unstable();
    indices.dedup();
    for i in indices {
        keys[i].get_or_insert_with(|| values.declare(ids.as_slice()[i]));
    }
}
