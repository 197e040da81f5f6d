//! A filter allocates nothing: counted by an allocator that counts.
#![allow(missing_docs, clippy::unwrap_used)]

use boxplus::filter::{
    Ekf, Filter, Imu, ImuNoise, Inertial, InertialState, Odometry, Part, RangeBearing, Sighting, Ukf,
};
use boxplus::lie::{LieGroup, SE2};
use boxplus::uncertainty::{Covariance, Gaussian, Global};
use nalgebra::{SVector, Vector3, vector};

fn planar(filter: &impl Filter) -> f64 {
    let odometry = Odometry { noise: Covariance::from_sigmas(&vector![0.02, 0.01, 0.01]).unwrap() };
    let noise = Covariance::from_sigmas(&vector![0.1, 0.05]).unwrap();
    let mut belief = Gaussian::<SE2, 3>::certain(SE2::identity());
    for _ in 0..50 {
        belief = filter.predict(&belief, &odometry, &vector![0.1, 0.0, 0.01]).unwrap();
        let seen = RangeBearing { beacon: vector![9.0, 1.0], measured: vector![8.0, 0.1], noise };
        belief = filter.update(&belief, &seen).belief;
    }
    belief.sigmas().norm()
}

fn inertial(filter: &impl Filter) -> f64 {
    let noise =
        ImuNoise { gyroscope: 1e-3, accelerometer: 1e-2, gyroscope_bias: 1e-5, accelerometer_bias: 1e-4 };
    let model = Inertial::upright(noise);
    let imu =
        Imu { gyroscope: vector![0.1, 0.0, 0.2], accelerometer: vector![0.0, 0.1, 9.8], duration: 0.01 };
    let start = InertialState::identity();
    let mut belief =
        Gaussian::<InertialState, 15, Global>::from_sigmas(start, &SVector::repeat(0.05)).unwrap();
    for _ in 0..20 {
        belief = filter.predict(&belief, &model, &imu).unwrap();
        let landmark = Part {
            measurement: Sighting {
                landmark: vector![2.0, 1.0, 0.0],
                measured: vector![2.0, 1.0, 0.1],
                noise: Covariance::from_sigmas(&Vector3::repeat(0.1)).unwrap(),
            },
            of: |x: &InertialState| x.motion,
            block: InertialState::BLOCKS.motion,
        };
        belief = filter.update(&belief, &landmark).belief;
    }
    belief.sigmas().norm()
}

#[test]
fn no_step_of_a_filter_allocates() {
    let mut sum = 0.0;
    let filters = allocation_counter::measure(|| {
        sum = planar(&Ekf::default()) + planar(&Ekf::iterated()) + planar(&Ukf::default());
        sum += inertial(&Ekf::default()) + inertial(&Ukf::default());
    });
    assert!(sum.is_finite());
    assert_eq!(filters.count_total, 0);
    // The counter counts.
    assert_eq!(allocation_counter::measure(|| assert!(Box::new(sum).is_finite())).count_total, 1);
}
