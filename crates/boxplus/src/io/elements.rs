//! What the formats share: poses, points, information matrices, and the vertices and edges made of them.

use super::error::{IoErrorKind, WriteError};
use super::scan::{Fields, Scan};
use crate::lie::{LieError, LieGroup, SE2, SE3, SO2, SO3};
use crate::pose_graph::{Edge, Label, OtherLine, Prior, Vertex};
use core::cell::Cell;
use core::f64::consts::PI;
use core::fmt::{Display, Write};
use nalgebra::{SMatrix, Vector2, Vector3};

/// Reads a value at the cursor.
pub(super) type Read<T> = fn(&mut Fields<'_>) -> Scan<T>;
/// Prints a value as fields.
pub(super) type Print<T> = fn(&mut Printer, &T);

/// Below, the norm of a quaternion is not worth a word: six printed decimals change it by less than 1e-6.
const ROUGH_NORM: f64 = 1e-3;

/// Above, a quaternion is normalised. Products, exponentials and normalised quaternions stay below (|q|² within 8ε of 1);
/// they must come back as they were written.
const UNIT: f64 = 16.0 * f64::EPSILON;

// ——— reading ———

/// `x`.
pub(super) fn scalar(f: &mut Fields<'_>) -> Scan<f64> {
    f.number()
}

/// `x y`.
pub(super) fn point2(f: &mut Fields<'_>) -> Scan<Vector2<f64>> {
    f.numbers::<2>().map(Vector2::from)
}

/// `x y z`.
pub(super) fn point3(f: &mut Fields<'_>) -> Scan<Vector3<f64>> {
    f.numbers::<3>().map(Vector3::from)
}

/// `x y θ`.
pub(super) fn pose2(f: &mut Fields<'_>) -> Scan<SE2> {
    let [x, y, theta] = f.numbers()?;
    Ok(SE2::from_parts(Vector2::new(x, y), rotation_of(theta)))
}

/// `x y z qx qy qz qw`.
pub(super) fn pose3(f: &mut Fields<'_>) -> Scan<SE3> {
    let t = point3(f)?;
    let x = f.number()?;
    let start = f.token_start();
    let [y, z, w] = f.numbers()?;
    match rotation3([x, y, z, w]) {
        Ok((rotation, norm)) => {
            if (norm - 1.0).abs() > ROUGH_NORM {
                f.rough_norm = Some(norm);
            }
            Ok(SE3::new(rotation, t))
        }
        Err(_) => Err(f.fail_from(start, IoErrorKind::ZeroQuaternion).into()), // All numbers are finite.
    }
}

/// `x y z roll pitch yaw`, R = Rz(yaw)·Ry(pitch)·Rx(roll).
pub(super) fn pose3_euler(f: &mut Fields<'_>) -> Scan<SE3> {
    let t = point3(f)?;
    let [roll, pitch, yaw] = f.numbers()?;
    let about = |axis: Vector3<f64>, angle: f64| SO3::exp(&(axis * angle));
    let rotation = about(Vector3::z(), yaw) * about(Vector3::y(), pitch) * about(Vector3::x(), roll);
    Ok(SE3::new(rotation, t))
}

/// The upper triangle by rows of a symmetric matrix.
pub(super) fn information<const D: usize>(f: &mut Fields<'_>) -> Scan<SMatrix<f64, D, D>> {
    let mut m: SMatrix<f64, D, D> = upper_triangle(f)?;
    m.fill_lower_triangle_with_upper_triangle();
    Ok(m)
}

/// The upper triangle by rows.
pub(super) fn upper_triangle<const D: usize>(f: &mut Fields<'_>) -> Scan<SMatrix<f64, D, D>> {
    let mut m = SMatrix::zeros();
    for row in 0..D {
        for column in row..D {
            m[(row, column)] = f.number()?;
        }
    }
    Ok(m)
}

/// `id value`.
pub(super) fn vertex<T>(f: &mut Fields<'_>, value: Read<T>) -> Scan<Vertex<T>> {
    Ok(Vertex { id: f.id()?, value: value(f)?, line: f.line() })
}

/// `from to value information`.
pub(super) fn edge<Z, const D: usize>(
    f: &mut Fields<'_>,
    value: Read<Z>,
    information: Read<SMatrix<f64, D, D>>,
) -> Scan<Edge<Z, D>> {
    let (from, to) = (f.id()?, f.id()?);
    Ok(Edge { from, to, measured: value(f)?, information: information(f)?, line: f.line() })
}

/// `id value information`.
pub(super) fn prior<Z, const D: usize>(f: &mut Fields<'_>, value: Read<Z>) -> Scan<Prior<Z, D>> {
    Ok(Prior { id: f.id()?, measured: value(f)?, information: information(f)?, line: f.line() })
}

/// Any line.
pub(super) fn other(f: &mut Fields<'_>) -> Scan<OtherLine> {
    let other = OtherLine { text: f.text()?.to_owned(), line: f.line() };
    f.skip_rest();
    Ok(other)
}

/// The rotation by θ, for |θ| > π by the equal angle within a turn, so that printing the angle gives it back.
fn rotation_of(theta: f64) -> SO2 {
    let rotation = SO2::from_angle(theta);
    if theta.abs() > PI { SO2::from_angle(rotation.angle()) } else { rotation }
}

/// The rotation of a quaternion, and the norm it had. A unit quaternion keeps every bit.
pub(super) fn rotation3(xyzw: [f64; 4]) -> Result<(SO3, f64), LieError> {
    let norm2: f64 = xyzw.iter().map(|q| q * q).sum();
    if (norm2 - 1.0).abs() > UNIT {
        return Ok((SO3::from_xyzw(xyzw)?, norm2.sqrt()));
    }
    // `from_xyzw` divides by the norm, which would move last digits at every reading; `map` visits x, y, z, w.
    let next = Cell::new(0);
    Ok((SO3::<f64>::identity().map(|_| xyzw[next.replace(next.get() + 1)]), 1.0))
}

// ——— printing ———

/// Lines being written, and whether every number so far was finite.
#[derive(Default)]
pub(super) struct Printer {
    text: String,
    not_finite: bool,
}

impl Printer {
    /// The text.
    pub(super) fn into_text(self) -> String {
        self.text
    }

    /// Writes one line: the tag, then what `fields` writes. `id` names the line in an error.
    pub(super) fn line(
        &mut self,
        tag: &'static str,
        id: u64,
        fields: impl FnOnce(&mut Self),
    ) -> Result<(), WriteError> {
        self.text.push_str(tag);
        fields(self);
        self.text.push('\n');
        if self.not_finite { Err(WriteError::NotFinite { tag, id }) } else { Ok(()) }
    }

    /// Writes a line as it is.
    pub(super) fn verbatim(&mut self, other: &OtherLine) {
        self.text.push_str(&other.text);
        self.text.push('\n');
    }

    fn push(&mut self, field: impl Display) {
        // Writing to a `String` does not fail.
        let _ = write!(self.text, " {field}");
    }

    /// Writes an id.
    pub(super) fn id(&mut self, id: u64) {
        self.push(id);
    }

    /// Writes an id of a letter and a number.
    pub(super) fn name(&mut self, name: Label) {
        self.push(name);
    }

    /// Writes the shortest decimal that reads back as the same float.
    pub(super) fn number(&mut self, x: f64) {
        self.not_finite |= !x.is_finite();
        if x == 0.0 || (1e-5..1e16).contains(&x.abs()) {
            self.push(x);
        } else {
            self.push(format_args!("{x:e}"));
        }
    }

    /// Writes numbers.
    pub(super) fn numbers(&mut self, numbers: &[f64]) {
        for &x in numbers {
            self.number(x);
        }
    }
}

/// `x`.
#[allow(clippy::trivially_copy_pass_by_ref)] // as `Print` has it
pub(super) fn print_scalar(p: &mut Printer, x: &f64) {
    p.number(*x);
}

/// `x y` or `x y z`.
pub(super) fn print_point<const N: usize>(p: &mut Printer, x: &SMatrix<f64, N, 1>) {
    p.numbers(x.as_slice());
}

/// `x y θ`.
pub(super) fn print_pose2(p: &mut Printer, x: &SE2) {
    p.numbers(x.translation().as_slice());
    p.number(angle_of(x.rotation()));
}

/// `x y z qx qy qz qw`.
pub(super) fn print_pose3(p: &mut Printer, x: &SE3) {
    p.numbers(x.translation().as_slice());
    p.numbers(&x.rotation().quaternion_xyzw());
}

/// `x y z roll pitch yaw`, R = Rz(yaw)·Ry(pitch)·Rx(roll).
pub(super) fn print_pose3_euler(p: &mut Printer, x: &SE3) {
    let r = x.rotation().to_matrix();
    let pitch = (-r.m31).atan2(r.m32.hypot(r.m33));
    // At pitch = ±π/2 only yaw ∓ roll is determined, and near it roll is mostly rounding: yaw is taken from what is left
    // after roll, R·Rx(−roll) = Rz·Ry with second column (−sin yaw, cos yaw, 0).
    let roll = r.m32.atan2(r.m33);
    let (s, c) = roll.sin_cos();
    let yaw = (s * r.m13 - c * r.m12).atan2(c * r.m22 - s * r.m23);
    p.numbers(x.translation().as_slice());
    p.numbers(&[roll, pitch, yaw]);
}

/// The upper triangle by rows.
pub(super) fn print_upper_triangle<const D: usize>(p: &mut Printer, m: &SMatrix<f64, D, D>) {
    for row in 0..D {
        for column in row..D {
            p.number(m[(row, column)]);
        }
    }
}

/// Writes a vertex.
pub(super) fn print_vertex<T>(
    p: &mut Printer,
    tag: &'static str,
    (id, value): (u64, &T),
    print: Print<T>,
) -> Result<(), WriteError> {
    p.line(tag, id, |p| {
        p.id(id);
        print(p, value);
    })
}

/// Writes an edge.
pub(super) fn print_edge<Z, const D: usize>(
    p: &mut Printer,
    tag: &'static str,
    e: &Edge<Z, D>,
    value: Print<Z>,
    information: Print<SMatrix<f64, D, D>>,
) -> Result<(), WriteError> {
    p.line(tag, e.from, |p| {
        p.id(e.from);
        p.id(e.to);
        value(p, &e.measured);
        information(p, &e.information);
    })
}

/// Writes a prior.
pub(super) fn print_prior<Z, const D: usize>(
    p: &mut Printer,
    tag: &'static str,
    prior: &Prior<Z, D>,
    value: Print<Z>,
) -> Result<(), WriteError> {
    p.line(tag, prior.id, |p| {
        p.id(prior.id);
        value(p, &prior.measured);
        print_upper_triangle(p, &prior.information);
    })
}

/// The angle whose cosine and sine are the stored ones, bit for bit, with the shortest decimal. A product of rotations may
/// lie between the rotations of all floats; then the angle of the nearest is taken.
fn angle_of(rotation: SO2) -> f64 {
    let angle = rotation.angle();
    exact_angle(rotation).or_else(|| exact_angle(rotation_of(angle))).unwrap_or(angle)
}

/// Among the floats next to atan2 those which give the rotation back, of these the one with the shortest decimal.
fn exact_angle(rotation: SO2) -> Option<f64> {
    let angle = rotation.angle();
    // atan2, cos and sin err by less than an ulp each, and a step of the angle by an ulp moves one of cos, sin by half of
    // one or more: four steps reach every angle.
    let below = core::iter::successors(Some(angle), |x| Some(x.next_down())).take(5);
    let above = core::iter::successors(Some(angle), |x| Some(x.next_up())).take(5).skip(1);
    let same = |x: &f64| {
        let back = rotation_of(*x);
        back.cos().to_bits() == rotation.cos().to_bits() && back.sin().to_bits() == rotation.sin().to_bits()
    };
    below.chain(above).filter(same).min_by_key(|x| format!("{x}").len())
}
