//! A C¹ path through elements at given times.

use super::hermite::Hermite;
use crate::lie::{Jacobian, LieGroup, Real, Tangent};
use crate::trajectory::chain::scaled_identity;
use crate::trajectory::error::{check_duration, check_ways};
use crate::trajectory::{Motion, MotionJac, TrajectoryError};

/// The path through given elements at given times, by cubic Hermite segments with velocities from the neighbours.
///
/// ```text
/// δ₋ = Xᵢ ⊖ Xᵢ₋₁ over h₋      δ₊ = Xᵢ₊₁ ⊖ Xᵢ over h₊      vᵢ = (h₊·δ₋/h₋ + h₋·δ₊/h₊)/(h₋ + h₊)
/// ```
/// Catmull & Rom (1974) in the non-uniform form: on ℝⁿ vᵢ is the slope of the parabola through three points. At both ends the
/// velocity is that of the outer geodesic. C¹, local (an element moves four segments), left-invariant, exact for constant
/// velocity.
///
/// ```
/// use boxplus::lie::{LieGroup, SE3};
/// use boxplus::trajectory::CatmullRom;
/// use nalgebra::Vector6;
/// let step = Vector6::new(1.0, 0.0, 0.0, 0.0, 0.0, 0.5); // forward 1 m, turning left by 0.5 rad
/// let times = [0.0, 1.0, 3.0, 4.0];
/// let poses = times.map(|t| SE3::exp(&(step * t)));
/// let now = CatmullRom::new(&poses, &times)?.at(2.5)?;
/// assert!((now.velocity - step).norm() < 1e-14 && now.value.rminus(&SE3::exp(&(step * 2.5))).norm() < 1e-14);
/// # Ok::<(), boxplus::trajectory::TrajectoryError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CatmullRom<'a, G: LieGroup<D>, const D: usize> {
    elements: &'a [G],
    times: &'a [G::Scalar],
}

impl<'a, G: LieGroup<D>, const D: usize> CatmullRom<'a, G, D> {
    /// The path that is at `elements[i]` at `times[i]`; two elements at least.
    ///
    /// # Errors
    /// [`TrajectoryError::CountsDiffer`], [`TrajectoryError::TooFew`], [`TrajectoryError::NotIncreasing`],
    /// [`TrajectoryError::NotFinite`], or [`TrajectoryError::Ambiguous`] where neighbours are half a turn apart.
    pub fn new(elements: &'a [G], times: &'a [G::Scalar]) -> Result<Self, TrajectoryError> {
        if elements.len() != times.len() {
            return Err(TrajectoryError::CountsDiffer { elements: elements.len(), times: times.len() });
        }
        if elements.len() < 2 {
            return Err(TrajectoryError::TooFew { got: elements.len(), needed: 2 });
        }
        if let Some(index) = times.iter().position(|t| !t.value().is_finite()) {
            return Err(TrajectoryError::NotFinite { index });
        }
        if let Some(index) = times.windows(2).position(|pair| pair[1].value() <= pair[0].value()) {
            return Err(TrajectoryError::NotIncreasing { index: index + 1 });
        }
        check_ways(elements)?;
        Ok(Self { elements, times })
    }

    /// X(t) with its rates.
    ///
    /// # Errors
    /// [`TrajectoryError::OutOfRange`], or those of [`Hermite::new`].
    pub fn at(&self, t: G::Scalar) -> Result<Motion<G, D>, TrajectoryError> {
        let i = self.segment(t)?;
        Ok(self.hermite(i)?.at(t - self.times[i]))
    }

    /// X(t) with its rates: `(motion, i, d_motion_d_element)`, the latter in elements i − 1, …, i + 2 (zero where there is
    /// none), where i begins the segment of t.
    ///
    /// # Errors
    /// [`TrajectoryError::OutOfRange`], or those of [`Hermite::new`].
    pub fn at_jac(&self, t: G::Scalar) -> Result<PathJac<G, D>, TrajectoryError> {
        let i = self.segment(t)?;
        let (motion, d) = self.hermite(i)?.at_jac(t - self.times[i]);
        let mut jacobians = [MotionJac::zero(), d.from, d.to, MotionJac::zero()];
        for (first, d_velocity) in [(0, d.velocity_from), (1, d.velocity_to)] {
            for (k, inner) in self.velocity_jac(i + first).iter().enumerate() {
                jacobians[first + k].add(&d_velocity.chained(inner));
            }
        }
        Ok((motion, i, jacobians))
    }

    fn segment(&self, t: G::Scalar) -> Result<usize, TrajectoryError> {
        let (first, last) = (self.times[0].value(), self.times[self.times.len() - 1].value());
        let time = t.value();
        if !(time >= first && time <= last) {
            return Err(TrajectoryError::OutOfRange { time, start: first, end: last });
        }
        let inner = &self.times[1..self.times.len() - 1];
        Ok(inner.partition_point(|knot| knot.value() <= time))
    }

    fn hermite(&self, i: usize) -> Result<Hermite<G, D>, TrajectoryError> {
        let duration = check_duration(self.times[i + 1] - self.times[i])?;
        let (from, to) = (self.velocity(i), self.velocity(i + 1));
        Hermite::new(self.elements[i], from, self.elements[i + 1], to, duration).map_err(
            |error| match error {
                TrajectoryError::Ambiguous { .. } => TrajectoryError::Ambiguous { segment: i },
                other => other,
            },
        )
    }

    /// vᵢ.
    fn velocity(&self, i: usize) -> Tangent<G::Scalar, D> {
        let [before, after] = self.slopes(i);
        let way = |k: usize| self.elements[k + 1].rminus(&self.elements[k]);
        let mut velocity = Tangent::<G::Scalar, D>::zeros();
        if i > 0 {
            velocity += way(i - 1) * before;
        }
        if i + 1 < self.elements.len() {
            velocity += way(i) * after;
        }
        velocity
    }

    /// ∂vᵢ in elements i − 1, i, i + 1.
    fn velocity_jac(&self, i: usize) -> [Jacobian<G::Scalar, D>; 3] {
        let [before, after] = self.slopes(i).map(scaled_identity::<G::Scalar, D>);
        let way = |k: usize| self.elements[k + 1].rminus_jac(&self.elements[k]);
        let mut jacobians = [Jacobian::<G::Scalar, D>::zeros(); 3];
        if i > 0 {
            let (_, d_here, d_before) = way(i - 1);
            jacobians[0] = before * d_before;
            jacobians[1] = before * d_here;
        }
        if i + 1 < self.elements.len() {
            let (_, d_after, d_here) = way(i);
            jacobians[1] += after * d_here;
            jacobians[2] = after * d_after;
        }
        jacobians
    }

    /// What δ₋ and δ₊ are multiplied with in vᵢ.
    fn slopes(&self, i: usize) -> [G::Scalar; 2] {
        let (zero, last) = (G::Scalar::lit(0.0), self.times.len() - 1);
        let span = |k: usize| self.times[k + 1] - self.times[k];
        let one = G::Scalar::lit(1.0);
        if i == 0 {
            [zero, one / span(0)]
        } else if i == last {
            [one / span(last - 1), zero]
        } else {
            let (before, after) = (span(i - 1), span(i));
            let total = before + after;
            [after / (before * total), before / (after * total)]
        }
    }
}

/// A motion, the index of the element that begins its segment, and derivatives in the elements around it.
pub type PathJac<G, const D: usize> = (Motion<G, D>, usize, [MotionJac<<G as LieGroup<D>>::Scalar, D>; 4]);
