//! Several estimates of one element.

use crate::monte_carlo::Normal;
use boxplus::lie::{LieGroup, Rn, SE2, SE3, SO3};
use boxplus::uncertainty::{Covariance, Criterion, FuseOptions, Gaussian, Global, UncertaintyError};
use nalgebra::{SVector, Vector3, Vector6, matrix, vector};
use std::f64::consts::PI;

fn estimate(k: usize) -> Gaussian<SE3, 6> {
    let tau = Vector6::from_fn(|i, _| 0.5 * ((2 * i) as f64).sin() + 0.2 * ((3 * i + 7 * k) as f64).cos());
    let l = nalgebra::Matrix6::from_fn(|i, j| {
        0.1 * ((i + 3 * j * i + j + k) as f64).cos() + f64::from(u8::from(i == j))
    });
    Gaussian::new(SE3::exp(&tau), Covariance::new(l * l.transpose() * 0.02).unwrap())
}

#[test]
fn vectors_fuse_by_adding_their_information() {
    let x = Gaussian::<Rn<2>, 2>::new(
        Rn::new(vector![1.0, 2.0]),
        Covariance::new(matrix![2.0, 0.5; 0.5, 1.0]).unwrap(),
    );
    let y =
        Gaussian::new(Rn::new(vector![2.0, 0.0]), Covariance::new(matrix![1.0, -0.3; -0.3, 3.0]).unwrap());
    let fused = Gaussian::fuse([&x, &y]).unwrap();
    let [a, b] = [x, y].map(|g| g.covariance().information().unwrap());
    let covariance = (a + b).try_inverse().unwrap();
    let mean = covariance * (a * x.mean().vector() + b * y.mean().vector());
    assert!((fused.estimate.covariance().matrix() - covariance).amax() < 1e-15);
    assert!((fused.estimate.mean().vector() - mean).amax() < 1e-15);
    assert!(fused.converged && fused.iterations <= 2);
}

#[test]
fn neither_order_nor_side_nor_start_changes_the_result() {
    let [x, y, z] = [1, 2, 3].map(estimate);
    let fused = Gaussian::fuse([&x, &y, &z]).unwrap();
    let turned = Gaussian::fuse([&z, &x, &y]).unwrap();
    let global = Gaussian::fuse(&[x, y, z].map(|g| g.to_global())).unwrap();
    for other in [turned.estimate, global.estimate.to_local()] {
        assert!(other.mean().rminus(fused.estimate.mean()).norm() < 1e-9);
        assert!((other.covariance().matrix() - fused.estimate.covariance().matrix()).amax() < 1e-10);
    }
    assert!((turned.cost - fused.cost).abs() < 1e-12);
    // A stationary point of the cost: its gradient by differences is 0.
    let cost = |g: &SE3| [x, y, z].iter().map(|k| 0.5 * k.mahalanobis_squared(g).unwrap()).sum::<f64>();
    for i in 0..6 {
        let step = SVector::<f64, 6>::from_fn(|j, _| if i == j { 1e-4 } else { 0.0 });
        let mean = fused.estimate.mean();
        let slope = (cost(&mean.rplus(&step)) - cost(&mean.rplus(&-step))) / 2e-4;
        assert!(slope.abs() < 1e-5, "{slope}");
    }
}

#[test]
fn a_fused_estimate_is_as_good_as_it_says() {
    // The error of the fused mean over many trials has the covariance that fusion states: NEES has mean D.
    let truth = SE3::exp(&Vector6::new(1.0, 0.5, -0.3, 0.4, -0.2, 0.6));
    let mut normal = Normal::new(41);
    let (trials, mut sum, mut square) = (4000, 0.0, 0.0);
    for _ in 0..trials {
        let given = [1, 2, 3].map(|k| {
            let noise = *estimate(k).covariance() * 0.3;
            Gaussian::<SE3, 6>::new(truth.rplus(&(noise.factor() * normal.vector())), noise)
        });
        let fused = Gaussian::fuse(&given).unwrap();
        assert!(fused.converged);
        let nees = fused.estimate.mahalanobis_squared(&truth).unwrap();
        sum += nees;
        square += nees * nees;
    }
    let mean = sum / f64::from(trials);
    let error = ((square / f64::from(trials) - mean * mean) / f64::from(trials)).sqrt();
    assert!((mean - 6.0).abs() < 4.0 * error, "{mean} ± {error}");
}

#[test]
fn the_fusion_of_barfoot_and_furgale_has_its_published_cost_and_error() {
    let truth = SE3::exp(&Vector6::new(1.0, 0.0, 0.0, 0.0, 0.0, PI / 6.0));
    let noise =
        [[2.0, 1.0, 1.0, 0.1, 0.2, 0.1], [1.0, 3.0, 1.0, 0.1, 0.1, 0.2], [1.0, 1.0, 5.0, 0.2, 0.1, 0.1]]
            .map(|v| Covariance::from_sigmas(&Vector6::from(v).map(|x: f64| (5.0 * x).sqrt())).unwrap());
    let mut normal = Normal::new(42);
    // Residuals are so large here (a radian) that Gauss–Newton converges linearly.
    let options = FuseOptions { max_iterations: 20, tolerance: 1e-3 };
    let (trials, mut cost, mut square, mut converged) = (3000, 0.0, 0.0, 0);
    for _ in 0..trials {
        let given = noise.map(|sigma| {
            Gaussian::<SE3, 6, Global>::new(truth.lplus(&(sigma.factor() * normal.vector())), sigma)
        });
        let fused = Gaussian::fuse_from(&SE3::identity(), &given, &options).unwrap();
        converged += i32::from(fused.converged);
        cost += fused.cost;
        square += truth.lminus(fused.estimate.mean()).norm_squared();
    }
    let n = f64::from(trials);
    let (cost, rms, converged) = (cost / n, (square / n).sqrt(), f64::from(converged) / n);
    println!("cost {cost:.3}, rms {rms:.3}, converged {converged:.3}");
    // The published standard errors, 0.017 and 0.008 of 20 000 trials, beside ours of fewer.
    let scale = (1.0 + 20_000.0 / n).sqrt();
    assert!((cost - 5.782).abs() < 3.0 * 0.017 * scale);
    assert!((rms - 2.720).abs() < 3.0 * 0.008 * scale);
    assert!(converged > 0.99);
}

