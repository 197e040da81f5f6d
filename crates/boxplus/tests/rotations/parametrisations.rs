//! Quaternion conventions, Rodrigues vectors, 6-D, axes and directions: values, refusals, Jacobians.

use crate::EPS;
use crate::table::{Table, error, within};
use boxplus::lie::{LieError, LieGroup, Real, RxSO3, SE2, SE3, SO2, SO3, Sim2, Sim3};
use nalgebra::{
    Isometry2, Isometry3, Matrix3, Rotation2, Rotation3, Similarity2, Similarity3, UnitComplex,
    UnitQuaternion, Vector2, Vector3,
};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

const EXACT: &str = include_str!("../reference/coordinates.csv");

/// The largest errors in ε: angle, axis, Gibbs, modified Rodrigues, their shadow; relative to the norm of each, except that
/// tan(θ/2) is as sensitive as its argument where it is large.
fn exact_errors<S: Real>() -> [f64; 5] {
    let mut worst = [0.0_f64; 5];
    let mut record = |i: usize, error: f64| worst[i] = worst[i].max(error);
    for row in Table::parse(EXACT).rows() {
        let r = SO3::from_xyzw(row.get("xyzw").map(S::lit)).unwrap();
        let (axis, angle) = r.to_axis_angle();
        record(0, (angle.value() - row.get::<1>("angle")[0]).abs() / row.get::<1>("angle")[0] / S::EPSILON);
        record(1, error(&axis, &row.vector("axis"), 1.0));
        let gibbs: Vector3<f64> = row.vector("gibbs");
        let sensitivity = 0.5 + 0.5 * gibbs.norm_squared();
        record(2, error(&r.to_gibbs().unwrap(), &gibbs, gibbs.norm().max(sensitivity)));
        let mrp: Vector3<f64> = row.vector("mrp");
        record(3, error(&r.to_mrp(), &mrp, mrp.norm()));
        let shadow: Vector3<f64> = row.vector("shadow");
        record(4, error(&r.to_mrp_shadow().unwrap(), &shadow, shadow.norm()));
        // And back: both are the rotation.
        for back in [SO3::from_mrp(r.to_mrp()), SO3::from_mrp(r.to_mrp_shadow().unwrap())] {
            assert!(back.unwrap().rminus(&r).norm().value() < 8.0 * S::EPSILON);
        }
        let back = SO3::from_axis_angle(&axis, angle).unwrap();
        assert!(back.rminus(&r).norm().value() < 8.0 * S::EPSILON);
        let back = SO3::from_gibbs(r.to_gibbs().unwrap()).unwrap();
        assert!(back.rminus(&r).norm().value() < 8.0 * S::EPSILON);
    }
    worst
}

#[test]
fn coordinates_are_right_to_the_last_digits() {
    for (scalar, errors) in [("f64", exact_errors::<f64>()), ("f32", exact_errors::<f32>())] {
        for (name, error) in ["angle", "axis", "Gibbs", "MRP", "shadow MRP"].into_iter().zip(errors) {
            within(&format!("{name} {scalar}"), error, 4.0);
        }
    }
}

#[test]
fn quaternion_orders_and_conventions_are_what_they_are_called() {
    let r: SO3 = SO3::exp(&Vector3::new(0.3, -1.2, 0.8));
    let xyzw @ [x, y, z, w] = r.quaternion_xyzw();
    assert_eq!(r.quaternion_wxyz(), [w, x, y, z]);
    assert_eq!(SO3::from_wxyz(r.quaternion_wxyz()).unwrap(), r);
    assert_eq!(SO3::from_jpl_xyzw(r.quaternion_jpl_xyzw()).unwrap(), r);
    // Trawny & Roumeliotis (2005) (62): C(q) = (2w² − 1)I − 2w·v^ + 2vvᵀ.
    let [a, b, c, d] = r.quaternion_jpl_xyzw();
    let v = Vector3::new(a, b, c);
    let theirs =
        Matrix3::identity() * (2.0 * d * d - 1.0) - SO3::hat(&v) * (2.0 * d) + v * v.transpose() * 2.0;
    assert!((theirs - r.to_matrix()).amax() < 4.0 * EPS);
    // Read in the wrong convention, the rotation is inverted.
    assert_eq!(SO3::from_jpl_xyzw(xyzw).unwrap(), r.inverse());
}

