//! The path of a robot as odometry tells it: the poses of one kind in the order of ids, steps between neighbours, loops between others.
//!
//! An error of a displacement is local at its second end: i_from_j·Exp(ε), ε ~ N(0, Σ). Errors of links that follow each
//! other add up once they are brought to one frame by Ad, to first order.

use core::cmp::Reverse;
use std::collections::BinaryHeap;

use nalgebra::SMatrix;

use super::super::indefinite::{Indefinite, usable_information};
use crate::lie::LieGroup;
use crate::pose_graph::ids::Ids;
use crate::pose_graph::{Edge, Vertex};

/// A measured displacement between two poses.
#[derive(Clone, Debug)]
pub(super) struct Link<G, const D: usize> {
    /// Its place among the constraints of the graph.
    pub(super) place: usize,
    /// The ranks of its poses, in the order of ids.
    pub(super) ends: [usize; 2],
    /// first_from_second.
    pub(super) measured: G,
    /// Of the measurement, local at the second end.
    pub(super) covariance: SMatrix<f64, D, D>,
}

impl<G: LieGroup<D, Scalar = f64>, const D: usize> Link<G, D> {
    /// The rank of the pose that comes later.
    pub(super) fn later(&self) -> usize {
        self.ends[0].max(self.ends[1])
    }

    /// The same measurement seen from the other end.
    fn reversed(&self) -> Self {
        let adjoint = self.measured.adjoint(); // (Z·Exp(ε))⁻¹ = Z⁻¹·Exp(−Ad_Z ε)
        Self {
            ends: [self.ends[1], self.ends[0]],
            measured: self.measured.inverse(),
            covariance: adjoint * self.covariance * adjoint.transpose(),
            ..self.clone()
        }
    }
}

/// All displacements of one kind.
#[derive(Clone, Debug)]
pub(super) struct Track<G, const D: usize> {
    /// Between neighbours in the order of ids.
    pub(super) steps: Vec<Link<G, D>>,
    /// Between others: the loop closures.
    pub(super) loops: Vec<Link<G, D>>,
}

impl<G: LieGroup<D, Scalar = f64>, const D: usize> Track<G, D> {
    /// Of `edges` whose first is at `place` among the constraints. Those without usable information are left out.
    pub(super) fn new(edges: &[Edge<G, D>], place: usize, ids: &Ids, policy: Indefinite) -> Self {
        let link = |(place, e): (usize, &Edge<G, D>)| {
            let information = usable_information(&e.information, policy)?;
            Some(Link {
                place,
                ends: [ids.index(e.from)?, ids.index(e.to)?],
                measured: e.measured,
                covariance: information.cholesky()?.inverse(),
            })
        };
        let links = (place..).zip(edges).filter_map(link).filter(|link| link.ends[0] != link.ends[1]);
        let (steps, loops) = links.partition(|link| link.ends[0].abs_diff(link.ends[1]) == 1);
        Self { steps, loops }
    }
}

/// Odometry integrated: the displacement between any two poses that it joins, and its covariance, in constant time.
pub(super) struct Chain<G, const D: usize> {
    /// The poses, each run of steps from its own origin.
    poses: Vec<G>,
    /// Covariances summed up since the origin, in the frame of the origin.
    sums: Vec<SMatrix<f64, D, D>>,
    /// The rank at which the run of each pose began.
    origins: Vec<usize>,
}

impl<G: LieGroup<D, Scalar = f64>, const D: usize> Chain<G, D> {
    /// Of `count` poses. Of several steps between the same poses the first counts.
    pub(super) fn new(steps: &[Link<G, D>], count: usize) -> Self {
        let mut onward: Vec<Option<Link<G, D>>> = vec![None; count];
        for step in steps {
            let forward = if step.ends[0] < step.ends[1] { step.clone() } else { step.reversed() };
            let begin = forward.ends[0];
            onward[begin].get_or_insert(forward);
        }
        let mut chain = Self { poses: vec![], sums: vec![], origins: vec![] };
        let mut at = (G::identity(), SMatrix::zeros(), 0);
        for (rank, step) in onward.iter().enumerate() {
            chain.poses.push(at.0);
            chain.sums.push(at.1);
            chain.origins.push(at.2);
            at = match step {
                Some(step) => {
                    let pose = at.0.compose(&step.measured);
                    let adjoint = pose.adjoint();
                    (pose, at.1 + adjoint * step.covariance * adjoint.transpose(), at.2)
                }
                None => (G::identity(), SMatrix::zeros(), rank + 1),
            };
        }
        chain
    }

