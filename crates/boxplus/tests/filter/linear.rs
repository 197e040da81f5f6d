//! On ℝⁿ every filter is Kalman's.

use boxplus::filter::{Ekf, Filter, Measurement, Motion, Ukf};
use boxplus::lie::Rn;
use boxplus::uncertainty::{Covariance, Gaussian, Global, Local, Side};
use nalgebra::{Matrix2, Matrix2x1, RowVector2, SVector, Vector2, matrix, vector};

/// A cart on a track: position and velocity, pushed at random.
pub(crate) struct Cart;
pub(crate) const F: Matrix2<f64> = matrix![1.0, 0.1; 0.0, 0.98];
pub(crate) const G: Matrix2x1<f64> = matrix![0.005; 0.1];
pub(crate) const Q: f64 = 0.09;

impl Motion<Rn<2>, 2, 1> for Cart {
    type Input = f64;
    fn step(&self, x: &Rn<2>, push: &f64, w: &SVector<f64, 1>) -> Rn<2> {
        Rn::new(F * x.vector() + G * (push + w[0]))
    }
    fn noise(&self, _: &f64) -> Covariance<1> {
        Covariance::unit() * Q.sqrt()
    }
    fn step_jac(&self, x: &Rn<2>, push: &f64) -> (Rn<2>, Matrix2<f64>, Matrix2x1<f64>) {
        (self.step(x, push, &SVector::zeros()), F, G)
    }
}

/// Its position, seen through a tilted lens.
pub(crate) struct Lens(pub(crate) f64);
pub(crate) const H: RowVector2<f64> = matrix![0.9, 0.2];
pub(crate) const N: f64 = 0.04;

impl Measurement<Rn<2>, 2, 1> for Lens {
    fn innovation(&self, x: &Rn<2>) -> SVector<f64, 1> {
        vector![self.0] - H * x.vector()
    }
    fn noise(&self) -> Covariance<1> {
        Covariance::unit() * N.sqrt()
    }
    fn innovation_jac(&self, x: &Rn<2>) -> (SVector<f64, 1>, RowVector2<f64>) {
        (self.innovation(x), H)
    }
}

/// Kalman's equations as in every textbook, with P ← (I − KH)P.
fn textbook(steps: &[(f64, f64)]) -> (Vector2<f64>, Matrix2<f64>) {
    let (mut x, mut p) = (vector![1.0, -1.0], Matrix2::from_diagonal(&vector![4.0, 1.0]));
    for (push, seen) in steps {
        x = F * x + G * *push;
        p = F * p * F.transpose() + G * Q * G.transpose();
        let s = (H * p * H.transpose())[(0, 0)] + N;
        let k = p * H.transpose() / s;
        x += k * (seen - (H * x)[(0, 0)]);
        p = (Matrix2::identity() - k * H) * p;
    }
    (x, p)
}

fn run<E: Side>(filter: &impl Filter, steps: &[(f64, f64)]) -> (Vector2<f64>, Matrix2<f64>) {
    let mut belief =
        Gaussian::<Rn<2>, 2, E>::from_sigmas(Rn::new(vector![1.0, -1.0]), &vector![2.0, 1.0]).unwrap();
    for (push, seen) in steps {
        belief = filter.predict(&belief, &Cart, push).unwrap();
        let update = filter.update(&belief, &Lens(*seen));
        assert!(update.is_accepted());
        belief = update.belief;
    }
    (belief.mean().vector(), *belief.covariance().matrix())
}

/// A square, as a motion and as a measurement.
struct Square;

impl Motion<Rn<1>, 1, 1> for Square {
    type Input = ();
    fn step(&self, x: &Rn<1>, (): &(), w: &SVector<f64, 1>) -> Rn<1> {
        let x = x.vector() + w;
        Rn::new(x.component_mul(&x))
    }
    fn noise(&self, (): &()) -> Covariance<1> {
        Covariance::zero()
    }
    fn step_jac(&self, x: &Rn<1>, (): &()) -> (Rn<1>, SVector<f64, 1>, SVector<f64, 1>) {
        (self.step(x, &(), &SVector::zeros()), x.vector() * 2.0, x.vector() * 2.0)
    }
}

impl Measurement<Rn<1>, 1, 1> for Square {
    fn innovation(&self, x: &Rn<1>) -> SVector<f64, 1> {
        vector![3.0] - x.vector().component_mul(&x.vector())
    }
    fn noise(&self) -> Covariance<1> {
        Covariance::unit()
    }
    fn innovation_jac(&self, x: &Rn<1>) -> (SVector<f64, 1>, SVector<f64, 1>) {
        (self.innovation(x), x.vector() * 2.0)
    }
}

#[test]
fn sigma_points_know_the_moments_of_a_square_at_any_spread() {
    // x ~ N(m, σ²): E[x²] = m² + σ², Var[x²] = 4m²σ² + 2σ⁴, Cov[x, x²] = 2mσ².
    let (m, s) = (1.5_f64, 0.4_f64);
    let prior = Gaussian::<Rn<1>, 1>::from_sigmas(Rn::new(vector![m]), &vector![s]).unwrap();
    let variance = 4.0 * m * m * s * s + 2.0 * s.powi(4);
    for alpha in [0.01, 0.3, 1.0] {
        let ukf = Ukf { alpha, ..Ukf::default() };
        let moved = ukf.predict_joint(&prior, &Square, &()).unwrap();
        assert!((moved.belief.covariance().matrix()[(0, 0)] - variance).abs() < 1e-12);
        assert!((moved.transition[(0, 0)] - 2.0 * m).abs() < 1e-12);
        assert!((moved.disturbance.matrix()[(0, 0)] - 2.0 * s.powi(4)).abs() < 1e-12);
        let update = ukf.update(&prior, &Square);
        let innovation = update.innovation().unwrap();
        assert!((innovation.value[0] - (3.0 - m * m - s * s)).abs() < 1e-12);
        assert!((innovation.covariance.matrix()[(0, 0)] - variance - 1.0).abs() < 1e-12);
        let cross = 2.0 * m * s * s;
        let left = s * s - cross * cross / (variance + 1.0);
        assert!((update.belief.covariance().matrix()[(0, 0)] - left).abs() < 1e-12);
        let gained = cross / (variance + 1.0) * innovation.value[0];
        assert!((update.belief.mean().vector()[0] - m - gained).abs() < 1e-12);
    }
}

#[test]
fn a_linear_system_gives_the_textbook_filter() {
    let steps: Vec<(f64, f64)> =
        (0..50).map(|k| ((0.3 * f64::from(k)).sin(), (0.1 * f64::from(k)).cos())).collect();
    let (x, p) = textbook(&steps);
    let agrees = |(y, q): (Vector2<f64>, Matrix2<f64>), bound: f64| {
        assert!(
            (y - x).norm() < bound && (q - p).norm() < bound,
            "{:e} {:e}",
            (y - x).norm(),
            (q - p).norm()
        );
    };
    agrees(run::<Local>(&Ekf::default(), &steps), 1e-13);
    agrees(run::<Global>(&Ekf::iterated(), &steps), 1e-13);
    agrees(run::<Local>(&Ukf::default(), &steps), 1e-13);
    agrees(run::<Global>(&Ukf { alpha: 1.0, ..Ukf::default() }, &steps), 1e-13);
    // The published spread: the mean is a second difference over 1e-3 standard deviations, rounded to ε/α² ≈ 2e-10.
    agrees(run::<Local>(&Ukf { alpha: 1e-3, ..Ukf::default() }, &steps), 2e-10);
}
