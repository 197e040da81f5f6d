//! boxplus.

use boxplus::filter::{
    Ekf, Filter, Imu, ImuNoise, Inertial, InertialState, Measurement, Motion, Odometry, Part, PositionFix,
    RangeBearing, SquareRootBelief, Ukf,
};
use boxplus::lie::{LieGroup, Real, Rn, SE2};
use boxplus::uncertainty::{Covariance, Gaussian, Side};
use nalgebra::{Matrix2x4, Matrix4, SVector, Vector2, Vector3, Vector4, vector};

/// Constant velocity in the plane, (x, y, v_x, v_y); the position is seen.
struct Cart {
    noise: Covariance<4>,
}

impl Motion<Rn<4>, 4, 4> for Cart {
    type Input = ();
    fn step(&self, x: &Rn<4>, (): &(), w: &Vector4<f64>) -> Rn<4> {
        Rn::new(transition() * x.vector() + w)
    }
    fn noise(&self, (): &()) -> Covariance<4> {
        self.noise
    }
    fn step_jac(&self, x: &Rn<4>, (): &()) -> (Rn<4>, Matrix4<f64>, Matrix4<f64>) {
        (Rn::new(transition() * x.vector()), transition(), Matrix4::identity())
    }
}

fn transition() -> Matrix4<f64> {
    let mut f = Matrix4::identity();
    (f[(0, 2)], f[(1, 3)]) = (0.1, 0.1);
    f
}

struct Seen {
    place: Vector2<f64>,
    noise: Covariance<2>,
}

impl Measurement<Rn<4>, 4, 2> for Seen {
    fn innovation(&self, x: &Rn<4>) -> Vector2<f64> {
        self.place - x.vector().fixed_rows::<2>(0)
    }
    fn noise(&self) -> Covariance<2> {
        self.noise
    }
    fn innovation_jac(&self, x: &Rn<4>) -> (Vector2<f64>, Matrix2x4<f64>) {
        (self.innovation(x), Matrix2x4::identity())
    }
}

fn cart_models() -> (Cart, Seen, Gaussian<Rn<4>, 4>) {
    let motion = Cart { noise: Covariance::unit() * 0.1 };
    let seen = Seen { place: vector![0.3, -0.2], noise: Covariance::unit() * 0.5 };
    (motion, seen, Gaussian::new(Rn::identity(), Covariance::unit()))
}

pub fn cart(steps: usize) -> f64 {
    let (motion, seen, mut belief) = cart_models();
    for _ in 0..steps {
        belief = Ekf::default().predict(&belief, &motion, &()).expect("finite");
        belief = Ekf::default().update(&belief, &seen).belief;
    }
    belief.mean().vector().x
}

pub fn cart_root(steps: usize) -> f64 {
    let (motion, seen, belief) = cart_models();
    let mut belief = SquareRootBelief::from_gaussian(&belief);
    for _ in 0..steps {
        belief = belief.predict(&motion, &()).expect("finite");
        belief = belief.update(&seen).expect("regular");
    }
    belief.mean().vector().x
}

fn planar(filter: &impl Filter, steps: usize) -> f64 {
    let odometry = Odometry { noise: Covariance::from_sigmas(&vector![0.02, 0.01, 0.01]).expect("positive") };
    let noise = Covariance::from_sigmas(&vector![0.1, 0.05]).expect("positive");
    let seen = RangeBearing { beacon: vector![9.0, 1.0], measured: vector![9.0, 0.1], noise };
    let sigmas = vector![0.1, 0.1, 0.1];
    let mut belief = Gaussian::<SE2, 3>::from_sigmas(SE2::identity(), &sigmas).expect("positive");
    for _ in 0..steps {
        belief = filter.predict(&belief, &odometry, &vector![0.001, 0.0, 0.0001]).expect("finite");
        belief = filter.update(&belief, &seen).belief;
    }
    belief.mean().angle()
}

pub fn plane(steps: usize) -> f64 {
    planar(&Ekf::default(), steps)
}

pub fn plane_iterated(steps: usize) -> f64 {
    planar(&Ekf::iterated(), steps)
}

pub fn plane_unscented(steps: usize) -> f64 {
    planar(&Ukf::default(), steps)
}

fn inertial_models<S: Real>() -> (Inertial<S>, Imu<S>, PositionFix<3, S>, Gaussian<InertialState<S>, 15>) {
    let l = S::lit;
    let noise = ImuNoise {
        gyroscope: l(1e-3),
        accelerometer: l(1e-2),
        gyroscope_bias: l(1e-5),
        accelerometer_bias: l(1e-4),
    };
    let imu = Imu {
        gyroscope: vector![l(0.1), l(0.0), l(0.2)],
        accelerometer: vector![l(0.0), l(0.1), l(9.8)],
        duration: l(0.01),
    };
    let fix = PositionFix::of_origin(Vector3::new(l(0.1), l(0.0), l(0.0)), Covariance::unit() * l(0.5));
    let start = Gaussian::new(InertialState::identity(), Covariance::unit() * l(0.05));
    (Inertial::upright(noise), imu, fix, start)
}

fn navigated<E: Side>(filter: &impl Filter, mut belief: Gaussian<InertialState, 15, E>, steps: usize) -> f64 {
    let (model, imu, measurement, _) = inertial_models();
    let (of, block) = (|x: &InertialState| x.motion, InertialState::BLOCKS.motion);
    for _ in 0..steps {
        belief = filter.predict(&belief, &model, &imu).expect("finite");
        belief = filter.update(&belief, &Part { measurement, of, block }).belief;
    }
    belief.mean().motion.position().x
}

pub fn inertial(steps: usize) -> f64 {
    navigated(&Ekf::default(), inertial_models().3, steps)
}

pub fn inertial_global(steps: usize) -> f64 {
    navigated(&Ekf::default(), inertial_models().3.to_global(), steps)
}

pub fn inertial_unscented(steps: usize) -> f64 {
    navigated(&Ukf::default(), inertial_models().3, steps)
}

pub fn inertial_single(steps: usize) -> f64 {
    let (model, imu, measurement, mut belief) = inertial_models::<f32>();
    let (of, block) = (|x: &InertialState<f32>| x.motion, InertialState::BLOCKS.motion);
    for _ in 0..steps {
        belief = Ekf::default().predict(&belief, &model, &imu).expect("finite");
        belief = Ekf::default().update(&belief, &Part { measurement, of, block }).belief;
    }
    f64::from(belief.mean().motion.position().x)
}

pub fn inertial_root(steps: usize) -> f64 {
    let (model, imu, measurement, belief) = inertial_models::<f32>();
    let (of, block) = (|x: &InertialState<f32>| x.motion, InertialState::BLOCKS.motion);
    let mut belief = SquareRootBelief::from_gaussian(&belief);
    for _ in 0..steps {
        belief = belief.predict(&model, &imu).expect("finite");
        belief = belief.update(&Part { measurement, of, block }).expect("regular");
    }
    let _: SVector<f32, 15> = belief.sigmas();
    f64::from(belief.mean().motion.position().x)
}
