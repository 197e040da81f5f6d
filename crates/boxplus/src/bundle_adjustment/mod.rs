//! Bundle adjustment: cameras and points from images of the points.
//!
//! A [`Bundle`] is the problem as data, as Bundle Adjustment in the Large (Agarwal et al. (2010)) states it: views, each with a camera of
//! its own, points, and where which view saw which point. [`Bundle::faults`] finds what would make a solver fail or a reconstruction wrong,
//! [`solve`] finds the optimum, [`simulate`] makes problems whose truth is known.
//!
//! ```text
//! r = π(X_v⁻¹·l_p) − z     cost ½ Σ ρ(|r|²)     pixels, one for the standard deviation of each
//! ```
//!
//! # Pitfalls
//!
//! - **Nobody sees where the world is.** Images do not change where everything is moved, turned and scaled together: seven directions
//!   are free, and [`Solved::gauge`] says where the result was put: the first view of each part where it was, the farthest from it as far
//!   away as it was.
//! - **Points behind cameras** have images by the formula, and public problems hold some. They are counted before and after,
//!   and [`Behind`] says whether they take part.
//! - **Far points** have rays so nearly parallel that noise may make them meet behind the cameras: there the cost is least. Points are
//!   [`Projective`](crate::camera::Projective) while they are estimated, so that they get to infinity, and beyond, in a few steps;
//!   with coordinates in space, as most solvers have them, they go half of the way a step, and the cost creeps.
//! - **A point seen once** fits whatever the camera does; it says nothing of it. [`Fault::SeenOnce`] counts them.

mod faults;
mod gauge;
pub mod simulate;
#[cfg(feature = "solve")]
pub mod solve;

pub use crate::pose_graph::{Line, Severity};
pub use faults::Fault;
pub use gauge::{Anchor, Gauge};
#[cfg(feature = "solve")]
pub use solve::{Behind, BundleError, Intrinsics, Settings, Solved};

use crate::camera::{Snavely, Unseen, View};
use nalgebra::{Vector2, Vector3};

/// Pose and camera of an image: the nine numbers of BAL.
pub type BalView = View<Snavely, 3, 9>;

/// A point seen in a view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// Number of the view, from 0.
    pub view: u32,
    /// Number of the point, from 0.
    pub point: u32,
    /// z, in pixels from the middle of the image, v upwards.
    pub pixel: Vector2<f64>,
    /// Where it was read.
    pub line: Line,
}

/// A problem of bundle adjustment: see the [module](self).
///
/// ```
/// use boxplus::bundle_adjustment::{Settings, simulate::{Options, World}, solve::solve};
/// let world = World::Ring.simulate(&Options { views: 8, points: 60, ..Options::default() })?;
/// assert!(world.bundle.faults().is_empty());
/// let solved = solve(&world.bundle, &Settings::default())?;
/// assert!(solved.report.converged() && solved.gauge.free == 7);
/// assert!(solved.rms() < 2.0 && solved.initial_rms() > 2.0); // pixels; the noise is one pixel in u and in v
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bundle {
    /// The images' poses and cameras.
    pub views: Vec<BalView>,
    /// The points, in the units of the poses.
    pub points: Vec<Vector3<f64>>,
    /// Which view saw which point, and where.
    pub observations: Vec<Observation>,
}

impl Bundle {
    /// r = π(X⁻¹·l) − z of an observation, in pixels; `None` where it is of a view or a point that does not exist.
    pub fn residual(&self, observation: &Observation) -> Option<Vector2<f64>> {
        let (view, point) = self.joined(observation)?;
        Some(view.image(point) - observation.pixel)
    }

    /// ½ Σ |r|², in pixels squared, of the observations of views and points that exist; also of those behind a camera.
    pub fn cost(&self) -> f64 {
        let residuals = self.observations.iter().filter_map(|o| self.residual(o));
        0.5 * residuals.map(|r| r.norm_squared()).sum::<f64>()
    }

    /// The observations of points that their view cannot have seen, and why, in order.
    pub fn unseen(&self) -> impl Iterator<Item = (&Observation, Unseen)> {
        self.observations.iter().filter_map(|o| {
            let (view, point) = self.joined(o)?;
            view.sees(point).err().map(|why| (o, why))
        })
    }

    /// The view and the point of an observation.
    pub(crate) fn joined(&self, observation: &Observation) -> Option<(&BalView, &Vector3<f64>)> {
        self.views.get(observation.view as usize).zip(self.points.get(observation.point as usize))
    }
}
