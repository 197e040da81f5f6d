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

/// E[ξ] to fourth order, ½(Log(Exp a·Exp b) + Log(Exp −a·Exp −b)) − ½[a, b] being what is sampled: odd orders cancel and the
/// second is known, so that nothing but the fourth is left.
fn shift<G: LieGroup<D, Scalar = f64>, const D: usize, const N: usize>(
    sigma: f64,
    correlated: bool,
    seed: u64,
) {
    let factor = |k: usize| {
        SMatrix::<f64, D, N>::from_fn(|i, j| ((i * i + 3 * i * j + 5 * k + j * j + 1) as f64).sin())
            * (sigma / (N as f64).sqrt())
    };
    // Independent errors read different halves of the noise.
    let (mut l1, mut l2) = (factor(1), factor(1) * 0.5 + factor(2) * 0.7);
    if !correlated {
        l1.columns_mut(D, N - D).fill(0.0);
        l2.columns_mut(0, D).fill(0.0);
    }
    let [s1, s2, cross] = [l1 * l1.transpose(), l2 * l2.transpose(), l1 * l2.transpose()];
    let [second, fourth] =
        [Order::Second, Order::Fourth].map(|o| compound::<G, D>(&s1, &s2, &cross, o).shift);
    let log = |a: &SVector<f64, D>, b: &SVector<f64, D>| G::exp(a).compose(&G::exp(b)).log();
    let moments = Moments::of(100_000, seed, |normal| {
        let eta = normal.vector::<N>();
        let (a, b) = (l1 * eta, l2 * eta);
        (log(&a, &b) + log(&-a, &-b)) * 0.5 - G::bracket(&a, &b) * 0.5
    });
    let name = std::any::type_name::<G>();
    let off = moments.mean_off(&(fourth - second));
    assert!(off < AGREES, "{name}: {off:.1} standard errors off");
    let off = moments.mean_off(&SVector::zeros());
    assert!(off > DISAGREES, "{name}: without it only {off:.1} standard errors off");
    assert!(correlated || second.amax() == 0.0, "{name}");
}

#[test]
fn the_mean_shifts_in_the_fourth_order_as_monte_carlo_says() {
    shift::<SO3, 3, 6>(0.15, false, 61);
    shift::<SE3, 6, 12>(0.15, false, 62);
    shift::<Sim3, 7, 14>(0.1, false, 63);
    shift::<SO3, 3, 6>(0.15, true, 64);
    shift::<SE3, 6, 12>(0.15, true, 65);
    shift::<SE2, 3, 6>(0.15, true, 66);
}

#[test]
fn the_banana_of_barfoot_and_furgale_has_its_published_covariance() {
    let noise = SMatrix::from_diagonal(&Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0009));
    let ad: &SMatrix<f64, 6, 6> = &SE3::exp(&Vector6::x()).adjoint();
    let after = |order| {
        (0..100).fold(SMatrix::<f64, 6, 6>::zeros(), |sigma, _| {
            compound::<SE3, 6>(&noise, &(ad * sigma * ad.transpose()), &SMatrix::zeros(), order).covariance
        })
    };
    let [second, fourth] = [Order::Second, Order::Fourth].map(after);
    let close = |found: f64, printed: f64| {
        (found - printed).abs() < 0.6 * 10_f64.powi(-3).min(printed.abs() * 1e-5 + 1e-9)
    };
    for (m, printed) in [(second, [0.0, 295.515, -4.455, 0.09]), (fourth, [1.67752, 294.40075, -4.455, 0.09])]
    {
        for (found, printed) in [m.m11, m.m22, m.m26, m.m66].into_iter().zip(printed) {
            assert!(close(found, printed), "{found} instead of {printed}");
        }
    }
}

#[test]
fn a_product_to_fourth_order_is_a_covariance_however_large_the_errors() {
    // Three radians about x, then about y: the series alone has left its radius, 9 − 2·81/12 < 0.
    let about = |sigmas: [f64; 3]| Gaussian::<SO3, 3>::from_sigmas(SO3::identity(), &sigmas.into()).unwrap();
    let (x, y) = (about([3.0, 0.0, 0.0]), about([0.0, 3.0, 0.0]));
    let none = SMatrix::zeros();
    let series =
        compound::<SO3, 3>(x.covariance().matrix(), y.covariance().matrix(), &none, Order::Fourth).covariance;
    assert!(Covariance::new(series).is_err());
    assert!(Covariance::new(*x.compose(&y, Order::Fourth).covariance().matrix()).is_ok());
}
