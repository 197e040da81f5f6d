//! Answers in print: a file that can be read again, or a document for machines.

use std::fmt::Write;

use boxplus::uncertainty::{ChiSquared, Covariance, Gaussian};
use nalgebra::SVector;
use serde_json::{Value, json};

use super::args::{Convention, Operation, SideName};
use super::in_convention;
use super::space::{Space, name, rows};
use crate::error::Error;
use crate::text::significant;

/// What was computed.
pub enum Answer<G: Space<D, N>, const D: usize, const N: usize> {
    Pose(Gaussian<G, D>),
    Point(SVector<f64, N>, Covariance<N>),
}

/// How estimates fit.
#[derive(Clone, Copy, Debug)]
pub enum Fit {
    Independent { chi_squared: f64, freedom: usize, iterations: usize },
    Intersection { weight: f64 },
}

/// An answer without types.
#[derive(Debug)]
pub struct Told {
    operation: &'static str,
    operands: Vec<String>,
    order: Option<String>,
    position: Vec<f64>,
    rotation: Option<(&'static str, Vec<Vec<f64>>)>,
    degrees: Option<String>,
    coordinates: Vec<&'static str>,
    sigmas: Vec<f64>,
    covariance: Vec<Vec<f64>>,
    rank: usize,
    convention: Option<(Convention, SideName)>,
    fit: Option<Fit>,
}

impl Told {
    /// In the convention asked for.
    pub fn new<G: Space<D, N>, const D: usize, const N: usize>(
        operation: &Operation,
        operands: &[String],
        answer: &Answer<G, D, N>,
        fit: Option<Fit>,
    ) -> Result<Self, Error> {
        let options = operation.options();
        let told = Self {
            operation: operation.name(),
            operands: operands.to_vec(),
            order: operation.order().map(|order| format!("{order:?}").to_lowercase()),
            position: Vec::new(),
            rotation: None,
            degrees: None,
            coordinates: Vec::new(),
            sigmas: Vec::new(),
            covariance: Vec::new(),
            rank: 0,
            convention: None,
            fit,
        };
        Ok(match answer {
            Answer::Pose(pose) => {
                let (covariance, side) = in_convention(pose, options)?;
                Self {
                    position: pose.mean().origin().as_slice().to_vec(),
                    rotation: Some(pose.mean().rotation(options.rotation)),
                    degrees: Some(pose.mean().degrees()),
                    coordinates: G::coordinates(options.to).to_vec(),
                    convention: Some((options.to, side)),
                    ..told.with(&covariance)
                }
            }
            Answer::Point(p, covariance) => {
                let coordinates = ["x m", "y m", "z m"][..N].to_vec();
                Self { position: p.as_slice().to_vec(), coordinates, ..told.with(covariance) }
            }
        })
    }

    fn with<const M: usize>(self, covariance: &Covariance<M>) -> Self {
        Self {
            sigmas: covariance.sigmas().as_slice().to_vec(),
            covariance: rows(covariance.matrix()),
            rank: covariance.rank(),
            ..self
        }
    }

    /// Whether the convention leaves the side open.
    fn has_side(&self) -> bool {
        matches!(self.convention, Some((Convention::Boxplus | Convention::Sophus | Convention::Barrau, _)))
    }

    /// For people, and for `boxplus pose -f -`.
    pub fn text(&self) -> String {
        let mut out = self.headline();
        out += "[pose.result]\n";
        let position = list(&self.position);
        // Writing to a string cannot fail.
        let _ = writeln!(out, "position = {position}  # m");
        if let Some((key, value)) = &self.rotation {
            let value = if *key == "yaw" { number(value[0][0]) } else { nested(value) };
            let degrees = self.degrees.as_deref().unwrap_or_default();
            let _ = writeln!(out, "{key} = {value}  # {degrees}");
        }
        let sigmas = self.coordinates.iter().zip(&self.sigmas);
        let told = sigmas.map(|(coordinate, sigma)| one_sigma(coordinate, *sigma)).collect::<Vec<_>>();
        let _ = writeln!(out, "# σ: {}", told.join(", "));
        if self.rank == 0 {
            out += "# certain: no coordinate has a variance\n";
            return out;
        }
        if let Some((convention, side)) = self.convention {
            let _ = writeln!(out, "convention = '{}'", name(convention));
            if self.has_side() {
                let _ = writeln!(out, "side = '{}'", format!("{side:?}").to_lowercase());
            }
        }
        let _ = writeln!(out, "covariance = [");
        let cells: Vec<Vec<String>> =
            self.covariance.iter().map(|row| row.iter().map(|x| number(*x)).collect()).collect();
        let width = cells.iter().flatten().map(String::len).max().unwrap_or(0);
        for row in &cells {
            let padded: Vec<_> = row.iter().map(|cell| format!("{cell:>width$}")).collect();
            let _ = writeln!(out, "  [{}],", padded.join(", "));
        }
        out += "]\n";
        out
    }

