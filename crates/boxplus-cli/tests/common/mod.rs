//! Runs the program as a user would.
#![allow(dead_code, reason = "each test file uses its part")]
#![allow(clippy::unwrap_used, unreachable_pub, reason = "a test may panic, and is no library")]

use std::fs;
use std::path::PathBuf;
use std::process::Output;

use assert_cmd::Command;
use tempfile::TempDir;

/// What a run left behind.
#[derive(Debug)]
pub struct Run {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).unwrap();
        let code = output.status.code().unwrap_or(-1);
        let (stdout, stderr) = (text(output.stdout), text(output.stderr));
        assert!(!stderr.contains("panicked"), "{stderr}");
        Self { code, stdout, stderr }
    }
}

impl Run {
    /// The document on standard output.
    pub fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|e| panic!("{e}: {}\n{}", self.stdout, self.stderr))
    }

    /// Both streams and the exit code, with times taken out.
    pub fn transcript(&self) -> String {
        format!("exit code {}\n--- stdout\n{}--- stderr\n{}", self.code, self.stdout, self.stderr)
    }
}

/// An empty folder to run in.
pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn with(self, name: &str, content: impl AsRef<[u8]>) -> Self {
        fs::write(self.path(name), content).unwrap();
        self
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap()
    }

    /// The names of all files, hidden ones too.
    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// `boxplus ARGUMENTS`, the words split at spaces, in this folder.
    pub fn boxplus(&self, arguments: &str) -> Run {
        self.boxplus_fed(arguments, Vec::new())
    }

    /// The same with something on standard input.
    pub fn boxplus_fed(&self, arguments: &str, input: impl Into<Vec<u8>>) -> Run {
        self.command(arguments).write_stdin(input).output().unwrap().into()
    }

    pub fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_boxplus"));
        command.current_dir(self.0.path()).args(arguments.split_whitespace());
        for variable in ["BOXPLUS_THREADS", "BOXPLUS_SEED", "CLICOLOR_FORCE", "FORCE_COLOR", "COLUMNS"] {
            command.env_remove(variable);
        }
        command.env("LC_ALL", "C.UTF-8");
        command
    }
}

/// Snapshots without what differs from run to run.
pub fn settings() -> insta::Settings {
    let mut settings = insta::Settings::clone_current();
    settings.add_filter(r"\d+(\.\d+)? (ms|s|min)\b( \d+ s)?", "[time]");
    settings.add_filter(r"boxplus(-cli)? \d+\.\d+\.\d+", "boxplus [version]");
    settings.add_filter(r"/tmp/[^\s:]*/", "[folder]/");
    settings.set_prepend_module_to_snapshot(true);
    settings
}

/// A square of four poses, driven twice as measured, with one loop closure.
pub const SQUARE: &str = "\
VERTEX_SE2 0 0 0 0
VERTEX_SE2 1 1.1 0 1.5
VERTEX_SE2 2 1 1.2 3.1
VERTEX_SE2 3 0 0.9 -1.6
EDGE_SE2 0 1 1 0 1.57 100 0 0 100 0 400
EDGE_SE2 1 2 1 0 1.57 100 0 0 100 0 400
EDGE_SE2 2 3 1 0 1.57 100 0 0 100 0 400
EDGE_SE2 3 0 1 0 1.57 100 0 0 100 0 400
";
