//! Pose graphs: from arrays and files, to their optimum.
#![allow(clippy::needless_pass_by_value)] // Arguments of Python are handed over.

use crate::error::{GraphError, ReadError, ShapeError};
use crate::slot::{Element, Matrix, Slot, rows};
use crate::solve::{choice, initial, iteration_dict, named, observed, set_option};
use boxplus::graph::{GraduatedLoss, Graduation, Iteration};
use boxplus::io;
use boxplus::lie::{SE2, SE3};
use boxplus::pose_graph::solve::{Progress, solve_observed};
use boxplus::pose_graph::{
    Edge, Indefinite, Line, PoseGraph as Graph, PoseGraphError, SolveSettings, Solved, Vertex,
};
use numpy::{IxDyn, PyArray1, PyArrayDyn, PyArrayMethods, PyReadonlyArray1};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use std::ops::ControlFlow;

type Pose2 = Element<SE2, 4>;
type Pose3 = Element<SE3, 7>;
type Numbers<'py> = Bound<'py, PyArrayDyn<f64>>;
type Ids<'py> = Bound<'py, PyArray1<u64>>;

/// A pose graph in the memory of the library.
#[pyclass(module = "boxplus._core")]
pub(crate) struct PoseGraph(Graph);

#[pymethods]
impl PoseGraph {
    #[new]
    fn new() -> Self {
        Self(Graph::default())
    }

    /// The graph of a file's bytes, and its format.
    #[staticmethod]
    fn parse(
        py: Python<'_>,
        content: &[u8],
        name: &str,
        format: Option<&str>,
    ) -> PyResult<(Self, &'static str)> {
        let format = format.map(choice::<io::Format>).transpose()?;
        let parsed = py
            .detach(|| io::read(content, name, format))
            .map_err(|error| ReadError::new_err(error.to_string()))?;
        Ok((Self(parsed.graph), parsed.format.name()))
    }

    /// The text of a file in this format.
    fn print(&self, py: Python<'_>, format: &str) -> PyResult<String> {
        let format = choice::<io::Format>(format)?;
        py.detach(|| io::write(&self.0, format)).map_err(|error| GraphError::new_err(error.to_string()))
    }

    fn copy(&self) -> Self {
        Self(self.0.clone())
    }

    /// What is in the graph, for people.
    fn counts(&self) -> (usize, usize, usize, usize, usize) {
        let Graph { poses2, poses3, points2, points3, .. } = &self.0;
        (
            poses2.len(),
            poses3.len(),
            points2.len() + points3.len(),
            self.0.constraints().count(),
            self.0.fixed.len(),
        )
    }

    /// Whether anything is in the plane, and whether anything is in space, of poses and edges.
    fn dimensions(&self) -> (bool, bool) {
        let Graph { poses2, poses3, edges2, edges3, .. } = &self.0;
        (!(poses2.is_empty() && edges2.is_empty()), !(poses3.is_empty() && edges3.is_empty()))
    }

    fn add_poses(
        &mut self,
        planar: bool,
        ids: PyReadonlyArray1<'_, u64>,
        poses: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        if planar {
            self.0.poses2.extend(vertices::<Pose2>(&ids, poses)?);
        } else {
            self.0.poses3.extend(vertices::<Pose3>(&ids, poses)?);
        }
        Ok(())
    }

    fn add_edges(
        &mut self,
        planar: bool,
        from_: PyReadonlyArray1<'_, u64>,
        to: PyReadonlyArray1<'_, u64>,
        measured: &Bound<'_, PyAny>,
        information: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        if planar {
            self.0.edges2.extend(edges::<Pose2, 3>(&from_, &to, measured, information)?);
        } else {
            self.0.edges3.extend(edges::<Pose3, 6>(&from_, &to, measured, information)?);
        }
        Ok(())
    }

    fn fix(&mut self, ids: PyReadonlyArray1<'_, u64>) -> PyResult<()> {
        self.0.fixed.extend_from_slice(ids.as_slice()?);
        Ok(())
    }

