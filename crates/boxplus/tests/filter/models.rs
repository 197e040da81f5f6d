//! Jacobians of the ready models against central differences, on both sides, where they are large.

use boxplus::camera::Stereo;
use boxplus::filter::{
    Attitude, DeadReckoning, DifferentialDrive, Gyroscope, Imu, ImuNoise, Inertial, InertialState,
    Measurement, Motion, Odometry, Part, PositionFix, Range, RangeBearing, Sighting, StereoSighting,
    VectorSighting, VelocityFix, WheelTravel, check_measurement, check_motion,
};
use boxplus::lie::{Action, LieGroup, Rn, SE2, SE3, SE23, SO3};
use boxplus::uncertainty::Covariance;
use nalgebra::{SVector, Vector3, vector};

/// Differences leave 2e-11 of values and derivatives up to some tens.
const AGREES: f64 = 2e-8;

fn tangent<const D: usize>(seed: f64) -> SVector<f64, D> {
    SVector::from_fn(|i, _| (seed + 1.7 * i as f64).sin())
}

fn cov<const D: usize>() -> Covariance<D> {
    Covariance::unit()
}

const NOISE: ImuNoise =
    ImuNoise { gyroscope: 0.1, accelerometer: 0.2, gyroscope_bias: 0.3, accelerometer_bias: 0.4 };

#[test]
fn motions_have_the_jacobians_they_state() {
    for seed in 0..20 {
        let s = f64::from(seed);
        let pose = SE3::exp(&tangent(s));
        assert!(check_motion(&Odometry { noise: cov() }, &pose, &tangent(s + 0.5)) < AGREES);
        let planar = SE2::exp(&tangent(s));
        assert!(check_motion(&Odometry { noise: cov() }, &planar, &tangent(s + 0.5)) < AGREES);
        let drive = DifferentialDrive { track: 0.4, rolling: 0.1, slip: 0.1 };
        assert!(check_motion(&drive, &planar, &WheelTravel { left: s.sin(), right: s.cos() }) < AGREES);
        let attitude = Attitude { rotation: pose.rotation(), gyroscope_bias: Rn::new(tangent(s)) };
        let gyroscope = Gyroscope { noise: 0.1, bias_walk: 0.1 };
        assert!(check_motion(&gyroscope, &attitude, &(tangent(s + 1.0), 0.7)) < AGREES);
        let imu = Imu { gyroscope: tangent(s + 2.0), accelerometer: tangent(s + 3.0) * 9.0, duration: 0.3 };
        let motion = SE23::exp(&tangent(s));
        assert!(check_motion(&DeadReckoning::upright(NOISE), &motion, &imu) < AGREES);
        let state = InertialState {
            motion,
            gyroscope_bias: Rn::new(tangent(s + 4.0)),
            accelerometer_bias: Rn::new(tangent(s + 5.0)),
        };
        assert!(check_motion(&Inertial::upright(NOISE), &state, &imu) < AGREES);
    }
}

