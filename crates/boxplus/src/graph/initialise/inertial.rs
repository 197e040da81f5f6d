//! Where to start with an inertial sensor whose attitude nobody knows.

use nalgebra::{Matrix3, Vector3};

use crate::lie::{Action, LieError, LieGroup, SE23, SO3};
use crate::trajectory::Preintegration;

/// States of an inertial sensor from positions alone, in closed form: of the first attitude nothing needs to be known, of gravity
/// all.
///
/// ```text
/// w_k = (P_{k+2} − P_{k+1})/T_{k+1} − (P_{k+1} − P_k)/T_k − ½g(T_k + T_{k+1})            world
/// b_k = A_k·(Δv_k − Δp_k/T_k) + A_{k+1}·Δp_{k+1}/T_{k+1}      A_k = ΔR_0·…·ΔR_{k−1}      first body frame
/// w_k = R₀·b_k      R₀ = argmin Σ |w_k − R₀b_k|²
/// ```
/// Exact where sums and positions are: velocities are eliminated, and R₀ is the nearest rotation to Σ w_k·b_kᵀ, Horn (1987). A bias of
/// the gyroscope turns A_k further and further: make the sums about what it shows at rest, or take the legs of a minute.
///
/// `first` is the position at the start; each leg is a sum and the position at its end; all positions in metres of the world, of the
/// sensor itself. One state more than legs is returned.
///
/// ```
/// use boxplus::graph::inertial_start;
/// use boxplus::lie::{LieGroup, SE23};
/// use boxplus::trajectory::{Imu, ImuBias, ImuNoise, Preintegration};
/// use nalgebra::{SVector, Vector3};
/// let (bias, gravity) = (ImuBias::zero(), Vector3::new(0.0, 0.0, -9.81));
/// let mut states = vec![SE23::exp(&SVector::<f64, 9>::from_fn(|i, _| (i as f64).cos()))]; // whatever it is
/// let mut legs = vec![];
/// for k in 0..4 {
///     let t = f64::from(k);
///     let sample = Imu { gyroscope: Vector3::new(t.sin(), 0.3, 0.2), accelerometer: Vector3::new(t, 1.0, 9.0), duration: 0.1 };
///     let sum = Preintegration::of(&[sample; 5], bias, ImuNoise { gyro: 1e-3, accel: 1e-2 })?;
///     states.push(sum.predict(&states[k as usize], &bias, &gravity));
///     legs.push((sum, states[k as usize + 1].position()));
/// }
/// let start = inertial_start(states[0].position(), &legs, &gravity)?;
/// assert!(start.iter().zip(&states).all(|(x, y)| x.is_near(y, 1e-12)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`LieError::Undetermined`] where the heading does not show: fewer than two legs, at rest, or no acceleration but along gravity;
/// [`LieError::NotFinite`].
pub fn inertial_start(
    first: Vector3<f64>,
    legs: &[(Preintegration, Vector3<f64>)],
    gravity: &Vector3<f64>,
) -> Result<Vec<SE23>, LieError> {
    let legs = Legs::new(first, legs);
    let start = legs.attitude(gravity)?;
    Ok(legs.states(&start, gravity))
}

/// What is known of each leg.
struct Leg<'a> {
    sum: &'a Preintegration,
    /// A_k.
    first_from_start: SO3,
    start: Vector3<f64>,
    /// The average over the leg, in the world.
    velocity: Vector3<f64>,
}

struct Legs<'a>(Vec<Leg<'a>>, Vector3<f64>);

impl<'a> Legs<'a> {
    fn new(first: Vector3<f64>, legs: &'a [(Preintegration, Vector3<f64>)]) -> Self {
        let (mut turned, mut place) = (SO3::identity(), first);
        let mut all = Vec::with_capacity(legs.len());
        for (sum, end) in legs {
            let velocity = (end - place) / sum.duration();
            all.push(Leg { sum, first_from_start: turned, start: place, velocity });
            (turned, place) = (turned * sum.increment().rotation(), *end);
        }
        Self(all, place)
    }

    /// R₀.
    fn attitude(&self, gravity: &Vector3<f64>) -> Result<SO3, LieError> {
        let mut sum = Matrix3::zeros();
        for pair in self.0.windows(2) {
            let [now, next] = [&pair[0], &pair[1]];
            let [t, t_next] = [now, next].map(|leg| leg.sum.duration());
            let [step, step_next] = [now, next].map(|leg| leg.sum.increment());
            let world = next.velocity - now.velocity - gravity * (0.5 * (t + t_next));
            let body = now.first_from_start.act(&(step.velocity() - step.position() / t))
                + next.first_from_start.act(&(step_next.position() / t_next));
            sum += world * body.transpose();
        }
        SO3::project(&sum)
    }

    /// Attitudes by the gyroscope, velocities by what position and accelerometer say together.
    fn states(&self, start: &SO3, gravity: &Vector3<f64>) -> Vec<SE23> {
        let mut states: Vec<SE23> = Vec::with_capacity(self.0.len() + 1);
        let mut end = None;
        for leg in &self.0 {
            let (rotation, t, step) =
                (*start * leg.first_from_start, leg.sum.duration(), leg.sum.increment());
            let velocity = leg.velocity - gravity * (0.5 * t) - rotation.act(&step.position()) / t;
            states.push(SE23::new(rotation, leg.start, velocity));
            end = Some((rotation * step.rotation(), velocity + gravity * t + rotation.act(&step.velocity())));
        }
        states.extend(end.map(|(rotation, velocity)| SE23::new(rotation, self.1, velocity)));
        states
    }
}
