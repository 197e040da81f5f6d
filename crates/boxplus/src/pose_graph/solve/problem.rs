//! From a pose graph to factors and variables, and back.

use nalgebra::{DMatrix, SMatrix};

use super::indefinite::{Indefinite, mend, symmetric, translations};
use super::keys::{End, Keys, declare, insert};
use super::{ChartKind, PoseGraphError, SolveSettings};
use crate::graph::{
    Bearing2, Between, Chart, Chordal, Difference, Factor, FactorId, G2o, Graph, GraphError, GroupVariable,
    Key, Located, Log, Noise, Prior, Range, Sighting2, Sighting3, Values, Variable, VariableId, Variables,
    isotropic_information,
};
use crate::lie::{LieGroup, Rn, SE2, SE3};
use crate::pose_graph::{Edge, Fault, Line, PoseGraph, Severity, Vertex, VertexKind};

/// The factor graph of a pose graph.
pub(in crate::pose_graph) struct Problem {
    pub(in crate::pose_graph) factors: Graph,
    pub(in crate::pose_graph) values: Values,
    keys: Keys,
    /// The factor of each measurement, in the order of [`PoseGraph::constraints`]; none where it was left out.
    pub(super) ids: Vec<Option<FactorId>>,
    /// Measurements whose information was mended or that were left out.
    pub(super) mended: Vec<Line>,
}

impl Problem {
    pub(in crate::pose_graph) fn new(
        graph: &PoseGraph,
        settings: &SolveSettings,
    ) -> Result<Self, PoseGraphError> {
        let mut builder = Builder::new(graph, settings);
        builder.insert_vertices();
        if builder.values.is_empty() {
            return Err(PoseGraphError::Empty);
        }
        if let Some(id) = builder.keys.ambiguous() {
            return Err(PoseGraphError::AmbiguousVertex { id });
        }
        builder.hold_fixed()?;
        if builder.add_factors().is_some() {
            return Ok(builder.problem());
        }
        let faults = faults(graph, settings.indefinite);
        Err(match builder.refused {
            Some((line, error)) if faults.is_empty() => PoseGraphError::Measurement { line, error },
            _ => PoseGraphError::Faulty { faults },
        })
    }

    /// The variable of a vertex, and the rotation from its tangent to the world: R of a pose, I of a point.
    pub(super) fn frame(&self, id: u64) -> Option<(VariableId, DMatrix<f64>)> {
        let (keys, values) = (&self.keys, &self.values);
        let dynamic = |matrix: &[f64], size| DMatrix::from_column_slice(size, size, matrix);
        if let Some(key) = keys.pose2(id) {
            return Some((key.into(), dynamic(values.get(key)?.rotation().to_matrix().as_slice(), 2)));
        }
        if let Some(key) = keys.pose3(id) {
            return Some((key.into(), dynamic(values.get(key)?.rotation().to_matrix().as_slice(), 3)));
        }
        let point2 = keys.point2(id).map(|key| (key.into(), DMatrix::identity(2, 2)));
        point2.or_else(|| keys.point3(id).map(|key| (key.into(), DMatrix::identity(3, 3))))
    }

    /// ‖U·r‖² of every measurement, NaN where it was left out.
    pub(super) fn chi2(&self, values: &Values) -> Vec<f64> {
        let chi2 = |id: &Option<FactorId>| {
            id.and_then(|id| self.factors.squared_error(id, values)).unwrap_or(f64::NAN)
        };
        self.ids.iter().map(chi2).collect()
    }
}

/// `graph` with its vertices at `values`; vertices it did not have are added.
pub(super) fn with_values(graph: &PoseGraph, values: &Values) -> PoseGraph {
    let mut out = graph.clone();
    write(values, &mut out.poses2, |x: &SE2| *x);
    write(values, &mut out.poses3, |x: &SE3| *x);
    write(values, &mut out.points2, |x: &Rn<2>| x.vector());
    write(values, &mut out.points3, |x: &Rn<3>| x.vector());
    out
}

