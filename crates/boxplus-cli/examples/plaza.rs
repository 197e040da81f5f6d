//! Where is a lawn mower that only hears how far its beacons are? Plaza 1 of Djugash, Hamner & Roth (2009): half an hour, 1.9 km, odometry
//! and radio ranges to four beacons at known places.
//!
//! Ranges bounce off buildings: a gate leaves out what cannot be. They do not say where the mower looks; driving does.
//!
//! Arguments: the folder of the public data, a picture to draw.

mod log;

use std::path::Path;

use boxplus::filter::{Ekf, Gate, Odometry, Range};
use boxplus::io::{IoError, IoErrorKind, Layout, Stamp, Unit, decompress, read_log};
use boxplus::lie::SE2;
use boxplus::recording::{Course, Log, Score, Stamped, Twist2, seconds};
use boxplus::uncertainty::{Covariance, Gaussian};
use boxplus_cli::draw::Run;
use log::{DEGREES, Outcome, Report, Row};
use nalgebra::{Vector2, vector};

/// Errors of the odometry that grow with √seconds: ahead in m, sideways in m, of the heading in rad.
const DRIFT: [f64; 3] = [0.1, 0.05, 0.02];
/// Of a range, in metres.
const RANGE: f64 = 1.0;
/// At the start: metres and radians.
const START: [f64; 3] = [1.0, 1.0, 0.5];
/// How many there are.
const BEACONS: usize = 4;

fn main() -> Outcome<()> {
    log::main(run)
}

/// The lawn.
pub(crate) fn run(folder: &Path) -> Outcome<Report> {
    let graph = std::fs::read(folder.join("ranging/plaza1.pyfg.gz"))?;
    let graph = decompress(&graph, "plaza1.pyfg")?;
    let graph = String::from_utf8_lossy(&graph);
    let truth = lines(&graph, "VERTEX_SE2 ", 1);
    let truth = poses(truth.as_bytes(), "plaza1.pyfg")?.samples;
    let places = beacons(&graph)?;
    let speeds = speeds(&log::read_log(folder, "ranging/Plaza1_DR.txt", steps)?);
    let noise = Covariance::from_sigmas(&vector![RANGE])?;
    let range = |&(beacon, measured): &(usize, f64)| {
        Some(Range { beacon: *places.get(beacon)?, antenna: Vector2::zeros(), measured, noise })
    };
    // A graph owes nobody an order of time.
    let mut heard: Vec<_> =
        lines(&graph, "EDGE_RANGE ", 1).replace(" L", " ").lines().map(str::to_owned).collect();
    heard.sort_by(|a, b| time(a).total_cmp(&time(b)));
    let heard = ranges(heard.join("\n").as_bytes(), "plaza1.pyfg")?.samples;
    let heard: Vec<_> = heard
        .iter()
        .filter_map(|z| Some(Stamped { stamp_ns: z.stamp_ns, value: range(&z.value)? }))
        .collect();

    let start_ns = speeds.first().ok_or("no odometry")?.stamp_ns;
    let start = Gaussian::<SE2, 3>::from_sigmas(truth.first().ok_or("no truth")?.value, &START.into())?;
    let drift = Covariance::from_sigmas(&DRIFT.into())?;
    let mut course = Course::smoothing(Ekf::iterated().gated(Gate::at(0.999)), start_ns, start);
    course.follow(
        &speeds,
        &heard,
        |speed: &Twist2, duration| {
            let noise = drift * duration.sqrt();
            (Odometry { noise }, vector![speed.forward, 0.0, speed.turning] * duration)
        },
        |course, range| {
            course.update(range);
        },
    )?;

    let smoothed = course.smoothed();
    let scores = [Score::new(course.track(), &truth, 1.0), Score::new(&smoothed, &truth, 1.0)];
    let [filter, smoother] = [("iterated EKF", &scores[0]), ("smoother", &scores[1])]
        .map(|(name, s)| Row::new(name, s, 2, course.fates()));
    let band = course.track().iter().step_by(4).map(|belief| log::in_plane(&belief.value)).collect();
    let picture = Run {
        title: "Plaza 1: ranges to four beacons".to_owned(),
        facts: log::facts(&filter),
        path: Some(log::path(
            false,
            band,
            truth.iter().map(|pose| pose.value.translation().push(0.0)).collect(),
            places.iter().map(|place| place.push(0.0)).collect(),
        )),
        charts: log::charts(
            &scores[0],
            start_ns,
            [("ahead [m]", 1.0), ("to the left [m]", 1.0), ("heading [°]", DEGREES)],
        ),
    };
    Ok(Report {
        title: "Plaza 1: odometry and ranges on SE(2)".to_owned(),
        rows: vec![filter, smoother],
        picture,
    })
}

