//! Why the library would not solve a graph, with the line of the file at fault.

use boxplus::graph::GraphError;
use boxplus::pose_graph::{Fault, PoseGraphError};

use crate::error::Error;
use crate::excerpt::Excerpt;
use crate::input::Loaded;
use crate::text::count;

impl Loaded {
    /// The error for the user.
    pub fn refusal(&self, error: PoseGraphError) -> Error {
        match error {
            PoseGraphError::Faulty { faults } => self.faulty(&faults),
            PoseGraphError::Measurement { line, ref error } => match self.line(line.0) {
                Some(excerpt) => {
                    Error::malformed(error.to_string(), self.look(), excerpt, "read here".to_owned())
                }
                None => Error::Unreadable { message: error.to_string(), help: Some(self.look()) },
            },
            PoseGraphError::NoSuchVertex { .. } => Error::Usage {
                message: error.to_string(),
                help: Some(format!("`boxplus info {}` says which ids there are", self.name)),
            },
            PoseGraphError::Graph(error) if is_open(&error) => {
                Error::Undetermined { message: error.to_string(), help: Some(self.look()) }
            }
            _ => Error::Unreadable { message: format!("{}: {error}", self.name), help: Some(self.look()) },
        }
    }

    fn faulty(&self, faults: &[Fault]) -> Error {
        let Some(first) = faults.first() else {
            return Error::Unreadable { message: format!("{}: the graph is faulty", self.name), help: None };
        };
        let others = match faults.len() - 1 {
            0 => String::new(),
            n => format!(" (and {})", count(n, "fault more", "faults more")),
        };
        let message = format!("{first}{others}");
        let help = self.help(first, faults.len());
        match self.line(first.line().0) {
            Some(excerpt) => Error::malformed(message, help, excerpt, "read here".to_owned()),
            None => Error::Unreadable { message: format!("{}: {message}", self.name), help: Some(help) },
        }
    }

    fn help(&self, fault: &Fault, count: usize) -> String {
        let mend = match fault {
            Fault::Information { .. } => {
                "--information clamp or isotropic makes such matrices positive definite, --information skip leaves such edges out"
            }
            Fault::MissingVertex { .. } => {
                "add the vertex, or remove the line; a file without any vertex is fine, too"
            }
            _ => "correct or remove the line",
        };
        if count > 1 { format!("{mend}; {}", self.look()) } else { mend.to_owned() }
    }

    fn look(&self) -> String {
        format!("`boxplus info {} --verbose` says more", self.name)
    }

    /// A line of the file, counted from 1.
    fn line(&self, line: u32) -> Option<Excerpt> {
        let text = boxplus::io::decompress(&self.source, &self.name).ok()?;
        Excerpt::line(&self.name, &text, line)
    }
}

/// Whether the measurements leave the answer open, rather than being wrong.
fn is_open(error: &GraphError) -> bool {
    matches!(
        error,
        GraphError::Unconstrained(_)
            | GraphError::MissingValues { .. }
            | GraphError::Unread { .. }
            | GraphError::IllConditioned
    )
}
