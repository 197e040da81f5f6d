//! Small simulated worlds.

use boxplus::graph::{Between, Graph, GroupVariable, Key, Noise, Values};
use nalgebra::{SMatrix, SVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A seeded source of numbers.
pub(crate) fn rng(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// A vector with entries uniform in (−size, size).
pub(crate) fn noise<const D: usize>(rng: &mut ChaCha8Rng, size: f64) -> SVector<f64, D> {
    SVector::from_fn(|_, _| size * rng.random_range(-1.0..1.0))
}

/// A random positive definite matrix with eigenvalues of order `size`.
pub(crate) fn positive<const D: usize>(rng: &mut ChaCha8Rng, size: f64) -> SMatrix<f64, D, D> {
    let a = SMatrix::<f64, D, D>::from_fn(|_, _| rng.random_range(-1.0..1.0));
    (a * a.transpose() + SMatrix::identity()) * size
}

/// A walk of `count` poses with `loops` closures between random pairs, noisy measurements with full information
/// matrices, and starts off the truth by `start`.
pub(crate) struct Walk<G> {
    pub(crate) graph: Graph,
    pub(crate) values: Values,
    pub(crate) keys: Vec<Key<G>>,
    pub(crate) truth: Vec<G>,
}

pub(crate) fn walk<G: GroupVariable<D>, const D: usize>(
    seed: u64,
    count: usize,
    loops: usize,
    start: f64,
) -> Walk<G> {
    let mut rng = rng(seed);
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let mut truth = vec![G::identity()];
    for i in 1..count {
        let step = SVector::from_fn(|row, _| if row == 0 { 1.0 } else { 0.3 }) + noise::<D>(&mut rng, 0.2);
        let next = truth[i - 1].rplus(&step);
        truth.push(next);
    }
    let keys: Vec<_> = truth.iter().map(|x| values.insert(x.rplus(&noise::<D>(&mut rng, start)))).collect();
    let mut measure = |i: usize, j: usize| {
        let measured = truth[i].between(&truth[j]).rplus(&noise::<D>(&mut rng, 0.02));
        let noise = Noise::from_information(&positive::<D>(&mut rng, 1000.0)).unwrap();
        graph.add((keys[i], keys[j]), Between::new(measured), noise);
        rng.random_range(0..count)
    };
    let mut last = 0;
    for i in 1..count {
        last = measure(i - 1, i);
    }
    for k in 0..loops {
        let other = (last + k * 7919) % count;
        let here = (other + count / 2) % count;
        last = measure(here, other);
    }
    Walk { graph, values, keys, truth }
}
