//! Which way is up, and which way is north? Two logs of a hand-held inertial sensor with a magnetometer and an optical reference: BROAD trial
//! 2, Laidig et al. (2021), and RepoIMU T-stick 2, trial 1, Szczęsna et al. (2016).
//!
//! An accelerometer shows gravity only while the hand does not accelerate: the more its length differs from 9.81 m/s², the less it is
//! believed. The same for the magnetometer and the length of the field where the sensor was at rest.
//!
//! Arguments: the folder of the public data, a picture to draw.

mod log;

use std::path::Path;

use boxplus::filter::{Attitude, Ekf, Gyroscope, Part, STANDARD_GRAVITY, VectorSighting};
use boxplus::io::{IoError, IoErrorKind, Layout, Stamp, Unit, read_log};
use boxplus::lie::{Action, LieGroup, Rn, SO3};
use boxplus::recording::{Course, Log, Score, Stamped, part_of};
use boxplus::uncertainty::{Covariance, Gaussian};
use boxplus_cli::draw::Run;
use log::{DEGREES, Outcome, Report, Row};
use nalgebra::{Vector3, vector};

/// Densities that hold the scale errors of a moving sensor, too: more than its data sheet says.
const GYROSCOPE: Gyroscope = Gyroscope { noise: 5e-3, bias_walk: 1e-4 };
/// A second at the beginning, when the sensor is at rest.
const REST: f64 = 1.0;

/// What the sensor shows: rad/s, m/s², and the magnetic field in any unit.
#[derive(Clone, Copy, Debug)]
struct Marg {
    gyroscope: Vector3<f64>,
    accelerometer: Vector3<f64>,
    magnetometer: Vector3<f64>,
}

fn main() -> Outcome<()> {
    log::main(run)
}

/// Both logs; BROAD is drawn.
pub(crate) fn run(folder: &Path) -> Outcome<Report> {
    let file = "inertial/repoimu-TStick_Test02_Trial1.csv.gz";
    let truth = log::read_log(folder, file, repoimu_truth)?;
    let (repoimu, _) = estimate("RepoIMU T-stick 2-1", &log::read_log(folder, file, repoimu)?, &truth, true)?;
    let file = "inertial/broad-02_undisturbed_slow_rotation_B.csv.gz";
    let truth = log::read_log(folder, file, broad_truth)?;
    let (broad, picture) = estimate("BROAD 2", &log::read_log(folder, file, broad)?, &truth, false)?;
    let title = "Attitude from gyroscope, accelerometer and magnetometer".to_owned();
    Ok(Report { title, rows: vec![broad, repoimu], picture })
}

/// `at_start`: the reference's world is the sensor's frame at the start; else z is up and y is magnetic north.
fn estimate(
    name: &str,
    marg: &[Stamped<Marg>],
    truth: &[Stamped<SO3>],
    at_start: bool,
) -> Outcome<(Row, Run)> {
    let start_ns = marg.first().ok_or("no sample")?.stamp_ns;
    let still: Vec<_> =
        marg.iter().take_while(|m| m.seconds_since(start_ns) < REST).map(|m| m.value).collect();
    let mean = |f: fn(&Marg) -> Vector3<f64>| still.iter().map(f).sum::<Vector3<f64>>() / still.len() as f64;
    let (force, field) = (mean(|m| m.accelerometer), mean(|m| m.magnetometer));
    let north_of_start = SO3::from_direction_pairs([&Vector3::z(), &Vector3::y()], [&force, &field])?;
    let rotation = if at_start { SO3::identity() } else { north_of_start };
    let up = rotation.act_direction(&force).normalize() * STANDARD_GRAVITY;
    let world_field = rotation.act_direction(&field);

    let there = Attitude { rotation, gyroscope_bias: Rn::new(Vector3::zeros()) };
    let start = Gaussian::<Attitude, 6>::from_sigmas(there, &vector![0.05, 0.05, 0.1, 0.02, 0.02, 0.02])?;
    let mut course = Course::forward(Ekf::default(), start_ns, start);
    course.follow(
        marg,
        marg,
        |m: &Marg, duration| (GYROSCOPE, (m.gyroscope, duration)),
        |course, m| {
            course.update(&sighting(&up, &m.accelerometer, 0.1));
            course.update(&sighting(&world_field, &m.magnetometer, 0.15));
        },
    )?;

    let rotations = part_of(course.track(), |x| x.rotation, 0);
    let score = Score::new(&rotations, truth, 0.02);
    let row = Row::new(name, &score, 0, course.fates());
    let picture = Run {
        title: format!("{name}: attitude"),
        facts: log::facts(&row),
        path: None,
        charts: log::charts(
            &score,
            start_ns,
            [("about x [°]", DEGREES), ("about y [°]", DEGREES), ("about z [°]", DEGREES)],
        ),
    };
    Ok((row, picture))
}

