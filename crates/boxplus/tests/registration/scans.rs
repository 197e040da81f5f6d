//! Scans matched by nearest neighbours: the truth is found, threads change no bit, what is free is named.

use super::support::{Draw, mean_and_error};
use boxplus::lie::{LieGroup, SE2, SE3, SO3};
use boxplus::registration::{
    Icp, Kernel, Method, Preparation, Registered, RegistrationError, Role, Scan, Termination, thinned,
};
use nalgebra::{Vector2, Vector3, vector};

/// Points on the walls, floor and a pillar of a room of 8 × 6 × 3 m, seen from somewhere in it, with noise along each axis.
fn room(draw: &mut Draw, n: usize, noise: f64) -> Vec<Vector3<f64>> {
    let point = |draw: &mut Draw| {
        let (u, v) = (draw.between(0.0, 1.0), draw.between(0.0, 1.0));
        match draw.below(6) {
            0 => vector![8.0 * u, 0.0, 3.0 * v],
            1 => vector![8.0 * u, 6.0, 3.0 * v],
            2 => vector![0.0, 6.0 * u, 3.0 * v],
            3 => vector![8.0, 6.0 * u, 3.0 * v],
            4 => vector![8.0 * u, 6.0 * v, 0.0],
            _ => {
                let (s, c) = (std::f64::consts::TAU * u).sin_cos();
                vector![5.0 + 0.5 * c, 2.0 + 0.5 * s, 3.0 * v]
            }
        }
    };
    (0..n).map(|_| point(draw) - vector![3.0, 2.5, 1.2] + draw.normals::<3>() * noise).collect()
}

fn scan<const N: usize>(cloud: &[nalgebra::SVector<f64, N>]) -> Scan<N> {
    Scan::new(cloud, &Preparation::default()).unwrap()
}

fn with(method: Method) -> Icp {
    Icp { method, ..Icp::default() }
}

fn truth() -> SE3 {
    SE3::new(SO3::exp(&vector![0.02, -0.03, 0.08]), vector![0.2, -0.15, 0.05])
}

#[test]
fn the_same_points_are_laid_upon_each_other_exactly() {
    let mut draw = Draw::new(1);
    let target = room(&mut draw, 4000, 0.0);
    let source: Vec<_> = target.iter().map(|q| truth().inverse() * *q).collect();
    let (source, target) = (scan(&source), scan(&target));
    for method in Method::ALL {
        let found = source.align(&target, &SE3::identity(), &with(method)).unwrap();
        let error = found.target_from_source.rminus(&truth()).norm();
        assert!(error < 1e-9, "{method:?}: {error:e} after {} steps", found.iterations);
        assert_eq!((found.matches, found.termination), (4000, Termination::Converged));
        assert!(found.free.is_empty() && found.rmse < 1e-9 && found.fitness() == 1.0);
    }
}

#[test]
fn a_scan_laid_upon_itself_is_known_to_rounding() {
    let mut draw = Draw::new(12);
    let room = scan(&room(&mut draw, 2000, 0.0));
    for method in Method::ALL {
        let found: Registered<SE3, 6> = room.align(&room, &SE3::identity(), &with(method)).unwrap();
        assert!(found.rmse == 0.0 && found.sigma > 0.0 && found.information.iter().all(|x| x.is_finite()));
        let sigmas = found.pose().unwrap().sigmas();
        assert!(sigmas.min() > 0.0 && sigmas.max() < 1e-15, "{method:?}: {sigmas}");
    }
}

#[test]
fn points_on_a_line_turn_freely_about_it() {
    let mut draw = Draw::new(13);
    let line: Vec<_> = (0..500).map(|_| vector![2.0, draw.between(-9.0, 9.0), -1.0]).collect();
    let start = SE3::new(SO3::identity(), vector![0.1, 0.1, 0.1]);
    for method in [Method::PointToPoint, Method::Generalised] {
        let found = scan(&line).align(&scan(&line), &start, &with(method)).unwrap();
        let names: Vec<_> = found.free.iter().map(ToString::to_string).collect();
        assert_eq!(names, ["rotation about (0.00, 1.00, 0.00)"], "{method:?}");
        assert_eq!((found.free[0].share, found.matches), (0.0, 500));
        assert_eq!(found.pose().unwrap_err(), RegistrationError::Unconstrained { directions: 1 });
    }
}

