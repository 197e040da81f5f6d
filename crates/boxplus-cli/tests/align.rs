//! `boxplus align`: streams, files, exit codes, refusals.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fmt::Write as _;

use common::{Folder, settings};

/// Points on three walls and a floor of a room, on a grid that differs from `step` to `step`.
fn room(step: f64, moved: [f64; 3]) -> String {
    let mut text = String::new();
    let [dx, dy, turn] = moved;
    let (s, c) = turn.sin_cos();
    let mut put = |x: f64, y: f64, z: f64| {
        let (x, y) = (x - dx, y - dy);
        writeln!(text, "{:.5} {:.5} {z:.5}", c * x + s * y, c * y - s * x).unwrap();
    };
    let count = |length: f64| (length / step).round() as i32;
    for i in 0..count(6.0) {
        let u = f64::from(i) * step;
        for j in 0..count(2.0) {
            let v = f64::from(j) * step;
            put(u, 0.0, v);
            put(u, 4.0, v);
        }
        for j in 0..count(4.0) {
            put(u, f64::from(j) * step, 0.0);
        }
    }
    for i in 0..count(4.0) {
        for j in 0..count(2.0) {
            put(0.0, f64::from(i) * step, f64::from(j) * step);
        }
    }
    text
}

fn rooms() -> Folder {
    Folder::new().with("map.xyz", room(0.1, [0.0; 3])).with("scan.xyz", room(0.13, [0.1, -0.05, 0.03]))
}

#[test]
fn align_prints_one_readable_screen() {
    let run = rooms().boxplus("align scan.xyz map.xyz --max-distance 0.5 --threads 1");
    assert_eq!(run.code, 0, "{}", run.stderr);
    for word in ["scan.xyz", "moved", "turned", "known to", "fitness", "stopped", "time"] {
        assert!(run.stdout.contains(word), "{word} is missing: {}", run.stdout);
    }
    assert_eq!(run.stderr, "");
}

#[test]
fn the_json_of_align_has_the_motion_and_its_covariance() {
    let folder = rooms();
    let run = folder.boxplus("align scan.xyz map.xyz --max-distance 0.5 --json -o moved.ply --plot both.svg");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let document = run.json();
    let t = &document["target_from_source"]["translation"];
    let found: Vec<f64> = t.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    for (found, truth) in found.iter().zip([0.1, -0.05, 0.0]) {
        assert!((found - truth).abs() < 2e-3, "{document}");
    }
    let yaw = 2.0 * document["target_from_source"]["quaternion_xyzw"][2].as_f64().unwrap().asin();
    assert!((yaw - 0.03).abs() < 1e-3, "{document}");
    assert_eq!(document["covariance"].as_array().unwrap().len(), 6);
    assert_eq!(document["outputs"], serde_json::json!(["moved.ply", "both.svg"]));
    assert_eq!((document["converged"].as_bool(), document["dimension"].as_u64()), (Some(true), Some(3)));
    assert!(folder.read("moved.ply").starts_with(b"ply\nformat binary_little_endian"));
    assert!(String::from_utf8(folder.read("both.svg")).unwrap().contains("scan.xyz onto map.xyz"));
    // What was moved is where it belongs.
    let again = folder.boxplus("align moved.ply map.xyz --max-distance 0.5 --json").json();
    let x = again["target_from_source"]["translation"][0].as_f64().unwrap();
    assert!(x.abs() < 1e-3, "{again}");
}

#[test]
fn threads_change_no_digit_of_the_document() {
    let folder = rooms();
    let run = |threads: u32| {
        let mut document =
            folder.boxplus(&format!("align scan.xyz map.xyz --voxel 0.2 --json --threads {threads}")).json();
        document["seconds"] = serde_json::Value::Null;
        document
    };
    assert_eq!(run(1), run(2));
}

#[test]
fn a_cloud_of_two_columns_is_aligned_in_the_plane() {
    let wall = |dx: f64, step: f64| -> String {
        let along = (0..200).map(|i| format!("{},{}\n", f64::from(i) * step - dx, 0.0));
        let up = (0..200).map(|i| format!("{},{}\n", -dx, f64::from(i) * step));
        along.chain(up).collect()
    };
    let folder = Folder::new().with("a.csv", wall(0.1, 0.021)).with("b.csv", wall(0.0, 0.02));
    let document = folder.boxplus("align a.csv b.csv --max-distance 0.3 --json").json();
    assert_eq!(document["dimension"], 2);
    let x = document["target_from_source"]["translation"][0].as_f64().unwrap();
    assert!((x - 0.1).abs() < 2e-3, "{document}");
    assert_eq!(document["coordinates"], serde_json::json!(["x", "y", "angle"]));
}

