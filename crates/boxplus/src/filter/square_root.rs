//! The filter in square-root form: half the digits carry as far.

use super::model::{all_finite, finite, observed, stepped};
use super::{FilterError, Measurement, Motion};
use crate::lie::{Jacobian, LieGroup, Real, Tangent};
use crate::uncertainty::linear::right_divided_by_transpose;
use crate::uncertainty::{Gaussian, Local, Side};
use nalgebra::{SMatrix, SVector, SimdComplexField};

/// A belief by the lower triangular L of its covariance, P = LLᵀ.
///
/// P is never formed: its condition number is the square of that of L, so that a filter on `f32`, with seven digits, behaves as one on P
/// with fourteen. It pays on a microcontroller, where `f64` is slow, and where a sensor is more exact than the prior by more than half
/// of the digits: (σ_prior/σ_sensor)² > 1/ε, 3·10³ in `f32`. There HPHᵀ + N rounds N away, and [`Ekf`](super::Ekf) loses what the sensor
/// did not see, Joseph's form or not. In `f64` with covariances of usual size there is nothing to gain.
///
/// ```text
/// predict  L ← triangle of [F·L, G·√Q]                  sums of squares, one column at a time: Golub & Van Loan (2013) §6.5
/// update   z, H whitened by √N, then row by row: a = Lᵀhᵀ, α = 1 + aᵀa, K = La/α, LLᵀ ← L(I − aaᵀ/α)Lᵀ
/// reset    L ← triangle of J·L
/// ```
/// The row by row update is Carlson (1973): it keeps L triangular and has no difference in it.
///
/// ```
/// use boxplus::filter::{Ekf, Filter, PositionFix, SquareRootBelief};
/// use boxplus::lie::SE2;
/// use boxplus::uncertainty::{Covariance, Gaussian};
/// use nalgebra::vector;
/// let prior = Gaussian::<SE2, 3>::from_sigmas(SE2::new(vector![1.0, 2.0], 0.3), &vector![0.5, 0.5, 0.2])?;
/// let fix = PositionFix { antenna: vector![1.0, 0.0], measured: vector![2.1, 2.2], noise: Covariance::from_sigmas(&vector![0.1, 0.1])? };
/// let root = SquareRootBelief::from_gaussian(&prior).update(&fix)?.to_gaussian()?;
/// let usual = Ekf::default().update(&prior, &fix).belief;
/// assert!((root.covariance().matrix() - usual.covariance().matrix()).amax() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SquareRootBelief<G: LieGroup<D>, const D: usize, E: Side = Local> {
    mean: G,
    /// L.
    root: Jacobian<G::Scalar, D>,
    side: core::marker::PhantomData<E>,
}

impl<G: LieGroup<D>, const D: usize, E: Side> SquareRootBelief<G, D, E> {
    /// From a mean and any root of the covariance, D×D: P = `root`·`root`ᵀ.
    ///
    /// # Errors
    /// [`FilterError::CovarianceNotFinite`].
    pub fn new(mean: G, root: &Jacobian<G::Scalar, D>) -> Result<Self, FilterError> {
        let root = triangle(Jacobian::zeros(), root);
        if !all_finite(&root) {
            return Err(FilterError::CovarianceNotFinite);
        }
        Ok(Self { mean, root, side: core::marker::PhantomData })
    }

    /// The same belief.
    pub fn from_gaussian(belief: &Gaussian<G, D, E>) -> Self {
        Self { mean: *belief.mean(), root: belief.covariance().factor(), side: core::marker::PhantomData }
    }

    /// The same belief, as far as P can hold it.
    ///
    /// # Errors
    /// [`FilterError::CovarianceNotFinite`] where a square overflows.
    pub fn to_gaussian(&self) -> Result<Gaussian<G, D, E>, FilterError> {
        let unit = crate::uncertainty::Covariance::unit().transformed(&self.root);
        super::ekf::checked(Gaussian::new(self.mean, unit))
    }

    /// x̂.
    pub fn mean(&self) -> &G {
        &self.mean
    }

    /// L, D×D, lower triangular.
    pub fn root(&self) -> &Jacobian<G::Scalar, D> {
        &self.root
    }

    /// The standard deviation of each coordinate: the lengths of the rows of L.
    pub fn sigmas(&self) -> Tangent<G::Scalar, D> {
        Tangent::from_fn(|i, _| self.root.row(i).norm_squared().simd_sqrt())
    }

