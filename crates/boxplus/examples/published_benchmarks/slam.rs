//! The fourth simulation: a robot that maps twenty landmarks while it drives in a circle.

use super::{EKF, ITERATED, UKF, sigmas, white};
use boxplus::filter::{Filter, FilterError, Measurement, MonteCarlo, Motion, Report, Run};
use boxplus::lie::{Action, Jacobian, LieGroup, Real, SE2, SO2};
use boxplus::uncertainty::{Covariance, Gaussian, Global, Side};
use nalgebra::{Matrix2, SMatrix, SVector, Vector2, vector};
use rand_chacha::ChaCha8Rng;
use std::any::TypeId;

const LANDMARKS: usize = 20;
/// Heading, robot, landmarks.
const D: usize = 3 + 2 * LANDMARKS;

/// A heading with the places of a robot (the first) and of landmarks: SE₁₊ₗ(2), whose exponential turns all places; or, `FLAT`, the
/// product SO(2)×ℝ², which nothing couples. Tangent (θ, ρ₀, ρ₁, …).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Map<const FLAT: bool, S: Real = f64> {
    heading: SO2<S>,
    places: [Vector2<S>; 1 + LANDMARKS],
}

fn quarter<S: Real>() -> Matrix2<S> {
    Matrix2::new(S::zero(), -S::one(), S::one(), S::zero())
}

fn part<S: Real>(tau: &SVector<S, D>, i: usize) -> Vector2<S> {
    tau.fixed_rows::<2>(1 + 2 * i).into_owned()
}

/// A matrix from the blocks `(ρᵢ by ρᵢ, ρᵢ by θ)` and `θ by θ`.
fn blocks<S: Real>(turn: S, of: impl Fn(usize) -> (Matrix2<S>, Vector2<S>)) -> Jacobian<S, D> {
    let mut m = Jacobian::<S, D>::zeros();
    m[(0, 0)] = turn;
    for i in 0..=LANDMARKS {
        let (place, heading) = of(i);
        m.fixed_view_mut::<2, 2>(1 + 2 * i, 1 + 2 * i).copy_from(&place);
        m.fixed_view_mut::<2, 1>(1 + 2 * i, 0).copy_from(&heading);
    }
    m
}

impl<const FLAT: bool, S: Real> Map<FLAT, S> {
    /// A Jacobian of SE(2), for every place.
    fn of_each(tau: &SVector<S, D>, jacobian: impl Fn(&SVector<S, 3>) -> Jacobian<S, 3>) -> Jacobian<S, D> {
        if FLAT {
            return Jacobian::identity();
        }
        blocks(S::one(), |i| {
            let rho = part(tau, i);
            let j = jacobian(&vector![rho.x, rho.y, tau[0]]);
            (j.fixed_view::<2, 2>(0, 0).into_owned(), j.fixed_view::<2, 1>(0, 2).into_owned())
        })
    }
}

impl<const FLAT: bool, S: Real> LieGroup<D> for Map<FLAT, S> {
    type Scalar = S;
    type Over<T: Real> = Map<FLAT, T>;
    type Algebra = SVector<S, D>;

