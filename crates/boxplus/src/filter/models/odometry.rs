//! Steps in the frame of the body, on any group.

use crate::filter::Motion;
use crate::lie::{Jacobian, LieGroup, Tangent};
use crate::uncertainty::Covariance;

/// Odometry: x⁺ = x·Exp(u + w), a step u ∈ ℝᴰ in the frame of the body, w ~ N(0, Q). Solà et al. (2018) (87).
///
/// F = Ad_{Exp u}⁻¹, G = J_r(u); on the left F = I: the global error of dead reckoning does not move at all, it only grows.
///
/// On SE(2) and SE(3) wheels or a camera give u; on SO(3) a gyroscope does, u = ωΔ.
///
/// ```
/// use boxplus::filter::{Ekf, Filter, Odometry};
/// use boxplus::lie::{LieGroup, SE3};
/// use boxplus::uncertainty::{Covariance, Gaussian};
/// use nalgebra::{Vector6, vector};
/// let odometry = Odometry { noise: Covariance::from_sigmas(&Vector6::repeat(0.01))? };
/// let start = Gaussian::<SE3, 6>::certain(SE3::identity());
/// let end = Ekf::default().predict(&start, &odometry, &vector![1.0, 0.0, 0.0, 0.0, 0.0, 0.1])?;
/// assert!(end.sigmas()[0] > 0.0099);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Odometry<const D: usize, S = f64> {
    /// Q of one step, D×D, in the units of the tangent.
    pub noise: Covariance<D, S>,
}

impl<G: LieGroup<D>, const D: usize> Motion<G, D, D> for Odometry<D, G::Scalar> {
    type Input = Tangent<G::Scalar, D>;

    fn step(&self, x: &G, input: &Self::Input, noise: &Tangent<G::Scalar, D>) -> G {
        x.rplus(&(input + noise))
    }
    fn noise(&self, _: &Self::Input) -> Covariance<D, G::Scalar> {
        self.noise
    }
    fn step_jac(&self, x: &G, input: &Self::Input) -> (G, Jacobian<G::Scalar, D>, Jacobian<G::Scalar, D>) {
        x.rplus_jac(input)
    }
    fn step_left_jac(
        &self,
        x: &G,
        input: &Self::Input,
    ) -> (G, Jacobian<G::Scalar, D>, Jacobian<G::Scalar, D>) {
        // Exp(τ)·x·Exp(u): the error stays where it is.
        let (next, _, d_u) = x.rplus_jac(input);
        (next, Jacobian::identity(), next.adjoint() * d_u)
    }
}
