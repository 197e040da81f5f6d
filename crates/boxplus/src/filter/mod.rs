//! Filters: one belief, carried through motions and measurements.
//!
//! A filter knows a state by a [`Gaussian`](crate::uncertainty::Gaussian): a mean on the group and the covariance of its error.
//! A [`Motion`] moves it and makes it wider, a [`Measurement`] corrects it and makes it narrower:
//!
//! ```text
//! predict   x ← f(x, u)    P ← FPFᵀ + GQGᵀ
//! gate      z = y − h(x)   S = HPHᵀ + N     zᵀS⁻¹z beyond the χ² quantile: not believed
//! update    K = PHᵀS⁻¹     δ = Kz           P ← (I − KH)P(I − KH)ᵀ + KNKᵀ
//! inject    x ← x ⊞ δ
//! reset     P ← J(δ)·P·J(δ)ᵀ
//! ```
//!
//! A robot drives, sees a beacon, and knows where it is:
//!
//! ```
//! use boxplus::filter::{Ekf, Filter, Gate, Odometry, Outcome, RangeBearing};
//! use boxplus::lie::{LieGroup, SE2};
//! use boxplus::uncertainty::{Covariance, Gaussian};
//! use nalgebra::vector;
//! let filter = Ekf::iterated().gated(Gate::at(0.999));
//! let odometry = Odometry { noise: Covariance::from_sigmas(&vector![0.05, 0.01, 0.02])? }; // metres, metres, radians
//! let mut belief = Gaussian::<SE2, 3>::certain(SE2::identity());
//! for _ in 0..10 {
//!     belief = filter.predict(&belief, &odometry, &vector![0.5, 0.0, 0.1])?;
//! }
//! let lost = belief.sigmas();
//! let noise = Covariance::from_sigmas(&vector![0.1, 0.02])?; // metres, radians
//! let update = filter.update(&belief, &RangeBearing { beacon: vector![4.0, 6.0], measured: vector![3.3, 0.4], noise });
//! match update.outcome {
//!     Outcome::Accepted(innovation) => assert!(innovation.nis < 13.8),
//!     Outcome::Gated(innovation) => panic!("an outlier, NIS {}", innovation.nis),
//!     Outcome::Refused(error) => panic!("{error}"),
//! }
//! assert!(update.belief.sigmas()[1] < lost[1]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | question | answer |
//! |---|---|
//! | which filter? | [`Ekf::iterated`] where corrections are large, [`Ekf::default`] else; [`Ukf`] where no derivative is to be had |
//! | which side? | the one on which errors move by themselves: see below |
//! | a sensor of my own | [`Measurement`], a vehicle of my own: [`Motion`]; without algebra: `ByDuals` (feature `autodiff`) |
//! | a vehicle told by a differential equation | [`Flow`], through [`Discretised`] |
//! | nothing is known at the start; very many sensors | [`InformationBelief`] |
//! | seven digits (`f32`), and a sensor far better than the prior | [`SquareRootBelief`] |
//! | biases, calibration, several bodies | one [`bundle!`](crate::bundle), its fields measured through [`Part`] |
//! | the whole past, not only now | [`Smoother`] |
//! | measurements that come late | [`Replay`] |
//! | can the covariance be believed? | `MonteCarlo`, on a `Simulation` or one of your own (feature `rand`) |
//!
//! # The side of the error
//!
//! The belief's type says where errors stand, `Gaussian<G, D, Local>` or `<G, D, Global>`: X = X̂·Exp(ξ) or Exp(ξ)·X̂. The first is the
//! *left*-invariant error X̂⁻¹X of Barrau & Bonnabel (2017), the second their *right*-invariant XX̂⁻¹. There is one machinery for both:
//! what their papers add, an innovation turned into the frame of the body or of the world, turns H and N along and leaves Kz as it
//! is. Predictions are the same on either side, exactly; so are single corrections with reset. What differs is the shape of the prior,
//! a banana in one of them, and which derivatives depend on the estimate:
//!
//! | measured | seen | side on which H does not depend on the estimate |
//! |---|---|---|
//! | positions, velocities in the world: GNSS | [`PositionFix`] | `Local` |
//! | landmarks, directions in the body: camera, magnetometer | [`Sighting`], [`VectorSighting`] | `Global` |
//!
//! For motions that are *group-affine* (odometry, inertial navigation on SE₂(3)) the error moves by a matrix that is free of the state and
//! right for errors of any size: [`DeadReckoning`]. That is why these models live on the groups they live on.
//!
//! # Pitfalls
//!
//! - **The reset** J_r(δ)PJ_r(δ)ᵀ is missing from most texts. In the demonstration of Solà et al. (2018) it lowers the average NEES
//!   from 4.26 to 3.81 of an ideal 3; iterating gives 3.00. These numbers are tests of the library.
//! - **A state on ⟨ℝ³, SO(3)⟩ is not one on SE(3)**: with a heading unknown by 45° the former's NEES of position is a hundred times
//!   too large. Run the example `filter_consistency`.
//! - **An exact sensor** of a state that is certain has a singular S: refused, by name. Noise is never zero in practice.
//! - **Densities and discrete noise**: data sheets give densities, per √Hz. [`ImuNoise`] takes those; simulations that draw one number of
//!   deviation σ per step of Δ have the density σ√Δ.
//! - **Degrees**: rates are in rad/s, specific forces in m/s². A filter cannot tell; its NIS will.
//! - **A gate** hides a wrong model as well as an outlier: look at the share that is gated before trusting it.
//!
//! Fixed sizes, no allocation per step, `no_std`; [`Smoother`], [`Replay`] and `MonteCarlo` need `std`.
#![allow(clippy::type_complexity)] // A value and one Jacobian per argument; naming each tuple would hide that.

#[cfg(all(feature = "rand", feature = "std"))]
mod consistency;
mod continuous;
#[cfg(feature = "autodiff")]
mod duals;
mod ekf;
mod error;
mod information;
mod model;
mod models;
#[cfg(feature = "std")]
mod replay;
#[cfg(all(feature = "rand", feature = "std"))]
mod simulations;
#[cfg(feature = "std")]
mod smooth;
mod square_root;
mod step;
mod ukf;

#[cfg(all(feature = "rand", feature = "std"))]
pub use consistency::{ConsistencyError, MonteCarlo, Report, Run, Series, Verdict};
pub use continuous::{Discretised, Flow};
#[cfg(feature = "autodiff")]
pub use duals::{ByDuals, SmoothMeasurement, SmoothMotion};
pub use ekf::Ekf;
pub use error::FilterError;
pub use information::InformationBelief;
pub use model::{Measurement, Motion, check_measurement, check_motion};
pub use models::*;
#[cfg(feature = "std")]
pub use replay::Replay;
#[cfg(all(feature = "rand", feature = "std"))]
pub use simulations::{Rule, Simulation, Trial, UnknownSimulation};
#[cfg(feature = "std")]
pub use smooth::Smoother;
pub use square_root::SquareRootBelief;
pub use step::{Filter, Gate, Innovation, Outcome, Predicted, Update};
pub use ukf::Ukf;
