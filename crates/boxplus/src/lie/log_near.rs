//! The logarithm nearest to a reference: tangents that follow an element through θ = π, 2π, ….
//!
//! A rotation has many logarithms, φ·(1 + 2πk/θ); `log` takes the shortest and therefore jumps at π. A filter, a plot or a spline
//! that follows a motion wants the one near where it was: [`LogNear::log_near`]. The rest of the tangent follows the chosen φ,
//! ρ = J_l(φ)⁻¹·t, and with scale ρ = G(φ, σ)⁻¹·t.
//!
//! Perpendicular to the axis the plane is that of complex numbers, turned by φ × ·; with z = σ + iθ
//!
//! ```text
//! ρ∥ = (σ/(e^σ − 1))·t∥        ρ⊥ = (z/(eᶻ − 1))·t⊥        eᶻ = e^σ·(cos θ + i sin θ)
//! ```
//! where eᶻ is read off the element, however many turns θ has, so that nothing is lost to the rounding of 2πk. After whole
//! turns (k ≠ 0, R = I) and without scale, t has no logarithm, unless t⊥ = 0: [`LieError::WholeTurns`]. Elsewhere Log returns
//! the tangent of Exp within 4ε·θ times the condition θ/(2 sin(θ/2)), every group, `f32` and `f64` (`tests/rotations`).
//!
//! ```
//! use boxplus::lie::{LieGroup, LogNear, SE2};
//! use nalgebra::Vector3;
//! let step = Vector3::new(0.1, 0.0, 0.05);
//! let mut odometer = Vector3::zeros();
//! let mut pose: SE2 = SE2::identity();
//! for _ in 0..100 {
//!     pose = pose.rplus(&step);
//!     odometer = pose.log_near(&odometer)?;
//! }
//! assert!((odometer - step * 100.0).norm() < 1e-12); // 5 rad, and not 5 − 2π
//! # Ok::<(), boxplus::lie::LieError>(())
//! ```

use super::{LieError, LieGroup, Real, RxSO2, RxSO3, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3, Tangent};
use core::f64::consts::TAU;
use nalgebra::{SVector, SimdComplexField, Vector1, Vector2, Vector3, Vector4};

/// A group whose elements have several logarithms.
pub trait LogNear<const D: usize>: LieGroup<D> {
    /// The τ with Exp τ = `self` whose rotation is nearest to that of `reference`. For single numbers.
    ///
    /// # Errors
    /// [`LieError::WholeTurns`] where R = I to rounding, the reference asks for one turn or more, and there is a translation.
    fn log_near(&self, reference: &Tangent<Self::Scalar, D>) -> Result<Tangent<Self::Scalar, D>, LieError>;
}

impl<S: Real> LogNear<1> for SO2<S> {
    fn log_near(&self, reference: &Vector1<S>) -> Result<Vector1<S>, LieError> {
        Ok(Vector1::new(angle_near(self, reference.x)))
    }
}

impl<S: Real> LogNear<2> for RxSO2<S> {
    fn log_near(&self, reference: &Vector2<S>) -> Result<Vector2<S>, LieError> {
        Ok(Vector2::new(angle_near(&self.rotation(), reference.x), self.log_scale()))
    }
}

impl<S: Real> LogNear<3> for SO3<S> {
    fn log_near(&self, reference: &Vector3<S>) -> Result<Vector3<S>, LieError> {
        Ok(SO3::log_near(self, reference))
    }
}

impl<S: Real> LogNear<4> for RxSO3<S> {
    fn log_near(&self, reference: &Vector4<S>) -> Result<Vector4<S>, LieError> {
        Ok(self.rotation().log_near(&reference.xyz()).push(self.log_scale()))
    }
}

impl<S: Real> LogNear<3> for SE2<S> {
    fn log_near(&self, reference: &Vector3<S>) -> Result<Vector3<S>, LieError> {
        if angle_near(&self.rotation(), reference.z).value() == self.angle().value() {
            return Ok(self.log());
        }
        let similarity = Sim2::from_pose(self).log_near(&reference.push(S::zero()))?;
        Ok(similarity.xyz())
    }
}

impl<S: Real> LogNear<4> for Sim2<S> {
    fn log_near(&self, reference: &Vector4<S>) -> Result<Vector4<S>, LieError> {
        let theta = angle_near(&self.rotation(), reference.z);
        if theta.value() == self.rotation().angle().value() {
            return Ok(self.log());
        }
        let plane =
            Turns { theta, sigma: self.log_scale(), power: growth(self.log_scale(), &self.rotation()) };
        let [a, b] = plane.across(self.translation().iter().all(|x| x.value() == 0.0))?;
        let rho = self.translation() * a + SO2::turn(&self.translation()) * b;
        Ok(Vector4::new(rho.x, rho.y, theta, self.log_scale()))
    }
}

impl<S: Real> LogNear<6> for SE3<S> {
    fn log_near(&self, reference: &Tangent<S, 6>) -> Result<Tangent<S, 6>, LieError> {
        match Unturn::new(&self.rotation(), &reference.fixed_rows::<3>(3).into_owned(), S::zero()) {
            None => Ok(self.log()),
            Some(unturn) => Ok(join([unturn.apply(&self.translation())?, unturn.phi])),
        }
    }
}

