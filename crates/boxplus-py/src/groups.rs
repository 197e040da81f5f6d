//! The operations of every group, by one table.

use crate::operation::operations;
use crate::slot::{Element, Matrix, Scalar, Slot, Vector};
use boxplus::lie::{
    Action, BatchGroup, Distance, LeftJacobians, LieGroup, LogNear, Number, Plain, Rn, SE2, SE3, SE23, SGal3,
    SO2, SO3, Sim2, Sim3,
};
use bytemuck::TransparentWrapper;
use pyo3::prelude::*;

operations! {
    /// What every group can do. D is the dimension of its tangents, N the count of an element's numbers, P the dimension of the
    /// points it moves, A the shape of its algebra; `x`, `y` are elements.
    Group[G, A, const D: usize, const N: usize, const P: usize]
    where [
        G: LeftJacobians<D> + BatchGroup<D> + LieGroup<D, Scalar = f64, Algebra = A::Value> + Action<D, P>,
        G: Plain<N, Number = f64> + TransparentWrapper<[f64; N]>,
        <G as LieGroup<D>>::Over<<f64 as Number>::Lanes>: Action<D, P>,
        A: Slot + 'static,
    ];

    fallible from_array(numbers: Vector<N>) -> Element<G, N> { G::from_array(numbers.into()) }
    batch exp(tau: Vector<D>) -> Element<G, N> { G::exp(&tau) }
    new exp_jac(tau: Vector<D>) -> (Element<G, N>, Matrix<D, D>) { G::exp_jac(&tau) }
    new exp_left_jac(tau: Vector<D>) -> (Element<G, N>, Matrix<D, D>) { G::exp_left_jac(&tau) }
    batch log(x: Element<G, N>) -> Vector<D> { x.log() }
    new log_jac(x: Element<G, N>) -> (Vector<D>, Matrix<D, D>) { x.log_jac() }
    new log_left_jac(x: Element<G, N>) -> (Vector<D>, Matrix<D, D>) { x.log_left_jac() }
    batch inverse(x: Element<G, N>) -> Element<G, N> { x.inverse() }
    new inverse_jac(x: Element<G, N>) -> (Element<G, N>, Matrix<D, D>) { x.inverse_jac() }
    new inverse_left_jac(x: Element<G, N>) -> (Element<G, N>, Matrix<D, D>) { x.inverse_left_jac() }
    batch compose(x: Element<G, N>, y: Element<G, N>) -> Element<G, N> { x.compose(&y) }
    new compose_jac(x: Element<G, N>, y: Element<G, N>) -> (Element<G, N>, Matrix<D, D>, Matrix<D, D>) { x.compose_jac(&y) }
    new compose_left_jac(x: Element<G, N>, y: Element<G, N>) -> (Element<G, N>, Matrix<D, D>, Matrix<D, D>) {
        x.compose_left_jac(&y)
    }
    batch between(x: Element<G, N>, y: Element<G, N>) -> Element<G, N> { x.between(&y) }
    new between_jac(x: Element<G, N>, y: Element<G, N>) -> (Element<G, N>, Matrix<D, D>, Matrix<D, D>) { x.between_jac(&y) }
    new between_left_jac(x: Element<G, N>, y: Element<G, N>) -> (Element<G, N>, Matrix<D, D>, Matrix<D, D>) {
        x.between_left_jac(&y)
    }
    batch rplus(x: Element<G, N>, tau: Vector<D>) -> Element<G, N> { x.rplus(&tau) }
    new rplus_jac(x: Element<G, N>, tau: Vector<D>) -> (Element<G, N>, Matrix<D, D>, Matrix<D, D>) { x.rplus_jac(&tau) }
    new rplus_left_jac(x: Element<G, N>, tau: Vector<D>) -> (Element<G, N>, Matrix<D, D>, Matrix<D, D>) {
        x.rplus_left_jac(&tau)
    }
    new lplus(x: Element<G, N>, tau: Vector<D>) -> Element<G, N> { x.lplus(&tau) }
    new lplus_jac(x: Element<G, N>, tau: Vector<D>) -> (Element<G, N>, Matrix<D, D>, Matrix<D, D>) { x.lplus_jac(&tau) }
    new lplus_left_jac(x: Element<G, N>, tau: Vector<D>) -> (Element<G, N>, Matrix<D, D>, Matrix<D, D>) {
        x.lplus_left_jac(&tau)
    }
    batch rminus(y: Element<G, N>, x: Element<G, N>) -> Vector<D> { y.rminus(&x) }
    new rminus_jac(y: Element<G, N>, x: Element<G, N>) -> (Vector<D>, Matrix<D, D>, Matrix<D, D>) { y.rminus_jac(&x) }
    new rminus_left_jac(y: Element<G, N>, x: Element<G, N>) -> (Vector<D>, Matrix<D, D>, Matrix<D, D>) {
        y.rminus_left_jac(&x)
    }
    new lminus(y: Element<G, N>, x: Element<G, N>) -> Vector<D> { y.lminus(&x) }
    new lminus_jac(y: Element<G, N>, x: Element<G, N>) -> (Vector<D>, Matrix<D, D>, Matrix<D, D>) { y.lminus_jac(&x) }
    new lminus_left_jac(y: Element<G, N>, x: Element<G, N>) -> (Vector<D>, Matrix<D, D>, Matrix<D, D>) {
        y.lminus_left_jac(&x)
    }
    new power(x: Element<G, N>, alpha: Scalar) -> Element<G, N> { x.power(alpha) }
    new power_jac(x: Element<G, N>, alpha: Scalar) -> (Element<G, N>, Matrix<D, D>, Vector<D>) { x.power_jac(alpha) }
    new power_left_jac(x: Element<G, N>, alpha: Scalar) -> (Element<G, N>, Matrix<D, D>, Vector<D>) {
        x.power_left_jac(alpha)
    }
    new interpolate(x: Element<G, N>, y: Element<G, N>, t: Scalar) -> Element<G, N> { x.interpolate(&y, t) }
    new interpolate_jac(x: Element<G, N>, y: Element<G, N>, t: Scalar)
        -> (Element<G, N>, Matrix<D, D>, Matrix<D, D>, Vector<D>) { x.interpolate_jac(&y, t) }
    new interpolate_left_jac(x: Element<G, N>, y: Element<G, N>, t: Scalar)
        -> (Element<G, N>, Matrix<D, D>, Matrix<D, D>, Vector<D>) { x.interpolate_left_jac(&y, t) }
    new equal(x: Element<G, N>, y: Element<G, N>) -> Scalar { f64::from(x == y) }
    new is_near(x: Element<G, N>, y: Element<G, N>, tolerance: Scalar) -> Scalar { f64::from(x.is_near(&y, tolerance)) }
    new weighted_distance(x: Element<G, N>, y: Element<G, N>, weights: Vector<D>) -> Scalar {
        x.weighted_distance(&y, &weights)
    }

    new adjoint(x: Element<G, N>) -> Matrix<D, D> { x.adjoint() }
    new adjoint_times(x: Element<G, N>, tau: Vector<D>) -> Vector<D> { x.adjoint_times(&tau) }
    new small_adjoint(tau: Vector<D>) -> Matrix<D, D> { G::small_adjoint(&tau) }
    new bracket(a: Vector<D>, b: Vector<D>) -> Vector<D> { G::bracket(&a, &b) }
    new hat(tau: Vector<D>) -> A { G::hat(&tau) }
    new vee(algebra: A) -> Vector<D> { G::vee(&algebra) }
    new right_jacobian(tau: Vector<D>) -> Matrix<D, D> { G::right_jacobian(&tau) }
    new right_jacobian_inverse(tau: Vector<D>) -> Matrix<D, D> { G::right_jacobian_inverse(&tau) }
    new right_jacobian_derivative(tau: Vector<D>, delta: Vector<D>) -> Matrix<D, D> {
        G::right_jacobian_derivative(&tau, &delta)
    }
    new right_jacobian_inverse_derivative(tau: Vector<D>, delta: Vector<D>) -> Matrix<D, D> {
        G::right_jacobian_inverse_derivative(&tau, &delta)
    }
    new left_jacobian(tau: Vector<D>) -> Matrix<D, D> { G::left_jacobian(&tau) }
    new left_jacobian_inverse(tau: Vector<D>) -> Matrix<D, D> { G::left_jacobian_inverse(&tau) }
    new covariance_to_left(x: Element<G, N>, right: Matrix<D, D>) -> Matrix<D, D> { x.covariance_to_left(&right) }
    new covariance_to_right(x: Element<G, N>, left: Matrix<D, D>) -> Matrix<D, D> { x.covariance_to_right(&left) }

    batch act(x: Element<G, N>, p: Vector<P>) -> Vector<P> { x.act(&p) }
    new act_jac(x: Element<G, N>, p: Vector<P>) -> (Vector<P>, Matrix<P, D>, Matrix<P, P>) { x.act_jac(&p) }
    new act_left_jac(x: Element<G, N>, p: Vector<P>) -> (Vector<P>, Matrix<P, D>, Matrix<P, P>) { x.act_left_jac(&p) }
    new act_inverse(x: Element<G, N>, p: Vector<P>) -> Vector<P> { x.act_inverse(&p) }
    new act_inverse_jac(x: Element<G, N>, p: Vector<P>) -> (Vector<P>, Matrix<P, D>, Matrix<P, P>) {
        x.act_inverse_jac(&p)
    }
    new act_inverse_left_jac(x: Element<G, N>, p: Vector<P>) -> (Vector<P>, Matrix<P, D>, Matrix<P, P>) {
        x.act_inverse_left_jac(&p)
    }
    new act_direction(x: Element<G, N>, d: Vector<P>) -> Vector<P> { x.act_direction(&d) }
    new act_direction_jac(x: Element<G, N>, d: Vector<P>) -> (Vector<P>, Matrix<P, D>, Matrix<P, P>) {
        x.act_direction_jac(&d)
    }
    new act_direction_left_jac(x: Element<G, N>, d: Vector<P>) -> (Vector<P>, Matrix<P, D>, Matrix<P, P>) {
        x.act_direction_left_jac(&d)
    }
    new linear_part(x: Element<G, N>) -> Matrix<P, P> { x.linear_part() }
    new generators_at(p: Vector<P>) -> Matrix<P, D> { G::generators_at(&p) }
}

