//! What is written is what is read, for any graph.
#![cfg(feature = "io")]
#![allow(clippy::unwrap_used)] // a failing test may panic

use boxplus::io::{self, Format};
use boxplus::lie::{LieGroup, SE2, SE3, SO3};
use boxplus::pose_graph::{
    Edge, Label, Line, Offset, OtherLine, PoseGraph, Prior, Prior3, Sighting3, Stamp, Vertex,
};
use core::f64::consts::{FRAC_PI_2, PI};
use nalgebra::{SMatrix, SVector, Vector2, Vector3, Vector4};
use proptest::collection::vec;
use proptest::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
use proptest::prelude::*;

const LINE: Line = Line(0);

/// Any finite float: every magnitude, both signs, both zeros.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -1e3..1e3,
        2 => NORMAL | SUBNORMAL | ZERO | POSITIVE | NEGATIVE,
        1 => (-1_000_000i32..1_000_000).prop_map(|i| f64::from(i) * 1e-3),
    ]
}

fn vector<const D: usize>() -> impl Strategy<Value = SVector<f64, D>> {
    vec(number(), D).prop_map(|x| SVector::from_column_slice(&x))
}

fn symmetric<const D: usize>() -> impl Strategy<Value = SMatrix<f64, D, D>> {
    vec(number(), D * D).prop_map(|x| {
        let mut m = SMatrix::<f64, D, D>::from_column_slice(&x);
        m.fill_lower_triangle_with_upper_triangle();
        m
    })
}

fn angle() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => -PI..PI,
        1 => (-3i32..=3).prop_map(|k| f64::from(k) * FRAC_PI_2 / 1.5),
        1 => -1e-9..1e-9,
        1 => (-1e-9..1e-9).prop_map(|x| (PI - f64::abs(x)).copysign(x)),
        1 => -1e-300..1e-300,
        1 => Just(-0.0),
    ]
}

fn pose2() -> impl Strategy<Value = SE2> {
    (vector::<2>(), angle()).prop_map(|(t, angle)| SE2::new(t, angle))
}

/// A rotation made in one of the ways rotations are made.
fn rotation3() -> impl Strategy<Value = SO3> {
    let parts = || vec(-1.0..1.0, 4).prop_map(|q| Vector4::from_column_slice(&q));
    prop_oneof![
        parts().prop_filter_map("zero", |q| SO3::from_xyzw(q.into()).ok()),
        vec(-4.0..4.0, 3).prop_map(|phi| SO3::exp(&Vector3::from_column_slice(&phi))),
        (parts(), parts()).prop_filter_map("zero", |(p, q)| {
            Some(SO3::from_xyzw(p.into()).ok()? * SO3::from_xyzw(q.into()).ok()?)
        }),
    ]
}

fn pose3() -> impl Strategy<Value = SE3> {
    (vector::<3>(), rotation3()).prop_map(|(t, r)| SE3::new(r, t))
}

fn id() -> impl Strategy<Value = u64> {
    prop_oneof![4 => 0u64..20, 1 => any::<u64>()]
}

fn edge<Z: core::fmt::Debug, const D: usize>(
    z: impl Strategy<Value = Z>,
) -> impl Strategy<Value = Edge<Z, D>> {
    (id(), id(), z, symmetric::<D>()).prop_map(|(from, to, measured, information)| Edge {
        from,
        to,
        measured,
        information,
        line: LINE,
    })
}

fn prior<Z: core::fmt::Debug, const D: usize>(
    z: impl Strategy<Value = Z>,
) -> impl Strategy<Value = Prior<Z, D>> {
    (id(), z, symmetric::<D>()).prop_map(|(id, measured, information)| Prior {
        id,
        measured,
        information,
        line: LINE,
    })
}

/// Values as vertices with increasing ids from `first`.
fn vertices<T>(first: u64, values: Vec<T>) -> Vec<Vertex<T>> {
    values.into_iter().zip(first..).map(|(value, id)| Vertex { id, value, line: LINE }).collect()
}

