//! Words of the command line and what they stand for in the library.

use std::path::Path;
use std::str::FromStr;

use boxplus::graph::{GraduatedLoss, Graduation, Kernel};
use boxplus::pose_graph::simulate::Simulator;
use boxplus::pose_graph::{self, ChartKind};
use boxplus::{graph, io};
use clap::ValueEnum;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

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
    /// For machines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lm => "levenberg_marquardt",
            Self::Gn => "gauss_newton",
            Self::Dogleg => "dogleg",
        }
    }

    /// The library's word.
    pub fn library(self) -> graph::Algorithm {
        match self {
            Self::Lm => graph::Algorithm::LevenbergMarquardt,
            Self::Gn => graph::Algorithm::GaussNewton,
            Self::Dogleg => graph::Algorithm::Dogleg,
        }
    }
}

/// Where the optimiser starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Init {
    /// Whatever costs least
    Auto,
    /// The vertices of the file
    File,
    /// Measurements chained along a spanning tree
    SpanningTree,
    /// Rotations by relaxation to matrices, then positions, both linear
    Chordal,
}

impl Init {
    /// The library's word.
    pub fn library(self) -> graph::Initial {
        match self {
            Self::Auto => graph::Initial::Auto,
            Self::File => graph::Initial::AsGiven,
            Self::SpanningTree => graph::Initial::SpanningTree,
            Self::Chordal => graph::Initial::Chordal,
        }
    }
}

/// What is minimised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Chart {
    /// ½ Σ eᵀΩe, e = Log(Z⁻¹Xᵢ⁻¹Xⱼ), as GTSAM
    Log,
    /// Σ eᵀΩe, e = translation and vector part of the quaternion, as g2o
    G2o,
    /// ½ Σ eᵀΩe of the pose-graph example of Ceres
    Ceres,
    /// Squared distances of rotation matrices and positions, as SE-Sync
    SeSync,
}

impl Chart {
    /// The library's word.
    pub fn library(self) -> ChartKind {
        match self {
            Self::Log => ChartKind::Log,
            Self::G2o => ChartKind::G2o,
            Self::Ceres => ChartKind::Ceres,
            Self::SeSync => ChartKind::SeSync,
        }
    }
}

/// What is done against outliers, and how the user wrote it.
#[derive(Clone, Debug)]
pub struct Robust {
    /// The kernel of every measurement.
    pub kernel: Kernel,
    /// How false loop closures are sought.
    pub graduation: Option<Graduation>,
    /// The user's word.
    pub text: String,
}

impl FromStr for Robust {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, scale) = text.split_once(':').map_or((text, None), |(name, scale)| (name, Some(scale)));
        let losses =
            [("gnc-tls", GraduatedLoss::TruncatedLeastSquares), ("gnc-gm", GraduatedLoss::GemanMcClure)];
        let Some((_, loss)) = losses.into_iter().find(|(known, _)| *known == name) else {
            let kernel = text.parse().map_err(|error| format!("{error}, gnc-tls, gnc-gm"))?;
            return Ok(Self { kernel, graduation: None, text: text.to_owned() });
        };
        let scale = match scale.map(str::parse::<f64>) {
            None => None,
            Some(Ok(scale)) if scale > 0.0 && scale.is_finite() => Some(scale),
            Some(_) => return Err(format!("the scale of {name} must be positive and finite")),
        };
        let graduation = Some(Graduation { loss, scale });
        Ok(Self { kernel: Kernel::None, graduation, text: text.to_owned() })
    }
}

/// What becomes of an edge whose information matrix is not positive definite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Indefinite {
    /// Refuse the graph, naming such edges
    Refuse,
    /// Raise the eigenvalues until it is
    Clamp,
    /// Weigh all directions of the translation alike, and all of the rotation
    Isotropic,
    /// Leave the edge out
    Skip,
}

impl Indefinite {
    /// The library's word.
    pub fn library(self) -> pose_graph::Indefinite {
        match self {
            Self::Refuse => pose_graph::Indefinite::Refuse,
            Self::Clamp => pose_graph::Indefinite::Clamp,
            Self::Isotropic => pose_graph::Indefinite::Isotropic,
            Self::Skip => pose_graph::Indefinite::Skip,
        }
    }
}

/// Takes the names of simulators.
pub fn simulator() -> impl TypedValueParser<Value = Simulator> {
    let names = Simulator::ALL.map(|world| PossibleValue::new(world.name()).help(world.description()));
    PossibleValuesParser::new(names).try_map(|name| name.parse())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ending_of_a_name_tells_the_format() {
        let formats = ["a.g2o", "b/A.G2O.gz", "x.graph", "x.toro.gz", "x.isam.txt", "x.txt", "gz", ".gz"];
        let told = formats.map(|name| Format::of(Path::new(name)));
        let [g2o, toro, isam] = [Format::G2o, Format::Toro, Format::Isam].map(Some);
        assert_eq!(told, [g2o, g2o, toro, toro, isam, None, None, None]);
    }
}
