//! What holds of particular groups: behaviour at the cut, constructors; in rooms of their own matrices and subgroups, drift,
//! units of length, and any bits.
#![allow(missing_docs, clippy::unwrap_used)]

mod any_bits;
mod drift;
mod scales;
mod subgroups;

use boxplus::lie::{Action, LieError, LieGroup, Real, Rn, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3};
use nalgebra::{Matrix2, Matrix3, Matrix4, SMatrix, SVector, Vector1, Vector3, Vector4, Vector6};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

const EPS: f64 = f64::EPSILON;

fn small_vector<const N: usize>(size: f64) -> impl Strategy<Value = SVector<f64, N>> {
    prop::array::uniform(-1.0..1.0_f64).prop_map(move |a: [f64; N]| SVector::from(a) * size)
}
proptest! {
    #[test]
    fn a_matrix_gives_its_rotation_back(phi in small_vector::<3>(4.0)) {
        // By docs/accuracy.md: matrix 4.5√3 ε in the Frobenius norm, √2 of which is an angle, rminus 5.5 ε; 2 ε between.
        let x = SO3::exp(&phi);
        let bound = (4.5 * 1.5_f64.sqrt() + 5.5 + 2.0) * EPS;
        prop_assert!(SO3::from_matrix(&x.to_matrix()).unwrap().rminus(&x).norm() < bound);
        prop_assert!(SO3::project(&x.to_matrix()).unwrap().rminus(&x).norm() < bound);
        let pose = SE3::new(x, phi * 10.0);
        prop_assert!(SE3::from_matrix(&pose.to_matrix()).unwrap().rminus(&pose).norm() < bound);
        let pose = SE2::new(phi.xy(), phi.z);
        prop_assert!(SE2::from_matrix(&pose.to_matrix()).unwrap().rminus(&pose).norm() < 8.0 * EPS);
    }
    #[test]
    fn both_quaternion_orders_and_any_norm_give_the_rotation(phi in small_vector::<3>(4.0), e in -300..300_i32) {
        let x = SO3::exp(&phi);
        let scale = 10.0_f64.powi(e);
        let [i, j, k, w] = x.quaternion_xyzw().map(|c| c * scale);
        // Scaling and normalising leave 1.5 ε in q, twice that in the angle; rminus 5.5 ε.
        prop_assert!(SO3::from_xyzw([i, j, k, w]).unwrap().rminus(&x).norm() < 8.5 * EPS);
        prop_assert_eq!(SO3::from_wxyz([w, i, j, k]).unwrap(), SO3::from_xyzw([i, j, k, w]).unwrap());
    }
    #[test]
    fn projection_is_the_polar_factor(m in prop::array::uniform9(-1.0..1.0_f64)) {
        let m = Matrix3::from_column_slice(&m);
        let svd = m.svd(true, true);
        let (u, vt) = (svd.u.unwrap(), svd.v_t.unwrap());
        let sign = (u * vt).determinant().signum();
        let least = svd.singular_values.imin();
        let mut middle = Matrix3::identity();
        middle[(least, least)] = sign;
        let others: f64 = (0..3).filter(|i| *i != least).map(|i| svd.singular_values[i]).fold(9.0, f64::min);
        let gap = others + sign * svd.singular_values[least];
        prop_assume!(gap > 0.05);
        // The oracle itself is exact to ε/gap.
        let difference = SO3::project(&m).unwrap().to_matrix() - u * middle * vt;
        prop_assert!(difference.amax() < 64.0 * EPS / gap, "{}", difference.amax() / EPS * gap);
    }
    #[test]
    fn constructors_and_logarithms_never_panic(bits in prop::array::uniform::<_, 9>(any::<u64>())) {
        let x = bits.map(f64::from_bits);
        let quaternion = SO3::from_xyzw([x[0], x[1], x[2], x[3]]);
        if let Ok(r) = quaternion {
            prop_assert!(r.log().norm() <= PI * (1.0 + EPS));
        }
        let _ = SO3::from_matrix(&Matrix3::from_column_slice(&x));
        let _ = SO3::project(&Matrix3::from_column_slice(&x));
        let _ = SO2::project(&Matrix2::from_column_slice(&x[..4]));
        let _ = SO2::from_cos_sin(x[4], x[5]);
        let _ = SE3::exp(&Vector6::from_column_slice(&x[..6])).log();
    }
}

