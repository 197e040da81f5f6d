//! The best transform between paired points, in closed form, and how sure it is.

use super::error::{Axis, RegistrationError, Role};
use crate::lie::{Action, LieError, SE2, SE3, Sim2, Sim3, Tangent};
use crate::uncertainty::{Covariance, Gaussian};
use nalgebra::{ComplexField, Matrix2, Matrix3, Matrix4, SMatrix, SVector};

/// A group that pairs of points determine: [`SE2`], [`SE3`], [`Sim2`], [`Sim3`].
///
/// Its tangent starts with the N coordinates of a translation.
pub trait Alignable<const D: usize, const N: usize>: Action<D, N, Scalar = f64> {
    /// The element without translation whose linear part is nearest to a matrix, in the Frobenius norm.
    ///
    /// # Errors
    /// [`LieError::Undetermined`] where several are equally near.
    fn nearest(linear: &SMatrix<f64, N, N>) -> Result<Self, LieError>;

    /// Whether the determinant of a matrix is negative.
    fn mirrors(linear: &SMatrix<f64, N, N>) -> bool;

    /// p ↦ p + t.
    fn translation_by(t: &SVector<f64, N>) -> Self {
        Self::exp(&Tangent::<f64, D>::from_fn(|i, _| if i < N { t[i] } else { 0.0 }))
    }
}

macro_rules! alignable {
    ($($group:ident, $dimension:literal, $size:literal, $linear:ident, $homogeneous:ident;)*) => {$(
        impl Alignable<$dimension, $size> for $group {
            fn nearest(linear: &$linear<f64>) -> Result<Self, LieError> {
                let mut m = $homogeneous::identity();
                m.fixed_view_mut::<$size, $size>(0, 0).copy_from(linear);
                Self::project(&m)
            }

            fn mirrors(linear: &$linear<f64>) -> bool {
                linear.determinant() < 0.0
            }
        }
    )*};
}

alignable! {
    SE2, 3, 2, Matrix2, Matrix3;
    SE3, 6, 3, Matrix3, Matrix4;
    Sim2, 4, 2, Matrix2, Matrix3;
    Sim3, 7, 3, Matrix3, Matrix4;
}

/// A group of rigid motions, [`SE2`] or [`SE3`]: what scans without known pairs determine. A free scale would shrink a source
/// to a point, which has a partner at no distance.
pub trait Rigid<const D: usize, const N: usize>: Alignable<D, N> {}

impl Rigid<3, 2> for SE2 {}
impl Rigid<6, 3> for SE3 {}

/// Coordinates up to here have squares, and sums of squares, that are finite.
pub(super) const LARGEST: f64 = 1e100;

/// What is known of the errors e = q − X·p of the pairs.
#[derive(Clone, Copy, Debug)]
pub enum Noise<'a, const N: usize> {
    /// The residuals tell: independent errors of variance σ²/w, the same along every axis, σ² = Σw|e|²/(Nn − D).
    Estimated,
    /// Independent errors of variance σ²/w, the same along every axis; σ in the units of the target, w the weight of the pair.
    Isotropic(f64),
    /// One covariance per pair, in the axes of the target: that of q plus A·(that of p)·Aᵀ.
    PerPair(&'a [Covariance<N>]),
}

