//! sophus_lie: left Jacobians, tangents (ω, υ), f64. J_r(τ) = J_l(−τ); its Jacobians of compositions are of parameters.
use boxplus_group_peers::{Bench, Driver, Order};
use sophus_lie::prelude::*;
use sophus_lie::{Isometry2F64, Isometry3F64, Rotation2F64, Rotation3F64};

type Vector<const N: usize> = nalgebra33::SVector<f64, N>;

/// The same operations of every group; `$n` numbers of a tangent, `$p` of an element, `$d` of a point.
macro_rules! operations {
    ($bench:expr, $group:ty, $n:literal, $p:literal, $d:literal, $tangent:expr, $element:expr) => {{
        let (bench, tangent, element): (Bench<'_>, Order, Order) = ($bench, Order($tangent), Order($element));
        let tau: Vec<Vector<$n>> = bench.tau.iter().map(|r| Vector::from_vec(tangent.theirs(r))).collect();
        let points: Vec<Vector<$d>> = bench.point.iter().map(|r| Vector::from_vec(r.clone())).collect();
        let read = |r: &Vec<f64>| <$group>::from_params(Vector::<$p>::from_vec(element.theirs(r)));
        let (a, b): (Vec<$group>, Vec<$group>) =
            (bench.a.iter().map(read).collect(), bench.b.iter().map(read).collect());
        let x_row = |x: $group| element.vector(|k| x.params()[k]);
        let t_row = |t: Vector<$n>| tangent.vector(|k| t[k]);
        let j_row = |j: nalgebra33::SMatrix<f64, $n, $n>| tangent.matrix(|i, k| j[(i, k)]);
        bench.cell("exp", |i| <$group>::exp(tau[i]), x_row);
        bench.cell("log", |i| a[i].log(), t_row);
        bench.cell("inverse", |i| a[i].inverse(), x_row);
        bench.cell("compose", |i| a[i].group_mul(b[i]), x_row);
        bench.cell("between", |i| a[i].inverse().group_mul(b[i]), x_row);
        bench.cell("act", |i| a[i].transform(points[i]), |y| y.iter().copied().collect());
        bench.cell("rplus", |i| a[i].group_mul(<$group>::exp(tau[i])), x_row);
        bench.cell("rminus", |i| a[i].inverse().group_mul(b[i]).log(), t_row);
        bench.cell("adjoint", |i| a[i].adj(), j_row);
        bench.cell("jr", |i| <$group>::left_jacobian(-tau[i]), j_row);
        bench.cell("jr_inv", |i| <$group>::inv_left_jacobian(-tau[i]), j_row);
    }};
}

fn main() {
    let driver = Driver::from_args();
    driver.bench("SO2", "f64").into_iter().for_each(|b| operations!(b, Rotation2F64, 1, 2, 2, &[0], &[0, 1]));
    let plane = |b| operations!(b, Isometry2F64, 3, 4, 2, &[1, 2, 0], &[0, 1, 2, 3]);
    driver.bench("SE2", "f64").into_iter().for_each(plane);
    driver
        .bench("SO3", "f64")
        .into_iter()
        .for_each(|b| operations!(b, Rotation3F64, 3, 4, 3, &[0, 1, 2], &[1, 2, 3, 0]));
    let space = |b| operations!(b, Isometry3F64, 6, 7, 3, &[3, 4, 5, 0, 1, 2], &[1, 2, 3, 0, 4, 5, 6]);
    driver.bench("SE3", "f64").into_iter().for_each(space);
}
