//! The few SVG elements the drawing is made of.

use colorous::Color;
use svg::node::element::{Circle, Element, Ellipse, Line, Path, Rectangle, Text};

use super::window::Area;

/// Inter is in the PNG; the others are there for a browser that lacks it.
pub const FONTS: &str =
    "Inter, -apple-system, 'Segoe UI', 'Helvetica Neue', Arial, 'DejaVu Sans', sans-serif";

/// `#rrggbb`.
fn hex(colour: Color) -> String {
    format!("#{colour:x}")
}

/// Pixels to a hundredth.
pub fn pixels(x: f64) -> f64 {
    (x * 100.0).round() / 100.0
}

/// How a text stands to its place.
#[derive(Clone, Copy, Debug)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// A text style.
#[derive(Clone, Copy, Debug)]
pub struct Type {
    pub size: f64,
    pub bold: bool,
    pub colour: Color,
}

/// One line of text on the baseline `(x, y)`.
pub fn text(content: &str, (x, y): (f64, f64), anchor: Anchor, style: Type) -> Text {
    let anchor = match anchor {
        Anchor::Start => "start",
        Anchor::Middle => "middle",
        Anchor::End => "end",
    };
    let weight = if style.bold { 600 } else { 400 };
    Text::new(content)
        .set("x", pixels(x))
        .set("y", pixels(y))
        .set("text-anchor", anchor)
        .set("font-size", style.size)
        .set("font-weight", weight)
        .set("fill", hex(style.colour))
}

/// A straight line.
pub fn line((x1, y1): (f64, f64), (x2, y2): (f64, f64), colour: Color, width: f64) -> Line {
    let line =
        Line::new().set("x1", pixels(x1)).set("y1", pixels(y1)).set("x2", pixels(x2)).set("y2", pixels(y2));
    line.set("stroke", hex(colour)).set("stroke-width", pixels(width)).set("stroke-linecap", "round")
}

/// An open path.
pub fn path(data: String, colour: Color, width: f64) -> Path {
    Path::new()
        .set("d", data)
        .set("stroke", hex(colour))
        .set("stroke-width", pixels(width))
        .set("fill", "none")
}

/// A closed path, filled so that what is below shines through.
pub fn band(data: String, colour: Color) -> Path {
    Path::new().set("d", data).set("fill", hex(colour)).set("fill-opacity", 0.2).set("stroke", "none")
}

/// A filled rectangle.
pub fn rectangle(area: Area, colour: Color) -> Rectangle {
    let Area { x, y, width, height } = area;
    let shape = Rectangle::new().set("x", pixels(x)).set("y", pixels(y));
    shape.set("width", pixels(width)).set("height", pixels(height)).set("fill", hex(colour))
}

/// A filled dot.
pub fn dot((x, y): (f64, f64), radius: f64, colour: Color) -> Circle {
    Circle::new().set("cx", pixels(x)).set("cy", pixels(y)).set("r", pixels(radius)).set("fill", hex(colour))
}

/// An ellipse with half axes `radii`, the first at `angle` (clockwise on the page, radians).
pub fn ellipse((x, y): (f64, f64), radii: (f64, f64), angle: f64, colour: Color) -> Ellipse {
    let (x, y) = (pixels(x), pixels(y));
    let shape =
        Ellipse::new().set("cx", x).set("cy", y).set("rx", pixels(radii.0)).set("ry", pixels(radii.1));
    let shape = shape.set("transform", format!("rotate({} {x} {y})", pixels(angle.to_degrees())));
    let shape = shape.set("fill", hex(colour)).set("fill-opacity", 0.12);
    shape.set("stroke", hex(colour)).set("stroke-width", 0.8).set("stroke-opacity", 0.75)
}

/// A group that clips what leaves `area`.
pub fn clipped(id: &str, area: Area) -> (Element, svg::node::element::Group) {
    let mut clip = Element::new("clipPath");
    svg::Node::assign(&mut clip, "id", id);
    svg::Node::append(&mut clip, rectangle(area, super::colour::PAPER));
    (clip, svg::node::element::Group::new().set("clip-path", format!("url(#{id})")))
}
