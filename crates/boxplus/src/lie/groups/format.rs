//! Elements as text, and what every group has beside its operations: a default and `*=`.
//!
//! `{}` names the parts and honours a precision; `{:?}` has the same numbers as a struct, to the last digit.
//!
//! ```
//! use boxplus::lie::{LieGroup, SE3, SO3};
//! use nalgebra::Vector3;
//! let turn = SO3::exp(&Vector3::new(0.0, 0.0, std::f64::consts::FRAC_PI_2));
//! let pose = SE3::new(turn, Vector3::new(1.0, 2.0, 3.0));
//! assert_eq!(format!("{pose:.3}"), "SE3(translation [1.000, 2.000, 3.000], xyzw [0.000, 0.000, 0.707, 0.707])");
//! ```

use super::plain::every_plain;
use super::{Plain, Rn, RxSO2, RxSO3, S3, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3};
use crate::lie::{LieGroup, Real};
use core::fmt::{Debug, Display, Formatter, Result};
use core::ops::MulAssign;

/// The parts of an array by name; a part of one number is that number.
struct Part<'a, S>(&'a [S]);

impl<S: Debug> Debug for Part<'_, S> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self.0 {
            [number] => number.fmt(f),
            numbers => f.debug_list().entries(numbers).finish(),
        }
    }
}

/// Calls `write` with the name and the numbers of each part, in order.
fn each_part<G: Plain<N>, const N: usize>(
    x: &G,
    mut write: impl FnMut(&'static str, Part<'_, G::Number>) -> Result,
) -> Result {
    let numbers = x.to_array();
    let mut rest = numbers.as_slice();
    for (name, length) in G::FIELDS {
        let (part, after) = rest.split_at_checked(*length).unwrap_or((rest, &[]));
        write(name, Part(part))?;
        rest = after;
    }
    Ok(())
}

fn debug<G: Plain<N>, const N: usize>(x: &G, f: &mut Formatter<'_>) -> Result {
    let mut shape = f.debug_struct(G::NAME);
    each_part(x, |name, part| {
        shape.field(if name.is_empty() { "x" } else { name }, &part);
        Ok(())
    })?;
    shape.finish()
}

fn display<G: Plain<N>, const N: usize>(x: &G, f: &mut Formatter<'_>) -> Result {
    write!(f, "{}(", G::NAME)?;
    let mut separator = "";
    each_part(x, |name, part| {
        f.write_str(separator)?;
        separator = ", ";
        if !name.is_empty() {
            write!(f, "{name} ")?;
        }
        part.fmt(f)
    })?;
    f.write_str(")")
}

macro_rules! text {
    ($($(const $m:ident,)? $group:ty, $n:expr;)*) => { $(
        impl<$(const $m: usize,)? S: Real> Debug for $group {
            fn fmt(&self, f: &mut Formatter<'_>) -> Result {
                debug::<Self, { $n }>(self, f)
            }
        }

        /// The parts by name, with the formatter's precision.
        impl<$(const $m: usize,)? S: Real> Display for $group {
            fn fmt(&self, f: &mut Formatter<'_>) -> Result {
                display::<Self, { $n }>(self, f)
            }
        }

        /// The identity.
        impl<$(const $m: usize,)? S: Real> Default for $group {
            fn default() -> Self {
                Self::identity()
            }
        }

        /// X ← X·Y.
        impl<$(const $m: usize,)? S: Real> MulAssign for $group {
            #[inline]
            fn mul_assign(&mut self, rhs: Self) {
                *self = self.compose(&rhs);
            }
        }
    )* };
}

every_plain!(text);
