//! Pose graphs whose truth is known.
//!
//! A simulator drives a path through a world and measures what is near:
//!
//! ```text
//! odometry  k−1 → k      Z = X_{k−1}⁻¹·X_k·Exp(ε)       ε ~ N(0, Σ), Σ = diag(σ_t², …, σ_r²), Ω = Σ⁻¹
//! closure   i → j        Z = X_i⁻¹·X_j·Exp(ε)           where the path comes by again
//! sighting  i → p        z = X_i⁻¹·p + ε
//! ```
//! The initial values are the odometry, chained from the true first pose, so that they drift as a real robot does. The same
//! options give the same graph.
//!
//! ```
//! use boxplus::pose_graph::simulate::{Options, Simulator};
//! let world: Simulator = "sphere".parse()?;
//! let simulated = world.simulate(&Options { size: Some(400), seed: 7, ..Options::default() })?;
//! assert_eq!(simulated.graph.poses3.len(), 400);
//! assert_eq!(simulated.graph.edges3.len(), 399 + 380);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod false_closures;
mod worlds;

use super::{Edge, Line, PoseGraph, Vertex};
use crate::lie::{Action, LieGroup, SE2};
use core::{f64::consts::TAU, fmt, str::FromStr};
use nalgebra::{SMatrix, SVector, Vector2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A world to drive through. [`Simulator::ALL`] lists them; each has a name and a description.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Simulator {
    /// Rings on a sphere, each joined to the ring below.
    Sphere,
    /// Rings around the tube of a torus, each joined to the next, the last to the first.
    Torus,
    /// Back and forth through a cubic lattice, joined to all neighbours.
    Grid,
    /// A random drive along the streets of a city of square blocks, in the plane.
    Manhattan,
    /// Laps and ramps through the floors of a car park, with few loop closures.
    Garage,
    /// A drive through a park in the plane that sees trees: loops close through points alone.
    Landmarks,
}

impl Simulator {
    /// Every simulator.
    pub const ALL: [Self; 6] =
        [Self::Sphere, Self::Torus, Self::Grid, Self::Manhattan, Self::Garage, Self::Landmarks];

    /// Its name, as [`FromStr`] takes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Torus => "torus",
            Self::Grid => "grid",
            Self::Manhattan => "manhattan",
            Self::Garage => "garage",
            Self::Landmarks => "landmarks",
        }
    }

    /// One line about it.
    pub fn description(self) -> &'static str {
        match self {
            Self::Sphere => "rings on a sphere, each joined to the ring below (3-D)",
            Self::Torus => "rings around a torus, each joined to the next (3-D)",
            Self::Grid => "back and forth through a cubic lattice, joined to all neighbours (3-D)",
            Self::Manhattan => "a random drive along the streets of a city of square blocks (2-D)",
            Self::Garage => "laps and ramps through a car park, with few loop closures (3-D)",
            Self::Landmarks => "a drive through a park that sees trees (2-D poses and points)",
        }
    }

    /// The number of poses unless [`Options::size`] says otherwise.
    pub fn default_size(self) -> usize {
        match self {
            Self::Sphere => 2500,
            Self::Torus => 5000,
            Self::Grid => 1000,
            Self::Manhattan => 3500,
            Self::Garage => 1661,
            Self::Landmarks => 2000,
        }
    }

    /// Makes a graph.
    ///
    /// # Errors
    /// [`OptionsError`], where an option is out of its range.
    pub fn simulate(self, options: &Options) -> Result<Simulated, OptionsError> {
        let size = options.size.unwrap_or(self.default_size());
        options.check(size)?;
        let rng = &mut ChaCha8Rng::seed_from_u64(options.seed);
        Ok(match self {
            Self::Sphere => in_space(&worlds::sphere(size), options, rng),
            Self::Torus => in_space(&worlds::torus(size), options, rng),
            Self::Grid => in_space(&worlds::grid(size), options, rng),
            Self::Garage => in_space(&worlds::garage(size), options, rng),
            Self::Manhattan => in_plane(&worlds::manhattan(size, rng), options, rng),
            Self::Landmarks => with_points(&worlds::park(size, rng), options, rng),
        })
    }
}

