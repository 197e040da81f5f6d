//! Threads that work on the items of a slice, if there are any to be had.

#[cfg(feature = "parallel")]
use rayon::prelude::*;

/// Several threads, or just the caller's.
pub(crate) struct Pool {
    #[cfg(feature = "parallel")]
    threads: Option<rayon::ThreadPool>,
}

#[cfg_attr(
    not(feature = "parallel"),
    expect(clippy::unused_self, reason = "the caller's thread needs no state")
)]
impl Pool {
    /// `threads` = 0 means one per core; more than `items` are never used.
    #[cfg(feature = "parallel")]
    pub(crate) fn new(threads: usize, items: usize) -> Self {
        let available = std::thread::available_parallelism().map_or(1, usize::from);
        let threads = if threads == 0 { available } else { threads }.min(items);
        // A pool that cannot be made (no more threads to be had) is no reason to fail: one gives the same result.
        let build = || rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok();
        Self { threads: if threads > 1 { build() } else { None } }
    }

    #[cfg(not(feature = "parallel"))]
    pub(crate) fn new(_: usize, _: usize) -> Self {
        Self {}
    }

    /// Number of threads that work.
    #[cfg(feature = "solve")]
    pub(crate) fn threads(&self) -> usize {
        #[cfg(feature = "parallel")]
        return self.threads.as_ref().map_or(1, rayon::ThreadPool::current_num_threads);
        #[cfg(not(feature = "parallel"))]
        1
    }

    /// Calls `work` on each item with its number, in any order.
    pub(crate) fn for_each<T: Send>(&self, items: &mut [T], work: impl Fn(usize, &mut T) + Sync) {
        #[cfg(feature = "parallel")]
        if let Some(pool) = &self.threads {
            pool.install(|| items.par_iter_mut().enumerate().for_each(|(i, item)| work(i, item)));
            return;
        }
        items.iter_mut().enumerate().for_each(|(i, item)| work(i, item));
    }
}
