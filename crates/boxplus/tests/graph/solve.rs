//! Minima are minima, whatever the algorithm, the threads, and the gauge.

use std::ops::ControlFlow;

use boxplus::graph::{
    Algorithm, Between, Graph, GroupVariable, Initial, Kernel, Noise, Prior, SolveOptions, Termination,
    Values,
};
use boxplus::lie::{LieGroup, Rn, SE2, SE3, SO2, SO3};
use nalgebra::{SVector, vector};

use crate::world::{Walk, noise, rng, walk};

fn options(algorithm: Algorithm) -> SolveOptions {
    SolveOptions { algorithm, threads: 1, ..SolveOptions::default() }
}

/// No small random move of all free variables lowers the cost.
fn assert_minimum<G: GroupVariable<D>, const D: usize>(walk: &Walk<G>, values: &Values) {
    let cost = walk.graph.cost(values).unwrap();
    let mut rng = rng(1);
    for size in [1e-2, 1e-3, 1e-4] {
        for _ in 0..10 {
            let mut moved = values.clone();
            for &key in &walk.keys[1..] {
                moved.set(key, values.get(key).unwrap().rplus(&noise::<D>(&mut rng, size))).unwrap();
            }
            assert!(walk.graph.cost(&moved).unwrap() > cost);
        }
    }
}

fn all_algorithms_agree<G: GroupVariable<D>, const D: usize>() {
    let walk = walk::<G, D>(3, 60, 40, 0.05);
    let costs = [Algorithm::LevenbergMarquardt, Algorithm::GaussNewton, Algorithm::Dogleg].map(|algorithm| {
        let solution = walk.graph.optimize(&walk.values, &options(algorithm)).unwrap();
        assert!(solution.report.converged(), "{algorithm:?}: {:?}", solution.report.termination);
        assert!(solution.unconstrained.is_none());
        assert_minimum(&walk, &solution.values);
        assert_eq!(solution.report.cost, walk.graph.cost(&solution.values).unwrap());
        solution.report.cost
    });
    assert!(costs.iter().all(|cost| (cost / costs[0] - 1.0).abs() < 1e-9), "{costs:?}");
}

#[test]
fn the_three_algorithms_find_one_minimum_on_every_group() {
    all_algorithms_agree::<Rn<2>, 2>();
    all_algorithms_agree::<SO2, 1>();
    all_algorithms_agree::<SE2, 3>();
    all_algorithms_agree::<SO3, 3>();
    all_algorithms_agree::<SE3, 6>();
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let walk = walk::<SE3, 6>(5, 1500, 1500, 0.02); // more factors than one thread keeps for itself
    let run = |threads| {
        walk.graph.optimize(&walk.values, &SolveOptions { threads, ..SolveOptions::default() }).unwrap()
    };
    let alone = run(1);
    for threads in [2, 3, 7] {
        let several = run(threads);
        assert_eq!(several.report.threads, if cfg!(feature = "parallel") { threads } else { 1 });
        assert_eq!(alone.report.cost.to_bits(), several.report.cost.to_bits());
        for &key in &walk.keys {
            assert_eq!(alone.values.get(key), several.values.get(key));
        }
    }
}

#[test]
fn on_a_linear_problem_every_step_keeps_its_promise_whatever_the_damping() {
    let walk = walk::<Rn<3>, 3>(6, 60, 40, 0.5);
    for algorithm in [Algorithm::LevenbergMarquardt, Algorithm::GaussNewton, Algorithm::Dogleg] {
        for initial_damping in [1e-6, 1e-2, 10.0] {
            let settings = SolveOptions { initial_damping, ..options(algorithm) };
            let report = walk.graph.optimize(&walk.values, &settings).unwrap().report;
            let first = report.iterations[0];
            assert!((first.gain - 1.0).abs() < 1e-9, "{algorithm:?}, {initial_damping}: {}", first.gain);
        }
    }
}

#[test]
fn what_was_solved_before_changes_no_bit() {
    let walk = |start| walk::<SE3, 6>(7, 80, 60, start);
    let bits = |graph: &Graph, values: &Values| {
        let solution = graph.optimize(values, &options(Algorithm::LevenbergMarquardt)).unwrap();
        let costs = solution.report.iterations.iter().map(|iteration| iteration.cost.to_bits());
        costs.collect::<Vec<_>>()
    };
    let (fresh, mut used) = (walk(0.1), walk(0.1));
    used.graph.initialise(&used.values, Initial::Chordal).unwrap();
    used.values.hold(used.keys[3]); // other variables: another analysis
    used.graph.optimize(&used.values, &SolveOptions::default()).unwrap();
    used.graph.marginals(&used.values).unwrap();
    assert_eq!(bits(&used.graph, &fresh.values), bits(&fresh.graph, &fresh.values));
}

