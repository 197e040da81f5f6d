//! Graduated non-convexity: outliers told from inliers without a guess that is near already.
//!
//! A kernel that ignores outliers has a minimum for every choice of what to ignore, and descent finds the nearest. Its surrogate is
//! as convex as least squares at first, for the largest residual there is, and is bent into the kernel stage by stage, each
//! stage starting where the last ended. Yang, Antonante, Tzoumas & Carlone (2020), §IV. Their weights are ρ′ of the surrogates
//! used here; each stage descends on the surrogate itself, so that no step raises its cost.

use core::fmt;
use core::ops::ControlFlow;
use std::collections::BTreeMap;

use super::{Iteration, Solution, SolveOptions};
use crate::graph::{FactorId, Graph, GraphError, Kernel, Values};
use crate::uncertainty::ChiSquared;

/// What the surrogates are bent into.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GraduatedLoss {
    /// ρ = min(s, c²): an outlier does not pull at all, an inlier as in least squares. [`Kernel::Truncated`].
    #[default]
    TruncatedLeastSquares,
    /// ρ = c²s/(c² + s): every residual pulls a little less than in least squares. [`Kernel::GemanMcClure`].
    GemanMcClure,
}

/// How outliers are told. See [`Graph::optimize_graduated`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Graduation {
    /// What the surrogates are bent into.
    pub loss: GraduatedLoss,
    /// c, the largest ‖U·r‖ of an inlier, in standard deviations; `None` is what one inlier in a hundred exceeds, the root of
    /// the 99 % quantile of χ² with as many degrees of freedom as the factor has residuals (3.37 in the plane, 4.10 in
    /// space).
    pub scale: Option<f64>,
}

impl Graduation {
    /// `"gnc-tls"` or `"gnc-gm"`.
    pub fn name(self) -> &'static str {
        match self.loss {
            GraduatedLoss::TruncatedLeastSquares => "gnc-tls",
            GraduatedLoss::GemanMcClure => "gnc-gm",
        }
    }

    /// c² of a factor with `dof` residuals.
    pub(crate) fn bound(self, dof: usize) -> f64 {
        let usual = || ChiSquared::new(dof).quantile(INLIERS).unwrap_or(f64::INFINITY);
        self.scale.map_or_else(usual, |scale| scale * scale)
    }

    /// The surrogate of a factor that tells outliers from c² on, where `control` is 0 at the end.
    fn kernel(self, bound: f64, control: f64) -> Kernel {
        match self.loss {
            GraduatedLoss::TruncatedLeastSquares => {
                Kernel::Truncated { scale: bound.sqrt(), spread: control }
            }
            GraduatedLoss::GemanMcClure => Kernel::GemanMcClure((bound * (1.0 + control)).sqrt()),
        }
    }
}

impl fmt::Display for Graduation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())?;
        self.scale.map_or(Ok(()), |scale| write!(f, ":{scale}"))
    }
}

/// How fast the surrogates are bent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    /// No control is larger: what lies beyond c²(1 + most) does not pull at first.
    pub(crate) most: f64,
    /// By how much the control falls from stage to stage.
    pub(crate) step: f64,
    /// The share of c² that is meant: the variance seen as a share of that stated.
    pub(crate) noise: f64,
}

impl Default for Pace {
    fn default() -> Self {
        Self { most: f64::INFINITY, step: STEP, noise: 1.0 }
    }
}

/// Share of the inliers that the usual scale keeps.
const INLIERS: f64 = 0.99;
/// By how much the control falls from stage to stage. Yang et al. (2020), Remark 5.
const STEP: f64 = 1.4;
/// Below this the surrogate is the kernel.
const BENT: f64 = 1e-2;
/// Trial steps a stage: the next one goes on from wherever it ends.
const STEPS: usize = 8;
/// What a stage may leave of its cost to gain.
const STAGE_COST: f64 = 1e-4;

/// An estimate, and what it takes to be outliers.
#[derive(Clone, Debug)]
pub struct Graduated {
    /// The estimate; its report is that of the last stage.
    pub solution: Solution,
    /// How many surrogates were minimised before the kernel itself.
    pub stages: usize,
    /// The suspects that do not agree with the estimate: those with ‖U·r‖ > c.
    pub rejected: Vec<FactorId>,
}

