//! Dual numbers pass through: derivatives of what is computed from a Gaussian are exact.

use boxplus::lie::{LieGroup, SE3};
use boxplus::uncertainty::{Covariance, Gaussian, Order};
use nalgebra::{Const, Matrix6, SVector, Vector6};
use num_dual::DualSVec64;

type Dual = DualSVec64<6>;

#[test]
fn the_slope_of_a_log_density_is_its_closed_form() {
    let l = Matrix6::from_fn(|i, j| {
        0.1 * (((i * i + 3 * i * j + j + 1) as f64).sin() + f64::from(u8::from(i == j)))
    });
    let covariance = Covariance::new(l * l.transpose()).unwrap();
    let mean = SE3::exp(&Vector6::from_fn(|i, _| (i as f64).cos()));
    let x = mean.rplus(&Vector6::from_fn(|i, _| 0.1 * (i as f64).sin()));
    let (e, d_e, _) = x.rminus_jac(&mean);
    let expected = -(d_e.transpose() * covariance.information().unwrap() * e);

    let u = SVector::<Dual, 6>::from_fn(|i, _| Dual::from_re(0.0).derivative(i));
    let dual = Covariance::new(covariance.matrix().map(Dual::from_re)).unwrap();
    let gaussian = Gaussian::<SE3<Dual>, 6>::new(mean.map(Dual::from_re), dual);
    let value = gaussian.tangent_log_density(&x.map(Dual::from_re).rplus(&u)).unwrap();
    let slope = value.eps.unwrap_generic(Const::<6>, Const::<1>);
    assert!((slope - expected).amax() < 1e-11 * expected.amax());
    // Through a product to fourth order and a factorisation there is no NaN, even where directions are certain.
    let product = gaussian.compose(&Gaussian::certain(mean.map(Dual::from_re).rplus(&u)), Order::Fourth);
    let entries = product.covariance().factor();
    assert!(entries.iter().all(|x| x.re.is_finite()
        && x.eps.unwrap_generic(Const::<6>, Const::<1>).iter().all(|d: &f64| d.is_finite())));
}
