//! Factors: measurements between variables, stored by type so that no virtual call is made per factor.

use core::any::{Any, TypeId};
use core::fmt::Debug;
use core::ops::Range;

use nalgebra::{DVector, SMatrix, SVector};

use super::linear::structure::{Normal, SetPlan};
use super::linear::vector::dot;
use super::noise::Noise;
use super::robust::Kernel;
use super::values::{Key, Offsets, Values, VariableId};
use super::variable::{JacobianBlock, TangentResidual, Variable};
use crate::lie::Real;

/// A measurement: a residual of dimension R that is zero where the variables agree with it.
///
/// Write [`Self::residual`] for every scalar; its Jacobians then are exact, by dual numbers over the tangents. Override
/// [`Self::residual_jac`] where a closed form is known; a test can hold it against [`dual_jacobians`].
///
/// ```
/// use boxplus::graph::{Factor, Graph, Noise, Values};
/// use boxplus::lie::{LieGroup, Real, SE2};
/// use nalgebra::{vector, SVector};
///
/// /// Odometer: the distance driven between two poses, whatever the direction.
/// struct Distance(f64);
/// impl Factor<1> for Distance {
///     const NAME: &'static str = "distance driven";
///     const RELATIVE: bool = true;
///     type Variables = (SE2, SE2);
///     fn residual<S: Real>(&self, (a, b): &(SE2<S>, SE2<S>)) -> SVector<S, 1> {
///         vector![(b.translation() - a.translation()).norm() - S::lit(self.0)]
///     }
/// }
///
/// let (mut graph, mut values) = (Graph::new(), Values::new());
/// let keys = (values.insert(SE2::identity()), values.insert(SE2::new(vector![1.0, 0.0], 0.0)));
/// graph.add(keys, Distance(2.0), Noise::from_sigmas(&vector![0.1])?);
/// assert!((graph.cost(&values)? - 50.0).abs() < 1e-12); // ½ (1 m / 0.1 m)²
/// # Ok::<(), boxplus::graph::GraphError>(())
/// ```
pub trait Factor<const R: usize>: Send + Sync + 'static {
    /// What messages call it.
    const NAME: &'static str;
    /// Whether it measures its variables against each other only, so that moving all of them together, as one rigid
    /// world, changes nothing. Where all factors of a connected part are such, one of its variables is held.
    const RELATIVE: bool = false;
    /// The variables it reads, as a tuple of one to four.
    type Variables: Variables;

    /// The residual, not whitened, in the units of the measurement.
    fn residual<S: Real>(&self, variables: &<Self::Variables as Variables>::Over<S>) -> SVector<S, R>;

    /// The residual and its Jacobian by each variable, on the local (right) side: R×D each, in order.
    fn residual_jac(
        &self,
        variables: &Self::Variables,
    ) -> (SVector<f64, R>, <Self::Variables as Variables>::Jacobians<R>) {
        (self.residual::<f64>(&variables.constant()), dual_jacobians(self, variables))
    }
}

/// The exact Jacobians of a factor's residual by dual numbers, whatever its own `residual_jac` says.
pub fn dual_jacobians<const R: usize, F: Factor<R> + ?Sized>(
    factor: &F,
    variables: &F::Variables,
) -> <F::Variables as Variables>::Jacobians<R> {
    F::Variables::derivatives(factor, variables)
}

/// The residual of a factor as a function of the tangent of one of its variables.
struct Along<'a, F: ?Sized, V> {
    factor: &'a F,
    variables: &'a V,
    position: usize,
}

impl<const R: usize, F: Factor<R> + ?Sized> TangentResidual<R> for Along<'_, F, F::Variables> {
    fn at<S: Real>(&self, delta: &[S]) -> SVector<S, R> {
        self.factor.residual(&self.variables.perturb(self.position, delta))
    }
}

/// Most variables one factor reads.
pub const MAX_ARITY: usize = 4;

/// Slots of a factor's variables in their stores; the unused ones are zero.
pub(crate) type Slots = [u32; MAX_ARITY];

