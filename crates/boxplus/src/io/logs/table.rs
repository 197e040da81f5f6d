//! Lines of numbers with a time: one reader for all of them.

use super::super::error::{IoError, IoErrorKind, Place};
use super::super::{decompress, not_text, scan};
use super::stamp::Stamp;
use crate::recording::{Log, Oddity, Stamped};
use core::ops::Range;

/// Rows may be out of order by less than this, in nanoseconds: messages overtake each other on their way. A clock that was set back is
/// another thing: sorting would shuffle two recordings into one.
const OVERTAKING_NS: i64 = 1_000_000_000;
/// A step so many times the median is a gap.
const GAP: i64 = 5;
/// The fastest that gyroscopes of robots measure: 2000°/s, in rad/s.
const FASTEST: f64 = 35.0;
/// Quaternions printed with four digits are off by less.
const ROUGH: f64 = 1e-3;
/// Specific forces of a body that does not fall all the time are longer, in m/s².
const LIGHTEST: f64 = 3.0;

/// What a number of a log is, so that wrong units are noticed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Anything.
    Any,
    /// An angle in radians.
    Angle,
    /// An angular rate in rad/s.
    Rate,
    /// A component of a specific force in m/s²; the first three of them are one vector.
    Force,
    /// A component of a unit quaternion; the first four of them are one.
    Quaternion,
}

/// How the rows of a log are laid out: a time, then N numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout<const N: usize> {
    /// Its name, for errors.
    pub format: &'static str,
    /// What the time is.
    pub stamp: Stamp,
    /// The names of the fields, with blanks between: the time, where there is one, and the N numbers.
    pub fields: &'static str,
    /// Whether columns are found by these names in a header, in any order and among others; else by their places.
    pub named: bool,
    /// What the numbers are.
    pub units: [Unit; N],
}

impl<const N: usize> Layout<N> {
    /// The first number that no angle or rate in radians is likely to be, and its name.
    fn suspicious(&self, numbers: &[f64; N]) -> Option<(&'static str, f64)> {
        let names = self.fields.split(' ').skip(usize::from(self.stamp.has_column()));
        let limit = |unit: &Unit| match unit {
            Unit::Angle => core::f64::consts::TAU,
            Unit::Rate => FASTEST,
            Unit::Any | Unit::Force | Unit::Quaternion => f64::INFINITY,
        };
        let mut all = names.zip(self.units.iter().zip(numbers));
        all.find(|(_, (unit, x))| x.abs() > limit(unit)).map(|(name, (_, x))| (name, *x))
    }

    /// The length of the vector of all numbers of a unit, if there are `dimension` of them or more.
    fn norm(&self, unit: Unit, dimension: usize, numbers: &[f64; N]) -> Option<f64> {
        let all = || self.units.iter().zip(numbers).filter(|(u, _)| **u == unit).map(|(_, x)| x);
        (all().count() >= dimension).then(|| all().take(dimension).map(|x| x * x).sum::<f64>().sqrt())
    }
}

/// Reads rows of numbers and makes of each what `make` makes of it. Separated by commas, semicolons or blanks, whichever the first
/// rows use; plain or gzip; lines that start with `#` and titles before the first row are skipped. `name` appears in errors.
///
/// Rows with NaN, infinite or absent numbers are left out, rows out of order by less than a second are sorted; gaps and suspicious
/// units are told: [`Log::oddities`].
///
/// ```
/// use boxplus::io::{Layout, Stamp, Unit, read_log};
/// let layout = Layout {
///     format: "thermometer", stamp: Stamp::Seconds, fields: "time celsius", named: true, units: [Unit::Any],
/// };
/// let text = "station,time,celsius\n7,0.5,20.1\n7,1.5,nan\n7,2.5,20.4\n";
/// let log = read_log(text.as_bytes(), "day.csv", &layout, |[celsius]| Ok(celsius + 273.15))?;
/// assert_eq!((log.samples.len(), log.samples[1].stamp_ns), (2, 2_500_000_000));
/// assert_eq!(log.oddities[0].to_string(), "line 3: 1 rows with NaN, infinite or absent numbers; left out");
/// # Ok::<(), boxplus::io::IoError>(())
/// ```
///
/// # Errors
/// [`IoError`]: not text, no row, a field that is no number or not there, a time that is none or runs back by a second or more,
/// and what `make` refuses.
pub fn read_log<T, const N: usize>(
    bytes: &[u8],
    name: &str,
    layout: &Layout<N>,
    mut make: impl FnMut([f64; N]) -> Result<T, IoErrorKind>,
) -> Result<Log<T>, IoError> {
    let text = decompress(bytes, name)?;
    let mut rows = Rows::new(&text, name, layout)?;
    let mut read = Collected::new(layout);
    while let Some(row) = rows.next_row()? {
        match row.numbers {
            Some(numbers) => {
                let value = make(numbers).map_err(|kind| rows.fail(&row.whole, 0, kind))?;
                read.push(row.line, row.stamp_ns, &numbers, value);
            }
            None => read.missing(row.line),
        }
    }
    read.into_log(&rows)
}

