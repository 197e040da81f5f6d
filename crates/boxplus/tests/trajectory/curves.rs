use crate::support::*;
use boxplus::lie::{LieGroup, Rn, SE2, SE3, SE23, SGal3, SO2, SO3, Sim3};
use boxplus::trajectory::{Bezier, CatmullRom, Hermite, Squad, TrajectoryError, slerp};
use nalgebra::{SVector, Vector1, Vector2, Vector3};
use std::f64::consts::PI;

#[test]
fn bezier_on_vectors_is_the_sum_of_bernstein_polynomials() {
    let controls: [Rn<2>; 5] = std::array::from_fn(|i| Rn::new(draw::<2>(i as u64)));
    let curve = Bezier::new(controls).unwrap();
    for u in [0.0, 0.2, 0.5, 0.9, 1.0, 1.3] {
        let v: f64 = 1.0 - u;
        let bernstein =
            [v.powi(4), 4.0 * u * v.powi(3), 6.0 * u * u * v * v, 4.0 * u * u * u * v, u * u * u * u];
        let sum = controls.iter().zip(bernstein).fold(Vector2::zeros(), |sum, (x, b)| sum + x.vector() * b);
        close("Bernstein", &curve.at(u).value.vector(), &sum, 32.0 * EPS);
    }
}

#[test]
fn bezier_meets_its_ends_and_leaves_along_its_polygon() {
    let controls: [SE3; 4] = walk(3, 0.6);
    let curve = Bezier::new(controls).unwrap();
    let (start, _, leave) = curve.at_jac(0.0);
    let (end, _, arrive) = curve.at_jac(1.0);
    same("start", &start, &controls[0], 4.0 * EPS);
    same("end", &end, &controls[3], 32.0 * EPS);
    close("leaves", &leave, &(controls[1].rminus(&controls[0]) * 3.0), 32.0 * EPS);
    close("arrives", &arrive, &(controls[3].rminus(&controls[2]) * 3.0), 32.0 * EPS);
    let back = Bezier::new([controls[3], controls[2], controls[1], controls[0]]).unwrap();
    same("reversed", &back.at(0.3).value, &curve.at(0.7).value, 64.0 * EPS);
}

#[test]
fn bezier_of_two_is_the_geodesic_and_of_one_a_point() {
    let [x, y]: [SE3; 2] = walk(4, 0.8);
    same("geodesic", &Bezier::new([x, y]).unwrap().at(0.3).value, &x.interpolate(&y, 0.3), 4.0 * EPS);
    same("point", &Bezier::new([x]).unwrap().at(0.3).value, &x, 0.0);
    assert_eq!(Bezier::<SE3, 6, 0>::new([]), Err(TrajectoryError::TooFew { got: 0, needed: 1 }));
}

fn hermite<G: LieGroup<D, Scalar = f64>, const D: usize>(
    seed: u64,
) -> (Hermite<G, D>, [G; 2], [SVector<f64, D>; 2]) {
    let ends: [G; 2] = walk(seed, 0.6);
    let velocities = [draw::<D>(seed + 1) * 0.4, draw::<D>(seed + 2) * 0.4];
    (Hermite::new(ends[0], velocities[0], ends[1], velocities[1], 2.0).unwrap(), ends, velocities)
}

fn hermite_meets_its_ends<G: LieGroup<D, Scalar = f64>, const D: usize>() {
    for seed in 0..20 {
        let (curve, ends, velocities) = hermite::<G, D>(seed);
        for (k, t) in [0.0, 2.0].into_iter().enumerate() {
            let now = curve.at(t);
            same("element", &now.value, &ends[k], 64.0 * EPS);
            close("velocity", &now.velocity, &velocities[k], 64.0 * EPS);
        }
    }
}