impl Graph {
    /// The values of least cost near `initial` where some of the `suspects` may be gross outliers, as false loop closures
    /// are. All other factors are trusted. On return the suspects keep the robust kernel. Suspects of another graph are passed
    /// over.
    ///
    /// Start from an estimate that no suspect went into; the closer the trusted factors hold it, the more outliers can be
    /// told. The first surrogate is nearly least squares on everything: where that has many minima, as pose graphs have whose
    /// odometry is wrong by as much as the map is wide, the outliers choose among them. For pose graphs
    /// `pose_graph::SolveSettings::graduation` therefore begins elsewhere. Time: some ten to fifty stages of a few steps.
    ///
    /// ```
    /// use boxplus::graph::{Between, Graduation, Graph, Noise, Prior, SolveOptions, Values};
    /// use boxplus::lie::{LieGroup, SE2};
    /// use nalgebra::vector;
    /// let (mut graph, mut values) = (Graph::new(), Values::new());
    /// let keys: Vec<_> = (0..20).map(|i| values.insert(SE2::new(vector![f64::from(i), 0.0], 0.0))).collect();
    /// let noise = Noise::from_sigmas(&vector![0.1, 0.1, 0.05])?;
    /// let step = SE2::new(vector![1.0, 0.0], 0.0);
    /// keys.windows(2).for_each(|pair| drop(graph.add((pair[0], pair[1]), Between::new(step), noise)));
    /// graph.add((keys[0],), Prior { mean: SE2::identity() }, Noise::unit());
    /// let right = graph.add((keys[0], keys[10]), Between::new(SE2::new(vector![10.0, 0.0], 0.0)), noise);
    /// let wrong = graph.add((keys[5], keys[19]), Between::new(SE2::new(vector![0.0, 0.0], 1.0)), noise);
    /// let options = SolveOptions::default();
    /// let found = graph.optimize_graduated(&values, &options, &[right, wrong], Graduation::default())?;
    /// assert_eq!(found.rejected, [wrong]);
    /// # Ok::<(), boxplus::graph::GraphError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Graph::optimize`]; [`GraphError::InvalidKernel`] for a scale that is not positive and finite.
    pub fn optimize_graduated(
        &mut self,
        initial: &Values,
        options: &SolveOptions,
        suspects: &[FactorId],
        graduation: Graduation,
    ) -> Result<Graduated, GraphError> {
        self.optimize_graduated_observed(initial, options, suspects, graduation, &mut |_| {
            ControlFlow::Continue(())
        })
    }

    /// As [`Self::optimize_graduated`]; `observer` sees every trial step, whose cost is that of the stage's surrogate, and may
    /// stop with the estimate so far.
    ///
    /// # Errors
    /// As [`Self::optimize_graduated`].
    pub fn optimize_graduated_observed(
        &mut self,
        initial: &Values,
        options: &SolveOptions,
        suspects: &[FactorId],
        graduation: Graduation,
        observer: &mut dyn FnMut(&Iteration) -> ControlFlow<()>,
    ) -> Result<Graduated, GraphError> {
        self.optimize_graduated_at(initial, options, suspects, (graduation, Pace::default()), observer)
    }

    /// As [`Self::optimize_graduated_observed`], at another pace.
    pub(crate) fn optimize_graduated_at(
        &mut self,
        initial: &Values,
        options: &SolveOptions,
        suspects: &[FactorId],
        (graduation, pace): (Graduation, Pace),
        observer: &mut dyn FnMut(&Iteration) -> ControlFlow<()>,
    ) -> Result<Graduated, GraphError> {
        let mut bounds = BTreeMap::new(); // a quantile costs more than a factor
        let mut suspect = |&id: &FactorId| {
            let dof = self.residual_dim(id)?;
            let bound = *bounds.entry(dof).or_insert_with(|| pace.noise * graduation.bound(dof));
            Some(Suspect { id, bound })
        };
        let suspects: Vec<Suspect> = suspects.iter().filter_map(&mut suspect).collect();
        let mut control = self.first_control(&suspects, initial, graduation)?.min(pace.most);
        let stage = SolveOptions {
            max_iterations: STEPS.min(options.max_iterations),
            relative_cost: STAGE_COST.max(options.relative_cost),
            ..options.clone()
        };
        let (mut values, mut stages, mut stopped) = (initial.clone(), 0, false);
        while control > BENT && !stopped {
            self.bend(&suspects, graduation, control);
            let mut watch = |i: &Iteration| {
                let flow = observer(i);
                stopped |= flow.is_break();
                flow
            };
            values = self.optimize_observed(&values, &stage, &mut watch)?.values;
            control /= pace.step;
            stages += 1;
        }
        self.bend(&suspects, graduation, 0.0);
        let mut last = |i: &Iteration| if stopped { ControlFlow::Break(()) } else { observer(i) };
        let solution = self.optimize_observed(&values, options, &mut last)?;
        let outlier = |s: &&Suspect| self.squared_error(s.id, &solution.values).is_some_and(|x| x > s.bound);
        let rejected = suspects.iter().filter(outlier).map(|s| s.id).collect();
        Ok(Graduated { solution, stages, rejected })
    }

    /// The control at which the surrogate of the worst suspect is convex up to its residual: s ≤ c²(1 + β)/2 (Yang et al.
    /// (2020), Remark 5: μ = c²/(2s − c²) = 1/β for truncated least squares, μ = 2s/c² ≈ 1 + β for Geman–McClure).
    fn first_control(
        &mut self,
        suspects: &[Suspect],
        initial: &Values,
        graduation: Graduation,
    ) -> Result<f64, GraphError> {
        self.bend(suspects, graduation, 0.0);
        self.check(initial)?;
        let excess = |s: &Suspect| self.squared_error(s.id, initial).map_or(0.0, |x| 2.0 * x / s.bound - 1.0);
        // What is not finite is refused by the solver, with its name.
        Ok(suspects.iter().map(excess).filter(|x| x.is_finite()).fold(0.0, f64::max))
    }

    fn bend(&mut self, suspects: &[Suspect], graduation: Graduation, control: f64) {
        for suspect in suspects {
            self.set_kernel_of(suspect.id, graduation.kernel(suspect.bound, control));
        }
    }
}

/// A factor that may be an outlier, and the largest ‖U·r‖² it may have.
struct Suspect {
    id: FactorId,
    bound: f64,
}
