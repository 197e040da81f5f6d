//! The laws of a Lie group as a test suite: one line for any group, a user's own included.
//!
//! ```
//! use boxplus::lie::{SE3, laws};
//! laws::check_group::<SE3, 6>()?;
//! laws::check_action::<SE3, 6, 3>()?;
//! # Ok::<(), laws::Violation>(())
//! ```
//!
//! A new group is right when its required items are consistent, and each law couples several of them: the axioms
//! couple compose and inverse, J_l = Σ ad^k/(k+1)! couples the Jacobian with ad, Exp(Ad_X τ) = X·Exp(τ)·X⁻¹ couples Ad
//! with Exp, central differences couple every `_jac` with its value. Tangents are drawn generic and along axes, from 0 and
//! 10⁻¹² up to `radius`; nothing is compared looser than rounding allows: bounds are multiples of ε of the scalar times
//! the adjoints involved, central differences of order h⁴ with h = ε^{1/5} hold ε^{4/5}, and statements with an error order
//! (Baker–Campbell–Hausdorff) are tested by their slope.
//!
//! [`check_embedding`] holds a homomorphism to the same, such as that of a subgroup. `docs/properties.md` lists every property
//! checked of the built-in groups, and where; what a suite of laws cannot see is the last digit, for which they have
//! reference tables.

mod bch;
mod derivatives;
mod embedding;
mod means;
mod sample;
mod second_order;

pub use embedding::check_embedding;

use super::{Action, LeftJacobians, LieGroup, Manifold, PointJac, Real, Tangent};
use bch::{composition_of_tangents, orders_of_error};
use derivatives::{left_derivatives, right_derivatives};
use means::mean_of_few;
use nalgebra::{SMatrix, SVector};
use sample::{
    LENGTHS, ROUNDS, Sample, bernoulli_series, close, difference, difference_error, draw, largest,
    power_series, rounding, same, tangent,
};
use second_order::{jacobian_derivatives, squared_distance};

/// A law that does not hold, and by how much.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{law}: the sides differ by {error:.1e}, rounding explains {bound:.1e} (sample {sample})")]
pub struct Violation {
    /// The law.
    pub law: &'static str,
    /// Largest entry of the difference.
    pub error: f64,
    /// Largest entry that rounding explains.
    pub bound: f64,
    /// Number of the sample; samples are the same in every run.
    pub sample: usize,
}

/// What a law answers.
type Verdict = Result<(), Violation>;

/// Tangents as long as this stay inside the cut locus of every rotation, central differences included.
const RADIUS: f64 = 3.0;
/// All laws of a group, for tangents up to length 3.
///
/// # Errors
/// The first law that does not hold.
pub fn check_group<G: LieGroup<D>, const D: usize>() -> Verdict {
    check_group_within::<G, D>(RADIUS)
}

/// All laws of a group, for tangents up to length `radius`: where Log inverts Exp.
///
/// # Errors
/// The first law that does not hold.
pub fn check_group_within<G: LieGroup<D>, const D: usize>(radius: f64) -> Verdict {
    // Law by law, the simplest first: the one reported is then the nearest to the cause.
    let laws = [axioms, exponential, algebra, adjoint, jacobians, steps, curves];
    let derivatives = [right_derivatives, left_derivatives, double_twin];
    let further = [composition_of_tangents, jacobian_derivatives, mean_of_few];
    for law in laws.into_iter().chain(derivatives).chain(further) {
        each_sample(|sample| law(&Sample::<G, D>::new(sample, radius)))?;
    }
    each_sample(orders_of_error::<G::Over<f64>, D>)?;
    each_sample(squared_distance::<G::Over<f64>, D>)
}

