//! Can the covariance be believed? Many simulated runs, and what they say.

use super::{Innovation, Update};
use crate::lie::{LieGroup, Real};
use crate::uncertainty::{ChiSquared, Covariance, Gaussian, Side, UncertaintyError};
use nalgebra::SVector;
use rand::SeedableRng;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::{thread, vec, vec::Vec};

/// A Monte-Carlo experiment: independent runs of a simulation with a filter in it, and the statistics of its errors.
///
/// A run draws a truth, filters what sensors make of it, and [records](Run) errors. Three questions are answered:
///
/// - **NEES** ξᵀP⁻¹ξ, of an error and its claimed covariance: of a consistent filter, χ² with the dimension as its mean.
/// - **NIS** zᵀS⁻¹z, of innovations: the same without a truth.
/// - **RMSE** √E|ξ|².
///
/// The average over N runs of a quantity of dimension n has N·average ~ χ²(nN). Runs are independent; the times of one run
/// are *not*, so that averaging over time narrows nothing for certain: its variance is at most that of one time, and the
/// interval of one time is the one that is never too narrow. The standard error, from the scatter of the runs, is the sharper
/// statement where there are many.
///
/// Run i has the generator seeded by `seed + i`: the same numbers come out for every number of threads.
///
/// ```
/// use boxplus::filter::{Ekf, Filter, MonteCarlo, Odometry, PositionFix, Verdict};
/// use boxplus::lie::{LieGroup, Rn, SE2};
/// use boxplus::uncertainty::Gaussian;
/// use nalgebra::vector;
/// use rand_chacha::ChaCha8Rng;
///
/// let slip = Gaussian::<SE2, 3>::from_sigmas(SE2::identity(), &vector![0.05, 0.02, 0.03])?;
/// let jitter = Gaussian::<Rn<2>, 2>::from_sigmas(Rn::identity(), &vector![0.1, 0.1])?;
/// let odometry = Odometry { noise: *slip.covariance() };
/// let experiment = MonteCarlo { runs: 200, ..MonteCarlo::default() };
/// let report = experiment.run::<ChaCha8Rng>(|rng, run| {
///     let (mut truth, step) = (SE2::identity(), vector![0.5, 0.0, 0.1]);
///     let mut belief = Gaussian::<SE2, 3>::certain(truth);
///     for _ in 0..20 {
///         truth = truth.rplus(&(step + slip.sample(rng).log()));
///         belief = Ekf::default().predict(&belief, &odometry, &step)?;
///         let seen = truth.translation() + jitter.sample(rng).vector();
///         let update = Ekf::default().update(&belief, &PositionFix::of_origin(seen, *jitter.covariance()));
///         run.innovation("fix", &update);
///         belief = update.belief;
///         run.state("pose", &truth, &belief);
///     }
///     Ok::<(), boxplus::filter::FilterError>(())
/// })?;
/// let pose = report.series("pose").ok_or("recorded")?;
/// assert_eq!(pose.verdict(), Verdict::Consistent);
/// assert!((pose.mean - 3.0).abs() < 0.3 && pose.interval[0] > 2.6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MonteCarlo {
    /// N.
    pub runs: usize,
    /// Seed of the first run.
    pub seed: u64,
    /// Probability of the intervals, 0 < p < 1.
    pub confidence: f64,
    /// How many runs are made at a time; never changes a result.
    pub threads: NonZeroUsize,
}

impl Default for MonteCarlo {
    /// 100 runs from seed 0, 95 %, one at a time.
    fn default() -> Self {
        Self { runs: 100, seed: 0, confidence: 0.95, threads: NonZeroUsize::MIN }
    }
}

/// What one run records, by name and in the order of its times.
#[derive(Clone, Debug, Default)]
pub struct Run {
    series: Vec<Recorded>,
    refused: usize,
}

/// One quantity of one run.
#[derive(Clone, Debug)]
struct Recorded {
    name: &'static str,
    /// In the order of the times.
    samples: Vec<Sample>,
    /// Sum over the times of the square of each coordinate.
    squares: Vec<f64>,
}

/// Two squares of one error: by its covariance, and plain.
#[derive(Clone, Copy, Debug, Default)]
struct Sample {
    normalised: f64,
    square: f64,
}

impl Run {
    /// The error of a belief about the truth, on the belief's side, and its NEES.
    pub fn state<G: LieGroup<D>, const D: usize, E: Side>(
        &mut self,
        name: &'static str,
        truth: &G,
        belief: &Gaussian<G, D, E>,
    ) {
        self.error(name, &belief.error_of(truth), belief.covariance());
    }

