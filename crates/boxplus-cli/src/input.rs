//! Graphs and bundles from files, from standard input and from simulators.

use std::fs;
use std::io::{self, Read};
use std::path::Path;
use std::time::Instant;

use boxplus::bundle_adjustment::{Bundle, simulate as bundles};
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
    /// The graph, where its vertices are the truth.
    pub fn truth(&self) -> Option<&PoseGraph> {
        let told = self.format.is_some_and(graph_io::Format::holds_truth) && self.graph.vertex_count() > 0;
        told.then_some(&self.graph)
    }

    /// Everything wrong with it.
    pub fn faults(&self) -> Vec<Fault> {
        self.warnings.iter().copied().chain(self.graph.faults()).collect()
    }

    /// The name without folders and endings, for titles.
    pub fn title(&self) -> String {
        title(&self.name)
    }
}

/// A name without folders and endings.
pub fn title(name: &str) -> String {
    let file = Path::new(name).file_name().map_or(name.to_owned(), |n| n.to_string_lossy().into_owned());
    let stem = file.trim_end_matches(".gz").trim_end_matches(".bz2");
    stem.rsplit_once('.').map_or(stem, |(stem, _)| stem).trim_start_matches("demo:").to_owned()
}

/// Cameras and points, and where they come from.
#[derive(Debug)]
pub struct LoadedBundle {
    /// For people.
    pub name: String,
    /// The problem.
    pub bundle: Bundle,
    /// The bytes of the file, to show the place of a fault.
    pub source: Vec<u8>,
    /// Seconds to read and parse, or to simulate.
    pub seconds: f64,
}

/// What `solve` solves.
#[derive(Debug)]
pub enum Problem {
    Graph(Box<Loaded>),
    Bundle(Box<LoadedBundle>),
}

/// Reads the graph that the user named.
pub fn load(input: &Input, global: &Global, console: Console) -> Result<Loaded, Error> {
    match load_problem(input, global, console)? {
        Problem::Graph(loaded) => Ok(*loaded),
        Problem::Bundle(bundle) => Err(Error::Usage {
            message: format!("{} holds cameras and points, not a pose graph", bundle.name),
            help: Some("`boxplus solve` adjusts bundles".to_owned()),
        }),
    }
}

/// Reads what the user named, a graph or a bundle: the content says which.
pub fn load_problem(input: &Input, global: &Global, console: Console) -> Result<Problem, Error> {
    let started = Instant::now();
    let source = input.source.as_path();
    let _progress = Progress::start(console, &format!("reading {}", source.display()));
    let mut problem = match demo(source)? {
        Some(Demo::Graph(world)) => Problem::Graph(Box::new(simulated(world, input.world, global)?)),
        Some(Demo::Bundle(world)) => Problem::Bundle(Box::new(photographed(world, input.world, global)?)),
        None => read(source, input)?,
    };
    match &mut problem {
        Problem::Graph(loaded) => loaded.seconds = started.elapsed().as_secs_f64(),
        Problem::Bundle(loaded) => loaded.seconds = started.elapsed().as_secs_f64(),
    }
    Ok(problem)
}

/// A simulated world.
enum Demo {
    Graph(Simulator),
    Bundle(bundles::World),
}

/// The simulator that `demo:NAME` names.
fn demo(source: &Path) -> Result<Option<Demo>, Error> {
    let Some(name) = source.to_str().and_then(|s| s.strip_prefix("demo:")) else { return Ok(None) };
    let graph = name.parse().map(Demo::Graph);
    let found = graph.ok().or_else(|| name.parse().map(Demo::Bundle).ok());
    let graphs = Simulator::ALL.map(Simulator::name);
    let names = || graphs.into_iter().chain(bundles::World::ALL.map(bundles::World::name));
    found.map(Some).ok_or_else(|| Error::Usage {
        message: format!("there is no simulator `{name}`"),
        help: Some(format!(
            "choose one of {}",
            names().map(|n| format!("demo:{n}")).collect::<Vec<_>>().join(", ")
        )),
    })
}

/// A simulated bundle: --size counts views, --noise is a factor of half a pixel.
fn photographed(world: bundles::World, options: World, global: &Global) -> Result<LoadedBundle, Error> {
    let usual = bundles::Options::default();
    let views = options.size.unwrap_or(usual.views);
    let options = bundles::Options {
        views,
        points: 50 * views,
        seed: global.seed.unwrap_or(usual.seed),
        sigma: options.noise.unwrap_or(1.0) * usual.sigma,
        outliers: options.outliers.unwrap_or(usual.outliers),
        ..usual
    };
    let help = Some("--size counts views, --noise is a factor, --outliers a chance".to_owned());
    let simulated =
        world.simulate(&options).map_err(|error| Error::Usage { message: error.to_string(), help })?;
    Ok(LoadedBundle {
        name: format!("demo:{world}"),
        bundle: simulated.bundle,
        source: Vec::new(),
        seconds: 0.0,
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

fn read(source: &Path, input: &Input) -> Result<Problem, Error> {
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
    if input.from.is_none() && graph_io::bal::looks_like(&bytes) {
        let bundle = graph_io::bal::read(&bytes, &name).map_err(|error| Error::parsing(&error, &bytes))?;
        return Ok(Problem::Bundle(Box::new(LoadedBundle { name, bundle, source: bytes, seconds: 0.0 })));
    }
    let parsed = graph_io::read(&bytes, &name, input.from.map(Format::library));
    let parsed = parsed.map_err(|error| Error::parsing(&error, &bytes))?;
    let graph_io::Parsed { graph, format, gzip, warnings, .. } = parsed;
    let format = Some(format);
    Ok(Problem::Graph(Box::new(Loaded { name, graph, format, gzip, source: bytes, warnings, seconds: 0.0 })))
}

fn bytes(source: &Path) -> io::Result<Vec<u8>> {
    if is_standard(source) {
        let mut bytes = Vec::new();
        io::stdin().lock().read_to_end(&mut bytes)?;
        return Ok(bytes);
    }
    fs::read(source)
}
