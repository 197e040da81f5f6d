//! Files: text in, text out, never a path.
//!
//! # Pose graphs
//!
//! | format | vertices | measurements |
//! |---|---|---|
//! | [g2o](Format::G2o) | `VERTEX_SE2`, `VERTEX_SE3:QUAT`, `VERTEX_XY`, `VERTEX_TRACKXYZ` | `EDGE_SE2`, `EDGE_SE3:QUAT`, `EDGE_SE2_XY`, `EDGE_SE3_TRACKXYZ`, `EDGE_BEARING_SE2_XY`, `EDGE_PRIOR_SE2`, `EDGE_SE3_PRIOR`, `EDGE_PRIOR_XY`, `EDGE_POINTXYZ_PRIOR`, with `PARAMS_SE2OFFSET`, `PARAMS_SE3OFFSET`, `FIX` |
//! | [TORO](Format::Toro) | `VERTEX2`, `VERTEX3` | `EDGE2`, `EDGE3` |
//! | [iSAM](Format::Isam) | none | `ODOMETRY`, `EDGE2`, `EDGE3`, `LANDMARK`, `POINT3`, with the square root of the information |
//! | [PyFG](Format::Pyfg) | `VERTEX_SE2`, `VERTEX_SE3:QUAT`, `VERTEX_XY`, `VERTEX_XYZ`: the truth | `EDGE_SE2`, `EDGE_SE3:QUAT`, `EDGE_SE2_XY`, `EDGE_SE3_XYZ`, `EDGE_RANGE`, `VERTEX_…:PRIOR`, with times and covariances |
//!
//! Clouds of points have files of their own, [`cloud`], and bundles of cameras and points, too, [`bal`].
//!
//! Lines with other tags are kept in [`PoseGraph::other`]. Comments (`#` at the start of a line) are dropped.
//!
//! ```
//! use boxplus::io;
//! let text = b"VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0.5\nEDGE_SE2 0 1 1 0 0.5 100 0 0 100 0 400\n";
//! let parsed = io::read(text, "two.g2o", None)?;
//! assert_eq!(parsed.graph.edges2.len(), 1);
//! assert_eq!(io::write(&parsed.graph, io::Format::G2o)?.as_bytes(), text);
//!
//! let error = io::read(b"VERTEX_SE2 0 0 O 0", "typo.g2o", None).unwrap_err();
//! assert_eq!(error.to_string(), "typo.g2o:1:16: `O` is not a number; expected y in field 3 of VERTEX_SE2");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Logs
//!
//! | reader | file | a row |
//! |---|---|---|
//! | [`read_tum`] | TUM trajectory | time, position, quaternion (x, y, z, w) |
//! | [`read_euroc_imu`] | EuRoC/ASL `imu0/data.csv` | nanoseconds, rate, specific force |
//! | [`read_euroc_states`] | EuRoC/ASL `state_groundtruth_estimate0/data.csv` | nanoseconds, position, quaternion (w, x, y, z), velocity, biases |
//! | [`read_kitti_imu`], [`read_positions`] | KITTI, as GTSAM's examples have it | time, specific force, rate; time, position |
//! | [`read_mrclam_odometry`] and its four sisters | UTIAS MRCLAM `.dat` | time, speed, turn rate; and so on |
//! | [`read_log`] | any rows of numbers, by a [`Layout`] | a time and numbers |
//!
//! Samples come out in order of time, see [`Log`](crate::recording::Log); what was odd is told, not hidden.

pub mod bal;
pub mod cloud;
mod elements;
mod error;
mod g2o;
mod isam;
mod logs;
mod pyfg;
mod scan;
mod toro;

pub use error::{IoError, IoErrorKind, Place, WriteError};
pub use logs::*;

