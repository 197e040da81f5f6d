//! Gaussian-process priors on trajectories: white noise on acceleration (WNOA) or on jerk (WNOJ), and what they say between
//! two states.
//!
//! ```text
//! X(t) = X_k·Exp(ξ(t))      d^R ξ/dtᴿ = w, white of density Q_c       γ = (ξ, ξ̇, …) ∈ ℝᴿᴰ       R = 2: WNOA, R = 3: WNOJ
//! Φ_ij = Δʲ⁻ⁱ/(j − i)!      Q_ij = Δ^{2R−1−i−j}/((2R−1−i−j)·(R−1−i)!·(R−1−j)!)        i, j from 0; each ⊗ I or ⊗ Q_c
//! ends     γ_k = (0, ω_k, ω̇_k),   γ_{k+1} = (ξ₁, J_r⁻¹(ξ₁)ω_{k+1}, …),   ξ₁ = X_{k+1} ⊖ X_k
//! error    e = γ_{k+1} − Φ(Δ)γ_k ~ N(0, Q(Δ) ⊗ Q_c)
//! query    γ(t) = Λ·γ_k + Ψ·γ_{k+1}      Ψ = Q(t)·Φ(Δ − t)ᵀ·Q(Δ)⁻¹      Λ = Φ(t) − Ψ·Φ(Δ)
//!          γ(t) given both ends ~ N(·, (Q(t) − Ψ·Q(Δ)·Ψᵀ) ⊗ Q_c)
//! ```
//! Anderson & Barfoot (2015), Tang et al. (2019), Barfoot (2024) §11, in our local convention: theirs are ξ = Log(X·X_k⁻¹)
//! with J_l⁻¹. Where they take ξ̈ ≈ J_r⁻¹ω̇ + ½ad(J_r⁻¹ω)·ω, here it is exact, J_r⁻¹(ω̇ − (d/dt J_r)ξ̇).
//!
//! All four matrices are R×R: Q_c cancels in the query. On ℝⁿ the mean between two states is the cubic (R = 2) or quintic
//! (R = 3) Hermite polynomial.

use super::chain::scaled_identity;
use super::error::{check_duration, check_finite, check_ways};
use super::{Motion, TrajectoryError};
use crate::lie::second_order::right_jacobian_product_derivative;
use crate::lie::{Jacobian, LieGroup, Real, Tangent};
use nalgebra::SMatrix;

/// Φ(Δ), R×R (⊗ I): Δʲ⁻ⁱ/(j − i)!.
pub fn gp_transition<S: Real, const R: usize>(duration: S) -> SMatrix<S, R, R> {
    SMatrix::from_fn(|i, j| match j.checked_sub(i) {
        Some(n) => power(duration, n) * S::lit(1.0 / factorial(n)),
        None => S::zero(),
    })
}

/// Q(Δ), R×R (⊗ Q_c): WNOA \[Δ³/3, Δ²/2; Δ²/2, Δ\], WNOJ \[Δ⁵/20, Δ⁴/8, Δ³/6; ·, Δ³/3, Δ²/2; ·, ·, Δ\].
pub fn gp_covariance<S: Real, const R: usize>(duration: S) -> SMatrix<S, R, R> {
    SMatrix::from_fn(|i, j| {
        let (a, b) = (R - 1 - i, R - 1 - j);
        let n = a + b + 1;
        power(duration, n) * S::lit(1.0 / (n as f64 * factorial(a) * factorial(b)))
    })
}

/// Q(Δ)⁻¹, R×R (⊗ Q_c⁻¹), in closed form: Q is a scaled Hilbert matrix. WNOA \[12/Δ³, −6/Δ²; −6/Δ², 4/Δ\].
pub fn gp_information<S: Real, const R: usize>(duration: S) -> SMatrix<S, R, R> {
    let rate = S::one() / duration;
    SMatrix::from_fn(|i, j| {
        let (a, b) = (R - 1 - i, R - 1 - j);
        let hilbert = inverse_hilbert(R, a, b) * factorial(a) * factorial(b);
        power(rate, a + b + 1) * S::lit(hilbert)
    })
}

