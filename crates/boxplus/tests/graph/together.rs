//! Factors that are computed together.

use boxplus::graph::{
    Between, Factor, FactorBatch, Graph, GraphError, Kernel, Key, MAX_ARITY, Noise, SolveOptions, Values,
    VariableId,
};
use boxplus::lie::{LieGroup, Rn, SE2};
use core::ops::Range;
use nalgebra::{matrix, vector};

/// Displacements, computed as a batch.
struct Displacements {
    ends: Vec<(Key<SE2>, Key<SE2>)>,
    measured: Vec<SE2>,
}

impl Displacements {
    fn at(&self, values: &Values, i: usize) -> (Between<SE2>, (SE2, SE2)) {
        let (a, b) = self.ends[i];
        (Between::new(self.measured[i]), (*values.get(a).unwrap(), *values.get(b).unwrap()))
    }
    fn columns(&self) -> [Vec<VariableId>; 2] {
        [self.ends.iter().map(|e| e.0.into()).collect(), self.ends.iter().map(|e| e.1.into()).collect()]
    }
}

impl FactorBatch<3> for Displacements {
    fn name(&self) -> &'static str {
        "displacement"
    }
    fn is_relative(&self) -> bool {
        true
    }
    fn residuals(&self, values: &Values, range: Range<usize>, residuals: &mut [f64]) {
        for (i, out) in range.zip(residuals.chunks_exact_mut(3)) {
            let (factor, variables) = self.at(values, i);
            out.copy_from_slice(factor.residual::<f64>(&variables).as_slice());
        }
    }
    fn residuals_jac(
        &self,
        values: &Values,
        range: Range<usize>,
        residuals: &mut [f64],
        jacobians: &mut [&mut [f64]],
    ) {
        for (place, i) in range.enumerate() {
            let (factor, variables) = self.at(values, i);
            let (r, (d_a, d_b)) = factor.residual_jac(&variables);
            residuals[3 * place..][..3].copy_from_slice(r.as_slice());
            for (jacobian, d) in jacobians.iter_mut().zip([d_a, d_b]) {
                jacobian[9 * place..][..9].copy_from_slice(d.transpose().as_slice());
            }
        }
    }
}

/// A loop of noisy steps, with correlated noise, and its poses somewhat off.
fn ring() -> (Values, Displacements, Vec<Noise<3>>) {
    let count = 150; // more than one chunk
    let mut values = Values::new();
    let off = |i: usize, k: f64| 0.1 * (k * i as f64).sin();
    let step = SE2::new(vector![1.0, 0.0], core::f64::consts::TAU / count as f64);
    let mut pose = SE2::identity();
    let mut keys = vec![];
    for i in 0..count {
        keys.push(values.insert(pose.rplus(&vector![off(i, 1.7), off(i, 2.3), off(i, 3.1)])));
        pose = pose.compose(&step);
    }
    let ends = (0..count).map(|i| (keys[i], keys[(i + 1) % count])).collect();
    let measured =
        (0..count).map(|i| step.rplus(&(vector![off(i, 5.1), off(i, 7.7), off(i, 0.7)] * 0.3))).collect();
    let information = matrix![9.0, 2.0, 1.0; 2.0, 4.0, 0.5; 1.0, 0.5, 30.0];
    let noise = Noise::from_information(&information).unwrap();
    (values, Displacements { ends, measured }, vec![noise; count])
}

#[test]
fn a_batch_is_solved_as_its_factors_are() {
    for kernel in [Kernel::None, Kernel::Huber(0.3)] {
        let (values, batch, noises) = ring();
        let mut single = Graph::new();
        for (i, &noise) in noises.iter().enumerate() {
            single.add_robust(batch.ends[i], Between::new(batch.measured[i]), noise, kernel);
        }
        let (mut together, columns) = (Graph::new(), batch.columns());
        let ids = together.add_batch(&values, &columns, batch, noises, kernel).unwrap();
        assert_eq!((ids.len(), together.len()), (150, 150));
        let options = SolveOptions::default();
        let [a, b] = [&single, &together].map(|graph| graph.optimize(&values, &options).unwrap());
        assert!(a.report.converged() && b.report.converged());
        assert_eq!(a.report.gauge, b.report.gauge);
        assert!((a.report.cost - b.report.cost).abs() < 1e-10 * a.report.cost);
        assert_eq!(together.name(ids[7], &values).unwrap().to_string(), "displacement of SE2 7, SE2 8");
        let pairs = single.ids().zip(&ids);
        for (alone, &id) in pairs {
            let [x, y] = [single.squared_error(alone, &a.values), together.squared_error(id, &a.values)];
            assert!((x.unwrap() - y.unwrap()).abs() < 1e-12);
        }
        let [p, q] = [&single, &together].map(|graph| {
            let key = a.values.key::<SE2>(75).unwrap();
            graph.marginals(&a.values).unwrap().covariance(key).unwrap()
        });
        assert!((&p - q).amax() < 1e-9 * p.amax());
    }
}

#[test]
fn directions_that_a_batch_leaves_free_are_named() {
    struct Lengths(Vec<Key<Rn<2>>>);
    impl FactorBatch<1> for Lengths {
        fn name(&self) -> &'static str {
            "length"
        }
        fn residuals(&self, values: &Values, range: Range<usize>, residuals: &mut [f64]) {
            for (i, r) in range.zip(residuals) {
                *r = values.get(self.0[i]).unwrap().vector().norm() - 1.0;
            }
        }
        fn residuals_jac(&self, values: &Values, range: Range<usize>, r: &mut [f64], j: &mut [&mut [f64]]) {
            self.residuals(values, range.clone(), r);
            for (i, row) in range.zip(j[0].chunks_exact_mut(2)) {
                row.copy_from_slice(values.get(self.0[i]).unwrap().vector().normalize().as_slice());
            }
        }
    }
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let keys = vec![values.insert(Rn::new(vector![2.0, 0.0])), values.insert(Rn::new(vector![0.0, 0.5]))];
    let column = keys.iter().map(|&key| key.into()).collect();
    graph.add_batch(&values, &[column], Lengths(keys), vec![Noise::unit(); 2], Kernel::None).unwrap();
    let solution = graph.optimize(&values, &SolveOptions::default()).unwrap();
    assert!(solution.report.cost < 1e-20);
    assert!(solution.unconstrained.unwrap().to_string().contains("Rn 0"));
}

#[test]
fn uneven_batches_are_refused() {
    let (values, batch, noises) = ring();
    let [a, b] = batch.columns();
    let mut graph = Graph::new();
    let wrong = [vec![], vec![a.clone(), b[1..].to_vec()], vec![a.clone(); MAX_ARITY + 1]];
    for columns in wrong {
        let (_, batch, _) = ring();
        let error = graph.add_batch(&values, &columns, batch, noises.clone(), Kernel::None).unwrap_err();
        assert_eq!(error, GraphError::UnevenBatch { factors: 150 });
    }
    let error = graph.add_batch(&Values::new(), &[a, b], batch, noises, Kernel::None).unwrap_err();
    assert!(matches!(error, GraphError::ForeignKey { number: 0, .. }), "{error}");
    assert!(graph.is_empty());
    let nothing = Displacements { ends: vec![], measured: vec![] };
    let none: Vec<Noise<3>> = vec![];
    assert_eq!(graph.add_batch(&values, &[vec![]], nothing, none, Kernel::None), Ok(vec![]));
    assert!(graph.cost(&values) == Ok(0.0) && values.key::<SE2>(150).is_none());
}
