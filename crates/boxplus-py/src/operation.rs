//! One operation of the library, applied to every element of a batch.

use crate::argument::{Argument, Operand, broadcast, finite};
use crate::error::{Fault, Reason, Refusal, ShapeError, tuple};
use crate::slot::{Slot, Slots, product};
use arrayvec::ArrayVec;
use boxplus::lie::LengthMismatch;
use numpy::ndarray::Dimension;
use numpy::{IxDyn, PyArrayDyn, PyArrayMethods, PyReadwriteArrayDyn};
use pyo3::prelude::*;
use pyo3::types::{PyFloat, PyTuple};
use rayon::prelude::*;
use std::convert::Infallible;
use std::marker::PhantomData;
use std::ops::Range;
use std::sync::OnceLock;

/// Arguments and results at most: with room for them on the stack, a call on one element allocates nothing but its results.
const MOST: usize = 6;
/// Below this many elements the interpreter's lock costs more than the operation does.
const RELEASE: usize = 32;
/// From this many elements on, many are computed at a time.
const WORTHWHILE: usize = 8;
/// From this many elements on, all cores work.
const PARALLEL: usize = 4096;
/// Elements a thread takes at a time: its arguments and results stay in the cache while they are checked.
const CHUNK: usize = 1024;

/// An operation on arrays: the names and shapes of its arguments, the shapes of its results, and what is done with each element.
pub(crate) struct Operation {
    names: &'static [&'static str],
    inputs: &'static [&'static [usize]],
    outputs: &'static [&'static [usize]],
    /// Which arguments are elements, checked when they came to be.
    checked: &'static [bool],
    /// Which results are elements.
    frozen: &'static [bool],
    kernel: Box<dyn Kernel>,
}

/// What computes a stretch of a batch. All that does not depend on its types is in [`Operation`], once for all operations.
trait Kernel: Send + Sync {
    /// Fills the rows of `outputs` with what belongs to `places` of the batch.
    fn run(
        &self,
        inputs: &[Operand<'_>],
        places: Range<usize>,
        outputs: &mut [&mut [f64]],
    ) -> Result<(), Fault>;
}

impl Operation {
    /// An operation from `I` to `O` that has an answer for all arguments.
    pub(crate) fn new<I, O, F>(names: &'static [&'static str], f: F) -> Self
    where
        I: Slots + 'static,
        O: Slots + 'static,
        F: Fn(I::Values) -> O::Values + Send + Sync + 'static,
    {
        Self::fallible::<I, O, _, _>(names, move |values| Ok::<_, Infallible>(f(values)))
    }

