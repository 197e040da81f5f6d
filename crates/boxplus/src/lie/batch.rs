//! Many elements at once, at the width of the machine.
//!
//! Each operation of [`Batch`] is the scalar operation of the same name over slices, `out[i] = x[i].compose(&y[i])`, to the last bit.
//! Blocks of 32 elements are laid out number by number, computed with the vector instructions the machine has (AVX2, NEON,
//! found at run time), and laid back. No operation is contracted and no sum reordered, so that neither the instruction set nor the
//! number of threads changes a bit. An element that needs a rare form, such as an angle beyond π, is computed alone.
//!
//! Any group serves. One of your own is vectorised if its operations are inlined by force, `#[inline(always)]`, and take their
//! elementary functions from [`Real`]; otherwise it is merely right. So are Exp, Log and Jacobians of the similarities, and
//! Jacobians of SGal(3), which are faster one by one; `docs/benchmarks.md` has what each gains.
//!
//! ```
//! use boxplus::lie::{Batch, LieGroup, SE3};
//! use nalgebra::Vector6;
//! let steps: Vec<Vector6<f64>> = (0..1000).map(|i| Vector6::repeat(0.001 * f64::from(i))).collect();
//! let mut poses = vec![SE3::identity(); steps.len()];
//! Batch::OneCore.exp(&steps, &mut poses)?;
//! assert_eq!(poses[700], SE3::exp(&steps[700]));
//! assert!(Batch::OneCore.exp(&steps, &mut poses[1..]).is_err());
//! # Ok::<(), boxplus::lie::LengthMismatch>(())
//! ```

mod operation;
mod shape;

use super::{Action, Jacobian, LieGroup, Real, Tangent};
use nalgebra::SVector;
use operation::{
    Act, Between, Compose, Exp, ExpJac, Inverse, Log, LogJac, Operation, Rminus, RminusJac, Rplus, RplusJac,
};
#[cfg(feature = "parallel")]
use rayon::prelude::*;
use shape::{BLOCK, Element, Flat, Shape};
pub use shape::{BatchGroup, Number};

/// Below this many elements a block is not worth its layout.
const WORTHWHILE: usize = 4;
/// Elements a thread takes at a time.
#[cfg(feature = "parallel")]
const CHUNK: usize = 1024;

/// Slices of a batch that do not belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a batch of {inputs} inputs and {outputs} outputs; all slices must have the same length")]
pub struct LengthMismatch {
    /// Length of the first input that differs.
    pub inputs: usize,
    /// Length of the output.
    pub outputs: usize,
}

/// Where a batch runs. Its methods are the operations; results are the same bits either way.
///
/// # Errors
/// Every operation gives [`LengthMismatch`], and computes nothing, unless all its slices have one length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Batch {
    /// On the calling thread.
    OneCore,
    /// On the threads of rayon; without the feature `parallel` like [`Batch::OneCore`].
    AllCores,
}

type Wide<G, const D: usize> = <G as LieGroup<D>>::Over<<<G as LieGroup<D>>::Scalar as Number>::Lanes>;
type Vector<G, const D: usize> = Flat<<G as LieGroup<D>>::Scalar, D, 1>;
type Point<G, const D: usize, const N: usize> = Flat<<G as LieGroup<D>>::Scalar, N, 1>;
type Matrix<G, const D: usize> = Flat<<G as LieGroup<D>>::Scalar, D, D>;
/// The result of an operation in two arguments with its Jacobians.
type Jacobians<V, S, const D: usize> = (V, Jacobian<S, D>, Jacobian<S, D>);

