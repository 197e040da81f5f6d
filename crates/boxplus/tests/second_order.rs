//! The derivative of the right Jacobian, against 80 digits and against dual numbers; tangents composed by their series.
#![allow(missing_docs, clippy::unwrap_used)]

use boxplus::lie::second_order::squared_norm_hessian;
use boxplus::lie::{
    Bch, BchOrder, Jacobian, LieGroup, R3xSO3, Real, Rn, RxSO2, RxSO3, S3, SE2, SE3, SE23, SGal3, SO2, SO3,
    Sim2, Sim3, Tangent,
};
use nalgebra::SMatrix;
use std::f64::consts::PI;

const TABLE: &str = include_str!("reference/second_order.csv");

/// The worst error of a group over the table, in ε, relative to the largest entry of each matrix.
fn worst<G: LieGroup<D>, const D: usize>(group: &str) -> f64 {
    let rows = TABLE.lines().filter_map(|line| line.strip_prefix(group)?.strip_prefix(','));
    let (mut worst, mut count) = (0.0_f64, 0);
    for row in rows {
        let numbers: Vec<f64> = row.split(',').map(|x| x.parse().unwrap()).collect();
        let vector = |at: usize| Tangent::<G::Scalar, D>::from_fn(|i, _| G::Scalar::lit(numbers[at + i]));
        let truth = SMatrix::<f64, D, D>::from_row_slice(&numbers[2 * D..]);
        let found = G::right_jacobian_derivative(&vector(0), &vector(D)).map(Real::value);
        worst = worst.max((found - truth).amax() / truth.amax() / G::Scalar::EPSILON);
        count += 1;
    }
    assert_eq!(count, 9, "{group}");
    worst
}

macro_rules! accurate {
    ($($name:ident: $group:ident, $d:literal, $bound:literal;)*) => { $(
        #[test]
        fn $name() {
            let name = stringify!($name);
            let (double, single) = (worst::<$group<f64>, $d>(name), worst::<$group<f32>, $d>(name));
            println!("{name}: f64 {double:.1} ε, f32 {single:.1} ε");
            assert!(double <= $bound && single <= $bound, "{name}: f64 {double:.1} ε, f32 {single:.1} ε");
        }
    )* };
}

mod derivative_of_the_right_jacobian_is_right_to_the_last_digits_on {
    use super::*;
    accurate! {
        so3: SO3, 3, 2.0;
        se2: SE2, 3, 2.0;
        se3: SE3, 6, 3.0;
        se23: SE23, 9, 3.0;
        sgal3: SGal3, 10, 4.0;
        sim2: Sim2, 4, 4.0;
        sim3: Sim3, 7, 4.0;
    }
}