#[test]
fn a_step_of_the_quaternion_turns_twice_as_far() {
    let (_, d_q) = SO3::<f64>::identity().quaternion_xyzw_jac();
    assert_eq!(d_q.fixed_rows::<3>(0).into_owned(), Matrix3::identity() * 0.5);
}

#[test]
fn types_of_nalgebra_come_and_go_without_a_change_of_rotation() {
    let p = Vector3::new(0.4, -1.3, 2.0);
    let q = UnitQuaternion::from_euler_angles(0.3, -0.4, 2.0);
    let r = SO3::from(q);
    assert!((r * p - q * p).norm() < 8.0 * EPS);
    assert!(UnitQuaternion::from(r).angle_to(&q) < 8.0 * EPS);
    let m = Rotation3::from_euler_angles(0.3, -0.4, 2.0);
    assert!((SO3::try_from(m).unwrap() * p - m * p).norm() < 8.0 * EPS);
    assert!((Rotation3::from(r) * p - m * p).norm() < 8.0 * EPS);
    let mirrored = Rotation3::from_matrix_unchecked(-Matrix3::<f64>::identity());
    assert_eq!(SO3::try_from(mirrored), Err(LieError::Reflection));
    let x = Isometry3::from_parts(Vector3::new(1.0, 2.0, 3.0).into(), q);
    assert!((SE3::from(x) * p - x.transform_point(&p.into()).coords).norm() < 8.0 * EPS);
    assert_eq!(SE3::from(Isometry3::from(SE3::from(x))), SE3::from(x));
    let s = Similarity3::from_isometry(x, 1.5);
    assert!((Sim3::try_from(s).unwrap() * p - s.transform_point(&p.into()).coords).norm() < 16.0 * EPS);
    assert!((Similarity3::from(Sim3::try_from(s).unwrap()).scaling() - 1.5).abs() < 2.0 * EPS);
    let negative = Similarity3::from_isometry(x, -1.5);
    assert_eq!(Sim3::try_from(negative), Err(LieError::NotAScale { scale: -1.5 }));

    let (p, z): (_, UnitComplex<f64>) = (p.xy(), UnitComplex::new(2.5));
    assert_eq!(SO2::from(z), SO2::from_angle(2.5));
    assert!((UnitComplex::from(SO2::from(z)).angle() - 2.5).abs() < 2.0 * EPS);
    assert!((SO2::try_from(Rotation2::new(2.5)).unwrap() * p - z * p).norm() < 4.0 * EPS);
    assert!((Rotation2::from(SO2::from(z)) * p - z * p).norm() < 4.0 * EPS);
    let x = Isometry2::new(Vector2::new(1.0, 2.0), 2.5);
    assert!((SE2::from(x) * p - x.transform_point(&p.into()).coords).norm() < 8.0 * EPS);
    assert!((Isometry2::from(SE2::from(x)).inverse() * x).rotation.angle().abs() < 4.0 * EPS);
    let s = Similarity2::from_isometry(x, 0.5);
    assert!((Sim2::try_from(s).unwrap() * p - s.transform_point(&p.into()).coords).norm() < 8.0 * EPS);
    assert!((Similarity2::from(Sim2::try_from(s).unwrap()).scaling() - 0.5).abs() < EPS);
}

