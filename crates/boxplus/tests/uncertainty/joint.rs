//! Correlated elements: products and displacements against Monte Carlo on both sides, conditioning against linear algebra.

use crate::monte_carlo::{AGREES, DISAGREES, Moments};
use boxplus::lie::{LieGroup, Rn, SE2, SE3, SO3};
use boxplus::uncertainty::{Covariance, Gaussian, Global, Joint, Local, Order, Pair, Side};
use nalgebra::{SMatrix, SVector, matrix, vector};

/// A pair with everything correlated, and the two factors of its errors: ξ₁ = L₁η, ξ₂ = L₂η, η of twice the dimension.
struct Case<G: LieGroup<D, Scalar = f64>, E: Side, const D: usize, const N: usize> {
    pair: Pair<G, D, G, D, E>,
    l1: SMatrix<f64, D, N>,
    l2: SMatrix<f64, D, N>,
}

fn case<G: LieGroup<D, Scalar = f64>, E: Side, const D: usize, const N: usize>(
    sigma: f64,
) -> Case<G, E, D, N> {
    let factor = |k: usize| {
        SMatrix::<f64, D, N>::from_fn(|i, j| ((i * i + 3 * i * j + 5 * k + j * j + 1) as f64).sin())
            * (sigma / (N as f64).sqrt())
    };
    // Half of the second error is the first one's.
    let (l1, l2) = (factor(1), factor(1) * 0.5 + factor(2) * 0.7);
    let element = |k: usize, l: &SMatrix<f64, D, N>| {
        let tau = SVector::<f64, D>::from_fn(|i, _| 0.7 * ((3 * i + k) as f64).cos());
        Gaussian::new(G::exp(&tau), Covariance::new(l * l.transpose()).unwrap())
    };
    let pair = Pair::new(element(1, &l1), element(2, &l2), l1 * l2.transpose()).unwrap();
    Case { pair, l1, l2 }
}

type Operation<G, E, const D: usize> = fn(&Pair<G, D, G, D, E>, Order) -> Gaussian<G, D, E>;

/// Both orders of one operation beside Monte Carlo; ignoring the correlation must be seen.
fn agrees<G: LieGroup<D, Scalar = f64>, E: Side, const D: usize, const N: usize>(
    name: &str,
    sigma: f64,
    seed: u64,
    operation: Operation<G, E, D>,
    exact: fn(&G, &G) -> G,
) {
    let Case { pair, l1, l2 } = case::<G, E, D, N>(sigma);
    let [first, second, fourth] = [Order::First, Order::Second, Order::Fourth].map(|o| operation(&pair, o));
    let ignorant = operation(&Pair::independent(*pair.first(), *pair.second()), Order::Fourth);
    let about = |x: &Gaussian<G, D, E>, draw: &G| x.error_of(draw);
    // The error is linear but for its second order, which is the control's remainder: J₁ξ₁ + J₂ξ₂ by differences.
    let [x, y] = [*pair.first(), *pair.second()];
    let h = 1e-4;
    let column = |k: usize| {
        let at = |s: f64| {
            let draw =
                exact(&x.perturbed(&(l1.column(k) * (s * h))), &y.perturbed(&(l2.column(k) * (s * h))));
            about(&first, &draw)
        };
        (at(1.0) - at(-1.0)) / (2.0 * h)
    };
    let linear = SMatrix::<f64, D, N>::from_fn(|i, k| column(k)[i]);
    let moments = Moments::controlled(200_000, seed, &(linear * linear.transpose()), |normal| {
        let eta = normal.vector::<N>();
        let draw = exact(&x.perturbed(&(l1 * eta)), &y.perturbed(&(l2 * eta)));
        (about(&first, &draw), linear * eta)
    });
    // Told about the mean of the means.
    let shift = first.error_of(fourth.mean());
    let back = E::jacobian_inverse::<G, D>(&shift);
    let told = back * fourth.covariance().matrix() * back.transpose();
    let off = moments.covariance_off(&told);
    assert!(off < AGREES, "{name}: fourth order is {off:.1} standard errors off");
    assert!(moments.mean_off(&shift) < AGREES, "{name}: mean {:.1}", moments.mean_off(&shift));
    assert!(moments.mean_off(&SVector::zeros()) > DISAGREES, "{name}: the mean shifts");
    assert!(second.mean().rminus(first.mean()).norm() > 0.0);
    let off = moments.covariance_off(second.covariance().matrix());
    assert!(off > DISAGREES, "{name}: second order is only {off:.1} standard errors off");
    let relative = |m: &SMatrix<f64, D, D>| (m - moments.covariance).norm() / moments.covariance.norm();
    assert!(relative(second.covariance().matrix()) < 0.05, "{}", relative(second.covariance().matrix()));
    assert!(relative(ignorant.covariance().matrix()) > 0.15, "{name}: correlation matters");
}

