//! Words of the command line and what they stand for in the library.

use std::path::Path;
use std::str::FromStr;

use boxplus::graph::{GraduatedLoss, Graduation, Kernel};
use boxplus::pose_graph::simulate::Simulator;
use boxplus::pose_graph::solve::{Pairwise, Switches};
use boxplus::pose_graph::{self, ChartKind, Label, NoLabel};
use boxplus::{bundle_adjustment, graph, io};
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
    /// PyFG, .pyfg: ranges; the vertices are the truth
    Pyfg,
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
            (".pyfg", Self::Pyfg),
        ];
        endings.into_iter().find(|(ending, _)| name.ends_with(ending)).map(|(_, format)| format)
    }

    /// The library's word.
    pub fn library(self) -> io::Format {
        match self {
            Self::G2o => io::Format::G2o,
            Self::Toro => io::Format::Toro,
            Self::Isam => io::Format::Isam,
            Self::Pyfg => io::Format::Pyfg,
        }
    }
}

/// The id of a vertex, as a number or as `A0`.
pub fn id(text: &str) -> Result<u64, NoLabel> {
    text.parse().map(|Label(id)| id)
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
    /// The map as it grew, piece by piece, where landmarks close loops
    Grown,
}

impl Init {
    /// The library's word.
    pub fn library(self) -> graph::Initial {
        match self {
            Self::Auto => graph::Initial::Auto,
            Self::File => graph::Initial::AsGiven,
            Self::SpanningTree => graph::Initial::SpanningTree,
            Self::Chordal => graph::Initial::Chordal,
            Self::Grown => graph::Initial::Grown,
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
    /// Whether loop closures have switches.
    pub switches: Option<Switches>,
    /// Whether loop closures must agree with each other.
    pub pairwise: Option<Pairwise>,
    /// The user's word.
    pub text: String,
}

impl Robust {
    /// Whether loop closures are under suspicion.
    pub fn doubts_closures(&self) -> bool {
        self.graduation.is_some() || self.switches.is_some() || self.pairwise.is_some()
    }

    /// A kernel, or what is sought among the loop closures that are left.
    fn one(text: &str) -> Result<Self, String> {
        let none = Self {
            kernel: Kernel::None,
            graduation: None,
            switches: None,
            pairwise: None,
            text: text.to_owned(),
        };
        let (name, number) = text.split_once(':').map_or((text, None), |(name, number)| (name, Some(number)));
        let scale = || match number.map(str::parse::<f64>) {
            None => Ok(None),
            Some(Ok(scale)) if scale > 0.0 && scale.is_finite() => Ok(Some(scale)),
            Some(_) => Err(format!("the scale of {name} must be positive and finite")),
        };
        let graduated = |loss| Ok::<_, String>(Some(Graduation { loss, scale: scale()? }));
        Ok(match name {
            "gnc-tls" => Self { graduation: graduated(GraduatedLoss::TruncatedLeastSquares)?, ..none },
            "gnc-gm" => Self { graduation: graduated(GraduatedLoss::GemanMcClure)?, ..none },
            "switchable" => Self { switches: Some(Switches { scale: scale()? }), ..none },
            "pcm" => Self { pairwise: Some(pairwise(number)?), ..none },
            _ => {
                let wrong = |error| format!("{error}, gnc-tls, gnc-gm, switchable, pcm");
                Self { kernel: text.parse().map_err(wrong)?, ..none }
            }
        })
    }
}

impl FromStr for Robust {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let Some((first, second)) = text.split_once('+') else { return Self::one(text) };
        let (first, second) = (Self::one(first)?, Self::one(second)?);
        if first.pairwise.is_none() || second.kernel != Kernel::None || second.pairwise.is_some() {
            return Err(
                "only pcm can be followed by another, as in pcm+gnc-tls, pcm+gnc-gm or pcm+switchable"
                    .to_owned(),
            );
        }
        Ok(Self { pairwise: first.pairwise, text: text.to_owned(), ..second })
    }
}

/// Reads how sure it must be that two closures disagree.
fn pairwise(confidence: Option<&str>) -> Result<Pairwise, String> {
    let usual = Pairwise::default();
    match confidence.map(str::parse::<f64>) {
        None => Ok(usual),
        Some(Ok(confidence)) if confidence > 0.0 && confidence < 1.0 => Ok(Pairwise { confidence, ..usual }),
        Some(_) => Err("the confidence of pcm must lie between 0 and 1".to_owned()),
    }
}

/// What becomes of an edge whose information matrix is not positive definite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Indefinite {
    /// Refuse the graph, naming such edges
    #[value(alias = "refuse")]
    Reject,
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
            Self::Reject => pose_graph::Indefinite::Refuse,
            Self::Clamp => pose_graph::Indefinite::Clamp,
            Self::Isotropic => pose_graph::Indefinite::Isotropic,
            Self::Skip => pose_graph::Indefinite::Skip,
        }
    }
}

