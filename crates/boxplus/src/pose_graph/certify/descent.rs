//! Down in ℝᴾ: along an eigenvector into a new dimension, and by Newton's method to the next minimum.
//!
//! Where P > D there is room around the obstacles of ℝᴰ: where an estimate is no optimum although every small step makes it
//! worse, the eigenvector of S with a negative eigenvalue is a way down through the new dimension. A Riemannian
//! staircase, Boumal (2015); Rosen et al. (2019), §4.2.
//!
//! The Hessian along the constraints is S itself: ½F changes by tr(Ẋ·S·Ẋᵀ)/2 to second order, so that one matrix serves
//! the proof and the method. A frame is completed to Q ∈ O(P), of which the first D columns count, and moves by Q·Cay(A),
//! A skew and zero where both coordinates are beyond D: D(D−1)/2 + D(P−D) numbers turn it and P move it.

use core::ops::ControlFlow;

use nalgebra::{DMatrix, SMatrix, SVector, SymmetricEigen};

use super::quadratic::{Frame, Layout, Link, cost, dual, multipliers, slopes};
use crate::graph::GraphError;
use crate::graph::linear::cholesky::Cholesky;

/// The first damping, relative to the weights; it grows and shrinks by [`PACE`].
const DAMPING: f64 = 1e-6;
/// Damping is not let below this: the rotations of the unused dimensions are free.
const LEAST_DAMPING: f64 = 1e-12;
/// Where damping beyond this does not help, nothing will.
const MOST_DAMPING: f64 = 1e8;
const PACE: f64 = 10.0;
/// Damping falls by this factor where a step promises nothing.
const LOOSER: f64 = 1e3;
/// Steps at most.
const STEPS: usize = 300;

/// The pairs (a, b) of axes that a turn may mix, a < D, in the order of the tangent.
fn planes<const P: usize, const D: usize>() -> impl Iterator<Item = (usize, usize)> {
    (0..D).flat_map(|a| (a + 1..P).map(move |b| (a, b)))
}

/// What one coordinate of the tangent does to X = [Y t] ∈ ℝᴾˣ⁽ᴰ⁺¹⁾: column `column` moves by `sign` along axis `axis` of
/// [Q I].
#[derive(Clone, Copy)]
struct Move {
    axis: usize,
    column: usize,
    sign: f64,
}

/// The moves of every coordinate: a turn in the plane (a, b) moves y_a along q_b and y_b, if it counts, against q_a.
fn moves<const P: usize, const D: usize>() -> Vec<Vec<Move>> {
    let turn = |(a, b)| {
        let there = Move { axis: b, column: a, sign: 1.0 };
        let back = Move { axis: a, column: b, sign: -1.0 };
        if b < D { vec![there, back] } else { vec![there] }
    };
    let shift = |p| vec![Move { axis: P + p, column: D, sign: 1.0 }];
    planes::<P, D>().map(turn).chain((0..P).map(shift)).collect()
}

/// A frame while it moves.
#[derive(Clone, Copy)]
struct Body<const P: usize> {
    q: SMatrix<f64, P, P>,
    t: SVector<f64, P>,
}

impl<const P: usize> Body<P> {
    /// Axis `axis` of [Q I].
    fn axis(&self, axis: usize) -> SVector<f64, P> {
        if axis < P {
            self.q.column(axis).into_owned()
        } else {
            SVector::from_fn(|p, _| if p + P == axis { 1.0 } else { 0.0 })
        }
    }

