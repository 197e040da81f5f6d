//! Points and noise at random, the same in every run.

use boxplus::lie::{LieGroup, Tangent};
use nalgebra::{SVector, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Numbers that are the same in every run.
pub(crate) struct Draw(ChaCha8Rng);

impl Draw {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Uniform in [low, high).
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    /// One of 0 … n − 1.
    #[cfg(feature = "registration")]
    pub(crate) fn below(&mut self, n: u8) -> u8 {
        self.0.random_range(0..n)
    }

    /// Standard normal, Box & Muller (1958).
    pub(crate) fn normal(&mut self) -> f64 {
        let (u, v): (f64, f64) = (1.0 - self.0.random::<f64>(), self.0.random());
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    }

    /// Independent standard normal coordinates.
    pub(crate) fn normals<const N: usize>(&mut self) -> SVector<f64, N> {
        SVector::from_fn(|_, _| self.normal())
    }

    /// An element with standard normal tangent times `size`.
    pub(crate) fn element<G: LieGroup<D, Scalar = f64>, const D: usize>(&mut self, size: f64) -> G {
        G::exp(&(Tangent::<f64, D>::from_fn(|_, _| self.normal()) * size))
    }
}

/// The mean of `x`, and its standard error.
pub(crate) fn mean_and_error(x: &[f64]) -> (f64, f64) {
    let n = x.len() as f64;
    let mean = x.iter().sum::<f64>() / n;
    let variance = x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

/// The angle between two directions of space, up to sign.
pub(crate) fn angle_between(a: &[f64], b: &Vector3<f64>) -> f64 {
    let a = Vector3::from_column_slice(a);
    a.cross(b).norm().atan2(a.dot(b).abs())
}
