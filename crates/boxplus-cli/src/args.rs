//! The command line as data.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use boxplus::graph::SolveOptions;
use boxplus::io::cloud::CloudFormat;
use boxplus::pose_graph::simulate::Simulator;
use boxplus::registration::{Kernel, Method as Alignment};
use clap::{Args, Parser, Subcommand, ValueHint};
use clap_complete::Shell;

use crate::choices::{
    Algorithm, Behind, Chart, Format, Gauge, Indefinite, Init, Intrinsics, Robust, id, simulator,
};
use crate::consistency::{self, Consistency};
use crate::filter;
use crate::pose;
use crate::pose::args::Pose;

const EXAMPLES: &str = "\
Examples:
  boxplus solve demo:sphere --plot sphere.svg      solve a simulated graph and draw it
  boxplus solve map.g2o -o solved.g2o              solve a file and save the result
  boxplus info map.g2o                             what is in it, and what is wrong with it
  boxplus convert map.g2o map.graph                from g2o to TORO
  boxplus align scan.ply map.ply --voxel 0.25      lay one point cloud upon another

Exit codes: 0 done; 1 output cannot be written; 2 usage; 3 unreadable or malformed input;
4 the data do not determine an answer; 5 not converged; 130 interrupted.";

/// State estimation on Lie groups: solve, inspect, convert, simulate and draw pose graphs.
#[derive(Debug, Parser)]
#[command(name = "boxplus", version, propagate_version = true, arg_required_else_help = true, after_help = EXAMPLES)]
pub struct Cli {
    #[command(flatten)]
    pub global: Global,
    #[command(subcommand)]
    pub verb: Verb,
}

/// Options of every verb.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Global options")]
pub struct Global {
    /// Print one JSON document on standard output, all else on standard error.
    #[arg(long, global = true)]
    pub json: bool,
    /// Print nothing but errors.
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// Print details.
    #[arg(short, long, global = true, conflicts_with = "quiet")]
    pub verbose: bool,
    /// Threads; one per core unless given. No digit of a result depends on it.
    #[arg(long, global = true, value_name = "N", env = "BOXPLUS_THREADS")]
    pub threads: Option<NonZeroUsize>,
    /// Seed of what is simulated.
    #[arg(long, global = true, value_name = "N", env = "BOXPLUS_SEED")]
    pub seed: Option<u64>,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Find the most likely poses of a graph, or cameras and points of a bundle.
    #[command(after_help = SOLVE_EXAMPLES)]
    Solve(Box<Solve>),
    /// Say what is in a file, and what is wrong with it.
    #[command(after_help = INFO_EXAMPLES)]
    Info(Info),
    /// Say what the measurements leave open, and which of them disagree.
    #[command(after_help = DIAGNOSE_EXAMPLES)]
    Diagnose(Diagnose),
    /// Translate a file to another format.
    #[command(after_help = CONVERT_EXAMPLES)]
    Convert(Convert),
    /// Make a graph whose true poses are known.
    #[command(after_help = SIMULATE_EXAMPLES)]
    Simulate(Simulate),
    /// Draw a graph as it is in the file.
    #[command(after_help = PLOT_EXAMPLES)]
    Plot(Plot),
    /// Calculate with uncertain poses: compose, invert, relate, fuse.
    #[command(after_help = pose::args::EXAMPLES)]
    Pose(Box<Pose>),
    /// Follow what moves through the logs of its sensors.
    #[command(after_help = filter::EXAMPLES)]
    Filter(Box<filter::Options>),
    /// Try a filter on a simulation many times: can its covariance be believed?
    #[command(after_help = consistency::EXAMPLES)]
    Consistency(Consistency),
    /// Lay one point cloud upon another: the motion, its covariance, and what the clouds do not say.
    #[command(after_help = ALIGN_EXAMPLES)]
    Align(Box<Align>),
    /// Print the completions of a shell.
    #[command(after_help = COMPLETIONS_EXAMPLES)]
    Completions(Completions),
}

