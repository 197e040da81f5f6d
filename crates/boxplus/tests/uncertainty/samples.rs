//! From data to a Gaussian and back, and the angles of older programs.

use crate::monte_carlo::{AGREES, DISAGREES, Moments, Normal};
use boxplus::lie::{LieGroup, SE2, SE3, SO3};
use boxplus::uncertainty::{Covariance, Gaussian, Global, UncertaintyError};
use nalgebra::{Matrix6, SMatrix, SVector, Vector3, Vector6, vector};
use std::f64::consts::FRAC_PI_2;

fn pose() -> Gaussian<SE3, 6> {
    let l = Matrix6::from_fn(|i, j| 0.1 * ((i * i + 3 * i * j + j + 1) as f64).sin());
    let mean = SE3::exp(&Vector6::from_fn(|i, _| ((3 * i + 1) as f64).cos()));
    Gaussian::new(mean, Covariance::new(l * l.transpose()).unwrap())
}

#[test]
fn samples_give_mean_and_covariance_back() {
    let (truth, mut normal) = (pose(), Normal::new(81));
    let l = truth.covariance().factor();
    let draws: Vec<SE3> = (0..20_000).map(|_| truth.perturbed(&(l * normal.vector()))).collect();
    let found = Gaussian::<SE3, 6>::from_samples(&draws).unwrap();
    let n = draws.len() as f64;
    // Errors of a mean are Σ/n, of a variance 2σ⁴/n.
    let off = truth.error_of(found.gaussian.mean());
    assert!(truth.covariance().mahalanobis_squared(&off).unwrap() * n < 30.0, "χ² of 6: 30 is 4·10⁻⁵");
    for i in 0..6 {
        let (x, y) = (found.gaussian.covariance().matrix()[(i, i)], truth.covariance().matrix()[(i, i)]);
        assert!((x / y - 1.0).abs() < 4.0 * (2.0 / n).sqrt());
    }
    assert!(found.iterations <= 8 && found.count == 20_000);
    // The same data on the other side: the mean is bi-invariant.
    let global = Gaussian::<SE3, 6, Global>::from_samples(&draws).unwrap().gaussian.to_local();
    assert!(global.mean().rminus(found.gaussian.mean()).norm() < 1e-13);
    assert!((global.covariance().matrix() - found.gaussian.covariance().matrix()).amax() < 1e-13);
}

#[test]
fn few_or_scattered_samples_are_told() {
    let one = Gaussian::<SO3, 3>::from_samples(&[SO3::identity()]);
    assert_eq!(one.unwrap_err(), UncertaintyError::TooFew { given: 1, needed: 2 });
    let three = [0.0, 0.1, 0.3].map(|t| SE3::exp(&Vector6::from_fn(|i, _| t * ((i as f64) + t).sin())));
    assert_eq!(Gaussian::<SE3, 6>::from_samples(&three).unwrap().gaussian.covariance().rank(), 2);
    let lost = [SO3::exp(&vector![0.1, 0.0, 0.0]), SO3::exp(&vector![f64::NAN, 0.0, 0.0])];
    assert!(Gaussian::<SO3, 3>::from_samples(&lost).is_err());
}

#[cfg(feature = "rand")]
#[test]
fn draws_have_the_moments_they_should_and_stay_where_nothing_is_uncertain() {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    let pose = pose();
    let mut draws = pose.samples(ChaCha8Rng::seed_from_u64(82));
    let moments = Moments::of(50_000, 0, |_| pose.error_of(&draws.next().unwrap()));
    assert!(moments.mean_off(&SVector::zeros()) < AGREES);
    assert!(moments.covariance_off(pose.covariance().matrix()) < AGREES);
    let rail = Gaussian::<SE2, 3>::from_sigmas(SE2::identity(), &vector![0.1, 0.0, 0.0]).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(83);
    for _ in 0..100 {
        let x = rail.sample(&mut rng);
        assert_eq!((x.translation().y, x.angle()), (0.0, 0.0));
    }
    let again = |seed| pose.sample(&mut ChaCha8Rng::seed_from_u64(seed));
    assert_eq!(again(5), again(5));
    assert_ne!(again(5), again(6));
}

/// R_z(yaw)·R_y(pitch)·R_x(roll).
fn rotation(angles: &Vector3<f64>) -> SO3 {
    let about = |axis: Vector3<f64>, angle: f64| SO3::exp(&(axis * angle));
    about(Vector3::z(), angles.x)
        .compose(&about(Vector3::y(), angles.y))
        .compose(&about(Vector3::x(), angles.z))
}

#[test]
fn a_covariance_of_yaw_pitch_and_roll_is_that_of_monte_carlo() {
    let state = Vector6::new(1.0, -2.0, 0.5, 2.0, 0.7, -1.1);
    let l = Matrix6::from_fn(|i, j| {
        0.002 * (((i * i + 3 * i * j + j + 1) as f64).sin() + f64::from(u8::from(i == j)))
    });
    let given = Covariance::new(l * l.transpose()).unwrap();
    let gaussian = Gaussian::<SE3, 6>::from_yaw_pitch_roll(&state, &given);
    let element = |s: &Vector6<f64>| {
        SE3::new(rotation(&s.fixed_rows::<3>(3).into_owned()), s.fixed_rows::<3>(0).into_owned())
    };
    assert!(gaussian.mean().rminus(&element(&state)).norm() < 1e-15);
    let moments =
        Moments::of(50_000, 84, |normal| gaussian.error_of(&element(&(state + l * normal.vector()))));
    assert!(moments.covariance_off(gaussian.covariance().matrix()) < AGREES);
    assert!(moments.covariance_off(given.matrix()) > DISAGREES, "the angles are no rotation vector");
    let (back, covariance) = gaussian.to_yaw_pitch_roll().unwrap();
    assert!((back - state).amax() < 1e-14);
    assert!((covariance.matrix() - given.matrix()).amax() < 1e-17);
    let part = Gaussian::<SO3, 3>::from_yaw_pitch_roll(
        &state.fixed_rows::<3>(3).into_owned(),
        &Covariance::new(given.matrix().fixed_view::<3, 3>(3, 3).into_owned()).unwrap(),
    );
    let block = gaussian.covariance().matrix().fixed_view::<3, 3>(3, 3).into_owned();
    assert!((part.covariance().matrix() - block).amax() < 1e-18);
    let (angles, _) = part.to_yaw_pitch_roll().unwrap();
    assert!((angles - state.fixed_rows::<3>(3)).amax() < 1e-14);
}

#[test]
fn gimbal_lock_is_an_error_and_its_neighbourhood_is_not() {
    let at = |pitch: f64| {
        Gaussian::<SO3, 3>::new(rotation(&vector![0.3, pitch, 0.1]), Covariance::unit() * 0.01)
            .to_yaw_pitch_roll()
    };
    for pitch in [FRAC_PI_2, -FRAC_PI_2, FRAC_PI_2 - 1e-9] {
        assert!(matches!(at(pitch), Err(UncertaintyError::GimbalLock { .. })), "{pitch}");
    }
    let (angles, covariance) = at(FRAC_PI_2 - 1e-3).unwrap();
    assert!((angles - vector![0.3, FRAC_PI_2 - 1e-3, 0.1]).amax() < 1e-12);
    assert!(covariance.sigmas().x > 9.0, "yaw and roll are spread without bound, their sum is not");
    let sum = covariance.transformed(&SMatrix::<f64, 1, 3>::new(1.0, 0.0, -1.0)).sigmas().x;
    assert!(sum < 0.02, "{sum}");
}
