//! What is assumed of the sensors and of the start: a file in TOML, every line of which may be left out.

use std::fs;
use std::path::Path;

use boxplus::filter::{Gate, ImuNoise};
use boxplus::uncertainty::{Covariance, UncertaintyError};
use nalgebra::SVector;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::error::Error;
use crate::settings::toml;

/// For odometry and sightings of beacons in the plane.
#[derive(Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Beacons {
    /// σ of what odometry is off after a second, growing with √t: m ahead, m sideways, rad.
    pub drift: [f64; 3],
    /// σ of a sighting: distance in m, direction in rad.
    pub sighting: [f64; 2],
    /// Where the vehicle is at first: m, m, rad.
    pub start: Option<[f64; 3]>,
    /// σ of that.
    pub start_sigmas: [f64; 3],
    /// Share of good sightings that are believed; 1 believes all.
    pub gate: f64,
}

impl Default for Beacons {
    fn default() -> Self {
        Self {
            drift: [0.03, 0.03, 0.06],
            sighting: [0.4, 0.06],
            start: None,
            start_sigmas: [0.5; 3],
            gate: 0.9999,
        }
    }
}

/// For an inertial sensor and positions.
#[derive(Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Gnss {
    /// White noise of the rates, rad/√s.
    pub gyroscope: f64,
    /// White noise of the forces, m/s/√s.
    pub accelerometer: f64,
    /// Walk of their biases, rad/s/√s and m/s²/√s.
    pub gyroscope_bias: f64,
    pub accelerometer_bias: f64,
    /// σ of a position in each direction, m.
    pub position: [f64; 3],
    /// Heading at first, about the vertical from x; that of the way to the second position unless given.
    pub heading_deg: Option<f64>,
    /// σ at first: position m, rotation rad, velocity m/s, bias of the rates rad/s, of the forces m/s².
    pub start_sigmas: [f64; 5],
    /// Share of good positions that are believed; 1 believes all.
    pub gate: f64,
}

impl Default for Gnss {
    fn default() -> Self {
        Self {
            gyroscope: 1.75e-3,
            accelerometer: 0.1,
            gyroscope_bias: 2e-5,
            accelerometer_bias: 3e-3,
            position: [0.1; 3],
            heading_deg: None,
            start_sigmas: [0.1, 0.3, 2.0, 0.01, 0.2],
            gate: 1.0,
        }
    }
}

impl Gnss {
    /// The densities, once they are known to be some.
    pub fn noise(&self) -> Result<ImuNoise, Error> {
        let Self { gyroscope, accelerometer, gyroscope_bias, accelerometer_bias, .. } = *self;
        sigmas(
            "gyroscope, accelerometer and their biases",
            [gyroscope, accelerometer, gyroscope_bias, accelerometer_bias],
        )?;
        Ok(ImuNoise { gyroscope, accelerometer, gyroscope_bias, accelerometer_bias })
    }
}

/// The file, or what is assumed without one.
pub fn read<T: DeserializeOwned + Default>(path: Option<&Path>, keys: &str) -> Result<T, Error> {
    let Some(path) = path else { return Ok(T::default()) };
    let text = fs::read_to_string(path).map_err(|source| Error::Read { path: path.to_owned(), source })?;
    toml(&path.display().to_string(), &text, &format!("this model has {keys}; see `boxplus filter --help`"))
}

/// Independent coordinates of these standard deviations.
pub fn sigmas<const N: usize>(key: &str, values: [f64; N]) -> Result<Covariance<N>, Error> {
    Covariance::from_sigmas(&SVector::from(values)).map_err(|error| refused(key, &error))
}

/// A gate that keeps this share of good measurements.
pub fn gate(share: f64) -> Result<Gate, Error> {
    if share > 0.0 && share <= 1.0 {
        return Ok(Gate::at(share));
    }
    Err(refused("gate", &UncertaintyError::NotAProbability { given: share }))
}

fn refused(key: &str, error: &UncertaintyError) -> Error {
    Error::Unreadable {
        message: format!("{key} of the configuration: {error}"),
        help: Some(
            "standard deviations in metres, radians and seconds; see `boxplus filter --help`".to_owned(),
        ),
    }
}
