//! What a filter's track looks like.

use boxplus::lie::{SE2, SE3};
use boxplus::recording::{Score, seconds};
use boxplus::uncertainty::Gaussian;
use nalgebra::{Matrix3, Vector3};

use super::{Ellipse, ErrorChart, Panel, Scene};

/// The errors of some coordinates over time, each with its name and what its unit is multiplied by.
pub fn charts<const D: usize>(score: &Score<D>, start_ns: i64, names: [(&str, f64); D]) -> Vec<ErrorChart> {
    let chart = |(i, (name, factor)): (usize, &(&str, f64))| ErrorChart {
        heading: (*name).to_owned(),
        note: format!("{:.1} % inside 3σ", 100.0 * score.inside(i..i + 1, 3.0)),
        times: score.judged.iter().map(|j| seconds(start_ns, j.stamp_ns)).collect(),
        error: score.judged.iter().map(|j| j.error[i] * factor).collect(),
        band: score.judged.iter().map(|j| 3.0 * j.sigmas[i] * factor).collect(),
    };
    names.iter().enumerate().map(chart).collect()
}

/// Degrees in a radian, for charts.
pub const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// A path with its band beside the truth: positions, and their covariances in the axes of the world.
pub fn path(
    spatial: bool,
    band: Vec<Ellipse>,
    truth: Vec<Vector3<f64>>,
    landmarks: Vec<Vector3<f64>>,
) -> Panel {
    let tracks = vec![band.iter().map(|ellipse| ellipse.centre).collect()];
    let length: f64 = truth.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    Panel {
        heading: if spatial { "In space" } else { "From above" }.to_owned(),
        note: if truth.is_empty() { String::new() } else { format!("{length:.0} m") },
        scene: Scene { spatial, tracks, landmarks, truth, band, ..Scene::default() },
    }
}

/// A position in the plane with the covariance of the local error, told in the axes of the world.
pub fn in_plane(belief: &Gaussian<SE2, 3>) -> Ellipse {
    let turn = belief.mean().rotation().to_matrix();
    let turned = turn * belief.covariance().matrix().fixed_view::<2, 2>(0, 0) * turn.transpose();
    let mut covariance = Matrix3::zeros();
    covariance.fixed_view_mut::<2, 2>(0, 0).copy_from(&turned);
    Ellipse { centre: belief.mean().translation().push(0.0), covariance }
}

/// The same in space.
pub fn in_space(belief: &Gaussian<SE3, 6>) -> Ellipse {
    let turn = belief.mean().rotation().to_matrix();
    let covariance = turn * belief.covariance().matrix().fixed_view::<3, 3>(0, 0) * turn.transpose();
    Ellipse { centre: belief.mean().translation(), covariance }
}