#[test]
fn singular_coordinates_are_refused_by_name() {
    let half: SO3 = SO3::from_xyzw([0.6, 0.8, 0.0, 0.0]).unwrap();
    assert_eq!(half.to_gibbs(), Err(LieError::HalfTurn));
    assert_eq!(half.to_gibbs_jac(), Err(LieError::HalfTurn));
    assert_eq!(SO3::<f64>::identity().to_mrp_shadow(), Err(LieError::NoShadow));
    assert_eq!(SO3::from_gibbs(Vector3::new(f64::NAN, 0.0, 0.0)), Err(LieError::NotFinite));
    assert_eq!(SO3::from_mrp(Vector3::new(0.0, f64::INFINITY, 0.0)), Err(LieError::NotFinite));
    let (x, zero, nan) = (Vector3::x(), Vector3::zeros(), Vector3::new(0.0, f64::NAN, 0.0));
    assert_eq!(SO3::from_6d(&x, &zero), Err(LieError::Zero));
    assert_eq!(SO3::from_6d(&nan, &x), Err(LieError::NotFinite));
    assert!(matches!(SO3::from_6d(&x, &(x * -3.0)), Err(LieError::Parallel { sine }) if sine < EPS));
    assert_eq!(SO3::between_directions(&x, &zero), Err(LieError::Zero));
    assert_eq!(SO3::between_directions(&nan, &x), Err(LieError::NotFinite));
    assert_eq!(SO3::from_axis_angle(&zero, 1.0), Err(LieError::Zero));
    assert!(matches!(
        SO3::from_direction_pairs([&x, &x], [&x, &Vector3::y()]),
        Err(LieError::Parallel { .. })
    ));
    assert!(matches!(half.swing_twist(&Vector3::z()), Err(LieError::AxisReversed)));
    assert!(matches!(half.swing_twist(&zero), Err(LieError::Zero)));
    assert_eq!(SO3::<f64>::identity().to_axis_angle(), (Vector3::z(), 0.0));
}

#[test]
fn huge_rodrigues_vectors_are_half_and_whole_turns() {
    let n = Vector3::new(0.6, 0.0, -0.8);
    let half: SO3 = SO3::from_gibbs(n * 1e300).unwrap();
    assert!(half.rminus(&SO3::exp(&(n * PI))).norm() < 4.0 * EPS);
    assert!(SO3::from_mrp(n * 1e300).unwrap().log().norm() < 1e-299);
    let tiny = SO3::exp(&(n * 1e-200));
    assert!((tiny.to_mrp_shadow().unwrap() * 1e-201 / 0.4 + n).norm() < 1e-14, "−4/θ·n");
}

#[test]
fn modified_parameters_can_be_followed_through_half_a_turn() {
    let n = Vector3::new(2.0, -3.0, 6.0) / 7.0;
    let mut m = Vector3::zeros();
    for step in 1..300 {
        let theta = 0.02 * f64::from(step); // up to 6 rad
        m = SO3::exp(&(n * theta)).to_mrp_near(&m);
        assert!((m - n * (theta / 4.0).tan()).norm() < 16.0 * EPS * (1.0 + m.norm_squared()));
    }
}

/// What holds in `f64` holds in `f32`, with its ε.
#[test]
fn directions_in_f32_are_as_right_as_its_digits() {
    let e = f32::EPSILON;
    for k in 0..200 {
        let wave = |i: u8| (f32::from(i) * 0.7 + k as f32 * 1.3).sin();
        let (a, b) = (Vector3::new(wave(1), wave(2), wave(3)), Vector3::new(wave(5), wave(4), wave(9)));
        for to in [b, a + b * 1e-4, -a + b * 1e-4, -a, a] {
            let r = SO3::between_directions(&a, &to).unwrap();
            assert!((r * a.normalize() - to.normalize()).norm() < 8.0 * e);
        }
        let sine = a.normalize().cross(&b.normalize()).norm();
        let r = SO3::from_6d(&a, &b).unwrap();
        let [x, y] = r.to_6d();
        assert!((x - a.normalize()).norm() < 8.0 * e && y.dot(&b) > 0.0);
        let pair = SO3::from_direction_pairs([&(r * a), &(r * b)], [&a, &b]).unwrap();
        assert!(pair.rminus(&r).norm() < 32.0 * e / sine);
        let parts = r.swing_twist(&b).unwrap();
        assert!((parts.swing * parts.twist).rminus(&r).norm() < 8.0 * e);
        assert!(RxSO3::project(&(r.to_matrix() * 3.0)).unwrap().rotation().rminus(&r).norm() < 16.0 * e);
    }
}

