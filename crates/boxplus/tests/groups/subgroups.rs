//! Groups as their matrices, and as parts of each other.

use super::{EPS, small_vector};
use boxplus::lie::{
    Action, LieGroup, R3xSO3, Real, Rn, RxSO2, RxSO3, S3, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3, laws,
};
use nalgebra::{SMatrix, SVector, Vector2, Vector3, Vector6};
use proptest::prelude::*;

/// exp of a matrix by its power series, halved until small, then squared.
fn matrix_exp<const N: usize>(m: SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    let m = m / 256.0;
    let (mut term, mut sum) = (SMatrix::identity(), SMatrix::identity());
    for k in 1..20 {
        term = term * m / f64::from(k);
        sum += term;
    }
    (0..8).fold(sum, |s, _| s * s)
}

/// The laws that tie a group to its matrices.
fn is_its_matrix_group<G, const D: usize, const N: usize>(
    to_matrix: fn(&G) -> SMatrix<f64, N, N>,
    a: SVector<f64, D>,
    b: SVector<f64, D>,
) where
    G: LieGroup<D, Scalar = f64, Algebra = SMatrix<f64, N, N>>,
{
    let (x, y) = (G::exp(&a), G::exp(&b));
    let (mx, my, ha, hb) = (to_matrix(&x), to_matrix(&y), G::hat(&a), G::hat(&b));
    let close =
        |l: SMatrix<f64, N, N>, r: SMatrix<f64, N, N>| (l - r).amax() < 2000.0 * EPS * (1.0 + r.amax());
    assert!(close(mx, matrix_exp(ha)), "Exp τ = exp(τ^)");
    assert!(close(to_matrix(&x.compose(&y)), mx * my), "compose is the product");
    assert!(close(to_matrix(&x.inverse()) * mx, SMatrix::identity()), "inverse is the inverse");
    assert!(close(G::hat(&G::bracket(&a, &b)), ha * hb - hb * ha), "bracket is the commutator");
    assert!(close(G::hat(&(a * 2.0 - b)), ha * 2.0 - hb), "hat is linear");
    assert!(close(G::hat(&(x.adjoint() * b)), mx * hb * to_matrix(&x.inverse())), "(Ad_X τ)^ = X·τ^·X⁻¹");
}

