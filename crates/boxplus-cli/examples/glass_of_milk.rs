//! How far along its rail is a robot? "Glass of milk", an assignment of the course AER1513 of T. Barfoot: in one dimension, a speed from the
//! wheels and the distance to a cylinder, ten times a second for 21 minutes. The simplest log there is: everything is linear, and filter and
//! smoother are exact.
//!
//! Distances are used each, every 10th and every 100th: what lies between, the smoother knows better.
//!
//! Arguments: the folder of the public data, a picture to draw.

mod log;

use std::path::Path;

use boxplus::filter::{Ekf, Odometry, PositionFix};
use boxplus::io::{IoError, Layout, Stamp, Unit, decompress, read_log};
use boxplus::lie::Rn;
use boxplus::recording::{Course, Fates, Log, Score, Stamped};
use boxplus::uncertainty::{Covariance, Gaussian};
use boxplus_cli::draw::Run;
use log::{Outcome, Report, Row};
use nalgebra::vector;

fn main() -> Outcome<()> {
    log::main(run)
}

/// Filter and smoother with ever fewer distances; the smoother with one in ten is drawn.
pub(crate) fn run(folder: &Path) -> Outcome<Report> {
    let file = "inertial/glass-of-milk-dataset1.csv.gz";
    let rows = log::read_log(folder, file, columns)?;
    let bytes = std::fs::read(folder.join(file))?;
    let text = decompress(&bytes, file)?;
    let text = String::from_utf8_lossy(&text);
    let constant =
        |key: &str| log::constants(&text, key).first().copied().ok_or(format!("{file} does not state {key}"));
    let (cylinder, speed_sigma) = (constant("l")?, constant("v_var")?.sqrt());
    let distance = Covariance::from_sigmas(&vector![constant("r_var")?.sqrt()])?;
    let truth: Vec<Stamped<Rn<1>>> = rows.iter().map(|row| row.map(|[.., x]| Rn::new(vector![*x]))).collect();

    let mut report =
        Report { title: "Glass of milk: position on a rail".to_owned(), rows: vec![], picture: nothing() };
    for every in [1, 10, 100] {
        let fix = |row: &Stamped<[f64; 3]>| {
            row.map(|[r, ..]| PositionFix::of_origin(vector![cylinder - r], distance))
        };
        let fixes: Vec<_> = rows.iter().step_by(every).map(fix).collect();
        let first = rows.first().ok_or("no row")?;
        let start =
            Gaussian::<Rn<1>, 1>::from_sigmas(Rn::new(vector![cylinder - first.value[0]]), &vector![1.0])?;
        let mut course = Course::smoothing(Ekf::default(), first.stamp_ns, start);
        course.follow(
            &rows,
            &fixes,
            |[_, speed, _], duration| {
                (Odometry { noise: Covariance::unit() * (speed_sigma * duration) }, vector![speed * duration])
            },
            |course, fix| {
                course.update(fix);
            },
        )?;
        let smoothed = course.smoothed();
        report.rows.push(judged(&format!("filter, 1 in {every}"), course.track(), &truth, course.fates()).0);
        let (row, score) = judged(&format!("smoother, 1 in {every}"), &smoothed, &truth, course.fates());
        if every == 10 {
            report.picture = Run {
                title: "Glass of milk: a rail, smoothed".to_owned(),
                facts: log::facts(&row),
                path: None,
                charts: log::charts(&score, first.stamp_ns, [("position [m]", 1.0)]),
            };
        }
        report.rows.push(row);
    }
    Ok(report)
}

fn judged(
    name: &str,
    track: &[Stamped<Gaussian<Rn<1>, 1>>],
    truth: &[Stamped<Rn<1>>],
    fates: Fates,
) -> (Row, Score<1>) {
    let score = Score::new(track, truth, 0.2);
    (Row::new(name, &score, 1, fates), score)
}

fn nothing() -> Run {
    Run { title: String::new(), facts: String::new(), path: None, charts: vec![] }
}

/// Distance in metres, speed in m/s, truth in metres.
fn columns(bytes: &[u8], name: &str) -> Result<Log<[f64; 3]>, IoError> {
    let layout = Layout {
        format: "glass-of-milk data",
        stamp: Stamp::Seconds,
        fields: "t r v x_true",
        named: true,
        units: [Unit::Any; 3],
    };
    read_log(bytes, name, &layout, Ok)
}