/// Poses and the edges between them.
fn poses() -> impl Strategy<Value = PoseGraph> {
    let parts = (vec(pose2(), 1..4), vec(pose3(), 0..4), vec(edge(pose2()), 0..4), vec(edge(pose3()), 0..4));
    parts.prop_map(|(poses2, poses3, edges2, edges3)| PoseGraph {
        poses2: vertices(0, poses2),
        poses3: vertices(10, poses3),
        edges2,
        edges3,
        ..PoseGraph::default()
    })
}

/// A graph with everything a g2o file can hold.
fn graph() -> impl Strategy<Value = PoseGraph> {
    let points = (vec(vector::<2>(), 0..3), vec(vector::<3>(), 0..3), vec(id(), 0..3));
    let sighting3 =
        (id(), id(), id(), vector(), symmetric()).prop_map(|(from, to, offset, measured, information)| {
            Sighting3 { from, to, offset, measured, information, line: LINE }
        });
    let sightings = (vec(edge(vector::<2>()), 0..3), vec(sighting3, 0..3), vec(edge(number()), 0..3));
    let prior3 = (id(), id(), pose3(), symmetric()).prop_map(|(id, offset, measured, information)| Prior3 {
        id,
        offset,
        measured,
        information,
        line: LINE,
    });
    let priors = (
        vec(prior(pose2()), 0..2),
        vec(prior3, 0..2),
        vec(prior(vector::<2>()), 0..2),
        vec(prior(vector::<3>()), 0..2),
    );
    let offsets = (vec(pose2(), 0..2), vec(pose3(), 0..2));
    let other = vec("[A-Z]{3,8}_X( [ -~]{0,12})?", 0..3);
    (poses(), points, sightings, priors, offsets, other).prop_map(
        |(poses, points, sightings, priors, offsets, other)| PoseGraph {
            points2: vertices(20, points.0),
            points3: vertices(30, points.1),
            fixed: points.2,
            sightings2: sightings.0,
            sightings3: sightings.1,
            bearings2: sightings.2,
            priors2: priors.0,
            priors3: priors.1,
            point_priors2: priors.2,
            point_priors3: priors.3,
            offsets2: (0..).zip(offsets.0).map(|(id, value)| Offset { id, value, line: LINE }).collect(),
            offsets3: (5..).zip(offsets.1).map(|(id, value)| Offset { id, value, line: LINE }).collect(),
            other: other.into_iter().map(|text| OtherLine { text, line: LINE }).collect(),
            ..poses
        },
    )
}

fn reread(graph: &PoseGraph, format: Format) -> PoseGraph {
    io::read(io::write(graph, format).unwrap().as_bytes(), "", Some(format)).unwrap().graph
}