    /// As [`Self::new`], with the same function of many elements at a time, by the vector instructions of the machine.
    pub(crate) fn batch<I, O, F, M>(names: &'static [&'static str], f: F, many: M) -> Self
    where
        I: Slots + 'static,
        O: Slot + 'static,
        F: Fn(I::Values) -> O::Value + Send + Sync + 'static,
        M: Fn(I::Slices<'_>, &mut [O::Value]) -> Result<(), LengthMismatch> + Send + Sync + 'static,
    {
        let each = Self::new::<I, O, F>(names, f);
        let kernel = Box::new(Many::<I, O, M> { each: each.kernel, compute: many, of: PhantomData });
        Self { kernel, ..each }
    }

    /// An operation from `I` to `O` that may refuse its arguments.
    pub(crate) fn fallible<I, O, F, E>(names: &'static [&'static str], f: F) -> Self
    where
        I: Slots + 'static,
        O: Slots + 'static,
        F: Fn(I::Values) -> Result<O::Values, E> + Send + Sync + 'static,
        E: Into<Refusal> + 'static,
    {
        Self {
            names,
            inputs: I::SHAPES,
            outputs: O::SHAPES,
            checked: I::CHECKED,
            frozen: O::CHECKED,
            kernel: Box::new(Each::<I, O, F> { f, of: PhantomData }),
        }
    }

    /// Applies the operation to arrays whose batches broadcast. Elements come back as arrays that cannot be written, so that they
    /// stay elements; several results as a tuple; a number that is no batch as a `float`.
    pub(crate) fn call<'py>(
        &self,
        py: Python<'py>,
        arguments: &[&Bound<'py, PyAny>],
    ) -> PyResult<Bound<'py, PyAny>> {
        let arguments = (arguments.iter().zip(self.names).zip(self.inputs))
            .map(|((value, name), trailing)| Argument::new(value, name, trailing))
            .collect::<PyResult<ArrayVec<_, MOST>>>()?;
        let batch = self.common_batch(&arguments)?;
        let mut results = (self.outputs.iter())
            .map(|shape| zeros(py, &batch, shape))
            .collect::<PyResult<ArrayVec<_, MOST>>>()?;
        {
            let operands = (arguments.iter().zip(self.inputs))
                .map(|(argument, shape)| argument.operand(shape, product(shape), &batch))
                .collect::<PyResult<ArrayVec<_, MOST>>>()?;
            let mut rows = (results.iter_mut().map(PyReadwriteArrayDyn::as_slice_mut))
                .collect::<Result<ArrayVec<_, MOST>, _>>()?;
            let count = product(&batch);
            let mut compute = || self.run(&operands, count, &mut rows);
            let done = if count < RELEASE { compute() } else { py.detach(compute) };
            done.map_err(|fault| fault.raise(self.names, &batch))?;
        }
        let mut results =
            results.into_iter().zip(self.frozen).map(|(array, frozen)| finished(array, *frozen));
        match (self.outputs, results.next()) {
            ([_], Some(result)) => Ok(result),
            (_, first) => {
                let all: ArrayVec<_, MOST> = first.into_iter().chain(results).collect();
                Ok(PyTuple::new(py, all)?.into_any())
            }
        }
    }

    /// The common batch of the arguments.
    fn common_batch(&self, arguments: &[Argument<'_>]) -> PyResult<Vec<usize>> {
        let shapes =
            || arguments.iter().zip(self.inputs).map(|(argument, trailing)| argument.batch(trailing.len()));
        broadcast(shapes()).ok_or_else(|| {
            let told =
                self.names.iter().zip(shapes()).map(|(name, shape)| format!("{name} {}", tuple(shape)));
            ShapeError::new_err(format!("batches do not broadcast: {}", told.collect::<Vec<_>>().join(", ")))
        })
    }

    /// Computes all rows, in parallel where there are many. Of several faults, the first place is told.
    fn run(&self, inputs: &[Operand<'_>], count: usize, outputs: &mut [&mut [f64]]) -> Result<(), Fault> {
        if count < PARALLEL || !threads_are_here() {
            return self.stretch(inputs, 0..count, outputs);
        }
        let mut chunks: Vec<Vec<&mut [f64]>> = Vec::new();
        chunks.resize_with(count.div_ceil(CHUNK), Vec::new);
        for (output, shape) in outputs.iter_mut().zip(self.outputs) {
            let rows = output.chunks_mut(CHUNK * product(shape));
            chunks.iter_mut().zip(rows).for_each(|(chunk, rows)| chunk.push(rows));
        }
        chunks
            .into_par_iter()
            .enumerate()
            .filter_map(|(i, mut outputs)| {
                let start = i * CHUNK;
                self.stretch(inputs, start..count.min(start + CHUNK), &mut outputs).err()
            })
            .min_by_key(|fault| fault.index)
            .map_or(Ok(()), Err)
    }

    /// Computes the rows of some places, small enough to stay in the cache while they are checked.
    fn stretch(
        &self,
        inputs: &[Operand<'_>],
        places: Range<usize>,
        outputs: &mut [&mut [f64]],
    ) -> Result<(), Fault> {
        for (argument, operand) in inputs.iter().enumerate().filter(|(argument, _)| !self.checked[*argument])
        {
            if let Some(index) = operand.first_not_finite(places.clone()) {
                return Err(Fault { index, reason: Reason::Argument(argument) });
            }
        }
        self.kernel.run(inputs, places.clone(), outputs)?;
        if outputs.iter().all(|rows| finite(rows)) {
            return Ok(());
        }
        let first = outputs
            .iter()
            .zip(self.outputs)
            .filter_map(|(rows, shape)| rows.chunks(product(shape)).position(|row| !finite(row)));
        Err(Fault { index: places.start + first.min().unwrap_or(0), reason: Reason::Overflow })
    }
}

fn zeros<'py>(py: Python<'py>, batch: &[usize], shape: &[usize]) -> PyResult<PyReadwriteArrayDyn<'py, f64>> {
    let mut extents = IxDyn::zeros(batch.len() + shape.len());
    extents.slice_mut().iter_mut().zip(batch.iter().chain(shape)).for_each(|(to, from)| *to = *from);
    Ok(PyArrayDyn::zeros(py, extents, false).try_readwrite()?)
}

