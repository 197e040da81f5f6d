use crate::support::*;
use boxplus::lie::{Action, LieGroup, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3};
use boxplus::trajectory::{
    BSpline, Motion, PointMotion, body_velocity, global_error_dynamics, global_error_integral,
    global_error_transition, local_error_dynamics, local_error_integral, local_error_transition,
    rate_from_body, rate_from_spatial, spatial_velocity,
};
use nalgebra::{SMatrix, SVector, Vector3, Vector6};

fn rates_and_coordinates<G: LieGroup<D, Scalar = f64>, const D: usize>() {
    let coordinates = |t: f64| draw::<D>(1) + draw::<D>(2) * t + draw::<D>(3) * (t * t);
    for t in [0.0, 0.3] {
        let (tau, rate, second) =
            (coordinates(t), draw::<D>(2) + draw::<D>(3) * (2.0 * t), draw::<D>(3) * 2.0);
        let x = G::exp(&tau);
        let body = difference(t, |s| G::exp(&coordinates(s)).rminus(&x));
        let spatial = difference(t, |s| G::exp(&coordinates(s)).lminus(&x));
        close("ω = J_r τ̇", &body_velocity::<G, D>(&tau, &rate), &body, 1e-10);
        close("ϖ = J_l τ̇", &spatial_velocity::<G, D>(&tau, &rate), &spatial, 1e-10);
        close("τ̇ from ω", &rate_from_body::<G, D>(&tau, &body), &rate, 1e-10);
        close("τ̇ from ϖ", &rate_from_spatial::<G, D>(&tau, &spatial), &rate, 1e-10);

        let motion = Motion::<G, D>::from_coordinates(&[tau, rate, second, SVector::zeros()]);
        let bend = difference(t, |s| {
            body_velocity::<G, D>(&coordinates(s), &(draw::<D>(2) + draw::<D>(3) * (2.0 * s)))
        });
        close("ω̇ = J_r τ̈ + (d/dt J_r)τ̇", &motion.acceleration, &bend, 1e-10);
        let bend = difference(t, |s| {
            let rate = draw::<D>(2) + draw::<D>(3) * (2.0 * s);
            Motion::<G, D>::from_coordinates(&[coordinates(s), rate, second, SVector::zeros()]).acceleration
        });
        close("jerk", &motion.jerk, &bend, 1e-10);
        let back = motion.coordinates();
        for (a, b) in back.iter().zip([tau, rate, second, SVector::zeros()]) {
            close("back to coordinates", a, &b, 200.0 * EPS);
        }
        let (spatial, d_spatial) = motion.spatial();
        close("ϖ = Ad_X ω", &spatial, &spatial_velocity::<G, D>(&tau, &rate), 32.0 * EPS);
        let change = difference(t, |s| {
            spatial_velocity::<G, D>(&coordinates(s), &(draw::<D>(2) + draw::<D>(3) * (2.0 * s)))
        });
        close("ϖ̇ = Ad_X ω̇", &d_spatial, &change, 1e-9);
    }
}

#[test]
fn rates_of_bodies_and_of_coordinates_are_each_others_image() {
    rates_and_coordinates::<SO2, 1>();
    rates_and_coordinates::<SE2, 3>();
    rates_and_coordinates::<SO3, 3>();
    rates_and_coordinates::<SE3, 6>();
    rates_and_coordinates::<SE23, 9>();
    rates_and_coordinates::<SGal3, 10>();
    rates_and_coordinates::<Sim3, 7>();
}

fn products<G: LieGroup<D, Scalar = f64>, const D: usize>() {
    // Two curves of which every rate is known; product and inverse differentiated numerically, one order after the other.
    let (a, b): ([G; 9], [G; 9]) = (walk(1, 0.4), walk(2, 0.4));
    let (a, b) =
        (BSpline::<_, D, 5>::new(&a, 0.0, 1.0).unwrap(), BSpline::<_, D, 5>::new(&b, 0.0, 1.0).unwrap());
    let product = |t: f64| a.at(t).unwrap().then(&b.at(t).unwrap());
    let inverse = |t: f64| a.at(t).unwrap().inverse();
    let mount = G::exp(&draw(4));
    let sensor = |t: f64| a.at(t).unwrap().of_frame(&mount);
    let curves: [&dyn Fn(f64) -> Motion<G, D>; 3] = [&product, &inverse, &sensor];
    for curve in curves {
        let now = curve(1.5);
        close("velocity", &now.velocity, &difference(1.5, |t| curve(t).value.rminus(&now.value)), 1e-10);
        close("acceleration", &now.acceleration, &difference(1.5, |t| curve(t).velocity), 1e-10);
        close("jerk", &now.jerk, &difference(1.5, |t| curve(t).acceleration), 1e-10);
    }
}

#[test]
fn products_and_inverses_of_motions_have_the_rates_of_products_and_inverses() {
    products::<SE2, 3>();
    products::<SO3, 3>();
    products::<SE3, 6>();
    products::<SGal3, 10>();
    products::<Sim3, 7>();
}