#[test]
fn shepperd_divides_by_the_largest_component_on_every_branch() {
    for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
        for theta in [0.0, 1e-9, 1.0, 2.2, 3.0, PI - 1e-9, PI] {
            let x = SO3::exp(&(axis * theta));
            let back = SO3::from_matrix(&x.to_matrix()).unwrap();
            assert!(back.rminus(&x).norm() < 4.0 * EPS, "{axis} {theta}");
        }
    }
}

#[test]
fn what_is_no_rotation_is_refused_with_the_reason() {
    let nan = Matrix3::from_element(f64::NAN);
    assert_eq!(SO3::from_matrix(&nan), Err(LieError::NotFinite));
    assert_eq!(SO3::project(&nan), Err(LieError::NotFinite));
    assert_eq!(SO3::from_xyzw([0.0, f64::INFINITY, 0.0, 1.0]), Err(LieError::NotFinite));
    assert_eq!(SO3::from_xyzw([0.0; 4]), Err(LieError::Zero));
    assert_eq!(SO2::<f64>::from_cos_sin(0.0, 0.0), Err(LieError::Zero));
    assert_eq!(SO3::from_matrix(&-Matrix3::<f64>::identity()), Err(LieError::Reflection));
    assert_eq!(SO2::from_matrix(&Matrix2::new(1.0, 0.0, 0.0, -1.0)), Err(LieError::Reflection));
    let scaled = SO3::from_matrix(&(Matrix3::<f64>::identity() * 1.1)).unwrap_err();
    assert!(matches!(scaled, LieError::NotARotation { deviation } if (deviation - 0.21).abs() < 1e-12));
    assert!(matches!(SO3::project(&Matrix3::<f64>::zeros()), Err(LieError::Undetermined { .. })));
    assert!(matches!(SO3::project(&-Matrix3::<f64>::identity()), Err(LieError::Undetermined { .. })));
    let rank_one = Vector3::new(1.0, 2.0, 3.0) * Vector3::new(-1.0, 0.5, 2.0).transpose();
    assert!(matches!(SO3::project(&rank_one), Err(LieError::Undetermined { .. })));
    assert!(matches!(
        SO2::<f64>::project(&Matrix2::new(1.0, 0.0, 0.0, -1.0)),
        Err(LieError::Undetermined { .. })
    ));
    let mut transposed = SE3::exp(&Vector6::repeat(0.3)).to_matrix().transpose();
    assert_eq!(SE3::from_matrix(&transposed), Err(LieError::NotHomogeneous));
    transposed[(3, 0)] = f64::NAN;
    assert_eq!(SE3::from_matrix(&transposed), Err(LieError::NotFinite));
    let message = SO3::from_matrix(&(Matrix3::<f64>::identity() * 1.1)).unwrap_err().to_string();
    assert_eq!(message, "not a rotation: RᵀR differs from I by 2.1e-1; `project` gives the nearest rotation");
}

#[test]
fn at_pi_the_logarithm_keeps_the_stored_sign() {
    let n = Vector3::new(2.0, -3.0, 6.0) / 7.0;
    for sign in [1.0, -1.0] {
        let x = SO3::from_xyzw([sign * n.x, sign * n.y, sign * n.z, 0.0]).unwrap();
        assert!((x.log() - n * (sign * PI)).norm() < 2.0 * PI * EPS);
        let plane = SO2::from_cos_sin(-1.0, sign * 0.0).unwrap();
        assert!((plane.angle() - sign * PI).abs() < EPS);
    }
    // Beyond π the shorter way round is taken.
    let beyond = SO3::exp(&(n * (PI + 1e-9)));
    assert!((beyond.log() - n * (1e-9 - PI)).norm() < 4.0 * PI * EPS);
}

