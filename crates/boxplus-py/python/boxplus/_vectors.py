"""Vectors under addition: R1 to R6."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy.typing as npt

from boxplus import _core
from boxplus._group import Group

if TYPE_CHECKING:
    from boxplus._elements import Floats


class Rn(Group):
    """Vectors under addition, the flat case in which every Jacobian is ±I: biases, landmarks, velocities.

    The classes `R1` to `R6` are those of one dimension. They act on points as translations.

    >>> import boxplus as bp
    >>> bp.R2([1.0, 2.0]) + [0.5, 0.0]
    R2([1.5, 2])
    """

    __slots__ = ()

    def __init__(self, vector: npt.ArrayLike) -> None:
        """The vectors ``(..., D)``."""
        self._numbers = type(self).from_array(vector)._numbers

    @property
    def vector(self) -> Floats:
        """The coordinates, ``(..., D)``."""
        return self._numbers


class R1(Rn):
    """Numbers."""

    __slots__ = ()
    dimension = numbers = point_dimension = 1
    fields = (("", 1),)
    _operations = _core.R1


class R2(Rn):
    """Vectors of 2 numbers."""

    __slots__ = ()
    dimension = numbers = point_dimension = 2
    fields = (("", 2),)
    _operations = _core.R2


class R3(Rn):
    """Vectors of 3 numbers."""

    __slots__ = ()
    dimension = numbers = point_dimension = 3
    fields = (("", 3),)
    _operations = _core.R3


class R4(Rn):
    """Vectors of 4 numbers."""

    __slots__ = ()
    dimension = numbers = point_dimension = 4
    fields = (("", 4),)
    _operations = _core.R4


class R5(Rn):
    """Vectors of 5 numbers."""

    __slots__ = ()
    dimension = numbers = point_dimension = 5
    fields = (("", 5),)
    _operations = _core.R5


class R6(Rn):
    """Vectors of 6 numbers."""

    __slots__ = ()
    dimension = numbers = point_dimension = 6
    fields = (("", 6),)
    _operations = _core.R6
