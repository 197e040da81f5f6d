//! An element in motion: where it is, and its velocity, acceleration and jerk in the frame of the body.
//!
//! ```text
//! Ẋ = X·ω^       ω: body velocity      ω̇: acceleration      ω̈: jerk                    each ∈ ℝᴰ, per unit of time
//! Z = X·Y        w = Ad(Y⁻¹)·ω_X
//!                ω_Z = w + ω_Y
//!                ω̇_Z = Ad(Y⁻¹)·ω̇_X + [w, ω_Y] + ω̇_Y
//!                ω̈_Z = Ad(Y⁻¹)·ω̈_X + 2[Ad(Y⁻¹)·ω̇_X, ω_Y] + [[w, ω_Y], ω_Y] + [w, ω̇_Y] + ω̈_Y
//! Z = X⁻¹        ω_Z = −Ad_X·ω,   ω̇_Z = −Ad_X·ω̇,   ω̈_Z = −Ad_X·(ω̈ + [ω, ω̇])
//! spatial        Ẋ = ϖ^·X,   ϖ = Ad_X·ω,   ϖ̇ = Ad_X·ω̇       (d/dt Ad_X = Ad_X·ad_ω, and [ω, ω] = 0)
//! ```
//! Barfoot (2024) (8.26)–(8.33) on SE(3); the product rule is the recursion of Sommer et al. (2020), on any group.
//!
//! Pitfall: ω̇ is the derivative of coordinates in a turning frame. On SE(3) its first three numbers are not the
//! acceleration of the origin, which is R·(ρ̇ + φ×ρ): [`Motion::act`] gives that.

use crate::lie::{Action, Jacobian, LieGroup, Real, Tangent};
use nalgebra::{SMatrix, SVector};

/// An element X(t) with its velocity, acceleration and jerk in the body frame.
///
/// ```
/// use boxplus::lie::{LieGroup, SE2};
/// use boxplus::trajectory::{Motion, PointMotion};
/// use nalgebra::{Vector2, Vector3};
/// // A car at 2 m/s in a bend of radius 4 m feels v²/r = 1 m/s² to the left.
/// let car = Motion::steady(SE2::identity(), Vector3::new(2.0, 0.0, 0.5));
/// let seat = car.act(&PointMotion::fixed(Vector2::zeros()));
/// assert_eq!(seat.velocity, Vector2::new(2.0, 0.0));
/// assert_eq!(seat.acceleration, Vector2::new(0.0, 1.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion<G: LieGroup<D>, const D: usize> {
    /// X, local to parent.
    pub value: G,
    /// ω, body frame, per unit of time.
    pub velocity: Tangent<G::Scalar, D>,
    /// ω̇, body frame.
    pub acceleration: Tangent<G::Scalar, D>,
    /// ω̈, body frame.
    pub jerk: Tangent<G::Scalar, D>,
}

impl<G: LieGroup<D>, const D: usize> Motion<G, D> {
    /// At rest at `value`.
    pub fn at_rest(value: G) -> Self {
        Self::steady(value, SVector::zeros())
    }

    /// Passing `value` at the constant body velocity ω.
    pub fn steady(value: G, velocity: Tangent<G::Scalar, D>) -> Self {
        Self { value, velocity, acceleration: SVector::zeros(), jerk: SVector::zeros() }
    }

    /// Exp(λ(t)·d) for constant d, given \[λ, λ̇, λ̈, λ⃛\].
    pub fn along(direction: &Tangent<G::Scalar, D>, [s, ds, dds, ddds]: [G::Scalar; 4]) -> Self {
        Self {
            value: G::exp(&(direction * s)),
            velocity: direction * ds,
            acceleration: direction * dds,
            jerk: direction * ddds,
        }
    }

    /// X(t)·Y(t), with Y = `next` moving relative to X: rates of the product, in the frame of Y.
    pub fn then(&self, next: &Self) -> Self {
        self.then_seen_by(next, &next.value.inverse().adjoint())
    }

    /// [`Motion::then`], given Ad(Y⁻¹).
    pub(super) fn then_seen_by(&self, next: &Self, ad: &Jacobian<G::Scalar, D>) -> Self {
        let seen = [self.velocity, self.acceleration, self.jerk].map(|rate| ad * rate);
        let [w, dw, ddw] = seen;
        let (bracket, two) = (G::bracket, G::Scalar::lit(2.0));
        let coriolis = bracket(&w, &next.velocity);
        let second = bracket(&dw, &next.velocity) * two + bracket(&coriolis, &next.velocity);
        Self {
            value: self.value.compose(&next.value),
            velocity: w + next.velocity,
            acceleration: dw + coriolis + next.acceleration,
            jerk: ddw + second + bracket(&w, &next.acceleration) + next.jerk,
        }
    }

