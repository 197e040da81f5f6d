//! Shoemake's spherical quadrangle on any group, and slerp.

use crate::lie::{Jacobian, LieGroup, Real, SO3, Tangent};
use crate::trajectory::chain::scaled_identity;
use crate::trajectory::error::check_ways;
use crate::trajectory::{Motion, TrajectoryError};

/// R₀·(R₀⁻¹R₁)ᵗ, spherical linear interpolation of rotations: [`LieGroup::interpolate`] under the name quaternions know.
///
/// Turns at constant rate along the shortest way; q and −q are one rotation, so that no sign needs care. At half a turn both
/// ways are equally short, and the choice is deterministic. Shoemake (1985).
///
/// ```
/// use boxplus::lie::{LieGroup, SO3};
/// use boxplus::trajectory::slerp;
/// use nalgebra::Vector3;
/// let (from, to) = (SO3::identity(), SO3::exp(&Vector3::new(0.0, 0.0, 1.0)));
/// assert!((slerp(&from, &to, 0.25).log() - Vector3::new(0.0, 0.0, 0.25)).norm() < 1e-15);
/// ```
#[inline]
pub fn slerp<S: Real>(from: &SO3<S>, to: &SO3<S>, t: S) -> SO3<S> {
    from.interpolate(to, t)
}

/// One segment of a C¹ curve through elements of any group, from the second to the third of four, u ∈ \[0, 1\].
///
/// ```text
/// Sᵢ = Xᵢ·Exp(−¼[(Xᵢ₊₁ ⊖ Xᵢ) + (Xᵢ₋₁ ⊖ Xᵢ)])
/// X(u) = geodesic(geodesic(X₁, X₂, u), geodesic(S₁, S₂, u), 2u(1 − u))
/// ```
/// Shoemake (1987). At every element the velocity is the mean of those of the two geodesics that meet there, so that
/// segments join with one velocity; the parameter is uniform. For unequal times take [`super::CatmullRom`].
///
/// ```
/// use boxplus::lie::{LieGroup, SO3};
/// use boxplus::trajectory::Squad;
/// use nalgebra::Vector3;
/// let turn = |a: f64| SO3::exp(&Vector3::new(0.0, 0.0, a));
/// let (middle, _, rate) = Squad::new([turn(0.0), turn(0.5), turn(1.0), turn(1.5)])?.at_jac(0.5);
/// assert!(middle.rminus(&turn(0.75)).norm() < 1e-15 && (rate.z - 0.5).abs() < 1e-15);
/// # Ok::<(), boxplus::trajectory::TrajectoryError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Squad<G: LieGroup<D>, const D: usize> {
    elements: [G; 4],
}

impl<G: LieGroup<D>, const D: usize> Squad<G, D> {
    /// The segment between `elements[1]` and `elements[2]`; at the ends of a path repeat the outermost element.
    ///
    /// # Errors
    /// [`TrajectoryError::NotFinite`], or [`TrajectoryError::Ambiguous`] where neighbours are half a turn apart.
    pub fn new(elements: [G; 4]) -> Result<Self, TrajectoryError> {
        check_ways(&elements)?;
        Ok(Self { elements })
    }

    /// X(u) with its rates, per unit of u.
    pub fn at(&self, u: G::Scalar) -> Motion<G, D> {
        let [before, from, to, after] = &self.elements;
        let (zero, one) = (G::Scalar::lit(0.0), G::Scalar::lit(1.0));
        let along = |from: &G, to: &G| {
            Motion::at_rest(*from).interpolate(&Motion::at_rest(*to), &[u, one, zero, zero])
        };
        let outer = along(from, to);
        outer.interpolate(&along(&pull(before, from, to), &pull(from, to, after)), &blend(u))
    }

    /// X(u): `(value, [d_value_d_element; 4], d_value_d_u)`, the last being the body velocity per unit of u.
    pub fn at_jac(&self, u: G::Scalar) -> (G, [Jacobian<G::Scalar, D>; 4], Tangent<G::Scalar, D>) {
        let [before, from, to, after] = &self.elements;
        let (left, d_left) = pull_jac(before, from, to);
        let (right, d_right) = pull_jac(from, to, after);
        let (outer, outer_from, outer_to, outer_u) = from.interpolate_jac(to, u);
        let (inner, inner_left, inner_right, inner_u) = left.interpolate_jac(&right, u);
        let [weight, d_weight, ..] = blend(u);
        let (value, d_outer, d_inner, d_blend) = outer.interpolate_jac(&inner, weight);
        let (d_l, d_r) = (d_inner * inner_left, d_inner * inner_right);
        let jacobians = [
            d_l * d_left[0],
            d_l * d_left[1] + d_r * d_right[0] + d_outer * outer_from,
            d_l * d_left[2] + d_r * d_right[1] + d_outer * outer_to,
            d_r * d_right[2],
        ];
        (value, jacobians, d_outer * outer_u + d_inner * inner_u + d_blend * d_weight)
    }
}

/// 2u(1 − u) and its derivatives.
fn blend<S: Real>(u: S) -> [S; 4] {
    let (one, two) = (S::one(), S::lit(2.0));
    [two * u * (one - u), two - two * (u + u), S::lit(-4.0), S::zero()]
}

/// Sᵢ.
fn pull<G: LieGroup<D>, const D: usize>(before: &G, here: &G, after: &G) -> G {
    here.rplus(&((after.rminus(here) + before.rminus(here)) * G::Scalar::lit(-0.25)))
}

/// Sᵢ and its Jacobians in the three elements.
fn pull_jac<G: LieGroup<D>, const D: usize>(
    before: &G,
    here: &G,
    after: &G,
) -> (G, [Jacobian<G::Scalar, D>; 3]) {
    let (forth, d_after, forth_here) = after.rminus_jac(here);
    let (back, d_before, back_here) = before.rminus_jac(here);
    let quarter = G::Scalar::lit(-0.25);
    let (value, d_here, d_step) = here.rplus_jac(&((forth + back) * quarter));
    let d_step = d_step * scaled_identity(quarter);
    (value, [d_step * d_before, d_here + d_step * (forth_here + back_here), d_step * d_after])
}
