//! Densities, distances and divergences.

use crate::monte_carlo::Normal;
use boxplus::lie::{LieGroup, Rn, SE3, SO3};
use boxplus::uncertainty::{Covariance, Gaussian, Global, UncertaintyError};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3, Vector6, matrix, vector};
use std::f64::consts::{PI, TAU};

/// Mean and standard error of a function of draws.
fn average(runs: usize, seed: u64, mut f: impl FnMut(&mut Normal) -> f64) -> (f64, f64) {
    let mut normal = Normal::new(seed);
    let (mut sum, mut square) = (0.0, 0.0);
    for _ in 0..runs {
        let x = f(&mut normal);
        sum += x;
        square += x * x;
    }
    let (n, mean) = (runs as f64, sum / runs as f64);
    (mean, ((square / n - mean * mean) / n).sqrt())
}

#[test]
fn the_haar_density_integrates_to_one_and_the_tangent_density_does_not() {
    let l = Matrix3::new(0.7, 0.0, 0.0, 0.2, 0.5, 0.0, -0.1, 0.2, 0.6);
    let gaussian = Gaussian::<SO3, 3>::new(
        SO3::exp(&vector![0.4, 0.3, -0.8]),
        Covariance::new(l * l.transpose()).unwrap(),
    );
    // Haar measure dV = det J_r dξ has the volume 8π²; a uniform rotation is a uniform unit quaternion.
    let uniform = |normal: &mut Normal| {
        let q: SVector<f64, 4> = normal.vector();
        SO3::from_xyzw(q.into()).unwrap()
    };
    let volume = 8.0 * PI * PI;
    let (haar, error) =
        average(200_000, 61, |normal| volume * gaussian.haar_log_density(&uniform(normal)).unwrap().exp());
    // The share of ξ beyond half a turn, lost to the cut, is below 1e-4 here.
    assert!((haar - 1.0).abs() < 4.0 * error + 1e-4, "{haar} ± {error}");
    let (tangent, error) =
        average(200_000, 62, |normal| volume * gaussian.tangent_log_density(&uniform(normal)).unwrap().exp());
    assert!((tangent - 1.0).abs() > 10.0 * error, "{tangent} ± {error}");
}

#[test]
fn distances_and_densities_do_not_depend_on_the_side() {
    let l = SMatrix::<f64, 6, 6>::from_fn(|i, j| ((i * i + 3 * i * j + j + 1) as f64).sin() * 0.2);
    let local = Gaussian::<SE3, 6>::new(
        SE3::exp(&Vector6::new(3.0, 1.0, 2.0, 0.5, -0.4, 0.3)),
        Covariance::new(l * l.transpose()).unwrap(),
    );
    let global = local.to_global();
    let x = local.perturbed(&Vector6::new(0.1, 0.05, -0.1, 0.2, 0.1, -0.15));
    let close = |a: f64, b: f64| (a - b).abs() < 1e-8 * (1.0 + a.abs());
    assert!(close(local.mahalanobis_squared(&x).unwrap(), global.mahalanobis_squared(&x).unwrap()));
    assert!(close(local.haar_log_density(&x).unwrap(), global.haar_log_density(&x).unwrap()));
    assert!(close(local.tangent_entropy().unwrap(), global.tangent_entropy().unwrap()));
    let other = Gaussian::<SE3, 6>::new(x, *local.covariance() * 1.3);
    assert!(close(local.kl_divergence(&other).unwrap(), global.kl_divergence(&other.to_global()).unwrap()));
}

#[test]
fn the_divergence_is_that_of_monte_carlo() {
    let sigmas = Vector6::new(0.1, 0.2, 0.15, 0.1, 0.12, 0.08);
    let p = Gaussian::<SE3, 6, Global>::from_sigmas(
        SE3::exp(&Vector6::new(1.0, 0.0, 0.0, 0.0, 0.0, 0.5)),
        &sigmas,
    )
    .unwrap();
    let away = p.perturbed(&Vector6::new(0.1, -0.1, 0.1, 0.08, -0.05, 0.04));
    let q = Gaussian::<SE3, 6, Global>::from_sigmas(away, &(sigmas * 1.3)).unwrap();
    let divergence = p.kl_divergence(&q).unwrap();
    let l = p.covariance().factor();
    let (sampled, error) = average(100_000, 63, |normal| {
        let x = p.perturbed(&(l * normal.vector()));
        p.haar_log_density(&x).unwrap() - q.haar_log_density(&x).unwrap()
    });
    assert!(
        (divergence - sampled).abs() < 0.01 * divergence + 4.0 * error,
        "{divergence} {sampled} ± {error}"
    );
    assert!(p.kl_divergence(&p).unwrap().abs() < 1e-12);
    assert!((divergence - q.kl_divergence(&p).unwrap()).abs() > 0.05, "it is no distance");
}

#[test]
fn vectors_have_their_textbook_densities() {
    let sigma = matrix![2.0, 0.5; 0.5, 1.0];
    let g = Gaussian::<Rn<2>, 2>::new(Rn::new(vector![1.0, 2.0]), Covariance::new(sigma).unwrap());
    let (x, e) = (Rn::new(vector![1.5, 1.0]), vector![0.5, -1.0]);
    let square = (e.transpose() * sigma.try_inverse().unwrap() * e).x;
    let density = -0.5 * (square + (TAU * TAU * sigma.determinant()).ln());
    assert!((g.mahalanobis_squared(&x).unwrap() - square).abs() < 1e-15);
    assert!((g.tangent_log_density(&x).unwrap() - density).abs() < 1e-15);
    assert!((g.haar_log_density(&x).unwrap() - density).abs() < 1e-15);
    let entropy = 0.5 * ((TAU * 1_f64.exp()).powi(2) * sigma.determinant()).ln();
    assert!((g.tangent_entropy().unwrap() - entropy).abs() < 1e-15);
    let narrow = Gaussian::<Rn<2>, 2>::from_sigmas(Rn::new(vector![0.0, 0.0]), &vector![1.0, 1.0]).unwrap();
    // ½(tr Σ₁ + |μ|² − 2 − ln det Σ₁)
    let expected = 0.5 * (3.0 + 5.0 - 2.0 - 1.75_f64.ln());
    assert!((g.kl_divergence(&narrow).unwrap() - expected).abs() < 1e-14);
}

#[test]
fn a_certain_direction_has_no_density() {
    let rail = Gaussian::<SO3, 3>::from_sigmas(SO3::identity(), &Vector3::new(0.1, 0.1, 0.0)).unwrap();
    for refused in [rail.tangent_log_density(rail.mean()), rail.kl_divergence(&rail), rail.tangent_entropy()]
    {
        assert!(matches!(refused, Err(UncertaintyError::Singular { .. })));
    }
}
