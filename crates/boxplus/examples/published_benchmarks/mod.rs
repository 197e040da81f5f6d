//! Three simulations of Brossard, Barrau & Bonnabel (2020), as their documentation describes them: several filters on the same
//! data, orientation and position recorded apart.
#![allow(dead_code, reason = "the example prints what the tests only compare")]

use boxplus::bundle;
use boxplus::filter::{
    DeadReckoning, Ekf, Filter, FilterError, Imu, ImuNoise, Measurement, MonteCarlo, Motion, Odometry,
    PositionFix, Report, Run, Sighting, Ukf, VectorSighting,
};
use boxplus::lie::{Action, Jacobian, LieGroup, Rn, SE2, SE23, SO2, SO3};
use boxplus::uncertainty::{Covariance, Gaussian, Global, Side};
use nalgebra::{SMatrix, SVector, Vector2, Vector3, vector};
use rand_chacha::ChaCha8Rng;

/// The published filters: none resets, sigma points are close.
const EKF: Ekf = Ekf { reset: false, ..PLAIN };
const UKF: Ukf = Ukf { alpha: 1e-3, reset: false, gate: PLAIN.gate };
const PLAIN: Ekf = Ekf { reset: true, iterations: 1, tolerance: 1e-6, gate: boxplus::filter::Gate::open() };
/// What we would take.
const ITERATED: Ekf = Ekf { iterations: 10, ..PLAIN };

/// Standard normal numbers.
fn white<const N: usize>(rng: &mut ChaCha8Rng) -> SVector<f64, N> {
    Gaussian::<Rn<N>, N>::new(Rn::new(SVector::zeros()), Covariance::unit()).sample(rng).vector()
}

fn sigmas<const N: usize>(values: [f64; N]) -> Covariance<N> {
    let scale = SMatrix::<f64, N, N>::from_diagonal(&values.into());
    Covariance::unit().transformed(&scale)
}

