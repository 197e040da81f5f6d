//! Random elements: uniform rotations, directions and poses, Gaussian steps.
//!
//! **Uniform** means invariant: a rotation of the sample is as likely as the sample (Haar measure). Uniform Euler angles are not, nor
//! is a uniform axis with a uniform angle: the angle θ of a uniform rotation has density (1 − cos θ)/π, half turns being most
//! likely. Here SO(3) is drawn by Shoemake's (1992) three numbers, S² by Archimedes' (uniform height and azimuth). Poses have no
//! uniform distribution, their group being unbounded; [`SE3::sample_in_box`] draws the rotation uniformly and the
//! translation, independent of it, in a box of the parent frame.
//!
//! **Gaussian** means in the tangent: X̄·Exp(ξ) with ξ ~ N(0, Σ), Barfoot (2024) (8.37). [`TangentSampler`] factorises Σ once, by
//! Cholesky with pivots, and accepts semidefinite matrices: what has no variance does not move.
//!
//! Of an element whose covariance is kept beside it, [`Gaussian::sample`](crate::uncertainty::Gaussian::sample) draws.
//!
//! The numbers come from a generator of the caller, so that a seed gives the same sample everywhere.
//!
//! ```
//! use boxplus::lie::{LieGroup, SE3, SO3, TangentSampler};
//! use nalgebra::{Matrix6, Vector6};
//! use rand::SeedableRng;
//! let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
//! let anywhere: SO3 = SO3::sample_uniform(&mut rng);
//! // Noise about the body's z axis and along its x axis, nothing else.
//! let noise = TangentSampler::new(&Matrix6::from_diagonal(&Vector6::new(0.04, 0.0, 0.0, 0.0, 0.0, 0.01)))?;
//! let mean = SE3::new(anywhere, [1.0, 2.0, 3.0].into());
//! let step = noise.sample_around(&mean, &mut rng).rminus(&mean);
//! assert!(step.rows(2, 3).norm() < 1e-15 && step[5] != 0.0);
//! # Ok::<(), boxplus::lie::LieError>(())
//! ```

use super::{Jacobian, LieError, LieGroup, Manifold, Real, S2, SE2, SE3, SO2, SO3, Tangent};
use core::f64::consts::TAU;
use nalgebra::{SMatrix, SVector, SimdComplexField, Vector2, Vector3};
use rand::{Rng, RngExt};

/// (cos, sin) of a uniform angle.
fn circle(rng: &mut (impl Rng + ?Sized)) -> [f64; 2] {
    let (sin, cos) = (TAU * rng.random::<f64>()).simd_sin_cos();
    [cos, sin]
}

impl<S: Real> SO2<S> {
    /// A uniform rotation.
    pub fn sample_uniform(rng: &mut (impl Rng + ?Sized)) -> Self {
        let [cos, sin] = circle(rng).map(S::lit);
        Self::from_unit(cos, sin).normalize()
    }
}

impl<S: Real> SO3<S> {
    /// A uniform rotation, Shoemake (1992): two pairs of components, the share of each pair in |q|² = 1 being uniform.
    pub fn sample_uniform(rng: &mut (impl Rng + ?Sized)) -> Self {
        let share = rng.random::<f64>();
        let ([a, b], [c, d]) = (circle(rng), circle(rng));
        let (first, second) = (share.simd_sqrt(), (1.0 - share).simd_sqrt());
        let [x, y, z, w] = [a * first, b * first, c * second, d * second].map(S::lit);
        Self::from_unit(Vector3::new(x, y, z), w).normalize()
    }
}

impl<S: Real> S2<S> {
    /// A uniform direction: height and azimuth are uniform.
    pub fn sample_uniform(rng: &mut (impl Rng + ?Sized)) -> Self {
        let height = 2.0 * rng.random::<f64>() - 1.0;
        let ([cos, sin], radius) = (circle(rng), ((1.0 - height) * (1.0 + height)).simd_sqrt());
        Self::from_unit(Vector3::new(cos * radius, sin * radius, height).map(S::lit))
    }
}