    /// Any error with its claimed covariance: a part of the state, a position, an angle.
    pub fn error<const N: usize, S: Real>(
        &mut self,
        name: &'static str,
        error: &SVector<S, N>,
        covariance: &Covariance<N, S>,
    ) {
        // Certain and wrong is infinitely overconfident; NaN stays NaN, and shows.
        let normalised = covariance.mahalanobis_squared(error).map_or(f64::INFINITY, Real::value);
        self.push(name, &error.map(Real::value), normalised);
    }

    /// The innovation of an update, its NIS; a refused measurement is counted.
    pub fn innovation<G: LieGroup<D>, const D: usize, const M: usize, E: Side>(
        &mut self,
        name: &'static str,
        update: &Update<G, D, M, E>,
    ) {
        match update.innovation() {
            Some(Innovation { value, nis, .. }) => {
                self.push(name, &value.map(Real::value), nis.value());
            }
            None => self.refused += 1,
        }
    }

    fn push<const N: usize>(&mut self, name: &'static str, error: &SVector<f64, N>, normalised: f64) {
        let place = self.series.iter().position(|known| known.name == name).unwrap_or_else(|| {
            self.series.push(Recorded { name, samples: Vec::new(), squares: vec![0.0; N] });
            self.series.len() - 1
        });
        let recorded = &mut self.series[place];
        recorded.samples.push(Sample { normalised, square: error.norm_squared() });
        recorded.squares.iter_mut().zip(error).for_each(|(sum, x)| *sum += x * x);
    }
}

/// What all runs say.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// One for each name that was recorded, in that order.
    pub series: Vec<Series>,
    /// How many measurements were refused, in all runs.
    pub refused: usize,
}

impl Report {
    /// The series of a name.
    pub fn series(&self, name: &str) -> Option<&Series> {
        self.series.iter().find(|series| series.name == name)
    }
}

/// NEES or NIS, and RMSE, of one recorded quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Its name.
    pub name: &'static str,
    /// Its dimension n: what a consistent average tends to.
    pub dimension: usize,
    /// Runs in which it was recorded.
    pub runs: usize,
    /// The average over all runs and times; not divided by n.
    pub mean: f64,
    /// Its standard error, from the scatter of the runs.
    pub standard_error: f64,
    /// Where the average at one time lies with the confidence asked for, if the filter is consistent.
    pub interval: [f64; 2],
    /// √ of the average of |error|² over all runs and times.
    pub rmse: f64,
    /// The same of each coordinate, in its own unit.
    pub rmse_of_coordinates: Vec<f64>,
    /// The average over the runs, time by time, as far as every run recorded it.
    pub mean_by_time: Vec<f64>,
    /// RMSE, time by time.
    pub rmse_by_time: Vec<f64>,
}

/// Whether covariances are to be believed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Errors are larger than claimed.
    Overconfident,
    /// Errors are smaller than claimed.
    Underconfident,
    /// No contradiction at this number of runs.
    Consistent,
}

impl Series {
    /// The average against the interval: a contradiction is one at the confidence asked for.
    pub fn verdict(&self) -> Verdict {
        let [low, high] = self.interval;
        if self.mean < low {
            Verdict::Underconfident
        } else if self.mean <= high {
            Verdict::Consistent
        } else {
            Verdict::Overconfident // NaN as well: believe nothing
        }
    }

    /// The share of times whose average lies in the interval; of a consistent filter, about the confidence.
    pub fn share_inside(&self) -> f64 {
        let [low, high] = self.interval;
        let inside = self.mean_by_time.iter().filter(|x| (low..=high).contains(*x)).count();
        inside as f64 / self.mean_by_time.len().max(1) as f64
    }

    /// Of the runs that recorded it.
    fn of(name: &'static str, recorded: &[&Recorded], p: f64) -> Result<Self, UncertaintyError> {
        let dimension = recorded.iter().map(|run| run.squares.len()).min().unwrap_or(0);
        let runs: Vec<&[Sample]> = recorded.iter().map(|run| run.samples.as_slice()).collect();
        let n = runs.len();
        let all: Vec<Sample> = runs.iter().flat_map(|run| run.iter().copied()).collect();
        let mean = average(all.iter().map(|s| s.normalised));
        // Weighted by length, so that the average of the runs is the average of all.
        let scale = n as f64 / all.len() as f64;
        let deviation = |run: &[Sample]| run.iter().map(|s| s.normalised - mean).sum::<f64>() * scale;
        let scatter: f64 = runs.iter().map(|run| deviation(run) * deviation(run)).sum();
        let times = runs.iter().map(|run| run.len()).min().unwrap_or(0);
        let at = |k: usize| runs.iter().map(move |run| run[k]);
        Ok(Self {
            name,
            dimension,
            runs: n,
            mean,
            standard_error: if n > 1 { (scatter / (n * (n - 1)) as f64).sqrt() } else { f64::INFINITY },
            interval: ChiSquared::new(dimension * n).interval(p)?.map(|x| x / n as f64),
            rmse: average(all.iter().map(|s| s.square)).sqrt(),
            rmse_of_coordinates: (0..dimension)
                .map(|i| (recorded.iter().map(|run| run.squares[i]).sum::<f64>() / all.len() as f64).sqrt())
                .collect(),
            mean_by_time: (0..times).map(|k| average(at(k).map(|s| s.normalised))).collect(),
            rmse_by_time: (0..times).map(|k| average(at(k).map(|s| s.square)).sqrt()).collect(),
        })
    }
}

