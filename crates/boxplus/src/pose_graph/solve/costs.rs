//! The four conventions in which tools print the cost of a pose graph.

use super::problem::Problem;
use super::{ChartKind, PoseGraphError, SolveSettings};
use crate::graph::Kernel;
use crate::pose_graph::PoseGraph;

/// One estimate, judged in the conventions of four tools; see [`ChartKind`]. Only at the optimum of its own chart is each
/// what its tool would reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Costs {
    /// ½ Σ eᵀΩe, full logarithm (boxplus, GTSAM).
    pub log: f64,
    /// Σ eᵀΩe, imaginary quaternion (g2o's χ²).
    pub g2o: f64,
    /// Σ τ‖·‖² + κ‖·‖²_F (SE-Sync).
    pub se_sync: f64,
    /// ½ Σ eᵀΩe, twice the imaginary quaternion (Ceres' pose-graph example).
    pub ceres: f64,
}

impl Costs {
    /// Judges the vertices of `graph` as they stand, without robust kernel.
    ///
    /// # Errors
    /// [`PoseGraphError`], where the graph is faulty or a vertex has no value.
    pub fn new(graph: &PoseGraph, settings: &SolveSettings) -> Result<Self, PoseGraphError> {
        let cost = |chart: ChartKind| -> Result<f64, PoseGraphError> {
            let settings = SolveSettings { chart, kernel: Kernel::None, ..settings.clone() };
            let problem = Problem::new(graph, &settings)?;
            Ok(chart.factor() * problem.factors.cost(&problem.values)?)
        };
        Ok(Self {
            log: cost(ChartKind::Log)?,
            g2o: cost(ChartKind::G2o)?,
            se_sync: cost(ChartKind::SeSync)?,
            ceres: cost(ChartKind::Ceres)?,
        })
    }

    /// The cost in the convention of one chart.
    pub fn of(&self, chart: ChartKind) -> f64 {
        match chart {
            ChartKind::Log => self.log,
            ChartKind::G2o => self.g2o,
            ChartKind::Ceres => self.ceres,
            ChartKind::SeSync => self.se_sync,
        }
    }
}
