//! The optimum of a pose graph, and how good it is.
//!
//! ```
//! use boxplus::pose_graph::SolveSettings;
//! use boxplus::pose_graph::simulate::{Options, Simulator};
//! use boxplus::pose_graph::solve::solve;
//! let world = Simulator::Manhattan.simulate(&Options { size: Some(400), ..Options::default() })?;
//! let solved = solve(&world.graph, &SolveSettings::default())?;
//! assert!(solved.report.converged());
//! assert!(solved.cost < solved.initial_cost);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod closures;
mod costs;
mod indefinite;
mod keys;
pub(in crate::pose_graph) mod problem;
mod uncertainty;

use core::fmt;
use core::ops::ControlFlow;
use core::str::FromStr;

pub use closures::{Pairwise, Selection, Switches};
pub use costs::Costs;
pub use indefinite::Indefinite;
pub(in crate::pose_graph) use indefinite::usable_information;
pub(in crate::pose_graph) use problem::faults;
pub use uncertainty::PositionCovariance;

use super::constraint::{Constraint, Kind};
use super::{Fault, Label, Line, PoseGraph};
use crate::graph::{
    self, Clock, Graduation, GraphError, Growth, Initial, Iteration, Kernel, SolveOptions, SolveReport,
    Unconstrained,
};
use problem::{Problem, with_values};

/// How the residual of a relative pose is written, and so what is minimised.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ChartKind {
    /// ½ Σ eᵀΩe with e = Log(Z⁻¹Xᵢ⁻¹Xⱼ): what boxplus and GTSAM minimise.
    #[default]
    Log,
    /// χ² = Σ eᵀΩe with e = (t, vec q) of Z⁻¹Xᵢ⁻¹Xⱼ (2-D: (t, θ)): what g2o minimises.
    G2o,
    /// ½ Σ eᵀΩe with e = (Rᵢᵀ(tⱼ − tᵢ) − t, 2·vec(q_Z·q⁻¹)) (2-D: (…, θ)): what the pose-graph example of Ceres minimises.
    Ceres,
    /// Σ τ‖tⱼ − tᵢ − Rᵢt̃‖² + κ‖Rⱼ − RᵢR̃‖² with isotropic weights: what SE-Sync minimises.
    SeSync,
}

impl ChartKind {
    /// Every chart.
    pub const ALL: [Self; 4] = [Self::Log, Self::G2o, Self::Ceres, Self::SeSync];

    /// Its name, as [`FromStr`] takes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Log => "log",
            Self::G2o => "g2o",
            Self::Ceres => "ceres",
            Self::SeSync => "se-sync",
        }
    }

    /// The objective of this chart's tool as a multiple of ½ Σ eᵀΩe.
    pub fn factor(self) -> f64 {
        match self {
            Self::Log | Self::Ceres => 1.0,
            Self::G2o | Self::SeSync => 2.0,
        }
    }
}

impl fmt::Display for ChartKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is none of [`ChartKind::ALL`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not a chart; choose log, g2o, ceres or se-sync")]
pub struct UnknownChart;

impl FromStr for ChartKind {
    type Err = UnknownChart;

    fn from_str(name: &str) -> Result<Self, UnknownChart> {
        Self::ALL.into_iter().find(|chart| chart.name() == name).ok_or(UnknownChart)
    }
}

/// How a pose graph is solved.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SolveSettings {
    /// What is minimised.
    pub chart: ChartKind,
    /// Where to start.
    pub initial: Initial,
    /// How much a large residual may pull.
    pub kernel: Kernel,
    /// Whether to look for false loop closures ([`PoseGraph::loop_closures`]), and how: graduated non-convexity, in which
    /// [`SolveSettings::kernel`] bounds all other measurements. With [`Initial::Auto`] the map is first grown from odometry, piece by
    /// piece, each closure held against the drift since the map was last closed; from any other start the schedule is the
    /// published one.
    pub graduation: Option<Graduation>,
    /// Whether every loop closure has a switch, which may turn it off. Not used with [`SolveSettings::graduation`].
    pub switches: Option<Switches>,
    /// Whether only the largest set of loop closures that agree with each other through odometry is used, before
    /// anything else is done.
    pub pairwise: Option<Pairwise>,
    /// Vertices to hold, besides those that the file fixes.
    pub fixed: Vec<u64>,
    /// What to do with information matrices that are not positive definite.
    pub indefinite: Indefinite,
    /// How to move and when to stop.
    pub options: SolveOptions,
}

/// The factors of a pose graph and its vertices, for tests of what lies below.
#[cfg(test)]
pub(crate) fn factors(graph: &PoseGraph) -> Result<(graph::Graph, graph::Values), PoseGraphError> {
    Problem::new(graph, &SolveSettings::default()).map(|problem| (problem.factors, problem.values))
}