fn average(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
    sum / count
}

impl MonteCarlo {
    /// All runs of `simulation`, which gets a generator of its own and a record to fill.
    ///
    /// # Errors
    /// Those of the simulation, of the first run that fails; [`UncertaintyError::NotAProbability`] for a confidence outside (0, 1).
    pub fn run<R: SeedableRng>(
        &self,
        simulation: impl Fn(&mut R, &mut Run) -> Result<(), super::FilterError> + Sync,
    ) -> Result<Report, ConsistencyError> {
        self.run_while(|_| true, simulation)
    }

    /// The same, as long as `proceed` says so: it is asked before each run, with the number of runs that are finished. The report
    /// is of the runs that were made.
    ///
    /// # Errors
    /// Those of [`MonteCarlo::run`].
    pub fn run_while<R: SeedableRng>(
        &self,
        proceed: impl Fn(usize) -> bool + Sync,
        simulation: impl Fn(&mut R, &mut Run) -> Result<(), super::FilterError> + Sync,
    ) -> Result<Report, ConsistencyError> {
        let finished = AtomicUsize::new(0);
        let single = |i: usize| -> Result<_, super::FilterError> {
            if !proceed(finished.load(Ordering::Relaxed)) {
                return Ok(None);
            }
            let (mut rng, mut run) = (R::seed_from_u64(self.seed.wrapping_add(i as u64)), Run::default());
            simulation(&mut rng, &mut run)?;
            finished.fetch_add(1, Ordering::Relaxed);
            Ok(Some(run))
        };
        let runs = in_order(self.runs, self.threads.get(), single)?;
        Ok(self.report(&runs.into_iter().flatten().collect::<Vec<_>>())?)
    }

    fn report(&self, runs: &[Run]) -> Result<Report, UncertaintyError> {
        let all = || runs.iter().flat_map(|run| &run.series);
        let mut names: Vec<&'static str> = Vec::new();
        for recorded in all() {
            if !names.contains(&recorded.name) {
                names.push(recorded.name);
            }
        }
        let series = names.iter().map(|&name| {
            let recorded: Vec<_> = all().filter(|recorded| recorded.name == name).collect();
            Series::of(name, &recorded, self.confidence)
        });
        let series = series.collect::<Result<Vec<_>, _>>()?;
        Ok(Report { series, refused: runs.iter().map(|run| run.refused).sum() })
    }
}

/// Why an experiment has no result.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ConsistencyError {
    /// A run of the simulation failed.
    #[error(transparent)]
    Filter(#[from] super::FilterError),
    /// The confidence is no probability.
    #[error(transparent)]
    Uncertainty(#[from] UncertaintyError),
}

/// f(0), …, f(n − 1), in this order, computed by `threads` threads in contiguous parts; the first error, if any.
fn in_order<T: Send, X: Send>(
    n: usize,
    threads: usize,
    f: impl Fn(usize) -> Result<T, X> + Sync,
) -> Result<Vec<T>, X> {
    if threads <= 1 {
        return (0..n).map(f).collect();
    }
    let size = n.div_ceil(threads).max(1);
    let part = |start: usize| (start..n.min(start + size)).map(&f).collect::<Result<Vec<T>, X>>();
    let parts = thread::scope(|scope| {
        let part = &part;
        let handles: Vec<_> = (0..n).step_by(size).map(|start| scope.spawn(move || part(start))).collect();
        // A panic of the simulation goes on in the caller.
        let join = |handle: thread::ScopedJoinHandle<'_, _>| {
            handle.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        };
        handles.into_iter().map(join).collect::<Vec<_>>()
    });
    let mut all = Vec::with_capacity(n);
    for part in parts {
        all.extend(part?);
    }
    Ok(all)
}
