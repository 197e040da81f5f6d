//! An uncertain element of a group: mean, covariance, side.

use super::{Covariance, Global, Local, Side, UncertaintyError};
use crate::lie::{LieGroup, Real, Tangent};
use core::marker::PhantomData;
use nalgebra::SMatrix;

/// A concentrated Gaussian on a group: X = X̄·Exp(ξ) (`Local`) or Exp(ξ)·X̄ (`Global`), ξ ~ N(0, Σ).
///
/// Solà et al. (2018) (51)–(53), Barfoot (2024) (8.37), (8.38). Points and other vectors are Gaussians of
/// [`Rn`](crate::lie::Rn).
///
/// ```
/// use boxplus::lie::{LieGroup, SE2};
/// use boxplus::uncertainty::{Covariance, Gaussian, Order};
/// use nalgebra::vector;
/// let sigmas = Covariance::from_sigmas(&vector![0.1, 0.05, 0.02])?; // metres, metres, radians
/// let step = Gaussian::<SE2, 3>::new(SE2::new(vector![1.0, 0.0], 0.3), sigmas);
/// let twice = step.compose(&step, Order::Second);
/// assert!(twice.sigmas()[1] > step.sigmas()[1]);
/// // The same statement in the frame of the world, and back: exact.
/// let back = twice.to_global().to_local();
/// assert!((back.covariance().matrix() - twice.covariance().matrix()).amax() < 1e-16);
/// # Ok::<(), boxplus::uncertainty::UncertaintyError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaussian<G: LieGroup<D>, const D: usize, E: Side = Local> {
    mean: G,
    covariance: Covariance<D, G::Scalar>,
    side: PhantomData<E>,
}

impl<G: LieGroup<D>, const D: usize, E: Side> Gaussian<G, D, E> {
    /// From a mean and the covariance of its error on the side `E`, in the units of the tangent, squared.
    pub fn new(mean: G, covariance: Covariance<D, G::Scalar>) -> Self {
        Self { mean, covariance, side: PhantomData }
    }

    /// An element known exactly.
    pub fn certain(mean: G) -> Self {
        Self::new(mean, Covariance::zero())
    }

    /// Independent errors with the given standard deviations, in the units of the tangent; 0 is allowed.
    ///
    /// # Errors
    /// [`UncertaintyError::InvalidSigma`].
    pub fn from_sigmas(mean: G, sigmas: &Tangent<G::Scalar, D>) -> Result<Self, UncertaintyError> {
        Ok(Self::new(mean, Covariance::from_sigmas(sigmas)?))
    }

    /// From the information matrix Ω = Σ⁻¹, D×D, of the error on the side `E`.
    ///
    /// # Errors
    /// Those of [`Covariance::from_information`].
    pub fn from_information(
        mean: G,
        information: &SMatrix<G::Scalar, D, D>,
    ) -> Result<Self, UncertaintyError> {
        Ok(Self::new(mean, Covariance::from_information(information)?))
    }

    /// X̄.
    pub fn mean(&self) -> &G {
        &self.mean
    }

    /// Σ of the error on the side `E`.
    pub fn covariance(&self) -> &Covariance<D, G::Scalar> {
        &self.covariance
    }

    /// The standard deviation of each coordinate of the error.
    pub fn sigmas(&self) -> Tangent<G::Scalar, D> {
        self.covariance.sigmas()
    }

    /// The error of `x`: Log(X̄⁻¹x) or Log(xX̄⁻¹).
    pub fn error_of(&self, x: &G) -> Tangent<G::Scalar, D> {
        E::error(x, &self.mean)
    }

    /// The element with the error ξ.
    pub fn perturbed(&self, xi: &Tangent<G::Scalar, D>) -> G {
        E::perturb(&self.mean, xi)
    }

    /// The same random element, its error on the other side: Ad Σ Adᵀ, exactly. Solà et al. (2018) (54).
    pub fn to_opposite(&self) -> Gaussian<G, D, E::Opposite> {
        Gaussian::new(self.mean, self.covariance.transformed(&E::to_opposite(&self.mean)))
    }

    /// X⁻¹: exact, whatever the size of Σ. Barfoot (2024) (8.38); local AΣAᵀ with A = Ad_X̄, global with A = Ad_X̄⁻¹, on *both*
    /// sides of Σ.
    pub fn inverse(&self) -> Self {
        let moved = self.covariance.transformed(&E::under_inverse(&self.mean));
        Self::new(self.mean.inverse(), moved)
    }

    /// Frame change on the left, A·X with A = `new_from_old` known: exact. The local covariance stays as it is.
    ///
    /// The world is given another origin, `new_world_from_body = new_from_old * world_from_body`.
    pub fn change_parent(&self, new_from_old: &G) -> Self {
        let moved = self.covariance.transformed(&E::under_left_factor(new_from_old));
        Self::new(new_from_old.compose(&self.mean), moved)
    }

    /// Frame change on the right, X·B with B = `body_from_sensor` known: exact. The global covariance stays as it is.
    ///
    /// The same error, told of another point of a rigid body: Σ ← Ad_B⁻¹ Σ Ad_B⁻ᵀ on the local side. This is not what
    /// follows a correction, see [`Gaussian::reset`].
    pub fn change_body(&self, body_from_sensor: &G) -> Self {
        let moved = self.covariance.transformed(&E::under_right_factor(body_from_sensor));
        Self::new(self.mean.compose(body_from_sensor), moved)
    }

    /// Reset: an error ξ ~ N(θ, Σ) about X̄ told about the mean moved by θ, where it is N(0, JΣJᵀ), J = J_r(θ) local, J_l(θ)
    /// global. Mueller, Hehn & D'Andrea (2017).
    ///
    /// This is what follows the correction of a filter, which finds a mean error θ. To first order in the spread; θ may
    /// be large.
    pub fn reset(&self, theta: &Tangent<G::Scalar, D>) -> Self {
        Self::new(self.perturbed(theta), self.covariance.transformed(&E::jacobian::<G, D>(theta)))
    }

    /// Parallel transport of Σ along the one-parameter subgroup from X̄ to the mean moved by θ: Ad_{Exp(∓θ/2)}, − local, +
    /// global. Ge, van Goor & Mahony (2023) on SO(3).
    ///
    /// The transport of the symmetric Cartan connection; on groups with a bi-invariant metric (SO(2), SO(3), ℝⁿ) that of
    /// Levi-Civita, which turns vectors without stretching them. It says where the *axes* of an ellipsoid go. No change
    /// of coordinates of a random variable is a transport: use [`Gaussian::reset`] or [`Gaussian::change_body`] for those.
    pub fn transport(&self, theta: &Tangent<G::Scalar, D>) -> Self {
        let half = G::exp(&(theta * G::Scalar::lit(0.5)));
        // Local: Ad of Exp(−θ/2); global: Ad of Exp(θ/2), each a known factor on the side's own far end.
        let turned = E::under_left_factor(&half) * E::under_right_factor(&half);
        Self::new(self.perturbed(theta), self.covariance.transformed(&turned))
    }
}

impl<G: LieGroup<D>, const D: usize> Gaussian<G, D, Local> {
    /// The same random element, its error in the frame of the parent.
    pub fn to_global(&self) -> Gaussian<G, D, Global> {
        self.to_opposite()
    }
}

impl<G: LieGroup<D>, const D: usize> Gaussian<G, D, Global> {
    /// The same random element, its error in the frame of the body.
    pub fn to_local(&self) -> Gaussian<G, D, Local> {
        self.to_opposite()
    }
}
