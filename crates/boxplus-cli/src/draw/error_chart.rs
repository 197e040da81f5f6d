//! One coordinate of an error over time, inside its band.

use std::fmt::Write as _;

use svg::Document;

use super::colour::{ELLIPSE, GRID, MUTED, TRACK};
use super::page::{Anchor, band, clipped, line, path, pixels, text};
use super::panel::{HEADING, NOTE, TICK, metres};
use super::window::{Area, ticks};

/// Points that are drawn of a line at most, two for each pixel column or so.
const COLUMNS: usize = 1200;
/// Room for the heading above and for the numbers at the left.
const HEADING_ROOM: f64 = 26.0;
const TICK_ROOM: f64 = 54.0;

/// An error and what was claimed of it.
#[derive(Clone, Debug, Default)]
pub struct ErrorChart {
    /// What is measured, with its unit.
    pub heading: String,
    /// How much of it is inside.
    pub note: String,
    /// Seconds.
    pub times: Vec<f64>,
    /// The error at each time.
    pub error: Vec<f64>,
    /// Half of the band at each time.
    pub band: Vec<f64>,
}

impl ErrorChart {
    /// Adds the chart to the page; `axis` says whether times are written below.
    pub fn draw(&self, document: Document, id: &str, area: Area, axis: bool) -> Document {
        let plot = Area {
            x: area.x + TICK_ROOM,
            y: area.y + HEADING_ROOM,
            width: area.width - TICK_ROOM,
            height: area.height - HEADING_ROOM - if axis { 22.0 } else { 8.0 },
        };
        let document = document
            .add(text(&self.heading, (plot.x, area.y + 17.0), Anchor::Start, HEADING))
            .add(text(&self.note, (plot.x + plot.width, area.y + 17.0), Anchor::End, NOTE));
        let frame = Frame { plot, start: self.start(), length: self.length(), reach: self.reach() };
        let document = frame.grid(document, axis);
        let (clip, marks) = clipped(id, plot);
        let marks = marks
            .add(band(self.outline(&frame), ELLIPSE))
            .add(path(self.line(&frame), TRACK, 1.1).set("stroke-linejoin", "round"));
        document.add(clip).add(marks)
    }

    fn start(&self) -> f64 {
        self.times.first().copied().unwrap_or(0.0)
    }

    fn length(&self) -> f64 {
        let length = self.times.last().copied().unwrap_or(1.0) - self.start();
        if length > 0.0 && length.is_finite() { length } else { 1.0 }
    }

    /// Half of what is shown: nearly all of the band and of the error, not what a start from nowhere is like.
    fn reach(&self) -> f64 {
        let most = |numbers: &[f64], percent: usize| {
            let mut sizes: Vec<f64> = numbers.iter().map(|x| x.abs()).filter(|x| x.is_finite()).collect();
            sizes.sort_by(f64::total_cmp);
            sizes.get(sizes.len() * percent / 100).or(sizes.last()).copied().unwrap_or(0.0)
        };
        let reach = (1.15 * most(&self.band, 95)).max(1.1 * most(&self.error, 99));
        // Beyond, there are no round numbers in between.
        if (1e-300..1e300).contains(&reach) { reach } else { 1.0 }
    }

    fn pieces(&self) -> impl Iterator<Item = std::ops::Range<usize>> + Clone + use<> {
        let count = self.times.len().min(self.error.len()).min(self.band.len());
        let size = count.div_ceil(COLUMNS).max(1);
        (0..count).step_by(size).map(move |start| start..(start + size).min(count))
    }

    /// Of every piece the widest half.
    fn outline(&self, frame: &Frame) -> String {
        let half = |piece: std::ops::Range<usize>| {
            (self.times[piece.start], self.band[piece].iter().copied().fold(0.0, f64::max))
        };
        let upper = self.pieces().map(half);
        let lower: Vec<_> = self.pieces().map(half).map(|(t, half)| (t, -half)).collect();
        let mut data = points(upper.chain(lower.into_iter().rev()), frame);
        data.push('Z');
        data
    }

    /// Of every piece the lowest and the highest, so that no peak is lost.
    fn line(&self, frame: &Frame) -> String {
        let ends = |piece: std::ops::Range<usize>| {
            let errors = &self.error[piece.clone()];
            let low = errors.iter().copied().fold(f64::INFINITY, f64::min);
            let high = errors.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let time = self.times[piece.start];
            if errors.len() == 1 { vec![(time, low)] } else { vec![(time, low), (time, high)] }
        };
        points(self.pieces().flat_map(ends), frame)
    }
}

fn points(points: impl Iterator<Item = (f64, f64)>, frame: &Frame) -> String {
    let mut data = String::new();
    for (t, x) in points.filter(|(t, x)| t.is_finite() && x.is_finite()) {
        let (x, y) = frame.place(t, x);
        let command = if data.is_empty() { 'M' } else { 'L' };
        // Writing into a String cannot fail.
        let _ = write!(data, "{command}{} {}", pixels(x), pixels(y));
    }
    if data.is_empty() { "M0 0".to_owned() } else { data }
}

/// Where times and errors are on the page.
struct Frame {
    plot: Area,
    start: f64,
    length: f64,
    reach: f64,
}

impl Frame {
    fn place(&self, t: f64, x: f64) -> (f64, f64) {
        let Area { x: left, y: top, width, height } = self.plot;
        // What is far out is clipped; its numbers need not be large.
        let part = (x / self.reach).clamp(-20.0, 20.0);
        (left + width * (t - self.start) / self.length, top + 0.5 * height * (1.0 - part))
    }

    fn grid(&self, mut document: Document, axis: bool) -> Document {
        let Area { x, y, width, height } = self.plot;
        let levels = ticks(-self.reach, self.reach);
        let every = if height < 90.0 { 2 } else { 1 };
        for level in
            levels.iter().copied().filter(|l| (l / (levels[1] - levels[0])).round() as i64 % every == 0)
        {
            let (_, at) = self.place(self.start, level);
            let colour = if level.abs() < 1e-12 { MUTED } else { GRID };
            document = document.add(line((x, at), (x + width, at), colour, 1.0));
            document = document.add(text(&metres(level), (x - 7.0, at + 4.0), Anchor::End, TICK));
        }
        for t in ticks(self.start, self.start + self.length) {
            let (at, _) = self.place(t, 0.0);
            document = document.add(line((at, y), (at, y + height), GRID, 1.0));
            if axis && at < x + width - 24.0 {
                document = document.add(text(&metres(t), (at, y + height + 17.0), Anchor::Middle, TICK));
            }
        }
        if axis {
            document = document.add(text("s", (x + width, y + height + 17.0), Anchor::End, TICK));
        }
        document
    }
}