#[allow(clippy::missing_errors_doc)] // Said once, above.
impl Batch {
    /// [`LieGroup::exp`].
    pub fn exp<G: BatchGroup<D>, const D: usize>(
        self,
        tau: &[Tangent<G::Scalar, D>],
        out: &mut [G],
    ) -> Result<(), LengthMismatch> {
        self.run::<Exp<D>, Vector<G, D>, Element<G, D>, G, Wide<G, D>>(tau, out)
    }
    /// [`LieGroup::exp_jac`].
    pub fn exp_jac<G: BatchGroup<D>, const D: usize>(
        self,
        tau: &[Tangent<G::Scalar, D>],
        out: &mut [(G, Jacobian<G::Scalar, D>)],
    ) -> Result<(), LengthMismatch> {
        self.run::<ExpJac<D>, Vector<G, D>, (Element<G, D>, Matrix<G, D>), G, Wide<G, D>>(tau, out)
    }
    /// [`LieGroup::log`].
    pub fn log<G: BatchGroup<D>, const D: usize>(
        self,
        x: &[G],
        out: &mut [Tangent<G::Scalar, D>],
    ) -> Result<(), LengthMismatch> {
        self.run::<Log<D>, Element<G, D>, Vector<G, D>, G, Wide<G, D>>(x, out)
    }
    /// [`LieGroup::log_jac`].
    pub fn log_jac<G: BatchGroup<D>, const D: usize>(
        self,
        x: &[G],
        out: &mut [(Tangent<G::Scalar, D>, Jacobian<G::Scalar, D>)],
    ) -> Result<(), LengthMismatch> {
        self.run::<LogJac<D>, Element<G, D>, (Vector<G, D>, Matrix<G, D>), G, Wide<G, D>>(x, out)
    }
    /// [`LieGroup::inverse`].
    pub fn inverse<G: BatchGroup<D>, const D: usize>(
        self,
        x: &[G],
        out: &mut [G],
    ) -> Result<(), LengthMismatch> {
        self.run::<Inverse<D>, Element<G, D>, Element<G, D>, G, Wide<G, D>>(x, out)
    }
    /// [`LieGroup::compose`].
    pub fn compose<G: BatchGroup<D>, const D: usize>(
        self,
        x: &[G],
        y: &[G],
        out: &mut [G],
    ) -> Result<(), LengthMismatch> {
        self.run::<Compose<D>, (Element<G, D>, Element<G, D>), Element<G, D>, G, Wide<G, D>>((x, y), out)
    }
    /// [`LieGroup::between`].
    pub fn between<G: BatchGroup<D>, const D: usize>(
        self,
        x: &[G],
        y: &[G],
        out: &mut [G],
    ) -> Result<(), LengthMismatch> {
        self.run::<Between<D>, (Element<G, D>, Element<G, D>), Element<G, D>, G, Wide<G, D>>((x, y), out)
    }
    /// [`Action::act`].
    pub fn act<G: BatchGroup<D> + Action<D, N>, const D: usize, const N: usize>(
        self,
        x: &[G],
        p: &[SVector<G::Scalar, N>],
        out: &mut [SVector<G::Scalar, N>],
    ) -> Result<(), LengthMismatch>
    where
        Wide<G, D>: Action<D, N>,
    {
        self.run::<Act<D, N>, (Element<G, D>, Point<G, D, N>), Point<G, D, N>, G, Wide<G, D>>((x, p), out)
    }
    /// [`LieGroup::rplus`].
    pub fn rplus<G: BatchGroup<D>, const D: usize>(
        self,
        x: &[G],
        tau: &[Tangent<G::Scalar, D>],
        out: &mut [G],
    ) -> Result<(), LengthMismatch> {
        self.run::<Rplus<D>, (Element<G, D>, Vector<G, D>), Element<G, D>, G, Wide<G, D>>((x, tau), out)
    }
    /// [`LieGroup::rplus_jac`].
    pub fn rplus_jac<G: BatchGroup<D>, const D: usize>(
        self,
        x: &[G],
        tau: &[Tangent<G::Scalar, D>],
        out: &mut [Jacobians<G, G::Scalar, D>],
    ) -> Result<(), LengthMismatch> {
        self.run::<RplusJac<D>, (Element<G, D>, Vector<G, D>), (Element<G, D>, Matrix<G, D>, Matrix<G, D>), G, Wide<G, D>>(
            (x, tau),
            out,
        )
    }
    /// [`LieGroup::rminus`]: `out[i]` = `y[i]` ⊖ `x[i]`.
    pub fn rminus<G: BatchGroup<D>, const D: usize>(
        self,
        y: &[G],
        x: &[G],
        out: &mut [Tangent<G::Scalar, D>],
    ) -> Result<(), LengthMismatch> {
        self.run::<Rminus<D>, (Element<G, D>, Element<G, D>), Vector<G, D>, G, Wide<G, D>>((y, x), out)
    }
    /// [`LieGroup::rminus_jac`]: of `y[i]` ⊖ `x[i]`.
    pub fn rminus_jac<G: BatchGroup<D>, const D: usize>(
        self,
        y: &[G],
        x: &[G],
        out: &mut [Jacobians<Tangent<G::Scalar, D>, G::Scalar, D>],
    ) -> Result<(), LengthMismatch> {
        self.run::<RminusJac<D>, (Element<G, D>, Element<G, D>), (Vector<G, D>, Matrix<G, D>, Matrix<G, D>), G, Wide<G, D>>(
            (y, x),
            out,
        )
    }

