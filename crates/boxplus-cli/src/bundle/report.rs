//! What a bundle's `solve` found out, as one document for machines and for the screen alike.

use boxplus::bundle_adjustment::{Anchor, Fault, Severity, Solved};
use serde::Serialize;

use crate::args::Method;
use crate::document::{Phases, Trial};
use crate::input::LoadedBundle;
use crate::output::{DIM, STRONG, WARN};
use crate::report::{row, stopped};
use crate::text::{count, duration, grouped, significant};

/// Digits of a cost.
const DIGITS: usize = 10;
/// Worst observations in the document, and on the screen without `--verbose`.
const DETAILED: usize = 20;
const WORST: usize = 3;

/// The report of a bundle. Numbers that are not finite become `null` in JSON.
#[derive(Debug, Serialize)]
pub struct BundleDocument {
    /// `boxplus.bundle`.
    pub format: &'static str,
    /// Counts up when a field changes its meaning or goes away.
    pub version: u32,
    pub input: String,
    pub views: usize,
    pub points: usize,
    pub observations: usize,
    /// Observations that take part.
    pub used: usize,
    pub intrinsics: &'static str,
    pub robust: Option<String>,
    /// ½ Σ ρ(|r|²) of the input, pixels squared.
    pub initial_cost: f64,
    /// And of the result.
    pub cost: f64,
    /// Root mean square of |r|, pixels.
    pub initial_rms: f64,
    pub rms: f64,
    pub iterations: usize,
    pub accepted: usize,
    pub termination: &'static str,
    pub reason: String,
    pub converged: bool,
    pub gauge: GaugeReport,
    /// Observations of points behind their camera or beyond its lens, before and after.
    pub unseen: [usize; 2],
    pub seconds: Seconds,
    pub threads: usize,
    pub trace: Vec<Trial>,
    pub worst: Vec<WorstObservation>,
    pub faults: Vec<FaultReport>,
    pub outputs: Vec<String>,
}

/// What images do not tell.
#[derive(Debug, Serialize)]
pub struct GaugeReport {
    /// Free directions: seven for each part without a held view.
    pub free: usize,
    /// Views held as asked.
    pub fixed: Vec<u64>,
    /// Where each part was put: a view that stands where it stood, and one that is as far from it as it was.
    pub anchors: Vec<AnchorReport>,
}

#[derive(Debug, Serialize)]
pub struct AnchorReport {
    pub view: usize,
    pub scale: Option<usize>,
}

/// An observation that fits badly.
#[derive(Debug, Serialize)]
pub struct WorstObservation {
    pub view: u32,
    pub point: u32,
    /// |r|, pixels.
    pub pixels: f64,
    /// Line of the file, `null` where it does not come from one.
    pub line: Option<u32>,
}

#[derive(Debug, Serialize)]
pub struct FaultReport {
    pub severity: &'static str,
    pub line: Option<u32>,
    pub message: String,
}

/// Wall clock.
#[derive(Debug, Serialize)]
pub struct Seconds {
    pub load: f64,
    pub optimise: f64,
    pub total: f64,
    /// Parts of `optimise`.
    pub phases: Phases,
}

fn known(line: u32) -> Option<u32> {
    Some(line).filter(|&line| line > 0)
}

impl BundleDocument {
    pub(super) fn new(loaded: &LoadedBundle, method: &Method, solved: &Solved, total: f64) -> Self {
        let (bundle, report) = (&loaded.bundle, &solved.report);
        let worst = solved.worst(DETAILED).into_iter().map(|i| {
            let o = &bundle.observations[i];
            WorstObservation {
                view: o.view,
                point: o.point,
                pixels: solved.squared[i].sqrt(),
                line: known(o.line.0),
            }
        });
        let anchor = |&Anchor { view, scale }: &Anchor| AnchorReport { view, scale };
        Self {
            format: "boxplus.bundle",
            version: 1,
            input: loaded.name.clone(),
            views: bundle.views.len(),
            points: bundle.points.len(),
            observations: bundle.observations.len(),
            used: solved.used,
            intrinsics: method.intrinsics.unwrap_or_default().name(),
            robust: method.robust.as_ref().map(|robust| robust.text.clone()),
            initial_cost: solved.initial_cost,
            cost: solved.cost,
            initial_rms: solved.initial_rms(),
            rms: solved.rms(),
            iterations: report.iterations.len(),
            accepted: report.accepted(),
            termination: report.termination.name(),
            reason: report.termination.to_string(),
            converged: report.converged(),
            gauge: GaugeReport {
                free: solved.gauge.free,
                fixed: method.fix.clone(),
                anchors: solved.gauge.anchors.iter().map(anchor).collect(),
            },
            unseen: [solved.unseen_before, solved.unseen_after],
            seconds: Seconds {
                load: loaded.seconds,
                optimise: report.seconds.total,
                total,
                phases: Phases::of(&report.seconds),
            },
            threads: report.threads,
            trace: report.iterations.iter().map(Trial::of).collect(),
            worst: worst.collect(),
            faults: bundle.faults().iter().map(FaultReport::of).collect(),
            outputs: vec![],
        }
    }

