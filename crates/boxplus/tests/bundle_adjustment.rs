//! Bundle adjustment on worlds whose truth is known, and on public problems.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test fails by panicking, and says what it skips"
)]

mod public_data;

use boxplus::bundle_adjustment::simulate::{Options, OptionsError, World};
use boxplus::bundle_adjustment::solve::solve;
use boxplus::bundle_adjustment::{
    Behind, Bundle, BundleError, Fault, Intrinsics, Line, Observation, Settings, Severity,
};
use boxplus::graph::Kernel;
use boxplus::io::{IoErrorKind, WriteError, bal, cloud};
use boxplus::lie::{Action, LieGroup, SO3, Sim3};
use flate2::{Compression, write::GzEncoder};
use nalgebra::{Vector3, vector};
use std::io::Write;

fn world(world: World, options: &Options) -> (Bundle, Bundle) {
    let simulated = world.simulate(options).unwrap();
    (simulated.bundle, simulated.truth)
}

fn small() -> Options {
    Options { views: 24, points: 600, ..Options::default() }
}

/// χ² of the truth is known: 2 an observation. The optimum has less by the unknowns, each of which takes one.
#[test]
fn residuals_at_the_optimum_are_the_noise_less_what_the_unknowns_take() {
    for kind in World::ALL {
        let (bundle, truth) = world(kind, &small());
        let solved = solve(&bundle, &Settings::default()).unwrap();
        assert!(solved.report.converged(), "{kind}: {:?}", solved.report.termination);
        let numbers = 2.0 * bundle.observations.len() as f64;
        let unknowns = f64::from(9 * 24 + 3 * 600 - 7);
        let (chi2, expected) = (2.0 * solved.cost / 0.25, numbers - unknowns); // σ = ½ pixel
        let spread = (2.0 * expected).sqrt();
        assert!((chi2 - expected).abs() < 4.0 * spread, "{kind}: χ² {chi2}, expected {expected} ± {spread}");
        assert!(
            solved.cost < truth.cost() && (solved.bundle.cost() / solved.cost - 1.0).abs() < 1e-9,
            "{kind}"
        );
    }
}

#[test]
fn without_noise_the_truth_is_found_but_for_the_gauge() {
    for intrinsics in [Intrinsics::Own, Intrinsics::Known] {
        let (mut bundle, truth) = world(World::Ring, &Options { sigma: 0.0, ..small() });
        for (view, known) in bundle.views.iter_mut().zip(&truth.views) {
            view.camera = known.camera;
        }
        bundle.views[0] = truth.views[0];
        let solved = solve(&bundle, &Settings { intrinsics, ..Settings::default() }).unwrap();
        assert!(solved.cost < 1e-9, "{intrinsics:?}: {}", solved.cost);
        // The scale is that of the start; the rest is exact.
        let place = |bundle: &Bundle, i: usize| bundle.views[i].world_from_camera.translation();
        let scale = (place(&solved.bundle, 12) - place(&truth, 0)).norm()
            / (place(&truth, 12) - place(&truth, 0)).norm();
        for (found, p) in solved.bundle.points.iter().zip(&truth.points) {
            let expected = place(&truth, 0) + (p - place(&truth, 0)) * scale;
            assert!((found - expected).norm() < 1e-4, "{intrinsics:?}: {found} {expected}");
        }
    }
}

#[test]
fn shared_intrinsics_are_one_camera() {
    let (mut bundle, _) = world(World::Street, &small());
    let camera = bundle.views[0].camera;
    let shared = boxplus::camera::Snavely { focal: 810.0, distortion: [-0.05, 0.01] };
    for o in &mut bundle.observations {
        // What the shared camera would have seen: each pixel carried over along its ray.
        let view = bundle.views[o.view as usize];
        let ray = boxplus::camera::Camera::unproject(&view.camera, &o.pixel).unwrap();
        o.pixel = boxplus::camera::Camera::image(&shared, &ray);
    }
    bundle.views.iter_mut().for_each(|view| view.camera = camera);
    let solved = solve(&bundle, &Settings { intrinsics: Intrinsics::Shared, ..Settings::default() }).unwrap();
    assert!(solved.bundle.views.iter().all(|view| view.camera == solved.bundle.views[7].camera));
    assert!(solved.cost < solved.initial_cost && solved.report.unknowns <= 6 * 23 + 3 + 3 * 600);
}

