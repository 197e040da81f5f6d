//! Marginal covariances: how sure the estimate is of single variables, and of several together.

use nalgebra::DMatrix;

use super::GraphError;
use super::diagnose::{SINGULAR, least_eigenvalue, scale, weakest};
use super::gauge;
use super::linear::analyses::Analyses;
use super::linear::cholesky::Cholesky;
use super::linear::evaluate::Evaluator;
use super::linear::structure::Structure;
use super::minimum_norm::MinimumNorm;
use super::names::VariableName;
use super::set::AnySet;
use super::values::{Key, Values, VariableId};
use super::variable::GroupVariable;

/// Covariances of the variables at an estimate: blocks of (JᵀJ)⁻¹.
///
/// Every covariance is on the **local (right) side**, X = X̄·Exp(ξ), ξ ~ N(0, Σ), in the order of the tangent (metres
/// before radians); [`Self::covariance_global`] has the other side (Solà et al. (2018) (54)). Held variables are known exactly:
/// their covariance is zero. Where the graph has no held variable and no prior, all is relative to
/// [`Marginals::gauge`], or, made by [`Graph::marginals_of_minimum_norm`](super::Graph::marginals_of_minimum_norm), to none.
pub struct Marginals {
    structure: Structure,
    /// Of S·H·S, whose diagonal is one.
    cholesky: Cholesky,
    /// S = D^-½.
    scale: Vec<f64>,
    values: Values,
    gauge: Vec<VariableName>,
    /// Where no variable is held for the gauge.
    free: Option<MinimumNorm>,
}

impl Marginals {
    pub(super) fn new(
        sets: &[Box<dyn AnySet>],
        values: &Values,
        analyses: &Analyses,
    ) -> Result<Self, GraphError> {
        let mut values = values.clone();
        let gauge = gauge::fix(sets, &mut values).iter().map(|&id| values.name(id)).collect();
        let structure = Structure::new(sets, &values, analyses)?;
        let mut normal = structure.normal();
        let mut evaluator = Evaluator::new(sets, 1);
        evaluator.linearise(&values, &structure, &mut normal);
        let (scaled, scale) = scale(&structure, &normal);
        let mut cholesky = Cholesky::new(&structure.pattern)?;
        let factorised = cholesky.factorise(&scaled).is_ok();
        // The search for free directions costs as much again: only where the factor hints at one.
        let doubtful = !factorised || least_eigenvalue(structure.size(), |x| cholesky.solve(x)) < SINGULAR;
        if doubtful && let Some(unconstrained) = weakest(&evaluator, &structure, &normal, &values)? {
            return Err(GraphError::Unconstrained(unconstrained));
        }
        if !factorised {
            return Err(GraphError::IllConditioned);
        }
        Ok(Self { structure, cholesky, scale, values, gauge, free: None })
    }

    /// The same without a gauge; see [`MinimumNorm`].
    pub(super) fn of_minimum_norm(
        sets: &[Box<dyn AnySet>],
        values: &Values,
        analyses: &Analyses,
    ) -> Result<Self, GraphError> {
        let held = Self::new(sets, values, analyses)?; // with a gauge held, all else must be determined
        let mut fixed = values.clone();
        let pinned = gauge::fix(sets, &mut fixed);
        if pinned.is_empty() {
            return Ok(held);
        }
        let structure = Structure::new(sets, values, analyses)?;
        let mut normal = structure.normal();
        Evaluator::new(sets, 1).linearise(values, &structure, &mut normal);
        let (mut scaled, scale) = scale(&structure, &normal);
        for &id in &pinned {
            let start = structure.offsets.get(id).ok_or(GraphError::IllConditioned)?;
            structure.diagonal[start..start + values.dim(id)].iter().for_each(|&at| scaled[at] += 1.0);
        }
        let mut cholesky = Cholesky::new(&structure.pattern)?;
        cholesky.factorise(&scaled).map_err(|_| GraphError::IllConditioned)?;
        let free = MinimumNorm::new(sets, values, (&structure, &scale), &mut cholesky, &pinned);
        Ok(Self { structure, cholesky, scale, values: values.clone(), gauge: vec![], free: Some(free) })
    }

    /// What was held for lack of any held variable or prior: its covariance is zero, and all others are relative to it. Empty
    /// for those of minimum norm.
    pub fn gauge(&self) -> &[VariableName] {
        &self.gauge
    }

