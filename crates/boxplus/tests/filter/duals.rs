//! Dual numbers find the closed forms.

use boxplus::filter::{
    ByDuals, DeadReckoning, Imu, ImuNoise, Measurement, Motion, RangeBearing, SmoothMeasurement, SmoothMotion,
};
use boxplus::lie::{Action, LieGroup, Real, SE2, SE23, SGal3, SO2, SO3};
use boxplus::uncertainty::Covariance;
use nalgebra::{SVector, Vector3, vector};

/// Strap-down integration as a user would write it: an exact increment, then the world's frame.
struct Strapdown;
impl SmoothMotion<SE23, 9, 6> for Strapdown {
    type Input = Imu;
    fn step<S: Real>(&self, x: &SE23<S>, imu: &Imu, w: &SVector<S, 6>) -> SE23<S> {
        let dt = S::lit(imu.duration);
        let mut tau = SVector::<S, 10>::zeros();
        for i in 0..3 {
            tau[3 + i] = (S::lit(imu.gyroscope[i]) - w[i]) * dt;
            tau[6 + i] = (S::lit(imu.accelerometer[i]) - w[3 + i]) * dt;
        }
        tau[9] = dt;
        let step = SGal3::exp(&tau);
        let g = Vector3::new(S::zero(), S::zero(), S::lit(-9.80665));
        let r: SO3<S> = x.rotation();
        SE23::new(
            r * step.rotation(),
            x.position() + x.velocity() * dt + g * (dt * dt * S::lit(0.5)) + r * step.position(),
            x.velocity() + g * dt + r * step.velocity(),
        )
    }
    fn noise(&self, _: &Imu) -> Covariance<6> {
        Covariance::unit()
    }
}

#[test]
fn duals_find_the_jacobians_of_inertial_navigation() {
    let closed = DeadReckoning::upright(ImuNoise::default());
    for seed in 0..10 {
        let s = f64::from(seed);
        let x = SE23::exp(&SVector::from_fn(|i, _| (s + i as f64).sin()));
        let imu = Imu {
            gyroscope: vector![s.sin(), 1.0, s.cos()],
            accelerometer: vector![s.cos(), 2.0, 9.0],
            duration: 0.2,
        };
        let (y, f, g) = closed.step_jac(&x, &imu);
        let (z, f_dual, g_dual) = ByDuals(Strapdown).step_jac(&x, &imu);
        assert!(z.rminus(&y).norm() < 1e-14);
        assert!((f_dual - f).amax() < 1e-14 && (g_dual - g).amax() < 1e-14);
        let (_, f, g) = closed.step_left_jac(&x, &imu);
        let (_, f_dual, g_dual) = ByDuals(Strapdown).step_left_jac(&x, &imu);
        assert!((f_dual - f).amax() < 1e-13 && (g_dual - g).amax() < 1e-13);
    }
}

struct Seen(RangeBearing);
impl SmoothMeasurement<SE2, 3, 2> for Seen {
    fn innovation<S: Real>(&self, x: &SE2<S>) -> SVector<S, 2> {
        let b = x.act_inverse(&self.0.beacon.map(S::lit));
        let bearing = SO2::from_angle(S::lit(self.0.measured.y) - S::polar_angle(b.y, b.x)).angle();
        vector![S::lit(self.0.measured.x) - b.norm_squared().simd_sqrt(), bearing]
    }
    fn noise(&self) -> Covariance<2> {
        self.0.noise
    }
}

#[test]
fn duals_find_the_jacobians_of_range_and_bearing() {
    for seed in 0..10 {
        let s = f64::from(seed);
        let seen = RangeBearing {
            beacon: vector![3.0, s.sin()],
            measured: vector![2.0, 3.0],
            noise: Covariance::unit(),
        };
        let x = SE2::new(vector![s.cos(), 0.3 * s], s);
        let ((z, h), (z_dual, h_dual)) = (seen.innovation_jac(&x), ByDuals(Seen(seen)).innovation_jac(&x));
        assert!((z_dual - z).amax() < 1e-15 && (h_dual - h).amax() < 1e-15);
    }
    // Abeam, where atan(y/x) divides by zero.
    let seen =
        RangeBearing { beacon: vector![0.0, 2.0], measured: vector![2.0, 1.5], noise: Covariance::unit() };
    let (closed, dual) =
        (seen.innovation_jac(&SE2::identity()), ByDuals(Seen(seen)).innovation_jac(&SE2::identity()));
    assert!((dual.0 - closed.0).amax() < 1e-15 && (dual.1 - closed.1).amax() < 1e-15);
}
