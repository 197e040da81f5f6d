//! Averages of group elements: "how do I average rotations?"
//!
//! Averaging quaternions, Euler angles or matrices number by number leaves the group, depends on signs, or fails at the wrap of
//! an angle (`examples/average_rotations.rs`). On a group there are several means; each asks another question.
//!
//! | mean | is the X̄ with | choose it when |
//! |---|---|---|
//! | bi-invariant, [`Means::mean`] | Σ wᵢ Log(X̄⁻¹Xᵢ) = 0 | in doubt: needs no metric, does not depend on frames or on the side |
//! | geodesic, [`Means::geodesic_mean`] | min Σ wᵢ‖Log(X̄⁻¹Xᵢ)‖² | metres and radians have a known exchange rate; left-invariant only |
//! | chordal, [`ChordalMean::chordal_mean`] | min Σ wᵢ‖X̄ − Xᵢ‖² of matrices | no iteration is wanted, or a start for one |
//! | Huber's, [`Means::huber_mean`] | min Σ wᵢρ(‖Log(X̄⁻¹Xᵢ)‖) | a few data may be wrong, and the scatter of the others is known |
//! | median, [`Means::median`] | min Σ wᵢ‖Log(X̄⁻¹Xᵢ)‖ | up to half of the data may be wrong |
//!
//! On SO(2), SO(3) and ℝⁿ the first two are the same: their metric is bi-invariant, and J_l⁻ᵀ(τ)·τ = τ. For data within θ of their
//! mean the chordal one differs by O(θ³).
//!
//! # Poses
//! The mean of SE(3) is not the mean of ⟨ℝ³, SO(3)⟩. Two poses that a car drove through are halfway on the arc in SE(3), and halfway
//! on the chord in ⟨ℝ³, SO(3)⟩, whose rotations and translations are averaged apart. Take SE(3) when the poses are the same
//! *motion*, measured repeatedly (an extrinsic calibration, odometry between two stamps): the result does not depend on where the
//! origins of either frame are. Take [`R3xSO3`](super::R3xSO3) when translations are positions of one point in one frame and
//! have nothing to do with the rotation: the mean position is then the arithmetic one.
//!
//! ```
//! use boxplus::lie::{LieGroup, Means, R3xSO3, SE3, Weights};
//! use nalgebra::Vector6;
//! let quarter = Vector6::new(1.0, 0.0, 0.0, 0.0, 0.0, std::f64::consts::FRAC_PI_2);
//! let ends = [SE3::identity(), SE3::exp(&quarter)];
//! let arc = SE3::mean(&ends, Weights::Equal)?.value;
//! let chord = R3xSO3::mean(&ends.map(|x| R3xSO3::from_pose(&x)), Weights::Equal)?.value;
//! assert!(arc.rminus(&SE3::exp(&(quarter * 0.5))).norm() < 1e-15);
//! assert!((chord.translation() - ends[1].translation() * 0.5).norm() < 1e-15);
//! assert!((arc.translation() - chord.translation()).norm() > 0.18); // metres apart
//! # Ok::<(), boxplus::lie::LieError>(())
//! ```
//!
//! # When there is no mean
//! Two rotations half a turn apart have two means, a cloud all around has none. The mean is the only one when every element is
//! nearer than half of the way to where Log jumps: θ < π/2 on SO(2) and SO(3) (Afsari 2011), θ < π for S³, whatever the
//! translation. That is checked, by whether twice the tangent is a principal logarithm, and [`LieError::TooDispersed`] names the
//! element. [`Means::barycentre`] does not refuse, and tells what weight lies beyond.
//!
//! # Uncertainty
//! By the implicit function theorem ∂X̄/∂Xᵢ = H⁻¹·wᵢ·J_r⁻¹(τᵢ) with H = Σ wⱼ J_l⁻¹(τⱼ): [`Mean::jac`]. The report has the scatter of
//! the elements and the covariance of X̄ that follows from it.
//!
//! # Names elsewhere
//! manif has four: `average_biinvariant` is [`Means::mean`]; `average_frechet_left` and `average_frechet_right` multiply the same step
//! by a matrix and by its inverse, and are that mean, too; `average` solves Σ J_rᵀ(τᵢ)·τᵢ = 0, which is none of ours and minimises
//! no sum of squares. Sophus: `average`, `iterativeMean` are [`Means::mean`]; GTSAM: `FindKarcherMean` as well.

