//! Where is a camera that sees known points? "Starry night", an assignment of the course AER1513 of T. Barfoot: a stereo camera and an
//! inertial sensor are carried over twenty landmarks; a motion-capture system knows the truth.
//!
//! Filtered, and smoothed with what came later; as a batch with the measured speeds, and as one in continuous time without them, a state a
//! second. All noise is as the log itself states it.
//!
//! Arguments: the folder of the public data, a picture to draw.

mod log;

use std::path::Path;

use boxplus::camera::Stereo;
use boxplus::filter::{Ekf, Gate, Odometry, StereoSighting};
use boxplus::graph::{
    Between, Graph, Interpolated, Kernel, Key, MotionPrior, Noise, Prior, Reprojection, SolveOptions, Values,
    VariableId,
};
use boxplus::io::{IoError, Layout, Stamp, Unit, decompress, read_log};
use boxplus::lie::{LieGroup, Rn, SE3, SO3};
use boxplus::recording::{Course, Fates, Log, Score, Stamped, Track, seconds};
use boxplus::trajectory::Moving;
use boxplus::uncertainty::{Covariance, Gaussian};
use boxplus_cli::draw::Run;
use log::{DEGREES, Outcome, Report, Row};
use nalgebra::{DMatrix, Matrix3, Matrix6, SVector, Vector3, Vector4, Vector6};

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
    let batch = |name: &str, track: &Track<SE3, 6>| {
        let fates = Fates::default();
        let row = Row::new(name, &Score::new(track, &poses, 0.3), 3, fates);
        Row { accepted: seen.len(), ..row }
    };
    let odometry = odometry_batch(&constants, &smoothed, &poses, &speeds, &seen)?;
    let continuous = continuous_batch(&odometry, &speeds, &seen)?;
    let [odometry, continuous] = [("batch, speeds", odometry), ("batch, no speeds, 1 s", continuous)]
        .map(|(name, track)| batch(name, &track));
    Ok(Report {
        title: "Starry night: stereo sightings on SE(3)".to_owned(),
        rows: vec![filter, odometry, continuous, smoother],
        picture,
    })
}

/// A landmark seen by the pair on the body.
fn reprojection(z: &StereoSighting) -> Reprojection<Stereo, 4, 5> {
    let pose_from_camera = z.camera_from_body.inverse();
    Reprojection { camera: z.camera, pose_from_camera, measured: z.measured }
}

/// All poses at once, joined by the measured speeds, from the smoothed ones on; sightings beyond 3σ pull no harder.
fn odometry_batch(
    constants: &Constants,
    start: &[Stamped<Gaussian<SE3, 6>>],
    poses: &[Stamped<SE3>],
    speeds: &[Stamped<Vector6<f64>>],
    seen: &[Stamped<StereoSighting>],
) -> Outcome<Track<SE3, 6>> {
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let first = Prior { mean: poses.first().ok_or("no pose")?.value };
    let near = |pose: &Stamped<SE3>| {
        let k = start.partition_point(|x| x.stamp_ns < pose.stamp_ns).min(start.len() - 1);
        *start[k].value.mean()
    };
    let keys: Vec<_> = poses.iter().map(|pose| values.insert(near(pose))).collect();
    graph.add((keys[0],), first, Noise::from_sigmas(&Vector6::repeat(START))?);
    for (k, pair) in speeds.windows(2).enumerate() {
        let duration = pair[1].seconds_since(pair[0].stamp_ns);
        let step = SE3::exp(&(pair[0].value * duration));
        let noise = Noise::from_sigmas(&(constants.speed_sigmas * duration.sqrt()))?;
        graph.add((keys[k], keys[k + 1]), Between::new(step), noise);
    }
    for z in seen {
        let k = poses.partition_point(|pose| pose.stamp_ns < z.stamp_ns);
        let landmark = values.insert(Rn::new(z.value.landmark));
        values.hold(landmark);
        let noise = Noise::from_covariance(z.value.noise.matrix())?;
        graph.add_robust((keys[k], landmark), reprojection(&z.value), noise, Kernel::Huber(3.0));
    }
    let solution = graph.optimize(&values, &SolveOptions::default())?;
    let ids: Vec<VariableId> = keys.iter().map(|&key| key.into()).collect();
    let covariances = graph.marginals(&solution.values)?.covariances(&ids)?;
    let belief = |((key, covariance), pose): ((&Key<SE3>, &DMatrix<f64>), &Stamped<SE3>)| {
        let covariance = Covariance::new(Matrix6::from_column_slice(covariance.as_slice()))?;
        let mean = *solution.values.get(*key).ok_or("a pose is missing")?;
        Ok(Stamped { stamp_ns: pose.stamp_ns, value: Gaussian::new(mean, covariance) })
    };
    keys.iter().zip(&covariances).zip(poses).map(belief).collect()
}

