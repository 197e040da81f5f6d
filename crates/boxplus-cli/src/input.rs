//! Graphs from files, from standard input and from simulators.

use std::fs;
use std::io::{self, Read};
use std::path::Path;
use std::time::Instant;

use boxplus::io as graph_io;
use boxplus::pose_graph::simulate::Simulator;
use boxplus::pose_graph::{Fault, PoseGraph};

use crate::args::{Global, Input, World};
use crate::choices::Format;
use crate::error::Error;
use crate::output::{Console, is_standard};
use crate::progress::Progress;
use crate::simulate;

/// A graph and where it comes from.
#[derive(Debug)]
pub struct Loaded {
    /// For people: the path, `<stdin>` or `demo:NAME`.
    pub name: String,
    /// The graph.
    pub graph: PoseGraph,
    /// The format of the file, `None` where it was simulated.
    pub format: Option<graph_io::Format>,
    /// Whether it was compressed.
    pub gzip: bool,
    /// The bytes of the file, to show the place of a fault.
    pub source: Vec<u8>,
    /// What was odd but could be read.
    warnings: Vec<Fault>,
    /// Seconds to read and parse, or to simulate.
    pub seconds: f64,
}

impl Loaded {
    /// Everything wrong with it.
    pub fn faults(&self) -> Vec<Fault> {
        self.warnings.iter().copied().chain(self.graph.faults()).collect()
    }

    /// The name without folders and endings, for titles.
    pub fn title(&self) -> String {
        let file =
            Path::new(&self.name).file_name().map_or(self.name.clone(), |n| n.to_string_lossy().into_owned());
        let stem = file.trim_end_matches(".gz");
        stem.rsplit_once('.').map_or(stem, |(stem, _)| stem).trim_start_matches("demo:").to_owned()
    }
}

/// Reads what the user named.
pub fn load(input: &Input, global: &Global, console: Console) -> Result<Loaded, Error> {
    let started = Instant::now();
    let source = input.source.as_path();
    let _progress = Progress::start(console, &format!("reading {}", source.display()));
    let mut loaded = match demo(source)? {
        Some(world) => simulated(world, input.world, global)?,
        None => read(source, input)?,
    };
    loaded.seconds = started.elapsed().as_secs_f64();
    Ok(loaded)
}

/// The simulator that `demo:NAME` names.
fn demo(source: &Path) -> Result<Option<Simulator>, Error> {
    let Some(name) = source.to_str().and_then(|s| s.strip_prefix("demo:")) else { return Ok(None) };
    let names = || Simulator::ALL.map(|world| format!("demo:{world}")).join(", ");
    name.parse().map(Some).map_err(|_| Error::Usage {
        message: format!("there is no simulator `{name}`"),
        help: Some(format!("choose one of {}", names())),
    })
}

fn simulated(world: Simulator, options: World, global: &Global) -> Result<Loaded, Error> {
    let graph = simulate::run_world(world, options, global.seed)?.graph;
    Ok(Loaded {
        name: format!("demo:{world}"),
        graph,
        format: None,
        gzip: false,
        source: Vec::new(),
        warnings: Vec::new(),
        seconds: 0.0,
    })
}

fn read(source: &Path, input: &Input) -> Result<Loaded, Error> {
    if input.world != World::default() {
        return Err(Error::Usage {
            message: format!(
                "{} is not simulated: --size, --noise and --outliers say nothing to it",
                source.display()
            ),
            help: Some("leave them out, or name a simulated graph such as demo:sphere".to_owned()),
        });
    }
    let name = if is_standard(source) { "<stdin>".to_owned() } else { source.display().to_string() };
    let bytes = bytes(source).map_err(|source| Error::Read { path: name.clone().into(), source })?;
    let parsed = graph_io::read(&bytes, &name, input.from.map(Format::library));
    let parsed = parsed.map_err(|error| Error::parsing(&error, &bytes))?;
    let graph_io::Parsed { graph, format, gzip, warnings, .. } = parsed;
    Ok(Loaded { name, graph, format: Some(format), gzip, source: bytes, warnings, seconds: 0.0 })
}

fn bytes(source: &Path) -> io::Result<Vec<u8>> {
    if is_standard(source) {
        let mut bytes = Vec::new();
        io::stdin().lock().read_to_end(&mut bytes)?;
        return Ok(bytes);
    }
    fs::read(source)
}