const SOLVE_EXAMPLES: &str = "\
Examples:
  boxplus solve demo:sphere --size 900 --noise 2 --seed 7 --plot sphere.png
  boxplus solve map.g2o -o solved.g2o --json > report.json
  boxplus solve map.g2o --robust cauchy:1 --init chordal
  boxplus solve map.g2o --robust gnc-tls --json | jq .rejected_closures
  boxplus solve map.g2o --robust pcm+gnc-tls
  boxplus solve map.g2o --certify
  gzip -dc map.g2o.gz | boxplus solve - -o - > solved.g2o
  boxplus solve problem-49-7776-pre.txt.bz2 -o adjusted.ply --plot adjusted.svg --robust huber:2
  boxplus solve demo:city --size 200 -o colmap/

The cost is ½ Σ eᵀΩe, and --chart says what e is: the full logarithm on the group (log), or what g2o, Ceres' pose-graph
example and SE-Sync minimise. All four are printed at the result. Ctrl-C stops after the iteration under way and keeps
the best poses so far; a second one aborts.

Files of Bundle Adjustment in the Large (known by their content, plain, gzip or bzip2) are adjusted: -o takes .bal or .txt, .ply, or a
folder for COLMAP's text files; --fix and --robust count views and pixels.";

/// Options of `solve`.
#[derive(Args, Debug)]
pub struct Solve {
    #[command(flatten)]
    pub input: Input,
    /// Write the solved graph here; the ending says the format, `-` is standard output.
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub output: Option<PathBuf>,
    /// Format of --output, where its name does not say.
    #[arg(long, value_name = "FORMAT", requires = "output")]
    pub to: Option<Format>,
    /// Draw the graph before and after, as .svg or .png.
    #[arg(long, value_name = "PICTURE", value_hint = ValueHint::FilePath)]
    pub plot: Option<PathBuf>,
    /// Draw 95 % ellipses of the positions, too: relative to what is held, or to nothing (free), where nothing is fixed.
    #[arg(long, requires = "plot", value_name = "GAUGE", num_args = 0..=1, require_equals = true, default_missing_value = "held")]
    pub covariance: Option<Gauge>,
    #[command(flatten)]
    pub method: Method,
}

/// How `solve` solves.
#[derive(Args, Debug)]
#[command(next_help_heading = "Method")]
pub struct Method {
    /// How the optimiser moves.
    #[arg(long, value_name = "NAME", default_value = "lm")]
    pub algorithm: Algorithm,
    /// Where it starts.
    #[arg(long, value_name = "NAME", default_value = "auto")]
    pub init: Init,
    /// What the residual of an edge is.
    #[arg(long, value_name = "NAME", default_value = "log")]
    pub chart: Chart,
    /// Robust kernel against outliers, its scale in standard deviations: huber, pseudo-huber, cauchy, geman-mcclure,
    /// welsch, tukey, fair, dcs, truncated, barron. Or find and leave out false loop closures, odometry trusted, by graduated
    /// non-convexity (gnc-tls, gnc-gm) or switches (switchable); without scale one true closure in a hundred is given up. Or use
    /// only the largest set of closures of which every two agree (pcm:CONFIDENCE), also before another: pcm+gnc-tls.
    #[arg(long, value_name = "NAME[:SCALE]")]
    pub robust: Option<Robust>,
    /// Hold a vertex where it is; may be given again.
    #[arg(long, value_name = "ID", value_parser = id)]
    pub fix: Vec<u64>,
    /// Prove that no other estimate is better, or go on to one that is. For graphs of poses alone; the proof is about
    /// SE-Sync's cost, near whose optimum those of the other charts lie.
    #[arg(long, conflicts_with = "robust")]
    pub certify: bool,
    /// Edges whose information matrix is not positive definite.
    #[arg(long, value_name = "POLICY", default_value = "reject", alias = "indefinite")]
    pub information: Indefinite,
    /// Of bundles: what is estimated of the cameras; own unless given.
    #[arg(long, value_name = "WHICH")]
    pub intrinsics: Option<Intrinsics>,
    /// Of bundles: observations of points behind their camera; keep unless given.
    #[arg(long, value_name = "POLICY")]
    pub behind: Option<Behind>,
    /// Stop after so many steps.
    #[arg(long, value_name = "N")]
    pub max_iterations: Option<usize>,
    /// Stop when a step lowers the cost by less than this part of it.
    #[arg(long, value_name = "X", value_parser = tolerance)]
    pub relative_cost: Option<f64>,
    /// Stop when the gradient is below this, in standard deviations.
    #[arg(long, value_name = "X", value_parser = tolerance)]
    pub gradient: Option<f64>,
    /// Stop when the step is below this, in standard deviations.
    #[arg(long, value_name = "X", value_parser = tolerance)]
    pub step: Option<f64>,
}

