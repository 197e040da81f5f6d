//! Where is a camera that sees known points? "Starry night", an assignment of the course AER1513 of T. Barfoot: a stereo camera and an
//! inertial sensor are carried over twenty landmarks; a motion-capture system knows the truth.
//!
//! Filtered, and smoothed with what came later. All noise is as the log itself states it.
//!
//! Arguments: the folder of the public data, a picture to draw.

mod log;

use std::path::Path;

use boxplus::camera::Stereo;
use boxplus::filter::{Ekf, Gate, Odometry, StereoSighting};
use boxplus::io::{IoError, Layout, Stamp, Unit, decompress, read_log};
use boxplus::lie::{LieGroup, SE3, SO3};
use boxplus::recording::{Course, Log, Score, Stamped};
use boxplus::uncertainty::{Covariance, Gaussian};
use boxplus_cli::draw::Run;
use log::{DEGREES, Outcome, Report, Row};
use nalgebra::{Matrix3, Vector3, Vector4, Vector6};

/// At the start: metres and radians.
const START: f64 = 0.1;

fn main() -> Outcome<()> {
    log::main(run)
}

/// Filter and smoother; the latter is drawn.
pub(crate) fn run(folder: &Path) -> Outcome<Report> {
    let states = "inertial/starry-night-dataset3-state.csv.gz";
    let constants = Constants::read(&std::fs::read(folder.join(states))?, states)?;
    let poses = log::read_log(folder, states, truth)?;
    let speeds = log::read_log(folder, states, speeds)?;
    let seen = log::read_log(folder, "inertial/starry-night-dataset3-stereo.csv.gz", sightings)?;
    let seen: Vec<_> = seen
        .iter()
        .filter_map(|z| Some(Stamped { stamp_ns: z.stamp_ns, value: constants.sighting(&z.value)? }))
        .collect();

    let first = poses.first().ok_or("no pose")?;
    let start = Gaussian::<SE3, 6>::from_sigmas(first.value, &Vector6::repeat(START))?;
    let speed_noise = Covariance::from_sigmas(&constants.speed_sigmas)?;
    let mut course = Course::smoothing(Ekf::iterated().gated(Gate::at(0.9999)), first.stamp_ns, start);
    course.follow(
        &speeds,
        &seen,
        |speed: &Vector6<f64>, duration| (Odometry { noise: speed_noise * duration }, speed * duration),
        |course, sighting| {
            course.update(sighting);
        },
    )?;

    let smoothed = course.smoothed();
    let scores = [Score::new(course.track(), &poses, 0.3), Score::new(&smoothed, &poses, 0.3)];
    let [filter, smoother] = [("iterated EKF", &scores[0]), ("smoother", &scores[1])]
        .map(|(name, score)| Row::new(name, score, 3, course.fates()));
    let names = [
        ("x of the body [m]", 1.0),
        ("y [m]", 1.0),
        ("z [m]", 1.0),
        ("about x [°]", DEGREES),
        ("about y [°]", DEGREES),
        ("about z [°]", DEGREES),
    ];
    let truth = poses.iter().map(|pose| pose.value.translation()).collect();
    let band = smoothed.iter().map(|belief| log::in_space(&belief.value)).collect();
    let picture = Run {
        title: "Starry night: stereo camera and inertial sensor, smoothed".to_owned(),
        facts: log::facts(&smoother),
        path: Some(log::path(true, band, truth, constants.landmarks.clone())),
        charts: log::charts(&scores[1], first.stamp_ns, names),
    };
    Ok(Report {
        title: "Starry night: stereo sightings on SE(3)".to_owned(),
        rows: vec![filter, smoother],
        picture,
    })
}

/// What the head of the file says.
struct Constants {
    camera: Stereo,
    camera_from_body: SE3,
    pixel_sigmas: Vector4<f64>,
    /// Of the velocity, then of the rate.
    speed_sigmas: Vector6<f64>,
    landmarks: Vec<Vector3<f64>>,
}

