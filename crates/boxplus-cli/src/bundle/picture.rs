//! The picture of a bundle: cameras and points, before and after.

use boxplus::bundle_adjustment::{BalView, Bundle, Solved};
use boxplus::lie::Action;
use nalgebra::{Vector3, vector};

use crate::draw::{Figure, Panel, Scene};
use crate::input::{LoadedBundle, title};
use crate::text::{count, duration, grouped, significant};

/// Points and cameras drawn; more would hide each other.
const POINTS: usize = 4000;
const VIEWS: usize = 150;
/// One point in so many, at each end of each axis, is far off, and left out.
const STRAY: usize = 50;
/// Length of a drawn camera over the extent of what is drawn.
const CAMERA: f64 = 0.03;

/// Two panels: as it was given, and its optimum.
pub fn figure(loaded: &LoadedBundle, solved: &Solved) -> Figure {
    let frame = Frame::of(&solved.bundle);
    let panel = |heading: &str, rms: f64, bundle: &Bundle| Panel {
        heading: heading.to_owned(),
        note: format!("rms {} pixels", significant(rms, 4)),
        scene: frame.scene(bundle),
    };
    let bundle = &loaded.bundle;
    let sizes = format!(
        "{} views · {} points · {} observations",
        grouped(bundle.views.len()),
        grouped(bundle.points.len()),
        grouped(bundle.observations.len())
    );
    let change = format!("cost {} → {}", significant(solved.initial_cost, 4), significant(solved.cost, 6));
    let steps = count(solved.report.iterations.len(), "step", "steps");
    Figure {
        title: title(&loaded.name),
        facts: format!("{sizes} · {change} · {steps}, {}", duration(solved.report.seconds.total)),
        panels: vec![
            panel("Before", solved.initial_rms(), bundle),
            panel("After", solved.rms(), &solved.bundle),
        ],
    }
}

/// What is drawn: a box around most points and all cameras.
struct Frame {
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Frame {
    fn of(bundle: &Bundle) -> Self {
        let ends = [0, 1, 2].map(|axis| {
            let mut x: Vec<f64> = bundle.points.iter().map(|p| p[axis]).collect();
            x.sort_unstable_by(f64::total_cmp);
            let stray = x.len() / STRAY;
            let kept = &x[stray..x.len() - stray];
            let places = bundle.views.iter().map(|view| view.world_from_camera.translation()[axis]);
            let all = kept.iter().copied().chain(places);
            all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
        });
        Self { low: ends.map(|e| e.0).into(), high: ends.map(|e| e.1).into() }
    }

    fn scene(&self, bundle: &Bundle) -> Scene {
        let inside = |p: &&Vector3<f64>| (0..3).all(|i| (self.low[i]..=self.high[i]).contains(&p[i]));
        let every = bundle.points.len().div_ceil(POINTS).max(1);
        let size = CAMERA * (self.high - self.low).norm();
        let some = bundle.views.len().div_ceil(VIEWS).max(1);
        Scene {
            spatial: true,
            landmarks: bundle.points.iter().step_by(every).filter(inside).copied().collect(),
            views: bundle.views.iter().step_by(some).map(|view| frustum(view, size)).collect(),
            ..Scene::default()
        }
    }
}

/// The centre of a camera and the corners of its image, `size` ahead, which is along −z.
fn frustum(view: &BalView, size: f64) -> [Vector3<f64>; 5] {
    let corner = |x: f64, y: f64| view.world_from_camera.act(&(vector![0.6 * x, 0.45 * y, -1.0] * size));
    let centre = view.world_from_camera.translation();
    [centre, corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0)]
}
