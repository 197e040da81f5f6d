//! Several uncertain elements whose errors are correlated.
//!
//! Two poses of one trajectory share their past; a landmark shares the error of the pose that saw it. Treated as
//! independent, their displacement comes out far too uncertain. [`Pair`] holds two elements, of different groups if need
//! be; [`Joint`] holds N of one group. Both keep the whole joint covariance and check it once.
//!
//! ```text
//!             global                                              local
//! X·Y         Σ₁ + AΣ₂Aᵀ + SAᵀ + ASᵀ,  A = Ad_X                   BΣ₁Bᵀ + Σ₂ + BS + SᵀBᵀ,  B = Ad_Y⁻¹
//! X⁻¹·Y       A(Σ₁ + Σ₂ − S − Sᵀ)Aᵀ,   A = Ad_X⁻¹                 MΣ₁Mᵀ + Σ₂ − MS − SᵀMᵀ,  M = Ad(Y⁻¹X)
//! (X, Y)      [Σ₁, S; Sᵀ, Σ₂],  S = E[ξ₁ξ₂ᵀ]
//! ```
//!
//! Mangelson et al. (2020), with these corrections to forms in circulation, each wrong by half or more in Monte Carlo: the
//! lower left block is Sᵀ, not S; an inverse has Ad on *both* sides of Σ; and the table as printed is for global
//! perturbations only.

use super::linear::{Square, checked};
use super::{Covariance, Gaussian, Local, Order, Side, UncertaintyError};
use crate::lie::{LieGroup, Real, Tangent};
use nalgebra::SMatrix;

/// Two correlated elements X ∈ A and Y ∈ B, their errors on one side.
///
/// ```
/// use boxplus::lie::SE2;
/// use boxplus::uncertainty::{Gaussian, Order, Pair};
/// use nalgebra::vector;
/// let start = Gaussian::<SE2, 3>::from_sigmas(SE2::new(vector![0.0, 0.0], 0.1), &vector![3.0, 3.0, 0.5])?;
/// let step = Gaussian::from_sigmas(SE2::new(vector![1.0, 0.0], 0.2), &vector![0.1, 0.1, 0.05])?;
/// let poses = Pair::independent(start, step).with_product(); // (start, start·step)
/// let between = poses.between(Order::Second); // forgets what both share
/// assert!((between.sigmas() - step.sigmas()).norm() < 1e-12);
/// # Ok::<(), boxplus::uncertainty::UncertaintyError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair<
    A: LieGroup<M>,
    const M: usize,
    B: LieGroup<N, Scalar = A::Scalar>,
    const N: usize,
    E: Side = Local,
> {
    first: Gaussian<A, M, E>,
    second: Gaussian<B, N, E>,
    cross: SMatrix<A::Scalar, M, N>,
}

