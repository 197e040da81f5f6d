//! How sure a trajectory is, as a band along it.

use nalgebra::{Matrix2, Vector2};

use super::camera::Camera;
use super::page::pixels;
use super::scene::Ellipse;
use super::window::Window;

/// Half of the width, in standard deviations across the path.
const SIGMAS: f64 = 3.0;
/// More pieces than this nobody sees.
const PIECES: usize = 1500;

/// The outline of the band on the page: one piece from each position to the next and a joint at each bend, all turning the same way, so
/// that pieces that overlap add up to one area.
pub fn along(path: &[Ellipse], camera: &Camera, window: &Window) -> String {
    let every = path.len().div_ceil(PIECES).max(1);
    let shown = path.iter().step_by(every).chain(path.last().filter(|_| every > 1));
    let spots: Vec<Spot> = shown
        .map(|ellipse| {
            let spot = camera.project(&ellipse.centre);
            let (x, y) = window.place(spot.u, spot.v);
            // The page's y points down.
            let turned = Matrix2::new(window.scale, 0.0, 0.0, -window.scale);
            (Vector2::new(x, y), turned * camera.project_covariance(&ellipse.covariance) * turned)
        })
        .filter(|(at, covariance)| at.iter().chain(covariance.iter()).all(|x| x.is_finite() && x.abs() < 1e9))
        .collect();
    let pieces =
        spots.windows(2).filter_map(|pair| piece(&pair[0], &pair[1])).map(|corners| outline(&corners));
    let joints = spots.windows(3).filter_map(joint).map(|corners| outline(&corners));
    pieces.chain(joints).collect()
}

/// A position on the page, and its covariance.
type Spot = (Vector2<f64>, Matrix2<f64>);

fn outline(corners: &[Vector2<f64>]) -> String {
    let points = corners.iter().map(|p| format!("{} {}", pixels(p.x), pixels(p.y)));
    format!("M{}Z", points.collect::<Vec<_>>().join("L"))
}

/// The corners between two positions, clockwise on the page; `None` where they are one.
fn piece((from, before): &Spot, (to, after): &Spot) -> Option<[Vector2<f64>; 4]> {
    let across = across(from, to)?;
    let (start, end) = (half(across, before), half(across, after));
    Some([from - start, to - end, to + end, from + start])
}

/// What two pieces leave open on the outer side of a bend, clockwise on the page.
fn joint(three: &[Spot]) -> Option<[Vector2<f64>; 3]> {
    let [(from, _), (at, covariance), (to, _)] = three else { return None };
    let (before, after) = (across(from, at)?, across(at, to)?);
    let [p, q] = [before, after].map(|across| half(across, covariance));
    // Turning to the side that `across` shows, the other one is open.
    Some(if before.perp(&after) > 0.0 { [*at, at - p, at - q] } else { [*at, at + q, at + p] })
}

/// Clockwise on the page from the way between two positions.
fn across(from: &Vector2<f64>, to: &Vector2<f64>) -> Option<Vector2<f64>> {
    (to - from).try_normalize(1e-6).map(|ahead| Vector2::new(-ahead.y, ahead.x))
}

/// Half of the band in a direction.
fn half(across: Vector2<f64>, covariance: &Matrix2<f64>) -> Vector2<f64> {
    across * (SIGMAS * across.dot(&(covariance * across)).max(0.0).sqrt())
}
