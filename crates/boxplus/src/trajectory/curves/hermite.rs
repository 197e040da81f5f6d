//! Cubic Hermite segments: from one element and velocity to another.

use crate::lie::{Jacobian, LieGroup, Real, Tangent};
use crate::trajectory::chain::{self, Link, scaled_identity};
use crate::trajectory::error::{check_duration, check_finite, check_ways};
use crate::trajectory::{Motion, MotionJac, TrajectoryError};

/// A cubic Hermite segment on any group: leaves A with body velocity v_A, arrives at B with v_B after a given duration.
///
/// ```text
/// o₁ = T·v_A/3      o₃ = T·v_B/3      o₂ = Log(Exp(−o₁)·A⁻¹B·Exp(−o₃))      u = t/T
/// X(t) = A·Exp((1 − (1 − u)³)·o₁)·Exp((3u² − 2u³)·o₂)·Exp(u³·o₃)
/// ```
/// Kim, Kim & Shin (1995). It is the cubic on ℝⁿ, keeps a constant velocity constant, and is left-invariant.
///
/// ```
/// use boxplus::lie::{LieGroup, SE2};
/// use boxplus::trajectory::Hermite;
/// use nalgebra::Vector3;
/// // Park one metre to the left, starting and ending forwards at 1 m/s.
/// let (start, goal) = (SE2::identity(), SE2::exp(&Vector3::new(4.0, 1.0, 0.0)));
/// let forward = Vector3::new(1.0, 0.0, 0.0);
/// let path = Hermite::new(start, forward, goal, forward, 4.0)?;
/// let end = path.at(4.0);
/// assert!(end.value.rminus(&goal).norm() < 1e-14 && (end.velocity - forward).norm() < 1e-14);
/// # Ok::<(), boxplus::trajectory::TrajectoryError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hermite<G: LieGroup<D>, const D: usize> {
    from: G,
    velocity_from: Tangent<G::Scalar, D>,
    to: G,
    velocity_to: Tangent<G::Scalar, D>,
    duration: G::Scalar,
}

/// The derivatives of a [`Hermite`] segment in its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HermiteJac<S, const D: usize> {
    /// In A, perturbed locally.
    pub from: MotionJac<S, D>,
    /// In v_A.
    pub velocity_from: MotionJac<S, D>,
    /// In B, perturbed locally.
    pub to: MotionJac<S, D>,
    /// In v_B.
    pub velocity_to: MotionJac<S, D>,
}

impl<G: LieGroup<D>, const D: usize> Hermite<G, D> {
    /// From `from`, left with body velocity `velocity_from`, to `to`, met with `velocity_to`, in `duration`.
    ///
    /// # Errors
    /// [`TrajectoryError::NotADuration`], [`TrajectoryError::NotFinite`] (element 0 or 1), or [`TrajectoryError::Ambiguous`]
    /// where the middle exponential turns by half a turn: the velocities lead elsewhere than to `to`, or more than once
    /// around.
    pub fn new(
        from: G,
        velocity_from: Tangent<G::Scalar, D>,
        to: G,
        velocity_to: Tangent<G::Scalar, D>,
        duration: G::Scalar,
    ) -> Result<Self, TrajectoryError> {
        check_duration(duration)?;
        check_finite(&velocity_from, 0)?;
        check_finite(&velocity_to, 1)?;
        let segment = Self { from, velocity_from, to, velocity_to, duration };
        let [first, last] = segment.outer();
        check_ways(&[from.rplus(&first), to.rplus(&-last)])?;
        Ok(segment)
    }

    /// T.
    pub fn duration(&self) -> G::Scalar {
        self.duration
    }

    /// X(t) with its rates, t ∈ \[0, T\]; beyond, the same cubic continues.
    pub fn at(&self, t: G::Scalar) -> Motion<G, D> {
        let [first, last] = self.outer();
        let middle = self.to.rplus(&-last).rminus(&self.from.rplus(&first));
        chain::motion(&self.from, &self.links([first, middle, last], t))
    }

    /// X(t) with its rates: `(motion, derivatives in both ends)`. In time, they are the rates themselves.
    pub fn at_jac(&self, t: G::Scalar) -> (Motion<G, D>, HermiteJac<G::Scalar, D>) {
        let [first, last] = self.outer();
        let (left, left_from, left_first) = self.from.rplus_jac(&first);
        let (right, right_to, right_last) = self.to.rplus_jac(&-last);
        let (middle, d_right, d_left) = right.rminus_jac(&left);
        let (motion, d_base, [d_first, d_middle, d_last]) =
            chain::motion_jac(&self.from, &self.links([first, middle, last], t), 0);
        let third: Jacobian<G::Scalar, D> = scaled_identity(self.duration * G::Scalar::lit(1.0 / 3.0));

        let mut from = d_middle.chained(&(d_left * left_from));
        from.value += d_base;
        let mut velocity_from = d_first;
        velocity_from.add(&d_middle.chained(&(d_left * left_first)));
        let mut velocity_to = d_last;
        velocity_to.add(&d_middle.chained(&-(d_right * right_last)));
        let jacobian = HermiteJac {
            from,
            velocity_from: velocity_from.chained(&third),
            to: d_middle.chained(&(d_right * right_to)),
            velocity_to: velocity_to.chained(&third),
        };
        (motion, jacobian)
    }

    /// o₁ and o₃.
    fn outer(&self) -> [Tangent<G::Scalar, D>; 2] {
        let third = self.duration * G::Scalar::lit(1.0 / 3.0);
        [self.velocity_from * third, self.velocity_to * third]
    }

    fn links(&self, directions: [Tangent<G::Scalar, D>; 3], t: G::Scalar) -> [Link<G::Scalar, D>; 3] {
        let lit = G::Scalar::lit;
        let (rate, one) = (lit(1.0) / self.duration, lit(1.0));
        let (u, rate2) = (t * rate, rate * rate);
        let (v, rate3) = (one - u, rate2 * rate);
        let (three, six) = (lit(3.0), lit(6.0));
        let leave = [one - v * v * v, three * v * v * rate, -six * v * rate2, six * rate3];
        let cross =
            [u * u * (three - u - u), six * u * v * rate, (six - lit(12.0) * u) * rate2, lit(-12.0) * rate3];
        let arrive = [u * u * u, three * u * u * rate, six * u * rate2, six * rate3];
        let [first, middle, last] = directions;
        [(first, leave), (middle, cross), (last, arrive)]
            .map(|(direction, weights)| Link { direction, weights })
    }
}
