//! Reconstructions for other programs: PLY, and the text files of COLMAP.

use super::check;
use crate::bundle_adjustment::Bundle;
use crate::io::error::WriteError;
use crate::lie::{Action, LieGroup, SE3, SO3};
use core::fmt::Write;
use nalgebra::{Vector3, vector};

const WHITE: [u8; 3] = [230, 230, 230];
const GREEN: [u8; 3] = [0, 200, 80];

/// Points in white and the places of the cameras in green, as a binary little-endian PLY with 64-bit coordinates.
///
/// # Errors
/// [`WriteError::NotFinite`].
pub fn write_ply(bundle: &Bundle) -> Result<Vec<u8>, WriteError> {
    check(bundle)?;
    let places = bundle.views.iter().map(|view| (view.world_from_camera.translation(), GREEN));
    let vertices = bundle.points.iter().map(|p| (*p, WHITE)).chain(places);
    let header = format!(
        "ply\nformat binary_little_endian 1.0\ncomment written by boxplus: points, then cameras\nelement vertex {}\n\
         property double x\nproperty double y\nproperty double z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
        bundle.points.len() + bundle.views.len()
    );
    let mut bytes = header.into_bytes();
    for (place, colour) in vertices {
        place.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        bytes.extend(colour);
    }
    Ok(bytes)
}

/// The three text files of a reconstruction in COLMAP's format.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Colmap {
    /// `cameras.txt`
    pub cameras: String,
    /// `images.txt`
    pub images: String,
    /// `points3D.txt`
    pub points: String,
}

/// A reconstruction in COLMAP's text format: cameras of the model `RADIAL`, numbers from 1, images named `0.jpg`, `1.jpg` and so on.
///
/// COLMAP's cameras look along z with y downwards, and pixels count from the corner of the image, whose size a bundle does not know: it is
/// made just large enough for all observations. Points that nobody sees are left out, as COLMAP has none.
///
/// ```
/// use boxplus::{bundle_adjustment::simulate::{Options, World}, io::bal};
/// let world = World::Ring.simulate(&Options { views: 3, points: 40, ..Options::default() })?;
/// let files = bal::colmap(&world.truth)?;
/// assert!(files.cameras.lines().nth(2).unwrap().starts_with("1 RADIAL "));
/// assert_eq!(files.images.lines().count(), 2 + 2 * 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`WriteError::NotFinite`].
pub fn colmap(bundle: &Bundle) -> Result<Colmap, WriteError> {
    check(bundle)?;
    let half = bundle.observations.iter().fold([1.0_f64; 2], |half, o| {
        [half[0].max(o.pixel.x.abs().ceil()), half[1].max(o.pixel.y.abs().ceil())]
    });
    let mut seen_by = vec![vec![]; bundle.views.len()];
    for o in bundle.observations.iter().filter(|o| bundle.joined(o).is_some()) {
        seen_by[o.view as usize].push(o);
    }
    let mut tracks = vec![(vec![], 0.0); bundle.points.len()];
    let mut images = String::from(
        "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# POINTS2D[] as (X, Y, POINT3D_ID)\n",
    );
    let mut cameras =
        String::from("# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n# RADIAL: f, cx, cy, k1, k2\n");
    // Writing to a string cannot fail.
    for (i, (view, seen)) in bundle.views.iter().zip(&seen_by).enumerate() {
        let (id, camera, [k1, k2], [cx, cy]) = (i + 1, view.camera.focal, view.camera.distortion, half);
        let _ = writeln!(cameras, "{id} RADIAL {} {} {camera} {cx} {cy} {k1} {k2}", 2.0 * cx, 2.0 * cy);
        let [x, y, z, w, tx, ty, tz] = turned(&view.world_from_camera);
        let _ = writeln!(images, "{id} {w} {x} {y} {z} {tx} {ty} {tz} {id} {i}.jpg");
        for (place, o) in seen.iter().enumerate() {
            let apart = if place == 0 { "" } else { " " };
            let _ = write!(images, "{apart}{} {} {}", o.pixel.x + cx, cy - o.pixel.y, o.point + 1);
            let (track, error) = &mut tracks[o.point as usize];
            track.push((id, place));
            *error += bundle.residual(o).map_or(0.0, |r| r.norm());
        }
        images.push('\n');
    }
    Ok(Colmap { cameras, images, points: points(bundle, &tracks) })
}

/// Of each point: who saw it, and the sum of its reprojection errors.
type Track = (Vec<(usize, usize)>, f64);

fn points(bundle: &Bundle, tracks: &[Track]) -> String {
    let mut text =
        String::from("# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n");
    for (i, (p, (track, error))) in
        bundle.points.iter().zip(tracks).enumerate().filter(|(_, (_, (track, _)))| !track.is_empty())
    {
        let [r, g, b] = WHITE;
        let mean = error / track.len() as f64;
        let _ = write!(text, "{} {} {} {} {r} {g} {b} {mean}", i + 1, p.x, p.y, p.z);
        for (image, place) in track {
            let _ = write!(text, " {image} {place}");
        }
        text.push('\n');
    }
    text
}

/// The pose as COLMAP writes it: camera_from_world with z ahead and y downwards, quaternion (x, y, z, w), then translation.
fn turned(world_from_camera: &SE3) -> [f64; 7] {
    let half_turn = SO3::exp(&vector![core::f64::consts::PI, 0.0, 0.0]);
    let rotation = half_turn.compose(&world_from_camera.rotation().inverse());
    let translation: Vector3<f64> = -rotation.act(&world_from_camera.translation());
    let [x, y, z, w] = rotation.quaternion_xyzw();
    [x, y, z, w, translation.x, translation.y, translation.z]
}
