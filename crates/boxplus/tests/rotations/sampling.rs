//! Random elements are distributed as they should be: Kolmogorov–Smirnov and χ² over many seeds, moments with standard errors.
//!
//! Every test looks at all its p-values at once: none below 0.01 over their number (Bonferroni), and their mean, of variance
//! 1/(12n), within three standard errors of ½, so that a sample may not be more regular than chance either.

use crate::EPS;
use boxplus::lie::{LieError, LieGroup, Manifold, S2, SE2, SE3, SO2, SO3, TangentSampler};
use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector2, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{PI, TAU};

const SEEDS: u64 = 24;
const SAMPLES: usize = 4000;

/// p-value of Kolmogorov–Smirnov for numbers that should be uniform on \[0, 1\]. Stephens (1970).
fn kolmogorov_smirnov(mut u: Vec<f64>) -> f64 {
    u.sort_by(f64::total_cmp);
    let n = u.len() as f64;
    let gaps = u.iter().enumerate().map(|(i, u)| (u - i as f64 / n).max((i as f64 + 1.0) / n - u));
    let d = gaps.fold(0.0, f64::max);
    let lambda = (n.sqrt() + 0.12 + 0.11 / n.sqrt()) * d;
    let series = (1..=100).map(|k| {
        let k = f64::from(k);
        2.0 * if k % 2.0 == 1.0 { 1.0 } else { -1.0 } * (-2.0 * k * k * lambda * lambda).exp()
    });
    series.sum::<f64>().clamp(0.0, 1.0)
}

/// p-value of χ² for cells of equal probability. Wilson & Hilferty (1931): (χ²/k)^⅓ is normal, to 10⁻³ for k > 50.
fn chi_squared(cells: usize, cell: impl Iterator<Item = usize>) -> f64 {
    let mut counts = vec![0.0; cells];
    cell.for_each(|i| counts[i] += 1.0);
    let expected = counts.iter().sum::<f64>() / cells as f64;
    let chi: f64 = counts.iter().map(|c| (c - expected) * (c - expected) / expected).sum();
    let k = (cells - 1) as f64;
    let spread = 2.0 / (9.0 * k);
    upper_tail(((chi / k).cbrt() - (1.0 - spread)) / spread.sqrt())
}

/// P(N(0, 1) > z), by the error function of Abramowitz & Stegun 7.1.26, to 2·10⁻⁷.
fn upper_tail(z: f64) -> f64 {
    let x = z.abs() / 2.0_f64.sqrt();
    let t = 1.0 / (1.0 + 0.3275911 * x);
    let polynomial = [1.061405429, -1.453152027, 1.421413741, -0.284496736, 0.254829592];
    let tail = 0.5 * polynomial.iter().fold(0.0, |sum, a| (sum + a) * t) * (-x * x).exp();
    if z > 0.0 { tail } else { 1.0 - tail }
}

fn are_plausible(name: &str, p: &[f64]) {
    let n = p.len() as f64;
    let least = p.iter().copied().fold(1.0, f64::min);
    assert!(least > 0.01 / n, "{name}: p = {least:.1e} among {n}");
    let (mean, error) = (p.iter().sum::<f64>() / n, (1.0 / (12.0 * n)).sqrt());
    assert!((mean - 0.5).abs() < 3.0 * error, "{name}: mean p = {mean:.3} ± {error:.3}");
}

fn is_uniform<X>(name: &str, draw: impl Fn(&mut ChaCha8Rng) -> X, to_unit_interval: impl Fn(&X) -> f64) {
    let p = (0..SEEDS).map(|seed| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        kolmogorov_smirnov((0..SAMPLES).map(|_| to_unit_interval(&draw(&mut rng))).collect())
    });
    are_plausible(name, &p.collect::<Vec<_>>());
}

