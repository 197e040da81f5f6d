//! Sensors that see points, distances, directions and positions.

use crate::filter::Measurement;
use crate::lie::{Action, Real, SE2, SO2};
use crate::uncertainty::Covariance;
use nalgebra::{RowVector2, SMatrix, SVector, SimdComplexField, Vector2};

/// A landmark at a known place, its position measured in the frame of the body: y = X⁻¹·l + n.
///
/// For cameras with depth, stereo, laser scanners. The innovation turned into the frame of the world, R̂(y − X̂⁻¹l), has the
/// constant left Jacobian \[−I, l^\] of the right-invariant filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting<const N: usize, S = f64> {
    /// l, in metres of the world.
    pub landmark: SVector<S, N>,
    /// y, in metres of the body.
    pub measured: SVector<S, N>,
    /// Of y.
    pub noise: Covariance<N, S>,
}

impl<G: Action<D, N>, const D: usize, const N: usize> Measurement<G, D, N> for Sighting<N, G::Scalar> {
    fn innovation(&self, x: &G) -> SVector<G::Scalar, N> {
        self.measured - x.act_inverse(&self.landmark)
    }
    fn noise(&self) -> Covariance<N, G::Scalar> {
        self.noise
    }
    fn innovation_jac(&self, x: &G) -> (SVector<G::Scalar, N>, SMatrix<G::Scalar, N, D>) {
        let (y, h, _) = x.act_inverse_jac(&self.landmark);
        (self.measured - y, h)
    }
    fn innovation_left_jac(&self, x: &G) -> (SVector<G::Scalar, N>, SMatrix<G::Scalar, N, D>) {
        let (y, h, _) = x.act_inverse_left_jac(&self.landmark);
        (self.measured - y, h)
    }
}

/// The position of a point of the body, measured in the world: y = X·a + n; GNSS, motion capture, total station.
///
/// a is the antenna's place in the body, the lever arm. Forgetting it biases the position by its length and, through turns,
/// teaches the filter that this bias is certain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionFix<const N: usize, S = f64> {
    /// a, in metres of the body.
    pub antenna: SVector<S, N>,
    /// y, in metres of the world.
    pub measured: SVector<S, N>,
    /// Of y.
    pub noise: Covariance<N, S>,
}

impl<const N: usize, S: Real> PositionFix<N, S> {
    /// A fix of the origin of the body.
    pub fn of_origin(measured: SVector<S, N>, noise: Covariance<N, S>) -> Self {
        Self { antenna: SVector::zeros(), measured, noise }
    }
}

impl<G: Action<D, N>, const D: usize, const N: usize> Measurement<G, D, N> for PositionFix<N, G::Scalar> {
    fn innovation(&self, x: &G) -> SVector<G::Scalar, N> {
        self.measured - x.act(&self.antenna)
    }
    fn noise(&self) -> Covariance<N, G::Scalar> {
        self.noise
    }
    fn innovation_jac(&self, x: &G) -> (SVector<G::Scalar, N>, SMatrix<G::Scalar, N, D>) {
        let (y, h, _) = x.act_jac(&self.antenna);
        (self.measured - y, h)
    }
    fn innovation_left_jac(&self, x: &G) -> (SVector<G::Scalar, N>, SMatrix<G::Scalar, N, D>) {
        let (y, h, _) = x.act_left_jac(&self.antenna);
        (self.measured - y, h)
    }
}

/// A direction or field known in the world, measured in the body: y = R⁻¹·d + n; magnetometer, accelerometer at rest, sun
/// sensor.
///
/// An accelerometer at rest shows the *specific force*, which is minus gravity: d = (0, 0, 9.81) in a world whose z points
/// up, for y in m/s². It says nothing while the body accelerates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VectorSighting<const N: usize, S = f64> {
    /// d, in the frame of the world.
    pub reference: SVector<S, N>,
    /// y, in the frame of the body, in the units of d.
    pub measured: SVector<S, N>,
    /// Of y.
    pub noise: Covariance<N, S>,
}

impl<G: Action<D, N>, const D: usize, const N: usize> Measurement<G, D, N> for VectorSighting<N, G::Scalar> {
    fn innovation(&self, x: &G) -> SVector<G::Scalar, N> {
        self.measured - x.inverse().act_direction(&self.reference)
    }
    fn noise(&self) -> Covariance<N, G::Scalar> {
        self.noise
    }
    fn innovation_jac(&self, x: &G) -> (SVector<G::Scalar, N>, SMatrix<G::Scalar, N, D>) {
        // The local error of X is minus the global error of X⁻¹, and the other way round.
        let (y, h, _) = x.inverse().act_direction_left_jac(&self.reference);
        (self.measured - y, -h)
    }
    fn innovation_left_jac(&self, x: &G) -> (SVector<G::Scalar, N>, SMatrix<G::Scalar, N, D>) {
        let (y, h, _) = x.inverse().act_direction_jac(&self.reference);
        (self.measured - y, -h)
    }
}

