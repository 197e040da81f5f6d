//! How well the measurements hold the variables: what is free, what is weak, and how far the two are apart.

use nalgebra::DMatrix;

use super::diagnose::{scale, softest, weakest};
use super::gauge;
use super::linear::evaluate::Evaluator;
use super::linear::structure::{Normal, Structure};
use super::linear::vector::{dot, product, rough};
use super::values::VariableId;
use super::{Graph, GraphError, Unconstrained, Values, VariableName};

/// How well a graph determines its variables; see [`Graph::conditioning`].
#[derive(Clone, Debug, PartialEq)]
pub struct Conditioning {
    /// Variables that their own measurements leave free, even if all others were known: e.g. a point seen in one direction.
    pub loose: Vec<Loose>,
    /// All directions that nothing constrains, those of `loose` too, with one variable of each floating part held.
    pub unconstrained: Option<Unconstrained>,
    /// The ratio of the largest to the smallest eigenvalue of D^-½HD^-½, D the diagonal of H = JᵀJ: no unit matters. Above
    /// some 1e12 the answer has few digits; infinite where something is unconstrained.
    pub condition: f64,
    /// The variables that are known worst, at most [`Conditioning::SHOWN`], worst first; none where something is
    /// unconstrained.
    pub weakest: Vec<Weak>,
}

impl Conditioning {
    /// Weak variables named at most.
    pub const SHOWN: usize = 5;
}

/// A variable with directions that its own measurements do not see.
#[derive(Clone, Debug, PartialEq)]
pub struct Loose {
    /// The variable.
    pub variable: VariableName,
    /// Unit vectors in its tangent (each coordinate in units of its conditional σ), in the order of the tangent.
    pub directions: Vec<Vec<f64>>,
}

