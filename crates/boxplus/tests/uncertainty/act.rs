//! Points moved by uncertain elements, and E[C].

use crate::monte_carlo::{AGREES, DISAGREES, Moments};
use boxplus::lie::{Action, LieGroup, Rn, SE2, SE3, SGal3, SO3, Sim3};
use boxplus::uncertainty::{Covariance, Gaussian, Global, Local, Order, Side, isotropic_shrink};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// All orders beside Monte Carlo, the point being uncertain as well.
fn agrees<G: Action<D, N, Scalar = f64>, E: Side, const D: usize, const N: usize>(sigma: f64, seed: u64) {
    let l = SMatrix::<f64, D, D>::from_fn(|i, j| {
        ((i * i + 3 * i * j + j + 1) as f64).sin() * sigma / (D as f64).sqrt()
    });
    let k = SMatrix::<f64, N, N>::from_fn(|i, j| ((2 * i + 3 * i * j + j) as f64).cos() * sigma);
    let tau = SVector::<f64, D>::from_fn(|i, _| 0.8 * ((3 * i + 1) as f64).cos());
    let x = Gaussian::<G, D, E>::new(G::exp(&tau), Covariance::new(l * l.transpose()).unwrap());
    let p = SVector::<f64, N>::from_fn(|i, _| 1.5 * ((2 * i + 1) as f64).sin());
    let point = Gaussian::new(Rn::new(p), Covariance::new(k * k.transpose()).unwrap());
    let [first, second, fourth] = [Order::First, Order::Second, Order::Fourth].map(|o| x.act_on(&point, o));
    // The linear part, by differences: exact for the point, and to h² for the element.
    let h = 1e-4;
    let along =
        |xi: SVector<f64, D>| (x.perturbed(&(xi * h)).act(&p) - x.perturbed(&(xi * -h)).act(&p)) / (2.0 * h);
    let a = x.mean().linear_part();
    let control = SMatrix::<f64, N, D>::from_fn(|i, j| along(l.column(j).into_owned())[i]);
    let known = control * control.transpose() + a * k * k.transpose() * a.transpose();
    let moments = Moments::controlled(200_000, seed, &known, |normal| {
        let (eta, zeta) = (normal.vector::<D>(), k * normal.vector::<N>());
        let y = x.perturbed(&(l * eta)).act(&(p + zeta));
        (y - first.mean().vector(), control * eta + a * zeta)
    });
    let name = std::any::type_name::<(G, E)>();
    let shift = |g: &Gaussian<Rn<N>, N>| g.mean().vector() - first.mean().vector();
    assert!(moments.mean_off(&shift(&fourth)) < AGREES, "{name}: {:.1}", moments.mean_off(&shift(&fourth)));
    assert!(moments.mean_off(&shift(&first)) > DISAGREES, "{name}: {:.1}", moments.mean_off(&shift(&first)));
    let off = moments.covariance_off(fourth.covariance().matrix());
    assert!(off < AGREES, "{name}: fourth order is {off:.1} standard errors off");
    let off = moments.covariance_off(second.covariance().matrix());
    assert!(off > DISAGREES, "{name}: second order is only {off:.1} standard errors off");
    assert!((second.covariance().matrix() - known).amax() < 1e-8, "{name}: JΣJᵀ");
    assert!((moments.mean - shift(&second)).norm() < 0.1 * moments.mean.norm(), "{name}");
}

#[test]
fn a_point_moved_by_an_uncertain_element_agrees_with_monte_carlo() {
    agrees::<SO3, Local, 3, 3>(0.2, 31);
    agrees::<SE2, Global, 3, 2>(0.25, 32);
    agrees::<SE3, Local, 6, 3>(0.2, 33);
    agrees::<SE3, Global, 6, 3>(0.2, 34);
    agrees::<SGal3, Local, 10, 4>(0.15, 35);
    agrees::<Sim3, Global, 7, 3>(0.15, 36);
}

/// Σ of J11.
fn wide() -> Gaussian<SO3, 3> {
    let sigma = Matrix3::new(0.3, 0.05, -0.02, 0.05, 0.2, 0.04, -0.02, 0.04, 0.1);
    Gaussian::new(SO3::identity(), Covariance::new(sigma).unwrap())
}

#[test]
fn the_expected_rotation_matrix_has_its_published_errors() {
    let rotation = wide();
    let l = rotation.covariance().factor();
    let mean = Moments::of(400_000, 37, |normal| {
        let c = SO3::exp(&(l * normal.vector())).to_matrix();
        SVector::<f64, 9>::from_iterator(c.iter().copied())
    });
    let sampled = Matrix3::from_iterator(mean.mean.iter().copied());
    let off = |order| (sampled - rotation.expected_matrix(order)).norm();
    let error = mean.mean_error.norm();
    assert!((off(Order::Second) - 0.0316).abs() < 3.0 * error, "{}", off(Order::Second));
    assert!((off(Order::Fourth) - 0.0016).abs() < 3.0 * error, "{} ± {error}", off(Order::Fourth));
    assert!(off(Order::First) > 0.3);
}

#[test]
fn the_expected_matrix_is_the_expected_action() {
    let r = SO3::exp(&Vector3::new(0.4, -0.7, 0.2));
    let p = Vector3::new(1.0, -2.0, 0.5);
    for order in [Order::First, Order::Second, Order::Fourth] {
        let local = Gaussian::<SO3, 3>::new(r, *wide().covariance());
        let global = local.to_global();
        assert!((local.expected_matrix(order) - global.expected_matrix(order)).amax() < 1e-14);
        let acted = local.act(&p, order).mean().vector();
        assert!((local.expected_matrix(order) * p - acted).amax() < 1e-14, "{order:?}");
    }
}

#[test]
fn an_isotropic_rotation_shrinks_by_its_closed_form() {
    let sigma: f64 = 0.05;
    let series = Gaussian::<SO3, 3>::from_sigmas(SO3::identity(), &Vector3::repeat(sigma)).unwrap();
    let exact = Matrix3::identity() * isotropic_shrink(sigma);
    // What is left out is of order σ⁶.
    assert!((series.expected_matrix(Order::Fourth) - exact).amax() < sigma.powi(6));
    assert!((series.expected_matrix(Order::Second) - exact).amax() > 0.4 * sigma.powi(4));
    let sampled =
        Moments::of(100_000, 38, |normal| SO3::exp(&(normal.vector::<3>() * 0.6)).act(&Vector3::x()));
    assert!(sampled.mean_off(&(Vector3::x() * isotropic_shrink(0.6))) < AGREES);
    assert!((isotropic_shrink(0.6_f64) - 0.6897).abs() < 5e-5);
}
