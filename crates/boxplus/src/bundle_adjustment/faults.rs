//! What would make bundle adjustment fail or its result wrong, found before anything is solved.

use super::{Bundle, Line, Observation, Severity};
use crate::camera::Unseen;

/// Something wrong with a problem, with how often it is and where it is first. Prints as one sentence.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// Observations by views that do not exist.
    #[error("{count} observation(s) are by views that do not exist, the first by view {view}")]
    MissingView {
        /// How many.
        count: usize,
        /// The first such view.
        view: u32,
        /// Where it was read.
        line: Line,
    },
    /// Observations of points that do not exist.
    #[error("{count} observation(s) are of points that do not exist, the first of point {point}")]
    MissingPoint {
        /// How many.
        count: usize,
        /// The first such point.
        point: u32,
        /// Where it was read.
        line: Line,
    },
    /// Observations with NaN or infinity.
    #[error(
        "{count} observation(s) hold a number that is not finite, the first of point {point} by view {view}"
    )]
    PixelNotFinite {
        /// How many.
        count: usize,
        /// Its view.
        view: u32,
        /// Its point.
        point: u32,
        /// Where it was read.
        line: Line,
    },
    /// Views with NaN or infinity.
    #[error("{count} view(s) hold a number that is not finite, the first is {view}")]
    ViewNotFinite {
        /// How many.
        count: usize,
        /// The first of them.
        view: usize,
    },
    /// Points with NaN or infinity.
    #[error("{count} point(s) hold a number that is not finite, the first is {point}")]
    PointNotFinite {
        /// How many.
        count: usize,
        /// The first of them.
        point: usize,
    },
    /// Observations of a point by a view that has seen it before.
    #[error(
        "{count} observation(s) are of a point that the view has seen before, the first of point {point} by view {view}"
    )]
    Duplicate {
        /// How many.
        count: usize,
        /// Its view.
        view: u32,
        /// Its point.
        point: u32,
        /// Where it was read.
        line: Line,
    },
    /// Observations of points behind the view, or beyond the fold of its lens.
    #[error(
        "{count} observation(s) are of points behind the camera or beyond its lens, the first of point {point} by view {view}"
    )]
    Unseen {
        /// How many.
        count: usize,
        /// How many of them are behind.
        behind: usize,
        /// The view of the first.
        view: u32,
        /// Its point.
        point: u32,
        /// Where it was read.
        line: Line,
    },
    /// Points of a single observation: their depth is open.
    #[error("{count} point(s) are seen by one view only, so that their depth is open; the first is {point}")]
    SeenOnce {
        /// How many.
        count: usize,
        /// The first of them.
        point: usize,
    },
    /// Views that see fewer points than nine unknowns need.
    #[error("{count} view(s) see fewer than 5 points, too few for pose and camera; the first is {view}")]
    SeesFew {
        /// How many.
        count: usize,
        /// The first of them.
        view: usize,
    },
    /// Points that nobody sees.
    #[error("{count} point(s) are seen by no view and keep their place; the first is {point}")]
    NeverSeen {
        /// How many.
        count: usize,
        /// The first of them.
        point: usize,
    },
}

impl Fault {
    /// How bad it is.
    pub fn severity(&self) -> Severity {
        match self {
            Self::NeverSeen { .. } => Severity::Note,
            Self::Duplicate { .. } | Self::Unseen { .. } | Self::SeenOnce { .. } | Self::SeesFew { .. } => {
                Severity::Warning
            }
            _ => Severity::Error,
        }
    }

    /// Where it was read first, `Line(0)` where no line is at fault.
    pub fn line(&self) -> Line {
        match *self {
            Self::MissingView { line, .. }
            | Self::MissingPoint { line, .. }
            | Self::PixelNotFinite { line, .. }
            | Self::Duplicate { line, .. }
            | Self::Unseen { line, .. } => line,
            _ => Line(0),
        }
    }
}