/// What a uniform rotation must show, of whatever `draw` gives.
fn is_haar(name: &str, draw: impl Fn(&mut ChaCha8Rng) -> SO3 + Copy) {
    // The density of θ is (1 − cos θ)/π.
    let angle = |r: &SO3| {
        let theta = r.to_axis_angle().1;
        (theta - theta.sin()) / PI
    };
    let height = |r: &SO3| 0.5 * (1.0 + r.to_axis_angle().0.z);
    let azimuth = |r: &SO3| {
        let n = r.to_axis_angle().0;
        n.y.atan2(n.x) / TAU + 0.5
    };
    is_uniform(&format!("{name}, angle"), draw, angle);
    is_uniform(&format!("{name}, axis height"), draw, height);
    is_uniform(&format!("{name}, axis azimuth"), draw, azimuth);
    for i in 0..3 {
        for j in 0..3 {
            let entry = |r: &SO3| 0.5 * (1.0 + r.to_matrix()[(i, j)]);
            is_uniform(&format!("{name}, entry {i}{j}"), draw, entry);
        }
    }
    // Jointly: 4 × 4 × 4 cells.
    let cell = |u: f64| [0.25, 0.5, 0.75].iter().filter(|edge| u > **edge).count();
    let p = (0..SEEDS).map(|seed| {
        let mut rng = ChaCha8Rng::seed_from_u64(1000 + seed);
        let sample = (0..SAMPLES).map(|_| draw(&mut rng));
        chi_squared(64, sample.map(|r| cell(angle(&r)) + 4 * cell(height(&r)) + 16 * cell(azimuth(&r))))
    });
    are_plausible(&format!("{name}, cells"), &p.collect::<Vec<_>>());
}

#[test]
fn uniform_rotations_are_uniform_however_they_are_turned() {
    is_haar("SO(3)", SO3::sample_uniform);
    let (a, b) = (SO3::about_x(1.0), SO3::about_y(-2.0));
    is_haar("turned on both sides", |rng| a * SO3::sample_uniform(rng) * b);
    is_haar("inverted", |rng| SO3::<f64>::sample_uniform(rng).inverse());
    is_haar("of a pose", |rng| SE3::sample_in_box(rng, [&Vector3::zeros(), &Vector3::x()]).rotation());
}

#[test]
#[should_panic(expected = "uniform axis and angle, angle")]
fn a_uniform_axis_with_a_uniform_angle_is_caught() {
    use rand::RngExt;
    is_haar("uniform axis and angle", |rng| {
        let axis = S2::<f64>::sample_uniform(rng).vector();
        SO3::exp(&(axis * (PI * rng.random::<f64>())))
    });
}

#[test]
fn uniform_directions_and_plane_rotations_are_uniform() {
    let tilt = SO3::exp(&Vector3::new(0.4, -1.1, 0.7));
    for axis in 0..3 {
        is_uniform("S², component", S2::sample_uniform, |n: &S2| 0.5 * (1.0 + n.vector()[axis]));
        is_uniform(
            "S², turned",
            |rng| tilt * S2::sample_uniform(rng),
            |n: &S2| 0.5 * (1.0 + n.vector()[axis]),
        );
    }
    is_uniform("SO(2)", SO2::sample_uniform, |r: &SO2| r.angle() / TAU + 0.5);
    let (low, high) = (Vector2::new(-3.0, 1.0), Vector2::new(5.0, 2.0));
    let draw = |rng: &mut ChaCha8Rng| SE2::sample_in_box(rng, [&low, &high]);
    is_uniform("SE(2), x", draw, |x: &SE2| (x.translation().x + 3.0) / 8.0);
    is_uniform("SE(2), y", draw, |x: &SE2| x.translation().y - 1.0);
    is_uniform("SE(2), angle", draw, |x: &SE2| x.angle() / TAU + 0.5);
    is_uniform("S² in f32", S2::<f32>::sample_uniform, |n| 0.5 * f64::from(1.0 + n.vector().x));
}

#[test]
fn samples_are_elements_and_depend_on_the_seed_alone() {
    let draw = |seed| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (SO3::<f64>::sample_uniform(&mut rng), S2::<f64>::sample_uniform(&mut rng))
    };
    assert_eq!(draw(1), draw(1));
    assert_ne!(draw(1), draw(2));
    for seed in 0..1000 {
        let (r, n) = draw(seed);
        let norm = r.quaternion_xyzw().iter().map(|c| c * c).sum::<f64>();
        assert!((norm - 1.0).abs() < 4.0 * EPS && (n.vector().norm() - 1.0).abs() < 4.0 * EPS);
    }
}

