//! Several estimates of one element, combined.

use super::{Covariance, Gaussian, Side, UncertaintyError};
use crate::lie::{LieGroup, Real, Tangent};
use nalgebra::{SMatrix, SimdComplexField};

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FuseOptions {
    /// Most steps made.
    pub max_iterations: usize,
    /// Stop when √(δᵀHδ) < `tolerance`, the step in standard deviations of the result. Not below √ε of the scalar.
    pub tolerance: f64,
}

impl Default for FuseOptions {
    fn default() -> Self {
        Self { max_iterations: 50, tolerance: 1e-6 }
    }
}

/// The estimate that fits all, and how it was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fused<G: LieGroup<D>, const D: usize, E: Side> {
    /// The most likely element and its covariance H⁻¹ there.
    pub estimate: Gaussian<G, D, E>,
    /// V = ½Σ eᵀΣ⁻¹e at the estimate. 2V is χ² with D(K − 1) degrees of freedom if the K estimates are honest.
    pub cost: f64,
    /// Steps made.
    pub iterations: usize,
    /// Whether the last step was short enough.
    pub converged: bool,
    /// Length of the last step, in standard deviations of the result.
    pub step: f64,
}

/// What covariance intersection makes small.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Criterion {
    /// det Σ, the volume of the ellipsoid: it does not depend on units.
    #[default]
    Determinant,
    /// tr Σ, the sum of variances: metres² and radians² are added as they stand.
    Trace,
}

/// A consistent estimate from two of unknown correlation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intersection<G: LieGroup<D>, const D: usize, E: Side> {
    /// The estimate. Σ is no smaller than the true error, whatever the correlation (to first order).
    pub estimate: Gaussian<G, D, E>,
    /// ω ∈ \[0, 1\], the share of the first estimate's information; 1 − ω is the second's.
    pub weight: f64,
}

/// An information matrix with the element it speaks about.
#[derive(Clone, Copy)]
pub(super) struct Known<G: LieGroup<D>, const D: usize> {
    pub(super) mean: G,
    pub(super) information: SMatrix<G::Scalar, D, D>,
}

/// The quadratic model of the cost at a point.
struct Model<S, const D: usize> {
    hessian: SMatrix<S, D, D>,
    gradient: Tangent<S, D>,
    cost: S,
}

