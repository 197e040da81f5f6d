//! A covariance matrix that is known to be one.

use super::error::{Direction, UncertaintyError};
use super::linear;
use crate::lie::Real;
use core::ops::{Add, Mul};
use nalgebra::{SMatrix, SVector};

/// A covariance Σ of ℝᴰ: symmetric and positive semi-definite, checked once, when it is made.
///
/// Directions without variance are allowed (a wheel that cannot slip sideways) and known: [`Covariance::rank`],
/// [`Covariance::null_directions`]. What needs Σ⁻¹ says so and returns an error that names such a direction.
///
/// ```
/// use boxplus::uncertainty::{Covariance, UncertaintyError};
/// use nalgebra::{matrix, vector};
/// let wheel = Covariance::from_sigmas(&vector![0.1, 0.0, 0.02])?; // metres, metres, radians
/// assert_eq!(wheel.rank(), 2);
/// assert!(wheel.information().unwrap_err().to_string().contains("1.00·τ[1]"));
/// let wrong = Covariance::new(matrix![1.0, 2.0; 2.0, 1.0]).unwrap_err();
/// assert_eq!(wrong.to_string(), "the variance along 0.71·τ[0] − 0.71·τ[1] is -1.0e0; a covariance has none below 0");
/// # Ok::<(), UncertaintyError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Covariance<const D: usize, S = f64> {
    matrix: SMatrix<S, D, D>,
}

impl<const D: usize, S: Real> Covariance<D, S> {
    /// Checks a D×D matrix in the units of the tangent, squared. Rounding is forgiven: an asymmetry of √ε of the
    /// standard deviations, an eigenvalue of −√ε where the diagonal is scaled to 1.
    ///
    /// # Errors
    /// [`UncertaintyError::NotFinite`], [`UncertaintyError::Asymmetric`], [`UncertaintyError::Indefinite`].
    pub fn new(matrix: SMatrix<S, D, D>) -> Result<Self, UncertaintyError> {
        Ok(Self { matrix: linear::checked(&matrix)? })
    }

    /// No uncertainty at all.
    pub fn zero() -> Self {
        Self { matrix: SMatrix::zeros() }
    }

    /// Independent coordinates with variance 1.
    pub fn unit() -> Self {
        Self { matrix: SMatrix::identity() }
    }

    /// Independent coordinates with the given standard deviations, in the units of the tangent; 0 is allowed.
    ///
    /// # Errors
    /// [`UncertaintyError::InvalidSigma`].
    pub fn from_sigmas(sigmas: &SVector<S, D>) -> Result<Self, UncertaintyError> {
        // A square may overflow where its root is finite.
        let valid = |x: S| x.value() >= 0.0 && (x * x).value().is_finite();
        match sigmas.iter().enumerate().find(|(_, x)| !valid(**x)) {
            Some((index, sigma)) => Err(UncertaintyError::InvalidSigma { index, sigma: sigma.value() }),
            None => Ok(Self::independent(sigmas)),
        }
    }

    /// The same of standard deviations that nobody gave but a model computed: NaN stays NaN, for a filter to refuse.
    pub(crate) fn independent(sigmas: &SVector<S, D>) -> Self {
        Self { matrix: SMatrix::from_diagonal(&sigmas.map(|x| x * x)) }
    }

    /// Ω⁻¹ of an information matrix Ω, D×D, in the inverse units of the tangent, squared.
    ///
    /// # Errors
    /// Those of [`Covariance::new`], [`UncertaintyError::NoInformation`] where Ω is singular.
    pub fn from_information(information: &SMatrix<S, D, D>) -> Result<Self, UncertaintyError> {
        let inverse = Self::new(*information)?.information();
        inverse.map(Self::by_construction).map_err(|error| match error {
            UncertaintyError::Singular { direction } => UncertaintyError::NoInformation { direction },
            other => other,
        })
    }

    /// A matrix that is semi-definite because of how it was found; only its rounding is made symmetric.
    pub(crate) fn by_construction(matrix: SMatrix<S, D, D>) -> Self {
        Self { matrix: linear::symmetrised(&matrix) }
    }

    /// Σ, D×D.
    pub fn matrix(&self) -> &SMatrix<S, D, D> {
        &self.matrix
    }

    /// The standard deviation of each coordinate.
    pub fn sigmas(&self) -> SVector<S, D> {
        // √0 has no derivative for dual numbers.
        self.matrix.diagonal().map(|x| if x.value() > 0.0 { x.simd_sqrt() } else { S::zero() })
    }

    /// JΣJᵀ, M×M: the covariance of J·ξ.
    pub fn transformed<const M: usize>(&self, j: &SMatrix<S, M, D>) -> Covariance<M, S> {
        Covariance::by_construction(j * self.matrix * j.transpose())
    }

