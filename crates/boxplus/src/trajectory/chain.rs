//! Products of exponentials with fixed directions: the common form of B-splines and Hermite curves.
//!
//! ```text
//! X(t) = X₀·Exp(λ₁(t)·d₁)·…·Exp(λ_N(t)·d_N)                               A_j = Exp(λ_j d_j),  w = Ad(A_j⁻¹)·ω_{j−1}
//! ω_j = w + λ̇_j d_j              ∂ω_j/∂d_j = λ_j·ad_w·J_r(λ_j d_j) + λ̇_j I
//! ω̇_j = Ad(A_j⁻¹)ω̇_{j−1} + λ̇_j[ω_j, d_j] + λ̈_j d_j
//!                                ∂ω̇_j/∂d_j = λ_j·ad(Ad(A_j⁻¹)ω̇_{j−1})·J_r(λ_j d_j) + λ̇_j(ad_{ω_j} − ad_{d_j}·∂ω_j/∂d_j) + λ̈_j I
//! ```
//! Sommer et al. (2020); the derivatives follow from Ad(Exp(−(τ + δ)))·v = Ad(Exp(−τ))·v + ad(…)·J_r(τ)·δ.

use super::motion::{Motion, MotionJac};
use crate::lie::{Jacobian, LieGroup, Tangent};
use nalgebra::SMatrix;

/// One exponential: a fixed direction and \[λ, λ̇, λ̈, λ⃛\] at the time in question.
#[derive(Clone, Copy)]
pub(super) struct Link<S, const D: usize> {
    pub(super) direction: Tangent<S, D>,
    pub(super) weights: [S; 4],
}

/// X(t) with its rates: O(N) adjoints.
pub(super) fn motion<G: LieGroup<D>, const D: usize>(base: &G, links: &[Link<G::Scalar, D>]) -> Motion<G, D> {
    let start = Motion::at_rest(*base);
    links.iter().fold(start, |motion, link| motion.then(&Motion::along(&link.direction, link.weights)))
}

/// X(t) with its rates, and their derivatives in X₀ (of the value alone: the rates do not depend on it) and in each d_j
/// from the link `first` on; links before it are left out, their derivatives zero.
pub(super) fn motion_jac<G: LieGroup<D>, const D: usize, const N: usize>(
    base: &G,
    links: &[Link<G::Scalar, D>; N],
    first: usize,
) -> (Motion<G, D>, Jacobian<G::Scalar, D>, [MotionJac<G::Scalar, D>; N]) {
    let (motion, steps) = forward(base, links, first);
    // What the end knows of the rates after step j: P = ∂ω_N/∂ω_j = ∂ω̇_N/∂ω̇_j = ∂X_N/∂X_j, and R = ∂ω̇_N/∂ω_j.
    let (mut p, mut r) = (Jacobian::<G::Scalar, D>::identity(), Jacobian::<G::Scalar, D>::zeros());
    let mut jacobians = [MotionJac::zero(); N];
    for (jacobian, (step, link)) in jacobians.iter_mut().zip(steps.iter().zip(links)).skip(first).rev() {
        *jacobian = MotionJac {
            value: p * step.local.value,
            velocity: p * step.local.velocity,
            acceleration: p * step.local.acceleration + r * step.local.velocity,
        };
        let bend = G::small_adjoint(&(link.direction * link.weights[1]));
        r = (r - p * bend) * step.adjoint;
        p *= step.adjoint;
    }
    (motion, p, jacobians)
}

/// What one exponential does: Ad(A_j⁻¹), and how the motion right after it answers to d_j.
#[derive(Clone, Copy)]
struct Step<S, const D: usize> {
    adjoint: Jacobian<S, D>,
    local: MotionJac<S, D>,
}

fn forward<G: LieGroup<D>, const D: usize, const N: usize>(
    base: &G,
    links: &[Link<G::Scalar, D>; N],
    first: usize,
) -> (Motion<G, D>, [Step<G::Scalar, D>; N]) {
    let mut motion = Motion::at_rest(*base);
    let mut steps = [Step { adjoint: SMatrix::identity(), local: MotionJac::zero() }; N];
    for (step, link) in steps.iter_mut().zip(links).skip(first) {
        let Link { direction, weights: [s, ds, dds, _] } = link;
        let next = Motion::<G, D>::along(direction, link.weights);
        let adjoint = next.value.inverse().adjoint();
        let seen = [motion.velocity, motion.acceleration].map(|rate| G::small_adjoint(&(adjoint * rate)));
        motion = motion.then_seen_by(&next, &adjoint);
        let value = G::right_jacobian(&(direction * *s)) * *s;
        let velocity = seen[0] * value + scaled_identity(*ds);
        let turn = G::small_adjoint(&motion.velocity) - G::small_adjoint(direction) * velocity;
        let acceleration = seen[1] * value + turn * *ds + scaled_identity(*dds);
        *step = Step { adjoint, local: MotionJac { value, velocity, acceleration } };
    }
    (motion, steps)
}

/// s·I.
pub(super) fn scaled_identity<S: crate::lie::Real, const D: usize>(s: S) -> Jacobian<S, D> {
    SMatrix::from_diagonal_element(s)
}