use crate::pose_graph::{Fault, Line, PoseGraph};
use bzip2::read::MultiBzDecoder;
use core::{fmt, str::FromStr};
use elements::Printer;
use flate2::read::MultiGzDecoder;
use scan::{Fields, Layouts, Scan, Source};
use std::borrow::Cow;
use std::io::{ErrorKind, Read};

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Format {
    /// g2o: the format of most public files. Writing and reading back gives the same graph, bit for bit, with two
    /// exceptions: only the upper triangle of an information matrix is written, and the angle of an SE(2) pose that is a
    /// product of others may change by an ulp.
    G2o,
    /// TORO: poses and edges with Euler angles in space, so that reading back agrees to rounding only. `EDGE2` orders its
    /// information I₁₁ I₁₂ I₂₂ I₃₃ I₁₃ I₂₃; an `EDGE3` without information has the identity.
    Toro,
    /// iSAM: measurements only, with the upper triangle of a square root S of the information, Ω = SᵀS. Writing drops the
    /// initial values. Points of a `POINT3` line have a numbering of their own; where it meets that of the poses, the
    /// points are moved behind the last pose and [`Parsed::point_shift`] says by how much.
    Isam,
    /// PyFG: maps with ranges, by Papalia et al. (2024). Names are a letter and a number ([`Label`](crate::pose_graph::Label)); vertices are
    /// the truth ([`Format::holds_truth`]). Covariances are inverted, so that reading back agrees to rounding; of the times those of poses are
    /// kept, and measurements are written at the times of their poses.
    Pyfg,
}

impl Format {
    /// Every format.
    pub const ALL: [Self; 4] = [Self::G2o, Self::Toro, Self::Isam, Self::Pyfg];

    /// Whether the vertices of such files are the truth rather than a first estimate: nobody should start there.
    pub fn holds_truth(self) -> bool {
        self == Self::Pyfg
    }

