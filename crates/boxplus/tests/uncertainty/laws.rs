//! Laws that hold for every group, on both sides, in `f64` and `f32`.

use boxplus::lie::{LieGroup, Real, Rn, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3};
use boxplus::uncertainty::{Covariance, Gaussian, Global, Local, Order, Pair, Side};
use nalgebra::{SMatrix, SVector};

const ORDERS: [Order; 3] = [Order::First, Order::Second, Order::Fourth];

fn element<G: LieGroup<D>, E: Side, const D: usize>(k: usize, sigma: f64) -> Gaussian<G, D, E> {
    let lit = G::Scalar::lit;
    let tau = SVector::from_fn(|i, _| lit(0.6 * ((3 * i + 5 * k + 1) as f64).cos()));
    let l = SMatrix::<G::Scalar, D, D>::from_fn(|i, j| {
        lit(sigma * (((i * i + 3 * i * j + 7 * k + j) as f64).sin() + f64::from(u8::from(i == j))))
    });
    Gaussian::new(G::exp(&tau), Covariance::new(l * l.transpose()).unwrap())
}

/// The same mean and covariance, to a few dozen roundings of their size.
fn same<G: LieGroup<D>, E: Side, const D: usize>(law: &str, x: &Gaussian<G, D, E>, y: &Gaussian<G, D, E>) {
    same_within(law, x, y, 1.0);
}

/// The same, where rounding is amplified by a condition number.
fn same_within<G: LieGroup<D>, E: Side, const D: usize>(
    law: &str,
    x: &Gaussian<G, D, E>,
    y: &Gaussian<G, D, E>,
    condition: f64,
) {
    let size = |m: &SMatrix<G::Scalar, D, D>| m.iter().fold(0.0, |a: f64, x| a.max(x.value().abs()));
    let bound = 512.0 * G::Scalar::EPSILON * condition;
    let covariance = size(&(x.covariance().matrix() - y.covariance().matrix()));
    let scale = size(x.covariance().matrix());
    assert!(covariance <= bound * scale, "{law}: covariances differ by {covariance:e} of {scale:e}");
    let mean = x.mean().rminus(y.mean()).norm_squared().value().sqrt();
    assert!(mean <= bound * 8.0, "{law}: means differ by {mean:e}");
}

