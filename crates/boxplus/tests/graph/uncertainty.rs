//! Marginal covariances, and what cannot be known.

use boxplus::graph::{
    Bearing2, Between, Graph, GraphError, GroupVariable, Noise, Prior, Range, Sighting2, SolveOptions, Values,
};
use boxplus::lie::{LieGroup, Rn, SE2, SE3};
use nalgebra::{DMatrix, DVector, SMatrix, SVector, Vector2, vector};

use crate::world::{noise, positive, rng, walk};

/// JᵀJ of a walk with its first pose held, by central differences of the cost's whitened residuals: second differences of
/// the cost would lose half the digits, so each residual is differentiated through the cost of a graph of its own.
fn dense_information<G: GroupVariable<D>, const D: usize>(
    edges: &[(usize, usize, G, SMatrix<f64, D, D>)],
    poses: &[G],
) -> DMatrix<f64> {
    let size = D * (poses.len() - 1);
    let mut information = DMatrix::zeros(size, size);
    for (i, j, z, omega) in edges {
        let residual = |a: &G, b: &G| z.between(&a.between(b)).log();
        let mut jacobian = DMatrix::zeros(D, size);
        let h = 1e-6; // h² ≈ 1e-12, ε/h ≈ 2e-10
        for (which, pose) in [(0, *i), (1, *j)].into_iter().filter(|&(_, pose)| pose > 0) {
            for d in 0..D {
                let step =
                    |sign: f64| SVector::<f64, D>::from_fn(|row, _| if row == d { sign * h } else { 0.0 });
                let at = |sign: f64| {
                    let moved = poses[pose].rplus(&step(sign));
                    if which == 0 { residual(&moved, &poses[*j]) } else { residual(&poses[*i], &moved) }
                };
                jacobian.column_mut(D * (pose - 1) + d).copy_from(&((at(1.0) - at(-1.0)) / (2.0 * h)));
            }
        }
        let omega = DMatrix::from_column_slice(D, D, omega.as_slice());
        information += jacobian.transpose() * omega * jacobian;
    }
    information
}

fn marginals_are_the_dense_inverse<G: GroupVariable<D>, const D: usize>() {
    let mut rng = rng(21);
    let poses: Vec<G> = walk::<G, D>(22, 8, 0, 0.0).truth;
    let pairs = (1..8).map(|j| (j - 1, j)).chain([(0, 5), (2, 7), (6, 1)]);
    let edges: Vec<_> = pairs
        .map(|(i, j)| {
            (i, j, poses[i].between(&poses[j]).rplus(&noise(&mut rng, 0.05)), positive::<D>(&mut rng, 50.0))
        })
        .collect();
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let keys: Vec<_> = poses.iter().map(|x| values.insert(*x)).collect();
    for (i, j, z, omega) in &edges {
        graph.add((keys[*i], keys[*j]), Between::new(*z), Noise::from_information(omega).unwrap());
    }
    let mut marginals = graph.marginals(&values).unwrap();
    assert_eq!(marginals.gauge()[0].label, 0);
    let dense = dense_information(&edges, &poses).try_inverse().unwrap();
    let size = dense.amax();
    for (k, &key) in keys[1..].iter().enumerate() {
        let block = dense.view((D * k, D * k), (D, D));
        assert!((marginals.covariance(key).unwrap() - block).amax() < 1e-8 * size);
    }
    let joint = marginals.joint(&[keys[5].into(), keys[0].into(), keys[2].into()]).unwrap();
    assert!((joint.view((0, 2 * D), (D, D)) - dense.view((4 * D, D), (D, D))).amax() < 1e-8 * size);
    assert_eq!(joint.view((D, 0), (D, 3 * D)).amax(), 0.0, "the held pose is known exactly");
}

#[test]
fn marginals_equal_the_inverse_of_the_dense_information_matrix() {
    marginals_are_the_dense_inverse::<Rn<3>, 3>();
    marginals_are_the_dense_inverse::<SE2, 3>();
    marginals_are_the_dense_inverse::<SE3, 6>();
}

