use crate::support::*;
use boxplus::lie::{LieGroup, Rn, SE2, SE3, SE23, SGal3, SO2, SO3, Sim3, Tangent};
use boxplus::trajectory::{BSpline, Bezier, TrajectoryError};
use nalgebra::{SVector, Vector2, Vector3};

/// The uniform B-spline basis of order k by Cox and de Boor's recursion, which shares nothing with the matrix form.
fn basis(k: usize, x: f64) -> f64 {
    if k == 1 {
        return f64::from(u8::from((0.0..1.0).contains(&x)));
    }
    let d = (k - 1) as f64;
    x / d * basis(k - 1, x) + (k as f64 - x) / d * basis(k - 1, x - 1.0)
}

fn equals_the_euclidean_spline<const K: usize>() {
    let controls: [Rn<2>; 12] = std::array::from_fn(|i| Rn::new(draw::<2>(i as u64)));
    let spline = BSpline::<_, 2, K>::new(&controls, 0.0, 1.0).unwrap();
    for n in 0..100 {
        let t = 0.001 + f64::from(n) * 0.01 * (spline.end() - 0.002);
        let mut sum = Vector2::zeros();
        for (i, control) in controls.iter().enumerate() {
            // Control i acts on [i − K + 1, i + 1).
            sum += control.vector() * basis(K, t - i as f64 + K as f64 - 1.0);
        }
        close("value", &spline.at(t).unwrap().value.vector(), &sum, 64.0 * EPS);
    }
}

#[test]
fn on_vectors_it_is_the_classical_b_spline_of_every_order() {
    equals_the_euclidean_spline::<1>();
    equals_the_euclidean_spline::<2>();
    equals_the_euclidean_spline::<3>();
    equals_the_euclidean_spline::<4>();
    equals_the_euclidean_spline::<5>();
    equals_the_euclidean_spline::<6>();
    equals_the_euclidean_spline::<8>();
}

#[test]
fn its_weights_are_those_printed_for_the_cubic() {
    // Sommer et al. (2020): 6·M̃ = [6 0 0 0; 5 3 −3 1; 1 3 3 −2; 0 0 0 1], read off one unit step after the other.
    let printed = [[6.0, 0.0, 0.0, 0.0], [5.0, 3.0, -3.0, 1.0], [1.0, 3.0, 3.0, -2.0], [0.0, 0.0, 0.0, 1.0]];
    for (j, row) in printed.iter().enumerate() {
        let controls: [Rn<1>; 4] =
            std::array::from_fn(|i| Rn::new(SVector::from([f64::from(u8::from(i >= j))])));
        let now = BSpline::<_, 1, 4>::new(&controls, 0.0, 1.0).unwrap().at(0.3).unwrap();
        let [a, b, c, d] = row.map(|x| x / 6.0);
        let u = 0.3;
        assert!((now.value.vector()[0] - (a + u * (b + u * (c + u * d)))).abs() < 4.0 * EPS);
        assert!((now.velocity[0] - (b + u * (2.0 * c + 3.0 * u * d))).abs() < 4.0 * EPS);
        assert!((now.acceleration[0] - (2.0 * c + 6.0 * u * d)).abs() < 8.0 * EPS);
        assert!((now.jerk[0] - 6.0 * d).abs() < 8.0 * EPS);
    }
}

fn keeps_a_constant_velocity<G: LieGroup<D, Scalar = f64>, const D: usize, const K: usize>() {
    let step = draw::<D>(3) * 0.8;
    let controls: [G; 10] = std::array::from_fn(|i| G::exp(&(step * (i as f64 - 4.0) * 0.3)));
    let spline = BSpline::<_, D, K>::new(&controls, 10.0, 0.3).unwrap();
    for n in 0..=20 {
        let t = (10.0 + f64::from(n) / 20.0 * (spline.end() - 10.0)).min(spline.end());
        let now = spline.at(t).unwrap();
        // λ₁ + … + λ_{K−1} = u + (K − 2)/2: the time at which the curve is at control element 0 is −(K − 2)/2.
        let phase = (t - 10.0) / 0.3 + (K as f64 - 2.0) / 2.0 - 4.0;
        same("value", &now.value, &G::exp(&(step * phase * 0.3)), 200.0 * EPS);
        close("velocity", &now.velocity, &step, 400.0 * EPS);
        close("acceleration", &now.acceleration, &SVector::zeros(), 1e-11);
    }
}

#[test]
fn it_reproduces_a_motion_of_constant_velocity() {
    keeps_a_constant_velocity::<SO2, 1, 4>();
    keeps_a_constant_velocity::<SE2, 3, 3>();
    keeps_a_constant_velocity::<SO3, 3, 5>();
    keeps_a_constant_velocity::<SE3, 6, 4>();
    keeps_a_constant_velocity::<SE23, 9, 6>();
    keeps_a_constant_velocity::<SGal3, 10, 4>();
    keeps_a_constant_velocity::<Sim3, 7, 4>();
}

