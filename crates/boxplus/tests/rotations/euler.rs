//! Euler angles: against SciPy, against 50 digits, at gimbal lock.

use crate::EPS;
use crate::table::{Table, error, within};
use boxplus::lie::{EulerAngles, EulerSequence, GimbalLock, LieError, LieGroup, Real, SO3};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

const SCIPY: &str = include_str!("../reference/euler_scipy.csv");
const EXACT: &str = include_str!("../reference/coordinates.csv");

/// All 24, in the order of the tables: capital letters first, alphabetically.
pub(crate) fn sequences() -> impl Iterator<Item = EulerSequence> {
    let intrinsic = EulerSequence::INTRINSIC;
    intrinsic.into_iter().chain(intrinsic.map(EulerSequence::extrinsic))
}

/// Angles modulo whole turns, and their distance.
fn apart(a: f64, b: f64) -> f64 {
    let d = a - b;
    (d - TAU * (d / TAU).round()).abs()
}

#[test]
fn names_are_read_and_printed_as_in_scipy() {
    let names: Vec<_> = sequences().map(|s| s.to_string()).collect();
    assert_eq!(names.len(), 24);
    for (name, sequence) in names.iter().zip(sequences()) {
        assert_eq!(name.parse(), Ok(sequence));
        assert_eq!(sequence.is_extrinsic(), name.to_lowercase() == *name);
        assert_eq!(sequence.is_proper(), name.as_bytes()[0] == name.as_bytes()[2]);
    }
    for wrong in ["", "XX", "XXY", "XYy", "XYZX", "ABC", "Xyz", "ψ"] {
        assert_eq!(wrong.parse::<EulerSequence>(), Err(LieError::NotASequence));
    }
}

#[test]
fn all_24_sequences_agree_with_scipy_at_gimbal_lock_and_elsewhere() {
    for row in Table::parse(SCIPY).rows() {
        let sequence: EulerSequence = row.name().parse().unwrap();
        let q = SO3::from_xyzw(row.get("xyzw")).unwrap();
        let r = SO3::from_euler(sequence, row.get("angles"));
        assert!(r.rminus(&q).norm() < 8.0 * EPS, "{sequence}: {:?}", row.get::<3>("angles"));
        let (ours, theirs) = (q.to_euler(sequence), row.get::<3>("back"));
        // Rounding of a quaternion moves the first and the third angle by its size over the distance from the lock.
        let sensitivity = if ours.margin() < 1e-12 { 1.0 } else { 1.0 / ours.margin().sin() };
        for (i, (a, b)) in ours.angles.iter().zip(theirs).enumerate() {
            // SciPy's middle angle at the lock is good to 1e-8 only, by its arc cosine.
            let bound = if i == 1 { 16.0 } else { 16.0 * sensitivity } * EPS;
            assert!(apart(*a, b) < bound, "{sequence} {ours:?} {theirs:?}");
        }
    }
}

/// The largest error of the angles in ε, over the sensitivity 1/sin(margin) of the first and the third.
fn exact_error<S: Real>() -> f64 {
    let mut worst = 0.0_f64;
    for row in Table::parse(EXACT).rows() {
        let q = SO3::from_xyzw(row.get("xyzw").map(S::lit)).unwrap();
        let truth = row.get::<72>("euler");
        for (k, sequence) in sequences().enumerate() {
            let euler = q.to_euler(sequence);
            let slack = euler.margin().sin();
            for i in 0..3 {
                let error = apart(euler.angles[i].value(), truth[3 * k + i]) / S::EPSILON;
                let error = if i == 1 { error } else { error * slack };
                if !(slack < 16.0 * S::EPSILON && i != 1) {
                    worst = worst.max(error);
                }
            }
        }
    }
    worst
}

#[test]
fn every_angle_is_right_to_the_last_digit_its_rotation_determines() {
    // In ε rad; at 3 rad a unit in the last place is 2 ε, and two half-angles are rounded before they are added.
    within("Euler f64", exact_error::<f64>(), 6.0);
    within("Euler f32", exact_error::<f32>(), 6.0);
}

#[test]
fn angles_always_give_the_rotation_back() {
    let mut worst = [0.0_f64; 2];
    let margins = [0.0, 1e-18, 1e-16, 3e-16, 1e-15, 1e-14, 1e-12, 1e-8, 1e-7, 1e-4, 0.1, 0.7];
    for sequence in sequences() {
        for (k, margin) in margins.into_iter().enumerate() {
            for lock in [0.0, 1.0] {
                let middle = if sequence.is_proper() { lock * PI } else { lock * PI - FRAC_PI_2 };
                let middle = middle + (0.5 - lock) * 2.0 * margin;
                let angles = [0.3 + k as f64, middle, 1.7 - 0.4 * k as f64];
                let r = SO3::from_euler(sequence, angles);
                let back = r.to_euler(sequence);
                worst[0] = worst[0].max(back.rotation().rminus(&r).norm() / EPS);
                let single = r.map(|x| x as f32).normalize();
                let back = single.to_euler(sequence);
                let error = back.rotation().rminus(&single).norm();
                worst[1] = worst[1].max(f64::from(error) / f64::from(f32::EPSILON));
                let [first, second, third] = back.angles.map(f64::from);
                assert!(first.abs() <= PI + 1e-6 && third.abs() <= PI + 1e-6);
                let middle = if sequence.is_proper() { second - FRAC_PI_2 } else { second };
                assert!(middle.abs() <= FRAC_PI_2 + 1e-6);
            }
        }
    }
    // Snapping the third angle to 0 within 16 ε of the lock costs up to that much.
    within("round trip f64", worst[0], 20.0);
    within("round trip f32", worst[1], 20.0);
}

