//! tiny-solver, with its own SE(3) manifold and prior, and factors of ours: its own between factors take no Ω.
//!
//! The residual is g2o's, (t, θ) or (t, vec q) of Z⁻¹Xᵢ⁻¹Xⱼ, whitened; tiny-solver differentiates it.

use std::{collections::HashMap, error::Error, fs, path::Path, sync::Arc};

use boxplus_peers::{Arguments, Recorder, guarded};
use tiny_solver::{
    GaussNewtonOptimizer, LevenbergMarquardtOptimizer, Optimizer, OptimizerOptions,
    factors::{Factor, PriorFactor, na},
    manifold::se3::{SE3, SE3Manifold},
    problem::Problem,
};

type Values = HashMap<String, na::DVector<f64>>;

/// (t, θ) of Z⁻¹Xᵢ⁻¹Xⱼ on SE(2); variables are θ, x, y, as in tiny-solver's own factor.
struct Between2d {
    measured: na::Isometry2<f64>,
    sqrt_information: na::DMatrix<f64>,
}

impl<T: na::RealField> Factor<T> for Between2d {
    fn residual_func(&self, poses: &[na::DVector<T>]) -> na::DVector<T> {
        let pose = |p: &na::DVector<T>| na::Isometry2::new(na::Vector2::new(p[1].clone(), p[2].clone()), p[0].clone());
        let error = (pose(&poses[0]) * self.measured.cast::<T>()).inverse() * pose(&poses[1]);
        let t = error.translation;
        whiten(&self.sqrt_information, &[t.x.clone(), t.y.clone(), error.rotation.angle()])
    }
}

/// (t, vec q) of Z⁻¹Xᵢ⁻¹Xⱼ on SE(3), the scalar part of q positive; variables are x y z w of q, then t.
struct Between3d {
    measured: na::DVector<f64>,
    sqrt_information: na::DMatrix<f64>,
}

impl<T: na::RealField> Factor<T> for Between3d {
    fn residual_func(&self, poses: &[na::DVector<T>]) -> na::DVector<T> {
        let measured = SE3::from_vec(self.measured.as_view()).cast::<T>();
        let predicted = SE3::from_vec(poses[0].as_view()) * measured;
        let error = predicted.inverse() * SE3::from_vec(poses[1].as_view());
        let mut q = error.rot.to_vec();
        if q[3] < T::zero() {
            q = -q;
        }
        let t = error.xyz;
        whiten(
            &self.sqrt_information,
            &[t[0].clone(), t[1].clone(), t[2].clone(), q[0].clone(), q[1].clone(), q[2].clone()],
        )
    }
}

/// U·e for upper triangular U; zeros of U are skipped, since each product of dual numbers allocates.
fn whiten<T: na::RealField>(upper: &na::DMatrix<f64>, e: &[T]) -> na::DVector<T> {
    na::DVector::from_fn(e.len(), |row, _| {
        (row..e.len())
            .filter(|&column| upper[(row, column)] != 0.0)
            .map(|column| e[column].clone() * na::convert::<f64, T>(upper[(row, column)]))
            .fold(T::zero(), |sum, term| sum + term)
    })
}

fn vector<const N: usize>(numbers: [f64; N]) -> na::DVector<f64> {
    na::DVector::from_row_slice(&numbers)
}

fn name(id: &str) -> String {
    format!("x{id}")
}

/// The upper triangular U with `UᵀU` = Ω, from the upper triangle of Ω by rows.
fn sqrt_information(size: usize, upper: &[f64]) -> Result<na::DMatrix<f64>, String> {
    let mut information = na::DMatrix::zeros(size, size);
    let cells = (0..size).flat_map(|row| (row..size).map(move |column| (row, column)));
    for ((row, column), &entry) in cells.zip(upper) {
        information[(row, column)] = entry;
        information[(column, row)] = entry;
    }
    let factor = information.cholesky().ok_or("an information matrix is not positive definite")?;
    Ok(factor.l().transpose())
}

fn load(path: &Path) -> Result<(Problem, Values), Box<dyn Error>> {
    let (mut problem, mut values) = (Problem::new(), Values::new());
    for line in fs::read_to_string(path)?.lines() {
        let fields: Vec<&str> = line.split_whitespace().collect();
        let numbers =
            |from: usize| fields[from..].iter().map(|field| field.parse::<f64>()).collect::<Result<Vec<_>, _>>();
        match fields.first() {
            Some(&"VERTEX_SE2") => {
                let p = numbers(2)?;
                values.insert(name(fields[1]), vector([p[2], p[0], p[1]]));
            }
            Some(&"VERTEX_SE3:QUAT") => {
                let (p, variable) = (numbers(2)?, name(fields[1]));
                problem.set_variable_manifold(&variable, Arc::new(SE3Manifold));
                values.insert(variable, vector([p[3], p[4], p[5], p[6], p[0], p[1], p[2]]));
            }
            Some(&"EDGE_SE2") => {
                let z = numbers(3)?;
                let factor = Between2d {
                    measured: na::Isometry2::new(na::Vector2::new(z[0], z[1]), z[2]),
                    sqrt_information: sqrt_information(3, &z[3..])?,
                };
                problem.add_residual_block(3, &[&name(fields[1]), &name(fields[2])], Box::new(factor), None);
            }
            Some(&"EDGE_SE3:QUAT") => {
                let z = numbers(3)?;
                let factor = Between3d {
                    measured: vector([z[3], z[4], z[5], z[6], z[0], z[1], z[2]]),
                    sqrt_information: sqrt_information(6, &z[7..])?,
                };
                problem.add_residual_block(6, &[&name(fields[1]), &name(fields[2])], Box::new(factor), None);
            }
            _ => {}
        }
    }
    let first = name("0");
    let start = values.get(&first).ok_or("there is no vertex 0")?.clone();
    let size = start.len();
    problem.add_residual_block(size, &[&first], Box::new(PriorFactor { v: start }), None);
    Ok((problem, values))
}

/// x y θ or x y z qx qy qz qw of each pose.
fn coordinates(values: &Values) -> Vec<f64> {
    let ids = 0..values.len();
    ids.flat_map(|id| match values[&name(&id.to_string())].as_slice() {
        &[theta, x, y] => vec![x, y, theta],
        &[qx, qy, qz, qw, x, y, z] => vec![x, y, z, qx, qy, qz, qw],
        other => other.to_vec(),
    })
    .collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse()?;
    let (problem, values) = load(&arguments.graph)?;
    let optimizer: Box<dyn Optimizer> = match arguments.method.as_str() {
        "lm" => Box::new(LevenbergMarquardtOptimizer::default()),
        "gn" => Box::new(GaussNewtonOptimizer::default()),
        other => return Err(format!("unknown method {other}").into()),
    };
    let mut options = OptimizerOptions::default();
    options.max_iteration = arguments.max_iterations.unwrap_or(options.max_iteration);
    let limit = options.max_iteration;
    let mut recorder = Recorder::default();
    recorder.start();
    let outcome = guarded(|| optimizer.optimize(&problem, &values, Some(options)));
    recorder.stop();
    let status = match outcome {
        Ok(Some(result)) => {
            recorder.keep(limit, coordinates(&result));
            "finished".into()
        }
        Ok(None) => "error: the solver gave up".into(),
        Err(panic) => panic,
    };
    recorder.report(&status, &arguments.poses)?;
    Ok(())
}
