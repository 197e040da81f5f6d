//! How well does an inertial sensor carry a drone from one position to the next? EuRoC V1_01: 145 s of flight, 200 Hz, Burri et al.
//! (2016), with the ground truth recomputed by OpenVINS.
//!
//! Positions of the truth, one a second, each off by 5 cm, correct what the sensor says in between. Orientation and velocity follow from
//! them alone. The error is the global one; on this log the local one does as well (`docs/logs.md`).
//!
//! Filtered, and as a batch, which begins without knowing anything of attitude, velocity and where down is.
//!
//! Arguments: the folder of the public data, a picture to draw.

mod log;

use std::path::Path;

use boxplus::filter::{Ekf, Gate, ImuNoise, Inertial, InertialState, Part, PositionFix, STANDARD_GRAVITY};
use boxplus::io;
use boxplus::lie::{Rn, SE3};
use boxplus::recording::{Course, ImuReading, Score, Stamped, part_of};
use boxplus::trajectory::ImuBias;
use boxplus::uncertainty::{Covariance, Gaussian, Global};
use boxplus_cli::draw::Run;
use log::inertial::Batch;
use log::{DEGREES, Outcome, Report, Row};
use nalgebra::{SVector, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

const IMU: &str = "inertial/euroc-V1_01_easy/imu0.csv.gz";
const TRUTH: &str = "inertial/euroc-V1_01_easy/groundtruth-recomputed.csv";
/// White noise ten times that of the data set's `imu0/sensor.yaml`, which is of a sensor at rest: this one vibrates. Biases as it says.
const NOISE: ImuNoise = ImuNoise {
    gyroscope: 1.6968e-3,
    accelerometer: 2.0e-2,
    gyroscope_bias: 1.9393e-5,
    accelerometer_bias: 3.0e-3,
};
/// Of the positions, in metres.
const FIX: f64 = 0.05;
/// Rows of the truth from one position to the next: a second.
const EVERY: usize = 20;
/// At the start: position, rotation, velocity, biases of gyroscope and accelerometer.
const START: [f64; 5] = [0.1, 0.1, 0.1, 0.005, 0.2];
/// Readings of the first second: the drone is at rest, and the gyroscope shows its bias.
const REST: usize = 200;

fn main() -> Outcome<()> {
    log::main(run)
}

/// The flight.
pub(crate) fn run(folder: &Path) -> Outcome<Report> {
    let imu = log::read_log(folder, IMU, io::read_euroc_imu)?;
    let states = log::read_log(folder, TRUTH, io::read_euroc_states)?;
    let truth = truth(folder)?;

    let noise = Covariance::from_sigmas(&Vector3::repeat(FIX))?;
    let fix = |place: &Vector3<f64>| Part {
        measurement: PositionFix::of_origin(*place, noise),
        of: |x: &InertialState| x.motion,
        block: InertialState::BLOCKS.motion,
    };
    let fixes: Vec<_> = positions(&truth)?.iter().skip(1).map(|place| place.map(fix)).collect();

    let first = states.first().ok_or("no truth")?;
    let there = InertialState {
        motion: first.value.motion,
        gyroscope_bias: Rn::new(at_rest(&imu)),
        accelerometer_bias: Rn::new(Vector3::zeros()),
    };
    let start =
        Gaussian::<InertialState, 15, Global>::from_sigmas(there, &SVector::from_fn(|i, _| START[i / 3]))?;
    let mut course = Course::forward(Ekf::iterated().gated(Gate::at(0.9999)), first.stamp_ns, start);
    let model = Inertial::upright(NOISE);
    course.follow(
        &imu,
        &fixes,
        |reading: &ImuReading, duration| (model, reading.held(duration)),
        |course, fix| {
            course.update(fix);
        },
    )?;

    let poses = part_of(course.track(), |x| x.motion.pose(), 0);
    let filter = Row::new("iterated, positions 1 Hz", &Score::new(&poses, &truth, 0.06), 3, course.fates());

    let estimate = batch(folder)?.tilted().solve()?;
    let (tilt, sigma) = estimate.tilt().ok_or("gravity was not estimated")?;
    let score = Score::new(&estimate.track, &truth, 0.06);
    let row = estimate.row("batch, nothing known", &score, fixes.len() + 1);
    let band = estimate.track.iter().step_by(5).map(|belief| log::in_space(&belief.value)).collect();
    let names = [
        ("x of the body [m]", 1.0),
        ("y [m]", 1.0),
        ("z [m]", 1.0),
        ("roll [°]", DEGREES),
        ("pitch [°]", DEGREES),
        ("yaw [°]", DEGREES),
    ];
    let places = truth.iter().map(|pose| pose.value.translation()).collect();
    let picture = Run {
        title: "EuRoC V1_01: inertial sensor, a position a second, as a batch; attitude and gravity unknown"
            .to_owned(),
        facts: log::facts(&row),
        path: Some(log::path(true, band, places, vec![])),
        charts: log::charts(&score, first.stamp_ns, names),
    };
    let title = format!(
        "EuRoC V1_01: inertial navigation on SE₂(3) with biases; down is {tilt:.2} ± {sigma:.2}° off −z"
    );
    Ok(Report { title, rows: vec![filter, row], picture })
}

/// The whole flight at once: ten states a second, of which one has a position.
pub(crate) fn batch(folder: &Path) -> Outcome<Batch> {
    let imu = log::read_log(folder, IMU, io::read_euroc_imu)?;
    let truth = truth(folder)?;
    let times: Vec<i64> = truth.iter().step_by(2).map(|pose| pose.stamp_ns).collect();
    let bias = ImuBias::new(at_rest(&imu), Vector3::zeros());
    let mut batch = Batch::new(NOISE, bias, &imu, &times, &positions(&truth)?, FIX)?;
    (batch.bias_sigmas, batch.gravity) = ([START[3], START[4]], STANDARD_GRAVITY);
    Ok(batch)
}

/// What was so.
pub(crate) fn truth(folder: &Path) -> Outcome<Vec<Stamped<SE3>>> {
    let states = log::read_log(folder, TRUTH, io::read_euroc_states)?;
    Ok(states.iter().map(|state| state.map(|x| x.motion.pose())).collect())
}

/// A position a second, with noise.
fn positions(truth: &[Stamped<SE3>]) -> Outcome<Vec<Stamped<Vector3<f64>>>> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let jitter = Gaussian::<Rn<3>, 3>::from_sigmas(Rn::new(Vector3::zeros()), &Vector3::repeat(FIX))?;
    let mut fix = |pose: &SE3| pose.translation() + jitter.sample(&mut rng).vector();
    // The filter starts from the first pose: its position was drawn last when there was no batch.
    let mut fixes: Vec<_> = truth.iter().step_by(EVERY).skip(1).map(|pose| pose.map(&mut fix)).collect();
    fixes.splice(0..0, truth.first().map(|pose| pose.map(&mut fix)));
    Ok(fixes)
}

/// What the gyroscope shows while the drone is at rest: its bias.
fn at_rest(imu: &[Stamped<ImuReading>]) -> Vector3<f64> {
    let still = &imu[..REST.min(imu.len())];
    still.iter().map(|m| m.value.gyroscope).sum::<Vector3<f64>>() / still.len() as f64
}
