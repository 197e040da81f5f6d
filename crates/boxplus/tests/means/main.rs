//! Means: what they are invariant under, when they are refused, how they follow their elements, and how sure they are.
#![allow(missing_docs, clippy::unwrap_used)]

mod sure;

use boxplus::lie::{
    ChordalMean, Distance, LieError, LieGroup, Means, R3xSO3, Real, Rn, RxSO2, RxSO3, S3, SE2, SE3, SE23,
    SGal3, SO2, SO3, Sim2, Sim3, Tangent, Weights,
};
use nalgebra::{SVector, Vector1, Vector3, vector};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

const EPS: f64 = f64::EPSILON;
const WEIGHTS: [f64; 5] = [1.0, 0.7, 1.2, 0.6, 0.9];

/// Numbers in (−1, 1), the same in every run.
fn draw<S: Real, const D: usize>(seed: usize) -> Tangent<S, D> {
    let mut normal = Normal(seed as u64 * 7919);
    Tangent::from_fn(|_, _| S::lit(2.0 * normal.uniform() - 1.0))
}

/// Elements within `size` of a generic one, in every coordinate.
fn cloud<G: LieGroup<D>, const D: usize>(size: f64) -> [G; 5] {
    let center = G::exp(&draw(40));
    core::array::from_fn(|i| center.rplus(&(draw::<G::Scalar, D>(i) * G::Scalar::lit(size))))
}

fn apart<G: LieGroup<D>, const D: usize>(x: &G, y: &G) -> f64 {
    x.rminus(y).iter().fold(0.0, |a: f64, c| a.max(c.value().abs()))
}

/// What holds of the bi-invariant mean on every group.
fn laws<G: LieGroup<D>, const D: usize>() {
    let (xs, bound) = (cloud::<G, D>(0.5), 2000.0 * G::Scalar::EPSILON);
    let same = |name: &str, x: &G, y: &G| {
        assert!(apart(x, y) < bound, "{name}, {}: {:.1e}", std::any::type_name::<G>(), apart(x, y));
    };
    let mean = |xs: &[G], weights: Weights<'_>| G::mean(xs, weights).unwrap().value;
    let found = G::mean(&xs, Weights::Of(&WEIGHTS)).unwrap();
    let m = found.value;
    assert!(found.residual < bound && found.iterations < 40 && found.beyond == 0.0);
    same("one element is its own mean", &mean(&xs[..1], Weights::Equal), &xs[0]);
    let middle = xs[0].interpolate(&xs[1], G::Scalar::lit(0.5));
    same("two elements meet halfway", &mean(&xs[..2], Weights::Equal), &middle);
    let quarter = xs[0].interpolate(&xs[1], G::Scalar::lit(0.25));
    same("weights divide the way", &mean(&xs[..2], Weights::Of(&[3.0, 1.0])), &quarter);
    same("equal weights are none", &mean(&xs, Weights::Of(&[0.3; 5])), &mean(&xs, Weights::Equal));
    let repeated = [xs[0], xs[0], xs[0], xs[1]];
    same("a weight is a multiplicity", &mean(&repeated, Weights::Equal), &quarter);
    let zero = [1.0, 1.0, 0.0, 0.0, 0.0];
    same("weight 0 does not count", &mean(&xs, Weights::Of(&zero)), &middle);
    let (mut ys, mut weights) = (xs, WEIGHTS);
    ys.rotate_left(2);
    weights.rotate_left(2);
    same("order does not matter", &mean(&ys, Weights::Of(&weights)), &m);
    let g = G::exp(&draw(77));
    same("left-invariant", &mean(&xs.map(|x| g.compose(&x)), Weights::Of(&WEIGHTS)), &g.compose(&m));
    same("right-invariant", &mean(&xs.map(|x| x.compose(&g)), Weights::Of(&WEIGHTS)), &m.compose(&g));
    same("inversion", &mean(&xs.map(|x| x.inverse()), Weights::Of(&WEIGHTS)), &m.inverse());
    let by_hand = xs.iter().fold(SVector::<f64, D>::zeros(), |sum, x| sum + x.rminus(&m).map(Real::value));
    let unweighted = G::mean(&xs, Weights::Equal).unwrap().value;
    assert!(by_hand.norm() > 0.01 || apart(&m, &unweighted) < bound, "weights matter");
}

