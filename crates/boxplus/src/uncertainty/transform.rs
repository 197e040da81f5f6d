//! An uncertain element through any function.
//!
//! The function takes an element of a group and returns a point of any [`Manifold`]: an element, a direction, a vector
//! ([`Rn`](crate::lie::Rn)). Nothing but its values is asked for. Two ways, each with its own kind of error:
//!
//! - [`Gaussian::unscented`] sees f at ±√D standard deviations: right for a wide error and a function that is odd there.
//! - [`Gaussian::expanded`] takes derivatives at the mean, to the order you say.
//!
//! Unscented compounding of independent poses equals second order (Barfoot & Furgale (2014) (57)): sigma points do not
//! replace [`compound`](super::compound) to fourth order.

use super::{Covariance, Gaussian, Order, Side, UncertaintyError};
use crate::lie::{LieGroup, Manifold, Real, Tangent};
use nalgebra::{SMatrix, SVector, SimdComplexField};

/// The weights of sigma points: λ = α²(D + κ) − D, points at √(D + λ) standard deviations. Wan & van der Merwe (2000).
///
/// The default, α = 1 and β = κ = 0, has no centre point and equal positive weights, so that a covariance is always
/// semi-definite. β = 2 suits a Gaussian's fourth moment along one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SigmaPoints {
    /// Spread of the points, 0 < α ≤ 1.
    pub alpha: f64,
    /// Added to the centre's weight in the covariance, with 1 − α².
    pub beta: f64,
    /// Secondary spread, κ > −D.
    pub kappa: f64,
}

impl Default for SigmaPoints {
    fn default() -> Self {
        Self { alpha: 1.0, beta: 0.0, kappa: 0.0 }
    }
}

/// What a function makes of an uncertain element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transformed<H: Manifold<M>, const M: usize, const D: usize> {
    /// The mean of the image.
    pub mean: H,
    /// Its covariance, in the coordinates of ⊞ at the mean (on a group, the local side).
    pub covariance: Covariance<M, H::Scalar>,
    /// E\[ξ·ηᵀ\], D×M: error of the input, on its side, with error of the image.
    pub cross: SMatrix<H::Scalar, D, M>,
}

impl<H, const M: usize, const D: usize> Transformed<H, M, D>
where
    H: LieGroup<M>,
{
    /// The image as an uncertain element of its group.
    pub fn gaussian(&self) -> Gaussian<H, M> {
        Gaussian::new(self.mean, self.covariance)
    }
}

/// The images of the sigma points.
struct Images<H, const D: usize> {
    centre: H,
    plus: [H; D],
    minus: [H; D],
}

impl<G: LieGroup<D>, const D: usize, E: Side> Gaussian<G, D, E> {
    /// Through f by 2D + 1 sigma points X̄ ⊞ ±√(D + λ)·L e_k, Σ = LLᵀ; the mean of their images is the fixed point
    /// Σw·(Yᵢ ⊟ Ȳ) = 0.
    ///
    /// ```
    /// use boxplus::lie::{Action, Rn, SE2};
    /// use boxplus::uncertainty::{Gaussian, SigmaPoints};
    /// use nalgebra::vector;
    /// let pose = Gaussian::<SE2, 3>::from_sigmas(SE2::new(vector![1.0, 2.0], 0.5), &vector![0.1, 0.1, 0.05])?;
    /// let range = |x: &SE2| Rn::new(vector![x.act_inverse(&vector![4.0, 6.0]).norm()]);
    /// let seen = pose.unscented(range, &SigmaPoints::default())?;
    /// assert!((seen.mean.vector().x - 5.0).abs() < 2e-3);
    /// assert!((seen.covariance.sigmas().x - 0.1).abs() < 1e-4);
    /// # Ok::<(), boxplus::uncertainty::UncertaintyError>(())
    /// ```
    ///
    /// # Errors
    /// [`UncertaintyError::NotConverged`] where the images have no mean or are not finite, [`UncertaintyError::Indefinite`] where
    /// a negative weight leaves no covariance.
    pub fn unscented<H, const M: usize>(
        &self,
        f: impl Fn(&G) -> H,
        points: &SigmaPoints,
    ) -> Result<Transformed<H, M, D>, UncertaintyError>
    where
        H: Manifold<M, Scalar = G::Scalar>,
    {
        let n = D as f64;
        let square = points.alpha * points.alpha * (n + points.kappa); // D + λ
        let spread = self.covariance().factor() * G::Scalar::lit(square.simd_sqrt());
        let images = self.images(&f, &spread);
        let (weight, centre) = (0.5 / square, 1.0 - n / square);
        let mean = images.mean::<M>(weight, centre)?;
        let centre = centre + 1.0 - points.alpha * points.alpha + points.beta;
        let offset = images.centre.minus(&mean);
        let mut covariance = offset * offset.transpose() * G::Scalar::lit(centre);
        let mut cross = SMatrix::zeros();
        for k in 0..D {
            let (p, m) = (images.plus[k].minus(&mean), images.minus[k].minus(&mean));
            covariance += (p * p.transpose() + m * m.transpose()) * G::Scalar::lit(weight);
            cross += spread.column(k) * (p - m).transpose() * G::Scalar::lit(weight);
        }
        Ok(Transformed { mean, covariance: Covariance::new(covariance)?, cross })
    }

