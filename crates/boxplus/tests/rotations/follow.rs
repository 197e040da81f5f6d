//! Logarithms near a reference, nearest elements, distances.

use crate::EPS;
use boxplus::lie::{
    Distance, LieError, LieGroup, LogNear, Real, RxSO2, RxSO3, S3, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2,
    Sim3,
};
use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector2, Vector3, Vector6};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, SQRT_2, TAU};

/// Where the angles stand in a tangent: first coordinate and number.
type Angles = (usize, usize);

/// Follows Exp(τ), the angle growing to 15 rad, past π, 2π, 3π, …: Log near the last tangent is τ itself.
fn follows<G: LogNear<D>, const D: usize>((at, n): Angles) {
    let epsilon = G::Scalar::EPSILON;
    let mut followed = SVector::zeros();
    for step in 0..=150 {
        let mut tau = SVector::<f64, D>::from_fn(|i, _| 0.9 * ((i * 7 + 1) as f64).sin());
        let angle = tau.rows(at, n).norm();
        let theta = 0.1 * f64::from(step) + 0.03;
        tau.rows_mut(at, n).scale_mut(theta / angle);
        let tau = tau.map(G::Scalar::lit);
        followed = G::exp(&tau).log_near(&followed).unwrap();
        // The element is right to a few ε of its tangent, θε; the way back amplifies that by the pole of J⁻¹, θ/(2 sin(θ/2)).
        let pole = theta / (2.0 * (theta / 2.0).sin().abs());
        let bound = 4.0 * epsilon * theta.max(1.0) * pole.max(1.0);
        let error = (followed - tau).map(Real::value).norm();
        assert!(error < bound, "at {theta} rad: {error:.1e} of {bound:.1e}\n{followed:?}\n{tau:?}");
    }
}

#[test]
fn every_group_can_be_followed_through_many_turns() {
    macro_rules! follow {
        ($($group:ident, $d:literal, $angles:expr;)*) => { $(
            follows::<$group, $d>($angles);
            follows::<$group<f32>, $d>($angles);
        )* };
    }
    follow! {
        SO2, 1, (0, 1); SO3, 3, (0, 3); RxSO2, 2, (0, 1); RxSO3, 4, (0, 3); SE2, 3, (2, 1); SE3, 6, (3, 3);
        SE23, 9, (3, 3); SGal3, 10, (3, 3); Sim2, 4, (2, 1); Sim3, 7, (3, 3);
    }
}

#[test]
fn unit_quaternions_tell_whole_turns_apart_and_log_is_exact_up_to_them() {
    let n = Vector3::new(2.0, -3.0, 6.0) / 7.0;
    for theta in [0.0, 1e-12, 1e-6, 0.3, 3.0, PI, 3.3, 5.0, 6.0, TAU - 1e-3, TAU - 1e-7, TAU - 1e-12] {
        let q = S3::exp(&(n * theta));
        // The quaternion is right to 2 ε, twice that in angle; near −1 the axis is known to ε over the distance only.
        let axis_error = 8.0 * EPS * if theta > PI { theta / (theta / 2.0).sin() } else { 1.0 };
        assert!((q.log() - n * theta).norm() < axis_error, "{theta}");
        assert!((q.log().norm() - theta).abs() < 8.0 * EPS);
        assert_eq!(SO3::from(q), SO3::exp(&(n * theta)));
        assert_eq!(SO3::from(-q), SO3::from(q));
        assert_ne!(-q, q);
    }
    let minus_one = -S3::<f64>::identity();
    assert!((minus_one.log() - Vector3::new(0.0, 0.0, TAU)).norm() < 4.0 * EPS);
    assert!(
        (S3::<f32>::exp(&Vector3::new(0.0, 3.0, -4.0)).log() - Vector3::new(0.0, 3.0, -4.0)).norm() < 1e-5
    );
    // Followed through four half turns without a jump.
    let mut q = S3::identity();
    for step in 0..600 {
        let next = q.lift_near(&SO3::about_x(0.02 * f64::from(step)));
        assert!(next.rminus(&q).norm() < 0.021);
        q = next;
    }
    assert!((q.log().x - (0.02 * 599.0 - 2.0 * TAU)).abs() < 1e-12);
}

