//! SO(2), SE(2), Sim(2).

use super::judge::{Errors, LAST, Row, Table, jacobians, matrix};
use boxplus::lie::{Action, LieGroup, Real, SE2, SO2, Sim2};
use nalgebra::{Matrix3, Vector1, Vector2, Vector3};

pub(crate) fn plane<S: Real>(table: &Table, errors: &mut Errors) {
    for row in table.rows::<S>() {
        let tau: Vector3<S> = row.input("tau");
        let theta = tau.z.value().abs();
        if theta < LAST {
            plane_tangent(&row, &tau, theta, errors);
        }
        plane_elements::<S>(&row, errors);
    }
}

pub(crate) fn unit<S: Real>(r: SO2<S>) -> [S; 2] {
    [r.cos(), r.sin()]
}

pub(crate) fn plane_tangent<S: Real>(row: &Row<'_>, tau: &Vector3<S>, theta: f64, errors: &mut Errors) {
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

pub(crate) fn plane_elements<S: Real>(row: &Row<'_>, errors: &mut Errors) {
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

pub(crate) fn similarity_of_the_plane<S: Real>(table: &Table, errors: &mut Errors) {
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
