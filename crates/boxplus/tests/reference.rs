//! Every operation against arbitrary-precision truth (`scripts/reference_tables.py`), in units of ε.
//!
//! Errors are normwise, block by block, so that a large translation cannot hide a wrong rotation. The bounds asserted
//! here are the ones stated in `docs/accuracy.md`; `BOXPLUS_BLESS=1 cargo test --test reference` writes that file.
#![allow(missing_docs, clippy::unwrap_used, clippy::float_cmp)] // exact: is an input representable?

use boxplus::lie::{Action, LieGroup, Real, SE2, SE3, SGal3, SO2, SO3, Sim2, Sim3, Stumpff};
use nalgebra::{Matrix3, Matrix6, SMatrix, SVector, Vector1, Vector2, Vector3, Vector6};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::fmt::Write;

/// What is promised of an operation, for `f32` and `f64` alike.
struct Bound {
    name: &'static str,
    /// What the error is relative to.
    relative_to: &'static str,
    /// The largest error in ε for θ ≤ π.
    principal: f64,
    /// The largest error in ε for θ from π to `LAST`, in multiples of θ/(2π − θ). `NONE` for operations on elements.
    beyond: f64,
}

const NONE: f64 = f64::INFINITY;

const fn bound(name: &'static str, relative_to: &'static str, principal: f64, beyond: f64) -> Bound {
    Bound { name, relative_to, principal, beyond }
}

