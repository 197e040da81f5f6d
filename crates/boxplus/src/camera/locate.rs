//! Where a camera is that sees known points, and where a point is that known cameras see.

use super::{Camera, Unseen, View};
use crate::lie::{Action, Manifold, Rn, SE3};
use crate::registration::Pairs;
use crate::uncertainty::{Covariance, Gaussian, UncertaintyError};
use nalgebra::{Matrix3, SMatrix, SVector, SimdComplexField, SimdRealField, Vector2, Vector3, vector};

/// Why images do not tell a place.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LocateError {
    /// Too few points for a pose, or views for a point.
    #[error("{given} given, at least {needed} are needed: four points for a pose, two views for a point")]
    TooFew {
        /// How many were given.
        given: usize,
        /// How many are needed.
        needed: usize,
    },
    /// A standard deviation of pixels that is not positive.
    #[error("a standard deviation must be finite and positive, not {sigma}")]
    NotASigma {
        /// What was given.
        sigma: f64,
    },
    /// The rays to a point are so nearly parallel that its distance is noise.
    #[error(
        "the rays differ by {parallax:.1e} rad at most, less than three standard deviations of a pixel: how far the point is nobody can tell"
    )]
    NoParallax {
        /// The largest angle between two rays, in radians.
        parallax: f64,
    },
    /// No pose of three points fits: they lie on a line, or in no place from which these directions could be theirs.
    #[error("no pose fits these directions: are three points on a line, or the pairs mixed up?")]
    NoPose,
    /// The best place is not before the camera.
    #[error("at the best estimate, {unseen} (observation {index})")]
    Unseen {
        /// Which observation.
        index: usize,
        /// Why it cannot be.
        unseen: Unseen,
    },
    /// A pixel outside the model of the lens.
    #[error("observation {index} is outside of the image that the model of the lens has")]
    NotAnImage {
        /// Which observation.
        index: usize,
    },
    /// The observations leave a direction open.
    #[error(transparent)]
    Uncertainty(#[from] UncertaintyError),
}

/// The poses world_from_camera, at most four, from which three points of the world appear in three unit directions of the camera.
///
/// The distances sᵢ of the points from the camera fulfil sᵢ² + sⱼ² − 2sᵢsⱼcos θᵢⱼ = |pᵢ − pⱼ|². Two of them eliminated, a quartic in
/// v = s₃/s₁ remains: Grunert (1841), in the form of Haralick et al. (1994), eqs. (8), (9). Its roots are polished by Newton's method
/// on the three equations.
///
/// ```
/// use boxplus::camera::poses_of_three;
/// use boxplus::lie::{Action, LieGroup, SE3};
/// use nalgebra::vector;
/// let truth = SE3::exp(&vector![0.3, -0.2, 0.1, 0.2, 0.4, -0.1]);
/// let points = [vector![1.0, 0.5, 5.0], vector![-1.0, 0.2, 6.0], vector![0.3, -1.0, 4.0]];
/// let rays = points.map(|p| truth.act_inverse(&p).normalize());
/// let nearest = poses_of_three(&rays, &points).map(|pose| pose.between(&truth).log().norm()).fold(9.0, f64::min);
/// assert!(nearest < 1e-9);
/// ```
pub fn poses_of_three(
    rays: &[Vector3<f64>; 3],
    points: &[Vector3<f64>; 3],
) -> impl Iterator<Item = SE3> + use<> {
    let [p1, p2, p3] = points;
    let squares = [(p2 - p3).norm_squared(), (p1 - p3).norm_squared(), (p1 - p2).norm_squared()];
    let cosines = [rays[1].dot(&rays[2]), rays[0].dot(&rays[2]), rays[0].dot(&rays[1])];
    let (rays, points) = (*rays, *points);
    distances(squares, cosines).into_iter().flatten().filter_map(move |s| {
        let seen: [Vector3<f64>; 3] = core::array::from_fn(|i| rays[i] * s[i]);
        let pairs = Pairs::new(&seen, &points).ok()?;
        pairs.align::<SE3, 6>().ok().map(|aligned| aligned.target_from_source)
    })
}

