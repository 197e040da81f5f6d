//! The g2o format. Tags and fields are those of g2o's `slam2d` and `slam3d` types.
//!
//! Orders: θ in radians, quaternions x y z w, information as the upper triangle by rows.

use super::Format;
use super::elements::{
    Printer, edge, information, other, point2, point3, pose2, pose3, print_edge, print_point, print_pose2,
    print_pose3, print_prior, print_scalar, print_upper_triangle, print_vertex, prior, scalar, vertex,
};
use super::error::WriteError;
use super::scan::{Fields, Layouts, Scan};
use crate::pose_graph::{Kind, Offset, PoseGraph, Prior3, Sighting3, Vertex};

pub(super) const LAYOUTS: Layouts = &[
    ("VERTEX_SE2", "id x y theta"),
    ("VERTEX_SE3:QUAT", "id x y z qx qy qz qw"),
    ("VERTEX_XY", "id x y"),
    ("VERTEX_TRACKXYZ", "id x y z"),
    ("EDGE_SE2", "from to x y theta information(6)"),
    ("EDGE_SE3:QUAT", "from to x y z qx qy qz qw information(21)"),
    ("EDGE_SE2_XY", "from to x y information(3)"),
    ("EDGE_SE3_TRACKXYZ", "from to offset x y z information(6)"),
    ("EDGE_BEARING_SE2_XY", "from to bearing information"),
    ("EDGE_PRIOR_SE2", "id x y theta information(6)"),
    ("EDGE_SE3_PRIOR", "id offset x y z qx qy qz qw information(21)"),
    ("EDGE_PRIOR_XY", "id x y information(3)"),
    ("EDGE_POINTXYZ_PRIOR", "id x y z information(6)"),
    ("PARAMS_SE2OFFSET", "id x y theta"),
    ("PARAMS_SE3OFFSET", "id x y z qx qy qz qw"),
    ("FIX", "id id"),
];

/// Reads one line.
pub(super) fn read_line(f: &mut Fields<'_>, graph: &mut PoseGraph) -> Scan<()> {
    match f.tag {
        b"EDGE_SE3:QUAT" => graph.edges3.push(edge(f, pose3, information)?),
        b"EDGE_SE2" => graph.edges2.push(edge(f, pose2, information)?),
        b"VERTEX_SE3:QUAT" => graph.poses3.push(vertex(f, pose3)?),
        b"VERTEX_SE2" => graph.poses2.push(vertex(f, pose2)?),
        b"VERTEX_XY" => graph.points2.push(vertex(f, point2)?),
        b"VERTEX_TRACKXYZ" => graph.points3.push(vertex(f, point3)?),
        b"EDGE_SE2_XY" => graph.sightings2.push(edge(f, point2, information)?),
        b"EDGE_SE3_TRACKXYZ" => graph.sightings3.push(sighting3(f)?),
        b"EDGE_BEARING_SE2_XY" => graph.bearings2.push(edge(f, scalar, information)?),
        b"EDGE_PRIOR_SE2" => graph.priors2.push(prior(f, pose2)?),
        b"EDGE_SE3_PRIOR" => graph.priors3.push(prior3(f)?),
        b"EDGE_PRIOR_XY" => graph.point_priors2.push(prior(f, point2)?),
        b"EDGE_POINTXYZ_PRIOR" => graph.point_priors3.push(prior(f, point3)?),
        b"PARAMS_SE2OFFSET" => graph.offsets2.push(offset(vertex(f, pose2)?)),
        b"PARAMS_SE3OFFSET" => graph.offsets3.push(offset(vertex(f, pose3)?)),
        b"FIX" => {
            while !f.is_done() {
                graph.fixed.push(f.id()?);
            }
        }
        _ => graph.other.push(other(f)?),
    }
    f.finish()
}

