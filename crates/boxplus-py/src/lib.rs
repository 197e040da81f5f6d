//! boxplus for Python: the extension module `boxplus._core`.
//!
//! No mathematics is here. A row of an array becomes an element, a vector or a matrix ([`slot`]), an [`operation`] of the library
//! is applied to every row of arrays that broadcast, without the interpreter's lock, and its results become rows again. What a
//! person meets, classes with names, types and documentation, is Python, in `python/boxplus`.

mod argument;
mod error;
mod estimate;
mod filters;
mod gaussian;
mod graph;
mod groups;
mod kinds;
mod operation;
mod pose_graph;
mod rotation;
mod slot;
mod solve;
mod user_factor;

use pyo3::prelude::*;

/// The extension module behind the package boxplus.
#[pymodule(gil_used = false)]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    error::register(module)?;
    groups::register(module)?;
    gaussian::register(module)?;
    rotation::register(module)?;
    filters::register(module)?;
    module.add_class::<pose_graph::PoseGraph>()?;
    module.add_class::<graph::FactorGraph>()?;
    module.add_class::<estimate::Estimate>()?;
    module.add_class::<estimate::Marginals>()
}
