//! Tangents of other libraries: orders against numbers that these libraries computed, and sides against definitions.
#![allow(missing_docs, clippy::unwrap_used)]

use boxplus::lie::orders::{Order, barrau, gtsam, kelly, lgmath, manif, ros, sophus};
use boxplus::lie::{LeftJacobians, LieGroup, SE2, SE3, SE23, SGal3, SO3, Sim2, Sim3};
use nalgebra::{Matrix6, SMatrix, SVector, Vector3, Vector6};
use proptest::prelude::*;

/// One row of `tangent_orders.csv`: what a library says of the Exp of a tangent in its own order.
struct Row<'a> {
    name: String,
    columns: Vec<&'a str>,
}

const TANGENT: usize = 2;
const ROTATION: usize = 3;
const POSITION: usize = 4;
const VELOCITY: usize = 5;
const LAST: usize = 6;
const ADJOINT: usize = 7;

impl Row<'_> {
    fn numbers(&self, column: usize) -> Vec<f64> {
        self.columns[column].split_whitespace().map(|x| x.parse().unwrap()).collect()
    }

    /// The group element of the tangent, whose adjoint must be the library's.
    fn element<G: LieGroup<D, Scalar = f64>, const D: usize>(&self, order: Order<D>) -> G {
        let theirs = SVector::<f64, D>::from_column_slice(&self.numbers(TANGENT));
        let x = G::exp(&order.to_ours(&theirs));
        assert!((order.to_theirs(&x.log()) - theirs).amax() < 1e-14, "{}: Log", self.name);
        let adjoint = order.matrix_to_theirs(&x.adjoint());
        self.agrees(ADJOINT, adjoint.transpose().as_slice());
        x
    }

    /// Tangents are below 3, so that 1e-14 is a few dozen roundings; a wrong order is wrong by 0.01 at least.
    fn agrees(&self, column: usize, ours: &[f64]) {
        let theirs = self.numbers(column);
        if theirs.is_empty() {
            return;
        }
        assert_eq!(theirs.len(), ours.len(), "{}", self.name);
        for (a, b) in theirs.iter().zip(ours) {
            assert!((a - b).abs() < 1e-14, "{}, column {column}: {theirs:?} is not {ours:?}", self.name);
        }
    }

    fn space(&self, rotation: SO3, position: Vector3<f64>) {
        self.agrees(ROTATION, rotation.to_matrix().transpose().as_slice());
        self.agrees(POSITION, position.as_slice());
    }

    fn pose(&self, order: Order<6>) {
        let x: SE3 = self.element(order);
        self.space(x.rotation(), x.translation());
    }

    fn planar_pose(&self, order: Order<3>) {
        let x: SE2 = self.element(order);
        self.agrees(ROTATION, x.rotation().to_matrix().transpose().as_slice());
        self.agrees(POSITION, x.translation().as_slice());
    }

    fn extended_pose(&self, order: Order<9>) {
        let x: SE23 = self.element(order);
        self.space(x.rotation(), x.position());
        self.agrees(VELOCITY, x.velocity().as_slice());
    }

    fn galilean(&self, order: Order<10>) {
        let x: SGal3 = self.element(order);
        self.space(x.rotation(), x.position());
        self.agrees(VELOCITY, x.velocity().as_slice());
        self.agrees(LAST, &[x.time()]);
    }
}

