//! Motions told as differential equations with white noise.

use super::Motion;
use crate::lie::{Jacobian, LieGroup, Real, Tangent};
use crate::trajectory::{Integrator, discretise, local_error_dynamics};
use crate::uncertainty::Covariance;

/// A motion in continuous time, Ẋ = X·(f(X, u) + w)^: f ∈ ℝᴰ the velocity in the frame of the body, w ∈ ℝᴰ white noise of density Q,
/// E\[w(t)w(s)ᵀ\] = Q·δ(t − s).
///
/// [`Discretised`] makes it a [`Motion`]. Densities are those of data sheets, per √Hz.
///
/// ```
/// use boxplus::filter::{Discretised, Ekf, Filter, Flow, check_motion};
/// use boxplus::lie::{LieGroup, SE2};
/// use boxplus::uncertainty::{Covariance, Gaussian};
/// use nalgebra::{Matrix3, Vector2, Vector3, vector};
///
/// /// A boat in a current that is known in the world; its rudder trembles.
/// struct Boat { current: Vector2<f64> }
/// impl Flow<SE2, 3> for Boat {
///     type Input = (f64, f64); // m/s ahead, rad/s
///     fn velocity(&self, x: &SE2, (ahead, turn): &(f64, f64)) -> Vector3<f64> {
///         let drift = x.rotation().inverse().to_matrix() * self.current;
///         vector![ahead + drift.x, drift.y, *turn]
///     }
///     fn velocity_jac(&self, x: &SE2, u: &(f64, f64)) -> (Vector3<f64>, Matrix3<f64>) {
///         let drift = x.rotation().inverse().to_matrix() * self.current;
///         let mut d_x = Matrix3::zeros();
///         (d_x[(0, 2)], d_x[(1, 2)]) = (drift.y, -drift.x); // the current, seen from a body that turned
///         (self.velocity(x, u), d_x)
///     }
///     fn density(&self, _: &SE2, _: &(f64, f64)) -> Covariance<3> {
///         Covariance::<1>::unit().transformed(&vector![0.0, 0.0, 0.1]) // rad/s/√Hz
///     }
/// }
/// let boat = Discretised { flow: Boat { current: vector![0.5, -0.2] }, steps: 4 };
/// let start = Gaussian::<SE2, 3>::certain(SE2::new(vector![1.0, 2.0], 0.5));
/// let moved = Ekf::default().predict(&start, &boat, &((2.0, 0.1), 0.5))?; // for half a second
/// assert!((moved.sigmas()[2] - 0.1 * 0.5_f64.sqrt()).abs() < 1e-15);
/// // Sideways: the integral of a random walk that a speed of 2 m/s multiplies.
/// let sideways = 2.0 * 0.1 * (0.5_f64.powi(3) / 3.0).sqrt();
/// assert!((moved.sigmas()[1] / sideways - 1.0).abs() < 0.01);
/// # Ok::<(), boxplus::filter::FilterError>(())
/// ```
pub trait Flow<G: LieGroup<D>, const D: usize> {
    /// u, held over the step.
    type Input;
    /// f(X, u), in the units of the tangent per second.
    fn velocity(&self, x: &G, input: &Self::Input) -> Tangent<G::Scalar, D>;
    /// `(f, ∂f/∂X)`, the right (local) Jacobian, D×D.
    fn velocity_jac(&self, x: &G, input: &Self::Input) -> (Tangent<G::Scalar, D>, Jacobian<G::Scalar, D>);
    /// Q, D×D, in the units of f, squared, times seconds. Of noise that enters by L, D×W:
    /// [`Covariance::transformed`] by L.
    fn density(&self, x: &G, input: &Self::Input) -> Covariance<D, G::Scalar>;
}

/// A [`Flow`] over steps of time: the input is (u, Δ in seconds).
///
/// ```text
/// mean   by the commutator-free method of order 4 (Celledoni, Marthinsen & Owren 2003)
/// error  ξ̇ = A·ξ + w,  A = ∂f/∂X − ad_f, held at the middle of each part of the step: Φ and Q_d by van Loan (1978)
/// ```
/// Φ is right to second order in Δ/`steps`: check it by [`check_motion`](super::check_motion) at the longest step you take. The
/// disturbance of a step is √Q_d·w, w ~ N(0, I), so that noise reaches coordinates it does not enter itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Discretised<F> {
    /// What moves.
    pub flow: F,
    /// Parts into which each step is cut, at least 1.
    pub steps: usize,
}

impl<F> Discretised<F> {
    /// `(X(t + Δ), Φ, Q_d)`; NaN where the step is no duration.
    fn moved<G: LieGroup<D>, const D: usize>(
        &self,
        x: &G,
        (input, duration): &(F::Input, G::Scalar),
    ) -> (G, Jacobian<G::Scalar, D>, Jacobian<G::Scalar, D>)
    where
        F: Flow<G, D>,
    {
        let h = self.part(*duration);
        let (mut x, mut phi, mut q) = (*x, Jacobian::identity(), Jacobian::zeros());
        for _ in 0..self.steps.max(1) {
            let middle = self.advanced(&x, input, h * G::Scalar::lit(0.5));
            let (f, d_x) = self.flow.velocity_jac(&middle, input);
            let a = d_x + local_error_dynamics::<G, D>(&f);
            let density = self.flow.density(&middle, input);
            let Ok((part, noise)) = discretise(&a, &Jacobian::identity(), density.matrix(), h) else {
                let nan = G::Scalar::lit(f64::NAN);
                return (x.rplus(&Tangent::repeat(nan)), Jacobian::repeat(nan), Jacobian::repeat(nan));
            };
            x = self.advanced(&x, input, h);
            (phi, q) = (part * phi, part * q * part.transpose() + noise);
        }
        (x, phi, q)
    }

    /// Δ of one part.
    fn part<S: Real>(&self, duration: S) -> S {
        duration * S::lit(1.0 / self.steps.max(1) as f64)
    }

    fn advanced<G: LieGroup<D>, const D: usize>(&self, x: &G, input: &F::Input, h: G::Scalar) -> G
    where
        F: Flow<G, D>,
    {
        let start = G::Scalar::lit(0.0);
        Integrator::CommutatorFree4.step(x, start, h, |_, x: &G| self.flow.velocity(x, input))
    }
}

impl<G: LieGroup<D>, F: Flow<G, D>, const D: usize> Motion<G, D, D> for Discretised<F> {
    type Input = (F::Input, G::Scalar);

    fn step(&self, x: &G, input: &Self::Input, noise: &Tangent<G::Scalar, D>) -> G {
        let (next, _, q) = self.moved(x, input);
        next.rplus(&(Covariance::by_construction(q).factor() * noise))
    }
    fn noise(&self, _: &Self::Input) -> Covariance<D, G::Scalar> {
        Covariance::unit()
    }
    fn step_jac(&self, x: &G, input: &Self::Input) -> (G, Jacobian<G::Scalar, D>, Jacobian<G::Scalar, D>) {
        let (next, phi, q) = self.moved(x, input);
        (next, phi, Covariance::by_construction(q).factor())
    }
}
