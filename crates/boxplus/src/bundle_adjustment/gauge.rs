//! Where the world is put: images do not say it.

use super::Bundle;
use crate::lie::{Action, LieGroup, SE3};
use crate::partition::Partition;

/// What keeps one part of the world in its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Anchor {
    /// The view that stands where it stood.
    pub view: usize,
    /// The view that is as far from it as it was; `None` where all stand in one place, or where two views are held.
    pub scale: Option<usize>,
}

/// The directions in which the world can be moved, turned and scaled without changing an image, and where it was put.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Gauge {
    /// How many directions are free: seven for each part without a held view, one for each part with one.
    pub free: usize,
    /// One anchor for each part, in the order of their views.
    pub anchors: Vec<Anchor>,
}

/// Views and points that hang together through observations.
struct Part {
    views: Vec<usize>,
    points: Vec<usize>,
}

impl Bundle {
    /// Parts of the problem that no observation joins: they have no place relative to each other. Views and points without
    /// observations are no parts.
    pub fn parts(&self) -> usize {
        self.split().len()
    }

    fn split(&self) -> Vec<Part> {
        let views = self.views.len();
        let mut partition = Partition::new(views + self.points.len());
        let mut read = vec![false; views];
        for o in self.observations.iter().filter(|o| self.joined(o).is_some()) {
            read[o.view as usize] = true;
            partition.join(o.view as usize, views + o.point as usize);
        }
        let (mut parts, mut part_of): (Vec<Part>, _) = (vec![], vec![None; views + self.points.len()]);
        for view in (0..views).filter(|&view| read[view]) {
            let number = *part_of[partition.find(view)].get_or_insert_with(|| {
                parts.push(Part { views: vec![], points: vec![] });
                parts.len() - 1
            });
            parts[number].views.push(view);
        }
        for point in 0..self.points.len() {
            if let Some(number) = part_of[partition.find(views + point)] {
                parts[number].points.push(point);
            }
        }
        parts
    }

    /// Moves, turns and scales every part so that it stands as in `start`: its first view (of those held, where any are) in its
    /// place, and the view farthest from it as far away. Images do not change.
    pub(super) fn stand_as(&mut self, start: &Self, held: &[usize]) -> Gauge {
        let mut gauge = Gauge::default();
        for part in self.split() {
            let of_part: Vec<usize> = part.views.iter().copied().filter(|v| held.contains(v)).collect();
            let view = of_part.first().copied().unwrap_or(part.views[0]);
            let mut scale = None;
            if of_part.len() < 2 {
                gauge.free += if of_part.is_empty() { 7 } else { 1 };
                scale = self.carry(start, &part, view);
            }
            gauge.anchors.push(Anchor { view, scale });
        }
        gauge
    }

    /// Carries one part by p ↦ s·(Q·p) about its anchor; returns the view that says how large it is.
    fn carry(&mut self, start: &Self, part: &Part, anchor: usize) -> Option<usize> {
        let place = |bundle: &Self, view: usize| bundle.views[view].world_from_camera.translation();
        let distance = |bundle: &Self, view: usize| (place(bundle, view) - place(bundle, anchor)).norm();
        let farthest =
            |a: &usize, b: &usize| distance(start, *a).total_cmp(&distance(start, *b)).then(b.cmp(a));
        let ruler = part.views.iter().copied().max_by(farthest);
        let ruler = ruler.filter(|&view| distance(start, view) > 0.0 && distance(self, view) > 0.0);
        let scale = ruler.map_or(1.0, |view| distance(start, view) / distance(self, view));

        let (from, to) = (self.views[anchor].world_from_camera, start.views[anchor].world_from_camera);
        let turn = to.rotation().compose(&from.rotation().inverse());
        let moved = |p| to.translation() + turn.act(&(p - from.translation())) * scale;
        for &view in &part.views {
            let pose = self.views[view].world_from_camera;
            self.views[view].world_from_camera =
                SE3::new(turn.compose(&pose.rotation()), moved(pose.translation()));
        }
        self.views[anchor].world_from_camera = to;
        part.points.iter().for_each(|&point| self.points[point] = moved(self.points[point]));
        ruler
    }
}
