//! Homomorphisms, such as the embedding of a subgroup.

use super::sample::{Sample, close, judge, largest, rounding, same};
use super::{RADIUS, Verdict, each_sample};
use crate::lie::{LieGroup, Real};
use nalgebra::SMatrix;

/// That h ↦ `element`(h) from H into G is a homomorphism with the derivative `tangent`, G-coordinates by H-coordinates: every
/// operation before it is the operation after it. For subgroups and for other parametrisations of the same group.
///
/// ```
/// use boxplus::lie::{SE3, SO3, laws};
/// use nalgebra::{SMatrix, Vector3};
/// let mut rotation = SMatrix::<f64, 6, 3>::zeros();
/// rotation.fixed_view_mut::<3, 3>(3, 0).fill_with_identity();
/// laws::check_embedding::<SO3, SE3, 3, 6>(|r| SE3::new(*r, Vector3::zeros()), &rotation)?;
/// # Ok::<(), laws::Violation>(())
/// ```
///
/// # Errors
/// The first operation that does not commute with it.
pub fn check_embedding<H, G, const C: usize, const D: usize>(
    element: impl Fn(&H) -> G,
    tangent: &SMatrix<G::Scalar, D, C>,
) -> Verdict
where
    H: LieGroup<C>,
    G: LieGroup<D, Scalar = H::Scalar>,
{
    each_sample(|sample| {
        let s = Sample::<H, C>::new(sample, RADIUS);
        let (x, y, t) = (element(&s.x), element(&s.y), H::Scalar::lit(0.3));
        let bound = 4.0 * rounding::<G::Scalar>() * s.scale * (1.0 + largest(&x.adjoint()));
        let (a, b) = (tangent * s.a, tangent * s.b);
        same("identity", &element(&H::identity()), &G::identity(), 0.0)?;
        same("exp", &element(&H::exp(&s.a)), &G::exp(&a), bound)?;
        close("log", &(tangent * s.x.log()), &x.log(), bound)?;
        same("compose", &element(&s.x.compose(&s.y)), &x.compose(&y), bound)?;
        same("inverse", &element(&s.x.inverse()), &x.inverse(), bound)?;
        same("between", &element(&s.x.between(&s.y)), &x.between(&y), bound)?;
        same("interpolate", &element(&s.x.interpolate(&s.y, t)), &x.interpolate(&y, t), bound)?;
        close("bracket", &(tangent * H::bracket(&s.a, &s.b)), &G::bracket(&a, &b), bound)?;
        let wide = bound * (1.0 + largest(&H::right_jacobian_inverse(&s.a))) * (1.0 + largest(&s.a));
        let pairs = [
            ("Ad", s.x.adjoint(), x.adjoint()),
            ("J_r", H::right_jacobian(&s.a), G::right_jacobian(&a)),
            ("J_l", H::left_jacobian(&s.a), G::left_jacobian(&a)),
            ("J_r⁻¹", H::right_jacobian_inverse(&s.a), G::right_jacobian_inverse(&a)),
            ("DJ_r", H::right_jacobian_derivative(&s.a, &s.b), G::right_jacobian_derivative(&a, &b)),
        ];
        pairs.into_iter().try_for_each(|(law, before, after)| {
            judge(law, largest(&(tangent * before - after * tangent)), wide)
        })
    })
}
