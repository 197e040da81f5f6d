//! Cameras: from a point in front of a lens to its image, and back.
//!
//! A camera model is a plain value with a handful of numbers, its intrinsics. [`Camera::project`] maps a point in the frame of the camera
//! to the image, in pixels, [`Camera::project_jac`] also gives the derivatives by the point and by the intrinsics in closed form, and
//! [`Camera::unproject`] gives the direction in which a pixel looks.
//!
//! | model | intrinsics | sees | source |
//! |---|---|---|---|
//! | [`Pinhole`] | f_x f_y c_x c_y, k₁ k₂ p₁ p₂ k₃ | z > 0, up to the fold of its lens | Brown (1966), as OpenCV |
//! | [`KannalaBrandt`] | f_x f_y c_x c_y, k₁ k₂ k₃ k₄ | angles below π, up to the fold | Kannala & Brandt (2006), as OpenCV's `fisheye` |
//! | [`DoubleSphere`] | f_x f_y c_x c_y, ξ α | more than a half space | Usenko, Demmel & Cremers (2018) |
//! | [`Snavely`] | f, k₁ k₂ | z < 0: it looks backwards | Snavely et al. (2006), as Bundler and BAL |
//! | [`Stereo`] | f_x f_y c_x c_y, b | z > 0 | a rectified pair |
//!
//! x points right in the image and z ahead, but for [`Snavely`]. Points are in metres, or in any unit: no image depends on it (that of
//! [`Stereo`] does).
//!
//! ```
//! use boxplus::camera::{Camera, KannalaBrandt, Unseen};
//! use nalgebra::{Vector3, vector};
//! let camera = KannalaBrandt { focal: [190.0, 190.0], centre: [254.0, 256.0], distortion: [3e-3, 7e-4, -2e-3, 2e-4] };
//! let beside = vector![1.0, -0.2, -0.1]; // more than a right angle from the axis: a fisheye sees it
//! let pixel = camera.project(&beside)?;
//! assert!((camera.unproject(&pixel)? - beside.normalize()).norm() < 1e-14);
//! assert_eq!(camera.project(&vector![0.0, 0.0, -1.0]), Err(Unseen::Behind));
//! # Ok::<(), Unseen>(())
//! ```
//!
//! # Pitfalls
//!
//! - **A formula knows no behind.** x/z is finite for z < 0, too, and an optimiser happily puts points there. [`Camera::project`] refuses
//!   them; [`Camera::image`] is the bare formula, which optimisers need (they may have to pass through), and whose user must count with
//!   [`Camera::sees`].
//! - **Lenses fold.** Polynomials of the radius turn back beyond some angle, so that a point far outside the image appears in its middle.
//!   Such points are [`Unseen::OutOfView`]: everything beyond the first fold is, also where the polynomial rises again.
//! - **Pixels count from the middle of the first one** in OpenCV and here, from its corner in COLMAP: half a pixel in c_x and c_y.

mod double_sphere;
mod kannala_brandt;
mod locate;
mod pinhole;
mod projective;
mod radial;
mod snavely;
mod stereo;
mod view;

pub use double_sphere::DoubleSphere;
pub use kannala_brandt::KannalaBrandt;
pub use locate::{LocateError, Located, locate_camera, locate_point, poses_of_three};
pub use pinhole::Pinhole;
pub use projective::Projective;
pub use snavely::Snavely;
pub use stereo::Stereo;
#[cfg(feature = "solve")]
pub(crate) use view::through_pose;
pub use view::{View, Viewed};

use crate::lie::{Manifold, Real};
use nalgebra::{SMatrix, SVector, Vector3};

/// Why a camera does not see a point, or no point appears at a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Unseen {
    /// The point is behind the camera, or in its centre.
    #[error(
        "the point is behind the camera or in its centre; is the pose inverted, or the camera one that looks along −z?"
    )]
    Behind,
    /// The model of the lens does not reach so far from the axis.
    #[error("the model of the lens does not reach so far from its axis: it folds, or ends, before")]
    OutOfView,
}

/// The image of a point, R numbers, with its derivatives by the point, R×3, and by the P intrinsics, R×P.
pub type Imaged<S, const R: usize, const P: usize> = (SVector<S, R>, SMatrix<S, R, 3>, SMatrix<S, R, P>);

