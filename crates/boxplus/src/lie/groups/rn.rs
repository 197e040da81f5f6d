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
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(x: SVector<S, N>) -> Self {
        Self(x.into())
    }

    /// The coordinates.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn vector(&self) -> SVector<S, N> {
        self.0.into()
    }
}

impl<const N: usize, S: Real> LieGroup<N> for Rn<N, S> {
    type Scalar = S;
    type Over<T: Real> = Rn<N, T>;
    type Algebra = SVector<S, N>;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn identity() -> Self {
        Self::new(SVector::zeros())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn compose(&self, rhs: &Self) -> Self {
        Self::new(self.vector() + rhs.vector())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn inverse(&self) -> Self {
        Self::new(-self.vector())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn exp(tau: &SVector<S, N>) -> Self {
        Self::new(*tau)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn log(&self) -> SVector<S, N> {
        self.vector()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn adjoint(&self) -> SMatrix<S, N, N> {
        SMatrix::identity()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn small_adjoint(_: &SVector<S, N>) -> SMatrix<S, N, N> {
        SMatrix::zeros()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn right_jacobian(_: &SVector<S, N>) -> SMatrix<S, N, N> {
        SMatrix::identity()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn right_jacobian_inverse(_: &SVector<S, N>) -> SMatrix<S, N, N> {
        SMatrix::identity()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn hat(tau: &SVector<S, N>) -> SVector<S, N> {
        *tau
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn vee(algebra: &SVector<S, N>) -> SVector<S, N> {
        *algebra
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn map<T: Real>(&self, f: impl Fn(S) -> T) -> Rn<N, T> {
        Rn::new(self.vector().map(f))
    }
}

impl<const N: usize, S: Real> Action<N, N> for Rn<N, S> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn act(&self, p: &SVector<S, N>) -> SVector<S, N> {
        self.vector() + p
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn linear_part(&self) -> SMatrix<S, N, N> {
        SMatrix::identity()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn generators_at(_: &SVector<S, N>) -> SMatrix<S, N, N> {
        SMatrix::identity()
    }
}

impl<const N: usize, S: Real> Mul for Rn<N, S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, rhs: Self) -> Self {
        self.compose(&rhs)
    }
}

impl<const N: usize, S: Real> Mul<SVector<S, N>> for Rn<N, S> {
    type Output = SVector<S, N>;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, p: SVector<S, N>) -> SVector<S, N> {
        self.act(&p)
    }
}
