//! Which directions of which variables nothing constrains.
//!
//! A direction v with vᵀHv ≈ 0 is one along which no residual changes. They are found by subspace iteration with the
//! inverse of D^-½HD^-½ + εI, D the diagonal of H, where every coordinate has its own unit; and they are told by the
//! share that each coordinate of each variable has in the space they span.

use core::fmt;

use nalgebra::DMatrix;

use super::GraphError;
use super::linear::cholesky::Cholesky;
use super::linear::evaluate::Evaluator;
use super::linear::structure::{Normal, Structure};
use super::linear::vector::{dot, product, rough};
use super::{Values, VariableName};

/// One coordinate of one variable that takes part in an unconstrained direction.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeCoordinate {
    /// The variable.
    pub variable: VariableName,
    /// The coordinate of its tangent, e.g. `"yaw"`.
    pub coordinate: &'static str,
    /// How much of this coordinate's axis lies in the unconstrained space: 1 is entirely free.
    pub share: f64,
}

/// The directions that no factor constrains.
#[derive(Clone, Debug, PartialEq)]
pub struct Unconstrained {
    /// How many independent directions were found.
    pub directions: usize,
    /// Whether there may be more than were looked for.
    pub more: bool,
    /// Variables that take part in them.
    pub variables: usize,
    /// The coordinates that have the largest shares, largest first, at most [`Unconstrained::SHOWN`].
    pub coordinates: Vec<FreeCoordinate>,
}

impl Unconstrained {
    /// Coordinates named at most.
    pub const SHOWN: usize = 6;
}

impl fmt::Display for Unconstrained {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let more = if self.more { "at least " } else { "" };
        let plural = if self.directions == 1 { "direction is" } else { "directions are" };
        write!(f, "{more}{} {plural} constrained by no factor", self.directions)?;
        for (i, free) in self.coordinates.iter().enumerate() {
            let lead = if i == 0 { ": " } else { ", " };
            write!(f, "{lead}{} of {} ({:.0} %)", free.coordinate, free.variable, 100.0 * free.share)?;
        }
        let hidden = self.variables > Self::SHOWN;
        if hidden {
            write!(
                f,
                ", … ({} variables take part, so a whole part of the graph moves together)",
                self.variables
            )?;
        }
        write!(f, "; add a measurement that sees them, a prior, or hold a variable")
    }
}

/// Directions sought at once.
const SOUGHT: usize = 8;
/// Shifts of the scaled matrix (unit diagonal), the smallest first: the first that leaves it factorisable is taken.
const SHIFTS: [f64; 5] = [1e-14, 1e-13, 1e-12, 1e-11, 1e-10];
/// A direction is unconstrained where the scaled curvature ‖J·v‖² of a unit v is below this. It is summed over the factors,
/// where a free direction cancels to ε² ≈ 1e-31, not taken from JᵀJ, which would leave ε. The softest bend of a chain of
/// 10⁵ planar poses has 3e-18.
const FREE: f64 = 1e-21;
/// Directions above this in JᵀJ are not looked at: its rounding is a thousand times less.
const CANDIDATE: f64 = 1e-12;

/// A curvature below this, where the diagonal is one, hints at a direction that nothing constrains.
pub(crate) const SINGULAR: f64 = 1e-10;

/// About the least eigenvalue of a matrix A, from above, by two inverse iterations; `solve` overwrites x with A⁻¹x.
pub(crate) fn least_eigenvalue(size: usize, mut solve: impl FnMut(&mut [f64])) -> f64 {
    let mut x = rough(size);
    let mut least = f64::INFINITY;
    for _ in 0..2 {
        let norm = dot(&x, &x).sqrt();
        x.iter_mut().for_each(|x| *x /= norm);
        solve(&mut x);
        least = dot(&x, &x).sqrt().recip();
    }
    least
}

/// The unconstrained directions of the normal equations, or `None` where every direction is constrained.
pub(crate) fn weakest(
    evaluator: &Evaluator<'_>,
    structure: &Structure,
    normal: &Normal,
    values: &Values,
) -> Result<Option<Unconstrained>, GraphError> {
    let size = structure.size();
    let sought = SOUGHT.min(size);
    if size == 0 {
        return Ok(None);
    }
    let (scaled, scale) = scale(structure, normal);
    let Some((basis, _)) = softest(structure, &scaled)? else {
        return Ok(None); // negative curvature beyond rounding cannot come from JᵀJ
    };
    let free = free_directions(evaluator, structure, values, (&scaled, &scale), &basis);
    Ok((!free.is_empty()).then(|| describe(structure, values, &free, sought)))
}