    /// X(t)⁻¹: the parent as the body sees it move.
    pub fn inverse(&self) -> Self {
        let ad = self.value.adjoint();
        Self {
            value: self.value.inverse(),
            velocity: -(ad * self.velocity),
            acceleration: -(ad * self.acceleration),
            jerk: -(ad * (self.jerk + G::bracket(&self.velocity, &self.acceleration))),
        }
    }

    /// The same motion of a frame Y = X·C fixed to the body at C = `body_from_frame`: a sensor on its mount.
    pub fn of_frame(&self, body_from_frame: &G) -> Self {
        self.then(&Self::at_rest(*body_from_frame))
    }

    /// ϖ = Ad_X·ω and ϖ̇ = Ad_X·ω̇: velocity and acceleration in the parent frame, Ẋ = ϖ^·X. Barfoot (2024) (8.26).
    pub fn spatial(&self) -> (Tangent<G::Scalar, D>, Tangent<G::Scalar, D>) {
        let ad = self.value.adjoint();
        (ad * self.velocity, ad * self.acceleration)
    }

    /// The transport theorem: the motion in the parent frame of a point that moves in the body frame.
    ///
    /// ```text
    /// y = X·p      ẏ = A·(ṗ + G(p)ω)      ÿ = A·(p̈ + 2Wṗ + W·G(p)ω + G(p)ω̇)      W·d = (G(d) − G(0))·ω
    /// ```
    /// with A the linear part and G the generators of the [`Action`]: on SE(3) ẏ = R(ṗ + φ×p + ρ), then Coriolis, centrifugal
    /// and Euler terms in this order. Of a point fixed in the world the body sees
    /// `motion.inverse().act(&PointMotion::fixed(p))`, ṗ = −G(p)ω, Barfoot (2024) (8.36).
    pub fn act<const N: usize>(&self, p: &PointMotion<G::Scalar, N>) -> PointMotion<G::Scalar, N>
    where
        G: Action<D, N>,
    {
        let linear = self.value.linear_part();
        let (here, origin) = (G::generators_at(&p.position), G::generators_at(&SVector::zeros()));
        let turn = |d: &SVector<G::Scalar, N>| (G::generators_at(d) - origin) * self.velocity;
        let carried = here * self.velocity;
        let relative = p.acceleration + turn(&(p.velocity + p.velocity + carried)) + here * self.acceleration;
        PointMotion {
            position: self.value.act(&p.position),
            velocity: linear * (p.velocity + carried),
            acceleration: linear * relative,
        }
    }
}

/// A point of ℝᴺ with its velocity and acceleration, all in one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointMotion<S, const N: usize> {
    /// Where it is, in metres.
    pub position: SVector<S, N>,
    /// Its velocity, per unit of time.
    pub velocity: SVector<S, N>,
    /// Its acceleration.
    pub acceleration: SVector<S, N>,
}

impl<S: Real, const N: usize> PointMotion<S, N> {
    /// A point at rest.
    pub fn fixed(position: SVector<S, N>) -> Self {
        Self { position, velocity: SVector::zeros(), acceleration: SVector::zeros() }
    }
}

/// How value, velocity and acceleration of a [`Motion`] answer to one argument, each D×D; right (local) Jacobians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionJac<S, const D: usize> {
    /// ∂X/∂·, both sides perturbed locally where they are group elements.
    pub value: Jacobian<S, D>,
    /// ∂ω/∂·.
    pub velocity: Jacobian<S, D>,
    /// ∂ω̇/∂·.
    pub acceleration: Jacobian<S, D>,
}

impl<S: Real, const D: usize> MotionJac<S, D> {
    /// Nothing depends on the argument.
    pub(super) fn zero() -> Self {
        Self { value: SMatrix::zeros(), velocity: SMatrix::zeros(), acceleration: SMatrix::zeros() }
    }

    /// The chain rule: the argument itself answers to something else by `inner`.
    pub(super) fn chained(&self, inner: &Jacobian<S, D>) -> Self {
        Self {
            value: self.value * inner,
            velocity: self.velocity * inner,
            acceleration: self.acceleration * inner,
        }
    }

    /// Adds another way on which the argument acts.
    pub(super) fn add(&mut self, other: &Self) {
        self.value += other.value;
        self.velocity += other.velocity;
        self.acceleration += other.acceleration;
    }
}