/// One row: where it is, when, and its numbers unless one of them is missing.
struct Row<const N: usize> {
    line: u32,
    whole: Range<usize>,
    stamp_ns: i64,
    numbers: Option<[f64; N]>,
}

/// The rows of a text.
struct Rows<'a, const N: usize> {
    text: &'a [u8],
    name: &'a str,
    layout: &'a Layout<N>,
    separator: Option<u8>,
    /// The column of each field of the layout.
    columns: Vec<usize>,
    at: usize,
    line: u32,
    row: i64,
    started: bool,
    cells: Vec<Range<usize>>,
}

impl<'a, const N: usize> Rows<'a, N> {
    fn new(text: &'a [u8], name: &'a str, layout: &'a Layout<N>) -> Result<Self, IoError> {
        let source = scan::Source { name, text, layouts: &[] };
        if let Some(at) = text.iter().position(|&b| b == 0) {
            return Err(not_text(source, at));
        }
        let at = if text.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        let count = N + usize::from(layout.stamp.has_column());
        let mut rows = Self {
            text,
            name,
            layout,
            separator: None,
            columns: (0..count).collect(),
            at,
            line: 0,
            row: 0,
            started: false,
            cells: Vec::new(),
        };
        if layout.named {
            rows.find_header()?;
        }
        Ok(rows)
    }

    /// The first line that has all names.
    fn find_header(&mut self) -> Result<(), IoError> {
        let mut missing = None;
        while let Some(whole) = self.next_line() {
            self.separator = separator(&self.text[whole.clone()]);
            self.split(whole);
            let place = |name: &str| self.cells.iter().position(|cell| self.title(cell) == name.as_bytes());
            let found: Vec<_> = self.layout.fields.split(' ').map(|name| (name, place(name))).collect();
            match found.iter().find(|(_, place)| place.is_none()) {
                None => {
                    self.columns = found.into_iter().filter_map(|(_, place)| place).collect();
                    return Ok(());
                }
                // Of a line that has none of the names, nothing is missing.
                Some((name, _)) if found.iter().any(|(_, place)| place.is_some()) => missing = Some(*name),
                Some(_) => {}
            }
        }
        let name = missing.or_else(|| self.layout.fields.split(' ').next()).unwrap_or_default();
        Err(self.fail_line(1, IoErrorKind::MissingColumn { name }))
    }

    /// A cell of a header: EuRoC's starts with `#`.
    fn title(&self, cell: &Range<usize>) -> &[u8] {
        let cell = &self.text[cell.clone()];
        cell.strip_prefix(b"#").unwrap_or(cell).trim_ascii()
    }

    fn next_line(&mut self) -> Option<Range<usize>> {
        if self.at >= self.text.len() {
            return None;
        }
        let start = self.at;
        let rest = &self.text[start..];
        let end = start + rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.at = end + 1;
        self.line = self.line.saturating_add(1);
        Some(start..end)
    }

    /// Cells of a line, without the blanks around them.
    fn split(&mut self, line: Range<usize>) {
        self.cells.clear();
        let bytes = &self.text[line.clone()];
        let blank = self.separator.is_none();
        let is_end = |b: &u8| if blank { b.is_ascii_whitespace() } else { Some(*b) == self.separator };
        let mut start = line.start;
        for cell in bytes.split(is_end) {
            let trimmed = cell.trim_ascii_start();
            let first = start + cell.len() - trimmed.len();
            if !(blank && trimmed.is_empty()) {
                self.cells.push(first..first + trimmed.trim_ascii_end().len());
            }
            start += cell.len() + 1;
        }
    }

    fn next_row(&mut self) -> Result<Option<Row<N>>, IoError> {
        while let Some(whole) = self.next_line() {
            let bytes = self.text[whole.clone()].trim_ascii();
            if bytes.is_empty() || bytes[0] == b'#' {
                continue;
            }
            if !self.started {
                self.separator = separator(bytes);
            }
            self.split(whole.clone());
            if !self.started && self.is_title() {
                continue;
            }
            self.started = true;
            return self.parsed(whole).map(Some);
        }
        Ok(None)
    }

