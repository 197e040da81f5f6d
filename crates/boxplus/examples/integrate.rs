//! Which integrator? Error against step, for every method, on a rigid body that tumbles.
//!
//! What its gyro reads is known at every time, so that Magnus expansions apply; where the rate depends on the attitude (a
//! controlled or a rigid body), the first four remain. Errors are angles after ten seconds, against steps of 10⁻⁴ s.
#![expect(clippy::print_stdout, reason = "an example talks")]

use boxplus::lie::{LieGroup, SO3};
use boxplus::trajectory::{Integrator, magnus2, magnus4};
use nalgebra::{Vector3, vector};

const DURATION: f64 = 10.0;
const STEPS: [u32; 5] = [50, 100, 200, 400, 800];

fn gyro(t: f64) -> Vector3<f64> {
    vector![1.2 * (0.9 * t).cos(), 0.8 * (1.7 * t).sin(), 0.5 + 0.3 * (0.4 * t).cos()]
}

/// X₀ followed for the whole time by one exponential per step.
fn by_exponentials(n: u32, omega: impl Fn(f64, f64) -> Vector3<f64>) -> SO3 {
    let h = DURATION / f64::from(n);
    (0..n).fold(SO3::identity(), |x, i| x.rplus(&omega(h * f64::from(i), h)))
}

fn main() {
    let truth = by_exponentials(100_000, |t, h| magnus4::<SO3, 3>(gyro, t, h));
    println!("{:>18} {}  order", "", STEPS.map(|n| format!("{:>9} s", DURATION / f64::from(n))).join(""));
    for method in Integrator::ALL {
        let run = |n| method.integrate(&SO3::identity(), 0.0, DURATION, n, |t, _| gyro(t));
        print(&format!("{method:?}"), &truth, run);
    }
    print("Magnus 2", &truth, |n| by_exponentials(n, |t, h| magnus2::<SO3, 3>(gyro, t, h)));
    print("Magnus 4", &truth, |n| by_exponentials(n, |t, h| magnus4::<SO3, 3>(gyro, t, h)));
    println!(
        "Halving the step divides the error by 2^order. Evaluations of the rate per step: 1, 3, 4, 4, 1, 2."
    );
}

/// One line of errors in radians, and the order that the last two of them show.
fn print(name: &str, truth: &SO3, run: impl Fn(u32) -> SO3) {
    let errors = STEPS.map(|n| run(n).rminus(truth).norm());
    let order = (errors[3] / errors[4]).log2();
    println!("{name:>18} {}  {order:.2}", errors.map(|e| format!("{e:>11.1e}")).join(""));
}
