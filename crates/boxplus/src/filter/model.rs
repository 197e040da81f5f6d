//! What a user writes: how the state moves, and what sensors see of it.

use super::FilterError;
use crate::lie::{Jacobian, LieGroup, Real};
use crate::uncertainty::{Covariance, Local, Side};
use core::any::TypeId;
use core::cell::Cell;
use nalgebra::{SMatrix, SVector};

/// One step of a state of the group G, dimension D, disturbed by w ∈ ℝᵂ: x⁺ = f(x, u, w), w ~ N(0, Q).
///
/// Write [`Motion::step`], the disturbance included, [`Motion::noise`], and the Jacobians in closed form; or write a residual
/// for every scalar and let dual numbers find them (`ByDuals`, feature `autodiff`). An error made in a closed form shows in
/// [`check_motion`](super::check_motion).
///
/// ```
/// use boxplus::filter::{Motion, check_motion};
/// use boxplus::lie::{LieGroup, SE2};
/// use boxplus::uncertainty::Covariance;
/// use nalgebra::{Matrix3, Matrix3x1, SVector, vector};
///
/// /// A train: it knows its track, and slips along it.
/// struct Train { along: f64, curvature: f64 }
/// impl Motion<SE2, 3, 1> for Train {
///     type Input = f64; // metres driven
///     fn step(&self, x: &SE2, driven: &f64, slip: &SVector<f64, 1>) -> SE2 {
///         x.rplus(&(vector![1.0, 0.0, self.curvature] * (driven + slip[0])))
///     }
///     fn noise(&self, driven: &f64) -> Covariance<1> {
///         Covariance::unit() * (self.along * driven.abs().sqrt())
///     }
///     fn step_jac(&self, x: &SE2, driven: &f64) -> (SE2, Matrix3<f64>, Matrix3x1<f64>) {
///         let track = vector![1.0, 0.0, self.curvature];
///         let (next, d_x, d_tau) = x.rplus_jac(&(track * *driven));
///         (next, d_x, d_tau * track)
///     }
/// }
/// let train = Train { along: 0.01, curvature: 0.002 };
/// assert!(check_motion(&train, &SE2::new(vector![3.0, 1.0], 0.4), &10.0) < 1e-8);
/// ```
pub trait Motion<G: LieGroup<D>, const D: usize, const W: usize> {
    /// u: what is known about the step, such as an odometer's reading; `()` where nothing is.
    type Input;

    /// f(x, u, w).
    fn step(&self, x: &G, input: &Self::Input, noise: &SVector<G::Scalar, W>) -> G;
    /// Q, W×W: the covariance of w during this step.
    fn noise(&self, input: &Self::Input) -> Covariance<W, G::Scalar>;
    /// `(f(x, u, 0), F, G)`: the right (local) Jacobians by x, D×D, and by w, D×W.
    fn step_jac(&self, x: &G, input: &Self::Input) -> (G, Jacobian<G::Scalar, D>, SMatrix<G::Scalar, D, W>);

    /// The same with left (global) Jacobians, Ad_{x⁺}·F·Ad_x⁻¹ and Ad_{x⁺}·G: exact, Solà et al. (2018) (46). Override where the
    /// left form is simpler.
    fn step_left_jac(
        &self,
        x: &G,
        input: &Self::Input,
    ) -> (G, Jacobian<G::Scalar, D>, SMatrix<G::Scalar, D, W>) {
        let (next, d_x, d_w) = self.step_jac(x, input);
        let ad = next.adjoint();
        (next, ad * d_x * x.inverse().adjoint(), ad * d_w)
    }
}