#[test]
fn measurements_have_the_jacobians_they_state() {
    for seed in 0..20 {
        let s = f64::from(seed);
        let (pose, planar) = (SE3::exp(&tangent(s)), SE2::exp(&tangent(s)));
        let sighting = Sighting { landmark: tangent(s + 1.0), measured: tangent(s), noise: cov::<3>() };
        assert!(check_measurement(&sighting, &pose) < AGREES);
        assert!(check_measurement(&sighting, &SE23::exp(&tangent(s))) < AGREES);
        let velocity = VelocityFix { measured: tangent(s + 1.0), noise: cov() };
        assert!(check_measurement(&velocity, &SE23::exp(&(tangent(s) * 3.0))) < AGREES);
        let fix = PositionFix { antenna: tangent(s + 2.0), measured: tangent(s), noise: cov::<3>() };
        assert!(check_measurement(&fix, &pose) < AGREES);
        let north = VectorSighting { reference: tangent(s + 3.0), measured: tangent(s), noise: cov::<3>() };
        assert!(check_measurement(&north, &pose) < AGREES);
        assert!(check_measurement(&north, &pose.rotation()) < AGREES);
        let range =
            Range { beacon: vector![4.0, 1.0, 2.0], antenna: tangent(s), measured: 3.0, noise: cov() };
        assert!(check_measurement(&range, &pose) < AGREES);
        let seen = RangeBearing { beacon: vector![3.0, -2.0], measured: vector![3.0, s.sin()], noise: cov() };
        assert!(check_measurement(&seen, &planar) < AGREES);
        let camera_from_body = SE3::exp(&tangent(s + 2.0));
        let camera = Stereo { focal: [2.0, 1.5], centre: [0.3, 0.4], baseline: 0.2 };
        let ahead = vector![s.sin(), s.cos(), 4.0];
        let landmark = pose.act(&camera_from_body.act_inverse(&ahead));
        let stereo =
            StereoSighting { camera, camera_from_body, landmark, measured: tangent(s), noise: cov() };
        assert!(check_measurement(&stereo, &pose) < AGREES);
        let state = Attitude { rotation: SO3::exp(&tangent(s)), gyroscope_bias: Rn::new(tangent(s)) };
        let part =
            Part { measurement: north, of: |x: &Attitude| x.rotation, block: Attitude::BLOCKS.rotation };
        assert!(check_measurement(&part, &state) < AGREES);
    }
}

#[test]
fn a_checker_finds_a_wrong_sign() {
    struct Wrong(Odometry<3>);
    impl Motion<SE2, 3, 3> for Wrong {
        type Input = Vector3<f64>;
        fn step(&self, x: &SE2, u: &Vector3<f64>, w: &Vector3<f64>) -> SE2 {
            self.0.step(x, u, w)
        }
        fn noise(&self, u: &Vector3<f64>) -> Covariance<3> {
            Motion::<SE2, 3, 3>::noise(&self.0, u)
        }
        fn step_jac(
            &self,
            x: &SE2,
            u: &Vector3<f64>,
        ) -> (SE2, nalgebra::Matrix3<f64>, nalgebra::Matrix3<f64>) {
            let (next, f, g) = self.0.step_jac(x, u);
            (next, f, g.transpose())
        }
    }
    assert!(check_motion(&Wrong(Odometry { noise: cov() }), &SE2::identity(), &vector![1.0, 0.0, 0.3]) > 0.1);
}

#[test]
fn a_checker_finds_what_is_not_a_number() {
    /// A compass that forgets a derivative, in the first or the last column.
    struct Forgetful(usize);
    impl Measurement<SE2, 3, 1> for Forgetful {
        fn innovation(&self, x: &SE2) -> SVector<f64, 1> {
            vector![-x.angle()]
        }
        fn noise(&self) -> Covariance<1> {
            cov()
        }
        fn innovation_jac(&self, x: &SE2) -> (SVector<f64, 1>, nalgebra::RowVector3<f64>) {
            let mut h = nalgebra::RowVector3::new(0.0, 0.0, 1.0);
            h[self.0] = f64::NAN;
            (self.innovation(x), h)
        }
    }
    for column in 0..3 {
        assert!(check_measurement(&Forgetful(column), &SE2::new(vector![1.0, 2.0], 0.3)).is_nan());
    }
    let lost = vector![f64::NAN, 0.0, 0.0];
    assert!(check_motion(&Odometry { noise: cov() }, &SE2::identity(), &lost).is_nan());
}

#[test]
fn inertial_steps_compose() {
    // Two half steps with the same readings are one step: the increment is the exact solution.
    let model = DeadReckoning::upright(NOISE);
    let imu = Imu { gyroscope: tangent(2.0), accelerometer: tangent::<3>(3.0) * 9.0, duration: 0.4 };
    let half = Imu { duration: 0.2, ..imu };
    let (x, still) = (SE23::exp(&tangent(1.0)), SVector::zeros());
    let once = model.step(&x, &imu, &still);
    let twice = model.step(&model.step(&x, &half, &still), &half, &still);
    assert!(twice.rminus(&once).norm() < 1e-14);
}
