//! Factor graphs: variables and factors from arrays, to the estimate that fits best.
#![allow(clippy::needless_pass_by_value)] // Arguments of Python are handed over.

use crate::argument::Argument;
use crate::error::{GraphError, ShapeError};
use crate::estimate::{Estimate, Marginals, report};
use crate::kinds::{R1, R2, R3, R4, R5, R6, of_group};
use crate::slot::{Element, Matrix, Scalar, Slot, Vector, rows};
use crate::solve::{choice, initial, observed, set_option};
use crate::user_factor::{Column, Raised, UserFactors};
use boxplus::graph::{
    Bearing2, Bearing3, Between, Factor, FactorId, Graph, GroupVariable, Initial, Kernel, Key, Located,
    Noise, Prior, Range, Sighting2, Sighting3, SolveOptions, Values, Variables,
};
use boxplus::lie::{Plain, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3};
use bytemuck::TransparentWrapper;
use nalgebra::{SVector, Unit};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::{PyIndexError, PyKeyboardInterrupt, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::ops::ControlFlow;

/// Numbers of variables among those of their kind.
pub(crate) type Numbers<'py> = PyReadonlyArray1<'py, u32>;
/// How sure measurements are: `"sigmas"`, `"information"` or `"covariance"`, the array, and the name of a robust kernel.
type Certainty<'py> = (String, Bound<'py, PyAny>, String);
/// Places of factors, in the order of their addition.
type Places = (usize, usize);

/// A group with stored numbers that a graph can estimate.
pub(crate) trait Estimated<const D: usize, const N: usize>:
    GroupVariable<D> + Plain<N, Number = f64> + TransparentWrapper<[f64; N]>
{
}
impl<G, const D: usize, const N: usize> Estimated<D, N> for G where
    G: GroupVariable<D> + Plain<N, Number = f64> + TransparentWrapper<[f64; N]>
{
}

/// Variables and factors in the memory of the library.
#[pyclass(module = "boxplus._core")]
pub(crate) struct FactorGraph {
    graph: Graph,
    values: Values,
    /// In the order of their addition.
    factors: Vec<FactorId>,
    raised: Raised,
}

#[pymethods]
impl FactorGraph {
    #[new]
    fn new() -> Self {
        Self { graph: Graph::new(), values: Values::new(), factors: vec![], raised: Raised::default() }
    }

    /// How many variables and factors there are.
    fn counts(&self) -> (usize, usize) {
        (self.values.total(), self.factors.len())
    }

    /// Adds variables with first estimates `numbers`, (N, ...), and returns the number of the first.
    fn add_variables(&mut self, kind: &str, numbers: &Bound<'_, PyAny>) -> PyResult<usize> {
        of_group!(kind, insert(&mut self.values, numbers))
    }

    /// Adds variables without values.
    fn declare(&mut self, kind: &str, count: usize) -> PyResult<usize> {
        of_group!(kind, declare(&mut self.values, count))
    }

    /// Holds variables where they are, or lets go of them.
    fn hold(&mut self, kind: &str, numbers: Numbers<'_>, held: bool) -> PyResult<()> {
        of_group!(kind, hold(&mut self.values, numbers.as_slice()?, held))
    }

    fn add_priors(
        &mut self,
        kind: &str,
        x: Numbers<'_>,
        mean: &Bound<'_, PyAny>,
        certainty: Certainty<'_>,
    ) -> PyResult<Places> {
        of_group!(kind, priors(self, x.as_slice()?, mean, &certainty))
    }

    fn add_displacements(
        &mut self,
        kind: &str,
        a: Numbers<'_>,
        b: Numbers<'_>,
        measured: &Bound<'_, PyAny>,
        certainty: Certainty<'_>,
    ) -> PyResult<Places> {
        of_group!(kind, displacements(self, (a.as_slice()?, b.as_slice()?), measured, &certainty))
    }

    fn add_sightings(
        &mut self,
        planar: bool,
        poses: Numbers<'_>,
        points: Numbers<'_>,
        seen: &Bound<'_, PyAny>,
        certainty: Certainty<'_>,
    ) -> PyResult<Places> {
        let ends = (poses.as_slice()?, points.as_slice()?);
        if planar {
            self.pairs::<Vector<2>, _, SE2, R2, 2>(ends, seen, &certainty, |measured| Sighting2 { measured })
        } else {
            self.pairs::<Vector<3>, _, SE3, R3, 3>(ends, seen, &certainty, Sighting3::new)
        }
    }

