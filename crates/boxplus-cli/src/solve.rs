//! `boxplus solve`: read, optimise, report, write.

use std::borrow::Cow;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use boxplus::graph::{Initial, Kernel, SolveOptions, Termination};
use boxplus::pose_graph::certify::{Certificate, CertifyError, certify_observed};
use boxplus::pose_graph::solve::{Progress as Event, solve_observed};
use boxplus::pose_graph::{PoseGraph, SolveSettings, Solved};

use crate::args::{Global, Method, Solve};
use crate::before_after;
use crate::bundle;
use crate::choices::Format;
use crate::convert::{format, save};
use crate::document::SolveDocument;
use crate::error::{Error, Outcome};
use crate::input::{self, Loaded, Problem};
use crate::interrupt;
use crate::output::{self, Console};
use crate::plot::{self, Picture};
use crate::progress::Progress;
use crate::text::{grouped, significant};

/// Reads, optimises, reports and writes.
pub fn run(options: &Solve, global: &Global, console: Console) -> Result<Outcome, Error> {
    let started = Instant::now();
    interrupt::watch();
    let loaded =
        match input::load_problem(&options.input, global, console.beside(options.output.as_deref())?)? {
            Problem::Graph(loaded) => *loaded,
            Problem::Bundle(loaded) => return bundle::run(&loaded, options, global, (console, started)),
        };
    refuse_what_is_for_bundles(&options.method)?;
    let output = options.output.as_deref().map(|path| result_format(path, options.to)).transpose()?;
    let picture = options.plot.as_deref().map(Picture::of).transpose()?;
    let console = console.beside(options.output.as_deref())?;
    let settings = settings(&options.method, global);
    let measured = blind(&loaded, &settings);
    let solved = optimise(&measured, &loaded, &settings, console)?;
    let (solved, certificate) =
        if options.method.certify && solved.report.termination != Termination::Interrupted {
            let (solved, certificate) = certified(solved, &loaded, &settings, console)?;
            (solved, Some(certificate))
        } else {
            (solved, None)
        };

    let mut document = SolveDocument::new(&loaded, &options.method, &solved, started.elapsed().as_secs_f64());
    certificate.iter().for_each(|certificate| document.certified(certificate));
    if !console.is_json() {
        console.say(&document.screen(console.is_verbose()))?;
    }
    if let Some((path, format)) = options.output.as_deref().zip(output) {
        save(&solved.graph, path, format, console)?;
        document.wrote(path);
    }
    if let Some((path, picture)) = options.plot.as_deref().zip(picture) {
        let figure = before_after::figure(&loaded, &settings, &solved, options.covariance, console)?;
        plot::save(&figure, picture, path, console)?;
        document.wrote(path);
    }
    if console.is_json() {
        output::document(&document)?;
    }
    let stopped = solved.report.termination == Termination::Interrupted
        || certificate.is_some_and(|certificate| certificate.stopped);
    Ok(outcome(&solved, stopped, options.output.is_some(), console))
}

/// Options that say something to bundles only.
fn refuse_what_is_for_bundles(method: &Method) -> Result<(), Error> {
    if method.intrinsics.is_none() && method.behind.is_none() {
        return Ok(());
    }
    Err(Error::Usage {
        message: "--intrinsics and --behind are for bundles of cameras and points; this is a pose graph"
            .to_owned(),
        help: Some("leave them out".to_owned()),
    })
}

/// The format of the result, which must hold poses.
fn result_format(path: &Path, asked: Option<Format>) -> Result<Format, Error> {
    match format(path, asked)? {
        Format::Isam => Err(Error::Usage {
            message: "an iSAM file holds measurements only: the solved poses would be lost".to_owned(),
            help: Some("write .g2o or .graph (TORO)".to_owned()),
        }),
        format => Ok(format),
    }
}