/// The largest difference between two rotations or translations, relative to 1 + |t|.
fn distance(a: &SE3, b: &SE3) -> f64 {
    let t = (a.translation() - b.translation()).norm() / (1.0 + b.translation().norm());
    t.max(a.rotation().rminus(&b.rotation()).norm())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn g2o_gives_every_graph_back_bit_for_bit(graph in graph()) {
        let text = io::write(&graph, Format::G2o).unwrap();
        let back = io::read(text.as_bytes(), "", Some(Format::G2o)).unwrap().graph;
        prop_assert_eq!(&graph, &back);
        // `==` does not tell q from −q nor 0 from −0; the text does.
        prop_assert_eq!(text, io::write(&back, Format::G2o).unwrap());
    }

    #[test]
    fn the_format_is_recognised(graph in poses()) {
        for format in [Format::G2o, Format::Toro] {
            let text = io::write(&graph, format).unwrap();
            prop_assert_eq!(io::read(text.as_bytes(), "", None).unwrap().format, format);
        }
    }

    #[test]
    fn products_of_planar_rotations_keep_their_angle(a in pose2(), b in pose2()) {
        let product = PoseGraph { poses2: vertices(0, vec![a * b]), ..PoseGraph::default() };
        let back = reread(&product, Format::G2o);
        let turned = back.poses2[0].value.rotation().rminus(&(a * b).rotation()).x;
        // Half an ulp of an angle below π, and the rounding of the product, its cosine and sine.
        prop_assert!(turned.abs() <= 4.0 * f64::EPSILON);
        prop_assert_eq!(reread(&back, Format::G2o), back); // and then stay
    }

    #[test]
    fn toro_gives_poses_back_to_rounding(graph in poses()) {
        let back = reread(&graph, Format::Toro);
        prop_assert_eq!(&graph.poses2, &back.poses2);
        prop_assert_eq!(&graph.edges2, &back.edges2);
        for (a, b) in graph.poses3.iter().zip(&back.poses3) {
            prop_assert_eq!(a.id, b.id);
            prop_assert!(distance(&a.value, &b.value) < 16.0 * f64::EPSILON); // three rotations of a few ε each
        }
        for (a, b) in graph.edges3.iter().zip(&back.edges3) {
            prop_assert_eq!((a.from, a.to, a.information), (b.from, b.to, b.information));
            prop_assert!(distance(&a.measured, &b.measured) < 16.0 * f64::EPSILON);
        }
    }

    #[test]
    fn euler_angles_hold_at_gimbal_lock(roll in angle(), off in -1e-7..1e-7, yaw in angle(), up in any::<bool>()) {
        let about = |axis: Vector3<f64>, angle: f64| SO3::exp(&(axis * angle));
        let pitch = if up { FRAC_PI_2 - off } else { off - FRAC_PI_2 };
        let r = about(Vector3::z(), yaw) * about(Vector3::y(), pitch) * about(Vector3::x(), roll);
        let pose = SE3::new(r, Vector3::zeros());
        let graph = PoseGraph { poses3: vertices(0, vec![pose]), ..PoseGraph::default() };
        prop_assert!(distance(&reread(&graph, Format::Toro).poses3[0].value, &pose) < 16.0 * f64::EPSILON);
    }

    #[test]
    fn isam_gives_measurements_back_to_rounding(root in vec(-1.0..1.0, 36), z in pose3(), p in vector::<2>()) {
        let mut root = SMatrix::<f64, 6, 6>::from_column_slice(&root).upper_triangle();
        root.set_diagonal(&root.diagonal().map(|x| 1.0 + x.abs()));
        let omega = root.transpose() * root;
        let mut graph = PoseGraph::default();
        graph.edges3.push(Edge { from: 0, to: 1, measured: z, information: omega, line: LINE });
        let information = omega.fixed_view::<2, 2>(0, 0).into_owned();
        graph.sightings2.push(Edge { from: 0, to: 2, measured: p, information, line: LINE });
        let back = reread(&graph, Format::Isam);
        // Cholesky's backward error: 7·ε·|S|ᵀ|S|.
        let bound = 8.0 * f64::EPSILON * (root.abs().transpose() * root.abs()).max();
        prop_assert!((back.edges3[0].information - omega).amax() <= bound);
        prop_assert!((back.sightings2[0].information - information).amax() <= bound);
        prop_assert_eq!(back.sightings2[0].measured, p);
        prop_assert!(distance(&back.edges3[0].measured, &z) < 16.0 * f64::EPSILON);
    }

    #[test]
    fn pyfg_gives_maps_back_to_rounding(
        root in vec(-1.0..1.0, 36),
        (flat, z) in (pose2(), pose3()),
        p in vector::<2>(),
        range in 0.0..1e6,
        seconds in 0.0..2e9,
    ) {
        let mut root = SMatrix::<f64, 6, 6>::from_column_slice(&root).upper_triangle();
        root.set_diagonal(&root.diagonal().map(|x| 1.0 + x.abs()));
        let six = root.transpose() * root;
        let (two, three) = (six.fixed_view::<2, 2>(0, 0).into_owned(), six.fixed_view::<3, 3>(0, 0).into_owned());
        let one = six.fixed_view::<1, 1>(0, 0).into_owned();
        let [a, b, l, c, d] = [(b'A', 0), (b'B', 7), (b'L', 3), (b'C', 1), (b'P', 2)]
            .map(|(letter, number)| Label::new(letter, number).unwrap().0);
        let vertex = |id| Vertex { id, value: flat, line: LINE };
        let stamp = |id, seconds| Stamp { id, seconds };
        let mut graph = PoseGraph {
            poses2: vec![vertex(a), vertex(b)],
            poses3: vec![Vertex { id: c, value: z, line: LINE }],
            points2: vec![Vertex { id: l, value: p, line: LINE }],
            points3: vec![Vertex { id: d, value: z.translation(), line: LINE }],
            stamps: vec![stamp(a, seconds), stamp(b, -seconds), stamp(c, seconds)],
            offsets3: vec![Offset { id: 0, value: SE3::identity(), line: LINE }],
            ..PoseGraph::default()
        };
        graph.edges2.push(Edge { from: a, to: b, measured: flat, information: three, line: LINE });
        graph.edges3.push(Edge { from: c, to: c, measured: z, information: six, line: LINE });
        graph.sightings2.push(Edge { from: b, to: l, measured: p, information: two, line: LINE });
        let measured = z.translation();
        graph.sightings3.push(Sighting3 { from: c, to: d, offset: 0, measured, information: three, line: LINE });
        graph.ranges.push(Edge { from: a, to: l, measured: range, information: one, line: LINE });
        graph.ranges.push(Edge { from: a, to: b, measured: range, information: one, line: LINE });
        graph.priors2.push(Prior { id: a, measured: flat, information: three, line: LINE });
        graph.priors3.push(Prior3 { id: c, offset: 0, measured: z, information: six, line: LINE });
        graph.point_priors2.push(Prior { id: l, measured: p, information: two, line: LINE });
        graph.point_priors3.push(Prior { id: d, measured, information: three, line: LINE });

        let back = reread(&graph, Format::Pyfg);
        // Inverted twice: κ(Ω)·ε each, in the scale of Ω.
        let condition = six.norm() * six.try_inverse().unwrap().norm();
        let bound = 32.0 * f64::EPSILON * condition * six.norm();
        let matrices = |graph: &PoseGraph| {
            graph.constraints().flat_map(|c| c.information.to_vec()).collect::<Vec<f64>>()
        };
        for (x, y) in matrices(&back).into_iter().zip(matrices(&graph)) {
            prop_assert!((x - y).abs() <= bound, "{x} instead of {y}");
        }
        // All else stays to the last bit.
        let without = |mut graph: PoseGraph| {
            graph.edges2.iter_mut().for_each(|e| e.information.fill(0.0));
            graph.edges3.iter_mut().for_each(|e| e.information.fill(0.0));
            graph.sightings2.iter_mut().for_each(|e| e.information.fill(0.0));
            graph.sightings3.iter_mut().for_each(|e| e.information.fill(0.0));
            graph.ranges.iter_mut().for_each(|e| e.information.fill(0.0));
            graph.priors2.iter_mut().for_each(|e| e.information.fill(0.0));
            graph.priors3.iter_mut().for_each(|e| e.information.fill(0.0));
            graph.point_priors2.iter_mut().for_each(|e| e.information.fill(0.0));
            graph.point_priors3.iter_mut().for_each(|e| e.information.fill(0.0));
            graph
        };
        prop_assert_eq!(without(back), without(graph));
    }

    #[test]
    fn numbers_round_as_in_the_standard_library(text in r"-?(0|[1-9][0-9]{0,25})(\.[0-9]{1,25})?(e-?[0-9]{1,2})?") {
        let line = format!("VERTEX_XY 0 {text} 0");
        let graph = io::read(line.as_bytes(), "", None).unwrap().graph;
        prop_assert_eq!(graph.points2[0].value.x.to_bits(), text.parse::<f64>().unwrap().to_bits());
    }
}

