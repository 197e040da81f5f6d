//! Other libraries' tangents: the order of their coordinates, and the side on which they perturb.
//!
//! A 6×6 covariance does not say whether its first three rows are metres or radians, nor in which frame. Most confusion between
//! libraries is of these two kinds, and both are settled exactly:
//!
//! - **Order.** With Π the permutation, theirs = Π·ours: τ' = Πτ, Σ' = ΠΣΠᵀ, J' = Π_out·J·Π_inᵀ. That is an [`Order`], one constant
//!   for each type of another library, in a module of the library's name.
//! - **Side.** A left (global) covariance is Σ_left = Ad_X Σ_right Ad_Xᵀ (Solà et al. (2018) (54)):
//!   [`LeftJacobians::covariance_to_left`](crate::lie::LeftJacobians::covariance_to_left) and its inverse.
//!
//! | library | SE(2) | SE(3) | SE₂(3) | SGal(3) | Sim(2) | Sim(3) | perturbs on the |
//! |---|---|---|---|---|---|---|---|
//! | boxplus | ρ, θ | ρ, φ | ρ, φ, ν | ρ, φ, ν, ι | ρ, θ, σ | ρ, φ, σ | right |
//! | [`gtsam`] 4.3 | ρ, θ | φ, ρ | φ, ρ, ν | φ, ν, ρ, ι | ρ, θ, σ | φ, ρ, σ | right |
//! | [`manif`] | ρ, θ | ρ, φ | ρ, φ, ν | ρ, ν, φ, ι | | | right |
//! | [`sophus`] | ρ, θ | ρ, φ | | | ρ, θ, σ | ρ, φ, σ | (says nothing) |
//! | [`lgmath`], Barfoot | | ρ, φ | | | | | left |
//! | [`barrau`], Brossard, and invariant filters | | φ, ρ | φ, ν, ρ | | | | left and right |
//! | [`kelly`] | | | | ρ, ν, φ, ι | | | right |
//! | [`ros`] | | t, then axes | | | | | the parent frame |
//!
//! The rows of GTSAM, manif, Sophus and lgmath are tested against numbers that these libraries computed
//! (`tests/reference/tangent_orders.csv`), Exp and Ad.
//!
//! ```
//! use boxplus::lie::{LeftJacobians, LieGroup, SE3, orders};
//! use nalgebra::{Matrix6, Vector6};
//! let ours = Vector6::new(1.0, 2.0, 3.0, 0.1, 0.2, 0.3); // metres, then radians
//! assert_eq!(orders::gtsam::POSE3.to_theirs(&ours), Vector6::new(0.1, 0.2, 0.3, 1.0, 2.0, 3.0));
//!
//! let marginal_from_gtsam = Matrix6::from_diagonal(&Vector6::new(0.01, 0.01, 0.04, 1.0, 1.0, 4.0));
//! let covariance = orders::gtsam::POSE3.matrix_to_ours(&marginal_from_gtsam);
//! assert_eq!((covariance[(2, 2)], covariance[(5, 5)]), (4.0, 0.04));
//! // The same uncertainty, perturbed on the left as lgmath does:
//! let pose = SE3::exp(&ours);
//! let global = pose.covariance_to_left(&covariance);
//! assert!((pose.covariance_to_right(&global) - covariance).amax() < 1e-12);
//! ```

use super::Real;
use nalgebra::{SMatrix, SVector};

/// How another library orders a tangent ℝᴰ: a permutation, applied exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Order<const D: usize> {
    ours: [usize; D],
}

impl<const D: usize> Order<D> {
    /// The order in which coordinate i of theirs is coordinate `ours[i]` of ours.
    ///
    /// # Panics
    /// Unless `ours` has each of 0 … D − 1 once; in a constant that is an error of the compiler.
    pub const fn new(ours: [usize; D]) -> Self {
        let (mut seen, mut i) = ([false; D], 0);
        while i < D {
            assert!(
                ours[i] < D && !seen[ours[i]],
                "not a permutation: a coordinate is missing or named twice"
            );
            seen[ours[i]] = true;
            i += 1;
        }
        Self { ours }
    }

