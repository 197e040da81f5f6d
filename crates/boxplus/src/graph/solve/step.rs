//! Steps of the trust-region methods, and how far the linear model is trusted.

use super::clock::Clock;
use super::report::Seconds;
use super::{Algorithm, SolveOptions};
use crate::graph::diagnose::{SINGULAR, least_eigenvalue};
use crate::graph::linear::cholesky::Cholesky;
use crate::graph::linear::structure::{Normal, Structure};
use crate::graph::linear::vector::{dot, product};

/// The linear model at the current estimate, and the means to solve it.
pub(crate) struct System<'a> {
    pub(crate) structure: &'a Structure,
    pub(crate) normal: Normal,
    pub(crate) cholesky: Cholesky,
    pub(crate) clock: Clock,
    pub(crate) seconds: Seconds,
}

impl System<'_> {
    /// H·x.
    fn product(&self, x: &[f64]) -> Vec<f64> {
        product(&self.structure.pattern, &self.normal.matrix, x)
    }
}

/// A step to try.
#[derive(Clone, Debug)]
pub(crate) struct Step {
    /// δ, in the order of the structure.
    pub(crate) delta: Vec<f64>,
    /// Decrease of the cost that the model promises: −gᵀδ − ½ δᵀHδ.
    pub(crate) predicted: f64,
    /// max |δᵢ|·√Dᵢ.
    pub(crate) scaled: f64,
}

/// How far the model is trusted.
pub(crate) struct Region {
    trust: Trust,
    /// D: the diagonal of H, with 1 for its zeros.
    diagonal: Vec<f64>,
    /// λ of the matrix last factorised, NaN before the first.
    factored: f64,
    /// With less damping than this the equations of this linearisation could not be solved.
    least: f64,
    /// For dogleg: the Gauss–Newton step and the Cauchy step of this linearisation.
    steps: Option<(Vec<f64>, Vec<f64>)>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Trust {
    /// λ, and ν by which a rejection multiplies it.
    Damping {
        lambda: f64,
        nu: f64,
    },
    /// Consecutive steps that raised the cost.
    Full {
        climbs: u32,
    },
    Radius(f64),
}

/// λ beyond this moves nothing any more.
const LARGEST_DAMPING: f64 = 1e12;
/// A trust radius below this moves nothing any more.
const SMALLEST_RADIUS: f64 = 1e-12;
/// With more damping than this a short step is no sign of a minimum: it may be the damping that makes it short.
const FREE_DAMPING: f64 = 1e-6;
/// λ below this is rounding of the diagonal.
const SMALLEST_DAMPING: f64 = 1e-14;
/// A trial is accepted when the cost falls by this share of the promise.
const ACCEPT: f64 = 1e-3;
/// λ beyond which a factor says nothing of the least curvature, and one that hides nothing above [`SINGULAR`].
const HIDING: f64 = 1e-6;
const PROBING: f64 = 1e-13;
/// Gauss–Newton is said to diverge after this many climbs in a row.
const CLIMBS: u32 = 5;

impl Region {
    pub(crate) fn new(options: &SolveOptions, size: usize) -> Self {
        let trust = match options.algorithm {
            Algorithm::LevenbergMarquardt => {
                // max also cures what is not a number.
                Trust::Damping { lambda: options.initial_damping.max(SMALLEST_DAMPING), nu: 2.0 }
            }
            Algorithm::GaussNewton => Trust::Full { climbs: 0 },
            Algorithm::Dogleg => Trust::Radius(options.initial_radius.max(SMALLEST_RADIUS)),
        };
        Self { trust, diagonal: vec![0.0; size], factored: f64::NAN, least: 0.0, steps: None }
    }

    /// Takes note of new normal equations.
    pub(crate) fn linearised(&mut self, structure: &Structure, normal: &Normal) {
        let entries = structure.diagonal.iter().map(|&at| normal.matrix[at]);
        // What no residual depends on has no unit of its own; its gradient is zero whatever stands here.
        self.diagonal.iter_mut().zip(entries).for_each(|(d, h)| *d = if h > 0.0 { h } else { 1.0 });
        self.steps = None;
        self.least = 0.0;
    }