/// The names under which a filter records: orientation and position, and what is left of NEES for the late times.
pub(crate) type Names = [&'static str; 2];

bundle! {
    /// A planar pose as position beside heading, which nothing couples.
    struct FlatPose { position: Rn<2> [2], heading: SO2 [1] }
}

impl FlatPose {
    fn of(x: &SE2) -> Self {
        Self { position: Rn::new(x.translation()), heading: x.rotation() }
    }
    fn pose(&self) -> SE2 {
        SE2::from_parts(self.position.vector(), self.heading)
    }
    /// From local errors of the pose to those of the pair.
    fn chart(&self) -> Jacobian<f64, 3> {
        let mut t = Jacobian::<f64, 3>::identity();
        t.fixed_view_mut::<2, 2>(0, 0).copy_from(&self.heading.to_matrix());
        t
    }
}

struct Flat<T>(T);

impl Motion<FlatPose, 3, 3> for Flat<Odometry<3>> {
    type Input = Vector3<f64>;
    fn step(&self, x: &FlatPose, u: &Vector3<f64>, w: &Vector3<f64>) -> FlatPose {
        FlatPose::of(&self.0.step(&x.pose(), u, w))
    }
    fn noise(&self, _: &Vector3<f64>) -> Covariance<3> {
        self.0.noise
    }
    fn step_jac(&self, x: &FlatPose, u: &Vector3<f64>) -> (FlatPose, Jacobian<f64, 3>, Jacobian<f64, 3>) {
        let (next, f, g) = self.0.step_jac(&x.pose(), u);
        let next = FlatPose::of(&next);
        (next, next.chart() * f * x.chart().transpose(), next.chart() * g)
    }
}

impl Measurement<FlatPose, 3, 2> for Flat<PositionFix<2>> {
    fn innovation(&self, x: &FlatPose) -> Vector2<f64> {
        self.0.measured - x.position.vector()
    }
    fn noise(&self) -> Covariance<2> {
        self.0.noise
    }
    fn innovation_jac(&self, x: &FlatPose) -> (Vector2<f64>, SMatrix<f64, 2, 3>) {
        (self.innovation(x), SMatrix::<f64, 2, 3>::identity())
    }
}

/// Records a planar belief, local errors.
fn planar(run: &mut Run, names: [Names; 2], late: bool, truth: &SE2, mean: &SE2, p: &Jacobian<f64, 3>) {
    let turn = mean.rotation().between(&truth.rotation()).angle();
    let shift = mean.act_inverse(&truth.translation());
    let angular = Covariance::unit().transformed(&vector![p[(2, 2)].sqrt()]);
    let Ok(linear) = Covariance::new(p.fixed_view::<2, 2>(0, 0).into_owned()) else { return };
    for (kind, now) in names.into_iter().zip([true, late]) {
        if now {
            run.error(kind[0], &vector![turn], &angular);
            run.error(kind[1], &shift, &linear);
        }
    }
}

/// A robot on a circle of 5 m, its heading at the start unknown by 45°. NEES counts from 20 s on.
pub(crate) fn localisation(runs: usize, threads: std::num::NonZeroUsize) -> Option<Report> {
    const NAMES: [[Names; 2]; 6] = [
        [
            ["UKF on the product", "UKF on the product, m"],
            ["UKF on the product, late", "UKF on the product, m, late"],
        ],
        [["left UKF", "left UKF, m"], ["left UKF, late", "left UKF, m, late"]],
        [["right UKF", "right UKF, m"], ["right UKF, late", "right UKF, m, late"]],
        [["EKF", "EKF, m"], ["EKF, late", "EKF, m, late"]],
        [["IEKF", "IEKF, m"], ["IEKF, late", "IEKF, m, late"]],
        [["iterated IEKF", "iterated IEKF, m"], ["iterated IEKF, late", "iterated IEKF, m, late"]],
    ];
    let (dt, turn) = (0.01, std::f64::consts::TAU / 40.0);
    let deviations = [0.01 * dt, 0.01 * dt, 1.0_f64.to_radians() * dt];
    let odometry = Odometry { noise: sigmas(deviations) };
    let (u, unit) = (vector![5.0 * turn, 0.0, turn] * dt, Covariance::unit());
    let simulation = |rng: &mut ChaCha8Rng, run: &mut Run| -> Result<(), FilterError> {
        let mut truth = SE2::identity();
        let guess = SE2::new(vector![0.0, 0.0], 45_f64.to_radians() * white::<1>(rng)[0]);
        let start = Gaussian::<SE2, 3>::new(guess, sigmas([0.0, 0.0, 45_f64.to_radians()]));
        let flat = Gaussian::<FlatPose, 3>::new(FlatPose::of(&guess), *start.covariance());
        let (mut flat_ukf, mut flat_ekf, mut right) = (flat, flat, start.to_global());
        let (mut left, mut iekf, mut iterated) = (start, start, start);
        for k in 1..4000 {
            truth = truth.rplus(&u);
            let seen = u + white::<3>(rng).component_mul(&Vector3::from(deviations));
            flat_ukf = UKF.predict(&flat_ukf, &Flat(odometry), &seen)?;
            flat_ekf = EKF.predict(&flat_ekf, &Flat(odometry), &seen)?;
            left = UKF.predict(&left, &odometry, &seen)?;
            right = UKF.predict(&right, &odometry, &seen)?;
            iekf = EKF.predict(&iekf, &odometry, &seen)?;
            iterated = ITERATED.predict(&iterated, &odometry, &seen)?;
            if k % 100 == 0 {
                let fix = PositionFix::of_origin(truth.translation() + white(rng), unit);
                flat_ukf = UKF.update(&flat_ukf, &Flat(fix)).belief;
                flat_ekf = EKF.update(&flat_ekf, &Flat(fix)).belief;
                left = UKF.update(&left, &fix).belief;
                right = UKF.update(&right, &fix).belief;
                iekf = EKF.update(&iekf, &fix).belief;
                iterated = ITERATED.update(&iterated, &fix).belief;
            }
            if k % 10 != 0 {
                continue;
            }
            for (i, belief) in [(0, &flat_ukf), (3, &flat_ekf)] {
                let t = belief.mean().chart().transpose();
                let p = belief.covariance().transformed(&t);
                planar(run, NAMES[i], k >= 2000, &truth, &belief.mean().pose(), p.matrix());
            }
            for (i, belief) in [(1, &left), (2, &right.to_local()), (4, &iekf), (5, &iterated)] {
                planar(run, NAMES[i], k >= 2000, &truth, belief.mean(), belief.covariance().matrix());
            }
        }
        Ok(())
    };
    MonteCarlo { runs, threads, ..MonteCarlo::default() }.run(simulation).ok()
}

bundle! {
    /// An extended pose as three things beside each other.
    struct FlatMotion { position: Rn<3> [3], rotation: SO3 [3], velocity: Rn<3> [3] }
}

impl FlatMotion {
    fn of(x: &SE23) -> Self {
        Self { position: Rn::new(x.position()), rotation: x.rotation(), velocity: Rn::new(x.velocity()) }
    }
    fn motion(&self) -> SE23 {
        SE23::new(self.rotation, self.position.vector(), self.velocity.vector())
    }
    /// From local errors of the extended pose to those of the three.
    fn chart(&self) -> Jacobian<f64, 9> {
        let mut t = Jacobian::<f64, 9>::identity();
        for i in [0, 6] {
            t.fixed_view_mut::<3, 3>(i, i).copy_from(&self.rotation.to_matrix());
        }
        t
    }
}

impl Motion<FlatMotion, 9, 6> for Flat<DeadReckoning> {
    type Input = Imu;
    fn step(&self, x: &FlatMotion, imu: &Imu, w: &SVector<f64, 6>) -> FlatMotion {
        FlatMotion::of(&self.0.step(&x.motion(), imu, w))
    }
    fn noise(&self, imu: &Imu) -> Covariance<6> {
        self.0.noise(imu)
    }
    fn step_jac(&self, x: &FlatMotion, imu: &Imu) -> (FlatMotion, Jacobian<f64, 9>, SMatrix<f64, 9, 6>) {
        let (next, f, g) = self.0.step_jac(&x.motion(), imu);
        let next = FlatMotion::of(&next);
        (next, next.chart() * f * x.chart().transpose(), next.chart() * g)
    }
}

const LANDMARKS: [Vector3<f64>; 3] =
    [vector![0.0, 2.0, 2.0], vector![-2.0, -2.0, -2.0], vector![2.0, -2.0, -2.0]];

/// All landmarks at once, each with 0.1 m.
struct Landmarks(SVector<f64, 9>);

impl Landmarks {
    fn each(&self) -> impl Iterator<Item = (usize, Sighting<3>)> {
        LANDMARKS.into_iter().enumerate().map(|(k, landmark)| {
            let measured = self.0.fixed_rows::<3>(3 * k).into_owned();
            (3 * k, Sighting { landmark, measured, noise: Covariance::unit() * 0.1 })
        })
    }
}

impl Measurement<SE23, 9, 9> for Landmarks {
    fn innovation(&self, x: &SE23) -> SVector<f64, 9> {
        self.innovation_jac(x).0
    }
    fn noise(&self) -> Covariance<9> {
        Covariance::unit() * 0.1
    }
    fn innovation_jac(&self, x: &SE23) -> (SVector<f64, 9>, Jacobian<f64, 9>) {
        let (mut z, mut h) = (SVector::<f64, 9>::zeros(), Jacobian::<f64, 9>::zeros());
        for (row, sighting) in self.each() {
            let (value, slope) = sighting.innovation_jac(x);
            z.fixed_rows_mut::<3>(row).copy_from(&value);
            h.fixed_rows_mut::<3>(row).copy_from(&slope);
        }
        (z, h)
    }
}

impl Measurement<FlatMotion, 9, 9> for Flat<Landmarks> {
    fn innovation(&self, x: &FlatMotion) -> SVector<f64, 9> {
        self.0.innovation(&x.motion())
    }
    fn noise(&self) -> Covariance<9> {
        self.0.noise()
    }
    fn innovation_jac(&self, x: &FlatMotion) -> (SVector<f64, 9>, Jacobian<f64, 9>) {
        let (z, h) = self.0.innovation_jac(&x.motion());
        (z, h * x.chart().transpose())
    }
}

/// Records an extended pose, local errors.
fn spatial(run: &mut Run, names: Names, truth: &SE23, mean: &SE23, p: &Jacobian<f64, 9>) {
    let turn = truth.rotation().rminus(&mean.rotation());
    let shift = mean.act_inverse(&truth.position());
    let block = |i: usize| Covariance::new(p.fixed_view::<3, 3>(i, i).into_owned());
    if let (Ok(linear), Ok(angular)) = (block(0), block(3)) {
        run.error(names[0], &turn, &angular);
        run.error(names[1], &shift, &linear);
    }
}

/// What an exact sensor shows on a circle of 5 m in 30 s, by the differences of positions that the authors take: the body starts
/// at rest, and is struck once.
fn circle(dt: f64, gravity: &Vector3<f64>) -> (SE23, Vec<Vector3<f64>>) {
    let place = |k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / 2999.0;
        vector![5.0 * angle.sin(), 5.0 * angle.cos(), 0.0]
    };
    let velocity = |k: usize| if k == 0 { Vector3::zeros() } else { (place(k) - place(k - 1)) / dt };
    let force = |k: usize| if k == 0 { -gravity } else { (velocity(k) - velocity(k - 1)) / dt - gravity };
    (SE23::new(SO3::identity(), place(0), Vector3::zeros()), (0..2999).map(force).collect())
}

