//! Where is my robot among known landmarks? UTIAS MRCLAM, data set 6: five robots drive for a quarter of an hour, count their wheels'
//! turns, and see landmarks at a distance and in a direction. Leung, Halpern, Barfoot & Liu (2011).
//!
//! The error of the camera's distances hardly changes while a robot stands and looks at the same landmark: sightings are far from
//! independent. A filter that takes each of them at its own accuracy soon believes itself to the millimetre, so that each is told
//! to be worth less: distances 0.4 m, directions 0.06 rad, several times what single ones are off.
//!
//! Arguments: the folder of the public data, a picture to draw.

mod log;

use std::collections::HashMap;
use std::path::Path;

use boxplus::filter::{Ekf, Gate, Odometry, RangeBearing};
use boxplus::io;
use boxplus::lie::SE2;
use boxplus::recording::{Course, Score, Stamped, Twist2};
use boxplus::uncertainty::{Covariance, Gaussian};
use boxplus_cli::draw::Run;
use log::{DEGREES, Outcome, Report, Row};
use nalgebra::{Vector2, vector};

/// Errors of the odometry that grow with √seconds: ahead in m, sideways in m, of the heading in rad.
const DRIFT: [f64; 3] = [0.03, 0.03, 0.06];
/// Of a sighting: distance in m, direction in rad.
const SIGHTING: [f64; 2] = [0.4, 0.06];
/// Where a robot is put down: within so many metres and radians of the truth.
const START: [f64; 3] = [0.5, 0.5, 0.5];

fn main() -> Outcome<()> {
    log::main(run)
}

/// Every robot; the last one is drawn.
pub(crate) fn run(folder: &Path) -> Outcome<Report> {
    let mut rows = Vec::new();
    let mut picture = None;
    for robot in 1..=5 {
        let (row, drawing) = localise(folder, robot)?;
        rows.push(row);
        picture = Some(drawing);
    }
    let title = "MRCLAM 6: five robots among fifteen landmarks, iterated EKF on SE(2)".to_owned();
    Ok(Report { title, rows, picture: picture.ok_or("no robot")? })
}

fn localise(folder: &Path, robot: usize) -> Outcome<(Row, Run)> {
    let file = |what: &str| format!("landmark-slam/mrclam6/Robot{robot}_{what}.dat.gz");
    let odometry = log::read_log(folder, &file("Odometry"), io::read_mrclam_odometry)?;
    let truth = log::read_log(folder, &file("Groundtruth"), io::read_mrclam_groundtruth)?;
    let (seen, landmarks) = sightings(folder, &file("Measurement"))?;

    let start_ns = odometry.first().ok_or("no odometry")?.stamp_ns;
    let there = truth.iter().find(|pose| pose.stamp_ns >= start_ns).ok_or("no truth")?.value;
    let start = Gaussian::<SE2, 3>::from_sigmas(there, &START.into())?;
    let drift = Covariance::from_sigmas(&DRIFT.into())?;
    let mut course = Course::forward(Ekf::iterated().gated(Gate::at(0.9999)), start_ns, start);
    course.follow(
        &odometry,
        &seen,
        |speed: &Twist2, duration| {
            let noise = drift * duration.sqrt();
            (Odometry { noise }, vector![speed.forward, 0.0, speed.turning] * duration)
        },
        |course, sighting| {
            course.update(sighting);
        },
    )?;

    let score = Score::new(course.track(), &truth, 0.1);
    let row = Row::new(&format!("robot {robot}"), &score, 2, course.fates());
    let band = course.track().iter().step_by(20).map(|belief| log::in_plane(&belief.value)).collect();
    let truth = truth.iter().step_by(20).map(|pose| pose.value.translation().push(0.0)).collect();
    let landmarks = landmarks.into_iter().map(|landmark| landmark.push(0.0)).collect();
    let picture = Run {
        title: format!("MRCLAM 6, robot {robot}"),
        facts: log::facts(&row),
        path: Some(log::path(false, band, truth, landmarks)),
        charts: log::charts(
            &score,
            start_ns,
            [("ahead [m]", 1.0), ("to the left [m]", 1.0), ("heading [°]", DEGREES)],
        ),
    };
    Ok((row, picture))
}

/// What was seen of landmarks, and where all of them are.
type Sightings = (Vec<Stamped<RangeBearing>>, Vec<Vector2<f64>>);

/// What the robot saw of landmarks, and where these are. Other robots and barcodes that nobody knows are left out.
fn sightings(folder: &Path, file: &str) -> Outcome<Sightings> {
    let base = "landmark-slam/mrclam6";
    let barcodes = log::read(folder, &format!("{base}/Barcodes.dat"), io::read_mrclam_barcodes)?;
    let landmarks =
        log::read(folder, &format!("{base}/Landmark_Groundtruth.dat"), io::read_mrclam_landmarks)?;
    let subject: HashMap<u32, u32> =
        barcodes.into_iter().map(|[subject, barcode]| (barcode, subject)).collect();
    let place: HashMap<u32, Vector2<f64>> = landmarks.iter().map(|l| (l.label, l.position)).collect();
    let noise = Covariance::from_sigmas(&SIGHTING.into())?;
    let mut seen = Vec::new();
    for sample in log::read_log(folder, file, io::read_mrclam_measurements)? {
        if let Some(&beacon) = subject.get(&sample.value.label).and_then(|subject| place.get(subject)) {
            seen.push(sample.map(|s| RangeBearing { beacon, measured: vector![s.range, s.bearing], noise }));
        }
    }
    Ok((seen, landmarks.into_iter().map(|l| l.position).collect()))
}
