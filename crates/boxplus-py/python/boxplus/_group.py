"""What all groups share: operations, derivatives and operators of elements."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, overload

import numpy as np
import numpy.typing as npt

from boxplus._elements import Elements

if TYPE_CHECKING:
    from typing_extensions import Self

    from boxplus import _core
    from boxplus._elements import Bools, Floats, Scalars


class Group(Elements):
    """A Lie group. An instance holds one element, or an array of elements of any shape.

    Wherever elements, tangents, points or numbers meet, their shapes broadcast as in NumPy, the last axes, which hold one
    tangent, point or matrix, excepted: ``poses[:, None] @ points`` moves every point by every pose.

    **Conventions.** Perturbations are local (right): ``X + tau`` is X·Exp(τ), ``Y - X`` is Log(X⁻¹Y). Tangents are ordered
    position (m), rotation (rad), then velocity (m/s), time (s) or log-scale. A method ending in ``_jac`` returns the value, then one
    Jacobian for each argument, in order, all right (local); ``_left_jac`` has the left (global) ones. An element maps its local frame
    into its parent: ``p_world = world_from_body @ p_body``.

    **In and out.** Any array-like of real numbers is taken, computed with in double precision, and never changed. ``np.asarray(X)``
    shows the stored numbers, ``(..., numbers)``, without a copy and read-only: elements never change. Wrong shapes raise
    `ShapeError`; a NaN or an infinity raises `NotFiniteError`, in an argument as in a result. Large batches run on all cores, without
    the interpreter's lock.
    """

    __slots__ = ()

    # NumPy's operators leave the work to those of this class.
    __array_ufunc__ = None
    __hash__ = None  # type: ignore[assignment]

    # Making elements

    @classmethod
    def identity(cls, shape: int | tuple[int, ...] = ()) -> Self:
        """The neutral element; with `shape`, an array of it."""
        shape = (shape,) if isinstance(shape, int) else shape
        return cls.exp(np.zeros((*shape, cls.dimension)))

    @classmethod
    def exp(cls, tau: npt.ArrayLike) -> Self:
        """Exp(τ), tangents ``(..., D)`` to elements ``(...)``."""
        return cls._of(cls._operations.exp(tau))

    @classmethod
    def exp_jac(cls, tau: npt.ArrayLike) -> tuple[Self, Floats]:
        """Exp(τ) and the right Jacobian J_r(τ), ``(..., D, D)``."""
        value, d_tau = cls._operations.exp_jac(tau)
        return cls._of(value), d_tau

    @classmethod
    def exp_left_jac(cls, tau: npt.ArrayLike) -> tuple[Self, Floats]:
        """Exp(τ) and the left Jacobian J_l(τ), ``(..., D, D)``."""
        value, d_tau = cls._operations.exp_left_jac(tau)
        return cls._of(value), d_tau

    # Comparing

    def __eq__(self, other: object) -> Bools:  # type: ignore[override]
        """Which elements are equal, ``(...)``: exactly, q and -q being one rotation."""
        if type(other) is not type(self):
            return NotImplemented
        return _bools(self._operations.equal(self._numbers, other._numbers))

    def __ne__(self, other: object) -> Bools:  # type: ignore[override]
        """Which elements are not equal, ``(...)``."""
        equal = self.__eq__(other)
        if equal is NotImplemented:
            return NotImplemented
        return np.logical_not(equal) if isinstance(equal, np.ndarray) else not equal

    def is_near(self, other: Self, tolerance: npt.ArrayLike) -> Bools:
        """Whether no coordinate of X ⊖ Y exceeds `tolerance`, metres and radians alike, ``(...)``."""
        return _bools(self._operations.is_near(self._numbers, self._same(other), tolerance))

    def weighted_distance(self, other: Self, weights: npt.ArrayLike) -> Scalars:
        """‖w ∘ (Y ⊖ X)‖ with weights per metre, per radian, …, ``(..., D)``."""
        return self._operations.weighted_distance(self._numbers, self._same(other), weights)

    # The group

    def compose(self, other: Self) -> Self:
        """X·Y, which ``X @ Y`` is, too."""
        return self._of(self._operations.compose(self._numbers, self._same(other)))

    def compose_jac(self, other: Self) -> tuple[Self, Floats, Floats]:
        """X·Y and its right Jacobians in X and Y, ``(..., D, D)``."""
        value, d_self, d_other = self._operations.compose_jac(self._numbers, self._same(other))
        return self._of(value), d_self, d_other

    def compose_left_jac(self, other: Self) -> tuple[Self, Floats, Floats]:
        """X·Y and its left Jacobians in X and Y, ``(..., D, D)``."""
        value, d_self, d_other = self._operations.compose_left_jac(self._numbers, self._same(other))
        return self._of(value), d_self, d_other

    def inverse(self) -> Self:
        """X⁻¹."""
        return self._of(self._operations.inverse(self._numbers))

    def inverse_jac(self) -> tuple[Self, Floats]:
        """X⁻¹ and its right Jacobian, ``(..., D, D)``."""
        value, d_self = self._operations.inverse_jac(self._numbers)
        return self._of(value), d_self

    def inverse_left_jac(self) -> tuple[Self, Floats]:
        """X⁻¹ and its left Jacobian, ``(..., D, D)``."""
        value, d_self = self._operations.inverse_left_jac(self._numbers)
        return self._of(value), d_self

    def between(self, other: Self) -> Self:
        """X⁻¹·Y: Y seen from X."""
        return self._of(self._operations.between(self._numbers, self._same(other)))

    def between_jac(self, other: Self) -> tuple[Self, Floats, Floats]:
        """X⁻¹·Y and its right Jacobians in X and Y, ``(..., D, D)``."""
        value, d_self, d_other = self._operations.between_jac(self._numbers, self._same(other))
        return self._of(value), d_self, d_other

    def between_left_jac(self, other: Self) -> tuple[Self, Floats, Floats]:
        """X⁻¹·Y and its left Jacobians in X and Y, ``(..., D, D)``."""
        value, d_self, d_other = self._operations.between_left_jac(self._numbers, self._same(other))
        return self._of(value), d_self, d_other

    def log(self) -> Floats:
        """Log(X), the shortest tangent, ``(..., D)``. At a half turn both signs are right; this one is deterministic."""
        return self._operations.log(self._numbers)

    def log_jac(self) -> tuple[Floats, Floats]:
        """Log(X) and its right Jacobian J_r⁻¹, ``(..., D, D)``."""
        return self._operations.log_jac(self._numbers)

    def log_left_jac(self) -> tuple[Floats, Floats]:
        """Log(X) and its left Jacobian J_l⁻¹, ``(..., D, D)``."""
        return self._operations.log_left_jac(self._numbers)

    # Steps

    def rplus(self, tau: npt.ArrayLike) -> Self:
        """X·Exp(τ), a step ``(..., D)`` in the local frame, which ``X + tau`` is, too."""
        return self._of(self._operations.rplus(self._numbers, tau))

    def rplus_jac(self, tau: npt.ArrayLike) -> tuple[Self, Floats, Floats]:
        """X·Exp(τ) and its right Jacobians in X and τ, ``(..., D, D)``."""
        value, d_self, d_tau = self._operations.rplus_jac(self._numbers, tau)
        return self._of(value), d_self, d_tau

    def rplus_left_jac(self, tau: npt.ArrayLike) -> tuple[Self, Floats, Floats]:
        """X·Exp(τ) and its left Jacobians in X and τ, ``(..., D, D)``."""
        value, d_self, d_tau = self._operations.rplus_left_jac(self._numbers, tau)
        return self._of(value), d_self, d_tau

    def rminus(self, base: Self) -> Floats:
        """Y ⊖ X = Log(X⁻¹Y), ``(..., D)``: the local step from X = `base` to Y = `self`, which ``Y - X`` is, too."""
        return self._operations.rminus(self._numbers, self._same(base))

    def rminus_jac(self, base: Self) -> tuple[Floats, Floats, Floats]:
        """Y ⊖ X and its right Jacobians in Y = `self` and X = `base`, ``(..., D, D)``."""
        return self._operations.rminus_jac(self._numbers, self._same(base))

    def rminus_left_jac(self, base: Self) -> tuple[Floats, Floats, Floats]:
        """Y ⊖ X and its left Jacobians in Y = `self` and X = `base`, ``(..., D, D)``."""
        return self._operations.rminus_left_jac(self._numbers, self._same(base))

    def lplus(self, tau: npt.ArrayLike) -> Self:
        """Exp(τ)·X, a step ``(..., D)`` in the global frame."""
        return self._of(self._operations.lplus(self._numbers, tau))

    def lplus_jac(self, tau: npt.ArrayLike) -> tuple[Self, Floats, Floats]:
        """Exp(τ)·X and its right Jacobians in X and τ, ``(..., D, D)``."""
        value, d_self, d_tau = self._operations.lplus_jac(self._numbers, tau)
        return self._of(value), d_self, d_tau

    def lplus_left_jac(self, tau: npt.ArrayLike) -> tuple[Self, Floats, Floats]:
        """Exp(τ)·X and its left Jacobians in X and τ, ``(..., D, D)``."""
        value, d_self, d_tau = self._operations.lplus_left_jac(self._numbers, tau)
        return self._of(value), d_self, d_tau

    def lminus(self, base: Self) -> Floats:
        """Log(YX⁻¹), ``(..., D)``: the global step from X = `base` to Y = `self`."""
        return self._operations.lminus(self._numbers, self._same(base))

    def lminus_jac(self, base: Self) -> tuple[Floats, Floats, Floats]:
        """Log(YX⁻¹) and its right Jacobians in Y = `self` and X = `base`, ``(..., D, D)``."""
        return self._operations.lminus_jac(self._numbers, self._same(base))

    def lminus_left_jac(self, base: Self) -> tuple[Floats, Floats, Floats]:
        """Log(YX⁻¹) and its left Jacobians in Y = `self` and X = `base`, ``(..., D, D)``."""
        return self._operations.lminus_left_jac(self._numbers, self._same(base))

    plus, plus_jac, minus, minus_jac = rplus, rplus_jac, rminus, rminus_jac

    def power(self, alpha: npt.ArrayLike) -> Self:
        """X^α = Exp(α·Log X), which ``X ** alpha`` is, too; `alpha` is ``(...)``."""
        return self._of(self._operations.power(self._numbers, alpha))

    def power_jac(self, alpha: npt.ArrayLike) -> tuple[Self, Floats, Floats]:
        """X^α and its right Jacobians in X, ``(..., D, D)``, and α, ``(..., D)``."""
        value, d_self, d_alpha = self._operations.power_jac(self._numbers, alpha)
        return self._of(value), d_self, d_alpha

    def power_left_jac(self, alpha: npt.ArrayLike) -> tuple[Self, Floats, Floats]:
        """X^α and its left Jacobians in X, ``(..., D, D)``, and α, ``(..., D)``."""
        value, d_self, d_alpha = self._operations.power_left_jac(self._numbers, alpha)
        return self._of(value), d_self, d_alpha

    def interpolate(self, other: Self, t: npt.ArrayLike) -> Self:
        """X·(X⁻¹Y)ᵗ, X at t = 0 and Y at t = 1, at constant velocity along the shortest way; `t` is ``(...)``."""
        return self._of(self._operations.interpolate(self._numbers, self._same(other), t))

    def interpolate_jac(self, other: Self, t: npt.ArrayLike) -> tuple[Self, Floats, Floats, Floats]:
        """`interpolate` and its right Jacobians in X and Y, ``(..., D, D)``, and t, ``(..., D)``, the velocity."""
        value, d_self, d_other, d_t = self._operations.interpolate_jac(self._numbers, self._same(other), t)
        return self._of(value), d_self, d_other, d_t

    def interpolate_left_jac(self, other: Self, t: npt.ArrayLike) -> tuple[Self, Floats, Floats, Floats]:
        """`interpolate` and its left Jacobians in X and Y, ``(..., D, D)``, and t, ``(..., D)``, the velocity."""
        value, d_self, d_other, d_t = self._operations.interpolate_left_jac(self._numbers, self._same(other), t)
        return self._of(value), d_self, d_other, d_t

    # Tangents

    def adjoint(self) -> Floats:
        """Ad_X, ``(..., D, D)``: X·Exp(τ) = Exp(Ad_X τ)·X."""
        return self._operations.adjoint(self._numbers)

    def adjoint_times(self, tau: npt.ArrayLike) -> Floats:
        """Ad_X·τ, ``(..., D)``: the local step τ, seen from the global frame."""
        return self._operations.adjoint_times(self._numbers, tau)

    @classmethod
    def small_adjoint(cls, tau: npt.ArrayLike) -> Floats:
        """ad_τ, ``(..., D, D)``: ad_τ υ = [τ, υ]."""
        return cls._operations.small_adjoint(tau)

    @classmethod
    def bracket(cls, a: npt.ArrayLike, b: npt.ArrayLike) -> Floats:
        """[a, b], ``(..., D)``."""
        return cls._operations.bracket(a, b)

    @classmethod
    def hat(cls, tau: npt.ArrayLike) -> Floats:
        """τ^, the tangent as a matrix of the algebra, ``(..., M, M)``; for vectors the tangent itself."""
        return cls._operations.hat(tau)

    @classmethod
    def vee(cls, algebra: npt.ArrayLike) -> Floats:
        """The tangent ``(..., D)`` of a matrix of the algebra, ``(..., M, M)``; the inverse of `hat`."""
        return cls._operations.vee(algebra)

    @classmethod
    def generators(cls) -> Floats:
        """The basis of the algebra, ``(D, M, M)``: τ^ = Σ τᵢEᵢ."""
        return cls._operations.hat(np.eye(cls.dimension))

    @classmethod
    def right_jacobian(cls, tau: npt.ArrayLike) -> Floats:
        """J_r(τ), ``(..., D, D)``: Exp(τ + δ) ≈ Exp(τ)·Exp(J_r δ)."""
        return cls._operations.right_jacobian(tau)

    @classmethod
    def right_jacobian_inverse(cls, tau: npt.ArrayLike) -> Floats:
        """J_r(τ)⁻¹, ``(..., D, D)``, unbounded towards a whole turn."""
        return cls._operations.right_jacobian_inverse(tau)

    @classmethod
    def left_jacobian(cls, tau: npt.ArrayLike) -> Floats:
        """J_l(τ), ``(..., D, D)``: Exp(τ + δ) ≈ Exp(J_l δ)·Exp(τ)."""
        return cls._operations.left_jacobian(tau)

    @classmethod
    def left_jacobian_inverse(cls, tau: npt.ArrayLike) -> Floats:
        """J_l(τ)⁻¹, ``(..., D, D)``, unbounded towards a whole turn."""
        return cls._operations.left_jacobian_inverse(tau)

    @classmethod
    def right_jacobian_derivative(cls, tau: npt.ArrayLike, delta: npt.ArrayLike) -> Floats:
        """d/dt J_r(τ + tδ) at t = 0, ``(..., D, D)``: the second derivative of Exp."""
        return cls._operations.right_jacobian_derivative(tau, delta)

    @classmethod
    def right_jacobian_inverse_derivative(cls, tau: npt.ArrayLike, delta: npt.ArrayLike) -> Floats:
        """d/dt J_r⁻¹(τ + tδ) at t = 0, ``(..., D, D)``: the second derivative of Log."""
        return cls._operations.right_jacobian_inverse_derivative(tau, delta)

    def covariance_to_left(self, right: npt.ArrayLike) -> Floats:
        """Ad_X Σ Ad_Xᵀ, ``(..., D, D)``: the covariance of the global tangent at X, of that of the local one."""
        return self._operations.covariance_to_left(self._numbers, right)

    def covariance_to_right(self, left: npt.ArrayLike) -> Floats:
        """The covariance of the local tangent at X, ``(..., D, D)``, of that of the global one."""
        return self._operations.covariance_to_right(self._numbers, left)

    # Points

    def act(self, p: npt.ArrayLike) -> Floats:
        """X·p, points ``(..., P)`` of the local frame seen in the parent frame, which ``X @ p`` is, too."""
        return self._operations.act(self._numbers, p)

    def act_jac(self, p: npt.ArrayLike) -> tuple[Floats, Floats, Floats]:
        """X·p, its right Jacobian in X, ``(..., P, D)``, and that in p, ``(..., P, P)``."""
        return self._operations.act_jac(self._numbers, p)

    def act_left_jac(self, p: npt.ArrayLike) -> tuple[Floats, Floats, Floats]:
        """X·p, its left Jacobian in X, ``(..., P, D)``, and that in p, ``(..., P, P)``."""
        return self._operations.act_left_jac(self._numbers, p)

    def act_inverse(self, p: npt.ArrayLike) -> Floats:
        """X⁻¹·p, points ``(..., P)`` of the parent frame seen in the local frame."""
        return self._operations.act_inverse(self._numbers, p)

    def act_inverse_jac(self, p: npt.ArrayLike) -> tuple[Floats, Floats, Floats]:
        """X⁻¹·p, its right Jacobian in X, ``(..., P, D)``, and that in p, ``(..., P, P)``."""
        return self._operations.act_inverse_jac(self._numbers, p)

    def act_inverse_left_jac(self, p: npt.ArrayLike) -> tuple[Floats, Floats, Floats]:
        """X⁻¹·p, its left Jacobian in X, ``(..., P, D)``, and that in p, ``(..., P, P)``."""
        return self._operations.act_inverse_left_jac(self._numbers, p)

    def act_direction(self, d: npt.ArrayLike) -> Floats:
        """A·d, directions, velocities or differences of points, ``(..., P)``, which no translation moves."""
        return self._operations.act_direction(self._numbers, d)

    def act_direction_jac(self, d: npt.ArrayLike) -> tuple[Floats, Floats, Floats]:
        """A·d, its right Jacobian in X, ``(..., P, D)``, and that in d, ``(..., P, P)``."""
        return self._operations.act_direction_jac(self._numbers, d)

    def act_direction_left_jac(self, d: npt.ArrayLike) -> tuple[Floats, Floats, Floats]:
        """A·d, its left Jacobian in X, ``(..., P, D)``, and that in d, ``(..., P, P)``."""
        return self._operations.act_direction_left_jac(self._numbers, d)

    def linear_part(self) -> Floats:
        """A, ``(..., P, P)``: the linear part of the action, ∂(X·p)/∂p."""
        return self._operations.linear_part(self._numbers)

    @classmethod
    def generators_at(cls, p: npt.ArrayLike) -> Floats:
        """∂(Exp(τ)·p)/∂τ at τ = 0, ``(..., P, D)``: the velocity of p for each basis tangent."""
        return cls._operations.generators_at(p)

    # Operators

    @overload
    def __matmul__(self, other: Self) -> Self: ...  # pyright: ignore[reportOverlappingOverload]
    @overload
    def __matmul__(self, other: npt.ArrayLike) -> Floats: ...
    def __matmul__(self, other: Self | npt.ArrayLike) -> Self | Floats:
        """X·Y of elements, X·p of points ``(..., P)``."""
        if isinstance(other, Group):
            return self._of(self._operations.compose(self._numbers, self._same(other)))
        return self._operations.act(self._numbers, other)

    def __add__(self, tau: npt.ArrayLike) -> Self:
        """X ⊞ τ, `rplus`."""
        return self._of(self._operations.rplus(self._numbers, tau))

    def __sub__(self, base: Self) -> Floats:
        """Y ⊟ X, `rminus`."""
        return self._operations.rminus(self._numbers, self._same(base))

    def __pow__(self, alpha: npt.ArrayLike) -> Self:
        """X^α, `power`."""
        return self._of(self._operations.power(self._numbers, alpha))


class MatrixGroup(Group):
    """A group whose elements are matrices, ``(M, M)``."""

    __slots__ = ()

    _matrices: ClassVar[_core.Matrices]

    @classmethod
    def from_matrix(cls, matrix: npt.ArrayLike) -> Self:
        """The elements of matrices ``(..., M, M)``, which may be rounded in print (by 1e-5); see `project`."""
        return cls._of(cls._matrices.from_matrix(matrix))

    @classmethod
    def project(cls, matrix: npt.ArrayLike) -> Self:
        """The elements nearest to any matrices ``(..., M, M)``, in the Frobenius norm of the rotation."""
        return cls._of(cls._matrices.project(matrix))

    def to_matrix(self) -> Floats:
        """The matrices, ``(..., M, M)``."""
        return self._matrices.to_matrix(self._numbers)

    def normalize(self) -> Self:
        """The same elements with rotations of unit norm to the last digit. Products already hold it to rounding."""
        return self._of(self._matrices.normalize(self._numbers))

    def log_near(self, reference: npt.ArrayLike) -> Floats:
        """The logarithm nearest to `reference`, ``(..., D)``, through any number of turns: Exp of it is X."""
        return self._matrices.log_near(self._numbers, reference)


def _bools(numbers: Scalars) -> Bools:
    return numbers.astype(np.bool_) if isinstance(numbers, np.ndarray) else bool(numbers)