/// A group whose elements are matrices: what its type offers beside the laws.
trait MatrixGroup<const D: usize, const M: usize>: LogNear<D, Scalar = f64> {
    fn from_matrix(matrix: &nalgebra::SMatrix<f64, M, M>) -> Result<Self, boxplus::lie::LieError>;
    fn project(matrix: &nalgebra::SMatrix<f64, M, M>) -> Result<Self, boxplus::lie::LieError>;
    fn to_matrix(&self) -> nalgebra::SMatrix<f64, M, M>;
    fn normalize(&self) -> Self;
}

operations! {
    /// What groups of M×M matrices can do besides.
    Matrices[G, const D: usize, const N: usize, const M: usize]
    where [
        G: MatrixGroup<D, M>,
        G: Plain<N, Number = f64> + TransparentWrapper<[f64; N]>,
    ];

    fallible from_matrix(matrix: Matrix<M, M>) -> Element<G, N> { G::from_matrix(&matrix) }
    fallible project(matrix: Matrix<M, M>) -> Element<G, N> { G::project(&matrix) }
    new to_matrix(x: Element<G, N>) -> Matrix<M, M> { x.to_matrix() }
    new normalize(x: Element<G, N>) -> Element<G, N> { x.normalize() }
    fallible log_near(x: Element<G, N>, reference: Vector<D>) -> Vector<D> { LogNear::log_near(&x, &reference) }
}