impl fmt::Display for Simulator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is none of [`Simulator::ALL`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no such simulator; choose sphere, torus, grid, manhattan, garage or landmarks")]
pub struct UnknownSimulator;

impl FromStr for Simulator {
    type Err = UnknownSimulator;

    fn from_str(name: &str) -> Result<Self, UnknownSimulator> {
        Self::ALL.into_iter().find(|s| s.name() == name).ok_or(UnknownSimulator)
    }
}

/// What to simulate.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// The number of poses, at least 1; `None` takes [`Simulator::default_size`].
    pub size: Option<usize>,
    /// Start of the random numbers.
    pub seed: u64,
    /// Standard deviation of each measured coordinate, metres, ≥ 0. With 0 it is exact and weighs like 1 m.
    pub sigma_translation: f64,
    /// Standard deviation of each measured rotation, radians, ≥ 0. With 0 it is exact and weighs like 1 rad.
    pub sigma_rotation: f64,
    /// The chance, 0…1, that a possible loop closure (or sighting of a point) is measured.
    pub closures: f64,
    /// The chance, 0…1, that a loop closure (or sighting) is of another place than it says.
    pub outliers: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            size: None,
            seed: 0,
            sigma_translation: 0.05,
            sigma_rotation: 0.01,
            closures: 1.0,
            outliers: 0.0,
        }
    }
}

/// An option out of its range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OptionsError {
    /// A graph without poses.
    #[error("the size must be at least 1")]
    NoPoses,
    /// A standard deviation that is negative, infinite or NaN.
    #[error("{name} is {value}; a standard deviation must be finite and not negative")]
    Sigma {
        /// The option.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A chance that is none.
    #[error("{name} is {value}; it must be between 0 and 1")]
    Chance {
        /// The option.
        name: &'static str,
        /// Its value.
        value: f64,
    },
}

impl Options {
    fn check(&self, size: usize) -> Result<(), OptionsError> {
        let sigmas = [("sigma_translation", self.sigma_translation), ("sigma_rotation", self.sigma_rotation)];
        let chances = [("closures", self.closures), ("outliers", self.outliers)];
        if size == 0 {
            return Err(OptionsError::NoPoses);
        }
        if let Some((name, value)) = sigmas.into_iter().find(|(_, v)| !(v.is_finite() && *v >= 0.0)) {
            return Err(OptionsError::Sigma { name, value });
        }
        match chances.into_iter().find(|(_, v)| !(0.0..=1.0).contains(v)) {
            Some((name, value)) => Err(OptionsError::Chance { name, value }),
            None => Ok(()),
        }
    }
}

/// A simulated graph and its truth.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulated {
    /// What the robot knows: drifting initial values and noisy measurements.
    pub graph: PoseGraph,
    /// The true poses and points, with the same ids and no measurements.
    pub truth: PoseGraph,
}

/// A path, and the pairs of its poses that could measure each other.
struct World<G> {
    path: Vec<G>,
    closures: Vec<(usize, usize)>,
}

/// A path in the plane, points, and which pose could see which point.
struct Park {
    path: Vec<SE2>,
    points: Vec<Vector2<f64>>,
    sightings: Vec<(usize, usize)>,
}

/// The vertices as the robot believes them, the vertices as they are, and the measurements.
type Survey<G, const D: usize> = (Vec<Vertex<G>>, Vec<Vertex<G>>, Vec<Edge<G, D>>);

fn in_space(world: &World<crate::lie::SE3>, options: &Options, rng: &mut ChaCha8Rng) -> Simulated {
    let (t, r) = (options.sigma_translation, options.sigma_rotation);
    let (poses3, truth, edges3) = survey(world, &SVector::from([t, t, t, r, r, r]), options, rng);
    Simulated {
        graph: PoseGraph { poses3, edges3, ..PoseGraph::default() },
        truth: PoseGraph { poses3: truth, ..PoseGraph::default() },
    }
}

