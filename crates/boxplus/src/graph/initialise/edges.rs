//! The relative poses of a graph, whatever their chart.

use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector2, Vector3};

use crate::graph::factors::isotropic_weights;
use crate::graph::set::{AnySet, FactorSet};
use crate::graph::{Between, Chart, Chordal, Difference, FactorId, G2o, GroupVariable, Log, Prior, Product};
use crate::lie::{SE2, SE3, SO2, SO3};

/// A measured displacement between two poses of one kind.
#[derive(Clone, Copy)]
pub(crate) struct Edge<P, const D: usize> {
    pub(crate) from: u32,
    pub(crate) to: u32,
    pub(crate) measured: P,
    pub(crate) information: SMatrix<f64, D, D>,
    pub(crate) factor: FactorId,
}

/// What SE(2) and SE(3) have in common: a rotation matrix and a position in ℝᴺ.
pub(crate) trait Pose<const N: usize, const D: usize>: GroupVariable<D> {
    /// (R, t).
    fn parts(&self) -> (SMatrix<f64, N, N>, SVector<f64, N>);
    /// How many rows of a relaxed rotation tell the others.
    const ROWS: usize;
    /// The pose at `t` with the rotation nearest to the matrix whose rows are the columns of `rows`, of which the first
    /// [`Self::ROWS`] count; `None` where several are equally near.
    fn with_rows(rows: &SMatrix<f64, N, N>, t: &SVector<f64, N>) -> Option<Self>;
    /// The same rotation at `t`.
    fn moved_to(&self, t: &SVector<f64, N>) -> Self;
    /// The relative poses of this kind.
    fn edges(sets: &[Box<dyn AnySet>]) -> Vec<Edge<Self, D>>;
    /// The rotational weight κ of a full information matrix.
    fn rotation_weight(information: &SMatrix<f64, D, D>) -> f64 {
        isotropic_weights(information).map_or(1.0, |(_, kappa)| kappa)
    }
}

impl Pose<2, 3> for SE2 {
    fn parts(&self) -> (Matrix2<f64>, Vector2<f64>) {
        (self.rotation().to_matrix(), self.translation())
    }
    const ROWS: usize = 1;
    /// The relaxation commutes with quarter turns, so that the second row is the first one turned.
    fn with_rows(rows: &Matrix2<f64>, t: &Vector2<f64>) -> Option<Self> {
        let (cos, minus_sin) = (rows[(0, 0)], rows[(1, 0)]);
        Some(Self::from_parts(*t, SO2::project(&Matrix2::new(cos, minus_sin, -minus_sin, cos)).ok()?))
    }
    fn moved_to(&self, t: &Vector2<f64>) -> Self {
        Self::from_parts(*t, self.rotation())
    }
    fn edges(sets: &[Box<dyn AnySet>]) -> Vec<Edge<Self, 3>> {
        in_all_charts(sets)
    }
}

impl Pose<3, 6> for SE3 {
    fn parts(&self) -> (Matrix3<f64>, Vector3<f64>) {
        (self.rotation().to_matrix(), self.translation())
    }
    const ROWS: usize = 3;
    fn with_rows(rows: &Matrix3<f64>, t: &Vector3<f64>) -> Option<Self> {
        Some(Self::new(SO3::project(&rows.transpose()).ok()?, *t))
    }
    fn moved_to(&self, t: &Vector3<f64>) -> Self {
        Self::new(self.rotation(), *t)
    }
    fn edges(sets: &[Box<dyn AnySet>]) -> Vec<Edge<Self, 6>> {
        in_all_charts(sets)
    }
}

/// The relative poses of every chart.
fn in_all_charts<P: GroupVariable<D>, const D: usize>(sets: &[Box<dyn AnySet>]) -> Vec<Edge<P, D>>
where
    Log: Chart<P, D>,
    Product: Chart<P, D>,
    G2o: Chart<P, D>,
    Difference: Chart<P, D>,
    Chordal: Chart<P, D>,
{
    let mut edges = in_chart::<P, Log, D>(sets);
    edges.extend(in_chart::<P, Product, D>(sets));
    edges.extend(in_chart::<P, G2o, D>(sets));
    edges.extend(in_chart::<P, Difference, D>(sets));
    edges.extend(in_chart::<P, Chordal, D>(sets));
    edges
}

/// The relative poses of one chart.
fn in_chart<P: GroupVariable<D>, C: Chart<P, D>, const D: usize>(
    sets: &[Box<dyn AnySet>],
) -> Vec<Edge<P, D>> {
    let mut edges = vec![];
    for (number, set) in sets.iter().enumerate() {
        let Some(set) = set.as_any().downcast_ref::<FactorSet<Between<P, C>, D>>() else { continue };
        edges.extend((0..set.factors.len()).map(|index| Edge {
            from: set.slots[index][0],
            to: set.slots[index][1],
            measured: set.factors[index].measured,
            information: set.noises[index].information(),
            factor: FactorId { set: number as u32, index: index as u32 },
        }));
    }
    edges
}

/// The poses that have a prior, with its mean, the surest prior first.
pub(crate) fn priors<P: GroupVariable<D>, const D: usize>(sets: &[Box<dyn AnySet>]) -> Vec<(u32, P)> {
    let sets = sets.iter().filter_map(|set| set.as_any().downcast_ref::<FactorSet<Prior<P>, D>>());
    let mut priors: Vec<(f64, u32, P)> = sets
        .flat_map(|set| set.slots.iter().zip(&set.factors).zip(&set.noises))
        .map(|((slots, prior), noise)| (noise.information().trace(), slots[0], prior.mean))
        .collect();
    priors.sort_by(|a, b| b.0.total_cmp(&a.0));
    priors.into_iter().map(|(_, slot, mean)| (slot, mean)).collect()
}
