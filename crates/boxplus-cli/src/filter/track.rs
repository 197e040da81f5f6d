//! What a filter made of the logs, of the plane or of space.

use boxplus::lie::{LieGroup, SE2, SE3, SO3};
use boxplus::recording::{Fates, Score, Stamped, Track, seconds};
use boxplus::uncertainty::Gaussian;
use nalgebra::Vector3;

use crate::draw::{DEGREES, Ellipse, ErrorChart, Panel, charts, in_plane, in_space, path};

/// Points of a band that are drawn at most.
const BAND: usize = 3000;

/// A pose that can be told and drawn.
pub trait Drawn<const D: usize>: LieGroup<D, Scalar = f64> {
    const SPATIAL: bool;
    /// Names of the local coordinates, with what makes of their unit that of print.
    const COORDINATES: [(&'static str, f64); D];
    fn in_space(&self) -> SE3;
    fn ellipse(belief: &Gaussian<Self, D>) -> Ellipse;
}

impl Drawn<3> for SE2 {
    const SPATIAL: bool = false;
    const COORDINATES: [(&'static str, f64); 3] =
        [("ahead [m]", 1.0), ("to the left [m]", 1.0), ("heading [°]", DEGREES)];
    fn in_space(&self) -> SE3 {
        SE3::new(SO3::about_z(self.angle()), self.translation().push(0.0))
    }
    fn ellipse(belief: &Gaussian<Self, 3>) -> Ellipse {
        in_plane(belief)
    }
}

impl Drawn<6> for SE3 {
    const SPATIAL: bool = true;
    const COORDINATES: [(&'static str, f64); 6] = [
        ("x of the body [m]", 1.0),
        ("y [m]", 1.0),
        ("z [m]", 1.0),
        ("roll [°]", DEGREES),
        ("pitch [°]", DEGREES),
        ("yaw [°]", DEGREES),
    ];
    fn in_space(&self) -> SE3 {
        *self
    }
    fn ellipse(belief: &Gaussian<Self, 6>) -> Ellipse {
        in_space(belief)
    }
}

/// A track, without its type.
pub struct Filtered {
    /// The poses, in space.
    pub poses: Vec<Stamped<SE3>>,
    /// Standard deviations of the last one, by name.
    pub last: Vec<(&'static str, f64)>,
    /// What became of the measurements.
    pub fates: Fates,
    /// Beside the truth, where it is known.
    pub score: Option<Scored>,
    /// The path, and the errors where the truth is known.
    pub picture: (Panel, Vec<ErrorChart>),
}

/// A track beside the truth.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct Scored {
    /// How many poses were judged.
    pub poses: usize,
    /// RMSE in metres.
    pub position: f64,
    /// RMSE in degrees.
    pub rotation_deg: f64,
    /// Share of the errors within 3σ, coordinate by coordinate.
    pub inside_three_sigma: f64,
    /// Average NEES of a coordinate; 1 where the covariance is as claimed.
    pub nees: f64,
}

impl Filtered {
    pub fn new<G: Drawn<D>, const D: usize>(
        track: &Track<G, D>,
        truth: &[Stamped<G>],
        fates: Fates,
        landmarks: Vec<Vector3<f64>>,
    ) -> Self {
        let last = track.last().map_or([0.0; D], |belief| belief.value.sigmas().into());
        let named = G::COORDINATES.into_iter().zip(last);
        let score = Score::new(track, truth, apart(truth));
        let start_ns = track.first().map_or(0, |belief| belief.stamp_ns);
        let every = track.len().div_ceil(BAND).max(1);
        let band = track.iter().step_by(every).map(|belief| G::ellipse(&belief.value)).collect();
        let during = |pose: &&Stamped<G>| {
            track.last().is_some_and(|last| (start_ns..=last.stamp_ns).contains(&pose.stamp_ns))
        };
        let truth = truth.iter().filter(during).map(|pose| pose.value.in_space().translation()).collect();
        let judged = !score.judged.is_empty();
        let errors = if judged { charts(&score, start_ns, G::COORDINATES) } else { Vec::new() };
        Self {
            poses: track.iter().map(|belief| belief.map(|belief| belief.mean().in_space())).collect(),
            last: named.map(|((name, factor), sigma)| (name, sigma * factor)).collect(),
            fates,
            score: judged.then(|| Scored::of(&score)),
            picture: (path(G::SPATIAL, band, truth, landmarks), errors),
        }
    }

    /// How long the track is, in seconds.
    pub fn seconds(&self) -> f64 {
        match self.poses.as_slice() {
            [first, .., last] => seconds(first.stamp_ns, last.stamp_ns),
            _ => 0.0,
        }
    }
}

impl Scored {
    fn of<const D: usize>(score: &Score<D>) -> Self {
        // Positions come first: of three coordinates two, of six three.
        let position = D.div_ceil(2);
        Self {
            poses: score.judged.len(),
            position: score.rmse(0..position),
            rotation_deg: score.rmse(position..D).to_degrees(),
            inside_three_sigma: score.inside(0..D, 3.0),
            nees: score.mean_nees(),
        }
    }
}

/// Between samples of the truth farther apart than this there is a gap: five times the usual.
fn apart<T>(truth: &[Stamped<T>]) -> f64 {
    match truth {
        [first, .., last] => 5.0 * seconds(first.stamp_ns, last.stamp_ns) / (truth.len() - 1) as f64,
        _ => 0.0,
    }
}