/// A tuple of one to four [`Variable`]s.
pub trait Variables: Copy + Send + Sync + 'static {
    /// Tangent dimension of each.
    const DIMS: &'static [usize];
    /// A key for each.
    type Keys: Copy;
    /// The same tuple over another scalar.
    type Over<S: Real>;
    /// R×D matrices, one for each.
    type Jacobians<const R: usize>: Copy;
    /// The stores the values are read from.
    #[doc(hidden)]
    type Stores<'a>: Copy;

    /// The tuple carried into `S` as constants.
    fn constant<S: Real>(&self) -> Self::Over<S>;
    /// The tuple with the element at `position` moved by `delta`.
    fn perturb<S: Real>(&self, position: usize, delta: &[S]) -> Self::Over<S>;
    /// Exact Jacobians by dual numbers.
    fn derivatives<const R: usize, F: Factor<R, Variables = Self> + ?Sized>(
        factor: &F,
        at: &Self,
    ) -> Self::Jacobians<R>;
    #[doc(hidden)]
    fn kinds() -> &'static [fn() -> TypeId];
    #[doc(hidden)]
    fn slots(keys: &Self::Keys) -> [u32; MAX_ARITY];
    #[doc(hidden)]
    fn keys(slots: &[u32; MAX_ARITY]) -> Self::Keys;
    #[doc(hidden)]
    fn stores(values: &Values) -> Self::Stores<'_>;
    #[doc(hidden)]
    fn gather(stores: &Self::Stores<'_>, slots: &[u32; MAX_ARITY]) -> Option<Self>;
    /// Calls `with` on (U·J)ᵀ of each variable: D×R, column by column.
    #[doc(hidden)]
    fn whiten<const R: usize, T>(
        jacobians: &Self::Jacobians<R>,
        sqrt_information: &SMatrix<f64, R, R>,
        with: impl FnOnce(&[&[f64]]) -> T,
    ) -> T;
}

macro_rules! variables {
    ($($v:ident $x:ident $position:tt),+) => {
        impl<$($v: Variable),+> Variables for ($($v,)+) {
            const DIMS: &'static [usize] = &[$($v::DIM),+];
            type Keys = ($(Key<$v>,)+);
            type Over<S: Real> = ($($v::Over<S>,)+);
            type Jacobians<const R: usize> = ($($v::Jacobian<R>,)+);
            type Stores<'a> = ($(&'a [Option<$v>],)+);

            fn constant<S: Real>(&self) -> Self::Over<S> {
                ($(self.$position.constant(),)+)
            }
            fn perturb<S: Real>(&self, position: usize, delta: &[S]) -> Self::Over<S> {
                ($(if position == $position { self.$position.perturb(delta) } else { self.$position.constant() },)+)
            }
            fn derivatives<const R: usize, F: Factor<R, Variables = Self> + ?Sized>(factor: &F, variables: &Self) -> Self::Jacobians<R> {
                ($($v::derivative(&Along { factor, variables, position: $position }),)+)
            }
            fn kinds() -> &'static [fn() -> TypeId] {
                &[$(TypeId::of::<$v>),+]
            }
            fn slots(keys: &Self::Keys) -> [u32; MAX_ARITY] {
                let mut slots = [0; MAX_ARITY];
                $(slots[$position] = keys.$position.slot;)+
                slots
            }
            fn keys(slots: &[u32; MAX_ARITY]) -> Self::Keys {
                ($(Key::<$v>::new(slots[$position]),)+)
            }
            fn stores(values: &Values) -> Self::Stores<'_> {
                ($(values.slice::<$v>(),)+)
            }
            #[inline]
            fn gather(stores: &Self::Stores<'_>, slots: &[u32; MAX_ARITY]) -> Option<Self> {
                Some(($(stores.$position.get(slots[$position] as usize).copied().flatten()?,)+))
            }
            #[inline]
            fn whiten<const R: usize, T>(
                jacobians: &Self::Jacobians<R>,
                sqrt_information: &SMatrix<f64, R, R>,
                with: impl FnOnce(&[&[f64]]) -> T,
            ) -> T {
                $(let $x = whitened_transpose::<R, $v>(&jacobians.$position, sqrt_information);)+
                with(&[$($x.as_slice()),+])
            }
        }
    };
}
variables!(A a 0);
variables!(A a 0, B b 1);
variables!(A a 0, B b 1, C c 2);
variables!(A a 0, B b 1, C c 2, D d 3);

/// (U·J)ᵀ for an upper triangular U: D×R, so that all later loops run along contiguous columns.
#[inline]
fn whitened_transpose<const R: usize, V: Variable>(
    jacobian: &V::Jacobian<R>,
    u: &SMatrix<f64, R, R>,
) -> V::Jacobian<R> {
    let mut out = V::Jacobian::<R>::zeros();
    let (j, w) = (jacobian.as_slice(), out.as_mut_slice());
    for r in 0..R {
        for k in r..R {
            let u_rk = u[(r, k)];
            for d in 0..V::DIM {
                w[r * V::DIM + d] += u_rk * j[d * R + k];
            }
        }
    }
    out
}

