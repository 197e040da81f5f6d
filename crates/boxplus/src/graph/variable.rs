//! What a graph can estimate, and what a factor can read.

use core::fmt::Debug;

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use num_dual::{Derivative, DualSVec64};

use crate::camera::{Camera, DoubleSphere, KannalaBrandt, Pinhole, Projective, Snavely, Stereo, View};
use crate::lie::{
    Action, LieGroup, R3xSO3, Real, Rn, RxSO2, RxSO3, S2, S3, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3,
};
use crate::trajectory::{ImuBias, Moving};

/// A variable of the graph: a point of a manifold with tangent space ℝᴰ, moved by X ⊞ δ on the local side.
///
/// Every group of [`crate::lie`] is one. [`variable!`](crate::variable) makes a user's own
/// [`Manifold`](crate::lie::Manifold) one too.
pub trait Variable: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// Dimension D of the tangent space.
    const DIM: usize;
    /// What messages call it, e.g. `"SE2"`.
    const NAME: &'static str;
    /// Names of the D coordinates of the tangent, for diagnoses, e.g. `["x", "y", "yaw"]`.
    const COORDINATES: &'static [&'static str];
    /// Whether holding one variable of this kind keeps a world of relative measurements in place: a pose or a rotation does,
    /// a point or a parameter does not.
    const POSE: bool = false;
    /// R×D: the derivative of an R-dimensional residual by this variable.
    type Jacobian<const R: usize>: JacobianBlock;
    /// The same variable written in another scalar.
    type Over<S: Real>: Copy;

    /// X ⊞ δ for a tangent `delta` of length D.
    fn retract(&self, delta: &[f64]) -> Self;
    /// X with its coordinates carried into `S` as constants.
    fn constant<S: Real>(&self) -> Self::Over<S>;
    /// X ⊞ δ for a `delta` of length D in `S`: what dual numbers differentiate.
    fn perturb<S: Real>(&self, delta: &[S]) -> Self::Over<S>;
    /// Exact derivative of `residual` at δ = 0, by dual numbers.
    fn derivative<const R: usize>(residual: &impl TangentResidual<R>) -> Self::Jacobian<R>;
    /// Whether every stored number is finite.
    fn is_finite(&self) -> bool;
}

/// A residual as a function of the tangent of one variable, for every scalar. (A closure cannot be generic.)
pub trait TangentResidual<const R: usize> {
    /// The residual at X ⊞ `delta`.
    fn at<S: Real>(&self, delta: &[S]) -> SVector<S, R>;
}

/// Exact R×D derivative of `residual` at δ = 0: one evaluation with D infinitesimals.
pub fn derivative<const R: usize, const D: usize>(residual: &impl TangentResidual<R>) -> SMatrix<f64, R, D> {
    let delta: [DualSVec64<D>; D] = core::array::from_fn(|i| {
        DualSVec64::new(0.0, Derivative::derivative_generic(nalgebra::Const::<D>, nalgebra::U1, i))
    });
    let r = residual.at(&delta);
    SMatrix::from_fn(|row, column| r[row].eps.0.map_or(0.0, |eps| eps[column]))
}

/// An R×D matrix of which only its variable knows the type: the numbers, column by column.
pub trait JacobianBlock: Copy + Debug + Send + Sync {
    /// All zeros.
    fn zeros() -> Self;
    /// The R·D numbers, column by column.
    fn as_slice(&self) -> &[f64];
    /// As [`Self::as_slice`], to write.
    fn as_mut_slice(&mut self) -> &mut [f64];
}

impl<const R: usize, const D: usize> JacobianBlock for SMatrix<f64, R, D> {
    fn zeros() -> Self {
        Self::zeros()
    }
    fn as_slice(&self) -> &[f64] {
        self.as_slice()
    }
    fn as_mut_slice(&mut self) -> &mut [f64] {
        self.as_mut_slice()
    }
}

