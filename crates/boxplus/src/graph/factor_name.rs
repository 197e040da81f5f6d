//! How messages call a factor.

use core::fmt;

use super::values::VariableName;

/// What messages call a factor: its kind and the variables it reads.
#[derive(Clone, Debug, PartialEq)]
pub struct FactorName {
    /// Kind, e.g. `"relative pose"`.
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
