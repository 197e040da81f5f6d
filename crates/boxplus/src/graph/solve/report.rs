//! What a solve says of itself.

use core::fmt;

use crate::graph::VariableName;

/// Why the optimiser stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Termination {
    /// The cost no longer changes: see [`SolveOptions::relative_cost`](super::SolveOptions::relative_cost).
    RelativeCost,
    /// The gradient vanished: see [`SolveOptions::gradient`](super::SolveOptions::gradient).
    Gradient,
    /// The step vanished: see [`SolveOptions::step`](super::SolveOptions::step).
    Step,
    /// No variable is free, or no factor is there.
    NothingToSolve,
    /// The allowed iterations are used up.
    MaxIterations,
    /// No step, however damped, lowers the cost any more, though the gradient has not vanished; or robust kernels have
    /// silenced every factor.
    NoDecrease,
    /// Gauss–Newton steps raised the cost; the best estimate before is returned. Levenberg–Marquardt may do better.
    Diverged,
    /// The observer asked to stop.
    Interrupted,
}

impl Termination {
    /// Whether a minimum was reached.
    pub fn converged(self) -> bool {
        matches!(self, Self::RelativeCost | Self::Gradient | Self::Step | Self::NothingToSolve)
    }

    /// A name for machines: `"relative_cost"`.
    pub fn name(self) -> &'static str {
        match self {
            Self::RelativeCost => "relative_cost",
            Self::Gradient => "gradient",
            Self::Step => "step",
            Self::NothingToSolve => "nothing_to_solve",
            Self::MaxIterations => "max_iterations",
            Self::NoDecrease => "no_decrease",
            Self::Diverged => "diverged",
            Self::Interrupted => "interrupted",
        }
    }
}

impl fmt::Display for Termination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::RelativeCost => "the cost no longer changes",
            Self::Gradient => "the gradient vanished",
            Self::Step => "the step vanished",
            Self::NothingToSolve => "nothing to solve",
            Self::MaxIterations => "the allowed iterations are used up",
            Self::NoDecrease => "no step lowers the cost any more",
            Self::Diverged => "the steps raise the cost",
            Self::Interrupted => "interrupted",
        })
    }
}

/// One trial step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iteration {
    /// Cost of the estimate after this trial.
    pub cost: f64,
    /// Cost before, less the cost that the trial reached: negative where it went up.
    pub decrease: f64,
    /// The actual decrease over the one that the linear model promised.
    pub gain: f64,
    /// Levenberg–Marquardt's λ, or dogleg's trust radius; 0 for Gauss–Newton.
    pub damping: f64,
    /// Largest |gᵢ|/√Hᵢᵢ before the step: what one coordinate alone could gain, in standard deviations.
    pub gradient: f64,
    /// Largest |δᵢ|·√Hᵢᵢ: how far one coordinate moves, in its standard deviations with all others held.
    pub step: f64,
    /// Whether the estimate moved.
    pub accepted: bool,
    /// Seconds since the solve began.
    pub seconds: f64,
}

/// Seconds spent in each phase of a solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seconds {
    /// Ordering, layout and symbolic factorisation, once.
    pub analyse: f64,
    /// Residuals, Jacobians and normal equations.
    pub linearise: f64,
    /// Numeric factorisations.
    pub factorise: f64,
    /// Triangular solves.
    pub solve: f64,
    /// Trial costs.
    pub evaluate: f64,
    /// All of it.
    pub total: f64,
}

/// How a solve went.
#[derive(Clone, Debug, PartialEq)]
pub struct SolveReport {
    /// Cost ½ Σ ρ(‖U·r‖²) of the initial values.
    pub initial_cost: f64,
    /// Cost of the result.
    pub cost: f64,
    /// Every trial step, in order.
    pub iterations: Vec<Iteration>,
    /// Why it stopped.
    pub termination: Termination,
    /// What was held for lack of any fixed variable or prior, one for each connected part of the graph.
    pub gauge: Vec<VariableName>,
    /// Free variables that no factor reads: they keep their values.
    pub unread: Vec<VariableName>,
    /// Free scalars.
    pub unknowns: usize,
    /// Numbers in the factor L.
    pub factor_len: usize,
    /// Threads that linearised.
    pub threads: usize,
    /// Where the time went.
    pub seconds: Seconds,
}

impl SolveReport {
    /// Whether a minimum was reached.
    pub fn converged(&self) -> bool {
        self.termination.converged()
    }

    /// Number of steps that moved the estimate.
    pub fn accepted(&self) -> usize {
        self.iterations.iter().filter(|iteration| iteration.accepted).count()
    }
}
