//! The filter in information form: what is unknown is a zero, not an infinity.

use super::model::{all_finite, finite, observed, stepped};
use super::{FilterError, Measurement, Motion};
use crate::lie::linear::inverse;
use crate::lie::{LieGroup, Real, Tangent};
use crate::uncertainty::{Covariance, Gaussian, Local, Side, UncertaintyError};
use nalgebra::SMatrix;

/// A belief by its information matrix Y = P⁻¹, which may say nothing in some directions.
///
/// A receiver that has just been switched on knows nothing: Y = 0, where a covariance would have to be infinite or made up. And
/// measurements *add*: those of many sensors, or of other robots, are summed without an inverse, in any order.
///
/// ```text
/// update   Y ← Y + HᵀN⁻¹H      δ = Y⁻HᵀN⁻¹z      x ← x ⊞ δ      Y ← J⁻ᵀYJ⁻¹, J = J_r(δ) local, J_l(δ) global; again from there
/// predict  M = F⁻ᵀYF⁻¹         Y ← M − MB(I + BᵀMB)⁻¹BᵀM,       BBᵀ = GQGᵀ
/// ```
/// Barfoot (2024) §3.3.1 and, for the reset, Mueller, Hehn & D'Andrea (2017). Y⁻ is a generalised inverse: what no measurement has
/// seen stays where it is. Where Y is regular the numbers are those of [`Ekf::iterated`](super::Ekf::iterated). It iterates for a reason: from a
/// guess far off, a single step would mix directions that are known with those that are not.
///
/// ```
/// use boxplus::filter::{InformationBelief, PositionFix};
/// use boxplus::lie::{LieGroup, SE2};
/// use boxplus::uncertainty::Covariance;
/// use nalgebra::vector;
/// let noise = Covariance::from_sigmas(&vector![0.1, 0.1])?;
/// let antenna = |at: [f64; 2], seen: [f64; 2]| PositionFix { antenna: at.into(), measured: seen.into(), noise };
/// let nothing = InformationBelief::<SE2, 3>::unknown(SE2::identity());
/// let placed = nothing.update(&antenna([0.0, 0.0], [5.0, 3.0]))?;
/// assert!(placed.rank() == 2 && placed.to_gaussian().is_err()); // nothing has told the heading
/// let headed = placed.update(&antenna([1.0, 0.0], [6.0, 3.1]))?;
/// assert!((headed.mean().angle() - 0.1).abs() < 0.01 && headed.to_gaussian().is_ok());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InformationBelief<G: LieGroup<D>, const D: usize, E: Side = Local> {
    mean: G,
    /// Y: symmetric and positive semi-definite, as a covariance is.
    information: Covariance<D, G::Scalar>,
    side: core::marker::PhantomData<E>,
}

impl<G: LieGroup<D>, const D: usize, E: Side> InformationBelief<G, D, E> {
    /// From a mean and Y, D×D, in the inverse units of the tangent, squared.
    ///
    /// # Errors
    /// Those of [`Covariance::new`].
    pub fn new(mean: G, information: SMatrix<G::Scalar, D, D>) -> Result<Self, UncertaintyError> {
        Ok(Self::of(mean, Covariance::new(information)?))
    }

    fn of(mean: G, information: Covariance<D, G::Scalar>) -> Self {
        Self { mean, information, side: core::marker::PhantomData }
    }

    /// Nothing is known; `guess` is where measurements are linearised first.
    pub fn unknown(guess: G) -> Self {
        Self::of(guess, Covariance::zero())
    }

    /// The same belief.
    ///
    /// # Errors
    /// [`UncertaintyError::Singular`] where the Gaussian is certain along a direction.
    pub fn from_gaussian(belief: &Gaussian<G, D, E>) -> Result<Self, UncertaintyError> {
        Self::new(*belief.mean(), belief.covariance().information()?)
    }

    /// The same belief.
    ///
    /// # Errors
    /// [`UncertaintyError::NoInformation`] where nothing is known along a direction.
    pub fn to_gaussian(&self) -> Result<Gaussian<G, D, E>, UncertaintyError> {
        Gaussian::from_information(self.mean, self.information.matrix())
    }

    /// x̂.
    pub fn mean(&self) -> &G {
        &self.mean
    }

    /// Y, D×D.
    pub fn information(&self) -> &SMatrix<G::Scalar, D, D> {
        self.information.matrix()
    }

    /// Number of directions of which something is known.
    pub fn rank(&self) -> usize {
        self.information.rank()
    }

