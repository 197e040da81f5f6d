//! Every closed form is held against dual numbers, at generic points, near the identity, and near π.

use nalgebra::{SMatrix, SVector, Unit, Vector2, Vector3, Vector6, vector};

use super::*;
use crate::camera::{Pinhole, Projective, Snavely, Stereo, View};
use crate::graph::{Factor, GroupVariable, JacobianBlock, Variables, dual_jacobians};
use crate::lie::{Action, LieGroup, Rn, S2, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3};
use crate::trajectory::{Imu, ImuBias, ImuNoise, Moving};
use crate::uncertainty::Covariance;

/// Largest difference of the closed Jacobians from the dual ones, relative to their size.
fn check<const R: usize, F: Factor<R>>(name: &str, factor: &F, variables: &F::Variables)
where
    F::Variables: Variables,
{
    let (residual, closed) = factor.residual_jac(variables);
    let dual = dual_jacobians(factor, variables);
    let plain = factor.residual::<f64>(&variables.constant());
    assert!((residual - plain).amax() <= 1e-13 * (1.0 + plain.amax()), "{name}: residual {residual} {plain}");
    let identity = SMatrix::<f64, R, R>::identity();
    let columns = |j| F::Variables::whiten::<R, Vec<f64>>(j, &identity, |parts| parts.concat());
    let (closed, dual): (Vec<f64>, Vec<f64>) = (columns(&closed), columns(&dual));
    let size = dual.iter().fold(1.0, |m: f64, x| m.max(x.abs()));
    for (i, (a, b)) in closed.iter().zip(&dual).enumerate() {
        assert!((a - b).abs() <= 2e-13 * size, "{name}: entry {i} of {closed:?}\n{dual:?}");
    }
}

fn poses3() -> Vec<SE3> {
    let axis = Vector3::new(0.36, -0.48, 0.8);
    [0.0, 1e-9, 1e-3, 0.7, 2.0, 3.1]
        .iter()
        .map(|angle| SE3::exp(&Vector6::new(1.0, -2.0, 0.5, axis.x * angle, axis.y * angle, axis.z * angle)))
        .collect()
}

fn poses2() -> Vec<SE2> {
    [-3.1, -1.0, 0.0, 1e-9, 0.4, 2.0].iter().map(|angle| SE2::exp(&vector![0.7, -1.2, *angle])).collect()
}

#[test]
fn displacements_and_priors_have_exact_jacobians_in_every_chart() {
    for (i, x1) in poses3().iter().enumerate() {
        for x2 in &poses3() {
            // Measurements near the prediction, so that the error angle is generic and below π.
            let z = x1.between(x2).rplus(&Vector6::new(0.1, 0.2, -0.3, 0.4, -0.2, 0.1 * (1.0 + i as f64)));
            check("log", &Between::new(z), &(*x1, *x2));
            check("g2o", &Between::<_, G2o>::in_chart(z), &(*x1, *x2));
            check("difference", &Between::<_, Difference>::in_chart(z), &(*x1, *x2));
            check("chordal", &Between::<_, Chordal>::in_chart(z), &(*x1, *x2));
            check("product", &Between::<_, Product>::in_chart(z), &(*x1, *x2));
        }
        check("prior", &Prior { mean: poses3()[3] }, &(*x1,));
        check("so3", &Prior { mean: SO3::exp(&Vector3::new(0.3, 0.1, -0.2)) }, &(x1.rotation(),));
    }
    for x1 in &poses2() {
        for x2 in &poses2() {
            let z = x1.between(x2).rplus(&vector![0.1, -0.2, 0.3]);
            check("log", &Between::new(z), &(*x1, *x2));
            check("g2o", &Between::<_, G2o>::in_chart(z), &(*x1, *x2));
            check("difference", &Between::<_, Difference>::in_chart(z), &(*x1, *x2));
            check("chordal", &Between::<_, Chordal>::in_chart(z), &(*x1, *x2));
            check("product", &Between::<_, Product>::in_chart(z), &(*x1, *x2));
        }
        check("prior", &Prior { mean: SE2::exp(&vector![0.3, 0.2, 0.1]) }, &(*x1,));
        check("so2", &Between::new(SO2::from_angle(0.2)), &(x1.rotation(), SO2::from_angle(0.5)));
    }
    group::<SE23, 9>("se23");
    group::<SGal3, 10>("sgal3");
    group::<Sim3, 7>("sim3");
    group::<Sim2, 4>("sim2");
    check(
        "rn",
        &Between::new(Rn::new(vector![1.0, 2.0])),
        &(Rn::new(vector![0.0, 1.0]), Rn::new(vector![3.0, 1.0])),
    );
}