#[test]
fn angles_beyond_a_turn_are_read_as_the_equal_angle_and_then_stay() {
    for angle in [3.2, -3.2, 7.0, 100.0, -1e6, 1e300] {
        let line = format!("VERTEX_SE2 0 0 0 {angle}");
        let graph = io::read(line.as_bytes(), "", None).unwrap().graph;
        let expected = SE2::new(Vector2::zeros(), angle);
        let turned = graph.poses2[0].value.rotation().rminus(&expected.rotation()).x;
        assert!(turned.abs() <= 4.0 * f64::EPSILON, "{angle}");
        assert_eq!(reread(&graph, Format::G2o), graph, "{angle}");
    }
}

#[test]
fn written_numbers_are_as_short_as_they_were() {
    let text = "VERTEX_SE2 0 0.1 -12 0.3\nVERTEX_SE2 1 1e-7 1e20 -3.14\nVERTEX_SE3:QUAT 2 1 2 3 0.6 0 0 0.8\nFIX 0\n\
                EDGE_SE2 0 1 1.5 0 -0.000017 1 0 0 1 0 1000000\n";
    let graph = io::read(text.as_bytes(), "", None).unwrap().graph;
    assert_eq!(io::write(&graph, Format::G2o).unwrap(), text);
}

#[test]
fn several_ids_may_be_fixed_in_one_line_and_comments_are_skipped() {
    let text = "# made by hand\r\n\r\nVERTEX_XY 1 0 0\r\n  VERTEX_XY\t2 1 1 \r\nFIX 1 2\r\n#FIX 3\r\nLASER 1 2 é\r\n";
    let graph = io::read(text.as_bytes(), "", None).unwrap().graph;
    assert_eq!(graph.fixed, [1, 2]);
    assert_eq!(graph.points2.iter().map(|v| v.line.0).collect::<Vec<_>>(), [3, 4]);
    assert_eq!(
        (graph.other[0].text.as_str(), graph.other[0].tag(), graph.other[0].line.0),
        ("LASER 1 2 é", "LASER", 7)
    );
    assert_eq!(graph.statistics().other, [("LASER".to_owned(), 1)]);
}

