//! Factors in store: all of one type together, so that no virtual call is made per factor.

use core::any::{Any, TypeId};
use core::ops::Range;

use nalgebra::DVector;

use super::Kernel;
use super::factor::{Factor, Slots, Variables};
use super::linear::kernels::Kernels;
use super::linear::structure::{Normal, SetPlan};
use super::linear::vector::dot;
use super::noise::Noise;
use super::renewal::Renewal;
use super::values::{Offsets, Values, VariableId};

/// All factors of one type.
pub(crate) struct FactorSet<F: Factor<R>, const R: usize> {
    pub(crate) factors: Vec<F>,
    pub(crate) slots: Vec<Slots>,
    pub(crate) noises: Vec<Noise<R>>,
    kernels: Vec<Kernel>,
}

impl<F: Factor<R>, const R: usize> FactorSet<F, R> {
    pub(crate) fn new() -> Self {
        Self { factors: vec![], slots: vec![], noises: vec![], kernels: vec![] }
    }

    pub(crate) fn push(&mut self, slots: Slots, factor: F, noise: Noise<R>, kernel: Kernel) -> usize {
        self.factors.push(factor);
        self.slots.push(slots);
        self.noises.push(noise);
        self.kernels.push(kernel);
        self.factors.len() - 1
    }

    /// Overwrites `out` with the part of one factor: gradient, then the blocks Jᵀ_q J_p, p ≤ q.
    #[inline(always)]
    fn linearise_one(&self, index: usize, variables: &F::Variables, out: &mut [f64]) {
        let (residual, jacobians) = self.factors[index].residual_jac(variables);
        let u = self.noises[index].sqrt_information();
        let whitened = u * residual;
        let weight = self.kernels[index].weight(whitened.norm_squared());
        F::Variables::whiten(&jacobians, u, |w| {
            normal_equations::<R>(F::Variables::DIMS, w, whitened.as_slice(), weight, out);
        });
    }
}

/// Writes Jᵀr for each variable and then Jᵀ_q J_p for each pair p ≤ q, times `weight`; `w` holds Jᵀ, D×R.
#[inline(always)]
pub(crate) fn normal_equations<const R: usize>(
    dims: &[usize],
    w: &[&[f64]],
    r: &[f64],
    weight: f64,
    out: &mut [f64],
) {
    let mut at = 0;
    for (&d, w) in dims.iter().zip(w) {
        for i in 0..d {
            let mut sum = 0.0;
            for k in 0..R {
                sum += w[k * d + i] * r[k];
            }
            out[at + i] = weight * sum;
        }
        at += d;
    }
    for q in 0..dims.len() {
        for p in 0..=q {
            let (dp, dq) = (dims[p], dims[q]);
            for column in 0..dp {
                let target = &mut out[at..at + dq];
                target.fill(0.0);
                for k in 0..R {
                    let factor = weight * w[p][k * dp + column];
                    for (t, x) in target.iter_mut().zip(&w[q][k * dq..(k + 1) * dq]) {
                        *t += factor * x;
                    }
                }
                at += dq;
            }
        }
    }
}

/// Numbers that one factor of these dimensions adds to the normal equations.
pub(crate) const fn stride(dims: &[usize]) -> usize {
    let (mut total, mut q) = (0, 0);
    while q < dims.len() {
        total += dims[q];
        let mut p = 0;
        while p <= q {
            total += dims[p] * dims[q];
            p += 1;
        }
        q += 1;
    }
    total
}

/// Adds to `slopes` the derivatives along the `directions` by one variable, which is at `place` in them: weight·J·d, with J by rows.
pub(crate) fn add_slopes(
    rows: &[f64],
    place: Range<usize>,
    weight: f64,
    directions: &[Vec<f64>],
    slopes: &mut [DVector<f64>],
) {
    for (slope, row) in slopes.iter_mut().zip(rows.chunks_exact(place.len())) {
        for (k, direction) in directions.iter().enumerate() {
            slope[k] += weight * dot(row, &direction[place.clone()]);
        }
    }
}

/// A [`FactorSet`] whose type is forgotten: one virtual call per chunk of factors.
pub(crate) trait AnySet: Any + Send + Sync {
    fn name(&self) -> &'static str;
    fn is_relative(&self) -> bool;
    fn len(&self) -> usize;
    fn dims(&self) -> &[usize];
    /// The kinds of the variables that each factor reads, and their slots.
    fn kinds(&self) -> Vec<TypeId>;
    fn slots(&self, index: usize) -> &Slots;
    /// What messages call the kinds.
    fn kind_names(&self) -> &[&'static str];
    /// The variables of a factor.
    fn ids(&self, index: usize) -> Vec<VariableId> {
        self.kinds()
            .into_iter()
            .zip(self.slots(index))
            .map(|(kind, &slot)| VariableId { kind, slot })
            .collect()
    }
    /// Cost of the factors of `range` in order; not a number where a variable has no value.
    fn cost(&self, values: &Values, range: Range<usize>) -> f64;
    /// ‖U·r‖² of one factor.
    fn squared(&self, values: &Values, index: usize) -> f64;
    /// Overwrites `out` with each factor's part of the normal equations, [`stride`] numbers a factor; no numbers where a variable
    /// has no value.
    fn linearise(&self, values: &Values, range: Range<usize>, out: &mut [f64]);
    /// Replaces factors that were linearised about a value of their variables by those about `values`.
    fn renew(&mut self, values: &Values) -> Renewal;
    /// Dimension R of the residual.
    fn residual_dim(&self) -> usize;
    /// Overwrites `slopes[r][k]` with the derivative of the r-th whitened residual of a factor along the k-th direction.
    fn slopes(
        &self,
        values: &Values,
        index: usize,
        offsets: &Offsets,
        directions: &[Vec<f64>],
        slopes: &mut [DVector<f64>],
    );
    /// Adds what [`Self::linearise`] wrote to the normal equations, factor by factor.
    fn scatter(&self, range: Range<usize>, parts: &[f64], plan: &SetPlan, normal: &mut Normal);
    /// The factors that are to be kept, in a set of their own.
    fn part(&self, keep: &dyn Fn(usize) -> bool) -> Box<dyn AnySet>;
    /// By factor.
    fn kernels(&self) -> &[Kernel];
    fn kernels_mut(&mut self) -> &mut [Kernel];
    fn as_any(&self) -> &dyn Any;
    fn as_any_mut(&mut self) -> &mut dyn Any;
}

/// Where the variables of a set's factors stand in an [`Offsets`] table, looked up without a search for each.
pub(crate) struct Places<'a> {
    set: &'a dyn AnySet,
    tables: Vec<&'a [u32]>,
}

