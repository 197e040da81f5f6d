//! Regions hold what they promise.

use crate::monte_carlo::Normal;
use boxplus::lie::{LieGroup, Rn, SE2, SE3};
use boxplus::uncertainty::{Covariance, Gaussian, Global, Order};
use nalgebra::{SVector, matrix, vector};
use std::f64::consts::TAU;

/// A robot that drove 100 m with an uncertain heading: Barfoot & Furgale (2014), figure 2, in the plane.
fn banana() -> Gaussian<SE2, 3, Global> {
    let step = Gaussian::certain(SE2::new(vector![1.0, 0.0], 0.0));
    let turn = Gaussian::<SE2, 3, Global>::from_sigmas(SE2::identity(), &vector![0.0, 0.0, 0.03]).unwrap();
    Gaussian::chain((0..100).flat_map(|_| [&turn, &step]), Order::Fourth)
}

/// The share of endpoints that a predicate holds for, and its standard error.
fn share(seed: u64, inside: impl Fn(&SE2) -> bool) -> (f64, f64) {
    const RUNS: usize = 3000;
    let mut normal = Normal::new(seed);
    let held = (0..RUNS).filter(|_| {
        let end = (0..100).fold(SE2::identity(), |x, _| {
            let turn = SE2::new(vector![0.0, 0.0], 0.03 * normal.vector::<1>().x);
            x.compose(&turn).compose(&SE2::new(vector![1.0, 0.0], 0.0))
        });
        inside(&end)
    });
    let p = held.count() as f64 / RUNS as f64;
    (p, (p * (1.0 - p) / RUNS as f64).sqrt())
}

#[test]
fn the_bent_region_holds_the_endpoints_of_a_drive_and_the_ellipse_does_not() {
    let end = banana();
    let region = end.region(0.9).unwrap();
    let (held, error) = share(71, |x| region.contains(x).unwrap());
    assert!((held - 0.9).abs() < 4.0 * error, "{held} ± {error}");
    // Linearised, the position has no variance ahead at all: an ellipse that holds almost nothing.
    let linear = end.to_local().act(&vector![0.0, 0.0], Order::First).ellipsoid(0.9).unwrap();
    let (held, error) = share(72, |x| linear.contains(&x.translation()));
    assert!(held < 0.9 - 10.0 * error, "{held} ± {error}");
}

#[test]
fn every_region_has_its_probability() {
    let l = nalgebra::Matrix6::from_fn(|i, j| ((i * i + 3 * i * j + j + 1) as f64).sin() * 0.15);
    let pose = Gaussian::<SE3, 6>::new(
        SE3::exp(&SVector::from([1.0, 2.0, 3.0, 0.5, 0.4, 0.3])),
        Covariance::new(l * l.transpose()).unwrap(),
    );
    let point = Gaussian::<Rn<3>, 3>::new(
        Rn::new(vector![1.0, 2.0, 3.0]),
        Covariance::new(*pose.covariance().transformed(&nalgebra::Matrix3x6::identity()).matrix()).unwrap(),
    );
    let k = point.covariance().factor();
    for p in [0.5, 0.95] {
        let (region, ellipsoid) = (pose.region(p).unwrap(), point.ellipsoid(p).unwrap());
        let mut normal = Normal::new(73);
        let (runs, mut poses, mut points) = (20_000, 0, 0);
        for _ in 0..runs {
            poses += i32::from(region.contains(&pose.perturbed(&(l * normal.vector()))).unwrap());
            points += i32::from(ellipsoid.contains(&(point.mean().vector() + k * normal.vector())));
        }
        let error = (p * (1.0 - p) / f64::from(runs)).sqrt();
        for held in [poses, points] {
            assert!((f64::from(held) / f64::from(runs) - p).abs() < 4.0 * error);
        }
    }
}

#[test]
fn the_boundary_lies_on_the_boundary() {
    let end = banana();
    let region = end.region(0.9).unwrap();
    for x in region.curve([0, 1], 40).chain([region.boundary(&vector![0.3, -2.0, 1.0])]) {
        // Ahead nothing is uncertain to first order: the whitened error is judged on coordinates of very different size.
        let square = end.mahalanobis_squared(&x).unwrap();
        assert!((square / region.threshold() - 1.0).abs() < 1e-6, "{square}");
    }
    let ellipse = Gaussian::<Rn<2>, 2>::new(
        Rn::new(vector![1.0, -1.0]),
        Covariance::new(matrix![2.0, 0.8; 0.8, 1.0]).unwrap(),
    );
    let drawn = ellipse.ellipsoid(0.6).unwrap();
    for i in 0..12 {
        let y = drawn.boundary(TAU * f64::from(i) / 12.0);
        let square = ellipse.mahalanobis_squared(&Rn::new(y)).unwrap();
        let threshold = boxplus::uncertainty::ChiSquared::new(2).quantile(0.6).unwrap();
        assert!((square / threshold - 1.0).abs() < 1e-13);
        assert!(drawn.contains(&(drawn.centre + (y - drawn.centre) * 0.999)));
        assert!(!drawn.contains(&(drawn.centre + (y - drawn.centre) * 1.001)));
    }
    assert!((drawn.angle() - 0.5 * (2.0 * 0.8_f64).atan2(1.0)).abs() < 1e-15);
}

#[test]
fn a_flat_region_has_fewer_degrees_of_freedom() {
    let rail = Gaussian::<Rn<2>, 2>::from_sigmas(Rn::new(vector![1.0, 2.0]), &vector![0.5, 0.0]).unwrap();
    let segment = rail.ellipsoid(0.6826894921370859).unwrap(); // one σ of one coordinate
    assert!((segment.semi_axes() - vector![0.5, 0.0]).amax() < 1e-15);
    assert!(segment.contains(&vector![1.49, 2.0]) && !segment.contains(&vector![1.0, 2.001]));
}
