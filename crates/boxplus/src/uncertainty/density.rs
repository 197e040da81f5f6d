//! How likely, how far, how different.
//!
//! Two densities go by one name. The *Haar* density is that of the random element X̄·Exp(ξ) itself, with respect to the
//! invariant measure: it carries the factor |det J(ξ)|⁻¹ by which Exp stretches volume. The *tangent* density is that of ξ,
//! which many texts call the concentrated Gaussian. They differ by a term of order Σ, enough to bias a likelihood ratio; the
//! functions are named apart.

use super::{Gaussian, Side, UncertaintyError, linear};
use crate::lie::{LieGroup, Real};
use nalgebra::SimdComplexField;

impl<G: LieGroup<D>, const D: usize, E: Side> Gaussian<G, D, E> {
    /// ξᵀΣ⁻¹ξ of the error ξ of `x`; the same on both sides. For a true Σ it is χ² with D degrees of freedom.
    ///
    /// # Errors
    /// [`UncertaintyError::Singular`].
    pub fn mahalanobis_squared(&self, x: &G) -> Result<G::Scalar, UncertaintyError> {
        self.covariance().mahalanobis_squared(&self.error_of(x))
    }

    /// ln p of the error ξ of `x` in the tangent space, −½(ξᵀΣ⁻¹ξ + ln det Σ + D ln 2π): without the Haar factor.
    ///
    /// # Errors
    /// [`UncertaintyError::Singular`].
    pub fn tangent_log_density(&self, x: &G) -> Result<G::Scalar, UncertaintyError> {
        let constant = G::Scalar::lit(D as f64 * core::f64::consts::TAU.simd_ln());
        let sum = self.mahalanobis_squared(x)? + self.covariance().log_determinant()? + constant;
        Ok(sum * G::Scalar::lit(-0.5))
    }

    /// ln p of `x` with respect to Haar measure: [`Gaussian::tangent_log_density`] − ln|det J(ξ)|.
    ///
    /// J = J_r and the left-invariant measure for local errors, J_l and the right-invariant one for global; on all groups
    /// here but those with a scale (Sim(2), Sim(3)) both measures are one. det J_r = 2c₂(θ²) on SO(3) and SE(2), its square on
    /// SE(3). The branch of the logarithm is the shortest: right while errors stay below half a turn.
    ///
    /// ```
    /// use boxplus::lie::{LieGroup, SO3};
    /// use boxplus::uncertainty::Gaussian;
    /// use nalgebra::vector;
    /// let g = Gaussian::<SO3, 3>::from_sigmas(SO3::identity(), &vector![0.3, 0.3, 0.3])?;
    /// let theta: f64 = 0.5;
    /// let x = SO3::exp(&vector![0.0, 0.0, theta]);
    /// let factor = 2.0 * (1.0 - theta.cos()) / (theta * theta);
    /// let difference = g.haar_log_density(&x)? - g.tangent_log_density(&x)?;
    /// assert!((difference + factor.ln()).abs() < 1e-14);
    /// # Ok::<(), boxplus::uncertainty::UncertaintyError>(())
    /// ```
    ///
    /// # Errors
    /// [`UncertaintyError::Singular`].
    pub fn haar_log_density(&self, x: &G) -> Result<G::Scalar, UncertaintyError> {
        let jacobian = E::jacobian::<G, D>(&self.error_of(x));
        Ok(self.tangent_log_density(x)? - linear::log_abs_determinant(jacobian))
    }

    /// Entropy of the error in the tangent space, ½ ln det(2πeΣ), in nats: without the Haar factor.
    ///
    /// # Errors
    /// [`UncertaintyError::Singular`].
    pub fn tangent_entropy(&self) -> Result<G::Scalar, UncertaintyError> {
        let per_coordinate = 1.0 + core::f64::consts::TAU.simd_ln();
        let constant = G::Scalar::lit(D as f64 * per_coordinate);
        Ok((self.covariance().log_determinant()? + constant) * G::Scalar::lit(0.5))
    }

    /// The Kullback–Leibler divergence KL(self ‖ other), in nats: what is lost where `other` stands in for `self`.
    ///
    /// ½\[tr(Σ₂⁻¹Σ₁') + δᵀΣ₂⁻¹δ − D + ln(det Σ₂/det Σ₁')\], δ the error of X̄₁ about X̄₂, Σ₁' = J⁻¹Σ₁J⁻ᵀ: `self` told about the mean
    /// of `other`, to first order in its spread. Exact on ℝⁿ.
    ///
    /// # Errors
    /// [`UncertaintyError::Singular`].
    pub fn kl_divergence(&self, other: &Self) -> Result<G::Scalar, UncertaintyError> {
        let delta = other.error_of(self.mean());
        let moved = self.covariance().transformed(&E::jacobian_inverse::<G, D>(&delta));
        let information = other.covariance().information()?;
        let trace = (information * moved.matrix()).trace();
        let distance = other.covariance().mahalanobis_squared(&delta)?;
        let volumes = other.covariance().log_determinant()? - moved.log_determinant()?;
        Ok((trace + distance - G::Scalar::lit(D as f64) + volumes) * G::Scalar::lit(0.5))
    }
}