/// The distances (s₁, s₂, s₃) that fit: a² = |p₂ − p₃|², b², c² and the cosines of the angles opposite to them.
fn distances([a2, b2, c2]: [f64; 3], [ca, cb, cg]: [f64; 3]) -> [Option<Vector3<f64>>; 4] {
    let (d, s) = ((a2 - c2) / b2, (a2 + c2) / b2);
    let (a, c) = (a2 / b2, c2 / b2);
    let quartic = [
        (1.0 + d) * (1.0 + d) - 4.0 * a * cg * cg,
        4.0 * (-d * (1.0 + d) * cb + 2.0 * a * cg * cg * cb - (1.0 - s) * ca * cg),
        2.0 * (d * d - 1.0 + 2.0 * d * d * cb * cb + 2.0 * (1.0 - c) * ca * ca - 4.0 * s * ca * cb * cg
            + 2.0 * (1.0 - a) * cg * cg),
        4.0 * (d * (1.0 - d) * cb - (1.0 - s) * ca * cg + 2.0 * c * ca * ca * cb),
        (d - 1.0) * (d - 1.0) - 4.0 * c * ca * ca,
    ];
    positive_roots(quartic).map(|v| {
        let v = v?;
        let u = ((d - 1.0) * v * v - 2.0 * d * cb * v + 1.0 + d) / (2.0 * (cg - v * ca));
        let s1 = (b2 / (1.0 + v * v - 2.0 * v * cb)).simd_sqrt();
        polished(vector![s1, u * s1, v * s1], [a2, b2, c2], [ca, cb, cg])
    })
}

/// Newton's method on the three equations; `None` where a distance is not positive or the equations do not hold.
fn polished(mut s: Vector3<f64>, [a2, b2, c2]: [f64; 3], [ca, cb, cg]: [f64; 3]) -> Option<Vector3<f64>> {
    let miss = |s: &Vector3<f64>| {
        vector![
            s.y * s.y + s.z * s.z - 2.0 * s.y * s.z * ca - a2,
            s.x * s.x + s.z * s.z - 2.0 * s.x * s.z * cb - b2,
            s.x * s.x + s.y * s.y - 2.0 * s.x * s.y * cg - c2
        ]
    };
    for _ in 0..10 {
        let j = Matrix3::new(
            0.0,
            s.y - s.z * ca,
            s.z - s.y * ca,
            s.x - s.z * cb,
            0.0,
            s.z - s.x * cb,
            s.x - s.y * cg,
            s.y - s.x * cg,
            0.0,
        ) * 2.0;
        s -= j.lu().solve(&miss(&s))?;
    }
    let fits = miss(&s).amax() <= 1e-9 * (a2 + b2 + c2); // half the digits and some, as where two roots meet
    (fits && s.iter().all(|s| *s > 0.0)).then_some(s)
}

/// The positive real roots of Σ cₖ·xᵏ, between the extrema, which are the roots of the derivative.
fn positive_roots(c: [f64; 5]) -> [Option<f64>; 4] {
    let reach = 1.0 + c[..4].iter().fold(0.0, |most: f64, x| most.max((x / c[4]).abs())); // Cauchy's bound
    let mut knots = [0.0; 6];
    let mut count = 0; // of extrema of the derivative at hand, from the highest derivative down
    for order in (0..4).rev() {
        let degree = 4 - order;
        let at = |x: f64| {
            (0..=degree).rev().fold(0.0, |sum, k| {
                sum * x + c[k + order] * (k + 1..=k + order).map(|i| i as f64).product::<f64>()
            })
        };
        let mut found = [0.0; 6];
        let mut roots = 0;
        for i in 0..=count {
            let low = if i == 0 { 0.0 } else { knots[i - 1] };
            let high = if i == count { reach } else { knots[i] };
            if let Some(root) = bisected(&at, low, high) {
                found[roots] = root;
                roots += 1;
            }
        }
        (knots, count) = (found, roots);
    }
    core::array::from_fn(|i| (i < count).then_some(knots[i]))
}

fn bisected(at: &impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> Option<f64> {
    let rising = at(high) > at(low);
    if !(at(low) * at(high) <= 0.0 && low < high) {
        return None;
    }
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if (at(middle) > 0.0) == rising { high = middle } else { low = middle }
    }
    Some(0.5 * (low + high))
}

/// The pose of a camera, and how sure it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Located<X> {
    /// The place with its covariance: of a pose on the local side, (ρ, φ).
    pub estimate: X,
    /// Root mean square of |r| over the observations, in pixels.
    pub rms: f64,
}