#[test]
fn near_the_shortest_logarithm_it_is_the_shortest_to_the_last_bit() {
    let tau = SVector::<f64, 10>::from_fn(|i, _| 0.8 * ((i * 3 + 1) as f64).sin());
    let x = SGal3::exp(&tau);
    assert_eq!(x.log_near(&(x.log() * 1.1)).unwrap(), x.log());
    let x = SE2::new(Vector2::new(1.0, 2.0), 3.0);
    assert_eq!(x.log_near(&Vector3::zeros()).unwrap(), x.log());
    let x = Sim3::new(SO3::about_x(2.0), Vector3::new(1.0, 2.0, 3.0), 0.4);
    assert_eq!(x.log_near(&SVector::zeros()).unwrap(), x.log());
}

#[test]
fn after_whole_turns_a_translation_has_no_logarithm_and_other_things_have() {
    let turn = Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, TAU);
    let at = |x, y, z| SE3::new(SO3::<f64>::identity(), Vector3::new(x, y, z));
    assert_eq!(at(1.0, 0.0, 0.0).log_near(&turn), Err(LieError::WholeTurns));
    assert_eq!(at(0.0, 0.0, 0.0).log_near(&turn).unwrap(), turn);
    // Along the axis it is a screw of whole turns.
    let screw = at(0.0, 0.0, 3.0).log_near(&turn).unwrap();
    assert!((screw - Vector6::new(0.0, 0.0, 3.0, 0.0, 0.0, TAU)).norm() < 4.0 * EPS);
    assert!(SE3::exp(&screw).rminus(&at(0.0, 0.0, 3.0)).norm() < 16.0 * EPS);
    let plane = SE2::new(Vector2::new(1.0, 0.0), 0.0);
    assert_eq!(plane.log_near(&Vector3::new(0.0, 0.0, TAU)), Err(LieError::WholeTurns));
    // A change of scale opens the circle to a spiral, which ends elsewhere.
    let spiral = Sim3::new(SO3::identity(), Vector3::new(1.0, 0.0, 0.0), 0.5);
    let tau = spiral.log_near(&turn.push(0.5)).unwrap();
    assert!((tau[5] - TAU).abs() < 2.0 * EPS);
    assert!(Sim3::exp(&tau).rminus(&spiral).norm() < 64.0 * EPS);
}

fn numbers<const N: usize>() -> impl Strategy<Value = SVector<f64, N>> {
    prop::array::uniform(-1.0..1.0_f64).prop_map(|a: [f64; N]| SVector::from(a))
}

/// No small step away from the nearest element is nearer to `m`.
fn is_nearest<G: LieGroup<D, Scalar = f64>, const D: usize, const N: usize>(
    m: &SMatrix<f64, N, N>,
    nearest: &G,
    to_matrix: fn(&G) -> SMatrix<f64, N, N>,
) {
    let distance = |x: &G| (to_matrix(x) - m).norm_squared();
    let best = distance(nearest);
    for i in 0..D {
        for step in [1e-2, -1e-2, 1e-4, -1e-4] {
            let mut tau = SVector::zeros();
            tau[i] = step;
            assert!(distance(&nearest.rplus(&tau)) >= best * (1.0 - 16.0 * EPS), "coordinate {i} by {step}");
        }
    }
}

