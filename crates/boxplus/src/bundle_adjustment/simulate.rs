//! Bundles whose truth is known.
//!
//! Points lie on walls and are seen by the nearest views that face them, at least two:
//!
//! ```text
//! z = π(X_v⁻¹·l_p) + ε      ε ~ N(0, σ²I)      within the image of 1280 × 960 pixels, f ≈ 800, k₁ ≈ −0.05, k₂ ≈ 0.01
//! ```
//!
//! The start is the truth with noise on poses, points and focal lengths, as a reconstruction has it before its adjustment. The same options
//! give the same bundle.
//!
//! ```
//! use boxplus::bundle_adjustment::simulate::{Options, World};
//! let world = World::Street.simulate(&Options { views: 20, points: 500, seed: 7, ..Options::default() })?;
//! assert_eq!((world.truth.views.len(), world.truth.points.len()), (20, 500));
//! let noise = (2.0 * world.truth.cost() / (2.0 * world.truth.observations.len() as f64)).sqrt();
//! assert!((noise - 0.5).abs() < 0.02 && world.bundle.cost() > 100.0 * world.truth.cost());
//! # Ok::<(), boxplus::bundle_adjustment::simulate::OptionsError>(())
//! ```

use core::f64::consts::TAU;
use core::{fmt, str::FromStr};

use nalgebra::{Matrix3, Vector2, Vector3, Vector6, vector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{BalView, Bundle, Line, Observation};
use crate::camera::{Camera, Snavely, View};
use crate::lie::{Action, LieGroup, SE3, SO3};

/// A world to take pictures of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum World {
    /// A statue, and a ring of views around it.
    Ring,
    /// Two rows of houses, and a drive between them.
    Street,
    /// Blocks of houses, and a drive along all streets around them.
    City,
}

impl World {
    /// Every world.
    pub const ALL: [Self; 3] = [Self::Ring, Self::Street, Self::City];

    /// Its name, as [`FromStr`] takes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ring => "ring",
            Self::Street => "street",
            Self::City => "city",
        }
    }

    /// Makes a bundle.
    ///
    /// # Errors
    /// [`OptionsError`], where an option is out of its range.
    pub fn simulate(self, options: &Options) -> Result<Simulated, OptionsError> {
        options.check()?;
        let rng = &mut ChaCha8Rng::seed_from_u64(options.seed);
        let scene = match self {
            Self::Ring => ring(options),
            Self::Street => street(options),
            Self::City => city(options),
        };
        Ok(photograph(&scene, options, rng))
    }
}

impl fmt::Display for World {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is none of [`World::ALL`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no such world; choose ring, street or city")]
pub struct UnknownWorld;

impl FromStr for World {
    type Err = UnknownWorld;

    fn from_str(name: &str) -> Result<Self, UnknownWorld> {
        Self::ALL.into_iter().find(|world| world.name() == name).ok_or(UnknownWorld)
    }
}

/// What to simulate.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// The number of views, at least 2.
    pub views: usize,
    /// The number of points, at least 1.
    pub points: usize,
    /// Most views that see one point, at least 2: the nearest that face it.
    pub track: usize,
    /// Start of the random numbers.
    pub seed: u64,
    /// σ, the standard deviation of u and of v, pixels, ≥ 0.
    pub sigma: f64,
    /// The chance, 0…1, that an observation is of anywhere in the image.
    pub outliers: f64,
    /// How far the start is from the truth, ≥ 0: 1 is 5 cm and 0.3° a pose, 15 cm a point, 1 % a focal length.
    pub start: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { views: 60, points: 3000, track: 8, seed: 0, sigma: 0.5, outliers: 0.0, start: 1.0 }
    }
}

impl Options {
    fn check(&self) -> Result<(), OptionsError> {
        let counts = [("views", self.views, 2), ("points", self.points, 1), ("track", self.track, 2)];
        if let Some(&(option, given, least)) = counts.iter().find(|(_, given, least)| given < least) {
            return Err(OptionsError::TooFew { option, given, least });
        }
        let numbers = [
            ("sigma", self.sigma, f64::MAX),
            ("outliers", self.outliers, 1.0),
            ("start", self.start, f64::MAX),
        ];
        match numbers.iter().find(|(_, given, most)| !(0.0..=*most).contains(given)) {
            Some(&(option, given, most)) => Err(OptionsError::OutOfRange { option, given, most }),
            None => Ok(()),
        }
    }
}

