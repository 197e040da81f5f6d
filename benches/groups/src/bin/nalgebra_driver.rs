//! nalgebra: unit complex numbers and quaternions, isometries and similarities. It has no exp, log or Jacobian of poses.
use boxplus_group_peers::{Bench, Driver};
use nalgebra::{
    Complex, Isometry2, Isometry3, Point2, Point3, Quaternion, RealField, SVector, Similarity2, Similarity3,
    UnitComplex, UnitQuaternion, convert, try_convert,
};

fn main() {
    let driver = Driver::from_args();
    all::<f64>(&driver, "f64");
    all::<f32>(&driver, "f32");
}

fn all<S: RealField + Copy>(driver: &Driver, scalar: &'static str) {
    driver.bench("SO2", scalar).iter().for_each(so2::<S>);
    driver.bench("SE2", scalar).iter().for_each(|bench| {
        let points = points(bench).map(|p: SVector<S, 2>| Point2::from(p)).collect::<Vec<_>>();
        let (a, b): (Vec<Isometry2<S>>, _) = (elements(&bench.a, isometry2), elements(&bench.b, isometry2));
        let flat = |x: Isometry2<S>| [complex_row(&x.rotation), row(x.translation.vector.as_slice())].concat();
        bench.cell("inverse", |i| a[i].inverse(), flat);
        bench.cell("compose", |i| a[i] * b[i], flat);
        bench.cell("between", |i| a[i].inv_mul(&b[i]), flat);
        bench.cell("act", |i| a[i] * points[i], |p| row(p.coords.as_slice()));
    });
    driver.bench("SO3", scalar).iter().for_each(so3::<S>);
    driver.bench("SE3", scalar).iter().for_each(|bench| {
        let points = points(bench).map(|p: SVector<S, 3>| Point3::from(p)).collect::<Vec<_>>();
        let (a, b): (Vec<Isometry3<S>>, _) = (elements(&bench.a, isometry3), elements(&bench.b, isometry3));
        let flat = |x: Isometry3<S>| [row(x.rotation.coords.as_slice()), row(x.translation.vector.as_slice())].concat();
        bench.cell("inverse", |i| a[i].inverse(), flat);
        bench.cell("compose", |i| a[i] * b[i], flat);
        bench.cell("between", |i| a[i].inv_mul(&b[i]), flat);
        bench.cell("act", |i| a[i] * points[i], |p| row(p.coords.as_slice()));
    });
    driver.bench("Sim2", scalar).iter().for_each(|bench| {
        let points = points(bench).map(|p: SVector<S, 2>| Point2::from(p)).collect::<Vec<_>>();
        let read = |r: &[f64]| Similarity2::from_isometry(isometry2(r), exp(r[4]));
        let (a, b): (Vec<Similarity2<S>>, _) = (elements(&bench.a, read), elements(&bench.b, read));
        let flat = |x: Similarity2<S>| {
            let pose = [complex_row(&x.isometry.rotation), row(x.isometry.translation.vector.as_slice())].concat();
            [pose, vec![number(x.scaling()).ln()]].concat()
        };
        bench.cell("inverse", |i| a[i].inverse(), flat);
        bench.cell("compose", |i| a[i] * b[i], flat);
        bench.cell("between", |i| a[i].inverse() * b[i], flat);
        bench.cell("act", |i| a[i] * points[i], |p| row(p.coords.as_slice()));
    });
    driver.bench("Sim3", scalar).iter().for_each(|bench| {
        let points = points(bench).map(|p: SVector<S, 3>| Point3::from(p)).collect::<Vec<_>>();
        let read = |r: &[f64]| Similarity3::from_isometry(isometry3(r), exp(r[7]));
        let (a, b): (Vec<Similarity3<S>>, _) = (elements(&bench.a, read), elements(&bench.b, read));
        let flat = |x: Similarity3<S>| {
            let pose = [row(x.isometry.rotation.coords.as_slice()), row(x.isometry.translation.vector.as_slice())];
            [pose.concat(), vec![number(x.scaling()).ln()]].concat()
        };
        bench.cell("inverse", |i| a[i].inverse(), flat);
        bench.cell("compose", |i| a[i] * b[i], flat);
        bench.cell("between", |i| a[i].inverse() * b[i], flat);
        bench.cell("act", |i| a[i] * points[i], |p| row(p.coords.as_slice()));
    });
}

