//! In `f32`, as on a microcontroller.

use boxplus::filter::{Ekf, Filter, Odometry, RangeBearing, Ukf};
use boxplus::lie::{LieGroup, SE2};
use boxplus::uncertainty::{Covariance, Gaussian};
use nalgebra::{Vector2, Vector3};

fn drive<S: boxplus::lie::Real>(filter: &impl Filter) -> [f64; 3] {
    let vector = |x: [f64; 3]| Vector3::from(x.map(S::lit));
    let noise = Covariance::from_sigmas(&Vector2::new(S::lit(0.1), S::lit(0.05))).unwrap();
    let odometry = Odometry { noise: Covariance::from_sigmas(&vector([0.02, 0.01, 0.01])).unwrap() };
    let mut belief = Gaussian::<SE2<S>, 3>::certain(SE2::identity());
    for k in 0..100 {
        belief = filter.predict(&belief, &odometry, &vector([0.1, 0.0, 0.02])).unwrap();
        let beacon = Vector2::new(S::lit(2.0), S::lit(3.0));
        let b = boxplus::lie::Action::act_inverse(belief.mean(), &beacon);
        let error = S::lit(0.05 * f64::from(k).sin());
        let measured = Vector2::new(b.norm() + error, b.y.simd_atan2(b.x) + error);
        let update = filter.update(&belief, &RangeBearing { beacon, measured, noise });
        assert!(update.is_accepted());
        belief = update.belief;
    }
    let (t, angle) = (belief.mean().translation(), belief.mean().angle());
    [t.x.value(), t.y.value(), angle.value()]
}

#[test]
fn single_precision_follows_double() {
    // A hundred steps of a few metres: ε·10²·10 m ≈ 1e-4; unscented means add ε/α².
    let off = |filter: &dyn Fn() -> ([f64; 3], [f64; 3])| {
        let (a, b) = filter();
        (0..3).map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max)
    };
    assert!(off(&|| (drive::<f32>(&Ekf::default()), drive::<f64>(&Ekf::default()))) < 1e-4);
    let ukf = Ukf { alpha: 1.0, ..Ukf::default() };
    assert!(off(&|| (drive::<f32>(&ukf), drive::<f64>(&ukf))) < 1e-4);
}
