//! Filters on their way through recordings: no side of the error tells another story.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use boxplus::filter::{Ekf, Odometry, PositionFix};
use boxplus::lie::{LieGroup, SE2, SE3};
use boxplus::recording::{Course, Score, Stamped, part_of};
use boxplus::uncertainty::{Covariance, Gaussian, Side};
use nalgebra::vector;

#[test]
fn a_belief_is_the_same_from_either_side() {
    let mean = SE3::exp(&vector![40.0, -7.0, 2.0, 0.3, -0.8, 1.1]);
    let local = Gaussian::<SE3, 6>::from_sigmas(mean, &vector![0.1, 0.2, 0.3, 0.01, 0.02, 0.03]).unwrap();
    let at = |value| Stamped { stamp_ns: 0, value };
    let seen = part_of::<_, SE3, _, 6, 6>(&[at(local)], |x| *x, 0)[0].value;
    assert_eq!(seen.covariance().matrix(), local.covariance().matrix());
    let global = [Stamped { stamp_ns: 0, value: local.to_global() }];
    let seen = part_of::<_, SE3, _, 6, 6>(&global, |x| *x, 0)[0].value;
    assert!((seen.covariance().matrix() - local.covariance().matrix()).amax() < 1e-12);
}

const SECOND: i64 = 1_000_000_000;
const STEP: [f64; 3] = [1.0, 0.0, 0.2];

/// Twelve steps far from the origin, a position after every third.
fn driven<E: Side>(start: Gaussian<SE2, 3, E>) -> Course<Ekf, SE2, 3, E> {
    let odometry = Odometry { noise: Covariance::from_sigmas(&vector![0.1, 0.05, 0.03]).unwrap() };
    let noise = Covariance::from_sigmas(&vector![0.2, 0.1]).unwrap();
    let mut course = Course::smoothing(Ekf::default(), 0, start);
    for k in 1..=12 {
        course.predict(&odometry, &STEP.into(), k * SECOND).unwrap();
        if k % 3 == 0 {
            let off = vector![0.3, -0.2] * (k as f64).sin();
            let place = course.belief().mean().translation() + off;
            assert!(course.update(&PositionFix::of_origin(place, noise)));
        }
    }
    course
}

#[test]
fn a_course_and_its_score_are_the_same_from_either_side() {
    // Errors of odometry move by Ad, exactly, and one correction with reset is one of both sides: only rounding may differ.
    let start = SE2::new(vector![30.0, -20.0], 2.0);
    let believed = Gaussian::<SE2, 3>::from_sigmas(start, &vector![0.3, 0.2, 0.1]).unwrap();
    let truth: Vec<_> = (0..=12)
        .map(|k| Stamped { stamp_ns: k * SECOND, value: start.rplus(&(vector![1.0, 0.01, 0.21] * k as f64)) })
        .collect();
    let (local, global) = (driven(believed), driven(believed.to_global()));
    assert_eq!((local.fates().accepted, global.fates().accepted), (4, 4));
    assert!((local.fates().mean_nis() - global.fates().mean_nis()).abs() < 1e-11);
    let tracks = [(local.track().to_vec(), global.track().to_vec()), (local.smoothed(), global.smoothed())];
    for (local, global) in tracks {
        assert_eq!((local.len(), global.len()), (13, 13));
        for (l, g) in local.iter().zip(&global) {
            let same = g.value.to_local();
            assert!(l.stamp_ns == g.stamp_ns && l.value.mean().rminus(same.mean()).norm() < 1e-11);
            assert!((l.value.covariance().matrix() - same.covariance().matrix()).amax() < 1e-11);
        }
        let scores = [Score::new(&local, &truth, 0.0), Score::new(&global, &truth, 0.0)];
        assert_eq!(scores[0].judged.len(), 13);
        for (l, g) in scores[0].judged.iter().zip(&scores[1].judged) {
            assert!((l.error - g.error).norm() < 1e-11 && (l.sigmas - g.sigmas).norm() < 1e-10);
            // At the start both are 0: the truth is where it was put.
            let (l, g) = (l.nees.unwrap(), g.nees.unwrap());
            assert!((l - g).abs() < 1e-9 * (1.0 + g), "{l} {g}");
        }
    }
}
