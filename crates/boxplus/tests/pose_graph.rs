//! What is wrong with a pose graph is found, counted and named.
#![cfg(feature = "io")]
#![allow(clippy::unwrap_used)] // a failing test may panic

use boxplus::io::{self, Format};
use boxplus::lie::{LieGroup, SE2};
use boxplus::pose_graph::simulate::{Options, Simulator};
use boxplus::pose_graph::{
    Degree, Edge, Fault, InformationProblem, Kind, Line, PoseGraph, Severity, Vertex, VertexKind,
};
use nalgebra::{Matrix3, Matrix6, Vector2, Vector3};

const TWO: &str = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\n";

fn faults(text: &str) -> Vec<Fault> {
    io::read(text.as_bytes(), "", None).unwrap().graph.faults()
}

/// The only fault of a file.
fn fault(text: &str) -> Fault {
    let faults = faults(text);
    assert_eq!(faults.len(), 1, "{faults:?}");
    faults[0]
}

fn edge(from: u64, to: u64, information: Matrix3<f64>) -> Edge<SE2, 3> {
    Edge { from, to, measured: SE2::identity(), information, line: Line(0) }
}

#[test]
fn a_good_graph_has_no_faults() {
    assert_eq!(faults(&format!("{TWO}EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n")), []);
    assert_eq!(
        faults("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"),
        [],
        "without vertices there are no initial values"
    );
    assert_eq!(PoseGraph::default().faults(), []);
}

#[test]
fn a_dangling_edge_is_an_error() {
    let found = fault(&format!("{TWO}EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2_XY 1 9 0 0 1 0 1"));
    assert_eq!(found, Fault::MissingVertex { kind: Kind::Sighting2, id: 9, line: Line(4) });
    assert_eq!((found.line().0, found.severity()), (4, Severity::Error));
    assert_eq!(found.to_string(), "EDGE_SE2_XY refers to 9, which is no vertex");
}

#[test]
fn an_edge_to_another_kind_of_vertex_is_an_error() {
    let found = fault("VERTEX_SE2 0 0 0 0\nVERTEX_XY 1 1 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1");
    let (expected, is) = (VertexKind::Pose2, VertexKind::Point2);
    assert_eq!(found, Fault::WrongVertex { kind: Kind::Edge2, id: 1, expected, found: is, line: Line(3) });
}

#[test]
fn missing_offsets_and_fixed_vertices_are_found() {
    let sighting =
        "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_TRACKXYZ 1 0 0 0\nEDGE_SE3_TRACKXYZ 0 1 7 0 0 0 1 0 0 1 0 1";
    assert_eq!(fault(sighting), Fault::MissingOffset { kind: Kind::Sighting3, offset: 7, line: Line(3) });
    assert_eq!(faults(&format!("{sighting}\nPARAMS_SE3OFFSET 7 0 0 0 0 0 0 1")), []);
    let found = fault(&format!("{TWO}EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nFIX 0 5"));
    assert_eq!((found, found.severity()), (Fault::MissingFixed { id: 5 }, Severity::Warning));
}

#[test]
fn a_self_loop_is_a_warning() {
    let found = fault(&format!("{TWO}EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 1 1 0 0 0 1 0 0 1 0 1"));
    assert_eq!(
        (found, found.severity()),
        (Fault::SelfLoop { kind: Kind::Edge2, id: 1, line: Line(4) }, Severity::Warning)
    );
}

#[test]
fn every_bad_information_matrix_is_named() {
    let problem = |information| {
        let graph = PoseGraph { edges2: vec![edge(0, 1, information)], ..PoseGraph::default() };
        match graph.faults()[..] {
            [] => None,
            [fault @ Fault::Information { problem, .. }] => Some((problem, fault.severity())),
            ref faults => panic!("{faults:?}"),
        }
    };
    let mut m = Matrix3::identity();
    assert_eq!(problem(m), None);
    m[(0, 1)] = f64::NAN;
    assert_eq!(problem(m), Some((InformationProblem::NotFinite, Severity::Error)));
    m[(0, 1)] = 1e-3;
    assert_eq!(problem(m), Some((InformationProblem::NotSymmetric { gap: 1e-3 }, Severity::Error)));
    m[(0, 1)] = 1e-16;
    assert_eq!(problem(m), None, "rounding of an inverse");
    assert_eq!(problem(Matrix3::zeros()), Some((InformationProblem::Zero, Severity::Warning)));
    let indefinite = InformationProblem::Indefinite { smallest: -2.0 };
    assert_eq!(
        problem(Matrix3::from_diagonal(&Vector3::new(1.0, -2.0, 3.0))),
        Some((indefinite, Severity::Error))
    );
    let singular = InformationProblem::Singular { smallest: 0.0, largest: 3.0 };
    assert_eq!(
        problem(Matrix3::from_diagonal(&Vector3::new(1.0, 0.0, 3.0))),
        Some((singular, Severity::Warning))
    );
    let tilted = nalgebra::matrix![1.0, 2.0, 0.0; 2.0, 1.0, 0.0; 0.0, 0.0, 1.0]; // eigenvalues −1, 1, 3
    let Some((InformationProblem::Indefinite { smallest }, _)) = problem(tilted) else { panic!("not found") };
    assert!((smallest + 1.0).abs() < 1e-15);
}

