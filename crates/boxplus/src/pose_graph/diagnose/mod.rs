//! What is wrong with a pose graph, in the words of whoever made it.
//!
//! [`PoseGraph::diagnose`] asks, in this order: can it be read ([`Fault`]s, numbers that are not finite); does it have a place
//! ([`Part`]s adrift); is everything seen ([`Conditioning`]); do the measurements agree ([`Fit`]). Each answer is
//! data with the ids and lines at fault. What cannot be asked, because something before it is wrong, is `None`.
//!
//! ```
//! use boxplus::pose_graph::simulate::{Options, Simulator};
//! let graph = Simulator::Manhattan.simulate(&Options { size: Some(300), seed: 1, ..Options::default() })?.graph;
//! let (spoilt, places) = graph.with_false_closures(0.1, 1)?;
//! let fit = spoilt.diagnose().fit.unwrap();
//! assert!(fit.contradicting.iter().flatten().count() >= places.len() - 1);
//! # Ok::<(), boxplus::pose_graph::simulate::OptionsError>(())
//! ```

mod fit;
mod parts;

pub use fit::{Fit, KindFit, Scale};
pub use parts::{Freedom, Part};

use super::solve::problem::Problem;
use super::solve::{Indefinite, SolveSettings};
use super::{Constraint, Fault, Kind, Line, PoseGraph, PoseGraphError, Severity};
use crate::graph::Conditioning;

/// A vertex or measurement with a number that is NaN or infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NotFinite {
    /// The kind of the measurement; `None` for the value of a vertex.
    pub kind: Option<Kind>,
    /// The vertex, or the first of the measurement.
    pub id: u64,
    /// The second vertex of the measurement.
    pub to: Option<u64>,
    /// Where it was read.
    pub line: Line,
}

/// What [`PoseGraph::diagnose`] found.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// What is wrong before anything is solved, e.g. information matrices that are not positive definite, repeated edges.
    pub faults: Vec<Fault>,
    /// Values and measurements that are not finite numbers.
    pub not_finite: Vec<NotFinite>,
    /// The parts that no measurement joins, largest first, and how each may move as a whole.
    pub parts: Vec<Part>,
    /// What is free and what is weak within the parts; measurements without positive definite information left out.
    pub conditioning: Option<Conditioning>,
    /// How well the measurements agree at the optimum.
    pub fit: Option<Fit>,
    /// Why the last two could not be asked.
    pub stopped: Option<PoseGraphError>,
}

impl Diagnosis {
    /// Whether the data determine all but where each part lies in the world, and no part is adrift from another.
    pub fn determined(&self) -> bool {
        let adrift = self.parts.len() > 1 && self.parts.iter().any(|part| part.freedom != Freedom::None);
        let free = self.conditioning.as_ref().is_none_or(|c| c.unconstrained.is_some());
        !adrift && !free
    }

    /// Whether nothing at all was found: no fault but notes, everything determined, and all measurements agree as they
    /// claim to.
    pub fn healthy(&self) -> bool {
        self.determined()
            && self.not_finite.is_empty()
            && self.faults.iter().all(|fault| fault.severity() == Severity::Note)
            && self
                .fit
                .as_ref()
                .is_some_and(|fit| fit.contradicting.is_empty() && fit.scale == Scale::Plausible)
    }
}

impl PoseGraph {
    /// Looks for everything that is wrong: see the [module](self). Solves the graph, with and without false loop closures
    /// left out, and so takes as long as a few solves.
    pub fn diagnose(&self) -> Diagnosis {
        let mut diagnosis = Diagnosis {
            faults: self.faults(),
            not_finite: self.not_finite(),
            parts: parts::parts(self),
            conditioning: None,
            fit: None,
            stopped: None,
        };
        if diagnosis.not_finite.is_empty() {
            diagnosis.stopped = self.examine(&mut diagnosis).err();
        }
        diagnosis
    }

    fn examine(&self, diagnosis: &mut Diagnosis) -> Result<(), PoseGraphError> {
        let settings = SolveSettings { indefinite: Indefinite::Skip, ..SolveSettings::default() };
        let (fit, solved) = fit::fit(self, &settings)?;
        let problem = Problem::new(&solved.graph, &settings)?;
        diagnosis.conditioning = Some(problem.factors.conditioning(&problem.values)?);
        diagnosis.fit = Some(fit);
        Ok(())
    }

    fn not_finite(&self) -> Vec<NotFinite> {
        fn bad<T>(vertices: &[super::Vertex<T>], finite: impl Fn(&T) -> bool) -> Vec<NotFinite> {
            let bad = vertices.iter().filter(|v| !finite(&v.value));
            bad.map(|v| NotFinite { kind: None, id: v.id, to: None, line: v.line }).collect()
        }
        let finite = |numbers: &[f64]| numbers.iter().all(|x| x.is_finite());
        let mut found = bad(&self.poses2, |x| finite(&super::Measured::Pose2(x).numbers()));
        found.extend(bad(&self.poses3, |x| finite(&super::Measured::Pose3(x).numbers())));
        found.extend(bad(&self.points2, |x| finite(x.as_slice())));
        found.extend(bad(&self.points3, |x| finite(x.as_slice())));
        let measured =
            self.constraints().filter(|c| !finite(&c.measured.numbers()) || !finite(c.information));
        let name = |c: Constraint<'_>| NotFinite { kind: Some(c.kind), id: c.from, to: c.to, line: c.line };
        found.extend(measured.map(name));
        found
    }
}