/// What [`solve_observed`] tells while it works.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress<'a> {
    /// The map grows towards a first estimate ([`Initial::Grown`]), at ½ Σ ρ(‖U·r‖²).
    Growing(Growth),
    /// The first estimate is there, made this way, with this objective.
    Initialised(Initial, f64),
    /// A trial step was made.
    Iteration(&'a Iteration),
}

/// One measurement, and how badly it fits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Misfit {
    /// Its kind.
    pub kind: Kind,
    /// Its first vertex.
    pub from: u64,
    /// Its second vertex, or `None` for a prior.
    pub to: Option<u64>,
    /// Where it was read.
    pub line: Line,
    /// ‖U·r‖²: χ² with `dof` degrees of freedom if the information is as stated.
    pub chi2: f64,
    /// Dimension of the residual.
    pub dof: usize,
}

/// Seconds of the phases of [`solve`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seconds {
    /// From the pose graph to factors and variables.
    pub build: f64,
    /// The first estimate.
    pub initialise: f64,
    /// The optimisation.
    pub optimise: f64,
}

/// An optimum, and how good it is.
#[derive(Clone, Debug)]
pub struct Solved {
    /// The input with its vertices at the optimum. Vertices that had no value are added.
    pub graph: PoseGraph,
    /// The input with its vertices at the first estimate.
    pub initial: PoseGraph,
    /// The way the first estimate was made.
    pub initialisation: Initial,
    /// The objective of every candidate for the first estimate.
    pub candidates: Vec<(Initial, f64)>,
    /// The objective of the input as it was given, or `None` where vertices had no value.
    pub given_cost: Option<f64>,
    /// The objective of the first estimate, in the convention of the chart.
    pub initial_cost: f64,
    /// The objective at the optimum, in the convention of the chart, with the kernel.
    pub cost: f64,
    /// What the four tools would print for this optimum, without kernel.
    pub costs: Costs,
    /// How the optimisation went.
    pub report: SolveReport,
    /// The directions that nothing constrains.
    pub unconstrained: Option<Unconstrained>,
    /// Parts of the graph that no measurement joins: they have no place relative to each other.
    pub parts: usize,
    /// χ² of every measurement, in the order of [`PoseGraph::constraints`]; NaN where it was left out.
    pub chi2: Vec<f64>,
    /// With [`SolveSettings::graduation`], [`SolveSettings::switches`] or [`SolveSettings::pairwise`]: the loop closures found to be
    /// false, as places in [`PoseGraph::constraints`].
    pub rejected: Vec<usize>,
    /// With [`SolveSettings::pairwise`]: how many closures agree with each other.
    pub selection: Option<Selection>,
    /// The measurements whose information matrix had to be mended or left out.
    pub mended: Vec<Line>,
    /// Where the time went.
    pub seconds: Seconds,
}

impl Solved {
    /// Whether some part of the graph has no place relative to the others: nothing joins them, and nothing ties it down.
    pub fn falls_apart(&self) -> bool {
        self.parts > 1 && !self.report.gauge.is_empty()
    }

    /// The `count` measurements that fit worst, worst first.
    pub fn worst(&self, count: usize) -> Vec<Misfit> {
        let mut all: Vec<_> = self.misfits().filter(|m| !m.chi2.is_nan()).collect();
        all.sort_by(|a, b| b.chi2.total_cmp(&a.chi2));
        all.truncate(count);
        all
    }

    /// The loop closures found to be false, in the order of [`PoseGraph::constraints`].
    pub fn rejected_closures(&self) -> Vec<Misfit> {
        let misfits: Vec<_> = self.misfits().collect();
        self.rejected.iter().filter_map(|&place| misfits.get(place).copied()).collect()
    }

    /// The solved graph without the loop closures found to be false: what its covariances are to be told from.
    pub fn agreeing(&self) -> PoseGraph {
        closures::keeping(&self.graph, |place| self.rejected.binary_search(&place).is_err())
    }

    /// Every measurement and its χ², in the order of [`PoseGraph::constraints`].
    pub(in crate::pose_graph) fn misfits(&self) -> impl Iterator<Item = Misfit> {
        let misfit = |(c, &chi2): (Constraint<'_>, &f64)| Misfit {
            kind: c.kind,
            from: c.from,
            to: c.to,
            line: c.line,
            chi2,
            dof: c.dof(),
        };
        self.graph.constraints().zip(&self.chi2).map(misfit)
    }
}

/// Why a pose graph cannot be solved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PoseGraphError {
    /// The graph itself is faulty.
    #[error("{} fault(s) make the graph unsolvable{}", faults.len(), first(faults))]
    Faulty {
        /// All of them.
        faults: Vec<Fault>,
    },
    /// One measurement cannot be used.
    #[error("the measurement of line {} cannot be used: {error}", line.0)]
    Measurement {
        /// Where it was read.
        line: Line,
        /// What is wrong with it.
        error: GraphError,
    },
    /// One id names two vertices, of one kind or of two.
    #[error("{} names two vertices; give each vertex an id of its own", Label(*id))]
    AmbiguousVertex {
        /// The id.
        id: u64,
    },
    /// There is nothing to estimate.
    #[error("the graph has no vertex and no measurement")]
    Empty,
    /// A vertex is to be held that does not exist.
    #[error("vertex {} is to be fixed, but neither a vertex nor a measurement has this id", Label(*id))]
    NoSuchVertex {
        /// Its id.
        id: u64,
    },
    /// The solver refused.
    #[error(transparent)]
    Graph(#[from] GraphError),
}