/// Displacements and priors of a group, at tangents up to length 3.
fn group<G: GroupVariable<D>, const D: usize>(name: &str)
where
    (G,): Variables,
    (G, G): Variables,
{
    let tangent = |k: usize, length: f64| {
        SVector::<f64, D>::from_fn(|i, _| ((3 * i + 7 * k + 1) as f64).sin()).normalize() * length
    };
    for (k, length) in [0.0, 1e-9, 1e-3, 0.7, 2.0, 3.0].into_iter().enumerate() {
        let (x1, x2) = (G::exp(&tangent(k, length)), G::exp(&tangent(k + 6, 1.1)));
        let z = x1.between(&x2).rplus(&tangent(k + 12, 0.6));
        check(name, &Between::new(z), &(x1, x2));
        check(name, &Prior { mean: x2.rplus(&tangent(k, 0.6)) }, &(x2,));
    }
}

#[test]
fn ranges_bearings_and_sightings_have_exact_jacobians() {
    let point3 = Rn::new(vector![3.0, -1.0, 2.5]);
    for x in &poses3() {
        check("range", &Range::new(1.3), &(*x, point3));
        check(
            "range of poses",
            &Range::new(1.3),
            &(*x, SE3::exp(&Vector6::new(4.0, 1.0, 0.0, 0.5, 0.2, 0.1))),
        );
        check("bearing", &Bearing3::new(&Unit::new_normalize(Vector3::new(0.2, 1.0, -0.4))), &(*x, point3));
        let sensor = SE3::exp(&Vector6::new(0.1, 0.2, 0.3, 0.5, -0.4, 0.3));
        let sighting = Sighting3 { measured: Vector3::new(1.0, 2.0, 3.0), pose_from_sensor: sensor };
        check("sighting", &sighting, &(*x, point3));
    }
    let point2 = Rn::new(vector![-2.0, 4.0]);
    for x in &poses2() {
        check("range", &Range::new(1.3), &(*x, point2));
        check("bearing", &Bearing2::new(3.0), &(*x, point2));
        check("sighting", &Sighting2 { measured: Vector2::new(1.0, 2.0) }, &(*x, point2));
    }
    // Exactly at right angles to the measured direction, where atan(y/x) divides by zero.
    check("bearing abeam", &Bearing2::new(0.0), &(SE2::identity(), Rn::new(vector![0.0, 4.0])));
}

/// Half a second of rough motion.
fn samples() -> Vec<Imu> {
    let wave = |i: usize, k: usize| ((3 * i + 5 * k) as f64).sin();
    let sample = |i| Imu {
        gyroscope: Vector3::from_fn(|k, _| 1.5 * wave(i, k)),
        accelerometer: Vector3::from_fn(|k, _| 4.0 * wave(i + 7, k)),
        duration: 0.01,
    };
    (0..50).map(sample).collect()
}

#[test]
fn inertial_factors_and_fixes_have_exact_jacobians() {
    let noise = ImuNoise { gyro: 2e-3, accel: 2e-2 };
    let imu = Inertial::new(&samples(), ImuBias::zero(), noise, Vector3::new(0.3, -0.2, -9.8)).unwrap();
    let tilted = InertialUnderGravity::new(&samples(), ImuBias::zero(), noise, 9.81).unwrap();
    let down = S2::from_vector(&Vector3::new(0.3, -0.2, -9.8)).unwrap();
    let bias = ImuBias::exp(&Vector6::new(0.1, -0.05, 0.02, 0.3, -0.1, 0.2));
    for (k, length) in [0.0, 1e-9, 1e-3, 0.7, 2.0, 3.0].into_iter().enumerate() {
        let tangent = |k: usize| SVector::<f64, 9>::from_fn(|i, _| ((3 * i + 7 * k + 1) as f64).sin());
        let from = SE23::exp(&(tangent(k).normalize() * length));
        let to = imu.sum().predict(&from, &bias, &imu.gravity).rplus(&(tangent(k + 6) * 0.4));
        check("inertial", &imu, &(from, to, bias));
        check("inertial, gravity unknown", &tilted, &(from, to, bias, down));
        let antenna = Position::of_point(vector![1.0, 2.0, 3.0], vector![0.3, -0.5, 0.2]);
        check("position", &antenna, &(from,));
        check("velocity", &Velocity { measured: vector![1.0, 2.0, 3.0] }, &(from,));
        check(
            "position in the plane",
            &Position::of_point(vector![1.0, 2.0], vector![0.3, -0.5]),
            &(poses2()[k],),
        );
        check("distance", &Range::new(1.3), &(from, to));
    }
}

