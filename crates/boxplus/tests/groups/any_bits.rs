//! Any bit pattern may come in: nothing panics, and what is not a number stays recognisable as such.

use boxplus::lie::{
    Bch, LeftJacobians, LieGroup, Means, R3xSO3, Rn, RxSO2, RxSO3, S3, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2,
    Sim3, Weights, second_order,
};
use nalgebra::{SMatrix, SVector};
use proptest::prelude::*;

/// Zeros, subnormals, huge numbers, infinities, NaN and ordinary numbers, in like shares.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<u64>().prop_map(f64::from_bits),
        Just(0.0),
        Just(-0.0),
        Just(f64::MIN_POSITIVE / 4.0),
        Just(f64::MAX),
        Just(f64::INFINITY),
        Just(f64::NEG_INFINITY),
        Just(f64::NAN),
        Just(std::f64::consts::PI),
        -10.0..10.0_f64,
    ]
}

/// Calls everything that takes tangents or elements.
fn survives<G: LieGroup<D, Scalar = f64>, const D: usize>(numbers: &[f64]) {
    let a = SVector::<f64, D>::from_fn(|i, _| numbers[i]);
    let b = SVector::<f64, D>::from_fn(|i, _| numbers[D + i]);
    let (x, y, t) = (G::exp(&a), G::exp(&b), numbers[0]);
    let _ = (x.inverse_jac(), x.compose_jac(&y), x.between_jac(&y), G::exp_jac(&a), x.log_jacs());
    let _ = (x.rplus_jac(&b), x.rminus_jac(&y), x.lplus_jac(&b), x.lminus_jac(&y), x.power_jac(t));
    let _ = (x.interpolate_jac(&y, t), x.interpolate_left_jac(&y, t), G::vee(&G::hat(&a)), x == y);
    let _ = (G::bracket(&a, &b), G::bch_jac(&a, &b), G::right_jacobian_inverse_derivative(&a, &b));
    let _ = second_order::right_jacobian_product_derivative::<G, D>(&a, &b);
    let _ = second_order::squared_norm_hessian::<G, D>(&a, &SMatrix::identity());
    let _ = (G::barycentre(&[x, y], Weights::Of(&[1.0, t])), G::mean(&[x, y], Weights::Equal));
    let _ = (G::geodesic_mean(&[x, y], Weights::Equal, &b), G::median(&[x, y], Weights::Equal, &a));
    let _ = (x.is_near(&y, t), format!("{x:?}"));
}

/// A tangent with one NaN: its element, and what is made of that, has one as well, and is equal to nothing.
fn keeps_nan<G: LieGroup<D, Scalar = f64>, const D: usize>() {
    let not_finite = |v: &SVector<f64, D>| v.iter().any(|c| c.is_nan());
    let tau = SVector::<f64, D>::from_fn(|i, _| 0.1 + 0.2 * i as f64);
    let y = G::exp(&tau);
    for k in 0..D {
        let mut spoilt = tau;
        spoilt[k] = f64::NAN;
        let x = G::exp(&spoilt);
        let kept = [
            ("log", x.log()),
            ("compose", x.compose(&y).log()),
            ("compose, second", y.compose(&x).log()),
            ("inverse", x.inverse().log()),
            ("between", x.between(&y).log()),
            ("interpolate", x.interpolate(&y, 0.5).log()),
        ];
        let name = std::any::type_name::<G>();
        for (what, tangent) in kept {
            assert!(not_finite(&tangent), "{what} of {name} hides coordinate {k}");
        }
        let same = x;
        assert!(x != same && !x.is_near(&same, 1.0), "coordinate {k} of {name}");
        assert!(G::mean(&[x, y], Weights::Equal).is_err(), "the mean of {name} hides coordinate {k}");
    }
}

macro_rules! on_every_group {
    ($($name:ident: $group:ty, $d:literal;)*) => {
        proptest! {
            #![proptest_config(ProptestConfig::with_cases(64))]
            $(#[test]
            fn $name(numbers in prop::collection::vec(any_number(), 20)) {
                survives::<$group, $d>(&numbers);
            })*
        }
        #[test]
        fn a_nan_is_not_swallowed() {
            $(keeps_nan::<$group, $d>();)*
        }
    };
}

on_every_group! {
    no_bits_make_rn_panic: Rn<3>, 3;
    no_bits_make_so2_panic: SO2, 1;
    no_bits_make_so3_panic: SO3, 3;
    no_bits_make_s3_panic: S3, 3;
    no_bits_make_se2_panic: SE2, 3;
    no_bits_make_se3_panic: SE3, 6;
    no_bits_make_r3xso3_panic: R3xSO3, 6;
    no_bits_make_se23_panic: SE23, 9;
    no_bits_make_sgal3_panic: SGal3, 10;
    no_bits_make_rxso2_panic: RxSO2, 2;
    no_bits_make_rxso3_panic: RxSO3, 4;
    no_bits_make_sim2_panic: Sim2, 4;
    no_bits_make_sim3_panic: Sim3, 7;
}
