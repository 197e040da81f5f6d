//! Published benchmarks, with fewer runs than the example that prints them.

#[path = "../../examples/published_benchmarks/mod.rs"]
mod published_benchmarks;

use boxplus::filter::{Report, Verdict};
use published_benchmarks::{attitude, inertial, localisation};
use std::num::NonZeroUsize;

const RUNS: usize = 20;

fn rmse(report: &Report, name: &str) -> f64 {
    report.series(name).unwrap().rmse
}

fn verdict(report: &Report, name: &str) -> Verdict {
    report.series(name).unwrap().verdict()
}

#[test]
fn filters_on_the_group_are_consistent_where_those_on_the_product_are_not() {
    let report = localisation(RUNS, NonZeroUsize::MIN).unwrap();
    for name in ["left UKF, m, late", "right UKF, m, late", "iterated IEKF, m, late", "iterated IEKF, late"] {
        assert_eq!(verdict(&report, name), Verdict::Consistent, "{name}");
    }
    for name in ["UKF on the product, m, late", "EKF, m, late", "EKF, late"] {
        assert_eq!(verdict(&report, name), Verdict::Overconfident, "{name}");
    }
    // Published 11.35° ± 1.1° and 0.45 m ± 0.065 m in groups of 100 runs; ours is a smaller group.
    let scale = (1.0 + 100.0 / RUNS as f64).sqrt();
    assert!((rmse(&report, "IEKF").to_degrees() - 11.35).abs() < 4.0 * 1.1 * scale);
    assert!((rmse(&report, "IEKF, m") - 0.45).abs() < 4.0 * 0.065 * scale);
    assert!(rmse(&report, "EKF, m") > 1.2 * rmse(&report, "IEKF, m"));
}

#[test]
fn inertial_filters_on_the_group_are_consistent_where_those_on_the_product_are_not() {
    let report = inertial(RUNS, NonZeroUsize::MIN).unwrap();
    for name in ["left UKF", "left UKF, m", "right UKF", "right UKF, m", "iterated IEKF", "iterated IEKF, m"]
    {
        assert_eq!(verdict(&report, name), Verdict::Consistent, "{name}");
    }
    for name in ["UKF on the product, m", "EKF, m", "EKF"] {
        assert_eq!(verdict(&report, name), Verdict::Overconfident, "{name}");
    }
    assert!(rmse(&report, "EKF, m") > 2.0 * rmse(&report, "IEKF, m"));
}

#[test]
fn attitude_filters_agree_and_are_consistent() {
    let report = attitude(8, NonZeroUsize::MIN).unwrap();
    for name in ["left UKF", "right UKF", "EKF"] {
        assert_eq!(verdict(&report, name), Verdict::Consistent, "{name}");
    }
    let [left, right] = ["left UKF", "right UKF"].map(|name| rmse(&report, name));
    assert!((left / right - 1.0).abs() < 0.05);
}
