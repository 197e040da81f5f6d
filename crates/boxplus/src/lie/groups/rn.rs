//! ℝⁿ under addition: the flat case in which every Jacobian is ±I.
//!
//! X·Y = x + y, X⁻¹ = −x, Exp = Log = identity, Ad = J_r = I, ad = 0. It acts on points as a translation.
//! Biases, landmarks and velocities are `Rn`, so that code written for groups serves them without a special case.
//!
//! Pitfall: an angle is no ℝ¹. A heading kept as `Rn<1>` does not wrap; take [`crate::lie::SO2`].
//!
//! ```
//! use boxplus::lie::{LieGroup, Manifold, Rn};
//! let bias = Rn::<2>::new([1.0, 2.0].into());
//! let step = [0.5, 0.0].into();
//! assert_eq!(bias.plus(&step).minus(&bias), step);
//! ```

use crate::lie::{Action, LieGroup, Real};
use core::ops::Mul;
use nalgebra::{SMatrix, SVector};

/// A vector of ℝᴺ as an element of the additive group.
#[derive(Clone, Copy, PartialEq)]
#[cfg_attr(feature = "bytemuck", derive(bytemuck::TransparentWrapper))]
#[repr(transparent)]
pub struct Rn<const N: usize, S = f64>(pub(in crate::lie) [S; N]);

impl<const N: usize, S: Real> Rn<N, S> {
    /// The element with the given coordinates.
    pub fn new(x: SVector<S, N>) -> Self {
        Self(x.into())
    }

    /// The coordinates.
    pub fn vector(&self) -> SVector<S, N> {
        self.0.into()
    }
}

impl<const N: usize, S: Real> LieGroup<N> for Rn<N, S> {
    type Scalar = S;
    type Over<T: Real> = Rn<N, T>;
    type Algebra = SVector<S, N>;

    fn identity() -> Self {
        Self::new(SVector::zeros())
    }
    fn compose(&self, rhs: &Self) -> Self {
        Self::new(self.vector() + rhs.vector())
    }
    fn inverse(&self) -> Self {
        Self::new(-self.vector())
    }
    fn exp(tau: &SVector<S, N>) -> Self {
        Self::new(*tau)
    }
    fn log(&self) -> SVector<S, N> {
        self.vector()
    }
    fn adjoint(&self) -> SMatrix<S, N, N> {
        SMatrix::identity()
    }
    fn small_adjoint(_: &SVector<S, N>) -> SMatrix<S, N, N> {
        SMatrix::zeros()
    }
    fn right_jacobian(_: &SVector<S, N>) -> SMatrix<S, N, N> {
        SMatrix::identity()
    }
    fn right_jacobian_inverse(_: &SVector<S, N>) -> SMatrix<S, N, N> {
        SMatrix::identity()
    }
    fn hat(tau: &SVector<S, N>) -> SVector<S, N> {
        *tau
    }
    fn vee(algebra: &SVector<S, N>) -> SVector<S, N> {
        *algebra
    }
    fn map<T: Real>(&self, f: impl Fn(S) -> T) -> Rn<N, T> {
        Rn::new(self.vector().map(f))
    }
}

impl<const N: usize, S: Real> Action<N, N> for Rn<N, S> {
    fn act(&self, p: &SVector<S, N>) -> SVector<S, N> {
        self.vector() + p
    }
    fn linear_part(&self) -> SMatrix<S, N, N> {
        SMatrix::identity()
    }
    fn generators_at(_: &SVector<S, N>) -> SMatrix<S, N, N> {
        SMatrix::identity()
    }
}

impl<const N: usize, S: Real> Mul for Rn<N, S> {
    type Output = Self;
    fn mul(self, rhs: Self) -> Self {
        self.compose(&rhs)
    }
}

impl<const N: usize, S: Real> Mul<SVector<S, N>> for Rn<N, S> {
    type Output = SVector<S, N>;
    fn mul(self, p: SVector<S, N>) -> SVector<S, N> {
        self.act(&p)
    }
}