#[test]
fn q_and_minus_q_are_one_rotation() {
    let x = SO3::exp(&Vector3::new(0.3, -1.2, 0.8));
    let [i, j, k, w] = x.quaternion_xyzw();
    let minus = SO3::from_xyzw([-i, -j, -k, -w]).unwrap();
    assert_eq!(minus, x);
    assert_eq!(minus.log(), x.log());
    assert_eq!(minus.to_matrix(), x.to_matrix());
    assert_eq!(minus.compose(&x), x.compose(&x));
    assert_eq!(SE3::new(minus, Vector3::x()).log(), SE3::new(x, Vector3::x()).log());
}

#[test]
fn a_full_turn_is_the_identity() {
    let n = Vector3::new(2.0, -3.0, 6.0) / 7.0;
    for turns in [1.0, 2.0, -3.0, 1000.0] {
        // θ is rounded: its own error is turns·2π·ε.
        let bound = 2.0 * EPS * TAU * f64::abs(turns);
        assert!(SO3::exp(&(n * TAU * turns)).log().norm() < bound);
        assert!(
            SE3::exp(&Vector6::new(0.0, 0.0, 0.0, n.x, n.y, n.z).scale(TAU * turns)).log().norm() < bound
        );
        assert!(SO2::exp(&Vector1::new(TAU * turns)).angle().abs() < bound);
        // A closed circle leads back to its start: the translation perpendicular to the axis vanishes.
        let circle = SE2::exp(&Vector3::new(5.0, 0.0, TAU * turns));
        assert!(circle.translation().norm() < bound);
    }
}

#[test]
fn log_near_follows_a_rotation_through_many_turns() {
    let n = Vector3::new(2.0, -3.0, 6.0) / 7.0;
    let mut followed = Vector3::zeros();
    for step in 1..=400 {
        let truth = n * (0.1 * f64::from(step));
        followed = SO3::exp(&truth).log_near(&followed);
        assert!((followed - truth).norm() < 64.0 * EPS * truth.norm().max(1.0), "{followed} {truth}");
    }
    assert_eq!(SO3::<f64>::identity().log_near(&Vector3::zeros()), Vector3::zeros());
    let turn = SO3::<f64>::identity().log_near(&Vector3::new(0.0, 0.0, 6.0));
    assert!((turn - Vector3::new(0.0, 0.0, TAU)).norm() < 1e-14);
}

/// How far a stored quaternion is from unit norm, in units of ε.
fn quaternion_error<S: Real>(x: &SO3<S>) -> f64 {
    (x.quaternion_xyzw().iter().map(|c| c.value() * c.value()).sum::<f64>() - 1.0).abs() / S::EPSILON
}

#[test]
fn tiny_and_huge_scales_keep_their_digits() {
    let at = |sigma: f64| Sim3::new(SO3::identity(), Vector3::zeros(), sigma);
    assert_eq!(at(1e-14).compose(&at(1e-14)).log()[6], 2e-14);
    let far = at(300.0).compose(&at(300.0));
    assert_eq!(far.compose(&at(-600.0)), Sim3::identity());
}

