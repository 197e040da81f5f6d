//! The PyFG format of range-aided maps (Papalia, Fishberg, O'Neill, How, Rosen & Leonard, 2024): g2o's tags with a time
//! before the names, names of a letter and a number, and covariances in the place of information matrices.

use super::Format;
use super::elements::{
    Print, Printer, Read, other, point2, point3, pose2, pose3, print_point, print_pose2, print_pose3,
    print_upper_triangle, scalar, upper_triangle,
};
use super::error::{IoErrorKind, WriteError};
use super::scan::{Fields, Layouts, Scan};
use crate::lie::{LieGroup, SE3};
use crate::pose_graph::{Edge, Label, Line, Offset, PoseGraph, Prior, Prior3, Sighting3, Stamp, Vertex};
use nalgebra::SMatrix;
use std::collections::{HashMap, HashSet};

pub(super) const LAYOUTS: Layouts = &[
    ("VERTEX_SE2", "time name x y theta"),
    ("VERTEX_SE3:QUAT", "time name x y z qx qy qz qw"),
    ("VERTEX_XY", "name x y"),
    ("VERTEX_XYZ", "name x y z"),
    ("VERTEX_SE2:PRIOR", "time name x y theta covariance(6)"),
    ("VERTEX_SE3:QUAT:PRIOR", "time name x y z qx qy qz qw covariance(21)"),
    ("VERTEX_XY:PRIOR", "time name x y covariance(3)"),
    ("VERTEX_XYZ:PRIOR", "time name x y z covariance(6)"),
    ("EDGE_SE2", "time from to x y theta covariance(6)"),
    ("EDGE_SE3:QUAT", "time from to x y z qx qy qz qw covariance(21)"),
    ("EDGE_SE2_XY", "time from to x y covariance(3)"),
    ("EDGE_SE3_XYZ", "time from to x y z covariance(6)"),
    ("EDGE_RANGE", "time from to range variance"),
];

/// The sensor offset of every point in space: none.
const ON_BODY: u64 = 0;

/// Reads one line.
pub(super) fn read_line(f: &mut Fields<'_>, graph: &mut PoseGraph) -> Scan<()> {
    match f.tag {
        b"EDGE_RANGE" => graph.ranges.push(edge(f, scalar)?),
        b"EDGE_SE2" => graph.edges2.push(edge(f, pose2)?),
        b"EDGE_SE3:QUAT" => graph.edges3.push(edge(f, pose3)?),
        b"EDGE_SE2_XY" => graph.sightings2.push(edge(f, point2)?),
        b"EDGE_SE3_XYZ" => {
            let Edge { from, to, measured, information, line } = edge(f, point3)?;
            graph.sightings3.push(Sighting3 { from, to, offset: ON_BODY, measured, information, line });
        }
        b"VERTEX_SE2" => {
            let vertex = stamped(f, pose2, &mut graph.stamps)?;
            graph.poses2.push(vertex);
        }
        b"VERTEX_SE3:QUAT" => {
            let vertex = stamped(f, pose3, &mut graph.stamps)?;
            graph.poses3.push(vertex);
        }
        b"VERTEX_XY" => graph.points2.push(vertex(f, point2)?),
        b"VERTEX_XYZ" => graph.points3.push(vertex(f, point3)?),
        b"VERTEX_SE2:PRIOR" => graph.priors2.push(prior(f, pose2)?),
        b"VERTEX_XY:PRIOR" => graph.point_priors2.push(prior(f, point2)?),
        b"VERTEX_XYZ:PRIOR" => graph.point_priors3.push(prior(f, point3)?),
        b"VERTEX_SE3:QUAT:PRIOR" => {
            let Prior { id, measured, information, line } = prior(f, pose3)?;
            graph.priors3.push(Prior3 { id, offset: ON_BODY, measured, information, line });
        }
        _ => graph.other.push(other(f)?),
    }
    f.finish()
}

