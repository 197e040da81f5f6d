//! Loop closures that were never measured.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{OptionsError, PoseGraph};
use crate::pose_graph::{Edge, Line};

impl PoseGraph {
    /// The graph with false loop closures, until they are `share` (0…1, less than 1) of all; and their places among
    /// [`PoseGraph::constraints`]. Each takes the measured displacement and the information of a true closure drawn at random and claims
    /// it of two poses drawn at random that do not follow each other, as a place recognition does that is wrong: the
    /// displacement is plausible, the poses are not. The same seed gives the same closures. A graph without closures is
    /// returned as it is.
    ///
    /// ```
    /// use boxplus::pose_graph::simulate::{Options, Simulator};
    /// let graph = Simulator::Sphere.simulate(&Options { size: Some(400), ..Options::default() })?.graph;
    /// let (spoilt, places) = graph.with_false_closures(0.5, 7)?;
    /// assert_eq!((places.len(), spoilt.edges3.len()), (380, graph.edges3.len() + 380));
    /// # Ok::<(), boxplus::pose_graph::simulate::OptionsError>(())
    /// ```
    ///
    /// # Errors
    /// [`OptionsError::Chance`] for a share out of range.
    pub fn with_false_closures(&self, share: f64, seed: u64) -> Result<(Self, Vec<usize>), OptionsError> {
        if !(0.0..1.0).contains(&share) {
            return Err(OptionsError::Chance { name: "share", value: share });
        }
        let closes = self.loop_closures();
        let (flat, spatial) = closes[..self.edges2.len() + self.edges3.len()].split_at(self.edges2.len());
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut out = self.clone();
        let first = out.edges2.len();
        spoil(&mut out.edges2, flat, share, &mut rng);
        let second = out.edges2.len() + out.edges3.len();
        let mut places: Vec<usize> = (first..out.edges2.len()).collect();
        spoil(&mut out.edges3, spatial, share, &mut rng);
        places.extend(second..out.edges2.len() + out.edges3.len());
        Ok((out, places))
    }
}

/// Appends false closures made of the true ones, which `closes` marks.
fn spoil<Z: Clone, const D: usize>(
    edges: &mut Vec<Edge<Z, D>>,
    closes: &[bool],
    share: f64,
    rng: &mut ChaCha8Rng,
) {
    let closures: Vec<usize> = (0..edges.len()).filter(|&i| closes[i]).collect();
    let mut ids: Vec<u64> = edges.iter().flat_map(|e| [e.from, e.to]).collect();
    ids.sort_unstable();
    ids.dedup();
    if closures.is_empty() || ids.len() < 3 {
        return;
    }
    let (given, wanted) = (edges.len(), share / (1.0 - share) * closures.len() as f64);
    while ((edges.len() - given) as f64) < wanted - 0.5 {
        let (i, j) = (rng.random_range(0..ids.len()), rng.random_range(0..ids.len()));
        if i.abs_diff(j) > 1 {
            let like = edges[closures[rng.random_range(0..closures.len())]].clone();
            edges.push(Edge { from: ids[i.min(j)], to: ids[i.max(j)], line: Line(0), ..like });
        }
    }
}
