//! Logs and a model, filtered.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use boxplus::filter::{Ekf, FilterError, Inertial, InertialState, Odometry, Part, PositionFix, RangeBearing};
use boxplus::io::{self, IoError};
use boxplus::lie::{Rn, SE2, SE3, SE23, SO3};
use boxplus::recording::{Course, ImuReading, Log, Stamped, Twist2, part_of};
use boxplus::uncertainty::{Gaussian, Global};
use nalgebra::{Vector2, Vector3, vector};

use super::config::{self, gate, sigmas};
use super::track::Filtered;
use crate::error::Error;
use crate::output::Console;

/// The files of a run.
pub struct Files<'a> {
    pub logs: &'a [PathBuf],
    pub truth: Option<&'a Path>,
    pub smooth: bool,
    pub console: Console,
}

fn read<T>(path: &Path, reader: fn(&[u8], &str) -> Result<T, IoError>) -> Result<T, Error> {
    let bytes = fs::read(path).map_err(|source| Error::Read { path: path.to_owned(), source })?;
    reader(&bytes, &path.display().to_string()).map_err(|error| Error::parsing(&error, &bytes))
}

impl Files<'_> {
    /// The samples of a log; what is odd about it is told.
    fn log<T>(
        &self,
        path: &Path,
        reader: fn(&[u8], &str) -> Result<Log<T>, IoError>,
    ) -> Result<Vec<Stamped<T>>, Error> {
        let log = read(path, reader)?;
        log.oddities.iter().for_each(|oddity| self.console.warn(&format!("{}: {oddity}", path.display())));
        Ok(log.samples)
    }

    /// The truth, or none.
    fn truth<T>(&self, reader: fn(&[u8], &str) -> Result<Log<T>, IoError>) -> Result<Vec<Stamped<T>>, Error> {
        self.truth.map_or(Ok(Vec::new()), |path| self.log(path, reader))
    }
}

/// Odometry, and beacons at known places: ODOMETRY MEASUREMENTS LANDMARKS BARCODES of MRCLAM.
pub fn beacons(files: &Files<'_>, config: &config::Beacons) -> Result<Filtered, Error> {
    let [odometry, measurements, landmarks, barcodes] =
        named(files, "ODOMETRY MEASUREMENTS LANDMARKS BARCODES")?;
    let speeds = files.log(odometry, io::read_mrclam_odometry)?;
    let landmarks = read(landmarks, io::read_mrclam_landmarks)?;
    let subject: HashMap<u32, u32> = read(barcodes, io::read_mrclam_barcodes)?
        .into_iter()
        .map(|[subject, code]| (code, subject))
        .collect();
    let place: HashMap<u32, Vector2<f64>> = landmarks.iter().map(|l| (l.label, l.position)).collect();
    let noise = sigmas("sighting", config.sighting)?;
    // Other robots, and codes that nobody knows, are no beacons.
    let beacon = |code: u32| subject.get(&code).and_then(|subject| place.get(subject)).copied();
    let seen: Vec<_> = files
        .log(measurements, io::read_mrclam_measurements)?
        .iter()
        .filter_map(|s| {
            let beacon = beacon(s.value.label)?;
            Some(s.map(|s| RangeBearing { beacon, measured: vector![s.range, s.bearing], noise }))
        })
        .collect();
    let truth = files.truth(io::read_mrclam_groundtruth)?;

    let start_ns = start_of("odometry", &speeds)?;
    let there = config.start.map(|[x, y, heading]| SE2::new(vector![x, y], heading));
    let there = there.or_else(|| truth.iter().find(|pose| pose.stamp_ns >= start_ns).map(|pose| pose.value));
    let there = there.ok_or_else(|| Error::Usage {
        message: "nobody says where the vehicle is at first".to_owned(),
        help: Some(
            "write start = [x, y, heading] in the --config, or name the ground truth by --truth".to_owned(),
        ),
    })?;
    let start = Gaussian::<SE2, 3>::new(there, sigmas("start_sigmas", config.start_sigmas)?);
    let drift = sigmas("drift", config.drift)?;
    let filter = Ekf::iterated().gated(gate(config.gate)?);
    let mut course = if files.smooth {
        Course::smoothing(filter, start_ns, start)
    } else {
        Course::forward(filter, start_ns, start)
    };
    let step = |speed: &Twist2, duration: f64| {
        (Odometry { noise: drift * duration.sqrt() }, vector![speed.forward, 0.0, speed.turning] * duration)
    };
    course
        .follow(&speeds, &seen, step, |course, z| {
            course.update(z);
        })
        .map_err(|error| broken(&error))?;
    let landmarks = landmarks.iter().map(|landmark| landmark.position.push(0.0)).collect();
    Ok(Filtered::new(&course.smoothed(), &truth, course.fates(), landmarks))
}

