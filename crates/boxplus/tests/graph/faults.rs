//! Faulty graphs are refused with the reason and the place.

use boxplus::graph::{
    Between, Factor, Graph, GraphError, Initial, Kernel, Noise, Prior, SolveOptions, Values,
};
use boxplus::lie::{LieGroup, Real, Rn, SE2};
use nalgebra::{SVector, vector};

fn pair() -> (Graph, Values, boxplus::graph::Key<SE2>, boxplus::graph::Key<SE2>) {
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let (a, b) = (values.insert_labelled(SE2::identity(), 10), values.insert_labelled(SE2::identity(), 11));
    graph.add((a, b), Between::new(SE2::new(vector![1.0, 0.0], 0.0)), Noise::unit());
    (graph, values, a, b)
}

#[test]
fn a_variable_without_a_value_is_named() {
    let (mut graph, mut values, a, _) = pair();
    let missing = values.declare::<SE2>(42);
    graph.add((a, missing), Between::new(SE2::identity()), Noise::unit());
    match graph.optimize(&values, &SolveOptions::default()) {
        Err(GraphError::MissingValues { variables }) => assert_eq!(variables[0].label, 42),
        other => panic!("{other:?}"),
    }
    let unread = values.declare::<SE2>(43);
    values.set(missing, SE2::identity()).unwrap();
    assert!(graph.optimize(&values, &SolveOptions::default()).is_ok(), "no factor reads {unread:?}");
}