/// Up to π everything is below 8 ε but e, which enters Q̃ with a small factor only. Measured over eight independent sets
/// of directions, plus a fifth for the trigonometry of other platforms; the coefficients up to π use none. Of the groups
/// after SE(3) six sets were measured, their tables end at π; SE₂(3) is SE(3) bit for bit (`tests/groups`).
const BOUNDS: &[Bound] = &[
    bound("c₁", "the larger of c₁, θc₂", 1.5, 1.5),
    bound("c₂", "itself", 2.0, 2.0),
    bound("c₃", "itself", 1.0, 1.5),
    bound("c₄", "itself", 1.0, 1.5),
    bound("c₅", "itself", 1.0, 1.5),
    bound("c₆", "itself", 1.0, 3.0),
    bound("d", "itself", 3.0, 3.0),
    bound("e", "itself", 32.0, 32.0),
    bound("β₁", "itself", 2.5, 3.0),
    bound("β₂", "itself", 4.0, 4.5),
    bound("SO(2) exp", "1", 0.5, 0.5),
    bound("SO(2) log", "θ", 1.5, NONE),
    bound("SO(2) compose", "1", 1.5, NONE),
    bound("SO(2) act", "p", 2.0, NONE),
    bound("SO(2) rminus", "1 rad", 2.5, NONE),
    bound("SE(2) exp, translation", "t", 3.5, 3.0),
    bound("SE(2) Jr", "each block", 3.0, 2.0),
    bound("SE(2) Jl", "each block", 3.0, 2.0),
    bound("SE(2) Jr⁻¹", "each block", 2.0, 2.5),
    bound("SE(2) Jl⁻¹", "each block", 2.0, 2.5),
    bound("SE(2) log, translation", "ρ", 2.5, NONE),
    bound("SE(2) Ad", "each block", 1.5, NONE),
    bound("SE(2) compose, translation", "the larger translation", 2.5, NONE),
    bound("SE(2) act", "the larger of p, t", 2.5, NONE),
    bound("SE(2) rminus, translation", "ρ", 2.5, NONE),
    bound("SO(3) exp", "1", 2.0, 2.5),
    bound("SO(3) Jr", "itself", 2.5, 2.5),
    bound("SO(3) Jl", "itself", 2.5, 2.5),
    bound("SO(3) Jr⁻¹", "itself", 2.5, 2.5),
    bound("SO(3) Jl⁻¹", "itself", 2.5, 2.5),
    bound("SO(3) log", "φ", 2.0, NONE),
    bound("SO(3) Ad", "itself", 4.5, NONE),
    bound("SO(3) compose", "1", 1.5, NONE),
    bound("SO(3) act", "p", 6.0, NONE),
    bound("SO(3) rminus", "1 rad", 5.5, NONE),
    bound("SE(3) exp, translation", "t", 4.5, 5.0),
    bound("SE(3) Jr, Q block", "itself", 3.0, 5.5),
    bound("SE(3) Jl, Q block", "itself", 3.0, 5.5),
    bound("SE(3) Jr⁻¹, Q̃ block", "itself", 5.0, 11.0),
    bound("SE(3) Jl⁻¹, Q̃ block", "itself", 5.0, 11.0),
    bound("SE(3) log, translation", "ρ", 4.5, NONE),
    bound("SE(3) Ad, t^R block", "itself", 5.0, NONE),
    bound("SE(3) compose, translation", "the larger translation", 6.0, NONE),
    bound("SE(3) act", "the larger of p, t", 4.5, NONE),
    bound("SE(3) rminus, translation", "ρ", 5.5, NONE),
    bound("SGal(3) exp, position", "the larger of ρ, νι", 2.0, NONE),
    bound("SGal(3) Jr, ρφ block", "itself", 4.0, NONE),
    bound("SGal(3) Jr, ρν block", "itself", 3.5, NONE),
    bound("SGal(3) Jr, ρι column", "itself", 2.0, NONE),
    bound("SGal(3) Jl, ρφ block", "itself", 4.0, NONE),
    bound("SGal(3) Jl, ρν block", "itself", 3.5, NONE),
    bound("SGal(3) Jl, ρι column", "itself", 2.0, NONE),
    bound("SGal(3) Jr⁻¹, ρφ block", "itself", 4.5, NONE),
    bound("SGal(3) Jr⁻¹, ρν block", "itself", 2.5, NONE),
    bound("SGal(3) Jr⁻¹, ρι column", "itself", 2.0, NONE),
    bound("SGal(3) Jl⁻¹, ρφ block", "itself", 4.5, NONE),
    bound("SGal(3) Jl⁻¹, ρν block", "itself", 2.5, NONE),
    bound("SGal(3) Jl⁻¹, ρι column", "itself", 2.0, NONE),
    bound("SGal(3) log, position", "the larger of p, vt", 4.5, NONE),
    bound("SGal(3) Ad, (p − vt)^R block", "the larger of p, vt", 5.5, NONE),
    bound("SGal(3) Ad, tR block", "itself", 3.5, NONE),
    bound("SGal(3) compose, position", "the largest of p, vt", 4.0, NONE),
    bound("SGal(3) act, place", "the largest of p, vτ", 5.0, NONE),
    bound("SGal(3) rminus, position", "the largest of Δp, vΔt", 5.0, NONE),
    bound("Sim(3) exp, translation", "t", 3.0, NONE),
    bound("Sim(3) Jr, G block", "itself", 3.0, NONE),
    bound("Sim(3) Jr, S block", "itself", 3.0, NONE),
    bound("Sim(3) Jr, c column", "itself", 3.0, NONE),
    bound("Sim(3) Jl, G block", "itself", 3.0, NONE),
    bound("Sim(3) Jl, S block", "itself", 3.0, NONE),
    bound("Sim(3) Jl, c column", "itself", 3.0, NONE),
    bound("Sim(3) Jr⁻¹, G block", "itself", 3.0, NONE),
    bound("Sim(3) Jr⁻¹, S block", "itself", 4.0, NONE),
    bound("Sim(3) Jr⁻¹, c column", "itself", 4.0, NONE),
    bound("Sim(3) Jl⁻¹, G block", "itself", 3.0, NONE),
    bound("Sim(3) Jl⁻¹, S block", "itself", 4.0, NONE),
    bound("Sim(3) Jl⁻¹, c column", "itself", 4.0, NONE),
    bound("Sim(3) log, translation", "ρ", 3.5, NONE),
    bound("Sim(3) Ad, sR block", "itself", 3.5, NONE),
    bound("Sim(3) Ad, t^R block", "itself", 4.5, NONE),
    bound("Sim(3) Ad, t column", "itself", 0.5, NONE),
    bound("Sim(3) compose, translation", "the larger of t, s·t", 3.5, NONE),
    bound("Sim(3) act", "the larger of s·p, t", 3.5, NONE),
    bound("Sim(3) rminus, translation", "ρ", 5.5, NONE),
    bound("Sim(2) exp, translation", "t", 2.5, NONE),
    bound("Sim(2) Jr, φ₁ block", "itself", 2.0, NONE),
    bound("Sim(2) Jr, columns", "itself", 3.0, NONE),
    bound("Sim(2) Jl, φ₁ block", "itself", 2.0, NONE),
    bound("Sim(2) Jl, columns", "itself", 3.0, NONE),
    bound("Sim(2) Jr⁻¹, φ₁ block", "itself", 2.0, NONE),
    bound("Sim(2) Jr⁻¹, columns", "itself", 3.0, NONE),
    bound("Sim(2) Jl⁻¹, φ₁ block", "itself", 2.0, NONE),
    bound("Sim(2) Jl⁻¹, columns", "itself", 3.0, NONE),
    bound("Sim(2) log, translation", "ρ", 2.5, NONE),
    bound("Sim(2) Ad, sR block", "itself", 1.5, NONE),
    bound("Sim(2) Ad, t columns", "itself", 0.5, NONE),
    bound("Sim(2) compose, translation", "the larger of t, s·t", 2.5, NONE),
    bound("Sim(2) act", "the larger of s·p, t", 2.0, NONE),
    bound("Sim(2) rminus, translation", "ρ", 3.5, NONE),
];

