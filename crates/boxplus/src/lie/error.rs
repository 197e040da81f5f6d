//! What can be wrong with numbers that should become a group element.

/// Why numbers do not determine an element of a group.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LieError {
    /// A component is NaN or infinite.
    #[error("a component is NaN or infinite; check the source of the numbers")]
    NotFinite,
    /// All components of a quaternion or of (cos, sin) are zero.
    #[error("all components are zero, which is no rotation; was the field left unset?")]
    Zero,
    /// RᵀR differs from I by more than rounding in print.
    #[error("not a rotation: RᵀR differs from I by {deviation:.1e}; `project` gives the nearest rotation")]
    NotARotation {
        /// Largest entry of |RᵀR − I|.
        deviation: f64,
    },
    /// An orthogonal matrix with determinant −1: it mirrors.
    #[error("a reflection (determinant −1), not a rotation; an axis is flipped or two are exchanged")]
    Reflection,
    /// Several rotations are equally near to the matrix.
    #[error(
        "the nearest rotation is not unique: relative gap {gap:.1e} (a matrix of rank below 2, or a reflection)"
    )]
    Undetermined {
        /// (σ₂ ± σ₃)/σ₁ of the singular values, σ₃ signed by the determinant; in 2-D, what remains of a rotation.
        gap: f64,
    },
    /// A scale that is not a positive number.
    #[error("a scale must be positive, not {scale}; its logarithm is the coordinate")]
    NotAScale {
        /// What was given.
        scale: f64,
    },
    /// The last row of a homogeneous matrix is not (0, …, 0, 1).
    #[error("the last row of the matrix must be (0, …, 0, 1); was it transposed?")]
    NotHomogeneous,
    /// Stored numbers whose quaternion or (cos, sin) is not of unit norm.
    #[error(
        "the rotation is not of unit norm: |q|² differs from 1 by {deviation:.1e}; normalise it, or check the order of the numbers"
    )]
    NotUnit {
        /// ||q|² − 1|.
        deviation: f64,
    },
}
