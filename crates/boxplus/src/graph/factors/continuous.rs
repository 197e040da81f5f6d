//! Trajectories in continuous time: states joined by Gaussian-process priors, and what is measured between them.

use core::marker::PhantomData;

use nalgebra::{DMatrix, SMatrix, SVector};

use crate::graph::{
    Factor, GraphError, GroupVariable, JacobianBlock, Key, Marginals, Noise, Values, Variable,
};
use crate::lie::{LieGroup, Real};
use crate::trajectory::{GaussianProcess, Moving, TrajectoryError, gp_covariance};
use crate::uncertainty::{Covariance, Gaussian};

/// White noise on acceleration (R = 2) or on jerk (R = 3) between two states of a trajectory: [`GaussianProcess`] as a factor.
///
/// ```text
/// r = γ_{k+1} − Φ(Δ)γ_k ~ N(0, Q(Δ) ⊗ Q_c)      ∈ ℝᴺ, N = R·D: of ξ, ξ̇, …
/// ```
///
/// With it, few states stand for the whole trajectory: measurements at any time between two of them become factors by
/// [`Interpolated`], and [`MotionPrior::query`] says where it was, and how surely, at any time.
///
/// ```
/// use boxplus::graph::{Graph, Interpolated, MotionPrior, Noise, Position, Prior, SolveOptions, Values};
/// use boxplus::lie::{LieGroup, SE2};
/// use boxplus::trajectory::Moving;
/// use boxplus::uncertainty::Covariance;
/// use nalgebra::{SVector, vector};
/// type State = Moving<SE2, 3, 2, 6>;
/// let prior = MotionPrior::<SE2, 3, 2, 6>::new(2.0, Covariance::from_sigmas(&vector![0.1, 0.01, 0.1])?)?;
///
/// let (mut graph, mut values) = (Graph::new(), Values::new());
/// let start = State::new(SE2::identity(), vector![1.0, 0.0, 0.0]);
/// let keys = (values.insert(start), values.insert(State::identity()));
/// graph.add((keys.0,), Prior { mean: start }, Noise::from_sigmas(&SVector::repeat(0.01))?);
/// graph.add(keys, prior, prior.noise()?);
/// // Seen at 1.9 s, a little to the left of straight ahead.
/// let seen = Interpolated::<_, State, _>::new(Position::<SE2, 2>::of_origin(vector![1.9, 0.1]), 2.0, 1.9)?;
/// graph.add(keys, seen, Noise::from_sigmas(&vector![0.02, 0.02])?);
///
/// let solution = graph.optimize(&values, &SolveOptions::default())?;
/// let mut marginals = graph.marginals(&solution.values)?;
/// let then = prior.query(&solution.values, &mut marginals, keys, 1.0)?;
/// assert!(then.mean().translation().y > 0.01 && then.sigmas()[0] < 0.1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Anderson & Barfoot (2015), Tang et al. (2019), Barfoot (2024) §11.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionPrior<G, const D: usize, const R: usize, const N: usize> {
    duration: f64,
    density: Covariance<D>,
    of: PhantomData<fn() -> G>,
}

impl<G: GroupVariable<D>, const D: usize, const R: usize, const N: usize> MotionPrior<G, D, R, N> {
    /// Of two states `duration` seconds apart, under noise of density Q_c: in the units of the R-th rate, squared, per hertz; on SE(3) with
    /// R = 2, (m/s²)²/Hz and (rad/s²)²/Hz.
    ///
    /// # Errors
    /// [`TrajectoryError::NotADuration`].
    pub fn new(duration: f64, density: Covariance<D>) -> Result<Self, TrajectoryError> {
        check(duration, 0.0)?;
        Ok(Self { duration, density, of: PhantomData })
    }

    /// Q(Δ) ⊗ Q_c, N×N: the noise of this factor.
    ///
    /// # Errors
    /// [`GraphError::NotPositiveDefinite`] where Q_c is singular.
    pub fn noise(&self) -> Result<Noise<N>, GraphError> {
        let (q, density) = (gp_covariance::<f64, R>(self.duration), self.density.matrix());
        Noise::from_covariance(&SMatrix::from_fn(|i, j| q[(i / D, j / D)] * density[(i % D, j % D)]))
    }

