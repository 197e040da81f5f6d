//! Filters judged: verdicts, bands, pictures.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::Folder;

#[test]
fn the_recommended_filter_is_told_to_be_consistent() {
    let run = Folder::new().boxplus("consistency beacons --runs 60 --threads 2");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stdout.contains("can be believed") && run.stdout.contains("60 runs"), "{}", run.stdout);
}

#[test]
fn a_plain_filter_is_told_to_be_overconfident() {
    let run = Folder::new().boxplus("consistency beacons --filter extended --no-reset --runs 60 --json");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let document = run.json();
    let state = &document["series"][0];
    assert_eq!((state["name"].as_str(), state["verdict"].as_str()), (Some("state"), Some("overconfident")));
    assert!(state["mean"].as_f64().unwrap() > state["band"][1].as_f64().unwrap());
    assert_eq!(state["rmse"].as_array().unwrap().len(), document["coordinates"].as_array().unwrap().len());
    assert_eq!((document["runs"].as_u64(), document["refused"].as_u64()), (Some(60), Some(0)));
}

#[test]
fn the_number_of_threads_changes_no_digit() {
    let folder = Folder::new();
    let [one, three] = ["1", "3"].map(|threads| {
        folder.boxplus(&format!("consistency wheels --runs 9 --seed 4 --json --threads {threads}")).json()
    });
    assert_eq!(one["series"], three["series"]);
    let other = folder.boxplus("consistency wheels --runs 9 --seed 5 --json").json();
    assert_ne!(one["series"], other["series"]);
}

#[test]
fn a_picture_shows_the_band_of_every_series() {
    let folder = Folder::new();
    let run = folder.boxplus("consistency wheels --runs 20 --side global --plot nees.svg");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let svg = String::from_utf8(folder.read("nees.svg")).unwrap();
    assert!(
        svg.contains("NEES of the state") && svg.contains("NIS of position") && svg.contains("<path"),
        "{svg}"
    );
    assert_eq!(folder.boxplus("consistency wheels --runs 2 --plot nees.png").code, 0);
    assert_eq!(&folder.read("nees.png")[1..4], b"PNG");
}

#[test]
fn mistakes_are_named() {
    for (words, told) in [
        ("consistency nowhere", "beacons"),
        ("consistency wheels --runs 0", "runs"),
        ("consistency wheels --confidence 95", "between 0 and 1"),
        ("consistency wheels --plot nees.pdf", ".svg"),
    ] {
        let run = Folder::new().boxplus(words);
        assert!(run.code == 2 && run.stderr.contains(told), "{words}: {}", run.stderr);
    }
}
