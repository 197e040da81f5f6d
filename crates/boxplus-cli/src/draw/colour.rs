//! Colours and the scale of residuals.

use colorous::{Color, PLASMA};

/// The page.
pub const PAPER: Color = Color { r: 0xff, g: 0xff, b: 0xff };
/// Titles.
pub const INK: Color = Color { r: 0x11, g: 0x18, b: 0x27 };
/// Axis labels and captions.
pub const MUTED: Color = Color { r: 0x6b, g: 0x72, b: 0x80 };
/// Grid lines.
pub const GRID: Color = Color { r: 0xe8, g: 0xeb, b: 0xf0 };
/// Trajectories.
pub const TRACK: Color = Color { r: 0x33, g: 0x41, b: 0x55 };
/// Where a trajectory truly went.
pub const TRUTH: Color = Color { r: 0xea, g: 0x58, b: 0x0c };
/// Landmarks.
pub const LANDMARK: Color = Color { r: 0x05, g: 0x96, b: 0x69 };
/// Sightings of landmarks.
pub const SIGHTING: Color = Color { r: 0xa7, g: 0xd8, b: 0xc6 };
/// Point clouds: the one that stays, the one that is moved.
pub const CLOUDS: [Color; 2] = [Color { r: 0x1d, g: 0x6f, b: 0xb8 }, Color { r: 0xe0, g: 0x6c, b: 0x1f }];
/// Covariance ellipses.
pub const ELLIPSE: Color = Color { r: 0x25, g: 0x63, b: 0xeb };

/// The part of the map used: its bright end is invisible on paper.
const RANGE: (f64, f64) = (0.1, 0.87);
/// Decades shown at most; smaller residuals take the first colour.
const DECADES: i32 = 6;

/// `colour` with `amount` ∈ \[0, 1\] of the paper mixed in.
pub fn fade(colour: Color, amount: f64) -> Color {
    let mix = |c: u8, p: u8| steps(f64::from(c) + amount.clamp(0.0, 1.0) * (f64::from(p) - f64::from(c)));
    Color { r: mix(colour.r, PAPER.r), g: mix(colour.g, PAPER.g), b: mix(colour.b, PAPER.b) }
}

/// The nearest whole number in [0, 255].
#[allow(clippy::cast_sign_loss, reason = "clamped")]
pub fn steps(x: f64) -> u8 {
    x.round().clamp(0.0, 255.0) as u8
}

/// The colour at `t` ∈ \[0, 1\] of the residual scale: calm blue to hot orange, perceptually uniform.
pub fn heat(t: f64) -> Color {
    PLASMA.eval_continuous(RANGE.0 + (RANGE.1 - RANGE.0) * t.clamp(0.0, 1.0))
}

/// A logarithmic scale over whole decades.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decades {
    pub low: i32,
    pub high: i32,
}

impl Decades {
    /// The decades that hold these numbers but for the smallest 5 %; `None` where none is positive and finite.
    pub fn of(numbers: impl Iterator<Item = f64>) -> Option<Self> {
        let mut logs: Vec<f64> = numbers.filter(|x| *x > 0.0 && x.is_finite()).map(f64::log10).collect();
        logs.sort_by(f64::total_cmp);
        let high = (logs.last()?.ceil() as i32).clamp(-30, 30);
        let low = logs.get(logs.len() / 20)?.floor() as i32;
        Some(Self { low: low.clamp(high - DECADES, high - 1), high })
    }

    /// Where `x` stands on the scale, in \[0, 1\].
    pub fn position(self, x: f64) -> f64 {
        let t = (x.log10() - f64::from(self.low)) / f64::from(self.high - self.low);
        if t.is_nan() { 1.0 } else { t.clamp(0.0, 1.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_spans_whole_decades() {
        let scale = Decades::of([0.3, 2.0, 40.0].into_iter());
        assert_eq!(scale, Some(Decades { low: -1, high: 2 }));
    }

    #[test]
    fn numbers_that_have_no_logarithm_do_not_count() {
        assert_eq!(Decades::of([0.0, f64::NAN, f64::INFINITY].into_iter()), None);
    }

    #[test]
    fn zero_is_the_first_colour_and_nan_the_last() {
        let scale = Decades { low: -1, high: 2 };
        assert_eq!([0.0, 0.1, 100.0, 1e9, f64::NAN].map(|x| scale.position(x)), [0.0, 0.0, 1.0, 1.0, 1.0]);
    }

    #[test]
    fn equal_numbers_have_a_scale_too() {
        assert_eq!(Decades::of([1.0; 3].into_iter()), Some(Decades { low: -1, high: 0 }));
    }

    #[test]
    fn fading_ends_at_the_paper() {
        assert_eq!([0.0, 1.0].map(|t| fade(INK, t).into_tuple()), [INK, PAPER].map(Color::into_tuple));
    }
}
