//! Bundles, written as an outsider: structs of one's own that are groups, block by block.
#![allow(missing_docs, clippy::unwrap_used)]

use boxplus::bundle;
use boxplus::lie::{Block, Jacobian, LieGroup, R3xSO3, Rn, SE2, SE3, SO2, SO3, Sim3, Tangent, laws};
use nalgebra::{SMatrix, SVector, Vector3};
use proptest::prelude::*;

bundle! {
    /// What an inertial sensor shows at rest.
    struct Biases { accelerometer: Rn<3> [3], gyroscope: Rn<3> [3] }
}

bundle! {
    /// A robot with a camera whose scale drifts.
    struct Robot {
        /// world_from_body.
        pose: boxplus::lie::SE3 [6],
        biases: Biases [6],
        /// map_from_world.
        map: Sim3 [7],
        wheel: SO2 [1],
        clock: Rn<2> [2],
    }
}
const N: usize = 22;

bundle! {
    struct One { only: SE2 [3] }
}

bundle! {
    struct Many {
        a: SO2 [1], b: SO2 [1], c: SO2 [1], d: SO2 [1], e: SO2 [1], f: SO2 [1], g: SO2 [1], h: SO2 [1],
        i: SE2 [3], j: SE2 [3], k: SO3 [3], l: Rn<3> [3], m: Biases [6],
    }
}

#[test]
fn a_bundle_passes_the_laws_in_one_line() {
    laws::check_group::<Biases, 6>().unwrap();
    laws::check_group::<Robot, N>().unwrap();
    laws::check_group::<One, 3>().unwrap();
    laws::check_group::<Many, 26>().unwrap();
    laws::check_group::<R3xSO3, 6>().unwrap();
}

#[test]
fn a_bundle_passes_the_laws_in_f32() {
    laws::check_group::<Biases<f32>, 6>().unwrap();
    laws::check_group::<Robot<f32>, N>().unwrap();
    laws::check_group::<R3xSO3<f32>, 6>().unwrap();
}

#[test]
fn blocks_follow_one_another() {
    let b = Robot::BLOCKS;
    let ranges = [b.pose.range(), b.biases.range(), b.map.range(), b.wheel.range(), b.clock.range()];
    assert_eq!(ranges, [0..6, 6..12, 12..19, 19..20, 20..22]);
    assert_eq!(Biases::BLOCKS.gyroscope, Block::new(3));
}

fn tangent<const D: usize>() -> impl Strategy<Value = SVector<f64, D>> {
    prop::collection::vec(-1.5..1.5_f64, D).prop_map(|x| SVector::from_column_slice(&x))
}

fn bits<const R: usize, const C: usize>(m: &SMatrix<f64, R, C>) -> Vec<u64> {
    m.iter().map(|x| x.to_bits()).collect()
}