/// Writes a graph: offsets, vertices, fixed vertices, measurements.
pub(super) fn write(graph: &PoseGraph, p: &mut Printer) -> Result<(), WriteError> {
    super::refuse(Format::G2o, &[("ranges", graph.ranges.len())])?;
    for o in &graph.offsets2 {
        print_vertex(p, "PARAMS_SE2OFFSET", (o.id, &o.value), print_pose2)?;
    }
    for o in &graph.offsets3 {
        print_vertex(p, "PARAMS_SE3OFFSET", (o.id, &o.value), print_pose3)?;
    }
    write_vertices(graph, p)?;
    for &id in &graph.fixed {
        p.line("FIX", id, |p| p.id(id))?;
    }
    write_edges(graph, p)?;
    write_priors(graph, p)?;
    Ok(())
}

fn write_vertices(graph: &PoseGraph, p: &mut Printer) -> Result<(), WriteError> {
    for v in &graph.poses2 {
        print_vertex(p, "VERTEX_SE2", (v.id, &v.value), print_pose2)?;
    }
    for v in &graph.poses3 {
        print_vertex(p, "VERTEX_SE3:QUAT", (v.id, &v.value), print_pose3)?;
    }
    for v in &graph.points2 {
        print_vertex(p, "VERTEX_XY", (v.id, &v.value), print_point)?;
    }
    for v in &graph.points3 {
        print_vertex(p, "VERTEX_TRACKXYZ", (v.id, &v.value), print_point)?;
    }
    Ok(())
}

fn write_edges(graph: &PoseGraph, p: &mut Printer) -> Result<(), WriteError> {
    for e in &graph.edges2 {
        print_edge(p, Kind::Edge2.tag(), e, print_pose2, print_upper_triangle)?;
    }
    for e in &graph.edges3 {
        print_edge(p, Kind::Edge3.tag(), e, print_pose3, print_upper_triangle)?;
    }
    for e in &graph.sightings2 {
        print_edge(p, Kind::Sighting2.tag(), e, print_point, print_upper_triangle)?;
    }
    for e in &graph.sightings3 {
        p.line(Kind::Sighting3.tag(), e.from, |p| {
            p.id(e.from);
            p.id(e.to);
            p.id(e.offset);
            print_point(p, &e.measured);
            print_upper_triangle(p, &e.information);
        })?;
    }
    for e in &graph.bearings2 {
        print_edge(p, Kind::Bearing2.tag(), e, print_scalar, print_upper_triangle)?;
    }
    Ok(())
}

fn write_priors(graph: &PoseGraph, p: &mut Printer) -> Result<(), WriteError> {
    for prior in &graph.priors2 {
        print_prior(p, Kind::Prior2.tag(), prior, print_pose2)?;
    }
    for prior in &graph.priors3 {
        p.line(Kind::Prior3.tag(), prior.id, |p| {
            p.id(prior.id);
            p.id(prior.offset);
            print_pose3(p, &prior.measured);
            print_upper_triangle(p, &prior.information);
        })?;
    }
    for prior in &graph.point_priors2 {
        print_prior(p, Kind::PointPrior2.tag(), prior, print_point)?;
    }
    for prior in &graph.point_priors3 {
        print_prior(p, Kind::PointPrior3.tag(), prior, print_point)?;
    }
    Ok(())
}

/// `from to offset x y z information`.
fn sighting3(f: &mut Fields<'_>) -> Scan<Sighting3> {
    let (from, to, offset) = (f.id()?, f.id()?, f.id()?);
    Ok(Sighting3 { from, to, offset, measured: point3(f)?, information: information(f)?, line: f.line() })
}

/// `id offset x y z qx qy qz qw information`.
fn prior3(f: &mut Fields<'_>) -> Scan<Prior3> {
    let (id, offset) = (f.id()?, f.id()?);
    Ok(Prior3 { id, offset, measured: pose3(f)?, information: information(f)?, line: f.line() })
}

/// A sensor offset has the fields of a vertex.
fn offset<G>(vertex: Vertex<G>) -> Offset<G> {
    Offset { id: vertex.id, value: vertex.value, line: vertex.line }
}