impl Constants {
    fn read(bytes: &[u8], name: &str) -> Outcome<Self> {
        let text = decompress(bytes, name)?;
        let text = String::from_utf8_lossy(&text);
        let of = |key: &str| log::constants(&text, key);
        let one = |key: &str| of(key).first().copied().ok_or(format!("{name} does not state {key}"));
        let [rate, speed, pixels, turn, place] = ["w_var", "v_var", "y_var", "C_c_v", "rho_v_c_v"].map(of);
        if [rate.len(), speed.len(), pixels.len(), turn.len(), place.len()] != [3, 3, 4, 9, 3] {
            return Err(format!("{name} does not state all constants").into());
        }
        let camera_from_body = SO3::project(&Matrix3::from_row_slice(&turn))?;
        let body_from_camera = SE3::new(camera_from_body.inverse(), Vector3::from_row_slice(&place));
        let landmarks = (1..).map(|j| of(&format!("landmark {j}: rho_i_pj_i"))).take_while(|l| l.len() == 3);
        Ok(Self {
            camera: Stereo {
                focal: [one("fu")?, one("fv")?],
                centre: [one("cu")?, one("cv")?],
                baseline: one("b")?,
            },
            camera_from_body: body_from_camera.inverse(),
            pixel_sigmas: Vector4::from_row_slice(&pixels).map(f64::sqrt),
            speed_sigmas: Vector6::from_iterator(speed.into_iter().chain(rate)).map(f64::sqrt),
            landmarks: landmarks.map(|l| Vector3::from_row_slice(&l)).collect(),
        })
    }

    /// Landmark number and pixels as a measurement; `None` for a landmark that nobody knows.
    fn sighting(&self, [j, pixels @ ..]: &[f64; 5]) -> Option<StereoSighting> {
        let landmark = self.landmarks.iter().zip(1..).find(|(_, number)| f64::from(*number) == *j)?.0;
        let noise = Covariance::from_sigmas(&self.pixel_sigmas).ok()?;
        Some(StereoSighting {
            camera: self.camera,
            camera_from_body: self.camera_from_body,
            landmark: *landmark,
            measured: Vector4::from_row_slice(pixels),
            noise,
        })
    }
}

fn truth(bytes: &[u8], name: &str) -> Result<Log<SE3>, IoError> {
    let layout = Layout {
        format: "starry-night states",
        stamp: Stamp::Seconds,
        fields: "t theta_vk_i_1 theta_vk_i_2 theta_vk_i_3 r_i_vk_i_1 r_i_vk_i_2 r_i_vk_i_3",
        named: true,
        units: [Unit::Angle, Unit::Angle, Unit::Angle, Unit::Any, Unit::Any, Unit::Any],
    };
    read_log(bytes, name, &layout, |[a, b, c, x, y, z]| {
        Ok(SE3::new(SO3::exp(&Vector3::new(a, b, c)), Vector3::new(x, y, z)))
    })
}

/// Velocity and rate in the frame of the body.
fn speeds(bytes: &[u8], name: &str) -> Result<Log<Vector6<f64>>, IoError> {
    let layout = Layout {
        format: "starry-night states",
        stamp: Stamp::Seconds,
        fields: "t v_vk_vk_i_1 v_vk_vk_i_2 v_vk_vk_i_3 w_vk_vk_i_1 w_vk_vk_i_2 w_vk_vk_i_3",
        named: true,
        units: [Unit::Any, Unit::Any, Unit::Any, Unit::Rate, Unit::Rate, Unit::Rate],
    };
    read_log(bytes, name, &layout, |row| Ok(Vector6::from_row_slice(&row)))
}

fn sightings(bytes: &[u8], name: &str) -> Result<Log<[f64; 5]>, IoError> {
    let layout = Layout {
        format: "starry-night sightings",
        stamp: Stamp::Seconds,
        fields: "t j u_left v_left u_right v_right",
        named: true,
        units: [Unit::Any; 5],
    };
    read_log(bytes, name, &layout, Ok)
}
