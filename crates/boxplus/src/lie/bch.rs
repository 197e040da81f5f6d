//! Composition in the tangent space: Baker, Campbell and Hausdorff.
//!
//! ```text
//! Log(Exp a·Exp b) = a + b + ½[a, b] + (1/12)([a, [a, b]] + [b, [b, a]]) − (1/24)[b, [a, [a, b]]] + …      Barfoot (2024) (8.14)
//!                  = b + J_l⁻¹(b)·a + O(a²) = a + J_r⁻¹(a)·b + O(b²)                                     Barfoot (2024) (8.15), (8.16)
//! ```
//!
//! The exact value costs one composition, [`Bch::bch`]. The series is for theory, and for bounds: it converges only where a and b
//! are short together, and its error falls by 2ⁿ⁺¹ as they are halved. Truncated to first order in one *small* argument, it holds
//! for any length of the other: that is how Jacobians of Log arise.
//!
//! ```
//! use boxplus::lie::{Bch, BchOrder, SO3};
//! use nalgebra::Vector3;
//! let (a, b) = (Vector3::new(0.1, 0.0, 0.02), Vector3::new(0.0, 0.1, -0.05));
//! let exact = SO3::bch(&a, &b);
//! let error = |order| (SO3::bch_series(&a, &b, order) - exact).norm();
//! assert!(error(BchOrder::First) < 1e-2 && error(BchOrder::Second) < 3e-4);
//! assert!(error(BchOrder::Third) < 1e-5 && error(BchOrder::Fourth) < 1e-6);
//! ```

use super::{Jacobian, LieGroup, Real, Tangent};

/// The last power of the tangents that a truncated series keeps; its error is of the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum BchOrder {
    /// a + b.
    First,
    /// … + ½\[a, b\].
    Second,
    /// … + (1/12)(\[a, \[a, b\]\] + \[b, \[b, a\]\]).
    Third,
    /// … − (1/24)\[b, \[a, \[a, b\]\]\].
    Fourth,
}

/// Composition of tangents, of every group.
pub trait Bch<const D: usize>: LieGroup<D> {
    /// Log(Exp a·Exp b), exactly.
    #[inline]
    fn bch(a: &Tangent<Self::Scalar, D>, b: &Tangent<Self::Scalar, D>) -> Tangent<Self::Scalar, D> {
        Self::exp(a).compose(&Self::exp(b)).log()
    }

    /// c = Log(Exp a·Exp b): `(c, d_c_d_a, d_c_d_b)` = (c, J_l⁻¹(c)·J_l(a), J_r⁻¹(c)·J_r(b)), D×D each.
    #[inline]
    fn bch_jac(
        a: &Tangent<Self::Scalar, D>,
        b: &Tangent<Self::Scalar, D>,
    ) -> (Tangent<Self::Scalar, D>, Jacobian<Self::Scalar, D>, Jacobian<Self::Scalar, D>) {
        let (c, right, left) = Self::exp(a).compose(&Self::exp(b)).log_jacs();
        (c, left * Self::left_jacobian(a), right * Self::right_jacobian(b))
    }

    /// b + J_l⁻¹(b)·a: first order in a, exact in b. The error is O(a²). Barfoot (2024) (8.15).
    #[inline]
    fn bch_small_first(
        a: &Tangent<Self::Scalar, D>,
        b: &Tangent<Self::Scalar, D>,
    ) -> Tangent<Self::Scalar, D> {
        b + Self::left_jacobian_inverse(b) * a
    }

    /// a + J_r⁻¹(a)·b: first order in b, exact in a. The error is O(b²). Barfoot (2024) (8.16).
    #[inline]
    fn bch_small_second(
        a: &Tangent<Self::Scalar, D>,
        b: &Tangent<Self::Scalar, D>,
    ) -> Tangent<Self::Scalar, D> {
        a + Self::right_jacobian_inverse(a) * b
    }

    /// The series up to `order` n; the error is O((|a| + |b|)ⁿ⁺¹). Barfoot (2024) (8.14).
    fn bch_series(
        a: &Tangent<Self::Scalar, D>,
        b: &Tangent<Self::Scalar, D>,
        order: BchOrder,
    ) -> Tangent<Self::Scalar, D> {
        let factor = |x: f64| Self::Scalar::lit(x);
        let (ad_a, ad_b) = (Self::small_adjoint(a), Self::small_adjoint(b));
        let ab = ad_a * b;
        let aab = ad_a * ab;
        let mut sum = a + b;
        if order >= BchOrder::Second {
            sum += ab * factor(0.5);
        }
        if order >= BchOrder::Third {
            sum += (aab - ad_b * ab) * factor(1.0 / 12.0);
        }
        if order >= BchOrder::Fourth {
            sum -= ad_b * aab * factor(1.0 / 24.0);
        }
        sum
    }
}

impl<G: LieGroup<D>, const D: usize> Bch<D> for G {}
