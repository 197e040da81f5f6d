//! How what a batch reads and writes is laid out number by number, and back.

use crate::lie::lanes::Lanes;
use crate::lie::unrolled::each;
use crate::lie::{LieGroup, Real};
use core::cell::Cell;
use core::marker::PhantomData;
use nalgebra::{ArrayStorage, SMatrix};

/// Elements per block: the numbers of the largest results then stay in the first cache.
pub(crate) const BLOCK: usize = 32;

/// A number that batches compute with: `f32`, `f64`.
pub trait Number: Real + PartialEq {
    /// What stands for it inside a batch.
    type Lanes: Real;
    /// `self`, inside a batch.
    fn lanes(self) -> Self::Lanes;
    /// The number that `lanes` stands for.
    fn of(lanes: Self::Lanes) -> Self;
}

impl Number for f64 {
    type Lanes = Lanes<f64>;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lanes(self) -> Self::Lanes {
        Lanes::from([self, self])
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of(lanes: Self::Lanes) -> Self {
        lanes.0[0]
    }
}

impl Number for f32 {
    type Lanes = Lanes<f32>;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lanes(self) -> Self::Lanes {
        Lanes::from([self, self])
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of(lanes: Self::Lanes) -> Self {
        lanes.0[0]
    }
}

/// Something made of numbers, of which a block is laid out in `Slots`: number by number, `BLOCK` elements each.
pub(crate) trait Shape {
    type Number: Number;
    /// As its user sees it.
    type Narrow: Copy + Send;
    /// The same over lanes.
    type Wide;
    type Slots;
    type Slices<'a>: Copy + Send + Sync;