/// Why a world cannot be simulated.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OptionsError {
    /// Too small a number.
    #[error("{option} must be at least {least}, not {given}")]
    TooFew {
        /// Of what.
        option: &'static str,
        /// What was given.
        given: usize,
        /// What is needed.
        least: usize,
    },
    /// A number that is negative, too large or none.
    #[error("{option} must be from 0 to {most}, not {given}")]
    OutOfRange {
        /// Of what.
        option: &'static str,
        /// What was given.
        given: f64,
        /// What is possible.
        most: f64,
    },
}

/// A bundle and its truth.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulated {
    /// What was seen, with a start.
    pub bundle: Bundle,
    /// The same with true views and points.
    pub truth: Bundle,
}

/// Half the image, in pixels.
const HALF: [f64; 2] = [640.0, 480.0];
/// Draws of a point before it is kept though fewer than two views see it.
const DRAWS: usize = 1000;

/// A point of a wall and the normal there.
type Place = (Vector3<f64>, Vector3<f64>);

/// Where pictures are taken, and how a point of a wall is drawn.
struct Scene {
    poses: Vec<SE3>,
    wall: Box<dyn Fn(&mut ChaCha8Rng) -> Place>,
}

/// The pose at `place` of a camera that looks along −z of its own frame towards `ahead`, the sky upwards.
fn looking(place: Vector3<f64>, ahead: &Vector3<f64>) -> SE3 {
    let back = -ahead.normalize();
    let right = Vector3::z().cross(&back).normalize();
    let axes = Matrix3::from_columns(&[right, back.cross(&right), back]);
    // The columns are orthonormal; `ahead` never points to the sky.
    SE3::new(SO3::project(&axes).unwrap_or_else(|_| SO3::identity()), place)
}

/// A bumpy ball of 2 m and views 6 m around it.
fn ring(options: &Options) -> Scene {
    let poses = (0..options.views).map(|i| {
        let (sin, cos) = (TAU * i as f64 / options.views as f64).sin_cos();
        let place = vector![6.0 * cos, 6.0 * sin, 1.0 + (7.0 * sin).sin()];
        looking(place, &-place)
    });
    let wall = move |rng: &mut ChaCha8Rng| {
        let z: f64 = rng.random_range(-0.9..0.9);
        let (sin, cos) = rng.random_range(0.0..TAU).sin_cos();
        let normal = vector![cos * (1.0 - z * z).sqrt(), sin * (1.0 - z * z).sqrt(), z];
        (normal * (2.0 + 0.2 * (9.0 * z + 4.0 * sin).sin()), normal)
    };
    Scene { poses: poses.collect(), wall: Box::new(wall) }
}

/// Houses on both sides of 2 m a view, 8 m from the middle, and views that look ahead to either side by turns.
fn street(options: &Options) -> Scene {
    let length = 2.0 * options.views as f64;
    let poses = (0..options.views).map(|i| {
        let side = if i % 2 == 0 { 1.0 } else { -1.0 };
        looking(vector![2.0 * i as f64, 0.2 * (0.3 * i as f64).sin(), 1.7], &vector![1.0, 0.35 * side, 0.1])
    });
    let wall = move |rng: &mut ChaCha8Rng| {
        let side = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        let depth = 8.0 + rng.random_range(0.0..1.0);
        let place = vector![rng.random_range(2.0..length + 14.0), side * depth, rng.random_range(0.0..9.0)];
        (place, vector![0.0, -side, 0.0])
    };
    Scene { poses: poses.collect(), wall: Box::new(wall) }
}

/// Blocks of 30 m, streets of 16 m with houses also beyond their ends, and a drive along every street of one direction, then of the other.
fn city(options: &Options) -> Scene {
    const PITCH: f64 = 46.0;
    let streets = ((options.views as f64).sqrt() / 3.0).ceil().max(2.0);
    let (extent, lanes) = ((streets - 1.0) * PITCH, 2.0 * streets);
    let pace = lanes * extent / options.views as f64;
    let poses = (0..options.views).map(|i| {
        let travelled = (i as f64 + 0.5) * pace;
        let (lane, along) = ((travelled / extent).floor(), travelled % extent);
        let side = if i % 2 == 0 { 0.35 } else { -0.35 };
        let across = (lane % streets) * PITCH;
        if lane < streets {
            looking(vector![along, across, 1.7], &vector![1.0, side, 0.1])
        } else {
            looking(vector![across, along, 1.7], &vector![side, 1.0, 0.1])
        }
    });
    let wall = move |rng: &mut ChaCha8Rng| {
        let corner = [0, 1].map(|_| rng.random_range(-1.0..streets).floor() * PITCH + 8.0);
        let (along, height) = (rng.random_range(0.0..30.0), rng.random_range(0.0..9.0));
        let (far, swapped) = (rng.random_bool(0.5), rng.random_bool(0.5));
        let (out, sign) = if far { (30.0, 1.0) } else { (0.0, -1.0) };
        let place = vector![corner[0] + along, corner[1] + out, height];
        let normal = vector![0.0, sign, 0.0];
        if swapped {
            (vector![corner[0] + out, corner[1] + along, height], normal.yxz())
        } else {
            (place, normal)
        }
    };
    Scene { poses: poses.collect(), wall: Box::new(wall) }
}

