//! Inertial measurements between two states, pre-integrated.

use std::sync::Arc;

use nalgebra::{SMatrix, SVector, Vector3};

use crate::graph::{Factor, GraphError, Noise, Renewed};
use crate::lie::{Manifold, Real, S2, SE23};
use crate::trajectory::{Imu, ImuBias, ImuNoise, Preintegration, TrajectoryError};

/// Inertial samples between two states of the sensor, under known gravity: [`Preintegration`] as a factor.
///
/// ```text
/// r = Log(Δ(b)⁻¹·F(X_i)⁻¹·Γ⁻¹·X_j) ~ N(0, Σ)      ∈ ℝ⁹, local tangent (ρ, φ, ν) of SE₂(3): m, rad, m/s
/// ```
///
/// Reads the states X_i, X_j and the bias b, which held during the samples. Biases of successive factors are joined by a random
/// walk: a [`Between`](super::Between) whose measurement is [`ImuBias::zero`] and whose standard deviations are the densities of the
/// walk times √T.
///
/// Δ(b) is linear in the change of the bias. How far off that is where the bias has moved, and the sum about the new bias, is what
/// [`Graph::renew`](crate::graph::Graph::renew) tells and makes.
///
/// ```
/// use boxplus::graph::{Graph, Inertial, Prior, Noise, SolveOptions, Values};
/// use boxplus::lie::{LieGroup, SE23};
/// use boxplus::trajectory::{Imu, ImuBias, ImuNoise};
/// use nalgebra::{SVector, Vector3};
/// // A second at rest, but for a push of 0.5 m/s² ahead.
/// let push = Imu { gyroscope: Vector3::zeros(), accelerometer: Vector3::new(0.5, 0.0, 9.81), duration: 0.01 };
/// let noise = ImuNoise { gyro: 1e-3, accel: 1e-2 };
/// let imu = Inertial::new(&[push; 100], ImuBias::zero(), noise, Vector3::new(0.0, 0.0, -9.81))?;
///
/// let (mut graph, mut values) = (Graph::new(), Values::new());
/// let states = [SE23::identity(); 2].map(|x| values.insert(x));
/// let bias = values.insert(ImuBias::zero());
/// values.hold(bias);
/// graph.add((states[0],), Prior { mean: SE23::identity() }, Noise::from_sigmas(&SVector::repeat(0.01))?);
/// let sigma = imu.noise()?;
/// graph.add((states[0], states[1], bias), imu, sigma);
/// let solution = graph.optimize(&values, &SolveOptions::default())?;
/// let end = solution.values.get(states[1]).ok_or("no such state")?;
/// assert!((end.position() - Vector3::new(0.25, 0.0, 0.0)).norm() < 1e-9);
/// assert!((end.velocity() - Vector3::new(0.5, 0.0, 0.0)).norm() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Forster et al. (2017); Barrau & Bonnabel (2017), Brossard et al. (2022).
///
/// `G` is what is known of gravity: the vector, in m/s² of the world, (0, 0, −9.81) where z points up; or of
/// [`InertialUnderGravity`] its strength.
#[derive(Clone, Debug)]
pub struct Inertial<G = Vector3<f64>> {
    samples: Samples,
    /// What is known of gravity, in m/s².
    pub gravity: G,
}

impl<G: Copy> Inertial<G> {
    /// The sum of `samples`, in order of time, about `bias`, the best known.
    ///
    /// # Errors
    /// Those of [`Preintegration::of`].
    pub fn new(samples: &[Imu], bias: ImuBias, noise: ImuNoise, gravity: G) -> Result<Self, TrajectoryError> {
        Ok(Self { samples: Samples::new(samples, bias, noise)?, gravity })
    }

    /// The sum, about the bias it was made with.
    pub fn sum(&self) -> &Preintegration {
        &self.samples.sum
    }

    /// Σ of the sum, 9×9: the noise of this factor.
    ///
    /// # Errors
    /// [`GraphError::NotPositiveDefinite`] where there are fewer than two samples: a single one leaves no doubt that position and
    /// velocity go together.
    pub fn noise(&self) -> Result<Noise<9>, GraphError> {
        Noise::from_covariance(&self.samples.sum.covariance())
    }