/// The pseudo-inverse of a dense symmetric matrix whose null space has `null` dimensions.
fn pseudo_inverse(matrix: &DMatrix<f64>, null: usize) -> DMatrix<f64> {
    let eigen = matrix.clone().symmetric_eigen();
    let mut order: Vec<usize> = (0..matrix.nrows()).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let seen = order[null..].iter().map(|&k| {
        let vector = eigen.eigenvectors.column(k);
        vector * vector.transpose() / eigen.eigenvalues[k]
    });
    seen.sum()
}

/// Two walks that nothing joins, and points seen from the first: everything relative, two gauges.
#[test]
fn marginals_without_a_gauge_are_the_pseudo_inverse_of_the_dense_information_matrix() {
    let mut rng = rng(24);
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let flat: Vec<SE2> = walk::<SE2, 3>(25, 6, 0, 0.0).truth;
    let spatial: Vec<SE3> = walk::<SE3, 6>(26, 4, 0, 0.0).truth;
    let flat: Vec<_> = flat.into_iter().map(|x| (values.insert(x), x)).collect();
    let points: Vec<_> = (0..3).map(|_| values.insert(Rn::new(noise::<2>(&mut rng, 3.0)))).collect();
    let spatial: Vec<_> = spatial.into_iter().map(|x| (values.insert(x), x)).collect();
    for (i, j) in [(0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (0, 3), (5, 1)] {
        let z = flat[i].1.between(&flat[j].1).rplus(&noise(&mut rng, 0.05));
        let omega = positive::<3>(&mut rng, 50.0);
        graph.add((flat[i].0, flat[j].0), Between::new(z), Noise::from_information(&omega).unwrap());
    }
    for (i, p) in [(0, 0), (1, 0), (2, 1), (3, 1), (4, 2), (0, 2)] {
        let omega = positive::<2>(&mut rng, 50.0);
        let seen = Sighting2 { measured: noise::<2>(&mut rng, 2.0) };
        graph.add((flat[i].0, points[p]), seen, Noise::from_information(&omega).unwrap());
    }
    for (i, j) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
        let z = spatial[i].1.between(&spatial[j].1).rplus(&noise(&mut rng, 0.05));
        let omega = positive::<6>(&mut rng, 50.0);
        graph.add((spatial[i].0, spatial[j].0), Between::new(z), Noise::from_information(&omega).unwrap());
    }
    let mut ids: Vec<_> = flat.iter().map(|&(key, _)| key.into()).collect();
    ids.extend(points.iter().map(|&key| boxplus::graph::VariableId::from(key)));
    ids.extend(spatial.iter().map(|&(key, _)| boxplus::graph::VariableId::from(key)));

    let mut free = graph.marginals_of_minimum_norm(&values).unwrap();
    assert!(free.gauge().is_empty());
    let covariance = free.joint(&ids).unwrap();
    // The information of a weak prior on everything, whose inverse leaves no gauge, less that prior.
    let weight = 1.0;
    for &(key, mean) in &flat {
        graph.add((key,), Prior { mean }, Noise::from_information(&(SMatrix::identity() * weight)).unwrap());
    }
    for &key in &points {
        let mean = *values.get(key).unwrap();
        graph.add((key,), Prior { mean }, Noise::from_information(&(SMatrix::identity() * weight)).unwrap());
    }
    for &(key, mean) in &spatial {
        graph.add((key,), Prior { mean }, Noise::from_information(&(SMatrix::identity() * weight)).unwrap());
    }
    let tied = graph.marginals(&values).unwrap().joint(&ids).unwrap();
    let size = tied.nrows();
    let information = tied.try_inverse().unwrap() - DMatrix::identity(size, size) * weight;
    let dense = pseudo_inverse(&information, 3 + 6);
    assert!((&covariance - &dense).amax() < 1e-9 * dense.amax(), "{:.1e}", (&covariance - &dense).amax());
    // All blocks in one sweep, and one block asked for alone, are the same as in the joint.
    let mut start = 0;
    for block in free.covariances(&ids).unwrap() {
        let dim = block.nrows();
        let expected = covariance.view((start, start), (dim, dim));
        assert!((&block - expected).amax() < 1e-12 * dense.amax(), "{:.1e}", (&block - expected).amax());
        start += dim;
    }
    assert_eq!(start, size);
    let alone = free.covariance(points[1]).unwrap();
    assert!((alone - covariance.view((20, 20), (2, 2))).amax() < 1e-15 * dense.amax());
    // With priors there is no gauge to be free of.
    let mut tied_too = graph.marginals_of_minimum_norm(&values).unwrap();
    assert_eq!(tied_too.joint(&ids).unwrap(), graph.marginals(&values).unwrap().joint(&ids).unwrap());
}