/// Independent standard normal numbers. Box & Muller (1958), without rejection: a seed gives the same sequence everywhere
/// that logarithm and cosine round alike.
pub(crate) fn standard_normal<S: Real, const D: usize>(rng: &mut (impl Rng + ?Sized)) -> SVector<S, D> {
    // 53 bits, in (0, 1).
    let mut uniform = || ((rng.next_u64() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64;
    SVector::from_fn(|_, _| {
        let radius = (-2.0 * uniform().simd_ln()).simd_sqrt();
        S::lit(radius * (TAU * uniform()).simd_cos())
    })
}

/// A uniform point between two corners.
fn in_box<S: Real, const N: usize>(
    rng: &mut (impl Rng + ?Sized),
    [low, high]: [&SVector<S, N>; 2],
) -> SVector<S, N> {
    SVector::from_fn(|i, _| low[i] + (high[i] - low[i]) * S::lit(rng.random::<f64>()))
}

impl<S: Real> SE2<S> {
    /// A pose with uniform rotation and a translation uniform between two corners of a box, in metres of the parent frame.
    pub fn sample_in_box(rng: &mut (impl Rng + ?Sized), corners: [&Vector2<S>; 2]) -> Self {
        let rotation = SO2::sample_uniform(rng);
        Self::from_parts(in_box(rng, corners), rotation)
    }
}

impl<S: Real> SE3<S> {
    /// A pose with uniform rotation and a translation uniform between two corners of a box, in metres of the parent frame.
    pub fn sample_in_box(rng: &mut (impl Rng + ?Sized), corners: [&Vector3<S>; 2]) -> Self {
        let rotation = SO3::sample_uniform(rng);
        Self::new(rotation, in_box(rng, corners))
    }
}

/// Draws tangents ξ ~ N(0, Σ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentSampler<const D: usize> {
    factor: SMatrix<f64, D, D>,
}

/// Asymmetry and negative variances up to this, of correlations, are rounding of J·Σ·Jᵀ: that leaves about D²ε < 10⁻¹³.
const ROUNDING: f64 = 1e-10;

impl<const D: usize> TangentSampler<D> {
    /// For the covariance Σ, D×D, in products of the tangent's units; positive semidefinite.
    ///
    /// # Errors
    /// [`LieError::NotFinite`], or [`LieError::NotACovariance`] for a matrix that is not symmetric or has a negative
    /// direction.
    pub fn new(covariance: &Jacobian<f64, D>) -> Result<Self, LieError> {
        if covariance.iter().any(|x| !x.is_finite()) {
            return Err(LieError::NotFinite);
        }
        // Of correlations, so that metres and radians count alike. A coordinate without variance keeps its scale.
        let sigma = SVector::<f64, D>::from_fn(|i, _| covariance[(i, i)].abs().simd_sqrt());
        let inverse = sigma.map(|s| if s > 0.0 { 1.0 / s } else { 1.0 });
        let correlation = SMatrix::<f64, D, D>::from_fn(|i, j| covariance[(i, j)] * inverse[i] * inverse[j]);
        let deviation = (correlation - correlation.transpose()).amax();
        if deviation > ROUNDING {
            return Err(LieError::NotACovariance { deviation });
        }
        let factor = semidefinite_cholesky((correlation + correlation.transpose()) * 0.5)?;
        Ok(Self {
            factor: SMatrix::from_fn(|i, j| factor[(i, j)] * if sigma[i] > 0.0 { sigma[i] } else { 1.0 }),
        })
    }

    /// L with Σ = L·Lᵀ, D×D; columns beyond the rank of Σ are 0.
    pub fn factor(&self) -> &SMatrix<f64, D, D> {
        &self.factor
    }

    /// ξ = L·n with n standard normal.
    pub fn sample<S: Real>(&self, rng: &mut (impl Rng + ?Sized)) -> Tangent<S, D> {
        (self.factor * standard_normal::<f64, D>(rng)).map(S::lit)
    }

    /// X̄ ⊞ ξ: Σ is that of the local (right) tangent at `mean`.
    pub fn sample_around<M: Manifold<D>>(&self, mean: &M, rng: &mut (impl Rng + ?Sized)) -> M {
        mean.plus(&self.sample(rng))
    }

    /// Exp(ξ)·X̄: Σ is that of the global (left) tangent.
    pub fn sample_around_left<G: LieGroup<D>>(&self, mean: &G, rng: &mut (impl Rng + ?Sized)) -> G {
        mean.lplus(&self.sample(rng))
    }
}

/// L with A = L·Lᵀ, for a symmetric semidefinite A with entries of size 1: the largest remaining variance first.
fn semidefinite_cholesky<const D: usize>(mut a: SMatrix<f64, D, D>) -> Result<SMatrix<f64, D, D>, LieError> {
    let mut factor = SMatrix::<f64, D, D>::zeros();
    for k in 0..D {
        let pivot = a.diagonal().imax();
        let variance = a[(pivot, pivot)];
        // Below, what remains is rounding, or not a covariance.
        if variance <= D as f64 * f64::EPSILON {
            break;
        }
        let column = a.column(pivot) / variance.simd_sqrt();
        a -= column * column.transpose();
        factor.set_column(k, &column);
    }
    let deviation = a.amax();
    if deviation > ROUNDING { Err(LieError::NotACovariance { deviation }) } else { Ok(factor) }
}