/// An orthonormal basis, column by column, of (nearly) the softest directions of the scaled matrix, by inverse iteration, and the
/// factorisation it was made with. `None` where no small shift makes the matrix positive definite.
pub(crate) fn softest(
    structure: &Structure,
    scaled: &[f64],
) -> Result<Option<(Vec<f64>, Cholesky)>, GraphError> {
    let size = structure.size();
    let sought = SOUGHT.min(size);
    let mut cholesky = Cholesky::new(&structure.pattern)?;
    let factorised = SHIFTS.iter().any(|shift| {
        let mut shifted = scaled.to_vec();
        structure.diagonal.iter().for_each(|&at| shifted[at] += shift);
        cholesky.factorise(&shifted).is_ok()
    });
    if !factorised {
        return Ok(None);
    }
    let mut basis = rough(size * sought);
    orthonormalise(&mut basis, size);
    for _ in 0..6 {
        cholesky.solve(&mut basis);
        orthonormalise(&mut basis, size);
    }
    Ok(Some((basis, cholesky)))
}

/// S·H·S with S = D^-½, which has a unit diagonal, and S. A coordinate that nothing reads keeps its zero.
pub(crate) fn scale(structure: &Structure, normal: &Normal) -> (Vec<f64>, Vec<f64>) {
    let scale: Vec<f64> = structure
        .diagonal
        .iter()
        .map(|&at| if normal.matrix[at] > 0.0 { normal.matrix[at].sqrt().recip() } else { 1.0 })
        .collect();
    let mut scaled = normal.matrix.clone();
    for block in structure.pattern.blocks() {
        let numbers = &mut scaled[block.at..block.at + block.rows * block.columns];
        for (column, one) in numbers.chunks_exact_mut(block.rows).zip(&scale[block.column..]) {
            column.iter_mut().zip(&scale[block.row..]).for_each(|(h, other)| *h *= one * other);
        }
    }
    (scaled, scale)
}

/// The combinations of the basis along which no residual changes: those that look free in the matrix, sifted by the
/// factors themselves.
fn free_directions(
    evaluator: &Evaluator<'_>,
    structure: &Structure,
    values: &Values,
    (scaled, scale): (&[f64], &[f64]),
    basis: &[f64],
) -> Vec<Vec<f64>> {
    let columns: Vec<Vec<f64>> = basis.chunks(structure.size()).map(<[f64]>::to_vec).collect();
    let images: Vec<_> = columns.iter().map(|v| product(&structure.pattern, scaled, v)).collect();
    let projected = DMatrix::from_fn(columns.len(), columns.len(), |i, j| dot(&columns[i], &images[j]));
    let candidates = soft_combinations(&columns, &projected, CANDIDATE);
    let unscale = |v: &Vec<f64>| v.iter().zip(scale).map(|(v, s)| v * s).collect();
    let unscaled: Vec<Vec<f64>> = candidates.iter().map(unscale).collect();
    soft_combinations(&candidates, &evaluator.curvatures(values, structure, &unscaled), FREE)
}

/// The orthonormal combinations of orthonormal `columns` in which the symmetric `form` is below `bound`.
fn soft_combinations(columns: &[Vec<f64>], form: &DMatrix<f64>, bound: f64) -> Vec<Vec<f64>> {
    if columns.is_empty() {
        return vec![];
    }
    let eigen = ((form + form.transpose()) * 0.5).symmetric_eigen();
    let soft = (0..columns.len()).filter(|&k| eigen.eigenvalues[k] < bound);
    soft.map(|k| {
        let mut vector = vec![0.0; columns[0].len()];
        for (j, column) in columns.iter().enumerate() {
            let weight = eigen.eigenvectors[(j, k)];
            vector.iter_mut().zip(column).for_each(|(v, c)| *v += weight * c);
        }
        vector
    })
    .collect()
}

fn describe(structure: &Structure, values: &Values, free: &[Vec<f64>], sought: usize) -> Unconstrained {
    let mut shares: Vec<(usize, f64)> =
        (0..structure.size()).map(|i| (i, free.iter().map(|v| v[i] * v[i]).sum::<f64>())).collect();
    let largest = shares.iter().map(|&(_, share)| share).fold(0.0, f64::max);
    shares.retain(|&(_, share)| share > 1e-3 * largest);
    let mut variables: Vec<_> = shares.iter().map(|&(i, _)| structure.coordinate(i).0).collect();
    variables.dedup();
    shares.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let coordinates = shares.iter().take(Unconstrained::SHOWN).map(|&(i, share)| {
        let (id, coordinate) = structure.coordinate(i);
        let names = values.coordinates(id);
        FreeCoordinate {
            variable: values.name(id),
            coordinate: names.get(coordinate).copied().unwrap_or("coordinate"),
            share: share.min(1.0),
        }
    });
    Unconstrained {
        directions: free.len(),
        more: free.len() == sought && sought < structure.size(),
        variables: variables.len(),
        coordinates: coordinates.collect(),
    }
}

/// Modified Gram–Schmidt on the columns of `basis`, twice is enough.
fn orthonormalise(basis: &mut [f64], size: usize) {
    for _ in 0..2 {
        for k in 0..basis.len() / size {
            let (done, rest) = basis.split_at_mut(k * size);
            let vector = &mut rest[..size];
            for other in done.chunks(size) {
                let along = dot(other, vector);
                vector.iter_mut().zip(other).for_each(|(v, o)| *v -= along * o);
            }
            let norm = dot(vector, vector).sqrt();
            if norm > 0.0 {
                vector.iter_mut().for_each(|v| *v /= norm);
            }
        }
    }
}
