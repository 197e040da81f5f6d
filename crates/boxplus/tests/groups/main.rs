//! What holds of particular groups: their matrices, subgroups, behaviour at the cut, constructors, drift.
#![allow(missing_docs, clippy::unwrap_used)]

mod drift;

use boxplus::lie::{
    Action, LieError, LieGroup, Real, Rn, RxSO2, RxSO3, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3,
};
use nalgebra::{Matrix2, Matrix3, Matrix4, SMatrix, SVector, Vector1, Vector2, Vector3, Vector6};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

const EPS: f64 = f64::EPSILON;

fn small_vector<const N: usize>(size: f64) -> impl Strategy<Value = SVector<f64, N>> {
    prop::array::uniform(-1.0..1.0_f64).prop_map(move |a: [f64; N]| SVector::from(a) * size)
}

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
    fn se3_is_the_subgroup_of_sim3_at_scale_one(a in small_vector::<6>(1.7), b in small_vector::<6>(1.7)) {
        let lift = |t: &Vector6<f64>| t.push(0.0);
        let rows = |m: SMatrix<f64, 7, 7>| m.fixed_view::<6, 6>(0, 0).into_owned();
        let (x, y, xs, ys) = (SE3::exp(&a), SE3::exp(&b), Sim3::exp(&lift(&a)), Sim3::exp(&lift(&b)));
        prop_assert_eq!(xs.log_scale(), 0.0);
        prop_assert!((Sim3::from_pose(&x).log() - lift(&x.log())).norm() < 16.0 * EPS);
        prop_assert_eq!(Sim3::from_pose(&x).compose(&Sim3::from_pose(&y)), Sim3::from_pose(&x.compose(&y)));
        prop_assert!((xs.compose(&ys).log() - lift(&x.compose(&y).log())).norm() < 128.0 * EPS);
        prop_assert!((rows(xs.adjoint()) - x.adjoint()).amax() < 16.0 * EPS);
        prop_assert!((rows(Sim3::right_jacobian(&lift(&a))) - SE3::right_jacobian(&a)).amax() < 16.0 * EPS);
        let inverse = Sim3::right_jacobian_inverse(&lift(&a));
        prop_assert!((rows(inverse) - SE3::right_jacobian_inverse(&a)).amax() < 32.0 * EPS);
    }
    #[test]
    fn se2_is_the_subgroup_of_sim2_at_scale_one(a in small_vector::<3>(1.7), b in small_vector::<3>(1.7)) {
        let lift = |t: &Vector3<f64>| t.push(0.0);
        let rows = |m: Matrix4<f64>| m.fixed_view::<3, 3>(0, 0).into_owned();
        let (x, y, xs, ys) = (SE2::exp(&a), SE2::exp(&b), Sim2::exp(&lift(&a)), Sim2::exp(&lift(&b)));
        prop_assert_eq!(xs.log_scale(), 0.0);
        prop_assert!((xs.compose(&ys).log() - lift(&x.compose(&y).log())).norm() < 64.0 * EPS);
        prop_assert!((rows(xs.adjoint()) - x.adjoint()).amax() < 8.0 * EPS);
        prop_assert!((rows(Sim2::right_jacobian(&lift(&a))) - SE2::right_jacobian(&a)).amax() < 8.0 * EPS);
        let inverse = Sim2::right_jacobian_inverse(&lift(&a));
        prop_assert!((rows(inverse) - SE2::right_jacobian_inverse(&a)).amax() < 8.0 * EPS);
    }
    #[test]
    fn sim2_is_the_subgroup_of_sim3_in_the_plane(a in small_vector::<4>(1.7), b in small_vector::<4>(1.7)) {
        let lift = |t: &SVector<f64, 4>| SVector::from([t.x, t.y, 0.0, 0.0, 0.0, t.z, t.w]);
        let drop = |t: &SVector<f64, 7>| SVector::from([t[0], t[1], t[5], t[6]]);
        let rows = |m: SMatrix<f64, 7, 7>| m.select_rows(&[0, 1, 5, 6]).select_columns(&[0, 1, 5, 6]);
        let (x, y, x3, y3) = (Sim2::exp(&a), Sim2::exp(&b), Sim3::exp(&lift(&a)), Sim3::exp(&lift(&b)));
        prop_assert!((drop(&x3.compose(&y3).log()) - x.compose(&y).log()).amax() < 128.0 * EPS);
        prop_assert!((rows(x3.adjoint()) - x.adjoint()).amax() < 32.0 * EPS);
        prop_assert!((rows(Sim3::right_jacobian(&lift(&a))) - Sim2::right_jacobian(&a)).amax() < 32.0 * EPS);
        let inverse = Sim3::right_jacobian_inverse(&lift(&a));
        prop_assert!((rows(inverse) - Sim2::right_jacobian_inverse(&a)).amax() < 64.0 * EPS);
    }

    #[test]
    fn se2_is_the_subgroup_of_se3_in_the_plane(a in small_vector::<3>(1.7), b in small_vector::<3>(1.7)) {
        let lift = |t: &Vector3<f64>| Vector6::new(t.x, t.y, 0.0, 0.0, 0.0, t.z);
        let drop = |t: &Vector6<f64>| Vector3::new(t[0], t[1], t[5]);
        let rows = |m: SMatrix<f64, 6, 6>| m.select_rows(&[0, 1, 5]).select_columns(&[0, 1, 5]);
        let (x, y, x3, y3) = (SE2::exp(&a), SE2::exp(&b), SE3::exp(&lift(&a)), SE3::exp(&lift(&b)));
        prop_assert!((drop(&x3.compose(&y3).log()) - x.compose(&y).log()).amax() < 64.0 * EPS);
        prop_assert!((drop(&x3.rminus(&y3)) - x.rminus(&y)).amax() < 64.0 * EPS);
        prop_assert!((rows(x3.adjoint()) - x.adjoint()).amax() < 16.0 * EPS);
        prop_assert!((rows(SE3::right_jacobian(&lift(&a))) - SE2::right_jacobian(&a)).amax() < 16.0 * EPS);
        let inverse = SE3::right_jacobian_inverse(&lift(&a));
        prop_assert!((rows(inverse) - SE2::right_jacobian_inverse(&a)).amax() < 16.0 * EPS);
        let p = Vector2::new(0.4, -1.3);
        prop_assert!((x3.act(&Vector3::new(p.x, p.y, 0.0)).xy() - x.act(&p)).amax() < 16.0 * EPS);
    }
    #[test]
    fn so2_is_the_subgroup_of_se2_at_the_origin(a in -3.0..3.0_f64, b in -3.0..3.0_f64) {
        let (x, y) = (SO2::from_angle(a), SO2::from_angle(b));
        let at = |r: SO2| SE2::from_parts(Vector2::zeros(), r);
        prop_assert_eq!(at(x).compose(&at(y)), at(x.compose(&y)));
        prop_assert_eq!(at(x).log(), Vector3::new(0.0, 0.0, x.angle()));
        prop_assert_eq!(SE2::exp(&Vector3::new(0.0, 0.0, a)), at(x));
    }
    #[test]
    fn so3_is_the_subgroup_of_se3_at_the_origin(a in small_vector::<3>(1.7), b in small_vector::<3>(1.7)) {
        let at = |r: SO3| SE3::new(r, Vector3::zeros());
        let (x, y) = (SO3::exp(&a), SO3::exp(&b));
        prop_assert_eq!(at(x).compose(&at(y)), at(x.compose(&y)));
        prop_assert_eq!(at(x).log().fixed_rows::<3>(3).into_owned(), x.log());
        prop_assert_eq!(at(x).log().fixed_rows::<3>(0).into_owned(), Vector3::zeros());
    }
    #[test]
    fn translations_are_the_subgroup_rn_of_se3(a in small_vector::<3>(9.0), b in small_vector::<3>(9.0)) {
        let at = |t: Vector3<f64>| SE3::exp(&Vector6::new(t.x, t.y, t.z, 0.0, 0.0, 0.0));
        let sum = Rn::new(a).compose(&Rn::new(b)).vector();
        prop_assert_eq!(at(a).compose(&at(b)).translation(), sum);
        prop_assert_eq!(at(a).act(&b), Rn::new(a).act(&b));
    }

    #[test]
    fn a_matrix_gives_its_rotation_back(phi in small_vector::<3>(4.0)) {
        // By docs/accuracy.md: matrix 4.5√3 ε in the Frobenius norm, √2 of which is an angle, rminus 5.5 ε; 2 ε between.
        let x = SO3::exp(&phi);
        let bound = (4.5 * 1.5_f64.sqrt() + 5.5 + 2.0) * EPS;
        prop_assert!(SO3::from_matrix(&x.to_matrix()).unwrap().rminus(&x).norm() < bound);
        prop_assert!(SO3::project(&x.to_matrix()).unwrap().rminus(&x).norm() < bound);
        let pose = SE3::new(x, phi * 10.0);
        prop_assert!(SE3::from_matrix(&pose.to_matrix()).unwrap().rminus(&pose).norm() < bound);
        let pose = SE2::new(phi.xy(), phi.z);
        prop_assert!(SE2::from_matrix(&pose.to_matrix()).unwrap().rminus(&pose).norm() < 8.0 * EPS);
    }
    #[test]
    fn both_quaternion_orders_and_any_norm_give_the_rotation(phi in small_vector::<3>(4.0), e in -300..300_i32) {
        let x = SO3::exp(&phi);
        let scale = 10.0_f64.powi(e);
        let [i, j, k, w] = x.quaternion_xyzw().map(|c| c * scale);
        // Scaling and normalising leave 1.5 ε in q, twice that in the angle; rminus 5.5 ε.
        prop_assert!(SO3::from_xyzw([i, j, k, w]).unwrap().rminus(&x).norm() < 8.5 * EPS);
        prop_assert_eq!(SO3::from_wxyz([w, i, j, k]).unwrap(), SO3::from_xyzw([i, j, k, w]).unwrap());
    }
    #[test]
    fn projection_is_the_polar_factor(m in prop::array::uniform9(-1.0..1.0_f64)) {
        let m = Matrix3::from_column_slice(&m);
        let svd = m.svd(true, true);
        let (u, vt) = (svd.u.unwrap(), svd.v_t.unwrap());
        let sign = (u * vt).determinant().signum();
        let least = svd.singular_values.imin();
        let mut middle = Matrix3::identity();
        middle[(least, least)] = sign;
        let others: f64 = (0..3).filter(|i| *i != least).map(|i| svd.singular_values[i]).fold(9.0, f64::min);
        let gap = others + sign * svd.singular_values[least];
        prop_assume!(gap > 0.05);
        // The oracle itself is exact to ε/gap.
        let difference = SO3::project(&m).unwrap().to_matrix() - u * middle * vt;
        prop_assert!(difference.amax() < 64.0 * EPS / gap, "{}", difference.amax() / EPS * gap);
    }
    #[test]
    fn constructors_and_logarithms_never_panic(bits in prop::array::uniform::<_, 9>(any::<u64>())) {
        let x = bits.map(f64::from_bits);
        let quaternion = SO3::from_xyzw([x[0], x[1], x[2], x[3]]);
        if let Ok(r) = quaternion {
            prop_assert!(r.log().norm() <= PI * (1.0 + EPS));
        }
        let _ = SO3::from_matrix(&Matrix3::from_column_slice(&x));
        let _ = SO3::project(&Matrix3::from_column_slice(&x));
        let _ = SO2::project(&Matrix2::from_column_slice(&x[..4]));
        let _ = SO2::from_cos_sin(x[4], x[5]);
        let _ = SE3::exp(&Vector6::from_column_slice(&x[..6])).log();
    }
}

