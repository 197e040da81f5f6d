//! Rodrigues vectors: three numbers without trigonometry.
//!
//! ```text
//! Gibbs (Cayley)        g = tan(θ/2)·n = v/w            q ∝ (g, 1)                infinite at θ = π
//! modified Rodrigues    m = tan(θ/4)·n = v/(1 + w)      q ∝ (2m, 1 − |m|²)        infinite at θ = 2π
//! shadow set            m' = −m/|m|² = −v/(1 − w)       the same rotation by −q
//! ∂g/∂δ = ½(I + g^ + ggᵀ)                  ∂δ/∂g = 2(I − g^)/(1 + |g|²)
//! ∂m/∂δ = ¼((1 − |m|²)I + 2m^ + 2mmᵀ)      ∂δ/∂m = 16·(∂m/∂δ)ᵀ/(1 + |m|²)²
//! ```
//! Schaub & Junkins (1996), with the attitude taken as `parent_from_body` and δ on the right. Of the two sets of modified
//! parameters one has |m| ≤ 1: [`SO3::to_mrp`] gives that one, which never is singular but jumps to its shadow at θ = π.
//! To follow a rotation continuously take [`SO3::to_mrp_near`].
//!
//! ```
//! use boxplus::lie::{LieError, LieGroup, SO3};
//! use std::f64::consts::PI;
//! let half_turn: SO3 = SO3::about_x(PI);
//! let exactly = SO3::from_xyzw([1.0, 0.0, 0.0, 0.0])?;
//! assert_eq!(exactly.to_gibbs(), Err(LieError::HalfTurn));
//! assert!((half_turn.to_mrp().norm() - 1.0).abs() < 1e-15);
//! assert!(SO3::from_mrp(half_turn.to_mrp_shadow()?)?.rminus(&half_turn).norm() < 1e-15);
//! # Ok::<(), LieError>(())
//! ```

use super::skew;
use crate::lie::{LieError, Real, SO3};
use nalgebra::{Matrix3, Vector3};

impl<S: Real> SO3<S> {
    /// The rotation of a Gibbs (Rodrigues, Cayley) vector tan(θ/2)·n.
    ///
    /// # Errors
    /// [`LieError::NotFinite`].
    pub fn from_gibbs(g: Vector3<S>) -> Result<Self, LieError> {
        Self::from_xyzw([g.x, g.y, g.z, S::one()])
    }

    /// [`SO3::from_gibbs`]: `(value, d_value_d_g)`, 3×3.
    ///
    /// # Errors
    /// [`LieError::NotFinite`].
    pub fn from_gibbs_jac(g: Vector3<S>) -> Result<(Self, Matrix3<S>), LieError> {
        let (value, jacobian) = Self::from_xyzw_jac([g.x, g.y, g.z, S::one()])?;
        Ok((value, jacobian.fixed_columns::<3>(0).into_owned()))
    }

    /// The Gibbs (Rodrigues, Cayley) vector tan(θ/2)·n.
    ///
    /// # Errors
    /// [`LieError::HalfTurn`] where θ = π, or so near that the vector overflows.
    pub fn to_gibbs(&self) -> Result<Vector3<S>, LieError> {
        let [x, y, z, w] = self.quaternion_xyzw();
        let g = Vector3::new(x, y, z) / w;
        if g.iter().all(|x| x.value().is_finite()) { Ok(g) } else { Err(LieError::HalfTurn) }
    }

    /// [`SO3::to_gibbs`]: `(value, d_g_d_self)`, 3×3: ½(I + g^ + ggᵀ).
    ///
    /// # Errors
    /// [`LieError::HalfTurn`].
    pub fn to_gibbs_jac(&self) -> Result<(Vector3<S>, Matrix3<S>), LieError> {
        let g = self.to_gibbs()?;
        Ok((g, (Matrix3::identity() + skew(&g) + g * g.transpose()) * S::lit(0.5)))
    }