impl<S: Real> LogNear<7> for Sim3<S> {
    fn log_near(&self, reference: &Tangent<S, 7>) -> Result<Tangent<S, 7>, LieError> {
        match Unturn::new(&self.rotation(), &reference.fixed_rows::<3>(3).into_owned(), self.log_scale()) {
            None => Ok(self.log()),
            Some(unturn) => {
                let tau: Tangent<S, 6> = join([unturn.apply(&self.translation())?, unturn.phi]);
                Ok(tau.push(self.log_scale()))
            }
        }
    }
}

impl<S: Real> LogNear<9> for SE23<S> {
    fn log_near(&self, reference: &Tangent<S, 9>) -> Result<Tangent<S, 9>, LieError> {
        match Unturn::new(&self.rotation(), &reference.fixed_rows::<3>(3).into_owned(), S::zero()) {
            None => Ok(self.log()),
            Some(unturn) => {
                Ok(join([unturn.apply(&self.position())?, unturn.phi, unturn.apply(&self.velocity())?]))
            }
        }
    }
}

impl<S: Real> LogNear<10> for SGal3<S> {
    fn log_near(&self, reference: &Tangent<S, 10>) -> Result<Tangent<S, 10>, LieError> {
        let Some(unturn) =
            Unturn::new(&self.rotation(), &reference.fixed_rows::<3>(3).into_owned(), S::zero())
        else {
            return Ok(self.log());
        };
        // ρ = J⁻¹(p − ι·Γ₂ν) with ν = J⁻¹v, and Γ₂ν = φ^⁻¹(v − ν) across the axis, ½ν along it: J = I + Γ₂φ^.
        let (v, phi) = (self.velocity(), unturn.phi);
        let nu = unturn.apply(&v)?;
        let x = phi.norm_squared();
        let bend = (v - nu).cross(&phi) / x + phi * (phi.dot(&nu) / x * S::lit(0.5));
        let rho = unturn.apply(&(self.position() - bend * self.time()))?;
        let tau: Tangent<S, 9> = join([rho, phi, nu]);
        Ok(tau.push(self.time()))
    }
}

/// Three coordinates each, one after the other.
fn join<S: Real, const K: usize, const D: usize>(parts: [Vector3<S>; K]) -> SVector<S, D> {
    SVector::from_fn(|i, _| parts[i / 3][i % 3])
}

/// The angle of `rotation` nearest to `reference`.
fn angle_near<S: Real>(rotation: &SO2<S>, reference: S) -> S {
    let angle = rotation.angle();
    angle + S::lit(TAU * ((reference - angle).value() / TAU).simd_round())
}

/// eᶻ − 1 as (re, im), with 1 − cos θ = 2·sin²(θ/2) free of cancellation.
fn growth<S: Real>(sigma: S, rotation: &SO2<S>) -> Vector2<S> {
    let scale = sigma.simd_exp();
    let (cos, sin) = (rotation.cos(), rotation.sin());
    // sin²/(1 + cos) near θ = 0, 1 − cos elsewhere.
    let versine = if cos.value() > 0.0 { sin * sin / (S::one() + cos) } else { S::one() - cos };
    Vector2::new(sigma.simd_exp_m1() - scale * versine, scale * sin)
}

/// z = σ + iθ and eᶻ − 1, at θ of one turn or more.
struct Turns<S> {
    theta: S,
    sigma: S,
    power: Vector2<S>,
}

impl<S: Real> Turns<S> {
    /// z/(eᶻ − 1) as \[re, im\].
    fn across(&self, nothing_across: bool) -> Result<[S; 2], LieError> {
        let (re, im) = (self.power.x, self.power.y);
        let size = re * re + im * im;
        // An element is right to about 4ε; nearer than this to I, no digit of z/(eᶻ − 1) is known.
        if size.value() <= (16.0 * S::EPSILON) * (16.0 * S::EPSILON) {
            return if nothing_across { Ok([S::zero(); 2]) } else { Err(LieError::WholeTurns) };
        }
        Ok([(self.sigma * re + self.theta * im) / size, (self.theta * re - self.sigma * im) / size])
    }
}

/// G(φ, σ)⁻¹ at a φ that is not the shortest: J_l(φ)⁻¹ where σ = 0.
struct Unturn<S> {
    phi: Vector3<S>,
    turns: Turns<S>,
}

impl<S: Real> Unturn<S> {
    /// None where the shortest logarithm is the nearest to `reference`.
    fn new(rotation: &SO3<S>, reference: &Vector3<S>, sigma: S) -> Option<Self> {
        let phi = rotation.log_near(reference);
        if phi.map(Real::value) == rotation.log().map(Real::value) {
            return None;
        }
        let theta = phi.norm_squared().simd_sqrt();
        let [x, y, z, w] = rotation.quaternion_xyzw();
        let sin_half = Vector3::new(x, y, z).dot(&phi) / theta;
        let scale = sigma.simd_exp() * S::lit(2.0);
        let power = Vector2::new(sigma.simd_exp_m1() - scale * sin_half * sin_half, scale * sin_half * w);
        Some(Self { phi, turns: Turns { theta, sigma, power } })
    }

    fn apply(&self, t: &Vector3<S>) -> Result<Vector3<S>, LieError> {
        let axis = self.phi / self.turns.theta;
        let along = axis * axis.dot(t);
        let across = t - along;
        let nothing = across.norm_squared().value() <= (S::EPSILON * S::EPSILON) * t.norm_squared().value();
        let [a, b] = self.turns.across(nothing)?;
        let sigma = self.turns.sigma;
        let shrink = if sigma.value() == 0.0 { S::one() } else { sigma / sigma.simd_exp_m1() };
        Ok(along * shrink + across * a + axis.cross(t) * b)
    }
}
