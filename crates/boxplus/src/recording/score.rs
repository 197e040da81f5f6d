//! A track beside the truth.

use super::course::local_covariance;
use super::log::{Stamped, seconds};
use crate::lie::LieGroup;
use crate::uncertainty::{Gaussian, Side};
use core::ops::Range;
use nalgebra::SVector;
use std::vec::Vec;

/// What a track believed, beside what was so.
///
/// Errors are local: Log(X̂⁻¹X), of a pose the position ahead, to the left and up in metres, then the rotation in radians.
///
/// ```
/// use boxplus::lie::{LieGroup, SE2};
/// use boxplus::recording::{Score, Stamped};
/// use boxplus::uncertainty::Gaussian;
/// use nalgebra::vector;
/// let belief = Gaussian::<SE2, 3>::from_sigmas(SE2::new(vector![1.0, 0.0], 0.0), &vector![0.1, 0.1, 0.01])?;
/// let truth = [0, 2].map(|s| Stamped { stamp_ns: s * 1_000_000_000, value: SE2::new(vector![0.6 * s as f64, 0.1], 0.0) });
/// let score = Score::new(&[Stamped { stamp_ns: 1_000_000_000, value: belief }], &truth, 3.0);
/// assert!((score.judged[0].error - vector![-0.4, 0.1, 0.0]).norm() < 1e-15); // 0.6 m were so, 1 m was believed
/// assert_eq!((score.inside(0..1, 3.0), score.inside(0..2, 3.0), score.inside(0..3, 5.0)), (0.0, 0.5, 1.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Score<const D: usize> {
    /// In order of time.
    pub judged: Vec<Judged<D>>,
}

/// A belief beside the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judged<const D: usize> {
    /// When.
    pub stamp_ns: i64,
    /// ξ = Log(X̂⁻¹X).
    pub error: SVector<f64, D>,
    /// Standard deviations that were claimed.
    pub sigmas: SVector<f64, D>,
    /// ξᵀP⁻¹ξ; `None` where P is singular.
    pub nees: Option<f64>,
}

impl<const D: usize> Score<D> {
    /// Every belief at whose time the truth is known: between two samples of `truth` that are at most `apart` seconds apart,
    /// where it is interpolated. Both in order of time.
    pub fn new<G, E>(track: &[Stamped<Gaussian<G, D, E>>], truth: &[Stamped<G>], apart: f64) -> Self
    where
        G: LieGroup<D, Scalar = f64>,
        E: Side,
    {
        let judge = |belief: &Stamped<Gaussian<G, D, E>>| {
            let so = at(truth, belief.stamp_ns, apart)?;
            let covariance = local_covariance(&belief.value);
            let error = so.rminus(belief.value.mean());
            let nees = covariance.mahalanobis_squared(&error).ok();
            Some(Judged { stamp_ns: belief.stamp_ns, error, sigmas: covariance.sigmas(), nees })
        };
        Self { judged: track.iter().filter_map(judge).collect() }
    }

    /// √ of the mean square of the length of the error in these coordinates, in their unit; NaN without any.
    pub fn rmse(&self, coordinates: Range<usize>) -> f64 {
        let square =
            |j: &Judged<D>| j.error.as_slice()[coordinates.clone()].iter().map(|x| x * x).sum::<f64>();
        (self.judged.iter().map(square).sum::<f64>() / self.judged.len() as f64).sqrt()
    }

    /// The largest length of the error in these coordinates.
    pub fn largest(&self, coordinates: Range<usize>) -> f64 {
        let length =
            |j: &Judged<D>| j.error.as_slice()[coordinates.clone()].iter().map(|x| x * x).sum::<f64>().sqrt();
        self.judged.iter().map(length).fold(0.0, f64::max)
    }

    /// The share of errors, coordinate by coordinate, within `k` standard deviations: of a consistent filter, 0.9973 for k = 3.
    pub fn inside(&self, coordinates: Range<usize>, k: f64) -> f64 {
        let all = || self.judged.iter().flat_map(|j| coordinates.clone().map(|i| (j.error[i], j.sigmas[i])));
        let held = all().filter(|(error, sigma)| error.abs() <= k * sigma).count();
        held as f64 / all().count() as f64
    }

    /// The average NEES of a coordinate: 1 where the covariance is as claimed, more where it claims too much; NaN without any.
    pub fn mean_nees(&self) -> f64 {
        let all = || self.judged.iter().filter_map(|j| j.nees);
        all().sum::<f64>() / (D * all().count()) as f64
    }

    /// The part that begins so many seconds after the first belief: when a filter has settled.
    pub fn after(&self, settled: f64) -> Self {
        let start_ns = self.judged.first().map_or(0, |j| j.stamp_ns);
        let late = |j: &&Judged<D>| seconds(start_ns, j.stamp_ns) >= settled;
        Self { judged: self.judged.iter().filter(late).copied().collect() }
    }
}

/// The truth at a time.
fn at<G: LieGroup<D, Scalar = f64>, const D: usize>(
    truth: &[Stamped<G>],
    stamp_ns: i64,
    apart: f64,
) -> Option<G> {
    let next = truth.partition_point(|x| x.stamp_ns < stamp_ns);
    let after = truth.get(next)?;
    if after.stamp_ns == stamp_ns {
        return Some(after.value);
    }
    let before = truth.get(next.checked_sub(1)?)?;
    let step = seconds(before.stamp_ns, after.stamp_ns);
    let part = seconds(before.stamp_ns, stamp_ns) / step;
    (step <= apart).then(|| before.value.interpolate(&after.value, part))
}