    fn images<H>(&self, f: &impl Fn(&G) -> H, spread: &SMatrix<G::Scalar, D, D>) -> Images<H, D> {
        let at = |k: usize, sign: f64| f(&self.perturbed(&(spread.column(k) * G::Scalar::lit(sign))));
        Images {
            centre: f(self.mean()),
            plus: core::array::from_fn(|k| at(k, 1.0)),
            minus: core::array::from_fn(|k| at(k, -1.0)),
        }
    }

    /// Through f by its derivatives at the mean, taken by central differences along the columns of L, Σ = LLᵀ.
    ///
    /// With η the error of the image about f(X̄), gᵢ = ∂η/∂(L e_i) and Hᵢⱼ the second derivatives:
    ///
    /// ```text
    /// First    mean f(X̄)                  Σ gᵢgᵢᵀ
    /// Second   mean f(X̄) ⊞ ½ΣHᵢᵢ          Σ gᵢgᵢᵀ
    /// Fourth   mean f(X̄) ⊞ ½ΣHᵢᵢ          Σ gᵢgᵢᵀ + ½Σ HᵢⱼHᵢⱼᵀ
    /// ```
    ///
    /// `Fourth` is exact for functions of second degree; third derivatives, of the same order in Σ, are left out as in
    /// Barfoot & Furgale (2014) §V.
    pub fn expanded<H, const M: usize>(&self, f: impl Fn(&G) -> H, order: Order) -> Transformed<H, M, D>
    where
        H: Manifold<M, Scalar = G::Scalar>,
    {
        // h = ε^(1/6): rounding ε/h² and truncation h⁴ (gᵢ, Hᵢᵢ) are alike; h² in mixed Hᵢⱼ is below what is neglected.
        let h = if G::Scalar::EPSILON > 1e-10 { 1.0 / 16.0 } else { 1.0 / 512.0 };
        let (l, base) = (self.covariance().factor(), f(self.mean()));
        let at = |xi: &Tangent<G::Scalar, D>| f(&self.perturbed(xi)).minus(&base);
        let stencil =
            |k: usize| [1.0, -1.0, 2.0, -2.0].map(|s: f64| at(&(l.column(k) * G::Scalar::lit(s * h))));
        let (mut covariance, mut shift) = (SMatrix::zeros(), SVector::zeros());
        let mut cross = SMatrix::zeros();
        for k in 0..D {
            let [p, m, pp, mm] = stencil(k);
            let first = ((p - m) * G::Scalar::lit(8.0) - (pp - mm)) * G::Scalar::lit(1.0 / (12.0 * h));
            let second = ((p + m) * G::Scalar::lit(16.0) - (pp + mm)) * G::Scalar::lit(1.0 / (12.0 * h * h));
            covariance += first * first.transpose();
            cross += l.column(k) * first.transpose();
            shift += second * G::Scalar::lit(0.5);
            if order == Order::Fourth {
                covariance += second * second.transpose() * G::Scalar::lit(0.5);
                for j in 0..k {
                    let corner = |a: f64, b: f64| {
                        at(&(l.column(k) * G::Scalar::lit(a * h) + l.column(j) * G::Scalar::lit(b * h)))
                    };
                    let sum = corner(1.0, 1.0) + corner(-1.0, -1.0) - corner(1.0, -1.0) - corner(-1.0, 1.0);
                    let mixed = sum * G::Scalar::lit(0.25 / (h * h));
                    covariance += mixed * mixed.transpose(); // Hⱼₖ and Hₖⱼ
                }
            }
        }
        let mean = if order == Order::First { base } else { base.plus(&shift) };
        Transformed { mean, covariance: Covariance::by_construction(covariance), cross }
    }
}

impl<H, const D: usize> Images<H, D> {
    /// The weighted mean as a fixed point.
    fn mean<const M: usize>(&self, weight: f64, centre: f64) -> Result<H, UncertaintyError>
    where
        H: Manifold<M>,
    {
        const ITERATIONS: usize = 50;
        let mut mean = self.centre;
        let mut length = 0.0;
        for _ in 0..ITERATIONS {
            let (mut step, mut spread) = (self.centre.minus(&mean) * H::Scalar::lit(centre), 0.0);
            for y in self.plus.iter().chain(&self.minus) {
                let difference = y.minus(&mean);
                spread += difference.norm_squared().value() * weight;
                step += difference * H::Scalar::lit(weight);
            }
            mean = mean.plus(&step);
            length = step.norm_squared().value().simd_sqrt();
            // Below rounding of the differences there is nothing to gain.
            let weights = 1.0 + centre.abs() + 2.0 * D as f64 * weight;
            if length <= 64.0 * H::Scalar::EPSILON * weights * (1.0 + spread.simd_sqrt()) {
                return Ok(mean);
            }
        }
        Err(UncertaintyError::NotConverged { iterations: ITERATIONS, step: length })
    }
}
