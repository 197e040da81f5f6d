//! Where a landmark stands, told by poses that are known: seen at a place, at a distance, in a direction.
//!
//! ```text
//! place      x = X·z                               one is enough
//! distance   ‖x − o‖ = z                           two meet in mirror images, more tell which is the landmark
//! direction  (x − o)/‖x − o‖ = u                   two cross
//! ```
//! Squares of distances differ by what is linear in x: x is found along the directions in which the poses o spread, and its
//! height h over them from ‖x − o‖² up to its sign. Both signs are kept and refined on the residuals themselves; the
//! cheaper one is the landmark, once it is cheaper by more than noise.

use nalgebra::{DMatrix, SMatrix, SVector, SymmetricEigen};

use super::edges::Pose;
use crate::graph::set::{AnySet, FactorSet};
use crate::graph::{Bearing2, Bearing3, Factor, Key, MAX_ARITY, Range, Sighting2, Sighting3, Values};
use crate::lie::{Action, Rn, SE2, SE3};

/// The larger share of the distance to a landmark that its standard deviation may be: beyond, no Gaussian describes it.
const SURE: f64 = 0.2;
/// By how many standard deviations the mirror image must be worse: no chance in four hundred for the wrong one.
const APART: f64 = 3.0;
/// From here on, in standard deviations, a measurement pulls no harder.
const HUBER: f64 = 3.0;
/// Steps of the refinement; each gains a digit or more.
const REFINE: usize = 20;

/// What a pose says of a point, in its own frame.
#[derive(Clone, Copy, Debug)]
enum Seen<const N: usize> {
    Place(SVector<f64, N>),
    Distance(f64),
    Direction(SVector<f64, N>),
}

/// A measurement of one point from one pose, by their slots.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight<const N: usize> {
    pose: u32,
    pub(super) point: u32,
    seen: Seen<N>,
    /// In metres; of a direction in radians.
    sigma: f64,
}

impl<const N: usize> Sight<N> {
    /// Whether it leaves more than one place to its point.
    pub(super) fn is_partial(&self) -> bool {
        !matches!(self.seen, Seen::Place(_))
    }
}

/// A landmark found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found<const N: usize> {
    pub(super) place: SVector<f64, N>,
    /// Whether noise cannot have put it elsewhere.
    pub(super) sure: bool,
    /// The next best place: where the landmark could be instead.
    pub(super) rival: Option<SVector<f64, N>>,
}

/// Poses that see points of ℝᴺ.
pub(super) trait Observer<const N: usize, const D: usize>: Pose<N, D> {
    /// All their measurements of points: of one point together, in the order in which they were added.
    fn sights(sets: &[Box<dyn AnySet>]) -> Vec<Sight<N>>;
}

impl Observer<2, 3> for SE2 {
    fn sights(sets: &[Box<dyn AnySet>]) -> Vec<Sight<2>> {
        let mut sights = of::<Sighting2, 2, 2>(sets, [0, 1], |f| Seen::Place(f.measured));
        sights.extend(ranges::<Self, 2, 3>(sets));
        sights.extend(of::<Bearing2, 1, 2>(sets, [0, 1], |f| Seen::Direction(f.direction())));
        by_point(sights)
    }
}

impl Observer<3, 6> for SE3 {
    fn sights(sets: &[Box<dyn AnySet>]) -> Vec<Sight<3>> {
        let place = |f: &Sighting3| Seen::Place(f.pose_from_sensor.act(&f.measured));
        let mut sights = of::<Sighting3, 3, 3>(sets, [0, 1], place);
        sights.extend(ranges::<Self, 3, 6>(sets));
        sights.extend(of::<Bearing3, 2, 3>(sets, [0, 1], |f| Seen::Direction(f.direction())));
        by_point(sights)
    }
}

fn ranges<P: Observer<N, D>, const N: usize, const D: usize>(sets: &[Box<dyn AnySet>]) -> Vec<Sight<N>>
where
    Range<P, Rn<N>, N>: Factor<1>,
    Range<Rn<N>, P, N>: Factor<1>,
{
    let mut sights = of::<Range<P, Rn<N>, N>, 1, N>(sets, [0, 1], |f| Seen::Distance(f.measured));
    sights.extend(of::<Range<Rn<N>, P, N>, 1, N>(sets, [1, 0], |f| Seen::Distance(f.measured)));
    sights
}

/// The measurements that factors of one type make, with the places of pose and point among their variables.
fn of<F: Factor<R>, const R: usize, const N: usize>(
    sets: &[Box<dyn AnySet>],
    [pose, point]: [usize; 2],
    seen: impl Fn(&F) -> Seen<N>,
) -> Vec<Sight<N>> {
    let sets = sets.iter().filter_map(|set| set.as_any().downcast_ref::<FactorSet<F, R>>());
    let factors = sets.flat_map(|set| set.slots.iter().zip(&set.factors).zip(&set.noises));
    let sight = |((slots, factor), noise): ((&[u32; MAX_ARITY], &F), &crate::graph::Noise<R>)| Sight {
        pose: slots[pose],
        point: slots[point],
        seen: seen(factor),
        sigma: (R as f64 / noise.information().trace()).sqrt(),
    };
    factors.map(sight).collect()
}