/// Points p of a source and q of a target that are known to correspond, with weights.
///
/// ```
/// use boxplus::lie::{LieGroup, SE3};
/// use boxplus::registration::{Noise, Pairs, RegistrationError};
/// use nalgebra::{Vector3, Vector6};
/// let truth: SE3 = SE3::exp(&Vector6::new(1.0, 2.0, 3.0, 0.1, -0.2, 0.3));
/// let source = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]].map(Vector3::from);
/// let target = source.map(|p| truth * p);
/// let pairs = Pairs::new(&source, &target)?;
/// let fit = pairs.align::<SE3, 6>()?;
/// assert!(fit.target_from_source.rminus(&truth).norm() < 1e-14);
/// let pose = pairs.uncertain(&fit.target_from_source, Noise::Isotropic(0.01))?; // points to a centimetre
/// assert!(pose.sigmas()[5] < 0.01);
///
/// let line = [[0.0; 3], [1.0; 3], [2.0; 3]].map(Vector3::from);
/// let refused = Pairs::new(&line, &line)?.align::<SE3, 6>().unwrap_err();
/// assert_eq!(
///     refused.to_string(),
///     "the source points lie on a line: the rotation about its axis (0.58, 0.58, 0.58) is free"
/// );
/// # Ok::<(), RegistrationError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Pairs<'a, const N: usize> {
    source: &'a [SVector<f64, N>],
    target: &'a [SVector<f64, N>],
    weights: Option<&'a [f64]>,
}

/// The transform that fits pairs best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aligned<G> {
    /// X, with q ≈ X·p.
    pub target_from_source: G,
    /// √(Σw|q − X·p|²/Σw), in the units of the target.
    pub rms: f64,
    /// Whether a reflection fits better than any rotation. Usual for flat sets with noise; for others an axis is likely flipped.
    pub reflected: bool,
}

/// Weighted moments of pairs about their centroids.
struct Moments<const N: usize> {
    weight: f64,
    centroids: [SVector<f64, N>; 2],
    /// Σw(p − p̄)(p − p̄)ᵀ/Σw, and the same of q.
    scatters: [SMatrix<f64, N, N>; 2],
    /// Σw(q − q̄)(p − p̄)ᵀ/Σw.
    cross: SMatrix<f64, N, N>,
    /// Largest |coordinate| of each set.
    reach: [f64; 2],
}

impl<'a, const N: usize> Pairs<'a, N> {
    /// Pairs `source[i]` with `target[i]`.
    ///
    /// # Errors
    /// [`RegistrationError::Unpaired`], [`RegistrationError::NotFinite`].
    pub fn new(
        source: &'a [SVector<f64, N>],
        target: &'a [SVector<f64, N>],
    ) -> Result<Self, RegistrationError> {
        if source.len() != target.len() {
            let (source_points, target_points) = (source.len(), target.len());
            return Err(RegistrationError::Unpaired { source_points, target_points });
        }
        check_finite(source, Role::Source)?;
        check_finite(target, Role::Target)?;
        Ok(Self { source, target, weights: None })
    }

    /// The same pairs, pair i with `weights[i]` ≥ 0: the inverse of its variance, up to a common factor.
    ///
    /// # Errors
    /// [`RegistrationError::WeightCount`], [`RegistrationError::NotAWeight`].
    pub fn weighted(self, weights: &'a [f64]) -> Result<Self, RegistrationError> {
        if weights.len() != self.source.len() {
            let (pairs, weights) = (self.source.len(), weights.len());
            return Err(RegistrationError::WeightCount { pairs, weights });
        }
        let valid = |w: f64| (0.0..=LARGEST).contains(&w);
        match weights.iter().enumerate().find(|(_, w)| !valid(**w)) {
            Some((index, &weight)) => Err(RegistrationError::NotAWeight { index, weight }),
            None => Ok(Self { weights: Some(weights), ..self }),
        }
    }

