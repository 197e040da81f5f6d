//! Where did the robot drive, where are the beacons, and by how much is its odometry off?
//!
//! Smoothing and mapping with self-calibration, Solà et al. (2018) §V-B to §V-D: nothing is known beforehand but roughly where the robot
//! started. Printed are truth, estimate and three standard deviations, in the plane and in space.
//!
//! With a number as argument: that many drives of each kind, and whether the covariances can be believed.
#![expect(clippy::print_stdout, reason = "an example talks")]

use boxplus::graph::{BeaconDrive, Driven, GroupVariable, Key, Marginals, Nees, Sees, SolveOptions, Values};
use boxplus::lie::Rn;
use boxplus::uncertainty::{ChiSquared, UncertaintyError};
use nalgebra::SVector;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    match std::env::args().nth(1) {
        None => {
            told("In the plane", &BeaconDrive::in_plane())?;
            told("In space", &BeaconDrive::in_space())
        }
        Some(runs) => {
            let runs = runs.parse()?;
            println!(
                "| drive | bias | NEES of the bias | beacons | last pose | everything |\n|---|---|---|---|---|---|"
            );
            judged("plane", &BeaconDrive::in_plane(), runs)?;
            judged("space", &BeaconDrive::in_space(), runs)?;
            judged("demonstration, plane", &BeaconDrive::<_, 3, 2>::demonstration(), runs)?;
            judged("demonstration, space", &BeaconDrive::<_, 6, 3>::demonstration(), runs)
        }
    }
}

/// One drive: truth, estimate, and how sure it is.
fn told<G: Sees<D, N>, const D: usize, const N: usize>(
    title: &str,
    drive: &BeaconDrive<G, D, N>,
) -> Result<(), Box<dyn Error>> {
    let driven = drive.simulate(&mut ChaCha8Rng::seed_from_u64(3))?;
    let Driven { graph, start, truth, poses, beacons, bias } = &driven;
    let solution = graph.optimize(start, &SolveOptions::default())?;
    let report = &solution.report;
    println!(
        "{title}: {} poses, {} beacons, {} sightings",
        poses.len(),
        beacons.len(),
        drive.sightings.len()
    );
    println!("cost {:.0} → {:.1}: {}", report.initial_cost, report.cost, report.termination);
    let mut told = Told { truth, estimate: &solution.values, marginals: graph.marginals(&solution.values)? };
    told.line("bias", *bias, Rn::vector)?;
    for (k, &beacon) in beacons.iter().enumerate() {
        told.line(&format!("beacon {k}"), beacon, Rn::vector)?;
    }
    for (i, &pose) in poses.iter().enumerate().step_by(20) {
        told.line(&format!("pose {i}"), pose, |x| x.act(&SVector::zeros()))?;
    }
    for Nees { of, dimension, squared } in driven.nees(&solution.values)? {
        println!("{of:10} NEES {squared:.1} of {dimension}");
    }
    println!();
    Ok(())
}

/// Lines of truth, estimate and three standard deviations.
struct Told<'a> {
    truth: &'a Values,
    estimate: &'a Values,
    marginals: Marginals,
}

impl Told<'_> {
    /// Where it is and was thought to be; the error on the local side, each coordinate with 3σ.
    fn line<V: GroupVariable<D>, const D: usize, const N: usize>(
        &mut self,
        name: &str,
        key: Key<V>,
        place: impl Fn(&V) -> SVector<f64, N>,
    ) -> Result<(), Box<dyn Error>> {
        let [truth, estimate] = [self.truth, self.estimate].map(|values| values.get(key));
        let (truth, estimate) = (truth.ok_or("no truth")?, estimate.ok_or("no estimate")?);
        let sigmas = self.marginals.covariance(key)?.diagonal().map(f64::sqrt);
        let numbers = |x: SVector<f64, N>| x.iter().map(|x| format!("{x:7.3}")).collect::<Vec<_>>().join(" ");
        let error = truth.rminus(estimate);
        let errors: Vec<_> =
            error.iter().zip(&sigmas).map(|(e, s)| format!("{e:7.3} ±{:5.3}", 3.0 * s)).collect();
        println!("{name:10} {} → {} | {}", numbers(place(truth)), numbers(place(estimate)), errors.join(" "));
        Ok(())
    }
}

/// Many drives, the bias estimated, known, and taken for none.
fn judged<G: Sees<D, N>, const D: usize, const N: usize>(
    name: &str,
    drive: &BeaconDrive<G, D, N>,
    runs: usize,
) -> Result<(), Box<dyn Error>> {
    for (how, known) in
        [("estimated", None), ("known", Some(drive.bias)), ("ignored", Some(SVector::zeros()))]
    {
        let mut sums: Vec<Nees> = vec![];
        for seed in 0..runs {
            let driven = drive.simulate(&mut ChaCha8Rng::seed_from_u64(seed as u64))?;
            let driven = match known {
                Some(bias) => driven.with_bias(bias)?,
                None => driven,
            };
            let solved = driven.graph.optimize(&driven.start, &SolveOptions::default())?.values;
            let judged = driven.nees(&solved)?;
            if sums.is_empty() {
                sums = judged;
            } else {
                sums.iter_mut().zip(judged).for_each(|(sum, one)| sum.squared += one.squared);
            }
        }
        let cells = ["bias", "beacons", "last pose", "everything"].map(|of| {
            let Some(Nees { dimension, squared, .. }) = sums.iter().find(|sum| sum.of == of) else {
                return Ok("–".to_owned());
            };
            let [low, high] = ChiSquared::new(dimension * runs).interval(0.95)?.map(|x| x / runs as f64);
            Ok::<_, UncertaintyError>(format!(
                "{:.2} of {dimension} ({low:.2} – {high:.2})",
                squared / runs as f64
            ))
        });
        let cells = cells.into_iter().collect::<Result<Vec<_>, _>>()?;
        println!("| {name} | {how} | {} |", cells.join(" | "));
    }
    Ok(())
}
