//! The optimum of a bundle, and how good it is.

use core::ops::ControlFlow;

use super::{BalView, Bundle, Fault, Gauge, Observation, Severity};
use crate::camera::{Projective, Snavely, View};
use crate::graph::{
    Graph, GraphError, Iteration, Kernel, Key, Noise, ReprojectionOwn, ReprojectionShared, SolveOptions,
    SolveReport, Values, Variable,
};
use crate::lie::SE3;
use nalgebra::Vector3;

/// What is estimated of the cameras.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Intrinsics {
    /// Every view has its own.
    #[default]
    Own,
    /// All views were taken by one camera: that of the first view is the start.
    Shared,
    /// They are known, and stay.
    Known,
}

/// What becomes of observations of points that their view does not see at the start, behind it or beyond its lens.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Behind {
    /// They take part by the bare formula, as in Ceres: the pull of their image may bring them before the camera.
    #[default]
    Keep,
    /// They are left out, as in GTSAM, and counted.
    LeaveOut,
}

/// How a bundle is adjusted.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// How much a large residual may pull; scales in pixels.
    pub kernel: Kernel,
    /// What is estimated of the cameras.
    pub intrinsics: Intrinsics,
    /// What becomes of points behind cameras.
    pub behind: Behind,
    /// Views that stay as they are, pose and camera.
    pub fixed: Vec<usize>,
    /// How to move and when to stop.
    pub options: SolveOptions,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            kernel: Kernel::None,
            intrinsics: Intrinsics::Own,
            behind: Behind::Keep,
            fixed: vec![],
            options: Self::options(),
        }
    }
}

impl Settings {
    /// The options of the solver that suit bundles: more damping at the start, because depths are far from linear, and a tolerance that
    /// images of a pixel's noise can tell. The gauge is known to be free, so that no search for free directions is made.
    pub fn options() -> SolveOptions {
        SolveOptions {
            initial_damping: 1e-4,
            relative_cost: 1e-7,
            diagnose: false,
            ..SolveOptions::default()
        }
    }
}

/// Why a bundle cannot be adjusted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BundleError {
    /// The problem itself is faulty.
    #[error("{} fault(s) make the bundle unsolvable; the first: {}", faults.len(), faults[0])]
    Faulty {
        /// All of them, at least one.
        faults: Vec<Fault>,
    },
    /// A view is to be held that does not exist.
    #[error("view {view} is to be held, but there are {views} views, counted from 0")]
    NoSuchView {
        /// Its number.
        view: usize,
        /// How many there are.
        views: usize,
    },
    /// The solver refused.
    #[error(transparent)]
    Graph(#[from] GraphError),
}

/// An optimum, and how good it is.
#[derive(Clone, Debug)]
pub struct Solved {
    /// The input with views and points at the optimum.
    pub bundle: Bundle,
    /// The cost ½ Σ ρ(|r|²) of the input, in pixels squared, of the observations that take part.
    pub initial_cost: f64,
    /// The cost of the optimum.
    pub cost: f64,
    /// How the optimisation went.
    pub report: SolveReport,
    /// What images do not tell, and where the result was put.
    pub gauge: Gauge,
    /// Observations that take part.
    pub used: usize,
    /// Observations of points that their view does not see: at the start.
    pub unseen_before: usize,
    /// And at the optimum, where it may be more: rays that meet under hardly any parallax may well meet behind the cameras.
    pub unseen_after: usize,
    /// |r|² of every observation at the optimum, in pixels squared, without kernel; also of those left out.
    pub squared: Vec<f64>,
}

impl Solved {
    /// The root mean square of |r| over the observations that take part, in pixels, by the cost: of the optimum.
    pub fn rms(&self) -> f64 {
        self.per_observation(self.cost)
    }

    /// And of the input.
    pub fn initial_rms(&self) -> f64 {
        self.per_observation(self.initial_cost)
    }