    /// The rotation of modified Rodrigues parameters tan(θ/4)·n, of either set.
    ///
    /// # Errors
    /// [`LieError::NotFinite`].
    pub fn from_mrp(m: Vector3<S>) -> Result<Self, LieError> {
        let size = m.iter().fold(0.0, |a: f64, x| a.max(x.value().abs()));
        if !size.is_finite() {
            return Err(LieError::NotFinite);
        }
        // (2m, 1 − |m|²) over size², should the square be large; it then is the shadow that is used.
        let unit = S::lit(1.0 / size.max(1.0));
        let m = m * unit;
        let v = m * (S::lit(2.0) * unit);
        Self::from_xyzw([v.x, v.y, v.z, unit * unit - m.norm_squared()])
    }

    /// [`SO3::from_mrp`]: `(value, d_value_d_m)`, 3×3: 4((1 − |m|²)I − 2m^ + 2mmᵀ)/(1 + |m|²)².
    ///
    /// # Errors
    /// [`LieError::NotFinite`].
    pub fn from_mrp_jac(m: Vector3<S>) -> Result<(Self, Matrix3<S>), LieError> {
        let scale = S::lit(4.0) / (S::one() + m.norm_squared());
        let jacobian = mrp_rates(&m).transpose() * (scale * scale);
        Ok((Self::from_mrp(m)?, jacobian))
    }

    /// The modified Rodrigues parameters tan(θ/4)·n with |m| ≤ 1.
    pub fn to_mrp(&self) -> Vector3<S> {
        let (v, w) = self.short();
        v / (S::one() + w)
    }

    /// [`SO3::to_mrp`]: `(value, d_m_d_self)`, 3×3: ¼((1 − |m|²)I + 2m^ + 2mmᵀ).
    pub fn to_mrp_jac(&self) -> (Vector3<S>, Matrix3<S>) {
        let m = self.to_mrp();
        (m, mrp_rates(&m))
    }

    /// The modified Rodrigues parameters with |m| ≥ 1, those of the longer way round. Their Jacobian has the same form.
    ///
    /// # Errors
    /// [`LieError::NoShadow`] at the identity, or so near that the vector overflows.
    pub fn to_mrp_shadow(&self) -> Result<Vector3<S>, LieError> {
        let (v, w) = self.short();
        // 1 − w = |v|²/(1 + w) without cancellation; v/|v|² without squaring small numbers.
        let largest = v.iter().fold(0.0, |a: f64, x| a.max(x.value().abs()));
        let u = v / S::lit(largest);
        let m = u * ((-S::one() - w) / (u.norm_squared() * S::lit(largest)));
        if m.iter().all(|x| x.value().is_finite()) { Ok(m) } else { Err(LieError::NoShadow) }
    }

    /// The set of modified Rodrigues parameters nearer to `reference`: follows a rotation through θ = π.
    pub fn to_mrp_near(&self, reference: &Vector3<S>) -> Vector3<S> {
        let near = self.to_mrp();
        let distance = |m: &Vector3<S>| (m - reference).norm_squared().value();
        match self.to_mrp_shadow() {
            Ok(shadow) if distance(&shadow) < distance(&near) => shadow,
            _ => near,
        }
    }

    /// (v, w) of the quaternion with w ≥ 0.
    pub(super) fn short(&self) -> (Vector3<S>, S) {
        let [x, y, z, w] = self.quaternion_xyzw();
        let sign = S::lit(if w.value() < 0.0 { -1.0 } else { 1.0 });
        (Vector3::new(x, y, z) * sign, w * sign)
    }
}

/// ∂m/∂δ.
fn mrp_rates<S: Real>(m: &Vector3<S>) -> Matrix3<S> {
    let two = S::lit(2.0);
    let diagonal = Matrix3::from_diagonal_element(S::one() - m.norm_squared());
    (diagonal + skew(m) * two + m * m.transpose() * two) * S::lit(0.25)
}