/// A table of the script: named columns of numbers.
struct Table {
    header: Vec<&'static str>,
    rows: Vec<Vec<f64>>,
    inputs: usize,
}

impl Table {
    fn parse(text: &'static str, inputs: usize) -> Self {
        let mut lines = text.lines();
        let header = lines.next().unwrap().split(',').collect();
        let rows = lines.map(|l| l.split(',').map(|x| x.parse().unwrap()).collect()).collect();
        Self { header, rows, inputs }
    }

    /// The rows whose inputs `S` represents exactly.
    fn rows<S: Real>(&self) -> impl Iterator<Item = Row<'_>> {
        let exact = |x: &f64| S::lit(*x).value() == *x;
        let usable = self.rows.iter().filter(move |r| r[..self.inputs].iter().all(exact));
        usable.map(|numbers| Row { header: &self.header, numbers })
    }
}

struct Row<'a> {
    header: &'a [&'static str],
    numbers: &'a [f64],
}

impl Row<'_> {
    /// The numbers of the columns `name0`, `name1`, …
    fn get<const N: usize>(&self, name: &str) -> [f64; N] {
        let first = format!("{name}0");
        let i = self.header.iter().position(|h| **h == first).unwrap();
        std::array::from_fn(|k| self.numbers[i + k])
    }
    fn input<S: Real, const N: usize>(&self, name: &str) -> SVector<S, N> {
        SVector::from(self.get::<N>(name)).map(S::lit)
    }
}

/// The largest errors of each operation, in ε: for θ ≤ π, and beyond in multiples of θ/(2π − θ).
#[derive(Default)]
struct Errors(BTreeMap<String, [f64; 2]>);

impl Errors {
    /// Records |computed − truth|/scale in ε of `S`, and beyond π over the amplification there.
    fn record<S: Real>(&mut self, name: &str, theta: f64, computed: &[S], truth: &[f64], scale: f64) {
        assert_eq!(computed.len(), truth.len());
        let difference = norm(computed.iter().zip(truth).map(|(c, t)| c.value() - t));
        let amplified = (theta / (TAU - theta)).max(1.0);
        let error = if difference == 0.0 { 0.0 } else { difference / scale / S::EPSILON / amplified };
        assert!(!error.is_nan(), "{name} at θ = {theta}: {computed:?}");
        let worst = &mut self.0.entry(name.to_owned()).or_default()[usize::from(theta > PI)];
        *worst = worst.max(error);
    }
    /// Relative to the norm of the truth.
    fn relative<S: Real>(&mut self, name: &str, theta: f64, computed: &[S], truth: &[f64]) {
        self.record(name, theta, computed, truth, norm(truth.iter().copied()));
    }
}

fn norm(x: impl IntoIterator<Item = f64>) -> f64 {
    // Scaled, for translations span twelve decades.
    let x: Vec<f64> = x.into_iter().collect();
    let largest = x.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    if largest == 0.0 { 0.0 } else { largest * x.iter().map(|b| (b / largest).powi(2)).sum::<f64>().sqrt() }
}

/// Jacobians at θ → 2π are poles; the tables go on, the promise ends here.
const LAST: f64 = 6.2;

fn coefficients<S: Real>(table: &Table, errors: &mut Errors) {
    for row in table.rows::<S>().filter(|row| row.numbers[0].sqrt() < LAST) {
        let x = row.numbers[0];
        let c = Stumpff::new(S::lit(x));
        let values = [c.c1, c.c2, c.c3, c.c4, c.c5, c.c6, c.d(), c.e(), c.beta1(), c.beta2()];
        for (k, value) in values.into_iter().enumerate() {
            let (truth, rest) = (row.numbers[1 + 2 * k], row.numbers[2 + 2 * k]);
            // c₁ crosses zero at π; it enters M = c₁I + θc₂[1]× of norm |(c₁, θc₂)|, which does not.
            let scale = if k == 0 { truth.hypot(x.sqrt() * row.numbers[3]) } else { truth.abs() };
            let error = (value.value() - truth) - rest;
            errors.record(BOUNDS[k].name, x.sqrt(), &[S::lit(error)], &[0.0], scale);
        }
    }
}

