//! What can go wrong, said so that the user can mend it, and the exit code that goes with it.

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use boxplus::io::IoError;
use boxplus::io::IoErrorKind::{DuplicateId, TooManyFields, ZeroQuaternion};
use miette::{Diagnostic, SourceSpan};
use thiserror::Error;

use crate::excerpt::Excerpt;

/// A failure of the program; each has its exit code.
#[derive(Debug, Error, Diagnostic)]
pub enum Error {
    /// The input cannot be opened or read.
    #[error("cannot read {}", path.display())]
    #[diagnostic(help("{}", reading_help(source)))]
    Read {
        path: PathBuf,
        #[source]
        source: io::Error,
    },
    /// The input is not what it should be, at a place.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Malformed(Box<Malformed>),
    /// The input as a whole is not what it should be.
    #[error("{message}")]
    Unreadable {
        message: String,
        #[help]
        help: Option<String>,
    },
    /// Input that is well-formed but leaves the answer open.
    #[error("{message}")]
    Undetermined {
        message: String,
        #[help]
        help: Option<String>,
    },
    /// A file cannot be written.
    #[error("cannot write {}", path.display())]
    #[diagnostic(help("nothing was written there; choose another path, or make the folder first"))]
    Write {
        path: PathBuf,
        #[source]
        source: io::Error,
    },
    /// The result cannot be said in the format that is asked for.
    #[error("{message}")]
    Unwritable { message: String },
    /// Arguments that contradict each other or the input.
    #[error("{message}")]
    Usage {
        message: String,
        #[help]
        help: Option<String>,
    },
    /// Standard output is closed or full.
    #[error("cannot write to standard output")]
    Stdout(#[source] io::Error),
}

/// A fault at a place of the input.
#[derive(Debug, Error, Diagnostic)]
#[error("{message}")]
pub struct Malformed {
    message: String,
    #[help]
    help: String,
    #[source_code]
    excerpt: Excerpt,
    #[label("{label}")]
    span: SourceSpan,
    label: String,
}

/// How the program ends when nothing fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Done.
    Done,
    /// A result that is arbitrary in directions that nothing constrains.
    Undetermined,
    /// A result, but not an optimum.
    NotConverged,
    /// Stopped by the user; the best result so far is saved.
    Interrupted,
}

impl Error {
    /// A file that the reader refused, with the place in it.
    pub fn parsing(error: &IoError, bytes: &[u8]) -> Self {
        let message = error.kind.to_string();
        let text = boxplus::io::decompress(bytes, &error.name).unwrap_or_default();
        let Some(place) = &error.place else {
            return Self::Unreadable {
                message: format!("{}: {message}", error.name),
                help: Some(error.help()),
            };
        };
        let excerpt = Excerpt::new(&error.name, &text, place.span.clone());
        let label = match (&error.kind, place.expected()) {
            (ZeroQuaternion | DuplicateId { .. } | TooManyFields { .. }, _) | (_, None) => "here".to_owned(),
            (_, Some(expected)) => format!("{expected} expected here"),
        };
        Self::malformed(message, error.help(), excerpt, label)
    }

    /// A fault at the marked place of an excerpt.
    pub fn malformed(message: String, help: String, excerpt: Excerpt, label: String) -> Self {
        Self::Malformed(Box::new(Malformed { message, help, span: excerpt.span(), excerpt, label }))
    }

    /// Prints the report on standard error.
    pub fn report(self) -> ExitCode {
        let code = self.exit_code();
        // Nobody is left to tell when standard error is closed.
        let _ = writeln!(io::stderr(), "{:?}", miette::Report::new(self));
        code
    }

    /// Whether the reader of standard output left early, as `head` does: not worth a word.
    pub fn is_broken_pipe(&self) -> bool {
        matches!(self, Self::Stdout(source) if source.kind() == io::ErrorKind::BrokenPipe)
    }

    /// 1 output cannot be written, 2 usage, 3 unreadable or malformed input, 4 no answer in the data.
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Write { .. } | Self::Unwritable { .. } | Self::Stdout(_) => 1,
            Self::Usage { .. } => 2,
            Self::Read { .. } | Self::Malformed(_) | Self::Unreadable { .. } => 3,
            Self::Undetermined { .. } => 4,
        })
    }
}

impl Outcome {
    /// 0 done, 4 no answer in the data, 5 not converged, 130 interrupted.
    pub fn exit_code(self) -> ExitCode {
        ExitCode::from(match self {
            Self::Done => 0,
            Self::Undetermined => 4,
            Self::NotConverged => 5,
            Self::Interrupted => 130,
        })
    }
}

fn reading_help(source: &io::Error) -> &'static str {
    match source.kind() {
        io::ErrorKind::NotFound => "is the path right? `demo:sphere` and the like need no file",
        io::ErrorKind::PermissionDenied => "the file is there, but you may not read it",
        io::ErrorKind::IsADirectory => "that is a folder; name a file in it",
        _ => "check that it is a readable file, plain or gzip",
    }
}