macro_rules! groups {
    ($($name:ident: $group:ident<$($n:literal)?>, $d:literal;)*) => { $(
        mod $name {
            use super::*;
            #[test]
            fn mean_is_bi_invariant() {
                laws::<$group<$($n,)? f64>, $d>();
                laws::<$group<$($n,)? f32>, $d>();
            }
            #[test]
            fn other_means_are_stationary() {
                stationary::<$group<$($n,)? f64>, $d>();
            }
            #[test]
            fn at_hubers_mean_bounded_pulls_balance() {
                bounded_pulls_balance::<$group<$($n,)? f64>, $d>();
            }
            #[cfg(feature = "autodiff")]
            #[test]
            fn means_follow_their_elements() {
                dual::follow::<$group<$($n,)? f64>, $d>();
            }
        }
    )* };
}

groups! {
    rn: Rn<3>, 3;
    so2: SO2<>, 1;
    so3: SO3<>, 3;
    s3: S3<>, 3;
    se2: SE2<>, 3;
    se3: SE3<>, 6;
    r3xso3: R3xSO3<>, 6;
    se23: SE23<>, 9;
    sgal3: SGal3<>, 10;
    rxso2: RxSO2<>, 2;
    rxso3: RxSO3<>, 4;
    sim2: Sim2<>, 4;
    sim3: Sim3<>, 7;
}

/// At the geodesic mean and at the median the cost they minimise has no slope, and is larger all around.
fn stationary<G: LieGroup<D, Scalar = f64>, const D: usize>() {
    let (xs, metric) = (cloud::<G, D>(0.4), Tangent::<f64, D>::from_fn(|i, _| 1.0 + 0.3 * i as f64));
    let distances = |m: &G, power: i32| -> f64 {
        xs.iter().zip(WEIGHTS).map(|(x, w)| w * m.weighted_distance(x, &metric).powi(power)).sum()
    };
    let m = G::geodesic_mean(&xs, Weights::Of(&WEIGHTS), &metric).unwrap();
    assert!(m.residual < 200.0 * EPS && m.iterations < 60, "{}, {:.1e}", m.iterations, m.residual);
    let h = 1e-4; // the cubic term of the cost leaves h²
    for i in 0..D {
        let at = |t: f64| {
            let mut step = Tangent::zeros();
            step[i] = t;
            distances(&m.value.rplus(&step), 2)
        };
        let (slope, bend) = ((at(h) - at(-h)) / (2.0 * h), (at(h) + at(-h) - 2.0 * at(0.0)) / (h * h));
        assert!(slope.abs() < 1e-6 && bend > 0.1, "{}: {slope:.1e} {bend}", std::any::type_name::<G>());
    }
    let m = G::median(&xs, Weights::Of(&WEIGHTS), &metric).unwrap();
    assert!(m.residual < 1e-10, "{}, {:.1e}", m.iterations, m.residual);
    let (mut pulls, mut held) = (Tangent::<f64, D>::zeros(), 0.0);
    for (x, w) in xs.iter().zip(WEIGHTS) {
        let distance = m.value.weighted_distance(x, &metric);
        if distance > 1e-12 { pulls += x.rminus(&m.value) * (w / distance) } else { held += w }
    }
    let pull = metric.component_mul(&pulls).norm();
    assert!(pull < 1e-10 || pull <= held, "Σ w τ/‖τ‖ = {pulls}, held by {held}");
}

/// At Huber's mean what is beyond the threshold pulls as from there; without a threshold it is the mean, with none to speak of the median.
fn bounded_pulls_balance<G: LieGroup<D, Scalar = f64>, const D: usize>() {
    let (xs, metric) = (cloud::<G, D>(0.4), Tangent::<f64, D>::from_fn(|i, _| 1.0 + 0.3 * i as f64));
    let huber = |threshold| G::huber_mean(&xs, Weights::Of(&WEIGHTS), &metric, threshold).unwrap();
    for threshold in [0.1, 0.3, 0.6] {
        let m = huber(threshold);
        let sum = xs.iter().zip(WEIGHTS).fold(Tangent::<f64, D>::zeros(), |sum, (x, w)| {
            let reduced = (threshold / m.value.weighted_distance(x, &metric)).min(1.0);
            assert!((m.pull(x) - reduced).abs() < 1e-13);
            sum + x.rminus(&m.value) * (w * reduced)
        });
        assert!(sum.norm() < 1e-13 && m.residual < 1e-13, "{threshold}: {:.1e}", sum.norm());
    }
    let mean = G::mean(&xs, Weights::Of(&WEIGHTS)).unwrap().value;
    assert!(apart(&huber(f64::INFINITY).value, &mean) < 200.0 * EPS);
    assert!(apart(&huber(0.1).value, &mean) > 1e-4);
    let median = G::median(&xs, Weights::Of(&WEIGHTS), &metric).unwrap().value;
    assert!(apart(&huber(1e-3).value, &median) < 2e-3);
}

