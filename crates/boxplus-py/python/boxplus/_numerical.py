"""Derivatives of functions that a user writes, by differences."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from boxplus._elements import Elements
from boxplus._group import Group

if TYPE_CHECKING:
    from collections.abc import Callable

    from boxplus._elements import Floats

STEP = 1e-5  # h²/6 and ε/h, the errors of a central difference, are both near 2e-11.


def numerical_jacobians(function: Callable[..., Any], *arguments: Group | npt.ArrayLike) -> list[Floats]:
    """The right (local) Jacobians of a function by each argument, ``(..., M, D)``, by central differences: to some ten digits.

    `function` takes batches ``(...)`` of elements, or vectors ``(..., D)``, and returns elements or vectors ``(..., M)`` likewise.

    >>> import boxplus as bp
    >>> pose, point = bp.SE2([1.0, 2.0], 0.5), [3.0, 4.0]
    >>> d_pose, d_point = bp.numerical_jacobians(bp.SE2.act, pose, point)
    >>> bool(abs(d_pose - pose.act_jac(point)[1]).max() < 1e-9)
    True
    """
    given = [x if isinstance(x, Elements) else np.asarray(x, dtype=np.float64) for x in arguments]
    return [_by(function, given, place) for place in range(len(given))]


def _by(function: Callable[..., Any], arguments: list[Any], place: int) -> Floats:
    x = arguments[place]
    dimension = x.dimension if isinstance(x, Group) else x.shape[-1]

    def moved(tangent: Floats) -> Any:
        return function(*arguments[:place], x + tangent, *arguments[place + 1 :])

    return np.stack([(moved(h) - moved(-h)) / (2.0 * STEP) for h in STEP * np.eye(dimension)], -1)
