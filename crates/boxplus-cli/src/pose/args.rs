//! The arguments of `boxplus pose`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum, ValueHint};
use serde::{Deserialize, Serialize};

pub const EXAMPLES: &str = "\
Examples:
  boxplus pose compose 'position = [1, 0], yaw_deg = 30, sigmas = [0.1, 0.1, 0.02]' 'position = [2, 0], yaw = 0'
  boxplus pose relate robot dock -f poses.toml             where the dock is, seen from the robot
  boxplus pose fuse gps odometry -f poses.toml --json      the estimate that fits both
  boxplus pose show lidar -f poses.toml --to gtsam         the same pose in another library's convention
  boxplus pose act robot 'position = [3, 1, 0]' -f poses.toml
  boxplus pose compose a b -f poses.toml | boxplus pose invert result -f -

A pose is the name of one in a file, or is written in place as in the file, between quotes:
  [pose.robot]                                 # any name; JSON of the same shape will do, too
  position = [1.0, 2.0, 0.5]                   # metres; two numbers in the plane
  yaw_pitch_roll_deg = [30, 0, 0]              # or quaternion_xyzw, quaternion_wxyz, rotation_vector, matrix; in
                                               # the plane yaw; in radians without _deg
  sigmas = [0.1, 0.1, 0.2, 0.01, 0.01, 0.03]   # or covariance, or information; of none, the pose is certain
  convention = 'gtsam'                         # of these numbers; side = 'local' or 'global'
  [[correlation]]                              # E[error of the first, error of the second]
  of = ['robot', 'dock']
  covariance = [[0.01, 0, 0], [0, 0.01, 0], [0, 0, 0.001]]
What is printed is such a file.";

/// Options of `pose`.
#[derive(Args, Debug)]
pub struct Pose {
    #[command(subcommand)]
    pub operation: Operation,
}

/// What to compute.
#[derive(Debug, Subcommand)]
pub enum Operation {
    /// The product of a chain of poses: a_from_b · b_from_c = a_from_c.
    Compose {
        /// From left to right.
        #[arg(required = true, num_args = 2.., value_name = "POSE")]
        poses: Vec<String>,
        #[command(flatten)]
        options: Options,
        #[command(flatten)]
        order: Powers,
    },
    /// The inverse: b_from_a of a_from_b.
    Invert {
        #[arg(value_name = "POSE")]
        pose: String,
        #[command(flatten)]
        options: Options,
    },
    /// The second pose seen from the first: inverse(FIRST) · SECOND.
    Relate {
        #[arg(value_name = "FIRST")]
        first: String,
        #[arg(value_name = "SECOND")]
        second: String,
        #[command(flatten)]
        options: Options,
        #[command(flatten)]
        order: Powers,
    },
    /// The pose that fits several estimates of it.
    Fuse {
        /// Estimates of one pose.
        #[arg(required = true, num_args = 2.., value_name = "POSE")]
        poses: Vec<String>,
        /// Of two estimates whose errors may be correlated in an unknown way: covariance intersection.
        #[arg(long)]
        unknown_correlation: bool,
        #[command(flatten)]
        options: Options,
    },
    /// Where a pose takes a point.
    Act {
        #[arg(value_name = "POSE")]
        pose: String,
        /// A pose without rotation: `position = […]`, and `sigmas`, `covariance` or `information` if it is uncertain.
        #[arg(value_name = "POINT")]
        point: String,
        #[command(flatten)]
        options: Options,
        #[command(flatten)]
        order: Powers,
    },
    /// The covariance after the mean moves: three operations that are taken for one another.
    Move {
        #[arg(value_name = "POSE")]
        pose: String,
        /// By how much: a displacement, applied on the side of --side; its covariance is not used.
        #[arg(value_name = "DISPLACEMENT")]
        by: String,
        /// What the move means.
        #[arg(long = "as", value_name = "MEANING")]
        meaning: Meaning,
        #[command(flatten)]
        options: Options,
    },
    /// The pose itself, in another convention.
    Show {
        #[arg(value_name = "POSE")]
        pose: String,
        #[command(flatten)]
        options: Options,
    },
}

