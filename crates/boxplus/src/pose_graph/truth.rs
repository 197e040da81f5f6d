//! How far an estimate is from the truth.

use std::collections::HashMap;

use nalgebra::SVector;

use super::{PoseGraph, Vertex};
use crate::registration::{Pairs, RegistrationError, Rigid};

/// The error of a map whose poses are laid upon the true ones: a map by itself has no place in the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MapError {
    /// Poses that both maps have.
    pub poses: usize,
    /// Root mean square distance of their positions, metres.
    pub position: f64,
    /// The largest distance, metres.
    pub largest: f64,
    /// Root mean square angle between their rotations, radians.
    pub rotation: f64,
    /// Points that both maps have.
    pub points: usize,
    /// Root mean square distance of the points, metres, moved with the poses.
    pub landmark: f64,
}

impl PoseGraph {
    /// The vertices beside those of the same ids in `truth`, after the rigid motion of the whole map that brings the positions
    /// of poses nearest to the true ones. The dimension is that of which there are more poses.
    ///
    /// ```
    /// use boxplus::pose_graph::simulate::{Options, Simulator};
    /// use boxplus::pose_graph::{SolveSettings, solve::solve};
    /// let world = Simulator::Manhattan.simulate(&Options { size: Some(400), ..Options::default() })?;
    /// let solved = solve(&world.graph, &SolveSettings::default())?;
    /// let (before, after) = (world.graph.error_beside(&world.truth)?, solved.graph.error_beside(&world.truth)?);
    /// assert!(after.position < before.position);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`RegistrationError`], where too few poses, or poses on a line, do not determine the motion.
    pub fn error_beside(&self, truth: &Self) -> Result<MapError, RegistrationError> {
        if self.poses3.len() > self.poses2.len() {
            compare((&self.poses3, &self.points3), (&truth.poses3, &truth.points3))
        } else {
            compare((&self.poses2, &self.points2), (&truth.poses2, &truth.points2))
        }
    }
}

/// The poses and points of one dimension.
type Map<'a, G, const N: usize> = (&'a [Vertex<G>], &'a [Vertex<SVector<f64, N>>]);

fn compare<G: Rigid<D, N>, const D: usize, const N: usize>(
    map: Map<'_, G, N>,
    truth: Map<'_, G, N>,
) -> Result<MapError, RegistrationError> {
    let (poses, points) = (common(map.0, truth.0), common(map.1, truth.1));
    let position = |x: &G| x.act(&SVector::zeros());
    let [here, there]: [Vec<_>; 2] =
        [poses.iter().map(|(x, _)| position(x)).collect(), poses.iter().map(|(_, y)| position(y)).collect()];
    let moved = Pairs::new(&here, &there)?.align::<G, D>()?.target_from_source;
    let distances = poses.iter().map(|(x, y)| (moved.act(&position(x)) - position(y)).norm());
    let turns = poses.iter().map(|(x, y)| y.between(&moved.compose(x)).log().rows(N, D - N).norm());
    Ok(MapError {
        poses: poses.len(),
        position: rms(distances.clone()),
        largest: distances.fold(0.0, f64::max),
        rotation: rms(turns),
        points: points.len(),
        landmark: rms(points.iter().map(|(p, q)| (moved.act(p) - q).norm())),
    })
}

/// The values that two maps have under one id.
fn common<T: Copy>(map: &[Vertex<T>], truth: &[Vertex<T>]) -> Vec<(T, T)> {
    let truth: HashMap<u64, T> = truth.iter().map(|v| (v.id, v.value)).collect();
    map.iter().filter_map(|v| Some((v.value, *truth.get(&v.id)?))).collect()
}

/// Root mean square; 0 of nothing.
fn rms(numbers: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = numbers.fold((0, 0.0), |(n, sum), x| (n + 1, sum + x * x));
    if count == 0 { 0.0 } else { (sum / f64::from(count)).sqrt() }
}