#[test]
fn shepperd_divides_by_the_largest_component_on_every_branch() {
    for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
        for theta in [0.0, 1e-9, 1.0, 2.2, 3.0, PI - 1e-9, PI] {
            let x = SO3::exp(&(axis * theta));
            let back = SO3::from_matrix(&x.to_matrix()).unwrap();
            assert!(back.rminus(&x).norm() < 4.0 * EPS, "{axis} {theta}");
        }
    }
}

#[test]
fn what_is_no_rotation_is_refused_with_the_reason() {
    let nan = Matrix3::from_element(f64::NAN);
    assert_eq!(SO3::from_matrix(&nan), Err(LieError::NotFinite));
    assert_eq!(SO3::project(&nan), Err(LieError::NotFinite));
    assert_eq!(SO3::from_xyzw([0.0, f64::INFINITY, 0.0, 1.0]), Err(LieError::NotFinite));
    assert_eq!(SO3::from_xyzw([0.0; 4]), Err(LieError::Zero));
    assert_eq!(SO2::<f64>::from_cos_sin(0.0, 0.0), Err(LieError::Zero));
    assert_eq!(SO3::from_matrix(&-Matrix3::<f64>::identity()), Err(LieError::Reflection));
    assert_eq!(SO2::from_matrix(&Matrix2::new(1.0, 0.0, 0.0, -1.0)), Err(LieError::Reflection));
    let scaled = SO3::from_matrix(&(Matrix3::<f64>::identity() * 1.1)).unwrap_err();
    assert!(matches!(scaled, LieError::NotARotation { deviation } if (deviation - 0.21).abs() < 1e-12));
    assert!(matches!(SO3::project(&Matrix3::<f64>::zeros()), Err(LieError::Undetermined { .. })));
    assert!(matches!(SO3::project(&-Matrix3::<f64>::identity()), Err(LieError::Undetermined { .. })));
    let rank_one = Vector3::new(1.0, 2.0, 3.0) * Vector3::new(-1.0, 0.5, 2.0).transpose();
    assert!(matches!(SO3::project(&rank_one), Err(LieError::Undetermined { .. })));
    assert!(matches!(
        SO2::<f64>::project(&Matrix2::new(1.0, 0.0, 0.0, -1.0)),
        Err(LieError::Undetermined { .. })
    ));
    let mut transposed = SE3::exp(&Vector6::repeat(0.3)).to_matrix().transpose();
    assert_eq!(SE3::from_matrix(&transposed), Err(LieError::NotHomogeneous));
    transposed[(3, 0)] = f64::NAN;
    assert_eq!(SE3::from_matrix(&transposed), Err(LieError::NotFinite));
    let message = SO3::from_matrix(&(Matrix3::<f64>::identity() * 1.1)).unwrap_err().to_string();
    assert_eq!(message, "not a rotation: RᵀR differs from I by 2.1e-1; `project` gives the nearest rotation");
}

