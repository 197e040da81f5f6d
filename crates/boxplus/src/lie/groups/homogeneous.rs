//! Homogeneous points: SE(2), SE(3), Sim(2) and Sim(3) acting on (ε, η) by their matrices, and the operators ⊙ and ⊚.
//!
//! A point at ε/η has η ≠ 0, a direction η = 0; both move by the one linear map p ↦ T·p, which [`Action`] offers with all
//! Jacobians. Two operators turn the tangent's matrix into a factor on the right, Barfoot (2024) (8.21), (8.22):
//!
//! ```text
//! ξ^·p = p^⊙·ξ        p^⊙ = [ηI, −ε^; 0, 0]        pᵀ·ξ^ = ξᵀ·p^⊚        p^⊚ = [0, ε; −ε^, 0]
//! ```
//!
//! With a scale both have one more: the column (ε, 0) of ⊙ and the row (εᵀ, 0) of ⊚.
//!
//! The derivative of any expression in T·p is read off: ∂(T·p)/∂ξ = (T·p)^⊙ on the left, T·p^⊙ on the right.
//!
//! ```
//! use boxplus::lie::{Action, LieGroup, SE3};
//! use nalgebra::{Vector4, Vector6};
//! let xi = Vector6::new(0.3, -0.1, 0.2, 0.5, -0.4, 0.1);
//! let p = Vector4::new(1.0, 2.0, 3.0, 1.0);
//! assert!((SE3::hat(&xi) * p - SE3::odot(&p) * xi).norm() < 1e-15);
//! assert!((p.transpose() * SE3::hat(&xi) - xi.transpose() * SE3::ocirc(&p)).norm() < 1e-15);
//! assert!((SE3::exp(&xi).act(&p) - SE3::exp(&xi).to_matrix() * p).norm() < 1e-15);
//! ```

use super::so3::skew;
use crate::lie::{Action, Real, SE2, SE3, Sim2, Sim3};
use nalgebra::{Matrix3, Matrix4, SMatrix, Vector3, Vector4};

impl<S: Real> SE3<S> {
    /// p^⊙ = \[ηI, −ε^; 0, 0\], 4×6, for p = (ε, η): ξ^·p = p^⊙·ξ. Barfoot (2024) (8.21).
    pub fn odot(p: &Vector4<S>) -> SMatrix<S, 4, 6> {
        let mut m = SMatrix::<S, 4, 6>::zeros();
        m.fixed_view_mut::<3, 3>(0, 0).fill_diagonal(p.w);
        m.fixed_view_mut::<3, 3>(0, 3).copy_from(&-skew(&p.xyz()));
        m
    }

    /// p^⊚ = \[0, ε; −ε^, 0\], 6×4, for p = (ε, η): pᵀ·ξ^ = ξᵀ·p^⊚. Barfoot (2024) (8.22).
    pub fn ocirc(p: &Vector4<S>) -> SMatrix<S, 6, 4> {
        let mut m = SMatrix::<S, 6, 4>::zeros();
        m.fixed_view_mut::<3, 1>(0, 3).copy_from(&p.xyz());
        m.fixed_view_mut::<3, 3>(3, 0).copy_from(&-skew(&p.xyz()));
        m
    }
}

impl<S: Real> SE2<S> {
    /// p^⊙, 3×3, for p = (ε, η): ξ^·p = p^⊙·ξ.
    pub fn odot(p: &Vector3<S>) -> Matrix3<S> {
        let o = S::zero();
        Matrix3::new(p.z, o, -p.y, o, p.z, p.x, o, o, o)
    }

    /// p^⊚, 3×3, for p = (ε, η): pᵀ·ξ^ = ξᵀ·p^⊚.
    pub fn ocirc(p: &Vector3<S>) -> Matrix3<S> {
        let o = S::zero();
        Matrix3::new(o, o, p.x, o, o, p.y, p.y, -p.x, o)
    }
}

/// T·p on homogeneous points and directions.
impl<S: Real> Action<6, 4> for SE3<S> {
    #[inline]
    fn act(&self, p: &Vector4<S>) -> Vector4<S> {
        let moved = self.rotation().act(&p.xyz()) + self.translation() * p.w;
        Vector4::new(moved.x, moved.y, moved.z, p.w)
    }
    #[inline]
    fn linear_part(&self) -> Matrix4<S> {
        self.to_matrix()
    }
    #[inline]
    fn generators_at(p: &Vector4<S>) -> SMatrix<S, 4, 6> {
        Self::odot(p)
    }
}

