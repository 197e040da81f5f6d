//! Factors whose residuals are computed together.

use core::any::{Any, TypeId};
use core::ops::Range;
use std::sync::Arc;

use nalgebra::DVector;

use super::factor::{MAX_ARITY, Slots};
use super::linear::structure::{Normal, SetPlan};
use super::linear::vector::dot;
use super::noise::Noise;
use super::renewal::Renewal;
use super::set::{AnySet, add_slopes, normal_equations, stride};
use super::values::{Offsets, Values, VariableId};
use super::{FactorId, Graph, GraphError, Kernel};

/// Factors of one kind with residuals of dimension R, computed many at a time: where each call costs much, as into another
/// language, or where many at a time cost little, as with vector instructions. A [`Factor`](super::Factor) is simpler, and faster
/// where neither holds.
///
/// ```
/// use boxplus::graph::{FactorBatch, Graph, Key, Kernel, Noise, SolveOptions, Values, VariableId};
/// use boxplus::lie::Rn;
/// use core::ops::Range;
/// use nalgebra::vector;
///
/// /// Springs between numbers: b − a = length.
/// struct Springs { ends: Vec<[Key<Rn<1>>; 2]>, lengths: Vec<f64> }
/// impl FactorBatch<1> for Springs {
///     fn name(&self) -> &'static str { "spring" }
///     fn is_relative(&self) -> bool { true }
///     fn residuals(&self, values: &Values, range: Range<usize>, residuals: &mut [f64]) {
///         let at = |key| values.get(key).map_or(f64::NAN, |x: &Rn<1>| x.vector()[0]);
///         for (i, r) in range.zip(residuals) {
///             *r = at(self.ends[i][1]) - at(self.ends[i][0]) - self.lengths[i];
///         }
///     }
///     fn residuals_jac(&self, values: &Values, range: Range<usize>, residuals: &mut [f64], jacobians: &mut [&mut [f64]]) {
///         self.residuals(values, range, residuals);
///         jacobians[0].fill(-1.0);
///         jacobians[1].fill(1.0);
///     }
/// }
///
/// let (mut graph, mut values) = (Graph::new(), Values::new());
/// let keys: Vec<_> = (0..3).map(|_| values.insert(Rn::new(vector![0.0]))).collect();
/// values.hold(keys[0]);
/// let springs = Springs { ends: vec![[keys[0], keys[1]], [keys[1], keys[2]]], lengths: vec![1.0, 2.0] };
/// let column = |end: usize| springs.ends.iter().map(|ends| ends[end].into()).collect::<Vec<VariableId>>();
/// let columns = [column(0), column(1)];
/// graph.add_batch(&values, &columns, springs, vec![Noise::unit(); 2], Kernel::None)?;
/// let solution = graph.optimize(&values, &SolveOptions::default())?;
/// assert!((solution.values.get(keys[2]).unwrap().vector()[0] - 3.0).abs() < 1e-9);
/// # Ok::<(), boxplus::graph::GraphError>(())
/// ```
pub trait FactorBatch<const R: usize>: Send + Sync + 'static {
    /// What messages call each factor.
    fn name(&self) -> &'static str;

    /// As [`Factor::RELATIVE`](super::Factor::RELATIVE), of all of them.
    fn is_relative(&self) -> bool {
        false
    }

    /// Overwrites `residuals` with those of the factors of `range` at `values`, R numbers each, not whitened. A NaN says that there
    /// is none.
    fn residuals(&self, values: &Values, range: Range<usize>, residuals: &mut [f64]);

    /// As [`Self::residuals`], and overwrites `jacobians[v]` with the derivatives by the v-th variable of each factor, on the local
    /// (right) side: R×D numbers each, row by row.
    fn residuals_jac(
        &self,
        values: &Values,
        range: Range<usize>,
        residuals: &mut [f64],
        jacobians: &mut [&mut [f64]],
    );
}