    fn run<O, I, R, G, W>(self, input: I::Slices<'_>, out: &mut [R::Narrow]) -> Result<(), LengthMismatch>
    where
        I: Shape,
        R: Shape<Number = I::Number>,
        O: Operation<G, In = I::Narrow, Out = R::Narrow> + Operation<W, In = I::Wide, Out = R::Wide>,
    {
        let outputs = out.len();
        if let Some(inputs) = I::other_length(input, outputs) {
            return Err(LengthMismatch { inputs, outputs });
        }
        if self == Self::AllCores {
            #[cfg(feature = "parallel")]
            out.par_chunks_mut(CHUNK).enumerate().for_each(|(i, out)| {
                dispatch::<O, I, R, G, W>(input, i * CHUNK, out);
            });
            #[cfg(not(feature = "parallel"))]
            dispatch::<O, I, R, G, W>(input, 0, out);
        } else {
            dispatch::<O, I, R, G, W>(input, 0, out);
        }
        Ok(())
    }
}

/// Computes `out` from the inputs at `start` and after, compiled once for each instruction set.
fn dispatch<O, I, R, G, W>(input: I::Slices<'_>, start: usize, out: &mut [R::Narrow])
where
    I: Shape,
    R: Shape<Number = I::Number>,
    O: Operation<G, In = I::Narrow, Out = R::Narrow> + Operation<W, In = I::Wide, Out = R::Wide>,
{
    pulp::Arch::new().dispatch(Blocks::<O, I, R, G, W> { input, start, out, of: core::marker::PhantomData });
}

struct Blocks<'a, 'b, O, I: Shape, R: Shape, G, W> {
    input: I::Slices<'a>,
    start: usize,
    out: &'b mut [R::Narrow],
    of: core::marker::PhantomData<(O, G, W)>,
}

impl<O, I, R, G, W> pulp::WithSimd for Blocks<'_, '_, O, I, R, G, W>
where
    I: Shape,
    R: Shape<Number = I::Number>,
    O: Operation<G, In = I::Narrow, Out = R::Narrow> + Operation<W, In = I::Wide, Out = R::Wide>,
{
    type Output = ();

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let (mut inputs, mut results) = (I::slots(), R::slots());
        let vectorised = I::fits() && R::fits();
        for (block, out) in self.out.chunks_mut(BLOCK).enumerate() {
            let start = self.start + block * BLOCK;
            let mut sums = [I::Number::lit(f64::NAN); BLOCK];
            if vectorised && out.len() >= WORTHWHILE {
                for k in 0..out.len() {
                    I::split(&I::at(self.input, start + k), &mut inputs, k);
                }
                for (k, sum) in sums.iter_mut().enumerate() {
                    *sum = R::put(&<O as Operation<W>>::apply(I::wide(&inputs, k)), &mut results, k);
                }
            }
            for (k, (out, sum)) in out.iter_mut().zip(sums).enumerate() {
                *out = if sum.value().is_nan() {
                    <O as Operation<G>>::apply(I::at(self.input, start + k))
                } else {
                    R::join(&results, k)
                };
            }
        }
    }
}