    fn add_bearings(
        &mut self,
        planar: bool,
        poses: Numbers<'_>,
        points: Numbers<'_>,
        measured: &Bound<'_, PyAny>,
        certainty: Certainty<'_>,
    ) -> PyResult<Places> {
        let ends = (poses.as_slice()?, points.as_slice()?);
        if planar {
            self.pairs::<Scalar, _, SE2, R2, 1>(ends, measured, &certainty, Bearing2::new)
        } else {
            let direction = |v| Bearing3::new(&Unit::new_normalize(v));
            self.pairs::<Vector<3>, _, SE3, R3, 2>(ends, measured, &certainty, direction)
        }
    }

    fn add_ranges(
        &mut self,
        kinds: (String, String),
        a: Numbers<'_>,
        b: Numbers<'_>,
        measured: &Bound<'_, PyAny>,
        certainty: Certainty<'_>,
    ) -> PyResult<Places> {
        let ends = (a.as_slice()?, b.as_slice()?);
        match (kinds.0.as_str(), kinds.1.as_str()) {
            ("SE2", "R2") => self.ranges::<SE2, R2, 2>(ends, measured, &certainty),
            ("SE2", "SE2") => self.ranges::<SE2, SE2, 2>(ends, measured, &certainty),
            ("R2", "R2") => self.ranges::<R2, R2, 2>(ends, measured, &certainty),
            ("SE3", "R3") => self.ranges::<SE3, R3, 3>(ends, measured, &certainty),
            ("SE3", "SE3") => self.ranges::<SE3, SE3, 3>(ends, measured, &certainty),
            ("R3", "R3") => self.ranges::<R3, R3, 3>(ends, measured, &certainty),
            (a, b) => Err(PyTypeError::new_err(format!(
                "a distance is between poses and points of the plane or of space, not {a} and {b}"
            ))),
        }
    }

    /// Adds factors whose residuals of `dimension` numbers Python computes, many at a time: see [`UserFactors`].
    fn add_user_factors(
        &mut self,
        variables: Vec<(String, Numbers<'_>)>,
        dimension: usize,
        function: Py<PyAny>,
        relative: bool,
        certainty: Certainty<'_>,
    ) -> PyResult<Places> {
        let columns = (variables.iter())
            .map(|(kind, numbers)| of_group!(kind.as_str(), column(&self.values, numbers.as_slice()?)))
            .collect::<PyResult<Vec<_>>>()?;
        let factors = UserFactors { columns, function, relative, raised: self.raised.clone() };
        match dimension {
            1 => self.user_factors::<1>(factors, &certainty),
            2 => self.user_factors::<2>(factors, &certainty),
            3 => self.user_factors::<3>(factors, &certainty),
            4 => self.user_factors::<4>(factors, &certainty),
            5 => self.user_factors::<5>(factors, &certainty),
            6 => self.user_factors::<6>(factors, &certainty),
            7 => self.user_factors::<7>(factors, &certainty),
            8 => self.user_factors::<8>(factors, &certainty),
            9 => self.user_factors::<9>(factors, &certainty),
            _ => Err(PyValueError::new_err(format!("a residual has 1 to 9 numbers, not {dimension}"))),
        }
    }

    /// The first estimates.
    fn initial(&self) -> Estimate {
        Estimate(self.values.clone())
    }

    /// The estimate of least cost under `settings`, a dictionary of keywords, and how it was found; `progress` is called with every
    /// step and may stop the search by returning False.
    fn solve<'py>(
        &self,
        py: Python<'py>,
        settings: &Bound<'py, PyDict>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(Estimate, Bound<'py, PyDict>)> {
        let (mut options, mut start) = (SolveOptions::default(), Initial::Auto);
        for (key, value) in settings {
            match key.extract::<String>()?.as_str() {
                "initial" => start = initial(&value)?,
                key => set_option(&mut options, key, &value)?,
            }
        }
        let mut observe = |step: &_| match Python::attach(|py| observed(py, progress.as_ref(), Some(step))) {
            Ok(flow) if !self.raised.is_set() => flow,
            Ok(_) => ControlFlow::Break(()),
            Err(error) => {
                self.raised.set(error);
                ControlFlow::Break(())
            }
        };
        let solved = py.detach(|| {
            let initialised = self.graph.initialise(&self.values, start)?;
            let solution = self.graph.optimize_observed(&initialised.values, &options, &mut observe)?;
            Ok((initialised.chosen, solution))
        });
        match self.raised.take() {
            Some(error) if !(error.is_instance_of::<PyKeyboardInterrupt>(py) && solved.is_ok()) => Err(error),
            _ => {
                let (chosen, solution) = solved.map_err(refused)?;
                let report = report(py, &solution, chosen)?;
                Ok((Estimate(solution.values), report))
            }
        }
    }