proptest! {
    #[test]
    fn the_nearest_element_is_nearer_than_its_neighbours(m in numbers::<25>(), e in -2..2_i32) {
        // A rotation, bent; otherwise a reflection may be as near.
        let noise = SMatrix::<f64, 5, 5>::from_column_slice(m.as_slice()) * 0.3;
        let turn = SO3::exp(&Vector3::new(m[0] * 3.0, m[7], m[9]));
        let mut five = noise;
        five.fixed_view_mut::<3, 3>(0, 0).copy_from(&((turn.to_matrix() + noise.fixed_view::<3, 3>(0, 0)) * 2.0_f64.powi(e)));
        let four = five.fixed_view::<4, 4>(0, 0).into_owned();
        let three = five.fixed_view::<3, 3>(0, 0).into_owned();
        let plane = SO2::from_angle(m[3] * 3.0).to_matrix() + noise.fixed_view::<2, 2>(0, 0);
        let mut homogeneous = noise.fixed_view::<3, 3>(2, 2).into_owned();
        homogeneous.fixed_view_mut::<2, 2>(0, 0).copy_from(&plane);
        is_nearest(&three, &SO3::project(&three).unwrap(), SO3::to_matrix);
        is_nearest(&three, &RxSO3::project(&three).unwrap(), RxSO3::to_matrix);
        is_nearest(&plane, &SO2::project(&plane).unwrap(), SO2::to_matrix);
        is_nearest(&plane, &RxSO2::project(&plane).unwrap(), RxSO2::to_matrix);
        is_nearest(&homogeneous, &SE2::project(&homogeneous).unwrap(), SE2::to_matrix);
        is_nearest(&homogeneous, &Sim2::project(&homogeneous).unwrap(), Sim2::to_matrix);
        is_nearest(&four, &SE3::project(&four).unwrap(), SE3::to_matrix);
        is_nearest(&four, &Sim3::project(&four).unwrap(), Sim3::to_matrix);
        is_nearest(&five, &SE23::project(&five).unwrap(), SE23::to_matrix);
        is_nearest(&five, &SGal3::project(&five).unwrap(), SGal3::to_matrix);
    }
    #[test]
    fn an_element_is_nearest_to_its_own_matrix(t in numbers::<10>()) {
        let bound = 64.0 * EPS;
        let x = SGal3::exp(&(t * 2.0));
        prop_assert!(SGal3::project(&x.to_matrix()).unwrap().rminus(&x).norm() < bound);
        let x = x.extended_pose();
        prop_assert!(SE23::project(&x.to_matrix()).unwrap().rminus(&x).norm() < bound);
        let x = Sim3::exp(&t.fixed_rows::<7>(0).into_owned());
        prop_assert!(Sim3::project(&x.to_matrix()).unwrap().rminus(&x).norm() < bound);
        let x = Sim2::exp(&t.fixed_rows::<4>(0).into_owned());
        prop_assert!(Sim2::project(&x.to_matrix()).unwrap().rminus(&x).norm() < bound);
        let linear = RxSO2::new(x.rotation(), x.log_scale());
        prop_assert!(RxSO2::project(&linear.to_matrix()).unwrap().rminus(&linear).norm() < bound);
    }
    #[test]
    fn distances_of_rotations_are_what_their_names_say(a in numbers::<3>(), b in numbers::<3>()) {
        let (x, y) = (SO3::exp(&(a * 3.0)), SO3::exp(&(b * 3.0)));
        let theta = x.angle_to(&y);
        prop_assert!((theta - y.rminus(&x).norm()).abs() < 8.0 * EPS);
        prop_assert!((theta - y.lminus(&x).norm()).abs() < 8.0 * EPS);
        prop_assert!((x.chordal_distance(&y) - (x.to_matrix() - y.to_matrix()).norm()).abs() < 16.0 * EPS);
        prop_assert!((x.chordal_distance(&y) - 2.0 * SQRT_2 * (theta / 2.0).sin()).abs() < 8.0 * EPS);
        let (p, q) = (SVector::from(x.quaternion_xyzw()), SVector::from(y.quaternion_xyzw()));
        prop_assert!((x.quaternion_distance(&y) - (p - q).norm().min((p + q).norm())).abs() < 8.0 * EPS);
        prop_assert!((x.quaternion_distance(&y) - 2.0 * (theta / 4.0).sin()).abs() < 8.0 * EPS);
        let (x, y) = (SO2::from_angle(a.x * 3.0), SO2::from_angle(b.x * 3.0));
        prop_assert!((x.chordal_distance(&y) - (x.to_matrix() - y.to_matrix()).norm()).abs() < 8.0 * EPS);
        prop_assert!((x.chordal_distance(&y) - 2.0 * SQRT_2 * (x.angle_to(&y) / 2.0).sin()).abs() < 8.0 * EPS);
    }
    #[test]
    fn a_weighted_distance_is_symmetric_and_does_not_depend_on_the_world(
        a in numbers::<6>(), b in numbers::<6>(), w in numbers::<6>(), weights in numbers::<6>(),
    ) {
        let (x, y, w) = (SE3::exp(&a), SE3::exp(&b), SE3::exp(&w));
        let distance = x.weighted_distance(&y, &weights);
        prop_assert!((distance - y.weighted_distance(&x, &weights)).abs() < 64.0 * EPS);
        prop_assert!((distance - (w * x).weighted_distance(&(w * y), &weights)).abs() < 256.0 * EPS);
        prop_assert_eq!(x.weighted_distance(&x, &weights), 0.0);
    }
}