    /// Whether no cell is a number.
    fn is_title(&self) -> bool {
        self.cells.iter().all(|cell| number(&self.text[cell.clone()]).is_none())
    }

    fn parsed(&mut self, whole: Range<usize>) -> Result<Row<N>, IoError> {
        let first = usize::from(self.layout.stamp.has_column());
        let stamp_ns = match self.columns.first().filter(|_| first == 1) {
            Some(&column) => self.stamp(column)?,
            None => self.layout.stamp.of_row(self.row),
        };
        self.row += 1;
        let mut numbers = Some([0.0; N]);
        for (i, &column) in self.columns[first..].iter().enumerate() {
            let cell = self.cell(column, first + i)?;
            let bytes = &self.text[cell.clone()];
            let x = if bytes.is_empty() { Some(f64::NAN) } else { number(bytes) };
            let Some(x) = x else {
                return Err(self.fail(&cell, first + i + 1, IoErrorKind::NotANumber { found: found(bytes) }));
            };
            numbers = numbers.filter(|_| x.is_finite());
            if let Some(place) = numbers.as_mut().and_then(|n| n.get_mut(i)) {
                *place = x;
            }
        }
        self.check_end()?;
        Ok(Row { line: self.line, whole, stamp_ns, numbers })
    }

    fn stamp(&self, column: usize) -> Result<i64, IoError> {
        let cell = self.cell(column, 0)?;
        let bytes = &self.text[cell.clone()];
        let kind = || IoErrorKind::NotATime { found: found(bytes) };
        self.layout.stamp.parse(bytes).ok_or_else(|| self.fail(&cell, 1, kind()))
    }

    /// The cell in a column, which must exist.
    fn cell(&self, column: usize, field: usize) -> Result<Range<usize>, IoError> {
        if let Some(cell) = self.cells.get(column) {
            return Ok(cell.clone());
        }
        let end = self.cells.last().map_or(0, |cell| cell.end);
        Err(self.fail(&(end..end), field + 1, IoErrorKind::MissingField))
    }

    /// Nothing may follow where places count.
    fn check_end(&self) -> Result<(), IoError> {
        let further = self.cells.iter().skip(self.columns.len()).find(|cell| !cell.is_empty());
        match further.filter(|_| !self.layout.named) {
            Some(cell) => {
                let found = found(&self.text[cell.clone()]);
                Err(self.fail(cell, self.columns.len() + 1, IoErrorKind::TooManyFields { found }))
            }
            None => Ok(()),
        }
    }

    /// An error at a place of the line that was read last.
    fn fail(&self, span: &Range<usize>, field: usize, kind: IoErrorKind) -> IoError {
        let before = &self.text[..span.start];
        let start = before.iter().rposition(|&b| b == b'\n').map_or(0, |i| i + 1);
        self.fail_in_line(self.line, start, span, field, kind)
    }

    fn fail_in_line(
        &self,
        line: u32,
        start: usize,
        span: &Range<usize>,
        field: usize,
        kind: IoErrorKind,
    ) -> IoError {
        let place = Place {
            line,
            column: (span.start - start + 1) as u32,
            field: field as u32,
            span: span.clone(),
            tag: self.layout.format.to_owned(),
            layout: Some(self.layout.fields),
        };
        IoError { name: self.name.into(), place: Some(place), kind }
    }

    /// An error about a line that was read before.
    fn fail_line(&self, line: u32, kind: IoErrorKind) -> IoError {
        let skipped = line.saturating_sub(1) as usize;
        let start = match skipped.checked_sub(1) {
            Some(nth) => {
                let ends = self.text.iter().enumerate().filter(|(_, b)| **b == b'\n');
                ends.map(|(i, _)| i + 1).nth(nth).unwrap_or(0)
            }
            None => 0,
        };
        let length = self.text[start..].iter().position(|&b| b == b'\n');
        let end = length.map_or(self.text.len(), |n| start + n);
        self.fail_in_line(line, start, &(start..end), 0, kind)
    }
}

/// The separator that a line uses: `None` is white space.
fn separator(line: &[u8]) -> Option<u8> {
    [b';', b','].into_iter().find(|separator| line.contains(separator))
}

/// A number, finite or not.
fn number(cell: &[u8]) -> Option<f64> {
    core::str::from_utf8(cell).ok()?.parse().ok()
}

fn found(cell: &[u8]) -> Box<str> {
    scan::shorten(cell).into()
}

/// Rows that were read, and what to say about them.
struct Collected<'a, T, const N: usize> {
    layout: &'a Layout<N>,
    samples: Vec<(Stamped<T>, u32)>,
    degrees: Option<Oddity>,
    /// `(rows, first line)` with a number missing, and with a quaternion of another norm.
    missing: (usize, u32),
    rough: (usize, u32),
    forces: Vec<f64>,
}

