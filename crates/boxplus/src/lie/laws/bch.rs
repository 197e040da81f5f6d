//! The formula of Baker, Campbell and Hausdorff: statements with an order of error, tested by their slope.

use super::Verdict;
use super::sample::{Sample, close, difference, difference_error, judge, largest, tangent};
use crate::lie::{Bch, BchOrder, LieGroup, Real};

/// Log(Exp a·Exp b) and its Jacobians.
pub(super) fn composition_of_tangents<G: LieGroup<D>, const D: usize>(s: &Sample<G, D>) -> Verdict {
    let (a, b) = (&s.a, &(s.b * G::Scalar::lit(0.5)));
    // Near the cut Log may jump by a turn between the points of a difference; inverse Jacobians there are large.
    let turn = largest(&G::right_jacobian_inverse(&G::bch(a, b)));
    let h = difference_error::<G::Scalar>() * s.scale * (1.0 + turn);
    let (c, d_a, d_b) = G::bch_jac(a, b);
    close("bch_jac value", &c, &G::bch(a, b), 0.0)?;
    close("bch_jac, first", &d_a, &difference(|u| G::bch(&(a + u), b)), h)?;
    close("bch_jac, second", &d_b, &difference(|u| G::bch(a, &(b + u))), h)
}

/// Halving the arguments divides the error by 2ⁿ.
pub(super) fn orders_of_error<G: LieGroup<D, Scalar = f64>, const D: usize>(sample: usize) -> Verdict {
    // Neighbours in the cycle of lengths: where one of them is tiny, terms of high order are, too, and nothing is seen of them.
    let (a, b) = (tangent::<f64, D>(sample, 3, 0.8), tangent::<f64, D>(sample + 1, 4, 0.8));
    let series = |order| {
        move |s: f64| largest(&(G::bch(&(a * s), &(b * s)) - G::bch_series(&(a * s), &(b * s), order)))
    };
    slope("Log(Exp a·Exp b) = a + b + O(2)", 2, series(BchOrder::First))?;
    slope("… + ½[a, b] + O(3)", 3, series(BchOrder::Second))?;
    slope("… + (1/12)([a, [a, b]] + [b, [b, a]]) + O(4)", 4, series(BchOrder::Third))?;
    slope("… − (1/24)[b, [a, [a, b]]] + O(5)", 5, series(BchOrder::Fourth))?;
    let small = |s: f64| largest(&(G::bch(&(a * s), &b) - G::bch_small_first(&(a * s), &b)));
    slope("Log(Exp(δ)·Exp(b)) = b + J_l⁻¹(b)·δ + O(δ²)", 2, small)?;
    let small = |s: f64| largest(&(G::bch(&a, &(b * s)) - G::bch_small_second(&a, &(b * s))));
    slope("Log(Exp(a)·Exp(δ)) = a + J_r⁻¹(a)·δ + O(δ²)", 2, small)?;
    let (first, x) = (G::right_jacobian_inverse(&a) * b, G::exp(&a));
    let second = G::right_jacobian_inverse_derivative(&a, &first) * b * 0.5;
    let small = |s: f64| largest(&(G::bch(&a, &(b * s)) - a - first * s - second * (s * s)));
    slope("Log(Exp(a)·Exp(δ)) = a + w + ½·DJ_r⁻¹(a)[w]·δ + O(δ³), w = J_r⁻¹(a)·δ", 3, small)?;
    let small = |s: f64| largest(&(G::exp(&(a + b * s)).rminus(&x) - G::right_jacobian(&a) * b * s));
    slope("Exp(a + δ) = Exp(a)·Exp(J_r(a)·δ + O(δ²))", 2, small)
}

/// Fails unless `error(s)` vanishes like s^order: halving s divides it by 2^order, up to the share of the next order.
pub(super) fn slope(law: &'static str, order: i32, error: impl Fn(f64) -> f64) -> Verdict {
    const STEP: f64 = 1.0 / 16.0;
    let (coarse, fine) = (error(STEP), error(STEP / 2.0));
    // Next-order terms change the error by a factor 1 ± O(s) each; below 1e-12 rounding takes over.
    let allowed = coarse * 1.5 / f64::from(1 << order) + 1e-12;
    judge(law, fine, allowed)
}