#[test]
fn small_distances_keep_their_digits() {
    let x = SO3::exp(&Vector3::new(0.3, -1.2, 0.8));
    for theta in [1e-150_f64, 1e-12, 1e-5] {
        let y = SO3::about_y(theta);
        assert!((SO3::identity().angle_to(&y) / theta - 1.0).abs() < 4.0 * EPS);
        assert!((SO3::identity().chordal_distance(&y) / (theta * SQRT_2) - 1.0).abs() < 1e-10);
        assert!((SO3::identity().quaternion_distance(&y) / (theta / 2.0) - 1.0).abs() < 1e-10);
    }
    assert!((x.angle_to(&x.compose(&SO3::about_x(PI))) - PI).abs() < 4.0 * EPS);
    assert!((SO2::from_angle(3.0).angle_to(&SO2::from_angle(-3.0)) - (TAU - 6.0)).abs() < 4.0 * EPS);
    assert_eq!(SO2::from_angle(FRAC_PI_2).angle_to(&SO2::from_angle(FRAC_PI_2)), 0.0);
}

#[test]
fn matrices_without_a_nearest_element_are_refused() {
    assert!(matches!(RxSO3::<f64>::project(&Matrix3::zeros()), Err(LieError::Undetermined { .. })));
    assert!(matches!(RxSO2::<f64>::project(&Matrix2::zeros()), Err(LieError::Undetermined { .. })));
    let mut m = SE3::<f64>::identity().to_matrix();
    m[(1, 3)] = f64::NAN;
    assert_eq!(SE3::project(&m), Err(LieError::NotFinite));
    assert_eq!(Sim3::project(&m), Err(LieError::NotFinite));
    let mut m = SGal3::<f64>::identity().to_matrix();
    m[(3, 4)] = f64::INFINITY;
    assert_eq!(SGal3::project(&m), Err(LieError::NotFinite));
    assert_eq!(RxSO3::<f64>::from_matrix(&Matrix3::zeros()), Err(LieError::NotAScale { scale: 0.0 }));
    assert_eq!(RxSO2::from_scale(SO2::identity(), -1.0), Err(LieError::NotAScale { scale: -1.0 }));
}

#[test]
fn scaled_rotations_are_similarities_about_the_origin_to_the_last_bit() {
    let (a, b) = (nalgebra::Vector4::new(0.4, -1.3, 0.8, 0.3), nalgebra::Vector4::new(-2.0, 0.3, 0.5, -0.7));
    let (x, y, p) = (RxSO3::exp(&a), RxSO3::exp(&b), Vector3::new(0.3, -0.7, 1.9));
    assert_eq!(Sim3::from(x * y), Sim3::from(x) * Sim3::from(y));
    assert_eq!(Sim3::from(x.inverse()), Sim3::from(x).inverse());
    assert_eq!(x * p, Sim3::from(x) * p);
    assert_eq!(Sim3::from(x).log().fixed_rows::<4>(3).into_owned(), x.log());
    // SO(3) and the real numbers side by side: their bounds are its bounds.
    assert_eq!((x.rotation(), x.log_scale()), (SO3::exp(&a.xyz()), a.w));
    assert_eq!((x * y).rotation(), x.rotation() * y.rotation());
    assert_eq!(
        RxSO3::right_jacobian_inverse(&a).fixed_view::<3, 3>(0, 0),
        SO3::right_jacobian_inverse(&a.xyz())
    );
    let back = RxSO3::from_matrix(&x.to_matrix()).unwrap();
    assert!(back.rminus(&x).norm() < 16.0 * EPS);

    let (x, y, p) = (RxSO2::exp(&a.xy()), RxSO2::exp(&b.xy()), p.xy());
    assert_eq!(Sim2::from(x * y), Sim2::from(x) * Sim2::from(y));
    assert_eq!(x * p, Sim2::from(x) * p);
    assert_eq!((x.rotation(), x.log_scale()), (SO2::from_angle(a.x), a.y));
    assert!(RxSO2::from_matrix(&x.to_matrix()).unwrap().rminus(&x).norm() < 8.0 * EPS);
}