fn plane<S: Real>(table: &Table, errors: &mut Errors) {
    for row in table.rows::<S>() {
        let tau: Vector3<S> = row.input("tau");
        let theta = tau.z.value().abs();
        if theta < LAST {
            plane_tangent(&row, &tau, theta, errors);
        }
        plane_elements::<S>(&row, errors);
    }
}

fn unit<S: Real>(r: SO2<S>) -> [S; 2] {
    [r.cos(), r.sin()]
}

fn plane_tangent<S: Real>(row: &Row<'_>, tau: &Vector3<S>, theta: f64, errors: &mut Errors) {
    let [c, s, x, y] = row.get("exp");
    errors.record("SO(2) exp", theta, &unit(SO2::exp(&Vector1::new(tau.z))), &[c, s], 1.0);
    errors.relative("SE(2) exp, translation", theta, SE2::exp(tau).translation().as_slice(), &[x, y]);
    let mut jacobian = |name, m: Matrix3<S>, [c, s, x, y]: [f64; 4]| {
        errors.relative(name, theta, &[m.m11, m.m21, m.m12, m.m22], &[c, s, -s, c]);
        errors.relative(name, theta, &[m.m13, m.m23], &[x, y]);
        assert_eq!([m.m31, m.m32, m.m33], [S::zero(), S::zero(), S::one()]);
    };
    jacobian("SE(2) Jl", SE2::left_jacobian(tau), row.get("jl"));
    jacobian("SE(2) Jr", SE2::right_jacobian(&-tau), row.get("jl"));
    jacobian("SE(2) Jl⁻¹", SE2::left_jacobian_inverse(tau), row.get("jl_inv"));
    jacobian("SE(2) Jr⁻¹", SE2::right_jacobian_inverse(&-tau), row.get("jl_inv"));
}

fn plane_elements<S: Real>(row: &Row<'_>, errors: &mut Errors) {
    let pose = |name: &str| {
        let [c, s, x, y] = row.get(name).map(S::lit);
        SE2::from_parts(Vector2::new(x, y), SO2::from_cos_sin(c, s).unwrap())
    };
    let (a, b, p) = (pose("a"), pose("b"), row.input("point"));
    let size = |v: Vector2<S>| v.map(Real::value).norm();

    let [x, y, angle] = row.get("log");
    errors.relative("SO(2) log", 0.0, a.rotation().log().as_slice(), &[angle]);
    errors.relative("SE(2) log, translation", 0.0, &a.log().as_slice()[..2], &[x, y]);

    let ([c, s, x, y], ad) = (row.get("adjoint"), a.adjoint());
    errors.relative("SE(2) Ad", 0.0, &[ad.m11, ad.m21, ad.m12, ad.m22], &[c, s, -s, c]);
    errors.relative("SE(2) Ad", 0.0, &[ad.m13, ad.m23], &[x, y]);

    let ([c, s, x, y], ab) = (row.get("compose"), a.compose(&b));
    errors.record("SO(2) compose", 0.0, &unit(ab.rotation()), &[c, s], 1.0);
    let scale = size(a.translation()).max(size(b.translation()));
    errors.record("SE(2) compose, translation", 0.0, ab.translation().as_slice(), &[x, y], scale);

    errors.relative("SO(2) act", 0.0, a.rotation().act(&p).as_slice(), &row.get::<2>("turned"));
    let scale = size(a.translation()).max(size(p));
    errors.record("SE(2) act", 0.0, a.act(&p).as_slice(), &row.get::<2>("act"), scale);

    let ([x, y, angle], step) = (row.get("rminus"), b.rminus(&a));
    errors.record("SO(2) rminus", 0.0, &[step.z], &[angle], 1.0);
    errors.relative("SE(2) rminus, translation", 0.0, &step.as_slice()[..2], &[x, y]);
}

fn space<S: Real>(table: &Table, errors: &mut Errors) {
    for row in table.rows::<S>() {
        let tau: Vector6<S> = row.input("tau");
        let theta = norm(row.get::<6>("tau")[3..].iter().copied());
        if theta < LAST {
            space_tangent(&row, &tau, theta, errors);
        }
        space_elements::<S>(&row, errors);
    }
}

