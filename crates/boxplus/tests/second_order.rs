//! Second derivatives by dual numbers: of J_r, of Exp and of Log, at 0, at switches, at π, of every group. The laws of the closed
//! forms are in `lie::laws`, their last digits in `tests/reference`.
#![cfg(feature = "autodiff")]
#![allow(missing_docs, clippy::unwrap_used)]

use boxplus::lie::{
    LieGroup, R3xSO3, Rn, RxSO2, RxSO3, S3, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3, Tangent,
};
use std::f64::consts::PI;

/// Numbers in (−1, 1), the same in every run.
fn draw<const D: usize>(seed: usize) -> Tangent<f64, D> {
    Tangent::from_fn(|i, _| {
        let z = ((seed * 64 + i + 1) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let z = (z ^ (z >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (z >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    })
}

mod dual {
    use super::*;
    use num_dual::DualSVec64;

    /// D J_r(τ)[δ] as the derivative that one dual number carries through J_r, the rotation being of angle 0 … π.
    pub(super) fn agrees<G: LieGroup<D, Scalar = f64>, const D: usize>(at: usize, n: usize) {
        let angles =
            [0.0, 1e-300, 1e-12, 1e-6, 1e-3, 0.1, 0.49, 0.51, 1.0, 2.0, 3.0, PI - 1e-9, PI, 3.17, 5.0];
        for (k, angle) in angles.into_iter().enumerate() {
            let (mut tau, delta) = (draw::<D>(k), draw::<D>(k + 30));
            let length = tau.rows(at, n).norm();
            tau.rows_mut(at, n).scale_mut(angle / length);
            let moved = tau.zip_map(&delta, |t, d| {
                DualSVec64::<1>::from_re(t) + DualSVec64::<1>::from_re(0.0).derivative(0) * d
            });
            let dual = G::Over::<DualSVec64<1>>::right_jacobian(&moved)
                .map(|x| x.eps.unwrap_generic(nalgebra::Const::<1>, nalgebra::Const::<1>).x);
            let closed = G::right_jacobian_derivative(&tau, &delta);
            let error = (dual - closed).amax();
            let bound = 256.0 * f64::EPSILON * (1.0 + closed.amax());
            assert!(error <= bound, "{}, θ = {angle}: {error:.1e}", std::any::type_name::<G>());
        }
    }
}

mod second_order_dual {
    use super::*;
    use num_dual::{Dual2_64, HyperDual64};

    /// Exp and Log along rays, whose second derivatives are D J_r(τ)[δ]δ and D J_r⁻¹(τ)[J_r⁻¹δ]δ: right at 0, at switches, at π.
    pub(super) fn agrees<G: LieGroup<D, Scalar = f64>, const D: usize>(at: usize, n: usize) {
        let angles =
            [0.0, 1e-300, 1e-160, 1e-12, 1e-6, 1e-3, 2e-3, 0.1, 0.49, 0.51, 1.0, 2.0, 3.0, PI - 1e-7, PI];
        for (k, angle) in angles.into_iter().enumerate() {
            let (mut tau, delta) = (draw::<D>(k), draw::<D>(k + 30));
            let length = tau.rows(at, n).norm();
            tau.rows_mut(at, n).scale_mut(angle / length);
            let x = G::exp(&tau);
            let fixed = x.map(Dual2_64::from_re);
            let ray = |start: f64, d: f64| Dual2_64::new(start, d, 0.0);
            let close =
                |what: &str, dual: Tangent<Dual2_64, D>, first: Tangent<f64, D>, second: Tangent<f64, D>| {
                    let bound = 512.0 * f64::EPSILON * (1.0 + first.amax()) * (1.0 + second.amax());
                    let errors = [(dual.map(|d| d.v1) - first).amax(), (dual.map(|d| d.v2) - second).amax()];
                    for (order, error) in [(1, errors[0]), (2, errors[1])] {
                        let name = std::any::type_name::<G>();
                        assert!(error <= bound, "{what}, order {order}, {name}, θ = {angle}: {error:.1e}");
                    }
                };
            let moved = <G::Over<Dual2_64> as LieGroup<D>>::exp(&tau.zip_map(&delta, ray));
            let second = G::right_jacobian_derivative(&tau, &delta) * delta;
            close("Exp", moved.rminus(&fixed), G::right_jacobian(&tau) * delta, second);
            let step = <G::Over<Dual2_64> as LieGroup<D>>::exp(&delta.map(|d| ray(0.0, d)));
            let tau = x.log();
            let first = G::right_jacobian_inverse(&tau) * delta;
            let second = G::right_jacobian_inverse_derivative(&tau, &first) * delta;
            close("Log", fixed.compose(&step).log(), first, second);
        }
    }

    #[test]
    fn derivatives_of_log_exist_at_exactly_half_a_turn() {
        // w = 0 to the bit, where atan(n/w) divides by zero.
        for q in [[1.0, 0.0, 0.0, 0.0], [0.6, 0.0, -0.8, 0.0], [0.0, 1.0, 0.0, -0.0]] {
            let (x, delta) = (SO3::from_xyzw(q).unwrap(), draw::<3>(5));
            let step = SO3::<Dual2_64>::exp(&delta.map(|d| Dual2_64::new(0.0, d, 0.0)));
            let dual = x.map(Dual2_64::from_re).compose(&step).log();
            let tau = x.log();
            let first = SO3::right_jacobian_inverse(&tau) * delta;
            let second = SO3::right_jacobian_inverse_derivative(&tau, &first) * delta;
            assert!((dual.map(|d| d.v1) - first).amax() < 64.0 * f64::EPSILON, "{q:?}");
            assert!((dual.map(|d| d.v2) - second).amax() < 256.0 * f64::EPSILON, "{q:?}");
        }
    }

    #[test]
    fn mixed_derivatives_are_those_of_hyper_dual_numbers() {
        let (tau, u, v) = (draw::<6>(1), draw::<6>(2), draw::<6>(3));
        let moved = Tangent::<HyperDual64, 6>::from_fn(|i, _| HyperDual64::new(tau[i], u[i], v[i], 0.0));
        let base = SE3::exp(&tau).map(HyperDual64::from_re);
        let mixed = SE3::<HyperDual64>::exp(&moved).rminus(&base).map(|d| d.eps1eps2);
        let d = |a: &Tangent<f64, 6>, b: &Tangent<f64, 6>| SE3::right_jacobian_derivative(&tau, a) * b;
        assert!((mixed - (d(&u, &v) + d(&v, &u)) * 0.5).amax() < 1e-14);
    }
}

macro_rules! groups {
    ($($name:ident: $group:ident<$($n:literal)?>, $d:literal, $at:literal, $k:literal;)*) => { $(
        mod $name {
            use super::*;
            #[test]
            fn right_jacobian_derivative_is_that_of_dual_numbers() {
                dual::agrees::<$group<$($n,)? f64>, $d>($at, $k);
            }
            #[test]
            fn second_derivatives_of_exp_and_log_are_right_at_0_at_switches_and_at_pi() {
                second_order_dual::agrees::<$group<$($n,)? f64>, $d>($at, $k);
            }
        }
    )* };
}

groups! {
    rn: Rn<3>, 3, 0, 3;
    so2: SO2<>, 1, 0, 1;
    so3: SO3<>, 3, 0, 3;
    s3: S3<>, 3, 0, 3;
    se2: SE2<>, 3, 2, 1;
    se3: SE3<>, 6, 3, 3;
    r3xso3: R3xSO3<>, 6, 3, 3;
    se23: SE23<>, 9, 3, 3;
    sgal3: SGal3<>, 10, 3, 3;
    rxso2: RxSO2<>, 2, 0, 1;
    rxso3: RxSO3<>, 4, 0, 3;
    sim2: Sim2<>, 4, 2, 1;
    sim3: Sim3<>, 7, 3, 3;
}
