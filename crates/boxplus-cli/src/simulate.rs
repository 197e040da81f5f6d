//! `boxplus simulate`, and the graphs behind `demo:NAME`.

use std::path::Path;

use boxplus::pose_graph::simulate::{Options, Simulated, Simulator};

use crate::args::{Global, Simulate, World};
use crate::convert::{format, save};
use crate::error::Error;
use crate::output::Console;

/// Writes a simulated graph, and its truth if asked.
pub fn run(options: &Simulate, global: &Global, console: Console) -> Result<(), Error> {
    let format_of = |path: &Path| format(path, options.to);
    let (output_format, truth_format) =
        (format_of(&options.output)?, options.truth.as_deref().map(format_of).transpose()?);
    let console = console.beside(Some(&options.output))?.beside(options.truth.as_deref())?;
    let Simulated { graph, truth } = run_world(options.name, options.world, global.seed)?;
    save(&graph, &options.output, output_format, console)?;
    if let Some((path, format)) = options.truth.as_deref().zip(truth_format) {
        save(&truth, path, format, console)?;
    }
    let outputs: Vec<&Path> =
        [options.output.as_path()].into_iter().chain(options.truth.as_deref()).collect();
    console.wrote("simulate", &format!("demo:{}", options.name), &outputs)
}

/// Simulates a world.
pub fn run_world(world: Simulator, options: World, seed: Option<u64>) -> Result<Simulated, Error> {
    let usual = Options::default();
    let noise = options.noise.unwrap_or(1.0);
    let options = Options {
        size: options.size,
        seed: seed.unwrap_or(usual.seed),
        sigma_translation: noise * usual.sigma_translation,
        sigma_rotation: noise * usual.sigma_rotation,
        outliers: options.outliers.unwrap_or(usual.outliers),
        ..usual
    };
    let help = Some("--size counts poses, --noise is a factor, --outliers a chance".to_owned());
    world.simulate(&options).map_err(|error| Error::Usage { message: error.to_string(), help })
}