#[test]
fn an_indefinite_matrix_among_many_names_its_line() {
    let good = "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n";
    let text = format!("{TWO}{good}EDGE_SE2 1 0 1 0 0 1 2 0 1 0 1\nEDGE_SE2 0 1 1 0.1 0 1 0 0 1 0 1\n");
    let found = fault(&text);
    assert!(matches!(found, Fault::Information { from: 1, to: Some(0), kind: Kind::Edge2, .. }), "{found:?}");
    assert_eq!(found.line().0, 4);
    let text =
        "EDGE_SE2: the information matrix is not positive definite: its smallest eigenvalue is -1.000e0";
    assert_eq!(found.to_string().replace(" of 1", ""), text);
}

#[test]
fn the_eigenvalue_range_spans_all_edges() {
    let mut graph = PoseGraph::default();
    let q = nalgebra::Rotation3::from_euler_angles(0.3, -0.7, 1.1).into_inner();
    let make = |d: [f64; 3]| q * Matrix3::from_diagonal(&Vector3::from(d)) * q.transpose();
    graph.edges2 = vec![
        edge(0, 1, make([2.0, 5.0, 7.0])),
        edge(1, 2, make([1e-6, 1.0, 1e6])),
        edge(2, 3, make([1.0; 3])),
    ];
    let (low, high) = graph.statistics().information_range.unwrap();
    assert!((high / 1e6 - 1.0).abs() < 1e-14);
    assert!((low - 1e-6).abs() < 4.0 * f64::EPSILON * 1e6, "{low}"); // the matrix itself is rounded to ε·1e6
}

#[test]
fn parts_that_nothing_joins_are_counted() {
    let text = format!(
        "{TWO}VERTEX_SE2 2 0 0 0\nVERTEX_SE2 3 0 0 0\nVERTEX_SE2 9 0 0 0\nEDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\nEDGE_SE2 2 3 1 0 0 1 0 0 1 0 1"
    );
    assert_eq!(fault(&text), Fault::Disconnected { components: 3, largest: 3, id: 0 });
}

#[test]
fn the_same_edge_twice_is_noted_but_not_a_second_measurement() {
    let e = "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n";
    let found = fault(&format!("{TWO}{e}EDGE_SE2 0 1 1 0.1 0 1 0 0 1 0 1\n{e}{e}"));
    let Fault::Repeated { count, first, line, from: 0, to: 1, kind: Kind::Edge2 } = found else {
        panic!("{found:?}")
    };
    assert_eq!((count, first.0, line.0, found.severity()), (3, 3, 5, Severity::Note));
}

#[test]
fn a_repeated_vertex_made_in_memory_is_an_error() {
    let vertex = |id| Vertex { id, value: SE2::identity(), line: Line(0) };
    let mut graph = PoseGraph { edges2: vec![edge(0, 1, Matrix3::identity())], ..PoseGraph::default() };
    graph.poses2 = vec![vertex(0), vertex(1), vertex(0)];
    assert_eq!(graph.faults(), [Fault::DuplicateVertex { id: 0, first: Line(0), line: Line(0) }]);
}

#[test]
fn a_quaternion_far_from_unit_norm_is_a_warning_of_the_reader() {
    let parsed =
        io::read(b"VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 0 0 0 0 0 1.2 1.6", "", None).unwrap();
    let [Fault::QuaternionNorm { norm, line }] = parsed.warnings[..] else { panic!("{:?}", parsed.warnings) };
    assert_eq!((norm, line.0), (2.0, 2));
    let q = parsed.graph.poses3[1].value.rotation().quaternion_xyzw();
    assert!((q[2] - 0.6).abs() < f64::EPSILON && (q[3] - 0.8).abs() < f64::EPSILON);
    let rounded = io::read(b"VERTEX_SE3:QUAT 0 0 0 0 0.5774 0.5774 0.5774 0.001", "", None).unwrap();
    assert_eq!(rounded.warnings, []);
}

