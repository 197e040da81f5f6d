//! First checks of every group.
#![allow(missing_docs)]
use boxplus::lie::{Action, LeftJacobians, LieGroup, Rn, SE2, SE3, SO2, SO3};
use nalgebra::{SMatrix, SVector};

fn check<G: LieGroup<D, Scalar = f64>, const D: usize>() {
    for scale in [0.0, 1e-9, 1e-4, 0.3, 1.0, 1.3] {
        let t = SVector::<f64, D>::from_fn(|i, _| scale * ((i as f64 * 2.7 + 1.0).sin() + 0.1));
        let u = SVector::<f64, D>::from_fn(|i, _| 0.7 * ((i as f64 * 1.3 + 0.4).cos() - 0.2));
        let x = G::exp(&t);
        let y = G::exp(&u);
        assert!((x.log() - t).amax() < 4e-15, "{:?} {}", x.log(), t);
        assert!(x.compose(&x.inverse()).log().amax() < 1e-15);
        let h = 1e-5;
        let fd = |f: &dyn Fn(&SVector<f64, D>) -> SVector<f64, D>| {
            SMatrix::<f64, D, D>::from_columns(&core::array::from_fn::<_, D, _>(|i| {
                let mut e = SVector::<f64, D>::zeros();
                e[i] = h;
                (f(&e) - f(&-e)) / (2.0 * h)
            }))
        };
        let ok = |a: SMatrix<f64, D, D>, b: SMatrix<f64, D, D>, s: &str| {
            assert!((a - b).amax() < 1e-8, "{s} {a} {b}");
        };
        ok(G::right_jacobian(&t), fd(&|d| G::exp(&(t + d)).rminus(&x)), "jr");
        ok(G::left_jacobian(&t), fd(&|d| G::exp(&(t + d)).lminus(&x)), "jl");
        ok(G::right_jacobian(&t) * G::right_jacobian_inverse(&t), SMatrix::identity(), "inv");
        let (z, a, b, c) = x.interpolate_jac(&y, 0.3);
        ok(a, fd(&|d| x.rplus(d).interpolate(&y, 0.3).rminus(&z)), "ia");
        ok(b, fd(&|d| x.interpolate(&y.rplus(d), 0.3).rminus(&z)), "ib");
        let ct = (x.interpolate(&y, 0.3 + h).rminus(&z) - x.interpolate(&y, 0.3 - h).rminus(&z)) / (2.0 * h);
        assert!((c - ct).amax() < 1e-8);
        let (z, a, b, c) = x.interpolate_left_jac(&y, 0.3);
        ok(a, fd(&|d| x.lplus(d).interpolate(&y, 0.3).lminus(&z)), "la");
        ok(b, fd(&|d| x.interpolate(&y.lplus(d), 0.3).lminus(&z)), "lb");
        let ct = (x.interpolate(&y, 0.3 + h).lminus(&z) - x.interpolate(&y, 0.3 - h).lminus(&z)) / (2.0 * h);
        assert!((c - ct).amax() < 1e-8);
        let (z, a, b) = y.rminus_jac(&x);
        ok(a, fd(&|d| y.rplus(d).rminus(&x) - z), "rma");
        ok(b, fd(&|d| y.rminus(&x.rplus(d)) - z), "rmb");
        let (z, a, b) = y.lminus_jac(&x);
        ok(a, fd(&|d| y.rplus(d).lminus(&x) - z), "lma");
        ok(b, fd(&|d| y.lminus(&x.rplus(d)) - z), "lmb");
        let (_, a, b) = y.rminus_left_jac(&x);
        ok(a, fd(&|d| y.lplus(d).rminus(&x) - y.rminus(&x)), "rma");
        ok(b, fd(&|d| y.rminus(&x.lplus(d)) - y.rminus(&x)), "rmb");
    }
}

fn check_action<G: Action<D, N, Scalar = f64>, const D: usize, const N: usize>() {
    let x = G::exp(&SVector::<f64, D>::from_fn(|i, _| 0.8 * (i as f64 * 2.7 + 1.0).sin()));
    let p = SVector::<f64, N>::from_fn(|i, _| 0.3 + i as f64);
    let h = 1e-5;
    for i in 0..D {
        let mut e = SVector::<f64, D>::zeros();
        e[i] = h;
        let r = |s: f64| x.rplus(&(e * s));
        let l = |s: f64| x.lplus(&(e * s));
        let col = |a: SVector<f64, N>, b: SVector<f64, N>, j: SMatrix<f64, N, D>| {
            let fd = (a - b) / (2.0 * h);
            assert!((fd - j.column(i)).amax() < 1e-8);
        };
        col(r(1.0).act(&p), r(-1.0).act(&p), x.act_jac(&p).1);
        col(l(1.0).act(&p), l(-1.0).act(&p), x.act_left_jac(&p).1);
        col(r(1.0).act_inverse(&p), r(-1.0).act_inverse(&p), x.act_inverse_jac(&p).1);
        col(l(1.0).act_inverse(&p), l(-1.0).act_inverse(&p), x.act_inverse_left_jac(&p).1);
        col(r(1.0).act_direction(&p), r(-1.0).act_direction(&p), x.act_direction_jac(&p).1);
        col(l(1.0).act_direction(&p), l(-1.0).act_direction(&p), x.act_direction_left_jac(&p).1);
    }
}

#[test]
fn every_group_passes_the_first_checks() {
    check::<Rn<3>, 3>();
    check::<SO2, 1>();
    check::<SE2, 3>();
    check::<SO3, 3>();
    check::<SE3, 6>();
    check_action::<Rn<3>, 3, 3>();
    check_action::<SO2, 1, 2>();
    check_action::<SE2, 3, 2>();
    check_action::<SO3, 3, 3>();
    check_action::<SE3, 6, 3>();
}