#[test]
fn a_byte_order_mark_is_skipped() {
    let graph = io::read(b"\xef\xbb\xbfVERTEX_XY 4 0 0\n", "", None).unwrap().graph;
    assert_eq!(graph.points2[0].id, 4);
}

#[test]
fn gzip_is_read_like_plain_text() {
    use std::io::Write;
    let text = b"VERTEX_XY 0 1 2\n";
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(text).unwrap();
    let bytes = encoder.finish().unwrap();
    let (plain, zipped) = (io::read(text, "", None).unwrap(), io::read(&bytes, "", None).unwrap());
    assert_eq!(plain.graph, zipped.graph);
    assert!(zipped.gzip && !plain.gzip);
    assert_eq!(&*io::decompress(&bytes, "").unwrap(), text);
}

#[test]
fn toro_orders_the_planar_information_in_its_own_way() {
    let line = "VERTEX2 0 0 0 0\nEDGE2 0 1 0 0 0 11 12 22 33 13 23\n";
    let parsed = io::read(line.as_bytes(), "", None).unwrap();
    let expected = nalgebra::matrix![11.0, 12.0, 13.0; 12.0, 22.0, 23.0; 13.0, 23.0, 33.0];
    assert_eq!((parsed.format, parsed.graph.edges2[0].information), (Format::Toro, expected));
    assert_eq!(io::write(&parsed.graph, Format::Toro).unwrap(), line);
}

#[test]
fn isam_squares_the_root_of_the_information() {
    let parsed = io::read(b"ODOMETRY 0 1 1 0 0 1 2 3 4 5 6", "", None).unwrap();
    let s = nalgebra::matrix![1.0, 2.0, 3.0; 0.0, 4.0, 5.0; 0.0, 0.0, 6.0];
    assert_eq!((parsed.format, parsed.graph.edges2[0].information), (Format::Isam, s.transpose() * s));
}

#[test]
fn pyfg_keeps_covariances_where_others_keep_information() {
    let text = "VERTEX_SE2 12.5 A0 0 0 0\nVERTEX_SE2 13.5 B7 1 2 0.5\nVERTEX_XY L0 3 4\n\
                EDGE_SE2 13.5 A0 B7 1 2 0.5 0.25 0 0 0.0625 0 4\nEDGE_RANGE 12.5 A0 L0 5 0.25\n";
    let parsed = io::read(text.as_bytes(), "", None).unwrap();
    let graph = &parsed.graph;
    assert_eq!(parsed.format, Format::Pyfg);
    assert_eq!(graph.edges2[0].information.diagonal(), Vector3::new(4.0, 16.0, 0.25));
    assert_eq!(graph.ranges[0].information.x, 4.0);
    assert_eq!(Label(graph.edges2[0].to).to_string(), "B7");
    assert_eq!(graph.stamps[1], Stamp { id: graph.poses2[1].id, seconds: 13.5 });
    assert!(graph.faults().is_empty());
    assert_eq!(io::write(graph, Format::Pyfg).unwrap(), text);
}
