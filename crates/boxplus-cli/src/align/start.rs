//! Where an alignment starts, as the user says it.

use std::fs;
use std::path::Path;

use boxplus::lie::{LieError, SE2, SE3, SO3};
use boxplus::registration::{Rigid, Scan};
use nalgebra::{Matrix3, Matrix4, SVector, Vector3, vector};
use serde_json::{Value, json};

use crate::error::Error;
use crate::text::significant;

/// A motion as people write and read it.
pub trait Motion<const D: usize, const N: usize>: Rigid<D, N> {
    /// How `--init` is written.
    const WRITTEN: &'static str;
    /// From the numbers of `--init`; `None` where there are too many or too few.
    fn from_numbers(numbers: &[f64]) -> Option<Result<Self, LieError>>;
    /// For machines.
    fn document(&self) -> Value;
    /// For people: `(what, value)`.
    fn rows(&self) -> Vec<(&'static str, String)>;
    /// The matrix by rows.
    fn matrix(&self) -> Vec<Vec<f64>>;
    /// What the coordinates of the tangent are called, and their units.
    fn coordinates() -> [(&'static str, &'static str); D];
}

fn numbers(x: &[f64], digits: usize) -> String {
    x.iter().map(|x| significant(*x, digits)).collect::<Vec<_>>().join("  ")
}

impl Motion<3, 2> for SE2 {
    const WRITTEN: &'static str = "x y angle, or a 3×3 matrix by rows";

    fn from_numbers(x: &[f64]) -> Option<Result<Self, LieError>> {
        match x.len() {
            3 => Some(Ok(Self::new(vector![x[0], x[1]], x[2]))),
            9 => Some(Self::from_matrix(&Matrix3::from_row_slice(x))),
            _ => None,
        }
    }

    fn document(&self) -> Value {
        let t = self.translation();
        json!({ "translation": t.as_slice(), "angle": self.angle(), "matrix": self.matrix() })
    }

    fn rows(&self) -> Vec<(&'static str, String)> {
        vec![
            ("moved", format!("{} m", numbers(self.translation().as_slice(), 6))),
            ("turned", format!("{}°", significant(self.angle().to_degrees(), 6))),
        ]
    }

    fn matrix(&self) -> Vec<Vec<f64>> {
        self.to_matrix().row_iter().map(|row| row.iter().copied().collect()).collect()
    }

    fn coordinates() -> [(&'static str, &'static str); 3] {
        [("x", "m"), ("y", "m"), ("angle", "rad")]
    }
}

impl Motion<6, 3> for SE3 {
    const WRITTEN: &'static str =
        "x y z qx qy qz qw, x y z and a rotation vector, or a 3×4 or 4×4 matrix by rows";

    fn from_numbers(x: &[f64]) -> Option<Result<Self, LieError>> {
        let translation = || Vector3::new(x[0], x[1], x[2]);
        match x.len() {
            6 => Some(Ok(Self::new(boxplus::lie::LieGroup::exp(&vector![x[3], x[4], x[5]]), translation()))),
            7 => Some(SO3::from_xyzw([x[3], x[4], x[5], x[6]]).map(|q| Self::new(q, translation()))),
            12 => {
                let mut whole = x.to_vec();
                whole.extend([0.0, 0.0, 0.0, 1.0]);
                Some(Self::from_matrix(&Matrix4::from_row_slice(&whole)))
            }
            16 => Some(Self::from_matrix(&Matrix4::from_row_slice(x))),
            _ => None,
        }
    }

    fn document(&self) -> Value {
        let (t, q) = (self.translation(), self.rotation().quaternion_xyzw());
        json!({ "translation": t.as_slice(), "quaternion_xyzw": q, "matrix": self.matrix() })
    }

    fn rows(&self) -> Vec<(&'static str, String)> {
        let turn = boxplus::lie::LieGroup::log(&self.rotation());
        let axis = if turn.norm() > 0.0 { turn / turn.norm() } else { Vector3::z() };
        vec![
            ("moved", format!("{} m", numbers(self.translation().as_slice(), 6))),
            (
                "turned",
                format!(
                    "{}° about {}",
                    significant(turn.norm().to_degrees(), 6),
                    numbers(axis.as_slice(), 3)
                ),
            ),
        ]
    }

    fn matrix(&self) -> Vec<Vec<f64>> {
        self.to_matrix().row_iter().map(|row| row.iter().copied().collect()).collect()
    }

    fn coordinates() -> [(&'static str, &'static str); 6] {
        [("x", "m"), ("y", "m"), ("z", "m"), ("about x", "rad"), ("about y", "rad"), ("about z", "rad")]
    }
}

/// The start that `--init` says: the identity unless given.
pub fn read<G: Motion<D, N>, const D: usize, const N: usize>(
    text: Option<&str>,
    source: &Scan<N>,
    target: &Scan<N>,
) -> Result<G, Error> {
    match text {
        None | Some("identity") => Ok(G::identity()),
        Some("centroids") => Ok(G::translation_by(&(centroid(target) - centroid(source)))),
        Some(text) if Path::new(text).is_file() => {
            let content =
                fs::read_to_string(text).map_err(|source| Error::Read { path: text.into(), source })?;
            parse(&content, text)
        }
        Some(text) => parse(text, text),
    }
}

fn centroid<const N: usize>(scan: &Scan<N>) -> SVector<f64, N> {
    let count = scan.points().len() as f64;
    scan.points().map(|p| p / count).sum()
}

fn parse<G: Motion<D, N>, const D: usize, const N: usize>(text: &str, shown: &str) -> Result<G, Error> {
    let usage = |message: String| Error::Usage {
        message,
        help: Some(format!(
            "write identity, centroids, {}, or the name of a file with these numbers",
            G::WRITTEN
        )),
    };
    let words = text.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty());
    let numbers: Vec<f64> = words
        .map(|word| word.parse().map_err(|_| usage(format!("--init {shown}: `{word}` is not a number"))))
        .collect::<Result<_, _>>()?;
    match G::from_numbers(&numbers) {
        Some(Ok(start)) => Ok(start),
        Some(Err(error)) => Err(usage(format!("--init {shown}: {error}"))),
        None => Err(usage(format!("--init {shown}: {} numbers make no start", numbers.len()))),
    }
}