/// Inertial navigation with three landmarks.
pub(crate) fn inertial(runs: usize, threads: std::num::NonZeroUsize) -> Option<Report> {
    const NAMES: [Names; 6] = [
        ["UKF on the product", "UKF on the product, m"],
        ["left UKF", "left UKF, m"],
        ["right UKF", "right UKF, m"],
        ["EKF", "EKF, m"],
        ["IEKF", "IEKF, m"],
        ["iterated IEKF", "iterated IEKF, m"],
    ];
    let dt: f64 = 0.01;
    // One number of deviation 0.01 a step is a density of 0.01·√Δ.
    let density = 0.01 * dt.sqrt();
    let noise = ImuNoise { gyroscope: density, accelerometer: density, ..ImuNoise::default() };
    let model = DeadReckoning { gravity: vector![0.0, 0.0, -9.82], noise };
    let (origin, forces) = circle(dt, &model.gravity);
    let (turn, shift) = (15_f64.to_radians() / 3_f64.sqrt(), 1.0 / 3_f64.sqrt());
    let prior = sigmas([shift, shift, shift, turn, turn, turn, 0.0, 0.0, 0.0]);
    let simulation = |rng: &mut ChaCha8Rng, run: &mut Run| -> Result<(), FilterError> {
        let mut truth = origin;
        let guess = SE23::new(
            truth.rotation().rplus(&(white::<3>(rng) * turn)),
            truth.position() + white::<3>(rng) * shift,
            truth.velocity(),
        );
        let start = Gaussian::<SE23, 9>::new(guess, prior);
        // The published filters on the product turn the rotation globally.
        let flat = Gaussian::<FlatMotion, 9>::new(FlatMotion::of(&guess), prior).to_global();
        let (mut flat_ukf, mut flat_ekf, mut left) = (flat, flat, start);
        let (mut right, mut iekf, mut iterated) = (start.to_global(), start.to_global(), start.to_global());
        for (k, force) in (1..3000).zip(&forces) {
            let exact = Imu { gyroscope: Vector3::zeros(), accelerometer: *force, duration: dt };
            truth = model.step(&truth, &exact, &SVector::zeros());
            let imu = Imu {
                gyroscope: white::<3>(rng) * 0.01,
                accelerometer: force + white::<3>(rng) * 0.01,
                duration: dt,
            };
            flat_ukf = UKF.predict(&flat_ukf, &Flat(model), &imu)?;
            flat_ekf = EKF.predict(&flat_ekf, &Flat(model), &imu)?;
            left = UKF.predict(&left, &model, &imu)?;
            right = UKF.predict(&right, &model, &imu)?;
            iekf = EKF.predict(&iekf, &model, &imu)?;
            iterated = ITERATED.predict(&iterated, &model, &imu)?;
            if k % 100 == 0 {
                let exact = -Landmarks(SVector::zeros()).innovation(&truth);
                let seen = exact + white::<9>(rng) * 0.1;
                flat_ukf = UKF.update(&flat_ukf, &Flat(Landmarks(seen))).belief;
                flat_ekf = EKF.update(&flat_ekf, &Flat(Landmarks(seen))).belief;
                left = UKF.update(&left, &Landmarks(seen)).belief;
                right = UKF.update(&right, &Landmarks(seen)).belief;
                iekf = EKF.update(&iekf, &Landmarks(seen)).belief;
                iterated = ITERATED.update(&iterated, &Landmarks(seen)).belief;
            }
            if k % 10 != 0 {
                continue;
            }
            for (i, belief) in [(0, &flat_ukf.to_local()), (3, &flat_ekf.to_local())] {
                let p = belief.covariance().transformed(&belief.mean().chart().transpose());
                spatial(run, NAMES[i], &truth, &belief.mean().motion(), p.matrix());
            }
            for (i, belief) in
                [(1, &left), (2, &right.to_local()), (4, &iekf.to_local()), (5, &iterated.to_local())]
            {
                spatial(run, NAMES[i], &truth, belief.mean(), belief.covariance().matrix());
            }
        }
        Ok(())
    };
    MonteCarlo { runs, threads, ..MonteCarlo::default() }.run(simulation).ok()
}

