//! Costs and normal equations over all factors, on as many threads as asked, with the same bits for any number.
//!
//! Factors are cut into chunks of fixed size. Threads compute chunks; sums over chunks, and the scattering into the
//! matrix, run in the order of the chunks on one thread.

use core::ops::Range;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::structure::{Normal, Structure};
use crate::graph::set::{AnySet, stride};
use crate::graph::values::Values;
use crate::pool::Pool;

/// Factors a chunk. Their parts of the normal equations (about 1 kB each for SE(3)) stay in a core's cache.
const CHUNK: usize = 64;
/// Chunks linearised before their parts are scattered: bounds the memory whatever the graph's size.
const BATCH: usize = 64;
/// Fewer factors than this are not worth waking other threads for.
const PARALLEL: usize = 2048;

/// The factor sets of a graph, cut into chunks, and the threads that work on them.
pub(crate) struct Evaluator<'a> {
    sets: &'a [Box<dyn AnySet>],
    chunks: Vec<Chunk>,
    costs: Vec<f64>,
    /// What chunks add to the normal equations.
    parts: Vec<Vec<f64>>,
    pool: Arc<Pool>,
}

#[derive(Clone, Debug)]
struct Chunk {
    set: usize,
    factors: Range<usize>,
}

impl<'a> Evaluator<'a> {
    /// `threads` = 0 means one per core.
    pub(crate) fn new(sets: &'a [Box<dyn AnySet>], threads: usize) -> Self {
        let mut chunks = vec![];
        for (set, factors) in sets.iter().enumerate() {
            let starts = (0..factors.len()).step_by(CHUNK);
            chunks.extend(starts.map(|s| Chunk { set, factors: s..(s + CHUNK).min(factors.len()) }));
        }
        let total: usize = sets.iter().map(|set| set.len()).sum();
        let pool = Arc::new(Pool::new(if total < PARALLEL { 1 } else { threads }, chunks.len()));
        Self { sets, costs: vec![0.0; chunks.len()], chunks, parts: vec![], pool }
    }

    /// The threads.
    pub(crate) fn pool(&self) -> Arc<Pool> {
        Arc::clone(&self.pool)
    }

    /// Number of threads that work.
    pub(crate) fn threads(&self) -> usize {
        self.pool.threads()
    }

    /// The cost: ½ Σ ρ(‖U·r‖²) over all factors.
    pub(crate) fn cost(&mut self, values: &Values) -> f64 {
        let Self { sets, chunks, costs, pool, .. } = self;
        pool.for_each(costs, |i, cost| *cost = sets[chunks[i].set].cost(values, chunks[i].factors.clone()));
        costs.iter().sum()
    }

    /// The curvatures (J·v)ᵀ(J·w) of the cost between all pairs of `directions`, summed over the factors.
    pub(crate) fn curvatures(
        &self,
        values: &Values,
        structure: &Structure,
        directions: &[Vec<f64>],
    ) -> DMatrix<f64> {
        let mut curvatures = DMatrix::zeros(directions.len(), directions.len());
        for set in self.sets {
            let mut slopes = vec![DVector::zeros(directions.len()); set.residual_dim()];
            for factor in 0..set.len() {
                set.slopes(values, factor, &structure.offsets, directions, &mut slopes);
                slopes.iter().for_each(|slope| curvatures.ger(1.0, slope, slope, 1.0));
            }
        }
        curvatures
    }

    /// Overwrites `normal` with JᵀJ and Jᵀr at `values`.
    pub(crate) fn linearise(&mut self, values: &Values, structure: &Structure, normal: &mut Normal) {
        normal.matrix.fill(0.0);
        normal.gradient.fill(0.0);
        let Self { sets, chunks, parts, pool, .. } = self;
        if parts.is_empty() {
            let widest = sets.iter().map(|set| stride(set.dims())).max().unwrap_or(0);
            // One thread scatters each chunk while it is in the cache.
            let together = if pool.threads() > 1 { BATCH.min(chunks.len()) } else { 1 };
            parts.resize(together, vec![0.0; widest * CHUNK]);
        }
        for batch in chunks.chunks(parts.len().max(1)) {
            let parts = &mut parts[..batch.len()];
            pool.for_each(parts, |i, part| {
                let Chunk { set, factors } = batch[i].clone();
                sets[set].linearise(values, factors, part);
            });
            for (Chunk { set, factors }, part) in batch.iter().zip(parts) {
                sets[*set].scatter(factors.clone(), part, &structure.plans[*set], normal);
            }
        }
    }
}