    fn identity() -> Self {
        Self { heading: SO2::identity(), places: [Vector2::zeros(); 1 + LANDMARKS] }
    }
    fn compose(&self, rhs: &Self) -> Self {
        let moved = |i: usize| if FLAT { rhs.places[i] } else { self.heading.act(&rhs.places[i]) };
        Self {
            heading: self.heading.compose(&rhs.heading),
            places: std::array::from_fn(|i| self.places[i] + moved(i)),
        }
    }
    fn inverse(&self) -> Self {
        let moved = |p: Vector2<S>| if FLAT { -p } else { -self.heading.act_inverse(&p) };
        Self { heading: self.heading.inverse(), places: self.places.map(moved) }
    }
    fn exp(tau: &SVector<S, D>) -> Self {
        let place = |i: usize| {
            let rho = part(tau, i);
            if FLAT { rho } else { SE2::exp(&vector![rho.x, rho.y, tau[0]]).translation() }
        };
        Self { heading: SO2::from_angle(tau[0]), places: std::array::from_fn(place) }
    }
    fn log(&self) -> SVector<S, D> {
        let mut tau = SVector::<S, D>::zeros();
        tau[0] = self.heading.angle();
        for (i, p) in self.places.iter().enumerate() {
            let rho =
                if FLAT { *p } else { SE2::from_parts(*p, self.heading).log().fixed_rows::<2>(0).into() };
            tau.fixed_rows_mut::<2>(1 + 2 * i).copy_from(&rho);
        }
        tau
    }
    fn adjoint(&self) -> Jacobian<S, D> {
        if FLAT {
            return Jacobian::identity();
        }
        let turned = self.heading.to_matrix();
        blocks(S::one(), |i| (turned, -(quarter::<S>() * self.places[i])))
    }
    fn small_adjoint(tau: &SVector<S, D>) -> Jacobian<S, D> {
        if FLAT {
            return Jacobian::zeros();
        }
        blocks(S::zero(), |i| (quarter::<S>() * tau[0], -(quarter::<S>() * part(tau, i))))
    }
    fn right_jacobian(tau: &SVector<S, D>) -> Jacobian<S, D> {
        Self::of_each(tau, SE2::right_jacobian)
    }
    fn right_jacobian_inverse(tau: &SVector<S, D>) -> Jacobian<S, D> {
        Self::of_each(tau, SE2::right_jacobian_inverse)
    }
    fn hat(tau: &SVector<S, D>) -> SVector<S, D> {
        *tau
    }
    fn vee(algebra: &SVector<S, D>) -> SVector<S, D> {
        *algebra
    }
    fn map<T: Real>(&self, f: impl Fn(S) -> T) -> Map<FLAT, T> {
        Map { heading: self.heading.map(&f), places: self.places.map(|p| p.map(&f)) }
    }
}

/// Odometry by an Euler step: p⁺ = p + R·(v + w₁, 0), R⁺ = R·Exp(ω + w₂), once a second. The input is (v, ω).
struct Drive(Covariance<2>);

impl<const FLAT: bool> Motion<Map<FLAT>, D, 2> for Drive {
    type Input = Vector2<f64>;

    fn step(&self, x: &Map<FLAT>, u: &Vector2<f64>, w: &Vector2<f64>) -> Map<FLAT> {
        let mut next = *x;
        next.places[0] += x.heading.act(&vector![u.x + w.x, 0.0]);
        next.heading = x.heading.compose(&SO2::from_angle(u.y + w.y));
        next
    }
    fn noise(&self, _: &Vector2<f64>) -> Covariance<2> {
        self.0
    }
    fn step_jac(&self, x: &Map<FLAT>, u: &Vector2<f64>) -> (Map<FLAT>, Jacobian<f64, D>, SMatrix<f64, D, 2>) {
        let (next, f, g) = self.step_left_jac(x, u);
        if FLAT {
            return (next, f, g);
        }
        let back = next.inverse().adjoint();
        (next, back * x.adjoint(), back * g)
    }
    fn step_left_jac(
        &self,
        x: &Map<FLAT>,
        u: &Vector2<f64>,
    ) -> (Map<FLAT>, Jacobian<f64, D>, SMatrix<f64, D, 2>) {
        let next = self.step(x, u, &Vector2::zeros());
        let (mut f, mut g) = (Jacobian::<f64, D>::identity(), SMatrix::<f64, D, 2>::zeros());
        g[(0, 1)] = 1.0;
        g.fixed_view_mut::<2, 1>(1, 0).copy_from(&x.heading.act(&vector![1.0, 0.0]));
        if FLAT {
            let swing = quarter() * x.heading.act(&vector![u.x, 0.0]);
            f.fixed_view_mut::<2, 1>(1, 0).copy_from(&swing);
        } else {
            for (i, p) in next.places.iter().enumerate() {
                g.fixed_view_mut::<2, 1>(1 + 2 * i, 1).copy_from(&-(quarter() * p));
            }
        }
        (next, f, g)
    }
}

/// Landmark i in the frame of the robot, y = Rᵀ(pᵢ − p₀) + n.
struct Seen {
    landmark: usize,
    measured: Vector2<f64>,
    noise: Covariance<2>,
}