#[test]
fn the_result_stands_where_the_start_stood_and_images_do_not_move_with_the_world() {
    let (bundle, _) = world(World::Ring, &small());
    let solved = solve(&bundle, &Settings::default()).unwrap();
    assert_eq!((solved.gauge.free, solved.gauge.anchors.len()), (7, 1));
    let anchor = solved.gauge.anchors[0];
    let place = |bundle: &Bundle, i: usize| bundle.views[i].world_from_camera.translation();
    let size = |b: &Bundle| (place(b, anchor.scale.unwrap()) - place(b, 0)).norm();
    assert_eq!(solved.bundle.views[0].world_from_camera, bundle.views[0].world_from_camera);
    assert!((size(&solved.bundle) / size(&bundle) - 1.0).abs() < 1e-12);

    // The whole world moved, turned and scaled: the same optimum, moved.
    let similarity = Sim3::exp(&vector![10.0, -20.0, 5.0, 0.3, -0.2, 0.4, 0.7]);
    let turn = SO3::project(&similarity.linear_part()).unwrap();
    let mut moved = bundle.clone();
    moved.points.iter_mut().for_each(|p| *p = similarity.act(p));
    for view in &mut moved.views {
        let pose = view.world_from_camera;
        view.world_from_camera =
            boxplus::lie::SE3::new(turn * pose.rotation(), similarity.act(&pose.translation()));
    }
    assert!((moved.cost() / bundle.cost() - 1.0).abs() < 1e-9);
    let again = solve(&moved, &Settings::default()).unwrap();
    assert!((again.cost / solved.cost - 1.0).abs() < 1e-6);
}

#[test]
fn held_views_stay_and_leave_only_the_scale_or_nothing() {
    let (bundle, _) = world(World::Street, &small());
    let free = |fixed: &[usize]| {
        let solved = solve(&bundle, &Settings { fixed: fixed.to_vec(), ..Settings::default() }).unwrap();
        assert!(fixed.iter().all(|&i| solved.bundle.views[i] == bundle.views[i]), "{fixed:?}");
        solved.gauge.free
    };
    assert_eq!((free(&[3]), free(&[3, 9])), (1, 0));
    let missing = solve(&bundle, &Settings { fixed: vec![24], ..Settings::default() });
    assert_eq!(missing.unwrap_err(), BundleError::NoSuchView { view: 24, views: 24 });
}

#[test]
fn a_robust_kernel_finds_the_truth_among_outliers() {
    let options = Options { outliers: 0.05, ..small() };
    let (bundle, truth) = world(World::Ring, &options);
    let settings = Settings { kernel: Kernel::Cauchy(1.0), ..Settings::default() };
    let solved = solve(&bundle, &settings).unwrap();
    let good = |bundle: &Bundle| {
        let true_residuals = truth.observations.iter().map(|o| truth.residual(o).unwrap().norm());
        let own = bundle.observations.iter().map(|o| bundle.residual(o).unwrap().norm());
        let pairs: Vec<f64> = true_residuals.zip(own).filter(|(t, _)| *t < 3.0).map(|(_, r)| r * r).collect();
        (pairs.iter().sum::<f64>() / pairs.len() as f64).sqrt()
    };
    let plain = solve(&bundle, &Settings::default()).unwrap();
    assert!(
        good(&solved.bundle) < 1.0 && good(&plain.bundle) > 3.0,
        "{} {}",
        good(&solved.bundle),
        good(&plain.bundle)
    );
}

