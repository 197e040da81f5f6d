//! What is drawn of a pose graph, freed from its types.

use nalgebra::{Matrix3, Vector3};

/// The marks of one pose graph, in metres of its world frame.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Drawn in space rather than as a plan.
    pub spatial: bool,
    /// Poses joined by odometry, in the order of travel.
    pub tracks: Vec<Vec<Vector3<f64>>>,
    /// Edges between poses that do not follow each other.
    pub loops: Vec<Link>,
    /// Edges between poses and landmarks.
    pub sightings: Vec<[Vector3<f64>; 2]>,
    /// Landmarks.
    pub landmarks: Vec<Vector3<f64>>,
    /// Cameras: the centre, then the corners of the image, in turn.
    pub views: Vec<[Vector3<f64>; 5]>,
    /// Point clouds: one that stays, one that is moved.
    pub clouds: [Vec<Vector3<f64>>; 2],
    /// How sure the positions are.
    pub ellipses: Vec<Ellipse>,
    /// Where the poses truly were, in the order of travel.
    pub truth: Vec<Vector3<f64>>,
    /// How sure the positions are, in the order of travel: a band along them.
    pub band: Vec<Ellipse>,
}

/// A loop closure.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    /// Its two poses.
    pub ends: [Vector3<f64>; 2],
    /// √(χ² per degree of freedom): standard deviations.
    pub residual: f64,
}

/// A position and its covariance, in world axes.
#[derive(Clone, Copy, Debug)]
pub struct Ellipse {
    /// Metres.
    pub centre: Vector3<f64>,
    /// Square metres.
    pub covariance: Matrix3<f64>,
}

impl Scene {
    /// Every position, each at least once; those that are not finite are left out.
    pub fn points(&self) -> Vec<Vector3<f64>> {
        let ends = self.loops.iter().flat_map(|l| l.ends);
        let all = self
            .tracks
            .iter()
            .flatten()
            .chain(&self.truth)
            .chain(self.views.iter().flatten())
            .copied()
            .chain(ends)
            .chain(self.landmarks.iter().copied())
            .chain(self.clouds.iter().flatten().copied());
        all.filter(|p| p.iter().all(|x| x.is_finite())).collect()
    }
}
