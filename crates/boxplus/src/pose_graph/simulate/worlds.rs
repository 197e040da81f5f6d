//! The worlds: true paths, and where they come by again. Neighbouring poses are about 1 m apart.

use super::{Park, World};
use crate::lie::{LieGroup, SE2, SE3, SO3};
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use nalgebra::{Matrix3, Vector2, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;

/// A spiral from pole to pole. The body looks east, its z-axis away from the centre.
pub(super) fn sphere(size: usize) -> World<SE3> {
    let ring = size.isqrt().max(2);
    let radius = ring as f64 / TAU;
    let pose = |k: usize| {
        let longitude = TAU * k as f64 / ring as f64;
        let latitude = 0.98 * PI * (k as f64 / (size.max(2) - 1) as f64 - 0.5); // stops short of the poles
        let (sin_lon, cos_lon) = longitude.sin_cos();
        let (sin_lat, cos_lat) = latitude.sin_cos();
        let up = Vector3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat);
        SE3::new(facing(&Vector3::new(-sin_lon, cos_lon, 0.0), &up), up * radius)
    };
    World { path: (0..size).map(pose).collect(), closures: (ring..size).map(|k| (k - ring, k)).collect() }
}

/// Rings around the tube that move on around the axis. The body looks along its ring, its z-axis away from the tube.
pub(super) fn torus(size: usize) -> World<SE3> {
    let ring = (size / 4).isqrt().max(2);
    let rings = size as f64 / ring as f64;
    let tube = ring as f64 / TAU;
    let radius = 1.5 * tube + rings / TAU;
    let pose = |k: usize| {
        let (sin_u, cos_u) = (TAU * k as f64 / size as f64).sin_cos();
        let (sin_v, cos_v) = (TAU * k as f64 / ring as f64).sin_cos();
        let up = Vector3::new(cos_v * cos_u, cos_v * sin_u, sin_v);
        let forward = Vector3::new(-sin_v * cos_u, -sin_v * sin_u, cos_v);
        SE3::new(facing(&forward, &up), Vector3::new(cos_u, sin_u, 0.0) * radius + up * tube)
    };
    // The last ring meets the first at the same side of the tube.
    let next = |k: usize| if k + ring < size { k + ring } else { k % ring };
    let closures = if size > 2 * ring { (0..size).map(|k| (k, next(k))).collect() } else { Vec::new() };
    World { path: (0..size).map(pose).collect(), closures }
}

/// A lattice of side ⌈∛size⌉, walked row by row and layer by layer. The body looks where it goes, and keeps its heading
/// between layers.
pub(super) fn grid(size: usize) -> World<SE3> {
    let side = (1..size).find(|s| s.pow(3) >= size).unwrap_or(1);
    let flip = |i: usize, odd: usize| if odd % 2 == 1 { side - 1 - i } else { i };
    let place =
        |k: usize| [flip(k % side, k / side), flip(k / side % side, k / (side * side)), k / (side * side)];
    let index = |[x, y, z]: [usize; 3]| {
        let row = z * side + flip(y, z);
        row * side + flip(x, row)
    };
    let position = |k: usize| Vector3::from(place(k).map(|i| i as f64));
    let mut heading = 0.0;
    let mut path = Vec::with_capacity(size);
    for k in 0..size {
        let step = position(k + 1) - position(k);
        if step.x != 0.0 || step.y != 0.0 {
            heading = step.y.atan2(step.x);
        }
        path.push(SE3::new(SO3::exp(&(Vector3::z() * heading)), position(k)));
    }
    let neighbours = |k: usize| {
        let axes = (0..3).flat_map(move |axis| [(axis, -1), (axis, 1)]);
        axes.filter_map(move |(axis, step)| {
            let mut there = place(k);
            there[axis] = there[axis].checked_add_signed(step).filter(|i| *i < side)?;
            Some((index(there), k)).filter(|(j, _)| *j + 1 < k)
        })
    };
    World { path, closures: (0..size).flat_map(neighbours).collect() }
}

