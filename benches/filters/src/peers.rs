//! The peers, each with the nalgebra it speaks.

use adskalman::{
    KalmanFilterNoControl, ObservationModel, StateAndCovariance, TransitionModelLinearNoControl,
};
use kfilter::measurement::{LinearMeasurement, LinearisableMeasurement, Measurement};
use kfilter::system::StepReturn;
use kfilter::{Kalman, KalmanFilter, KalmanPredict, KalmanPredictInput, KalmanUpdate};
use nalgebra::{Matrix2, Matrix2x4, Matrix4, Matrix4x2, U2, U4, Vector4, vector};
use std::time::Duration;

struct Cart([Matrix4<f64>; 3]);

#[allow(non_snake_case)]
impl TransitionModelLinearNoControl<f64, U4> for Cart {
    fn F(&self) -> &Matrix4<f64> {
        &self.0[0]
    }
    fn FT(&self) -> &Matrix4<f64> {
        &self.0[1]
    }
    fn Q(&self) -> &Matrix4<f64> {
        &self.0[2]
    }
}

struct Seen(Matrix2x4<f64>, Matrix4x2<f64>, Matrix2<f64>);

#[allow(non_snake_case)]
impl ObservationModel<f64, U4, U2> for Seen {
    fn H(&self) -> &Matrix2x4<f64> {
        &self.0
    }
    fn HT(&self) -> &Matrix4x2<f64> {
        &self.1
    }
    fn R(&self) -> &Matrix2<f64> {
        &self.2
    }
}

pub fn cart_adskalman(steps: usize) -> f64 {
    let mut f = Matrix4::identity();
    (f[(0, 2)], f[(1, 3)]) = (0.1, 0.1);
    let cart = Cart([f, f.transpose(), Matrix4::identity() * 0.01]);
    let seen = Seen(Matrix2x4::identity(), Matrix4x2::identity(), Matrix2::identity() * 0.25);
    let filter = KalmanFilterNoControl::new(&cart, &seen);
    let mut belief = StateAndCovariance::new(Vector4::zeros(), Matrix4::identity());
    for _ in 0..steps {
        belief = filter.step(&belief, &vector![0.3, -0.2]).expect("regular");
    }
    belief.state().x
}

pub fn cart_kfilter(steps: usize) -> f64 {
    use nalgebra34::{Matrix2, Matrix2x4, Matrix4, Vector2, Vector4};
    let mut f = Matrix4::identity();
    (f[(0, 2)], f[(1, 3)]) = (0.1, 0.1);
    let mut filter =
        Kalman::<f64, 4, 0, _>::new(f, Matrix4::identity() * 0.01, Vector4::zeros(), Matrix4::identity());
    let seen =
        LinearMeasurement::new(Matrix2x4::identity(), Matrix2::identity() * 0.25, Vector2::new(0.3, -0.2));
    for _ in 0..steps {
        filter.predict().expect("finite");
        filter.update(&seen).expect("regular");
    }
    filter.state().x
}

/// Range and bearing of a beacon from (x, y, θ), linearised by hand.
struct RangeBearing {
    z: nalgebra34::Vector2<f64>,
    r: nalgebra34::Matrix2<f64>,
    h: nalgebra34::Matrix2x3<f64>,
    ht: nalgebra34::Matrix3x2<f64>,
}

impl RangeBearing {
    fn linearised(&mut self, x: &nalgebra34::Vector3<f64>) {
        let (dx, dy) = (9.0 - x.x, 1.0 - x.y);
        let q = dx * dx + dy * dy;
        let r = q.sqrt();
        self.h = nalgebra34::Matrix2x3::new(-dx / r, -dy / r, 0.0, dy / q, -dx / q, -1.0);
        self.ht = self.h.transpose();
    }
}

impl Measurement<f64, 3, 2> for RangeBearing {
    fn covariance(&self) -> &nalgebra34::Matrix2<f64> {
        &self.r
    }
    fn set_measurement(&mut self, z: nalgebra34::Vector2<f64>) {
        self.z = z;
    }
    fn predict(&self, x: &nalgebra34::Vector3<f64>) -> nalgebra34::Vector2<f64> {
        let (dx, dy) = (9.0 - x.x, 1.0 - x.y);
        nalgebra34::Vector2::new((dx * dx + dy * dy).sqrt(), dy.atan2(dx) - x.z)
    }
    fn measurement(&self) -> &nalgebra34::Vector2<f64> {
        &self.z
    }
}

impl LinearisableMeasurement<f64, 3, 2> for RangeBearing {
    fn observation(&self) -> &nalgebra34::Matrix2x3<f64> {
        &self.h
    }
    fn observation_transpose(&self) -> &nalgebra34::Matrix3x2<f64> {
        &self.ht
    }
}

fn driven(x: nalgebra34::Vector3<f64>, u: nalgebra34::Vector2<f64>) -> StepReturn<f64, 3> {
    let (sin, cos) = x.z.sin_cos();
    let turn = nalgebra34::Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
    let noise = nalgebra34::Matrix3::from_diagonal(&nalgebra34::Vector3::new(4e-4, 1e-4, 1e-4));
    StepReturn {
        state: nalgebra34::Vector3::new(x.x + u.x * cos, x.y + u.x * sin, x.z + u.y),
        jacobian: nalgebra34::Matrix3::new(1.0, 0.0, -u.x * sin, 0.0, 1.0, u.x * cos, 0.0, 0.0, 1.0),
        covariance: turn * noise * turn.transpose(),
    }
}

pub fn plane_kfilter(steps: usize) -> f64 {
    use nalgebra34::{Matrix2, Matrix2x3, Matrix3, Matrix3x2, Vector2, Vector3};
    let mut filter =
        Kalman::<f64, 3, 2, _>::new_ekf_with_input(driven, Vector3::zeros(), Matrix3::identity() * 0.01);
    let r = Matrix2::from_diagonal(&Vector2::new(0.01, 0.0025));
    let mut seen =
        RangeBearing { z: Vector2::new(9.0, 0.1), r, h: Matrix2x3::zeros(), ht: Matrix3x2::zeros() };
    for _ in 0..steps {
        KalmanPredictInput::predict(&mut filter, Vector2::new(0.001, 0.0001)).expect("finite");
        seen.linearised(filter.state());
        filter.update(&seen).expect("regular");
    }
    filter.state().z
}

pub fn inertial_eskf(steps: usize) -> f64 {
    use nalgebra25::{Point3, Vector3};
    let mut filter = eskf::Builder::new()
        .acceleration_variance(0.1)
        .rotation_variance(0.01)
        .acceleration_bias(1e-4)
        .rotation_bias(1e-5)
        .initial_covariance(0.0025)
        .build();
    for _ in 0..steps {
        filter.predict(Vector3::new(0.0, 0.1, 9.8), Vector3::new(0.1, 0.0, 0.2), Duration::from_millis(10));
        let variance = eskf::ESKF::variance_from_element(0.25);
        filter.observe_position(Point3::new(0.1, 0.0, 0.0), variance).expect("regular");
    }
    f64::from(filter.position.x)
}
