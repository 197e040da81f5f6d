//! The sphere of directions.

use crate::EPS;
use crate::table::{Table, error, within};
use boxplus::lie::{LieError, LieGroup, Manifold, Real, S2, SO3, laws};
use nalgebra::{Matrix2, SMatrix, SVector, Vector2, Vector3};
use proptest::prelude::*;
use std::f64::consts::PI;

const TABLE: &str = include_str!("../reference/sphere.csv");

fn direction<S: Real>(x: f64, y: f64, z: f64) -> S2<S> {
    S2::from_vector(&Vector3::new(x, y, z).map(S::lit)).unwrap()
}

#[test]
fn directions_pass_the_axioms_of_a_manifold() {
    // Differences of order h⁴ are as good as the fifth derivative is small: not near −z, nor near the antipode. Dual numbers
    // and the table go there.
    let points = [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.3, 0.7, -0.2), (-1.0, 0.4, 0.5)];
    laws::check_manifold(&points.map(|(x, y, z)| direction::<f64>(x, y, z)), 2.0).unwrap();
    laws::check_manifold(&points.map(|(x, y, z)| direction::<f32>(x, y, z)), 2.0).unwrap();
}

/// By rows, as the table has it.
fn by_rows(m: [f64; 4]) -> Matrix2<f64> {
    Matrix2::from_row_slice(&m)
}

/// The largest errors in ε of plus, minus and the four Jacobians; those of ⊟ in multiples of its condition π/(π − |τ|).
fn exact_errors<S: Real>() -> [f64; 6] {
    let mut worst = [0.0_f64; 6];
    for row in Table::parse(TABLE).rows() {
        let n = S2::from_vector(&row.vector::<S, 3>("start")).unwrap();
        let tau = row.vector::<S, 2>("tau");
        let (y, d_n, d_tau) = n.plus_jac(&tau);
        let m = S2::from_vector(&row.vector::<S, 3>("other")).unwrap();
        let (step, e_m, e_n) = m.minus_jac(&n);
        // How fast the bases turn at either end multiplies rounding: 1/(distance from −z).
        let spin = |d: &S2<S>| 1.0 + 2.0 / (d.vector() + Vector3::z()).norm().value().max(1e-9);
        let condition = PI / (PI - step.norm().value());
        let turns = spin(&n) + spin(&y);
        let errors = [
            error(&y.vector(), &row.vector("plus"), spin(&n)),
            error(&step, &row.vector("minus"), condition * spin(&n)),
            error(&d_n, &by_rows(row.get("d_start")), turns * by_rows(row.get("d_start")).norm().max(1.0)),
            error(&d_tau, &by_rows(row.get("d_tau")), turns),
            error(&e_m, &by_rows(row.get("e_other")), turns * condition * condition),
            error(&e_n, &by_rows(row.get("e_start")), turns * condition * condition * spin(&n)),
        ];
        worst = std::array::from_fn(|i| worst[i].max(errors[i]));
    }
    worst
}

#[test]
fn steps_and_their_jacobians_are_right_to_the_last_digits() {
    for (scalar, errors) in [("f64", exact_errors::<f64>()), ("f32", exact_errors::<f32>())] {
        let names = ["plus", "minus", "plus in n", "plus in τ", "minus in m", "minus in n"];
        for (name, error) in names.into_iter().zip(errors) {
            within(&format!("S² {name} {scalar}"), error, 6.0);
        }
    }
}

#[test]
fn at_zero_and_at_the_antipode_the_step_is_as_documented() {
    for n in [direction::<f64>(0.0, 0.0, 1.0), direction(0.0, 0.0, -1.0), direction(0.3, -0.5, 0.2)] {
        assert_eq!(n.minus(&n), Vector2::zeros());
        assert_eq!(n.plus(&Vector2::zeros()), n);
        assert!(((-n).minus(&n) - Vector2::new(PI, 0.0)).norm() < 4.0 * PI * EPS);
        assert!((n.plus(&(-n).minus(&n)).vector() + n.vector()).norm() < 4.0 * EPS);
        let (value, d_m, d_n) = n.minus_jac(&n);
        assert!(
            (d_m - Matrix2::identity()).amax() < 4.0 * EPS && (d_n + Matrix2::identity()).amax() < 4.0 * EPS
        );
        assert_eq!(value, Vector2::zeros());
    }
    // Tiny steps keep their digits.
    let n = direction::<f64>(0.0, 0.0, 1.0);
    let tau = Vector2::new(3e-13, -4e-13);
    assert!((n.plus(&tau).minus(&n) - tau).norm() < 2.0 * EPS * tau.norm());
}

#[test]
fn the_basis_is_right_handed_everywhere_and_at_its_one_singular_point() {
    let mut points = vec![direction::<f64>(0.0, 0.0, -1.0), direction(0.0, 0.0, 1.0)];
    for e in 0..20 {
        let r = 10.0_f64.powi(-e);
        points.extend([
            direction(r, 0.3 * r, -1.0),
            direction(-r, r, -1.0),
            direction(0.0, -r, -1.0),
            direction(r, r, 1.0),
        ]);
    }
    for n in points {
        let b = n.basis();
        // Entries up to 2 carry four roundings.
        assert!((b.transpose() * b - Matrix2::identity()).amax() < 8.0 * EPS, "{n:?}");
        assert!((b.column(0).cross(&b.column(1)) - n.vector()).norm() < 8.0 * EPS, "{n:?}");
    }
    let south = direction::<f64>(0.0, 0.0, -1.0).basis();
    assert_eq!(south, SMatrix::<f64, 3, 2>::new(-1.0, 0.0, 0.0, 1.0, 0.0, 0.0));
    let south = direction::<f32>(0.0, 0.0, -1.0).basis();
    assert_eq!(south, SMatrix::<f32, 3, 2>::new(-1.0, 0.0, 0.0, 1.0, 0.0, 0.0));
    assert_eq!(direction::<f64>(0.0, 0.0, 1.0).basis().row(0)[0], 1.0);
}

