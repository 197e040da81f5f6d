//! What would make a solver fail or a map wrong, found before anything is solved.

use super::constraint::{Constraint, Kind, VertexKind};
use super::ids::Ids;
use super::information::{InformationProblem, spectrum};
use super::{Label, Line, PoseGraph};
use crate::partition::Partition;
use core::cmp::Ordering;

/// How bad a [`Fault`] is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Odd, harmless.
    Note,
    /// The graph can be solved, but probably says something else than was meant.
    Warning,
    /// The graph cannot be solved as it is.
    Error,
}

/// Something wrong with a pose graph. Prints as one sentence, without the line.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// A measurement of a vertex that does not exist, in a graph that has vertices.
    #[error("{kind} refers to {}, which is no vertex", Label(*id))]
    MissingVertex {
        /// The measurement.
        kind: Kind,
        /// The vertex that is missing.
        id: u64,
        /// Where it was read.
        line: Line,
    },
    /// A measurement of a vertex of another kind.
    #[error("{kind} refers to {} as a {expected}, but it is a {found}", Label(*id))]
    WrongVertex {
        /// The measurement.
        kind: Kind,
        /// The vertex.
        id: u64,
        /// What the measurement needs.
        expected: VertexKind,
        /// What the vertex is.
        found: VertexKind,
        /// Where it was read.
        line: Line,
    },
    /// A measurement by a sensor that is not on the body.
    #[error("{kind} refers to sensor offset {offset}, which does not exist; add PARAMS_SE3OFFSET {offset}")]
    MissingOffset {
        /// The measurement.
        kind: Kind,
        /// The offset that is missing.
        offset: u64,
        /// Where it was read.
        line: Line,
    },
    /// A fixed vertex that does not exist.
    #[error("{} is to be fixed, but is no vertex", Label(*id))]
    MissingFixed {
        /// The vertex that is missing.
        id: u64,
    },
    /// Two vertices with one id.
    #[error("the vertex {} is given twice, first in line {}", Label(*id), first.0)]
    DuplicateVertex {
        /// The id.
        id: u64,
        /// Where it was read first.
        first: Line,
        /// Where it was read again.
        line: Line,
    },
    /// A measurement of a vertex against itself.
    #[error("{kind} joins {} to itself", Label(*id))]
    SelfLoop {
        /// The measurement.
        kind: Kind,
        /// The vertex.
        id: u64,
        /// Where it was read.
        line: Line,
    },
    /// An information matrix that is no inverse covariance.
    #[error("{kind} of {}: the information matrix {problem}", Label(*from))]
    Information {
        /// The measurement.
        kind: Kind,
        /// Its first vertex.
        from: u64,
        /// Its second vertex.
        to: Option<u64>,
        /// What is wrong.
        problem: InformationProblem,
        /// Where it was read.
        line: Line,
    },
    /// The same measurement, to the last bit, more than once.
    #[error("{kind} from {} to {} is given {count} times with the same numbers, first in line {}", Label(*from), Label(*to), first.0)]
    Repeated {
        /// The measurement.
        kind: Kind,
        /// Its first vertex.
        from: u64,
        /// Its second vertex.
        to: u64,
        /// How often it is given.
        count: usize,
        /// Where it was read first.
        first: Line,
        /// Where it was read next.
        line: Line,
    },
    /// Vertices that no chain of measurements joins to the rest.
    #[error(
        "the graph falls into {components} parts; the largest has {largest} vertices, and {} is not in it",
        Label(*id)
    )]
    Disconnected {
        /// How many parts.
        components: usize,
        /// How many vertices the largest has.
        largest: usize,
        /// The lowest id outside the largest.
        id: u64,
    },
    /// A quaternion that was far from unit norm when it was read.
    #[error("a quaternion has the norm {norm:.6}; it was normalised")]
    QuaternionNorm {
        /// Its norm.
        norm: f64,
        /// Where it was read.
        line: Line,
    },
}

impl Fault {
    /// How bad it is.
    pub fn severity(&self) -> Severity {
        match self {
            Self::Repeated { .. } => Severity::Note,
            Self::SelfLoop { .. }
            | Self::MissingFixed { .. }
            | Self::Disconnected { .. }
            | Self::QuaternionNorm { .. }
            | Self::Information {
                problem: InformationProblem::Zero | InformationProblem::Singular { .. },
                ..
            } => Severity::Warning,
            _ => Severity::Error,
        }
    }

    /// Where it was read, `Line(0)` where no single line is at fault.
    pub fn line(&self) -> Line {
        match *self {
            Self::MissingVertex { line, .. }
            | Self::WrongVertex { line, .. }
            | Self::MissingOffset { line, .. }
            | Self::DuplicateVertex { line, .. }
            | Self::SelfLoop { line, .. }
            | Self::Information { line, .. }
            | Self::Repeated { line, .. }
            | Self::QuaternionNorm { line, .. } => line,
            Self::MissingFixed { .. } | Self::Disconnected { .. } => Line(0),
        }
    }
}

impl PoseGraph {
    /// Everything wrong with the graph, in the order: vertices, references, self loops, information, repetitions, connection.
    ///
    /// Takes O(n log n) for n vertices and measurements, whatever they join.
    ///
    /// ```
    /// use boxplus::{io, pose_graph::Severity};
    /// let text = b"VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 1 1 0 0 1 2 0 1 0 1\n";
    /// let fault = io::read(text, "two.g2o", None)?.graph.faults()[0];
    /// assert_eq!((fault.line().0, fault.severity()), (3, Severity::Error));
    /// assert!(fault.to_string().contains("not positive definite: its smallest eigenvalue is -1.000e0"));
    /// # Ok::<(), io::IoError>(())
    /// ```
    pub fn faults(&self) -> Vec<Fault> {
        let mut faults = Vec::new();
        let vertices = self.sorted_vertices(&mut faults);
        self.find_missing(&vertices, &mut faults);
        self.find_self_loops(&mut faults);
        self.find_bad_information(&mut faults);
        self.find_repeated(&mut faults);
        self.find_parts(&mut faults);
        faults
    }

