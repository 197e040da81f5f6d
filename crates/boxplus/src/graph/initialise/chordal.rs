//! Poses by two linear problems.
//!
//! ```text
//! rotations   min Σ κ‖R_j − R_i·R̃‖²_F over all matrices, then the nearest rotation to each
//! positions   min Σ ‖t_j − t_i − R_i·t̃‖² in the metric R_i·Ω_t·R_iᵀ
//! ```
//!
//! The rows of the matrices are independent of each other and share one system: it is factorised once and solved for
//! each row. Both problems join the same poses, so that ordering and symbolic factorisation serve both.

use nalgebra::{SMatrix, SVector};

use super::edges::{Edge, Pose};
use crate::graph::linear::cholesky::Cholesky;
use crate::graph::linear::evaluate::Evaluator;
use crate::graph::linear::structure::Structure;
use crate::graph::set::AnySet;
use crate::graph::{Between, Factor, Graph, GraphError, Key, Noise, Values, Variable};
use crate::lie::{Real, Rn};

/// Overwrites the poses that are joined by relative poses and are not in `known`; `values` hold a value for each.
pub(crate) fn relax<P: Pose<N, D>, const N: usize, const D: usize>(
    sets: &[Box<dyn AnySet>],
    known: &[bool],
    values: &mut Values,
) -> Result<(), GraphError> {
    let edges = P::edges(sets);
    if edges.is_empty() {
        return Ok(());
    }
    let mut system = None;
    let mut poses: Vec<P> = values.slice::<P>().iter().map(|pose| pose.unwrap_or_else(P::identity)).collect();
    let rotations = rotations(&edges, known, &poses, &mut system)?;
    for (pose, rotation) in poses.iter_mut().zip(&rotations) {
        *pose = P::nearest(rotation, &pose.parts().1).unwrap_or(*pose);
    }
    let positions = positions(&edges, known, &poses, &mut system)?;
    let mut free = vec![false; known.len()];
    edges
        .iter()
        .flat_map(|edge| [edge.from, edge.to])
        .for_each(|slot| free[slot as usize] = !known[slot as usize]);
    for slot in (0..free.len()).filter(|&slot| free[slot]) {
        values.set(Key::new(slot as u32), poses[slot].moved_to(&positions[slot]))?;
    }
    Ok(())
}

/// One row x of a rotation matrix, transposed: x_j = R̃ᵀ·x_i.
struct Row<const N: usize> {
    transposed: SMatrix<f64, N, N>,
}

impl<const N: usize> Factor<N> for Row<N> {
    const NAME: &'static str = "row of a rotation";
    const RELATIVE: bool = true;
    type Variables = (Rn<N>, Rn<N>);

    fn residual<S: Real>(
        &self,
        (x_i, x_j): &(<Rn<N> as Variable>::Over<S>, <Rn<N> as Variable>::Over<S>),
    ) -> SVector<S, N> {
        x_j.vector() - self.transposed.map(S::lit) * x_i.vector()
    }

    fn residual_jac(
        &self,
        (x_i, x_j): &(Rn<N>, Rn<N>),
    ) -> (SVector<f64, N>, (SMatrix<f64, N, N>, SMatrix<f64, N, N>)) {
        (x_j.vector() - self.transposed * x_i.vector(), (-self.transposed, SMatrix::identity()))
    }
}

/// The relaxed rotation of every pose; those known keep theirs.
fn rotations<P: Pose<N, D>, const N: usize, const D: usize>(
    edges: &[Edge<P, D>],
    known: &[bool],
    poses: &[P],
    system: &mut Option<System>,
) -> Result<Vec<SMatrix<f64, N, N>>, GraphError> {
    let mut graph = Graph::new();
    for edge in edges {
        let sigma = P::rotation_weight(&edge.information).sqrt().recip();
        let noise = Noise::from_sigmas(&SVector::repeat(sigma))?;
        let factor = Row { transposed: edge.measured.parts().0.transpose() };
        graph.add((Key::new(edge.from), Key::new(edge.to)), factor, noise);
    }
    let rows: Vec<Values> =
        (0..N).map(|k| anchored(known, |slot| poses[slot].parts().0.row(k).transpose())).collect();
    let rows = solve_linear(system, &graph.sets, rows)?;
    let entry = |slot: usize, i: usize, j: usize| {
        rows[i].get(Key::<Rn<N>>::new(slot as u32)).map_or(0.0, |row| row.vector()[j])
    };
    Ok((0..poses.len()).map(|slot| SMatrix::from_fn(|i, j| entry(slot, i, j))).collect())
}

/// The position of every pose, given its rotation.
fn positions<P: Pose<N, D>, const N: usize, const D: usize>(
    edges: &[Edge<P, D>],
    known: &[bool],
    poses: &[P],
    system: &mut Option<System>,
) -> Result<Vec<SVector<f64, N>>, GraphError> {
    let mut graph = Graph::new();
    for edge in edges {
        let (r, _) = poses[edge.from as usize].parts();
        let metric = SMatrix::<f64, N, N>::from_fn(|i, j| edge.information[(i, j)]);
        let metric = r * metric * r.transpose();
        let noise = Noise::from_information(&((metric + metric.transpose()) * 0.5))?;
        let displacement = Between::new(Rn::new(r * edge.measured.parts().1));
        graph.add((Key::new(edge.from), Key::new(edge.to)), displacement, noise);
    }
    let solved = solve_linear(system, &graph.sets, vec![anchored(known, |slot| poses[slot].parts().1)])?;
    let position =
        |slot: usize| solved[0].get(Key::<Rn<N>>::new(slot as u32)).map_or_else(SVector::zeros, Rn::vector);
    Ok((0..poses.len()).map(position).collect())
}

/// One vector for each pose: held at `value` where the pose is known, free and zero elsewhere.
fn anchored<const N: usize>(known: &[bool], value: impl Fn(usize) -> SVector<f64, N>) -> Values {
    let mut values = Values::new();
    for (slot, &known) in known.iter().enumerate() {
        let key = values.insert(Rn::new(if known { value(slot) } else { SVector::zeros() }));
        if known {
            values.hold(key);
        }
    }
    values
}

/// What depends on the edges alone.
struct System {
    structure: Structure,
    cholesky: Cholesky,
}

impl System {
    fn new(sets: &[Box<dyn AnySet>], values: &Values) -> Result<Self, GraphError> {
        let structure = Structure::new(sets, values)?;
        let cholesky = Cholesky::new(&structure.pattern)?;
        Ok(Self { structure, cholesky })
    }
}

/// Solves linear least-squares problems that differ in their held values only: one factorisation for all.
fn solve_linear(
    system: &mut Option<System>,
    sets: &[Box<dyn AnySet>],
    mut problems: Vec<Values>,
) -> Result<Vec<Values>, GraphError> {
    let System { structure, cholesky } = match system {
        Some(system) => system,
        None => system.insert(System::new(sets, &problems[0])?),
    };
    let mut evaluator = Evaluator::new(sets, 1);
    let mut normal = structure.normal();
    for (number, values) in problems.iter_mut().enumerate() {
        evaluator.linearise(values, structure, &mut normal);
        if number == 0 {
            cholesky.factorise(&normal.matrix).map_err(|_| GraphError::IllConditioned)?;
        }
        let mut step: Vec<f64> = normal.gradient.iter().map(|g| -g).collect();
        cholesky.solve(&mut step);
        let start = values.clone();
        start.retract_into(values, &step, &structure.offsets);
    }
    Ok(problems)
}