#[test]
fn different_points_of_one_room_meet_within_their_noise() {
    let mut draw = Draw::new(2);
    let target = scan(&room(&mut draw, 6000, 0.01));
    let inverse = truth().inverse();
    let source: Vec<_> = room(&mut draw, 5000, 0.01).iter().map(|q| inverse * *q).collect();
    let source = scan(&source);
    // A coordinate is known to 5e-4, if matches were independent; √(6·3.5) of that is usual, twice as much may be.
    for (method, bound) in
        [(Method::PointToPoint, 0.02), (Method::PointToPlane, 5e-3), (Method::Generalised, 5e-3)]
    {
        let found = source.align(&target, &SE3::identity(), &with(method)).unwrap();
        let error = found.target_from_source.rminus(&truth()).norm();
        println!("{method:?}: {error:.1e}, {} steps, σ {:.4}", found.iterations, found.sigma);
        assert!(error < bound, "{method:?}: {error:e}");
        assert_eq!(found.termination, Termination::Converged);
    }
}

#[test]
fn threads_change_no_bit() {
    let mut draw = Draw::new(3);
    let (target, source) = (room(&mut draw, 3000, 0.01), room(&mut draw, 2500, 0.01));
    let run = |threads: usize, method| {
        let preparation = Preparation { voxel: 0.1, threads, ..Preparation::default() };
        let [source, target] = [&source, &target].map(|cloud| Scan::new(cloud, &preparation).unwrap());
        let options = Icp { threads, kernel: Kernel::Cauchy(2.0), ..with(method) };
        source.align(&target, &truth(), &options).unwrap()
    };
    for method in Method::ALL {
        let one: Registered<SE3, 6> = run(1, method);
        for threads in [0, 2, 3, 7] {
            assert_eq!(run(threads, method), one);
        }
    }
}

#[test]
fn a_corridor_is_free_along_itself_and_keeps_the_start_there() {
    let mut draw = Draw::new(4);
    let wall = |draw: &mut Draw| {
        let (x, v) = (draw.between(-20.0, 20.0), draw.between(0.0, 1.0));
        match draw.below(4) {
            0 => vector![x, -1.0, 3.0 * v],
            1 => vector![x, 1.0, 3.0 * v],
            2 => vector![x, 2.0 * v - 1.0, 0.0],
            _ => vector![x, 2.0 * v - 1.0, 3.0],
        }
    };
    let cloud = |draw: &mut Draw| -> Vec<Vector3<f64>> {
        (0..5000).map(|_| wall(draw) + draw.normals::<3>() * 0.005).collect()
    };
    let (target, source) = (scan(&cloud(&mut draw)), scan(&cloud(&mut draw)));
    let start = SE3::new(SO3::exp(&vector![0.02, 0.0, 0.01]), vector![0.7, 0.1, 0.1]);
    for method in Method::ALL {
        let found = source.align(&target, &start, &with(method)).unwrap();
        let names: Vec<_> = found.free.iter().map(ToString::to_string).collect();
        assert_eq!(names, ["translation along (1.00, 0.00, 0.00)"], "{method:?}");
        assert_eq!(found.pose().unwrap_err(), RegistrationError::Unconstrained { directions: 1 });
        let error = found.target_from_source.log();
        assert!((error[0] - 0.7).abs() < 0.02, "{method:?} slid: {error}");
        if method != Method::PointToPoint {
            // Corners are rounded off by the width of a neighbourhood, 0.3 m of 2 m.
            assert!(error.rows(1, 5).amax() < 0.01, "{method:?}: {error}");
        }
        // Nothing is known along it, something about every other direction.
        let along = found.free[0].tangent;
        assert!((found.information * along).norm() < 1e-9 * found.information.norm());
    }
}

#[test]
fn a_floor_leaves_three_directions_free() {
    let mut draw = Draw::new(5);
    let floor: Vec<_> = (0..3000)
        .map(|_| vector![draw.between(-9.0, 9.0), draw.between(-9.0, 9.0), 0.003 * draw.normal()])
        .collect();
    let found = scan(&floor).align(&scan(&floor[..2000]), &SE3::identity(), &Icp::default()).unwrap();
    let mut names: Vec<_> = found.free.iter().map(ToString::to_string).collect();
    names.sort();
    let axes = ["translation along (0.00, 1.00, 0.00)", "translation along (1.00, 0.00, 0.00)"];
    assert_eq!(names, ["rotation about (0.00, 0.00, 1.00)", axes[0], axes[1]]);
}