/// The pose of a camera with known intrinsics from points of the world and their pixels, each with standard deviation `sigma`.
///
/// A start is taken from three points at a time, the one that fits all best; then Σ|π(X⁻¹l) − z|² is minimised. The covariance is
/// σ²(JᵀJ)⁻¹, on the local side. No pair may be false: leave out outliers before.
///
/// ```
/// use boxplus::camera::{Camera, Pinhole, locate_camera};
/// use boxplus::lie::{Action, LieGroup, SE3};
/// use nalgebra::vector;
/// let (camera, truth) = (Pinhole::new([500.0; 2], [320.0, 240.0]), SE3::exp(&vector![0.3, -0.2, 0.1, 0.2, 0.4, -0.1]));
/// let points = [[1.0, 0.5, 5.0], [-1.0, 0.2, 6.0], [0.3, -1.0, 4.0], [0.5, 1.0, 7.0]].map(Into::into);
/// let seen = points.map(|l| (l, camera.image(&truth.act_inverse(&l))));
/// let found = locate_camera(&camera, &seen, 0.5)?;
/// assert!(found.estimate.mean().between(&truth).log().norm() < 1e-9 && found.rms < 1e-9);
/// assert!(found.estimate.sigmas()[2] < 0.05); // half a pixel tells the distance to some centimetres
/// # Ok::<(), boxplus::camera::LocateError>(())
/// ```
///
/// # Errors
/// [`LocateError`].
pub fn locate_camera<C: Camera<2, P, Scalar = f64>, const P: usize>(
    camera: &C,
    seen: &[(Vector3<f64>, Vector2<f64>)],
    sigma: f64,
) -> Result<Located<Gaussian<SE3, 6>>, LocateError> {
    check(seen.len(), 4, sigma)?;
    let evaluate = |pose: &SE3| {
        let mut model = Model::default();
        for (l, pixel) in seen {
            let p = pose.act_inverse(l);
            let (image, d_p, _) = camera.image_jac(&p);
            model.add(&(image - pixel), &super::view::through_pose(&d_p, &p, 1.0));
        }
        model
    };
    let start = start(camera, seen, &|pose| evaluate(pose).cost)?;
    let (pose, model) = descend(start, evaluate);
    let unseen = |(index, (l, _)): (usize, &(Vector3<f64>, _))| {
        camera.sees(&pose.act_inverse(l)).err().map(|unseen| LocateError::Unseen { index, unseen })
    };
    if let Some(error) = seen.iter().enumerate().find_map(unseen) {
        return Err(error);
    }
    let covariance = Covariance::from_information(&(model.hessian / (sigma * sigma)))?;
    Ok(Located { estimate: Gaussian::new(pose, covariance), rms: model.rms(seen.len()) })
}

/// The pose of three points that costs least over all.
fn start<C: Camera<2, P, Scalar = f64>, const P: usize>(
    camera: &C,
    seen: &[(Vector3<f64>, Vector2<f64>)],
    cost: &impl Fn(&SE3) -> f64,
) -> Result<SE3, LocateError> {
    let third = seen.len() / 3; // rounded down, so that the three are never the same
    let mut best: Option<(f64, SE3)> = None;
    for i in 0..seen.len().min(8) {
        let chosen = [i, (i + third) % seen.len(), (i + 2 * third) % seen.len()];
        let points = chosen.map(|k| seen[k].0);
        let mut rays = [Vector3::zeros(); 3];
        for (ray, index) in rays.iter_mut().zip(chosen) {
            *ray = camera.unproject(&seen[index].1).map_err(|_| LocateError::NotAnImage { index })?;
        }
        for pose in poses_of_three(&rays, &points) {
            let cost = cost(&pose);
            if cost.is_finite() && best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, pose));
            }
        }
    }
    best.map(|(_, pose)| pose).ok_or(LocateError::NoPose)
}

/// The place of a point that views of known pose and intrinsics see at pixels of standard deviation `sigma`, and its covariance.
///
/// The start is the point nearest to all rays, Σ|(I − ddᵀ)(l − c)|² → min; then Σ|π(X⁻¹l) − z|² is minimised. Rays that differ by less
/// than three standard deviations of a pixel are refused: the covariance would be that of a place, while the truth may be at infinity.
///
/// ```
/// use boxplus::camera::{LocateError, Pinhole, View, locate_point};
/// use boxplus::lie::{LieGroup, SE3, SO3};
/// use nalgebra::vector;
/// let at = |x: f64| -> View<Pinhole, 9, 15> {
///     View { world_from_camera: SE3::new(SO3::identity(), vector![x, 0.0, 0.0]), camera: Pinhole::new([500.0; 2], [0.0; 2]) }
/// };
/// let point = vector![0.5, 0.2, 4.0];
/// let seen = [at(0.0), at(1.0)].map(|view| (view, view.image(&point)));
/// let found = locate_point(&seen, 0.5)?;
/// assert!((found.estimate.mean().vector() - point).norm() < 1e-9);
/// let refused = locate_point(&[at(0.0), at(0.001)].map(|view| (view, view.image(&point))), 0.5);
/// assert!(matches!(refused, Err(LocateError::NoParallax { .. })));
/// # Ok::<(), LocateError>(())
/// ```
///
/// # Errors
/// [`LocateError`].
pub fn locate_point<C: Camera<2, P, Scalar = f64>, const P: usize, const D: usize>(
    seen: &[(View<C, P, D>, Vector2<f64>)],
    sigma: f64,
) -> Result<Located<Gaussian<Rn<3>, 3>>, LocateError> {
    check(seen.len(), 2, sigma)?;
    let start = nearest_to_rays(seen, sigma)?;
    let evaluate = |l: &Rn<3>| {
        let mut model = Model::default();
        for (view, pixel) in seen {
            let (image, _, d_l) = view.image_jac(&l.vector());
            model.add(&(image - pixel), &d_l);
        }
        model
    };
    let (point, model) = descend(Rn::new(start), evaluate);
    for (index, (view, _)) in seen.iter().enumerate() {
        view.sees(&point.vector()).map_err(|unseen| LocateError::Unseen { index, unseen })?;
    }
    let covariance = Covariance::from_information(&(model.hessian / (sigma * sigma)))?;
    Ok(Located { estimate: Gaussian::new(point, covariance), rms: model.rms(seen.len()) })
}

