//! From white noise in time to a covariance per step.
//!
//! ```text
//! ẋ = A·x + L·w      w white, E[w(t)w(s)ᵀ] = Q·δ(t − s)          over a step Δ:   x⁺ = Φ·x + v,  v ~ N(0, Q_d)
//! Φ = exp(AΔ)        Q_d = ∫₀^Δ exp(As)·LQLᵀ·exp(As)ᵀ ds
//! ```
//! Van Loan (1978) reads both off exp(\[−A, LQLᵀ; 0, Aᵀ\]Δ). Here the same integral is its power series over a step of ‖A‖h
//! ≤ ¼, then doubled, Q(2h) = Q(h) + Φ(h)·Q(h)·Φ(h)ᵀ: sums of positive terms only. No inverse of Φ appears, which for a
//! strongly damped A is what overflows in van Loan's matrix; Q_d is symmetric to the bit and positive semidefinite to
//! rounding.
//!
//! On a group A is the error dynamics of one side: −ad_ω for the local error ([`super::local_error_dynamics`]), +ad_ϖ for
//! the global one. A density of a gyro, 0.01 rad/s/√Hz, is √Q; over 1 s it makes an error of 0.01 rad, over 4 s one of 0.02
//! rad.

use super::TrajectoryError;
use super::error::check_duration;
use super::kinematics::{local_error_dynamics, local_error_integral};
use crate::lie::{Jacobian, LieGroup, Real, Tangent};
use nalgebra::SMatrix;

/// Terms of the series: its operator X ↦ (AX + XAᵀ)h has a norm ≤ ½, and ½ⁿ/n! < ε/20 from n = 14 on.
const TERMS: usize = 15;

/// Φ and Q_d, both N×N, of ẋ = A·x + L·w over `duration`, with Q, M×M, the density of w. Van Loan (1978).
///
/// The scalar is a single number: how often the step is halved depends on its value.
///
/// # Errors
/// [`TrajectoryError::NotADuration`], or [`TrajectoryError::NotFinite`] (index 0, 1, 2: A, L, Q).
///
/// ```
/// use boxplus::trajectory::discretise;
/// use nalgebra::{matrix, vector};
/// // A cart: position and velocity, pushed by white acceleration of density 2 m/s²/√Hz.
/// let (phi, q_d) = discretise(&matrix![0.0, 1.0; 0.0, 0.0], &vector![0.0, 1.0], &matrix![4.0_f64], 0.5)?;
/// assert_eq!(phi, matrix![1.0, 0.5; 0.0, 1.0]);
/// assert!((q_d - matrix![0.125 / 3.0, 0.125; 0.125, 0.5] * 4.0).amax() < 1e-15);
/// # Ok::<(), boxplus::trajectory::TrajectoryError>(())
/// ```
pub fn discretise<S: Real, const N: usize, const M: usize>(
    a: &SMatrix<S, N, N>,
    l: &SMatrix<S, N, M>,
    q: &SMatrix<S, M, M>,
    duration: S,
) -> Result<(SMatrix<S, N, N>, SMatrix<S, N, N>), TrajectoryError> {
    check_duration(duration)?;
    let finite = [a.iter().all(is_finite), l.iter().all(is_finite), q.iter().all(is_finite)];
    if let Some(index) = finite.iter().position(|finite| !finite) {
        return Err(TrajectoryError::NotFinite { index });
    }
    let halvings = halvings(largest_column_sum(a) * duration.value());
    let step = duration * S::lit(1.0 / (1_u64 << halvings) as f64);
    let (mut phi, mut q_d) = series(&(a * step), &(l * q * l.transpose() * step));
    for _ in 0..halvings {
        q_d += symmetric(&(phi * q_d * phi.transpose()));
        phi *= phi;
    }
    Ok((phi, q_d))
}