#[test]
fn gimbal_lock_is_reported_with_the_combination_that_is_determined() {
    for sequence in sequences() {
        for upper in [false, true] {
            let quarter = FRAC_PI_2 * if sequence.is_proper() { 0.0 } else { -1.0 };
            let middle = quarter + if upper { PI } else { 0.0 };
            let (first, third) = (0.7, -1.1);
            let r = SO3::from_euler(sequence, [first, middle, third]);
            let euler = r.to_euler(sequence);
            assert_eq!(euler.angles[2], 0.0, "{sequence}: the third angle is the free one");
            assert!(euler.margin() < 4.0 * EPS);
            // The other combination, by what leaves the rotation as it is.
            let same = |a: f64, c: f64| {
                SO3::from_euler(sequence, [first + a, middle, third + c]).rminus(&r).norm() < 1e-14
            };
            match euler.lock {
                Some(GimbalLock::Sum(sum)) => {
                    assert!(apart(sum, first + third) < 8.0 * EPS);
                    assert!(same(0.5, -0.5) && !same(0.5, 0.5), "{sequence}");
                }
                Some(GimbalLock::Difference(difference)) => {
                    assert!(apart(difference, first - third) < 8.0 * EPS);
                    assert!(same(0.5, 0.5) && !same(0.5, -0.5), "{sequence}");
                }
                None => panic!("{sequence} at {middle} is not reported"),
            }
            assert!(
                matches!(r.to_euler_jac(sequence), Err(LieError::GimbalLock { margin }) if margin < 4.0 * EPS)
            );
            let towards = if upper { -1.0 } else { 1.0 };
            let beside = |margin: f64| {
                SO3::from_euler(sequence, [first, middle + towards * margin, third]).to_euler(sequence)
            };
            assert!(beside(1e-9).lock.is_some() && beside(1e-7).lock.is_none());
            assert!((beside(1e-7).margin() - 1e-7).abs() < 4.0 * EPS);
        }
    }
}

#[test]
fn letters_in_reverse_order_about_fixed_axes_are_the_same_rotation() {
    let angles @ [a, b, c] = [0.3, -1.2, 2.2];
    for sequence in EulerSequence::INTRINSIC {
        let reversed: String = sequence.to_string().to_lowercase().chars().rev().collect();
        let fixed = SO3::from_euler(reversed.parse().unwrap(), [c, b, a]);
        assert_eq!(fixed, SO3::from_euler(sequence, angles));
    }
}

#[test]
fn yaw_turns_left_pitch_lowers_the_nose_and_roll_lowers_the_right_wing() {
    let (x, y) = (Vector3::x(), Vector3::y());
    let turned = |yaw, pitch, roll| SO3::<f64>::from_yaw_pitch_roll(yaw, pitch, roll);
    assert!((turned(0.1, 0.0, 0.0) * x).y > 0.0);
    assert!((turned(0.0, 0.1, 0.0) * x).z < 0.0);
    assert!((turned(0.0, 0.0, 0.1) * y).z > 0.0);
    let [yaw, pitch, roll] = turned(2.5, -0.4, -2.9).yaw_pitch_roll();
    assert!((Vector3::new(yaw, pitch, roll) - Vector3::new(2.5, -0.4, -2.9)).norm() < 4.0 * EPS);
}

#[test]
fn the_rates_and_their_inverse_undo_each_other_near_the_lock_too() {
    for sequence in sequences() {
        for margin in [1e-10, 1e-6, 1e-3, 0.2, 1.5] {
            let middle = if sequence.is_proper() { margin } else { FRAC_PI_2 - margin };
            let euler = EulerAngles { sequence, angles: [0.8, middle, -2.1], lock: None };
            let (e, inverse) = (euler.d_rotation_d_angles(), euler.d_angles_d_rotation().unwrap());
            let bound = 8.0 * EPS;
            assert!(error(&(e * inverse), &Matrix3::identity(), inverse.norm()) * EPS < bound);
            assert!((e.determinant().abs() - margin.sin()).abs() < bound);
        }
    }
}

#[cfg(feature = "autodiff")]
#[test]
fn jacobians_of_all_24_sequences_are_those_of_dual_numbers() {
    use crate::parametrisations::dual::{close, constant, derivatives, unknown};
    for sequence in sequences() {
        for middle in [-2.0, -1.0, 0.4, 1.3, 2.9] {
            let angles = [2.3, middle, -0.6];
            let (r, d_r) = SO3::from_euler_jac(sequence, angles);
            let dual = SO3::from_euler(sequence, (constant(&Vector3::from(angles)) + unknown()).into());
            close("from_euler", &derivatives(&dual.rminus(&r.map(Real::lit))), &d_r);
            let (euler, d_euler) = r.to_euler_jac(sequence).unwrap();
            let dual = r.map(Real::lit).rplus(&unknown()).to_euler(sequence);
            let angles = Vector3::from(dual.angles);
            close("to_euler", &derivatives(&angles), &d_euler);
            assert!((angles.map(Real::value) - Vector3::from(euler.angles)).amax() < 4.0 * EPS);
        }
    }
}