impl PoseGraph {
    /// χ² = ‖U·r‖² of every measurement at the values that the graph holds, in the order of [`PoseGraph::constraints`]:
    /// without kernel, NaN where a measurement is left out or a vertex has no value.
    ///
    /// ```
    /// use boxplus::pose_graph::simulate::{Options, Simulator};
    /// use boxplus::pose_graph::{SolveSettings, solve::solve};
    /// let graph = Simulator::Manhattan.simulate(&Options { size: Some(50), ..Options::default() })?.graph;
    /// let settings = SolveSettings::default();
    /// let solved = solve(&graph, &settings)?;
    /// let cost = 0.5 * solved.graph.chi2(&settings)?.iter().sum::<f64>();
    /// assert!((cost - solved.costs.log).abs() < 1e-9 * cost);
    /// assert_eq!(graph.initialised(&settings)?, solved.initial);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`PoseGraphError`], where the graph is faulty.
    pub fn chi2(&self, settings: &SolveSettings) -> Result<Vec<f64>, PoseGraphError> {
        let problem = Problem::new(self, settings)?;
        Ok(problem.chi2(&problem.values))
    }

    /// The graph with its vertices at the first estimate that [`solve`] would start from.
    ///
    /// # Errors
    /// As [`solve`].
    pub fn initialised(&self, settings: &SolveSettings) -> Result<PoseGraph, PoseGraphError> {
        let problem = Problem::new(self, settings)?;
        let start = closures::first_estimate(self, &problem, settings, &mut |_| ControlFlow::Continue(()))?;
        Ok(with_values(self, &start.initialisation.values))
    }
}

fn first(faults: &[Fault]) -> String {
    faults.first().map_or_else(String::new, |fault| format!("; the first: {fault}"))
}

/// Finds the optimum of a pose graph: initialises, optimises, and judges the result.
///
/// Not converging is no error: see [`SolveReport::termination`].
///
/// # Errors
/// [`PoseGraphError`], with every fault found.
pub fn solve(graph: &PoseGraph, settings: &SolveSettings) -> Result<Solved, PoseGraphError> {
    solve_observed(graph, settings, &mut |_| ControlFlow::Continue(()))
}

/// As [`solve`]; `observer` sees the progress, and may stop with the best estimate so far.
///
/// # Errors
/// As [`solve`].
pub fn solve_observed(
    graph: &PoseGraph,
    settings: &SolveSettings,
    observer: &mut dyn FnMut(Progress<'_>) -> ControlFlow<()>,
) -> Result<Solved, PoseGraphError> {
    let clock = Clock::start();
    let problem = Problem::new(graph, settings)?;
    let scale = settings.chart.factor();
    let given_cost = problem.factors.cost(&problem.values).ok().map(|cost| scale * cost);
    let built = clock.seconds();

    let mut grows = |growth| observer(Progress::Growing(growth));
    let start = closures::first_estimate(graph, &problem, settings, &mut grows)?;
    let first = &start.initialisation;
    let initialised = clock.seconds();
    let stopped = observer(Progress::Initialised(first.chosen, scale * first.cost())).is_break();

    let max_iterations = if stopped { 0 } else { settings.options.max_iterations };
    let options = SolveOptions { max_iterations, ..settings.options.clone() };
    let mut watch = |iteration: &Iteration| observer(Progress::Iteration(iteration));
    let found = if settings.doubts_closures() {
        closures::search(graph, &start, (settings, &options), &mut watch)?
    } else {
        let solution = problem.factors.optimize_observed(&first.values, &options, &mut watch)?;
        closures::Found { solution, rejected: vec![], selection: None }
    };
    let optimised = clock.seconds();

    let closures::Found { solution, rejected, selection } = found;
    let mut report = solution.report;
    if stopped {
        report.termination = graph::Termination::Interrupted;
    }
    let solved = with_values(graph, &solution.values);
    Ok(Solved {
        costs: Costs::new(&solved, settings)?,
        initial: with_values(graph, &first.values),
        initialisation: first.chosen,
        candidates: first.costs.iter().map(|&(initial, cost)| (initial, scale * cost)).collect(),
        given_cost,
        initial_cost: scale * report.initial_cost,
        cost: scale * report.cost,
        chi2: problem.chi2(&solution.values),
        parts: problem.factors.parts(&problem.values).len(),
        rejected,
        selection,
        mended: problem.mended,
        unconstrained: solution.unconstrained,
        report,
        graph: solved,
        seconds: Seconds { build: built, initialise: initialised - built, optimise: optimised - initialised },
    })
}
