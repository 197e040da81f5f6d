//! Uncertain elements of groups: how sure are we, in which frame, and to which order?
//!
//! A pose with an error is a random element of a group. Its error is small, so it is described where vectors are: in the
//! tangent space at the mean, by a covariance. Three things must be said of every covariance, and here types say them:
//!
//! - **Side.** X = X̄·Exp(ξ) ([`Local`]: errors in the frame of the body) or X = Exp(ξ)·X̄ ([`Global`]: of the parent). The two
//!   covariances of one random pose differ by Ad_X̄, exactly, and one read as the other can be off by any factor.
//! - **Validity.** A [`Covariance`] is symmetric and positive semi-definite, checked once. Directions without variance are
//!   allowed and known.
//! - **Order.** Σ₁ + AdΣ₂Adᵀ keeps second powers of the errors; with an uncertain heading the fourth count as well:
//!   [`Order`].
//!
//! ```
//! use boxplus::lie::{LieGroup, SE3};
//! use boxplus::uncertainty::{Gaussian, Order};
//! use nalgebra::vector;
//! let odometry = Gaussian::<SE3, 6>::from_sigmas(
//!     SE3::exp(&vector![1.0, 0.0, 0.0, 0.0, 0.0, 0.3]),
//!     &vector![0.1, 0.05, 0.01, 0.01, 0.01, 0.05], // metres, radians; forward, left, up
//! )?;
//! let ten_steps = Gaussian::chain([&odometry; 10], Order::Fourth);
//! let back = ten_steps.inverse();
//! let position = ten_steps.act(&vector![0.0, 0.0, 0.0], Order::Fourth); // with the shift of its mean
//! assert!(position.mean().vector().norm() < ten_steps.mean().translation().norm());
//! assert!((back.inverse().covariance().matrix() - ten_steps.covariance().matrix()).amax() < 1e-14);
//! # Ok::<(), boxplus::uncertainty::UncertaintyError>(())
//! ```
//!
//! | question | answer |
//! |---|---|
//! | products, inverses, chains of independent poses | [`Gaussian::compose`], [`Gaussian::inverse`], [`Gaussian::between`], [`Gaussian::chain`] |
//! | of correlated ones; one of them becomes known | [`Pair`], [`Joint`] |
//! | where is a point, seen through an uncertain pose? | [`Gaussian::act`], [`Gaussian::act_on`], [`Gaussian::expected_matrix`] |
//! | any other function | [`Gaussian::unscented`], [`Gaussian::expanded`] |
//! | several estimates of one pose | [`Gaussian::fuse`]; of unknown correlation, [`Gaussian::intersect`] |
//! | how far off, how likely, how different? | [`Gaussian::mahalanobis_squared`], [`Gaussian::haar_log_density`], [`Gaussian::kl_divergence`], [`ChiSquared`] |
//! | draw it | [`Gaussian::region`], [`Gaussian::ellipsoid`] |
//! | from data | [`Gaussian::from_samples`], [`Covariance::from_information`], [`Covariance::permuted`], [`Gaussian::from_yaw_pitch_roll`] |
//!
//! # Three moves of a covariance that are taken for one another
//!
//! From X̄ to Y = X̄·Exp(θ), for local errors:
//!
//! | move | Σ at Y | when | as a reset |
//! |---|---|---|---|
//! | frame change [`Gaussian::change_body`] | Ad_{Exp(−θ)} Σ Ad_{Exp(−θ)}ᵀ | the same error, of another point of the body | 40 % off |
//! | reset [`Gaussian::reset`] | J_r(θ) Σ J_r(θ)ᵀ | after a correction by θ: ξ ~ N(θ, Σ) told about its mean | 0.02 % off |
//! | parallel transport [`Gaussian::transport`] | Ad_{Exp(−θ/2)} Σ Ad_{Exp(−θ/2)}ᵀ | carrying the axes of an ellipsoid along | 6 % off |
//! | none | Σ | | 40 % off |
//!
//! The last column is Monte Carlo of a reset by 0.88 rad on SO(3), a test of the library. Frame change with the sign turned is
//! off by 95 %, and I − ½θ^, the usual approximation of J_r, by 25 %. "The covariance change may be omitted" holds for
//! small corrections only: at start-up, when corrections are large, it matters most.
//!
//! # Pitfalls
//!
//! - **Frame change is Ad_{Y⁻¹X}**, with elements inside; Ad of Y ⊖ X, a vector, is a slip of the pen that circulates.
//! - **Tables belong to a side.** The formulas for correlated poses in circulation are for *global* errors; used for local
//!   ones they are off by 100 %. Those of [`Pair`] exist for both.
//! - **J_l = J_rᵀ** holds on SO(2) and SO(3) only. In general J_l(ξ) = J_r(−ξ) = Ad_{Exp ξ}·J_r(ξ).
//! - **An inverse** has Ad_X̄ on both sides of Σ, a relative pose the cross-covariance transposed in one of its terms; either
//!   slip costs 60 to 150 %.
//! - **Off-diagonal entries matter**: N(0, Σ) is not given by its variances.
//! - **Averages.** The mean minimises the sum of *squared* distances; the sum of distances gives the median. It takes three
//!   to six steps, not many.
//! - **"Known to be a rotation in the plane"** is Σ = diag(σ², σ², ∞): known *up to* such rotations. An infinite variance is a
//!   missing row of information, not a covariance; see [`UncertaintyError::NoInformation`].
//!
//! Everything here has fixed size and allocates nothing. Functions that choose by value, such as where a pivot is zero,
//! do so on the number without its derivatives; dual numbers pass through.

mod act;
mod chi_squared;
mod covariance;
mod density;
mod error;
mod fuse;
mod gaussian;
mod joint;
pub(crate) mod linear;
mod propagate;
mod regions;
mod samples;
mod side;
mod transform;
mod yaw_pitch_roll;

pub use act::isotropic_shrink;
pub use chi_squared::ChiSquared;
pub use covariance::Covariance;
pub use error::{Direction, UncertaintyError};
pub use fuse::{Criterion, FuseOptions, Fused, Intersection};
pub use gaussian::Gaussian;
pub use joint::{Joint, Pair};
pub use propagate::{Compounded, Order, compound};
pub use regions::{Ellipsoid, Region};
pub use samples::Sampled;
pub use side::{Global, Local, Side};
pub use transform::{SigmaPoints, Transformed};
