//! What can be wrong with a file, and with a graph that should become one.

use super::Format;
use crate::pose_graph::{Label, Line};
use core::{fmt, ops::Range};

/// A file that cannot be read: which one, where in it, and why.
///
/// Prints as `name:line:column: why`; [`IoError::help`] says what to do.
#[derive(Clone, Debug, PartialEq)]
pub struct IoError {
    /// The name that was given to the reader.
    pub name: String,
    /// Where, unless the file as a whole is at fault.
    pub place: Option<Place>,
    /// Why.
    pub kind: IoErrorKind,
}

/// A place in a file, after decompression (see [`super::decompress`]).
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Line, from 1.
    pub line: u32,
    /// Byte in the line, from 1.
    pub column: u32,
    /// Field in the line, from 0, the tag.
    pub field: u32,
    /// Bytes in the text.
    pub span: Range<usize>,
    /// First word of the line; empty in formats whose lines have none.
    pub tag: String,
    /// The fields of such a line, where the tag is known; without a tag, what was expected.
    pub layout: Option<&'static str>,
}

impl Place {
    /// What the layout calls the field.
    pub fn expected(&self) -> Option<&'static str> {
        let layout = self.layout?;
        if self.tag.is_empty() {
            return Some(layout); // lines without tags: what the one field should be
        }
        let last = layout.rsplit(' ').next();
        layout.split(' ').nth(self.field.checked_sub(1)? as usize).or(last)
    }
}

/// Why a file cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum IoErrorKind {
    /// The gzip stream stops before its end.
    #[error("the gzip file ends early")]
    GzipTruncated,
    /// The gzip stream does not decode, or its checksum is wrong.
    #[error("the gzip file is corrupt")]
    GzipCorrupt,
    /// A byte that no text holds.
    #[error("this is not a text file (byte 0x{byte:02x})")]
    NotText {
        /// The byte.
        byte: u8,
    },
    /// No vertex and no measurement.
    #[error("no vertex and no edge in this file ({unknown} lines with unknown tags)")]
    Empty {
        /// How many lines have an unknown tag.
        unknown: usize,
    },
    /// The line ends before its last field.
    #[error("the line ends too early")]
    MissingField,
    /// Fields are left over.
    #[error("the line goes on after its last field, with `{found}`")]
    TooManyFields {
        /// The first field too many.
        found: Box<str>,
    },
    /// Not a number.
    #[error("`{found}` is not a number")]
    NotANumber {
        /// The field.
        found: Box<str>,
    },
    /// NaN, infinite, or too large for a 64-bit float.
    #[error("`{found}` is not a finite number")]
    NotFinite {
        /// The field.
        found: Box<str>,
    },
    /// Not a whole number.
    #[error("`{found}` is not an id")]
    NotAnId {
        /// The field.
        found: Box<str>,
    },
    /// Below zero.
    #[error("the id {found} is negative")]
    NegativeId {
        /// The field.
        found: Box<str>,
    },
    /// Above 2⁶⁴ − 1.
    #[error("the id {found} is too large")]
    HugeId {
        /// The field.
        found: Box<str>,
    },
    /// Not a letter and a number.
    #[error("`{found}` is not a name")]
    NotAName {
        /// The field.
        found: Box<str>,
    },
    /// A matrix that is no covariance.
    #[error("the covariance is not positive definite")]
    NoCovariance,
    /// A quaternion without direction.
    #[error("the quaternion is zero")]
    ZeroQuaternion,
    /// A time that is none.
    #[error("`{found}` is not a time")]
    NotATime {
        /// The field.
        found: Box<str>,
    },
    /// A clock that was set back, or two recordings in one file.
    #[error("time runs back by {}.{:03} s", .milliseconds / 1000, .milliseconds % 1000)]
    TimeRunsBack {
        /// By how much.
        milliseconds: i64,
    },
    /// A log without a sample.
    #[error("no row of {format} in this file ({incomplete} rows with NaN, infinite or absent numbers)")]
    NoSamples {
        /// What was looked for.
        format: &'static str,
        /// Rows that were left out.
        incomplete: u32,
    },
    /// A log whose header does not name a column.
    #[error("no column is called {name}")]
    MissingColumn {
        /// The column.
        name: &'static str,
    },
    /// A packed file that grows beyond all measure.
    #[error("the packed file unpacks to more than {limit} bytes")]
    TooLarge {
        /// What is read at most.
        limit: u64,
    },
    /// A vertex or sensor offset that was already given.
    #[error("{} was already given in line {first}", Label(*id))]
    DuplicateId {
        /// The id.
        id: u64,
        /// The line that gave it first.
        first: u32,
    },
    /// A cloud without any point that is finite.
    #[error("no points in this file ({dropped} with coordinates that are not finite)")]
    NoPoints {
        /// How many points have a coordinate that is NaN or infinite.
        dropped: usize,
    },
    /// A length that no number of points has.
    #[error("{bytes} bytes are no whole number of points of three or four 32-bit floats")]
    NotPoints {
        /// Length of the file.
        bytes: usize,
    },
    /// The bytes end before what the header promises.
    #[error("the file ends at byte {offset}, {missing} bytes before what its header promises")]
    Truncated {
        /// Length of the file.
        offset: usize,
        /// How many bytes are missing, at least.
        missing: usize,
    },
    /// The lines end before what the header promises.
    #[error("the file ends after {given} of {promised} lines that its header promises")]
    TooFewLines {
        /// How many there are.
        given: usize,
        /// How many should be.
        promised: usize,
    },
    /// A word that the header of a cloud cannot have there.
    #[error("`{found}` cannot stand here")]
    UnknownWord {
        /// The word.
        found: Box<str>,
    },
    /// A header that does not end.
    #[error("the header has no `{end}`")]
    HeaderOpen {
        /// What should end it.
        end: &'static str,
    },
    /// A line of the header that is missing, or has another number of entries than the others.
    #[error("`{what}` is missing in the header, or has not one entry per field")]
    HeaderLacks {
        /// First word of the line.
        what: &'static str,
    },
    /// A type of numbers that does not exist.
    #[error("no number of the given type has {size} bytes")]
    NumberType {
        /// What SIZE says.
        size: usize,
    },
    /// A header without coordinates.
    #[error("the points have no x and y")]
    NoCoordinates,
    /// The compressed body does not decode.
    #[error("the compressed points are corrupt")]
    LzfCorrupt,
    /// The bzip2 stream stops before its end.
    #[error("the bzip2 file ends early")]
    Bzip2Truncated,
    /// The bzip2 stream does not decode, or its checksum is wrong.
    #[error("the bzip2 file is corrupt")]
    Bzip2Corrupt,
    /// The numbers end before what the header promises.
    #[error("the file ends where its header promises {expected}")]
    EndsEarly {
        /// What should follow.
        expected: &'static str,
    },
    /// An observation by a camera that does not exist.
    #[error("there is no camera {number}: the header promises {count}, counted from 0")]
    NoSuchCamera {
        /// Its number.
        number: u32,
        /// How many there are.
        count: u32,
    },
    /// An observation of a point that does not exist.
    #[error("there is no point {number}: the header promises {count}, counted from 0")]
    NoSuchPoint {
        /// Its number.
        number: u32,
        /// How many there are.
        count: u32,
    },
}