proptest! {
    #[test]
    fn so2_is_its_matrix_group(a in small_vector::<1>(3.0), b in small_vector::<1>(3.0)) {
        is_its_matrix_group::<SO2, 1, 2>(SO2::to_matrix, a, b);
    }
    #[test]
    fn se2_is_its_matrix_group(a in small_vector::<3>(3.0), b in small_vector::<3>(3.0)) {
        is_its_matrix_group::<SE2, 3, 3>(SE2::to_matrix, a, b);
    }
    #[test]
    fn so3_is_its_matrix_group(a in small_vector::<3>(3.0), b in small_vector::<3>(3.0)) {
        is_its_matrix_group::<SO3, 3, 3>(SO3::to_matrix, a, b);
    }
    #[test]
    fn se3_is_its_matrix_group(a in small_vector::<6>(3.0), b in small_vector::<6>(3.0)) {
        is_its_matrix_group::<SE3, 6, 4>(SE3::to_matrix, a, b);
    }
    #[test]
    fn se23_is_its_matrix_group(a in small_vector::<9>(2.5), b in small_vector::<9>(2.5)) {
        is_its_matrix_group::<SE23, 9, 5>(SE23::to_matrix, a, b);
        let x = SE23::exp(&a);
        prop_assert!(SE23::from_matrix(&x.to_matrix()).unwrap().rminus(&x).norm() < 64.0 * EPS);
    }
    #[test]
    fn se23_is_two_copies_of_se3_with_one_rotation_to_the_last_bit(
        a in small_vector::<9>(2.5), b in small_vector::<9>(2.5),
    ) {
        // Its position is that of SE(3), its velocity that of SE(3) as well: the bounds of SE(3) hold for both.
        let (x, y) = (SE23::exp(&a), SE23::exp(&b));
        for first in [0, 6] {
            let part = |t: &SVector<f64, 9>| Vector6::from_fn(|i, _| t[if i < 3 { first + i } else { i }]);
            let rows = |m: SMatrix<f64, 9, 9>| {
                let kept = [first, first + 1, first + 2, 3, 4, 5];
                SMatrix::<f64, 6, 6>::from(m.select_rows(&kept).select_columns(&kept).fixed_view::<6, 6>(0, 0))
            };
            let moved = |x: &SE23| SE3::new(x.rotation(), if first == 0 { x.position() } else { x.velocity() });
            let (x3, y3) = (SE3::exp(&part(&a)), SE3::exp(&part(&b)));
            prop_assert_eq!(moved(&x), x3);
            prop_assert_eq!(part(&x.log()), x3.log());
            prop_assert_eq!(moved(&x.compose(&y)), x3.compose(&y3));
            prop_assert_eq!(moved(&x.inverse()), x3.inverse());
            prop_assert_eq!(part(&x.rminus(&y)), x3.rminus(&y3));
            prop_assert_eq!(rows(x.adjoint()), x3.adjoint());
            prop_assert_eq!(rows(SE23::right_jacobian(&a)), SE3::right_jacobian(&part(&a)));
            prop_assert_eq!(rows(SE23::left_jacobian(&a)), SE3::left_jacobian(&part(&a)));
            prop_assert_eq!(rows(SE23::right_jacobian_inverse(&a)), SE3::right_jacobian_inverse(&part(&a)));
            prop_assert_eq!(rows(x.log_jacs().2), x3.log_jacs().2);
        }
        let p = b.fixed_rows::<3>(0).into_owned();
        prop_assert_eq!(x.act(&p), x.pose().act(&p));
        prop_assert_eq!(x.act_jac(&p).1.columns(6, 3).amax(), 0.0);
    }
    #[test]
    fn sgal3_is_its_matrix_group(a in small_vector::<10>(2.0), b in small_vector::<10>(2.0)) {
        is_its_matrix_group::<SGal3, 10, 5>(SGal3::to_matrix, a, b);
        let x = SGal3::exp(&a);
        prop_assert!(SGal3::from_matrix(&x.to_matrix()).unwrap().rminus(&x).norm() < 64.0 * EPS);
    }
    #[test]
    fn se23_is_the_subgroup_of_sgal3_at_time_zero_to_the_last_bit(
        a in small_vector::<9>(2.5), b in small_vector::<9>(2.5),
    ) {
        let at = |x: SE23| SGal3::from_extended(x, 0.0);
        let lift = |t: &SVector<f64, 9>| t.push(0.0);
        let rows = |m: SMatrix<f64, 10, 10>| m.fixed_view::<9, 9>(0, 0).into_owned();
        let (x, y) = (SE23::exp(&a), SE23::exp(&b));
        prop_assert_eq!(SGal3::exp(&lift(&a)), at(x));
        prop_assert_eq!(at(x).log(), lift(&x.log()));
        prop_assert_eq!(at(x).compose(&at(y)), at(x.compose(&y)));
        prop_assert_eq!(at(x).inverse(), at(x.inverse()));
        prop_assert_eq!(at(x).between(&at(y)), at(x.between(&y)));
        prop_assert_eq!(rows(at(x).adjoint()), x.adjoint());
        prop_assert_eq!(rows(SGal3::right_jacobian(&lift(&a))), SE23::right_jacobian(&a));
        prop_assert_eq!(rows(SGal3::right_jacobian_inverse(&lift(&a))), SE23::right_jacobian_inverse(&a));
        prop_assert_eq!(rows(at(x).log_jacs().2), x.log_jacs().2);
    }
    #[test]
    fn constant_rate_and_force_are_an_exponential_of_sgal3(
        omega in small_vector::<3>(1.0), force in small_vector::<3>(9.0),
    ) {
        // 2¹² steps of Δ/2¹² are the one step: increments of an inertial sensor add up exactly, up to rounding.
        let (n, total) = (4096, 2.0);
        let increment = |time: f64| {
            let (phi, nu) = (omega * time, force * time);
            SGal3::exp(&SVector::from([0.0, 0.0, 0.0, phi.x, phi.y, phi.z, nu.x, nu.y, nu.z, time]))
        };
        let step = increment(total / f64::from(n));
        let sum = (0..n).fold(SGal3::identity(), |x, _| x.compose(&step));
        prop_assert!(sum.rminus(&increment(total)).norm() < 64.0 * f64::from(n) * EPS);
        // And they are p = ∫∫R·a, which without rotation is ½aΔ².
        let straight = SGal3::exp(&SVector::from([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, force.x, force.y, force.z, 1.0]));
        prop_assert_eq!(straight.position(), force * 0.5);
    }

    #[test]
    fn sim3_is_its_matrix_group(a in small_vector::<7>(1.7), b in small_vector::<7>(1.7)) {
        is_its_matrix_group::<Sim3, 7, 4>(Sim3::to_matrix, a, b);
        let x = Sim3::exp(&a);
        prop_assert!(Sim3::from_matrix(&x.to_matrix()).unwrap().rminus(&x).norm() < 64.0 * EPS);
    }
    #[test]
    fn sim2_is_its_matrix_group(a in small_vector::<4>(1.7), b in small_vector::<4>(1.7)) {
        is_its_matrix_group::<Sim2, 4, 3>(Sim2::to_matrix, a, b);
        let x = Sim2::exp(&a);
        prop_assert!(Sim2::from_matrix(&x.to_matrix()).unwrap().rminus(&x).norm() < 64.0 * EPS);
    }
    #[test]
    fn scaled_rotations_are_their_matrix_groups(a in small_vector::<4>(1.7), b in small_vector::<4>(1.7)) {
        is_its_matrix_group::<RxSO3, 4, 3>(RxSO3::to_matrix, a, b);
        is_its_matrix_group::<RxSO2, 2, 2>(RxSO2::to_matrix, a.xy(), b.xy());
    }
    #[test]
    fn subgroups_move_points_as_their_group_does(a in small_vector::<4>(1.7), p in small_vector::<3>(9.0)) {
        let flat = Vector3::new(p.x, p.y, 0.0);
        let lift = |t: &SVector<f64, 4>| SVector::from([t.x, t.y, 0.0, 0.0, 0.0, t.z, t.w]);
        let moved = Sim2::exp(&a).act(&p.xy());
        let x3 = Sim3::exp(&lift(&a));
        prop_assert!((x3.act(&flat).xy() - moved).norm() < 16.0 * EPS * (1.0 + x3.scale() * p.norm()));
        let x = SE2::exp(&a.xyz());
        prop_assert_eq!(Sim2::from_pose(&x).act(&p.xy()), x.act(&p.xy()));
        let translation = a.xyz();
        let pose = SE3::exp(&Vector6::new(translation.x, translation.y, translation.z, 0.0, 0.0, 0.0));
        prop_assert_eq!(pose.act(&p), Rn::new(translation).act(&p));
    }
}