impl<'a, T, const N: usize> Collected<'a, T, N> {
    fn new(layout: &'a Layout<N>) -> Self {
        let (missing, rough) = ((0, 0), (0, 0));
        Self { layout, samples: Vec::new(), degrees: None, missing, rough, forces: Vec::new() }
    }

    fn missing(&mut self, line: u32) {
        count(&mut self.missing, line);
    }

    fn push(&mut self, line: u32, stamp_ns: i64, numbers: &[f64; N], value: T) {
        self.samples.push((Stamped { stamp_ns, value }, line));
        if self.degrees.is_none() {
            self.degrees =
                self.layout.suspicious(numbers).map(|(field, value)| Oddity::Degrees { field, line, value });
        }
        self.forces.extend(self.layout.norm(Unit::Force, 3, numbers));
        if self.layout.norm(Unit::Quaternion, 4, numbers).is_some_and(|norm| (norm - 1.0).abs() > ROUGH) {
            count(&mut self.rough, line);
        }
    }

    fn into_log(mut self, rows: &Rows<'_, N>) -> Result<Log<T>, IoError> {
        if self.samples.is_empty() {
            let kind = IoErrorKind::NoSamples {
                format: self.layout.format,
                incomplete: u32::try_from(self.missing.0).unwrap_or(u32::MAX),
            };
            return Err(IoError { name: rows.name.into(), place: None, kind });
        }
        let odd = |(rows, line): (usize, u32), oddity: fn(usize, u32) -> Oddity| {
            (rows > 0).then(|| oddity(rows, line))
        };
        let late = self.late(rows)?;
        self.samples.sort_by_key(|(sample, _)| sample.stamp_ns);
        let oddities = [
            odd(self.missing, |rows, line| Oddity::Missing { rows, line }),
            odd(late, |rows, line| Oddity::OutOfOrder { rows, line }),
            gaps(&self.samples),
            self.degrees,
            median(&mut self.forces).filter(|m| *m < LIGHTEST).map(|median| Oddity::MultiplesOfG { median }),
            odd(self.rough, |rows, line| Oddity::QuaternionNorm { rows, line }),
        ];
        let samples = self.samples.into_iter().map(|(sample, _)| sample).collect();
        Ok(Log { samples, oddities: oddities.into_iter().flatten().collect() })
    }

    /// The rows that are not in order of time; an error where the clock was set back.
    fn late(&self, rows: &Rows<'_, N>) -> Result<(usize, u32), IoError> {
        let (mut latest_ns, mut late) = (i64::MIN, (0, 0));
        for &(Stamped { stamp_ns, .. }, line) in &self.samples {
            let back_ns = if latest_ns > stamp_ns { latest_ns.saturating_sub(stamp_ns) } else { 0 };
            if back_ns >= OVERTAKING_NS {
                let milliseconds = back_ns / 1_000_000;
                return Err(rows.fail_line(line, IoErrorKind::TimeRunsBack { milliseconds }));
            }
            if back_ns > 0 {
                count(&mut late, line);
            }
            latest_ns = latest_ns.max(stamp_ns);
        }
        Ok(late)
    }
}

/// One row more, the first of them in `line`.
fn count((rows, first): &mut (usize, u32), line: u32) {
    *first = if *rows == 0 { line } else { *first };
    *rows += 1;
}

fn gaps<T>(samples: &[(Stamped<T>, u32)]) -> Option<Oddity> {
    let step = |pair: &[(Stamped<T>, u32)]| pair[1].0.stamp_ns.saturating_sub(pair[0].0.stamp_ns);
    let mut steps: Vec<i64> = samples.windows(2).map(step).collect();
    let middle = steps.len() / 2;
    let usual = *steps.get_mut(..).filter(|s| !s.is_empty())?.select_nth_unstable(middle).1;
    let is_gap = |pair: &&[(Stamped<T>, u32)]| usual > 0 && step(pair) > usual.saturating_mul(GAP);
    let longest = samples.windows(2).filter(is_gap).max_by_key(|pair| step(pair))?;
    Some(Oddity::Gaps {
        count: samples.windows(2).filter(is_gap).count(),
        longest: step(longest) as f64 / 1e9,
        line: longest[1].1,
        usual: usual as f64 / 1e9,
    })
}

fn median(numbers: &mut [f64]) -> Option<f64> {
    let middle = numbers.len() / 2;
    (!numbers.is_empty()).then(|| *numbers.select_nth_unstable_by(middle, f64::total_cmp).1)
}
