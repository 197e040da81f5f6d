//! What `solve` says: one document, printed as JSON or as one readable screen.

use std::path::Path;

use boxplus::graph::{Initial, Iteration, VariableName};
use boxplus::pose_graph::solve::Misfit;
use boxplus::pose_graph::{PoseGraph, Solved};
use serde::Serialize;

use crate::args::Method;
use crate::info::{self, FaultReport};
use crate::input::Loaded;
use crate::output::{DIM, GOOD, STRONG, WARN};
use crate::text::{count, duration, grouped, significant};

/// Digits of a cost on the screen.
const DIGITS: usize = 10;
/// Worst edges on the screen, and in the document or with `--verbose`.
const WORST: usize = 5;
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
    /// What nothing constrains, in words.
    pub unconstrained: Option<String>,
    pub outputs: Vec<String>,
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
            trace: report.iterations.iter().map(|i| Trial::new(i, method.chart.library().factor())).collect(),
            worst_edges: solved.worst(DETAILED).iter().map(WorstEdge::new).collect(),
            faults: loaded.faults().iter().map(FaultReport::new).collect(),
            unconstrained: solved.unconstrained.as_ref().map(ToString::to_string),
            outputs: Vec::new(),
        }
    }

    /// Notes that a file was written.
    pub fn wrote(&mut self, path: &Path) {
        self.outputs.push(path.display().to_string());
    }

    /// The screen.
    pub fn screen(&self, verbose: bool) -> String {
        let mut rows = vec![self.heading(), String::new(), self.cost_row()];
        rows.extend(self.charts());
        rows.push(row("stopped", &self.stopped()));
        rows.push(row("start", &self.start()));
        rows.push(row("held", &self.held()));
        rows.push(row("time", &self.time()));
        rows.extend(self.fault_rows());
        rows.extend(self.worst_rows(if verbose { self.worst_edges.len() } else { WORST }));
        if verbose {
            rows.extend(self.trace_rows());
        }
        rows.join("\n")
    }

    fn heading(&self) -> String {
        let mut parts: Vec<String> =
            self.kinds.iter().map(|k| format!("{} {}", grouped(k.count), k.kind)).collect();
        parts.push(count(self.edges, "measurement", "measurements"));
        parts.push(count(self.loop_closures, "loop closure", "loop closures"));
        format!("{STRONG}{}{STRONG:#}   {}", self.input, parts.join(" · "))
    }

    fn cost_row(&self) -> String {
        let robust = self.robust.as_ref().map_or(String::new(), |kernel| format!(", robust {kernel}"));
        let convention = match self.chart {
            "g2o" => "χ² of g2o",
            "ceres" => "½Σ of Ceres' pose graphs",
            "se-sync" => "objective of SE-Sync",
            _ => "½Σ eᵀΩe, e the logarithm",
        };
        let what = format!("{DIM}{convention}{robust}{DIM:#}");
        let (from, to) = (significant(self.initial_cost, 6), significant(self.cost, DIGITS));
        row("cost", &format!("{from} → {STRONG}{to}{STRONG:#}   {what}"))
    }

    fn charts(&self) -> [String; 2] {
        let [log, g2o, se_sync, ceres] =
            [self.costs.log, self.costs.g2o, self.costs.se_sync, self.costs.ceres]
                .map(|x| significant(x, DIGITS));
        [
            row("", &format!("{DIM}log ½Σ{DIM:#}   {log:<18} {DIM}g2o χ²{DIM:#}   {g2o}")),
            row("", &format!("{DIM}ceres ½Σ{DIM:#} {ceres:<18} {DIM}se-sync{DIM:#}  {se_sync}")),
        ]
    }

    fn stopped(&self) -> String {
        let style = if self.converged { GOOD } else { WARN };
        let steps = count(self.iterations, "step", "steps");
        let rejected = self.iterations - self.accepted.min(self.iterations);
        let rejected = if rejected > 0 { format!(", {rejected} rejected") } else { String::new() };
        format!("{style}{}{style:#} after {steps}{rejected}", self.reason)
    }

    fn start(&self) -> String {
        let others = self.initialisation.candidates.iter().filter(|c| c.name != self.initialisation.chosen);
        let others: Vec<_> =
            others.map(|c| format!("{} {}", c.name.replace('_', " "), significant(c.cost, 4))).collect();
        let rest = if others.is_empty() {
            String::new()
        } else {
            format!("   {DIM}rather than {}{DIM:#}", others.join(", "))
        };
        format!("{}{rest}", self.initialisation.chosen.replace('_', " "))
    }

    fn held(&self) -> String {
        match (self.gauge.fixed.as_slice(), self.gauge.held.as_slice()) {
            ([], []) => "nothing: priors keep the graph in place".to_owned(),
            ([id], []) => format!("vertex {id}, as asked"),
            (ids, []) => format!("{} vertices, as asked", grouped(ids.len())),
            (_, [one]) => format!("{one}, because nothing else is fixed"),
            (_, many) => {
                let names = many.iter().take(5).cloned().collect::<Vec<_>>().join(", ");
                let more = if many.len() > 5 { ", …" } else { "" };
                format!("{names}{more}: one in each of {} parts", grouped(many.len()))
            }
        }
    }

    fn time(&self) -> String {
        let Seconds { load, initialise, optimise, total, phases } = &self.seconds;
        let parts = format!(
            "{DIM}load {} · initialise {} · optimise {} (linearise {}, factorise {}){DIM:#}",
            duration(*load),
            duration(*initialise),
            duration(*optimise),
            duration(phases.linearise + phases.evaluate),
            duration(phases.analyse + phases.factorise + phases.solve),
        );
        format!("{}, {}   {parts}", duration(*total), count(self.threads, "thread", "threads"))
    }

    fn fault_rows(&self) -> Vec<String> {
        let shown = self.faults.iter().take(WORST);
        let mut rows: Vec<_> = shown.map(|fault| row(fault.severity(), &fault.text())).collect();
        if self.faults.len() > WORST {
            rows.push(row(
                "",
                &format!("and {} more: see `boxplus info`", grouped(self.faults.len() - WORST)),
            ));
        }
        rows
    }

    fn worst_rows(&self, shown: usize) -> Vec<String> {
        let rows = self.worst_edges.iter().take(shown).enumerate().map(|(i, edge)| {
            let to = edge.to.map_or(String::new(), |to| format!(" → {to}"));
            let line = edge.line.map_or(String::new(), |line| format!("   {DIM}line {line}{DIM:#}"));
            let ends = format!("{}{to}", edge.from);
            let chi2 = significant(edge.chi2, 4);
            let sigmas = significant(edge.sigmas, 3);
            row(if i == 0 { "worst" } else { "" }, &format!("{ends:<16} χ² {chi2:<10} {sigmas:>6} σ{line}"))
        });
        rows.collect()
    }

    fn trace_rows(&self) -> Vec<String> {
        let title = row(
            "",
            &format!("{DIM}step   cost             gradient    step        damping     seconds{DIM:#}"),
        );
        let rows = self.trace.iter().enumerate().map(|(i, s)| {
            let mark = if s.accepted { ' ' } else { '×' };
            let number = |x: f64| format!("{x:<11.3e}");
            let line = format!(
                "{:>4}{mark}  {:<16.9e} {} {} {} {:.4}",
                i + 1,
                s.cost,
                number(s.gradient),
                number(s.step),
                number(s.damping),
                s.seconds
            );
            row("", &line)
        });
        [title].into_iter().chain(rows).collect()
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
            phases: Phases {
                analyse: phases.analyse,
                linearise: phases.linearise,
                factorise: phases.factorise,
                solve: phases.solve,
                evaluate: phases.evaluate,
            },
        }
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
    format!("{kind} {}", variable.label)
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
    fn new(iteration: &Iteration, factor: f64) -> Self {
        let &Iteration { cost, gradient, step, damping, accepted, seconds, .. } = iteration;
        Self { cost: factor * cost, gradient, step, damping, accepted, seconds }
    }
}

impl WorstEdge {
    fn new(misfit: &Misfit) -> Self {
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

/// One line of a screen: what, and its value.
pub fn row(label: &str, value: &str) -> String {
    format!("  {DIM}{label:<9}{DIM:#} {value}").trim_end().to_owned()
}
