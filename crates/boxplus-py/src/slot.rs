//! How a row of an array holds a value.

use boxplus::lie::Plain;
use bytemuck::TransparentWrapper;
use nalgebra::{SMatrix, SVector};
use pyo3::prelude::*;
use std::marker::PhantomData;
use std::ops::Range;

use crate::argument::{Argument, Operand};
use crate::error::{NotFiniteError, ShapeError};

/// A kind of value, its shape in an array, and how it is read from and written to a row of numbers.
pub(crate) trait Slot {
    /// What is computed with.
    type Value: 'static;
    /// The trailing axes of an array of such values.
    const SHAPE: &'static [usize];
    /// How many numbers a row has.
    const LEN: usize = product(Self::SHAPE);
    /// Whether rows were checked when they came to be: those of elements.
    const CHECKED: bool = false;

    /// The value of a row of [`Self::LEN`] numbers.
    fn read(row: &[f64]) -> Self::Value;
    /// Fills a row of [`Self::LEN`] numbers.
    fn write(value: &Self::Value, row: &mut [f64]);
    /// Rows one behind the other as values, without a copy, where the library has them in memory as NumPy does.
    fn view(_: &[f64]) -> Option<&[Self::Value]> {
        None
    }
    /// As [`Self::view`], to write.
    fn view_mut(_: &mut [f64]) -> Option<&mut [Self::Value]> {
        None
    }
}

/// Values of a stretch of a batch, one behind the other.
pub(crate) enum Column<'a, V> {
    /// They lie so in the array.
    View(&'a [V]),
    /// They were gathered.
    Own(Vec<V>),
}

impl<V> std::ops::Deref for Column<'_, V> {
    type Target = [V];
    fn deref(&self) -> &[V] {
        match self {
            Self::View(values) => values,
            Self::Own(values) => values,
        }
    }
}

/// The values of an argument at some places of the batch.
fn column<'a, S: Slot>(operand: &'a Operand<'_>, places: Range<usize>) -> Column<'a, S::Value> {
    match operand.rows(places.clone()).and_then(S::view) {
        Some(values) => Column::View(values),
        None => Column::Own(places.map(|place| S::read(operand.row(place))).collect()),
    }
}

/// The length of a row.
pub(crate) const fn product(shape: &[usize]) -> usize {
    match shape {
        [] => 1,
        [first, rest @ ..] => *first * product(rest),
    }
}

/// A single number.
pub(crate) struct Scalar;
/// A vector of N numbers: a tangent, a point.
pub(crate) struct Vector<const N: usize>;
/// An R×C matrix by rows.
pub(crate) struct Matrix<const R: usize, const C: usize>;
/// An element by its N stored numbers.
pub(crate) struct Element<G, const N: usize>(PhantomData<G>);

impl Slot for Scalar {
    type Value = f64;
    const SHAPE: &'static [usize] = &[];

    #[inline]
    fn read(row: &[f64]) -> f64 {
        row[0]
    }
    #[inline]
    fn write(value: &f64, row: &mut [f64]) {
        row[0] = *value;
    }
}

impl<const N: usize> Slot for Vector<N> {
    type Value = SVector<f64, N>;
    const SHAPE: &'static [usize] = &[N];

    #[inline]
    fn read(row: &[f64]) -> SVector<f64, N> {
        SVector::from_column_slice(row)
    }
    #[inline]
    fn write(value: &SVector<f64, N>, row: &mut [f64]) {
        row.copy_from_slice(value.as_slice());
    }
}

impl<const R: usize, const C: usize> Slot for Matrix<R, C> {
    type Value = SMatrix<f64, R, C>;
    const SHAPE: &'static [usize] = &[R, C];

    #[inline]
    fn read(row: &[f64]) -> SMatrix<f64, R, C> {
        SMatrix::from_row_slice(row)
    }
    #[inline]
    fn write(value: &SMatrix<f64, R, C>, row: &mut [f64]) {
        row.copy_from_slice(value.transpose().as_slice());
    }
}

impl<G, const N: usize> Slot for Element<G, N>
where
    G: Plain<N, Number = f64> + TransparentWrapper<[f64; N]> + 'static,
{
    type Value = G;
    const SHAPE: &'static [usize] = &[N];
    const CHECKED: bool = true;

    #[inline]
    fn read(row: &[f64]) -> G {
        let mut numbers = [0.0; N];
        numbers.copy_from_slice(row);
        G::wrap(numbers)
    }
    #[inline]
    fn write(value: &G, row: &mut [f64]) {
        row.copy_from_slice(&value.to_array());
    }
    fn view(rows: &[f64]) -> Option<&[G]> {
        Some(G::wrap_slice(rows.as_chunks().0))
    }
    fn view_mut(rows: &mut [f64]) -> Option<&mut [G]> {
        Some(G::wrap_slice_mut(rows.as_chunks_mut().0))
    }
}

