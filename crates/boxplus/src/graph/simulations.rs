//! Drives among beacons, simulated, to try smoothing and mapping on.

use super::factors::{CalibratedOdometry, Prior, Sighting2, Sighting3};
use super::{Factor, Graph, GraphError, GroupVariable, Key, Marginals, Noise, Values, VariableId};
use crate::lie::sample::standard_normal;
use crate::lie::{Action, LieGroup, Rn, SE2, SE3, Tangent};
use crate::uncertainty::{Covariance, Gaussian};
use core::f64::consts::TAU;
use nalgebra::{Cholesky, DVector, SVector, vector};
use rand::Rng;
use std::{vec, vec::Vec};

/// A pose that sees points in its own frame, of ℝᴺ.
pub trait Sees<const D: usize, const N: usize>: GroupVariable<D> + Action<D, N, Scalar = f64> {
    /// The factor of a point that is seen.
    type Sighting: Factor<N, Variables = (Self, Rn<N>)>;
    /// A point seen at `measured`, in metres, in the frame of the pose.
    fn sighting(measured: SVector<f64, N>) -> Self::Sighting;
}

impl Sees<3, 2> for SE2 {
    type Sighting = Sighting2;
    fn sighting(measured: SVector<f64, 2>) -> Sighting2 {
        Sighting2 { measured }
    }
}

impl Sees<6, 3> for SE3 {
    type Sighting = Sighting3;
    fn sighting(measured: SVector<f64, 3>) -> Sighting3 {
        Sighting3::new(measured)
    }
}

/// A drive among beacons at unknown places, with odometry off by an unknown bias: smoothing and mapping with self-calibration, Solà et
/// al. (2018) §V-B to §V-D.
///
/// Readings of odometry are uₖ + E·c + w, w ~ N(0, Q), where c is a bias of the first and of the last coordinate: of the way ahead and
/// of the turn about the vertical. Beacons are seen at X⁻¹·b + n.
///
/// ```
/// use boxplus::graph::{BeaconDrive, SolveOptions};
/// use rand::SeedableRng;
/// let drive = BeaconDrive::in_plane();
/// let simulated = drive.simulate(&mut rand_chacha::ChaCha8Rng::seed_from_u64(3))?;
/// let solved = simulated.graph.optimize(&simulated.start, &SolveOptions::default())?;
/// assert!(solved.report.converged());
/// let sigmas = simulated.graph.marginals(&solved.values)?.covariance(simulated.bias)?.diagonal().map(f64::sqrt);
/// let bias = solved.values.get(simulated.bias).ok_or("solved")?.vector();
/// let error = bias - drive.bias;
/// assert!(error.iter().zip(&sigmas).all(|(e, sigma)| e.abs() < 3.0 * sigma && *sigma < 0.005));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct BeaconDrive<G: LieGroup<D>, const D: usize, const N: usize> {
    /// What is known of the first pose.
    pub prior: Gaussian<G, D>,
    /// The true motions uₖ = Xₖ₊₁ ⊟ Xₖ: metres and radians.
    pub steps: Vec<Tangent<f64, D>>,
    /// Where the beacons are, in metres.
    pub beacons: Vec<SVector<f64, N>>,
    /// Which pose sees which beacon, counted from 0. Those that do not exist are passed over.
    pub sightings: Vec<(usize, usize)>,
    /// c: metres ahead and radians of turning, in each step.
    pub bias: SVector<f64, 2>,
    /// √ of the diagonal of Q: metres and radians.
    pub odometry_sigmas: Tangent<f64, D>,
    /// Standard deviation of each coordinate of n, in metres.
    pub sighting_sigma: f64,
}

impl BeaconDrive<SE2, 3, 2> {
    /// One and a half laps of a circle of 20 m in 60 steps, eight beacons, each seen from up to 4 m away. Readings are a tenth too long
    /// and turn an eighth too little.
    pub fn in_plane() -> Self {
        let beacons = [
            vector![5.0, 3.0],
            vector![3.0, 7.0],
            vector![-1.0, 8.0],
            vector![-4.5, 5.5],
            vector![-4.5, 1.0],
            vector![-1.0, -2.0],
            vector![3.5, -1.0],
            vector![0.5, 3.5],
        ];
        Self {
            prior: start(SE2::identity(), vector![0.02, 0.02, 0.01]),
            steps: vec![vector![0.5, 0.0, TAU / 40.0]; 60],
            beacons: beacons.to_vec(),
            sightings: Vec::new(),
            bias: vector![0.05, -0.02],
            odometry_sigmas: vector![0.02, 0.01, 0.01],
            sighting_sigma: 0.1,
        }
        .seeing_within(4.0)
    }

