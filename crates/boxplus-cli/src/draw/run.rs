//! A filter's run: where it went, and its errors inside their bands.

use super::camera::Camera;
use super::error_chart::ErrorChart;
use super::legend::Legend;
use super::window::Area;
use super::{DEEPEST, GAP, HEADER, MARGIN, PANEL, Panel, SHALLOWEST, panel, sheet};

/// Width of the charts where there is no path beside them.
const ALONE: f64 = 820.0;
/// Height of a chart, at least.
const LOWEST: f64 = 104.0;

/// A path with its band, and beside it the errors over time.
#[derive(Clone, Debug)]
pub struct Run {
    /// What it is.
    pub title: String,
    /// The main numbers, in one line.
    pub facts: String,
    /// Where it went; nothing for what has no place, such as an attitude.
    pub path: Option<Panel>,
    /// From top to bottom; none where nobody knows the truth.
    pub charts: Vec<ErrorChart>,
}

impl Run {
    /// The drawing as an SVG document.
    pub fn svg(&self) -> String {
        let camera = self.camera();
        let path = self.path.as_ref().map_or(0.0, |path| panel::height(&path.scene, PANEL, &camera));
        let wanted = (LOWEST * self.charts.len() as f64).max(path);
        let tall = wanted
            .clamp(SHALLOWEST * PANEL, (DEEPEST * PANEL).max(LOWEST * self.charts.len() as f64))
            .round();
        let (left, width) = match (&self.path, self.charts.is_empty()) {
            (Some(_), false) => (PANEL + GAP, PANEL),
            (Some(_), true) => (PANEL, 0.0),
            (None, _) => (0.0, ALONE),
        };
        let legend = Legend::of_run(self.path.as_slice(), !self.charts.is_empty());
        let inner = left + width;
        let page = (2.0 * MARGIN + inner, HEADER + tall + legend.height(inner));
        let mut document = sheet(&self.title, &self.facts, page);
        if let Some(path) = &self.path {
            let area = Area { x: MARGIN, y: HEADER, width: PANEL, height: tall };
            document = panel::draw(document, path, "path", area, &camera, None);
        }
        let height = tall / self.charts.len().max(1) as f64;
        for (i, chart) in self.charts.iter().enumerate() {
            let area = Area { x: MARGIN + left, y: HEADER + i as f64 * height, width, height };
            document = chart.draw(document, &format!("chart{i}"), area, i + 1 == self.charts.len());
        }
        let footer = Area { x: MARGIN, y: HEADER + tall, width: inner, height: legend.height(inner) };
        legend.draw(document, footer).to_string()
    }

    fn camera(&self) -> Camera {
        match &self.path {
            Some(path) if path.scene.spatial => Camera::isometric(&path.scene.points()),
            _ => Camera::plan(),
        }
    }
}