/// A measurement in ℝᴹ of a state of the group G, dimension D, with the value read off the sensor inside.
///
/// The innovation z(x) is what was measured minus what the state x predicts, with angles wrapped. Its Jacobian has the sign
/// of the *prediction*: z(x ⊞ τ) ≈ z(x) − H·τ, so that for z = y − h(x) H is ∂h/∂x, as in the textbooks. Closed forms are
/// tried by [`check_measurement`](super::check_measurement).
///
/// ```
/// use boxplus::filter::{Measurement, check_measurement};
/// use boxplus::lie::{LieGroup, SE2};
/// use boxplus::uncertainty::Covariance;
/// use nalgebra::{RowVector3, SVector, vector};
///
/// /// A compass: the heading in radians.
/// struct Compass { heading: f64 }
/// impl Measurement<SE2, 3, 1> for Compass {
///     fn innovation(&self, x: &SE2) -> SVector<f64, 1> {
///         let wrapped = SE2::new(vector![0.0, 0.0], self.heading - x.angle()).angle();
///         vector![wrapped]
///     }
///     fn noise(&self) -> Covariance<1> {
///         Covariance::unit() * 0.02
///     }
///     fn innovation_jac(&self, x: &SE2) -> (SVector<f64, 1>, RowVector3<f64>) {
///         (self.innovation(x), RowVector3::new(0.0, 0.0, 1.0))
///     }
/// }
/// let x = SE2::new(vector![0.0, 0.0], -3.0);
/// assert!(Compass { heading: 3.0 }.innovation(&x)[0].abs() < 0.3);
/// assert!(check_measurement(&Compass { heading: 3.0 }, &x) < 1e-8);
/// ```
pub trait Measurement<G: LieGroup<D>, const D: usize, const M: usize> {
    /// z(x), in the units of the measurement.
    fn innovation(&self, x: &G) -> SVector<G::Scalar, M>;
    /// N, M×M: the covariance of the sensor's error.
    fn noise(&self) -> Covariance<M, G::Scalar>;
    /// `(z, H)` with the right (local) Jacobian of the prediction, M×D: z(x·Exp τ) ≈ z − H·τ.
    fn innovation_jac(&self, x: &G) -> (SVector<G::Scalar, M>, SMatrix<G::Scalar, M, D>);

    /// `(z, H)` with the left (global) Jacobian, H·Ad_x⁻¹: z(Exp(τ)·x) ≈ z − H·τ. Override where the left form is simpler.
    fn innovation_left_jac(&self, x: &G) -> (SVector<G::Scalar, M>, SMatrix<G::Scalar, M, D>) {
        let (z, h) = self.innovation_jac(x);
        (z, h * x.inverse().adjoint())
    }
}

/// Decided by the compiler, for each type apart.
fn is_local<E: Side>() -> bool {
    TypeId::of::<E>() == TypeId::of::<Local>()
}

/// [`Motion::step_jac`] on the side E, checked to be finite.
pub(super) fn stepped<G, E, F, const D: usize, const W: usize>(
    motion: &F,
    x: &G,
    input: &F::Input,
) -> Result<(G, Jacobian<G::Scalar, D>, SMatrix<G::Scalar, D, W>), FilterError>
where
    G: LieGroup<D>,
    E: Side,
    F: Motion<G, D, W>,
{
    let (next, d_x, d_w) =
        if is_local::<E>() { motion.step_jac(x, input) } else { motion.step_left_jac(x, input) };
    if is_finite(&next) && all_finite(&d_x) && all_finite(&d_w) {
        Ok((next, d_x, d_w))
    } else {
        Err(FilterError::MotionNotFinite)
    }
}

/// [`Measurement::innovation_jac`] on the side E, checked to be finite.
pub(super) fn observed<G, E, Z, const D: usize, const M: usize>(
    measurement: &Z,
    x: &G,
) -> Result<(SVector<G::Scalar, M>, SMatrix<G::Scalar, M, D>), FilterError>
where
    G: LieGroup<D>,
    E: Side,
    Z: Measurement<G, D, M>,
{
    let (z, h) =
        if is_local::<E>() { measurement.innovation_jac(x) } else { measurement.innovation_left_jac(x) };
    if all_finite(&z) && all_finite(&h) { Ok((z, h)) } else { Err(FilterError::MeasurementNotFinite) }
}

