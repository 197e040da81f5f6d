use crate::support::*;
use boxplus::lie::{Action, LieGroup, SE23, SGal3, SO3};
use boxplus::trajectory::{ImuBias, ImuNoise, Preintegration, TrajectoryError};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

const QUIET: ImuNoise = ImuNoise { gyro: 2e-3, accel: 2e-2 };
const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);
type Sample = (Vector3<f64>, Vector3<f64>);

/// The motion of J8: gyro of σ 1.5 rad/s, accelerometer of σ 4 m/s².
fn shaken(seed: u64, n: u64) -> Vec<Sample> {
    (0..n).map(|i| (normal(seed * 10_000 + 2 * i) * 1.5, normal(seed * 10_000 + 2 * i + 1) * 4.0)).collect()
}

fn sum(samples: &[Sample], dt: f64, bias: ImuBias, noise: ImuNoise) -> Preintegration {
    let mut sum = Preintegration::new(bias, noise).unwrap();
    samples.iter().for_each(|(gyro, accel)| sum.push(gyro, accel, dt).unwrap());
    sum
}

fn bias(seed: u64, gyro: f64, accel: f64) -> ImuBias {
    ImuBias::new(draw::<3>(seed).normalize() * gyro, draw::<3>(seed + 1).normalize() * accel)
}

#[test]
fn one_sample_is_one_exponential_of_the_galilean_group() {
    let (w, a) = shaken(10, 1)[0];
    let x = sum(&[(w, a)], 0.3, ImuBias::zero(), QUIET).increment();
    let tau =
        SVector::from([0.0, 0.0, 0.0, w.x * 0.3, w.y * 0.3, w.z * 0.3, a.x * 0.3, a.y * 0.3, a.z * 0.3, 0.3]);
    same("Δ", &x, &SGal3::exp(&tau).extended_pose(), 0.0);
}

#[test]
fn increments_of_constant_rate_and_force_are_exact_however_they_are_cut() {
    let table = Table::parse(include_str!("../reference/increments.csv"));
    for row in 0..table.rows() {
        let (rate, force) = (table.get::<3>(row, "w"), table.get::<3>(row, "a"));
        if table.get::<3>(row, "dw").norm() > 0.0 {
            continue;
        }
        for n in [1, 3, 100_usize] {
            let dt = table.get::<1>(row, "t")[0] / n as f64;
            let samples = vec![(rate, force); n];
            let x = sum(&samples, dt, ImuBias::zero(), QUIET).increment();
            let bound = 8.0 * EPS * n as f64;
            close("R", &x.rotation().to_matrix(), &table.matrix(row, "r"), bound);
            close("v", &x.velocity(), &table.get::<3>(row, "v"), bound);
            close("p", &x.position(), &table.get::<3>(row, "p"), bound);
        }
    }
}

#[test]
fn increments_of_a_varying_motion_converge_with_the_square_of_the_sample_time() {
    let table = Table::parse(include_str!("../reference/increments.csv"));
    for row in 0..table.rows() {
        let [w, dw, a, da] = ["w", "dw", "a", "da"].map(|name| table.get::<3>(row, name));
        if dw.norm() == 0.0 {
            continue;
        }
        let total = table.get::<1>(row, "t")[0];
        let error = |n: u32| {
            let dt = total / f64::from(n);
            let middle = |i: u32| dt * (f64::from(i) + 0.5);
            let samples: Vec<_> = (0..n).map(|i| (w + dw * middle(i), a + da * middle(i))).collect();
            let x = sum(&samples, dt, ImuBias::zero(), QUIET).increment();
            (x.position() - table.get::<3>(row, "p")).norm()
                + (x.velocity() - table.get::<3>(row, "v")).norm()
        };
        let order = (error(32) / error(64)).log2();
        assert!((order - 2.0).abs() < 0.05, "row {row}: order {order:.3}");
    }
}

/// Forster et al. (2017) as printed: rotation of a sample's start, additive corrections. δp, δv in the frame of Δ.
struct Forster {
    r: SO3,
    v: Vector3<f64>,
    p: Vector3<f64>,
    d_r: Matrix3<f64>,
    d_v: [Matrix3<f64>; 2],
    d_p: [Matrix3<f64>; 2],
    covariance: SMatrix<f64, 9, 9>,
}