/// The lines that begin with a tag, without it and without the word number `without` behind it.
fn lines(text: &str, tag: &str, without: usize) -> String {
    let words = |line: &str| -> Vec<String> {
        let all = line.split_whitespace().enumerate();
        all.filter(|(i, _)| *i != without).map(|(_, word)| word.to_owned()).collect()
    };
    let tagged = text.lines().filter_map(|line| line.strip_prefix(tag));
    tagged.map(|line| words(line).join(" ") + "\n").collect()
}

/// The first number of a line.
fn time(line: &str) -> f64 {
    line.split(' ').next().and_then(|word| word.parse().ok()).unwrap_or(f64::NAN)
}

fn beacons(graph: &str) -> Outcome<Vec<Vector2<f64>>> {
    let places = lines(graph, "VERTEX_XY ", 0);
    let place = |line: &str| -> Outcome<Vector2<f64>> {
        let (x, y) = line.split_once(' ').ok_or("a beacon has x and y")?;
        Ok(Vector2::new(x.parse()?, y.parse()?))
    };
    places.lines().map(place).collect()
}

fn poses(bytes: &[u8], name: &str) -> Result<Log<SE2>, IoError> {
    let layout = Layout {
        format: "PyFG poses",
        stamp: Stamp::Seconds,
        fields: "time x y theta",
        named: false,
        units: [Unit::Any; 3],
    };
    read_log(bytes, name, &layout, |[x, y, theta]| Ok(SE2::new(Vector2::new(x, y), theta)))
}

/// Metres driven and radians turned since the row before.
fn steps(bytes: &[u8], name: &str) -> Result<Log<[f64; 2]>, IoError> {
    let layout = Layout {
        format: "Plaza odometry",
        stamp: Stamp::Seconds,
        fields: "time distance turn",
        named: false,
        units: [Unit::Any, Unit::Angle],
    };
    read_log(bytes, name, &layout, Ok)
}

/// The number of the beacon, and metres.
fn ranges(bytes: &[u8], name: &str) -> Result<Log<(usize, f64)>, IoError> {
    let layout = Layout {
        format: "PyFG ranges",
        stamp: Stamp::Seconds,
        fields: "time beacon range variance",
        named: false,
        units: [Unit::Any; 3],
    };
    read_log(bytes, name, &layout, |[beacon, range, _]| {
        let number = (0..BEACONS).find(|i| *i as f64 == beacon);
        Ok((number.ok_or_else(|| IoErrorKind::NotAnId { found: beacon.to_string().into() })?, range))
    })
}

/// Steps end at their stamps: speeds that hold from one stamp to the next.
fn speeds(steps: &[Stamped<[f64; 2]>]) -> Vec<Stamped<Twist2>> {
    let speed = |pair: &[Stamped<[f64; 2]>]| {
        let (from, to) = (pair[0].stamp_ns, pair[1].stamp_ns);
        let [forward, turning] = pair[1].value.map(|way| way / seconds(from, to));
        Stamped { stamp_ns: from, value: Twist2 { forward, turning } }
    };
    let stop = steps.last().map(|last| last.map(|_| Twist2 { forward: 0.0, turning: 0.0 }));
    steps.windows(2).map(speed).chain(stop).collect()
}
