//! The other dual numbers of `num-dual`: one direction at a time, and second derivatives.

use super::Real;
use num_dual::{Dual2_64, Dual2SVec64, Dual64, HyperDual64};

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
        }
    )* };
}

real! {
    [] Dual64;
    [] Dual2_64;
    [const N: usize] Dual2SVec64<N>;
    [] HyperDual64;
}