#[test]
fn a_held_variable_keeps_its_bits_and_stays_held() {
    let mut walk = walk::<SE3, 6>(6, 30, 10, 0.1);
    let held = walk.keys[7];
    let before = *walk.values.get(held).unwrap();
    walk.values.hold(held);
    let solution = walk.graph.optimize(&walk.values, &SolveOptions::default()).unwrap();
    assert_eq!(solution.values.get(held), Some(&before));
    assert!(solution.values.is_held(held) && solution.report.gauge.is_empty());
    assert_eq!(solution.report.unknowns, 29 * 6);
}

#[test]
fn a_graph_without_anchor_is_given_a_gauge_for_each_part() {
    let mut walk = walk::<SE2, 3>(7, 20, 5, 0.1);
    let (a, b) = (walk.values.insert_labelled(SE2::identity(), 900), walk.values.insert(SE2::identity()));
    walk.graph.add((a, b), Between::new(SE2::new(vector![1.0, 2.0], 0.3)), Noise::unit());
    let solution = walk.graph.optimize(&walk.values, &SolveOptions::default()).unwrap();
    let labels: Vec<_> = solution.report.gauge.iter().map(|name| name.label).collect();
    assert_eq!(labels, [0, 900]);
    assert!(!solution.values.is_held(a), "the gauge is for the solve only");
    assert_eq!(solution.values.get(a), Some(&SE2::identity()));
}

#[test]
fn a_prior_ties_its_part_down() {
    let mut walk = walk::<SE2, 3>(8, 20, 5, 0.1);
    let mean = SE2::new(vector![10.0, -3.0], 1.0);
    walk.graph.add((walk.keys[4],), Prior { mean }, Noise::unit());
    let solution = walk.graph.optimize(&walk.values, &SolveOptions::default()).unwrap();
    assert!(solution.report.gauge.is_empty());
    let error = solution.values.get(walk.keys[4]).unwrap().rminus(&mean);
    assert!(error.amax() < 1e-6, "{error}"); // nothing contradicts the prior
}

#[test]
fn robust_kernels_keep_a_false_closure_from_bending_the_map() {
    let error = |kernel| {
        let mut walk = walk::<SE2, 3>(9, 60, 40, 0.01);
        let lie = Between::new(SE2::new(vector![30.0, 30.0], 2.0));
        let noise = Noise::from_sigmas(&vector![0.02, 0.02, 0.02]).unwrap();
        walk.graph.add((walk.keys[3], walk.keys[40]), lie, noise);
        walk.graph.set_kernel(kernel);
        let solution = walk.graph.optimize(&walk.values, &SolveOptions::default()).unwrap();
        assert!(kernel == Kernel::None || solution.report.converged(), "{:?}", solution.report.termination);
        let origin = |values: &Values, i: usize| {
            values.get(walk.keys[0]).unwrap().between(values.get(walk.keys[i]).unwrap())
        };
        (0..60)
            .map(|i| origin(&solution.values, i).rminus(&walk.truth[0].between(&walk.truth[i])).norm())
            .fold(0.0, f64::max)
    };
    assert!(error(Kernel::None) > 1.0);
    for kernel in [Kernel::Cauchy(1.0), Kernel::GemanMcClure(3.0), Kernel::Tukey(10.0), Kernel::Dcs(3.0)] {
        assert!(error(kernel) < 0.15, "{kernel:?}: {}", error(kernel));
    }
}

#[test]
fn initialisation_recovers_poses_that_were_never_given() {
    let walk = walk::<SE3, 6>(10, 80, 60, 0.0);
    let mut values = Values::new();
    for label in 0..80 {
        values.declare::<SE3>(label);
    }
    for initial in [Initial::Auto, Initial::SpanningTree, Initial::Chordal] {
        let start = walk.graph.initialise(&values, initial).unwrap();
        let solution = walk.graph.optimize(&start.values, &SolveOptions::default()).unwrap();
        let truth = walk.graph.optimize(&walk.values, &SolveOptions::default()).unwrap();
        assert!((solution.report.cost / truth.report.cost - 1.0).abs() < 1e-8, "{initial}");
    }
    let auto = walk.graph.initialise(&values, Initial::Auto).unwrap();
    assert_eq!(auto.costs.len(), 2, "as given is no candidate without values");
    let lowest = auto.costs.iter().map(|&(_, cost)| cost).fold(f64::INFINITY, f64::min);
    assert_eq!(walk.graph.cost(&auto.values).unwrap(), lowest);
}