/// An inertial sensor, and positions: IMU POSITIONS.
pub fn gnss(files: &Files<'_>, config: &config::Gnss) -> Result<Filtered, Error> {
    let [imu, positions] = named(files, "IMU POSITIONS")?;
    let imu = files.log(imu, if is_csv(imu) { io::read_euroc_imu } else { io::read_kitti_imu })?;
    let positions = files.log(positions, io::read_positions)?;
    let truth = match files.truth {
        Some(path) if is_csv(path) => {
            files.truth(io::read_euroc_states)?.iter().map(|x| x.map(|x| x.motion.pose())).collect()
        }
        _ => files.truth(io::read_tum)?,
    };
    let noise = sigmas("position", config.position)?;
    let fix = |p: &Vector3<f64>| Part {
        measurement: PositionFix::of_origin(*p, noise),
        of: |x: &InertialState| x.motion,
        block: InertialState::BLOCKS.motion,
    };
    let fixes: Vec<_> = positions.iter().map(|p| p.map(fix)).collect();
    let imu = from_first(&imu, &positions)?;

    let there = InertialState {
        motion: level(&positions, config.heading_deg),
        gyroscope_bias: Rn::new(Vector3::zeros()),
        accelerometer_bias: Rn::new(Vector3::zeros()),
    };
    let spread = config.start_sigmas;
    let spread: [f64; 15] = std::array::from_fn(|i| spread[i / 3]);
    let start = Gaussian::<InertialState, 15, Global>::new(there, sigmas("start_sigmas", spread)?);
    let filter = Ekf::iterated().gated(gate(config.gate)?);
    let start_ns = start_of("inertial sensor", &imu)?;
    let mut course = if files.smooth {
        Course::smoothing(filter, start_ns, start)
    } else {
        Course::forward(filter, start_ns, start)
    };
    let model = Inertial::upright(config.noise()?);
    let step = |reading: &ImuReading, duration: f64| (model, reading.held(duration));
    course
        .follow(&imu, &fixes[1..], step, |course, z| {
            course.update(z);
        })
        .map_err(|error| broken(&error))?;
    let poses = part_of::<_, SE3, _, 15, 6>(&course.smoothed(), |x| x.motion.pose(), 0);
    Ok(Filtered::new(&poses, &truth, course.fates(), Vec::new()))
}

/// As many files as a model takes.
fn named<'a, const N: usize>(files: &Files<'a>, wanted: &str) -> Result<&'a [PathBuf; N], Error> {
    files.logs.try_into().map_err(|_| Error::Usage {
        message: format!("this model takes {N} files, and {} are named", files.logs.len()),
        help: Some(format!("name {wanted}, in this order")),
    })
}

/// Whether a name ends in `.csv`, packed or not.
fn is_csv(path: &Path) -> bool {
    let is = |path: &Path, ending: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending));
    is(path, "csv") || (is(path, "gz") && is(&path.with_extension(""), "csv"))
}

fn start_of<T>(what: &str, log: &[Stamped<T>]) -> Result<i64, Error> {
    match log {
        [first, _, ..] => Ok(first.stamp_ns),
        _ => Err(Error::Undetermined {
            message: format!("the log of the {what} has fewer than two samples in the time of the others"),
            help: Some("are the logs of one drive, and their times of one clock?".to_owned()),
        }),
    }
}

/// The readings from the first position on: what holds there is the reading before.
fn from_first(
    imu: &[Stamped<ImuReading>],
    positions: &[Stamped<Vector3<f64>>],
) -> Result<Vec<Stamped<ImuReading>>, Error> {
    let first = start_of("positions", positions)?;
    let begin = imu.partition_point(|reading| reading.stamp_ns <= first).saturating_sub(1);
    let mut imu = imu[begin.min(imu.len())..].to_vec();
    if let Some(held) = imu.first_mut() {
        held.stamp_ns = held.stamp_ns.max(first);
    }
    Ok(imu)
}

/// Level at the first position, on the way to the second.
fn level(positions: &[Stamped<Vector3<f64>>], heading_deg: Option<f64>) -> SE23 {
    let [from, to] = [0, 1].map(|i| positions[i]);
    let step = to.value - from.value;
    let heading = heading_deg.map_or(step.y.atan2(step.x), f64::to_radians);
    SE23::new(SO3::about_z(heading), from.value, step / to.seconds_since(from.stamp_ns))
}

fn broken(error: &FilterError) -> Error {
    Error::Undetermined { message: format!("the filter broke down: {error}"), help: None }
}