/// What is estimated of the cameras of a bundle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Intrinsics {
    /// Those of every view
    #[default]
    Own,
    /// Those of one camera that took all views
    Shared,
    /// None: they are known
    Known,
}

impl Intrinsics {
    /// For machines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Own => "own",
            Self::Shared => "shared",
            Self::Known => "known",
        }
    }

    /// The library's word.
    pub fn library(self) -> bundle_adjustment::Intrinsics {
        match self {
            Self::Own => bundle_adjustment::Intrinsics::Own,
            Self::Shared => bundle_adjustment::Intrinsics::Shared,
            Self::Known => bundle_adjustment::Intrinsics::Known,
        }
    }
}

/// What becomes of observations of points behind their camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Behind {
    /// They take part by the bare formula, as in Ceres
    Keep,
    /// They are left out, as in GTSAM
    LeaveOut,
}

impl Behind {
    /// The library's word.
    pub fn library(self) -> bundle_adjustment::Behind {
        match self {
            Self::Keep => bundle_adjustment::Behind::Keep,
            Self::LeaveOut => bundle_adjustment::Behind::LeaveOut,
        }
    }
}

/// What covariances are relative to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Gauge {
    /// What is fixed, else one held vertex, whose covariance is zero
    Held,
    /// Nothing: the least covariance that the measurements allow
    Free,
}

/// Takes the names of simulators.
pub fn simulator() -> impl TypedValueParser<Value = Simulator> {
    let names = Simulator::ALL.map(|world| PossibleValue::new(world.name()).help(world.description()));
    PossibleValuesParser::new(names).try_map(|name| name.parse())
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    #[test]
    fn what_is_done_against_outliers_is_read_and_only_pcm_goes_before_another() {
        let read = |text: &str| text.parse::<Robust>();
        let both = read("pcm:0.99+gnc-gm:3").unwrap();
        assert_eq!(both.pairwise.unwrap().confidence, 0.99);
        assert_eq!(both.graduation.unwrap().scale, Some(3.0));
        assert_eq!(both.text, "pcm:0.99+gnc-gm:3");
        assert!(read("pcm+switchable:2").unwrap().switches.is_some());
        assert!(read("switchable").unwrap().doubts_closures() && read("pcm").unwrap().doubts_closures());
        assert!(!read("dcs:1").unwrap().doubts_closures());
        for bad in [
            "gnc-tls+pcm",
            "pcm+pcm",
            "pcm+huber",
            "pcm:1",
            "pcm:0",
            "switchable:-1",
            "pcm+",
            "+pcm",
            "pcm+gnc",
        ] {
            assert!(read(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn the_ending_of_a_name_tells_the_format() {
        let formats = ["a.g2o", "b/A.G2O.gz", "x.graph", "x.toro.gz", "x.isam.txt", "x.txt", "gz", ".gz"];
        let told = formats.map(|name| Format::of(Path::new(name)));
        let [g2o, toro, isam] = [Format::G2o, Format::Toro, Format::Isam].map(Some);
        assert_eq!(told, [g2o, g2o, toro, toro, isam, None, None, None]);
    }
}