#[test]
fn what_is_no_direction_is_refused() {
    assert_eq!(S2::from_vector(&Vector3::<f64>::zeros()), Err(LieError::Zero));
    assert_eq!(S2::from_vector(&Vector3::new(1.0, f64::NAN, 0.0)), Err(LieError::NotFinite));
    assert_eq!(direction::<f64>(1e-300, 0.0, 0.0), direction(1e300, 0.0, 0.0));
}

fn vectors<const N: usize>() -> impl Strategy<Value = SVector<f64, N>> {
    prop::array::uniform(-1.0..1.0_f64).prop_map(|a: [f64; N]| SVector::from(a))
}

proptest! {
    #[test]
    fn rotations_act_transitively_and_preserve_distance(a in vectors::<3>(), b in vectors::<3>(), phi in vectors::<3>()) {
        prop_assume!(a.norm() > 0.1 && b.norm() > 0.1);
        let (m, n, r) = (direction::<f64>(a.x, a.y, a.z), direction::<f64>(b.x, b.y, b.z), SO3::exp(&(phi * 3.0)));
        prop_assert!(((m.rotation_to(&n).unwrap() * m).vector() - n.vector()).norm() < 8.0 * EPS);
        prop_assert!(((r * m).angle_to(&(r * n)) - m.angle_to(&n)).abs() < 16.0 * EPS);
        // The columns of a basis are unit within 4 ε, an angle is at most π.
        prop_assert!((m.minus(&n).norm() - m.angle_to(&n)).abs() < 16.0 * EPS);
        prop_assert!((m.chordal_distance(&n) - 2.0 * (m.angle_to(&n) / 2.0).sin()).abs() < 8.0 * EPS);
        prop_assert!((m.angle_to(&-n) + m.angle_to(&n) - PI).abs() < 4.0 * EPS);
        prop_assert!(((SO3::identity() * m).vector() - m.vector()).norm() < 2.0 * EPS);
    }
}

#[test]
fn a_million_steps_stay_on_the_sphere() {
    let mut n = direction::<f64>(0.3, 0.5, -0.2);
    let r = SO3::exp(&Vector3::new(0.3, -0.2, 0.5));
    for i in 0..1_000_000 {
        n = r * n.plus(&Vector2::new(f64::from(i).sin(), 0.3));
    }
    assert!((n.vector().norm() - 1.0).abs() < 4.0 * EPS);
}

#[cfg(feature = "autodiff")]
#[test]
fn jacobians_are_those_of_dual_numbers_without_nan_at_zero_and_near_the_poles() {
    use crate::parametrisations::dual::{constant, derivatives, unknown};
    let lift = |n: S2| Manifold::map(&n, Real::lit);
    let points = [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (1e-3, 2e-3, -1.0), (0.3, 0.7, -0.2), (-1.0, 0.4, 0.5)];
    for (k, (x, y, z)) in points.into_iter().enumerate() {
        let n = direction::<f64>(x, y, z);
        for length in [0.0, 1e-12, 1e-6, 0.01, 0.7, 2.0, 3.0, PI - 1e-3] {
            let tau = Vector2::new((k as f64).cos(), (k as f64).sin()) * length;
            let (y, d_n, d_tau) = n.plus_jac(&tau);
            // Where a basis turns by 2/r within r, rounding counts as often.
            let spin = 1.0 + 2.0 / (y.vector() + Vector3::z()).norm().max(1e-3);
            let close = |name: &str, dual: Matrix2<f64>, closed: Matrix2<f64>| {
                let bound = 64.0 * EPS * spin * (1.0 + closed.norm() * (1.0 + closed.norm()));
                assert!((dual - closed).amax() < bound, "{name} at {n:?} {tau}: {dual}{closed}");
            };
            let dual = lift(n).plus(&(constant(&tau) + unknown())).minus(&lift(y));
            close("plus in τ", derivatives(&dual), d_tau);
            let (_, e_y, e_n) = y.minus_jac(&n);
            close("minus in m", derivatives(&lift(y).plus(&unknown()).minus(&lift(n))), e_y);
            if z > -1.0 || x != 0.0 {
                let dual = lift(n).plus(&unknown()).plus(&constant(&tau)).minus(&lift(y));
                close("plus in n", derivatives(&dual), d_n);
                close("minus in n", derivatives(&lift(y).minus(&lift(n).plus(&unknown()))), e_n);
            }
            let r = SO3::exp(&Vector3::new(0.3, -1.2, 0.8));
            let rc: SO3<crate::parametrisations::dual::Dual<3>> = LieGroup::map(&r, Real::lit);
            let (moved, d_r, d_n) = n.rotated_by_jac(&r);
            let dual = (rc.rplus(&unknown()) * Manifold::map(&n, Real::lit))
                .minus(&Manifold::map(&moved, Real::lit));
            assert!((derivatives(&dual) - d_r).amax() < 64.0 * EPS);
            let dual = (LieGroup::map(&r, Real::lit) * lift(n).plus(&unknown())).minus(&lift(moved));
            close("R·n in n", derivatives(&dual), d_n);
        }
    }
}
