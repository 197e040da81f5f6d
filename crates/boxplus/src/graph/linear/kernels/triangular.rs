//! Substitution with the columns of one front.

use super::{Simd, WithSimd};

pub(super) struct Forward<'a> {
    pub(super) panel: &'a [f64],
    pub(super) rows: usize,
    pub(super) pivots: usize,
    pub(super) x: &'a mut [f64],
}

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for p in 0..self.pivots {
            let column = &self.panel[p * self.rows..][..self.x.len()];
            let pivot = self.x[p] / column[p];
            self.x[p] = pivot;
            let minus = simd.splat_f64s(-pivot);
            let (vectors, tail) = S::as_simd_f64s(&column[p + 1..]);
            let (targets, rest) = S::as_mut_simd_f64s(&mut self.x[p + 1..]);
            for (target, l) in targets.iter_mut().zip(vectors) {
                *target = simd.mul_add_e_f64s(*l, minus, *target);
            }
            rest.iter_mut().zip(tail).for_each(|(target, l)| *target -= l * pivot);
        }
    }
}

pub(super) struct Backward<'a> {
    pub(super) panel: &'a [f64],
    pub(super) rows: usize,
    pub(super) pivots: usize,
    pub(super) x: &'a mut [f64],
}

impl WithSimd for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for p in (0..self.pivots).rev() {
            let column = &self.panel[p * self.rows..][..self.x.len()];
            let (vectors, tail) = S::as_simd_f64s(&column[p + 1..]);
            let (factors, rest) = S::as_simd_f64s(&self.x[p + 1..]);
            let mut sums = [simd.splat_f64s(0.0); 4];
            for (vectors, factors) in vectors.chunks(4).zip(factors.chunks(4)) {
                for ((sum, l), x) in sums.iter_mut().zip(vectors).zip(factors) {
                    *sum = simd.mul_add_e_f64s(*l, *x, *sum);
                }
            }
            let sum = simd.add_f64s(simd.add_f64s(sums[0], sums[1]), simd.add_f64s(sums[2], sums[3]));
            let tail: f64 = tail.iter().zip(rest).map(|(l, x)| l * x).sum();
            self.x[p] = (self.x[p] - simd.reduce_sum_f64s(sum) - tail) / column[p];
        }
    }
}
