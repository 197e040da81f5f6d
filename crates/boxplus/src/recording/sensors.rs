//! What sensors record.

use crate::filter::Imu;
use crate::lie::SE23;
use nalgebra::{Vector2, Vector3};

/// One reading of an inertial sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuReading {
    /// Angular rate, in rad/s of the body.
    pub gyroscope: Vector3<f64>,
    /// Specific force, in m/s² of the body: at rest, +g upwards.
    pub accelerometer: Vector3<f64>,
}

impl ImuReading {
    /// The reading held for `duration` seconds: an input of the inertial models.
    pub fn held(&self, duration: f64) -> Imu {
        Imu { gyroscope: self.gyroscope, accelerometer: self.accelerometer, duration }
    }
}

/// Speeds of a vehicle in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist2 {
    /// Ahead, in m/s.
    pub forward: f64,
    /// Counter-clockwise, in rad/s.
    pub turning: f64,
}

/// Something with a label, seen at a distance in a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighted {
    /// Which.
    pub label: u32,
    /// In metres.
    pub range: f64,
    /// In radians from straight ahead, counter-clockwise.
    pub bearing: f64,
}

/// A landmark in the plane whose place is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landmark {
    /// Which.
    pub label: u32,
    /// In metres.
    pub position: Vector2<f64>,
    /// Standard deviations of x and y, in metres.
    pub sigmas: Vector2<f64>,
}

/// Pose, velocity and biases, as a reference system knows them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NavigationState {
    /// world_from_body and the velocity in the world.
    pub motion: SE23,
    /// In rad/s.
    pub gyroscope_bias: Vector3<f64>,
    /// In m/s².
    pub accelerometer_bias: Vector3<f64>,
}
