//! The one scalar bound of the library.

use nalgebra::SimdRealField;

/// A real scalar: `f32`, `f64`, or a dual number that carries exact derivatives.
///
/// Formulas are written once for every `Real`. They never branch on data with `if`; where two forms of one function
/// meet they call [`Real::choose`], so that a lane type (several numbers in lock-step) can join later.
pub trait Real: SimdRealField<Element: SimdRealField> + Copy + Send + Sync + 'static {
    /// Distance from 1 to the next number of the underlying float.
    const EPSILON: f64;
    /// Terms of a Horner series in θ² that reach full accuracy for θ² < 10 (12 in `f64`, 6 in `f32`); even, at most 12.
    const SERIES_TERMS: usize;

    /// The constant `x`, rounded to this scalar.
    fn lit(x: f64) -> Self;

    /// The value without its derivatives, as an `f64`.
    fn value(self) -> f64;

    /// `yes()` where `condition` holds, else `no()`; a single number evaluates one of them only.
    fn choose<T>(condition: bool, yes: impl FnOnce() -> T, no: impl FnOnce() -> T) -> T {
        if condition { yes() } else { no() }
    }

    /// The angle of the point (x, y), in \[−π, π\]. Derivatives of dual numbers are right on the axes, too, where atan(y/x) divides
    /// by zero or cancels; at (0, 0), where there are none, they are 0.
    #[inline]
    fn polar_angle(y: Self, x: Self) -> Self {
        y.simd_atan2(x)
    }
}

impl Real for f64 {
    const EPSILON: f64 = f64::EPSILON;
    const SERIES_TERMS: usize = 12;
    fn lit(x: f64) -> Self {
        x
    }
    fn value(self) -> f64 {
        self
    }
}

impl Real for f32 {
    const EPSILON: f64 = f32::EPSILON as f64;
    const SERIES_TERMS: usize = 6;
    fn lit(x: f64) -> Self {
        x as f32
    }
    fn value(self) -> f64 {
        f64::from(self)
    }
}

#[cfg(feature = "autodiff")]
impl<const N: usize> Real for num_dual::DualSVec64<N> {
    const EPSILON: f64 = f64::EPSILON;
    const SERIES_TERMS: usize = 12;
    fn lit(x: f64) -> Self {
        Self::from_re(x)
    }
    fn value(self) -> f64 {
        self.re
    }
    fn polar_angle(y: Self, x: Self) -> Self {
        super::dual::polar_angle(y, x)
    }
}
