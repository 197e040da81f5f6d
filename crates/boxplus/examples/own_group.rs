//! My group is not in the list. How do I write it, and how do I know that it is right?
//!
//! The gain of a sensor is positive, and errors of it are per cent, not units: a group under multiplication, tangent ln g. What is
//! required is written below; means, interpolation, uncertainty, filters and second derivatives follow. `laws` proves it.
#![expect(clippy::print_stdout, reason = "an example talks")]

use boxplus::lie::{Jacobian, LieError, LieGroup, Means, Real, Tangent, Weights, laws};
use nalgebra::{Matrix1, Vector1};

/// A positive number g, tangent ln g. On request with a mistake, such as one makes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Gain<S = f64, const MISTAKE: bool = false>(S);

impl<S: Real, const MISTAKE: bool> LieGroup<1> for Gain<S, MISTAKE> {
    type Scalar = S;
    type Over<T: Real> = Gain<T, MISTAKE>;
    type Algebra = Tangent<S, 1>;

    fn identity() -> Self {
        Self(S::one())
    }
    fn compose(&self, rhs: &Self) -> Self {
        Self(self.0 * rhs.0)
    }
    fn inverse(&self) -> Self {
        // 1/g ≈ 1 − (g − 1) holds near 1 only.
        Self(if MISTAKE { S::lit(2.0) - self.0 } else { S::one() / self.0 })
    }
    fn exp(tau: &Tangent<S, 1>) -> Self {
        Self(tau.x.simd_exp())
    }
    fn log(&self) -> Tangent<S, 1> {
        Vector1::new(self.0.simd_ln())
    }
    // The group is commutative: nothing turns, nothing bends.
    fn adjoint(&self) -> Jacobian<S, 1> {
        Matrix1::identity()
    }
    fn small_adjoint(_: &Tangent<S, 1>) -> Jacobian<S, 1> {
        Matrix1::zeros()
    }
    fn right_jacobian(_: &Tangent<S, 1>) -> Jacobian<S, 1> {
        Matrix1::identity()
    }
    fn right_jacobian_inverse(_: &Tangent<S, 1>) -> Jacobian<S, 1> {
        Matrix1::identity()
    }
    fn hat(tau: &Tangent<S, 1>) -> Self::Algebra {
        *tau
    }
    fn vee(algebra: &Self::Algebra) -> Tangent<S, 1> {
        *algebra
    }
    fn map<T: Real>(&self, f: impl Fn(S) -> T) -> Gain<T, MISTAKE> {
        Gain(f(self.0))
    }
}

fn main() -> Result<(), LieError> {
    println!("f64:     {:?}", laws::check_group::<Gain, 1>());
    println!("f32:     {:?}", laws::check_group::<Gain<f32>, 1>());
    if let Err(violation) = laws::check_group::<Gain<f64, true>, 1>() {
        println!("mistake: {violation}");
    }

    // All else is there: the mean of gains is the geometric one, halfway between 1 and 4 is 2.
    let gains: [Gain; 2] = [Gain(1.0), Gain(4.0)];
    println!("mean:    {:?}", Gain::mean(&gains, Weights::Equal)?.value);
    println!("halfway: {:?}", gains[0].interpolate(&gains[1], 0.5));
    Ok(())
}