/// Options of every operation.
#[derive(Args, Clone, Debug)]
pub struct Options {
    /// A file with poses, TOML or JSON; may be given again, `-` is standard input.
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub file: Vec<PathBuf>,
    /// Convention of the covariances given, where a pose does not say its own.
    #[arg(long, value_name = "CONVENTION", default_value = "boxplus")]
    pub from: Convention,
    /// Convention of the covariance printed.
    #[arg(long, value_name = "CONVENTION", default_value = "boxplus")]
    pub to: Convention,
    /// Side of the covariance printed: errors in the frame of the body, or of the parent.
    #[arg(long, value_name = "SIDE")]
    pub side: Option<SideName>,
    /// How the rotation is printed, in space.
    #[arg(long, value_name = "FORM", default_value = "xyzw")]
    pub rotation: RotationForm,
}

/// How many powers of the errors are kept.
#[derive(Args, Clone, Copy, Debug)]
pub struct Powers {
    /// Up to which power of the errors moments are kept: first is JΣJᵀ alone, second adds the shift of the mean, fourth the next
    /// terms of both.
    #[arg(long, value_name = "ORDER", default_value = "fourth")]
    pub order: OrderName,
}

/// See [`boxplus::uncertainty::Order`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum OrderName {
    First,
    Second,
    Fourth,
}

/// Which side of the mean an error stands on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SideName {
    /// X = mean · Exp(error)
    Local,
    /// X = Exp(error) · mean
    Global,
}

/// What the rows of a covariance are, and in whose frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Convention {
    /// (ρ, φ): translation, rotation; local unless said
    Boxplus,
    /// (φ, ρ) in space, (x, y, θ) in the plane; local
    Gtsam,
    /// (ρ, φ); local
    Manif,
    /// (ρ, φ); local unless said
    Sophus,
    /// (ρ, φ); global
    Lgmath,
    /// (φ, ρ), of invariant filters, in space; local (left-invariant) unless said
    Barrau,
    /// position and rotation about the axes of the parent, as in PoseWithCovariance
    Ros,
    /// (x, y, z, yaw, pitch, roll), (x, y, yaw): the coordinates themselves
    Ypr,
    /// (x, y, z, roll, pitch, yaw): the coordinates themselves
    Rpy,
}

/// How a rotation in space is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RotationForm {
    /// quaternion_xyzw
    Xyzw,
    /// quaternion_wxyz
    Wxyz,
    /// yaw_pitch_roll, radians
    Ypr,
    /// rotation_vector, radians
    Vector,
    /// matrix, by rows
    Matrix,
}

/// What the move of a mean means.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Meaning {
    /// A correction: the error is found to have this mean (Σ ← JΣJᵀ)
    Correction,
    /// Another point of the same body, fixed to it (Σ ← Ad⁻¹ Σ Ad⁻ᵀ on the local side)
    Body,
    /// Another origin of the parent frame: the displacement comes before the pose
    Parent,
    /// Parallel transport: where the axes of the ellipsoid go
    Transport,
}

impl Operation {
    /// Its options.
    pub fn options(&self) -> &Options {
        match self {
            Self::Compose { options, .. }
            | Self::Invert { options, .. }
            | Self::Relate { options, .. }
            | Self::Fuse { options, .. }
            | Self::Act { options, .. }
            | Self::Move { options, .. }
            | Self::Show { options, .. } => options,
        }
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Compose { .. } => "compose",
            Self::Invert { .. } => "invert",
            Self::Relate { .. } => "relate",
            Self::Fuse { .. } => "fuse",
            Self::Act { .. } => "act",
            Self::Move { .. } => "move",
            Self::Show { .. } => "show",
        }
    }

    /// The poses as the user names them, in order.
    pub fn operands(&self) -> Vec<&str> {
        match self {
            Self::Compose { poses, .. } | Self::Fuse { poses, .. } => {
                poses.iter().map(String::as_str).collect()
            }
            Self::Invert { pose, .. } | Self::Show { pose, .. } => vec![pose],
            Self::Relate { first, second, .. } => vec![first, second],
            Self::Act { pose, point, .. } => vec![pose, point],
            Self::Move { pose, by, .. } => vec![pose, by],
        }
    }

    /// Up to which power moments are kept, where that is a question.
    pub fn order(&self) -> Option<OrderName> {
        match self {
            Self::Compose { order, .. } | Self::Relate { order, .. } | Self::Act { order, .. } => {
                Some(order.order)
            }
            Self::Invert { .. } | Self::Fuse { .. } | Self::Move { .. } | Self::Show { .. } => None,
        }
    }
}
