//! Curves through or near given elements, one file each.

mod bezier;
mod catmull_rom;
mod hermite;
mod squad;

pub use bezier::Bezier;
pub use catmull_rom::{CatmullRom, PathJac};
pub use hermite::{Hermite, HermiteJac};
pub use squad::{Squad, slerp};
