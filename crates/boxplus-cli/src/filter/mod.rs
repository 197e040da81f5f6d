//! `boxplus filter`: where was it, by the logs of its sensors, and how sure is that?

mod config;
mod models;
mod track;

use std::fmt::Write;
use std::path::PathBuf;
use std::time::Instant;

use boxplus::io::write_tum;
use boxplus::recording::Fates;
use clap::{Args, ValueEnum, ValueHint};
use serde_json::{Value, json};

use crate::draw::Run;
use crate::error::{Error, Outcome};
use crate::output::{Console, DIM, STRONG, document};
use crate::plot::{Picture, save_svg};
use crate::text::{count, duration, significant};
use models::Files;
use track::Filtered;

pub const EXAMPLES: &str = "\
Examples:
  boxplus filter beacons Robot1_Odometry.dat Robot1_Measurement.dat Landmark_Groundtruth.dat Barcodes.dat \\
      --truth Robot1_Groundtruth.dat --plot robot1.svg
  boxplus filter gnss imu0.csv positions.txt --config sensor.toml -o trajectory.tum --smooth

Models and their LOGs, in this order, plain or gzip:
  beacons   ODOMETRY MEASUREMENTS LANDMARKS BARCODES   a vehicle in the plane that counts its wheels' turns and sees beacons at known
                                                       places, as MRCLAM has it; truth: its ground truth
  gnss      IMU POSITIONS                              an inertial sensor (EuRoC's .csv, else KITTI's text) and `Time,X,Y,Z` in metres;
                                                       truth: EuRoC's states as .csv, else TUM

The configuration is TOML; every line may be left out, and these are what is assumed then:
  # beacons                                  # gnss
  drift = [0.03, 0.03, 0.06]                 gyroscope = 1.75e-3          # white noise, rad/√s
  sighting = [0.4, 0.06]                     accelerometer = 0.1          # m/s/√s
  start_sigmas = [0.5, 0.5, 0.5]             gyroscope_bias = 2e-5        # walks, rad/s/√s
  gate = 0.9999                              accelerometer_bias = 3e-3    # m/s²/√s
  # start = [0, 0, 0], else from the truth   position = [0.1, 0.1, 0.1]
                                             start_sigmas = [0.1, 0.3, 2.0, 0.01, 0.2]
                                             gate = 1.0
                                             # heading_deg = 0, else towards the second position
drift is the σ of odometry after a second (m ahead, m sideways, rad), sighting that of distance and direction (m, rad), position that
of a position (m). start_sigmas are of x, y and heading; or of position, rotation, velocity and both biases. gate is the share of good
measurements that is believed; 1 believes all.

The filter is the iterated extended one, with reset. A NIS far from 1 says that the noise is not as stated. Exit code 3 where a log or the
configuration cannot be read, 4 where the logs do not go together.";

/// Options of `filter`.
#[derive(Args, Debug)]
pub struct Options {
    /// What moves, and what is measured.
    #[arg(value_name = "MODEL")]
    pub model: Model,
    /// The logs of the sensors, in the order of the model.
    #[arg(value_name = "LOG", required = true, value_hint = ValueHint::FilePath)]
    pub logs: Vec<PathBuf>,
    /// How noisy the sensors are and where it starts, in TOML.
    #[arg(long, value_name = "FILE.toml", value_hint = ValueHint::FilePath)]
    pub config: Option<PathBuf>,
    /// Where it truly was: errors are told.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub truth: Option<PathBuf>,
    /// Tell the past again with all measurements.
    #[arg(long)]
    pub smooth: bool,
    /// Write the trajectory here, in TUM's format; `-` is standard output.
    #[arg(short, long, value_name = "TRAJECTORY", value_hint = ValueHint::FilePath)]
    pub output: Option<PathBuf>,
    /// Draw the path with its 3σ band, and the errors where the truth is known, as .svg or .png.
    #[arg(long, value_name = "PICTURE", value_hint = ValueHint::FilePath)]
    pub plot: Option<PathBuf>,
}

/// The ready models.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Model {
    /// Odometry in the plane, distances and directions of beacons
    Beacons,
    /// An inertial sensor with biases, positions
    Gnss,
}

