//! The bi-invariant mean.

use super::sample::{Sample, close, largest, rounding, same};
use super::{Verdict, Violation};
use crate::lie::{LieGroup, Means, Real, Weights};
use nalgebra::{SMatrix, SVector};

/// The mean of three close elements: its definition, its invariances, and that of two.
pub(super) fn mean_of_few<G: LieGroup<D>, const D: usize>(s: &Sample<G, D>) -> Verdict {
    let part = |t: f64| s.b * G::Scalar::lit(t);
    let data = [s.x, s.x.rplus(&part(0.4)), s.x.rplus(&(s.c * G::Scalar::lit(0.4)))];
    let w = G::exp(&part(1.0));
    let bound = 4.0 * rounding::<G::Scalar>() * s.scale * s.scale;
    let m = reached(G::mean(&data, Weights::Equal))?;
    let logarithms = data.iter().fold(SVector::zeros(), |sum, x| sum + x.rminus(&m.value));
    close("Σ Log(M⁻¹X) = 0", &logarithms, &SVector::zeros(), bound)?;
    same("the mean is left-invariant", &of(data.map(|x| w.compose(&x)))?, &w.compose(&m.value), bound)?;
    same("the mean is right-invariant", &of(data.map(|x| x.compose(&w)))?, &m.value.compose(&w), bound)?;
    same("the mean of inverses is the inverse", &of(data.map(|x| x.inverse()))?, &m.value.inverse(), bound)?;
    let [x, y, z] = data;
    same("the mean does not know an order", &of([z, x, y])?, &m.value, bound)?;
    let middle = x.interpolate(&y, G::Scalar::lit(0.5));
    same("the mean of two is their midpoint", &of([x, y])?, &middle, bound)?;
    same("the mean of one is itself", &of([x])?, &x, bound)?;
    // Moving all data alike on the left moves the mean alike, hence its derivatives add up to that motion.
    let left = |g: &G| g.inverse().adjoint();
    let third = G::Scalar::lit(1.0 / 3.0);
    let sum = data.iter().try_fold(SMatrix::zeros(), |sum, x| Some(sum + m.jac(x, third)? * left(x)));
    let sum = sum.ok_or(Violation { law: "a mean follows its elements", ..NO_MEAN })?;
    let size = 1.0 + largest(&left(&m.value));
    close("Σ ∂M/∂X = ∂M", &sum, &left(&m.value), bound * size)
}

const NO_MEAN: Violation =
    Violation { law: "close elements have a mean", error: f64::NAN, bound: 0.0, sample: 0 };

fn of<G: LieGroup<D>, const D: usize, const N: usize>(data: [G; N]) -> Result<G, Violation> {
    reached(G::mean(&data, Weights::Equal)).map(|m| m.value)
}

fn reached<T, E>(mean: Result<T, E>) -> Result<T, Violation> {
    mean.map_err(|_| NO_MEAN)
}