    /// The demonstration of Solà et al.: three poses, five beacons, nine sightings; (0.1 m, 0, 0.05 rad) a step, σ 0.01 of odometry and
    /// 0.001 m of sightings. Its bias is that of [`BeaconDrive::<SE3, 6, 3>::demonstration`](BeaconDrive::demonstration).
    pub fn demonstration() -> Self {
        let beacons =
            [vector![3.0, 0.0], vector![2.0, -1.0], vector![2.0, 1.0], vector![3.0, -1.0], vector![3.0, 1.0]];
        Self {
            prior: start(SE2::identity(), vector![0.01, 0.01, 0.01]),
            steps: vec![vector![0.1, 0.0, 0.05]; 2],
            beacons: beacons.to_vec(),
            sightings: DEMONSTRATED.to_vec(),
            bias: vector![0.05, 0.1],
            odometry_sigmas: SVector::repeat(0.01),
            sighting_sigma: 0.001,
        }
    }
}

impl BeaconDrive<SE3, 6, 3> {
    /// Two laps up a helix in 60 steps of half a metre, rolling a little, ten beacons, each seen from up to 4 m away. Readings are a tenth
    /// too long and turn a tenth too little.
    pub fn in_space() -> Self {
        // On a pole through the middle and on the walls of a tower.
        let on_wall = |k: usize| {
            let (sin, cos) = (TAU * k as f64 / 7.0).sin_cos();
            vector![4.5 * cos, 2.4 + 4.5 * sin, 0.7 * k as f64]
        };
        let on_pole = |k: usize| vector![0.0, 2.4, 2.0 * k as f64];
        Self {
            prior: start(SE3::identity(), vector![0.02, 0.02, 0.02, 0.01, 0.01, 0.01]),
            steps: (0..60)
                .map(|k| vector![0.5, 0.0, 0.08, 0.02 * (TAU * f64::from(k) / 20.0).sin(), 0.0, TAU / 30.0])
                .collect(),
            beacons: (0..7).map(on_wall).chain((0..3).map(on_pole)).collect(),
            sightings: Vec::new(),
            bias: vector![0.05, -0.02],
            odometry_sigmas: vector![0.02, 0.01, 0.01, 0.01, 0.01, 0.01],
            sighting_sigma: 0.1,
        }
        .seeing_within(4.0)
    }

    /// The demonstration of Solà et al. in space, as their software has it: three poses, five beacons, nine sightings; (0.2 m, 0, 0, 0, 0, 0.1 rad)
    /// a step, biased by 0.05 m and 0.1 rad, σ 0.01 of odometry and 0.001 m of sightings.
    pub fn demonstration() -> Self {
        let beacons = [
            vector![3.0, 0.0, 0.0],
            vector![2.0, -1.0, -1.0],
            vector![2.0, -1.0, 1.0],
            vector![2.0, 1.0, 1.0],
            vector![2.0, 1.0, -1.0],
        ];
        Self {
            prior: start(SE3::identity(), SVector::repeat(0.01)),
            steps: vec![vector![0.2, 0.0, 0.0, 0.0, 0.0, 0.1]; 2],
            beacons: beacons.to_vec(),
            sightings: DEMONSTRATED.to_vec(),
            bias: vector![0.05, 0.1],
            odometry_sigmas: SVector::repeat(0.01),
            sighting_sigma: 0.001,
        }
    }
}

/// Which pose sees which beacon in the demonstrations of Solà et al.
const DEMONSTRATED: [(usize, usize); 9] =
    [(0, 0), (0, 1), (0, 3), (1, 0), (1, 2), (1, 4), (2, 1), (2, 2), (2, 4)];

/// Independent coordinates.
fn start<G: LieGroup<D, Scalar = f64>, const D: usize>(mean: G, sigmas: SVector<f64, D>) -> Gaussian<G, D> {
    Gaussian::new(mean, Covariance::independent(&sigmas))
}

