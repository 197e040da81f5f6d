//! Trajectories in continuous time: cubic B-splines whose control elements are variables.

use core::marker::PhantomData;

use nalgebra::{SMatrix, SVector, Vector3};

use super::continuous::matrix;
use crate::graph::{Factor, GroupVariable, Variable};
use crate::lie::{Action, LieGroup, Real, SE3, SO3};
use crate::trajectory::{ImuBias, Motion, MotionJac, TrajectoryError, segment, segment_jac};

/// What a factor measures of a G, measured on a cumulative cubic B-spline: [`BSpline`](crate::trajectory::BSpline) of order 4, whose
/// control elements are variables.
///
/// The factor reads G alone, or G and one variable more, a landmark; V is the tuple of these. This one reads, in place of G, the four
/// control elements that act at the time, neighbours in order.
///
/// ```
/// use boxplus::graph::{Graph, Noise, OnSpline, Prior, SolveOptions, Values};
/// use boxplus::lie::{LieGroup, SO3};
/// use boxplus::trajectory::BSpline;
/// use nalgebra::Vector3;
/// // A steady turn, seen ten times in two intervals.
/// let seen = |t: f64| SO3::exp(&Vector3::new(0.0, 0.0, 0.6 * t));
/// let (mut graph, mut values) = (Graph::new(), Values::new());
/// let knots = [SO3::identity(); 5].map(|x| values.insert(x));
/// for i in 0..10_usize {
///     let (interval, u) = (i / 5, (i % 5) as f64 / 5.0);
///     let keys = (knots[interval], knots[interval + 1], knots[interval + 2], knots[interval + 3]);
///     graph.add(keys, OnSpline::<_, _, 3>::new(Prior { mean: seen(interval as f64 + u) }, u)?, Noise::unit());
/// }
/// let solution = graph.optimize(&values, &SolveOptions::default())?;
/// let knots: Vec<SO3> = knots.iter().filter_map(|&knot| solution.values.get(knot).copied()).collect();
/// let spline = BSpline::<_, 3, 4>::new(&knots, 0.0, 1.0)?;
/// assert!(spline.at(1.37)?.value.is_near(&seen(1.37), 1e-9));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Sommer et al. (2020).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnSpline<F, V, const D: usize> {
    /// The factor at the time.
    pub factor: F,
    place: f64,
    of: PhantomData<fn() -> V>,
}

impl<F, V, const D: usize> OnSpline<F, V, D> {
    /// `factor` at the place u ∈ \[0, 1\] of the interval.
    ///
    /// # Errors
    /// [`TrajectoryError::OutOfRange`].
    pub fn new<const K: usize>(factor: F, place: f64) -> Result<Self, TrajectoryError>
    where
        F: Factor<K, Variables = V>,
    {
        Ok(Self { factor, place: check(place)?, of: PhantomData })
    }

    fn value<G: LieGroup<D>>(&self, knots: [&G; 4]) -> G {
        segment(&knots, G::Scalar::lit(self.place), G::Scalar::lit(1.0)).value
    }
}

impl<F, G, const D: usize, const K: usize> Factor<K> for OnSpline<F, (G,), D>
where
    G: GroupVariable<D>,
    F: Factor<K, Variables = (G,)>,
{
    const NAME: &'static str = F::NAME;
    const RELATIVE: bool = F::RELATIVE;
    type Variables = (G, G, G, G);

    fn residual<S: Real>(&self, (a, b, c, d): &Knots<G, S>) -> SVector<S, K> {
        let [a, b, c, d] = [a, b, c, d].map(|x| G::group::<S>(x));
        self.factor.residual::<S>(&(G::variable::<S>(&self.value([&a, &b, &c, &d])),))
    }

    fn residual_jac(
        &self,
        (a, b, c, d): &Self::Variables,
    ) -> (SVector<f64, K>, (G::Jacobian<K>, G::Jacobian<K>, G::Jacobian<K>, G::Jacobian<K>)) {
        let (motion, d_motion) = segment_jac(&[a, b, c, d], self.place, 1.0);
        let (r, (d_x,)) = self.factor.residual_jac(&(motion.value,));
        let d_x = matrix::<_, K, D>(&d_x);
        let [a, b, c, d] = d_motion.map(|by| G::jacobian(d_x * by.value));
        (r, (a, b, c, d))
    }
}

impl<F, G, L, const D: usize, const K: usize> Factor<K> for OnSpline<F, (G, L), D>
where
    G: GroupVariable<D>,
    L: Variable,
    F: Factor<K, Variables = (G, L)>,
{
    const NAME: &'static str = F::NAME;
    const RELATIVE: bool = F::RELATIVE;
    type Variables = (G, G, G, G, L);

    fn residual<S: Real>(
        &self,
        (a, b, c, d, other): &(Over<G, S>, Over<G, S>, Over<G, S>, Over<G, S>, L::Over<S>),
    ) -> SVector<S, K> {
        let [a, b, c, d] = [a, b, c, d].map(|x| G::group::<S>(x));
        self.factor.residual::<S>(&(G::variable::<S>(&self.value([&a, &b, &c, &d])), *other))
    }

    fn residual_jac(
        &self,
        (a, b, c, d, other): &Self::Variables,
    ) -> (SVector<f64, K>, (G::Jacobian<K>, G::Jacobian<K>, G::Jacobian<K>, G::Jacobian<K>, L::Jacobian<K>))
    {
        let (motion, d_motion) = segment_jac(&[a, b, c, d], self.place, 1.0);
        let (r, (d_x, d_other)) = self.factor.residual_jac(&(motion.value, *other));
        let d_x = matrix::<_, K, D>(&d_x);
        let [a, b, c, d] = d_motion.map(|by| G::jacobian(d_x * by.value));
        (r, (a, b, c, d, d_other))
    }
}

