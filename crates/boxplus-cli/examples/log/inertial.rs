//! An inertial sensor and positions of it as one batch problem: the whole past at once. Of the first state nothing is known but that the
//! positions are in a frame whose z axis points up.

use std::fmt::Write as _;
use std::time::Instant;

use boxplus::filter::ImuNoise as Densities;
use boxplus::graph::{
    Between, Graph, Inertial, InertialUnderGravity, Key, Noise, Position, Prior, Renewal, SolveOptions,
    Values, VariableId, inertial_start,
};
use boxplus::lie::{Manifold, S2, SE3, SE23};
use boxplus::recording::{Event, Fates, ImuReading, Score, Stamped, timeline};
use boxplus::trajectory::{Imu, ImuBias, ImuNoise, Preintegration};
use boxplus::uncertainty::{Covariance, Gaussian};
use nalgebra::{Matrix6, Vector3, Vector6};

use super::{Outcome, Row};

/// What is known.
#[derive(Clone, Debug)]
pub struct Batch {
    /// Σ of readings and of the walk of biases.
    pub densities: Densities,
    /// Of a position, in metres.
    pub fix_sigma: f64,
    /// The best guess, and its standard deviations: gyroscope, accelerometer.
    pub bias: ImuBias,
    pub bias_sigmas: [f64; 2],
    /// m/s², down.
    pub gravity: f64,
    /// Whether the direction of gravity is estimated, too.
    pub tilted: bool,
    legs: Vec<Leg>,
    /// Where states begin, by [`inertial_start`].
    start: Vec<SE23>,
    fixes: Vec<Option<Vector3<f64>>>,
    times: Vec<i64>,
}

/// The readings between two states, and their sum about the guessed bias.
#[derive(Clone, Debug)]
struct Leg {
    readings: Vec<Imu>,
    sum: Preintegration,
}

/// What came out.
pub struct Estimate {
    /// Poses with their covariances.
    pub track: Vec<Stamped<Gaussian<SE3, 6>>>,
    pub bias: ImuBias,
    /// Down in the frame of the positions, with standard deviations in radians, where it was estimated.
    pub down: Option<(S2, [f64; 2])>,
    pub cost: f64,
    /// Residuals less unknowns.
    pub freedom: usize,
    pub renewals: Vec<Renewal>,
    /// Sums and graph; optimum; covariances.
    pub seconds: [f64; 3],
    pub iterations: usize,
}

impl Batch {
    /// States at `times`, of which the first, the last and some between have a position.
    pub fn new(
        densities: Densities,
        bias: ImuBias,
        imu: &[Stamped<ImuReading>],
        times: &[i64],
        fixes: &[Stamped<Vector3<f64>>],
        fix_sigma: f64,
    ) -> Outcome<Self> {
        let at = |time: i64| fixes.iter().find(|fix| fix.stamp_ns == time).map(|fix| fix.value);
        let mut batch = Self {
            densities,
            fix_sigma,
            bias,
            bias_sigmas: [0.01, 0.2],
            gravity: 9.81,
            tilted: false,
            legs: vec![],
            start: vec![],
            fixes: times.iter().map(|&time| at(time)).collect(),
            times: times.to_vec(),
        };
        for readings in cut(imu, times) {
            let sum = Preintegration::of(&readings, bias, batch.white())?;
            batch.legs.push(Leg { readings, sum });
        }
        batch.start = batch.beginning()?;
        Ok(batch)
    }

    /// The same, with the direction of gravity to be estimated.
    pub fn tilted(self) -> Self {
        Self { tilted: true, ..self }
    }

    fn white(&self) -> ImuNoise {
        ImuNoise { gyro: self.densities.gyroscope, accel: self.densities.accelerometer }
    }

    fn down(&self) -> Vector3<f64> {
        Vector3::new(0.0, 0.0, -self.gravity)
    }

    /// States at positions in closed form, those between by dead reckoning.
    fn beginning(&self) -> Outcome<Vec<SE23>> {
        let seen: Vec<usize> = (0..self.times.len()).filter(|&k| self.fixes[k].is_some()).collect();
        let mut legs = vec![];
        for pair in seen.windows(2) {
            let sums = self.legs[pair[0]..pair[1]].iter().map(|leg| leg.sum);
            let sum = sums.reduce(|sum, next| sum.then(&next)).ok_or("two states at one time")?;
            legs.push((sum, self.fixes[pair[1]].ok_or("a position is missing")?));
        }
        let first = self.fixes[0].ok_or("the first state has no position")?;
        let at_fixes = inertial_start(first, &legs, &self.down())?;
        let mut states: Vec<SE23> = vec![];
        let mut fixed = at_fixes.into_iter();
        for k in 0..self.times.len() {
            let reckoned = |x: &SE23| self.legs[k - 1].sum.predict(x, &self.bias, &self.down());
            let state = match self.fixes[k] {
                Some(_) => fixed.next(),
                None => states.last().map(reckoned),
            };
            states.push(state.ok_or("the first state has no position")?);
        }
        Ok(states)
    }

