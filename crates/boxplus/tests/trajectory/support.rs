//! Samples, comparisons and dual numbers shared by the tests of this folder.

use boxplus::lie::{LieGroup, Tangent};
use nalgebra::{SMatrix, SVector};

pub(crate) const EPS: f64 = f64::EPSILON;

/// Numbers in (−1, 1), the same in every run (SplitMix64).
pub(crate) fn draw<const N: usize>(seed: u64) -> SVector<f64, N> {
    SVector::from_fn(|i, _| {
        let mut z = (seed * 64 + i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    })
}

/// The basis vector i.
pub(crate) fn unit<const D: usize>(i: usize) -> SVector<f64, D> {
    SVector::from_fn(|j, _| f64::from(u8::from(i == j)))
}

/// A walk of N elements with steps of length up to `size` per coordinate.
pub(crate) fn walk<G: LieGroup<D, Scalar = f64>, const D: usize, const N: usize>(
    seed: u64,
    size: f64,
) -> [G; N] {
    let mut x = G::exp(&draw(seed));
    std::array::from_fn(|i| {
        x = x.rplus(&(draw::<D>(seed + 100 + i as u64) * size));
        x
    })
}

pub(crate) fn distance<G: LieGroup<D, Scalar = f64>, const D: usize>(x: &G, y: &G) -> f64 {
    x.rminus(y).amax()
}

#[track_caller]
pub(crate) fn close<const R: usize, const C: usize>(
    name: &str,
    a: &SMatrix<f64, R, C>,
    b: &SMatrix<f64, R, C>,
    bound: f64,
) {
    let error = (a - b).amax();
    assert!(error <= bound * (1.0 + b.amax()), "{name}: differs by {error:.2e}, allowed {bound:.0e}\n{a}{b}");
}

#[track_caller]
pub(crate) fn same<G: LieGroup<D, Scalar = f64>, const D: usize>(name: &str, x: &G, y: &G, bound: f64) {
    let error = distance(x, y);
    assert!(error <= bound, "{name}: differs by {error:.2e}, allowed {bound:.0e}\n{x:?}\n{y:?}");
}

/// ∂f/∂t by central differences of fourth order, h⁴/30·f⁵ ≈ ε/h: about 1e-11 for rates of order 1.
pub(crate) fn difference<const N: usize>(t: f64, f: impl Fn(f64) -> Tangent<f64, N>) -> Tangent<f64, N> {
    let h = 1.0 / 1024.0;
    ((f(t + h) - f(t - h)) * 8.0 - (f(t + 2.0 * h) - f(t - 2.0 * h))) / (12.0 * h)
}

/// Numbers of the standard normal distribution (Box and Muller), the same in every run.
pub(crate) fn normal<const N: usize>(seed: u64) -> SVector<f64, N> {
    let (a, b) = (draw::<N>(2 * seed), draw::<N>(2 * seed + 1));
    SVector::from_fn(|i, _| {
        let radius = (-2.0 * (0.5 * (a[i] + 1.0)).max(f64::MIN_POSITIVE).ln()).sqrt();
        radius * (std::f64::consts::PI * b[i]).cos()
    })
}

/// A covariance agrees with that of zero-mean samples within 4.5 standard errors of each entry.
#[track_caller]
pub(crate) fn agrees_with_samples<const N: usize>(
    covariance: &SMatrix<f64, N, N>,
    samples: &[SVector<f64, N>],
) {
    let n = samples.len() as f64;
    let measured = samples.iter().fold(SMatrix::<f64, N, N>::zeros(), |sum, x| sum + x * x.transpose()) / n;
    for i in 0..N {
        for j in 0..N {
            let (c, d) = (covariance[(i, i)] * covariance[(j, j)], covariance[(i, j)]);
            let error = ((c + d * d) / n).sqrt();
            let off = (measured[(i, j)] - d).abs();
            assert!(
                off <= 4.5 * error,
                "({i}, {j}): {off:.2e}, standard error {error:.2e}\n{covariance}{measured}"
            );
        }
    }
}

/// A table of the scripts: a row is its numbers by column name.
pub(crate) struct Table {
    header: Vec<&'static str>,
    rows: Vec<Vec<f64>>,
}

impl Table {
    pub(crate) fn parse(text: &'static str) -> Self {
        let mut lines = text.lines();
        let header = lines.next().unwrap().split(',').collect();
        Self { header, rows: lines.map(|l| l.split(',').map(|x| x.parse().unwrap()).collect()).collect() }
    }

    pub(crate) fn rows(&self) -> usize {
        self.rows.len()
    }

    /// The numbers of the columns `name0`, `name1`, … of a row.
    pub(crate) fn get<const N: usize>(&self, row: usize, name: &str) -> SVector<f64, N> {
        let first = format!("{name}0");
        let at = self.header.iter().position(|h| **h == first).unwrap();
        SVector::from_fn(|i, _| self.rows[row][at + i])
    }

    /// The same, as a matrix written by rows.
    pub(crate) fn matrix(&self, row: usize, name: &str) -> SMatrix<f64, 3, 3> {
        SMatrix::from_row_slice(self.get::<9>(row, name).as_slice())
    }
}

#[cfg(feature = "autodiff")]
pub(crate) use dual::*;

#[cfg(feature = "autodiff")]
mod dual {
    use super::*;
    use boxplus::trajectory::{Motion, MotionJac};
    use nalgebra::Const;
    use num_dual::DualSVec64;

    pub(crate) type Dual<const N: usize> = DualSVec64<N>;
    pub(crate) type Over<G, const D: usize, const N: usize> = <G as LieGroup<D>>::Over<Dual<N>>;

    pub(crate) fn constant<const N: usize, const M: usize>(x: &SVector<f64, M>) -> SVector<Dual<N>, M> {
        x.map(Dual::from_re)
    }

    /// x with unit derivatives.
    pub(crate) fn unknown<const N: usize>(x: &SVector<f64, N>) -> SVector<Dual<N>, N> {
        SVector::from_fn(|i, _| Dual::from_re(x[i]).derivative(i))
    }

    pub(crate) fn derivatives<const N: usize, const M: usize>(y: &SVector<Dual<N>, M>) -> SMatrix<f64, M, N> {
        let rows = y.map(|d| d.eps.unwrap_generic(Const::<N>, Const::<1>));
        SMatrix::from_fn(|i, j| rows[i][j])
    }

    pub(crate) fn lift<G: LieGroup<D, Scalar = f64>, const D: usize, const N: usize>(x: &G) -> Over<G, D, N> {
        x.map(Dual::from_re)
    }

    /// `x` perturbed locally by unknowns.
    pub(crate) fn moved<G: LieGroup<D, Scalar = f64>, const D: usize>(x: &G) -> Over<G, D, D> {
        lift::<G, D, D>(x).rplus(&unknown(&SVector::zeros()))
    }

    /// The local derivative of a value that is `at` without its dual part.
    pub(crate) fn local<G: LieGroup<D, Scalar = f64>, const D: usize, const N: usize>(
        y: &Over<G, D, N>,
        at: &G,
    ) -> SMatrix<f64, D, N> {
        derivatives(&y.rminus(&lift::<G, D, N>(at)))
    }

    /// A motion in dual numbers answers as the closed form says.
    #[track_caller]
    pub(crate) fn answers<G: LieGroup<D, Scalar = f64>, const D: usize>(
        name: &str,
        dual: &Motion<Over<G, D, D>, D>,
        at: &G,
        closed: &MotionJac<f64, D>,
        bound: f64,
    ) {
        close(&format!("{name}, value"), &closed.value, &local(&dual.value, at), bound);
        close(&format!("{name}, velocity"), &closed.velocity, &derivatives(&dual.velocity), bound);
        close(
            &format!("{name}, acceleration"),
            &closed.acceleration,
            &derivatives(&dual.acceleration),
            bound,
        );
    }

    /// The rates of a motion are its time derivatives, one after the other.
    #[track_caller]
    pub(crate) fn rates<G: LieGroup<D, Scalar = f64>, const D: usize>(
        dual: &Motion<Over<G, D, 1>, D>,
        motion: &Motion<G, D>,
        bound: f64,
    ) {
        close("velocity", &motion.velocity, &local::<G, D, 1>(&dual.value, &motion.value), bound);
        close("acceleration", &motion.acceleration, &derivatives(&dual.velocity), bound);
        close("jerk", &motion.jerk, &derivatives(&dual.acceleration), bound);
    }
}
