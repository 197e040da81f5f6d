//! Steps of the Kalman filter of errors, over arrays of beliefs.

use crate::kinds::{R1, R2, R3, R4, each_group};
use crate::operation::operations;
use crate::slot::{Element, Matrix, Scalar, Vector};
use boxplus::filter::{
    Ekf, Filter, FilterError, Gate, Measurement, Motion, Odometry, Outcome, PositionFix, Range, Sighting,
    VectorSighting,
};
use boxplus::lie::{Action, LieGroup, Plain, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3};
use boxplus::uncertainty::{Covariance, Gaussian, Global, Local, Side, UncertaintyError};
use bytemuck::TransparentWrapper;
use nalgebra::{SMatrix, SVector};
use pyo3::prelude::*;

/// A step of the motion that Python computed.
struct Computed<G, const D: usize> {
    next: G,
    transition: SMatrix<f64, D, D>,
    noise: Covariance<D>,
}

impl<G: LieGroup<D, Scalar = f64>, const D: usize> Motion<G, D, D> for Computed<G, D> {
    type Input = ();

    fn step(&self, _: &G, (): &(), noise: &SVector<f64, D>) -> G {
        self.next.rplus(noise)
    }
    fn noise(&self, (): &()) -> Covariance<D> {
        self.noise
    }
    fn step_jac(&self, _: &G, (): &()) -> (G, SMatrix<f64, D, D>, SMatrix<f64, D, D>) {
        (self.next, self.transition, SMatrix::identity())
    }
}

/// An innovation that Python computed.
struct Observed<const D: usize, const M: usize> {
    innovation: SVector<f64, M>,
    jacobian: SMatrix<f64, M, D>,
    noise: Covariance<M>,
}

impl<G: LieGroup<D, Scalar = f64>, const D: usize, const M: usize> Measurement<G, D, M> for Observed<D, M> {
    fn innovation(&self, _: &G) -> SVector<f64, M> {
        self.innovation
    }
    fn noise(&self) -> Covariance<M> {
        self.noise
    }
    fn innovation_jac(&self, _: &G) -> (SVector<f64, M>, SMatrix<f64, M, D>) {
        (self.innovation, self.jacobian)
    }
}

operations! {
    /// Predictions of beliefs on the side E.
    Predictions[G, E, const D: usize, const N: usize]
    where [
        G: LieGroup<D, Scalar = f64>,
        G: Plain<N, Number = f64> + TransparentWrapper<[f64; N]>,
        E: Side,
    ];

    fallible computed(
        mean: Element<G, N>, covariance: Matrix<D, D>, next: Element<G, N>, transition: Matrix<D, D>, noise: Matrix<D, D>
    ) -> (Element<G, N>, Matrix<D, D>) {
        Covariance::new(noise).map_err(FilterFault::from).and_then(|noise| {
            predicted::<G, E, _, D>(mean, covariance, &Computed { next, transition, noise }, &())
        })
    }
    fallible odometry(mean: Element<G, N>, covariance: Matrix<D, D>, step: Vector<D>, noise: Matrix<D, D>)
        -> (Element<G, N>, Matrix<D, D>) {
        Covariance::new(noise)
            .map_err(FilterFault::from)
            .and_then(|noise| predicted::<G, E, _, D>(mean, covariance, &Odometry { noise }, &step))
    }
}

operations! {
    /// Updates of beliefs on the side E by measurements of M numbers: the belief, S, NIS and whether it was accepted.
    Updates[G, E, const D: usize, const N: usize, const M: usize]
    where [
        G: LieGroup<D, Scalar = f64>,
        G: Plain<N, Number = f64> + TransparentWrapper<[f64; N]>,
        E: Side,
    ];

    fallible update(
        mean: Element<G, N>, covariance: Matrix<D, D>, innovation: Vector<M>, jacobian: Matrix<M, D>, noise: Matrix<M, M>,
        gate: Scalar
    ) -> (Element<G, N>, Matrix<D, D>, Matrix<M, M>, Scalar, Scalar) {
        updated::<G, E, D, M>(mean, covariance, (innovation, jacobian, noise), gate)
    }
}