/// The block of a value that belongs to one field must be what the group of the field computes, and what stands outside the
/// diagonal must be zero.
macro_rules! agrees {
    ($tau:ident, $other:ident, $($field:ident: $group:ty, $d:literal;)*) => {{
        let (x, y) = (Robot::exp(&$tau), Robot::exp(&$other));
        let (tau, right, left) = x.log_jacs();
        let matrices = |z: &Robot, t: &Tangent<f64, N>| -> Vec<Jacobian<f64, N>> {
            vec![
                z.adjoint(),
                Robot::small_adjoint(t),
                Robot::right_jacobian(t),
                Robot::right_jacobian_inverse(t),
                Robot::left_jacobian(t),
                Robot::left_jacobian_inverse(t),
            ]
        };
        let mut outside = matrices(&x, &$tau);
        outside.extend([right, left, Robot::exp_jac(&$tau).1, x.log_jac().1]);
        $({
            let block = Robot::BLOCKS.$field;
            let (t, u) = (block.of(&$tau), block.of(&$other));
            let (p, q) = (<$group>::exp(&t), <$group>::exp(&u));
            assert_eq!(x.$field, p);
            assert_eq!(x.compose(&y).$field, p.compose(&q));
            assert_eq!((x * y).$field, p.compose(&q));
            assert_eq!(x.inverse().$field, p.inverse());
            assert_eq!(x.between(&y).$field, p.between(&q));
            assert_eq!(x.rplus(&$other).$field, p.rplus(&u));
            assert_eq!(x.lplus(&$other).$field, p.lplus(&u));
            assert_eq!(x.interpolate(&y, 0.3).$field, p.interpolate(&q, 0.3));
            assert_eq!(bits(&block.of(&x.log())), bits(&p.log()));
            assert_eq!(bits(&block.of(&x.rminus(&y))), bits(&p.rminus(&q)));
            assert_eq!(bits(&block.of(&x.lminus(&y))), bits(&p.lminus(&q)));
            assert_eq!(bits(&block.of(&x.adjoint_times(&$other))), bits(&p.adjoint_times(&u)));
            let own = [
                p.adjoint(),
                <$group>::small_adjoint(&t),
                <$group>::right_jacobian(&t),
                <$group>::right_jacobian_inverse(&t),
                <$group>::left_jacobian(&t),
                <$group>::left_jacobian_inverse(&t),
            ];
            for (whole, own) in matrices(&x, &$tau).iter().zip(own) {
                assert_eq!(bits(&block.marginal(whole)), bits(&own));
            }
            let (own_tau, own_right, own_left) = p.log_jacs();
            assert_eq!(bits(&block.of(&tau)), bits(&own_tau));
            assert_eq!(bits(&block.marginal(&right)), bits(&own_right));
            assert_eq!(bits(&block.marginal(&left)), bits(&own_left));
            assert_eq!(bits(&block.marginal(&Robot::exp_jac(&$tau).1)), bits(&<$group>::exp_jac(&t).1));
            assert_eq!(bits(&block.marginal(&x.log_jac().1)), bits(&p.log_jac().1));
            outside.iter_mut().for_each(|m| block.set_diagonal(m, &SMatrix::zeros()));
        })*
        assert!(outside.iter().all(|m| m.iter().all(|x| *x == 0.0)));
    }};
}

proptest! {
    #[test]
    fn a_bundle_computes_what_its_fields_compute_to_the_last_bit(
        tau in tangent::<N>(), other in tangent::<N>(),
    ) {
        agrees!(tau, other, pose: SE3, 6; biases: Biases, 6; map: Sim3, 7; wheel: SO2, 1; clock: Rn<2>, 2;);
    }

    #[test]
    fn a_block_is_found_where_it_was_put(tau in tangent::<9>(), part in tangent::<4>()) {
        const BLOCK: Block<4, 9> = Block::new(3);
        const REST: Block<3, 9> = Block::new(0);
        prop_assert_eq!(BLOCK.of(&BLOCK.embed(&part)), part);
        prop_assert_eq!(REST.of(&BLOCK.embed(&part)), Vector3::zeros());
        let mut changed = tau;
        BLOCK.set(&mut changed, &part);
        prop_assert_eq!(BLOCK.of(&changed), part);
        prop_assert_eq!(REST.of(&changed), REST.of(&tau));
        let outer = tau * tau.transpose();
        prop_assert_eq!(BLOCK.marginal(&outer), BLOCK.of(&tau) * BLOCK.of(&tau).transpose());
        prop_assert_eq!(BLOCK.cross(&REST, &outer), BLOCK.of(&tau) * REST.of(&tau).transpose());
        prop_assert_eq!(BLOCK.columns(&tau.transpose()), BLOCK.of(&tau).transpose());
        let mut jacobian = SMatrix::<f64, 1, 9>::zeros();
        BLOCK.set_columns(&mut jacobian, &part.transpose());
        prop_assert_eq!(jacobian.transpose(), BLOCK.embed(&part));
    }

    #[test]
    fn the_pair_and_the_pose_have_one_covariance_in_two_frames(
        tau in tangent::<6>(), delta in tangent::<6>(),
    ) {
        // A step of the pose, as the pair sees it: Log of the difference is J·δ up to δ².
        let (pose, h) = (SE3::exp(&tau), 1e-6);
        let (pair, d_pair_d_pose) = R3xSO3::from_pose_jac(&pose);
        let moved = R3xSO3::from_pose(&pose.rplus(&(delta * h))).rminus(&pair) / h;
        prop_assert!((moved - d_pair_d_pose * delta).norm() < 1e-4);
        let (back, d_pose_d_pair) = pair.pose_jac();
        prop_assert_eq!(back, pose);
        // A quaternion within 2ε of unit norm makes RᵀR − I as large as 8ε; rounding of the entries adds no more.
        prop_assert!((d_pair_d_pose * d_pose_d_pair - SMatrix::identity()).amax() < 16.0 * f64::EPSILON);
        let moved = pair.rplus(&(delta * h)).pose().rminus(&pose) / h;
        prop_assert!((moved - d_pose_d_pair * delta).norm() < 1e-4);
    }
}

