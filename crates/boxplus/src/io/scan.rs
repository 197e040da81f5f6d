//! Text into lines, lines into fields, fields into numbers; every failure knows its place.

use super::error::{IoError, IoErrorKind, Place};
use crate::pose_graph::{Label, Line};
use core::ops::Range;

/// What the fields of a line are called: `(tag, fields)`; the last name stands for all further fields.
pub(super) type Layouts = &'static [(&'static str, &'static str)];

/// An outcome in the inner loop: the error is boxed, so that a number travels in registers.
pub(super) type Scan<T> = Result<T, Box<IoError>>;

/// A text with its name and the layouts of its format.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub(super) name: &'a str,
    pub(super) text: &'a [u8],
    pub(super) layouts: Layouts,
}

/// The lines of a text that say something: neither blank nor a `#` comment.
pub(super) struct Lines<'a> {
    source: Source<'a>,
    at: usize,
    line: u32,
}

/// One line, read field by field; the tag is read.
pub(super) struct Fields<'a> {
    source: Source<'a>,
    start: usize,
    end: usize,
    at: usize,
    token: Range<usize>,
    field: u32,
    line: u32,
    /// First word of the line.
    pub(super) tag: &'a [u8],
    /// The norm of a quaternion that was not quite one.
    pub(super) rough_norm: Option<f64>,
}

impl<'a> Source<'a> {
    /// Its lines.
    pub(super) fn lines(self) -> Lines<'a> {
        let bom = if self.text.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        Lines { source: self, at: bom, line: 0 }
    }

    /// An error without a place.
    pub(super) fn fail(&self, kind: IoErrorKind) -> IoError {
        IoError { name: self.name.into(), place: None, kind }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Fields<'a>;

    fn next(&mut self) -> Option<Fields<'a>> {
        while self.at < self.source.text.len() {
            let start = self.at;
            let rest = &self.source.text[start..];
            let end = start + rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
            self.at = end + 1;
            self.line = self.line.saturating_add(1);
            let mut fields = Fields {
                source: self.source,
                start,
                end,
                at: start,
                token: start..start,
                field: 0,
                line: self.line,
                tag: b"",
                rough_norm: None,
            };
            match fields.token() {
                None | Some([b'#', ..]) => {}
                Some(tag) => {
                    fields.tag = tag;
                    return Some(fields);
                }
            }
        }
        None
    }
}

impl<'a> Fields<'a> {
    /// Where it stands in the file.
    pub(super) fn line(&self) -> Line {
        Line(self.line)
    }

