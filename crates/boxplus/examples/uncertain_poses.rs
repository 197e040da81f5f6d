//! How good are the formulas for uncertain poses?
//!
//! Published experiments repeated: each table prints our numbers, with the standard error of the sampling, beside the
//! reference. A count of samples may be given (default 100 000; the references used 20 000 to 4 000 000).
#![expect(clippy::print_stdout, reason = "an example talks")]

use boxplus::lie::{Action, LieGroup, Rn, SE3, SO3};
use boxplus::uncertainty::{
    Covariance, FuseOptions, Gaussian, Global, Local, Order, Pair, SigmaPoints, UncertaintyError, compound,
};
use nalgebra::{Matrix3, Matrix6, SMatrix, SVector, Vector3, Vector4, Vector6, vector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::f64::consts::PI;

type Outcome = Result<(), UncertaintyError>;
type Pose = Gaussian<SE3, 6, Global>;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let samples = std::env::args().nth(1).map_or(Ok(100_000), |count| count.parse())?;
    compounding(samples)?;
    banana()?;
    fusion(samples / 20)?;
    stereo(samples)?;
    correlated(samples)?;
    reset(samples)?;
    rotated_vector(samples)?;
    Ok(())
}

/// Standard normal vectors, the same in every run.
fn white<const N: usize>() -> impl Iterator<Item = SVector<f64, N>> {
    let unit = Gaussian::<Rn<N>, N>::new(Rn::new(SVector::zeros()), Covariance::unit());
    unit.samples(ChaCha8Rng::seed_from_u64(2014)).map(|x| x.vector())
}

/// Sampled mean and covariance, and the Frobenius norms of their standard errors.
struct Moments<const N: usize> {
    mean: SVector<f64, N>,
    mean_error: f64,
    covariance: SMatrix<f64, N, N>,
    covariance_error: f64,
}

impl<const N: usize> Moments<N> {
    /// Of pairs (x, c), c a control variate: the linear part of x, whose covariance is known. Only the rest is sampled.
    fn of(
        control: &SMatrix<f64, N, N>,
        draws: impl Iterator<Item = (SVector<f64, N>, SVector<f64, N>)>,
    ) -> Self {
        let (mut count, mut m1, mut m2) = (0.0, SVector::zeros(), SMatrix::<f64, N, N>::zeros());
        let (mut norm1, mut norm2) = (0.0, 0.0);
        for (x, c) in draws {
            let (first, second) = (x - c, x * x.transpose() - c * c.transpose());
            count += 1.0;
            m1 += first;
            m2 += second;
            norm1 += first.norm_squared();
            norm2 += second.norm_squared();
        }
        let (mean, square) = (m1 / count, m2 / count);
        Self {
            mean,
            mean_error: ((norm1 / count - mean.norm_squared()) / count).sqrt(),
            covariance: control + square - mean * mean.transpose(),
            covariance_error: ((norm2 / count - square.norm_squared()) / count).sqrt(),
        }
    }

    /// The second moment, about zero.
    fn square(&self) -> SMatrix<f64, N, N> {
        self.covariance + self.mean * self.mean.transpose()
    }
}

fn pose(tau: [f64; 6], variances: [f64; 6], alpha: f64) -> Result<Pose, UncertaintyError> {
    Gaussian::from_sigmas(SE3::exp(&tau.into()), &Vector6::from(variances).map(|v| (alpha * v).sqrt()))
}

