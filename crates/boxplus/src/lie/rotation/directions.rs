//! Rotations from axes and directions: one turn, the shortest way between two directions, a frame from two, swing and twist.
//!
//! - About an axis: [`SO3::from_axis_angle`], [`SO3::about_x`] ….
//! - From one direction to another: the shortest rotation, [`SO3::between_directions`]. One direction leaves the turn about
//!   itself open; "shortest" is a choice, and antiparallel directions leave even the axis open.
//! - Two directions seen in two frames fix a rotation, [`SO3::from_direction_pairs`] (TRIAD, Black (1964)): the first pair is
//!   matched exactly, the second as well as possible. "Look at" is this: say which local axis looks where, and which is up.
//! - The inverse question, how much of a rotation is about a given axis, is [`SO3::swing_twist`].
//!
//! ```
//! use boxplus::lie::SO3;
//! use nalgebra::Vector3;
//! // A camera (z ahead, y down) at the origin looks at a landmark; the world's z is up.
//! let landmark = Vector3::new(2.0, 1.0, 0.5);
//! let down = -Vector3::z();
//! let world_from_camera: SO3 = SO3::from_direction_pairs([&landmark, &down], [&Vector3::z(), &Vector3::y()])?;
//! assert!((world_from_camera * Vector3::z() - landmark.normalize()).norm() < 1e-15);
//! assert!((world_from_camera * Vector3::x()).z.abs() < 1e-15); // its x axis is level
//! # Ok::<(), boxplus::lie::LieError>(())
//! ```

use super::matrix::gram_schmidt;
use super::unit;
use crate::lie::{LieError, LieGroup, Real, SO2, SO3};
use nalgebra::{Matrix3, Vector2, Vector3};

/// A rotation as swing·twist: first a turn about an axis, then the shortest rotation that brings the axis where it goes.
#[derive(Clone, Copy, Debug)]
pub struct SwingTwist<S: Real = f64> {
    /// Turns about a direction perpendicular to the axis.
    pub swing: SO3<S>,
    /// Turns about the axis.
    pub twist: SO3<S>,
    /// Angle of the twist about the axis in radians, in [−π, π].
    pub angle: S,
}

impl<S: Real> SO2<S> {
    /// The rotation R with R·`from` ∥ `to`; lengths do not matter, opposite directions are no special case.
    ///
    /// # Errors
    /// [`LieError::NotFinite`] or [`LieError::Zero`].
    pub fn between_directions(from: &Vector2<S>, to: &Vector2<S>) -> Result<Self, LieError> {
        let [a, b] = [Self::from_cos_sin(from.x, from.y)?, Self::from_cos_sin(to.x, to.y)?];
        Ok(a.between(&b))
    }
}

impl<S: Real> SO3<S> {
    /// The rotation by `angle` radians about the x axis.
    pub fn about_x(angle: S) -> Self {
        Self::about(0, angle)
    }

    /// The rotation by `angle` radians about the y axis.
    pub fn about_y(angle: S) -> Self {
        Self::about(1, angle)
    }

    /// The rotation by `angle` radians about the z axis.
    pub fn about_z(angle: S) -> Self {
        Self::about(2, angle)
    }

    #[inline]
    pub(super) fn about(axis: usize, angle: S) -> Self {
        let (sin, cos) = (angle * S::lit(0.5)).simd_sin_cos();
        Self::from_unit(Vector3::ith(axis, sin), cos)
    }

    /// The rotation by `angle` radians about `axis`, of any length but 0, by the right hand.
    ///
    /// # Errors
    /// [`LieError::NotFinite`] or [`LieError::Zero`], of the axis.
    pub fn from_axis_angle(axis: &Vector3<S>, angle: S) -> Result<Self, LieError> {
        let (sin, cos) = (angle * S::lit(0.5)).simd_sin_cos();
        Ok(Self::from_unit(unit(axis)? * sin, cos))
    }