/// A drive that was simulated.
pub struct Driven<G: Sees<D, N>, const D: usize, const N: usize> {
    /// What was measured, and what is known of the first pose.
    pub graph: Graph,
    /// Dead reckoning: poses from the mean of the first by odometry as read, beacons where they were first seen from these, no bias.
    pub start: Values,
    /// What is true, under the same keys.
    pub truth: Values,
    /// In the order of the drive.
    pub poses: Vec<Key<G>>,
    /// In the order of [`BeaconDrive::beacons`]; nothing is known of one that no pose has seen.
    pub beacons: Vec<Key<Rn<N>>>,
    /// c.
    pub bias: Key<Rn<2>>,
}

/// The error of one or more variables, normalised by the covariance that is claimed for them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nees {
    /// Of what.
    pub of: &'static str,
    /// How many coordinates: of a consistent estimate the mean of [`Nees::squared`], which is χ².
    pub dimension: usize,
    /// ξᵀΣ⁻¹ξ, ξ on the local side.
    pub squared: f64,
}

impl<G: Sees<D, N>, const D: usize, const N: usize> Driven<G, D, N> {
    /// Takes the bias to be `bias`: a constant of the problem.
    ///
    /// # Errors
    /// None of values that [`BeaconDrive::simulate`] made.
    pub fn with_bias(mut self, bias: SVector<f64, 2>) -> Result<Self, GraphError> {
        self.start.set(self.bias, Rn::new(bias))?;
        self.start.hold(self.bias);
        Ok(self)
    }

    /// How an estimate stands to the truth: the bias, all beacons, the last pose, and everything together; nothing that is held.
    ///
    /// # Errors
    /// Those of [`Graph::marginals`].
    pub fn nees(&self, estimate: &Values) -> Result<Vec<Nees>, GraphError> {
        let mut marginals = self.graph.marginals(estimate)?;
        let bias = self.errors(&[self.bias], estimate, &marginals);
        let beacons = self.errors(&self.beacons, estimate, &marginals);
        let poses = self.errors(&self.poses, estimate, &marginals);
        let last = poses[poses.len().saturating_sub(1)..].to_vec();
        let everything = [bias.clone(), beacons.clone(), poses].concat();
        let parts = [("bias", bias), ("beacons", beacons), ("last pose", last), ("everything", everything)];
        let all = parts.into_iter().filter(|(_, errors)| !errors.is_empty()).map(|(of, errors)| {
            let (ids, errors): (Vec<_>, Vec<_>) = errors.into_iter().unzip();
            let xi = DVector::from_vec(errors.concat());
            let factor = Cholesky::new(marginals.joint(&ids)?).ok_or(GraphError::IllConditioned)?;
            Ok(Nees { of, dimension: xi.len(), squared: xi.dot(&factor.solve(&xi)) })
        });
        all.collect()
    }

    /// X ⊟ X̂ of the variables that were estimated.
    fn errors<V: GroupVariable<K>, const K: usize>(
        &self,
        keys: &[Key<V>],
        estimate: &Values,
        marginals: &Marginals,
    ) -> Vec<(VariableId, Vec<f64>)> {
        let estimated = keys.iter().filter(|&&key| marginals.knows(key) && !estimate.is_held(key));
        let error = |&key: &Key<V>| {
            let xi = self.truth.get(key)?.rminus(estimate.get(key)?);
            Some((key.into(), xi.as_slice().to_vec()))
        };
        estimated.filter_map(error).collect()
    }
}

impl<G: Sees<D, N>, const D: usize, const N: usize> BeaconDrive<G, D, N> {
    /// The same drive with every beacon seen from every pose that is nearer than `reach` metres.
    #[must_use]
    pub fn seeing_within(mut self, reach: f64) -> Self {
        let poses = path(*self.prior.mean(), &self.steps);
        let near = |x: &G| {
            let seen = self.beacons.iter().map(|b| x.act_inverse(b).norm()).enumerate();
            seen.filter(|(_, distance)| *distance < reach).map(|(k, _)| k).collect::<Vec<_>>()
        };
        self.sightings =
            poses.iter().enumerate().flat_map(|(i, x)| near(x).into_iter().map(move |k| (i, k))).collect();
        self
    }