/// Reads, filters, reports and writes.
pub fn run(options: &Options, console: Console) -> Result<Outcome, Error> {
    let started = Instant::now();
    let picture = options.plot.as_deref().map(Picture::of).transpose()?;
    let console = console.beside(options.output.as_deref())?;
    let Options { logs, truth, config, smooth, .. } = options;
    let files = Files { logs, truth: truth.as_deref(), smooth: *smooth, console };
    let config = config.as_deref();
    let filtered = match options.model {
        Model::Beacons => {
            models::beacons(&files, &config::read(config, "drift, sighting, start, start_sigmas and gate")?)
        }
        Model::Gnss => models::gnss(
            &files,
            &config::read(
                config,
                "gyroscope, accelerometer, their biases, position, heading_deg, start_sigmas and gate",
            )?,
        ),
    }?;
    if filtered.fates == Fates::default() {
        console.warn("no measurement falls into the time of the first log: this is dead reckoning");
    }
    let told = Told { options, filtered: &filtered, seconds: started.elapsed().as_secs_f64() };
    if console.is_json() {
        document(&told.document())?;
    } else {
        console.say(told.screen().trim_end())?;
    }
    if let Some(path) = &options.output {
        console.write(path, write_tum(&filtered.poses).as_bytes())?;
    }
    if let Some((path, picture)) = options.plot.as_deref().zip(picture) {
        save_svg(&told.drawing().svg(), picture, path, console)?;
    }
    Ok(Outcome::Done)
}

/// A track and where it comes from.
struct Told<'a> {
    options: &'a Options,
    filtered: &'a Filtered,
    seconds: f64,
}

impl Told<'_> {
    fn model(&self) -> String {
        format!("{:?}", self.options.model).to_lowercase()
    }

    /// The errors, or, where nobody knows the truth, what is claimed.
    fn facts(&self) -> String {
        match &self.filtered.score {
            Some(score) => format!(
                "position {} m, rotation {}° rms · {:.1} % of errors inside 3σ",
                significant(score.position, 3),
                significant(score.rotation_deg, 3),
                100.0 * score.inside_three_sigma
            ),
            None => self.fates(),
        }
    }

    fn fates(&self) -> String {
        let fates = self.filtered.fates;
        format!(
            "{} believed, {} gated, {} refused; NIS {} of 1",
            count(fates.accepted, "measurement", "measurements"),
            fates.gated,
            fates.refused,
            significant(fates.mean_nis(), 3)
        )
    }

    fn screen(&self) -> String {
        let told = if self.options.smooth { "smoothed" } else { "filtered" };
        let mut out = format!("{STRONG}{}{STRONG:#}  {}\n", self.model(), self.fates());
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "{DIM}{} {told}, {} of driving, {}{DIM:#}",
            count(self.filtered.poses.len(), "pose", "poses"),
            duration(self.filtered.seconds()),
            duration(self.seconds)
        );
        if let Some(last) = self.filtered.poses.last() {
            let p = last.value.translation();
            let [x, y, z] = [p.x, p.y, p.z].map(|x| significant(x, 6));
            let sigmas =
                self.filtered.last.iter().map(|(name, sigma)| format!("{name} {}", significant(*sigma, 3)));
            let _ = writeln!(out, "\nat last  {x} {y} {z} m");
            let _ = writeln!(out, "σ        {}", sigmas.collect::<Vec<_>>().join(", "));
        }
        if let Some(score) = &self.filtered.score {
            let _ = writeln!(
                out,
                "\nbeside the truth  {}; NEES {} of 1",
                self.facts(),
                significant(score.nees, 3)
            );
        }
        out
    }

    fn document(&self) -> Value {
        let Filtered { poses, last, fates, score, .. } = self.filtered;
        let names: Vec<_> = self.options.logs.iter().map(|path| path.display().to_string()).collect();
        json!({
            "format": "boxplus.filter",
            "version": 1,
            "model": self.model(),
            "logs": names,
            "smoothed": self.options.smooth,
            "poses": poses.len(),
            "duration": self.filtered.seconds(),
            "seconds": self.seconds,
            "measurements": {
                "accepted": fates.accepted, "gated": fates.gated, "refused": fates.refused, "nis": fates.mean_nis(),
            },
            "last": poses.last().map(|pose| json!({
                "stamp_ns": pose.stamp_ns,
                "position": pose.value.translation().as_slice(),
                "quaternion_xyzw": pose.value.rotation().quaternion_xyzw(),
                "sigmas": last.iter().map(|(name, sigma)| json!({ "of": name, "sigma": sigma })).collect::<Vec<_>>(),
            })),
            "score": score,
        })
    }

    fn drawing(&self) -> Run {
        let (path, charts) = self.filtered.picture.clone();
        let name = |path: &PathBuf| path.file_name().map(|name| name.to_string_lossy().into_owned());
        let log = self.options.logs.first().and_then(name).unwrap_or_default();
        let log = log.trim_end_matches(".gz").rsplit_once('.').map_or(log.as_str(), |(stem, _)| stem);
        Run { title: format!("{log}: {}", self.model()), facts: self.facts(), path: Some(path), charts }
    }
}
