//! Is a matrix an inverse covariance?

use nalgebra::{SMatrix, SVector};

/// What is wrong with an information matrix.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum InformationProblem {
    /// An entry is NaN or infinite.
    #[error("has an entry that is NaN or infinite")]
    NotFinite,
    /// All entries are zero: the measurement says nothing.
    #[error("is zero: the measurement says nothing")]
    Zero,
    /// Ω ≠ Ωᵀ.
    #[error("is not symmetric: entries differ by {gap:.1e}")]
    NotSymmetric {
        /// Largest entry of |Ω − Ωᵀ|.
        gap: f64,
    },
    /// An eigenvalue is negative.
    #[error("is not positive definite: its smallest eigenvalue is {smallest:.3e}")]
    Indefinite {
        /// The smallest eigenvalue.
        smallest: f64,
    },
    /// An eigenvalue is zero to rounding.
    #[error(
        "is singular: its eigenvalues reach from {smallest:.1e} to {largest:.1e}, so a direction is not measured"
    )]
    Singular {
        /// The smallest eigenvalue.
        smallest: f64,
        /// The largest eigenvalue.
        largest: f64,
    },
}

/// The smallest and the largest eigenvalue of a D×D information matrix, if it is positive definite.
pub(super) fn spectrum(information: &[f64]) -> Result<(f64, f64), InformationProblem> {
    match information.len() {
        1 => spectrum_of(&SMatrix::<f64, 1, 1>::from_column_slice(information)),
        4 => spectrum_of(&SMatrix::<f64, 2, 2>::from_column_slice(information)),
        9 => spectrum_of(&SMatrix::<f64, 3, 3>::from_column_slice(information)),
        _ => spectrum_of(&SMatrix::<f64, 6, 6>::from_column_slice(information)),
    }
}

fn spectrum_of<const D: usize>(m: &SMatrix<f64, D, D>) -> Result<(f64, f64), InformationProblem> {
    if m.iter().any(|x| !x.is_finite()) {
        return Err(InformationProblem::NotFinite);
    }
    let scale = m.amax();
    if scale == 0.0 {
        return Err(InformationProblem::Zero);
    }
    let gap = (m - m.transpose()).amax();
    if gap > f64::EPSILON.sqrt() * scale {
        return Err(InformationProblem::NotSymmetric { gap }); // An inverse is symmetric to κε; this is no rounding.
    }
    let eigenvalues = eigenvalues(&(m / scale)) * scale;
    let (smallest, largest) = (eigenvalues.min(), eigenvalues.max());
    let rounding = D as f64 * f64::EPSILON * largest.abs();
    match smallest {
        x if x < -rounding => Err(InformationProblem::Indefinite { smallest }),
        x if x <= rounding => Err(InformationProblem::Singular { smallest, largest }),
        _ => Ok((smallest, largest)),
    }
}

/// The eigenvalues of a symmetric matrix, in no order, by Jacobi's method: cyclic rotations until nothing is left off the
/// diagonal. Small eigenvalues of a definite matrix keep their digits (Demmel, Veselić (1992)).
fn eigenvalues<const D: usize>(m: &SMatrix<f64, D, D>) -> SVector<f64, D> {
    let mut a = *m;
    // Convergence is quadratic: ten sweeps are more than any 6×6 matrix needs.
    for _ in 0..10 {
        let mut rotated = false;
        for p in 0..D {
            for q in p + 1..D {
                rotated |= annihilate(&mut a, p, q);
            }
        }
        if !rotated {
            break;
        }
    }
    a.diagonal()
}

/// Rotates `a` in the plane (p, q) so that `a[(p, q)]` vanishes; false if it had already. Golub, Van Loan (2013), 8.5.2.
fn annihilate<const D: usize>(a: &mut SMatrix<f64, D, D>, p: usize, q: usize) -> bool {
    let (app, aqq, apq) = (a[(p, p)], a[(q, q)], a[(p, q)]);
    if apq.abs() <= f64::EPSILON * (app.abs() * aqq.abs()).sqrt() * 0.5 || apq.abs() < f64::MIN_POSITIVE {
        return false;
    }
    let tau = (aqq - app) / (2.0 * apq);
    let t = 1.0f64.copysign(tau) / (tau.abs() + 1.0f64.hypot(tau));
    let c = 1.0 / 1.0f64.hypot(t);
    let s = t * c;
    for k in 0..D {
        let (akp, akq) = (a[(k, p)], a[(k, q)]);
        (a[(k, p)], a[(k, q)]) = (c * akp - s * akq, s * akp + c * akq);
    }
    for k in 0..D {
        let (apk, aqk) = (a[(p, k)], a[(q, k)]);
        (a[(p, k)], a[(q, k)]) = (c * apk - s * aqk, s * apk + c * aqk);
    }
    (a[(p, q)], a[(q, p)]) = (0.0, 0.0);
    true
}
