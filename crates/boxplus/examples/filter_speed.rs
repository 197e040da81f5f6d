//! How long does a step take? Nanoseconds of a prediction and of an update, on one core; run with `--release`.
#![expect(clippy::print_stdout, reason = "an example talks")]

use boxplus::filter::{
    Ekf, Filter, FilterError, Imu, ImuNoise, Inertial, InertialState, Measurement, Motion, Odometry, Part,
    PositionFix, RangeBearing, Ukf,
};
use boxplus::lie::{LieGroup, SE2};
use boxplus::uncertainty::{Covariance, Gaussian, Global, Side};
use nalgebra::{SVector, Vector3, vector};
use std::hint::black_box;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let odometry = Odometry { noise: Covariance::from_sigmas(&vector![0.02, 0.01, 0.01])? };
    let noise = Covariance::from_sigmas(&vector![0.1, 0.05])?;
    let seen = RangeBearing { beacon: vector![9.0, 1.0], measured: vector![9.0, 0.1], noise };
    let pose = Gaussian::<SE2, 3>::from_sigmas(SE2::identity(), &vector![0.1, 0.1, 0.1])?;
    println!("range and bearing on SE(2), 3 coordinates (ns: predict, update)");
    let u = vector![0.1, 0.0, 0.01];
    measure("extended", &Ekf::default(), &pose, &odometry, &u, &seen)?;
    measure("extended, global", &Ekf::default(), &pose.to_global(), &odometry, &u, &seen)?;
    measure("iterated", &Ekf::iterated(), &pose, &odometry, &u, &seen)?;
    measure("unscented", &Ukf::default(), &pose, &odometry, &u, &seen)?;

    let noise =
        ImuNoise { gyroscope: 1e-3, accelerometer: 1e-2, gyroscope_bias: 1e-5, accelerometer_bias: 1e-4 };
    let model = Inertial::upright(noise);
    let imu =
        Imu { gyroscope: vector![0.1, 0.0, 0.2], accelerometer: vector![0.0, 0.1, 9.8], duration: 0.01 };
    let gnss = Part {
        measurement: PositionFix::of_origin(
            vector![0.1, 0.0, 0.0],
            Covariance::from_sigmas(&Vector3::repeat(0.5))?,
        ),
        of: |x: &InertialState| x.motion,
        block: InertialState::BLOCKS.motion,
    };
    let start =
        Gaussian::<InertialState, 15>::from_sigmas(InertialState::identity(), &SVector::repeat(0.05))?;
    println!("inertial navigation with biases and GNSS, 15 coordinates");
    measure("extended", &Ekf::default(), &start, &model, &imu, &gnss)?;
    measure::<_, Global, _, _, _, 15, 12, 3>(
        "invariant",
        &Ekf::default(),
        &start.to_global(),
        &model,
        &imu,
        &gnss,
    )?;
    measure("unscented", &Ukf::default(), &start, &model, &imu, &gnss)?;
    Ok(())
}

fn measure<G, E, F, M, Z, const D: usize, const W: usize, const N: usize>(
    name: &str,
    filter: &F,
    belief: &Gaussian<G, D, E>,
    motion: &M,
    input: &M::Input,
    measurement: &Z,
) -> Result<(), FilterError>
where
    G: LieGroup<D>,
    E: Side,
    F: Filter,
    M: Motion<G, D, W>,
    Z: Measurement<G, D, N>,
{
    const STEPS: u32 = 20_000;
    let start = Instant::now();
    for _ in 0..STEPS {
        black_box(filter.predict(black_box(belief), motion, input)?);
    }
    let predicted = start.elapsed() / STEPS;
    let start = Instant::now();
    for _ in 0..STEPS {
        black_box(filter.update(black_box(belief), measurement));
    }
    let updated = start.elapsed() / STEPS;
    println!("  {name:18} {:8} {:8}", predicted.as_nanos(), updated.as_nanos());
    Ok(())
}