    /// max |gᵢ|/√Dᵢ, infinite where a derivative is not finite: a minimum there is no minimum.
    pub(crate) fn scaled_gradient(&self, normal: &Normal) -> f64 {
        let scaled = normal.gradient.iter().zip(&self.diagonal).map(|(g, d)| g.abs() / d.sqrt());
        scaled.fold(0.0, |max, x| if x.is_finite() { max.max(x) } else { f64::INFINITY })
    }

    /// λ, the radius, or 0.
    pub(crate) fn damping(&self) -> f64 {
        match self.trust {
            Trust::Damping { lambda, .. } => lambda,
            Trust::Full { .. } => 0.0,
            Trust::Radius(radius) => radius,
        }
    }

    /// Whether the last step was held back by the region rather than by the model.
    pub(crate) fn binds(&self) -> bool {
        match self.trust {
            Trust::Damping { lambda, .. } => lambda > FREE_DAMPING.max(self.least),
            Trust::Full { .. } => false,
            Trust::Radius(radius) => {
                self.steps.as_ref().is_some_and(|(newton, _)| length(newton, &self.diagonal) > radius)
            }
        }
    }

    /// Lets the next step be longer.
    pub(crate) fn loosen(&mut self) {
        match &mut self.trust {
            Trust::Damping { lambda, .. } => *lambda = (0.1 * *lambda).max(self.least),
            Trust::Full { .. } => {}
            Trust::Radius(radius) => *radius *= 10.0,
        }
    }

    pub(crate) fn is_damped(&self) -> bool {
        matches!(self.trust, Trust::Damping { .. })
    }

    /// Whether there is no shorter step left to try.
    pub(crate) fn exhausted(&self) -> bool {
        match self.trust {
            Trust::Damping { lambda, .. } => lambda > LARGEST_DAMPING,
            Trust::Full { .. } => true,
            Trust::Radius(radius) => radius <= SMALLEST_RADIUS,
        }
    }

    /// The step of this method, or `None` where the equations cannot be solved.
    pub(crate) fn step(&mut self, system: &mut System<'_>) -> Option<Step> {
        let delta = match self.trust {
            Trust::Full { .. } => self.solve(0.0, system)?,
            Trust::Damping { .. } => self.damped_step(system)?,
            Trust::Radius(radius) => {
                if self.steps.is_none() {
                    let newton = self.solve(0.0, system)?;
                    self.steps = Some((newton, self.cauchy(system)));
                }
                let (newton, cauchy) = self.steps.as_ref()?;
                dogleg(newton, cauchy, &self.diagonal, radius)
            }
        };
        let slope = dot(&system.normal.gradient, &delta);
        let curvature = match self.trust {
            Trust::Radius(_) => dot(&delta, &system.product(&delta)),
            // Hδ = −g − λDδ: no product with H.
            _ => -slope - self.factored * length(&delta, &self.diagonal).powi(2),
        };
        let scaled = delta.iter().zip(&self.diagonal).map(|(x, d)| x.abs() * d.sqrt()).fold(0.0, f64::max);
        Some(Step { predicted: -slope - 0.5 * curvature, scaled, delta })
    }

    /// Raises λ until H + λD is positive definite.
    fn damped_step(&mut self, system: &mut System<'_>) -> Option<Vec<f64>> {
        loop {
            let Trust::Damping { lambda, .. } = self.trust else { return None };
            if let Some(delta) = self.solve(lambda, system) {
                return Some(delta);
            }
            if self.exhausted() {
                return None;
            }
            self.least = (10.0 * lambda).max(SMALLEST_DAMPING);
            self.trust = Trust::Damping { lambda: self.least, nu: 2.0 };
        }
    }

    /// −(H + λD)⁻¹g.
    fn solve(&mut self, lambda: f64, system: &mut System<'_>) -> Option<Vec<f64>> {
        let start = system.clock.seconds();
        self.factored = lambda;
        let Normal { matrix, gradient } = &system.normal;
        let done = system.cholesky.factorise_with(matrix, (lambda, &self.diagonal), gradient);
        let middle = system.clock.seconds();
        system.seconds.factorise += middle - start;
        done.ok()?;
        let mut delta = system.cholesky.solution();
        delta.iter_mut().for_each(|x| *x = -*x);
        system.seconds.solve += system.clock.seconds() - middle;
        delta.iter().all(|x| x.is_finite()).then_some(delta)
    }