    /// The optimum, and how sure it is.
    pub fn solve(&self) -> Outcome<Estimate> {
        let clock = Instant::now();
        let mut problem = Problem::new(self)?;
        let built = clock.elapsed().as_secs_f64();
        let (mut values, mut renewals) = (problem.values.clone(), vec![]);
        let mut iterations = 0;
        let cost = loop {
            let solution =
                problem.graph.optimize(&values, &SolveOptions { threads: 1, ..SolveOptions::default() })?;
            values = solution.values;
            iterations += solution.report.iterations.len();
            renewals.push(problem.graph.renew(&values)?);
            if renewals.last().is_some_and(|renewal| renewal.largest < 0.1) || renewals.len() > 5 {
                break solution.report.cost;
            }
        };
        let optimised = clock.elapsed().as_secs_f64();
        let mut marginals = problem.graph.marginals(&values)?;
        let ids: Vec<VariableId> = problem.states.iter().map(|&key| key.into()).collect();
        let covariances = marginals.covariances(&ids)?;
        let told = clock.elapsed().as_secs_f64();
        let mut track = vec![];
        for ((key, covariance), &stamp_ns) in problem.states.iter().zip(&covariances).zip(&self.times) {
            let pose = values.get(*key).ok_or("a state is missing")?.pose();
            let covariance = Covariance::new(Matrix6::from(covariance.fixed_view::<6, 6>(0, 0)))?;
            track.push(Stamped { stamp_ns, value: Gaussian::new(pose, covariance) });
        }
        let down = match problem.down {
            Some(key) => {
                let covariance = marginals.covariance(key)?;
                let sigmas = [0, 1].map(|i| covariance[(i, i)].sqrt());
                values.get(key).map(|&down| (down, sigmas))
            }
            None => None,
        };
        Ok(Estimate {
            track,
            bias: *values.get(problem.biases[0]).ok_or("a bias is missing")?,
            down,
            cost,
            freedom: problem.freedom,
            renewals,
            seconds: [built, optimised - built, told - optimised],
            iterations,
        })
    }

    /// Solved five times; of each stage the shortest time.
    pub fn fastest(&self) -> Outcome<Estimate> {
        let mut estimate = self.solve()?;
        for _ in 1..5 {
            let again = self.solve()?.seconds;
            estimate.seconds.iter_mut().zip(again).for_each(|(least, time)| *least = least.min(time));
        }
        Ok(estimate)
    }

    /// The problem as text, a line a fact, for other solvers.
    pub fn text(&self) -> Outcome<String> {
        let mut text = String::new();
        let d = &self.densities;
        writeln!(
            text,
            "noise {:e} {:e} {:e} {:e} {:e} {}",
            d.gyroscope,
            d.accelerometer,
            d.gyroscope_bias,
            d.accelerometer_bias,
            self.fix_sigma,
            self.gravity
        )?;
        let list = |numbers: &[f64]| numbers.iter().map(|x| format!("{x:e}")).collect::<Vec<_>>().join(" ");
        let state = |x: &SE23| {
            let (p, v, q) = (x.position(), x.velocity(), x.rotation().quaternion_xyzw());
            list(&[p.x, p.y, p.z, q[0], q[1], q[2], q[3], v.x, v.y, v.z])
        };
        writeln!(text, "bias {} {}", list(self.bias.vector().as_slice()), list(&self.bias_sigmas))?;
        for (k, start) in self.start.iter().enumerate() {
            writeln!(text, "state {} {}", self.times[k], state(start))?;
            if let Some(fix) = self.fixes[k] {
                writeln!(text, "fix {k} {}", list(fix.as_slice()))?;
            }
            for z in self.legs.get(k).into_iter().flat_map(|leg| &leg.readings) {
                let (w, a) = (z.gyroscope, z.accelerometer);
                writeln!(text, "imu {k} {}", list(&[w.x, w.y, w.z, a.x, a.y, a.z, z.duration]))?;
            }
        }
        Ok(text)
    }
}

