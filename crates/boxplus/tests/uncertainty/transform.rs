//! Through any function: sigma points and expansions against Monte Carlo and the published stereo camera.

use crate::monte_carlo::{AGREES, DISAGREES, Moments};
use boxplus::lie::{Action, LieGroup, Rn, SE2, SE3, SO3};
use boxplus::uncertainty::{Covariance, Gaussian, Global, Order, SigmaPoints, UncertaintyError};
use nalgebra::{Matrix2, SVector, Vector4, matrix, vector};

/// Pose and point errors of Barfoot & Furgale (2014), figure 8, at the scale α.
fn figure_8(alpha: f64) -> Gaussian<Rn<9>, 9> {
    let variances = SVector::from([0.1, 0.1, 0.01, 0.01, 0.01, 0.01, 1.0, 1.0, 1.0]);
    let sigmas = variances.map(|v: f64| (alpha * v).sqrt());
    Gaussian::from_sigmas(Rn::new(SVector::zeros()), &sigmas).unwrap()
}

/// What a stereo camera sees of the point (10, 10, 10) with these errors: left and right pixel.
fn stereo(errors: &Rn<9>) -> Rn<4> {
    let errors = errors.vector();
    let pose = SE3::exp(&errors.fixed_rows::<6>(0).into_owned());
    let p = pose.act(&(vector![10.0, 10.0, 10.0] + errors.fixed_rows::<3>(6)));
    let half_baseline = 0.125;
    Rn::new(Vector4::new(p.x + half_baseline, p.y, p.x - half_baseline, p.y) * (200.0 / p.z))
}

#[test]
fn the_stereo_camera_of_barfoot_and_furgale_has_its_published_errors() {
    // α, errors of the mean (first order, second, sigma points), its standard error; of the covariance (second, fourth, sigma).
    let published = [
        (0.1, [1.616, 0.015, 0.016], 0.015, [25.6, 20.0, 6.7], 1.0),
        (0.5, [8.52, 0.50, 0.15], 0.03, [715.0, 575.0, 164.0], 5.0),
    ];
    for (alpha, means, mean_error, covariances, covariance_error) in published {
        let errors = figure_8(alpha);
        let l = errors.covariance().factor();
        let sampled = Moments::of(150_000, 51, |normal| stereo(&Rn::new(l * normal.vector())).vector());
        let [first, second, fourth] =
            [Order::First, Order::Second, Order::Fourth].map(|order| errors.expanded(stereo, order));
        let sigma = errors.unscented(stereo, &SigmaPoints::default()).unwrap();
        // Their sampling and ours.
        let slack = 3.0 * (mean_error + sampled.mean_error.norm());
        for (found, expected) in [first, second, sigma].iter().zip(means) {
            let off = (found.mean.vector() - sampled.mean).norm();
            assert!((off - expected).abs() < slack, "α = {alpha}: {off:.3} instead of {expected}");
        }
        let slack = 3.0 * (covariance_error + sampled.covariance_error.norm());
        for (found, expected) in [second, fourth, sigma].iter().zip(covariances) {
            let off = (found.covariance.matrix() - sampled.covariance).norm();
            assert!(
                (off - expected).abs() < slack,
                "α = {alpha}: {off:.1} instead of {expected} ± {slack:.1}"
            );
        }
    }
}

#[test]
fn polynomials_of_second_degree_are_exact() {
    // y = x² and y = x₁x₂ of x ~ N(μ, Σ): moments known in closed form.
    let sigma = matrix![0.5, 0.2; 0.2, 0.3];
    let mu = vector![0.7, -0.4];
    let x = Gaussian::<Rn<2>, 2>::new(Rn::new(mu), Covariance::new(sigma).unwrap());
    let f = |x: &Rn<2>| Rn::new(vector![x.vector().x * x.vector().x, x.vector().x * x.vector().y]);
    let mean = vector![mu.x * mu.x + 0.5, mu.x * mu.y + 0.2];
    let j = matrix![2.0 * mu.x, 0.0; mu.y, mu.x];
    let fourth = Matrix2::new(2.0 * 0.25, 2.0 * 0.5 * 0.2, 2.0 * 0.5 * 0.2, 0.5 * 0.3 + 0.2 * 0.2);
    let found = x.expanded(f, Order::Fourth);
    assert!((found.mean.vector() - mean).amax() < 1e-9);
    assert!((found.covariance.matrix() - j * sigma * j.transpose() - fourth).amax() < 1e-9);
    assert!((found.cross - sigma * j.transpose()).amax() < 1e-12);
    // Sigma points see the mean of any quadratic, whatever their spread.
    for points in [SigmaPoints::default(), SigmaPoints { alpha: 0.5, beta: 2.0, kappa: 1.0 }] {
        let found = x.unscented(f, &points).unwrap();
        assert!((found.mean.vector() - mean).amax() < 1e-13);
        assert!((found.cross - sigma * j.transpose()).amax() < 1e-13);
    }
}

