//! What is known of one variable beforehand.

use nalgebra::SVector;

use crate::graph::{Factor, GroupVariable, Variable};
use crate::lie::{LieGroup, Real};

/// A variable known beforehand, on the local side of its mean.
///
/// ```text
/// r = Log(X̄⁻¹X)      ∂r/∂X = J_r⁻¹(r)
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior<G> {
    /// The mean X̄.
    pub mean: G,
}

impl<G: GroupVariable<D>, const D: usize> Factor<D> for Prior<G> {
    const NAME: &'static str = "prior";
    type Variables = (G,);

    fn residual<S: Real>(&self, (x,): &(<G as Variable>::Over<S>,)) -> SVector<S, D> {
        G::group::<S>(x).rminus(&LieGroup::map(&self.mean, S::lit))
    }

    fn residual_jac(&self, (x,): &(G,)) -> (SVector<f64, D>, (G::Jacobian<D>,)) {
        let (r, d_r_d_x) = self.mean.between(x).log_jac();
        (r, (G::jacobian(d_r_d_x),))
    }
}
