//! `boxplus info`: what is in a file, and what is wrong with it.

use boxplus::pose_graph::{Degree, Fault, Label, PoseGraph, Severity, Statistics};
use serde::Serialize;

use crate::args::{Global, Info};
use crate::error::Error;
use crate::input::{self, Loaded};
use crate::output::{self, Console, DIM, GOOD, STRONG, WARN};
use crate::report::row;
use crate::text::{count, grouped, significant};

/// Faults on the screen without `--verbose`.
const SHOWN: usize = 8;

/// Reads, counts, checks, prints.
pub fn run(options: &Info, global: &Global, console: Console) -> Result<(), Error> {
    let loaded = input::load(&options.input, global, console)?;
    let (statistics, faults) = (loaded.graph.statistics(), loaded.faults());
    if console.is_json() {
        return output::document(&document(&loaded, &statistics, &faults));
    }
    console.say(&screen(&loaded, &statistics, &faults, console.is_verbose()))
}

/// The document for machines.
#[derive(Debug, Serialize)]
struct InfoReport<'a> {
    format: &'static str,
    version: u32,
    input: &'a str,
    file_format: Option<&'static str>,
    gzip: bool,
    poses: usize,
    points: usize,
    fixed: usize,
    ids: usize,
    id_range: Option<(u64, u64)>,
    id_gaps: u64,
    measurements: usize,
    counts: Vec<Tagged<'a>>,
    other: Vec<Tagged<'a>>,
    loop_closures: usize,
    repeated_edges: usize,
    components: usize,
    largest_component: usize,
    degree: DegreeReport,
    bounds: Option<[[f64; 3]; 2]>,
    trajectory_length: f64,
    sigma_translation: Option<f64>,
    sigma_rotation: Option<f64>,
    information_range: Option<(f64, f64)>,
    faults: Vec<FaultReport>,
}

#[derive(Debug, Serialize)]
struct Tagged<'a> {
    tag: &'a str,
    count: usize,
}

#[derive(Debug, Serialize)]
struct DegreeReport {
    min: usize,
    mean: f64,
    max: usize,
}

/// A fault for machines.
#[derive(Debug, Serialize)]
pub struct FaultReport {
    severity: &'static str,
    /// Line of the input, `null` where no single line is at fault.
    line: Option<u32>,
    message: String,
}

impl FaultReport {
    /// The fault with its line.
    pub fn new(fault: &Fault) -> Self {
        let line = Some(fault.line().0).filter(|&line| line > 0);
        Self { severity: severity(fault), line, message: fault.to_string() }
    }

    /// `note`, `warning` or `error`.
    pub fn severity(&self) -> &'static str {
        self.severity
    }

    /// One line of a screen.
    pub fn text(&self) -> String {
        let place = self.line.map_or(String::new(), |line| format!("{DIM}line {line}:{DIM:#} "));
        format!("{place}{WARN}{}{WARN:#}", self.message)
    }
}

fn severity(fault: &Fault) -> &'static str {
    match fault.severity() {
        Severity::Note => "note",
        Severity::Warning => "warning",
        Severity::Error => "error",
    }
}

fn document<'a>(loaded: &'a Loaded, s: &'a Statistics, faults: &[Fault]) -> InfoReport<'a> {
    InfoReport {
        format: "boxplus.info",
        version: 1,
        input: &loaded.name,
        file_format: loaded.format.map(boxplus::io::Format::name),
        gzip: loaded.gzip,
        poses: s.poses,
        points: s.points,
        fixed: s.fixed,
        ids: s.ids,
        id_range: s.id_range,
        id_gaps: s.id_gaps,
        measurements: s.counts.iter().map(|(_, count)| count).sum(),
        counts: s.counts.iter().map(|(kind, count)| Tagged { tag: kind.tag(), count: *count }).collect(),
        other: s.other.iter().map(|(tag, count)| Tagged { tag, count: *count }).collect(),
        loop_closures: s.loop_closures,
        repeated_edges: s.repeated_edges,
        components: s.components,
        largest_component: s.largest_component,
        degree: DegreeReport { min: s.degree.min, mean: s.degree.mean, max: s.degree.max },
        bounds: s.bounds.map(|(low, high)| [low.into(), high.into()]),
        trajectory_length: s.trajectory_length,
        sigma_translation: s.sigma_translation,
        sigma_rotation: s.sigma_rotation,
        information_range: s.information_range,
        faults: faults.iter().map(FaultReport::new).collect(),
    }
}

fn screen(loaded: &Loaded, s: &Statistics, faults: &[Fault], verbose: bool) -> String {
    let packed = if loaded.gzip { ", gzip" } else { "" };
    let format = loaded.format.map_or("simulated", boxplus::io::Format::name);
    let mut rows = vec![
        format!("{STRONG}{}{STRONG:#}   {DIM}{format}{packed}{DIM:#}", loaded.name),
        String::new(),
        row("vertices", &vertices(&loaded.graph, s)),
        row("measured", &measurements(s)),
        row("joined", &connection(s)),
    ];
    rows.extend(extent(s).map(|text| row("extent", &text)));
    rows.extend(noise(s).map(|text| row("noise", &text)));
    rows.push(row(
        "fixed",
        &if s.fixed == 0 { "nothing".to_owned() } else { count(s.fixed, "vertex", "vertices") },
    ));
    rows.extend(unknown(s).map(|text| row("unknown", &text)));
    rows.extend(fault_rows(faults, if verbose { usize::MAX } else { SHOWN }));
    rows.join("\n")
}