#[test]
fn in_the_plane_any_direction_is_turned_to_any_other() {
    for (a, b) in [(0.3, 2.0), (1.0, 1.0 + PI), (-3.0, 3.0), (0.7, 0.7)] {
        let at = |angle: f64| Vector2::new(angle.cos(), angle.sin());
        let r = SO2::between_directions(&(at(a) * 1e200), &(at(b) * 1e-200)).unwrap();
        assert!((r * at(a) - at(b)).norm() < 4.0 * EPS);
    }
    assert_eq!(SO2::between_directions(&Vector2::zeros(), &Vector2::<f64>::x()), Err(LieError::Zero));
}

fn direction() -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-1.0..1.0_f64).prop_map(Vector3::from).prop_filter("not 0", |v| v.norm() > 0.1)
}

proptest! {
    #[test]
    fn the_shortest_rotation_takes_one_direction_to_the_other(a in direction(), b in direction(), e in -18..0_i32) {
        // Also nearly parallel and nearly opposite ones, at any length.
        let near = a + b * 10.0_f64.powi(e);
        for to in [b, near, -near, a, -a, a * 1e200, -a * 1e-200] {
            let r = SO3::between_directions(&a, &to).unwrap();
            let (from, to) = (a.normalize(), (to / to.amax()).normalize());
            prop_assert!((r * from - to).norm() < 8.0 * EPS, "{}", (r * from - to).norm() / EPS);
            // Shortest: by the angle between them, about an axis perpendicular to both.
            let angle = 2.0 * (from - to).norm().atan2((from + to).norm());
            prop_assert!((r.log().norm() - angle).abs() < 8.0 * EPS);
            prop_assert!(r.to_axis_angle().0.dot(&from).abs() * angle < 8.0 * EPS * PI / (PI - angle).max(EPS));
        }
        prop_assert_eq!(SO3::between_directions(&a, &a).unwrap(), SO3::identity());
    }
    #[test]
    fn swing_and_twist_make_up_the_rotation(phi in direction(), axis in direction(), size in 0.0..3.0_f64) {
        let r = SO3::exp(&(phi.normalize() * size));
        let parts = r.swing_twist(&axis).unwrap();
        prop_assert!((parts.swing * parts.twist).rminus(&r).norm() < 8.0 * EPS);
        let n = axis.normalize();
        prop_assert!((parts.twist.log() - n * parts.angle).norm() < 8.0 * EPS);
        prop_assert!(parts.swing.quaternion_xyzw()[..3].iter().zip(n.iter()).map(|(a, b)| a * b).sum::<f64>().abs() < 8.0 * EPS);
        // The swing is the shortest rotation to where the axis goes.
        let shortest = SO3::between_directions(&n, &(r * n)).unwrap();
        let reversal = (n + r * n).norm();
        prop_assert!(parts.swing.rminus(&shortest).norm() < 64.0 * EPS / reversal);
    }
    #[test]
    fn two_directions_fix_a_rotation(phi in direction(), a in direction(), b in direction(), tilt in -0.5..0.5_f64) {
        prop_assume!(a.cross(&b).norm() > 1e-3);
        let r = SO3::exp(&(phi * 3.0));
        let found = SO3::from_direction_pairs([&(r * a), &(r * b * 2.0)], [&a, &b]).unwrap();
        prop_assert!(found.rminus(&r).norm() < 32.0 * EPS / a.normalize().cross(&b.normalize()).norm());
        // The second direction may be wrong within the plane.
        let off = r * (b + a * tilt);
        let found = SO3::from_direction_pairs([&(r * a), &off], [&a, &b]).unwrap();
        prop_assert!(found.rminus(&r).norm() < 64.0 * EPS / a.normalize().cross(&b.normalize()).norm());
    }
    #[test]
    fn six_numbers_need_not_be_orthonormal(phi in direction(), s in 1e-3..1e3_f64, along in -5.0..5.0_f64) {
        let r = SO3::exp(&(phi * 3.0));
        let [a, b] = r.to_6d();
        prop_assert!(SO3::from_6d(&(a * s), &((b + a * along) / s)).unwrap().rminus(&r).norm() < 64.0 * EPS);
    }
    #[test]
    fn coordinates_never_panic(bits in prop::array::uniform::<_, 6>(any::<u64>())) {
        let x = bits.map(f64::from_bits);
        let (a, b) = (Vector3::new(x[0], x[1], x[2]), Vector3::new(x[3], x[4], x[5]));
        let rotations = [
            SO3::from_6d(&a, &b), SO3::from_gibbs(a), SO3::from_mrp(b), SO3::between_directions(&a, &b),
            SO3::from_axis_angle(&a, x[3]), SO3::from_direction_pairs([&a, &b], [&b, &a]),
        ];
        for r in rotations.into_iter().flatten() {
            for sequence in crate::euler::sequences() {
                let _ = r.to_euler_jac(sequence);
            }
            let _ = (r.to_gibbs(), r.to_mrp(), r.to_mrp_shadow(), r.swing_twist(&a), r.to_axis_angle());
        }
        let _ = SO3::from_xyzw_jac([x[0], x[1], x[2], x[3]]);
    }
}