/// Barfoot & Furgale (2014), figure 3.
fn compounding(samples: usize) -> Outcome {
    println!("Two poses compounded: |Σ − sampled|            (reference in brackets)");
    println!("   α      2nd order         4th order       s.e.");
    let reference = [
        (0.05, 0.0089, 0.0015),
        (0.1, 0.0358, 0.0023),
        (0.25, 0.230, 0.015),
        (0.5, 0.956, 0.105),
        (0.75, 2.160, 0.248),
        (1.0, 3.639, 0.419),
    ];
    for (alpha, second_reference, fourth_reference) in reference {
        let x = pose([0.0, 2.0, 0.0, PI / 6.0, 0.0, 0.0], [10.0, 5.0, 5.0, 0.5, 1.0, 0.5], alpha)?;
        let y = pose([0.0, 0.0, 1.0, PI / 4.0, 0.0, 0.0], [5.0, 10.0, 5.0, 0.5, 0.5, 1.0], alpha)?;
        let mean = x.mean().compose(y.mean());
        let moved = y.covariance().transformed(&x.mean().adjoint());
        let (l1, l2) = (x.covariance().factor(), y.covariance().factor());
        let draws = white::<12>().take(samples).map(|eta| {
            let (a, b) = (l1 * eta.fixed_rows::<6>(0), l2 * eta.fixed_rows::<6>(6));
            let product = x.perturbed(&a).compose(&y.perturbed(&b));
            (product.lminus(&mean), a + x.mean().adjoint() * b)
        });
        let sampled = Moments::of(&(x.covariance().matrix() + moved.matrix()), draws);
        let off = [Order::Second, Order::Fourth].map(|order| {
            let found = compound::<SE3, 6>(x.covariance().matrix(), moved.matrix(), &Matrix6::zeros(), order);
            (found.covariance - sampled.square()).norm()
        });
        let [second, fourth] = off;
        println!(
            "  {alpha:4.2}  {second:7.4} ({second_reference:6.4})  {fourth:7.4} ({fourth_reference:6.4})  {:.4}",
            sampled.covariance_error
        );
    }
    Ok(())
}

/// Barfoot & Furgale (2014), figure 2.
fn banana() -> Outcome {
    println!("\nA hundred steps of 1 m with 0.03 rad of heading noise each");
    let step = pose([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0009], 1.0)?;
    for (order, reference) in
        [(Order::Second, [0.0, 295.515, -4.455, 0.09]), (Order::Fourth, [1.67752, 294.40075, -4.455, 0.09])]
    {
        let mut sigma = Matrix6::zeros();
        for _ in 0..100 {
            let moved = step.mean().adjoint() * sigma * step.mean().adjoint().transpose();
            sigma =
                compound::<SE3, 6>(step.covariance().matrix(), &moved, &Matrix6::zeros(), order).covariance;
        }
        let found = [sigma.m11, sigma.m22, sigma.m26, sigma.m66];
        println!("  {order:?} order: Σxx Σyy Σyθ Σθθ = {found:.5?} ({reference:?})");
    }
    Ok(())
}

/// Barfoot & Furgale (2014), figure 5.
fn fusion(trials: usize) -> Outcome {
    let truth = SE3::exp(&Vector6::new(1.0, 0.0, 0.0, 0.0, 0.0, PI / 6.0));
    let variances =
        [[2.0, 1.0, 1.0, 0.1, 0.2, 0.1], [1.0, 3.0, 1.0, 0.1, 0.1, 0.2], [1.0, 1.0, 5.0, 0.2, 0.1, 0.1]];
    let sensors =
        variances.map(|v| Covariance::from_sigmas(&Vector6::from(v).map(|v: f64| (5.0 * v).sqrt())));
    let [a, b, c] = sensors;
    let sensors = [a?, b?, c?].map(|sigma| Pose::new(truth, sigma));
    let options = FuseOptions { max_iterations: 20, tolerance: 1e-3 };
    let (mut rng, mut cost, mut square, mut converged) = (ChaCha8Rng::seed_from_u64(5), Vec::new(), 0.0, 0);
    for _ in 0..trials {
        let seen = sensors.map(|sensor| Pose::new(sensor.sample(&mut rng), *sensor.covariance()));
        let fused = Pose::fuse_from(&SE3::identity(), &seen, &options)?;
        cost.push(fused.cost);
        square += truth.lminus(fused.estimate.mean()).norm_squared();
        converged += usize::from(fused.converged);
    }
    let n = trials as f64;
    let mean = cost.iter().sum::<f64>() / n;
    let error = (cost.iter().map(|v| (v - mean).powi(2)).sum::<f64>()).sqrt() / n;
    println!("\nThree estimates fused, {trials} trials, all counted");
    println!(
        "  cost {mean:.3} ± {error:.3} (5.782 ± 0.017)   rms pose error {:.3} (2.720 ± 0.008)",
        (square / n).sqrt()
    );
    println!("  settled to 10⁻³ σ within 20 steps: {:.1} %", 100.0 * converged as f64 / n);
    Ok(())
}

