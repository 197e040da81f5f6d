//! What every driver shares: the inputs, and one operation evaluated, timed or counted. `README.md` has the protocol.
//!
//! Numbers cross in the convention of boxplus: tangents (ρ, θ, …), right Jacobians by rows, elements as (rotation, …) with
//! a rotation as (cos, sin) or a quaternion xyzw, and the logarithm of a scale. A driver converts, outside of what is timed.
use std::{
    fs,
    hint::black_box,
    path::PathBuf,
    time::{Duration, Instant},
};

/// How long one operation is measured in one process, and the sweeps it takes at least.
const BUDGET: Duration = Duration::from_millis(4);
const SWEEPS: usize = 7;

/// Numbers per row: of a tangent, a point, an element.
pub const LAYOUTS: [(&str, [usize; 3]); 8] = [
    ("SO2", [1, 2, 2]),
    ("SE2", [3, 2, 4]),
    ("SO3", [3, 3, 4]),
    ("SE3", [6, 3, 7]),
    ("SE23", [9, 3, 10]),
    ("SGal3", [10, 4, 11]),
    ("Sim2", [4, 2, 5]),
    ("Sim3", [7, 3, 8]),
];

enum Mode {
    /// Writes the results of every operation to a folder.
    Eval(PathBuf),
    /// Prints the least and the median nanoseconds per call of every operation.
    Time,
    /// Runs every operation once over all inputs inside a function that callgrind watches.
    Count,
}

/// The command line of a driver: `eval INPUTS OUTPUTS`, `time INPUTS` or `count INPUTS`.
pub struct Driver {
    mode: Mode,
    inputs: PathBuf,
}

impl Driver {
    /// # Panics
    /// On any other command line.
    #[must_use]
    pub fn from_args() -> Self {
        let args: Vec<String> = std::env::args().skip(1).collect();
        let mode = match args[0].as_str() {
            "eval" => Mode::Eval(PathBuf::from(&args[2])),
            "time" => Mode::Time,
            "count" => Mode::Count,
            other => panic!("{other} is none of eval, time, count"),
        };
        Self { mode, inputs: PathBuf::from(&args[1]) }
    }

    /// The inputs of a group; none where the harness asks for no operation of it.
    ///
    /// # Panics
    /// If the group is unknown or its file is cut short.
    #[must_use]
    pub fn bench(&self, group: &'static str, scalar: &'static str) -> Option<Bench<'_>> {
        let (_, [d, n, e]) = LAYOUTS.into_iter().find(|(name, _)| *name == group).expect("a group");
        let bytes = fs::read(self.inputs.join(format!("{group}.{scalar}"))).ok()?;
        let (numbers, _) = bytes.as_chunks::<8>();
        let numbers: Vec<f64> = numbers.iter().map(|x| f64::from_le_bytes(*x)).collect();
        let mut bench = Bench { driver: self, group, scalar, tau: vec![], point: vec![], a: vec![], b: vec![] };
        for row in numbers.chunks_exact(d + n + 2 * e) {
            let (tau, rest) = row.split_at(d);
            let (point, rest) = rest.split_at(n);
            let (a, b) = rest.split_at(e);
            bench.tau.push(tau.to_vec());
            bench.point.push(point.to_vec());
            bench.a.push(a.to_vec());
            bench.b.push(b.to_vec());
        }
        bench.cell("empty", |i| i, |_| vec![]);
        Some(bench)
    }
}

/// The inputs of one group in one scalar type, and what becomes of each of its operations.
pub struct Bench<'a> {
    driver: &'a Driver,
    group: &'static str,
    scalar: &'static str,
    pub tau: Vec<Vec<f64>>,
    pub point: Vec<Vec<f64>>,
    pub a: Vec<Vec<f64>>,
    pub b: Vec<Vec<f64>>,
}

