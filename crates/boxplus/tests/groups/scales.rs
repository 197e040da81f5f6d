//! Nothing depends on the unit of length: kilometres and nanometres give the same bits.

use boxplus::lie::{LieGroup, Real, SE2, SE3, SE23, SGal3, Sim2, Sim3, Stumpff};
use nalgebra::{SMatrix, SVector};

/// Multiplies the lengths of a tangent by `scale`; `lengths` says which coordinates are lengths.
fn scaled<S: Real, const D: usize>(tau: &SVector<S, D>, lengths: &[usize], scale: S) -> SVector<S, D> {
    SVector::from_fn(|i, _| if lengths.contains(&i) { tau[i] * scale } else { tau[i] })
}

/// Entry (i, j) of a Jacobian has the unit of i over that of j.
fn scaled_matrix<S: Real, const D: usize>(
    m: &SMatrix<S, D, D>,
    lengths: &[usize],
    scale: S,
) -> SMatrix<S, D, D> {
    let unit = |i: usize| if lengths.contains(&i) { scale } else { S::one() };
    SMatrix::from_fn(|i, j| m[(i, j)] * unit(i) / unit(j))
}

/// A power of two changes no mantissa, so that every operation commutes with it to the last bit.
fn homogeneous<G: LieGroup<D>, const D: usize>(lengths: &[usize], orders: [i32; 2]) {
    let wave = |s: usize| SVector::<f64, D>::from_fn(|i, _| 0.7 * ((i * 3 + s) as f64).sin());
    for order in orders {
        let scale = G::Scalar::lit(2.0_f64.powi(order));
        for k in 0..8_usize {
            let size = |t: SVector<f64, D>| t.map(|x| G::Scalar::lit(x * k as f64 / 2.0));
            let (a, b) = (size(wave(1 + k)), size(wave(20)));
            let [large_a, large_b] = [&a, &b].map(|t| scaled(t, lengths, scale));
            let (x, y) = (G::exp(&a), G::exp(&b));
            let (large_x, large_y) = (G::exp(&large_a), G::exp(&large_b));
            let same = |name: &str, small: SVector<G::Scalar, D>, large: SVector<G::Scalar, D>| {
                assert_eq!(scaled(&small, lengths, scale), large, "{name}, 2^{order}");
            };
            same("log", x.log(), large_x.log());
            same("compose", x.compose(&y).log(), large_x.compose(&large_y).log());
            same("inverse", x.inverse().log(), large_x.inverse().log());
            same("rminus", x.rminus(&y), large_x.rminus(&large_y));
            let same = |name: &str, small: SMatrix<G::Scalar, D, D>, large: SMatrix<G::Scalar, D, D>| {
                assert_eq!(scaled_matrix(&small, lengths, scale), large, "{name}, 2^{order}");
            };
            same("Ad", x.adjoint(), large_x.adjoint());
            same("J_r", G::right_jacobian(&a), G::right_jacobian(&large_a));
            same("J_r⁻¹", G::right_jacobian_inverse(&a), G::right_jacobian_inverse(&large_a));
        }
    }
}

#[test]
fn lengths_from_a_picometre_to_a_million_million_metres_have_the_same_digits() {
    homogeneous::<SE2, 3>(&[0, 1], [-40, 40]);
    homogeneous::<SE3, 6>(&[0, 1, 2], [-40, 40]);
    homogeneous::<SE23, 9>(&[0, 1, 2, 6, 7, 8], [-40, 40]);
    homogeneous::<SGal3, 10>(&[0, 1, 2, 6, 7, 8], [-40, 40]);
    homogeneous::<Sim2, 4>(&[0, 1], [-40, 40]);
    homogeneous::<Sim3, 7>(&[0, 1, 2], [-40, 40]);
    homogeneous::<SE2<f32>, 3>(&[0, 1], [-40, 40]);
    homogeneous::<SE3<f32>, 6>(&[0, 1, 2], [-40, 40]);
    homogeneous::<SE23<f32>, 9>(&[0, 1, 2, 6, 7, 8], [-40, 40]);
    homogeneous::<SGal3<f32>, 10>(&[0, 1, 2, 6, 7, 8], [-40, 40]);
    homogeneous::<Sim2<f32>, 4>(&[0, 1], [-40, 40]);
    homogeneous::<Sim3<f32>, 7>(&[0, 1, 2], [-40, 40]);
}

/// Both sides of every switch: no step but of rounding, and the sign of the slope is kept over some ulps.
#[test]
fn coefficients_go_on_monotonously_across_their_switches() {
    // All fall with x up to 10 but d and e, which rise.
    let values = |x: f64| {
        let c = Stumpff::new(x);
        [c.c0, c.c1, c.c2, c.c3, c.c4, c.c5, c.c6, -c.d(), -c.e()]
    };
    for switch in [0.25, 10.0_f64] {
        let step = switch * f64::EPSILON;
        let [before, at, after] = [-1.0, 0.0, 1.0].map(|k| values(switch + k * step));
        let [wide_before, wide_after] = [-1.0, 1.0].map(|k| values(switch * (1.0 + k * 1e-9)));
        for i in 0..at.len() {
            // Each side holds its bound of docs/accuracy.md: a few ε, 32 of e.
            let rounding = if i == 8 { 64.0 } else { 8.0 } * f64::EPSILON * at[i].abs().max(0.1);
            assert!((before[i] - after[i]).abs() <= rounding, "coefficient {i} jumps at x = {switch}");
            if switch < 1.0 || i > 1 {
                assert!(wide_before[i] > wide_after[i], "coefficient {i} turns round at x = {switch}");
            }
        }
    }
}