#[test]
fn on_rotations_the_geodesic_mean_is_the_bi_invariant_one_and_on_poses_it_is_not() {
    let rotations = cloud::<SO3, 3>(0.6);
    let mean = SO3::mean(&rotations, Weights::Of(&WEIGHTS)).unwrap();
    let geodesic = SO3::geodesic_mean(&rotations, Weights::Of(&WEIGHTS), &Vector3::repeat(2.0)).unwrap();
    assert!(apart(&mean.value, &geodesic.value) < 32.0 * EPS);
    assert!((mean.covariance.unwrap() - geodesic.covariance.unwrap()).amax() < 64.0 * EPS);
    let poses = cloud::<SE3, 6>(0.6);
    let mean = SE3::mean(&poses, Weights::Equal).unwrap();
    let geodesic = SE3::geodesic_mean(&poses, Weights::Equal, &Tangent::repeat(1.0)).unwrap();
    assert!(apart(&mean.value, &geodesic.value) > 1e-3);
    // A minimum of a left-invariant distance moves with the parent frame, not with the body's.
    let g = SE3::exp(&draw(77));
    let left =
        SE3::geodesic_mean(&poses.map(|x| g * x), Weights::Equal, &Tangent::repeat(1.0)).unwrap().value;
    let right =
        SE3::geodesic_mean(&poses.map(|x| x * g), Weights::Equal, &Tangent::repeat(1.0)).unwrap().value;
    assert!(apart(&left, &(g * geodesic.value)) < 1e-13);
    assert!(apart(&right, &(geodesic.value * g)) > 1e-3);
}

/// The gradient of Σ w‖M − Mᵢ‖² vanishes on the group.
fn chordal<G, const D: usize, const N: usize>(to_matrix: fn(&G) -> nalgebra::SMatrix<f64, N, N>)
where
    G: ChordalMean<D> + LieGroup<D, Scalar = f64>,
{
    let xs = cloud::<G, D>(0.5);
    let m = G::chordal_mean(&xs, Weights::Of(&WEIGHTS)).unwrap();
    let cost = |m: &G| -> f64 {
        xs.iter().zip(WEIGHTS).map(|(x, w)| w * (to_matrix(m) - to_matrix(x)).norm_squared()).sum()
    };
    let h = 1e-4;
    for i in 0..D {
        let at = |t: f64| {
            let mut step = Tangent::zeros();
            step[i] = t;
            cost(&m.rplus(&step))
        };
        let (slope, bend) = ((at(h) - at(-h)) / (2.0 * h), (at(h) + at(-h) - 2.0 * at(0.0)) / (h * h));
        assert!(slope.abs() < 2e-6 * cost(&m).max(1.0) && bend > 0.1, "{i}: {slope:.1e} {bend}");
    }
}

#[test]
fn chordal_means_are_nearest_to_all_matrices() {
    chordal::<SO2, 1, 2>(SO2::to_matrix);
    chordal::<SO3, 3, 3>(SO3::to_matrix);
    chordal::<SE2, 3, 3>(SE2::to_matrix);
    chordal::<SE3, 6, 4>(SE3::to_matrix);
    chordal::<SE23, 9, 5>(SE23::to_matrix);
    chordal::<SGal3, 10, 5>(SGal3::to_matrix);
    chordal::<RxSO2, 2, 2>(RxSO2::to_matrix);
    chordal::<RxSO3, 4, 3>(RxSO3::to_matrix);
    chordal::<Sim2, 4, 3>(Sim2::to_matrix);
    chordal::<Sim3, 7, 4>(Sim3::to_matrix);
    let around = [0.0, FRAC_PI_2, PI, -FRAC_PI_2].map(SO2::from_angle);
    assert!(matches!(SO2::chordal_mean(&around, Weights::Equal), Err(LieError::Undetermined { .. })));
    assert_eq!(SO3::<f64>::chordal_mean(&[], Weights::Equal), Err(LieError::NoElements));
}