/// A camera whose image of a point are R numbers (2, or 4 of a pair) and which has P intrinsics.
///
/// A model writes the bare formula and where it holds; all else follows. As a [`Manifold`] it moves by adding to its intrinsics.
pub trait Camera<const R: usize, const P: usize>: Manifold<P> {
    /// What the intrinsics are called, in their order.
    const INTRINSICS: &'static [&'static str];

    /// The intrinsics, in the order of [`Self::INTRINSICS`].
    fn intrinsics(&self) -> SVector<Self::Scalar, P>;
    /// The camera with these intrinsics.
    fn from_intrinsics(intrinsics: &SVector<Self::Scalar, P>) -> Self;
    /// The bare formula, without a question whether the camera sees the point: infinite or NaN in its poles.
    fn image(&self, p: &Vector3<Self::Scalar>) -> SVector<Self::Scalar, R>;
    /// The bare formula with its derivatives: `(image, d_image_d_p, d_image_d_intrinsics)`.
    fn image_jac(&self, p: &Vector3<Self::Scalar>) -> Imaged<Self::Scalar, R, P>;
    /// [`Self::image`] by the same model over another scalar, for who knows the model by this trait alone.
    fn image_over<S: Real>(camera: &Self::Over<S>, p: &Vector3<S>) -> SVector<S, R>;
    /// Whether the camera sees the point. (Looked up by value: for single numbers.)
    ///
    /// # Errors
    /// [`Unseen`]: why not.
    fn sees(&self, p: &Vector3<Self::Scalar>) -> Result<(), Unseen>;
    /// What appears there: a unit direction in the frame of the camera, the point itself for a pair.
    ///
    /// # Errors
    /// [`Unseen::OutOfView`], where nothing does.
    fn unproject(&self, image: &SVector<Self::Scalar, R>) -> Result<Vector3<Self::Scalar>, Unseen>;

    /// The image, in pixels, of a point in the frame of the camera.
    ///
    /// # Errors
    /// [`Unseen`], where the camera does not see it.
    fn project(&self, p: &Vector3<Self::Scalar>) -> Result<SVector<Self::Scalar, R>, Unseen> {
        self.sees(p).map(|()| self.image(p))
    }

    /// As [`Self::project`], with the derivatives: `(image, d_image_d_p, d_image_d_intrinsics)`.
    ///
    /// # Errors
    /// [`Unseen`], where the camera does not see it.
    fn project_jac(&self, p: &Vector3<Self::Scalar>) -> Result<Imaged<Self::Scalar, R, P>, Unseen> {
        self.sees(p).map(|()| self.image_jac(p))
    }
}

/// Makes a camera model the manifold of its intrinsics, moved by adding to them.
macro_rules! added_to {
    ($camera:ident, $r:literal, $p:literal) => {
        impl<S: Real> $crate::lie::Manifold<$p> for $camera<S> {
            type Scalar = S;
            type Over<T: Real> = $camera<T>;

            fn plus(&self, tau: &nalgebra::SVector<S, $p>) -> Self {
                Self::from_intrinsics(&(self.intrinsics() + tau))
            }
            fn minus(&self, base: &Self) -> nalgebra::SVector<S, $p> {
                self.intrinsics() - base.intrinsics()
            }
            fn plus_jac(
                &self,
                tau: &nalgebra::SVector<S, $p>,
            ) -> (Self, nalgebra::SMatrix<S, $p, $p>, nalgebra::SMatrix<S, $p, $p>) {
                (self.plus(tau), nalgebra::SMatrix::identity(), nalgebra::SMatrix::identity())
            }
            fn minus_jac(
                &self,
                base: &Self,
            ) -> (nalgebra::SVector<S, $p>, nalgebra::SMatrix<S, $p, $p>, nalgebra::SMatrix<S, $p, $p>) {
                let one = nalgebra::SMatrix::<S, $p, $p>::identity();
                (self.minus(base), one, -one)
            }
            fn map<T: Real>(&self, f: impl Fn(S) -> T) -> $camera<T> {
                $camera::from_intrinsics(&self.intrinsics().map(f))
            }
        }
    };
}
pub(crate) use added_to;

/// [`Unseen::Behind`] unless `ahead` > 0, which NaN is not.
fn in_front<S: Real>(ahead: S) -> Result<(), Unseen> {
    if ahead.value() > 0.0 { Ok(()) } else { Err(Unseen::Behind) }
}