    fn per_observation(&self, cost: f64) -> f64 {
        (2.0 * cost / self.used.max(1) as f64).sqrt()
    }

    /// Places of the `count` observations that fit worst, worst first.
    pub fn worst(&self, count: usize) -> Vec<usize> {
        let mut all: Vec<usize> = (0..self.squared.len()).collect();
        all.sort_by(|&a, &b| self.squared[b].total_cmp(&self.squared[a]).then(a.cmp(&b)));
        all.truncate(count);
        all
    }
}

/// Finds the optimum of a bundle from where it is.
///
/// Not converging is no error: see [`SolveReport::termination`].
///
/// # Errors
/// [`BundleError`].
pub fn solve(bundle: &Bundle, settings: &Settings) -> Result<Solved, BundleError> {
    solve_observed(bundle, settings, &mut |_| ControlFlow::Continue(()))
}

/// As [`solve`]; `observer` sees every trial step, and may stop with the best estimate so far.
///
/// # Errors
/// As [`solve`].
pub fn solve_observed(
    bundle: &Bundle,
    settings: &Settings,
    observer: &mut dyn FnMut(&Iteration) -> ControlFlow<()>,
) -> Result<Solved, BundleError> {
    check(bundle, settings)?;
    let problem = Problem::new(bundle, settings);
    let solution = problem.graph.optimize_observed(&problem.values, &settings.options, observer)?;
    let mut solved = problem.read(bundle, &solution.values);
    let gauge = solved.stand_as(bundle, &settings.fixed);
    let squared =
        solved.observations.iter().map(|o| solved.residual(o).map_or(f64::NAN, |r| r.norm_squared()));
    Ok(Solved {
        initial_cost: solution.report.initial_cost,
        cost: solution.report.cost,
        report: solution.report,
        gauge,
        used: problem.graph.len(),
        unseen_before: bundle.unseen().count(),
        unseen_after: solved.unseen().count(),
        squared: squared.collect(),
        bundle: solved,
    })
}

fn check(bundle: &Bundle, settings: &Settings) -> Result<(), BundleError> {
    let mut faults = bundle.faults();
    faults.retain(|fault| fault.severity() == Severity::Error);
    if !faults.is_empty() {
        return Err(BundleError::Faulty { faults });
    }
    match settings.fixed.iter().find(|&&view| view >= bundle.views.len()) {
        Some(&view) => Err(BundleError::NoSuchView { view, views: bundle.views.len() }),
        None => Ok(()),
    }
}

/// The bundle as factors, in a world whose origin is amid the views and whose unit is about the distance of points: to homogeneous
/// coordinates both matter.
struct Problem {
    graph: Graph,
    values: Values,
    views: Views,
    points: Vec<Key<Projective>>,
    frame: Frame,
}

/// The variables of the views.
enum Views {
    /// Pose and camera as one.
    Own(Vec<Key<BalView>>),
    /// Poses, and for each the camera: one and the same, or held.
    Apart(Vec<Key<SE3>>, Vec<Key<Snavely>>),
}

/// Where the world of the variables has its origin, and its unit.
#[derive(Clone, Copy)]
struct Frame {
    origin: Vector3<f64>,
    unit: f64,
}

impl Frame {
    fn of(bundle: &Bundle) -> Self {
        let places = bundle.views.iter().map(|view| view.world_from_camera.translation());
        let origin = places.sum::<Vector3<f64>>() / bundle.views.len().max(1) as f64;
        let mut distances: Vec<f64> = bundle.points.iter().map(|p| (p - origin).norm()).collect();
        distances.sort_unstable_by(f64::total_cmp);
        let median = distances.get(distances.len() / 2).copied().unwrap_or(1.0);
        Self { origin, unit: if median > 0.0 { median } else { 1.0 } }
    }

    fn enter(self, view: &BalView) -> BalView {
        let pose = view.world_from_camera;
        let place = (pose.translation() - self.origin) / self.unit;
        BalView { world_from_camera: SE3::new(pose.rotation(), place), ..*view }
    }