    /// Turned by Cay(A) = (I − A/2)⁻¹(I + A/2), which is orthogonal, and moved.
    fn moved<const D: usize>(&self, delta: &[f64]) -> Self {
        let mut half = SMatrix::<f64, P, P>::zeros();
        for ((a, b), x) in planes::<P, D>().zip(delta) {
            half[(b, a)] += 0.5 * x;
            half[(a, b)] -= 0.5 * x;
        }
        let one = SMatrix::<f64, P, P>::identity();
        let turn = (one - half).try_inverse().map_or(one, |inverse| inverse * (one + half));
        let q = self.q * turn;
        // One Newton step towards the nearest orthogonal matrix: drift does not add up.
        let q = q * (one * 1.5 - q.transpose() * q * 0.5);
        Self { q, t: self.t + SVector::<f64, P>::from_column_slice(&delta[delta.len() - P..]) }
    }

    fn frame<const D: usize>(&self) -> Frame<P, D> {
        Frame { y: self.q.fixed_columns::<D>(0).into_owned(), t: self.t }
    }
}

/// Somebody who may stop the search.
pub(super) struct Watch<'a> {
    pub(super) observer: &'a mut dyn FnMut(f64) -> ControlFlow<()>,
    pub(super) stopped: bool,
}

impl Watch<'_> {
    /// Tells the cost; whether to go on.
    fn goes_on(&mut self, cost: f64) -> bool {
        self.stopped |= (self.observer)(cost).is_break();
        !self.stopped
    }
}

/// The minimum next to `frames`, until a step promises to lower the cost by less than `relative` of it.
///
/// Damped Newton steps: (H + λW)δ = −g, W the weights of the measurements; λ grows until H + λW is positive definite and
/// the cost falls.
///
/// # Errors
/// [`GraphError::OutOfMemory`].
pub(super) fn minimise<const P: usize, const D: usize>(
    links: &[Link<D>],
    given: &[Frame<P, D>],
    relative: f64,
    watch: &mut Watch<'_>,
) -> Result<Vec<Frame<P, D>>, GraphError> {
    let mut newton = Newton::<P, D>::new(links, given.len())?;
    let mut bodies: Vec<Body<P>> = given.iter().map(|f| Body { q: complete(&f.y), t: f.t }).collect();
    let (mut frames, mut damping) = (given.to_vec(), DAMPING);
    let mut least = cost(links, &frames);
    newton.linearise(links, &bodies, &frames);
    for _ in 0..STEPS {
        if !watch.goes_on(least) {
            break;
        }
        let Some(predicted) = newton.step(damping) else {
            damping *= PACE;
            if damping > MOST_DAMPING {
                break;
            }
            continue;
        };
        let trial = newton.moved(&bodies);
        let trial_frames: Vec<Frame<P, D>> = trial.iter().map(Body::frame).collect();
        let new = cost(links, &trial_frames);
        let small = predicted <= relative * least;
        if new < least {
            let gain = (least - new) / predicted;
            damping = if gain > 0.75 { (damping / PACE).max(LEAST_DAMPING) } else { damping };
            (bodies, frames, least) = (trial, trial_frames, new);
            newton.linearise(links, &bodies, &frames);
        } else if !small {
            damping *= PACE;
        }
        if small && damping > LEAST_DAMPING {
            damping = (damping / LOOSER).max(LEAST_DAMPING); // convergence is not believed of a step that was held short
        } else if small || damping > MOST_DAMPING {
            break;
        }
    }
    Ok(frames)
}

/// The Newton equations, laid out once.
struct Newton<const P: usize, const D: usize> {
    layout: Layout,
    /// Layout of S, from which the Hessian is read.
    dual: Layout,
    moves: Vec<Vec<Move>>,
    held: Vec<bool>,
    weights: Vec<f64>,
    hessian: Vec<f64>,
    damped: Vec<f64>,
    gradient: Vec<f64>,
    delta: Vec<f64>,
    cholesky: Cholesky,
}