use super::linear::inverse;
use super::{
    Jacobian, LieError, LieGroup, Real, RxSO2, RxSO3, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3, Tangent,
};
use nalgebra::{SMatrix, SimdComplexField};

/// How much each element counts. Only ratios matter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weights<'a> {
    /// All alike.
    Equal,
    /// One each, at least 0.
    Of(&'a [f64]),
}

impl Weights<'_> {
    /// Checks the weights of `count` elements: `[largest, Σw/largest]`, so that no sum overflows.
    fn total(&self, count: usize) -> Result<[f64; 2], LieError> {
        if count == 0 {
            return Err(LieError::NoElements);
        }
        let Self::Of(weights) = self else { return Ok([1.0, count as f64]) };
        if weights.len() != count {
            return Err(LieError::WeightCount { elements: count, weights: weights.len() });
        }
        let wrong = |w: f64| !(w.is_finite() && w >= 0.0);
        if let Some((index, &weight)) = weights.iter().enumerate().find(|(_, w)| wrong(**w)) {
            return Err(LieError::NotAWeight { index, weight });
        }
        let largest = weights.iter().fold(0.0, |a: f64, &w| a.max(w));
        let sum = weights.iter().map(|w| w / largest).sum();
        if largest > 0.0 { Ok([largest, sum]) } else { Err(LieError::NoWeight) }
    }

    /// wᵢ/Σw.
    fn share(&self, index: usize, [largest, sum]: [f64; 2]) -> f64 {
        let weight = if let Self::Of(weights) = self { weights[index] } else { 1.0 };
        weight / largest / sum
    }
}

/// A mean, and how it was found.
#[derive(Clone, Copy, Debug)]
pub struct Mean<G: LieGroup<D>, const D: usize> {
    /// X̄.
    pub value: G,
    /// Steps to it.
    pub iterations: usize,
    /// Length of what should be zero: Σ wᵢ Log(X̄⁻¹Xᵢ), or the gradient of the sum that is minimised; the weights summing to 1.
    pub residual: f64,
    /// The largest ‖Log(X̄⁻¹Xᵢ)‖, metres and radians as they are.
    pub radius: f64,
    /// Share of the weight at half of the way to the cut locus or beyond it. 0: no other mean.
    pub beyond: f64,
    /// Σ wᵢτᵢτᵢᵀ with τᵢ = Log(X̄⁻¹Xᵢ) and weights summing to 1, D×D, local: the scatter about X̄.
    pub dispersion: Jacobian<G::Scalar, D>,
    /// Covariance of X̄ itself, D×D, local, if the elements are independent and scatter alike: H⁻¹·Σ wᵢ²vᵢvᵢᵀ·H⁻ᵀ/(1 − Σ wᵢ²), vᵢ
    /// being what element i contributes to the residual; for equal weights near X̄, dispersion/(n − 1). None where the elements
    /// do not tell: a single one, or a median that sits on an element.
    pub covariance: Option<Jacobian<G::Scalar, D>>,
    sensitivity: Option<Jacobian<G::Scalar, D>>,
    touch: f64,
    kind: Kind<G::Scalar, D>,
}

