//! One view of a pose graph.

use colorous::Color;
use nalgebra::Vector3;
use svg::Document;
use svg::node::element::Group;

use super::band::along;
use super::camera::{Camera, Spot};
use super::colour::{
    CLOUDS, Decades, ELLIPSE, GRID, INK, LANDMARK, MUTED, SIGHTING, TRACK, TRUTH, fade, heat, steps,
};
use super::page::{Anchor, Type, band, clipped, dot, ellipse, line, path, text};
use super::strokes::{Kind, Layer, STEPS, Strokes};
use super::window::{Area, Window, aspect};
use super::{Panel, Scene};

pub const HEADING: Type = Type { size: 15.0, bold: true, colour: INK };
pub const NOTE: Type = Type { size: 13.0, bold: false, colour: MUTED };
pub const TICK: Type = Type { size: 11.5, bold: false, colour: MUTED };

/// Room for the heading, and for the labels of a plan's axes.
const HEADING_ROOM: f64 = 34.0;
const TICK_ROOM: (f64, f64) = (38.0, 24.0);
/// Room for the world axes of a view in space.
const TRIAD_ROOM: f64 = 40.0;
/// How far the farthest line fades into the paper.
const FADE: f64 = 0.7;
/// Up to so many poses each is a dot, too.
const DOTS: usize = 400;
/// Width of a point of a cloud.
const CLOUD_DOT: f64 = 1.4;
/// More ellipses than this hide each other.
const ELLIPSES: usize = 300;
/// √χ²: the quantile of 95 % for two degrees of freedom.
const CONFIDENCE_95: f64 = 2.447_746_830_680_816;

/// The height that a panel of `width` needs to show `scene`.
pub fn height(scene: &Scene, width: f64, camera: &Camera) -> f64 {
    let room = if scene.spatial {
        (0.0, HEADING_ROOM + TRIAD_ROOM)
    } else {
        (TICK_ROOM.0, HEADING_ROOM + TICK_ROOM.1)
    };
    let aspect = aspect(scene.points().iter().map(|p| camera.project(p)));
    (width - room.0) * aspect + room.1
}

/// Adds a panel to the page.
pub fn draw(
    document: Document,
    panel: &Panel,
    id: &str,
    area: Area,
    camera: &Camera,
    decades: Option<Decades>,
) -> Document {
    let scene = &panel.scene;
    let baseline = area.y + 18.0;
    let document = document.add(text(&panel.heading, (area.x, baseline), Anchor::Start, HEADING)).add(text(
        &panel.note,
        (area.x + area.width, baseline),
        Anchor::End,
        NOTE,
    ));
    let room = if scene.spatial { (0.0, 0.0) } else { TICK_ROOM };
    let inner = Area {
        x: area.x + room.0,
        y: area.y + HEADING_ROOM,
        width: area.width - room.0,
        height: area.height - HEADING_ROOM - room.1,
    };
    let spots: Vec<Spot> = scene.points().iter().map(|p| camera.project(p)).collect();
    let view =
        View { camera, window: Window::fit(inner, spots.iter().copied()), depth: Depth::of(&spots, scene) };
    let (clip, mut marks) = clipped(id, inner);
    if !scene.band.is_empty() {
        marks = marks.add(band(along(&scene.band, camera, &view.window), ELLIPSE));
    }
    for (layer, data) in view.strokes(scene, decades).into_paths() {
        marks = marks.add(path(data, view.colour(layer), width(scene, layer.kind)));
    }
    marks = view.add_clouds(marks, scene);
    marks = view.add_dots(marks, scene);
    marks = view.add_ellipses(marks, scene);
    let document = if scene.spatial { document } else { grid(document, &view.window) };
    let document =
        document.add(clip).add(marks.set("stroke-linejoin", "round").set("stroke-linecap", "round"));
    if scene.spatial { triad(document, camera, &view.window) } else { document }
}

struct View<'a> {
    camera: &'a Camera,
    window: Window,
    depth: Depth,
}

/// The range of nearness, in steps; a plan has one step only.
struct Depth {
    far: f64,
    step: f64,
}

