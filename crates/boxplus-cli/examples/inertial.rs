//! The batch problems of EuRoC V1_01 and of KITTI as text, with their solution and the truth: what `benches/inertial` gives to other solvers.
//!
//! Arguments: the folder of the public data, a folder to write into.
#![allow(clippy::duplicate_mod, reason = "every example brings what they share")]
#![allow(dead_code, clippy::print_stdout, reason = "an example's `main` is not called; an example talks")]

#[path = "euroc.rs"]
mod euroc;
#[path = "kitti.rs"]
mod kitti;
#[path = "log/mod.rs"]
mod log;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use log::Outcome;

fn main() -> Outcome<()> {
    let mut arguments = std::env::args().skip(1);
    let Some(folder) = log::folder(arguments.next()) else { return Ok(()) };
    let Some(target) = arguments.next().map(PathBuf::from) else {
        println!("nothing is written: name a folder for the problems, after that of the data");
        return Ok(());
    };
    let truth = euroc::truth(&folder)?;
    let poses = truth.iter().map(|pose| {
        let (t, q) = (pose.value.translation(), pose.value.rotation().quaternion_xyzw());
        (pose.stamp_ns, [t.as_slice(), &q].concat())
    });
    euroc_and_kitti(&folder, &target, poses.collect())
}

fn euroc_and_kitti(folder: &Path, target: &Path, poses: Vec<(i64, Vec<f64>)>) -> Outcome<()> {
    let problem = euroc::batch(folder)?;
    write(target, "euroc", &problem.text()?, &problem.fastest()?.text()?, poses)?;
    let problem = kitti::batch(folder)?;
    let places =
        kitti::held_back(folder)?.iter().map(|p| (p.stamp_ns, p.value.as_slice().to_vec())).collect();
    write(target, "kitti", &problem.text()?, &problem.fastest()?.text()?, places)
}

/// NAME.problem, NAME.estimate and NAME.truth.
fn write(
    target: &Path,
    name: &str,
    problem: &str,
    estimate: &str,
    truth: Vec<(i64, Vec<f64>)>,
) -> Outcome<()> {
    let mut so = String::new();
    for (stamp_ns, numbers) in truth {
        let numbers: Vec<String> = numbers.iter().map(|x| format!("{x:e}")).collect();
        writeln!(so, "{stamp_ns} {}", numbers.join(" "))?;
    }
    for (ending, text) in [("problem", problem), ("estimate", estimate), ("truth", &so)] {
        let file = target.join(format!("{name}.{ending}"));
        std::fs::write(&file, text)?;
        println!("wrote {}", file.display());
    }
    Ok(())
}
