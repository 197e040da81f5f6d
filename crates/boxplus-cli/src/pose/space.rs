//! The plane and space: poses from what people write, and covariances in everybody's conventions.

use boxplus::lie::{Action, EulerSequence, LieGroup, SE2, SE3, SO2, SO3, orders};
use boxplus::uncertainty::{Covariance, Gaussian, UncertaintyError};
use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector3};

use super::args::{Convention, RotationForm, SideName};
use super::written::{Named, Written};
use crate::error::Error;

/// Poses of ℝᴺ, with D coordinates.
pub trait Space<const D: usize, const N: usize>: LieGroup<D, Scalar = f64> + Action<D, N> {
    /// The mean of what is written.
    fn mean(named: &Named) -> Result<Self, Error>;
    /// B, D×D: from our local errors of `mean` to the coordinates of a convention.
    fn chart(mean: &Self, convention: Convention, side: SideName) -> Result<SMatrix<f64, D, D>, Error>;
    /// The names of those coordinates, with their units.
    fn coordinates(convention: Convention) -> [&'static str; D];
    /// Where the origin is.
    fn origin(&self) -> SVector<f64, N>;
    /// The rotation as it is written: key and value.
    fn rotation(&self, form: RotationForm) -> (&'static str, Vec<Vec<f64>>);
    /// The angles for people, in degrees.
    fn degrees(&self) -> String;
}

/// The side that a convention has, if the user does not say another one that it allows.
pub fn side(convention: Convention, asked: Option<SideName>) -> Result<SideName, Error> {
    use Convention::{Barrau, Boxplus, Gtsam, Lgmath, Manif, Ros, Rpy, Sophus, Ypr};
    let own = match convention {
        Boxplus | Sophus | Barrau => return Ok(asked.unwrap_or(SideName::Local)),
        Lgmath => SideName::Global,
        // Of the last three, with the parent's axes or coordinates, neither: their charts start from the local one.
        Gtsam | Manif | Ros | Ypr | Rpy => SideName::Local,
    };
    match asked {
        Some(other) if other != own || matches!(convention, Ros | Ypr | Rpy) => Err(Error::Usage {
            message: format!("the convention {} has no side of choice", name(convention)),
            help: Some("leave the side out, or take the convention boxplus".to_owned()),
        }),
        _ => Ok(own),
    }
}

/// Its word.
pub fn name(convention: Convention) -> String {
    format!("{convention:?}").to_lowercase()
}

/// An uncertain pose, errors local, and B⁻¹: from the coordinates it was written in.
pub fn pose<G: Space<D, N>, const D: usize, const N: usize>(
    named: &Named,
    from: Convention,
) -> Result<(Gaussian<G, D>, SMatrix<f64, D, D>), Error> {
    let mean = G::mean(named)?;
    let convention = named.written.convention.unwrap_or(from);
    let chart = G::chart(&mean, convention, side(convention, named.written.side)?)
        .map_err(|error| about(named, error))?;
    let back = chart.try_inverse().ok_or_else(|| named.refused("its coordinates are singular there"))?;
    let given = covariance::<D>(named)?;
    Ok((Gaussian::new(mean, given.transformed(&back)), back))
}

/// An uncertain point.
pub fn point<const N: usize>(named: &Named) -> Result<(SVector<f64, N>, Covariance<N>), Error> {
    if named.written.rotations() > 0 {
        return Err(named.refused("a point has no rotation"));
    }
    Ok((position(named)?, covariance::<N>(named)?))
}

/// The covariance as it is written, checked.
fn covariance<const D: usize>(named: &Named) -> Result<Covariance<D>, Error> {
    let refused = |error: UncertaintyError| named.refused(&error.to_string());
    match (&named.written.sigmas, &named.written.covariance, &named.written.information) {
        (None, None, None) => Ok(Covariance::zero()),
        (Some(sigmas), None, None) => {
            let sigmas =
                numbers::<D>(sigmas).ok_or_else(|| named.sized("sigmas", &format!("{D} numbers")))?;
            Covariance::from_sigmas(&sigmas).map_err(refused)
        }
        (None, Some(rows), None) => Covariance::new(square(named, "covariance", rows)?).map_err(refused),
        (None, None, Some(rows)) => {
            Covariance::from_information(&square(named, "information", rows)?).map_err(refused)
        }
        _ => Err(named.refused("say one of sigmas, covariance and information")),
    }
}

/// D×D numbers.
pub fn square<const D: usize>(
    named: &Named,
    what: &str,
    rows: &[Vec<f64>],
) -> Result<SMatrix<f64, D, D>, Error> {
    let complete = rows.len() == D && rows.iter().all(|row| row.len() == D);
    let finite = rows.iter().flatten().all(|x| x.is_finite());
    match (complete, finite) {
        (true, true) => Ok(SMatrix::from_fn(|i, j| rows[i][j])),
        (true, false) => Err(named.refused(&format!("{what} has a number that is not finite"))),
        (false, _) => Err(named.sized(what, &format!("{D} rows of {D} numbers"))),
    }
}

fn numbers<const D: usize>(given: &[f64]) -> Option<SVector<f64, D>> {
    (given.len() == D).then(|| SVector::from_column_slice(given))
}

fn position<const N: usize>(named: &Named) -> Result<SVector<f64, N>, Error> {
    let finite = named.written.position.iter().all(|x| x.is_finite());
    if !finite {
        return Err(named.refused("its position is not finite"));
    }
    numbers(&named.written.position).ok_or_else(|| named.sized("position", &format!("{N} numbers")))
}

fn about(named: &Named, error: Error) -> Error {
    match error {
        Error::Usage { message, help } => {
            Error::Usage { message: format!("{}: {message}", named.label()), help }
        }
        other => other,
    }
}

impl Written {
    /// In how many ways the rotation is said.
    pub fn rotations(&self) -> usize {
        let said = [
            self.yaw.is_some(),
            self.yaw_deg.is_some(),
            self.yaw_pitch_roll.is_some(),
            self.yaw_pitch_roll_deg.is_some(),
            self.quaternion_xyzw.is_some(),
            self.quaternion_wxyz.is_some(),
            self.rotation_vector.is_some(),
            self.matrix.is_some(),
        ];
        said.into_iter().filter(|&said| said).count()
    }
}

impl Named {
    /// Short enough for a message.
    pub fn label(&self) -> String {
        let short: String = self.name.chars().take(40).collect();
        if short.len() < self.name.len() { format!("pose `{short}…`") } else { format!("pose `{short}`") }
    }

    /// What is wrong with it.
    pub fn refused(&self, message: &str) -> Error {
        Error::Unreadable { message: format!("{}: {message}", self.label()), help: None }
    }

    fn sized(&self, what: &str, wanted: &str) -> Error {
        let help = format!(
            "in the plane a position has 2 numbers and a covariance 3 rows, in space 3 and 6; this one has a position of {}",
            self.written.position.len()
        );
        Error::Unreadable { message: format!("{}: {what} must be {wanted}", self.label()), help: Some(help) }
    }

    fn one_rotation(&self, ways: &str) -> Result<(), Error> {
        let help = Some(format!("one of {ways}; zero is a rotation, too"));
        let refused =
            |message: &str| Error::Unreadable { message: format!("{}: {message}", self.label()), help };
        match self.written.rotations() {
            0 => Err(refused("its rotation is missing")),
            1 => Ok(()),
            _ => Err(refused("its rotation is said more than once")),
        }
    }

    fn rows<const R: usize>(&self) -> Result<Option<SMatrix<f64, R, R>>, Error> {
        self.written.matrix.as_deref().map(|rows| square(self, "matrix", rows)).transpose()
    }
}

impl Space<3, 2> for SE2 {
    fn mean(named: &Named) -> Result<Self, Error> {
        const WAYS: &str = "yaw, yaw_deg, matrix";
        named.one_rotation(WAYS)?;
        let written = &named.written;
        let angle = written.yaw.or(written.yaw_deg.map(f64::to_radians));
        let rotation = match (angle, named.rows()?) {
            (Some(angle), _) if angle.is_finite() => SO2::from_angle(angle),
            (None, Some(m)) => SO2::from_matrix(&m).map_err(|error| named.refused(&error.to_string()))?,
            (Some(_), _) => return Err(named.refused("its angle is not finite")),
            (None, None) => return Err(named.refused(&format!("a rotation in the plane is one of {WAYS}"))),
        };
        Ok(Self::from_parts(position(named)?, rotation))
    }

    fn chart(mean: &Self, convention: Convention, side: SideName) -> Result<Matrix3<f64>, Error> {
        use Convention::{Barrau, Boxplus, Gtsam, Lgmath, Manif, Ros, Rpy, Sophus, Ypr};
        match (convention, side) {
            (Boxplus | Gtsam | Manif | Sophus | Lgmath, SideName::Local) => Ok(Matrix3::identity()),
            (Boxplus | Gtsam | Manif | Sophus | Lgmath, SideName::Global) => Ok(mean.adjoint()),
            (Ros | Ypr | Rpy, _) => {
                let mut b = Matrix3::identity();
                b.fixed_view_mut::<2, 2>(0, 0).copy_from(&mean.rotation().to_matrix());
                Ok(b)
            }
            (Barrau, _) => Err(Error::Usage {
                message: "the convention barrau is one of poses in space".to_owned(),
                help: Some("in the plane take boxplus with --side".to_owned()),
            }),
        }
    }

    fn coordinates(convention: Convention) -> [&'static str; 3] {
        match convention {
            Convention::Ros | Convention::Ypr | Convention::Rpy => ["x m", "y m", "yaw rad"],
            _ => ["ρ₁ m", "ρ₂ m", "θ rad"],
        }
    }

    fn origin(&self) -> SVector<f64, 2> {
        self.translation()
    }

    fn rotation(&self, form: RotationForm) -> (&'static str, Vec<Vec<f64>>) {
        let m: Matrix2<f64> = self.rotation().to_matrix();
        match form {
            RotationForm::Matrix => ("matrix", rows(&m)),
            _ => ("yaw", vec![vec![self.angle()]]),
        }
    }

    fn degrees(&self) -> String {
        format!("yaw {:.4}°", self.angle().to_degrees())
    }
}

impl Space<6, 3> for SE3 {
    fn mean(named: &Named) -> Result<Self, Error> {
        const WAYS: &str = "yaw_pitch_roll, yaw_pitch_roll_deg, quaternion_xyzw, quaternion_wxyz, rotation_vector, matrix, yaw, yaw_deg";
        named.one_rotation(WAYS)?;
        let written = &named.written;
        let refused = |error: boxplus::lie::LieError| named.refused(&error.to_string());
        let yaw = written.yaw.or(written.yaw_deg.map(f64::to_radians)).map(|yaw| [yaw, 0.0, 0.0]);
        let angles =
            written.yaw_pitch_roll.or(written.yaw_pitch_roll_deg.map(|a| a.map(f64::to_radians))).or(yaw);
        let rotation = if let Some([yaw, pitch, roll]) = angles {
            SO3::from_yaw_pitch_roll(yaw, pitch, roll)
        } else if let Some(q) = written.quaternion_xyzw {
            SO3::from_xyzw(q).map_err(refused)?
        } else if let Some(q) = written.quaternion_wxyz {
            SO3::from_wxyz(q).map_err(refused)?
        } else if let Some(phi) = written.rotation_vector {
            SO3::exp(&phi.into())
        } else if let Some(m) = named.rows()? {
            SO3::from_matrix(&m).map_err(refused)?
        } else {
            return Err(named.refused(&format!("a rotation in space is one of {WAYS}")));
        };
        if rotation.quaternion_xyzw().iter().any(|x| !x.is_finite()) {
            return Err(named.refused("its rotation is not finite"));
        }
        Ok(Self::new(rotation, position(named)?))
    }

    fn chart(mean: &Self, convention: Convention, side: SideName) -> Result<SMatrix<f64, 6, 6>, Error> {
        use Convention::{Barrau, Boxplus, Gtsam, Lgmath, Manif, Ros, Rpy, Sophus, Ypr};
        let ours = match side {
            SideName::Local => SMatrix::identity(),
            SideName::Global => mean.adjoint(),
        };
        let r = mean.rotation().to_matrix();
        Ok(match convention {
            Boxplus => ours,
            Gtsam => orders::gtsam::POSE3.rows_to_theirs(&ours),
            Manif => orders::manif::SE3.rows_to_theirs(&ours),
            Sophus => orders::sophus::SE3.rows_to_theirs(&ours),
            Lgmath => orders::lgmath::SE3.rows_to_theirs(&ours),
            Barrau => orders::barrau::SE3.rows_to_theirs(&ours),
            Ros => blocks(&r, &r),
            Ypr => blocks(&r, &rates(mean)?),
            Rpy => {
                let rates = rates(mean)?;
                blocks(&r, &Matrix3::from_rows(&[rates.row(2), rates.row(1), rates.row(0)]))
            }
        })
    }

    fn coordinates(convention: Convention) -> [&'static str; 6] {
        use Convention::{Barrau, Gtsam, Ros, Rpy, Ypr};
        match convention {
            Gtsam | Barrau => ["φ₁ rad", "φ₂ rad", "φ₃ rad", "ρ₁ m", "ρ₂ m", "ρ₃ m"],
            Ros => ["x m", "y m", "z m", "about x rad", "about y rad", "about z rad"],
            Ypr => ["x m", "y m", "z m", "yaw rad", "pitch rad", "roll rad"],
            Rpy => ["x m", "y m", "z m", "roll rad", "pitch rad", "yaw rad"],
            _ => ["ρ₁ m", "ρ₂ m", "ρ₃ m", "φ₁ rad", "φ₂ rad", "φ₃ rad"],
        }
    }

    fn origin(&self) -> Vector3<f64> {
        self.translation()
    }

    fn rotation(&self, form: RotationForm) -> (&'static str, Vec<Vec<f64>>) {
        let r = self.rotation();
        match form {
            RotationForm::Xyzw => ("quaternion_xyzw", vec![r.quaternion_xyzw().to_vec()]),
            RotationForm::Wxyz => {
                let [x, y, z, w] = r.quaternion_xyzw();
                ("quaternion_wxyz", vec![vec![w, x, y, z]])
            }
            RotationForm::Ypr => ("yaw_pitch_roll", vec![r.yaw_pitch_roll().to_vec()]),
            RotationForm::Vector => ("rotation_vector", vec![r.log().as_slice().to_vec()]),
            RotationForm::Matrix => ("matrix", rows(&r.to_matrix())),
        }
    }

    fn degrees(&self) -> String {
        let [yaw, pitch, roll] = self.rotation().yaw_pitch_roll().map(f64::to_degrees);
        format!("yaw {yaw:.4}°, pitch {pitch:.4}°, roll {roll:.4}°")
    }
}

/// ∂(yaw, pitch, roll)/∂φ, local.
fn rates(mean: &SE3) -> Result<Matrix3<f64>, Error> {
    let undetermined = |message: String| Error::Undetermined {
        message,
        help: Some("take a convention that turns about axes: boxplus, gtsam, ros".to_owned()),
    };
    let angles = mean.rotation().to_euler(EulerSequence::ZYX);
    if angles.lock.is_some() {
        let degrees = angles.angles[1].to_degrees();
        return Err(undetermined(format!(
            "yaw and roll are not told apart at a pitch of {degrees:.4}° (gimbal lock): they have no covariance"
        )));
    }
    angles.d_angles_d_rotation().map_err(|error| undetermined(error.to_string()))
}

fn blocks(a: &Matrix3<f64>, b: &Matrix3<f64>) -> SMatrix<f64, 6, 6> {
    let mut m = SMatrix::<f64, 6, 6>::zeros();
    m.fixed_view_mut::<3, 3>(0, 0).copy_from(a);
    m.fixed_view_mut::<3, 3>(3, 3).copy_from(b);
    m
}

/// A matrix by rows.
pub fn rows<const R: usize, const C: usize>(m: &SMatrix<f64, R, C>) -> Vec<Vec<f64>> {
    m.row_iter().map(|row| row.iter().copied().collect()).collect()
}
