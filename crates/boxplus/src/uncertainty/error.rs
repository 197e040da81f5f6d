//! What can be wrong with an uncertainty, and along which direction.

use core::fmt;

/// A unit direction of a tangent space by its (at most) three largest coordinates, largest first.
///
/// Indices count the coordinates of the tangent from 0; those of a joint run on through its elements. Printed as
/// `0.98·τ[2] − 0.17·τ[5]`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Direction {
    /// (index, coefficient); unused places have coefficient 0.
    pub coordinates: [(usize, f64); 3],
}

/// Coefficients below this share of the largest are not worth a name.
const NEGLIGIBLE: f64 = 1e-3;

impl Direction {
    /// The direction of the given coordinates, which need not be normalised.
    pub(super) fn of(coordinates: impl Iterator<Item = f64> + Clone) -> Self {
        let largest = coordinates.clone().fold(0.0, |a: f64, x| a.max(x.abs()));
        let norm = norm(coordinates.clone());
        // Signs are arbitrary: the largest coordinate is positive.
        let sign = coordinates.clone().find(|x| x.abs() == largest).map_or(1.0, f64::signum);
        let mut kept = [(0, 0.0_f64); 3];
        for (index, x) in coordinates.enumerate().filter(|(_, x)| x.abs() > NEGLIGIBLE * largest) {
            if let Some(place) = kept.iter().position(|(_, held)| x.abs() > held.abs() * norm) {
                kept[place..].rotate_right(1);
                kept[place] = (index, sign * x / norm);
            }
        }
        Self { coordinates: kept }
    }
}

fn norm(coordinates: impl Iterator<Item = f64>) -> f64 {
    nalgebra::SimdComplexField::simd_sqrt(coordinates.map(|x| x * x).sum::<f64>())
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, (index, x)) in self.coordinates.iter().filter(|(_, x)| *x != 0.0).enumerate() {
            let sign = match (place, *x < 0.0) {
                (0, false) => "",
                (0, true) => "−",
                (_, false) => " + ",
                (_, true) => " − ",
            };
            write!(f, "{sign}{:.2}·τ[{index}]", x.abs())?;
        }
        Ok(())
    }
}

/// Why numbers do not make an uncertainty, or an operation has no answer.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum UncertaintyError {
    /// An entry is NaN or infinite.
    #[error("entry ({row}, {column}) is NaN or infinite")]
    NotFinite {
        /// Its row, from 0.
        row: usize,
        /// Its column, from 0.
        column: usize,
    },
    /// Σᵢⱼ and Σⱼᵢ differ by more than rounding, √ε of the standard deviations.
    #[error("entries ({row}, {column}) and ({column}, {row}) of a covariance differ by {difference:.1e}")]
    Asymmetric {
        /// Row of the entry that differs most from its mirror image.
        row: usize,
        /// Its column.
        column: usize,
        /// By how much.
        difference: f64,
    },
    /// A variance is negative.
    #[error("the variance along {direction} is {variance:.1e}; a covariance has none below 0")]
    Indefinite {
        /// The smallest eigenvalue of the matrix scaled to unit diagonal: a pure number.
        eigenvalue: f64,
        /// dᵀΣd along the unit direction d.
        variance: f64,
        /// d.
        direction: Direction,
    },
    /// The variance along a direction is zero, and the operation divides by it.
    #[error("the covariance is singular: nothing is uncertain along {direction}")]
    Singular {
        /// The direction, without variance.
        direction: Direction,
    },
    /// An information matrix says nothing along a direction, so that its covariance would be infinite.
    #[error("the information matrix says nothing along {direction}; its variance would be infinite")]
    NoInformation {
        /// The direction, without information.
        direction: Direction,
    },
    /// A standard deviation that is negative, NaN or infinite, or whose square is.
    #[error(
        "a standard deviation must be finite, as its square must, and at least 0, but σ[{index}] = {sigma}"
    )]
    InvalidSigma {
        /// Its coordinate.
        index: usize,
        /// What was given.
        sigma: f64,
    },
    /// A covariance from fewer than two samples, or a combination of no estimates.
    #[error("{given} given, at least {needed} needed")]
    TooFew {
        /// How many were given.
        given: usize,
        /// How many are needed.
        needed: usize,
    },
    /// An index list in which one index is missing or too large.
    #[error("not a permutation: no place holds index {missing}")]
    NotAPermutation {
        /// The smallest index that does not occur.
        missing: usize,
    },
    /// An iteration did not settle: the inputs are too far apart, or too uncertain, for one Gaussian.
    #[error("not settled after {iterations} iterations (last step {step:.1e}); the inputs are too far apart")]
    NotConverged {
        /// How many were made.
        iterations: usize,
        /// Length of the last step.
        step: f64,
    },
    /// Yaw and roll turn about one axis at a pitch of ±π/2, where no covariance of the three angles exists.
    #[error("pitch {pitch} is ±π/2 up to rounding: yaw and roll are not distinguished (gimbal lock)")]
    GimbalLock {
        /// The pitch, in radians.
        pitch: f64,
    },
    /// A probability outside (0, 1).
    #[error("a probability must lie between 0 and 1, not at {given}")]
    NotAProbability {
        /// What was given.
        given: f64,
    },
}
