//! What the examples on public logs share: where the data are, what is printed, what is drawn.
#![allow(dead_code, unreachable_pub, unused_imports, reason = "each example takes what it needs")]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "an example talks")]

pub mod inertial;

use std::error::Error;
use std::ops::Range;
use std::path::{Path, PathBuf};

use boxplus::io::IoError;
use boxplus::recording::{Fates, Log, Score, Stamped};
pub use boxplus_cli::draw::{DEGREES, charts, in_plane, in_space, path};
use boxplus_cli::draw::{Run, png};

pub type Outcome<T> = Result<T, Box<dyn Error>>;

/// What came out of a log.
#[derive(Debug)]
pub struct Report {
    /// Which log.
    pub title: String,
    /// One for each filter or robot.
    pub rows: Vec<Row>,
    /// The picture of the last one.
    pub picture: Run,
}

/// A filter's result.
#[derive(Clone, Debug, Default)]
pub struct Row {
    /// Which filter, or which robot.
    pub name: String,
    /// RMSE of the position in metres.
    pub position: Option<f64>,
    /// RMSE of the rotation in degrees.
    pub rotation: Option<f64>,
    /// Share of all errors inside 3σ, coordinate by coordinate; of a Gaussian 0.9973.
    pub inside: f64,
    /// Average NEES of a coordinate; 1 is consistent.
    pub nees: f64,
    /// Average NIS of a coordinate of the measurements.
    pub nis: f64,
    /// Measurements that were believed, and not.
    pub accepted: usize,
    pub gated: usize,
}

impl Row {
    /// From a score whose first coordinates are a position, the others a rotation.
    pub fn new<const D: usize>(name: &str, score: &Score<D>, position: usize, fates: Fates) -> Self {
        let rmse = |part: Range<usize>| (!part.is_empty()).then(|| score.rmse(part));
        Self {
            name: name.to_owned(),
            position: rmse(0..position),
            rotation: rmse(position..D).map(f64::to_degrees),
            inside: score.inside(0..D, 3.0),
            nees: score.mean_nees(),
            nis: fates.mean_nis(),
            accepted: fates.accepted,
            gated: fates.gated,
        }
    }
}

/// Runs an example on the folder of the public data and prints what came out; the second argument, a name ending in .svg or .png, is
/// drawn.
pub fn main(run: fn(&Path) -> Outcome<Report>) -> Outcome<()> {
    let mut arguments = std::env::args().skip(1);
    let Some(folder) = folder(arguments.next()) else { return Ok(()) };
    let report = run(&folder)?;
    println!("{}", report.title);
    println!("{:24} position   rotation   inside 3σ   NEES    NIS   measurements", "");
    for row in &report.rows {
        let cell = |x: Option<f64>, unit| x.map_or_else(String::new, |x| format!("{x:.3} {unit}"));
        println!(
            "{:24} {:>8}  {:>9}   {:7.2} %  {:5.2}  {:5.2}   {} believed, {} not",
            row.name,
            cell(row.position, "m"),
            cell(row.rotation, "°"),
            100.0 * row.inside,
            row.nees,
            row.nis,
            row.accepted,
            row.gated
        );
    }
    if let Some(name) = arguments.next() {
        let svg = report.picture.svg();
        let bytes = if Path::new(&name).extension().is_some_and(|ending| ending == "png") {
            png(&svg).ok_or("nothing to draw")?
        } else {
            svg.into_bytes()
        };
        std::fs::write(&name, bytes)?;
        println!("wrote {name}");
    }
    Ok(())
}

/// The folder of the public data: as given, else `BOXPLUS_DATA`, else `shared/data` beside the checkout; `None`, with a note, where
/// there is none.
pub fn folder(given: Option<String>) -> Option<PathBuf> {
    let beside = || concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data").into();
    let named = given.map(PathBuf::from).or_else(|| std::env::var_os("BOXPLUS_DATA").map(PathBuf::from));
    let folder = named.unwrap_or_else(beside);
    if folder.join("inertial").is_dir() {
        return Some(folder);
    }
    println!(
        "SKIPPED: there is no inertial/ in {}; name a folder with it, or set BOXPLUS_DATA",
        folder.display()
    );
    None
}

/// A log of the folder.
pub fn read<T>(folder: &Path, path: &str, reader: fn(&[u8], &str) -> Result<T, IoError>) -> Outcome<T> {
    let file = folder.join(path);
    let bytes = std::fs::read(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    Ok(reader(&bytes, path)?)
}

/// The same, telling what is odd about it.
pub fn read_log<T>(
    folder: &Path,
    path: &str,
    reader: fn(&[u8], &str) -> Result<Log<T>, IoError>,
) -> Outcome<Vec<Stamped<T>>> {
    let log = read(folder, path, reader)?;
    log.oddities.iter().for_each(|oddity| eprintln!("{path}: {oddity}"));
    Ok(log.samples)
}

/// The main numbers, in one line.
pub fn facts(row: &Row) -> String {
    let errors = [
        row.position.map(|x| format!("position {x:.3} m")),
        row.rotation.map(|x| format!("rotation {x:.2}°")),
    ];
    let errors = errors.into_iter().flatten().collect::<Vec<_>>().join(", ");
    format!("{errors} rms · {:.1} % of errors inside 3σ", 100.0 * row.inside)
}

/// The numbers that a comment `# key=…` or `# key (…)=…` of a file states, whatever is around them; none where there is no such line.
pub fn constants(text: &str, key: &str) -> Vec<f64> {
    let comments = text.lines().filter_map(|line| line.strip_prefix('#')).map(str::trim_start);
    let line = comments.filter_map(|line| line.strip_prefix(key)).find(|rest| rest.starts_with(['=', ' ']));
    let value = line.and_then(|rest| rest.split_once('=')).map_or("", |(_, value)| value);
    let words = value.split(|c: char| !(c.is_ascii_alphanumeric() || "+-.".contains(c)));
    words.filter_map(|word| word.parse().ok()).collect()
}