/// A variable that is known badly.
#[derive(Clone, Debug, PartialEq)]
pub struct Weak {
    /// The variable.
    pub variable: VariableName,
    /// Marginal standard deviation of each coordinate of its tangent, local side, with the coordinate's name, relative to
    /// what is held.
    pub sigmas: Vec<(&'static str, f64)>,
    /// By how much the largest of them exceeds the σ with all other variables known.
    pub inflation: f64,
}

/// A direction of one variable is free where the scaled curvature is below this, a thousand times the rounding of JᵀJ.
const LOOSE: f64 = 1e-12;
/// Steps of the power iteration for the largest eigenvalue, of which two digits matter.
const POWERS: usize = 30;

impl Graph {
    /// How well the factors hold the variables at `values`: which are free, which are weak. Robust kernels count with their
    /// weights.
    ///
    /// ```
    /// use boxplus::graph::{Bearing2, Graph, Noise, Prior, Values};
    /// use boxplus::lie::{LieGroup, Rn, SE2};
    /// use nalgebra::vector;
    /// let (mut graph, mut values) = (Graph::new(), Values::new());
    /// let pose = values.insert(SE2::identity());
    /// let tree = values.insert(Rn::new(vector![5.0, 0.0]));
    /// graph.add((pose,), Prior { mean: SE2::identity() }, Noise::unit());
    /// graph.add((pose, tree), Bearing2::new(0.0), Noise::unit()); // says nothing of the distance
    /// let conditioning = graph.conditioning(&values)?;
    /// assert!((conditioning.loose[0].directions[0][0].abs() - 1.0).abs() < 1e-12);
    /// assert_eq!(conditioning.unconstrained.unwrap().directions, 1);
    /// # Ok::<(), boxplus::graph::GraphError>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`Graph::cost`]; [`GraphError::IllConditioned`], [`GraphError::OutOfMemory`].
    pub fn conditioning(&self, values: &Values) -> Result<Conditioning, GraphError> {
        self.check(values)?;
        let mut values = values.clone();
        gauge::fix(&self.sets, &mut values);
        let structure = Structure::new(&self.sets, &values, &self.analyses)?;
        let mut normal = structure.normal();
        let mut evaluator = Evaluator::new(&self.sets, 1);
        evaluator.linearise(&values, &structure, &mut normal);
        let loose = loose(&structure, &normal, &values);
        let unconstrained = weakest(&evaluator, &structure, &normal, &values)?;
        let (condition, weakest) = match unconstrained {
            Some(_) => (f64::INFINITY, vec![]),
            None if structure.size() == 0 => (1.0, vec![]),
            None => weak(&structure, &normal, &values)?,
        };
        Ok(Conditioning { loose, unconstrained, condition, weakest })
    }
}

/// Variables whose own block of the normal equations is singular.
fn loose(structure: &Structure, normal: &Normal, values: &Values) -> Vec<Loose> {
    let free = |&id: &VariableId| {
        let start = structure.offsets.get(id)?;
        let entry = |i: usize, j: usize| normal.matrix[structure.diagonal[start + i.min(j)] + i.abs_diff(j)];
        let sigma = |i: usize| if entry(i, i) > 0.0 { entry(i, i).sqrt().recip() } else { 1.0 };
        let dim = values.dim(id);
        let block = DMatrix::from_fn(dim, dim, |i, j| entry(i, j) * sigma(i) * sigma(j));
        if !block.iter().all(|x| x.is_finite()) {
            return None;
        }
        let eigen = block.symmetric_eigen();
        let soft = (0..dim).filter(|&k| eigen.eigenvalues[k] < LOOSE);
        let directions: Vec<Vec<f64>> =
            soft.map(|k| eigen.eigenvectors.column(k).iter().copied().collect()).collect();
        (!directions.is_empty()).then(|| Loose { variable: values.name(id), directions })
    };
    let mut found: Vec<Loose> = structure.variables.iter().filter_map(free).collect();
    found.sort_by_key(|loose| (loose.variable.kind, loose.variable.label));
    found
}

/// The condition of the scaled equations, and the variables that their softest directions move most.
fn weak(structure: &Structure, normal: &Normal, values: &Values) -> Result<(f64, Vec<Weak>), GraphError> {
    let size = structure.size();
    let (scaled, scale) = scale(structure, normal);
    let (basis, mut cholesky) = softest(structure, &scaled)?.ok_or(GraphError::IllConditioned)?;
    let columns: Vec<&[f64]> = basis.chunks(size).collect();
    let images: Vec<_> = columns.iter().map(|v| product(&structure.pattern, &scaled, v)).collect();
    let form = DMatrix::from_fn(columns.len(), columns.len(), |i, j| dot(columns[i], &images[j]));
    let eigen = ((&form + form.transpose()) * 0.5).symmetric_eigen();
    let softness = eigen.eigenvalues.map(|x| x.max(f64::EPSILON).recip());
    // A lower bound of each coordinate's variance: the part of the inverse that lies in the softest directions.
    let inverse = &eigen.eigenvectors * DMatrix::from_diagonal(&softness) * eigen.eigenvectors.transpose();
    let variance = |row: usize| {
        let v: Vec<f64> = columns.iter().map(|column| column[row]).collect();
        (0..v.len()).map(|i| (0..v.len()).map(|j| v[i] * inverse[(i, j)] * v[j]).sum::<f64>()).sum::<f64>()
    };
    let starts = &structure.pattern.starts;
    let mut order: Vec<(f64, usize)> = (0..structure.variables.len())
        .map(|k| (starts[k]..starts[k + 1]).map(variance).fold(0.0, f64::max))
        .zip(0..)
        .collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let weak = order.iter().take(Conditioning::SHOWN).map(|&(_, k)| {
        let (id, rows) = (structure.variables[k], starts[k]..starts[k + 1]);
        let mut sigma = |row: usize| {
            let mut unit = vec![0.0; size];
            unit[row] = 1.0;
            cholesky.solve(&mut unit);
            unit[row].max(0.0).sqrt()
        };
        let relative: Vec<f64> = rows.clone().map(&mut sigma).collect();
        let names = values.coordinates(id).iter().copied().chain(core::iter::repeat("coordinate"));
        Weak {
            variable: values.name(id),
            sigmas: names.zip(rows.zip(&relative).map(|(row, sigma)| sigma * scale[row])).collect(),
            inflation: relative.iter().copied().fold(0.0, f64::max),
        }
    });
    let weak = weak.collect();
    Ok((largest(structure, &scaled) * softness.max(), weak))
}

/// The largest eigenvalue, by power iteration.
fn largest(structure: &Structure, scaled: &[f64]) -> f64 {
    let mut x = rough(structure.size());
    let mut value = 0.0;
    for _ in 0..POWERS {
        let norm = dot(&x, &x).sqrt();
        x.iter_mut().for_each(|x| *x /= norm);
        x = product(&structure.pattern, scaled, &x);
        value = dot(&x, &x).sqrt();
    }
    value
}