#[test]
fn a_sum_made_anew_is_the_sum_about_the_new_bias() {
    let noise = ImuNoise { gyro: 2e-3, accel: 2e-2 };
    let gravity = Vector3::new(0.0, 0.0, -9.81);
    let old = Inertial::new(&samples(), ImuBias::zero(), noise, gravity).unwrap();
    let x = SE23::identity();
    let error = |scale: f64| {
        let bias = ImuBias::exp(&(Vector6::new(0.1, -0.05, 0.02, 0.3, -0.1, 0.2) * scale));
        let renewed = old.renewed(&(x, x, bias)).unwrap();
        let fresh = Inertial::new(&samples(), bias, noise, gravity).unwrap();
        assert_eq!((renewed.factor.sum(), renewed.noise), (fresh.sum(), fresh.noise().unwrap()));
        renewed.error
    };
    // What is left out is of second order.
    let [small, large] = [error(0.1), error(1.0)];
    assert!((large / small / 100.0 - 1.0).abs() < 0.2 && large > 0.01, "{small} {large}");
}

/// The same, against central differences: they compile for large states, too, where dual numbers take minutes.
fn check_differences<const R: usize, F: Factor<R>>(name: &str, factor: &F, variables: &F::Variables) {
    const H: f64 = 1e-5; // h²/6 ≈ ε/h ≈ 2e-11, times third derivatives and sizes of order 100
    let (residual, closed) = factor.residual_jac(variables);
    let plain = factor.residual::<f64>(&variables.constant());
    assert!((residual - plain).amax() <= 1e-13 * (1.0 + plain.amax()), "{name}: residual {residual} {plain}");
    F::Variables::whiten::<R, ()>(&closed, &SMatrix::identity(), |parts| {
        for (position, (part, &dim)) in parts.iter().zip(F::Variables::DIMS).enumerate() {
            for d in 0..dim {
                let at = |h: f64| {
                    let delta: Vec<f64> = (0..dim).map(|i| if i == d { h } else { 0.0 }).collect();
                    factor.residual::<f64>(&variables.perturb::<f64>(position, &delta))
                };
                let slope = (at(H) - at(-H)) / (2.0 * H);
                for (r, (row, wanted)) in part.chunks_exact(dim).zip(&slope).enumerate() {
                    let off = (row[d] - wanted).abs();
                    assert!(
                        off < 1e-8 * (1.0 + wanted.abs()),
                        "{name}: ∂r{r}/∂x{position}[{d}] is off by {off:.1e}"
                    );
                }
            }
        }
    });
}

/// A tangent of numbers in (−1, 1), times `size`.
fn tangent<const D: usize>(k: usize, size: f64) -> SVector<f64, D> {
    SVector::from_fn(|i, _| size * ((3 * i + 7 * k + 1) as f64).sin())
}

/// Priors of order R, and a pose seen between their states.
fn joined_by_a_prior<G: GroupVariable<D>, const D: usize, const R: usize, const N: usize>() {
    let prior = MotionPrior::<G, D, R, N>::new(1.4, Covariance::unit()).unwrap();
    for k in 0..4 {
        let from = Moving::<G, D, R, N>::exp(&tangent(k, 0.8));
        let to = from.rplus(&tangent(k + 9, 0.5));
        check_differences("prior", &prior, &(from, to));
        for time in [0.0, 0.6, 1.4] {
            let seen = Interpolated::<_, Moving<G, D, R, N>, _>::new(Prior { mean: *to.value() }, 1.4, time);
            check_differences("interpolated", &seen.unwrap(), &(from, to));
        }
    }
}

/// An element seen on a spline.
fn on_a_spline<G: GroupVariable<D>, const D: usize>()
where
    (G, G, G, G): Variables,
{
    for k in 0..4 {
        let a = G::exp(&tangent(k, 0.8));
        let b = a.rplus(&tangent(k + 9, 0.5));
        let (c, d) = (b.rplus(&tangent(k + 3, 0.5)), b.rplus(&tangent(k + 5, 0.7)));
        for place in [0.0, 0.4, 1.0] {
            let seen = OnSpline::<_, _, D>::new(Prior { mean: b.rplus(&tangent(k, 0.3)) }, place);
            check_differences("on a spline", &seen.unwrap(), &(a, b, c, d));
        }
    }
}

