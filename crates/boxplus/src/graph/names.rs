//! How messages call variables and factors.

use core::fmt;

use crate::label::Label;

/// How messages call a variable: its kind and its label (the id of its file, else its number).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VariableName {
    /// Kind, e.g. `"SE2"`.
    pub kind: &'static str,
    /// Id in its file, or the number of its key.
    pub label: u64,
}

impl fmt::Display for VariableName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.kind, Label(self.label))
    }
}

/// What messages call a factor: its kind and the variables it reads.
#[derive(Clone, Debug, PartialEq)]
pub struct FactorName {
    /// Kind, e.g. `"displacement"`.
    pub kind: &'static str,
    /// The variables it reads.
    pub variables: Vec<VariableName>,
}

impl fmt::Display for FactorName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of ", self.kind)?;
        for (i, variable) in self.variables.iter().enumerate() {
            write!(f, "{}{variable}", if i == 0 { "" } else { ", " })?;
        }
        Ok(())
    }
}
