//! How a row of an array holds a value.

use boxplus::lie::Plain;
use bytemuck::TransparentWrapper;
use nalgebra::{SMatrix, SVector};
use std::marker::PhantomData;

use crate::argument::Operand;

/// A kind of value, its shape in an array, and how it is read from and written to a row of numbers.
pub(crate) trait Slot {
    /// What is computed with.
    type Value;
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
    G: Plain<N, Number = f64> + TransparentWrapper<[f64; N]>,
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
}

/// One or several [`Slot`]s: the arguments of an operation, or its results.
pub(crate) trait Slots {
    /// One value, or a tuple.
    type Values;
    /// The shape of each.
    const SHAPES: &'static [&'static [usize]];
    /// [`Slot::CHECKED`] of each.
    const CHECKED: &'static [bool];

    /// The values in the rows at `index`.
    fn read(operands: &[Operand<'_>], index: usize) -> Self::Values;
    /// Writes the values to the rows at `index`.
    fn write(values: &Self::Values, outputs: &mut [&mut [f64]], index: usize);
}

impl<A: Slot> Slots for A {
    type Values = A::Value;
    const SHAPES: &'static [&'static [usize]] = &[A::SHAPE];
    const CHECKED: &'static [bool] = &[A::CHECKED];

    #[inline]
    fn read(operands: &[Operand<'_>], index: usize) -> A::Value {
        A::read(operands[0].row(index))
    }
    #[inline]
    fn write(value: &A::Value, outputs: &mut [&mut [f64]], index: usize) {
        A::write(value, &mut outputs[0][index * A::LEN..][..A::LEN]);
    }
}

macro_rules! tuples {
    ($(($($slot:ident $i:tt),+))*) => { $(
        impl<$($slot: Slot),+> Slots for ($($slot,)+) {
            type Values = ($($slot::Value,)+);
            const SHAPES: &'static [&'static [usize]] = &[$($slot::SHAPE),+];
            const CHECKED: &'static [bool] = &[$($slot::CHECKED),+];

            #[inline]
            fn read(operands: &[Operand<'_>], index: usize) -> Self::Values {
                ($($slot::read(operands[$i].row(index)),)+)
            }
            #[inline]
            fn write(values: &Self::Values, outputs: &mut [&mut [f64]], index: usize) {
                $($slot::write(&values.$i, &mut outputs[$i][index * $slot::LEN..][..$slot::LEN]);)+
            }
        }
    )* };
}

tuples! { (A 0) (A 0, B 1) (A 0, B 1, C 2) (A 0, B 1, C 2, D 3) (A 0, B 1, C 2, D 3, E 4) }
