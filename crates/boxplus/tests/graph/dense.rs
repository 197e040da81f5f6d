//! Random graphs of four-variable factors, with held and repeated variables, against dense linear algebra.

use boxplus::graph::{Algorithm, Factor, Graph, Key, Noise, Prior, SolveOptions, Values, VariableId};
use boxplus::lie::{LieGroup, Real, Rn};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

use crate::world::{noise, positive, rng};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// r = M₁·a + M₂·b + M₃·c + M₄·d + e.
#[derive(Clone)]
struct Linear {
    blocks: (SMatrix<f64, 3, 1>, SMatrix<f64, 3, 2>, SMatrix<f64, 3, 2>, SMatrix<f64, 3, 3>),
    offset: SVector<f64, 3>,
}

impl Factor<3> for Linear {
    const NAME: &'static str = "linear";
    type Variables = (Rn<1>, Rn<2>, Rn<2>, Rn<3>);
    fn residual<S: Real>(&self, (a, b, c, d): &(Rn<1, S>, Rn<2, S>, Rn<2, S>, Rn<3, S>)) -> SVector<S, 3> {
        let (m1, m2, m3, m4) = &self.blocks;
        m1.map(S::lit) * a.vector()
            + m2.map(S::lit) * b.vector()
            + m3.map(S::lit) * c.vector()
            + m4.map(S::lit) * d.vector()
            + self.offset.map(S::lit)
    }
}

fn matrix<const C: usize>(rng: &mut ChaCha8Rng) -> SMatrix<f64, 3, C> {
    SMatrix::from_fn(|_, _| rng.random_range(-1.0..1.0))
}

/// Five variables of dimension N from `first` on in the dense numbering, some held, each with a unit prior at zero.
fn variables<const N: usize>(
    rng: &mut ChaCha8Rng,
    graph: &mut Graph,
    values: &mut Values,
    held: &mut Vec<bool>,
) -> Vec<Key<Rn<N>>> {
    let insert = |_| {
        let key = values.insert(Rn::new(noise::<N>(rng, 1.0)));
        let hold = rng.random_range(0.0..1.0) < 0.2;
        if hold {
            values.hold(key);
        }
        held.extend([hold; N]);
        graph.add((key,), Prior { mean: Rn::identity() }, Noise::unit());
        key
    };
    (0..5).map(insert).collect()
}

fn coordinates<const N: usize>(values: &Values, keys: &[Key<Rn<N>>]) -> Vec<f64> {
    keys.iter()
        .flat_map(|&key| values.get(key).unwrap().vector().iter().copied().collect::<Vec<_>>())
        .collect()
}

#[test]
fn the_solution_and_its_covariance_are_those_of_the_dense_problem() {
    let mut rng = rng(31);
    for _ in 0..100 {
        let (mut graph, mut values, mut held) = (Graph::new(), Values::new(), vec![]);
        let ones = variables::<1>(&mut rng, &mut graph, &mut values, &mut held);
        let twos = variables::<2>(&mut rng, &mut graph, &mut values, &mut held);
        let threes = variables::<3>(&mut rng, &mut graph, &mut values, &mut held);
        let all = |values: &Values| {
            [coordinates(values, &ones), coordinates(values, &twos), coordinates(values, &threes)].concat()
        };
        let start = DVector::from_vec(all(&values));
        let (mut hessian, mut gradient) = (DMatrix::identity(30, 30), start.clone()); // the priors
        for _ in 0..25 {
            let [a, b, c, d] = core::array::from_fn(|_| rng.random_range(0..5usize)); // b = c now and then
            let blocks =
                (matrix::<1>(&mut rng), matrix::<2>(&mut rng), matrix::<2>(&mut rng), matrix::<3>(&mut rng));
            let (offset, information) = (noise::<3>(&mut rng, 1.0), positive::<3>(&mut rng, 0.5));
            let mut jacobian = DMatrix::<f64>::zeros(3, 30);
            let mut add = |at: usize, block: DMatrix<f64>| {
                let mut view = jacobian.columns_mut(at, block.ncols());
                view += block;
            };
            add(a, DMatrix::from_column_slice(3, 1, blocks.0.as_slice()));
            add(5 + 2 * b, DMatrix::from_column_slice(3, 2, blocks.1.as_slice()));
            add(5 + 2 * c, DMatrix::from_column_slice(3, 2, blocks.2.as_slice()));
            add(15 + 3 * d, DMatrix::from_column_slice(3, 3, blocks.3.as_slice()));
            let omega = DMatrix::from_column_slice(3, 3, information.as_slice());
            let residual = &jacobian * &start + DVector::from_column_slice(offset.as_slice());
            hessian += jacobian.transpose() * &omega * &jacobian;
            gradient += jacobian.transpose() * omega * residual;
            let keys = (ones[a], twos[b], twos[c], threes[d]);
            graph.add(keys, Linear { blocks, offset }, Noise::from_information(&information).unwrap());
        }
        let free: Vec<usize> = (0..30).filter(|&i| !held[i]).collect();
        let inverse = hessian.select_rows(&free).select_columns(&free).try_inverse().unwrap();
        let step = -&inverse * gradient.select_rows(&free);
        let (mut expected, mut covariance) = (start.clone(), DMatrix::zeros(30, 30));
        for (p, &i) in free.iter().enumerate() {
            expected[i] += step[p];
            free.iter().enumerate().for_each(|(q, &j)| covariance[(i, j)] = inverse[(p, q)]);
        }

        let options = SolveOptions { algorithm: Algorithm::GaussNewton, ..SolveOptions::default() };
        let solution = graph.optimize(&values, &options).unwrap();
        assert!((DVector::from_vec(all(&solution.values)) - expected).amax() < 1e-12);
        let wanted: [VariableId; 3] = [threes[1].into(), ones[0].into(), twos[4].into()];
        let joint = graph.marginals(&solution.values).unwrap().joint(&wanted).unwrap();
        let indices = [18, 19, 20, 0, 13, 14];
        let dense = covariance.select_rows(&indices).select_columns(&indices);
        assert!((joint - dense).amax() < 1e-13);
    }
}