/// Means and covariances of samples against 0 and Σ, each in its standard error.
fn has_moments<const D: usize>(
    covariance: &SMatrix<f64, D, D>,
    draw: impl Fn(&mut ChaCha8Rng) -> SVector<f64, D>,
) {
    let n = 20_000;
    for seed in 0..8 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (mut mean, mut second) = (SVector::<f64, D>::zeros(), SMatrix::<f64, D, D>::zeros());
        for _ in 0..n {
            let x = draw(&mut rng);
            mean += x / f64::from(n);
            second += x * x.transpose() / f64::from(n);
        }
        // Of N(0, Σ): Var(mean) = Σ/n, Var(second moment) = (Σᵢᵢ·Σⱼⱼ + Σᵢⱼ²)/n. With 8·D² ≈ 300 numbers 4.5 s.e. is one in 500.
        for i in 0..D {
            let error = (covariance[(i, i)] / f64::from(n)).sqrt();
            assert!(mean[i].abs() <= 4.5 * error, "mean {i}: {} of {error}", mean[i]);
            for j in 0..D {
                let (a, b, c) = (covariance[(i, i)], covariance[(j, j)], covariance[(i, j)]);
                let error = ((a * b + c * c) / f64::from(n)).sqrt();
                let off = (second[(i, j)] - c).abs();
                assert!(off <= 4.5 * error + 1e-15 * c.abs(), "{i}{j}: off by {off}, s.e. {error}");
            }
        }
    }
}

#[test]
fn gaussian_steps_have_the_covariance_on_the_side_that_is_named() {
    // Metres beside milliradians, correlated.
    let half = SMatrix::<f64, 6, 6>::from_fn(|i, j| {
        (1.0 + (i * 5 + j * 3) as f64).sin() * if i < 3 { 0.3 } else { 0.002 }
    });
    let covariance = half * half.transpose();
    let sampler = TangentSampler::new(&covariance).unwrap();
    let product = sampler.factor() * sampler.factor().transpose();
    for (i, (a, b)) in product.iter().zip(&covariance).enumerate() {
        let scale = (covariance[(i % 6, i % 6)] * covariance[(i / 6, i / 6)]).sqrt();
        assert!((a - b).abs() < 8.0 * EPS * scale);
    }
    has_moments(&covariance, |rng| sampler.sample(rng));
    let mean = SE3::new(SO3::about_x(0.5), Vector3::new(3.0, -2.0, 1.0));
    has_moments(&covariance, |rng| sampler.sample_around(&mean, rng).rminus(&mean));
    has_moments(&covariance, |rng| sampler.sample_around_left(&mean, rng).lminus(&mean));
    let (plane, n) =
        (Matrix2::new(0.04, 0.01, 0.01, 0.02), S2::from_vector(&Vector3::new(1.0, 2.0, 3.0)).unwrap());
    let sampler = TangentSampler::new(&plane).unwrap();
    has_moments(&plane, |rng| sampler.sample_around(&n, rng).minus(&n));
    // And they are normal: the squared Mahalanobis length is exponential in two dimensions.
    let inverse = plane.try_inverse().unwrap();
    let length = |x: &Vector2<f64>| 1.0 - (-0.5 * (x.transpose() * inverse * x).x).exp();
    is_uniform("Mahalanobis", |rng| sampler.sample(rng), length);
    is_uniform(
        "direction",
        |rng| sampler.sample::<f64>(rng),
        |x| {
            let white = sampler.factor().try_inverse().unwrap() * x;
            white.y.atan2(white.x) / TAU + 0.5
        },
    );
}

#[test]
fn a_semidefinite_covariance_moves_only_what_it_names() {
    let along = Vector3::new(1.0, -2.0, 0.5);
    let line = along * along.transpose();
    let sampler = TangentSampler::new(&line).unwrap();
    has_moments(&line, |rng| sampler.sample(rng));
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for _ in 0..100 {
        let x: Vector3<f64> = sampler.sample(&mut rng);
        assert!(x.cross(&along).norm() < 8.0 * EPS * x.norm() * along.norm());
    }
    let nothing = TangentSampler::new(&Matrix3::zeros()).unwrap();
    assert_eq!(nothing.sample::<f64>(&mut rng), Vector3::zeros());
}

#[test]
fn what_is_no_covariance_is_refused() {
    let wrong = |m: Matrix2<f64>| TangentSampler::new(&m).unwrap_err();
    assert_eq!(wrong(Matrix2::new(1.0, f64::NAN, 0.0, 1.0)), LieError::NotFinite);
    assert!(matches!(wrong(Matrix2::new(1.0, 0.5, 0.4, 1.0)), LieError::NotACovariance { .. }));
    assert!(matches!(wrong(Matrix2::new(1.0, 2.0, 2.0, 1.0)), LieError::NotACovariance { .. }));
    assert!(matches!(wrong(Matrix2::new(1.0, 0.0, 0.0, -1e-12)), LieError::NotACovariance { .. }));
    assert!(matches!(wrong(Matrix2::new(1.0, 0.1, 0.1, 0.0)), LieError::NotACovariance { .. }));
    // Tiny beside huge is no fault.
    assert!(TangentSampler::new(&Matrix2::new(1e12, 0.0, 0.0, 1e-12)).is_ok());
}