    /// What this is, as comments.
    fn headline(&self) -> String {
        let mut out = format!("# {}: {}", self.operation, self.operands.join("; "));
        if let Some(order) = &self.order {
            let _ = write!(out, ", to {order} order");
        }
        out.push('\n');
        match self.fit {
            Some(Fit::Independent { chi_squared, freedom, iterations }) => {
                let p = ChiSquared::new(freedom).survival(chi_squared);
                let _ = writeln!(
                    out,
                    "# χ² = {} of {freedom}: {} ({iterations} iterations)",
                    significant(chi_squared, 4),
                    if p < 0.01 {
                        "they contradict each other; one chance in a hundred"
                    } else {
                        "they agree"
                    }
                );
            }
            Some(Fit::Intersection { weight }) => {
                let _ =
                    writeln!(out, "# covariance intersection, weights {weight:.3} and {:.3}", 1.0 - weight);
            }
            None => {}
        }
        if self.degrees.is_some() && self.rank > 0 && self.rank < self.sigmas.len() {
            let _ = writeln!(out, "# of rank {}: some direction has no variance", self.rank);
        }
        out
    }

    /// For machines.
    pub fn document(&self) -> Value {
        let rotation = self.rotation.as_ref().map(|(key, value)| {
            let value = match (*key, value.as_slice()) {
                ("yaw", [row]) => json!(row[0]),
                (_, [row]) => json!(row),
                (_, rows) => json!(rows),
            };
            json!({ *key: value })
        });
        let fit = self.fit.map(|fit| match fit {
            Fit::Independent { chi_squared, freedom, iterations } => json!({
                "chi_squared": chi_squared,
                "degrees_of_freedom": freedom,
                "p_value": ChiSquared::new(freedom).survival(chi_squared),
                "iterations": iterations,
            }),
            Fit::Intersection { weight } => json!({ "weights": [weight, 1.0 - weight] }),
        });
        json!({
            "format": "boxplus.pose",
            "version": 1,
            "operation": self.operation,
            "operands": self.operands,
            "order": self.order,
            "position": self.position,
            "rotation": rotation,
            "convention": self.convention.map(|(convention, _)| name(convention)),
            "side": self.convention.filter(|_| self.has_side()).map(|(_, side)| side),
            "coordinates": self.coordinates,
            "sigmas": self.sigmas,
            "covariance": self.covariance,
            "rank": self.rank,
            "fit": fit,
        })
    }
}

/// `yaw 1.2°`, `x 0.1 m`.
fn one_sigma(coordinate: &str, sigma: f64) -> String {
    if let Some(name) = coordinate.strip_suffix(" rad") {
        return format!("{name} {}°", significant(sigma.to_degrees(), 4));
    }
    let name = coordinate.strip_suffix(" m").unwrap_or(coordinate);
    format!("{name} {} m", significant(sigma, 4))
}

/// A number of TOML that keeps what a double holds, and no more digits than needed.
fn number(x: f64) -> String {
    format!("{x:?}")
}

fn list(row: &[f64]) -> String {
    format!("[{}]", row.iter().map(|x| number(*x)).collect::<Vec<_>>().join(", "))
}

/// One row is a list, more are a list of lists.
fn nested(rows: &[Vec<f64>]) -> String {
    match rows {
        [row] => list(row),
        rows => format!("[{}]", rows.iter().map(|row| list(row)).collect::<Vec<_>>().join(", ")),
    }
}
