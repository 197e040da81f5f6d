//! Factor graphs: what was measured, what is estimated, and the estimate that fits best.
//!
//! [`Values`] hold the variables, a [`Graph`] holds the factors. [`Graph::optimize`] finds the values of least cost
//! F(X) = ½ Σ ρ(‖U·r(X)‖²), where U is the square root of a factor's information matrix and ρ its robust kernel.
//! Steps are local, X ⊞ δ = X·Exp(δ). [`Graph::marginals`] says how sure the result is.
//!
//! ```
//! use boxplus::graph::{Between, Graph, Initial, Noise, Prior, SolveOptions, Values};
//! use boxplus::lie::{LieGroup, SE2};
//! use nalgebra::vector;
//!
//! let (mut graph, mut values) = (Graph::new(), Values::new());
//! let corners: Vec<_> = (0..4).map(|_| values.insert(SE2::identity())).collect();
//! let side = SE2::new(vector![1.0, 0.0], core::f64::consts::FRAC_PI_2); // drive one metre, turn left
//! let noise = Noise::from_sigmas(&vector![0.1, 0.1, 0.05])?;
//! for i in 0..4 {
//!     graph.add((corners[i], corners[(i + 1) % 4]), Between::new(side), noise); // the last closes the loop
//! }
//! graph.add((corners[0],), Prior { mean: SE2::identity() }, Noise::unit());
//!
//! let start = graph.initialise(&values, Initial::Auto)?.values; // never start from nothing
//! let solution = graph.optimize(&start, &SolveOptions::default())?;
//! assert!(solution.report.converged() && solution.report.cost < 1e-20);
//! let opposite = solution.values.get(corners[2]).unwrap().translation();
//! assert!((opposite - vector![1.0, 1.0]).norm() < 1e-9);
//! # Ok::<(), boxplus::graph::GraphError>(())
//! ```

mod conditioning;
mod diagnose;
mod error;
mod factor;
mod factors;
mod gauge;
mod initialise;
pub(crate) mod linear;
mod marginals;
mod minimum_norm;
mod names;
mod noise;
mod renewal;
mod set;
#[cfg(feature = "rand")]
mod simulations;
mod solve;
mod together;
mod values;
mod variable;

pub use conditioning::{Conditioning, Loose, Weak};
pub use diagnose::{FreeCoordinate, Unconstrained};
pub use error::GraphError;
pub use factor::{Factor, FactorId, MAX_ARITY, Variables, dual_jacobians};

pub use crate::label::{Label, NoLabel};
pub use crate::robust::{Kernel, KernelError};
pub use factors::{
    Bearing2, Bearing3, Between, CalibratedOdometry, Chart, Chordal, Difference, G2o, Inertial,
    InertialUnderGravity, Interpolated, Log, MotionPrior, OnSpline, Position, Prior, Product, Range,
    Reprojection, ReprojectionOwn, ReprojectionShared, Sighting2, Sighting3, SplineImu, Velocity,
};
#[cfg(feature = "io")]
pub(crate) use factors::{isotropic_information, isotropic_weights};
pub use initialise::{Growth, Initial, Initialisation, inertial_start};
pub use marginals::Marginals;
pub use names::{FactorName, VariableName};
pub use noise::Noise;
pub use renewal::{Renewal, Renewed};
#[cfg(feature = "rand")]
pub use simulations::{BeaconDrive, Driven, Nees, Sees};
#[cfg(feature = "io")]
pub(crate) use solve::Pace;
#[cfg(feature = "io")]
pub(crate) use solve::clock::Clock;
pub use solve::{
    Algorithm, Graduated, GraduatedLoss, Graduation, Iteration, Seconds, Solution, SolveOptions, SolveReport,
    Termination,
};
pub use together::FactorBatch;
pub use values::{Key, Values, VariableId};
pub use variable::{
    CameraVariable, Carries, GroupVariable, JacobianBlock, Located, PointVariable, TangentResidual, Variable,
    ViewVariable, derivative,
};

use core::ops::ControlFlow;
use std::collections::HashMap;