/// The faults that keep a graph from being solved.
pub(in crate::pose_graph) fn faults(graph: &PoseGraph, indefinite: Indefinite) -> Vec<Fault> {
    let (mut matrices, mut others): (Vec<_>, Vec<_>) =
        graph.faults().into_iter().partition(|fault| matches!(fault, Fault::Information { .. }));
    others.retain(|fault| fault.severity() == Severity::Error);
    // What was to be mended is at fault only if nothing else is: then it was beyond mending.
    if indefinite == Indefinite::Refuse || others.is_empty() {
        others.append(&mut matrices);
    }
    others
}

/// Vertices in the order of their kind; those of `values` beyond the ones given are new.
fn write<V: Variable, T>(values: &Values, vertices: &mut Vec<Vertex<T>>, value: impl Fn(&V) -> T) {
    let given = vertices.len();
    for (i, (key, x)) in values.iter::<V>().enumerate() {
        let Some(x) = x else { continue };
        match vertices.get_mut(i).filter(|_| i < given) {
            Some(vertex) => vertex.value = value(x),
            None => vertices.push(Vertex { id: values.name(key).label, value: value(x), line: Line(0) }),
        }
    }
}

struct Builder<'a> {
    graph: &'a PoseGraph,
    settings: &'a SolveSettings,
    keys: Keys,
    values: Values,
    factors: Graph,
    factor_ids: Vec<Option<FactorId>>,
    mended: Vec<Line>,
    /// The measurement that could not be used, and why.
    refused: Option<(Line, GraphError)>,
}

impl<'a> Builder<'a> {
    fn new(graph: &'a PoseGraph, settings: &'a SolveSettings) -> Self {
        let ids = graph.ids();
        let count = ids.len();
        let keys = Keys {
            ids,
            repeated: None,
            poses2: vec![None; count],
            poses3: vec![None; count],
            points2: vec![None; count],
            points3: vec![None; count],
        };
        Self {
            graph,
            settings,
            keys,
            values: Values::new(),
            factors: Graph::new(),
            factor_ids: vec![],
            mended: vec![],
            refused: None,
        }
    }

    /// The vertices of the file, or, where it has none at all, one without value for each id that is measured.
    fn insert_vertices(&mut self) {
        let Self { graph, keys, values, .. } = self;
        let Keys { ids, repeated, poses2, poses3, points2, points3 } = keys;
        let twice = [
            insert(ids, values, poses2, &graph.poses2, |value| *value),
            insert(ids, values, poses3, &graph.poses3, |value| *value),
            insert(ids, values, points2, &graph.points2, |value| Rn::new(*value)),
            insert(ids, values, points3, &graph.points3, |value| Rn::new(*value)),
        ];
        *repeated = twice.into_iter().flatten().next();
        if values.is_empty() {
            declare(ids, values, poses2, graph.edges2.iter().flat_map(|e| [e.from, e.to]));
            declare(ids, values, poses2, graph.sightings2.iter().map(|e| e.from));
            declare(ids, values, poses2, graph.bearings2.iter().map(|e| e.from));
            declare(ids, values, poses2, graph.priors2.iter().map(|p| p.id));
            declare(ids, values, poses3, graph.edges3.iter().flat_map(|e| [e.from, e.to]));
            declare(ids, values, poses3, graph.sightings3.iter().map(|e| e.from));
            declare(ids, values, poses3, graph.priors3.iter().map(|p| p.id));
            declare(ids, values, points2, graph.sightings2.iter().map(|e| e.to));
            declare(ids, values, points2, graph.bearings2.iter().map(|e| e.to));
            declare(ids, values, points2, graph.point_priors2.iter().map(|p| p.id));
            declare(ids, values, points3, graph.sightings3.iter().map(|e| e.to));
            declare(ids, values, points3, graph.point_priors3.iter().map(|p| p.id));
            let ranged = graph.ranged_points(|id| keys.end(id).map(End::kind));
            let Keys { ids, points2, points3, .. } = keys;
            let of = |kind| ranged.iter().filter(move |point| point.1 == kind).map(|point| point.0);
            declare(ids, values, points2, of(VertexKind::Point2));
            declare(ids, values, points3, of(VertexKind::Point3));
        }
    }

