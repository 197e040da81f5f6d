//! The closed form: best, exact, honest about its covariance, and refused where points leave a rotation open.

use super::support::{Draw, angle_between, mean_and_error};
use boxplus::lie::{LieGroup, SE2, SE3, SO3, Sim2, Sim3};
use boxplus::registration::{Alignable, Noise, Pairs, RegistrationError, Role};
use boxplus::uncertainty::Covariance;
use nalgebra::{SMatrix, SVector, Vector2, Vector3, vector};

/// Points of a flat, off-centre cloud, which makes translation and rotation correlate.
fn cloud<const N: usize>(draw: &mut Draw, n: usize) -> Vec<SVector<f64, N>> {
    let point = |draw: &mut Draw| SVector::from_fn(|i, _| 3.0 + draw.normal() * [2.0, 1.0, 0.3][i]);
    (0..n).map(|_| point(draw)).collect()
}

/// A factor of the noise of a target point that differs from axis to axis.
fn shape<const N: usize>() -> SMatrix<f64, N, N> {
    SMatrix::from_fn(
        |i, j| if i == j { 0.01 * (1.0 + 2.0 * i as f64) } else { 0.004 * (i as f64 - j as f64) },
    )
}

fn truth_is_found<G: Alignable<D, N>, const D: usize, const N: usize>() {
    let mut draw = Draw::new(1);
    for n in [N, N + 1, 50] {
        for _ in 0..200 {
            let truth: G = draw.element(1.0);
            let source = cloud::<N>(&mut draw, n);
            let target: Vec<_> = source.iter().map(|p| truth.act(p)).collect();
            let fit = Pairs::new(&source, &target).unwrap().align::<G, D>().unwrap();
            // The worst triangles have an aspect of 1e-3, whose square divides ε·10.
            let error = fit.target_from_source.rminus(&truth).amax();
            assert!(error < 1e-8, "{n} points: {error:e}");
            assert!(fit.rms < 1e-12);
        }
    }
}

/// At a minimum ΣwJᵀe = 0, and every step costs.
fn the_fit_is_a_minimum<G: Alignable<D, N>, const D: usize, const N: usize>() {
    let mut draw = Draw::new(2);
    for _ in 0..100 {
        let truth: G = draw.element(1.0);
        let source = cloud::<N>(&mut draw, 12);
        let target: Vec<_> = source.iter().map(|p| truth.act(p) + draw.normals::<N>() * 0.2).collect();
        let weights: Vec<f64> = source.iter().map(|_| draw.between(0.1, 3.0)).collect();
        let pairs = Pairs::new(&source, &target).unwrap().weighted(&weights).unwrap();
        let x = pairs.align::<G, D>().unwrap().target_from_source;
        let each = || source.iter().zip(&target).zip(&weights);
        let gradient = each().fold(SVector::<f64, D>::zeros(), |sum, ((p, q), w)| {
            let (y, j, _) = x.act_jac(p);
            sum + j.transpose() * (q - y) * *w
        });
        assert!(gradient.amax() < 1e-10, "{gradient}");
        let cost = |x: &G| each().map(|((p, q), w)| w * (q - x.act(p)).norm_squared()).sum::<f64>();
        for size in [1e-3, 0.1, 1.0, 3.0] {
            let other = x.rplus(&(draw.normals::<D>() * size));
            assert!(cost(&other) > cost(&x));
        }
    }
}

/// The mean of ξᵀΣ⁻¹ξ over runs, as a multiple of what it should be, and its standard error.
fn nees<G: Alignable<D, N>, const D: usize, const N: usize>(noise: &str) -> (f64, f64) {
    let mut draw = Draw::new(3);
    let (n, runs) = (8, 4000);
    let scores: Vec<f64> = (0..runs)
        .map(|_| {
            let truth: G = draw.element(0.5);
            let source = cloud::<N>(&mut draw, n);
            let weights: Vec<f64> = source.iter().map(|_| draw.between(0.3, 3.0)).collect();
            let isotropic = noise != "per pair";
            let target = source.iter().zip(&weights).map(|(p, w)| {
                let e = draw.normals::<N>();
                truth.act(p) + if isotropic { e * 0.02 / w.sqrt() } else { shape::<N>() * e / w.sqrt() }
            });
            let target: Vec<_> = target.collect();
            let each = |w: &f64| Covariance::new(shape::<N>() * shape::<N>().transpose() / *w).unwrap();
            let covariances: Vec<_> = weights.iter().map(each).collect();
            let noise = match noise {
                "estimated" => Noise::Estimated,
                "isotropic" => Noise::Isotropic(0.02),
                _ => Noise::PerPair(&covariances),
            };
            let pairs = Pairs::new(&source, &target).unwrap().weighted(&weights).unwrap();
            let x = pairs.align::<G, D>().unwrap().target_from_source;
            pairs.uncertain(&x, noise).unwrap().mahalanobis_squared(&truth).unwrap()
        })
        .collect();
    let (mean, error) = mean_and_error(&scores);
    // An estimated σ² makes this D times Fisher's F of (D, ν), whose mean is ν/(ν − 2).
    let freedom = (N * n - D) as f64;
    let expected = D as f64 * if noise == "estimated" { freedom / (freedom - 2.0) } else { 1.0 };
    (mean / expected, error / expected)
}