/// A variable over another scalar, and four of them.
type Over<G, S> = <G as Variable>::Over<S>;
type Knots<G, S> = (Over<G, S>, Over<G, S>, Over<G, S>, Over<G, S>);

/// One reading of an inertial sensor on a cubic spline of poses of the sensor, with its bias: no pre-integration, any time.
///
/// ```text
/// (ρ, φ) = body velocity      r = (φ + b_g − ω̃,  ρ̇ + φ×ρ − Rᵀg + b_a − ã)      ∈ ℝ⁶, rad/s and m/s²
/// ```
/// Its noise is that of one reading: a density over √Δ of the sensor, and what the spline is too smooth for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplineImu {
    place: f64,
    /// Intervals per second.
    rate: f64,
    gyro: Vector3<f64>,
    accel: Vector3<f64>,
    gravity: Vector3<f64>,
}

impl SplineImu {
    /// The reading `gyro` in rad/s and `accel` in m/s² at the place u ∈ \[0, 1\] of an interval of so many seconds, under `gravity` in m/s²
    /// of the world.
    ///
    /// # Errors
    /// [`TrajectoryError::OutOfRange`], [`TrajectoryError::NotADuration`].
    pub fn new(
        [gyro, accel]: [Vector3<f64>; 2],
        place: f64,
        interval: f64,
        gravity: Vector3<f64>,
    ) -> Result<Self, TrajectoryError> {
        if !(interval > 0.0 && interval.is_finite()) {
            return Err(TrajectoryError::NotADuration { duration: interval });
        }
        Ok(Self { place: check(place)?, rate: interval.recip(), gyro, accel, gravity })
    }

    /// The reading that the motion and the bias predict, less the one that was.
    fn error<S: Real>(&self, motion: &Motion<SE3<S>, 6>, bias: &ImuBias<S>) -> SVector<S, 6> {
        let [rho, phi] = halves(&motion.velocity);
        let gravity = motion.value.rotation().inverse().act(&self.gravity.map(S::lit));
        let gyro = phi + bias.gyro() - self.gyro.map(S::lit);
        let accel = halves(&motion.acceleration)[0] + phi.cross(&rho) - gravity + bias.accel()
            - self.accel.map(S::lit);
        SVector::from([gyro.x, gyro.y, gyro.z, accel.x, accel.y, accel.z])
    }

    /// ∂r by an argument to which the motion answers by `by`, 6×6.
    fn error_jac(&self, motion: &Motion<SE3, 6>, by: &MotionJac<f64, 6>) -> SMatrix<f64, 6, 6> {
        let [rho, phi] = halves(&motion.velocity);
        let gravity = motion.value.rotation().inverse().act(&self.gravity);
        let (d_rho, d_phi) = (by.velocity.fixed_rows::<3>(0), by.velocity.fixed_rows::<3>(3));
        let d_accel = by.acceleration.fixed_rows::<3>(0) + SO3::hat(&phi) * d_rho
            - SO3::hat(&rho) * d_phi
            - SO3::hat(&gravity) * by.value.fixed_rows::<3>(3);
        let mut d_r = SMatrix::<f64, 6, 6>::zeros();
        d_r.fixed_rows_mut::<3>(0).copy_from(&d_phi);
        d_r.fixed_rows_mut::<3>(3).copy_from(&d_accel);
        d_r
    }
}

impl Factor<6> for SplineImu {
    const NAME: &'static str = "inertial reading";
    type Variables = (SE3, SE3, SE3, SE3, ImuBias);

    fn residual<S: Real>(
        &self,
        (a, b, c, d, bias): &(SE3<S>, SE3<S>, SE3<S>, SE3<S>, ImuBias<S>),
    ) -> SVector<S, 6> {
        self.error(&segment(&[a, b, c, d], S::lit(self.place), S::lit(self.rate)), bias)
    }

    fn residual_jac(
        &self,
        (a, b, c, d, bias): &Self::Variables,
    ) -> (SVector<f64, 6>, (Jac, Jac, Jac, Jac, Jac)) {
        let (motion, d_motion) = segment_jac(&[a, b, c, d], self.place, self.rate);
        let [a, b, c, d] = d_motion.map(|by| self.error_jac(&motion, &by));
        (self.error(&motion, bias), (a, b, c, d, Jac::identity()))
    }
}

type Jac = SMatrix<f64, 6, 6>;

/// (ρ, φ) of a twist.
fn halves<S: Real>(twist: &SVector<S, 6>) -> [Vector3<S>; 2] {
    [0, 3].map(|k| twist.fixed_rows::<3>(k).into_owned())
}

fn check(place: f64) -> Result<f64, TrajectoryError> {
    if (0.0..=1.0).contains(&place) {
        Ok(place)
    } else {
        Err(TrajectoryError::OutOfRange { time: place, start: 0.0, end: 1.0 })
    }
}
