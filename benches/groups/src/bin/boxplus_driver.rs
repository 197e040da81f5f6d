//! boxplus itself, by the same protocol as its peers.
use boxplus::lie::{
    Action, Batch, BatchGroup, LengthMismatch, LieGroup, Number, Real, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3,
};
use boxplus_group_peers::{Bench, Driver};
use nalgebra::{SMatrix, SVector, Vector2, Vector3};

fn main() {
    let driver = Driver::from_args();
    both::<1, 2, SO2<f64>, SO2<f32>>(&driver, "SO2");
    both::<3, 2, SE2<f64>, SE2<f32>>(&driver, "SE2");
    both::<3, 3, SO3<f64>, SO3<f32>>(&driver, "SO3");
    both::<6, 3, SE3<f64>, SE3<f32>>(&driver, "SE3");
    both::<9, 3, SE23<f64>, SE23<f32>>(&driver, "SE23");
    both::<10, 4, SGal3<f64>, SGal3<f32>>(&driver, "SGal3");
    both::<4, 2, Sim2<f64>, Sim2<f32>>(&driver, "Sim2");
    both::<7, 3, Sim3<f64>, Sim3<f32>>(&driver, "Sim3");
}

fn both<const D: usize, const N: usize, F64, F32>(driver: &Driver, name: &'static str)
where
    F64: Stored<D, N> + BatchGroup<D>,
    F32: Stored<D, N> + BatchGroup<D>,
    Wide<F64, D>: Action<D, N>,
    Wide<F32, D>: Action<D, N>,
{
    if let Some(bench) = driver.bench(name, "f64") {
        operations::<D, N, F64>(&bench);
        batches::<D, N, F64>(&bench);
    }
    if let Some(bench) = driver.bench(name, "f32") {
        operations::<D, N, F32>(&bench);
        batches::<D, N, F32>(&bench);
    }
}

/// What a batch of `G` computes with.
type Wide<G, const D: usize> = <G as LieGroup<D>>::Over<<<G as LieGroup<D>>::Scalar as Number>::Lanes>;

/// An element as a row of numbers.
trait Stored<const D: usize, const N: usize>: Action<D, N> {
    fn read(row: &[f64]) -> Self;
    fn write(&self) -> Vec<f64>;
}

fn operations<const D: usize, const N: usize, G: Stored<D, N>>(bench: &Bench<'_>) {
    let vectors = |rows: &[Vec<f64>]| -> Vec<SVector<G::Scalar, D>> { rows.iter().map(|r| vector(r)).collect() };
    let (tau, points): (_, Vec<SVector<G::Scalar, N>>) =
        (vectors(&bench.tau), bench.point.iter().map(|r| vector(r)).collect());
    let elements = |rows: &[Vec<f64>]| -> Vec<G> { rows.iter().map(|r| G::read(r)).collect() };
    let (a, b) = (elements(&bench.a), elements(&bench.b));

    bench.cell("exp", |i| G::exp(&tau[i]), |x| x.write());
    bench.cell("log", |i| a[i].log(), |t| flat(&t));
    bench.cell("inverse", |i| a[i].inverse(), |x| x.write());
    bench.cell("compose", |i| a[i].compose(&b[i]), |x| x.write());
    bench.cell("between", |i| a[i].between(&b[i]), |x| x.write());
    bench.cell("act", |i| a[i].act(&points[i]), |y| flat(&y));
    bench.cell("rplus", |i| a[i].rplus(&tau[i]), |x| x.write());
    bench.cell("rminus", |i| b[i].rminus(&a[i]), |t| flat(&t));
    bench.cell("adjoint", |i| a[i].adjoint(), |m| flat(&m));
    bench.cell("jr", |i| G::right_jacobian(&tau[i]), |m| flat(&m));
    bench.cell("jr_inv", |i| G::right_jacobian_inverse(&tau[i]), |m| flat(&m));
    bench.cell("exp_jac", |i| G::exp_jac(&tau[i]), |(x, j)| [x.write(), flat(&j)].concat());
    bench.cell("log_jac", |i| a[i].log_jac(), |(t, j)| [flat(&t), flat(&j)].concat());
    bench.cell("inverse_jac", |i| a[i].inverse_jac(), |(x, j)| [x.write(), flat(&j)].concat());
    let two =
        |(x, j, k): (G, SMatrix<G::Scalar, D, D>, SMatrix<G::Scalar, D, D>)| [x.write(), flat(&j), flat(&k)].concat();
    bench.cell("compose_jac", |i| a[i].compose_jac(&b[i]), two);
    bench.cell("between_jac", |i| a[i].between_jac(&b[i]), two);
    bench.cell("act_jac", |i| a[i].act_jac(&points[i]), |(y, j, k)| [flat(&y), flat(&j), flat(&k)].concat());
    bench.cell("rplus_jac", |i| a[i].rplus_jac(&tau[i]), two);
    bench.cell("rminus_jac", |i| b[i].rminus_jac(&a[i]), |(t, j, k)| [flat(&t), flat(&j), flat(&k)].concat());
}

/// The same on whole slices.
fn batches<const D: usize, const N: usize, G: Stored<D, N> + BatchGroup<D>>(bench: &Bench<'_>)
where
    Wide<G, D>: Action<D, N>,
{
    let tau: Vec<SVector<G::Scalar, D>> = bench.tau.iter().map(|r| vector(r)).collect();
    let points: Vec<SVector<G::Scalar, N>> = bench.point.iter().map(|r| vector(r)).collect();
    let elements = |rows: &[Vec<f64>]| -> Vec<G> { rows.iter().map(|r| G::read(r)).collect() };
    let (a, b, on) = (elements(&bench.a), elements(&bench.b), Batch::OneCore);
    let filled = |result: Result<(), LengthMismatch>| result.expect("slices of one length");

    let (x, t, j) = (G::identity(), SVector::<G::Scalar, D>::zeros(), SMatrix::<G::Scalar, D, D>::zeros());
    bench.batch("exp", &x, |out| filled(on.exp(&tau, out)), |x| x.write());
    bench.batch("log", &t, |out| filled(on.log(&a, out)), |t| flat(&t));
    bench.batch("inverse", &x, |out| filled(on.inverse(&a, out)), |x| x.write());
    bench.batch("compose", &x, |out| filled(on.compose(&a, &b, out)), |x| x.write());
    bench.batch("between", &x, |out| filled(on.between(&a, &b, out)), |x| x.write());
    bench.batch("act", &points[0], |out| filled(on.act(&a, &points, out)), |y| flat(&y));
    bench.batch("rplus", &x, |out| filled(on.rplus(&a, &tau, out)), |x| x.write());
    bench.batch("rminus", &t, |out| filled(on.rminus(&b, &a, out)), |t| flat(&t));
    bench.batch("exp_jac", &(x, j), |out| filled(on.exp_jac(&tau, out)), |(x, j)| [x.write(), flat(&j)].concat());
    bench.batch("log_jac", &(t, j), |out| filled(on.log_jac(&a, out)), |(t, j)| [flat(&t), flat(&j)].concat());
    let rplus_row = |(x, j, k): (G, _, _)| [x.write(), flat(&j), flat(&k)].concat();
    bench.batch("rplus_jac", &(x, j, j), |out| filled(on.rplus_jac(&a, &tau, out)), rplus_row);
    let rminus_row = |(t, j, k)| [flat(&t), flat(&j), flat(&k)].concat();
    bench.batch("rminus_jac", &(t, j, j), |out| filled(on.rminus_jac(&b, &a, out)), rminus_row);
}

fn vector<S: Real, const D: usize>(row: &[f64]) -> SVector<S, D> {
    SVector::from_fn(|i, _| S::lit(row[i]))
}

/// By rows.
fn flat<S: Real, const R: usize, const C: usize>(m: &SMatrix<S, R, C>) -> Vec<f64> {
    m.transpose().iter().map(|x| x.value()).collect()
}

fn xyz<S: Real>(row: &[f64]) -> Vector3<S> {
    vector(row)
}

impl<S: Real> Stored<1, 2> for SO2<S> {
    fn read(r: &[f64]) -> Self {
        Self::from_cos_sin(S::lit(r[0]), S::lit(r[1])).expect("not zero")
    }
    fn write(&self) -> Vec<f64> {
        vec![self.cos().value(), self.sin().value()]
    }
}
impl<S: Real> Stored<3, 2> for SE2<S> {
    fn read(r: &[f64]) -> Self {
        Self::from_parts(vector(&r[2..]), SO2::read(r))
    }
    fn write(&self) -> Vec<f64> {
        [self.rotation().write(), flat(&self.translation())].concat()
    }
}
impl<S: Real> Stored<3, 3> for SO3<S> {
    fn read(r: &[f64]) -> Self {
        Self::from_xyzw([r[0], r[1], r[2], r[3]].map(S::lit)).expect("not zero")
    }
    fn write(&self) -> Vec<f64> {
        self.quaternion_xyzw().map(Real::value).to_vec()
    }
}
impl<S: Real> Stored<6, 3> for SE3<S> {
    fn read(r: &[f64]) -> Self {
        Self::new(SO3::read(r), xyz(&r[4..]))
    }
    fn write(&self) -> Vec<f64> {
        [self.rotation().write(), flat(&self.translation())].concat()
    }
}
impl<S: Real> Stored<9, 3> for SE23<S> {
    fn read(r: &[f64]) -> Self {
        Self::new(SO3::read(r), xyz(&r[4..]), xyz(&r[7..]))
    }
    fn write(&self) -> Vec<f64> {
        [self.pose().write(), flat(&self.velocity())].concat()
    }
}
impl<S: Real> Stored<10, 4> for SGal3<S> {
    fn read(r: &[f64]) -> Self {
        Self::from_extended(SE23::read(r), S::lit(r[10]))
    }
    fn write(&self) -> Vec<f64> {
        [self.extended_pose().write(), vec![self.time().value()]].concat()
    }
}
impl<S: Real> Stored<4, 2> for Sim2<S> {
    fn read(r: &[f64]) -> Self {
        Self::new(SO2::read(r), Vector2::new(S::lit(r[2]), S::lit(r[3])), S::lit(r[4]))
    }
    fn write(&self) -> Vec<f64> {
        [self.rotation().write(), flat(&self.translation()), vec![self.log_scale().value()]].concat()
    }
}
impl<S: Real> Stored<7, 3> for Sim3<S> {
    fn read(r: &[f64]) -> Self {
        Self::new(SO3::read(r), xyz(&r[4..]), S::lit(r[7]))
    }
    fn write(&self) -> Vec<f64> {
        [self.rotation().write(), flat(&self.translation()), vec![self.log_scale().value()]].concat()
    }
}