    /// ½ Σ ρ(‖U·r‖²) at an estimate.
    fn cost(&self, py: Python<'_>, estimate: &Estimate) -> PyResult<f64> {
        let cost = py.detach(|| self.graph.cost(&estimate.0));
        self.raised.take().map_or_else(|| cost.map_err(refused), Err)
    }

    /// ‖U·r‖² of factors by their places.
    fn chi2<'py>(
        &self,
        py: Python<'py>,
        estimate: &Estimate,
        places: Places,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let factors = self.factors.get(places.0..places.1).unwrap_or(&[]);
        let chi2: Vec<f64> = py.detach(|| {
            let of = |&id: &FactorId| self.graph.squared_error(id, &estimate.0).unwrap_or(f64::NAN);
            factors.iter().map(of).collect()
        });
        self.raised.take().map_or_else(|| Ok(PyArray1::from_vec(py, chi2)), Err)
    }

    /// The covariances at an estimate.
    fn marginals(&self, py: Python<'_>, estimate: &Estimate) -> PyResult<Marginals> {
        let marginals = py.detach(|| self.graph.marginals(&estimate.0));
        self.raised.take().map_or_else(|| marginals.map(Marginals).map_err(refused), Err)
    }
}

impl FactorGraph {
    /// Factors between pairs of variables, made of the rows of `measured`.
    fn pairs<S, F, A, B, const R: usize>(
        &mut self,
        (a, b): (&[u32], &[u32]),
        measured: &Bound<'_, PyAny>,
        certainty: &Certainty<'_>,
        factor: impl Fn(S::Value) -> F,
    ) -> PyResult<Places>
    where
        S: Slot,
        F: Factor<R>,
        A: boxplus::graph::Variable,
        B: boxplus::graph::Variable,
        F::Variables: Variables<Keys = (Key<A>, Key<B>)>,
    {
        if a.len() != b.len() {
            return Err(ShapeError::new_err(format!("{} factors begin, but {} end", a.len(), b.len())));
        }
        let ends = keys::<A>(&self.values, a)?.into_iter().zip(keys::<B>(&self.values, b)?);
        self.add(ends.collect(), rows::<S>(measured, "measured", a.len())?.into_iter().map(factor), certainty)
    }

    fn ranges<A: Located<N>, B: Located<N>, const N: usize>(
        &mut self,
        ends: (&[u32], &[u32]),
        measured: &Bound<'_, PyAny>,
        certainty: &Certainty<'_>,
    ) -> PyResult<Places> {
        self.pairs::<Scalar, Range<A, B, N>, A, B, 1>(ends, measured, certainty, Range::new)
    }

    fn add<F: Factor<R>, const R: usize>(
        &mut self,
        keys: Vec<<F::Variables as Variables>::Keys>,
        factors: impl Iterator<Item = F>,
        certainty: &Certainty<'_>,
    ) -> PyResult<Places> {
        let (noises, kernel) = noises::<R>(certainty, keys.len())?;
        let start = self.factors.len();
        for ((keys, factor), noise) in keys.into_iter().zip(factors).zip(noises) {
            self.factors.push(self.graph.add_robust(keys, factor, noise, kernel));
        }
        Ok((start, self.factors.len()))
    }

    fn user_factors<const R: usize>(
        &mut self,
        factors: UserFactors,
        certainty: &Certainty<'_>,
    ) -> PyResult<Places> {
        let columns: Vec<_> = factors.columns.iter().map(|column| column.ids()).collect();
        let count = columns.first().map_or(0, Vec::len);
        let (noises, kernel) = noises::<R>(certainty, count)?;
        let ids =
            self.graph.add_batch::<R>(&self.values, &columns, factors, noises, kernel).map_err(refused)?;
        let start = self.factors.len();
        self.factors.extend(ids);
        Ok((start, self.factors.len()))
    }
}

