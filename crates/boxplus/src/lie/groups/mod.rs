//! The groups, one file each: required items, constructors with their errors, and the page that teaches it.

mod format;
mod homogeneous;
mod plain;
mod r3xso3;
mod rn;
mod rxso2;
mod rxso3;
mod s3;
mod se2;
mod se23;
mod se3;
mod second;
mod sgal3;
mod sim2;
mod sim3;
mod similarity;
mod so2;
mod so3;

pub use plain::Plain;
#[cfg(feature = "serde")]
pub(crate) use plain::every_plain;
#[cfg(feature = "bytemuck")]
pub use plain::{PlainSlices, SliceError};
pub use r3xso3::R3xSO3;
pub use rn::Rn;
pub use rxso2::RxSO2;
pub use rxso3::RxSO3;
pub use s3::{S1, S3};
pub use se2::SE2;
pub use se3::SE3;
pub use se23::SE23;
pub use sgal3::SGal3;
pub use sim2::Sim2;
pub use sim3::Sim3;
pub use so2::SO2;
pub use so3::SO3;
