//! Files of logs: trajectories, inertial sensors, robots among landmarks.

mod mrclam;
mod stamp;
mod table;

pub use mrclam::{
    read_mrclam_barcodes, read_mrclam_groundtruth, read_mrclam_landmarks, read_mrclam_measurements,
    read_mrclam_odometry,
};
pub use stamp::Stamp;
pub use table::{Layout, Unit, read_log};

use super::elements::rotation3;
use super::error::{IoError, IoErrorKind};
use crate::lie::{SE3, SE23, SO3};
use crate::recording::{ImuReading, Log, NavigationState, Stamped};
use core::fmt::Write as _;
use nalgebra::Vector3;
use table::Unit::{Any, Force, Quaternion, Rate};

/// The rotation of a quaternion of about unit norm; one of unit norm keeps every bit.
fn rotation(xyzw: [f64; 4]) -> Result<SO3, IoErrorKind> {
    rotation3(xyzw).map(|(rotation, _)| rotation).map_err(|_| IoErrorKind::ZeroQuaternion)
}

/// Three numbers from place `i` on.
fn vector(row: &[f64], i: usize) -> Vector3<f64> {
    Vector3::from_fn(|k, _| row[i + k])
}

/// A TUM trajectory: `time tx ty tz qx qy qz qw` with the time in seconds, world_from_body.
///
/// ```
/// use boxplus::io::{read_tum, write_tum};
/// let text = "1403715274.302140000 1 2 3 0 0 0 1\n1403715274.307140000 1.5 2 3 0 0 1 0\n";
/// let log = read_tum(text.as_bytes(), "truth.tum")?;
/// assert_eq!(log.samples[1].stamp_ns, 1_403_715_274_307_140_000); // to the last digit
/// assert_eq!(write_tum(&log.samples), text);
/// # Ok::<(), boxplus::io::IoError>(())
/// ```
///
/// # Errors
/// Those of [`read_log`], and a quaternion that is zero.
pub fn read_tum(bytes: &[u8], name: &str) -> Result<Log<SE3>, IoError> {
    let layout = Layout {
        format: "a TUM trajectory",
        stamp: Stamp::Seconds,
        fields: "time tx ty tz qx qy qz qw",
        named: false,
        units: [Any, Any, Any, Quaternion, Quaternion, Quaternion, Quaternion],
    };
    read_log(bytes, name, &layout, |row| {
        let [_, _, _, x, y, z, w] = row;
        Ok(SE3::new(rotation([x, y, z, w])?, vector(&row, 0)))
    })
}

/// A trajectory as TUM text. Numbers are the shortest decimals that read back as the same float.
pub fn write_tum(poses: &[Stamped<SE3>]) -> String {
    let mut text = String::new();
    for Stamped { stamp_ns, value } in poses {
        let (p, q) = (value.translation(), value.rotation().quaternion_xyzw());
        let numbers = [p.x, p.y, p.z, q[0], q[1], q[2], q[3]];
        text.push_str(&stamp::print(*stamp_ns));
        for x in numbers {
            // Writing into a String cannot fail.
            let _ = write!(text, " {x}");
        }
        text.push('\n');
    }
    text
}

/// Readings of an inertial sensor in EuRoC's (ASL's) csv: nanoseconds, rates in rad/s, specific forces in m/s².
///
/// # Errors
/// Those of [`read_log`].
pub fn read_euroc_imu(bytes: &[u8], name: &str) -> Result<Log<ImuReading>, IoError> {
    let layout = Layout {
        format: "EuRoC IMU data",
        stamp: Stamp::Nanoseconds,
        fields: "timestamp w_x w_y w_z a_x a_y a_z",
        named: false,
        units: [Rate, Rate, Rate, Force, Force, Force],
    };
    read_log(bytes, name, &layout, |row| {
        Ok(ImuReading { gyroscope: vector(&row, 0), accelerometer: vector(&row, 3) })
    })
}

/// States in EuRoC's (ASL's) csv: nanoseconds, position, quaternion (w, x, y, z), velocity, biases of gyroscope and accelerometer.
///
/// # Errors
/// Those of [`read_log`], and a quaternion that is zero.
pub fn read_euroc_states(bytes: &[u8], name: &str) -> Result<Log<NavigationState>, IoError> {
    let layout = Layout {
        format: "EuRoC states",
        stamp: Stamp::Nanoseconds,
        fields: "timestamp p_x p_y p_z q_w q_x q_y q_z v_x v_y v_z bw_x bw_y bw_z ba_x ba_y ba_z",
        named: false,
        units: [
            Any, Any, Any, Quaternion, Quaternion, Quaternion, Quaternion, Any, Any, Any, Any, Any, Any, Any,
            Any, Any,
        ],
    };
    read_log(bytes, name, &layout, |row| {
        let turned = rotation([row[4], row[5], row[6], row[3]])?;
        Ok(NavigationState {
            motion: SE23::new(turned, vector(&row, 0), vector(&row, 7)),
            gyroscope_bias: vector(&row, 10),
            accelerometer_bias: vector(&row, 13),
        })
    })
}

/// Readings of KITTI's inertial sensor as GTSAM's examples have them: `Time dt accelX accelY accelZ omegaX omegaY omegaZ`, named in
/// the first line. `dt` is not read: the times say the same, and more exactly.
///
/// # Errors
/// Those of [`read_log`].
pub fn read_kitti_imu(bytes: &[u8], name: &str) -> Result<Log<ImuReading>, IoError> {
    let layout = Layout {
        format: "KITTI IMU data",
        stamp: Stamp::Seconds,
        fields: "Time accelX accelY accelZ omegaX omegaY omegaZ",
        named: true,
        units: [Force, Force, Force, Rate, Rate, Rate],
    };
    read_log(bytes, name, &layout, |row| {
        Ok(ImuReading { gyroscope: vector(&row, 3), accelerometer: vector(&row, 0) })
    })
}

/// Positions in metres of a local frame, `Time,X,Y,Z`, named in the first line: KITTI's GNSS as GTSAM's examples have it.
///
/// # Errors
/// Those of [`read_log`].
pub fn read_positions(bytes: &[u8], name: &str) -> Result<Log<Vector3<f64>>, IoError> {
    let layout = Layout {
        format: "positions",
        stamp: Stamp::Seconds,
        fields: "Time X Y Z",
        named: true,
        units: [Any; 3],
    };
    read_log(bytes, name, &layout, |row| Ok(vector(&row, 0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lie::LieGroup;

    #[test]
    fn a_trajectory_reads_back_as_written() {
        let tau = nalgebra::vector![1.0, -2.0, 3.0, 0.3, -0.2, 0.1];
        let poses: Vec<_> = (0..50_i64)
            .map(|i| Stamped { stamp_ns: i * 1_234_567_891 - 7, value: SE3::exp(&(tau * i as f64)) })
            .collect();
        let read = read_tum(write_tum(&poses).as_bytes(), "").map(|log| log.samples);
        for (read, pose) in read.into_iter().flatten().zip(&poses) {
            assert_eq!(read.stamp_ns, pose.stamp_ns);
            assert!(read.value.rminus(&pose.value).norm() < 1e-15);
        }
    }
}