impl<G: LieGroup<D>, const D: usize> Mean<G, D> {
    /// How strong an element pulls for its distance: of [`Means::huber_mean`] 1 up to the threshold k and k/d beyond, where what is
    /// below 1 was held for an outlier; of the median 1/d, and 0 for an element that is X̄; of the others 1.
    pub fn pull(&self, element: &G) -> G::Scalar {
        self.kind.pull(&element.rminus(&self.value), self.touch)
    }

    /// ∂X̄/∂Xᵢ, D×D, right: how the mean follows one of its elements, whose weight is the `share` wᵢ/Σw. None where the mean
    /// does not follow smoothly, such as a median that sits on an element.
    pub fn jac(&self, element: &G, share: G::Scalar) -> Option<Jacobian<G::Scalar, D>> {
        let (tau, right, _) = self.value.between(element).log_jacs();
        Some(self.sensitivity? * self.kind.slope::<G>(&tau, self.touch)? * right * share)
    }

    /// The covariance of X̄, D×D, local, of two or more independent elements with known covariances Σᵢ, local as well:
    /// Σ Jᵢ Σᵢ Jᵢᵀ. `elements` yields (Xᵢ, wᵢ/Σw, Σᵢ).
    pub fn propagated<'a>(
        &self,
        elements: impl IntoIterator<Item = (&'a G, G::Scalar, &'a Jacobian<G::Scalar, D>)>,
    ) -> Option<Jacobian<G::Scalar, D>> {
        elements.into_iter().try_fold(
            SMatrix::zeros(),
            |sum: Jacobian<_, D>, (element, share, covariance)| {
                let jac = self.jac(element, share)?;
                Some(sum + jac * covariance * jac.transpose())
            },
        )
    }
}

/// Means of every group. All are for single numbers: iterations stop by value. Dual numbers carry exact derivatives through.
pub trait Means<const D: usize>: LieGroup<D> {
    /// The bi-invariant mean, Σ wᵢ Log(X̄⁻¹Xᵢ) = 0. Pennec & Arsigny (2013).
    ///
    /// ```
    /// use boxplus::lie::{Means, SO2, Weights};
    /// let headings = [350.0_f64, 0.0, 25.0].map(|degrees| SO2::from_angle(degrees.to_radians()));
    /// let mean = SO2::mean(&headings, Weights::Equal)?;
    /// assert!((mean.value.angle().to_degrees() - 5.0).abs() < 1e-12); // and not 125°
    /// # Ok::<(), boxplus::lie::LieError>(())
    /// ```
    ///
    /// # Errors
    /// [`LieError::NoElements`]; [`LieError::WeightCount`], [`LieError::NotAWeight`], [`LieError::NoWeight`];
    /// [`LieError::NotFinite`]; [`LieError::TooDispersed`] for several means, [`LieError::NotConverged`].
    fn mean(elements: &[Self], weights: Weights<'_>) -> Result<Mean<Self, D>, LieError> {
        Average::new(Kind::BiInvariant, elements, weights)?.the_only_one()
    }

    /// [`Means::mean`] however dispersed the elements are, as long as the iteration settles. Check [`Mean::beyond`].
    ///
    /// # Errors
    /// Those of [`Means::mean`] but [`LieError::TooDispersed`].
    fn barycentre(elements: &[Self], weights: Weights<'_>) -> Result<Mean<Self, D>, LieError> {
        Average::new(Kind::BiInvariant, elements, weights)?.solve()
    }

    /// The X̄ that minimises Σ wᵢ‖m ∘ Log(X̄⁻¹Xᵢ)‖², [`Distance::weighted_distance`](super::Distance::weighted_distance) squared, m
    /// being its factors per metre and radian. Gauss–Newton. Independent of the parent frame; of the local frame only where the
    /// metric is.
    ///
    /// # Errors
    /// Those of [`Means::mean`].
    fn geodesic_mean(
        elements: &[Self],
        weights: Weights<'_>,
        metric: &Tangent<Self::Scalar, D>,
    ) -> Result<Mean<Self, D>, LieError> {
        Average::new(Kind::Geodesic(*metric), elements, weights)?.the_only_one()
    }