#[test]
fn factors_in_continuous_time_have_the_jacobians_of_differences_on_many_groups() {
    joined_by_a_prior::<Rn<2>, 2, 2, 4>();
    joined_by_a_prior::<SO2, 1, 3, 3>();
    joined_by_a_prior::<SE2, 3, 2, 6>();
    joined_by_a_prior::<SO3, 3, 3, 9>();
    joined_by_a_prior::<SE3, 6, 2, 12>();
    joined_by_a_prior::<SE3, 6, 3, 18>();
    joined_by_a_prior::<SE23, 9, 2, 18>();
    joined_by_a_prior::<Sim3, 7, 2, 14>();
    on_a_spline::<Rn<2>, 2>();
    on_a_spline::<SO2, 1>();
    on_a_spline::<SE2, 3>();
    on_a_spline::<SO3, 3>();
    on_a_spline::<SE3, 6>();
    on_a_spline::<SE23, 9>();
    on_a_spline::<SGal3, 10>();
    on_a_spline::<Sim3, 7>();
}

#[test]
fn factors_in_continuous_time_have_exact_jacobians() {
    type Turning = Moving<SO3, 3, 2, 6>;
    let from = Turning::exp(&tangent(1, 0.8));
    let to = from.rplus(&tangent(9, 0.5));
    check("prior", &MotionPrior::<SO3, 3, 2, 6>::new(1.4, Covariance::unit()).unwrap(), &(from, to));
    let seen = Prior { mean: *to.value() };
    check("interpolated", &Interpolated::<_, Turning, _>::new(seen, 1.4, 0.6).unwrap(), &(from, to));
    let knots = (*from.value(), *to.value(), SO3::identity(), *from.value());
    check("on a spline", &OnSpline::<_, _, 3>::new(seen, 0.4).unwrap(), &knots);
}

#[test]
fn landmarks_and_inertial_readings_in_continuous_time_have_the_jacobians_of_differences() {
    let sighting =
        Sighting3 { measured: Vector3::new(1.0, 2.0, 3.0), pose_from_sensor: SE3::exp(&tangent(3, 0.5)) };
    let landmark = Rn::new(vector![3.0, -1.0, 2.5]);
    for k in 0..4 {
        let from = Moving::<SE3, 6, 2, 12>::exp(&tangent(k, 0.8));
        let to = from.rplus(&tangent(k + 9, 0.5));
        let seen = Interpolated::<_, Moving<SE3, 6, 2, 12>, _>::new(sighting, 1.4, 0.5).unwrap();
        check_differences("sighting between states", &seen, &(from, to, landmark));

        let knots: [SE3; 4] = core::array::from_fn(|i| from.value().rplus(&tangent(k + 2 * i, 0.3)));
        let [a, b, c, d] = knots;
        check_differences(
            "sighting on a spline",
            &OnSpline::<_, _, 6>::new(sighting, 0.3).unwrap(),
            &(a, b, c, d, landmark),
        );
        let reading = [Vector3::new(0.1, 0.2, 0.3), Vector3::new(0.3, 0.1, 9.0)];
        let imu = SplineImu::new(reading, 0.3, 0.5, Vector3::new(0.1, 0.2, -9.8)).unwrap();
        check_differences("inertial reading", &imu, &(a, b, c, d, ImuBias::exp(&tangent(k, 0.1))));
    }
}

#[test]
fn reprojections_have_exact_jacobians_before_the_camera_and_behind_it() {
    let snavely = Snavely { focal: 400.0, distortion: [-0.1, 0.02] };
    let pinhole =
        Pinhole { distortion: [-0.2, 0.1, 1e-3, 2e-3, 0.0], ..Pinhole::new([400.0; 2], [320.0; 2]) };
    let stereo = Stereo { focal: [400.0; 2], centre: [320.0; 2], baseline: 0.3 };
    let sensor = SE3::exp(&Vector6::new(0.1, 0.2, 0.3, 0.5, -0.4, 0.3));
    for x in &poses3() {
        for p in [vector![0.3, -0.4, 2.0], vector![-0.5, 0.2, -3.0]] {
            let point = Rn::new(x.act(&p));
            let known =
                Reprojection { camera: pinhole, pose_from_camera: sensor, measured: vector![300.0, 310.0] };
            check("known camera", &known, &(*x, point));
            check("pair", &Reprojection::new(stereo, vector![300.0, 310.0, 280.0, 310.0]), &(*x, point));
            let shared = ReprojectionShared::<Pinhole, Rn<3>, 2>::new(vector![300.0, 310.0]);
            check("shared camera", &shared, &(*x, point, pinhole));
            let view = View { world_from_camera: *x, camera: snavely };
            check(
                "view",
                &ReprojectionOwn::<View<Snavely, 3, 9>, Rn<3>, 2>::new(vector![30.0, 31.0]),
                &(view, point),
            );
            for extent in [1.0, 1e-9, -2.0] {
                let far = Projective::new(&point.vector(), extent);
                let own = ReprojectionOwn::<View<Snavely, 3, 9>, Projective, 2>::new(vector![30.0, 31.0]);
                check("view of a far point", &own, &(view, far));
                let shared = ReprojectionShared::<Pinhole, Projective, 2>::new(vector![300.0, 310.0]);
                check("shared camera, far point", &shared, &(*x, far, pinhole));
            }
        }
    }
}