use linear::analyses::Analyses;
use linear::evaluate::Evaluator;
use set::{AnySet, FactorSet};
use values::State;

/// The factors: what was measured, with which noise.
#[derive(Default)]
pub struct Graph {
    sets: Vec<Box<dyn AnySet>>,
    analyses: Analyses,
}

impl Graph {
    /// No factors.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a measurement of the variables `keys`, with Gaussian noise.
    pub fn add<F: Factor<R>, const R: usize>(
        &mut self,
        keys: <F::Variables as Variables>::Keys,
        factor: F,
        noise: Noise<R>,
    ) -> FactorId {
        self.add_robust(keys, factor, noise, Kernel::None)
    }

    /// Adds a measurement whose pull is bounded by a robust kernel.
    pub fn add_robust<F: Factor<R>, const R: usize>(
        &mut self,
        keys: <F::Variables as Variables>::Keys,
        factor: F,
        noise: Noise<R>,
        kernel: Kernel,
    ) -> FactorId {
        let (number, set) = self.set_mut::<F, R>();
        let index = set.push(F::Variables::slots(&keys), factor, noise, kernel);
        FactorId { set: number as u32, index: index as u32 }
    }

    /// Gives every factor this kernel.
    pub fn set_kernel(&mut self, kernel: Kernel) {
        self.sets.iter_mut().for_each(|set| set.kernels_mut().fill(kernel));
    }

    /// Gives one factor this kernel; an id of another graph is passed over.
    pub fn set_kernel_of(&mut self, factor: FactorId, kernel: Kernel) {
        if self.set_of(factor).is_some() {
            self.sets[factor.set as usize].kernels_mut()[factor.index as usize] = kernel;
        }
    }

    /// How many numbers the residual of a factor has; `None` for an id of another graph.
    pub(crate) fn residual_dim(&self, factor: FactorId) -> Option<usize> {
        self.set_of(factor).map(AnySet::residual_dim)
    }

    /// The set that holds a factor.
    fn set_of(&self, factor: FactorId) -> Option<&dyn AnySet> {
        self.sets
            .get(factor.set as usize)
            .filter(|set| (factor.index as usize) < set.len())
            .map(AsRef::as_ref)
    }

    /// Number of factors.
    pub fn len(&self) -> usize {
        self.sets.iter().map(|set| set.len()).sum()
    }

    /// Whether there is no factor.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Every factor, by type and then in order of addition.
    pub fn ids(&self) -> impl Iterator<Item = FactorId> {
        self.sets.iter().enumerate().flat_map(|(set, factors)| {
            (0..factors.len()).map(move |index| FactorId { set: set as u32, index: index as u32 })
        })
    }

    /// What messages call a factor; `None` for an id of another graph.
    pub fn name(&self, factor: FactorId, values: &Values) -> Option<FactorName> {
        let set = self.set_of(factor)?;
        let variables = set.ids(factor.index as usize).iter().map(|&id| values.name(id)).collect();
        Some(FactorName { kind: set.name(), variables })
    }

    /// ‖U·r‖² of a factor: χ² with R degrees of freedom if the noise is as stated. `None` for an id of another graph.
    pub fn squared_error(&self, factor: FactorId, values: &Values) -> Option<f64> {
        Some(self.set_of(factor)?.squared(values, factor.index as usize))
    }

    /// The connected parts of the graph, each in the order of its variables: no factor joins one to another, so that they
    /// have no place relative to each other. Variables that no factor reads are left out.
    pub fn parts(&self, values: &Values) -> Vec<Vec<VariableName>> {
        let names = |part: gauge::Part| part.variables.into_iter().map(|id| values.name(id)).collect();
        gauge::parts(&self.sets, values).into_iter().map(names).collect()
    }

