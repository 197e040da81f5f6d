//! Split covariance intersection: its two limits, and what it promises.

use boxplus::lie::{LieGroup, Rn, SE2};
use boxplus::uncertainty::{Covariance, Criterion, Gaussian, Global, Split, UncertaintyError};
use nalgebra::{SVector, vector};

fn cov(sigmas: [f64; 3]) -> Covariance<3> {
    Covariance::from_sigmas(&sigmas.into()).unwrap()
}

fn poses() -> [SE2; 2] {
    [SE2::new(vector![1.0, 2.0], 0.3), SE2::new(vector![1.2, 1.9], 0.35)]
}

fn off(a: &Gaussian<SE2, 3>, b: &Gaussian<SE2, 3>) -> f64 {
    a.error_of(b.mean()).amax().max((a.covariance().matrix() - b.covariance().matrix()).amax())
}

#[test]
fn with_nothing_shared_it_is_fusion() {
    let [x, y] = poses();
    let (p, q) = (cov([0.3, 0.1, 0.05]), cov([0.2, 0.4, 0.02]));
    let split = |mean, own| Split::<SE2, 3>::new(mean, Covariance::zero(), own);
    let fused = split(x, p).fuse(&split(y, q), Criterion::Determinant).unwrap().estimate;
    let expected = Gaussian::fuse(&[Gaussian::new(x, p), Gaussian::new(y, q)]).unwrap().estimate;
    assert!(off(&fused.total(), &expected) < 1e-9);
    assert_eq!(fused.shared().matrix().amax(), 0.0);
}

#[test]
fn with_everything_shared_it_is_covariance_intersection() {
    let [x, y] = poses();
    let (p, q) = (cov([0.3, 0.1, 0.05]), cov([0.1, 0.4, 0.05]));
    let split = |mean, shared| Split::<SE2, 3>::new(mean, shared, Covariance::zero());
    let fused = split(x, p).fuse(&split(y, q), Criterion::Trace).unwrap();
    let expected = Gaussian::<SE2, 3>::new(x, p).intersect(&Gaussian::new(y, q), Criterion::Trace).unwrap();
    assert!((fused.weight - expected.weight).abs() < 1e-6);
    assert!(off(&fused.estimate.total(), &expected.estimate) < 1e-6);
    assert_eq!(fused.estimate.own().matrix().amax(), 0.0);
}

#[test]
fn the_claim_holds_for_every_correlation_of_what_is_shared() {
    let (s, o) = ([vector![2.0, 0.5], vector![0.6, 1.5]], [vector![0.3, 0.4], vector![0.5, 0.2]]);
    let of = |k: usize| {
        let part = |sigmas: SVector<f64, 2>| Covariance::<2>::from_sigmas(&sigmas).unwrap();
        Split::<Rn<2>, 2>::new(Rn::identity(), part(s[k]), part(o[k]))
    };
    let fused = of(0).fuse(&of(1), Criterion::Determinant).unwrap();
    let claimed = fused.estimate.total();
    let inflated = |k: usize, w: f64| s[k].map(|x| x * x / w) + o[k].map(|x| x * x);
    let (p, q) = (inflated(0, fused.weight), inflated(1, 1.0 - fused.weight));
    for rho in [-1.0, -0.5, 0.0, 0.5, 1.0] {
        for i in 0..2 {
            let (k, l) = (q[i] / (p[i] + q[i]), p[i] / (p[i] + q[i]));
            let own = k * k * o[0][i].powi(2) + l * l * o[1][i].powi(2);
            let shared =
                k * k * s[0][i].powi(2) + l * l * s[1][i].powi(2) + 2.0 * k * l * rho * s[0][i] * s[1][i];
            let claim = claimed.covariance().matrix()[(i, i)];
            assert!(own + shared <= claim * (1.0 + 1e-9), "{rho} {i}: {} {claim}", own + shared);
            let claim = fused.estimate.own().matrix()[(i, i)];
            assert!((own - claim).abs() < 1e-9 * claim, "{own} {claim}");
        }
    }
}

#[test]
fn both_sides_agree() {
    let [x, y] = poses();
    let (s, o) = (cov([0.3, 0.1, 0.05]), cov([0.2, 0.4, 0.02]));
    let global = |g: &SE2, c: Covariance<3>| c.transformed(&g.adjoint());
    let local = Split::<SE2, 3>::new(x, s, o).fuse(&Split::new(y, o, s), Criterion::Determinant).unwrap();
    let turned = Split::<SE2, 3, Global>::new(x, global(&x, s), global(&x, o))
        .fuse(&Split::new(y, global(&y, o), global(&y, s)), Criterion::Determinant)
        .unwrap();
    assert!(off(&turned.estimate.total().to_local(), &local.estimate.total()) < 1e-6);
}

#[test]
fn a_certain_estimate_is_refused() {
    let [x, y] = poses();
    let certain = Split::<SE2, 3>::new(x, Covariance::zero(), cov([0.1, 0.0, 0.1]));
    let other = Split::new(y, cov([0.1, 0.1, 0.1]), Covariance::zero());
    assert!(matches!(certain.fuse(&other, Criterion::Trace), Err(UncertaintyError::Singular { .. })));
}
