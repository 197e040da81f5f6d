//! Words of the command line and what they stand for in the library.

use std::path::Path;

use boxplus::{graph, io};
use clap::ValueEnum;

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// g2o, .g2o
    G2o,
    /// TORO, .graph or .toro
    Toro,
    /// iSAM, .isam or .isam.txt: measurements only
    Isam,
}

impl Format {
    /// What the ending of a name says, beneath a `.gz`.
    pub fn of(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_string_lossy().to_lowercase();
        let name = name.strip_suffix(".gz").unwrap_or(&name);
        let endings = [
            (".g2o", Self::G2o),
            (".graph", Self::Toro),
            (".toro", Self::Toro),
            (".isam", Self::Isam),
            (".isam.txt", Self::Isam),
        ];
        endings.into_iter().find(|(ending, _)| name.ends_with(ending)).map(|(_, format)| format)
    }

    /// The library's word.
    pub fn library(self) -> io::Format {
        match self {
            Self::G2o => io::Format::G2o,
            Self::Toro => io::Format::Toro,
            Self::Isam => io::Format::Isam,
        }
    }
}

/// How the optimiser moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Algorithm {
    /// Levenberg–Marquardt
    Lm,
    /// Gauss–Newton: fastest near the optimum, no safety net far from it
    Gn,
    /// Powell's dogleg
    Dogleg,
}

impl Algorithm {
    /// The library's word.
    pub fn library(self) -> graph::Algorithm {
        match self {
            Self::Lm => graph::Algorithm::LevenbergMarquardt,
            Self::Gn => graph::Algorithm::GaussNewton,
            Self::Dogleg => graph::Algorithm::Dogleg,
        }
    }
}

/// What is simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Demo {
    Sphere,
    Torus,
    Grid,
    Manhattan,
    Garage,
}

impl Demo {
    pub fn name(self) -> &'static str {
        "sphere"
    }
}
