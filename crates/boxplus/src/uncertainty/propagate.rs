//! Products of uncertain elements, to first, second and fourth order.
//!
//! Bring both errors into the frame of the output (local Ad₂⁻¹ξ₁ and ξ₂, global ξ₁ and Ad₁ξ₂: exact). Then the error of the
//! product is ξ = Log(Exp ξ₁·Exp ξ₂) on either side and in every group, and its moments follow from the
//! Baker–Campbell–Hausdorff series. With S = E\[ξ₁ξ₂ᵀ\], ad_a the ad of basis vector e_a, s_b and s'_b row and column b of S:
//!
//! ```text
//! 1st, 2nd   Σ = Σ₁ + Σ₂ + S + Sᵀ
//! 2nd        E[ξ] = m = ½ Σ_a ad_a·s_a
//! 4th        Σ = Σ₁ + Σ₂ + S + Sᵀ + T + Tᵀ + ¼[B + Σ_jl (ad_j·s_l)(ad_l·s_j)ᵀ]
//!            T = [(A₁ + G₂ + 2ad_m)(Σ₂ + Sᵀ) + (A₂ + G₁ − 2ad_m)(Σ₁ + S)]/12
//!            A_k = Σ_a ad_a·ad(Σ_k e_a)   B = Σ_a ad_a·Σ₂·ad(Σ₁e_a)ᵀ   G₁ = −Σ_b ad_b·ad(s_b)   G₂ = −Σ_b ad_b·ad(s'_b)
//!            E[ξ] = m − (1/24) Σ_a [ad_a·A₁·Σ₂e_a + ad(s_a)·ad_a·2m + Σ_b ad(s_a)·ad_b·ad_a·s_b]
//! ```
//!
//! To fourth order the series may lose a little of its definiteness where a direction has no variance. With P, Q the two
//! brackets of T, Σ + E\[(Pξ₂ + Qξ₁)(Pξ₂ + Qξ₁)ᵀ\]/144 is a sum of squares and differs in the sixth order only: that is what
//! products return, always a covariance.
//!
//! Barfoot & Furgale (2014) (38), (55) for S = 0, there in blocks of SE(3); Mangelson et al. (2020) for S ≠ 0, here closed.

use super::{Covariance, Gaussian, Side};
use crate::lie::{Jacobian, LieGroup, Real, Tangent};
use nalgebra::SMatrix;

/// Up to which power of the standard deviations the moments of a result are kept.
///
/// "Second order" is what Barfoot & Furgale (2014) call the covariance JΣJᵀ, and others "first order": the terms are of
/// second order in the errors. Here `First` is that covariance with the mean of the means, `Second` adds the shift of the
/// mean, `Fourth` the next terms of both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// Linearised: the mean of the means, JΣJᵀ.
    First,
    /// And the mean's shift of second order: that of a point acted on, or of a product of correlated elements. A product of
    /// independent elements has none.
    #[default]
    Second,
    /// And all terms of fourth order, of mean and covariance.
    Fourth,
}

/// What becomes of two errors in one frame: [`compound`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compounded<S, const D: usize> {
    /// E\[ξ\].
    pub shift: Tangent<S, D>,
    /// Covariance of ξ about E\[ξ\], D×D, as published.
    pub covariance: SMatrix<S, D, D>,
    /// The terms of sixth order, D×D, that complete the squares: with them the covariance is positive semi-definite.
    pub completion: SMatrix<S, D, D>,
}

/// Mean and covariance of ξ = Log(Exp ξ₁·Exp ξ₂), formulas above. `first` = Σ₁ and `second` = Σ₂ stand in the frame of the
/// output, `cross` = E\[ξ₁ξ₂ᵀ\]; D×D each.
pub fn compound<G: LieGroup<D>, const D: usize>(
    first: &SMatrix<G::Scalar, D, D>,
    second: &SMatrix<G::Scalar, D, D>,
    cross: &SMatrix<G::Scalar, D, D>,
    order: Order,
) -> Compounded<G::Scalar, D> {
    let sum = first + second + cross + cross.transpose();
    let completion = SMatrix::zeros();
    if order == Order::First {
        return Compounded { shift: Tangent::zeros(), covariance: sum, completion };
    }
    let basis = Basis::<G, D>::new();
    let shift = Basis::<G, D>::contract(|a| basis.ad[a] * row(cross, a)) * G::Scalar::lit(0.5);
    if order == Order::Second {
        return Compounded { shift, covariance: sum, completion };
    }
    let (a1, a2) = (basis.square(first), basis.square(second));
    let (g1, g2) = (-basis.square(cross), -basis.square(&cross.transpose()));
    let twice = G::small_adjoint(&shift) * G::Scalar::lit(2.0);
    let (p, q) = (a1 + g2 + twice, a2 + g1 - twice);
    let twelfth = G::Scalar::lit(1.0 / 12.0);
    let t = (p * (second + cross.transpose()) + q * (first + cross)) * twelfth;
    let quarter = basis.brackets(first, second, cross) * G::Scalar::lit(0.25);
    let mixed = p * cross.transpose() * q.transpose();
    let square = p * second * p.transpose() + q * first * q.transpose() + mixed + mixed.transpose();
    Compounded {
        shift: shift + basis.fourth_shift(&a1, second, cross),
        covariance: sum + t + t.transpose() + quarter,
        completion: square * (twelfth * twelfth),
    }
}