fn by_point<const N: usize>(mut sights: Vec<Sight<N>>) -> Vec<Sight<N>> {
    sights.sort_by_key(|sight| sight.point); // stable
    sights
}

/// A measurement from a pose that is known: where that stands, and what it says, both in the world.
#[derive(Clone, Copy, Debug)]
struct Known<const N: usize> {
    origin: SVector<f64, N>,
    seen: Seen<N>,
    sigma: f64,
}

impl<const N: usize> Known<N> {
    /// The whitened residual and its derivative; of a distance along the ray.
    fn residual(&self, x: &SVector<f64, N>) -> (SVector<f64, N>, SMatrix<f64, N, N>) {
        let ray = x - self.origin;
        let distance = ray.norm();
        let u = if distance > 0.0 { ray / distance } else { SVector::zeros() };
        let (r, jacobian) = match self.seen {
            Seen::Place(place) => (x - place, SMatrix::identity()),
            Seen::Distance(z) => (u * (distance - z), u * u.transpose()),
            // |u − z| is the angle between them for small ones, and has no second zero behind the pose.
            Seen::Direction(z) => {
                (u - z, (SMatrix::identity() - u * u.transpose()) / distance.max(f64::MIN_POSITIVE))
            }
        };
        (r / self.sigma, jacobian / self.sigma)
    }
}

/// The landmark of `sights`, all of one point, from those poses that are known; `None` where they do not tell any place.
pub(super) fn locate<P: Pose<N, D>, const N: usize, const D: usize>(
    sights: &[Sight<N>],
    values: &Values,
    is_known: impl Fn(u32) -> bool,
) -> Option<Found<N>> {
    let known: Vec<Known<N>> = sights
        .iter()
        .filter(|sight| is_known(sight.pose))
        .filter_map(|sight| {
            let (rotation, origin) = values.get(Key::<P>::new(sight.pose))?.parts();
            let seen = match sight.seen {
                Seen::Place(z) => Seen::Place(rotation * z + origin),
                Seen::Direction(z) => Seen::Direction(rotation * z),
                distance @ Seen::Distance(_) => distance,
            };
            Some(Known { origin, seen, sigma: sight.sigma })
        })
        .collect();
    let first = known.iter().find_map(|k| if let Seen::Place(place) = k.seen { Some(place) } else { None });
    if let Some(place) = first {
        return Some(Found { place, sure: true, rival: None });
    }
    choose(&known, &candidates(&known))
}

/// The best of the candidates, refined.
fn choose<const N: usize>(known: &[Known<N>], candidates: &[SVector<f64, N>]) -> Option<Found<N>> {
    let mut refined: Vec<_> = candidates.iter().map(|x| refine(known, x)).collect();
    refined.retain(|(x, cost)| cost.is_finite() && x.iter().all(|x| x.is_finite()));
    refined.sort_by(|a, b| a.1.total_cmp(&b.1));
    let &(place, cost) = refined.first()?;
    let spread = spread(known, &place);
    let distance = known.iter().map(|k| (place - k.origin).norm()).sum::<f64>() / known.len() as f64;
    // Where the fit is worse than stated, so is everything told from it.
    let excess = (2.0 * cost / known.len().saturating_sub(N).max(1) as f64).max(1.0);
    let apart = |(x, _): &&(SVector<f64, N>, f64)| (x - place).norm() > APART * spread.min(distance);
    let rival = refined.iter().find(apart);
    let ruled_out = |(_, other): &(SVector<f64, N>, f64)| 2.0 * (other - cost) > APART.powi(2) * excess;
    let sure = spread * excess.sqrt() < SURE * distance && rival.is_none_or(ruled_out);
    Some(Found { place, sure, rival: rival.map(|rival| rival.0) })
}

/// Places where the landmark may be, before any refinement.
fn candidates<const N: usize>(known: &[Known<N>]) -> Vec<SVector<f64, N>> {
    let (mut spheres, mut rays, mut polar) = (vec![], vec![], vec![]);
    for k in known {
        match k.seen {
            Seen::Distance(z) => spheres.push((k.origin, z)),
            Seen::Direction(u) => rays.push((k.origin, u)),
            Seen::Place(_) => {}
        }
    }
    // A distance and a direction from one pose are a place.
    for (origin, u) in &rays {
        polar.extend(spheres.iter().filter(|(o, _)| o == origin).map(|(_, z)| origin + u * *z));
    }
    polar.truncate(1);
    polar.extend(crossing(&rays));
    polar.extend(mirror_images(&spheres).into_iter().flatten());
    if polar.is_empty() {
        // Not determined; but the optimiser is to say so, and needs some value.
        polar.extend(rays.first().map(|(origin, u)| origin + u));
    }
    polar
}

