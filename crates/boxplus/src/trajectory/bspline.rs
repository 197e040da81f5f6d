//! Cumulative B-splines of any order over any group.
//!
//! ```text
//! X(u) = Xᵢ·Π_{j=1}^{K−1} Exp(λ_j(u)·d_j)      d_j = X_{i+j} ⊖ X_{i+j−1}      u = (t − tᵢ)/Δ ∈ [0, 1)
//! λ(u) = M̃·(1, u, …, u^{K−1})ᵀ                 M̃_j = Σ_{s≥j} M_s
//! M_{s,n} = C(K−1, n)/(K−1)!·Σ_{l=s}^{K−1} (−1)^{l−s}·C(K, l−s)·(K−1−l)^{K−1−n}
//! ```
//! Kim, Kim & Shin (1995); Sommer et al. (2020), whose recursion gives rates in O(K); M from Qin (2000). Rates and
//! derivatives in the control elements: the [`Motion`] product rule and its differential.
//!
//! What to expect of it:
//! - **Order** K is the number of control elements that act at one time; degree K − 1, C^{K−2} across knots. K = 4 is the
//!   cubic: continuous acceleration, what an inertial sensor needs. K = 2 is the geodesic polygon.
//! - **It passes near its control elements, not through them** (for K ≥ 3); [`super::CatmullRom`] passes through.
//! - **Ends**: knots are uniform and none is repeated. N control elements give N − K + 1 intervals, \[t₀, t₀ + (N − K +
//!   1)·Δ\], and outside no value but an error. The curve starts near element (K − 2)/2, e.g. near the second for a cubic.
//!   Repeat the outermost element K − 1 times to start exactly there, at rest.
//! - **Not bi-invariant**: moving all control elements from the left moves the curve along; from the right it does not.
//! - **Precision of time**: t − t₀ is what counts; subtract an epoch of 10⁹ s before it reaches a float.

use super::chain::{self, Link};
use super::error::{check_duration, check_ways};
use super::{Motion, MotionJac, TrajectoryError};
use crate::lie::{LieGroup, Real};

/// A cumulative B-spline of order K with uniform knots, over borrowed control elements.
///
/// ```
/// use boxplus::lie::{LieGroup, SE3};
/// use boxplus::trajectory::BSpline;
/// use nalgebra::Vector6;
/// let step = Vector6::new(1.0, 0.0, 0.0, 0.0, 0.0, 0.5);
/// let controls: Vec<SE3> = (0..8).map(|i| SE3::exp(&(step * f64::from(i)))).collect();
/// let spline = BSpline::<_, 6, 4>::new(&controls, 0.0, 0.1)?; // cubic, knots 0.1 s apart
/// assert_eq!(spline.end(), 0.5);
/// let now = spline.at(0.23)?;
/// assert!((now.velocity - step * 10.0).norm() < 1e-12); // one control element per 0.1 s
/// assert!(now.acceleration.norm() < 1e-11);
/// # Ok::<(), boxplus::trajectory::TrajectoryError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BSpline<'a, G: LieGroup<D>, const D: usize, const K: usize> {
    controls: &'a [G],
    start: G::Scalar,
    interval: G::Scalar,
}

impl<'a, G: LieGroup<D>, const D: usize, const K: usize> BSpline<'a, G, D, K> {
    /// The spline of `controls`, at least K, which starts at the time `start` and has a knot every `interval`.
    ///
    /// # Errors
    /// [`TrajectoryError::NotADuration`], [`TrajectoryError::TooFew`], [`TrajectoryError::NotFinite`] (`start` or a control
    /// element), or [`TrajectoryError::Ambiguous`] where neighbours are half a turn apart.
    pub fn new(controls: &'a [G], start: G::Scalar, interval: G::Scalar) -> Result<Self, TrajectoryError> {
        const { assert!(0 < K && K <= 16, "a B-spline has an order from 1 to 16") };
        check_duration(interval)?;
        if !start.value().is_finite() {
            return Err(TrajectoryError::NotFinite { index: 0 });
        }
        if controls.len() < K {
            return Err(TrajectoryError::TooFew { got: controls.len(), needed: K });
        }
        check_ways(controls)?;
        Ok(Self { controls, start, interval })
    }

    /// Where the spline begins.
    pub fn start(&self) -> G::Scalar {
        self.start
    }

    /// Where the spline ends: start + (N − K + 1)·interval.
    pub fn end(&self) -> G::Scalar {
        self.start + self.interval * G::Scalar::lit((self.controls.len() - K + 1) as f64)
    }

    /// X(t) with its rates.
    ///
    /// # Errors
    /// [`TrajectoryError::OutOfRange`].
    pub fn at(&self, t: G::Scalar) -> Result<Motion<G, D>, TrajectoryError> {
        let (i, u) = self.locate(t)?;
        Ok(segment(&self.local(i), u, self.rate()))
    }

    /// X(t) with its rates: `(motion, i, d_motion_d_control)`, the latter in control elements i, …, i + K − 1; no other acts
    /// at t.
    ///
    /// # Errors
    /// [`TrajectoryError::OutOfRange`].
    pub fn at_jac(&self, t: G::Scalar) -> Result<SplineJac<G, D, K>, TrajectoryError> {
        let (i, u) = self.locate(t)?;
        let (motion, jacobians) = segment_jac(&self.local(i), u, self.rate());
        Ok((motion, i, jacobians))
    }