    /// Theirs is ours.
    pub const fn same() -> Self {
        let (mut ours, mut i) = ([0; D], 0);
        while i < D {
            ours[i] = i;
            i += 1;
        }
        Self { ours }
    }

    /// The order that leads back: its theirs is our ours.
    pub const fn inverse(self) -> Self {
        let (mut theirs, mut i) = ([0; D], 0);
        while i < D {
            theirs[self.ours[i]] = i;
            i += 1;
        }
        Self { ours: theirs }
    }

    /// Blocks of three in the order `blocks`, then the coordinates that remain.
    const fn of_triples<const K: usize>(blocks: [usize; K]) -> Self {
        let (mut ours, mut i) = (Self::same().ours, 0);
        while i < 3 * K {
            ours[i] = 3 * blocks[i / 3] + i % 3;
            i += 1;
        }
        Self::new(ours)
    }

    /// Π, D×D: theirs = Π·ours.
    pub fn permutation<S: Real>(self) -> SMatrix<S, D, D> {
        self.rows_to_theirs(&SMatrix::identity())
    }

    /// τ' = Πτ.
    #[inline]
    pub fn to_theirs<S: Real>(self, tau: &SVector<S, D>) -> SVector<S, D> {
        self.rows_to_theirs(tau)
    }

    /// τ = Πᵀτ'.
    #[inline]
    pub fn to_ours<S: Real>(self, theirs: &SVector<S, D>) -> SVector<S, D> {
        self.rows_to_ours(theirs)
    }

    /// ΠMΠᵀ: a covariance, an information matrix, or a Jacobian from this tangent to itself, D×D.
    pub fn matrix_to_theirs<S: Real>(self, ours: &SMatrix<S, D, D>) -> SMatrix<S, D, D> {
        self.columns_to_theirs(&self.rows_to_theirs(ours))
    }

    /// ΠᵀMΠ, the inverse of [`Self::matrix_to_theirs`].
    pub fn matrix_to_ours<S: Real>(self, theirs: &SMatrix<S, D, D>) -> SMatrix<S, D, D> {
        self.columns_to_ours(&self.rows_to_ours(theirs))
    }

    /// ΠJ, D×N: a derivative *of* this tangent.
    pub fn rows_to_theirs<S: Real, const N: usize>(self, ours: &SMatrix<S, D, N>) -> SMatrix<S, D, N> {
        SMatrix::from_fn(|i, j| ours[(self.ours[i], j)])
    }

    /// ΠᵀJ, D×N, the inverse of [`Self::rows_to_theirs`].
    pub fn rows_to_ours<S: Real, const N: usize>(self, theirs: &SMatrix<S, D, N>) -> SMatrix<S, D, N> {
        self.inverse().rows_to_theirs(theirs)
    }

    /// JΠᵀ, M×D: a derivative *by* this tangent.
    pub fn columns_to_theirs<S: Real, const M: usize>(self, ours: &SMatrix<S, M, D>) -> SMatrix<S, M, D> {
        SMatrix::from_fn(|i, j| ours[(i, self.ours[j])])
    }

    /// JΠ, M×D, the inverse of [`Self::columns_to_theirs`].
    pub fn columns_to_ours<S: Real, const M: usize>(self, theirs: &SMatrix<S, M, D>) -> SMatrix<S, M, D> {
        self.inverse().columns_to_theirs(theirs)
    }
}

/// GTSAM 4.3: rotation first in space, translation first in the plane; perturbs on the right, by Expmap.
pub mod gtsam {
    use super::Order;