#[test]
fn odometry_with_parameters_has_exact_jacobians() {
    let (c2, c1) = (Rn::new(vector![0.2, -0.3]), Rn::new(vector![0.7]));
    for x1 in &poses2() {
        for x2 in &poses2() {
            let measured = x2.rminus(x1) + vector![0.3, -0.1, 0.2];
            check("bias", &CalibratedOdometry::<SE2, 3, 2>::biased(measured, [0, 2]), &(*x1, *x2, c2));
            check("scale", &CalibratedOdometry::<SE2, 3, 1>::new(measured, measured), &(*x1, *x2, c1));
        }
    }
    for x1 in &poses3() {
        for x2 in &poses3() {
            let measured = x2.rminus(x1) + Vector6::new(0.3, -0.1, 0.2, 0.1, 0.2, -0.4);
            check("bias", &CalibratedOdometry::<SE3, 6, 2>::biased(measured, [0, 5]), &(*x1, *x2, c2));
            check("scale", &CalibratedOdometry::<SE3, 6, 1>::new(measured, measured), &(*x1, *x2, c1));
        }
    }
}

#[test]
fn a_bias_is_added_to_what_is_read() {
    let (x, u, c) = (poses2()[1], vector![0.5, 0.1, 0.2], vector![0.05, 0.02]);
    let read = vector![0.55, 0.1, 0.22];
    let factor = CalibratedOdometry::<SE2, 3, 2>::biased(read, [0, 2]);
    assert!(factor.residual_jac(&(x, x.rplus(&u), Rn::new(c))).0.amax() < 1e-15);
    // A coordinate that there is not is the bias of nothing.
    assert_eq!(CalibratedOdometry::<SE2, 3, 1>::biased(read, [3]).enters.amax(), 0.0);
}

#[test]
fn every_chart_is_zero_at_its_measurement() {
    let (x1, x2) = (poses3()[3], poses3()[4]);
    let z = x1.between(&x2);
    let zero = |r: Vector6<f64>| assert!(r.amax() < 1e-15, "{r}");
    zero(Between::new(z).residual_jac(&(x1, x2)).0);
    zero(Between::<_, G2o>::in_chart(z).residual_jac(&(x1, x2)).0);
    zero(Between::<_, Difference>::in_chart(z).residual_jac(&(x1, x2)).0);
    zero(Between::<_, Product>::in_chart(z).residual_jac(&(x1, x2)).0);
    zero(Between::<_, Chordal>::in_chart(z).residual_jac(&(x1, x2)).0);
    let (x1, x2) = (poses2()[1], poses2()[5]);
    let z = x1.between(&x2);
    let zero = |r: Vector3<f64>| assert!(r.amax() < 1e-15, "{r}");
    zero(Between::new(z).residual_jac(&(x1, x2)).0);
    zero(Between::<_, G2o>::in_chart(z).residual_jac(&(x1, x2)).0);
    zero(Between::<_, Chordal>::in_chart(z).residual_jac(&(x1, x2)).0);
}

#[test]
fn charts_do_not_see_the_sign_of_a_quaternion() {
    let z = SE3::exp(&Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, 3.0));
    let d = SE3::exp(&Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, 3.2)); // w < 0 on the way
    let (e, _) = <G2o as Chart<SE3, 6>>::error_jac(&z, &d);
    assert!(
        (e[5] - 0.1f64.sin()).abs() < 1e-15
            && JacobianBlock::as_slice(&e)[..5].iter().all(|x| x.abs() < 1e-15)
    );
}

#[test]
fn where_a_distance_has_no_derivative_it_is_zero() {
    let here = Rn::new(vector![1.0, 2.0]);
    let (r, (a, b)) = Range::<_, _, 2>::new(0.5).residual_jac(&(here, here));
    assert_eq!((r[0], a.amax(), b.amax()), (-0.5, 0.0, 0.0));
    let (_, (x, p)) = Bearing2::new(0.1).residual_jac(&(SE2::new(here.vector(), 0.3), here));
    assert_eq!((x.amax(), p.amax()), (0.0, 0.0));
}