fn the_covariance_is_that_of_many_runs<G: Alignable<D, N>, const D: usize, const N: usize>() {
    for noise in ["estimated", "isotropic", "per pair"] {
        let (ratio, error) = nees::<G, D, N>(noise);
        println!("{}: {noise}: {ratio:.3} ± {error:.3}", std::any::type_name::<G>());
        // Four standard errors, and 1 % for what is not linear in noise of a hundredth of the size.
        assert!((ratio - 1.0).abs() < 4.0 * error + 0.01, "{noise}: {ratio} ± {error}");
    }
}

/// An isometry of the source's frame or the target's moves the answer along.
fn moving_the_frames_moves_the_answer<G: Alignable<D, N>, const D: usize, const N: usize>() {
    let mut draw = Draw::new(4);
    for _ in 0..100 {
        let (a, b): (G, G) = (draw.element(1.0), draw.element(1.0));
        let source = cloud::<N>(&mut draw, 9);
        let target: Vec<_> = source.iter().map(|p| p + draw.normals::<N>() * 0.1).collect();
        let pairs = Pairs::new(&source, &target).unwrap();
        let fit = pairs.align::<G, D>().unwrap().target_from_source;
        let local = pairs.uncertain(&fit, Noise::Isotropic(0.1)).unwrap();
        let moved: Vec<_> = source.iter().map(|p| b.inverse().act(p)).collect();
        let seen: Vec<_> = target.iter().map(|q| a.act(q)).collect();
        let pairs = Pairs::new(&moved, &seen).unwrap();
        let expected = a.compose(&fit).compose(&b);
        assert!(pairs.align::<G, D>().unwrap().target_from_source.rminus(&expected).amax() < 1e-10);
        // Noise is measured in the units of the target, which A changes by its scale.
        let scale = a.linear_part().column(0).norm();
        let pose = pairs.uncertain(&expected, Noise::Isotropic(0.1 * scale)).unwrap();
        let by_frame_change = local.change_body(&b);
        let (x, y) = (pose.covariance().matrix(), by_frame_change.covariance().matrix());
        assert!((x - y).amax() < 1e-9 * x.amax(), "{x}{y}");
    }
}

macro_rules! for_every_group {
    ($($property:ident)*) => {$(
        mod $property {
            use super::*;
            #[test]
            fn in_se2() { super::$property::<SE2, 3, 2>(); }
            #[test]
            fn in_se3() { super::$property::<SE3, 6, 3>(); }
            #[test]
            fn in_sim2() { super::$property::<Sim2, 4, 2>(); }
            #[test]
            fn in_sim3() { super::$property::<Sim3, 7, 3>(); }
        }
    )*};
}

for_every_group! {
    truth_is_found
    the_fit_is_a_minimum
    the_covariance_is_that_of_many_runs
    moving_the_frames_moves_the_answer
}

#[test]
fn coordinates_of_a_national_grid_cost_no_more_digits_than_they_have() {
    let mut draw = Draw::new(5);
    let origin = vector![4.5e5, 5.4e6, 300.0];
    let truth = SE3::new(SO3::exp(&vector![0.1, -0.2, 0.7]), vector![1.0, 2.0, 3.0]);
    let source = cloud::<3>(&mut draw, 30);
    let moved: Vec<_> = source.iter().map(|p| truth * *p + origin).collect();
    let fit = Pairs::new(&source, &moved).unwrap().align::<SE3, 6>().unwrap();
    // ε·5.4e6 ≈ 1.2e-9 m per point.
    assert!(fit.rms < 1e-9, "{}", fit.rms);
    let error = fit.target_from_source.rotation().rminus(&truth.rotation()).norm();
    assert!(error < 1e-9, "{error:e}");
}