    /// Holds what the file or the user fixes. The file may name what it does not have; the user may not.
    fn hold_fixed(&mut self) -> Result<(), PoseGraphError> {
        for &id in &self.graph.fixed {
            self.hold(id);
        }
        match self.settings.fixed.iter().find(|&&id| !self.hold(id)) {
            Some(&id) => Err(PoseGraphError::NoSuchVertex { id }),
            None => Ok(()),
        }
    }

    fn hold(&mut self, id: u64) -> bool {
        let Keys { ids, poses2, poses3, points2, points3, .. } = &self.keys;
        let values = &mut self.values;
        let Some(i) = ids.index(id) else { return false };
        if let Some(key) = poses2[i] {
            values.hold(key);
        }
        if let Some(key) = poses3[i] {
            values.hold(key);
        }
        if let Some(key) = points2[i] {
            values.hold(key);
        }
        if let Some(key) = points3[i] {
            values.hold(key);
        }
        true
    }

    /// Adds a factor for every measurement, in the order of [`PoseGraph::constraints`]; `None` where one is faulty.
    fn add_factors(&mut self) -> Option<()> {
        match self.settings.chart {
            ChartKind::Log => self.add_edges::<Log>()?,
            ChartKind::G2o => self.add_edges::<G2o>()?,
            ChartKind::Ceres => self.add_edges::<Difference>()?,
            ChartKind::SeSync => self.add_edges::<Chordal>()?,
        }
        let graph = self.graph;
        for e in &graph.sightings2 {
            let keys = (self.keys.pose2(e.from)?, self.keys.point2(e.to)?);
            self.add(keys, Sighting2 { measured: e.measured }, (&e.information, 2), e.line)?;
        }
        for e in &graph.sightings3 {
            let keys = (self.keys.pose3(e.from)?, self.keys.point3(e.to)?);
            let factor = Sighting3 { measured: e.measured, pose_from_sensor: self.offset(e.offset)? };
            self.add(keys, factor, (&e.information, 3), e.line)?;
        }
        for e in &graph.bearings2 {
            let keys = (self.keys.pose2(e.from)?, self.keys.point2(e.to)?);
            self.add(keys, Bearing2::new(e.measured), (&e.information, 0), e.line)?;
        }
        for e in &graph.ranges {
            self.add_range(e)?;
        }
        for p in &graph.priors2 {
            let key = (self.keys.pose2(p.id)?,);
            self.add(key, Prior { mean: p.measured }, (&p.information, 2), p.line)?;
        }
        for p in &graph.priors3 {
            // The file measures the sensor, X·B ≈ Z; its error, seen from the body, is Ad_B times that of the body.
            let (key, body_from_sensor) = ((self.keys.pose3(p.id)?,), self.offset(p.offset)?);
            let mean = p.measured.compose(&body_from_sensor.inverse());
            let sensor_from_body = body_from_sensor.inverse().adjoint();
            let information = sensor_from_body.transpose() * p.information * sensor_from_body;
            self.add(key, Prior { mean }, (&symmetric(&information), 3), p.line)?;
        }
        for p in &graph.point_priors2 {
            let key = (self.keys.point2(p.id)?,);
            self.add(key, Prior { mean: Rn::new(p.measured) }, (&p.information, 2), p.line)?;
        }
        for p in &graph.point_priors3 {
            let key = (self.keys.point3(p.id)?,);
            self.add(key, Prior { mean: Rn::new(p.measured) }, (&p.information, 3), p.line)?;
        }
        Some(())
    }

    fn add_range(&mut self, e: &Edge<f64, 1>) -> Option<()> {
        match (self.keys.end(e.from)?, self.keys.end(e.to)?) {
            (End::Pose2(a), End::Point2(b)) => self.add_distance::<_, _, 2>((a, b), e),
            (End::Pose2(a), End::Pose2(b)) => self.add_distance::<_, _, 2>((a, b), e),
            (End::Point2(a), End::Pose2(b)) => self.add_distance::<_, _, 2>((a, b), e),
            (End::Point2(a), End::Point2(b)) => self.add_distance::<_, _, 2>((a, b), e),
            (End::Pose3(a), End::Point3(b)) => self.add_distance::<_, _, 3>((a, b), e),
            (End::Pose3(a), End::Pose3(b)) => self.add_distance::<_, _, 3>((a, b), e),
            (End::Point3(a), End::Pose3(b)) => self.add_distance::<_, _, 3>((a, b), e),
            (End::Point3(a), End::Point3(b)) => self.add_distance::<_, _, 3>((a, b), e),
            _ => None, // one in the plane and one in space
        }
    }

