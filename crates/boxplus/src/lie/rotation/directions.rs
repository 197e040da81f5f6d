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
use super::{skew, unit};
use crate::lie::{LieError, LieGroup, Real, SO2, SO3};
use nalgebra::{Matrix3, RowVector3, SMatrix, Vector2, Vector3};

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

    /// [`SO3::from_axis_angle`]: `(value, d_value_d_axis, d_value_d_angle)`, 3×3 and 3×1:
    /// (sin θ·(I − nnᵀ) − (1 − cos θ)·n^)/|axis| and n.
    ///
    /// # Errors
    /// Those of [`SO3::from_axis_angle`].
    pub fn from_axis_angle_jac(
        axis: &Vector3<S>,
        angle: S,
    ) -> Result<(Self, Matrix3<S>, Vector3<S>), LieError> {
        let n = unit(axis)?;
        let (sin, cos) = (angle * S::lit(0.5)).simd_sin_cos();
        let across = Matrix3::identity() - n * n.transpose();
        let d_axis = (across * cos - skew(&n) * sin) * (sin * S::lit(2.0) / n.dot(axis));
        Ok((Self::from_unit(n * sin, cos), d_axis, n))
    }

    /// `(axis, angle)`, the axis of unit length and the angle in \[0, π\] radians. The identity has any axis; ours is z.
    pub fn to_axis_angle(&self) -> (Vector3<S>, S) {
        let (v, w) = self.short();
        match unit(&v) {
            Ok(axis) => (axis, S::polar_angle(axis.dot(&v), w) * S::lit(2.0)),
            Err(_) => (Vector3::z(), S::zero()),
        }
    }

    /// [`SO3::to_axis_angle`]: `((axis, angle), d_axis_d_self, d_angle_d_self)`, 3×3 and 1×3: ½(cot(θ/2)·(I − nnᵀ) + n^) and nᵀ.
    ///
    /// # Errors
    /// [`LieError::NoAxis`] at the identity, or so near that the derivative overflows.
    pub fn to_axis_angle_jac(&self) -> Result<((Vector3<S>, S), Matrix3<S>, RowVector3<S>), LieError> {
        let ((n, angle), (v, w)) = (self.to_axis_angle(), self.short());
        let cot = w / n.dot(&v);
        if !cot.value().is_finite() {
            return Err(LieError::NoAxis);
        }
        let across = Matrix3::identity() - n * n.transpose();
        Ok(((n, angle), (across * cot + skew(&n)) * S::lit(0.5), n.transpose()))
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

    /// [`SO3::between_directions`]: `(value, d_value_d_from, d_value_d_to)`, 3×3 each, with a and b the unit vectors:
    /// −(I − abᵀ/(1 + a·b))·a^/|from| and (I + abᵀ/(1 + a·b))·a^·Rᵀ/|to|. They grow as 1/(π − θ).
    ///
    /// # Errors
    /// Those of [`SO3::between_directions`], or [`LieError::Opposite`].
    pub fn between_directions_jac(
        from: &Vector3<S>,
        to: &Vector3<S>,
    ) -> Result<(Self, Matrix3<S>, Matrix3<S>), LieError> {
        let (value, a, b) = (Self::between_directions(from, to)?, unit(from)?, unit(to)?);
        // 1 + a·b without cancellation.
        let above = (a + b).norm_squared() * S::lit(0.5);
        if above.value() == 0.0 {
            return Err(LieError::Opposite);
        }
        let (twist, turn) = (a * b.transpose() / above, skew(&a));
        let d_from = (twist - Matrix3::identity()) * turn / a.dot(from);
        let d_to = (twist + Matrix3::identity()) * turn * value.to_matrix().transpose() / b.dot(to);
        Ok((value, d_from, d_to))
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

    /// [`SO3::from_direction_pairs`]: `(value, d_value_d_parent, d_value_d_local)`, 3×6 each, by both vectors of a pair one after the
    /// other: ±F·∂F, F being the frame of the pair `local` and ∂F that of [`SO3::from_6d_jac`].
    ///
    /// # Errors
    /// Those of [`SO3::from_direction_pairs`].
    pub fn from_direction_pairs_jac(
        parent: [&Vector3<S>; 2],
        local: [&Vector3<S>; 2],
    ) -> Result<(Self, SMatrix<S, 3, 6>, SMatrix<S, 3, 6>), LieError> {
        let value = Self::from_direction_pairs(parent, local)?;
        let (_, d_parent) = Self::from_6d_jac(parent[0], parent[1])?;
        let (frame, d_local) = Self::from_6d_jac(local[0], local[1])?;
        let frame = frame.to_matrix();
        Ok((value, frame * d_parent, -frame * d_local))
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
            angle: S::polar_angle(along, w) * S::lit(2.0),
        })
    }

    /// [`SO3::swing_twist`]: `(value, d_swing_d_self, d_angle_d_self)`, 3×3 and 1×3: T·(I − n·dᵀ), T the twist, n the axis, and
    /// dᵀ = (w²n + w·n×v + (n·v)v)ᵀ/(w² + (n·v)²). The twist moves by n·dᵀ.
    ///
    /// # Errors
    /// Those of [`SO3::swing_twist`].
    pub fn swing_twist_jac(
        &self,
        axis: &Vector3<S>,
    ) -> Result<(SwingTwist<S>, Matrix3<S>, RowVector3<S>), LieError> {
        let (value, n, (v, w)) = (self.swing_twist(axis)?, unit(axis)?, self.short());
        let along = n.dot(&v);
        let d_angle = (n * (w * w) + n.cross(&v) * w + v * along).transpose() / (w * w + along * along);
        let d_swing = value.twist.to_matrix() * (Matrix3::identity() - n * d_angle);
        Ok((value, d_swing, d_angle))
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
