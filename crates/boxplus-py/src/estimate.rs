//! What a solved factor graph says: values, covariances, and how they were found.
#![allow(clippy::needless_pass_by_value)] // Arguments of Python are handed over.

use crate::error::GraphError;
use crate::graph::{Estimated, Numbers, keys, refused};
use crate::kinds::{R1, R2, R3, R4, R5, R6, of_group};
use crate::solve::iteration_dict;
use boxplus::graph::{Initial, Solution, Values, VariableId};
use boxplus::lie::{Plain, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3};
use nalgebra::DMatrix;
use numpy::{IxDyn, PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};

/// Values of all variables.
#[pyclass(frozen, module = "boxplus._core")]
pub(crate) struct Estimate(pub(crate) Values);

#[pymethods]
impl Estimate {
    /// The stored numbers of variables, (N, ...), read-only.
    fn get<'py>(
        &self,
        py: Python<'py>,
        kind: &str,
        numbers: Numbers<'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        of_group!(kind, read(py, &self.0, numbers.as_slice()?))
    }
}

/// Covariances at an estimate.
#[pyclass(module = "boxplus._core")]
pub(crate) struct Marginals(pub(crate) boxplus::graph::Marginals);

#[pymethods]
impl Marginals {
    /// D×D each, of variables of one kind: (N, D, D), local.
    fn covariances<'py>(
        &mut self,
        py: Python<'py>,
        estimate: &Estimate,
        kind: &str,
        numbers: Numbers<'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (dimension, ids) = of_group!(kind, ids(&estimate.0, numbers.as_slice()?))?;
        let found = py.detach(|| self.0.covariances(&ids)).map_err(refused)?;
        let entries: Vec<f64> = found.iter().flat_map(DMatrix::as_slice).copied().collect();
        PyArray1::from_vec(py, entries).reshape(IxDyn(&[ids.len(), dimension, dimension]))
    }

    /// That of all given variables together, in their order.
    fn joint<'py>(
        &mut self,
        py: Python<'py>,
        estimate: &Estimate,
        variables: Vec<(String, Numbers<'py>)>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let mut all = vec![];
        for (kind, numbers) in &variables {
            all.extend(of_group!(kind.as_str(), ids(&estimate.0, numbers.as_slice()?))?.1);
        }
        let joint = py.detach(|| self.0.joint(&all)).map_err(refused)?;
        PyArray1::from_slice(py, joint.as_slice()).reshape(IxDyn(&[joint.nrows(), joint.ncols()]))
    }

    /// What was held for lack of anything that says where the graph is.
    fn held(&self) -> Vec<String> {
        self.0.gauge().iter().map(ToString::to_string).collect()
    }
}

fn ids<G: Estimated<D, N>, const D: usize, const N: usize>(
    values: &Values,
    numbers: &[u32],
) -> PyResult<(usize, Vec<VariableId>)> {
    Ok((D, keys::<G>(values, numbers)?.into_iter().map(VariableId::from).collect()))
}

fn read<'py, G: Estimated<D, N>, const D: usize, const N: usize>(
    py: Python<'py>,
    values: &Values,
    numbers: &[u32],
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let mut read = Vec::with_capacity(N * numbers.len());
    for (key, number) in keys::<G>(values, numbers)?.into_iter().zip(numbers) {
        let value = values.get(key).ok_or_else(|| {
            GraphError::new_err(format!(
                "{} {number} has no value yet; solve the graph first",
                <G as Plain<N>>::NAME
            ))
        })?;
        read.extend(value.to_array());
    }
    let array = PyArray1::from_vec(py, read).reshape(IxDyn(&[numbers.len(), N]))?;
    Ok(array.readwrite().make_nonwriteable().as_any().cast::<PyArrayDyn<f64>>()?.clone())
}

/// How the solve went, as a dictionary.
pub(crate) fn report<'py>(
    py: Python<'py>,
    solution: &Solution,
    start: Initial,
) -> PyResult<Bound<'py, PyDict>> {
    let (told, report) = (PyDict::new(py), &solution.report);
    told.set_item("cost", report.cost)?;
    told.set_item("initial_cost", report.initial_cost)?;
    told.set_item("converged", report.converged())?;
    told.set_item("termination", report.termination.name())?;
    told.set_item("initialisation", start.name())?;
    let iterations = report.iterations.iter().map(|iteration| iteration_dict(py, iteration));
    told.set_item("iterations", iterations.collect::<PyResult<Vec<_>>>()?)?;
    let names = |names: &[boxplus::graph::VariableName]| names.iter().map(ToString::to_string).collect();
    told.set_item::<_, Vec<String>>("held", names(&report.gauge))?;
    told.set_item::<_, Vec<String>>("unread", names(&report.unread))?;
    told.set_item("unconstrained", solution.unconstrained.as_ref().map(ToString::to_string))?;
    told.set_item("unknowns", report.unknowns)?;
    let seconds = &report.seconds;
    let phases = [
        ("analyse", seconds.analyse),
        ("linearise", seconds.linearise),
        ("factorise", seconds.factorise),
        ("solve", seconds.solve),
        ("evaluate", seconds.evaluate),
        ("total", seconds.total),
    ];
    told.set_item("seconds", phases.into_py_dict(py)?)?;
    Ok(told)
}