#[test]
fn opposite_directions_turn_about_the_documented_axis() {
    let a = Vector3::new(0.1, -2.0, 0.3);
    let r = SO3::between_directions(&a, &-a).unwrap();
    let (axis, angle) = r.to_axis_angle();
    assert!((angle - PI).abs() < 2.0 * EPS);
    assert!((axis - a.cross(&Vector3::x()).normalize()).norm() < 4.0 * EPS);
    let x = SO3::between_directions(&Vector3::<f64>::x(), &-Vector3::x()).unwrap();
    assert!((x.to_axis_angle().0 - Vector3::x().cross(&Vector3::y())).norm() < EPS);
    assert!((SO3::about_x(FRAC_PI_2) * Vector3::y() - Vector3::z()).norm() < 2.0 * EPS);
    assert!((SO3::about_y(FRAC_PI_2) * Vector3::z() - Vector3::x()).norm() < 2.0 * EPS);
    assert!((SO3::about_z(FRAC_PI_2) * Vector3::x() - Vector3::y()).norm() < 2.0 * EPS);
}

#[test]
fn what_is_determined_up_to_rounding_only_is_refused_or_repaired() {
    // A half turn about a generic axis: infinite in every component.
    let half = SO3::from_xyzw([0.6, 0.48, 0.64, 0.0]).unwrap();
    assert!(matches!(half.to_gibbs(), Err(LieError::HalfTurn)));
    // A twist of which 10⁻¹⁷ is left.
    let reversed = SO3::from_xyzw([1.0, 0.0, 0.0, 1e-17]).unwrap();
    assert!(matches!(reversed.swing_twist(&Vector3::z()), Err(LieError::AxisReversed)));
    // Parallel but for the rounding of 0.1, 0.2, 0.3 times 3.
    let a = Vector3::new(0.1, 0.2, 0.3);
    assert!(matches!(SO3::from_6d(&a, &(a * 3.0)), Err(LieError::Parallel { .. })));
    // Nearly parallel: the first direction is met to the last digits all the same.
    for angle in [1e-3, 1e-6, 1e-9, 1e-12] {
        let r = SO3::from_6d(&a, &(a * 2.0 + a.cross(&Vector3::x()) * angle)).unwrap();
        assert!((r * Vector3::x() - a.normalize()).norm() < 8.0 * EPS, "{angle}");
    }
    // Quaternions and complex numbers that nalgebra calls unit without looking.
    let long = UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(0.9, 0.1, -0.5, 0.3));
    let norm: f64 = SO3::from(long).quaternion_xyzw().iter().map(|x| x * x).sum();
    assert!((norm - 1.0).abs() < 2.0 * EPS);
    let long = SO2::<f64>::from(UnitComplex::new_unchecked(nalgebra::Complex::new(0.9, 0.6)));
    assert!((long.cos().hypot(long.sin()) - 1.0).abs() < 2.0 * EPS);
}