#[test]
fn initialisation_moves_no_held_variable() {
    let mut walk = walk::<SE3, 6>(11, 40, 30, 0.3);
    let placed = SE3::exp(&SVector::from([5.0, 6.0, 7.0, 0.1, 0.2, 0.3]));
    walk.values.set(walk.keys[9], placed).unwrap();
    walk.values.hold(walk.keys[9]);
    for initial in [Initial::SpanningTree, Initial::Chordal] {
        let start = walk.graph.initialise(&walk.values, initial).unwrap();
        assert_eq!(start.values.get(walk.keys[9]), Some(&placed), "{initial}");
        assert!(
            walk.graph.cost(&start.values).unwrap() < walk.graph.cost(&walk.values).unwrap(),
            "{initial}"
        );
    }
}

#[test]
fn exact_measurements_are_met_to_rounding_by_the_chordal_start_alone() {
    let truth: Vec<SE3> = walk::<SE3, 6>(12, 50, 0, 0.0).truth;
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let keys: Vec<_> = (0..50).map(|label| values.declare::<SE3>(label)).collect();
    for (i, j) in (1..50).map(|j| (j - 1, j)).chain([(0, 49), (10, 30)]) {
        graph.add((keys[i], keys[j]), Between::new(truth[i].between(&truth[j])), Noise::unit());
    }
    let start = graph.initialise(&values, Initial::Chordal).unwrap();
    assert!(graph.cost(&start.values).unwrap() < 1e-20);
}

