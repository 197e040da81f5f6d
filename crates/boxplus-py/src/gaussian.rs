//! Uncertain elements: the operations of every group and side, by one table.

use crate::kinds::{R1, R2, R3, R4, each_group};
use crate::operation::operations;
use crate::slot::{Element, Matrix, Scalar, Vector};
use boxplus::lie::{Action, LieGroup, Plain, Rn, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3};
use boxplus::uncertainty::{Covariance, Gaussian, Global, Local, Order, Side, UncertaintyError};
use bytemuck::TransparentWrapper;
use nalgebra::SMatrix;
use pyo3::prelude::*;

operations! {
    /// What uncertain elements can do, by mean and covariance; a covariance is checked wherever it comes in. E is the side, `order` is
    /// 1, 2 or 4.
    Gaussians[G, E, const D: usize, const N: usize, const P: usize]
    where [
        G: LieGroup<D, Scalar = f64> + Action<D, P>,
        G: Plain<N, Number = f64> + TransparentWrapper<[f64; N]>,
        E: Side,
    ];

    fallible checked(covariance: Matrix<D, D>) -> Matrix<D, D> { Covariance::new(covariance).map(|c| *c.matrix()) }
    fallible from_sigmas(sigmas: Vector<D>) -> Matrix<D, D> { Covariance::from_sigmas(&sigmas).map(|c| *c.matrix()) }
    fallible from_information(information: Matrix<D, D>) -> Matrix<D, D> {
        Covariance::from_information(&information).map(|c| *c.matrix())
    }
    fallible sigmas(covariance: Matrix<D, D>) -> Vector<D> { Covariance::new(covariance).map(|c| c.sigmas()) }
    fallible information(covariance: Matrix<D, D>) -> Matrix<D, D> { Covariance::new(covariance)?.information() }
    fallible principal_axes(covariance: Matrix<D, D>) -> (Vector<D>, Matrix<D, D>) {
        Covariance::new(covariance).map(|c| c.principal_axes())
    }

    fallible inverse(mean: Element<G, N>, covariance: Matrix<D, D>) -> (Element<G, N>, Matrix<D, D>) {
        of::<G, E, D>(mean, covariance).map(|x| parts(&x.inverse()))
    }
    fallible to_opposite(mean: Element<G, N>, covariance: Matrix<D, D>) -> (Element<G, N>, Matrix<D, D>) {
        of::<G, E, D>(mean, covariance).map(|x| parts(&x.to_opposite()))
    }
    fallible change_parent(mean: Element<G, N>, covariance: Matrix<D, D>, new_from_old: Element<G, N>)
        -> (Element<G, N>, Matrix<D, D>) {
        of::<G, E, D>(mean, covariance).map(|x| parts(&x.change_parent(&new_from_old)))
    }
    fallible change_body(mean: Element<G, N>, covariance: Matrix<D, D>, body_from_sensor: Element<G, N>)
        -> (Element<G, N>, Matrix<D, D>) {
        of::<G, E, D>(mean, covariance).map(|x| parts(&x.change_body(&body_from_sensor)))
    }
    fallible reset(mean: Element<G, N>, covariance: Matrix<D, D>, theta: Vector<D>) -> (Element<G, N>, Matrix<D, D>) {
        of::<G, E, D>(mean, covariance).map(|x| parts(&x.reset(&theta)))
    }
    fallible transport(mean: Element<G, N>, covariance: Matrix<D, D>, theta: Vector<D>) -> (Element<G, N>, Matrix<D, D>) {
        of::<G, E, D>(mean, covariance).map(|x| parts(&x.transport(&theta)))
    }
    fallible compose(
        mean: Element<G, N>, covariance: Matrix<D, D>, other: Element<G, N>, other_covariance: Matrix<D, D>, order: Scalar
    ) -> (Element<G, N>, Matrix<D, D>) {{
        let (x, y) = (of::<G, E, D>(mean, covariance)?, of::<G, E, D>(other, other_covariance)?);
        Ok::<_, UncertaintyError>(parts(&x.compose(&y, power(order))))
    }}
    fallible between(
        mean: Element<G, N>, covariance: Matrix<D, D>, other: Element<G, N>, other_covariance: Matrix<D, D>, order: Scalar
    ) -> (Element<G, N>, Matrix<D, D>) {{
        let (x, y) = (of::<G, E, D>(mean, covariance)?, of::<G, E, D>(other, other_covariance)?);
        Ok::<_, UncertaintyError>(parts(&x.between(&y, power(order))))
    }}
    fallible fuse(
        mean: Element<G, N>, covariance: Matrix<D, D>, other: Element<G, N>, other_covariance: Matrix<D, D>
    ) -> (Element<G, N>, Matrix<D, D>) {{
        let (x, y) = (of::<G, E, D>(mean, covariance)?, of::<G, E, D>(other, other_covariance)?);
        let fused = Gaussian::fuse([&x, &y])?;
        if fused.converged {
            Ok(parts(&fused.estimate))
        } else {
            Err(UncertaintyError::NotConverged { iterations: fused.iterations, step: fused.step })
        }
    }}
    fallible act_on(
        mean: Element<G, N>, covariance: Matrix<D, D>, p: Vector<P>, p_covariance: Matrix<P, P>, order: Scalar
    ) -> (Vector<P>, Matrix<P, P>) {{
        let point = Gaussian::<Rn<P>, P>::new(Rn::new(p), Covariance::new(p_covariance)?);
        let moved = of::<G, E, D>(mean, covariance)?.act_on(&point, power(order));
        Ok::<_, UncertaintyError>((moved.mean().vector(), *moved.covariance().matrix()))
    }}

    fallible error_of(mean: Element<G, N>, covariance: Matrix<D, D>, x: Element<G, N>) -> Vector<D> {
        of::<G, E, D>(mean, covariance).map(|gaussian| gaussian.error_of(&x))
    }
    fallible perturbed(mean: Element<G, N>, covariance: Matrix<D, D>, xi: Vector<D>) -> Element<G, N> {
        of::<G, E, D>(mean, covariance).map(|x| x.perturbed(&xi))
    }
    fallible drawn(mean: Element<G, N>, covariance: Matrix<D, D>, normal: Vector<D>) -> Element<G, N> {
        of::<G, E, D>(mean, covariance).map(|x| x.perturbed(&(x.covariance().factor() * normal)))
    }
    fallible mahalanobis_squared(mean: Element<G, N>, covariance: Matrix<D, D>, x: Element<G, N>) -> Scalar {
        of::<G, E, D>(mean, covariance)?.mahalanobis_squared(&x)
    }
    fallible tangent_log_density(mean: Element<G, N>, covariance: Matrix<D, D>, x: Element<G, N>) -> Scalar {
        of::<G, E, D>(mean, covariance)?.tangent_log_density(&x)
    }
    fallible haar_log_density(mean: Element<G, N>, covariance: Matrix<D, D>, x: Element<G, N>) -> Scalar {
        of::<G, E, D>(mean, covariance)?.haar_log_density(&x)
    }
    fallible tangent_entropy(mean: Element<G, N>, covariance: Matrix<D, D>) -> Scalar {
        of::<G, E, D>(mean, covariance)?.tangent_entropy()
    }
    fallible kl_divergence(
        mean: Element<G, N>, covariance: Matrix<D, D>, other: Element<G, N>, other_covariance: Matrix<D, D>
    ) -> Scalar {
        of::<G, E, D>(mean, covariance)?.kl_divergence(&of::<G, E, D>(other, other_covariance)?)
    }
    fallible boundary(mean: Element<G, N>, covariance: Matrix<D, D>, direction: Vector<D>, probability: Scalar)
        -> Element<G, N> {
        of::<G, E, D>(mean, covariance)?.region(probability).map(|region| region.boundary(&direction))
    }
}

