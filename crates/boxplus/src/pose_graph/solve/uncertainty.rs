//! How sure a solved pose graph is of its positions.

use nalgebra::{DMatrix, Matrix3};

use super::problem::Problem;
use super::{PoseGraphError, SolveSettings};
use crate::graph::VariableId;
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
        let mut marginals = problem.factors.marginals(&problem.values)?;
        let known = |(_, variable, _): &(u64, VariableId, DMatrix<f64>)| marginals.knows(*variable);
        let framed =
            ids.iter().filter_map(|&id| problem.frame(id).map(|(key, rotation)| (id, key, rotation)));
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
}
