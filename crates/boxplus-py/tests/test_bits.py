"""Results equal those of the Rust library, bit for bit."""

from __future__ import annotations

import os
import subprocess
from typing import cast

import numpy as np
import numpy.typing as npt
import pytest
from numpy.testing import assert_array_equal

import boxplus as bp

BITS = os.environ.get("BOXPLUS_BITS", "")
"""The built example `bits` of the crate."""


def rows(text: str) -> list[npt.NDArray[np.float64]]:
    return [np.array([int(x, 16) for x in row.split(",")], dtype=np.uint64).view(np.float64) for row in text.split()]


@pytest.mark.skipif(not BITS, reason="BOXPLUS_BITS does not say where the example `bits` is; scripts/python does")
def test_results_are_those_of_the_library_bit_for_bit() -> None:
    printed = subprocess.run([BITS], check=True, capture_output=True, text=True).stdout
    lines = printed.splitlines()
    assert len(lines) == 8 * 32 * 9
    for line in lines:
        called, results = line.split(">")
        name, operation, numbers = called.split(" ", 2)
        group: type[bp.Group] = getattr(bp, name)
        given = rows(numbers)
        if operation in ("exp", "right_jacobian_inverse"):
            value = getattr(group, operation)(given[0])
        else:
            x, *others = given
            arguments: list[object] = list(others)
            if operation in ("compose", "between", "rminus_jac", "interpolate"):
                arguments[0] = group.from_array(others[0])
            value = getattr(group.from_array(x), operation)(*arguments)
        values = cast("tuple[npt.ArrayLike, ...]", value if isinstance(value, tuple) else (value,))
        for ours, exact in zip(values, rows(results), strict=True):
            assert_array_equal(np.asarray(ours).ravel().view(np.uint64), exact.view(np.uint64), err_msg=line)
