"""Groups of the plane: SO(2), SE(2), Sim(2)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from boxplus import _core
from boxplus._elements import joined, number
from boxplus._group import MatrixGroup

if TYPE_CHECKING:
    from typing_extensions import Self

    from boxplus._elements import Floats, Scalars


class SO2(MatrixGroup):
    """Rotations of the plane, stored as (cos θ, sin θ).

    A tangent is (θ,) in radians, counter-clockwise. ``SO2()`` is the identity.

    >>> import boxplus as bp
    >>> quarter = bp.SO2.from_angle(3.141592653589793 / 2)
    >>> quarter @ [1.0, 0.0]
    array([6.123234e-17, 1.000000e+00])
    """

    __slots__ = ()

    dimension, numbers, point_dimension = 1, 2, 2
    fields = (("cos_sin", 2),)
    _operations, _matrices = _core.SO2, _core.SO2_matrices

    def __init__(self) -> None:
        self._numbers = type(self).identity()._numbers

    @classmethod
    def from_angle(cls, angle: npt.ArrayLike) -> Self:
        """The rotations by `angle`, ``(...)``, in radians."""
        return cls.exp(np.asarray(angle)[..., None])

    @classmethod
    def from_cos_sin(cls, cos: npt.ArrayLike, sin: npt.ArrayLike) -> Self:
        """The rotations whose cosine and sine have the ratio of the arguments, ``(...)``, of any norm but 0."""
        return cls._of(_core.rotations.planar_from_cos_sin(cos, sin))

    @property
    def angle(self) -> Scalars:
        """θ, ``(...)``, in [-π, π] radians."""
        return number(self.log())

    @property
    def cos(self) -> Scalars:
        """cos θ, ``(...)``."""
        return number(self._numbers, 0)

    @property
    def sin(self) -> Scalars:
        """sin θ, ``(...)``."""
        return number(self._numbers, 1)

    def angle_to(self, other: SO2) -> Scalars:
        """The angle between two rotations, ``(...)``, in [0, π] radians."""
        return _core.rotations.planar_angle_to(self._numbers, self._same(other))

    def chordal_distance(self, other: SO2) -> Scalars:
        """‖R₁ - R₂‖ of Frobenius, ``(...)``."""
        return _core.rotations.planar_chordal_distance(self._numbers, self._same(other))


class _Placed(MatrixGroup):
    """Elements stored as a translation, a rotation, and whatever follows."""

    __slots__ = ()

    @property
    def translation(self) -> Floats:
        """t, ``(..., 2)``, in metres of the parent frame."""
        return self._numbers[..., 0:2]

    @property
    def rotation(self) -> SO2:
        """R, ``(...)``."""
        return SO2._of(self._numbers[..., 2:4])


class SE2(_Placed):
    """Poses of the plane, stored as (t₁, t₂, cos θ, sin θ).

    A tangent is (ρ₁, ρ₂, θ): metres, metres, radians.

    >>> import boxplus as bp
    >>> bp.SE2([1.0, 2.0], 0.0) @ [0.5, 0.0]
    array([1.5, 2. ])
    """

    __slots__ = ()

    dimension, numbers, point_dimension = 3, 4, 2
    fields = (("translation", 2), ("cos_sin", 2))
    _operations, _matrices = _core.SE2, _core.SE2_matrices

    def __init__(self, translation: npt.ArrayLike = (0.0, 0.0), angle: npt.ArrayLike | SO2 = 0.0) -> None:
        """The motions p ↦ R·p + t of translations ``(..., 2)`` in m and angles ``(...)`` in rad, or rotations."""
        rotation = angle if isinstance(angle, SO2) else SO2.from_angle(angle)
        parts = joined((translation, 2), (rotation, 2), names=("translation", "angle"))
        self._numbers = type(self).from_array(parts)._numbers

    @property
    def angle(self) -> Scalars:
        """The heading, ``(...)``, in [-π, π] radians."""
        return self.rotation.angle


class Sim2(_Placed):
    """Similarities of the plane, p ↦ s·R·p + t, stored as (t₁, t₂, cos θ, sin θ, σ) with s = e^σ.

    A tangent is (ρ₁, ρ₂, θ, σ): metres, metres, radians, and the rate of ln s.
    """

    __slots__ = ()

    dimension, numbers, point_dimension = 4, 5, 2
    fields = (("translation", 2), ("cos_sin", 2), ("log_scale", 1))
    _operations, _matrices = _core.Sim2, _core.Sim2_matrices

    def __init__(
        self,
        rotation: SO2 | None = None,
        translation: npt.ArrayLike = (0.0, 0.0),
        log_scale: npt.ArrayLike = 0.0,
    ) -> None:
        """The similarities of rotations ``(...)``, translations ``(..., 2)`` in m and log-scales ``(...)``."""
        parts = joined(
            (translation, 2),
            (SO2() if rotation is None else rotation, 2),
            (log_scale, None),
            names=("translation", "rotation", "log_scale"),
        )
        self._numbers = type(self).from_array(parts)._numbers

    @property
    def log_scale(self) -> Scalars:
        """σ = ln s, ``(...)``."""
        return number(self._numbers, 4)

    @property
    def scale(self) -> Scalars:
        """s = e^σ, ``(...)``: lengths in the parent frame over lengths in the local one."""
        return number(np.exp(self._numbers[..., 4:5]))