    /// The median of Weiszfeld (1937), of exponential barycentres: Σ wᵢτᵢ/‖m ∘ τᵢ‖ = 0 with τᵢ = Log(X̄⁻¹Xᵢ) and m the factors per metre
    /// and radian; where X̄ sits on an element, Vardi & Zhang (2000). Elements far away pull no stronger than near ones.
    ///
    /// ```
    /// use boxplus::lie::{LieGroup, Means, SO3, Weights};
    /// use nalgebra::Vector3;
    /// let readings = [0.0, 0.1, -0.1, 3.0].map(SO3::about_z); // the last is an outlier
    /// let median = SO3::median(&readings, Weights::Equal, &Vector3::repeat(1.0))?;
    /// assert!(median.value.log().norm() < 0.11);
    /// # Ok::<(), boxplus::lie::LieError>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`Means::mean`]; [`LieError::TooDispersed`] only if half of the weight or more lies beyond the bound.
    fn median(
        elements: &[Self],
        weights: Weights<'_>,
        metric: &Tangent<Self::Scalar, D>,
    ) -> Result<Mean<Self, D>, LieError> {
        Average::new(Kind::Median(*metric), elements, weights)?.the_only_one()
    }

    /// Huber's (1964) mean, of exponential barycentres: Σ wᵢ·min(1, k/dᵢ)·τᵢ = 0 with τᵢ = Log(X̄⁻¹Xᵢ), dᵢ = ‖m ∘ τᵢ‖ and k = `threshold`.
    /// Elements nearer than k count as in [`Means::mean`], those beyond pull as strong as if they were at k: by their direction.
    ///
    /// Between the mean, k = ∞, and the median, k → 0. With m = 1/σ of each coordinate k is a number of standard deviations; k² the
    /// quantile of χ² with D degrees of freedom that 95 % of good elements keep below (SO(3): k = 2.8) costs little of the mean's precision
    /// where there are no outliers. [`Mean::pull`] says which elements were held for some.
    ///
    /// ```
    /// use boxplus::lie::{LieGroup, Means, SO3, Weights};
    /// use nalgebra::Vector3;
    /// let readings = [0.00, 0.02, -0.01, 0.01, 1.5].map(SO3::about_z); // the last is an outlier
    /// let (per_sigma, k) = (Vector3::repeat(1.0 / 0.02), 2.8);
    /// let mean = SO3::huber_mean(&readings, Weights::Equal, &per_sigma, k)?;
    /// assert!(mean.value.log().norm() < 0.02); // the mean is at 0.3
    /// assert!(mean.pull(&readings[4]) < 0.1 && mean.pull(&readings[1]) == 1.0);
    /// # Ok::<(), boxplus::lie::LieError>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`Means::median`]; [`LieError::NotAThreshold`] unless `threshold` is positive.
    fn huber_mean(
        elements: &[Self],
        weights: Weights<'_>,
        metric: &Tangent<Self::Scalar, D>,
        threshold: f64,
    ) -> Result<Mean<Self, D>, LieError> {
        if threshold.is_nan() || threshold <= 0.0 {
            return Err(LieError::NotAThreshold { threshold });
        }
        Average::new(Kind::Huber(*metric, threshold), elements, weights)?.the_only_one()
    }
}

impl<G: LieGroup<D>, const D: usize> Means<D> for G {}

/// What the sum over the elements is of.
#[derive(Clone, Copy, Debug)]
enum Kind<S, const D: usize> {
    BiInvariant,
    Geodesic(Tangent<S, D>),
    Median(Tangent<S, D>),
    Huber(Tangent<S, D>, f64),
}

impl<S: Real, const D: usize> Kind<S, D> {
    /// Whether an element far away pulls no stronger than one at some distance.
    const fn is_robust(&self) -> bool {
        matches!(self, Self::Median(_) | Self::Huber(..))
    }

