//! Every kind of broken file is refused with its place, and none of them panics.
#![cfg(feature = "io")]
#![allow(clippy::unwrap_used)] // a failing test may panic

use boxplus::io::{self, Format, IoError, IoErrorKind, WriteError};
use boxplus::lie::{LieGroup, SE2};
use boxplus::pose_graph::simulate::{Options, Simulator};
use boxplus::pose_graph::{Edge, Line, PoseGraph, Vertex};
use nalgebra::{Matrix3, Vector2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::io::Write;

fn refused(text: impl AsRef<[u8]>) -> IoError {
    io::read(text.as_ref(), "bad.g2o", None).unwrap_err()
}

/// Checks the whole message, the text under the span, and that the help says something.
fn assert_refused(text: &str, message: &str, under_span: &str, help: &str) {
    let error = refused(text);
    assert_eq!(error.to_string(), format!("bad.g2o:{message}"));
    let span = error.place.as_ref().map_or(0..0, |place| place.span.clone());
    assert_eq!(&text[span], under_span, "{message}");
    assert!(error.help().contains(help), "{}", error.help());
}

#[test]
fn a_truncated_line_is_refused() {
    assert_refused(
        "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0",
        "2:17: the line ends too early; expected theta in field 4 of VERTEX_SE2",
        "",
        "VERTEX_SE2 id x y theta",
    );
    assert_refused(
        "EDGE_SE2 0 1 1 0 0 1 0 0 1 0  \nVERTEX_SE2 1 1 0 0",
        "1:29: the line ends too early; expected information(6) in field 11 of EDGE_SE2",
        "",
        "EDGE_SE2 from to x y theta information(6)",
    );
}

#[test]
fn what_is_no_number_is_refused() {
    for word in ["x", "1,5", "0x10", "1.2.3", "--1", "1e", "-", "1.#QNAN", "١"] {
        let text = format!("VERTEX_XY 7 0 0\n VERTEX_XY 8 {word} 0");
        let message = format!("2:14: `{word}` is not a number; expected x in field 2 of VERTEX_XY");
        assert_refused(&text, &message, word, "VERTEX_XY id x y");
    }
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    for word in ["nan", "-NaN", "inf", "-Infinity", "1e999"] {
        let text = format!("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 {word}");
        let message =
            format!("1:30: `{word}` is not a finite number; expected information(6) in field 11 of EDGE_SE2");
        assert_refused(&text, &message, word, "no estimate can come from it");
    }
}

#[test]
fn a_zero_quaternion_is_refused() {
    let text = "VERTEX_SE3:QUAT 0 1 2 3 0 0.0 -0 0";
    let message = "1:25: the quaternion is zero";
    assert_refused(text, message, "0 0.0 -0 0", "0 0 0 1 is no rotation");
}

#[test]
fn a_field_too_many_is_refused() {
    let text = "VERTEX_XY 0 1 2 3 4";
    assert_refused(text, "1:17: the line goes on after its last field, with `3`", "3", "VERTEX_XY id x y");
}

#[test]
fn a_repeated_vertex_names_both_lines() {
    let text = "VERTEX_SE2 3 0 0 0\nVERTEX_SE2 4 0 0 0\n# between\nVERTEX_XY 3 0 0\nVERTEX_XY 4 0 0\n";
    assert_refused(text, "4:11: 3 was already given in line 1", "3", "ids count poses and points together");
    let text = "VERTEX_XY 0 0 0\nPARAMS_SE2OFFSET 0 0 0 0\nPARAMS_SE3OFFSET 0 0 0 0 0 0 0 1";
    assert!(refused(text).to_string().contains("3:18: 0 was already given in line 2"));
}

#[test]
fn ids_that_are_negative_huge_or_fractions_are_refused() {
    let message = |why: &str| format!("1:11: {why}; expected id in field 1 of VERTEX_XY");
    let whole = "whole numbers from 0 to 18446744073709551615";
    assert_refused("VERTEX_XY -1 0 0", &message("the id -1 is negative"), "-1", whole);
    let huge = "18446744073709551616";
    let text = format!("VERTEX_XY {huge} 0 0");
    assert_refused(&text, &message("the id 18446744073709551616 is too large"), huge, whole);
    for word in ["1.0", "+1", "a", "1e3", "-", "-x"] {
        let text = format!("VERTEX_XY {word} 0 0");
        assert_refused(&text, &message(&format!("`{word}` is not an id")), word, whole);
    }
    assert!(io::read(b"VERTEX_XY 18446744073709551615 0 0", "", None).is_ok());
}

#[test]
fn a_file_without_content_is_refused() {
    let message = "bad.g2o: no vertex and no edge in this file";
    for text in ["", "\n\n", "# nothing\n", "FIX 0\n", "hello\nworld\n"] {
        assert!(refused(text).to_string().starts_with(message), "{text:?}");
    }
    assert_eq!(refused("hello\nworld\n").kind, IoErrorKind::Empty { unknown: 2 });
}

#[test]
fn binary_garbage_is_refused() {
    let error = refused(b"VERTEX_XY 0 0 0\n\x89PNG\r\n\x1a\n\0\0\0\rIHDR");
    assert_eq!(error.to_string(), "bad.g2o:4:1: this is not a text file (byte 0x00)");
    let error = refused(b"VERTEX_XY 0 0 0\nab \xff\xfe");
    assert_eq!(
        (error.kind.clone(), error.place.unwrap().span),
        (IoErrorKind::NotText { byte: 0xff }, 19..20)
    );
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for length in 1..500 {
        let bytes: Vec<u8> = (0..length).map(|_| rng.random()).collect();
        let _: IoError = refused(bytes);
    }
}

#[test]
fn broken_gzip_is_refused() {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    for id in 0..1000 {
        writeln!(encoder, "VERTEX_XY {id} {} 0", f64::from(id).sin()).unwrap();
    }
    let bytes = encoder.finish().unwrap();
    for length in [2, 9, 10, 11, bytes.len() / 2, bytes.len() - 8, bytes.len() - 1] {
        assert_eq!(refused(&bytes[..length]).kind, IoErrorKind::GzipTruncated, "{length} bytes");
    }
    for at in [3, bytes.len() / 2, bytes.len() - 6] {
        let mut corrupt = bytes.clone();
        corrupt[at] ^= 0x55;
        let error = refused(corrupt);
        assert!(
            matches!(error.kind, IoErrorKind::GzipCorrupt | IoErrorKind::GzipTruncated),
            "byte {at}: {error}"
        );
    }
    assert_eq!(io::read(&bytes, "", None).unwrap().graph.points2.len(), 1000);
}

#[test]
fn errors_of_every_format_name_its_fields() {
    let field = |text: &str, format| {
        let error = io::read(text.as_bytes(), "", Some(format)).unwrap_err();
        error.place.as_ref().and_then(io::Place::expected)
    };
    assert_eq!(field("VERTEX3 0 0 0 0 0 x 0", Format::Toro), Some("pitch"));
    assert_eq!(field("EDGE2 0 1 0 0 0 1 0 x 0 0 0", Format::Toro), Some("I22"));
    assert_eq!(field("EDGE3 0 1 0 0 0 0 0 0 1", Format::Toro), Some("information(21)"));
    assert_eq!(field("LANDMARK 0 1 0 0 1 0", Format::Isam), Some("root(3)"));
    assert_eq!(field("EDGE_SE3_TRACKXYZ 0 1 -1", Format::G2o), Some("offset"));
    assert_eq!(field("EDGE_RANGE 0.5 A0 L0 3", Format::Pyfg), Some("variance"));
}

#[test]
fn pyfg_lines_are_refused_with_their_place_and_name() {
    let first = "VERTEX_SE2 0 A0 0 0 0\n";
    let refused = |line: &str, message: &str, under_span: &str, help: &str| {
        assert_refused(&format!("{first}{line}"), &format!("2:{message}"), under_span, help);
    };
    let name = "names are a letter and a number";
    refused(
        "EDGE_RANGE 0.5 A0 12 3 0.1",
        "19: `12` is not a name; expected to in field 3 of EDGE_RANGE",
        "12",
        name,
    );
    refused("VERTEX_XY L 0 0", "11: `L` is not a name; expected name in field 1 of VERTEX_XY", "L", name);
    let huge = "A72057594037927936"; // 2⁵⁶
    let message = format!("11: `{huge}` is not a name; expected name in field 1 of VERTEX_XY");
    refused(&format!("VERTEX_XY {huge} 0 0"), &message, huge, name);
    refused(
        "EDGE_RANGE x A0 L0 3 0.1",
        "12: `x` is not a number; expected time in field 1 of EDGE_RANGE",
        "x",
        "EDGE_RANGE time from to range variance",
    );
    for variance in ["0", "-0.1"] {
        let line = format!("EDGE_RANGE 0.5 A0 L0 3 {variance}");
        refused(&line, "24: the covariance is not positive definite", variance, "positive eigenvalues");
    }
    refused(
        "EDGE_SE2_XY 0.5 A0 L0 1 2 1 2 1",
        "27: the covariance is not positive definite",
        "1 2 1",
        "its upper triangle row by row",
    );
    refused("VERTEX_SE2 1 A0 0 0 0", "14: A0 was already given in line 1", "A0", "renumber or delete one");
}

#[test]
fn points_that_cannot_be_renumbered_are_refused() {
    let s3 = "1 0 0 1 0 1";
    let text = format!("POINT3 18446744073709551615 1 0 0 0 {s3}");
    assert!(matches!(refused(text).kind, IoErrorKind::HugeId { .. }));
    let text = format!("POINT3 0 0 0 0 0 {s3}\nPOINT3 1 0 0 0 0 {s3}");
    let parsed = io::read(text.as_bytes(), "", None).unwrap();
    assert_eq!((parsed.point_shift, parsed.graph.sightings3[0].to), (2, 2));
}

#[test]
fn a_graph_that_a_format_cannot_hold_is_not_written() {
    let park =
        Simulator::Landmarks.simulate(&Options { size: Some(50), ..Options::default() }).unwrap().graph;
    let error = io::write(&park, Format::Toro).unwrap_err();
    assert!(
        matches!(error, WriteError::Unrepresentable { format: Format::Toro, what: "points", .. }),
        "{error}"
    );

    let mut graph = PoseGraph::default();
    graph.poses2.push(Vertex { id: 5, value: SE2::new(Vector2::new(f64::NAN, 0.0), 0.0), line: Line(0) });
    for format in [Format::G2o, Format::Toro] {
        assert!(matches!(io::write(&graph, format).unwrap_err(), WriteError::NotFinite { id: 5, .. }));
    }

    let alone = io::read(b"VERTEX_SE2 0 0 0 0\n", "", None).unwrap().graph;
    let what = "vertices without a measurement";
    let error = WriteError::Unrepresentable { format: Format::Isam, what, count: 1 };
    assert_eq!(io::write(&alone, Format::Isam).unwrap_err(), error);

    let kept = "VERTEX_SE2 0 0 0 0\nVERTEX3 1 2 3 4 5 6 7 8\n";
    let graph = io::read(kept.as_bytes(), "", Some(Format::G2o)).unwrap().graph;
    assert_eq!(io::write(&graph, Format::G2o).unwrap(), kept);
    let error = WriteError::Foreign { format: Format::Toro, tag: "VERTEX3".into(), line: Line(2) };
    assert_eq!(io::write(&graph, Format::Toro).unwrap_err(), error);

    let information = Matrix3::from_diagonal_element(-1.0);
    let edge = Edge { from: 8, to: 9, measured: SE2::identity(), information, line: Line(0) };
    let graph = PoseGraph { edges2: vec![edge], ..PoseGraph::default() };
    let bare = "vertices whose names are bare numbers";
    let error = io::write(&graph, Format::Pyfg).unwrap_err();
    assert!(matches!(error, WriteError::Unrepresentable { what, count: 2, .. } if what == bare), "{error}");
    let error = WriteError::NotPositiveDefinite { tag: "EDGE2", id: 8 };
    assert_eq!(io::write(&graph, Format::Isam).unwrap_err(), error);
}

/// One random injury: a byte changed, some removed, some doubled, or the end cut off.
fn injure(text: &mut Vec<u8>, rng: &mut ChaCha8Rng) {
    const BYTES: &[u8] = b"0123456789.-+eE \n\r\t#:_NaIfXY\0\xff\x1f\x8b";
    if text.is_empty() {
        return;
    }
    let at = rng.random_range(0..text.len());
    let end = (at + rng.random_range(1..40)).min(text.len());
    match rng.random_range(0..6) {
        0 | 1 => text[at] = BYTES[rng.random_range(0..BYTES.len())],
        2 => text.insert(at, BYTES[rng.random_range(0..BYTES.len())]),
        3 => drop(text.drain(at..end)),
        4 => text.extend_from_within(at..end),
        _ => text.truncate(at.max(1)),
    }
}

#[test]
fn twenty_thousand_injured_files_never_panic_and_errors_point_into_the_file() {
    let small = Options { size: Some(6), ..Options::default() };
    let graph = |s: Simulator| s.simulate(&small).unwrap().graph;
    let park = io::write(&graph(Simulator::Landmarks), Format::G2o).unwrap();
    let texts = [
        io::write(&graph(Simulator::Sphere), Format::G2o).unwrap(),
        park + "PARAMS_SE3OFFSET 0 0 0 0 0 0 0 1\nEDGE_SE3_TRACKXYZ 0 1 0 1 2 3 1 0 0 1 0 1\nFIX 0 1\n\
                EDGE_SE3_PRIOR 0 0 0 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\nLASER 1 2 3\n",
        io::write(&graph(Simulator::Manhattan), Format::Toro).unwrap(),
        io::write(&graph(Simulator::Garage), Format::Isam).unwrap()
            + "ODOMETRY 0 1 1 0 0 1 0 0 1 0 1\nLANDMARK 0 9 1 1 1 0 1\nPOINT3 0 1 1 1 1 1 0 0 1 0 1\n",
        "VERTEX_SE2 0.1 A0 0 0 0\nVERTEX_SE2 0.2 A1 1 0 0.1\nVERTEX_XY L0 3 4\nEDGE_SE2 0.2 A0 A1 1 0 0.1 1 0 0 1 0 1\n\
         EDGE_RANGE 0.2 A1 L0 4.5 0.1\nVERTEX_SE2:PRIOR 0.1 A0 0 0 0 1 0 0 1 0 1\nEDGE_SE2_XY 0.2 A1 L0 2 4 1 0 1\n"
            .into(),
    ];
    let mut rng = ChaCha8Rng::seed_from_u64(2026);
    let (mut read, mut refused) = (0, 0);
    for round in 0..20_000 {
        let mut text = texts[round % texts.len()].clone().into_bytes();
        for _ in 0..rng.random_range(1..4) {
            injure(&mut text, &mut rng);
        }
        match io::read(&text, "injured", None) {
            Ok(parsed) => {
                read += 1;
                parsed.graph.faults();
                parsed.graph.statistics();
                if let Ok(text) = io::write(&parsed.graph, Format::G2o) {
                    let back = io::read(text.as_bytes(), "", None).unwrap().graph;
                    assert!(parsed.format != Format::G2o || parsed.graph == back, "round {round}");
                }
            }
            Err(error) => {
                refused += 1;
                assert!(!error.help().is_empty());
                if let Some(place) = error.place {
                    let lines = text.split(|&b| b == b'\n').count();
                    assert!((1..=lines).contains(&(place.line as usize)), "round {round}");
                    assert!(
                        place.span.start <= place.span.end && place.span.end <= text.len(),
                        "round {round}"
                    );
                }
            }
        }
    }
    assert!(
        read > 1000 && refused > 1000,
        "{read} read, {refused} refused: the injuries are too mild or too severe"
    );
}

#[test]
fn a_file_cut_anywhere_never_panics() {
    let graph = Simulator::Torus.simulate(&Options { size: Some(12), ..Options::default() }).unwrap().graph;
    let text = io::write(&graph, Format::G2o).unwrap();
    for length in 0..text.len() {
        match io::read(&text.as_bytes()[..length], "cut", None) {
            Ok(parsed) => assert!(parsed.graph.vertex_count() > 0),
            Err(error) => assert!(error.place.is_none_or(|place| place.span.end <= length)),
        }
    }
}
