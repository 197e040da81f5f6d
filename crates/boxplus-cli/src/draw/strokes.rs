//! Many segments, few paths: segments of one depth and colour share a path, so that 10⁵ edges stay a small file.

use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Steps of depth, and of colour.
pub const STEPS: u8 = 16;

/// What a segment belongs to; smaller keys are drawn first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Layer {
    /// 0 is the farthest.
    pub depth: u8,
    /// What kind of line.
    pub kind: Kind,
    /// Step of the colour map.
    pub colour: u8,
}

/// The lines of a pose graph, in the order of drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    Sighting,
    Loop,
    Truth,
    Track,
    View,
}

/// Paths under construction.
#[derive(Debug, Default)]
pub struct Strokes {
    paths: BTreeMap<Layer, Path>,
}

/// Path data with whole tenths of pixels, so that relative moves never drift.
#[derive(Debug, Default)]
struct Path {
    data: String,
    end: Option<(i64, i64)>,
}

impl Strokes {
    /// Adds the segment between two pixels; one that nobody could see is left out.
    pub fn segment(&mut self, layer: Layer, from: (f64, f64), to: (f64, f64)) {
        if ![from.0, from.1, to.0, to.1].iter().all(|x| x.abs() < 1e6) {
            return;
        }
        let (from, to) = (tenths(from), tenths(to));
        if from != to {
            self.paths.entry(layer).or_default().segment(from, to);
        }
    }

    /// The path data of every layer, back to front.
    pub fn into_paths(self) -> impl Iterator<Item = (Layer, String)> {
        self.paths.into_iter().map(|(layer, path)| (layer, path.data))
    }
}

impl Path {
    fn segment(&mut self, from: (i64, i64), to: (i64, i64)) {
        match self.end {
            Some(end) if end == from => {}
            Some(end) => self.command('m', (from.0 - end.0, from.1 - end.1)),
            None => self.command('M', from),
        }
        self.command('l', (to.0 - from.0, to.1 - from.1));
        self.end = Some(to);
    }

    fn command(&mut self, name: char, (x, y): (i64, i64)) {
        self.data.push(name);
        self.number(x);
        if y >= 0 {
            self.data.push(' ');
        }
        self.number(y);
    }

    fn number(&mut self, tenths: i64) {
        let sign = if tenths < 0 { "-" } else { "" };
        let (whole, part) = (tenths.abs() / 10, tenths.abs() % 10);
        // Writing into a String cannot fail.
        let _ = match (whole, part) {
            (_, 0) => write!(self.data, "{sign}{whole}"),
            (0, _) => write!(self.data, "{sign}.{part}"),
            _ => write!(self.data, "{sign}{whole}.{part}"),
        };
    }
}

fn tenths((x, y): (f64, f64)) -> (i64, i64) {
    ((x * 10.0).round() as i64, (y * 10.0).round() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAYER: Layer = Layer { depth: 0, kind: Kind::Track, colour: 0 };

    fn data(segments: &[[(f64, f64); 2]]) -> Vec<String> {
        let mut strokes = Strokes::default();
        segments.iter().for_each(|&[a, b]| strokes.segment(LAYER, a, b));
        strokes.into_paths().map(|(_, data)| data).collect()
    }

    #[test]
    fn joined_segments_are_one_line() {
        assert_eq!(data(&[[(1.0, 2.0), (3.5, 2.0)], [(3.5, 2.0), (3.0, 1.9)]]), ["M1 2l2.5 0l-.5-.1"]);
    }

    #[test]
    fn separate_segments_share_a_path() {
        assert_eq!(data(&[[(0.0, 0.0), (1.0, 0.0)], [(5.0, 5.0), (5.0, 6.0)]]), ["M0 0l1 0m4 5l0 1"]);
    }

    #[test]
    fn what_cannot_be_seen_is_left_out() {
        assert!(
            data(&[[(0.0, 0.0), (0.01, 0.0)], [(f64::NAN, 0.0), (1.0, 0.0)], [(1e9, 0.0), (1.0, 0.0)]])
                .is_empty()
        );
    }

    #[test]
    fn the_far_is_drawn_before_the_near() {
        let mut strokes = Strokes::default();
        for depth in [3, 1, 2] {
            strokes.segment(Layer { depth, ..LAYER }, (0.0, 0.0), (1.0, 1.0));
        }
        let order: Vec<_> = strokes.into_paths().map(|(layer, _)| layer.depth).collect();
        assert_eq!(order, [1, 2, 3]);
    }
}
