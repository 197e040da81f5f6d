//! A measurement of one field of a bundle.

use crate::filter::Measurement;
use crate::lie::{Block, LieGroup};
use crate::uncertainty::Covariance;
use nalgebra::{SMatrix, SVector};

/// Makes a measurement of a group G one of a bundle B that has a G among its fields.
///
/// ```
/// use boxplus::bundle;
/// use boxplus::filter::{Ekf, Filter, Part, PositionFix};
/// use boxplus::lie::{LieGroup, Rn, SE2};
/// use boxplus::uncertainty::{Covariance, Gaussian};
/// use nalgebra::{SVector, vector};
/// bundle! {
///     struct Rover { pose: SE2 [3], wheel_bias: Rn<1> [1] }
/// }
/// let fix = Part {
///     measurement: PositionFix::of_origin(vector![0.3, 0.1], Covariance::from_sigmas(&vector![0.1, 0.1])?),
///     of: |rover: &Rover| rover.pose,
///     block: Rover::BLOCKS.pose,
/// };
/// let belief = Gaussian::<Rover, 4>::from_sigmas(Rover::identity(), &SVector::repeat(0.2))?;
/// let after = Ekf::default().update(&belief, &fix).belief;
/// assert!(after.sigmas()[0] < 0.1 && after.sigmas()[3] == 0.2);
/// # Ok::<(), boxplus::uncertainty::UncertaintyError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Part<Z, P, const D: usize, const N: usize> {
    /// The measurement of the field.
    pub measurement: Z,
    /// From the bundle, its field.
    pub of: P,
    /// Where the field stands in the tangent of the bundle: `Bundle::BLOCKS.field`.
    pub block: Block<D, N>,
}

impl<B, G, Z, P, const D: usize, const N: usize, const M: usize> Measurement<B, N, M> for Part<Z, P, D, N>
where
    B: LieGroup<N>,
    G: LieGroup<D, Scalar = B::Scalar>,
    Z: Measurement<G, D, M>,
    P: Fn(&B) -> G,
{
    fn innovation(&self, x: &B) -> SVector<B::Scalar, M> {
        self.measurement.innovation(&(self.of)(x))
    }
    fn noise(&self) -> Covariance<M, B::Scalar> {
        self.measurement.noise()
    }
    fn innovation_jac(&self, x: &B) -> (SVector<B::Scalar, M>, SMatrix<B::Scalar, M, N>) {
        self.widened(self.measurement.innovation_jac(&(self.of)(x)))
    }
    fn innovation_left_jac(&self, x: &B) -> (SVector<B::Scalar, M>, SMatrix<B::Scalar, M, N>) {
        // Ad of a bundle is block-diagonal.
        self.widened(self.measurement.innovation_left_jac(&(self.of)(x)))
    }
}

impl<Z, P, const D: usize, const N: usize> Part<Z, P, D, N> {
    fn widened<S: crate::lie::Real, const M: usize>(
        &self,
        (z, h): (SVector<S, M>, SMatrix<S, M, D>),
    ) -> (SVector<S, M>, SMatrix<S, M, N>) {
        let mut wide = SMatrix::zeros();
        self.block.set_columns(&mut wide, &h);
        (z, wide)
    }
}
