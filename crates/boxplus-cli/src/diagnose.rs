//! `boxplus diagnose`: what is wrong with a graph, in words.

use boxplus::graph::{Conditioning, Loose, Weak};
use boxplus::pose_graph::diagnose::{Diagnosis, Fit, Freedom, NotFinite, Part, Scale};
use boxplus::pose_graph::{Kind, Label, PoseGraphError};
use serde::Serialize;

use crate::args::{Diagnose, Global};
use crate::document::WorstEdge;
use crate::error::{Error, Outcome};
use crate::info::FaultReport;
use crate::input::{self, Loaded};
use crate::output::{self, Console, DIM, GOOD, STRONG, WARN};
use crate::progress::Progress;
use crate::report::row;
use crate::text::{count, significant};

/// Lines of one kind on the screen without `--verbose`.
const SHOWN: usize = 5;

/// Reads, examines, prints. Exit code 4 where the data do not determine an answer.
pub fn run(options: &Diagnose, global: &Global, console: Console) -> Result<Outcome, Error> {
    let loaded = input::load(&options.input, global, console)?;
    let progress = Progress::start(console, "examining");
    let diagnosis = loaded.graph.diagnose();
    drop(progress);
    let document = Document::new(&loaded, &diagnosis);
    if console.is_json() {
        output::document(&document)?;
    } else {
        console.say(&document.screen(if console.is_verbose() { usize::MAX } else { SHOWN }))?;
    }
    Ok(if diagnosis.determined() { Outcome::Done } else { Outcome::Undetermined })
}

/// The document for machines; the screen is made from it. Numbers that are not finite become `null` in JSON.
#[derive(Debug, Serialize)]
struct Document<'a> {
    format: &'static str,
    version: u32,
    input: &'a str,
    healthy: bool,
    determined: bool,
    faults: Vec<FaultReport>,
    not_finite: Vec<Place>,
    parts: Vec<PartReport>,
    /// Ratio of the extreme eigenvalues of the normal equations with unit diagonal.
    condition: Option<f64>,
    loose: Vec<LooseReport>,
    unconstrained: Option<String>,
    weakest: Vec<WeakReport>,
    fit: Option<FitReport>,
    /// Why the graph could not be examined further.
    stopped: Option<String>,
}

#[derive(Debug, Serialize)]
struct Place {
    kind: Option<&'static str>,
    id: u64,
    to: Option<u64>,
    line: Option<u32>,
}

#[derive(Debug, Serialize)]
struct PartReport {
    first: u64,
    poses: usize,
    points: usize,
    /// Independent directions in which it may move as a whole.
    directions: usize,
    freedom: &'static str,
}

#[derive(Debug, Serialize)]
struct LooseReport {
    variable: String,
    what: String,
    directions: Vec<Vec<f64>>,
}

#[derive(Debug, Serialize)]
struct WeakReport {
    variable: String,
    /// Coordinates and their marginal standard deviations.
    sigmas: Vec<(&'static str, f64)>,
    inflation: f64,
}

#[derive(Debug, Serialize)]
struct FitReport {
    chi2: f64,
    dof: usize,
    /// 95 % band of χ².
    band: [f64; 2],
    scale: &'static str,
    kinds: Vec<KindReport>,
    worst: Vec<WorstEdge>,
    contradicting: Vec<Vec<WorstEdge>>,
}

#[derive(Debug, Serialize)]
struct KindReport {
    kind: &'static str,
    closes_loops: bool,
    count: usize,
    ratio: f64,
    band: [f64; 2],
    scale: &'static str,
}

impl<'a> Document<'a> {
    fn new(loaded: &'a Loaded, diagnosis: &Diagnosis) -> Self {
        let conditioning = diagnosis.conditioning.as_ref();
        let loose = |c: &Conditioning| c.loose.iter().map(LooseReport::new).collect();
        let weak = |c: &Conditioning| c.weakest.iter().map(WeakReport::new).collect();
        Self {
            format: "boxplus.diagnose",
            version: 1,
            input: &loaded.name,
            healthy: diagnosis.healthy(),
            determined: diagnosis.determined(),
            faults: loaded.faults().iter().map(FaultReport::new).collect(),
            not_finite: diagnosis.not_finite.iter().map(Place::new).collect(),
            parts: diagnosis.parts.iter().map(PartReport::new).collect(),
            condition: conditioning.map(|c| c.condition),
            loose: conditioning.map_or_else(Vec::new, loose),
            unconstrained: conditioning.and_then(|c| c.unconstrained.as_ref()).map(ToString::to_string),
            weakest: conditioning.map_or_else(Vec::new, weak),
            fit: diagnosis.fit.as_ref().map(FitReport::new),
            stopped: diagnosis.stopped.as_ref().map(PoseGraphError::to_string),
        }
    }