    /// The next field as it stands.
    #[inline]
    fn token(&mut self) -> Option<&'a [u8]> {
        let bytes = &self.source.text[..self.end];
        let blank = bytes[self.at..].iter().position(|b| !b.is_ascii_whitespace());
        let start = self.at + blank?;
        let length = bytes[start..].iter().position(u8::is_ascii_whitespace);
        self.at = length.map_or(self.end, |n| start + n);
        self.token = start..self.at;
        self.field += 1;
        Some(&bytes[start..self.at])
    }

    /// The next field, which must exist.
    #[inline]
    fn required(&mut self) -> Scan<&'a [u8]> {
        if let Some(token) = self.token() {
            return Ok(token);
        }
        // Point behind the last character, and count the field that is missing.
        self.token = self.token.end..self.token.end;
        self.field += 1;
        Err(self.fail(IoErrorKind::MissingField).into())
    }

    /// The next field as a finite number, rounded as the standard library rounds.
    #[inline]
    pub(super) fn number(&mut self) -> Scan<f64> {
        let token = self.required()?;
        match core::str::from_utf8(token).ok().and_then(|text| text.parse::<f64>().ok()) {
            Some(x) if x.is_finite() => Ok(x),
            Some(_) => Err(self.fail(IoErrorKind::NotFinite { found: self.found() }).into()),
            None => Err(self.fail(IoErrorKind::NotANumber { found: self.found() }).into()),
        }
    }

    /// The next N fields as numbers.
    #[inline]
    pub(super) fn numbers<const N: usize>(&mut self) -> Scan<[f64; N]> {
        let mut x = [0.0; N];
        for x in &mut x {
            *x = self.number()?;
        }
        Ok(x)
    }

    /// The next field as an id.
    #[inline]
    pub(super) fn id(&mut self) -> Scan<u64> {
        let token = self.required()?;
        let digit = |id: Option<u64>, b: &u8| {
            id?.checked_mul(10)?.checked_add(b.is_ascii_digit().then(|| u64::from(b - b'0'))?)
        };
        match token.iter().fold(Some(0), digit) {
            Some(id) => Ok(id),
            None => Err(self.fail(self.why_no_id(token)).into()),
        }
    }

    /// The next field as an id of a letter and a number.
    #[inline]
    pub(super) fn name(&mut self) -> Scan<u64> {
        let token = self.required()?;
        let label = core::str::from_utf8(token).ok().and_then(|text| text.parse::<Label>().ok());
        match label.filter(|label| label.letter().is_some()) {
            Some(Label(id)) => Ok(id),
            None => Err(self.fail(IoErrorKind::NotAName { found: self.found() }).into()),
        }
    }

    /// Whether one of the next two fields is a letter and a number, as no g2o line has them there.
    pub(super) fn has_names(&self) -> bool {
        let rest = self.source.text[self.at..self.end].split(u8::is_ascii_whitespace);
        let is_name = |field: &[u8]| match field {
            [letter, digits @ ..] => {
                letter.is_ascii_alphabetic() && !digits.is_empty() && digits.iter().all(u8::is_ascii_digit)
            }
            [] => false,
        };
        rest.filter(|field| !field.is_empty()).take(2).any(is_name)
    }

    /// Where the next field starts.
    pub(super) fn next_start(&self) -> usize {
        let bytes = &self.source.text[self.at..self.end];
        self.at + bytes.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(0)
    }

    /// Whether the line has no further field.
    pub(super) fn is_done(&self) -> bool {
        self.source.text[self.at..self.end].iter().all(u8::is_ascii_whitespace)
    }

    /// Passes over all further fields.
    pub(super) fn skip_rest(&mut self) {
        self.at = self.end;
    }

    /// Checks that the line has no further field.
    #[inline]
    pub(super) fn finish(&mut self) -> Scan<()> {
        match self.token() {
            None => Ok(()),
            Some(_) => Err(self.fail(IoErrorKind::TooManyFields { found: self.found() }).into()),
        }
    }

    /// The whole line.
    pub(super) fn text(&self) -> Scan<&'a str> {
        let bytes = &self.source.text[self.start..self.end];
        let bytes = bytes.strip_suffix(b"\r").unwrap_or(bytes);
        core::str::from_utf8(bytes).map_err(|e| self.not_text(self.start + e.valid_up_to()).into())
    }

    /// Where the last field starts.
    pub(super) fn token_start(&self) -> usize {
        self.token.start
    }

    /// An error over all fields from byte `start` to the last.
    #[cold]
    pub(super) fn fail_from(&self, start: usize, kind: IoErrorKind) -> IoError {
        self.fail_at(start..self.token.end, kind)
    }

    /// An error at the last field.
    #[cold]
    pub(super) fn fail(&self, kind: IoErrorKind) -> IoError {
        self.fail_at(self.token.clone(), kind)
    }

    /// An error at a byte that no text holds.
    pub(super) fn not_text(&self, at: usize) -> IoError {
        self.fail_at(at..at + 1, IoErrorKind::NotText { byte: self.source.text[at] })
    }

    fn fail_at(&self, span: Range<usize>, kind: IoErrorKind) -> IoError {
        let tag = shorten(self.tag);
        let layout = self.source.layouts.iter().find(|(known, _)| *known == tag).map(|(_, layout)| *layout);
        let column = (span.start - self.start + 1) as u32;
        let place = Place { line: self.line, column, field: self.field - 1, span, tag, layout };
        IoError { name: self.source.name.into(), place: Some(place), kind }
    }

    fn found(&self) -> Box<str> {
        shorten(&self.source.text[self.token.clone()]).into()
    }

    fn why_no_id(&self, token: &[u8]) -> IoErrorKind {
        let found = self.found();
        match token {
            [b'-', digits @ ..] if !digits.is_empty() && digits.iter().all(u8::is_ascii_digit) => {
                IoErrorKind::NegativeId { found }
            }
            digits if digits.iter().all(u8::is_ascii_digit) => IoErrorKind::HugeId { found },
            _ => IoErrorKind::NotAnId { found },
        }
    }
}

/// At most 40 characters of a field, for a message.
pub(super) fn shorten(bytes: &[u8]) -> String {
    String::from_utf8_lossy(&bytes[..bytes.len().min(160)]).chars().take(40).collect()
}
