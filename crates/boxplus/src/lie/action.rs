//! How a group moves the points of ℝᴺ.

use super::LieGroup;
use nalgebra::{SMatrix, SVector};

/// Action of a group on ℝᴺ by affine maps, X·p = A·p + b; for SE(3), y = R·p + t.
///
/// Three items define it; the Jacobians follow, because Exp(τ)·p ≈ p + G(p)τ and
/// X·Exp(τ)·p = X·(p + G(p)τ) = y + A·G(p)τ, while Exp(τ)·X·p = y + G(y)τ:
///
/// ```text
/// y = X·p          right ∂y/∂X = A·G(p)        left ∂y/∂X = G(y)         ∂y/∂p = A
/// y = X⁻¹·p        right ∂y/∂X = −G(y)         left ∂y/∂X = −A⁻¹·G(p)    ∂y/∂p = A⁻¹
/// direction y = A·d: the same with G(d) − G(0), a direction being a difference of points
/// ```
///
/// Solà et al. (2018) (182); Barfoot (2024) (8.24), (8.25).
pub trait Action<const D: usize, const N: usize>: LieGroup<D> {
    /// y = X·p: a point in the local frame, seen in the parent frame.
    fn act(&self, p: &SVector<Self::Scalar, N>) -> SVector<Self::Scalar, N>;
    /// A, N×N: the linear part of the action, ∂(X·p)/∂p.
    fn linear_part(&self) -> SMatrix<Self::Scalar, N, N>;
    /// G(p) = ∂(Exp(τ)·p)/∂τ at τ = 0, N×D: the velocity of `p` for each basis tangent. SE(3): \[I, −p^\].
    fn generators_at(p: &SVector<Self::Scalar, N>) -> SMatrix<Self::Scalar, N, D>;

    /// y = X·p, right Jacobians: `(y, d_y_d_self, d_y_d_p)`, N×D and N×N.
    #[inline]
    fn act_jac(&self, p: &SVector<Self::Scalar, N>) -> PointJac<Self, D, N> {
        let a = self.linear_part();
        (self.act(p), a * Self::generators_at(p), a)
    }
    /// y = X·p, left Jacobian in X: `(y, d_y_d_self, d_y_d_p)`.
    #[inline]
    fn act_left_jac(&self, p: &SVector<Self::Scalar, N>) -> PointJac<Self, D, N> {
        let y = self.act(p);
        (y, Self::generators_at(&y), self.linear_part())
    }

    /// y = X⁻¹·p: a point of the parent frame, seen in the local frame.
    #[inline]
    fn act_inverse(&self, p: &SVector<Self::Scalar, N>) -> SVector<Self::Scalar, N> {
        self.inverse().act(p)
    }
    /// y = X⁻¹·p, right Jacobian in X: `(y, d_y_d_self, d_y_d_p)`.
    #[inline]
    fn act_inverse_jac(&self, p: &SVector<Self::Scalar, N>) -> PointJac<Self, D, N> {
        let (y, d_y, a) = self.inverse().act_left_jac(p);
        (y, -d_y, a)
    }
    /// y = X⁻¹·p, left Jacobian in X: `(y, d_y_d_self, d_y_d_p)`.
    #[inline]
    fn act_inverse_left_jac(&self, p: &SVector<Self::Scalar, N>) -> PointJac<Self, D, N> {
        let (y, d_y, a) = self.inverse().act_jac(p);
        (y, -d_y, a)
    }

    /// y = A·d: a direction, a velocity or a difference of points, which no translation moves.
    #[inline]
    fn act_direction(&self, d: &SVector<Self::Scalar, N>) -> SVector<Self::Scalar, N> {
        self.linear_part() * d
    }
    /// y = A·d, right Jacobian in X: `(y, d_y_d_self, d_y_d_d)`.
    #[inline]
    fn act_direction_jac(&self, d: &SVector<Self::Scalar, N>) -> PointJac<Self, D, N> {
        let a = self.linear_part();
        (self.act_direction(d), a * direction_generators::<Self, D, N>(d), a)
    }
    /// y = A·d, left Jacobian in X: `(y, d_y_d_self, d_y_d_d)`.
    #[inline]
    fn act_direction_left_jac(&self, d: &SVector<Self::Scalar, N>) -> PointJac<Self, D, N> {
        let y = self.act_direction(d);
        (y, direction_generators::<Self, D, N>(&y), self.linear_part())
    }
}

/// The value of an action on ℝᴺ, its Jacobian in the element, N×D, and in the point, N×N.
pub type PointJac<G, const D: usize, const N: usize> = (
    SVector<<G as LieGroup<D>>::Scalar, N>,
    SMatrix<<G as LieGroup<D>>::Scalar, N, D>,
    SMatrix<<G as LieGroup<D>>::Scalar, N, N>,
);

#[inline]
fn direction_generators<G: Action<D, N>, const D: usize, const N: usize>(
    d: &SVector<G::Scalar, N>,
) -> SMatrix<G::Scalar, N, D> {
    G::generators_at(d) - G::generators_at(&SVector::zeros())
}