#[test]
fn at_pi_the_logarithm_keeps_the_stored_sign() {
    let n = Vector3::new(2.0, -3.0, 6.0) / 7.0;
    for sign in [1.0, -1.0] {
        let x = SO3::from_xyzw([sign * n.x, sign * n.y, sign * n.z, 0.0]).unwrap();
        assert!((x.log() - n * (sign * PI)).norm() < 2.0 * PI * EPS);
        let plane = SO2::from_cos_sin(-1.0, sign * 0.0).unwrap();
        assert!((plane.angle() - sign * PI).abs() < EPS);
    }
    // Beyond π the shorter way round is taken.
    let beyond = SO3::exp(&(n * (PI + 1e-9)));
    assert!((beyond.log() - n * (1e-9 - PI)).norm() < 4.0 * PI * EPS);
}

#[test]
fn q_and_minus_q_are_one_rotation() {
    let x = SO3::exp(&Vector3::new(0.3, -1.2, 0.8));
    let [i, j, k, w] = x.quaternion_xyzw();
    let minus = SO3::from_xyzw([-i, -j, -k, -w]).unwrap();
    assert_eq!(minus, x);
    assert_eq!(minus.log(), x.log());
    assert_eq!(minus.to_matrix(), x.to_matrix());
    assert_eq!(minus.compose(&x), x.compose(&x));
    assert_eq!(SE3::new(minus, Vector3::x()).log(), SE3::new(x, Vector3::x()).log());
}

