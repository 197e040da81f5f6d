//! A camera somewhere.

use super::{Camera, Unseen};
use crate::lie::{Action, Block, Jacobian, Manifold, Real, SE3, Tangent};
use nalgebra::{SMatrix, SVector, Vector3, vector};

/// The image of a point, R numbers, with its derivatives by the view, R×D, and by the point in the world, R×3.
pub type Viewed<S, const R: usize, const D: usize> = (SVector<S, R>, SMatrix<S, R, D>, SMatrix<S, R, 3>);

/// An image taken somewhere: the pose of its camera and the camera itself, D = 6 + P numbers that are estimated together.
///
/// The tangent is that of the pose, local side (ρ, φ), then the intrinsics, which are added to.
///
/// ```
/// use boxplus::camera::{Snavely, View};
/// use boxplus::lie::{LieGroup, Manifold, SE3};
/// use nalgebra::SVector;
/// let view = View { world_from_camera: SE3::identity(), camera: Snavely { focal: 500.0, distortion: [0.0, 0.0] } };
/// let mut step = SVector::<f64, 9>::zeros();
/// (step[2], step[6]) = (0.1, 5.0); // backwards, as this camera looks along −z, and a longer lens
/// let moved = view.plus(&step);
/// assert_eq!((moved.world_from_camera.translation().z, moved.camera.focal), (0.1, 505.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View<C: Manifold<P>, const P: usize, const D: usize> {
    /// Where it was taken.
    pub world_from_camera: SE3<C::Scalar>,
    /// By which camera.
    pub camera: C,
}

impl<C: Manifold<P>, const P: usize, const D: usize> View<C, P, D> {
    /// Where the pose stands in a tangent; the compiler refuses another D than 6 + P.
    pub const POSE: Block<6, D> = Block::new(0);
    /// Where the intrinsics stand.
    pub const INTRINSICS: Block<P, D> = {
        assert!(D == 6 + P, "the tangent of a view has six coordinates more than its camera has intrinsics");
        Block::new(6)
    };

    /// The image of a point of the world: the bare formula, as [`Camera::image`].
    #[inline]
    pub fn image<const R: usize>(&self, p_world: &Vector3<C::Scalar>) -> SVector<C::Scalar, R>
    where
        C: Camera<R, P>,
    {
        self.camera.image(&self.world_from_camera.act_inverse(p_world))
    }

    /// Its derivatives: `(image, d_image_d_view, d_image_d_p)`, R×D and R×3.
    #[inline]
    pub fn image_jac<const R: usize>(&self, p_world: &Vector3<C::Scalar>) -> Viewed<C::Scalar, R, D>
    where
        C: Camera<R, P>,
    {
        let p = self.world_from_camera.act_inverse(p_world);
        let (image, d_view, d_p) = self.image_of(&p, C::Scalar::lit(1.0));
        (image, d_view, d_p * self.world_from_camera.rotation().to_matrix().transpose())
    }

    /// The image of p = Rᵀ·(l − w·t), up to scale, with its derivatives by the view and by p: R×D and R×3.
    #[inline]
    pub(crate) fn image_of<const R: usize>(
        &self,
        p: &Vector3<C::Scalar>,
        w: C::Scalar,
    ) -> Viewed<C::Scalar, R, D>
    where
        C: Camera<R, P>,
    {
        let (image, d_p, d_intrinsics) = self.camera.image_jac(p);
        let mut d_view = SMatrix::zeros();
        Self::POSE.set_columns(&mut d_view, &through_pose(&d_p, p, w));
        Self::INTRINSICS.set_columns(&mut d_view, &d_intrinsics);
        (image, d_view, d_p)
    }

    /// Whether it sees a point of the world.
    ///
    /// # Errors
    /// [`Unseen`]: why not.
    pub fn sees<const R: usize>(&self, p_world: &Vector3<C::Scalar>) -> Result<(), Unseen>
    where
        C: Camera<R, P>,
    {
        self.camera.sees(&self.world_from_camera.act_inverse(p_world))
    }