impl<const P: usize, const D: usize> Newton<P, D> {
    fn new(links: &[Link<D>], count: usize) -> Result<Self, GraphError> {
        let moves = moves::<P, D>();
        let layout = Layout::new(links, count, moves.len())?;
        let cholesky = Cholesky::new(&layout.pattern)?;
        let mut held = vec![false; count];
        layout.anchors.iter().for_each(|&pose| held[pose] = true);
        let mut weights = vec![0.0; count * moves.len()];
        for link in links {
            let turn = link.kappa + link.tau * link.translation.norm_squared();
            for (k, moved) in moves.iter().enumerate() {
                let weight = if moved[0].column < D { turn } else { link.tau };
                weights[layout.row(link.from) + k] += weight;
                weights[layout.row(link.to) + k] += weight;
            }
        }
        let numbers = layout.pattern.len();
        Ok(Self {
            dual: layout.resized(D + 1)?,
            gradient: vec![0.0; weights.len()],
            delta: vec![0.0; weights.len()],
            hessian: vec![0.0; numbers],
            damped: vec![0.0; numbers],
            layout,
            moves,
            held,
            weights,
            cholesky,
        })
    }

    /// Gradient and Hessian of ½F.
    fn linearise(&mut self, links: &[Link<D>], bodies: &[Body<P>], frames: &[Frame<P, D>]) {
        let slopes = slopes(links, frames);
        let dual = dual(&self.dual, links, &multipliers(frames, &slopes));
        for (pose, (body, slope)) in bodies.iter().zip(&slopes).enumerate() {
            let row = self.layout.row(pose);
            for (k, moved) in self.moves.iter().enumerate() {
                let along = |m: &Move| {
                    let of = |column| if column < D { slope.y.column(column).into_owned() } else { slope.t };
                    m.sign * body.axis(m.axis).dot(&of(m.column))
                };
                self.gradient[row + k] = if self.held[pose] { 0.0 } else { moved.iter().map(along).sum() };
            }
        }
        self.hessian.fill(0.0);
        for pose in 0..bodies.len() {
            if self.held[pose] {
                let place = self.layout.block(pose, pose);
                for k in 0..self.moves.len() {
                    self.hessian[place(k, k)] = self.weights[self.layout.row(pose) + k];
                }
            } else {
                self.block(&dual, bodies, (pose, pose));
            }
        }
        for pair in 0..self.layout.pairs.len() {
            let (i, j) = self.layout.pairs[pair];
            let (i, j) = (i as usize, j as usize);
            if !self.held[i] && !self.held[j] {
                self.block(&dual, bodies, (i, j));
            }
        }
    }

    /// tr(Ẋ_i·S_ij·Ẋ_jᵀ) for all pairs of coordinates of two poses.
    fn block(&mut self, dual: &[f64], bodies: &[Body<P>], (i, j): (usize, usize)) {
        let inner: Vec<f64> =
            (0..4 * P * P).map(|n| bodies[i].axis(n / (2 * P)).dot(&bodies[j].axis(n % (2 * P)))).collect();
        let (place, entry) = (self.layout.block(i, j), self.dual.block(i, j));
        for (k, first) in self.moves.iter().enumerate() {
            for (l, second) in self.moves.iter().enumerate().take(if i == j { k + 1 } else { usize::MAX }) {
                let mut sum = 0.0;
                for m in first {
                    for n in second {
                        let s = dual[entry(m.column, n.column)];
                        sum += m.sign * n.sign * inner[m.axis * 2 * P + n.axis] * s;
                    }
                }
                self.hessian[place(k, l)] = sum;
            }
        }
    }

    /// Solves for the step; returns by how much it should lower F, or `None` where the damping does not suffice.
    fn step(&mut self, damping: f64) -> Option<f64> {
        self.damped.copy_from_slice(&self.hessian);
        for pose in 0..self.layout.count() {
            let (row, place) = (self.layout.row(pose), self.layout.block(pose, pose));
            for k in 0..self.moves.len() {
                self.damped[place(k, k)] += damping * self.weights[row + k];
            }
        }
        self.cholesky.factorise(&self.damped).ok()?;
        self.delta.iter_mut().zip(&self.gradient).for_each(|(d, g)| *d = -g);
        self.cholesky.solve(&mut self.delta);
        // F falls by −2gᵀδ − δᵀHδ, and Hδ = −g − λWδ.
        let falls = self.gradient.iter().zip(&self.delta).zip(&self.weights);
        let predicted: f64 = falls.map(|((g, d), w)| -g * d + damping * w * d * d).sum();
        predicted.is_finite().then_some(predicted)
    }

