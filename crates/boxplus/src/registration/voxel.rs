//! Thinning: one point per cube of a grid.

use super::RegistrationError;
use super::closed_form::check_finite;
use super::error::Role;
use nalgebra::SVector;

/// One point for each occupied cube of edge `size`: the mean of the points in it. In the order of the cubes, by their last
/// coordinate first.
///
/// Cubes are counted from the smallest coordinates of the cloud, so that a cloud moved by any translation thins alike.
///
/// ```
/// use boxplus::registration::thinned;
/// use nalgebra::vector;
/// let cloud = [vector![0.0, 0.0], vector![0.2, 0.4], vector![7.0, 7.0]];
/// assert_eq!(thinned(&cloud, 1.0)?, [vector![0.1, 0.2], vector![7.0, 7.0]]);
/// # Ok::<(), boxplus::registration::RegistrationError>(())
/// ```
///
/// # Errors
/// [`RegistrationError::NotFinite`]; [`RegistrationError::VoxelSize`] where `size` is not positive, or so small that the grid has
/// more than 2²¹ cubes along an axis (in the plane 2³²).
pub fn thinned<const N: usize>(
    points: &[SVector<f64, N>],
    size: f64,
) -> Result<Vec<SVector<f64, N>>, RegistrationError> {
    check_finite(points, Role::Cloud)?;
    let Some(corner) = points.iter().copied().reduce(|a, b| a.inf(&b)) else { return Ok(vec![]) };
    let extent = points.iter().map(|p| (p - corner).amax()).fold(0.0, f64::max);
    let bits = (64 / N as u32).min(62);
    // Also false for NaN.
    if !(size > 0.0 && extent / size < (1_u64 << bits) as f64) {
        return Err(RegistrationError::VoxelSize { size, extent });
    }
    let mut order: Vec<(u64, usize)> =
        points.iter().enumerate().map(|(i, p)| (cube(&(p - corner), size, bits), i)).collect();
    order.sort_unstable();
    let mean = |cube: &[(u64, usize)]| {
        let sum: SVector<f64, N> = cube.iter().map(|&(_, i)| points[i] - corner).sum();
        corner + sum / cube.len() as f64
    };
    Ok(order.chunk_by(|a, b| a.0 == b.0).map(mean).collect())
}

/// The cube of a point, its coordinates side by side in one number.
#[allow(clippy::cast_sign_loss, reason = "measured from the smallest coordinates")]
fn cube<const N: usize>(p: &SVector<f64, N>, size: f64, bits: u32) -> u64 {
    (0..N).rev().fold(0, |key, i| (key << bits) | (p[i] / size) as u64)
}
