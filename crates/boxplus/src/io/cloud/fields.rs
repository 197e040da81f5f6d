//! Fields of a point: in a line of text, or in bytes.

use super::File;
use crate::io::error::{IoError, IoErrorKind, Place};

/// How a number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Number {
    /// Bytes.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The number in `size()` bytes, the lowest first.
    fn value(self, little: [u8; 8]) -> f64 {
        let whole = u64::from_le_bytes(little);
        match self {
            Self::I8 => f64::from(whole as i8),
            Self::U8 => f64::from(whole as u8),
            Self::I16 => f64::from(whole as i16),
            Self::U16 => f64::from(whole as u16),
            Self::I32 => f64::from(whole as i32),
            Self::U32 => f64::from(whole as u32),
            Self::I64 => whole.cast_signed() as f64,
            Self::U64 => whole as f64,
            Self::F32 => f64::from(f32::from_bits(whole as u32)),
            Self::F64 => f64::from_bits(whole),
        }
    }
}

/// Bytes that are read from the front.
pub(super) struct Binary<'a> {
    file: File<'a>,
    at: usize,
    big: bool,
}

impl<'a> Binary<'a> {
    pub(super) fn new(file: File<'a>, at: usize, big: bool) -> Self {
        Self { file, at, big }
    }

    /// The next bytes.
    pub(super) fn take(&mut self, size: usize) -> Result<&'a [u8], IoError> {
        let rest = &self.file.bytes[self.at..];
        let Some((taken, _)) = rest.split_at_checked(size) else {
            let (offset, missing) = (self.file.bytes.len(), size - rest.len());
            return Err(self.file.fail(IoErrorKind::Truncated { offset, missing }));
        };
        self.at += size;
        Ok(taken)
    }

    /// The next number.
    pub(super) fn number(&mut self, kind: Number) -> Result<f64, IoError> {
        let (size, big) = (kind.size(), self.big);
        let bytes = self.take(size)?;
        let mut little = [0; 8];
        little.iter_mut().zip(bytes).for_each(|(to, from)| *to = *from);
        if big {
            little[..size].reverse();
        }
        Ok(kind.value(little))
    }

    /// Refuses a promise of more bytes than there are.
    pub(super) fn check_room(&self, items: usize, size: usize) -> Result<(), IoError> {
        let room = self.file.bytes.len() - self.at;
        match items.checked_mul(size) {
            Some(needed) if needed <= room => Ok(()),
            needed => {
                let missing = needed.map_or(usize::MAX, |needed| needed - room);
                Err(self.file.fail(IoErrorKind::Truncated { offset: self.file.bytes.len(), missing }))
            }
        }
    }
}

/// A line of text, field by field.
#[derive(Clone)]
pub(in crate::io) struct Line<'a> {
    file: File<'a>,
    start: usize,
    end: usize,
    at: usize,
    /// From 1.
    number: u32,
    /// Fields taken.
    pub(in crate::io) fields: u32,
    token: (usize, usize),
}

/// The lines of a text from a place on, blank ones and comments too.
pub(in crate::io) struct Lines<'a> {
    file: File<'a>,
    pub(in crate::io) at: usize,
    number: u32,
}

impl<'a> Lines<'a> {
    pub(in crate::io) fn new(file: File<'a>) -> Self {
        let bom = if file.bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        Self { file, at: bom, number: 0 }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        let start = self.at;
        let rest = self.file.bytes.get(start..).filter(|rest| !rest.is_empty())?;
        let end = start + rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.at = (end + 1).min(self.file.bytes.len());
        self.number = self.number.saturating_add(1);
        let token = (start, start);
        Some(Line { file: self.file, start, end, at: start, number: self.number, fields: 0, token })
    }
}

