//! Integrators that never leave the group: Ẋ = X·f(t, X)^ by exponentials.
//!
//! A step of a vector-space Runge–Kutta method leaves the group and must be projected back, which costs its order or its
//! invariants. These step along tangents instead. Body form, k = h·f in the frame of X:
//!
//! ```text
//! Lie–Euler   X⁺ = X⊕k₁                                                                                  order 1
//! CG3         k₂ at X⊕¾k₁,  k₃ at X⊕(119/216)k₁⊕(17/108)k₂,  X⁺ = X⊕(13/51)k₁⊕(−⅔)k₂⊕(24/17)k₃          order 3
//! RKMK4       k₂ at X⊕½k₁,  k₃ at X⊕(½k₂ + ⅛[k₁, k₂]),  k₄ at X⊕k₃,
//!             X⁺ = X⊕(k₁ + 2k₂ + 2k₃ + k₄ + ½[k₁, k₄])/6                                                 order 4
//! CF4         k₂ at Y = X⊕½k₁,  k₃ at X⊕½k₂,  k₄ at Y⊕(k₃ − ½k₁),
//!             X⁺ = X⊕(3k₁ + 2k₂ + 2k₃ − k₄)/12⊕(−k₁ + 2k₂ + 2k₃ + 3k₄)/12                                order 4
//! ```
//! CG3: Crouch & Grossman (1993); RKMK4: Munthe-Kaas (1999); CF4: Celledoni, Marthinsen & Owren (2003), free of brackets.
//!
//! Which one? For a given error CF4 or RKMK4 need the fewest evaluations of f; where f is known in advance, a function of
//! time alone, [`super::magnus4`] needs two per step. `examples/integrate.rs` prints error against step for all.
//!
//! Pitfall: the signs of the brackets belong to the side. With those of the spatial form (most textbooks) RKMK4 falls to
//! order 2.

use crate::lie::{LieGroup, Real, Tangent};

/// A method with a fixed step; all are explicit and of the stated order on every group.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Integrator {
    /// X⊕h·f: order 1, one evaluation.
    LieEuler,
    /// Crouch & Grossman (1993): order 3, three evaluations, six exponentials.
    CrouchGrossman3,
    /// Runge–Kutta–Munthe-Kaas: order 4, four evaluations, four exponentials, two brackets.
    Rkmk4,
    /// Celledoni, Marthinsen & Owren (2003): order 4, four evaluations, five exponentials, no bracket.
    CommutatorFree4,
}

impl Integrator {
    /// All of them, by order.
    pub const ALL: [Self; 4] = [Self::LieEuler, Self::CrouchGrossman3, Self::Rkmk4, Self::CommutatorFree4];

    /// p: the error of a whole integration vanishes like hᵖ.
    pub fn order(self) -> u32 {
        match self {
            Self::LieEuler => 1,
            Self::CrouchGrossman3 => 3,
            Self::Rkmk4 | Self::CommutatorFree4 => 4,
        }
    }

    /// X(t + h) from X(t), where Ẋ = X·f(t, X)^ and f is a body velocity. h may be negative.
    pub fn step<G: LieGroup<D>, const D: usize>(
        self,
        x: &G,
        t: G::Scalar,
        h: G::Scalar,
        f: impl Fn(G::Scalar, &G) -> Tangent<G::Scalar, D>,
    ) -> G {
        let k = |c: f64, x: &G| f(t + h * G::Scalar::lit(c), x) * h;
        match self {
            Self::LieEuler => x.rplus(&k(0.0, x)),
            Self::CrouchGrossman3 => crouch_grossman3(x, k),
            Self::Rkmk4 => rkmk4(x, k),
            Self::CommutatorFree4 => commutator_free4(x, k),
        }
    }

    /// X(t + h) from X(t), where Ẋ = f(t, X)^·X and f is a spatial velocity.
    ///
    /// It is the body form of X⁻¹, whose velocity is −f: products turn round and brackets change sign by themselves.
    pub fn step_spatial<G: LieGroup<D>, const D: usize>(
        self,
        x: &G,
        t: G::Scalar,
        h: G::Scalar,
        f: impl Fn(G::Scalar, &G) -> Tangent<G::Scalar, D>,
    ) -> G {
        self.step(&x.inverse(), t, h, |t, y| -f(t, &y.inverse())).inverse()
    }

