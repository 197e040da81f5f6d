use crate::support::*;
use boxplus::lie::{LieGroup, Real, SE2, SE3, SE23, SGal3, SO3, Sim3, Tangent};
use boxplus::trajectory::{
    Integrator, TrajectoryError, magnus_linear, magnus_linear_spatial, magnus2, magnus4, magnus4_spatial,
};

/// How long is integrated: a few turns.
const T: f64 = 4.0;

/// A velocity that turns, depends on the element and commutes with itself at no two times.
fn field<G: LieGroup<D, Scalar = f64>, const D: usize>(t: f64, x: &G) -> Tangent<f64, D> {
    let here = x.adjoint() * Tangent::<f64, D>::from_fn(|i, _| 0.3 * (i as f64 + 1.0).cos());
    draw::<D>(1) * (1.3 * t).cos()
        + draw::<D>(2) * (0.9 * t).sin()
        + draw::<D>(3) * 0.4
        + here.map(f64::sin) * 0.3
}

/// The part that does not depend on the element.
fn clock<const D: usize>(t: f64) -> Tangent<f64, D> {
    draw::<D>(1) * (1.3 * t).cos() + draw::<D>(2) * (0.9 * t).sin() + draw::<D>(3) * 0.4
}

/// Least-squares slope of log error against log step, over the errors that rounding does not touch.
fn slope(errors: &[(f64, f64)]) -> f64 {
    let n = errors.len() as f64;
    let points = errors.iter().map(|(h, e)| (h.ln(), e.ln()));
    let (x, y) = points.clone().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let (xy, xx) = points.fold((0.0, 0.0), |(a, b), (u, v)| (a + (u - x) * (v - y), b + (u - x) * (u - x)));
    xy / xx
}

/// The order measured between `coarse` and `coarse·2^halvings` steps, against a far finer run of the same equation.
fn measured<G: LieGroup<D, Scalar = f64>, const D: usize>(
    truth: &G,
    coarse: u32,
    halvings: u32,
    run: impl Fn(u32) -> G,
) -> f64 {
    let errors: Vec<_> =
        (0..=halvings).map(|k| (1.0 / f64::from(coarse << k), distance(&run(coarse << k), truth))).collect();
    let finest = errors[errors.len() - 1].1;
    assert!(finest > 1e-12, "rounding has taken over: {errors:?}");
    slope(&errors)
}

/// How far an order can be followed: (coarsest steps, halvings). Ten halvings are three decades of h; at order 4 that would
/// be twelve decades of error, more than lie between the asymptotic regime and the rounding of a thousand steps: seven
/// there, two decades.
fn range(order: u32) -> (u32, u32) {
    match order {
        1 => (64, 10),
        2 => (16, 10),
        3 => (8, 10),
        _ => (8, 7),
    }
}

fn orders<G: LieGroup<D, Scalar = f64>, const D: usize>() {
    let x = G::exp(&(draw(5) * 0.5));
    let truth = Integrator::CommutatorFree4.integrate(&x, 0.2, T, 1 << 14, field::<G, D>);
    let spatial = |t: f64, x: &G| -field::<G, D>(t, &x.inverse());
    for method in Integrator::ALL {
        let (coarse, halvings) = range(method.order());
        let order = measured(&truth, coarse, halvings, |n| method.integrate(&x, 0.2, T, n, field::<G, D>));
        assert!((order - f64::from(method.order())).abs() < 0.1, "{method:?}: order {order:.3}");
        // The mirror image of the problem has the mirror image as its solution.
        let h = T / 16.0;
        let mirrored =
            (0..16).fold(x.inverse(), |y, i| method.step_spatial(&y, 0.2 + h * f64::from(i), h, spatial));
        let body = method.integrate(&x, 0.2, T, 16, field::<G, D>);
        same("spatial form", &mirrored.inverse(), &body, 256.0 * EPS);
    }
}

#[test]
fn every_integrator_has_its_order_on_every_group() {
    orders::<SO3, 3>();
    orders::<SE2, 3>();
    orders::<SE3, 6>();
    orders::<SE23, 9>();
    orders::<SGal3, 10>();
    orders::<Sim3, 7>();
}

#[test]
fn the_field_is_followed_to_the_truth_of_another_method() {
    // Two methods of different construction agree at a fine step: neither is merely consistent with itself.
    let x = SE3::exp(&(draw(5) * 0.5));
    let a = Integrator::CommutatorFree4.integrate(&x, 0.2, T, 4096, field::<SE3, 6>);
    let b = Integrator::Rkmk4.integrate(&x, 0.2, T, 4096, field::<SE3, 6>);
    same("CF4 and RKMK4", &a, &b, 1e-13);
}

