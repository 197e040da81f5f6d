//! To and from the types of nalgebra.
//!
//! Quaternions, complex numbers and isometries are rotations by their type and come by `From`; they are normalised on the
//! way, nalgebra's may have drifted. Matrices (`Rotation3`, `Rotation2`) and scales are checked: `TryFrom`. A number that is
//! not finite stays so.

use crate::lie::{LieError, Real, SE2, SE3, SO2, SO3, Sim2, Sim3};
use nalgebra::{
    Isometry2, Isometry3, Quaternion, Rotation2, Rotation3, Similarity2, Similarity3, Translation, Unit,
    UnitComplex, UnitQuaternion,
};

impl<S: Real> From<UnitQuaternion<S>> for SO3<S> {
    fn from(q: UnitQuaternion<S>) -> Self {
        Self::from_unit(q.imag(), q.w).normalize()
    }
}

impl<S: Real> From<SO3<S>> for UnitQuaternion<S> {
    fn from(r: SO3<S>) -> Self {
        let [x, y, z, w] = r.quaternion_xyzw();
        Unit::new_unchecked(Quaternion::new(w, x, y, z))
    }
}

impl<S: Real> TryFrom<Rotation3<S>> for SO3<S> {
    type Error = LieError;
    fn try_from(r: Rotation3<S>) -> Result<Self, LieError> {
        Self::from_matrix(r.matrix())
    }
}

impl<S: Real> From<SO3<S>> for Rotation3<S> {
    fn from(r: SO3<S>) -> Self {
        Self::from_matrix_unchecked(r.to_matrix())
    }
}

impl<S: Real> From<UnitComplex<S>> for SO2<S> {
    fn from(z: UnitComplex<S>) -> Self {
        Self::from_unit(z.re, z.im).normalize()
    }
}

impl<S: Real> From<SO2<S>> for UnitComplex<S> {
    fn from(r: SO2<S>) -> Self {
        Unit::new_unchecked(nalgebra::Complex::new(r.cos(), r.sin()))
    }
}

impl<S: Real> TryFrom<Rotation2<S>> for SO2<S> {
    type Error = LieError;
    fn try_from(r: Rotation2<S>) -> Result<Self, LieError> {
        Self::from_matrix(r.matrix())
    }
}

impl<S: Real> From<SO2<S>> for Rotation2<S> {
    fn from(r: SO2<S>) -> Self {
        Self::from_matrix_unchecked(r.to_matrix())
    }
}

impl<S: Real> From<Isometry3<S>> for SE3<S> {
    fn from(x: Isometry3<S>) -> Self {
        Self::new(x.rotation.into(), x.translation.vector)
    }
}

impl<S: Real> From<SE3<S>> for Isometry3<S> {
    fn from(x: SE3<S>) -> Self {
        Self::from_parts(Translation::from(x.translation()), x.rotation().into())
    }
}

impl<S: Real> From<Isometry2<S>> for SE2<S> {
    fn from(x: Isometry2<S>) -> Self {
        Self::from_parts(x.translation.vector, x.rotation.into())
    }
}

impl<S: Real> From<SE2<S>> for Isometry2<S> {
    fn from(x: SE2<S>) -> Self {
        Self::from_parts(Translation::from(x.translation()), x.rotation().into())
    }
}

/// Refuses a scale that is not positive, which nalgebra allows.
impl<S: Real> TryFrom<Similarity3<S>> for Sim3<S> {
    type Error = LieError;
    fn try_from(x: Similarity3<S>) -> Result<Self, LieError> {
        Self::from_scale(x.isometry.rotation.into(), x.isometry.translation.vector, x.scaling())
    }
}

impl<S: Real> From<Sim3<S>> for Similarity3<S> {
    fn from(x: Sim3<S>) -> Self {
        Self::from_parts(Translation::from(x.translation()), x.rotation().into(), x.scale())
    }
}

/// Refuses a scale that is not positive, which nalgebra allows.
impl<S: Real> TryFrom<Similarity2<S>> for Sim2<S> {
    type Error = LieError;
    fn try_from(x: Similarity2<S>) -> Result<Self, LieError> {
        Self::from_scale(x.isometry.rotation.into(), x.isometry.translation.vector, x.scaling())
    }
}

impl<S: Real> From<Sim2<S>> for Similarity2<S> {
    fn from(x: Sim2<S>) -> Self {
        Self::from_parts(Translation::from(x.translation()), x.rotation().into(), x.scale())
    }
}
