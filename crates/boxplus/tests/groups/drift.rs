//! Elements do not leave their group, however often they are composed.

use boxplus::lie::{LieGroup, Real, RxSO3, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3};
use nalgebra::{SVector, Vector3};

use crate::{EPS, quaternion_error};

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

#[test]
fn ten_million_compositions_stay_on_so2_and_se2() {
    let error = |r: SO2| (r.cos().powi(2) + r.sin().powi(2) - 1.0).abs() / EPS;
    drifts_at_most::<SO2, 1>(|x| error(*x), 4.0);
    drifts_at_most::<SE2, 3>(|x| error(x.rotation()), 4.0);
}

#[test]
fn ten_million_compositions_stay_on_so3() {
    drifts_at_most::<SO3, 3>(quaternion_error, 4.0);
    drifts_at_most::<SO3<f32>, 3>(quaternion_error, 4.0);
}

#[test]
fn ten_million_compositions_stay_on_se3() {
    drifts_at_most::<SE3, 6>(|x| quaternion_error(&x.rotation()), 4.0);
}

#[test]
fn ten_million_compositions_stay_on_se23() {
    drifts_at_most::<SE23, 9>(|x| quaternion_error(&x.rotation()), 4.0);
}

#[test]
fn ten_million_compositions_stay_on_sgal3() {
    drifts_at_most::<SGal3, 10>(|x| quaternion_error(&x.rotation()), 4.0);
}

#[test]
fn ten_million_compositions_stay_on_sim3_and_keep_the_scale() {
    // The eight steps multiply to the scale 1 up to rounding, which accumulates in σ as in any sum; the rotation stays.
    drifts_at_most::<Sim3, 7>(|x| quaternion_error(&x.rotation()), 4.0);
    let step = |sigma| Sim3::new(SO3::exp(&Vector3::new(0.1, 0.2, 0.3)), Vector3::zeros(), sigma);
    let (up, down) = (step(0.7), step(-0.7));
    let end = (0..5_000_000).fold(Sim3::identity(), |x, _| x.compose(&up).compose(&down));
    assert_eq!(end.scale(), 1.0);
    let turned = |r: SO2| (r.cos().powi(2) + r.sin().powi(2) - 1.0).abs() / EPS;
    drifts_at_most::<RxSO3, 4>(|x| quaternion_error(&x.rotation()), 4.0);
    drifts_at_most::<Sim2, 4>(|x| turned(x.rotation()), 4.0);
}