    fn moved(&self, bodies: &[Body<P>]) -> Vec<Body<P>> {
        let size = self.moves.len();
        let step = |pose| &self.delta[self.layout.row(pose)..self.layout.row(pose) + size];
        bodies.iter().enumerate().map(|(pose, body)| body.moved::<D>(step(pose))).collect()
    }
}

/// Frames with one row more, moved down along the eigenvector `direction` of S: as far as the cost allows.
pub(super) fn descend<const P: usize, const Q: usize, const D: usize>(
    frames: &[Frame<P, D>],
    direction: impl Fn(usize) -> (SVector<f64, D>, f64),
    cost: impl Fn(&[Frame<Q, D>]) -> f64,
) -> Vec<Frame<Q, D>> {
    let largest = (0..frames.len()).map(|i| direction(i).0.norm()).fold(0.0, f64::max);
    let at = |length: f64| -> Vec<Frame<Q, D>> {
        let moved = |(i, frame): (usize, &Frame<P, D>)| {
            let (turn, shift) = direction(i);
            let mut y = SMatrix::<f64, Q, D>::zeros();
            y.view_mut((0, 0), (P, D)).copy_from(&frame.y);
            y.view_mut((P, 0), (1, D)).copy_from(&(turn.transpose() * length));
            let t = SVector::<f64, Q>::from_fn(|p, _| if p < P { frame.t[p] } else { length * shift });
            Frame { y: polar(&y), t }
        };
        frames.iter().enumerate().map(moved).collect()
    };
    let lengths = core::iter::successors(Some(1.0 / largest), |length| Some(length * 0.5)).take(40);
    let trials = lengths.map(|length| (cost(&at(length)), length));
    // The cost falls as length² for small lengths and rises again: the best of the halvings is near the best there is.
    let best = trials.fold((f64::INFINITY, 0.0), |best, trial| if trial.0 < best.0 { trial } else { best });
    at(best.1)
}

/// The nearest matrix with orthonormal columns: Y(YᵀY)^-½.
pub(super) fn polar<const P: usize, const D: usize>(y: &SMatrix<f64, P, D>) -> SMatrix<f64, P, D> {
    let gram = y.transpose() * y;
    let mut eigen = SymmetricEigen::new(DMatrix::from_column_slice(D, D, gram.as_slice()));
    eigen.eigenvalues.apply(|x| *x = x.max(f64::MIN_POSITIVE).sqrt().recip());
    let root = eigen.recompose();
    y * SMatrix::<f64, D, D>::from_column_slice(root.as_slice())
}

/// An orthogonal matrix whose first columns are those of `y`.
fn complete<const P: usize, const D: usize>(y: &SMatrix<f64, P, D>) -> SMatrix<f64, P, P> {
    let mut q = SMatrix::<f64, P, P>::zeros();
    q.view_mut((0, 0), (P, D)).copy_from(y);
    for column in D..P {
        // The axis that the columns so far reach least, made orthogonal to them.
        let reach = |p: usize| q.row(p).columns(0, column).norm_squared();
        let axis = (0..P).min_by(|&a, &b| reach(a).total_cmp(&reach(b))).unwrap_or(0);
        let mut new = SVector::<f64, P>::zeros();
        new[axis] = 1.0;
        for _ in 0..2 {
            for k in 0..column {
                let along = q.column(k).dot(&new);
                new -= q.column(k) * along;
            }
        }
        q.set_column(column, &new.normalize());
    }
    q
}
