//! The picture of `align`: from above, before and after.

use nalgebra::Vector3;

use super::report::AlignDocument;
use crate::draw::{Figure, Panel, Scene};
use crate::text::{count, duration, significant};

/// Points drawn of a cloud; more would hide each other.
const SHOWN: usize = 5000;
/// One point in so many, at each end of each axis, does not widen the picture.
const STRAY: usize = 100;

/// Two panels: the source where it starts and where it was found, upon the target.
pub fn figure(document: &AlignDocument, target: Vec<Vector3<f64>>, source: [Vec<Vector3<f64>>; 2]) -> Figure {
    let frame = Frame::of([&target, &source[1]]);
    let target = frame.some(target);
    let [before, after] = source.map(|cloud| frame.some(cloud));
    let panel = |heading: &str, note, source| Panel {
        heading: heading.to_owned(),
        note,
        scene: Scene { clouds: [target.clone(), source], ..Scene::default() },
    };
    let rmse = format!(
        "{} % matched, rms {} m",
        significant(100.0 * document.fitness, 3),
        significant(document.rmse, 3)
    );
    let panels = vec![panel("Before", String::new(), before), panel("After", rmse, after)];
    let steps = count(document.iterations, "step", "steps");
    let effort = format!("{steps}, {}", duration(document.seconds.prepare + document.seconds.align));
    let points = &document.points;
    Figure {
        title: format!("{} onto {}", stem(&document.source), stem(&document.target)),
        facts: format!(
            "{} onto {} points · {} · {effort}",
            crate::text::grouped(points.source_used),
            crate::text::grouped(points.target_used),
            document.method
        ),
        panels,
    }
}

/// A name without folders.
fn stem(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or(name)
}

/// What is seen from above.
struct Frame {
    low: [f64; 2],
    high: [f64; 2],
}

impl Frame {
    /// Around all but a few points.
    fn of(clouds: [&[Vector3<f64>]; 2]) -> Self {
        let ends = [0, 1].map(|axis| {
            let mut x: Vec<f64> = clouds.into_iter().flatten().map(|p| p[axis]).collect();
            x.sort_unstable_by(f64::total_cmp);
            let stray = x.len() / STRAY;
            let kept = &x[stray..x.len() - stray];
            let (low, high) = (kept.first().copied().unwrap_or(0.0), kept.last().copied().unwrap_or(0.0));
            let room = 0.1 * (high - low);
            (low - room, high + room)
        });
        Self { low: ends.map(|e| e.0), high: ends.map(|e| e.1) }
    }

    /// Some of the points inside, evenly over the cloud.
    fn some(&self, cloud: Vec<Vector3<f64>>) -> Vec<Vector3<f64>> {
        let inside = |p: &Vector3<f64>| (0..2).all(|i| (self.low[i]..=self.high[i]).contains(&p[i]));
        let every = cloud.len().div_ceil(SHOWN).max(1);
        cloud.into_iter().step_by(every).filter(inside).collect()
    }
}