/// The point nearest to all lines o + su.
fn crossing<const N: usize>(rays: &[(SVector<f64, N>, SVector<f64, N>)]) -> Option<SVector<f64, N>> {
    let (mut a, mut b) = (SMatrix::<f64, N, N>::zeros(), SVector::<f64, N>::zeros());
    for (origin, u) in rays {
        let across = SMatrix::identity() - u * u.transpose();
        a += across;
        b += across * origin;
    }
    solve(&a, &b).filter(|_| rays.len() > 1)
}

/// The two points at distances z from the points o, one on each side of the flat in which these spread most.
fn mirror_images<const N: usize>(spheres: &[(SVector<f64, N>, f64)]) -> Option<[SVector<f64, N>; 2]> {
    if spheres.is_empty() {
        return None;
    }
    let count = spheres.len() as f64;
    let centre = spheres.iter().map(|(o, _)| o).sum::<SVector<f64, N>>() / count;
    let mean = spheres.iter().map(|(o, z)| z * z - (o - centre).norm_squared()).sum::<f64>() / count;
    // With y = x − c and o measured from c: 2oᵀy = (mean of z² − o²) − (z² − o²), whose mean is 0 on both sides.
    let (mut a, mut b) = (SMatrix::<f64, N, N>::zeros(), SVector::<f64, N>::zeros());
    for (o, z) in spheres {
        let o = o - centre;
        a += o * o.transpose();
        b += o * ((mean - (z * z - o.norm_squared())) * 0.5);
    }
    let eigen = SymmetricEigen::new(DMatrix::from_column_slice(N, N, a.as_slice()));
    let flattest = eigen.eigenvalues.imin();
    let direction = |i: usize| SVector::<f64, N>::from_column_slice(eigen.eigenvectors.column(i).as_slice());
    let mut y = SVector::<f64, N>::zeros();
    let resolved = eigen.eigenvalues.max() * f64::EPSILON.sqrt();
    for i in (0..N).filter(|&i| i != flattest && eigen.eigenvalues[i] > resolved) {
        y += direction(i) * (direction(i).dot(&b) / eigen.eigenvalues[i]);
    }
    let height = (mean - y.norm_squared()).max(0.0).sqrt();
    let up = direction(flattest) * height;
    y.iter().all(|y| y.is_finite()).then(|| [centre + y + up, centre + y - up])
}

/// Damped Gauss–Newton steps with Huber's kernel; the place and its cost.
fn refine<const N: usize>(known: &[Known<N>], start: &SVector<f64, N>) -> (SVector<f64, N>, f64) {
    let (mut x, mut damping) = (*start, 1e-3);
    let (mut cost, mut hessian, mut gradient) = normal_equations(known, &x);
    for _ in 0..REFINE {
        let damped = hessian + SMatrix::from_diagonal(&(hessian.diagonal() * damping));
        let Some(step) = solve(&damped, &gradient) else { break };
        let trial = normal_equations(known, &(x - step));
        if trial.0 < cost {
            x -= step;
            damping *= 0.1;
            (cost, hessian, gradient) = trial;
        } else {
            damping *= 10.0;
        }
    }
    (x, cost)
}

/// Cost, JᵀJ and Jᵀr.
fn normal_equations<const N: usize>(
    known: &[Known<N>],
    x: &SVector<f64, N>,
) -> (f64, SMatrix<f64, N, N>, SVector<f64, N>) {
    let mut sum = (0.0, SMatrix::zeros(), SVector::zeros());
    for k in known {
        let (r, jacobian) = k.residual(x);
        let (rho, weight) = crate::graph::Kernel::Huber(HUBER).evaluate(r.norm_squared());
        sum.0 += 0.5 * rho;
        sum.1 += jacobian.transpose() * jacobian * weight;
        sum.2 += jacobian.transpose() * r * weight;
    }
    sum
}

/// The standard deviation of the place along its least certain direction, infinite where it is free.
fn spread<const N: usize>(known: &[Known<N>], x: &SVector<f64, N>) -> f64 {
    let (_, hessian, _) = normal_equations(known, x);
    let dynamic = DMatrix::from_column_slice(N, N, hessian.as_slice());
    dynamic.symmetric_eigenvalues().min().max(0.0).sqrt().recip()
}

fn solve<const N: usize>(a: &SMatrix<f64, N, N>, b: &SVector<f64, N>) -> Option<SVector<f64, N>> {
    let solved = a.cholesky()?.solve(b);
    solved.iter().all(|x| x.is_finite()).then_some(solved)
}