    /// Measures anew what was linearised about a variable, about its value now: inertial sums about the estimated biases.
    ///
    /// Tells by how much the old ones were off there; where that is no small part of a standard deviation, solve again:
    ///
    /// ```
    /// # use boxplus::graph::{Graph, GraphError, SolveOptions, Solution, Values};
    /// fn solve(graph: &mut Graph, start: &Values) -> Result<Solution, GraphError> {
    ///     let mut solution = graph.optimize(start, &SolveOptions::default())?;
    ///     while graph.renew(&solution.values)?.largest > 0.1 {
    ///         solution = graph.optimize(&solution.values, &SolveOptions::default())?;
    ///     }
    ///     Ok(solution)
    /// }
    /// # assert!(solve(&mut Graph::new(), &Values::new()).is_ok());
    /// ```
    ///
    /// # Errors
    /// Those of [`Graph::cost`].
    pub fn renew(&mut self, values: &Values) -> Result<Renewal, GraphError> {
        self.check(values)?;
        let renewals = self.sets.iter_mut().map(|set| set.renew(values));
        Ok(renewals.fold(Renewal::default(), Renewal::and))
    }

    /// The cost ½ Σ ρ(‖U·r‖²).
    ///
    /// # Errors
    /// [`GraphError::MissingValues`], [`GraphError::ValueNotFinite`], [`GraphError::ForeignKey`],
    /// [`GraphError::InvalidKernel`].
    pub fn cost(&self, values: &Values) -> Result<f64, GraphError> {
        self.check(values)?;
        Ok(Evaluator::new(&self.sets, 1).cost(values))
    }

    /// The values of least cost near `initial`. Held variables do not move. Where nothing ties a connected part of the
    /// graph down, one of its variables is held; the report says which.
    ///
    /// Not converging is no error: see [`SolveReport::termination`].
    ///
    /// # Errors
    /// Those of [`Graph::cost`]; [`GraphError::ResidualNotFinite`]; for Gauss–Newton and dogleg also
    /// [`GraphError::Unconstrained`] and [`GraphError::IllConditioned`]; [`GraphError::OutOfMemory`].
    pub fn optimize(&self, initial: &Values, options: &SolveOptions) -> Result<Solution, GraphError> {
        self.optimize_observed(initial, options, &mut |_| ControlFlow::Continue(()))
    }

    /// As [`Self::optimize`]; `observer` sees every trial step, and may stop with the best values so far.
    ///
    /// # Errors
    /// As [`Self::optimize`].
    pub fn optimize_observed(
        &self,
        initial: &Values,
        options: &SolveOptions,
        observer: &mut dyn FnMut(&Iteration) -> ControlFlow<()>,
    ) -> Result<Solution, GraphError> {
        self.check(initial)?;
        let cost = Evaluator::new(&self.sets, 1).cost(initial);
        if let Some(factor) = self.first_not_finite(initial, cost) {
            return Err(GraphError::ResidualNotFinite { factor });
        }
        solve::optimize((&self.sets, &self.analyses), (initial, cost), options, observer)
    }

    /// Covariances of the variables at `values`, the estimate.
    ///
    /// # Errors
    /// Those of [`Graph::cost`]; [`GraphError::Unconstrained`] where the graph does not determine them;
    /// [`GraphError::IllConditioned`], [`GraphError::OutOfMemory`].
    pub fn marginals(&self, values: &Values) -> Result<Marginals, GraphError> {
        self.check(values)?;
        Marginals::new(&self.sets, values, &self.analyses)
    }

    /// As [`Graph::marginals`], but without a gauge where no variable is held and no factor ties the world down: blocks of the
    /// pseudo-inverse (JᵀJ)⁺, of all covariances that the factors allow the one of least trace. No variable is known exactly
    /// then, and none is favoured; the covariance of a relative quantity is the same in every gauge. Least is meant in the coordinates of the tangents, of
    /// which metres and radians count alike: with other units it is another matrix. Time: as for [`Graph::marginals`], twice.
    ///
    /// ```
    /// use boxplus::graph::{Between, Graph, Noise, Values};
    /// use boxplus::lie::Rn;
    /// use nalgebra::vector;
    /// let (mut graph, mut values) = (Graph::new(), Values::new());
    /// let (a, b) = (values.insert(Rn::new(vector![0.0])), values.insert(Rn::new(vector![3.0])));
    /// graph.add((a, b), Between::new(Rn::new(vector![3.0])), Noise::from_sigmas(&vector![0.2])?);
    /// let mut free = graph.marginals_of_minimum_norm(&values)?;
    /// // b − a is known to 0.04 m². Held at a, all of it is b's; without a gauge each has a quarter, and they move against each other.
    /// let joint = free.joint(&[a.into(), b.into()])?;
    /// assert!((joint[(0, 0)] - 0.01).abs() < 1e-15 && (joint[(0, 1)] + 0.01).abs() < 1e-15);
    /// assert!(free.gauge().is_empty());
    /// # Ok::<(), boxplus::graph::GraphError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Graph::marginals`].
    pub fn marginals_of_minimum_norm(&self, values: &Values) -> Result<Marginals, GraphError> {
        self.check(values)?;
        Marginals::of_minimum_norm(&self.sets, values, &self.analyses)
    }

