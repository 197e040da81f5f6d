//! Which directions the matched surfaces see.

use super::closed_form::Alignable;
use super::matching::{Matching, Model};
use crate::lie::{Jacobian, Tangent};
use crate::uncertainty::Covariance;
use core::fmt;
use nalgebra::{SMatrix, SVector};

/// A surface that sees a direction at less than sin 17° may owe it to the error of its normal.
const GRAZING: f64 = 0.3;

/// A direction about which the matched surfaces say nothing, such as that along a corridor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Free<const D: usize> {
    /// The direction as a local tangent of the result, at the origin of the source: (ρ, θ).
    pub tangent: Tangent<f64, D>,
    /// The same at the centroid of the source: a pure translation has no rotation there.
    pub about_centroid: Tangent<f64, D>,
    /// The part of the matches that see it, from 0 to 1.
    pub share: f64,
    /// Root of the mean squared distance of the source points from their centroid: what a radian moves them.
    radius: f64,
    dimension: usize,
}

impl<const D: usize> fmt::Display for Free<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (rho, theta) = self.about_centroid.as_slice().split_at(self.dimension);
        let size = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let (sliding, turning) = (size(rho), size(theta) * self.radius);
        let unit = |x: &[f64]| super::Axis::new(&x.iter().map(|y| y / size(x)).collect::<Vec<_>>());
        match (sliding >= turning, theta.len()) {
            (true, _) => write!(f, "translation along {}", unit(rho)),
            (false, 1) => f.write_str("rotation"),
            (false, _) => write!(f, "rotation about {}", unit(theta)),
        }
    }
}

/// The quadratic model in coordinates that all are lengths, without what no surface sees.
pub(super) struct Spectrum<const D: usize> {
    /// What a unit of each coordinate of the tangent moves the points: 1 and the radius.
    scales: Tangent<f64, D>,
    /// Eigenvalues of the scaled H where it is seen, in descending order, and their unit directions.
    curvatures: Tangent<f64, D>,
    directions: Jacobian<f64, D>,
    /// Smaller curvatures are lost in the rounding of D terms.
    least: f64,
    /// What is not seen, as unit vectors in the scaled coordinates, and the part of the matches that see each.
    free: Vec<(Tangent<f64, D>, f64)>,
}

impl<const D: usize> Spectrum<D> {
    /// `least` is the share below which a direction is free.
    pub(super) fn of<G: Alignable<D, N>, const N: usize>(
        x: &G,
        model: &Model<D>,
        matching: &Matching<'_, N, D>,
        least: f64,
    ) -> Self {
        let radius = matching.radius();
        let scales = Tangent::<f64, D>::from_fn(|i, _| if i < N { 1.0 } else { radius });
        let sample = Sample::new(x, matching, &scales);
        let mut free = canonical(&sample.free(least));
        let scaled = SMatrix::from_fn(|i, j| model.hessian[(i, j)] / (scales[i] * scales[j]));
        let seen = projector(&free);
        let (curvatures, directions) = principal(&(seen * scaled * seen));
        let least = 16.0 * f64::EPSILON * curvatures[0];
        // Normals tell no rotation of points about the line they lie on; nothing does.
        let flat: Vec<_> =
            (0..D).filter(|&k| curvatures[k] <= least).map(|k| directions.column(k).into_owned()).collect();
        if flat.len() > free.len() {
            free = canonical(&flat);
        }
        let share = |v: &Tangent<f64, D>| if v.dot(&(scaled * v)) > least { sample.share(v) } else { 0.0 };
        let free = free.into_iter().map(|v| (v, share(&v))).collect();
        Self { scales, curvatures, directions, least, free }
    }

