//! Elements as plain numbers: to arrays and back, and slices of arrays seen as slices of elements.

use super::{Rn, RxSO2, RxSO3, S3, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3};
use crate::lie::{LieError, Real};

/// A group whose element is N plain numbers in a stated order.
///
/// Every group stores its element as one array, in the order of its tangent: position, rotation, then whatever else. The names of
/// [`Plain::FIELDS`] say it too, and `Debug`, `Display` and `serde` use them.
///
/// | group | numbers |
/// |---|---|
/// | [`Rn<N>`](crate::lie::Rn) | x₁ … x_N |
/// | [`SO2`](crate::lie::SO2) | cos θ, sin θ |
/// | [`SO3`](crate::lie::SO3) | quaternion x, y, z, **w last** |
/// | [`S3`](crate::lie::S3) | x, y, z, w, whose sign counts |
/// | [`RxSO2`](crate::lie::RxSO2) | cos θ, sin θ, σ |
/// | [`RxSO3`](crate::lie::RxSO3) | quaternion x, y, z, w, σ |
/// | [`SE2`](crate::lie::SE2) | t₁, t₂, cos θ, sin θ |
/// | [`SE3`](crate::lie::SE3) | t₁, t₂, t₃, quaternion x, y, z, w |
/// | [`SE23`](crate::lie::SE23) | position, quaternion x, y, z, w, velocity |
/// | [`SGal3`](crate::lie::SGal3) | position, quaternion x, y, z, w, velocity, time |
/// | [`Sim2`](crate::lie::Sim2) | t₁, t₂, cos θ, sin θ, σ |
/// | [`Sim3`](crate::lie::Sim3) | t₁, t₂, t₃, quaternion x, y, z, w, σ |
///
/// That of [`SE3`](crate::lie::SE3) is the order of TUM trajectories and of ROS poses, that of manif for every group they share.
///
/// ```
/// use boxplus::lie::{LieError, Plain, SE3};
/// let pose = SE3::from_array([1.0, 2.0, 3.0, 0.0, 0.0, 0.6, 0.8])?; // t, then the quaternion x, y, z, w
/// assert_eq!(pose.translation().y, 2.0);
/// assert_eq!(pose.to_array()[6], 0.8);
/// let halved = SE3::from_array([1.0, 2.0, 3.0, 0.0, 0.0, 0.3, 0.4]);
/// assert!(matches!(halved, Err(LieError::NotUnit { .. })));
/// # Ok::<(), LieError>(())
/// ```
pub trait Plain<const N: usize>: Copy {
    /// The scalar the numbers are written in.
    type Number: Real;
    /// The name of the group.
    const NAME: &'static str;
    /// Names and lengths of the parts of the array, in order; the lengths add up to N. Coordinates of ℝⁿ need no name.
    const FIELDS: &'static [(&'static str, usize)];

    /// The N stored numbers, exactly as they are.
    fn to_array(&self) -> [Self::Number; N];

    /// The element of these numbers. A rotation of unit norm to rounding (||q|² − 1| ≤ 16ε) keeps its bits, so that
    /// `from_array(to_array)` changes none; one that was rounded in print (≤ 10⁻⁵) is normalised.
    ///
    /// # Errors
    /// [`LieError::NotFinite`], or [`LieError::NotUnit`] where it is no rotation even by the number of digits of a text file.
    fn from_array(numbers: [Self::Number; N]) -> Result<Self, LieError>;

    /// Whether these numbers are an element as they stand, without normalising.
    ///
    /// # Errors
    /// [`LieError::NotFinite`], or [`LieError::NotUnit`] where ||q|² − 1| > 16ε.
    fn check_array(numbers: &[Self::Number; N]) -> Result<(), LieError>;
}

/// A slice of arrays is a slice of elements, without a copy: what a file mapped into memory or another library's buffer needs.
///
/// Checked as a whole first. The way back needs no check. A mutable slice of elements can only be given valid ones, so that the
/// arrays below stay valid, too. (Unchecked casts are `bytemuck`'s own: every group is a `TransparentWrapper` of its array.)
///
/// ```
/// use boxplus::lie::{LieError, LieGroup, PlainSlices, SE3};
/// let mut numbers = vec![[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0, 0.0, 0.6, 0.8]];
/// let poses: &[SE3] = SE3::slice_from_arrays(&numbers)?;
/// assert_eq!(poses[0].between(&poses[1]).translation().x, 1.0);
/// assert_eq!(SE3::as_arrays(poses), numbers);
/// SE3::slice_from_arrays_mut(&mut numbers)?[1] = SE3::identity();
/// assert_eq!(numbers[1], numbers[0]);
///
/// numbers[1][6] = f64::NAN;
/// let error = SE3::slice_from_arrays(&numbers).unwrap_err();
/// assert_eq!((error.index, error.reason), (1, LieError::NotFinite));
/// # Ok::<(), boxplus::lie::SliceError>(())
/// ```
#[cfg(feature = "bytemuck")]
pub trait PlainSlices<const N: usize>: Plain<N> + bytemuck::TransparentWrapper<[Self::Number; N]> {
    /// The arrays as elements, in place.
    ///
    /// # Errors
    /// The index of the first array that is no element, and why; see [`Plain::check_array`]. Numbers that only print rounding
    /// keeps from unit norm must be copied by [`Plain::from_array`], which normalises.
    fn slice_from_arrays(arrays: &[[Self::Number; N]]) -> Result<&[Self], SliceError> {
        check_arrays::<Self, N>(arrays)?;
        Ok(Self::wrap_slice(arrays))
    }

