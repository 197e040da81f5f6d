//! The entries of A⁻¹ that lie in the pattern of L, in one sweep down the tree.
//!
//! With Z = A⁻¹, pivots J and the rows I below them, L₂₁L₁₁⁻¹ = Y gives (Takahashi, Fagan & Chin 1973; Erisman & Tinney 1975)
//!
//! ```text
//! Z_IJ = −Z_II·Y        Z_JJ = L₁₁⁻ᵀL₁₁⁻¹ − Yᵀ·Z_IJ
//! ```
//!
//! A front needs Z_II only, which its parent holds, since I lies within the parent's pivots and rows. The sweep is the
//! factorisation run backwards: where an update went up, a block of Z comes down, into the same place of the same stack. It
//! takes about two factorisations, where a column of Z each would take as many solves as there are unknowns.

use super::cholesky::{Cholesky, zeros};
use super::kernels::{Kernels, Matrix, Product, SLACK};
use super::plan::{Front, Leaves};
use crate::graph::GraphError;

/// Scratch of one front.
struct Scratch {
    /// L₁₁⁻¹ by rows, and its negative.
    inverse: Vec<f64>,
    negative: Vec<f64>,
    /// Yᵀ and Z_IJᵀ.
    y: Vec<f64>,
    transposed: Vec<f64>,
    column: Vec<f64>,
}

impl Cholesky {
    /// Computes the selected inverse of the matrix last factorised; [`Self::inverse_entry`] reads it.
    ///
    /// # Errors
    /// [`GraphError::OutOfMemory`].
    pub(crate) fn invert(&mut self) -> Result<(), GraphError> {
        let (mut pivots, mut below) = (0, 0);
        for front in &self.plan.fronts {
            pivots = pivots.max(front.pivots * front.pivots);
            below = below.max(front.pivots * front.below());
        }
        let scratch = || {
            Ok::<_, GraphError>(Scratch {
                inverse: zeros(pivots)?,
                negative: zeros(pivots)?,
                y: zeros(below)?,
                transposed: zeros(below)?,
                column: zeros(self.plan.tallest)?,
            })
        };
        let mut scratch = [scratch()?, scratch()?]; // a leaf's comes on top of its parent's
        let total = self.plan.inverse;
        let mut inverse = core::mem::take(&mut self.inverse);
        inverse.try_reserve_exact(total + SLACK).map_err(|_| GraphError::OutOfMemory)?;
        inverse.resize(total + SLACK, 0.0);
        for number in (0..self.plan.fronts.len()).rev() {
            if !self.plan.fronts[number].is_leaf {
                self.invert_front(number, &mut inverse, &mut scratch);
            }
        }
        self.inverse = inverse;
        Ok(())
    }

    /// (A⁻¹)ᵢⱼ, or `None` where L has no such entry or [`Self::invert`] has not been called since the factorisation.
    pub(crate) fn inverse_entry(&self, i: usize, j: usize) -> Option<f64> {
        let (row, column) = (i.max(j), i.min(j));
        let number = self.plan.fronts.partition_point(|front| front.start <= column).checked_sub(1)?;
        let front = &self.plan.fronts[number];
        let local = if row < front.start + front.pivots {
            row - front.start
        } else {
            let runs = self.plan.runs_of(front);
            let run = &runs[runs.partition_point(|run| run.scalar as usize <= row).checked_sub(1)?];
            let within = row - run.scalar as usize;
            (within < run.len as usize).then_some(front.pivots + run.from as usize + within)?
        };
        self.inverse.get(front.inverse + (column - front.start) * front.rows + local).copied()
    }

