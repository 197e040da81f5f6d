//! Matches of points, and the quadratic model of their cost.

use super::closed_form::Alignable;
use super::icp::{Icp, Method};
use super::scan::{CHUNK, Scan};
use crate::lie::{Jacobian, Tangent};
use crate::pool::Pool;
use crate::robust::Kernel;
use nalgebra::{SMatrix, SVector};

/// A source point p, its partner q and the metric W of r = q − X·p, held while a step is tried.
#[derive(Clone, Copy)]
pub(super) struct Match<const N: usize> {
    pub(super) p: SVector<f64, N>,
    q: SVector<f64, N>,
    metric: SMatrix<f64, N, N>,
    /// Of the target at q.
    pub(super) normal: Option<SVector<f64, N>>,
}

impl<const N: usize> Match<N> {
    /// `(r, rᵀWr)` at X.
    #[inline]
    fn residual<G: Alignable<D, N>, const D: usize>(&self, x: &G) -> (SVector<f64, N>, f64) {
        let r = self.q - x.act(&self.p);
        (r, r.dot(&(self.metric * r)))
    }
}

/// Sums over matches at X, about which X·Exp(τ) costs ½c − gᵀτ + ½τᵀHτ.
#[derive(Clone, Copy)]
pub(super) struct Model<const D: usize> {
    /// H = ΣwJᵀWJ.
    pub(super) hessian: Jacobian<f64, D>,
    /// g = ΣwJᵀWr.
    pub(super) gradient: Tangent<f64, D>,
    /// Σw, with w = ρ′ the weight of a match.
    pub(super) weight: f64,
    /// Σw·rᵀWr.
    pub(super) squares: f64,
    /// Σ|r|².
    pub(super) distances: f64,
    /// Σσ²ρ.
    pub(super) cost: f64,
}

impl<const D: usize> Model<D> {
    fn zero() -> Self {
        Self {
            hessian: SMatrix::zeros(),
            gradient: SVector::zeros(),
            weight: 0.0,
            squares: 0.0,
            distances: 0.0,
            cost: 0.0,
        }
    }

    fn plus(self, other: &Self) -> Self {
        Self {
            hessian: self.hessian + other.hessian,
            gradient: self.gradient + other.gradient,
            weight: self.weight + other.weight,
            squares: self.squares + other.squares,
            distances: self.distances + other.distances,
            cost: self.cost + other.cost,
        }
    }
}

/// A piece of the source with its matches.
struct Chunk<const N: usize, const D: usize> {
    matches: Vec<Match<N>>,
    model: Model<D>,
    cost: f64,
}

/// The matches of a source with a target.
pub(super) struct Matching<'a, const N: usize, const D: usize> {
    source: &'a Scan<N>,
    target: &'a Scan<N>,
    options: &'a Icp,
    pool: Pool,
    chunks: Vec<Chunk<N, D>>,
    /// Standard deviation of √(rᵀWr), by which a robust kernel judges.
    scale: f64,
}

impl<'a, const N: usize, const D: usize> Matching<'a, N, D> {
    pub(super) fn new(source: &'a Scan<N>, target: &'a Scan<N>, options: &'a Icp) -> Self {
        let count = source.points.len().div_ceil(CHUNK);
        let empty = || Chunk { matches: Vec::with_capacity(CHUNK), model: Model::zero(), cost: 0.0 };
        let chunks = (0..count).map(|_| empty()).collect();
        Self { source, target, options, pool: Pool::new(options.threads, count), chunks, scale: 1.0 }
    }

    /// Every match, in the order of the source.
    pub(super) fn each(&self) -> impl Iterator<Item = &Match<N>> {
        self.chunks.iter().flat_map(|chunk| &chunk.matches)
    }

    /// Root of the mean squared distance of the source points from their centroid: what a radian moves them. A single place has
    /// none; there any length will do.
    pub(super) fn radius(&self) -> f64 {
        if self.source.radius > 0.0 { self.source.radius } else { 1.0 }
    }

    /// How many points of the source have a partner.
    pub(super) fn count(&self) -> usize {
        self.chunks.iter().map(|chunk| chunk.matches.len()).sum()
    }