    /// All ids that a vertex or a measurement names.
    pub(super) fn ids(&self) -> Ids {
        let of_vertices = self.vertices().map(|(id, ..)| id);
        Ids::new(of_vertices).with(self.constraints().flat_map(|c| [c.from, c.to.unwrap_or(c.from)]))
    }

    /// Which of the [`PoseGraph::ids`] hang together.
    pub(super) fn partition(&self, ids: &Ids) -> Partition {
        let mut partition = Partition::new(ids.len());
        for c in self.constraints() {
            if let (Some(i), Some(j)) = (ids.index(c.from), c.to.and_then(|to| ids.index(to))) {
                partition.join(i, j);
            }
        }
        partition
    }

    fn sorted_vertices(&self, faults: &mut Vec<Fault>) -> (Ids, Vec<VertexKind>) {
        let mut vertices: Vec<_> = self.vertices().collect();
        vertices.sort_by_key(|(id, ..)| *id); // stable: the first given stays first
        let repeated = vertices.windows(2).filter(|pair| pair[0].0 == pair[1].0);
        faults.extend(repeated.map(|p| Fault::DuplicateVertex { id: p[0].0, first: p[0].2, line: p[1].2 }));
        vertices.dedup_by_key(|(id, ..)| *id);
        (Ids::new(vertices.iter().map(|v| v.0)), vertices.iter().map(|v| v.1).collect())
    }

    fn find_missing(&self, (ids, kinds): &(Ids, Vec<VertexKind>), faults: &mut Vec<Fault>) {
        let offsets = Ids::new(self.offsets3.iter().map(|o| o.id));
        for Constraint { kind, from, to, offset, line, .. } in self.constraints() {
            let found = |id| ids.index(id).map(|i| kinds[i]);
            let mut expected = [kind.from_kind(), kind.to_kind()];
            if kind == Kind::Range {
                expected[1] =
                    found(from).map(|start| to.and_then(found).map_or(start, |end| start.beside(end)));
            }
            for (id, expected) in [Some(from), to].into_iter().zip(expected) {
                match (id, id.and_then(found), expected) {
                    (Some(id), Some(found), Some(expected)) if found != expected => {
                        faults.push(Fault::WrongVertex { kind, id, expected, found, line });
                    }
                    (Some(id), None, _) if ids.len() > 0 => {
                        faults.push(Fault::MissingVertex { kind, id, line });
                    }
                    _ => {}
                }
            }
            let missing = offset.filter(|&id| offsets.index(id).is_none());
            faults.extend(missing.map(|offset| Fault::MissingOffset { kind, offset, line }));
        }
        let named = if ids.len() > 0 { ids } else { &self.ids() };
        let missing = self.fixed.iter().filter(|&&id| named.index(id).is_none());
        faults.extend(missing.map(|&id| Fault::MissingFixed { id }));
    }

    fn find_self_loops(&self, faults: &mut Vec<Fault>) {
        let loops = self.constraints().filter(|c| c.to == Some(c.from));
        faults.extend(loops.map(|c| Fault::SelfLoop { kind: c.kind, id: c.from, line: c.line }));
    }

    fn find_bad_information(&self, faults: &mut Vec<Fault>) {
        let mut last: (&[f64], _) = (&[], None);
        for Constraint { kind, from, to, information, line, .. } in self.constraints() {
            // Most files use few different matrices.
            if last.0 != information {
                last = (information, spectrum(information).err());
            }
            faults.extend(last.1.map(|problem| Fault::Information { kind, from, to, problem, line }));
        }
    }

    fn find_repeated(&self, faults: &mut Vec<Fault>) {
        let mut binary: Vec<_> = self.constraints().filter(|c| c.to.is_some()).collect();
        binary.sort_by(compare); // stable: in the order of the file
        for run in binary.chunk_by(|a, b| compare(a, b) == Ordering::Equal).filter(|run| run.len() > 1) {
            let Constraint { kind, from, to, line: first, .. } = run[0];
            let (to, count, line) = (to.unwrap_or(from), run.len(), run[1].line);
            faults.push(Fault::Repeated { kind, from, to, count, first, line });
        }
    }

    fn find_parts(&self, faults: &mut Vec<Fault>) {
        let ids = self.ids();
        let mut partition = self.partition(&ids);
        let components = partition.parts().count();
        let Some((root, largest)) =
            partition.parts().max_by_key(|(_, size)| *size).filter(|_| components > 1)
        else {
            return;
        };
        let outside = (0..ids.len()).find(|&i| partition.find(i) != root);
        faults.extend(outside.map(|i| Fault::Disconnected { components, largest, id: ids.as_slice()[i] }));
    }
}

/// Orders measurements by what they join, then by every number.
fn compare(a: &Constraint<'_>, b: &Constraint<'_>) -> Ordering {
    let joins = |c: &Constraint<'_>| (c.kind, c.from, c.to, c.offset);
    let by_numbers = |a: &[f64], b: &[f64]| {
        a.iter().zip(b).map(|(x, y)| x.total_cmp(y)).find(|o| o.is_ne()).unwrap_or(Ordering::Equal)
    };
    joins(a)
        .cmp(&joins(b))
        .then_with(|| by_numbers(&a.measured.numbers(), &b.measured.numbers()))
        .then_with(|| by_numbers(a.information, b.information))
}
