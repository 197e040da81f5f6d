//! What `solve` says: one readable screen.

use boxplus::pose_graph::Label;

use crate::document::{
    CertificateReport, DescentReport, Seconds, SolveDocument, Trial, TruthReport, WorstEdge,
};
use crate::output::{DIM, GOOD, STRONG, WARN};
use crate::text::{count, duration, grouped, significant};

/// Digits of a cost.
const DIGITS: usize = 10;
/// Worst edges and faults without `--verbose`.
const WORST: usize = 5;

impl SolveDocument {
    /// The screen.
    pub fn screen(&self, verbose: bool) -> String {
        let mut rows = vec![self.heading(), String::new(), self.cost_row()];
        rows.extend(self.charts());
        rows.extend(self.truth.iter().map(TruthReport::row));
        rows.extend(self.certificate.iter().flat_map(CertificateReport::rows));
        rows.push(row("stopped", &self.stopped()));
        rows.push(row("start", &self.start()));
        rows.push(row("held", &self.held()));
        rows.push(row("time", &self.time()));
        rows.extend(self.fault_rows());
        rows.extend(self.pairwise());
        rows.extend(self.rejected(if verbose { usize::MAX } else { WORST }));
        rows.extend(self.mended());
        rows.extend(self.worst_rows(if verbose { self.worst_edges.len() } else { WORST }));
        if verbose {
            rows.extend(Trial::rows(&self.trace));
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
        stopped(self.converged, &self.reason, self.iterations, self.accepted)
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
            ([id], []) => format!("vertex {}, as asked", Label(*id)),
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

    fn mended(&self) -> Option<String> {
        let edges = count(self.mended.len(), "measurement", "measurements");
        let text = format!("{WARN}{edges}{WARN:#} with an information matrix that is not positive definite");
        (!self.mended.is_empty()).then(|| row("mended", &text))
    }

    fn worst_rows(&self, shown: usize) -> Vec<String> {
        let edges = self.worst_edges.iter().take(shown).enumerate();
        edges.map(|(i, edge)| row(if i == 0 { "worst" } else { "" }, &edge.text())).collect()
    }

    fn pairwise(&self) -> Option<String> {
        let pairwise = self.pairwise.as_ref()?;
        let closures = count(pairwise.closures, "loop closure", "loop closures");
        let sure = if pairwise.is_largest { "no larger set does" } else { "the largest set found in time" };
        let text =
            format!("{} of {closures} agree with each other   {DIM}{sure}{DIM:#}", grouped(pairwise.kept));
        Some(row("pairwise", &text))
    }

    /// The loop closures found to be false.
    fn rejected(&self, shown: usize) -> Vec<String> {
        let Some(rejected) = &self.rejected_closures else { return vec![] };
        let told = match rejected.len() {
            0 => format!(
                "{GOOD}none{GOOD:#} of {}",
                count(self.loop_closures, "loop closure", "loop closures")
            ),
            n => format!(
                "{WARN}{}{WARN:#} of {} found false, and left out",
                grouped(n),
                count(self.loop_closures, "loop closure", "loop closures")
            ),
        };
        let mut rows = vec![row("rejected", &told)];
        rows.extend(rejected.iter().take(shown).map(|edge| row("", &edge.text())));
        if rejected.len() > shown {
            rows.push(row(
                "",
                &format!("{DIM}and {} more, with --verbose{DIM:#}", grouped(rejected.len() - shown)),
            ));
        }
        rows
    }
}

impl Trial {
    /// A table of the steps.
    pub fn rows(trace: &[Self]) -> Vec<String> {
        let title = row(
            "",
            &format!("{DIM}step   cost             gradient    step        damping     seconds{DIM:#}"),
        );
        let rows = trace.iter().enumerate().map(|(i, s)| {
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

impl TruthReport {
    fn row(&self) -> String {
        let [position, largest, landmark] = [self.position, self.largest, self.landmark]
            .map(|metres| format!("{} m", significant(metres, 3)));
        let points = match self.points {
            0 => String::new(),
            n => format!(" · {} {landmark}", count(n, "point", "points")),
        };
        let angle = significant(self.rotation, 3);
        let what = format!("{DIM}rms beside the truth, aligned{DIM:#}");
        row(
            "error",
            &format!("{STRONG}{position}{STRONG:#}, at most {largest}, {angle} rad{points}   {what}"),
        )
    }
}

impl CertificateReport {
    fn rows(&self) -> Vec<String> {
        let gap = significant(self.gap, 2);
        let part = format!("{DIM}SE-Sync's cost {}{DIM:#}", significant(self.cost, DIGITS));
        let verdict = match self.verdict {
            "optimal" => format!("{GOOD}yes{GOOD:#}, no estimate is better by more than {gap}   {part}"),
            _ => {
                format!("{WARN}undecided{WARN:#}, another estimate could be better by at most {gap}   {part}")
            }
        };
        let way = |descent: &DescentReport| {
            let most: Vec<_> = descent.vertices.iter().map(ToString::to_string).collect();
            let left = if self.escapes == 0 { "is not left" } else { "left" };
            let text = format!(
                "the minimum at {} {left}: curvature {}, vertices {} turn most",
                significant(descent.from_cost, DIGITS),
                significant(descent.curvature, 3),
                most.join(", ")
            );
            row("", &text)
        };
        [row("optimum", &verdict)].into_iter().chain(self.descent.as_ref().map(way)).collect()
    }
}

impl WorstEdge {
    /// `0 → 7   χ² 12.1   2 σ   line 5`.
    pub fn text(&self) -> String {
        let to = self.to.map_or(String::new(), |to| format!(" → {}", Label(to)));
        let line = self.line.map_or(String::new(), |line| format!("   {DIM}line {line}{DIM:#}"));
        let ends = format!("{}{to}", Label(self.from));
        let (chi2, sigmas) = (significant(self.chi2, 4), significant(self.sigmas, 3));
        format!("{ends:<16} χ² {chi2:<10} {sigmas:>6} σ{line}")
    }
}

/// Why the search ended, and after how many trial steps, of which so many were accepted.
pub fn stopped(converged: bool, reason: &str, iterations: usize, accepted: usize) -> String {
    let style = if converged { GOOD } else { WARN };
    let steps = count(iterations, "step", "steps");
    let rejected = iterations - accepted.min(iterations);
    let rejected = if rejected > 0 { format!(", {rejected} rejected") } else { String::new() };
    format!("{style}{reason}{style:#} after {steps}{rejected}")
}

/// One line of a screen: what, and its value.
pub fn row(label: &str, value: &str) -> String {
    format!("  {DIM}{label:<9}{DIM:#} {value}").trim_end().to_owned()
}
