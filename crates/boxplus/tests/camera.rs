//! Camera models against dual numbers, against themselves backwards, and against OpenCV.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use boxplus::camera::{Camera, DoubleSphere, KannalaBrandt, Pinhole, Snavely, Stereo, Unseen, View};
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
