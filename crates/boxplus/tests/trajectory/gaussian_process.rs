use crate::support::*;
use boxplus::lie::{LieGroup, Rn, SE2, SE3, SE23, SGal3, SO2, SO3, Sim3};
use boxplus::trajectory::{
    GaussianProcess, Motion, TrajectoryError, discretise, gp_bridge, gp_covariance, gp_information,
    gp_interpolation, gp_transition,
};
use nalgebra::{Matrix1, Matrix3, SMatrix, SVector, Vector1, matrix};

fn is_the_noise_of_integrators<const R: usize>() {
    // R integrators in a row, driven by unit white noise.
    let a = SMatrix::<f64, R, R>::from_fn(|i, j| f64::from(u8::from(j == i + 1)));
    let l = unit::<R>(R - 1);
    for dt in [0.01, 0.5, 3.0] {
        let (phi, q) = discretise(&a, &l, &Matrix1::new(1.0), dt).unwrap();
        close("Φ", &gp_transition::<f64, R>(dt), &phi, 64.0 * EPS);
        close("Q", &gp_covariance::<f64, R>(dt), &q, 64.0 * EPS);
        // Entries differ in unit and size: each is held to the rounding of its own terms.
        let (inverse, q) = (gp_information::<f64, R>(dt), gp_covariance::<f64, R>(dt));
        let (product, terms) = (inverse * q - SMatrix::identity(), inverse.abs() * q.abs());
        let held = product.zip_map(&terms, |x, size| x.abs() / size);
        assert!(held.amax() < 8.0 * EPS, "Q⁻¹Q = I, Δ = {dt}: {product}");
    }
}

#[test]
fn its_matrices_are_those_of_integrated_white_noise() {
    is_the_noise_of_integrators::<1>();
    is_the_noise_of_integrators::<2>();
    is_the_noise_of_integrators::<3>();
    is_the_noise_of_integrators::<4>();
}

#[test]
fn its_matrices_are_those_printed() {
    // Anderson & Barfoot (2015); Tang et al. (2019) (with Δ = 2).
    let d = 2.0_f64;
    let wnoa = matrix![12.0 / d.powi(3), -6.0 / d.powi(2); -6.0 / d.powi(2), 4.0 / d];
    close("WNOA", &gp_information::<f64, 2>(d), &wnoa, 4.0 * EPS);
    let wnoj = Matrix3::new(
        720.0 / d.powi(5),
        -360.0 / d.powi(4),
        60.0 / d.powi(3),
        -360.0 / d.powi(4),
        192.0 / d.powi(3),
        -36.0 / d.powi(2),
        60.0 / d.powi(3),
        -36.0 / d.powi(2),
        9.0 / d,
    );
    close("WNOJ", &gp_information::<f64, 3>(d), &wnoj, 4.0 * EPS);
}

#[test]
fn the_query_is_the_conditional_mean_of_the_joint_gaussian() {
    // State at 0 known; joint covariance of the states at t and Δ, conditioned on the latter by the general formula.
    let (t, d) = (0.7, 2.0);
    let (lambda, psi) = gp_interpolation::<f64, 3>(d, t);
    let (q_t, q_d) = (gp_covariance::<f64, 3>(t), gp_covariance::<f64, 3>(d));
    let cross = q_t * gp_transition::<f64, 3>(d - t).transpose();
    let gain = cross * q_d.try_inverse().unwrap();
    close("Ψ", &psi, &gain, 1e-12);
    close("Λ", &lambda, &(gp_transition(t) - gain * gp_transition(d)), 1e-12);
    let left = (q_t - gain * q_d * gain.transpose())[(0, 0)];
    assert!((gp_bridge::<f64, 3>(d, t) / left - 1.0).abs() < 1e-10, "{left}");
}