impl<A, const M: usize, B, const N: usize, E: Side> Pair<A, M, B, N, E>
where
    A: LieGroup<M>,
    B: LieGroup<N, Scalar = A::Scalar>,
{
    /// From the marginals and the cross-covariance E\[ξ₁ξ₂ᵀ\], M×N.
    ///
    /// # Errors
    /// [`UncertaintyError::NotFinite`], [`UncertaintyError::Indefinite`] where `cross` is larger than the marginals allow;
    /// the direction counts the coordinates of X, then those of Y.
    pub fn new(
        first: Gaussian<A, M, E>,
        second: Gaussian<B, N, E>,
        cross: SMatrix<A::Scalar, M, N>,
    ) -> Result<Self, UncertaintyError> {
        checked(&Quarters {
            aa: *first.covariance().matrix(),
            ab: cross,
            ba: cross.transpose(),
            bb: *second.covariance().matrix(),
        })?;
        Ok(Self { first, second, cross })
    }

    /// Two independent elements.
    pub fn independent(first: Gaussian<A, M, E>, second: Gaussian<B, N, E>) -> Self {
        Self { first, second, cross: SMatrix::zeros() }
    }

    /// X alone, Y being anything: its marginal.
    pub fn first(&self) -> &Gaussian<A, M, E> {
        &self.first
    }

    /// Y alone, X being anything: its marginal.
    pub fn second(&self) -> &Gaussian<B, N, E> {
        &self.second
    }

    /// S = E\[ξ₁ξ₂ᵀ\], M×N.
    pub fn cross(&self) -> &SMatrix<A::Scalar, M, N> {
        &self.cross
    }

    /// The same pair with errors on the other side: exact.
    pub fn to_opposite(&self) -> Pair<A, M, B, N, E::Opposite> {
        let (j, k) = (E::to_opposite(self.first.mean()), E::to_opposite(self.second.mean()));
        Pair {
            first: self.first.to_opposite(),
            second: self.second.to_opposite(),
            cross: j * self.cross * k.transpose(),
        }
    }

    /// X once Y is known to be `second`: N(SΣ₂⁻¹β, Σ₁ − SΣ₂⁻¹Sᵀ) with β the error of `second`, reset about its mean.
    ///
    /// Where Σ₂ is singular a generalised inverse serves; an error of `second` in a direction that Y cannot take is
    /// ignored.
    pub fn given_second(&self, second: &B) -> Gaussian<A, M, E> {
        let gain = self.second.covariance().generalised_solve(&self.cross.transpose()).transpose();
        let rest = self.first.covariance().matrix() - gain * self.cross.transpose();
        let theta = gain * self.second.error_of(second);
        Gaussian::new(*self.first.mean(), Covariance::by_construction(rest)).reset(&theta)
    }

    /// Both after an independent measurement of Y that is uncertain itself: what it says of Y and, by the correlation, of X.
    ///
    /// ```text
    /// β = error of the measured mean about Ȳ     R = J⁻¹(β)·Σ_measured·J⁻ᵀ(β)     K = [S; Σ₂]·(Σ₂ + R)⁻¹
    /// Σ ← (I − K[0, I])·Σ·(I − K[0, I])ᵀ + KRKᵀ, reset about the means moved by Kβ
    /// ```
    /// To first order, as a Kalman filter; of a measurement that is certain, [`Pair::given_second`].
    pub fn observing_second(&self, measured: &Gaussian<B, N, E>) -> Self {
        let (aa, bb) = (self.first.covariance().matrix(), self.second.covariance().matrix());
        let (beta, r) = seen_from(&self.second, measured);
        let weight = Covariance::by_construction(bb + r);
        let k1 = weight.generalised_solve(&self.cross.transpose()).transpose();
        let k2 = weight.generalised_solve(bb).transpose();
        let kept = SMatrix::identity() - k2;
        let lost = k1 * self.cross.transpose();
        let first = aa - lost - lost.transpose() + k1 * weight.matrix() * k1.transpose();
        let second = kept * bb * kept.transpose() + k2 * r * k2.transpose();
        let cross = (self.cross - k1 * bb) * kept.transpose() + k1 * r * k2.transpose();
        let (theta1, theta2) = (k1 * beta, k2 * beta);
        Self {
            first: Gaussian::new(*self.first.mean(), Covariance::by_construction(first)).reset(&theta1),
            second: Gaussian::new(*self.second.mean(), Covariance::by_construction(second)).reset(&theta2),
            cross: E::jacobian::<A, M>(&theta1) * cross * E::jacobian::<B, N>(&theta2).transpose(),
        }
    }

    /// Both after an independent, uncertain measurement of X; see [`Pair::observing_second`].
    pub fn observing_first(&self, measured: &Gaussian<A, M, E>) -> Self {
        self.swapped().observing_second(measured).swapped()
    }

    /// Y once X is known to be `first`; see [`Pair::given_second`].
    pub fn given_first(&self, first: &A) -> Gaussian<B, N, E> {
        self.swapped().given_second(first)
    }

    /// (Y, X).
    pub fn swapped(&self) -> Pair<B, N, A, M, E> {
        Pair { first: self.second, second: self.first, cross: self.cross.transpose() }
    }
}