    const fn iterations(&self) -> usize {
        if self.is_robust() { 2000 } else { 100 }
    }

    /// h(τ), by which the pull of an element at τ from the mean is reduced: 1, or where that is robust 1/d or k/d beyond d = k,
    /// d = √(τᵀΩτ) and Ω = diag(metric²). 0 for what holds the median, being nearer than `touch`.
    fn pull(&self, tau: &Tangent<S, D>, touch: f64) -> S {
        match self {
            Self::BiInvariant | Self::Geodesic(_) => S::one(),
            Self::Median(_) if size(tau) <= touch => S::zero(),
            Self::Median(metric) => S::one() / length(metric, tau),
            Self::Huber(metric, threshold) => {
                let distance = length(metric, tau);
                if distance.value() <= *threshold { S::one() } else { S::lit(*threshold) / distance }
            }
        }
    }

    /// v(τ), what an element at τ from the mean contributes: h(τ)·τ, of the geodesic mean J_l⁻ᵀ(τ)Ωτ.
    fn influence<G: LieGroup<D, Scalar = S>>(&self, tau: &Tangent<S, D>, touch: f64) -> Tangent<S, D> {
        match self {
            Self::Geodesic(metric) => G::left_jacobian_inverse(tau).tr_mul(&squared(metric, tau)),
            _ => tau * self.pull(tau, touch),
        }
    }

    /// dv/dτ, D×D; None where v has none.
    fn slope<G: LieGroup<D, Scalar = S>>(&self, tau: &Tangent<S, D>, touch: f64) -> Option<Jacobian<S, D>> {
        match self {
            Self::BiInvariant => Some(SMatrix::identity()),
            Self::Geodesic(metric) => {
                let (force, inverse) = (squared(metric, tau), G::left_jacobian_inverse(tau));
                let mut slope = inverse.transpose() * SMatrix::from_diagonal(&metric.component_mul(metric));
                for k in 0..D {
                    let axis = Tangent::from_fn(|i, _| if i == k { S::one() } else { S::zero() });
                    let bend = G::right_jacobian_inverse_derivative(&-tau, &-axis).tr_mul(&force);
                    slope.set_column(k, &(slope.column(k) + bend));
                }
                Some(slope)
            }
            Self::Median(_) if size(tau) <= touch => None,
            Self::Huber(metric, threshold) if length(metric, tau).value() <= *threshold => {
                Some(SMatrix::identity())
            }
            Self::Median(metric) | Self::Huber(metric, _) => {
                let unit = tau / length(metric, tau);
                let across = SMatrix::identity() - unit * squared(metric, &unit).transpose();
                Some(across * self.pull(tau, touch))
            }
        }
    }
}

/// ‖τ‖.
fn size<S: Real, const D: usize>(tau: &Tangent<S, D>) -> f64 {
    tau.norm_squared().value().simd_sqrt()
}

/// Ωτ.
fn squared<S: Real, const D: usize>(metric: &Tangent<S, D>, tau: &Tangent<S, D>) -> Tangent<S, D> {
    metric.component_mul(&metric.component_mul(tau))
}

/// √(τᵀΩτ).
fn length<S: Real, const D: usize>(metric: &Tangent<S, D>, tau: &Tangent<S, D>) -> S {
    metric.component_mul(tau).norm_squared().simd_sqrt()
}

/// A mean to be found.
struct Average<'a, G: LieGroup<D>, const D: usize> {
    kind: Kind<G::Scalar, D>,
    elements: &'a [G],
    weights: Weights<'a>,
    total: [f64; 2],
}

impl<'a, G: LieGroup<D>, const D: usize> Average<'a, G, D> {
    fn new(kind: Kind<G::Scalar, D>, elements: &'a [G], weights: Weights<'a>) -> Result<Self, LieError> {
        Ok(Self { kind, elements, weights, total: weights.total(elements.len())? })
    }