impl Bench<'_> {
    /// One operation, called with the number of a row; `flat` brings its result into the common convention.
    ///
    /// # Panics
    /// If results cannot be written.
    pub fn cell<R>(&self, operation: &str, call: impl Fn(usize) -> R, flat: impl Fn(R) -> Vec<f64>) {
        let results = || (0..self.a.len()).flat_map(|i| flat(call(i))).collect();
        let sweep = |rows| {
            for i in 0..rows {
                black_box(&call(black_box(i))); // by reference: a Jacobian is not copied once more
            }
        };
        self.run(operation, results, sweep);
    }

    /// One operation on all rows by one call, which fills a slice.
    ///
    /// # Panics
    /// If results cannot be written.
    pub fn batch<R: Clone>(&self, operation: &str, first: &R, call: impl Fn(&mut [R]), flat: impl Fn(R) -> Vec<f64>) {
        let all = std::cell::RefCell::new(vec![first.clone(); self.a.len()]);
        let fill = || call(&mut all.borrow_mut());
        let results = || {
            fill();
            all.borrow().iter().cloned().flat_map(&flat).collect()
        };
        self.run(&format!("{operation}_batch"), results, |_| fill());
    }

    /// What the mode asks for, of an operation by its results and by a sweep over a number of rows.
    fn run(&self, operation: &str, results: impl Fn() -> Vec<f64>, sweep: impl Fn(usize)) {
        let name = format!("{}.{}.{operation}", self.group, self.scalar);
        let rows = self.a.len();
        match &self.driver.mode {
            Mode::Eval(folder) => {
                let bytes: Vec<u8> = results().into_iter().flat_map(f64::to_le_bytes).collect();
                fs::write(folder.join(name), bytes).expect("the folder of the results");
            }
            Mode::Time => {
                let (least, median) = time(rows, || sweep(rows));
                println!("{name} {least:.3} {median:.3}");
            }
            Mode::Count => {
                println!("{name} {rows}");
                sweep_counted(|| sweep(rows));
            }
        }
    }
}

/// The least and the median nanoseconds per row over sweeps.
fn time(rows: usize, sweep: impl Fn()) -> (f64, f64) {
    let (begin, mut sweeps) = (Instant::now(), vec![]);
    while sweeps.len() < SWEEPS || begin.elapsed() < BUDGET {
        let start = Instant::now();
        sweep();
        #[expect(clippy::cast_precision_loss)]
        sweeps.push(start.elapsed().as_secs_f64() * 1e9 / rows as f64);
    }
    sweeps.sort_by(f64::total_cmp);
    (sweeps[0], sweeps[sweeps.len() / 2])
}

/// What callgrind counts: it starts and dumps at this name.
#[inline(never)]
fn sweep_counted(sweep: impl Fn()) {
    sweep();
    black_box(()); // no tail call: the function must be left
}

/// Where the coordinates of boxplus stand among those of a peer: ours k is theirs `self.0[k]`.
#[derive(Clone, Copy)]
pub struct Order(pub &'static [usize]);

impl Order {
    /// A vector of ours in their order.
    #[must_use]
    pub fn theirs(self, ours: &[f64]) -> Vec<f64> {
        let mut theirs = vec![0.0; ours.len()];
        self.0.iter().zip(ours).for_each(|(k, x)| theirs[*k] = *x);
        theirs
    }
    /// A vector of theirs in our order.
    #[must_use]
    pub fn vector(self, theirs: impl Fn(usize) -> f64) -> Vec<f64> {
        self.0.iter().map(|k| theirs(*k)).collect()
    }
    /// A square matrix of theirs in our order, by rows.
    #[must_use]
    pub fn matrix(self, theirs: impl Fn(usize, usize) -> f64) -> Vec<f64> {
        self.0.iter().flat_map(|i| self.0.iter().map(|j| theirs(*i, *j)).collect::<Vec<_>>()).collect()
    }
    /// A matrix of theirs with columns in our order, by rows.
    #[must_use]
    pub fn columns(self, rows: usize, theirs: impl Fn(usize, usize) -> f64) -> Vec<f64> {
        (0..rows).flat_map(|i| self.0.iter().map(|j| theirs(i, *j)).collect::<Vec<_>>()).collect()
    }
}