/// Fewest points from which pose and camera of a view follow: ten numbers for nine unknowns.
const POINTS: usize = 5;

impl Bundle {
    /// Everything wrong with the problem, in the order of the variants of [`Fault`]. Takes O(n log n) for n observations.
    pub fn faults(&self) -> Vec<Fault> {
        let (views, points) = (self.views.len(), self.points.len());
        let mut faults = vec![];
        faults.extend(
            first(self.observations.iter().filter(|o| o.view as usize >= views))
                .map(|(count, o)| Fault::MissingView { count, view: o.view, line: o.line }),
        );
        faults.extend(
            first(self.observations.iter().filter(|o| o.point as usize >= points))
                .map(|(count, o)| Fault::MissingPoint { count, point: o.point, line: o.line }),
        );
        let not_finite = |o: &&Observation| !o.pixel.iter().all(|x| x.is_finite());
        faults.extend(
            first(self.observations.iter().filter(not_finite)).map(|(count, o)| Fault::PixelNotFinite {
                count,
                view: o.view,
                point: o.point,
                line: o.line,
            }),
        );
        faults.extend(
            first((0..views).filter(|&v| !is_finite(&self.views[v])))
                .map(|(count, view)| Fault::ViewNotFinite { count, view }),
        );
        let lost = |&p: &usize| !self.points[p].iter().all(|x| x.is_finite());
        faults.extend(
            first((0..points).filter(lost)).map(|(count, point)| Fault::PointNotFinite { count, point }),
        );
        faults.extend(self.duplicates());
        faults.extend(self.out_of_sight());
        faults.extend(self.loose());
        faults
    }

    fn duplicates(&self) -> Option<Fault> {
        let mut order: Vec<usize> = (0..self.observations.len()).collect();
        let key = |&i: &usize| (self.observations[i].view, self.observations[i].point, i);
        order.sort_unstable_by_key(key);
        let again = order
            .windows(2)
            .filter(|pair| key(&pair[0]).0 == key(&pair[1]).0 && key(&pair[0]).1 == key(&pair[1]).1);
        let again = again.map(|pair| pair[1]);
        let (count, earliest) = (again.clone().count(), again.min()?);
        let o = &self.observations[earliest];
        Some(Fault::Duplicate { count, view: o.view, point: o.point, line: o.line })
    }

    fn out_of_sight(&self) -> Option<Fault> {
        let behind = self.unseen().filter(|(_, why)| *why == Unseen::Behind).count();
        let (count, (o, _)) = first(self.unseen())?;
        Some(Fault::Unseen { count, behind, view: o.view, point: o.point, line: o.line })
    }

    fn loose(&self) -> impl Iterator<Item = Fault> {
        let (mut seen, mut sees) = (vec![0_usize; self.points.len()], vec![0_usize; self.views.len()]);
        for o in &self.observations {
            if self.joined(o).is_some() {
                seen[o.point as usize] += 1;
                sees[o.view as usize] += 1;
            }
        }
        let with = |counts: &[usize], wanted: fn(usize) -> bool| {
            first((0..counts.len()).filter(|&i| wanted(counts[i])))
        };
        let once = with(&seen, |n| n == 1).map(|(count, point)| Fault::SeenOnce { count, point });
        let few = with(&sees, |n| n < POINTS).map(|(count, view)| Fault::SeesFew { count, view });
        let never = with(&seen, |n| n == 0).map(|(count, point)| Fault::NeverSeen { count, point });
        [once, few, never].into_iter().flatten()
    }
}

fn is_finite(view: &super::BalView) -> bool {
    let pose = view.world_from_camera.to_matrix();
    let [k1, k2] = view.camera.distortion;
    pose.iter().chain(&[view.camera.focal, k1, k2]).all(|x| x.is_finite())
}

/// How many there are, and the first.
fn first<T>(mut all: impl Iterator<Item = T>) -> Option<(usize, T)> {
    let first = all.next()?;
    Some((1 + all.count(), first))
}