    /// Drives once: the first pose is drawn from the prior, and noise for every reading.
    ///
    /// # Errors
    /// [`GraphError::InvalidSigma`]; [`GraphError::NotPositiveDefinite`] of a prior that is certain of a direction.
    pub fn simulate(&self, rng: &mut impl Rng) -> Result<Driven<G, D, N>, GraphError> {
        let poses = path(self.prior.sample(rng), &self.steps);
        let readings: Vec<_> = self.steps.iter().map(|u| self.read(u, rng)).collect();
        let mut see = |&(i, k): &(usize, usize)| {
            let place = poses.get(i)?.act_inverse(self.beacons.get(k)?);
            Some((i, k, place + standard_normal(rng) * self.sighting_sigma))
        };
        let seen: Vec<Seen<N>> = self.sightings.iter().filter_map(&mut see).collect();
        let reckoned = path(*self.prior.mean(), &readings);
        let placed = |k: usize| {
            let first = seen.iter().find(|(_, beacon, _)| *beacon == k);
            first.map_or(SVector::zeros(), |(i, _, measured)| reckoned[*i].act(measured))
        };
        let placed: Vec<_> = (0..self.beacons.len()).map(placed).collect();

        // The same keys twice: they count the variables of a kind in the order of insertion.
        let (truth, ..) = variables(&poses, &self.beacons, self.bias);
        let (start, poses, beacons, bias) = variables(&reckoned, &placed, SVector::zeros());
        let mut driven = Driven { graph: Graph::new(), start, truth, poses, beacons, bias };
        self.tie(&mut driven, &readings, &seen)?;
        Ok(driven)
    }

    /// A reading of odometry.
    fn read(&self, u: &Tangent<f64, D>, rng: &mut impl Rng) -> Tangent<f64, D> {
        let exact = CalibratedOdometry::<G, D, 2>::biased(*u, biased(D));
        u + exact.enters * self.bias + self.odometry_sigmas.component_mul(&standard_normal(rng))
    }

    /// Adds the factors.
    fn tie(
        &self,
        driven: &mut Driven<G, D, N>,
        readings: &[Tangent<f64, D>],
        seen: &[Seen<N>],
    ) -> Result<(), GraphError> {
        let Driven { graph, poses, beacons, bias, .. } = driven;
        let known = Noise::from_covariance(self.prior.covariance().matrix())?;
        graph.add((poses[0],), Prior { mean: *self.prior.mean() }, known);
        let odometry = Noise::from_sigmas(&self.odometry_sigmas)?;
        for (pair, reading) in poses.windows(2).zip(readings) {
            let factor = CalibratedOdometry::<G, D, 2>::biased(*reading, biased(D));
            graph.add((pair[0], pair[1], *bias), factor, odometry);
        }
        let sighting = Noise::from_sigmas(&SVector::repeat(self.sighting_sigma))?;
        for &(i, k, measured) in seen {
            graph.add((poses[i], beacons[k]), G::sighting(measured), sighting);
        }
        Ok(())
    }
}

/// Pose, beacon, and where the one sees the other.
type Seen<const N: usize> = (usize, usize, SVector<f64, N>);

/// The coordinates of a tangent of dimension `d` that are biased: ahead, and about the vertical.
const fn biased(d: usize) -> [usize; 2] {
    [0, d - 1]
}

/// The poses from a first one on.
fn path<G: LieGroup<D, Scalar = f64>, const D: usize>(first: G, steps: &[Tangent<f64, D>]) -> Vec<G> {
    let next = |x: &mut G, step: &Tangent<f64, D>| {
        *x = x.rplus(step);
        Some(*x)
    };
    core::iter::once(first).chain(steps.iter().scan(first, next)).collect()
}

/// The variables of a drive and their keys.
#[expect(clippy::type_complexity, reason = "used twice, side by side")]
fn variables<G: Sees<D, N>, const D: usize, const N: usize>(
    poses: &[G],
    beacons: &[SVector<f64, N>],
    bias: SVector<f64, 2>,
) -> (Values, Vec<Key<G>>, Vec<Key<Rn<N>>>, Key<Rn<2>>) {
    let mut values = Values::new();
    let poses = poses.iter().map(|x| values.insert(*x)).collect();
    let beacons = beacons.iter().map(|b| values.insert(Rn::new(*b))).collect();
    let bias = values.insert(Rn::new(bias));
    (values, poses, beacons, bias)
}
