//! PCD, version 0.7.

use super::fields::{Binary, Line, Lines, Number};
use super::header::{Count, Property, Record, Role, length};
use super::lzf::unpacked;
use super::{File, Points};
use crate::io::error::{IoError, IoErrorKind};

/// How the body is written.
enum Encoding {
    Ascii,
    Binary,
    Compressed,
}

/// The lines of the header as they stand.
#[derive(Default)]
struct Header {
    fields: Vec<String>,
    sizes: Vec<usize>,
    types: Vec<String>,
    counts: Vec<usize>,
    width: Option<usize>,
    height: Option<usize>,
    points: Option<usize>,
}

const ENCODINGS: &str = "ascii, binary or binary_compressed";

pub(super) fn read(file: File<'_>, points: &mut Points) -> Result<(), IoError> {
    let mut lines = Lines::new(file);
    let (encoding, header) = header(file, &mut lines)?;
    let record = header.record(file)?;
    let (true, spatial) = record.coordinates() else { return Err(file.fail(IoErrorKind::NoCoordinates)) };
    points.planar = !spatial;
    let count = header.count(file)?;
    let mut bytes = Binary::new(file, lines.at, false);
    match encoding {
        Encoding::Ascii => record.ascii_records(file, &mut lines, count, |point| points.push(point)),
        Encoding::Binary => record.binary_points(&mut bytes, count, points),
        Encoding::Compressed => compressed(file, &mut bytes, &record, count, points),
    }
}

/// The columns x, y and z of a packed body, which stores all of the first field, then all of the next.
fn compressed(
    file: File<'_>,
    bytes: &mut Binary<'_>,
    record: &Record,
    count: usize,
    points: &mut Points,
) -> Result<(), IoError> {
    let mut length = || bytes.number(Number::U32).map(length);
    let (packed, size) = (length()?, length()?);
    let body = unpacked(bytes.take(packed)?, size).ok_or_else(|| file.fail(IoErrorKind::LzfCorrupt))?;
    let unpacked = File { name: file.name, bytes: &body };
    Binary::new(unpacked, 0, false).check_room(count, record.size())?;
    let mut all = vec![[0.0; 3]; count];
    let mut at = 0;
    for property in &record.properties {
        if let Role::Coordinate(axis) = property.role {
            let mut column = Binary::new(unpacked, at, false);
            for point in &mut all {
                point[axis] = column.number(property.number)?;
            }
        }
        at += count * property.size(); // has room: checked above
    }
    all.into_iter().for_each(|point| points.push(point));
    Ok(())
}

fn header(file: File<'_>, lines: &mut Lines<'_>) -> Result<(Encoding, Header), IoError> {
    let mut header = Header::default();
    for mut line in lines {
        line.check_text()?;
        if line.is_comment_or_blank() {
            continue;
        }
        match line.word() {
            Some("FIELDS" | "COLUMNS") => header.fields = words(&mut line),
            Some("SIZE") => header.sizes = wholes(&mut line, "a size in bytes")?,
            Some("TYPE") => header.types = words(&mut line),
            Some("COUNT") => header.counts = wholes(&mut line, "a count")?,
            Some("WIDTH") => header.width = Some(line.whole("the number of points in a row")?),
            Some("HEIGHT") => header.height = Some(line.whole("the number of rows")?),
            Some("POINTS") => header.points = Some(line.whole("the number of points")?),
            Some("VERSION" | "VIEWPOINT") => {}
            Some("DATA") => return Ok((encoding(&mut line)?, header)),
            _ => {
                let expected = "VERSION, FIELDS, SIZE, TYPE, COUNT, WIDTH, HEIGHT, VIEWPOINT, POINTS or DATA";
                return Err(line.fail(IoErrorKind::UnknownWord { found: line.found() }, expected));
            }
        }
    }
    Err(file.fail(IoErrorKind::HeaderOpen { end: "DATA" }))
}

fn encoding(line: &mut Line<'_>) -> Result<Encoding, IoError> {
    match line.word() {
        Some("ascii") => Ok(Encoding::Ascii),
        Some("binary") => Ok(Encoding::Binary),
        Some("binary_compressed") => Ok(Encoding::Compressed),
        Some(_) => Err(line.fail(IoErrorKind::UnknownWord { found: line.found() }, ENCODINGS)),
        None => Err(line.missing(ENCODINGS)),
    }
}

fn words(line: &mut Line<'_>) -> Vec<String> {
    core::iter::from_fn(|| line.word().map(str::to_owned)).collect()
}

fn wholes(line: &mut Line<'_>, expected: &'static str) -> Result<Vec<usize>, IoError> {
    let mut numbers = vec![];
    while line.clone().field().is_some() {
        numbers.push(line.whole(expected)?);
    }
    Ok(numbers)
}

impl Header {
    /// POINTS, else WIDTH × HEIGHT.
    fn count(&self, file: File<'_>) -> Result<usize, IoError> {
        let area = self.width.map(|width| width.saturating_mul(self.height.unwrap_or(1)));
        self.points.or(area).ok_or_else(|| file.fail(IoErrorKind::HeaderLacks { what: "POINTS" }))
    }

    /// FIELDS, SIZE, TYPE and COUNT, which must be equally many.
    fn record(&self, file: File<'_>) -> Result<Record, IoError> {
        let n = self.fields.len();
        let lengths = [("FIELDS", n), ("SIZE", self.sizes.len()), ("TYPE", self.types.len())];
        let counts = if self.counts.is_empty() { n } else { self.counts.len() };
        let lengths = lengths.into_iter().chain([("COUNT", counts)]);
        if let Some((what, _)) = lengths.into_iter().find(|(_, length)| *length != n || *length == 0) {
            return Err(file.fail(IoErrorKind::HeaderLacks { what }));
        }
        let property = |i: usize| {
            let number = number(&self.types[i], self.sizes[i])
                .ok_or_else(|| file.fail(IoErrorKind::NumberType { size: self.sizes[i] }))?;
            let count = self.counts.get(i).copied().unwrap_or(1);
            let role = if count == 1 { Role::of(&self.fields[i]) } else { Role::Other };
            Ok(Property { role, number, count: Count::Fixed(count) })
        };
        Ok(Record { properties: (0..n).map(property).collect::<Result<_, IoError>>()? })
    }
}

fn number(kind: &str, size: usize) -> Option<Number> {
    match (kind, size) {
        ("I", 1) => Some(Number::I8),
        ("I", 2) => Some(Number::I16),
        ("I", 4) => Some(Number::I32),
        ("I", 8) => Some(Number::I64),
        ("U", 1) => Some(Number::U8),
        ("U", 2) => Some(Number::U16),
        ("U", 4) => Some(Number::U32),
        ("U", 8) => Some(Number::U64),
        ("F", 4) => Some(Number::F32),
        ("F", 8) => Some(Number::F64),
        _ => None,
    }
}