#[test]
fn on_vectors_the_means_are_the_cubic_and_the_quintic_through_both_states() {
    let check = |coefficients: &[f64]| {
        let at = |t: f64, order: usize| {
            let fall = |k: usize| (0..order).fold(1.0, |f, j| f * (k as f64 - j as f64));
            let powers = coefficients.iter().enumerate().skip(order);
            powers.map(|(k, c)| c * fall(k) * t.powi(i32::try_from(k - order).unwrap())).sum::<f64>()
        };
        let state = |t: f64| Motion {
            value: Rn::<1>::new(Vector1::new(at(t, 0))),
            velocity: Vector1::new(at(t, 1)),
            acceleration: Vector1::new(at(t, 2)),
            jerk: Vector1::zeros(),
        };
        let now = if coefficients.len() == 4 {
            GaussianProcess::<_, 1, 2>::new(state(0.0), state(1.5), 1.5).unwrap().at(0.4).unwrap()
        } else {
            GaussianProcess::<_, 1, 3>::new(state(0.0), state(1.5), 1.5).unwrap().at(0.4).unwrap()
        };
        close("value", &now.value.vector(), &state(0.4).value.vector(), 200.0 * EPS);
        close("velocity", &now.velocity, &state(0.4).velocity, 200.0 * EPS);
        close("acceleration", &now.acceleration, &state(0.4).acceleration, 500.0 * EPS);
        close("jerk", &now.jerk, &Vector1::new(at(0.4, 3)), 4000.0 * EPS);
    };
    check(&[1.0, -2.0, 0.5, 0.3]);
    check(&[1.0, -2.0, 0.5, 0.3, -0.7, 0.2]);
}

fn state<G: LieGroup<D, Scalar = f64>, const D: usize>(seed: u64) -> [Motion<G, D>; 2] {
    let values: [G; 2] = walk(seed, 0.5);
    std::array::from_fn(|i| Motion {
        value: values[i],
        velocity: draw::<D>(seed + 40 + i as u64) * 0.5,
        acceleration: draw::<D>(seed + 50 + i as u64) * 0.5,
        jerk: SVector::zeros(),
    })
}

fn meets_both_states<G: LieGroup<D, Scalar = f64>, const D: usize>() {
    for seed in 0..5 {
        let [from, to] = state::<G, D>(seed);
        let wnoa = GaussianProcess::<_, D, 2>::new(from, to, 1.4).unwrap();
        let wnoj = GaussianProcess::<_, D, 3>::new(from, to, 1.4).unwrap();
        for (t, end) in [(0.0, &from), (1.4, &to)] {
            for now in [wnoa.at(t).unwrap(), wnoj.at(t).unwrap()] {
                same("value", &now.value, &end.value, 200.0 * EPS);
                close("velocity", &now.velocity, &end.velocity, 1000.0 * EPS);
            }
            close("acceleration", &wnoj.at(t).unwrap().acceleration, &end.acceleration, 4000.0 * EPS);
        }
        for curve in [&|t| wnoa.at(t).unwrap() as Motion<G, D>, &|t| wnoj.at(t).unwrap()]
            as [&dyn Fn(f64) -> Motion<G, D>; 2]
        {
            let now = curve(0.5);
            close("velocity", &now.velocity, &difference(0.5, |t| curve(t).value.rminus(&now.value)), 1e-10);
            close("acceleration", &now.acceleration, &difference(0.5, |t| curve(t).velocity), 1e-10);
            close("jerk", &now.jerk, &difference(0.5, |t| curve(t).acceleration), 1e-10);
        }
    }
}

#[test]
fn the_mean_meets_both_states_and_its_rates_are_its_derivatives() {
    meets_both_states::<SO2, 1>();
    meets_both_states::<SE2, 3>();
    meets_both_states::<SO3, 3>();
    meets_both_states::<SE3, 6>();
    meets_both_states::<SE23, 9>();
    meets_both_states::<SGal3, 10>();
    meets_both_states::<Sim3, 7>();
}

