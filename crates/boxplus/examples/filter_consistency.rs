//! Which filter can be believed? Published benchmarks repeated.
//!
//! Brossard, Barrau & Bonnabel (2020) compare filters on poses as pairs of position and orientation, and on groups, from the left
//! and from the right. Ours are printed with their standard errors beside the numbers of their documentation, which are averages of 100
//! runs and scatter accordingly. The last row of a table is the filter we would take, but for mapping,
//! where the reset of the covariance hurts: `docs/consistency.md`. NEES is divided by its dimension: 1 is
//! consistent, more is overconfident. A thousand runs are in `docs/consistency.md`.
//!
//! A count of runs may be given (default 20; a tenth of it for mapping), a seed, and the names of tables.
#![expect(clippy::print_stdout, reason = "an example talks")]

mod published_benchmarks;

use boxplus::filter::{MonteCarlo, Report, Series};
use published_benchmarks::{attitude, inertial, localisation, slam};

/// Orientation RMSE in degrees, position RMSE in metres, NEES of both.
type Published = (&'static str, Option<[f64; 4]>);

const LOCALISATION: [Published; 6] = [
    ("UKF on the product", Some([11.98, 0.75, 4.40, 49.0])),
    ("left UKF", Some([11.35, 0.45, 0.94, 0.99])),
    ("right UKF", Some([11.35, 0.45, 0.94, 1.01])),
    ("EKF", Some([12.00, 0.76, 4.91, 275.3])),
    ("IEKF", Some([11.35, 0.45, 1.00, 2.02])),
    ("iterated IEKF", None),
];
const INERTIAL: [Published; 6] = [
    ("UKF on the product", Some([2.89, 0.29, 2.16, 3.27])),
    ("left UKF", Some([2.84, 0.24, 1.07, 1.11])),
    ("right UKF", Some([2.83, 0.24, 1.08, 1.16])),
    ("EKF", Some([3.20, 0.82, 11.35, 276.3])),
    ("IEKF", Some([2.83, 0.24, 1.14, 1.37])),
    ("iterated IEKF", None),
];
const SLAM: [Published; 7] = [
    ("UKF on the product", Some([3.01, 0.67, 2.93, 2.63])),
    ("left UKF", Some([3.30, 0.75, 10.38, 118.6])),
    ("right UKF", Some([2.51, 0.55, 1.01, 1.09])),
    ("EKF", Some([3.02, 0.67, 2.88, 2.56])),
    ("IEKF", Some([2.51, 0.55, 1.01, 1.17])),
    ("iterated left IEKF", None),
    ("iterated IEKF", None),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize, usual: u64| arguments.get(k).map_or(Ok(usual), |text| text.parse::<u64>());
    let (runs, seed) = (number(0, 20)?, number(1, 0)?);
    let wanted = |name: &str| arguments.len() < 3 || arguments[2..].iter().any(|other| other == name);
    let threads = std::thread::available_parallelism()?;
    let experiment = MonteCarlo { runs: usize::try_from(runs)?, seed, threads, ..MonteCarlo::default() };
    let failed = "a filter failed";
    if wanted("localisation") {
        println!("Localisation in the plane, heading unknown by 45° ({runs} runs; NEES from 20 s on)");
        table(&localisation(&experiment).ok_or(failed)?, &LOCALISATION, ", late");
    }
    if wanted("inertial") {
        println!("\nInertial navigation with three landmarks ({runs} runs)");
        table(&inertial(&experiment).ok_or(failed)?, &INERTIAL, "");
    }
    if wanted("slam") {
        let fewer = MonteCarlo { runs: experiment.runs.div_ceil(10), ..experiment };
        println!("\nMapping twenty landmarks in the plane ({} runs)", fewer.runs);
        table(&slam(&fewer).ok_or(failed)?, &SLAM, "");
    }
    if wanted("attitude") {
        println!("\nAttitude from gyroscope, accelerometer and magnetometer ({runs} runs; RMSE of one axis)");
        let report = attitude(&experiment).ok_or(failed)?;
        println!("{:20} RMSE (°)      published   NEES          published", "");
        for (name, rmse, nees) in [("left UKF", 1.06, 1.00), ("right UKF", 1.05, 0.99), ("EKF", 1.05, 0.99)] {
            let series = report.series(name).ok_or("recorded")?;
            let axis = 3_f64.sqrt();
            let ours =
                with_error(series.rmse.to_degrees() / axis, series.rmse_standard_error.to_degrees() / axis);
            let consistency = with_error(series.mean / 3.0, series.standard_error / 3.0);
            println!("{name:20} {ours:13} {rmse:9.2}   {consistency:13} {nees:9.2}");
        }
    }
    Ok(())
}

fn with_error(value: f64, error: f64) -> String {
    format!("{value:6.2} ±{error:5.2}")
}

fn table(report: &Report, rows: &[Published], suffix: &str) {
    println!(
        "{:20} orientation (°)         position (m)            NEES orientation        NEES position",
        ""
    );
    for (name, published) in rows {
        let series = |suffix: &str| report.series(&format!("{name}{suffix}"));
        let all = [series(""), series(", m"), series(suffix), series(&format!(", m{suffix}"))];
        let ours = |series: Option<&Series>, column: usize| match (series, column) {
            (Some(s), 0) => with_error(s.rmse.to_degrees(), s.rmse_standard_error.to_degrees()),
            (Some(s), 1) => with_error(s.rmse, s.rmse_standard_error),
            (Some(s), _) => with_error(s.mean / s.dimension as f64, s.standard_error / s.dimension as f64),
            (None, _) => String::new(),
        };
        let cell = |column: usize| {
            let theirs = published.map_or_else(|| format!("{:>7}", ""), |p| format!("{:7.2}", p[column]));
            format!(" {:13} {theirs} |", ours(all[column], column))
        };
        println!("{name:20}{}", (0..4).map(cell).collect::<String>());
    }
    println!("{:20} (each: ours, published)", "");
}
