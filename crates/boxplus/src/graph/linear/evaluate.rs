//! Costs and normal equations over all factors, on as many threads as asked, with the same bits for any number.
//!
//! Factors are cut into chunks of fixed size. Threads compute chunks; sums over chunks, and the scattering into the
//! matrix, run in the order of the chunks on one thread.

use core::ops::Range;

use super::structure::{Normal, Structure};
use crate::graph::factor::{AnySet, stride};
use crate::graph::values::Values;

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
    buffers: Vec<Vec<f64>>,
    costs: Vec<f64>,
    #[cfg(feature = "parallel")]
    pool: Option<rayon::ThreadPool>,
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
        let widest = sets.iter().map(|set| stride(set.dims())).max().unwrap_or(0);
        let buffers = vec![vec![0.0; widest * CHUNK]; BATCH.min(chunks.len())];
        let costs = vec![0.0; chunks.len()];
        let _ = (threads, total, PARALLEL);
        Self {
            sets,
            chunks,
            buffers,
            costs,
            #[cfg(feature = "parallel")]
            pool: pool(if total < PARALLEL { 1 } else { threads }),
        }
    }

    /// Number of threads that work.
    pub(crate) fn threads(&self) -> usize {
        #[cfg(feature = "parallel")]
        return self.pool.as_ref().map_or(1, rayon::ThreadPool::current_num_threads);
        #[cfg(not(feature = "parallel"))]
        1
    }

    /// The cost: ½ Σ ρ(‖U·r‖²) over all factors.
    pub(crate) fn cost(&mut self, values: &Values) -> f64 {
        let Self { sets, chunks, costs, .. } = self;
        let evaluate = |chunk: &Chunk| sets[chunk.set].cost(values, chunk.factors.clone());
        #[cfg(feature = "parallel")]
        if let Some(pool) = &self.pool {
            use rayon::prelude::*;
            pool.install(|| {
                costs.par_iter_mut().zip(chunks.par_iter()).for_each(|(cost, chunk)| *cost = evaluate(chunk));
            });
            return costs.iter().sum();
        }
        costs.iter_mut().zip(chunks.iter()).for_each(|(cost, chunk)| *cost = evaluate(chunk));
        costs.iter().sum()
    }

    /// Overwrites `normal` with JᵀJ and Jᵀr at `values`, and returns the cost.
    pub(crate) fn linearise(&mut self, values: &Values, structure: &Structure, normal: &mut Normal) -> f64 {
        normal.matrix.fill(0.0);
        normal.gradient.fill(0.0);
        let mut cost = 0.0;
        for batch in self.chunks.chunks(BATCH) {
            let sets = self.sets;
            let work = |(cost, (chunk, buffer)): (&mut f64, (&Chunk, &mut Vec<f64>))| {
                *cost = sets[chunk.set].linearise(values, chunk.factors.clone(), buffer);
            };
            #[cfg(feature = "parallel")]
            if let Some(pool) = &self.pool {
                use rayon::prelude::*;
                let jobs = batch.par_iter().zip(&mut self.buffers);
                pool.install(|| self.costs.par_iter_mut().zip(jobs).for_each(work));
            } else {
                self.costs.iter_mut().zip(batch.iter().zip(&mut self.buffers)).for_each(work);
            }
            #[cfg(not(feature = "parallel"))]
            self.costs.iter_mut().zip(batch.iter().zip(&mut self.buffers)).for_each(work);

            for ((chunk, buffer), part) in batch.iter().zip(&self.buffers).zip(&self.costs) {
                sets[chunk.set].scatter(chunk.factors.clone(), buffer, &structure.plans[chunk.set], normal);
                cost += part;
            }
        }
        cost
    }
}

/// A pool where more than one thread is wanted.
#[cfg(feature = "parallel")]
fn pool(threads: usize) -> Option<rayon::ThreadPool> {
    let available = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = if threads == 0 { available } else { threads };
    // A pool that cannot be made (no more threads to be had) is no reason to fail: one thread gives the same result.
    if threads > 1 { rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok() } else { None }
}