#[test]
fn correlated_products_agree_with_monte_carlo_on_both_sides() {
    agrees::<SO3, Local, 3, 6>("SO(3) local", 0.12, 21, Pair::compose, G::product);
    agrees::<SE3, Local, 6, 12>("SE(3) local", 0.18, 22, Pair::compose, G::product);
    agrees::<SE3, Global, 6, 12>("SE(3) global", 0.19, 23, Pair::compose, G::product);
    agrees::<SE2, Global, 3, 6>("SE(2) global", 0.2, 24, Pair::compose, G::product);
}

#[test]
fn correlated_displacements_agree_with_monte_carlo_on_both_sides() {
    agrees::<SO3, Global, 3, 6>("SO(3) global", 0.12, 25, Pair::between, G::displacement);
    agrees::<SE3, Local, 6, 12>("SE(3) local", 0.12, 26, Pair::between, G::displacement);
    agrees::<SE3, Global, 6, 12>("SE(3) global", 0.12, 27, Pair::between, G::displacement);
}

/// The operations on known elements.
struct G;
impl G {
    fn product<X: LieGroup<D>, const D: usize>(x: &X, y: &X) -> X {
        x.compose(y)
    }
    fn displacement<X: LieGroup<D>, const D: usize>(x: &X, y: &X) -> X {
        x.between(y)
    }
}

#[test]
fn the_corrected_table_holds_and_its_misprints_do_not() {
    let global = case::<SE3, Global, 6, 12>(0.1).pair;
    let local = case::<SE3, Local, 6, 12>(0.1).pair;
    let near = |x: &SMatrix<f64, 6, 6>, y: &SMatrix<f64, 6, 6>| (x - y).norm() / y.norm();
    let parts = |pair: [SMatrix<f64, 6, 6>; 3]| pair;
    let [s1, s2, s] = parts([
        *global.first().covariance().matrix(),
        *global.second().covariance().matrix(),
        *global.cross(),
    ]);
    let (x, y) = (global.first().mean(), global.second().mean());
    let (a, inverse) = (x.adjoint(), x.inverse().adjoint());
    let product = *global.compose(Order::First).covariance().matrix();
    let table = s1 + a * s2 * a.transpose() + s * a.transpose() + a * s.transpose();
    assert!(near(&table, &product) < 1e-14);
    let relative = *global.between(Order::First).covariance().matrix();
    let table = inverse * (s1 + s2 - s - s.transpose()) * inverse.transpose();
    assert!(near(&table, &relative) < 1e-14);
    let untransposed = inverse * (s1 + s2 - s - s) * inverse.transpose();
    assert!(near(&untransposed, &relative) > 0.1, "K39: the first term lacks its transpose");
    let printed = inverse * s1 * a.transpose();
    assert!(near(&printed, global.first().inverse().covariance().matrix()) > 0.5, "K38: Ad on one side");

    let [s1, s2, s] =
        [*local.first().covariance().matrix(), *local.second().covariance().matrix(), *local.cross()];
    let b = y.inverse().adjoint();
    let table = b * s1 * b.transpose() + s2 + b * s + s.transpose() * b.transpose();
    assert!(near(&table, local.compose(Order::First).covariance().matrix()) < 1e-14);
    let m = y.inverse().compose(x).adjoint();
    let table = m * s1 * m.transpose() + s2 - m * s - s.transpose() * m.transpose();
    assert!(near(&table, local.between(Order::First).covariance().matrix()) < 1e-14);
    let of_the_other_side = s1 + a * s2 * a.transpose() + s * a.transpose() + a * s.transpose();
    assert!(near(&of_the_other_side, local.compose(Order::First).covariance().matrix()) > 0.3, "K36");
}

