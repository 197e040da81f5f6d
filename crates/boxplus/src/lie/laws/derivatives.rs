//! The derivatives of every operation.

use super::Verdict;
use super::sample::{Sample, close, difference, difference_error, largest, rounding, same};
use crate::lie::{LeftJacobians, LieGroup, Real};
use nalgebra::SVector;

/// Every `_jac` returns the value of the plain operation and its derivative, by central differences.
pub(super) fn right_derivatives<G: LieGroup<D>, const D: usize>(s: &Sample<G, D>) -> Verdict {
    // Y near X, so that the differences of Log stay off the cut.
    let (a, b, x, y) = (&s.a, &s.b, &s.x, &s.x.rplus(&s.b));
    let (t, h) = (G::Scalar::lit(0.3), difference_error::<G::Scalar>() * s.scale);
    let bound = rounding::<G::Scalar>() * s.scale;

    let (v, d_x) = x.inverse_jac();
    same("inverse_jac", &v, &x.inverse(), bound)?;
    close("inverse_jac", &d_x, &difference(|u| x.rplus(u).inverse().rminus(&v)), h)?;
    let (v, d_x, d_y) = x.compose_jac(y);
    same("compose_jac", &v, &x.compose(y), bound)?;
    close("compose_jac, first", &d_x, &difference(|u| x.rplus(u).compose(y).rminus(&v)), h)?;
    close("compose_jac, second", &d_y, &difference(|u| x.compose(&y.rplus(u)).rminus(&v)), h)?;
    let (v, d_x, d_y) = x.between_jac(y);
    same("between_jac", &v, &x.between(y), bound)?;
    close("between_jac, first", &d_x, &difference(|u| x.rplus(u).between(y).rminus(&v)), h)?;
    close("between_jac, second", &d_y, &difference(|u| x.between(&y.rplus(u)).rminus(&v)), h)?;
    let (v, d_a) = G::exp_jac(a);
    same("exp_jac", &v, x, bound)?;
    close("exp_jac", &d_a, &difference(|u| G::exp(&(a + u)).rminus(&v)), h)?;
    let (v, d_x) = x.log_jac();
    close("log_jac", &v, &x.log(), bound)?;
    close("log_jac", &d_x, &difference(|u| x.rplus(u).log()), h)?;

    let (v, d_x, d_b) = x.rplus_jac(b);
    same("rplus_jac", &v, &x.rplus(b), bound)?;
    close("rplus_jac, element", &d_x, &difference(|u| x.rplus(u).rplus(b).rminus(&v)), h)?;
    close("rplus_jac, tangent", &d_b, &difference(|u| x.rplus(&(b + u)).rminus(&v)), h)?;
    let (v, d_y, d_x) = y.rminus_jac(x);
    close("rminus_jac", &v, &y.rminus(x), bound)?;
    close("rminus_jac, first", &d_y, &difference(|u| y.rplus(u).rminus(x)), h)?;
    close("rminus_jac, base", &d_x, &difference(|u| y.rminus(&x.rplus(u))), h)?;
    let (v, d_x, d_b) = x.lplus_jac(b);
    same("lplus_jac", &v, &x.lplus(b), bound)?;
    close("lplus_jac, element", &d_x, &difference(|u| x.rplus(u).lplus(b).rminus(&v)), h)?;
    close("lplus_jac, tangent", &d_b, &difference(|u| x.lplus(&(b + u)).rminus(&v)), h)?;
    let (v, d_y, d_x) = y.lminus_jac(x);
    close("lminus_jac", &v, &y.lminus(x), bound)?;
    close("lminus_jac, first", &d_y, &difference(|u| y.rplus(u).lminus(x)), h)?;
    close("lminus_jac, base", &d_x, &difference(|u| y.lminus(&x.rplus(u))), h)?;

    let (v, d_x, d_t) = x.power_jac(t);
    same("power_jac", &v, &x.power(t), bound)?;
    close("power_jac, element", &d_x, &difference(|u| x.rplus(u).power(t).rminus(&v)), h)?;
    close("power_jac, exponent", &d_t, &difference(|u: &SVector<_, 1>| x.power(t + u.x).rminus(&v)), h)?;
    let (v, d_x, d_y, d_t) = x.interpolate_jac(y, t);
    same("interpolate_jac", &v, &x.interpolate(y, t), bound)?;
    close("interpolate_jac, X", &d_x, &difference(|u| x.rplus(u).interpolate(y, t).rminus(&v)), h)?;
    close("interpolate_jac, Y", &d_y, &difference(|u| x.interpolate(&y.rplus(u), t).rminus(&v)), h)?;
    close(
        "interpolate_jac, t",
        &d_t,
        &difference(|u: &SVector<_, 1>| x.interpolate(y, t + u.x).rminus(&v)),
        h,
    )
}

