//! What the lines and colours mean.

use colorous::Color;
use svg::Document;

use super::colour::{CLOUDS, Decades, ELLIPSE, LANDMARK, MUTED, SIGHTING, TRACK, TRUTH, heat};
use super::page::{Anchor, Type, dot, ellipse, line, rectangle, text};
use super::window::Area;
use super::{Panel, Scene};

const LABEL: Type = Type { size: 13.0, bold: false, colour: MUTED };
const TICK: Type = Type { size: 11.5, bold: false, colour: MUTED };
/// Height of a row.
const ROW: f64 = 84.0;
const SECOND_ROW: f64 = 44.0;
/// The colour bar, and the room for its title.
const BAR: f64 = 240.0;
const BAR_TITLE: f64 = 215.0;
const CELLS: u8 = 60;

/// The legend of all panels.
pub struct Legend {
    entries: Vec<(Mark, &'static str, Color)>,
    decades: Option<Decades>,
}

#[derive(Clone, Copy)]
enum Mark {
    Line,
    Dot,
    Ellipse,
}

impl Legend {
    /// What occurs in the panels.
    pub fn of(panels: &[Panel], decades: Option<Decades>) -> Self {
        let any = |f: fn(&Scene) -> bool| panels.iter().any(|p| f(&p.scene));
        let entries = [
            (any(|s| !s.tracks.is_empty()), (Mark::Line, "trajectory", TRACK)),
            (any(|s| !s.views.is_empty()), (Mark::Line, "camera", TRACK)),
            (any(|s| !s.truth.is_empty()), (Mark::Line, "truth", TRUTH)),
            (any(|s| !s.band.is_empty()), (Mark::Ellipse, "3σ", ELLIPSE)),
            (any(|s| !s.landmarks.is_empty()), (Mark::Dot, "landmark", LANDMARK)),
            (any(|s| !s.sightings.is_empty()), (Mark::Line, "sighting", SIGHTING)),
            (any(|s| !s.clouds[0].is_empty()), (Mark::Dot, "target", CLOUDS[0])),
            (any(|s| !s.clouds[1].is_empty()), (Mark::Dot, "source", CLOUDS[1])),
            (any(|s| !s.ellipses.is_empty()), (Mark::Ellipse, "95 % of positions", ELLIPSE)),
        ];
        Self { entries: entries.into_iter().filter(|e| e.0).map(|e| e.1).collect(), decades }
    }

    /// Of a path and of errors over time.
    pub fn of_run(path: &[Panel], errors: bool) -> Self {
        let mut legend = Self::of(path, None);
        if errors {
            legend.entries.push((Mark::Line, "error", TRACK));
            if path.is_empty() {
                legend.entries.push((Mark::Ellipse, "3σ", ELLIPSE));
            }
        }
        legend
    }

    /// The height it needs on a page of this width.
    pub fn height(&self, width: f64) -> f64 {
        if self.has_two_rows(width) { ROW + SECOND_ROW } else { ROW }
    }

    fn has_two_rows(&self, width: f64) -> bool {
        let entries: f64 = self.entries.iter().map(|e| advance(e.1)).sum();
        self.decades.is_some() && entries + BAR_TITLE + BAR > width
    }

    /// Adds the legend to the page.
    pub fn draw(&self, mut document: Document, area: Area) -> Document {
        let middle = area.y + 44.0;
        let mut x = area.x;
        for &(mark, name, colour) in &self.entries {
            document = match mark {
                Mark::Line => document.add(line((x, middle), (x + 22.0, middle), colour, 2.0)),
                Mark::Dot => document.add(dot((x + 11.0, middle), 3.5, colour)),
                Mark::Ellipse => document.add(ellipse((x + 11.0, middle), (11.0, 6.0), 0.0, colour)),
            };
            document = document.add(text(name, (x + 30.0, middle + 4.0), Anchor::Start, LABEL));
            x += advance(name);
        }
        let middle = if self.has_two_rows(area.width) { middle + SECOND_ROW } else { middle };
        match self.decades {
            Some(decades) => colour_bar(document, area.x + area.width, middle, decades),
            None => document,
        }
    }
}

/// From one entry to the next.
fn advance(name: &str) -> f64 {
    56.0 + 6.8 * name.chars().count() as f64
}

fn colour_bar(mut document: Document, right: f64, middle: f64, decades: Decades) -> Document {
    let (left, cell) = (right - BAR, BAR / f64::from(CELLS));
    for i in 0..CELLS {
        let x = left + f64::from(i) * cell;
        // Cells overlap a little: no hair lines between them.
        let part = Area { x, y: middle - 5.0, width: (cell + 0.6).min(right - x), height: 10.0 };
        document = document.add(rectangle(part, heat((f64::from(i) + 0.5) / f64::from(CELLS))));
    }
    for power in decades.low..=decades.high {
        let at = left + BAR * f64::from(power - decades.low) / f64::from(decades.high - decades.low);
        let anchor = if power == decades.high { Anchor::End } else { Anchor::Middle };
        document = document.add(text(&decade(power), (at, middle + 21.0), anchor, TICK));
    }
    document.add(text("residual of loop closures [σ]", (left - 16.0, middle + 4.0), Anchor::End, LABEL))
}

/// 10ᵖ in print.
fn decade(power: i32) -> String {
    match power {
        -2 => "0.01".to_owned(),
        -1 => "0.1".to_owned(),
        0 => "1".to_owned(),
        1 => "10".to_owned(),
        2 => "100".to_owned(),
        3 => "1000".to_owned(),
        _ => format!("10{}", crate::text::superscript(power)),
    }
}
