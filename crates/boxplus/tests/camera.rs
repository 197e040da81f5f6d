//! Camera models against dual numbers, against themselves backwards, and against OpenCV.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use boxplus::camera::{
    Camera, DoubleSphere, KannalaBrandt, LocateError, Pinhole, Projective, Snavely, Stereo, Unseen, View,
    locate_camera, locate_point, poses_of_three,
};
use boxplus::lie::{Action, LieGroup, Manifold, Real, SE3};
use nalgebra::{SMatrix, SVector, Vector3, vector};
use num_dual::{Derivative, DualSVec64};

const PINHOLE: Pinhole = Pinhole {
    focal: [458.654, 457.296],
    centre: [367.215, 248.375],
    distortion: [-0.28340811, 0.07395907, 1.9359e-2, 1.76187e-2, 0.01],
};
const FISHEYE: KannalaBrandt = KannalaBrandt {
    focal: [190.978, 190.973],
    centre: [254.932, 256.897],
    distortion: [3.4823e-3, 7.1503e-4, -2.0532e-3, 2.0293e-4],
};
const SPHERES: DoubleSphere =
    DoubleSphere { focal: [364.2, 363.9], centre: [376.5, 240.0], xi: -0.213, alpha: 0.581 };
const SNAVELY: Snavely = Snavely { focal: 1500.0, distortion: [-0.05, 0.012] };
const STEREO: Stereo = Stereo { focal: [400.0, 410.0], centre: [320.0, 240.0], baseline: 0.2 };

/// Points all around the axis `ahead`, on it and close to it, up to `angle` from it.
fn points(ahead: f64, angle: f64) -> Vec<Vector3<f64>> {
    let mut points = vec![];
    for theta in [0.0, 1e-9, 1e-5, 1e-3, 0.1, 0.3, 0.5, 0.8, 1.0].map(|share| share * angle) {
        for turn in 0..5 {
            let (sin, cos) = (1.3 * f64::from(turn) + 0.4).sin_cos();
            let distance = 0.5 + 3.0 * f64::from(turn);
            points.push(distance * vector![theta.sin() * cos, theta.sin() * sin, ahead * theta.cos()]);
        }
    }
    points
}

/// The derivative of `f` at zero, exactly.
fn derivative<const R: usize, const N: usize>(
    f: impl Fn(&SVector<DualSVec64<N>, N>) -> SVector<DualSVec64<N>, R>,
    at: &SVector<f64, N>,
) -> SMatrix<f64, R, N> {
    let x = SVector::from_fn(|i, _| {
        DualSVec64::new(at[i], Derivative::derivative_generic(nalgebra::Const::<N>, nalgebra::U1, i))
    });
    let y = f(&x);
    SMatrix::from_fn(|r, c| y[r].eps.0.map_or(0.0, |eps| eps[c]))
}

fn close<const R: usize, const N: usize>(
    name: &str,
    a: &SMatrix<f64, R, N>,
    b: &SMatrix<f64, R, N>,
    bound: f64,
) {
    let error = (a - b).amax() / b.amax().max(1.0);
    assert!(error <= bound, "{name}: {error:e}\n{a}{b}");
}

/// Jacobians are those of dual numbers, and what is projected comes back.
fn check<C, const R: usize, const P: usize>(name: &str, camera: C, ahead: f64, angle: f64)
where
    C: Camera<R, P, Scalar = f64>,
    C::Over<DualSVec64<P>>: Camera<R, P, Scalar = DualSVec64<P>>,
{
    assert_eq!(C::INTRINSICS.len(), P);
    assert_eq!(C::from_intrinsics(&camera.intrinsics()), camera);
    for p in points(ahead, angle) {
        let (image, d_p, d_intrinsics) = camera.project_jac(&p).unwrap();
        close(name, &camera.project(&p).unwrap(), &image, 1e-15);
        let over = camera.map(DualSVec64::<3>::lit);
        close(name, &d_p, &derivative(|p| C::image_over(&over, p), &p), 2e-14);
        let constant = p.map(DualSVec64::<P>::lit);
        let by_intrinsics = |i: &SVector<_, P>| C::Over::<DualSVec64<P>>::from_intrinsics(i).image(&constant);
        close(name, &d_intrinsics, &derivative(by_intrinsics, &camera.intrinsics()), 2e-14);

        let back = camera.unproject(&image).unwrap();
        let expected = if R == 2 { p.normalize() } else { p };
        assert!((back - expected).norm() < 1e-11 * expected.norm(), "{name}: {p} came back as {back}");
    }
}

