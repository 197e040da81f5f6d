//! What leaves the program: text for people, documents for machines, files written whole or not at all.

use std::fs::{self, File};
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};

use anstyle::{AnsiColor, Style};
use flate2::{Compression, write::GzEncoder};
use serde::Serialize;

use crate::error::Error;

/// Section titles.
pub const STRONG: Style = Style::new().bold();
/// What matters less.
pub const DIM: Style = Style::new().dimmed();
/// Done well.
pub const GOOD: Style = AnsiColor::Green.on_default();
/// To be looked at.
pub const WARN: Style = AnsiColor::Yellow.on_default();

/// The way to standard output and standard error; colours reach a terminal only, `NO_COLOR` is honoured.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::struct_excessive_bools, reason = "independent switches of the user")]
pub struct Console {
    json: bool,
    quiet: bool,
    verbose: bool,
    /// A file goes to standard output, so text for people must not.
    occupied: bool,
}

impl Console {
    /// `json`: one document is all that standard output carries; `quiet`: no text for people.
    pub fn new(json: bool, quiet: bool, verbose: bool) -> Self {
        Self { json, quiet, verbose, occupied: false }
    }

    /// The same, where `output` may be `-`, standard output, which carries one thing only.
    pub fn beside(self, output: Option<&Path>) -> Result<Self, Error> {
        let wanted = output.is_some_and(is_standard);
        if wanted && (self.json || self.occupied) {
            let other = if self.json { "--json" } else { "another file" };
            return Err(Error::Usage {
                message: format!("standard output is wanted for a file and for {other}"),
                help: Some("write the file to a path".to_owned()),
            });
        }
        Ok(Self { occupied: self.occupied || wanted, ..self })
    }

    /// The document of a verb that only writes files.
    pub fn wrote(self, verb: &str, input: &str, outputs: &[&Path]) -> Result<(), Error> {
        let outputs: Vec<_> = outputs.iter().map(|path| path.display().to_string()).collect();
        let format = format!("boxplus.{verb}");
        if !self.json {
            return Ok(());
        }
        document(&serde_json::json!({ "format": format, "version": 1, "input": input, "outputs": outputs }))
    }

    /// Whether a machine reads.
    pub fn is_json(self) -> bool {
        self.json
    }

    /// Whether details are wanted.
    pub fn is_verbose(self) -> bool {
        self.verbose
    }

    /// Whether progress may be shown.
    pub fn is_live(self) -> bool {
        !self.quiet && io::stderr().is_terminal()
    }

    /// Text for people.
    pub fn say(self, text: &str) -> Result<(), Error> {
        if self.quiet {
            return Ok(());
        }
        let written = if self.json || self.occupied {
            writeln!(anstream::stderr(), "{text}")
        } else {
            writeln!(anstream::stdout(), "{text}")
        };
        written.map_err(Error::Stdout)
    }

    /// Something that went not quite as wished; always on standard error.
    pub fn warn(self, text: &str) {
        if !self.quiet {
            // Nobody is left to tell when standard error is closed.
            let _ = writeln!(anstream::stderr(), "{WARN}warning:{WARN:#} {text}");
        }
    }

    /// Writes a file and says where it is.
    pub fn write(self, path: &Path, bytes: &[u8]) -> Result<(), Error> {
        write(path, bytes)?;
        if is_standard(path) { Ok(()) } else { self.say(&format!("{GOOD}wrote{GOOD:#} {}", path.display())) }
    }
}

/// Prints the document for machines.
pub fn document(document: &impl Serialize) -> Result<(), Error> {
    let mut out = io::stdout().lock();
    serde_json::to_writer_pretty(&mut out, document).map_err(io::Error::from).map_err(Error::Stdout)?;
    writeln!(out).and_then(|()| out.flush()).map_err(Error::Stdout)
}

/// `-` stands for standard output.
pub fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Writes all of `bytes` to `path`, packed where it ends in `.gz`: to a new file beside it that then takes its name,
/// so that a reader sees the old content or the new, never a part.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let failed = |source| Error::Write { path: path.to_owned(), source };
    if is_standard(path) {
        let mut out = io::stdout().lock();
        return out.write_all(bytes).and_then(|()| out.flush()).map_err(Error::Stdout);
    }
    let packed;
    let bytes = if path.extension().is_some_and(|e| e == "gz") {
        packed = gzip(bytes).map_err(failed)?;
        &packed
    } else {
        bytes
    };
    replace(path, bytes).map_err(failed)
}

fn gzip(bytes: &[u8]) -> io::Result<Vec<u8>> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes)?;
    encoder.finish()
}

fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    // The target of a link is replaced, not the link; a pipe or a device cannot be.
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    if fs::metadata(&path).is_ok_and(|m| !m.is_file() && !m.is_dir()) {
        return File::options().write(true).open(&path)?.write_all(bytes);
    }
    let mut file = new_file(folder(&path))?;
    file.write_all(bytes)?;
    if let Ok(old) = fs::metadata(&path) {
        fs::set_permissions(file.path(), old.permissions())?;
    }
    file.persist(&path)?;
    Ok(())
}

fn folder(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

fn new_file(folder: PathBuf) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".boxplus-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As any new file: the umask takes its part.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    // The error without the name of the temporary file, which nobody knows.
    builder.tempfile_in(folder).map_err(|error| error.kind().into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.txt");
        for content in [&b"long old content"[..], b"new"] {
            write(&path, content).unwrap();
            assert_eq!(fs::read(&path).unwrap(), content);
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn what_cannot_be_written_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let taken = folder.path().join("taken");
        fs::create_dir(&taken).unwrap();
        assert!(write(&taken, b"x").is_err());
        assert!(write(&folder.path().join("missing/out.txt"), b"x").is_err());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_name_in_gz_is_packed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.txt.gz");
        write(&path, b"text").unwrap();
        let text = io::read_to_string(flate2::read::GzDecoder::new(File::open(&path).unwrap())).unwrap();
        assert_eq!(text, "text");
    }

    #[cfg(unix)]
    #[test]
    fn links_and_permissions_stay() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, "old").unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
        symlink(&file, &link).unwrap();
        write(&link, b"new").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_written_to_not_replaced() {
        write(Path::new("/dev/null"), b"x").unwrap();
    }
}