    fn split(tau: &Tangent<C::Scalar, D>) -> (SVector<C::Scalar, 6>, SVector<C::Scalar, P>) {
        (Self::POSE.of(tau), Self::INTRINSICS.of(tau))
    }
    fn join(pose: &SVector<C::Scalar, 6>, intrinsics: &SVector<C::Scalar, P>) -> Tangent<C::Scalar, D> {
        Self::POSE.embed(pose) + Self::INTRINSICS.embed(intrinsics)
    }
    fn diagonal(
        pose: &SMatrix<C::Scalar, 6, 6>,
        intrinsics: &SMatrix<C::Scalar, P, P>,
    ) -> Jacobian<C::Scalar, D> {
        let mut jacobian = SMatrix::zeros();
        Self::POSE.set_diagonal(&mut jacobian, pose);
        Self::INTRINSICS.set_diagonal(&mut jacobian, intrinsics);
        jacobian
    }
}

/// The derivative of p = Rᵀ·(l − w·t) by the pose, local side, carried through that of an image by p: R×6.
///
/// ∂p/∂X = \[−w·I, p^\]; a row r times p^ is the cross product r × p.
#[inline]
pub(crate) fn through_pose<S: Real, const R: usize>(
    d_p: &SMatrix<S, R, 3>,
    p: &Vector3<S>,
    w: S,
) -> SMatrix<S, R, 6> {
    let mut d_pose = SMatrix::<S, R, 6>::zeros();
    for (mut row, d) in d_pose.row_iter_mut().zip(d_p.row_iter()) {
        let d = vector![d[0], d[1], d[2]];
        let (moved, turned) = (d * -w, d.cross(p));
        (row[0], row[1], row[2]) = (moved.x, moved.y, moved.z);
        (row[3], row[4], row[5]) = (turned.x, turned.y, turned.z);
    }
    d_pose
}

impl<C: Manifold<P>, const P: usize, const D: usize> Manifold<D> for View<C, P, D> {
    type Scalar = C::Scalar;
    type Over<S: Real> = View<C::Over<S>, P, D>;

    #[inline]
    fn plus(&self, tau: &Tangent<C::Scalar, D>) -> Self {
        let (pose, intrinsics) = Self::split(tau);
        Self { world_from_camera: self.world_from_camera.plus(&pose), camera: self.camera.plus(&intrinsics) }
    }
    fn minus(&self, base: &Self) -> Tangent<C::Scalar, D> {
        Self::join(&self.world_from_camera.minus(&base.world_from_camera), &self.camera.minus(&base.camera))
    }
    fn plus_jac(
        &self,
        tau: &Tangent<C::Scalar, D>,
    ) -> (Self, Jacobian<C::Scalar, D>, Jacobian<C::Scalar, D>) {
        let (pose, intrinsics) = Self::split(tau);
        let (world_from_camera, pose_self, pose_tau) = self.world_from_camera.plus_jac(&pose);
        let (camera, camera_self, camera_tau) = self.camera.plus_jac(&intrinsics);
        let sum = Self { world_from_camera, camera };
        (sum, Self::diagonal(&pose_self, &camera_self), Self::diagonal(&pose_tau, &camera_tau))
    }
    fn minus_jac(
        &self,
        base: &Self,
    ) -> (Tangent<C::Scalar, D>, Jacobian<C::Scalar, D>, Jacobian<C::Scalar, D>) {
        let (pose, pose_self, pose_base) = self.world_from_camera.minus_jac(&base.world_from_camera);
        let (camera, camera_self, camera_base) = self.camera.minus_jac(&base.camera);
        let tau = Self::join(&pose, &camera);
        (tau, Self::diagonal(&pose_self, &camera_self), Self::diagonal(&pose_base, &camera_base))
    }
    fn map<S: Real>(&self, f: impl Fn(C::Scalar) -> S) -> View<C::Over<S>, P, D> {
        let world_from_camera = Manifold::map(&self.world_from_camera, &f);
        View { world_from_camera, camera: self.camera.map(f) }
    }
}