/// Rounds through an oval car park: on each floor one lap and a quarter on the level, then three quarters of a lap up the
/// ramp. What lies side by side closes a loop only where the level laps overlap.
pub(super) fn garage(size: usize) -> World<SE3> {
    const FLOOR: f64 = 3.0;
    let floors = size.div_ceil(330);
    let back = size.div_ceil(2 * floors);
    let lap = back as f64;
    let (a, b) = (0.2 * lap, 0.115 * lap); // circumference ≈ lap × 1 m
    let position = |laps: f64| {
        let (floor, u) = ((laps / 2.0).floor(), laps.rem_euclid(2.0));
        let ramp = ((u - 1.25) / 0.75).clamp(0.0, 1.0);
        let (sin, cos) = (TAU * laps).sin_cos();
        // The ramp starts and ends level: 3r² − 2r³.
        Vector3::new(a * cos, b * sin, FLOOR * (floor + ramp * ramp * (3.0 - 2.0 * ramp)))
    };
    let pose = |k: usize| {
        let laps = k as f64 / lap;
        let forward = position(laps + 1e-4) - position(laps - 1e-4);
        SE3::new(facing(&forward, &Vector3::z()), position(laps))
    };
    let overlaps = |k: &usize| (1.0..1.25).contains(&(*k as f64 / lap).rem_euclid(2.0)) && back > 1;
    World {
        path: (0..size).map(pose).collect(),
        closures: (back..size).filter(overlaps).map(|k| (k - back, k)).collect(),
    }
}

/// A walk along the streets of a square city with a crossing every `BLOCK` metres: half the time straight on, else left
/// or right, back only where the city ends. A pose closes a loop with the last one at the same place.
pub(super) fn manhattan(size: usize, rng: &mut ChaCha8Rng) -> World<SE2> {
    const BLOCK: i32 = 4;
    const RECENT: usize = 10;
    let blocks = i32::try_from((size / 24).isqrt()).unwrap_or(i32::MAX / 8) + 1; // every street about three times
    let side = BLOCK * blocks;
    let inside = |(x, y): (i32, i32)| (0..=side).contains(&x) && (0..=side).contains(&y);
    let ahead = |(x, y): (i32, i32), heading: usize| {
        let (dx, dy) = [(1, 0), (0, 1), (-1, 0), (0, -1)][heading % 4];
        (x + dx, y + dy)
    };
    let (mut place, mut heading) = ((side / BLOCK / 2 * BLOCK, side / BLOCK / 2 * BLOCK), 0);
    let mut last_at = BTreeMap::new();
    let mut world = World { path: Vec::with_capacity(size), closures: Vec::new() };
    for k in 0..size {
        if place.0 % BLOCK == 0 && place.1 % BLOCK == 0 {
            let turns = [0, 0, 1, 3].map(|turn| (heading + turn) % 4);
            let open: Vec<usize> = turns.into_iter().filter(|&h| inside(ahead(place, h))).collect();
            heading = if open.is_empty() { heading + 2 } else { open[rng.random_range(0..open.len())] };
        }
        let (x, y) = (f64::from(place.0), f64::from(place.1));
        world.path.push(SE2::new(Vector2::new(x, y), FRAC_PI_2 * heading as f64));
        let before = last_at.insert(place, k);
        world.closures.extend(before.filter(|j| k - j > RECENT).map(|j| (j, k)));
        place = ahead(place, heading);
    }
    world
}

/// A drive from one random place to the next with bounded curvature, and trees at random places that are seen nearby.
pub(super) fn park(size: usize, rng: &mut ChaCha8Rng) -> Park {
    const RANGE: f64 = 5.0;
    const CURVATURE: f64 = 0.2; // rad per step of 1 m
    let side = 1.2 * (size as f64).sqrt();
    let anywhere = |rng: &mut ChaCha8Rng| Vector2::new(rng.random::<f64>(), rng.random::<f64>()) * side;
    let points: Vec<_> = (0..size.div_ceil(20)).map(|_| anywhere(rng)).collect();
    let (mut pose, mut goal) = (SE2::new(Vector2::repeat(side / 2.0), 0.0), anywhere(rng));
    let (mut path, mut sightings) = (Vec::with_capacity(size), Vec::new());
    for k in 0..size {
        path.push(pose);
        let near = |p: &Vector2<f64>| (p - pose.translation()).norm() < RANGE;
        sightings.extend(points.iter().enumerate().filter(|(_, p)| near(p)).map(|(p, _)| (k, p)));
        // A goal inside the circle of the sharpest turn would be orbited for ever.
        if (goal - pose.translation()).norm() < 2.0 / CURVATURE {
            goal = anywhere(rng);
        }
        let bearing = goal - pose.translation();
        let turn = SE2::new(Vector2::zeros(), bearing.y.atan2(bearing.x)).rminus(&pose).z;
        pose = pose.compose(&SE2::exp(&Vector3::new(1.0, 0.0, turn.clamp(-CURVATURE, CURVATURE))));
    }
    Park { path, points, sightings }
}

/// The rotation whose x-axis looks along `forward` and whose z-axis is as near to `up` as it can be.
fn facing(forward: &Vector3<f64>, up: &Vector3<f64>) -> SO3 {
    let x = forward.normalize();
    let y = up.cross(&x).normalize();
    // The columns are orthonormal, hence a rotation.
    SO3::from_matrix(&Matrix3::from_columns(&[x, y, x.cross(&y)])).unwrap_or(SO3::identity())
}
