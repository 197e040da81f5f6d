//! Bundles: several groups side by side, which are a group again, block by block.

use super::Real;
use core::ops::Range;
use nalgebra::{SMatrix, SVector};

/// Where one block of a tangent ℝᴺ stands: D coordinates, one after another.
///
/// ```
/// use boxplus::lie::Block;
/// use nalgebra::{Vector3, Vector6};
/// const ROTATION: Block<3, 6> = Block::new(3); // of SE(3): (ρ, φ)
/// assert_eq!(ROTATION.of(&Vector6::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0)), Vector3::new(4.0, 5.0, 6.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block<const D: usize, const N: usize> {
    start: usize,
}

impl<const D: usize, const N: usize> Block<D, N> {
    /// The coordinates `start .. start + D`.
    ///
    /// # Panics
    /// Where they are not all among the N; in a constant that is an error of the compiler.
    pub const fn new(start: usize) -> Self {
        assert!(start <= N && D <= N - start, "the block does not fit into the tangent");
        Self { start }
    }

    /// Block number `index` of blocks of the given `sizes`, which follow one another.
    ///
    /// # Panics
    /// Where there is no such block or it does not fit; in a constant that is an error of the compiler.
    pub const fn nth(sizes: &[usize], index: usize) -> Self {
        let (mut start, mut i) = (0, 0);
        while i < index {
            start += sizes[i];
            i += 1;
        }
        assert!(sizes[index] == D, "the block has another size");
        Self::new(start)
    }

    /// The indices of its coordinates.
    pub const fn range(&self) -> Range<usize> {
        self.start..self.start + D
    }

    /// Its part of a tangent.
    #[inline]
    pub fn of<S: Real>(&self, tau: &SVector<S, N>) -> SVector<S, D> {
        tau.fixed_rows::<D>(self.start).into_owned()
    }

    /// Its part of a covariance, D×D: what is known of it when the other blocks are unknown.
    #[inline]
    pub fn marginal<S: Real>(&self, covariance: &SMatrix<S, N, N>) -> SMatrix<S, D, D> {
        covariance.fixed_view::<D, D>(self.start, self.start).into_owned()
    }

    /// Its covariance with another block, D×E.
    #[inline]
    pub fn cross<S: Real, const E: usize>(
        &self,
        other: &Block<E, N>,
        covariance: &SMatrix<S, N, N>,
    ) -> SMatrix<S, D, E> {
        covariance.fixed_view::<D, E>(self.start, other.start).into_owned()
    }

    /// Its columns of a Jacobian, M×D: the derivative by this block.
    #[inline]
    pub fn columns<S: Real, const M: usize>(&self, jacobian: &SMatrix<S, M, N>) -> SMatrix<S, M, D> {
        jacobian.fixed_columns::<D>(self.start).into_owned()
    }

    /// The tangent that moves this block by `part` and no other.
    #[inline]
    pub fn embed<S: Real>(&self, part: &SVector<S, D>) -> SVector<S, N> {
        let mut tau = SVector::zeros();
        self.set(&mut tau, part);
        tau
    }

    /// Overwrites its part of a tangent.
    #[inline]
    pub fn set<S: Real>(&self, tau: &mut SVector<S, N>, part: &SVector<S, D>) {
        tau.fixed_rows_mut::<D>(self.start).copy_from(part);
    }

    /// Overwrites its diagonal block of an N×N matrix.
    #[inline]
    pub fn set_diagonal<S: Real>(&self, matrix: &mut SMatrix<S, N, N>, part: &SMatrix<S, D, D>) {
        matrix.fixed_view_mut::<D, D>(self.start, self.start).copy_from(part);
    }

    /// Overwrites its columns of a Jacobian.
    #[inline]
    pub fn set_columns<S: Real, const M: usize>(
        &self,
        jacobian: &mut SMatrix<S, M, N>,
        part: &SMatrix<S, M, D>,
    ) {
        jacobian.fixed_columns_mut::<D>(self.start).copy_from(part);
    }
}