#[test]
fn what_is_no_similarity_is_refused_with_the_reason() {
    let (turn, t) = (SO3::exp(&Vector3::new(0.1, -0.2, 0.3)), Vector3::new(1.0, 2.0, 3.0));
    for scale in [0.0, -2.0, f64::INFINITY] {
        assert_eq!(Sim3::from_scale(turn, t, scale), Err(LieError::NotAScale { scale }));
        assert_eq!(Sim2::from_scale(SO2::from_angle(0.1), t.xy(), scale), Err(LieError::NotAScale { scale }));
    }
    assert!(matches!(Sim3::from_scale(turn, t, f64::NAN), Err(LieError::NotAScale { .. })));
    assert_eq!(Sim3::<f64>::from_matrix(&Matrix4::zeros()), Err(LieError::NotAScale { scale: 0.0 }));
    let x = Sim3::from_scale(turn, t, 1e-200).unwrap();
    assert!(Sim3::from_matrix(&x.to_matrix()).unwrap().between(&x).rotation().log().norm() < 16.0 * EPS);
    let mirrored = x.to_matrix() * Matrix4::from_diagonal(&nalgebra::Vector4::new(-1.0, 1.0, 1.0, 1.0));
    assert_eq!(Sim3::from_matrix(&mirrored), Err(LieError::Reflection));
    let sheared = x.to_matrix() * Matrix4::from_diagonal(&nalgebra::Vector4::new(2.0, 1.0, 1.0, 1.0));
    assert!(matches!(Sim3::from_matrix(&sheared), Err(LieError::NotARotation { .. })));
    assert_eq!(
        SE23::<f64>::from_matrix(&SMatrix::<f64, 5, 5>::repeat(1.0).map(|_| f64::NAN)),
        Err(LieError::NotFinite)
    );
    let mut skewed = SE23::new(turn, t, t).to_matrix();
    skewed[(4, 3)] = 0.1;
    assert_eq!(SE23::from_matrix(&skewed), Err(LieError::NotHomogeneous));
    assert_eq!(SGal3::from_matrix(&skewed), Err(LieError::NotHomogeneous));
    skewed[(3, 4)] = f64::NAN;
    assert_eq!(SGal3::from_matrix(&skewed), Err(LieError::NotFinite));
}

#[test]
fn normalisation_is_idempotent_and_repairs_a_cast() {
    let x = SE3::exp(&Vector6::new(1.0, 2.0, 3.0, 0.4, -0.5, 0.6));
    let single = x.map(|c| c as f32).map(f64::from);
    assert!(quaternion_error(&single.rotation()) > 1e6);
    let repaired = single.normalize();
    assert!(quaternion_error(&repaired.rotation()) <= 2.0);
    assert!(repaired.normalize().rminus(&repaired).norm() <= 4.0 * EPS);
    assert!(repaired.rminus(&x).norm() < 1e-6);
}

#[test]
fn homogeneous_points_move_as_their_points_and_directions_do() {
    let x = SE3::exp(&Vector6::new(1.0, 2.0, 3.0, 0.4, -0.5, 0.6));
    let p = Vector3::new(0.3, -0.7, 1.9);
    assert!((x.act(&p.push(1.0)).xyz() - x.act(&p)).norm() < 8.0 * EPS);
    assert!((x.act(&p.push(0.0)).xyz() - Action::<6, 3>::act_direction(&x, &p)).norm() < 8.0 * EPS);
    assert_eq!(Action::<6, 4>::linear_part(&x), x.to_matrix());
    let x = Sim3::exp(&SVector::from([1.0, 2.0, 3.0, 0.4, -0.5, 0.6, 0.7]));
    assert!((x.act(&p.push(1.0)).xyz() - x.act(&p)).norm() < 8.0 * EPS * x.scale());
    let x = Sim2::exp(&SVector::from([1.0, 2.0, 0.4, 0.7]));
    assert!((x.act(&p.xy().push(0.0)).xy() - Action::<4, 2>::act_direction(&x, &p.xy())).norm() < 8.0 * EPS);
    boxplus::lie::laws::check_action::<SE3, 6, 4>().unwrap();
    boxplus::lie::laws::check_action::<SE2, 3, 3>().unwrap();
    boxplus::lie::laws::check_action::<Sim3, 7, 4>().unwrap();
    boxplus::lie::laws::check_action::<Sim2, 4, 3>().unwrap();
}

