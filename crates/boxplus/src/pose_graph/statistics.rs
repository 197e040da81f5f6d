//! Counts and sizes of a pose graph.

use super::constraint::{Constraint, Kind, Measured, VertexKind};
use super::ids::Ids;
use super::information::spectrum;
use super::{Label, PoseGraph};
use nalgebra::{SMatrix, Vector3};
use std::collections::BTreeMap;

/// How many measurements join a vertex to others.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Degree {
    /// Of the loneliest vertex.
    pub min: usize,
    /// On average.
    pub mean: f64,
    /// Of the busiest vertex.
    pub max: usize,
}

/// What a pose graph consists of. See [`PoseGraph::statistics`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Poses with an initial value.
    pub poses: usize,
    /// Points with an initial value.
    pub points: usize,
    /// Ids that a vertex or a measurement names.
    pub ids: usize,
    /// The lowest and the highest id.
    pub id_range: Option<(u64, u64)>,
    /// Ids in the range, of the letters that there are, that nothing names.
    pub id_gaps: u64,
    /// Vertices to be held fixed.
    pub fixed: usize,
    /// How many measurements of each kind, without zeros.
    pub counts: Vec<(Kind, usize)>,
    /// Edges between poses that do not follow each other in the order of ids.
    pub loop_closures: usize,
    /// Measurements beyond the first that join the same two vertices, in either direction.
    pub repeated_edges: usize,
    /// Parts that no measurement joins.
    pub components: usize,
    /// How many vertices the largest part has.
    pub largest_component: usize,
    /// Measurements per vertex.
    pub degree: Degree,
    /// The lowest and the highest corner of the box around all initial positions, metres.
    pub bounds: Option<(Vector3<f64>, Vector3<f64>)>,
    /// Sum of the distances between the initial positions of poses that follow each other, metres.
    pub trajectory_length: f64,
    /// The smallest and the largest eigenvalue of all information matrices that are positive definite.
    pub information_range: Option<(f64, f64)>,
    /// Median over the edges between poses of √(tr Σ_t/d), metres.
    pub sigma_translation: Option<f64>,
    /// Median over the edges between poses of √(tr Σ_r/(1 or 3)), radians if the information weighs rotation vectors.
    pub sigma_rotation: Option<f64>,
    /// Tags that are not understood, with their counts.
    pub other: Vec<(String, usize)>,
}

impl PoseGraph {
    /// Counts, connection, extent and noise.
    ///
    /// ```
    /// use boxplus::pose_graph::simulate::{Options, Simulator};
    /// let statistics = Simulator::Sphere.simulate(&Options::default())?.graph.statistics();
    /// assert_eq!((statistics.poses, statistics.loop_closures, statistics.components), (2500, 2450, 1));
    /// assert!((statistics.sigma_translation.unwrap() - 0.05).abs() < 1e-12);
    /// # Ok::<(), boxplus::pose_graph::simulate::OptionsError>(())
    /// ```
    pub fn statistics(&self) -> Statistics {
        let ids = self.ids();
        let joined = self.joined(&ids);
        let (loop_closures, repeated_edges) = self.loops(&joined);
        let parts: Vec<usize> = self.partition(&ids).parts().map(|(_, size)| size).collect();
        let id_range = ids.as_slice().first().copied().zip(ids.as_slice().last().copied());
        let (sigma_translation, sigma_rotation) = self.noise();
        Statistics {
            poses: self.poses2.len() + self.poses3.len(),
            points: self.points2.len() + self.points3.len(),
            ids: ids.len(),
            id_range,
            id_gaps: gaps(ids.as_slice()),
            fixed: self.fixed.len(),
            counts: self.counts(),
            loop_closures,
            repeated_edges,
            components: parts.len(),
            largest_component: parts.into_iter().max().unwrap_or(0),
            degree: degree(&joined, ids.len()),
            bounds: self.bounds(),
            trajectory_length: self.trajectory_length(),
            information_range: self.information_range(),
            sigma_translation,
            sigma_rotation,
            other: self.other_tags(),
        }
    }

