//! The coordinates of rotations.

use crate::operation::{Operation, operations};
use crate::slot::{Element, Matrix, Scalar, Vector};
use boxplus::lie::{EulerSequence, SO2, SO3};
use pyo3::prelude::*;

type R3 = Element<SO3, 4>;
type R2 = Element<SO2, 2>;

operations! {
    /// Rotations of space from coordinates and back.
    Rotations[] where [];

    fallible from_xyzw(q: Vector<4>) -> R3 { SO3::from_xyzw(q.into()) }
    fallible from_xyzw_jac(q: Vector<4>) -> (R3, Matrix<3, 4>) { SO3::from_xyzw_jac(q.into()) }
    fallible from_wxyz(q: Vector<4>) -> R3 { SO3::from_wxyz(q.into()) }
    fallible from_jpl_xyzw(q: Vector<4>) -> R3 { SO3::from_jpl_xyzw(q.into()) }
    new to_xyzw_jac(x: R3) -> (Vector<4>, Matrix<4, 3>) {{
        let (q, jacobian) = x.quaternion_xyzw_jac();
        (q.into(), jacobian)
    }}
    new to_wxyz(x: R3) -> Vector<4> { x.quaternion_wxyz().into() }
    new to_jpl_xyzw(x: R3) -> Vector<4> { x.quaternion_jpl_xyzw().into() }

    fallible from_axis_angle(axis: Vector<3>, angle: Scalar) -> R3 { SO3::from_axis_angle(&axis, angle) }
    new to_axis_angle(x: R3) -> (Vector<3>, Scalar) { x.to_axis_angle() }
    fallible between_directions(a: Vector<3>, b: Vector<3>) -> R3 { SO3::between_directions(&a, &b) }
    fallible from_gibbs(g: Vector<3>) -> R3 { SO3::from_gibbs(g) }
    fallible from_gibbs_jac(g: Vector<3>) -> (R3, Matrix<3, 3>) { SO3::from_gibbs_jac(g) }
    fallible to_gibbs(x: R3) -> Vector<3> { x.to_gibbs() }
    fallible to_gibbs_jac(x: R3) -> (Vector<3>, Matrix<3, 3>) { x.to_gibbs_jac() }
    fallible from_mrp(m: Vector<3>) -> R3 { SO3::from_mrp(m) }
    fallible from_mrp_jac(m: Vector<3>) -> (R3, Matrix<3, 3>) { SO3::from_mrp_jac(m) }
    new to_mrp(x: R3) -> Vector<3> { x.to_mrp() }
    new to_mrp_jac(x: R3) -> (Vector<3>, Matrix<3, 3>) { x.to_mrp_jac() }
    fallible from_6d(a: Vector<3>, b: Vector<3>) -> R3 { SO3::from_6d(&a, &b) }
    fallible from_6d_jac(a: Vector<3>, b: Vector<3>) -> (R3, Matrix<3, 6>) { SO3::from_6d_jac(&a, &b) }
    new angle_to(x: R3, y: R3) -> Scalar { x.angle_to(&y) }
    new chordal_distance(x: R3, y: R3) -> Scalar { x.chordal_distance(&y) }
    new quaternion_distance(x: R3, y: R3) -> Scalar { x.quaternion_distance(&y) }

    fallible planar_from_cos_sin(cos: Scalar, sin: Scalar) -> R2 { SO2::from_cos_sin(cos, sin) }
    new planar_angle_to(x: R2, y: R2) -> Scalar { x.angle_to(&y) }
    new planar_chordal_distance(x: R2, y: R2) -> Scalar { x.chordal_distance(&y) }
}

/// The sequence of a name such as `ZYX`.
fn sequence(name: &str) -> PyResult<EulerSequence> {
    name.parse().map_err(|error: boxplus::lie::LieError| crate::error::LieError::new_err(error.to_string()))
}

/// Rotations of Euler angles, (..., 3), about the axes of `sequence`.
#[pyfunction]
fn from_euler<'py>(py: Python<'py>, name: &str, angles: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let sequence = sequence(name)?;
    Operation::new::<(Vector<3>,), R3, _>(&["angles"], move |(angles,)| {
        SO3::from_euler(sequence, angles.into())
    })
    .call(py, &[angles])
}

/// [`from_euler`] and its Jacobian, (..., 3, 3).
#[pyfunction]
fn from_euler_jac<'py>(
    py: Python<'py>,
    name: &str,
    angles: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let sequence = sequence(name)?;
    Operation::new::<(Vector<3>,), (R3, Matrix<3, 3>), _>(&["angles"], move |(angles,)| {
        SO3::from_euler_jac(sequence, angles.into())
    })
    .call(py, &[angles])
}

/// Euler angles, (..., 3), and how far the middle one is from gimbal lock, (...).
#[pyfunction]
fn to_euler<'py>(py: Python<'py>, name: &str, x: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let sequence = sequence(name)?;
    Operation::new::<(R3,), (Vector<3>, Scalar), _>(&["x"], move |(x,)| {
        let euler = x.to_euler(sequence);
        (euler.angles.into(), euler.margin())
    })
    .call(py, &[x])
}

/// Euler angles, (..., 3), and their Jacobian, (..., 3, 3), which gimbal lock has not.
#[pyfunction]
fn to_euler_jac<'py>(py: Python<'py>, name: &str, x: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let sequence = sequence(name)?;
    Operation::fallible::<(R3,), (Vector<3>, Matrix<3, 3>), _, _>(&["x"], move |(x,)| {
        x.to_euler_jac(sequence).map(|(euler, jacobian)| (euler.angles.into(), jacobian))
    })
    .call(py, &[x])
}

/// Adds the table and the functions to the module.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Rotations>()?;
    module.add("rotations", Rotations::new())?;
    module.add_function(wrap_pyfunction!(from_euler, module)?)?;
    module.add_function(wrap_pyfunction!(from_euler_jac, module)?)?;
    module.add_function(wrap_pyfunction!(to_euler, module)?)?;
    module.add_function(wrap_pyfunction!(to_euler_jac, module)?)
}