#[test]
fn the_pair_of_translation_and_rotation_interpolates_along_a_straight_line_and_the_pose_does_not() {
    let turn = SO3::exp(&Vector3::new(0.0, 0.0, 1.0));
    let (start, end) = (SE3::identity(), SE3::new(turn, Vector3::new(2.0, 0.0, 0.0)));
    let half_way = R3xSO3::from_pose(&start).interpolate(&R3xSO3::from_pose(&end), 0.5);
    assert_eq!(half_way.translation(), Vector3::new(1.0, 0.0, 0.0));
    assert!(start.interpolate(&end, 0.5).translation().y < -0.2);
}

#[test]
fn hat_is_the_tuple_of_the_fields() {
    let tau = SVector::<f64, 6>::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0);
    let (translation, rotation) = R3xSO3::<f64>::hat(&tau);
    assert_eq!(translation, Vector3::new(1.0, 2.0, 3.0));
    assert_eq!(rotation, SO3::hat(&Vector3::new(4.0, 5.0, 6.0)));
}

/// A bundle is a variable of a factor graph by one more line.
#[cfg(feature = "solve")]
mod in_a_graph {
    use super::*;
    use boxplus::graph::{Between, Graph, Noise, Prior, SolveOptions, Values};

    boxplus::variable!(group Biases, Biases<S>, 6, "biases", &["ax", "ay", "az", "gx", "gy", "gz"]);

    #[test]
    fn a_chain_of_bundles_meets_its_measurements() {
        let (mut graph, mut values) = (Graph::new(), Values::new());
        let first = R3xSO3::exp(&SVector::from([1.0, 0.0, 0.5, 0.1, -0.2, 0.3]));
        let step = R3xSO3::exp(&SVector::from([0.5, 0.2, 0.0, 0.0, 0.3, 0.1]));
        let keys = [0, 1, 2].map(|i| values.insert(R3xSO3::exp(&SVector::from([0.1 * f64::from(i); 6]))));
        graph.add((keys[0],), Prior { mean: first }, Noise::unit());
        graph.add((keys[0], keys[1]), Between::new(step), Noise::unit());
        graph.add((keys[1], keys[2]), Between::new(step), Noise::unit());
        let biases = values.insert(Biases::identity());
        let at_rest = Biases::exp(&SVector::from([0.01, 0.02, 0.03, 0.04, 0.05, 0.06]));
        graph.add((biases,), Prior { mean: at_rest }, Noise::unit());
        let solved = graph.optimize(&values, &SolveOptions::default()).unwrap().values;
        let last = *solved.get(keys[2]).unwrap();
        assert!(last.rminus(&(first * step * step)).norm() < 1e-9, "{last:?}");
        assert!(solved.get(biases).unwrap().rminus(&at_rest).norm() < 1e-12);
    }
}