    /// Whether a factor reads the variable, or it is held: others have no covariance.
    pub fn knows(&self, variable: impl Into<VariableId>) -> bool {
        self.place(variable.into()).is_ok()
    }

    /// D×D covariance of one variable, local side.
    ///
    /// # Errors
    /// [`GraphError::ForeignKey`] for a key of other values; [`GraphError::Unread`] for a variable that no factor reads.
    pub fn covariance(&mut self, variable: impl Into<VariableId>) -> Result<DMatrix<f64>, GraphError> {
        self.joint(&[variable.into()])
    }

    /// D×D covariances of many variables, local side each, in the order given: all from one sweep over the factor, whose time
    /// is about that of two factorisations however many they are.
    ///
    /// # Errors
    /// As [`Self::covariance`]; [`GraphError::OutOfMemory`].
    pub fn covariances(&mut self, variables: &[VariableId]) -> Result<Vec<DMatrix<f64>>, GraphError> {
        let places = variables.iter().map(|&id| self.place(id)).collect::<Result<Vec<_>, _>>()?;
        self.cholesky.invert()?;
        let mut covariances = Vec::with_capacity(variables.len());
        for (&id, place) in variables.iter().zip(places) {
            let dim = self.values.dim(id);
            covariances.push(DMatrix::from_fn(dim, dim, |i, j| {
                // Both triangles read the same entry: the matrix is symmetric to the last bit.
                let entry = |start: usize| {
                    let (i, j) = (start + i.max(j), start + i.min(j));
                    let pinned = self.cholesky.inverse_entry(i, j)? * self.scale[i] * self.scale[j];
                    Some(pinned + self.free.as_ref().map_or(0.0, |free| free.correction(i, j)))
                };
                place.and_then(entry).unwrap_or(0.0)
            }));
        }
        Ok(covariances)
    }

    /// D×D covariance of one group element on the **global (left) side**, X = Exp(ξ)·X̄: Ad_X̄ Σ Ad_X̄ᵀ, exactly.
    ///
    /// # Errors
    /// As [`Self::covariance`].
    pub fn covariance_global<G: GroupVariable<D>, const D: usize>(
        &mut self,
        variable: Key<G>,
    ) -> Result<DMatrix<f64>, GraphError> {
        let local = self.covariance(variable)?;
        let mean =
            self.values.get(variable).ok_or(GraphError::Unread { variable: self.values.name(variable) })?;
        let adjoint = DMatrix::from_column_slice(D, D, mean.adjoint().as_slice());
        Ok(&adjoint * local * adjoint.transpose())
    }

    /// Joint covariance of several variables, local side each, in the order given: its blocks off the diagonal are their
    /// correlations.
    ///
    /// # Errors
    /// As [`Self::covariance`].
    pub fn joint(&mut self, variables: &[VariableId]) -> Result<DMatrix<f64>, GraphError> {
        let mut rows = vec![]; // each coordinate's place in the structure; none for held variables
        for &id in variables {
            let place = self.place(id)?;
            rows.extend((0..self.values.dim(id)).map(|i| place.map(|start| start + i)));
        }
        let size = self.structure.size();
        let free: Vec<usize> = rows.iter().flatten().copied().collect();
        let mut columns = vec![0.0; size * free.len()];
        free.iter().enumerate().for_each(|(k, &row)| columns[k * size + row] = 1.0);
        self.cholesky.solve(&mut columns);

        let mut covariance = DMatrix::zeros(rows.len(), rows.len());
        let mut k = 0;
        for (j, column) in rows.iter().enumerate() {
            let Some(column) = *column else { continue };
            for (i, row) in rows.iter().enumerate() {
                let Some(row) = *row else { continue };
                let correction = self.free.as_ref().map_or(0.0, |free| free.correction(row, column));
                covariance[(i, j)] =
                    columns[k * size + row] * self.scale[row] * self.scale[column] + correction;
            }
            k += 1;
        }
        Ok((&covariance + covariance.transpose()) * 0.5)
    }

    /// Where the coordinates of a variable start in the structure; nowhere where it is held.
    fn place(&self, id: VariableId) -> Result<Option<usize>, GraphError> {
        let place = self.structure.offsets.get(id);
        if place.is_some() || self.values.is_held(id) {
            return Ok(place);
        }
        Err(match self.values.state(id) {
            Some(_) => GraphError::Unread { variable: self.values.name(id) },
            None => GraphError::ForeignKey { kind: self.values.name(id).kind, number: id.slot },
        })
    }
}