    /// Which measurements are loop closures, in the order of [`PoseGraph::constraints`]: edges between poses of which neither
    /// follows the other in the order of ids. The others are odometry, or measure points, or are priors.
    ///
    /// ```
    /// use boxplus::pose_graph::simulate::{Options, Simulator};
    /// let graph = Simulator::Sphere.simulate(&Options::default())?.graph;
    /// let closes = graph.loop_closures();
    /// assert_eq!((closes[0], closes[2499]), (false, true)); // 0 → 1, then 0 → 50
    /// # Ok::<(), boxplus::pose_graph::simulate::OptionsError>(())
    /// ```
    pub fn loop_closures(&self) -> Vec<bool> {
        // Points may be numbered between poses: what follows what is a matter of the poses alone.
        let poses = Ids::new(self.pose_ids());
        let closes = |c: Constraint<'_>| {
            let ends = c.to.filter(|_| matches!(c.kind, Kind::Edge2 | Kind::Edge3));
            let ranks = ends.and_then(|to| Some((poses.index(c.from)?, poses.index(to)?)));
            ranks.is_some_and(|(i, j)| i.abs_diff(j) > 1)
        };
        self.constraints().map(closes).collect()
    }

    fn counts(&self) -> Vec<(Kind, usize)> {
        let mut counts = BTreeMap::new();
        self.constraints().for_each(|c| *counts.entry(c.kind).or_insert(0) += 1);
        counts.into_iter().collect()
    }

    fn other_tags(&self) -> Vec<(String, usize)> {
        let mut counts = BTreeMap::new();
        self.other.iter().for_each(|line| *counts.entry(line.tag()).or_insert(0) += 1);
        counts.into_iter().map(|(tag, count)| (tag.to_owned(), count)).collect()
    }

    /// The indices that each measurement joins, lower first, and whether both are poses.
    fn joined(&self, ids: &Ids) -> Vec<(usize, usize, bool)> {
        let pair = |c: Constraint<'_>| {
            let (i, j) = (ids.index(c.from)?, ids.index(c.to?)?);
            Some((i.min(j), i.max(j), matches!(c.kind, Kind::Edge2 | Kind::Edge3)))
        };
        self.constraints().filter_map(pair).collect()
    }

    /// Loop closures and repeated measurements.
    fn loops(&self, joined: &[(usize, usize, bool)]) -> (usize, usize) {
        let mut pairs: Vec<_> = joined.iter().map(|(i, j, _)| (*i, *j)).collect();
        pairs.sort_unstable();
        pairs.dedup();
        let closures = self.loop_closures().into_iter().filter(|closes| *closes).count();
        (closures, joined.len() - pairs.len())
    }

    /// The ids of poses, named by vertices or by measurements.
    fn pose_ids(&self) -> impl Iterator<Item = u64> {
        let vertices = self.poses2.iter().map(|v| v.id).chain(self.poses3.iter().map(|v| v.id));
        let pose = |kind| matches!(kind, Some(VertexKind::Pose2 | VertexKind::Pose3));
        vertices.chain(self.constraints().flat_map(move |c| {
            let from = pose(c.kind.from_kind()).then_some(c.from);
            let to = c.to.filter(|_| pose(c.kind.to_kind()));
            from.into_iter().chain(to)
        }))
    }

    /// All initial positions.
    fn positions(&self) -> impl Iterator<Item = Vector3<f64>> {
        let flat =
            self.poses2.iter().map(|v| v.value.translation()).chain(self.points2.iter().map(|v| v.value));
        let spatial =
            self.poses3.iter().map(|v| v.value.translation()).chain(self.points3.iter().map(|v| v.value));
        flat.map(|p| Vector3::new(p.x, p.y, 0.0)).chain(spatial)
    }

    fn bounds(&self) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let boxes = self.positions().map(|p| (p, p));
        boxes.reduce(|(low, high), (p, _)| (low.inf(&p), high.sup(&p)))
    }

    fn trajectory_length(&self) -> f64 {
        let flat = self.poses2.iter().map(|v| (v.id, v.value.translation().push(0.0)));
        let mut path: Vec<_> =
            flat.chain(self.poses3.iter().map(|v| (v.id, v.value.translation()))).collect();
        path.sort_by_key(|(id, _)| *id);
        path.windows(2).map(|step| (step[1].1 - step[0].1).norm()).sum()
    }

    fn information_range(&self) -> Option<(f64, f64)> {
        let mut last: (&[f64], Option<(f64, f64)>) = (&[], None);
        let mut range: Option<(f64, f64)> = None;
        for Constraint { information, .. } in self.constraints() {
            if last.0 == information {
                continue; // Most files use few different matrices.
            }
            last = (information, spectrum(information).ok());
            if let Some((low, high)) = last.1 {
                range = Some(range.map_or((low, high), |(l, h)| (l.min(low), h.max(high))));
            }
        }
        range
    }

    fn noise(&self) -> (Option<f64>, Option<f64>) {
        let sigmas = |c: Constraint<'_>| match c.measured {
            Measured::Pose2(_) if c.to.is_some() => sigmas::<3>(c.information, 2),
            Measured::Pose3(_) if c.to.is_some() => sigmas::<6>(c.information, 3),
            _ => None,
        };
        let (translation, rotation) = self.constraints().filter_map(sigmas).unzip();
        (median(translation), median(rotation))
    }
}

/// Ids between others of the same letter that are missing.
fn gaps(ids: &[u64]) -> u64 {
    let neighbours = ids.windows(2).filter(|pair| Label(pair[0]).letter() == Label(pair[1]).letter());
    neighbours.map(|pair| pair[1] - pair[0] - 1).sum()
}

fn degree(joined: &[(usize, usize, bool)], n: usize) -> Degree {
    let mut degrees = vec![0; n];
    for &(i, j, _) in joined {
        degrees[i] += 1;
        degrees[j] += usize::from(i != j);
    }
    let sum: usize = degrees.iter().sum();
    let (min, max) = (degrees.iter().min().copied(), degrees.iter().max().copied());
    Degree { min: min.unwrap_or(0), mean: sum as f64 / n.max(1) as f64, max: max.unwrap_or(0) }
}

/// Root mean square σ of the first `split` directions and of the others, if Ω is positive definite.
fn sigmas<const D: usize>(information: &[f64], split: usize) -> Option<(f64, f64)> {
    let covariance = SMatrix::<f64, D, D>::from_column_slice(information).cholesky()?.inverse().diagonal();
    let mean = |range: &[f64]| (range.iter().sum::<f64>() / range.len() as f64).sqrt();
    let (translation, rotation) = covariance.as_slice().split_at(split);
    Some((mean(translation), mean(rotation)))
}

/// The middle of a list, the upper one of two.
fn median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}
