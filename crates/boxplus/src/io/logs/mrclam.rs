//! The `.dat` files of the UTIAS multi-robot data sets, Leung et al. (2011).

use super::Stamp;
use super::table::{
    Layout,
    Unit::{Angle, Any, Rate},
    read_log,
};
use crate::io::error::{IoError, IoErrorKind};
use crate::lie::SE2;
use crate::recording::{Landmark, Log, Sighted, Twist2};
use nalgebra::Vector2;

/// `RobotN_Odometry.dat`: time, forward speed in m/s, turn rate in rad/s.
///
/// ```
/// use boxplus::io::read_mrclam_odometry;
/// let text = "# Time [s]    forward velocity [m/s]    angular velocity[rad/s]\n1248444187.156 \t  0.086 \t -0.398\n";
/// let log = read_mrclam_odometry(text.as_bytes(), "Robot1_Odometry.dat")?;
/// assert_eq!(log.samples[0].value.turning, -0.398);
/// # Ok::<(), boxplus::io::IoError>(())
/// ```
///
/// # Errors
/// Those of [`read_log`].
pub fn read_mrclam_odometry(bytes: &[u8], name: &str) -> Result<Log<Twist2>, IoError> {
    let layout = Layout {
        format: "MRCLAM odometry",
        stamp: Stamp::Seconds,
        fields: "time forward turning",
        named: false,
        units: [Any, Rate],
    };
    read_log(bytes, name, &layout, |[forward, turning]| Ok(Twist2 { forward, turning }))
}

/// `RobotN_Measurement.dat`: time, barcode, range in metres, bearing in radians.
///
/// # Errors
/// Those of [`read_log`], and a barcode that is no whole number.
pub fn read_mrclam_measurements(bytes: &[u8], name: &str) -> Result<Log<Sighted>, IoError> {
    let layout = Layout {
        format: "MRCLAM measurements",
        stamp: Stamp::Seconds,
        fields: "time barcode range bearing",
        named: false,
        units: [Any, Any, Angle],
    };
    read_log(bytes, name, &layout, |[barcode, range, bearing]| {
        Ok(Sighted { label: whole(barcode)?, range, bearing })
    })
}

/// `RobotN_Groundtruth.dat`: time, x, y in metres, heading in radians.
///
/// # Errors
/// Those of [`read_log`].
pub fn read_mrclam_groundtruth(bytes: &[u8], name: &str) -> Result<Log<SE2>, IoError> {
    let layout = Layout {
        format: "MRCLAM ground truth",
        stamp: Stamp::Seconds,
        fields: "time x y heading",
        named: false,
        units: [Any, Any, Angle],
    };
    read_log(bytes, name, &layout, |[x, y, heading]| Ok(SE2::new(Vector2::new(x, y), heading)))
}

/// `Barcodes.dat`: pairs of subject and barcode.
///
/// # Errors
/// Those of [`read_log`], and what is no whole number.
pub fn read_mrclam_barcodes(bytes: &[u8], name: &str) -> Result<Vec<[u32; 2]>, IoError> {
    let layout = Layout {
        format: "MRCLAM barcodes",
        stamp: Stamp::Every(1.0),
        fields: "subject barcode",
        named: false,
        units: [Any; 2],
    };
    let log = read_log(bytes, name, &layout, |[subject, barcode]| Ok([whole(subject)?, whole(barcode)?]))?;
    Ok(log.samples.into_iter().map(|sample| sample.value).collect())
}

/// `Landmark_Groundtruth.dat`: subject, position and its standard deviations, in metres.
///
/// # Errors
/// Those of [`read_log`], and a subject that is no whole number.
pub fn read_mrclam_landmarks(bytes: &[u8], name: &str) -> Result<Vec<Landmark>, IoError> {
    let layout = Layout {
        format: "MRCLAM landmarks",
        stamp: Stamp::Every(1.0),
        fields: "subject x y sigma_x sigma_y",
        named: false,
        units: [Any; 5],
    };
    let log = read_log(bytes, name, &layout, |[subject, x, y, sigma_x, sigma_y]| {
        let (position, sigmas) = (Vector2::new(x, y), Vector2::new(sigma_x, sigma_y));
        Ok(Landmark { label: whole(subject)?, position, sigmas })
    })?;
    Ok(log.samples.into_iter().map(|sample| sample.value).collect())
}

/// A number that names something.
fn whole(x: f64) -> Result<u32, IoErrorKind> {
    if x.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&x) {
        #[allow(clippy::cast_sign_loss, reason = "checked")]
        return Ok(x as u32);
    }
    Err(IoErrorKind::NotAnId { found: x.to_string().into() })
}