/// Makes a struct a Lie group: each field is a group with its dimension in brackets, the whole their product.
///
/// A state is rarely a pose alone: a rover also has biases, a calibration, a clock. Their product ⟨X₁, …, X_k⟩ is a Lie group of
/// dimension D = ΣDᵢ, in which nothing couples (Solà et al. (2018) §IV):
///
/// ```text
/// ⟨X₁, X₂⟩·⟨Y₁, Y₂⟩ = ⟨X₁Y₁, X₂Y₂⟩      Exp⟨τ₁, τ₂⟩ = ⟨Exp τ₁, Exp τ₂⟩      Ad = [Ad₁, 0; 0, Ad₂]      J_r = [J_r₁, 0; 0, J_r₂]
/// ```
///
/// This macro makes a struct of yours such a group. Its fields keep their names and types, and everything that works on a
/// [`LieGroup`](crate::lie::LieGroup) works on it. Its constant `BLOCKS` says where each field stands: a
/// [`Block`](crate::lie::Block) finds it in a tangent, in a covariance or in a Jacobian.
///
/// ```
/// use boxplus::bundle;
/// use boxplus::lie::{LieGroup, Rn, SE3};
/// use nalgebra::{SMatrix, SVector, Vector3};
///
/// bundle! {
///     /// Where a rover is, and what its gyroscope shows at rest.
///     pub struct Rover {
///         /// world_from_body.
///         pub pose: SE3 [6],
///         /// In rad/s.
///         pub bias: Rn<3> [3],
///     }
/// }
///
/// let start: Rover = Rover::identity();
/// let step = SVector::<f64, 9>::from_fn(|i, _| 0.125 * i as f64);
/// let end = start.rplus(&step);
/// assert_eq!(end.pose, SE3::exp(&Rover::BLOCKS.pose.of(&step)));
/// assert_eq!(end.bias.vector(), Vector3::new(0.75, 0.875, 1.0));
///
/// let covariance = SMatrix::<f64, 9, 9>::identity() * 0.01;
/// let of_pose: SMatrix<f64, 6, 6> = Rover::BLOCKS.pose.marginal(&covariance);
/// assert_eq!((of_pose[(5, 5)], Rover::BLOCKS.bias.range()), (0.01, 6..9));
/// ```
///
/// **⟨ℝ³, SO(3)⟩ is not SE(3).** Both hold a rotation and a translation, and differ in everything else: see
/// [`R3xSO3`](crate::lie::R3xSO3).
///
/// The struct is generic over the scalar, `Rover<S = f64>`, its fields are `SE3<S>`, `Rn<3, S>`; they are written without that
/// parameter. A field may be any group whose last parameter is the scalar: those of [`crate::lie`], one of your own,
/// another bundle. It gets
///
/// - [`LieGroup<D>`](crate::lie::LieGroup), D being the sum of the dimensions; its `Algebra` is the tuple of those of the fields;
/// - `Clone`, `Copy`, `Debug`, `PartialEq`, `Default` (the identity), `*` and `*=`; `Display` if all fields have it, and so with
///   serialisation, under the feature `serde`;
/// - the constant `BLOCKS`, which has for each field the [`Block`](crate::lie::Block) where it stands in a tangent;
/// - with `variable!` (feature `solve`), in one more line, a place in a factor graph.
///
/// ```
/// use boxplus::bundle;
/// use boxplus::lie::{LieGroup, Rn, SE3, SO3, laws};
///
/// bundle! {
///     struct Inertial { accelerometer: Rn<3> [3], gyroscope: Rn<3> [3] }
/// }
/// bundle! {
///     /// A body, its sensors' biases, and how its camera is mounted.
///     struct Body { world_from_body: SE3 [6], biases: Inertial [6], body_from_camera: SO3 [3] }
/// }
/// laws::check_group::<Body, 15>()?;
/// assert_eq!(Body::BLOCKS.body_from_camera.range(), 12..15);
/// # Ok::<(), laws::Violation>(())
/// ```
///
/// A wrong dimension does not compile:
///
/// ```compile_fail,E0277
/// boxplus::bundle! { struct Wrong { pose: boxplus::lie::SE3 [7] } }
/// ```
#[macro_export]
macro_rules! bundle {
    (
        $(#[$attribute:meta])*
        $visibility:vis struct $name:ident {
            $($(#[$field_attribute:meta])*
            $field_visibility:vis $field:ident: $($group:ident)::+ $(<$($argument:tt),+>)? [$d:expr]),+ $(,)?
        }
    ) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        $visibility struct $name<S: $crate::lie::Real = f64> {
            $($(#[$field_attribute])* $field_visibility $field: $($group)::+ <$($($argument,)+)? S>,)+
        }

        const _: () = {
            use $crate::lie::{Block, Jacobian, LieGroup, Real, Tangent};

            const SIZES: &[usize] = &[$($d),+];
            const N: usize = 0 $(+ $d)+;
            #[allow(non_camel_case_types)]
            enum Index { $($field),+ }

            #[doc = concat!("The blocks of a tangent of `", stringify!($name), "`, by the names of its fields.")]
            #[derive(Clone, Copy, Debug)]
            #[allow(dead_code)]
            pub struct Blocks {
                $(#[doc = concat!("Where `", stringify!($field), "` stands.")]
                pub $field: Block<{ $d }, N>,)+
            }

            impl $name {
                /// Where each field stands in a tangent, a covariance or a Jacobian.
                pub const BLOCKS: Blocks =
                    Blocks { $($field: Block::nth(SIZES, Index::$field as usize)),+ };
            }

            impl<S: Real> LieGroup<N> for $name<S> {
                type Scalar = S;
                type Over<T: Real> = $name<T>;
                type Algebra = ($(<$($group)::+ <$($($argument,)+)? S> as LieGroup<{ $d }>>::Algebra,)+);

                #[inline]
                fn identity() -> Self {
                    Self { $($field: LieGroup::<{ $d }>::identity()),+ }
                }
                #[inline]
                fn compose(&self, rhs: &Self) -> Self {
                    Self { $($field: self.$field.compose(&rhs.$field)),+ }
                }
                #[inline]
                fn inverse(&self) -> Self {
                    Self { $($field: self.$field.inverse()),+ }
                }
                #[inline]
                fn between(&self, other: &Self) -> Self {
                    Self { $($field: self.$field.between(&other.$field)),+ }
                }
                #[inline]
                fn exp(tau: &Tangent<S, N>) -> Self {
                    Self { $($field: LieGroup::exp(&$name::BLOCKS.$field.of(tau))),+ }
                }
                #[inline]
                fn log(&self) -> Tangent<S, N> {
                    let mut tau = Tangent::<S, N>::zeros();
                    $($name::BLOCKS.$field.set(&mut tau, &self.$field.log());)+
                    tau
                }
                #[inline]
                fn adjoint(&self) -> Jacobian<S, N> {
                    let mut matrix = Jacobian::<S, N>::zeros();
                    $($name::BLOCKS.$field.set_diagonal(&mut matrix, &self.$field.adjoint());)+
                    matrix
                }
                #[inline]
                fn adjoint_times(&self, tau: &Tangent<S, N>) -> Tangent<S, N> {
                    let mut moved = Tangent::<S, N>::zeros();
                    $(let part = self.$field.adjoint_times(&$name::BLOCKS.$field.of(tau));
                    $name::BLOCKS.$field.set(&mut moved, &part);)+
                    moved
                }
                $crate::__bundle_blocks!($name, small_adjoint, $($field: ($($group)::+ <$($($argument,)+)? S>)),+);
                $crate::__bundle_blocks!($name, right_jacobian, $($field: ($($group)::+ <$($($argument,)+)? S>)),+);
                $crate::__bundle_blocks!($name, right_jacobian_inverse, $($field: ($($group)::+ <$($($argument,)+)? S>)),+);
                $crate::__bundle_blocks!($name, left_jacobian, $($field: ($($group)::+ <$($($argument,)+)? S>)),+);
                $crate::__bundle_blocks!($name, left_jacobian_inverse, $($field: ($($group)::+ <$($($argument,)+)? S>)),+);
                #[inline]
                fn exp_jac(tau: &Tangent<S, N>) -> (Self, Jacobian<S, N>) {
                    let mut right = Jacobian::<S, N>::zeros();
                    let value = Self { $($field: {
                        let (x, j) = LieGroup::exp_jac(&$name::BLOCKS.$field.of(tau));
                        $name::BLOCKS.$field.set_diagonal(&mut right, &j);
                        x
                    }),+ };
                    (value, right)
                }
                #[inline]
                fn log_jac(&self) -> (Tangent<S, N>, Jacobian<S, N>) {
                    let (mut tau, mut right) = (Tangent::<S, N>::zeros(), Jacobian::<S, N>::zeros());
                    $(let (t, r) = self.$field.log_jac();
                    $name::BLOCKS.$field.set(&mut tau, &t);
                    $name::BLOCKS.$field.set_diagonal(&mut right, &r);)+
                    (tau, right)
                }
                #[inline]
                fn log_jacs(&self) -> (Tangent<S, N>, Jacobian<S, N>, Jacobian<S, N>) {
                    let mut tau = Tangent::<S, N>::zeros();
                    let (mut right, mut left) = (Jacobian::<S, N>::zeros(), Jacobian::<S, N>::zeros());
                    $(let (t, r, l) = self.$field.log_jacs();
                    $name::BLOCKS.$field.set(&mut tau, &t);
                    $name::BLOCKS.$field.set_diagonal(&mut right, &r);
                    $name::BLOCKS.$field.set_diagonal(&mut left, &l);)+
                    (tau, right, left)
                }
                fn hat(tau: &Tangent<S, N>) -> Self::Algebra {
                    ($(<$($group)::+ <$($($argument,)+)? S> as LieGroup<{ $d }>>::hat(&$name::BLOCKS.$field.of(tau)),)+)
                }
                fn vee(($($field,)+): &Self::Algebra) -> Tangent<S, N> {
                    let mut tau = Tangent::<S, N>::zeros();
                    $($name::BLOCKS.$field.set(
                        &mut tau,
                        &<$($group)::+ <$($($argument,)+)? S> as LieGroup<{ $d }>>::vee($field),
                    );)+
                    tau
                }
                fn map<T: Real>(&self, f: impl Fn(S) -> T) -> $name<T> {
                    $name { $($field: LieGroup::<{ $d }>::map(&self.$field, &f)),+ }
                }
            }

            impl<S: Real> Default for $name<S> {
                fn default() -> Self {
                    LieGroup::identity()
                }
            }

            /// The fields by name, with the formatter's precision.
            impl<S: Real> core::fmt::Display for $name<S>
            where
                $($($group)::+ <$($($argument,)+)? S>: core::fmt::Display,)+
            {
                fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                    f.write_str(concat!(stringify!($name), "("))?;
                    $(if Index::$field as usize > 0 {
                        f.write_str(", ")?;
                    }
                    f.write_str(concat!(stringify!($field), " "))?;
                    core::fmt::Display::fmt(&self.$field, f)?;)+
                    f.write_str(")")
                }
            }

            impl<S: Real> core::ops::MulAssign for $name<S> {
                #[inline]
                fn mul_assign(&mut self, rhs: Self) {
                    *self = self.compose(&rhs);
                }
            }

            impl<S: Real> core::ops::Mul for $name<S> {
                type Output = Self;
                #[inline]
                fn mul(self, rhs: Self) -> Self {
                    self.compose(&rhs)
                }
            }
        };
        $crate::__bundle_serialize!($name, $($field: ($($group)::+ <$($($argument,)+)? S>)),+);
    };
}

/// Without the feature `serde` a bundle has no serialisation.
#[cfg(not(feature = "serde"))]
#[doc(hidden)]
#[macro_export]
macro_rules! __bundle_serialize {
    ($($ignored:tt)*) => {};
}

/// A function of a tangent whose value is a block-diagonal matrix, for [`bundle!`](crate::bundle).
#[doc(hidden)]
#[macro_export]
macro_rules! __bundle_blocks {
    ($name:ident, $function:ident, $($field:ident: ($group:ty)),+) => {
        #[inline]
        fn $function(tau: &Tangent<S, N>) -> Jacobian<S, N> {
            let mut matrix = Jacobian::<S, N>::zeros();
            $($name::BLOCKS.$field.set_diagonal(&mut matrix, &<$group>::$function(&$name::BLOCKS.$field.of(tau)));)+
            matrix
        }
    };
}