#[test]
fn a_straight_wall_leaves_a_direction_open_and_the_exit_code_says_so() {
    let wall =
        |step: f64| (0..300).map(|i| format!("{} 0\n", f64::from(i) * step)).collect::<Vec<_>>().concat();
    let folder = Folder::new().with("a.xyz", wall(0.021)).with("b.xyz", wall(0.02));
    let run = folder.boxplus("align a.xyz b.xyz --max-distance 0.3");
    assert_eq!(run.code, 4, "{}", run.transcript());
    assert!(run.stdout.contains("translation along (1.00, 0.00)"), "{}", run.stdout);
    let document = folder.boxplus("align a.xyz b.xyz --max-distance 0.3 --json").json();
    assert!(document["covariance"].is_null() && document["free"].as_array().unwrap().len() == 1);
}

#[test]
fn starts_are_taken_in_every_form() {
    let folder = rooms().with("start.txt", "1 0 0 0.1\n0 1 0 -0.05\n0 0 1 0\n0 0 0 1\n");
    for init in [
        "identity",
        "centroids",
        "start.txt",
        "0.1,-0.05,0,0,0,0,1",
        "0.1,-0.05,0,0,0,0.03",
        "-0.01,0,0,0,0,0,1",
    ] {
        let run = folder.boxplus(&format!("align scan.xyz map.xyz --max-distance 0.6 --json --init {init}"));
        assert_eq!(run.code, 0, "{init}: {}", run.stderr);
        let x = run.json()["target_from_source"]["translation"][0].as_f64().unwrap();
        assert!((x - 0.1).abs() < 2e-3, "{init}: {x}");
    }
}

#[test]
fn what_is_asked_wrongly_is_refused_with_code_2() {
    let folder = rooms();
    for wrong in [
        "--init 1,2",
        "--init 1,2,three",
        "--init 0,0,0,0,0,0,0",
        "--init 1,0,0,0,0,1,0,0,0,0,5,0",
        "--init nan,0,0,0,0,0,1",
        "--voxel -1",
        "--voxel 1e-12",
        "--max-distance 0",
        "--neighbours 0",
        "--method nearest",
        "--robust huber:0",
        "--from las",
        "--plot out.gif",
    ] {
        let run = folder.boxplus(&format!("align scan.xyz map.xyz {wrong}"));
        assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{wrong}: {}", run.transcript());
        assert!(!run.stderr.is_empty());
    }
    assert_eq!(folder.names(), ["map.xyz", "scan.xyz"], "nothing was written");
}

#[test]
fn malformed_clouds_are_shown_with_their_place() {
    let folder = rooms()
        .with("bad.xyz", "1 2 3\n4 five 6\n")
        .with("cut.ply", "ply\nformat ascii 1.0\n")
        .with("nan.xyz", "nan 0 0\n");
    let run = folder.boxplus("align bad.xyz map.xyz -o out.ply");
    assert_eq!((run.code, run.stdout.as_str()), (3, ""));
    settings().bind(|| insta::assert_snapshot!(run.stderr));
    for name in ["cut.ply", "nan.xyz", "nowhere.ply"] {
        let run = folder.boxplus(&format!("align {name} map.xyz -o out.ply"));
        assert_eq!((run.code, run.stdout.as_str()), (3, ""), "{name}");
        assert!(run.stderr.contains(name), "{}", run.stderr);
    }
    assert!(!folder.names().contains(&"out.ply".to_owned()));
}

#[test]
fn clouds_that_do_not_meet_have_no_answer() {
    let run = rooms().boxplus("align scan.xyz map.xyz --max-distance 0.5 --init 50,0,0,0,0,0,1");
    assert_eq!(run.code, 4, "{}", run.transcript());
    assert!(run.stderr.contains("do not overlap") && run.stderr.contains("--init"), "{}", run.stderr);
}

#[test]
fn too_few_steps_are_told_with_code_5() {
    let run = rooms().boxplus("align scan.xyz map.xyz --max-distance 0.5 --max-iterations 1");
    assert_eq!(run.code, 5, "{}", run.transcript());
    assert!(run.stderr.contains("--max-iterations"), "{}", run.stderr);
}

#[test]
fn a_cloud_comes_from_standard_input_and_goes_to_standard_output() {
    let folder = rooms();
    let run = folder
        .command("align - map.xyz --max-distance 0.5 -o -")
        .write_stdin(room(0.13, [0.1, 0.0, 0.0]))
        .output()
        .unwrap();
    assert!(run.status.success());
    assert!(run.stdout.starts_with(b"ply\n"), "only the file is on standard output");
    assert!(String::from_utf8_lossy(&run.stderr).contains("fitness"));
}