/// A variable that is a group: its two ways of changing the scalar are one.
pub trait GroupVariable<const D: usize>: Variable + LieGroup<D, Scalar = f64> {
    /// The same element, seen as a group.
    fn group<S: Real>(x: &<Self as Variable>::Over<S>) -> <Self as LieGroup<D>>::Over<S>;
    /// The same element, seen as a variable.
    fn variable<S: Real>(x: &<Self as LieGroup<D>>::Over<S>) -> <Self as Variable>::Over<S>;
    /// The same matrix, seen as a Jacobian by this variable.
    fn jacobian<const R: usize>(matrix: SMatrix<f64, R, D>) -> Self::Jacobian<R>;
}

/// A variable that stands somewhere in ℝᴺ: a pose or a point.
pub trait Located<const N: usize>: Variable {
    /// Its position in the parent frame, in metres.
    fn position<S: Real>(x: &Self::Over<S>) -> SVector<S, N>;
    /// Its position and the N×D derivative on the local side.
    fn position_jac(&self) -> (SVector<f64, N>, Self::Jacobian<N>);
}

/// A variable that carries a body: points fixed to it stand in ℝᴺ. Planar and spatial poses, extended poses.
pub trait Carries<const N: usize>: Located<N> {
    /// X·p: the point `p` of the body, in metres of the parent frame.
    fn carry<S: Real>(x: &Self::Over<S>, p: &SVector<S, N>) -> SVector<S, N>;
    /// X·p and its N×D derivative on the local side.
    fn carry_jac(&self, p: &SVector<f64, N>) -> (SVector<f64, N>, Self::Jacobian<N>);
}

/// A camera that is a variable: its image of a point in its own frame are R numbers.
pub trait CameraVariable<const R: usize>: Variable {
    /// The bare formula of the image, [`Camera::image`].
    fn image<S: Real>(x: &Self::Over<S>, p: &Vector3<S>) -> SVector<S, R>;
    /// `(image, d_image_d_self, d_image_d_p)`.
    fn image_jac(&self, p: &Vector3<f64>) -> (SVector<f64, R>, Self::Jacobian<R>, SMatrix<f64, R, 3>);
}

/// A [`View`] that is a variable: its image of a point of the world are R numbers.
pub trait ViewVariable<const R: usize>: Variable {
    /// The bare formula of the image, [`Camera::image`].
    fn image<S: Real, L: PointVariable>(x: &Self::Over<S>, l: &L::Over<S>) -> SVector<S, R>;
    /// `(image, d_image_d_self, d_image_d_l)`.
    fn image_jac<L: PointVariable>(&self, l: &L) -> (SVector<f64, R>, Self::Jacobian<R>, L::Jacobian<R>);
}

/// A point of the world that cameras see.
pub trait PointVariable: Variable {
    /// Whether p has a length. A pair of cameras needs one; to a single camera p and s·p look alike.
    const METRIC: bool;
    /// p = Rᵀ·(l − w·t): the point in the frame of a pose, up to scale where it is not metric.
    fn seen_from<S: Real>(x: &Self::Over<S>, pose: &SE3<S>) -> Vector3<S>;
    /// `(p, w, d_p_d_self)`.
    fn seen_from_jac(&self, pose: &SE3) -> (Vector3<f64>, f64, Matrix3<f64>);
    /// A matrix by the tangent, seen as a Jacobian by this variable.
    fn jacobian<const R: usize>(matrix: SMatrix<f64, R, 3>) -> Self::Jacobian<R>;
}

