//! Positions and velocities in the world, as satellites tell them.

use nalgebra::{SMatrix, SVector, Vector3};

use crate::graph::{Carries, Factor};
use crate::lie::{Real, SE23};

/// The position of a point of the body, measured in the world: a GNSS antenna, a marker of a motion capture system.
///
/// ```text
/// r = X·l − z      ∂r/∂X = A·G(l), on SE(3) [R, −R·l^]      N×D, local side
/// ```
///
/// ```
/// use boxplus::graph::{Factor, Position};
/// use boxplus::lie::{SE23, SO3};
/// use nalgebra::Vector3;
/// // The antenna is 1 m behind the sensor, which looks along y.
/// let fix = Position::of_point(Vector3::new(5.0, 1.0, 0.0), Vector3::new(-1.0, 0.0, 0.0));
/// let x: SE23 = SE23::new(SO3::about_z(std::f64::consts::FRAC_PI_2), Vector3::new(5.0, 2.0, 0.0), Vector3::zeros());
/// assert!(fix.residual_jac(&(x,)).0.norm() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Position<X, const N: usize> {
    /// z, in metres of the world.
    pub measured: SVector<f64, N>,
    /// l, where the point is on the body, in metres.
    pub lever: SVector<f64, N>,
    of: core::marker::PhantomData<fn() -> X>,
}

impl<X, const N: usize> Position<X, N> {
    /// The origin of the body was at `measured`, in metres of the world.
    pub fn of_origin(measured: SVector<f64, N>) -> Self {
        Self::of_point(measured, SVector::zeros())
    }

    /// The point `lever` of the body, in metres, was at `measured` in the world.
    pub fn of_point(measured: SVector<f64, N>, lever: SVector<f64, N>) -> Self {
        Self { measured, lever, of: core::marker::PhantomData }
    }
}

impl<X: Carries<N>, const N: usize> Factor<N> for Position<X, N> {
    const NAME: &'static str = "position";
    type Variables = (X,);

    fn residual<S: Real>(&self, (x,): &(X::Over<S>,)) -> SVector<S, N> {
        X::carry(x, &self.lever.map(S::lit)) - self.measured.map(S::lit)
    }

    fn residual_jac(&self, (x,): &(X,)) -> (SVector<f64, N>, (X::Jacobian<N>,)) {
        let (place, d_place) = x.carry_jac(&self.lever);
        (place - self.measured, (d_place,))
    }
}

/// The velocity of the origin, measured in the world: Doppler of GNSS, or zero where the body is known to stand.
///
/// ```text
/// r = v − z      ∂r/∂X = [0, 0, R]      3×9, local side
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Velocity {
    /// z, in m/s of the world.
    pub measured: Vector3<f64>,
}

impl Factor<3> for Velocity {
    const NAME: &'static str = "velocity";
    type Variables = (SE23,);

    fn residual<S: Real>(&self, (x,): &(SE23<S>,)) -> Vector3<S> {
        x.velocity() - self.measured.map(S::lit)
    }

    fn residual_jac(&self, (x,): &(SE23,)) -> (Vector3<f64>, (SMatrix<f64, 3, 9>,)) {
        let mut d_x = SMatrix::<f64, 3, 9>::zeros();
        d_x.fixed_view_mut::<3, 3>(0, 6).copy_from(&x.rotation().to_matrix());
        (x.velocity() - self.measured, (d_x,))
    }
}