fn laws<G: LieGroup<D>, E: Side, const D: usize>() {
    let name = std::any::type_name::<(G, E)>();
    let said = |law: &str| format!("{name}: {law}");
    let [x, y, z] = [1, 2, 3].map(|k| element::<G, E, D>(k, 0.05));
    let known = *y.mean();

    same(&said("the other side and back"), &x.to_opposite().to_opposite(), &x);
    same(&said("X⁻¹⁻¹ = X"), &x.inverse().inverse(), &x);
    same(&said("inverse on the other side"), &x.to_opposite().inverse().to_opposite(), &x.inverse());
    same(
        &said("change_parent on the other side"),
        &x.to_opposite().change_parent(&known).to_opposite(),
        &x.change_parent(&known),
    );
    same(
        &said("change_body on the other side"),
        &x.to_opposite().change_body(&known).to_opposite(),
        &x.change_body(&known),
    );
    let theta = SVector::<G::Scalar, D>::from_fn(|i, _| G::Scalar::lit(0.3 * ((i + 1) as f64).sin()));
    let other = E::to_opposite(x.mean()) * theta;
    same(&said("reset on the other side"), &x.to_opposite().reset(&other).to_opposite(), &x.reset(&theta));
    same(
        &said("transport on the other side"),
        &x.to_opposite().transport(&other).to_opposite(),
        &x.transport(&theta),
    );
    for order in ORDERS {
        let product = x.compose(&y, order);
        same(
            &said("compose on the other side"),
            &x.to_opposite().compose(&y.to_opposite(), order).to_opposite(),
            &product,
        );
        same(
            &said("between on the other side"),
            &x.to_opposite().between(&y.to_opposite(), order).to_opposite(),
            &x.between(&y, order),
        );
        same(
            &said("X·B, B certain, is a change of body"),
            &x.compose(&Gaussian::certain(known), order),
            &x.change_body(&known),
        );
        same(
            &said("A·X, A certain, is a change of parent"),
            &Gaussian::certain(known).compose(&x, order),
            &x.change_parent(&known),
        );
        same(&said("(XY)⁻¹ = Y⁻¹X⁻¹"), &product.inverse(), &y.inverse().compose(&x.inverse(), order));
        assert!(Covariance::new(*product.covariance().matrix()).is_ok());
    }
    let second = Order::Second;
    same(
        &said("(XY)Z = X(YZ)"),
        &x.compose(&y, second).compose(&z, second),
        &x.compose(&y.compose(&z, second), second),
    );
    same(
        &said("a chain is its products"),
        &Gaussian::chain(&[x, y, z], second),
        &x.compose(&y, second).compose(&z, second),
    );

    // Correlated: what both ends of a step share cancels in the displacement.
    let l = x.covariance().factor();
    let cross = l * y.covariance().factor().transpose() * G::Scalar::lit(0.4);
    let pair = Pair::new(x, y, cross).unwrap();
    for start in [Pair::independent(x, y), pair] {
        same(&said("X⁻¹(XY) = Y"), &start.with_product().between(Order::First), &y);
        same(&said("(X⁻¹)⁻¹ and Y⁻¹"), &start.inverted().inverted().compose(second), &start.compose(second));
        let turned = start.to_opposite();
        for order in ORDERS {
            same(
                &said("correlated compose on the other side"),
                &turned.compose(order).to_opposite(),
                &start.compose(order),
            );
            same(
                &said("correlated between on the other side"),
                &turned.between(order).to_opposite(),
                &start.between(order),
            );
        }
    }
    // Z known: no more uncertain than before, in any direction.
    let given = pair.given_second(y.mean());
    assert!(Covariance::new(x.covariance().matrix() - given.covariance().matrix()).is_ok(), "{name}");

    let fused = Gaussian::fuse([&x, &x]).unwrap().estimate;
    let halved = Gaussian::new(*x.mean(), *x.covariance() * G::Scalar::lit(0.5_f64.sqrt()));
    let variances = x.covariance().principal_axes().0;
    let condition = variances[0] / variances[D - 1]; // of the inverse
    same_within(&said("two equal estimates halve the variance"), &fused, &halved, condition);

    // Samples: the mean of ± pairs is the mean, the covariance that of the factor's columns.
    let spread = G::Scalar::lit((D as f64 - 0.5).sqrt());
    let plus: [G; D] = std::array::from_fn(|k| x.perturbed(&(l.column(k) * spread)));
    let minus: [G; D] = std::array::from_fn(|k| x.perturbed(&(l.column(k) * -spread)));
    let samples: Vec<G> = plus.into_iter().chain(minus).collect();
    same(&said("sigma points are samples"), &Gaussian::from_samples(&samples).unwrap().gaussian, &x);
}

/// Variance in two directions only, or in one.
fn degenerate<G: LieGroup<D, Scalar = f64>, E: Side, const D: usize>() {
    let l = SMatrix::<f64, D, D>::from_fn(|i, j| {
        if j < 2.min(D.div_ceil(2)) { 0.3 * ((3 * i + 5 * j + 1) as f64).sin() } else { 0.0 }
    });
    let x =
        Gaussian::<G, D, E>::new(G::exp(&SVector::repeat(0.3)), Covariance::new(l * l.transpose()).unwrap());
    for order in ORDERS {
        // Validity is checked anew: semi-definite to fourth order as well, however many steps.
        let chain = Gaussian::chain([&x; 5], order);
        assert!(Covariance::new(*chain.covariance().matrix()).is_ok(), "{order:?}");
        assert!(Covariance::new(*chain.between(&x, order).covariance().matrix()).is_ok());
    }
    assert_eq!(x.covariance().rank(), x.inverse().covariance().rank());
    assert_eq!(x.covariance().rank(), x.to_opposite().covariance().rank());
}

macro_rules! laws {
    ($($name:ident: $group:ty, $d:literal;)*) => { $(
        mod $name {
            use super::*;
            type Single = <$group as LieGroup<$d>>::Over<f32>;

            #[test]
            fn hold_in_f64() {
                laws::<$group, Local, $d>();
                laws::<$group, Global, $d>();
            }
            #[test]
            fn hold_in_f32() {
                laws::<Single, Local, $d>();
                laws::<Single, Global, $d>();
            }
            #[test]
            fn hold_where_directions_are_certain() {
                degenerate::<$group, Local, $d>();
                degenerate::<$group, Global, $d>();
            }
        }
    )* };
}

laws! {
    rn: Rn<3>, 3;
    so2: SO2, 1;
    se2: SE2, 3;
    so3: SO3, 3;
    se3: SE3, 6;
    se23: SE23, 9;
    sgal3: SGal3, 10;
    sim3: Sim3, 7;
    sim2: Sim2, 4;
}
