//! A cloud made ready to be aligned: thinned, searchable, with normals.

use super::closed_form::check_finite;
use super::error::{RegistrationError, Role};
use super::surface::Surface;
use super::voxel::thinned;
use crate::pool::Pool;
use core::num::NonZero;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::SVector;

/// How a cloud is made ready.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preparation {
    /// Edge of the cubes in which points are averaged, see [`thinned`]; 0 keeps all points.
    pub voxel: f64,
    /// The normal at a point is that of its so many nearest neighbours, itself included; 0 makes none, for point to point.
    pub neighbours: usize,
    /// Threads; 0 is one per core. No bit of a result depends on it.
    pub threads: usize,
}

impl Default for Preparation {
    fn default() -> Self {
        Self { voxel: 0.0, neighbours: 10, threads: 0 }
    }
}

/// A cloud of the plane (N = 2) or of space (N = 3), made ready once, and then aligned with as many others as there are.
///
/// ```
/// use boxplus::lie::{LieGroup, SE2};
/// use boxplus::registration::{Icp, Preparation, RegistrationError, Scan};
/// use nalgebra::{Vector2, vector};
/// // Two walls of a room, seen from two places.
/// let wall = |i: i32| if i < 40 { vector![0.1 * f64::from(i), 3.0] } else { vector![4.0, 0.1 * f64::from(i - 40)] };
/// let truth = SE2::new(vector![0.2, -0.1], 0.05);
/// let target: Vec<Vector2<f64>> = (0..70).map(wall).collect();
/// let source: Vec<_> = target.iter().map(|q| truth.inverse() * *q).collect();
/// let [source, target] = [source, target].map(|cloud| Scan::new(&cloud, &Preparation::default()));
/// let found = source?.align(&target?, &SE2::identity(), &Icp::default())?;
/// assert!(found.target_from_source.rminus(&truth).norm() < 1e-3, "{:?}", found.target_from_source);
/// # Ok::<(), RegistrationError>(())
/// ```
#[derive(Debug)]
pub struct Scan<const N: usize> {
    /// The centroid; all else is relative to it, so that no digit is spent on where the world begins.
    pub(super) centre: SVector<f64, N>,
    pub(super) points: Vec<SVector<f64, N>>,
    /// √(Σ|p|²/n): how far a radian moves the points.
    pub(super) radius: f64,
    pub(super) surfaces: Vec<Surface<N>>,
    tree: ImmutableKdTree<f64, N>,
}

/// Points per piece of work; fixed, so that sums do not depend on threads.
pub(super) const CHUNK: usize = 256;

impl<const N: usize> Scan<N> {
    /// Thins, sorts and finds normals.
    ///
    /// # Errors
    /// [`RegistrationError::NotFinite`], [`RegistrationError::VoxelSize`], [`RegistrationError::Empty`],
    /// [`RegistrationError::TooMany`].
    pub fn new(cloud: &[SVector<f64, N>], preparation: &Preparation) -> Result<Self, RegistrationError> {
        check_finite(cloud, Role::Cloud)?;
        let mut points =
            if preparation.voxel == 0.0 { cloud.to_vec() } else { thinned(cloud, preparation.voxel)? };
        if points.is_empty() {
            return Err(RegistrationError::Empty);
        }
        let count = points.len() as f64;
        let centre = points.iter().map(|p| p / count).sum::<SVector<f64, N>>();
        points.iter_mut().for_each(|p| *p -= centre);
        let radius = (points.iter().map(SVector::norm_squared).sum::<f64>() / count).sqrt();
        let places: Vec<[f64; N]> = points.iter().map(|p| (*p).into()).collect();
        let tree = ImmutableKdTree::new_from_slice(&places)
            .map_err(|_| RegistrationError::TooMany { points: places.len() })?;
        let mut scan = Self { centre, points, radius, surfaces: vec![], tree };
        scan.surfaces = scan.surfaces(preparation);
        Ok(scan)
    }

    /// The points after thinning, in the frame of the cloud.
    pub fn points(&self) -> impl ExactSizeIterator<Item = SVector<f64, N>> + '_ {
        self.points.iter().map(|p| p + self.centre)
    }

    /// The unit normal at each point, its sign arbitrary; `None` where the neighbours lie on a line or are not asked for.
    pub fn normals(&self) -> impl ExactSizeIterator<Item = Option<SVector<f64, N>>> + '_ {
        let normal = |i| self.surfaces.get(i).and_then(|surface: &Surface<N>| surface.normal);
        (0..self.points.len()).map(normal)
    }

    /// The median distance from a point to its nearest neighbour, by some of the points; 0 where all coincide, or there is one.
    pub fn spacing(&self) -> f64 {
        let every = self.points.len().div_ceil(CHUNK).max(1);
        let two = NonZero::<usize>::MIN.saturating_add(1);
        let second = |p: &SVector<f64, N>| {
            let found = self.tree.query(&(*p).into()).nearest_n::<SquaredEuclidean<f64>>(two).execute();
            found.last().map_or(0.0, |near| near.distance)
        };
        let mut distances: Vec<f64> = self.points.iter().step_by(every).map(second).collect();
        let middle = distances.len() / 2;
        distances.select_nth_unstable_by(middle, f64::total_cmp).1.sqrt()
    }

    /// `(index, squared distance)` of the point nearest to a place relative to the centroid.
    #[inline]
    pub(super) fn nearest(&self, place: &SVector<f64, N>) -> (usize, f64) {
        let found = self.tree.query(&(*place).into()).nearest_one::<SquaredEuclidean<f64>>().execute();
        (found.item as usize, found.distance)
    }

    fn surfaces(&self, preparation: &Preparation) -> Vec<Surface<N>> {
        let Some(neighbours) = NonZero::new(preparation.neighbours) else { return vec![] };
        let mut surfaces = vec![Surface::none(); self.points.len()];
        let mut chunks: Vec<_> = self.points.chunks(CHUNK).zip(surfaces.chunks_mut(CHUNK)).collect();
        Pool::new(preparation.threads, chunks.len()).for_each(&mut chunks, |_, (points, surfaces)| {
            for (p, surface) in points.iter().zip(surfaces.iter_mut()) {
                let found =
                    self.tree.query(&(*p).into()).nearest_n::<SquaredEuclidean<f64>>(neighbours).execute();
                *surface = Surface::of(found.iter().map(|near| self.points[near.item as usize]));
            }
        });
        surfaces
    }
}
