//! Every group passes the public law suite in `f64`, `f32` and dual numbers: one line each.
#![allow(missing_docs, clippy::unwrap_used)]

use boxplus::lie::{LieGroup, Rn, RxSO2, RxSO3, S3, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3, laws};
use boxplus::trajectory::Moving;

macro_rules! laws {
    ($($name:ident: $group:ty, $d:literal, $n:literal;)*) => { $(
        mod $name {
            use super::*;
            type Single = <$group as LieGroup<$d>>::Over<f32>;

            #[test]
            fn is_a_lie_group_in_f64() {
                laws::check_group::<$group, $d>().unwrap();
            }
            #[test]
            fn is_a_lie_group_in_f32() {
                laws::check_group::<Single, $d>().unwrap();
            }
            #[cfg(feature = "autodiff")]
            #[test]
            fn is_a_lie_group_in_dual_numbers() {
                laws::check_group::<<$group as LieGroup<$d>>::Over<num_dual::Dual64>, $d>().unwrap();
            }
            #[test]
            fn acts_on_points_in_f64_and_f32() {
                laws::check_action::<$group, $d, $n>().unwrap();
                laws::check_action::<Single, $d, $n>().unwrap();
            }
        }
    )* };
}

laws! {
    rn: Rn<3>, 3, 3;
    so2: SO2, 1, 2;
    se2: SE2, 3, 2;
    so3: SO3, 3, 3;
    se3: SE3, 6, 3;
    se23: SE23, 9, 3;
    sgal3: SGal3, 10, 4;
    sim3: Sim3, 7, 3;
    sim2: Sim2, 4, 2;
    s3: S3, 3, 3;
    rxso3: RxSO3, 4, 3;
    rxso2: RxSO2, 2, 2;
}

#[test]
fn elements_with_their_rates_are_a_group() {
    laws::check_group::<Moving<SO2, 1, 2, 2>, 2>().unwrap();
    laws::check_group::<Moving<SE2, 3, 3, 9>, 9>().unwrap();
    laws::check_group::<Moving<SO3<f32>, 3, 2, 6>, 6>().unwrap();
    laws::check_group::<Moving<SE3, 6, 3, 18>, 18>().unwrap();
}

#[test]
fn unit_quaternions_are_a_group_beyond_half_a_turn() {
    laws::check_group_within::<S3, 3>(5.0).unwrap();
    laws::check_group_within::<S3<f32>, 3>(5.0).unwrap();
    assert!(laws::check_group_within::<SO3, 3>(5.0).is_err(), "rotations are not");
}

/// Dual numbers through every operation: their derivatives are the closed-form Jacobians, without NaN at the identity,
/// at switches and at π.
#[cfg(feature = "autodiff")]
mod dual_numbers {
    use super::*;
    use boxplus::lie::R3xSO3;
    use nalgebra::{Const, Matrix3, SMatrix, SVector, Vector3};
    use num_dual::DualSVec64;
    use std::f64::consts::PI;

    type Dual<const N: usize> = DualSVec64<N>;

    fn constants<const N: usize, const M: usize>(x: &SVector<f64, M>) -> SVector<Dual<N>, M> {
        x.map(Dual::from_re)
    }

    /// 0 with unit derivatives.
    fn unknown<const N: usize>() -> SVector<Dual<N>, N> {
        SVector::from_fn(|i, _| Dual::from_re(0.0).derivative(i))
    }

    fn derivatives<const N: usize, const M: usize>(y: &SVector<Dual<N>, M>) -> SMatrix<f64, M, N> {
        let rows = y.map(|d| d.eps.unwrap_generic(Const::<N>, Const::<1>));
        SMatrix::from_fn(|i, j| rows[i][j])
    }

    fn close<const M: usize, const N: usize>(
        name: &str,
        theta: f64,
        dual: &SMatrix<f64, M, N>,
        closed: &SMatrix<f64, M, N>,
    ) {
        let bound = 256.0 * f64::EPSILON * (1.0 + closed.amax());
        let error = (dual - closed).amax();
        assert!(error <= bound, "{name} at |τ| = {theta}: differs by {error:.1e}\n{dual}{closed}");
    }

    /// Where the rotation stands in a tangent: first coordinate and number of coordinates.
    type Angles = (usize, usize);

    /// Directions: generic, and so that the rotation angle of the tangent is exactly |τ|.
    fn tangents<const D: usize>((at, n): Angles) -> impl Iterator<Item = SVector<f64, D>> {
        let lengths = [0.0, 1e-300, 1e-12, 1e-8, 1e-4, 2e-3, 0.1, 0.5, 1.0, 2.0, 3.0, PI - 1e-7, PI];
        lengths.into_iter().flat_map(move |length| {
            (0..3).map(move |k| {
                let mut t = SVector::<f64, D>::from_fn(|i, _| ((i * 3 + k * 7 + 1) as f64).sin());
                let angle = t.rows(at, n).norm();
                let scale = if angle > 0.0 { length / angle } else { 1.0 };
                t.rows_mut(at, n).scale_mut(scale);
                t
            })
        })
    }