/// `(β, R)`: a measured element as a number and its covariance in the tangent space at the mean of what is measured.
fn seen_from<G: LieGroup<D>, E: Side, const D: usize>(
    known: &Gaussian<G, D, E>,
    measured: &Gaussian<G, D, E>,
) -> (Tangent<G::Scalar, D>, SMatrix<G::Scalar, D, D>) {
    let beta = known.error_of(measured.mean());
    (beta, *measured.covariance().transformed(&E::jacobian_inverse::<G, D>(&beta)).matrix())
}

impl<G: LieGroup<D>, const D: usize, E: Side> Pair<G, D, G, D, E> {
    /// X·Y, correlation included.
    pub fn compose(&self, order: Order) -> Gaussian<G, D, E> {
        self.first.compose_correlated(&self.second, &self.cross, order)
    }

    /// X⁻¹·Y, Y seen from X, correlation included: what both share cancels.
    pub fn between(&self, order: Order) -> Gaussian<G, D, E> {
        self.with_first_inverted().compose(order)
    }

    /// (X⁻¹, Y): exact.
    pub fn with_first_inverted(&self) -> Self {
        let cross = -(E::under_inverse(self.first.mean()) * self.cross);
        Self { first: self.first.inverse(), second: self.second, cross }
    }

    /// (X⁻¹, Y⁻¹): exact.
    pub fn inverted(&self) -> Self {
        let (j, k) = (E::under_inverse(self.first.mean()), E::under_inverse(self.second.mean()));
        let cross = j * self.cross * k.transpose();
        Self { first: self.first.inverse(), second: self.second.inverse(), cross }
    }

    /// (X, X·Y): the two ends of a step, to second order. Its [`Pair::between`] is Y again.
    pub fn with_product(&self) -> Self {
        let (x, y) = (self.first.mean(), self.second.mean());
        let (f1, f2) = (E::under_right_factor(y), E::under_left_factor(x));
        let cross = self.first.covariance().matrix() * f1.transpose() + self.cross * f2.transpose();
        Self { first: self.first, second: self.compose(Order::First), cross }
    }
}

/// N correlated elements of one group, their errors on one side.
///
/// ```
/// use boxplus::lie::SE2;
/// use boxplus::uncertainty::{Gaussian, Joint, Order};
/// use nalgebra::vector;
/// let step = Gaussian::<SE2, 3>::from_sigmas(SE2::new(vector![1.0, 0.0], 0.2), &vector![0.1, 0.1, 0.05])?;
/// let poses = Joint::along(&[step; 4]); // dead reckoning: all poses, and how they hang together
/// let last = poses.pair(2, 3).between(Order::Second);
/// assert!((last.sigmas() - step.sigmas()).norm() < 1e-15);
/// let fixed = poses.given(3, poses.marginal(3).mean()); // a fix at the end
/// assert!(fixed.marginal(2).sigmas().norm() < poses.marginal(2).sigmas().norm());
/// # Ok::<(), boxplus::uncertainty::UncertaintyError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint<G: LieGroup<D>, const D: usize, const N: usize, E: Side = Local> {
    means: [G; N],
    blocks: Blocks<G::Scalar, D, N>,
    side: core::marker::PhantomData<E>,
}

impl<G: LieGroup<D>, const D: usize, const N: usize, E: Side> Joint<G, D, N, E> {
    /// From the means and the blocks E\[ξᵢξⱼᵀ\], D×D each.
    ///
    /// # Errors
    /// [`UncertaintyError::NotFinite`], [`UncertaintyError::Asymmetric`], [`UncertaintyError::Indefinite`]; rows, columns and
    /// directions count through the elements.
    pub fn new(means: [G; N], blocks: [[SMatrix<G::Scalar, D, D>; N]; N]) -> Result<Self, UncertaintyError> {
        Ok(Self::from_parts(means, checked(&Blocks(blocks))?))
    }