    /// The X that minimises Σw|q − X·p|²: Arun, Huang & Blostein (1987), Horn (1987), with scale Umeyama (1991).
    ///
    /// The linear part is the element nearest to C·N/tr(Σ_p), with C = Σw(q − q̄)(p − p̄)ᵀ/Σw and Σ_p the scatter of p, which
    /// is nearest to C as a rotation and has Umeyama's scale. Where only the target has errors, this is the
    /// most likely X. Errors of the source make the scale too small, by the part of their variance in that of the points.
    ///
    /// # Errors
    /// [`RegistrationError::TooFewPairs`], [`RegistrationError::Coincident`], [`RegistrationError::Collinear`],
    /// [`RegistrationError::Ambiguous`].
    pub fn align<G: Alignable<D, N>, const D: usize>(&self) -> Result<Aligned<G>, RegistrationError> {
        let moments = self.moments()?;
        moments.check()?;
        let linear = moments.cross * (N as f64 / moments.scatters[0].trace());
        let rotation = G::nearest(&linear).map_err(|_| moments.ambiguous())?;
        let [source, target] = moments.centroids;
        let target_from_source =
            G::translation_by(&target).compose(&rotation).compose(&G::translation_by(&-source));
        // In coordinates about the centroids, whose digits the translation does not eat.
        let squares = self.each().map(|(w, p, q)| {
            w * (q - target - rotation.linear_part() * (p - source)).norm_squared() / moments.weight
        });
        let rms = ComplexField::sqrt(squares.sum::<f64>());
        Ok(Aligned { target_from_source, rms, reflected: G::mirrors(&moments.cross) })
    }

    /// X with the covariance of its local tangent, to first order in the errors of the pairs.
    ///
    /// With J = ∂(X·p)/∂X it is H⁻¹(Σw²JᵀCJ)H⁻¹, H = ΣwJᵀJ, for errors of covariance C; for isotropic ones this is σ²H⁻¹. X may
    /// be any estimate; at [`Pairs::align`] the formula is that of the least-squares estimator.
    ///
    /// # Errors
    /// [`RegistrationError::NoRedundancy`], [`RegistrationError::NotASigma`], [`RegistrationError::CovarianceCount`], or those
    /// of [`Pairs::align`], where the points do not determine X.
    pub fn uncertain<G: Alignable<D, N>, const D: usize>(
        &self,
        target_from_source: &G,
        noise: Noise<'_, N>,
    ) -> Result<Gaussian<G, D>, RegistrationError> {
        let moments = self.moments()?;
        moments.check()?;
        let [centre, _] = moments.centroids;
        let a = target_from_source.linear_part();
        let jacobian = |p: &SVector<f64, N>| a * G::generators_at(&(p - centre));
        let information = self.each().fold(SMatrix::<f64, D, D>::zeros(), |sum, (w, p, _)| {
            let j = jacobian(p);
            sum + j.transpose() * j * w
        });
        let unit = Covariance::from_information(&information)?;
        let covariance = match noise {
            Noise::Estimated => unit * self.deviation::<G, D>(target_from_source)?,
            Noise::Isotropic(sigma) if sigma > 0.0 && sigma <= LARGEST => unit * sigma,
            Noise::Isotropic(sigma) => return Err(RegistrationError::NotASigma { sigma }),
            Noise::PerPair(covariances) => {
                self.check_count(covariances.len())?;
                let score = self.each().zip(covariances).fold(SMatrix::zeros(), |sum, ((w, p, _), c)| {
                    let j = jacobian(p);
                    sum + j.transpose() * c.matrix() * j * (w * w)
                });
                Covariance::new(score)?.transformed(unit.matrix())
            }
        };
        // The sum was taken where X·T(p̄) is local; back to the origin of the source.
        let about_centre = target_from_source.compose(&G::translation_by(&centre));
        Ok(Gaussian::new(about_centre, covariance).change_body(&G::translation_by(&-centre)))
    }

    /// √(Σw|q − X·p|²/(Nn − D)).
    fn deviation<G: Alignable<D, N>, const D: usize>(&self, x: &G) -> Result<f64, RegistrationError> {
        let pairs = self.count();
        if N * pairs <= D {
            return Err(RegistrationError::NoRedundancy { pairs });
        }
        let squares: f64 = self.each().map(|(w, p, q)| w * (q - x.act(p)).norm_squared()).sum();
        Ok(ComplexField::sqrt(squares / (N * pairs - D) as f64))
    }