/// Numbers in (−1, 1), the same in every run.
fn draw<const D: usize>(seed: usize) -> Tangent<f64, D> {
    Tangent::from_fn(|i, _| {
        let z = ((seed * 64 + i + 1) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let z = (z ^ (z >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (z >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    })
}

/// What every group must fulfil, whether it has a closed form or not.
fn laws<G: LieGroup<D, Scalar = f64>, const D: usize>() {
    for (k, length) in [0.0, 1e-12, 1e-6, 1e-3, 0.1, 0.5, 1.0, 2.0, 3.0].into_iter().enumerate() {
        let (tau, u, v) = (draw::<D>(k).normalize() * length, draw::<D>(k + 20), draw::<D>(k + 40));
        let name = std::any::type_name::<G>();
        let close = |law: &str, a: &Jacobian<f64, D>, b: &Jacobian<f64, D>, bound: f64| {
            let error = (a - b).amax();
            assert!(error <= bound * (1.0 + b.amax()), "{law}, {name}, |τ| = {length}: {error:.1e}");
        };
        let d = |w: &Tangent<f64, D>| G::right_jacobian_derivative(&tau, w);
        let bound = 64.0 * f64::EPSILON;
        close("linear in δ", &d(&(u * 2.0 - v)), &(d(&u) * 2.0 - d(&v)), bound);
        let h = 1.0 / 1024.0; // h⁴/30 ≈ ε/h ≈ 2e-13; the difference's own constants 30-fold
        let at = |w: &Tangent<f64, D>, s: f64| G::right_jacobian(&(tau + w * s));
        let right = ((at(&u, h) - at(&u, -h)) * 8.0 - (at(&u, 2.0 * h) - at(&u, -2.0 * h))) / (12.0 * h);
        close("d J_r/dt", &d(&u), &right, 6e-12);
        let at = |w: &Tangent<f64, D>, s: f64| G::right_jacobian_inverse(&(tau + w * s));
        let inverse = ((at(&u, h) - at(&u, -h)) * 8.0 - (at(&u, 2.0 * h) - at(&u, -2.0 * h))) / (12.0 * h);
        close("d J_r⁻¹/dt", &G::right_jacobian_inverse_derivative(&tau, &u), &inverse, 6e-12);
        // The curvature of Exp: ∂(J_r u)/∂τ along v, less the same with u and v exchanged, is −[J_r u, J_r v] (Maurer, Cartan).
        let j = G::right_jacobian(&tau);
        let asymmetry = d(&v) * u - d(&u) * v;
        let bracket = G::bracket(&(j * v), &(j * u));
        let error = (asymmetry + bracket).amax();
        assert!(error <= bound * (1.0 + bracket.amax()), "Maurer and Cartan, {name}, {length}: {error:.1e}");
    }
}

/// The Hessian of ½τᵀΩτ by second differences of its value, which know no Jacobian.
fn hessian<G: LieGroup<D, Scalar = f64>, const D: usize>() {
    for k in 0..6 {
        let x = G::exp(&(draw::<D>(k).normalize() * (0.1 + 0.4 * k as f64)));
        let l = SMatrix::<f64, D, D>::from_fn(|i, j| ((i * i + 3 * i * j + j + k) as f64).sin());
        let information = l * l.transpose();
        let closed = squared_norm_hessian::<G, D>(&x.log(), &information);
        let h = 1.0 / 512.0; // h⁴ ≈ 2e-11, ε/h² ≈ 6e-11, of a cost of a few hundred
        for i in 0..D {
            for j in 0..D {
                let value = |s: f64, t: f64| {
                    let step = Tangent::<f64, D>::from_fn(|r, _| {
                        f64::from(u8::from(r == i)) * s + f64::from(u8::from(r == j)) * t
                    });
                    let tau = x.rplus(&step).log();
                    0.5 * tau.dot(&(information * tau))
                };
                let mixed =
                    |h: f64| (value(h, h) - value(h, -h) - value(-h, h) + value(-h, -h)) / (4.0 * h * h);
                let error = (4.0 * mixed(h) - mixed(2.0 * h)) / 3.0 - closed[(i, j)];
                let bound = 2e-8 * (1.0 + closed.amax());
                assert!(error.abs() < bound, "({i}, {j}) of {}: {error:.1e}", std::any::type_name::<G>());
            }
        }
        assert!((closed - closed.transpose()).amax() <= 64.0 * f64::EPSILON * closed.amax());
    }
}

#[cfg(feature = "autodiff")]
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

#[cfg(feature = "autodiff")]
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
                    // Above the switch of Log at θ = 2e-3, √n² differentiated twice leaves ε/n, n = sin(θ/2).
                    let root = if angle > 1e-3 { 8.0 * f64::EPSILON / (0.5 * angle).sin() } else { 0.0 };
                    let bound = 512.0 * f64::EPSILON * (1.0 + first.amax()) * (1.0 + second.amax()) + root;
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

/// Truncations fall short by the power they say: halving the tangents divides the error by 2ⁿ⁺¹.
fn bch<G: LieGroup<D, Scalar = f64>, const D: usize>(a: &Tangent<f64, D>, b: &Tangent<f64, D>) {
    let name = std::any::type_name::<G>();
    let slope = |what: &str, order: f64, error: &dyn Fn(f64) -> f64| {
        let (coarse, fine) = (error(1.0 / 16.0), error(1.0 / 32.0));
        // Groups in which a and b commute, or nearly, have no error to speak of.
        if fine > 1e-12 {
            let measured = (coarse / fine).log2();
            assert!(measured > order - 0.25, "{what}, {name}: slope {measured:.2}, not {order}");
        } else {
            assert!(coarse < 1e-9, "{what}, {name}: {coarse:.1e} and then {fine:.1e}");
        }
    };
    let orders = [BchOrder::First, BchOrder::Second, BchOrder::Third, BchOrder::Fourth];
    for (n, order) in orders.into_iter().enumerate() {
        let error = |s: f64| (G::bch(&(a * s), &(b * s)) - G::bch_series(&(a * s), &(b * s), order)).norm();
        slope("series", n as f64 + 2.0, &error);
    }
    slope("a small", 2.0, &|s| (G::bch(&(a * s), b) - G::bch_small_first(&(a * s), b)).norm());
    slope("b small", 2.0, &|s| (G::bch(a, &(b * s)) - G::bch_small_second(a, &(b * s))).norm());

    let (c, d_a, d_b) = G::bch_jac(a, b);
    assert!((c - G::bch(a, b)).norm() < 16.0 * f64::EPSILON * (1.0 + c.norm()));
    let h = 1.0 / 1024.0;
    for i in 0..D {
        let difference = |f: &dyn Fn(&Tangent<f64, D>) -> Tangent<f64, D>| {
            let at = |s: f64| f(&Tangent::from_fn(|k, _| if k == i { s * h } else { 0.0 }));
            ((at(1.0) - at(-1.0)) * 8.0 - (at(2.0) - at(-2.0))) / (12.0 * h)
        };
        let off = (difference(&|u| G::bch(&(a + u), b)) - d_a.column(i)).amax();
        assert!(off < 6e-12 * (1.0 + d_a.amax()), "∂c/∂a, {name}: {off:.1e}");
        let off = (difference(&|u| G::bch(a, &(b + u))) - d_b.column(i)).amax();
        assert!(off < 6e-12 * (1.0 + d_b.amax()), "∂c/∂b, {name}: {off:.1e}");
    }
}

/// Generic tangents, and tangents whose rotation is along their translation, where a wrong coupling hides.
fn bch_of<G: LieGroup<D, Scalar = f64>, const D: usize>(at: usize, n: usize) {
    for k in 0..4 {
        let (a, b) = (draw::<D>(k + 3).normalize(), draw::<D>(k + 50).normalize());
        bch::<G, D>(&a, &b);
        if at > 0 && D > at {
            let parallel = |mut t: Tangent<f64, D>| {
                for i in 0..n.min(at) {
                    t[i] = t[at + i] * 0.7;
                }
                t
            };
            bch::<G, D>(&parallel(a), &parallel(b));
            bch::<G, D>(&parallel(a), &b);
        }
    }
}

macro_rules! groups {
    ($($name:ident: $group:ident<$($n:literal)?>, $d:literal, $at:literal, $k:literal;)*) => { $(
        mod $name {
            use super::*;
            #[test]
            fn right_jacobian_derivative_obeys_its_laws() {
                laws::<$group<$($n,)? f64>, $d>();
            }
            #[test]
            fn squared_norm_hessian_is_that_of_differences() {
                hessian::<$group<$($n,)? f64>, $d>();
            }
            #[cfg(feature = "autodiff")]
            #[test]
            fn right_jacobian_derivative_is_that_of_dual_numbers() {
                dual::agrees::<$group<$($n,)? f64>, $d>($at, $k);
            }
            #[cfg(feature = "autodiff")]
            #[test]
            fn second_derivatives_of_exp_and_log_are_right_at_0_at_switches_and_at_pi() {
                second_order_dual::agrees::<$group<$($n,)? f64>, $d>($at, $k);
            }
            #[test]
            fn bch_series_has_the_order_it_says() {
                bch_of::<$group<$($n,)? f64>, $d>($at, $k);
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
