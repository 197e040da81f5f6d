//! `boxplus align`: two clouds laid upon each other.

mod picture;
mod report;
mod start;

use std::fs;
use std::io::{self, Read};
use std::path::Path;
use std::time::Instant;

use boxplus::io::cloud::{self, Cloud};
use boxplus::lie::{SE2, SE3};
use boxplus::registration::{Icp, Preparation, Registered, RegistrationError, Scan, Termination};
use nalgebra::{SVector, Vector2, Vector3};

use crate::args::{Align, Global};
use crate::error::{Error, Outcome};
use crate::output::{self, Console, is_standard};
use crate::plot::{self, Picture};
use crate::progress::Progress;
use report::{AlignDocument, Seconds};
use start::Motion;

/// A cloud and where it comes from.
struct Loaded {
    name: String,
    cloud: Cloud,
}

/// Gate in voxels, where none is given: what small_gicp has by default, 1 m for 0.25 m.
const GATE: f64 = 4.0;

/// Reads, aligns, reports and writes.
pub fn run(options: &Align, global: &Global, console: Console) -> Result<Outcome, Error> {
    let started = Instant::now();
    let picture = options.plot.as_deref().map(Picture::of).transpose()?;
    let console = console.beside(options.output.as_deref())?;
    let [source, target] = [&options.source, &options.target].map(|path| load(path, options, console));
    let (source, target) = (source?, target?);
    let job = Job { options, global, console, picture, source, target, started };
    if options.planar || (job.source.cloud.planar && job.target.cloud.planar) {
        let chart = Chart { into: |p| Vector2::new(p.x, p.y), out: |p| Vector3::new(p.x, p.y, 0.0) };
        job.run::<SE2, 3, 2>(chart)
    } else {
        job.run::<SE3, 6, 3>(Chart { into: |p| *p, out: |p| *p })
    }
}

fn load(path: &Path, options: &Align, console: Console) -> Result<Loaded, Error> {
    let name = if is_standard(path) { "<stdin>".to_owned() } else { path.display().to_string() };
    let bytes = bytes(path).map_err(|source| Error::Read { path: name.clone().into(), source })?;
    let cloud = cloud::read(&bytes, &name, options.from).map_err(|error| Error::parsing(&error, &bytes))?;
    if cloud.dropped > 0 {
        console.warn(&format!("{name}: {} points are not finite and left out", cloud.dropped));
    }
    Ok(Loaded { name, cloud })
}

fn bytes(path: &Path) -> io::Result<Vec<u8>> {
    if is_standard(path) {
        let mut bytes = Vec::new();
        io::stdin().lock().read_to_end(&mut bytes)?;
        return Ok(bytes);
    }
    fs::read(path)
}

/// From a point of a file to a point of the group, and back.
#[derive(Clone, Copy)]
struct Chart<const N: usize> {
    into: fn(&Vector3<f64>) -> SVector<f64, N>,
    out: fn(&SVector<f64, N>) -> Vector3<f64>,
}

/// Everything that is asked for.
struct Job<'a> {
    options: &'a Align,
    global: &'a Global,
    console: Console,
    picture: Option<Picture>,
    source: Loaded,
    target: Loaded,
    started: Instant,
}