/// Makes a [`Manifold`](crate::lie::Manifold) in `f64` a [`Variable`], and with `group` a [`LieGroup`] a
/// [`GroupVariable`] too: `variable!(group type, over, dimension, name, coordinates)`, where `over` is the type with
/// scalar `S`; with `pose` instead, also one that may be held for the gauge ([`Variable::POSE`]).
///
/// ```
/// use boxplus::graph::{Variable, Values};
/// use boxplus::lie::{Manifold, Real};
/// use nalgebra::{SMatrix, SVector, vector};
///
/// /// A positive length, moved by its logarithm: never negative, whatever the step.
/// #[derive(Clone, Copy, Debug, PartialEq)]
/// struct Length<S = f64>(S);
/// impl<S: Real> Manifold<1> for Length<S> {
///     type Scalar = S;
///     type Over<T: Real> = Length<T>;
///     fn plus(&self, tau: &SVector<S, 1>) -> Self { Self(self.0 * tau[0].simd_exp()) }
///     fn minus(&self, base: &Self) -> SVector<S, 1> { vector![(self.0 / base.0).simd_ln()] }
///     fn plus_jac(&self, tau: &SVector<S, 1>) -> (Self, SMatrix<S, 1, 1>, SMatrix<S, 1, 1>) {
///         (self.plus(tau), SMatrix::identity(), SMatrix::identity())
///     }
///     fn minus_jac(&self, base: &Self) -> (SVector<S, 1>, SMatrix<S, 1, 1>, SMatrix<S, 1, 1>) {
///         (self.minus(base), SMatrix::identity(), -SMatrix::<S, 1, 1>::identity())
///     }
///     fn map<T: Real>(&self, f: impl Fn(S) -> T) -> Length<T> { Length(f(self.0)) }
/// }
/// boxplus::variable!(Length, Length<S>, 1, "length", &["log length"]);
///
/// let mut values = Values::new();
/// let key = values.insert(Length(2.0));
/// assert_eq!(values.get(key), Some(&Length(2.0)));
/// ```
#[macro_export]
macro_rules! variable {
    (pose $type:ty, $over:ty, $dim:expr, $name:literal, $coordinates:expr) => {
        $crate::variable!(group $type, $over, $dim, $name, $coordinates, const POSE: bool = true;);
    };
    (group $(const $n:ident,)? $type:ty, $over:ty, $dim:expr, $name:literal, $coordinates:expr $(, $pose:item)?) => {
        $crate::variable!($(const $n,)? $type, $over, $dim, $name, $coordinates $(, $pose)?);
        impl $(<const $n: usize>)? $crate::graph::GroupVariable<{ $dim }> for $type {
            fn group<S: $crate::lie::Real>(x: &$over) -> $over {
                *x
            }
            fn variable<S: $crate::lie::Real>(x: &$over) -> $over {
                *x
            }
            fn jacobian<const R: usize>(
                matrix: $crate::nalgebra::SMatrix<f64, R, { $dim }>,
            ) -> $crate::nalgebra::SMatrix<f64, R, { $dim }> {
                matrix
            }
        }
    };
    ($(const $n:ident,)? $type:ty, $over:ty, $dim:expr, $name:literal, $coordinates:expr $(, $pose:item)?) => {
        impl $(<const $n: usize>)? $crate::graph::Variable for $type {
            const DIM: usize = $dim;
            const NAME: &'static str = $name;
            const COORDINATES: &'static [&'static str] = $coordinates;
            $($pose)?
            type Jacobian<const R: usize> = $crate::nalgebra::SMatrix<f64, R, { $dim }>;
            type Over<S: $crate::lie::Real> = $over;

            fn retract(&self, delta: &[f64]) -> Self {
                $crate::lie::Manifold::plus(self, &$crate::nalgebra::SVector::from_column_slice(delta))
            }
            fn constant<S: $crate::lie::Real>(&self) -> $over {
                $crate::lie::Manifold::map(self, S::lit)
            }
            fn perturb<S: $crate::lie::Real>(&self, delta: &[S]) -> $over {
                let x: $over = $crate::lie::Manifold::map(self, S::lit);
                $crate::lie::Manifold::plus(&x, &$crate::nalgebra::SVector::from_column_slice(delta))
            }
            fn derivative<const R: usize>(
                residual: &impl $crate::graph::TangentResidual<R>,
            ) -> Self::Jacobian<R> {
                $crate::graph::derivative::<R, { $dim }>(residual)
            }
            fn is_finite(&self) -> bool {
                let finite = core::cell::Cell::new(true);
                let _ = $crate::lie::Manifold::map(self, |x: f64| {
                    finite.set(finite.get() && x.is_finite());
                    x
                });
                finite.get()
            }
        }
    };
}