/// Pictures of a scene: what every point's nearest views see of it, with noise, and a start beside the truth.
fn photograph(scene: &Scene, options: &Options, rng: &mut ChaCha8Rng) -> Simulated {
    let views: Vec<BalView> = scene
        .poses
        .iter()
        .map(|&world_from_camera| {
            let focal = 800.0 * (1.0 + 0.02 * normal(rng));
            let distortion = [-0.05 + 0.005 * normal(rng), 0.01 + 0.002 * normal(rng)];
            View { world_from_camera, camera: Snavely { focal, distortion } }
        })
        .collect();
    let (mut points, mut observations) = (vec![], vec![]);
    for point in 0..options.points as u32 {
        let (place, seen) = landmark(scene, &views, options.track, rng);
        for (view, pixel) in seen {
            let noise = options.sigma * vector![normal(rng), normal(rng)];
            let anywhere = HALF.map(|half| rng.random_range(-half..half));
            let pixel = if rng.random_bool(options.outliers) { anywhere.into() } else { pixel + noise };
            observations.push(Observation { view: view as u32, point, pixel, line: Line(0) });
        }
        points.push(place);
    }
    let truth = Bundle { views, points, observations };
    Simulated { bundle: displaced(&truth, options.start, rng), truth }
}

/// A point that at least two views see, and where they do.
fn landmark(
    scene: &Scene,
    views: &[BalView],
    track: usize,
    rng: &mut ChaCha8Rng,
) -> (Vector3<f64>, Vec<(usize, Vector2<f64>)>) {
    let mut draw = || {
        let (place, facing) = (scene.wall)(rng);
        (place, sightings(views, &place, &facing, track))
    };
    let drawn = (1..DRAWS).map(|_| draw()).find(|(_, seen)| seen.len() > 1);
    drawn.unwrap_or_else(draw)
}

/// The nearest views that face a point of a wall and have it in the image, in their order.
fn sightings(
    views: &[BalView],
    place: &Vector3<f64>,
    facing: &Vector3<f64>,
    most: usize,
) -> Vec<(usize, Vector2<f64>)> {
    let seen = views.iter().enumerate().filter_map(|(i, view)| {
        let towards = view.world_from_camera.translation() - place;
        let distance = towards.norm();
        if towards.dot(facing) < 0.2 * distance || distance > 60.0 {
            return None;
        }
        let pixel = view.camera.project(&view.world_from_camera.act_inverse(place)).ok()?;
        (pixel.x.abs() < HALF[0] && pixel.y.abs() < HALF[1]).then_some((distance, i, pixel))
    });
    let mut seen: Vec<_> = seen.collect();
    seen.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    seen.truncate(most);
    seen.sort_by_key(|(_, i, _)| *i);
    seen.into_iter().map(|(_, i, pixel)| (i, pixel)).collect()
}

/// The start: poses, points and focal lengths beside the truth.
fn displaced(truth: &Bundle, start: f64, rng: &mut ChaCha8Rng) -> Bundle {
    let mut bundle = truth.clone();
    let (place, turn) = (0.05 * start, 0.3_f64.to_radians() * start);
    for view in &mut bundle.views {
        let step = Vector6::from_fn(|i, _| normal(rng) * if i < 3 { place } else { turn });
        view.world_from_camera = view.world_from_camera.rplus(&step);
        view.camera.focal *= 1.0 + 0.01 * start * normal(rng);
    }
    for point in &mut bundle.points {
        *point += Vector3::from_fn(|_, _| 0.15 * start * normal(rng));
    }
    bundle
}

/// A sample of N(0, 1).
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    // Box, Muller (1958); 1 − u is never zero.
    (-2.0 * (1.0 - rng.random::<f64>()).ln()).sqrt() * (TAU * rng.random::<f64>()).cos()
}
