//! apex-solver, with its own reader, between factors, whitening by Ω and observers.

use std::{
    error::Error,
    sync::{Arc, Mutex, PoisonError},
};

use apex_solver::{
    JacobianMode, NoiseModel,
    apex_io::{G2oLoader, GraphLoader},
    apex_manifolds::ManifoldType,
    core::{VarKey, problem::Problem, variable::ManifoldVariable},
    factors::pose::{BetweenFactor, PriorFactor},
    optimizer::{
        DogLeg, GaussNewton, LevenbergMarquardt, OptObserver, OptimizationStatus, OptimizeResult,
        dog_leg::DogLegConfig, gauss_newton::GaussNewtonConfig, levenberg_marquardt::LevenbergMarquardtConfig,
    },
};
use boxplus_peers::{Arguments, Recorder, guarded};
use nalgebra::{DMatrix, dvector};
use slotmap::SlotMap;

type Variables = SlotMap<VarKey, Box<dyn ManifoldVariable>>;
type Shared = Arc<Mutex<Recorder>>;

struct Observer {
    keys: Vec<VarKey>,
    recorder: Shared,
}

impl OptObserver for Observer {
    fn on_step(&self, variables: &Variables, iteration: usize) {
        let mut recorder = self.recorder.lock().unwrap_or_else(PoisonError::into_inner);
        recorder.observe(iteration + 1, coordinates(&self.keys, variables));
    }
}

/// x y θ or x y z qx qy qz qw of each pose; apex-solver keeps w first.
fn coordinates(keys: &[VarKey], variables: &Variables) -> Vec<f64> {
    keys.iter()
        .flat_map(|&key| match variables[key].to_dvector().as_slice() {
            &[x, y, z, qw, qx, qy, qz] => vec![x, y, z, qx, qy, qz, qw],
            other => other.to_vec(),
        })
        .collect()
}

/// A problem, its variables in the order of their ids, and their coordinates at the start.
type Start = (Problem, Vec<VarKey>, Vec<f64>);

/// Levenberg-Marquardt holds the first pose; the other two get a prior there, as in apex-solver's own program for
/// pose graphs.
fn build(arguments: &Arguments) -> Result<Start, Box<dyn Error>> {
    let graph = G2oLoader::load(&arguments.graph)?;
    let mut problem = Problem::new(JacobianMode::Sparse);
    let hold = arguments.method == "lm";
    let (mut keys, mut start) = (Vec::new(), Vec::new());
    for id in 0..graph.vertices_se2.len() {
        let pose = &graph.vertices_se2[&id].pose;
        start.extend([pose.x(), pose.y(), pose.angle()]);
        keys.push(problem.add_variable(ManifoldType::SE2, dvector![pose.x(), pose.y(), pose.angle()]));
        if id == 0 && !hold {
            problem.add_residual_block(&keys, Box::new(PriorFactor::new(pose.clone())), None);
        }
    }
    for id in 0..graph.vertices_se3.len() {
        let pose = &graph.vertices_se3[&id].pose;
        let (t, q) = (pose.translation(), pose.rotation_quaternion());
        start.extend([t.x, t.y, t.z, q.i, q.j, q.k, q.w]);
        keys.push(problem.add_variable(ManifoldType::SE3, dvector![t.x, t.y, t.z, q.w, q.i, q.j, q.k]));
        if id == 0 && !hold {
            problem.add_residual_block(&keys, Box::new(PriorFactor::new(pose.clone())), None);
        }
    }
    if hold {
        let freedoms = if graph.vertices_se3.is_empty() { 3 } else { 6 };
        (0..freedoms).for_each(|index| problem.fix_variable(keys[0], index));
    }
    for edge in graph.edges_se2 {
        let noise = NoiseModel::from_information(DMatrix::from_column_slice(3, 3, edge.information.as_slice()))?;
        let factor = Box::new(BetweenFactor::new(edge.measurement));
        problem.add_residual_block_with_noise(&[keys[edge.from], keys[edge.to]], factor, None, noise);
    }
    for edge in graph.edges_se3 {
        let noise = NoiseModel::from_information(DMatrix::from_column_slice(6, 6, edge.information.as_slice()))?;
        let factor = Box::new(BetweenFactor::new(edge.measurement));
        problem.add_residual_block_with_noise(&[keys[edge.from], keys[edge.to]], factor, None, noise);
    }
    Ok((problem, keys, start))
}

fn optimize(arguments: &Arguments, problem: &mut Problem, observer: Observer) -> Result<OptimizeResult, String> {
    let limit = arguments.max_iterations;
    match arguments.method.as_str() {
        "lm" => {
            let mut config = LevenbergMarquardtConfig::new();
            config.max_iterations = limit.unwrap_or(config.max_iterations);
            let mut solver = LevenbergMarquardt::with_config(config);
            solver.add_observer(observer);
            guarded(|| solver.optimize(problem))
        }
        "gn" => {
            let mut config = GaussNewtonConfig::new();
            config.max_iterations = limit.unwrap_or(config.max_iterations);
            let mut solver = GaussNewton::with_config(config);
            solver.add_observer(observer);
            guarded(|| solver.optimize(problem))
        }
        "dogleg" => {
            let mut config = DogLegConfig::new();
            config.max_iterations = limit.unwrap_or(config.max_iterations);
            let mut solver = DogLeg::with_config(config);
            solver.add_observer(observer);
            guarded(|| solver.optimize(problem))
        }
        other => Err(format!("unknown method {other}")),
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse()?;
    let (mut problem, keys, start) = build(&arguments)?;
    let recorder = Shared::default();
    let lock = || recorder.lock().unwrap_or_else(PoisonError::into_inner);
    lock().keep(0, start);
    let observer = Observer { keys, recorder: Arc::clone(&recorder) };
    lock().start();
    let outcome = optimize(&arguments, &mut problem, observer);
    lock().stop();
    let status = match outcome {
        Ok(Ok(result)) => match result.status {
            OptimizationStatus::MaxIterationsReached => "max_iterations".into(),
            OptimizationStatus::Converged
            | OptimizationStatus::CostToleranceReached
            | OptimizationStatus::GradientToleranceReached
            | OptimizationStatus::ParameterToleranceReached => "converged".into(),
            other => format!("error: {other}"),
        },
        Ok(Err(error)) => format!("error: {error}"),
        Err(panic) => panic,
    };
    lock().report(&status, &arguments.poses)?;
    Ok(())
}