    /// The arrays as elements, in place, to be written.
    ///
    /// # Errors
    /// Those of [`Self::slice_from_arrays`].
    fn slice_from_arrays_mut(arrays: &mut [[Self::Number; N]]) -> Result<&mut [Self], SliceError> {
        check_arrays::<Self, N>(arrays)?;
        Ok(Self::wrap_slice_mut(arrays))
    }

    /// The elements as arrays, in place.
    fn as_arrays(elements: &[Self]) -> &[[Self::Number; N]] {
        Self::peel_slice(elements)
    }
}

#[cfg(feature = "bytemuck")]
impl<G, const N: usize> PlainSlices<N> for G where G: Plain<N> + bytemuck::TransparentWrapper<[G::Number; N]> {}

#[cfg(feature = "bytemuck")]
fn check_arrays<G: Plain<N>, const N: usize>(arrays: &[[G::Number; N]]) -> Result<(), SliceError> {
    arrays.iter().enumerate().try_for_each(|(index, numbers)| {
        G::check_array(numbers).map_err(|reason| SliceError { index, reason })
    })
}

/// Which array of a slice is no element, and why.
#[cfg(feature = "bytemuck")]
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("element {index} (counted from 0): {reason}")]
pub struct SliceError {
    /// Its place in the slice, from 0.
    pub index: usize,
    /// What is wrong with it.
    #[source]
    pub reason: LieError,
}

/// ||q|² − 1| above this many ε is more than the rounding of a normalisation, in any library.
const UNIT_ROUNDING: f64 = 16.0;
/// ||q|² − 1| of a quaternion printed with six decimals is below 2·Σ|qᵢ|·½·10⁻⁶ ≤ 2·10⁻⁶.
const UNIT_PRINTED: f64 = 1e-5;

/// |q|² − 1 of the numbers that must have unit norm, 0 where there are none; refuses what is not finite.
fn unit_deviation<S: Real>(numbers: &[S], unit: &[S]) -> Result<f64, LieError> {
    if numbers.iter().any(|x| !x.value().is_finite()) {
        return Err(LieError::NotFinite);
    }
    let square = unit.iter().fold(0.0, |sum, x| sum + x.value() * x.value());
    Ok(if unit.is_empty() { 0.0 } else { (square - 1.0).abs() })
}

/// Implements [`Plain`] for a group that stores its array: `unit` is what must have norm 1.
macro_rules! plain {
    ($($(const $m:ident,)? $group:ty, $n:expr, $name:literal, unit $unit:expr, $fields:expr;)*) => { $(
        impl<$(const $m: usize,)? S: Real> Plain<{ $n }> for $group {
            type Number = S;
            const NAME: &'static str = $name;
            const FIELDS: &'static [(&'static str, usize)] = $fields;

            #[inline]
            fn to_array(&self) -> [S; $n] {
                self.0
            }
            fn from_array(numbers: [S; $n]) -> Result<Self, LieError> {
                let deviation = unit_deviation(&numbers, &numbers[$unit])?;
                if deviation <= UNIT_ROUNDING * S::EPSILON {
                    Ok(Self(numbers))
                } else if deviation <= UNIT_PRINTED {
                    Ok(Self(numbers).normalize())
                } else {
                    Err(LieError::NotUnit { deviation })
                }
            }
            fn check_array(numbers: &[S; $n]) -> Result<(), LieError> {
                let deviation = unit_deviation(numbers, &numbers[$unit])?;
                if deviation <= UNIT_ROUNDING * S::EPSILON { Ok(()) } else { Err(LieError::NotUnit { deviation }) }
            }
        }
    )* };
}

plain! {
    const M, Rn<M, S>, M, "Rn", unit 0..0, &[("", M)];
    SO2<S>, 2, "SO2", unit 0..2, &[("cos_sin", 2)];
    SO3<S>, 4, "SO3", unit 0..4, &[("xyzw", 4)];
    SE2<S>, 4, "SE2", unit 2..4, &[("translation", 2), ("cos_sin", 2)];
    SE3<S>, 7, "SE3", unit 3..7, &[("translation", 3), ("xyzw", 4)];
    SE23<S>, 10, "SE23", unit 3..7, &[("position", 3), ("xyzw", 4), ("velocity", 3)];
    S3<S>, 4, "S3", unit 0..4, &[("xyzw", 4)];
    RxSO2<S>, 3, "RxSO2", unit 0..2, &[("cos_sin", 2), ("log_scale", 1)];
    RxSO3<S>, 5, "RxSO3", unit 0..4, &[("xyzw", 4), ("log_scale", 1)];
    SGal3<S>, 11, "SGal3", unit 3..7, &[("position", 3), ("xyzw", 4), ("velocity", 3), ("time", 1)];
    Sim2<S>, 5, "Sim2", unit 2..4, &[("translation", 2), ("cos_sin", 2), ("log_scale", 1)];
    Sim3<S>, 8, "Sim3", unit 3..7, &[("translation", 3), ("xyzw", 4), ("log_scale", 1)];
}

/// Calls a macro with every group that stores an array, and the length of the array.
macro_rules! every_plain {
    ($implement:ident) => {
        $implement! {
            const M, Rn<M, S>, M;
            SO2<S>, 2;
            SO3<S>, 4;
            SE2<S>, 4;
            SE3<S>, 7;
            SE23<S>, 10;
            S3<S>, 4;
            RxSO2<S>, 3;
            RxSO3<S>, 5;
            SGal3<S>, 11;
            Sim2<S>, 5;
            Sim3<S>, 8;
        }
    };
}
pub(crate) use every_plain;

impl<const N: usize, S: Real> Rn<N, S> {
    /// ℝⁿ has no norm to restore.
    fn normalize(self) -> Self {
        self
    }
}