    /// Its name, as [`FromStr`] takes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::G2o => "g2o",
            Self::Toro => "toro",
            Self::Isam => "isam",
            Self::Pyfg => "pyfg",
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is none of [`Format::ALL`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not a format; choose g2o, toro, isam or pyfg")]
pub struct UnknownFormat;

impl FromStr for Format {
    type Err = UnknownFormat;

    fn from_str(name: &str) -> Result<Self, UnknownFormat> {
        Self::ALL.into_iter().find(|f| f.name() == name).ok_or(UnknownFormat)
    }
}

/// A file that was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Parsed {
    /// What it says.
    pub graph: PoseGraph,
    /// The format it was read in.
    pub format: Format,
    /// Whether it was compressed.
    pub gzip: bool,
    /// What was odd but could be read: quaternions that are far from unit norm.
    pub warnings: Vec<Fault>,
    /// What was added to the ids of points that are numbered apart from the poses (iSAM).
    pub point_shift: u64,
}

/// Reads a pose graph from the bytes of a file, plain or gzip. `name` appears in errors. Without a `format` the content
/// decides: names such as `A0` are PyFG, `VERTEX2` or `VERTEX3` is TORO, `EDGE2` or `EDGE3` without them, `ODOMETRY`, `LANDMARK` and `POINT3` are iSAM, all
/// else is g2o.
///
/// Time and memory are linear in the size of the text.
///
/// # Errors
/// [`IoError`], with the place: what is malformed, twice given, or not a pose graph at all. What is well-formed but makes no
/// sense is found by [`PoseGraph::faults`].
pub fn read(bytes: &[u8], name: &str, format: Option<Format>) -> Result<Parsed, IoError> {
    let text = decompress(bytes, name)?;
    let unformatted = Source { name, text: &text, layouts: &[] };
    if let Some(at) = text.iter().position(|&b| b == 0) {
        return Err(not_text(unformatted, at));
    }
    let format = format.unwrap_or_else(|| sniff(unformatted));
    let Codec { layouts, read_line, .. } = codec(format);
    let source = Source { layouts, ..unformatted };
    let (mut graph, mut warnings) = (PoseGraph::default(), Vec::new());
    for mut fields in source.lines() {
        read_line(&mut fields, &mut graph)?;
        warnings.extend(fields.rough_norm.map(|norm| Fault::QuaternionNorm { norm, line: fields.line() }));
    }
    check_content(source, &graph)?;
    if format == Format::Pyfg {
        pyfg::add_offset(&mut graph);
    }
    let point_shift = if format == Format::Isam { isam::part_points(source, &mut graph)? } else { 0 };
    Ok(Parsed { graph, format, gzip: matches!(text, Cow::Owned(_)), warnings, point_shift })
}

/// What a format knows: its lines, how one is read, how a graph is written but for lines of other tags.
struct Codec {
    layouts: Layouts,
    read_line: fn(&mut Fields<'_>, &mut PoseGraph) -> Scan<()>,
    write: fn(&PoseGraph, &mut Printer) -> Result<(), WriteError>,
}

fn codec(format: Format) -> Codec {
    match format {
        Format::G2o => Codec { layouts: g2o::LAYOUTS, read_line: g2o::read_line, write: g2o::write },
        Format::Toro => Codec { layouts: toro::LAYOUTS, read_line: toro::read_line, write: toro::write },
        Format::Isam => Codec { layouts: isam::LAYOUTS, read_line: isam::read_line, write: isam::write },
        Format::Pyfg => Codec { layouts: pyfg::LAYOUTS, read_line: pyfg::read_line, write: pyfg::write },
    }
}

/// Writes a pose graph. Numbers are the shortest decimals that read back as the same float; how far
/// `read(write(graph)) == graph` holds is said at each [`Format`].
///
/// # Errors
/// [`WriteError`], where a number is not finite or the format cannot hold the graph.
pub fn write(graph: &PoseGraph, format: Format) -> Result<String, WriteError> {
    let (Codec { layouts, write, .. }, mut printer) = (codec(format), Printer::default());
    write(graph, &mut printer)?;
    for other in &graph.other {
        if layouts.iter().any(|(known, _)| *known == other.tag()) {
            return Err(WriteError::Foreign { format, tag: other.tag().into(), line: other.line });
        }
        printer.verbatim(other);
    }
    Ok(printer.into_text())
}

/// Numbers shrink to a quarter, and a file of one number repeated to a hundredth; gzip itself could do a thousandth.
const UNPACKED_FACTOR: u64 = 256;
const UNPACKED_AT_LEAST: u64 = 1 << 24;

/// The text of a file: `bytes` as they are, or decompressed if they start like gzip or bzip2. The spans of an [`IoError`] count in
/// this text.
///
/// # Errors
/// [`IoErrorKind::GzipTruncated`], [`IoErrorKind::GzipCorrupt`], the same of bzip2, or [`IoErrorKind::TooLarge`] for a file that is packed as no data are.
pub fn decompress<'a>(bytes: &'a [u8], name: &str) -> Result<Cow<'a, [u8]>, IoError> {
    let (mut unpacked, truncated, corrupt): (Box<dyn Read + '_>, _, _) = if bytes.starts_with(b"\x1f\x8b") {
        (Box::new(MultiGzDecoder::new(bytes)), IoErrorKind::GzipTruncated, IoErrorKind::GzipCorrupt)
    } else if is_bzip2(bytes) {
        (Box::new(MultiBzDecoder::new(bytes)), IoErrorKind::Bzip2Truncated, IoErrorKind::Bzip2Corrupt)
    } else {
        return Ok(Cow::Borrowed(bytes));
    };
    let mut text = Vec::new();
    let limit = UNPACKED_AT_LEAST + UNPACKED_FACTOR * bytes.len() as u64;
    match unpacked.as_mut().take(limit + 1).read_to_end(&mut text) {
        Ok(length) if length as u64 > limit => {
            Err(IoError { name: name.into(), place: None, kind: IoErrorKind::TooLarge { limit } })
        }
        Ok(_) => Ok(Cow::Owned(text)),
        Err(error) => {
            let early = error.kind() == ErrorKind::UnexpectedEof;
            let kind = if early { truncated } else { corrupt };
            Err(IoError { name: name.into(), place: None, kind })
        }
    }
}

