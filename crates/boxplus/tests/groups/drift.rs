//! Elements do not leave their group, however often they are composed.

use boxplus::lie::{LieGroup, R3xSO3, Real, RxSO2, RxSO3, S3, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3};
use nalgebra::{SVector, Vector3};

use crate::quaternion_error;

/// 10⁷ compositions with generic increments; `norm` measures the distance from the group.
fn drifts_at_most<G: LieGroup<D>, const D: usize>(norm: impl Fn(&G) -> f64, bound: f64) {
    let wave = |i: usize, k: usize| ((i * (k + 2)) as f64).sin();
    let steps: [G; 8] =
        std::array::from_fn(|i| G::exp(&SVector::from_fn(|k, _| G::Scalar::lit(0.9 * wave(i + 1, k)))));
    let mut x = G::identity();
    for i in 0..10_000_000 {
        x = x.compose(&steps[i % 8]);
        if i % 1024 == 0 {
            assert!(norm(&x) <= bound, "after {i} compositions: {:.1e}", norm(&x));
        }
    }
}

/// How far a stored (cos, sin) is from unit norm, in units of ε.
fn unit_error<S: Real>(r: &SO2<S>) -> f64 {
    (r.cos().value().powi(2) + r.sin().value().powi(2) - 1.0).abs() / S::EPSILON
}

macro_rules! drift {
    ($($name:ident: $group:ident, $d:literal, $error:expr;)*) => { $(
        #[test]
        fn $name() {
            drifts_at_most::<$group, $d>($error, 4.0);
            drifts_at_most::<$group<f32>, $d>($error, 4.0);
        }
    )* };
}

drift! {
    ten_million_compositions_stay_on_so2: SO2, 1, unit_error;
    ten_million_compositions_stay_on_se2: SE2, 3, |x| unit_error(&x.rotation());
    ten_million_compositions_stay_on_so3: SO3, 3, quaternion_error;
    ten_million_compositions_stay_on_s3: S3, 3, |x| quaternion_error(&SO3::from(*x));
    ten_million_compositions_stay_on_se3: SE3, 6, |x| quaternion_error(&x.rotation());
    ten_million_compositions_stay_on_r3xso3: R3xSO3, 6, |x| quaternion_error(&x.rotation());
    ten_million_compositions_stay_on_se23: SE23, 9, |x| quaternion_error(&x.rotation());
    ten_million_compositions_stay_on_sgal3: SGal3, 10, |x| quaternion_error(&x.rotation());
    ten_million_compositions_stay_on_rxso2: RxSO2, 2, |x| unit_error(&x.rotation());
    ten_million_compositions_stay_on_rxso3: RxSO3, 4, |x| quaternion_error(&x.rotation());
    ten_million_compositions_stay_on_sim2: Sim2, 4, |x| unit_error(&x.rotation());
    ten_million_compositions_stay_on_sim3: Sim3, 7, |x| quaternion_error(&x.rotation());
}

#[test]
fn ten_million_compositions_keep_the_scale() {
    // Steps that multiply to the scale 1 do so up to rounding, which accumulates in σ as in any sum.
    let step = |sigma| Sim3::new(SO3::exp(&Vector3::new(0.1, 0.2, 0.3)), Vector3::zeros(), sigma);
    let (up, down) = (step(0.7), step(-0.7));
    let end = (0..5_000_000).fold(Sim3::identity(), |x, _| x.compose(&up).compose(&down));
    assert_eq!(end.scale(), 1.0);
}