#[test]
fn a_value_that_is_not_finite_is_named() {
    for bad in [f64::NAN, f64::INFINITY] {
        let (graph, mut values, _, b) = pair();
        values.set(b, SE2::new(vector![bad, 0.0], 0.0)).unwrap();
        match graph.optimize(&values, &SolveOptions::default()) {
            Err(GraphError::ValueNotFinite { variable }) => assert_eq!(variable.label, 11),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_measurement_that_is_not_finite_is_named_with_what_it_reads() {
    let (mut graph, values, a, b) = pair();
    graph.add((b, a), Between::new(SE2::new(vector![f64::NAN, 0.0], 0.0)), Noise::unit());
    match graph.optimize(&values, &SolveOptions::default()) {
        Err(error @ GraphError::ResidualNotFinite { .. }) => {
            assert!(error.to_string().contains("displacement of SE2 11, SE2 10"), "{error}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_key_of_other_values_is_refused() {
    let (mut graph, values, a, _) = pair();
    let mut others = values.clone();
    let foreign = others.insert(SE2::identity());
    graph.add((a, foreign), Between::new(SE2::identity()), Noise::unit());
    assert!(matches!(graph.cost(&values), Err(GraphError::ForeignKey { number: 2, .. })));
    assert!(graph.cost(&others).is_ok());
    for initial in [Initial::Auto, Initial::SpanningTree, Initial::Chordal] {
        assert!(matches!(
            graph.initialise(&values, initial),
            Err(GraphError::ForeignKey { kind: "SE2", .. })
        ));
    }
    let mut empty = Values::new();
    assert!(matches!(empty.set(a, SE2::identity()), Err(GraphError::ForeignKey { .. })));
}

/// A residual that is defined on one side only: log x.
#[derive(Clone)]
struct Logarithm;
impl Factor<1> for Logarithm {
    const NAME: &'static str = "logarithm";
    type Variables = (Rn<1>,);
    fn residual<S: Real>(&self, (x,): &(Rn<1, S>,)) -> SVector<S, 1> {
        vector![x.vector()[0].simd_ln() + S::lit(2.0)]
    }
}

#[test]
fn a_step_into_undefined_ground_is_rejected_not_fatal() {
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let x = values.insert(Rn::new(vector![3.0])); // Gauss–Newton would step to −6.3
    graph.add((x,), Logarithm, Noise::unit());
    let solution = graph.optimize(&values, &SolveOptions::default()).unwrap();
    assert!(solution.report.converged());
    assert!((solution.values.get(x).unwrap().vector()[0] - (-2.0f64).exp()).abs() < 1e-9);
    assert!(solution.report.iterations.iter().any(|iteration| !iteration.accepted));
}

/// Finite everywhere it is evaluated, but with an infinite slope at zero: √x.
#[derive(Clone)]
struct Root;
impl Factor<1> for Root {
    const NAME: &'static str = "root";
    type Variables = (Rn<1>,);
    fn residual<S: Real>(&self, (x,): &(Rn<1, S>,)) -> SVector<S, 1> {
        vector![x.vector()[0].simd_sqrt() - S::lit(1.0)]
    }
}

#[test]
fn a_derivative_that_is_not_finite_is_no_minimum() {
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let x = values.insert(Rn::new(vector![0.0]));
    graph.add((x,), Root, Noise::unit());
    let report = graph.optimize(&values, &SolveOptions::default()).unwrap().report;
    assert!(!report.converged(), "{:?}", report.termination);
}

#[test]
fn a_measurement_that_is_not_finite_is_named_before_it_spreads() {
    let (mut graph, mut values, _, b) = pair();
    let c = values.declare::<SE2>(12);
    graph.add((b, c), Between::new(SE2::new(vector![f64::NAN, 0.0], 0.0)), Noise::unit());
    match graph.initialise(&values, Initial::SpanningTree) {
        Err(error @ GraphError::ResidualNotFinite { .. }) => {
            assert!(error.to_string().contains("SE2 11, SE2 12"));
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_held_variable_must_have_a_value() {
    let (mut graph, mut values, a, _) = pair();
    let held = values.declare::<SE2>(12);
    values.hold(held);
    graph.add((a, held), Between::new(SE2::identity()), Noise::unit());
    assert!(matches!(graph.initialise(&values, Initial::Auto), Err(GraphError::MissingValues { .. })));
}

#[test]
fn kernels_without_a_scale_are_refused() {
    for kernel in [
        Kernel::Huber(0.0),
        Kernel::Cauchy(f64::NAN),
        Kernel::Dcs(-1.0),
        Kernel::Barron { alpha: 3.0, scale: 1.0 },
    ] {
        let (mut graph, values, ..) = pair();
        graph.set_kernel(kernel);
        assert!(matches!(graph.cost(&values), Err(GraphError::InvalidKernel { .. })), "{kernel:?}");
    }
}

#[test]
fn parts_that_nothing_joins_are_listed() {
    let (mut graph, mut values, ..) = pair();
    let (c, d) = (values.insert_labelled(SE2::identity(), 20), values.insert_labelled(SE2::identity(), 21));
    graph.add((d, c), Between::new(SE2::identity()), Noise::unit());
    values.insert_labelled(SE2::identity(), 30); // read by nothing
    let labels =
        |part: &Vec<boxplus::graph::VariableName>| part.iter().map(|name| name.label).collect::<Vec<_>>();
    assert_eq!(graph.parts(&values).iter().map(labels).collect::<Vec<_>>(), [[10, 11], [20, 21]]);
}

#[test]
fn huge_and_tiny_units_do_not_change_the_answer() {
    for scale in [1e-6, 1.0, 1e6] {
        let (mut graph, mut values) = (Graph::new(), Values::new());
        let keys: Vec<_> = (0..4).map(|_| values.insert(Rn::new(vector![0.0, 0.0]))).collect();
        for i in 0..4 {
            let step = Rn::new(vector![scale, 2.0 * scale]);
            let noise = Noise::from_sigmas(&vector![scale, 3.0 * scale]).unwrap();
            graph.add((keys[i], keys[(i + 1) % 4]), Between::new(step), noise);
        }
        graph.add(
            (keys[0],),
            Prior { mean: Rn::identity() },
            Noise::from_sigmas(&vector![scale, scale]).unwrap(),
        );
        let report = graph.optimize(&values, &SolveOptions::default()).unwrap().report;
        assert!(
            report.converged() && (report.cost - 2.0 * (1.0 + 4.0 / 9.0)).abs() < 1e-9,
            "{}",
            report.cost
        );
    }
}

/// Of two numbers only the sum is known.
#[derive(Clone)]
struct Sum;
impl Factor<1> for Sum {
    const NAME: &'static str = "sum";
    type Variables = (Rn<1>, Rn<1>);
    fn residual<S: Real>(&self, (a, b): &(Rn<1, S>, Rn<1, S>)) -> SVector<S, 1> {
        a.vector() + b.vector()
    }
}

#[test]
fn where_only_damping_makes_the_equations_solvable_the_search_still_ends() {
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let point = |x| Rn::new(vector![x]);
    let keys = (values.insert(point(-3.0)), values.insert(point(3.0)));
    // An information of 1e-320 has three digits: JᵀJ is singular, and little damping is lost in rounding.
    graph.add(keys, Sum, Noise::from_sigmas(&vector![1e160]).unwrap());
    let options = SolveOptions { gradient: 0.0, step: 0.0, max_iterations: 20, ..SolveOptions::default() };
    let solution = graph.optimize(&values, &options).unwrap();
    assert!(solution.report.iterations.len() <= 20);
}