fn magnus_orders<G: LieGroup<D, Scalar = f64>, const D: usize>() {
    let x = G::exp(&(draw(5) * 0.5));
    let body = |n: u32, omega: &dyn Fn(f64, f64) -> Tangent<f64, D>| {
        let h = T / f64::from(n);
        (0..n).fold(x, |x, i| x.rplus(&omega(0.2 + h * f64::from(i), h)))
    };
    let spatial = |n: u32, omega: &dyn Fn(f64, f64) -> Tangent<f64, D>| {
        let h = T / f64::from(n);
        (0..n).fold(x, |x, i| x.lplus(&omega(0.2 + h * f64::from(i), h)))
    };
    let truth = Integrator::CommutatorFree4.integrate(&x, 0.2, T, 1 << 14, |t, _: &G| clock::<D>(t));
    let order = measured(&truth, 16, 10, |n| body(n, &|t, h| magnus2::<G, D>(clock::<D>, t, h)));
    assert!((order - 2.0).abs() < 0.1, "Magnus 2: {order:.3}");
    let order = measured(&truth, 4, 7, |n| body(n, &|t, h| magnus4::<G, D>(clock::<D>, t, h)));
    assert!((order - 4.0).abs() < 0.1, "Magnus 4: {order:.3}");
    let order = measured(&truth, 16, 10, |n| body(n, &|t, h| magnus4_spatial::<G, D>(clock::<D>, t, h)));
    assert!((order - 2.0).abs() < 0.1, "Magnus 4 with the signs of the other side: {order:.3}");

    let truth = spatial(1 << 14, &|t, h| magnus2::<G, D>(clock::<D>, t, h));
    let fine = spatial(1 << 10, &|t, h| magnus4_spatial::<G, D>(clock::<D>, t, h));
    same("both orders lead to one solution", &fine, &truth, 1e-8);
    let order = measured(&fine, 4, 6, |n| spatial(n, &|t, h| magnus4_spatial::<G, D>(clock::<D>, t, h)));
    assert!((order - 4.0).abs() < 0.1, "Magnus 4, spatial: {order:.3}");
}

#[test]
fn magnus_has_its_order_on_both_sides_and_loses_it_with_the_wrong_sign() {
    magnus_orders::<SO3, 3>();
    magnus_orders::<SE3, 6>();
    magnus_orders::<SE23, 9>();
    magnus_orders::<SGal3, 10>();
    magnus_orders::<Sim3, 7>();
}

#[test]
fn rkmk4_with_the_brackets_of_the_other_side_falls_to_order_two() {
    // What a transcription from a text in spatial form would do in the body form.
    let wrong = |x: &SO3, t: f64, h: f64| {
        let f = |t: f64, x: &SO3| field::<SO3, 3>(t, x) * h;
        let k1 = f(t, x);
        let k2 = f(t + h / 2.0, &x.rplus(&(k1 * 0.5)));
        let k3 = f(t + h / 2.0, &x.rplus(&(k2 * 0.5 - SO3::bracket(&k1, &k2) * 0.125)));
        let k4 = f(t + h, &x.rplus(&k3));
        x.rplus(&((k1 + (k2 + k3) * 2.0 + k4 - SO3::bracket(&k1, &k4) * 0.5) / 6.0))
    };
    let x = SO3::exp(&(draw(5) * 0.5));
    let truth = Integrator::CommutatorFree4.integrate(&x, 0.2, T, 1 << 14, field::<SO3, 3>);
    let order = measured(&truth, 16, 10, |n| {
        let h = T / f64::from(n);
        (0..n).fold(x, |x, i| wrong(&x, 0.2 + h * f64::from(i), h))
    });
    assert!((order - 2.0).abs() < 0.1, "{order:.3}");
}

fn one_step<G: LieGroup<D, Scalar = f64>, const D: usize>(
    expansion: impl Fn(f64) -> G,
    truth: impl Fn(f64) -> G,
) -> f64 {
    let errors: Vec<_> =
        (0..6).map(|k| 0.4 / f64::from(1 << k)).map(|h| (h, distance(&expansion(h), &truth(h)))).collect();
    slope(&errors)
}

#[test]
fn the_closed_form_for_a_linear_velocity_errs_by_the_fifth_power_and_by_the_third_without_its_bracket() {
    let (omega, alpha) = (draw::<6>(11), draw::<6>(12));
    let truth = |h: f64| {
        Integrator::CommutatorFree4.integrate(&SE3::identity(), 0.0, h, 2048, |t, _| omega + alpha * t)
    };
    let order = one_step(|h| SE3::exp(&magnus_linear::<SE3, 6>(&omega, &alpha, h)), truth);
    assert!((order - 5.0).abs() < 0.15, "{order:.3}");
    let order = one_step(|h| SE3::exp(&(omega * h + alpha * (h * h / 2.0))), truth);
    assert!((order - 3.0).abs() < 0.15, "{order:.3}");
    // Spatial: Ẋ = (ω + αt)^X is the body form of the inverse with −ω, −α.
    let spatial = magnus_linear_spatial::<SE3, 6>(&omega, &alpha, 0.3);
    let mirrored = magnus_linear::<SE3, 6>(&-omega, &-alpha, 0.3);
    same("spatial", &SE3::exp(&spatial), &SE3::exp(&mirrored).inverse(), 4.0 * EPS);
}