#[test]
fn a_pair_of_weight_zero_is_not_there() {
    let mut draw = Draw::new(6);
    let source = cloud::<3>(&mut draw, 7);
    let mut target: Vec<_> = source.iter().map(|p| p + draw.normals::<3>() * 0.1).collect();
    let kept = target.clone();
    let without = Pairs::new(&source[..6], &kept[..6]).unwrap();
    let fit = without.align::<SE3, 6>().unwrap();
    target[6] = vector![1e6, 0.0, -1e6];
    let weights = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0];
    let with = Pairs::new(&source, &target).unwrap().weighted(&weights).unwrap();
    let same = with.align::<SE3, 6>().unwrap();
    assert!(same.target_from_source.rminus(&fit.target_from_source).norm() < 1e-14);
    let sigmas =
        |pairs: &Pairs<'_, 3>| pairs.uncertain(&fit.target_from_source, Noise::Estimated).unwrap().sigmas();
    assert!((sigmas(&with) - sigmas(&without)).amax() < 1e-14);
}

fn refusal<const N: usize>(source: &[SVector<f64, N>], target: &[SVector<f64, N>]) -> RegistrationError
where
    SE3: Alignable<6, N>,
{
    Pairs::new(source, target).and_then(|pairs| pairs.align::<SE3, 6>()).unwrap_err()
}

#[test]
fn too_few_points_are_refused() {
    let p = [vector![0.0, 0.0, 0.0], vector![1.0, 0.0, 0.0]];
    assert_eq!(refusal(&p, &p), RegistrationError::TooFewPairs { given: 2, needed: 3 });
    assert_eq!(refusal::<3>(&[], &[]), RegistrationError::TooFewPairs { given: 0, needed: 3 });
    let one = [vector![1.0, 2.0]];
    let error = Pairs::new(&one, &one).unwrap().align::<SE2, 3>().unwrap_err();
    assert_eq!(error, RegistrationError::TooFewPairs { given: 1, needed: 2 });
    let three = [p[0], p[1], vector![0.0, 1.0, 0.0]];
    let pairs = Pairs::new(&three, &three).unwrap().weighted(&[1.0, 0.0, 1.0]).unwrap();
    let error = pairs.align::<SE3, 6>().unwrap_err();
    assert_eq!(error, RegistrationError::TooFewPairs { given: 2, needed: 3 });
}

#[test]
fn points_on_a_line_name_the_axis_that_is_free() {
    let mut draw = Draw::new(7);
    for offset in [0.0, 1e3, 1e6] {
        for _ in 0..100 {
            let along = draw.normals::<3>().normalize();
            let line: Vec<_> =
                (0..20).map(|_| along * draw.normal() * 5.0 + Vector3::repeat(offset)).collect();
            let spread = cloud::<3>(&mut draw, 20);
            let pose: SE3 = draw.element(1.0);
            let seen: Vec<_> = line.iter().map(|p| pose * *p).collect();
            let RegistrationError::Collinear { role: Role::Source, axis } = refusal(&line, &seen) else {
                panic!("{}", refusal(&line, &seen))
            };
            assert!(angle_between(axis.coordinates(), &along) < 1e-6);
            let RegistrationError::Collinear { role: Role::Target, axis } = refusal(&spread, &line) else {
                panic!("{}", refusal(&spread, &line))
            };
            assert!(angle_between(axis.coordinates(), &along) < 1e-6);
        }
    }
}

#[test]
fn points_a_millimetre_off_a_line_of_a_metre_are_taken_and_said_to_turn() {
    let line: Vec<_> = (0..11).map(|i| vector![0.1 * f64::from(i), 1e-3 * f64::from(i % 2), 0.0]).collect();
    let pairs = Pairs::new(&line, &line).unwrap();
    let fit = pairs.align::<SE3, 6>().unwrap();
    let pose = pairs.uncertain(&fit.target_from_source, Noise::Isotropic(1e-3)).unwrap();
    // σ/(√n·0.5 mm) about the line, σ/(√n·0.32 m) across.
    assert!(pose.sigmas()[3] > 0.5 && pose.sigmas()[4] < 2e-3, "{}", pose.sigmas());
}