/// The covariance of a model's noise, if it is finite: a factor would take what is not for certain.
pub(super) fn finite<S: Real, const N: usize>(
    noise: Covariance<N, S>,
) -> Result<Covariance<N, S>, FilterError> {
    if all_finite(noise.matrix()) { Ok(noise) } else { Err(FilterError::CovarianceNotFinite) }
}

/// Whether no entry is NaN or infinite.
pub(super) fn all_finite<S: Real, const R: usize, const C: usize>(m: &SMatrix<S, R, C>) -> bool {
    m.iter().all(|x| x.value().is_finite())
}

/// Whether no stored number of an element is NaN or infinite.
pub(super) fn is_finite<G: LieGroup<D>, const D: usize>(x: &G) -> bool {
    let finite = Cell::new(true);
    let _: G::Over<f64> = x.map(|s| {
        finite.set(finite.get() && s.value().is_finite());
        s.value()
    });
    finite.get()
}

/// The largest difference between the Jacobians of a motion, on both sides, and central differences of its step: some 1e-9
/// of their size where the closed forms are right; NaN where anything is.
///
/// For tests of a motion of your own, in `f64`.
pub fn check_motion<G, F, const D: usize, const W: usize>(motion: &F, x: &G, input: &F::Input) -> f64
where
    G: LieGroup<D, Scalar = f64>,
    F: Motion<G, D, W>,
{
    let still = SVector::zeros();
    let (next, f, g) = motion.step_jac(x, input);
    let (_, f_left, g_left) = motion.step_left_jac(x, input);
    let at_rest = motion.step(x, input, &still);
    let d_x = (0..D).fold(larger(0.0, &at_rest.rminus(&next)), |worst, k| {
        let local = difference(k, |tau| motion.step(&x.rplus(tau), input, &still).rminus(&next));
        let global = difference(k, |tau| motion.step(&x.lplus(tau), input, &still).lminus(&next));
        larger(larger(worst, &(local - f.column(k))), &(global - f_left.column(k)))
    });
    (0..W).fold(d_x, |worst, k| {
        let local = difference(k, |w| motion.step(x, input, w).rminus(&next));
        let global = difference(k, |w| motion.step(x, input, w).lminus(&next));
        larger(larger(worst, &(local - g.column(k))), &(global - g_left.column(k)))
    })
}

/// The largest difference between the Jacobians of a measurement, on both sides, and central differences of its innovation; NaN
/// where anything is.
///
/// For tests of a measurement of your own, in `f64`.
pub fn check_measurement<G, Z, const D: usize, const M: usize>(measurement: &Z, x: &G) -> f64
where
    G: LieGroup<D, Scalar = f64>,
    Z: Measurement<G, D, M>,
{
    let (z, h) = measurement.innovation_jac(x);
    let (_, h_left) = measurement.innovation_left_jac(x);
    (0..D).fold(larger(0.0, &(measurement.innovation(x) - z)), |worst, k| {
        let local = difference(k, |tau| measurement.innovation(&x.rplus(tau)));
        let global = difference(k, |tau| measurement.innovation(&x.lplus(tau)));
        larger(larger(worst, &(local + h.column(k))), &(global + h_left.column(k)))
    })
}

/// The largest of `worst` and the sizes of the entries; NaN, which `max` and `amax` pass over, once there is one.
fn larger<const R: usize>(worst: f64, entries: &SVector<f64, R>) -> f64 {
    let worse = |worst: f64, size: f64| if worst.is_nan() || size <= worst { worst } else { size };
    entries.iter().fold(worst, |worst, x| worse(worst, x.abs()))
}

/// Column k of a Jacobian by the central difference.
fn difference<const N: usize, const R: usize>(
    k: usize,
    f: impl Fn(&SVector<f64, N>) -> SVector<f64, R>,
) -> SVector<f64, R> {
    let h = 1e-5; // h²/6 ≈ ε/h ≈ 2e-11
    let mut step = SVector::zeros();
    step[k] = h;
    (f(&step) - f(&-step)) / (2.0 * h)
}
