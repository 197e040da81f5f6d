//! `boxplus consistency`: can the covariance of a filter be believed?

use std::fmt::Write;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::thread;
use std::time::Instant;

use boxplus::filter::{MonteCarlo, Report, Rule, Series, Simulation, Trial, Verdict};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum, ValueHint};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

use crate::args::Global;
use crate::draw::{Chart, Strip};
use crate::error::{Error, Outcome};
use crate::interrupt;
use crate::output::{Console, DIM, GOOD, STRONG, WARN, document};
use crate::plot::{Picture, save_svg};
use crate::pose::args::SideName;
use crate::progress::Progress;
use crate::text::{count, duration, grouped, significant};

pub const EXAMPLES: &str = "\
Examples:
  boxplus consistency beacons                                        the recommended filter: iterated, with reset
  boxplus consistency beacons --filter extended --no-reset --runs 1000
  boxplus consistency gnss --side global --plot nees.svg
  boxplus consistency attitude --filter unscented --json | jq '.series[0].verdict'

A truth is drawn from the prior, moves by the model and is measured, with noise of the size that the filter is told; so whatever
is wrong is the filter. NEES is the square of the state's error, NIS that of an innovation, both by the covariance the filter
claims: on average the number of coordinates n, if it can be believed. Ctrl-C reports the runs that were made.";

/// Options of `consistency`.
#[derive(Args, Debug)]
pub struct Consistency {
    /// What is simulated.
    #[arg(value_name = "SIMULATION", value_parser = simulation())]
    pub simulation: Simulation,
    /// How many runs.
    #[arg(long, value_name = "N", default_value = "200")]
    pub runs: NonZeroUsize,
    /// The filter.
    #[arg(long, value_name = "NAME", default_value = "iterated")]
    pub filter: FilterName,
    /// Side of its errors: local is the left-, global the right-invariant filter.
    #[arg(long, value_name = "SIDE", default_value = "local")]
    pub side: SideName,
    /// Leave the covariance as it is when a correction moves the mean.
    #[arg(long)]
    pub no_reset: bool,
    /// Probability of the bands.
    #[arg(long, value_name = "P", default_value = "0.95", value_parser = probability)]
    pub confidence: f64,
    /// Draw NEES and NIS over time with their bands, as .svg or .png.
    #[arg(long, value_name = "PICTURE", value_hint = ValueHint::FilePath)]
    pub plot: Option<PathBuf>,
}

/// See [`Rule`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FilterName {
    /// Extended, linearised until it settles
    Iterated,
    /// Extended, linearised once
    Extended,
    /// Unscented
    Unscented,
}

fn simulation() -> impl TypedValueParser<Value = Simulation> {
    let names = Simulation::ALL.map(|world| PossibleValue::new(world.name()).help(world.description()));
    PossibleValuesParser::new(names).try_map(|name| name.parse())
}

fn probability(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(p) if p > 0.0 && p < 1.0 => Ok(p),
        _ => Err("must be a number between 0 and 1".to_owned()),
    }
}

/// Simulates, judges and reports.
pub fn run(options: &Consistency, global: &Global, console: Console) -> Result<Outcome, Error> {
    let picture = options.plot.as_deref().map(Picture::of).transpose()?;
    interrupt::watch();
    let trial = Trial {
        rule: match options.filter {
            FilterName::Iterated => Rule::Iterated,
            FilterName::Extended => Rule::Extended,
            FilterName::Unscented => Rule::Unscented,
        },
        global: options.side == SideName::Global,
        reset: !options.no_reset,
    };
    let experiment = MonteCarlo {
        runs: options.runs.get(),
        seed: global.seed.unwrap_or(0),
        confidence: options.confidence,
        threads: global.threads.or_else(|| thread::available_parallelism().ok()).unwrap_or(NonZeroUsize::MIN),
    };
    let started = Instant::now();
    let report = simulated(options.simulation, trial, &experiment, console)?;
    let told =
        Told { options, experiment: &experiment, report: &report, seconds: started.elapsed().as_secs_f64() };
    let Some(state) = report.series("state") else {
        return Err(Error::Undetermined {
            message: "stopped before one run was finished".to_owned(),
            help: Some("take fewer runs with --runs".to_owned()),
        });
    };
    if console.is_json() {
        document(&told.document())?;
    } else {
        console.say(told.screen().trim_end())?;
    }
    if let Some((path, picture)) = options.plot.as_deref().zip(picture) {
        save_svg(&told.chart().svg(), picture, path, console)?;
    }
    Ok(if state.runs < experiment.runs { Outcome::Interrupted } else { Outcome::Done })
}

fn simulated(
    world: Simulation,
    trial: Trial,
    experiment: &MonteCarlo,
    console: Console,
) -> Result<Report, Error> {
    let progress = Progress::start(console, "the first run");
    let proceed = |finished: usize| {
        progress.now(format!("{} of {} runs", grouped(finished), grouped(experiment.runs)));
        !interrupt::asked()
    };
    world.run::<ChaCha8Rng>(trial, experiment, proceed).map_err(|error| Error::Undetermined {
        message: format!("the filter broke down: {error}"),
        help: None,
    })
}

/// A report and where it comes from.
struct Told<'a> {
    options: &'a Consistency,
    experiment: &'a MonteCarlo,
    report: &'a Report,
    seconds: f64,
}