/// Row `a` of a matrix, as a vector.
fn row<S: Real, const D: usize>(m: &SMatrix<S, D, D>, a: usize) -> Tangent<S, D> {
    m.row(a).transpose()
}

/// ad of every basis vector.
struct Basis<G: LieGroup<D>, const D: usize> {
    ad: [Jacobian<G::Scalar, D>; D],
}

impl<G: LieGroup<D>, const D: usize> Basis<G, D> {
    fn new() -> Self {
        let unit = |a: usize| Tangent::from_fn(|i, _| G::Scalar::lit(f64::from(u8::from(i == a))));
        Self { ad: core::array::from_fn(|a| G::small_adjoint(&unit(a))) }
    }

    /// Σ_a of a term.
    fn contract<const C: usize>(
        term: impl Fn(usize) -> SMatrix<G::Scalar, D, C>,
    ) -> SMatrix<G::Scalar, D, C> {
        (0..D).fold(SMatrix::zeros(), |sum, a| sum + term(a))
    }

    /// Σ_ab M_ab·ad_a·ad_b.
    fn square(&self, m: &SMatrix<G::Scalar, D, D>) -> Jacobian<G::Scalar, D> {
        Self::contract(|a| self.ad[a] * G::small_adjoint(&row(m, a)))
    }

    /// B + Σ_jl (ad_j·s_l)(ad_l·s_j)ᵀ, four times the covariance of ½\[ξ₁, ξ₂\].
    fn brackets(
        &self,
        first: &SMatrix<G::Scalar, D, D>,
        second: &SMatrix<G::Scalar, D, D>,
        cross: &SMatrix<G::Scalar, D, D>,
    ) -> SMatrix<G::Scalar, D, D> {
        let direct = |a: usize| self.ad[a] * second * G::small_adjoint(&row(first, a)).transpose();
        // Column l of ad_j·Sᵀ is ad_j·s_l.
        let turned: [SMatrix<G::Scalar, D, D>; D] = core::array::from_fn(|j| self.ad[j] * cross.transpose());
        let crossed =
            |j: usize| Self::contract(|l| turned[j].column(l).into_owned() * turned[l].column(j).transpose());
        Self::contract(|a| direct(a) + crossed(a))
    }

    /// The part of E\[ξ\] of fourth order, −(1/24)·E\[\[ξ₂, \[ξ₁, \[ξ₁, ξ₂\]\]\]\].
    fn fourth_shift(
        &self,
        a1: &Jacobian<G::Scalar, D>,
        second: &SMatrix<G::Scalar, D, D>,
        cross: &SMatrix<G::Scalar, D, D>,
    ) -> Tangent<G::Scalar, D> {
        let twice = Self::contract(|a| self.ad[a] * row(cross, a));
        let sum = Self::contract(|a| {
            let turned = G::small_adjoint(&row(cross, a));
            let mixed = Self::contract(|b| turned * self.ad[b] * self.ad[a] * row(cross, b));
            self.ad[a] * a1 * row(second, a) + turned * self.ad[a] * twice + mixed
        });
        sum * G::Scalar::lit(-1.0 / 24.0)
    }
}

impl<G: LieGroup<D>, const D: usize, E: Side> Gaussian<G, D, E> {
    /// X·Y of independent elements; for correlated ones see [`Pair::compose`](super::Pair::compose).
    ///
    /// To second order, global Σ₁ + Ad₁Σ₂Ad₁ᵀ, local Ad₂⁻¹Σ₁Ad₂⁻ᵀ + Σ₂: Barfoot & Furgale (2014) (38), Barfoot (2024) (8.42).
    /// To fourth, [`compound`].
    pub fn compose(&self, rhs: &Self, order: Order) -> Self {
        self.compose_correlated(rhs, &SMatrix::zeros(), order)
    }

    /// X⁻¹·Y, `other` = Y seen from X, of independent elements.
    pub fn between(&self, other: &Self, order: Order) -> Self {
        self.inverse().compose(other, order)
    }

    /// The product of a chain of independent elements, from left to right; of none, the certain identity.
    pub fn chain<'a>(elements: impl IntoIterator<Item = &'a Self>, order: Order) -> Self {
        elements.into_iter().fold(Self::certain(G::identity()), |x, y| x.compose(y, order))
    }

    /// X·Y with E\[ξ₁ξ₂ᵀ\] = `cross`, each error in its own frame.
    pub(super) fn compose_correlated(
        &self,
        rhs: &Self,
        cross: &SMatrix<G::Scalar, D, D>,
        order: Order,
    ) -> Self {
        let (f1, f2) = (E::under_right_factor(rhs.mean()), E::under_left_factor(self.mean()));
        let first = self.covariance().transformed(&f1);
        let second = rhs.covariance().transformed(&f2);
        let cross = f1 * cross * f2.transpose();
        let product = compound::<G, D>(first.matrix(), second.matrix(), &cross, order);
        let covariance = Covariance::by_construction(product.covariance + product.completion);
        Self::new(self.mean().compose(rhs.mean()), covariance).reset(&product.shift)
    }
}