/// Dual numbers through every conversion are its closed-form Jacobian.
#[cfg(feature = "autodiff")]
pub(crate) mod dual {
    use super::*;
    use nalgebra::{Const, SMatrix, SVector, Vector4};
    use num_dual::DualSVec64;

    pub(crate) type Dual<const N: usize> = DualSVec64<N>;

    pub(crate) fn constant<const N: usize, const M: usize>(x: &SVector<f64, M>) -> SVector<Dual<N>, M> {
        x.map(Dual::from_re)
    }
    /// 0 with unit derivatives.
    pub(crate) fn unknown<const N: usize>() -> SVector<Dual<N>, N> {
        SVector::from_fn(|i, _| Dual::from_re(0.0).derivative(i))
    }
    pub(crate) fn derivatives<const N: usize, const M: usize>(y: &SVector<Dual<N>, M>) -> SMatrix<f64, M, N> {
        let rows = y.map(|d| d.eps.unwrap_generic(Const::<N>, Const::<1>));
        SMatrix::from_fn(|i, j| rows[i][j])
    }
    pub(crate) fn close<const M: usize, const N: usize>(
        name: &str,
        dual: &SMatrix<f64, M, N>,
        closed: &SMatrix<f64, M, N>,
    ) {
        let difference = (dual - closed).amax();
        assert!(difference <= 64.0 * EPS * (1.0 + closed.amax()), "{name}: {difference:.1e}\n{dual}{closed}");
    }

