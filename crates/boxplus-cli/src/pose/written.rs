//! Poses as people write them: TOML or JSON, in files or in place.

use std::collections::BTreeMap;
use std::path::Path;
use std::{fs, io};

use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::args::{Convention, Options, SideName};
use crate::error::Error;
use crate::output::is_standard;
use crate::settings::{fault, toml};

const HELP: &str = "a pose is [pose.NAME] with position and a rotation; see `boxplus pose --help`";

/// One pose, or a point, before it is looked at.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Written {
    pub position: Vec<f64>,
    pub yaw: Option<f64>,
    pub yaw_deg: Option<f64>,
    pub yaw_pitch_roll: Option<[f64; 3]>,
    pub yaw_pitch_roll_deg: Option<[f64; 3]>,
    pub quaternion_xyzw: Option<[f64; 4]>,
    pub quaternion_wxyz: Option<[f64; 4]>,
    pub rotation_vector: Option<[f64; 3]>,
    pub matrix: Option<Vec<Vec<f64>>>,
    pub sigmas: Option<Vec<f64>>,
    pub covariance: Option<Vec<Vec<f64>>>,
    pub information: Option<Vec<Vec<f64>>>,
    pub convention: Option<Convention>,
    pub side: Option<SideName>,
}

/// Two poses whose errors are correlated.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Correlation {
    of: [String; 2],
    covariance: Vec<Vec<f64>>,
}

/// A file.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    pose: BTreeMap<String, Written>,
    #[serde(default)]
    correlation: Vec<Correlation>,
}

/// A pose with the name for messages.
#[derive(Clone, Debug)]
pub struct Named {
    pub name: String,
    pub written: Written,
}

/// Everything that was read.
#[derive(Debug, Default)]
pub struct Library {
    poses: BTreeMap<String, Written>,
    correlations: Vec<Correlation>,
}

impl Library {
    /// The files of the command line; what comes later wins.
    pub fn read(options: &Options) -> Result<Self, Error> {
        let mut library = Self::default();
        for path in &options.file {
            let name = if is_standard(path) { "<stdin>".to_owned() } else { path.display().to_string() };
            let text = text(path).map_err(|source| Error::Read { path: name.clone().into(), source })?;
            let file: File = if text.trim_start().starts_with('{') {
                json(&name, &text)?
            } else {
                toml(&name, &text, HELP)?
            };
            library.poses.extend(file.pose);
            library.correlations.extend(file.correlation);
        }
        Ok(library)
    }

    /// The pose that a word of the command line means.
    pub fn find(&self, word: &str) -> Result<Named, Error> {
        if word.contains('=') {
            let written: Alone = toml("<argument>", &format!("it = {{ {word} }}\n"), HELP)?;
            return Ok(Named { name: word.to_owned(), written: written.it });
        }
        if let Some(written) = self.poses.get(word) {
            return Ok(Named { name: word.to_owned(), written: written.clone() });
        }
        let known: Vec<_> = self.poses.keys().map(|name| format!("`{name}`")).collect();
        Err(Error::Usage {
            message: format!("there is no pose `{word}`"),
            help: Some(if known.is_empty() {
                "name a file of poses by -f, or write the pose in place: 'position = [1, 2], yaw = 0.3'"
                    .to_owned()
            } else {
                format!("the files have {}", known.join(", "))
            }),
        })
    }

    /// `E[ξ₁ξ₂ᵀ]` of two named poses, in their own conventions, if a file says it.
    pub fn correlation(&self, first: &str, second: &str) -> Option<Vec<Vec<f64>>> {
        self.correlations.iter().rev().find_map(|known| match &known.of {
            [a, b] if a == first && b == second => Some(known.covariance.clone()),
            [a, b] if a == second && b == first => Some(transposed(&known.covariance)),
            _ => None,
        })
    }
}

#[derive(Deserialize)]
struct Alone {
    it: Written,
}

/// Of a matrix by rows; of rows that differ in length, what all have.
fn transposed(rows: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let columns = rows.iter().map(Vec::len).min().unwrap_or(0);
    (0..columns).map(|j| rows.iter().map(|row| row[j]).collect()).collect()
}

fn text(path: &Path) -> io::Result<String> {
    if is_standard(path) { io::read_to_string(io::stdin().lock()) } else { fs::read_to_string(path) }
}

fn json<T: DeserializeOwned>(name: &str, text: &str) -> Result<T, Error> {
    serde_json::from_str(text).map_err(|error| {
        let line: usize = text.split_inclusive('\n').take(error.line().saturating_sub(1)).map(str::len).sum();
        let at = line + error.column().saturating_sub(1);
        fault(name, text, at..at + 1, &error.to_string(), HELP)
    })
}