impl<G: LieGroup<D>, const D: usize, E: Side> Gaussian<G, D, E> {
    /// The most likely element given *independent* estimates of it: argmin ½Σ_k eᵀΣ_k⁻¹e with e the error about X̄_k.
    ///
    /// Gauss–Newton from the mean of the first, with exact Jacobians J(e)⁻¹: Barfoot & Furgale (2014) §IV with the whole
    /// Bernoulli series. A step that does not lower the cost is halved, so that estimates half a turn apart find a minimum
    /// as well.
    ///
    /// ```
    /// use boxplus::lie::SE2;
    /// use boxplus::uncertainty::Gaussian;
    /// use nalgebra::vector;
    /// let gps = Gaussian::<SE2, 3>::from_sigmas(SE2::new(vector![1.0, 2.0], 0.1), &vector![1.0, 1.0, 0.5])?;
    /// let map = Gaussian::from_sigmas(SE2::new(vector![1.4, 1.9], 0.2), &vector![0.2, 0.2, 0.05])?;
    /// let both = Gaussian::fuse([&gps, &map])?;
    /// assert!(both.converged && both.estimate.sigmas()[0] < 0.2);
    /// # Ok::<(), boxplus::uncertainty::UncertaintyError>(())
    /// ```
    ///
    /// # Errors
    /// [`UncertaintyError::TooFew`] of none; [`UncertaintyError::Singular`] where an estimate is certain along a direction.
    pub fn fuse<'a>(
        estimates: impl IntoIterator<Item = &'a Self, IntoIter: Clone>,
    ) -> Result<Fused<G, D, E>, UncertaintyError> {
        let estimates = estimates.into_iter();
        let start = estimates.clone().next().ok_or(UncertaintyError::TooFew { given: 0, needed: 1 })?;
        Self::fuse_from(start.mean(), estimates, &FuseOptions::default())
    }

    /// [`Gaussian::fuse`] from a first guess.
    ///
    /// # Errors
    /// Those of [`Gaussian::fuse`].
    pub fn fuse_from<'a>(
        start: &G,
        estimates: impl IntoIterator<Item = &'a Self, IntoIter: Clone>,
        options: &FuseOptions,
    ) -> Result<Fused<G, D, E>, UncertaintyError> {
        let estimates = estimates.into_iter();
        if estimates.clone().next().is_none() {
            return Err(UncertaintyError::TooFew { given: 0, needed: 1 });
        }
        // Says which estimate is singular before any work is done.
        estimates.clone().try_for_each(|x| x.covariance().regular_factor().map(drop))?;
        let known = estimates.filter_map(|x| {
            x.covariance().information().ok().map(|information| Known { mean: *x.mean(), information })
        });
        minimised::<G, D, E>(start, &known, options)
    }

    /// An estimate from two whose errors are correlated in an unknown way: Σ⁻¹ = ωΣ₁⁻¹ + (1 − ω)Σ₂⁻¹, both told about the
    /// result, ω chosen by `criterion`. Julier & Uhlmann (1997).
    ///
    /// For robots that exchange maps, and whenever the same measurement may have entered both.
    ///
    /// # Errors
    /// [`UncertaintyError::Singular`]; [`UncertaintyError::NotConverged`] where the two are half a turn apart.
    pub fn intersect(
        &self,
        other: &Self,
        criterion: Criterion,
    ) -> Result<Intersection<G, D, E>, UncertaintyError> {
        let known = [self, other].map(|x| x.covariance().information());
        let [first, second] = known;
        let (first, second) = (first?, second?);
        let at = |weight: f64| {
            let share = |x: &Self, information: SMatrix<G::Scalar, D, D>, w: f64| Known {
                mean: *x.mean(),
                information: information * G::Scalar::lit(w),
            };
            let pair = [share(self, first, weight), share(other, second, 1.0 - weight)];
            minimised::<G, D, E>(self.mean(), &pair.into_iter(), &FuseOptions::default())
        };
        let size = |x: &Gaussian<G, D, E>| criterion.size(x);
        let weight = smallest(|weight| size(&at(weight)?.estimate))?;
        let inner = Intersection { estimate: converged(at(weight)?)?, weight };
        let ends =
            [Intersection { estimate: *self, weight: 1.0 }, Intersection { estimate: *other, weight: 0.0 }];
        let mut best = (size(&inner.estimate)?, inner);
        for end in ends {
            let value = size(&end.estimate)?;
            if value < best.0 {
                best = (value, end);
            }
        }
        Ok(best.1)
    }
}

impl Criterion {
    /// ln det Σ or tr Σ.
    pub(super) fn size<G: LieGroup<D>, const D: usize, E: Side>(
        self,
        x: &Gaussian<G, D, E>,
    ) -> Result<f64, UncertaintyError> {
        match self {
            Self::Determinant => x.covariance().log_determinant().map(Real::value),
            Self::Trace => Ok(x.covariance().matrix().trace().value()),
        }
    }
}

/// The estimate, if the iteration settled.
pub(super) fn converged<G: LieGroup<D>, const D: usize, E: Side>(
    fused: Fused<G, D, E>,
) -> Result<Gaussian<G, D, E>, UncertaintyError> {
    let Fused { estimate, iterations, step, .. } = fused;
    if fused.converged { Ok(estimate) } else { Err(UncertaintyError::NotConverged { iterations, step }) }
}