#[test]
fn constant_velocity_is_one_exponential_for_every_method() {
    let omega = draw::<9>(13);
    let (x, end) = (SE23::exp(&draw(14)), SE23::exp(&draw(14)).rplus(&(omega * 2.0)));
    for method in Integrator::ALL {
        let reached = method.integrate(&x, 0.0, 2.0, 3, |_, _| omega);
        same("constant", &reached, &end, 64.0 * EPS);
    }
    same("no step", &Integrator::Rkmk4.integrate(&x, 0.0, 2.0, 0, |_, _| omega), &x, 0.0);
}

#[test]
fn single_precision_agrees_with_double() {
    let omega = |t: f64| draw::<3>(15) * t.cos() + draw::<3>(16) * t.sin();
    let double = Integrator::Rkmk4.integrate(&SO3::identity(), 0.0, 1.0, 20, |t, _| omega(t));
    let single = Integrator::Rkmk4
        .integrate(&SO3::<f32>::identity(), 0.0, 1.0, 20, |t, _| omega(f64::from(t)).map(f32::lit));
    close("f32", &single.log().map(f64::from), &double.log(), 1e-5);
}

fn keeps_its_tolerance<G: LieGroup<D, Scalar = f64>, const D: usize>() {
    let x = G::exp(&(draw(5) * 0.5));
    let truth = Integrator::CommutatorFree4.integrate(&x, 0.2, T, 1 << 13, field::<G, D>);
    for method in [Integrator::CrouchGrossman3, Integrator::Rkmk4, Integrator::CommutatorFree4] {
        for tolerance in [1e-5, 1e-9] {
            let end = method.integrate_adaptive(&x, 0.2, T, tolerance, field::<G, D>).unwrap();
            let error = distance(&end.value, &truth);
            // Errors of steps add up, and are carried along by an adjoint.
            assert!(
                error < 20.0 * tolerance * end.steps as f64,
                "{method:?}, {tolerance:e}: {error:.1e}, {end:?}"
            );
            assert!(error > 1e-3 * tolerance, "{method:?} works harder than asked: {error:.1e}, {end:?}");
        }
    }
}

#[test]
fn adaptive_steps_keep_their_tolerance_without_waste() {
    keeps_its_tolerance::<SO3, 3>();
    keeps_its_tolerance::<SE3, 6>();
    keeps_its_tolerance::<SGal3, 10>();
}

#[test]
fn adaptive_integration_can_go_back_in_time_or_nowhere() {
    let x = SE3::exp(&draw(5));
    let method = Integrator::Rkmk4;
    let there = method.integrate_adaptive(&x, 0.2, 2.0, 1e-11, field::<SE3, 6>).unwrap().value;
    let back = method.integrate_adaptive(&there, 2.2, -2.0, 1e-11, field::<SE3, 6>).unwrap();
    same("there and back", &back.value, &x, 1e-8);
    let nowhere = method.integrate_adaptive(&x, 0.2, 0.0, 1e-9, field::<SE3, 6>).unwrap();
    assert_eq!((nowhere.value, nowhere.steps), (x, 0));
}

#[test]
fn adaptive_integration_says_where_no_step_is_short_enough() {
    let x = SO3::identity();
    let pole = |t: f64, _: &SO3| draw::<3>(1) / (1.0 - t);
    let stuck = Integrator::Rkmk4.integrate_adaptive(&x, 0.0, 2.0, 1e-9, pole);
    assert!(
        matches!(stuck, Err(TrajectoryError::StepTooSmall { time }) if (time - 1.0).abs() < 1e-6),
        "{stuck:?}"
    );
    let dead = |t: f64, _: &SO3| draw::<3>(1) * if t > 0.5 { f64::NAN } else { 1.0 };
    let stuck = Integrator::Rkmk4.integrate_adaptive(&x, 0.0, 2.0, 1e-9, dead);
    assert!(
        matches!(stuck, Err(TrajectoryError::StepTooSmall { time }) if (time - 0.5).abs() < 1e-6),
        "{stuck:?}"
    );
    let refused = |t, duration, tolerance| {
        Integrator::Rkmk4.integrate_adaptive(&x, t, duration, tolerance, |_, _| draw::<3>(1)).unwrap_err()
    };
    assert_eq!(refused(f64::NAN, 1.0, 1e-9), TrajectoryError::NotFinite { index: 1 });
    assert_eq!(refused(0.0, f64::INFINITY, 1e-9), TrajectoryError::NotFinite { index: 2 });
    assert_eq!(refused(0.0, 1.0, 0.0), TrajectoryError::NotATolerance { tolerance: 0.0 });
}
