//! Compounding: published numbers, and both orders against Monte Carlo.

use crate::monte_carlo::{AGREES, DISAGREES, Moments};
use boxplus::lie::{LieGroup, SE2, SE3, SE23, SGal3, SO3, Sim3};
use boxplus::uncertainty::{Covariance, Gaussian, Global, Local, Order, Side, compound};
use nalgebra::{SMatrix, SVector, Vector6};
use std::f64::consts::PI;

/// Two uncertain poses of Barfoot & Furgale (2014), figure 3.
fn figure_3(alpha: f64) -> [Gaussian<SE3, 6, Global>; 2] {
    let gaussian = |tau: [f64; 6], variances: [f64; 6]| {
        let sigmas = SVector::from(variances).map(|v: f64| (alpha * v).sqrt());
        Gaussian::from_sigmas(SE3::exp(&Vector6::from(tau)), &sigmas).unwrap()
    };
    [
        gaussian([0.0, 2.0, 0.0, PI / 6.0, 0.0, 0.0], [10.0, 5.0, 5.0, 0.5, 1.0, 0.5]),
        gaussian([0.0, 0.0, 1.0, PI / 4.0, 0.0, 0.0], [5.0, 10.0, 5.0, 0.5, 0.5, 1.0]),
    ]
}

#[test]
fn the_fourth_order_of_barfoot_and_furgale_is_met_to_the_last_digit() {
    let [x, y] = figure_3(0.1);
    let second = y.covariance().transformed(&x.mean().adjoint());
    let none = SMatrix::zeros();
    let [linear, fourth] = [Order::Second, Order::Fourth]
        .map(|order| compound::<SE3, 6>(x.covariance().matrix(), second.matrix(), &none, order));
    let distance = (fourth.covariance - linear.covariance).norm();
    assert!((distance - 0.03470088955026769).abs() < 1e-16, "{distance:.18}");
}

/// A covariance without symmetry: coordinates correlated, directions unequal.
fn generic<const D: usize>(sigma: f64, seed: usize) -> SMatrix<f64, D, D> {
    let factor = SMatrix::<f64, D, D>::from_fn(|i, j| ((i * i + 5 * i * j + 7 * seed + j + 1) as f64).sin());
    factor * factor.transpose() * (sigma * sigma / factor.norm_squared() * D as f64)
}

fn product<G: LieGroup<D, Scalar = f64>, E: Side, const D: usize>(sigma: f64, seed: u64) {
    let tangent = |k: usize| SVector::<f64, D>::from_fn(|i, _| 0.8 * ((3 * i + k) as f64).cos());
    let gaussian = |k: usize| {
        let covariance = Covariance::new(generic::<D>(sigma, k)).unwrap();
        Gaussian::<G, D, E>::new(G::exp(&tangent(k)), covariance)
    };
    let (x, y) = (gaussian(1), gaussian(2));
    let [second, fourth] = [Order::Second, Order::Fourth].map(|order| x.compose(&y, order));
    // The linear part of the error is known exactly and serves as control.
    let (j1, j2) = (E::under_right_factor(y.mean()), E::under_left_factor(x.mean()));
    let (l1, l2) = (x.covariance().factor(), y.covariance().factor());
    let moments = Moments::controlled(150_000, seed, second.covariance().matrix(), |normal| {
        let (a, b) = (l1 * normal.vector(), l2 * normal.vector());
        let product = x.perturbed(&a).compose(&y.perturbed(&b));
        (second.error_of(&product), j1 * a + j2 * b)
    });
    // About the mean of the means, ξ has the mean E[ξ] and, up to sixth order, the covariance of the fourth order.
    let shift = second.error_of(fourth.mean());
    let name = std::any::type_name::<(G, E)>();
    let off = moments.covariance_off(fourth.covariance().matrix());
    assert!(off < AGREES, "{name}: fourth order is {off:.1} standard errors off");
    assert!(moments.mean_off(&shift) < AGREES, "{name}: mean {:.1}", moments.mean_off(&shift));
    let off = moments.covariance_off(second.covariance().matrix());
    assert!(off > DISAGREES, "{name}: second order is only {off:.1} standard errors off");
}

#[test]
fn fourth_order_products_agree_with_monte_carlo_where_second_order_does_not() {
    product::<SO3, Local, 3>(0.15, 1);
    product::<SO3, Global, 3>(0.15, 2);
    product::<SE2, Local, 3>(0.15, 3);
    product::<SE3, Local, 6>(0.12, 4);
    product::<SE3, Global, 6>(0.12, 5);
    product::<SE23, Local, 9>(0.1, 6);
    product::<SGal3, Global, 10>(0.1, 7);
    product::<Sim3, Local, 7>(0.1, 8);
}
