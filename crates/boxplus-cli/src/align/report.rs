//! What `align` found out, as one document for machines and for the screen alike.

use boxplus::registration::{Free, Icp, Registered, Termination};
use serde::Serialize;
use serde_json::Value;

use super::Job;
use super::start::Motion;
use crate::output::{DIM, GOOD, STRONG, WARN};
use crate::report::row;
use crate::text::{count, duration, grouped, significant};

/// The report of an alignment.
#[derive(Debug, Serialize)]
pub struct AlignDocument {
    /// `boxplus.align`.
    pub format: &'static str,
    /// Counts up when a field changes its meaning or goes away.
    pub version: u32,
    pub source: String,
    pub target: String,
    pub method: &'static str,
    /// 2 or 3.
    pub dimension: usize,
    pub voxel: f64,
    pub max_distance: f64,
    /// Points after reading, and after thinning.
    pub points: Points,
    pub target_from_source: Value,
    /// Of the local tangent, in `coordinates`; `null` where a direction is free.
    pub covariance: Option<Vec<Vec<f64>>>,
    pub sigmas: Option<Vec<f64>>,
    pub coordinates: Vec<&'static str>,
    pub free: Vec<FreeReport>,
    pub matches: usize,
    /// Part of the source points that have a partner.
    pub fitness: f64,
    /// Root of the mean squared distance of partners.
    pub rmse: f64,
    /// Standard deviation of what is minimised.
    pub sigma: f64,
    pub iterations: usize,
    pub termination: &'static str,
    pub converged: bool,
    pub seconds: Seconds,
    pub outputs: Vec<String>,
    #[serde(skip)]
    rows: Vec<(&'static str, String)>,
    #[serde(skip)]
    units: Vec<&'static str>,
}

/// Numbers of points.
#[derive(Debug, Serialize)]
pub struct Points {
    pub source: usize,
    pub target: usize,
    pub source_used: usize,
    pub target_used: usize,
}

/// A direction that no surface sees.
#[derive(Debug, Serialize)]
pub struct FreeReport {
    pub direction: String,
    /// As a local tangent, in the document's `coordinates`.
    pub tangent: Vec<f64>,
    /// Part of the matches that see it.
    pub share: f64,
}

/// Wall clock.
#[derive(Debug, Default, Serialize)]
pub struct Seconds {
    pub load: f64,
    pub prepare: f64,
    pub align: f64,
    pub total: f64,
}

impl AlignDocument {
    pub(super) fn new<G: Motion<D, N>, const D: usize, const N: usize>(
        job: &Job<'_>,
        icp: &Icp,
        found: &Registered<G, D>,
        (source_used, target_used): (usize, usize),
    ) -> Self {
        let pose = found.pose().ok();
        let rows =
            |m: &nalgebra::SMatrix<f64, D, D>| m.row_iter().map(|r| r.iter().copied().collect()).collect();
        Self {
            format: "boxplus.align",
            version: 1,
            source: job.source.name.clone(),
            target: job.target.name.clone(),
            method: icp.method.name(),
            dimension: N,
            voxel: job.options.voxel,
            max_distance: icp.max_distance,
            points: Points {
                source: job.source.cloud.points.len(),
                target: job.target.cloud.points.len(),
                source_used,
                target_used,
            },
            target_from_source: found.target_from_source.document(),
            covariance: pose.as_ref().map(|pose| rows(pose.covariance().matrix())),
            sigmas: pose.as_ref().map(|pose| pose.sigmas().iter().copied().collect()),
            coordinates: G::coordinates().map(|(name, _)| name).to_vec(),
            free: found.free.iter().map(FreeReport::of).collect(),
            matches: found.matches,
            fitness: found.fitness(),
            rmse: found.rmse,
            sigma: found.sigma,
            iterations: found.iterations,
            termination: match found.termination {
                Termination::Converged => "converged",
                Termination::Stalled => "stalled",
                _ => "max_iterations",
            },
            converged: found.termination != Termination::MaxIterations,
            seconds: Seconds::default(),
            outputs: vec![],
            rows: found.target_from_source.rows(),
            units: G::coordinates().map(|(_, unit)| unit).to_vec(),
        }
    }

    /// The screen.
    pub fn screen(&self) -> String {
        let Points { source_used, target_used, .. } = self.points;
        let names = format!("{STRONG}{}{STRONG:#} onto {STRONG}{}{STRONG:#}", self.source, self.target);
        let sizes = format!("{} onto {} points", grouped(source_used), grouped(target_used));
        let mut rows = vec![format!("{names}   {sizes}, {}", self.method), String::new()];
        rows.extend(self.rows.iter().map(|(label, value)| row(label, value)));
        rows.push(row("known to", &self.known()));
        rows.extend(self.free.iter().map(FreeReport::row));
        rows.push(row("fitness", &self.fit()));
        let style = if self.converged { GOOD } else { WARN };
        let steps = count(self.iterations, "step", "steps");
        rows.push(row(
            "stopped",
            &format!("{style}{}{style:#} after {steps}", self.termination.replace('_', " ")),
        ));
        let Seconds { load, prepare, align, total } = self.seconds;
        let parts = [("load", load), ("prepare", prepare), ("align", align)];
        let parts = parts.map(|(name, x)| format!("{name} {}", duration(x))).join(" · ");
        rows.push(row("time", &format!("{}   {DIM}{parts}{DIM:#}", duration(total))));
        rows.join("\n")
    }

    /// σ of each coordinate; those of one unit side by side.
    fn known(&self) -> String {
        let Some(sigmas) = &self.sigmas else {
            return format!("{WARN}unknown{WARN:#}, some direction is free");
        };
        let of = |unit: &str| {
            let all = sigmas.iter().zip(&self.units).filter(|(_, u)| **u == unit);
            all.map(|(x, _)| significant(*x, 2)).collect::<Vec<_>>().join("  ")
        };
        let note =
            format!("{DIM}σ along and about the axes of the source, matches taken as independent{DIM:#}");
        format!("{} m   {} rad   {note}", of("m"), of("rad"))
    }

    /// `93.9 % within 1 m, 0.12 m apart`.
    pub fn fit(&self) -> String {
        let share = significant(100.0 * self.fitness, 3);
        let (gate, rmse) = (significant(self.max_distance, 3), significant(self.rmse, 3));
        format!("{share} % of the source has a partner within {gate} m, {rmse} m away (rms)")
    }
}

impl FreeReport {
    fn of<const D: usize>(free: &Free<D>) -> Self {
        let tangent = free.tangent.iter().copied().collect();
        Self { direction: free.to_string(), tangent, share: free.share }
    }

    fn row(&self) -> String {
        let share = significant(100.0 * self.share, 2);
        row(
            "free",
            &format!("{WARN}{}{WARN:#}   {DIM}seen by {share} % of the matches{DIM:#}", self.direction),
        )
    }
}
