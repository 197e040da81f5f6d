//! Models without derivatives: dual numbers find them.

use super::{Measurement, Motion};
use crate::lie::{Jacobian, LieGroup, Real};
use crate::uncertainty::Covariance;
use nalgebra::{SMatrix, SVector};
use num_dual::{Derivative, DualSVec64};

/// A [`Motion`] written for every scalar, without Jacobians; [`ByDuals`] makes it a motion.
///
/// Steps of a body with drag, of a car with a trailer, of anything whose Jacobian is a page of algebra:
///
/// ```
/// use boxplus::filter::{ByDuals, Ekf, Filter, SmoothMotion};
/// use boxplus::lie::{LieGroup, Real, SE2};
/// use boxplus::uncertainty::{Covariance, Gaussian};
/// use nalgebra::{SVector, vector};
///
/// /// A car: it drives `u.0` metres with the front wheels turned by `u.1`; the steering is noisy.
/// struct Car { wheelbase: f64 }
/// impl SmoothMotion<SE2, 3, 1> for Car {
///     type Input = (f64, f64);
///     fn step<S: Real>(&self, x: &SE2<S>, (driven, steered): &(f64, f64), w: &SVector<S, 1>) -> SE2<S> {
///         let curvature = (w[0] + S::lit(*steered)).simd_tan() * S::lit(1.0 / self.wheelbase);
///         x.rplus(&(vector![S::one(), S::zero(), curvature] * S::lit(*driven)))
///     }
///     fn noise(&self, _: &(f64, f64)) -> Covariance<1> {
///         Covariance::unit() * 0.02
///     }
/// }
/// let start = Gaussian::<SE2, 3>::certain(SE2::identity());
/// let end = Ekf::default().predict(&start, &ByDuals(Car { wheelbase: 2.5 }), &(1.0, 0.1))?;
/// let slope = 0.02 / (2.5 * 0.1_f64.cos().powi(2));
/// assert!((end.sigmas()[2] - slope).abs() < 1e-15);
/// # Ok::<(), boxplus::filter::FilterError>(())
/// ```
pub trait SmoothMotion<G: LieGroup<D>, const D: usize, const W: usize> {
    /// u, see [`Motion::Input`].
    type Input;
    /// f(x, u, w).
    fn step<S: Real>(&self, x: &G::Over<S>, input: &Self::Input, noise: &SVector<S, W>) -> G::Over<S>;
    /// Q, W×W.
    fn noise(&self, input: &Self::Input) -> Covariance<W>;
}

/// A [`Measurement`] written for every scalar, without Jacobians; [`ByDuals`] makes it a measurement.
///
/// ```
/// use boxplus::filter::{ByDuals, SmoothMeasurement, check_measurement};
/// use boxplus::lie::{Action, Real, SE2};
/// use boxplus::uncertainty::Covariance;
/// use nalgebra::{SVector, vector};
///
/// /// A microphone: how loud a source at a known place is.
/// struct Loudness(f64);
/// impl SmoothMeasurement<SE2, 3, 1> for Loudness {
///     fn innovation<S: Real>(&self, x: &SE2<S>) -> SVector<S, 1> {
///         let square = x.act_inverse(&vector![S::lit(3.0), S::lit(1.0)]).norm_squared();
///         vector![S::lit(self.0) - S::one() / (square + S::one())]
///     }
///     fn noise(&self) -> Covariance<1> {
///         Covariance::unit() * 0.01
///     }
/// }
/// assert!(check_measurement(&ByDuals(Loudness(0.1)), &SE2::new(vector![1.0, 0.0], 0.4)) < 1e-9);
/// ```
pub trait SmoothMeasurement<G: LieGroup<D>, const D: usize, const M: usize> {
    /// z(x): what was measured minus what x predicts.
    fn innovation<S: Real>(&self, x: &G::Over<S>) -> SVector<S, M>;
    /// N, M×M.
    fn noise(&self) -> Covariance<M>;
}

/// A model with exact Jacobians by dual numbers: a [`SmoothMotion`] as a [`Motion`], a [`SmoothMeasurement`] as a
/// [`Measurement`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ByDuals<T>(pub T);

/// Infinitesimals along the N axes.
fn seeds<const N: usize>() -> SVector<DualSVec64<N>, N> {
    SVector::from_fn(|i, _| {
        DualSVec64::new(0.0, Derivative::derivative_generic(nalgebra::Const::<N>, nalgebra::U1, i))
    })
}

/// The derivatives that R dual numbers carry, R×N.
fn slopes<const R: usize, const N: usize>(y: &SVector<DualSVec64<N>, R>) -> SMatrix<f64, R, N> {
    SMatrix::from_fn(|row, column| y[row].eps.0.map_or(0.0, |eps| eps[column]))
}

impl<G, T, const D: usize, const W: usize> Motion<G, D, W> for ByDuals<T>
where
    G: LieGroup<D, Scalar = f64, Over<f64> = G>,
    T: SmoothMotion<G, D, W>,
{
    type Input = T::Input;

    fn step(&self, x: &G, input: &T::Input, noise: &SVector<f64, W>) -> G {
        self.0.step::<f64>(x, input, noise)
    }
    fn noise(&self, input: &T::Input) -> Covariance<W> {
        self.0.noise(input)
    }
    fn step_jac(&self, x: &G, input: &T::Input) -> (G, Jacobian<f64, D>, SMatrix<f64, D, W>) {
        let next = self.0.step::<f64>(x, input, &SVector::zeros());
        let moved = self.0.step::<DualSVec64<D>>(
            &x.map::<DualSVec64<D>>(Real::lit).rplus(&seeds()),
            input,
            &SVector::zeros(),
        );
        let d_x = moved.rminus(&next.map::<DualSVec64<D>>(Real::lit));
        let pushed = self.0.step::<DualSVec64<W>>(&x.map::<DualSVec64<W>>(Real::lit), input, &seeds());
        let d_w = pushed.rminus(&next.map::<DualSVec64<W>>(Real::lit));
        (next, slopes(&d_x), slopes(&d_w))
    }
}

impl<G, T, const D: usize, const M: usize> Measurement<G, D, M> for ByDuals<T>
where
    G: LieGroup<D, Scalar = f64, Over<f64> = G>,
    T: SmoothMeasurement<G, D, M>,
{
    fn innovation(&self, x: &G) -> SVector<f64, M> {
        self.0.innovation::<f64>(x)
    }
    fn noise(&self) -> Covariance<M> {
        self.0.noise()
    }
    fn innovation_jac(&self, x: &G) -> (SVector<f64, M>, SMatrix<f64, M, D>) {
        let z = self.0.innovation::<DualSVec64<D>>(&x.map::<DualSVec64<D>>(Real::lit).rplus(&seeds()));
        (z.map(Real::value), -slopes(&z))
    }
}