#[test]
fn what_has_no_unique_way_or_time_is_refused() {
    let at = |a: f64| Motion::at_rest(SO3::exp(&nalgebra::vector![0.0, 0.0, a]));
    let half_turn = GaussianProcess::<_, 3, 2>::new(at(0.0), at(std::f64::consts::PI), 1.0);
    assert_eq!(half_turn, Err(TrajectoryError::Ambiguous { segment: 0 }));
    let backwards = GaussianProcess::<_, 3, 2>::new(at(0.0), at(1.0), -1.0);
    assert_eq!(backwards, Err(TrajectoryError::NotADuration { duration: -1.0 }));
    let lost = |x: Motion<SO3, 3>| Motion { acceleration: SVector::repeat(f64::NAN), ..x };
    let spinning = |x: Motion<SO3, 3>| Motion { velocity: SVector::repeat(f64::INFINITY), ..x };
    let refused = |from, to| GaussianProcess::<_, 3, 2>::new(from, to, 1.0).unwrap_err();
    assert_eq!(refused(spinning(at(0.0)), at(1.0)), TrajectoryError::NotFinite { index: 0 });
    assert_eq!(refused(at(0.0), spinning(at(1.0))), TrajectoryError::NotFinite { index: 1 });
    // White noise on acceleration does not read accelerations; on jerk it does.
    assert!(GaussianProcess::<_, 3, 2>::new(lost(at(0.0)), lost(at(1.0)), 1.0).is_ok());
    let refused = GaussianProcess::<_, 3, 3>::new(at(0.0), lost(at(1.0)), 1.0);
    assert_eq!(refused, Err(TrajectoryError::NotFinite { index: 1 }));
    let late = GaussianProcess::<_, 3, 2>::new(at(0.0), at(1.0), 1.0).unwrap().at(1.1);
    assert_eq!(late, Err(TrajectoryError::OutOfRange { time: 1.1, start: 0.0, end: 1.0 }));
}

#[cfg(feature = "autodiff")]
mod dual {
    use super::*;

    const BOUND: f64 = 4000.0 * EPS;

    /// The state with one of its arguments unknown (0: X, 1: ω, 2: ω̇; none beyond), as dual numbers.
    fn dual<G: LieGroup<D, Scalar = f64>, const D: usize>(
        state: &Motion<G, D>,
        unknown_part: usize,
    ) -> Motion<Over<G, D, D>, D> {
        let value = if unknown_part == 0 { moved(&state.value) } else { lift::<G, D, D>(&state.value) };
        let part = |i: usize, v: &SVector<f64, D>| if unknown_part == i { unknown(v) } else { constant(v) };
        let mut motion = Motion::steady(value, part(1, &state.velocity));
        motion.acceleration = part(2, &state.acceleration);
        motion
    }

    fn answers_as_its_jacobians_say<G: LieGroup<D, Scalar = f64>, const D: usize, const R: usize>() {
        for seed in 0..4 {
            let [from, mut to] = state::<G, D>(seed);
            if seed == 3 {
                // Nearly half a turn, where the series are longest.
                let way = to.value.rminus(&from.value);
                to.value = from.value.rplus(&(way * (3.1 / way.norm())));
            }
            let closed = GaussianProcess::<_, D, R>::new(from, to, 1.4).unwrap();
            let (error, d_error) = closed.error_jac();
            assert_eq!(error, closed.error());
            let (now, d_now) = closed.at_jac(0.6).unwrap();
            for (end, argument) in (0..2).flat_map(|end| (0..R).map(move |argument| (end, argument))) {
                let part = |this: usize| if end == this { argument } else { 3 };
                let (from, to) = (dual(&from, part(0)), dual(&to, part(1)));
                let moved =
                    GaussianProcess::<Over<G, D, D>, D, R>::new(from, to, Dual::from_re(1.4)).unwrap();
                for (block, e) in moved.error().iter().enumerate() {
                    close("error", &d_error[end][argument][block], &derivatives(e), BOUND);
                }
                let (y, d) = (moved.at(Dual::from_re(0.6)).unwrap(), &d_now[end][argument]);
                close("value", &d.value, &local(&y.value, &now.value), BOUND);
                close("velocity", &d.velocity, &derivatives(&y.velocity), BOUND);
            }
        }
    }

    #[test]
    fn errors_and_queries_have_the_derivatives_of_dual_numbers() {
        answers_as_its_jacobians_say::<SO2, 1, 2>();
        answers_as_its_jacobians_say::<SE2, 3, 2>();
        answers_as_its_jacobians_say::<SO3, 3, 2>();
        answers_as_its_jacobians_say::<SO3, 3, 3>();
        answers_as_its_jacobians_say::<SE3, 6, 2>();
        answers_as_its_jacobians_say::<SE3, 6, 3>();
        answers_as_its_jacobians_say::<SE23, 9, 2>();
        answers_as_its_jacobians_say::<SGal3, 10, 2>();
        answers_as_its_jacobians_say::<Sim3, 7, 3>();
    }
}