impl<'a> Line<'a> {
    /// The next field. Blanks, or a comma or semicolon, are between fields; there is an empty one before the first comma of a line
    /// and between two, none after the last.
    pub(in crate::io) fn field(&mut self) -> Option<&'a [u8]> {
        let is_mark = |b: &u8| matches!(b, b',' | b';');
        let bytes = &self.file.bytes[..self.end];
        let visible = |from: usize| {
            bytes[from..].iter().position(|b| !b.is_ascii_whitespace()).map_or(self.end, |n| from + n)
        };
        let mut start = visible(self.at);
        if self.fields > 0 && bytes.get(start).is_some_and(is_mark) {
            start = visible(start + 1);
        }
        if start == self.end {
            return None;
        }
        let ends = |b: &u8| b.is_ascii_whitespace() || is_mark(b);
        let end = bytes[start..].iter().position(ends).map_or(self.end, |n| start + n);
        (self.at, self.token) = (end, (start, end));
        self.fields += 1;
        Some(&bytes[start..end])
    }

    /// Whether the line has no further field.
    pub(in crate::io) fn is_done(&self) -> bool {
        self.clone().field().is_none()
    }

    /// Which line of the file it is, from 1.
    pub(in crate::io) fn number(&self) -> u32 {
        self.number
    }

    /// The next field as a word; what is no text is shown as such.
    pub(in crate::io) fn word(&mut self) -> Option<&'a str> {
        self.field().map(|field| core::str::from_utf8(field).unwrap_or("\u{fffd}"))
    }

    /// The next field as a number, NaN and infinity included.
    pub(in crate::io) fn float(&mut self, expected: &'static str) -> Result<f64, IoError> {
        let Some(field) = self.field() else { return Err(self.missing(expected)) };
        let number = core::str::from_utf8(field).ok().and_then(|text| text.parse().ok());
        number.ok_or_else(|| self.fail(IoErrorKind::NotANumber { found: self.found() }, expected))
    }

    /// The next field as a whole number.
    pub(in crate::io) fn whole(&mut self, expected: &'static str) -> Result<usize, IoError> {
        let Some(field) = self.field() else { return Err(self.missing(expected)) };
        let number = core::str::from_utf8(field).ok().and_then(|text| text.parse().ok());
        number.ok_or_else(|| self.fail(IoErrorKind::NotANumber { found: self.found() }, expected))
    }

    /// An error behind the last field.
    pub(in crate::io) fn missing(&mut self, expected: &'static str) -> IoError {
        let visible = self.file.bytes[self.start..self.end].trim_ascii_end().len();
        self.token = (self.start + visible, self.start + visible);
        self.fail(IoErrorKind::MissingField, expected)
    }

    /// An error at the last field.
    pub(in crate::io) fn fail(&self, kind: IoErrorKind, expected: &'static str) -> IoError {
        let (start, end) = self.token;
        let place = Place {
            line: self.number,
            column: (start - self.start + 1) as u32,
            field: 1,
            span: start..end,
            tag: String::new(),
            layout: (!expected.is_empty()).then_some(expected),
        };
        IoError { name: self.file.name.into(), place: Some(place), kind }
    }

    /// At most 40 characters of the last field, for a message.
    pub(in crate::io) fn found(&self) -> Box<str> {
        let bytes = &self.file.bytes[self.token.0..self.token.1];
        let shown: String =
            String::from_utf8_lossy(&bytes[..bytes.len().min(160)]).chars().take(40).collect();
        shown.into()
    }

    /// The first byte that no text holds, as an error.
    pub(in crate::io) fn check_text(&self) -> Result<(), IoError> {
        let bytes = &self.file.bytes[self.start..self.end];
        let binary = |b: &u8| *b < b' ' && !b.is_ascii_whitespace();
        match bytes.iter().position(binary) {
            Some(at) => {
                let token = (self.start + at, self.start + at + 1);
                Err(Self { token, ..self.clone() }.fail(IoErrorKind::NotText { byte: bytes[at] }, ""))
            }
            None => Ok(()),
        }
    }

    /// Whether there is nothing to read.
    pub(in crate::io) fn is_comment_or_blank(&self) -> bool {
        let text = self.file.bytes[self.start..self.end].trim_ascii();
        text.is_empty() || text.starts_with(b"#") || text.starts_with(b"//")
    }
}
