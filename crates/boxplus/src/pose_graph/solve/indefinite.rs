//! Information matrices that are not positive definite, mended.

use nalgebra::{DMatrix, SMatrix, SymmetricEigen};

use crate::graph::Noise;

/// What to do with a measurement whose information matrix is not positive definite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Indefinite {
    /// Refuse the graph, naming them all.
    #[default]
    Refuse,
    /// Raise the eigenvalues to at least 1e-9 of the largest, which must be positive.
    Clamp,
    /// Weigh every direction of the translation alike, and every direction of the rotation, by the mean of its diagonal, which
    /// must be positive.
    Isotropic,
    /// Leave the measurement out.
    Skip,
}

/// The smallest eigenvalue that [`Indefinite::Clamp`] leaves, as a share of the largest.
const CLAMP: f64 = 1e-9;

/// The information matrix that a policy makes of this one; `None` where the measurement is to be left out.
pub(in crate::pose_graph) fn usable_information<const D: usize>(
    information: &SMatrix<f64, D, D>,
    policy: Indefinite,
) -> Option<SMatrix<f64, D, D>> {
    match (Noise::from_information(information), policy) {
        (Ok(noise), _) => Some(noise.information()),
        (Err(_), policy) => mend(information, translations::<D>(), policy),
    }
}

/// How many coordinates of a pose's tangent of dimension D are its translation.
pub(super) const fn translations<const D: usize>() -> usize {
    if D == 3 { 2 } else { 3 }
}

/// The information matrix that a policy makes of one that is not positive definite; its first `split` coordinates are a
/// translation. `None` where it makes none.
pub(super) fn mend<const D: usize>(
    information: &SMatrix<f64, D, D>,
    split: usize,
    policy: Indefinite,
) -> Option<SMatrix<f64, D, D>> {
    match policy {
        Indefinite::Clamp => clamped(information),
        Indefinite::Isotropic => isotropic(information, split),
        Indefinite::Refuse | Indefinite::Skip => None,
    }
}

/// The diagonal matrix with the mean of the first `split` diagonal entries, then with that of the others; `None` where one is
/// not positive and finite.
fn isotropic<const D: usize>(information: &SMatrix<f64, D, D>, split: usize) -> Option<SMatrix<f64, D, D>> {
    let diagonal = information.diagonal();
    let (translation, rotation) = diagonal.as_slice().split_at(split.min(D));
    let mean = |block: &[f64]| block.iter().sum::<f64>() / block.len() as f64;
    let (tau, kappa) = (mean(translation), mean(rotation));
    let mended = SMatrix::<f64, D, D>::from_fn(|i, j| match i == j {
        true if i < split => tau,
        true => kappa,
        false => 0.0,
    });
    mended.diagonal().iter().all(|x| *x > 0.0 && x.is_finite()).then_some(mended)
}

/// The nearest matrix whose eigenvalues are at least [`CLAMP`] of the largest; `None` where that is not finite.
fn clamped<const D: usize>(information: &SMatrix<f64, D, D>) -> Option<SMatrix<f64, D, D>> {
    if !information.iter().all(|x| x.is_finite()) {
        return None;
    }
    let dynamic = DMatrix::from_column_slice(D, D, symmetric(information).as_slice());
    let mut eigen = SymmetricEigen::new(dynamic);
    let floor = CLAMP * eigen.eigenvalues.max();
    eigen.eigenvalues.apply(|x| *x = x.max(floor));
    let mended = SMatrix::from_column_slice(eigen.recompose().as_slice());
    (floor > 0.0).then(|| symmetric(&mended))
}

pub(super) fn symmetric<const D: usize>(m: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
    (m + m.transpose()) * 0.5
}
