//! SO(3), SE(3), SGal(3), Sim(3).

use super::judge::{Errors, LAST, Row, Table, jacobians, matrix, norm};
use boxplus::lie::{Action, LieGroup, Real, SE3, SGal3, SO3, Sim3};
use nalgebra::{Matrix3, Matrix6, SVector, Vector3, Vector6};

pub(crate) fn space<S: Real>(table: &Table, errors: &mut Errors) {
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
pub(crate) type Names = [&'static str; 2];

/// Both blocks of \[J Q; 0 J\] against 18 numbers, J and Q by rows.
pub(crate) fn blocks<S: Real>(
    errors: &mut Errors,
    names: Names,
    theta: f64,
    m: &Matrix6<S>,
    truth: &[f64; 18],
) {
    let part = |i, j| -> Matrix3<S> { m.fixed_view::<3, 3>(i, j).transpose() };
    errors.relative(names[0], theta, part(0, 0).as_slice(), &truth[..9]);
    errors.relative(names[1], theta, part(0, 3).as_slice(), &truth[9..]);
    assert_eq!(part(3, 3), part(0, 0));
    assert_eq!(part(3, 0), Matrix3::zeros());
}

pub(crate) fn space_tangent<S: Real>(row: &Row<'_>, tau: &Vector6<S>, theta: f64, errors: &mut Errors) {
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

pub(crate) fn space_elements<S: Real>(row: &Row<'_>, errors: &mut Errors) {
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

/// What SGal(3) has beyond SE₂(3): the position and its blocks, in which clocks meet velocities.
pub(crate) fn galilean<S: Real>(table: &Table, errors: &mut Errors) {
    for row in table.rows::<S>() {
        let element = |name: &str| {
            let [x, y, z, w, p0, p1, p2, v0, v1, v2, t] = row.get(name).map(S::lit);
            let rotation = SO3::from_xyzw([x, y, z, w]).unwrap();
            SGal3::new(rotation, Vector3::new(p0, p1, p2), Vector3::new(v0, v1, v2), t)
        };
        galilean_jacobians::<S>(&row, errors);

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

/// The block ρφ is the sum of one of ρ and of ι times one of ν, which may cancel: its error is relative to the larger.
fn galilean_jacobians<S: Real>(row: &Row<'_>, errors: &mut Errors) {
    let (tau, sizes) = (row.input::<S, 10>("tau"), row.get::<4>("coupling"));
    let [jl, inverse] = ["jl", "jl_inv"].map(|name| row.get::<21>(name));
    let larger = [sizes[0].max(sizes[1]), sizes[2].max(sizes[3])];
    for (name, m, truth, terms) in [
        ("SGal(3) Jl", SGal3::left_jacobian(&tau), jl, larger[0]),
        ("SGal(3) Jr", SGal3::right_jacobian(&-tau), jl, larger[0]),
        ("SGal(3) Jl⁻¹", SGal3::left_jacobian_inverse(&tau), inverse, larger[1]),
        ("SGal(3) Jr⁻¹", SGal3::right_jacobian_inverse(&-tau), inverse, larger[1]),
    ] {
        let block: Matrix3<S> = m.fixed_view::<3, 3>(0, 3).transpose();
        errors.record(&format!("{name}, ρφ block"), 0.0, block.as_slice(), &truth[..9], terms);
        let parts = [("ρν block", [0, 6, 3, 3]), ("ρι column", [0, 9, 3, 1])];
        matrix(errors, name, &parts, &m, &truth[9..]);
    }
}

pub(crate) fn similarity_of_space<S: Real>(table: &Table, errors: &mut Errors) {
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
