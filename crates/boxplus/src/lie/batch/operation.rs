//! The operations of a batch, each once for single numbers and lanes.

use crate::lie::{Action, Jacobian, LieGroup, Tangent};
use nalgebra::SVector;

/// A function of elements of `G`.
pub(crate) trait Operation<G> {
    type In;
    type Out;
    fn apply(input: Self::In) -> Self::Out;
}

type Pair<G, const D: usize> =
    (G, Jacobian<<G as LieGroup<D>>::Scalar, D>, Jacobian<<G as LieGroup<D>>::Scalar, D>);
type Step<G, const D: usize> = Tangent<<G as LieGroup<D>>::Scalar, D>;
type Square<G, const D: usize> = Jacobian<<G as LieGroup<D>>::Scalar, D>;

/// One operation a line: its arguments, its result, its value.
macro_rules! operations {
    ($($name:ident: |$x:pat_param, $in:ty| $out:ty = $value:expr;)*) => {$(
        pub(crate) struct $name<const D: usize>;
        impl<G: LieGroup<D>, const D: usize> Operation<G> for $name<D> {
            type In = $in;
            type Out = $out;
            #[cfg_attr(not(debug_assertions), inline(always))]
            fn apply($x: Self::In) -> Self::Out {
                $value
            }
        }
    )*};
}

operations! {
    Exp: |tau, Step<G, D>| G = G::exp(&tau);
    ExpJac: |tau, Step<G, D>| (G, Square<G, D>) = G::exp_jac(&tau);
    Log: |x, G| Step<G, D> = x.log();
    LogJac: |x, G| (Step<G, D>, Square<G, D>) = x.log_jac();
    Inverse: |x, G| G = x.inverse();
    Compose: |(x, y), (G, G)| G = x.compose(&y);
    Between: |(x, y), (G, G)| G = x.between(&y);
    Rplus: |(x, tau), (G, Step<G, D>)| G = x.rplus(&tau);
    RplusJac: |(x, tau), (G, Step<G, D>)| Pair<G, D> = x.rplus_jac(&tau);
    Rminus: |(y, x), (G, G)| Step<G, D> = y.rminus(&x);
    RminusJac: |(y, x), (G, G)| (Step<G, D>, Square<G, D>, Square<G, D>) = y.rminus_jac(&x);
}

/// The action on points: the one operation that not every group has.
pub(crate) struct Act<const D: usize, const N: usize>;
impl<G: Action<D, N>, const D: usize, const N: usize> Operation<G> for Act<D, N> {
    type In = (G, SVector<G::Scalar, N>);
    type Out = SVector<G::Scalar, N>;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn apply((x, p): Self::In) -> Self::Out {
        x.act(&p)
    }
}
