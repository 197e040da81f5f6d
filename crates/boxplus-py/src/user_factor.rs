//! Factors whose residuals Python computes.

use crate::argument::Argument;
use crate::error::ShapeError;
use crate::graph::Estimated;
use boxplus::graph::{FactorBatch, Key, Values, VariableId};
use boxplus::lie::Plain;
use numpy::{IxDyn, PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

/// The first exception that a function of the user raised, for the one who asked to find.
#[derive(Clone, Default)]
pub(crate) struct Raised(Arc<Mutex<Option<PyErr>>>);

impl Raised {
    /// Keeps an exception, unless there is one.
    pub(crate) fn set(&self, error: PyErr) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }
    /// Whether there is one.
    pub(crate) fn is_set(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }
    /// The exception, which then is gone.
    pub(crate) fn take(&self) -> Option<PyErr> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// One variable of each factor of a batch, all of one kind.
pub(crate) trait Column: Send + Sync {
    /// What the graph calls them.
    fn ids(&self) -> Vec<VariableId>;
    /// Length of a tangent.
    fn dimension(&self) -> usize;
    /// Stored numbers of some of them, (n, ...).
    fn gather<'py>(
        &self,
        py: Python<'py>,
        values: &Values,
        range: Range<usize>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>>;
}

/// Keys of variables of the group G.
pub(crate) struct Keys<G, const D: usize, const N: usize>(pub(crate) Vec<Key<G>>);

impl<G: Estimated<D, N>, const D: usize, const N: usize> Column for Keys<G, D, N> {
    fn ids(&self) -> Vec<VariableId> {
        self.0.iter().copied().map(VariableId::from).collect()
    }
    fn dimension(&self) -> usize {
        D
    }
    fn gather<'py>(
        &self,
        py: Python<'py>,
        values: &Values,
        range: Range<usize>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let row = |&key: &Key<G>| values.get(key).map_or([f64::NAN; N], Plain::to_array);
        let numbers: Vec<f64> = self.0[range.clone()].iter().flat_map(row).collect();
        PyArray1::from_vec(py, numbers).reshape(IxDyn(&[range.len(), N]))
    }
}

/// Factors whose residuals a function of Python computes, many at a time: `function(start, stop, jacobians, *numbers)` gets the
/// stored numbers of the variables of the factors from `start` to `stop`, and returns their residuals, and if `jacobians` also the
/// derivatives by each variable.
pub(crate) struct UserFactors {
    pub(crate) columns: Vec<Box<dyn Column>>,
    pub(crate) function: Py<PyAny>,
    pub(crate) relative: bool,
    pub(crate) raised: Raised,
}

impl UserFactors {
    /// Calls the function and copies what it returns.
    fn call<const R: usize>(
        &self,
        values: &Values,
        range: Range<usize>,
        residuals: &mut [f64],
        jacobians: Option<&mut [&mut [f64]]>,
    ) -> PyResult<()> {
        Python::attach(|py| {
            let head = (range.start, range.end, jacobians.is_some()).into_pyobject(py)?;
            let numbers = (self.columns.iter())
                .map(|column| column.gather(py, values, range.clone()).map(Bound::into_any))
                .collect::<PyResult<Vec<_>>>()?;
            let arguments: Vec<_> = head.iter().chain(numbers).collect();
            let answer = self.function.bind(py).call1(PyTuple::new(py, arguments)?)?;
            let Some(jacobians) = jacobians else {
                return copied(&answer, "the residual", &[R], range.len(), residuals);
            };
            let answers: Vec<Bound<'_, PyAny>> = answer.extract()?;
            if answers.len() != 1 + jacobians.len() {
                return Err(ShapeError::new_err(format!(
                    "expected a residual and {} Jacobian(s), not {} arrays",
                    jacobians.len(),
                    answers.len()
                )));
            }
            copied(&answers[0], "the residual", &[R], range.len(), residuals)?;
            for (v, (answer, jacobian)) in answers[1..].iter().zip(jacobians).enumerate() {
                let (name, shape) = (format!("Jacobian {v}"), [R, self.columns[v].dimension()]);
                copied(answer, &name, &shape, range.len(), jacobian)?;
            }
            Ok(())
        })
    }
}

impl<const R: usize> FactorBatch<R> for UserFactors {
    fn name(&self) -> &'static str {
        "user-defined factor"
    }
    fn is_relative(&self) -> bool {
        self.relative
    }
    fn residuals(&self, values: &Values, range: Range<usize>, residuals: &mut [f64]) {
        if let Err(error) = self.call::<R>(values, range, residuals, None) {
            self.raised.set(error);
            residuals.fill(f64::NAN);
        }
    }
    fn residuals_jac(
        &self,
        values: &Values,
        range: Range<usize>,
        residuals: &mut [f64],
        jacobians: &mut [&mut [f64]],
    ) {
        if let Err(error) = self.call::<R>(values, range, residuals, Some(jacobians)) {
            self.raised.set(error);
            residuals.fill(f64::NAN);
        }
    }
}

/// Copies rows of a trailing shape, or one for all, out of an array.
fn copied(
    array: &Bound<'_, PyAny>,
    name: &str,
    trailing: &[usize],
    count: usize,
    out: &mut [f64],
) -> PyResult<()> {
    let argument = Argument::new(array, name, trailing)?;
    let batch = argument.batch(trailing.len());
    if !(batch == [count] || batch.is_empty()) {
        return Err(ShapeError::new_err(format!("{name}: {batch:?} rows for {count} factors")));
    }
    let len = out.len() / count.max(1);
    let operand = argument.operand(trailing, len, &[count])?;
    out.chunks_exact_mut(len.max(1)).enumerate().for_each(|(i, out)| out.copy_from_slice(operand.row(i)));
    Ok(())
}