/// Barfoot & Furgale (2014), figure 8.
fn stereo(samples: usize) -> Outcome {
    println!("\nA point 10 m away in a stereo camera, pose and point uncertain");
    println!("   α    mean, px: 1st order       2nd order         sigma points      s.e.");
    println!("        covariance, px²: 2nd      4th               sigma points      s.e.");
    let reference = [
        (0.1, [1.616, 0.015, 0.016], [25.6, 20.0, 6.7]),
        (0.5, [8.52, 0.50, 0.15], [715.0, 575.0, 164.0]),
        (1.0, [18.35, 2.31, 0.51], [3687.0, 3129.0, 398.0]),
    ];
    let camera = |errors: &Rn<9>| {
        let errors = errors.vector();
        let moved = SE3::exp(&errors.fixed_rows::<6>(0).into_owned());
        let p = moved.act(&(vector![10.0, 10.0, 10.0] + errors.fixed_rows::<3>(6)));
        Rn::new(Vector4::new(p.x + 0.125, p.y, p.x - 0.125, p.y) * (200.0 / p.z))
    };
    for (alpha, means, covariances) in reference {
        let variances = SVector::from([0.1, 0.1, 0.01, 0.01, 0.01, 0.01, 1.0, 1.0, 1.0]);
        let errors = Gaussian::<Rn<9>, 9>::from_sigmas(
            Rn::new(SVector::zeros()),
            &variances.map(|v: f64| (alpha * v).sqrt()),
        )?;
        let [first, second, fourth] =
            [Order::First, Order::Second, Order::Fourth].map(|order| errors.expanded(camera, order));
        let l = errors.covariance().factor();
        let linear = (errors.covariance().information()? * first.cross).transpose() * l;
        let at_mean = first.mean.vector();
        let draws = white::<9>()
            .take(samples)
            .map(|eta| (camera(&Rn::new(l * eta)).vector() - at_mean, linear * eta));
        let sampled = Moments::of(first.covariance.matrix(), draws);
        let sigma = errors.unscented(camera, &SigmaPoints::default())?;
        let line = |off: [f64; 3], reference: [f64; 3], error: f64| {
            off.iter().zip(reference).for_each(|(x, r)| print!("{:>18}", format!("{x:.3} ({r})")));
            println!("    {error:.3}");
        };
        print!("  {alpha:3.1}  ");
        line(
            [first, second, sigma].map(|t| (t.mean.vector() - at_mean - sampled.mean).norm()),
            means,
            sampled.mean_error,
        );
        print!("       ");
        let off = [second, fourth, sigma].map(|t| (t.covariance.matrix() - sampled.covariance).norm());
        line(off, covariances, sampled.covariance_error);
    }
    Ok(())
}

