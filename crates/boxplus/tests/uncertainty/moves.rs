//! Frame change, reset and parallel transport are three operations; only one of them follows a correction.

use crate::monte_carlo::{AGREES, DISAGREES, Moments};
use boxplus::lie::{LieGroup, SE3, SO3};
use boxplus::uncertainty::{Covariance, Gaussian, Global, Local, Side};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Σ and a correction of 0.88 rad.
fn correction() -> (Covariance<3>, Vector3<f64>) {
    let l = Matrix3::new(0.05, 0.0, 0.0, 0.01, 0.03, 0.0, -0.02, 0.01, 0.015);
    (Covariance::new(l * l.transpose()).unwrap(), Vector3::new(0.6, -0.5, 0.4) * (0.88 / 0.77_f64.sqrt()))
}

#[test]
fn a_reset_is_what_monte_carlo_finds_and_the_other_moves_are_not() {
    let (covariance, theta) = correction();
    let before = Gaussian::<SO3, 3>::new(SO3::exp(&Vector3::new(0.3, 0.2, -0.4)), covariance);
    let after = before.reset(&theta);
    let (l, j) = (covariance.factor(), SO3::right_jacobian(&theta));
    let moments = Moments::controlled(100_000, 11, after.covariance().matrix(), |normal| {
        let xi = l * normal.vector();
        (after.error_of(&before.perturbed(&(theta + xi))), j * xi)
    });
    let relative = |m: &Matrix3<f64>| (m - moments.covariance).norm() / moments.covariance.norm();
    // First order in the spread: what is neglected is Σ² beside Σ.
    assert!(relative(after.covariance().matrix()) < 0.0005, "{}", relative(after.covariance().matrix()));
    let frame = before.change_body(&SO3::exp(&theta));
    let transported = before.transport(&theta);
    let exp = SO3::exp(&theta).adjoint();
    let half = Matrix3::identity() - 0.5 * SO3::hat(&theta);
    let wrong = [
        ("nothing", 0.40, *covariance.matrix()),
        ("frame change", 0.40, *frame.covariance().matrix()),
        ("parallel transport", 0.06, *transported.covariance().matrix()),
        ("frame change, turned", 0.95, exp * covariance.matrix() * exp.transpose()),
        ("I − ½θ^", 0.25, half * covariance.matrix() * half.transpose()),
    ];
    // As the module's page says.
    for (name, expected, m) in wrong {
        assert!((relative(&m) - expected).abs() < 0.006, "{name}: {}", relative(&m));
        assert!(moments.covariance_off(&m) > DISAGREES, "{name}");
    }
}

#[test]
fn a_reset_is_exact_in_the_limit_of_small_spread_on_both_sides() {
    fn check<E: Side>(seed: u64) {
        let l = SMatrix::<f64, 6, 6>::from_fn(|i, j| 2e-4 * ((i * i + 3 * i * j + j) as f64).sin());
        let covariance = Covariance::new(l * l.transpose()).unwrap();
        let theta = SVector::<f64, 6>::from_fn(|i, _| 0.9 * ((2 * i + 1) as f64).cos());
        let before = Gaussian::<SE3, 6, E>::new(SE3::exp(&(theta * 0.7)), covariance);
        let after = before.reset(&theta);
        let moments = Moments::of(20_000, seed, |normal| {
            after.error_of(&before.perturbed(&(theta + l * normal.vector())))
        });
        assert!(moments.covariance_off(after.covariance().matrix()) < AGREES);
        assert!(moments.mean_off(&SVector::zeros()) < AGREES);
        assert!(moments.covariance_off(covariance.matrix()) > DISAGREES);
    }
    check::<Local>(12);
    check::<Global>(13);
}

#[test]
fn transport_on_a_rotation_group_turns_the_ellipsoid_without_stretching_it() {
    let (covariance, theta) = correction();
    let local = Gaussian::<SO3, 3>::new(SO3::exp(&Vector3::new(0.3, 0.2, -0.4)), covariance);
    let moved = local.transport(&theta);
    let lengths = |g: &Gaussian<SO3, 3>| g.covariance().principal_axes().0;
    assert!((lengths(&moved) - lengths(&local)).amax() < 1e-17);
    // The same path in the frame of the parent.
    let global = local.to_global().transport(&(local.mean().adjoint() * theta)).to_local();
    assert!((global.covariance().matrix() - moved.covariance().matrix()).amax() < 1e-17);
    assert!(global.mean().rminus(moved.mean()).norm() < 1e-15);
    // And back again.
    let back = moved.transport(&-theta);
    assert!((back.covariance().matrix() - covariance.matrix()).amax() < 1e-17);
}