fn forster(samples: &[Sample], dt: f64, bias: ImuBias, noise: ImuNoise) -> Forster {
    let z = Matrix3::zeros();
    let mut s = Forster {
        r: SO3::identity(),
        v: Vector3::zeros(),
        p: Vector3::zeros(),
        d_r: z,
        d_v: [z; 2],
        d_p: [z; 2],
        covariance: SMatrix::zeros(),
    };
    for (gyro, accel) in samples {
        let (w, a) = (gyro - bias.gyro(), accel - bias.accel());
        let r = s.r.to_matrix();
        let turned = r * SO3::hat(&a);
        let back = SO3::exp(&(w * -dt)).to_matrix();
        let jr = SO3::right_jacobian(&(w * dt));
        // Order (δφ, δv, δp).
        let mut big_a = SMatrix::<f64, 9, 9>::identity();
        big_a.fixed_view_mut::<3, 3>(0, 0).copy_from(&back);
        big_a.fixed_view_mut::<3, 3>(3, 0).copy_from(&(-turned * dt));
        big_a.fixed_view_mut::<3, 3>(6, 0).copy_from(&(-turned * (dt * dt / 2.0)));
        big_a.fixed_view_mut::<3, 3>(6, 3).copy_from(&(Matrix3::identity() * dt));
        let mut b = SMatrix::<f64, 9, 6>::zeros();
        b.fixed_view_mut::<3, 3>(0, 0).copy_from(&(jr * dt));
        b.fixed_view_mut::<3, 3>(3, 3).copy_from(&(r * dt));
        b.fixed_view_mut::<3, 3>(6, 3).copy_from(&(r * (dt * dt / 2.0)));
        let (g, f) = (noise.gyro * noise.gyro / dt, noise.accel * noise.accel / dt);
        let q = SMatrix::<f64, 6, 6>::from_diagonal(&SVector::from([g, g, g, f, f, f]));
        s.covariance = big_a * s.covariance * big_a.transpose() + b * q * b.transpose();
        s.d_p[1] += s.d_v[1] * dt - r * (dt * dt / 2.0);
        s.d_p[0] += s.d_v[0] * dt - turned * s.d_r * (dt * dt / 2.0);
        s.d_v[1] -= r * dt;
        s.d_v[0] -= turned * s.d_r * dt;
        s.d_r = back * s.d_r - jr * dt;
        s.p += s.v * dt + s.r.act(&a) * (dt * dt / 2.0);
        s.v += s.r.act(&a) * dt;
        s.r = s.r.rplus(&(w * dt));
    }
    s
}

#[test]
fn short_samples_give_the_sums_jacobians_and_covariance_of_forster_et_al() {
    // A smooth motion sampled ever finer: the difference of the two is of the order of the sample time.
    let at = |t: f64| (draw::<3>(1) * (2.0 * t).sin() + draw::<3>(2), draw::<3>(3) * 4.0 * (3.0 * t).cos());
    let gap = |n: u32| {
        let dt = 0.5 / f64::from(n);
        let samples: Vec<_> = (0..n).map(|i| at(dt * f64::from(i))).collect();
        let (about, noise) = (bias(5, 0.02, 0.1), ImuNoise { gyro: 0.02, accel: 0.1 });
        let (ours, theirs) = (sum(&samples, dt, about, noise), forster(&samples, dt, about, noise));
        // Ours (ρ, φ, ν) in the frame of the end, theirs (φ, v, p) with v and p in the frame of the start.
        let r = ours.increment().rotation().to_matrix();
        let mut change = SMatrix::<f64, 9, 9>::zeros();
        change.fixed_view_mut::<3, 3>(0, 3).copy_from(&Matrix3::identity());
        change.fixed_view_mut::<3, 3>(3, 6).copy_from(&r);
        change.fixed_view_mut::<3, 3>(6, 0).copy_from(&r);
        let d = change * ours.d_increment_d_bias();
        let mut d_theirs = SMatrix::<f64, 9, 6>::zeros();
        d_theirs.fixed_view_mut::<3, 3>(0, 0).copy_from(&theirs.d_r);
        for k in 0..2 {
            d_theirs.fixed_view_mut::<3, 3>(3, 3 * k).copy_from(&theirs.d_v[k]);
            d_theirs.fixed_view_mut::<3, 3>(6, 3 * k).copy_from(&theirs.d_p[k]);
        }
        let covariance = change * ours.covariance() * change.transpose();
        let x = ours.increment();
        [
            x.rotation().rminus(&theirs.r).norm(),
            (x.velocity() - theirs.v).norm() + (x.position() - theirs.p).norm(),
            (d - d_theirs).norm() / d.norm(),
            (covariance - theirs.covariance).norm() / covariance.norm(),
        ]
    };
    let (coarse, fine) = (gap(100), gap(1000));
    assert!(coarse[0] < 16.0 * EPS, "rotations are the same");
    for (name, i) in [("sums", 1), ("bias Jacobian", 2), ("covariance", 3)] {
        assert!(
            fine[i] < 3e-3 && (coarse[i] / fine[i] - 10.0).abs() < 1.0,
            "{name}: {:.2e}, {:.2e}",
            coarse[i],
            fine[i]
        );
    }
}

