//! What is given to an operation: anything that NumPy reads as numbers, broadcast to one shape.

use crate::error::{ShapeError, any_batch_of, tuple};
use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFloat};
use pyo3::{intern, types::PyInt};
use std::ops::Range;

/// An argument as contiguous numbers.
pub(crate) enum Argument<'py> {
    /// A number of Python, for which an array would cost more than the operation.
    Number([f64; 1]),
    /// An array of any shape.
    Array(PyReadonlyArrayDyn<'py, f64>),
}

impl<'py> Argument<'py> {
    /// The argument `name`, whose trailing axes must be `trailing`.
    pub(crate) fn new(value: &Bound<'py, PyAny>, name: &str, trailing: &[usize]) -> PyResult<Self> {
        if trailing.is_empty() && (value.is_instance_of::<PyFloat>() || value.is_instance_of::<PyInt>()) {
            return Ok(Self::Number([value.extract()?]));
        }
        let array = match value.cast::<PyArrayDyn<f64>>().map(PyArrayMethods::readonly) {
            Ok(array) if array.as_slice().is_ok() => array,
            _ => converted(value, name)?,
        };
        if !array.shape().ends_with(trailing) {
            return Err(ShapeError::new_err(format!(
                "{name}: expected an array of shape {}, not {}",
                any_batch_of(trailing),
                tuple(array.shape())
            )));
        }
        Ok(Self::Array(array))
    }

    /// The axes before the last `trailing` ones.
    pub(crate) fn batch(&self, trailing: usize) -> &[usize] {
        match self {
            Self::Number(_) => &[],
            Self::Array(array) => &array.shape()[..array.shape().len() - trailing],
        }
    }

    /// The rows of `len` numbers, one for each place of a batch of shape `batch`, with which they broadcast.
    pub(crate) fn operand<'a>(
        &'a self,
        trailing: &[usize],
        len: usize,
        batch: &[usize],
    ) -> PyResult<Operand<'a>> {
        let numbers = match self {
            Self::Number(number) => number,
            Self::Array(array) => array.as_slice()?,
        };
        Ok(Operand { numbers, len, index: Index::new(self.batch(trailing.len()), batch) })
    }
}

/// A new contiguous array of doubles of whatever NumPy reads as real numbers.
fn converted<'py>(value: &Bound<'py, PyAny>, name: &str) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    let py = value.py();
    if value.hasattr(intern!(py, "_operations"))? {
        let kind = value.get_type().name()?;
        return Err(PyTypeError::new_err(format!("{name}: expected numbers, not elements of {kind}")));
    }
    let how = PyDict::new(py);
    how.set_item(intern!(py, "order"), "C")?;
    how.set_item(intern!(py, "casting"), "same_kind")?;
    let array = py.import(intern!(py, "numpy"))?.call_method1(intern!(py, "asarray"), (value,))?;
    let array = array
        .call_method(intern!(py, "astype"), (intern!(py, "float64"),), Some(&how))
        .map_err(|error| PyTypeError::new_err(format!("{name}: expected numbers: {}", error.value(py))))?;
    Ok(array.cast::<PyArrayDyn<f64>>()?.readonly())
}

/// The shape to which all the given ones broadcast, as NumPy does, or nothing.
pub(crate) fn broadcast<'a>(shapes: impl IntoIterator<Item = &'a [usize]>) -> Option<Vec<usize>> {
    let mut common: Vec<usize> = Vec::new();
    for shape in shapes {
        if common == shape {
            continue;
        }
        let missing = shape.len().saturating_sub(common.len());
        common.splice(..0, std::iter::repeat_n(1, missing));
        let offset = common.len() - shape.len();
        for (extent, &given) in common[offset..].iter_mut().zip(shape) {
            match (*extent, given) {
                (a, b) if a == b || b == 1 => {}
                (1, b) => *extent = b,
                _ => return None,
            }
        }
    }
    Some(common)
}

/// Rows of numbers, one for each place of a batch.
pub(crate) struct Operand<'a> {
    numbers: &'a [f64],
    len: usize,
    index: Index,
}

/// Which row stands at a place of a batch.
enum Index {
    /// Each has its own.
    Each,
    /// One for all.
    Same,
    /// By (extent, stride) of every axis, last axis first.
    Strided(Vec<(usize, usize)>),
}

impl Index {
    fn new(own: &[usize], batch: &[usize]) -> Self {
        if own == batch {
            return Self::Each;
        }
        if own.iter().all(|&extent| extent == 1) {
            return Self::Same;
        }
        let mut stride = 1;
        let own = own.iter().rev().chain(std::iter::repeat(&1));
        Self::Strided(
            batch
                .iter()
                .rev()
                .zip(own)
                .map(|(&extent, &own)| {
                    let step = if own == 1 { 0 } else { stride };
                    stride *= own;
                    (extent, step)
                })
                .collect(),
        )
    }
}

impl Operand<'_> {
    /// The rows at some places, where each place has its own.
    pub(crate) fn rows(&self, places: Range<usize>) -> Option<&[f64]> {
        matches!(self.index, Index::Each)
            .then(|| &self.numbers[places.start * self.len..places.end * self.len])
    }

    /// The first of some places whose row has a number that is NaN or infinite.
    pub(crate) fn first_not_finite(&self, mut places: Range<usize>) -> Option<usize> {
        match self.index {
            Index::Same if finite(self.row(0)) => None,
            Index::Each if self.rows(places.clone()).is_some_and(finite) => None,
            _ => places.find(|&place| !finite(self.row(place))),
        }
    }

    /// The row at a place of the batch, counted in row-major order.
    #[inline]
    pub(crate) fn row(&self, place: usize) -> &[f64] {
        let row = match &self.index {
            Index::Each => place,
            Index::Same => 0,
            Index::Strided(axes) => strided(axes, place),
        };
        &self.numbers[row * self.len..][..self.len]
    }
}

/// Whether no number is NaN or infinite. Without a branch per number, so that it costs little.
pub(crate) fn finite(numbers: &[f64]) -> bool {
    numbers.iter().fold(true, |all, x| all & x.is_finite())
}

/// Apart, because rare.
#[inline(never)]
fn strided(axes: &[(usize, usize)], place: usize) -> usize {
    let mut rest = place;
    axes.iter().fold(0, |row, &(extent, stride)| {
        let along = rest % extent;
        rest /= extent;
        row + along * stride
    })
}