impl Method {
    /// How to move and when to stop: what was given, else what is usual.
    pub fn options(&self, usual: &SolveOptions, global: &Global) -> SolveOptions {
        SolveOptions {
            algorithm: self.algorithm.library(),
            max_iterations: self.max_iterations.unwrap_or(usual.max_iterations),
            relative_cost: self.relative_cost.unwrap_or(usual.relative_cost),
            gradient: self.gradient.unwrap_or(usual.gradient),
            step: self.step.unwrap_or(usual.step),
            threads: global.threads.map_or(usual.threads, usize::from),
            ..usual.clone()
        }
    }
}

const INFO_EXAMPLES: &str = "\
Examples:
  boxplus info map.g2o
  boxplus info map.g2o.gz --json | jq .loop_closures";

/// Options of `info`.
#[derive(Args, Debug)]
pub struct Info {
    #[command(flatten)]
    pub input: Input,
}

const DIAGNOSE_EXAMPLES: &str = "\
Examples:
  boxplus diagnose map.g2o
  boxplus diagnose demo:manhattan --outliers 0.1
  boxplus diagnose map.g2o --json | jq .fit.contradicting

Exit code 4 where the measurements do not determine an answer.";

/// Options of `diagnose`.
#[derive(Args, Debug)]
pub struct Diagnose {
    #[command(flatten)]
    pub input: Input,
}

const CONVERT_EXAMPLES: &str = "\
Examples:
  boxplus convert map.g2o map.graph
  boxplus convert map.g2o map.g2o.gz
  boxplus convert - solved.g2o --from toro < map.txt";

/// Options of `convert`.
#[derive(Args, Debug)]
pub struct Convert {
    #[command(flatten)]
    pub input: Input,
    /// Where to write; `-` is standard output, an ending in .gz packs.
    #[arg(value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
    /// Format of OUT, where its name does not say.
    #[arg(long, value_name = "FORMAT")]
    pub to: Option<Format>,
}

const SIMULATE_EXAMPLES: &str = "\
Examples:
  boxplus simulate sphere -o sphere.g2o --truth truth.g2o
  boxplus simulate grid --size 8000 --noise 0.5 --seed 7 -o grid.g2o";

/// Options of `simulate`.
#[derive(Args, Debug)]
pub struct Simulate {
    /// What to simulate.
    #[arg(value_name = "NAME", value_parser = simulator())]
    pub name: Simulator,
    #[command(flatten)]
    pub world: World,
    /// Write the graph here, as a robot would have measured it; `-` is standard output.
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
    /// Write the true poses here, too.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub truth: Option<PathBuf>,
    /// Format of the files, where their names do not say.
    #[arg(long, value_name = "FORMAT")]
    pub to: Option<Format>,
}

const PLOT_EXAMPLES: &str = "\
Examples:
  boxplus plot map.g2o -o map.svg
  boxplus plot demo:torus -o torus.png";

/// Options of `plot`.
#[derive(Args, Debug)]
pub struct Plot {
    #[command(flatten)]
    pub input: Input,
    /// The picture, .svg or .png.
    #[arg(short, long, value_name = "PICTURE", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
}

const ALIGN_EXAMPLES: &str = "\
Examples:
  boxplus align scan.ply map.pcd --voxel 0.25 --plot aligned.svg
  boxplus align 000001.bin 000000.bin --voxel 0.3 --init '2.8 1.6 0 0 0 0 1' -o moved.ply
  boxplus align scan.csv room.csv --method plane --robust cauchy:1
  boxplus align scan.ply map.ply --json | jq .target_from_source.matrix

PLY, PCD, XYZ, CSV and KITTI's .bin are read, plain or gzip; two columns are a cloud of the plane. The covariance is that of
the local tangent: errors along and about the axes of the source. Exit code 4 where the clouds do not meet, or leave a
direction open, as a corridor does.";