/// Correlated poses compounded. The reference used a joint covariance of its own: sizes compare, digits do not.
fn correlated(samples: usize) -> Outcome {
    println!("\nCorrelated poses compounded: relative error");
    println!("  scale    2nd order          4th order          correlation ignored    s.e.");
    let factor =
        |k: usize| Matrix6::from_fn(|i, j| 0.12 * ((i * i + 3 * i * j + 5 * k + j * j + 1) as f64).sin());
    for (scale, second_reference, fourth_reference) in
        [(0.1_f64, 0.0048, 0.0010), (0.3, 0.0129, 0.0012), (1.0, 0.0439, 0.0018)]
    {
        let (l1, l2) = (factor(1) * scale.sqrt(), (factor(1) * 0.5 + factor(2) * 0.7) * scale.sqrt());
        let element = |k: f64, l: &Matrix6<f64>| {
            let mean = SE3::exp(&Vector6::from_fn(|i, _| (i as f64 + k).cos()));
            Ok(Gaussian::<SE3, 6>::new(mean, Covariance::new(l * l.transpose())?))
        };
        let pair = Pair::new(element(1.0, &l1)?, element(2.0, &l2)?, l1 * l2.transpose())?;
        let (x, y) = (*pair.first(), *pair.second());
        let mean = x.mean().compose(y.mean());
        let linear = y.mean().inverse().adjoint() * l1 + l2;
        let draws = white::<6>().take(samples).map(|eta| {
            let product = x.perturbed(&(l1 * eta)).compose(&y.perturbed(&(l2 * eta)));
            (product.rminus(&mean), linear * eta)
        });
        let sampled = Moments::of(&(linear * linear.transpose()), draws);
        let truth = sampled.covariance;
        let turned = y.mean().inverse().adjoint();
        let first = x.covariance().transformed(&turned);
        let off = |cross: Matrix6<f64>, order| {
            let found = compound::<SE3, 6>(first.matrix(), y.covariance().matrix(), &cross, order);
            (found.covariance - truth).norm() / truth.norm()
        };
        let cross = turned * pair.cross();
        let off =
            [off(cross, Order::Second), off(cross, Order::Fourth), off(Matrix6::zeros(), Order::Fourth)];
        println!(
            "   {scale:3.1}   {:.4} ({second_reference:.4})    {:.4} ({fourth_reference:.4})    {:.4}                {:.4}",
            off[0],
            off[1],
            off[2],
            sampled.covariance_error / truth.norm()
        );
    }
    Ok(())
}

/// Reset, frame change and parallel transport after a correction of 0.88 rad.
fn reset(samples: usize) -> Outcome {
    let before = Gaussian::<SO3, 3>::from_sigmas(SO3::identity(), &vector![0.05, 0.02, 0.01])?;
    let theta = Vector3::new(0.6, -0.5, 0.4).normalize() * 0.88;
    let after = before.reset(&theta);
    let l = before.covariance().factor();
    let linear = SO3::right_jacobian(&theta) * l;
    let draws = white::<3>()
        .take(samples)
        .map(|eta| (after.error_of(&before.perturbed(&(theta + l * eta))), linear * eta));
    let truth = Moments::of(after.covariance().matrix(), draws);
    let (error, truth) = (truth.covariance_error, truth.covariance);
    println!(
        "\nThe covariance after a correction of 0.88 rad: relative error (s.e. {:.5})",
        error / truth.norm()
    );
    let moves = [
        ("reset", after),
        ("nothing", before),
        ("frame change", before.change_body(&SO3::exp(&theta))),
        ("parallel transport", before.transport(&theta)),
    ];
    for (name, gaussian) in moves {
        println!("  {name:<18} {:.4}", (gaussian.covariance().matrix() - truth).norm() / truth.norm());
    }
    Ok(())
}

/// The mean of a rotation matrix, |found − sampled|.
fn rotated_vector(samples: usize) -> Outcome {
    let sigma = Matrix3::new(0.3, 0.05, -0.02, 0.05, 0.2, 0.04, -0.02, 0.04, 0.1);
    let rotation = Gaussian::<SO3, 3, Local>::new(SO3::identity(), Covariance::new(sigma)?);
    let l = rotation.covariance().factor();
    let entries = |m: Matrix3<f64>| SVector::<f64, 9>::from_iterator(m.iter().copied());
    let draws = white::<3>().take(samples).map(|eta| {
        let c = SO3::exp(&(l * eta)).to_matrix();
        (entries(c), entries(SO3::hat(&(l * eta))))
    });
    let sampled = Moments::of(&SMatrix::zeros(), draws);
    let mean = Matrix3::from_iterator(sampled.mean.iter().copied());
    let [second, fourth] =
        [Order::Second, Order::Fourth].map(|o| (rotation.expected_matrix(o) - mean).norm());
    println!(
        "\nE[C]: 2nd order off by {second:.4} (0.0316), 4th by {fourth:.4} (0.0016), s.e. {:.4}",
        sampled.mean_error
    );
    Ok(())
}