    /// `(axis, angle)`, the axis of unit length and the angle in \[0, π\] radians. The identity has any axis; ours is z.
    pub fn to_axis_angle(&self) -> (Vector3<S>, S) {
        let (v, w) = self.short();
        match unit(&v) {
            Ok(axis) => (axis, axis.dot(&v).simd_atan2(w) * S::lit(2.0)),
            Err(_) => (Vector3::z(), S::zero()),
        }
    }

    /// The shortest rotation R with R·`from` ∥ `to`; lengths do not matter.
    ///
    /// Equal directions give the identity. Of the half turns between opposite directions it takes the one about `from` × e,
    /// e being the coordinate axis least along `from` (the first of several), and about its limit near them. R·`from` is right
    /// to a few ε always; the axis is as uncertain as the directions make it. For single numbers.
    ///
    /// # Errors
    /// [`LieError::NotFinite`] or [`LieError::Zero`].
    pub fn between_directions(from: &Vector3<S>, to: &Vector3<S>) -> Result<Self, LieError> {
        let (a, b) = (unit(from)?, unit(to)?);
        let cos = a.dot(&b);
        if cos.value() >= 0.0 {
            return Ok(half_way(&a, &b, cos));
        }
        // The quaternion (a × b, 1 + a·b) vanishes towards −a. So a half turn to −a, then the short rest.
        let half_turn = Self::from_unit(perpendicular(&a, &b)?, S::zero());
        Ok(half_way(&-a, &b, -cos).compose(&half_turn))
    }

    /// The rotation that takes the first direction of `local` to the first of `parent`, and the second as near to the second
    /// as possible: TRIAD, Black (1964). `parent_from_local`, when both name the same two things.
    ///
    /// # Errors
    /// [`LieError::NotFinite`], [`LieError::Zero`], or [`LieError::Parallel`] where a pair spans no plane.
    pub fn from_direction_pairs(parent: [&Vector3<S>; 2], local: [&Vector3<S>; 2]) -> Result<Self, LieError> {
        let frame = |[a, b]: [&Vector3<S>; 2]| {
            let [x, y] = gram_schmidt(a, b)?;
            Ok(Matrix3::from_columns(&[x, y, x.cross(&y)]))
        };
        Self::from_matrix(&(frame(parent)? * frame(local)?.transpose()))
    }

    /// swing·twist of this rotation, the twist about `axis` in the local frame.
    ///
    /// # Errors
    /// [`LieError::NotFinite`] or [`LieError::Zero`] of the axis; [`LieError::AxisReversed`] where the rotation turns the
    /// axis over (within rounding), so that any twist will do.
    pub fn swing_twist(&self, axis: &Vector3<S>) -> Result<SwingTwist<S>, LieError> {
        let (n, (v, w)) = (unit(axis)?, self.short());
        let along = n.dot(&v);
        let size = (along * along + w * w).simd_sqrt();
        if size.value() <= 4.0 * S::EPSILON {
            return Err(LieError::AxisReversed);
        }
        let twist = Self::from_unit(n * (along / size), w / size);
        Ok(SwingTwist {
            swing: self.compose(&twist.inverse()),
            twist,
            angle: along.simd_atan2(w) * S::lit(2.0),
        })
    }
}

/// The quaternion (a × b, 1 + a·b) at unit norm, for unit vectors at most 90° apart.
fn half_way<S: Real>(a: &Vector3<S>, b: &Vector3<S>, cos: S) -> SO3<S> {
    SO3::from_unit(a.cross(b), S::one() + cos).normalize()
}

/// A unit vector perpendicular to the unit vector `a`: along a × b, as far as that is known.
fn perpendicular<S: Real>(a: &Vector3<S>, b: &Vector3<S>) -> Result<Vector3<S>, LieError> {
    let least = a.map(|x| x.value().abs()).imin();
    let axis = a.cross(b);
    let axis =
        if axis.iter().all(|x| x.value() == 0.0) { a.cross(&Vector3::ith(least, S::one())) } else { axis };
    let [_, axis] = gram_schmidt(a, &axis)?;
    Ok(axis)
}