/// Lists the matrix groups: dimension of the tangent, numbers, dimension of the points, size of the matrix.
macro_rules! matrix_groups {
    ($($group:ident $d:literal $n:literal $p:literal $m:literal)*) => {
        $(impl MatrixGroup<$d, $m> for $group {
            fn from_matrix(matrix: &nalgebra::SMatrix<f64, $m, $m>) -> Result<Self, boxplus::lie::LieError> {
                <$group>::from_matrix(matrix)
            }
            fn project(matrix: &nalgebra::SMatrix<f64, $m, $m>) -> Result<Self, boxplus::lie::LieError> {
                <$group>::project(matrix)
            }
            fn to_matrix(&self) -> nalgebra::SMatrix<f64, $m, $m> {
                <$group>::to_matrix(self)
            }
            fn normalize(&self) -> Self {
                <$group>::normalize(self)
            }
        })*
        fn register_matrix_groups(module: &Bound<'_, PyModule>) -> PyResult<()> {
            $(module.add(stringify!($group), Group::new::<$group, Matrix<$m, $m>, $d, $n, $p>())?;
            module.add(concat!(stringify!($group), "_matrices"), Matrices::new::<$group, $d, $n, $m>())?;)*
            Ok(())
        }
    };
}

matrix_groups! {
    SO2 1 2 2 2
    SO3 3 4 3 3
    SE2 3 4 2 3
    SE3 6 7 3 4
    SE23 9 10 3 5
    SGal3 10 11 4 5
    Sim2 4 5 2 3
    Sim3 7 8 3 4
}

macro_rules! vectors {
    ($module:ident; $($n:literal)*) => {
        $($module.add(concat!("R", $n), Group::new::<Rn<$n>, Vector<$n>, $n, $n, $n>())?;)*
    };
}

/// Adds the operations of each group to the module, under its name.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Group>()?;
    module.add_class::<Matrices>()?;
    register_matrix_groups(module)?;
    vectors!(module; 1 2 3 4 5 6);
    Ok(())
}
