//! `boxplus solve` of bundles: streams, files, exit codes, refusals.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use boxplus::bundle_adjustment::simulate::{Options, World};
use boxplus::io::{bal, cloud};
use common::Folder;

/// A ring of views as a file of BAL.
fn ring() -> Folder {
    let options = Options { views: 8, points: 200, ..Options::default() };
    let world = World::Ring.simulate(&options).unwrap();
    Folder::new().with("ring.txt", bal::write(&world.bundle).unwrap())
}

#[test]
fn a_bundle_is_known_by_its_content_and_told_on_one_screen() {
    let run = ring().boxplus("solve ring.txt --threads 1");
    assert_eq!(run.code, 0, "{}", run.stderr);
    for word in ["8 views", "200 points", "cost", "rms", "stopped", "view 0 stays", "7 directions", "worst"] {
        assert!(run.stdout.contains(word), "{word} is missing: {}", run.stdout);
    }
    assert_eq!(run.stderr, "");
}

#[test]
fn results_are_written_in_every_format_and_named_in_the_document() {
    let folder = ring();
    let run = folder.boxplus("solve ring.txt --json -o adjusted.bal.gz --plot ring.svg --robust huber:2");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let document = run.json();
    assert_eq!(
        (document["format"].as_str(), document["gauge"]["free"].as_u64()),
        (Some("boxplus.bundle"), Some(7))
    );
    assert!(document["rms"].as_f64() < document["initial_rms"].as_f64());
    assert_eq!(document["outputs"].as_array().unwrap().len(), 2);
    let adjusted = bal::read(&folder.read("adjusted.bal.gz"), "adjusted").unwrap();
    assert_eq!((adjusted.views.len(), adjusted.points.len()), (8, 200));
    assert!(String::from_utf8(folder.read("ring.svg")).unwrap().contains("camera"));

    assert_eq!(folder.boxplus("solve ring.txt -q -o adjusted.ply --intrinsics known").code, 0);
    assert_eq!(cloud::read(&folder.read("adjusted.ply"), "ply", None).unwrap().points.len(), 208);
    assert_eq!(folder.boxplus("solve demo:street --size 12 -q -o model").code, 0);
    for name in ["cameras.txt", "images.txt", "points3D.txt"] {
        assert!(!folder.read(&format!("model/{name}")).is_empty());
    }
}

#[test]
fn what_makes_no_sense_is_refused_with_the_reason() {
    let folder = ring().with("bad.txt", "1 1 1\n0 5 1 2\n0 0 0 0 0 0 1 0 0\n0 0 -1\n");
    let refused = |arguments: &str, code: i32, reason: &str| {
        let run = folder.boxplus(arguments);
        assert_eq!(run.code, code, "{arguments}: {}", run.stderr);
        assert!(run.stderr.contains(reason), "{arguments}: {}", run.stderr);
    };
    refused("solve bad.txt", 3, "there is no point 5");
    refused("solve ring.txt --certify", 2, "--certify is for pose graphs");
    refused("solve ring.txt -o out.g2o", 2, "does not tell the format");
    refused("solve ring.txt --fix 8", 2, "view 8 is to be held");
    refused("info ring.txt", 2, "holds cameras and points");
    refused("solve demo:sphere --size 50 --behind keep", 2, "for bundles");
    refused("solve demo:nowhere", 2, "demo:ring");
}