#[test]
fn sigma_points_compound_as_second_order_does() {
    // Barfoot & Furgale (2014) (57). With one input known exactly both are exact.
    let sigma = Covariance::from_sigmas(&SVector::<f64, 6>::from_fn(|i, _| 0.1 + 0.02 * i as f64)).unwrap();
    let step = SE3::exp(&SVector::<f64, 6>::from_fn(|i, _| ((i + 2) as f64).cos()));
    let pose =
        Gaussian::<SE3, 6>::new(SE3::exp(&SVector::<f64, 6>::from_fn(|i, _| ((i + 1) as f64).sin())), sigma);
    let found = pose.unscented(|x| x.compose(&step), &SigmaPoints::default()).unwrap();
    let exact = pose.change_body(&step);
    assert!((found.covariance.matrix() - exact.covariance().matrix()).amax() < 1e-14);
    assert!(found.mean.rminus(exact.mean()).norm() < 1e-13);
    let linear = pose.expanded(|x| x.compose(&step), Order::First);
    assert!((linear.covariance.matrix() - exact.covariance().matrix()).amax() < 1e-10);
    assert!((found.gaussian().covariance().matrix() - found.covariance.matrix()).amax() == 0.0);
    // Global in: the cross-covariance is that of the global error.
    let global = pose.to_global().unscented(|x| x.compose(&step), &SigmaPoints::default()).unwrap();
    let expected = pose.mean().adjoint() * found.cross;
    assert!((global.cross - expected).amax() < 1e-12);
}

#[test]
fn sigma_points_agree_with_monte_carlo_where_linearisation_does_not() {
    let heading =
        Gaussian::<SE2, 3, Global>::from_sigmas(SE2::new(vector![3.0, 0.0], 0.0), &vector![0.0, 0.0, 0.2])
            .unwrap();
    let f = |x: &SE2| Rn::<2>::new(x.translation());
    let l = heading.covariance().factor();
    let moments = Moments::of(200_000, 52, |normal| f(&heading.perturbed(&(l * normal.vector()))).vector());
    let tuned = heading.unscented(f, &SigmaPoints { alpha: 1.0, beta: 0.0, kappa: 0.0 }).unwrap();
    let linear = heading.expanded(f, Order::First);
    assert!(moments.mean_off(&linear.mean.vector()) > DISAGREES);
    assert!(
        (moments.mean - tuned.mean.vector()).norm()
            < 0.03 * (moments.mean - linear.mean.vector()).norm() + 4.0 * moments.mean_error.norm()
    );
    let fourth = heading.expanded(f, Order::Fourth);
    assert!(
        (fourth.mean.vector() - moments.mean).norm()
            < AGREES * moments.mean_error.norm() + 3.0 * 0.2_f64.powi(4) / 8.0
    );
}

#[test]
fn a_function_with_an_unusable_answer_is_told() {
    let x = Gaussian::<SO3, 3>::from_sigmas(SO3::identity(), &vector![0.1, 0.1, 0.1]).unwrap();
    let lost = x.unscented(|_| Rn::<1>::new(vector![f64::NAN]), &SigmaPoints::default());
    assert!(matches!(lost, Err(UncertaintyError::NotConverged { .. } | UncertaintyError::NotFinite { .. })));
    // A negative centre weight on a strongly curved function: no covariance is left.
    let squared = |x: &SO3| Rn::<1>::new(vector![x.log().norm_squared()]);
    let negative = x.unscented(squared, &SigmaPoints { alpha: 1e-3, beta: -3.0, kappa: 0.0 });
    assert!(matches!(negative, Err(UncertaintyError::Indefinite { .. })), "{negative:?}");
}
