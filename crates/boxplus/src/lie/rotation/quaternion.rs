//! Quaternions: both orders, both conventions, and the tangent's factor ½.
//!
//! [`SO3`] *is* a unit quaternion, stored \[x, y, z, w\] with q and −q taken as one rotation. The unit quaternions themselves
//! form the sphere S³, which covers SO(3) twice and has the same tangent: Exp takes the rotation vector φ of SO(3) and
//! halves it inside, q = (sin(θ/2)·n, cos(θ/2)) (Solà et al. (2018), example 5). No measurement tells q from −q, hence SO(3)
//! is what everything here returns; [`S3`](crate::lie::S3) is for the rare case that tells them apart. `From` and `Into` lead
//! to and from [`nalgebra::UnitQuaternion`]. In the plane the unit complex numbers S¹ and SO(2) are one and the same,
//! [`SO2`](crate::lie::SO2) stores (cos θ, sin θ).
//!
//! **Order.** x, y, z, w: nalgebra, Eigen's memory, ROS, SciPy, glam, this library. w, x, y, z: Eigen's constructor, g2o's
//! theory papers, Ceres, Blender, MuJoCo, Drake. Nothing in four numbers tells which, hence every name here says it.
//!
//! **Convention.** Hamilton, ij = k, everywhere. JPL's quaternions (ij = −k: MSCKF, NASA) of one rotation have the same
//! scalar and the opposite vector; read as Hamilton's they are the inverse rotation, silently.
//!
//! **The factor ½.** To first order q ⊗ (½δ, 1) is R·Exp(δ): a step of 1 in q's tangent turns by 2 rad. Covariances of
//! "quaternion vector parts" are therefore a quarter of those of δ; [`SO3::quaternion_xyzw_jac`] has the factor in it.
//!
//! ```
//! use boxplus::lie::{LieGroup, SO3};
//! use nalgebra::{UnitQuaternion, Vector3};
//! let r: SO3 = SO3::about_z(0.8);
//! let [w, x, y, z] = r.quaternion_wxyz();
//! assert_eq!(r.quaternion_xyzw(), [x, y, z, w]);
//! assert_eq!(SO3::from_jpl_xyzw(r.quaternion_xyzw())?, r.inverse());
//! let q: UnitQuaternion<f64> = r.into();
//! assert!((q.angle() - 0.8).abs() < 1e-15);
//! assert_eq!(SO3::from(q), r);
//! # Ok::<(), boxplus::lie::LieError>(())
//! ```

use super::skew;
use crate::lie::{LieError, LieGroup, Real, SO3};
use nalgebra::{Matrix3, SMatrix, Vector3};

impl<S: Real> SO3<S> {
    /// The unit quaternion as \[w, x, y, z\]; its sign is arbitrary.
    #[inline]
    pub fn quaternion_wxyz(&self) -> [S; 4] {
        let [x, y, z, w] = self.quaternion_xyzw();
        [w, x, y, z]
    }

    /// The rotation of a JPL quaternion, vector first, of any norm but 0: Hamilton's is its conjugate.
    ///
    /// JPL quaternions mostly stand for `local_from_global`; what comes out is that same rotation of coordinates.
    ///
    /// # Errors
    /// Those of [`SO3::from_xyzw`].
    pub fn from_jpl_xyzw(quaternion: [S; 4]) -> Result<Self, LieError> {
        Ok(Self::from_xyzw(quaternion)?.inverse())
    }

    /// The JPL quaternion of this rotation, vector first.
    #[inline]
    pub fn quaternion_jpl_xyzw(&self) -> [S; 4] {
        self.inverse().quaternion_xyzw()
    }

    /// [`SO3::quaternion_xyzw`]: `(value, d_xyzw_d_self)`, 4×3: ½\[wI + v^; −vᵀ\].
    pub fn quaternion_xyzw_jac(&self) -> ([S; 4], SMatrix<S, 4, 3>) {
        let q @ [x, y, z, w] = self.quaternion_xyzw();
        let (v, half) = (Vector3::new(x, y, z), S::lit(0.5));
        let mut jacobian = SMatrix::<S, 4, 3>::zeros();
        let upper = (Matrix3::from_diagonal_element(w) + skew(&v)) * half;
        jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(&upper);
        jacobian.fixed_view_mut::<1, 3>(3, 0).copy_from(&(v.transpose() * -half));
        (q, jacobian)
    }

    /// [`SO3::from_xyzw`], which normalises: `(value, d_value_d_xyzw)`, 3×4: 2\[wI − v^, −v\]/|q|².
    ///
    /// # Errors
    /// Those of [`SO3::from_xyzw`].
    pub fn from_xyzw_jac(quaternion: [S; 4]) -> Result<(Self, SMatrix<S, 3, 4>), LieError> {
        let value = Self::from_xyzw(quaternion)?;
        // At unit norm, over the norm: squares of huge or tiny components would not be representable.
        let [x, y, z, w] = value.quaternion_xyzw();
        let along = quaternion.iter().zip([x, y, z, w]).fold(S::zero(), |sum, (a, b)| sum + *a * b);
        let (v, factor) = (Vector3::new(x, y, z), S::lit(2.0) / along);
        let mut jacobian = SMatrix::<S, 3, 4>::zeros();
        let left = (Matrix3::from_diagonal_element(w) - skew(&v)) * factor;
        jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(&left);
        jacobian.set_column(3, &(v * -factor));
        Ok((value, jacobian))
    }
}
