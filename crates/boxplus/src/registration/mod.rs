//! Clouds of points laid upon each other: the transform, and how sure it is.
//!
//! **Pairs.** Where it is known which points correspond, the best motion or similarity has a closed form, [`Pairs::align`], and its
//! covariance follows from the noise of the points, [`Pairs::uncertain`]. Points that leave a rotation open are refused, with
//! the axis that is free.
//!
//! **Scans** (feature `registration`). Where it is not known, points are paired with their nearest neighbours, the transform is
//! improved, and again: iterated closest points, [`Scan::align`], Besl & McKay (1992). What is minimised, for matches (p, q),
//! r = q − X·p and n, C the normal and covariance of the surface at a point:
//!
//! ```text
//! point to point    Σ ρ(|r|²/σ²)                    Besl & McKay (1992)
//! point to plane    Σ ρ((n_qᵀr)²/σ²)                Chen & Medioni (1992)
//! generalised       Σ ρ(rᵀ(C_q + R·C_p·Rᵀ)⁻¹r/σ²)   Segal, Haehnel & Thrun (2009)
//! ```
//!
//! # Pitfalls
//!
//! - **The start counts.** Matches within [`Icp::max_distance`] of a wrong place hold the estimate there. Nothing here searches.
//! - **Corridors.** A scan of two parallel walls slides along them, and its covariance, from matches that slide along, would not
//!   tell. [`Registered::free`] names such directions; the start is kept along them.
//! - **Covariance of matched scans** counts matches as independent. Neighbours share their normals and their partners, so
//!   that true errors are larger; [`Registered::pose`] says by how much in a simulated room.
//! - **Rings of a lidar.** The nearest neighbours of a point of a sparse scan lie on its own ring, a line without normal. Thin the scan
//!   ([`Preparation::voxel`]); points without normal take no part in point to plane.

mod closed_form;
mod error;
#[cfg(feature = "registration")]
mod icp;
#[cfg(feature = "registration")]
mod matching;
#[cfg(feature = "registration")]
mod observed;
#[cfg(feature = "registration")]
mod scan;
#[cfg(feature = "registration")]
mod surface;
#[cfg(feature = "registration")]
mod voxel;

#[cfg(feature = "registration")]
pub use crate::robust::{Kernel, KernelError};
pub use closed_form::{Alignable, Aligned, Noise, Pairs, Rigid};
pub use error::{Axis, RegistrationError, Role};
#[cfg(feature = "registration")]
pub use icp::{Icp, Method, Registered, Termination, UnknownMethod};
#[cfg(feature = "registration")]
pub use observed::Free;
#[cfg(feature = "registration")]
pub use scan::{Preparation, Scan};
#[cfg(feature = "registration")]
pub use voxel::thinned;