/// (Λ, Ψ), R×R (⊗ I): the mean at t ∈ \[0, Δ\] is Λγ_k + Ψγ_{k+1}.
///
/// ```
/// use boxplus::trajectory::gp_interpolation;
/// // Half way of WNOA: ξ = ½(ξ₀ + ξ₁) + Δ/8·(ξ̇₀ − ξ̇₁).
/// let (lambda, psi) = gp_interpolation::<f64, 2>(2.0, 1.0);
/// assert!((lambda.row(0) - nalgebra::RowVector2::new(0.5, 0.25)).amax() < 1e-15);
/// assert!((psi.row(0) - nalgebra::RowVector2::new(0.5, -0.25)).amax() < 1e-15);
/// ```
pub fn gp_interpolation<S: Real, const R: usize>(duration: S, t: S) -> (SMatrix<S, R, R>, SMatrix<S, R, R>) {
    let gain = gp_transition::<S, R>(duration - t).transpose() * gp_information(duration);
    let psi = gp_covariance(t) * gain;
    (gp_transition(t) - psi * gp_transition(duration), psi)
}

/// t²ᴿ⁻¹(Δ − t)²ᴿ⁻¹/((2R − 1)·(R − 1)!²·Δ²ᴿ⁻¹) (⊗ Q_c): the variance of ξ at t ∈ \[0, Δ\] that the prior leaves when both ends are known, the
/// first entry of Q(t) − Ψ·Q(Δ)·Ψᵀ without its cancellation; R = 1 is the Brownian bridge.
///
/// ```
/// use boxplus::trajectory::gp_bridge;
/// assert!((gp_bridge::<f64, 2>(2.0, 1.0) - 1.0 / 24.0).abs() < 1e-16);
/// ```
pub fn gp_bridge<S: Real, const R: usize>(duration: S, t: S) -> S {
    let n = 2 * R - 1;
    let size = n as f64 * factorial(R - 1) * factorial(R - 1);
    power(t * (duration - t) / duration, n) * S::lit(1.0 / size)
}

/// Two states of a trajectory with a prior of order R between them: R = 2 for WNOA, R = 3 for WNOJ.
///
/// WNOA reads value and velocity of its ends, WNOJ their accelerations, too. Weigh [`GaussianProcess::error`] with
/// [`gp_information`] ⊗ Q_c⁻¹.
///
/// ```
/// use boxplus::lie::{LieGroup, SE3};
/// use boxplus::trajectory::{GaussianProcess, Motion};
/// use nalgebra::Vector6;
/// let omega = Vector6::new(1.0, 0.0, 0.0, 0.0, 0.0, 0.5);
/// let (start, end) = (SE3::identity(), SE3::exp(&(omega * 2.0)));
/// let between = GaussianProcess::<_, 6, 2>::new(Motion::steady(start, omega), Motion::steady(end, omega), 2.0)?;
/// assert!(between.error().iter().all(|e| e.norm() < 1e-14)); // constant velocity is what WNOA expects
/// let now = between.at(0.7)?;
/// assert!(now.value.rminus(&SE3::exp(&(omega * 0.7))).norm() < 1e-14 && (now.velocity - omega).norm() < 1e-14);
/// # Ok::<(), boxplus::trajectory::TrajectoryError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianProcess<G: LieGroup<D>, const D: usize, const R: usize> {
    from: Motion<G, D>,
    duration: G::Scalar,
    /// ξ₁, ξ̇₁, ξ̈₁; ξ⃛₁ is not read.
    arrival: [Tangent<G::Scalar, D>; 4],
}

impl<G: LieGroup<D>, const D: usize, const R: usize> GaussianProcess<G, D, R> {
    /// From one state to the next, `duration` later.
    ///
    /// # Errors
    /// [`TrajectoryError::NotADuration`], [`TrajectoryError::NotFinite`] (what is read of the first state, 0, or the second, 1), or
    /// [`TrajectoryError::Ambiguous`] where the states are half a turn apart.
    pub fn new(from: Motion<G, D>, to: Motion<G, D>, duration: G::Scalar) -> Result<Self, TrajectoryError> {
        check_duration(duration)?;
        check_ways(&[from.value, to.value])?;
        for (index, state) in [&from, &to].into_iter().enumerate() {
            check_finite(&state.velocity, index)?;
            if R == 3 {
                check_finite(&state.acceleration, index)?;
            }
        }
        Ok(Self::unchecked(from, to, duration))
    }