/// A vector of the world as the body sees it. `noise` is a part of its length; what the length differs comes on top, five times.
fn sighting(
    world: &Vector3<f64>,
    body: &Vector3<f64>,
    noise: f64,
) -> Part<VectorSighting<3>, fn(&Attitude) -> SO3, 3, 6> {
    let (length, reference) = (body.norm(), world.norm());
    let sigma = noise * reference + 5.0 * (length - reference).abs();
    Part {
        measurement: VectorSighting { reference: *world, measured: *body, noise: Covariance::unit() * sigma },
        of: |x| x.rotation,
        block: Attitude::BLOCKS.rotation,
    }
}

fn broad(bytes: &[u8], name: &str) -> Result<Log<Marg>, IoError> {
    let fields = "gyr_x gyr_y gyr_z acc_x acc_y acc_z mag_x mag_y mag_z";
    read_log(bytes, name, &broad_layout(fields, MARG), |row| Ok(marg(&row)))
}

fn broad_truth(bytes: &[u8], name: &str) -> Result<Log<SO3>, IoError> {
    read_log(bytes, name, &broad_layout("opt_qw opt_qx opt_qy opt_qz", [Unit::Quaternion; 4]), quaternion)
}

/// Its samples carry no time, but a fixed rate.
fn broad_layout<const N: usize>(fields: &'static str, units: [Unit; N]) -> Layout<N> {
    Layout { format: "BROAD data", stamp: Stamp::Every(7.0 / 2000.0), fields, named: true, units }
}

fn repoimu(bytes: &[u8], name: &str) -> Result<Log<Marg>, IoError> {
    repoimu_rows(bytes, name, |row| {
        let [.., ax, ay, az, gx, gy, gz, mx, my, mz] = row;
        Ok(marg(&[gx, gy, gz, ax, ay, az, mx, my, mz]))
    })
}

fn repoimu_truth(bytes: &[u8], name: &str) -> Result<Log<SO3>, IoError> {
    repoimu_rows(bytes, name, |[w, x, y, z, ..]| quaternion([w, x, y, z]))
}

fn repoimu_rows<T>(
    bytes: &[u8],
    name: &str,
    make: impl FnMut([f64; 13]) -> Result<T, IoErrorKind>,
) -> Result<Log<T>, IoError> {
    use Unit::{Any, Force, Quaternion, Rate};
    let layout = Layout {
        format: "RepoIMU data",
        stamp: Stamp::Seconds,
        fields: "time qw qx qy qz ax ay az gx gy gz mx my mz",
        named: false,
        units: [
            Quaternion, Quaternion, Quaternion, Quaternion, Force, Force, Force, Rate, Rate, Rate, Any, Any,
            Any,
        ],
    };
    read_log(bytes, name, &layout, make)
}

const MARG: [Unit; 9] = {
    use Unit::{Any, Force, Rate};
    [Rate, Rate, Rate, Force, Force, Force, Any, Any, Any]
};

fn marg(row: &[f64; 9]) -> Marg {
    let vector = |i: usize| Vector3::new(row[i], row[i + 1], row[i + 2]);
    Marg { gyroscope: vector(0), accelerometer: vector(3), magnetometer: vector(6) }
}

fn quaternion(wxyz: [f64; 4]) -> Result<SO3, IoErrorKind> {
    SO3::from_wxyz(wxyz).map_err(|_| IoErrorKind::ZeroQuaternion)
}