#[test]
fn the_operators_of_homogeneous_points_move_the_tangent_to_the_right() {
    let (p, flat) = (Vector4::new(0.3, -0.7, 1.9, 0.8), Vector3::new(0.3, -0.7, 0.8));
    let tau = SVector::<f64, 7>::from([1.0, 2.0, 3.0, 0.4, -0.5, 0.6, 0.7]);
    let (pose, similar) = (tau.fixed_rows::<6>(0).into_owned(), tau.fixed_rows::<4>(0).into_owned());
    assert!((SE3::hat(&pose) * p - SE3::odot(&p) * pose).norm() < 4.0 * EPS);
    assert!((p.transpose() * SE3::hat(&pose) - pose.transpose() * SE3::ocirc(&p)).norm() < 4.0 * EPS);
    assert!((Sim3::hat(&tau) * p - Sim3::odot(&p) * tau).norm() < 4.0 * EPS);
    assert!((p.transpose() * Sim3::hat(&tau) - tau.transpose() * Sim3::ocirc(&p)).norm() < 4.0 * EPS);
    let plane = pose.fixed_rows::<3>(0).into_owned();
    assert!((SE2::hat(&plane) * flat - SE2::odot(&flat) * plane).norm() < 4.0 * EPS);
    assert!((flat.transpose() * SE2::hat(&plane) - plane.transpose() * SE2::ocirc(&flat)).norm() < 4.0 * EPS);
    assert!((Sim2::hat(&similar) * flat - Sim2::odot(&flat) * similar).norm() < 4.0 * EPS);
    assert!(
        (flat.transpose() * Sim2::hat(&similar) - similar.transpose() * Sim2::ocirc(&flat)).norm()
            < 4.0 * EPS
    );
}

#[test]
fn far_from_the_origin_neighbours_keep_their_digits() {
    let base = SE3::new(SO3::exp(&Vector3::new(0.3, -1.2, 0.8)), Vector3::new(4e6, -3e6, 5e5));
    let step = Vector3::new(0.25, -0.125, 0.5);
    let near = SE3::new(base.rotation(), base.translation() + step);
    let back = base.rotation().inverse().act(&step);
    assert!((base.between(&near).translation() - back).norm() < 4.0 * EPS * step.norm());
    let inverse_first = base.inverse().compose(&near).translation();
    assert!((inverse_first - back).norm() > 1e-12, "the plain product loses seven digits here");
}

#[test]
fn operators_are_the_named_operations() {
    let (a, b) = (Vector6::new(1.0, 2.0, 3.0, 0.4, -0.5, 0.6), Vector6::new(0.1, 0.2, -0.3, 1.4, 0.5, -0.6));
    let (x, y, p) = (SE3::exp(&a), SE3::exp(&b), Vector3::new(0.3, -0.7, 1.9));
    assert_eq!(x * y, x.compose(&y));
    assert_eq!(x * p, x.act(&p));
    assert_eq!(x.rotation() * y.rotation(), x.rotation().compose(&y.rotation()));
    assert_eq!(x.rotation() * p, x.rotation().act(&p));
    let (x, y, p) = (SE2::new(a.xy(), a.w), SE2::new(b.xy(), b.w), p.xy());
    assert_eq!(x * y, x.compose(&y));
    assert_eq!(x * p, x.act(&p));
    assert_eq!(x.rotation() * p, x.rotation().act(&p));
    assert_eq!(Rn::new(p) * Rn::new(p), Rn::new(p * 2.0));
    let quarter = SO2::from_angle(FRAC_PI_2);
    assert_eq!((quarter * quarter).log(), quarter.compose(&quarter).log());
    let _: Matrix4<f64> = SE3::exp(&a).to_matrix();
    let (turn, p) = (SO3::exp(&a.fixed_rows::<3>(3).into_owned()), Vector3::new(0.3, -0.7, 1.9));
    let (x, y) = (SE23::new(turn, p, p * 2.0), Sim3::new(turn, p, 0.3));
    assert_eq!((x * x, x * p), (x.compose(&x), x.act(&p)));
    assert_eq!((y * y, y * p), (y.compose(&y), y.act(&p)));
    let (x, e) = (SGal3::from_extended(x, 0.5), p.push(0.25));
    assert_eq!((x * x, x * e), (x.compose(&x), x.act(&e)));
    let (x, p) = (Sim2::new(quarter, p.xy(), 0.3), p.xy());
    assert_eq!((x * x, x * p), (x.compose(&x), x.act(&p)));
}
