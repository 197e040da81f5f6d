//! The element of a group nearest to any matrix.
//!
//! "Nearest" is in the Frobenius norm of the matrices the group consists of: \[R t; 0 1\] for SE(3), \[R v p; 0 1 t; 0 0 1\] for
//! SGal(3). The sum of squares falls apart by blocks: R is nearest to its block by itself, [`SO3::project`]; translations,
//! velocities and the time are taken as they are; the constant rows below are ignored. With a scale the block M is met by
//! s·R of the same R and s = tr(RᵀM)/n, the share of M along R.
//!
//! Pitfall: a homogeneous matrix is not divided by its last entry; one that projects (last row ≠ (0, …, 1)) is no motion.
//!
//! ```
//! use boxplus::lie::{LieGroup, SE3};
//! use nalgebra::{Matrix4, Vector6};
//! let x: SE3 = SE3::exp(&Vector6::new(1.0, 2.0, 3.0, 0.4, -0.5, 0.6));
//! let printed: Matrix4<f64> = x.to_matrix().map(|entry: f64| (entry * 100.0).round() / 100.0); // two decimals
//! assert!(SE3::from_matrix(&printed).is_err());
//! assert!(SE3::project(&printed)?.rminus(&x).norm() < 0.01);
//! # Ok::<(), boxplus::lie::LieError>(())
//! ```

use super::{LieError, Real, RxSO2, RxSO3, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3};
use nalgebra::{Matrix2, Matrix3, Matrix4, SMatrix, SVector};

/// The top left N×N block and the column `k` beside it.
fn parts<S: Real, const M: usize, const N: usize>(
    m: &SMatrix<S, M, M>,
    k: usize,
) -> Result<(SMatrix<S, N, N>, SVector<S, N>), LieError> {
    let column = m.fixed_view::<N, 1>(0, k).into_owned();
    finite(column.as_slice())?;
    Ok((m.fixed_view::<N, N>(0, 0).into_owned(), column))
}

fn finite<S: Real>(numbers: &[S]) -> Result<(), LieError> {
    if numbers.iter().all(|x| x.value().is_finite()) { Ok(()) } else { Err(LieError::NotFinite) }
}

impl<S: Real> RxSO2<S> {
    /// The scaled rotation nearest to any 2×2 matrix.
    ///
    /// # Errors
    /// Those of [`SO2::project`].
    pub fn project(m: &Matrix2<S>) -> Result<Self, LieError> {
        let rotation = SO2::project(m)?;
        Self::from_scale(rotation, rotation.to_matrix().dot(m) * S::lit(0.5))
    }
}

impl<S: Real> RxSO3<S> {
    /// The scaled rotation nearest to any 3×3 matrix.
    ///
    /// # Errors
    /// Those of [`SO3::project`].
    pub fn project(m: &Matrix3<S>) -> Result<Self, LieError> {
        let rotation = SO3::project(m)?;
        Self::from_scale(rotation, rotation.to_matrix().dot(m) / S::lit(3.0))
    }
}

impl<S: Real> SE2<S> {
    /// The motion nearest to any 3×3 matrix; its last row is ignored.
    ///
    /// # Errors
    /// Those of [`SO2::project`].
    pub fn project(m: &Matrix3<S>) -> Result<Self, LieError> {
        let (block, t) = parts(m, 2)?;
        Ok(Self::from_parts(t, SO2::project(&block)?))
    }
}

impl<S: Real> SE3<S> {
    /// The motion nearest to any 4×4 matrix; its last row is ignored.
    ///
    /// # Errors
    /// Those of [`SO3::project`].
    pub fn project(m: &Matrix4<S>) -> Result<Self, LieError> {
        let (block, t) = parts(m, 3)?;
        Ok(Self::new(SO3::project(&block)?, t))
    }
}

impl<S: Real> SE23<S> {
    /// The extended pose nearest to any 5×5 matrix \[R v p; …\]; its last two rows are ignored.
    ///
    /// # Errors
    /// Those of [`SO3::project`].
    pub fn project(m: &SMatrix<S, 5, 5>) -> Result<Self, LieError> {
        let ((block, v), (_, p)) = (parts::<S, 5, 3>(m, 3)?, parts::<S, 5, 3>(m, 4)?);
        Ok(Self::new(SO3::project(&block)?, p, v))
    }
}

impl<S: Real> SGal3<S> {
    /// The Galilean transformation nearest to any 5×5 matrix \[R v p; · · t; …\]; of its last two rows only t is read.
    ///
    /// # Errors
    /// Those of [`SO3::project`].
    pub fn project(m: &SMatrix<S, 5, 5>) -> Result<Self, LieError> {
        let time = m[(3, 4)];
        finite(&[time])?;
        Ok(Self::from_extended(SE23::project(m)?, time))
    }
}

impl<S: Real> Sim2<S> {
    /// The similarity nearest to any 3×3 matrix; its last row is ignored.
    ///
    /// # Errors
    /// Those of [`SO2::project`].
    pub fn project(m: &Matrix3<S>) -> Result<Self, LieError> {
        let (block, t) = parts(m, 2)?;
        let x = RxSO2::project(&block)?;
        Ok(Self::new(x.rotation(), t, x.log_scale()))
    }
}

impl<S: Real> Sim3<S> {
    /// The similarity nearest to any 4×4 matrix; its last row is ignored.
    ///
    /// # Errors
    /// Those of [`SO3::project`].
    pub fn project(m: &Matrix4<S>) -> Result<Self, LieError> {
        let (block, t) = parts(m, 3)?;
        let x = RxSO3::project(&block)?;
        Ok(Self::new(x.rotation(), t, x.log_scale()))
    }
}