#[test]
fn conditioning_is_that_of_vectors_where_the_group_is_flat() {
    let joint = matrix![4.0, 1.0, 0.5; 1.0, 2.0, 0.3; 0.5, 0.3, 1.0];
    let x = Gaussian::<Rn<2>, 2>::new(
        Rn::new(vector![1.0, 2.0]),
        Covariance::new(joint.fixed_view::<2, 2>(0, 0).into_owned()).unwrap(),
    );
    let y = Gaussian::<Rn<1>, 1>::new(Rn::new(vector![3.0]), Covariance::new(matrix![1.0]).unwrap());
    let pair = Pair::new(x, y, vector![0.5, 0.3]).unwrap();
    let given = pair.given_second(&Rn::new(vector![5.0]));
    assert!((given.mean().vector() - vector![2.0, 2.6]).amax() < 1e-15);
    assert!((given.covariance().matrix() - matrix![3.75, 0.85; 0.85, 1.91]).amax() < 1e-15);
    let other = pair.given_first(&Rn::new(vector![1.0, 2.0]));
    let schur = 1.0
        - (vector![0.5, 0.3].transpose()
            * matrix![4.0, 1.0; 1.0, 2.0].try_inverse().unwrap()
            * vector![0.5, 0.3])
        .x;
    assert!((other.covariance().matrix().x - schur).abs() < 1e-15);
}

#[test]
fn knowing_one_element_of_another_group_moves_the_other() {
    // A pose and a point it carries: Y = X·p. Once the point is known, what remains is the turn about it.
    let pose = Gaussian::<SE2, 3>::from_sigmas(SE2::new(vector![1.0, 2.0], 0.4), &vector![0.01, 0.01, 0.01])
        .unwrap();
    let p = vector![2.0, 0.0];
    let (_, j, _) = boxplus::lie::Action::act_jac(pose.mean(), &p);
    let seen = pose.act(&p, Order::First);
    let pair = Pair::new(pose, seen, pose.covariance().matrix() * j.transpose()).unwrap();
    let truth = pose.perturbed(&vector![0.005, -0.01, 0.004]);
    let point = boxplus::lie::Action::act(&truth, &p);
    let given = pair.given_second(&Rn::new(point));
    let predicted = given.act(&p, Order::First);
    assert!((predicted.mean().vector() - point).norm() < 1e-4, "second order in the error");
    assert!(predicted.covariance().matrix().amax() < 1e-6, "beside 5e-4 before");
    assert_eq!(given.covariance().rank(), 1);
}

#[test]
fn a_joint_of_many_is_consistent_with_its_pairs() {
    fn check<E: Side>() {
        let step = |k: usize| {
            let tau = SVector::<f64, 6>::from_fn(|i, _| 0.5 * ((2 * i + k) as f64).sin());
            let l = SMatrix::<f64, 6, 6>::from_fn(|i, j| 0.03 * ((i + 3 * j * i + k) as f64).cos());
            Gaussian::<SE3, 6, E>::new(SE3::exp(&tau), Covariance::new(l * l.transpose()).unwrap())
        };
        let steps = [0, 1, 2, 3].map(step);
        let poses = Joint::along(&steps);
        let chained = Gaussian::chain(&steps, Order::Second);
        let error = poses.marginal(3).covariance().matrix() - chained.covariance().matrix();
        assert!(error.amax() < 1e-15 && poses.marginal(3).mean().rminus(chained.mean()).norm() < 1e-14);
        for k in 0..3 {
            let again = poses.pair(k, k + 1).between(Order::Second);
            assert!((again.covariance().matrix() - steps[k + 1].covariance().matrix()).amax() < 1e-14);
        }
        let means = [0, 1, 2, 3].map(|k| *poses.marginal(k).mean());
        let blocks = [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| *poses.cross(i, j)));
        let rebuilt = Joint::<SE3, 6, 4, E>::new(means, blocks).unwrap();
        assert!((rebuilt.cross(0, 3) - poses.cross(0, 3)).amax() < 1e-17);
        let fix = poses.marginal(3).perturbed(&SVector::repeat(0.01));
        let given = poses.given(3, &fix);
        assert_eq!(given.marginal(3).covariance().matrix().amax(), 0.0);
        assert!(given.marginal(3).mean().rminus(&fix).norm() < 1e-14);
        let alone = poses.pair(1, 3).given_second(&fix);
        assert!((given.marginal(1).covariance().matrix() - alone.covariance().matrix()).amax() < 1e-15);
        assert!(given.marginal(1).mean().rminus(alone.mean()).norm() < 1e-14);
        let other = poses.to_opposite().pair(1, 2).between(Order::Fourth).to_opposite();
        let here = poses.pair(1, 2).between(Order::Fourth);
        assert!((other.covariance().matrix() - here.covariance().matrix()).amax() < 1e-14);
        let mut wrong = blocks;
        wrong[0][3] *= 40.0;
        wrong[3][0] *= 40.0;
        assert!(Joint::<SE3, 6, 4, E>::new(means, wrong).is_err());
    }
    check::<Local>();
    check::<Global>();
}