#[test]
fn a_full_turn_is_the_identity() {
    let n = Vector3::new(2.0, -3.0, 6.0) / 7.0;
    for turns in [1.0, 2.0, -3.0, 1000.0] {
        // θ is rounded: its own error is turns·2π·ε.
        let bound = 2.0 * EPS * TAU * f64::abs(turns);
        assert!(SO3::exp(&(n * TAU * turns)).log().norm() < bound);
        assert!(
            SE3::exp(&Vector6::new(0.0, 0.0, 0.0, n.x, n.y, n.z).scale(TAU * turns)).log().norm() < bound
        );
        assert!(SO2::exp(&Vector1::new(TAU * turns)).angle().abs() < bound);
        // A closed circle leads back to its start: the translation perpendicular to the axis vanishes.
        let circle = SE2::exp(&Vector3::new(5.0, 0.0, TAU * turns));
        assert!(circle.translation().norm() < bound);
    }
}

#[test]
fn log_near_follows_a_rotation_through_many_turns() {
    let n = Vector3::new(2.0, -3.0, 6.0) / 7.0;
    let mut followed = Vector3::zeros();
    for step in 1..=400 {
        let truth = n * (0.1 * f64::from(step));
        followed = SO3::exp(&truth).log_near(&followed);
        assert!((followed - truth).norm() < 64.0 * EPS * truth.norm().max(1.0), "{followed} {truth}");
    }
    assert_eq!(SO3::<f64>::identity().log_near(&Vector3::zeros()), Vector3::zeros());
    let turn = SO3::<f64>::identity().log_near(&Vector3::new(0.0, 0.0, 6.0));
    assert!((turn - Vector3::new(0.0, 0.0, TAU)).norm() < 1e-14);
}

