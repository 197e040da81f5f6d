//! Written as an outsider: a group the library does not have passes its laws by one line.
#![allow(missing_docs, clippy::unwrap_used)]

use boxplus::lie::{Action, LieGroup, Manifold, Real, laws};
use boxplus::uncertainty::{Gaussian, Order};
use nalgebra::{Matrix1, Matrix1x2, Matrix2, Vector1, Vector2};

/// The affine maps x ↦ s·x + b of the line with s > 0: scale and offset of a sensor. Tangent (ρ, σ), matrix \[s b; 0 1\].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Affine<S = f64> {
    scale: S,
    offset: S,
}

/// (e^σ − 1)/σ.
fn f<S: Real>(sigma: S) -> S {
    S::choose(sigma.simd_abs().simd_lt(S::lit(1e-3)), || series(sigma, 1), || sigma.simd_exp_m1() / sigma)
}

/// (e^σ − 1 − σ)/σ².
fn g<S: Real>(sigma: S) -> S {
    let closed = || (sigma.simd_exp_m1() - sigma) / (sigma * sigma);
    S::choose(sigma.simd_abs().simd_lt(S::lit(0.5)), || series(sigma, 2), closed)
}

/// Σ σᵏ/(k + shift)!.
fn series<S: Real>(sigma: S, shift: usize) -> S {
    let start = S::lit(if shift == 1 { 1.0 } else { 0.5 });
    let (mut term, mut sum) = (start, start);
    for k in 1..16 {
        term = term * sigma / S::lit((k + shift) as f64);
        sum += term;
    }
    sum
}

impl<S: Real> LieGroup<2> for Affine<S> {
    type Scalar = S;
    type Over<T: Real> = Affine<T>;
    type Algebra = Matrix2<S>;

    fn identity() -> Self {
        Self { scale: S::one(), offset: S::zero() }
    }
    fn compose(&self, rhs: &Self) -> Self {
        Self { scale: self.scale * rhs.scale, offset: self.scale * rhs.offset + self.offset }
    }
    fn inverse(&self) -> Self {
        Self { scale: S::one() / self.scale, offset: -self.offset / self.scale }
    }
    fn exp(tau: &Vector2<S>) -> Self {
        Self { scale: tau.y.simd_exp(), offset: tau.x * f(tau.y) }
    }
    fn log(&self) -> Vector2<S> {
        let sigma = self.scale.simd_ln();
        Vector2::new(self.offset / f(sigma), sigma)
    }
    fn adjoint(&self) -> Matrix2<S> {
        Matrix2::new(self.scale, -self.offset, S::zero(), S::one())
    }
    fn small_adjoint(tau: &Vector2<S>) -> Matrix2<S> {
        Matrix2::new(tau.y, -tau.x, S::zero(), S::zero())
    }
    fn right_jacobian(tau: &Vector2<S>) -> Matrix2<S> {
        Matrix2::new(f(-tau.y), tau.x * g(-tau.y), S::zero(), S::one())
    }
    fn right_jacobian_inverse(tau: &Vector2<S>) -> Matrix2<S> {
        let f = f(-tau.y);
        Matrix2::new(S::one() / f, -tau.x * g(-tau.y) / f, S::zero(), S::one())
    }
    fn hat(tau: &Vector2<S>) -> Matrix2<S> {
        Matrix2::new(tau.y, tau.x, S::zero(), S::zero())
    }
    fn vee(algebra: &Matrix2<S>) -> Vector2<S> {
        Vector2::new(algebra.m12, algebra.m11)
    }
    fn map<T: Real>(&self, f: impl Fn(S) -> T) -> Affine<T> {
        Affine { scale: f(self.scale), offset: f(self.offset) }
    }
}

impl<S: Real> Action<2, 1> for Affine<S> {
    fn act(&self, p: &Vector1<S>) -> Vector1<S> {
        p * self.scale + Vector1::new(self.offset)
    }
    fn linear_part(&self) -> Matrix1<S> {
        Matrix1::new(self.scale)
    }
    fn generators_at(p: &Vector1<S>) -> Matrix1x2<S> {
        Matrix1x2::new(S::one(), p.x)
    }
}

#[test]
fn a_users_group_passes_the_laws_in_one_line() {
    laws::check_group::<Affine, 2>().unwrap();
}

#[test]
fn a_users_group_passes_the_laws_in_f32() {
    laws::check_group::<Affine<f32>, 2>().unwrap();
}

#[test]
fn a_users_action_passes_the_laws_in_one_line() {
    laws::check_action::<Affine, 2, 1>().unwrap();
}

#[test]
fn a_users_group_carries_uncertainty() {
    let x = Affine { scale: 2.0, offset: 1.0 };
    let gaussian = Gaussian::<Affine, 2>::from_sigmas(x, &Vector2::new(0.1, 0.05)).unwrap();
    let (p, j) = (Vector1::new(3.0), x.act_jac(&Vector1::new(3.0)).1);
    let seen = gaussian.act(&p, Order::First);
    let expected = j * gaussian.covariance().matrix() * j.transpose();
    assert!((seen.covariance().matrix() - expected).amax() < 1e-15);
    let back = gaussian.to_global().inverse().inverse().to_local();
    assert!((back.covariance().matrix() - gaussian.covariance().matrix()).amax() < 1e-16);
    assert!(
        gaussian.compose(&gaussian.inverse(), Order::Fourth).mean().log().amax() < 1e-4,
        "the shift of E[ξ]"
    );
}

/// The same group with one wrong item, chosen by `FAULT`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Faulty<const FAULT: usize, S = f64>(Affine<S>);