/// Adds the sensor offset that measurements in space refer to.
pub(super) fn add_offset(graph: &mut PoseGraph) {
    if !(graph.sightings3.is_empty() && graph.priors3.is_empty()) {
        graph.offsets3.push(Offset { id: ON_BODY, value: SE3::identity(), line: Line(0) });
    }
}

fn vertex<T>(f: &mut Fields<'_>, value: Read<T>) -> Scan<Vertex<T>> {
    Ok(Vertex { id: f.name()?, value: value(f)?, line: f.line() })
}

fn stamped<T>(f: &mut Fields<'_>, value: Read<T>, stamps: &mut Vec<Stamp>) -> Scan<Vertex<T>> {
    let seconds = f.number()?;
    let vertex = vertex(f, value)?;
    stamps.push(Stamp { id: vertex.id, seconds });
    Ok(vertex)
}

fn edge<Z, const D: usize>(f: &mut Fields<'_>, value: Read<Z>) -> Scan<Edge<Z, D>> {
    f.number()?; // the time of the measurement, which its poses have, too
    let (from, to) = (f.name()?, f.name()?);
    Ok(Edge { from, to, measured: value(f)?, information: inverse(f)?, line: f.line() })
}

fn prior<Z, const D: usize>(f: &mut Fields<'_>, value: Read<Z>) -> Scan<Prior<Z, D>> {
    f.number()?;
    Ok(Prior { id: f.name()?, measured: value(f)?, information: inverse(f)?, line: f.line() })
}

/// The inverse of the covariance that follows.
fn inverse<const D: usize>(f: &mut Fields<'_>) -> Scan<SMatrix<f64, D, D>> {
    let first = f.next_start();
    let mut covariance: SMatrix<f64, D, D> = upper_triangle(f)?;
    covariance.fill_lower_triangle_with_upper_triangle();
    inverted(&covariance).ok_or_else(|| f.fail_from(first, IoErrorKind::NoCovariance).into())
}

/// The inverse, symmetric to the last bit; `None` where the matrix is not positive definite.
fn inverted<const D: usize>(matrix: &SMatrix<f64, D, D>) -> Option<SMatrix<f64, D, D>> {
    let mut inverse = matrix.cholesky()?.inverse();
    inverse.fill_lower_triangle_with_upper_triangle();
    inverse.iter().all(|x| x.is_finite()).then_some(inverse)
}

/// Writes a graph: vertices, priors, measurements.
pub(super) fn write(graph: &PoseGraph, p: &mut Printer) -> Result<(), WriteError> {
    representable(graph)?;
    let stamps = graph.stamps.iter().map(|stamp| (stamp.id, stamp.seconds)).collect();
    let out = &mut Out { printer: p, graph, stamps };
    out.vertices()?;
    out.priors()?;
    out.edges("EDGE_SE2", &graph.edges2, print_pose2)?;
    out.edges("EDGE_SE3:QUAT", &graph.edges3, print_pose3)?;
    out.edges("EDGE_SE2_XY", &graph.sightings2, print_point)?;
    for &Sighting3 { from, to, measured, information, line, .. } in &graph.sightings3 {
        out.edges("EDGE_SE3_XYZ", &[Edge { from, to, measured, information, line }], print_point)?;
    }
    out.edges("EDGE_RANGE", &graph.ranges, |p, z| p.number(*z))?;
    Ok(())
}

fn representable(graph: &PoseGraph) -> Result<(), WriteError> {
    let on_body = |o: &&Offset<SE3>| o.value == SE3::identity();
    let moved = graph.offsets3.len() - graph.offsets3.iter().filter(on_body).count();
    let vertices = graph.vertices().map(|(id, ..)| id);
    let ids = vertices.chain(graph.constraints().flat_map(|c| [c.from, c.to.unwrap_or(c.from)]));
    let unnamed = ids.filter(|&id| Label(id).letter().is_none()).collect::<HashSet<u64>>().len();
    super::refuse(
        Format::Pyfg,
        &[
            ("bearings", graph.bearings2.len()),
            ("fixed vertices", graph.fixed.len()),
            ("sensor offsets", graph.offsets2.len() + moved),
            ("vertices whose names are bare numbers", unnamed),
        ],
    )
}

