//! Nonlinear least squares on manifolds: Levenberg–Marquardt, Gauss–Newton, Powell's dogleg.
//!
//! All three minimise F(X) = ½ Σ ρ(‖U·r(X)‖²) by steps X ⊞ δ from the model F + gᵀδ + ½ δᵀHδ with H = JᵀJ, g = Jᵀr
//! (weighted by ρ′). They differ in how far they trust the model. H is kept undamped, so that a rejected step costs no
//! linearisation, and everything that depends on the structure alone is computed once.

pub(crate) mod clock;
mod graduated;
mod report;
pub(crate) mod step;

use core::ops::ControlFlow;

use super::diagnose::{Unconstrained, weakest};
use super::linear::analyses::Analyses;
use super::linear::cholesky::Cholesky;
use super::linear::evaluate::Evaluator;
use super::linear::structure::Structure;
use super::set::AnySet;
use super::values::Values;
use super::{GraphError, gauge};
use clock::Clock;
#[cfg(feature = "io")]
pub(crate) use graduated::Pace;
pub use graduated::{Graduated, GraduatedLoss, Graduation};
pub use report::{Iteration, Seconds, SolveReport, Termination};
use step::{Region, Step, System};

/// How the optimiser moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Algorithm {
    /// Damped steps (H + λD)δ = −g, D the diagonal of H. The safe choice. Nielsen (1999); Madsen et al. (2004), §3.2.
    #[default]
    LevenbergMarquardt,
    /// Full steps Hδ = −g: fastest near the minimum, without a safety net far from it.
    GaussNewton,
    /// Between steepest descent and Gauss–Newton, within a trust region; one factorisation a linearisation.
    /// Powell (1970); Madsen et al. (2004), §3.3.
    Dogleg,
}

/// When to stop, and how to move.
#[derive(Clone, Debug, PartialEq)]
pub struct SolveOptions {
    /// How the optimiser moves.
    pub algorithm: Algorithm,
    /// Stop after this many trial steps.
    pub max_iterations: usize,
    /// Stop when a step that is not held back lowers the cost by less than `relative_cost`·cost, or the model promises no
    /// more than that.
    pub relative_cost: f64,
    /// Stop when max |gᵢ|/√Hᵢᵢ < `gradient`, in standard deviations.
    pub gradient: f64,
    /// Stop when max |δᵢ|·√Hᵢᵢ < `step`, in standard deviations.
    pub step: f64,
    /// The first λ of Levenberg–Marquardt, relative to the diagonal of H.
    pub initial_damping: f64,
    /// The first trust radius of dogleg, in standard deviations: ‖√D·δ‖ ≤ radius.
    pub initial_radius: f64,
    /// Whether to look for directions that nothing constrains, where the last factorisation hints at any: some factorisations
    /// more. For graphs of which it is known that they leave directions open.
    pub diagnose: bool,
    /// Threads that linearise; 0 means one per core. No bit of the result depends on it.
    pub threads: usize,
}

impl Default for SolveOptions {
    fn default() -> Self {
        Self {
            algorithm: Algorithm::LevenbergMarquardt,
            max_iterations: 100,
            relative_cost: 1e-9,
            gradient: 1e-9,
            step: 1e-9,
            initial_damping: 1e-6,
            initial_radius: 1e4,
            diagnose: true,
            threads: 0,
        }
    }
}

/// The estimate a solve ended with, and how it went.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The best values found.
    pub values: Values,
    /// How it went.
    pub report: SolveReport,
    /// The directions that nothing constrains, where there are any: there the values are arbitrary.
    pub unconstrained: Option<Unconstrained>,
}

/// Minimises the cost from `initial`, where it is `cost`; `observer` sees every trial step and may stop the search.
pub(super) fn optimize(
    (sets, analyses): (&[Box<dyn AnySet>], &Analyses),
    (initial, cost): (&Values, f64),
    options: &SolveOptions,
    observer: &mut dyn FnMut(&Iteration) -> ControlFlow<()>,
) -> Result<Solution, GraphError> {
    let clock = Clock::start();
    let mut values = initial.clone();
    let gauge = gauge::fix(sets, &mut values);
    let structure = Structure::new(sets, &values, analyses)?;
    let evaluator = Evaluator::new(sets, options.threads);
    let mut cholesky = Cholesky::new(&structure.pattern)?;
    cholesky.share(evaluator.pool())?;
    let report = SolveReport {
        initial_cost: cost,
        cost: 0.0,
        iterations: vec![],
        termination: Termination::MaxIterations,
        gauge: gauge.iter().map(|&id| initial.name(id)).collect(),
        unread: structure.unread.iter().map(|&id| initial.name(id)).collect(),
        unknowns: structure.size(),
        factor_len: cholesky.factor_len(),
        threads: evaluator.threads(),
        seconds: Seconds::default(),
    };
    let seconds = Seconds { analyse: clock.seconds(), ..Seconds::default() };
    let system = System { structure: &structure, normal: structure.normal(), cholesky, clock, seconds };
    let mut search = Search {
        trial: values.clone(),
        best: None,
        cost: report.initial_cost,
        region: Region::new(options, structure.size()),
        system,
        values,
        evaluator,
        report,
    };
    search.report.termination = search.run(options, observer)?;
    let unconstrained = if options.diagnose { search.unconstrained()? } else { None };
    let mut solution = search.finish(unconstrained);
    gauge.iter().for_each(|&id| solution.values.set_held(id, false));
    Ok(solution)
}