#[test]
fn a_robust_kernel_forgets_what_has_moved() {
    let mut draw = Draw::new(6);
    let target = room(&mut draw, 5000, 0.005);
    let inverse = truth().inverse();
    let mut source: Vec<_> = room(&mut draw, 5000, 0.005).iter().map(|q| inverse * *q).collect();
    // A fifth of the room: somebody has shifted the furniture by 40 cm.
    source.iter_mut().take(1000).for_each(|p| *p += vector![0.3, 0.25, 0.0]);
    let (source, target) = (scan(&source), scan(&target));
    let error = |kernel| {
        let options = Icp { kernel, ..with(Method::PointToPlane) };
        source.align(&target, &SE3::identity(), &options).unwrap().target_from_source.rminus(&truth()).norm()
    };
    let (plain, robust) = (error(Kernel::None), error(Kernel::GemanMcClure(2.0)));
    println!("{plain:.1e} without, {robust:.1e} with a kernel");
    assert!(robust < 3e-3 && plain > 5.0 * robust, "{plain:e} {robust:e}");
}

/// The mean NEES of runs over six degrees of freedom.
fn nees(method: Method, runs: u64) -> (f64, f64) {
    let scores: Vec<f64> = (0..runs)
        .map(|seed| {
            let mut draw = Draw::new(1000 + seed);
            let target = scan(&room(&mut draw, 3000, 0.01));
            let inverse = truth().inverse();
            let source: Vec<_> = room(&mut draw, 3000, 0.01).iter().map(|q| inverse * *q).collect();
            let options = Icp { max_distance: 0.5, ..with(method) };
            let found = scan(&source).align(&target, &truth(), &options).unwrap();
            found.pose().unwrap().mahalanobis_squared(&truth()).unwrap() / 6.0
        })
        .collect();
    mean_and_error(&scores)
}

#[test]
fn the_covariance_of_matched_scans_is_as_wrong_as_documented() {
    // What the doc of `Registered::pose` says.
    for (method, documented) in
        [(Method::PointToPoint, 20.0), (Method::PointToPlane, 3.5), (Method::Generalised, 2.0)]
    {
        let (ratio, error) = nees(method, 40);
        println!("{method:?}: NEES/6 {ratio:.2} ± {error:.2}");
        assert!((ratio - documented).abs() < 4.0 * error, "{method:?}: {ratio} ± {error}");
    }
}

#[test]
fn clouds_of_the_plane_are_aligned_in_se2() {
    let mut draw = Draw::new(7);
    let outline = |draw: &mut Draw| {
        let u = draw.between(0.0, 10.0);
        let p = if u < 5.0 { vector![u, 0.0] } else { vector![5.0, 0.6 * (u - 5.0)] };
        p + draw.normals::<2>() * 0.005
    };
    let cloud = |draw: &mut Draw| -> Vec<Vector2<f64>> { (0..800).map(|_| outline(draw)).collect() };
    let truth = SE2::new(vector![0.1, -0.2], 0.06);
    let target = scan(&cloud(&mut draw));
    let source: Vec<_> = cloud(&mut draw).iter().map(|q| truth.inverse() * *q).collect();
    for method in [Method::PointToPlane, Method::Generalised] {
        let found = scan(&source).align(&target, &SE2::identity(), &with(method)).unwrap();
        assert!(found.target_from_source.rminus(&truth).norm() < 2e-3, "{method:?}");
        assert!(found.free.is_empty() && found.pose().is_ok());
    }
    let straight: Vec<_> = (0..500).map(|i| vector![0.01 * f64::from(i), 0.0]).collect();
    let found = scan(&straight).align(&scan(&straight), &SE2::identity(), &Icp::default()).unwrap();
    assert_eq!(found.free[0].to_string(), "translation along (1.00, 0.00)");
}

#[test]
fn where_the_world_begins_does_not_matter() {
    let mut draw = Draw::new(8);
    let (target, source) = (room(&mut draw, 3000, 0.01), room(&mut draw, 3000, 0.01));
    let found = scan(&source).align(&scan(&target), &truth(), &Icp::default()).unwrap();
    let origin = vector![4.5e4, -5.4e4, 300.0];
    let far = |cloud: &[Vector3<f64>]| -> Vec<_> { cloud.iter().map(|p| p + origin).collect() };
    let shift = SE3::new(SO3::identity(), origin);
    let start = shift * truth() * shift.inverse();
    let there = scan(&far(&source)).align(&scan(&far(&target)), &start, &Icp::default()).unwrap();
    let back = shift.inverse() * there.target_from_source * shift;
    // ε·5.4e4 ≈ 1.2e-11 m per point.
    assert!(back.rminus(&found.target_from_source).norm() < 1e-9);
    let sigmas = there.pose().unwrap().change_body(&shift).sigmas();
    assert!((sigmas - found.pose().unwrap().sigmas()).amax() < 1e-4 * sigmas.amax(), "{sigmas}");
}

