//! The derivatives of J and J⁻¹ against `scripts/second_order_tables.py`. Each is a sum of terms, one for each coordinate of δ,
//! which may cancel: errors are relative to the largest of the sum and its terms.

use super::judge::{Errors, LAST, Table, norm};
use boxplus::lie::{LieGroup, Real, SE2, SE3, SGal3, Sim2, Sim3};
use nalgebra::{SMatrix, SVector};

/// A block of a matrix: its names in `BOUNDS` for DJ and DJ⁻¹; first row, first column, rows, columns.
type Block = ([&'static str; 2], [usize; 4]);

/// DJ_r(τ)\[δ\] and DJ_r⁻¹(τ)\[δ\].
fn derivatives<G: LieGroup<D>, const D: usize>(
    tau: &SVector<G::Scalar, D>,
    delta: &SVector<G::Scalar, D>,
) -> [SMatrix<G::Scalar, D, D>; 2] {
    [G::right_jacobian_derivative(tau, delta), G::right_jacobian_inverse_derivative(tau, delta)]
}

/// Every block of one group; `angle` is the rotation angle of a tangent.
fn group<G: LieGroup<D>, const D: usize>(
    text: &'static str,
    blocks: &[Block],
    angle: fn(&[f64]) -> f64,
    errors: &mut Errors,
) {
    let table = Table::parse(text, 2 * D);
    let rows = table.rows::<G::Scalar>().map(|row| (angle(&row.get::<D>("tau")), row));
    for (theta, row) in rows.filter(|(theta, _)| *theta < LAST) {
        // J_l(τ) = J_r(−τ).
        let (tau, delta) = (-row.input::<G::Scalar, D>("tau"), -row.input::<G::Scalar, D>("delta"));
        let computed = derivatives::<G, D>(&tau, &delta);
        let terms: [_; D] = std::array::from_fn(|i| {
            let part = SVector::from_fn(|k, _| if i == k { delta[k].value() } else { 0.0 });
            derivatives::<G::Over<f64>, D>(&tau.map(Real::value), &part)
        });
        for (k, column) in ["djl", "djl_inv"].into_iter().enumerate() {
            let mut first = row.first(column);
            for (names, place) in blocks {
                let found = entries(&computed[k], *place);
                let truth = &row.numbers[first..first + found.len()];
                let sizes = terms.iter().map(|term| norm(entries(&term[k], *place)));
                let scale = sizes.fold(norm(truth.iter().copied()), f64::max);
                errors.record(names[k], theta, &found, truth, scale);
                first += found.len();
            }
        }
    }
}

/// The entries of a block, by rows.
fn entries<S: Real, const D: usize>(m: &SMatrix<S, D, D>, [i, j, h, w]: [usize; 4]) -> Vec<S> {
    (0..h * w).map(|n| m[(i + n / w, j + n % w)]).collect()
}

pub(crate) fn second_order<S: Real>(errors: &mut Errors) {
    let in_plane = |tau: &[f64]| tau[2].abs();
    let in_space = |tau: &[f64]| norm(tau[3..6].iter().copied());
    let blocks = [
        (["SE(2) DJ, M block", "SE(2) DJ⁻¹, M block"], [0, 0, 2, 2]),
        (["SE(2) DJ, q column", "SE(2) DJ⁻¹, q column"], [0, 2, 2, 1]),
    ];
    group::<SE2<S>, 3>(include_str!("second_se2.csv"), &blocks, in_plane, errors);
    let blocks = [
        (["SO(3) DJ", "SO(3) DJ⁻¹"], [0, 0, 3, 3]),
        (["SE(3) DJ, Q block", "SE(3) DJ⁻¹, Q̃ block"], [0, 3, 3, 3]),
    ];
    group::<SE3<S>, 6>(include_str!("second_se3.csv"), &blocks, in_space, errors);
    let blocks = [
        (["SGal(3) DJ, ρφ block", "SGal(3) DJ⁻¹, ρφ block"], [0, 3, 3, 3]),
        (["SGal(3) DJ, ρν block", "SGal(3) DJ⁻¹, ρν block"], [0, 6, 3, 3]),
        (["SGal(3) DJ, ρι column", "SGal(3) DJ⁻¹, ρι column"], [0, 9, 3, 1]),
    ];
    group::<SGal3<S>, 10>(include_str!("second_sgal3.csv"), &blocks, in_space, errors);
    let blocks = [
        (["Sim(2) DJ, φ₁ block", "Sim(2) DJ⁻¹, φ₁ block"], [0, 0, 2, 2]),
        (["Sim(2) DJ, columns", "Sim(2) DJ⁻¹, columns"], [0, 2, 2, 2]),
    ];
    group::<Sim2<S>, 4>(include_str!("second_sim2.csv"), &blocks, in_plane, errors);
    let blocks = [
        (["Sim(3) DJ, G block", "Sim(3) DJ⁻¹, G block"], [0, 0, 3, 3]),
        (["Sim(3) DJ, S block", "Sim(3) DJ⁻¹, S block"], [0, 3, 3, 3]),
        (["Sim(3) DJ, c column", "Sim(3) DJ⁻¹, c column"], [0, 6, 3, 1]),
        (["Sim(3) DJ, J block", "Sim(3) DJ⁻¹, J block"], [3, 3, 3, 3]),
    ];
    group::<Sim3<S>, 7>(include_str!("second_sim3.csv"), &blocks, in_space, errors);
}
