//! Residual charts: how the difference of two displacements becomes numbers.
//!
//! A relative pose is measured as Z and predicted as Δ = X₁⁻¹X₂. Tools differ in the numbers they make of the two, and
//! so in what they minimise. Here the choice is a type; Jacobians are exact in each.
//!
//! | chart | SE(3) | SE(2) | minimised by |
//! |---|---|---|---|
//! | [`Log`] | Log(Z⁻¹Δ) | Log(Z⁻¹Δ) | boxplus, GTSAM |
//! | [`G2o`] | (t, vec q) of Z⁻¹Δ, w ≥ 0 | (t, θ) of Z⁻¹Δ | g2o |
//! | [`Product`] | (t_Δ − t_Z, Log(q_Z⁻¹q_Δ)) | (t_Δ − t_Z, θ_Δ − θ_Z) | tools on SO(3)×ℝ³ |
//! | [`Difference`] | (t_Δ − t_Z, 2·vec(q_Z·q_Δ⁻¹)) | (t_Δ − t_Z, θ_Δ − θ_Z) | Ceres' pose-graph example |

use nalgebra::{Matrix2, Matrix3, Matrix6, SMatrix, SVector, Vector3, Vector6};

use crate::lie::{LieGroup, Real, SE2, SE3, SO3};

/// How a measured and a predicted displacement become a residual.
pub trait Chart<G: LieGroup<D, Scalar = f64>, const D: usize>:
    Copy + Default + Send + Sync + 'static
{
    /// e(Z, Δ).
    fn error<S: Real>(measured: &G::Over<S>, predicted: &G::Over<S>) -> SVector<S, D>;
    /// `(e, d_e_d_predicted)`, the latter on the local side of Δ.
    fn error_jac(measured: &G, predicted: &G) -> (SVector<f64, D>, SMatrix<f64, D, D>);
}

/// The full logarithm, e = Log(Z⁻¹Δ), on any group.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Log;

impl<G: LieGroup<D, Scalar = f64>, const D: usize> Chart<G, D> for Log {
    fn error<S: Real>(measured: &G::Over<S>, predicted: &G::Over<S>) -> SVector<S, D> {
        predicted.rminus(measured)
    }
    #[inline]
    fn error_jac(measured: &G, predicted: &G) -> (SVector<f64, D>, SMatrix<f64, D, D>) {
        measured.between(predicted).log_jac()
    }
}

/// g2o's chart: translation and imaginary quaternion (2-D: angle) of Z⁻¹Δ.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct G2o;

/// Ceres' chart: translations are compared in the frame of the first pose, rotations by twice the imaginary quaternion
/// (2-D: by the angle).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Difference;

/// SE-Sync's chart: [`Difference`], in 2-D with 2·sin(θ/2) for the angle. With information diag(τ·I, 2κ·I), twice the cost
/// is Σ τ‖t_j − t_i − R_i t̃‖² + κ‖R_j − R_i R̃‖²_F, its objective.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Chordal;

/// The chart of ⟨ℝ³, SO(3)⟩: translations are compared in the frame of the first pose, rotations by the logarithm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Product;

impl Chart<SE3, 6> for Product {
    fn error<S: Real>(measured: &SE3<S>, predicted: &SE3<S>) -> Vector6<S> {
        let rotation = predicted.rotation().rminus(&measured.rotation());
        join(&(predicted.translation() - measured.translation()), &rotation)
    }
    fn error_jac(measured: &SE3, predicted: &SE3) -> (Vector6<f64>, Matrix6<f64>) {
        let (rotation, d_rotation) = measured.rotation().between(&predicted.rotation()).log_jac();
        let mut jacobian = Matrix6::zeros();
        jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(&predicted.rotation().to_matrix());
        jacobian.fixed_view_mut::<3, 3>(3, 3).copy_from(&d_rotation);
        (join(&(predicted.translation() - measured.translation()), &rotation), jacobian)
    }
}

impl Chart<SE2, 3> for Product {
    fn error<S: Real>(measured: &SE2<S>, predicted: &SE2<S>) -> Vector3<S> {
        Difference::error::<S>(measured, predicted)
    }
    fn error_jac(measured: &SE2, predicted: &SE2) -> (Vector3<f64>, Matrix3<f64>) {
        Difference::error_jac(measured, predicted)
    }
}

impl Chart<SE3, 6> for G2o {
    fn error<S: Real>(measured: &SE3<S>, predicted: &SE3<S>) -> Vector6<S> {
        let error = measured.between(predicted);
        join(&error.translation(), &folded(&error.rotation()).0)
    }
    fn error_jac(measured: &SE3, predicted: &SE3) -> (Vector6<f64>, Matrix6<f64>) {
        let error = measured.between(predicted);
        let (v, w) = folded(&error.rotation());
        let mut jacobian = Matrix6::zeros();
        jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(&error.rotation().to_matrix());
        jacobian.fixed_view_mut::<3, 3>(3, 3).copy_from(&half_quaternion(&v, w));
        (join(&error.translation(), &v), jacobian)
    }
}

impl Chart<SE2, 3> for G2o {
    fn error<S: Real>(measured: &SE2<S>, predicted: &SE2<S>) -> Vector3<S> {
        let error = measured.between(predicted);
        let t = error.translation();
        Vector3::new(t.x, t.y, error.angle())
    }
    fn error_jac(measured: &SE2, predicted: &SE2) -> (Vector3<f64>, Matrix3<f64>) {
        let error = measured.between(predicted);
        (Self::error::<f64>(measured, predicted), block(&error.rotation().to_matrix(), 1.0))
    }
}

