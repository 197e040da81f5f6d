//! Aligns two scans once, as a new process, and prints what it took: SOURCE TARGET METHOD VOXEL GATE THREADS.
//!
//! Like the peer it starts the clock with both clouds in memory: thinning, trees, normals and iterations are inside.

use std::error::Error;
use std::time::Instant;

use boxplus::io::cloud;
use boxplus::lie::{LieGroup, SE3};
use boxplus::registration::{Icp, Preparation, Registered, Scan};
use cpu_time::ProcessTime;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [source, target, method, voxel, gate, threads] = arguments.as_slice() else {
        return Err("usage: SOURCE TARGET METHOD VOXEL GATE THREADS".into());
    };
    let read = |path: &str| -> Result<_, Box<dyn Error>> { Ok(cloud::read(&std::fs::read(path)?, path, None)?.points) };
    let (source, target) = (read(source)?, read(target)?);
    let threads = threads.parse()?;
    let preparation = Preparation { voxel: voxel.parse()?, threads, ..Preparation::default() };
    let options = Icp { method: method.parse()?, max_distance: gate.parse()?, threads, ..Icp::default() };

    let (wall, cpu) = (Instant::now(), ProcessTime::now());
    let (source, target) = (Scan::new(&source, &preparation)?, Scan::new(&target, &preparation)?);
    let prepared = wall.elapsed().as_secs_f64();
    let found: Registered<SE3, 6> = source.align(&target, &SE3::identity(), &options)?;
    let (wall, cpu) = (wall.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64());

    let matrix = found.target_from_source.to_matrix().transpose();
    println!(
        "{{\"wall\": {wall}, \"cpu\": {cpu}, \"prepared\": {prepared}, \"iterations\": {}, \"matches\": {}, \"T\": {:?}}}",
        found.iterations,
        found.matches,
        matrix.as_slice()
    );
    Ok(())
}