#[test]
fn hermite_meets_elements_and_velocities() {
    hermite_meets_its_ends::<SO2, 1>();
    hermite_meets_its_ends::<SO3, 3>();
    hermite_meets_its_ends::<SE2, 3>();
    hermite_meets_its_ends::<SE3, 6>();
    hermite_meets_its_ends::<SE23, 9>();
    hermite_meets_its_ends::<SGal3, 10>();
    hermite_meets_its_ends::<Sim3, 7>();
}

#[test]
fn hermite_on_vectors_is_the_cubic_through_both_ends() {
    // p(t) = 1 + 2t − 3t² + ½t³ and its derivatives.
    let p = |t: f64| 1.0 + t * (2.0 + t * (-3.0 + 0.5 * t));
    let v = |t: f64| 2.0 + t * (-6.0 + 1.5 * t);
    let point = |t: f64| Rn::<1>::new(Vector1::new(p(t)));
    let curve =
        Hermite::new(point(0.0), Vector1::new(v(0.0)), point(2.5), Vector1::new(v(2.5)), 2.5).unwrap();
    for t in [0.0, 0.4, 1.7, 2.5] {
        let now = curve.at(t);
        close("value", &now.value.vector(), &point(t).vector(), 16.0 * EPS);
        close("velocity", &now.velocity, &Vector1::new(v(t)), 16.0 * EPS);
        close("acceleration", &now.acceleration, &Vector1::new(-6.0 + 3.0 * t), 32.0 * EPS);
        close("jerk", &now.jerk, &Vector1::new(3.0), 32.0 * EPS);
    }
}

#[test]
fn hermite_refuses_what_has_no_unique_way() {
    let x = SO3::identity();
    let z = |a: f64| Vector3::new(0.0, 0.0, a);
    let refused = Hermite::new(x, z(0.0), SO3::exp(&z(PI)), z(0.0), 1.0);
    assert_eq!(refused, Err(TrajectoryError::Ambiguous { segment: 0 }));
    // Fast enough velocities cover most of the way.
    assert!(Hermite::new(x, z(2.0), SO3::exp(&z(PI)), z(2.0), 1.0).is_ok());
    let refused = Hermite::new(x, z(f64::NAN), x, z(0.0), 1.0);
    assert_eq!(refused, Err(TrajectoryError::NotFinite { index: 0 }));
    let refused = Hermite::new(x, z(0.0), x, z(0.0), 0.0);
    assert_eq!(refused, Err(TrajectoryError::NotADuration { duration: 0.0 }));
}

#[test]
fn squad_passes_through_its_elements_with_one_velocity() {
    let x: [SE3; 5] = walk(6, 0.5);
    let first = Squad::new([x[0], x[1], x[2], x[3]]).unwrap();
    let second = Squad::new([x[1], x[2], x[3], x[4]]).unwrap();
    let (start, ..) = first.at_jac(0.0);
    let (end, _, arrives) = first.at_jac(1.0);
    let (again, _, leaves) = second.at_jac(0.0);
    same("start", &start, &x[1], 16.0 * EPS);
    same("end", &end, &x[2], 64.0 * EPS);
    same("joint", &again, &x[2], 16.0 * EPS);
    close("one velocity", &arrives, &leaves, 64.0 * EPS);
    // The mean of the two geodesics that meet there.
    close("velocity", &leaves, &((x[3].rminus(&x[2]) + x[2].rminus(&x[1])) * 0.5), 64.0 * EPS);
}

#[test]
fn slerp_turns_at_constant_rate() {
    let [a, b]: [SO3; 2] = walk(8, 1.2);
    let angle = b.rminus(&a).norm();
    for t in [0.0, 0.1, 0.5, 1.0] {
        assert!((slerp(&a, &b, t).rminus(&a).norm() - t * angle).abs() < 8.0 * EPS);
    }
}