impl Depth {
    fn of(spots: &[Spot], scene: &Scene) -> Self {
        let far = spots.iter().map(|s| s.near).fold(f64::INFINITY, f64::min);
        let near = spots.iter().map(|s| s.near).fold(f64::NEG_INFINITY, f64::max);
        let step = if scene.spatial && near > far { (near - far) / f64::from(STEPS) } else { f64::INFINITY };
        Self { far, step }
    }

    fn index(&self, near: f64) -> u8 {
        if self.step.is_finite() {
            steps(((near - self.far) / self.step).floor()).min(STEPS - 1)
        } else {
            STEPS - 1
        }
    }

    fn fade(index: u8) -> f64 {
        FADE * (1.0 - f64::from(index) / f64::from(STEPS - 1))
    }
}

impl View<'_> {
    fn place(&self, p: &Vector3<f64>) -> ((f64, f64), f64) {
        let spot = self.camera.project(p);
        (self.window.place(spot.u, spot.v), spot.near)
    }

    fn strokes(&self, scene: &Scene, decades: Option<Decades>) -> Strokes {
        let mut strokes = Strokes::default();
        let mut add = |kind, colour, ends: [&Vector3<f64>; 2]| {
            let [(from, near), (to, near_too)] = ends.map(|p| self.place(p));
            strokes.segment(
                Layer { depth: self.depth.index(0.5 * (near + near_too)), kind, colour },
                from,
                to,
            );
        };
        for [pose, landmark] in &scene.sightings {
            add(Kind::Sighting, 0, [pose, landmark]);
        }
        for link in &scene.loops {
            let heat = decades.map_or(0.0, |d| d.position(link.residual));
            add(Kind::Loop, steps(heat * f64::from(STEPS - 1)), [&link.ends[0], &link.ends[1]]);
        }
        for pair in scene.truth.windows(2) {
            add(Kind::Truth, 0, [&pair[0], &pair[1]]);
        }
        for pair in scene.tracks.iter().flat_map(|track| track.windows(2)) {
            add(Kind::Track, 0, [&pair[0], &pair[1]]);
        }
        for [centre, corners @ ..] in &scene.views {
            for (i, corner) in corners.iter().enumerate() {
                add(Kind::View, 0, [centre, corner]);
                add(Kind::View, 0, [corner, &corners[(i + 1) % 4]]);
            }
        }
        strokes
    }

    fn colour(&self, layer: Layer) -> Color {
        let colour = match layer.kind {
            Kind::Sighting => SIGHTING,
            Kind::Loop => heat(f64::from(layer.colour) / f64::from(STEPS - 1)),
            Kind::Truth => TRUTH,
            Kind::Track | Kind::View => TRACK,
        };
        if self.depth.step.is_finite() { fade(colour, Depth::fade(layer.depth)) } else { colour }
    }

    /// One path a cloud, of strokes so short that their round ends are dots: a tenth of the size of as many circles.
    fn add_clouds(&self, mut marks: Group, scene: &Scene) -> Group {
        for (cloud, colour) in scene.clouds.iter().zip(CLOUDS) {
            let places = cloud.iter().map(|p| self.place(p).0);
            let dots = places.fold(String::new(), |dots, (x, y)| dots + &format!("M{x:.1} {y:.1}h.1"));
            if !dots.is_empty() {
                marks = marks.add(path(dots, colour, CLOUD_DOT).set("stroke-opacity", 0.7));
            }
        }
        marks
    }

    fn add_dots(&self, mut marks: Group, scene: &Scene) -> Group {
        let poses: Vec<_> = scene.tracks.iter().flatten().collect();
        let shown = if poses.len() <= DOTS && scene.truth.is_empty() { poses } else { Vec::new() };
        for (points, radius, colour) in
            [(shown, 2.0, TRACK), (scene.landmarks.iter().collect(), landmark_radius(scene), LANDMARK)]
        {
            for (place, near) in
                points.into_iter().map(|p| self.place(p)).filter(|(p, _)| p.0.is_finite() && p.1.is_finite())
            {
                let fading =
                    if self.depth.step.is_finite() { Depth::fade(self.depth.index(near)) } else { 0.0 };
                marks = marks.add(dot(place, radius, fade(colour, fading)));
            }
        }
        marks
    }

    fn add_ellipses(&self, mut marks: Group, scene: &Scene) -> Group {
        let every = scene.ellipses.len().div_ceil(ELLIPSES).max(1);
        for shown in scene.ellipses.iter().step_by(every) {
            let axes = self.camera.project_covariance(&shown.covariance).symmetric_eigen();
            let radius = |i: usize| CONFIDENCE_95 * axes.eigenvalues[i].max(0.0).sqrt() * self.window.scale;
            let first = axes.eigenvectors.column(0);
            // The page's y points down.
            let angle = (-first.y).atan2(first.x);
            let (place, _) = self.place(&shown.centre);
            if [place.0, place.1, radius(0), radius(1), angle].iter().all(|x| x.is_finite()) {
                marks = marks.add(ellipse(place, (radius(0), radius(1)), angle, ELLIPSE));
            }
        }
        marks
    }
}