impl Graph {
    /// Adds factors that are computed together. `columns[v][i]` is the v-th variable of the i-th factor, `noises[i]` its noise.
    ///
    /// # Errors
    /// [`GraphError::UnevenBatch`] unless there are one to four columns, each of one kind and as long as `noises`;
    /// [`GraphError::ForeignKey`] for a variable of other values.
    pub fn add_batch<const R: usize>(
        &mut self,
        values: &Values,
        columns: &[Vec<VariableId>],
        batch: impl FactorBatch<R>,
        noises: Vec<Noise<R>>,
        kernel: Kernel,
    ) -> Result<Vec<FactorId>, GraphError> {
        let even = |column: &Vec<VariableId>| {
            column.len() == noises.len() && column.iter().all(|id| id.kind == column[0].kind)
        };
        if !(1..=MAX_ARITY).contains(&columns.len()) || !columns.iter().all(even) {
            return Err(GraphError::UnevenBatch { factors: noises.len() });
        }
        if let Some(&id) = columns.iter().flatten().find(|id| values.state(**id).is_none()) {
            return Err(GraphError::ForeignKey { kind: values.name(id).kind, number: id.slot });
        }
        if noises.is_empty() {
            return Ok(vec![]);
        }
        let (set, count) = (self.sets.len() as u32, noises.len());
        let first = || columns.iter().map(|column| column[0]);
        self.sets.push(Box::new(BatchSet {
            kinds: first().map(|id| id.kind).collect(),
            names: first().map(|id| values.name(id).kind).collect(),
            dims: first().map(|id| values.dim(id)).collect(),
            slots: (0..count).map(|i| slots_of(columns, i)).collect(),
            kernels: vec![kernel; count],
            noises,
            places: (0..count).collect(),
            batch: Arc::new(batch),
        }));
        Ok((0..count as u32).map(|index| FactorId { set, index }).collect())
    }
}

fn slots_of(columns: &[Vec<VariableId>], factor: usize) -> Slots {
    core::array::from_fn(|place| columns.get(place).map_or(0, |column| column[factor].slot))
}

/// A batch with its variables and noises.
struct BatchSet<B, const R: usize> {
    batch: Arc<B>,
    /// Of each factor in the batch; ascending.
    places: Vec<usize>,
    /// Of the variables that each factor reads, in order.
    kinds: Vec<TypeId>,
    names: Vec<&'static str>,
    dims: Vec<usize>,
    slots: Vec<Slots>,
    noises: Vec<Noise<R>>,
    kernels: Vec<Kernel>,
}

impl<B: FactorBatch<R>, const R: usize> BatchSet<B, R> {
    /// The places of the factors of `range` in the batch, as ranges.
    fn runs(&self, range: Range<usize>) -> impl Iterator<Item = Range<usize>> {
        let runs = self.places[range].chunk_by(|a, b| a + 1 == *b);
        runs.map(|run| run[0]..run[0] + run.len())
    }

    /// U·r of the factors of `range`.
    fn whitened(&self, values: &Values, range: Range<usize>) -> Vec<f64> {
        let mut residuals = vec![f64::NAN; R * range.len()];
        let mut rest = &mut residuals[..];
        for run in self.runs(range.clone()) {
            let (own, others) = rest.split_at_mut(R * run.len());
            self.batch.residuals(values, run, own);
            rest = others;
        }
        self.whiten(range, &mut residuals, 1);
        residuals
    }

    /// U·r and U·J of the factors of `range`, row by row.
    fn whitened_jac(&self, values: &Values, range: Range<usize>) -> (Vec<f64>, Vec<Vec<f64>>) {
        let mut residuals = vec![f64::NAN; R * range.len()];
        let mut jacobians: Vec<_> = self.dims.iter().map(|d| vec![f64::NAN; R * d * range.len()]).collect();
        let (mut rest, mut rows) =
            (&mut residuals[..], jacobians.iter_mut().map(|j| &mut j[..]).collect::<Vec<_>>());
        for run in self.runs(range.clone()) {
            let (own, others) = rest.split_at_mut(R * run.len());
            let split =
                rows.into_iter().zip(&self.dims).map(|(row, dim)| row.split_at_mut(R * dim * run.len()));
            let (mut own_rows, other_rows): (Vec<_>, Vec<_>) = split.unzip();
            self.batch.residuals_jac(values, run, own, &mut own_rows);
            (rest, rows) = (others, other_rows);
        }
        self.whiten(range.clone(), &mut residuals, 1);
        for (jacobian, &dim) in jacobians.iter_mut().zip(&self.dims) {
            self.whiten(range.clone(), jacobian, dim);
        }
        (residuals, jacobians)
    }

