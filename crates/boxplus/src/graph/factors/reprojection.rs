//! Points seen by cameras.

use core::marker::PhantomData;

use nalgebra::{SMatrix, SVector};

use crate::camera::{Camera, through_pose};
use crate::graph::{CameraVariable, Factor, PointVariable, ViewVariable};
use crate::lie::{Action, LieGroup, Real, Rn, SE3};

/// A point in the image of a known camera at `pose_from_camera` on a pose: the residual is predicted less measured, in pixels.
///
/// ```text
/// p = C⁻¹·(X⁻¹·l)     r = π(p) − z     ∂r/∂X = ∂π/∂p·R_Cᵀ·[−I, (X⁻¹l)^]     ∂r/∂l = ∂π/∂p·R_Cᵀ·R_Xᵀ      R×6 and R×3, local side
/// ```
///
/// π is the bare formula, [`Camera::image`]: a point behind the camera has a residual like any other. Ask [`Camera::sees`] which are.
///
/// ```
/// use boxplus::camera::{Camera, Pinhole};
/// use boxplus::graph::{Graph, Noise, Prior, Reprojection, SolveOptions, Values};
/// use boxplus::lie::{Action, LieGroup, Rn, SE3, SO3};
/// use nalgebra::vector;
/// // Two cameras a metre apart see a point 4 m ahead.
/// let (camera, point) = (Pinhole::new([500.0, 500.0], [320.0, 240.0]), vector![0.3, -0.2, 4.0]);
/// let (mut graph, mut values) = (Graph::new(), Values::new());
/// let landmark = values.insert(Rn::new(vector![0.0, 0.0, 2.0]));
/// for x in [0.0, 1.0] {
///     let pose = SE3::new(SO3::identity(), vector![x, 0.0, 0.0]);
///     let measured = camera.project(&pose.act_inverse(&point))?;
///     let key = values.insert(pose);
///     values.hold(key);
///     graph.add((key, landmark), Reprojection::new(camera, measured), Noise::unit());
/// }
/// let solution = graph.optimize(&values, &SolveOptions::default())?;
/// assert!((solution.values.get(landmark).unwrap().vector() - point).norm() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reprojection<C, const R: usize, const P: usize> {
    /// π, with intrinsics that are known.
    pub camera: C,
    /// C, where it sits on the body.
    pub pose_from_camera: SE3,
    /// z, in pixels.
    pub measured: SVector<f64, R>,
}

impl<C: Camera<R, P, Scalar = f64>, const R: usize, const P: usize> Reprojection<C, R, P> {
    /// A point seen by a camera in the origin of the pose.
    pub fn new(camera: C, measured: SVector<f64, R>) -> Self {
        Self { camera, pose_from_camera: SE3::identity(), measured }
    }
}

impl<C: Camera<R, P, Scalar = f64>, const R: usize, const P: usize> Factor<R> for Reprojection<C, R, P> {
    const NAME: &'static str = "reprojection";
    const RELATIVE: bool = true;
    type Variables = (SE3, Rn<3>);

    fn residual<S: Real>(&self, (x, l): &(SE3<S>, Rn<3, S>)) -> SVector<S, R> {
        let camera_from_pose = LieGroup::map(&self.pose_from_camera.inverse(), S::lit);
        let p = camera_from_pose.act(&x.act_inverse(&l.vector()));
        C::image_over(&self.camera.map(S::lit), &p) - self.measured.map(S::lit)
    }

    fn residual_jac(
        &self,
        (x, l): &(SE3, Rn<3>),
    ) -> (SVector<f64, R>, (SMatrix<f64, R, 6>, SMatrix<f64, R, 3>)) {
        let camera_from_pose = self.pose_from_camera.inverse();
        let (seen, w, d_seen_d_l) = l.seen_from_jac(x);
        let (image, d_p, _) = self.camera.image_jac(&camera_from_pose.act(&seen));
        let d_seen = d_p * camera_from_pose.rotation().to_matrix();
        (image - self.measured, (through_pose(&d_seen, &seen, w), d_seen * d_seen_d_l))
    }
}

/// A point in one of the images of a camera whose intrinsics are estimated, too: one variable, shared by all its images.
///
/// ```text
/// p = X⁻¹·l     r = π(p; c) − z     ∂r/∂X = ∂π/∂p·[−I, p^]     ∂r/∂l = ∂π/∂p·Rᵀ     ∂r/∂c = ∂π/∂c      R×6, R×3 and R×P
/// ```
///
/// π is the bare formula, as in [`Reprojection`]. The point is an [`Rn<3>`](Rn), or a [`Projective`](crate::camera::Projective) one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReprojectionShared<C, L, const R: usize> {
    /// z, in pixels.
    pub measured: SVector<f64, R>,
    variables: PhantomData<fn() -> (C, L)>,
}

impl<C, L, const R: usize> ReprojectionShared<C, L, R> {
    /// A point seen at `measured`, in pixels.
    pub fn new(measured: SVector<f64, R>) -> Self {
        Self { measured, variables: PhantomData }
    }
}

impl<C: CameraVariable<R>, L: PointVariable, const R: usize> Factor<R> for ReprojectionShared<C, L, R> {
    const NAME: &'static str = "reprojection";
    const RELATIVE: bool = true;
    type Variables = (SE3, L, C);

    fn residual<S: Real>(&self, (x, l, camera): &(SE3<S>, L::Over<S>, C::Over<S>)) -> SVector<S, R> {
        const { assert!(L::METRIC || R == 2, "a pair of cameras sees how far a point is") };
        C::image(camera, &L::seen_from(l, x)) - self.measured.map(S::lit)
    }

    fn residual_jac(
        &self,
        (x, l, camera): &(SE3, L, C),
    ) -> (SVector<f64, R>, (SMatrix<f64, R, 6>, L::Jacobian<R>, C::Jacobian<R>)) {
        let (p, w, d_p_d_l) = l.seen_from_jac(x);
        let (image, d_camera, d_p) = camera.image_jac(&p);
        (image - self.measured, (through_pose(&d_p, &p, w), L::jacobian(d_p * d_p_d_l), d_camera))
    }
}

/// A point in an image whose pose and intrinsics are one variable, a [`View`](crate::camera::View).
///
/// The residual and its derivatives are those of [`ReprojectionShared`]; one large block costs less than two, where no two images share
/// their intrinsics. It is not called relative, so that nothing is held for the gauge: that would hold the intrinsics of a view, too, which
/// its image does determine. Damped steps need no gauge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReprojectionOwn<V, L, const R: usize> {
    /// z, in pixels.
    pub measured: SVector<f64, R>,
    variables: PhantomData<fn() -> (V, L)>,
}

impl<V, L, const R: usize> ReprojectionOwn<V, L, R> {
    /// A point seen at `measured`, in pixels.
    pub fn new(measured: SVector<f64, R>) -> Self {
        Self { measured, variables: PhantomData }
    }
}

impl<V: ViewVariable<R>, L: PointVariable, const R: usize> Factor<R> for ReprojectionOwn<V, L, R> {
    const NAME: &'static str = "reprojection";
    type Variables = (V, L);

    #[inline]
    fn residual<S: Real>(&self, (view, l): &(V::Over<S>, L::Over<S>)) -> SVector<S, R> {
        V::image::<S, L>(view, l) - self.measured.map(S::lit)
    }

    #[inline]
    fn residual_jac(&self, (view, l): &(V, L)) -> (SVector<f64, R>, (V::Jacobian<R>, L::Jacobian<R>)) {
        let (image, d_view, d_l) = view.image_jac(l);
        (image - self.measured, (d_view, d_l))
    }
}