    /// After one step of the motion. F must be invertible, as that of every flow is.
    ///
    /// # Errors
    /// [`FilterError::MotionNotFinite`], also where F has no inverse; [`FilterError::CovarianceNotFinite`].
    pub fn predict<M: Motion<G, D, W>, const W: usize>(
        &self,
        motion: &M,
        input: &M::Input,
    ) -> Result<Self, FilterError> {
        let (next, f, g) = stepped::<G, E, M, D, W>(motion, &self.mean, input)?;
        let back = inverse(&f).ok_or(FilterError::MotionNotFinite)?;
        let moved = self.information.transformed(&back.transpose());
        let b = g * finite(motion.noise(input))?.factor();
        let mb = moved.matrix() * b;
        let inner = Covariance::<W, G::Scalar>::unit() + moved.transformed(&b.transpose());
        let inner = inner.information().map_err(|_| FilterError::CovarianceNotFinite)?;
        // M − MB(I + BᵀMB)⁻¹BᵀM as a sum of squares: with A = I − MB(I + BᵀMB)⁻¹Bᵀ it is AMAᵀ + CCᵀ, C = MB(I + BᵀMB)⁻¹.
        let c = mb * inner;
        let a = SMatrix::identity() - c * b.transpose();
        let left = moved.transformed(&a) + Covariance::<W, G::Scalar>::unit().transformed(&c);
        if all_finite(left.matrix()) {
            Ok(Self::of(next, left))
        } else {
            Err(FilterError::CovarianceNotFinite)
        }
    }

    /// After a measurement, linearised until it settles: a guess may be far off.
    ///
    /// # Errors
    /// [`FilterError::MeasurementNotFinite`]; [`FilterError::Singular`] where the sensor claims to be exact along a direction.
    pub fn update<Z: Measurement<G, D, M>, const M: usize>(
        &self,
        measurement: &Z,
    ) -> Result<Self, FilterError> {
        self.settled(|x| contribution::<G, E, Z, D, M>(measurement, x))
    }

    /// After several measurements of one kind at once: their information is added.
    ///
    /// # Errors
    /// Those of [`InformationBelief::update`], of the first that fails.
    pub fn update_all<'a, Z: Measurement<G, D, M> + 'a, const M: usize>(
        &self,
        measurements: impl IntoIterator<Item = &'a Z, IntoIter: Clone>,
    ) -> Result<Self, FilterError> {
        let measurements = measurements.into_iter();
        self.settled(|x| {
            measurements.clone().try_fold((Covariance::zero(), Tangent::zeros()), |(y, v), measurement| {
                let (matrix, vector) = contribution::<G, E, Z, D, M>(measurement, x)?;
                Ok((y + matrix, v + vector))
            })
        })
    }

    /// Gauss–Newton on what was known and what is `seen`, HᵀN⁻¹H and HᵀN⁻¹z at a point.
    fn settled(
        &self,
        seen: impl Fn(&G) -> Result<(Covariance<D, G::Scalar>, Tangent<G::Scalar, D>), FilterError>,
    ) -> Result<Self, FilterError> {
        let mut x = self.mean;
        for _ in 1..ITERATIONS {
            let (next, squared_step) = self.stepped(&x, &seen)?;
            // Half of the digits of a standard deviation.
            if squared_step <= G::Scalar::EPSILON {
                return Ok(next);
            }
            x = next.mean;
        }
        Ok(self.stepped(&x, &seen)?.0)
    }

    /// The belief linearised at x, and the square of its step from there in standard deviations.
    fn stepped(
        &self,
        x: &G,
        seen: impl Fn(&G) -> Result<(Covariance<D, G::Scalar>, Tangent<G::Scalar, D>), FilterError>,
    ) -> Result<(Self, f64), FilterError> {
        // The prior's mean stands at −e of x, as J(e)·e = e on either side.
        let e = E::error(x, &self.mean);
        let prior = self.information.transformed(&E::jacobian_inverse::<G, D>(&e).transpose());
        let (matrix, vector) = seen(x)?;
        let information = prior + matrix;
        let delta = information.generalised_solve(&(vector - prior.matrix() * e));
        if !all_finite(&delta) || !all_finite(information.matrix()) {
            return Err(FilterError::MeasurementNotFinite);
        }
        let squared_step = delta.dot(&(information.matrix() * delta)).value();
        let back = E::jacobian_inverse::<G, D>(&delta);
        let moved = Self::of(E::perturb(x, &delta), information.transformed(&back.transpose()));
        Ok((moved, squared_step))
    }
}

/// Most linearisations of an update.
const ITERATIONS: usize = 10;

/// `(HᵀN⁻¹H, HᵀN⁻¹z)` at x.
fn contribution<G, E, Z, const D: usize, const M: usize>(
    measurement: &Z,
    x: &G,
) -> Result<(Covariance<D, G::Scalar>, Tangent<G::Scalar, D>), FilterError>
where
    G: LieGroup<D>,
    E: Side,
    Z: Measurement<G, D, M>,
{
    let (z, h) = observed::<G, E, Z, D, M>(measurement, x)?;
    let noise = finite(measurement.noise())?;
    let weight = noise.information().map_err(|error| FilterError::of_inversion(&error))?;
    let weight = Covariance::new(weight).map_err(|_| FilterError::CovarianceNotFinite)?;
    Ok((weight.transformed(&h.transpose()), h.transpose() * weight.matrix() * z))
}