    /// Multiplies matrices of R rows, one for each factor of `range`, by U from the left.
    fn whiten(&self, range: Range<usize>, matrices: &mut [f64], columns: usize) {
        for (noise, matrix) in self.noises[range].iter().zip(matrices.chunks_exact_mut(R * columns)) {
            let u = noise.sqrt_information();
            // U is upper triangular: a row needs itself and those below, which are still as they were.
            for r in 0..R {
                for c in 0..columns {
                    matrix[r * columns + c] = (r..R).map(|k| u[(r, k)] * matrix[k * columns + c]).sum();
                }
            }
        }
    }
}

impl<B: FactorBatch<R>, const R: usize> AnySet for BatchSet<B, R> {
    fn name(&self) -> &'static str {
        self.batch.name()
    }
    fn is_relative(&self) -> bool {
        self.batch.is_relative()
    }
    fn len(&self) -> usize {
        self.slots.len()
    }
    fn dims(&self) -> &[usize] {
        &self.dims
    }
    fn kinds(&self) -> Vec<TypeId> {
        self.kinds.clone()
    }
    fn slots(&self, index: usize) -> &Slots {
        &self.slots[index]
    }
    fn kind_names(&self) -> &[&'static str] {
        &self.names
    }
    fn cost(&self, values: &Values, range: Range<usize>) -> f64 {
        let whitened = self.whitened(values, range.clone());
        let squares = whitened.chunks_exact(R).map(|r| dot(r, r));
        self.kernels[range].iter().zip(squares).map(|(kernel, s)| 0.5 * kernel.evaluate(s).0).sum()
    }
    fn squared(&self, values: &Values, index: usize) -> f64 {
        let whitened = self.whitened(values, index..index + 1);
        dot(&whitened, &whitened)
    }
    fn linearise(&self, values: &Values, range: Range<usize>, out: &mut [f64]) {
        let (residuals, jacobians) = self.whitened_jac(values, range.clone());
        for (i, (kernel, out)) in
            self.kernels[range].iter().zip(out.chunks_exact_mut(stride(&self.dims))).enumerate()
        {
            let r = &residuals[i * R..][..R];
            let weight = kernel.weight(dot(r, r));
            let rows: [&[f64]; MAX_ARITY] = core::array::from_fn(|v| {
                jacobians.get(v).map_or(&[][..], |j| &j[i * R * self.dims[v]..][..R * self.dims[v]])
            });
            normal_equations::<R>(&self.dims, &rows[..self.dims.len()], r, weight, out);
        }
    }
    fn renew(&mut self, _: &Values) -> Renewal {
        Renewal::default()
    }
    fn residual_dim(&self) -> usize {
        R
    }
    fn slopes(
        &self,
        values: &Values,
        index: usize,
        offsets: &Offsets,
        directions: &[Vec<f64>],
        slopes: &mut [DVector<f64>],
    ) {
        slopes.iter_mut().for_each(|slope| slope.fill(0.0));
        let (residuals, jacobians) = self.whitened_jac(values, index..index + 1);
        let weight = self.kernels[index].weight(dot(&residuals, &residuals)).sqrt();
        for ((id, rows), &dim) in self.ids(index).iter().zip(&jacobians).zip(&self.dims) {
            let Some(start) = offsets.get(*id) else { continue };
            add_slopes(rows, start..start + dim, weight, directions, slopes);
        }
    }
    fn scatter(&self, range: Range<usize>, parts: &[f64], plan: &SetPlan, normal: &mut Normal) {
        for (index, part) in range.zip(parts.chunks_exact(stride(&self.dims))) {
            plan.scatter(index, &self.dims, part, normal);
        }
    }
    fn part(&self, keep: &dyn Fn(usize) -> bool) -> Box<dyn AnySet> {
        let kept: Vec<usize> = (0..self.len()).filter(|&index| keep(index)).collect();
        Box::new(Self {
            batch: Arc::clone(&self.batch),
            places: kept.iter().map(|&index| self.places[index]).collect(),
            kinds: self.kinds.clone(),
            names: self.names.clone(),
            dims: self.dims.clone(),
            slots: kept.iter().map(|&index| self.slots[index]).collect(),
            noises: kept.iter().map(|&index| self.noises[index]).collect(),
            kernels: kept.iter().map(|&index| self.kernels[index]).collect(),
        })
    }
    fn kernels(&self) -> &[Kernel] {
        &self.kernels
    }
    fn kernels_mut(&mut self) -> &mut [Kernel] {
        &mut self.kernels
    }
    fn as_any(&self) -> &dyn Any {
        self
    }
    fn as_any_mut(&mut self) -> &mut dyn Any {
        self
    }
}