    /// The screen.
    pub fn screen(&self, verbose: bool) -> String {
        let sizes = format!(
            "{} views · {} points · {} observations",
            grouped(self.views),
            grouped(self.points),
            grouped(self.observations)
        );
        let mut rows = vec![format!("{STRONG}{}{STRONG:#}   {sizes}", self.input), String::new()];
        rows.push(row("cost", &self.cost()));
        let (from, to) = (significant(self.initial_rms, 4), significant(self.rms, 4));
        rows.push(row("rms", &format!("{from} → {STRONG}{to}{STRONG:#} pixels an observation")));
        rows.push(row("stopped", &self.stopped()));
        rows.push(row("held", &self.held()));
        rows.extend(self.unseen());
        rows.push(row("time", &self.time()));
        rows.extend(self.faults.iter().map(FaultReport::row));
        let shown = if verbose { self.worst.len() } else { WORST };
        let worst = self.worst.iter().take(shown).enumerate();
        rows.extend(worst.map(|(i, worst)| row(if i == 0 { "worst" } else { "" }, &worst.text())));
        if verbose {
            rows.extend(Trial::rows(&self.trace));
        }
        rows.join("\n")
    }

    fn cost(&self) -> String {
        let robust = self.robust.as_ref().map_or(String::new(), |kernel| format!(", robust {kernel}"));
        let (from, to) = (significant(self.initial_cost, 6), significant(self.cost, DIGITS));
        format!(
            "{from} → {STRONG}{to}{STRONG:#}   {DIM}½Σ|r|² in pixels, {} intrinsics{robust}{DIM:#}",
            self.intrinsics
        )
    }

    fn stopped(&self) -> String {
        stopped(self.converged, &self.reason, self.iterations, self.accepted)
    }

    /// What keeps the world in place, which no image tells.
    fn held(&self) -> String {
        let fixed = match self.gauge.fixed.len() {
            0 => String::new(),
            n => format!("{}, as asked   ", count(n, "view", "views")),
        };
        let put = match self.gauge.anchors.as_slice() {
            _ if self.gauge.free == 0 => String::new(),
            [AnchorReport { view, scale: Some(scale) }] => {
                format!("view {view} stays, view {scale} as far from it as before")
            }
            [AnchorReport { view, scale: None }] => format!("view {view} stays"),
            many => format!("one view in each of {} parts stays", many.len()),
        };
        let free = count(self.gauge.free, "direction", "directions");
        format!("{fixed}{put}   {DIM}images leave {free} free{DIM:#}")
    }

    fn unseen(&self) -> Option<String> {
        let [before, after] = self.unseen;
        let left_out = self.observations - self.used;
        let fate = if left_out > 0 { format!(", {} left out", grouped(left_out)) } else { String::new() };
        (before + after + left_out > 0).then(|| {
            let text = format!(
                "{WARN}{} → {}{WARN:#} observations of points behind the camera or beyond its lens{fate}",
                grouped(before),
                grouped(after)
            );
            row("behind", &text)
        })
    }

    fn time(&self) -> String {
        let Seconds { load, optimise, total, phases } = &self.seconds;
        let parts = format!(
            "{DIM}load {} · optimise {} (linearise {}, factorise {}){DIM:#}",
            duration(*load),
            duration(*optimise),
            duration(phases.linearise + phases.evaluate),
            duration(phases.analyse + phases.factorise + phases.solve),
        );
        format!("{}, {}   {parts}", duration(*total), count(self.threads, "thread", "threads"))
    }
}

impl WorstObservation {
    fn text(&self) -> String {
        let line = self.line.map_or(String::new(), |line| format!("   {DIM}line {line}{DIM:#}"));
        format!(
            "view {:<6} point {:<8} {:>6} pixels{line}",
            self.view,
            self.point,
            significant(self.pixels, 3)
        )
    }
}

impl FaultReport {
    fn of(fault: &Fault) -> Self {
        let severity = match fault.severity() {
            Severity::Note => "note",
            Severity::Warning => "warning",
            Severity::Error => "error",
        };
        Self { severity, line: known(fault.line().0), message: fault.to_string() }
    }

    fn row(&self) -> String {
        let place = self.line.map_or(String::new(), |line| format!("{DIM}line {line}:{DIM:#} "));
        row(self.severity, &format!("{place}{WARN}{}{WARN:#}", self.message))
    }
}