    fn poses<'py>(&self, py: Python<'py>, planar: bool) -> PyResult<(Ids<'py>, Numbers<'py>)> {
        if planar {
            vertex_arrays::<Pose2>(py, &self.0.poses2)
        } else {
            vertex_arrays::<Pose3>(py, &self.0.poses3)
        }
    }

    fn edges<'py>(
        &self,
        py: Python<'py>,
        planar: bool,
    ) -> PyResult<(Ids<'py>, Ids<'py>, Numbers<'py>, Numbers<'py>)> {
        if planar {
            edge_arrays::<Pose2, 3>(py, &self.0.edges2)
        } else {
            edge_arrays::<Pose3, 6>(py, &self.0.edges3)
        }
    }

    fn fixed<'py>(&self, py: Python<'py>) -> Ids<'py> {
        PyArray1::from_slice(py, &self.0.fixed)
    }

    /// The optimum under `settings`, a dictionary of the keywords of the package's `solve`; `progress` is called with every step
    /// and may stop the search by returning False.
    fn solve<'py>(
        &self,
        py: Python<'py>,
        settings: &Bound<'py, PyDict>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(Self, Bound<'py, PyDict>)> {
        let settings = self::settings(settings)?;
        let mut raised = None;
        let mut observe =
            |step: Progress<'_>| match Python::attach(|py| observed(py, progress.as_ref(), made(&step))) {
                Ok(flow) => flow,
                Err(error) => {
                    raised = Some(error);
                    ControlFlow::Break(())
                }
            };
        let solved = py
            .detach(|| solve_observed(&self.0, &settings, &mut observe))
            .map_err(|error| refused(&error))?;
        match raised {
            Some(error) if !error.is_instance_of::<PyKeyboardInterrupt>(py) => Err(error),
            _ => {
                let report = report(py, &solved)?;
                Ok((Self(solved.graph), report))
            }
        }
    }

    /// χ² of every measurement at the poses that the graph holds.
    fn chi2<'py>(
        &self,
        py: Python<'py>,
        settings: &Bound<'py, PyDict>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let settings = self::settings(settings)?;
        let chi2 = py.detach(|| self.0.chi2(&settings)).map_err(|error| refused(&error))?;
        Ok(PyArray1::from_vec(py, chi2))
    }

    /// The ids whose positions are determined, and their covariances in the world frame, (N, 3, 3).
    fn position_covariances<'py>(
        &self,
        py: Python<'py>,
        ids: PyReadonlyArray1<'py, u64>,
        settings: &Bound<'py, PyDict>,
    ) -> PyResult<(Ids<'py>, Numbers<'py>)> {
        let settings = self::settings(settings)?;
        let ids = ids.as_slice()?;
        let found =
            py.detach(|| self.0.position_covariances(ids, &settings)).map_err(|error| refused(&error))?;
        let ids = PyArray1::from_iter(py, found.iter().map(|position| position.id));
        Ok((ids, array::<Matrix<3, 3>>(py, found.iter().map(|position| &position.covariance))?))
    }
}

/// The keywords of `solve` as settings of the library.
fn settings(keywords: &Bound<'_, PyDict>) -> PyResult<SolveSettings> {
    let mut settings = SolveSettings::default();
    for (key, value) in keywords {
        let key: String = key.extract()?;
        match key.as_str() {
            "chart" => settings.chart = choice(value.extract()?)?,
            "initial" => settings.initial = initial(&value)?,
            "robust" => {
                let graduation = |loss| Graduation { loss, scale: None };
                match value.extract()? {
                    "gnc-tls" => settings.graduation = Some(graduation(GraduatedLoss::TruncatedLeastSquares)),
                    "gnc-gm" => settings.graduation = Some(graduation(GraduatedLoss::GemanMcClure)),
                    kernel => settings.kernel = choice(kernel)?,
                }
            }
            "indefinite" => {
                let choices = [
                    ("refuse", Indefinite::Refuse),
                    ("clamp", Indefinite::Clamp),
                    ("isotropic", Indefinite::Isotropic),
                    ("skip", Indefinite::Skip),
                ];
                settings.indefinite = named("indefinite", &value, &choices)?;
            }
            "fixed" => settings.fixed = value.extract()?,
            key => set_option(&mut settings.options, key, &value)?,
        }
    }
    Ok(settings)
}

/// The trial step that was made, if it is one.
fn made<'a>(progress: &Progress<'a>) -> Option<&'a Iteration> {
    match progress {
        Progress::Iteration(iteration) => Some(iteration),
        _ => None,
    }
}

