//! Inputs and measurements of several clocks as one sequence.

use super::log::{Stamped, seconds};

/// What happens next on a [`timeline`].
#[derive(Debug, PartialEq)]
pub enum Event<'a, I, Z> {
    /// Time passes while an input holds.
    Step {
        /// u.
        input: &'a I,
        /// How long, in seconds; positive.
        duration: f64,
        /// When it ends.
        end_ns: i64,
    },
    /// A measurement is made.
    Seen {
        /// What it says.
        value: &'a Z,
        /// When.
        stamp_ns: i64,
    },
}

/// Inputs that hold until the next one, cut where measurements fall between, and the measurements, in order of time.
///
/// Begins with the first input and ends with the last one, whose own duration nobody knows; measurements before and after are
/// left out. At one time, measurements come after the step that ends there. Both slices must be in order of time, as those of a
/// [`Log`](super::Log) are.
///
/// ```
/// use boxplus::recording::{Event, Stamped, timeline};
/// let at = |seconds: i64, value| Stamped { stamp_ns: seconds * 1_000_000_000, value };
/// let inputs = [at(0, "drive"), at(10, "turn"), at(20, "stop")];
/// let told: Vec<String> = timeline(&inputs, &[at(4, "beacon"), at(10, "wall")])
///     .map(|event| match event {
///         Event::Step { input, duration, .. } => format!("{input} {duration} s"),
///         Event::Seen { value, .. } => value.to_string(),
///     })
///     .collect();
/// assert_eq!(told, ["drive 4 s", "beacon", "drive 6 s", "wall", "turn 10 s"]);
/// ```
pub fn timeline<'a, I, Z>(
    inputs: &'a [Stamped<I>],
    seen: &'a [Stamped<Z>],
) -> impl Iterator<Item = Event<'a, I, Z>> {
    let start_ns = inputs.first().map_or(i64::MAX, |input| input.stamp_ns);
    let early = seen.partition_point(|z| z.stamp_ns < start_ns);
    Timeline { inputs, seen: &seen[early..], now_ns: start_ns }
}

struct Timeline<'a, I, Z> {
    /// From the one that holds on.
    inputs: &'a [Stamped<I>],
    /// Those to come.
    seen: &'a [Stamped<Z>],
    now_ns: i64,
}

impl<'a, I, Z> Iterator for Timeline<'a, I, Z> {
    type Item = Event<'a, I, Z>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some((z, rest)) = self.seen.split_first().filter(|(z, _)| z.stamp_ns <= self.now_ns) {
                self.seen = rest;
                return Some(Event::Seen { value: &z.value, stamp_ns: z.stamp_ns });
            }
            let (input, rest) = self.inputs.split_first()?;
            let until_ns = rest.first()?.stamp_ns;
            if until_ns <= self.now_ns {
                self.inputs = rest;
                continue;
            }
            let end_ns = self.seen.first().map_or(until_ns, |z| z.stamp_ns.min(until_ns));
            let duration = seconds(self.now_ns, end_ns);
            self.now_ns = end_ns;
            return Some(Event::Step { input: &input.value, duration, end_ns });
        }
    }
}
