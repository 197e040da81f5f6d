//! Integration to a tolerance: steps as long as the motion allows.

use super::error::check_finite;
use super::{Integrator, TrajectoryError};
use crate::lie::{LieGroup, Real, Tangent};

/// Where an adaptive integration ended, and what it took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptive<G> {
    /// X at the end.
    pub value: G,
    /// Steps taken.
    pub steps: usize,
    /// Steps refused and tried again, shorter.
    pub refused: usize,
}

impl Integrator {
    /// X(t + `duration`) from X(t), body form, with an error of at most `tolerance` per step in every coordinate of the
    /// tangent.
    ///
    /// Each step is made once and again in two halves; the halves are kept, and their distance over 2ᵖ − 1 estimates their
    /// error (Richardson). It sizes the next step, h ← 0.9·h·(tolerance/error)^{1/(p+1)}, changed at most fivefold. The
    /// error at the end is about the tolerance times the number of steps. Metres and radians share one tolerance: scale f's
    /// units to taste. A negative duration goes back in time. Pitfall: what happens between the nodes of a step is not seen;
    /// stop at known events and start anew. For single numbers: the steps depend on the values.
    ///
    /// # Errors
    /// [`TrajectoryError::NotATolerance`], [`TrajectoryError::NotFinite`] for a bad start (0), time (1) or
    /// duration (2), [`TrajectoryError::StepTooSmall`] where f is not finite, or jumps by more than the tolerance allows.
    ///
    /// ```
    /// use boxplus::lie::{LieGroup, SO3};
    /// use boxplus::trajectory::Integrator;
    /// use nalgebra::Vector3;
    /// // Calm, but for a knock at t = 5.
    /// let gyro = |t: f64, _: &SO3| Vector3::new(0.1 * t.cos(), 4.0 * (-20.0 * (t - 5.0).powi(2)).exp(), 0.0);
    /// let end = Integrator::CommutatorFree4.integrate_adaptive(&SO3::identity(), 0.0, 10.0, 1e-9, gyro)?;
    /// let fine = Integrator::CommutatorFree4.integrate(&SO3::identity(), 0.0, 10.0, 20_000, gyro);
    /// assert!(end.value.rminus(&fine).norm() < 1e-7 && end.steps < 200);
    /// # Ok::<(), boxplus::trajectory::TrajectoryError>(())
    /// ```
    pub fn integrate_adaptive<G: LieGroup<D>, const D: usize>(
        self,
        x: &G,
        t: G::Scalar,
        duration: G::Scalar,
        tolerance: f64,
        f: impl Fn(G::Scalar, &G) -> Tangent<G::Scalar, D>,
    ) -> Result<Adaptive<G>, TrajectoryError> {
        check_finite(&x.log(), 0)?;
        if let Some(k) = [t, duration].iter().position(|number| !number.value().is_finite()) {
            return Err(TrajectoryError::NotFinite { index: k + 1 });
        }
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            return Err(TrajectoryError::NotATolerance { tolerance });
        }
        let mut report = Adaptive { value: *x, steps: 0, refused: 0 };
        let (mut done, mut h) = (G::Scalar::lit(0.0), duration);
        while (duration - done).value() != 0.0 {
            let left = duration - done;
            let last = h.value().abs() >= left.value().abs();
            if last {
                h = left;
            }
            let (next, error) = self.halved_step(&report.value, t + done, h, &f);
            if error <= tolerance {
                report = Adaptive { value: next, steps: report.steps + 1, ..report };
                done = if last { duration } else { done + h };
            } else {
                report.refused += 1;
            }
            h *= self.growth::<G::Scalar>(tolerance / error);
            if (t + done + h).value() == (t + done).value() && (duration - done).value() != 0.0 {
                return Err(TrajectoryError::StepTooSmall { time: (t + done).value() });
            }
        }
        Ok(report)
    }

    /// A step in two halves, and the estimate of its largest error.
    fn halved_step<G: LieGroup<D>, const D: usize>(
        self,
        x: &G,
        t: G::Scalar,
        h: G::Scalar,
        f: impl Fn(G::Scalar, &G) -> Tangent<G::Scalar, D>,
    ) -> (G, f64) {
        let half = h * G::Scalar::lit(0.5);
        let fine = self.step(&self.step(x, t, half, &f), t + half, half, &f);
        let gap = fine.rminus(&self.step(x, t, h, &f));
        // Not `f64::max`, which would drop a NaN.
        let largest = gap.iter().map(|e| e.value().abs()).fold(0.0, |a, b| if b <= a { a } else { b });
        (fine, largest / f64::from((1 << self.order()) - 1))
    }

    /// 0.9·ratio^{1/(p+1)} between 1/5 and 5; a NaN shrinks the step.
    fn growth<S: Real>(self, ratio: f64) -> S {
        // Below the fifth power of five nothing changes the answer.
        let bounded = if ratio > 0.0 { ratio.min(1e9) } else { 0.0 };
        let exponent = S::lit(1.0 / f64::from(self.order() + 1));
        let factor = (S::lit(bounded).simd_powf(exponent) * S::lit(0.9)).value();
        S::lit(factor.clamp(0.2, 5.0))
    }
}