    fn add_distance<A: Located<N>, B: Located<N>, const N: usize>(
        &mut self,
        keys: (Key<A>, Key<B>),
        e: &Edge<f64, 1>,
    ) -> Option<()> {
        self.add(keys, Range::<A, B, N>::new(e.measured), (&e.information, 1), e.line)
    }

    fn add_edges<C: Chart<SE2, 3> + Chart<SE3, 6>>(&mut self) -> Option<()> {
        let graph = self.graph;
        for e in &graph.edges2 {
            let keys = (self.keys.pose2(e.from)?, self.keys.pose2(e.to)?);
            self.add_edge::<SE2, C, 3>(keys, e.measured, &e.information, e.line)?;
        }
        for e in &graph.edges3 {
            let keys = (self.keys.pose3(e.from)?, self.keys.pose3(e.to)?);
            self.add_edge::<SE3, C, 6>(keys, e.measured, &e.information, e.line)?;
        }
        Some(())
    }

    fn add_edge<P: GroupVariable<D>, C: Chart<P, D>, const D: usize>(
        &mut self,
        keys: (Key<P>, Key<P>),
        measured: P,
        information: &SMatrix<f64, D, D>,
        line: Line,
    ) -> Option<()> {
        let mut noise = self.noise(information, translations::<D>(), line).ok()?;
        if let (ChartKind::SeSync, Some(full)) = (self.settings.chart, noise) {
            noise = Some(Noise::from_information(&isotropic_information(&full.information())?).ok()?);
        }
        self.push(keys, Between::<P, C>::in_chart(measured), noise);
        Some(())
    }

    fn add<F: Factor<R>, const R: usize>(
        &mut self,
        keys: <F::Variables as Variables>::Keys,
        factor: F,
        (information, split): (&SMatrix<f64, R, R>, usize),
        line: Line,
    ) -> Option<()> {
        let noise = self.noise(information, split, line).ok()?;
        self.push(keys, factor, noise);
        Some(())
    }

    /// The noise of a measurement whose first `split` coordinates are a translation, mended as the settings say; `None` where it is to be left out.
    ///
    /// # Errors
    /// What is beyond mending; it is kept for the report.
    fn noise<const R: usize>(
        &mut self,
        information: &SMatrix<f64, R, R>,
        split: usize,
        line: Line,
    ) -> Result<Option<Noise<R>>, GraphError> {
        let error = match Noise::from_information(information) {
            Ok(noise) => return Ok(Some(noise)),
            Err(error) => error,
        };
        self.mended.push(line);
        let mended = match self.settings.indefinite {
            Indefinite::Skip => return Ok(None),
            Indefinite::Refuse => None,
            policy => {
                mend(information, split, policy).and_then(|mended| Noise::from_information(&mended).ok())
            }
        };
        mended.map(Some).ok_or_else(|| {
            self.refused = Some((line, error.clone()));
            error
        })
    }

    fn push<F: Factor<R>, const R: usize>(
        &mut self,
        keys: <F::Variables as Variables>::Keys,
        factor: F,
        noise: Option<Noise<R>>,
    ) {
        let id = noise.map(|noise| self.factors.add_robust(keys, factor, noise, self.settings.kernel));
        self.factor_ids.push(id);
    }

    fn offset(&self, id: u64) -> Option<SE3> {
        self.graph.offsets3.iter().find(|offset| offset.id == id).map(|offset| offset.value)
    }

    fn problem(self) -> Problem {
        let Self { keys, values, factors, factor_ids, mended, .. } = self;
        Problem { factors, values, keys, ids: factor_ids, mended }
    }
}