/// Finer lines for larger graphs.
fn width(scene: &Scene, kind: Kind) -> f64 {
    let lines = scene.loops.len() + scene.tracks.iter().map(Vec::len).sum::<usize>();
    let base = (2.5 - 0.4 * (lines.max(1) as f64).log10()).clamp(0.5, 2.0);
    match kind {
        Kind::Track | Kind::Truth => base,
        Kind::Loop => 0.85 * base,
        Kind::Sighting => 0.5,
        Kind::View => 1.1,
    }
}

fn landmark_radius(scene: &Scene) -> f64 {
    if scene.landmarks.len() > 2000 { 1.4 } else { 3.0 }
}

/// Round metres without superfluous zeros; a proper minus.
pub fn metres(x: f64) -> String {
    let x = if x.abs() < 1e-12 { 0.0 } else { x };
    let plain = format!("{:.6}", x.abs());
    let plain = plain.trim_end_matches('0').trim_end_matches('.');
    let sign = if x < 0.0 { "−" } else { "" };
    if x.abs() >= 1e7 { format!("{sign}{:e}", x.abs()) } else { format!("{sign}{plain}") }
}

fn grid(mut document: Document, window: &Window) -> Document {
    let Area { x, y, width, height } = window.area;
    let bottom = y + height;
    for (u, at) in window.horizontal_ticks() {
        document = document.add(line((at, y), (at, bottom), GRID, 1.0));
        if at < x + width - 46.0 {
            document = document.add(text(&metres(u), (at, bottom + 17.0), Anchor::Middle, TICK));
        }
    }
    for (v, at) in window.vertical_ticks() {
        document = document.add(line((x, at), (x + width, at), GRID, 1.0));
        if at > y + 22.0 {
            document = document.add(text(&metres(v), (x - 7.0, at + 4.0), Anchor::End, TICK));
        }
    }
    document.add(text("x [m]", (x + width, bottom + 17.0), Anchor::End, TICK)).add(text(
        "y [m]",
        (x - 7.0, y + 9.0),
        Anchor::End,
        TICK,
    ))
}

/// The world axes and a scale bar: a view in space has no ticks.
fn triad(mut document: Document, camera: &Camera, window: &Window) -> Document {
    let Area { x, y, width, height } = window.area;
    let origin = (x + 34.0, y + height - 26.0);
    for (name, u, v) in camera.axes() {
        let at = |length: f64| (origin.0 + length * u, origin.1 - length * v);
        let label = (at(37.0).0, at(37.0).1 + 4.0);
        document = document.add(line(origin, at(28.0), MUTED, 1.2));
        document = document.add(text(&name.to_string(), label, Anchor::Middle, TICK));
    }
    let (length, right) = (window.round_length(), x + width - 6.0);
    let (left, bar) = (right - length * window.scale, y + height - 14.0);
    document = document.add(line((left, bar), (right, bar), MUTED, 1.6));
    for end in [left, right] {
        document = document.add(line((end, bar - 3.5), (end, bar + 3.5), MUTED, 1.6));
    }
    let label = format!("{} m", metres(length));
    document.add(text(&label, (0.5 * (left + right), bar - 9.0), Anchor::Middle, TICK))
}
