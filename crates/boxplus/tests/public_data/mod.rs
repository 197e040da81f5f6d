//! The public data sets: where they are, and the optima of those that are pose graphs.
//!
//! They may not be distributed with the library; without them a test says that it skips.
#![allow(dead_code, reason = "each test takes what it needs")]

use std::path::PathBuf;

use boxplus::io;
use boxplus::pose_graph::PoseGraph;

/// The folder of the public data: `BOXPLUS_DATA`, else `shared/data` beside the checkout; `None`, with a note, where there is none.
pub(crate) fn folder() -> Option<PathBuf> {
    let beside = || concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data").into();
    let folder = std::env::var_os("BOXPLUS_DATA").map_or_else(beside, PathBuf::from);
    if folder.join("pose-graph").is_dir() {
        return Some(folder);
    }
    println!(
        "SKIPPED: there is no pose-graph/ in {}; set BOXPLUS_DATA to a folder with it",
        folder.display()
    );
    None
}

/// The bytes of a file of the folder; `None`, with a note, where there is no such file.
pub(crate) fn bytes(path: &str) -> Option<Vec<u8>> {
    let file = folder()?.join(path);
    let bytes = std::fs::read(&file).ok();
    if bytes.is_none() {
        println!("SKIPPED: there is no {}", file.display());
    }
    bytes
}

/// A pose graph, plain or packed; `None`, with a note, where there is no public data at all.
pub(crate) fn graph(name: &str) -> Option<PoseGraph> {
    let folder = folder()?.join("pose-graph");
    let path = [name.to_owned(), format!("{name}.gz")]
        .map(|name| folder.join(name))
        .into_iter()
        .find(|p| p.is_file());
    let path = path.unwrap_or_else(|| panic!("{name} is not in {}", folder.display()));
    Some(io::read(&std::fs::read(path).unwrap(), name, None).unwrap().graph)
}

/// Optima of (SE-Sync, log, g2o, Ceres): the first certified, the others the best known.
pub(crate) const OPTIMA: [(&str, [f64; 4]); 11] = [
    ("M3500.g2o", [193.8622584, 68.95743912, 137.9129509, 68.95647547]),
    ("manhattan.g2o", [6431.391387, 1774.520535, 3549.036796, 1766.729263]),
    ("intel.g2o", [52.34822729, 22.50211654, 45.00469581, 22.20890399]),
    ("MIT.g2o", [61.15411552, 20.60347352, 41.16326884, 19.80064724]),
    ("kitti_00.g2o", [125.693515, 49.16106912, 98.32201174, 49.13134093]),
    ("sphere2500.g2o", [1687.005814, 675.7009629, 727.1496672, 677.0084937]),
    ("parking-garage.g2o", [1.262524428, 0.6341924, 1.23869058, 0.6341932]),
    ("torus3D.g2o", [24227.04556, 12117.63688, 14574.74644, 12113.52278]),
    ("sphere_bignoise_vertex3.g2o", [2961756.49, 1494168.755, 743862.7209, 1476863.346]),
    ("smallGrid3D.g2o", [1025.398056, 517.9253324, 458.1537843, 512.6990278]),
    ("tinyGrid3D.g2o", [18.51936642, 9.313909434, 6.727881617, 9.259683211]),
];