/// How far a stored quaternion is from unit norm, in units of ε.
fn quaternion_error<S: Real>(x: &SO3<S>) -> f64 {
    (x.quaternion_xyzw().iter().map(|c| c.value() * c.value()).sum::<f64>() - 1.0).abs() / S::EPSILON
}

#[test]
fn tiny_and_huge_scales_keep_their_digits() {
    let at = |sigma: f64| Sim3::new(SO3::identity(), Vector3::zeros(), sigma);
    assert_eq!(at(1e-14).compose(&at(1e-14)).log()[6], 2e-14);
    let far = at(300.0).compose(&at(300.0));
    assert_eq!(far.compose(&at(-600.0)), Sim3::identity());
}

#[test]
fn what_is_no_similarity_is_refused_with_the_reason() {
    let (turn, t) = (SO3::exp(&Vector3::new(0.1, -0.2, 0.3)), Vector3::new(1.0, 2.0, 3.0));
    for scale in [0.0, -2.0, f64::INFINITY] {
        assert_eq!(Sim3::from_scale(turn, t, scale), Err(LieError::NotAScale { scale }));
        assert_eq!(Sim2::from_scale(SO2::from_angle(0.1), t.xy(), scale), Err(LieError::NotAScale { scale }));
    }
    assert!(matches!(Sim3::from_scale(turn, t, f64::NAN), Err(LieError::NotAScale { .. })));
    assert_eq!(Sim3::<f64>::from_matrix(&Matrix4::zeros()), Err(LieError::NotAScale { scale: 0.0 }));
    let x = Sim3::from_scale(turn, t, 1e-200).unwrap();
    assert!(Sim3::from_matrix(&x.to_matrix()).unwrap().between(&x).rotation().log().norm() < 16.0 * EPS);
    let mirrored = x.to_matrix() * Matrix4::from_diagonal(&nalgebra::Vector4::new(-1.0, 1.0, 1.0, 1.0));
    assert_eq!(Sim3::from_matrix(&mirrored), Err(LieError::Reflection));
    let sheared = x.to_matrix() * Matrix4::from_diagonal(&nalgebra::Vector4::new(2.0, 1.0, 1.0, 1.0));
    assert!(matches!(Sim3::from_matrix(&sheared), Err(LieError::NotARotation { .. })));
    assert_eq!(
        SE23::<f64>::from_matrix(&SMatrix::<f64, 5, 5>::repeat(1.0).map(|_| f64::NAN)),
        Err(LieError::NotFinite)
    );
    let mut skewed = SE23::new(turn, t, t).to_matrix();
    skewed[(4, 3)] = 0.1;
    assert_eq!(SE23::from_matrix(&skewed), Err(LieError::NotHomogeneous));
    assert_eq!(SGal3::from_matrix(&skewed), Err(LieError::NotHomogeneous));
    skewed[(3, 4)] = f64::NAN;
    assert_eq!(SGal3::from_matrix(&skewed), Err(LieError::NotFinite));
}

