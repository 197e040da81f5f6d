//! How sure a trajectory is, as a band along it.

use std::fmt::Write as _;

use nalgebra::{Matrix2, Vector2};

use super::camera::Camera;
use super::page::pixels;
use super::scene::Ellipse;
use super::window::Window;

/// Half of the width, in standard deviations across the path.
const SIGMAS: f64 = 3.0;
/// More pieces than this nobody sees.
const PIECES: usize = 1500;

/// The outline of the band on the page: one piece from each position to the next, all turning the same way, so that pieces that
/// overlap add up to one area.
pub fn along(path: &[Ellipse], camera: &Camera, window: &Window) -> String {
    let every = path.len().div_ceil(PIECES).max(1);
    let shown = path.iter().step_by(every).chain(path.last().filter(|_| every > 1));
    let spots: Vec<(Vector2<f64>, Matrix2<f64>)> = shown
        .map(|ellipse| {
            let spot = camera.project(&ellipse.centre);
            let (x, y) = window.place(spot.u, spot.v);
            // The page's y points down.
            let turned = Matrix2::new(window.scale, 0.0, 0.0, -window.scale);
            (Vector2::new(x, y), turned * camera.project_covariance(&ellipse.covariance) * turned)
        })
        .filter(|(at, covariance)| at.iter().chain(covariance.iter()).all(|x| x.is_finite() && x.abs() < 1e9))
        .collect();
    let mut data = String::new();
    for pair in spots.windows(2) {
        if let Some(piece) = piece(&pair[0], &pair[1]) {
            let [a, b, c, d] = piece.map(|p| format!("{} {}", pixels(p.x), pixels(p.y)));
            // Writing into a String cannot fail.
            let _ = write!(data, "M{a}L{b}L{c}L{d}Z");
        }
    }
    data
}

/// The corners between two positions, clockwise on the page; `None` where they are one.
fn piece(
    (from, before): &(Vector2<f64>, Matrix2<f64>),
    (to, after): &(Vector2<f64>, Matrix2<f64>),
) -> Option<[Vector2<f64>; 4]> {
    let ahead = (to - from).try_normalize(1e-6)?;
    let across = Vector2::new(-ahead.y, ahead.x);
    let half =
        |covariance: &Matrix2<f64>| across * (SIGMAS * across.dot(&(covariance * across)).max(0.0).sqrt());
    Some([from - half(before), to - half(after), to + half(after), from + half(before)])
}