fn transports<G: Action<D, N, Scalar = f64>, const D: usize, const N: usize>() {
    let controls: [G; 8] = walk(5, 0.4);
    let curve = BSpline::<_, D, 5>::new(&controls, 0.0, 1.0).unwrap();
    // A point that moves in the body, with time in its last coordinate where the group has events.
    let (p, v, a) = (draw::<N>(1), draw::<N>(2), draw::<N>(3));
    let point = |t: f64| PointMotion {
        position: p + v * t + a * (t * t / 2.0),
        velocity: v + a * t,
        acceleration: a,
    };
    for inverted in [false, true] {
        let seen = |t: f64| {
            let motion = curve.at(t).unwrap();
            (if inverted { motion.inverse() } else { motion }).act(&point(t))
        };
        let now = seen(1.3);
        close("velocity", &now.velocity, &difference(1.3, |t| seen(t).position), 1e-10);
        close("acceleration", &now.acceleration, &difference(1.3, |t| seen(t).velocity), 1e-10);
    }
}

#[test]
fn transport_gives_the_velocity_and_acceleration_of_points_in_the_other_frame() {
    transports::<SO2, 1, 2>();
    transports::<SE2, 3, 2>();
    transports::<SE2, 3, 3>();
    transports::<SO3, 3, 3>();
    transports::<SE3, 6, 3>();
    transports::<SE3, 6, 4>();
    transports::<SE23, 9, 3>();
    transports::<SGal3, 10, 4>();
    transports::<Sim2, 4, 2>();
    transports::<Sim3, 7, 3>();
}

#[test]
fn a_fixed_world_point_seen_from_the_body_moves_against_it() {
    // Barfoot (2024) (8.36), in our frames: ṗ = −(ρ + φ×p).
    let omega = Vector6::new(1.0, -0.5, 0.2, 0.3, 0.1, -0.7);
    let motion = Motion::steady(SE3::exp(&draw(6)), omega);
    let seen = motion.inverse().act(&PointMotion::fixed(Vector3::new(3.0, 1.0, -2.0)));
    let (rho, phi) = (omega.fixed_rows::<3>(0), omega.fixed_rows::<3>(3));
    let expected = -(rho + phi.cross(&seen.position));
    close("ṗ", &seen.velocity, &expected, 16.0 * EPS);
}

fn errors_travel<G: LieGroup<D, Scalar = f64>, const D: usize>() {
    let omega = draw::<D>(7);
    let x = |t: f64| G::exp(&draw(8)).rplus(&(omega * t));
    let (s, t) = (0.2, 1.1);
    let xi = draw::<D>(9) * 0.3;
    // Finite errors travel linearly, exactly.
    let later = x(s).rplus(&xi).rplus(&(omega * (t - s))).rminus(&x(t));
    close("local Φ", &later, &(local_error_transition(&x(s), &x(t)) * xi), 64.0 * EPS);
    let spatial = x(s).adjoint() * omega;
    let later = x(s).lplus(&xi).lplus(&(spatial * (t - s))).lminus(&x(t));
    close("global Φ", &later, &(global_error_transition(&x(s), &x(t)) * xi), 64.0 * EPS);
    // Φ solves its differential equation, from I.
    let column = |i: usize| {
        let e = unit::<D>(i);
        let local = difference(t, |t| local_error_transition(&x(s), &x(t)) * e);
        let global = difference(t, |t| global_error_transition(&x(s), &x(t)) * e);
        let (phi, psi) =
            (local_error_transition(&x(s), &x(t)) * e, global_error_transition(&x(s), &x(t)) * e);
        close("local dynamics", &local, &(local_error_dynamics::<G, D>(&omega) * phi), 1e-10);
        close("global dynamics", &global, &(global_error_dynamics::<G, D>(&spatial) * psi), 1e-10);
    };
    (0..D).for_each(column);
    // ∫Φ is what a constant error of the velocity does, to first order: differences in δω.
    let duration = 0.9;
    let mut numeric = [SMatrix::<f64, D, D>::zeros(); 2];
    for i in 0..D {
        let e = unit::<D>(i);
        let truth = G::exp(&(omega * duration));
        let local = difference(0.0, |d| G::exp(&((omega + e * d) * duration)).rminus(&truth));
        let global = difference(0.0, |d| G::exp(&((omega + e * d) * duration)).lminus(&truth));
        numeric[0].set_column(i, &local);
        numeric[1].set_column(i, &global);
    }
    close("local ∫Φ", &local_error_integral::<G, D>(&omega, duration), &numeric[0], 1e-10);
    close("global ∫Φ", &global_error_integral::<G, D>(&omega, duration), &numeric[1], 1e-10);
}

#[test]
fn transition_matrices_carry_errors_on_both_sides() {
    errors_travel::<SO3, 3>();
    errors_travel::<SE2, 3>();
    errors_travel::<SE3, 6>();
    errors_travel::<SE23, 9>();
    errors_travel::<SGal3, 10>();
    errors_travel::<Sim3, 7>();
}