#[test]
fn every_derivative_is_that_of_dual_numbers_and_every_pixel_leads_back_to_its_point() {
    check("pinhole", PINHOLE, 1.0, 0.8);
    check("pinhole without distortion", Pinhole::new([300.0, 310.0], [10.0, -20.0]), 1.0, 1.5);
    check("fisheye", FISHEYE, 1.0, 2.0);
    check("double sphere", SPHERES, 1.0, 1.9);
    check("Snavely", SNAVELY, -1.0, 1.1);
    check("stereo", STEREO, 1.0, 1.0);
}

#[test]
fn unprojection_has_derivatives() {
    fn check<C, const P: usize>(camera: C, p: Vector3<f64>)
    where
        C: Camera<2, P, Scalar = f64>,
        C::Over<DualSVec64<2>>: Camera<2, P, Scalar = DualSVec64<2>>,
    {
        let image = camera.project(&p).unwrap();
        let over = camera.map(DualSVec64::<2>::lit);
        let d_ray = derivative(|u| over.unproject(u).unwrap(), &image);
        let (_, d_image, _) = camera.image_jac(&p.normalize());
        close("back and forth", &(d_image * d_ray), &SMatrix::identity(), 1e-11);
    }
    for p in points(1.0, 0.7).into_iter().filter(|p| p.xy().norm() > 1e-4) {
        check(PINHOLE, p);
        check(FISHEYE, p);
        check(SPHERES, p);
        check(SNAVELY, -p);
    }
}

#[test]
fn single_precision_agrees_with_double() {
    for p in points(1.0, 0.8) {
        let single = FISHEYE.map(|x| x as f32).project(&p.map(|x| x as f32)).unwrap();
        let double = FISHEYE.project(&p).unwrap();
        assert!((single.map(f64::from) - double).norm() < 2e-4, "{single} {double}"); // of 500 pixels, 3 ulps
    }
}

#[test]
fn points_behind_are_refused_and_the_formula_is_not_asked() {
    let behind = vector![0.1, 0.2, -1.0];
    for nowhere in [behind, Vector3::zeros(), Vector3::repeat(f64::NAN)] {
        assert_eq!(PINHOLE.project(&nowhere), Err(Unseen::Behind));
        assert_eq!(STEREO.project(&nowhere), Err(Unseen::Behind));
        assert_eq!(SPHERES.project(&nowhere), Err(Unseen::Behind));
    }
    assert_eq!(FISHEYE.project(&Vector3::zeros()), Err(Unseen::Behind));
    assert_eq!(FISHEYE.project(&vector![0.0, 0.0, -2.0]), Err(Unseen::Behind));
    assert!(SNAVELY.project(&behind).is_ok() && SNAVELY.project(&-behind) == Err(Unseen::Behind));
    assert!(PINHOLE.image(&behind).iter().all(|x| x.is_finite()));
}

/// At a fold the radius turns back: beyond, a pixel would have two points.
#[test]
fn nothing_is_seen_beyond_the_fold_of_a_lens_even_where_it_unfolds_again() {
    // r(1 − r² + 0.3r⁴): rises to r² ≈ 0.42, falls, and rises again from r² ≈ 1.58.
    let camera = Snavely { focal: 100.0, distortion: [-1.0, 0.3] };
    let at = |r2: f64| camera.sees(&vector![r2.sqrt(), 0.0, -1.0]);
    for (r2, seen) in [(0.42, true), (0.43, false), (1.0, false), (1.6, false), (9.0, false)] {
        assert_eq!(at(r2).is_ok(), seen, "at r² = {r2}");
    }
    // The largest radius there is: 100·√0.4226·(1 − 0.4226 + 0.3·0.4226²) = 41.02 pixels.
    assert!(camera.unproject(&vector![41.0, 0.0]).is_ok());
    assert_eq!(camera.unproject(&vector![41.1, 0.0]), Err(Unseen::OutOfView));

    let pinhole = Pinhole { distortion: [-1.0, 0.3, 0.0, 0.0, 0.0], ..Pinhole::new([100.0; 2], [0.0; 2]) };
    assert_eq!(pinhole.project(&vector![2.0, 0.0, 1.0]), Err(Unseen::OutOfView));
    assert_eq!(pinhole.unproject(&vector![0.0, 41.1]), Err(Unseen::OutOfView));
    let fisheye = KannalaBrandt { focal: [100.0; 2], centre: [0.0; 2], distortion: [-0.1, 0.0, 0.0, 0.0] };
    assert_eq!(fisheye.project(&vector![1.0, 0.0, -1.0]), Err(Unseen::OutOfView)); // 135° > √(1/0.3) rad
    assert_eq!(fisheye.unproject(&vector![130.0, 0.0]), Err(Unseen::OutOfView));
    assert_eq!(SPHERES.unproject(&vector![9000.0, 0.0]), Err(Unseen::OutOfView));
    assert_eq!(STEREO.unproject(&vector![10.0, 0.0, 10.0, 0.0]), Err(Unseen::OutOfView));
}

