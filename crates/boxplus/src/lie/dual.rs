//! The dual numbers of `num-dual`: along many directions, along one at a time, and to second order.

use super::Real;
use num_dual::{Dual2_64, Dual2SVec64, Dual64, DualSVec64, HyperDual64};

/// atan2 of dual numbers: the point is turned onto the positive x axis by its angle without derivatives, where atan(y/x) has them
/// exactly. At the origin, where there are none, they are 0.
pub(super) fn polar_angle<S: Real>(y: S, x: S) -> S {
    let angle = y.value().atan2(x.value());
    let (sin, cos) = angle.sin_cos();
    let (sin, cos) = (S::lit(sin), S::lit(cos));
    let along = x * cos + y * sin;
    if along.value() == 0.0 {
        return S::lit(angle);
    }
    let rest = ((y * cos - x * sin) / along).simd_atan();
    rest - S::lit(rest.value()) + S::lit(angle)
}

/// Near 0 by the series of atan: no root of 0, hence derivatives there, too. It reaches to tan θ = 1/20, for a second derivative of
/// the quotient beyond loses the digits of ε/θ; the next term is tan¹⁴ θ/15.
fn angle_over_sine<S: Real>(sin_squared: S, cos: S) -> S {
    if sin_squared.value() < 0.0025 * (cos * cos).value() {
        let r = sin_squared / (cos * cos);
        let term = |sum: S, k: u32| S::lit(1.0 / f64::from(k)) - r * sum;
        return [11, 9, 7, 5, 3, 1].into_iter().fold(S::lit(1.0 / 13.0), term) / cos;
    }
    let sin = sin_squared.simd_sqrt();
    polar_angle(sin, cos) / sin
}

macro_rules! real {
    ($([$($parameter:tt)*] $dual:ty;)*) => { $(
        impl<$($parameter)*> Real for $dual {
            const EPSILON: f64 = f64::EPSILON;
            const SERIES_TERMS: usize = 12;
            fn lit(x: f64) -> Self {
                Self::from_re(x)
            }
            fn value(self) -> f64 {
                self.re
            }
            fn polar_angle(y: Self, x: Self) -> Self {
                polar_angle(y, x)
            }
            fn angle_over_sine(sin_squared: Self, cos: Self) -> Self {
                angle_over_sine(sin_squared, cos)
            }
        }
    )* };
}

real! {
    [const N: usize] DualSVec64<N>;
    [] Dual64;
    [] Dual2_64;
    [const N: usize] Dual2SVec64<N>;
    [] HyperDual64;
}
