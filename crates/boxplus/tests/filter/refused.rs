//! Bad input leaves the belief as it was, to the last bit, and says why.

use boxplus::filter::{
    Ekf, Filter, FilterError, Gate, InformationBelief, Odometry, Outcome, Range, RangeBearing, Sighting,
    SquareRootBelief, Ukf,
};
use boxplus::lie::SE2;
use boxplus::uncertainty::{Covariance, Gaussian};
use nalgebra::{Vector2, Vector3, vector};

fn belief() -> Gaussian<SE2, 3> {
    Gaussian::from_sigmas(SE2::new(vector![1.0, 2.0], 0.5), &vector![0.3, 0.2, 0.1]).unwrap()
}

fn sighting(measured: Vector2<f64>, sigma: f64) -> Sighting<2> {
    Sighting {
        landmark: vector![1.0, 2.0],
        measured,
        noise: Covariance::from_sigmas(&Vector2::repeat(sigma)).unwrap(),
    }
}

fn both(check: impl Fn(&dyn Fn(&Gaussian<SE2, 3>, &Sighting<2>) -> (Gaussian<SE2, 3>, Outcome<2>), Gate)) {
    for gate in [Gate::open(), Gate::at(0.999)] {
        check(
            &|belief, z| {
                let update = Ekf::default().gated(gate).update(belief, z);
                (update.belief, update.outcome)
            },
            gate,
        );
        check(
            &|belief, z| {
                let update = Ukf::default().gated(gate).update(belief, z);
                (update.belief, update.outcome)
            },
            gate,
        );
    }
}

#[test]
fn a_value_that_is_not_a_number_is_refused() {
    both(|update, _| {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let (after, outcome) = update(&belief(), &sighting(vector![bad, 0.0], 0.1));
            assert_eq!(outcome, Outcome::Refused(FilterError::MeasurementNotFinite));
            assert_eq!(after, belief());
        }
    });
}

#[test]
fn an_unlikely_value_is_gated_and_its_nis_is_told() {
    both(|update, gate| {
        let (after, outcome) = update(&belief(), &sighting(vector![5.0, 0.0], 0.1));
        match outcome {
            Outcome::Gated(innovation) => {
                assert!(gate != Gate::open() && innovation.nis > 100.0);
                assert_eq!(after, belief());
            }
            Outcome::Accepted(_) => assert_eq!(gate, Gate::open()),
            Outcome::Refused(error) => panic!("{error}"),
        }
    });
}

#[test]
fn an_exact_sensor_of_a_certain_state_is_refused_by_name() {
    both(|update, _| {
        let certain = Gaussian::certain(*belief().mean());
        let (after, outcome) = update(&certain, &sighting(vector![0.0, 0.0], 0.0));
        let Outcome::Refused(error @ FilterError::Singular { .. }) = outcome else { panic!("{outcome:?}") };
        assert_eq!(after, certain);
        assert!(error.to_string().starts_with("the innovation has no variance along 1.00·τ["));
    });
}

#[test]
fn an_exact_sensor_of_an_uncertain_state_is_believed_exactly() {
    both(|update, _| {
        let (after, outcome) = update(&belief(), &sighting(vector![0.1, 0.05], 0.0));
        assert!(matches!(outcome, Outcome::Accepted(_)));
        assert_eq!(after.covariance().rank(), 1);
    });
}

#[test]
fn a_bearing_from_the_beacon_itself_is_refused() {
    let noise = Covariance::from_sigmas(&vector![0.1, 0.1]).unwrap();
    let here = RangeBearing { beacon: belief().mean().translation(), measured: vector![1.0, 0.0], noise };
    let update = Ekf::default().update(&belief(), &here);
    assert_eq!(update.outcome, Outcome::Refused(FilterError::MeasurementNotFinite));
    assert_eq!(update.belief, belief());
    let range = Range {
        beacon: belief().mean().translation(),
        antenna: vector![0.0, 0.0],
        measured: 1.0,
        noise: Covariance::unit(),
    };
    assert!(!Ekf::default().update(&belief(), &range).is_accepted());
}

#[test]
fn an_iterated_filter_that_leaves_the_finite_is_refused() {
    // The first linearisation is fine, its step leads to the beacon of infinite slope or beyond: whatever happens, no NaN.
    let noise = Covariance::from_sigmas(&vector![1e-9]).unwrap();
    for distance in [1e-300, 1e-12, 1e-3, 1e3, 1e300] {
        let range = Range {
            beacon: belief().mean().translation() + vector![distance, 0.0],
            antenna: vector![0.0, 0.0],
            measured: 0.0,
            noise,
        };
        let update = Ekf::iterated().update(&belief(), &range);
        assert!(update.belief.covariance().matrix().iter().all(|x| x.is_finite()), "{distance}");
        assert!(update.belief.mean().translation().iter().all(|x| x.is_finite()), "{distance}");
        if !update.is_accepted() {
            assert_eq!(update.belief, belief());
        }
    }
}

#[test]
fn a_motion_that_is_not_a_number_is_an_error() {
    let odometry = Odometry { noise: Covariance::from_sigmas(&Vector3::repeat(0.1)).unwrap() };
    let bad = vector![f64::NAN, 0.0, 0.0];
    let refused = Ekf::default().predict(&belief(), &odometry, &bad).unwrap_err();
    assert_eq!(refused, FilterError::MotionNotFinite);
    assert_eq!(Ukf::default().predict(&belief(), &odometry, &bad).unwrap_err(), refused);
    let endless = vector![f64::MAX, f64::MAX, 0.3];
    assert!(Ekf::default().predict(&belief(), &odometry, &endless).is_err());
}

#[test]
fn spreads_out_of_reach_are_kept_in_reach() {
    for alpha in [0.0, -1.0, 7.0, f64::INFINITY] {
        let update = Ukf { alpha, ..Ukf::default() }.update(&belief(), &sighting(vector![0.1, 0.0], 0.1));
        assert!(update.is_accepted(), "{alpha}");
        assert!(Covariance::new(*update.belief.covariance().matrix()).is_ok());
    }
}

#[test]
fn noise_that_is_not_a_number_is_refused_and_not_taken_for_none() {
    let refused = Err(FilterError::CovarianceNotFinite);
    for bad in [f64::NAN, f64::INFINITY] {
        let (odometry, step) = (Odometry { noise: Covariance::unit() * bad }, vector![1.0, 0.0, 0.1]);
        assert_eq!(Ekf::default().predict(&belief(), &odometry, &step), refused);
        assert_eq!(Ukf::default().predict(&belief(), &odometry, &step), refused);
        let information = InformationBelief::from_gaussian(&belief()).unwrap();
        assert_eq!(information.predict(&odometry, &step).unwrap_err(), FilterError::CovarianceNotFinite);
        let root = SquareRootBelief::from_gaussian(&belief());
        assert_eq!(root.predict(&odometry, &step).unwrap_err(), FilterError::CovarianceNotFinite);
        let seen = Sighting { noise: Covariance::unit() * bad, ..sighting(vector![0.1, 0.2], 0.1) };
        assert_eq!(information.update(&seen).unwrap_err(), FilterError::CovarianceNotFinite);
        assert_eq!(root.update(&seen).unwrap_err(), FilterError::CovarianceNotFinite);
        for update in [Ekf::default().update(&belief(), &seen), Ukf::default().update(&belief(), &seen)] {
            assert_eq!(update.outcome, Outcome::Refused(FilterError::CovarianceNotFinite));
        }
    }
}