#[test]
fn chordal_mean_of_rotations_is_the_top_eigenvector_of_their_quaternions() {
    let xs = cloud::<SO3, 3>(0.6);
    let m = SO3::chordal_mean(&xs, Weights::Of(&WEIGHTS)).unwrap();
    let q = |x: &SO3| SVector::<f64, 4>::from(x.quaternion_xyzw());
    let sum =
        xs.iter().zip(WEIGHTS).map(|(x, w)| q(x) * q(x).transpose() * w).sum::<nalgebra::Matrix4<f64>>();
    let eigen = sum.symmetric_eigen();
    let top = eigen.eigenvectors.column(eigen.eigenvalues.imax()).into_owned();
    assert!(1.0 - top.dot(&q(&m)).abs() < 8.0 * EPS);
    // Of third order in the spread: an eighth for half of it.
    let off = |size: f64| {
        let xs = cloud::<SO3, 3>(size);
        let chordal = SO3::chordal_mean(&xs, Weights::Equal).unwrap();
        apart(&chordal, &SO3::mean(&xs, Weights::Equal).unwrap().value)
    };
    let slope = (off(0.2) / off(0.1)).log2();
    assert!((slope - 3.0).abs() < 0.1, "{slope}");
}

#[test]
fn elements_too_dispersed_for_one_mean_are_refused_with_the_bound() {
    let refused = |angles: &[f64], reach: f64| {
        let xs: Vec<SO2> = angles.iter().map(|&a| SO2::from_angle(a)).collect();
        let Err(LieError::TooDispersed { reach: found, .. }) = SO2::mean(&xs, Weights::Equal) else {
            panic!("{angles:?}: {:?}", SO2::mean(&xs, Weights::Equal));
        };
        assert!((found - reach).abs() < 1e-6, "{angles:?}: {found}");
    };
    refused(&[0.0, PI], 0.5); // antipodal: two means
    refused(&[0.7, 0.7 - PI], 0.5);
    refused(&[0.0, PI / 1.5, -PI / 1.5], 2.0 / 3.0); // all around
    assert!(SO2::mean(&[0.0, 0.999 * PI].map(SO2::from_angle), Weights::Equal).is_ok());
    // The one that is named counts.
    let xs = [0.0, 1.0, 2.0, PI].map(SO2::from_angle);
    let error = SO2::mean(&xs, Weights::Of(&[1.0, 0.0, 1.0, 0.0])).err();
    assert_eq!(error, None, "what has no weight may be anywhere");
    let xs = [0.0, PI, 2.5].map(SO2::from_angle);
    let Err(LieError::TooDispersed { index, reach }) = SO2::mean(&xs, Weights::Of(&[1.0, 0.0, 0.01])) else {
        panic!("2.5 rad are beyond a quarter turn");
    };
    assert!(index == 2 && reach < 0.8, "element {index} at {reach}");
    // Rounding of long translations is no jump.
    for length in [1e17, 1e30] {
        let far = [0.0, 1.0].map(|s| SE3::exp(&(vector![1.0, -2.0, 0.5, 0.3, 0.2, 0.6] * s)));
        let far = far.map(|x| SE3::new(x.rotation(), x.translation() * length));
        assert!(SE3::mean(&far, Weights::Equal).is_ok(), "{length:e}");
    }
    // Rotations by half a turn about any axis, and with a translation beside.
    for i in 0..20 {
        let half = draw::<f64, 3>(i).normalize() * PI;
        let (e, x) = (SO3::identity(), SO3::exp(&half));
        assert!(matches!(SO3::mean(&[e, x], Weights::Equal), Err(LieError::TooDispersed { .. })), "{i}");
        let poses = [SE3::identity(), SE3::new(x, draw(i) * 100.0)];
        assert!(matches!(SE3::mean(&poses, Weights::Equal), Err(LieError::TooDispersed { .. })), "{i}");
        let near = [e, SO3::exp(&(half * (1.0 - 1e-6)))];
        assert!(SO3::mean(&near, Weights::Equal).is_ok());
        let single = [SO3::<f32>::identity(), SO3::exp(&half.map(|c| c as f32))];
        assert!(matches!(SO3::mean(&single, Weights::Equal), Err(LieError::TooDispersed { .. })), "{i}");
        // Unit quaternions cover twice: theirs is half a turn of q, twice as far.
        let quaternions = [S3::identity(), S3::exp(&half)];
        assert!(S3::mean(&quaternions, Weights::Equal).is_ok());
    }
    // The rotations may be anywhere in a bundle, the translations anywhere at all.
    let far = [1e9, -1e9].map(|x| R3xSO3::new(SO3::about_z(x * 1e-9), Vector3::x() * x));
    assert!(R3xSO3::mean(&far, Weights::Equal).unwrap().value.translation().norm() < 1e-6);
    let error = SO3::mean(&[0.0, 2.0, 4.0].map(SO3::about_z), Weights::Equal).unwrap_err();
    assert!(error.to_string().contains("of the way to the cut locus"), "{error}");
}