    fn screen(&self, shown: usize) -> String {
        let verdict = if self.healthy { format!("{GOOD}healthy{GOOD:#}") } else { String::new() };
        let mut rows = vec![format!("{STRONG}{}{STRONG:#}   {verdict}", self.input), String::new()];
        listed(&mut rows, "faults", shown, &self.faults, FaultReport::text);
        listed(&mut rows, "not finite", shown, &self.not_finite, Place::text);
        listed(&mut rows, "parts", shown, &self.parts, PartReport::text);
        listed(&mut rows, "free", shown, &self.loose, |l| {
            format!("{WARN}{}{WARN:#}: {}", l.variable, l.what)
        });
        rows.extend(self.unconstrained.as_ref().map(|text| row("unseen", &format!("{WARN}{text}{WARN:#}"))));
        let condition = self.condition.filter(|c| c.is_finite());
        rows.extend(condition.map(|c| row("condition", &significant(c, 2))));
        listed(&mut rows, "weakest", shown, &self.weakest, WeakReport::text);
        if let Some(fit) = &self.fit {
            fit.rows(&mut rows, shown);
        }
        rows.extend(self.stopped.as_ref().map(|text| row("stopped", &format!("{WARN}{text}{WARN:#}"))));
        rows.join("\n")
    }
}

/// Rows of which the first has the label.
fn listed<T>(rows: &mut Vec<String>, label: &str, shown: usize, items: &[T], text: impl Fn(&T) -> String) {
    let lines = items.iter().take(shown).enumerate();
    rows.extend(lines.map(|(i, item)| row(if i == 0 { label } else { "" }, &text(item))));
    if items.len() > shown {
        rows.push(row("", &format!("{DIM}and {} more, with --verbose{DIM:#}", items.len() - shown)));
    }
}

impl Place {
    fn new(n: &NotFinite) -> Self {
        let line = Some(n.line.0).filter(|&line| line > 0);
        Self { kind: n.kind.map(Kind::tag), id: n.id, to: n.to, line }
    }

    fn text(&self) -> String {
        let line = self.line.map_or(String::new(), |line| format!("{DIM}line {line}:{DIM:#} "));
        let to = self.to.map_or(String::new(), |to| format!(" → {}", Label(to)));
        format!(
            "{line}{WARN}{} {}{to} has a number that is not finite{WARN:#}",
            self.kind.unwrap_or("vertex"),
            Label(self.id)
        )
    }
}

impl PartReport {
    fn new(part: &Part) -> Self {
        let freedom = match (part.freedom, part.spatial) {
            (Freedom::All, false) => "free to translate in x, y and to turn",
            (Freedom::All, true) => "free to translate in x, y, z and to turn about every axis",
            (Freedom::TurnAboutPoint, false) => "free to turn about its only known point",
            (Freedom::TurnAboutPoint, true) => "free to turn about every axis through its only known point",
            (Freedom::TurnAboutLine, _) => "free to turn about the line through its known points",
            (Freedom::None, _) => "held",
        };
        let &Part { first, poses, points, .. } = part;
        Self { first, poses, points, directions: part.directions(), freedom }
    }

    fn text(&self) -> String {
        let points = if self.points > 0 {
            format!(", {}", count(self.points, "point", "points"))
        } else {
            String::new()
        };
        format!("{}{points} from {}: {}", count(self.poses, "pose", "poses"), self.first, self.freedom)
    }
}

impl LooseReport {
    fn new(loose: &Loose) -> Self {
        let dim = loose.directions.first().map_or(0, Vec::len);
        let what = match (loose.variable.kind.starts_with("SE"), loose.directions.len()) {
            (false, 1) => "depth unobserved".to_owned(),
            (_, n) => format!("{n} of {dim} directions unobserved"),
        };
        Self { variable: loose.variable.to_string(), what, directions: loose.directions.clone() }
    }
}

impl WeakReport {
    fn new(weak: &Weak) -> Self {
        Self { variable: weak.variable.to_string(), sigmas: weak.sigmas.clone(), inflation: weak.inflation }
    }

    fn text(&self) -> String {
        let sigmas: Vec<_> =
            self.sigmas.iter().map(|(name, s)| format!("{name} {}", significant(*s, 2))).collect();
        format!("{}   σ {}", self.variable, sigmas.join(", "))
    }
}

impl FitReport {
    fn new(fit: &Fit) -> Self {
        let kinds = fit.kinds.iter().map(|k| KindReport {
            kind: k.kind.tag(),
            closes_loops: k.closes_loops,
            count: k.count,
            ratio: k.ratio,
            band: k.band,
            scale: k.scale.name(),
        });
        Self {
            chi2: fit.chi2,
            dof: fit.dof,
            band: fit.band,
            scale: fit.scale.name(),
            kinds: kinds.collect(),
            worst: fit.worst.iter().map(WorstEdge::new).collect(),
            contradicting: fit.contradicting.iter().map(|g| g.iter().map(WorstEdge::new).collect()).collect(),
        }
    }

    fn rows(&self, rows: &mut Vec<String>, shown: usize) {
        let dof = self.dof.max(1) as f64;
        let [low, high] = self.band.map(|x| significant(x / dof, 3));
        let said = said(self.scale);
        rows.push(row(
            "χ²",
            &format!(
                "{} per degree of freedom, {low} to {high} expected   {said}",
                significant(self.chi2 / dof, 3)
            ),
        ));
        listed(rows, "", shown, &self.kinds, |k| {
            let closes = if k.closes_loops { " closing loops" } else { "" };
            let [low, high] = k.band.map(|x| significant(x, 3));
            let what = format!("{} {}{closes}", k.count, k.kind);
            format!(
                "{what:<34} {} {DIM}({low} to {high}){DIM:#}   {}",
                significant(k.ratio, 3),
                self::said(k.scale)
            )
        });
        listed(rows, "false", shown, &self.contradicting, |group| {
            let first = group.first().map_or(String::new(), WorstEdge::text);
            format!(
                "{WARN}{}{WARN:#} against all the rest: {first}",
                count(group.len(), "loop closure", "loop closures")
            )
        });
        listed(
            rows,
            "worst",
            shown.min(self.worst.len()),
            &self.worst[..shown.min(self.worst.len())],
            WorstEdge::text,
        );
    }
}

fn said(scale: &str) -> String {
    match scale {
        s if s == Scale::Plausible.name() => format!("{GOOD}plausible{GOOD:#}"),
        s if s == Scale::TooSure.name() => format!("{WARN}information too large{WARN:#}"),
        s if s == Scale::TooUnsure.name() => format!("{WARN}information too small{WARN:#}"),
        _ => "nothing is measured twice".to_owned(),
    }
}