    /// The minimiser of the model along D⁻¹g, the steepest descent in the metric of D.
    fn cauchy(&self, system: &System<'_>) -> Vec<f64> {
        let gradient = &system.normal.gradient;
        let direction: Vec<f64> = gradient.iter().zip(&self.diagonal).map(|(g, d)| -g / d).collect();
        let slope = dot(gradient, &direction);
        let curvature = dot(&direction, &system.product(&direction));
        direction.iter().map(|x| -slope / curvature * x).collect()
    }

    /// Accepts or rejects a trial, and adapts the trust.
    pub(crate) fn judge(&mut self, cost: f64, gain: f64, step: &Step) -> bool {
        let accepted = cost.is_finite() && step.predicted > 0.0 && gain > ACCEPT;
        match &mut self.trust {
            Trust::Damping { lambda, nu } => {
                if accepted {
                    // Nielsen: a smooth fall with the gain. Near a quadratic minimum (gain → 1) λ falls tenfold.
                    *lambda =
                        (*lambda * (1.0 - (2.0 * gain - 1.0).powi(3)).clamp(0.1, 2.0)).max(SMALLEST_DAMPING);
                    *nu = 2.0;
                } else {
                    *lambda *= *nu;
                    *nu *= 2.0;
                }
                accepted
            }
            Trust::Full { climbs } => {
                *climbs = if gain > 0.0 { 0 } else { *climbs + 1 };
                cost.is_finite() && *climbs < CLIMBS
            }
            Trust::Radius(radius) => {
                let length =
                    step.delta.iter().zip(&self.diagonal).map(|(x, d)| x * x * d).sum::<f64>().sqrt();
                if gain > 0.75 {
                    *radius = radius.max(3.0 * length);
                } else if gain < 0.25 || !cost.is_finite() {
                    *radius = 0.25 * radius.min(length);
                }
                accepted
            }
        }
    }

    /// Whether H is (nearly) singular, as far as two inverse iterations in the metric of D tell. They ask the last factor;
    /// where its damping hides what lies below, they ask once more with next to none.
    pub(crate) fn hints_at_singularity(&mut self, system: &mut System<'_>) -> bool {
        // With much damping, or where nothing was factorised, nothing is known.
        let known = self.factored <= HIDING;
        if known && self.least_curvature(system) >= SINGULAR + 3.0 * self.factored {
            return false;
        }
        self.solve(PROBING, system).is_none() || self.least_curvature(system) < SINGULAR
    }

    /// About the least eigenvalue of D^-½HD^-½ + λI, from above.
    fn least_curvature(&self, system: &mut System<'_>) -> f64 {
        let scale = |x: &mut [f64]| x.iter_mut().zip(&self.diagonal).for_each(|(x, d)| *x *= d.sqrt());
        least_eigenvalue(self.diagonal.len(), |x| {
            scale(x);
            system.cholesky.solve(x);
            scale(x);
        })
    }
}

/// ‖√D·x‖.
fn length(x: &[f64], diagonal: &[f64]) -> f64 {
    x.iter().zip(diagonal).map(|(x, d)| x * x * d).sum::<f64>().sqrt()
}

/// The point of Powell's path 0 → Cauchy → Gauss–Newton at ‖√D·δ‖ = radius, or its end.
fn dogleg(newton: &[f64], cauchy: &[f64], diagonal: &[f64], radius: f64) -> Vec<f64> {
    let inner =
        |a: &[f64], b: &[f64]| a.iter().zip(b).zip(diagonal).map(|((a, b), d)| a * b * d).sum::<f64>();
    if inner(newton, newton) <= radius * radius {
        return newton.to_vec();
    }
    let descent = inner(cauchy, cauchy).sqrt();
    if descent >= radius {
        return cauchy.iter().map(|x| x * radius / descent).collect();
    }
    let leg: Vec<f64> = newton.iter().zip(cauchy).map(|(n, c)| n - c).collect();
    let (a, b, c) = (inner(&leg, &leg), inner(cauchy, &leg), descent * descent - radius * radius);
    let root = (b * b - a * c).sqrt();
    let t = if b > 0.0 { -c / (b + root) } else { (root - b) / a }; // the positive root, without cancellation
    cauchy.iter().zip(&leg).map(|(x, l)| x + t * l).collect()
}