fn is_smooth<const K: usize>() {
    let controls: [SE3; 9] = walk(7, 0.6);
    let spline = BSpline::<_, 6, K>::new(&controls, 0.0, 0.5).unwrap();
    let delta = 1e-9;
    for knot in 1..9 - K {
        let t = 0.5 * knot as f64;
        let (before, after) = (spline.at(t - delta).unwrap(), spline.at(t + delta).unwrap());
        let gaps = [
            distance(&before.value, &after.value),
            (before.velocity - after.velocity).amax(),
            (before.acceleration - after.acceleration).amax(),
            (before.jerk - after.jerk).amax(),
        ];
        for (order, gap) in gaps.iter().enumerate().take(K) {
            // Continuous up to derivative K − 2; the next one jumps.
            let continuous = order + 2 <= K;
            assert_eq!(
                *gap < 1e-5,
                continuous,
                "order {K}, derivative {order} at knot {knot}: gap {gap:.1e}"
            );
        }
    }
}

#[test]
fn across_knots_it_has_k_minus_two_derivatives_and_no_more() {
    is_smooth::<2>();
    is_smooth::<3>();
    is_smooth::<4>();
    is_smooth::<5>();
}

#[test]
fn a_control_element_acts_on_k_intervals_only() {
    let controls: [SE3; 10] = walk(11, 0.5);
    let mut other = controls;
    other[5] = other[5].rplus(&(draw::<6>(1) * 0.1));
    let (a, b) = (
        BSpline::<_, 6, 4>::new(&controls, 0.0, 1.0).unwrap(),
        BSpline::<_, 6, 4>::new(&other, 0.0, 1.0).unwrap(),
    );
    for n in 0..70 {
        let t = f64::from(n) / 10.0 + 0.05;
        let moved = a.at(t).unwrap() != b.at(t).unwrap();
        // Control 5 acts on intervals 2 to 5.
        assert_eq!(moved, (2.0..6.0).contains(&t), "at {t}");
    }
}

#[test]
fn moving_all_control_elements_from_the_left_moves_the_curve() {
    let controls: [SE3; 6] = walk(13, 0.5);
    let by = SE3::exp(&draw(5));
    let moved = controls.map(|x| by * x);
    let a = BSpline::<_, 6, 4>::new(&controls, 0.0, 1.0).unwrap().at(1.3).unwrap();
    let b = BSpline::<_, 6, 4>::new(&moved, 0.0, 1.0).unwrap().at(1.3).unwrap();
    same("value", &b.value, &(by * a.value), 32.0 * EPS);
    close("velocity", &b.velocity, &a.velocity, 32.0 * EPS);
}

#[test]
fn repeated_outer_elements_start_the_curve_there_at_rest() {
    let x: [SE2; 3] = walk(17, 0.5);
    let controls = [x[0], x[0], x[0], x[1], x[2]];
    let now = BSpline::<_, 3, 4>::new(&controls, 0.0, 1.0).unwrap().at(0.0).unwrap();
    same("start", &now.value, &x[0], 4.0 * EPS);
    assert_eq!(now.velocity, Vector3::zeros());
}

#[test]
fn outside_and_from_bad_elements_there_is_an_error_and_no_value() {
    let controls: [SO3; 5] = walk(19, 0.4);
    let spline = BSpline::<_, 3, 4>::new(&controls, 2.0, 0.5).unwrap();
    assert_eq!(spline.end(), 3.0);
    for time in [1.999, 3.001] {
        assert_eq!(spline.at(time), Err(TrajectoryError::OutOfRange { time, start: 2.0, end: 3.0 }));
    }
    assert!(matches!(spline.at(f64::NAN), Err(TrajectoryError::OutOfRange { .. })));
    let few = BSpline::<_, 3, 4>::new(&controls[..3], 0.0, 1.0);
    assert_eq!(few, Err(TrajectoryError::TooFew { got: 3, needed: 4 }));
    for duration in [0.0, -1.0, f64::INFINITY] {
        let refused = BSpline::<_, 3, 4>::new(&controls, 0.0, duration);
        assert_eq!(refused, Err(TrajectoryError::NotADuration { duration }));
    }
    let mut half_turn = controls;
    half_turn[3] = half_turn[2].rplus(&Vector3::new(0.0, std::f64::consts::PI, 0.0));
    let refused = BSpline::<_, 3, 4>::new(&half_turn, 0.0, 1.0);
    assert_eq!(refused, Err(TrajectoryError::Ambiguous { segment: 2 }));
}