    /// Where the trajectory is `t` ∈ \[0, Δ\] seconds after the first of the two states `keys`, and how surely: the mean of the prior, and
    /// the covariance of both states carried there plus what the prior leaves open between them. Local.
    ///
    /// # Errors
    /// [`GraphError::Trajectory`] for a time outside, or states half a turn apart; those of [`Marginals::joint`].
    pub fn query(
        &self,
        values: &Values,
        marginals: &mut Marginals,
        keys: (Key<Moving<G, D, R, N>>, Key<Moving<G, D, R, N>>),
        t: f64,
    ) -> Result<Gaussian<G, D>, GraphError> {
        let get = |key: Key<Moving<G, D, R, N>>| {
            values
                .get(key)
                .ok_or(GraphError::ForeignKey { kind: Moving::<G, D, R, N>::NAME, number: key.slot })
        };
        let between =
            GaussianProcess::<G, D, R>::new(get(keys.0)?.motion(), get(keys.1)?.motion(), self.duration)?;
        let (now, _) = between.at_jac(t)?;
        let [from, to] =
            by_states::<G, D, R, N>(&between, t).map(|d| DMatrix::from_column_slice(D, N, d.as_slice()));
        let mut jacobian = DMatrix::zeros(D, 2 * N);
        jacobian.columns_mut(0, N).copy_from(&from);
        jacobian.columns_mut(N, N).copy_from(&to);
        let carried = &jacobian * marginals.joint(&[keys.0.into(), keys.1.into()])? * jacobian.transpose();
        let open = between.noise_at(t, self.density.matrix())?;
        let covariance = SMatrix::<f64, D, D>::from_column_slice(carried.as_slice()) + open;
        Ok(Gaussian::new(now.value, Covariance::new(covariance).map_err(|_| GraphError::IllConditioned)?))
    }
}

impl<G: GroupVariable<D>, const D: usize, const R: usize, const N: usize> Factor<N>
    for MotionPrior<G, D, R, N>
{
    const NAME: &'static str = "motion prior";
    type Variables = (Moving<G, D, R, N>, Moving<G, D, R, N>);

    fn residual<S: Real>(&self, (from, to): &Pair<G, S, D, R, N>) -> SVector<S, N> {
        let between =
            GaussianProcess::<_, D, R>::unchecked(from.motion(), to.motion(), S::lit(self.duration));
        let error = between.error();
        SVector::from_fn(|i, _| error[i / D][i % D])
    }

    fn residual_jac(
        &self,
        (from, to): &Self::Variables,
    ) -> (SVector<f64, N>, (SMatrix<f64, N, N>, SMatrix<f64, N, N>)) {
        let between = GaussianProcess::<G, D, R>::unchecked(from.motion(), to.motion(), self.duration);
        let (error, d_error) = between.error_jac();
        let [d_from, d_to] = d_error.map(|d| SMatrix::from_fn(|i, j| d[j / D][i / D][(i % D, j % D)]));
        (SVector::from_fn(|i, _| error[i / D][i % D]), (d_from, d_to))
    }
}

/// Two states over another scalar.
type Pair<G, S, const D: usize, const R: usize, const N: usize> =
    (Moving<<G as LieGroup<D>>::Over<S>, D, R, N>, Moving<<G as LieGroup<D>>::Over<S>, D, R, N>);

/// What a factor measures of a G, measured at a time between two states M of a trajectory: a [`Position`](super::Position) that came
/// late, a line of a rolling shutter, a ray of a spinning lidar.
///
/// The factor reads G alone, or G and one variable more, a landmark; V is the tuple of these. This one reads the two states in place of
/// G, and answers to them through the mean of the prior: ∂r/∂γ = ∂r/∂X·∂X(t)/∂γ. It needs no noise of its own: between the states the
/// prior is uncertain by [`gp_bridge`](crate::trajectory::gp_bridge), which must be small beside the noise of the measurement; else set a
/// state there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interpolated<F, M, V> {
    /// The factor at the time.
    pub factor: F,
    duration: f64,
    time: f64,
    between: PhantomData<fn() -> (M, V)>,
}

impl<F, M, V> Interpolated<F, M, V> {
    /// `factor`, `time` seconds after the first of two states that are `duration` apart.
    ///
    /// # Errors
    /// [`TrajectoryError::NotADuration`], [`TrajectoryError::OutOfRange`].
    pub fn new<const K: usize>(factor: F, duration: f64, time: f64) -> Result<Self, TrajectoryError>
    where
        F: Factor<K, Variables = V>,
    {
        check(duration, time)?;
        Ok(Self { factor, duration, time, between: PhantomData })
    }

