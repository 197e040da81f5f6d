//! `boxplus plot`, and the pictures of `solve`.

use std::path::Path;

use boxplus::pose_graph::{Constraint, Indefinite, PoseGraph, SolveSettings};

use crate::args::{Global, Plot};
use crate::draw::{Figure, Panel, Scene, png};
use crate::error::Error;
use crate::info::kinds;
use crate::input::{self, Loaded};
use crate::output::Console;
use crate::text::{count, significant};

/// A kind of picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Picture {
    Svg,
    Png,
}

impl Picture {
    /// What the ending of a name says.
    pub fn of(path: &Path) -> Result<Self, Error> {
        match path.extension().and_then(|e| e.to_str()) {
            Some("svg") => Ok(Self::Svg),
            Some("png") => Ok(Self::Png),
            _ => Err(Error::Usage {
                message: format!("the name {} does not tell the kind of picture", path.display()),
                help: Some("end it in .svg or .png".to_owned()),
            }),
        }
    }
}

/// Draws a graph as it is.
pub fn run(options: &Plot, global: &Global, console: Console) -> Result<(), Error> {
    let picture = Picture::of(&options.output)?;
    let loaded = input::load(&options.input, global, console)?;
    let panel = panel(&loaded)?;
    let figure = Figure { title: loaded.title(), facts: facts(&loaded.graph), panels: vec![panel] };
    save(&figure, picture, &options.output, console)?;
    console.wrote("plot", &loaded.name, &[&options.output])
}

/// The graph where its vertices are, or, where it has none, as first estimated.
fn panel(loaded: &Loaded) -> Result<Panel, Error> {
    // A picture is wanted even of a graph that cannot be solved.
    let settings = SolveSettings { indefinite: Indefinite::Skip, ..SolveSettings::default() };
    let refused = |error| loaded.refusal(error);
    let (heading, graph) = if loaded.graph.vertex_count() > 0 {
        ("As in the file", loaded.graph.clone())
    } else {
        ("First estimate", loaded.graph.initialised(&settings).map_err(refused)?)
    };
    let chi2 = graph.chi2(&settings).map_err(refused)?;
    let note = format!("cost {}", significant(0.5 * chi2.iter().filter(|x| !x.is_nan()).sum::<f64>(), 6));
    Ok(Panel { heading: heading.to_owned(), note, scene: Scene::of(&graph, &sigmas(&graph, &chi2)) })
}

/// Writes a picture.
pub fn save(figure: &Figure, picture: Picture, path: &Path, console: Console) -> Result<(), Error> {
    save_svg(&figure.svg(), picture, path, console)
}

/// Writes a drawing.
pub fn save_svg(svg: &str, picture: Picture, path: &Path, console: Console) -> Result<(), Error> {
    match picture {
        Picture::Svg => console.write(path, svg.as_bytes()),
        Picture::Png => {
            let bytes = png(svg).ok_or_else(|| Error::Unwritable {
                message: format!("{} is not written: the drawing has no pixels", path.display()),
            })?;
            console.write(path, &bytes)
        }
    }
}

/// `2500 poses in space · 4949 measurements`.
pub fn facts(graph: &PoseGraph) -> String {
    let kinds = kinds(graph).into_iter().map(|(n, one, many)| count(n, one, many));
    let measurements = count(graph.constraints().count(), "measurement", "measurements");
    kinds.chain([measurements]).collect::<Vec<_>>().join(" · ")
}

/// √(χ² per degree of freedom) of every measurement.
pub fn sigmas(graph: &PoseGraph, chi2: &[f64]) -> Vec<f64> {
    let sigma = |(constraint, chi2): (Constraint<'_>, &f64)| (chi2 / constraint.dof() as f64).sqrt();
    graph.constraints().zip(chi2).map(sigma).collect()
}