variable!(group const N, Rn<N>, Rn<N, S>, N, "Rn", &["x", "y", "z", "4th", "5th", "6th"]);
variable!(pose SO2, SO2<S>, 1, "SO2", &["yaw"]);
variable!(pose SE2, SE2<S>, 3, "SE2", &["x", "y", "yaw"]);
variable!(pose SO3, SO3<S>, 3, "SO3", &["rotation about x", "rotation about y", "rotation about z"]);
variable!(pose SE3, SE3<S>, 6, "SE3", &["x", "y", "z", "rotation about x", "rotation about y", "rotation about z"]);
variable!(pose R3xSO3, R3xSO3<S>, 6, "R3xSO3", &["x", "y", "z", "rotation about x", "rotation about y", "rotation about z"]);
variable!(pose SE23, SE23<S>, 9, "SE2(3)", &["x", "y", "z", "rotation about x", "rotation about y", "rotation about z", "velocity along x", "velocity along y", "velocity along z"]);
variable!(pose SGal3, SGal3<S>, 10, "SGal(3)", &["x", "y", "z", "rotation about x", "rotation about y", "rotation about z", "velocity along x", "velocity along y", "velocity along z", "time"]);
variable!(pose Sim3, Sim3<S>, 7, "Sim3", &["x", "y", "z", "rotation about x", "rotation about y", "rotation about z", "log scale"]);
variable!(pose RxSO3, RxSO3<S>, 4, "RxSO3", &["rotation about x", "rotation about y", "rotation about z", "log scale"]);
variable!(pose RxSO2, RxSO2<S>, 2, "RxSO2", &["yaw", "log scale"]);
variable!(pose S3, S3<S>, 3, "S3", &["rotation about x", "rotation about y", "rotation about z"]);
variable!(S2, S2<S>, 2, "S2", &["along the first basis vector", "along the second basis vector"]);
variable!(pose Sim2, Sim2<S>, 4, "Sim2", &["x", "y", "yaw", "log scale"]);

/// Cameras, and views of them: `model, R, P, D = 6 + P, names, intrinsics`.
macro_rules! cameras {
    ($($camera:ident, $r:literal, $p:literal, $d:literal, $name:literal, $view:literal, [$($intrinsic:literal),+];)+) => { $(
        variable!($camera, $camera<S>, $p, $name, &[$($intrinsic),+]);
        impl CameraVariable<$r> for $camera {
            #[inline]
            fn image<S: Real>(x: &$camera<S>, p: &Vector3<S>) -> SVector<S, $r> {
                Camera::image(x, p)
            }
            #[inline]
            fn image_jac(
                &self,
                p: &Vector3<f64>,
            ) -> (SVector<f64, $r>, SMatrix<f64, $r, $p>, SMatrix<f64, $r, 3>) {
                let (image, d_p, d_self) = Camera::image_jac(self, p);
                (image, d_self, d_p)
            }
        }
        variable!(View<$camera, $p, $d>, View<$camera<S>, $p, $d>, $d, $view,
            &["x", "y", "z", "rotation about x", "rotation about y", "rotation about z", $($intrinsic),+]);
        impl ViewVariable<$r> for View<$camera, $p, $d> {
            #[inline]
            fn image<S: Real, L: PointVariable>(x: &View<$camera<S>, $p, $d>, l: &L::Over<S>) -> SVector<S, $r> {
                const { assert!(L::METRIC || $r == 2, "a pair of cameras sees how far a point is") };
                Camera::image(&x.camera, &L::seen_from(l, &x.world_from_camera))
            }
            #[inline]
            fn image_jac<L: PointVariable>(
                &self,
                l: &L,
            ) -> (SVector<f64, $r>, SMatrix<f64, $r, $d>, L::Jacobian<$r>) {
                let (p, w, d_p_d_l) = l.seen_from_jac(&self.world_from_camera);
                let (image, d_view, d_p) = self.image_of(&p, w);
                (image, d_view, L::jacobian(d_p * d_p_d_l))
            }
        }
    )+ };
}
cameras! {
    Pinhole, 2, 9, 15, "pinhole camera", "pinhole view", ["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"];
    KannalaBrandt, 2, 8, 14, "fisheye camera", "fisheye view", ["fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4"];
    DoubleSphere, 2, 6, 12, "double sphere camera", "double sphere view", ["fx", "fy", "cx", "cy", "xi", "alpha"];
    Snavely, 2, 3, 9, "Snavely camera", "Snavely view", ["f", "k1", "k2"];
    Stereo, 4, 5, 11, "stereo camera", "stereo view", ["fx", "fy", "cx", "cy", "baseline"];
}