/// The whole joint covariance of a pair of two-dimensional vectors.
fn whole(pair: &Pair<Rn<2>, 2, Rn<2>, 2>) -> (SVector<f64, 4>, SMatrix<f64, 4, 4>) {
    let mut p = SMatrix::<f64, 4, 4>::zeros();
    p.fixed_view_mut::<2, 2>(0, 0).copy_from(pair.first().covariance().matrix());
    p.fixed_view_mut::<2, 2>(2, 2).copy_from(pair.second().covariance().matrix());
    p.fixed_view_mut::<2, 2>(0, 2).copy_from(pair.cross());
    p.fixed_view_mut::<2, 2>(2, 0).copy_from(&pair.cross().transpose());
    let (x, y) = (pair.first().mean().vector(), pair.second().mean().vector());
    (vector![x.x, x.y, y.x, y.y], p)
}

#[test]
fn an_uncertain_measurement_of_one_vector_is_a_kalman_update_of_both() {
    let Case { pair, .. } = case::<Rn<2>, Local, 2, 4>(0.8);
    let measured =
        Gaussian::new(Rn::new(vector![0.4, -0.3]), Covariance::new(matrix![0.3, 0.1; 0.1, 0.2]).unwrap());
    let (x, p) = whole(&pair);
    for first in [false, true] {
        let mut h = SMatrix::<f64, 2, 4>::zeros();
        h.fixed_view_mut::<2, 2>(0, if first { 0 } else { 2 }).fill_with_identity();
        let s = h * p * h.transpose() + measured.covariance().matrix();
        let gain = p * h.transpose() * s.try_inverse().unwrap();
        let expected = (x + gain * (measured.mean().vector() - h * x), p - gain * h * p);
        let observed = if first { pair.observing_first(&measured) } else { pair.observing_second(&measured) };
        let (mean, covariance) = whole(&observed);
        assert!((mean - expected.0).amax() < 1e-14 && (covariance - expected.1).amax() < 1e-14, "{first}");
        let joint = Joint::new(
            [*pair.first().mean(), *pair.second().mean()],
            [
                [*pair.first().covariance().matrix(), *pair.cross()],
                [pair.cross().transpose(), *pair.second().covariance().matrix()],
            ],
        );
        let of_joint = joint.unwrap().observing(usize::from(!first), &measured).pair(0, 1);
        let (mean, covariance) = whole(&of_joint);
        assert!((mean - expected.0).amax() < 1e-14 && (covariance - expected.1).amax() < 1e-14, "{first}");
    }
}

#[test]
fn a_certain_measurement_is_conditioning_and_a_vague_one_is_none() {
    let Case { pair, .. } = case::<SE3, Local, 6, 12>(0.2);
    let place = pair.second().perturbed(&(SVector::repeat(0.1)));
    let (given, known) = (pair.given_second(&place), pair.observing_second(&Gaussian::certain(place)));
    assert!((given.covariance().matrix() - known.first().covariance().matrix()).amax() < 1e-12);
    assert!(given.error_of(known.first().mean()).amax() < 1e-12);
    assert!(known.second().covariance().matrix().amax() < 1e-12 && known.cross().amax() < 1e-12);
    let vague = pair.observing_second(&Gaussian::new(place, Covariance::unit() * 1e6));
    assert!((vague.first().covariance().matrix() - pair.first().covariance().matrix()).amax() < 1e-10);
    assert!((vague.cross() - pair.cross()).amax() < 1e-10);
}

#[test]
fn a_measurement_says_the_same_on_both_sides() {
    let Case { pair, .. } = case::<SE3, Local, 6, 12>(0.2);
    let tau = SVector::<f64, 6>::from_fn(|i, _| 0.2 * (i as f64).sin());
    let measured = Gaussian::new(pair.second().perturbed(&tau), Covariance::unit() * 0.1);
    let local = pair.observing_second(&measured);
    let global = pair.to_opposite().observing_second(&measured.to_opposite()).to_opposite();
    assert!((local.cross() - global.cross()).amax() < 1e-13);
    assert!((local.first().covariance().matrix() - global.first().covariance().matrix()).amax() < 1e-13);
    assert!(local.first().error_of(global.first().mean()).amax() < 1e-13);
    let joint = Joint::along(&[*pair.first(), *pair.second()]);
    let seen = Gaussian::new(joint.marginal(1).perturbed(&tau), Covariance::unit() * 0.1);
    let (a, b) = (joint.observing(1, &seen).pair(0, 1), joint.pair(0, 1).observing_second(&seen));
    assert!((a.cross() - b.cross()).amax() < 1e-13);
    assert!((a.second().covariance().matrix() - b.second().covariance().matrix()).amax() < 1e-13);
}