/// Mean errors of R, v and p over 200 motions of 50 samples of 10 ms, for |δb| of 0.01·scale rad/s and 0.1·scale m/s²:
/// uncorrected, corrected on the group, and corrected as Forster et al. do (against their own sums).
fn after_a_change_of_bias(scale: f64) -> [[f64; 3]; 3] {
    let mut means = [[0.0; 3]; 3];
    for seed in 0..200 {
        let samples = shaken(seed, 50);
        let delta = bias(seed, 0.01 * scale, 0.1 * scale);
        let ours = sum(&samples, 0.01, ImuBias::zero(), QUIET);
        let truth = sum(&samples, 0.01, delta, QUIET).increment();
        let theirs = forster(&samples, 0.01, ImuBias::zero(), QUIET);
        let their_truth = forster(&samples, 0.01, delta, QUIET);
        let additive = [
            theirs.r.rplus(&(theirs.d_r * delta.gyro())).rminus(&their_truth.r),
            theirs.v + theirs.d_v[0] * delta.gyro() + theirs.d_v[1] * delta.accel() - their_truth.v,
            theirs.p + theirs.d_p[0] * delta.gyro() + theirs.d_p[1] * delta.accel() - their_truth.p,
        ];
        let error = |x: &SE23| {
            let turn = x.rotation().rminus(&truth.rotation());
            [turn, x.velocity() - truth.velocity(), x.position() - truth.position()]
        };
        let all: [[Vector3<f64>; 3]; 3] =
            [error(&ours.increment()), error(&ours.corrected(&delta)), additive];
        for (mean, errors) in means.iter_mut().zip(all) {
            for (mean, error) in mean.iter_mut().zip(errors) {
                *mean += error.norm() / 200.0;
            }
        }
    }
    means
}

#[test]
fn correcting_a_bias_leaves_an_error_of_second_order() {
    let ([uncorrected, corrected, additive], [_, tenth, _]) =
        (after_a_change_of_bias(1.0), after_a_change_of_bias(0.1));
    println!("uncorrected {uncorrected:?}, corrected {corrected:?}, additive {additive:?}");
    for i in 0..3 {
        // J8 of the theory notes, one set of motions there: 5.0e-3, 5.0e-2, 1.25e-2, then 2.2e-7, 9.6e-5, 1.6e-5.
        let known = [[5.0e-3, 5.0e-2, 1.25e-2][i], [2.2e-7, 9.6e-5, 1.6e-5][i]];
        assert!((uncorrected[i] / known[0] - 1.0).abs() < 0.05, "uncorrected {i}: {:.2e}", uncorrected[i]);
        assert!((additive[i] / known[1]).ln().abs() < 1.5_f64.ln(), "additive {i}: {:.2e}", additive[i]);
        assert!(corrected[i] < 1.001 * additive[i], "on the group {i}: {:.2e}", corrected[i]);
        assert!((corrected[i] / tenth[i] / 100.0 - 1.0).abs() < 0.1, "quadratic {i}: {:.2e}", tenth[i]);
    }
}

#[test]
fn covariance_is_that_of_simulated_samples() {
    let noise = ImuNoise { gyro: 0.01, accel: 0.05 };
    let (samples, dt) = (shaken(3, 40), 0.01);
    let clean = sum(&samples, dt, ImuBias::zero(), noise);
    let errors: Vec<SVector<f64, 9>> = (0..6000)
        .map(|run: u64| {
            let noisy: Vec<_> = samples
                .iter()
                .enumerate()
                .map(|(i, (w, a))| {
                    let n = normal::<6>(1_000_000 + run * 64 + i as u64) / dt.sqrt();
                    (w + n.fixed_rows::<3>(0) * noise.gyro, a + n.fixed_rows::<3>(3) * noise.accel)
                })
                .collect();
            sum(&noisy, dt, ImuBias::zero(), noise).increment().rminus(&clean.increment())
        })
        .collect();
    agrees_with_samples(&clean.covariance(), &errors);
}

