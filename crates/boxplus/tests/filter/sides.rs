//! What theory says of the side of the error.

use boxplus::filter::{
    DeadReckoning, Ekf, Filter, Imu, ImuNoise, Motion, Odometry, PositionFix, Sighting, Ukf,
};
use boxplus::lie::{Action, LieGroup, SE2, SE23};
use boxplus::uncertainty::{Covariance, Gaussian, Global, Local};
use nalgebra::{SMatrix, SVector, Vector3, vector};

fn start() -> Gaussian<SE2, 3> {
    let l = SMatrix::<f64, 3, 3>::from_fn(|i, j| 0.1 * ((i * i + 3 * i * j + j + 1) as f64).sin());
    Gaussian::new(SE2::new(vector![3.0, -2.0], 0.7), Covariance::new(l * l.transpose()).unwrap())
}

fn odometry() -> Odometry<3> {
    Odometry { noise: Covariance::from_sigmas(&vector![0.03, 0.01, 0.02]).unwrap() }
}

fn beacon() -> Sighting<2> {
    Sighting {
        landmark: vector![5.0, 1.0],
        measured: SE2::new(vector![3.0, -2.0], 0.7).act_inverse(&vector![5.0, 1.0]) + vector![0.1, -0.2],
        noise: Covariance::from_sigmas(&vector![0.1, 0.2]).unwrap(),
    }
}

#[test]
fn predictions_are_the_same_on_both_sides() {
    // F and G are exact derivatives, and Ad between the sides is exact.
    let step = vector![0.5, 0.1, 0.4];
    let local = Ekf::default().predict(&start(), &odometry(), &step).unwrap();
    let global = Ekf::default().predict(&start().to_global(), &odometry(), &step).unwrap();
    assert!((global.to_local().covariance().matrix() - local.covariance().matrix()).amax() < 1e-15);
}

#[test]
fn one_correction_differs_between_the_sides_by_what_its_reset_neglects() {
    // The correction Exp(δ) of one side is Exp(Ad δ) of the other, the same element; J_r(δ) and J_l(Ad δ) agree through Ad.
    let local = Ekf::default().update(&start(), &beacon());
    let global = Ekf::default().update(&start().to_global(), &beacon());
    assert!(global.belief.mean().rminus(local.belief.mean()).norm() < 1e-14);
    let difference = global.belief.to_local().covariance().matrix() - local.belief.covariance().matrix();
    assert!(difference.amax() < 1e-15, "with the reset a correction does not know its side");
    let nis = [local.innovation().unwrap().nis, global.innovation().unwrap().nis];
    assert!((nis[0] - nis[1]).abs() < 1e-13 * nis[0]);

    // Without it, it does: each side then claims its old covariance about a new mean.
    let bare = Ekf { reset: false, ..Ekf::default() };
    let local = bare.update(&start(), &beacon()).belief;
    let global = bare.update(&start().to_global(), &beacon()).belief;
    let difference = global.to_local().covariance().matrix() - local.covariance().matrix();
    assert!(difference.amax() > 1e-5, "{:e}", difference.amax());
}

#[test]
fn an_iterated_update_is_the_maximum_of_the_posterior() {
    // ... which the side of the prior decides, because N(0, P) does; the gradient of the cost vanishes there.
    fn check<E: boxplus::uncertainty::Side>(prior: &Gaussian<SE2, 3, E>) {
        let after = Ekf { tolerance: 1e-12, ..Ekf::iterated() }.update(prior, &beacon()).belief;
        let cost = |x: &SE2| {
            let z = beacon().measured - x.act_inverse(&beacon().landmark);
            prior.mahalanobis_squared(x).unwrap() + beacon().noise.mahalanobis_squared(&z).unwrap()
        };
        for k in 0..3 {
            let mut h = Vector3::zeros();
            h[k] = 1e-5;
            let slope = (cost(&after.perturbed(&h)) - cost(&after.perturbed(&-h))) / 2e-5;
            assert!(slope.abs() < 1e-5, "{slope:e}");
        }
    }
    check(&start());
    check(&start().to_global());
}