/// The point nearest to the rays of all pixels, which must differ.
fn nearest_to_rays<C: Camera<2, P, Scalar = f64>, const P: usize, const D: usize>(
    seen: &[(View<C, P, D>, Vector2<f64>)],
    sigma: f64,
) -> Result<Vector3<f64>, LocateError> {
    let ray = |index: usize| -> Result<_, LocateError> {
        let (view, pixel) = &seen[index];
        let own = view.camera.unproject(pixel).map_err(|_| LocateError::NotAnImage { index })?;
        Ok(view.world_from_camera.act_direction(&own))
    };
    let (first, mut parallax) = (ray(0)?, 0.0_f64);
    let (mut sum, mut right) = (Matrix3::zeros(), Vector3::zeros());
    let mut pixel_angle = 0.0_f64;
    for (index, (view, _)) in seen.iter().enumerate() {
        let d = ray(index)?;
        let across = Matrix3::identity() - d * d.transpose();
        sum += across;
        right += across * view.world_from_camera.translation();
        parallax = parallax.max(d.cross(&first).norm().simd_atan2(d.dot(&first)));
        // Pixels a radian: the larger singular value of the image by the direction.
        let (_, d_p, _) = view.camera.image_jac(&view.world_from_camera.rotation().act_inverse(&d));
        pixel_angle = pixel_angle.max(sigma / d_p.norm().max(f64::MIN_POSITIVE));
    }
    if parallax < 3.0 * pixel_angle {
        return Err(LocateError::NoParallax { parallax });
    }
    sum.lu().solve(&right).ok_or(LocateError::NoParallax { parallax })
}

fn check(given: usize, needed: usize, sigma: f64) -> Result<(), LocateError> {
    if given < needed {
        Err(LocateError::TooFew { given, needed })
    } else if sigma > 0.0 && sigma.is_finite() {
        Ok(())
    } else {
        Err(LocateError::NotASigma { sigma })
    }
}

/// Normal equations of a few unknowns.
struct Model<const D: usize> {
    cost: f64,
    hessian: SMatrix<f64, D, D>,
    gradient: SVector<f64, D>,
}

impl<const D: usize> Default for Model<D> {
    fn default() -> Self {
        Self { cost: 0.0, hessian: SMatrix::zeros(), gradient: SVector::zeros() }
    }
}

impl<const D: usize> Model<D> {
    fn add(&mut self, r: &Vector2<f64>, j: &SMatrix<f64, 2, D>) {
        self.cost += r.norm_squared();
        self.hessian += j.transpose() * j;
        self.gradient += j.transpose() * r;
    }

    fn rms(&self, count: usize) -> f64 {
        (self.cost / count as f64).simd_sqrt()
    }
}

/// Levenberg's and Marquardt's method for one element.
fn descend<X: Manifold<D, Scalar = f64>, const D: usize>(
    start: X,
    evaluate: impl Fn(&X) -> Model<D>,
) -> (X, Model<D>) {
    let (mut x, mut model, mut damping) = (start, evaluate(&start), 1e-6);
    for _ in 0..100 {
        let mut damped = model.hessian;
        (0..D).for_each(|i| damped[(i, i)] *= 1.0 + damping);
        let solved = damped.cholesky().map(|factor| factor.solve(&-model.gradient));
        let step: SVector<f64, D> = solved.unwrap_or_else(SVector::zeros);
        let trial = x.plus(&step);
        let there = evaluate(&trial);
        if there.cost < model.cost {
            let settled = model.cost - there.cost <= 1e-14 * model.cost;
            (x, model, damping) = (trial, there, damping * 0.1);
            if settled {
                break;
            }
        } else if damping > 1e8 || step.amax() == 0.0 {
            break;
        } else {
            damping *= 10.0;
        }
    }
    (x, model)
}
