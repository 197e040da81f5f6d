//! The few lines around a fault, ready to be shown: a file of 100 MB or of random bytes is no trouble.

use std::ops::Range;

use miette::{MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};

/// Lines longer than this are cut around the fault.
const WIDTH: usize = 160;
/// What is kept before the fault in a line that is cut.
const BEFORE: usize = 60;

/// A piece of a file that knows where it comes from.
#[derive(Debug)]
pub struct Excerpt {
    name: String,
    text: String,
    /// Line and column of its first character, counted from 0.
    line: usize,
    column: usize,
    span: SourceSpan,
}

impl Excerpt {
    /// The lines around the bytes `span` of `content`.
    pub fn new(name: &str, content: &[u8], span: Range<usize>) -> Self {
        let start = span.start.min(content.len());
        let line_start = content[..start].iter().rposition(|&b| b == b'\n').map_or(0, |i| i + 1);
        let line_end = end_of_line(content, start);
        let end = span.end.clamp(start, line_end.max(start));
        let line = content[..line_start].split(|&b| b == b'\n').count() - 1;
        if line_end - line_start > WIDTH {
            let from = line_start.max(start.saturating_sub(BEFORE));
            let to = line_end.min(from + WIDTH);
            return Self::assemble(name, content, [from, start, end.min(to), to], (line, from - line_start));
        }
        let (first, lines_before) = back(content, line_start, 2);
        let mut last = line_end;
        if last < content.len() && end_of_line(content, last + 1) - last <= WIDTH {
            last = end_of_line(content, last + 1);
        }
        Self::assemble(name, content, [first, start, end, last], (line - lines_before, 0))
    }

    /// The lines around a line of `content`, counted from 1, which is marked as a whole.
    pub fn line(name: &str, content: &[u8], line: u32) -> Option<Self> {
        let before = (line as usize).checked_sub(2);
        let ends = content.iter().enumerate().filter(|(_, b)| **b == b'\n').map(|(i, _)| i + 1);
        let start = match before {
            Some(skipped) => ends.clone().nth(skipped)?,
            None if line == 1 => 0,
            None => return None,
        };
        Some(Self::new(name, content, start..end_of_line(content, start)))
    }

    /// `[from, start, end, to]`: the text, and the fault within.
    fn assemble(name: &str, content: &[u8], cuts: [usize; 4], (line, column): (usize, usize)) -> Self {
        let [before, fault, after] =
            [0, 1, 2].map(|i| printable(&content[cuts[i]..cuts[i + 1].max(cuts[i])]));
        let span = (before.len(), fault.len()).into();
        Self { name: name.to_owned(), text: before + &fault + &after, line, column, span }
    }

    /// A span without the lines around it: what the headline of a report asks for.
    fn point(&self, span: SourceSpan) -> MietteSpanContents<'_> {
        let start = span.offset().min(self.text.len());
        let end = (start + span.len()).min(self.text.len());
        let before = &self.text[..start];
        let (line, column) = match before.rsplit_once('\n') {
            Some((lines, rest)) => (self.line + 1 + lines.matches('\n').count(), rest.chars().count()),
            None => (self.line, self.column + before.chars().count()),
        };
        let data = &self.text.as_bytes()[start..end];
        MietteSpanContents::new_named(self.name.clone(), data, span, line, column, 1)
    }

    /// Where the fault is in the excerpt.
    pub fn span(&self) -> SourceSpan {
        self.span
    }
}

fn end_of_line(content: &[u8], from: usize) -> usize {
    content[from..].iter().position(|&b| b == b'\n').map_or(content.len(), |i| from + i)
}

/// The start of the line up to `lines` lines earlier, and how many were there and short enough to be shown.
fn back(content: &[u8], mut start: usize, lines: usize) -> (usize, usize) {
    for taken in 0..lines {
        if start == 0 {
            return (start, taken);
        }
        let previous = content[..start - 1].iter().rposition(|&b| b == b'\n').map_or(0, |i| i + 1);
        if start - previous > WIDTH {
            return (start, taken);
        }
        start = previous;
    }
    (start, lines)
}

/// Text as it is; a replacement for what has no place on a terminal.
fn printable(bytes: &[u8]) -> String {
    let visible = |c: char| if c.is_control() && c != '\n' && c != '\t' { '\u{fffd}' } else { c };
    String::from_utf8_lossy(bytes).chars().filter(|&c| c != '\r').map(visible).collect()
}

impl SourceCode for Excerpt {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        lines_before: usize,
        lines_after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        if (lines_before, lines_after) == (0, 0) {
            return Ok(Box::new(self.point(*span)));
        }
        let all = (0, self.text.len()).into();
        let lines = self.text.lines().count();
        Ok(Box::new(MietteSpanContents::new_named(
            self.name.clone(),
            self.text.as_bytes(),
            all,
            self.line,
            self.column,
            lines,
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(content: &[u8], span: Range<usize>) -> (String, String, usize, usize) {
        let excerpt = Excerpt::new("f", content, span);
        let marked = excerpt.span.offset()..excerpt.span.offset() + excerpt.span.len();
        (excerpt.text[marked].to_owned(), excerpt.text.clone(), excerpt.line, excerpt.column)
    }

    #[test]
    fn two_lines_before_and_one_after_are_shown() {
        let content = b"one\ntwo\nthree\nfour bad\nfive\nsix\n";
        let (fault, text, line, column) = shown(content, 19..22);
        assert_eq!(
            (fault.as_str(), text.as_str(), line, column),
            ("bad", "two\nthree\nfour bad\nfive", 1, 0)
        );
    }

    #[test]
    fn a_long_line_is_cut_around_the_fault() {
        let content = [b"short\n".as_slice(), &[b'x'; 5000], b"BAD", &[b'y'; 5000]].concat();
        let (fault, text, line, column) = shown(&content, 5006..5009);
        assert_eq!((fault.as_str(), text.len(), line, column), ("BAD", WIDTH, 1, 5000 - BEFORE));
    }

    #[test]
    fn bytes_that_are_no_text_are_replaced_and_the_mark_stays_right() {
        let (fault, text, ..) = shown(b"\xff\x00\x1b[31m bad \xfe", 8..11);
        assert_eq!(fault, "bad");
        assert!(text.chars().all(|c| !c.is_control()));
    }

    #[test]
    fn a_line_is_found_by_its_number() {
        let marked = |line| {
            let excerpt = Excerpt::line("f", b"one\ntwo\nthree", line)?;
            Some(excerpt.text[excerpt.span.offset()..][..excerpt.span.len()].to_owned())
        };
        let expected = [None, Some("one"), Some("two"), Some("three"), None];
        assert_eq!([0, 1, 2, 3, 4].map(marked), expected.map(|line| line.map(str::to_owned)));
    }

    #[test]
    fn any_span_of_any_content_is_shown_without_panic() {
        let content = b"a\n\n\xffb\r\nccc\n";
        for start in 0..content.len() + 3 {
            for end in start..content.len() + 5 {
                shown(content, start..end);
                shown(b"", start..end);
            }
        }
    }
}