    /// A mean that may not be the only one is refused.
    fn the_only_one(&self) -> Result<Mean<G, D>, LieError> {
        let bearable = if self.kind.is_robust() { 0.5 } else { f64::MIN_POSITIVE };
        let mean = self.solve()?;
        if mean.beyond < bearable { Ok(mean) } else { Err(self.too_dispersed(&mean.value)) }
    }

    /// Which element that counts is furthest on its way to the cut locus, and how far.
    fn too_dispersed(&self, center: &G) -> LieError {
        let (mut index, mut shortest) = (0, 1.0);
        for (i, (x, share)) in self.shares().enumerate() {
            let tau = x.rminus(center);
            // The element is at 1/(2s) of its way when s·τ is half-way; bisect s.
            if share > 0.0 && is_half_way::<G, D>(&tau, shortest) {
                let (mut near, mut far) = (0.5, shortest);
                for _ in 0..30 {
                    let middle = 0.5 * (near + far);
                    if is_half_way::<G, D>(&tau, middle) { far = middle } else { near = middle }
                }
                (index, shortest) = (i, far);
            }
        }
        LieError::TooDispersed { index, reach: (0.5 / shortest).min(1.0) }
    }

    fn solve(&self) -> Result<Mean<G, D>, LieError> {
        let mut value = self.start()?;
        let mut length = f64::INFINITY;
        for iteration in 1..=self.kind.iterations() {
            let resolution = self.resolution(&value);
            if let Some(element) = self.held_by_an_element(&value, 16.0 * resolution) {
                return Ok(self.report(element, iteration));
            }
            let step = self.step(&value, 16.0 * resolution);
            value = value.rplus(&step);
            length = size(&step);
            if !length.is_finite() {
                return Err(LieError::NotFinite);
            }
            if length <= 64.0 * resolution {
                return Ok(self.report(value, iteration));
            }
        }
        Err(LieError::NotConverged { iterations: self.kind.iterations(), step: length })
    }

    /// The element next to `center` if it is the median: if its weight holds it against the pull of all others. Iterations
    /// would only creep towards it.
    fn held_by_an_element(&self, center: &G, touch: f64) -> Option<G> {
        let Kind::Median(metric) = &self.kind else { return None };
        let distance = |x: &G| length(metric, &x.rminus(center)).value();
        let next = self.elements.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        (size(&self.balance(next, touch)) == 0.0).then_some(*next)
    }

    /// What rounding leaves of a tangent at `center`: ε times the longest one, and times the entries of Ad, where its translation is.
    fn resolution(&self, center: &G) -> f64 {
        let spread = self.tangents(center).fold(0.0, |a: f64, (tau, _)| a.max(size(&tau)));
        G::Scalar::EPSILON * (spread + center.adjoint().map(Real::value).amax())
    }

    /// The first element that counts.
    fn start(&self) -> Result<G, LieError> {
        let first = self.shares().find(|(_, share)| *share > 0.0).map(|(x, _)| *x);
        first.ok_or(LieError::NoWeight)
    }

    /// (Xᵢ, wᵢ/Σw).
    fn shares(&self) -> impl Iterator<Item = (&G, f64)> {
        self.elements.iter().enumerate().map(|(i, x)| (x, self.weights.share(i, self.total)))
    }

    /// (τᵢ, wᵢ/Σw) seen from `center`.
    fn tangents(&self, center: &G) -> impl Iterator<Item = (Tangent<G::Scalar, D>, f64)> {
        self.shares().map(|(x, share)| (x.rminus(center), share))
    }

    fn step(&self, center: &G, touch: f64) -> Tangent<G::Scalar, D> {
        match &self.kind {
            Kind::BiInvariant => self.balance(center, touch),
            Kind::Geodesic(metric) => self.gauss_newton(center, metric),
            Kind::Median(_) | Kind::Huber(..) => self.reweighted(center, touch),
        }
    }