    /// The factor of the sum made anew about `bias`.
    fn about(&self, bias: &ImuBias) -> Option<Renewed<Self, 9>> {
        let (samples, noise, error) = self.samples.about(bias)?;
        Some(Renewed { factor: Self { samples, gravity: self.gravity }, noise, error })
    }
}

impl Factor<9> for Inertial {
    const NAME: &'static str = "inertial samples";
    type Variables = (SE23, SE23, ImuBias);

    fn residual<S: Real>(&self, (from, to, bias): &(SE23<S>, SE23<S>, ImuBias<S>)) -> SVector<S, 9> {
        self.samples.sum.map(S::lit).residual(from, to, bias, &self.gravity.map(S::lit))
    }

    fn residual_jac(
        &self,
        (from, to, bias): &(SE23, SE23, ImuBias),
    ) -> (SVector<f64, 9>, (SMatrix<f64, 9, 9>, SMatrix<f64, 9, 9>, SMatrix<f64, 9, 6>)) {
        let (r, d_from, d_to, d_bias, _) = self.samples.sum.residual_jac(from, to, bias, &self.gravity);
        (r, (d_from, d_to, d_bias))
    }

    fn renewed(&self, (_, _, bias): &Self::Variables) -> Option<Renewed<Self, 9>> {
        self.about(bias)
    }
}

/// Inertial samples between two states of the sensor where only the strength of gravity is known: its direction is a variable, down,
/// in the frame of the states.
///
/// [`Inertial`] otherwise. For states whose frame nobody has levelled: that of the first camera, or of a motion capture system; or,
/// where positions are known in a levelled one, to see how level it is. ∂g/∂n = |g|·B(n), 3×2.
pub type InertialUnderGravity = Inertial<f64>;

impl Factor<9> for InertialUnderGravity {
    const NAME: &'static str = "inertial samples under gravity";
    type Variables = (SE23, SE23, ImuBias, S2);

    fn residual<S: Real>(
        &self,
        (from, to, bias, down): &(SE23<S>, SE23<S>, ImuBias<S>, S2<S>),
    ) -> SVector<S, 9> {
        self.samples.sum.map(S::lit).residual(from, to, bias, &(down.vector() * S::lit(self.gravity)))
    }

    fn residual_jac(
        &self,
        (from, to, bias, down): &(SE23, SE23, ImuBias, S2),
    ) -> (SVector<f64, 9>, (SMatrix<f64, 9, 9>, SMatrix<f64, 9, 9>, SMatrix<f64, 9, 6>, SMatrix<f64, 9, 2>))
    {
        let gravity = down.vector() * self.gravity;
        let (r, d_from, d_to, d_bias, d_gravity) = self.samples.sum.residual_jac(from, to, bias, &gravity);
        (r, (d_from, d_to, d_bias, d_gravity * down.basis() * self.gravity))
    }

    fn renewed(&self, (_, _, bias, _): &Self::Variables) -> Option<Renewed<Self, 9>> {
        self.about(bias)
    }
}

/// Samples and their sum.
#[derive(Clone, Debug)]
struct Samples {
    all: Arc<[Imu]>,
    sum: Preintegration,
}

impl Samples {
    fn new(all: &[Imu], bias: ImuBias, noise: ImuNoise) -> Result<Self, TrajectoryError> {
        Ok(Self { all: all.into(), sum: Preintegration::of(all, bias, noise)? })
    }

    /// The sum anew about `bias`, its noise, and how many standard deviations the corrected old one is off.
    fn about(&self, bias: &ImuBias) -> Option<(Self, Noise<9>, f64)> {
        let sum = Preintegration::of(&self.all, *bias, self.sum.noise()).ok()?;
        let noise = Noise::from_covariance(&sum.covariance()).ok()?;
        let off = self.sum.corrected(bias).minus(&sum.increment());
        let error = (noise.sqrt_information() * off).norm();
        Some((Self { all: self.all.clone(), sum }, noise, error))
    }
}