#[test]
fn a_prediction_has_no_residual_and_obeys_the_laws_of_falling() {
    let from = SE23::exp(&draw(1));
    let pre = sum(&shaken(4, 30), 0.02, bias(2, 0.02, 0.2), QUIET);
    let about = bias(6, 0.03, 0.1);
    let to = pre.predict(&from, &about, &GRAVITY);
    close("r", &pre.residual(&from, &to, &about, &GRAVITY), &SVector::zeros(), 64.0 * EPS);
    let (t, x) = (pre.duration(), pre.corrected(&about));
    close(
        "v",
        &to.velocity(),
        &(from.velocity() + GRAVITY * t + from.rotation().act(&x.velocity())),
        16.0 * EPS,
    );
    let p =
        from.position() + from.velocity() * t + GRAVITY * (t * t / 2.0) + from.rotation().act(&x.position());
    close("p", &to.position(), &p, 16.0 * EPS);
}

#[test]
fn the_residual_of_two_states_is_the_error_of_the_increment() {
    // So that Σ needs no Jacobian of its own: a state moved by ξ after the prediction has the residual ξ.
    let (from, about) = (SE23::exp(&draw(1)), ImuBias::zero());
    let pre = sum(&shaken(4, 30), 0.02, about, QUIET);
    let xi = draw::<9>(7) * 0.4;
    let to = pre.predict(&from, &about, &GRAVITY).rplus(&xi);
    close("r", &pre.residual(&from, &to, &about, &GRAVITY), &xi, 64.0 * EPS);
}

#[test]
fn sums_join_in_order() {
    let (samples, about) = (shaken(5, 40), bias(1, 0.01, 0.1));
    let whole = sum(&samples, 0.01, about, QUIET);
    let joined = sum(&samples[..17], 0.01, about, QUIET).then(&sum(&samples[17..], 0.01, about, QUIET));
    same("Δ", &joined.increment(), &whole.increment(), 128.0 * EPS);
    close("T", &nalgebra::vector![joined.duration()], &nalgebra::vector![0.4], 16.0 * EPS);
    close("Σ", &(joined.covariance() * 1e6), &(whole.covariance() * 1e6), 256.0 * EPS);
    close("D", &joined.d_increment_d_bias(), &whole.d_increment_d_bias(), 128.0 * EPS);
}

#[test]
fn bad_samples_are_refused_and_change_nothing() {
    let mut pre = sum(&shaken(6, 3), 0.01, ImuBias::zero(), QUIET);
    let (before, ok, bad) = (pre, Vector3::zeros(), Vector3::new(0.0, f64::NAN, 0.0));
    assert_eq!(pre.push(&bad, &ok, 0.01), Err(TrajectoryError::NotFinite { index: 0 }));
    assert_eq!(pre.push(&ok, &bad, 0.01), Err(TrajectoryError::NotFinite { index: 1 }));
    for duration in [0.0, -0.01, f64::INFINITY] {
        assert_eq!(pre.push(&ok, &ok, duration), Err(TrajectoryError::NotADuration { duration }));
    }
    assert!(matches!(pre.push(&ok, &ok, f64::NAN), Err(TrajectoryError::NotADuration { .. })));
    assert_eq!(pre, before);
    let negative = ImuNoise { gyro: -1.0, accel: 1.0 };
    let refused = Preintegration::new(ImuBias::zero(), negative);
    assert_eq!(refused, Err(TrajectoryError::NotADensity { density: -1.0 }));
}

#[test]
fn single_precision_agrees_with_double() {
    let samples = shaken(7, 50);
    let double = sum(&samples, 0.01, ImuBias::zero(), QUIET);
    let noise = ImuNoise { gyro: 2e-3_f32, accel: 2e-2 };
    let mut single = Preintegration::<f32>::new(ImuBias::zero(), noise).unwrap();
    for (w, a) in &samples {
        single.push(&w.map(|x| x as f32), &a.map(|x| x as f32), 0.01).unwrap();
    }
    close("Δ", &single.increment().log().map(f64::from), &double.increment().log(), 1e-5);
    let scale = 1.0 / double.covariance().amax();
    close("Σ", &(single.covariance().map(f64::from) * scale), &(double.covariance() * scale), 1e-4);
}

