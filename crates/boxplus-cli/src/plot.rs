//! `boxplus plot`, and the pictures of `solve`.

use std::path::Path;

use crate::args::{Global, Plot};
use crate::draw::{Figure, Panel, Scene, png};
use crate::error::Error;
use crate::info::kinds;
use crate::input::{self, Loaded};
use crate::output::Console;
use crate::text::count;

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
    let figure = Figure { title: loaded.title(), facts: facts(&loaded), panels: vec![panel(&loaded)] };
    save(&figure, picture, &options.output, console)
}

/// Writes a picture.
pub fn save(figure: &Figure, picture: Picture, path: &Path, console: Console) -> Result<(), Error> {
    let svg = figure.svg();
    match picture {
        Picture::Svg => console.write(path, svg.as_bytes()),
        Picture::Png => {
            let bytes = png(&svg).ok_or_else(|| Error::Unwritable {
                message: format!("{} is not written: the drawing has no pixels", path.display()),
            })?;
            console.write(path, &bytes)
        }
    }
}

/// `2500 poses in space · 4949 measurements`.
pub fn facts(loaded: &Loaded) -> String {
    let kinds = kinds(&loaded.graph).into_iter().map(|(n, one, many)| count(n, one, many));
    let measurements = count(loaded.graph.constraints().count(), "measurement", "measurements");
    kinds.chain([measurements]).collect::<Vec<_>>().join(" · ")
}

fn panel(loaded: &Loaded) -> Panel {
    Panel { heading: "As in the file".to_owned(), note: String::new(), scene: Scene::of(&loaded.graph, &[]) }
}