/// A graph on its way into text.
struct Out<'a> {
    printer: &'a mut Printer,
    graph: &'a PoseGraph,
    stamps: HashMap<u64, f64>,
}

impl Out<'_> {
    fn vertices(&mut self) -> Result<(), WriteError> {
        let graph = self.graph;
        for v in &graph.poses2 {
            self.line("VERTEX_SE2", (Some(v.id), &[v.id]), |p| print_pose2(p, &v.value))?;
        }
        for v in &graph.poses3 {
            self.line("VERTEX_SE3:QUAT", (Some(v.id), &[v.id]), |p| print_pose3(p, &v.value))?;
        }
        for v in &graph.points2 {
            self.line("VERTEX_XY", (None, &[v.id]), |p| print_point(p, &v.value))?;
        }
        for v in &graph.points3 {
            self.line("VERTEX_XYZ", (None, &[v.id]), |p| print_point(p, &v.value))?;
        }
        Ok(())
    }

    fn priors(&mut self) -> Result<(), WriteError> {
        let graph = self.graph;
        for x in &graph.priors2 {
            self.prior("VERTEX_SE2:PRIOR", x, print_pose2)?;
        }
        for &Prior3 { id, measured, information, line, .. } in &graph.priors3 {
            self.prior("VERTEX_SE3:QUAT:PRIOR", &Prior { id, measured, information, line }, print_pose3)?;
        }
        for x in &graph.point_priors2 {
            self.prior("VERTEX_XY:PRIOR", x, print_point)?;
        }
        for x in &graph.point_priors3 {
            self.prior("VERTEX_XYZ:PRIOR", x, print_point)?;
        }
        Ok(())
    }

    fn prior<Z, const D: usize>(
        &mut self,
        tag: &'static str,
        prior: &Prior<Z, D>,
        value: Print<Z>,
    ) -> Result<(), WriteError> {
        let covariance = covariance(&prior.information, tag, prior.id)?;
        self.line(tag, (Some(prior.id), &[prior.id]), |p| {
            value(p, &prior.measured);
            print_upper_triangle(p, &covariance);
        })
    }

    /// Each at the time of its later pose.
    fn edges<Z, const D: usize>(
        &mut self,
        tag: &'static str,
        edges: &[Edge<Z, D>],
        value: Print<Z>,
    ) -> Result<(), WriteError> {
        for e in edges {
            let covariance = covariance(&e.information, tag, e.from)?;
            let at = if self.stamps.contains_key(&e.to) { e.to } else { e.from };
            self.line(tag, (Some(at), &[e.from, e.to]), |p| {
                value(p, &e.measured);
                print_upper_triangle(p, &covariance);
            })?;
        }
        Ok(())
    }

    /// `tag [time of a vertex, else 0] names …`.
    fn line(
        &mut self,
        tag: &'static str,
        (at, names): (Option<u64>, &[u64]),
        fields: impl FnOnce(&mut Printer),
    ) -> Result<(), WriteError> {
        let time = at.map(|id| self.stamps.get(&id).copied().unwrap_or(0.0));
        self.printer.line(tag, names[0], |p| {
            time.iter().for_each(|&time| p.number(time));
            names.iter().for_each(|&id| p.name(Label(id)));
            fields(p);
        })
    }
}

fn covariance<const D: usize>(
    information: &SMatrix<f64, D, D>,
    tag: &'static str,
    id: u64,
) -> Result<SMatrix<f64, D, D>, WriteError> {
    inverted(information).ok_or(WriteError::NotPositiveDefinite { tag, id })
}
