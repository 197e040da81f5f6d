//! Pose graphs, trajectories and charts on paper: one drawing, as SVG, and as PNG from the same SVG.

mod band;
mod camera;
mod chart;
mod colour;
mod error_chart;
mod from_graph;
mod from_track;
mod legend;
mod page;
mod panel;
mod png;
mod run;
mod scene;
mod strokes;
mod window;

pub use chart::{Chart, Strip};
pub use error_chart::ErrorChart;
pub use from_graph::Places;
pub use from_track::{DEGREES, charts, in_plane, in_space, path};
pub use png::render as png;
pub use run::Run;
pub use scene::{Ellipse, Scene};

use camera::Camera;
use colour::{Decades, INK, MUTED, PAPER};
use legend::Legend;
use page::{Anchor, FONTS, Type, text};
use svg::Document;
use svg::node::element::Title;
use window::Area;

const MARGIN: f64 = 40.0;
const HEADER: f64 = 98.0;
const PANEL: f64 = 580.0;
/// Height of a panel over its width, at least and at most.
const SHALLOWEST: f64 = 0.55;
const DEEPEST: f64 = 1.05;
const GAP: f64 = 36.0;

const TITLE: Type = Type { size: 25.0, bold: true, colour: INK };
const FACTS: Type = Type { size: 14.5, bold: false, colour: MUTED };
const SIGNATURE: Type = Type { size: 11.5, bold: false, colour: MUTED };

/// One or more views side by side under one title.
#[derive(Clone, Debug)]
pub struct Figure {
    /// What it is.
    pub title: String,
    /// The main numbers, in one line.
    pub facts: String,
    /// From left to right.
    pub panels: Vec<Panel>,
}

/// One view.
#[derive(Clone, Debug)]
pub struct Panel {
    /// What is seen.
    pub heading: String,
    /// Its main number.
    pub note: String,
    /// The marks.
    pub scene: Scene,
}

impl Figure {
    /// The drawing as an SVG document.
    pub fn svg(&self) -> String {
        let count = self.panels.len().max(1) as f64;
        let camera = self.camera();
        let tall = self.panels.iter().map(|p| panel::height(&p.scene, PANEL, &camera)).fold(0.0, f64::max);
        let tall = tall.clamp(SHALLOWEST * PANEL, DEEPEST * PANEL).round();
        let residuals = self.panels.iter().flat_map(|p| &p.scene.loops).map(|l| l.residual);
        let decades = Decades::of(residuals);
        let legend = Legend::of(&self.panels, decades);
        let inner = count * PANEL + (count - 1.0) * GAP;
        let (width, height) = (2.0 * MARGIN + inner, HEADER + tall + legend.height(inner));
        let mut document = sheet(&self.title, &self.facts, (width, height));
        for (i, panel) in self.panels.iter().enumerate() {
            let x = MARGIN + i as f64 * (PANEL + GAP);
            let area = Area { x, y: HEADER, width: PANEL, height: tall };
            document = panel::draw(document, panel, &format!("panel{i}"), area, &camera, decades);
        }
        let footer = Area { x: MARGIN, y: HEADER + tall, width: inner, height: legend.height(inner) };
        legend.draw(document, footer).to_string()
    }

    /// One camera for all panels, chosen for the last: the result.
    fn camera(&self) -> Camera {
        match self.panels.last() {
            Some(last) if self.panels.iter().any(|p| p.scene.spatial) => {
                Camera::isometric(&last.scene.points())
            }
            _ => Camera::plan(),
        }
    }
}

/// A page with its titles.
fn sheet(title: &str, facts: &str, (width, height): (f64, f64)) -> Document {
    Document::new()
        .set("viewBox", (0, 0, width, height))
        .set("width", width)
        .set("height", height)
        .set("font-family", FONTS)
        .add(Title::new(format!("{title}: {facts}")))
        .add(page::rectangle(Area { x: 0.0, y: 0.0, width, height }, PAPER))
        .add(text(title, (MARGIN, 48.0), Anchor::Start, TITLE))
        .add(text(facts, (MARGIN, 73.0), Anchor::Start, FACTS))
        .add(text("boxplus", (width - MARGIN, 48.0), Anchor::End, SIGNATURE))
}

#[cfg(test)]
mod tests;
