//! Where an uncertain element takes a point: moments of y = X·p.
//!
//! Exp(ξ)·b = b + B₁ + ½B₂ + …, B_n homogeneous of degree n in ξ. With ξ = Lη, η ~ N(0, I), and B_k the velocity field of
//! column k of L (for SE(3), \[I, −p^\]·l_k), the expectations are sums of products of these fields:
//!
//! ```text
//! E[Exp(ξ)·b] = b + ½Σ_k B_kB_k b + (1/24)Σ_kl (B_kB_kB_lB_l + B_kB_lB_kB_l + B_kB_lB_lB_k) b
//! Cov         = Σ_k (B_k b)(B_k b)ᵀ                                                          = GΣGᵀ
//!             + ¼Σ_kl (B_kB_l b)(B_kB_l b + B_lB_k b)ᵀ
//!             + (1/6)Σ_kl (B_k b)((B_kB_lB_l + B_lB_kB_l + B_lB_lB_k) b)ᵀ + its transpose
//! ```
//!
//! and, so that it is a sum of squares whatever Σ, the square of the last line's right factor, which is of sixth order.
//!
//! On SO(3) the mean is Barfoot (2024) (8.41) with one more term. It always shrinks: a rotated arrow whose direction is
//! uncertain is shorter on average, and linearisation, which leaves its length alone, *over*estimates it.

use super::{Covariance, Gaussian, Order, Side};
use crate::lie::{Action, LieGroup, Real, Rn, SO3};
use nalgebra::{Matrix3, SMatrix, SVector};

/// The velocity fields of the columns of a factor of Σ.
struct Fields<S, const D: usize, const N: usize> {
    /// B_k − B_k(0), N×N.
    linear: [SMatrix<S, N, N>; D],
    /// B_k(0).
    constant: [SVector<S, N>; D],
}

impl<S: Real, const D: usize, const N: usize> Fields<S, D, N> {
    fn new<G: Action<D, N, Scalar = S>>(factor: &SMatrix<S, D, D>) -> Self {
        let at_origin = G::generators_at(&SVector::zeros());
        let unit = |j: usize| SVector::from_fn(|i, _| S::lit(f64::from(u8::from(i == j))));
        let along: [SMatrix<S, N, D>; N] = core::array::from_fn(|j| G::generators_at(&unit(j)) - at_origin);
        Self {
            linear: core::array::from_fn(|k| {
                let mut field = SMatrix::<S, N, N>::zeros();
                (0..N).for_each(|j| field.set_column(j, &(along[j] * factor.column(k))));
                field
            }),
            constant: core::array::from_fn(|k| at_origin * factor.column(k)),
        }
    }

    /// B_k at a point.
    fn at(&self, k: usize, p: &SVector<S, N>) -> SVector<S, N> {
        self.linear[k] * p + self.constant[k]
    }

    /// Σ_l of the three orders of B_k, B_l, B_l at a point, for each k; `velocities` are the B_k there.
    fn third(&self, velocities: &[SVector<S, N>; D]) -> [SVector<S, N>; D] {
        let (b, v) = (&self.linear, velocities);
        core::array::from_fn(|k| {
            (0..D).fold(SVector::zeros(), |sum, l| {
                sum + b[k] * (b[l] * v[l]) + b[l] * (b[k] * v[l]) + b[l] * (b[l] * v[k])
            })
        })
    }

    /// Mean and covariance of Exp(ξ)·b.
    fn moments(&self, b: &SVector<S, N>, order: Order) -> (SVector<S, N>, SMatrix<S, N, N>) {
        let v: [SVector<S, N>; D] = core::array::from_fn(|k| self.at(k, b));
        let mut covariance = v.iter().fold(SMatrix::zeros(), |sum, v| sum + v * v.transpose());
        if order == Order::First {
            return (*b, covariance);
        }
        let second = (0..D).fold(SVector::zeros(), |sum, k| sum + self.linear[k] * v[k]);
        let mean = b + second * S::lit(0.5);
        if order == Order::Second {
            return (mean, covariance);
        }
        let third = self.third(&v);
        let fourth = (0..D).fold(SVector::zeros(), |sum, k| sum + self.linear[k] * third[k]);
        for k in 0..D {
            let cubic = v[k] + third[k] * S::lit(1.0 / 6.0);
            covariance += cubic * cubic.transpose() - v[k] * v[k].transpose();
            for l in 0..D {
                let (kl, lk) = (self.linear[k] * v[l], self.linear[l] * v[k]);
                covariance += kl * (kl + lk).transpose() * S::lit(0.25);
            }
        }
        (mean + fourth * S::lit(1.0 / 24.0), covariance)
    }

