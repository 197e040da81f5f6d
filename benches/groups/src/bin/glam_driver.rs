//! glam: quaternions, and affine maps in the place of poses. It has no exp, log or Jacobian of poses.
use boxplus_group_peers::Driver;
use glam::{Affine3A, DAffine3, DQuat, DVec2, DVec3, Quat, Vec2, Vec3, Vec3A};

/// The same operations of its types for one scalar.
macro_rules! operations {
    ($driver:expr, $scalar:ident, $vec2:ty, $vec3:ty, $quat:ty, $affine:ty, $point:ty, $act:ident) => {{
        let scalar = stringify!($scalar);
        #[allow(clippy::cast_possible_truncation)]
        let lit = |x: f64| x as $scalar;
        let vec2 = |r: &[f64]| <$vec2>::new(lit(r[0]), lit(r[1]));
        let vec3 = |r: &[f64]| <$vec3>::new(lit(r[0]), lit(r[1]), lit(r[2]));
        let quat = |r: &[f64]| <$quat>::from_xyzw(lit(r[0]), lit(r[1]), lit(r[2]), lit(r[3]));
        let affine = |r: &[f64]| <$affine>::from_rotation_translation(quat(r), vec3(&r[4..]));
        let row2 = |v: $vec2| v.to_array().map(f64::from).to_vec();
        let row3 = |v: $vec3| v.to_array().map(f64::from).to_vec();
        let row4 = |q: $quat| q.to_array().map(f64::from).to_vec();
        if let Some(bench) = $driver.bench("SO2", scalar) {
            let (tau, points) = (read(&bench.tau, |r| lit(r[0])), read(&bench.point, vec2));
            let (a, b) = (read(&bench.a, vec2), read(&bench.b, vec2));
            let conjugate = |z: $vec2| <$vec2>::new(z.x, -z.y);
            bench.cell("exp", |i| <$vec2>::from_angle(tau[i]), row2);
            bench.cell("log", |i| a[i].to_angle(), |t| vec![f64::from(t)]);
            bench.cell("inverse", |i| conjugate(a[i]), row2);
            bench.cell("compose", |i| a[i].rotate(b[i]), row2);
            bench.cell("between", |i| conjugate(a[i]).rotate(b[i]), row2);
            bench.cell("act", |i| a[i].rotate(points[i]), row2);
            bench.cell("rplus", |i| a[i].rotate(<$vec2>::from_angle(tau[i])), row2);
            bench.cell("rminus", |i| conjugate(a[i]).rotate(b[i]).to_angle(), |t| vec![f64::from(t)]);
        }
        if let Some(bench) = $driver.bench("SO3", scalar) {
            let (tau, points) = (read(&bench.tau, vec3), read(&bench.point, vec3));
            let (a, b) = (read(&bench.a, quat), read(&bench.b, quat));
            bench.cell("exp", |i| <$quat>::from_scaled_axis(tau[i]), row4);
            bench.cell("log", |i| a[i].to_scaled_axis(), row3);
            bench.cell("inverse", |i| a[i].inverse(), row4);
            bench.cell("compose", |i| a[i] * b[i], row4);
            bench.cell("between", |i| a[i].inverse() * b[i], row4);
            bench.cell("act", |i| a[i] * points[i], row3);
            bench.cell("rplus", |i| a[i] * <$quat>::from_scaled_axis(tau[i]), row4);
            bench.cell("rminus", |i| (a[i].inverse() * b[i]).to_scaled_axis(), row3);
        }
        if let Some(bench) = $driver.bench("SE3", scalar) {
            let points = read(&bench.point, |r| <$point>::from(vec3(r)));
            let (a, b) = (read(&bench.a, affine), read(&bench.b, affine));
            let flat = |x: $affine| {
                let (_, q, t) = x.to_scale_rotation_translation();
                [row4(q), row3(t)].concat()
            };
            bench.cell("inverse", |i| a[i].inverse(), flat);
            bench.cell("compose", |i| a[i] * b[i], flat);
            bench.cell("between", |i| a[i].inverse() * b[i], flat);
            bench.cell("act", |i| a[i].$act(points[i]), |p| row3(p.into()));
        }
    }};
}

fn main() {
    let driver = Driver::from_args();
    operations!(driver, f64, DVec2, DVec3, DQuat, DAffine3, DVec3, transform_point3);
    operations!(driver, f32, Vec2, Vec3, Quat, Affine3A, Vec3A, transform_point3a);
}

fn read<T>(rows: &[Vec<f64>], one: impl Fn(&[f64]) -> T) -> Vec<T> {
    rows.iter().map(|r| one(r)).collect()
}