impl IoErrorKind {
    fn is_about_one_field(&self) -> bool {
        use IoErrorKind::{
            HugeId, MissingField, NegativeId, NotAName, NotANumber, NotATime, NotAnId, NotFinite, UnknownWord,
        };
        matches!(
            self,
            MissingField
                | NotANumber { .. }
                | NotFinite { .. }
                | NotATime { .. }
                | NotAnId { .. }
                | NotAName { .. }
                | NegativeId { .. }
                | HugeId { .. }
                | UnknownWord { .. }
        )
    }
}

impl fmt::Display for IoError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.name)?;
        let Some(place) = &self.place else { return write!(f, " {}", self.kind) };
        write!(f, "{}:{}: {}", place.line, place.column, self.kind)?;
        match place.expected().filter(|_| self.kind.is_about_one_field()) {
            Some(expected) if place.tag.is_empty() => write!(f, "; expected {expected}"),
            Some(expected) => write!(f, "; expected {expected} in field {} of {}", place.field, place.tag),
            None => Ok(()),
        }
    }
}

impl core::error::Error for IoError {}

impl From<Box<IoError>> for IoError {
    fn from(error: Box<IoError>) -> Self {
        *error
    }
}

impl IoError {
    /// What to do about it.
    pub fn help(&self) -> String {
        match &self.kind {
            IoErrorKind::GzipTruncated | IoErrorKind::Bzip2Truncated => "fetch or copy the file again; it was cut off".into(),
            IoErrorKind::GzipCorrupt => "fetch or copy the file again; `gzip -t` must accept it".into(),
            IoErrorKind::Bzip2Corrupt => "fetch or copy the file again; `bzip2 -t` must accept it".into(),
            IoErrorKind::EndsEarly { .. } => "fetch or copy the file again; it was cut off, or its first line is wrong".into(),
            IoErrorKind::NoSuchCamera { .. } | IoErrorKind::NoSuchPoint { .. } => {
                "the first line of the file must say: cameras points observations; all numbers count from 0".into()
            }
            IoErrorKind::NotText { .. } => {
                "pose graphs are plain or gzip text in g2o, TORO, iSAM or PyFG format".into()
            }
            IoErrorKind::Empty { .. } => {
                "lines of a pose graph start with a tag such as VERTEX_SE2 or EDGE_SE3:QUAT".into()
            }
            IoErrorKind::ZeroQuaternion => "give a unit quaternion; 0 0 0 1 is no rotation".into(),
            IoErrorKind::DuplicateId { .. } => {
                "ids count poses and points together; renumber or delete one".into()
            }
            IoErrorKind::NotFinite { .. } => {
                "remove the line or correct the program that wrote it; no estimate can come from it".into()
            }
            IoErrorKind::NegativeId { .. } | IoErrorKind::HugeId { .. } | IoErrorKind::NotAnId { .. } => {
                "ids are whole numbers from 0 to 18446744073709551615".into()
            }
            IoErrorKind::NotAName { .. } => "names are a letter and a number: A0 is a pose, L0 a landmark".into(),
            IoErrorKind::NoCovariance => {
                "a covariance is a symmetric matrix of positive eigenvalues, its upper triangle row by row; no number in it may be rounded to 0"
                    .into()
            }
            IoErrorKind::NotATime { .. } => "a time is a decimal number of seconds, or whole nanoseconds in EuRoC's files".into(),
            IoErrorKind::TimeRunsBack { .. } => {
                "was the clock set back, or are these two recordings? Cut the file there; less than a second would be sorted"
                    .into()
            }
            IoErrorKind::NoSamples { .. } => "is it the right file? Compare its first lines with the format's".into(),
            IoErrorKind::MissingColumn { .. } => self.columns_help(),
            IoErrorKind::TooLarge { .. } => "unpack it with `gzip -d` or `bzip2 -d` if it is meant to be so large".into(),
            IoErrorKind::NoPoints { .. }
            | IoErrorKind::UnknownWord { .. }
            | IoErrorKind::HeaderOpen { .. }
            | IoErrorKind::HeaderLacks { .. }
            | IoErrorKind::NumberType { .. }
            | IoErrorKind::NoCoordinates => {
                "point clouds are PLY, PCD, lines of two or three numbers, or KITTI's .bin, plain or gzip"
                    .into()
            }
            IoErrorKind::NotPoints { .. }
            | IoErrorKind::Truncated { .. }
            | IoErrorKind::TooFewLines { .. }
            | IoErrorKind::LzfCorrupt => "fetch or copy the file again; it was cut off or damaged".into(),
            IoErrorKind::MissingField
            | IoErrorKind::TooManyFields { .. }
            | IoErrorKind::NotANumber { .. } => self.layout_help(),
        }
    }

