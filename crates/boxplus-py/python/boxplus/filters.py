"""The Kalman filter of errors on any group: extended, and, by the side of the belief, left- or right-invariant.

A filter has no state: beliefs, `Gaussian` of any shape, go in and come out, many vehicles at a time as easily as one. What is known of a
vehicle is a *motion*, what a sensor says is a *measurement*: those here, or a function of your own.

>>> import boxplus as bp
>>> from boxplus import filters
>>> belief = bp.Gaussian.from_sigmas(bp.SE2(), [0.1, 0.1, 0.05])
>>> belief = filters.predict(belief, filters.Odometry([1.0, 0.0, 0.2], noise=[[4e-4, 0, 0], [0, 1e-4, 0], [0, 0, 1e-4]]))
>>> beacon = filters.Sighting(landmark=[4.0, 1.0], measured=[3.0, 0.3], noise=[[9e-4, 0], [0, 9e-4]])
>>> update = filters.update(belief, beacon, gate=0.999)
>>> update.accepted, bool(update.belief.sigmas[0] < belief.sigmas[0])
(True, True)
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar, cast

import numpy as np
import numpy.typing as npt

from boxplus import _core
from boxplus._gaussian import Gaussian
from boxplus._group import Group
from boxplus._numerical import numerical_jacobians

if TYPE_CHECKING:
    from collections.abc import Callable

    from boxplus._elements import Bools, Floats, Scalars

__all__ = [
    "Innovation",
    "Measurement",
    "Motion",
    "Odometry",
    "PositionFix",
    "Range",
    "Sighting",
    "Step",
    "Update",
    "VectorSighting",
    "predict",
    "update",
]

G = TypeVar("G", bound=Group)


class Motion(Protocol):
    """What `predict` takes: how a state moves during one step."""

    def _predicted(self, belief: Gaussian[Any], table: _core.Predictions) -> tuple[Floats, Floats]: ...


class Measurement(Protocol):
    """What `update` takes: what a sensor says of a state."""

    @property
    def noise(self) -> npt.ArrayLike:
        """Covariance of the sensor, ``(..., M, M)``."""
        ...

    def _innovation(self, x: Any, sensors: _core.Sensors) -> tuple[npt.ArrayLike, npt.ArrayLike]: ...


@dataclass(frozen=True)
class Update(Generic[G]):
    """What became of measurements."""

    belief: Gaussian[G]
    """The beliefs, ``(...)``: corrected where the measurement was accepted, else as they were."""
    innovation: Floats
    """z, measured minus predicted, ``(..., M)``."""
    covariance: Floats
    """S = HPHᵀ + N, ``(..., M, M)``."""
    nis: Scalars
    """zᵀS⁻¹z, ``(...)``: of a consistent filter, χ² with M degrees of freedom."""
    accepted: Bools
    """Which measurements the gate admitted, ``(...)``."""


def predict(belief: Gaussian[G], motion: Motion) -> Gaussian[G]:
    """The beliefs after one step: P ← FPFᵀ + Q on their side, exactly symmetric and semi-definite."""
    table, _ = _tables(belief)
    return belief._like(motion._predicted(belief, table))


def update(belief: Gaussian[G], measurement: Measurement, gate: float = 1.0) -> Update[G]:
    """The beliefs after a measurement (Joseph's form, with reset), or as they were where the `gate` does not admit it.

    A gate of 0.99 refuses innovations beyond the 99 % quantile of χ²; 1 admits all. Raises `FilterError` for an innovation that is
    certain in some direction though the state is, too.
    """
    _, updates = _tables(belief)
    sensors = cast("_core.Sensors", getattr(_core, f"{type(belief.mean).__name__}_sensors"))
    z, jacobian = measurement._innovation(belief.mean, sensors)
    z = np.asarray(z, dtype=np.float64)
    size = z.shape[-1] if z.ndim else 0
    if not 1 <= size <= len(updates):
        raise _core.ShapeError(f"an innovation has 1 to {len(updates)} numbers, (..., M); this one has the shape {z.shape}")
    mean, covariance, s, nis, accepted = updates[size - 1].update(*belief._both, z, jacobian, measurement.noise, gate)
    after = belief._like((mean, covariance))
    return Update(after, z, s, nis, accepted != 0.0)


@dataclass(frozen=True)
class Odometry:
    """X⁺ = X·Exp(u + w): a step in the frame of the body, on any group. Solà et al. (2018) (87)."""

    step: npt.ArrayLike
    """u, ``(..., D)``: metres and radians of this step."""
    noise: npt.ArrayLike
    """Covariance of w, ``(..., D, D)``."""

    def _predicted(self, belief: Gaussian[Any], table: _core.Predictions) -> tuple[Floats, Floats]:
        return table.odometry(*belief._both, self.step, self.noise)


@dataclass(frozen=True)
class Step:
    """A motion of your own: ``function(x)`` is the state after the step.

    With `jacobians` the function returns ``(next, F)``, F the right (local) Jacobian, ``(..., D, D)``; else F is found by central differences,
    to some ten digits, and a warning says so.
    """

    function: Callable[..., Any]
    """From states ``(...)`` to states ``(...)``."""
    noise: npt.ArrayLike
    """Covariance of the local error that the step adds, ``(..., D, D)``."""
    jacobians: bool = False
    """Whether the function returns F, too."""

    def _predicted(self, belief: Gaussian[Any], table: _core.Predictions) -> tuple[Floats, Floats]:
        mean = belief.mean
        following, transition = _with_jacobian(self.function, mean, self.jacobians)
        return table.computed(*belief._both, mean._same(following), transition, self.noise)


@dataclass(frozen=True)
class Innovation:
    """A measurement of your own: ``function(x)`` is z, what was measured minus what the state x predicts, angles wrapped, ``(..., M)``, M ≤ 6.

    With `jacobians` the function returns ``(z, H)``, where H has the sign of the *prediction*, z(x ⊞ τ) ≈ z(x) - H·τ, ``(..., M, D)``; else H
    is found by central differences, to some ten digits, and a warning says so.
    """

    function: Callable[..., Any]
    """From states ``(...)`` to innovations ``(..., M)``."""
    noise: npt.ArrayLike
    """Covariance of the sensor, ``(..., M, M)``."""
    jacobians: bool = False
    """Whether the function returns H, too."""

    def _innovation(self, x: Any, sensors: _core.Sensors) -> tuple[npt.ArrayLike, npt.ArrayLike]:
        z, derivative = _with_jacobian(self.function, x, self.jacobians)
        return z, derivative if self.jacobians else -np.asarray(derivative)


@dataclass(frozen=True)
class Sighting:
    """A landmark at a known place, measured in the frame of the body: y = X⁻¹·l + n."""

    landmark: npt.ArrayLike
    """l, ``(..., P)``, in metres of the world."""
    measured: npt.ArrayLike
    """y, ``(..., P)``, in metres of the body."""
    noise: npt.ArrayLike
    """Covariance of y, ``(..., P, P)``."""

    def _innovation(self, x: Any, sensors: _core.Sensors) -> tuple[npt.ArrayLike, npt.ArrayLike]:
        return sensors.sighting(x._numbers, self.landmark, self.measured)


@dataclass(frozen=True)
class PositionFix:
    """The place of a point of the body, measured in the world: y = X·a + n; GNSS, motion capture."""

    measured: npt.ArrayLike
    """y, ``(..., P)``, in metres of the world."""
    noise: npt.ArrayLike
    """Covariance of y, ``(..., P, P)``."""
    antenna: npt.ArrayLike | None = None
    """a, ``(..., P)``, the lever arm in metres of the body; by default its origin."""

    def _innovation(self, x: Any, sensors: _core.Sensors) -> tuple[npt.ArrayLike, npt.ArrayLike]:
        return sensors.position_fix(x._numbers, _or_origin(x, self.antenna), self.measured)


@dataclass(frozen=True)
class VectorSighting:
    """A direction or field known in the world, measured in the body: y = R⁻¹·d + n; magnetometer, accelerometer at rest."""

    reference: npt.ArrayLike
    """d, ``(..., P)``, in the world."""
    measured: npt.ArrayLike
    """y, ``(..., P)``, in the body, in the units of d."""
    noise: npt.ArrayLike
    """Covariance of y, ``(..., P, P)``."""

    def _innovation(self, x: Any, sensors: _core.Sensors) -> tuple[npt.ArrayLike, npt.ArrayLike]:
        return sensors.vector_sighting(x._numbers, self.reference, self.measured)


@dataclass(frozen=True)
class Range:
    """The distance between a point of the body and a beacon: y = |X·a - l| + n; ultra-wide band, sonar."""

    beacon: npt.ArrayLike
    """l, ``(..., P)``, in metres of the world."""
    measured: npt.ArrayLike
    """y, ``(...)``, in metres."""
    noise: npt.ArrayLike
    """Variance of y, ``(..., 1, 1)``."""
    antenna: npt.ArrayLike | None = None
    """a, ``(..., P)``, in metres of the body; by default its origin."""

    def _innovation(self, x: Any, sensors: _core.Sensors) -> tuple[npt.ArrayLike, npt.ArrayLike]:
        return sensors.range(x._numbers, self.beacon, _or_origin(x, self.antenna), self.measured)


def _tables(belief: Gaussian[Any]) -> tuple[_core.Predictions, tuple[_core.Updates, ...]]:
    name = f"{type(belief.mean).__name__}_{belief.side}_filter"
    return cast("tuple[_core.Predictions, tuple[_core.Updates, ...]]", getattr(_core, name))


def _or_origin(x: Group, point: npt.ArrayLike | None) -> npt.ArrayLike:
    return np.zeros(x.point_dimension) if point is None else point


def _with_jacobian(function: Callable[..., Any], x: Group, given: bool) -> tuple[Any, Any]:
    if given:
        value, jacobian = function(x)
        return value, jacobian
    warnings.warn("a Jacobian is found by central differences; give it with jacobians=True", stacklevel=4)
    return function(x), numerical_jacobians(function, x)[0]
