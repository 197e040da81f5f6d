//! Logs of sensors, filtered: what comes out, and what is said of logs that do not go together.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fmt::Write;

use common::Folder;

/// A lap of a circle of 5 m at 1 m/s, ten times a second, with five beacons; what is read is off by sines that have no mean.
fn lap() -> Folder {
    let beacons = [(0.0, 0.0), (7.0, 3.0), (-2.0, 7.0), (-6.0, -3.0), (3.0, -6.0)];
    let [mut odometry, mut seen, mut truth] = [const { String::new() }; 3];
    let jitter = |k: usize, frequency: f64| (frequency * k as f64).sin();
    for k in 0..=314 {
        let (time, heading) = (0.1 * k as f64, 0.02 * k as f64);
        let (x, y) = (5.0 * heading.sin(), 5.0 - 5.0 * heading.cos());
        writeln!(truth, "{time:.3} {x:.6} {y:.6} {heading:.6}").unwrap();
        writeln!(odometry, "{time:.3} {} {}", 1.0 + 0.03 * jitter(k, 1.7), 0.2 + 0.02 * jitter(k, 2.3))
            .unwrap();
        if k % 5 == 0 && k > 0 {
            let (number, (bx, by)) = (k / 5 % 5, beacons[k / 5 % 5]);
            let (range, bearing) = ((bx - x).hypot(by - y), (by - y).atan2(bx - x) - heading);
            let turned = bearing.sin().atan2(bearing.cos());
            let (range, bearing) = (range + 0.05 * jitter(k, 0.9), turned + 0.01 * jitter(k, 1.3));
            writeln!(seen, "{time:.3} {} {range:.6} {bearing:.6}", 10 + number).unwrap();
        }
    }
    let landmarks = |f: &dyn Fn(usize, (f64, f64)) -> String| -> String {
        beacons.into_iter().enumerate().map(|(i, b)| f(i, b)).collect()
    };
    Folder::new()
        .with("odometry.dat", odometry)
        .with("seen.dat", seen)
        .with("truth.dat", truth)
        .with("landmarks.dat", landmarks(&|i, (x, y)| format!("{} {x} {y} 0.001 0.001\n", i + 1)))
        .with("barcodes.dat", landmarks(&|i, _| format!("{} {}\n", i + 1, i + 10)))
        .with(
            "config.toml",
            "drift = [0.03, 0.01, 0.02]\nsighting = [0.05, 0.01]\nstart_sigmas = [0.1, 0.1, 0.1]\n",
        )
}

const LOGS: &str = "filter beacons odometry.dat seen.dat landmarks.dat barcodes.dat";

#[test]
fn a_lap_among_beacons_is_followed_written_and_drawn() {
    let folder = lap();
    let run = folder
        .boxplus(&format!("{LOGS} --config config.toml --truth truth.dat --json -o t.tum --plot t.svg"));
    assert_eq!(run.code, 0, "{}", run.stderr);
    let document = run.json();
    assert_eq!((&document["format"], &document["poses"]), (&"boxplus.filter".into(), &315.into()));
    assert_eq!(document["measurements"]["accepted"], 62);
    let score = |key: &str| document["score"][key].as_f64().unwrap();
    assert!(score("position") < 0.06 && score("rotation_deg") < 1.0, "{document}");
    assert!(score("inside_three_sigma") > 0.99 && score("nees") < 2.0);
    let trajectory = String::from_utf8(folder.read("t.tum")).unwrap();
    assert_eq!(trajectory.lines().count(), 315);
    assert!(trajectory.lines().all(|line| line.split(' ').count() == 8));
    assert!(String::from_utf8(folder.read("t.svg")).unwrap().contains("heading [°]"));
}

#[test]
fn the_past_told_again_is_nearer_the_truth() {
    let folder = lap();
    let error = |smooth: &str| {
        let run = folder.boxplus(&format!("{LOGS} --config config.toml --truth truth.dat --json {smooth}"));
        run.json()["score"]["position"].as_f64().unwrap()
    };
    assert!(error("--smooth") < error(""));
}

#[test]
fn an_inertial_sensor_is_carried_by_positions() {
    // Straight on at 2 m/s, level; a position a second.
    let mut imu = "Time dt accelX accelY accelZ omegaX omegaY omegaZ\n".to_owned();
    (0..=1000).for_each(|k| writeln!(imu, "{:.2} 0.01 0 0 9.80665 0 0 0", 0.01 * f64::from(k)).unwrap());
    let mut positions = "Time,X,Y,Z\n".to_owned();
    (0..=10)
        .for_each(|k| writeln!(positions, "{k},{},{},1", f64::from(k) * 1.2, f64::from(k) * 1.6).unwrap());
    let folder = Folder::new().with("imu.txt", imu).with("positions.txt", positions);
    let run = folder.boxplus("filter gnss imu.txt positions.txt --json");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let document = run.json();
    assert_eq!(document["score"], serde_json::Value::Null);
    let last = &document["last"]["position"];
    for (i, there) in [12.0, 16.0, 1.0].into_iter().enumerate() {
        assert!((last[i].as_f64().unwrap() - there).abs() < 1e-6, "{document}");
    }
    // The way to the second position is the heading.
    let half = (1.6_f64 / 1.2).atan() / 2.0;
    assert!((document["last"]["quaternion_xyzw"][2].as_f64().unwrap() - half.sin()).abs() < 1e-6);
}

#[test]
fn what_cannot_be_filtered_is_said_with_what_to_do() {
    let folder = lap()
        .with("typing.toml", "drift = [0.03, 0.01, 0.02]\nsigthing = [0.05, 0.01]\n")
        .with("negative.toml", "drift = [0.03, -0.01, 0.02]\n")
        .with("gate.toml", "gate = 2\n")
        .with("later.dat", "900.0 10 1.0 0.0\n901.0 11 1.0 0.0\n")
        .with("word.dat", "0.0 1.0 0.1\n0.1 fast 0.1\n");
    let refused = |arguments: &str, code: i32, words: &[&str]| {
        let run = folder.boxplus(arguments);
        assert_eq!(run.code, code, "{arguments}: {}", run.stderr);
        words
            .iter()
            .for_each(|word| assert!(run.stderr.contains(word), "{arguments}: {word} in {}", run.stderr));
    };
    refused("filter beacons odometry.dat seen.dat", 2, &["takes 4 files, and 2", "ODOMETRY MEASUREMENTS"]);
    refused(LOGS, 2, &["at first", "--truth"]);
    let truth = format!("{LOGS} --truth truth.dat");
    refused(&format!("{truth} --config typing.toml"), 3, &["typing.toml", "sigthing", "start_sigmas"]);
    refused(&format!("{truth} --config negative.toml"), 3, &["drift", "σ[1] = -0.01"]);
    refused(&format!("{truth} --config gate.toml"), 3, &["gate", "2"]);
    refused(&format!("{truth} --config absent.toml"), 3, &["cannot read absent.toml"]);
    refused(&truth.replace("odometry.dat", "word.dat"), 3, &["word.dat", "fast"]);
    refused(&format!("{truth} --plot t.jpg"), 2, &[".svg or .png"]);
    refused(&truth.replace("odometry.dat", "absent.dat"), 3, &["cannot read absent.dat"]);
    // Measurements of another time leave dead reckoning, and that is told.
    let run = folder.boxplus(&truth.replace("seen.dat", "later.dat"));
    assert!(run.code == 0 && run.stderr.contains("no measurement"), "{}", run.stderr);
}