    fn columns_help(&self) -> String {
        let fields = self.place.as_ref().and_then(|place| place.layout).unwrap_or_default();
        format!("a line before the numbers must name the columns, among them, in any order: {fields}")
    }

    fn layout_help(&self) -> String {
        match &self.place {
            Some(Place { tag, layout: Some(layout), .. }) if !tag.is_empty() => {
                format!("such a line reads: {tag} {layout}")
            }
            _ => "compare the line with its neighbours".into(),
        }
    }
}

/// Why a graph cannot be written in a format.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// A number is NaN or infinite; no reader would take the file.
    #[error("{tag} of {}: a number is NaN or infinite; was the solution accepted although it diverged?", Label(*id))]
    NotFinite {
        /// The tag of the line.
        tag: &'static str,
        /// The vertex, the first vertex of the edge, or the sensor offset.
        id: u64,
    },
    /// The format has no such lines.
    #[error("{format} has no lines for {count} × {what}; write g2o, or remove them first")]
    Unrepresentable {
        /// The format.
        format: Format,
        /// What it cannot hold.
        what: &'static str,
        /// How many there are.
        count: usize,
    },
    /// A line that was kept because its tag was unknown would not be in this format.
    #[error("line {} is a {tag}, which was kept unread, but {format} knows such lines; remove it, or read the file as {format}", line.0)]
    Foreign {
        /// The format.
        format: Format,
        /// The tag of the line.
        tag: Box<str>,
        /// Where it was read.
        line: Line,
    },
    /// iSAM stores a square root of the information and PyFG its inverse: it must be positive definite.
    #[error("{tag} of {}: the information matrix is not positive definite, so it has no square root and no inverse", Label(*id))]
    NotPositiveDefinite {
        /// The tag of the line.
        tag: &'static str,
        /// The first vertex of the edge.
        id: u64,
    },
}
