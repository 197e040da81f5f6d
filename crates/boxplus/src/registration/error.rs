//! Why points do not determine a transform.

use crate::uncertainty::UncertaintyError;
use core::fmt;

/// Which set of points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The points that are moved.
    Source,
    /// The points that stay.
    Target,
    /// A cloud by itself, which may become either.
    Cloud,
}

impl fmt::Display for Role {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Source => "source",
            Self::Target => "target",
            Self::Cloud => "cloud",
        })
    }
}

/// A unit direction of the plane or of space. Printed as `(0.71, −0.71, 0.00)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    coordinates: [f64; 3],
    dimension: usize,
}

impl Axis {
    pub(super) fn new(direction: &[f64]) -> Self {
        let mut coordinates = [0.0; 3];
        coordinates.iter_mut().zip(direction).for_each(|(x, y)| *x = *y);
        // The sign is arbitrary: the largest coordinate is positive.
        let largest = coordinates.iter().fold(0.0, |a: f64, x| if x.abs() > a.abs() { *x } else { a });
        Self { coordinates: coordinates.map(|x| x * largest.signum()), dimension: direction.len().min(3) }
    }

    /// Its two or three coordinates.
    pub fn coordinates(&self) -> &[f64] {
        &self.coordinates[..self.dimension]
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, x) in self.coordinates().iter().enumerate() {
            let start = if place == 0 { "(" } else { ", " };
            let minus = if *x <= -0.005 { "−" } else { "" }; // what rounds to 0 has no sign
            write!(f, "{start}{minus}{:.2}", x.abs())?;
        }
        f.write_str(")")
    }
}

/// Why points do not determine a transform, or its covariance.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RegistrationError {
    /// Pairs are made of equally many points.
    #[error("{source_points} source points for {target_points} target points; each needs its partner")]
    Unpaired {
        /// How many source points there are.
        source_points: usize,
        /// How many target points.
        target_points: usize,
    },
    /// Not one weight per pair.
    #[error("{weights} weights for {pairs} pairs; each needs one")]
    WeightCount {
        /// How many pairs were given.
        pairs: usize,
        /// How many weights.
        weights: usize,
    },
    /// A weight that is negative, NaN or infinite.
    #[error("a weight must be finite and at least 0, but that of pair {index} is {weight}")]
    NotAWeight {
        /// The pair, from 0.
        index: usize,
        /// Its weight.
        weight: f64,
    },
    /// A coordinate is NaN, infinite or so large that its square is.
    #[error("{role} point {index} has a coordinate that is NaN, infinite or beyond 1e100")]
    NotFinite {
        /// Which set it belongs to.
        role: Role,
        /// The point, from 0.
        index: usize,
    },
    /// Fewer points than the transform has freedom for.
    #[error("{given} pairs with a weight, at least {needed} are needed to fix a rotation")]
    TooFewPairs {
        /// How many have a weight above 0.
        given: usize,
        /// How many are needed: 2 in the plane, 3 in space.
        needed: usize,
    },
    /// All points of one set are one point.
    #[error("all {role} points coincide: every rotation about that point fits equally well")]
    Coincident {
        /// Which set.
        role: Role,
    },
    /// All points of one set lie on one line, in space.
    #[error("the {role} points lie on a line: the rotation about its axis {axis} is free")]
    Collinear {
        /// Which set.
        role: Role,
        /// The direction of the line, in the frame of that set.
        axis: Axis,
    },
    /// Several rotations fit equally well, because the sets are mirror images of each other, or unrelated.
    #[error(
        "the rotation about {axis} of the target is free: the sets match a reflection as well as any rotation; is an axis flipped?"
    )]
    Ambiguous {
        /// The axis in the frame of the target; in the plane, that across it, (0, 0, 1).
        axis: Axis,
    },
    /// No redundancy, from which the noise could be estimated.
    #[error("{pairs} pairs fit exactly, whatever their noise; state it, or give more pairs")]
    NoRedundancy {
        /// How many pairs have a weight.
        pairs: usize,
    },
    /// A standard deviation that is not positive.
    #[error("a standard deviation must be finite and positive, not {sigma}")]
    NotASigma {
        /// What was given.
        sigma: f64,
    },
    /// Not one covariance per pair.
    #[error("{covariances} covariances for {pairs} pairs; each needs one")]
    CovarianceCount {
        /// How many pairs were given.
        pairs: usize,
        /// How many covariances.
        covariances: usize,
    },
    /// A cloud without points.
    #[error("a cloud without points")]
    Empty,
    /// More points than are told apart.
    #[error("{points} points; at most 2³² − 1 are taken, thin them first")]
    TooMany {
        /// How many were given.
        points: usize,
    },
    /// A grid that cannot be.
    #[error(
        "cubes of edge {size} for a cloud of extent {extent}: the edge must be positive, and not a millionth of the extent"
    )]
    VoxelSize {
        /// Edge of a cube.
        size: f64,
        /// Largest extent of the cloud along an axis.
        extent: f64,
    },
    /// An option of the alignment without sense.
    #[error("{option} must be finite and positive, not {value}")]
    NotAnOption {
        /// Which option.
        option: &'static str,
        /// What was given.
        value: f64,
    },
    /// A start with numbers that are NaN, infinite or beyond 1e100.
    #[error("the start has a number that is NaN, infinite or beyond 1e100")]
    InitialNotFinite,
    /// A robust kernel whose scale is not positive.
    #[error("the scale of a robust kernel must be finite and positive")]
    NotAKernel,
    /// Almost no point has a partner.
    #[error(
        "{matches} points have a partner within {max_distance}, {needed} are needed: the clouds do not overlap there; start closer, or look farther"
    )]
    NoOverlap {
        /// How many points have one.
        matches: usize,
        /// How many are needed.
        needed: usize,
        /// How far away a partner may be.
        max_distance: f64,
    },
    /// The method needs normals, and a scan has none.
    #[error(
        "the {role} scan has no normals, and the method needs them; prepare it with neighbours ≥ 3, or take point to point"
    )]
    NoNormals {
        /// Which scan.
        role: Role,
    },
    /// A transform without covariance: the scans say nothing along some directions.
    #[error(
        "the scans say nothing about {directions} direction(s), whose variance would be infinite; see `free`"
    )]
    Unconstrained {
        /// How many directions are free.
        directions: usize,
    },
    /// A covariance does not exist.
    #[error(transparent)]
    Uncertainty(#[from] UncertaintyError),
}