    /// Σ wᵢvᵢ, which is 0 at the mean. For the median less the weight of the elements that are where the centre is: they hold it by
    /// that much, in any direction.
    fn balance(&self, center: &G, touch: f64) -> Tangent<G::Scalar, D> {
        let (mut sum, mut here) = (Tangent::<G::Scalar, D>::zeros(), 0.0);
        for (tau, share) in self.tangents(center) {
            sum += self.kind.influence::<G>(&tau, touch) * G::Scalar::lit(share);
            here += if size(&tau) <= touch { share } else { 0.0 };
        }
        match &self.kind {
            Kind::Median(metric) if here > 0.0 => {
                let strength = length(metric, &sum).value();
                if strength <= here { Tangent::zeros() } else { sum * G::Scalar::lit(1.0 - here / strength) }
            }
            _ => sum,
        }
    }

    /// (Σ wᵢ J_l⁻ᵀΩJ_l⁻¹)⁻¹·Σ wᵢvᵢ.
    fn gauss_newton(&self, center: &G, metric: &Tangent<G::Scalar, D>) -> Tangent<G::Scalar, D> {
        let mut hessian = Jacobian::<G::Scalar, D>::zeros();
        for (tau, share) in self.tangents(center) {
            let scaled = SMatrix::from_diagonal(metric) * G::left_jacobian_inverse(&tau);
            hessian += scaled.tr_mul(&scaled) * G::Scalar::lit(share);
        }
        let not_a_number = || Tangent::repeat(G::Scalar::lit(f64::NAN));
        inverse(&hessian).map_or_else(not_a_number, |h| h * self.balance(center, 0.0))
    }

    /// Σ wᵢvᵢ/Σ wᵢhᵢ: the mean with weights as they are from here. Weiszfeld (1937).
    fn reweighted(&self, center: &G, touch: f64) -> Tangent<G::Scalar, D> {
        let pulls =
            self.tangents(center).map(|(tau, share)| G::Scalar::lit(share) * self.kind.pull(&tau, touch));
        let stiffness = pulls.fold(G::Scalar::lit(0.0), |a, b| a + b);
        // Where all are here, 0 by a small number.
        self.balance(center, touch) / (stiffness + G::Scalar::lit(f64::from(f32::MIN_POSITIVE)))
    }

    /// H = Σ wᵢ·v′(τᵢ)·J_l⁻¹(τᵢ), the derivative of −Σ wᵢvᵢ by the centre, inverted.
    fn sensitivity(&self, center: &G, touch: f64) -> Option<Jacobian<G::Scalar, D>> {
        let mut hessian = Jacobian::<G::Scalar, D>::zeros();
        for (tau, share) in self.tangents(center) {
            let slope = self.kind.slope::<G>(&tau, touch)? * G::left_jacobian_inverse(&tau);
            hessian += slope * G::Scalar::lit(share);
        }
        inverse(&hessian)
    }

    fn report(&self, found: G, iterations: usize) -> Mean<G, D> {
        let touch = 16.0 * self.resolution(&found);
        // One step of Newton's: to the last digit, and derivatives of dual numbers become those of the solution.
        let newton =
            self.sensitivity(&found, touch).map(|s| s * self.balance(&found, touch)).filter(is_finite);
        let value = newton.map_or(found, |step| found.rplus(&step));
        let sensitivity = self.sensitivity(&value, touch).filter(is_finite);
        let (mut dispersion, mut meat) = (Jacobian::<G::Scalar, D>::zeros(), Jacobian::zeros());
        let (mut radius, mut beyond, mut squares) = (0.0_f64, 0.0, 0.0);
        for (tau, share) in self.tangents(&value) {
            let (v, weight) = (self.kind.influence::<G>(&tau, touch), G::Scalar::lit(share));
            dispersion += tau * tau.transpose() * weight;
            meat += v * v.transpose() * (weight * weight);
            radius = radius.max(size(&tau));
            beyond += if is_half_way::<G, D>(&tau, 1.0) { share } else { 0.0 };
            squares += share * share;
        }
        let freedom = 1.0 - squares;
        let covariance = sensitivity
            .filter(|_| freedom > 4.0 * f64::EPSILON)
            .map(|s| s * meat * s.transpose() * G::Scalar::lit(1.0 / freedom));
        Mean {
            value,
            iterations,
            residual: size(&self.balance(&value, touch)),
            radius,
            beyond,
            dispersion,
            covariance,
            sensitivity,
            touch,
            kind: self.kind,
        }
    }
}