impl Chart<SE3, 6> for Difference {
    fn error<S: Real>(measured: &SE3<S>, predicted: &SE3<S>) -> Vector6<S> {
        let rotation = measured.rotation().compose(&predicted.rotation().inverse());
        join(&(predicted.translation() - measured.translation()), &(folded(&rotation).0 * S::lit(2.0)))
    }
    fn error_jac(measured: &SE3, predicted: &SE3) -> (Vector6<f64>, Matrix6<f64>) {
        let (v, w) = folded(&measured.rotation().compose(&predicted.rotation().inverse()));
        // Δ·Exp(φ) turns q into Exp(−R_Z·φ)·q.
        let d_q = half_quaternion(&-v, w) * measured.rotation().to_matrix() * -2.0;
        let mut jacobian = Matrix6::zeros();
        jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(&predicted.rotation().to_matrix());
        jacobian.fixed_view_mut::<3, 3>(3, 3).copy_from(&d_q);
        (join(&(predicted.translation() - measured.translation()), &(v * 2.0)), jacobian)
    }
}

impl Chart<SE2, 3> for Difference {
    fn error<S: Real>(measured: &SE2<S>, predicted: &SE2<S>) -> Vector3<S> {
        let t = predicted.translation() - measured.translation();
        Vector3::new(t.x, t.y, measured.rotation().between(&predicted.rotation()).angle())
    }
    fn error_jac(measured: &SE2, predicted: &SE2) -> (Vector3<f64>, Matrix3<f64>) {
        (Self::error::<f64>(measured, predicted), block(&predicted.rotation().to_matrix(), 1.0))
    }
}

impl Chart<SE3, 6> for Chordal {
    fn error<S: Real>(measured: &SE3<S>, predicted: &SE3<S>) -> Vector6<S> {
        Difference::error::<S>(measured, predicted)
    }
    fn error_jac(measured: &SE3, predicted: &SE3) -> (Vector6<f64>, Matrix6<f64>) {
        Difference::error_jac(measured, predicted)
    }
}

impl Chart<SE2, 3> for Chordal {
    fn error<S: Real>(measured: &SE2<S>, predicted: &SE2<S>) -> Vector3<S> {
        let mut error: Vector3<S> = Difference::error::<S>(measured, predicted);
        error.z = (error.z * S::lit(0.5)).simd_sin() * S::lit(2.0);
        error
    }
    fn error_jac(measured: &SE2, predicted: &SE2) -> (Vector3<f64>, Matrix3<f64>) {
        let (mut error, mut jacobian): (Vector3<f64>, Matrix3<f64>) =
            Difference::error_jac(measured, predicted);
        let (sin, cos) = (0.5 * error.z).sin_cos();
        error.z = 2.0 * sin;
        jacobian[(2, 2)] = cos;
        (error, jacobian)
    }
}

/// SE-Sync's isotropic information of a full one: translations get τ = N/tr(Ω_t⁻¹), rotations 2κ with
/// κ = 3/(2·tr(Ω_R⁻¹)) in 3-D and κ = Ω_θθ in 2-D. Rosen et al. (2019), §2.
///
/// With it, twice the cost in the [`Chordal`] chart is Σ τ‖t_j − t_i − R_i t̃‖² + κ‖R_j − R_i R̃‖²_F.
/// `None` unless both blocks are invertible. D is 3 or 6.
#[cfg(feature = "io")]
pub(crate) fn isotropic_information<const D: usize>(
    information: &SMatrix<f64, D, D>,
) -> Option<SMatrix<f64, D, D>> {
    let (tau, kappa) = isotropic_weights(information)?;
    let translations = if D == 3 { 2 } else { 3 };
    Some(SMatrix::from_diagonal(&SVector::from_fn(|i, _| if i < translations { tau } else { 2.0 * kappa })))
}

/// SE-Sync's (τ, κ) of an information matrix in the order (t, θ), 3×3 or 6×6.
pub(crate) fn isotropic_weights<const D: usize>(information: &SMatrix<f64, D, D>) -> Option<(f64, f64)> {
    if D == 3 {
        let t = Matrix2::from_fn(|i, j| information[(i, j)]);
        Some((2.0 / t.try_inverse()?.trace(), information[(2, 2)]))
    } else {
        let t = Matrix3::from_fn(|i, j| information[(i, j)]);
        let r = Matrix3::from_fn(|i, j| information[(3 + i, 3 + j)]);
        Some((3.0 / t.try_inverse()?.trace(), 1.5 / r.try_inverse()?.trace()))
    }
}

/// (v, w) of the unit quaternion with w ≥ 0.
fn folded<S: Real>(rotation: &SO3<S>) -> (Vector3<S>, S) {
    let [x, y, z, w] = rotation.quaternion_xyzw();
    let sign = S::choose(w.simd_lt(S::zero()), || S::lit(-1.0), || S::lit(1.0));
    (Vector3::new(x, y, z) * sign, w * sign)
}

/// ∂v/∂φ on the local side: ½(w·I + v^); on the global side with −v.
fn half_quaternion(v: &Vector3<f64>, w: f64) -> Matrix3<f64> {
    (Matrix3::from_diagonal_element(w) + v.cross_matrix()) * 0.5
}

fn join<S: Real>(t: &Vector3<S>, r: &Vector3<S>) -> Vector6<S> {
    Vector6::new(t.x, t.y, t.z, r.x, r.y, r.z)
}

/// diag(R, c).
fn block(rotation: &Matrix2<f64>, c: f64) -> Matrix3<f64> {
    let mut m = Matrix3::zeros();
    m.fixed_view_mut::<2, 2>(0, 0).copy_from(rotation);
    m[(2, 2)] = c;
    m
}