#[test]
fn every_fault_is_found_counted_and_told() {
    let (mut bundle, _) = world(World::Ring, &Options { views: 6, points: 40, ..Options::default() });
    assert!(bundle.faults().is_empty(), "{:?}", bundle.faults());
    let seen = |view, point, line| Observation { view, point, pixel: vector![1.0, 2.0], line: Line(line) };
    let again = bundle.observations[0];
    bundle.observations.extend([seen(6, 0, 7), seen(0, 90, 8), seen(9, 1, 9), again]);
    bundle.observations.push(Observation { pixel: vector![f64::NAN, 0.0], ..seen(1, 1, 10) });
    bundle.points.extend([Vector3::zeros(), vector![f64::INFINITY, 0.0, 0.0]]);
    bundle.observations.push(seen(2, 40, 11));
    bundle.views.push(bundle.views[0]);
    bundle.views[6].camera.focal = f64::NAN;
    let faults = bundle.faults();
    let has =
        |wanted: &str| assert!(faults.iter().any(|f| f.to_string().contains(wanted)), "{wanted}: {faults:?}");
    has("1 observation(s) are by views that do not exist, the first by view 9");
    has("1 observation(s) are of points that do not exist, the first of point 90");
    has("1 observation(s) hold a number that is not finite, the first of point 1 by view 1");
    has("1 view(s) hold a number that is not finite, the first is 6");
    has("1 point(s) hold a number that is not finite, the first is 41");
    has("of a point that the view has seen before");
    has("1 point(s) are seen by one view only");
    has("1 point(s) are seen by no view");
    let refused = solve(&bundle, &Settings::default()).unwrap_err();
    let BundleError::Faulty { faults } = refused else { panic!("{refused}") };
    assert!(faults.iter().all(|fault| fault.severity() == Severity::Error) && faults.len() == 5);
}

#[test]
fn points_behind_cameras_are_counted_and_left_out_only_if_asked() {
    let (mut bundle, _) = world(World::Street, &small());
    let (view, observation) = (bundle.views[0], bundle.observations[0]);
    let behind = view.world_from_camera.act(&vector![0.1, 0.1, 5.0]);
    bundle.points.push(behind);
    bundle.observations.push(Observation { point: 600, view: 0, ..observation });
    let fault = bundle.faults().into_iter().find(|f| matches!(f, Fault::Unseen { .. })).unwrap();
    assert!(matches!(fault, Fault::Unseen { count: 1, behind: 1, view: 0, point: 600, .. }));
    let all = bundle.observations.len();
    let kept = solve(&bundle, &Settings::default()).unwrap();
    assert_eq!((kept.unseen_before, kept.used), (1, all));
    let left = solve(&bundle, &Settings { behind: Behind::LeaveOut, ..Settings::default() }).unwrap();
    assert_eq!((left.used, left.squared.len()), (all - 1, all));
}

#[test]
fn options_out_of_range_are_refused() {
    let refused = |options: Options| World::City.simulate(&options).unwrap_err();
    assert!(matches!(refused(Options { views: 1, ..small() }), OptionsError::TooFew { option: "views", .. }));
    assert!(matches!(
        refused(Options { outliers: 1.5, ..small() }),
        OptionsError::OutOfRange { option: "outliers", .. }
    ));
    assert!(matches!(
        refused(Options { sigma: f64::NAN, ..small() }),
        OptionsError::OutOfRange { option: "sigma", .. }
    ));
    assert_eq!(World::City.simulate(&small()), World::City.simulate(&small()));
}

#[test]
fn what_is_written_reads_back_plain_and_packed() {
    let (_, truth) = world(World::City, &small());
    let text = bal::write(&truth).unwrap();
    assert!(bal::looks_like(text.as_bytes()));
    let mut gzip = GzEncoder::new(vec![], Compression::fast());
    gzip.write_all(text.as_bytes()).unwrap();
    let gzip = gzip.finish().unwrap();
    for bytes in [text.as_bytes(), &gzip] {
        let read = bal::read(bytes, "city.bal").unwrap();
        assert_eq!((&read.points, &read.observations), (&truth.points, &truth.observations));
        for (a, b) in read.views.iter().zip(&truth.views) {
            let apart = a.world_from_camera.between(&b.world_from_camera).log().norm();
            assert!(apart < 1e-12 && a.camera == b.camera, "{apart:e}"); // places of 100 m, a few ulps each way
        }
    }
    let mut broken = truth.clone();
    broken.points[3].x = f64::NAN;
    assert_eq!(bal::write(&broken), Err(WriteError::NotFinite { tag: "point", id: 3 }));
}