    /// Pairs every source point with the nearest target point, X being relative to the centroids.
    pub(super) fn pair<G: Alignable<D, N>>(&mut self, x: &G) {
        let Self { source, target, options, pool, chunks, .. } = self;
        // One matrix for all points is cheaper than the action.
        let (rotation, translation) = (x.linear_part(), x.act(&SVector::zeros()));
        let gate = options.max_distance * options.max_distance;
        pool.for_each(chunks, |k, chunk| {
            chunk.matches.clear();
            let first = k * CHUNK;
            for i in first..source.points.len().min(first + CHUNK) {
                let p = source.points[i];
                let (j, distance) = target.nearest(&(rotation * p + translation));
                if distance <= gate {
                    chunk.matches.extend(matched(options.method, (source, i), (target, j), &rotation));
                }
            }
        });
        self.scale = self.options.noise.unwrap_or_else(|| self.spread(x));
    }

    /// The quadratic model of the cost.
    pub(super) fn model<G: Alignable<D, N>>(&mut self, x: &G) -> Model<D> {
        let (kernel, variance) = (self.options.kernel, self.scale * self.scale);
        let a = x.linear_part();
        self.pool.for_each(&mut self.chunks, |_, chunk| {
            chunk.model = chunk.matches.iter().fold(Model::zero(), |sum, m| {
                let (r, s) = m.residual(x);
                let (rho, w) = kernel.evaluate(s / variance);
                let j = a * G::generators_at(&m.p);
                let jw = j.transpose() * (m.metric * w);
                Model {
                    hessian: sum.hessian + jw * j,
                    gradient: sum.gradient + jw * r,
                    weight: sum.weight + w,
                    squares: sum.squares + w * s,
                    distances: sum.distances + r.norm_squared(),
                    cost: sum.cost + variance * rho,
                }
            });
        });
        self.chunks.iter().fold(Model::zero(), |sum, chunk| sum.plus(&chunk.model))
    }

    /// Σσ²ρ(rᵀWr/σ²) of the matches as they are.
    pub(super) fn cost<G: Alignable<D, N>>(&mut self, x: &G) -> f64 {
        let (kernel, variance) = (self.options.kernel, self.scale * self.scale);
        self.pool.for_each(&mut self.chunks, |_, chunk| {
            let cost = |m: &Match<N>| variance * kernel.rho(m.residual(x).1 / variance);
            chunk.cost = chunk.matches.iter().map(cost).sum();
        });
        self.chunks.iter().map(|chunk| chunk.cost).sum()
    }

    /// The standard deviation of √(rᵀWr) by its median, which half of the matches may be wrong about.
    fn spread<G: Alignable<D, N>>(&self, x: &G) -> f64 {
        if self.options.kernel == Kernel::None {
            return 1.0;
        }
        let mut squares: Vec<f64> = self.each().map(|m| m.residual(x).1).collect();
        let middle = squares.len() / 2;
        if middle == 0 {
            return 1.0;
        }
        let median = *squares.select_nth_unstable_by(middle, f64::total_cmp).1;
        // The median of χ² with as many degrees of freedom as the residual has; a perfect fit has no scale.
        let quantile = if self.options.method == Method::PointToPoint {
            [0.455, 1.386, 2.366][N.min(3) - 1]
        } else {
            0.455
        };
        let floor = f64::EPSILON * self.options.max_distance;
        (median / quantile).sqrt().max(floor)
    }
}

/// A match with its metric; `None` where the method can do nothing with it.
fn matched<const N: usize>(
    method: Method,
    (source, i): (&Scan<N>, usize),
    (target, j): (&Scan<N>, usize),
    rotation: &SMatrix<f64, N, N>,
) -> Option<Match<N>> {
    let surface = target.surfaces.get(j);
    let normal = surface.and_then(|surface| surface.normal);
    let metric = match method {
        Method::PointToPoint => SMatrix::identity(),
        Method::PointToPlane => normal.map(|n| n * n.transpose())?,
        Method::Generalised => {
            let of_source = source.surfaces.get(i)?.covariance();
            inverse(surface?.covariance() + rotation * of_source * rotation.transpose())
        }
    };
    Some(Match { p: source.points[i], q: target.points[j], metric, normal })
}

/// The inverse of a small symmetric positive definite matrix, which needs no pivots: Gauss and Jordan, in place.
#[inline]
fn inverse<const N: usize>(mut a: SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    for k in 0..N {
        let pivot = a[(k, k)].recip();
        a[(k, k)] = 1.0;
        a.row_mut(k).scale_mut(pivot);
        for i in (0..N).filter(|&i| i != k) {
            let factor = a[(i, k)];
            a[(i, k)] = 0.0;
            for j in 0..N {
                a[(i, j)] -= factor * a[(k, j)];
            }
        }
    }
    a
}