/// The readings between successive times: those that hold are cut where a time falls between two.
fn cut(imu: &[Stamped<ImuReading>], times: &[i64]) -> Vec<Vec<Imu>> {
    let Some(&first) = times.first() else { return vec![] };
    let begin = imu.partition_point(|reading| reading.stamp_ns <= first).saturating_sub(1);
    let mut imu = imu[begin..].to_vec();
    if let Some(reading) = imu.first_mut() {
        reading.stamp_ns = first;
    }
    let marks: Vec<_> = times[1..].iter().map(|&stamp_ns| Stamped { stamp_ns, value: () }).collect();
    let (mut legs, mut readings) = (vec![], vec![]);
    for event in timeline(&imu, &marks) {
        match event {
            Event::Step { input, duration, .. } => readings.push(input.held(duration)),
            Event::Seen { .. } => legs.push(std::mem::take(&mut readings)),
        }
    }
    legs
}

struct Problem {
    graph: Graph,
    values: Values,
    states: Vec<Key<SE23>>,
    biases: Vec<Key<ImuBias>>,
    down: Option<Key<S2>>,
    freedom: usize,
}

impl Problem {
    fn new(batch: &Batch) -> Outcome<Self> {
        let (mut graph, mut values) = (Graph::new(), Values::new());
        let states: Vec<_> = batch.start.iter().map(|&x| values.insert(x)).collect();
        let biases: Vec<_> = states.iter().map(|_| values.insert(batch.bias)).collect();
        let level = S2::from_vector(&batch.down())?;
        let down = batch.tilted.then(|| values.insert(level));

        let sigmas = Vector6::from_fn(|i, _| batch.bias_sigmas[i / 3]);
        graph.add((biases[0],), Prior { mean: batch.bias }, Noise::from_sigmas(&sigmas)?);
        for (k, leg) in batch.legs.iter().enumerate() {
            let (from, to, bias) = (states[k], states[k + 1], biases[k]);
            match down {
                None => {
                    let imu = Inertial::new(&leg.readings, batch.bias, batch.white(), batch.down())?;
                    let noise = imu.noise()?;
                    graph.add((from, to, bias), imu, noise);
                }
                Some(down) => {
                    let imu =
                        InertialUnderGravity::new(&leg.readings, batch.bias, batch.white(), batch.gravity)?;
                    let noise = imu.noise()?;
                    graph.add((from, to, bias, down), imu, noise);
                }
            }
            let root = leg.sum.duration().sqrt();
            let densities = [batch.densities.gyroscope_bias, batch.densities.accelerometer_bias];
            let walk = Noise::from_sigmas(&Vector6::from_fn(|i, _| densities[i / 3] * root))?;
            graph.add((biases[k], biases[k + 1]), Between::new(ImuBias::zero()), walk);
        }
        let noise = Noise::from_sigmas(&Vector3::repeat(batch.fix_sigma))?;
        let seen: Vec<_> =
            states.iter().zip(&batch.fixes).filter_map(|(&x, fix)| Some((x, (*fix)?))).collect();
        for (state, fix) in &seen {
            graph.add((*state,), Position::of_origin(*fix), noise);
        }
        let residuals = 15 * batch.legs.len() + 3 * seen.len() + 6;
        let freedom = residuals - 15 * states.len() - if batch.tilted { 2 } else { 0 };
        Ok(Self { graph, values, states, biases, down, freedom })
    }
}

impl Estimate {
    /// Judged; in place of the NIS, χ² of a degree of freedom.
    pub fn row<const D: usize>(&self, name: &str, score: &Score<D>, fixes: usize) -> Row {
        let nis = 2.0 * self.cost / self.freedom as f64;
        Row { nis, accepted: fixes, ..Row::new(name, score, 3, Fates::default()) }
    }

    /// Cost, iterations and seconds, then a state a line: stamp, position, quaternion x y z w, standard deviations of the local error.
    pub fn text(&self) -> Outcome<String> {
        let mut text = String::new();
        let [built, optimised, told] = self.seconds;
        writeln!(text, "cost {:e} {} {built:e} {optimised:e} {told:e}", self.cost, self.iterations)?;
        for belief in &self.track {
            let (x, sigmas) = (belief.value.mean(), belief.value.sigmas());
            let (t, q) = (x.translation(), x.rotation().quaternion_xyzw());
            let numbers = [t.as_slice(), &q, sigmas.as_slice()].concat();
            let numbers: Vec<_> = numbers.iter().map(|x| format!("{x:e}")).collect();
            writeln!(text, "{} {}", belief.stamp_ns, numbers.join(" "))?;
        }
        Ok(text)
    }

    /// The angle between down and −z, in degrees, with the larger standard deviation.
    pub fn tilt(&self) -> Option<(f64, f64)> {
        let (down, sigmas) = self.down?;
        let level = S2::from_vector(&Vector3::new(0.0, 0.0, -1.0)).ok()?;
        let tilt = down.minus(&level).norm();
        Some((tilt.to_degrees(), sigmas[0].max(sigmas[1]).to_degrees()))
    }
}