    fn from_parts(means: [G; N], blocks: Blocks<G::Scalar, D, N>) -> Self {
        Self { means, blocks, side: core::marker::PhantomData }
    }

    /// Independent elements.
    pub fn independent(elements: &[Gaussian<G, D, E>; N]) -> Self {
        let mut blocks = Blocks::<G::Scalar, D, N>::zeros();
        (0..N).for_each(|i| blocks.0[i][i] = *elements[i].covariance().matrix());
        Self::from_parts(elements.map(|x| *x.mean()), blocks)
    }

    /// All partial products X₁, X₁X₂, … of independent steps, to second order: the poses of dead reckoning.
    pub fn along(steps: &[Gaussian<G, D, E>; N]) -> Self {
        let mut blocks = Blocks::<G::Scalar, D, N>::zeros();
        let mut means = steps.map(|x| *x.mean());
        for k in 0..N {
            let known = if k == 0 { G::identity() } else { means[k - 1] };
            let (f1, f2) = (E::under_right_factor(steps[k].mean()), E::under_left_factor(&known));
            means[k] = known.compose(steps[k].mean());
            for i in 0..k {
                blocks.0[i][k] = blocks.0[i][k - 1] * f1.transpose();
                blocks.0[k][i] = blocks.0[i][k].transpose();
            }
            let own = *steps[k].covariance().transformed(&f2).matrix();
            let carried =
                if k == 0 { SMatrix::zeros() } else { f1 * blocks.0[k - 1][k - 1] * f1.transpose() };
            blocks.0[k][k] = own + carried;
        }
        Self::from_parts(means, super::linear::symmetrised(&blocks))
    }

    /// Element `i` alone: its marginal.
    ///
    /// # Panics
    /// If `i` ≥ N, as for an array.
    pub fn marginal(&self, i: usize) -> Gaussian<G, D, E> {
        Gaussian::new(self.means[i], Covariance::by_construction(self.blocks.0[i][i]))
    }

    /// E\[ξᵢξⱼᵀ\], D×D.
    ///
    /// # Panics
    /// If an index is ≥ N, as for an array.
    pub fn cross(&self, i: usize, j: usize) -> &SMatrix<G::Scalar, D, D> {
        &self.blocks.0[i][j]
    }

    /// Elements `i` and `j`, the others being anything.
    ///
    /// # Panics
    /// If an index is ≥ N, as for an array.
    pub fn pair(&self, i: usize, j: usize) -> Pair<G, D, G, D, E> {
        Pair { first: self.marginal(i), second: self.marginal(j), cross: *self.cross(i, j) }
    }

    /// All elements once element `k` is known to be `value`, which makes it certain; see [`Pair::given_second`].
    ///
    /// # Panics
    /// If `k` ≥ N, as for an array.
    pub fn given(&self, k: usize, value: &G) -> Self {
        let known = self.marginal(k);
        let error = known.error_of(value);
        let gains: [SMatrix<G::Scalar, D, D>; N] =
            core::array::from_fn(|i| known.covariance().generalised_solve(self.cross(k, i)).transpose());
        let thetas = gains.map(|gain| gain * error);
        let resets = thetas.map(|theta| E::jacobian::<G, D>(&theta));
        let mut given = Self::from_parts(self.means, Blocks::zeros());
        for i in (0..N).filter(|&i| i != k) {
            given.means[i] = E::perturb(&self.means[i], &thetas[i]);
            for j in (0..N).filter(|&j| j != k) {
                let rest = self.cross(i, j) - gains[i] * self.cross(k, j);
                given.blocks.0[i][j] = resets[i] * rest * resets[j].transpose();
            }
        }
        given.means[k] = *value;
        Self { blocks: super::linear::symmetrised(&given.blocks), ..given }
    }

