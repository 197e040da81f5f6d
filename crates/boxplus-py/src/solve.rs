//! What every solver takes and tells: settings by keyword, steps as dictionaries.

use boxplus::graph::{Algorithm, Initial, Iteration, SolveOptions};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict};
use std::ops::ControlFlow;
use std::str::FromStr;

/// A choice by its name.
pub(crate) fn choice<T: FromStr<Err: std::fmt::Display>>(name: &str) -> PyResult<T> {
    name.parse().map_err(|error| PyValueError::new_err(format!("{name:?} is {error}")))
}

/// A choice from a list of names.
pub(crate) fn named<T: Copy>(what: &str, value: &Bound<'_, PyAny>, choices: &[(&str, T)]) -> PyResult<T> {
    let name: String = value.extract()?;
    let found = choices.iter().find(|(known, _)| *known == name).map(|(_, choice)| *choice);
    found.ok_or_else(|| {
        let names: Vec<_> = choices.iter().map(|(name, _)| *name).collect();
        PyValueError::new_err(format!("{what} is one of {}, not {name:?}", names.join(", ")))
    })
}

/// How the first estimate is made.
pub(crate) fn initial(value: &Bound<'_, PyAny>) -> PyResult<Initial> {
    let choices = [Initial::Auto, Initial::AsGiven, Initial::SpanningTree, Initial::Chordal, Initial::Grown];
    named("initial", value, &choices.map(|choice| (choice.name(), choice)))
}

/// Sets the option of this name.
pub(crate) fn set_option(options: &mut SolveOptions, key: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
    match key {
        "algorithm" => {
            let choices = [
                ("levenberg_marquardt", Algorithm::LevenbergMarquardt),
                ("gauss_newton", Algorithm::GaussNewton),
                ("dogleg", Algorithm::Dogleg),
            ];
            options.algorithm = named(key, value, &choices)?;
        }
        "max_iterations" => options.max_iterations = value.extract()?,
        "relative_cost" => options.relative_cost = value.extract()?,
        "gradient" => options.gradient = value.extract()?,
        "step" => options.step = value.extract()?,
        "threads" => options.threads = value.extract()?,
        _ => return Err(PyValueError::new_err(format!("no setting is called {key:?}"))),
    }
    Ok(())
}

/// Tells Python of a step, and asks it whether somebody wants to stop: Ctrl-C raises, `progress` returns False.
pub(crate) fn observed(
    py: Python<'_>,
    progress: Option<&Py<PyAny>>,
    step: Option<&Iteration>,
) -> PyResult<ControlFlow<()>> {
    py.check_signals()?;
    let (Some(progress), Some(iteration)) = (progress, step) else {
        return Ok(ControlFlow::Continue(()));
    };
    let answer = progress.bind(py).call1((iteration_dict(py, iteration)?,))?;
    let stop = answer.is_instance_of::<PyBool>() && !answer.is_truthy()?;
    Ok(if stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
}

/// A step as a dictionary.
pub(crate) fn iteration_dict<'py>(py: Python<'py>, iteration: &Iteration) -> PyResult<Bound<'py, PyDict>> {
    let Iteration { cost, decrease, gain, damping, gradient, step, accepted, seconds } = iteration;
    let told = PyDict::new(py);
    let numbers = [
        ("cost", cost),
        ("decrease", decrease),
        ("gain", gain),
        ("damping", damping),
        ("gradient", gradient),
        ("step", step),
        ("seconds", seconds),
    ];
    numbers.into_iter().try_for_each(|(key, x)| told.set_item(key, x))?;
    told.set_item("accepted", accepted)?;
    Ok(told)
}