    /// The same where the duration is known to be one; of states half a turn apart, one of the two ways.
    pub(crate) fn unchecked(from: Motion<G, D>, to: Motion<G, D>, duration: G::Scalar) -> Self {
        const { assert!(R == 2 || R == 3, "2: white noise on acceleration, 3: on jerk") };
        let relative = Motion { value: from.value.between(&to.value), ..to };
        Self { from, duration, arrival: relative.coordinates() }
    }

    /// e = γ_{k+1} − Φ(Δ)γ_k: R blocks, of ξ, ξ̇, ….
    pub fn error(&self) -> [Tangent<G::Scalar, D>; R] {
        let (start, phi) = (self.departure(), gp_transition::<G::Scalar, R>(self.duration));
        core::array::from_fn(|i| (0..R).fold(self.arrival[i], |sum, j| sum - start[j] * phi[(i, j)]))
    }

    /// The mean at t ∈ \[0, Δ\] after the first state, with its rates; those beyond the state are the derivatives of the
    /// mean.
    ///
    /// # Errors
    /// [`TrajectoryError::OutOfRange`].
    pub fn at(&self, t: G::Scalar) -> Result<Motion<G, D>, TrajectoryError> {
        self.check_time(t)?;
        Ok(self.query(t))
    }

    /// X(t) alone, for a time that is known to lie between the states.
    #[cfg(feature = "solve")]
    pub(crate) fn value_at(&self, t: G::Scalar) -> G {
        self.from.value.rplus(&self.mean(t)[0])
    }

    /// [`GaussianProcess::at`] for a time that is known to lie between the states.
    fn query(&self, t: G::Scalar) -> Motion<G, D> {
        let relative = Motion::<G, D>::from_coordinates(&self.mean(t));
        Motion { value: self.from.value.compose(&relative.value), ..relative }
    }

    /// The covariance of X(t), local, that the prior of density Q_c leaves when both states are known: c·J_r(ξ)·Q_c·J_r(ξ)ᵀ with c of [`gp_bridge`].
    ///
    /// # Errors
    /// [`TrajectoryError::OutOfRange`].
    pub fn noise_at(
        &self,
        t: G::Scalar,
        density: &Jacobian<G::Scalar, D>,
    ) -> Result<Jacobian<G::Scalar, D>, TrajectoryError> {
        self.check_time(t)?;
        let right = G::right_jacobian(&self.mean(t)[0]);
        Ok(right * density * right.transpose() * gp_bridge::<G::Scalar, R>(self.duration, t))
    }

    fn check_time(&self, t: G::Scalar) -> Result<(), TrajectoryError> {
        let (time, end) = (t.value(), self.duration.value());
        if time >= 0.0 && time <= end {
            Ok(())
        } else {
            Err(TrajectoryError::OutOfRange { time, start: 0.0, end })
        }
    }

    /// γ_k.
    fn departure(&self) -> [Tangent<G::Scalar, D>; 3] {
        [Tangent::<G::Scalar, D>::zeros(), self.from.velocity, self.from.acceleration]
    }

    /// ξ, ξ̇, ξ̈, ξ⃛ at t.
    fn mean(&self, t: G::Scalar) -> [Tangent<G::Scalar, D>; 4] {
        let start = self.departure();
        self.rows(t).map(|(lambda, psi)| {
            let mut sum = Tangent::<G::Scalar, D>::zeros();
            for j in 0..R {
                sum += start[j] * lambda[j] + self.arrival[j] * psi[j];
            }
            sum
        })
    }

    /// The rows of (Λ, Ψ) that give ξ and its derivatives. Beyond the state, ξ⁽ᴿ⁾ is the mean of the noise, the last row of
    /// Φ(Δ − t)ᵀQ(Δ)⁻¹, and every further derivative is the row above with the other sign.
    fn rows(&self, t: G::Scalar) -> [([G::Scalar; R], [G::Scalar; R]); 4] {
        let (lambda, psi) = gp_interpolation::<G::Scalar, R>(self.duration, t);
        let gain =
            gp_transition::<G::Scalar, R>(self.duration - t).transpose() * gp_information(self.duration);
        let back = gain * gp_transition::<G::Scalar, R>(self.duration);
        let row = |m: &SMatrix<G::Scalar, R, R>, i: usize| core::array::from_fn(|j| m[(i, j)]);
        core::array::from_fn(|i| match i.checked_sub(R) {
            None => (row(&lambda, i), row(&psi, i)),
            Some(0) => (row(&-back, R - 1), row(&gain, R - 1)),
            Some(_) => (row(&back, R - 2), row(&-gain, R - 2)),
        })
    }
}

