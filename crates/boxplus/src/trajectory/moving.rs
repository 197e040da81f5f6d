//! States of continuous time: an element together with its rates, as one element of a larger group.

use super::Motion;
use crate::lie::{Jacobian, LieGroup, Tangent};
use nalgebra::SVector;

/// An element with its first R − 1 rates: the state of a [`GaussianProcess`](super::GaussianProcess) of order R. The group
/// ⟨G, ℝ^{(R−1)D}⟩, of dimension N = R·D, tangent (δX, δω, δω̇).
///
/// `Moving<SE3, 6, 2, 12>` is a pose with its velocity, `Moving<SE3, 6, 3, 18>` one with its acceleration, too; rates are those of the
/// body, as in [`Motion`]. Element and rates do not couple: a step of the one leaves the others. (Rust cannot multiply R by D in a type
/// yet: a wrong N does not compile.)
///
/// ```
/// use boxplus::lie::{LieGroup, SE2};
/// use boxplus::trajectory::Moving;
/// use nalgebra::{SVector, Vector3};
/// let car = Moving::<SE2, 3, 2, 6>::new(SE2::identity(), Vector3::new(2.0, 0.0, 0.5)); // 2 m/s ahead, turning left
/// let moved = car.rplus(&SVector::from([1.0, 0.0, 0.0, 0.5, 0.0, 0.0]));
/// assert_eq!(moved.value(), &SE2::exp(&Vector3::new(1.0, 0.0, 0.0)));
/// assert_eq!(moved.motion().velocity, Vector3::new(2.5, 0.0, 0.5));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moving<G: LieGroup<D>, const D: usize, const R: usize, const N: usize> {
    value: G,
    /// ω, then ω̇; the latter stays zero where R = 2.
    rates: [Tangent<G::Scalar, D>; 2],
}

impl<G: LieGroup<D>, const D: usize, const R: usize, const N: usize> Moving<G, D, R, N> {
    /// Passing `value` at the body velocity ω, without acceleration.
    pub fn new(value: G, velocity: Tangent<G::Scalar, D>) -> Self {
        Self::from_motion(&Motion::steady(value, velocity))
    }

    /// The part of a motion that the state has.
    pub fn from_motion(motion: &Motion<G, D>) -> Self {
        const { assert!(N == R * D && (R == 2 || R == 3), "N = R·D; R is 2 (velocity) or 3 (acceleration, too)") };
        let acceleration = if R > 2 { motion.acceleration } else { Tangent::<G::Scalar, D>::zeros() };
        Self { value: motion.value, rates: [motion.velocity, acceleration] }
    }

    /// X.
    pub fn value(&self) -> &G {
        &self.value
    }

    /// X with its rates, those beyond the state zero.
    pub fn motion(&self) -> Motion<G, D> {
        let [velocity, acceleration] = self.rates;
        Motion { acceleration, ..Motion::steady(self.value, velocity) }
    }

    /// The blocks of a tangent.
    fn split(tau: &Tangent<G::Scalar, N>) -> (Tangent<G::Scalar, D>, [Tangent<G::Scalar, D>; 2]) {
        let block = |k: usize| match k {
            k if k < R => tau.fixed_rows::<D>(k * D).into_owned(),
            _ => SVector::zeros(),
        };
        (block(0), [block(1), block(2)])
    }

    /// The tangent of blocks.
    fn joined(tau: &Tangent<G::Scalar, D>, rates: &[Tangent<G::Scalar, D>; 2]) -> Tangent<G::Scalar, N> {
        let blocks = [tau, &rates[0], &rates[1]];
        Tangent::<G::Scalar, N>::from_fn(|i, _| blocks[i / D][i % D])
    }

    /// A matrix of the element, the identity of the rates.
    fn beside_identity(block: &Jacobian<G::Scalar, D>) -> Jacobian<G::Scalar, N> {
        let mut matrix = Jacobian::<G::Scalar, N>::identity();
        matrix.fixed_view_mut::<D, D>(0, 0).copy_from(block);
        matrix
    }
}

impl<G: LieGroup<D>, const D: usize, const R: usize, const N: usize> LieGroup<N> for Moving<G, D, R, N> {
    type Scalar = G::Scalar;
    type Over<S: crate::lie::Real> = Moving<G::Over<S>, D, R, N>;
    type Algebra = (G::Algebra, [Tangent<G::Scalar, D>; 2]);

    fn identity() -> Self {
        Self::from_motion(&Motion::at_rest(G::identity()))
    }
    fn compose(&self, rhs: &Self) -> Self {
        let rates = core::array::from_fn(|k| self.rates[k] + rhs.rates[k]);
        Self { value: self.value.compose(&rhs.value), rates }
    }
    fn inverse(&self) -> Self {
        Self { value: self.value.inverse(), rates: self.rates.map(|rate| -rate) }
    }
    fn exp(tau: &Tangent<G::Scalar, N>) -> Self {
        let (tau, rates) = Self::split(tau);
        Self { value: G::exp(&tau), rates }
    }
    fn log(&self) -> Tangent<G::Scalar, N> {
        Self::joined(&self.value.log(), &self.rates)
    }
    fn adjoint(&self) -> Jacobian<G::Scalar, N> {
        Self::beside_identity(&self.value.adjoint())
    }
    fn small_adjoint(tau: &Tangent<G::Scalar, N>) -> Jacobian<G::Scalar, N> {
        let mut matrix = Jacobian::<G::Scalar, N>::zeros();
        matrix.fixed_view_mut::<D, D>(0, 0).copy_from(&G::small_adjoint(&Self::split(tau).0));
        matrix
    }
    fn right_jacobian(tau: &Tangent<G::Scalar, N>) -> Jacobian<G::Scalar, N> {
        Self::beside_identity(&G::right_jacobian(&Self::split(tau).0))
    }
    fn right_jacobian_inverse(tau: &Tangent<G::Scalar, N>) -> Jacobian<G::Scalar, N> {
        Self::beside_identity(&G::right_jacobian_inverse(&Self::split(tau).0))
    }
    fn hat(tau: &Tangent<G::Scalar, N>) -> Self::Algebra {
        let (tau, rates) = Self::split(tau);
        (G::hat(&tau), rates)
    }
    fn vee((algebra, rates): &Self::Algebra) -> Tangent<G::Scalar, N> {
        Self::joined(&G::vee(algebra), rates)
    }
    fn map<S: crate::lie::Real>(&self, f: impl Fn(G::Scalar) -> S) -> Self::Over<S> {
        Moving { value: self.value.map(&f), rates: self.rates.map(|rate| rate.map(&f)) }
    }
}