/// The matrix, D×C, that puts the k-th coordinate of a subgroup at `places[k]`.
fn places<S: Real, const D: usize, const C: usize>(places: [usize; C]) -> SMatrix<S, D, C> {
    SMatrix::from_fn(|i, j| S::lit(f64::from(u8::from(places[j] == i))))
}

fn embeddings<S: Real>() {
    let (o2, o3) = (Vector2::<S>::zeros(), Vector3::<S>::zeros());
    let flat = |t: Vector2<S>| Vector3::new(t.x, t.y, S::zero());
    let about_z = |r: &SO2<S>| SO3::about_z(r.angle());
    laws::check_embedding::<SO2<S>, SO3<S>, 1, 3>(about_z, &places([2])).unwrap();
    laws::check_embedding::<SO2<S>, SE2<S>, 1, 3>(|r| SE2::from_parts(o2, *r), &places([2])).unwrap();
    laws::check_embedding::<SO3<S>, SE3<S>, 3, 6>(|r| SE3::new(*r, o3), &places([3, 4, 5])).unwrap();
    laws::check_embedding::<SO3<S>, R3xSO3<S>, 3, 6>(|r| R3xSO3::new(*r, o3), &places([3, 4, 5])).unwrap();
    let translation = |t: &Rn<3, S>| SE3::new(SO3::identity(), t.vector());
    laws::check_embedding::<Rn<3, S>, SE3<S>, 3, 6>(translation, &places([0, 1, 2])).unwrap();
    let lift = |x: &SE2<S>| SE3::new(about_z(&x.rotation()), flat(x.translation()));
    laws::check_embedding::<SE2<S>, SE3<S>, 3, 6>(lift, &places([0, 1, 5])).unwrap();
    laws::check_embedding::<SE2<S>, Sim2<S>, 3, 4>(Sim2::from_pose, &places([0, 1, 2])).unwrap();
    laws::check_embedding::<SE3<S>, Sim3<S>, 6, 7>(Sim3::from_pose, &places([0, 1, 2, 3, 4, 5])).unwrap();
    let lift = |x: &Sim2<S>| Sim3::new(about_z(&x.rotation()), flat(x.translation()), x.log_scale());
    laws::check_embedding::<Sim2<S>, Sim3<S>, 4, 7>(lift, &places([0, 1, 5, 6])).unwrap();
    let lift = |x: &RxSO2<S>| Sim2::new(x.rotation(), o2, x.log_scale());
    laws::check_embedding::<RxSO2<S>, Sim2<S>, 2, 4>(lift, &places([2, 3])).unwrap();
    let lift = |x: &RxSO3<S>| Sim3::new(x.rotation(), o3, x.log_scale());
    laws::check_embedding::<RxSO3<S>, Sim3<S>, 4, 7>(lift, &places([3, 4, 5, 6])).unwrap();
    let lift = |x: &SE3<S>| SE23::from_pose(*x, o3);
    laws::check_embedding::<SE3<S>, SE23<S>, 6, 9>(lift, &places([0, 1, 2, 3, 4, 5])).unwrap();
    let lift = |x: &SE23<S>| SGal3::from_extended(*x, S::zero());
    laws::check_embedding::<SE23<S>, SGal3<S>, 9, 10>(lift, &places([0, 1, 2, 3, 4, 5, 6, 7, 8])).unwrap();
    laws::check_embedding::<S3<S>, SO3<S>, 3, 3>(|q| SO3::from(*q), &places([0, 1, 2])).unwrap();
}

#[test]
fn embeddings_commute_with_every_operation() {
    embeddings::<f64>();
    embeddings::<f32>();
}

#[test]
fn a_wrong_embedding_is_told() {
    let wrong = |r: &SO2| SO3::exp(&Vector3::new(0.0, 0.0, -r.angle()));
    assert_eq!(laws::check_embedding::<SO2, SO3, 1, 3>(wrong, &places([2])).unwrap_err().law, "exp");
    let shifted = |r: &SO2| SE2::from_parts(Vector2::new(1.0, 0.0), *r);
    assert_eq!(laws::check_embedding::<SO2, SE2, 1, 3>(shifted, &places([2])).unwrap_err().law, "identity");
}