#[test]
fn relative_uncertainty_is_the_same_in_every_gauge() {
    let walk = walk::<SE3, 6>(27, 12, 9, 0.05);
    let (graph, values) = (&walk.graph, &walk.values);
    let pair = [walk.keys[3].into(), walk.keys[10].into()];
    let (x, y) = (values.get(walk.keys[3]).unwrap(), values.get(walk.keys[10]).unwrap());
    let adjoint = y.between(x).adjoint(); // X⁻¹Y·Exp(…): −Ad_{Y⁻¹X} ξ_x + ξ_y
    let mut jacobian = DMatrix::zeros(6, 12);
    jacobian.view_mut((0, 0), (6, 6)).copy_from(&-adjoint);
    jacobian.view_mut((0, 6), (6, 6)).fill_with_identity();
    let held = graph.marginals(values).unwrap().joint(&pair).unwrap();
    let free = graph.marginals_of_minimum_norm(values).unwrap().joint(&pair).unwrap();
    let relative = |joint: &DMatrix<f64>| &jacobian * joint * jacobian.transpose();
    assert!((relative(&held) - relative(&free)).amax() < 1e-9 * relative(&held).amax());
    assert!(free.trace() < held.trace());
}

#[test]
fn the_marginal_of_one_displacement_is_its_noise_on_the_local_side() {
    let covariance = positive::<6>(&mut rng(23), 0.01);
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let z = SE3::exp(&SVector::from([1.0, 2.0, 3.0, 0.5, -0.4, 0.3]));
    let (a, b) = (
        values.insert(SE3::exp(&SVector::from([4.0, 0.0, 1.0, 0.2, 0.9, 0.0]))),
        values.insert(SE3::identity()),
    );
    graph.add((a, b), Between::new(z), Noise::from_covariance(&covariance).unwrap());
    values.hold(a);
    let solution = graph.optimize(&values, &SolveOptions::default()).unwrap();
    let marginal = graph.marginals(&solution.values).unwrap().covariance(b).unwrap();
    let expected = DMatrix::from_column_slice(6, 6, covariance.as_slice());
    let adjoint = solution.values.get(b).unwrap().adjoint();
    let global = graph.marginals(&solution.values).unwrap().covariance_global(b).unwrap();
    let moved = adjoint * covariance * adjoint.transpose();
    assert!((global - DMatrix::from_column_slice(6, 6, moved.as_slice())).amax() < 1e-9 * moved.amax());
    assert!((&marginal - &expected).amax() < 1e-10 * expected.amax());
}

