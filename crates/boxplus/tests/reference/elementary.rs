//! Sine, cosine, exponential and angles, in units in the last place of the truth: of single numbers and of what batches compute with.

use super::judge::{Errors, Table};
use boxplus::lie::Real;

/// Column of the table, name of the bound, value.
fn functions<S: Real>(x: S) -> [(&'static str, &'static str, S); 5] {
    let (sin, cos) = x.sin_cos();
    let arc = S::angle_over_sine(S::one() - x * x, x);
    [
        ("sin", "sin x", sin),
        ("cos", "cos x", cos),
        ("exp", "exp x", x.exp()),
        ("atan", "angle of (1, x)", S::polar_angle(x, S::one())),
        ("arc", "acos w/√(1 − w²)", arc),
    ]
}

/// Errors at the arguments that `S` represents; `over` takes one to the number that is judged.
pub(crate) fn elementary<S: Real, L: Real>(over: impl Fn(S) -> L, errors: &mut Errors) {
    let table = Table::parse(include_str!("elementary.csv"), 1);
    for row in table.rows::<S>() {
        for (column, name, value) in functions(over(S::lit(row.numbers[0]))) {
            let first = row.column(column);
            let (truth, rest) = (row.numbers[first], row.numbers[first + 1]);
            // Not where it is nan, or subnormal or infinite in `S`.
            if (S::lit(truth).value() - truth).abs() <= S::EPSILON * truth.abs() {
                let error = (value.value() - truth) - rest;
                errors.record(name, 0.0, &[S::lit(error)], &[0.0], unit(truth));
            }
        }
    }
}

/// The power of two below |x|: ε times it is one unit in the last place.
fn unit(x: f64) -> f64 {
    x.abs().log2().floor().exp2()
}

/// The numbers inside a batch, which have no other form to fall back on.
#[cfg(feature = "batch")]
mod lanes {
    use super::elementary;
    use crate::bounds::{BOUNDS, Bound};
    use crate::judge::Errors;
    use boxplus::lie::{Number, Real};

    fn inside_a_batch<S: Number>() -> Errors {
        let mut errors = Errors::default();
        elementary::<S, S::Lanes>(S::lanes, &mut errors);
        errors
    }

    #[test]
    fn a_batch_has_elementary_functions_within_the_bounds_of_single_numbers() {
        for (scalar, errors) in [("f64", inside_a_batch::<f64>()), ("f32", inside_a_batch::<f32>())] {
            assert_eq!(errors.0.len(), 5);
            for Bound { name, principal, .. } in BOUNDS.iter().filter(|b| errors.0.contains_key(b.name)) {
                let worst = errors.0[*name][0];
                assert!(worst <= *principal, "{scalar} {name}: {worst:.2} ulp, promised {principal}");
            }
        }
    }

    #[test]
    fn beyond_its_range_an_elementary_function_of_a_batch_is_not_a_number() {
        let exp = |x: f64| f64::of(x.lanes().exp());
        let sin = |x: f64| f64::of(x.lanes().sin_cos().0);
        assert!(exp(707.9).is_finite() && sin(65535.9).is_finite());
        for x in [708.0, -708.0, 1e300, f64::INFINITY, f64::NAN] {
            assert!(exp(x).is_nan(), "exp {x}");
        }
        for x in [65536.0, -65536.0, 1e300, f64::INFINITY, f64::NAN] {
            assert!(sin(x).is_nan(), "sin {x}");
        }
    }
}
