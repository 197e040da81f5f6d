//! The TORO format (Grisetti, Stachniss, Grzonka, Burgard, 2007).

use super::Format;
use super::elements::{
    Printer, edge, information, other, pose2, pose3_euler, print_edge, print_pose2, print_pose3_euler,
    print_upper_triangle, print_vertex, vertex,
};
use super::error::WriteError;
use super::scan::{Fields, Layouts, Scan};
use crate::pose_graph::PoseGraph;
use nalgebra::{Matrix3, Matrix6};

pub(super) const LAYOUTS: Layouts = &[
    ("VERTEX2", "id x y theta"),
    ("VERTEX3", "id x y z roll pitch yaw"),
    ("EDGE2", "from to x y theta I11 I12 I22 I33 I13 I23"),
    ("EDGE3", "from to x y z roll pitch yaw information(21)"),
];

/// Reads one line.
pub(super) fn read_line(f: &mut Fields<'_>, graph: &mut PoseGraph) -> Scan<()> {
    match f.tag {
        b"VERTEX2" => graph.poses2.push(vertex(f, pose2)?),
        b"VERTEX3" => graph.poses3.push(vertex(f, pose3_euler)?),
        b"EDGE2" => graph.edges2.push(edge(f, pose2, information2)?),
        b"EDGE3" => graph.edges3.push(edge(f, pose3_euler, information3)?),
        _ => graph.other.push(other(f)?),
    }
    f.finish()
}

/// Writes a graph of poses.
pub(super) fn write(graph: &PoseGraph, p: &mut Printer) -> Result<(), WriteError> {
    poses_only(graph)?;
    for v in &graph.poses2 {
        print_vertex(p, "VERTEX2", (v.id, &v.value), print_pose2)?;
    }
    for v in &graph.poses3 {
        print_vertex(p, "VERTEX3", (v.id, &v.value), print_pose3_euler)?;
    }
    for e in &graph.edges2 {
        print_edge(p, "EDGE2", e, print_pose2, print_information2)?;
    }
    for e in &graph.edges3 {
        print_edge(p, "EDGE3", e, print_pose3_euler, print_upper_triangle)?;
    }
    Ok(())
}

fn poses_only(graph: &PoseGraph) -> Result<(), WriteError> {
    let sightings = graph.sightings2.len() + graph.sightings3.len() + graph.bearings2.len();
    let priors =
        graph.priors2.len() + graph.priors3.len() + graph.point_priors2.len() + graph.point_priors3.len();
    super::refuse(
        Format::Toro,
        &[
            ("points", graph.points2.len() + graph.points3.len()),
            ("sightings", sightings),
            ("ranges", graph.ranges.len()),
            ("priors", priors),
            ("fixed vertices", graph.fixed.len()),
            ("sensor offsets", graph.offsets2.len() + graph.offsets3.len()),
        ],
    )
}

fn information2(f: &mut Fields<'_>) -> Scan<Matrix3<f64>> {
    let [xx, xy, yy, tt, xt, yt] = f.numbers()?;
    Ok(Matrix3::new(xx, xy, xt, xy, yy, yt, xt, yt, tt))
}

fn print_information2(p: &mut Printer, m: &Matrix3<f64>) {
    p.numbers(&[m.m11, m.m12, m.m22, m.m33, m.m13, m.m23]);
}

fn information3(f: &mut Fields<'_>) -> Scan<Matrix6<f64>> {
    if f.is_done() { Ok(Matrix6::identity()) } else { information(f) }
}
