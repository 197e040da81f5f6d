//! What can be wrong with a graph.

use super::Kernel;
use super::diagnose::Unconstrained;
use super::names::{FactorName, VariableName};
use crate::trajectory::TrajectoryError;

/// Why a graph cannot be solved, or a matrix cannot be a noise.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GraphError {
    /// A key does not belong to these values.
    #[error(
        "{kind} key {number} is not in these values; insert the variable first, and use keys with the values that made them"
    )]
    ForeignKey {
        /// Kind of the variable.
        kind: &'static str,
        /// Number of the key.
        number: u32,
    },
    /// Variables are read by factors but have no value.
    #[error("{} variable(s) have no initial value, the first is {}; set them, or initialise from the measurements (spanning tree or chordal)", variables.len(), variables[0])]
    MissingValues {
        /// All of them, at least one.
        variables: Vec<VariableName>,
    },
    /// A value holds NaN or infinity.
    #[error("{variable} holds a number that is not finite; correct its initial value")]
    ValueNotFinite {
        /// The first such variable.
        variable: VariableName,
    },
    /// A residual is NaN or infinite at the initial values.
    #[error(
        "the residual of {factor} is not finite at the initial values; check its measurement and the values it reads"
    )]
    ResidualNotFinite {
        /// The first such factor.
        factor: FactorName,
    },
    /// Factors that are computed together do not read variables of the same kinds, or not equally many.
    #[error(
        "the variables of {factors} factors must come as one to four columns, each of one kind and {factors} long"
    )]
    UnevenBatch {
        /// How many factors have a noise.
        factors: usize,
    },
    /// A matrix holds NaN or infinity.
    #[error("the matrix holds a number that is not finite")]
    NotFinite,
    /// A standard deviation is not positive and finite.
    #[error("a standard deviation must be positive and finite, not {sigma}")]
    InvalidSigma {
        /// The first such number.
        sigma: f64,
    },
    /// A matrix that must be symmetric is not.
    #[error("the matrix is not symmetric: two mirrored entries differ by {asymmetry:.3e}")]
    NotSymmetric {
        /// Largest difference of mirrored entries.
        asymmetry: f64,
    },
    /// A matrix that must be positive definite is not.
    #[error("the matrix is not positive definite: its smallest eigenvalue is {smallest_eigenvalue:.3e}")]
    NotPositiveDefinite {
        /// Its smallest eigenvalue.
        smallest_eigenvalue: f64,
    },
    /// Nothing constrains some directions of some variables.
    #[error("{0}")]
    Unconstrained(Unconstrained),
    /// A covariance was asked of a variable that no factor reads.
    #[error("{variable} is read by no factor, so that nothing is known of it; add a measurement")]
    Unread {
        /// The variable.
        variable: VariableName,
    },
    /// The normal equations could not be factorised though every direction is constrained.
    #[error(
        "the normal equations lost positive definiteness to rounding; rescale the noises, or use Levenberg–Marquardt"
    )]
    IllConditioned,
    /// The scale of a robust kernel is not positive and finite, or Barron's shape is above 2.
    #[error(
        "{kernel:?} is no robust kernel: its scale must be positive and finite (and Barron's shape at most 2)"
    )]
    InvalidKernel {
        /// The first such kernel.
        kernel: Kernel,
    },
    /// A time outside the trajectory, or states between which none leads.
    #[error(transparent)]
    Trajectory(#[from] TrajectoryError),
    /// Memory for the factorisation could not be had.
    #[error(
        "not enough memory to factorise the normal equations; the graph is too dense for a direct method"
    )]
    OutOfMemory,
}