    /// X(t).
    fn value<G: LieGroup<D>, const D: usize, const R: usize, const N: usize>(
        &self,
        from: &Moving<G, D, R, N>,
        to: &Moving<G, D, R, N>,
    ) -> G {
        let [duration, time] = [self.duration, self.time].map(G::Scalar::lit);
        GaussianProcess::<G, D, R>::unchecked(from.motion(), to.motion(), duration).value_at(time)
    }

    /// X(t) with its derivatives in both states, D×N.
    fn value_jac<G: GroupVariable<D>, const D: usize, const R: usize, const N: usize>(
        &self,
        from: &Moving<G, D, R, N>,
        to: &Moving<G, D, R, N>,
    ) -> (G, [SMatrix<f64, D, N>; 2]) {
        let between = GaussianProcess::<G, D, R>::unchecked(from.motion(), to.motion(), self.duration);
        (between.value_at(self.time), by_states(&between, self.time))
    }
}

impl<F, G, const D: usize, const R: usize, const N: usize, const K: usize> Factor<K>
    for Interpolated<F, Moving<G, D, R, N>, (G,)>
where
    G: GroupVariable<D>,
    F: Factor<K, Variables = (G,)>,
{
    const NAME: &'static str = F::NAME;
    type Variables = (Moving<G, D, R, N>, Moving<G, D, R, N>);

    fn residual<S: Real>(&self, (from, to): &Pair<G, S, D, R, N>) -> SVector<S, K> {
        self.factor.residual::<S>(&(G::variable::<S>(&self.value(from, to)),))
    }

    fn residual_jac(
        &self,
        (from, to): &Self::Variables,
    ) -> (SVector<f64, K>, (SMatrix<f64, K, N>, SMatrix<f64, K, N>)) {
        let (x, [d_from, d_to]) = self.value_jac(from, to);
        let (r, (d_x,)) = self.factor.residual_jac(&(x,));
        let d_x = matrix(&d_x);
        (r, (d_x * d_from, d_x * d_to))
    }
}

impl<F, G, L, const D: usize, const R: usize, const N: usize, const K: usize> Factor<K>
    for Interpolated<F, Moving<G, D, R, N>, (G, L)>
where
    G: GroupVariable<D>,
    L: Variable,
    F: Factor<K, Variables = (G, L)>,
{
    const NAME: &'static str = F::NAME;
    type Variables = (Moving<G, D, R, N>, Moving<G, D, R, N>, L);

    fn residual<S: Real>(
        &self,
        (from, to, other): &(
            Moving<<G as LieGroup<D>>::Over<S>, D, R, N>,
            Moving<<G as LieGroup<D>>::Over<S>, D, R, N>,
            L::Over<S>,
        ),
    ) -> SVector<S, K> {
        self.factor.residual::<S>(&(G::variable::<S>(&self.value(from, to)), *other))
    }

    fn residual_jac(
        &self,
        (from, to, other): &Self::Variables,
    ) -> (SVector<f64, K>, (SMatrix<f64, K, N>, SMatrix<f64, K, N>, L::Jacobian<K>)) {
        let (x, [d_from, d_to]) = self.value_jac(from, to);
        let (r, (d_x, d_other)) = self.factor.residual_jac(&(x, *other));
        let d_x = matrix(&d_x);
        (r, (d_x * d_from, d_x * d_to, d_other))
    }
}

/// A Jacobian block as the K×D matrix that it is.
pub(super) fn matrix<J: JacobianBlock, const K: usize, const D: usize>(block: &J) -> SMatrix<f64, K, D> {
    SMatrix::from_column_slice(block.as_slice())
}

/// ∂X(t)/∂γ of both states, D×N.
fn by_states<G: LieGroup<D, Scalar = f64>, const D: usize, const R: usize, const N: usize>(
    between: &GaussianProcess<G, D, R>,
    t: f64,
) -> [SMatrix<f64, D, N>; 2] {
    between.query_jac(t).map(|d| SMatrix::from_fn(|i, j| d[j / D].value[(i, j % D)]))
}

/// Whether `time` lies in an interval of length `duration`.
fn check(duration: f64, time: f64) -> Result<(), TrajectoryError> {
    if !(duration > 0.0 && duration.is_finite()) {
        return Err(TrajectoryError::NotADuration { duration });
    }
    if (0.0..=duration).contains(&time) {
        Ok(())
    } else {
        Err(TrajectoryError::OutOfRange { time, start: 0.0, end: duration })
    }
}
