//! How sure means are, and which resist what is wrong.

use super::{Normal, apart, draw};
use boxplus::lie::{LieError, LieGroup, Means, Rn, SE3, SO2, SO3, Sim3, Tangent, Weights};
use nalgebra::{Vector1, Vector3, vector};

#[test]
fn the_median_of_angles_is_their_median_and_resists_what_is_wrong() {
    let unit = Vector1::new(1.0);
    let angles = [0.3, -0.2, 0.0, 0.9, 0.1_f64];
    let median = SO2::median(&angles.map(SO2::from_angle), Weights::Equal, &unit).unwrap();
    assert!((median.value.angle() - 0.1).abs() < 1e-12);
    assert_eq!(median.covariance, None); // it sits on an element
    // Where the elements coincide, weights decide.
    let two = [0.0, 1.0_f64].map(SO2::from_angle);
    let median = SO2::median(&two, Weights::Of(&[1.0, 2.0]), &unit).unwrap();
    assert!((median.value.angle() - 1.0).abs() < 1e-12);
    // The weight that is where the iteration starts holds it there at once, as long as the others pull no stronger.
    let at = |x: f64, y: f64| Rn::<2>::new([x, y].into());
    let held =
        Rn::median(&[at(0.0, 0.0), at(1.0, 0.0)], Weights::Of(&[1.0, 0.8]), &[1.0, 1.0].into()).unwrap();
    assert_eq!((held.value.vector().amax(), held.iterations), (0.0, 1));
    let same = [SO3::about_z(0.2); 3];
    let ones = Vector3::repeat(1.0);
    assert!(apart(&SO3::median(&same, Weights::Equal, &ones).unwrap().value, &same[0]) < 1e-15);
    // Two of five upside down: the mean is refused or lost, the median stays among the three.
    let center = SO3::exp(&draw(3));
    let mut readings: [SO3; 5] = core::array::from_fn(|i| center.rplus(&(draw::<f64, 3>(i) * 0.01)));
    readings[0] = center.rplus(&vector![3.0, 0.3, 0.0]);
    readings[3] = center.rplus(&vector![0.0, -2.9, 0.4]);
    assert!(SO3::mean(&readings, Weights::Equal).is_err());
    let median = SO3::median(&readings, Weights::Equal, &ones).unwrap();
    assert!(median.value.rminus(&center).norm() < 0.03 && (median.beyond - 0.4).abs() < 1e-15);
}

/// Means of `N` draws X̄·Exp(σ∘η), again and again: their own scatter against the covariance each of them reports, and against
/// the covariance propagated from that of the elements.
fn covariance_of_the_mean<G: LieGroup<D, Scalar = f64>, const D: usize, const N: usize>(
    average: impl Fn(&[G]) -> boxplus::lie::Mean<G, D>,
    sigma: f64,
    seed: u64,
) {
    const RUNS: usize = 2000;
    let (truth, mut normal) = (G::exp(&draw(12)), Normal(seed));
    let sigmas = Tangent::<f64, D>::from_fn(|i, _| sigma * (1.0 + 0.5 * (i as f64).sin()));
    let (mut scatter, mut reported) = (Tangent::<f64, D>::zeros(), Tangent::<f64, D>::zeros());
    let mut propagated = Tangent::<f64, D>::zeros();
    let each = nalgebra::SMatrix::from_diagonal(&sigmas.component_mul(&sigmas));
    for _ in 0..RUNS {
        let xs: [G; N] = core::array::from_fn(|_| truth.rplus(&sigmas.component_mul(&normal.vector())));
        let mean = average(&xs);
        let off = mean.value.rminus(&truth);
        scatter += off.component_mul(&off);
        reported += mean.covariance.unwrap().diagonal();
        let elements = xs.iter().map(|x| (x, 1.0 / N as f64, &each));
        propagated += mean.propagated(elements).unwrap().diagonal();
    }
    // A variance from RUNS draws has the relative standard error √(2/RUNS); the report of N draws has √(2/(N·RUNS)).
    let error = (2.0 / RUNS as f64).sqrt();
    for i in 0..D {
        for (name, claimed) in [("reported", reported[i]), ("propagated", propagated[i])] {
            let ratio = scatter[i] / claimed;
            assert!((ratio - 1.0).abs() < 4.5 * error, "{name}, coordinate {i}: {ratio}, s.e. {error:.3}");
        }
    }
}

#[test]
fn a_mean_is_as_sure_as_it_says() {
    covariance_of_the_mean::<SO3, 3, 10>(|xs| SO3::mean(xs, Weights::Equal).unwrap(), 0.2, 1);
    covariance_of_the_mean::<SE3, 6, 10>(|xs| SE3::mean(xs, Weights::Equal).unwrap(), 0.15, 2);
    covariance_of_the_mean::<Sim3, 7, 10>(|xs| Sim3::mean(xs, Weights::Equal).unwrap(), 0.15, 3);
    let metric = Tangent::repeat(1.0);
    let geodesic = |xs: &[SE3]| SE3::geodesic_mean(xs, Weights::Equal, &metric).unwrap();
    covariance_of_the_mean::<SE3, 6, 10>(geodesic, 0.15, 4);
}

#[test]
fn hubers_mean_costs_little_where_all_is_well_resists_what_is_wrong_and_is_as_sure_as_it_says() {
    const RUNS: usize = 1000;
    let (sigma, mut normal) = (0.05, Normal(5));
    let metric = Vector3::repeat(1.0 / sigma);
    let (mut good, mut bad, mut reported) = ([0.0; 3], [0.0; 3], 0.0);
    for _ in 0..RUNS {
        let mut xs: [SO3; 15] = core::array::from_fn(|_| SO3::exp(&(normal.vector() * sigma)));
        let means = |xs: &[SO3]| {
            [
                SO3::mean(xs, Weights::Equal).unwrap(),
                SO3::huber_mean(xs, Weights::Equal, &metric, 2.0).unwrap(),
                SO3::median(xs, Weights::Equal, &metric).unwrap(),
            ]
        };
        let found = means(&xs);
        (0..3).for_each(|k| good[k] += found[k].value.log().norm_squared());
        reported += found[1].covariance.unwrap().trace();
        for x in &mut xs[..3] {
            *x = SO3::exp(&vector![0.9, 0.3, -0.2]); // a fifth is wrong, and alike
        }
        let found = means(&xs);
        (0..3).for_each(|k| bad[k] += found[k].value.log().norm_squared());
        assert!(found[1].pull(&xs[0]) < 0.15);
    }
    let ([mean, huber, median], [lost, kept, _]) = (good, bad);
    assert!(huber < 1.05 * mean && median > 1.1 * mean, "{} {}", huber / mean, median / mean);
    assert!(kept < 0.1 * lost, "{}", kept / lost);
    // Three variances from RUNS draws.
    let ratio = huber / reported;
    assert!((ratio - 1.0).abs() < 4.5 * (2.0 / (3.0 * RUNS as f64)).sqrt(), "{ratio}");
}

#[test]
fn a_threshold_must_be_positive() {
    let xs = [0.0, 0.1].map(SO2::from_angle);
    for threshold in [0.0, -1.0] {
        let refused = SO2::huber_mean(&xs, Weights::Equal, &Vector1::new(1.0), threshold).unwrap_err();
        assert_eq!(refused, LieError::NotAThreshold { threshold });
    }
    let refused = SO2::huber_mean(&xs, Weights::Equal, &Vector1::new(1.0), f64::NAN).unwrap_err();
    assert!(matches!(refused, LieError::NotAThreshold { threshold } if threshold.is_nan()));
}