impl Seen {
    fn slope(&self, place: &Matrix2<f64>, heading: &Vector2<f64>) -> SMatrix<f64, 2, D> {
        let mut h = SMatrix::<f64, 2, D>::zeros();
        h.fixed_view_mut::<2, 1>(0, 0).copy_from(heading);
        h.fixed_view_mut::<2, 2>(0, 1).copy_from(&-place);
        h.fixed_view_mut::<2, 2>(0, 1 + 2 * self.landmark).copy_from(place);
        h
    }

    /// The belief with the landmark in it, seen for the first time.
    fn added<const FLAT: bool, E: Side>(
        &self,
        belief: &Gaussian<Map<FLAT>, D, E>,
    ) -> Gaussian<Map<FLAT>, D, E> {
        let (mut mean, row) = (*belief.mean(), 1 + 2 * self.landmark);
        mean.places[self.landmark] = mean.places[0] + mean.heading.act(&self.measured);
        let global = TypeId::of::<E>() == TypeId::of::<Global>();
        // Errors of the new place by those of heading and robot, and by n.
        let (by_heading, by_noise) = match (FLAT, global) {
            (true, _) => (quarter() * mean.heading.act(&self.measured), mean.heading.to_matrix()),
            (false, true) => (Vector2::zeros(), mean.heading.to_matrix()),
            (false, false) => (quarter() * self.measured, Matrix2::identity()),
        };
        let mut t = Jacobian::<f64, D>::identity();
        t.fixed_view_mut::<2, 2>(row, row).fill(0.0);
        t.fixed_view_mut::<2, 2>(row, 1).fill_with_identity();
        t.fixed_view_mut::<2, 1>(row, 0).copy_from(&by_heading);
        let mut n = SMatrix::<f64, D, 2>::zeros();
        n.fixed_view_mut::<2, 2>(row, 0).copy_from(&by_noise);
        Gaussian::new(mean, belief.covariance().transformed(&t) + self.noise.transformed(&n))
    }
}

impl<const FLAT: bool> Measurement<Map<FLAT>, D, 2> for Seen {
    fn innovation(&self, x: &Map<FLAT>) -> Vector2<f64> {
        self.measured - x.heading.act_inverse(&(x.places[self.landmark] - x.places[0]))
    }
    fn noise(&self) -> Covariance<2> {
        self.noise
    }
    fn innovation_jac(&self, x: &Map<FLAT>) -> (Vector2<f64>, SMatrix<f64, 2, D>) {
        let z = Measurement::<Map<FLAT>, D, 2>::innovation(self, x);
        let place = if FLAT { x.heading.to_matrix().transpose() } else { Matrix2::identity() };
        (z, self.slope(&place, &-(quarter() * (self.measured - z))))
    }
    fn innovation_left_jac(&self, x: &Map<FLAT>) -> (Vector2<f64>, SMatrix<f64, 2, D>) {
        if FLAT {
            return self.innovation_jac(x);
        }
        let z = Measurement::<Map<FLAT>, D, 2>::innovation(self, x);
        (z, self.slope(&x.heading.to_matrix().transpose(), &Vector2::zeros()))
    }
}

/// What a robot sees at one time: new landmarks apart.
struct Glance {
    odometry: Vector2<f64>,
    known: Vec<Seen>,
    new: Vec<Seen>,
}

fn filtered<const FLAT: bool, E: Side>(
    filter: &impl Filter,
    drive: &Drive,
    belief: &Gaussian<Map<FLAT>, D, E>,
    glance: &Glance,
) -> Result<Gaussian<Map<FLAT>, D, E>, FilterError> {
    let predicted = filter.predict(belief, drive, &glance.odometry)?;
    let corrected = glance.known.iter().fold(predicted, |belief, seen| filter.update(&belief, seen).belief);
    Ok(glance.new.iter().fold(corrected, |belief, seen| seen.added(&belief)))
}