#[test]
fn a_view_is_its_pose_and_its_camera() {
    let pose = SE3::exp(&vector![0.3, -0.2, 0.5, 0.4, -0.1, 0.2]);
    let view: View<Snavely, 3, 9> = View { world_from_camera: pose, camera: SNAVELY };
    let p = pose.act(&vector![0.2, -0.3, -2.0]);
    let (image, d_view, d_p) = view.image_jac(&p);
    close("image", &image, &SNAVELY.image(&vector![0.2, -0.3, -2.0]), 1e-14);
    let over = view.map(DualSVec64::<9>::lit);
    let moved = derivative(|tau| over.plus(tau).image(&p.map(DualSVec64::<9>::lit)), &SVector::zeros());
    close("by the view", &d_view, &moved, 1e-13);
    let over = view.map(DualSVec64::<3>::lit);
    close("by the point", &d_p, &derivative(|p| over.image(p), &p), 1e-13);
    let tau = SVector::<f64, 9>::from_fn(|i, _| 0.1 * i as f64);
    assert!((view.plus(&tau).minus(&view) - tau).amax() < 1e-12); // of the focal length's 1500
    assert!(view.sees(&p).is_ok());
}

/// The axioms of a manifold, and derivatives by dual numbers, near infinity and on both sides of it.
#[test]
fn projective_points_pass_through_infinity() {
    let place = vector![1.0, -2.0, 4.0];
    for extent in [2.0, 1e-3, 0.0, -1e-3, -2.0] {
        let x = Projective::new(&place, extent);
        for tau in
            [Vector3::zeros(), vector![1e-9, 0.0, 2e-9], vector![0.4, -0.7, 0.2], vector![3.0, 2.0, -1.0]]
        {
            let (y, d_self, d_tau) = x.plus_jac(&tau);
            assert!((y.minus(&x) - tau).norm() < 1e-14 * (1.0 + tau.norm_squared()), "{extent} {tau}");
            let (_, d_y, d_x) = y.minus_jac(&x);
            let over = |p: &Projective| p.map(DualSVec64::<3>::lit);
            let t = tau.map(DualSVec64::<3>::lit);
            close(
                "⊞ by X",
                &d_self,
                &derivative(|e| over(&x).plus(e).plus(&t).minus(&over(&y)), &Vector3::zeros()),
                1e-13,
            );
            close("⊞ by τ", &d_tau, &derivative(|t| over(&x).plus(t).minus(&over(&y)), &tau), 1e-13);
            close(
                "⊟ by Y",
                &d_y,
                &derivative(|e| over(&y).plus(e).minus(&over(&x)), &Vector3::zeros()),
                1e-13,
            );
            close(
                "⊟ by X",
                &d_x,
                &derivative(|e| over(&y).minus(&over(&x).plus(e)), &Vector3::zeros()),
                1e-13,
            );
        }
    }
    assert!((Projective::new(&place, 2.0).place(2.0) - place).norm() < 1e-15);
    assert!(Projective::new(&place, 0.0).place(1.0).iter().all(|x| x.is_finite()));
}