#[test]
fn half_a_turn_is_refused_and_a_little_less_is_not_on_every_group() {
    fn check<G: LieGroup<D, Scalar = f64>, const D: usize>(angle: usize) {
        let away = |theta: f64| {
            let mut tau = draw::<D>(9) * 3.0;
            if D >= 6 {
                tau.fixed_rows_mut::<3>(3).normalize_mut();
                tau.fixed_rows_mut::<3>(3).scale_mut(theta);
            } else {
                tau[angle] = theta;
            }
            let start = G::exp(&draw(8));
            Bezier::new([start, start.rplus(&tau)])
        };
        assert!(away(std::f64::consts::PI - 1e-6).is_ok());
        assert_eq!(away(std::f64::consts::PI), Err(TrajectoryError::Ambiguous { segment: 0 }));
        assert!(away(std::f64::consts::PI + 1e-6).is_ok(), "the other way is shorter");
        assert_eq!(away(f64::NAN), Err(TrajectoryError::NotFinite { index: 1 }));
        let (good, bad) = (G::identity(), G::exp(&Tangent::repeat(f64::NAN)));
        assert_eq!(Bezier::new([bad, good]), Err(TrajectoryError::NotFinite { index: 0 }));
        assert_eq!(Bezier::new([good, good, bad]), Err(TrajectoryError::NotFinite { index: 2 }));
        assert_eq!(Bezier::new([bad]), Err(TrajectoryError::NotFinite { index: 0 }));
    }
    check::<SO2, 1>(0);
    check::<SE2, 3>(2);
    check::<SE3, 6>(0);
    check::<SE23, 9>(0);
    check::<SGal3, 10>(0);
    check::<Sim3, 7>(0);
}

#[test]
fn single_precision_agrees_with_double() {
    let controls: [SE3; 6] = walk(23, 0.5);
    let single = controls.map(|x| LieGroup::map(&x, |a| a as f32));
    let a = BSpline::<_, 6, 4>::new(&controls, 0.0, 0.5).unwrap().at(0.7).unwrap();
    let b = BSpline::<_, 6, 4>::new(&single, 0.0, 0.5).unwrap().at(0.7).unwrap();
    let near = |x: &Tangent<f64, 6>, y: &Tangent<f32, 6>| close("f32", &y.map(f64::from), x, 1e-5);
    near(&a.value.log(), &b.value.log());
    near(&a.velocity, &b.velocity);
    near(&a.acceleration, &b.acceleration);
}

#[cfg(feature = "autodiff")]
mod dual {
    use super::*;

    fn answers_as_its_jacobians_say<G: LieGroup<D, Scalar = f64>, const D: usize, const K: usize>() {
        for (seed, size) in [(1, 0.7), (2, 0.2), (3, 1e-7), (4, 0.0)] {
            let controls: [G; 8] = walk(seed, size);
            let spline = BSpline::<_, D, K>::new(&controls, 1.0, 0.4).unwrap();
            for place in [0.0, 0.31, 0.77, 1.0] {
                let t = 1.0 + place * (spline.end() - 1.0);
                let (motion, first, jacobians) = spline.at_jac(t).unwrap();
                let again = spline.at(t).unwrap();
                same("value", &again.value, &motion.value, 0.0);
                close("velocity", &again.velocity, &motion.velocity, 4.0 * EPS);
                close("acceleration", &again.acceleration, &motion.acceleration, 4.0 * EPS);
                for (j, closed) in jacobians.iter().enumerate() {
                    let mut dual = controls.map(|x| lift::<G, D, D>(&x));
                    dual[first + j] = moved(&controls[first + j]);
                    let at = |x: f64| Dual::<D>::from_re(x);
                    let spline = BSpline::<_, D, K>::new(&dual, at(1.0), at(0.4)).unwrap();
                    answers("control", &spline.at(at(t)).unwrap(), &motion.value, closed, 2000.0 * EPS);
                }
                let dual = controls.map(|x| lift::<G, D, 1>(&x));
                let at = |x: f64| Dual::<1>::from_re(x);
                let spline = BSpline::<_, D, K>::new(&dual, at(1.0), at(0.4)).unwrap();
                rates(&spline.at(at(t).derivative(0)).unwrap(), &motion, 2000.0 * EPS);
            }
        }
    }

    #[test]
    fn every_derivative_is_that_of_dual_numbers() {
        answers_as_its_jacobians_say::<SO2, 1, 4>();
        answers_as_its_jacobians_say::<SO3, 3, 2>();
        answers_as_its_jacobians_say::<SO3, 3, 4>();
        answers_as_its_jacobians_say::<SE2, 3, 5>();
        answers_as_its_jacobians_say::<SE3, 6, 4>();
        answers_as_its_jacobians_say::<SE3, 6, 6>();
        answers_as_its_jacobians_say::<SE23, 9, 4>();
        answers_as_its_jacobians_say::<SGal3, 10, 3>();
        answers_as_its_jacobians_say::<Sim3, 7, 4>();
        answers_as_its_jacobians_say::<Rn<3>, 3, 4>();
    }
}