fn record<const FLAT: bool>(
    run: &mut Run,
    names: super::Names,
    truth: &SE2,
    belief: &Gaussian<Map<FLAT>, D>,
) {
    let (mean, p) = (belief.mean(), belief.covariance());
    let turn = mean.heading.between(&truth.rotation()).angle();
    let shift = truth.translation() - mean.places[0];
    let shift = if FLAT { shift } else { mean.heading.act_inverse(&shift) };
    let angular = Covariance::<1>::new(p.matrix().fixed_view::<1, 1>(0, 0).into_owned());
    let linear = Covariance::<2>::new(p.matrix().fixed_view::<2, 2>(1, 1).into_owned());
    if let (Ok(angular), Ok(linear)) = (angular, linear) {
        run.error(names[0], &vector![turn], &angular);
        run.error(names[1], &shift, &linear);
    }
}

/// A robot on a circle of 9.5 m at 1 Hz for 2500 s; landmarks 3 m outside it are seen from 1 m to 5 m. Recorded every tenth second.
pub(crate) fn slam(experiment: &MonteCarlo) -> Option<Report> {
    const NAMES: [super::Names; 7] = [
        ["UKF on the product", "UKF on the product, m"],
        ["left UKF", "left UKF, m"],
        ["right UKF", "right UKF, m"],
        ["EKF", "EKF, m"],
        ["IEKF", "IEKF, m"],
        ["iterated IEKF", "iterated IEKF, m"],
        ["iterated left IEKF", "iterated left IEKF, m"],
    ];
    let u = vector![0.25, 1.5_f64.to_radians()];
    let deviations = [0.05 * u.x / 2_f64.sqrt(), 0.1 * u.x * 2_f64.sqrt()];
    let (drive, noise) = (Drive(sigmas(deviations)), sigmas([0.1, 0.1]));
    let radius = u.x / u.y;
    let places: [Vector2<f64>; LANDMARKS] = std::array::from_fn(|i| {
        let angle = std::f64::consts::TAU * i as f64 / LANDMARKS as f64;
        vector![angle.cos(), angle.sin()] * (radius + 3.0) + vector![0.0, radius]
    });
    let simulation = |rng: &mut ChaCha8Rng, run: &mut Run| -> Result<(), FilterError> {
        let mut truth = SE2::identity();
        let start = Gaussian::<Map<false>, D>::certain(Map::identity());
        let flat = Gaussian::<Map<true>, D>::certain(Map::identity());
        let (mut flat_ukf, mut left, mut right) = (flat, start, start.to_global());
        let (mut ekf, mut iekf, mut iterated, mut iterated_left) =
            (flat, start.to_global(), start.to_global(), start);
        let mut met = [false; LANDMARKS];
        for k in 1..2500 {
            let step = truth.rotation().act(&vector![u.x, 0.0]);
            truth =
                SE2::from_parts(truth.translation() + step, truth.rotation().compose(&SO2::from_angle(u.y)));
            let odometry = u + white::<2>(rng).component_mul(&Vector2::from(deviations));
            let (mut known, mut new) = (Vec::new(), Vec::new());
            for (i, place) in places.iter().enumerate() {
                let seen = truth.act_inverse(place);
                if (1.0..5.0).contains(&seen.norm()) {
                    let seen = Seen { landmark: 1 + i, measured: seen + white::<2>(rng) * 0.1, noise };
                    if std::mem::replace(&mut met[i], true) { known.push(seen) } else { new.push(seen) }
                }
            }
            let glance = Glance { odometry, known, new };
            flat_ukf = filtered(&UKF, &drive, &flat_ukf, &glance)?;
            left = filtered(&UKF, &drive, &left, &glance)?;
            right = filtered(&UKF, &drive, &right, &glance)?;
            ekf = filtered(&EKF, &drive, &ekf, &glance)?;
            iekf = filtered(&EKF, &drive, &iekf, &glance)?;
            iterated = filtered(&ITERATED, &drive, &iterated, &glance)?;
            iterated_left = filtered(&ITERATED, &drive, &iterated_left, &glance)?;
            if k >= 10 && k % 10 == 0 {
                record(run, NAMES[0], &truth, &flat_ukf);
                record(run, NAMES[3], &truth, &ekf);
                record(run, NAMES[1], &truth, &left);
                record(run, NAMES[6], &truth, &iterated_left);
                for (i, belief) in [(2, &right), (4, &iekf), (5, &iterated)] {
                    record(run, NAMES[i], &truth, &belief.to_local());
                }
            }
        }
        Ok(())
    };
    experiment.run(simulation).ok()
}