/// T·p on homogeneous points and directions.
impl<S: Real> Action<3, 3> for SE2<S> {
    #[inline]
    fn act(&self, p: &Vector3<S>) -> Vector3<S> {
        let moved = self.rotation().act(&p.xy()) + self.translation() * p.z;
        Vector3::new(moved.x, moved.y, p.z)
    }
    #[inline]
    fn linear_part(&self) -> Matrix3<S> {
        self.to_matrix()
    }
    #[inline]
    fn generators_at(p: &Vector3<S>) -> Matrix3<S> {
        Self::odot(p)
    }
}

impl<S: Real> Sim3<S> {
    /// p^⊙ = \[ηI, −ε^, ε; 0, 0, 0\], 4×7, for p = (ε, η): ξ^·p = p^⊙·ξ.
    pub fn odot(p: &Vector4<S>) -> SMatrix<S, 4, 7> {
        let mut m = SMatrix::<S, 4, 7>::zeros();
        m.fixed_view_mut::<4, 6>(0, 0).copy_from(&SE3::odot(p));
        m.fixed_view_mut::<3, 1>(0, 6).copy_from(&p.xyz());
        m
    }

    /// p^⊚ = \[0, ε; −ε^, 0; εᵀ, 0\], 7×4, for p = (ε, η): pᵀ·ξ^ = ξᵀ·p^⊚.
    pub fn ocirc(p: &Vector4<S>) -> SMatrix<S, 7, 4> {
        let mut m = SMatrix::<S, 7, 4>::zeros();
        m.fixed_view_mut::<6, 4>(0, 0).copy_from(&SE3::ocirc(p));
        m.fixed_view_mut::<1, 3>(6, 0).copy_from(&p.xyz().transpose());
        m
    }
}

impl<S: Real> Sim2<S> {
    /// p^⊙, 3×4, for p = (ε, η): ξ^·p = p^⊙·ξ.
    pub fn odot(p: &Vector3<S>) -> SMatrix<S, 3, 4> {
        let mut m = SMatrix::<S, 3, 4>::zeros();
        m.fixed_view_mut::<3, 3>(0, 0).copy_from(&SE2::odot(p));
        m.fixed_view_mut::<2, 1>(0, 3).copy_from(&p.xy());
        m
    }

    /// p^⊚, 4×3, for p = (ε, η): pᵀ·ξ^ = ξᵀ·p^⊚.
    pub fn ocirc(p: &Vector3<S>) -> SMatrix<S, 4, 3> {
        let mut m = SMatrix::<S, 4, 3>::zeros();
        m.fixed_view_mut::<3, 3>(0, 0).copy_from(&SE2::ocirc(p));
        m.fixed_view_mut::<1, 2>(3, 0).copy_from(&p.xy().transpose());
        m
    }
}

/// T·p on homogeneous points and directions.
impl<S: Real> Action<7, 4> for Sim3<S> {
    #[inline]
    fn act(&self, p: &Vector4<S>) -> Vector4<S> {
        let moved = self.rotation().act(&p.xyz()) * self.scale() + self.translation() * p.w;
        Vector4::new(moved.x, moved.y, moved.z, p.w)
    }
    #[inline]
    fn linear_part(&self) -> Matrix4<S> {
        self.to_matrix()
    }
    #[inline]
    fn generators_at(p: &Vector4<S>) -> SMatrix<S, 4, 7> {
        Self::odot(p)
    }
}

/// T·p on homogeneous points and directions.
impl<S: Real> Action<4, 3> for Sim2<S> {
    #[inline]
    fn act(&self, p: &Vector3<S>) -> Vector3<S> {
        let moved = self.rotation().act(&p.xy()) * self.scale() + self.translation() * p.z;
        Vector3::new(moved.x, moved.y, p.z)
    }
    #[inline]
    fn linear_part(&self) -> Matrix3<S> {
        self.to_matrix()
    }
    #[inline]
    fn generators_at(p: &Vector3<S>) -> SMatrix<S, 3, 4> {
        Self::odot(p)
    }
}