/// Mahalanobis distances of 2000 solved worlds have the mean that χ² has.
#[test]
fn marginals_predict_the_scatter_of_solutions() {
    let mut rng = rng(24);
    let truth: Vec<SE2> = walk::<SE2, 3>(25, 6, 0, 0.0).truth;
    let pairs: Vec<_> = (1..6).map(|j| (j - 1, j)).chain([(0, 5), (1, 4)]).collect();
    let sigma = 0.02;
    let (mut sum, runs) = (0.0, 2000);
    for _ in 0..runs {
        let (mut graph, mut values) = (Graph::new(), Values::new());
        let keys: Vec<_> = truth.iter().map(|x| values.insert(*x)).collect();
        values.hold(keys[0]);
        for &(i, j) in &pairs {
            // The sum of twelve uniform numbers is near enough to normal: its first two moments are exact.
            let gauss = (0..12).map(|_| noise::<3>(&mut rng, 0.5)).sum::<SVector<f64, 3>>() * sigma;
            let z = truth[i].between(&truth[j]).rplus(&gauss);
            graph.add(
                (keys[i], keys[j]),
                Between::new(z),
                Noise::from_sigmas(&SVector::repeat(sigma)).unwrap(),
            );
        }
        let solution =
            graph.optimize(&values, &SolveOptions { threads: 1, ..SolveOptions::default() }).unwrap();
        let covariance = graph.marginals(&solution.values).unwrap().covariance(keys[3]).unwrap();
        let error = truth[3].rminus(solution.values.get(keys[3]).unwrap());
        let error = DVector::from_column_slice(error.as_slice());
        sum += (error.transpose() * covariance.try_inverse().unwrap() * &error)[0];
    }
    let (mean, standard_error) = (sum / f64::from(runs), (6.0 / f64::from(runs)).sqrt()); // var χ²₃ = 6
    assert!((mean - 3.0).abs() < 4.0 * standard_error, "{mean} ± {standard_error}");
}

/// A pose that is held, and a landmark that `see` measures.
fn landmark(
    see: impl Fn(&mut Graph, &mut Values, boxplus::graph::Key<SE2>, boxplus::graph::Key<Rn<2>>),
) -> (Graph, Values) {
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let pose = values.insert(SE2::identity());
    let point = values.insert_labelled(Rn::new(vector![3.0, 0.0]), 17);
    values.hold(pose);
    see(&mut graph, &mut values, pose, point);
    (graph, values)
}