    /// The factors all of whose variables are known.
    fn part(&self, knows: impl Fn(VariableId) -> bool) -> Self {
        let part = |set: &dyn AnySet| {
            let kinds = set.kinds();
            let id = |(&kind, &slot)| VariableId { kind, slot };
            set.part(&|factor| kinds.iter().zip(set.slots(factor)).map(id).all(&knows))
        };
        Self { sets: self.sets.iter().map(AsRef::as_ref).map(part).collect(), analyses: Analyses::default() }
    }

    fn set_mut<F: Factor<R>, const R: usize>(&mut self) -> (usize, &mut FactorSet<F, R>) {
        let position = self.sets.iter().position(|set| set.as_any().is::<FactorSet<F, R>>());
        let position = position.unwrap_or_else(|| {
            self.sets.push(Box::new(FactorSet::<F, R>::new()));
            self.sets.len() - 1
        });
        match self.sets[position].as_any_mut().downcast_mut() {
            Some(set) => (position, set),
            None => unreachable!("a set is found by the type it holds"),
        }
    }

    /// Every variable that a factor reads exists and has a finite value, and every kernel makes sense.
    fn check(&self, values: &Values) -> Result<(), GraphError> {
        let states = self.check_keys(values)?;
        if states.is_empty() {
            return Ok(());
        }
        let with = |wanted: State| {
            let matching = values.ids().filter(|id| states.get(id) == Some(&wanted));
            matching.map(|id| values.name(id)).collect::<Vec<_>>()
        };
        let missing = with(State::Declared);
        if !missing.is_empty() {
            return Err(GraphError::MissingValues { variables: missing });
        }
        match with(State::NotFinite).first() {
            Some(&variable) => Err(GraphError::ValueNotFinite { variable }),
            None => Ok(()),
        }
    }

    /// Every variable that a factor reads exists, and every kernel makes sense; returns the states that are not finite.
    fn check_keys(&self, values: &Values) -> Result<HashMap<VariableId, State>, GraphError> {
        let mut states = HashMap::new();
        for set in &self.sets {
            if let Some(&kernel) = set.kernels().iter().find(|kernel| !kernel.is_valid()) {
                return Err(GraphError::InvalidKernel { kernel });
            }
            for (place, (kind, &name)) in set.kinds().into_iter().zip(set.kind_names()).enumerate() {
                let state_of = values.states(kind);
                for slot in (0..set.len()).map(|factor| set.slots(factor)[place]) {
                    match state_of(slot) {
                        Some(State::Finite) => {}
                        Some(state) => drop(states.insert(VariableId { kind, slot }, state)),
                        None => return Err(GraphError::ForeignKey { kind: name, number: slot }),
                    }
                }
            }
        }
        Ok(states)
    }

    /// The first factor whose cost is not a finite number, where their sum is not.
    fn first_not_finite(&self, values: &Values, cost: f64) -> Option<FactorName> {
        if cost.is_finite() {
            return None;
        }
        let bad = |id: &FactorId| {
            let index = id.index as usize;
            !self.sets[id.set as usize].cost(values, index..index + 1).is_finite()
        };
        self.ids().find(bad).and_then(|id| self.name(id, values))
    }
}