/// Gauss–Newton with halving of steps that do not lower the cost.
pub(super) fn minimised<G: LieGroup<D>, const D: usize, E: Side>(
    start: &G,
    known: &(impl Iterator<Item = Known<G, D>> + Clone),
    options: &FuseOptions,
) -> Result<Fused<G, D, E>, UncertaintyError> {
    let tolerance = options.tolerance.max(G::Scalar::EPSILON.simd_sqrt());
    let mut x = *start;
    let mut model = quadratic::<G, D, E>(&x, known.clone());
    let (mut iterations, mut step) = (0, f64::INFINITY);
    while iterations < options.max_iterations && step >= tolerance {
        let covariance = Covariance::from_information(&model.hessian)?;
        let delta = -(covariance.matrix() * model.gradient);
        // −gᵀδ = δᵀHδ.
        let square = -model.gradient.dot(&delta).value();
        step = square.max(0.0).simd_sqrt();
        (x, model) = lowered::<G, D, E>(&x, &delta, model.cost.value(), known);
        iterations += 1;
    }
    let covariance = Covariance::from_information(&model.hessian)?;
    let (estimate, cost) = (Gaussian::new(x, covariance), model.cost.value());
    Ok(Fused { estimate, cost, iterations, converged: step < tolerance, step })
}

/// The end of a step, halved until the cost does not rise beyond rounding.
fn lowered<G: LieGroup<D>, const D: usize, E: Side>(
    x: &G,
    delta: &Tangent<G::Scalar, D>,
    cost: f64,
    known: &(impl Iterator<Item = Known<G, D>> + Clone),
) -> (G, Model<G::Scalar, D>) {
    const HALVINGS: i32 = 12;
    let allowed = cost * (1.0 + 16.0 * G::Scalar::EPSILON);
    let mut scale = 1.0;
    for _ in 0..HALVINGS {
        let next = E::perturb(x, &(delta * G::Scalar::lit(scale)));
        let model = quadratic::<G, D, E>(&next, known.clone());
        if model.cost.value() <= allowed {
            return (next, model);
        }
        scale *= 0.5;
    }
    // No step lowers the cost: rounding decides, and the point is as good as it gets.
    (*x, quadratic::<G, D, E>(x, known.clone()))
}

/// Cost ½Σ eᵀΩe, its gradient Σ J⁻ᵀΩe and Gauss–Newton Hessian Σ J⁻ᵀΩJ⁻¹ at `x`.
fn quadratic<G: LieGroup<D>, const D: usize, E: Side>(
    x: &G,
    known: impl Iterator<Item = Known<G, D>>,
) -> Model<G::Scalar, D> {
    let (mut hessian, mut gradient, mut cost) = (SMatrix::zeros(), Tangent::zeros(), G::Scalar::lit(0.0));
    for k in known {
        let e = E::error(x, &k.mean);
        let j = E::jacobian_inverse::<G, D>(&e);
        let weighted = j.transpose() * k.information;
        hessian += weighted * j;
        gradient += weighted * e;
        cost += e.dot(&(k.information * e)) * G::Scalar::lit(0.5);
    }
    Model { hessian, gradient, cost }
}

/// The ω ∈ (0, 1) that makes a function with one minimum smallest, by golden sections.
pub(super) fn smallest(f: impl Fn(f64) -> Result<f64, UncertaintyError>) -> Result<f64, UncertaintyError> {
    const GOLDEN: f64 = 0.6180339887498949;
    // A minimum is flat: half of the digits of ω are beyond what f can tell apart, 0.618³⁶ = 3e-8.
    const SECTIONS: usize = 36;
    let (mut low, mut high) = (0.0, 1.0);
    let (mut a, mut b) = (1.0 - GOLDEN, GOLDEN);
    let (mut fa, mut fb) = (f(a)?, f(b)?);
    for _ in 0..SECTIONS {
        if fa <= fb {
            (high, b, fb) = (b, a, fa);
            a = high - GOLDEN * (high - low);
            fa = f(a)?;
        } else {
            (low, a, fa) = (a, b, fb);
            b = low + GOLDEN * (high - low);
            fb = f(b)?;
        }
    }
    Ok(0.5 * (low + high))
}