    /// The interval of t and the place u in it; the end belongs to the last interval.
    fn locate(&self, t: G::Scalar) -> Result<(usize, G::Scalar), TrajectoryError> {
        let (time, start, end) = (t.value(), self.start.value(), self.end().value());
        if !(time >= start && time <= end) {
            return Err(TrajectoryError::OutOfRange { time, start, end });
        }
        let place = (t - self.start) / self.interval;
        #[expect(clippy::cast_sign_loss, reason = "not before the start")]
        let i = (place.value() as usize).min(self.controls.len() - K);
        Ok((i, place - G::Scalar::lit(i as f64)))
    }

    fn local(&self, i: usize) -> [&'a G; K] {
        core::array::from_fn(|j| &self.controls[i + j])
    }

    /// Intervals per unit of time.
    fn rate(&self) -> G::Scalar {
        G::Scalar::lit(1.0) / self.interval
    }
}

/// The motion at the place u ∈ \[0, 1\] of an interval, of which `rate` pass per unit of time.
pub(crate) fn segment<G: LieGroup<D>, const D: usize, const K: usize>(
    controls: &[&G; K],
    u: G::Scalar,
    rate: G::Scalar,
) -> Motion<G, D> {
    chain::motion(controls[0], &links(controls, u, rate)[1..])
}

/// [`segment`] with its derivatives in the control elements.
pub(crate) fn segment_jac<G: LieGroup<D>, const D: usize, const K: usize>(
    controls: &[&G; K],
    u: G::Scalar,
    rate: G::Scalar,
) -> (Motion<G, D>, [MotionJac<G::Scalar, D>; K]) {
    let (motion, d_base, d_links) = chain::motion_jac(controls[0], &links(controls, u, rate), 1);
    let mut jacobians = [MotionJac::zero(); K];
    jacobians[0].value = d_base;
    for j in 1..K {
        let (_, d_to, d_from) = controls[j].rminus_jac(controls[j - 1]);
        jacobians[j].add(&d_links[j].chained(&d_to));
        jacobians[j - 1].add(&d_links[j].chained(&d_from));
    }
    (motion, jacobians)
}

/// d_j and λ_j with its derivatives in time. The first stands for X_i itself and is left out of the chain.
fn links<G: LieGroup<D>, const D: usize, const K: usize>(
    controls: &[&G; K],
    u: G::Scalar,
    rate: G::Scalar,
) -> [Link<G::Scalar, D>; K] {
    core::array::from_fn(|j| {
        let before = controls[j.saturating_sub(1)];
        Link { direction: controls[j].rminus(before), weights: weight::<G::Scalar, K>(j, u, rate) }
    })
}

/// A motion, the index of the first control element that acts, and derivatives in the K that do.
pub type SplineJac<G, const D: usize, const K: usize> =
    (Motion<G, D>, usize, [MotionJac<<G as LieGroup<D>>::Scalar, D>; K]);

/// \[λ_j, λ̇_j, λ̈_j, λ⃛_j\] at u, where u grows by `rate` per unit of time: Horner's scheme with its derivatives.
fn weight<S: Real, const K: usize>(j: usize, u: S, rate: S) -> [S; 4] {
    let row = const { cumulative_matrix::<K>() }[j];
    let mut taylor = [S::lit(0.0); 4];
    for coefficient in row.iter().rev() {
        for order in (1..4).rev() {
            taylor[order] = taylor[order] * u + taylor[order - 1];
        }
        taylor[0] = taylor[0] * u + S::lit(*coefficient);
    }
    let rate2 = rate * rate;
    let factors = [S::lit(1.0), rate, rate2 * S::lit(2.0), rate2 * rate * S::lit(6.0)];
    core::array::from_fn(|order| taylor[order] * factors[order])
}

/// M̃, K×K: row j holds the coefficients of λ_j in powers of u. Exact integers over (K − 1)!, divided once.
const fn cumulative_matrix<const K: usize>() -> [[f64; K]; K] {
    let mut matrix = [[0.0; K]; K];
    let mut factorial = 1;
    let mut k = 2;
    while k < K {
        factorial *= k as i128;
        k += 1;
    }
    let mut n = 0;
    while n < K {
        // Summed from the last row up: M̃_j = M̃_{j+1} + M_j.
        let (mut sum, mut s) = (0, K);
        while s > 0 {
            s -= 1;
            sum += basis_numerator::<K>(s, n);
            matrix[s][n] = sum as f64 / factorial as f64;
        }
        n += 1;
    }
    matrix
}

/// (K − 1)!·M_{s,n}, an integer.
const fn basis_numerator<const K: usize>(s: usize, n: usize) -> i128 {
    let (mut sum, mut l) = (0, s);
    while l < K {
        let sign = if (l - s).is_multiple_of(2) { 1 } else { -1 };
        sum += sign * binomial(K, l - s) * ((K - 1 - l) as i128).pow((K - 1 - n) as u32);
        l += 1;
    }
    binomial(K - 1, n) * sum
}

const fn binomial(n: usize, k: usize) -> i128 {
    let (mut product, mut i) = (1, 0);
    while i < k {
        product = product * (n - i) as i128 / (i + 1) as i128;
        i += 1;
    }
    product
}
