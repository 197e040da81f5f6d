//! ⟨ℝ³, SO(3)⟩: a translation and a rotation side by side, tangent (δt, φ), the translation's part in the parent frame.
//!
//! ```text
//! ⟨t, R⟩·⟨u, Q⟩ = ⟨t + u, RQ⟩      Exp(δt, φ) = ⟨δt, Exp φ⟩      Ad = [I, 0; 0, R]      J_r = [I, 0; 0, J_r(φ)]
//! SE(3): (t, R)·(u, Q) = (t + Ru, RQ)      Exp(ρ, φ) = (J_l(φ)ρ, Exp φ)      Ad = [R, t^R; 0, R]      J_r = [J_r(φ), Q; 0, J_r(φ)]
//! ```
//!
//! The same seven numbers as a pose, another group: here nothing couples. A step δt moves the origin in the *parent* frame
//! whatever the rotation, a mean averages translations and rotations apart, and interpolation runs along a straight line while
//! turning. In SE(3) ρ is in the *body* frame, a mean and an interpolation are those of a screw motion, and an arc driven at
//! constant speed is one Exp. Solvers and drone controllers that keep "position and attitude" use this group, often while calling
//! it SE(3); their covariances differ from those of SE(3) by [`R3xSO3::from_pose_jac`].
//!
//! Pitfall: it does not *act* on points as poses do. p ↦ R·p + t is no action of this product, for
//! (XY)·p = RQp + t + u is not X·(Y·p) = R(Qp + u) + t; take [`R3xSO3::pose`] to move points and to chain frames.
//!
//! ```
//! use boxplus::lie::{LieGroup, R3xSO3, SE3};
//! use nalgebra::{Vector3, Vector6};
//! let ahead_turning_left = Vector6::new(1.0, 0.0, 0.0, 0.0, 0.0, std::f64::consts::FRAC_PI_2);
//! let (pose, pair) = (SE3::exp(&ahead_turning_left), R3xSO3::exp(&ahead_turning_left));
//! assert_eq!(pair.translation(), Vector3::new(1.0, 0.0, 0.0)); // straight ahead
//! assert!((pose.translation() - Vector3::new(1.0, 1.0, 0.0) * (2.0 / std::f64::consts::PI)).norm() < 1e-15); // a quarter circle
//! assert_eq!(pose.rotation(), pair.rotation());
//! ```

use crate::lie::{Jacobian, LieError, LieGroup, Plain, Real, Rn, SE3, SO3};
use nalgebra::{Matrix6, Vector3};

crate::bundle! {
    /// ⟨ℝ³, SO(3)⟩: a translation and a rotation side by side, uncoupled. The numbers of a pose, but not SE(3).
    ///
    /// Tangent (δt, φ): δt moves the origin in the parent frame whatever the rotation, where ρ of SE(3) is in the body frame.
    /// Exp, Ad and J have no coupling block. It does not act on points: take [`R3xSO3::pose`] to move them.
    pub struct R3xSO3 {
        translation: Rn<3> [3],
        rotation: SO3 [3],
    }
}

impl<S: Real> R3xSO3<S> {
    /// ⟨`translation`, `rotation`⟩.
    #[inline]
    pub fn new(rotation: SO3<S>, translation: Vector3<S>) -> Self {
        Self { translation: Rn::new(translation), rotation }
    }

    /// t, in metres of the parent frame.
    #[inline]
    pub fn translation(&self) -> Vector3<S> {
        self.translation.vector()
    }

    /// R.
    #[inline]
    pub fn rotation(&self) -> SO3<S> {
        self.rotation
    }

    /// The parts of a pose.
    #[inline]
    pub fn from_pose(pose: &SE3<S>) -> Self {
        Self::new(pose.rotation(), pose.translation())
    }

    /// The pose (R, t), which moves points: p ↦ R·p + t.
    #[inline]
    pub fn pose(&self) -> SE3<S> {
        SE3::new(self.rotation, self.translation())
    }

    /// The parts of a pose: `(value, d_value_d_pose)`, the latter \[R, 0; 0, I\]: δt = R·ρ. Exact, so that
    /// a covariance of the pose becomes J·Σ·Jᵀ.
    #[inline]
    pub fn from_pose_jac(pose: &SE3<S>) -> (Self, Jacobian<S, 6>) {
        let mut d_pose = Matrix6::identity();
        d_pose.fixed_view_mut::<3, 3>(0, 0).copy_from(&pose.rotation().to_matrix());
        (Self::from_pose(pose), d_pose)
    }

    /// The pose (R, t): `(value, d_value_d_self)`, the latter \[Rᵀ, 0; 0, I\].
    #[inline]
    pub fn pose_jac(&self) -> (SE3<S>, Jacobian<S, 6>) {
        let (_, d_self) = Self::from_pose_jac(&SE3::new(self.rotation.inverse(), self.translation()));
        (self.pose(), d_self)
    }
}

/// The numbers of the pose: t₁, t₂, t₃, quaternion x, y, z, w.
impl<S: Real> Plain<7> for R3xSO3<S> {
    type Number = S;
    const NAME: &'static str = "R3xSO3";
    const FIELDS: &'static [(&'static str, usize)] = SE3::<S>::FIELDS;

    fn to_array(&self) -> [S; 7] {
        self.pose().to_array()
    }
    fn from_array(numbers: [S; 7]) -> Result<Self, LieError> {
        SE3::from_array(numbers).map(|pose| Self::from_pose(&pose))
    }
    fn check_array(numbers: &[S; 7]) -> Result<(), LieError> {
        SE3::check_array(numbers)
    }
}