/// The names of the rotation and the coupling block in `BOUNDS`.
type Names = [&'static str; 2];

/// Both blocks of \[J Q; 0 J\] against 18 numbers, J and Q by rows.
fn blocks<S: Real>(errors: &mut Errors, names: Names, theta: f64, m: &Matrix6<S>, truth: &[f64; 18]) {
    let part = |i, j| -> Matrix3<S> { m.fixed_view::<3, 3>(i, j).transpose() };
    errors.relative(names[0], theta, part(0, 0).as_slice(), &truth[..9]);
    errors.relative(names[1], theta, part(0, 3).as_slice(), &truth[9..]);
    assert_eq!(part(3, 3), part(0, 0));
    assert_eq!(part(3, 0), Matrix3::zeros());
}

fn space_tangent<S: Real>(row: &Row<'_>, tau: &Vector6<S>, theta: f64, errors: &mut Errors) {
    let (truth, x) = (row.get::<7>("exp"), SE3::exp(tau));
    errors.record("SO(3) exp", theta, &x.rotation().quaternion_xyzw(), &truth[..4], 1.0);
    errors.relative("SE(3) exp, translation", theta, x.translation().as_slice(), &truth[4..]);

    let mut jacobian = |names, m: Matrix6<S>, table| blocks(errors, names, theta, &m, &row.get(table));
    jacobian(["SO(3) Jl", "SE(3) Jl, Q block"], SE3::left_jacobian(tau), "jl");
    jacobian(["SO(3) Jr", "SE(3) Jr, Q block"], SE3::right_jacobian(&-tau), "jl");
    jacobian(["SO(3) Jl⁻¹", "SE(3) Jl⁻¹, Q̃ block"], SE3::left_jacobian_inverse(tau), "jl_inv");
    jacobian(["SO(3) Jr⁻¹", "SE(3) Jr⁻¹, Q̃ block"], SE3::right_jacobian_inverse(&-tau), "jl_inv");

    let phi = tau.fixed_rows::<3>(3).into_owned();
    assert_eq!(SO3::exp(&phi), x.rotation());
    let upper = |m: Matrix6<S>| m.fixed_view::<3, 3>(0, 0).into_owned();
    assert_eq!(SO3::right_jacobian(&phi), upper(SE3::right_jacobian(tau)));
    assert_eq!(SO3::right_jacobian_inverse(&phi), upper(SE3::right_jacobian_inverse(tau)));
}

fn space_elements<S: Real>(row: &Row<'_>, errors: &mut Errors) {
    let pose = |name: &str| {
        let [x, y, z, w, t0, t1, t2] = row.get(name).map(S::lit);
        SE3::new(SO3::from_xyzw([x, y, z, w]).unwrap(), Vector3::new(t0, t1, t2))
    };
    let (a, b, p) = (pose("a"), pose("b"), row.input("point"));
    let size = |v: Vector3<S>| v.map(Real::value).norm();

    let (truth, tau) = (row.get::<6>("log"), a.log());
    errors.relative("SO(3) log", 0.0, &tau.as_slice()[3..], &truth[3..]);
    errors.relative("SE(3) log, translation", 0.0, &tau.as_slice()[..3], &truth[..3]);
    assert_eq!(a.rotation().log().as_slice(), &tau.as_slice()[3..]);

    blocks(errors, ["SO(3) Ad", "SE(3) Ad, t^R block"], 0.0, &a.adjoint(), &row.get("adjoint"));

    let (truth, ab) = (row.get::<7>("compose"), a.compose(&b));
    errors.record("SO(3) compose", 0.0, &ab.rotation().quaternion_xyzw(), &truth[..4], 1.0);
    let scale = size(a.translation()).max(size(b.translation()));
    errors.record("SE(3) compose, translation", 0.0, ab.translation().as_slice(), &truth[4..], scale);

    errors.relative("SO(3) act", 0.0, a.rotation().act(&p).as_slice(), &row.get::<3>("turned"));
    let scale = size(a.translation()).max(size(p));
    errors.record("SE(3) act", 0.0, a.act(&p).as_slice(), &row.get::<3>("act"), scale);

    let (truth, step) = (row.get::<6>("rminus"), b.rminus(&a));
    errors.record("SO(3) rminus", 0.0, &step.as_slice()[3..], &truth[3..], 1.0);
    errors.relative("SE(3) rminus, translation", 0.0, &step.as_slice()[..3], &truth[..3]);
}

/// Named blocks of a matrix: first row and column, rows and columns.
type Parts = [(&'static str, [usize; 4])];

/// The blocks of `m` against their numbers by rows, one block after the other, each relative to itself.
fn matrix<S: Real, const D: usize>(
    errors: &mut Errors,
    operation: &str,
    parts: &Parts,
    m: &SMatrix<S, D, D>,
    truth: &[f64],
) {
    let mut rest = truth;
    for (part, [i, j, h, w]) in parts {
        let (expected, after) = rest.split_at(h * w);
        let block: Vec<S> = m.view((*i, *j), (*h, *w)).transpose().iter().copied().collect();
        errors.relative(&format!("{operation}, {part}"), 0.0, &block, expected);
        rest = after;
    }
}

/// J_l, J_r and their inverses at ±τ against J_l(τ) and J_l(τ)⁻¹.
fn jacobians<G: LieGroup<D>, const D: usize, const K: usize>(
    errors: &mut Errors,
    group: &str,
    parts: &Parts,
    row: &Row<'_>,
) {
    let tau: SVector<G::Scalar, D> = row.input("tau");
    let (jl, inverse) = (row.get::<K>("jl"), row.get::<K>("jl_inv"));
    matrix(errors, &format!("{group} Jl"), parts, &G::left_jacobian(&tau), &jl);
    matrix(errors, &format!("{group} Jr"), parts, &G::right_jacobian(&-tau), &jl);
    matrix(errors, &format!("{group} Jl⁻¹"), parts, &G::left_jacobian_inverse(&tau), &inverse);
    matrix(errors, &format!("{group} Jr⁻¹"), parts, &G::right_jacobian_inverse(&-tau), &inverse);
}

fn similarity_of_space<S: Real>(table: &Table, errors: &mut Errors) {
    for row in table.rows::<S>() {
        let element = |name: &str| {
            let [x, y, z, w, t0, t1, t2, sigma] = row.get(name).map(S::lit);
            Sim3::new(SO3::from_xyzw([x, y, z, w]).unwrap(), Vector3::new(t0, t1, t2), sigma)
        };
        let parts = [("G block", [0, 0, 3, 3]), ("S block", [0, 3, 3, 3]), ("c column", [0, 6, 3, 1])];
        jacobians::<Sim3<S>, 7, 21>(errors, "Sim(3)", &parts, &row);

        let tau: SVector<S, 7> = row.input("tau");
        let (truth, x) = (row.get::<8>("exp"), Sim3::exp(&tau));
        errors.relative("Sim(3) exp, translation", 0.0, x.translation().as_slice(), &truth[4..7]);
        assert_eq!(x.log_scale(), tau[6]);
        assert_eq!(x.rotation(), SO3::exp(&tau.fixed_rows::<3>(3).into_owned()));

        let (a, b, p) = (element("a"), element("b"), row.input("point"));
        let log = a.log();
        errors.relative("Sim(3) log, translation", 0.0, &log.as_slice()[..3], &row.get::<7>("log")[..3]);
        assert_eq!(log.fixed_rows::<3>(3).into_owned(), a.rotation().log());
        let parts = [("sR block", [0, 0, 3, 3]), ("t^R block", [0, 3, 3, 3]), ("t column", [0, 6, 3, 1])];
        matrix(errors, "Sim(3) Ad", &parts, &a.adjoint(), &row.get::<21>("adjoint"));

        let (scale, size) = (row.get::<8>("a")[7].exp(), |v: Vector3<S>| v.map(Real::value).norm());
        let (truth, ab) = (row.get::<8>("compose"), a.compose(&b));
        let terms = size(a.translation()).max(scale * size(b.translation()));
        errors.record("Sim(3) compose, translation", 0.0, ab.translation().as_slice(), &truth[4..7], terms);
        let terms = size(a.translation()).max(scale * size(p));
        errors.record("Sim(3) act", 0.0, a.act(&p).as_slice(), &row.get::<3>("act"), terms);
        let (truth, step) = (row.get::<7>("rminus"), b.rminus(&a));
        errors.relative("Sim(3) rminus, translation", 0.0, &step.as_slice()[..3], &truth[..3]);
    }
}

fn similarity_of_the_plane<S: Real>(table: &Table, errors: &mut Errors) {
    for row in table.rows::<S>() {
        let element = |name: &str| {
            let [c, s, x, y, sigma] = row.get(name).map(S::lit);
            Sim2::new(SO2::from_cos_sin(c, s).unwrap(), Vector2::new(x, y), sigma)
        };
        let parts = [("φ₁ block", [0, 0, 2, 2]), ("columns", [0, 2, 2, 1]), ("columns", [0, 3, 2, 1])];
        jacobians::<Sim2<S>, 4, 8>(errors, "Sim(2)", &parts, &row);

        let (truth, x) = (row.get::<5>("exp"), Sim2::<S>::exp(&row.input("tau")));
        errors.relative("Sim(2) exp, translation", 0.0, x.translation().as_slice(), &truth[2..4]);
        let (a, b, p) = (element("a"), element("b"), row.input("point"));
        let log = a.log();
        errors.relative("Sim(2) log, translation", 0.0, &log.as_slice()[..2], &row.get::<4>("log")[..2]);
        let parts = [("sR block", [0, 0, 2, 2]), ("t columns", [0, 2, 2, 1]), ("t columns", [0, 3, 2, 1])];
        matrix(errors, "Sim(2) Ad", &parts, &a.adjoint(), &row.get::<8>("adjoint"));

        let (scale, size) = (row.get::<5>("a")[4].exp(), |v: Vector2<S>| v.map(Real::value).norm());
        let (truth, ab) = (row.get::<5>("compose"), a.compose(&b));
        let terms = size(a.translation()).max(scale * size(b.translation()));
        errors.record("Sim(2) compose, translation", 0.0, ab.translation().as_slice(), &truth[2..4], terms);
        let terms = size(a.translation()).max(scale * size(p));
        errors.record("Sim(2) act", 0.0, a.act(&p).as_slice(), &row.get::<2>("act"), terms);
        let (truth, step) = (row.get::<4>("rminus"), b.rminus(&a));
        errors.relative("Sim(2) rminus, translation", 0.0, &step.as_slice()[..2], &truth[..2]);
    }
}

/// What SGal(3) has beyond SE₂(3): the position and its blocks, in which clocks meet velocities.
fn galilean<S: Real>(table: &Table, errors: &mut Errors) {
    for row in table.rows::<S>() {
        let element = |name: &str| {
            let [x, y, z, w, p0, p1, p2, v0, v1, v2, t] = row.get(name).map(S::lit);
            let rotation = SO3::from_xyzw([x, y, z, w]).unwrap();
            SGal3::new(rotation, Vector3::new(p0, p1, p2), Vector3::new(v0, v1, v2), t)
        };
        let parts = [("ρφ block", [0, 3, 3, 3]), ("ρν block", [0, 6, 3, 3]), ("ρι column", [0, 9, 3, 1])];
        jacobians::<SGal3<S>, 10, 21>(errors, "SGal(3)", &parts, &row);

        let size = |v: &[f64]| norm(v.iter().copied());
        let (tau, truth) = (row.get::<10>("tau"), row.get::<11>("exp"));
        let x = SGal3::<S>::exp(&row.input("tau"));
        let terms = size(&tau[..3]).max(size(&truth[7..10]) * tau[9].abs());
        errors.record("SGal(3) exp, position", 0.0, x.position().as_slice(), &truth[4..7], terms);

        let (a, b, event) = (element("a"), element("b"), row.input("point"));
        let (ea, eb, e) = (row.get::<11>("a"), row.get::<11>("b"), row.get::<4>("point"));
        let (p, v, t) = (size(&ea[4..7]), size(&ea[7..10]), ea[10].abs());
        let terms = p.max(v * t);
        errors.record(
            "SGal(3) log, position",
            0.0,
            &a.log().as_slice()[..3],
            &row.get::<10>("log")[..3],
            terms,
        );
        let (truth, ad) = (row.get::<21>("adjoint"), a.adjoint());
        let part = |j| -> Matrix3<S> { ad.fixed_view::<3, 3>(0, j).transpose() };
        errors.record("SGal(3) Ad, (p − vt)^R block", 0.0, part(3).as_slice(), &truth[..9], terms);
        if t > 0.0 {
            errors.relative("SGal(3) Ad, tR block", 0.0, part(6).as_slice(), &truth[9..18]);
        }

        let terms = p.max(size(&eb[4..7])).max(v * eb[10].abs());
        let ab = a.compose(&b);
        let truth = row.get::<11>("compose");
        errors.record("SGal(3) compose, position", 0.0, ab.position().as_slice(), &truth[4..7], terms);
        let terms = p.max(size(&e[..3])).max(v * e[3].abs());
        let moved = a.act(&event);
        errors.record("SGal(3) act, place", 0.0, &moved.as_slice()[..3], &row.get::<4>("act")[..3], terms);
        let truth = row.get::<10>("rminus");
        let step = size(&[eb[4] - ea[4], eb[5] - ea[5], eb[6] - ea[6]]);
        let terms = step.max(v.max(size(&truth[6..9])) * (eb[10] - ea[10]).abs());
        errors.record("SGal(3) rminus, position", 0.0, &b.rminus(&a).as_slice()[..3], &truth[..3], terms);
    }
}

fn measure<S: Real>() -> Errors {
    let mut errors = Errors::default();
    coefficients::<S>(&Table::parse(include_str!("reference/coefficients.csv"), 1), &mut errors);
    plane::<S>(&Table::parse(include_str!("reference/se2.csv"), 13), &mut errors);
    space::<S>(&Table::parse(include_str!("reference/se3.csv"), 23), &mut errors);
    galilean::<S>(&Table::parse(include_str!("reference/sgal3.csv"), 36), &mut errors);
    similarity_of_space::<S>(&Table::parse(include_str!("reference/sim3.csv"), 26), &mut errors);
    similarity_of_the_plane::<S>(&Table::parse(include_str!("reference/sim2.csv"), 16), &mut errors);
    assert_eq!(errors.0.len(), BOUNDS.len(), "every operation has one bound");
    errors
}

fn assert_bounds(errors: &Errors, scalar: &str) {
    for Bound { name, principal, beyond, .. } in BOUNDS {
        let [below_pi, above_pi] = errors.0[*name];
        assert!(below_pi <= *principal, "{scalar} {name}: {below_pi:.2} ε, promised {principal}");
        assert!(above_pi <= *beyond, "{scalar} {name}: {above_pi:.2} ε beyond π, promised {beyond}");
    }
}

#[test]
fn every_operation_holds_its_stated_bound_in_f64() {
    assert_bounds(&measure::<f64>(), "f64");
}

#[test]
fn every_operation_holds_its_stated_bound_in_f32() {
    assert_bounds(&measure::<f32>(), "f32");
}

#[test]
fn the_accuracy_document_states_these_bounds() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/accuracy.md");
    let (double, single) = (measure::<f64>(), measure::<f32>());
    let mut text = String::from(PREAMBLE);
    let committed = std::fs::read_to_string(path).unwrap_or_default();
    let bless = std::env::var_os("BOXPLUS_BLESS").is_some();
    for Bound { name, relative_to, principal, beyond } in BOUNDS {
        let (double, single) = (double.0[*name], single.0[*name]);
        let mut promise = format!("| {name} | {relative_to} | {principal} |");
        let mut measured = format!(" {:.1} | {:.1} |", double[0], single[0]);
        if *beyond == NONE {
            promise += " – |";
            measured += " – | – |";
        } else {
            write!(promise, " {beyond} |").unwrap();
            write!(measured, " {:.1} | {:.1} |", double[1], single[1]).unwrap();
        }
        let stated = committed.lines().any(|l| l.starts_with(&promise));
        assert!(bless || stated, "docs/accuracy.md lacks {promise:?}; run with BOXPLUS_BLESS=1");
        writeln!(text, "{promise}{measured}").unwrap();
    }
    if bless {
        std::fs::write(path, text).unwrap();
    }
}

const PREAMBLE: &str = "\
# Accuracy of every `lie` operation in f32 and f64

Largest error against arbitrary precision, in units of ε (2⁻²³ in `f32`, 2⁻⁵² in `f64`), over θ from 10⁻¹² to 6.2, both sides
of every switch, π ± 10⁻¹², generic directions and translations from 10⁻⁶ to 10⁶ m. Errors are normwise and block by block:
the norm of the difference over the norm named in the second column, so that a large translation hides nothing. The
bounds are asserted by `cargo test -p boxplus --test reference`, the same for both scalars; this file is written by
`BOXPLUS_BLESS=1 cargo test -p boxplus --test reference`, the tables by `scripts/reference_tables.py`.

Beyond π, where no logarithm leads, errors are given in multiples of θ/(2π − θ): c₂ has a double zero at 2π, d, e and the
inverse Jacobians have a pole, and there the rounding of θ² itself is amplified. e enters Q̃ only as e(φ·ρ)φ^².

SE₂(3) has no rows of its own: its position and its velocity are, bit for bit, the translation of SE(3), and so are their
blocks of every Jacobian (`tests/groups`). The same holds of SGal(3) but for its position and the blocks named here, those
of row ρ. Sim(3) and Sim(2) are measured for |σ| ≤ 6, with σ and θ vanishing independently; their rotations are those of SO(3)
and SO(2), and so are those of ℝ⁺×SO(3), ℝ⁺×SO(2) and S³. Other coordinates of rotations and S² state their bounds in
their module docs, held by `tests/rotations`. Names of blocks are those of the module docs.

| operation | relative to | bound, θ ≤ π | bound, θ > π | f64, θ ≤ π | f32, θ ≤ π | f64, θ > π | f32, θ > π |
|---|---|---|---|---|---|---|---|
";
