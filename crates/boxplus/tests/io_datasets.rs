//! Public data sets, read from `BOXPLUS_DATA` or `../shared/data` beside the repository. They are not part of it: without the
//! folder these tests say so and pass.
#![cfg(feature = "io")]
#![allow(clippy::unwrap_used, clippy::print_stdout)] // a failing test may panic; a skipped one must say so

mod public_data;

use boxplus::io::{self, Format};
use boxplus::lie::{LieGroup, SE2, SE3};
use boxplus::pose_graph::{Fault, Kind, PoseGraph, Severity};
use std::collections::BTreeMap;

type Row = (&'static str, Format, usize, usize, usize, Option<f64>);

/// Name, format, poses, edges, loop closures, χ² of g2o at the initial values (six digits), as published with the data.
const POSE_GRAPHS: [Row; 17] = [
    ("sphere2500.g2o", Format::G2o, 2500, 4949, 2450, Some(2.54781e6)),
    ("sphere_bignoise_vertex3.g2o", Format::G2o, 2200, 8647, 6448, Some(1.76631e8)),
    ("torus3D.g2o.gz", Format::G2o, 5000, 9048, 4049, Some(2.94683e6)),
    ("parking-garage.g2o", Format::G2o, 1661, 6275, 4615, Some(16720.0)),
    ("smallGrid3D.g2o", Format::G2o, 125, 297, 173, Some(115958.0)),
    ("tinyGrid3D.g2o", Format::G2o, 9, 11, 3, Some(213.064)),
    ("M3500.g2o", Format::G2o, 3500, 5453, 1954, Some(2.56667e6)),
    ("M3500a.g2o", Format::G2o, 3500, 5453, 1954, Some(5.82650e7)),
    ("manhattan.g2o", Format::G2o, 3500, 5453, 1954, Some(2.33185e10)),
    ("manhattanOlson3500.g2o", Format::G2o, 3500, 5598, 2099, Some(69142.9)),
    ("intel.g2o", Format::G2o, 1728, 2512, 785, Some(551.736)),
    ("MIT.g2o", Format::G2o, 808, 827, 20, Some(4.41418e9)),
    ("kitti_00.g2o", Format::G2o, 4541, 4677, 137, Some(7.53296e7)),
    ("ring.g2o", Format::G2o, 434, 459, 26, Some(2.04106e6)),
    ("ring-groundtruth.g2o", Format::G2o, 434, 459, 26, None),
    ("sphere_smallnoise.toro.graph", Format::Toro, 2200, 8647, 6448, Some(982589.0)),
    ("sphere400.isam.txt", Format::Isam, 400, 779, 380, Some(2.24378e6)),
];

/// Initial poses: of the file, or chained along the edges i → i + 1 from the identity.
fn initial<G: LieGroup<D>, const D: usize>(
    vertices: impl Iterator<Item = (u64, G)>,
    edges: impl Iterator<Item = (u64, u64, G)>,
) -> BTreeMap<u64, G> {
    let mut poses: BTreeMap<u64, G> = vertices.collect();
    if poses.is_empty() {
        poses.insert(0, G::identity());
        for (from, to, measured) in edges {
            if let (Some(&last), true) = (poses.get(&from), to == from + 1) {
                poses.entry(to).or_insert_with(|| last.compose(&measured));
            }
        }
    }
    poses
}

/// χ² = Σ eᵀΩe as g2o has it: e is the translation and the angle, or the vector part of the quaternion with w ≥ 0, of
/// Z⁻¹·X₁⁻¹·X₂.
fn chi2(graph: &PoseGraph) -> f64 {
    let flat: BTreeMap<u64, SE2> = initial(
        graph.poses2.iter().map(|v| (v.id, v.value)),
        graph.edges2.iter().map(|e| (e.from, e.to, e.measured)),
    );
    let spatial: BTreeMap<u64, SE3> = initial(
        graph.poses3.iter().map(|v| (v.id, v.value)),
        graph.edges3.iter().map(|e| (e.from, e.to, e.measured)),
    );
    let chi2_2: f64 = (graph.edges2.iter())
        .map(|e| {
            let d = e.measured.between(&flat[&e.from].between(&flat[&e.to]));
            let r = d.translation().push(d.angle());
            r.dot(&(e.information * r))
        })
        .sum();
    let chi2_3: f64 = (graph.edges3.iter())
        .map(|e| {
            let d = e.measured.between(&spatial[&e.from].between(&spatial[&e.to]));
            let (t, [x, y, z, w]) = (d.translation(), d.rotation().quaternion_xyzw());
            let s = 1f64.copysign(w);
            let r = nalgebra::Vector6::new(t.x, t.y, t.z, s * x, s * y, s * z);
            r.dot(&(e.information * r))
        })
        .sum();
    chi2_2 + chi2_3
}

#[test]
fn every_public_pose_graph_is_read_as_published() {
    for (name, format, poses, edges, loops, chi2_start) in POSE_GRAPHS {
        let Some(bytes) = public_data::bytes(&format!("pose-graph/{name}")) else { return };
        let parsed = io::read(&bytes, name, None).unwrap();
        assert_eq!(parsed.format, format, "{name}");
        let s = parsed.graph.statistics();
        assert_eq!(s.ids, poses, "{name}");
        assert!(s.poses == poses || s.poses == 0, "{name}");
        assert_eq!(parsed.graph.edges2.len() + parsed.graph.edges3.len(), edges, "{name}");
        assert_eq!((s.loop_closures, s.components, s.id_gaps), (loops, 1, 0), "{name}");
        assert!(s.other.is_empty() && parsed.warnings.is_empty(), "{name}");
        let errors: Vec<Fault> =
            parsed.graph.faults().into_iter().filter(|f| f.severity() > Severity::Note).collect();
        assert_eq!(errors, [], "{name}");
        if let Some(expected) = chi2_start {
            let chi2 = chi2(&parsed.graph);
            assert!((chi2 / expected - 1.0).abs() < 1e-5, "{name}: χ² {chi2} ≠ {expected}");
        }
    }
}

#[test]
fn every_public_pose_graph_is_written_and_read_back_bit_for_bit() {
    for (name, ..) in POSE_GRAPHS {
        let Some(bytes) = public_data::bytes(&format!("pose-graph/{name}")) else { return };
        let graph = io::read(&bytes, name, None).unwrap().graph;
        let text = io::write(&graph, Format::G2o).unwrap();
        let back = io::read(text.as_bytes(), name, None).unwrap().graph;
        assert!(graph == back, "{name}");
        assert!(text == io::write(&back, Format::G2o).unwrap(), "{name}");
    }
}

#[test]
fn manhattan_olson_repeats_145_edges() {
    let Some(bytes) = public_data::bytes("pose-graph/manhattanOlson3500.g2o") else { return };
    let graph = io::read(&bytes, "manhattanOlson3500.g2o", None).unwrap().graph;
    assert_eq!(graph.statistics().repeated_edges, 145);
}

#[test]
fn isam_landmark_files_are_read_as_published() {
    let Some(bytes) = public_data::bytes("landmark-slam/victoriaPark.isam.txt") else { return };
    let parsed = io::read(&bytes, "victoriaPark", None).unwrap();
    let s = parsed.graph.statistics();
    assert_eq!((parsed.format, s.ids, s.components), (Format::Isam, 6969 + 151, 1));
    assert_eq!(s.counts, [(Kind::Edge2, 6968), (Kind::Sighting2, 3640)]);
    assert_eq!(s.loop_closures, 0);

    let Some(bytes) = public_data::bytes("landmark-slam/torus2000Points.isam.txt") else { return };
    let parsed = io::read(&bytes, "torus2000Points", None).unwrap();
    let s = parsed.graph.statistics();
    assert_eq!((s.ids, s.components, parsed.point_shift), (1073 + 20, 1, 1073));
    assert_eq!(s.counts, [(Kind::Edge3, 2034), (Kind::Sighting3, 1039)]);
    let text = io::write(&parsed.graph, Format::G2o).unwrap();
    assert!(io::read(text.as_bytes(), "", None).unwrap().graph == parsed.graph);
}

#[test]
fn pyfg_files_are_read_as_published_and_written_back_to_rounding() {
    let files = [
        ("goats_15.pyfg", 473 + 3, vec![(Kind::Edge2, 472), (Kind::Range, 786)]),
        ("plaza1.pyfg.gz", 9658 + 4, vec![(Kind::Edge2, 9657), (Kind::Range, 3326)]),
        ("single_drone.pyfg.gz", 1754 + 1, vec![(Kind::Edge3, 1753), (Kind::Range, 1754)]),
    ];
    for (name, vertices, counts) in files {
        let Some(bytes) = public_data::bytes(&format!("ranging/{name}")) else { return };
        let parsed = io::read(&bytes, name, None).unwrap();
        let s = parsed.graph.statistics();
        assert_eq!((parsed.format, s.poses + s.points, s.components), (Format::Pyfg, vertices, 1), "{name}");
        assert_eq!(s.counts, counts, "{name}");
        assert!(parsed.graph.faults().is_empty() && s.id_gaps == 0, "{name}");

        let text = io::write(&parsed.graph, Format::Pyfg).unwrap();
        let back = io::read(text.as_bytes(), name, None).unwrap().graph;
        for (a, b) in parsed.graph.constraints().zip(back.constraints()) {
            assert_eq!((a.measured, a.from, a.to), (b.measured, b.from, b.to), "{name}");
            let differ = |(x, y): (&f64, &f64)| (x - y).abs() > 8.0 * f64::EPSILON * y.abs();
            assert!(!a.information.iter().zip(b.information).any(differ), "{name}");
        }
        assert_eq!(parsed.graph.stamps, back.stamps, "{name}");
    }
}

#[test]
fn toro_and_isam_keep_the_graph_to_rounding() {
    for (name, format, ..) in POSE_GRAPHS {
        let Some(bytes) = public_data::bytes(&format!("pose-graph/{name}")) else { return };
        let graph = io::read(&bytes, name, None).unwrap().graph;
        let expected = chi2(&graph);
        if format == Format::Isam || graph.vertex_count() == 0 {
            let text = io::write(&graph, Format::Isam).unwrap();
            let back = io::read(text.as_bytes(), name, None).unwrap();
            assert_eq!(back.format, Format::Isam);
            assert!((chi2(&back.graph) / expected - 1.0).abs() < 1e-9, "{name}");
        } else {
            let text = io::write(&graph, Format::Toro).unwrap();
            let back = io::read(text.as_bytes(), name, None).unwrap();
            assert_eq!(back.format, Format::Toro);
            assert!((chi2(&back.graph) / expected - 1.0).abs() < 1e-7, "{name}");
        }
    }
}
