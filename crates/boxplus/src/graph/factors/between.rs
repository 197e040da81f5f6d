//! The measured displacement between two elements of one group: odometry, loop closures.

use nalgebra::SVector;

use super::chart::{Chart, Log};
use crate::graph::{Factor, GroupVariable, Variable};
use crate::lie::{LieGroup, Real};

/// Displacement Z measured from X₁ to X₂, with the residual in the chart `C`.
///
/// ```text
/// Δ = X₁⁻¹X₂      r = e(Z, Δ)      E = ∂e/∂Δ      (Log: e = Log(Z⁻¹Δ), E = J_r⁻¹(e))
/// ∂r/∂X₁ = −E·Ad(Δ⁻¹)              ∂r/∂X₂ = E      each D×D, local side
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Between<G, C = Log> {
    /// Z, the second variable seen from the first.
    pub measured: G,
    /// How the residual is written.
    pub chart: C,
}

impl<G> Between<G, Log> {
    /// The displacement `measured`, with the full logarithm as residual.
    pub fn new(measured: G) -> Self {
        Self { measured, chart: Log }
    }
}

impl<G, C: Default> Between<G, C> {
    /// The displacement `measured`, with the residual in chart `C`.
    pub fn in_chart(measured: G) -> Self {
        Self { measured, chart: C::default() }
    }
}

impl<G: GroupVariable<D>, C: Chart<G, D>, const D: usize> Factor<D> for Between<G, C> {
    const NAME: &'static str = "displacement";
    const RELATIVE: bool = true;
    type Variables = (G, G);

    fn residual<S: Real>(
        &self,
        (x1, x2): &(<G as Variable>::Over<S>, <G as Variable>::Over<S>),
    ) -> SVector<S, D> {
        let predicted = G::group::<S>(x1).between(&G::group::<S>(x2));
        C::error::<S>(&LieGroup::map(&self.measured, S::lit), &predicted)
    }

    #[inline]
    fn residual_jac(&self, (x1, x2): &(G, G)) -> (SVector<f64, D>, (G::Jacobian<D>, G::Jacobian<D>)) {
        let predicted = x1.between(x2);
        let (r, d_r_d_x2) = C::error_jac(&self.measured, &predicted);
        let d_r_d_x1 = -d_r_d_x2 * predicted.inverse().adjoint();
        (r, (G::jacobian(d_r_d_x1), G::jacobian(d_r_d_x2)))
    }
}