#[test]
fn exp_and_ad_of_other_libraries_are_ours_in_their_order() {
    let text = include_str!("reference/tangent_orders.csv");
    let mut rows = 0;
    for line in text.lines().skip(1) {
        let columns: Vec<&str> = line.split(',').collect();
        let row = Row { name: columns[..2].join("::"), columns };
        match row.name.as_str() {
            "gtsam::Pose2" => row.planar_pose(gtsam::POSE2),
            "gtsam::Pose3" => row.pose(gtsam::POSE3),
            "gtsam::NavState" => row.extended_pose(gtsam::NAV_STATE),
            "gtsam::Gal3" => row.galilean(gtsam::GAL3),
            "gtsam::Similarity2" => {
                let x: Sim2 = row.element(gtsam::SIMILARITY2);
                row.agrees(ROTATION, x.rotation().to_matrix().transpose().as_slice());
                row.agrees(POSITION, x.translation().as_slice());
                row.agrees(LAST, &[x.log_scale()]);
            }
            "gtsam::Similarity3" => {
                let x: Sim3 = row.element(gtsam::SIMILARITY3);
                row.space(x.rotation(), x.translation());
                row.agrees(LAST, &[x.log_scale()]);
            }
            "manif::SE2" => row.planar_pose(manif::SE2),
            "manif::SE3" => row.pose(manif::SE3),
            "manif::SE_2_3" => row.extended_pose(manif::SE_2_3),
            "manif::SGal3" => row.galilean(manif::SGAL3),
            "sophus::SE2" => row.planar_pose(sophus::SE2),
            "sophus::SE3" => row.pose(sophus::SE3),
            "lgmath::SE3" => row.pose(lgmath::SE3),
            other => panic!("no order for {other}"),
        }
        rows += 1;
    }
    assert_eq!(rows, 52);
}

/// Every constant, as a claim about blocks: names of coordinates in the order of the library.
#[test]
fn orders_are_those_of_the_papers() {
    let extended = SVector::from([1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 3.0, 3.0, 3.0]); // ρ = 1, φ = 2, ν = 3
    let galilean = extended.push(4.0); // ι = 4
    let blocks = |t: &[f64]| t.chunks(3).map(|b| b[0]).collect::<Vec<_>>();
    assert_eq!(blocks(barrau::SE23.to_theirs(&extended).as_slice()), [2.0, 3.0, 1.0]); // (φ, ν, ρ)
    assert_eq!(
        blocks(barrau::SE3.to_theirs(&Vector6::new(1.0, 1.0, 1.0, 2.0, 2.0, 2.0)).as_slice()),
        [2.0, 1.0]
    );
    assert_eq!(blocks(kelly::SGAL3.to_theirs(&galilean).as_slice()), [1.0, 3.0, 2.0, 4.0]); // (ρ, ν, φ, ι)
    assert_eq!((sophus::SIM2, sophus::SIM3, ros::TWIST), (Order::same(), Order::same(), Order::same()));
}

fn numbers<const R: usize, const C: usize>() -> impl Strategy<Value = SMatrix<f64, R, C>> {
    prop::collection::vec(-1.0..1.0_f64, R * C).prop_map(|x| SMatrix::from_column_slice(&x))
}

fn comes_back<const D: usize>(order: Order<D>, tau: &SVector<f64, D>, m: &SMatrix<f64, D, D>) {
    assert_eq!(order.to_ours(&order.to_theirs(tau)), *tau);
    assert_eq!(order.to_theirs(&order.to_ours(tau)), *tau);
    assert_eq!(order.matrix_to_ours(&order.matrix_to_theirs(m)), *m);
    assert_eq!(order.matrix_to_theirs(&order.matrix_to_ours(m)), *m);
    assert_eq!(order.rows_to_ours(&order.rows_to_theirs(m)), *m);
    assert_eq!(order.columns_to_ours(&order.columns_to_theirs(m)), *m);
    assert_eq!(order.inverse().inverse(), order);
    let p = order.permutation::<f64>();
    assert_eq!(p * tau, order.to_theirs(tau));
    assert_eq!(p * m * p.transpose(), order.matrix_to_theirs(m));
    assert_eq!(p * m, order.rows_to_theirs(m));
    assert_eq!(m * p.transpose(), order.columns_to_theirs(m));
}