operations! {
    /// What sensors say that come with the library: the innovation and the right Jacobian of the prediction.
    Sensors[G, const D: usize, const N: usize, const P: usize]
    where [
        G: LieGroup<D, Scalar = f64> + Action<D, P>,
        G: Plain<N, Number = f64> + TransparentWrapper<[f64; N]>,
    ];

    new sighting(x: Element<G, N>, landmark: Vector<P>, measured: Vector<P>) -> (Vector<P>, Matrix<P, D>) {
        Sighting { landmark, measured, noise: Covariance::unit() }.innovation_jac(&x)
    }
    new position_fix(x: Element<G, N>, antenna: Vector<P>, measured: Vector<P>) -> (Vector<P>, Matrix<P, D>) {
        PositionFix { antenna, measured, noise: Covariance::unit() }.innovation_jac(&x)
    }
    new vector_sighting(x: Element<G, N>, reference: Vector<P>, measured: Vector<P>) -> (Vector<P>, Matrix<P, D>) {
        VectorSighting { reference, measured, noise: Covariance::unit() }.innovation_jac(&x)
    }
    new range(x: Element<G, N>, beacon: Vector<P>, antenna: Vector<P>, measured: Scalar) -> (Vector<1>, Matrix<1, D>) {
        Range { beacon, antenna, measured, noise: Covariance::unit() }.innovation_jac(&x)
    }
}

/// Why there is no step.
pub(crate) enum FilterFault {
    /// The numbers are no uncertainty.
    Uncertainty(UncertaintyError),
    /// The filter refuses the step.
    Filter(FilterError),
}

impl From<UncertaintyError> for FilterFault {
    fn from(error: UncertaintyError) -> Self {
        Self::Uncertainty(error)
    }
}

fn predicted<G, E, F, const D: usize>(
    mean: G,
    covariance: SMatrix<f64, D, D>,
    motion: &F,
    input: &F::Input,
) -> Result<(G, SMatrix<f64, D, D>), FilterFault>
where
    G: LieGroup<D, Scalar = f64>,
    E: Side,
    F: Motion<G, D, D>,
{
    let belief = Gaussian::<G, D, E>::new(mean, Covariance::new(covariance)?);
    let next = Ekf::default().predict(&belief, motion, input).map_err(FilterFault::Filter)?;
    Ok((*next.mean(), *next.covariance().matrix()))
}

/// Mean and covariance, S, NIS, and 1 where the measurement was accepted.
type Updated<G, const D: usize, const M: usize> = (G, SMatrix<f64, D, D>, SMatrix<f64, M, M>, f64, f64);

fn updated<G, E, const D: usize, const M: usize>(
    mean: G,
    covariance: SMatrix<f64, D, D>,
    (innovation, jacobian, noise): (SVector<f64, M>, SMatrix<f64, M, D>, SMatrix<f64, M, M>),
    gate: f64,
) -> Result<Updated<G, D, M>, FilterFault>
where
    G: LieGroup<D, Scalar = f64>,
    E: Side,
{
    let belief = Gaussian::<G, D, E>::new(mean, Covariance::new(covariance)?);
    let measurement = Observed { innovation, jacobian, noise: Covariance::new(noise)? };
    let update = Ekf::default().gated(Gate::at(gate)).update(&belief, &measurement);
    let (innovation, accepted) = match update.outcome {
        Outcome::Accepted(innovation) => (innovation, 1.0),
        Outcome::Gated(innovation) => (innovation, 0.0),
        Outcome::Refused(error) => return Err(FilterFault::Filter(error)),
    };
    let after = update.belief;
    Ok((
        *after.mean(),
        *after.covariance().matrix(),
        *innovation.covariance.matrix(),
        innovation.nis,
        accepted,
    ))
}

/// Lists the groups: name, dimension of the tangent, numbers, dimension of the points.
macro_rules! groups {
    ($module:ident; $($group:ident $d:literal $n:literal $p:literal)*) => { $(
        $module.add(concat!(stringify!($group), "_sensors"), Sensors::new::<$group, $d, $n, $p>())?;
        groups!(@ $module $group Local concat!(stringify!($group), "_local_filter"), $d $n);
        groups!(@ $module $group Global concat!(stringify!($group), "_global_filter"), $d $n);
    )* };
    (@ $module:ident $group:ident $side:ident $name:expr, $d:literal $n:literal) => {
        let updates = (
            Updates::new::<$group, $side, $d, $n, 1>(), Updates::new::<$group, $side, $d, $n, 2>(),
            Updates::new::<$group, $side, $d, $n, 3>(), Updates::new::<$group, $side, $d, $n, 4>(),
            Updates::new::<$group, $side, $d, $n, 5>(), Updates::new::<$group, $side, $d, $n, 6>(),
        );
        $module.add($name, (Predictions::new::<$group, $side, $d, $n>(), updates))?;
    };
}

/// Adds the filters of each group and side to the module: predictions, then updates by measurements of 1 to 6 numbers.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Predictions>()?;
    module.add_class::<Updates>()?;
    module.add_class::<Sensors>()?;
    each_group!(groups, module);
    Ok(())
}
