//! The boxplus command line: flags and files in, a call of the library, a report out.
#![allow(unreachable_pub, reason = "a program has no outside: `pub` is what other modules use")]

mod align;
mod args;
mod before_after;
mod bundle;
mod choices;
mod consistency;
mod convert;
mod diagnose;
mod document;
mod error;
mod excerpt;
mod filter;
mod info;
mod input;
mod interrupt;
mod output;
mod plot;
mod pose;
mod progress;
mod refusal;
mod report;
mod settings;
mod simulate;
mod solve;

use std::process::ExitCode;

use args::{Cli, Completions, Verb};
use boxplus_cli::{draw, text};
use clap::{CommandFactory, Parser};
use error::{Error, Outcome};
use output::Console;

fn main() -> ExitCode {
    let cli = Cli::parse();
    match run(&cli) {
        Ok(outcome) => outcome.exit_code(),
        Err(error) if error.is_broken_pipe() => ExitCode::SUCCESS,
        Err(error) => error.report(),
    }
}

fn run(cli: &Cli) -> Result<Outcome, Error> {
    let global = &cli.global;
    let console = Console::new(global.json, global.quiet, global.verbose);
    match &cli.verb {
        Verb::Solve(options) => return solve::run(options, global, console),
        Verb::Align(options) => return align::run(options, global, console),
        Verb::Diagnose(options) => return diagnose::run(options, global, console),
        Verb::Filter(options) => return filter::run(options, console),
        Verb::Consistency(options) => return consistency::run(options, global, console),
        Verb::Info(options) => info::run(options, global, console)?,
        Verb::Convert(options) => convert::run(options, global, console)?,
        Verb::Simulate(options) => simulate::run(options, global, console)?,
        Verb::Plot(options) => plot::run(options, global, console)?,
        Verb::Pose(options) => pose::run(options, console)?,
        Verb::Completions(options) => completions(options)?,
    }
    Ok(Outcome::Done)
}

fn completions(options: &Completions) -> Result<(), Error> {
    let mut script = Vec::new();
    clap_complete::generate(options.shell, &mut Cli::command(), "boxplus", &mut script);
    output::write("-".as_ref(), &script)
}
