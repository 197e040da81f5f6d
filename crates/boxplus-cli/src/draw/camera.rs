//! From metres in space to metres on paper.

use nalgebra::{Matrix2, Matrix3, RowVector3, Vector3};

/// Isometric: the three axes are equally foreshortened.
const ELEVATION: f64 = 0.615_479_708_670_387_3; // atan(1/√2)
/// Where the eye stands when no horizontal direction stands out, counter-clockwise from the first axis.
const AZIMUTH: f64 = -55.0 * std::f64::consts::PI / 180.0;
/// A direction stands out when its variance is this many times that across it.
const ELONGATED: f64 = 1.5;
/// An axis with this part of the smaller other spread is taken for the vertical.
const FLAT: f64 = 0.2;

/// A parallel projection: the rows of an orthonormal frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    right: RowVector3<f64>,
    up: RowVector3<f64>,
    toward_eye: RowVector3<f64>,
}

/// A projected point: metres on the paper, and nearness to the eye (larger is nearer).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    pub u: f64,
    pub v: f64,
    pub near: f64,
}

impl Camera {
    /// The plan: x to the right, y up.
    pub fn plan() -> Self {
        let axis = |i| Matrix3::identity().row(i).into_owned();
        Self { right: axis(0), up: axis(1), toward_eye: axis(2) }
    }

    /// The isometric view, turned so that the longest horizontal direction lies across the paper.
    pub fn isometric(points: &[Vector3<f64>]) -> Self {
        let spread = covariance(points);
        let upright = upright(&spread);
        let azimuth = azimuth(&(upright * spread * upright.transpose()));
        let (sa, ca) = azimuth.sin_cos();
        let (se, ce) = ELEVATION.sin_cos();
        Self {
            right: RowVector3::new(-sa, ca, 0.0) * upright,
            up: RowVector3::new(-se * ca, -se * sa, ce) * upright,
            toward_eye: RowVector3::new(ce * ca, ce * sa, se) * upright,
        }
    }

    /// The point on the paper.
    pub fn project(&self, p: &Vector3<f64>) -> Spot {
        Spot { u: (self.right * p).x, v: (self.up * p).x, near: (self.toward_eye * p).x }
    }

    /// The covariance of a projected point.
    pub fn project_covariance(&self, covariance: &Matrix3<f64>) -> Matrix2<f64> {
        let at = |a: &RowVector3<f64>, b: &RowVector3<f64>| (a * covariance * b.transpose()).x;
        let across = at(&self.right, &self.up);
        Matrix2::new(at(&self.right, &self.right), across, across, at(&self.up, &self.up))
    }

    /// The world axes on the paper, as `(name, u, v)`, the farthest first.
    pub fn axes(&self) -> [(char, f64, f64); 3] {
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| self.toward_eye[a].total_cmp(&self.toward_eye[b]));
        order.map(|i| (['x', 'y', 'z'][i], self.right[i], self.up[i]))
    }
}

fn covariance(points: &[Vector3<f64>]) -> Matrix3<f64> {
    let n = points.len().max(1) as f64;
    let mean = points.iter().sum::<Vector3<f64>>() / n;
    points.iter().map(|p| (p - mean) * (p - mean).transpose()).sum::<Matrix3<f64>>() / n
}

/// The rotation that stands the vertical up as z: usually nothing; a camera trajectory (y down) is turned over.
fn upright(spread: &Matrix3<f64>) -> Matrix3<f64> {
    let sigma = spread.diagonal().map(f64::sqrt);
    if sigma.y < FLAT * sigma.x.min(sigma.z) {
        Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0)
    } else {
        Matrix3::identity()
    }
}

/// Looking across the first principal axis of the plan, a little from the side.
fn azimuth(spread: &Matrix3<f64>) -> f64 {
    let (xx, xy, yy) = (spread.m11, spread.m12, spread.m22);
    let (mean, radius) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
    if mean + radius < ELONGATED * (mean - radius) {
        return AZIMUTH;
    }
    let along = 0.5 * (2.0 * xy).atan2(xx - yy);
    along - 65.0_f64.to_radians()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_view_is_a_right_handed_rotation() {
        let camera_walk: Vec<_> =
            (0..50).map(|i| Vector3::new(f64::from(i % 7), 0.0, f64::from(i))).collect();
        let walk: Vec<_> = (0..50).map(|i| Vector3::new(f64::from(i), f64::from(i % 5), 1.0)).collect();
        for camera in [
            Camera::plan(),
            Camera::isometric(&[]),
            Camera::isometric(&walk),
            Camera::isometric(&camera_walk),
        ] {
            let m = Matrix3::from_rows(&[camera.right, camera.up, camera.toward_eye]);
            assert!((m * m.transpose() - Matrix3::identity()).norm() < 1e-14, "{m}");
            assert!((m.determinant() - 1.0).abs() < 1e-14, "{m}");
        }
    }

    #[test]
    fn the_vertical_points_up_and_the_long_side_lies_across() {
        let walk: Vec<_> = (0..50).map(|i| Vector3::new(f64::from(i), f64::from(i % 5), 1.0)).collect();
        let camera = Camera::isometric(&walk);
        assert!(camera.project(&Vector3::z()).v > 0.5);
        assert!(camera.project(&Vector3::x()).u.abs() > 0.8);
    }

    #[test]
    fn a_projected_covariance_is_that_of_projected_points() {
        let camera = Camera::isometric(&[]);
        let points: Vec<_> =
            (0..9).map(|i| Vector3::new(f64::from(i % 3), f64::from(i / 3), f64::from(i * i))).collect();
        let flat: Vec<_> =
            points.iter().map(|p| camera.project(p)).map(|s| Vector3::new(s.u, s.v, 0.0)).collect();
        let expected = covariance(&flat).fixed_view::<2, 2>(0, 0).into_owned();
        assert!((camera.project_covariance(&covariance(&points)) - expected).norm() < 1e-12);
    }
}
