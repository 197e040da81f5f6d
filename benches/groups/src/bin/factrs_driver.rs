//! factrs: tangents (φ, ρ), f64 (f32 is a feature of the whole crate). Its only Jacobians are Ad and J_r of SO(3).
use boxplus_group_peers::{Driver, Order};
use factrs::{
    linalg::VectorX,
    traits::Variable,
    variables::{MatrixLieGroup, SE2, SE3, SE23, SO2, SO3},
};
use nalgebra34::{SVector, Vector3};

/// What `MatrixLieGroup` adds; its bounds on sizes are better left to the compiler.
macro_rules! matrix_group {
    ($driver:expr, $name:literal, $d:literal, $order:expr, $read:expr) => {
        if let Some(bench) = $driver.bench($name, "f64") {
            let a: Vec<_> = bench.a.iter().map(|r| $read(r)).collect();
            let points: Vec<_> = bench.point.iter().map(|r| SVector::<f64, $d>::from_column_slice(r)).collect();
            bench.cell("act", |i| a[i].apply(points[i].as_view()), |y| y.iter().copied().collect());
            if $name != "SE2" {
                // There it indexes out of bounds.
                bench.cell("adjoint", |i| a[i].adjoint(), |m| Order($order).matrix(|i, j| m[(i, j)]));
            }
        }
    };
}

fn main() {
    let driver = Driver::from_args();
    let so2 = |r: &[f64]| SO2::from_theta(r[1].atan2(r[0]));
    let so3 = |r: &[f64]| SO3::from_xyzw(r[0], r[1], r[2], r[3]);
    let so3_row = |x: &SO3| vec![x.x(), x.y(), x.z(), x.w()];
    let vector = |r: &[f64]| Vector3::new(r[0], r[1], r[2]);
    operations(&driver, "SO2", &[0], so2, |x| angle_row(x.to_theta()));
    let se2 = |r: &[f64]| SE2::new(r[1].atan2(r[0]), r[2], r[3]);
    operations(&driver, "SE2", &[1, 2, 0], se2, |x| [angle_row(x.theta()), vec![x.x(), x.y()]].concat());
    operations(&driver, "SO3", &[0, 1, 2], so3, so3_row);
    let se3 = |r: &[f64]| SE3::from_rot_trans(so3(r), vector(&r[4..]));
    let se3_row = |x: &SE3| [so3_row(x.rot()), x.xyz().iter().copied().collect()].concat();
    operations(&driver, "SE3", &[3, 4, 5, 0, 1, 2], se3, se3_row);
    let se23 = |r: &[f64]| SE23::from_rot_vel_trans(so3(r), vector(&r[7..]), vector(&r[4..]));
    let se23_row = |x: &SE23| {
        [so3_row(x.rot()), x.xyz().iter().copied().collect(), x.uvw().iter().copied().collect::<Vec<_>>()].concat()
    };
    operations(&driver, "SE23", &[6, 7, 8, 0, 1, 2, 3, 4, 5], se23, se23_row);

    // What is of one type each, beside the operations of every variable.
    if let Some(bench) = driver.bench("SO3", "f64") {
        let tau: Vec<Vector3<f64>> = bench.tau.iter().map(|r| vector(r)).collect();
        let rows = |m: nalgebra34::Matrix3<f64>| m.transpose().iter().copied().collect::<Vec<_>>();
        bench.cell("jr", |i| SO3::dexp_right(tau[i].as_view()), rows);
    }
    matrix_group!(driver, "SO2", 2, &[0], so2);
    matrix_group!(driver, "SE2", 2, &[1, 2, 0], se2);
    matrix_group!(driver, "SO3", 3, &[0, 1, 2], so3);
    matrix_group!(driver, "SE3", 3, &[3, 4, 5, 0, 1, 2], se3);
    matrix_group!(driver, "SE23", 3, &[6, 7, 8, 0, 1, 2, 3, 4, 5], se23);
}

fn angle_row(theta: f64) -> Vec<f64> {
    vec![theta.cos(), theta.sin()]
}

fn operations<G: Variable<T = f64>>(
    driver: &Driver,
    name: &'static str,
    order: &'static [usize],
    read: impl Fn(&[f64]) -> G,
    write: impl Fn(&G) -> Vec<f64>,
) {
    let Some(bench) = driver.bench(name, "f64") else { return };
    let order = Order(order);
    let tau: Vec<VectorX<f64>> = bench.tau.iter().map(|r| VectorX::from_vec(order.theirs(r))).collect();
    let elements = |rows: &[Vec<f64>]| -> Vec<G> { rows.iter().map(|r| read(r)).collect() };
    let (a, b) = (elements(&bench.a), elements(&bench.b));
    let flat = |x: G| write(&x);
    let vector = |t: VectorX<f64>| order.vector(|k| t[k]);
    bench.cell("exp", |i| G::exp(tau[i].as_view()), flat);
    bench.cell("log", |i| a[i].log(), vector);
    bench.cell("inverse", |i| a[i].inverse(), flat);
    bench.cell("compose", |i| a[i].compose(&b[i]), flat);
    bench.cell("between", |i| b[i].minus(&a[i]), flat);
    bench.cell("rplus", |i| a[i].oplus_right(tau[i].as_view()), flat);
    bench.cell("rminus", |i| b[i].ominus_right(&a[i]), vector);
}