    /// The length of a slice that is not `len`.
    fn other_length(slices: Self::Slices<'_>, len: usize) -> Option<usize>;
    fn at(slices: Self::Slices<'_>, i: usize) -> Self::Narrow;
    /// Whether the slots have room for all its numbers.
    fn fits() -> bool;
    fn slots() -> Self::Slots;
    fn split(x: &Self::Narrow, slots: &mut Self::Slots, k: usize);
    fn wide(slots: &Self::Slots, k: usize) -> Self::Wide;
    /// Stores `x` and returns the sum of its numbers, which is NaN where one of them is.
    fn put(x: &Self::Wide, slots: &mut Self::Slots, k: usize) -> Self::Number;
    fn join(slots: &Self::Slots, k: usize) -> Self::Narrow;
}

/// A vector or matrix.
pub(crate) struct Flat<T, const R: usize, const C: usize>(PhantomData<T>);

impl<T: Number, const R: usize, const C: usize> Shape for Flat<T, R, C> {
    type Number = T;
    type Narrow = SMatrix<T, R, C>;
    type Wide = SMatrix<T::Lanes, R, C>;
    type Slots = [[[T; BLOCK]; R]; C];
    type Slices<'a> = &'a [SMatrix<T, R, C>];

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn other_length(slices: Self::Slices<'_>, len: usize) -> Option<usize> {
        Some(slices.len()).filter(|n| *n != len)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn at(slices: Self::Slices<'_>, i: usize) -> Self::Narrow {
        slices[i]
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn fits() -> bool {
        true
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn slots() -> Self::Slots {
        [[[T::lit(0.0); BLOCK]; R]; C]
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn split(x: &Self::Narrow, slots: &mut Self::Slots, k: usize) {
        each!(c < C, {
            let (column, slots) = (x.data.0[c], &mut slots[c]);
            each!(r < R, slots[r][k] = column[r]);
        });
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn wide(slots: &Self::Slots, k: usize) -> Self::Wide {
        let mut columns = [[T::lit(0.0).lanes(); R]; C];
        each!(c < C, {
            let (column, slots) = (&mut columns[c], &slots[c]);
            each!(r < R, column[r] = slots[r][k].lanes());
        });
        SMatrix::from_array_storage(ArrayStorage(columns))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn put(x: &Self::Wide, slots: &mut Self::Slots, k: usize) -> T {
        let mut total = T::lit(0.0);
        each!(c < C, {
            let (column, slots, mut sum) = (x.data.0[c], &mut slots[c], T::lit(0.0));
            each!(r < R, {
                let number = T::of(column[r]);
                slots[r][k] = number;
                sum += number;
            });
            total += sum;
        });
        total
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn join(slots: &Self::Slots, k: usize) -> Self::Narrow {
        let mut columns = [[T::lit(0.0); R]; C];
        each!(c < C, {
            let (column, slots) = (&mut columns[c], &slots[c]);
            each!(r < R, column[r] = slots[r][k]);
        });
        SMatrix::from_array_storage(ArrayStorage(columns))
    }
}

/// A group whose elements batches compute with: every group, since over its own scalar it is itself.
pub trait BatchGroup<const D: usize>: LieGroup<D, Scalar: Number> {
    /// `x`, which is one of `Self`.
    fn of(x: Self::Over<Self::Scalar>) -> Self;
}

impl<T: Number, G: LieGroup<D, Scalar = T, Over<T> = G>, const D: usize> BatchGroup<D> for G {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of(x: G) -> G {
        x
    }
}

/// An element of a group: its numbers in the order of [`LieGroup::map`], at most 4D of them.
pub(crate) struct Element<G, const D: usize>(PhantomData<G>);

impl<G: BatchGroup<D>, const D: usize> Shape for Element<G, D> {
    type Number = G::Scalar;
    type Narrow = G;
    type Wide = G::Over<<G::Scalar as Number>::Lanes>;
    type Slots = [[[Cell<G::Scalar>; BLOCK]; D]; 4];
    type Slices<'a> = &'a [G];

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn other_length(slices: Self::Slices<'_>, len: usize) -> Option<usize> {
        Some(slices.len()).filter(|n| *n != len)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn at(slices: Self::Slices<'_>, i: usize) -> G {
        slices[i]
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn fits() -> bool {
        let count = Cell::new(0);
        G::identity().map(|x| {
            count.set(count.get() + 1);
            x
        });
        count.get() <= 4 * D
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn slots() -> Self::Slots {
        core::array::from_fn(|_| {
            core::array::from_fn(|_| core::array::from_fn(|_| Cell::new(G::Scalar::lit(0.0))))
        })
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn split(x: &G, slots: &mut Self::Slots, k: usize) {
        let next = Cell::new(0);
        x.map(|number| {
            let n = next.replace(next.get() + 1);
            slots[n / D][n % D][k].set(number);
            number
        });
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn wide(slots: &Self::Slots, k: usize) -> Self::Wide {
        let next = Cell::new(0);
        G::identity().map(|_| {
            let n = next.replace(next.get() + 1);
            slots[n / D][n % D][k].get().lanes()
        })
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn put(x: &Self::Wide, slots: &mut Self::Slots, k: usize) -> G::Scalar {
        let next = Cell::new(0);
        let sum = Cell::new(G::Scalar::lit(0.0));
        x.map(|lanes| {
            let (n, number) = (next.replace(next.get() + 1), G::Scalar::of(lanes));
            slots[n / D][n % D][k].set(number);
            sum.set(sum.get() + number);
            lanes
        });
        sum.get()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn join(slots: &Self::Slots, k: usize) -> G {
        let next = Cell::new(0);
        G::of(G::identity().map(|_| {
            let n = next.replace(next.get() + 1);
            slots[n / D][n % D][k].get()
        }))
    }
}

impl<A: Shape, B: Shape<Number = A::Number>> Shape for (A, B) {
    type Number = A::Number;
    type Narrow = (A::Narrow, B::Narrow);
    type Wide = (A::Wide, B::Wide);
    type Slots = (A::Slots, B::Slots);
    type Slices<'a> = (A::Slices<'a>, B::Slices<'a>);

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn other_length((a, b): Self::Slices<'_>, len: usize) -> Option<usize> {
        A::other_length(a, len).or(B::other_length(b, len))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn at((a, b): Self::Slices<'_>, i: usize) -> Self::Narrow {
        (A::at(a, i), B::at(b, i))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn fits() -> bool {
        A::fits() && B::fits()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn slots() -> Self::Slots {
        (A::slots(), B::slots())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn split((a, b): &Self::Narrow, (p, q): &mut Self::Slots, k: usize) {
        A::split(a, p, k);
        B::split(b, q, k);
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn wide((p, q): &Self::Slots, k: usize) -> Self::Wide {
        (A::wide(p, k), B::wide(q, k))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn put((a, b): &Self::Wide, (p, q): &mut Self::Slots, k: usize) -> A::Number {
        A::put(a, p, k) + B::put(b, q, k)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn join((p, q): &Self::Slots, k: usize) -> Self::Narrow {
        (A::join(p, k), B::join(q, k))
    }
}

impl<A: Shape, B: Shape<Number = A::Number>, C: Shape<Number = A::Number>> Shape for (A, B, C) {
    type Number = A::Number;
    type Narrow = (A::Narrow, B::Narrow, C::Narrow);
    type Wide = (A::Wide, B::Wide, C::Wide);
    type Slots = (A::Slots, (B::Slots, C::Slots));
    type Slices<'a> = (A::Slices<'a>, (B::Slices<'a>, C::Slices<'a>));

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn other_length(slices: Self::Slices<'_>, len: usize) -> Option<usize> {
        <(A, (B, C))>::other_length(slices, len)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn at(slices: Self::Slices<'_>, i: usize) -> Self::Narrow {
        let (a, (b, c)) = <(A, (B, C))>::at(slices, i);
        (a, b, c)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn fits() -> bool {
        <(A, (B, C))>::fits()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn slots() -> Self::Slots {
        <(A, (B, C))>::slots()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn split(&(a, b, c): &Self::Narrow, slots: &mut Self::Slots, k: usize) {
        <(A, (B, C))>::split(&(a, (b, c)), slots, k);
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn wide(slots: &Self::Slots, k: usize) -> Self::Wide {
        let (a, (b, c)) = <(A, (B, C))>::wide(slots, k);
        (a, b, c)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn put((a, b, c): &Self::Wide, (p, (q, r)): &mut Self::Slots, k: usize) -> A::Number {
        A::put(a, p, k) + B::put(b, q, k) + C::put(c, r, k)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn join(slots: &Self::Slots, k: usize) -> Self::Narrow {
        let (a, (b, c)) = <(A, (B, C))>::join(slots, k);
        (a, b, c)
    }
}