fn imu(k: usize) -> Imu {
    let t = 0.3 * k as f64;
    Imu {
        gyroscope: vector![t.sin(), 0.5 * t.cos(), 0.8],
        accelerometer: vector![3.0 * t.cos(), t.sin(), 9.0],
        duration: 0.05,
    }
}

#[test]
fn inertial_errors_of_any_size_obey_a_linear_equation() {
    // Log-linearity, Barrau & Bonnabel (2017): the error of a metre and a radian goes through the matrix that the filter uses
    // for small ones, exactly; and the global matrix does not know the state.
    let model = DeadReckoning::upright(ImuNoise::default());
    let still = SVector::zeros();
    let xi = SVector::<f64, 9>::from_fn(|i, _| 0.7 * (1.0 + i as f64).sin());
    let (mut truth, mut estimate) = (SE23::exp(&xi), SE23::identity());
    let (mut local, mut global) = (truth.rminus(&estimate), truth.lminus(&estimate));
    for k in 0..100 {
        let f = model.step_jac(&estimate, &imu(k)).1;
        let f_left = model.step_left_jac(&estimate, &imu(k)).1;
        assert_eq!(f_left, model.step_left_jac(&truth, &imu(k)).1);
        truth = model.step(&truth, &imu(k), &still);
        estimate = model.step(&estimate, &imu(k), &still);
        (local, global) = (f * local, f_left * global);
    }
    // Compared as elements: the logarithm has turned over by then.
    assert!(estimate.rplus(&local).rminus(&truth).norm() < 1e-11);
    assert!(estimate.lplus(&global).rminus(&truth).norm() < 1e-11);
    assert!(truth.rminus(&estimate).norm() > 1.0);
}

#[test]
fn an_unscented_prediction_of_a_group_affine_motion_is_exact_at_any_spread() {
    // Without noise, errors move linearly, so that sigma points far and near give FPFᵀ alike.
    let model = DeadReckoning::upright(ImuNoise::default());
    let start = Gaussian::<SE23, 9, Global>::from_sigmas(SE23::identity(), &SVector::repeat(0.3)).unwrap();
    let ekf = Ekf::default().predict(&start, &model, &imu(1)).unwrap();
    for alpha in [0.1, 0.5, 1.0] {
        let ukf = Ukf { alpha, ..Ukf::default() }.predict(&start, &model, &imu(1)).unwrap();
        assert!((ukf.covariance().matrix() - ekf.covariance().matrix()).amax() < 1e-13);
    }
}

#[test]
fn innovations_in_the_frame_of_the_body_change_nothing() {
    // The left-invariant innovation R̂ᵀ(y − p̂) with noise R̂ᵀNR̂ is our y − p̂ with N, turned: gain times innovation is the same.
    let prior = start();
    let noise = Covariance::from_sigmas(&vector![0.1, 0.3]).unwrap();
    let fix = PositionFix::of_origin(vector![3.3, -1.8], noise);
    let update = Ekf::default().update(&prior, &fix);
    let r = prior.mean().rotation().to_matrix();
    let z = r.transpose() * (fix.measured - prior.mean().translation());
    let h = SMatrix::<f64, 2, 3>::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
    let p = prior.covariance().matrix();
    let s = h * p * h.transpose() + r.transpose() * noise.matrix() * r;
    let delta = p * h.transpose() * s.try_inverse().unwrap() * z;
    assert!(update.belief.mean().rminus(&prior.mean().rplus(&delta)).norm() < 1e-14);
}

#[test]
fn sides_are_no_matter_to_the_unscented_filter_in_the_small() {
    let tight = Gaussian::<SE2, 3, Local>::from_sigmas(*start().mean(), &vector![1e-4, 2e-4, 1e-4]).unwrap();
    let local = Ukf::default().update(&tight, &beacon()).belief;
    let global = Ukf::default().update(&tight.to_global(), &beacon()).belief;
    let ekf = Ekf::default().update(&tight, &beacon()).belief;
    assert!(global.mean().rminus(local.mean()).norm() < 1e-8);
    assert!(ekf.mean().rminus(local.mean()).norm() < 1e-8);
    let scale = local.covariance().matrix().amax();
    assert!((global.to_local().covariance().matrix() - ekf.covariance().matrix()).amax() < 1e-3 * scale);
}
