//! Samples with their times, and what was odd about them.

use core::fmt;
use std::vec::Vec;

/// Nanoseconds of a second.
pub(crate) const SECOND: f64 = 1e9;

/// Something, and when it was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stamped<T> {
    /// Nanoseconds since the epoch of the recording's clock. Whole numbers: in seconds since 1970 an `f64` resolves a quarter of a
    /// microsecond only.
    pub stamp_ns: i64,
    /// What.
    pub value: T,
}

impl<T> Stamped<T> {
    /// The same time, another value.
    pub fn map<U>(&self, f: impl FnOnce(&T) -> U) -> Stamped<U> {
        Stamped { stamp_ns: self.stamp_ns, value: f(&self.value) }
    }

    /// Seconds since `start_ns`.
    pub fn seconds_since(&self, start_ns: i64) -> f64 {
        seconds(start_ns, self.stamp_ns)
    }
}

/// Seconds between two stamps; whole before they become a float.
pub fn seconds(from_ns: i64, to_ns: i64) -> f64 {
    to_ns.saturating_sub(from_ns) as f64 / SECOND
}

/// What one sensor recorded, in order of time.
#[derive(Clone, Debug, PartialEq)]
pub struct Log<T> {
    /// By time; samples of one time in the order of the file.
    pub samples: Vec<Stamped<T>>,
    /// What was odd but could be handled.
    pub oddities: Vec<Oddity>,
}

/// Something odd about a log, and what was done about it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Oddity {
    /// Rows that were not in order of time, by less than a second: sorted.
    OutOfOrder {
        /// How many.
        rows: usize,
        /// Line of the first.
        line: u32,
    },
    /// Rows with a number that is NaN, infinite or absent: left out.
    Missing {
        /// How many.
        rows: usize,
        /// Line of the first.
        line: u32,
    },
    /// Steps of time far longer than usual. A filter that holds its input over them is told so by nobody else.
    Gaps {
        /// How many.
        count: usize,
        /// The longest, in seconds.
        longest: f64,
        /// Line after the longest.
        line: u32,
        /// The median step, in seconds.
        usual: f64,
    },
    /// An angle beyond a turn, or a rate beyond what gyroscopes measure (35 rad/s = 2000°/s): degrees? Taken as it is.
    Degrees {
        /// The field.
        field: &'static str,
        /// Line of the first.
        line: u32,
        /// The number there.
        value: f64,
    },
    /// Specific forces of a typical length far below 9.81: multiples of g? Taken as they are.
    MultiplesOfG {
        /// The median of their lengths.
        median: f64,
    },
    /// A quaternion whose norm is off by more than a thousandth: normalised.
    QuaternionNorm {
        /// How many.
        rows: usize,
        /// Line of the first.
        line: u32,
    },
}

impl fmt::Display for Oddity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::OutOfOrder { rows, line } => {
                write!(f, "line {line}: {rows} rows are earlier than the row before; sorted")
            }
            Self::Missing { rows, line } => {
                write!(f, "line {line}: {rows} rows with NaN, infinite or absent numbers; left out")
            }
            Self::Gaps { count, longest, line, usual } => write!(
                f,
                "line {line}: a gap of {longest:.3} s where {usual:.4} s is usual; the longest of {count}"
            ),
            Self::Degrees { field, line, value } => {
                write!(f, "line {line}: {field} is {value}; radians are expected, are these degrees?")
            }
            Self::MultiplesOfG { median } => write!(
                f,
                "specific forces are {median:.3} long; m/s² are expected, are these multiples of g?"
            ),
            Self::QuaternionNorm { rows, line } => {
                write!(f, "line {line}: {rows} quaternions are not of unit norm; normalised")
            }
        }
    }
}

impl<T> Log<T> {
    /// The same log of other values.
    pub fn map<U>(&self, mut f: impl FnMut(&T) -> U) -> Log<U> {
        let samples = self.samples.iter().map(|sample| sample.map(&mut f)).collect();
        Log { samples, oddities: self.oddities.clone() }
    }

    /// Every `n`-th sample, from the first on.
    pub fn every(&self, n: usize) -> Self
    where
        T: Clone,
    {
        Self {
            samples: self.samples.iter().step_by(n.max(1)).cloned().collect(),
            oddities: self.oddities.clone(),
        }
    }

    /// The samples of `start_ns ≤ time ≤ end_ns`.
    pub fn between(&self, start_ns: i64, end_ns: i64) -> &[Stamped<T>] {
        let from = self.samples.partition_point(|sample| sample.stamp_ns < start_ns);
        let to = self.samples.partition_point(|sample| sample.stamp_ns <= end_ns);
        &self.samples[from..to.max(from)]
    }
}