    /// Z of one front, from Z_II on its stack; hands the children theirs.
    fn invert_front(&mut self, number: usize, inverse: &mut [f64], scratch: &mut [Scratch]) {
        let front = self.plan.fronts[number];
        let (k, below, rows) = (front.pivots, front.below(), front.rows);
        let Some((scratch, rest)) = scratch.split_first_mut() else { return };
        invert_triangle(self.kernels, &self.panels[front.panel..], &front, scratch);
        let Scratch { inverse: w, negative, y, transposed, .. } = scratch;

        let z_below =
            Matrix { numbers: &self.stacks[front.stack][front.update..], stride: front.update_stride() };
        let z = &mut inverse[front.inverse..front.inverse + rows * k + SLACK];

        let kernels = self.kernels;
        let negative = Matrix { numbers: negative, stride: k };
        let w = Matrix { numbers: w, stride: k };
        let l_below = Matrix { numbers: &self.panels[front.panel + k..], stride: front.stride() };
        subtract(kernels, (y, k), (negative, l_below), [k, below, k], true); // Yᵀ = L₁₁⁻ᵀL₂₁ᵀ
        let y = Matrix { numbers: y, stride: k };
        subtract(kernels, (&mut z[k..], rows), (z_below, y), [below, k, below], true); // Z_IJ = −Z_II·Y
        for (p, column) in z.chunks_exact(rows).take(k).enumerate() {
            column[k..].iter().enumerate().for_each(|(i, x)| transposed[i * k + p] = *x);
        }
        let z_across = Matrix { numbers: transposed, stride: k };
        subtract(kernels, (z, rows), (negative, w), [k, k, k], true); // L₁₁⁻ᵀL₁₁⁻¹
        subtract(kernels, (z, rows), (y, z_across), [k, k, below], false); // −Yᵀ·Z_IJ

        // A leaf has no place of its own on the stack: it is done before the other children get theirs.
        for group in 0..self.plan.leaves_of(&front).len() {
            let Leaves { first, count, .. } = self.plan.leaves_of(&front)[group];
            for leaf in first as usize..(first + count) as usize {
                self.hand_down(&front, leaf, inverse, transposed);
                self.invert_front(leaf, inverse, rest);
            }
        }
        for child in 0..self.plan.children_of(&front).len() {
            let child = self.plan.children_of(&front)[child] as usize;
            self.hand_down(&front, child, inverse, transposed);
        }
    }

    /// Copies the rows and columns of Z that a child needs to the place of its update; `across` is Z_IJᵀ of the parent.
    fn hand_down(&mut self, front: &Front, child: usize, inverse: &[f64], across: &[f64]) {
        let (k, below, rows) = (front.pivots, front.below(), front.rows);
        let child = &self.plan.fronts[child];
        let [even, odd] = &mut self.stacks;
        let (own, other) = if front.stack == 0 { (&*even, odd) } else { (&*odd, even) };
        let target = &mut other[child.update..child.update + child.update_len()];
        let runs = self.plan.runs_of(child);
        for run in runs {
            for t in 0..run.len as usize {
                let column = run.to as usize + t;
                let to = &mut target[(run.from as usize + t) * child.update_stride()..];
                // The column in two pieces: rows of the pivots, and rows below them.
                let (upper, lower) = if run.pivots {
                    inverse[front.inverse + column * rows..][..rows].split_at(k)
                } else {
                    let below = &own[front.update + column * front.update_stride()..][..below];
                    (&across[column * k..][..k], below)
                };
                for other in runs {
                    let from = if other.pivots { upper } else { lower };
                    let len = other.len as usize;
                    to[other.from as usize..][..len].copy_from_slice(&from[other.to as usize..][..len]);
                }
            }
        }
    }
}

/// L₁₁⁻¹, column by column.
fn invert_triangle(kernels: Kernels, panel: &[f64], front: &Front, scratch: &mut Scratch) {
    let k = front.pivots;
    scratch.inverse[..k * k].fill(0.0);
    for j in 0..k {
        let column = &mut scratch.column[..k - j];
        column.fill(0.0);
        column[0] = 1.0;
        kernels.forward(&panel[j * (front.stride() + 1)..], front.stride(), k - j, column);
        column.iter().enumerate().for_each(|(i, x)| scratch.inverse[(j + i) * k + j] = *x);
    }
    scratch.negative.iter_mut().zip(&scratch.inverse[..k * k]).for_each(|(n, w)| *n = -w);
}

/// C := C − A·Bᵀ of these rows, columns and depth, or −A·Bᵀ where C is `fresh`.
fn subtract(
    kernels: Kernels,
    (c, stride): (&mut [f64], usize),
    (a, b): (Matrix<'_>, Matrix<'_>),
    [rows, columns, depth]: [usize; 3],
    fresh: bool,
) {
    kernels.subtract_product(Product { c, stride, a, b, rows, columns, depth, lower: false, fresh });
}