    /// `Pose2`: (x, y, θ), as ours.
    pub const POSE2: Order<3> = Order::same();
    /// `Pose3`: (φ, ρ).
    pub const POSE3: Order<6> = Order::of_triples([1, 0]);
    /// `NavState`, which is [`SE23`](crate::lie::SE23): (φ, ρ, ν).
    pub const NAV_STATE: Order<9> = Order::of_triples([1, 0, 2]);
    /// `Gal3`, which is [`SGal3`](crate::lie::SGal3): (φ, ν, ρ, ι).
    pub const GAL3: Order<10> = Order::of_triples([1, 2, 0]);
    /// `Similarity2`: (ρ, θ, σ), as ours. Its translation is ours divided by the scale: p ↦ s(Rp + t).
    pub const SIMILARITY2: Order<4> = Order::same();
    /// `Similarity3`: (φ, ρ, σ). Its translation is ours divided by the scale: p ↦ s(Rp + t).
    pub const SIMILARITY3: Order<7> = Order::of_triples([1, 0]);
}

/// manif: translation first; perturbs on the right.
pub mod manif {
    use super::Order;

    /// `SE2`: (ρ, θ), as ours.
    pub const SE2: Order<3> = Order::same();
    /// `SE3`: (ρ, φ), as ours.
    pub const SE3: Order<6> = Order::same();
    /// `SE_2_3`: (ρ, φ, ν), as ours.
    pub const SE_2_3: Order<9> = Order::same();
    /// `SGal3`: (ρ, ν, φ, ι).
    pub const SGAL3: Order<10> = Order::of_triples([0, 2, 1]);
}

/// Sophus: translation (υ) before rotation (ω) before log scale, as ours.
pub mod sophus {
    use super::Order;

    /// `SE2`: (υ, θ).
    pub const SE2: Order<3> = Order::same();
    /// `SE3`: (υ, ω).
    pub const SE3: Order<6> = Order::same();
    /// `Sim2`: (υ, θ, σ).
    pub const SIM2: Order<4> = Order::same();
    /// `Sim3`: (υ, ω, σ).
    pub const SIM3: Order<7> = Order::same();
}

/// lgmath and Barfoot (2024): order as ours, but on the left, and mostly of T = vehicle_from_inertial.
///
/// Since (Exp(ε)·T)⁻¹ = T⁻¹·Exp(−ε), their covariance of T *is* our covariance of X = T⁻¹, to the last bit. Where their
/// T is taken for our X instead, it is a left covariance of X:
/// [`covariance_to_right`](crate::lie::LeftJacobians::covariance_to_right) gives ours.
///
/// ```
/// use boxplus::lie::{LeftJacobians, LieGroup, SE3, orders};
/// use nalgebra::{Matrix6, Vector6};
/// let vehicle_from_inertial = SE3::exp(&Vector6::new(1.0, 2.0, 3.0, 0.1, 0.2, 0.3));
/// let theirs = Matrix6::from_diagonal(&Vector6::new(1.0, 2.0, 3.0, 0.1, 0.2, 0.3));
/// let of_inertial_from_vehicle = orders::lgmath::SE3.matrix_to_ours(&theirs);
/// let of_vehicle_from_inertial = vehicle_from_inertial.covariance_to_right(&theirs);
/// // Inverting X carries its covariance by Ad_X: the two agree.
/// let ad = vehicle_from_inertial.inverse().adjoint();
/// assert!((of_vehicle_from_inertial - ad * of_inertial_from_vehicle * ad.transpose()).amax() < 1e-12);
/// ```
pub mod lgmath {
    use super::Order;

    /// Transformations: (ρ, φ).
    pub const SE3: Order<6> = Order::same();
}

/// Barrau and Bonnabel (2017), Brossard et al. (2022), and most invariant filters: rotation, velocity, position.
///
/// Their left-invariant error X̂⁻¹X is our right perturbation, their right-invariant error XX̂⁻¹ our left one.
pub mod barrau {
    use super::Order;