#[test]
fn what_nothing_constrains_is_named_with_its_coordinates() {
    let (graph, values) = landmark(|graph, _, pose, point| {
        graph.add((pose, point), Range::new(3.0), Noise::unit());
    });
    // The distance fixes x; y is free, and the solver says so though it converges.
    let free = graph.optimize(&values, &SolveOptions::default()).unwrap().unconstrained.unwrap();
    assert_eq!((free.directions, free.variables, free.more), (1, 1, false));
    assert_eq!((free.coordinates[0].variable.label, free.coordinates[0].coordinate), (17, "y"));
    assert!((free.coordinates[0].share - 1.0).abs() < 1e-6);
    let error = graph.marginals(&values).err().unwrap();
    assert!(matches!(&error, GraphError::Unconstrained(_)));
    assert!(error.to_string().contains("y of Rn 17 (100 %)"), "{error}");

    let (graph, values) = landmark(|graph, _, pose, point| {
        graph.add((pose, point), Bearing2::new(0.0), Noise::unit());
    });
    let free = graph.optimize(&values, &SolveOptions::default()).unwrap().unconstrained.unwrap();
    assert_eq!(free.coordinates[0].coordinate, "x");

    // Gauss–Newton cannot even take a step: the same answer, as an error.
    let options =
        SolveOptions { algorithm: boxplus::graph::Algorithm::GaussNewton, ..SolveOptions::default() };
    let (mut graph, mut values) = landmark(|graph, _, pose, point| {
        graph.add((pose, point), Range::new(2.0), Noise::unit());
    });
    let second = values.insert_labelled(Rn::new(vector![0.0, 4.0]), 18);
    let other = values.insert(Rn::new(vector![0.0, 0.0]));
    values.hold(other);
    graph.add((other, second), Range::new(1.0), Noise::unit());
    match graph.optimize(&values, &options) {
        Err(GraphError::Unconstrained(free)) => assert_eq!(free.directions, 2),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_yaw_that_nothing_sees_is_found_in_a_large_graph() {
    let mut walk = walk::<SE2, 3>(26, 300, 200, 0.01);
    let tail = walk.values.insert_labelled(SE2::identity(), 5000);
    let place = walk.truth[150].rplus(&vector![2.0, 0.5, 0.4]);
    // Only the position of the tail is measured, by two ranges.
    for i in [150, 120] {
        let distance = (walk.truth[i].translation() - place.translation()).norm();
        walk.graph.add((walk.keys[i], tail), Range::new(distance), Noise::unit());
    }
    walk.values.set(tail, place).unwrap();
    let free = walk.graph.optimize(&walk.values, &SolveOptions::default()).unwrap();
    let free = free.unconstrained.unwrap();
    assert_eq!(free.directions, 1);
    assert_eq!((free.coordinates[0].variable.label, free.coordinates[0].coordinate), (5000, "yaw"));
}

#[test]
fn a_well_posed_graph_has_no_free_direction_however_long_its_chain() {
    // Its softest bend is 10⁻¹⁷ of its stiffest: below the rounding of JᵀJ, and yet no freedom.
    let walk = walk::<SE2, 3>(27, 30_000, 0, 0.0);
    let solution = walk.graph.optimize(&walk.values, &SolveOptions::default()).unwrap();
    assert!(solution.unconstrained.is_none() && solution.report.converged());
}

#[test]
fn a_weak_prior_is_not_no_prior() {
    let mut walk = walk::<SE2, 3>(28, 100, 0, 0.0);
    let weak = Noise::from_sigmas(&vector![1e3, 1e3, 1e3]).unwrap();
    walk.graph.add((walk.keys[0],), Prior { mean: walk.truth[0] }, weak);
    let sigma = walk.graph.marginals(&walk.values).unwrap().covariance(walk.keys[0]).unwrap()[(2, 2)].sqrt();
    // Its curvature is 10⁻¹² of the chain's: that leaves JᵀJ four digits, 10⁻¹⁶/10⁻¹².
    assert!((sigma / 1e3 - 1.0).abs() < 1e-3, "{sigma}");
}

#[test]
fn where_nothing_is_free_all_is_known() {
    let (mut graph, mut values) = (Graph::new(), Values::new());
    assert!(graph.marginals(&values).is_ok());
    let x = values.insert(SE2::identity());
    values.hold(x);
    graph.add((x,), Prior { mean: SE2::identity() }, Noise::unit());
    assert_eq!(graph.marginals(&values).unwrap().covariance(x).unwrap().amax(), 0.0);
}

#[test]
fn covariances_are_asked_of_known_variables_only() {
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let (a, lonely) = (values.insert(SE2::identity()), values.insert_labelled(SE2::identity(), 8));
    graph.add((a,), Prior { mean: SE2::identity() }, Noise::unit());
    let mut marginals = graph.marginals(&values).unwrap();
    assert!(marginals.covariance(a).is_ok());
    assert!(
        matches!(marginals.covariance(lonely), Err(GraphError::Unread { variable }) if variable.label == 8)
    );
    let foreign = Values::new().insert(Rn::new(Vector2::zeros()));
    assert!(matches!(marginals.covariance(foreign), Err(GraphError::ForeignKey { .. })));
}

#[test]
fn sightings_place_landmarks_and_their_covariance_grows_with_the_pose() {
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let (x, p) = (values.insert(SE2::identity()), values.insert(Rn::new(vector![9.0, 9.0])));
    graph.add((x,), Prior { mean: SE2::identity() }, Noise::from_sigmas(&vector![0.1, 0.1, 0.2]).unwrap());
    let seen = Sighting2 { measured: vector![10.0, 0.0] };
    graph.add((x, p), seen, Noise::from_sigmas(&vector![0.3, 0.3]).unwrap());
    let solution = graph.optimize(&values, &SolveOptions::default()).unwrap();
    assert!((solution.values.get(p).unwrap().vector() - vector![10.0, 0.0]).amax() < 1e-8);
    let covariance = graph.marginals(&solution.values).unwrap().covariance(p).unwrap();
    // σ² of the sighting, of the position, and 10 m times σ of the heading across the line of sight.
    assert!((covariance[(0, 0)] - (0.09 + 0.01)).abs() < 1e-9, "{covariance}");
    assert!((covariance[(1, 1)] - (0.09 + 0.01 + 4.0)).abs() < 1e-7, "{covariance}");
}
