//! The surface at a point, from its nearest neighbours.

use crate::uncertainty::Covariance;
use nalgebra::{SMatrix, SVector};

/// Neighbours with less extent than this across their line, as a part of their extent along it, have no plane: 1 : 10.
const LINE: f64 = 0.01;
/// Variance along the normal of a surface, with 1 along the surface; Segal, Haehnel & Thrun (2009) 3.1.
const THICKNESS: f64 = 1e-3;

/// The surface at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Surface<const N: usize> {
    /// Unit normal, its sign arbitrary; `None` where there is no surface.
    pub(super) normal: Option<SVector<f64, N>>,
}

impl<const N: usize> Surface<N> {
    /// The plane (line) of least squares through neighbours.
    pub(super) fn of(neighbours: impl ExactSizeIterator<Item = SVector<f64, N>> + Clone) -> Self {
        let n = neighbours.len().max(1) as f64;
        let mean = neighbours.clone().sum::<SVector<f64, N>>() / n;
        let scatter = neighbours.map(|p| (p - mean) * (p - mean).transpose()).sum::<SMatrix<f64, N, N>>() / n;
        let Ok(scatter) = Covariance::new(scatter) else { return Self::none() };
        let (variances, axes) = scatter.principal_axes();
        // All but the last axis must have extent.
        if N < 2 || variances[N - 2] <= LINE * variances[0] {
            return Self::none();
        }
        Self { normal: Some(axes.column(N - 1).into_owned()) }
    }

    /// No surface.
    pub(super) fn none() -> Self {
        Self { normal: None }
    }

    /// I − (1 − ε)nnᵀ, in units of the variance along the surface; I where there is none.
    pub(super) fn covariance(&self) -> SMatrix<f64, N, N> {
        let flattened = |n: SVector<f64, N>| SMatrix::identity() - n * n.transpose() * (1.0 - THICKNESS);
        self.normal.map_or(SMatrix::identity(), flattened)
    }
}
