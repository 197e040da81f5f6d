"""Uncertain elements: a mean on the group, a covariance in its tangent, and the side that it is on."""

from __future__ import annotations

from typing import TYPE_CHECKING, Generic, Literal, TypeAlias, TypeVar, cast

import numpy as np
import numpy.typing as npt

from boxplus import _core
from boxplus._group import Group
from boxplus._vectors import R1, R2, R3, R4, Rn

if TYPE_CHECKING:
    from boxplus._elements import Floats, Scalars

G = TypeVar("G", bound=Group)
H = TypeVar("H", bound=Group)
Side: TypeAlias = Literal["local", "global"]
"""Where an error stands: X = X̄·Exp(ξ) is local (right), X = Exp(ξ)·X̄ global (left)."""
Order: TypeAlias = Literal[1, 2, 4]
"""Up to which power of the standard deviations the moments of a result are kept: 1 is JΣJᵀ with the mean of the means, 2 adds the shift of
the mean, 4 the next terms of both."""

_POINTS: dict[int, type[Rn]] = {1: R1, 2: R2, 3: R3, 4: R4}


class Gaussian(Generic[G]):
    """Concentrated Gaussians, ``(...)``: means ``(...)`` on a group and covariances ``(..., D, D)``, which broadcast.

    A covariance has the units of the tangent, squared, position before rotation, on the given side. It is checked once: what is not
    symmetric and positive semi-definite raises `UncertaintyError`, which names the direction.

    >>> import boxplus as bp
    >>> step = bp.Gaussian.from_sigmas(bp.SE2([1.0, 0.0], 0.1), [0.05, 0.01, 0.02])
    >>> (step @ step).sigmas.round(4)
    array([0.0706, 0.0249, 0.0283])
    """

    __slots__ = ("_covariance", "_mean", "_side")
    __array_ufunc__ = None

    def __init__(self, mean: G, covariance: npt.ArrayLike, side: Side = "local") -> None:
        """The Gaussians about means ``(...)`` with covariances ``(..., D, D)`` on the given side."""
        table = _table(type(mean), side)
        self._take(mean, table.checked(covariance), side)

    @classmethod
    def from_sigmas(cls, mean: H, sigmas: npt.ArrayLike, side: Side = "local") -> Gaussian[H]:
        """Independent coordinates with standard deviations ``(..., D)``, of which some may be 0."""
        return Gaussian[H]._of(mean, _table(type(mean), side).from_sigmas(sigmas), side)

    @classmethod
    def from_information(cls, mean: H, information: npt.ArrayLike, side: Side = "local") -> Gaussian[H]:
        """Inverse covariances ``(..., D, D)``; `UncertaintyError` where they are singular."""
        return Gaussian[H]._of(mean, _table(type(mean), side).from_information(information), side)

    @classmethod
    def _of(cls, mean: H, covariance: Floats, side: Side) -> Gaussian[H]:
        gaussian: Gaussian[H] = object.__new__(Gaussian)  # pyright: ignore[reportUnknownVariableType]
        gaussian._take(mean, covariance, side)
        return gaussian

    def _take(self, mean: G, covariance: Floats, side: Side) -> None:
        try:
            batch = np.broadcast_shapes(mean.shape, covariance.shape[:-2])
        except ValueError:
            told = f"mean {mean.shape}, covariance {covariance.shape[:-2]}"
            raise _core.ShapeError(f"batches do not broadcast: {told}") from None
        self._mean = mean if mean.shape == batch else mean.broadcast_to(batch)
        covariance = covariance if covariance.shape[:-2] == batch else np.broadcast_to(covariance, (*batch, *covariance.shape[-2:]))
        covariance.flags.writeable = False
        self._covariance = covariance
        self._side: Side = side

    def _like(self, parts: tuple[Floats, Floats]) -> Gaussian[G]:
        return self._of(self._mean._of(parts[0]), parts[1], self._side)

    @property
    def _operations(self) -> _core.Gaussians:
        return _table(type(self._mean), self._side)

    @property
    def _both(self) -> tuple[Floats, Floats]:
        return self._mean._numbers, self._covariance

    def _other(self, other: Gaussian[G]) -> tuple[Floats, Floats]:
        if other._side != self._side:
            raise ValueError(f"one Gaussian is {self._side}, the other {other._side}; convert one with to_{self._side}()")
        return self._mean._same(other._mean), other._covariance

    @property
    def mean(self) -> G:
        """The means, ``(...)``."""
        return self._mean

    @property
    def covariance(self) -> Floats:
        """The covariances, ``(..., D, D)``, read-only."""
        return self._covariance

    @property
    def side(self) -> Side:
        """Which side the covariance is on."""
        return self._side

    @property
    def sigmas(self) -> Floats:
        """The standard deviation of each coordinate, ``(..., D)``."""
        return self._operations.sigmas(self._covariance)

    @property
    def information(self) -> Floats:
        """Σ⁻¹, ``(..., D, D)``; `UncertaintyError` names a direction without uncertainty."""
        return self._operations.information(self._covariance)

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the array of Gaussians, ``()`` for a single one."""
        return self._mean.shape

    def __len__(self) -> int:
        return len(self._mean)

    def __getitem__(self, index: int | slice | npt.NDArray[np.bool_] | npt.NDArray[np.intp]) -> Gaussian[G]:
        if not self.shape:
            raise TypeError("a single Gaussian cannot be indexed")
        return self._of(self._mean[index], self._covariance[index], self._side)

    def __repr__(self) -> str:
        name = type(self._mean).__name__
        if self.shape:
            return f"Gaussian({name} of shape {self.shape}, {self._side})"
        sigmas = ", ".join(f"{x:.3g}" for x in self.sigmas)
        return f"Gaussian({self._mean!r}, sigmas=[{sigmas}], {self._side})"

    # Other descriptions of the same

    def principal_axes(self) -> tuple[Floats, Floats]:
        """Standard deviations along the principal axes, ``(..., D)``, and the axes as columns, ``(..., D, D)``."""
        return self._operations.principal_axes(self._covariance)

    def to_local(self) -> Gaussian[G]:
        """The same Gaussians with local (right) covariances, exactly."""
        return self if self._side == "local" else self._opposite("local")

    def to_global(self) -> Gaussian[G]:
        """The same Gaussians with global (left) covariances, exactly."""
        return self if self._side == "global" else self._opposite("global")

    def _opposite(self, side: Side) -> Gaussian[G]:
        mean, covariance = self._operations.to_opposite(*self._both)
        return self._of(self._mean._of(mean), covariance, side)

    # Propagation

    def inverse(self) -> Gaussian[G]:
        """The inverses, exactly in the covariance."""
        return self._like(self._operations.inverse(*self._both))

    def compose(self, other: Gaussian[G], order: Order = 2) -> Gaussian[G]:
        """X·Y of independent X and Y, which ``X @ Y`` is, too."""
        return self._like(self._operations.compose(*self._both, *self._other(other), _power(order)))

    def between(self, other: Gaussian[G], order: Order = 2) -> Gaussian[G]:
        """X⁻¹·Y of independent X and Y."""
        return self._like(self._operations.between(*self._both, *self._other(other), _power(order)))

    def __matmul__(self, other: Gaussian[G]) -> Gaussian[G]:
        """X·Y of independent X and Y, to second order."""
        return self.compose(other)

    def change_parent(self, new_from_old: G) -> Gaussian[G]:
        """The same thing seen from another parent frame, known exactly."""
        return self._like(self._operations.change_parent(*self._both, self._mean._same(new_from_old)))

    def change_body(self, body_from_sensor: G) -> Gaussian[G]:
        """The frame of another part of the same rigid body, known exactly."""
        return self._like(self._operations.change_body(*self._both, self._mean._same(body_from_sensor)))

    def reset(self, theta: npt.ArrayLike) -> Gaussian[G]:
        """Errors of mean θ, ``(..., D)``, told about the mean moved by θ: what follows the correction of a filter."""
        return self._like(self._operations.reset(*self._both, theta))

    def transport(self, theta: npt.ArrayLike) -> Gaussian[G]:
        """Parallel transport of the covariance to the mean moved by θ, ``(..., D)``: where the axes of an ellipsoid go."""
        return self._like(self._operations.transport(*self._both, theta))

    def act(self, p: npt.ArrayLike, covariance: npt.ArrayLike | None = None, order: Order = 2) -> Gaussian[Rn]:
        """X·p for points ``(..., P)``, with covariances ``(..., P, P)`` of their own where they are uncertain, independently of X."""
        dimension = self._mean.point_dimension
        own = np.zeros((dimension, dimension)) if covariance is None else covariance
        mean, moved = self._operations.act_on(*self._both, p, own, _power(order))
        return Gaussian[Rn]._of(_POINTS[dimension](mean), moved, "local")

    # Together

    def fuse(self, other: Gaussian[G]) -> Gaussian[G]:
        """The most likely elements, given two independent estimates of each."""
        return self._like(self._operations.fuse(*self._both, *self._other(other)))

    def kl_divergence(self, other: Gaussian[G]) -> Scalars:
        """KL(self ‖ other), ``(...)``, in nats: what is lost where `other` stands in for these."""
        return self._operations.kl_divergence(*self._both, *self._other(other))

    # Elements

    def error_of(self, x: G) -> Floats:
        """The errors ξ of elements about the means, ``(..., D)``."""
        return self._operations.error_of(*self._both, self._mean._same(x))

    def perturbed(self, xi: npt.ArrayLike) -> G:
        """The elements at errors ξ, ``(..., D)``, from the means."""
        return self._mean._of(self._operations.perturbed(*self._both, xi))

    def sample(self, rng: np.random.Generator, shape: int | tuple[int, ...] = ()) -> G:
        """Draws of each Gaussian, ``(*shape, ...)``, by a generator of NumPy."""
        shape = (shape,) if isinstance(shape, int) else shape
        normal = rng.standard_normal((*shape, *self.shape, self._mean.dimension))
        return self._mean._of(self._operations.drawn(*self._both, normal))

    def mahalanobis_squared(self, x: G) -> Scalars:
        """ξᵀΣ⁻¹ξ of the errors of elements, ``(...)``."""
        return self._operations.mahalanobis_squared(*self._both, self._mean._same(x))

    def tangent_log_density(self, x: G) -> Scalars:
        """ln of the density of the errors of elements in the tangent, ``(...)``."""
        return self._operations.tangent_log_density(*self._both, self._mean._same(x))

    def haar_log_density(self, x: G) -> Scalars:
        """ln of the density of elements by the group's own (Haar) volume, ``(...)``."""
        return self._operations.haar_log_density(*self._both, self._mean._same(x))

    def tangent_entropy(self) -> Scalars:
        """The entropy of the errors in the tangent, ``(...)``, in nats."""
        return self._operations.tangent_entropy(*self._both)

    def boundary(self, direction: npt.ArrayLike, probability: float) -> G:
        """The elements where the region of a `probability` ends in directions ``(..., D)`` of the whitened tangent: bananas."""
        return self._mean._of(self._operations.boundary(*self._both, direction, probability))


def _table(group: type[Group], side: str) -> _core.Gaussians:
    if side not in ("local", "global"):
        raise ValueError(f"side is local or global, not {side!r}")
    table = cast("_core.Gaussians | None", getattr(_core, f"{group.__name__}_{side}", None))
    if table is None:
        raise TypeError(f"no Gaussians on {group.__name__}")
    return table


def _power(order: int) -> float:
    if order not in (1, 2, 4):
        raise ValueError(f"order is 1, 2 or 4, not {order!r}")
    return float(order)