    #[test]
    fn jacobians_of_the_coordinates_are_those_of_dual_numbers() {
        for (k, theta) in [0.0, 1e-9, 1e-3, 0.4, 1.5, 3.0, PI - 1e-4].into_iter().enumerate() {
            let direction = Vector3::new(0.3 - k as f64 * 0.2, 0.5, -0.4 + k as f64 * 0.1).normalize();
            let r: SO3 = SO3::exp(&(direction * theta));
            let rc: SO3<Dual<3>> = r.map(Dual::from_re);
            let moved = rc.rplus(&unknown());

            let (q, d_q) = r.quaternion_xyzw_jac();
            close("quaternion", &derivatives(&Vector4::from(moved.quaternion_xyzw())), &d_q);
            let q = Vector4::from(q) * 1.7;
            let (_, d_r) = SO3::from_xyzw_jac(q.into()).unwrap();
            let dual = SO3::from_xyzw((constant(&q) + unknown()).into()).unwrap();
            close("from quaternion", &derivatives(&dual.rminus(&r.map(Dual::from_re))), &d_r);

            if theta < 3.1 {
                let (g, d_g) = r.to_gibbs_jac().unwrap();
                close("Gibbs", &derivatives(&moved.to_gibbs().unwrap()), &d_g);
                let dual = SO3::from_gibbs(constant(&g) + unknown()).unwrap();
                close("from Gibbs", &derivatives(&dual.rminus(&rc)), &SO3::from_gibbs_jac(g).unwrap().1);
            }
            let (m, d_m) = r.to_mrp_jac();
            close("MRP", &derivatives(&moved.to_mrp()), &d_m);
            let mut sets = vec![m];
            sets.extend(r.to_mrp_shadow().ok().filter(|m| m.norm() < 1e3));
            for m in sets {
                let dual = SO3::from_mrp(constant(&m) + unknown()).unwrap();
                close("from MRP", &derivatives(&dual.rminus(&rc)), &SO3::from_mrp_jac(m).unwrap().1);
            }

            let ([a, b], d_ab) = r.to_6d_jac();
            let [ad, bd] = moved.to_6d();
            close(
                "6-D",
                &derivatives(&SVector::<Dual<3>, 6>::from_fn(|i, _| if i < 3 { ad[i] } else { bd[i - 3] })),
                &d_ab,
            );
            let (a, b) = (a * 2.5, b * 0.4 + a * 0.7);
            let u: SVector<Dual<6>, 6> = unknown();
            let (ua, ub) = (u.fixed_rows::<3>(0).into_owned(), u.fixed_rows::<3>(3).into_owned());
            let dual = SO3::from_6d(&(constant(&a) + ua), &(constant(&b) + ub)).unwrap();
            close(
                "from 6-D",
                &derivatives(&dual.rminus(&r.map(Dual::from_re))),
                &SO3::from_6d_jac(&a, &b).unwrap().1,
            );

            let (matrix, d_matrix) = r.to_matrix_jac();
            let entries = SVector::<Dual<3>, 9>::from_column_slice(moved.to_matrix().as_slice());
            close("matrix", &derivatives(&entries), &d_matrix);
            let bent = matrix * 1.3 + Matrix3::new(0.1, 0.2, -0.1, 0.05, 0.0, 0.1, -0.2, 0.1, 0.15);
            let (nearest, d_nearest) = SO3::project_jac(&bent).unwrap();
            let u: SVector<Dual<9>, 9> = unknown();
            let dual =
                bent.map(Dual::<9>::from_re) + SMatrix::<Dual<9>, 3, 3>::from_column_slice(u.as_slice());
            let dual = SO3::project(&dual).unwrap().rminus(&nearest.map(Dual::from_re));
            close("nearest rotation", &derivatives(&dual), &d_nearest);
        }
    }