    fn check_count(&self, covariances: usize) -> Result<(), RegistrationError> {
        let pairs = self.source.len();
        if covariances == pairs {
            Ok(())
        } else {
            Err(RegistrationError::CovarianceCount { pairs, covariances })
        }
    }

    /// `(weight, source point, target point)` of every pair.
    fn each(
        &self,
    ) -> impl Iterator<Item = (f64, &'a SVector<f64, N>, &'a SVector<f64, N>)> + Clone + use<'a, N> {
        let weights = self.weights;
        let pairs = self.source.iter().zip(self.target).enumerate();
        pairs.map(move |(i, (p, q))| (weights.map_or(1.0, |w| w[i]), p, q))
    }

    /// How many pairs have a weight.
    fn count(&self) -> usize {
        self.each().filter(|(w, ..)| *w > 0.0).count()
    }

    fn moments(&self) -> Result<Moments<N>, RegistrationError> {
        let (given, needed) = (self.count(), N);
        if given < needed {
            return Err(RegistrationError::TooFewPairs { given, needed });
        }
        let weight: f64 = self.each().map(|(w, ..)| w).sum();
        let mean = |f: fn(&SVector<f64, N>, &SVector<f64, N>) -> SVector<f64, N>| {
            self.each().fold(SVector::zeros(), |sum, (w, p, q)| sum + f(p, q) * (w / weight))
        };
        let centroids = [mean(|p, _| *p), mean(|_, q| *q)];
        let mut moments = Moments {
            weight,
            centroids,
            scatters: [SMatrix::zeros(); 2],
            cross: SMatrix::zeros(),
            reach: [0.0; 2],
        };
        for (w, p, q) in self.each().filter(|(w, ..)| *w > 0.0) {
            let (dp, dq) = (p - centroids[0], q - centroids[1]);
            let share = w / weight;
            moments.scatters[0] += dp * dp.transpose() * share;
            moments.scatters[1] += dq * dq.transpose() * share;
            moments.cross += dq * dp.transpose() * share;
            moments.reach = [moments.reach[0].max(p.amax()), moments.reach[1].max(q.amax())];
        }
        Ok(moments)
    }
}

impl<const N: usize> Moments<N> {
    /// Whether each set spans a plane, or in the plane a line.
    ///
    /// Coordinates are known to ε times the largest of them, and an eigenvalue of a scatter to ε times the largest of those:
    /// what is below 32 times either is no extent.
    fn check(&self) -> Result<(), RegistrationError> {
        for (k, role) in [Role::Source, Role::Target].into_iter().enumerate() {
            let (variances, axes) = Covariance::new(self.scatters[k])?.principal_axes();
            let rounding = 32.0 * f64::EPSILON * self.reach[k];
            let none = rounding * rounding;
            if variances[0] <= none {
                return Err(RegistrationError::Coincident { role });
            }
            if N > 2 && variances[1] <= none.max(32.0 * f64::EPSILON * variances[0]) {
                let axis = Axis::new(axes.column(0).as_slice());
                return Err(RegistrationError::Collinear { role, axis });
            }
        }
        Ok(())
    }

    /// The rotation about the first left singular vector of C is the one that costs least.
    fn ambiguous(&self) -> RegistrationError {
        let axis = match Covariance::new(self.cross * self.cross.transpose()) {
            Ok(square) if N > 2 => Axis::new(square.principal_axes().1.column(0).as_slice()),
            _ => Axis::new(&[0.0, 0.0, 1.0]),
        };
        RegistrationError::Ambiguous { axis }
    }
}

pub(super) fn check_finite<const N: usize>(
    points: &[SVector<f64, N>],
    role: Role,
) -> Result<(), RegistrationError> {
    let bad = |p: &SVector<f64, N>| !p.iter().all(|x| x.abs() <= LARGEST);
    match points.iter().position(bad) {
        Some(index) => Err(RegistrationError::NotFinite { role, index }),
        None => Ok(()),
    }
}