    /// Directions along which the model is curved; the others are free.
    fn seen(&self) -> impl Iterator<Item = (SVector<f64, D>, f64)> + '_ {
        let all = (0..D).map(|k| (self.directions.column(k).into_owned(), self.curvatures[k]));
        all.filter(|(_, curvature)| *curvature > self.least)
    }

    /// The step that minimises the model along the directions seen, damped by a part of each curvature, and how far it moves
    /// the points.
    pub(super) fn step(&self, gradient: &Tangent<f64, D>, damping: f64) -> (Tangent<f64, D>, f64) {
        let scaled = gradient.component_div(&self.scales);
        let step = self.seen().fold(Tangent::<f64, D>::zeros(), |sum, (direction, curvature)| {
            sum + direction * (direction.dot(&scaled) / (curvature * (1.0 + damping)))
        });
        (step.component_div(&self.scales), step.norm())
    }

    /// H without what is not seen.
    pub(super) fn information(&self) -> Jacobian<f64, D> {
        let scaled = self.seen().fold(Jacobian::<f64, D>::zeros(), |sum, (direction, curvature)| {
            sum + direction * direction.transpose() * curvature
        });
        SMatrix::from_fn(|i, j| scaled[(i, j)] * self.scales[i] * self.scales[j])
    }

    /// What is not seen; `centre` is the centroid of the source in its own frame.
    pub(super) fn free<G: Alignable<D, N>, const N: usize>(&self, centre: &SVector<f64, N>) -> Vec<Free<D>> {
        let outward = G::translation_by(centre).adjoint();
        let told = |(direction, share): &(Tangent<f64, D>, f64)| {
            let about_centroid = direction.component_div(&self.scales);
            let (tangent, radius) = (outward * about_centroid, self.scales[D - 1]);
            Free { tangent, about_centroid, share: *share, radius, dimension: N }
        };
        self.free.iter().map(told).collect()
    }
}

/// How matched surfaces see motions, by some of the matches.
struct Sample<const D: usize, const N: usize> {
    /// ∂(X·p)/∂τ in the scaled coordinates and the normal n there, both in the frame of the source.
    seen: Vec<(SMatrix<f64, N, D>, SVector<f64, N>)>,
    /// Matches without normal are points, and see everything.
    points: usize,
}

/// So many matches tell a share of a hundredth to a third of itself.
const SAMPLE: usize = 1024;

impl<const D: usize, const N: usize> Sample<D, N> {
    fn new<G: Alignable<D, N>>(x: &G, matching: &Matching<'_, N, D>, scales: &Tangent<f64, D>) -> Self {
        let back = x.linear_part().transpose();
        let mut sample = Self { seen: Vec::with_capacity(SAMPLE), points: 0 };
        for m in matching.each().step_by(matching.count().div_ceil(SAMPLE).max(1)) {
            let mut velocity = G::generators_at(&m.p);
            velocity.column_iter_mut().zip(scales).for_each(|(mut column, scale)| column /= *scale);
            match m.normal {
                Some(normal) => sample.seen.push((velocity, back * normal)),
                None => sample.points += 1,
            }
        }
        sample
    }

    /// Σ(nᵀv)²/Σ|v|² over the velocities v of a motion, leaving out what is seen at a grazing angle.
    fn share(&self, direction: &Tangent<f64, D>) -> f64 {
        let (mut seen, mut all) = (0.0, 0.0);
        for (velocity, normal) in &self.seen {
            let v = velocity * direction;
            let (across, size) = (normal.dot(&v).powi(2), v.norm_squared());
            all += size;
            seen += if across > GRAZING * GRAZING * size { across } else { 0.0 };
        }
        let points = self.points as f64 / (self.seen.len() + self.points).max(1) as f64;
        points + if all > 0.0 { (1.0 - points) * seen / all } else { 0.0 }
    }

    /// The principal motions of the normals that are seen by less than `least`.
    fn free(&self, least: f64) -> Vec<Tangent<f64, D>> {
        let rows = self.seen.iter().map(|(velocity, normal)| velocity.tr_mul(normal));
        let (_, directions) =
            principal(&rows.fold(Jacobian::<f64, D>::zeros(), |sum, a| sum + a * a.transpose()));
        let all = (0..D).map(|k| directions.column(k).into_owned());
        all.filter(|v| self.share(v) < least).collect()
    }
}

/// Eigenvalues in descending order and eigenvectors.
fn principal<const D: usize>(a: &Jacobian<f64, D>) -> (Tangent<f64, D>, Jacobian<f64, D>) {
    Covariance::by_construction(*a).principal_axes()
}

/// I − Σvvᵀ for orthonormal v.
fn projector<const D: usize>(basis: &[Tangent<f64, D>]) -> Jacobian<f64, D> {
    basis.iter().fold(SMatrix::identity(), |rest, v| rest - v * v.transpose())
}

/// An orthonormal basis of the same space, of vectors as near to coordinate axes as there are: whatever basis a multiple
/// eigenvalue has, people read translations and rotations.
fn canonical<const D: usize>(basis: &[Tangent<f64, D>]) -> Vec<Tangent<f64, D>> {
    let mut rest = SMatrix::identity() - projector(basis);
    let mut nearest = || {
        // Of equals the first.
        let i = (0..D).fold(0, |best, i| if rest[(i, i)] > rest[(best, best)] + 1e-9 { i } else { best });
        let v = rest.column(i).normalize();
        rest -= v * v.transpose();
        v
    };
    basis.iter().map(|_| nearest()).collect()
}
