//! Factors: measurements between variables.

use core::any::TypeId;
use core::fmt::Debug;

use nalgebra::{SMatrix, SVector};

use super::renewal::Renewed;
use super::values::{Key, Values};
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
/// #[derive(Clone)]
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
pub trait Factor<const R: usize>: Clone + Send + Sync + 'static {
    /// What messages call it.
    const NAME: &'static str;
    /// Whether it measures its variables against each other only, so that moving all of them together, as one rigid
    /// world, changes nothing. Where all factors of a connected part are such, one of its variables is held.
    const RELATIVE: bool = false;
    /// The variables it reads, as a tuple of one to five.
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

    /// For a factor that was linearised about a value of its variables, as sums of inertial samples are about a bias: the same
    /// measurement about `variables`. `None`, as here, where nothing was linearised. See [`Graph::renew`](super::Graph::renew).
    fn renewed(&self, _variables: &Self::Variables) -> Option<Renewed<Self, R>>
    where
        Self: Sized,
    {
        None
    }
}

/// The exact Jacobians of a factor's residual by dual numbers, whatever its own `residual_jac` says.
pub fn dual_jacobians<const R: usize, F: Factor<R>>(
    factor: &F,
    variables: &F::Variables,
) -> <F::Variables as Variables>::Jacobians<R> {
    F::Variables::derivatives(factor, variables)
}

/// The residual of a factor as a function of the tangent of one of its variables.
struct Along<'a, F, V> {
    factor: &'a F,
    variables: &'a V,
    position: usize,
}

impl<const R: usize, F: Factor<R>> TangentResidual<R> for Along<'_, F, F::Variables> {
    fn at<S: Real>(&self, delta: &[S]) -> SVector<S, R> {
        self.factor.residual(&self.variables.perturb(self.position, delta))
    }
}

/// Most variables one factor reads: the four knots of a cubic spline, and what is seen from there.
pub const MAX_ARITY: usize = 5;

/// Slots of a factor's variables in their stores; the unused ones are zero.
pub(crate) type Slots = [u32; MAX_ARITY];

/// A tuple of one to five [`Variable`]s.
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
    fn derivatives<const R: usize, F: Factor<R, Variables = Self>>(
        factor: &F,
        at: &Self,
    ) -> Self::Jacobians<R>;
    /// What messages call each.
    const NAMES: &'static [&'static str];
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
            const NAMES: &'static [&'static str] = &[$($v::NAME),+];
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
            fn derivatives<const R: usize, F: Factor<R, Variables = Self>>(factor: &F, variables: &Self) -> Self::Jacobians<R> {
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
variables!(A a 0, B b 1, C c 2, D d 3, E e 4);

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