#[test]
fn normalisation_is_idempotent_and_repairs_a_cast() {
    let x = SE3::exp(&Vector6::new(1.0, 2.0, 3.0, 0.4, -0.5, 0.6));
    let single = x.map(|c| c as f32).map(f64::from);
    assert!(quaternion_error(&single.rotation()) > 1e6);
    let repaired = single.normalize();
    assert!(quaternion_error(&repaired.rotation()) <= 2.0);
    assert!(repaired.normalize().rminus(&repaired).norm() <= 4.0 * EPS);
    assert!(repaired.rminus(&x).norm() < 1e-6);
}

#[test]
fn homogeneous_points_move_as_their_points_and_directions_do() {
    let x = SE3::exp(&Vector6::new(1.0, 2.0, 3.0, 0.4, -0.5, 0.6));
    let p = Vector3::new(0.3, -0.7, 1.9);
    assert!((x.act(&p.push(1.0)).xyz() - x.act(&p)).norm() < 8.0 * EPS);
    assert!((x.act(&p.push(0.0)).xyz() - Action::<6, 3>::act_direction(&x, &p)).norm() < 8.0 * EPS);
    assert_eq!(Action::<6, 4>::linear_part(&x), x.to_matrix());
    boxplus::lie::laws::check_action::<SE3, 6, 4>().unwrap();
    boxplus::lie::laws::check_action::<SE2, 3, 3>().unwrap();
}

#[test]
fn far_from_the_origin_neighbours_keep_their_digits() {
    let base = SE3::new(SO3::exp(&Vector3::new(0.3, -1.2, 0.8)), Vector3::new(4e6, -3e6, 5e5));
    let step = Vector3::new(0.25, -0.125, 0.5);
    let near = SE3::new(base.rotation(), base.translation() + step);
    let back = base.rotation().inverse().act(&step);
    assert!((base.between(&near).translation() - back).norm() < 4.0 * EPS * step.norm());
    let inverse_first = base.inverse().compose(&near).translation();
    assert!((inverse_first - back).norm() > 1e-12, "the plain product loses seven digits here");
}

#[test]
fn operators_are_the_named_operations() {
    let (a, b) = (Vector6::new(1.0, 2.0, 3.0, 0.4, -0.5, 0.6), Vector6::new(0.1, 0.2, -0.3, 1.4, 0.5, -0.6));
    let (x, y, p) = (SE3::exp(&a), SE3::exp(&b), Vector3::new(0.3, -0.7, 1.9));
    assert_eq!(x * y, x.compose(&y));
    assert_eq!(x * p, x.act(&p));
    assert_eq!(x.rotation() * y.rotation(), x.rotation().compose(&y.rotation()));
    assert_eq!(x.rotation() * p, x.rotation().act(&p));
    let (x, y, p) = (SE2::new(a.xy(), a.w), SE2::new(b.xy(), b.w), p.xy());
    assert_eq!(x * y, x.compose(&y));
    assert_eq!(x * p, x.act(&p));
    assert_eq!(x.rotation() * p, x.rotation().act(&p));
    assert_eq!(Rn::new(p) * Rn::new(p), Rn::new(p * 2.0));
    let quarter = SO2::from_angle(FRAC_PI_2);
    assert_eq!((quarter * quarter).log(), quarter.compose(&quarter).log());
    let _: Matrix4<f64> = SE3::exp(&a).to_matrix();
    let (turn, p) = (SO3::exp(&a.fixed_rows::<3>(3).into_owned()), Vector3::new(0.3, -0.7, 1.9));
    let (x, y) = (SE23::new(turn, p, p * 2.0), Sim3::new(turn, p, 0.3));
    assert_eq!((x * x, x * p), (x.compose(&x), x.act(&p)));
    assert_eq!((y * y, y * p), (y.compose(&y), y.act(&p)));
    let (x, e) = (SGal3::from_extended(x, 0.5), p.push(0.25));
    assert_eq!((x * x, x * e), (x.compose(&x), x.act(&e)));
    let (x, p) = (Sim2::new(quarter, p.xy(), 0.3), p.xy());
    assert_eq!((x * x, x * p), (x.compose(&x), x.act(&p)));
}
