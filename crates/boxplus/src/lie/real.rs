//! The one scalar bound of the library.

use super::elementary;
use nalgebra::{SMatrix, SimdBool, SimdComplexField, SimdRealField};

/// A real scalar: `f32`, `f64`, a dual number that carries exact derivatives, or several numbers in lock-step (lanes).
///
/// Formulas are written once for every `Real`. They never branch on data with `if`; where two forms of one function
/// meet they call [`Real::choose`] with a mask, the result of a comparison such as `simd_lt`.
pub trait Real: SimdRealField<Element: SimdRealField> + Copy + Send + Sync + 'static {
    /// Distance from 1 to the next number of the underlying float.
    const EPSILON: f64;
    /// Terms of a Horner series in θ² that reach full accuracy for θ² < 10 (12 in `f64`, 6 in `f32`); even, at most 12.
    const SERIES_TERMS: usize;

    /// The constant `x`, rounded to this scalar.
    fn lit(x: f64) -> Self;

    /// The value without its derivatives, as an `f64`. For what inspects one number, such as checks of input; of lanes
    /// the first.
    fn value(self) -> f64;

    /// (sin x, cos x).
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sin_cos(self) -> (Self, Self) {
        self.simd_sin_cos()
    }

    /// eˣ.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn exp(self) -> Self {
        self.simd_exp()
    }

    /// The angle of the point (x, y), in \[−π, π\]. Derivatives of dual numbers are right on the axes, too, where atan(y/x)
    /// divides by zero or cancels; at (0, 0), where there are none, they are 0.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn polar_angle(y: Self, x: Self) -> Self {
        y.simd_atan2(x)
    }

    /// θ/sin θ with sin² θ and cos θ ≥ 0 given: 1 at θ = 0, where nothing is divided, and π/2 at a right angle.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn angle_over_sine(_sin_squared: Self, cos: Self) -> Self {
        elementary::arc(cos)
    }

    /// The nearest whole number, a constant: its derivative is 0.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn nearest(self) -> Self {
        Self::lit(self.value().simd_round())
    }

    /// `yes()` where `mask` holds, else `no()`. Both are evaluated only where lanes disagree, hence never for one number.
    ///
    /// ```
    /// use boxplus::lie::Real;
    /// fn magnitude<S: Real>(x: S) -> S {
    ///     S::choose(x.simd_lt(S::zero()), || -x, || x)
    /// }
    /// assert_eq!([magnitude(-2.0), magnitude(3.0)], [2.0, 3.0]);
    /// ```
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn choose<T: Blend<Self>>(mask: Self::SimdBool, yes: impl FnOnce() -> T, no: impl FnOnce() -> T) -> T {
        if mask.all() {
            yes()
        } else if mask.none() {
            no()
        } else {
            T::blend(mask, yes(), no())
        }
    }

    /// Itself where `mask` holds, so that the common form of a function serves; `None` calls for the rare one. Lanes always
    /// take the common form, with NaN where `mask` fails, which tells a batch to compute that element alone.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn common(self, mask: Self::SimdBool) -> Option<Self> {
        mask.all().then_some(self)
    }
}

/// NaN of lanes, nothing of single numbers: for what batches do not vectorise and had better compute alone, such as long series,
/// which are loops, and matrices too large for the first cache.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn of_lanes<S: Real>(x: S) -> Option<S> {
    x.common(x.simd_lt(x))
}

/// What [`Real::choose`] chooses between: scalars, and what is made of them.
pub trait Blend<S: Real> {
    /// The lanes of `yes` where `mask` holds, those of `no` elsewhere.
    fn blend(mask: S::SimdBool, yes: Self, no: Self) -> Self;
}

impl<S: Real> Blend<S> for S {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn blend(mask: S::SimdBool, yes: Self, no: Self) -> Self {
        yes.select(mask, no)
    }
}

impl<S: Real, T: Blend<S> + Copy, const N: usize> Blend<S> for [T; N] {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn blend(mask: S::SimdBool, yes: Self, no: Self) -> Self {
        core::array::from_fn(|i| T::blend(mask, yes[i], no[i]))
    }
}

impl<S: Real, T: Blend<S>, U: Blend<S>> Blend<S> for (T, U) {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn blend(mask: S::SimdBool, yes: Self, no: Self) -> Self {
        (T::blend(mask, yes.0, no.0), U::blend(mask, yes.1, no.1))
    }
}

impl<S: Real, const R: usize, const C: usize> Blend<S> for SMatrix<S, R, C> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn blend(mask: S::SimdBool, yes: Self, no: Self) -> Self {
        yes.zip_map(&no, |y, n| y.select(mask, n))
    }
}

impl Real for f64 {
    const EPSILON: f64 = f64::EPSILON;
    const SERIES_TERMS: usize = 12;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lit(x: f64) -> Self {
        x
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn value(self) -> f64 {
        self
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sin_cos(self) -> (Self, Self) {
        match self.common(self.abs() < elementary::SIN_COS_END) {
            Some(x) => elementary::sin_cos(x),
            None => self.simd_sin_cos(),
        }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn exp(self) -> Self {
        match self.common(self.abs() < elementary::EXP_END) {
            Some(x) => elementary::exp(x),
            None => self.simd_exp(),
        }
    }
}

/// Elementary functions by way of `f64`: correctly rounded but for one case in 10⁸.
impl Real for f32 {
    const EPSILON: f64 = f32::EPSILON as f64;
    const SERIES_TERMS: usize = 6;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lit(x: f64) -> Self {
        x as f32
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn value(self) -> f64 {
        f64::from(self)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = Real::sin_cos(f64::from(self));
        (sin as f32, cos as f32)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn exp(self) -> Self {
        Real::exp(f64::from(self)) as f32
    }
}
