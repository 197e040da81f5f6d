//! What `solve` found out, as one document for machines and for the screen alike.

use std::path::Path;

use boxplus::graph::{Initial, Iteration, VariableName};
use boxplus::pose_graph::certify::Certificate;
use boxplus::pose_graph::solve::Misfit;
use boxplus::pose_graph::{Label, MapError, PoseGraph, Solved};
use serde::Serialize;

use crate::args::Method;
use crate::info::{self, FaultReport};
use crate::input::Loaded;

/// Worst edges in the document.
const DETAILED: usize = 20;

/// The report of a solve. Numbers that are not finite become `null` in JSON.
#[derive(Debug, Serialize)]
pub struct SolveDocument {
    /// `boxplus.solve`.
    pub format: &'static str,
    /// Counts up when a field changes its meaning or goes away.
    pub version: u32,
    pub input: String,
    pub vertices: usize,
    pub edges: usize,
    /// Vertices and measurements by kind, in words.
    pub kinds: Vec<Count>,
    pub loop_closures: usize,
    pub chart: &'static str,
    pub robust: Option<String>,
    pub algorithm: &'static str,
    /// Cost of the input as it is, `null` where vertices have no value.
    pub given_cost: Option<f64>,
    /// Cost of the estimate that the optimiser starts from.
    pub initial_cost: f64,
    /// What was minimised: ½ Σ ρ(eᵀΩe) in `chart`.
    pub cost: f64,
    /// The costs of the result as others count them, without the robust kernel.
    pub costs: Costs,
    pub iterations: usize,
    pub accepted: usize,
    pub termination: &'static str,
    pub reason: String,
    pub converged: bool,
    pub seconds: Seconds,
    pub threads: usize,
    pub gauge: Gauge,
    pub initialisation: Initialisation,
    pub trace: Vec<Trial>,
    pub worst_edges: Vec<WorstEdge>,
    pub faults: Vec<FaultReport>,
    /// With `--robust gnc-…`, `switchable` or `pcm`: the loop closures found to be false.
    pub rejected_closures: Option<Vec<WorstEdge>>,
    /// With `--robust pcm`: how many loop closures agree with each other.
    pub pairwise: Option<PairwiseReport>,
    /// Lines whose information matrix was mended, or that were left out: see `--information`.
    pub mended: Vec<u32>,
    /// Where the file holds the truth: how far the result is from it.
    pub truth: Option<TruthReport>,
    /// With `--certify`: what is proved about the result.
    pub certificate: Option<CertificateReport>,
    /// What nothing constrains, in words.
    pub unconstrained: Option<String>,
    pub outputs: Vec<String>,
}

/// The largest set of loop closures of which every two agree.
#[derive(Debug, Serialize)]
pub struct PairwiseReport {
    pub closures: usize,
    pub kept: usize,
    /// Whether it is certain that no set is larger; otherwise the search was cut short.
    pub is_largest: bool,
}

/// The result beside the truth, laid upon it by the rigid motion of the whole map that suits the poses best.
#[derive(Debug, Serialize)]
pub struct TruthReport {
    pub poses: usize,
    /// Root mean square distance of the positions, metres.
    pub position: f64,
    /// The largest, metres.
    pub largest: f64,
    /// Root mean square angle, radians.
    pub rotation: f64,
    pub points: usize,
    /// Root mean square distance of the points, metres.
    pub landmark: f64,
}

impl TruthReport {
    fn new(loaded: &Loaded, solved: &PoseGraph) -> Option<Self> {
        let MapError { poses, position, largest, rotation, points, landmark } =
            solved.error_beside(loaded.truth()?).ok()?;
        Some(Self { poses, position, largest, rotation, points, landmark })
    }
}

#[derive(Debug, Serialize)]
pub struct Count {
    pub count: usize,
    pub kind: String,
}

#[derive(Debug, Serialize)]
pub struct Costs {
    /// ½ Σ Ω‖Log(Z⁻¹Xᵢ⁻¹Xⱼ)‖², as GTSAM.
    pub log: f64,
    /// Σ eᵀΩe with the vector part of the quaternion.
    pub g2o: f64,
    /// SE-Sync's objective.
    pub se_sync: f64,
    /// ½ Σ of Ceres' pose-graph example.
    pub ceres: f64,
}