#[test]
fn a_path_passes_through_its_elements_without_a_jump_in_velocity() {
    let x: [SE3; 6] = walk(9, 0.5);
    let times = [0.0, 0.5, 1.5, 1.7, 3.0, 4.0];
    let path = CatmullRom::new(&x, &times).unwrap();
    for (i, t) in times.into_iter().enumerate() {
        same("element", &path.at(t).unwrap().value, &x[i], 64.0 * EPS);
    }
    for t in &times[1..5] {
        let (before, after) = (path.at(t - 1e-9).unwrap(), path.at(t + 1e-9).unwrap());
        close("velocity", &before.velocity, &after.velocity, 1e-7);
    }
}

#[test]
fn a_path_on_vectors_has_the_slope_of_the_parabola_through_three_points() {
    // Catmull–Rom reproduces parabolas where neighbours are known.
    let p = |t: f64| Rn::<1>::new(Vector1::new(1.0 - 2.0 * t + 0.7 * t * t));
    let times = [0.0, 0.5, 1.5, 1.7, 3.0];
    let x = times.map(p);
    let path = CatmullRom::new(&x, &times).unwrap();
    for t in [0.5, 0.9, 1.6, 1.7] {
        let now = path.at(t).unwrap();
        close("value", &now.value.vector(), &p(t).vector(), 32.0 * EPS);
        close("slope", &now.velocity, &Vector1::new(-2.0 + 1.4 * t), 64.0 * EPS);
    }
}

#[test]
fn a_path_refuses_bad_times() {
    let x: [SE2; 3] = walk(10, 0.5);
    let refused = |times: &[f64]| CatmullRom::new(&x, times).unwrap_err();
    assert_eq!(refused(&[0.0, 1.0]), TrajectoryError::CountsDiffer { elements: 3, times: 2 });
    assert_eq!(refused(&[0.0, 1.0, 1.0]), TrajectoryError::NotIncreasing { index: 2 });
    assert_eq!(refused(&[0.0, f64::NAN, 1.0]), TrajectoryError::NotFinite { index: 1 });
    assert_eq!(CatmullRom::new(&x[..1], &[0.0]), Err(TrajectoryError::TooFew { got: 1, needed: 2 }));
    let path = CatmullRom::new(&x, &[0.0, 1.0, 2.0]).unwrap();
    assert_eq!(path.at(2.5), Err(TrajectoryError::OutOfRange { time: 2.5, start: 0.0, end: 2.0 }));
}

#[cfg(feature = "autodiff")]
mod dual {
    use super::*;

    const BOUND: f64 = 2000.0 * EPS;

    fn bezier<G: LieGroup<D, Scalar = f64>, const D: usize, const N: usize>() {
        for (seed, size) in [(1, 0.5), (2, 1e-8), (3, 0.0)] {
            let controls: [G; N] = walk(seed, size);
            for u in [0.0, 0.35, 1.0] {
                let (value, jacobians, velocity) = Bezier::new(controls).unwrap().at_jac(u);
                let motion = Bezier::new(controls).unwrap().at(u);
                same("value", &value, &motion.value, 16.0 * EPS);
                for j in 0..N {
                    let mut dual = controls.map(|x| lift::<G, D, D>(&x));
                    dual[j] = moved(&controls[j]);
                    let y = Bezier::new(dual).unwrap().at(Dual::from_re(u));
                    close("control", &jacobians[j], &local(&y.value, &value), BOUND);
                }
                let dual = controls.map(|x| lift::<G, D, 1>(&x));
                rates(&Bezier::new(dual).unwrap().at(Dual::from_re(u).derivative(0)), &motion, BOUND);
                close("velocity", &velocity, &motion.velocity, BOUND);
            }
        }
    }