variable!(Projective, Projective<S>, 3, "projective point", &["x", "y", "z"]);

impl PointVariable for Rn<3> {
    const METRIC: bool = true;
    #[inline]
    fn seen_from<S: Real>(x: &Rn<3, S>, pose: &SE3<S>) -> Vector3<S> {
        pose.act_inverse(&x.vector())
    }
    #[inline]
    fn seen_from_jac(&self, pose: &SE3) -> (Vector3<f64>, f64, Matrix3<f64>) {
        (pose.act_inverse(&self.vector()), 1.0, pose.rotation().to_matrix().transpose())
    }
    #[inline]
    fn jacobian<const R: usize>(matrix: SMatrix<f64, R, 3>) -> SMatrix<f64, R, 3> {
        matrix
    }
}

impl PointVariable for Projective {
    const METRIC: bool = false;
    #[inline]
    fn seen_from<S: Real>(x: &Projective<S>, pose: &SE3<S>) -> Vector3<S> {
        pose.rotation().act_inverse(&(x.v - pose.translation() * x.w))
    }
    #[inline]
    fn seen_from_jac(&self, pose: &SE3) -> (Vector3<f64>, f64, Matrix3<f64>) {
        let (t, turn) = (pose.translation(), pose.rotation().to_matrix().transpose());
        let (d_v, d_w) = self.tangents();
        (turn * (self.v - t * self.w), self.w, turn * (d_v - t * d_w.transpose()))
    }
    #[inline]
    fn jacobian<const R: usize>(matrix: SMatrix<f64, R, 3>) -> SMatrix<f64, R, 3> {
        matrix
    }
}

impl<const N: usize> Located<N> for Rn<N> {
    fn position<S: Real>(x: &Rn<N, S>) -> SVector<S, N> {
        x.vector()
    }
    fn position_jac(&self) -> (SVector<f64, N>, SMatrix<f64, N, N>) {
        (self.vector(), SMatrix::identity())
    }
}

variable!(group ImuBias, ImuBias<S>, 6, "bias", &["gyroscope x", "gyroscope y", "gyroscope z", "accelerometer x", "accelerometer y", "accelerometer z"]);