#[test]
fn the_observer_sees_every_step_and_may_stop_with_the_best_so_far() {
    let walk = walk::<SE2, 3>(13, 60, 40, 0.3);
    let mut seen = vec![];
    let mut observer = |iteration: &boxplus::graph::Iteration| {
        seen.push(*iteration);
        if seen.len() == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let solution =
        walk.graph.optimize_observed(&walk.values, &SolveOptions::default(), &mut observer).unwrap();
    assert_eq!(solution.report.termination, Termination::Interrupted);
    assert_eq!(solution.report.iterations, seen);
    assert_eq!(solution.report.cost, seen[1].cost);
    assert!(seen[1].cost < solution.report.initial_cost);
}

#[test]
fn running_out_of_iterations_is_a_result_with_a_reason() {
    let walk = walk::<SE2, 3>(14, 60, 40, 0.3);
    let options = SolveOptions { max_iterations: 1, ..SolveOptions::default() };
    let report = walk.graph.optimize(&walk.values, &options).unwrap().report;
    assert_eq!(report.termination, Termination::MaxIterations);
    assert!(!report.converged() && report.iterations.len() == 1);
}

#[test]
fn nothing_to_solve_is_solved() {
    let values = Values::new();
    let report = Graph::new().optimize(&values, &SolveOptions::default()).unwrap().report;
    assert_eq!((report.termination, report.cost), (Termination::NothingToSolve, 0.0));

    let (mut graph, mut values) = (Graph::new(), Values::new());
    let (a, lonely) = (values.insert(SO2::from_angle(0.1)), values.insert(SO2::from_angle(0.7)));
    values.hold(a);
    graph.add((a,), Prior { mean: SO2::from_angle(0.4) }, Noise::unit());
    let solution = graph.optimize(&values, &SolveOptions::default()).unwrap();
    assert_eq!(solution.report.termination, Termination::NothingToSolve);
    assert_eq!(solution.report.unread.len(), 1);
    assert_eq!(solution.values.get(lonely), Some(&SO2::from_angle(0.7)));
}

#[test]
fn a_factor_may_read_one_variable_twice() {
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let x = values.insert(Rn::new(vector![3.0, 1.0]));
    graph.add((x,), Prior { mean: Rn::new(vector![1.0, 2.0]) }, Noise::unit());
    graph.add((x, x), Between::new(Rn::new(vector![0.5, 0.0])), Noise::unit()); // constant 0.5, no derivative
    let solution = graph.optimize(&values, &SolveOptions::default()).unwrap();
    assert!((solution.values.get(x).unwrap().vector() - vector![1.0, 2.0]).amax() < 1e-9);
    assert!((solution.report.cost - 0.125).abs() < 1e-12);
}

#[test]
fn units_of_one_part_do_not_change_the_answer_of_another() {
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let (far, sharp) = (values.insert(Rn::new(vector![1e7])), values.insert(Rn::new(vector![0.0])));
    graph.add((far,), Prior { mean: Rn::identity() }, Noise::from_sigmas(&vector![1e6]).unwrap());
    graph.add((sharp,), Prior { mean: Rn::identity() }, Noise::from_sigmas(&vector![1e-9]).unwrap());
    let solution = graph.optimize(&values, &SolveOptions::default()).unwrap();
    assert!(solution.report.converged() && solution.report.cost < 1e-15, "{}", solution.report.cost);
}

#[test]
fn a_step_held_short_is_no_sign_of_a_minimum() {
    let walk = walk::<SE2, 3>(16, 40, 20, 0.3);
    let best = walk.graph.optimize(&walk.values, &SolveOptions::default()).unwrap().report.cost;
    for (algorithm, damping, radius) in [
        (Algorithm::LevenbergMarquardt, 1e10, 1.0),
        (Algorithm::LevenbergMarquardt, 0.0, 1.0),
        (Algorithm::LevenbergMarquardt, f64::NAN, 1.0),
        (Algorithm::Dogleg, 1.0, 1e-10),
        (Algorithm::Dogleg, 1.0, 0.0),
        (Algorithm::Dogleg, 1.0, f64::NAN),
        (Algorithm::Dogleg, 1.0, 1.0),
    ] {
        let options = SolveOptions {
            algorithm,
            initial_damping: damping,
            initial_radius: radius,
            ..SolveOptions::default()
        };
        let report = walk.graph.optimize(&walk.values, &options).unwrap().report;
        assert!(
            report.converged() && (report.cost / best - 1.0).abs() < 1e-8,
            "{algorithm:?} {damping} {radius}"
        );
    }
}

#[test]
fn dogleg_steps_stay_within_the_radius_until_the_model_earns_more() {
    let walk = walk::<SE2, 3>(17, 40, 20, 0.5);
    let options =
        SolveOptions { algorithm: Algorithm::Dogleg, initial_radius: 2.0, ..SolveOptions::default() };
    let report = walk.graph.optimize(&walk.values, &options).unwrap().report;
    let newton =
        walk.graph.optimize(&walk.values, &SolveOptions { initial_radius: 1e9, ..options }).unwrap().report;
    // One coordinate moves no further than all together.
    assert!(report.iterations[0].step <= 2.0 && newton.iterations[0].step > 2.0);
    assert!(report.iterations[1].damping > 2.0, "the model was good: {:?}", report.iterations[0]);
    assert!(report.converged() && (report.cost / newton.cost - 1.0).abs() < 1e-8);
}

/// A wall in the cost: Gauss–Newton leaps over it into a valley that is higher.
#[derive(Clone)]
struct Wall;
impl boxplus::graph::Factor<1> for Wall {
    const NAME: &'static str = "wall";
    type Variables = (Rn<1>,);
    fn residual<S: boxplus::lie::Real>(&self, (x,): &(Rn<1, S>,)) -> SVector<S, 1> {
        let x = x.vector()[0];
        // 1 − x/10 on the left, 2 + (x − 10)² on the right.
        vector![S::choose(
            x.simd_lt(S::lit(5.0)),
            || S::lit(1.0) - x * S::lit(0.1),
            || S::lit(2.0) + (x - S::lit(10.0)) * (x - S::lit(10.0))
        )]
    }
}

#[test]
fn where_gauss_newton_climbs_the_better_estimate_is_returned_and_not_called_converged() {
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let x = values.insert(Rn::new(vector![0.0]));
    graph.add((x,), Wall, Noise::unit());
    let solution = graph.optimize(&values, &options(Algorithm::GaussNewton)).unwrap();
    assert_eq!(solution.report.termination, Termination::Diverged);
    assert_eq!((solution.report.cost, solution.values.get(x).unwrap().vector()[0]), (0.5, 0.0));
}

#[test]
fn kernels_that_silence_everything_do_not_make_a_minimum() {
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let x = values.insert(Rn::new(vector![100.0]));
    graph.add_robust((x,), Prior { mean: Rn::identity() }, Noise::unit(), Kernel::Tukey(1.0));
    let solution = graph.optimize(&values, &SolveOptions::default()).unwrap();
    assert_eq!(solution.report.termination, Termination::NoDecrease);
    assert!(solution.unconstrained.is_none());
}

#[test]
fn a_pose_is_held_for_the_gauge_rather_than_a_parameter() {
    #[derive(Clone)]
    struct Biased(SE2);
    impl boxplus::graph::Factor<3> for Biased {
        const NAME: &'static str = "biased odometry";
        const RELATIVE: bool = true;
        type Variables = (SE2, SE2, Rn<4>);
        fn residual<S: boxplus::lie::Real>(
            &self,
            (a, b, bias): &(SE2<S>, SE2<S>, Rn<4, S>),
        ) -> SVector<S, 3> {
            let measured = LieGroup::map(&self.0, S::lit);
            let error = b.rminus(&a.compose(&measured));
            SVector::from_fn(|i, _| error[i] - bias.vector()[i])
        }
    }
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let bias = values.insert(Rn::<4>::identity());
    let poses: Vec<_> = (0..4).map(|i| values.insert_labelled(SE2::identity(), 70 + i)).collect();
    for i in 0..4 {
        graph.add(
            (poses[i], poses[(i + 1) % 4], bias),
            Biased(SE2::new(vector![1.0, 0.0], 1.5)),
            Noise::unit(),
        );
    }
    let report = graph.optimize(&values, &SolveOptions::default()).unwrap().report;
    assert_eq!((report.gauge[0].kind, report.gauge[0].label), ("SE2", 70));
}

#[test]
fn the_surest_prior_is_the_root_of_the_tree() {
    let truth = walk::<SE3, 6>(18, 30, 0, 0.0).truth;
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let keys: Vec<_> = (0..30).map(|label| values.declare::<SE3>(label)).collect();
    for j in 1..30 {
        graph.add((keys[j - 1], keys[j]), Between::new(truth[j - 1].between(&truth[j])), Noise::unit());
    }
    let sigmas = |sigma| Noise::from_sigmas(&SVector::repeat(sigma)).unwrap();
    graph.add((keys[4],), Prior { mean: truth[4] }, sigmas(0.1));
    graph.add((keys[10],), Prior { mean: SE3::identity() }, sigmas(1e6)); // says nothing, and wrongly
    for initial in [Initial::SpanningTree, Initial::Chordal] {
        let start = graph.initialise(&values, initial).unwrap();
        assert!(start.cost() < 1e-8, "{initial}: {}", start.cost());
        assert!(start.values.get(keys[20]).unwrap().rminus(&truth[20]).amax() < 1e-9, "{initial}");
    }
}

#[test]
fn chordal_positions_weigh_the_full_information_in_the_frame_of_the_first_pose() {
    // Two poses, turned; two measurements that disagree, each sure along another axis of the first pose.
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let turned = SE2::new(vector![0.0, 0.0], 0.7);
    let (a, b) = (values.insert(turned), values.declare::<SE2>(1));
    values.hold(a);
    for (t, sigmas) in
        [(vector![1.0, 0.0], vector![0.001, 1.0, 0.1]), (vector![0.0, 2.0], vector![1.0, 0.001, 0.1])]
    {
        graph.add((a, b), Between::new(SE2::new(t, 0.0)), Noise::from_sigmas(&sigmas).unwrap());
    }
    let start = graph.initialise(&values, Initial::Chordal).unwrap();
    let local = turned.between(start.values.get(b).unwrap()).translation();
    assert!((local - vector![1.0, 2.0]).amax() < 1e-5, "{local}");
}

#[test]
fn the_automatic_start_passes_over_what_fails() {
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let keys: Vec<_> = (0..4).map(|label| values.declare::<SE2>(label)).collect();
    for (i, weight) in [(0, 1e-9), (1, 1e9), (2, 1e9)] {
        let noise = Noise::from_information(&nalgebra::SMatrix::from_diagonal_element(weight)).unwrap();
        graph.add((keys[i], keys[i + 1]), Between::new(SE2::new(vector![1.0, 0.0], 0.3)), noise);
    }
    assert!(graph.initialise(&values, Initial::Auto).unwrap().cost() < 1e-12);
}

#[test]
fn a_million_edges_between_two_poses_are_no_burden() {
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let keys = (values.insert(SE2::identity()), values.insert(SE2::identity()));
    let mut rng = rng(15);
    for _ in 0..1_000_000 {
        let measured = SE2::exp(&vector![1.0, 2.0, 0.3]).rplus(&noise(&mut rng, 0.1));
        graph.add(keys, Between::new(measured), Noise::unit());
    }
    let start = graph.initialise(&values, Initial::Auto).unwrap();
    let solution = graph.optimize(&start.values, &SolveOptions::default()).unwrap();
    let error = solution.values.get(keys.1).unwrap().rminus(&SE2::exp(&vector![1.0, 2.0, 0.3]));
    assert!(solution.report.converged() && error.amax() < 4.0 * 0.1 / 3e6f64.sqrt(), "{error}"); // σ/√n, uniform noise
}