fn so2<S: RealField + Copy>(bench: &Bench<'_>) {
    let (tau, points) = (elements(&bench.tau, |r| lit::<S>(r[0])), points(bench).collect::<Vec<SVector<S, 2>>>());
    let (a, b): (Vec<UnitComplex<S>>, _) = (elements(&bench.a, complex), elements(&bench.b, complex));
    let flat = |x: UnitComplex<S>| complex_row(&x);
    bench.cell("exp", |i| UnitComplex::new(tau[i]), flat);
    bench.cell("log", |i| a[i].angle(), |t| vec![number(t)]);
    bench.cell("inverse", |i| a[i].inverse(), flat);
    bench.cell("compose", |i| a[i] * b[i], flat);
    bench.cell("between", |i| a[i].rotation_to(&b[i]), flat);
    bench.cell("act", |i| a[i] * points[i], |p| row(p.as_slice()));
    bench.cell("rplus", |i| a[i] * UnitComplex::new(tau[i]), flat);
    bench.cell("rminus", |i| a[i].rotation_to(&b[i]).angle(), |t| vec![number(t)]);
}

fn so3<S: RealField + Copy>(bench: &Bench<'_>) {
    let (tau, points) = (elements(&bench.tau, vector::<S, 3>), points(bench).collect::<Vec<SVector<S, 3>>>());
    let (a, b): (Vec<UnitQuaternion<S>>, _) = (elements(&bench.a, quaternion), elements(&bench.b, quaternion));
    let flat = |x: UnitQuaternion<S>| row(x.coords.as_slice());
    bench.cell("exp", |i| UnitQuaternion::from_scaled_axis(tau[i]), flat);
    bench.cell("log", |i| a[i].scaled_axis(), |t| row(t.as_slice()));
    bench.cell("inverse", |i| a[i].inverse(), flat);
    bench.cell("compose", |i| a[i] * b[i], flat);
    bench.cell("between", |i| a[i].inverse() * b[i], flat);
    bench.cell("act", |i| a[i] * points[i], |p| row(p.as_slice()));
    bench.cell("rplus", |i| a[i] * UnitQuaternion::from_scaled_axis(tau[i]), flat);
    bench.cell("rminus", |i| (a[i].inverse() * b[i]).scaled_axis(), |t| row(t.as_slice()));
    let matrix = |m: nalgebra::Rotation3<S>| row(m.into_inner().transpose().as_slice());
    bench.cell("adjoint", |i| a[i].to_rotation_matrix(), matrix);
}

fn elements<T>(rows: &[Vec<f64>], read: impl Fn(&[f64]) -> T) -> Vec<T> {
    rows.iter().map(|r| read(r)).collect()
}
fn points<S: RealField + Copy, const N: usize>(bench: &Bench<'_>) -> impl Iterator<Item = SVector<S, N>> {
    bench.point.iter().map(|r| vector(r))
}
fn vector<S: RealField + Copy, const N: usize>(row: &[f64]) -> SVector<S, N> {
    SVector::from_fn(|i, _| lit(row[i]))
}
fn complex<S: RealField + Copy>(row: &[f64]) -> UnitComplex<S> {
    UnitComplex::from_complex(Complex::new(lit(row[0]), lit(row[1])))
}
fn quaternion<S: RealField + Copy>(row: &[f64]) -> UnitQuaternion<S> {
    UnitQuaternion::from_quaternion(Quaternion::from_vector(vector::<S, 4>(row)))
}
fn isometry2<S: RealField + Copy>(row: &[f64]) -> Isometry2<S> {
    Isometry2::from_parts(vector::<S, 2>(&row[2..]).into(), complex(row))
}
fn isometry3<S: RealField + Copy>(row: &[f64]) -> Isometry3<S> {
    Isometry3::from_parts(vector::<S, 3>(&row[4..]).into(), quaternion(row))
}
fn exp<S: RealField + Copy>(x: f64) -> S {
    lit::<S>(x).exp()
}

fn lit<S: RealField + Copy>(x: f64) -> S {
    convert(x)
}
fn number<S: RealField + Copy>(x: S) -> f64 {
    try_convert(x).expect("a float")
}
fn row<S: RealField + Copy>(x: &[S]) -> Vec<f64> {
    x.iter().map(|x| number(*x)).collect()
}
fn complex_row<S: RealField + Copy>(x: &UnitComplex<S>) -> Vec<f64> {
    vec![number(x.re), number(x.im)]
}