    /// Poses: (φ, ρ).
    pub const SE3: Order<6> = Order::of_triples([1, 0]);
    /// Extended poses: (φ, ν, ρ).
    pub const SE23: Order<9> = Order::of_triples([1, 2, 0]);
}

/// Kelly (2023): the Galilean group, in the order of its matrix.
pub mod kelly {
    use super::Order;

    /// (ρ, ν, φ, ι).
    pub const SGAL3: Order<10> = Order::of_triples([0, 2, 1]);
}

/// ROS messages: a position and three rotations, both about the axes of the parent frame.
///
/// `geometry_msgs/PoseWithCovariance` has the numbers of a 6×6 matrix row by row, in the order (x, y, z, rotation about X,
/// about Y, about Z), "the orientation parameters use a fixed-axis representation". So its position moves in the frame of the
/// header and its rotation is about that frame's axes: t + δt and Exp(δθ)·R, where ours are R·ρ = δt and R·φ = δθ. That is neither
/// our right perturbation nor a left perturbation of SE(3), whose rotation swings the position around the origin.
///
/// Three finite rotations about fixed axes differ from Exp(δθ) in second order, which no covariance sees: the conversion is
/// exact. Programs that write the variances of the angles roll, pitch, yaw *themselves* deviate from the message's
/// definition except near zero pitch and yaw; their numbers have to pass through the derivative of those angles first.
///
/// `TwistWithCovariance` is in the child frame, (linear, angular): [`ros::TWIST`], as ours.
pub mod ros {
    use super::Order;
    use crate::lie::{Jacobian, Real, SE3};
    use nalgebra::Matrix6;

    /// `Twist`: (linear, angular), in the frame of the body.
    pub const TWIST: Order<6> = Order::same();

    /// Our covariance of `pose`, local, from the 36 numbers of a `PoseWithCovariance`: B·Σ'·Bᵀ with B = \[Rᵀ, 0; 0, Rᵀ\].
    ///
    /// ```
    /// use boxplus::lie::{SE3, SO3, orders::ros};
    /// use nalgebra::{Vector3, Vector6, Matrix6};
    /// let facing_left = SO3::from_xyzw([0.0, 0.0, 1.0, 1.0])?; // +90° about z
    /// let pose = SE3::new(facing_left, Vector3::new(5.0, 0.0, 0.0));
    /// let mut message = [0.0; 36];
    /// (message[0], message[7]) = (4.0, 1.0); // 2 m along the map's x, 1 m along its y
    /// let ours = ros::pose_covariance_to_ours(&pose, &message);
    /// let expected = Matrix6::from_diagonal(&Vector6::new(1.0, 4.0, 0.0, 0.0, 0.0, 0.0)); // 1 m ahead, 2 m to the side
    /// assert!((ours - expected).amax() < 1e-14);
    /// # Ok::<(), boxplus::lie::LieError>(())
    /// ```
    pub fn pose_covariance_to_ours<S: Real>(pose: &SE3<S>, theirs: &[S; 36]) -> Jacobian<S, 6> {
        let b = turned(pose).transpose();
        b * Matrix6::from_row_slice(theirs) * b.transpose()
    }

    /// The 36 numbers of a `PoseWithCovariance`, by rows, of a `pose` with our local covariance.
    pub fn pose_covariance_to_theirs<S: Real>(pose: &SE3<S>, ours: &Jacobian<S, 6>) -> [S; 36] {
        let b = turned(pose);
        let theirs = b * ours * b.transpose();
        core::array::from_fn(|i| theirs[(i / 6, i % 6)])
    }

    /// ∂(δt, δθ)/∂(ρ, φ) = \[R, 0; 0, R\].
    fn turned<S: Real>(pose: &SE3<S>) -> Jacobian<S, 6> {
        let (r, mut m) = (pose.rotation().to_matrix(), Matrix6::zeros());
        m.fixed_view_mut::<3, 3>(0, 0).copy_from(&r);
        m.fixed_view_mut::<3, 3>(3, 3).copy_from(&r);
        m
    }
}
