//! Dense kernels of the factorisation, on column-major slices.
//!
//! All work goes through one register tile, Σₚ a(·, p)·b(·, p)ᵀ: up to four vectors of rows by six columns, which is what
//! the registers hold and what the blocks of 3 and 6 of pose graphs fill. The vectors are those of the machine the program
//! runs on (AVX-512, AVX2, NEON), chosen once at run time. Each entry is summed over p in one order, whatever tile it falls
//! into: cutting the work differently changes no bit.

mod triangular;
mod updates;

use pulp::{Arch, Simd, WithSimd, bytemuck};

use triangular::{Backward, Forward};
pub(crate) use updates::{Columns, Extension, Outer, Run};

/// Numbers beyond the end of a matrix that kernels may read (never use): all but one of the widest vector, rounded up.
pub(crate) const SLACK: usize = 8;

/// Columns of A and B taken at a time: of a tall front, so many fit into a core's cache.
pub(crate) const DEPTH: usize = 96;

/// The instruction set of this machine.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kernels(Arch);

impl Kernels {
    pub(crate) fn new() -> Self {
        Self(Arch::new())
    }

    /// Does `work` with what is inlined in it compiled for this machine's vectors. No bit depends on them: nothing is contracted.
    pub(crate) fn run<R>(self, work: impl FnOnce() -> R) -> R {
        self.0.dispatch(work)
    }

    /// Factorises the `pivots` leading columns of a front of `rows` rows in place, L₁₁ and L₂₁ of
    ///
    /// ```text
    /// [F₁₁ ·]   [L₁₁  ] [L₁₁ᵀ L₂₁ᵀ]
    /// [F₂₁ U] = [L₂₁ I] [       U′]        U′ = U − L₂₁L₂₁ᵀ
    /// ```
    ///
    /// `panel` holds the columns and [`SLACK`]. Returns whether all pivots are positive.
    pub(crate) fn factorise(self, panel: &mut [f64], rows: usize, pivots: usize) -> bool {
        for first in (0..pivots).step_by(DEPTH) {
            let width = (pivots - first).min(DEPTH);
            let next = first + width;
            let block = &mut panel[first * (rows + 1)..];
            if !self.0.dispatch(Factorise { panel: block, stride: rows, rows: rows - first, pivots: width }) {
                return false;
            }
            if next < pivots {
                // What is above the diagonal of the next columns is slack to those before.
                let (done, rest) = panel.split_at_mut(next * (rows + 1));
                let l = Matrix { numbers: &done[first * rows + next..], stride: rows };
                self.subtract_product(Product {
                    c: rest,
                    stride: rows,
                    a: l,
                    b: l,
                    rows: rows - next,
                    columns: pivots - next,
                    depth: width,
                    lower: true,
                    fresh: false,
                });
            }
        }
        true
    }

    /// C := C − A·Bᵀ, or −A·Bᵀ where C is `fresh`.
    pub(crate) fn subtract_product(self, product: Product<'_>) {
        self.0.dispatch(product);
    }

    /// Adds an update to columns of the parent.
    pub(crate) fn extend_add(self, extension: Extension<'_>) {
        self.0.dispatch(extension);
    }

    /// Subtracts a product L·Lᵀ from columns of the parent.
    pub(crate) fn subtract_outer(self, outer: Outer<'_>) {
        self.0.dispatch(outer);
    }

    /// x := [L₁₁⁻¹x₁; x₂ − L₂₁L₁₁⁻¹x₁].
    pub(crate) fn forward(self, panel: &[f64], rows: usize, pivots: usize, x: &mut [f64]) {
        self.0.dispatch(Forward { panel, rows, pivots, x });
    }

    /// x₁ := L₁₁⁻ᵀ(x₁ − L₂₁ᵀx₂).
    pub(crate) fn backward(self, panel: &[f64], rows: usize, pivots: usize, x: &mut [f64]) {
        self.0.dispatch(Backward { panel, rows, pivots, x });
    }
}

/// A column-major matrix: its numbers from the first on, and the distance of its columns.
#[derive(Clone, Copy)]
pub(crate) struct Matrix<'a> {
    pub(crate) numbers: &'a [f64],
    pub(crate) stride: usize,
}

/// C := C − A·Bᵀ with A `rows`×`depth` and B `columns`×`depth`. A has [`SLACK`] behind it.
pub(crate) struct Product<'a> {
    pub(crate) c: &'a mut [f64],
    pub(crate) stride: usize,
    pub(crate) a: Matrix<'a>,
    pub(crate) b: Matrix<'a>,
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    pub(crate) depth: usize,
    /// Whether only entries on and below the diagonal are wanted; others are then arbitrary.
    pub(crate) lower: bool,
    /// Whether C holds nothing yet.
    pub(crate) fresh: bool,
}

/// The widest tile, in columns, that fits into `columns`.
const fn width(columns: usize) -> usize {
    match columns {
        0..=2 => columns,
        3..=5 => 3,
        _ => 6,
    }
}