    /// i_from_j and its covariance, local at j.
    pub(super) fn between(&self, i: usize, j: usize) -> Option<(G, SMatrix<f64, D, D>)> {
        let joined = self.origins[i] == self.origins[j];
        let spread = if i < j { self.sums[j] - self.sums[i] } else { self.sums[i] - self.sums[j] };
        let adjoint = self.poses[j].inverse().adjoint();
        joined.then(|| (self.poses[i].between(&self.poses[j]), adjoint * spread * adjoint.transpose()))
    }
}

/// An estimate, and the measurements that are trusted: how far may it have drifted between two poses?
///
/// The shortest path of links gives an upper bound: what other paths know besides can only make it smaller.
pub(super) struct Net<G, const D: usize> {
    /// The estimate of each pose; none where the graph has no pose of this kind.
    poses: Vec<Option<G>>,
    ends: Vec<[usize; 2]>,
    covariances: Vec<SMatrix<f64, D, D>>,
    lengths: Vec<f64>,
    /// The links of each pose.
    of: Vec<Vec<usize>>,
}

impl<G: LieGroup<D, Scalar = f64>, const D: usize> Net<G, D> {
    /// The poses of `vertices` among all `ids`, and links that are trusted. The length of a link is its variance, coordinate by
    /// coordinate, in units of the first one's.
    pub(super) fn new<'a>(
        vertices: &[Vertex<G>],
        ids: &Ids,
        links: impl Iterator<Item = &'a Link<G, D>>,
    ) -> Self {
        let mut poses = vec![None; ids.len()];
        for vertex in vertices {
            if let Some(rank) = ids.index(vertex.id) {
                poses[rank] = Some(vertex.value);
            }
        }
        let mut net =
            Self { poses, ends: vec![], covariances: vec![], lengths: vec![], of: vec![vec![]; ids.len()] };
        let mut unit = None;
        for link in links {
            let variances = link.covariance.diagonal();
            let unit = *unit.get_or_insert(variances);
            link.ends.iter().for_each(|&end| net.of[end].push(net.ends.len()));
            net.ends.push(link.ends);
            net.covariances.push(link.covariance);
            net.lengths.push(variances.component_div(&unit).sum());
        }
        net
    }

    /// d² = εᵀS⁻¹ε of a displacement, ε = (X_i⁻¹X_j) ⊟ Z, where S is the covariance of Z and of the path from i to j; none where
    /// there is no path.
    pub(super) fn surprise(&self, link: &Link<G, D>) -> Option<f64> {
        let [i, j] = link.ends;
        let predicted = self.poses[i]?.between(&self.poses[j]?);
        let error = predicted.rminus(&link.measured);
        let spread = self.spread(i, j)? + link.covariance;
        Some(error.dot(&spread.cholesky()?.solve(&error)))
    }

    /// The covariance of X_i⁻¹X_j along the shortest path (Dijkstra (1959)), local at j.
    fn spread(&self, i: usize, j: usize) -> Option<SMatrix<f64, D, D>> {
        let mut came_by: Vec<Option<usize>> = vec![None; self.poses.len()];
        let mut length = vec![f64::INFINITY; self.poses.len()];
        let mut queue = BinaryHeap::from([(Reverse(0), j)]);
        length[j] = 0.0;
        while let Some((Reverse(bits), at)) = queue.pop() {
            if at == i {
                break;
            }
            if f64::from_bits(bits) > length[at] {
                continue; // a shorter way was found since
            }
            for &link in &self.of[at] {
                let next = self.other_end(link, at);
                let there = length[at] + self.lengths[link];
                if there < length[next] {
                    length[next] = there;
                    came_by[next] = Some(link);
                    queue.push((Reverse(there.to_bits()), next)); // positive numbers are ordered as their bits are
                }
            }
        }
        let (mut sum, mut at) = (SMatrix::zeros(), i);
        while at != j {
            let link = came_by[at]?;
            let adjoint = self.poses[j]?.between(&self.poses[self.ends[link][1]]?).adjoint();
            sum += adjoint * self.covariances[link] * adjoint.transpose();
            at = self.other_end(link, at);
        }
        Some(sum)
    }

    fn other_end(&self, link: usize, end: usize) -> usize {
        let [a, b] = self.ends[link];
        if a == end { b } else { a }
    }
}
