//! What the drivers of the Rust peers share: the command line, the stopwatch and the report of `drivers/record.py`.

use std::{
    any::Any,
    env, fs, io,
    panic::{AssertUnwindSafe, catch_unwind},
    path::PathBuf,
    time::{Duration, Instant},
};

use cpu_time::ProcessTime;

/// `GRAPH.g2o METHOD POSES [MAX_ITERATIONS]`.
#[derive(Debug)]
pub struct Arguments {
    /// The pose graph: vertices 0 … n−1 in order, then edges.
    pub graph: PathBuf,
    /// The algorithm.
    pub method: String,
    /// Where the poses of the recorded states go.
    pub poses: PathBuf,
    /// The solver's own default if absent.
    pub max_iterations: Option<usize>,
}

impl Arguments {
    /// Reads the process's arguments.
    ///
    /// # Errors
    /// If one is missing or the last is no number.
    pub fn parse() -> io::Result<Self> {
        let invalid = |message: &str| io::Error::new(io::ErrorKind::InvalidInput, message);
        let mut arguments = env::args().skip(1);
        let mut next = |name: &str| arguments.next().ok_or_else(|| invalid(&format!("missing argument {name}")));
        Ok(Self {
            graph: next("GRAPH")?.into(),
            method: next("METHOD")?,
            poses: next("POSES")?.into(),
            max_iterations: next("MAX_ITERATIONS")
                .ok()
                .map(|text| text.parse().map_err(|_| invalid("MAX_ITERATIONS is no number")))
                .transpose()?,
        })
    }
}

/// The number of threads to use, `PEERS_THREADS` of the environment: one unless given.
pub fn threads() -> usize {
    env::var("PEERS_THREADS").ok().and_then(|text| text.parse().ok()).unwrap_or(1)
}

/// Bytes that the process has (`VmRSS`), or had at most since the mark was reset (`VmHWM`).
fn memory(field: &str) -> usize {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix(field)).unwrap_or_default();
    line.split_whitespace().nth(1).and_then(|kilobytes| kilobytes.parse::<usize>().ok()).unwrap_or(0) * 1024
}

/// A stopwatch of CPU and wall time that stands still while states are copied, and the growth of the memory.
#[derive(Debug, Default)]
pub struct Recorder {
    elapsed: [Duration; 2],
    started: Option<(ProcessTime, Instant)>,
    before: Option<usize>,
    peak: usize,
    records: Vec<String>,
    states: Vec<f64>,
}

impl Recorder {
    /// Lets the time run.
    pub fn start(&mut self) {
        if self.before.is_none() {
            let _ = fs::write("/proc/self/clear_refs", "5"); // the mark of the high water
            self.before = Some(memory("VmRSS"));
        }
        self.started = Some((ProcessTime::now(), Instant::now()));
    }

    /// Holds the time.
    pub fn stop(&mut self) {
        if let Some((cpu, wall)) = self.started.take() {
            self.elapsed[0] += cpu.elapsed();
            self.elapsed[1] += wall.elapsed();
            let kept = self.before.unwrap_or(0) + size_of_val(self.states.as_slice());
            self.peak = self.peak.max(memory("VmHWM").saturating_sub(kept));
        }
    }

    /// Records a state at the time held: the coordinates of all poses in the order of their ids.
    pub fn keep(&mut self, iteration: usize, state: impl IntoIterator<Item = f64>) {
        let [cpu, wall] = self.seconds();
        self.records.push(format!("[{iteration}, {cpu}, {wall}]"));
        self.states.extend(state);
    }

    /// `stop`, `keep`, `start`: what an observer does.
    pub fn observe(&mut self, iteration: usize, state: impl IntoIterator<Item = f64>) {
        self.stop();
        self.keep(iteration, state);
        self.start();
    }

    /// Writes the states, prints the records.
    ///
    /// # Errors
    /// If the file of poses cannot be written.
    #[allow(clippy::print_stdout)]
    pub fn report(&self, status: &str, poses: &PathBuf) -> io::Result<()> {
        let bytes: Vec<u8> = self.states.iter().flat_map(|number| number.to_le_bytes()).collect();
        fs::write(poses, bytes)?;
        let [cpu, wall] = self.seconds();
        let (records, status) = (self.records.join(", "), status.replace(['"', '\\', '\n'], " "));
        let peak = self.peak;
        println!(r#"{{"status": "{status}", "records": [{records}], "total": [{cpu}, {wall}], "peak": {peak}}}"#);
        Ok(())
    }

    fn seconds(&self) -> [f64; 2] {
        self.elapsed.map(|duration| duration.as_secs_f64())
    }
}

/// Runs a solver; a panic of its becomes the status `Err("panic: …")`.
///
/// # Errors
/// If the solver panicked.
pub fn guarded<T>(solve: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(solve)).map_err(|payload| format!("panic: {}", message(payload.as_ref())))
}

fn message(payload: &(dyn Any + Send)) -> &str {
    payload
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| payload.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no message")
}
