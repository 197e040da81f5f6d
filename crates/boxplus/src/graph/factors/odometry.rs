//! Odometry that is off by what is estimated along with the poses.

use nalgebra::{SMatrix, SVector};

use crate::graph::{Factor, GroupVariable, Variable};
use crate::lie::{LieGroup, Real, Rn, Tangent};

/// Odometry from X₁ to X₂ whose readings are off by E·c, where c, of C numbers, is unknown and common to many steps.
///
/// ```text
/// ũ = X₂ ⊟ X₁ + E·c + w      τ = X₂ ⊟ X₁ = Log(X₁⁻¹X₂)      r = τ + E·c − ũ
/// ∂r/∂X₁ = −J_l⁻¹(τ)         ∂r/∂X₂ = J_r⁻¹(τ)              ∂r/∂c = E      D×D, D×D, D×C, local side
/// ```
///
/// Solà et al. (2018) §V-C, with the opposite sign of r. E, D×C, says where c enters: with unit vectors as columns c is a bias of these
/// coordinates ([`CalibratedOdometry::biased`]), with the reading itself as a column an error of scale. A bias that is known is a held
/// variable ([`Values::hold`](crate::graph::Values::hold)).
///
/// ```
/// use boxplus::graph::{CalibratedOdometry, Graph, Noise, Prior, SolveOptions, Values};
/// use boxplus::lie::{LieGroup, Rn, SE2};
/// use nalgebra::vector;
/// // Three steps of 1 m, read as 1.1 m, and where they ended: the wheels are smaller than was thought.
/// let (mut graph, mut values) = (Graph::new(), Values::new());
/// let poses: Vec<_> = (0..4).map(|i| values.insert(SE2::new(vector![f64::from(i), 0.0], 0.0))).collect();
/// let bias = values.insert(Rn::new(vector![0.0]));
/// let noise = Noise::from_sigmas(&vector![0.01, 0.01, 0.01])?;
/// for pair in poses.windows(2) {
///     let odometry = CalibratedOdometry::<SE2, 3, 1>::biased(vector![1.1, 0.0, 0.0], [0]);
///     graph.add((pair[0], pair[1], bias), odometry, noise);
/// }
/// for (i, x) in [(0, 0.0), (3, 3.0)] {
///     graph.add((poses[i],), Prior { mean: SE2::new(vector![x, 0.0], 0.0) }, noise);
/// }
/// let solved = graph.optimize(&values, &SolveOptions::default())?.values;
/// assert!((solved.get(bias).ok_or("solved")?.vector()[0] - 0.1).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CalibratedOdometry<G, const D: usize, const C: usize> {
    /// ũ, in the tangent of the first pose: metres, radians.
    pub measured: Tangent<f64, D>,
    /// E: units of ũ for one of c.
    pub enters: SMatrix<f64, D, C>,
    of: core::marker::PhantomData<fn() -> G>,
}

impl<G, const D: usize, const C: usize> CalibratedOdometry<G, D, C> {
    /// A reading ũ that E·c is part of.
    pub fn new(measured: Tangent<f64, D>, enters: SMatrix<f64, D, C>) -> Self {
        Self { measured, enters, of: core::marker::PhantomData }
    }

    /// A reading of which the `coordinates` of the tangent are biased, in the order of c: units of c are theirs. One that D does not
    /// have is the bias of nothing.
    pub fn biased(measured: Tangent<f64, D>, coordinates: [usize; C]) -> Self {
        Self::new(measured, SMatrix::from_fn(|row, column| f64::from(u8::from(coordinates[column] == row))))
    }
}

impl<G: GroupVariable<D>, const D: usize, const C: usize> Factor<D> for CalibratedOdometry<G, D, C> {
    const NAME: &'static str = "odometry to be calibrated";
    const RELATIVE: bool = true;
    type Variables = (G, G, Rn<C>);

    fn residual<S: Real>(
        &self,
        (x1, x2, c): &(<G as Variable>::Over<S>, <G as Variable>::Over<S>, Rn<C, S>),
    ) -> SVector<S, D> {
        let offset = self.enters.map(S::lit) * c.vector();
        G::group::<S>(x2).rminus(&G::group::<S>(x1)) + offset - self.measured.map(S::lit)
    }

    fn residual_jac(
        &self,
        (x1, x2, c): &(G, G, Rn<C>),
    ) -> (SVector<f64, D>, (G::Jacobian<D>, G::Jacobian<D>, SMatrix<f64, D, C>)) {
        let (tau, d_x2, d_x1) = x2.rminus_jac(x1);
        let r = tau + self.enters * c.vector() - self.measured;
        (r, (G::jacobian(d_x1), G::jacobian(d_x2), self.enters))
    }
}
