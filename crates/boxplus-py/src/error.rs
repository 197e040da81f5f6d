//! Exceptions, and how they tell shapes and places.

use crate::filters::FilterFault;
use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::convert::Infallible;
use std::fmt::Display;

create_exception!(boxplus, Error, PyValueError, "What boxplus refuses; the ancestor of all its exceptions.");
create_exception!(boxplus, ShapeError, Error, "An array has the wrong shape, or arrays do not broadcast.");
create_exception!(
    boxplus,
    NotFiniteError,
    Error,
    "A number is NaN or infinite, among the arguments or in a result that overflows."
);
create_exception!(boxplus, LieError, Error, "Numbers that do not determine an element of a group.");
create_exception!(
    boxplus,
    UncertaintyError,
    Error,
    "Numbers that are no uncertainty, or an operation that has no answer."
);
create_exception!(boxplus, FilterError, Error, "A filter cannot take a step; the belief is as it was.");
create_exception!(
    boxplus,
    ReadError,
    Error,
    "A file is malformed; the message names the line, the column and what was expected."
);
create_exception!(
    boxplus,
    GraphError,
    Error,
    "A graph cannot be solved; the message says where and what to do."
);

/// Makes the exceptions known to Python.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("Error", py.get_type::<Error>())?;
    module.add("ShapeError", py.get_type::<ShapeError>())?;
    module.add("NotFiniteError", py.get_type::<NotFiniteError>())?;
    module.add("UncertaintyError", py.get_type::<UncertaintyError>())?;
    module.add("FilterError", py.get_type::<FilterError>())?;
    module.add("ReadError", py.get_type::<ReadError>())?;
    module.add("GraphError", py.get_type::<GraphError>())?;
    module.add("LieError", py.get_type::<LieError>())
}

/// Why a batch has no result: the place in it, in row-major order, and the reason.
pub(crate) struct Fault {
    /// Place of the element.
    pub(crate) index: usize,
    /// What is wrong with it.
    pub(crate) reason: Reason,
}

/// What is wrong with one element of a batch.
pub(crate) enum Reason {
    /// The argument of this number has a NaN or an infinity.
    Argument(usize),
    /// Finite arguments, but the result is beyond the range of doubles.
    Overflow,
    /// The library refuses the numbers.
    Refused(Refusal),
}

/// Why the library refuses an element.
pub(crate) enum Refusal {
    /// Its numbers are no element.
    Lie(boxplus::lie::LieError),
    /// Its numbers are no uncertainty, or the operation has no answer.
    Uncertainty(boxplus::uncertainty::UncertaintyError),
    /// A filter does not take the step.
    Filter(boxplus::filter::FilterError),
}

impl From<Infallible> for Refusal {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}

impl From<boxplus::lie::LieError> for Refusal {
    fn from(error: boxplus::lie::LieError) -> Self {
        Self::Lie(error)
    }
}

impl From<boxplus::uncertainty::UncertaintyError> for Refusal {
    fn from(error: boxplus::uncertainty::UncertaintyError) -> Self {
        Self::Uncertainty(error)
    }
}

impl From<FilterFault> for Refusal {
    fn from(fault: FilterFault) -> Self {
        match fault {
            FilterFault::Uncertainty(error) => Self::Uncertainty(error),
            FilterFault::Filter(error) => Self::Filter(error),
        }
    }
}

impl Fault {
    /// The exception of an operation whose arguments have these `names`, over a batch of shape `batch`.
    pub(crate) fn raise(self, names: &[&str], batch: &[usize]) -> PyErr {
        let place = place(self.index, batch);
        match self.reason {
            Reason::Argument(argument) => {
                NotFiniteError::new_err(format!("{}{place} is NaN or infinite", names[argument]))
            }
            Reason::Overflow => NotFiniteError::new_err(format!(
                "the result{} is beyond the range of numbers",
                if batch.is_empty() { String::new() } else { format!(" at {place}") }
            )),
            Reason::Refused(Refusal::Lie(error)) => {
                LieError::new_err(format!("{}{place}: {error}", names[0]))
            }
            Reason::Refused(Refusal::Uncertainty(error)) => {
                UncertaintyError::new_err(at(&place, error.to_string()))
            }
            Reason::Refused(Refusal::Filter(error)) => FilterError::new_err(at(&place, error.to_string())),
        }
    }
}

/// A message with the place in the batch, unless it is a single element.
fn at(place: &str, message: String) -> String {
    if place.is_empty() { message } else { format!("at {place}: {message}") }
}

/// `[3]`, `[1, 4]`, or nothing for a batch that is a single element.
fn place(index: usize, batch: &[usize]) -> String {
    let mut rest = index;
    let mut along: Vec<String> = batch
        .iter()
        .rev()
        .map(|extent| {
            let index = rest % extent;
            rest /= extent;
            index.to_string()
        })
        .collect();
    along.reverse();
    if along.is_empty() { String::new() } else { format!("[{}]", along.join(", ")) }
}

/// A shape as Python prints it: `()`, `(7,)`, `(100, 7)`.
pub(crate) fn tuple(shape: &[usize]) -> String {
    match shape {
        [only] => format!("({only},)"),
        _ => format!("({})", joined(shape)),
    }
}

/// `(..., 7)`: any number of axes before the given ones.
pub(crate) fn any_batch_of(trailing: &[usize]) -> String {
    if trailing.is_empty() { "(...)".to_owned() } else { format!("(..., {})", joined(trailing)) }
}

fn joined(parts: &[impl Display]) -> String {
    parts.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}