/// The graph to solve: where its vertices are the truth, they are forgotten, unless the user says to start from them.
fn blind<'a>(loaded: &'a Loaded, settings: &SolveSettings) -> Cow<'a, PoseGraph> {
    match loaded.truth() {
        Some(truth) if settings.initial != Initial::AsGiven => Cow::Owned(truth.measurements_only()),
        _ => Cow::Borrowed(&loaded.graph),
    }
}

fn settings(method: &Method, global: &Global) -> SolveSettings {
    SolveSettings {
        chart: method.chart.library(),
        initial: method.init.library(),
        kernel: method.robust.as_ref().map_or(Kernel::None, |robust| robust.kernel),
        graduation: method.robust.as_ref().and_then(|robust| robust.graduation),
        switches: method.robust.as_ref().and_then(|robust| robust.switches),
        pairwise: method.robust.as_ref().and_then(|robust| robust.pairwise),
        fixed: method.fix.clone(),
        indefinite: method.information.library(),
        options: method.options(&SolveOptions::default(), global),
    }
}

/// The proof; and where it finds better poses, the optimum next to them.
fn certified(
    solved: Solved,
    loaded: &Loaded,
    settings: &SolveSettings,
    console: Console,
) -> Result<(Solved, Certificate), Error> {
    let progress = Progress::start(console, "proving that no other estimate is better");
    let observe = &mut |cost: f64| {
        progress.now(format!("proving that no other estimate is better, at cost {}", significant(cost, 6)));
        if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let certificate = certify_observed(&solved.graph, settings, observe).map_err(|error| match error {
        CertifyError::PoseGraph(error) => loaded.refusal(error),
        error => Error::Usage {
            message: format!("{}: {error}", loaded.name),
            help: Some("leave out --certify to solve it without a proof".to_owned()),
        },
    })?;
    drop(progress);
    if certificate.escapes == 0 {
        return Ok((solved, certificate));
    }
    let settings = SolveSettings { initial: Initial::AsGiven, ..settings.clone() };
    let better = optimise(&certificate.graph, loaded, &settings, console)?;
    // From the first estimate to the best one; what came between is in the certificate.
    let solved = Solved {
        graph: better.graph,
        cost: better.cost,
        costs: better.costs,
        report: better.report,
        chi2: better.chi2,
        unconstrained: better.unconstrained,
        ..solved
    };
    Ok((solved, certificate))
}

fn optimise(
    graph: &PoseGraph,
    loaded: &Loaded,
    settings: &SolveSettings,
    console: Console,
) -> Result<Solved, Error> {
    let progress = Progress::start(console, "looking for a first estimate");
    let (mut steps, factor) = (0, settings.chart.factor());
    let observe = &mut |event: Event<'_>| {
        match event {
            Event::Growing(map) => {
                progress.now(format!(
                    "growing the map: {} of {} poses, cost {}",
                    grouped(map.poses),
                    grouped(map.of),
                    significant(factor * map.cost, 6)
                ));
            }
            Event::Initialised(_, cost) => {
                progress.now(format!("optimising from cost {}", significant(cost, 6)));
            }
            Event::Iteration(iteration) => {
                steps += 1;
                progress.now(format!("step {steps}, cost {}", significant(factor * iteration.cost, 6)));
            }
        }
        if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    solve_observed(graph, settings, observe).map_err(|error| loaded.refusal(error))
}

fn outcome(solved: &Solved, stopped: bool, saved: bool, console: Console) -> Outcome {
    if stopped {
        let kept = if saved {
            "the best poses so far are saved"
        } else {
            "nothing is saved; give -o FILE to keep the poses"
        };
        console.warn(&format!("stopped as asked: {kept}"));
        return Outcome::Interrupted;
    }
    if let Some(unconstrained) = &solved.unconstrained {
        console.warn(&format!("{unconstrained}"));
        return Outcome::Undetermined;
    }
    if solved.falls_apart() {
        console.warn(&format!(
            "nothing joins the {} parts of the graph: each is solved by itself, and has no place relative to the others",
            solved.parts
        ));
        return Outcome::Undetermined;
    }
    if solved.report.converged() { Outcome::Done } else { Outcome::NotConverged }
}