fn is_finite<S: Real, const R: usize, const C: usize>(m: &SMatrix<S, R, C>) -> bool {
    m.iter().all(|x| x.value().is_finite())
}

/// Whether `stretch`·τ is half of the way to the cut locus or beyond: twice as long, Log no longer gives it back. The jump is by
/// whole turns, and moves a translation by as much as its length, so that rounding is not taken for it.
fn is_half_way<G: LieGroup<D>, const D: usize>(tau: &Tangent<G::Scalar, D>, stretch: f64) -> bool {
    let small = G::Scalar::EPSILON.simd_sqrt();
    let twice = tau * G::Scalar::lit(2.0 * stretch * (1.0 + small));
    let change = G::exp(&twice).log() - twice;
    let largest = twice.iter().fold(0.0, |a: f64, x| a.max(x.value().abs()));
    !change.iter().all(|x| x.value().abs() < 1.0 + small * largest)
}

/// Groups of matrices whose mean matrix has a nearest element.
pub trait ChordalMean<const D: usize>: LieGroup<D> {
    /// The X̄ that minimises Σ wᵢ‖X̄ − Xᵢ‖² in the Frobenius norm: the element nearest to the mean matrix Σ wᵢXᵢ (Markley et al. (2007)
    /// say the same of quaternions, as the top eigenvector of Σ wᵢqᵢqᵢᵀ). Translations, velocities and times are averaged apart from
    /// rotations, in the parent frame; a scale is tr(R̄ᵀΣ wᵢsᵢRᵢ)/n, too small by the dispersion of the rotations.
    ///
    /// # Errors
    /// [`LieError::NoElements`], [`LieError::WeightCount`], [`LieError::NotAWeight`], [`LieError::NoWeight`], [`LieError::NotFinite`];
    /// [`LieError::Undetermined`] where several rotations are as near: the elements are too dispersed.
    fn chordal_mean(elements: &[Self], weights: Weights<'_>) -> Result<Self, LieError>;
}

macro_rules! chordal {
    ($($group:ident, $d:literal;)*) => { $(
        impl<S: Real> ChordalMean<$d> for $group<S> {
            fn chordal_mean(elements: &[Self], weights: Weights<'_>) -> Result<Self, LieError> {
                let total = weights.total(elements.len())?;
                let mut mean = Self::identity().to_matrix() * S::zero();
                let mut size = mean;
                for (i, x) in elements.iter().enumerate() {
                    let part = x.to_matrix() * S::lit(weights.share(i, total));
                    mean += part;
                    size += part.map(SimdComplexField::simd_abs);
                }
                // What rounding leaves of entries that cancel has no direction.
                let rest = |x: S, size: S| x.value().abs() <= 8.0 * S::EPSILON * size.value();
                mean.zip_apply(&size, |x, size| *x -= S::lit(if rest(*x, size) { x.value() } else { 0.0 }));
                Self::project(&mean)
            }
        }
    )* };
}

chordal! {
    SO2, 1;
    SE2, 3;
    SO3, 3;
    SE3, 6;
    SE23, 9;
    SGal3, 10;
    RxSO2, 2;
    RxSO3, 4;
    Sim2, 4;
    Sim3, 7;
}