impl Job<'_> {
    /// In the plane or in space.
    fn run<G: Motion<D, N>, const D: usize, const N: usize>(
        &self,
        chart: Chart<N>,
    ) -> Result<Outcome, Error> {
        let loaded = self.started.elapsed().as_secs_f64();
        let threads = self.global.threads.map_or(0, usize::from);
        let preparation =
            Preparation { voxel: self.options.voxel, neighbours: self.options.neighbours, threads };
        let progress = Progress::start(self.console, "finding normals");
        let [source, target] = [&self.source, &self.target].map(|loaded| {
            let points: Vec<_> = loaded.cloud.points.iter().map(chart.into).collect();
            Scan::new(&points, &preparation).map_err(|error| refusal(&loaded.name, &error))
        });
        let (source, target) = (source?, target?);
        let prepared = self.started.elapsed().as_secs_f64();
        progress.now("aligning".to_owned());
        let initial = start::read::<G, D, N>(self.options.init.as_deref(), &source, &target)?;
        let icp = self.icp(target.spacing(), threads);
        let names = format!("{} onto {}", self.source.name, self.target.name);
        let found = source.align(&target, &initial, &icp).map_err(|error| refusal(&names, &error))?;
        drop(progress);
        let total = self.started.elapsed().as_secs_f64();
        let seconds = Seconds { load: loaded, prepare: prepared - loaded, align: total - prepared, total };
        let mut document =
            AlignDocument::new(self, &icp, &found, (source.points().len(), target.points().len()));
        document.seconds = seconds;
        if !self.console.is_json() {
            self.console.say(&document.screen())?;
        }
        self.write(&mut document, &found, (&source, &target, &initial), chart)?;
        if self.console.is_json() {
            output::document(&document)?;
        }
        Ok(self.outcome(&found))
    }

    fn icp(&self, spacing: f64, threads: usize) -> Icp {
        let usual = if self.options.voxel > 0.0 { GATE * self.options.voxel } else { 10.0 * spacing };
        Icp {
            method: self.options.method,
            max_distance: self.options.max_distance.unwrap_or(usual),
            kernel: self.options.robust.unwrap_or_default(),
            max_iterations: self.options.max_iterations,
            threads,
            ..Icp::default()
        }
    }

    /// The moved source and the picture, where they are asked for.
    fn write<G: Motion<D, N>, const D: usize, const N: usize>(
        &self,
        document: &mut AlignDocument,
        found: &Registered<G, D>,
        (source, target, initial): (&Scan<N>, &Scan<N>, &G),
        Chart { into, out }: Chart<N>,
    ) -> Result<(), Error> {
        if let Some(path) = self.options.output.as_deref() {
            let moved = |p: &Vector3<f64>| out(&found.target_from_source.act(&into(p)));
            let moved: Vec<_> = self.source.cloud.points.iter().map(moved).collect();
            let unwritable =
                |error| Error::Unwritable { message: format!("{} is not written: {error}", path.display()) };
            self.console.write(path, &cloud::write_ply(&moved).map_err(unwritable)?)?;
            document.outputs.push(path.display().to_string());
        }
        if let Some((path, picture)) = self.options.plot.as_deref().zip(self.picture) {
            let view = |x: &G| -> Vec<Vector3<f64>> { source.points().map(|p| out(&x.act(&p))).collect() };
            let still = target.points().map(|q| out(&q)).collect();
            let figure = picture::figure(document, still, [view(initial), view(&found.target_from_source)]);
            plot::save(&figure, picture, path, self.console)?;
            document.outputs.push(path.display().to_string());
        }
        Ok(())
    }

    fn outcome<G, const D: usize>(&self, found: &Registered<G, D>) -> Outcome {
        if !found.free.is_empty() {
            self.console.warn("no surface sees the free directions: the start is kept along them");
            Outcome::Undetermined
        } else if found.termination == Termination::MaxIterations {
            self.console.warn("not converged; --max-iterations allows more steps");
            Outcome::NotConverged
        } else {
            Outcome::Done
        }
    }
}

/// Why the library would not align, for the user.
fn refusal(name: &str, error: &RegistrationError) -> Error {
    let message = format!("{name}: {error}");
    let help = |text: &str| Some(text.to_owned());
    match error {
        RegistrationError::NoOverlap { .. } => {
            Error::Undetermined { message, help: help("--init gives a start, --max-distance looks farther") }
        }
        RegistrationError::VoxelSize { .. } => {
            Error::Usage { message, help: help("--voxel takes the edge of a cube in the units of the cloud") }
        }
        RegistrationError::NoNormals { .. } => {
            Error::Usage { message, help: help("--neighbours 10, or --method point") }
        }
        RegistrationError::NotAnOption { option: "max_distance", .. } => {
            Error::Usage { message, help: help("--max-distance says how far apart partners may be") }
        }
        RegistrationError::NotAnOption { .. } | RegistrationError::NotAKernel => {
            Error::Usage { message, help: None }
        }
        RegistrationError::InitialNotFinite => {
            Error::Usage { message, help: help("--init takes finite numbers") }
        }
        _ => Error::Unreadable { message, help: None },
    }
}
