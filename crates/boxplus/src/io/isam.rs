//! The iSAM format (Kaess, Ranganathan, Dellaert, 2008).

use super::Format;
use super::elements::{
    Printer, edge, other, point2, point3, pose2, pose3_euler, print_edge, print_point, print_pose2,
    print_pose3_euler, print_upper_triangle, upper_triangle,
};
use super::error::{IoError, IoErrorKind, WriteError};
use super::scan::{Fields, Layouts, Scan, Source};
use crate::lie::{LieGroup, SE3};
use crate::pose_graph::{Edge, Line, Offset, PoseGraph, Sighting3};
use nalgebra::SMatrix;

pub(super) const LAYOUTS: Layouts = &[
    ("ODOMETRY", "from to x y theta root(6)"),
    ("EDGE2", "from to x y theta root(6)"),
    ("LANDMARK", "from to x y root(3)"),
    ("EDGE3", "from to x y z roll pitch yaw root(21)"),
    ("POINT3", "from to x y z root(6)"),
];

/// The sensor offset of every point in space: none.
const ON_BODY: u64 = 0;

/// Reads one line.
pub(super) fn read_line(f: &mut Fields<'_>, graph: &mut PoseGraph) -> Scan<()> {
    match f.tag {
        b"ODOMETRY" | b"EDGE2" => graph.edges2.push(edge(f, pose2, squared)?),
        b"LANDMARK" => graph.sightings2.push(edge(f, point2, squared)?),
        b"EDGE3" => graph.edges3.push(edge(f, pose3_euler, squared)?),
        b"POINT3" => {
            let Edge { from, to, measured, information, line } = edge(f, point3, squared)?;
            graph.sightings3.push(Sighting3 { from, to, offset: ON_BODY, measured, information, line });
        }
        _ => graph.other.push(other(f)?),
    }
    f.finish()
}

/// Moves the ids of points in space behind those of the poses if the two meet; returns by how much. Adds the sensor offset
/// that their sightings refer to.
pub(super) fn part_points(source: Source<'_>, graph: &mut PoseGraph) -> Result<u64, IoError> {
    if graph.sightings3.is_empty() {
        return Ok(0);
    }
    graph.offsets3.push(Offset { id: ON_BODY, value: SE3::identity(), line: Line(0) });
    let poses =
        graph.edges3.iter().flat_map(|e| [e.from, e.to]).chain(graph.sightings3.iter().map(|s| s.from));
    let points = || graph.sightings3.iter().map(|s| s.to);
    let (Some(last_pose), Some(first_point), Some(last_point)) =
        (poses.max(), points().min(), points().max())
    else {
        return Ok(0);
    };
    if first_point > last_pose {
        return Ok(0);
    }
    let Some(shift) = last_pose.checked_add(1).filter(|shift| last_point.checked_add(*shift).is_some())
    else {
        return Err(source.fail(IoErrorKind::HugeId { found: last_pose.max(last_point).to_string().into() }));
    };
    for sighting in &mut graph.sightings3 {
        sighting.to += shift;
    }
    Ok(shift)
}

/// Writes the measurements of a graph.
pub(super) fn write(graph: &PoseGraph, p: &mut Printer) -> Result<(), WriteError> {
    measurements_only(graph)?;
    for e in &graph.edges2 {
        print_edge(p, "EDGE2", &root(e, "EDGE2")?, print_pose2, print_upper_triangle)?;
    }
    for e in &graph.sightings2 {
        print_edge(p, "LANDMARK", &root(e, "LANDMARK")?, print_point, print_upper_triangle)?;
    }
    for e in &graph.edges3 {
        print_edge(p, "EDGE3", &root(e, "EDGE3")?, print_pose3_euler, print_upper_triangle)?;
    }
    for &Sighting3 { from, to, measured, information, line, .. } in &graph.sightings3 {
        let e = Edge { from, to, measured, information, line };
        print_edge(p, "POINT3", &root(&e, "POINT3")?, print_point, print_upper_triangle)?;
    }
    Ok(())
}

fn measurements_only(graph: &PoseGraph) -> Result<(), WriteError> {
    let priors =
        graph.priors2.len() + graph.priors3.len() + graph.point_priors2.len() + graph.point_priors3.len();
    let on_body = |o: &&Offset<SE3>| o.value == SE3::identity();
    let moved = graph.offsets3.len() - graph.offsets3.iter().filter(on_body).count();
    let measured = graph.edges2.len() + graph.edges3.len() + graph.sightings2.len() + graph.sightings3.len();
    let alone = if measured == 0 { graph.vertex_count() } else { 0 };
    super::refuse(
        Format::Isam,
        &[
            ("bearings", graph.bearings2.len()),
            ("ranges", graph.ranges.len()),
            ("priors", priors),
            ("fixed vertices", graph.fixed.len()),
            ("sensor offsets", graph.offsets2.len() + moved),
            ("vertices without a measurement", alone),
        ],
    )
}

/// Ω = SᵀS of the upper triangle S.
fn squared<const D: usize>(f: &mut Fields<'_>) -> Scan<SMatrix<f64, D, D>> {
    let s: SMatrix<f64, D, D> = upper_triangle(f)?;
    let mut omega = s.transpose() * s;
    omega.fill_lower_triangle_with_upper_triangle(); // symmetric to the last bit
    Ok(omega)
}

/// The edge with its upper triangular square root S, Ω = SᵀS, in the place of Ω.
fn root<Z: Clone, const D: usize>(e: &Edge<Z, D>, tag: &'static str) -> Result<Edge<Z, D>, WriteError> {
    let not_definite = WriteError::NotPositiveDefinite { tag, id: e.from };
    let lower = e.information.cholesky().ok_or(not_definite)?.l();
    Ok(Edge { information: lower.transpose(), ..e.clone() })
}