    /// All elements after an independent, uncertain measurement of element `k`; see [`Pair::observing_second`].
    ///
    /// # Panics
    /// If `k` ≥ N, as for an array.
    pub fn observing(&self, k: usize, measured: &Gaussian<G, D, E>) -> Self {
        let known = self.marginal(k);
        let (beta, r) = seen_from(&known, measured);
        let weight = Covariance::by_construction(known.covariance().matrix() + r);
        let gains: [SMatrix<G::Scalar, D, D>; N] =
            core::array::from_fn(|i| weight.generalised_solve(self.cross(k, i)).transpose());
        let thetas = gains.map(|gain| gain * beta);
        let resets = thetas.map(|theta| E::jacobian::<G, D>(&theta));
        let block = |i: usize, j: usize| {
            resets[i] * (self.cross(i, j) - gains[i] * self.cross(k, j)) * resets[j].transpose()
        };
        let blocks = Blocks(core::array::from_fn(|i| core::array::from_fn(|j| block(i, j))));
        let means = core::array::from_fn(|i| E::perturb(&self.means[i], &thetas[i]));
        Self::from_parts(means, super::linear::symmetrised(&blocks))
    }

    /// The same elements with errors on the other side: exact.
    pub fn to_opposite(&self) -> Joint<G, D, N, E::Opposite> {
        let turns: [SMatrix<G::Scalar, D, D>; N] = core::array::from_fn(|i| E::to_opposite(&self.means[i]));
        let block = |i: usize, j: usize| turns[i] * self.cross(i, j) * turns[j].transpose();
        let blocks = Blocks(core::array::from_fn(|i| core::array::from_fn(|j| block(i, j))));
        Joint::from_parts(self.means, super::linear::symmetrised(&blocks))
    }
}

/// \[aa, ab; ba, bb\].
#[derive(Clone, Copy)]
struct Quarters<S, const M: usize, const N: usize> {
    aa: SMatrix<S, M, M>,
    ab: SMatrix<S, M, N>,
    ba: SMatrix<S, N, M>,
    bb: SMatrix<S, N, N>,
}

impl<S: Real, const M: usize, const N: usize> Square<S> for Quarters<S, M, N> {
    type Double = Quarters<f64, M, N>;
    fn size(&self) -> usize {
        M + N
    }
    fn at(&self, i: usize, j: usize) -> S {
        match (i < M, j < M) {
            (true, true) => self.aa[(i, j)],
            (true, false) => self.ab[(i, j - M)],
            (false, true) => self.ba[(i - M, j)],
            (false, false) => self.bb[(i - M, j - M)],
        }
    }
    fn put(&mut self, i: usize, j: usize, x: S) {
        match (i < M, j < M) {
            (true, true) => self.aa[(i, j)] = x,
            (true, false) => self.ab[(i, j - M)] = x,
            (false, true) => self.ba[(i - M, j)] = x,
            (false, false) => self.bb[(i - M, j - M)] = x,
        }
    }
    fn double(&self) -> Self::Double {
        Quarters {
            aa: self.aa.map(Real::value),
            ab: self.ab.map(Real::value),
            ba: self.ba.map(Real::value),
            bb: self.bb.map(Real::value),
        }
    }
}

/// N×N blocks of D×D.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Blocks<S, const D: usize, const N: usize>([[SMatrix<S, D, D>; N]; N]);

impl<S: Real, const D: usize, const N: usize> Blocks<S, D, N> {
    fn zeros() -> Self {
        Self([[SMatrix::zeros(); N]; N])
    }
}

impl<S: Real, const D: usize, const N: usize> Square<S> for Blocks<S, D, N> {
    type Double = Blocks<f64, D, N>;
    fn size(&self) -> usize {
        D * N
    }
    fn at(&self, i: usize, j: usize) -> S {
        self.0[i / D][j / D][(i % D, j % D)]
    }
    fn put(&mut self, i: usize, j: usize, x: S) {
        self.0[i / D][j / D][(i % D, j % D)] = x;
    }
    fn double(&self) -> Self::Double {
        Blocks(self.0.map(|row| row.map(|block| block.map(Real::value))))
    }
}