#[test]
fn thinning_keeps_the_mean_of_every_cube_wherever_the_cloud_is() {
    let mut draw = Draw::new(9);
    let cloud = room(&mut draw, 2000, 0.0);
    let thin = thinned(&cloud, 0.5).unwrap();
    assert!(thin.len() < 1000 && thin.len() > 300, "{}", thin.len());
    for p in &thin {
        assert!(cloud.iter().any(|q| (p - q).amax() <= 0.5));
    }
    let moved: Vec<_> = cloud.iter().map(|p| p + vector![1024.0, -2048.0, 512.0]).collect();
    let there = thinned(&moved, 0.5).unwrap();
    assert_eq!(there.len(), thin.len());
    assert!(thin.iter().zip(&there).all(|(p, q)| (q - vector![1024.0, -2048.0, 512.0] - p).amax() < 1e-12));
    assert!(thinned::<3>(&[], 1.0).unwrap().is_empty());
    let numbers = [0.0, 0.1, 5.0].map(nalgebra::Vector1::new);
    assert_eq!(thinned(&numbers, 1.0).unwrap(), [nalgebra::Vector1::new(0.05), numbers[2]]);
    for size in [0.0, -1.0, f64::NAN, 1e-9] {
        assert!(matches!(thinned(&cloud, size), Err(RegistrationError::VoxelSize { .. })), "{size}");
    }
}

#[test]
fn what_cannot_be_aligned_is_refused_with_the_reason() {
    let mut draw = Draw::new(10);
    let cloud = room(&mut draw, 500, 0.01);
    let good = scan(&cloud);
    let aligned =
        |options: Icp| good.align(&good, &SE3::identity(), &options).map(|_: Registered<SE3, 6>| ());
    for max_distance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = aligned(Icp { max_distance, ..Icp::default() }).unwrap_err();
        assert!(matches!(error, RegistrationError::NotAnOption { option: "max_distance", .. }), "{error}");
    }
    let error = aligned(Icp { least_share: f64::NAN, ..Icp::default() }).unwrap_err();
    assert!(matches!(error, RegistrationError::NotAnOption { option: "least_share", .. }), "{error}");
    let error = aligned(Icp { kernel: Kernel::Huber(f64::NAN), ..Icp::default() }).unwrap_err();
    assert_eq!(error, RegistrationError::NotAKernel);
    let bare = Scan::new(&cloud, &Preparation { neighbours: 0, ..Preparation::default() }).unwrap();
    let error = good.align(&bare, &SE3::identity(), &Icp::default()).unwrap_err();
    assert_eq!(error, RegistrationError::NoNormals { role: Role::Target });
    let error = bare.align(&good, &SE3::identity(), &Icp::default()).unwrap_err();
    assert_eq!(error, RegistrationError::NoNormals { role: Role::Source });
    assert!(bare.align(&bare, &SE3::identity(), &with(Method::PointToPoint)).is_ok());
    let away = SE3::new(SO3::identity(), vector![100.0, 0.0, 0.0]);
    let error = good.align(&good, &away, &Icp::default()).unwrap_err();
    assert_eq!(error, RegistrationError::NoOverlap { matches: 0, needed: 7, max_distance: 1.0 });
    let nowhere = SE3::new(SO3::identity(), vector![f64::NAN, 0.0, 0.0]);
    let error = good.align(&good, &nowhere, &Icp::default()).unwrap_err();
    assert_eq!(error, RegistrationError::InitialNotFinite);
    let none: [Vector3<f64>; 0] = [];
    assert_eq!(Scan::new(&none, &Preparation::default()).unwrap_err(), RegistrationError::Empty);
    let error = Scan::new(&[vector![0.0, f64::NAN]], &Preparation::default()).unwrap_err();
    assert_eq!(error, RegistrationError::NotFinite { role: Role::Cloud, index: 0 });
}

#[test]
fn clouds_of_one_place_one_line_and_many_doubles_do_no_harm() {
    let mut draw = Draw::new(11);
    let place = vec![vector![1.0, 2.0, 3.0]; 700];
    let line: Vec<_> = (0..700).map(|i| vector![f64::from(i % 100), 0.0, 0.0]).collect();
    let doubled: Vec<_> = room(&mut draw, 100, 0.0).into_iter().flat_map(|p| [p; 40]).collect();
    for cloud in [place, line, doubled] {
        let scan = scan(&cloud);
        for method in Method::ALL {
            let start = SE3::new(SO3::identity(), vector![0.1, 0.1, 0.1]);
            match scan.align(&scan, &start, &with(method)) {
                Ok(found) => assert!(found.target_from_source.log().iter().all(|x| x.is_finite())),
                Err(error) => assert!(matches!(error, RegistrationError::NoOverlap { .. }), "{error}"),
            }
        }
    }
}
