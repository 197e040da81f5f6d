//! Models that come with the library, one file each.

mod attitude;
mod inertial;
mod odometry;
mod part;
mod sightings;
mod stereo;
mod wheels;

pub use crate::trajectory::Imu;
pub use attitude::{Attitude, Gyroscope};
pub use inertial::{DeadReckoning, ImuNoise, Inertial, InertialState, STANDARD_GRAVITY, VelocityFix};
pub use odometry::Odometry;
pub use part::Part;
pub use sightings::{PositionFix, Range, RangeBearing, Sighting, VectorSighting};
pub use stereo::StereoSighting;
pub use wheels::{DifferentialDrive, WheelTravel};
