//! `boxplus solve` of a bundle: cameras and points from images.

mod picture;
mod report;

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use boxplus::bundle_adjustment::solve::solve_observed;
use boxplus::bundle_adjustment::{Bundle, BundleError, Settings, Solved};
use boxplus::graph::Termination;
use boxplus::io::{self, WriteError, bal};

use crate::args::{Global, Method, Solve};
use crate::choices::{Behind, Chart, Indefinite, Init, Intrinsics, Robust};
use crate::error::{Error, Outcome};
use crate::excerpt::Excerpt;
use crate::input::LoadedBundle;
use crate::interrupt;
use crate::output::{self, Console};
use crate::plot::{self, Picture};
use crate::progress::Progress;
use crate::text::significant;
use report::BundleDocument;

/// What is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Target {
    Bal,
    Ply,
    /// A folder with the three text files of COLMAP.
    Colmap,
}

impl Target {
    fn of(path: &Path) -> Result<Self, Error> {
        let name = path.to_string_lossy().to_lowercase();
        let plain = name.strip_suffix(".gz").unwrap_or(&name);
        let ends = |ending: &str| plain.ends_with(ending);
        if path.is_dir() || (path.extension().is_none() && !output::is_standard(path)) {
            Ok(Self::Colmap)
        } else if ends(".ply") {
            Ok(Self::Ply)
        } else if ends(".bal") || ends(".txt") || output::is_standard(path) {
            Ok(Self::Bal)
        } else {
            Err(Error::Usage {
                message: format!("the name {} does not tell the format", path.display()),
                help: Some(
                    "end it in .bal or .txt (BAL, also .gz), in .ply, or name a folder for COLMAP's text files".to_owned(),
                ),
            })
        }
    }
}

/// Adjusts, reports and writes.
pub fn run(
    loaded: &LoadedBundle,
    options: &Solve,
    global: &Global,
    (console, started): (Console, Instant),
) -> Result<Outcome, Error> {
    let target = options.output.as_deref().map(Target::of).transpose()?;
    let picture = options.plot.as_deref().map(Picture::of).transpose()?;
    let console = console.beside(options.output.as_deref())?;
    refuse_what_is_for_graphs(options)?;
    let settings = settings(&options.method, global)?;
    let solved = optimise(loaded, &settings, console)?;

    let mut document = BundleDocument::new(loaded, &options.method, &solved, started.elapsed().as_secs_f64());
    if !console.is_json() {
        console.say(&document.screen(console.is_verbose()))?;
    }
    if let Some((path, target)) = options.output.as_deref().zip(target) {
        save(&solved.bundle, path, target, console)?;
        document.outputs.push(path.display().to_string());
    }
    if let Some((path, picture)) = options.plot.as_deref().zip(picture) {
        plot::save(&picture::figure(loaded, &solved), picture, path, console)?;
        document.outputs.push(path.display().to_string());
    }
    if console.is_json() {
        output::document(&document)?;
    }
    Ok(outcome(&solved, options.output.is_some(), console))
}

/// Options that say something to pose graphs only.
fn refuse_what_is_for_graphs(options: &Solve) -> Result<(), Error> {
    let method = &options.method;
    let given = [
        ("--to", options.to.is_some()),
        ("--covariance", options.covariance.is_some()),
        ("--init", method.init != Init::Auto && method.init != Init::File),
        ("--chart", method.chart != Chart::Log),
        ("--certify", method.certify),
        ("--information", method.information != Indefinite::Reject),
        (
            "--robust with a search for false closures",
            method.robust.as_ref().is_some_and(Robust::doubts_closures),
        ),
    ];
    match given.iter().find(|(_, given)| *given) {
        Some((option, _)) => Err(Error::Usage {
            message: format!("{option} is for pose graphs; this is a bundle of cameras and points"),
            help: Some("leave it out".to_owned()),
        }),
        None => Ok(()),
    }
}

fn settings(method: &Method, global: &Global) -> Result<Settings, Error> {
    let number = |id: &u64| {
        usize::try_from(*id)
            .map_err(|_| Error::Usage { message: format!("there is no view {id}"), help: None })
    };
    Ok(Settings {
        kernel: method.robust.as_ref().map_or(boxplus::graph::Kernel::None, |robust| robust.kernel),
        intrinsics: method.intrinsics.map_or_else(Default::default, Intrinsics::library),
        behind: method.behind.map_or_else(Default::default, Behind::library),
        fixed: method.fix.iter().map(number).collect::<Result<_, _>>()?,
        options: method.options(&Settings::options(), global),
    })
}

fn optimise(loaded: &LoadedBundle, settings: &Settings, console: Console) -> Result<Solved, Error> {
    let progress = Progress::start(console, "adjusting");
    let mut steps = 0;
    let observe = &mut |iteration: &boxplus::graph::Iteration| {
        steps += 1;
        progress.now(format!("step {steps}, cost {}", significant(iteration.cost, 6)));
        if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    solve_observed(&loaded.bundle, settings, observe).map_err(|error| refusal(loaded, &error))
}

/// The error for the user, with the line of the file at fault.
fn refusal(loaded: &LoadedBundle, error: &BundleError) -> Error {
    let line = match error {
        BundleError::NoSuchView { .. } => return Error::Usage { message: error.to_string(), help: None },
        BundleError::Faulty { faults } => faults.iter().map(|f| f.line().0).find(|line| *line > 0),
        _ => None,
    };
    let excerpt = line.and_then(|line| {
        let text = io::decompress(&loaded.source, &loaded.name).ok()?;
        Excerpt::line(&loaded.name, &text, line)
    });
    let help = "correct or remove these numbers".to_owned();
    match excerpt {
        Some(excerpt) => Error::malformed(error.to_string(), help, excerpt, "read here".to_owned()),
        None => Error::Unreadable { message: format!("{}: {error}", loaded.name), help: Some(help) },
    }
}

fn save(bundle: &Bundle, path: &Path, target: Target, console: Console) -> Result<(), Error> {
    let unwritable = |error: WriteError| Error::Unwritable {
        message: format!("{} is not written: {error}", path.display()),
    };
    match target {
        Target::Bal => console.write(path, bal::write(bundle).map_err(unwritable)?.as_bytes()),
        Target::Ply => console.write(path, &bal::write_ply(bundle).map_err(unwritable)?),
        Target::Colmap => {
            let files = bal::colmap(bundle).map_err(unwritable)?;
            fs::create_dir_all(path).map_err(|source| Error::Write { path: path.to_owned(), source })?;
            let texts = [("cameras", &files.cameras), ("images", &files.images), ("points3D", &files.points)];
            texts.iter().try_for_each(|(name, text)| {
                console.write(&path.join(name).with_extension("txt"), text.as_bytes())
            })
        }
    }
}

fn outcome(solved: &Solved, saved: bool, console: Console) -> Outcome {
    if solved.report.termination == Termination::Interrupted {
        let kept = if saved {
            "the best cameras and points so far are saved"
        } else {
            "nothing is saved; give -o FILE to keep cameras and points"
        };
        console.warn(&format!("stopped as asked: {kept}"));
        return Outcome::Interrupted;
    }
    if solved.gauge.anchors.len() > 1 {
        console.warn(&format!(
            "no observation joins the {} parts of the bundle: they have no place relative to each other",
            solved.gauge.anchors.len()
        ));
        return Outcome::Undetermined;
    }
    if solved.report.converged() { Outcome::Done } else { Outcome::NotConverged }
}
