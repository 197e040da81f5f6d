//! From metres on paper to pixels, with the ticks in between.

use super::camera::Spot;

/// Free room around the drawing, as a part of its extent.
const MARGIN: f64 = 0.06;

/// A rectangle of the page in pixels, y down.
#[derive(Clone, Copy, Debug)]
pub struct Area {
    pub x: f64,
    pub y: f64,
    pub width: f64,
    pub height: f64,
}

/// A rectangle of the page that shows a piece of the paper at one scale for both directions.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    /// On the page.
    pub area: Area,
    /// Pixels per metre.
    pub scale: f64,
    centre: (f64, f64),
}

impl Window {
    /// The window that shows all of `spots`, as large as it fits.
    pub fn fit(area: Area, spots: impl Iterator<Item = Spot>) -> Self {
        let (u, v) = extent(spots);
        let (width, height) = (u.length().max(1e-9), v.length().max(1e-9));
        let scale = (area.width / width).min(area.height / height) * (1.0 - 2.0 * MARGIN);
        let scale = if u.length().max(v.length()) > 0.0 { scale } else { 100.0 };
        Self { area, scale, centre: (u.middle(), v.middle()) }
    }

    /// The pixel of a place on the paper.
    pub fn place(&self, u: f64, v: f64) -> (f64, f64) {
        let Area { x, y, width, height } = self.area;
        (
            x + 0.5 * width + (u - self.centre.0) * self.scale,
            y + 0.5 * height - (v - self.centre.1) * self.scale,
        )
    }

    /// Ticks along the horizontal, as `(metres, pixel)`.
    pub fn horizontal_ticks(&self) -> Vec<(f64, f64)> {
        let half = 0.5 * self.area.width / self.scale;
        let ticks = ticks(self.centre.0 - half, self.centre.0 + half);
        ticks.into_iter().map(|u| (u, self.place(u, 0.0).0)).collect()
    }

    /// Ticks along the vertical, as `(metres, pixel)`.
    pub fn vertical_ticks(&self) -> Vec<(f64, f64)> {
        let half = 0.5 * self.area.height / self.scale;
        let ticks = ticks(self.centre.1 - half, self.centre.1 + half);
        ticks.into_iter().map(|v| (v, self.place(0.0, v).1)).collect()
    }

    /// A round length in metres, about a fifth of the window.
    pub fn round_length(&self) -> f64 {
        round_step(0.22 * self.area.width / self.scale)
    }
}

/// Height over width of what `spots` cover, 1 where they cover nothing.
pub fn aspect(spots: impl Iterator<Item = Spot>) -> f64 {
    let (u, v) = extent(spots);
    if u.length().max(v.length()) > 0.0 { v.length() / u.length() } else { 1.0 }
}

fn extent(spots: impl Iterator<Item = Spot>) -> (Interval, Interval) {
    let (mut u, mut v) = (Interval::EMPTY, Interval::EMPTY);
    for spot in spots {
        u.include(spot.u);
        v.include(spot.v);
    }
    (u, v)
}

struct Interval {
    low: f64,
    high: f64,
}

impl Interval {
    const EMPTY: Self = Self { low: f64::INFINITY, high: f64::NEG_INFINITY };

    fn include(&mut self, x: f64) {
        self.low = self.low.min(x);
        self.high = self.high.max(x);
    }

    fn length(&self) -> f64 {
        (self.high - self.low).max(0.0)
    }

    fn middle(&self) -> f64 {
        if self.low <= self.high { 0.5 * (self.low + self.high) } else { 0.0 }
    }
}

/// The largest of 1, 2, 5 times a power of ten that is not over `x`.
fn round_step(x: f64) -> f64 {
    let power = 10f64.powi(x.log10().floor() as i32);
    let step = [5.0, 2.0, 1.0].into_iter().find(|s| s * power <= x * (1.0 + 1e-9));
    step.unwrap_or(1.0) * power
}

/// Four to eleven round numbers within `[low, high]`.
pub fn ticks(low: f64, high: f64) -> Vec<f64> {
    let step = round_step((high - low) / 4.0);
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    (first..=last.min(first.saturating_add(20))).map(|i| i as f64 * step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const AREA: Area = Area { x: 10.0, y: 20.0, width: 400.0, height: 300.0 };

    fn spot(u: f64, v: f64) -> Spot {
        Spot { u, v, near: 0.0 }
    }

    #[test]
    fn everything_fits_and_aspect_is_equal() {
        let spots = [spot(-3.0, 1.0), spot(50.0, 7.0), spot(2.0, -9.0)];
        let window = Window::fit(AREA, spots.into_iter());
        for s in spots {
            let (x, y) = window.place(s.u, s.v);
            assert!((10.0..410.0).contains(&x) && (20.0..320.0).contains(&y), "{x} {y}");
        }
        let ((x0, y0), (x1, y1)) = (window.place(0.0, 0.0), window.place(1.0, 1.0));
        assert!(((x1 - x0) - (y0 - y1)).abs() < 1e-9);
    }

    #[test]
    fn a_single_point_or_none_is_no_trouble() {
        for spots in [vec![], vec![spot(1e6, 2.0)]] {
            let window = Window::fit(AREA, spots.into_iter());
            assert!(window.scale.is_finite() && !window.horizontal_ticks().is_empty());
        }
    }

    #[test]
    fn ticks_are_round_and_few() {
        assert_eq!(ticks(-0.3, 1.1), [-0.2, 0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0]);
        for k in 0..40 {
            let n = ticks(-1.3, 1.17f64.powi(k)).len();
            assert!((4..=11).contains(&n), "{n}");
        }
    }
}
