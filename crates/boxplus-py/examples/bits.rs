//! Prints operations of every group, arguments and results bit by bit, for the tests of the Python package to compare with.
//!
//! A line is the group, the operation, its arguments and its results, all numbers by their bits in hexadecimal.
#![allow(clippy::print_stdout)] // Printing is its purpose.

use boxplus::lie::{Action, LieGroup, Plain, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3};
use nalgebra::SVector;

/// Lengths of the tangents: tiny, near the switches of the series, generic, and beyond a turn.
const SIZES: [f64; 8] = [0.0, 1e-12, 1e-6, 1e-3, 0.3, 1.0, 3.1, 7.0];

fn main() {
    print::<SO2, 1, 2, 2>();
    print::<SO3, 3, 4, 3>();
    print::<SE2, 3, 4, 2>();
    print::<SE3, 6, 7, 3>();
    print::<SE23, 9, 10, 3>();
    print::<SGal3, 10, 11, 4>();
    print::<Sim2, 4, 5, 2>();
    print::<Sim3, 7, 8, 3>();
}

fn print<G, const D: usize, const N: usize, const P: usize>()
where
    G: LieGroup<D, Scalar = f64> + Action<D, P> + Plain<N, Number = f64>,
{
    let mut seed = 1;
    for size in SIZES {
        for _ in 0..4 {
            let tau = vector::<D>(&mut seed) * size;
            let delta = vector::<D>(&mut seed);
            let (x, y) = (G::exp(&tau), G::exp(&delta));
            let (x_row, y_row) = (x.to_array(), y.to_array());
            let p = vector::<P>(&mut seed) * 10.0;
            let t = vector::<1>(&mut seed).x;
            row::<G, N>("exp", &[tau.as_slice()], &[&x_row]);
            row::<G, N>(
                "right_jacobian_inverse",
                &[tau.as_slice()],
                &[by_rows(&G::right_jacobian_inverse(&tau)).as_slice()],
            );
            row::<G, N>("log", &[&x_row], &[x.log().as_slice()]);
            row::<G, N>("compose", &[&x_row, &y_row], &[&x.compose(&y).to_array()]);
            row::<G, N>("between", &[&x_row, &y_row], &[&x.between(&y).to_array()]);
            row::<G, N>("interpolate", &[&x_row, &y_row, &[t]], &[&x.interpolate(&y, t).to_array()]);
            let (value, d_x, d_tau) = x.rplus_jac(&delta);
            row::<G, N>(
                "rplus_jac",
                &[&x_row, delta.as_slice()],
                &[&value.to_array(), by_rows(&d_x).as_slice(), by_rows(&d_tau).as_slice()],
            );
            let (value, d_x, d_y) = x.rminus_jac(&y);
            row::<G, N>(
                "rminus_jac",
                &[&x_row, &y_row],
                &[value.as_slice(), by_rows(&d_x).as_slice(), by_rows(&d_y).as_slice()],
            );
            let (value, d_x, d_p) = x.act_jac(&p);
            row::<G, N>(
                "act_jac",
                &[&x_row, p.as_slice()],
                &[value.as_slice(), by_rows(&d_x).as_slice(), by_rows(&d_p).as_slice()],
            );
        }
    }
}

/// Numbers in [−1, 1) by a linear congruential generator.
fn vector<const M: usize>(seed: &mut u64) -> SVector<f64, M> {
    SVector::from_fn(|_, _| {
        *seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (*seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    })
}

fn by_rows<const R: usize, const C: usize>(matrix: &nalgebra::SMatrix<f64, R, C>) -> Vec<f64> {
    matrix.transpose().as_slice().to_vec()
}

fn row<G: Plain<N>, const N: usize>(operation: &str, arguments: &[&[f64]], results: &[&[f64]]) {
    println!("{} {operation} {} > {}", G::NAME, bits(arguments), bits(results));
}

/// Rows separated by spaces, numbers by commas.
fn bits(rows: &[&[f64]]) -> String {
    let row =
        |row: &&[f64]| row.iter().map(|x| format!("{:016x}", x.to_bits())).collect::<Vec<_>>().join(",");
    rows.iter().map(row).collect::<Vec<_>>().join(" ")
}