struct Search<'a> {
    evaluator: Evaluator<'a>,
    system: System<'a>,
    region: Region,
    values: Values,
    cost: f64,
    trial: Values,
    /// Gauss–Newton may climb: the best estimate before it did.
    best: Option<(Values, f64)>,
    report: SolveReport,
}

impl Search<'_> {
    /// linearise → step → try → accept or reject, until there is a reason to stop.
    fn run(
        &mut self,
        options: &SolveOptions,
        observer: &mut dyn FnMut(&Iteration) -> ControlFlow<()>,
    ) -> Result<Termination, GraphError> {
        if self.system.structure.size() == 0 {
            return Ok(Termination::NothingToSolve);
        }
        let mut gradient = f64::NAN;
        let mut fresh = true; // no step from this linearisation has been rejected
        let mut moved = true; // there is none yet at these values
        while self.report.iterations.len() < options.max_iterations {
            if core::mem::take(&mut moved) {
                gradient = self.linearise();
            }
            if gradient < options.gradient {
                return Ok(if self.all_silenced() { Termination::NoDecrease } else { Termination::Gradient });
            }
            let Some(step) = self.propose()? else { return Ok(Termination::NoDecrease) };
            let small = step.scaled < options.step;
            if fresh && (small || step.predicted <= options.relative_cost * self.cost) {
                if self.region.binds() {
                    self.region.loosen();
                    continue;
                }
                // What remains is below the tolerance: take it if it helps, and stop.
                let iteration = self.attempt(&step, gradient, true);
                let _ = observer(&iteration); // it stops here anyway
                return Ok(if small { Termination::Step } else { Termination::RelativeCost });
            }
            let iteration = self.attempt(&step, gradient, false);
            if observer(&iteration).is_break() {
                return Ok(Termination::Interrupted);
            }
            fresh = iteration.accepted;
            if iteration.accepted {
                let settled = iteration.decrease.abs() <= options.relative_cost * self.cost;
                if settled && iteration.gain > 0.25 && !self.region.binds() {
                    return Ok(Termination::RelativeCost);
                }
                moved = true;
            } else if self.region.exhausted() {
                return Ok(if options.algorithm == Algorithm::GaussNewton {
                    Termination::Diverged
                } else {
                    Termination::NoDecrease
                });
            }
        }
        Ok(Termination::MaxIterations)
    }

    /// Whether robust kernels have silenced every factor: the gradient then vanishes without a minimum.
    fn all_silenced(&self) -> bool {
        self.cost > 0.0 && self.system.normal.matrix.iter().all(|h| *h == 0.0)
    }

    /// Refills the normal equations at the current values; returns the scaled gradient.
    fn linearise(&mut self) -> f64 {
        let Self { evaluator, system, region, values, .. } = self;
        let start = system.clock.seconds();
        evaluator.linearise(values, system.structure, &mut system.normal);
        region.linearised(system.structure, &system.normal);
        system.seconds.linearise += system.clock.seconds() - start;
        region.scaled_gradient(&system.normal)
    }

    /// The next step to try, or `None` where no damping makes the equations solvable.
    fn propose(&mut self) -> Result<Option<Step>, GraphError> {
        match self.region.step(&mut self.system) {
            Some(step) => Ok(Some(step)),
            None if self.region.is_damped() => Ok(None),
            None => Err(
                match weakest(&self.evaluator, self.system.structure, &self.system.normal, &self.values)? {
                    Some(unconstrained) => GraphError::Unconstrained(unconstrained),
                    None => GraphError::IllConditioned,
                },
            ),
        }
    }

    /// Moves to X ⊞ δ if the cost says so, adapts the region, and records the trial.
    fn attempt(&mut self, step: &Step, gradient: f64, last: bool) -> Iteration {
        let start = self.system.clock.seconds();
        self.values.retract_into(&mut self.trial, &step.delta, &self.system.structure.offsets);
        let cost = self.evaluator.cost(&self.trial);
        self.system.seconds.evaluate += self.system.clock.seconds() - start;

        let decrease = self.cost - cost;
        let gain = decrease / step.predicted;
        let damping = self.region.damping();
        let accepted = if last { cost < self.cost } else { self.region.judge(cost, gain, step) };
        if accepted {
            if decrease < 0.0 && self.best.as_ref().is_none_or(|(_, best)| self.cost < *best) {
                self.best = Some((self.values.clone(), self.cost));
            }
            core::mem::swap(&mut self.values, &mut self.trial);
            self.cost = cost;
        }
        let iteration = Iteration {
            cost: self.cost,
            decrease,
            gain,
            damping,
            gradient,
            step: step.scaled,
            accepted,
            seconds: self.system.clock.seconds(),
        };
        self.report.iterations.push(iteration);
        iteration
    }

    /// Looks for directions that nothing constrains, if the last factor hints at any.
    fn unconstrained(&mut self) -> Result<Option<Unconstrained>, GraphError> {
        let silenced = self.report.termination == Termination::NoDecrease;
        let nothing = self.system.structure.size() == 0;
        if nothing || silenced || !self.region.hints_at_singularity(&mut self.system) {
            return Ok(None);
        }
        weakest(&self.evaluator, self.system.structure, &self.system.normal, &self.values)
    }

    fn finish(mut self, unconstrained: Option<Unconstrained>) -> Solution {
        let (values, cost) = match self.best {
            Some((values, cost)) if cost < self.cost => {
                self.report.termination = Termination::Diverged; // wherever it went, it was better before
                (values, cost)
            }
            _ => (self.values, self.cost),
        };
        self.report.cost = cost;
        self.report.seconds = Seconds { total: self.system.clock.seconds(), ..self.system.seconds };
        Solution { values, report: self.report, unconstrained }
    }
}
