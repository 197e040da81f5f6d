//! Where is the car between two positions of its GNSS receiver? KITTI, 8 minutes and 3.7 km: inertial sensor at 100 Hz, positions at 1 Hz,
//! as GTSAM's example has them. Geiger et al. (2012).
//!
//! Nobody knows the truth but the receiver. Every second position is therefore kept from the filter, and the filter is judged there, a
//! second after the last one that it was told. The error of the receiver itself is part of what is seen.
//!
//! Filtered, and as a batch, which begins without knowing anything of attitude and velocity.
//!
//! Arguments: the folder of the public data, a picture to draw.

mod log;

use std::path::Path;

use boxplus::filter::{Ekf, ImuNoise, Inertial, InertialState, Part, PositionFix, STANDARD_GRAVITY};
use boxplus::io;
use boxplus::lie::{Rn, SE23, SO3};
use boxplus::recording::{Course, ImuReading, Score, Stamped, part_of};
use boxplus::trajectory::ImuBias;
use boxplus::uncertainty::{Covariance, Gaussian, Global};
use boxplus_cli::draw::{Ellipse, Run};
use log::inertial::Batch;
use log::{Outcome, Report, Row};
use nalgebra::{SVector, Vector3};

const IMU: &str = "inertial/kitti-imu-gps/KittiEquivBiasedImu.txt.gz";
const POSITIONS: &str = "inertial/kitti-imu-gps/KittiGps_converted.txt";
/// White noise ten times that of the log's metadata: a car on a road shakes. Biases as it says.
const NOISE: ImuNoise =
    ImuNoise { gyroscope: 1.75e-3, accelerometer: 0.1, gyroscope_bias: 2.91e-6, accelerometer_bias: 1.67e-4 };
/// Of the positions, in metres, as in GTSAM's example.
const FIX: f64 = 0.07;
/// At the start: position, rotation, velocity, biases of gyroscope and accelerometer.
const START: [f64; 5] = [0.07, 0.3, 2.0, 0.01, 0.1];

fn main() -> Outcome<()> {
    log::main(run)
}

/// The drive.
pub(crate) fn run(folder: &Path) -> Outcome<Report> {
    let imu = log::read_log(folder, IMU, io::read_kitti_imu)?;
    let positions = log::read_log(folder, POSITIONS, io::read_positions)?;
    // The inertial sensor begins with a gap of two seconds: from the second position on.
    let positions = &positions[1..];
    let [first, second, ..] = positions else { return Err("fewer than two positions".into()) };

    let noise = Covariance::from_sigmas(&Vector3::repeat(FIX))?;
    let fix = |p: &Vector3<f64>| Part {
        measurement: PositionFix::of_origin(*p, noise),
        of: |x: &InertialState| x.motion,
        block: InertialState::BLOCKS.motion,
    };
    let fixes: Vec<_> = positions.iter().skip(2).step_by(2).map(|p| p.map(fix)).collect();
    let held_back: Vec<Stamped<Rn<3>>> = held_back(folder)?.iter().map(|p| p.map(|p| Rn::new(*p))).collect();

    let start = Gaussian::from_sigmas(level(first, second), &SVector::from_fn(|i, _| START[i / 3]))?;
    let mut course = Course::<_, InertialState, 15, Global>::forward(Ekf::iterated(), first.stamp_ns, start);
    let model = Inertial::upright(NOISE);
    // Inputs from the first position on: what holds then is the reading before.
    let begin = imu.partition_point(|reading| reading.stamp_ns <= first.stamp_ns).saturating_sub(1);
    let mut imu = imu[begin..].to_vec();
    imu[0].stamp_ns = first.stamp_ns;
    // Positions that are held back are seen, too, so that there is a belief at their time; but not believed.
    let mut seen: Vec<_> = fixes.iter().map(|z| z.map(|z| Some(*z))).collect();
    seen.extend(held_back.iter().map(|z| z.map(|_| None)));
    seen.sort_by_key(|z| z.stamp_ns);
    course.follow(
        &imu,
        &seen,
        |reading: &ImuReading, duration| (model, reading.held(duration)),
        |course, fix| {
            fix.map(|fix| course.update(&fix));
        },
    )?;

    let poses = part_of(course.track(), |x| x.motion.pose(), 0);
    let places: Vec<Stamped<Ellipse>> = poses.iter().map(|belief| belief.map(log::in_space)).collect();
    let score = Score::new(&measured(&places, noise)?, &held_back, 0.0).after(20.0);
    let filter = Row::new("iterated, 0.5 Hz", &score, 3, course.fates());

    let estimate = batch(folder)?.solve()?;
    let places: Vec<Stamped<Ellipse>> =
        estimate.track.iter().map(|belief| belief.map(log::in_space)).collect();
    let score = Score::new(&measured(&places, noise)?, &held_back, 0.0).after(20.0);
    let row = estimate.row("batch, 0.5 Hz", &score, fixes.len());
    let truth = positions.iter().map(|p| p.value).collect();
    let picture = Run {
        title: "KITTI: inertial sensor, a position every other second, as a batch".to_owned(),
        facts: log::facts(&row),
        path: Some(log::path(false, places.iter().map(|place| place.value).collect(), truth, vec![])),
        charts: log::charts(&score, first.stamp_ns, [("east [m]", 1.0), ("north [m]", 1.0), ("up [m]", 1.0)]),
    };
    Ok(Report {
        title: "KITTI: inertial navigation on SE₂(3), judged at positions held back".to_owned(),
        rows: vec![filter, row],
        picture,
    })
}

/// The whole drive at once: a state a second, of which every other one has a position.
pub(crate) fn batch(folder: &Path) -> Outcome<Batch> {
    let imu = log::read_log(folder, IMU, io::read_kitti_imu)?;
    let positions = log::read_log(folder, POSITIONS, io::read_positions)?;
    let positions = &positions[1..];
    let times: Vec<i64> = positions.iter().map(|p| p.stamp_ns).collect();
    let fixes: Vec<_> = positions.iter().step_by(2).copied().collect();
    let mut batch = Batch::new(NOISE, ImuBias::zero(), &imu, &times, &fixes, FIX)?;
    (batch.bias_sigmas, batch.gravity) = ([START[3], START[4]], STANDARD_GRAVITY);
    Ok(batch)
}

/// The positions that were held back from it.
pub(crate) fn held_back(folder: &Path) -> Outcome<Vec<Stamped<Vector3<f64>>>> {
    let positions = log::read_log(folder, POSITIONS, io::read_positions)?;
    Ok(positions.into_iter().skip(2).step_by(2).collect())
}

/// Level, heading and moving from one position to the next.
fn level(from: &Stamped<Vector3<f64>>, to: &Stamped<Vector3<f64>>) -> InertialState {
    let step = to.value - from.value;
    let velocity = step / to.seconds_since(from.stamp_ns);
    InertialState {
        motion: SE23::new(SO3::about_z(step.y.atan2(step.x)), from.value, velocity),
        gyroscope_bias: Rn::new(Vector3::zeros()),
        accelerometer_bias: Rn::new(Vector3::zeros()),
    }
}

/// What the receiver will show of a place: its own noise comes on top.
fn measured(places: &[Stamped<Ellipse>], noise: Covariance<3>) -> Outcome<Vec<Stamped<Gaussian<Rn<3>, 3>>>> {
    let seen = |place: &Stamped<Ellipse>| {
        let covariance = Covariance::new(place.value.covariance)? + noise;
        Ok(place.map(|at| Gaussian::new(Rn::new(at.centre), covariance)))
    };
    places.iter().map(seen).collect()
}