    fn group<G: LieGroup<D, Scalar = f64>, const D: usize>(angles: Angles) {
        for tau in tangents::<D>(angles) {
            let theta = tau.rows(angles.0, angles.1).norm();
            let (x, u) = (G::exp(&tau), unknown::<D>());
            let y = x.rplus(&SVector::from_fn(|i, _| 0.3 * ((i * 5 + 2) as f64).cos()));
            let (xc, yc) = (x.map(Dual::<D>::from_re), y.map(Dual::<D>::from_re));
            let value = |z: G| z.map(Dual::<D>::from_re);
            let t = Dual::<D>::from_re(0.3);

            let dual = G::Over::<Dual<D>>::exp(&(constants(&tau) + u)).rminus(&xc);
            close("exp", theta, &derivatives(&dual), &G::exp_jac(&tau).1);
            close("log", theta, &derivatives(&xc.rplus(&u).log()), &x.log_jac().1);
            let dual = xc.rplus(&u).inverse().rminus(&value(x.inverse()));
            close("inverse", theta, &derivatives(&dual), &x.inverse_jac().1);
            let (z, d_x, _) = x.compose_jac(&y);
            close("compose", theta, &derivatives(&xc.rplus(&u).compose(&yc).rminus(&value(z))), &d_x);
            let (z, d_x, _) = x.between_jac(&y);
            close("between", theta, &derivatives(&xc.rplus(&u).between(&yc).rminus(&value(z))), &d_x);
            let (_, d_y, d_x) = y.rminus_jac(&x);
            close("rminus", theta, &derivatives(&yc.rplus(&u).rminus(&xc)), &d_y);
            close("rminus, base", theta, &derivatives(&yc.rminus(&xc.rplus(&u))), &d_x);
            let (_, d_y, d_x) = y.lminus_jac(&x);
            close("lminus", theta, &derivatives(&yc.rplus(&u).lminus(&xc)), &d_y);
            close("lminus, base", theta, &derivatives(&yc.lminus(&xc.rplus(&u))), &d_x);
            let (z, d_x, _) = x.power_jac(0.3);
            close("power", theta, &derivatives(&xc.rplus(&u).power(t).rminus(&value(z))), &d_x);
            let (z, d_x, d_y, _) = x.interpolate_jac(&y, 0.3);
            close(
                "interpolate, X",
                theta,
                &derivatives(&xc.rplus(&u).interpolate(&yc, t).rminus(&value(z))),
                &d_x,
            );
            close(
                "interpolate, Y",
                theta,
                &derivatives(&xc.interpolate(&yc.rplus(&u), t).rminus(&value(z))),
                &d_y,
            );
        }
    }

    #[test]
    fn derive_every_operation_of_every_group() {
        group::<Rn<3>, 3>((0, 3));
        group::<SO2, 1>((0, 1));
        group::<SE2, 3>((2, 1));
        group::<SO3, 3>((0, 3));
        group::<SE3, 6>((3, 3));
        group::<R3xSO3, 6>((3, 3));
        group::<SE23, 9>((3, 3));
        group::<SGal3, 10>((3, 3));
        group::<Sim3, 7>((3, 3));
        group::<Sim3, 7>((3, 4)); // σ vanishes with θ
        group::<Sim2, 4>((2, 1));
        group::<Sim2, 4>((2, 2));
        group::<S3, 3>((0, 3));
        group::<RxSO3, 4>((0, 3));
        group::<RxSO2, 2>((0, 1));
    }

    #[test]
    fn derive_the_projection_to_the_nearest_rotation() {
        // M = R·Exp(δ) is a rotation already, so that δ comes back; M = R·(I + S), S symmetric, does not turn R.
        let r = SO3::exp(&Vector3::new(0.4, -1.1, 0.7));
        let rc = r.map(Dual::<3>::from_re);
        let turned = SO3::project(&rc.rplus(&unknown::<3>()).to_matrix()).unwrap();
        close("project", 0.0, &derivatives(&turned.rminus(&rc)), &Matrix3::identity());
        let u = unknown::<3>();
        let stretched =
            rc.to_matrix() * (Matrix3::identity() + u * u.map(|_| Dual::from_re(1.0)).transpose());
        let skew = Matrix3::new(0.0, -0.5, 0.5, 0.5, 0.0, -0.5, -0.5, 0.5, 0.0);
        close("project, sheared", 0.0, &derivatives(&SO3::project(&stretched).unwrap().rminus(&rc)), &skew);
    }

    #[test]
    fn derive_the_logarithm_beyond_a_turn() {
        let tau = Vector3::new(2.0, -3.0, 6.0) * (9.0 / 7.0);
        let followed = SO3::exp(&(constants(&tau) + unknown::<3>())).log_near(&constants(&tau));
        close("log_near", 9.0, &derivatives(&followed), &Matrix3::identity());
    }
}