/// Values and derivatives of `scripts/camera_tables.py`.
#[test]
fn images_and_their_derivatives_are_those_of_opencv() {
    fn against<C: Camera<2, P, Scalar = f64>, const P: usize>(
        row: &str,
        [intrinsics, p, pixel, d_p]: [&str; 4],
    ) {
        let numbers = |cell: &str| cell.split(' ').map(|x| x.parse().unwrap()).collect::<Vec<f64>>();
        let camera = C::from_intrinsics(&SVector::from_vec(numbers(intrinsics)));
        let (image, jacobian, _) = camera.project_jac(&SVector::from_vec(numbers(p))).unwrap();
        close(row, &image, &SVector::from_vec(numbers(pixel)), 1e-14);
        // OpenCV's fisheye divides by r near the axis and loses half its digits there.
        let bound = if row.starts_with("fisheye") { 1e-9 } else { 1e-13 };
        close(row, &jacobian, &SMatrix::from_row_slice(&numbers(d_p)), bound);
    }
    let table = include_str!("reference/cameras.csv");
    for row in table.lines().skip(1) {
        let cells: Vec<_> = row.split(',').collect();
        let numbers = [cells[1], cells[2], cells[3], cells[4]];
        match cells[0] {
            "pinhole" => against::<Pinhole, 9>(row, numbers),
            "fisheye" => against::<KannalaBrandt, 8>(row, numbers),
            _ => against::<Snavely, 3>(row, numbers),
        }
    }
    assert_eq!(table.lines().count(), 141);
}

/// Six points before a camera, and where it sees them.
fn sightings(pose: &SE3, noise: f64) -> Vec<(Vector3<f64>, nalgebra::Vector2<f64>)> {
    let camera = Pinhole { distortion: [-0.2, 0.05, 1e-3, -5e-4, 0.0], ..PINHOLE };
    let places = [
        [1.0, 0.5, 5.0],
        [-1.5, 0.2, 6.0],
        [0.3, -1.4, 4.0],
        [1.5, 1.0, 7.0],
        [-0.8, -0.9, 3.5],
        [0.0, 1.6, 8.0],
    ];
    let seen = places.iter().enumerate().map(|(i, p)| {
        let l = pose.act(&Vector3::from(*p));
        let shift = vector![(3.7 * i as f64).sin(), (5.1 * i as f64 + 1.0).cos()] * noise;
        (l, camera.project(&Vector3::from(*p)).unwrap() + shift)
    });
    seen.collect()
}

#[test]
fn three_points_tell_at_most_four_poses_and_the_truth_is_among_them() {
    for k in 0..300 {
        let number = |i: usize| (12.9898 * (k * 17 + i) as f64).sin() * 43758.5453 % 1.0;
        let truth = SE3::exp(&SVector::from_fn(|i, _| 2.0 * number(i)));
        let points: [Vector3<f64>; 3] = std::array::from_fn(|i| {
            vector![2.0 * number(7 + i), 2.0 * number(11 + i), 4.0 + 2.0 * number(15 + i)]
        });
        let world = points.map(|p| truth.act(&p));
        let found: Vec<SE3> = poses_of_three(&points.map(|p| p.normalize()), &world).collect();
        let nearest = found.iter().map(|pose| pose.between(&truth).log().norm()).fold(9.0, f64::min);
        assert!(nearest < 1e-6 && found.len() <= 4, "case {k}: {nearest:e} among {}", found.len()); // double roots: half the digits
        for pose in &found {
            for (l, p) in world.iter().zip(&points) {
                assert!(pose.act_inverse(l).normalize().dot(&p.normalize()) > 1.0 - 1e-9, "case {k}");
            }
        }
    }
}