    fn squad<G: LieGroup<D, Scalar = f64>, const D: usize>() {
        for (seed, size) in [(1, 0.5), (2, 1e-8), (3, 0.0)] {
            let elements: [G; 4] = walk(seed, size);
            for u in [0.0, 0.35, 1.0] {
                let (value, jacobians, velocity) = Squad::new(elements).unwrap().at_jac(u);
                let motion = Squad::new(elements).unwrap().at(u);
                same("value", &value, &motion.value, 16.0 * EPS);
                for j in 0..4 {
                    let mut dual = elements.map(|x| lift::<G, D, D>(&x));
                    dual[j] = moved(&elements[j]);
                    let y = Squad::new(dual).unwrap().at(Dual::from_re(u));
                    close("element", &jacobians[j], &local(&y.value, &value), BOUND);
                }
                let dual = elements.map(|x| lift::<G, D, 1>(&x));
                rates(&Squad::new(dual).unwrap().at(Dual::from_re(u).derivative(0)), &motion, BOUND);
                close("velocity", &velocity, &motion.velocity, BOUND);
            }
        }
    }

    fn hermites<G: LieGroup<D, Scalar = f64>, const D: usize>() {
        for seed in 0..4 {
            let (curve, [a, b], [va, vb]) = hermite::<G, D>(seed);
            for t in [0.0, 0.7, 2.0] {
                let (motion, d) = curve.at_jac(t);
                let at = Dual::<D>::from_re;
                let (ac, bc) = (lift::<G, D, D>(&a), lift::<G, D, D>(&b));
                let (vac, vbc) = (constant(&va), constant(&vb));
                let cases = [
                    ("A", (moved(&a), vac, bc, vbc), d.from),
                    ("v_A", (ac, unknown(&va), bc, vbc), d.velocity_from),
                    ("B", (ac, vac, moved(&b), vbc), d.to),
                    ("v_B", (ac, vac, bc, unknown(&vb)), d.velocity_to),
                ];
                for (name, (a, va, b, vb), closed) in cases {
                    let dual = Hermite::new(a, va, b, vb, at(2.0)).unwrap().at(at(t));
                    answers(name, &dual, &motion.value, &closed, BOUND);
                }
                let at = Dual::<1>::from_re;
                let (a, b) = (lift::<G, D, 1>(&a), lift::<G, D, 1>(&b));
                let dual = Hermite::new(a, constant(&va), b, constant(&vb), at(2.0)).unwrap();
                rates(&dual.at(at(t).derivative(0)), &motion, BOUND);
            }
        }
    }

    fn paths<G: LieGroup<D, Scalar = f64>, const D: usize>() {
        let x: [G; 5] = walk(12, 0.4);
        let times = [0.0, 0.5, 1.5, 1.7, 3.0];
        for t in [0.0, 0.3, 0.9, 1.6, 2.1, 3.0] {
            let (motion, i, jacobians) = CatmullRom::new(&x, &times).unwrap().at_jac(t).unwrap();
            for k in 0..5 {
                let mut dual = x.map(|x| lift::<G, D, D>(&x));
                dual[k] = moved(&x[k]);
                let at = times.map(Dual::<D>::from_re);
                let y = CatmullRom::new(&dual, &at).unwrap().at(Dual::from_re(t)).unwrap();
                let near = (k + 1).checked_sub(i).and_then(|j| jacobians.get(j));
                let closed = near.copied().unwrap_or(boxplus::trajectory::MotionJac {
                    value: nalgebra::SMatrix::zeros(),
                    velocity: nalgebra::SMatrix::zeros(),
                    acceleration: nalgebra::SMatrix::zeros(),
                });
                answers("element", &y, &motion.value, &closed, BOUND);
            }
        }
    }

    #[test]
    fn every_derivative_is_that_of_dual_numbers() {
        bezier::<SO2, 1, 3>();
        bezier::<SO3, 3, 4>();
        bezier::<SE3, 6, 4>();
        bezier::<SGal3, 10, 3>();
        bezier::<Rn<2>, 2, 5>();
        squad::<SO3, 3>();
        squad::<SE2, 3>();
        squad::<SE3, 6>();
        squad::<Sim3, 7>();
        hermites::<SO2, 1>();
        hermites::<SO3, 3>();
        hermites::<SE3, 6>();
        hermites::<SE23, 9>();
        hermites::<SGal3, 10>();
        paths::<SE2, 3>();
        paths::<SE3, 6>();
        paths::<Sim3, 7>();
    }
}