    /// E\[A·P·Aᵀ\], A the linear part of Exp(ξ): (I + ½C)P(I + ½C)ᵀ + Σ_k B_kPB_kᵀ with C = Σ_k B_kB_k.
    fn spread(&self, p: &SMatrix<S, N, N>) -> SMatrix<S, N, N> {
        let half = self.linear.iter().fold(SMatrix::identity(), |sum, b| sum + b * b * S::lit(0.5));
        self.linear.iter().fold(half * p * half.transpose(), |sum, b| sum + b * p * b.transpose())
    }
}

impl<G: LieGroup<D>, const D: usize, E: Side> Gaussian<G, D, E> {
    /// y = X·p for a point known exactly: its mean and covariance in the parent frame.
    ///
    /// ```
    /// use boxplus::lie::SE2;
    /// use boxplus::uncertainty::{Gaussian, Order};
    /// use nalgebra::vector;
    /// let heading = Gaussian::<SE2, 3>::from_sigmas(SE2::new(vector![0.0, 0.0], 0.0), &vector![0.0, 0.0, 0.3])?;
    /// let tip = heading.act(&vector![1.0, 0.0], Order::Fourth);
    /// // E[cos θ] = exp(−σ²/2), and the sideways variance is that of sin θ.
    /// assert!((tip.mean().vector().x - (-0.045_f64).exp()).abs() < 2e-5);
    /// assert!((tip.covariance().matrix()[(1, 1)] - (1.0 - (-0.18_f64).exp()) / 2.0).abs() < 6e-4);
    /// # Ok::<(), boxplus::uncertainty::UncertaintyError>(())
    /// ```
    pub fn act<const N: usize>(
        &self,
        p: &SVector<G::Scalar, N>,
        order: Order,
    ) -> Gaussian<Rn<N, G::Scalar>, N>
    where
        G: Action<D, N>,
    {
        self.act_on(&Gaussian::certain(Rn::new(*p)), order)
    }

    /// y = X·p for a point that is uncertain itself, independently of X.
    pub fn act_on<const N: usize>(
        &self,
        p: &Gaussian<Rn<N, G::Scalar>, N>,
        order: Order,
    ) -> Gaussian<Rn<N, G::Scalar>, N>
    where
        G: Action<D, N>,
    {
        // Local: X̄ after the error; global: the error after X̄.
        let known = *self.mean();
        let (before, after) = E::around(&known);
        let fields = Fields::<G::Scalar, D, N>::new::<G>(&self.covariance().factor());
        let noise = p.covariance().transformed(&before.linear_part());
        let (mean, moved) = fields.moments(&before.act(&p.mean().vector()), order);
        let noise = match order {
            Order::Fourth => fields.spread(noise.matrix()),
            Order::First | Order::Second => *noise.matrix(),
        };
        let covariance = Covariance::by_construction(moved + noise).transformed(&after.linear_part());
        Gaussian::new(Rn::new(after.act(&mean)), covariance)
    }
}

impl<S: Real, E: Side> Gaussian<SO3<S>, 3, E> {
    /// E\[C\], 3×3: where the mean rotated vector points and how much it shrinks; not itself a rotation.
    ///
    /// E\[exp ξ^\] = I + ½(Σ − tr Σ·I) + (1/24)\[(tr² Σ + 2 tr Σ²)I − Σ(tr Σ·I + 2Σ)\] + …; Barfoot (2024) (8.41) stops after
    /// the second term.
    pub fn expected_matrix(&self, order: Order) -> Matrix3<S> {
        let (sigma, identity) = (self.covariance().matrix(), Matrix3::identity());
        let trace = sigma.trace();
        let mut e: Matrix3<S> = identity;
        if order != Order::First {
            e += (sigma - identity * trace) * S::lit(0.5);
        }
        if order == Order::Fourth {
            let square = sigma * sigma;
            let scale = trace * trace + square.trace() * S::lit(2.0);
            e += (identity * scale - sigma * trace - square * S::lit(2.0)) * S::lit(1.0 / 24.0);
        }
        let (before, after) = E::around(self.mean());
        after.to_matrix() * e * before.to_matrix()
    }
}

/// E\[C\] = s·C̄ exactly, for a rotation whose error has covariance σ²I: s = ⅓(1 + 2(1 − σ²)e^{−σ²/2}), 0.6897 at σ = 0.6 rad.
///
/// ```
/// let shrink: f64 = boxplus::uncertainty::isotropic_shrink(0.6);
/// assert!((shrink - 0.6897).abs() < 5e-5);
/// ```
pub fn isotropic_shrink<S: Real>(sigma: S) -> S {
    let x = sigma * sigma;
    (S::one() + (S::one() - x) * (x * S::lit(-0.5)).simd_exp() * S::lit(2.0)) * S::lit(1.0 / 3.0)
}
