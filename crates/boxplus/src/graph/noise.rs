//! How sure a measurement is: the square root of its information matrix.

use nalgebra::{Cholesky, SMatrix, SVector};

use super::GraphError;

/// Gaussian noise of an R-dimensional residual, kept as the upper triangular U with Ω = UᵀU, so that the
/// whitened residual is U·r.
///
/// ```
/// use boxplus::graph::Noise;
/// use nalgebra::{matrix, vector};
/// let noise = Noise::from_sigmas(&vector![0.1, 0.1, 0.02])?; // metres, metres, radians
/// assert!(Noise::<2>::from_information(&matrix![1.0, 2.0; 2.0, 1.0]).is_err()); // not positive definite
/// # Ok::<(), boxplus::graph::GraphError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise<const R: usize> {
    sqrt_information: SMatrix<f64, R, R>,
}

impl<const R: usize> Noise<R> {
    /// Standard deviation one in every coordinate.
    pub fn unit() -> Self {
        Self { sqrt_information: SMatrix::identity() }
    }

    /// One standard deviation per coordinate, in the units of the residual.
    ///
    /// # Errors
    /// [`GraphError::InvalidSigma`] unless all are finite and positive.
    pub fn from_sigmas(sigmas: &SVector<f64, R>) -> Result<Self, GraphError> {
        match sigmas.iter().find(|sigma| !(sigma.is_finite() && **sigma > 0.0)) {
            Some(&sigma) => Err(GraphError::InvalidSigma { sigma }),
            None => Ok(Self { sqrt_information: SMatrix::from_diagonal(&sigmas.map(f64::recip)) }),
        }
    }

    /// The information matrix Ω = Σ⁻¹, R×R, in the inverse units of the residual, squared.
    ///
    /// # Errors
    /// [`GraphError::NotFinite`], [`GraphError::NotSymmetric`] beyond 1.5e-8 of the largest entry, or
    /// [`GraphError::NotPositiveDefinite`] with the smallest eigenvalue.
    pub fn from_information(information: &SMatrix<f64, R, R>) -> Result<Self, GraphError> {
        if !information.iter().all(|x| x.is_finite()) {
            return Err(GraphError::NotFinite);
        }
        // An inverse is symmetric to κε; beyond half the digits it is no rounding.
        let asymmetry = (information - information.transpose()).amax();
        if asymmetry > f64::EPSILON.sqrt() * information.amax() {
            return Err(GraphError::NotSymmetric { asymmetry });
        }
        match Cholesky::new(*information) {
            Some(factor) => Ok(Self { sqrt_information: factor.l().transpose() }),
            None => {
                Err(GraphError::NotPositiveDefinite { smallest_eigenvalue: smallest_eigenvalue(information) })
            }
        }
    }

    /// The covariance matrix Σ, R×R, in the units of the residual, squared.
    ///
    /// # Errors
    /// As [`Self::from_information`].
    pub fn from_covariance(covariance: &SMatrix<f64, R, R>) -> Result<Self, GraphError> {
        Self::from_information(covariance)?; // says what is wrong with it
        // Σ = VVᵀ with V upper triangular: Cholesky's factor from the last row up. Then U = V⁻¹, and no digit is lost to an inverse of Σ.
        let reversed =
            |m: &SMatrix<f64, R, R>| SMatrix::<f64, R, R>::from_fn(|i, j| m[(R - 1 - i, R - 1 - j)]);
        let lower = Cholesky::new(reversed(covariance)).map(|factor| factor.l());
        let inverse = lower.and_then(|lower| lower.solve_lower_triangular(&SMatrix::identity()));
        let inverse = inverse.ok_or(GraphError::NotPositiveDefinite { smallest_eigenvalue: 0.0 })?;
        Ok(Self { sqrt_information: reversed(&inverse) })
    }

    /// U, upper triangular, with Ω = UᵀU.
    pub fn sqrt_information(&self) -> &SMatrix<f64, R, R> {
        &self.sqrt_information
    }

    /// Ω.
    pub fn information(&self) -> SMatrix<f64, R, R> {
        self.sqrt_information.transpose() * self.sqrt_information
    }
}

/// Smallest eigenvalue of a symmetric matrix.
fn smallest_eigenvalue<const R: usize>(matrix: &SMatrix<f64, R, R>) -> f64 {
    let dynamic = nalgebra::DMatrix::from_column_slice(R, R, matrix.as_slice());
    dynamic.symmetric_eigenvalues().min()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{matrix, vector};

    #[test]
    fn covariance_and_information_are_inverse() {
        let covariance = matrix![4.0, 1.0, 0.5; 1.0, 3.0, -0.2; 0.5, -0.2, 1.0];
        let noise = Noise::from_covariance(&covariance).unwrap();
        assert!((noise.information() * covariance - SMatrix::identity()).amax() < 1e-14);
        assert!((Noise::from_sigmas(&vector![2.0]).unwrap().information()[0] - 0.25).abs() < 1e-16);
    }

    #[test]
    fn faulty_matrices_are_refused_with_their_reason() {
        let indefinite = Noise::from_information(&matrix![1.0, 2.0; 2.0, 1.0]);
        assert!(
            matches!(indefinite, Err(GraphError::NotPositiveDefinite { smallest_eigenvalue }) if (smallest_eigenvalue + 1.0).abs() < 1e-12)
        );
        let skew = Noise::from_information(&matrix![1.0, 0.1; 0.2, 1.0]);
        assert!(matches!(skew, Err(GraphError::NotSymmetric { .. })));
        for bad in [f64::NAN, f64::INFINITY] {
            assert!(matches!(Noise::from_information(&matrix![bad]), Err(GraphError::NotFinite)));
        }
        for bad in [0.0, -0.1, f64::NAN, f64::INFINITY] {
            assert!(matches!(Noise::from_sigmas(&vector![bad]), Err(GraphError::InvalidSigma { .. })));
        }
    }
}