#[test]
fn estimates_half_a_turn_apart_still_find_a_minimum() {
    let at = |angle: f64| {
        Gaussian::<SO3, 3>::from_sigmas(
            SO3::exp(&Vector3::new(0.0, 0.0, angle)),
            &Vector3::new(0.1, 0.2, 0.3),
        )
        .unwrap()
    };
    let fused = Gaussian::fuse([&at(0.0), &at(3.1), &at(1.5)]).unwrap();
    assert!(fused.converged, "{fused:?}");
}

#[test]
fn intersection_is_consistent_whatever_the_correlation() {
    let [x, y] = [1, 2].map(estimate);
    for criterion in [Criterion::Determinant, Criterion::Trace] {
        let met = x.intersect(&y, criterion).unwrap();
        assert!(met.weight > 0.0 && met.weight < 1.0);
        let size = |g: &Gaussian<SE3, 6>| match criterion {
            Criterion::Determinant => g.covariance().log_determinant().unwrap(),
            Criterion::Trace => g.covariance().matrix().trace(),
        };
        assert!(size(&met.estimate) <= size(&x).min(size(&y)), "no worse than the better of the two");
        let both = Gaussian::fuse([&x, &y]).unwrap();
        assert!(size(&met.estimate) >= size(&both.estimate), "and no better than independence allows");
        // A neighbouring weight is no better.
        for weight in [met.weight - 0.01, met.weight + 0.01] {
            let scaled = |g: &Gaussian<SE3, 6>, w: f64| {
                Gaussian::<SE3, 6>::new(*g.mean(), *g.covariance() * w.recip().sqrt())
            };
            let other = Gaussian::fuse([&scaled(&x, weight), &scaled(&y, 1.0 - weight)]).unwrap();
            assert!(size(&other.estimate) > size(&met.estimate));
        }
        // The same estimate twice is itself, not twice as sure.
        let same = x.intersect(&x, criterion).unwrap().estimate;
        assert!((same.covariance().matrix() - x.covariance().matrix()).amax() < 1e-12);
    }
    // Vectors with errors of correlation ρ: the stated covariance bounds the true one for every ρ.
    let x = Gaussian::<Rn<2>, 2>::from_sigmas(Rn::new(vector![0.0, 0.0]), &vector![1.0, 3.0]).unwrap();
    let y = Gaussian::<Rn<2>, 2>::from_sigmas(Rn::new(vector![0.0, 0.0]), &vector![2.0, 1.0]).unwrap();
    let met = x.intersect(&y, Criterion::Determinant).unwrap();
    let stated = *met.estimate.covariance().matrix();
    let [kx, ky] = [(x, met.weight), (y, 1.0 - met.weight)]
        .map(|(g, w)| stated * g.covariance().information().unwrap() * w);
    for rho in [-0.99, -0.5, 0.0, 0.5, 0.99] {
        let cross = x.covariance().factor() * y.covariance().factor().transpose() * rho;
        let both = kx * cross * ky.transpose();
        let truth = kx * x.covariance().matrix() * kx.transpose()
            + ky * y.covariance().matrix() * ky.transpose()
            + both
            + both.transpose();
        assert!(Covariance::new(stated - truth).is_ok(), "{rho}");
    }
    assert!(Covariance::new(stated * 0.6 - kx * x.covariance().matrix() * kx.transpose()).is_ok());
}

#[test]
fn an_end_of_the_interval_is_found() {
    // One estimate better in every direction: nothing of the other helps.
    let better = Gaussian::<SE2, 3>::from_sigmas(SE2::identity(), &vector![0.1, 0.1, 0.1]).unwrap();
    let worse = Gaussian::<SE2, 3>::from_sigmas(SE2::identity(), &vector![1.0, 1.0, 1.0]).unwrap();
    assert_eq!(better.intersect(&worse, Criterion::Determinant).unwrap().weight, 1.0);
    assert_eq!(worse.intersect(&better, Criterion::Trace).unwrap().weight, 0.0);
}

#[test]
fn impossible_fusions_say_why() {
    let none: [&Gaussian<SE2, 3>; 0] = [];
    assert_eq!(Gaussian::fuse(none).unwrap_err(), UncertaintyError::TooFew { given: 0, needed: 1 });
    let rail = Gaussian::<SE2, 3>::from_sigmas(SE2::identity(), &vector![0.1, 0.0, 0.1]).unwrap();
    let refused = Gaussian::fuse([&rail, &rail]).unwrap_err();
    assert_eq!(refused.to_string(), "the covariance is singular: nothing is uncertain along 1.00·τ[1]");
}