impl Told<'_> {
    fn filter(&self) -> String {
        let Consistency { filter, side, no_reset, .. } = self.options;
        let reset = if *no_reset { "no reset" } else { "with reset" };
        format!("{filter:?} filter, {side:?} errors, {reset}").to_lowercase()
    }

    fn runs(&self) -> usize {
        self.report.series.iter().map(|series| series.runs).max().unwrap_or(0)
    }

    fn screen(&self) -> String {
        let (world, percent) = (self.options.simulation, 100.0 * self.experiment.confidence);
        let mut out = format!("{STRONG}{world}{STRONG:#}  {}\n", world.description());
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "{DIM}{}, {} from seed {}, {}{DIM:#}\n",
            self.filter(),
            count(self.runs(), "run", "runs"),
            self.experiment.seed,
            duration(self.seconds)
        );
        let _ = writeln!(
            out,
            "{DIM}{:<24} {:>3}  {:>16}  {:>15}  {:>6}  verdict{DIM:#}",
            "",
            "n",
            "mean",
            format!("{} % band", significant(percent, 3)),
            "inside"
        );
        for series in &self.report.series {
            let style = if series.verdict() == Verdict::Consistent { GOOD } else { WARN };
            let [low, high] = series.interval;
            let _ = writeln!(
                out,
                "{:<24} {:>3}  {:>16}  {:>15}  {:>4.0} %  {style}{}{style:#}",
                label(series),
                series.dimension,
                format!("{:.3} ± {:.3}", series.mean, series.standard_error),
                format!("{low:.3} – {high:.3}"),
                100.0 * series.share_inside(),
                word(series.verdict())
            );
        }
        if let Some(state) = self.report.series("state") {
            let errors = state.rmse_of_coordinates.iter().zip(world.coordinates());
            let errors: Vec<_> = errors.map(|(rmse, name)| with_unit(name, *rmse)).collect();
            let _ = writeln!(out, "\nRMSE  {}", errors.join(", "));
            let _ = writeln!(out, "\n{}", conclusion(state));
        }
        if self.report.refused > 0 {
            let _ = writeln!(out, "{WARN}{} measurements were refused{WARN:#}", self.report.refused);
        }
        out
    }

    fn document(&self) -> Value {
        let series: Vec<_> = self
            .report
            .series
            .iter()
            .map(|series| {
                json!({
                    "name": series.name,
                    "statistic": if series.name == "state" { "NEES" } else { "NIS" },
                    "dimension": series.dimension,
                    "runs": series.runs,
                    "mean": series.mean,
                    "standard_error": series.standard_error,
                    "band": series.interval,
                    "share_inside": series.share_inside(),
                    "rmse": series.rmse_of_coordinates,
                    "verdict": word(series.verdict()),
                    "mean_by_time": series.mean_by_time,
                })
            })
            .collect();
        json!({
            "format": "boxplus.consistency",
            "version": 1,
            "simulation": self.options.simulation.name(),
            "filter": self.filter(),
            "runs": self.runs(),
            "runs_wanted": self.experiment.runs,
            "seed": self.experiment.seed,
            "confidence": self.experiment.confidence,
            "coordinates": self.options.simulation.coordinates(),
            "seconds": self.seconds,
            "refused": self.report.refused,
            "series": series,
        })
    }

    fn chart(&self) -> Chart {
        let strips = self.report.series.iter().map(|series| Strip {
            heading: label(series),
            note: format!("{:.3} ± {:.3}: {}", series.mean, series.standard_error, word(series.verdict())),
            values: series.mean_by_time.clone(),
            expected: series.dimension as f64,
            band: series.interval,
        });
        Chart {
            title: self.options.simulation.description().to_owned(),
            facts: format!("{}, {}", self.filter(), count(self.runs(), "run", "runs")),
            strips: strips.collect(),
        }
    }
}

fn label(series: &Series) -> String {
    if series.name == "state" { "NEES of the state".to_owned() } else { format!("NIS of {}", series.name) }
}

fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Consistent => "consistent",
        Verdict::Overconfident => "overconfident",
        Verdict::Underconfident => "underconfident",
    }
}

/// `θ 1.2°`, `ρ₁ 0.1 m`.
fn with_unit(coordinate: &str, value: f64) -> String {
    let (name, unit) = coordinate.split_once(' ').unwrap_or((coordinate, ""));
    match unit {
        "rad" => format!("{name} {}°", significant(value.to_degrees(), 3)),
        "rad/s" => format!("{name} {}°/s", significant(value.to_degrees(), 3)),
        unit => format!("{name} {} {unit}", significant(value, 3)),
    }
}

/// The verdict in words.
fn conclusion(state: &Series) -> String {
    let ratio = (state.mean / state.dimension as f64).sqrt();
    match state.verdict() {
        Verdict::Consistent => {
            "The covariance can be believed: no contradiction at this number of runs.".to_owned()
        }
        Verdict::Overconfident => format!(
            "Overconfident: errors are {} times as large as the filter claims.",
            significant(ratio, 3)
        ),
        Verdict::Underconfident => format!(
            "Underconfident: errors are {} times as large as the filter claims.",
            significant(ratio, 3)
        ),
    }
}