/// How value and velocity at a time between two states answer to one argument; right (local) Jacobians, D×D.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateJac<S, const D: usize> {
    /// ∂X/∂·.
    pub value: Jacobian<S, D>,
    /// ∂ω/∂·.
    pub velocity: Jacobian<S, D>,
}

/// Derivatives in the states: first those in the earlier one, then in the later one, each in X, ω and, for WNOJ, ω̇.
impl<G: LieGroup<D>, const D: usize, const R: usize> GaussianProcess<G, D, R> {
    /// e with its derivatives `d_e[end][argument][block]`, D×D.
    pub fn error_jac(&self) -> ([Tangent<G::Scalar, D>; R], [[[Jacobian<G::Scalar, D>; R]; R]; 2]) {
        let (rows, [xi_from, xi_to]) = self.arrival_jac();
        let phi = gp_transition::<G::Scalar, R>(self.duration);
        let from = core::array::from_fn(|argument| {
            core::array::from_fn(|block| match argument {
                0 => rows[block][0] * xi_from,
                _ => scaled_identity(-phi[(block, argument)]),
            })
        });
        let to = core::array::from_fn(|argument| {
            core::array::from_fn(|block| match argument {
                0 => rows[block][0] * xi_to,
                _ => rows[block][argument],
            })
        });
        (self.error(), [from, to])
    }

    /// [`GaussianProcess::at`] with the derivatives of its value and velocity, `d_state[end][argument]`.
    ///
    /// # Errors
    /// [`TrajectoryError::OutOfRange`].
    pub fn at_jac(
        &self,
        t: G::Scalar,
    ) -> Result<(Motion<G, D>, [[StateJac<G::Scalar, D>; R]; 2]), TrajectoryError> {
        self.check_time(t)?;
        Ok((self.query(t), self.query_jac(t)))
    }

    /// The derivatives of [`GaussianProcess::query`].
    pub(crate) fn query_jac(&self, t: G::Scalar) -> [[StateJac<G::Scalar, D>; R]; 2] {
        let [(lambda, psi), (d_lambda, d_psi), ..] = self.rows(t);
        let [xi, rate, ..] = self.mean(t);
        let (rows, [xi_from, xi_to]) = self.arrival_jac();
        let (right, bend) = (G::right_jacobian(&xi), right_jacobian_product_derivative::<G, D>(&xi, &rate));
        let answer = |d_xi: Jacobian<G::Scalar, D>, d_rate: Jacobian<G::Scalar, D>| StateJac {
            value: right * d_xi,
            velocity: bend * d_xi + right * d_rate,
        };
        let arrival = |argument: usize, inner: &Jacobian<G::Scalar, D>| {
            let [d_xi, d_rate] = [psi, d_psi].map(|gain| {
                let zero = Jacobian::<G::Scalar, D>::zeros();
                (0..R).fold(zero, |sum, j| sum + rows[j][argument] * gain[j]) * inner
            });
            answer(d_xi, d_rate)
        };
        let mut from = core::array::from_fn(|m| match m {
            0 => arrival(0, &xi_from),
            _ => answer(scaled_identity(lambda[m]), scaled_identity(d_lambda[m])),
        });
        from[0].value += G::exp(&-xi).adjoint();
        let identity = Jacobian::<G::Scalar, D>::identity();
        let to = core::array::from_fn(|m| arrival(m, if m == 0 { &xi_to } else { &identity }));
        [from, to]
    }

