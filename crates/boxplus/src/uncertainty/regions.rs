//! Where an uncertain element is, with a given probability: ellipsoids of positions, and the curved region of the group.
//!
//! The set ξᵀΣ⁻¹ξ ≤ χ²_D is an ellipsoid in the tangent space; Exp bends it. A robot that drives straight with an uncertain
//! heading ends on an arc: its positions form a banana, which no ellipse in x and y covers. [`Region`] is the bent set
//! itself; [`Ellipsoid`] is what becomes of the position alone when its covariance is drawn.

use super::{ChiSquared, Gaussian, Side, UncertaintyError};
use crate::lie::{LieGroup, Real, Rn, Tangent};
use nalgebra::{SMatrix, SVector, SimdComplexField, Vector2};

/// The region {X : ξᵀΣ⁻¹ξ ≤ t} of a group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region<G: LieGroup<D>, const D: usize, E: Side> {
    gaussian: Gaussian<G, D, E>,
    threshold: f64,
}

impl<G: LieGroup<D>, const D: usize, E: Side> Gaussian<G, D, E> {
    /// The region that holds the element with the given probability, t the quantile of χ² with as many degrees of freedom
    /// as Σ has rank.
    ///
    /// ```
    /// use boxplus::lie::SE2;
    /// use boxplus::uncertainty::Gaussian;
    /// use nalgebra::vector;
    /// let pose = Gaussian::<SE2, 3>::from_sigmas(SE2::new(vector![1.0, 2.0], 0.5), &vector![0.1, 0.1, 0.4])?;
    /// let outline: Vec<_> = pose.region(0.95)?.curve([0, 1], 60).map(|x| x.translation()).collect();
    /// assert_eq!(outline.len(), 60);
    /// # Ok::<(), boxplus::uncertainty::UncertaintyError>(())
    /// ```
    ///
    /// # Errors
    /// [`UncertaintyError::NotAProbability`].
    pub fn region(&self, probability: f64) -> Result<Region<G, D, E>, UncertaintyError> {
        let threshold = ChiSquared::new(self.covariance().rank()).quantile(probability)?;
        Ok(Region { gaussian: *self, threshold })
    }
}

impl<G: LieGroup<D>, const D: usize, E: Side> Region<G, D, E> {
    /// t, the largest squared Mahalanobis distance inside.
    pub fn threshold(&self) -> f64 {
        self.threshold
    }

    /// Whether `x` is inside.
    ///
    /// # Errors
    /// [`UncertaintyError::Singular`].
    pub fn contains(&self, x: &G) -> Result<bool, UncertaintyError> {
        Ok(self.gaussian.mahalanobis_squared(x)?.value() <= self.threshold)
    }

    /// The point of the boundary in a direction of the whitened space: X̄ ⊞ √t·L·u, u of unit length, Σ = LLᵀ.
    pub fn boundary(&self, direction: &Tangent<G::Scalar, D>) -> G {
        let length = G::Scalar::lit(self.threshold.simd_sqrt());
        self.gaussian.perturbed(&(self.gaussian.covariance().factor() * direction.normalize() * length))
    }

    /// `count` elements along the section of the boundary by two principal axes of Σ (0 the largest): Barfoot & Furgale
    /// (2014), figure 2. Their translations draw the banana.
    ///
    /// # Panics
    /// If an axis is ≥ D, as for an array.
    pub fn curve(&self, axes: [usize; 2], count: usize) -> impl Iterator<Item = G> + use<G, D, E> {
        let gaussian = self.gaussian;
        let (variances, directions) = gaussian.covariance().principal_axes();
        let semi_axis = |k: usize| directions.column(k) * (variances[k] * self.threshold).simd_sqrt();
        let [a, b] = axes.map(semi_axis);
        (0..count).map(move |i| {
            let (sin, cos) = (core::f64::consts::TAU * i as f64 / count as f64).simd_sin_cos();
            gaussian.perturbed(&(a * cos + b * sin).map(Real::lit))
        })
    }
}

/// The ellipsoid {y : (y − c)ᵀΣ⁻¹(y − c) ≤ t} of ℝᴺ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid<const N: usize> {
    /// c.
    pub centre: SVector<f64, N>,
    /// Semi-axes as columns, the longest first; a column is 0 where nothing is uncertain.
    pub axes: SMatrix<f64, N, N>,
}

impl<S: Real, const N: usize, E: Side> Gaussian<Rn<N, S>, N, E> {
    /// The ellipsoid that holds the point with the given probability. For a pose, `pose.act(&origin, order)` is its position.
    ///
    /// ```
    /// use boxplus::lie::SE2;
    /// use boxplus::uncertainty::{Gaussian, Order};
    /// use nalgebra::vector;
    /// let pose = Gaussian::<SE2, 3>::from_sigmas(SE2::new(vector![1.0, 2.0], 0.5), &vector![0.3, 0.1, 0.02])?;
    /// let ellipse = pose.act(&vector![0.0, 0.0], Order::First).ellipsoid(0.39346934)?; // one σ in the plane
    /// assert!((ellipse.semi_axes() - vector![0.3, 0.1]).norm() < 1e-8);
    /// assert!((ellipse.angle() - 0.5).abs() < 1e-12);
    /// # Ok::<(), boxplus::uncertainty::UncertaintyError>(())
    /// ```
    ///
    /// # Errors
    /// [`UncertaintyError::NotAProbability`].
    pub fn ellipsoid(&self, probability: f64) -> Result<Ellipsoid<N>, UncertaintyError> {
        let threshold = ChiSquared::new(self.covariance().rank()).quantile(probability)?;
        let (variances, mut axes) = self.covariance().principal_axes();
        for (mut axis, variance) in axes.column_iter_mut().zip(&variances) {
            axis *= (variance * threshold).simd_sqrt();
        }
        Ok(Ellipsoid { centre: self.mean().vector().map(Real::value), axes })
    }
}

impl<const N: usize> Ellipsoid<N> {
    /// Lengths of the semi-axes, the longest first.
    pub fn semi_axes(&self) -> SVector<f64, N> {
        SVector::from_fn(|k, _| self.axes.column(k).norm_squared().simd_sqrt())
    }

    /// Whether a point is inside; of a flat ellipsoid, whether it is in the plane as well, up to rounding.
    pub fn contains(&self, y: &SVector<f64, N>) -> bool {
        let (mut rest, mut square) = (y - self.centre, 0.0);
        for axis in self.axes.column_iter().filter(|axis| axis.norm_squared() > 0.0) {
            let along = axis.dot(&rest) / axis.norm_squared();
            rest -= axis * along;
            square += along * along;
        }
        let size = self.axes.amax() + self.centre.amax();
        square <= 1.0 && rest.amax() <= 64.0 * f64::EPSILON * size
    }
}

impl Ellipsoid<2> {
    /// Angle of the longer axis, in radians from x, in (−π/2, π/2].
    pub fn angle(&self) -> f64 {
        let (mut x, mut y) = (self.axes[(0, 0)], self.axes[(1, 0)]);
        if x < 0.0 || (x == 0.0 && y < 0.0) {
            (x, y) = (-x, -y);
        }
        nalgebra::SimdRealField::simd_atan2(y, x)
    }

    /// The point of the boundary at parameter t, once round for t from 0 to 2π.
    pub fn boundary(&self, t: f64) -> Vector2<f64> {
        let (sin, cos) = t.simd_sin_cos();
        self.centre + self.axes.column(0) * cos + self.axes.column(1) * sin
    }
}