/// A pose with its velocity.
type State = Moving<SE3, 6, 2, 12>;

/// A state every ten steps, about a second, joined by white noise on acceleration; sightings at any time between two of them. Speeds say
/// how strong that noise is, and another estimate where to start; neither is measured here.
fn continuous_batch(
    start: &[Stamped<Gaussian<SE3, 6>>],
    speeds: &[Stamped<Vector6<f64>>],
    seen: &[Stamped<StereoSighting>],
) -> Outcome<Track<SE3, 6>> {
    let density = Covariance::from_sigmas(&wander(speeds))?;
    let times: Vec<i64> = start.iter().step_by(10).chain(start.last()).map(|x| x.stamp_ns).collect();
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let states = start.iter().step_by(10).chain(start.last());
    let keys: Vec<_> = states.map(|x| values.insert(State::new(*x.value.mean(), Vector6::zeros()))).collect();
    let first = State::new(*start.first().ok_or("no pose")?.value.mean(), Vector6::zeros());
    let sigmas = SVector::<f64, 12>::from_fn(|i, _| if i < 6 { START } else { 1.0 });
    graph.add((keys[0],), Prior { mean: first }, Noise::from_sigmas(&sigmas)?);
    let mut priors = vec![];
    for (k, pair) in times.windows(2).enumerate() {
        let prior = MotionPrior::<SE3, 6, 2, 12>::new(seconds(pair[0], pair[1]), density)?;
        graph.add((keys[k], keys[k + 1]), prior, prior.noise()?);
        priors.push(prior);
    }
    // The interval of a time, and how far into it.
    let place = |stamp_ns: i64| {
        let k = times.partition_point(|&time| time <= stamp_ns).clamp(1, times.len() - 1) - 1;
        (k, seconds(times[k], stamp_ns), seconds(times[k], times[k + 1]))
    };
    for z in seen.iter().filter(|z| z.stamp_ns <= times[times.len() - 1]) {
        let (k, time, duration) = place(z.stamp_ns);
        let landmark = values.insert(Rn::new(z.value.landmark));
        values.hold(landmark);
        let noise = Noise::from_covariance(z.value.noise.matrix())?;
        let between = Interpolated::<_, State, _>::new(reprojection(&z.value), duration, time)?;
        graph.add_robust((keys[k], keys[k + 1], landmark), between, noise, Kernel::Huber(3.0));
    }
    let solution = graph.optimize(&values, &SolveOptions::default())?;
    let mut marginals = graph.marginals(&solution.values)?;
    let mut track = vec![];
    for stamp_ns in start.iter().map(|x| x.stamp_ns) {
        let (k, time, _) = place(stamp_ns);
        let value = priors[k].query(&solution.values, &mut marginals, (keys[k], keys[k + 1]), time)?;
        track.push(Stamped { stamp_ns, value });
    }
    Ok(track)
}

/// √ of the density of the noise on acceleration that changes the measured speeds as they change.
fn wander(speeds: &[Stamped<Vector6<f64>>]) -> Vector6<f64> {
    let change = |pair: &[Stamped<Vector6<f64>>]| {
        let step = pair[1].value - pair[0].value;
        step.component_mul(&step) / pair[1].seconds_since(pair[0].stamp_ns)
    };
    (speeds.windows(2).map(change).sum::<Vector6<f64>>() / (speeds.len() - 1) as f64).map(f64::sqrt)
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