#[derive(Debug, Serialize)]
pub struct Seconds {
    pub load: f64,
    pub initialise: f64,
    pub optimise: f64,
    pub total: f64,
    /// Parts of `optimise`.
    pub phases: Phases,
}

#[derive(Debug, Serialize)]
pub struct Phases {
    pub analyse: f64,
    pub linearise: f64,
    pub factorise: f64,
    pub solve: f64,
    pub evaluate: f64,
}

/// What kept the graph from floating.
#[derive(Debug, Serialize)]
pub struct Gauge {
    /// Fixed in the file or by `--fix`.
    pub fixed: Vec<u64>,
    /// Held because nothing else was, one for each connected part.
    pub held: Vec<String>,
}

#[derive(Debug, Serialize)]
pub struct Initialisation {
    pub chosen: &'static str,
    pub candidates: Vec<Candidate>,
}

#[derive(Debug, Serialize)]
pub struct Candidate {
    pub name: &'static str,
    pub cost: f64,
}

/// A trial step.
#[derive(Debug, Serialize)]
pub struct Trial {
    pub cost: f64,
    pub gradient: f64,
    pub step: f64,
    pub damping: f64,
    pub accepted: bool,
    /// Since the initialisation began.
    pub seconds: f64,
}

#[derive(Debug, Serialize)]
pub struct WorstEdge {
    pub kind: String,
    pub from: u64,
    pub to: Option<u64>,
    /// Line of the input, `null` where it has none.
    pub line: Option<u32>,
    pub chi2: f64,
    /// √(χ² per degree of freedom).
    pub sigmas: f64,
}

/// Whether the result is the global optimum of SE-Sync's cost.
#[derive(Debug, Serialize)]
pub struct CertificateReport {
    /// `optimal`, `not_optimal` or `undecided`.
    pub verdict: &'static str,
    /// SE-Sync's cost of the estimate that the proof is about.
    pub cost: f64,
    /// No estimate whatever costs less.
    pub lower_bound: f64,
    pub gap: f64,
    /// Smallest eigenvalue of the dual matrix, or what it is at least.
    pub eigenvalue: f64,
    /// Minima that were left for lower ones.
    pub escapes: usize,
    /// The way down from the first of them.
    pub descent: Option<DescentReport>,
}

#[derive(Debug, Serialize)]
pub struct DescentReport {
    /// SE-Sync's cost where it begins.
    pub from_cost: f64,
    /// Curvature of the cost along it, negative.
    pub curvature: f64,
    /// The vertices that turn most.
    pub vertices: Vec<u64>,
}

impl CertificateReport {
    fn new(certificate: &Certificate) -> Self {
        let descent = certificate.descent.as_ref().map(|descent| DescentReport {
            from_cost: certificate.given_cost,
            curvature: descent.curvature,
            vertices: descent.vertices.clone(),
        });
        Self {
            verdict: certificate.verdict.name(),
            cost: certificate.cost,
            lower_bound: certificate.lower_bound,
            gap: certificate.gap(),
            eigenvalue: certificate.eigenvalue,
            escapes: certificate.escapes,
            descent,
        }
    }
}

impl SolveDocument {
    /// All there is to say. `total` counts seconds since the program began.
    pub fn new(loaded: &Loaded, method: &Method, solved: &Solved, total: f64) -> Self {
        let Solved { graph, report, costs, .. } = solved;
        Self {
            format: "boxplus.solve",
            version: 1,
            input: loaded.name.clone(),
            vertices: graph.vertex_count(),
            edges: graph.constraints().count(),
            kinds: kinds(graph),
            loop_closures: graph.statistics().loop_closures,
            chart: method.chart.library().name(),
            robust: method.robust.as_ref().map(|robust| robust.text.clone()),
            algorithm: method.algorithm.name(),
            given_cost: solved.given_cost,
            initial_cost: solved.initial_cost,
            cost: solved.cost,
            costs: Costs { log: costs.log, g2o: costs.g2o, se_sync: costs.se_sync, ceres: costs.ceres },
            iterations: report.iterations.len(),
            accepted: report.accepted(),
            termination: report.termination.name(),
            reason: report.termination.to_string(),
            converged: report.converged(),
            seconds: Seconds::new(loaded, solved, total),
            threads: report.threads,
            gauge: Gauge::new(&method.fix, solved),
            initialisation: Initialisation::new(solved),
            trace: report
                .iterations
                .iter()
                .map(|i| Trial::new(i, solved, method.chart.library().factor()))
                .collect(),
            worst_edges: solved.worst(DETAILED).iter().map(WorstEdge::new).collect(),
            faults: loaded.faults().iter().map(FaultReport::new).collect(),
            rejected_closures: method
                .robust
                .as_ref()
                .filter(|robust| robust.doubts_closures())
                .map(|_| solved.rejected_closures().iter().map(WorstEdge::new).collect()),
            pairwise: solved.selection.map(|selection| PairwiseReport {
                closures: selection.closures,
                kept: selection.kept,
                is_largest: selection.is_largest,
            }),
            mended: solved.mended.iter().map(|line| line.0).collect(),
            truth: TruthReport::new(loaded, graph),
            certificate: None,
            unconstrained: solved.unconstrained.as_ref().map(ToString::to_string),
            outputs: Vec::new(),
        }
    }