/// The distance between a point of the body and a beacon: y = |X·a − l| + n; ultra-wide band, sonar, time of flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range<const N: usize, S = f64> {
    /// l, in metres of the world.
    pub beacon: SVector<S, N>,
    /// a, where the antenna is, in metres of the body.
    pub antenna: SVector<S, N>,
    /// y, in metres.
    pub measured: S,
    /// Of y.
    pub noise: Covariance<1, S>,
}

impl<G: Action<D, N>, const D: usize, const N: usize> Measurement<G, D, 1> for Range<N, G::Scalar> {
    fn innovation(&self, x: &G) -> SVector<G::Scalar, 1> {
        let distance = (x.act(&self.antenna) - self.beacon).norm_squared().simd_sqrt();
        SVector::<_, 1>::new(self.measured - distance)
    }
    fn noise(&self) -> Covariance<1, G::Scalar> {
        self.noise
    }
    /// Not finite on the beacon, where the distance has no derivative: such a measurement is refused.
    fn innovation_jac(&self, x: &G) -> (SVector<G::Scalar, 1>, SMatrix<G::Scalar, 1, D>) {
        let (place, d_place, _) = x.act_jac(&self.antenna);
        self.along(&place, &d_place)
    }
    fn innovation_left_jac(&self, x: &G) -> (SVector<G::Scalar, 1>, SMatrix<G::Scalar, 1, D>) {
        let (place, d_place, _) = x.act_left_jac(&self.antenna);
        self.along(&place, &d_place)
    }
}

impl<const N: usize, S: Real> Range<N, S> {
    /// `(z, H)` with the antenna at `place`, which moves by `d_place`.
    fn along<const D: usize>(
        &self,
        place: &SVector<S, N>,
        d_place: &SMatrix<S, N, D>,
    ) -> (SVector<S, 1>, SMatrix<S, 1, D>) {
        let offset = place - self.beacon;
        let distance = offset.norm_squared().simd_sqrt();
        let towards = offset.transpose() * (S::one() / distance);
        (SVector::<_, 1>::new(self.measured - distance), towards * d_place)
    }
}

/// Distance and bearing of a beacon in the plane, seen from the body: y = (|b|, atan2(b₂, b₁)) + n, b = X⁻¹·l.
///
/// Bearings are measured from the body's x axis, counter-clockwise, and wrapped. A state on the beacon sees no bearing: the
/// measurement is refused.
///
/// ```
/// use boxplus::filter::{Measurement, RangeBearing};
/// use boxplus::lie::SE2;
/// use boxplus::uncertainty::Covariance;
/// use nalgebra::vector;
/// let noise = Covariance::from_sigmas(&vector![0.1, 0.02])?;
/// let seen = RangeBearing { beacon: vector![-3.0, 0.1], measured: vector![3.0, -3.1], noise };
/// let z = seen.innovation(&SE2::<f64>::new(vector![0.0, 0.0], 0.0)); // the beacon is behind: bearings near ±π
/// assert!(z[1].abs() < 0.1);
/// # Ok::<(), boxplus::uncertainty::UncertaintyError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeBearing<S = f64> {
    /// l, in metres of the world.
    pub beacon: Vector2<S>,
    /// (distance in metres, bearing in radians).
    pub measured: Vector2<S>,
    /// Of both.
    pub noise: Covariance<2, S>,
}

impl<S: Real> RangeBearing<S> {
    /// z for the beacon seen at b.
    fn compared(&self, b: &Vector2<S>) -> Vector2<S> {
        let bearing = S::polar_angle(b.y, b.x);
        // Through (cos, sin): wrapped to (−π, π].
        let turn = SO2::from_angle(self.measured.y - bearing).angle();
        Vector2::new(self.measured.x - b.norm_squared().simd_sqrt(), turn)
    }

    /// H for the beacon seen at b, which moves by `d_b`.
    fn slope(b: &Vector2<S>, d_b: &SMatrix<S, 2, 3>) -> SMatrix<S, 2, 3> {
        let square = b.norm_squared();
        let range = RowVector2::new(b.x, b.y) * (S::one() / square.simd_sqrt());
        let bearing = RowVector2::new(-b.y, b.x) * (S::one() / square);
        SMatrix::from_rows(&[range * d_b, bearing * d_b])
    }
}

impl<S: Real> Measurement<SE2<S>, 3, 2> for RangeBearing<S> {
    fn innovation(&self, x: &SE2<S>) -> Vector2<S> {
        self.compared(&x.act_inverse(&self.beacon))
    }
    fn noise(&self) -> Covariance<2, S> {
        self.noise
    }
    fn innovation_jac(&self, x: &SE2<S>) -> (Vector2<S>, SMatrix<S, 2, 3>) {
        let (b, d_b, _) = x.act_inverse_jac(&self.beacon);
        (self.compared(&b), Self::slope(&b, &d_b))
    }
    fn innovation_left_jac(&self, x: &SE2<S>) -> (Vector2<S>, SMatrix<S, 2, 3>) {
        let (b, d_b, _) = x.act_inverse_left_jac(&self.beacon);
        (self.compared(&b), Self::slope(&b, &d_b))
    }
}