impl<'a> Places<'a> {
    pub(crate) fn new(set: &'a dyn AnySet, offsets: &'a Offsets) -> Self {
        Self { set, tables: set.kinds().into_iter().map(|kind| offsets.of(kind)).collect() }
    }

    /// The place of each variable of a factor, in order; `None` where it has none.
    pub(crate) fn of(&self, factor: usize) -> impl Iterator<Item = Option<usize>> {
        let place = |(table, &slot): (&&[u32], &u32)| table.get(slot as usize).copied();
        self.tables
            .iter()
            .zip(self.set.slots(factor))
            .map(place)
            .map(|place| place.filter(|&place| place != Offsets::NONE).map(|place| place as usize))
    }
}

impl<F: Factor<R>, const R: usize> AnySet for FactorSet<F, R> {
    fn name(&self) -> &'static str {
        F::NAME
    }
    fn is_relative(&self) -> bool {
        F::RELATIVE
    }
    fn len(&self) -> usize {
        self.factors.len()
    }
    fn dims(&self) -> &[usize] {
        F::Variables::DIMS
    }
    fn kinds(&self) -> Vec<TypeId> {
        F::Variables::kinds().iter().map(|kind| kind()).collect()
    }
    fn slots(&self, index: usize) -> &Slots {
        &self.slots[index]
    }
    fn kind_names(&self) -> &[&'static str] {
        F::Variables::NAMES
    }
    fn cost(&self, values: &Values, range: Range<usize>) -> f64 {
        let stores = F::Variables::stores(values);
        let mut cost = 0.0;
        for index in range {
            let Some(variables) = F::Variables::gather(&stores, &self.slots[index]) else { return f64::NAN };
            let residual = self.factors[index].residual::<f64>(&variables.constant());
            let squared = (self.noises[index].sqrt_information() * residual).norm_squared();
            cost += 0.5 * self.kernels[index].evaluate(squared).0;
        }
        cost
    }
    fn squared(&self, values: &Values, index: usize) -> f64 {
        let stores = F::Variables::stores(values);
        F::Variables::gather(&stores, &self.slots[index]).map_or(f64::NAN, |variables| {
            let residual = self.factors[index].residual::<f64>(&variables.constant());
            (self.noises[index].sqrt_information() * residual).norm_squared()
        })
    }
    fn linearise(&self, values: &Values, range: Range<usize>, out: &mut [f64]) {
        let stores = F::Variables::stores(values);
        Kernels::new().run(|| {
            for (index, out) in range.zip(out.chunks_exact_mut(stride(F::Variables::DIMS))) {
                match F::Variables::gather(&stores, &self.slots[index]) {
                    Some(variables) => self.linearise_one(index, &variables, out),
                    None => out.fill(f64::NAN),
                }
            }
        });
    }
    fn renew(&mut self, values: &Values) -> Renewal {
        let stores = F::Variables::stores(values);
        let mut renewal = Renewal::default();
        for ((factor, slots), noise) in self.factors.iter_mut().zip(&self.slots).zip(&mut self.noises) {
            let renewed =
                F::Variables::gather(&stores, slots).and_then(|variables| factor.renewed(&variables));
            let Some(renewed) = renewed else { continue };
            (*factor, *noise) = (renewed.factor, renewed.noise);
            renewal = renewal.and(Renewal { factors: 1, largest: renewed.error });
        }
        renewal
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
        let stores = F::Variables::stores(values);
        let Some(variables) = F::Variables::gather(&stores, &self.slots[index]) else { return };
        let (residual, jacobians) = self.factors[index].residual_jac(&variables);
        let u = self.noises[index].sqrt_information();
        let weight = self.kernels[index].weight((u * residual).norm_squared()).sqrt();
        F::Variables::whiten(&jacobians, u, |whitened| {
            for ((id, w), &dim) in self.ids(index).iter().zip(whitened).zip(F::Variables::DIMS) {
                let Some(start) = offsets.get(*id) else { continue };
                add_slopes(w, start..start + dim, weight, directions, slopes);
            }
        });
    }
    fn scatter(&self, range: Range<usize>, parts: &[f64], plan: &SetPlan, normal: &mut Normal) {
        for (index, part) in range.zip(parts.chunks_exact(stride(F::Variables::DIMS))) {
            plan.scatter(index, F::Variables::DIMS, part, normal);
        }
    }
    fn part(&self, keep: &dyn Fn(usize) -> bool) -> Box<dyn AnySet> {
        let mut part = Self::new();
        for index in (0..self.len()).filter(|&index| keep(index)) {
            let (factor, noise) = (self.factors[index].clone(), self.noises[index]);
            part.push(self.slots[index], factor, noise, self.kernels[index]);
        }
        Box::new(part)
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