    /// After one step of the motion.
    ///
    /// # Errors
    /// [`FilterError::MotionNotFinite`], [`FilterError::CovarianceNotFinite`].
    pub fn predict<M: Motion<G, D, W>, const W: usize>(
        &self,
        motion: &M,
        input: &M::Input,
    ) -> Result<Self, FilterError> {
        let (next, f, g) = stepped::<G, E, M, D, W>(motion, &self.mean, input)?;
        let moved = triangle(Jacobian::zeros(), &(f * self.root));
        Self::new(next, &triangle(moved, &(g * finite(motion.noise(input))?.factor())))
    }

    /// After a measurement, linearised at the mean.
    ///
    /// # Errors
    /// [`FilterError::MeasurementNotFinite`], [`FilterError::CovarianceNotFinite`]; [`FilterError::Singular`] where the sensor claims to
    /// be exact along a direction.
    pub fn update<Z: Measurement<G, D, M>, const M: usize>(
        &self,
        measurement: &Z,
    ) -> Result<Self, FilterError> {
        let (z, h) = observed::<G, E, Z, D, M>(measurement, &self.mean)?;
        let noise = finite(measurement.noise())?;
        let whitener = noise.regular_factor().map_err(|error| FilterError::of_inversion(&error))?;
        // L_N⁻¹·[z, H], through the transpose: X·L_Nᵀ = [z, H]ᵀ.
        let z = right_divided_by_transpose(&z.transpose(), &whitener);
        let h = right_divided_by_transpose(&h.transpose(), &whitener);
        let (mut root, mut delta) = (self.root, Tangent::<G::Scalar, D>::zeros());
        for i in 0..M {
            let row = h.column(i).into_owned();
            let gain = seen(&mut root, &row);
            delta += gain * (z[i] - row.dot(&delta));
        }
        if !all_finite(&delta) {
            return Err(FilterError::MeasurementNotFinite);
        }
        Self::new(E::perturb(&self.mean, &delta), &(E::jacobian::<G, D>(&delta) * root))
    }
}

/// K of a number seen with H = `row`ᵀ and noise 1; L becomes the root after it. Carlson (1973), for lower triangles.
fn seen<S: Real, const D: usize>(root: &mut Jacobian<S, D>, row: &Tangent<S, D>) -> Tangent<S, D> {
    let a = root.transpose() * row;
    let (mut alpha, mut sum) = (S::one(), Tangent::<S, D>::zeros());
    for k in (0..D).rev() {
        let before = alpha;
        alpha += a[k] * a[k];
        let column = root.column(k).into_owned();
        let both = (before * alpha).simd_sqrt();
        // √(α₋/α) = α₋/√(α₋α).
        root.set_column(k, &(column * (before / both) - sum * (a[k] / both)));
        sum += column * a[k];
    }
    sum / alpha
}

/// The lower triangle whose square is that of \[`lower`, `columns`\].
fn triangle<S: Real, const D: usize, const C: usize>(
    mut lower: Jacobian<S, D>,
    columns: &SMatrix<S, D, C>,
) -> Jacobian<S, D> {
    for c in 0..C {
        let mut rest: SVector<S, D> = columns.column(c).into_owned();
        for k in 0..D {
            rotate(&mut lower, &mut rest, k);
        }
    }
    lower
}

/// Turns column k and the rest into each other until entry k of the rest is 0. Golub & Van Loan (2013) algorithm 5.1.3.
fn rotate<S: Real, const D: usize>(lower: &mut Jacobian<S, D>, rest: &mut SVector<S, D>, k: usize) {
    let (x, y) = (lower[(k, k)], rest[k]);
    if y.value() == 0.0 {
        return;
    }
    let length = hypotenuse(x, y);
    let (c, s) = (x / length, y / length);
    for i in k..D {
        let (p, q) = (lower[(i, k)], rest[i]);
        lower[(i, k)] = c * p + s * q;
        rest[i] = c * q - s * p;
    }
}

/// √(x² + y²) without the overflow or underflow of squares, y ≠ 0.
fn hypotenuse<S: Real>(x: S, y: S) -> S {
    let (large, small) =
        if x.value().abs() > y.value().abs() { (x.simd_abs(), y) } else { (y.simd_abs(), x) };
    let ratio = small / large;
    large * (S::one() + ratio * ratio).simd_sqrt()
}