impl<const FAULT: usize, S: Real> LieGroup<2> for Faulty<FAULT, S> {
    type Scalar = S;
    type Over<T: Real> = Faulty<FAULT, T>;
    type Algebra = Matrix2<S>;

    fn identity() -> Self {
        Self(Affine::identity())
    }
    fn compose(&self, rhs: &Self) -> Self {
        Self(self.0.compose(&rhs.0))
    }
    fn inverse(&self) -> Self {
        // The offset of the inverse without the scale: right for pure translations only.
        let inverse = self.0.inverse();
        Self(if FAULT == 1 { Affine { offset: -self.0.offset, ..inverse } } else { inverse })
    }
    fn exp(tau: &Vector2<S>) -> Self {
        // The offset moved by ρ: right to first order.
        let exp = Affine::exp(tau);
        Self(if FAULT == 2 { Affine { offset: tau.x, ..exp } } else { exp })
    }
    fn log(&self) -> Vector2<S> {
        self.0.log()
    }
    fn adjoint(&self) -> Matrix2<S> {
        let ad = self.0.adjoint();
        if FAULT == 3 { Matrix2::new(ad.m11, -ad.m12, ad.m21, ad.m22) } else { ad }
    }
    fn small_adjoint(tau: &Vector2<S>) -> Matrix2<S> {
        let ad = Affine::small_adjoint(tau);
        if FAULT == 4 { -ad } else { ad }
    }
    fn right_jacobian(tau: &Vector2<S>) -> Matrix2<S> {
        // I − ½ad: right to first order.
        let first_order = Matrix2::identity() - Affine::small_adjoint(tau) * S::lit(0.5);
        if FAULT == 5 { first_order } else { Affine::right_jacobian(tau) }
    }
    fn right_jacobian_inverse(tau: &Vector2<S>) -> Matrix2<S> {
        let left_instead = Affine::right_jacobian_inverse(&-tau);
        if FAULT == 6 { left_instead } else { Affine::right_jacobian_inverse(tau) }
    }
    fn right_jacobian_derivative(tau: &Vector2<S>, delta: &Vector2<S>) -> Matrix2<S> {
        // −½ad: right at 0 only.
        let at_zero = Affine::small_adjoint(delta) * S::lit(-0.5);
        if FAULT == 8 { at_zero } else { Affine::right_jacobian_derivative(tau, delta) }
    }
    fn hat(tau: &Vector2<S>) -> Matrix2<S> {
        Affine::hat(tau)
    }
    fn vee(algebra: &Matrix2<S>) -> Vector2<S> {
        let vee = Affine::vee(algebra);
        if FAULT == 7 { vee.yx() } else { vee }
    }
    fn map<T: Real>(&self, f: impl Fn(S) -> T) -> Faulty<FAULT, T> {
        Faulty(LieGroup::map(&self.0, f))
    }
}

#[test]
fn a_faulty_group_is_told_which_law_fails() {
    let law = |verdict: Result<(), laws::Violation>| verdict.unwrap_err().law;
    assert!(laws::check_group::<Faulty<0>, 2>().is_ok());
    assert_eq!(law(laws::check_group::<Faulty<1>, 2>()), "(XY)⁻¹ = Y⁻¹X⁻¹");
    assert_eq!(law(laws::check_group::<Faulty<2>, 2>()), "Log(Exp τ) = τ");
    assert_eq!(law(laws::check_group::<Faulty<3>, 2>()), "Ad_{Exp τ} = Σ adᵏ/k!");
    assert_eq!(law(laws::check_group::<Faulty<4>, 2>()), "Ad_{Exp τ} = Σ adᵏ/k!");
    assert_eq!(law(laws::check_group::<Faulty<5>, 2>()), "J_l = Σ adᵏ/(k + 1)!");
    assert_eq!(law(laws::check_group::<Faulty<6>, 2>()), "J_r·J_r⁻¹ = I");
    assert_eq!(law(laws::check_group::<Faulty<7>, 2>()), "vee(hat(τ)) = τ");
    assert_eq!(law(laws::check_group::<Faulty<8>, 2>()), "DJ_r[δ] is that of the series");
}

/// A share between 0 and 1, moved by its log-odds: a manifold of a user's own, written without the group trait.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Share<S = f64>(S);

impl<S: Real> Share<S> {
    fn log_odds(&self) -> S {
        (self.0 / (S::one() - self.0)).simd_ln()
    }
}

impl<S: Real> Manifold<1> for Share<S> {
    type Scalar = S;
    type Over<T: Real> = Share<T>;

    fn plus(&self, tau: &Vector1<S>) -> Self {
        Self(S::one() / (S::one() + (-self.log_odds() - tau.x).simd_exp()))
    }
    fn minus(&self, base: &Self) -> Vector1<S> {
        Vector1::new(self.log_odds() - base.log_odds())
    }
    fn plus_jac(&self, tau: &Vector1<S>) -> (Self, Matrix1<S>, Matrix1<S>) {
        (self.plus(tau), Matrix1::identity(), Matrix1::identity())
    }
    fn minus_jac(&self, base: &Self) -> (Vector1<S>, Matrix1<S>, Matrix1<S>) {
        (self.minus(base), Matrix1::identity(), -Matrix1::identity())
    }
    fn map<T: Real>(&self, f: impl Fn(S) -> T) -> Share<T> {
        Share(f(self.0))
    }
}

#[test]
fn a_users_manifold_passes_the_axioms_in_one_line() {
    laws::check_manifold(&[Share(0.5), Share(0.1), Share(0.9)], 1.0).unwrap();
    laws::check_manifold(&[Share(0.5_f32), Share(0.25)], 1.0).unwrap();
}
