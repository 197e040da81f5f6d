//! What can be wrong with numbers that should become a group element, and with elements that should have a mean.

/// Why numbers, or elements, do not determine an element of a group.
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
    /// The name is none of the 24 Euler sequences.
    #[error(
        "an Euler sequence is three of x, y, z, no two alike in a row: `ZYX` about the moving axes, `zyx` about the fixed ones"
    )]
    NotASequence,
    /// The first and the third Euler angle turn about one axis, so that only their sum or difference is determined.
    #[error(
        "gimbal lock: the middle angle is {margin:.1e} rad from where the first and the third axis coincide; take another sequence"
    )]
    GimbalLock {
        /// Distance of the middle angle from the lock, in radians.
        margin: f64,
    },
    /// A half turn, whose Gibbs vector is infinite.
    #[error("a rotation by π has no Gibbs vector; modified Rodrigues parameters reach up to 2π")]
    HalfTurn,
    /// The identity, whose shadow parameters are infinite.
    #[error("the identity has no shadow parameters; its modified Rodrigues parameters are 0")]
    NoShadow,
    /// Two directions that should span a plane lie on one line.
    #[error("the directions are parallel (sine of their angle {sine:.1e}); they must span a plane")]
    Parallel {
        /// |a × b|/(|a|·|b|).
        sine: f64,
    },
    /// A rotation that turns the axis over, whose twist about that axis can be anything.
    #[error("the rotation turns the axis over; its twist about the axis is undetermined")]
    AxisReversed,
    /// The identity, whose axis can be any and so has no derivative.
    #[error("the identity turns about no axis; differentiate its rotation vector, `log_jac`")]
    NoAxis,
    /// Opposite directions, between which the shortest rotation jumps.
    #[error(
        "the directions are opposite; the shortest rotation between them jumps there and has no derivative"
    )]
    Opposite,
    /// A whole number of turns, where a translation has no logarithm.
    #[error(
        "after whole turns the rotation is the identity and a translation has no logarithm there; take `log`"
    )]
    WholeTurns,
    /// Not a covariance: asymmetric, or negative along some direction.
    #[error("not a covariance: {deviation:.1e} of its largest entry contradicts symmetry or definiteness")]
    NotACovariance {
        /// Relative size of what is wrong.
        deviation: f64,
    },
    /// Stored numbers whose quaternion or (cos, sin) is not of unit norm.
    #[error(
        "the rotation is not of unit norm: |q|² differs from 1 by {deviation:.1e}; normalise it, or check the order of the numbers"
    )]
    NotUnit {
        /// ||q|² − 1|.
        deviation: f64,
    },
    /// A mean of nothing.
    #[error("no elements, no mean")]
    NoElements,
    /// Not one weight per element.
    #[error("{weights} weights for {elements} elements; each needs one")]
    WeightCount {
        /// How many elements were given.
        elements: usize,
        /// How many weights.
        weights: usize,
    },
    /// A weight that is negative, NaN or infinite.
    #[error("a weight must be finite and at least 0, but that of element {index} is {weight}")]
    NotAWeight {
        /// The element, from 0.
        index: usize,
        /// Its weight.
        weight: f64,
    },
    /// A threshold that is negative, 0 or NaN.
    #[error("a threshold must be positive, but it is {threshold}; take `median` for one next to 0")]
    NotAThreshold {
        /// The threshold.
        threshold: f64,
    },
    /// All weights are zero.
    #[error("all weights are zero; some element must count")]
    NoWeight,
    /// Elements so far apart that several means, or none, are as good.
    #[error(
        "too dispersed for one mean: element {index} is {reach:.2} of the way to the cut locus, and 0.50 is the bound (rotations: 90°); if some elements are outliers, take `median` or `huber_mean`"
    )]
    TooDispersed {
        /// The element furthest on its way from the centre to where Log jumps.
        index: usize,
        /// How far on that way, from 0 to 1; on rotations θ/π.
        reach: f64,
    },
    /// An iteration did not settle.
    #[error(
        "not settled after {iterations} iterations (last step {step:.1e}); the elements are too far apart"
    )]
    NotConverged {
        /// How many were made.
        iterations: usize,
        /// Length of the last step.
        step: f64,
    },
}
