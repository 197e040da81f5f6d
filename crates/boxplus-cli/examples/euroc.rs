//! How well does an inertial sensor carry a drone from one position to the next? EuRoC V1_01: 145 s of flight, 200 Hz, Burri et al.
//! (2016), with the ground truth recomputed by OpenVINS.
//!
//! Positions of the truth, one a second, each off by 5 cm, correct what the sensor says in between. Orientation and velocity follow from
//! them alone. The error is the global one; on this log the local one does as well (`docs/logs.md`).
//!
//! Arguments: the folder of the public data, a picture to draw.

mod log;

use std::path::Path;

use boxplus::filter::{Ekf, Gate, ImuNoise, Inertial, InertialState, Part, PositionFix};
use boxplus::io;
use boxplus::lie::{Rn, SE3};
use boxplus::recording::{Course, ImuReading, Score, Stamped, part_of};
use boxplus::uncertainty::{Gaussian, Global};
use boxplus_cli::draw::Run;
use log::{DEGREES, Outcome, Report, Row};
use nalgebra::{SVector, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

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
    let base = "inertial/euroc-V1_01_easy";
    let imu = log::read_log(folder, &format!("{base}/imu0.csv.gz"), io::read_euroc_imu)?;
    let states = log::read_log(folder, &format!("{base}/groundtruth-recomputed.csv"), io::read_euroc_states)?;
    let truth: Vec<Stamped<SE3>> = states.iter().map(|state| state.map(|x| x.motion.pose())).collect();

    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let jitter = Gaussian::<Rn<3>, 3>::from_sigmas(Rn::new(Vector3::zeros()), &Vector3::repeat(FIX))?;
    let mut fix = |pose: &SE3| Part {
        measurement: PositionFix::of_origin(
            pose.translation() + jitter.sample(&mut rng).vector(),
            *jitter.covariance(),
        ),
        of: |x: &InertialState| x.motion,
        block: InertialState::BLOCKS.motion,
    };
    let fixes: Vec<_> = truth.iter().step_by(EVERY).skip(1).map(|pose| pose.map(&mut fix)).collect();

    let first = states.first().ok_or("no truth")?;
    let still = &imu[..REST.min(imu.len())];
    let motion = first.value.motion;
    let there = InertialState {
        motion,
        gyroscope_bias: Rn::new(
            still.iter().map(|m| m.value.gyroscope).sum::<Vector3<f64>>() / still.len() as f64,
        ),
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
    let score = Score::new(&poses, &truth, 0.06);
    let row = Row::new("iterated, positions 1 Hz", &score, 3, course.fates());
    let band = poses.iter().step_by(20).map(|belief| log::in_space(&belief.value)).collect();
    let names = [
        ("x of the body [m]", 1.0),
        ("y [m]", 1.0),
        ("z [m]", 1.0),
        ("roll [°]", DEGREES),
        ("pitch [°]", DEGREES),
        ("yaw [°]", DEGREES),
    ];
    let picture = Run {
        title: "EuRoC V1_01: inertial sensor, a position a second".to_owned(),
        facts: log::facts(&row),
        path: Some(log::path(
            true,
            band,
            truth.iter().map(|pose| pose.value.translation()).collect(),
            vec![],
        )),
        charts: log::charts(&score, first.stamp_ns, names),
    };
    Ok(Report {
        title: "EuRoC V1_01: inertial navigation on SE₂(3) with biases".to_owned(),
        rows: vec![row],
        picture,
    })
}