/// Attitude from a gyroscope, an accelerometer and a magnetometer, all at 100 Hz.
pub(crate) fn attitude(runs: usize, threads: std::num::NonZeroUsize) -> Option<Report> {
    fn corrected<E: Side>(
        filter: &impl Filter,
        belief: &Gaussian<SO3, 3, E>,
        odometry: &Odometry<3>,
        seen: &Vector3<f64>,
        vectors: &[VectorSighting<3>; 2],
    ) -> Result<Gaussian<SO3, 3, E>, FilterError> {
        let predicted = filter.predict(belief, odometry, seen)?;
        Ok(vectors.iter().fold(predicted, |belief, vector| filter.update(&belief, vector).belief))
    }
    let (dt, gyroscope) = (0.01, 5_f64.to_radians());
    let odometry = Odometry { noise: Covariance::unit() * (gyroscope * dt) };
    let known: [(Vector3<f64>, f64); 2] = [(vector![0.0, 0.0, -9.82], 0.4), (vector![0.33, 0.0, -0.95], 0.2)];
    let simulation = |rng: &mut ChaCha8Rng, run: &mut Run| -> Result<(), FilterError> {
        let mut truth = SO3::identity();
        let prior = Covariance::unit() * 10_f64.to_radians();
        let start = Gaussian::<SO3, 3>::new(truth.rplus(&(white::<3>(rng) * 10_f64.to_radians())), prior);
        let (mut left, mut right, mut ekf) = (start, start.to_global(), start.to_global());
        for k in 1..10_000 {
            let rate = if k > 200 { vector![0.0, 0.0, 10_f64.to_radians()] } else { Vector3::zeros() };
            truth = truth.rplus(&(rate * dt));
            let seen = (rate + white::<3>(rng) * gyroscope) * dt;
            let vectors = known.map(|(reference, sigma)| VectorSighting {
                reference,
                measured: truth.act_inverse(&(reference + white::<3>(rng) * sigma)),
                noise: Covariance::unit() * sigma,
            });
            left = corrected(&UKF, &left, &odometry, &seen, &vectors)?;
            right = corrected::<Global>(&UKF, &right, &odometry, &seen, &vectors)?;
            ekf = corrected::<Global>(&EKF, &ekf, &odometry, &seen, &vectors)?;
            if k % 10 == 0 {
                run.state("left UKF", &truth, &left);
                run.state("right UKF", &truth, &right);
                run.state("EKF", &truth, &ekf);
            }
        }
        Ok(())
    };
    MonteCarlo { runs, threads, ..MonteCarlo::default() }.run(simulation).ok()
}