#[test]
fn a_camera_is_found_from_its_points_and_its_covariance_is_that_of_many_trials() {
    const TRIALS: usize = 2000;
    let camera = Pinhole { distortion: [-0.2, 0.05, 1e-3, -5e-4, 0.0], ..PINHOLE };
    let truth = SE3::exp(&vector![0.3, -0.2, 0.1, 0.2, 0.4, -0.1]);
    for count in 4..=6 {
        let exact = locate_camera(&camera, &sightings(&truth, 0.0)[..count], 0.5).unwrap();
        let error = exact.estimate.mean().between(&truth).log().norm();
        assert!(error < 1e-9 && exact.rms < 1e-9, "of {count} points: {error}");
    }
    // Mahalanobis distances of trials with noise of 0.5 pixels: six on average.
    let (mut sum, mut state) = (0.0, 7_u64);
    let mut uniform = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((state >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    };
    for _ in 0..TRIALS {
        let mut seen = sightings(&truth, 0.0);
        for (_, pixel) in &mut seen {
            let (r, turn) = ((-2.0 * uniform().ln()).sqrt(), std::f64::consts::TAU * uniform());
            *pixel += 0.5 * r * vector![turn.cos(), turn.sin()];
        }
        let found = locate_camera(&camera, &seen, 0.5).unwrap();
        let error = truth.rminus(found.estimate.mean());
        sum += found.estimate.covariance().mahalanobis_squared(&error).unwrap();
    }
    let mean = sum / TRIALS as f64;
    assert!((mean - 6.0).abs() < 4.0 * (12.0 / TRIALS as f64).sqrt(), "{mean}");
}

#[test]
fn what_does_not_tell_a_place_is_refused_with_the_reason() {
    let camera = Pinhole { distortion: [-0.2, 0.05, 1e-3, -5e-4, 0.0], ..PINHOLE };
    let seen = sightings(&SE3::identity(), 0.0);
    assert_eq!(locate_camera(&camera, &seen[..3], 0.5), Err(LocateError::TooFew { given: 3, needed: 4 }));
    assert_eq!(locate_camera(&camera, &seen, 0.0), Err(LocateError::NotASigma { sigma: 0.0 }));
    let line: Vec<_> = (0..5)
        .map(|i| vector![f64::from(i), 0.5 * f64::from(i), 6.0 + f64::from(i)])
        .map(|p| (p, camera.image(&p)))
        .collect();
    assert!(locate_camera(&camera, &line, 0.5).is_err());

    let at = |x: f64| -> View<Pinhole, 9, 15> {
        View {
            world_from_camera: SE3::exp(&vector![x, 0.0, 0.0, 0.0, 0.0, 0.0]),
            camera: Pinhole::new([500.0; 2], [0.0; 2]),
        }
    };
    let point = vector![0.5, 0.2, 4.0];
    let see = |x: f64| (at(x), at(x).image(&point));
    assert!(matches!(locate_point(&[see(0.0), see(0.001)], 0.5), Err(LocateError::NoParallax { .. })));
    assert_eq!(locate_point(&[see(0.0)], 0.5), Err(LocateError::TooFew { given: 1, needed: 2 }));
    // Rays that meet behind both cameras.
    let crossed = [(at(0.0), vector![-50.0, 0.0]), (at(1.0), vector![50.0, 0.0])];
    assert!(matches!(locate_point(&crossed, 0.5), Err(LocateError::Unseen { unseen: Unseen::Behind, .. })));
    // Depth is known to z²/(f·b)·σ√2 for two views: 4²/(500·1)·0.5·√2 = 2.3 cm.
    let found = locate_point(&[see(0.0), see(1.0)], 0.5).unwrap();
    assert!((found.estimate.mean().vector() - point).norm() < 1e-9);
    assert!((found.estimate.sigmas()[2] / 0.0226 - 1.0).abs() < 0.05, "{}", found.estimate.sigmas());
}

/// `scripts/camera_tables.py`: cv2.solvePnP and cv2.triangulatePoints on the same numbers.
#[test]
fn poses_and_points_are_those_of_opencv() {
    let table = include_str!("reference/locate.csv");
    let row = |name: &str| -> Vec<f64> {
        let line = table.lines().find(|line| line.starts_with(name)).unwrap();
        line.split(',').skip(1).map(|x| x.parse().unwrap()).collect()
    };
    let camera = Pinhole::new([500.0, 510.0], [320.0, 240.0]);
    let numbers = row("pnp");
    let (pose, seen) = numbers.split_at(6);
    let seen: Vec<_> = seen.chunks(5).map(|x| (vector![x[0], x[1], x[2]], vector![x[3], x[4]])).collect();
    let found = locate_camera(&camera, &seen, 1.0).unwrap().estimate.mean().inverse();
    let rotation: Vector3<f64> = found.rotation().log();
    assert!((rotation - Vector3::from_row_slice(&pose[..3])).norm() < 1e-6, "{rotation}"); // OpenCV stops at 1e-7 or so
    assert!(
        (found.translation() - Vector3::from_row_slice(&pose[3..])).norm() < 1e-5,
        "{}",
        found.translation()
    );

    let numbers = row("triangulation");
    let baseline = vector![numbers[3], 0.0, 0.0, 0.0, 0.0, 0.0];
    let views: [View<Pinhole, 9, 15>; 2] =
        [SE3::identity(), SE3::exp(&baseline)].map(|world_from_camera| View { world_from_camera, camera });
    let seen = [(views[0], vector![numbers[4], numbers[5]]), (views[1], vector![numbers[6], numbers[7]])];
    let point = locate_point(&seen, 1.0).unwrap().estimate.mean().vector();
    // OpenCV's is linear: it minimises an algebraic error, which exact pixels make zero as well.
    assert!((point - Vector3::from_row_slice(&numbers[..3])).norm() < 1e-6, "{point}");
}