/// exp(A) and ∫₀¹exp(As)·W·exp(As)ᵀds for ‖A‖ ≤ ¼: terms Tₖ = (A·Tₖ₋₁ + Tₖ₋₁·Aᵀ)/(k + 1) from T₀ = W.
fn series<S: Real, const N: usize>(
    a: &SMatrix<S, N, N>,
    w: &SMatrix<S, N, N>,
) -> (SMatrix<S, N, N>, SMatrix<S, N, N>) {
    let mut power = SMatrix::<S, N, N>::identity();
    let mut term = symmetric(w);
    let (mut phi, mut q_d) = (power, term);
    for k in 1..=TERMS {
        power = a * power * S::lit(1.0 / k as f64);
        phi += power;
        term = symmetric(&(a * term)) * S::lit(2.0 / (k + 1) as f64);
        q_d += term;
    }
    (phi, q_d)
}

/// (M + Mᵀ)/2.
fn symmetric<S: Real, const N: usize>(m: &SMatrix<S, N, N>) -> SMatrix<S, N, N> {
    (m + m.transpose()) * S::lit(0.5)
}

fn is_finite<S: Real>(x: &S) -> bool {
    x.value().is_finite()
}

/// ‖A‖₁.
fn largest_column_sum<S: Real, const N: usize>(a: &SMatrix<S, N, N>) -> f64 {
    let sums = a.column_iter().map(|column| column.iter().map(|x| x.value().abs()).sum::<f64>());
    sums.fold(0.0, f64::max)
}

/// How often to halve until ≤ ¼; 60 times at most, beyond which exp has overflowed or vanished.
fn halvings(size: f64) -> u32 {
    (0..60).find(|n| size <= 0.25 * (1_u64 << n) as f64).unwrap_or(60)
}

/// Φ and Q_d of the local error of X over a step with body velocity ω + w, w white of density Q: exact for constant ω.
///
/// ```text
/// Φ = Ad(Exp(−ωΔ))        Q_d = ∫₀^Δ Ad(Exp(−ωs))·Q·Ad(Exp(−ωs))ᵀ ds
/// ```
/// On SO(3) with Q = σ²I it is σ²Δ·I.
///
/// # Errors
/// Those of [`discretise`].
pub fn velocity_noise<G: LieGroup<D>, const D: usize>(
    omega: &Tangent<G::Scalar, D>,
    q: &Jacobian<G::Scalar, D>,
    duration: G::Scalar,
) -> Result<(Jacobian<G::Scalar, D>, Jacobian<G::Scalar, D>), TrajectoryError> {
    discretise(&local_error_dynamics::<G, D>(omega), &SMatrix::identity(), q, duration)
}

/// Q_d ≈ Δ·J_r(ωΔ)·Q·J_r(ωΔ)ᵀ: [`velocity_noise`] as if w were constant over the step; off by O(|ω|²Δ³).
///
/// ```
/// use boxplus::lie::SE2;
/// use boxplus::trajectory::{velocity_noise, velocity_noise_first_order};
/// use nalgebra::{Matrix3, Vector3};
/// let (omega, q) = (Vector3::new(1.0, 0.0, 0.5), Matrix3::from_diagonal(&Vector3::new(1e-4, 1e-6, 1e-4)));
/// let (_, exact) = velocity_noise::<SE2, 3>(&omega, &q, 0.1)?;
/// let near = velocity_noise_first_order::<SE2, 3>(&omega, &q, 0.1);
/// assert!((exact - near).norm() < 1e-3 * exact.norm());
/// # Ok::<(), boxplus::trajectory::TrajectoryError>(())
/// ```
pub fn velocity_noise_first_order<G: LieGroup<D>, const D: usize>(
    omega: &Tangent<G::Scalar, D>,
    q: &Jacobian<G::Scalar, D>,
    duration: G::Scalar,
) -> Jacobian<G::Scalar, D> {
    let integral = local_error_integral::<G, D>(omega, duration);
    let per_time = G::Scalar::lit(1.0) / duration;
    integral * q * integral.transpose() * per_time
}