fn finished(array: PyReadwriteArrayDyn<'_, f64>, frozen: bool) -> Bound<'_, PyAny> {
    if frozen {
        return array.make_nonwriteable().as_any().clone();
    }
    match array.get(IxDyn(&[])) {
        Some(number) => PyFloat::new(array.py(), *number).into_any(),
        None => array.as_any().clone(),
    }
}

/// A function of one element, applied to each.
struct Each<I, O, F> {
    f: F,
    of: PhantomData<fn(I) -> O>,
}

impl<I, O, F, E> Kernel for Each<I, O, F>
where
    I: Slots,
    O: Slots,
    F: Fn(I::Values) -> Result<O::Values, E> + Send + Sync,
    E: Into<Refusal>,
{
    fn run(
        &self,
        inputs: &[Operand<'_>],
        places: Range<usize>,
        outputs: &mut [&mut [f64]],
    ) -> Result<(), Fault> {
        for (row, place) in places.enumerate() {
            match (self.f)(I::read(inputs, place)) {
                Ok(values) => O::write(&values, outputs, row),
                Err(error) => return Err(Fault { index: place, reason: Reason::Refused(error.into()) }),
            }
        }
        Ok(())
    }
}

/// A function of many elements at a time.
struct Many<I, O, M> {
    /// The same of one.
    each: Box<dyn Kernel>,
    compute: M,
    of: PhantomData<fn() -> (I, O)>,
}

impl<I, O, M> Kernel for Many<I, O, M>
where
    I: Slots,
    O: Slot,
    M: Fn(I::Slices<'_>, &mut [O::Value]) -> Result<(), LengthMismatch> + Send + Sync,
{
    fn run(
        &self,
        inputs: &[Operand<'_>],
        places: Range<usize>,
        outputs: &mut [&mut [f64]],
    ) -> Result<(), Fault> {
        if places.len() < WORTHWHILE {
            return self.each.run(inputs, places, outputs);
        }
        let columns = I::columns(inputs, places);
        let rows = &mut *outputs[0];
        let fill = |values: &mut [O::Value]| {
            if (self.compute)(I::slices(&columns), values).is_err() {
                unreachable!("every column is as long as the stretch");
            }
        };
        if let Some(values) = O::view_mut(rows) {
            fill(values);
        } else {
            let mut values: Vec<_> = rows.chunks_exact(O::LEN).map(O::read).collect();
            fill(&mut values);
            rows.chunks_exact_mut(O::LEN).zip(&values).for_each(|(row, value)| O::write(value, row));
        }
        Ok(())
    }
}

/// Whether the threads that share large batches are in this process. They stay behind when it forks, and would be waited for
/// forever; one thread gives the same bits.
fn threads_are_here() -> bool {
    static HOME: OnceLock<u32> = OnceLock::new();
    let here = std::process::id();
    *HOME.get_or_init(|| here) == here
}

/// A class of operations: each a method on arrays, with the types of its rows and the formula, a call of the library.
///
/// The brackets hold the parameters and bounds in which types and formulas are written; `new` stands before operations that have an
/// answer for all arguments, `fallible` before those that do not, `batch` before those that the library's `Batch` has by the same name.
macro_rules! operations {
    (@batch $name:ident($($argument:ident),*) $arguments:ty, $results:ty, $names:expr, $formula:expr) => {
        $crate::operation::Operation::batch::<$arguments, $results, _, _>(
            $names,
            $formula,
            |($($argument,)*), out| boxplus::lie::Batch::OneCore.$name($($argument,)* out),
        )
    };
    (@new $name:ident($($argument:ident),*) $arguments:ty, $results:ty, $names:expr, $formula:expr) => {
        $crate::operation::Operation::new::<$arguments, $results, _>($names, $formula)
    };
    (@fallible $name:ident($($argument:ident),*) $arguments:ty, $results:ty, $names:expr, $formula:expr) => {
        $crate::operation::Operation::fallible::<$arguments, $results, _, _>($names, $formula)
    };
    (
        $(#[$attribute:meta])*
        $table:ident [$($parameter:tt)*] where [$($bound:tt)*];
        $($kind:ident $name:ident($($argument:ident: $slot:ty),*) -> $output:ty { $formula:expr })*
    ) => {
        $(#[$attribute])*
        #[pyo3::pyclass(frozen, module = "boxplus._core")]
        pub(crate) struct $table {
            $($name: $crate::operation::Operation,)*
        }

        // `self` is the table, not an element; the arguments are those of the operation.
        #[allow(clippy::wrong_self_convention, clippy::too_many_arguments)]
        #[pyo3::pymethods]
        impl $table {
            $(fn $name<'py>(
                &self,
                py: pyo3::Python<'py>,
                $($argument: &pyo3::Bound<'py, pyo3::PyAny>,)*
            ) -> pyo3::PyResult<pyo3::Bound<'py, pyo3::PyAny>> {
                self.$name.call(py, &[$($argument),*])
            })*
        }

        impl $table {
            /// The table of one group.
            fn new<$($parameter)*>() -> Self
            where
                $($bound)*
            {
                Self {
                    $($name: $crate::operation::operations!(
                        @$kind $name($($argument),*) ($($slot,)*), $output, &[$(stringify!($argument)),*], |($($argument,)*)| $formula
                    ),)*
                }
            }
        }
    };
}
pub(crate) use operations;