/// Vectors in the tallest tile: six columns of them, and the operands, fit into the registers.
const fn tallest<S: Simd>() -> usize {
    if S::REGISTER_COUNT >= 32 { 4 } else { 2 }
}

/// Calls `$run::<S, V, N>` for the tile of `$vectors`×`$columns`.
macro_rules! tile {
    ($s:ty, $vectors:expr, $n:ident, $run:ident($($argument:expr),*)) => {
        match $vectors {
            1 => $run::<$s, 1, $n>($($argument),*),
            2 => $run::<$s, 2, $n>($($argument),*),
            3 => $run::<$s, 3, $n>($($argument),*),
            _ => $run::<$s, 4, $n>($($argument),*),
        }
    };
}

/// Σₚ a(·, p)·b(·, p)ᵀ: N columns of V vectors.
#[inline(always)]
fn products<S: Simd, const V: usize, const N: usize>(
    simd: S,
    a: Matrix<'_>,
    b: Matrix<'_>,
    depth: usize,
) -> [[S::f64s; V]; N] {
    let mut sums = [[simd.splat_f64s(0.0); V]; N];
    for p in 0..depth {
        let a = &S::as_simd_f64s(&a.numbers[p * a.stride..][..V * S::F64_LANES]).0[..V];
        let b = &b.numbers[p * b.stride..][..N];
        for n in 0..N {
            let factor = simd.splat_f64s(b[n]);
            for v in 0..V {
                sums[n][v] = simd.mul_add_e_f64s(a[v], factor, sums[n][v]);
            }
        }
    }
    sums
}

/// V vectors from the start of `column`; what it does not have is zero.
#[inline(always)]
fn load<S: Simd, const V: usize>(simd: S, column: &[f64]) -> [S::f64s; V] {
    let mut loaded = [simd.splat_f64s(0.0); V];
    if column.len() >= V * S::F64_LANES {
        loaded.copy_from_slice(&S::as_simd_f64s(&column[..V * S::F64_LANES]).0[..V]);
    } else {
        let numbers: &mut [f64] = bytemuck::cast_slice_mut(&mut loaded);
        numbers.iter_mut().zip(column).for_each(|(to, from)| *to = *from);
    }
    loaded
}

/// Writes the first `rows` numbers of V vectors, of which the last may be filled in part.
#[inline(always)]
fn store<S: Simd, const V: usize>(simd: S, column: &mut [f64], rows: usize, values: [S::f64s; V]) {
    if rows >= V * S::F64_LANES {
        let (vectors, _) = S::as_mut_simd_f64s(&mut column[..V * S::F64_LANES]);
        vectors.copy_from_slice(&values);
    } else if column.len() >= V * S::F64_LANES {
        // What stands behind is written as it was: a whole vector is faster than its parts.
        let (vectors, _) = S::as_mut_simd_f64s(&mut column[..V * S::F64_LANES]);
        vectors[..V - 1].copy_from_slice(&values[..V - 1]);
        let filled = simd.mask_between_m64s(0, (rows - (V - 1) * S::F64_LANES) as u64).mask();
        vectors[V - 1] = simd.select_f64s(filled, values[V - 1], vectors[V - 1]);
    } else {
        let numbers: &[f64] = bytemuck::cast_slice(&values);
        column[..rows].copy_from_slice(&numbers[..rows]);
    }
}

impl WithSimd for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let depth = self.depth;
        if depth == 0 && self.fresh {
            strips(simd, &mut self);
        }
        for first in (0..depth).step_by(DEPTH) {
            self.depth = (depth - first).min(DEPTH);
            strips(simd, &mut self);
            self.a.numbers = &self.a.numbers[(self.a.stride * DEPTH).min(self.a.numbers.len())..];
            self.b.numbers = &self.b.numbers[(self.b.stride * DEPTH).min(self.b.numbers.len())..];
            self.fresh = false;
        }
    }
}

/// All columns of a product.
#[inline(always)]
fn strips<S: Simd>(simd: S, product: &mut Product<'_>) {
    let mut column = 0;
    while column < product.columns {
        let n = width(product.columns - column);
        match n {
            1 => strip::<S, 1>(simd, product, column),
            2 => strip::<S, 2>(simd, product, column),
            3 => strip::<S, 3>(simd, product, column),
            _ => strip::<S, 6>(simd, product, column),
        }
        column += n;
    }
}

/// The N columns of a product from `column` on.
#[inline(always)]
fn strip<S: Simd, const N: usize>(simd: S, product: &mut Product<'_>, column: usize) {
    let mut row = if product.lower { column } else { 0 };
    while row < product.rows {
        let vectors = (product.rows - row).div_ceil(S::F64_LANES).min(tallest::<S>());
        tile!(S, vectors, N, product_tile(simd, product, row, column));
        row += vectors * S::F64_LANES;
    }
}

