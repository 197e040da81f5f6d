//! What a pose graph looks like.

use std::collections::HashMap;

use boxplus::pose_graph::{Constraint, PoseGraph, VertexKind};
use nalgebra::Vector3;

use super::scene::{Link, Scene};

impl Scene {
    /// The marks of `graph` where its vertices are. `residuals` has one number for each of its constraints, in their
    /// order: √(χ² per degree of freedom).
    pub fn of(graph: &PoseGraph, residuals: &[f64]) -> Self {
        let places = Places::of(graph);
        let mut scene = Self {
            spatial: !graph.poses3.is_empty() || !graph.points3.is_empty(),
            landmarks: graph.points2.iter().map(|v| v.value.push(0.0)).collect(),
            ..Self::default()
        };
        scene.landmarks.extend(graph.points3.iter().map(|v| v.value));
        let mut joined = vec![false; places.travel.len()];
        let residuals = residuals.iter().copied().chain(std::iter::repeat(f64::NAN));
        for (constraint, residual) in graph.constraints().zip(residuals) {
            scene.add(&constraint, residual, &places, &mut joined);
        }
        scene.tracks = places.tracks(&joined);
        scene
    }

    fn add(&mut self, constraint: &Constraint<'_>, residual: f64, places: &Places, joined: &mut [bool]) {
        let (Some(to), Some(kind)) = (constraint.to, constraint.kind.to_kind()) else { return };
        let (Some(a), Some(b)) = (places.at(constraint.from), places.at(to)) else { return };
        if matches!(kind, VertexKind::Point2 | VertexKind::Point3) {
            self.sightings.push([a, b]);
        } else if let Some(first) = places.step(constraint.from, to) {
            joined[first] = true;
        } else {
            self.loops.push(Link { ends: [a, b], residual });
        }
    }
}

/// Where the vertices are, and the poses in the order of travel: that of their numbers.
pub struct Places {
    travel: Vec<(u64, Vector3<f64>)>,
    order: HashMap<u64, usize>,
    points: HashMap<u64, Vector3<f64>>,
}

impl Places {
    /// Those of `graph`.
    pub fn of(graph: &PoseGraph) -> Self {
        let plane = graph.poses2.iter().map(|v| (v.id, v.value.translation().push(0.0)));
        let space = graph.poses3.iter().map(|v| (v.id, v.value.translation()));
        let mut travel: Vec<_> = plane.chain(space).collect();
        travel.sort_by_key(|pose| pose.0);
        let order = travel.iter().enumerate().map(|(i, pose)| (pose.0, i)).collect();
        let points = graph.points2.iter().map(|v| (v.id, v.value.push(0.0)));
        let points = points.chain(graph.points3.iter().map(|v| (v.id, v.value))).collect();
        Self { travel, order, points }
    }

    /// Of a pose or a point.
    pub fn at(&self, id: u64) -> Option<Vector3<f64>> {
        self.order.get(&id).map(|&i| self.travel[i].1).or_else(|| self.points.get(&id).copied())
    }

    /// The earlier of two poses that follow each other.
    fn step(&self, from: u64, to: u64) -> Option<usize> {
        let (&a, &b) = (self.order.get(&from)?, self.order.get(&to)?);
        (a.abs_diff(b) == 1).then_some(a.min(b))
    }

    /// Poses joined to the next one travel together.
    fn tracks(&self, joined: &[bool]) -> Vec<Vec<Vector3<f64>>> {
        let mut tracks = vec![Vec::new()];
        for (pose, joined) in self.travel.iter().zip(joined) {
            if let Some(track) = tracks.last_mut() {
                track.push(pose.1);
            }
            if !joined {
                tracks.push(Vec::new());
            }
        }
        tracks.retain(|track| !track.is_empty());
        tracks
    }
}
