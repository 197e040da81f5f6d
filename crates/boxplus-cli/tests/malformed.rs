//! Input that is not what it should be: a clear error, exit code 3, no panic, nothing written.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fmt::Write as _;

use common::{Folder, SQUARE, settings};

/// Solves `content`, expects a refusal, and returns what was said.
fn refusal(content: impl AsRef<[u8]>) -> String {
    let folder = Folder::new().with("map.g2o", content);
    let run = folder.boxplus("solve map.g2o -o out.g2o --plot out.svg --json");
    assert_eq!((run.code, run.stdout.as_str()), (3, ""), "{}", run.stderr);
    assert_eq!(folder.names(), ["map.g2o"], "nothing else may be there");
    run.stderr
}

macro_rules! refusals {
    ($($(#[$doc:meta])* $name:ident: $content:expr;)*) => {$(
        $(#[$doc])*
        #[test]
        fn $name() {
            let said = refusal($content);
            settings().bind(|| insta::assert_snapshot!(stringify!($name), said));
        }
    )*};
}

refusals! {
    a_truncated_line: SQUARE.trim_end().strip_suffix("400").unwrap();
    a_word_for_a_number: SQUARE.replace("1.2 3.1", "north 3.1");
    not_a_number: SQUARE.replace("1.2 3.1", "NaN 3.1");
    an_infinite_number: SQUARE.replace("1.57 100", "inf 100");
    a_number_beyond_all_floats: SQUARE.replace("1.57 100", "1e999 100");
    an_indefinite_information_matrix: SQUARE.replacen("100 0 0 100 0 400", "100 900 0 100 0 400", 1);
    a_negative_information_matrix: SQUARE.replacen("100 0 0 100 0 400", "-100 0 0 100 0 400", 1);
    a_duplicate_id: SQUARE.replace("VERTEX_SE2 3", "VERTEX_SE2 1");
    a_dangling_edge: SQUARE.replace("EDGE_SE2 3 0", "EDGE_SE2 3 77");
    an_edge_between_the_wrong_kinds: format!("{SQUARE}VERTEX_XY 9 1 1\nEDGE_SE2 3 9 1 0 1.57 100 0 0 100 0 400\n");
    a_zero_quaternion: "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 1 0 0 0 0 0 0\n";
    an_empty_file: "";
    a_file_of_blanks_and_comments: "\n   \n# nothing\n\n";
    a_text_that_is_no_graph: "Dear Sir or Madam,\nplease find attached\n";
    binary_garbage: (0..4000u32).map(|i| (i.wrapping_mul(2654435761) >> 13) as u8).collect::<Vec<_>>();
    a_cut_gzip_file: &gzip(SQUARE.as_bytes())[..60];
    a_corrupt_gzip_file: { let mut bytes = gzip(SQUARE.as_bytes()); let n = bytes.len(); bytes[n - 6] ^= 0xff; bytes };
    a_line_of_a_megabyte: format!("{SQUARE}VERTEX_SE2 4 0 0 0 {}", "7 ".repeat(500_000));
    a_negative_id: SQUARE.replace("VERTEX_SE2 3", "VERTEX_SE2 -3");
    a_huge_id: SQUARE.replace("VERTEX_SE2 3", "VERTEX_SE2 99999999999999999999");
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    use std::io::Write as _;
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn a_missing_file() {
    let run = Folder::new().boxplus("info nowhere.g2o");
    assert_eq!((run.code, run.stdout.as_str()), (3, ""));
    settings().bind(|| insta::assert_snapshot!(run.stderr));
}

#[test]
fn a_folder_for_a_file() {
    let run = Folder::new().boxplus("info .");
    assert_eq!((run.code, run.stdout.as_str()), (3, ""));
    settings().bind(|| insta::assert_snapshot!(run.stderr));
}

#[test]
fn garbage_of_every_kind_is_refused_by_every_verb() {
    let cuts = (0..SQUARE.len()).step_by(37).map(|n| SQUARE.as_bytes()[..n].to_vec());
    let flips = (0..SQUARE.len()).step_by(41).map(|n| {
        let mut bytes = SQUARE.as_bytes().to_vec();
        bytes[n] = 0xff;
        bytes
    });
    for content in cuts.chain(flips) {
        let folder = Folder::new().with("map.g2o", &content);
        for verb in ["info", "convert", "plot", "solve"] {
            let rest = match verb {
                "convert" => "out.graph",
                "plot" => "-o out.svg",
                _ => "",
            };
            let run = folder.boxplus(&format!("{verb} map.g2o {rest}"));
            assert!([0, 3, 4, 5].contains(&run.code), "{verb}: {}", run.transcript());
            assert_eq!(run.code == 3, run.stderr.contains("  × "), "{verb}: {}", run.transcript());
        }
    }
}

/// Legal, if odd: it must be solved, and as fast as its size allows.
#[test]
fn a_million_edges_between_two_vertices_are_solved() {
    let mut text = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1.1 0 0.1\n".to_owned();
    for i in 0..1_000_000 {
        writeln!(text, "EDGE_SE2 0 1 {} 0 0 1 0 0 1 0 1", 1.0 + 1e-6 * f64::from(i)).unwrap();
    }
    let folder = Folder::new().with("map.g2o", text);
    let run = folder.boxplus("solve map.g2o -o out.g2o --json");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let document = run.json();
    assert_eq!((document["edges"].as_u64(), document["converged"].as_bool()), (Some(1_000_000), Some(true)));
}