#[test]
fn points_that_coincide_are_refused() {
    let p = [vector![1.0, 2.0, 3.0]; 5];
    assert_eq!(refusal(&p, &p), RegistrationError::Coincident { role: Role::Source });
    let q = [[0.1, 0.2], [0.1, 0.2]].map(Vector2::from);
    let error = Pairs::new(&q, &q).unwrap().align::<Sim2, 4>().unwrap_err();
    assert_eq!(error, RegistrationError::Coincident { role: Role::Source });
}

#[test]
fn two_points_fix_a_plane_motion_but_not_its_noise() {
    let p = [vector![0.0, 0.0], vector![1.0, 0.0]];
    let q = [vector![1.0, 1.0], vector![1.0, 3.0]];
    let pairs = Pairs::new(&p, &q).unwrap();
    let fit = pairs.align::<Sim2, 4>().unwrap();
    assert!((fit.target_from_source.scale() - 2.0).abs() < 1e-15);
    let error = pairs.uncertain(&fit.target_from_source, Noise::Estimated).unwrap_err();
    assert_eq!(error, RegistrationError::NoRedundancy { pairs: 2 });
    assert!(pairs.uncertain(&fit.target_from_source, Noise::Isotropic(0.1)).is_ok());
}

#[test]
fn mirror_images_are_refused_where_they_leave_a_rotation_open_and_told_elsewhere() {
    // Equal extents across the first axis: turned about it, the mirrored cross fits as well.
    let cross: Vec<_> = [[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        .iter()
        .flat_map(|p| [Vector3::from(*p), -Vector3::from(*p)])
        .collect();
    let mirrored: Vec<_> = cross.iter().map(|p| vector![p.x, p.y, -p.z]).collect();
    let RegistrationError::Ambiguous { axis } = refusal(&cross, &mirrored) else {
        panic!("{}", refusal(&cross, &mirrored))
    };
    assert!(angle_between(axis.coordinates(), &Vector3::x()) < 1e-7, "{axis}");
    let square: Vec<_> = cross.iter().map(Vector3::yz).collect();
    let flipped: Vec<_> = square.iter().map(|p| vector![p.x, -p.y]).collect();
    let error = Pairs::new(&square, &flipped).unwrap().align::<SE2, 3>().unwrap_err();
    assert!(error.to_string().contains("(0.00, 0.00, 1.00)"), "{error}");

    let mut draw = Draw::new(8);
    let generic = cloud::<3>(&mut draw, 20);
    let mirrored: Vec<_> = generic.iter().map(|p| vector![p.x, -p.y, p.z]).collect();
    let fit = Pairs::new(&generic, &mirrored).unwrap().align::<SE3, 6>().unwrap();
    assert!(fit.reflected && fit.rms > 0.1);
    assert!(!Pairs::new(&generic, &generic).unwrap().align::<SE3, 6>().unwrap().reflected);
}

#[test]
fn numbers_that_are_none_are_refused_with_their_place() {
    let good = [vector![0.0, 0.0, 0.0], vector![1.0, 0.0, 0.0], vector![0.0, 1.0, 0.0]];
    for x in [f64::NAN, f64::INFINITY, -1e200] {
        let mut bad = good;
        bad[1].y = x;
        assert_eq!(refusal(&bad, &good), RegistrationError::NotFinite { role: Role::Source, index: 1 });
        assert_eq!(refusal(&good, &bad), RegistrationError::NotFinite { role: Role::Target, index: 1 });
    }
    let pairs = Pairs::new(&good, &good).unwrap();
    for weight in [f64::NAN, f64::INFINITY, -1.0] {
        let error = pairs.weighted(&[1.0, 1.0, weight]).unwrap_err();
        assert!(matches!(error, RegistrationError::NotAWeight { index: 2, .. }), "{error}");
    }
    assert_eq!(pairs.weighted(&[1.0]).unwrap_err(), RegistrationError::WeightCount { pairs: 3, weights: 1 });
    let error = Pairs::new(&good, &good[..2]).unwrap_err();
    assert_eq!(error, RegistrationError::Unpaired { source_points: 3, target_points: 2 });
    let uncertain = |noise| pairs.uncertain(&SE3::identity(), noise).unwrap_err();
    assert!(matches!(uncertain(Noise::Isotropic(0.0)), RegistrationError::NotASigma { .. }));
    assert!(matches!(uncertain(Noise::Isotropic(f64::NAN)), RegistrationError::NotASigma { .. }));
    let error = uncertain(Noise::PerPair(&[]));
    assert_eq!(error, RegistrationError::CovarianceCount { pairs: 3, covariances: 0 });
}