// Of another number of parameters than the macro knows. Holding one would hold its velocity, too: no POSE.
impl<G: GroupVariable<D>, const D: usize, const R: usize, const N: usize> Variable for Moving<G, D, R, N> {
    const DIM: usize = N;
    const NAME: &'static str = "moving element";
    const COORDINATES: &'static [&'static str] = G::COORDINATES;
    type Jacobian<const K: usize> = SMatrix<f64, K, N>;
    type Over<S: Real> = Moving<<G as LieGroup<D>>::Over<S>, D, R, N>;

    fn retract(&self, delta: &[f64]) -> Self {
        self.rplus(&SVector::from_column_slice(delta))
    }
    fn constant<S: Real>(&self) -> <Self as Variable>::Over<S> {
        LieGroup::map(self, S::lit)
    }
    fn perturb<S: Real>(&self, delta: &[S]) -> <Self as Variable>::Over<S> {
        LieGroup::map(self, S::lit).rplus(&SVector::from_column_slice(delta))
    }
    fn derivative<const K: usize>(residual: &impl TangentResidual<K>) -> SMatrix<f64, K, N> {
        derivative(residual)
    }
    fn is_finite(&self) -> bool {
        self.value().is_finite()
            && self.motion().velocity.iter().chain(&self.motion().acceleration).all(|x| x.is_finite())
    }
}

impl<G: GroupVariable<D>, const D: usize, const R: usize, const N: usize> GroupVariable<N>
    for Moving<G, D, R, N>
{
    fn group<S: Real>(x: &<Self as Variable>::Over<S>) -> <Self as LieGroup<N>>::Over<S> {
        *x
    }
    fn variable<S: Real>(x: &<Self as LieGroup<N>>::Over<S>) -> <Self as Variable>::Over<S> {
        *x
    }
    fn jacobian<const K: usize>(matrix: SMatrix<f64, K, N>) -> SMatrix<f64, K, N> {
        matrix
    }
}

macro_rules! carries {
    ($($pose:ident $n:literal),+) => {
        $(impl Carries<$n> for $pose {
            fn carry<S: Real>(x: &$pose<S>, p: &SVector<S, $n>) -> SVector<S, $n> {
                x.act(p)
            }
            fn carry_jac(&self, p: &SVector<f64, $n>) -> (SVector<f64, $n>, Self::Jacobian<$n>) {
                let (place, d_self, _) = self.act_jac(p);
                (place, d_self)
            }
        })+
    };
}
carries!(SE2 2, SE3 3, SE23 3);

impl Located<2> for SE2 {
    fn position<S: Real>(x: &SE2<S>) -> SVector<S, 2> {
        x.translation()
    }
    fn position_jac(&self) -> (SVector<f64, 2>, SMatrix<f64, 2, 3>) {
        let mut jacobian = SMatrix::<f64, 2, 3>::zeros();
        jacobian.fixed_view_mut::<2, 2>(0, 0).copy_from(&self.rotation().to_matrix());
        (self.translation(), jacobian)
    }
}

impl Located<3> for SE3 {
    fn position<S: Real>(x: &SE3<S>) -> SVector<S, 3> {
        x.translation()
    }
    fn position_jac(&self) -> (SVector<f64, 3>, SMatrix<f64, 3, 6>) {
        let mut jacobian = SMatrix::<f64, 3, 6>::zeros();
        jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(&self.rotation().to_matrix());
        (self.translation(), jacobian)
    }
}

impl Located<3> for SE23 {
    fn position<S: Real>(x: &SE23<S>) -> SVector<S, 3> {
        x.position()
    }
    fn position_jac(&self) -> (SVector<f64, 3>, SMatrix<f64, 3, 9>) {
        let mut jacobian = SMatrix::<f64, 3, 9>::zeros();
        jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(&self.rotation().to_matrix());
        (self.position(), jacobian)
    }
}

impl Located<3> for R3xSO3 {
    fn position<S: Real>(x: &R3xSO3<S>) -> SVector<S, 3> {
        x.translation()
    }
    fn position_jac(&self) -> (SVector<f64, 3>, SMatrix<f64, 3, 6>) {
        let mut jacobian = SMatrix::<f64, 3, 6>::zeros();
        Self::BLOCKS.translation.set_columns(&mut jacobian, &SMatrix::identity());
        (self.translation(), jacobian)
    }
}