/// How the solve went, as a dictionary.
fn report<'py>(py: Python<'py>, solved: &Solved) -> PyResult<Bound<'py, PyDict>> {
    let told = PyDict::new(py);
    let report = &solved.report;
    let costs = &solved.costs;
    told.set_item("cost", solved.cost)?;
    told.set_item("initial_cost", solved.initial_cost)?;
    told.set_item("converged", report.converged())?;
    told.set_item("termination", report.termination.name())?;
    told.set_item("initialisation", solved.initialisation.name())?;
    told.set_item(
        "costs",
        [("log", costs.log), ("g2o", costs.g2o), ("se_sync", costs.se_sync), ("ceres", costs.ceres)]
            .into_py_dict(py)?,
    )?;
    let iterations = report.iterations.iter().map(|iteration| iteration_dict(py, iteration));
    told.set_item("iterations", iterations.collect::<PyResult<Vec<_>>>()?)?;
    told.set_item("held", report.gauge.iter().map(ToString::to_string).collect::<Vec<_>>())?;
    told.set_item("unconstrained", solved.unconstrained.as_ref().map(ToString::to_string))?;
    told.set_item("parts", solved.parts)?;
    told.set_item("unknowns", report.unknowns)?;
    told.set_item("rejected", PyArray1::from_slice(py, &solved.rejected))?;
    told.set_item("chi2", PyArray1::from_slice(py, &solved.chi2))?;
    let seconds = &solved.seconds;
    told.set_item(
        "seconds",
        [("build", seconds.build), ("initialise", seconds.initialise), ("optimise", seconds.optimise)]
            .into_py_dict(py)?,
    )?;
    Ok(told)
}

fn refused(error: &PoseGraphError) -> PyErr {
    let mut lines = vec![error.to_string()];
    if let PoseGraphError::Faulty { faults } = error {
        lines.extend(faults.iter().skip(1).take(9).map(ToString::to_string));
    }
    GraphError::new_err(lines.join("\n"))
}

fn vertices<S: Slot>(
    ids: &PyReadonlyArray1<'_, u64>,
    values: &Bound<'_, PyAny>,
) -> PyResult<Vec<Vertex<S::Value>>> {
    let ids = ids.as_slice()?;
    let values = rows::<S>(values, "poses", ids.len())?;
    Ok(ids.iter().zip(values).map(|(&id, value)| Vertex { id, value, line: Line(0) }).collect())
}

fn edges<S: Slot, const D: usize>(
    from: &PyReadonlyArray1<'_, u64>,
    to: &PyReadonlyArray1<'_, u64>,
    measured: &Bound<'_, PyAny>,
    information: &Bound<'_, PyAny>,
) -> PyResult<Vec<Edge<S::Value, D>>> {
    let (from, to) = (from.as_slice()?, to.as_slice()?);
    if from.len() != to.len() {
        return Err(ShapeError::new_err(format!("{} edges start, but {} end", from.len(), to.len())));
    }
    let measured = rows::<S>(measured, "measured", from.len())?;
    let information = rows::<Matrix<D, D>>(information, "information", from.len())?;
    let ends = from.iter().zip(to).zip(measured.into_iter().zip(information));
    Ok(ends
        .map(|((&from, &to), (measured, information))| Edge {
            from,
            to,
            measured,
            information,
            line: Line(0),
        })
        .collect())
}

fn array<'py, 'a, S: Slot>(
    py: Python<'py>,
    values: impl Iterator<Item = &'a S::Value>,
) -> PyResult<Numbers<'py>>
where
    S::Value: 'a,
{
    let mut numbers = Vec::new();
    let mut count = 0;
    for value in values {
        let start = numbers.len();
        numbers.resize(start + S::LEN, 0.0);
        S::write(value, &mut numbers[start..]);
        count += 1;
    }
    let shape: Vec<usize> = [count].iter().chain(S::SHAPE).copied().collect();
    PyArray1::from_vec(py, numbers).reshape(IxDyn(&shape))
}

fn vertex_arrays<'py, S: Slot>(
    py: Python<'py>,
    vertices: &[Vertex<S::Value>],
) -> PyResult<(Ids<'py>, Numbers<'py>)> {
    let ids = PyArray1::from_iter(py, vertices.iter().map(|vertex| vertex.id));
    Ok((ids, array::<S>(py, vertices.iter().map(|vertex| &vertex.value))?))
}

fn edge_arrays<'py, S: Slot, const D: usize>(
    py: Python<'py>,
    edges: &[Edge<S::Value, D>],
) -> PyResult<(Ids<'py>, Ids<'py>, Numbers<'py>, Numbers<'py>)> {
    Ok((
        PyArray1::from_iter(py, edges.iter().map(|edge| edge.from)),
        PyArray1::from_iter(py, edges.iter().map(|edge| edge.to)),
        array::<S>(py, edges.iter().map(|edge| &edge.measured))?,
        array::<Matrix<D, D>>(py, edges.iter().map(|edge| &edge.information))?,
    ))
}