/// Identifies a factor in its graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FactorId {
    pub(crate) set: u32,
    pub(crate) index: u32,
}

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

    /// Adds the part of one factor to `out` (gradient, then the blocks Jᵀ_q J_p, p ≤ q) and returns its cost.
    #[inline]
    fn linearise_one(&self, index: usize, variables: &F::Variables, out: &mut [f64]) -> f64 {
        let (residual, jacobians) = self.factors[index].residual_jac(variables);
        let u = self.noises[index].sqrt_information();
        let whitened = u * residual;
        let (rho, weight) = self.kernels[index].evaluate(whitened.norm_squared());
        F::Variables::whiten(&jacobians, u, |w| {
            normal_equations::<R>(F::Variables::DIMS, w, whitened.as_slice(), weight, out);
        });
        0.5 * rho
    }
}

/// Writes Jᵀr for each variable and then Jᵀ_q J_p for each pair p ≤ q, times `weight`; `w` holds Jᵀ, D×R.
#[inline(always)]
fn normal_equations<const R: usize>(dims: &[usize], w: &[&[f64]], r: &[f64], weight: f64, out: &mut [f64]) {
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

/// A [`FactorSet`] whose type is forgotten: one virtual call per chunk of factors.
pub(crate) trait AnySet: Any + Send + Sync {
    fn name(&self) -> &'static str;
    fn is_relative(&self) -> bool;
    fn len(&self) -> usize;
    fn dims(&self) -> &'static [usize];
    /// The kinds of the variables that each factor reads, and their slots.
    fn kinds(&self) -> &'static [fn() -> TypeId];
    fn slots(&self, index: usize) -> &Slots;
    /// The variables of a factor.
    fn ids(&self, index: usize) -> Vec<VariableId> {
        self.kinds()
            .iter()
            .zip(self.slots(index))
            .map(|(kind, &slot)| VariableId { kind: kind(), slot })
            .collect()
    }
    /// Cost of the factors of `range` in order; not a number where a variable has no value.
    fn cost(&self, values: &Values, range: Range<usize>) -> f64;
    /// ‖U·r‖² of one factor.
    fn squared(&self, values: &Values, index: usize) -> f64;
    /// Cost of `range`, and each factor's part of the normal equations, [`stride`] numbers a factor, into `out`.
    fn linearise(&self, values: &Values, range: Range<usize>, out: &mut [f64]) -> f64;
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
    fn set_kernel(&mut self, kernel: Kernel);
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
        Self { set, tables: set.kinds().iter().map(|kind| offsets.of(kind())).collect() }
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
    fn dims(&self) -> &'static [usize] {
        F::Variables::DIMS
    }
    fn kinds(&self) -> &'static [fn() -> TypeId] {
        F::Variables::kinds()
    }
    fn slots(&self, index: usize) -> &Slots {
        &self.slots[index]
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
    fn linearise(&self, values: &Values, range: Range<usize>, out: &mut [f64]) -> f64 {
        let stores = F::Variables::stores(values);
        let mut cost = 0.0;
        for (index, out) in range.zip(out.chunks_exact_mut(stride(F::Variables::DIMS))) {
            let Some(variables) = F::Variables::gather(&stores, &self.slots[index]) else { return f64::NAN };
            cost += self.linearise_one(index, &variables, out);
        }
        cost
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
                for (slope, row) in slopes.iter_mut().zip(w.chunks_exact(dim)) {
                    for (k, direction) in directions.iter().enumerate() {
                        slope[k] += weight * dot(row, &direction[start..start + dim]);
                    }
                }
            }
        });
    }
    fn scatter(&self, range: Range<usize>, parts: &[f64], plan: &SetPlan, normal: &mut Normal) {
        for (index, part) in range.zip(parts.chunks_exact(stride(F::Variables::DIMS))) {
            plan.scatter(index, F::Variables::DIMS, part, normal);
        }
    }
    fn set_kernel(&mut self, kernel: Kernel) {
        self.kernels.fill(kernel);
    }
    fn as_any(&self) -> &dyn Any {
        self
    }
    fn as_any_mut(&mut self) -> &mut dyn Any {
        self
    }
}