/// Options of `align`.
#[derive(Args, Debug)]
pub struct Align {
    /// The cloud that is moved; `-` is standard input.
    #[arg(value_name = "SOURCE", value_hint = ValueHint::FilePath)]
    pub source: PathBuf,
    /// The cloud that stays.
    #[arg(value_name = "TARGET", value_hint = ValueHint::FilePath)]
    pub target: PathBuf,
    /// Format of both clouds, where name and content do not say: ply, pcd, text, kitti.
    #[arg(long, value_name = "FORMAT")]
    pub from: Option<CloudFormat>,
    /// Write the moved source here, as PLY; `-` is standard output.
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub output: Option<PathBuf>,
    /// Draw both from above, before and after, as .svg or .png.
    #[arg(long, value_name = "PICTURE", value_hint = ValueHint::FilePath)]
    pub plot: Option<PathBuf>,
    /// Distances of points (point), from the planes of the target (plane), or weighed by the planes of both (generalised).
    #[arg(long, value_name = "NAME", default_value = "generalised")]
    pub method: Alignment,
    /// Average the points in cubes of this edge, in the units of the cloud; 0 keeps all.
    #[arg(long, value_name = "SIZE", value_parser = tolerance, default_value = "0")]
    pub voxel: f64,
    /// Partners are no farther apart than this; four voxels unless given, or ten times the distance of neighbours.
    #[arg(long, value_name = "X", value_parser = tolerance)]
    pub max_distance: Option<f64>,
    /// Neighbours that make the normal at a point.
    #[arg(long, value_name = "N", default_value_t = 10)]
    pub neighbours: usize,
    /// Robust kernel against what has moved, its scale in standard deviations.
    #[arg(long, value_name = "NAME[:SCALE]")]
    pub robust: Option<Kernel>,
    /// Where the source starts: identity, centroids, numbers, or a file with them. In space x y z qx qy qz qw, x y z and a rotation
    /// vector, or a 3×4 or 4×4 matrix by rows; in the plane x y angle, or a 3×3 matrix.
    #[arg(long, value_name = "START", allow_hyphen_values = true)]
    pub init: Option<String>,
    /// Leave z aside, and align in the plane.
    #[arg(long)]
    pub planar: bool,
    /// Stop after so many steps.
    #[arg(long, value_name = "N", default_value_t = 50)]
    pub max_iterations: usize,
}

const COMPLETIONS_EXAMPLES: &str = "\
Examples:
  boxplus completions bash > ~/.local/share/bash-completion/completions/boxplus
  boxplus completions zsh > ~/.zfunc/_boxplus
  boxplus completions fish > ~/.config/fish/completions/boxplus.fish";

/// Options of `completions`.
#[derive(Args, Debug)]
pub struct Completions {
    /// Whose completions.
    #[arg(value_name = "SHELL")]
    pub shell: Shell,
}

/// Where a graph comes from.
#[derive(Args, Debug)]
pub struct Input {
    /// A file (plain or packed), `-` for standard input, or `demo:NAME` for a simulated graph: sphere, torus, grid,
    /// manhattan, garage, landmarks; to solve also a bundle: ring, street, city.
    #[arg(value_name = "INPUT", value_hint = ValueHint::FilePath)]
    pub source: PathBuf,
    /// Format of the input, where its name and content do not say.
    #[arg(long, value_name = "FORMAT")]
    pub from: Option<Format>,
    #[command(flatten)]
    pub world: World,
}

const SIMULATED: &str = "Simulated graphs";

/// The size of a simulated world.
#[derive(Args, Clone, Copy, Debug, Default, PartialEq)]
pub struct World {
    /// Number of poses, or of views.
    #[arg(long, value_name = "N", help_heading = SIMULATED)]
    pub size: Option<usize>,
    /// Noise of its measurements as a multiple of the usual; 0 is none.
    #[arg(long, value_name = "X", value_parser = tolerance, help_heading = SIMULATED)]
    pub noise: Option<f64>,
    /// The chance that a loop closure is of another place than it says.
    #[arg(long, value_name = "P", value_parser = tolerance, help_heading = SIMULATED)]
    pub outliers: Option<f64>,
}

/// A number that is finite and not negative.
fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x >= 0.0 && x.is_finite() => Ok(x),
        Ok(_) => Err("must be zero or more, and finite".to_owned()),
        Err(_) => Err("is not a number".to_owned()),
    }
}