    /// Notes what is proved.
    pub fn certified(&mut self, certificate: &Certificate) {
        self.certificate = Some(CertificateReport::new(certificate));
    }

    /// Notes that a file was written.
    pub fn wrote(&mut self, path: &Path) {
        self.outputs.push(path.display().to_string());
    }
}

fn kinds(graph: &PoseGraph) -> Vec<Count> {
    let vertices =
        info::kinds(graph).into_iter().map(|(count, one, many)| (count, if count == 1 { one } else { many }));
    vertices.map(|(count, kind)| Count { count, kind: kind.to_owned() }).collect()
}

impl Seconds {
    fn new(loaded: &Loaded, solved: &Solved, total: f64) -> Self {
        let phases = &solved.report.seconds;
        Self {
            load: loaded.seconds,
            initialise: solved.seconds.build + solved.seconds.initialise,
            optimise: solved.seconds.optimise,
            total,
            phases: Phases::of(phases),
        }
    }
}

impl Phases {
    /// Those of an optimisation.
    pub fn of(seconds: &boxplus::graph::Seconds) -> Self {
        let &boxplus::graph::Seconds { analyse, linearise, factorise, solve, evaluate, .. } = seconds;
        Self { analyse, linearise, factorise, solve, evaluate }
    }
}

impl Gauge {
    fn new(asked: &[u64], solved: &Solved) -> Self {
        let mut fixed = [solved.graph.fixed.as_slice(), asked].concat();
        fixed.sort_unstable();
        fixed.dedup();
        Self { fixed, held: solved.report.gauge.iter().map(spoken).collect() }
    }
}

/// `pose 7`.
fn spoken(variable: &VariableName) -> String {
    let kind = if matches!(variable.kind, "SE2" | "SE3") { "pose" } else { "point" };
    format!("{kind} {}", Label(variable.label))
}

impl Initialisation {
    fn new(solved: &Solved) -> Self {
        let candidate = |&(initial, cost): &(Initial, f64)| Candidate { name: initial.name(), cost };
        Self {
            chosen: solved.initialisation.name(),
            candidates: solved.candidates.iter().map(candidate).collect(),
        }
    }
}

impl Trial {
    /// The solver counts in ½ Σ eᵀΩe, `factor` times that is what the chart's tool prints.
    fn new(iteration: &Iteration, solved: &Solved, factor: f64) -> Self {
        let trial = Self::of(iteration);
        Self { cost: factor * trial.cost, seconds: solved.seconds.initialise + trial.seconds, ..trial }
    }

    /// As the solver counts.
    pub fn of(iteration: &Iteration) -> Self {
        let &Iteration { cost, gradient, step, damping, accepted, seconds, .. } = iteration;
        Self { cost, gradient, step, damping, accepted, seconds }
    }
}

impl WorstEdge {
    /// The measurement in the document.
    pub fn new(misfit: &Misfit) -> Self {
        Self {
            kind: misfit.kind.to_string(),
            from: misfit.from,
            to: misfit.to,
            line: Some(misfit.line.0).filter(|&line| line > 0),
            chi2: misfit.chi2,
            sigmas: (misfit.chi2 / misfit.dof as f64).sqrt(),
        }
    }
}