#[test]
fn what_is_no_weight_or_no_element_is_refused() {
    let xs = cloud::<SE2, 3>(0.3);
    let mean = |weights: &[f64]| SE2::mean(&xs, Weights::Of(weights)).unwrap_err();
    assert_eq!(SE2::<f64>::mean(&[], Weights::Equal).unwrap_err(), LieError::NoElements);
    assert_eq!(SE2::<f64>::mean(&[], Weights::Of(&[])).unwrap_err(), LieError::NoElements);
    assert_eq!(mean(&[1.0; 4]), LieError::WeightCount { elements: 5, weights: 4 });
    assert_eq!(mean(&[1.0, -1.0, 1.0, 1.0, 1.0]), LieError::NotAWeight { index: 1, weight: -1.0 });
    assert!(matches!(mean(&[1.0, 1.0, f64::NAN, 1.0, 1.0]), LieError::NotAWeight { index: 2, .. }));
    assert!(matches!(mean(&[f64::INFINITY; 5]), LieError::NotAWeight { index: 0, .. }));
    assert_eq!(mean(&[0.0; 5]), LieError::NoWeight);
    let lost = [xs[0], SE2::exp(&vector![f64::NAN, 0.0, 0.0])];
    assert_eq!(SE2::mean(&lost, Weights::Equal).unwrap_err(), LieError::NotFinite);
    assert_eq!(SE2::median(&lost, Weights::Equal, &Tangent::repeat(1.0)).unwrap_err(), LieError::NotFinite);
    // Weights whose sum overflows are weights.
    let huge = SE2::mean(&xs, Weights::Of(&[1e308; 5])).unwrap().value;
    assert!(apart(&huge, &SE2::mean(&xs, Weights::Equal).unwrap().value) < 16.0 * EPS);
    assert_eq!(SE2::mean(&xs[..1], Weights::Equal).unwrap().covariance, None);
}

#[test]
fn an_iteration_that_does_not_settle_is_told() {
    // Similarities whose scales span e²⁰ about translations of that size: the fixed point runs away.
    let xs = [0.0, 3.0, -3.0]
        .map(|s| Sim3::exp(&Tangent::from([40.0 * s, 1.0, -2.0 * s, 0.5 * s, 0.3, -0.4 * s, 8.0 * s])));
    let found = Sim3::mean(&xs, Weights::Of(&[1.0, 1.0, 3.0]));
    assert!(matches!(found, Err(LieError::NotConverged { iterations: 100, .. })));
    // Three rotations on a circle of 120°: Weiszfeld's iteration about the first ends there, and is refused.
    let around = [0.0, 2.0 * PI / 3.0, -2.0 * PI / 3.0].map(SO2::from_angle);
    assert!(SO2::median(&around, Weights::Equal, &Vector1::new(1.0)).is_err());
}

#[test]
fn the_dispersion_is_the_weighted_mean_square() {
    let [near, far] = [0.0, 4.0].map(|x| Rn::<1>::new(Vector1::new(x)));
    let mean = Rn::mean(&[near, far], Weights::Of(&[3.0, 1.0])).unwrap(); // at 1: ¾·1² + ¼·3²
    assert_eq!((mean.value.vector().x, mean.dispersion.x, mean.radius), (1.0, 3.0, 3.0));
}

