//! `boxplus convert`.

use std::path::Path;

use boxplus::io as graph_io;
use boxplus::pose_graph::PoseGraph;

use crate::args::{Convert, Global};
use crate::choices::Format;
use crate::error::Error;
use crate::input;
use crate::output::{Console, is_standard};

/// Reads one format, writes another.
pub fn run(options: &Convert, global: &Global, console: Console) -> Result<(), Error> {
    let format = format(&options.output, options.to)?;
    let console = console.beside(Some(&options.output))?;
    let loaded = input::load(&options.input, global, console)?;
    save(&loaded.graph, &options.output, format, console)?;
    console.wrote("convert", &loaded.name, &[&options.output])
}

/// The format to write: as asked, or as the name tells.
pub fn format(path: &Path, asked: Option<Format>) -> Result<Format, Error> {
    let standard = is_standard(path).then_some(Format::G2o);
    asked.or(standard).or_else(|| Format::of(path)).ok_or_else(|| Error::Usage {
        message: format!("the name {} does not tell the format", path.display()),
        help: Some(
            "end it in .g2o, .graph (TORO), .isam or .pyfg, or say --to g2o, toro, isam or pyfg".to_owned(),
        ),
    })
}

/// Writes a graph.
pub fn save(graph: &PoseGraph, path: &Path, format: Format, console: Console) -> Result<(), Error> {
    let unwritable = |error: graph_io::WriteError| Error::Unwritable {
        message: format!("{} is not written: {error}", path.display()),
    };
    let text = graph_io::write(graph, format.library()).map_err(unwritable)?;
    console.write(path, text.as_bytes())
}