/// The laws of an action on ℝᴺ.
///
/// # Errors
/// The first law that does not hold.
pub fn check_action<G: Action<D, N>, const D: usize, const N: usize>() -> Verdict {
    each_sample(|sample| {
        let s = Sample::<G, D>::new(sample, RADIUS);
        let p = draw::<G::Scalar, N>(sample, 5);
        let d = draw::<G::Scalar, N>(sample, 6);
        let (x, y, xy) = (s.x, s.y, s.x.compose(&s.y));
        let bound = rounding::<G::Scalar>() * s.scale;
        close("e·p = p", &G::identity().act(&p), &p, 0.0)?;
        close("(XY)·p = X·(Y·p)", &xy.act(&p), &x.act(&y.act(&p)), bound)?;
        close("X⁻¹·(X·p) = p", &x.act_inverse(&x.act(&p)), &p, bound)?;
        close("an action is affine", &x.act_direction(&d), &(x.act(&(p + d)) - x.act(&p)), bound)?;
        action_derivatives(&s, &p, ["act_jac", "act_left_jac"], G::act, [G::act_jac, G::act_left_jac])?;
        let jacobians = [G::act_inverse_jac, G::act_inverse_left_jac];
        action_derivatives(&s, &p, ["act_inverse_jac", "act_inverse_left_jac"], G::act_inverse, jacobians)?;
        let jacobians = [G::act_direction_jac, G::act_direction_left_jac];
        action_derivatives(
            &s,
            &p,
            ["act_direction_jac", "act_direction_left_jac"],
            G::act_direction,
            jacobians,
        )
    })
}

