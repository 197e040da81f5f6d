//! Rotations by their columns: the 6-D coordinates of Zhou et al., and derivatives of matrix entries.
//!
//! The first two columns of R determine the third. As coordinates, any two vectors (a₁, a₂) that span a plane are made
//! orthonormal by Gram–Schmidt: b₁ = a₁/|a₁|, b₂ ∝ a₂ − (b₁·a₂)b₁, b₃ = b₁ × b₂. Zhou et al. (2019) show that five is the least
//! number of coordinates for a continuous inverse, which is why networks are trained on these six.
//!
//! ```text
//! ∂(R·eᵢ)/∂δ = −R·eᵢ^
//! δ₁ = (b₃·da₂ − (b₁·a₂)(b₃·da₁)/|a₁|)/|a₂ − (b₁·a₂)b₁|      δ₂ = −b₃·da₁/|a₁|      δ₃ = b₂·da₁/|a₁|
//! ```
//! The entries of M as coordinates are made a rotation by [`SO3::project`], whose derivative is the solution of
//! (tr(H)·I − H)·δ = vee(Rᵀ·dM − dMᵀ·R), H = RᵀM.
//!
//! ```
//! use boxplus::lie::{LieGroup, SO3};
//! use nalgebra::Vector3;
//! let x: SO3 = SO3::exp(&Vector3::new(0.1, -0.2, 0.3));
//! let [a, b] = x.to_6d();
//! let back = SO3::from_6d(&(a * 3.0), &(b - a * 0.5))?; // lengths, and a's share in b, do not matter
//! assert!(back.rminus(&x).norm() < 1e-15);
//! # Ok::<(), boxplus::lie::LieError>(())
//! ```

use super::{skew, unit};
use crate::lie::{LieError, Real, SO3};
use nalgebra::{Matrix3, SMatrix, SimdComplexField, Vector3};

/// Directions nearer to parallel than this multiple of ε span no plane.
const PARALLEL: f64 = 16.0;

/// Two directions made orthonormal: a, the part of b perpendicular to it, and the length of that part.
pub(super) fn gram_schmidt<S: Real>(a: &Vector3<S>, b: &Vector3<S>) -> Result<[Vector3<S>; 2], LieError> {
    let (a, b) = (unit(a)?, unit(b)?);
    let rest = b - a * a.dot(&b);
    let sine = rest.norm_squared().value().simd_sqrt();
    if sine <= PARALLEL * S::EPSILON {
        return Err(LieError::Parallel { sine });
    }
    // Once more: what cancellation has left along a is ε/sine.
    let rest = unit(&rest)?;
    Ok([a, unit(&(rest - a * a.dot(&rest)))?])
}

impl<S: Real> SO3<S> {
    /// The rotation whose first two columns are the directions `a` and, as far as it is perpendicular to `a`, `b`.
    ///
    /// # Errors
    /// [`LieError::NotFinite`], [`LieError::Zero`], or [`LieError::Parallel`].
    pub fn from_6d(a: &Vector3<S>, b: &Vector3<S>) -> Result<Self, LieError> {
        let [x, y] = gram_schmidt(a, b)?;
        Self::from_matrix(&Matrix3::from_columns(&[x, y, x.cross(&y)]))
    }

    /// [`SO3::from_6d`]: `(value, d_value_d_ab)`, 3×6.
    ///
    /// # Errors
    /// Those of [`SO3::from_6d`].
    pub fn from_6d_jac(a: &Vector3<S>, b: &Vector3<S>) -> Result<(Self, SMatrix<S, 3, 6>), LieError> {
        let value = Self::from_6d(a, b)?;
        let r = value.to_matrix();
        let [x, y, z] = [0, 1, 2].map(|i| r.column(i).into_owned());
        let (length, along, across) = (x.dot(a), x.dot(b), y.dot(b));
        let mut jacobian = SMatrix::<S, 3, 6>::zeros();
        let rows = [z * (-along / (length * across)), -z / length, y / length].map(|row| row.transpose());
        jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(&Matrix3::from_rows(&rows));
        jacobian.fixed_view_mut::<1, 3>(0, 3).copy_from(&(z / across).transpose());
        Ok((value, jacobian))
    }

    /// The first two columns of the matrix: the x and y axes of the local frame, seen in the parent frame.
    pub fn to_6d(&self) -> [Vector3<S>; 2] {
        let r = self.to_matrix();
        [0, 1].map(|i| r.column(i).into_owned())
    }

    /// [`SO3::to_6d`]: `(value, d_ab_d_self)`, 6×3.
    pub fn to_6d_jac(&self) -> ([Vector3<S>; 2], SMatrix<S, 6, 3>) {
        (self.to_6d(), self.to_matrix_jac().1.fixed_rows::<6>(0).into_owned())
    }

    /// [`SO3::to_matrix`]: `(value, d_entries_d_self)`, 9×3, entries column by column: blocks −R·eᵢ^.
    pub fn to_matrix_jac(&self) -> (Matrix3<S>, SMatrix<S, 9, 3>) {
        let r = self.to_matrix();
        let mut jacobian = SMatrix::<S, 9, 3>::zeros();
        for i in 0..3 {
            let block = -r * skew(&Vector3::ith(i, S::one()));
            jacobian.fixed_view_mut::<3, 3>(3 * i, 0).copy_from(&block);
        }
        (r, jacobian)
    }

    /// [`SO3::project`]: `(value, d_value_d_entries)`, 3×9, entries column by column. At a rotation also the derivative of
    /// [`SO3::from_matrix`].
    ///
    /// # Errors
    /// Those of [`SO3::project`].
    pub fn project_jac(m: &Matrix3<S>) -> Result<(Self, SMatrix<S, 3, 9>), LieError> {
        let value = Self::project(m)?;
        let r = value.to_matrix();
        let h = r.transpose() * m;
        let symmetric = (h + h.transpose()) * S::lit(0.5);
        // Both sides over tr(H) > 0, and the solution by Cramer's rule: columns of the inverse are cross products.
        let system = Matrix3::identity() - symmetric / h.trace();
        let [p, q, s] = [0, 1, 2].map(|i| system.column(i).into_owned());
        let rows = [q.cross(&s), s.cross(&p), p.cross(&q)].map(|row| row.transpose());
        let inverse = Matrix3::from_rows(&rows) / (p.dot(&q.cross(&s)) * h.trace());
        // vee(Rᵀ·dM − …) for dM in column i alone: eᵢ × Rᵀ·dm.
        let mut jacobian = SMatrix::<S, 3, 9>::zeros();
        for i in 0..3 {
            let block = inverse * skew(&Vector3::ith(i, S::one())) * r.transpose();
            jacobian.fixed_view_mut::<3, 3>(0, 3 * i).copy_from(&block);
        }
        Ok((value, jacobian))
    }
}
