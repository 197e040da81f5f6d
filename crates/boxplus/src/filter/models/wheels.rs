//! Odometry of a robot on two driven wheels.

use crate::filter::Motion;
use crate::lie::{LieGroup, Real, SE2};
use crate::uncertainty::Covariance;
use nalgebra::{Matrix3, Vector3};

/// How far each wheel rolled during a step, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelTravel<S = f64> {
    /// The left wheel.
    pub left: S,
    /// The right wheel.
    pub right: S,
}

/// A differential drive: x⁺ = x·Exp((l + r)/2, s, (r − l)/b), an arc, exactly.
///
/// w = (error of l, error of r, side slip s), 3. Variances grow with the way: σ² = k²·|way|, so that the uncertainty of a drive
/// does not depend on how finely it is sampled.
///
/// ```
/// use boxplus::filter::{DifferentialDrive, Ekf, Filter, WheelTravel};
/// use boxplus::lie::{LieGroup, SE2};
/// use boxplus::uncertainty::Gaussian;
/// let robot = DifferentialDrive { track: 0.5, rolling: 0.02, slip: 0.005 };
/// let mut belief = Gaussian::<SE2, 3>::certain(SE2::identity());
/// for _ in 0..10 {
///     belief = Ekf::default().predict(&belief, &robot, &WheelTravel { left: 0.1, right: 0.12 })?;
/// }
/// assert!((belief.mean().angle() - 0.4).abs() < 1e-12);
/// # Ok::<(), boxplus::filter::FilterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DifferentialDrive<S = f64> {
    /// b, the distance between the wheels, in metres.
    pub track: S,
    /// Error of a wheel, in metres per √metre it rolled.
    pub rolling: S,
    /// Side slip, in metres per √metre driven.
    pub slip: S,
}

impl<S: Real> DifferentialDrive<S> {
    /// ∂(tangent)/∂(l, r, s).
    fn kinematics(&self) -> Matrix3<S> {
        let (half, turn, o) = (S::lit(0.5), S::one() / self.track, S::zero());
        Matrix3::new(half, half, o, o, o, S::one(), -turn, turn, o)
    }
}

impl<S: Real> Motion<SE2<S>, 3, 3> for DifferentialDrive<S> {
    type Input = WheelTravel<S>;

    fn step(&self, x: &SE2<S>, travel: &WheelTravel<S>, w: &Vector3<S>) -> SE2<S> {
        let rolled = Vector3::new(travel.left, travel.right, S::zero()) + w;
        x.rplus(&(self.kinematics() * rolled))
    }
    fn noise(&self, travel: &WheelTravel<S>) -> Covariance<3, S> {
        let root = |way: S| way.simd_abs().simd_sqrt();
        Covariance::independent(&Vector3::new(
            self.rolling * root(travel.left),
            self.rolling * root(travel.right),
            self.slip * root((travel.left + travel.right) * S::lit(0.5)),
        ))
    }
    fn step_jac(&self, x: &SE2<S>, travel: &WheelTravel<S>) -> (SE2<S>, Matrix3<S>, Matrix3<S>) {
        let kinematics = self.kinematics();
        let rolled = Vector3::new(travel.left, travel.right, S::zero());
        let (next, d_x, d_tau) = x.rplus_jac(&(kinematics * rolled));
        (next, d_x, d_tau * kinematics)
    }
}