/// The rows of an array (N, ...), or one for all.
pub(crate) fn rows<S: Slot>(array: &Bound<'_, PyAny>, name: &str, count: usize) -> PyResult<Vec<S::Value>> {
    let argument = Argument::new(array, name, S::SHAPE)?;
    let batch = argument.batch(S::SHAPE.len());
    if !(batch == [count] || batch.is_empty()) {
        return Err(ShapeError::new_err(format!("{name}: {batch:?} rows where {count} are expected")));
    }
    let operand = argument.operand(S::SHAPE, S::LEN, &[count])?;
    match operand.first_not_finite(0..count) {
        Some(place) => Err(NotFiniteError::new_err(format!("{name}[{place}] is NaN or infinite"))),
        None => Ok((0..count).map(|place| S::read(operand.row(place))).collect()),
    }
}

/// One or several [`Slot`]s: the arguments of an operation, or its results.
pub(crate) trait Slots {
    /// One value, or a tuple.
    type Values;
    /// The shape of each.
    const SHAPES: &'static [&'static [usize]];
    /// [`Slot::CHECKED`] of each.
    const CHECKED: &'static [bool];
    /// A column of each.
    type Columns<'a>;
    /// A slice of each.
    type Slices<'a>;

    /// The values in the rows at `index`.
    fn read(operands: &[Operand<'_>], index: usize) -> Self::Values;
    /// Writes the values to the rows at `index`.
    fn write(values: &Self::Values, outputs: &mut [&mut [f64]], index: usize);
    /// The values at some places of a batch.
    fn columns<'a>(operands: &'a [Operand<'_>], places: Range<usize>) -> Self::Columns<'a>;
    /// The columns as slices.
    fn slices<'a>(columns: &'a Self::Columns<'_>) -> Self::Slices<'a>;
}

impl<A: Slot> Slots for A {
    type Values = A::Value;
    const SHAPES: &'static [&'static [usize]] = &[A::SHAPE];
    const CHECKED: &'static [bool] = &[A::CHECKED];
    type Columns<'a> = Column<'a, A::Value>;
    type Slices<'a> = &'a [A::Value];

    #[inline]
    fn read(operands: &[Operand<'_>], index: usize) -> A::Value {
        A::read(operands[0].row(index))
    }
    #[inline]
    fn write(value: &A::Value, outputs: &mut [&mut [f64]], index: usize) {
        A::write(value, &mut outputs[0][index * A::LEN..][..A::LEN]);
    }
    fn columns<'a>(operands: &'a [Operand<'_>], places: Range<usize>) -> Column<'a, A::Value> {
        column::<A>(&operands[0], places)
    }
    fn slices<'a>(column: &'a Column<'_, A::Value>) -> &'a [A::Value] {
        column
    }
}

macro_rules! tuples {
    ($(($($slot:ident $i:tt),+))*) => { $(
        impl<$($slot: Slot),+> Slots for ($($slot,)+) {
            type Values = ($($slot::Value,)+);
            const SHAPES: &'static [&'static [usize]] = &[$($slot::SHAPE),+];
            const CHECKED: &'static [bool] = &[$($slot::CHECKED),+];
            type Columns<'a> = ($(Column<'a, $slot::Value>,)+);
            type Slices<'a> = ($(&'a [$slot::Value],)+);

            #[inline]
            fn read(operands: &[Operand<'_>], index: usize) -> Self::Values {
                ($($slot::read(operands[$i].row(index)),)+)
            }
            #[inline]
            fn write(values: &Self::Values, outputs: &mut [&mut [f64]], index: usize) {
                $($slot::write(&values.$i, &mut outputs[$i][index * $slot::LEN..][..$slot::LEN]);)+
            }
            fn columns<'a>(operands: &'a [Operand<'_>], places: Range<usize>) -> Self::Columns<'a> {
                ($(column::<$slot>(&operands[$i], places.clone()),)+)
            }
            fn slices<'a>(columns: &'a Self::Columns<'_>) -> Self::Slices<'a> {
                ($(&columns.$i,)+)
            }
        }
    )* };
}

tuples! { (A 0) (A 0, B 1) (A 0, B 1, C 2) (A 0, B 1, C 2, D 3) (A 0, B 1, C 2, D 3, E 4) (A 0, B 1, C 2, D 3, E 4, F 5) }
