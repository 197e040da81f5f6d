//! How sure a solved pose graph is of its positions.

use nalgebra::{DMatrix, Matrix3};

use super::problem::Problem;
use super::{PoseGraphError, SolveSettings};
use crate::graph::{GraphError, Marginals, VariableId};
use crate::pose_graph::PoseGraph;

/// How sure the position of one vertex is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionCovariance {
    /// The vertex.
    pub id: u64,
    /// Covariance of its position, in the world frame, metres²; zero in z for the plane.
    pub covariance: Matrix3<f64>,
}

impl PoseGraph {
    /// Covariances of the positions of these vertices, at the values that the graph holds, in the world frame, relative
    /// to whatever is held. Ids that name no vertex, or one that no measurement reads, are left out.
    ///
    /// # Errors
    /// [`PoseGraphError`], e.g. where the measurements do not determine them.
    pub fn position_covariances(
        &self,
        ids: &[u64],
        settings: &SolveSettings,
    ) -> Result<Vec<PositionCovariance>, PoseGraphError> {
        let problem = Problem::new(self, settings)?;
        let marginals = problem.factors.marginals(&problem.values)?;
        Ok(positions(&problem, marginals, ids)?)
    }

    /// As [`Self::position_covariances`], but where nothing is held and no prior ties the graph down, relative to nothing: of all
    /// covariances that the measurements allow the one of least norm
    /// ([`Graph::marginals_of_minimum_norm`](crate::graph::Graph::marginals_of_minimum_norm)), in which no pose is favoured.
    ///
    /// ```
    /// use boxplus::pose_graph::SolveSettings;
    /// use boxplus::pose_graph::simulate::{Options, Simulator};
    /// let graph = Simulator::Manhattan.simulate(&Options { size: Some(60), ..Options::default() })?.graph;
    /// let settings = SolveSettings::default();
    /// let held = graph.position_covariances(&[0, 59], &settings)?;
    /// let free = graph.position_covariances_of_minimum_norm(&[0, 59], &settings)?;
    /// assert_eq!(held[0].covariance.trace(), 0.0); // the first pose is held, and known exactly
    /// assert!(free[0].covariance.trace() > 0.0 && free[1].covariance.trace() < held[1].covariance.trace());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::position_covariances`].
    pub fn position_covariances_of_minimum_norm(
        &self,
        ids: &[u64],
        settings: &SolveSettings,
    ) -> Result<Vec<PositionCovariance>, PoseGraphError> {
        let problem = Problem::new(self, settings)?;
        let marginals = problem.factors.marginals_of_minimum_norm(&problem.values)?;
        Ok(positions(&problem, marginals, ids)?)
    }
}

fn positions(
    problem: &Problem,
    mut marginals: Marginals,
    ids: &[u64],
) -> Result<Vec<PositionCovariance>, GraphError> {
    let known = |(_, variable, _): &(u64, VariableId, DMatrix<f64>)| marginals.knows(*variable);
    let framed = ids.iter().filter_map(|&id| problem.frame(id).map(|(key, rotation)| (id, key, rotation)));
    let framed: Vec<_> = framed.filter(known).collect();
    let variables: Vec<_> = framed.iter().map(|&(_, variable, _)| variable).collect();
    let covariances = marginals.covariances(&variables)?;
    let mut out = Vec::with_capacity(framed.len());
    for ((id, _, rotation), local) in framed.into_iter().zip(covariances) {
        let size = rotation.nrows();
        let world = &rotation * local.view((0, 0), (size, size)) * rotation.transpose();
        let entry = |i, j| if i < size && j < size { world[(i, j)] } else { 0.0 };
        out.push(PositionCovariance { id, covariance: Matrix3::from_fn(entry) });
    }
    Ok(out)
}