#[cfg(feature = "autodiff")]
mod dual {
    use super::*;

    const BOUND: f64 = 2000.0 * EPS;

    fn sum_dual<const N: usize>(samples: &[Sample], bias: ImuBias<Dual<N>>) -> Preintegration<Dual<N>> {
        let c = Dual::<N>::from_re;
        let mut sum = Preintegration::new(bias, ImuNoise { gyro: c(1e-3), accel: c(1e-2) }).unwrap();
        samples.iter().for_each(|(w, a)| sum.push(&constant(w), &constant(a), c(0.01)).unwrap());
        sum
    }

    fn dual_bias(b: &ImuBias) -> ImuBias<Dual<6>> {
        let v = unknown(&b.vector());
        LieGroup::exp(&v)
    }

    fn fixed_bias<const N: usize>(b: &ImuBias) -> ImuBias<Dual<N>> {
        LieGroup::exp(&constant(&b.vector()))
    }

    #[test]
    fn the_bias_jacobian_is_the_derivative_of_the_whole_sum() {
        let (samples, about) = (shaken(8, 50), bias(3, 0.05, 0.3));
        let closed = sum(&samples, 0.01, about, QUIET);
        let dual = sum_dual(&samples, dual_bias(&about));
        let x = closed.increment();
        close("D", &closed.d_increment_d_bias(), &local::<SE23, 9, 6>(&dual.increment(), &x), BOUND);
    }

    #[test]
    fn residual_and_prediction_have_the_derivatives_of_dual_numbers() {
        let (samples, about, now) = (shaken(9, 30), bias(3, 0.05, 0.3), bias(5, 0.08, 0.2));
        let pre = sum(&samples, 0.01, about, QUIET);
        let from = SE23::exp(&draw(1));
        let to = pre.predict(&from, &about, &GRAVITY).rplus(&(draw::<9>(2) * 0.3));
        let (r, d_from, d_to, d_bias, d_gravity) = pre.residual_jac(&from, &to, &now, &GRAVITY);
        assert_eq!(r, pre.residual(&from, &to, &now, &GRAVITY));
        let (value, p_from, p_bias, p_gravity) = pre.predict_jac(&from, &now, &GRAVITY);
        same("value", &value, &pre.predict(&from, &now, &GRAVITY), 0.0);

        let nine = sum_dual::<9>(&samples, fixed_bias(&about));
        let (lifted_to, g, b) = (lift::<SE23, 9, 9>(&to), constant(&GRAVITY), fixed_bias(&now));
        let moved_from = moved(&from);
        close("from", &d_from, &derivatives(&nine.residual(&moved_from, &lifted_to, &b, &g)), BOUND);
        let lifted = lift::<SE23, 9, 9>(&from);
        close("to", &d_to, &derivatives(&nine.residual(&lifted, &moved(&to), &b, &g)), BOUND);
        close(
            "predicted, from",
            &p_from,
            &local::<SE23, 9, 9>(&nine.predict(&moved_from, &b, &g), &value),
            BOUND,
        );

        let six = sum_dual::<6>(&samples, fixed_bias(&about));
        let (from, to, g) = (lift::<SE23, 9, 6>(&from), lift::<SE23, 9, 6>(&to), constant(&GRAVITY));
        close("bias", &d_bias, &derivatives(&six.residual(&from, &to, &dual_bias(&now), &g)), BOUND);
        let predicted = six.predict(&from, &dual_bias(&now), &g);
        close("predicted, bias", &p_bias, &local::<SE23, 9, 6>(&predicted, &value), BOUND);

        let (three, g) = (sum_dual::<3>(&samples, fixed_bias(&about)), unknown(&GRAVITY));
        let (from, to, now) =
            (from.map(|x| Dual::from_re(x.re)), to.map(|x| Dual::from_re(x.re)), fixed_bias(&now));
        close("gravity", &d_gravity, &derivatives(&three.residual(&from, &to, &now, &g)), BOUND);
        let predicted = three.predict(&from, &now, &g);
        close("predicted, gravity", &p_gravity, &local::<SE23, 9, 3>(&predicted, &value), BOUND);
    }
}