fn in_plane(world: &World<SE2>, options: &Options, rng: &mut ChaCha8Rng) -> Simulated {
    let (t, r) = (options.sigma_translation, options.sigma_rotation);
    let (poses2, truth, edges2) = survey(world, &SVector::from([t, t, r]), options, rng);
    Simulated {
        graph: PoseGraph { poses2, edges2, ..PoseGraph::default() },
        truth: PoseGraph { poses2: truth, ..PoseGraph::default() },
    }
}

/// Adds points to the graph of a path: those that are seen, first placed where they were first seen.
fn with_points(park: &Park, options: &Options, rng: &mut ChaCha8Rng) -> Simulated {
    let world = World { path: park.path.clone(), closures: Vec::new() };
    let Simulated { mut graph, mut truth } = in_plane(&world, options, rng);
    let sigma = Vector2::repeat(options.sigma_translation);
    let (first_id, mut placed) = (park.path.len() as u64, vec![false; park.points.len()]);
    for &(i, p) in &park.sightings {
        if !rng.random_bool(options.closures) {
            continue;
        }
        let seen = if rng.random_bool(options.outliers) { rng.random_range(0..park.points.len()) } else { p };
        let measured = park.path[i].act_inverse(&park.points[seen]) + noise(&sigma, rng);
        let (from, to, line) = (i as u64, first_id + p as u64, Line(0));
        graph.sightings2.push(Edge { from, to, measured, information: information(&sigma), line });
        if !placed[p] {
            placed[p] = true;
            graph.points2.push(Vertex { id: to, value: graph.poses2[i].value.act(&measured), line });
            truth.points2.push(Vertex { id: to, value: park.points[p], line });
        }
    }
    graph.points2.sort_by_key(|v| v.id);
    truth.points2.sort_by_key(|v| v.id);
    Simulated { graph, truth }
}

/// Measures a path: odometry from pose to pose, then the closures.
fn survey<G: LieGroup<D, Scalar = f64>, const D: usize>(
    world: &World<G>,
    sigma: &SVector<f64, D>,
    options: &Options,
    rng: &mut ChaCha8Rng,
) -> Survey<G, D> {
    let path = &world.path;
    let measure = |i: usize, j: usize, seen: usize, rng: &mut ChaCha8Rng| {
        let measured = path[i].between(&path[seen]).rplus(&noise(sigma, rng));
        Edge { from: i as u64, to: j as u64, measured, information: information(sigma), line: Line(0) }
    };
    let mut edges: Vec<_> = (1..path.len()).map(|k| measure(k - 1, k, k, rng)).collect();
    let step = |pose: &mut G, edge: &Edge<G, D>| {
        *pose = pose.compose(&edge.measured);
        Some(*pose)
    };
    let drifted: Vec<G> = edges.iter().scan(path[0], step).collect();
    for &(i, j) in &world.closures {
        if rng.random_bool(options.closures) {
            let seen = if rng.random_bool(options.outliers) { rng.random_range(0..path.len()) } else { j };
            edges.push(measure(i, j, seen, rng));
        }
    }
    let vertices = |values: &mut dyn Iterator<Item = G>| {
        values.zip(0..).map(|(value, id)| Vertex { id, value, line: Line(0) }).collect()
    };
    (vertices(&mut path[..1].iter().chain(&drifted).copied()), vertices(&mut path.iter().copied()), edges)
}

/// A sample of N(0, diag(σ²)).
fn noise<const D: usize>(sigma: &SVector<f64, D>, rng: &mut ChaCha8Rng) -> SVector<f64, D> {
    // Box, Muller (1958); 1 − u is never zero.
    sigma.map(|s| s * (-2.0 * (1.0 - rng.random::<f64>()).ln()).sqrt() * (TAU * rng.random::<f64>()).cos())
}

/// The inverse covariance; an exact measurement weighs like one with σ = 1.
fn information<const D: usize>(sigma: &SVector<f64, D>) -> SMatrix<f64, D, D> {
    SMatrix::from_diagonal(&sigma.map(|s| if s > 0.0 { s.recip().powi(2) } else { 1.0 }))
}