#[inline(always)]
fn product_tile<S: Simd, const V: usize, const N: usize>(
    simd: S,
    product: &mut Product<'_>,
    row: usize,
    column: usize,
) {
    let a = Matrix { numbers: &product.a.numbers[row..], stride: product.a.stride };
    let b = Matrix { numbers: &product.b.numbers[column..], stride: product.b.stride };
    let sums = products::<S, V, N>(simd, a, b, product.depth);
    for (n, sums) in sums.iter().enumerate() {
        let target = &mut product.c[(column + n) * product.stride + row..];
        let mut values = [simd.splat_f64s(0.0); V];
        if !product.fresh {
            values = load::<S, V>(simd, target);
        }
        for v in 0..V {
            values[v] = simd.sub_f64s(values[v], sums[v]);
        }
        let rows = (product.rows - row).min(V * S::F64_LANES);
        store::<S, V>(simd, target, rows, values);
    }
}

struct Factorise<'a> {
    panel: &'a mut [f64],
    stride: usize,
    rows: usize,
    pivots: usize,
}

impl WithSimd for Factorise<'_> {
    type Output = bool;

    /// Left-looking over strips of up to six columns, each read and written once.
    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> bool {
        let mut column = 0;
        while column < self.pivots {
            let n = width(self.pivots - column);
            let positive = match n {
                1 => pivot_strip::<S, 1>(simd, &mut self, column),
                2 => pivot_strip::<S, 2>(simd, &mut self, column),
                3 => pivot_strip::<S, 3>(simd, &mut self, column),
                _ => pivot_strip::<S, 6>(simd, &mut self, column),
            };
            if !positive {
                return false;
            }
            column += n;
        }
        true
    }
}

/// The Cholesky factor of a small matrix, column by column, with the inverses of its pivots.
struct Triangle<const N: usize> {
    l: [[f64; N]; N],
    inverses: [f64; N],
}

/// The N columns of a panel from `column` on, those before being done.
#[inline(always)]
fn pivot_strip<S: Simd, const N: usize>(simd: S, front: &mut Factorise<'_>, column: usize) -> bool {
    let Some(triangle) = diagonal::<N>(front, column) else { return false };
    let mut row = column + N;
    while row < front.rows {
        let vectors = (front.rows - row).div_ceil(S::F64_LANES).min(tallest::<S>());
        tile!(S, vectors, N, pivot_tile(simd, front, row, column, &triangle));
        row += vectors * S::F64_LANES;
    }
    true
}

/// Factorises the N×N block on the diagonal, or `None` where a pivot is not positive.
#[inline(always)]
fn diagonal<const N: usize>(front: &mut Factorise<'_>, column: usize) -> Option<Triangle<N>> {
    let mut l = [[0.0; N]; N];
    for p in 0..column {
        let before = &front.panel[p * front.stride + column..][..N];
        for j in 0..N {
            for i in 0..N {
                l[j][i] -= before[i] * before[j];
            }
        }
    }
    let mut inverses = [0.0; N];
    for j in 0..N {
        let target = &mut front.panel[(column + j) * front.stride + column..][..N];
        for i in j..N {
            l[j][i] += target[i];
            for t in 0..j {
                l[j][i] -= l[t][i] * l[t][j];
            }
        }
        let pivot = l[j][j];
        if pivot.is_nan() || pivot <= 0.0 {
            return None;
        }
        l[j][j] = pivot.sqrt();
        inverses[j] = l[j][j].recip();
        l[j][j + 1..].iter_mut().for_each(|l| *l *= inverses[j]);
        target[j..].copy_from_slice(&l[j][j..]);
    }
    Some(Triangle { l, inverses })
}

/// Rows below the diagonal block: (F − Σ l(·, p)·l(·, p)ᵀ)·L⁻ᵀ.
#[inline(always)]
fn pivot_tile<S: Simd, const V: usize, const N: usize>(
    simd: S,
    front: &mut Factorise<'_>,
    row: usize,
    column: usize,
    triangle: &Triangle<N>,
) {
    let stride = front.stride;
    let a = Matrix { numbers: &front.panel[row..], stride };
    let b = Matrix { numbers: &front.panel[column..], stride };
    let mut tile = products::<S, V, N>(simd, a, b, column);
    let rows = (front.rows - row).min(V * S::F64_LANES);
    for n in 0..N {
        let (done, rest) = tile.split_at_mut(n);
        let here = &mut rest[0];
        let target = &mut front.panel[(column + n) * stride + row..];
        let held = load::<S, V>(simd, target);
        here.iter_mut().zip(held).for_each(|(sum, held)| *sum = simd.sub_f64s(held, *sum));
        for (t, before) in done.iter().enumerate() {
            let factor = simd.splat_f64s(-triangle.l[t][n]);
            here.iter_mut().zip(before).for_each(|(x, l)| *x = simd.mul_add_e_f64s(*l, factor, *x));
        }
        let inverse = simd.splat_f64s(triangle.inverses[n]);
        here.iter_mut().for_each(|x| *x = simd.mul_f64s(*x, inverse));
        store::<S, V>(simd, target, rows, *here);
    }
}