#[test]
fn poses_and_pairs_of_translation_and_rotation_have_different_means() {
    let ends = [SE3::identity(), SE3::exp(&vector![1.0, 0.0, 0.0, 0.0, 0.0, FRAC_PI_2])];
    let arc = SE3::mean(&ends, Weights::Equal).unwrap().value;
    let chord = R3xSO3::mean(&ends.map(|x| R3xSO3::from_pose(&x)), Weights::Equal).unwrap().value;
    let radius = 1.0 / FRAC_PI_2;
    let on_the_circle = Vector3::new(FRAC_PI_4.sin(), 1.0 - FRAC_PI_4.cos(), 0.0) * radius;
    assert!((arc.translation() - on_the_circle).norm() < 4.0 * EPS);
    assert!((chord.translation() - ends[1].translation() * 0.5).norm() < 4.0 * EPS);
    assert!(arc.rotation().between(&chord.rotation()).log().norm() < 4.0 * EPS);
}

#[cfg(feature = "autodiff")]
mod dual {
    use super::*;
    use boxplus::lie::Mean;
    use nalgebra::{Const, SMatrix};
    use num_dual::DualSVec64;

    type Elements<G, const D: usize> = [<G as LieGroup<D>>::Over<DualSVec64<D>>; 5];

    /// The closed Jacobian of a mean by its third element against dual numbers carried through the iterations.
    fn follows<G: LieGroup<D, Scalar = f64>, const D: usize>(
        name: &str,
        mean: impl Fn(&[G]) -> Mean<G, D>,
        dual_mean: impl Fn(&Elements<G, D>) -> G::Over<DualSVec64<D>>,
    ) {
        let xs = cloud::<G, D>(0.5);
        let plain = mean(&xs);
        let closed = plain.jac(&xs[2], WEIGHTS[2] / WEIGHTS.iter().sum::<f64>()).unwrap();
        let mut duals = xs.map(|x| x.map(DualSVec64::<D>::from_re));
        let unknown = SVector::from_fn(|i, _| DualSVec64::<D>::from_re(0.0).derivative(i));
        duals[2] = duals[2].rplus(&unknown);
        let base = plain.value.map(DualSVec64::<D>::from_re);
        let rows = dual_mean(&duals).rminus(&base).map(|d| d.eps.unwrap_generic(Const::<D>, Const::<1>));
        let dual = SMatrix::<f64, D, D>::from_fn(|i, j| rows[i][j]);
        let error = (dual - closed).amax();
        assert!(error < 1e-10, "{name} of {}: {error:.1e}\n{dual}{closed}", std::any::type_name::<G>());
    }

    pub(super) fn follow<G: LieGroup<D, Scalar = f64>, const D: usize>() {
        let (weights, metric) =
            (Weights::Of(&WEIGHTS), Tangent::<f64, D>::from_fn(|i, _| 1.0 + 0.3 * i as f64));
        let dual_metric = metric.map(DualSVec64::<D>::from_re);
        follows::<G, D>(
            "mean",
            |xs| G::mean(xs, weights).unwrap(),
            |xs| Means::mean(xs, weights).unwrap().value,
        );
        follows::<G, D>(
            "geodesic mean",
            |xs| G::geodesic_mean(xs, weights, &metric).unwrap(),
            |xs| Means::geodesic_mean(xs, weights, &dual_metric).unwrap().value,
        );
        follows::<G, D>(
            "Huber's mean",
            |xs| G::huber_mean(xs, weights, &metric, 0.4).unwrap(),
            |xs| Means::huber_mean(xs, weights, &dual_metric, 0.4).unwrap().value,
        );
        // In one dimension the median of an odd number sits on one of them.
        if D > 1 {
            follows::<G, D>(
                "median",
                |xs| G::median(xs, weights, &metric).unwrap(),
                |xs| Means::median(xs, weights, &dual_metric).unwrap().value,
            );
        }
    }
}

/// Independent standard normal numbers by Box & Muller (1958) from SplitMix64.
struct Normal(u64);

impl Normal {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (((z ^ (z >> 31)) >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }
    fn vector<const D: usize>(&mut self) -> Tangent<f64, D> {
        Tangent::from_fn(|_, _| (-2.0 * self.uniform().ln()).sqrt() * (2.0 * PI * self.uniform()).cos())
    }
}