/// Every left Jacobian is the right one converted by adjoints, to rounding.
pub(super) fn left_derivatives<G: LieGroup<D>, const D: usize>(s: &Sample<G, D>) -> Verdict {
    let (a, b, x, y) = (&s.a, &s.b, &s.x, &s.x.rplus(&s.b));
    let t = G::Scalar::lit(0.3);
    let inverses = largest(&G::right_jacobian_inverse(a)) + largest(&G::right_jacobian_inverse(b));
    let bound = rounding::<G::Scalar>() * s.scale * s.scale * (1.0 + inverses);

    let ((v, left), (_, right)) = (x.inverse_left_jac(), x.inverse_jac());
    close("inverse_left_jac", &left, &v.output_to_left(&x.input_to_left(&right)), bound)?;
    let ((v, l_x, l_y), (_, r_x, r_y)) = (x.compose_left_jac(y), x.compose_jac(y));
    close("compose_left_jac, first", &l_x, &v.output_to_left(&x.input_to_left(&r_x)), bound)?;
    close("compose_left_jac, second", &l_y, &v.output_to_left(&y.input_to_left(&r_y)), bound)?;
    let ((v, l_x, l_y), (_, r_x, r_y)) = (x.between_left_jac(y), x.between_jac(y));
    close("between_left_jac, first", &l_x, &v.output_to_left(&x.input_to_left(&r_x)), bound)?;
    close("between_left_jac, second", &l_y, &v.output_to_left(&y.input_to_left(&r_y)), bound)?;
    let ((v, left), (_, right)) = (G::exp_left_jac(a), G::exp_jac(a));
    close("exp_left_jac", &left, &v.output_to_left(&right), bound)?;
    let ((_, left), (_, right)) = (x.log_left_jac(), x.log_jac());
    close("log_left_jac", &left, &x.input_to_left(&right), bound)?;

    let ((v, l_x, l_b), (_, r_x, r_b)) = (x.rplus_left_jac(b), x.rplus_jac(b));
    close("rplus_left_jac, element", &l_x, &v.output_to_left(&x.input_to_left(&r_x)), bound)?;
    close("rplus_left_jac, tangent", &l_b, &v.output_to_left(&r_b), bound)?;
    let ((_, l_y, l_x), (_, r_y, r_x)) = (y.rminus_left_jac(x), y.rminus_jac(x));
    close("rminus_left_jac, first", &l_y, &y.input_to_left(&r_y), bound)?;
    close("rminus_left_jac, base", &l_x, &x.input_to_left(&r_x), bound)?;
    let ((v, l_x, l_b), (_, r_x, r_b)) = (x.lplus_left_jac(b), x.lplus_jac(b));
    close("lplus_left_jac, element", &l_x, &v.output_to_left(&x.input_to_left(&r_x)), bound)?;
    close("lplus_left_jac, tangent", &l_b, &v.output_to_left(&r_b), bound)?;
    let ((_, l_y, l_x), (_, r_y, r_x)) = (y.lminus_left_jac(x), y.lminus_jac(x));
    close("lminus_left_jac, first", &l_y, &y.input_to_left(&r_y), bound)?;
    close("lminus_left_jac, base", &l_x, &x.input_to_left(&r_x), bound)?;

    let ((v, l_x, l_t), (_, r_x, r_t)) = (x.power_left_jac(t), x.power_jac(t));
    close("power_left_jac, element", &l_x, &v.output_to_left(&x.input_to_left(&r_x)), bound)?;
    close("power_left_jac, exponent", &l_t, &v.output_to_left(&r_t), bound)?;
    let ((v, l_x, l_y, l_t), (_, r_x, r_y, r_t)) = (x.interpolate_left_jac(y, t), x.interpolate_jac(y, t));
    close("interpolate_left_jac, X", &l_x, &v.output_to_left(&x.input_to_left(&r_x)), bound)?;
    close("interpolate_left_jac, Y", &l_y, &v.output_to_left(&y.input_to_left(&r_y)), bound)?;
    close("interpolate_left_jac, t", &l_t, &v.output_to_left(&r_t), bound)?;
    close("right again, input", &x.input_to_right(&x.input_to_left(&r_x)), &r_x, bound)?;
    close("right again, output", &v.output_to_right(&v.output_to_left(&r_x)), &r_x, bound)
}