/// `2500 poses in space, 20 points in space`.
pub fn kinds(graph: &PoseGraph) -> Vec<(usize, &'static str, &'static str)> {
    let kinds = [
        (graph.poses2.len(), "pose in the plane", "poses in the plane"),
        (graph.poses3.len(), "pose in space", "poses in space"),
        (graph.points2.len(), "point in the plane", "points in the plane"),
        (graph.points3.len(), "point in space", "points in space"),
    ];
    kinds.into_iter().filter(|kind| kind.0 > 0).collect()
}

fn vertices(graph: &PoseGraph, s: &Statistics) -> String {
    let kinds: Vec<_> = kinds(graph).into_iter().map(|(n, one, many)| count(n, one, many)).collect();
    let named = format!("none; measurements name {}", count(s.ids, "vertex", "vertices"));
    let what = if kinds.is_empty() { named } else { kinds.join(", ") };
    let ids =
        s.id_range.map_or(String::new(), |(low, high)| format!("ids {} to {}", Label(low), Label(high)));
    let gaps = if s.id_gaps > 0 {
        format!(", {} unused", grouped(usize::try_from(s.id_gaps).unwrap_or(usize::MAX)))
    } else {
        String::new()
    };
    format!("{what}   {DIM}{ids}{gaps}{DIM:#}")
}

fn measurements(s: &Statistics) -> String {
    let kinds: Vec<_> = s.counts.iter().map(|(kind, n)| format!("{} {}", grouped(*n), kind.tag())).collect();
    let repeated = if s.repeated_edges > 0 {
        format!(", {} between the same two", grouped(s.repeated_edges))
    } else {
        String::new()
    };
    format!(
        "{}   {DIM}{}{repeated}{DIM:#}",
        kinds.join(", "),
        count(s.loop_closures, "loop closure", "loop closures")
    )
}

fn connection(s: &Statistics) -> String {
    let Degree { min, mean, max } = s.degree;
    let degree = format!("{DIM}{min} to {max} measurements a vertex, {mean:.2} on average{DIM:#}");
    match s.components {
        1 => format!("one part   {degree}"),
        n => format!(
            "{WARN}{} parts{WARN:#}, the largest of {}   {degree}",
            grouped(n),
            count(s.largest_component, "vertex", "vertices")
        ),
    }
}

fn extent(s: &Statistics) -> Option<String> {
    let (low, high) = s.bounds?;
    let size = high - low;
    let flat = size.z == 0.0;
    let sides: Vec<_> = size.iter().take(if flat { 2 } else { 3 }).map(|x| significant(*x, 4)).collect();
    Some(format!("{} m   {DIM}path {} m{DIM:#}", sides.join(" × "), significant(s.trajectory_length, 5)))
}

fn noise(s: &Statistics) -> Option<String> {
    let metres = s.sigma_translation.map(|x| format!("{} m", significant(x, 3)));
    let radians = s.sigma_rotation.map(|x| format!("{} rad", significant(x, 3)));
    let sigmas: Vec<_> = metres.into_iter().chain(radians).collect();
    let range = s.information_range.map(|(low, high)| {
        let [low, high] = [low, high].map(|x| significant(x, 3));
        if low == high { format!("Ω {low}") } else { format!("Ω from {low} to {high}") }
    });
    let median =
        if sigmas.is_empty() { String::new() } else { format!("σ {} in the median", sigmas.join(", ")) };
    let text = format!("{median}   {DIM}{}{DIM:#}", range.unwrap_or_default());
    (!sigmas.is_empty() || s.information_range.is_some()).then_some(text)
}

fn unknown(s: &Statistics) -> Option<String> {
    let tags: Vec<_> = s.other.iter().map(|(tag, n)| format!("{} {tag}", grouped(*n))).collect();
    (!tags.is_empty()).then(|| format!("{}   {DIM}kept, not used{DIM:#}", tags.join(", ")))
}

fn fault_rows(faults: &[Fault], shown: usize) -> Vec<String> {
    if faults.is_empty() {
        return vec![row("faults", &format!("{GOOD}none{GOOD:#}"))];
    }
    let mut sorted: Vec<&Fault> = faults.iter().collect();
    sorted.sort_by_key(|fault| std::cmp::Reverse(fault.severity())); // stable: within a severity as found
    let mut rows = vec![row("faults", &grouped(faults.len()))];
    for fault in sorted.iter().take(shown) {
        rows.push(row("", &format!("{:<8} {}", severity(fault), FaultReport::new(fault).text())));
    }
    if faults.len() > shown {
        rows.push(row(
            "",
            &format!("{DIM}and {} more, with --verbose{DIM:#}", grouped(faults.len() - shown)),
        ));
    }
    rows
}