/// The right Jacobian by central differences, the left one by conversion.
fn action_derivatives<G: Action<D, N>, const D: usize, const N: usize>(
    s: &Sample<G, D>,
    p: &SVector<G::Scalar, N>,
    laws: [&'static str; 2],
    act: impl Fn(&G, &SVector<G::Scalar, N>) -> SVector<G::Scalar, N>,
    [right, left]: [fn(&G, &SVector<G::Scalar, N>) -> PointJac<G, D, N>; 2],
) -> Verdict {
    let (x, h) = (&s.x, difference_error::<G::Scalar>() * s.scale);
    let bound = rounding::<G::Scalar>() * s.scale;
    let (value, d_x, d_p) = right(x, p);
    close(laws[0], &value, &act(x, p), bound)?;
    close(laws[0], &d_x, &difference(|t| act(&x.rplus(t), p)), h)?;
    close(laws[0], &d_p, &difference(|t| act(x, &(p + t))), h)?;
    let (left_value, left_x, left_p) = left(x, p);
    close(laws[1], &left_value, &value, bound)?;
    close(laws[1], &left_x, &x.input_to_left(&d_x), bound)?;
    close(laws[1], &left_p, &d_p, bound)
}

/// The axioms of ⊞ and ⊟ and their Jacobians at the given elements, for tangents up to length `radius`.
///
/// # Errors
/// The first law that does not hold.
pub fn check_manifold<M: Manifold<D>, const D: usize>(elements: &[M], radius: f64) -> Verdict {
    each_sample(|sample| {
        let Some(x) = elements.get(sample % elements.len().max(1)) else { return Ok(()) };
        let tau = tangent::<M::Scalar, D>(sample, 0, radius);
        let y = x.plus(&tau);
        let (h, bound) = (difference_error::<M::Scalar>(), rounding::<M::Scalar>() * (1.0 + radius));
        close("(X ⊞ τ) ⊟ X = τ", &y.minus(x), &tau, bound)?;
        close("X ⊞ (Y ⊟ X) = Y", &x.plus(&y.minus(x)).minus(&y), &SVector::zeros(), bound)?;
        let (value, d_x, d_tau) = x.plus_jac(&tau);
        close("plus_jac value", &value.minus(&y), &SVector::zeros(), bound)?;
        close("plus_jac in X", &d_x, &difference(|t| x.plus(t).plus(&tau).minus(&y)), h)?;
        close("plus_jac in τ", &d_tau, &difference(|t| x.plus(&(tau + t)).minus(&y)), h)?;
        let (value, d_y, d_x) = y.minus_jac(x);
        close("minus_jac value", &value, &y.minus(x), bound)?;
        close("minus_jac in Y", &d_y, &difference(|t| y.plus(t).minus(x)), h)?;
        close("minus_jac in X", &d_x, &difference(|t| y.minus(&x.plus(t))), h)
    })
}

fn each_sample(check: impl Fn(usize) -> Verdict) -> Verdict {
    (0..ROUNDS * LENGTHS.len())
        .try_for_each(|sample| check(sample).map_err(|violation| Violation { sample, ..violation }))
}

fn axioms<G: LieGroup<D>, const D: usize>(s: &Sample<G, D>) -> Verdict {
    let (x, y, z, e) = (&s.x, &s.y, &s.z, &G::identity());
    let bound = rounding::<G::Scalar>() * s.scale;
    same("e·X = X", &e.compose(x), x, bound)?;
    same("X·e = X", &x.compose(e), x, bound)?;
    same("X·X⁻¹ = e", &x.compose(&x.inverse()), e, bound)?;
    same("X⁻¹·X = e", &x.inverse().compose(x), e, bound)?;
    same("(X⁻¹)⁻¹ = X", &x.inverse().inverse(), x, bound)?;
    same("(XY)Z = X(YZ)", &x.compose(y).compose(z), &x.compose(&y.compose(z)), bound)?;
    same("(XY)⁻¹ = Y⁻¹X⁻¹", &x.compose(y).inverse(), &y.inverse().compose(&x.inverse()), bound)?;
    same("between(X, Y) = X⁻¹Y", &x.between(y), &x.inverse().compose(y), bound)
}

fn exponential<G: LieGroup<D>, const D: usize>(s: &Sample<G, D>) -> Verdict {
    let bound = rounding::<G::Scalar>() * s.scale;
    let part = |t: f64| G::exp(&(s.a * G::Scalar::lit(t)));
    same("Exp 0 = e", &G::exp(&SVector::zeros()), &G::identity(), 0.0)?;
    close("Log e = 0", &G::identity().log(), &SVector::zeros(), 0.0)?;
    close("Log(Exp τ) = τ", &s.x.log(), &s.a, bound)?;
    same("Exp(Log X) = X", &G::exp(&s.x.log()), &s.x, bound)?;
    same("Exp(−τ) = Exp(τ)⁻¹", &G::exp(&-s.a), &s.x.inverse(), bound)?;
    close("Log(X⁻¹) = −Log X", &s.x.inverse().log(), &-s.x.log(), bound)?;
    same("Exp(sτ)·Exp(tτ) = Exp((s + t)τ)", &part(0.375).compose(&part(0.625)), &s.x, bound)
}

fn algebra<G: LieGroup<D>, const D: usize>(s: &Sample<G, D>) -> Verdict {
    let (a, b, c) = (&s.a, &s.b, &s.c);
    let size = |t: &Tangent<G::Scalar, D>| 1.0 + largest(t) + largest(&G::small_adjoint(t));
    let bound = rounding::<G::Scalar>() * size(a) * size(b) * size(c);
    let bracket = G::bracket;
    close("vee(hat(τ)) = τ", &G::vee(&G::hat(a)), a, 0.0)?;
    close("[a, b] = −[b, a]", &bracket(a, b), &-bracket(b, a), bound)?;
    let cyclic = bracket(a, &bracket(b, c)) + bracket(b, &bracket(c, a)) + bracket(c, &bracket(a, b));
    close("Jacobi: [a, [b, c]] + [b, [c, a]] + [c, [a, b]] = 0", &cyclic, &SVector::zeros(), bound)
}

fn adjoint<G: LieGroup<D>, const D: usize>(s: &Sample<G, D>) -> Verdict {
    let (x, y, b, c) = (&s.x, &s.y, &s.b, &s.c);
    let (ad_x, ad) = (x.adjoint(), G::small_adjoint(&s.a));
    let bound = rounding::<G::Scalar>() * s.scale * (1.0 + largest(&s.a));
    close("Ad_e = I", &G::identity().adjoint(), &SMatrix::identity(), 0.0)?;
    close("Ad_{XY} = Ad_X·Ad_Y", &x.compose(y).adjoint(), &(ad_x * y.adjoint()), bound)?;
    close("Ad_{X⁻¹}·Ad_X = I", &(x.inverse().adjoint() * ad_x), &SMatrix::identity(), bound)?;
    same("X·Exp(τ) = Exp(Ad_X τ)·X", &x.rplus(b), &x.lplus(&(ad_x * b)), bound)?;
    close("Ad_X τ without the matrix", &x.adjoint_times(b), &(ad_x * b), bound)?;
    let brackets = (ad_x * G::bracket(b, c), G::bracket(&(ad_x * b), &(ad_x * c)));
    close("Ad_X[b, c] = [Ad_X b, Ad_X c]", &brackets.0, &brackets.1, bound * s.scale)?;
    close("Ad_{Exp τ} = Σ adᵏ/k!", &ad_x, &power_series(&ad, 0), bound)
}

fn jacobians<G: LieGroup<D>, const D: usize>(s: &Sample<G, D>) -> Verdict {
    let (a, x) = (&s.a, &s.x);
    let (identity, ad) = (SMatrix::identity(), G::small_adjoint(a));
    let (right, left) = (G::right_jacobian(a), G::left_jacobian(a));
    let (right_inverse, left_inverse) = (G::right_jacobian_inverse(a), G::left_jacobian_inverse(a));
    let inverses = largest(&right_inverse) + largest(&left_inverse);
    let bound = rounding::<G::Scalar>() * s.scale * (1.0 + largest(a)) * (1.0 + inverses);
    close("J_l = Σ adᵏ/(k + 1)!", &left, &power_series(&ad, 1), bound)?;
    close("J_l(τ) = J_r(−τ)", &left, &G::right_jacobian(&-a), bound)?;
    close("J_l = Ad_{Exp τ}·J_r", &left, &(x.adjoint() * right), bound)?;
    close("J_r·J_r⁻¹ = I", &(right * right_inverse), &identity, bound)?;
    close("J_r⁻¹·J_r = I", &(right_inverse * right), &identity, bound)?;
    close("J_l⁻¹·J_l = I", &(left_inverse * left), &identity, bound)?;
    close("Ad_{Exp τ} = J_l·J_r⁻¹", &x.adjoint(), &(left * right_inverse), bound)?;
    close("J_l⁻¹ = Σ B_k·adᵏ/k!", &left_inverse, &bernoulli_series(&ad), bound)?;
    close("J_r(τ)·τ = τ", &(right * a), a, bound)?;
    close("Ad_{Exp τ} = I + ad·J_l", &x.adjoint(), &(identity + ad * left), bound)?;
    close("ad·J_l = J_l·ad", &(ad * left), &(left * ad), bound)?;
    let half = a * G::Scalar::lit(0.5);
    let doubled = (identity + G::exp(&half).adjoint()) * G::left_jacobian(&half) * G::Scalar::lit(0.5);
    close("J_l(2τ) = ½(I + Ad_{Exp τ})·J_l(τ)", &left, &doubled, bound)?;
    let (tau, r, l) = x.log_jacs();
    close("log_jacs value", &tau, &x.log(), 0.0)?;
    close("log_jacs right", &r, &G::right_jacobian_inverse(&tau), bound)?;
    close("log_jacs left", &l, &G::left_jacobian_inverse(&tau), bound)
}

fn steps<G: LieGroup<D>, const D: usize>(s: &Sample<G, D>) -> Verdict {
    let (x, b) = (&s.x, &s.b);
    let bound = rounding::<G::Scalar>() * s.scale;
    close("(X ⊕ τ) ⊖ X = τ", &x.rplus(b).rminus(x), b, bound)?;
    close("left: (τ ⊕ X) ⊖ X = τ", &x.lplus(b).lminus(x), b, bound)?;
    same("X ⊕ (Y ⊖ X) = Y", &x.rplus(&s.y.rminus(x)), &s.y, bound)?;
    same("left: (Y ⊖ X) ⊕ X = Y", &x.lplus(&s.y.lminus(x)), &s.y, bound)?;
    close("X ⊖ X = 0", &x.rminus(x), &SVector::zeros(), bound)?;
    same("⊞ is right", &x.plus(b), &x.rplus(b), 0.0)?;
    close("⊟ is right", &s.y.minus(x), &s.y.rminus(x), 0.0)
}

fn curves<G: LieGroup<D>, const D: usize>(s: &Sample<G, D>) -> Verdict {
    let (x, w, zero, one) = (&s.x, &s.z, G::Scalar::lit(0.0), G::Scalar::lit(1.0));
    let (y, t) = (&x.rplus(&s.b), G::Scalar::lit(0.3));
    let (z, bound) = (&x.interpolate(y, t), rounding::<G::Scalar>() * s.scale);
    same("interpolation starts at X", &x.interpolate(y, zero), x, bound)?;
    same("interpolation ends at Y", &x.interpolate(y, one), y, bound)?;
    close("interpolation has constant velocity", &z.rminus(x), &(s.b * t), bound)?;
    same("interpolation can be reversed", z, &y.interpolate(x, one - t), bound)?;
    let moved = w.compose(x).interpolate(&w.compose(y), t);
    same("interpolation is left-invariant", &w.compose(z), &moved, bound * s.scale)?;
    let moved = x.compose(w).interpolate(&y.compose(w), t);
    same("interpolation is right-invariant", &z.compose(w), &moved, bound * s.scale)?;
    let inverse = x.inverse().interpolate(&y.inverse(), t);
    same("interpolation commutes with inversion", &z.inverse(), &inverse, bound * s.scale)?;
    let half = G::Scalar::lit(0.5);
    same("the midpoint has no direction", &x.interpolate(y, half), &y.interpolate(x, half), bound)?;
    for t in [-0.5, 1.5].map(G::Scalar::lit) {
        close("interpolation goes on outside [0, 1]", &x.interpolate(y, t).rminus(x), &(s.b * t), bound)?;
    }
    same("X² = X·X", &w.power(G::Scalar::lit(2.0)), &w.compose(w), bound)?;
    same("X⁻¹ is the power −1", &x.power(-one), &x.inverse(), bound)
}

/// The group over `f64` computes the same: what a wrong constant or switch of one scalar type cannot survive.
fn double_twin<G: LieGroup<D>, const D: usize>(s: &Sample<G, D>) -> Verdict {
    let (a, b) = (&s.a.map(Real::value), &s.b.map(Real::value));
    let (x, y) = (s.x.map(Real::value), s.y.map(Real::value));
    let inverses = largest(&G::right_jacobian_inverse(&s.a)) + largest(&G::right_jacobian_inverse(&s.b));
    let bound = rounding::<G::Scalar>() * s.scale * (1.0 + inverses);
    let near = |law, twin: &G::Over<f64>, single: &G| same(law, twin, &single.map(Real::value), bound);
    near("Exp as in f64", &G::Over::<f64>::exp(a), &s.x)?;
    near("compose as in f64", &x.compose(&y), &s.x.compose(&s.y))?;
    close("Log as in f64", &x.log(), &s.x.log().map(Real::value), bound)?;
    let (twin, single) = (G::Over::<f64>::right_jacobian(a), G::right_jacobian(&s.a));
    close("J_r as in f64", &twin, &single.map(Real::value), bound)?;
    let (twin, single) = (G::Over::<f64>::right_jacobian_inverse(b), G::right_jacobian_inverse(&s.b));
    close("J_r⁻¹ as in f64", &twin, &single.map(Real::value), bound)
}