fn insert<G: Estimated<D, N>, const D: usize, const N: usize>(
    values: &mut Values,
    numbers: &Bound<'_, PyAny>,
) -> PyResult<usize> {
    let start = values.len::<G>();
    let argument = Argument::new(numbers, "values", &[N])?;
    let &[count] = argument.batch(1) else {
        return Err(ShapeError::new_err("values: expected a row of elements"));
    };
    let operand = argument.operand(&[N], N, &[count])?;
    for place in 0..count {
        values.insert(Element::<G, N>::read(operand.row(place)));
    }
    Ok(start)
}

#[allow(clippy::unnecessary_wraps)] // One of several functions that are called alike.
fn declare<G: Estimated<D, N>, const D: usize, const N: usize>(
    values: &mut Values,
    count: usize,
) -> PyResult<usize> {
    let start = values.len::<G>();
    for label in start..start + count {
        values.declare::<G>(label as u64);
    }
    Ok(start)
}

fn hold<G: Estimated<D, N>, const D: usize, const N: usize>(
    values: &mut Values,
    numbers: &[u32],
    held: bool,
) -> PyResult<()> {
    for key in keys::<G>(values, numbers)? {
        if held { values.hold(key) } else { values.release(key) }
    }
    Ok(())
}

fn priors<G: Estimated<D, N>, const D: usize, const N: usize>(
    graph: &mut FactorGraph,
    x: &[u32],
    mean: &Bound<'_, PyAny>,
    certainty: &Certainty<'_>,
) -> PyResult<Places> {
    let keys = keys::<G>(&graph.values, x)?.into_iter().map(|key| (key,)).collect();
    let means = rows::<Element<G, N>>(mean, "mean", x.len())?;
    graph.add(keys, means.into_iter().map(|mean| Prior { mean }), certainty)
}

fn displacements<G: Estimated<D, N>, const D: usize, const N: usize>(
    graph: &mut FactorGraph,
    ends: (&[u32], &[u32]),
    measured: &Bound<'_, PyAny>,
    certainty: &Certainty<'_>,
) -> PyResult<Places> {
    graph.pairs::<Element<G, N>, Between<G>, G, G, D>(ends, measured, certainty, Between::new)
}

fn column<G: Estimated<D, N>, const D: usize, const N: usize>(
    values: &Values,
    numbers: &[u32],
) -> PyResult<Box<dyn Column>> {
    Ok(Box::new(crate::user_factor::Keys::<G, D, N>(keys::<G>(values, numbers)?)))
}

/// The keys of variables of one kind.
pub(crate) fn keys<V: boxplus::graph::Variable>(values: &Values, numbers: &[u32]) -> PyResult<Vec<Key<V>>> {
    let key = |&number: &u32| {
        values
            .key(number as usize)
            .ok_or_else(|| PyIndexError::new_err(format!("the graph has no {} {number}", V::NAME)))
    };
    numbers.iter().map(key).collect()
}

/// The noise of each factor, and the kernel of all.
fn noises<const R: usize>(
    (kind, array, kernel): &Certainty<'_>,
    count: usize,
) -> PyResult<(Vec<Noise<R>>, Kernel)> {
    let noises: Vec<_> = match kind.as_str() {
        "sigmas" => {
            let rows = rows::<Vector<R>>(array, kind, count)?;
            rows.iter().map(Noise::from_sigmas as fn(&SVector<f64, R>) -> _).collect()
        }
        "covariance" => {
            rows::<Matrix<R, R>>(array, kind, count)?.iter().map(Noise::from_covariance).collect()
        }
        _ => rows::<Matrix<R, R>>(array, kind, count)?.iter().map(Noise::from_information).collect(),
    };
    let checked = noises.into_iter().enumerate().map(|(place, noise)| {
        noise.map_err(|error| GraphError::new_err(format!("{kind}[{place}]: {error}")))
    });
    Ok((checked.collect::<PyResult<_>>()?, choice(kernel)?))
}

pub(crate) fn refused(error: boxplus::graph::GraphError) -> PyErr {
    GraphError::new_err(error.to_string())
}
