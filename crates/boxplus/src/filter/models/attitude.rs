//! Attitude from a gyroscope.

use crate::bundle;
use crate::filter::Motion;
use crate::lie::{Jacobian, LieGroup, Real, Rn, SO3};
use crate::uncertainty::Covariance;
use nalgebra::{SVector, Vector3, Vector6};

bundle! {
    /// An attitude and the bias of the gyroscope that carries it, tangent (φ, b).
    pub struct Attitude {
        /// world_from_body.
        pub rotation: SO3 [3],
        /// b, in rad/s.
        pub gyroscope_bias: Rn<3> [3],
    }
}

/// Attitude by a gyroscope with a wandering bias: R⁺ = R·Exp((ω̃ − b − w)Δ). The input is (ω̃ in rad/s, Δ in s).
///
/// w = (reading, change of the bias), 6. Corrections come from [`VectorSighting`](super::VectorSighting)s of gravity and of the
/// magnetic field, through a [`Part`](super::Part); without the latter, the heading and the bias about the vertical stay
/// unknown, and the covariance says so.
///
/// ```
/// use boxplus::filter::{Attitude, Ekf, Filter, Gyroscope, Part, VectorSighting};
/// use boxplus::lie::LieGroup;
/// use boxplus::uncertainty::{Covariance, Gaussian};
/// use nalgebra::{SVector, Vector3, vector};
/// let gyroscope = Gyroscope { noise: 1e-3, bias_walk: 1e-5 };
/// let mut belief = Gaussian::<Attitude, 6>::from_sigmas(Attitude::identity(), &SVector::repeat(0.3))?;
/// let down = Covariance::from_sigmas(&Vector3::repeat(0.1))?;
/// for _ in 0..200 {
///     belief = Ekf::default().predict(&belief, &gyroscope, &(vector![0.02, 0.0, 0.0], 0.1))?; // it does not turn: a bias
///     let gravity = Part {
///         measurement: VectorSighting {
///             reference: vector![0.0, 0.0, 9.81], measured: vector![0.0, 0.0, 9.81], noise: down,
///         },
///         of: |x: &Attitude| x.rotation,
///         block: Attitude::BLOCKS.rotation,
///     };
///     belief = Ekf::default().update(&belief, &gravity).belief;
/// }
/// assert!((belief.mean().gyroscope_bias.vector().x - 0.02).abs() < 1e-3);
/// assert!(belief.sigmas()[2] > 0.3 && belief.sigmas()[5] > 0.29); // nothing tells the heading
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gyroscope<S = f64> {
    /// Angular random walk, in rad/s/√Hz.
    pub noise: S,
    /// Random walk of the bias, in rad/s²/√Hz.
    pub bias_walk: S,
}

impl<S: Real> Motion<Attitude<S>, 6, 6> for Gyroscope<S> {
    type Input = (Vector3<S>, S);

    fn step(&self, x: &Attitude<S>, (rate, dt): &(Vector3<S>, S), w: &Vector6<S>) -> Attitude<S> {
        let turn = (rate - x.gyroscope_bias.vector() - w.fixed_rows::<3>(0)) * *dt;
        Attitude {
            rotation: x.rotation.rplus(&turn),
            gyroscope_bias: Rn::new(x.gyroscope_bias.vector() + w.fixed_rows::<3>(3)),
        }
    }
    fn noise(&self, (_, dt): &(Vector3<S>, S)) -> Covariance<6, S> {
        let root = dt.simd_sqrt();
        let sigmas = [self.noise / root, self.bias_walk * root];
        Covariance::independent(&SVector::from_fn(|i, _| sigmas[i / 3]))
    }
    fn step_jac(
        &self,
        x: &Attitude<S>,
        (rate, dt): &(Vector3<S>, S),
    ) -> (Attitude<S>, Jacobian<S, 6>, Jacobian<S, 6>) {
        let turn = (rate - x.gyroscope_bias.vector()) * *dt;
        let (rotation, d_rotation, d_turn) = x.rotation.rplus_jac(&turn);
        let d_rate = d_turn * -*dt;
        let (mut f, mut g) = (Jacobian::<S, 6>::identity(), Jacobian::<S, 6>::identity());
        f.fixed_view_mut::<3, 3>(0, 0).copy_from(&d_rotation);
        f.fixed_view_mut::<3, 3>(0, 3).copy_from(&d_rate);
        g.fixed_view_mut::<3, 3>(0, 0).copy_from(&d_rate);
        (Attitude { rotation, gyroscope_bias: x.gyroscope_bias }, f, g)
    }
}