    fn leave(self, view: &BalView) -> BalView {
        let pose = view.world_from_camera;
        let place = self.origin + pose.translation() * self.unit;
        BalView { world_from_camera: SE3::new(pose.rotation(), place), ..*view }
    }
}

impl Problem {
    fn new(bundle: &Bundle, settings: &Settings) -> Self {
        let (mut values, frame) = (Values::new(), Frame::of(bundle));
        let views = Views::new(bundle, settings, frame, &mut values);
        let points = bundle
            .points
            .iter()
            .zip(0..)
            .map(|(p, i)| values.insert_labelled(Projective::new(&(p - frame.origin), frame.unit), i));
        let points: Vec<_> = points.collect();
        let mut graph = Graph::new();
        for o in bundle.observations.iter().filter(|o| takes_part(bundle, settings, o)) {
            let (view, point) = (o.view as usize, points[o.point as usize]);
            let (noise, kernel) = (Noise::unit(), settings.kernel);
            match &views {
                Views::Own(keys) => {
                    graph.add_robust((keys[view], point), ReprojectionOwn::new(o.pixel), noise, kernel)
                }
                Views::Apart(poses, cameras) => {
                    let keys = (poses[view], point, cameras[view]);
                    graph.add_robust(keys, ReprojectionShared::new(o.pixel), noise, kernel)
                }
            };
        }
        Self { graph, values, views, points, frame }
    }

    /// The bundle with the values of the variables. What did not move keeps its bits.
    fn read(&self, bundle: &Bundle, values: &Values) -> Bundle {
        let mut read = bundle.clone();
        for (point, &key) in read.points.iter_mut().zip(&self.points) {
            if let Some(found) = values.get(key).filter(|found| self.values.get(key) != Some(found)) {
                *point = self.frame.origin + found.place(self.frame.unit);
            }
        }
        for (i, view) in read.views.iter_mut().enumerate() {
            let (from, to) = (self.views.get(i, &self.values), self.views.get(i, values));
            if from != to {
                *view = to.map_or(*view, |to| self.frame.leave(&to));
            }
        }
        read
    }
}

impl Views {
    fn new(bundle: &Bundle, settings: &Settings, frame: Frame, values: &mut Values) -> Self {
        let views: Vec<_> = bundle.views.iter().map(|view| frame.enter(view)).zip(0_u64..).collect();
        let held = |i: u64| settings.fixed.contains(&(i as usize));
        if settings.intrinsics == Intrinsics::Own {
            return Self::Own(views.iter().map(|(view, i)| insert(values, *view, *i, held(*i))).collect());
        }
        let poses = views.iter().map(|(view, i)| insert(values, view.world_from_camera, *i, held(*i)));
        let poses = poses.collect();
        let cameras = match (settings.intrinsics, views.first()) {
            (Intrinsics::Shared, Some((first, _))) => {
                vec![insert(values, first.camera, 0, false); views.len()]
            }
            _ => views.iter().map(|(view, i)| insert(values, view.camera, *i, true)).collect(),
        };
        Self::Apart(poses, cameras)
    }

    fn get(&self, i: usize, values: &Values) -> Option<BalView> {
        match self {
            Self::Own(keys) => values.get(keys[i]).copied(),
            Self::Apart(poses, cameras) => {
                let (pose, camera) = (values.get(poses[i])?, values.get(cameras[i])?);
                Some(View { world_from_camera: *pose, camera: *camera })
            }
        }
    }
}

fn insert<V: Variable>(values: &mut Values, value: V, label: u64, held: bool) -> Key<V> {
    let key = values.insert_labelled(value, label);
    if held {
        values.hold(key);
    }
    key
}

fn takes_part(bundle: &Bundle, settings: &Settings, observation: &Observation) -> bool {
    let seen = || bundle.joined(observation).is_some_and(|(view, point)| view.sees(point).is_ok());
    settings.behind == Behind::Keep || seen()
}
