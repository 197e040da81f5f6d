//! Between the motion of a body and the motion of its coordinates τ = Log X, to third order in time, on any group.
//!
//! ```text
//! X = Exp(τ(t)):   ω = J_r(τ)·τ̇ = Σ Tₙ/(n + 1)!     T₀ = τ̇,  Tₙ = −[τ, Tₙ₋₁]     and its derivatives in time by Leibniz
//! X = Exp(τ/2)·Exp(τ/2): a series over τ/8, then the product rule of motions three times
//! ```
//! No Jacobian is differentiated, no case is apart at τ = 0.

use super::Motion;
use crate::lie::{LieGroup, Real, Tangent};

/// Halvings before the series: |φ| ≤ 2π becomes ≤ 0.79.
const HALVINGS: u32 = 3;
/// With n(n − 1)·0.79ⁿ⁻²/(n + 1)! the terms of the second derivative; < ε/100 from n = 18 on.
const TERMS: u32 = 18;

impl<G: LieGroup<D>, const D: usize> Motion<G, D> {
    /// The motion of Exp(τ(t)) from \[τ, τ̇, τ̈, τ⃛\], for |φ| ≤ 2π.
    ///
    /// ```
    /// use boxplus::lie::{LieGroup, SO3};
    /// use boxplus::trajectory::Motion;
    /// use nalgebra::{Vector3, vector};
    /// // An axis at rest: coordinates turn as the body does. An axis that moves: not so.
    /// let (phi, rate, o) = (vector![0.0, 0.0, 1.0], vector![0.0, 0.0, 2.0], Vector3::zeros());
    /// assert!((Motion::<SO3, 3>::from_coordinates(&[phi, rate, o, o]).velocity - rate).norm() < 1e-15);
    /// let motion = Motion::<SO3, 3>::from_coordinates(&[phi, vector![1.0, 0.0, 0.0], o, o]);
    /// assert!((motion.velocity - vector![1.0_f64.sin(), 1.0_f64.cos() - 1.0, 0.0]).norm() < 1e-15);
    /// ```
    pub fn from_coordinates(coordinates: &[Tangent<G::Scalar, D>; 4]) -> Self {
        let part = G::Scalar::lit(1.0 / f64::from(1_u32 << HALVINGS));
        let [velocity, acceleration, jerk] = rates::<G, D>(&coordinates.map(|c| c * part));
        let mut motion = Self { value: G::exp(&(coordinates[0] * part)), velocity, acceleration, jerk };
        for _ in 0..HALVINGS {
            motion = motion.then(&motion);
        }
        Self { value: G::exp(&coordinates[0]), ..motion }
    }

    /// \[τ, τ̇, τ̈, τ⃛\] of τ = Log X: the inverse of [`Motion::from_coordinates`], order by order: τ̇ = J_r⁻¹ω, then
    /// τ̈ = J_r⁻¹(ω̇ − what it would be with τ̈ = 0), likewise τ⃛.
    pub fn coordinates(&self) -> [Tangent<G::Scalar, D>; 4] {
        let (tau, inverse) = self.value.log_jac();
        let mut found = [
            tau,
            inverse * self.velocity,
            Tangent::<G::Scalar, D>::zeros(),
            Tangent::<G::Scalar, D>::zeros(),
        ];
        found[2] = inverse * (self.acceleration - Self::from_coordinates(&found).acceleration);
        found[3] = inverse * (self.jerk - Self::from_coordinates(&found).jerk);
        found
    }

    /// X·(X⁻¹Y)ˢ with X = `self` and Y = `other` in motion and s = `weight` in time, \[s, ṡ, s̈, s⃛\].
    ///
    /// The geodesic between two moving bodies; with both at rest, [`LieGroup::interpolate`] and its rates.
    pub fn interpolate(&self, other: &Self, weight: &[G::Scalar; 4]) -> Self {
        let tau = self.inverse().then(other).coordinates();
        // (s·τ)⁽ⁿ⁾ = Σ C(n, k)·s⁽ᵏ⁾·τ⁽ⁿ⁻ᵏ⁾
        let leibniz = |n: usize| {
            let mut sum = Tangent::<G::Scalar, D>::zeros();
            let mut binomial = 1.0;
            for k in 0..=n {
                sum += tau[n - k] * (weight[k] * G::Scalar::lit(binomial));
                binomial *= (n - k) as f64 / (k + 1) as f64;
            }
            sum
        };
        self.then(&Self::from_coordinates(&core::array::from_fn(leibniz)))
    }
}

/// ω, ω̇, ω̈ by the power series.
fn rates<G: LieGroup<D>, const D: usize>(
    [tau, first, second, third]: &[Tangent<G::Scalar, D>; 4],
) -> [Tangent<G::Scalar, D>; 3] {
    let [ad, d_ad, dd_ad] = [tau, first, second].map(G::small_adjoint);
    let mut term = [*first, *second, *third];
    let mut sum = term;
    let mut reciprocal = 1.0;
    for n in 1..=TERMS {
        let [t, d_t, dd_t] = term;
        let bend = d_ad * d_t;
        term = [-(ad * t), -(d_ad * t + ad * d_t), -(dd_ad * t + bend + bend + ad * dd_t)];
        reciprocal /= f64::from(n + 1);
        for (sum, term) in sum.iter_mut().zip(&term) {
            *sum += term * G::Scalar::lit(reciprocal);
        }
    }
    sum
}
