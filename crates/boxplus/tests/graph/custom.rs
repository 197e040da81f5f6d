//! Extension points, used as an outsider would.

use boxplus::graph::{Factor, Graph, Noise, Prior, SolveOptions, Values, dual_jacobians};
use boxplus::lie::{Action, LieGroup, Manifold, Real, Rn, S2, SE2, SE3, SO3};
use nalgebra::{SMatrix, SVector, Vector2, Vector3, vector};

/// A pinhole camera of unknown focal length sees a known point: residual only, two variables of different kinds.
#[derive(Clone)]
struct Projection {
    point: SVector<f64, 3>,
    pixel: Vector2<f64>,
}

impl Factor<2> for Projection {
    const NAME: &'static str = "projection";
    type Variables = (SE3, Rn<1>);
    fn residual<S: Real>(&self, (camera, focal): &(SE3<S>, Rn<1, S>)) -> SVector<S, 2> {
        let p = camera.act_inverse(&self.point.map(S::lit));
        let f = focal.vector()[0];
        vector![f * p.x / p.z, f * p.y / p.z] - self.pixel.map(S::lit)
    }
}

#[test]
fn a_residual_alone_calibrates_a_camera() {
    let (truth, focal) = (SE3::exp(&SVector::from([0.1, -0.2, 0.3, 0.05, 0.1, -0.1])), 500.0);
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let keys = (values.insert(SE3::identity()), values.insert(Rn::new(vector![400.0])));
    for i in 0..12 {
        let angle = f64::from(i);
        let point = vector![2.0 * angle.sin(), 2.0 * angle.cos(), 4.0 + f64::from(i % 4)];
        let p = truth.act_inverse(&point);
        let pixel = vector![focal * p.x / p.z, focal * p.y / p.z];
        graph.add(keys, Projection { point, pixel }, Noise::unit());
    }
    let solution = graph.optimize(&values, &SolveOptions::default()).unwrap();
    assert!(solution.report.converged(), "{:?}", solution.report);
    assert!((solution.values.get(keys.1).unwrap().vector()[0] - focal).abs() < 1e-6);
    assert!(solution.values.get(keys.0).unwrap().rminus(&truth).amax() < 1e-8);
}

/// Differential drive: a displacement by wheel speeds, with the wheel radius as third variable, in closed form.
#[derive(Clone)]
struct Drive {
    turns: f64,
}

impl Factor<2> for Drive {
    const NAME: &'static str = "drive";
    type Variables = (SE2, SE2, Rn<1>);
    fn residual<S: Real>(&self, (a, b, radius): &(SE2<S>, SE2<S>, Rn<1, S>)) -> SVector<S, 2> {
        let step = a.act_inverse(&b.translation());
        vector![step.x - radius.vector()[0] * S::lit(self.turns), step.y]
    }
    fn residual_jac(
        &self,
        (a, b, radius): &(SE2, SE2, Rn<1>),
    ) -> (SVector<f64, 2>, (SMatrix<f64, 2, 3>, SMatrix<f64, 2, 3>, SMatrix<f64, 2, 1>)) {
        let (step, d_step_d_a, d_step_d_t) = a.act_inverse_jac(&b.translation());
        let turn = d_step_d_t * b.rotation().to_matrix();
        let d_step_d_b = SMatrix::<f64, 2, 3>::from_fn(|i, j| if j < 2 { turn[(i, j)] } else { 0.0 });
        let residual = vector![step.x - radius.vector()[0] * self.turns, step.y];
        (residual, (d_step_d_a, d_step_d_b, vector![-self.turns, 0.0]))
    }
}

#[test]
fn a_closed_form_of_three_variables_agrees_with_dual_numbers_and_calibrates() {
    let variables =
        (SE2::exp(&vector![1.0, 2.0, 0.5]), SE2::exp(&vector![2.0, 1.0, -0.7]), Rn::new(vector![0.3]));
    let factor = Drive { turns: 4.0 };
    let (closed, dual) = (factor.residual_jac(&variables).1, dual_jacobians(&factor, &variables));
    assert!((closed.0 - dual.0).amax() + (closed.1 - dual.1).amax() + (closed.2 - dual.2).amax() < 1e-14);

    let (mut graph, mut values) = (Graph::new(), Values::new());
    let radius = values.insert(Rn::new(vector![0.2]));
    let poses: Vec<_> = (0..5).map(|_| values.insert(SE2::identity())).collect();
    for i in 0..4 {
        graph.add((poses[i], poses[i + 1], radius), Drive { turns: 4.0 }, Noise::unit());
    }
    let ends = [(poses[0], SE2::identity()), (poses[4], SE2::new(vector![4.8, 0.0], 0.0))];
    for (key, mean) in ends {
        graph.add((key,), Prior { mean }, Noise::unit());
    }
    let solution = graph.optimize(&values, &SolveOptions::default()).unwrap();
    assert!((solution.values.get(radius).unwrap().vector()[0] - 0.3).abs() < 1e-8);
    // Sideways, six coordinates between the ends face four equations: the zigzags are found.
    assert_eq!(solution.unconstrained.map(|free| free.directions), Some(2));
}

/// The direction of gravity, seen from a body whose attitude is known: a variable that is a manifold but no group.
#[derive(Clone)]
struct Plumb {
    world_from_body: SO3,
    seen: S2,
}

impl Factor<2> for Plumb {
    const NAME: &'static str = "plumb line";
    type Variables = (S2,);
    fn residual<S: Real>(&self, (down,): &(S2<S>,)) -> SVector<S, 2> {
        let world_from_body: SO3<S> = LieGroup::map(&self.world_from_body, S::lit);
        let seen: S2<S> = Manifold::map(&self.seen, S::lit);
        (world_from_body.inverse() * *down).minus(&seen)
    }
    fn residual_jac(&self, (down,): &(S2,)) -> (SVector<f64, 2>, (SMatrix<f64, 2, 2>,)) {
        let (turned, _, d_turned) = down.rotated_by_jac(&self.world_from_body.inverse());
        let (residual, d_residual, _) = turned.minus_jac(&self.seen);
        (residual, (d_residual * d_turned,))
    }
}

#[test]
fn a_direction_is_estimated_on_the_sphere_from_anywhere_on_it() {
    let truth = S2::from_vector(&Vector3::new(0.1, -0.2, -1.0)).unwrap();
    // The basis turns fastest around −z, where the truth is; the start is nearly opposite.
    let start = S2::from_vector(&Vector3::new(0.2, 0.3, 1.0)).unwrap();
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let down = values.insert(start);
    for i in 0..6 {
        let world_from_body = SO3::exp(&Vector3::new(0.3, -0.2, 0.5).scale(f64::from(i)));
        let seen = world_from_body.inverse() * truth;
        let factor = Plumb { world_from_body, seen };
        let (closed, dual) = (factor.residual_jac(&(start,)).1, dual_jacobians(&factor, &(start,)));
        assert!((closed.0 - dual.0).amax() < 1e-12 * closed.0.amax());
        graph.add((down,), factor, Noise::unit());
    }
    let solution = graph.optimize(&values, &SolveOptions::default()).unwrap();
    assert!(solution.report.converged(), "{:?}", solution.report);
    assert!(solution.values.get(down).unwrap().angle_to(&truth) < 1e-8);
}