#[test]
fn malformed_files_are_refused_with_the_line() {
    let good = "1 1 1\n0 0 1 2\n0 0 0 0 0 -2 500 0 0\n0 0 -3\n";
    assert!(bal::read(good.as_bytes(), "good").is_ok());
    let told = |text: &str| bal::read(text.as_bytes(), "f").unwrap_err().to_string();
    assert_eq!(told("1 1\n"), "f: the file ends where its header promises the number of observations");
    assert_eq!(told("1 1 x\n"), "f:1:5: `x` is not a number; expected the number of observations");
    assert_eq!(
        told("1 1 1\n1 0 1 2\n"),
        "f:2:1: there is no camera 1: the header promises 1, counted from 0"
    );
    assert_eq!(told("1 1 1\n0 0 1 nan\n"), "f:2:7: `nan` is not a finite number; expected v");
    assert_eq!(told(&good[..good.len() - 4]), "f: the file ends where its header promises z");
    assert_eq!(told(&format!("{good}7\n")), "f:5:1: the line goes on after its last field, with `7`");
    assert_eq!(told("1 1 99999999999\n0 0 1 2\n"), "f: the file ends where its header promises camera");
    let cut = bal::read(b"BZh91AY&SY\x01\x02", "cut.bz2").unwrap_err();
    assert!(matches!(cut.kind, IoErrorKind::Bzip2Truncated | IoErrorKind::Bzip2Corrupt), "{cut}");
    assert!(!bal::looks_like(b"VERTEX_SE2 0 0 0 0\n") && !bal::looks_like(b"1 2 3\n4 5 6\n"));
}

/// A point lands on its pixel by COLMAP's own formula, and PLY reads back.
#[test]
fn reconstructions_for_other_programs_say_the_same() {
    let (_, truth) = world(World::Ring, &Options { sigma: 0.0, ..small() });
    let ply = cloud::read(&bal::write_ply(&truth).unwrap(), "ring.ply", None).unwrap();
    assert_eq!(ply.points[..600], truth.points[..]);
    assert_eq!(ply.points.len(), 600 + 24);

    let files = bal::colmap(&truth).unwrap();
    let rows = |text: &str| -> Vec<Vec<String>> {
        let lines = text.lines().filter(|line| !line.starts_with('#'));
        lines.map(|line| line.split(' ').map(str::to_owned).collect()).collect()
    };
    let (cameras, images, points) = (rows(&files.cameras), rows(&files.images), rows(&files.points));
    let number = |word: &String| word.parse::<f64>().unwrap();
    let find = |id: &str| points.iter().find(|row| row[0] == id).unwrap();
    for pair in images.chunks(2) {
        let head: Vec<f64> = pair[0][..8].iter().map(number).collect();
        let rotation = SO3::from_xyzw([head[2], head[3], head[4], head[1]]).unwrap();
        let camera: Vec<f64> =
            cameras[pair[0][8].parse::<usize>().unwrap() - 1][2..].iter().map(number).collect();
        for (place, seen) in pair[1].chunks(3).enumerate() {
            let row = find(&seen[2]);
            let p = rotation.act(&vector![number(&row[1]), number(&row[2]), number(&row[3])])
                + vector![head[5], head[6], head[7]];
            let (a, b) = (p.x / p.z, p.y / p.z);
            let (t, [f, cx, cy, k1, k2]) =
                (a * a + b * b, [camera[2], camera[3], camera[4], camera[5], camera[6]]);
            let g = f * (1.0 + k1 * t + k2 * t * t);
            assert!(
                (g * a + cx - number(&seen[0])).abs() < 1e-6 && (g * b + cy - number(&seen[1])).abs() < 1e-6
            );
            let track = [pair[0][0].clone(), place.to_string()];
            assert!(
                row[8..].chunks(2).any(|entry| *entry == track),
                "{track:?} is not in the track of {}",
                seen[2]
            );
        }
    }
}

/// Costs of `bundle-adjustment/` as its README states them.
#[test]
fn public_problems_reach_the_best_known_cost() {
    for (name, start, best) in [
        ("bal-ladybug-49-7776-pre.txt", 850912.4607, 13344.27),
        ("bal-trafalgar-21-11315-pre.txt", 4413239.3144, 30378.64),
    ] {
        let Some(bytes) = public_data::bytes(&format!("bundle-adjustment/{name}")) else { return };
        let bundle = bal::read(&bytes, name).unwrap();
        assert!((bundle.cost() / start - 1.0).abs() < 1e-9, "{name} starts at {}", bundle.cost());
        let solved = solve(&bundle, &Settings::default()).unwrap();
        assert!(solved.report.converged() && solved.cost <= best * (1.0 + 1e-6), "{name}: {}", solved.cost);
        assert!((solved.bundle.cost() / solved.cost - 1.0).abs() < 1e-9);
    }
}