#[test]
fn statistics_count_what_is_there() {
    let text = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 3 4 0\nVERTEX_SE2 5 3 4 1\nVERTEX_XY 7 -1 9\nFIX 0\n\
                EDGE_SE2 0 1 1 0 0 4 0 0 4 0 100\nEDGE_SE2 1 5 1 0 0 1 0 0 1 0 1\nEDGE_SE2 5 0 1 0 0 4 0 0 4 0 100\n\
                EDGE_SE2 1 0 1 0 0 4 0 0 4 0 100\nEDGE_SE2_XY 5 7 1 1 1 0 1\nEDGE_PRIOR_SE2 0 0 0 0 1 0 0 1 0 1\nODD 1\nODD 2\n";
    let s = io::read(text.as_bytes(), "", None).unwrap().graph.statistics();
    assert_eq!((s.poses, s.points, s.ids, s.fixed, s.components, s.largest_component), (3, 1, 4, 1, 1, 4));
    assert_eq!((s.id_range, s.id_gaps), (Some((0, 7)), 4));
    assert_eq!(s.counts, [(Kind::Edge2, 4), (Kind::Sighting2, 1), (Kind::Prior2, 1)]);
    assert_eq!(s.loop_closures, 1, "5 → 0: 1 and 5 follow each other, since no pose lies between");
    assert_eq!(s.repeated_edges, 1);
    assert_eq!(s.degree, Degree { min: 1, mean: 2.5, max: 3 });
    assert_eq!(s.bounds, Some((Vector3::new(-1.0, 0.0, 0.0), Vector3::new(3.0, 9.0, 0.0))));
    assert!((s.trajectory_length - 5.0).abs() < 1e-15);
    assert_eq!((s.sigma_translation, s.sigma_rotation), (Some(0.5), Some(0.1)));
    assert_eq!(s.information_range, Some((1.0, 100.0)));
    assert_eq!(s.other, [("ODD".to_owned(), 2)]);
}

#[test]
fn statistics_of_nothing_are_nothing() {
    let s = PoseGraph::default().statistics();
    assert_eq!((s.ids, s.components, s.id_range, s.bounds, s.sigma_rotation), (0, 0, None, None, None));
}

#[test]
fn constraints_come_kind_by_kind_with_their_numbers() {
    let s = Simulator::Landmarks.simulate(&Options { size: Some(50), ..Options::default() }).unwrap().graph;
    let kinds: Vec<Kind> = s.constraints().map(|c| c.kind).collect();
    assert!(kinds.is_sorted() && kinds.contains(&Kind::Sighting2));
    let first = s.constraints().next().unwrap();
    assert_eq!((first.from, first.to, first.information), (0, Some(1), s.edges2[0].information.as_slice()));
}

#[test]
fn a_million_edges_between_two_vertices_are_counted() {
    let edges3 = (0..1_000_000u32)
        .map(|k| {
            let t = Vector3::new(f64::from(k % 1000), 0.0, 0.0);
            let measured = boxplus::lie::SE3::new(boxplus::lie::SO3::identity(), t);
            Edge { from: 0, to: 1, measured, information: Matrix6::identity(), line: Line(k + 1) }
        })
        .collect();
    let graph = PoseGraph { edges3, ..PoseGraph::default() };
    let faults = graph.faults();
    let s = graph.statistics();
    assert_eq!(faults.len(), 1000, "each of 1000 displacements is repeated");
    assert_eq!((s.repeated_edges, s.degree.max), (999_999, 1_000_000));
}

#[test]
fn lines_say_where_things_stand_but_do_not_tell_graphs_apart() {
    let text = format!("\n\n{TWO}EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n");
    let a = io::read(text.as_bytes(), "", None).unwrap().graph;
    let b = io::read(io::write(&a, Format::G2o).unwrap().as_bytes(), "", None).unwrap().graph;
    assert_eq!((a.edges2[0].line.0, b.edges2[0].line.0), (5, 3));
    assert_eq!(a, b);
    assert_ne!(a.edges2[0].measured, SE2::new(Vector2::zeros(), 0.0));
}
