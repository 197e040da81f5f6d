//! Rates of coordinates and rates of bodies, and how small errors travel along a trajectory.
//!
//! ```text
//! X = Exp(τ):   Ẋ = X·ω^   τ̇ = J_r⁻¹(τ)·ω   body          Ẋ = ϖ^·X   τ̇ = J_l⁻¹(τ)·ϖ   spatial
//! ω = J_r(τ)·τ̇                                               ϖ = J_l(τ)·τ̇
//! ```
//! Barfoot (2024) (8.26)–(8.33). Rate of a rotation vector ≠ angular velocity: they agree at τ = 0 and where both are
//! parallel. Accelerations, too, are converted by [`super::Motion::from_coordinates`] and [`super::Motion::coordinates`].
//!
//! Errors. Let X̂ move at the measured velocity, X at the true one, ω = ω̂ + δω:
//!
//! ```text
//! local  X = X̂·Exp(ξ)    ξ̇ = −ad_ω·ξ + δω    Φ(t, s) = Ad(X(t)⁻¹·X(s))      ∫₀^Δ Φ(Δ, s)ds = Δ·J_r(ωΔ)
//! global X = Exp(ξ)·X̂    ξ̇ = +ad_ϖ·ξ + δϖ    Φ(t, s) = Ad(X(t))·Ad(X(s))⁻¹   ∫₀^Δ Φ(Δ, s)ds = Δ·J_l(ϖΔ)
//! ```
//! to first order in ξ; Φ(t, s) carries an error of time s to time t and is exact for finite ξ where δω = 0. Barfoot (2024)
//! (8.30)–(8.35). The global Φ of one velocity in the parent frame does not depend on where X is; an error fixed to the body
//! is constant in neither. Pitfall: the 4×4 propagator of the pose and the 6×6 propagator of its error are different
//! matrices.

use crate::lie::{Jacobian, LieGroup, Tangent};

/// ω = J_r(τ)·τ̇: the body velocity of Exp(τ) whose coordinates move at `rate`.
pub fn body_velocity<G: LieGroup<D>, const D: usize>(
    tau: &Tangent<G::Scalar, D>,
    rate: &Tangent<G::Scalar, D>,
) -> Tangent<G::Scalar, D> {
    G::right_jacobian(tau) * rate
}

/// τ̇ = J_r⁻¹(τ)·ω: how the coordinates of Exp(τ) move at body velocity ω. Unbounded as θ → 2π.
///
/// ```
/// use boxplus::lie::{LieGroup, SO3};
/// use boxplus::trajectory::{body_velocity, rate_from_body};
/// use nalgebra::Vector3;
/// let (phi, gyro) = (Vector3::new(0.3, -0.2, 1.0), Vector3::new(0.0, 0.0, 1.0));
/// let rate = rate_from_body::<SO3, 3>(&phi, &gyro);
/// assert!((rate - gyro).norm() > 0.1); // not the angular velocity
/// assert!((body_velocity::<SO3, 3>(&phi, &rate) - gyro).norm() < 1e-15);
/// ```
pub fn rate_from_body<G: LieGroup<D>, const D: usize>(
    tau: &Tangent<G::Scalar, D>,
    omega: &Tangent<G::Scalar, D>,
) -> Tangent<G::Scalar, D> {
    G::right_jacobian_inverse(tau) * omega
}

/// ϖ = J_l(τ)·τ̇: the spatial velocity of Exp(τ) whose coordinates move at `rate`.
pub fn spatial_velocity<G: LieGroup<D>, const D: usize>(
    tau: &Tangent<G::Scalar, D>,
    rate: &Tangent<G::Scalar, D>,
) -> Tangent<G::Scalar, D> {
    G::left_jacobian(tau) * rate
}

/// τ̇ = J_l⁻¹(τ)·ϖ: how the coordinates of Exp(τ) move at spatial velocity ϖ. Unbounded as θ → 2π.
pub fn rate_from_spatial<G: LieGroup<D>, const D: usize>(
    tau: &Tangent<G::Scalar, D>,
    spatial: &Tangent<G::Scalar, D>,
) -> Tangent<G::Scalar, D> {
    G::left_jacobian_inverse(tau) * spatial
}

/// −ad_ω: the local error obeys ξ̇ = −ad_ω·ξ + δω, ω the body velocity.
pub fn local_error_dynamics<G: LieGroup<D>, const D: usize>(
    omega: &Tangent<G::Scalar, D>,
) -> Jacobian<G::Scalar, D> {
    -G::small_adjoint(omega)
}

/// +ad_ϖ: the global error obeys ξ̇ = ad_ϖ·ξ + δϖ, ϖ the spatial velocity.
pub fn global_error_dynamics<G: LieGroup<D>, const D: usize>(
    spatial: &Tangent<G::Scalar, D>,
) -> Jacobian<G::Scalar, D> {
    G::small_adjoint(spatial)
}

/// Φ(t, s) = Ad(X(t)⁻¹·X(s)): carries a local error from time s to time t.
///
/// ```
/// use boxplus::lie::{LieGroup, SE3};
/// use boxplus::trajectory::local_error_transition;
/// use nalgebra::Vector6;
/// let (before, step) = (SE3::identity(), Vector6::new(1.0, 0.0, 0.0, 0.0, 0.2, 0.5));
/// let (after, xi) = (before.rplus(&step), Vector6::new(0.1, -0.2, 0.1, 0.3, 0.0, -0.1));
/// let carried = local_error_transition(&before, &after) * xi;
/// assert!((before.rplus(&xi).rplus(&step).rminus(&after) - carried).norm() < 1e-15); // exact, ξ is not small
/// ```
pub fn local_error_transition<G: LieGroup<D>, const D: usize>(at_s: &G, at_t: &G) -> Jacobian<G::Scalar, D> {
    at_t.between(at_s).adjoint()
}

/// Φ(t, s) = Ad(X(t))·Ad(X(s))⁻¹ = Ad(X(t)·X(s)⁻¹): carries a global error from time s to time t.
pub fn global_error_transition<G: LieGroup<D>, const D: usize>(at_s: &G, at_t: &G) -> Jacobian<G::Scalar, D> {
    at_t.compose(&at_s.inverse()).adjoint()
}

/// Δ·J_r(ωΔ): what a constant error δω of the constant body velocity ω does to the local error in time Δ.
pub fn local_error_integral<G: LieGroup<D>, const D: usize>(
    omega: &Tangent<G::Scalar, D>,
    duration: G::Scalar,
) -> Jacobian<G::Scalar, D> {
    G::right_jacobian(&(omega * duration)) * duration
}

/// Δ·J_l(ϖΔ): what a constant error δϖ of the constant spatial velocity ϖ does to the global error in time Δ.
pub fn global_error_integral<G: LieGroup<D>, const D: usize>(
    spatial: &Tangent<G::Scalar, D>,
    duration: G::Scalar,
) -> Jacobian<G::Scalar, D> {
    G::left_jacobian(&(spatial * duration)) * duration
}
