//! Averages over time against the band they should lie in.

use std::fmt::Write;

use svg::Document;

use super::colour::{ELLIPSE, GRID, LANDMARK, TRACK, fade};
use super::page::{Anchor, line, path, rectangle, text};
use super::panel::{HEADING, NOTE, TICK};
use super::window::Area;
use super::{HEADER, MARGIN, sheet};
use crate::text::significant;

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 150.0;
const GAP: f64 = 52.0;
const AXIS: f64 = 46.0;
/// More points than this are no finer on paper.
const POINTS: usize = 760;

/// A page of strips, one below the other.
#[derive(Clone, Debug)]
pub struct Chart {
    /// What it is.
    pub title: String,
    /// The main numbers, in one line.
    pub facts: String,
    /// From top to bottom.
    pub strips: Vec<Strip>,
}

/// One quantity over time.
#[derive(Clone, Debug)]
pub struct Strip {
    /// What is averaged.
    pub heading: String,
    /// How much of it is inside.
    pub note: String,
    /// Time by time.
    pub values: Vec<f64>,
    /// What the values should be.
    pub expected: f64,
    /// Where they should lie.
    pub band: [f64; 2],
}

impl Chart {
    /// The drawing as an SVG document.
    pub fn svg(&self) -> String {
        let (width, step) = (2.0 * MARGIN + WIDTH, HEIGHT + GAP);
        let height = HEADER + self.strips.len() as f64 * step + MARGIN;
        let mut document = sheet(&self.title, &self.facts, (width, height));
        for (i, strip) in self.strips.iter().enumerate() {
            let y = HEADER + i as f64 * step + 28.0;
            document =
                strip.draw(document, Area { x: MARGIN + AXIS, y, width: WIDTH - AXIS, height: HEIGHT });
        }
        document.to_string()
    }
}

impl Strip {
    /// What is shown: from 0 to what is seen, at most ten times what is expected.
    fn top(&self) -> f64 {
        let seen = self.values.iter().copied().filter(|x| x.is_finite()).fold(self.band[1], f64::max);
        1.08 * seen.min(10.0 * self.expected)
    }

    fn draw(&self, document: Document, area: Area) -> Document {
        let top = self.top();
        let height = |value: f64| area.y + area.height * (1.0 - (value / top).clamp(0.0, 1.0));
        let right = area.x + area.width;
        let [low, high] = self.band.map(height);
        let band = Area { x: area.x, y: high, width: area.width, height: low - high };
        let mut document = document
            .add(text(&self.heading, (area.x - AXIS, area.y - 10.0), Anchor::Start, HEADING))
            .add(text(&self.note, (right, area.y - 10.0), Anchor::End, NOTE))
            .add(rectangle(band, fade(LANDMARK, 0.82)));
        for (value, label) in [
            (0.0, "0".to_owned()),
            (self.expected, significant(self.expected, 3)),
            (top, significant(top, 2)),
        ] {
            let y = height(value);
            let colour = if value == self.expected { LANDMARK } else { GRID };
            document = document.add(line((area.x, y), (right, y), colour, 1.0)).add(text(
                &label,
                (area.x - 8.0, y + 4.0),
                Anchor::End,
                TICK,
            ));
        }
        let beyond = self.values.iter().any(|x| x.is_nan() || *x > top);
        let colour = if beyond { TRACK } else { ELLIPSE };
        document
            .add(path(self.data(area, height), colour, 1.4))
            .add(text("1", (area.x, area.y + area.height + 16.0), Anchor::Middle, TICK))
            .add(text(
                &format!("step {}", self.values.len()),
                (right, area.y + area.height + 16.0),
                Anchor::End,
                TICK,
            ))
    }

    /// The line, thinned to what paper shows.
    fn data(&self, area: Area, height: impl Fn(f64) -> f64) -> String {
        let last = self.values.len().saturating_sub(1).max(1) as f64;
        let every = self.values.len().div_ceil(POINTS).max(1);
        let mut data = String::new();
        for (k, value) in self.values.iter().enumerate().step_by(every) {
            let x = area.x + area.width * k as f64 / last;
            let y = height(if value.is_nan() { f64::INFINITY } else { *value });
            // Writing to a string cannot fail.
            let _ = write!(data, "{}{x:.1} {y:.1}", if data.is_empty() { "M" } else { "L" });
        }
        data
    }
}
