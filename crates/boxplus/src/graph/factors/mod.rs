//! The measurements that come with the library. Each file gives the residual, its Jacobians, and the equation.

mod bearing;
mod between;
mod chart;
mod continuous;
mod fix;
mod inertial;
mod odometry;
mod prior;
mod range;
mod reprojection;
mod sighting;
mod spline;

pub use bearing::{Bearing2, Bearing3};
pub use between::Between;
#[cfg(feature = "io")]
pub(crate) use chart::isotropic_information;
pub(crate) use chart::isotropic_weights;
pub use chart::{Chart, Chordal, Difference, G2o, Log, Product};
pub use continuous::{Interpolated, MotionPrior};
pub use fix::{Position, Velocity};
pub use inertial::{Inertial, InertialUnderGravity};
pub use odometry::CalibratedOdometry;
pub use prior::Prior;
pub use range::Range;
pub use reprojection::{Reprojection, ReprojectionOwn, ReprojectionShared};
pub use sighting::{Sighting2, Sighting3};
pub use spline::{OnSpline, SplineImu};

#[cfg(test)]
mod tests;