fn of<G, E, const D: usize>(
    mean: G,
    covariance: SMatrix<f64, D, D>,
) -> Result<Gaussian<G, D, E>, UncertaintyError>
where
    G: LieGroup<D, Scalar = f64>,
    E: Side,
{
    Ok(Gaussian::new(mean, Covariance::new(covariance)?))
}

fn parts<G, E, const D: usize>(gaussian: &Gaussian<G, D, E>) -> (G, SMatrix<f64, D, D>)
where
    G: LieGroup<D, Scalar = f64>,
    E: Side,
{
    (*gaussian.mean(), *gaussian.covariance().matrix())
}

/// The order 1, 2 or 4; the package takes no other.
fn power(order: f64) -> Order {
    match order {
        1.0 => Order::First,
        2.0 => Order::Second,
        _ => Order::Fourth,
    }
}

/// Lists the groups: dimension of the tangent, numbers, dimension of the points.
macro_rules! groups {
    ($module:ident; $($group:ident $d:literal $n:literal $p:literal)*) => {
        $($module.add(concat!(stringify!($group), "_local"), Gaussians::new::<$group, Local, $d, $n, $p>())?;
        $module.add(concat!(stringify!($group), "_global"), Gaussians::new::<$group, Global, $d, $n, $p>())?;)*
    };
}

/// Adds the operations of each group and side to the module, under its name.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Gaussians>()?;
    each_group!(groups, module);
    Ok(())
}
