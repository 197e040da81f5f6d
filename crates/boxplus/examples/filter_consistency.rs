//! Which filter can be believed? Published benchmarks repeated.
//!
//! Brossard, Barrau & Bonnabel (2020) compare filters on poses as pairs of position and orientation, and on groups, from the left
//! and from the right. Ours are printed beside the numbers of their documentation, which are averages of 100 runs and scatter
//! accordingly: four thousand runs have shown groups of hundred to differ by 1.5° and 0.2 m for the EKF of the first table, by 1.1°
//! and 0.065 m for its IEKF. The last row of a table is the filter we would take. NEES is divided by its dimension: 1 is
//! consistent, more is overconfident.
//!
//! A count of runs may be given (default 20).
#![expect(clippy::print_stdout, reason = "an example talks")]

mod published_benchmarks;

use boxplus::filter::{Report, Series};
use published_benchmarks::{attitude, inertial, localisation};

/// Orientation RMSE in degrees, position RMSE in metres, NEES of both.
type Published = (&'static str, Option<[f64; 4]>);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let runs = std::env::args().nth(1).map_or(Ok(20), |count| count.parse())?;
    let threads = std::thread::available_parallelism()?;
    let report = localisation(runs, threads).ok_or("a filter failed")?;
    println!("Localisation in the plane, heading unknown by 45° ({runs} runs; NEES from 20 s on)");
    let published = [
        ("UKF on the product", Some([11.98, 0.75, 4.40, 49.0])),
        ("left UKF", Some([11.35, 0.45, 0.94, 0.99])),
        ("right UKF", Some([11.35, 0.45, 0.94, 1.01])),
        ("EKF", Some([12.00, 0.76, 4.91, 275.3])),
        ("IEKF", Some([11.35, 0.45, 1.00, 2.02])),
        ("iterated IEKF", None),
    ];
    table(&report, &published, true);
    let report = inertial(runs, threads).ok_or("a filter failed")?;
    println!("\nInertial navigation with three landmarks ({runs} runs)");
    let published = [
        ("UKF on the product", Some([2.89, 0.29, 2.16, 3.27])),
        ("left UKF", Some([2.84, 0.24, 1.07, 1.11])),
        ("right UKF", Some([2.83, 0.24, 1.08, 1.16])),
        ("EKF", Some([3.20, 0.82, 11.35, 276.3])),
        ("IEKF", Some([2.83, 0.24, 1.14, 1.37])),
        ("iterated IEKF", None),
    ];
    table(&report, &published, false);
    let report = attitude(runs, threads).ok_or("a filter failed")?;
    println!("\nAttitude from gyroscope, accelerometer and magnetometer ({runs} runs; RMSE of one axis)");
    println!("{:20} RMSE (°) published   NEES published", "");
    for (name, rmse, nees) in [("left UKF", 1.06, 1.00), ("right UKF", 1.05, 0.99), ("EKF", 1.05, 0.99)] {
        let series = report.series(name).ok_or("recorded")?;
        let ours = (series.rmse / 3_f64.sqrt()).to_degrees();
        println!("{name:20} {ours:8.2} {rmse:9.2} {:6.2} {nees:9.2}", series.mean / 3.0);
    }
    Ok(())
}

fn table(report: &Report, rows: &[Published], late: bool) {
    println!("{:20} orientation (°)  position (m)     NEES orientation    NEES position", "");
    for (name, published) in rows {
        let series = |suffix: &str| report.series(&format!("{name}{suffix}"));
        let suffix = if late { ", late" } else { "" };
        let all = [series(""), series(", m"), series(suffix), series(&format!(", m{suffix}"))];
        let ours = |series: Option<&Series>, column: usize| match (series, column) {
            (Some(s), 0) => s.rmse.to_degrees(),
            (Some(s), 1) => s.rmse,
            (Some(s), _) => s.mean / s.dimension as f64,
            (None, _) => f64::NAN,
        };
        let cell = |column: usize| {
            let theirs = published.map_or_else(|| format!("{:>7}", ""), |p| format!("{:7.2}", p[column]));
            format!(" {:8.2} {theirs} |", ours(all[column], column))
        };
        println!("{name:20}{}", (0..4).map(cell).collect::<String>());
    }
    println!("{:20} (each: ours, published)", "");
}