/// The magic of a bzip2 stream: its version, the size of its blocks, and how a block or an empty stream starts.
fn is_bzip2(bytes: &[u8]) -> bool {
    bytes.starts_with(b"BZh")
        && bytes.get(3).is_some_and(u8::is_ascii_digit)
        && bytes.get(4..10).is_some_and(|start| start == b"1AY&SY" || start == b"\x17\x72\x45\x38\x50\x90")
}

/// Refuses to drop what `format` cannot hold: the first of `(what, count)` that is not zero.
fn refuse(format: Format, contents: &[(&'static str, usize)]) -> Result<(), WriteError> {
    match contents.iter().find(|(_, count)| *count > 0) {
        Some(&(what, count)) => Err(WriteError::Unrepresentable { format, what, count }),
        None => Ok(()),
    }
}

fn sniff(source: Source<'_>) -> Format {
    let mut format = Format::G2o;
    for fields in source.lines() {
        match fields.tag {
            tag if pyfg::LAYOUTS.iter().any(|(known, _)| known.as_bytes() == tag) && fields.has_names() => {
                return Format::Pyfg;
            }
            b"VERTEX2" | b"VERTEX3" => return Format::Toro,
            b"ODOMETRY" | b"LANDMARK" | b"POINT3" => return Format::Isam,
            b"EDGE2" | b"EDGE3" => format = Format::Isam, // unless vertices follow
            tag if g2o::LAYOUTS.iter().any(|(known, _)| known.as_bytes() == tag) => return Format::G2o,
            _ => {}
        }
    }
    format
}

/// Refuses a file without content, and ids that are given twice.
fn check_content(source: Source<'_>, graph: &PoseGraph) -> Result<(), IoError> {
    if graph.vertex_count() == 0 && graph.constraints().next().is_none() {
        return Err(source.fail(IoErrorKind::Empty { unknown: graph.other.len() }));
    }
    let offsets2 = graph.offsets2.iter().map(|o| (o.id, o.line));
    let offsets = offsets2.chain(graph.offsets3.iter().map(|o| (o.id, o.line)));
    let vertices = graph.vertices().map(|(id, _, line)| (id, line));
    match first_repeated(vertices).or_else(|| first_repeated(offsets)) {
        Some((id, first, second)) => Err(at_id(source, second, IoErrorKind::DuplicateId { id, first })),
        None => Ok(()),
    }
}

/// The first line that repeats an id: `(id, line of the first, line)`.
fn first_repeated(ids: impl Iterator<Item = (u64, Line)>) -> Option<(u64, u32, u32)> {
    let mut ids: Vec<(u64, u32)> = ids.map(|(id, line)| (id, line.0)).collect();
    ids.sort_unstable();
    let repeated = ids.windows(2).filter(|pair| pair[0].0 == pair[1].0);
    repeated.map(|pair| (pair[0].0, pair[0].1, pair[1].1)).min_by_key(|(_, _, second)| *second)
}

/// An error at the first field of a line that was read before.
fn at_id(source: Source<'_>, line: u32, kind: IoErrorKind) -> IoError {
    let Some(mut fields) = source.lines().find(|fields| fields.line().0 == line) else {
        return source.fail(kind);
    };
    if fields.has_names() && fields.name().or_else(|_| fields.name()).is_ok() {
        return fields.fail(kind); // PyFG: the name, before it the time
    }
    match fields.id() {
        Ok(_) => fields.fail(kind),
        Err(_) => source.fail(kind), // It was read before.
    }
}

/// An error at a byte that no text holds.
fn not_text(source: Source<'_>, at: usize) -> IoError {
    let kind = IoErrorKind::NotText { byte: source.text[at] };
    let (mut line, mut start) = (0, 0);
    for before in source.text[..at].split(|&b| b == b'\n') {
        (line, start) = (line + 1, at - before.len());
    }
    let column = (at - start + 1) as u32;
    let place = Place { line, column, field: 0, span: at..at + 1, tag: String::new(), layout: None };
    IoError { name: source.name.into(), place: Some(place), kind }
}