    /// The covariance with coordinate i taken from place `order[i]`: how other libraries' tangent orders are read.
    ///
    /// ```
    /// use boxplus::uncertainty::Covariance;
    /// let rotation_first = Covariance::<6>::from_sigmas(&[0.1, 0.2, 0.3, 1.0, 2.0, 3.0].into())?;
    /// let ours = rotation_first.permuted(&[3, 4, 5, 0, 1, 2])?;
    /// assert!((ours.sigmas() - nalgebra::vector![1.0, 2.0, 3.0, 0.1, 0.2, 0.3]).norm() < 1e-15);
    /// # Ok::<(), boxplus::uncertainty::UncertaintyError>(())
    /// ```
    ///
    /// # Errors
    /// [`UncertaintyError::NotAPermutation`].
    pub fn permuted(&self, order: &[usize; D]) -> Result<Self, UncertaintyError> {
        match (0..D).find(|i| !order.contains(i)) {
            Some(missing) => Err(UncertaintyError::NotAPermutation { missing }),
            None => Ok(Self { matrix: SMatrix::from_fn(|i, j| self.matrix[(order[i], order[j])]) }),
        }
    }

    /// L, lower triangular, with Σ = LLᵀ; column k is 0 where coordinate k adds no variance to those before it.
    pub fn factor(&self) -> SMatrix<S, D, D> {
        linear::cholesky(&self.matrix)
    }

    /// The factor of a regular Σ.
    pub(crate) fn regular_factor(&self) -> Result<SMatrix<S, D, D>, UncertaintyError> {
        let l = self.factor();
        if linear::is_singular(&l) {
            return Err(UncertaintyError::Singular { direction: self.weakest_direction() });
        }
        Ok(l)
    }

    /// Σ⁻¹, D×D.
    ///
    /// # Errors
    /// [`UncertaintyError::Singular`].
    pub fn information(&self) -> Result<SMatrix<S, D, D>, UncertaintyError> {
        let l = self.regular_factor()?;
        let mut inverse = SMatrix::<S, D, D>::identity();
        inverse.column_iter_mut().for_each(|mut column| linear::solve(&l, column.as_mut_slice()));
        Ok(linear::symmetrised(&inverse))
    }

    /// Σ⁻·B, with Σ⁻ a generalised inverse: whichever is taken, JΣ⁻Jᵀ is the same if the rows of J lie in the range of Σ.
    pub(crate) fn generalised_solve<const M: usize>(&self, b: &SMatrix<S, D, M>) -> SMatrix<S, D, M> {
        let (l, mut x) = (self.factor(), *b);
        x.column_iter_mut().for_each(|mut column| linear::solve(&l, column.as_mut_slice()));
        x
    }

    /// ξᵀΣ⁻¹ξ.
    ///
    /// # Errors
    /// [`UncertaintyError::Singular`].
    pub fn mahalanobis_squared(&self, xi: &SVector<S, D>) -> Result<S, UncertaintyError> {
        let (l, mut white) = (self.regular_factor()?, *xi);
        linear::forward(&l, white.as_mut_slice());
        Ok(white.norm_squared())
    }

    /// ln det Σ, by the logarithms of the pivots.
    ///
    /// # Errors
    /// [`UncertaintyError::Singular`].
    pub fn log_determinant(&self) -> Result<S, UncertaintyError> {
        let l = self.regular_factor()?;
        Ok((0..D).fold(S::zero(), |sum, i| sum + l[(i, i)].simd_ln() * S::lit(2.0)))
    }

    /// Number of directions with variance, up to rounding.
    pub fn rank(&self) -> usize {
        D - self.null_directions().count()
    }

    /// Unit directions without variance, up to rounding, as columns of length D.
    pub fn null_directions(&self) -> impl Iterator<Item = SVector<f64, D>> + use<D, S> {
        let (values, vectors) = linear::scaled_eigen(&self.matrix.map(Real::value));
        let null = linear::null::<S>(D);
        (0..D).filter(move |&k| values[(k, k)] <= null).map(move |k| vectors.column(k).normalize())
    }

    /// `(variances, axes)`: eigenvalues in descending order and, as columns, their unit eigenvectors.
    ///
    /// Metres and radians mix in these axes; they draw a region, but judge nothing ([`Covariance::rank`] does).
    pub fn principal_axes(&self) -> (SVector<f64, D>, SMatrix<f64, D, D>) {
        let (values, vectors) = linear::eigen(&self.matrix.map(Real::value));
        let mut order: [usize; D] = core::array::from_fn(|i| i);
        order.sort_unstable_by(|&i, &j| values[(j, j)].total_cmp(&values[(i, i)]));
        let axes = SMatrix::from_fn(|i, k| vectors[(i, order[k])]);
        (SVector::from_fn(|k, _| values[(order[k], order[k])].max(0.0)), axes)
    }

    /// The direction of smallest variance where coordinates are scaled to variance 1, in words.
    pub fn weakest_direction(&self) -> Direction {
        linear::weakest(&linear::scaled_eigen(&self.matrix.map(Real::value))).1
    }
}

/// The covariance of a sum of independent errors.
impl<const D: usize, S: Real> Add for Covariance<D, S> {
    type Output = Self;
    fn add(self, rhs: Self) -> Self {
        Self { matrix: self.matrix + rhs.matrix }
    }
}

/// Σ·k², the covariance of k·ξ: `covariance * k` scales standard deviations by k.
impl<const D: usize, S: Real> Mul<S> for Covariance<D, S> {
    type Output = Self;
    fn mul(self, k: S) -> Self {
        Self { matrix: self.matrix * (k * k) }
    }
}