    /// X(t + `duration`) from X(t) in `steps` equal steps, body form. No step returns X.
    ///
    /// ```
    /// use boxplus::lie::{LieGroup, SO3};
    /// use boxplus::trajectory::Integrator;
    /// use nalgebra::Vector3;
    /// // The rates of a symmetric top: ω turns about its axis.
    /// let omega = |t: f64, _: &SO3| Vector3::new(t.cos(), t.sin(), 2.0);
    /// let end = Integrator::CommutatorFree4.integrate(&SO3::identity(), 0.0, 1.0, 100, omega);
    /// // In a frame that turns by −z they are constant: R(t) = Exp((t, 0, 3t))·Rot_z(−t).
    /// let truth = SO3::exp(&Vector3::new(1.0, 0.0, 3.0)) * SO3::exp(&Vector3::new(0.0, 0.0, -1.0));
    /// assert!(end.rminus(&truth).norm() < 1e-9);
    /// ```
    pub fn integrate<G: LieGroup<D>, const D: usize>(
        self,
        x: &G,
        t: G::Scalar,
        duration: G::Scalar,
        steps: u32,
        f: impl Fn(G::Scalar, &G) -> Tangent<G::Scalar, D>,
    ) -> G {
        let h = duration * G::Scalar::lit(1.0 / f64::from(steps.max(1)));
        (0..steps).fold(*x, |x, i| self.step(&x, t + h * G::Scalar::lit(f64::from(i)), h, &f))
    }
}

fn crouch_grossman3<G: LieGroup<D>, const D: usize>(
    x: &G,
    k: impl Fn(f64, &G) -> Tangent<G::Scalar, D>,
) -> G {
    let along = |x: &G, k: &Tangent<G::Scalar, D>, a: f64| x.rplus(&(k * G::Scalar::lit(a)));
    let k1 = k(0.0, x);
    let k2 = k(3.0 / 4.0, &along(x, &k1, 3.0 / 4.0));
    let k3 = k(17.0 / 24.0, &along(&along(x, &k1, 119.0 / 216.0), &k2, 17.0 / 108.0));
    along(&along(&along(x, &k1, 13.0 / 51.0), &k2, -2.0 / 3.0), &k3, 24.0 / 17.0)
}

fn rkmk4<G: LieGroup<D>, const D: usize>(x: &G, k: impl Fn(f64, &G) -> Tangent<G::Scalar, D>) -> G {
    let lit = G::Scalar::lit;
    let k1 = k(0.0, x);
    let k2 = k(0.5, &x.rplus(&(k1 * lit(0.5))));
    let k3 = k(0.5, &x.rplus(&(k2 * lit(0.5) + G::bracket(&k1, &k2) * lit(0.125))));
    let k4 = k(1.0, &x.rplus(&k3));
    x.rplus(&((k1 + (k2 + k3) * lit(2.0) + k4 + G::bracket(&k1, &k4) * lit(0.5)) * lit(1.0 / 6.0)))
}

fn commutator_free4<G: LieGroup<D>, const D: usize>(
    x: &G,
    k: impl Fn(f64, &G) -> Tangent<G::Scalar, D>,
) -> G {
    let lit = G::Scalar::lit;
    let k1 = k(0.0, x);
    let middle = x.rplus(&(k1 * lit(0.5)));
    let k2 = k(0.5, &middle);
    let k3 = k(0.5, &x.rplus(&(k2 * lit(0.5))));
    let k4 = k(1.0, &middle.rplus(&(k3 - k1 * lit(0.5))));
    let (inner, twelfth) = ((k2 + k3) * lit(2.0), lit(1.0 / 12.0));
    x.rplus(&((k1 * lit(3.0) + inner - k4) * twelfth)).rplus(&((inner - k1 + k4 * lit(3.0)) * twelfth))
}
