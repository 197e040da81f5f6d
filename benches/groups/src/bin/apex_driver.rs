//! The groups of apex-solver: right Jacobians, f64 alone. Its SGal3 is left out: with p₁ + R₁(p₂ + t₁v₂) it composes otherwise
//! than the Galilean group.
use apex_manifolds::{LieGroup, Tangent, se2::SE2, se3::SE3, se23::SE23, sim3::Sim3, so2::SO2, so3::SO3};
use boxplus_group_peers::{Driver, Order};
use nalgebra33::Vector3;

fn main() {
    let driver = Driver::from_args();
    let plane = |x: &[f64]| vec![x[2], x[3], x[1].atan2(x[0])];
    operations::<SO2>(&driver, "SO2", &[0], |x| vec![x[1].atan2(x[0])], |x| vec![x[0].cos(), x[0].sin()]);
    operations::<SE2>(&driver, "SE2", &[0, 1, 2], plane, |x| vec![x[2].cos(), x[2].sin(), x[0], x[1]]);
    let last = |x: &[f64]| vec![x[1], x[2], x[3], x[0]];
    operations::<SO3>(&driver, "SO3", &[0, 1, 2], |x| vec![x[3], x[0], x[1], x[2]], last);
    operations::<SE3>(&driver, "SE3", &[0, 1, 2, 3, 4, 5], swap, swap);
    operations::<SE23>(&driver, "SE23", &[0, 1, 2, 3, 4, 5, 6, 7, 8], swap, swap);
    let scale = |x: &[f64]| [&swap(x)[..7], &[x[7].exp()]].concat();
    operations::<Sim3>(&driver, "Sim3", &[0, 1, 2, 3, 4, 5, 6], scale, |x| [&swap(x)[..7], &[x[7].ln()]].concat());
}

/// (q xyzw, t, …) from (t, q wxyz, …), and back.
fn swap(x: &[f64]) -> Vec<f64> {
    [&x[4..7], &x[3..4], &x[..3], &x[7..]].concat()
}

fn operations<G: LieGroup>(
    driver: &Driver,
    name: &'static str,
    order: &'static [usize],
    read: impl Fn(&[f64]) -> Vec<f64>,
    write: impl Fn(&[f64]) -> Vec<f64>,
) {
    let Some(bench) = driver.bench(name, "f64") else { return };
    let order = Order(order);
    let tau: Vec<G::TangentVector> = bench.tau.iter().map(|r| Tangent::from_slice(&order.theirs(r))).collect();
    let elements = |rows: &[Vec<f64>]| -> Vec<G> { rows.iter().map(|r| G::from_param_slice(&read(r))).collect() };
    let (a, b) = (elements(&bench.a), elements(&bench.b));
    let element = |x: &G| write(x.as_param_slice());
    let vector = |t: &G::TangentVector| order.vector(|k| t.as_slice()[k]);
    let matrix = |m: &G::JacobianMatrix| order.matrix(|i, j| m[(i, j)]);
    let two = |(x, j, k): (G, G::JacobianMatrix, G::JacobianMatrix)| [element(&x), matrix(&j), matrix(&k)].concat();

    bench.cell("exp", |i| tau[i].exp(None), |x| element(&x));
    bench.cell("log", |i| a[i].log(None), |t| vector(&t));
    bench.cell("inverse", |i| a[i].inverse(None), |x| element(&x));
    bench.cell("compose", |i| a[i].compose(&b[i], None, None), |x| element(&x));
    bench.cell("between", |i| a[i].between(&b[i], None, None), |x| element(&x));
    bench.cell("rplus", |i| a[i].right_plus(&tau[i], None, None), |x| element(&x));
    bench.cell("rminus", |i| b[i].right_minus(&a[i], None, None), |t| vector(&t));
    bench.cell("adjoint", |i| a[i].adjoint(), |m| matrix(&m));
    bench.cell("jr", |i| tau[i].right_jacobian(), |m| matrix(&m));
    bench.cell("jr_inv", |i| tau[i].right_jacobian_inv(), |m| matrix(&m));
    let zero = G::zero_jacobian;
    let exp = |i: usize, mut j| (tau[i].exp(Some(&mut j)), j);
    bench.cell("exp_jac", |i| exp(i, zero()), |(x, j)| [element(&x), matrix(&j)].concat());
    let log = |i: usize, mut j| (a[i].log(Some(&mut j)), j);
    bench.cell("log_jac", |i| log(i, zero()), |(t, j)| [vector(&t), matrix(&j)].concat());
    let inverse = |i: usize, mut j| (a[i].inverse(Some(&mut j)), j);
    bench.cell("inverse_jac", |i| inverse(i, zero()), |(x, j)| [element(&x), matrix(&j)].concat());
    let compose = |i: usize, mut j, mut k| (a[i].compose(&b[i], Some(&mut j), Some(&mut k)), j, k);
    bench.cell("compose_jac", |i| compose(i, zero(), zero()), two);
    let between = |i: usize, mut j, mut k| (a[i].between(&b[i], Some(&mut j), Some(&mut k)), j, k);
    bench.cell("between_jac", |i| between(i, zero(), zero()), two);
    let rplus = |i: usize, mut j, mut k| (a[i].right_plus(&tau[i], Some(&mut j), Some(&mut k)), j, k);
    bench.cell("rplus_jac", |i| rplus(i, zero(), zero()), two);
    let rminus = |i: usize, mut j, mut k| (b[i].right_minus(&a[i], Some(&mut j), Some(&mut k)), j, k);
    bench.cell("rminus_jac", |i| rminus(i, zero(), zero()), |(t, j, k)| [vector(&t), matrix(&j), matrix(&k)].concat());
    let place = |r: &Vec<f64>| Vector3::new(r[0], r[1], r.get(2).copied().unwrap_or(0.0));
    let points: Vec<Vector3<f64>> = bench.point.iter().map(place).collect();
    let n = bench.point[0].len();
    bench.cell("act", |i| a[i].act(&points[i], None, None), |p| p.as_slice()[..n].to_vec());
}