proptest! {
    #[test]
    fn there_and_back_is_exact(
        t3 in numbers::<3, 1>(), m3 in numbers::<3, 3>(), t4 in numbers::<4, 1>(), m4 in numbers::<4, 4>(),
        t6 in numbers::<6, 1>(), m6 in numbers::<6, 6>(), t7 in numbers::<7, 1>(), m7 in numbers::<7, 7>(),
        t9 in numbers::<9, 1>(), m9 in numbers::<9, 9>(), t10 in numbers::<10, 1>(), m10 in numbers::<10, 10>(),
    ) {
        for o in [gtsam::POSE2, manif::SE2, sophus::SE2] { comes_back(o, &t3, &m3); }
        for o in [gtsam::SIMILARITY2, sophus::SIM2] { comes_back(o, &t4, &m4); }
        for o in [gtsam::POSE3, manif::SE3, sophus::SE3, lgmath::SE3, barrau::SE3, ros::TWIST] { comes_back(o, &t6, &m6); }
        for o in [gtsam::SIMILARITY3, sophus::SIM3] { comes_back(o, &t7, &m7); }
        for o in [gtsam::NAV_STATE, manif::SE_2_3, barrau::SE23] { comes_back(o, &t9, &m9); }
        for o in [gtsam::GAL3, manif::SGAL3, kelly::SGAL3] { comes_back(o, &t10, &m10); }
    }

    #[test]
    fn a_covariance_on_the_left_of_an_inverse_is_that_on_the_right(tau in numbers::<6, 1>(), delta in numbers::<6, 1>()) {
        // Barfoot's T = vehicle_from_inertial: (Exp(ε)·T)⁻¹ = T⁻¹·Exp(−ε).
        let t = SE3::exp(&tau);
        prop_assert!(t.lplus(&delta).inverse().rminus(&t.inverse().rplus(&-delta)).norm() < 64.0 * f64::EPSILON);
    }

    #[test]
    fn a_covariance_changes_sides_as_its_samples_do(tau in numbers::<6, 1>(), delta in numbers::<6, 1>()) {
        // One sample δ has the covariance δδᵀ; on the left the same sample is Ad·δ, and X·Exp(δ) = Exp(Ad·δ)·X.
        let x = SE3::exp(&tau);
        let left = x.rplus(&delta).lminus(&x);
        prop_assert!((x.covariance_to_left(&(delta * delta.transpose())) - left * left.transpose()).amax() < 1e-13);
        let m = delta * tau.transpose();
        prop_assert!((x.covariance_to_right(&x.covariance_to_left(&m)) - m).amax() < 1e-13);
    }

    #[test]
    fn a_ros_covariance_is_that_of_shifts_and_turns_about_the_axes_of_the_parent(
        tau in numbers::<6, 1>(), delta in numbers::<6, 1>(),
    ) {
        // Small δ = (δt, δθ) as the message defines it: t + δt, then turns about the fixed axes X, Y, Z.
        let (pose, h) = (SE3::exp(&tau), 1e-5);
        let about = |i: usize| SO3::exp(&(Vector3::ith(i, delta[3 + i] * h)));
        let turned = about(2) * about(1) * about(0) * pose.rotation();
        let moved = SE3::new(turned, pose.translation() + delta.fixed_rows::<3>(0) * h);
        let ours = moved.rminus(&pose) / h;
        let message = ros::pose_covariance_to_theirs(&pose, &(ours * ours.transpose()));
        let expected = delta * delta.transpose();
        // The angles differ from Exp(δθ) in second order: relative h.
        prop_assert!((Matrix6::from_row_slice(&message) - expected).amax() < 20.0 * h);
        let back = ros::pose_covariance_to_ours(&pose, &message);
        prop_assert!((back - ours * ours.transpose()).amax() < 1e-13);
    }
}

#[test]
fn a_ros_covariance_is_read_by_rows() {
    let numbers: [f64; 36] = core::array::from_fn(|i| i as f64);
    let ours = ros::pose_covariance_to_ours(&SE3::identity(), &numbers);
    assert_eq!((ours[(0, 1)], ours[(1, 0)]), (1.0, 6.0));
    assert_eq!(ros::pose_covariance_to_theirs(&SE3::identity(), &ours), numbers);
}

#[test]
#[should_panic(expected = "not a permutation")]
fn what_is_no_permutation_is_refused() {
    let _ = Order::new([0, 2, 2]);
}
