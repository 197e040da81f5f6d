//! Iterated closest points.

use super::closed_form::{Alignable, LARGEST, Rigid};
use super::error::{RegistrationError, Role};
use super::matching::{Matching, Model};
use super::observed::{Free, Spectrum};
use super::scan::Scan;
use crate::lie::{Jacobian, LieGroup};
use crate::robust::Kernel;
use crate::uncertainty::{Covariance, Gaussian};
use core::str::FromStr;
use nalgebra::SVector;

/// What is minimised; the formulas are in the [module](super).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Method {
    /// Distances of points.
    PointToPoint,
    /// Distances from the planes of the target.
    PointToPlane,
    /// Distances weighed by the planes of both.
    #[default]
    Generalised,
}

impl Method {
    /// Every method.
    pub const ALL: [Self; 3] = [Self::PointToPoint, Self::PointToPlane, Self::Generalised];

    /// Its name, as [`FromStr`] takes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::PointToPoint => "point",
            Self::PointToPlane => "plane",
            Self::Generalised => "generalised",
        }
    }
}

/// A name that is none of [`Method::ALL`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not a method of alignment; choose point, plane or generalised")]
pub struct UnknownMethod;

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, UnknownMethod> {
        Self::ALL.into_iter().find(|method| method.name() == name).ok_or(UnknownMethod)
    }
}

/// How scans are aligned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Icp {
    /// What is minimised.
    pub method: Method,
    /// A point and its nearest neighbour are a match if |q − X·p| ≤ `max_distance`, in the units of the cloud.
    pub max_distance: f64,
    /// Robust kernel over the matches; its scale is in standard deviations.
    pub kernel: Kernel,
    /// The standard deviation of a residual, by which the kernel judges; `None` takes it from the median of the residuals, anew
    /// in every iteration.
    pub noise: Option<f64>,
    /// Stop after so many steps.
    pub max_iterations: usize,
    /// Stop when a step moves the points by less than `tolerance`·`max_distance`, as a root mean square.
    pub tolerance: f64,
    /// A direction is free when the matches that see it, at more than 17°, are less than this part of all.
    pub least_share: f64,
    /// Threads; 0 is one per core. No bit of the result depends on it.
    pub threads: usize,
}

impl Default for Icp {
    fn default() -> Self {
        Self {
            method: Method::default(),
            max_distance: 1.0,
            kernel: Kernel::None,
            noise: None,
            max_iterations: 50,
            tolerance: 1e-4,
            least_share: 0.01,
            threads: 0,
        }
    }
}

/// Why an alignment stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Termination {
    /// The steps have become small.
    Converged,
    /// No step lowers the cost any more, to rounding.
    Stalled,
    /// After [`Icp::max_iterations`].
    MaxIterations,
}

/// Where a scan was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Registered<G, const D: usize> {
    /// X, which takes points of the source to where the target has them.
    pub target_from_source: G,
    /// Σ⁻¹ of the local tangent at X: H/σ², without what [`Registered::free`] names.
    pub information: Jacobian<f64, D>,
    /// σ, the standard deviation of the residuals that are minimised, √(Σw·rᵀWr/(nK − D)), with K = 1, but for point to point the
    /// dimension of the points. At least ε times the extent of the source, to which a perfect fit is known.
    pub sigma: f64,
    /// Directions about which the surfaces say nothing. The start is kept along them.
    pub free: Vec<Free<D>>,
    /// Points of the source, after thinning.
    pub points: usize,
    /// How many of them have a partner.
    pub matches: usize,
    /// √(Σ|q − X·p|²/n) over the matches, in the units of the cloud.
    pub rmse: f64,
    /// Number of steps.
    pub iterations: usize,
    /// Why it stopped.
    pub termination: Termination,
    covariance: Option<Covariance<D>>,
}

impl<G: LieGroup<D, Scalar = f64>, const D: usize> Registered<G, D> {
    /// The part of the source points that have a partner, from 0 to 1.
    pub fn fitness(&self) -> f64 {
        self.matches as f64 / self.points as f64
    }

    /// X with the covariance of its local tangent, H⁻¹σ².
    ///
    /// Errors of the matches count as independent, which they are not: neighbours share normals and partners. In a simulated room with
    /// independent noise of every point (a test of the library) true errors were larger than this σ by a factor of √20 point to
    /// point, √3.5 point to plane, √2 generalised; on real surfaces and with moving things they can be larger still.
    ///
    /// # Errors
    /// [`RegistrationError::Unconstrained`] where a direction is free; [`Registered::information`] has the others.
    pub fn pose(&self) -> Result<Gaussian<G, D>, RegistrationError> {
        match self.covariance {
            Some(covariance) if self.free.is_empty() => {
                Ok(Gaussian::new(self.target_from_source, covariance))
            }
            _ => Err(RegistrationError::Unconstrained { directions: self.free.len() }),
        }
    }
}

/// Damping after the first step that would raise the cost, and how it grows.
const DAMPING: (f64, f64) = (1e-3, 10.0);
/// Damped so much, a step is lost in rounding.
const MOST_DAMPING: f64 = 1e9;

