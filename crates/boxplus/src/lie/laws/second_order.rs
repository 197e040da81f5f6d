//! The derivatives of the Jacobians.

use super::Verdict;
use super::bch::slope;
use super::sample::{Sample, close, difference, difference_error, judge, largest, rounding, tangent};
use crate::lie::second_order::{
    left_jacobian_derivative, right_jacobian_product_derivative, squared_norm_hessian,
};
use crate::lie::{LieGroup, Real};
use nalgebra::{SMatrix, SVector};

/// A derivative along one direction, by central differences.
fn along<S: Real, const D: usize>(f: impl Fn(S) -> SMatrix<S, D, D>) -> SMatrix<S, D, D> {
    // Column by column, for the differences are those of vectors.
    let mut m = SMatrix::<S, D, D>::zeros();
    for k in 0..D {
        let column = difference(|t: &SVector<S, 1>| f(t.x).column(k).into_owned());
        m.set_column(k, &column.column(0));
    }
    m
}

/// DJ_r and DJ_r⁻¹ against differences, against the series of any group, and against the equation of Maurer and Cartan.
pub(super) fn jacobian_derivatives<G: LieGroup<D>, const D: usize>(s: &Sample<G, D>) -> Verdict {
    let (a, b, c) = (&s.a, &s.b, &s.c);
    let (right, inverse) = (G::right_jacobian(a), G::right_jacobian_inverse(a));
    let length = 1.0 + largest(a);
    let size = (1.0 + largest(b)) * (1.0 + largest(c)) * length * length;
    let inverses = 1.0 + largest(&inverse);
    let bound = rounding::<G::Scalar>() * s.scale * size;
    let h = difference_error::<G::Scalar>() * s.scale * size;

    let d_b = G::right_jacobian_derivative(a, b);
    close("DJ_r[δ] is the derivative of J_r", &d_b, &along(|t| G::right_jacobian(&(a + b * t))), h)?;
    close("DJ_r[δ] is that of the series", &d_b, &left_jacobian_derivative::<G, D>(&-a, &-b), bound)?;
    let d_c = G::right_jacobian_derivative(a, c);
    let curl = -G::bracket(&(right * b), &(right * c));
    close("DJ_r[δ]υ − DJ_r[υ]δ = −[J_r δ, J_r υ]", &(d_b * c - d_c * b), &curl, bound)?;
    close("DJ_r[τ]·τ + J_r·τ = τ", &(G::right_jacobian_derivative(a, a) * a), &SVector::zeros(), bound)?;
    let product = right_jacobian_product_derivative::<G, D>(a, c);
    close("∂(J_r·υ)/∂τ·δ = DJ_r[δ]·υ", &(product * b), &(d_b * c), bound)?;

    let d_inverse = G::right_jacobian_inverse_derivative(a, b);
    let wide = bound * inverses * inverses;
    close("DJ_r⁻¹ = −J_r⁻¹·DJ_r·J_r⁻¹", &d_inverse, &(-inverse * d_b * inverse), wide)
}

/// The second-order expansion of the squared distance, by its slope.
pub(super) fn squared_distance<G: LieGroup<D, Scalar = f64>, const D: usize>(sample: usize) -> Verdict {
    let (tau, u) = (tangent::<f64, D>(sample, 3, 2.0), tangent::<f64, D>(sample + 1, 4, 0.8));
    let information = SMatrix::<f64, D, D>::from_fn(|i, j| if i == j { 1.0 + i as f64 } else { 0.25 });
    let x = G::exp(&tau);
    let half_square = |t: &SVector<f64, D>| t.dot(&(information * t)) * 0.5;
    let value = half_square(&tau);
    let gradient = G::right_jacobian_inverse(&tau).tr_mul(&(information * tau));
    let hessian = squared_norm_hessian::<G, D>(&tau, &information);
    let rounded = 1e-14 * (1.0 + largest(&hessian));
    close("the Hessian is symmetric", &hessian, &hessian.transpose(), rounded)?;
    judge("½τᵀΩτ of Log X", (half_square(&x.log()) - value).abs(), 1e-12 * (1.0 + value))?;
    let remainder = |s: f64| {
        let step = u * s;
        let model = value + gradient.dot(&step) + step.dot(&(hessian * step)) * 0.5;
        (half_square(&x.rplus(&step).log()) - model).abs() / (1.0 + value)
    };
    slope("½τᵀΩτ of Log(X·Exp u) = f + gᵀu + ½uᵀHu + O(u³)", 3, remainder)
}