    /// ∂(ξ₁, ξ̇₁, ξ̈₁) in (ξ₁, ω, ω̇) of X_{k+1}, `rows[i][argument]`, and ∂ξ₁ in X_k and X_{k+1}. With K = J_r⁻¹(ξ₁), v = ξ̇₁:
    ///
    /// ```text
    /// ξ̇₁ = K·ω                  ∂/∂ξ₁ = −K·F(ξ₁, v)                                          ∂/∂ω = K
    /// ξ̈₁ = K·(ω̇ − F(ξ₁, v)v)    ∂/∂ξ₁ = −K·(F(ξ₁, ξ̈₁) + ∂(Fv)/∂ξ + ∂(Fv)/∂v·∂v/∂ξ₁)          ∂/∂ω = −K·∂(Fv)/∂v·K
    /// ```
    fn arrival_jac(&self) -> ([[Jacobian<G::Scalar, D>; R]; R], [Jacobian<G::Scalar, D>; 2]) {
        let [xi, rate, second, _] = &self.arrival;
        let (inverse, zero) = (G::right_jacobian_inverse(xi), Jacobian::<G::Scalar, D>::zeros());
        let d_rate = -(inverse * right_jacobian_product_derivative::<G, D>(xi, rate));
        let mut full =
            [[Jacobian::<G::Scalar, D>::identity(), zero, zero], [d_rate, inverse, zero], [zero; 3]];
        if R > 2 {
            let [d_xi, d_v] = second_bend::<G, D>(xi, rate);
            let bend = right_jacobian_product_derivative::<G, D>(xi, second) + d_xi + d_v * d_rate;
            full[2] = [-(inverse * bend), -(inverse * d_v * inverse), inverse];
        }
        let rows = core::array::from_fn(|i| core::array::from_fn(|argument| full[i][argument]));
        (rows, [-G::left_jacobian_inverse(xi), inverse])
    }
}

/// xⁿ.
fn power<S: Real>(x: S, n: usize) -> S {
    (0..n).fold(S::one(), |product, _| product * x)
}

/// n!, exact for what is needed here.
fn factorial(n: usize) -> f64 {
    (2..=n).fold(1.0, |product, k| product * k as f64)
}

/// (H⁻¹)_{ab} of the R×R Hilbert matrix H_ab = 1/(a + b + 1), an integer: Choi (1983).
fn inverse_hilbert(r: usize, a: usize, b: usize) -> f64 {
    let binomial = |n: usize, k: usize| factorial(n) / (factorial(k) * factorial(n - k));
    let sign = if (a + b).is_multiple_of(2) { 1.0 } else { -1.0 };
    let middle = binomial(a + b, a);
    sign * (a + b + 1) as f64 * binomial(r + a, r - b - 1) * binomial(r + b, r - a - 1) * middle * middle
}

/// \[∂(F(τ, v)·v)/∂τ, ∂(F(τ, v)·v)/∂v\] for |φ| ≤ π: how the acceleration of Exp(τ + vt) answers to τ and to v.
///
/// With tₙ = (−ad_τ)ⁿ·v and sₙ = ∂tₙ/∂τ·v = −\[v, tₙ₋₁\] − \[τ, sₙ₋₁\], F(τ, v)·v = Σ sₙ/(n + 1)!, differentiated term by term.
fn second_bend<G: LieGroup<D>, const D: usize>(
    tau: &Tangent<G::Scalar, D>,
    v: &Tangent<G::Scalar, D>,
) -> [Jacobian<G::Scalar, D>; 2] {
    // n²πⁿ⁻²/(n + 1)! < ε/100 from n = 29 on.
    const LONG: usize = 30;
    let zero = Jacobian::<G::Scalar, D>::zeros();
    let (ad, along) = (G::small_adjoint(tau), G::small_adjoint(v));
    let (mut t, mut s) = (*v, Tangent::<G::Scalar, D>::zeros());
    let (mut t_tau, mut t_v) = (zero, Jacobian::<G::Scalar, D>::identity());
    let (mut s_tau, mut s_v) = (zero, zero);
    let mut sum = [zero; 2];
    let mut reciprocal = 1.0;
    for n in 1..=LONG {
        let ad_t = G::small_adjoint(&t);
        (s_tau, s_v) = (G::small_adjoint(&s) - along * t_tau - ad * s_tau, ad_t - along * t_v - ad * s_v);
        s = -(along * t + ad * s);
        (t_tau, t_v) = (ad_t - ad * t_tau, -(ad * t_v));
        t = -(ad * t);
        reciprocal /= (n + 1) as f64;
        sum[0] += s_tau * G::Scalar::lit(reciprocal);
        sum[1] += s_v * G::Scalar::lit(reciprocal);
    }
    sum
}