impl<const N: usize> Scan<N> {
    /// Finds where this scan, the source, lies in another, the target: SE(2) in the plane, SE(3) in space.
    ///
    /// Each iteration pairs the points anew and takes the Gauss–Newton step, with the exact Jacobian ∂(X·p)/∂X, damped as
    /// Levenberg and Marquardt do where the step would raise the cost of these pairs. The metric of a match is held
    /// during a step. Directions that no surface sees are left out of the step.
    ///
    /// # Errors
    /// [`RegistrationError::NotAnOption`], [`RegistrationError::NotAKernel`], [`RegistrationError::NoNormals`],
    /// [`RegistrationError::NoOverlap`], [`RegistrationError::InitialNotFinite`]. Not converging is no error, see
    /// [`Registered::termination`].
    pub fn align<G: Rigid<D, N>, const D: usize>(
        &self,
        target: &Self,
        initial: &G,
        options: &Icp,
    ) -> Result<Registered<G, D>, RegistrationError> {
        options.check(self, target)?;
        let between = between_centres(initial, &self.centre, &target.centre);
        if !between.act(&SVector::zeros()).iter().all(|x| x.abs() <= LARGEST) {
            return Err(RegistrationError::InitialNotFinite);
        }
        let mut search = Search { matching: Matching::new(self, target, options), options, x: between };
        let (termination, iterations) = search.run()?;
        let (model, spectrum) = search.look()?;
        Ok(search.registered(self, target, (&model, &spectrum), (termination, iterations)))
    }
}

/// X between the centroids: what it says of points relative to them.
fn between_centres<G: Alignable<D, N>, const D: usize, const N: usize>(
    x: &G,
    source: &SVector<f64, N>,
    target: &SVector<f64, N>,
) -> G {
    G::translation_by(target).between(&x.compose(&G::translation_by(source)))
}

/// An alignment under way.
struct Search<'a, G, const D: usize, const N: usize> {
    matching: Matching<'a, N, D>,
    options: &'a Icp,
    /// X between the centroids.
    x: G,
}

impl<G: Rigid<D, N>, const D: usize, const N: usize> Search<'_, G, D, N> {
    /// Pairs and steps until it stops: why, and after how many steps.
    fn run(&mut self) -> Result<(Termination, usize), RegistrationError> {
        for iteration in 0..self.options.max_iterations {
            let (model, spectrum) = self.look()?;
            let Some(moved) = self.step(&model, &spectrum) else {
                return Ok((Termination::Stalled, iteration));
            };
            if moved < self.options.tolerance * self.options.max_distance {
                return Ok((Termination::Converged, iteration + 1));
            }
        }
        Ok((Termination::MaxIterations, self.options.max_iterations))
    }

    /// Pairs the points, and models the cost of the pairs.
    fn look(&mut self) -> Result<(Model<D>, Spectrum<D>), RegistrationError> {
        self.matching.pair(&self.x);
        let (matches, needed) = (self.matching.count(), D + 1);
        if matches < needed {
            let max_distance = self.options.max_distance;
            return Err(RegistrationError::NoOverlap { matches, needed, max_distance });
        }
        let model = self.matching.model(&self.x);
        let spectrum = Spectrum::of(&self.x, &model, &self.matching, self.options.least_share);
        Ok((model, spectrum))
    }

    /// Takes the step that lowers the cost of the pairs, and says how far it moves the points; `None` where none does.
    fn step(&mut self, model: &Model<D>, spectrum: &Spectrum<D>) -> Option<f64> {
        let mut damping = 0.0;
        while damping < MOST_DAMPING {
            let (tau, moved) = spectrum.step(&model.gradient, damping);
            let next = self.x.rplus(&tau);
            if self.matching.cost(&next) <= model.cost {
                self.x = next;
                return Some(moved);
            }
            damping = DAMPING.0.max(damping * DAMPING.1);
        }
        None
    }

    fn registered(
        &self,
        source: &Scan<N>,
        target: &Scan<N>,
        (model, spectrum): (&Model<D>, &Spectrum<D>),
        (termination, iterations): (Termination, usize),
    ) -> Registered<G, D> {
        let matches = self.matching.count();
        let coordinates = if self.options.method == Method::PointToPoint { N } else { 1 };
        // More matches than D were asked for; weights may still add up to less.
        let freedom = (model.weight * coordinates as f64 - D as f64).max(1.0);
        let sigma = (model.squares / freedom).sqrt().max(f64::EPSILON * self.matching.radius());
        let (from, to) = (G::translation_by(&-source.centre), G::translation_by(&target.centre));
        // The local tangent moves from the centroid to the origin of the source.
        let (inward, outward) = (from.adjoint(), G::translation_by(&source.centre).adjoint());
        let about_centroid = spectrum.information() / (sigma * sigma);
        let covariance = Covariance::from_information(&about_centroid).ok();
        Registered {
            target_from_source: to.compose(&self.x).compose(&from),
            information: inward.transpose() * about_centroid * inward,
            covariance: covariance.map(|c| c.transformed(&outward)),
            sigma,
            free: spectrum.free::<G, N>(&source.centre),
            points: source.points.len(),
            matches,
            rmse: (model.distances / matches as f64).sqrt(),
            iterations,
            termination,
        }
    }
}

impl Icp {
    fn check<const N: usize>(&self, source: &Scan<N>, target: &Scan<N>) -> Result<(), RegistrationError> {
        let options = [
            ("max_distance", self.max_distance),
            ("tolerance", self.tolerance),
            ("noise", self.noise.unwrap_or(1.0)),
            ("least_share", self.least_share),
        ];
        // Also false for NaN.
        if let Some(&(option, value)) = options.iter().find(|(_, x)| !(*x > 0.0 && *x <= LARGEST)) {
            return Err(RegistrationError::NotAnOption { option, value });
        }
        if !self.kernel.is_valid() {
            return Err(RegistrationError::NotAKernel);
        }
        let needs = |scan: &Scan<N>| scan.surfaces.is_empty();
        match self.method {
            Method::PointToPoint => Ok(()),
            _ if needs(target) => Err(RegistrationError::NoNormals { role: Role::Target }),
            Method::Generalised if needs(source) => Err(RegistrationError::NoNormals { role: Role::Source }),
            _ => Ok(()),
        }
    }
}