    #[test]
    fn jacobians_of_axes_and_directions_are_those_of_dual_numbers() {
        for (k, theta) in [1e-6, 1e-3, 0.4, 1.5, 3.0, PI, 4.0].into_iter().enumerate() {
            let axis = Vector3::new(0.3 - k as f64 * 0.2, 0.5, -0.4 + k as f64 * 0.1) * 1.7;
            let (r, d_axis, d_angle) = SO3::from_axis_angle_jac(&axis, theta).unwrap();
            let rc = r.map(Dual::from_re);
            let dual = SO3::from_axis_angle(&(constant(&axis) + unknown()), Dual::from_re(theta)).unwrap();
            close("from axis", &derivatives(&dual.rminus(&rc)), &d_axis);
            let angle = Dual::<1>::from_re(theta).derivative(0);
            let dual = SO3::from_axis_angle(&constant(&axis), angle).unwrap();
            close("from angle", &derivatives(&dual.rminus(&r.map(Dual::from_re))), &d_angle);

            let moved = rc.rplus(&unknown());
            let ((n, angle), d_n, d_angle) = r.to_axis_angle_jac().unwrap();
            let dual = moved.to_axis_angle();
            close("to axis", &derivatives(&dual.0), &d_n);
            close("to angle", &derivatives(&SVector::from([dual.1])), &d_angle);
            assert_eq!((n, angle), r.to_axis_angle());

            let about = Vector3::new(-0.2, 0.9, 0.1 * k as f64);
            let (value, d_swing, d_angle) = r.swing_twist_jac(&about).unwrap();
            let dual = moved.swing_twist(&constant(&about)).unwrap();
            close("swing", &derivatives(&dual.swing.rminus(&value.swing.map(Dual::from_re))), &d_swing);
            close("angle of twist", &derivatives(&SVector::from([dual.angle])), &d_angle);
            let d_twist = about.normalize() * d_angle;
            close("twist", &derivatives(&dual.twist.rminus(&value.twist.map(Dual::from_re))), &d_twist);

            let (a, b) = (axis, r * axis.yzx() * 0.6);
            let (value, d_a, d_b) = SO3::between_directions_jac(&a, &b).unwrap();
            let vc = value.map(Dual::from_re);
            let dual = SO3::between_directions(&(constant(&a) + unknown()), &constant(&b)).unwrap();
            close("from a direction", &derivatives(&dual.rminus(&vc)), &d_a);
            let dual = SO3::between_directions(&constant(&a), &(constant(&b) + unknown())).unwrap();
            close("to a direction", &derivatives(&dual.rminus(&vc)), &d_b);

            let (c, d) = (about * 2.0, axis.zxy());
            let (value, d_parent, d_local) = SO3::from_direction_pairs_jac([&a, &b], [&c, &d]).unwrap();
            let u: SVector<Dual<6>, 6> = unknown();
            let (first, second) = (u.fixed_rows::<3>(0).into_owned(), u.fixed_rows::<3>(3).into_owned());
            let [ac, bc, cc, dc] = [a, b, c, d].map(|x| constant::<6, 3>(&x));
            let moved = [ac + first, bc + second];
            let dual = SO3::from_direction_pairs([&moved[0], &moved[1]], [&cc, &dc]).unwrap();
            close("of the parent pair", &derivatives(&dual.rminus(&value.map(Dual::from_re))), &d_parent);
            let moved = [cc + first, dc + second];
            let dual = SO3::from_direction_pairs([&ac, &bc], [&moved[0], &moved[1]]).unwrap();
            close("of the local pair", &derivatives(&dual.rminus(&value.map(Dual::from_re))), &d_local);
        }
        assert!(matches!(SO3::<f64>::identity().to_axis_angle_jac(), Err(LieError::NoAxis)));
        let x = Vector3::<f64>::x();
        assert!(matches!(SO3::between_directions_jac(&x, &-x), Err(LieError::Opposite)));
    }

    #[test]
    fn angles_have_derivatives_at_half_a_turn_and_at_right_angles() {
        // The scalar part is 0 to the bit: atan(n/w) divides by it.
        let (axis, half) = (Vector3::new(0.6, 0.0, -0.8), SO3::from_xyzw([0.6, 0.0, -0.8, 0.0]).unwrap());
        let moved = half.map(Dual::<3>::from_re).rplus(&unknown());
        let angle = moved.to_axis_angle().1;
        close("angle", &derivatives(&SVector::from([angle])), &axis.transpose());
        let twist = moved.swing_twist(&constant(&axis)).unwrap().angle;
        close("twist", &derivatives(&SVector::from([twist])), &axis.transpose());
        let [left, right] = [FRAC_PI_2, -FRAC_PI_2].map(|angle| SO3::about_z(angle).map(Dual::<3>::from_re));
        let slope = derivatives(&SVector::from([left.angle_to(&right.rplus(&unknown()))]));
        close("distance", &slope.abs(), &Vector3::z().transpose());
        // Yaw and roll by 90°, where the matrix has zeros to divide by.
        for q in [[0.5, 0.5, -0.5, 0.5], [0.0, 0.0, 0.5, 0.5], [0.5, 0.0, 0.0, 0.5], [1.0, 0.0, 0.0, 0.0]] {
            let r = SO3::from_xyzw(q).unwrap();
            for sequence in crate::euler::sequences() {
                if let Ok((_, d_euler)) = r.to_euler_jac(sequence) {
                    let dual = r.map(Dual::<3>::from_re).rplus(&unknown()).to_euler(sequence);
                    close("Euler angles", &derivatives(&Vector3::from(dual.angles)), &d_euler);
                }
            }
        }
    }
}
